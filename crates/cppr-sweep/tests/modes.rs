//! What a sweep loses by few modes: tip error of both resolutions against a refined one, as docs/src/sweeps.md states it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Settings, Solver};
use cppr::statics::Loads;
use std::path::Path;

/// Largest tip error over nine poses of the workspace, pulled, pushed and turned, with and without a load across, relative to
/// the length.
fn error(robot: &Robot, resolution: Resolution) -> f64 {
    let length = robot.length();
    let mut worst = 0.0_f64;
    let weight = (0..robot.tube_count()).map(|t| robot.fields_at(t, 0.5 * length).bending_z).sum::<f64>();
    for share in [-1.0, 0.5, 1.0] {
        for (turn, force) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.3)] {
            let mut command = Command::held(robot);
            // A twentieth of the length at most, about 60° of bending for R1.
            let actuator = Actuator {
                push_pull: Drive::Motion(0.04 * share * length),
                rotation: Drive::Motion(turn * std::f64::consts::FRAC_PI_2),
            };
            command.actuators[0] = actuator;
            let across = Vector3::new(0.0, 0.0, force * weight / (length * length));
            command.loads = if force > 0.0 { Loads::tip_force(across) } else { Loads::none() };
            let tip = |resolution: Resolution| {
                let settings = Settings::default().with_resolution(resolution);
                let found = Solver::with_settings(robot, settings).unwrap().solve(&command).unwrap();
                assert!(found.status().is_equilibrium(), "{}: {command:?}", robot.design().name);
                found.tip().centre
            };
            worst = worst.max((tip(resolution) - tip(Resolution::SPATIAL.refined(2))).norm() / length);
        }
    }
    worst
}

#[test]
fn errors_are_those_of_the_documentation() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/src/sweeps.md")).unwrap();
    let stated = page.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let file = cells.get(1)?.strip_prefix('`')?.strip_suffix(".toml`")?;
        Some((file.to_owned(), cells[2].parse::<f64>().unwrap(), cells[3].parse::<f64>().unwrap()))
    });
    let mut seen = 0;
    for (file, default, paper) in stated {
        let file = cppr_io::robot_file::read(root.join(format!("robots/{file}.toml"))).unwrap();
        let robot = Robot::from_design(file.design).unwrap();
        for (resolution, stated) in [(Resolution::SPATIAL, default), (Resolution::PAPER, paper)] {
            let found = error(&robot, resolution);
            let name = &robot.design().name;
            assert!(found <= stated && found > 0.4 * stated, "{name}: stated {stated:e}, found {found:e}");
        }
        seen += 1;
    }
    assert_eq!(seen, 7, "robots in the table");
}
