//! One workspace for several equilibria: whatever it looked at last, each answers for itself.
#![allow(clippy::unwrap_used)]

mod common;

use common::prototype;
use cppr::analysis::Shape;
use cppr::analysis::shape::tip_pose;
use cppr::design::BelowPlate;
use cppr::solve::{Command, Settings, Workspace, solve};

#[test]
fn equilibria_do_not_see_each_other_through_the_workspace() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let settings = Settings::default();
    let mut workspace = Workspace::new();
    let other = solve(&robot, &mut workspace, &Command::pull(&[-3e-3]), &settings).unwrap();
    let own = solve(&robot, &mut workspace, &Command::pull(&[5e-3]), &settings).unwrap();
    let tip = tip_pose(&robot, &mut Workspace::new(), &own).1;
    let away = tip_pose(&robot, &mut workspace, &other).1;
    assert!((away - tip).norm() > 0.01);
    // The workspace still remembers to have solved `own` last, and must not take what it holds for it.
    let shape = Shape::at(&robot, &mut workspace, &own, &[robot.length()]);
    assert!((shape.sections[0].centre - tip).norm() < 1e-12);
    assert!((tip_pose(&robot, &mut workspace, &other).1 - away).norm() < 1e-12);
}
