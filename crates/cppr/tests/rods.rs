//! A single rod (N = 1) against closed forms and tables.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{reference, robot, stiff_tube, vector};
use cppr::Vector3;
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Command, Settings, Solver, Status};
use cppr::statics::{DistributedForce, Loads, Wrench};
use serde_json::Value;
use std::f64::consts::PI;

/// Length 1, EI 1, GJ as given.
fn rod(torsion: f64) -> Robot {
    robot(1.0, vec![stiff_tube(0.0, [1.0, 1.0], torsion, 0.0, 0.0)])
}

fn case(name: &str) -> Value {
    let data = reference("rods");
    data["cases"].as_array().unwrap().iter().find(|c| c["name"] == name).unwrap().clone()
}

fn planar(modes: usize) -> Settings {
    let resolution = Resolution { bending_z: modes, nodes: 2 * modes, ..Resolution::PLANAR };
    Settings::default().with_resolution(resolution)
}

fn load(force: [f64; 3], moment: [f64; 3]) -> Command {
    let wrench = Wrench { moment: Vector3::from(moment), ..Wrench::tip_force(Vector3::from(force)) };
    Command::pull(&[]).with_loads(Loads { wrenches: vec![wrench], ..Loads::none() })
}

#[test]
fn elastica_under_a_transverse_dead_load() {
    let robot = rod(1.0);
    let mut solver = Solver::with_settings(&robot, planar(16)).unwrap();
    for (alpha, expected) in
        case("elastica_cantilever_transverse_dead_tip_load")["outputs"].as_object().unwrap()
    {
        let command = load([0.0, alpha.parse().unwrap(), 0.0], [0.0; 3]);
        let found = solver.solve(&command).unwrap();
        assert_eq!(found.status(), Status::Converged);
        let cppr::kinematics::TipPose { rotation, centre: tip } = solver.tip(&found);
        let got = [tip.y, 1.0 - tip.x, rotation[(1, 0)].atan2(rotation[(0, 0)])];
        for (got, key) in got.into_iter().zip(["w_over_L", "u_over_L", "theta_rad"]) {
            let want = expected[key].as_f64().unwrap();
            assert!((got - want).abs() < 1e-8, "{alpha}: {key} {got} {want}");
        }
    }
}

#[test]
fn elastica_beyond_buckling() {
    let robot = rod(1.0);
    let settings = planar(24);
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    for (angle, expected) in case("elastica_clamped_free_axial_postbuckling")["outputs"].as_object().unwrap()
    {
        let force = expected["PL2_over_EI"].as_f64().unwrap();
        // Bent to the right side first by a moment, then released to the axial load alone.
        let degrees: f64 = angle.parse().unwrap();
        let bend = degrees.to_radians() / 1.2;
        let bent = solver.solve(&load([0.0; 3], [0.0, 0.0, bend])).unwrap();
        let found = solver.solve_from(&load([-force, 0.0, 0.0], [0.0; 3]), &bent).unwrap();
        assert_eq!(found.status(), Status::Converged, "{angle} degrees");
        let tip = solver.tip(&found).centre;
        for (got, key) in [tip.x, tip.y].into_iter().zip(["x_over_L", "y_over_L"]) {
            let want = expected[key].as_f64().unwrap();
            assert!((got - want).abs() < 1e-8, "{angle} degrees: {key} {got} {want}");
        }
    }
}

#[test]
fn pure_bending_closes_a_circle() {
    let robot = rod(1.0);
    for (factor, expected) in case("pure_bending_to_circle")["outputs"].as_object().unwrap() {
        let moment = factor.trim_end_matches("*pi").parse::<f64>().unwrap() * PI;
        for (settings, moments) in
            [(planar(12), [0.0, 0.0, moment]), (Settings::default(), [0.0, 0.0, moment])]
        {
            let mut solver = Solver::with_settings(&robot, settings).unwrap();
            let found = solver.solve(&load([0.0; 3], moments)).unwrap();
            let tip = solver.tip(&found).centre;
            assert!((tip.x - expected["x"].as_f64().unwrap()).abs() < 1e-8);
            assert!((tip.y - expected["y"].as_f64().unwrap()).abs() < 1e-8);
            let bend = found.elastic_energy() - 0.5 * moment * moment;
            assert!(bend.abs() < 1e-8, "energy off by {bend}");
        }
    }
}

#[test]
fn helix_under_a_wrench() {
    let helix = case("helix_of_straight_rod_under_wrench");
    let robot = rod(0.7);
    let resolution = Resolution { twist: 16, bending_y: 16, bending_z: 16, nodes: 48, ..Resolution::SPATIAL };
    let settings = Settings { resolution, ..Settings::default() };
    let mut solver = Solver::with_settings(&robot, settings).unwrap();
    // There is more than one equilibrium under this wrench: come from the curvatures of the helix itself.
    let at = |factor: f64| {
        let (force, moment) = (vector(&helix["inputs"]["F"]), vector(&helix["inputs"]["M_tip"]));
        load((force * factor).into(), (moment * factor).into())
    };
    let mut found = solver.rest();
    for i in 1..=40 {
        found = solver.solve_from(&at(f64::from(i) / 40.0), &found).unwrap();
    }
    let cppr::kinematics::TipPose { rotation, centre: tip } = solver.tip(&found);
    let outputs = &helix["outputs"];
    let error = |got: Vector3<f64>, key: &str| (got - vector(&outputs[key])).norm();
    assert!(error(tip, "tip") < 1e-8, "{tip} {}", outputs["tip"]);
    assert!(error(rotation.column(0).into_owned(), "tip_tangent") < 1e-8);
    assert!(error(rotation.column(1).into_owned(), "tip_d2") < 1e-8);
    for section in solver.shape(&found, 9).sections {
        let turn = 2.0 * section.label;
        // κ b in axes that run ahead of the Frenet frame by (twist − τ) s; the reference's remark has sin with a
        // minus sign, with which its own tip is not reached.
        let expected = Vector3::new(5.0, 4.0 * turn.sin(), 4.0 * turn.cos());
        assert!((section.curvature - expected).norm() < 1e-8, "{} {expected}", section.curvature);
    }
}

/// The factor of a load at which the margin of the straight rod vanishes, by bisection.
fn critical(
    robot: &Robot,
    settings: &Settings,
    low: f64,
    high: f64,
    command: impl Fn(f64) -> Command,
) -> f64 {
    let mut solver = Solver::with_settings(robot, *settings).unwrap();
    let (mut low, mut high) = (low, high);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let found = solver.solve(&command(middle)).unwrap();
        let margin = solver.stability(&found).unwrap().margin;
        assert_eq!(found.status() == Status::Converged, margin > 0.0);
        if margin > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// A rod that leaves a frictionless sleeve: what drives it back is the change of energy with its free length.
#[test]
fn configurational_force_of_a_sliding_sleeve() {
    let sleeve = case("bigoni_sliding_sleeve_configurational_force");
    let (load_size, want) =
        (sleeve["inputs"]["P"].as_f64().unwrap(), |key: &str| sleeve["outputs"][key].as_f64().unwrap());
    let command = load([0.0, load_size, 0.0], [0.0; 3]);
    let potential = |length: f64| {
        let robot = robot(length, vec![stiff_tube(0.0, [1.0, 1.0], 1.0, 0.0, 0.0)]);
        let mut solver = Solver::with_settings(&robot, planar(16)).unwrap();
        let found = solver.solve(&command).unwrap();
        assert_eq!(found.status(), Status::Converged);
        let tip = solver.tip(&found).centre;
        let base = solver.shape(&found, 2).sections[0].tubes[0].moment.z;
        (found.elastic_energy() - load_size * tip.y, tip, base)
    };
    let (_, tip, moment) = potential(1.0);
    for (got, key) in [(tip.x, "tip_x"), (tip.y, "tip_y"), (moment, "M0")] {
        assert!((got - want(key)).abs() < 1e-8, "{key} {got}");
    }
    let step = 1e-3;
    let slope = |step: f64| (potential(1.0 + step).0 - potential(1.0 - step).0) / (2.0 * step);
    let force = -(4.0 * slope(step) - slope(2.0 * step)) / 3.0;
    assert!((force - want("F_config")).abs() < 1e-8, "{force}");
}

#[test]
fn critical_loads() {
    let outputs = case("critical_loads")["outputs"].clone();
    let want = |key: &str| outputs[key].as_f64().unwrap();
    let euler = critical(&rod(1.0), &planar(12), 1.0, 4.0, |p| load([-p, 0.0, 0.0], [0.0; 3]));
    assert!((euler - want("euler_clamped_free")).abs() < 1e-9, "{euler}");
    let weight = critical(&rod(1.0), &planar(12), 4.0, 10.0, |q| {
        let force = DistributedForce { force: Vector3::new(-q, 0.0, 0.0), from: 0.0, to: 1.0 };
        Command::pull(&[]).with_loads(Loads { distributed: vec![force], ..Loads::none() })
    });
    assert!((weight - want("self_weight_column_clamped_free_qL3_over_EI")).abs() < 1e-8, "{weight}");
    // Lateral buckling of a strip that is stiff in the plane of the load: the classical value neglects the
    // deflection before buckling, which goes to zero with EI_Z/EI_Y.
    let strip = robot(1.0, vec![stiff_tube(0.0, [1.0, 1e6], 1.0, 0.0, 0.0)]);
    let lateral = critical(&strip, &Settings::default(), 3.0, 6.0, |p| load([0.0, p, 0.0], [0.0; 3]));
    assert!((lateral - want("prandtl_lateral_cantilever_PL2_over_sqrt_EI_GJ")).abs() < 1e-5, "{lateral}");
}
