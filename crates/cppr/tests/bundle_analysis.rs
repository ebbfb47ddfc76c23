//! Derivatives, limits and inverse problems of bundles: against those of the modal solver on robots that both know, and against what was
//! put in.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::bundle_cases::{cases, command, design};
use common::{prototype, stiff_tube};
use cppr::Vector3;
use cppr::analysis::inverse::{Accuracy, FreeInput, Measured, ShapePoint, Target};
use cppr::analysis::{BundleAnalysis, Limit, MovedBundle, SafeRange, Settled, Teeth};
use cppr::bundle::solve::{BundleCommand, BundleSolver, TubeDrive};
use cppr::bundle::{Bundle, BundleDesign, Part, TubeParts};
use cppr::design::{BelowPlate, Robot, TubeDesign};
use cppr::kinematics::Resolution;
use cppr::solve::{Actuator, Command, Drive, Freedom, Input, Settings, Solver};
use cppr::statics::{Loads, Wrench};

fn followers(command: &Command) -> BundleCommand {
    let drive = |a: &Actuator| TubeDrive { translation: a.push_pull, rotation: a.rotation };
    let drives = std::iter::once(TubeDrive::HELD).chain(command.actuators.iter().map(drive)).collect();
    BundleCommand { drives, loads: command.loads.clone() }
}

fn three() -> Robot {
    common::robot(
        0.1,
        vec![
            stiff_tube(2e-3, [4e-3, 3e-3], 2e-3, 0.0, 0.0),
            stiff_tube(1.5e-3, [2e-3, 1.5e-3], 1e-3, 3.0, 0.0),
            stiff_tube(1e-3, [1e-3, 0.8e-3], 0.6e-3, 1.5, 0.0),
        ],
    )
}

/// Jacobians, compliance and responses are those of the modal solver at many modes, loaded and not, driven by motions and by efforts.
#[test]
fn derivatives_are_those_of_the_modal_solver() {
    let robot = three();
    let design = BundleDesign::from(robot.design());
    let bundle = Bundle::new(&design).unwrap();
    let mut solver = BundleSolver::new(&bundle).with_tolerance(1e-10);
    let settings = Settings { resolution: Resolution::SPATIAL.refined(3), ..Settings::default() };
    let mut modal = Solver::with_settings(&robot, settings).unwrap();
    let pulled = |a: Drive, b: Drive, rotation: Drive| {
        let mut command = Command::held(&robot);
        command.actuators[0].push_pull = a;
        command.actuators[1].push_pull = b;
        command.actuators[1].rotation = rotation;
        command
    };
    let motions = pulled(Drive::Motion(2e-3), Drive::Motion(-1e-3), Drive::Motion(0.4));
    let efforts = pulled(Drive::Effort(1.5), Drive::Motion(1e-3), Drive::Effort(2e-3));
    let force = Loads::tip_force(Vector3::new(0.05, -0.1, 0.15));
    for command in
        [motions.clone(), efforts.clone(), motions.with_loads(force.clone()), efforts.with_loads(force)]
    {
        let expected = modal.solve(&command).unwrap();
        let expected = modal.sensitivity(&expected).unwrap();
        let found = solver.solve(&followers(&command));
        assert!(found.converged && found.stable);
        let own = solver.sensitivity(&found).unwrap();
        // Of followers: columns from the third on.
        assert_eq!(own.inputs[2..], expected.inputs[..]);
        let m = expected.inputs.len();
        for (name, own, other) in [
            ("tip", own.tip_jacobian.columns(2, m).into_owned(), expected.tip_jacobian),
            ("response", own.response.view((2, 2), (m, m)).into_owned(), expected.response),
            ("by wrench", own.response_by_wrench.rows(2, m).into_owned(), expected.response_by_wrench),
            (
                "compliance",
                nalgebra::DMatrix::from_column_slice(6, 6, own.compliance.as_slice()),
                nalgebra::DMatrix::from_column_slice(6, 6, expected.compliance.as_slice()),
            ),
        ] {
            for (a, b) in own.row_iter().zip(other.row_iter()) {
                let scale = b.amax();
                assert!(scale > 0.0 && (a - b).amax() < 2e-5 * scale, "{name}: {a} for {b}");
            }
        }
    }
}

/// The response of the motors' efforts to motions is symmetric, and so is the compliance of an unloaded tip (Maxwell, Betti); the rows by a wrench
/// are the columns by motions (virtual work). On the cases of the independent program: joints on the way, free tips, curved tubes.
/// Bends of many turns, of which the plate's unknowns alone say nothing any more, are found where the modal solver has them.
#[test]
fn great_bends_are_those_of_the_modal_solver() {
    let robot = prototype("R1", 1.27, BelowPlate::Continued);
    let bundle = Bundle::new(&BundleDesign::from(robot.design())).unwrap();
    let settings = Settings { resolution: Resolution::PLANAR.refined(4), ..Settings::default() };
    for motion in [-60e-3, 60e-3, 100e-3] {
        let command = Command::pull(&[motion]);
        let expected = Solver::with_settings(&robot, settings).unwrap().solve(&command).unwrap();
        let found = BundleSolver::new(&bundle).solve(&followers(&command));
        assert!(found.converged && found.stable, "{motion}: {}", found.verdict());
        let off = (found.tip - expected.tip().centre).norm() / robot.length();
        let tension = expected.actuators()[0].tension;
        assert!(off < 1e-7, "{motion}: the tip is off by {off:e} of the length");
        assert!(
            (found.efforts[1].force / tension - 1.0).abs() < 1e-7,
            "{motion}: {} N for {tension}",
            found.efforts[1].force
        );
    }
}

#[test]
fn derivatives_obey_reciprocity() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        let bundle = Bundle::new(&design(&case)).unwrap();
        let mut solver = BundleSolver::new(&bundle).with_tolerance(1e-10);
        let found = solver.solve(&command(&case));
        let own = solver.sensitivity(&found).unwrap();
        let scale = own.response.amax();
        assert!(scale > 0.0 && (&own.response - own.response.transpose()).amax() < 1e-5 * scale, "{name}");
        let forces = own.compliance.fixed_view::<3, 3>(0, 0);
        assert!(forces.amax() > 0.0 && (forces - forces.transpose()).amax() < 1e-5 * forces.amax(), "{name}");
        let work = own.response_by_wrench.columns(0, 3) + own.tip_jacobian.rows(0, 3).transpose();
        let size = own.tip_jacobian.rows(0, 3).amax();
        assert!(work.amax() < 1e-5 * size, "{name}: {work}");
    }
}

/// Strain, closure and shear of every notch are those of the modal solver.
#[test]
fn notches_are_judged_as_in_a_robot_of_one_length() {
    let mut design = prototype("R1", 1.0, BelowPlate::Plain).design().clone();
    for tube in &mut design.tubes {
        let TubeDesign::Notched(tube) = tube else { panic!("R1 is notched") };
        let pattern = tube.pattern.as_mut().unwrap();
        // Notches as short as those of a saw.
        (pattern.length, pattern.tooth) = (0.2 * pattern.pitch(), 0.8 * pattern.pitch());
    }
    let robot = Robot::from_design(design).unwrap();
    let design = BundleDesign::from(robot.design());
    let bundle = Bundle::new(&design).unwrap();
    let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle), &design);
    let settings = Settings { resolution: Resolution::SPATIAL.refined(3), ..Settings::default() };
    let mut modal = Solver::with_settings(&robot, settings).unwrap();
    let mut command = Command::held(&robot);
    command.actuators[0].push_pull = Drive::Motion(4.5e-3);
    command.actuators[0].rotation = Drive::Motion(0.5);
    let expected = modal.solve(&command).unwrap();
    let expected = modal.section_limits(&expected, Teeth::Rigid);
    let found = analysis.solver.solve(&followers(&command));
    let own = analysis.section_limits(&found, Teeth::Rigid);
    assert!(!expected.is_empty());
    assert_eq!(own.len(), expected.len());
    let greatest = |value: fn(&cppr::analysis::SectionLimit) -> f64| {
        expected.iter().map(value).fold(0.0, |m: f64, v| m.max(v.abs()))
    };
    let scales = [greatest(|s| s.strain), greatest(|s| s.closure.unwrap_or(0.0)), greatest(|s| s.shear)];
    for (a, b) in own.iter().zip(&expected) {
        assert_eq!((a.tube, a.place), (b.tube, b.place));
        assert!((a.abscissa - b.abscissa).abs() < 1e-12);
        let pairs =
            [(a.strain, b.strain), (a.closure.unwrap_or(0.0), b.closure.unwrap_or(0.0)), (a.shear, b.shear)];
        for ((a_value, b_value), scale) in pairs.into_iter().zip(scales) {
            assert!(scale > 0.0 && (a_value - b_value).abs() < 2e-3 * scale, "{a:?}\n{b:?}");
        }
    }
    // And so are the ends of ranges that the modes resolve.
    let expected = modal.safe_ranges(&command, Teeth::Rigid).unwrap();
    let pull = Input { tube: 2, freedom: Freedom::PushPull, is_motion: true };
    let end = |ranges: &[SafeRange]| ranges.iter().find(|own| own.input == pull).unwrap().high;
    let own = analysis.safe_range(&followers(&command), pull, Teeth::Rigid).unwrap();
    let (own, expected) = (end(&[own]), end(&expected));
    assert!((own.value - expected.value).abs() < 2e-4 * expected.value, "{own:?} for {expected:?}");
    let limits = [own, expected].map(|end| end.nearest.unwrap().limit);
    assert_eq!(limits, [Limit::Closure; 2]);
}

/// What a known command does is led back to it: a tip, a shape, and a force from efforts and position.
#[test]
fn inverse_problems_find_what_was_put_in() {
    let case = cases().into_iter().find(|case| case["joints"].as_array().unwrap().len() > 1).unwrap();
    let design = design(&case);
    let bundle = Bundle::new(&design).unwrap();
    let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle), &design);
    let known = command(&case);
    let found = analysis.solver.solve(&known);
    let length = bundle.length();
    let last = known.drives.len();
    let pulls: Vec<Input> =
        [2, last].map(|tube| Input { tube, freedom: Freedom::PushPull, is_motion: true }).into();
    let value = |input: &Input| known.drives[input.tube - 1].translation.value();
    let free: Vec<FreeInput> = pulls
        .iter()
        .map(|&input| FreeInput { input, bounds: [value(&input) - 2e-3, value(&input) + 2e-3] })
        .collect();
    // From elsewhere.
    let mut start = known.clone();
    for input in &pulls {
        start = start.with_input(*input, value(input) + 1.3e-3);
    }
    let target = Target { position: Some(found.tip), direction: None };
    let reached = analysis.reach(&start, &free, &target, &Accuracy::default()).unwrap();
    assert!(reached.reached, "{:?}", reached.distance);
    assert!((reached.equilibrium.tip - found.tip).norm() < 2e-6 * length);
    let shape = analysis.solver.shape(&found, 0.1 * length);
    let points: Vec<ShapePoint> = shape
        .iter()
        .filter(|s| s.length > 0.0)
        .map(|s| ShapePoint { label: Some(s.length.min(length)), position: s.centre, deviation: 1e-4 })
        .collect();
    let matched = analysis.shape_match(&start, &free, &points).unwrap();
    for (input, got) in pulls.iter().zip(&matched.values) {
        assert!((got - value(input)).abs() < 1e-5, "{input:?}: {got} for {}", value(input));
    }
    let force = Vector3::new(0.01, -0.02, 0.03);
    let mut loaded = known.clone();
    loaded.loads.wrenches.push(Wrench::tip_force(force));
    let under = analysis.solver.solve_from(&loaded, &found);
    assert!(under.converged && under.stable && (under.tip - found.tip).norm() > 1e-4);
    let mut measured = vec![Measured::Position(under.tip, 1e-4)];
    measured.extend(
        (1..=last).map(|tube| Measured::Effort(tube, Freedom::PushPull, under.efforts[tube - 1].force, 0.01)),
    );
    let sensed = analysis.sense(&known, &measured, false).unwrap();
    assert!((sensed.force - force).norm() < 1e-5 * force.norm(), "{} for {force}", sensed.force);
    assert!(sensed.misses.iter().all(|miss| *miss < 1e-3));
}

/// Two uniform tubes bend by the pull over the sum of their centroid offsets, whatever their stiffness: so does the slope by an offset follow from that
/// by the pull.
#[test]
fn slopes_by_a_parameter_settle_on_those_in_closed_form() {
    let design = |offset: f64| {
        let tube = |offset: f64, direction: f64| TubeParts {
            parts: vec![Part {
                length: 0.1,
                body: cppr::design::StiffnessTube::uniform(offset, direction, [2e-2, 1e-2], 8e-3).into(),
                rest_curvature: 0.0,
                rest_direction: 0.0,
            }],
            shaft: None,
        };
        BundleDesign {
            name: "uniform".into(),
            tubes: vec![tube(2e-3, 0.0), tube(offset, std::f64::consts::PI)],
            joints: vec![vec![(0, 0.1), (1, 0.1)]],
        }
    };
    let (offset, pull) = (1e-3, 5e-3);
    let own = design(offset);
    let bundle = Bundle::new(&own).unwrap();
    let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle), &own);
    let mut command = analysis.solver.held();
    command.drives[1].translation = Drive::Motion(pull);
    let found = analysis.solver.solve(&command);
    let moved = MovedBundle::new(4e-3 * offset, |by| Bundle::new(&design(offset + by)).ok()).unwrap();
    let tip =
        |_: &BundleSolver, found: &cppr::bundle::solve::BundleEquilibrium| found.tip.as_slice().to_vec();
    let Settled { slopes, changes } = analysis.parameter_sensitivity(&found, &moved, tip).unwrap();
    let jacobian = analysis.solver.tip_jacobian(&found).unwrap();
    for row in 0..3 {
        let want = -pull / (2e-3 + offset) * jacobian[(row, 2)];
        assert!((slopes[row] - want).abs() < 1e-5, "{row}: {} {want}", slopes[row]);
        assert!(changes[row] < 1e-3, "{changes:?}");
    }
    assert!(slopes[0].abs() > 1.0 && slopes[1].abs() > 1.0);
    // A bundle that cannot be is no neighbour.
    assert!(MovedBundle::new(2.0 * offset, |by| Bundle::new(&design(offset + by)).ok()).is_none());
}
