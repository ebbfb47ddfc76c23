//! Figures of results, and the files they go to.

use crate::Failure;
use crate::output;
use cppr::analysis::Shape;
use cppr::solve::{Drive, Equilibrium, Formulation, Solver};
use cppr::statics::{Frame, Loads, RotationMeans, Station, Thread, Wrench};
use cppr::{Matrix3, Vector3};
use cppr_plot::{Figure, Force, Line, Marks, Part, PlotError, Pose, ShapeInput, shape_figure};
use std::path::Path;

/// Format of a figure file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Vector graphics.
    Svg,
    /// Pixels.
    Png,
}

/// Pixels of a PNG per unit of the figure: about 200 dpi.
const PIXELS: f64 = 2.0;

/// By the file's ending.
pub fn format(path: &Path) -> Result<Format, Failure> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => Ok(Format::Svg),
        Some("png") => Ok(Format::Png),
        _ => Err(Failure::Input(format!("{}: figures are written as .svg or .png", path.display()))),
    }
}

/// Draws and writes a figure.
pub fn write(path: &Path, format: Format, figure: &Figure) -> Result<(), Failure> {
    let bytes = match format {
        Format::Svg => figure.to_svg().map(String::into_bytes),
        Format::Png => figure.to_png(PIXELS),
    };
    output::write(path, &bytes.map_err(|e| plot_failure(&e))?)
}

/// What a figure could not show.
pub fn plot_failure(error: &PlotError) -> Failure {
    Failure::Input(format!("the figure cannot be drawn: {error}"))
}

/// Centroid lines and centreline of a shape.
pub fn lines(shape: &Shape) -> Vec<Line> {
    let tubes = shape.sections.first().map_or(0, |s| s.tubes.len());
    let mut lines: Vec<Line> = (0..tubes)
        .map(|t| Line {
            part: Part::Tube(t + 1),
            points: shape.sections.iter().map(|s| s.tubes[t].centroid.into()).collect(),
        })
        .collect();
    lines.push(Line {
        part: Part::Centreline,
        points: shape.sections.iter().map(|s| s.centre.into()).collect(),
    });
    lines
}

/// Sections through which lines are drawn, at least.
const SMOOTH: usize = 201;

/// One pose with its forces, the robot at rest below it.
pub fn shape(solver: &mut Solver, found: &Equilibrium, samples: usize) -> Result<Figure, Failure> {
    draw(solver, found, samples, Vec::new())
}

/// The same with points in it: their name and places (m).
pub fn marked_shape(
    solver: &mut Solver,
    found: &Equilibrium,
    marks: Option<(&str, Vec<[f64; 3]>)>,
) -> Result<Figure, Failure> {
    let marks = marks.map(|(name, points)| Marks { name: name.into(), points }).into_iter().collect();
    draw(solver, found, SMOOTH, marks)
}

fn draw(
    solver: &mut Solver,
    found: &Equilibrium,
    samples: usize,
    marks: Vec<Marks>,
) -> Result<Figure, Failure> {
    let samples = samples.max(SMOOTH);
    let rest = solver.rest();
    let rest = lines(&solver.shape(&rest, samples));
    let pose = lines(&solver.shape(found, samples));
    let input = ShapeInput {
        title: title(found),
        poses: vec![Pose { label: String::new(), lines: pose, forces: forces(solver, found) }],
        rest,
        marks,
        ..ShapeInput::default()
    };
    shape_figure(&input).map_err(|e| plot_failure(&e))
}

/// Concentrated forces where they act.
fn forces(solver: &mut Solver, found: &Equilibrium) -> Vec<Force> {
    // What is spread along the robot has no arrow.
    let Loads { wrenches, threads, distributed: _, gravity: _ } = &found.command().loads;
    let mut labels: Vec<f64> = wrenches
        .iter()
        .map(|w| match w.station {
            Station::Tip => found.robot().length(),
            Station::Label(label) => label,
        })
        .collect();
    labels.push(found.robot().length());
    let sections = solver.shape_at(found, &labels).sections;
    let wrenches = wrenches
        .iter()
        .zip(&sections)
        .map(|(w, section)| wrench_arrow(w, &section.centre, &section.rotation));
    let threads = threads
        .iter()
        .zip(sections.last().into_iter().cycle())
        .map(|(thread, tip)| thread_arrow(thread, &tip.centre, &tip.rotation));
    wrenches.chain(threads).flatten().collect()
}

/// The force of a wrench at a section with this centre and frame; a pure moment has no arrow.
pub fn wrench_arrow(wrench: &Wrench, centre: &Vector3<f64>, rotation: &Matrix3<f64>) -> Option<Force> {
    let vector = match wrench.frame {
        Frame::World => wrench.force,
        Frame::Section => rotation * wrench.force,
    };
    let point = centre + rotation * wrench.point;
    (vector.norm() > 0.0).then(|| Force { point: point.into(), vector: vector.into() })
}

/// The force of a thread on a tip with this centre and frame.
pub fn thread_arrow(thread: &Thread, centre: &Vector3<f64>, rotation: &Matrix3<f64>) -> Option<Force> {
    let knot = centre + rotation * thread.point;
    let way = thread.pulley - knot;
    let distance = way.norm().max(f64::MIN_POSITIVE);
    // The thread touches the pulley beside its centre.
    let angle = (thread.radius / distance).min(1.0).asin() * if thread.left { 1.0 } else { -1.0 };
    let (s, c) = angle.sin_cos();
    let turned = Vector3::new(c * way.x - s * way.y, s * way.x + c * way.y, way.z);
    let vector = turned * (thread.tension / distance);
    (vector.norm() > 0.0).then(|| Force { point: knot.into(), vector: vector.into() })
}

/// Name, actuation, and the formulation where it is not the consistent one.
pub fn title(found: &Equilibrium) -> String {
    let mut parts = vec![found.robot().design().name.clone()];
    let rotation_means = match found.command().rotation_means {
        RotationMeans::Base => "Ω",
        RotationMeans::RelativeAngle => "−Δθ",
    };
    for (drive, (tube, state)) in found.command().actuators.iter().zip(found.followers()) {
        parts.push(match drive.push_pull {
            Drive::Motion(_) => format!("Δa_{{{tube}}} = {} mm", number(state.motion * 1e3)),
            Drive::Effort(_) => format!("T_{{{tube}}} = {} N", number(state.tension)),
        });
        match drive.rotation {
            Drive::Motion(angle) if angle.abs() <= 0.0 => {}
            Drive::Motion(_) => {
                parts.push(format!("{rotation_means}_{{{tube}}} = {}°", number(state.rotation.to_degrees())));
            }
            Drive::Effort(_) => parts.push(format!("Υ_{{{tube}}} = {} N mm", number(state.torque * 1e3))),
        }
    }
    if found.settings().formulation == Formulation::Printed {
        parts.push("as printed".into());
    }
    parts.join(", ")
}

/// At most four significant digits and four decimals, and a minus sign that is one.
pub fn number(value: f64) -> String {
    let whole = value.abs().max(1.0).log10().floor();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped between 0 and 4")]
    let digits = (3.0 - whole).clamp(0.0, 4.0) as usize;
    let text = format!("{value:.digits$}");
    let short = if digits > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".into() } else { short.replace('-', "−") }
}
