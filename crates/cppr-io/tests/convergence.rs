//! Every shipped robot, far bent, from a cold start: it is solved, and the default resolution is fine enough.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::design::Robot;
use cppr::solve::{Command, Settings, Solver, Status};
use cppr::statics::Loads;

fn robot(name: &str) -> Robot {
    let path = format!("{}/../../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Robot::from_design(cppr_io::robot_file::read(path).unwrap().design).unwrap()
}

/// Pulls (mm), tip force (N).
type Case = (&'static str, &'static [f64], [f64; 3]);

const CASES: &[Case] = &[
    ("r1", &[7.0], [0.0; 3]),
    ("r1", &[-7.0], [0.0; 3]),
    ("r1", &[6.0], [0.0, 0.1962, 0.0]),
    ("r1", &[-4.0], [0.0, 0.0, 0.1962]),
    ("r2", &[7.0], [0.0; 3]),
    ("r2", &[-7.0], [0.0; 3]),
    ("r3", &[20.0], [0.0; 3]),
    ("r3", &[-20.0], [0.0; 3]),
    ("r4", &[20.0], [0.0; 3]),
    ("r4", &[-20.0], [0.0; 3]),
    ("r4", &[5.0], [0.0, 0.1, 0.1]),
    ("childs2", &[1.0], [0.0, 0.0, -0.4905]),
    ("childs2", &[-1.0], [0.0, 0.0, -0.4905]),
    ("childs3", &[1.0, -0.5], [0.0, 0.0, -0.5]),
    ("helicoid", &[10.0], [0.0; 3]),
    ("helicoid", &[-10.0], [0.0; 3]),
];

#[test]
fn the_default_resolution_is_within_1e_4_of_the_converged_tip() {
    for &(name, motions, force) in CASES {
        let robot = robot(name);
        let motions: Vec<f64> = motions.iter().map(|a| a * 1e-3).collect();
        let command = Command::pull(&motions).with_loads(Loads::tip_force(Vector3::from(force)));
        let tip = |settings: &Settings| {
            let found = Solver::with_settings(&robot, *settings).unwrap().solve(&command).unwrap();
            assert_eq!(found.status(), Status::Converged, "{name} {motions:?} {force:?}");
            assert_eq!(found.statistics().load_steps, 0, "{name} {motions:?} needed load stepping");
            assert!(found.statistics().iterations <= 10, "{name} {motions:?}: {:?}", found.statistics());
            found.tip().centre
        };
        let settings = Settings::default();
        let coarse = tip(&settings);
        let fine = tip(&settings.with_resolution(settings.resolution.refined(2)));
        let error = (coarse - fine).norm() / robot.length();
        println!("{name} {motions:?} {force:?}: {error:.2e}");
        assert!(error < 1e-4, "{name} {motions:?} {force:?}: the tip moves by {error} L when refined");
    }
}
