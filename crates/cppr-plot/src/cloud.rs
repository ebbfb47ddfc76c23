//! Clouds of tip positions, coloured by a quantity: the workspace of a robot.
//!
//! Frame as for shapes: baseplate at x = 0, the robot at rest along +X. A [`Cloud`] takes any number of points and
//! remembers few: it keeps the first in each cell of space and doubles its cells when they become too many. Clouds in the plane
//! z = 0 are drawn in one panel, others in the three views and a perspective, in each of which what is nearer to the reader
//! hides what lies behind.

use std::collections::BTreeMap;

use crate::error::PlotError;
use crate::figure::{Axis, ColourBar, Dash, Figure, Marker, MarkerShape, Panel, Series, Stroke};
use crate::palette::{Colour, ramp};
use crate::space::{self, View};
use crate::ticks::count;

/// Most points that are remembered.
const MOST: usize = 40_000;
/// First cells, as parts of the reach.
const FINEST: f64 = 1.0 / 1024.0;
/// Relative distance from the plane z = 0 up to which a cloud counts as planar.
const PLANAR: f64 = 1e-9;
/// Shades of the colour bar.
const SHADES: usize = 12;
/// Cells across a view, each of which shows one point.
const CELLS: f64 = 150.0;

/// Points with values, thinned as they come.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    cell: f64,
    points: BTreeMap<[i64; 3], ([f64; 3], f64)>,
    /// Points given so far.
    pub total: u64,
}

impl Cloud {
    /// An empty cloud; `reach` is the length of the robot (m).
    #[must_use]
    pub fn new(reach: f64) -> Self {
        Self { cell: FINEST * reach, points: BTreeMap::new(), total: 0 }
    }

    /// Adds a point (m) and its value. Points and values that are not finite are left out.
    pub fn add(&mut self, point: [f64; 3], value: f64) {
        if !(point.iter().all(|v| v.is_finite()) && value.is_finite()) {
            return;
        }
        self.total += 1;
        self.points.entry(key(point, self.cell)).or_insert((point, value));
        while self.points.len() > MOST {
            self.cell *= 2.0;
            let fine = std::mem::take(&mut self.points);
            for (point, value) in fine.into_values() {
                self.points.entry(key(point, self.cell)).or_insert((point, value));
            }
        }
    }
}

fn key(point: [f64; 3], cell: f64) -> [i64; 3] {
    #[allow(clippy::cast_possible_truncation, reason = "saturates, far beyond any robot")]
    point.map(|v| (v / cell).floor() as i64)
}

/// What [`cloud_figure`] draws.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudInput {
    /// Short title; may be empty.
    pub title: String,
    /// The points.
    pub cloud: Cloud,
    /// What the colour tells, with its unit.
    pub value: Axis,
    /// Length of the robot (m), drawn at rest; none to draw the points alone, at their own scale.
    pub length: Option<f64>,
}

/// A cloud with its colour bar, equal axes in mm.
///
/// # Errors
/// [`PlotError::Empty`] without points.
pub fn cloud_figure(input: &CloudInput) -> Result<Figure, PlotError> {
    let points: Vec<([f64; 3], f64)> =
        input.cloud.points.values().map(|(p, v)| (p.map(|x| 1e3 * x), *v)).collect();
    if points.is_empty() {
        return Err(PlotError::Empty { what: "the cloud of points".to_owned() });
    }
    let rest = input.length.map(|length| [[0.0; 3], [1e3 * length, 0.0, 0.0]]);
    let mut shown: Vec<[f64; 3]> = points.iter().map(|(p, _)| *p).collect();
    shown.extend(rest.into_iter().flatten());
    let size = shown.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let low = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    // One value alone gets a bar around it.
    let room = if high - low > 1e-9 * high.abs().max(low.abs()) { 0.0 } else { high.abs().max(1.0) * 1e-3 };
    let bar = ColourBar { axis: input.value.clone(), range: [low - room, high + room], shades: SHADES };
    let planar = shown.iter().all(|p| p[2].abs() <= PLANAR * size);
    let mut figure = Figure { title: input.title.clone(), ..Figure::default() };
    if planar {
        let ends = space::ends(&shown, 0.05, 0.12);
        figure.panels = vec![panel(View::Xy, &ends, &points, rest.as_ref(), &bar)];
    } else {
        let ends = space::ends(&shown, 0.05, 0.4);
        figure.columns = 2;
        for view in [View::Xy, View::Perspective(ends), View::Xz, View::Yz] {
            figure.panels.push(panel(view, &ends, &points, rest.as_ref(), &bar));
        }
    }
    figure.bar = Some(bar);
    Ok(figure)
}

fn panel(
    view: View,
    ends: &space::Ends,
    points: &[([f64; 3], f64)],
    rest: Option<&[[f64; 3]; 2]>,
    bar: &ColourBar,
) -> Panel {
    let [x, y] = view.labels();
    let mut panel = Panel::new(Axis::new(x, "mm"), Axis::new(y, "mm"));
    panel.equal = true;
    panel.framed = view.axes().is_some();
    panel.own_scale = !panel.framed;
    view.title().clone_into(&mut panel.title);
    if let Some(rest) = rest {
        panel.series.push(Series {
            name: "robot at rest".to_owned(),
            points: rest.iter().map(|p| view.project(*p)).collect(),
            line: Some(Stroke { colour: Colour::INK, width: 1.4, dash: Dash::DashDot }),
            ..Series::default()
        });
    }
    match view.axes() {
        Some([x, y]) => {
            panel.x.range = Some(ends[x]);
            panel.y.range = Some(ends[y]);
        }
        None => space::draw_box(&mut panel, ends),
    }
    // What lies nearest to the reader in each cell of the view.
    let cell = ends.iter().map(|e| e[1] - e[0]).fold(0.0, f64::max) / CELLS;
    let mut nearest: BTreeMap<[i64; 3], (f64, [f64; 2], f64)> = BTreeMap::new();
    for (point, value) in points {
        let [x, y] = view.project(*point);
        let depth = view.towards_reader(*point);
        let place = nearest.entry(key([x, y, 0.0], cell)).or_insert((depth, [x, y], *value));
        if depth > place.0 {
            *place = (depth, [x, y], *value);
        }
    }
    let dots = nearest.len();
    let mut shades: Vec<Vec<[f64; 2]>> = vec![Vec::new(); bar.shades];
    for (_, at, value) in nearest.into_values() {
        shades[bar.shade(value)].push(at);
    }
    for (shade, points) in shades.into_iter().enumerate().filter(|(_, points)| !points.is_empty()) {
        // Few points are to be seen, many to touch each other.
        let size = (220.0 / count(dots).sqrt()).clamp(2.2, 5.0);
        let marker = Marker { shape: MarkerShape::Dot, size, colour: bar.colour(shade), filled: true };
        panel.series.push(Series { points, marker: Some(marker), ..Series::default() });
    }
    panel
}

impl ColourBar {
    /// Which shade a value has.
    fn shade(&self, value: f64) -> usize {
        let share = (value - self.range[0]) / (self.range[1] - self.range[0]);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the shades")]
        let shade = (share.clamp(0.0, 1.0) * count(self.shades)) as usize;
        shade.min(self.shades - 1)
    }

    /// Colour of a shade.
    pub(crate) fn colour(&self, shade: usize) -> Colour {
        ramp(count(shade) / count((self.shades - 1).max(1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cloud_keeps_its_extent_and_few_points() {
        let mut cloud = Cloud::new(1.0);
        for i in 0..300_000_u32 {
            let t = f64::from(i) * 0.618_033_988_749_895 % 1.0;
            let u = f64::from(i) / 3e5;
            cloud.add([u, t, u * t], u);
        }
        cloud.add([f64::NAN, 0.0, 0.0], 0.0);
        assert_eq!(cloud.total, 300_000);
        assert!(cloud.points.len() <= MOST && cloud.points.len() > MOST / 8, "{}", cloud.points.len());
        let high = cloud.points.values().map(|(p, _)| p[0]).fold(0.0, f64::max);
        let low = cloud.points.values().map(|(p, _)| p[0]).fold(1.0, f64::min);
        assert!(high > 0.98 && low < 0.02);
    }

    #[test]
    fn shades_cover_the_range() {
        let bar = ColourBar { axis: Axis::new("T", "N"), range: [-2.0, 4.0], shades: 12 };
        assert_eq!([-2.0, -1.6, 0.99, 1.01, 4.0, 9.0].map(|v| bar.shade(v)), [0, 0, 5, 6, 11, 11]);
    }
}
