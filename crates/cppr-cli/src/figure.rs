//! Figures of results, and the files they go to.

use crate::Failure;
use crate::output;
use cppr::analysis::Shape;
use cppr::design::Robot;
use cppr::solve::{Drive, Equilibrium};
use cppr::statics::{Frame, Station};
use cppr_plot::{Figure, Force, Line, Part, PlotError, Pose, ShapeInput, shape_figure};
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

/// One pose with its forces, the robot at rest below it.
pub fn shape(robot: &Robot, found: &Equilibrium, shape: &Shape, rest: &Shape) -> Result<Figure, Failure> {
    let mut forces = Vec::new();
    let nearest = |label: f64| {
        shape.sections.iter().min_by(|a, b| (a.label - label).abs().total_cmp(&(b.label - label).abs()))
    };
    for wrench in &found.command.loads.wrenches {
        let label = match wrench.station {
            Station::Tip => robot.length(),
            Station::Label(label) => label,
        };
        if let Some(section) = nearest(label) {
            let vector = match wrench.frame {
                Frame::World => wrench.force,
                Frame::Section => section.rotation * wrench.force,
            };
            let point = section.centre + section.rotation * wrench.point;
            forces.push(Force { point: point.into(), vector: vector.into() });
        }
    }
    for thread in &found.command.loads.threads {
        if let Some(tip) = shape.sections.last() {
            let point = tip.centre + tip.rotation * thread.point;
            let way = thread.pulley - point;
            let vector = way * (thread.tension / way.norm().max(f64::MIN_POSITIVE));
            forces.push(Force { point: point.into(), vector: vector.into() });
        }
    }
    let input = ShapeInput {
        title: title(robot, found),
        poses: vec![Pose { label: String::new(), lines: lines(shape), forces }],
        rest: lines(rest),
        ..ShapeInput::default()
    };
    shape_figure(&input).map_err(|e| plot_failure(&e))
}

/// Name and actuation.
fn title(robot: &Robot, found: &Equilibrium) -> String {
    let mut parts = vec![robot.design().name.clone()];
    for (f, (drive, state)) in found.command.actuators.iter().zip(&found.actuators).enumerate() {
        let tube = f + 2;
        match drive.push_pull {
            Drive::Motion(_) => parts.push(format!("Δa_{{{tube}}} = {:.4} mm", state.motion * 1e3)),
            Drive::Effort(_) => parts.push(format!("T_{{{tube}}} = {:.4} N", state.tension)),
        }
        match drive.rotation {
            Drive::Motion(angle) if angle.abs() <= 0.0 => {}
            Drive::Motion(_) => parts.push(format!("Ω_{{{tube}}} = {:.4}°", state.rotation.to_degrees())),
            Drive::Effort(_) => parts.push(format!("Υ_{{{tube}}} = {:.4} N mm", state.torque * 1e3)),
        }
    }
    parts.iter().map(|p| trim_zeros(p)).collect::<Vec<_>>().join(", ")
}

/// "5.0000 mm" reads better as "5 mm".
fn trim_zeros(text: &str) -> String {
    let Some(dot) = text.find('.') else { return text.into() };
    let digits = text[dot + 1..].chars().take_while(char::is_ascii_digit).count();
    if digits < 4 {
        return text.into();
    }
    let (number, rest) = text.split_at(dot + 1 + digits);
    format!("{}{rest}", number.trim_end_matches('0').trim_end_matches('.'))
}
