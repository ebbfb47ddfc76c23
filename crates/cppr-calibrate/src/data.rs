//! Measurements as CSV.
//!
//! One row per measured point. Columns in any order; the unit is in the name. How columns are separated and numbers written,
//! [`cppr_io::csv_table`] says.
//!
//! | column | meaning | default |
//! |---|---|---|
//! | `robot` | name of the robot, as in its file | the only robot |
//! | `pullK_mm`, `rotateK_deg` | motion of tube K, of the first only where a robot has parts or joints | 0 |
//! | `tensionK_N`, `torqueK_Nmm` | force or torque of its motor, in place of the motion | |
//! | `driven` | `on` or `back`: which way the motors came, where tubes rub | |
//! | `tip_force_x_N`, `_y_`, `_z_` | dead force on the tip | 0 |
//! | `tip_point_x_mm`, `_y_`, `_z_` | where it acts, in the tip's frame | centre of the tip |
//! | `at_mm` | label X of the measured point; of a robot with parts or joints the length of the centreline up to it, or the label on tube K | the tip |
//! | `line` | `centre`, or `tubeK` for the centroid line of tube K | centre |
//! | `x_mm`, `y_mm`, `z_mm` | measured point, base frame; an empty field was not measured | |
//! | `direction_x`, `_y`, `_z` | measured direction of the axis there | |
//! | `bend_deg` | measured angle between the axis there and that at the plate, from 0 to 180 | |
//! | `measured_tensionK_N`, `measured_torqueK_Nmm` | measured force and torque of a motor | |
//! | `sigma_mm`, `sigma_deg` | standard deviation of a coordinate, of a direction or bend | 1 |
//! | `sigma_N`, `sigma_Nmm` | that of a force, of a torque | 0.05, 1 |

use cppr::Vector3;
use cppr::bundle::solve::TubeDrive;
use cppr::solve::{Drive, Freedom, Quantity};
use cppr_io::csv_table::{Row, Table, TableProblem};
use std::fmt;

/// What was measured: the centreline or the centroid line of a tube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// The common centreline.
    Centre,
    /// The centroid line of a tube, index 0 for the leader.
    Tube(usize),
}

/// Which way the motors came to where they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driven {
    /// On, away from rest.
    On,
    /// Back, towards rest.
    Back,
}

/// What a number was measured of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observed {
    /// A coordinate of the point (m): 0 for x.
    Coordinate(usize),
    /// A component of the direction (-).
    Direction(usize),
    /// The angle between the axis at the point and that at the plate (rad).
    Bend,
    /// Force (N) or torque (N m) of the motor of a tube, index 0 for the leader.
    Effort(usize, Freedom),
}

impl fmt::Display for Observed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Coordinate(axis) => write!(f, "{}", AXES[*axis]),
            Self::Direction(_) => write!(f, "direction"),
            Self::Bend => write!(f, "bend"),
            Self::Effort(tube, freedom) => write!(f, "{}{}", Quantity::of(*freedom, false).name, tube + 1),
        }
    }
}

impl Observed {
    /// Unit of its values (SI); components of a direction count as angles.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Coordinate(_) => "m",
            Self::Direction(_) | Self::Bend => "rad",
            Self::Effort(_, freedom) => Quantity::of(freedom, false).unit,
        }
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// One row, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Line of the file, from 1.
    pub row: usize,
    /// Name of the robot; empty for the only one.
    pub robot: String,
    /// Motors of every tube, the leader first.
    pub drives: Vec<TubeDrive>,
    /// Which way they came, where that is known.
    pub driven: Option<Driven>,
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
    /// Measured angle between the axis there and that at the plate (rad).
    pub bend: Option<f64>,
    /// Measured forces (N) and torques (N m) of motors: tube (index from 0), which, value.
    pub efforts: Vec<(usize, Freedom, f64)>,
    /// Standard deviation of a coordinate (m).
    pub sigma: f64,
    /// Standard deviation of the direction and of the bend (rad).
    pub sigma_direction: f64,
    /// Standard deviation of a force (N) and of a torque (N m).
    pub sigma_effort: [f64; 2],
}

impl Measurement {
    /// What was measured, with value and standard deviation.
    #[must_use]
    pub fn numbers(&self) -> Vec<(Observed, f64, f64)> {
        let point = (0..3).map(|axis| (Observed::Coordinate(axis), self.point[axis], self.sigma));
        let mut numbers: Vec<_> = point.filter(|(_, value, _)| !value.is_nan()).collect();
        if let Some(direction) = self.direction {
            numbers.extend((0..3).map(|i| (Observed::Direction(i), direction[i], self.sigma_direction)));
        }
        numbers.extend(self.bend.map(|bend| (Observed::Bend, bend, self.sigma_direction)));
        numbers.extend(self.efforts.iter().map(|&(tube, freedom, value)| {
            let sigma = self.sigma_effort[usize::from(freedom == Freedom::Rotation)];
            (Observed::Effort(tube, freedom), value, sigma)
        }));
        numbers
    }

    /// Was it made of the same robot in the same pose?
    pub(crate) fn is_of_the_pose(&self, other: &Self) -> bool {
        self.robot == other.robot
            && (&self.drives, self.driven, self.tip_force, self.tip_point)
                == (&other.drives, other.driven, other.tip_force, other.tip_point)
    }
}

/// What a column holds.
#[derive(Clone, Copy)]
enum Column {
    Robot,
    Line,
    Driven,
    Drive(usize, Quantity),
    Measured(usize, Freedom),
    Force(usize),
    ForcePoint(usize),
    At,
    Point(usize),
    Direction(usize),
    Bend,
    Sigma,
    SigmaDirection,
    SigmaEffort(Freedom),
}

/// Largest number of a table: longer than any robot in mm, more than any force in N or angle in degrees.
const FURTHEST: f64 = 1e5;

const KNOWN: &str = "robot, pullK_mm, rotateK_deg, tensionK_N, torqueK_Nmm, driven, tip_force_x_N, tip_point_x_mm, at_mm, line, \
     x_mm, y_mm, z_mm, direction_x, bend_deg, measured_tensionK_N, measured_torqueK_Nmm, sigma_mm, sigma_deg, sigma_N, sigma_Nmm";

fn axis(text: &str) -> Option<usize> {
    AXES.iter().position(|a| *a == text)
}

fn column(name: &str) -> Option<Column> {
    let between = |start: &str, end: &str| name.strip_prefix(start)?.strip_suffix(end);
    let tube = |text: &str| text.parse::<usize>().ok().filter(|k| (1..=16).contains(k)).map(|k| k - 1);
    match name {
        "robot" => return Some(Column::Robot),
        "line" => return Some(Column::Line),
        "driven" => return Some(Column::Driven),
        "bend_deg" => return Some(Column::Bend),
        "at_mm" => return Some(Column::At),
        "sigma_mm" => return Some(Column::Sigma),
        "sigma_deg" => return Some(Column::SigmaDirection),
        "sigma_N" => return Some(Column::SigmaEffort(Freedom::PushPull)),
        "sigma_Nmm" => return Some(Column::SigmaEffort(Freedom::Rotation)),
        _ => {}
    }
    let motor = |quantity: Quantity| {
        let unit = format!("_{}", quantity.shown_unit.replace(' ', ""));
        let tube = |start: &str| between(start, &unit).and_then(tube);
        tube(quantity.keyword).map(|k| Column::Drive(k, quantity)).or_else(|| {
            let measured = tube(&format!("measured_{}", quantity.name)).filter(|_| !quantity.is_motion);
            measured.map(|k| Column::Measured(k, quantity.freedom))
        })
    };
    Quantity::ALL
        .into_iter()
        .find_map(motor)
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
            Some(Column::Drive(k, _) | Column::Measured(k, _)) if k >= tubes => {
                problem(head, format!("{name}: the robots have tubes 1 to {tubes}"));
            }
            Some(_) => {}
        }
        columns.push(found);
    }
    let measures = |c: &Column| {
        matches!(c, Column::Point(_) | Column::Direction(_) | Column::Bend | Column::Measured(..))
    };
    if !columns.iter().flatten().any(measures) {
        problem(
            head,
            "nothing is measured: give x_mm, y_mm, z_mm, or direction_x, direction_y, direction_z, or bend_deg, or measured_tension2_N"
                .into(),
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

/// Reads a field of a column of words; none of a column of numbers.
fn word(m: &mut Measurement, column: Column, field: &str) -> Option<Result<(), String>> {
    match column {
        Column::Robot => m.robot = field.into(),
        Column::Line => {
            let tube = field.strip_prefix("tube").and_then(|k| k.parse::<usize>().ok()).filter(|k| *k >= 1);
            m.line = match (field, tube) {
                ("centre", _) => Line::Centre,
                (_, Some(k)) => Line::Tube(k - 1),
                _ => return Some(Err(format!("line is centre or tube1, tube2, …, not {field}"))),
            };
        }
        Column::Driven => {
            m.driven = match field {
                "on" => Some(Driven::On),
                "back" => Some(Driven::Back),
                _ => return Some(Err(format!("driven is on or back, not {field}"))),
            };
        }
        _ => return None,
    }
    Some(Ok(()))
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
        drives: vec![TubeDrive::HELD; tubes],
        driven: None,
        tip_force: Vector3::zeros(),
        tip_point: Vector3::zeros(),
        at: None,
        line: Line::Centre,
        point: Vector3::new(nothing, nothing, nothing),
        direction: None,
        bend: None,
        efforts: Vec::new(),
        sigma: 1e-3,
        sigma_direction: 1_f64.to_radians(),
        sigma_effort: [0.05, 1e-3],
    };
    let mut told: Vec<(usize, Freedom)> = Vec::new();
    let mut direction = Vector3::new(nothing, nothing, nothing);
    let mut wrong = Vec::new();
    for ((field, column), name) in row.fields.iter().zip(columns).zip(head) {
        let Some(column) = column else { continue };
        if field.is_empty() {
            continue;
        }
        if let Some(told) = word(&mut m, *column, field) {
            wrong.extend(told.err());
            continue;
        }
        let number = match field.parse::<f64>() {
            Ok(number) if number.abs() <= FURTHEST => number,
            Ok(number) if number.is_finite() => {
                wrong.push(format!("{name}: {field} is more than any robot meets; check the unit"));
                continue;
            }
            _ => {
                wrong.push(format!("{name}: {field} is not a finite number"));
                continue;
            }
        };
        match *column {
            Column::Drive(k, quantity) if k < tubes => {
                if told.contains(&(k, quantity.freedom)) {
                    let one = Quantity::of(quantity.freedom, !quantity.is_motion).keyword;
                    wrong.push(format!(
                        "{name}: the {one} of tube {} is given as well; leave one empty",
                        k + 1
                    ));
                }
                told.push((k, quantity.freedom));
                let value = number * quantity.shown_size;
                let drive = if quantity.is_motion { Drive::Motion(value) } else { Drive::Effort(value) };
                match quantity.freedom {
                    Freedom::PushPull => m.drives[k].translation = drive,
                    Freedom::Rotation => m.drives[k].rotation = drive,
                }
            }
            Column::Measured(k, freedom) => {
                m.efforts.push((k, freedom, number * Quantity::of(freedom, false).shown_size));
            }
            Column::Bend if (0.0..=180.0).contains(&number) => m.bend = Some(number.to_radians()),
            Column::Bend => wrong.push(format!("{name}: {field} is not between 0 and 180")),
            Column::Force(axis) => m.tip_force[axis] = number,
            Column::ForcePoint(axis) => m.tip_point[axis] = number * 1e-3,
            Column::At => m.at = Some(number * 1e-3),
            Column::Point(axis) => m.point[axis] = number * 1e-3,
            Column::Direction(axis) => direction[axis] = number,
            Column::Sigma if number > 0.0 => m.sigma = number * 1e-3,
            Column::SigmaDirection if number > 0.0 => m.sigma_direction = number.to_radians(),
            Column::SigmaEffort(Freedom::PushPull) if number > 0.0 => m.sigma_effort[0] = number,
            Column::SigmaEffort(Freedom::Rotation) if number > 0.0 => m.sigma_effort[1] = number * 1e-3,
            Column::Sigma | Column::SigmaDirection | Column::SigmaEffort(_) => {
                wrong.push(format!("{name}: {field} is not positive"));
            }
            _ => {}
        }
    }
    let given = direction.iter().filter(|c| c.is_finite()).count();
    if given == 3 && direction.norm() > 0.0 {
        m.direction = Some(direction.normalize());
    } else if given > 0 {
        wrong.push("a direction needs all three components, not all zero".into());
    }
    if m.numbers().is_empty() && wrong.is_empty() {
        wrong.push("nothing is measured in this row".into());
    }
    if wrong.is_empty() { Ok(m) } else { Err(wrong) }
}
