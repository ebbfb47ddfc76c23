//! One solver for several equilibria: whatever it looked at last, each answers for itself.
#![allow(clippy::unwrap_used)]

mod common;

use common::prototype;
use cppr::design::BelowPlate;
use cppr::solve::{Command, Settings, Solver};

#[test]
fn equilibria_do_not_see_each_other_through_the_workspace() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let _settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let other = solver.solve(&Command::pull(&[-3e-3])).unwrap();
    let own = solver.solve(&Command::pull(&[5e-3])).unwrap();
    let tip = Solver::new(&robot).tip(&own).centre;
    let away = solver.tip(&other).centre;
    assert!((away - tip).norm() > 0.01);
    // The solver still remembers to have solved `own` last, and must not take what it holds for it.
    let shape = solver.shape_at(&own, &[robot.length()]);
    assert!((shape.sections[0].centre - tip).norm() < 1e-12);
    assert!((solver.tip(&other).centre - away).norm() < 1e-12);
}
