//! The test bench: robots of the paper, solved in either formulation.

use crate::PaperError;
use cppr::analysis::Shape;
use cppr::design::{Robot, RobotDesign, TubeDesign};
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Equilibrium, Formulation, Settings, Solver, Status};
use cppr_plot::{Colouring, Figure, Line, Part, Pose, ShapeInput, shape_figure};

/// Sections along a drawn line.
const SAMPLES: usize = 61;
/// The paper's modes in space: three per curvature, two per angle.
pub const PAPER_SPACE: Resolution =
    Resolution { twist: 2, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 12 };

const FILES: [(&str, &str); 7] = [
    ("r1", include_str!("../robots/r1.toml")),
    ("r2", include_str!("../robots/r2.toml")),
    ("r3", include_str!("../robots/r3.toml")),
    ("r4", include_str!("../robots/r4.toml")),
    ("childs2", include_str!("../robots/childs2.toml")),
    ("childs3", include_str!("../robots/childs3.toml")),
    ("helicoid", include_str!("../robots/helicoid.toml")),
];

/// Design of a shipped robot.
pub fn design(name: &str) -> Result<RobotDesign, PaperError> {
    let (_, text) = FILES
        .iter()
        .find(|(file, _)| *file == name)
        .ok_or_else(|| PaperError(format!("there is no robot {name}")))?;
    Ok(cppr_io::robot_file::parse(text).map_err(|p| PaperError(p.to_string()))?.design)
}

/// A robot from a design that was changed.
pub fn build(design: RobotDesign) -> Result<Robot, PaperError> {
    Robot::from_design(design).map_err(|problems| PaperError(problems.to_string()))
}

/// A shipped robot.
pub fn robot(name: &str) -> Result<Robot, PaperError> {
    build(design(name)?)
}

/// The design with another factor on all centroid offsets.
pub fn with_factor(mut design: RobotDesign, factor: f64) -> RobotDesign {
    for tube in &mut design.tubes {
        match tube {
            TubeDesign::Notched(t) => t.centroid_offset_factor = factor,
            TubeDesign::Stiffness(t) => t.centroid_offset_factor = factor,
        }
    }
    design
}

/// Consistent formulation, converged.
pub fn consistent() -> Settings {
    Settings::default()
}

/// Printed formulation in the plane with the paper's five modes.
pub fn printed_plane() -> Settings {
    Settings { formulation: Formulation::Printed, ..Settings::planar() }
}

/// Printed formulation in space with the paper's modes.
pub fn printed_space() -> Settings {
    Settings { formulation: Formulation::Printed, ..Settings::default().with_resolution(PAPER_SPACE) }
}

/// One solved state.
pub struct Solved {
    pub found: Equilibrium,
    pub shape: Shape,
    pub margin: Option<f64>,
}

impl Solved {
    /// Centroid of tube 1 at the tip (mm): what the paper plots.
    pub fn tip_mm(&self) -> [f64; 3] {
        self.shape.sections.last().map_or([0.0; 3], |s| (s.tubes[0].centroid * 1e3).into())
    }

    /// Centre of the tip section (mm).
    pub fn centre_mm(&self) -> [f64; 3] {
        self.shape.sections.last().map_or([0.0; 3], |s| (s.centre * 1e3).into())
    }

    /// T of follower 2 (N).
    pub fn tension(&self) -> f64 {
        self.found.actuators()[0].tension
    }

    /// As lines of a figure.
    pub fn pose(&self, label: String) -> Pose {
        Pose { label, lines: lines(&self.shape, true), forces: Vec::new() }
    }
}

/// Solves a command; no equilibrium is an error that names it.
pub fn solved(robot: &Robot, command: &Command, settings: &Settings) -> Result<Solved, PaperError> {
    solved_from(robot, command, settings, None)
}

/// The same from a neighbour.
pub fn solved_from(
    robot: &Robot,
    command: &Command,
    settings: &Settings,
    start: Option<&Equilibrium>,
) -> Result<Solved, PaperError> {
    let mut solver = Solver::with_settings(robot, *settings).map_err(|e| PaperError(e.to_string()))?;
    let found = match start {
        Some(start) => solver.solve_from(command, start),
        None => solver.solve(command),
    };
    let found = found.map_err(|e| PaperError(e.to_string()))?;
    if let Status::NotConverged(_) = found.status() {
        return Err(PaperError(format!("{}: {}", robot.design().name, found.status())));
    }
    let shape = solver.shape(&found, SAMPLES);
    let margin = solver.stability(&found).map(|s| s.margin);
    Ok(Solved { found, shape, margin })
}

/// Pulled by Δa (mm) and turned by Ω (deg).
pub fn actuated(pull_mm: f64, rotation_deg: f64) -> Command {
    let actuator = Actuator {
        push_pull: Drive::Motion(pull_mm * 1e-3),
        rotation: Drive::Motion(rotation_deg.to_radians()),
    };
    Command { actuators: vec![actuator], ..Command::pull(&[]) }
}

/// Pulled by Δa (mm), followed from rest in steps of about 1 mm: stays on one branch where there are several.
pub fn followed(robot: &Robot, pull: f64, settings: &Settings) -> Result<Solved, PaperError> {
    let steps = pull.abs().ceil().max(1.0);
    let mut state = solved(robot, &actuated(pull / steps, 0.0), settings)?;
    let mut at = 1.0;
    while at < steps {
        at += 1.0;
        state = solved_from(robot, &actuated(pull * at / steps, 0.0), settings, Some(&state.found))?;
    }
    Ok(state)
}

/// Centroid lines of a shape, with the centreline where wanted.
pub fn lines(shape: &Shape, tubes_only: bool) -> Vec<Line> {
    let count = shape.sections.first().map_or(0, |s| s.tubes.len());
    let mut lines: Vec<Line> = (0..count)
        .map(|t| Line {
            part: Part::Tube(t + 1),
            points: shape.sections.iter().map(|s| s.tubes[t].centroid.into()).collect(),
        })
        .collect();
    if !tubes_only {
        lines.push(centreline(shape));
    }
    lines
}

/// The centreline of a shape.
pub fn centreline(shape: &Shape) -> Line {
    Line { part: Part::Centreline, points: shape.sections.iter().map(|s| s.centre.into()).collect() }
}

/// A figure of several poses.
pub fn family(
    title: impl Into<String>,
    poses: Vec<Pose>,
    label_name: &str,
    colouring: Colouring,
) -> Result<Figure, PaperError> {
    let (title, label_name) = (title.into(), label_name.into());
    let input = ShapeInput { title, poses, label_name, colouring, ..ShapeInput::default() };
    Ok(shape_figure(&input)?)
}

/// A figure of several poses over the unloaded shapes at the same motions.
pub fn loaded_family(title: String, poses: Vec<Pose>, unloaded: Vec<Line>) -> Result<Figure, PaperError> {
    let (label_name, rest_name) = ("Δa (mm)".into(), "without load".into());
    let input = ShapeInput { title, poses, label_name, rest: unloaded, rest_name, ..ShapeInput::default() };
    Ok(shape_figure(&input)?)
}

/// Distance of two points (mm).
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
