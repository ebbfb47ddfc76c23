//! How many floating-point operations one Newton step takes: the kernel computes with numbers that count.
//! `cargo test --release -p cppr --lib work_of_one_step -- --nocapture` prints them.

use super::system::{Buffers, Point, System};
use super::{Actuator, Drive, Formulation};
use crate::design::{Profile, Robot, RobotDesign, StiffnessTube, TubeDesign};
use crate::kinematics::Resolution;
use crate::kinematics::layout::Layouts;
use crate::real::{Each, Real};
use crate::statics::{Loads, RotationMeans};
use nalgebra::Vector3;
use num_traits::{One, Zero};
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

/// A number that counts what is done with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Counted(f64);

macro_rules! counted {
    ($($operator:ident $function:ident $assign:ident $in_place:ident $sign:tt),*) => {$(
        impl $operator for Counted {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                self $sign other.0
            }
        }

        impl $operator<f64> for Counted {
            type Output = Self;

            fn $function(self, other: f64) -> Self {
                COUNT.set(COUNT.get() + 1);
                Self(self.0 $sign other)
            }
        }

        impl $assign for Counted {
            fn $in_place(&mut self, other: Self) {
                *self = *self $sign other;
            }
        }
    )*};
}

counted!(
    Add add AddAssign add_assign +,
    Sub sub SubAssign sub_assign -,
    Mul mul MulAssign mul_assign *,
    Div div DivAssign div_assign /
);

impl Neg for Counted {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for Counted {
    fn zero() -> Self {
        Self(0.0)
    }

    fn is_zero(&self) -> bool {
        self.vanishes()
    }
}

impl One for Counted {
    fn one() -> Self {
        Self(1.0)
    }
}

impl Real for Counted {
    const LANES: usize = 1;

    fn splat(value: f64) -> Self {
        Self(value)
    }

    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        Self(value(0))
    }

    fn lane(self, _: usize) -> f64 {
        self.0
    }

    fn plus(self, a: Self, b: Self) -> Self {
        self + a * b
    }
}

fn tube(offset: f64, direction: f64) -> TubeDesign {
    TubeDesign::Stiffness(StiffnessTube {
        centroid_offset: Profile::constant(offset),
        direction: Profile::constant(direction),
        bending_y: Profile::constant(8e-3),
        bending_z: Profile::constant(1e-3),
        torsion: Profile::constant(2e-3),
        axial: None,
        mass_per_length: Profile::constant(0.0),
        centroid_offset_factor: 1.0,
    })
}

/// Operations of one evaluation of residual and tangent, and of one factorisation and solution.
fn count(tubes: Vec<TubeDesign>, resolution: Resolution, loads: &Loads) -> [u64; 2] {
    let robot = Robot::from_design(RobotDesign { name: "counted".into(), length: 0.15, tubes }).unwrap();
    let layout = Layouts::default().get(robot.tube_count(), robot.length(), resolution, std::iter::empty());
    let rotation = if resolution.angle == 0 { Drive::Effort(0.0) } else { Drive::Motion(0.0) };
    let drives = vec![Actuator { push_pull: Drive::Motion(1e-3), rotation }; robot.follower_count()];
    let system = System {
        robot: &robot,
        layout: &layout,
        loads: Each::same(loads),
        rotation_means: RotationMeans::Base,
        actuators: Each::same(&drives),
        formulation: Formulation::Consistent,
    };
    let mut buffers = Buffers::<Counted>::default();
    let mut point = Point::rest(&layout);
    for (i, coordinate) in point.coordinates.iter_mut().enumerate() {
        *coordinate = Counted(0.3 + 0.1 * i as f64);
    }
    // What is kept between evaluations is there from the second on.
    assert_eq!(buffers.evaluate_consistent(&system, &point), 0);
    COUNT.set(0);
    assert_eq!(buffers.evaluate_consistent(&system, &point), 0);
    let evaluation = COUNT.replace(0);
    buffers.factor_in_order(&system);
    let mut step = buffers.residual.clone();
    buffers.solve(&mut step, 1);
    [evaluation, COUNT.get()]
}

#[test]
fn work_of_one_step() {
    let two = || vec![tube(3e-3, 0.0), tube(1e-3, PI)];
    let three = (0..3).map(|k| tube(1e-3, TAU / 3.0 * f64::from(k))).collect();
    let paper = Resolution { twist: 3, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 6 };
    let loads = Loads::tip_force(Vector3::new(0.0, 0.05, 0.05));
    for (name, tubes, resolution, loads, bounds) in [
        ("planar, two tubes", two(), Resolution::PLANAR, Loads::none(), 2_000..6_500),
        ("space, two tubes, tip force", two(), paper, loads.clone(), 20_000..52_000),
        ("space, two tubes, tip force, default", two(), Resolution::SPATIAL, loads, 90_000..250_000),
        ("space, three tubes", three, paper, Loads::none(), 8_000..22_000),
    ] {
        let [evaluation, solution] = count(tubes, resolution, &loads);
        println!("{name}: {evaluation} operations to evaluate, {solution} to factor and solve");
        assert!(bounds.contains(&(evaluation + solution)), "{name}: {evaluation} + {solution}");
    }
}
