//! What a figure of shapes is made from: poses, lines, forces. Lengths in m, forces in N.

use crate::error::{PlotError, check_values};

/// What [`shape_figure`](crate::shape_figure) draws.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeInput {
    /// Short title; may be empty.
    pub title: String,
    /// Poses, later ones above earlier ones.
    pub poses: Vec<Pose>,
    /// What the poses' labels are, with their unit, for the legend; may be empty.
    pub label_name: String,
    /// The robot at rest, drawn dimmed below all poses; may be empty.
    pub rest: Vec<Line>,
    /// What the dimmed lines are, for the legend; empty for `at rest`.
    pub rest_name: String,
    /// Further points, for example measured tips.
    pub marks: Vec<Marks>,
    /// What colours mean.
    pub colouring: Colouring,
}

/// One pose of the robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pose {
    /// Short text beside the tip, for example the actuation in the unit that [`ShapeInput::label_name`] gives; may be empty.
    pub label: String,
    /// Centroid lines and centreline.
    pub lines: Vec<Line>,
    /// Forces, drawn as arrows whose lengths compare within the figure.
    pub forces: Vec<Force>,
}

/// A line of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// What the line belongs to.
    pub part: Part,
    /// Points from base to tip, m.
    pub points: Vec<[f64; 3]>,
}

/// What a line belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Centroid line of a tube; the leader has number 1.
    Tube(usize),
    /// Centreline of the robot.
    Centreline,
}

/// A force on the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// Point of application, m.
    pub point: [f64; 3],
    /// Force, N.
    pub vector: [f64; 3],
}

/// Points drawn as crosses.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Marks {
    /// Legend entry.
    pub name: String,
    /// Points, m.
    pub points: Vec<[f64; 3]>,
}

/// What colours mean in a figure of several poses. Dashes always tell the tubes apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colouring {
    /// Each tube has its colour.
    #[default]
    Tube,
    /// As `Tube`, every other pose paler.
    Alternate,
    /// Each pose has its colour, from dark (first) to light (last).
    Pose,
}

/// Legend entry of a line.
pub(crate) fn name_of(part: Part) -> String {
    match part {
        Part::Tube(n) => format!("tube {n}"),
        Part::Centreline => "centreline".to_owned(),
    }
}

/// Refuses what cannot be drawn.
pub(crate) fn check(input: &ShapeInput) -> Result<(), PlotError> {
    if input.poses.is_empty() && input.rest.is_empty() {
        return Err(PlotError::Empty { what: "the list of poses".to_owned() });
    }
    let check_line = |owner: &str, line: &Line| {
        let what = format!("{owner}, {}", name_of(line.part));
        match (line.part, line.points.len()) {
            (Part::Tube(0), _) => Err(PlotError::TubeZero { what }),
            (_, 0) => Err(PlotError::Empty { what }),
            (_, 1) => Err(PlotError::SinglePoint { what }),
            _ => check_values(&what, line.points.iter().map(<[f64; 3]>::as_slice)),
        }
    };
    for (i, pose) in input.poses.iter().enumerate() {
        let owner = format!("pose {}", i + 1);
        if pose.lines.is_empty() {
            return Err(PlotError::Empty { what: owner });
        }
        for line in &pose.lines {
            check_line(&owner, line)?;
        }
        let rows = pose.forces.iter().flat_map(|f| [f.point.as_slice(), f.vector.as_slice()]);
        check_values(&format!("{owner}, forces (points and vectors)"), rows)?;
    }
    for line in &input.rest {
        check_line("at rest", line)?;
    }
    for marks in &input.marks {
        let what = format!("marks '{}'", marks.name);
        if marks.points.is_empty() {
            return Err(PlotError::Empty { what });
        }
        check_values(&what, marks.points.iter().map(<[f64; 3]>::as_slice))?;
    }
    Ok(())
}
