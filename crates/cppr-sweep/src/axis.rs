//! What varies in a sweep, and over which values.

use cppr::bundle::solve::BundleCommand;
use cppr::solve::{Command, Input};
use cppr::statics::{Loads, Station};
use statrs::distribution::{ContinuousCDF, Normal};

/// One input that varies. Values of actuators and loads are in SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// An actuator: its motion or its effort (m, rad, N, N m).
    Actuator(Input),
    /// Component 0 to 2 of the force of a wrench among the loads of the task's command (N).
    Force {
        /// Index among the wrenches.
        wrench: usize,
        /// Component.
        component: usize,
    },
    /// Component 0 to 2 of the moment of a wrench (N m).
    Moment {
        /// Index among the wrenches.
        wrench: usize,
        /// Component.
        component: usize,
    },
    /// A number of the robot file, in the unit of its key: `tube2.notches.depth_mm`.
    Design(String),
}

/// The values of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// Equally spaced from one end to the other, both included; sampled uniformly between them.
    Range {
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// How many; 0 where the axis is sampled.
        count: u32,
    },
    /// Normally distributed; sampled only.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
    },
}

/// One axis of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What varies.
    pub variable: Variable,
    /// Over what.
    pub values: Values,
}

impl Variable {
    /// Name of its column, with the unit; `loads` are those of the task's command.
    #[must_use]
    pub fn column(&self, loads: &Loads) -> String {
        let component = |c: usize| ["x", "y", "z"][c.min(2)];
        let place = |wrench: usize| match loads.wrenches.get(wrench).map(|w| w.station) {
            Some(Station::Tip) => "tip".to_owned(),
            _ => format!("load{}", wrench + 1),
        };
        match self {
            Self::Actuator(input) => format!("input_tube{}_{}", input.tube, input.quantity().column()),
            Self::Force { wrench, component: c } => {
                format!("input_{}_force_{}_N", place(*wrench), component(*c))
            }
            Self::Moment { wrench, component: c } => {
                format!("input_{}_moment_{}_Nm", place(*wrench), component(*c))
            }
            Self::Design(key) => format!("input_{key}"),
        }
    }

    /// Puts a value into a command; a design key leaves it as it is.
    pub(crate) fn put(&self, command: &mut Command, value: f64) {
        match *self {
            Self::Actuator(input) => {
                // A task that was checked has the tube.
                let there = command.set(input, value);
                debug_assert!(there.is_ok(), "{there:?}");
            }
            _ => self.load(&mut command.loads, value),
        }
    }

    /// The same for a bundle.
    pub(crate) fn put_in_bundle(&self, command: &mut BundleCommand, value: f64) {
        match *self {
            Self::Actuator(input) => *command = command.with_input(input, value),
            _ => self.load(&mut command.loads, value),
        }
    }

    fn load(&self, loads: &mut Loads, value: f64) {
        match *self {
            Self::Force { wrench, component } => {
                if let Some(wrench) = loads.wrenches.get_mut(wrench) {
                    wrench.force[component] = value;
                }
            }
            Self::Moment { wrench, component } => {
                if let Some(wrench) = loads.wrenches.get_mut(wrench) {
                    wrench.moment[component] = value;
                }
            }
            Self::Actuator(_) | Self::Design(_) => {}
        }
    }
}

impl Values {
    /// Value number `index` of a grid.
    pub(crate) fn at(&self, index: u64) -> f64 {
        match *self {
            Self::Range { from, count: 0 | 1, .. } => from,
            Self::Range { to, count, .. } if index + 1 == u64::from(count) => to,
            Self::Range { from, to, count } => {
                let share = index as f64 / f64::from(count - 1);
                from * (1.0 - share) + to * share
            }
            Self::Normal { mean, .. } => mean,
        }
    }

    /// The value below which the share 0 < `u` < 1 of all samples lies.
    pub(crate) fn quantile(&self, u: f64) -> f64 {
        match *self {
            Self::Range { from, to, .. } => from * (1.0 - u) + to * u,
            Self::Normal { mean, deviation } => match Normal::new(mean, deviation) {
                Ok(normal) => normal.inverse_cdf(u),
                Err(_) => f64::NAN,
            },
        }
    }

    /// Number of grid values.
    pub(crate) fn count(&self) -> u64 {
        match *self {
            Self::Range { count, .. } => u64::from(count),
            Self::Normal { .. } => 0,
        }
    }
}
