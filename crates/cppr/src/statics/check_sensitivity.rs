//! Jacobians, compliance, responses and derivatives by parameters of an equilibrium, against dual numbers.
//!
//! The plain program of `check` is differentiated as it stands: the conditions of equilibrium and their tangent from dual and
//! hyper-dual numbers, the tip's twist from dual numbers, the linear system solved by nalgebra. Nothing is shared with
//! `analysis::sensitivity` but the equilibrium itself.

use super::assembly::{Efforts, RotationMeans, Setting};
use super::check::{Pose, potential_loads, primal_along, test_robot};
use super::check_parameters::{PARAMETERS, SHARES, rates};
use crate::analysis::Perturbed;
use crate::design::Robot;
use crate::design::fields::Fields;
use crate::kinematics::Resolution;
use crate::real::Each;
use crate::solve::{Actuator, Command, Drive, Equilibrium, Settings, Solver};
use nalgebra::{DMatrix, DVector, Dyn, LU, Vector3};
use num_dual::{Dual64, HyperDual64};

/// Every way of driving, once with the uncut part of tube 3 inside the robot and once without.
fn commands() -> [Command; 2] {
    let (motion, effort) = (Drive::Motion, Drive::Effort);
    [
        [(motion(2e-3), effort(6e-3)), (motion(-1.5e-3), motion(0.3))],
        [(effort(-1.0), motion(0.2)), (motion(1e-3), effort(-2e-3))],
    ]
    .map(|pairs| Command {
        actuators: pairs.map(|(push_pull, rotation)| Actuator { push_pull, rotation }).to_vec(),
        loads: potential_loads(),
        rotation_means: RotationMeans::Base,
    })
}

/// Effort of an input: tensions and torques alternate, as inputs do.
fn effort(efforts: &mut Efforts, input: usize) -> &mut f64 {
    let list = if input % 2 == 0 { &mut efforts.tension } else { &mut efforts.torque };
    &mut list[input / 2]
}

/// An equilibrium, as the plain program sees it.
pub(super) struct Plain<'a> {
    setting: Setting<'a>,
    efforts: Efforts,
    pub u: Vec<f64>,
    /// Slope of the gradient by every input's effort: minus the slope of its motion.
    motions: Vec<DVector<f64>>,
    /// Inputs whose motion is prescribed: their efforts are unknown, and so are those of the edges.
    unknown: Vec<usize>,
    /// Second derivatives of 𝓛, the conditions that are kept beside and below.
    pub matrix: DMatrix<f64>,
    tangent: LU<f64, Dyn, Dyn>,
    /// Twist of the tip by the coordinates, 6 × n.
    pub twist: DMatrix<f64>,
}

/// Velocity of the centre and spin, from the dual parts of a pose.
fn rate_of((frame, centre): &Pose<Dual64>) -> [f64; 6] {
    let column = |axis: usize| Vector3::from(frame[axis].map(|c| c.re));
    let rate = |axis: usize| Vector3::from(frame[axis].map(|c| c.eps));
    let spin = (0..3).map(|a| column(a).cross(&rate(a))).sum::<Vector3<f64>>() * 0.5;
    [centre[0].eps, centre[1].eps, centre[2].eps, spin.x, spin.y, spin.z]
}

impl<'a> Plain<'a> {
    pub fn new(robot: &'a Robot, found: &'a Equilibrium) -> Self {
        let setting = Setting {
            robot,
            layout: &found.layout,
            loads: Each::same(&found.command.loads),
            rotation_means: found.command.rotation_means,
        };
        let (efforts, u) = (found.point.efforts.clone(), found.point.coordinates.clone());
        let n = u.len();
        let ahead = |efforts: &Efforts, i: usize| {
            let dual: Vec<Dual64> = (0..n).map(|j| Dual64::new(u[j], f64::from(u8::from(i == j)))).collect();
            primal_along(&setting, efforts, &dual, None)
        };
        let gradient = |efforts: &Efforts| DVector::from_fn(n, |i, _| ahead(efforts, i).lagrangian.eps);
        // 𝓛 is linear in all efforts.
        let here = gradient(&efforts);
        let slope = |change: &dyn Fn(&mut Efforts)| {
            let mut other = efforts.clone();
            change(&mut other);
            gradient(&other) - &here
        };
        let inputs = 2 * found.drives.len();
        let motions: Vec<_> = (0..inputs).map(|k| slope(&|e| *effort(e, k) += 1.0)).collect();
        let edges: Vec<_> = (0..efforts.edge.len()).map(|b| slope(&|e| e.edge[b] += 1.0)).collect();
        let is_motion = |k: &usize| {
            let actuator = found.drives[k / 2];
            [actuator.push_pull, actuator.rotation][k % 2].is_motion()
        };
        let unknown: Vec<usize> = (0..inputs).filter(is_motion).collect();
        let rows: Vec<&DVector<f64>> = unknown.iter().map(|&k| &motions[k]).chain(&edges).collect();
        let mut tangent = DMatrix::zeros(n + rows.len(), n + rows.len());
        for i in 0..n {
            for j in 0..=i {
                let part = |at: usize, k: usize| f64::from(u8::from(at == k));
                let hyper: Vec<HyperDual64> =
                    (0..n).map(|k| HyperDual64::new(u[k], part(i, k), part(j, k), 0.0)).collect();
                let value = primal_along(&setting, &efforts, &hyper, None).lagrangian.eps1eps2;
                tangent[(i, j)] = value;
                tangent[(j, i)] = value;
            }
            for (c, row) in rows.iter().enumerate() {
                tangent[(i, n + c)] = row[i];
                tangent[(n + c, i)] = row[i];
            }
        }
        let mut twist = DMatrix::zeros(6, n);
        for i in 0..n {
            let moved = ahead(&efforts, i);
            twist.column_mut(i).copy_from_slice(&rate_of(moved.ends.last().unwrap()));
        }
        Self { setting, efforts, u, motions, unknown, tangent: tangent.clone().lu(), matrix: tangent, twist }
    }

    /// Answer of coordinates and unknown efforts where the gradient changes by `load` and its slopes by the unknown efforts, the
    /// conditions, by `shift`.
    fn answer(&self, load: &DVector<f64>, shift: &DVector<f64>) -> DVector<f64> {
        let n = self.u.len();
        let mut right = DVector::zeros(n + shift.len());
        right.rows_mut(0, n).copy_from(&(-load));
        right.rows_mut(n, shift.len()).copy_from(&(-shift));
        self.tangent.solve(&right).unwrap()
    }

    /// What a parameter of the fields does to the conditions at fixed coordinates: slopes of ∂𝓛/∂p by the unknown efforts.
    fn conditions_by(&self, fields: &[Fields]) -> DVector<f64> {
        let still: Vec<Dual64> = self.u.iter().map(|&u| Dual64::new(u, 0.0)).collect();
        let at = |efforts: &Efforts| {
            let p = Dual64::new(0.0, 1.0);
            primal_along(&self.setting, efforts, &still, Some((fields, p))).lagrangian.eps
        };
        let here = at(&self.efforts);
        let slope = |change: &dyn Fn(&mut Efforts)| {
            let mut other = self.efforts.clone();
            change(&mut other);
            at(&other) - here
        };
        let motions = self.unknown.iter().map(|&k| slope(&|e| *effort(e, k) += 1.0));
        let edges = (0..self.efforts.edge.len()).map(|b| slope(&|e| e.edge[b] += 1.0));
        DVector::from_vec(motions.chain(edges).collect())
    }

    fn tip(&self, answer: &DVector<f64>) -> DVector<f64> {
        &self.twist * answer.rows(0, self.u.len())
    }

    /// Effort of an input whose motion is prescribed, motion of one whose effort is.
    fn conjugate(&self, answer: &DVector<f64>, input: usize) -> f64 {
        let n = self.u.len();
        match self.unknown.iter().position(|&k| k == input) {
            Some(place) => answer[n + place],
            None => -self.motions[input].dot(&answer.rows(0, n)),
        }
    }
}

/// A robot in equilibrium under a command, solved until rounding is left.
fn settled(robot: &Robot, command: &Command) -> Equilibrium {
    let modes = Resolution { twist: 2, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 5 };
    let settings = Settings { tolerance: 1e-13, ..Settings::default() }.with_resolution(modes);
    let found = Solver::with_settings(robot, settings).unwrap().solve(command).unwrap();
    assert!(found.status.is_equilibrium(), "{}", found.status);
    found
}

fn same(what: &str, got: &DVector<f64>, want: &DVector<f64>) {
    // Translations and rotations, tensions and torques: each against its own kind.
    assert!(want.amax() > 1e-9, "{what} is nothing");
    for (i, (g, w)) in got.iter().zip(want.iter()).enumerate() {
        assert!((g - w).abs() < 1e-9 * want.amax(), "{what}, {i}: {g} {w}");
    }
}

#[test]
fn jacobians_and_compliance_are_those_of_dual_numbers() {
    let robot = test_robot();
    let mut solver = Solver::new(&robot);
    for (turn, command) in commands().iter().enumerate() {
        let found = settled(&robot, command);
        assert_eq!(found.layout.edges.len(), 1 - turn, "the uncut part is inside in the first case only");
        let exact = solver.sensitivity(&found).unwrap();
        let rotation = solver.tip(&found).rotation;
        let plain = Plain::new(&robot, &found);
        let inputs = exact.inputs.len();
        let responses = |answer: &DVector<f64>| DVector::from_fn(inputs, |k, _| plain.conjugate(answer, k));
        let conditions = plain.unknown.len() + found.layout.edges.len();
        let (free, kept) = (DVector::zeros(plain.u.len()), DVector::zeros(conditions));
        for k in 0..inputs {
            let place = plain.unknown.iter().position(|&unknown| unknown == k);
            assert_eq!(exact.inputs[k].is_motion, place.is_some());
            let answer = match place {
                Some(place) => {
                    plain.answer(&free, &DVector::from_fn(conditions, |c, _| f64::from(u8::from(c == place))))
                }
                None => plain.answer(&plain.motions[k], &kept),
            };
            let tip = plain.tip(&answer);
            for (what, rows) in [("translation", 0), ("rotation", 3)] {
                let (world, body) = (&exact.tip_jacobian, &exact.tip_jacobian_body);
                let part = |m: &DMatrix<f64>| DVector::from(m.view((rows, k), (3, 1)).column(0).into_owned());
                let want = DVector::from(tip.rows(rows, 3).into_owned());
                same(&format!("{what} by input {k}"), &part(world), &want);
                let turned = rotation.transpose() * want.fixed_rows::<3>(0);
                same(
                    &format!("{what} by input {k}, body"),
                    &part(body),
                    &DVector::from_column_slice(turned.as_slice()),
                );
            }
            same(
                &format!("responses to input {k}"),
                &exact.response.column(k).into_owned(),
                &responses(&answer),
            );
        }
        for axis in 0..6 {
            let work = DVector::from(-plain.twist.row(axis).transpose());
            let answer = plain.answer(&work, &kept);
            let got = DVector::from_column_slice(exact.compliance.column(axis).as_slice());
            same(&format!("twist by wrench {axis}"), &got, &plain.tip(&answer));
            let got = exact.response_by_wrench.column(axis).into_owned();
            same(&format!("responses to wrench {axis}"), &got, &responses(&answer));
        }
    }
}

#[test]
fn derivatives_by_parameters_are_those_of_dual_numbers() {
    let (robot, step) = (test_robot(), 1e-3);
    let mut solver = Solver::new(&robot);
    for command in &commands() {
        let found = settled(&robot, command);
        let plain = Plain::new(&robot, &found);
        let n = plain.u.len();
        for (name, tube, change) in PARAMETERS {
            let at = |p: f64| {
                let mut design = robot.design().clone();
                change(&mut design.tubes[tube], p);
                Robot::from_design(design).ok()
            };
            let perturbed = Perturbed::new(step, at).unwrap();
            let read = |solver: &mut Solver, found: &Equilibrium| {
                let centre = solver.tip(found).centre;
                let states = found.actuators.iter().flat_map(|a| [a.tension, a.torque]);
                centre.iter().copied().chain(states).collect()
            };
            let got = solver.parameter_sensitivity(&found, &perturbed, read).unwrap();

            let robots = SHARES.map(|(share, _)| at(share * step).unwrap());
            let fields: Vec<Fields> = (0..3).map(|t| rates(&robots, t, step)).collect();
            let load = DVector::from_fn(n, |i, _| {
                let hyper: Vec<HyperDual64> = (0..n)
                    .map(|k| HyperDual64::new(plain.u[k], f64::from(u8::from(i == k)), 0.0, 0.0))
                    .collect();
                let p = HyperDual64::new(0.0, 0.0, 1.0, 0.0);
                primal_along(&plain.setting, &plain.efforts, &hyper, Some((&fields, p))).lagrangian.eps1eps2
            });
            let answer = plain.answer(&load, &plain.conditions_by(&fields));
            // What the parameter moves while the coordinates stay, and what they move.
            let still: Vec<Dual64> = plain.u.iter().map(|&u| Dual64::new(u, 0.0)).collect();
            let p = Dual64::new(0.0, 1.0);
            let own = primal_along(&plain.setting, &plain.efforts, &still, Some((&fields, p)));
            let own = DVector::from_column_slice(&rate_of(own.ends.last().unwrap()));
            let tip = plain.tip(&answer) + own;
            same(
                &format!("tip by {name}"),
                &DVector::from_column_slice(&got[..3]),
                &tip.rows(0, 3).into_owned(),
            );
            for &k in &plain.unknown {
                let (got, want) = (got[3 + k], plain.conjugate(&answer, k));
                assert!(
                    (got - want).abs() < 1e-8 * want.abs().max(1e-3),
                    "effort {k} by {name}: {got} {want}"
                );
            }
        }
    }
}
