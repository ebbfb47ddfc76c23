//! Views of space: the three coordinate planes and a perspective with its box.
//!
//! All are right-handed drawings: X to the right and Y or Z up, and Y to the right with Z up as seen from
//! beyond the tip. The perspective looks along +Y, from a little above and from the tip's side.

use crate::figure::{Annotation, Dash, Panel, Series, Stroke};
use crate::palette::Colour;
use crate::ticks::{Ticks, ticks};

/// Ends of X, Y and Z, in mm.
pub(crate) type Ends = [[f64; 2]; 3];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum View {
    Xy,
    Xz,
    Yz,
    /// Looks at the middle of this box.
    Perspective(Ends),
}

/// From the middle of the box to the eye.
const EYE: [f64; 3] = [0.50, -0.75, 0.43];
/// Distance of the eye in diagonals of the box: near enough for depth, far enough to keep proportions.
const DISTANCE: f64 = 3.0;

impl View {
    /// Coordinates that run to the right and upwards.
    pub(crate) fn axes(self) -> Option<[usize; 2]> {
        match self {
            Self::Xy => Some([0, 1]),
            Self::Xz => Some([0, 2]),
            Self::Yz => Some([1, 2]),
            Self::Perspective(_) => None,
        }
    }

    pub(crate) fn labels(self) -> [&'static str; 2] {
        self.axes().map_or(["", ""], |axes| axes.map(|k| ["X", "Y", "Z"][k]))
    }

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Perspective(_) => "perspective",
            _ => "",
        }
    }

    /// Coordinates on paper. In the perspective a length at the middle of the box keeps its scale.
    pub(crate) fn project(self, p: [f64; 3]) -> [f64; 2] {
        match self {
            Self::Xy => [p[0], p[1]],
            Self::Xz => [p[0], p[2]],
            Self::Yz => [p[1], p[2]],
            Self::Perspective(ends) => {
                let middle = ends.map(|e| 0.5 * (e[0] + e[1]));
                let diagonal = norm(ends.map(|e| e[1] - e[0]));
                let [right, up, eye] = camera();
                let d = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]];
                let far = DISTANCE * diagonal;
                // Points of the box stay well in front of the eye; others are kept there.
                let zoom = far / (far - dot(d, eye)).max(0.1 * far);
                [zoom * dot(d, right), zoom * dot(d, up)]
            }
        }
    }

    /// Component of a vector towards the reader.
    pub(crate) fn towards_reader(self, v: [f64; 3]) -> f64 {
        match self {
            Self::Xy => v[2],
            Self::Xz => -v[1],
            Self::Yz => v[0],
            Self::Perspective(_) => dot(v, camera()[2]),
        }
    }
}

/// Unit vectors to the right, upwards and to the eye.
fn camera() -> [[f64; 3]; 3] {
    let eye = EYE.map(|v| v / norm(EYE));
    // Right = Z × eye keeps Z upright on paper.
    let flat = eye[0].hypot(eye[1]);
    let right = [-eye[1] / flat, eye[0] / flat, 0.0];
    let up = [
        eye[1] * right[2] - eye[2] * right[1],
        eye[2] * right[0] - eye[0] * right[2],
        eye[0] * right[1] - eye[1] * right[0],
    ];
    [right, up, eye]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

fn bounds(points: &[[f64; 3]]) -> Ends {
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for p in points {
        for k in 0..3 {
            ends[k] = [ends[k][0].min(p[k]), ends[k][1].max(p[k])];
        }
    }
    ends
}

/// Largest extent along an axis.
pub(crate) fn extent(points: &[[f64; 3]]) -> f64 {
    bounds(points).iter().map(|e| e[1] - e[0]).fold(0.0, f64::max)
}

/// Ends of the axes: the points with a margin, no axis shorter than a part of the longest. Both are
/// relative to the longest.
pub(crate) fn ends(points: &[[f64; 3]], margin: f64, least: f64) -> Ends {
    let raw = bounds(points);
    let longest = raw.iter().map(|e| e[1] - e[0]).fold(0.0, f64::max);
    let size = raw.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    // All points in one place: a box of a tenth of their distance from the base, or of 1 mm.
    let floor = if size > 1e-9 { 1e-3 * size } else { 1.0 };
    let longest = longest.max(floor);
    raw.map(|[low, high]| {
        let more = (0.5 * (least * longest - (high - low))).max(margin * longest);
        [low - more, high + more]
    })
}

/// Draws the three far faces of the box with grid, numbers and axis names.
pub(crate) fn draw_box(panel: &mut Panel, ends: &Ends) {
    let view = View::Perspective(*ends);
    let longest = ends.iter().map(|e| e[1] - e[0]).fold(0.0, f64::max);
    let [x, y, z] = *ends;
    // The edge along Y is foreshortened and has room for few numbers.
    let marks: [Ticks; 3] = [(x, 4.0), (y, 2.0), (z, 3.5)]
        .map(|(e, least)| ticks(e[0], e[1], (4.5 * (e[1] - e[0]) / longest).max(least)));
    let mut lines: Vec<Series> = Vec::new();
    let mut line = |a: [f64; 3], b: [f64; 3], colour: Colour| {
        lines.push(Series {
            points: vec![view.project(a), view.project(b)],
            line: Some(Stroke { colour, width: 0.7, dash: Dash::Solid }),
            ..Series::default()
        });
    };
    // Far faces: floor z = z₀, back y = y₁, left x = x₀.
    for v in &marks[0].values {
        line([*v, y[0], z[0]], [*v, y[1], z[0]], Colour::GRID);
        line([*v, y[1], z[0]], [*v, y[1], z[1]], Colour::GRID);
    }
    for v in &marks[1].values {
        line([x[0], *v, z[0]], [x[1], *v, z[0]], Colour::GRID);
        line([x[0], *v, z[0]], [x[0], *v, z[1]], Colour::GRID);
    }
    for v in &marks[2].values {
        line([x[0], y[1], *v], [x[1], y[1], *v], Colour::GRID);
        line([x[0], y[0], *v], [x[0], y[1], *v], Colour::GRID);
    }
    let edges: [[[f64; 3]; 2]; 9] = [
        [[x[0], y[1], z[0]], [x[1], y[1], z[0]]],
        [[x[0], y[0], z[0]], [x[0], y[1], z[0]]],
        [[x[0], y[1], z[0]], [x[0], y[1], z[1]]],
        [[x[0], y[0], z[1]], [x[0], y[1], z[1]]],
        [[x[0], y[1], z[1]], [x[1], y[1], z[1]]],
        [[x[1], y[1], z[0]], [x[1], y[1], z[1]]],
        [[x[0], y[0], z[0]], [x[1], y[0], z[0]]],
        [[x[1], y[0], z[0]], [x[1], y[1], z[0]]],
        [[x[0], y[0], z[0]], [x[0], y[0], z[1]]],
    ];
    for (i, [a, b]) in edges.into_iter().enumerate() {
        line(a, b, if i < 6 { Colour::DIM } else { Colour::INK });
    }
    lines.append(&mut panel.series);
    panel.series = lines;

    // Numbers stand on the three near edges of the outline, axis names beyond their middles.
    let middle = ends.map(|e| 0.5 * (e[0] + e[1]));
    let edge = |k: usize, v: f64| match k {
        0 => [v, y[0], z[0]],
        1 => [x[1], v, z[0]],
        _ => [x[0], y[0], v],
    };
    let outward = [[-0.25, -1.0], [1.0, -0.75], [-1.0, 0.0]];
    for k in 0..3 {
        for (v, text) in marks[k].values.iter().zip(&marks[k].labels) {
            panel.annotations.push(number(view.project(edge(k, *v)), text, outward[k], 9.5));
        }
        let at = view.project(edge(k, middle[k]));
        let off = [0.08, 0.08, 0.13][k] * longest;
        let length = f64::hypot(outward[k][0], outward[k][1]);
        let at = [at[0] + off * outward[k][0] / length, at[1] + off * outward[k][1] / length];
        let text = ["X (mm)", "Y (mm)", "Z (mm)"][k].to_owned();
        let (towards, colour) = (outward[k], Colour::INK);
        panel.annotations.push(Annotation::Text { at, text, towards, size: 10.5, colour, avoid: true });
    }
    let corners: Vec<[f64; 2]> = edges.iter().flatten().map(|p| view.project(*p)).collect();
    for (k, axis) in [&mut panel.x, &mut panel.y].into_iter().enumerate() {
        let low = corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
        let room = [0.36, 0.22][k] * longest;
        axis.range = Some([low - room, high + 0.06 * longest]);
    }
}

fn number(at: [f64; 2], text: &str, towards: [f64; 2], size: f64) -> Annotation {
    let text = text.to_owned();
    Annotation::Text { at, text, towards, size, colour: Colour::INK, avoid: false }
}
