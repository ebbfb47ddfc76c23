//! Inverse problems: round trips, brute force, coverage of the stated intervals.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{Random, converged, prototype, robot, stiff_tube};
use cppr::Vector3;
use cppr::analysis::Teeth;
use cppr::analysis::inverse::{
    Accuracy, FreeInput, InverseProblem, Measured, ShapePoint, Target, free_near, free_within,
};
use cppr::design::{BelowPlate, Robot};
use cppr::solve::{Actuator, Command, Drive, Freedom, Settings, Solver, Status};
use cppr::statics::{Loads, Wrench};
use nalgebra::DVector;
use std::f64::consts::PI;

/// The three-tube robot of Childs and Rucker as section 4.9 has it.
fn childs3() -> Robot {
    let third = 2.0 * PI / 3.0;
    robot(
        0.03,
        vec![
            stiff_tube(1.12e-3, [196e-6, 178e-6], 273e-6, 0.0, 0.0),
            stiff_tube(0.983e-3, [181e-6, 178e-6], 278e-6, third, 0.0),
            stiff_tube(0.764e-3, [183e-6, 189e-6], 291e-6, -third, 0.0),
        ],
    )
}

struct Case {
    name: &'static str,
    robot: Robot,
    free: Vec<FreeInput>,
    /// Is a direction wanted as well?
    whole: bool,
}

fn cases() -> Vec<Case> {
    let free = |robot: &Robot, pull: f64, turn: f64| -> Vec<FreeInput> {
        Command::held(robot)
            .inputs()
            .map(|(input, _)| input)
            .collect::<Vec<_>>()
            .into_iter()
            .map(|input| {
                let reach = if input.freedom == Freedom::PushPull { pull } else { turn };
                FreeInput { input, bounds: [-reach, reach] }
            })
            .collect()
    };
    let (r1, r4) = (prototype("R1", 1.27, BelowPlate::Plain), prototype("R4", 1.06, BelowPlate::Plain));
    let c = childs3();
    let (free1, free4, free_c) = (free(&r1, 7e-3, 2.0), free(&r4, 6e-3, 1.4), free(&c, 2e-3, 0.5));
    let pulls = free_c.iter().copied().filter(|f| f.input.freedom == Freedom::PushPull).collect();
    vec![
        Case { name: "R1", robot: r1, free: free1, whole: false },
        Case { name: "R4", robot: r4, free: free4, whole: false },
        Case { name: "childs3, pulls", robot: c.clone(), free: pulls, whole: false },
        Case { name: "childs3, all", robot: c, free: free_c, whole: true },
    ]
}

fn with_values(robot: &Robot, free: &[FreeInput], values: &[f64]) -> Command {
    let mut command = Command::held(robot);
    for (own, &value) in free.iter().zip(values) {
        let actuator = &mut command.actuators[own.input.tube - 2];
        match own.input.freedom {
            Freedom::PushPull => actuator.push_pull = Drive::Motion(value),
            Freedom::Rotation => actuator.rotation = Drive::Motion(value),
        }
    }
    command
}

#[test]
fn reachable_poses_are_reached_within_the_bounds() {
    let settings = Settings::default();
    for case in cases() {
        let mut solver = Solver::new(&case.robot);
        let mut random = Random::new(5);
        for turn in 0..4 {
            let values: Vec<f64> =
                case.free.iter().map(|f| 0.95 * random.between(f.bounds[0], f.bounds[1])).collect();
            let command = with_values(&case.robot, &case.free, &values);
            let found = solver.solve(&command).unwrap();
            assert_eq!(found.status(), Status::Converged);
            let cppr::kinematics::TipPose { rotation, centre: position } = solver.tip(&found);
            let direction = case.whole.then(|| rotation.column(0) * 3.0);
            let target = Target { position: Some(position), direction };
            let held = Command::held(&case.robot);
            let accuracy = Accuracy::default();
            let answer = solver.reach(&held, &case.free, &target, &accuracy).unwrap();
            let what = format!("{} {turn}: {values:?} {:?} {:?}", case.name, answer.values, answer.distance);
            assert!(answer.reached, "{what}");
            assert!((answer.position - position).norm() < 1e-6 * case.robot.length(), "{what}");
            for (value, own) in answer.values.iter().zip(&case.free) {
                assert!(*value >= own.bounds[0] && *value <= own.bounds[1], "{what}");
            }
            // The command that is handed back leads there from rest, unless it is said to depend on the path.
            let again = converged(&case.robot, answer.equilibrium.command(), &settings);
            let off = (solver.tip(&again).centre - position).norm();
            assert_eq!(off > 1e-6 * case.robot.length(), answer.depends_on_path, "{what}");
        }
    }
}

#[test]
fn from_a_known_pose_its_neighbours_are_reached() {
    let (settings, accuracy) = (Settings::default(), Accuracy::default());
    for case in cases() {
        let mut solver = Solver::new(&case.robot);
        let start: Vec<f64> = case.free.iter().map(|f| 0.4 * f.bounds[1]).collect();
        let command = with_values(&case.robot, &case.free, &start);
        let start = converged(&case.robot, &command, &settings);
        let free: Vec<FreeInput> = free_near(&start)
            .into_iter()
            .filter(|near| case.free.iter().any(|own| own.input == near.input))
            .collect();
        assert_eq!(free.len(), case.free.len());
        let values: Vec<f64> = case.free.iter().map(|f| 0.5 * f.bounds[1]).collect();
        let wanted = with_values(&case.robot, &case.free, &values);
        let wanted = converged(&case.robot, &wanted, &settings);
        let cppr::kinematics::TipPose { rotation, centre: position } = wanted.tip();
        let target = Target {
            position: Some(position),
            direction: case.whole.then(|| rotation.column(0).into_owned()),
        };
        let answer = solver.reach_near(&start, &free, &target, &accuracy).unwrap();
        assert!(answer.reached && !answer.depends_on_path, "{}: {:?}", case.name, answer.distance);
        // Several combinations of four actuators can lead to one position.
        if case.name != "childs3, all" {
            for (got, want) in answer.values.iter().zip(&values) {
                assert!((got - want).abs() < 1e-5 * want.abs(), "{}: {got} {want}", case.name);
            }
        }
        // As near as the search over everything comes to a point out of reach straight beyond the tip.
        let beyond = Target { position: Some(1.3 * position), direction: None };
        let near = solver.reach_near(&start, &free, &beyond, &accuracy).unwrap();
        let all = solver.reach(&command, &free, &beyond, &accuracy).unwrap();
        assert!(!near.reached && !all.reached);
        assert!(near.distance.unwrap() < all.distance.unwrap() + 1e-6 * case.robot.length(), "{}", case.name);
        let nothing = solver.reach_near(&start, &free, &Target::default(), &accuracy);
        assert!(matches!(nothing, Err(InverseProblem::NothingGiven)));
    }
}

#[test]
fn out_of_reach_the_nearest_pose_is_that_of_brute_force() {
    let case = cases().remove(0);
    let mut solver = Solver::new(&case.robot);
    let grid = 41;
    for target in [Vector3::new(0.14, 0.02, 0.09), Vector3::new(0.05, 0.0, 0.0), Vector3::new(0.1, 0.2, 0.0)]
    {
        let wanted = Target { position: Some(target), direction: None };
        let held = Command::held(&case.robot);
        let answer = solver.reach(&held, &case.free, &wanted, &Accuracy::default()).unwrap();
        let mut least = f64::INFINITY;
        for i in 0..grid {
            for j in 0..grid {
                let share = |k: i32| 2.0 * f64::from(k) / f64::from(grid - 1) - 1.0;
                let values = [share(i) * case.free[0].bounds[1], share(j) * case.free[1].bounds[1]];
                let command = with_values(&case.robot, &case.free, &values);
                let found = solver.solve(&command).unwrap();
                if found.status() == Status::Converged {
                    let tip = solver.tip(&found).centre;
                    least = least.min((tip - target).norm());
                }
            }
        }
        let distance = answer.distance.unwrap();
        assert!(!answer.reached);
        // A pose between the points of the grid may be nearer, by at most what half a step moves the tip.
        assert!(distance < least + 1e-9 && distance > least - 6e-3, "{target}: {distance} {least}");
    }
}

#[test]
fn conditioning_moves_the_tip_along_its_axes() {
    let case = cases().remove(0);
    let held = Command::held(&case.robot);
    let mut solver = Solver::new(&case.robot);
    let accuracy = Accuracy::default();
    let target = Target { position: Some(Vector3::new(0.13, -0.05, 0.02)), direction: None };
    let answer = solver.reach(&held, &case.free, &target, &accuracy).unwrap();
    let conditioning = answer.conditioning.unwrap();
    let exact = solver.sensitivity(&answer.equilibrium).unwrap();
    assert_eq!(conditioning.axes.len(), 3);
    let movable: Vec<_> = conditioning.axes.iter().filter(|a| a.deviation > 0.0).collect();
    assert_eq!(movable.len(), 2, "two inputs move the tip in a surface");
    assert!(conditioning.idle.is_empty());
    for axis in movable {
        let shift: Vector3<f64> = (0..2)
            .map(|i| Vector3::from(exact.tip_jacobian.column(i).fixed_rows::<3>(0)) * axis.inputs[i])
            .sum();
        assert!((shift - axis.direction).norm() < 1e-9, "{axis:?} {shift}");
    }
    // Σ of the covariance J Σ Jᵀ.
    let total: f64 = [accuracy.translation, accuracy.rotation]
        .iter()
        .enumerate()
        .map(|(i, d)| (exact.tip_jacobian.column(i).fixed_rows::<3>(0) * *d).norm_squared())
        .sum();
    let sum: f64 = conditioning.axes.iter().map(|a| a.deviation * a.deviation).sum();
    assert!((sum - total).abs() < 1e-12 * total);
    let [best, worst] = [0, 1].map(|i| conditioning.axes[i].deviation);
    assert!(best > worst && (conditioning.condition - best / worst).abs() < 1e-12 * conditioning.condition);
    // A surface has no volume.
    assert!(conditioning.manipulability < 1e-30);

    // Four inputs move the tip everywhere, and one combination of them leaves it.
    let Case { robot, free, .. } = cases().remove(3);
    let mut solver = Solver::new(&robot);
    let held = Command::held(&robot);
    let target = Target { position: Some(Vector3::new(0.027, 4e-3, -5e-3)), direction: None };
    let answer = solver.reach(&held, &free, &target, &accuracy).unwrap();
    let conditioning = answer.conditioning.unwrap();
    let exact = solver.sensitivity(&answer.equilibrium).unwrap();
    let mut scaled = exact.tip_jacobian.rows(0, 3).into_owned();
    for (i, mut column) in scaled.column_iter_mut().enumerate() {
        column *= if i % 2 == 0 { accuracy.translation } else { accuracy.rotation };
    }
    let volume = (&scaled * scaled.transpose()).determinant().sqrt();
    assert!((conditioning.manipulability - volume).abs() < 1e-9 * volume && volume > 0.0);
    assert_eq!(conditioning.idle.len(), 1);
    let idle = DVector::from_column_slice(&conditioning.idle[0]);
    assert!((idle.norm() - 1.0).abs() < 1e-12 && (&scaled * idle).norm() < 1e-7 * scaled.norm());
}

#[test]
fn shapes_give_their_actuation_back() {
    let settings = Settings::default();
    for (case, labelled) in cases().into_iter().zip([true, false, false, true]) {
        let mut random = Random::new(11);
        let values: Vec<f64> =
            case.free.iter().map(|f| 0.9 * random.between(f.bounds[0], f.bounds[1])).collect();
        let command = with_values(&case.robot, &case.free, &values);
        let mut solver = Solver::new(&case.robot);
        let found = converged(&case.robot, &command, &settings);
        let shape = solver.shape(&found, 10);
        let points: Vec<ShapePoint> = shape.sections[1..]
            .iter()
            .map(|s| ShapePoint { label: labelled.then_some(s.label), position: s.centre, deviation: 1e-4 })
            .collect();
        let held = Command::held(&case.robot);
        let answer = solver.shape_match(&held, &case.free, &points).unwrap();
        assert!(answer.rms < 1e-7 * case.robot.length(), "{}: {}", case.name, answer.rms);
        let uncertainty = &answer.uncertainty;
        for (i, (got, want)) in answer.values.iter().zip(&values).enumerate() {
            let deviation = uncertainty.deviations[i];
            assert!(deviation.is_finite(), "{}: {uncertainty:?}", case.name);
            assert!((got - want).abs() < 1e-2 * deviation, "{}: {got} {want} ± {deviation}", case.name);
        }
    }
}

/// Two numbers with a standard normal distribution (Box and Muller).
fn normal(random: &mut Random) -> f64 {
    let (a, b) = (random.between(1e-12, 1.0), random.between(0.0, 2.0 * PI));
    (-2.0 * a.ln()).sqrt() * b.cos()
}

#[test]
fn forces_are_recovered_within_the_stated_intervals() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let actuator = Actuator { push_pull: Drive::Motion(5e-3), rotation: Drive::Motion(0.3) };
    let command = Command { actuators: vec![actuator], ..Command::held(&robot) };
    let force = Vector3::new(0.03, -0.12, 0.08);
    let loaded = command.clone().with_loads(Loads::tip_force(force));
    let truth = converged(&robot, &loaded, &settings);
    let cppr::kinematics::TipPose { rotation, centre: position } = solver.tip(&truth);
    let state = truth.actuators()[0];
    let (tension, torque, place, turn) = (0.02, 5e-4, 3e-4, 5e-3);
    let mut random = Random::new(2);
    let (mut inside, mut misfit, mut spread, seeds) = ([0; 3], 0.0, 0.0, 150);
    for _ in 0..seeds {
        let mut noise = |size: f64| size * normal(&mut random);
        let mut vector = |size: f64| Vector3::new(noise(size), noise(size), noise(size));
        let (shift, spin, other) = (vector(place), vector(turn), vector(1.0));
        let measured = [
            Measured::Effort(2, Freedom::PushPull, state.tension + other.x * tension, tension),
            Measured::Effort(2, Freedom::Rotation, state.torque + other.y * torque, torque),
            Measured::Position(position + shift, place),
            Measured::Direction(rotation.column(0) + spin, turn),
        ];
        let answer = solver.sense(&command, &measured, false).unwrap();
        for axis in 0..3 {
            let half = 1.959_964 * answer.uncertainty.deviations[axis];
            assert!(half < 0.2, "the measurements see the force: {half}");
            inside[axis] += i32::from((answer.force[axis] - force[axis]).abs() <= half);
        }
        let error = answer.force - force;
        let inverse = answer.uncertainty.covariance.clone().try_inverse().unwrap();
        spread += (error.transpose() * inverse * error)[0] / f64::from(3 * seeds);
        misfit += answer.uncertainty.misfit.powi(2) / f64::from(seeds);
    }
    // 95 % of 150 is 142.5 with a deviation of 2.7: four of them either way.
    for count in inside {
        assert!((132..=150).contains(&count), "{inside:?}");
    }
    // The covariance is as wide as the errors: χ² with three degrees of freedom, a deviation of √(2/(3 · 150)) over all seeds.
    assert!((spread - 1.0).abs() < 4.0 * (2.0 / 450.0_f64).sqrt(), "{spread}");
    // χ² over its four degrees of freedom has mean 1 and, over 150 seeds, a deviation of √(2/(4 · 150)).
    assert!((misfit - 1.0).abs() < 4.0 * (2.0 / 600.0_f64).sqrt(), "{misfit}");
}

#[test]
fn what_efforts_alone_do_not_see_is_named() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let command = Command::pull(&[4e-3]);
    let force = Vector3::new(0.0, 0.05, 0.0);
    let truth = converged(&robot, &command.clone().with_loads(Loads::tip_force(force)), &settings);
    let measured = [Measured::Effort(2, Freedom::PushPull, truth.actuators()[0].tension, 0.01)];
    let answer = solver.sense(&command, &measured, false).unwrap();
    // One number sees one combination, in the plane of the bend.
    let blind: Vec<_> = answer.uncertainty.principal.iter().filter(|p| p.blind).collect();
    assert_eq!(blind.len(), 2);
    assert!(blind.iter().any(|p| p.direction[2].abs() > 0.999), "{blind:?}");
    assert!(answer.uncertainty.deviations.iter().all(|d| d.is_infinite()));
    // The answer explains what was measured; half a kilonewton is explained by nothing.
    assert!(answer.misses[0] < 1e-6);
    let absurd = [Measured::Effort(2, Freedom::PushPull, 500.0, 0.01)];
    let none = solver.sense(&command, &absurd, false).unwrap();
    let left = (none.equilibrium.actuators()[0].tension - 500.0) / 0.01;
    assert!(none.misses[0] > 1e4 && (none.misses[0] - left.abs()).abs() < 1e-9 * none.misses[0]);
    assert!((answer.equilibrium.actuators()[0].tension - truth.actuators()[0].tension).abs() < 1e-9);
    // A whole wrench from a whole pose and both efforts.
    let moment = Vector3::new(1e-3, 2e-3, -3e-3);
    let wrench = Wrench { moment, ..Wrench::tip_force(force) };
    let loads = Loads { wrenches: vec![wrench], ..Loads::none() };
    let truth = converged(&robot, &command.clone().with_loads(loads), &settings);
    let cppr::kinematics::TipPose { rotation, centre: position } = solver.tip(&truth);
    let measured = [
        Measured::Effort(2, Freedom::PushPull, truth.actuators()[0].tension, 1e-4),
        Measured::Effort(2, Freedom::Rotation, truth.actuators()[0].torque, 1e-6),
        Measured::Position(position, 1e-6),
        Measured::Direction(rotation.column(0).into_owned(), 1e-5),
    ];
    let answer = solver.sense(&command, &measured, true).unwrap();
    for axis in 0..3 {
        let deviations = &answer.uncertainty.deviations;
        assert!((answer.force[axis] - force[axis]).abs() < 0.1 * deviations[axis].min(1.0));
        assert!((answer.moment[axis] - moment[axis]).abs() < 0.1 * deviations[3 + axis].min(1.0));
    }
}

#[test]
fn bounds_come_from_the_limits() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let held = Command::held(&robot);
    let mut solver = Solver::new(&robot);
    let ranges = solver.safe_ranges(&held, Teeth::Rigid).unwrap();
    let free = free_within(&robot, &ranges);
    assert_eq!(free.len(), 2);
    // Nothing limits the rotation of a straight robot: half a turn to either side.
    assert!((free[1].bounds[0] + PI).abs() < 1e-12 && (free[1].bounds[1] - PI).abs() < 1e-12);
    assert!(free[0].bounds[0] < -5e-3 && free[0].bounds[1] > 5e-3);
}

#[test]
fn what_cannot_be_asked_is_said() {
    let robot = prototype("R1", 1.27, BelowPlate::Plain);
    let _settings = Settings::default();
    let mut solver = Solver::new(&robot);
    let held = Command::held(&robot);
    let free: Vec<FreeInput> =
        held.inputs().map(|(input, _)| FreeInput { input, bounds: [-1e-3, 1e-3] }).collect();
    let accuracy = Accuracy::default();
    let mut ask =
        |free: &[FreeInput], target: Target| solver.reach(&held, free, &target, &accuracy).unwrap_err();
    let here = Target { position: Some(Vector3::new(0.15, 0.0, 0.0)), direction: None };
    assert_eq!(ask(&[], here), InverseProblem::NothingFree);
    assert_eq!(ask(&free, Target::default()), InverseProblem::NothingGiven);
    let upside_down = [FreeInput { bounds: [1e-3, -1e-3], ..free[0] }];
    assert_eq!(ask(&upside_down, here), InverseProblem::Bounds(free[0].input));
    let nowhere = Target { position: Some(Vector3::new(f64::NAN, 0.0, 0.0)), direction: None };
    assert_eq!(ask(&free, nowhere), InverseProblem::NotFinite("the wanted position"));
    let still = Target { position: None, direction: Some(Vector3::zeros()) };
    assert_eq!(ask(&free, still), InverseProblem::NotFinite("the wanted direction"));
    let point = ShapePoint { label: Some(0.2), position: Vector3::zeros(), deviation: 1e-3 };
    let problem = solver.shape_match(&held, &free, &[point]).unwrap_err();
    assert_eq!(problem, InverseProblem::Label(0.2));
    let effort = [Measured::Effort(3, Freedom::PushPull, 1.0, 0.1)];
    let problem = solver.sense(&held, &effort, false).unwrap_err();
    assert_eq!(problem, InverseProblem::EffortPrescribed(3));
}
