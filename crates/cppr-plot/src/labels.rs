//! Texts beside points, moved to where they cover least.

use crate::figure::{Annotation, Panel};
use crate::font::Font;
use crate::layout::Placed;
use crate::palette::Colour;
use crate::scene::{Anchor, Item, MIDDLE, Scene, Text};
use crate::thin::Rect;
use crate::ticks::count;

/// Turns away from the wanted direction, in degrees, tried in this order.
const TURNS: [f64; 9] = [0.0, 35.0, -35.0, 70.0, -70.0, 110.0, -110.0, 145.0, -145.0];
const GAPS: [f64; 3] = [6.0, 14.0, 24.0];

/// Draws the texts of a panel.
pub(crate) fn draw(scene: &mut Scene, panel: &Panel, placed: &Placed, font: &Font) {
    let mut taken: Vec<Rect> = Vec::new();
    let busy = if panel.annotations.iter().any(|a| matches!(a, Annotation::Text { avoid: true, .. })) {
        ink(panel, placed)
    } else {
        Vec::new()
    };
    // Texts that cannot move take their places first.
    let texts = |movable: bool| {
        panel
            .annotations
            .iter()
            .filter(move |a| matches!(a, Annotation::Text { avoid, .. } if *avoid == movable))
    };
    for annotation in texts(false).chain(texts(true)) {
        let Annotation::Text { at, text, towards, size, colour, avoid } = annotation else {
            continue;
        };
        let p = placed.map(*at);
        let extent = [font.width(text, *size), *size];
        let length = towards[0].hypot(towards[1]);
        let unit = if length > 0.0 { [towards[0] / length, -towards[1] / length] } else { [0.0, 0.0] };
        let rect = if *avoid && length > 0.0 {
            best(p, unit, extent, placed, &taken, &busy)
        } else {
            inside(beside(p, unit, extent, GAPS[0]), placed, panel.framed)
        };
        taken.push(rect);
        scene.items.push(Item::Text(Text {
            at: [rect.x + 0.5 * rect.w, rect.y + 0.5 * rect.h + MIDDLE * size],
            content: text.clone(),
            size: *size,
            anchor: Anchor::Middle,
            colour: *colour,
            upwards: false,
            rim: true,
        }));
    }
}

/// Points in px, not further apart than a few px, that a text had better not cover.
fn ink(panel: &Panel, placed: &Placed) -> Vec<[f64; 2]> {
    const APART: f64 = 3.0;
    let mut out = Vec::new();
    let mut along = |a: [f64; 2], b: [f64; 2]| {
        let mut left = ((b[0] - a[0]).hypot(b[1] - a[1]) / APART).min(1000.0);
        let parts = left.max(1.0);
        while left > 0.0 {
            let t = left / parts;
            out.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            left -= 1.0;
        }
    };
    for series in &panel.series {
        let step = (series.points.len() / 2000).max(1);
        let points: Vec<[f64; 2]> = series.points.iter().step_by(step).map(|p| placed.map(*p)).collect();
        // Lines without a name are background, such as a grid; but those that numbers stand on are not.
        if series.line.as_ref().is_some_and(|line| !series.name.is_empty() || line.colour == Colour::INK) {
            points.windows(2).for_each(|w| along(w[0], w[1]));
        }
        if series.marker.is_some() {
            for p in &points {
                // Both diagonals: to cover a mark counts more than to cross a line.
                along([p[0] - 4.0, p[1] - 4.0], [p[0] + 4.0, p[1] + 4.0]);
                along([p[0] - 4.0, p[1] + 4.0], [p[0] + 4.0, p[1] - 4.0]);
            }
        }
    }
    for annotation in &panel.annotations {
        if let Annotation::Arrow { from, to, .. } = annotation {
            along(placed.map(*from), placed.map(*to));
        }
    }
    out
}

fn best(
    p: [f64; 2],
    unit: [f64; 2],
    extent: [f64; 2],
    placed: &Placed,
    taken: &[Rect],
    busy: &[[f64; 2]],
) -> Rect {
    let mut best = (f64::INFINITY, Rect::default());
    for (g, gap) in GAPS.iter().enumerate() {
        for (k, turn) in TURNS.iter().enumerate() {
            let (s, c) = turn.to_radians().sin_cos();
            let turned = [c * unit[0] - s * unit[1], s * unit[0] + c * unit[1]];
            let wanted = beside(p, turned, extent, *gap);
            let rect = inside(wanted, placed, true);
            let moved = (rect.x - wanted.x).abs() + (rect.y - wanted.y).abs();
            // A text on a text cannot be read; on a line it can, with its rim.
            let mut cost = 0.5 * count(k) + 6.0 * count(g) + moved;
            cost += 1000.0 * count(taken.iter().filter(|t| t.overlaps(&rect)).count());
            if cost >= best.0 {
                continue;
            }
            cost += 5.0 * count(busy.iter().filter(|q| rect.contains(**q, 1.5)).count());
            if cost < best.0 {
                best = (cost, rect);
            }
        }
    }
    best.1
}

/// The box of a text that stands off from a point in a direction (y down).
fn beside(p: [f64; 2], unit: [f64; 2], [w, h]: [f64; 2], gap: f64) -> Rect {
    let centre = [p[0] + unit[0] * (0.5 * w + gap), p[1] + unit[1] * (0.5 * h + gap)];
    Rect { x: centre[0] - 0.5 * w, y: centre[1] - 0.5 * h, w, h }
}

/// Moves a box into the frame. Panels without a frame let texts stand on their margin.
fn inside(rect: Rect, placed: &Placed, framed: bool) -> Rect {
    let f = &placed.frame;
    let rim = if framed { 3.0 } else { -6.0 };
    let fit =
        |at: f64, extent: f64, low: f64, length: f64| at.min(low + length - rim - extent).max(low + rim);
    Rect { x: fit(rect.x, rect.w, f.x, f.w), y: fit(rect.y, rect.h, f.y, f.h), ..rect }
}
