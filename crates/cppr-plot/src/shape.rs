//! The shape of a robot: centroid lines of the tubes and the centreline, in mm, equal axes.
//!
//! Frame: baseplate at x = 0, the robot at rest along +X. Robots that stay in the plane z = 0 get one
//! panel (X-Y), others the three views and a perspective view. Points come in metres.

use crate::error::PlotError;
use crate::figure::{Annotation, Axis, Dash, Figure, Fill, Key, Marker, MarkerShape, Panel, Series, Stroke};
use crate::palette::{Colour, ramp, tube_stroke};
use crate::pose::{Colouring, Line, Part, Pose, ShapeInput, check, name_of};
use crate::space::{self, View};
use crate::ticks::count;

/// Relative distance from the plane z = 0 up to which a robot counts as planar.
const PLANAR: f64 = 1e-9;
/// Forces below this, in N, are rounding and not drawn.
const NEGLIGIBLE: f64 = 1e-12;
/// Length of the longest force arrow relative to the extent of the figure.
const ARROW: f64 = 0.14;

/// The figure of one or several poses.
///
/// # Errors
/// [`PlotError::Empty`] and [`PlotError::SinglePoint`] for missing poses, lines or points,
/// [`PlotError::NotFinite`], [`PlotError::TooLarge`], [`PlotError::TubeZero`].
pub fn shape_figure(input: &ShapeInput) -> Result<Figure, PlotError> {
    check(input)?;
    let points: Vec<[f64; 3]> = all_points(input).map(millimetres).collect();
    let size = points.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let forces: Vec<[f64; 3]> = input.poses.iter().flat_map(|p| &p.forces).map(|f| f.vector).collect();
    let strongest = forces.iter().map(|f| norm(*f)).fold(0.0, f64::max);
    let strongest = if strongest > NEGLIGIBLE { strongest } else { 0.0 };
    let planar = points.iter().all(|p| p[2].abs() <= PLANAR * size)
        && forces.iter().all(|f| f[2].abs() <= (PLANAR * strongest).max(NEGLIGIBLE));
    let extent = space::extent(&points);
    let stage = Stage {
        input,
        arrow_per_newton: if strongest > 0.0 { ARROW * extent / strongest } else { 0.0 },
        force_name: force_name(&forces, strongest),
        plate: plate_half(input).max(0.03 * extent),
        extent,
    };
    let mut heads = points;
    heads.extend(stage.forces().map(|(_, to)| to));
    let mut figure = Figure { title: input.title.clone(), ..Figure::default() };
    figure.keys = keys(input);
    // Labels stand beyond the tips.
    let margin = if input.poses.iter().all(|p| p.label.is_empty()) { 0.06 } else { 0.09 };
    if planar {
        let mut panel = stage.panel(View::Xy);
        let ends = space::ends(&heads, margin, 0.12);
        panel.x.range = Some(ends[0]);
        panel.y.range = Some(ends[1]);
        panel.y.zero_line = true;
        figure.panels = vec![panel];
    } else {
        let ends = space::ends(&heads, margin, 0.4);
        for view in [View::Xy, View::Perspective(ends), View::Xz, View::Yz] {
            let mut panel = stage.panel(view);
            match view.axes() {
                Some([x, y]) => {
                    panel.x.range = Some(ends[x]);
                    panel.y.range = Some(ends[y]);
                }
                None => space::draw_box(&mut panel, &ends),
            }
            figure.panels.push(panel);
        }
        figure.columns = 2;
    }
    Ok(figure)
}

/// What the panels of one figure have in common; lengths in mm.
struct Stage<'a> {
    input: &'a ShapeInput,
    arrow_per_newton: f64,
    force_name: String,
    plate: f64,
    extent: f64,
}

impl Stage<'_> {
    /// Tails and heads of the force arrows.
    fn forces(&self) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        self.input.poses.iter().flat_map(|p| &p.forces).map(|force| {
            let from = millimetres(&force.point);
            let k = self.arrow_per_newton;
            let f = force.vector;
            (from, [from[0] + k * f[0], from[1] + k * f[1], from[2] + k * f[2]])
        })
    }

    fn panel(&self, view: View) -> Panel {
        let [x, y] = view.labels();
        let mut panel = Panel::new(Axis::new(x, "mm"), Axis::new(y, "mm"));
        panel.equal = true;
        panel.framed = view.axes().is_some();
        panel.own_scale = !panel.framed;
        view.title().clone_into(&mut panel.title);
        self.plate(&mut panel, view);
        let rest_name = if self.input.rest_name.is_empty() { "at rest" } else { &self.input.rest_name };
        for line in &self.input.rest {
            let stroke = Stroke { colour: Colour::DIM, width: 1.2, ..stroke_of(line.part) };
            panel.series.push(Series {
                name: rest_name.to_owned(),
                points: project(view, &line.points),
                line: Some(stroke),
                ..Series::default()
            });
        }
        let last = self.input.poses.len().saturating_sub(1);
        let bare = self.input.poses.iter().flat_map(|p| &p.lines).all(|l| l.part == Part::Centreline);
        for (i, pose) in self.input.poses.iter().enumerate() {
            for line in &pose.lines {
                panel.series.push(Series {
                    name: name_of(line.part),
                    points: project(view, &line.points),
                    line: Some(recoloured(line.part, bare, self.input.colouring, i, last)),
                    ..Series::default()
                });
            }
        }
        self.tips(&mut panel, view);
        self.arrows(&mut panel, view);
        panel
    }

    fn plate(&self, panel: &mut Panel, view: View) {
        let h = self.plate;
        let name = "baseplate".to_owned();
        match view {
            View::Xy | View::Xz => panel.series.push(Series {
                name,
                points: vec![[0.0, -h], [0.0, h]],
                line: Some(Stroke { colour: Colour::rgb(0x80, 0x80, 0x80), width: 4.0, dash: Dash::Solid }),
                ..Series::default()
            }),
            // Seen from the front, the plate would only cover the panel.
            View::Yz => {}
            View::Perspective(_) => {
                let corners = [[-h, -h], [h, -h], [h, h], [-h, h], [-h, -h]];
                panel.series.push(Series {
                    name,
                    points: corners.iter().map(|c| view.project([0.0, c[0], c[1]])).collect(),
                    line: Some(Stroke {
                        colour: Colour::rgb(0x80, 0x80, 0x80),
                        width: 1.0,
                        dash: Dash::Solid,
                    }),
                    fill: Some(Fill { colour: Colour::DIM, opacity: 0.45, to_y: None }),
                    ..Series::default()
                });
            }
        }
    }

    fn tips(&self, panel: &mut Panel, view: View) {
        let mut tips = Vec::new();
        for pose in &self.input.poses {
            let Some(line) = tip_line(pose) else { continue };
            let path = project(view, &line.points);
            let Some(tip) = path.last().copied() else { continue };
            tips.push(tip);
            // In the side views of a spatial robot the same labels would only crowd.
            let shown = !matches!(view, View::Xz) && (panel.framed || self.input.poses.len() > 1);
            let spatial_top = view == View::Xy && self.input.poses.iter().any(out_of_plane);
            if !pose.label.is_empty() && shown && !spatial_top {
                let back = path[path.len() - 1 - (path.len() / 20).clamp(1, path.len() - 1)];
                panel.annotations.push(Annotation::Text {
                    at: tip,
                    text: pose.label.clone(),
                    towards: [tip[0] - back[0], tip[1] - back[1]],
                    size: 10.5,
                    colour: Colour::INK,
                    avoid: true,
                });
            }
        }
        if !tips.is_empty() {
            let marker = Marker { shape: MarkerShape::Circle, size: 5.5, colour: Colour::TIP, filled: true };
            panel.series.push(Series {
                name: tip_name(self.input),
                points: tips,
                marker: Some(marker),
                ..Series::default()
            });
        }
        for marks in &self.input.marks {
            panel.series.push(Series {
                name: marks.name.clone(),
                points: project(view, &marks.points),
                marker: Some(Marker {
                    shape: MarkerShape::Cross,
                    size: 7.0,
                    colour: Colour::rgb(0x1f, 0x5f, 0xd0),
                    filled: false,
                }),
                ..Series::default()
            });
        }
    }

    fn arrows(&self, panel: &mut Panel, view: View) {
        for (from, to) in self.forces() {
            let (a, b) = (view.project(from), view.project(to));
            let towards = view.towards_reader([to[0] - from[0], to[1] - from[1], to[2] - from[2]]);
            if (b[0] - a[0]).hypot(b[1] - a[1]) > 0.02 * self.extent {
                panel.annotations.push(Annotation::Arrow {
                    name: self.force_name.clone(),
                    from: a,
                    to: b,
                    stroke: Stroke { colour: Colour::BLACK, width: 1.8, dash: Dash::Solid },
                });
            } else if towards.abs() > 0.0 {
                let shape = if towards > 0.0 { MarkerShape::Towards } else { MarkerShape::Away };
                panel.series.push(Series {
                    points: vec![a],
                    marker: Some(Marker { shape, size: 11.0, colour: Colour::BLACK, filled: false }),
                    ..Series::default()
                });
            }
        }
    }
}

fn out_of_plane(pose: &Pose) -> bool {
    let size = pose.lines.iter().flat_map(|l| l.points.iter().flatten()).fold(0.0_f64, |m, v| m.max(v.abs()));
    pose.lines.iter().flat_map(|l| &l.points).any(|p| p[2].abs() > PLANAR * size)
}

/// The line that ends at the tip: the centreline, else the leader's, else the first.
fn tip_line(pose: &Pose) -> Option<&Line> {
    let of = |part: Part| pose.lines.iter().find(|l| l.part == part);
    of(Part::Centreline).or_else(|| of(Part::Tube(1))).or(pose.lines.first())
}

fn stroke_of(part: Part) -> Stroke {
    match part {
        Part::Tube(n) => Stroke { width: 1.8, ..tube_stroke(n) },
        // Thin dash-dot is the drawing convention for centrelines.
        Part::Centreline => Stroke { colour: Colour::INK, width: 0.9, dash: Dash::DashDot },
    }
}

/// Legend entry of the tips, which says what stands beside them.
fn tip_name(input: &ShapeInput) -> String {
    if input.label_name.is_empty() { "tip".to_owned() } else { format!("tip with {}", input.label_name) }
}

/// Centrelines are drawn in ink, unless they are all there is (`bare`).
fn recoloured(part: Part, bare: bool, colouring: Colouring, i: usize, last: usize) -> Stroke {
    let stroke = stroke_of(part);
    match colouring {
        Colouring::Alternate if i % 2 == 1 => {
            Stroke { colour: stroke.colour.mix(Colour::WHITE, 0.45), ..stroke }
        }
        Colouring::Pose if (bare || part != Part::Centreline) && last > 0 => {
            Stroke { colour: ramp(count(i) / count(last)), ..stroke }
        }
        _ => stroke,
    }
}

/// Where colour tells the pose, the legend shows the tubes in black, by their dashes.
fn keys(input: &ShapeInput) -> Vec<Key> {
    if input.colouring != Colouring::Pose || input.poses.len() < 2 {
        return Vec::new();
    }
    let parts = input.poses.iter().flat_map(|p| &p.lines).map(|l| l.part);
    parts
        .map(|part| Key {
            name: name_of(part),
            line: Some(Stroke { colour: Colour::INK, ..stroke_of(part) }),
            marker: None,
            fill: None,
            arrow: false,
        })
        .collect()
}

/// `force (0.5 N)`, or the largest of several.
fn force_name(forces: &[[f64; 3]], strongest: f64) -> String {
    if strongest <= 0.0 {
        return String::new();
    }
    let same = forces.iter().all(|f| norm(*f) > strongest * (1.0 - 1e-6));
    let newtons = significant(strongest);
    if same { format!("force ({newtons} N)") } else { format!("force (longest: {newtons} N)") }
}

/// Three significant digits without trailing zeros.
fn significant(v: f64) -> String {
    if !(1e-3..1e5).contains(&v) {
        return format!("{v:.2e}");
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 5")]
    let digits = (2.0 - v.log10().floor()).clamp(0.0, 5.0) as usize;
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Half the width of the plate: beyond the tubes' centroids at the base.
fn plate_half(input: &ShapeInput) -> f64 {
    let lines = input.poses.iter().flat_map(|p| &p.lines).chain(&input.rest);
    let bases = lines.filter_map(|l| l.points.first()).map(millimetres);
    2.0 * bases.map(|p| p[1].hypot(p[2])).fold(0.0, f64::max)
}

fn all_points(input: &ShapeInput) -> impl Iterator<Item = &[f64; 3]> {
    let lines = input.poses.iter().flat_map(|p| &p.lines).chain(&input.rest);
    let points = lines.flat_map(|l| &l.points);
    let marks = input.marks.iter().flat_map(|m| &m.points);
    points.chain(marks).chain(input.poses.iter().flat_map(|p| &p.forces).map(|f| &f.point))
}

fn millimetres(p: &[f64; 3]) -> [f64; 3] {
    p.map(|v| 1e3 * v)
}

fn norm(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}

fn project(view: View, points: &[[f64; 3]]) -> Vec<[f64; 2]> {
    points.iter().map(|p| view.project(millimetres(p))).collect()
}
