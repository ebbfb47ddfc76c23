//! How much a command asks of a robot: a mistaken unit shows here before it shows in a solve.
//!
//! Each load and each drive is measured by the angle through which it would bend or turn the robot, were the robot to
//! answer as at rest and free at the tip. With EI and GJ the sums over all tubes halfway along the robot:
//!
//!   force F at X, arm r: (½ F X² + F r X)/EI     moment M at X: M X/EI     force per length q from a to b: q (b³ − a³)/(6 EI)
//!   gravity g: g m L³/(6 EI)     tension T: T D L/EI     torque Υ: Υ L/GJ     pull Δa: Δa/D     turn Ω: Ω
//!
//! D is the distance between the centroid lines of follower and leader. These are sizes, not predictions.

use super::pulls::contradicting_pulls;
use crate::bundle::Bundle;
use crate::bundle::solve::BundleCommand;
use crate::design::Robot;
use crate::solve::{Command, Freedom, Input, Quantity, Status};
use crate::statics::{Loads, Station, Wrench};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

/// What of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// The motion or the effort of an actuator (m, N, rad, N m).
    Actuator(Input),
    /// The force on the tip (N).
    TipForce,
    /// The moment on the tip (N m).
    TipMoment,
    /// A force at label X (N).
    Force(f64),
    /// A moment at label X (N m).
    Moment(f64),
    /// A distributed force between two labels (N/m).
    Distributed(f64, f64),
    /// Gravity (m/s²).
    Gravity,
    /// The tension of a thread (N).
    Thread,
}

/// One part of a command and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Which part.
    pub asked: Asked,
    /// Its magnitude (SI).
    pub amount: f64,
    /// Angle through which it would bend or turn the robot (rad).
    pub angle: f64,
    /// How much of it would bend or turn the robot by 90° (SI).
    pub right_angle: f64,
}

impl Demand {
    /// Beyond three turns nothing is meant as it stands.
    const MOST: f64 = 3.0 * TAU;

    /// Is this more than any robot of this stiffness is meant for?
    #[must_use]
    pub fn is_absurd(&self) -> bool {
        self.angle > Self::MOST
    }
}

/// Parts of the length at which levers are looked for, one after the other.
const LEVERS: [f64; 5] = [0.5, 0.3, 0.7, 0.1, 0.9];

/// The part that asks most so far.
#[derive(Default)]
struct Greatest(Option<Demand>);

impl Greatest {
    /// Measures an amount by the angle that it bends or turns per unit.
    fn ask(&mut self, asked: Asked, amount: f64, per_unit: f64) {
        let angle = amount.abs() * per_unit;
        if angle > self.0.map_or(0.0, |g| g.angle) {
            let right_angle = FRAC_PI_2 / per_unit;
            self.0 = Some(Demand { asked, amount: amount.abs(), angle, right_angle });
        }
    }

    /// Measures loads on a robot of a length (m), with EI (N m²) and mass per length (kg/m) of all tubes together.
    fn ask_loads(&mut self, loads: &Loads, length: f64, bending: f64, mass: f64) {
        let Loads { wrenches, distributed, gravity, threads } = loads;
        for wrench in wrenches {
            let (force, moment) = match wrench.station {
                Station::Tip => (Asked::TipForce, Asked::TipMoment),
                Station::Label(at) => (Asked::Force(at), Asked::Moment(at)),
            };
            let [per_newton, per_newton_metre] = angles_of(wrench, length, bending);
            self.ask(force, length_of(&wrench.force), per_newton);
            self.ask(moment, length_of(&wrench.moment), per_newton_metre);
        }
        for d in distributed {
            self.ask(
                Asked::Distributed(d.from, d.to),
                length_of(&d.force),
                (d.to.powi(3) - d.from.powi(3)) / (6.0 * bending),
            );
        }
        if let Some(gravity) = gravity {
            self.ask(Asked::Gravity, length_of(gravity), mass * length.powi(3) / (6.0 * bending));
        }
        for thread in threads {
            self.ask(Asked::Thread, thread.tension, (0.5 * length + thread.point.norm()) * length / bending);
        }
    }
}

/// What loads and drives do to a robot at rest.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    length: f64,
    /// EI and GJ of all tubes halfway along the robot (N m²), and their mass per length (kg/m).
    bending: f64,
    torsion: f64,
    mass: f64,
    /// Lever of every tube about the leader's centroid line (m), 0 where there is none.
    levers: Vec<f64>,
}

impl Scale {
    pub(crate) fn of(robot: &Robot) -> Self {
        let length = robot.length();
        let middle: Vec<_> =
            (0..robot.tube_count()).map(|tube| robot.fields_at(tube, 0.5 * length)).collect();
        // Uncut parts have no lever: where there is none halfway, the first elsewhere counts.
        let lever_of = |tube: usize| {
            let lever = |part: f64| {
                [0, tube].map(|t| robot.fields_at(t, part * length).centroid_offset).iter().sum::<f64>()
            };
            LEVERS.into_iter().map(lever).find(|l| *l > 0.0).unwrap_or(0.0)
        };
        Self {
            length,
            bending: middle.iter().map(|f| f.bending_z).sum(),
            torsion: middle.iter().map(|f| f.torsion).sum(),
            mass: middle.iter().map(|f| f.mass_per_length).sum(),
            levers: (0..robot.tube_count()).map(lever_of).collect(),
        }
    }

    /// Angle (rad) per unit of an input; `None` of a tube that the robot has not, and where a pull has no lever and bends nothing.
    fn per_unit(&self, input: Input) -> Option<f64> {
        let lever = *self.levers.get(input.tube - 1)?;
        match (input.freedom, input.is_motion) {
            (Freedom::PushPull, true) => (lever > 0.0).then(|| 1.0 / lever),
            (Freedom::PushPull, false) => Some(lever * self.length / self.bending),
            (Freedom::Rotation, true) => Some(1.0),
            (Freedom::Rotation, false) => Some(self.length / self.torsion),
        }
    }

    /// Angle (rad) through which a change from one command to another would bend or turn the robot; infinite where more changes than
    /// values of actuators and concentrated loads.
    pub(crate) fn change(&self, from: &Command, to: &Command) -> f64 {
        let Loads { wrenches, distributed, gravity, threads } = &to.loads;
        let others = &from.loads;
        if !to.loads.is_like(others)
            || (distributed, gravity, threads) != (&others.distributed, &others.gravity, &others.threads)
        {
            return f64::INFINITY;
        }
        let inputs = from.inputs().zip(to.inputs()).map(|((before, a), (input, b))| {
            if before == input { (b - a).abs() * self.per_unit(input).unwrap_or(0.0) } else { f64::INFINITY }
        });
        let loads = wrenches.iter().zip(&others.wrenches).map(|(a, b)| {
            let [force, moment] = angles_of(a, self.length, self.bending);
            ((a.force - b.force).norm() * force).max((a.moment - b.moment).norm() * moment)
        });
        inputs.chain(loads).fold(0.0, f64::max)
    }
}

/// Angles (rad) per newton and per newton metre of a concentrated load on a robot of a length, with EI of all tubes together.
fn angles_of(wrench: &Wrench, length: f64, bending: f64) -> [f64; 2] {
    let at = match wrench.station {
        Station::Tip => length,
        Station::Label(at) => at,
    };
    [(0.5 * at + wrench.point.norm()) * at / bending, at / bending]
}

/// The part of a command that asks most of a robot; `None` where nothing is asked.
#[must_use]
pub fn greatest_demand(robot: &Robot, command: &Command) -> Option<Demand> {
    let scale = Scale::of(robot);
    let mut greatest = Greatest::default();
    for (input, value) in command.inputs() {
        if let Some(per_unit) = scale.per_unit(input) {
            greatest.ask(Asked::Actuator(input), value, per_unit);
        }
    }
    greatest.ask_loads(&command.loads, scale.length, scale.bending, scale.mass);
    greatest.0
}

/// The part of a command that asks most of a robot, where that is more than can be meant.
#[must_use]
pub fn absurd_demand(robot: &Robot, command: &Command) -> Option<Demand> {
    greatest_demand(robot, command).filter(Demand::is_absurd)
}

/// The same for a bundle. Pulls and gravity are not measured: a tube may be inserted as far as it is long.
#[must_use]
pub fn absurd_bundle_demand(bundle: &Bundle, command: &BundleCommand) -> Option<Demand> {
    let (length, [bending, torsion, lever]) = (bundle.length(), bundle.stiffness());
    let mut greatest = Greatest::default();
    for (tube, drive) in (1..).zip(&command.drives) {
        let sizes = [
            (Quantity::ROTATION, drive.rotation.motion(), 1.0),
            (Quantity::TENSION, drive.translation.effort(), lever * length / bending),
            (Quantity::TORQUE, drive.rotation.effort(), length / torsion),
        ];
        for (quantity, value, per_unit) in sizes {
            greatest.ask(Asked::Actuator(quantity.of_tube(tube)), value.unwrap_or(0.0), per_unit);
        }
    }
    greatest.ask_loads(&command.loads, length, bending, 0.0);
    greatest.0.filter(Demand::is_absurd)
}

/// How a solve ended, in a sentence; where its command asks for what cannot be meant, or for pulls that contradict one another, with that.
#[must_use]
pub fn explained(robot: &Robot, command: &Command, status: Status) -> String {
    if let Some(demand) = absurd_demand(robot, command) {
        return format!("{status}. {demand}");
    }
    let contradicting = if status.is_equilibrium() { None } else { contradicting_pulls(robot, command) };
    let Some(tubes) = contradicting else { return status.to_string() };
    let list: Vec<String> = tubes.iter().map(ToString::to_string).collect();
    format!(
        "{status}. The command is over-determined: without stretch the pulls of tubes {} depend on one another, because fewer of \
         them already fix how the robot bends. Drive one of these tubes by a force",
        list.join(", ")
    )
}

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Actuator(input) => write!(f, "The {} of tube {}", input.quantity().name, input.tube),
            Self::TipForce => write!(f, "The tip force"),
            Self::TipMoment => write!(f, "The tip moment"),
            Self::Force(at) => write!(f, "The force at {} mm", short(at * 1e3)),
            Self::Moment(at) => write!(f, "The moment at {} mm", short(at * 1e3)),
            Self::Distributed(from, to) => {
                write!(f, "The distributed force from {} to {} mm", short(from * 1e3), short(to * 1e3))
            }
            Self::Gravity => write!(f, "Gravity"),
            Self::Thread => write!(f, "The tension of the thread"),
        }
    }
}

impl fmt::Display for Demand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (factor, unit, does) = match self.asked {
            Asked::Actuator(input) => {
                let Quantity { freedom, shown_unit, shown_size, .. } = input.quantity();
                let does = if freedom == Freedom::PushPull { "bends" } else { "turns" };
                (1.0 / shown_size, shown_unit, does)
            }
            Asked::TipMoment | Asked::Moment(_) => (1e3, "N mm", "bends"),
            Asked::Distributed(..) => (1.0, "N/m", "bends"),
            Asked::Gravity => (1.0, "m/s²", "bends"),
            Asked::TipForce | Asked::Force(_) | Asked::Thread => (1.0, "N", "bends"),
        };
        let Self { asked, amount, right_angle, .. } = self;
        let (given, right) = (short(amount * factor), short(right_angle * factor));
        if let Asked::Actuator(Input { freedom: Freedom::Rotation, is_motion: true, .. }) = asked {
            return write!(f, "{asked} is {given} deg, {} turns. Check number and unit", short(amount / TAU));
        }
        write!(
            f,
            "{asked} is {given} {unit}; on this robot about {right} {unit} {does} by 90°. Check number and unit"
        )
    }
}

/// The norm, also of components whose squares overflow.
fn length_of(v: &Vector3<f64>) -> f64 {
    let greatest = v.amax();
    if greatest > 0.0 { greatest * (v / greatest).norm() } else { 0.0 }
}

/// Two or three digits.
fn short(value: f64) -> String {
    if value.abs() >= 1e6 || (value.abs() < 1e-2 && value != 0.0) {
        return format!("{value:.1e}");
    }
    let digits = if value.abs() < 10.0 { 2 } else { 0 };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
