//! Margin and limits of poses that are solved side by side against those of every pose alone.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{prototype, three_with_edges};
use cppr::Vector3;
use cppr::analysis::{SectionLimit, Teeth};
use cppr::design::{BelowPlate, Outline, Profile, Robot, TubeDesign};
use cppr::kinematics::Resolution;
use cppr::many::{March, Start};
use cppr::solve::{Command, Drive, Settings, Solver, Status};
use cppr::statics::Loads;
use std::ops::ControlFlow;

/// With an allowable strain, whatever else is changed.
fn changed(robot: &Robot, change: impl Fn(&mut cppr::design::NotchedTube)) -> Robot {
    let mut design = robot.design().clone();
    for tube in &mut design.tubes {
        let TubeDesign::Notched(tube) = tube else { panic!("no notches") };
        tube.material.allowable_strain = Some(0.015);
        change(tube);
    }
    Robot::from_design(design).unwrap()
}

fn robots() -> Vec<Robot> {
    let plain = |name: &str| prototype(name, 1.2, BelowPlate::Plain);
    let mut robots: Vec<Robot> = ["R1", "R2", "R3", "R4"].map(|name| changed(&plain(name), |_| {})).into();
    robots.push(changed(&prototype("R1", 1.2, BelowPlate::Continued), |_| {}));
    robots.push(changed(&three_with_edges(), |_| {}));
    // Without known notches, judged at sections: of constant and of varying depth.
    robots.push(changed(&plain("R1"), |tube| tube.pattern = None));
    robots.push(changed(&plain("R3"), |tube| tube.pattern = None));
    robots.push(changed(&plain("R1"), |tube| {
        if let Outline::Round { outer_radius, inner_radius } = tube.outline {
            tube.outline =
                Outline::Polygon { sides: 4, outer_apothem: outer_radius, inner_apothem: inner_radius };
        }
    }));
    robots.push(changed(&plain("R2"), |tube| tube.direction = Profile::linear(0.0, 1.5)));
    robots
}

#[test]
fn what_is_derived_side_by_side_is_what_it_is_alone() {
    let settings = [Settings::default(), Settings::planar()];
    let mut march = March::new(Solver::new(&robots()[0]));
    let (mut judged, mut stable) = (0, 0);
    for (number, robot) in robots().iter().enumerate() {
        for settings in settings.iter().filter(|s| s.resolution.angle > 0 || robot.is_planar()) {
            let planar = settings.resolution.angle == 0;
            let force = Vector3::new(0.0, 0.02, if planar { 0.0 } else { 0.03 });
            let base = Command::held(robot).with_loads(Loads::tip_force(force));
            let mut alone = Solver::with_settings(robot, *settings).unwrap();
            march.solver().copy_task(&alone);
            let put = |pose: usize, command: &mut Command| {
                let t = pose as f64 / 19.0 - 1.0;
                command.actuators[0].push_pull = Drive::Motion(0.03 * t * robot.length());
                command.actuators[0].rotation = Drive::Motion(if planar { 0.0 } else { 0.7 * t });
            };
            let flow = march.run(&base, Start::Neighbour, 39, put, |pose, solved| {
                let mut solved = solved.unwrap();
                let found = solved.equilibrium.clone();
                let at = format!("robot {number}, pose {pose}");
                if !found.status().is_equilibrium() {
                    assert!(solved.margin().is_none(), "{at}");
                    return ControlFlow::<()>::Continue(());
                }
                let near = |got: f64, wanted: f64, what: &str| {
                    assert!(
                        (got - wanted).abs() < 1e-12 * (1.0 + wanted.abs()),
                        "{at}, {what}: {got} {wanted}"
                    );
                };
                let whole = alone.stability(&found).unwrap();
                near(solved.margin().unwrap(), whole.margin, "margin");
                near(alone.margin(&found).unwrap(), whole.margin, "margin alone");
                assert_eq!(whole.margin > 0.0, found.status() == Status::Converged, "{at}");
                stable += usize::from(whole.inertia == 0);
                for teeth in [Teeth::Rigid, Teeth::Bending] {
                    let sections = alone.section_limits(&found, teeth);
                    let most = |value: fn(&SectionLimit) -> Option<f64>| {
                        sections.iter().filter_map(value).reduce(f64::max)
                    };
                    let wanted = [most(SectionLimit::strain_utilisation), most(|s| s.closure)];
                    for used in [solved.utilisation(teeth), alone.utilisation(&found, teeth)] {
                        for (got, wanted) in [used.strain, used.closure].into_iter().zip(wanted) {
                            assert_eq!(got.is_some(), wanted.is_some(), "{at}");
                            if let (Some(got), Some(wanted)) = (got, wanted) {
                                near(got, wanted, "utilisation");
                                judged += 1;
                            }
                        }
                    }
                }
                ControlFlow::Continue(())
            });
            assert!(flow.is_continue());
        }
    }
    assert!(stable > 400 && judged > 2000, "{stable} {judged}");
}

/// One mode that a prescribed motion holds.
#[test]
fn without_free_motions_there_is_no_margin_side_by_side_or_alone() {
    let robot = prototype("R1", 1.2, BelowPlate::Plain);
    let resolution =
        Resolution { twist: 0, bending_y: 0, bending_z: 1, angle: 0, stretch: 0, ..Resolution::PLANAR };
    let settings = Settings::planar().with_resolution(resolution);
    let base = Command::held(&robot);
    let mut alone = Solver::with_settings(&robot, settings).unwrap();
    let mut march = March::new(alone.clone());
    let put = |pose: usize, command: &mut Command| {
        command.actuators[0].push_pull = Drive::Motion(1e-4 * pose as f64);
    };
    let mut held = 0;
    let flow = march.run(&base, Start::Neighbour, 16, put, |_, solved| {
        let mut solved = solved.unwrap();
        assert!(solved.equilibrium.status().is_equilibrium() && solved.margin().is_none());
        assert!(alone.margin(solved.equilibrium).is_none());
        held += 1;
        ControlFlow::<()>::Continue(())
    });
    assert!(flow.is_continue() && held == 16);
}
