//! What is asked of a sweep.

use crate::axis::{Axis, Variable};
use crate::chunking::Chunking;
use crate::halton::Halton;
use crate::table::{Column, ColumnKind};
use cppr::analysis::Teeth;
use cppr::bundle::solve::BundleCommand;
use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::design::Robot;
use cppr::solve::{Command, Quantity, Settings};
use cppr::statics::Loads;
use std::ops::Range;

/// Motions and efforts of an actuator, in the order of their columns.
pub(crate) const STATE: [Quantity; 4] =
    [Quantity::PULL, Quantity::ROTATION, Quantity::TENSION, Quantity::TORQUE];

/// Most poses of one task: a thousand million rows are some 200 GB.
pub const MOST_POSES: u64 = 1_000_000_000;

/// Which combinations of the axes' values are solved.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// All; the last axis varies fastest.
    Grid,
    /// Scrambled Halton points, mapped through the quantiles of each axis.
    Samples {
        /// How many.
        count: u64,
        /// Same seed, same samples.
        seed: u64,
    },
    /// These: row after row, one value per axis (SI; a design key's own unit).
    List(Vec<f64>),
}

/// A robot of tubes of one length, joined at the tip.
#[derive(Clone, Debug)]
pub struct RobotSubject {
    /// The robot as its file says.
    pub robot: Robot,
    /// What all poses have in common.
    pub base: Command,
    /// How to solve.
    pub settings: Settings,
}

/// A robot with parts or joints.
#[derive(Clone, Debug)]
pub struct BundleSubject {
    /// The robot as its file says.
    pub bundle: Bundle,
    /// What it is made of.
    pub design: BundleDesign,
    /// What all poses have in common.
    pub base: BundleCommand,
    /// Are the tubes' centroid lines extensible?
    pub stretch: bool,
}

/// What a sweep is of.
#[derive(Clone, Debug)]
pub enum Subject {
    /// Tubes of one length, joined at the tip.
    Robot(Box<RobotSubject>),
    /// Anything else.
    Bundle(Box<BundleSubject>),
}

/// A sweep of a robot.
#[derive(Clone, Debug)]
pub struct Task {
    /// The robot, and what all poses have in common.
    pub subject: Subject,
    /// The text of its file; may be empty where no axis varies the design.
    pub robot_text: String,
    /// What varies, slowest first.
    pub axes: Vec<Axis>,
    /// Which poses.
    pub plan: Plan,
    /// Compute the margin to instability of every pose; not for bundles.
    pub margin: bool,
    /// Compute strain and closure of every notch, the teeth as given.
    pub limits: Option<Teeth>,
    /// Compute the equilibria with full slip, of motors driven on and of motors driven back; for bundles alone.
    pub friction: Option<Friction>,
}

/// The two ways of full slip, as their columns begin.
pub(crate) const SLIP: [&str; 2] = ["loading", "unloading"];

impl Task {
    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &str {
        match &self.subject {
            Subject::Robot(own) => &own.robot.design().name,
            Subject::Bundle(own) => &own.design.name,
        }
    }

    /// Length of the robot, of the longest tube of a bundle (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        match &self.subject {
            Subject::Robot(own) => own.robot.length(),
            Subject::Bundle(own) => own.bundle.length(),
        }
    }

    /// Loads that all poses have in common.
    #[must_use]
    pub fn loads(&self) -> &Loads {
        match &self.subject {
            Subject::Robot(own) => &own.base.loads,
            Subject::Bundle(own) => &own.base.loads,
        }
    }

    /// The columns: inputs, status, tip, bend, of a bundle the length of its centreline, actuators, energy, margin and limits where asked for, of a
    /// bundle tip and actuators under full slip where friction is given, and the estimated error, Newton steps.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let number = |name: String| Column { name, kind: ColumnKind::Number };
        let mut columns: Vec<Column> =
            self.axes.iter().map(|axis| number(axis.variable.column(self.loads()))).collect();
        columns.push(Column { name: "status".into(), kind: ColumnKind::Status });
        let tip = ["tip_x_m", "tip_y_m", "tip_z_m", "tip_qw", "tip_qx", "tip_qy", "tip_qz"];
        columns.extend(tip.map(|name| number(name.into())));
        columns.push(number("bend_angle_rad".into()));
        let tubes = match &self.subject {
            Subject::Robot(own) => own.robot.followers(),
            Subject::Bundle(own) => {
                columns.push(number("length_m".into()));
                1..=own.design.tubes.len()
            }
        };
        for tube in tubes {
            let own = STATE.map(|quantity| number(format!("tube{tube}_{}", quantity.column())));
            columns.extend(own);
        }
        if let Subject::Robot(_) = self.subject {
            columns.push(number("elastic_energy_J".into()));
        }
        if self.margin {
            columns.push(number("margin_to_instability".into()));
        }
        if self.limits.is_some() {
            for limit in ["strain", "closure", "torsion"] {
                let count = |what: &str| Column { name: format!("{limit}_{what}"), kind: ColumnKind::Count };
                columns.push(number(format!("{limit}_utilisation")));
                columns.extend([count("tube"), count("notch"), number(format!("{limit}_x_m"))]);
            }
        }
        if let (Subject::Bundle(own), Some(_)) = (&self.subject, self.friction) {
            for way in SLIP {
                columns.extend(["x", "y", "z"].map(|axis| number(format!("{way}_tip_{axis}_m"))));
                for tube in 1..=own.design.tubes.len() {
                    let own = STATE.map(|quantity| number(format!("{way}_tube{tube}_{}", quantity.column())));
                    columns.extend(own);
                }
            }
        }
        if let Subject::Bundle(_) = self.subject {
            columns.push(number("tip_error_m".into()));
        }
        columns.push(Column { name: "newton_steps".into(), kind: ColumnKind::Count });
        columns
    }

    /// Rows in all; saturates where they are beyond counting.
    #[must_use]
    pub fn rows(&self) -> u64 {
        match &self.plan {
            Plan::Grid => self.axes.iter().fold(1, |n: u64, axis| n.saturating_mul(axis.values.count())),
            Plan::Samples { count, .. } => *count,
            Plan::List(values) => (values.len() / self.axes.len().max(1)) as u64,
        }
    }

    /// Chunks in all. Check the task first.
    #[must_use]
    pub fn chunks(&self) -> u64 {
        self.chunking().chunks
    }

    pub(crate) fn chunking(&self) -> Chunking {
        match self.plan {
            Plan::Grid => {
                Chunking::new(&self.axes.iter().map(|axis| axis.values.count()).collect::<Vec<_>>())
            }
            _ => Chunking::new(&[self.rows()]),
        }
    }

    pub(crate) fn varies_design(&self) -> bool {
        self.axes.iter().any(|axis| matches!(axis.variable, Variable::Design(_)))
    }
}

/// Reads the inputs of rows.
pub(crate) struct Inputs<'a> {
    task: &'a Task,
    chunking: &'a Chunking,
    halton: Option<Halton>,
    digits: Vec<u64>,
}

impl<'a> Inputs<'a> {
    pub fn new(task: &'a Task, chunking: &'a Chunking) -> Self {
        let halton = match task.plan {
            Plan::Samples { seed, .. } => Some(Halton::new(task.axes.len(), seed)),
            _ => None,
        };
        Self { task, chunking, halton, digits: vec![0; task.axes.len()] }
    }

    /// In which order the rows of a chunk are solved, counted from its first: neighbours follow each other.
    // A chunk has few rows.
    #[allow(clippy::cast_possible_truncation)]
    pub fn path(&self, chunk: u64) -> Vec<usize> {
        let rows = self.chunking.rows_of(chunk);
        let count = rows.end - rows.start;
        match (&self.task.plan, &self.halton) {
            (Plan::List(_), _) => (0..count as usize).collect(),
            (_, Some(halton)) => self.strips(halton, rows),
            _ => (0..count).map(|turn| self.chunking.turn(chunk, turn) as usize).collect(),
        }
    }

    /// Samples strip by strip: all axes but the last are cut into as many pieces as leave some samples to each strip, and
    /// traversed like a grid.
    fn strips(&self, halton: &Halton, rows: Range<u64>) -> Vec<usize> {
        let axes = self.task.axes.len();
        let pieces = ((rows.end - rows.start) as f64).powf(1.0 / axes as f64).ceil();
        let mut path: Vec<(f64, f64, u64)> = rows
            .clone()
            .map(|row| {
                let (mut strip, mut odd) = (0.0, false);
                let reflected = |u: f64, odd: bool| if odd { 1.0 - u } else { u };
                for axis in 0..axes - 1 {
                    let piece = (reflected(halton.at(row, axis), odd) * pieces).floor();
                    strip = strip * pieces + piece;
                    odd = strip % 2.0 > 0.5;
                }
                (strip, reflected(halton.at(row, axes - 1), odd), row - rows.start)
            })
            .collect();
        path.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        #[allow(clippy::cast_possible_truncation)]
        path.into_iter().map(|(_, _, row)| row as usize).collect()
    }

    /// Values of all axes in a row.
    pub fn of(&mut self, row: u64, values: &mut [f64]) {
        let axes = &self.task.axes;
        match (&self.task.plan, &self.halton) {
            (Plan::List(list), _) => {
                // Rows of a list are counted by its length.
                #[allow(clippy::cast_possible_truncation)]
                let start = row as usize * axes.len();
                values.copy_from_slice(&list[start..start + axes.len()]);
            }
            (_, Some(halton)) => {
                for (j, (value, axis)) in values.iter_mut().zip(axes).enumerate() {
                    *value = axis.values.quantile(halton.at(row, j));
                }
            }
            _ => {
                self.chunking.digits(row, &mut self.digits);
                for ((value, axis), digit) in values.iter_mut().zip(axes).zip(&self.digits) {
                    *value = axis.values.at(*digit);
                }
            }
        }
    }
}
