//! The legend: rows of entries above the panels, where no data can lie below it.

use crate::draw::{draw_arrow, draw_marker, pen};
use crate::figure::{Annotation, Figure, Key};
use crate::font::Font;
use crate::layout::Layout;
use crate::scene::{Anchor, Item, Path, Scene};
use crate::ticks::count;

const SIZE: f64 = 12.0;
/// Length of the sample of a line.
const SAMPLE: f64 = 30.0;
const GAP: f64 = 18.0;

/// Legend entries of the whole figure, each name once.
pub(crate) fn keys(figure: &Figure) -> Vec<Key> {
    let mut out: Vec<Key> = Vec::new();
    if !figure.legend {
        return out;
    }
    let mut add = |key: Key| {
        if !key.name.trim().is_empty() && out.iter().all(|k| k.name != key.name) {
            out.push(key);
        }
    };
    figure.keys.iter().cloned().for_each(&mut add);
    for panel in &figure.panels {
        for s in &panel.series {
            add(Key { name: s.name.clone(), line: s.line, marker: s.marker, fill: s.fill, arrow: false });
        }
        for a in &panel.annotations {
            if let Annotation::Arrow { name, stroke, .. } = a {
                add(Key { name: name.clone(), line: Some(*stroke), marker: None, fill: None, arrow: true });
            }
        }
    }
    out
}

pub(crate) fn entry_width(font: &Font, key: &Key) -> f64 {
    sample_width(key) + 6.0 + font.width(&key.name, SIZE)
}

/// Length of the sample of an entry: a mark needs less than a dash pattern.
fn sample_width(key: &Key) -> f64 {
    if key.line.is_none() && key.fill.is_none() { 10.0 } else { SAMPLE }
}

/// A row: its width, and entries with their left ends.
type Row = (f64, Vec<(Key, f64)>);

fn rows(font: &Font, keys: &[Key], width: f64) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for key in keys {
        // Readers may set the SVG in a wider face than the one measured here.
        let w = 1.04 * entry_width(font, key);
        match rows.last_mut() {
            Some((used, row)) if *used + GAP + w <= width => {
                row.push((key.clone(), *used + GAP));
                *used += GAP + w;
            }
            _ => rows.push((w, vec![(key.clone(), 0.0)])),
        }
    }
    rows
}

/// Places the entries in as few rows as the width allows, of about equal length, centred below `at`.
/// Returns each with its left end and middle height, and the height of all.
pub(crate) fn place(font: &Font, keys: &[Key], width: f64, at: [f64; 2]) -> (Vec<(Key, [f64; 2])>, f64) {
    let height = SIZE * 1.6;
    let least = rows(font, keys, width).len();
    let placed = (10..20)
        .map(|k| rows(font, keys, 0.05 * f64::from(k) * width))
        .find(|rows| rows.len() <= least)
        .unwrap_or_else(|| rows(font, keys, width));
    let depth = if placed.is_empty() { 0.0 } else { count(placed.len()) * height + 4.0 };
    let mut out = Vec::new();
    let mut y = at[1] + 0.5 * height;
    for (used, row) in placed {
        out.extend(row.into_iter().map(|(key, x)| (key, [at[0] - 0.5 * used + x, y])));
        y += height;
    }
    (out, depth)
}

/// Draws the placed entries.
pub(crate) fn draw(scene: &mut Scene, layout: &Layout) {
    if layout.legend.is_empty() {
        return;
    }
    scene.items.push(Item::Open { class: "legend" });
    for (key, [x, y]) in &layout.legend {
        let sample = sample_width(key);
        let (a, b) = ([*x, *y], [x + sample, *y]);
        if let Some(fill) = key.fill {
            let corners = [[*x, y - 5.0], [b[0], y - 5.0], [b[0], y + 5.0], [*x, y + 5.0]];
            scene.path(Path {
                points: corners.to_vec(),
                closed: true,
                fill: Some((fill.colour, fill.opacity)),
                ..Path::default()
            });
        }
        match key.line {
            Some(stroke) if key.arrow => draw_arrow(scene, "", a, b, &stroke),
            Some(stroke) => {
                scene.path(Path { points: vec![a, b], pen: Some(pen(&stroke)), ..Path::default() });
            }
            None => {}
        }
        if let Some(marker) = &key.marker {
            draw_marker(scene, marker, [x + 0.5 * sample, *y], "");
        }
        scene.label([b[0] + 6.0, *y], &key.name, SIZE, Anchor::Start);
    }
    scene.items.push(Item::Close);
}
