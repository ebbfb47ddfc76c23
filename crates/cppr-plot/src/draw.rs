//! From the figure to marks in px.

use crate::error::PlotError;
use crate::figure::{Annotation, Figure, Marker, MarkerShape, Panel, Series, Stroke};
use crate::font::Font;
use crate::layout::{HEADING, LABEL, LINE, Layout, Placed, TICK, TITLE, axis_text, place};
use crate::palette::Colour;
use crate::scene::{Anchor, Item, MIDDLE, Path, Pen, Scene, Text};
use crate::thin::{clip, clip_polygon, thin};
use crate::ticks::count;
use crate::{labels, legend};

/// Darker than the grid, paler than any data.
const ZERO: Colour = Colour::rgb(0xc4, 0xc4, 0xc4);

/// The drawing of a figure.
pub(crate) fn scene(figure: &Figure) -> Result<Scene, PlotError> {
    let font = Font::load()?;
    let layout = place(figure, &font)?;
    let mut scene =
        Scene { width: layout.width, height: layout.height, title: figure.title.clone(), items: Vec::new() };
    draw_title(&mut scene, &layout);
    legend::draw(&mut scene, &layout);
    for (panel, placed) in figure.panels.iter().zip(&layout.panels) {
        draw_panel(&mut scene, panel, placed, &font);
    }
    if let Some((panel, placed)) = &layout.bar {
        draw_panel(&mut scene, panel, placed, &font);
    }
    Ok(scene)
}

pub(crate) fn pen(stroke: &Stroke) -> Pen {
    let dash = stroke.dash.pattern().iter().map(|d| d * stroke.width.max(0.8)).collect();
    Pen { colour: stroke.colour, width: stroke.width, dash }
}

fn draw_title(scene: &mut Scene, layout: &Layout) {
    let mut y = 8.0 + 0.5 * TITLE * LINE;
    for line in &layout.title {
        scene.items.push(Item::Text(Text {
            at: [0.5 * layout.width, y + MIDDLE * TITLE],
            content: line.clone(),
            size: TITLE,
            anchor: Anchor::Middle,
            colour: Colour::INK,
            upwards: false,
            rim: false,
        }));
        y += TITLE * LINE;
    }
}

fn draw_panel(scene: &mut Scene, panel: &Panel, placed: &Placed, font: &Font) {
    scene.items.push(Item::Open { class: "panel" });
    if panel.framed {
        draw_grid(scene, panel, placed);
    }
    for series in &panel.series {
        draw_area(scene, series, placed);
    }
    for series in &panel.series {
        draw_line(scene, series, placed);
    }
    // Marks lie above all lines, else the tip of one pose vanishes below the next pose.
    for series in &panel.series {
        if let Some(Marker { shape: MarkerShape::Dot, size, colour, .. }) = series.marker {
            let points = series.points.iter().map(|p| placed.map(*p));
            let points = points.filter(|p| placed.frame.contains(*p, 1e-6)).collect();
            scene.items.push(Item::Dots { points, size, colour });
        } else if let Some(marker) = &series.marker {
            for p in &series.points {
                let at = placed.map(*p);
                if placed.frame.contains(at, 1e-6) {
                    draw_marker(scene, marker, at, &series.name);
                }
            }
        }
    }
    if panel.framed {
        draw_axes(scene, panel, placed);
    }
    for annotation in &panel.annotations {
        if let Annotation::Arrow { name, from, to, stroke } = annotation {
            draw_arrow(scene, name, placed.map(*from), placed.map(*to), stroke);
        }
    }
    labels::draw(scene, panel, placed, font);
    if !panel.title.is_empty() {
        let f = &placed.frame;
        scene.label([f.x, f.y - 0.5 * HEADING * LINE - 1.0], &panel.title, HEADING, Anchor::Start);
    }
    scene.items.push(Item::Close);
}

fn draw_grid(scene: &mut Scene, panel: &Panel, placed: &Placed) {
    let f = &placed.frame;
    scene.items.push(Item::Open { class: "grid" });
    if panel.x.grid {
        for v in &placed.x_ticks.values {
            let x = placed.map([*v, placed.y[0]])[0];
            scene.line("", &[[x, f.y], [x, f.y + f.h]], Colour::GRID, 0.7);
        }
    }
    if panel.y.grid {
        for v in &placed.y_ticks.values {
            let y = placed.map([placed.x[0], *v])[1];
            scene.line("", &[[f.x, y], [f.x + f.w, y]], Colour::GRID, 0.7);
        }
    }
    let zero = placed.map([0.0, 0.0]);
    if panel.x.zero_line && f.contains([zero[0], f.y], 1e-6) {
        scene.line("", &[[zero[0], f.y], [zero[0], f.y + f.h]], ZERO, 1.0);
    }
    if panel.y.zero_line && f.contains([f.x, zero[1]], 1e-6) {
        scene.line("", &[[f.x, zero[1]], [f.x + f.w, zero[1]]], ZERO, 1.0);
    }
    scene.items.push(Item::Close);
}

fn draw_axes(scene: &mut Scene, panel: &Panel, placed: &Placed) {
    const MARK: f64 = 4.0;
    let f = &placed.frame;
    let (bottom, right) = (f.y + f.h, f.x + f.w);
    scene.items.push(Item::Open { class: "axes" });
    scene.path(Path {
        points: vec![[f.x, f.y], [right, f.y], [right, bottom], [f.x, bottom]],
        closed: true,
        pen: Some(Pen { colour: Colour::INK, width: 0.9, dash: Vec::new() }),
        ..Path::default()
    });
    for (v, label) in placed.x_ticks.values.iter().zip(&placed.x_ticks.labels) {
        let x = placed.map([*v, placed.y[0]])[0];
        scene.line("", &[[x, bottom], [x, bottom - MARK]], Colour::INK, 0.9);
        if panel.x.labelled {
            scene.label([x, bottom + 6.0 + 0.5 * TICK], label, TICK, Anchor::Middle);
        }
    }
    for (v, label) in placed.y_ticks.values.iter().zip(&placed.y_ticks.labels) {
        let y = placed.map([placed.x[0], *v])[1];
        scene.line("", &[[f.x, y], [f.x + MARK, y]], Colour::INK, 0.9);
        if panel.y.labelled {
            scene.label([f.x - 6.0, y], label, TICK, Anchor::End);
        }
    }
    if panel.x.labelled {
        let y = bottom + 8.0 + TICK * LINE + 0.5 * LABEL;
        let text = axis_text(&panel.x, &placed.x_ticks);
        scene.label([f.x + 0.5 * f.w, y], &text, LABEL, Anchor::Middle);
    }
    let lines = count(placed.y_label.len());
    for (i, line) in placed.y_label.iter().enumerate() {
        let middle = f.x - placed.y_tick_width - 12.0 - (lines - count(i) - 0.5) * LABEL * LINE;
        scene.items.push(Item::Text(Text {
            at: [middle + MIDDLE * LABEL, f.y + 0.5 * f.h],
            content: line.clone(),
            size: LABEL,
            anchor: Anchor::Middle,
            colour: Colour::INK,
            upwards: true,
            rim: false,
        }));
    }
    scene.items.push(Item::Close);
}

fn draw_area(scene: &mut Scene, series: &Series, placed: &Placed) {
    let Some(fill) = series.fill else { return };
    let mut points = thin(series.points.iter().map(|p| placed.map(*p)).collect());
    if let Some(y) = fill.to_y {
        let base = placed.map([placed.x[0], y])[1];
        if let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) {
            points.push([last[0], base]);
            points.push([first[0], base]);
        }
    }
    let points = clip_polygon(points, &placed.frame);
    scene.path(Path {
        class: "area",
        name: series.name.clone(),
        points,
        closed: true,
        pen: None,
        fill: Some((fill.colour, fill.opacity)),
    });
}

fn draw_line(scene: &mut Scene, series: &Series, placed: &Placed) {
    let Some(stroke) = &series.line else { return };
    let points = thin(series.points.iter().map(|p| placed.map(*p)).collect());
    for points in clip(&points, &placed.frame) {
        scene.path(Path {
            class: "series",
            name: series.name.clone(),
            points,
            closed: false,
            pen: Some(pen(stroke)),
            fill: None,
        });
    }
}

/// Polygon of `n` corners around a point, the first straight above it.
fn ring(at: [f64; 2], radius: f64, n: usize) -> Vec<[f64; 2]> {
    (0..n)
        .map(|i| {
            let a = std::f64::consts::TAU * count(i) / count(n);
            [at[0] + radius * a.sin(), at[1] - radius * a.cos()]
        })
        .collect()
}

pub(crate) fn draw_marker(scene: &mut Scene, marker: &Marker, at: [f64; 2], name: &str) {
    let r = 0.5 * marker.size;
    let thin_pen = |width: f64| Pen { colour: marker.colour, width, dash: Vec::new() };
    let outline = match marker.shape {
        MarkerShape::Circle | MarkerShape::Dot | MarkerShape::Towards | MarkerShape::Away => ring(at, r, 28),
        MarkerShape::Triangle => ring([at[0], at[1] + 0.2 * r], 1.2 * r, 3),
        MarkerShape::Diamond => ring(at, 1.15 * r, 4),
        MarkerShape::Square => [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]
            .map(|d| [at[0] + d[0] * r, at[1] + d[1] * r])
            .to_vec(),
        MarkerShape::Cross => Vec::new(),
    };
    let open = matches!(marker.shape, MarkerShape::Towards | MarkerShape::Away);
    if !outline.is_empty() {
        let inside = if marker.filled && !open { marker.colour } else { Colour::WHITE };
        scene.path(Path {
            class: "marker",
            name: name.to_owned(),
            points: outline,
            closed: true,
            pen: Some(thin_pen(1.3)),
            fill: Some((inside, 1.0)),
        });
    }
    if marker.shape == MarkerShape::Towards {
        scene.path(Path {
            points: ring(at, 0.32 * r, 16),
            closed: true,
            fill: Some((marker.colour, 1.0)),
            ..Path::default()
        });
    }
    if matches!(marker.shape, MarkerShape::Cross | MarkerShape::Away) {
        let h = 0.7 * r;
        for (dx, dy) in [(h, h), (h, -h)] {
            scene.path(Path {
                class: if marker.shape == MarkerShape::Cross { "marker" } else { "" },
                name: name.to_owned(),
                points: vec![[at[0] - dx, at[1] - dy], [at[0] + dx, at[1] + dy]],
                pen: Some(thin_pen(1.3)),
                ..Path::default()
            });
        }
    }
}

pub(crate) fn draw_arrow(scene: &mut Scene, name: &str, from: [f64; 2], to: [f64; 2], stroke: &Stroke) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length < 1e-3 {
        return;
    }
    let (ux, uy) = (dx / length, dy / length);
    // Short arrows keep a head in proportion.
    let head = (4.0 * stroke.width).clamp(5.0, 12.0).min(0.6 * length);
    let neck = [to[0] - ux * head, to[1] - uy * head];
    let half = 0.38 * head;
    scene.path(Path {
        class: "arrow",
        name: name.to_owned(),
        points: vec![from, [neck[0] + 0.2 * ux * head, neck[1] + 0.2 * uy * head]],
        pen: Some(pen(stroke)),
        ..Path::default()
    });
    scene.path(Path {
        points: vec![
            to,
            [neck[0] - uy * half, neck[1] + ux * half],
            [neck[0] + uy * half, neck[1] - ux * half],
        ],
        closed: true,
        fill: Some((stroke.colour, 1.0)),
        ..Path::default()
    });
}
