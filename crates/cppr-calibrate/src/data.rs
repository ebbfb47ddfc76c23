//! Measurements as CSV.
//!
//! One row per measured point. Columns in any order; the unit is in the name. How columns are separated and numbers written,
//! [`cppr_io::csv_table`] says.
//!
//! | column | meaning | default |
//! |---|---|---|
//! | `robot` | name of the robot, as in its file | the only robot |
//! | `pullK_mm`, `rotateK_deg` | motion of tube K, of the first only where a robot has parts or joints | 0 |
//! | `tip_force_x_N`, `_y_`, `_z_` | dead force on the tip | 0 |
//! | `tip_point_x_mm`, `_y_`, `_z_` | where it acts, in the tip's frame | centre of the tip |
//! | `at_mm` | label X of the measured point; of a robot with parts or joints the length of the centreline up to it, or the label on tube K | the tip |
//! | `line` | `centre`, or `tubeK` for the centroid line of tube K | centre |
//! | `x_mm`, `y_mm`, `z_mm` | measured point, base frame; an empty field was not measured | |
//! | `direction_x`, `_y`, `_z` | measured direction of the axis there | |
//! | `sigma_mm`, `sigma_deg` | standard deviation of a coordinate, of a direction | 1 |

use cppr::Vector3;
use cppr_io::csv_table::{Row, Table, TableProblem};

/// What was measured: the centreline or the centroid line of a tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// The common centreline.
    Centre,
    /// The centroid line of a tube, index 0 for the leader.
    Tube(usize),
}

/// One row, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Line of the file, from 1.
    pub row: usize,
    /// Name of the robot; empty for the only one.
    pub robot: String,
    /// Translation of every tube, the leader first (m).
    pub pulls: Vec<f64>,
    /// Rotation of every tube (rad).
    pub rotations: Vec<f64>,
    /// Dead tip force (N).
    pub tip_force: Vector3<f64>,
    /// Its point of action in the tip frame (m).
    pub tip_point: Vector3<f64>,
    /// Label of the measured point, or of a bundle the length of the centreline up to it (m); `None` is the tip.
    pub at: Option<f64>,
    /// Line that the point lies on.
    pub line: Line,
    /// Measured coordinates (m), NaN where not measured.
    pub point: Vector3<f64>,
    /// Measured direction, normalised.
    pub direction: Option<Vector3<f64>>,
    /// Standard deviation of a coordinate (m).
    pub sigma: f64,
    /// Standard deviation of the direction (rad).
    pub sigma_direction: f64,
}

/// What a column holds.
#[derive(Clone, Copy)]
enum Column {
    Robot,
    Line,
    Pull(usize),
    Rotate(usize),
    Force(usize),
    ForcePoint(usize),
    At,
    Point(usize),
    Direction(usize),
    Sigma,
    SigmaDirection,
}

/// Largest number of a table: longer than any robot in mm, more than any force in N or angle in degrees.
const FURTHEST: f64 = 1e5;

const KNOWN: &str = "robot, pullK_mm, rotateK_deg, tip_force_x_N, tip_point_x_mm, at_mm, line, x_mm, y_mm, z_mm, \
     direction_x, sigma_mm, sigma_deg";

fn axis(text: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|a| *a == text)
}

fn column(name: &str) -> Option<Column> {
    let between = |start: &str, end: &str| name.strip_prefix(start)?.strip_suffix(end);
    let tube = |text: &str| text.parse::<usize>().ok().filter(|k| (1..=16).contains(k)).map(|k| k - 1);
    match name {
        "robot" => return Some(Column::Robot),
        "line" => return Some(Column::Line),
        "at_mm" => return Some(Column::At),
        "sigma_mm" => return Some(Column::Sigma),
        "sigma_deg" => return Some(Column::SigmaDirection),
        _ => {}
    }
    between("pull", "_mm")
        .and_then(tube)
        .map(Column::Pull)
        .or_else(|| between("rotate", "_deg").and_then(tube).map(Column::Rotate))
        .or_else(|| between("tip_force_", "_N").and_then(axis).map(Column::Force))
        .or_else(|| between("tip_point_", "_mm").and_then(axis).map(Column::ForcePoint))
        .or_else(|| name.strip_prefix("direction_").and_then(axis).map(Column::Direction))
        .or_else(|| name.strip_suffix("_mm").and_then(axis).map(Column::Point))
}

/// Reads measurements; `tubes` is the largest number of tubes among the robots.
///
/// # Errors
/// Every problem of the file.
pub fn read(text: &str, tubes: usize) -> Result<Vec<Measurement>, Vec<TableProblem>> {
    let (table, mut problems) = Table::parse(text);
    let mut problem = |line: usize, message: String| problems.push(TableProblem { line, message });
    let head = table.head.line;
    let mut columns = Vec::new();
    for name in &table.head.fields {
        let found = column(name);
        match found {
            None => problem(head, format!("there is no column {name}; known are {KNOWN}")),
            Some(Column::Pull(k) | Column::Rotate(k)) if k >= tubes => {
                problem(head, format!("{name}: the robots have tubes 1 to {tubes}"));
            }
            Some(_) => {}
        }
        columns.push(found);
    }
    if !columns.iter().any(|c| matches!(c, Some(Column::Point(_) | Column::Direction(_)))) {
        problem(
            head,
            "nothing is measured: give x_mm, y_mm, z_mm or direction_x, direction_y, direction_z".into(),
        );
    }
    let mut list = Vec::new();
    for row in &table.rows {
        match measurement(row, &columns, &table.head.fields, tubes) {
            Ok(measurement) => list.push(measurement),
            Err(messages) => messages.into_iter().for_each(|m| problem(row.line, m)),
        }
    }
    if list.is_empty() && problems.is_empty() {
        let message = "there are no measurements below the head".into();
        problems.push(TableProblem { line: head, message });
    }
    if problems.is_empty() { Ok(list) } else { Err(problems) }
}

fn measurement(
    row: &Row,
    columns: &[Option<Column>],
    head: &[String],
    tubes: usize,
) -> Result<Measurement, Vec<String>> {
    let nothing = f64::NAN;
    let mut m = Measurement {
        row: row.line,
        robot: String::new(),
        pulls: vec![0.0; tubes],
        rotations: vec![0.0; tubes],
        tip_force: Vector3::zeros(),
        tip_point: Vector3::zeros(),
        at: None,
        line: Line::Centre,
        point: Vector3::new(nothing, nothing, nothing),
        direction: None,
        sigma: 1e-3,
        sigma_direction: 1_f64.to_radians(),
    };
    let mut direction = Vector3::new(nothing, nothing, nothing);
    let mut wrong = Vec::new();
    for ((field, column), name) in row.fields.iter().zip(columns).zip(head) {
        let Some(column) = column else { continue };
        if field.is_empty() {
            continue;
        }
        let number = match column {
            Column::Robot => {
                m.robot.clone_from(field);
                continue;
            }
            Column::Line => {
                let tube =
                    field.strip_prefix("tube").and_then(|k| k.parse::<usize>().ok()).filter(|k| *k >= 1);
                match (field.as_str(), tube) {
                    ("centre", _) => m.line = Line::Centre,
                    (_, Some(k)) => m.line = Line::Tube(k - 1),
                    _ => wrong.push(format!("line is centre or tube1, tube2, …, not {field}")),
                }
                continue;
            }
            _ => match field.parse::<f64>() {
                Ok(number) if number.abs() <= FURTHEST => number,
                Ok(number) if number.is_finite() => {
                    wrong.push(format!("{name}: {field} is more than any robot meets; check the unit"));
                    continue;
                }
                _ => {
                    wrong.push(format!("{name}: {field} is not a finite number"));
                    continue;
                }
            },
        };
        match *column {
            Column::Pull(k) if k < tubes => m.pulls[k] = number * 1e-3,
            Column::Rotate(k) if k < tubes => m.rotations[k] = number.to_radians(),
            Column::Force(axis) => m.tip_force[axis] = number,
            Column::ForcePoint(axis) => m.tip_point[axis] = number * 1e-3,
            Column::At => m.at = Some(number * 1e-3),
            Column::Point(axis) => m.point[axis] = number * 1e-3,
            Column::Direction(axis) => direction[axis] = number,
            Column::Sigma if number > 0.0 => m.sigma = number * 1e-3,
            Column::SigmaDirection if number > 0.0 => m.sigma_direction = number.to_radians(),
            Column::Sigma | Column::SigmaDirection => wrong.push(format!("{name}: {field} is not positive")),
            _ => {}
        }
    }
    let given = direction.iter().filter(|c| c.is_finite()).count();
    if given == 3 && direction.norm() > 0.0 {
        m.direction = Some(direction.normalize());
    } else if given > 0 {
        wrong.push("a direction needs all three components, not all zero".into());
    }
    if m.direction.is_none() && m.point.iter().all(|c| c.is_nan()) && wrong.is_empty() {
        wrong.push("nothing is measured in this row".into());
    }
    if wrong.is_empty() { Ok(m) } else { Err(wrong) }
}
