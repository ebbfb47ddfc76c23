//! What acts on the robot from outside: wrenches, distributed force, gravity, threads.
//!
//! Forces in N, moments in N m, lengths in m. Points are given in the frame of a section: origin at the
//! tube's centre, X along the tangent, Y towards the leader's centroid at that section.

use crate::dense::times;
use crate::design::Robot;
use crate::kinematics::so3::hat;
use crate::real::{MOST_LANES, Real};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;
use std::fmt;

/// Where a load acts along the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Station {
    /// On the tip body.
    Tip,
    /// On the leader's section with this label X (m).
    Label(f64),
}

/// In which frame the components of a wrench stay constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Frame {
    /// The baseplate's: a dead load.
    World,
    /// The loaded section's: a follower load, which turns with the robot.
    Section,
}

/// A concentrated force and moment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wrench {
    /// Force (N).
    pub force: Vector3<f64>,
    /// Moment about the point of action (N m).
    pub moment: Vector3<f64>,
    /// Frame of the components of force and moment.
    pub frame: Frame,
    /// Where along the robot.
    pub station: Station,
    /// Point of action in the section's frame (m).
    pub point: Vector3<f64>,
}

impl Wrench {
    /// A dead force at the centre of the tip section.
    #[must_use]
    pub fn tip_force(force: Vector3<f64>) -> Self {
        Self {
            force,
            moment: Vector3::zeros(),
            frame: Frame::World,
            station: Station::Tip,
            point: Vector3::zeros(),
        }
    }

    /// A dead moment on the tip.
    #[must_use]
    pub fn tip_moment(moment: Vector3<f64>) -> Self {
        Self { moment, ..Self::tip_force(Vector3::zeros()) }
    }
}

/// A dead force per unit of the leader's length (N/m), on the centreline between two labels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DistributedForce {
    /// Force per length in the baseplate's frame (N/m).
    pub force: Vector3<f64>,
    /// First label (m).
    pub from: f64,
    /// Last label (m).
    pub to: f64,
}

/// A thread from the tip over a pulley whose axle is parallel to Z to a hanging weight (eq 96–98).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Thread {
    /// Tension in the thread (N).
    pub tension: f64,
    /// Centre of the pulley in the baseplate's frame (m).
    pub pulley: Vector3<f64>,
    /// Radius of the pulley (m); 0 is an eyelet.
    pub radius: f64,
    /// True where the thread runs onto the pulley on its left, seen from the robot's tip along the
    /// thread with +Z up.
    pub left: bool,
    /// Where it is tied, in the tip section's frame (m).
    pub point: Vector3<f64>,
}

/// All external loads.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Loads {
    /// Concentrated wrenches.
    pub wrenches: Vec<Wrench>,
    /// Distributed forces.
    pub distributed: Vec<DistributedForce>,
    /// Gravitational acceleration in the baseplate's frame (m/s²); acts on every tube above the plate.
    pub gravity: Option<Vector3<f64>>,
    /// Threads over pulleys.
    pub threads: Vec<Thread>,
}

/// A part of the loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadPart {
    /// The force of a wrench.
    Force(Station),
    /// The moment of a wrench.
    Moment(Station),
    /// The point at which a wrench acts.
    Point(Station),
    /// A distributed force.
    Distributed,
    /// Gravity.
    Gravity,
    /// A thread.
    Thread,
}

impl fmt::Display for LoadPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, station) = match self {
            Self::Force(station) => ("the force", station),
            Self::Moment(station) => ("the moment", station),
            Self::Point(station) => ("the point of the load", station),
            Self::Distributed => return write!(f, "a distributed force"),
            Self::Gravity => return write!(f, "gravity"),
            Self::Thread => return write!(f, "a thread"),
        };
        match station {
            Station::Tip => write!(f, "{name} on the tip"),
            Station::Label(label) => write!(f, "{name} at {:.3} mm", label * 1e3),
        }
    }
}

/// A load that cannot be.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadProblem {
    /// A component is NaN or infinite; which load.
    NotFinite(&'static str),
    /// A label outside [0, L] (m).
    OutsideRobot {
        /// The label (m).
        label: f64,
        /// The robot's length (m).
        length: f64,
    },
    /// A distributed force ends before it begins (m).
    Backwards {
        /// First label (m).
        from: f64,
        /// Last label (m).
        to: f64,
    },
    /// A pulley radius or a tension is negative (SI).
    Negative(&'static str, f64),
    /// Gravity is to act on a robot without mass.
    NoMass,
}

impl fmt::Display for LoadProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(what) => write!(f, "{what} has a component that is not a finite number"),
            Self::OutsideRobot { label, length } => write!(
                f,
                "a load acts at {:.3} mm, but the robot reaches from 0 to {:.3} mm",
                label * 1e3,
                length * 1e3
            ),
            Self::Backwards { from, to } => {
                write!(
                    f,
                    "a distributed force runs from {:.3} to {:.3} mm: write the smaller label first",
                    from * 1e3,
                    to * 1e3
                )
            }
            Self::NoMass => write!(
                f,
                "gravity acts on nothing: this robot has no mass; give its tubes a density or a mass per length"
            ),
            Self::Negative(what, value) => write!(f, "{what} is {value}; it cannot be negative"),
        }
    }
}

impl std::error::Error for LoadProblem {}

impl Loads {
    /// No load.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// A single dead force at the centre of the tip section (N).
    #[must_use]
    pub fn tip_force(force: Vector3<f64>) -> Self {
        Self { wrenches: vec![Wrench::tip_force(force)], ..Self::default() }
    }

    /// True where nothing acts.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let Self { wrenches, distributed, gravity, threads } = self;
        wrenches.is_empty() && distributed.is_empty() && gravity.is_none() && threads.is_empty()
    }

    /// Do forces act between the ends of elements too?
    pub(crate) fn act_along(&self) -> bool {
        // The layout is cut where wrenches act; threads pull at the tip.
        let Self { wrenches: _, distributed, gravity, threads: _ } = self;
        gravity.is_some() || !distributed.is_empty()
    }

    /// The same loads, each multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let Self { wrenches, distributed, gravity, threads } = self;
        let wrench = |w: &Wrench| Wrench { force: w.force * factor, moment: w.moment * factor, ..*w };
        let spread = |d: &DistributedForce| DistributedForce { force: d.force * factor, ..*d };
        let thread = |t: &Thread| Thread { tension: t.tension * factor, ..*t };
        Self {
            wrenches: wrenches.iter().map(wrench).collect(),
            distributed: distributed.iter().map(spread).collect(),
            gravity: gravity.map(|g| g * factor),
            threads: threads.iter().map(thread).collect(),
        }
    }

    /// These loads and others at once.
    #[must_use]
    pub fn joined(mut self, other: Self) -> Self {
        let Self { wrenches, distributed, gravity, threads } = other;
        self.wrenches.extend(wrenches);
        self.distributed.extend(distributed);
        self.threads.extend(threads);
        self.gravity = match (self.gravity, gravity) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
        self
    }

    /// True where every load is the gradient of a potential, so that the tangent is symmetric: no
    /// moments, no follower loads, and no pulley with a radius (eq 98 has a potential in the pulley's plane only).
    #[must_use]
    pub fn is_conservative(&self) -> bool {
        // Distributed forces and gravity are dead.
        let Self { wrenches, distributed: _, gravity: _, threads } = self;
        wrenches.iter().all(|w| w.frame == Frame::World && w.moment == Vector3::zeros())
            && threads.iter().all(|thread| thread.radius <= 0.0)
    }

    /// True where no load acts across the X–Y plane.
    #[must_use]
    pub fn is_planar(&self) -> bool {
        self.out_of_plane().is_none()
    }

    /// The first part that acts across the X–Y plane.
    #[must_use]
    pub fn out_of_plane(&self) -> Option<LoadPart> {
        let out = |v: &Vector3<f64>| v.z.abs() > 0.0;
        let Self { wrenches, distributed, gravity, threads } = self;
        let of_wrench = |w: &Wrench| {
            if out(&w.force) {
                Some(LoadPart::Force(w.station))
            } else if w.moment.x.abs() > 0.0 || w.moment.y.abs() > 0.0 {
                Some(LoadPart::Moment(w.station))
            } else {
                out(&w.point).then_some(LoadPart::Point(w.station))
            }
        };
        let of_wrenches = wrenches.iter().find_map(of_wrench);
        let spread = distributed.iter().any(|d| out(&d.force)).then_some(LoadPart::Distributed);
        let weight = gravity.is_some_and(|g| out(&g)).then_some(LoadPart::Gravity);
        let thread = threads.iter().any(|t| out(&t.pulley) || out(&t.point)).then_some(LoadPart::Thread);
        of_wrenches.or(spread).or(weight).or(thread)
    }

    /// What is wrong with the loads, on a robot.
    ///
    /// # Errors
    /// The first problem found.
    pub fn check(&self, robot: &Robot) -> Result<(), LoadProblem> {
        self.check_on(robot.length(), robot.has_mass())
    }

    /// The same, on tube 1 of a length (m), of a robot with or without mass.
    ///
    /// # Errors
    /// The first problem found.
    pub fn check_on(&self, length: f64, has_mass: bool) -> Result<(), LoadProblem> {
        let finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
        let inside = |label: f64| {
            if (0.0..=length).contains(&label) {
                Ok(())
            } else {
                Err(LoadProblem::OutsideRobot { label, length })
            }
        };
        let Self { wrenches, distributed, gravity, threads } = self;
        for w in wrenches {
            if !(finite(&w.force) && finite(&w.moment) && finite(&w.point)) {
                return Err(LoadProblem::NotFinite("a wrench"));
            }
            if let Station::Label(label) = w.station {
                inside(label)?;
            }
        }
        for d in distributed {
            if !finite(&d.force) {
                return Err(LoadProblem::NotFinite("a distributed force"));
            }
            inside(d.from)?;
            inside(d.to)?;
            if d.from > d.to {
                return Err(LoadProblem::Backwards { from: d.from, to: d.to });
            }
        }
        if gravity.is_some_and(|g| !finite(&g)) {
            return Err(LoadProblem::NotFinite("the gravity"));
        }
        if gravity.is_some() && !has_mass {
            return Err(LoadProblem::NoMass);
        }
        for t in threads {
            if !(finite(&t.pulley) && finite(&t.point) && t.tension.is_finite() && t.radius.is_finite()) {
                return Err(LoadProblem::NotFinite("a thread"));
            }
            if t.radius < 0.0 {
                return Err(LoadProblem::Negative("a pulley radius", t.radius));
            }
            if t.tension < 0.0 {
                return Err(LoadProblem::Negative("a thread's tension", t.tension));
            }
        }
        Ok(())
    }

    /// Copies without giving memory back.
    pub(crate) fn copy(&mut self, other: &Self) {
        let Self { wrenches, distributed, gravity, threads } = other;
        self.wrenches.clone_from(wrenches);
        self.distributed.clone_from(distributed);
        self.gravity = *gravity;
        self.threads.clone_from(threads);
    }

    /// Do both differ in numbers only, so that they make the same elements and act in the same way?
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let Self { wrenches, distributed, gravity, threads } = self;
        wrenches.len() == other.wrenches.len()
            && wrenches.iter().zip(&other.wrenches).all(|(a, b)| a.station == b.station && a.frame == b.frame)
            && distributed.len() == other.distributed.len()
            && distributed
                .iter()
                .zip(&other.distributed)
                .all(|(a, b)| (a.from - b.from).abs() <= 0.0 && (a.to - b.to).abs() <= 0.0)
            && gravity.is_some() == other.gravity.is_some()
            && threads.len() == other.threads.len()
    }

    /// Labels where concentrated loads act or distributed ones begin and end: the fields have kinks there.
    pub(crate) fn cuts(&self) -> impl Iterator<Item = f64> {
        // Gravity acts everywhere, threads at the tip.
        let Self { wrenches, distributed, gravity: _, threads: _ } = self;
        let concentrated = wrenches.iter().filter_map(|w| match w.station {
            Station::Label(label) => Some(label),
            Station::Tip => None,
        });
        concentrated.chain(distributed.iter().flat_map(|d| [d.from, d.to]))
    }
}

/// Force and moment of one concentrated load at a given pose, and how they change with it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Applied<S: Real = f64> {
    /// Force on the point of action, world components (N).
    pub force: Vector3<S>,
    /// Moment about the point of action, world components (N m).
    pub moment: Vector3<S>,
    /// Arm from the section's centre to the point of action, world components (m).
    pub arm: Vector3<S>,
    /// ∂force/∂(point of action).
    pub force_by_point: Matrix3<S>,
    /// ∂force/∂φ.
    pub force_by_spin: Matrix3<S>,
    /// ∂moment/∂φ.
    pub moment_by_spin: Matrix3<S>,
}

impl<S: Real> Applied<S> {
    /// A wrench at the pose of its section.
    pub fn wrench(
        frame: Frame,
        rotation: &Matrix3<S>,
        force: &Vector3<S>,
        moment: &Vector3<S>,
        point: &Vector3<S>,
    ) -> Self {
        let arm = times(rotation, point);
        let dead = Self { force: *force, moment: *moment, arm, ..Self::default() };
        match frame {
            Frame::World => dead,
            Frame::Section => {
                let (force, moment) = (times(rotation, force), times(rotation, moment));
                // A force that turns with the section: δf = φ × f.
                Self { force, moment, force_by_spin: -hat(&force), moment_by_spin: -hat(&moment), ..dead }
            }
        }
    }

    /// Puts the loads of all lanes side by side.
    pub fn from_lanes(load: impl Fn(usize) -> Applied) -> Self {
        let lanes: [Applied; MOST_LANES] =
            from_fn(|l| if l < S::LANES { load(l) } else { Applied::default() });
        let vector =
            |of: fn(&Applied) -> &Vector3<f64>| Vector3::from_fn(|i, _| S::from_lanes(|l| of(&lanes[l])[i]));
        let matrix = |of: fn(&Applied) -> &Matrix3<f64>| {
            Matrix3::from_fn(|i, j| S::from_lanes(|l| of(&lanes[l])[(i, j)]))
        };
        Self {
            force: vector(|a| &a.force),
            moment: vector(|a| &a.moment),
            arm: vector(|a| &a.arm),
            force_by_point: matrix(|a| &a.force_by_point),
            force_by_spin: matrix(|a| &a.force_by_spin),
            moment_by_spin: matrix(|a| &a.moment_by_spin),
        }
    }
}

impl Thread {
    /// At the pose of the tip. The thread leaves the tip along the tangent to the pulley: the direction
    /// to its centre turned about Z by asin(radius/distance).
    pub(crate) fn at(&self, rotation: &Matrix3<f64>, centre: &Vector3<f64>) -> Applied {
        let arm = rotation * self.point;
        let gap = self.pulley - (centre + arm);
        // At the pulley itself the direction is undefined: keep it finite.
        let distance = gap.norm().max(self.radius * (1.0 + 1e-9)).max(1e-12);
        let unit = gap / distance;
        let side = if self.left { 1.0 } else { -1.0 };
        let sine = self.radius / distance;
        let (s, c) = (side * sine, (1.0 - sine * sine).sqrt());
        let turn = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        let force = turn * unit * self.tension;
        // The turning angle shrinks with the distance: dα = −side ρ/(d² cos α) δd.
        let angle_slope = -side * sine / (distance * c.max(1e-9));
        let across = Vector3::new(-force.y, force.x, 0.0);
        let by_gap = turn * (Matrix3::identity() - unit * unit.transpose()) * (self.tension / distance)
            + across * unit.transpose() * angle_slope;
        Applied {
            force,
            moment: Vector3::zeros(),
            arm,
            force_by_point: -by_gap,
            force_by_spin: Matrix3::zeros(),
            moment_by_spin: Matrix3::zeros(),
        }
    }
}
