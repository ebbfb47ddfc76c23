//! One quantity against another: effort against motion, misfit against a parameter, load against
//! actuation.

use crate::error::PlotError;
use crate::figure::{Axis, Dash, Figure, Marker, MarkerShape, Panel, Series, Stroke};
use crate::palette::{Colour, tube_stroke};

/// What [`xy_figure`] draws.
#[derive(Debug, Clone, PartialEq)]
pub struct XyInput {
    /// Short title; may be empty.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves; colour and dash follow their order.
    pub curves: Vec<XyCurve>,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct XyCurve {
    /// Legend entry; empty for none.
    pub name: String,
    /// Points in the units of the axes.
    pub points: Vec<[f64; 2]>,
    /// Stability at each point; empty if all are stable. A piece with an unstable end is drawn thin and
    /// dotted, as an entry of its own.
    pub stable: Vec<bool>,
    /// Mark every point.
    pub marked: bool,
    /// Draw no line between the points (implies marks).
    pub scattered: bool,
    /// A limit or reference (Euler's load, say): thin black dashes instead of the next colour.
    pub reference: bool,
    /// Colour and dash of the curve of this rank, from 1, instead of the next ones: what has the same colour in several panels of a
    /// figure is the same thing.
    pub rank: Option<usize>,
}

impl XyCurve {
    /// A stable curve without marks.
    #[must_use]
    pub fn new(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, ..Self::default() }
    }
}

const SHAPES: [MarkerShape; 5] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Triangle,
    MarkerShape::Diamond,
    MarkerShape::Cross,
];

/// A line plot of one panel.
///
/// # Errors
/// [`PlotError::Empty`] without curves or points, [`PlotError::SinglePoint`] for a line of one point
/// without mark, [`PlotError::LengthMismatch`] if stability is given for another number of points;
/// values that are not finite are refused when the figure is written.
pub fn xy_figure(input: &XyInput) -> Result<Figure, PlotError> {
    if input.curves.is_empty() {
        return Err(PlotError::Empty { what: "the list of curves".to_owned() });
    }
    let mut panel = Panel::new(input.x.clone(), input.y.clone());
    let mut rank = 0;
    for (i, curve) in input.curves.iter().enumerate() {
        let what = if curve.name.is_empty() {
            format!("curve {}", i + 1)
        } else {
            format!("curve '{}'", curve.name)
        };
        if !curve.stable.is_empty() && curve.stable.len() != curve.points.len() {
            let (expected, found) = (curve.points.len(), curve.stable.len());
            return Err(PlotError::LengthMismatch { what, expected, found });
        }
        let marked = curve.marked || curve.scattered;
        match curve.points.len() {
            0 => return Err(PlotError::Empty { what }),
            1 if !marked => return Err(PlotError::SinglePoint { what }),
            _ => {}
        }
        let stroke = if curve.reference {
            Stroke { colour: Colour::INK, width: 1.2, dash: Dash::Dashed }
        } else {
            rank = curve.rank.unwrap_or(rank + 1);
            tube_stroke(rank)
        };
        let marker = marked.then_some(Marker {
            shape: SHAPES[rank.saturating_sub(1) % SHAPES.len()],
            size: 6.0,
            colour: stroke.colour,
            filled: false,
        });
        if curve.scattered || curve.points.len() == 1 {
            panel.series.push(Series {
                name: curve.name.clone(),
                points: curve.points.clone(),
                marker,
                ..Series::default()
            });
        } else {
            panel.series.extend(branches(curve, stroke, marker));
        }
    }
    Ok(Figure { title: input.title.clone(), panels: vec![panel], max_width: 520.0, ..Figure::default() })
}

/// The stable and unstable pieces of a curve.
fn branches(curve: &XyCurve, stroke: Stroke, marker: Option<Marker>) -> Vec<Series> {
    let stable_at = |i: usize| curve.stable.get(i).copied().unwrap_or(true);
    let thin = Stroke { width: 0.7 * stroke.width, dash: Dash::Dotted, ..stroke };
    let mut out: Vec<(bool, Series)> = Vec::new();
    for (i, pair) in curve.points.windows(2).enumerate() {
        let stable = stable_at(i) && stable_at(i + 1);
        match out.last_mut() {
            Some((kind, piece)) if *kind == stable => piece.points.push(pair[1]),
            _ => {
                let (name, line) = match (stable, curve.name.is_empty()) {
                    (true, _) => (curve.name.clone(), stroke),
                    (false, true) => (String::new(), thin),
                    (false, false) => (format!("{} (unstable)", curve.name), thin),
                };
                let points = pair.to_vec();
                out.push((stable, Series { name, points, line: Some(line), marker, fill: None }));
            }
        }
    }
    // The stable branch leads the legend, wherever the curve begins.
    out.sort_by_key(|(stable, _)| !stable);
    out.into_iter().map(|(_, series)| series).collect()
}
