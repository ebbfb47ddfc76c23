//! Random bundles of 1 to 5 tubes with up to 3 joints: equilibria are found, or it is said where their path ends; what is found is as
//! accurate as it claims, turns with the plate, and is the same whether a motor's travel or its force is prescribed.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::random_bundle::random_bundle;
use common::{Random, seeds};
use cppr::Vector3;
use cppr::bundle::Bundle;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::solve::Drive;
use nalgebra::Rotation3;

/// Bundles that are tried; `CPPR_CASES` sets others.
const CASES: u64 = 60;
/// Bundles that go through control loops.
const LOOPS: u64 = 20;
/// Error allowed in one step of a control loop, and by how much of the length its poses are off at most.
const IN_LOOPS: [(f64, f64); 2] = [(1e-8, 1e-6), (1e-6, 1e-5)];

#[test]
fn any_bundle_has_its_equilibrium_or_the_reason_why_not() {
    let seeds = seeds(CASES);
    let cases = seeds.end - seeds.start;
    let (mut stable, mut ended, mut unknown, mut unreached) = (0_u64, 0_u64, Vec::new(), Vec::new());
    let (mut coarse, mut turned_away, mut forced_away, mut unrested) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for seed in seeds {
        let (design, command) = random_bundle(seed);
        let bundle = Bundle::new(&design).unwrap();
        let length = bundle.length();
        let mut solver = BundleSolver::new(&bundle);
        if !solver.rest().is_some_and(|rest| rest.stable) {
            unrested.push((seed, solver.rest().cloned().map(|rest| solver.inertia(&rest))));
        }
        let found = solver.solve(&command);
        if !(found.converged && found.stable) {
            let verdict = found.verdict();
            if verdict.contains("snap") {
                ended += 1;
            } else if verdict.contains("beyond") {
                unreached.push(seed);
            } else {
                unknown.push((seed, verdict));
            }
            continue;
        }
        stable += 1;
        let away = |other: &BundleEquilibrium, tip: Vector3<f64>| {
            if other.converged { (other.tip - tip).norm() / length } else { f64::INFINITY }
        };
        let mut finer = BundleSolver::new(&bundle).with_tolerance(1e-11);
        finer.rest();
        let finest = finer.solve_from(&command, &found);
        if away(&finest, found.tip) > 3.0 * found.error[0] / length + 1e-8 {
            coarse.push((seed, away(&finest, found.tip), found.error[0] / length));
        }
        if seed % 4 == 0 {
            let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
            let other = solver.solve(&turned(&command, &turn));
            if away(&other, turn * found.tip) > 1e-6 {
                turned_away.push((seed, away(&other, turn * found.tip), other.verdict()));
            }
        }
        if seed % 4 == 1
            && let Some(&(tube, _)) = design.joints.iter().flatten().find(|joint| joint.0 > 0)
        {
            let mut forced = command.clone();
            forced.drives[tube].translation = Drive::Effort(found.efforts[tube].force);
            let moved =
                solver.continued(&forced, &found).map_or(f64::INFINITY, |other| away(&other, found.tip));
            if moved > 1e-6 {
                forced_away.push((seed, moved));
            }
        }
    }
    println!(
        "{cases} bundles: no stable rest {unrested:?}; {stable} stable, {ended} lose their stability on the way, not reached {unreached:?}, unknown {unknown:?}; \
         coarser than said {coarse:?}; turned {turned_away:?}; forced {forced_away:?}"
    );
    let none_in_200 = |count: usize| count as u64 * 200 <= cases;
    assert!(none_in_200(unrested.len()) && none_in_200(unknown.len()));
    assert!(unreached.len() as u64 * 100 <= cases);
    assert!(stable * 100 >= cases * 95);
    assert!(none_in_200(coarse.len()) && none_in_200(turned_away.len()) && none_in_200(forced_away.len()));
}

/// The same with plate and loads turned.
fn turned(command: &BundleCommand, turn: &Rotation3<f64>) -> BundleCommand {
    let mut turned = command.clone();
    for drive in &mut turned.drives {
        drive.rotation = drive.rotation.with_value(drive.rotation.value() + turn.angle());
    }
    for wrench in &mut turned.loads.wrenches {
        wrench.force = turn * wrench.force;
    }
    turned
}

/// Control loops of random steps, in place: at every pose the equilibrium is that at the end of the path of equilibria from the pose before, in small steps; that
/// which is found from rest is that at the end of the path from rest; and what is said of stability without counting eigenvalues is what a count says.
#[test]
fn random_control_loops_keep_to_the_path() {
    for (tolerance, within) in IN_LOOPS {
        keep_to_the_path(tolerance, within);
    }
}

fn keep_to_the_path(tolerance: f64, within: f64) {
    let (mut poses, mut walked, mut astray, mut hopped, mut miscounted) =
        (0, [0; 2], Vec::new(), Vec::new(), Vec::new());
    for seed in seeds(LOOPS) {
        let (design, mut command) = random_bundle(seed);
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle).with_loop_tolerance(tolerance);
        let mut found = solver.solve(&command);
        let mut random = Random::new(seed);
        for step in 0..6 {
            if !found.stable {
                break;
            }
            let size = [1e-4, 1e-2][step % 2];
            for drive in &mut command.drives {
                let mut moved = |drive: Drive, unit: f64| match drive {
                    Drive::Motion(at) => Drive::Motion(at + size * unit * random.between(-1.0, 1.0)),
                    Drive::Effort(_) => drive,
                };
                drive.translation = moved(drive.translation, 0.3 * bundle.length());
                drive.rotation = moved(drive.rotation, 10.0);
            }
            let start = found.clone();
            solver.solve_into(&command, &mut found);
            let away = |own: &BundleEquilibrium, other: &BundleEquilibrium| {
                if own.stable { (own.tip - other.tip).norm() / bundle.length() } else { f64::INFINITY }
            };
            poses += 1;
            if let Some(end) = small_steps(&mut solver, &start, &command, 16) {
                walked[0] += 1;
                if away(&found, &end) > within {
                    astray.push((seed, step, away(&found, &end), found.iterations, found.verdict()));
                }
            }
            let rest = solver.rest().unwrap().clone();
            if step == 1
                && let Some(end) = small_steps(&mut solver, &rest, &command, 64)
            {
                walked[1] += 1;
                let whole = solver.solve(&command);
                if away(&whole, &end) > 1e-6 {
                    hopped.push((seed, step, away(&whole, &end), whole.iterations, whole.verdict()));
                }
            }
            if let Some(negative) = solver.inertia(&found).filter(|_| found.converged)
                && (negative == 0) != found.stable
            {
                miscounted.push((seed, step, negative));
            }
        }
    }
    println!(
        "{tolerance:e}: {poses} poses, paths to {} of them and from rest to {}; astray {astray:?}, hopped {hopped:?}, miscounted {miscounted:?}",
        walked[0], walked[1]
    );
    assert!(walked[0] * 10 > poses * 9 && walked[1] * 8 > poses, "{walked:?} of {poses}");
    assert!(astray.is_empty() && hopped.is_empty() && miscounted.is_empty());
}

/// Goes to a command in small steps, as long as equilibria are stable.
fn small_steps(
    solver: &mut BundleSolver,
    start: &BundleEquilibrium,
    command: &BundleCommand,
    steps: u32,
) -> Option<BundleEquilibrium> {
    let mut own = start.clone();
    for step in 1..=steps {
        let share = f64::from(step) / f64::from(steps);
        let mut moved = command.clone();
        for (drive, from) in moved.drives.iter_mut().zip(&start.command().drives) {
            let between = |to: Drive, from: Drive| {
                let first = if to.is_motion() == from.is_motion() { from.value() } else { 0.0 };
                to.with_value(first + share * (to.value() - first))
            };
            drive.translation = between(drive.translation, from.translation);
            drive.rotation = between(drive.rotation, from.rotation);
        }
        if start.command().loads.is_empty() {
            moved.loads = command.loads.scaled(share);
        }
        own = solver.continued(&moved, &own).filter(|own| own.stable)?;
    }
    Some(own)
}
