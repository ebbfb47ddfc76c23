//! Random bundles of 1 to 5 tubes with up to 3 joints: equilibria are found, or it is said where their path ends; what is found is as
//! accurate as it claims, turns with the plate, and is the same whether a motor's travel or its force is prescribed.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::random_bundle::random_bundle;
use cppr::Vector3;
use cppr::bundle::Bundle;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use cppr::solve::Drive;
use nalgebra::Rotation3;

/// Bundles that are tried; `CPPR_CASES` sets another number.
const CASES: u64 = 60;

#[test]
fn any_bundle_has_its_equilibrium_or_the_reason_why_not() {
    let cases = std::env::var("CPPR_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(CASES);
    let (mut stable, mut ended, mut unknown, mut unreached) = (0_u64, 0_u64, Vec::new(), Vec::new());
    let (mut coarse, mut turned_away, mut forced_away, mut unrested) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for seed in 0..cases {
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
