//! Writes a scene as PNG.
//!
//! Text is drawn from the outlines of the embedded font: the result does not depend on the fonts that are
//! installed, and the same scene gives the same bytes.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

use crate::error::PlotError;
use crate::font::{Font, runs};
use crate::palette::Colour;
use crate::scene::{Anchor, Item, Path, Pen, Scene, Text};

const LARGEST_SIDE: f64 = 16_384.0;

/// The PNG file, `scale` image pixels per px.
pub(crate) fn png(scene: &Scene, scale: f64) -> Result<Vec<u8>, PlotError> {
    let (width, height) = ((scene.width * scale).round(), (scene.height * scale).round());
    let fits = |side: f64| (1.0..=LARGEST_SIDE).contains(&side);
    if !fits(width) || !fits(height) {
        return Err(PlotError::ImageSize { width, height });
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers from 1 to 16384"
    )]
    let (columns, rows) = (width as u32, height as u32);
    let mut map = Pixmap::new(columns, rows).ok_or(PlotError::ImageSize { width, height })?;
    map.fill(Color::WHITE);
    let font = Font::load()?;
    let zoom = Transform::from_scale(single(scale), single(scale));
    for item in &scene.items {
        match item {
            Item::Open { .. } | Item::Close => {}
            Item::Path(path) => draw_path(&mut map, path, zoom),
            Item::Dots { points, size, colour } => draw_dots(&mut map, points, *size, *colour, zoom),
            Item::Text(text) => draw_text(&mut map, &font, text, zoom),
        }
    }
    map.encode_png().map_err(|_| PlotError::Encode)
}

fn draw_path(map: &mut Pixmap, path: &Path, zoom: Transform) {
    let mut builder = PathBuilder::new();
    for (i, p) in path.points.iter().enumerate() {
        if i == 0 {
            builder.move_to(single(p[0]), single(p[1]));
        } else {
            builder.line_to(single(p[0]), single(p[1]));
        }
    }
    if path.closed {
        builder.close();
    }
    let Some(outline) = builder.finish() else { return };
    if let Some((colour, opacity)) = path.fill {
        map.fill_path(&outline, &paint(colour, opacity), FillRule::Winding, zoom, None);
    }
    if let Some(pen) = &path.pen {
        map.stroke_path(&outline, &paint(pen.colour, 1.0), &stroke(pen), zoom, None);
    }
}

fn draw_dots(map: &mut Pixmap, points: &[[f64; 2]], size: f64, colour: Colour, zoom: Transform) {
    let mut builder = PathBuilder::new();
    for p in points {
        builder.push_circle(single(p[0]), single(p[1]), single(0.5 * size));
    }
    if let Some(outline) = builder.finish() {
        map.fill_path(&outline, &paint(colour, 1.0), FillRule::Winding, zoom, None);
    }
}

fn draw_text(map: &mut Pixmap, font: &Font, text: &Text, zoom: Transform) {
    let width = font.width(&text.content, text.size);
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * width,
        Anchor::End => -width,
    };
    let mut pen = start;
    let mut glyphs = Glyphs { builder: PathBuilder::new(), x: 0.0, y: 0.0, scale: 0.0 };
    for run in runs(&text.content) {
        let ems = text.size * run.size;
        glyphs.y = single(run.drop * text.size);
        glyphs.scale = single(ems / f64::from(font.face.units_per_em()));
        for c in run.text.chars() {
            let (id, advance) = font.glyph(c);
            glyphs.x = single(pen);
            font.face.outline_glyph(id, &mut glyphs);
            pen += advance * ems;
        }
    }
    let Some(outline) = glyphs.builder.finish() else { return };
    let mut place = zoom.pre_translate(single(text.at[0]), single(text.at[1]));
    if text.upwards {
        place = place.pre_concat(Transform::from_rotate(-90.0));
    }
    if text.rim {
        let rim = Pen { colour: Colour::WHITE, width: 3.0, dash: Vec::new() };
        map.stroke_path(&outline, &paint(rim.colour, 1.0), &stroke(&rim), place, None);
    }
    map.fill_path(&outline, &paint(text.colour, 1.0), FillRule::Winding, place, None);
    if text.bold {
        // One face is embedded; a hairline around the glyphs is weight enough for short headings.
        let weight = Pen { colour: text.colour, width: 0.035 * text.size, dash: Vec::new() };
        map.stroke_path(&outline, &paint(text.colour, 1.0), &stroke(&weight), place, None);
    }
}

fn paint(colour: Colour, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
    let alpha = (255.0 * opacity.clamp(0.0, 1.0)).round() as u8;
    paint.set_color_rgba8(colour.r, colour.g, colour.b, alpha);
    paint.anti_alias = true;
    paint
}

fn stroke(pen: &Pen) -> Stroke {
    Stroke {
        width: single(pen.width),
        line_cap: LineCap::Butt,
        line_join: LineJoin::Round,
        dash: StrokeDash::new(pen.dash.iter().map(|d| single(*d)).collect(), 0.0),
        ..Stroke::default()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "positions on a page; a millionth of the page is far below a pixel"
)]
fn single(v: f64) -> f32 {
    v as f32
}

/// Collects glyph outlines; fonts have y upwards.
struct Glyphs {
    builder: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Glyphs {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, self.y - self.scale * y)
    }
}

impl ttf_parser::OutlineBuilder for Glyphs {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (x1, y1) = self.at(x1, y1);
        let (x, y) = self.at(x, y);
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (x1, y1) = self.at(x1, y1);
        let (x2, y2) = self.at(x2, y2);
        let (x, y) = self.at(x, y);
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}
