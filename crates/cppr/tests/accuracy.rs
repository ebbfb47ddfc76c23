//! What is said of the discretisation error holds: against four times as many modes, on random robots.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::cases::random_case;
use common::seeds;
use cppr::analysis::ACCURACY;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Equilibrium, Formulation, Settings, Solver, Status};

/// Robots that are tried; `CPPR_CASES` sets others.
const CASES: u64 = 24;

/// Every answer has an error. That of the default answer is its distance from the answer of four times as many modes, but for what is left
/// of that one's, and both are stable; that of the answer that adapts is within what was asked for, or says that it is not, and is not exceeded threefold. With as few modes as
/// suffice the answer is the same within what was asked for, and as stable.
#[test]
fn errors_are_those_against_finer_modes() {
    let seeds = seeds(CASES);
    let cases = seeds.end - seeds.start;
    let (mut solved, mut integrated, mut coarse, mut reached, mut compared) = (0, 0, 0_u64, 0_u64, 0);
    let (mut spared, mut spoilt) = (0, Vec::new());
    let (mut unknown, mut wrong, mut exceeded, mut disagree, mut margins) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for seed in seeds {
        let (design, command) = random_case(seed);
        let robot = Robot::from_design(design).unwrap();
        let length = robot.length();
        let mut solver = Solver::new(&robot);
        let Ok(found) = solver.solve(&command) else { continue };
        if found.status() != Status::Converged {
            continue;
        }
        solved += 1;
        let (resolved, error) = solver.solve_resolved(&command, ACCURACY).unwrap();
        let Some(error) = error else {
            unknown.push(seed);
            continue;
        };
        reached += u64::from(error.tip <= ACCURACY * length);
        let settings = Settings { resolution: Resolution::SPATIAL.refined(4), ..Settings::default() };
        let mut finer = Solver::with_settings(&robot, settings).unwrap();
        let Ok(finest) = finer.solve(&command) else { continue };
        if finest.status() != Status::Converged {
            continue;
        }
        let from_finest = |other: &Equilibrium| (finest.tip().centre - other.tip().centre).norm();
        let left = finer.accuracy(&finest).map_or(from_finest(&resolved), |left| left.tip);
        if from_finest(&resolved) > 3.0 * error.tip + left + 1e-7 * length {
            exceeded.push((seed, from_finest(&resolved) / length, error));
        }
        let few = solver.fewest_modes(std::slice::from_ref(&command), ACCURACY);
        if few.settings.resolution.nodes < Resolution::SPATIAL.nodes {
            spared += 1;
            let own = Solver::with_settings(&robot, few.settings).unwrap().solve(&command).unwrap();
            let bound = ACCURACY * length + left;
            if own.status() != Status::Converged || from_finest(&own) > bound || few.error.is_none() {
                spoilt.push((seed, own.status(), from_finest(&own) / length, few));
            }
        }
        if let Some(error) = solver.margin_error(&found) {
            let [own, finest] =
                [solver.stability(&found), finer.stability(&finest)].map(|own| own.unwrap().margin);
            if (own - finest).abs() > 3.0 * error + 1e-7 {
                margins.push((seed, own, finest, error));
            }
        }
        if let Some(own) = solver.accuracy(&found) {
            integrated += 1;
            if own.stable != solver.stability(&found).map(|own| own.inertia == 0) {
                disagree.push((seed, own));
            }
            coarse += u64::from(own.tip > ACCURACY * length);
            compared += 1;
            if (from_finest(&found) - own.tip).abs() > left + 1e-6 * length {
                wrong.push((seed, from_finest(&found) / length, own.tip / length, left / length));
            }
        }
    }
    println!(
        "{solved} solved, {integrated} integrated, {coarse} of them coarser than {ACCURACY:e}, {reached} reached; no error {unknown:?}; \
         {compared} compared, wrong {wrong:?}, exceeded {exceeded:?}, margins {margins:?}; {spared} with fewer modes, wrong {spoilt:?}"
    );
    assert!(solved * 10 > cases * 6, "{solved}");
    assert!(unknown.is_empty(), "{unknown:?}");
    assert!(reached * 100 >= solved * 80, "{reached} of {solved}");
    assert!(wrong.is_empty() && compared * 10 > solved * 7, "{compared}, {wrong:?}");
    assert!(exceeded.is_empty(), "{exceeded:?}");
    assert!(spoilt.is_empty() && spared * 4 > solved, "{spared} of {solved}: {spoilt:?}");
    assert!(margins.is_empty(), "{margins:?}");
    assert!(disagree.is_empty(), "stable or not: {disagree:?}");
}

/// Answers that have no integrated counterpart have no estimate.
#[test]
fn the_printed_formulation_has_no_estimate() {
    let (design, command) = random_case(0);
    let robot = Robot::from_design(design).unwrap();
    let settings = Settings { formulation: Formulation::Printed, ..Settings::default() };
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    let found = solver.solve(&command).unwrap();
    assert!(solver.accuracy(&found).is_none());
}
