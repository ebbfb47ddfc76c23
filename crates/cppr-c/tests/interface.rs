//! Numbers over the C interface are those of the library, and what is wrong is said.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::float_cmp,
    clippy::too_many_lines,
    clippy::cast_ptr_alignment
)]

use cppr::analysis::Sensitivity;
use cppr::bundle::Bundle;
use cppr::bundle::solve::{BundleSolver, load_behind_plate};
use cppr::kinematics::TipPose;
use cppr::solve::{Actuator, Command, Drive, Solver};
use cppr::statics::{Loads, Wrench};
use cppr_c::many::{cppr_solve_many, cppr_solver_fewest_modes};
use cppr_c::robot::*;
use cppr_c::solver::*;
use cppr_c::status::{CPPR_ABI, cppr_abi, cppr_code, cppr_error_text, cppr_version};
use cppr_c::{cppr_field, cppr_input, cppr_option, cppr_start, cppr_value};
use std::ffi::{CStr, c_char};
use std::ptr::null;

const OK: i32 = cppr_code::Ok as i32;

fn text(pointer: *const c_char) -> String {
    assert!(!pointer.is_null());
    // SAFETY: texts of the library end with 0.
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned()
}

/// A call was refused with a code, for a reason.
fn refused(code: i32, wanted: cppr_code, part: &str) {
    assert_eq!(code, wanted as i32, "{part}");
    assert!(text(cppr_error_text()).contains(part), "{}: not {part}", text(cppr_error_text()));
}

/// A robot and a solver, freed at the end.
struct Held {
    robot: *mut cppr_robot,
    solver: *mut cppr_solver,
}

impl Held {
    fn open(path: &CStr) -> Self {
        // SAFETY: the path ends with 0, the robot lives.
        unsafe {
            let robot = cppr_robot_from_file(path.as_ptr());
            assert!(!robot.is_null(), "{}", text(cppr_error_text()));
            Self { robot, solver: cppr_solver_new(robot) }
        }
    }

    fn set(&self, input: cppr_input, tube: u32, value: f64) {
        // SAFETY: the solver lives.
        assert_eq!(unsafe { cppr_solver_set(self.solver, input as u32, tube, value) }, OK);
    }

    fn solve(&self) -> i32 {
        // SAFETY: the solver lives.
        unsafe { cppr_solver_solve(self.solver) }
    }

    fn get(&self, value: cppr_value) -> Vec<f64> {
        // SAFETY: the solver lives, the array has the size asked for.
        unsafe {
            let mut out = vec![0.0; cppr_solver_size(self.solver, value as u32)];
            let code = cppr_solver_get(self.solver, value as u32, out.as_mut_ptr(), out.len());
            assert_eq!(code, OK, "{value:?}: {}", text(cppr_error_text()));
            out
        }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // SAFETY: both live and are freed once.
        unsafe {
            cppr_robot_free(self.robot);
            cppr_solver_free(self.solver);
        }
    }
}

/// Every value of a bent, turned and loaded robot of three tubes; a robot freed before its solver.
#[test]
fn values_are_those_of_the_library() {
    let own = cppr_io::read_robot("../../robots/childs3.toml").unwrap();
    let mut solver = Solver::new(&own);
    let mut command = Command::held(&own).with_loads(Loads::tip_force([0.0, 0.02, -0.1].into()));
    command.actuators[0] = Actuator { push_pull: Drive::Motion(1e-3), rotation: Drive::Motion(0.5) };
    command.actuators[1].push_pull = Drive::Effort(-0.4);
    let found = solver.solve(&command).unwrap();
    let derived = solver.sensitivity(&found).unwrap();
    let TipPose { rotation, centre } = solver.tip(&found);

    let held = Held::open(c"../../robots/childs3.toml");
    held.set(cppr_input::Tension, 2, 7.0); // The motion given next takes its place.
    held.set(cppr_input::Pull, 2, 1e-3);
    held.set(cppr_input::Rotate, 2, 0.5);
    held.set(cppr_input::Tension, 3, -0.4);
    held.set(cppr_input::TipForceY, 0, 0.02);
    held.set(cppr_input::TipForceZ, 0, -0.1);
    assert_eq!(held.solve(), OK);
    let close = |value: cppr_value, wanted: &[f64]| {
        let got = held.get(value);
        assert_eq!(got.len(), wanted.len(), "{value:?}");
        for (got, wanted) in got.iter().zip(wanted) {
            let near = (got - wanted).abs() <= 1e-9 * wanted.abs().max(1e-3);
            assert!(near || (got.is_nan() && wanted.is_nan()), "{value:?}: {got} instead of {wanted}");
        }
    };
    let nan = f64::NAN;
    let states = found.actuators();
    close(cppr_value::Status, &[0.0]);
    close(cppr_value::Fraction, &[1.0]);
    close(cppr_value::ElasticEnergy, &[found.elastic_energy()]);
    close(cppr_value::TipPosition, centre.as_slice());
    close(cppr_value::TipRotation, rotation.transpose().as_slice());
    close(cppr_value::Pull, &[nan, 1e-3, states[1].motion]);
    close(cppr_value::Rotation, &[nan, 0.5, 0.0]);
    close(cppr_value::Tension, &[nan, states[0].tension, -0.4]);
    close(cppr_value::Torque, &[nan, states[0].torque, states[1].torque]);
    close(cppr_value::Margin, &[solver.margin(&found).unwrap()]);
    close(cppr_value::TotalBend, &[cppr::analysis::total_bend(&found)]);
    let error = solver.accuracy(&found).unwrap();
    close(cppr_value::Error, &[error.tip, error.force, error.torque]);
    // Columns of the leader, which has no actuator, are empty.
    let wide = |r: usize, c: usize, of: &dyn Fn(usize, usize) -> f64| if c < 2 { nan } else { of(r, c - 2) };
    let rows = |rows: usize, columns: usize, of: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        (0..rows * columns).map(|i| of(i / columns, i % columns)).collect()
    };
    close(cppr_value::Jacobian, &rows(6, 6, &|r, c| wide(r, c, &|r, c| derived.tip_jacobian[(r, c)])));
    close(
        cppr_value::JacobianBody,
        &rows(6, 6, &|r, c| wide(r, c, &|r, c| derived.tip_jacobian_body[(r, c)])),
    );
    close(cppr_value::Compliance, &rows(6, 6, &|r, c| derived.compliance[(r, c)]));
    let response =
        |r: usize, c: usize| if r < 2 { nan } else { wide(r - 2, c, &|r, c| derived.response[(r, c)]) };
    close(cppr_value::Response, &rows(6, 6, &response));
    let by_wrench = |r: usize, c: usize| if r < 2 { nan } else { derived.response_by_wrench[(r - 2, c)] };
    close(cppr_value::ResponseByWrench, &rows(6, 6, &by_wrench));
    assert!(held.get(cppr_value::Iterations)[0] >= 3.0 && held.get(cppr_value::Residual)[0] <= 1e-11);
}

/// Every value of a robot of parts and joints, driven by motion and force and loaded.
#[test]
fn values_of_parts_are_those_of_the_library() {
    let design = cppr_io::read_bundle("../../robots/bundles/two_sections.toml").unwrap();
    let bundle = Bundle::new(&design).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let mut command = solver.held();
    command.drives[1].translation = Drive::Motion(3e-3);
    command.drives[3].translation = Drive::Effort(1.5);
    command.drives[3].rotation = Drive::Motion(0.3);
    command.loads = Loads::tip_force([0.0, 0.02, 0.01].into());
    let found = solver.solve(&command);
    assert!(found.converged && found.stable && load_behind_plate(&command, &found).is_none());
    let derived: Sensitivity = solver.sensitivity(&found).unwrap();

    let held = Held::open(c"../../robots/bundles/two_sections.toml");
    // SAFETY: the robot lives.
    unsafe {
        assert!(cppr_robot_has_parts(held.robot) && cppr_robot_is_planar(held.robot));
        assert_eq!(cppr_robot_length(held.robot), bundle.length());
        let actuated = [0, 1, 4, 5].map(|tube| cppr_robot_is_actuated(held.robot, tube));
        assert_eq!(actuated, [false, true, true, false]);
    }
    held.set(cppr_input::Pull, 2, 3e-3);
    held.set(cppr_input::Tension, 4, 1.5);
    held.set(cppr_input::Rotate, 4, 0.3);
    held.set(cppr_input::TipForceY, 0, 0.02);
    held.set(cppr_input::TipForceZ, 0, 0.01);
    assert_eq!(held.solve(), OK);
    let same = |value: cppr_value, wanted: &[f64]| {
        let bits = |list: &[f64]| list.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&held.get(value)), bits(wanted), "{value:?}");
    };
    let efforts = |get: fn(&cppr::bundle::solve::TubeEffort) -> f64| -> Vec<f64> {
        found.efforts.iter().map(get).collect()
    };
    same(cppr_value::Status, &[0.0]);
    same(cppr_value::Fraction, &[1.0]);
    same(cppr_value::Length, &[found.length]);
    same(cppr_value::TipPosition, found.tip.as_slice());
    same(cppr_value::TipRotation, found.frame.transpose().as_slice());
    same(cppr_value::Pull, &efforts(|e| e.label));
    same(cppr_value::Rotation, &efforts(|e| e.rotation));
    same(cppr_value::Tension, &efforts(|e| e.force));
    same(cppr_value::Torque, &efforts(|e| e.torque));
    // Column by column is the transpose row by row.
    same(cppr_value::Jacobian, derived.tip_jacobian.transpose().as_slice());
    same(cppr_value::JacobianBody, derived.tip_jacobian_body.transpose().as_slice());
    same(cppr_value::Response, derived.response.transpose().as_slice());
    same(cppr_value::Compliance, derived.compliance.transpose().as_slice());
    same(cppr_value::ResponseByWrench, derived.response_by_wrench.transpose().as_slice());
    let error = held.get(cppr_value::Error);
    assert!(error[0] < 1e-4 * bundle.length() && error[2].is_nan());
    // What does not exist there is said, and what does is NaN.
    let mut out = [0.0];
    for value in
        [cppr_value::Margin, cppr_value::Residual, cppr_value::ElasticEnergy, cppr_value::Evaluations]
    {
        // SAFETY: the solver lives, the array has the size given.
        let code = unsafe { cppr_solver_get(held.solver, value as u32, out.as_mut_ptr(), 1) };
        assert_eq!((code, out[0].is_nan()), (cppr_code::NoValue as i32, true), "{value:?}");
        assert!(text(cppr_error_text()).contains("robots of parts and joints do not have it"));
    }

    // Fields at sections that the library gives.
    let shape = solver.shape(&found, found.length / 7.0);
    let labels: Vec<f64> = shape.iter().map(|s| s.length).collect();
    let field = |field: cppr_field, size: usize| {
        let mut out = vec![0.0; size * labels.len()];
        // SAFETY: the solver lives, arrays have the sizes given.
        let code = unsafe {
            let (count, room) = (labels.len(), out.len());
            cppr_solver_get_field(held.solver, field as u32, labels.as_ptr(), count, out.as_mut_ptr(), room)
        };
        assert_eq!(code, OK, "{field:?}: {}", text(cppr_error_text()));
        out
    };
    let near = |a: f64, b: f64, tolerance: f64| a.is_nan() && b.is_nan() || (a - b).abs() < tolerance;
    for (section, centre) in shape.iter().zip(field(cppr_field::Centre, 3).chunks(3)) {
        assert!((0..3).all(|i| near(centre[i], section.centre[i], 1e-11)), "{centre:?} {}", section.centre);
    }
    let rotations = field(cppr_field::Rotation, 9);
    let last = &rotations[rotations.len() - 9..];
    for (got, wanted) in last.iter().zip(found.frame.transpose().iter()) {
        // The shape is integrated in shorter steps than the solve, which is as exact as its steps.
        assert!(near(*got, *wanted, 1e-8), "{last:?}, not {}", found.frame);
    }
    let (abscissae, centroids) = (field(cppr_field::Abscissa, 4), field(cppr_field::Centroid, 12));
    let mut seen = 0;
    for (i, section) in shape.iter().enumerate() {
        // On the two sides of a place where something changes fields differ: that of the plate is given.
        if i > 0 && section.length <= shape[i - 1].length {
            continue;
        }
        for tube in &section.tubes {
            let own = 4 * i + tube.tube;
            // Where a tube ends it is gone on the other side.
            assert!(near(abscissae[own], tube.label, 1e-8), "{} {}", abscissae[own], tube.label);
            let wanted = section.centre + section.offset(tube);
            assert!((0..3).all(|c| near(centroids[3 * own + c], wanted[c], 1e-8)), "section {i}");
            seen += 1;
        }
    }
    assert!(seen > 15);
}

/// A warm start follows, a copy stands where its original does, and what cannot be asked is refused in a sentence.
#[test]
fn a_robot_of_parts_is_followed_and_refuses() {
    let held = Held::open(c"../../robots/bundles/two_sections.toml");
    for step in 1..=5 {
        held.set(cppr_input::Pull, 2, 5e-4 * f64::from(step));
        // SAFETY: the solver lives.
        assert_eq!(unsafe { cppr_solver_track(held.solver) }, OK);
    }
    let tip = held.get(cppr_value::TipPosition);
    assert_eq!(held.solve(), OK);
    let cold = held.get(cppr_value::TipPosition);
    assert!(tip.iter().zip(&cold).all(|(a, b)| (a - b).abs() < 1e-8), "{tip:?} {cold:?}");
    // SAFETY: pointers live or are null where that is tested, arrays have the sizes given.
    unsafe {
        let copy = cppr_solver_clone(held.solver);
        let mut out = [0.0; 3];
        assert_eq!(cppr_solver_get(copy, cppr_value::TipPosition as u32, out.as_mut_ptr(), 3), OK);
        assert_eq!(out.to_vec(), cold);
        // The copy has what it needs when all else is gone.
        drop(held);
        assert_eq!(cppr_solver_track(copy), OK);
        refused(cppr_solver_set(copy, 1, 5, 0.0), cppr_code::BadCommand, "this robot has tubes 1 to 4");
        let option = |option: cppr_option, value: f64| cppr_solver_set_option(copy, option as u32, value);
        refused(option(cppr_option::Planar, 1.0), cppr_code::BadArgument, "only the stretch can be chosen");
        refused(
            option(cppr_option::RelativeAngle, 1.0),
            cppr_code::BadArgument,
            "only the stretch can be chosen",
        );
        assert_eq!((option(cppr_option::Planar, 0.0), option(cppr_option::Refine, 1.0)), (OK, OK));
        for (tube, value, part) in
            [(2, f64::NAN, "the actuator of tube 2"), (2, 5.0, "behind the plate: pull less. Check the unit")]
        {
            assert_eq!(cppr_solver_set(copy, 1, tube, value), OK);
            refused(cppr_solver_solve(copy), cppr_code::BadCommand, part);
            let code = cppr_solver_get(copy, cppr_value::TipPosition as u32, out.as_mut_ptr(), 3);
            refused(code, cppr_code::NoValue, "the last command was refused");
        }
        assert_eq!(cppr_solver_hold(copy), OK);
        let (force, at) = ([0.0, 0.01, 0.0], 9.0);
        assert_eq!(cppr_solver_add_wrench(copy, force.as_ptr(), null(), 0, &raw const at, null()), OK);
        refused(cppr_solver_solve(copy), cppr_code::BadCommand, "a load acts at 9000.000 mm");
        // Drawn in, a place of tube 1 lies behind the plate.
        assert_eq!(cppr_solver_unload(copy), OK);
        let at = 1e-3;
        assert_eq!(cppr_solver_add_wrench(copy, force.as_ptr(), null(), 0, &raw const at, null()), OK);
        for tube in 1..=4 {
            assert_eq!(cppr_solver_set(copy, cppr_input::Pull as u32, tube, 2e-3), OK);
        }
        refused(cppr_solver_solve(copy), cppr_code::BadCommand, "drawn in behind the plate");
        assert_eq!(cppr_solver_hold(copy), OK);
        assert_eq!(cppr_solver_set(copy, cppr_input::Tension as u32, 2, 1e5), OK);
        assert!(text(cppr_solver_doubt(copy)).contains("tension of tube 2"));
        cppr_solver_free(copy);
        let broken = c"[[tube]]\n[[tube.part]]\nlength_mm = -1";
        assert!(cppr_robot_from_text(broken.as_ptr()).is_null());
        assert!(text(cppr_error_text()).contains("line 3"), "{}", text(cppr_error_text()));
    }
}

#[test]
fn fields_along_the_robot_and_loads_of_all_kinds() {
    let held = Held::open(c"../../robots/r1.toml");
    held.set(cppr_input::Pull, 2, 2e-3);
    // SAFETY: the solver lives, arrays have the sizes given.
    unsafe {
        let (force, point, at) = ([0.0, 0.05, 0.0], [0.0, 2e-3, 0.0], 0.06);
        assert_eq!(
            cppr_solver_add_wrench(held.solver, force.as_ptr(), null(), 1, &raw const at, point.as_ptr()),
            OK
        );
        assert_eq!(cppr_solver_add_distributed(held.solver, [0.0, 0.0, 0.2].as_ptr(), 0.0, 0.1), OK);
        assert_eq!(cppr_solver_add_gravity(held.solver, [0.0, -9.81, 0.0].as_ptr()), OK);
        let pulley = [0.2, 0.1, 0.0];
        assert_eq!(cppr_solver_add_thread(held.solver, 0.1, pulley.as_ptr(), 0.01, true, null()), OK);
    }
    assert_eq!(held.solve(), OK);
    let own = cppr_io::read_robot("../../robots/r1.toml").unwrap();
    let mut loads = Loads::none();
    loads.wrenches.push(Wrench {
        frame: cppr::statics::Frame::Section,
        station: cppr::statics::Station::Label(0.06),
        point: [0.0, 2e-3, 0.0].into(),
        ..Wrench::tip_force([0.0, 0.05, 0.0].into())
    });
    loads.distributed.push(cppr::statics::DistributedForce {
        force: [0.0, 0.0, 0.2].into(),
        from: 0.0,
        to: 0.1,
    });
    loads.gravity = Some([0.0, -9.81, 0.0].into());
    let pulley = [0.2, 0.1, 0.0].into();
    let thread =
        cppr::statics::Thread { tension: 0.1, pulley, radius: 0.01, left: true, point: [0.0; 3].into() };
    loads.threads.push(thread);
    let mut solver = Solver::new(&own);
    let command = Command::pull(&[2e-3]).with_loads(loads);
    let found = solver.solve(&command).unwrap();
    let labels = [0.0, 0.075, 0.15];
    let shape = solver.shape_at(&found, &labels);
    for (field, size, of) in [
        (
            cppr_field::Centre,
            3,
            (|s| s.centre.as_slice().to_vec()) as fn(&cppr::analysis::Section) -> Vec<f64>,
        ),
        (cppr_field::Rotation, 9, |s| s.rotation.transpose().as_slice().to_vec()),
        (cppr_field::Curvature, 3, |s| s.curvature.as_slice().to_vec()),
        (cppr_field::Abscissa, 2, |s| s.tubes.iter().map(|t| t.abscissa).collect()),
        (cppr_field::Centroid, 6, |s| s.tubes.iter().flat_map(|t| t.centroid.iter().copied()).collect()),
        (cppr_field::Moment, 6, |s| s.tubes.iter().flat_map(|t| t.moment.iter().copied()).collect()),
        (cppr_field::Force, 6, |s| s.tubes.iter().flat_map(|t| t.force.iter().copied()).collect()),
        (cppr_field::EnergyDensity, 1, |s| vec![s.energy_density]),
    ] {
        let mut out = vec![0.0; 3 * size];
        // SAFETY: the solver lives, arrays have the sizes given.
        let code = unsafe {
            cppr_solver_get_field(held.solver, field as u32, labels.as_ptr(), 3, out.as_mut_ptr(), out.len())
        };
        assert_eq!(code, OK, "{field:?}: {}", text(cppr_error_text()));
        let wanted: Vec<f64> = shape.sections.iter().flat_map(of).collect();
        for (got, wanted) in out.iter().zip(&wanted) {
            assert!(
                (got - wanted).abs() <= 1e-8 * wanted.abs().max(1e-3),
                "{field:?}: {out:?}, not {wanted:?}"
            );
        }
    }
    // Unloaded it is in its plane again.
    // SAFETY: the solver lives.
    assert_eq!(unsafe { cppr_solver_unload(held.solver) }, OK);
    assert_eq!(held.solve(), OK);
    assert!(held.get(cppr_value::TipPosition)[2].abs() < 1e-9);
}

/// Poses in a row by many and one by one, on one thread and on two, from rest and from the neighbour.
#[test]
fn many_poses_are_those_of_single_solves() {
    let held = Held::open(c"../../robots/childs3.toml");
    held.set(cppr_input::Rotate, 2, 0.3);
    let names = [cppr_input::Tension, cppr_input::Pull, cppr_input::TipForceY];
    let inputs = names.map(|input| input as u32);
    let tubes = [2, 3, 0];
    let poses = 50;
    let mut values: Vec<f64> =
        (0..poses).map(f64::from).flat_map(|i| [0.2 * i - 5.0, 5e-4 - 2e-5 * i, 1e-3 * i]).collect();
    values[3 * 7] = -500.0; // No equilibrium bears that.
    let wanted = [cppr_value::Status as u32, cppr_value::TipPosition as u32, cppr_value::Jacobian as u32, 9];
    let many = |start: cppr_start, threads: usize| {
        let mut out = vec![0.0; 50 * 41];
        // SAFETY: the solver lives, arrays have the sizes given.
        let code = unsafe {
            cppr_solve_many(
                held.solver,
                start as u32,
                50,
                3,
                inputs.as_ptr(),
                tubes.as_ptr(),
                values.as_ptr(),
                4,
                wanted.as_ptr(),
                out.as_mut_ptr(),
                out.len(),
                threads,
            )
        };
        assert_eq!(code, OK, "{}", text(cppr_error_text()));
        out
    };
    let bits = |out: &[f64]| out.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let from_rest = many(cppr_start::Rest, 1);
    assert_eq!(bits(&from_rest), bits(&many(cppr_start::Rest, 2)));
    let from_neighbour = many(cppr_start::Neighbour, 0);
    for (pose, (row, other)) in from_rest.chunks_exact(41).zip(from_neighbour.chunks_exact(41)).enumerate() {
        for (column, (input, tube)) in names.into_iter().zip(tubes).enumerate() {
            held.set(input, tube, values[3 * pose + column]);
        }
        let code = held.solve();
        assert_eq!((f64::from(code), f64::from(code)), (row[0], other[0]), "pose {pose}");
        assert_eq!(pose == 7, code == cppr_code::NoEquilibrium as i32, "pose {pose}");
        if pose == 7 {
            assert!(row[1..].iter().all(|v| v.is_nan()));
            // SAFETY: the solver lives.
            let why = text(unsafe { cppr_solver_explain(held.solver) });
            assert!(why.contains("not converged"), "{why}");
            continue;
        }
        let single =
            [held.get(cppr_value::TipPosition), held.get(cppr_value::Jacobian), held.get(cppr_value::Margin)];
        for ((got, wanted), near) in row[1..].iter().zip(single.concat()).zip(&other[1..]) {
            let close = |got: f64| (got - wanted).abs() <= 1e-8 * wanted.abs().max(1e-2);
            assert!(
                (close(*got) && close(*near)) || wanted.is_nan() && got.is_nan(),
                "pose {pose}: {got}, {wanted}"
            );
        }
    }
}

#[test]
fn a_warm_start_follows_and_comes_back_from_where_nothing_is() {
    let held = Held::open(c"../../robots/childs3.toml");
    for step in 1..=10 {
        held.set(cppr_input::Pull, 2, 1e-4 * f64::from(step));
        // SAFETY: the solver lives.
        assert_eq!(unsafe { cppr_solver_track(held.solver) }, OK);
    }
    let tip = held.get(cppr_value::TipPosition);
    // SAFETY: the solver lives.
    let copy = unsafe { cppr_solver_clone(held.solver) };
    held.set(cppr_input::Torque, 2, 5.0);
    // SAFETY: the solver lives.
    assert_eq!(unsafe { cppr_solver_track(held.solver) }, cppr_code::NoEquilibrium as i32);
    let mut out = [0.0; 3];
    // SAFETY: the solver lives, the array has the size given.
    let code = unsafe { cppr_solver_get(held.solver, cppr_value::TipPosition as u32, out.as_mut_ptr(), 3) };
    assert_eq!(code, cppr_code::NoValue as i32);
    assert!(out.iter().all(|v| v.is_nan()));
    assert!(text(cppr_error_text()).contains("found no equilibrium"));
    held.set(cppr_input::Rotate, 2, 0.0);
    // SAFETY: the solver lives.
    assert_eq!(unsafe { cppr_solver_track(held.solver) }, OK);
    // It starts where it was found last, which is the answer.
    assert!(held.get(cppr_value::Iterations)[0] <= 1.0);
    let again = held.get(cppr_value::TipPosition);
    assert!(tip.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12), "{tip:?} {again:?}");
    // SAFETY: the copy lives, the array has the size given; freed once.
    unsafe {
        assert_eq!(cppr_solver_get(copy, cppr_value::TipPosition as u32, out.as_mut_ptr(), 3), OK);
        assert_eq!(cppr_solver_track(copy), OK);
        cppr_solver_free(copy);
    }
    assert!(tip.iter().zip(&out).all(|(a, b)| (a - b).abs() < 1e-12));
}

#[test]
fn options_change_how_it_is_solved() {
    let held = Held::open(c"../../robots/r4.toml");
    held.set(cppr_input::Pull, 2, 11e-3);
    let tension = |option: Option<cppr_option>| {
        if let Some(option) = option {
            // SAFETY: the solver lives.
            assert_eq!(unsafe { cppr_solver_set_option(held.solver, option as u32, 1.0) }, OK);
        }
        assert_eq!(held.solve(), OK, "{option:?}");
        held.get(cppr_value::Tension)[1]
    };
    let consistent = tension(None);
    let planar = tension(Some(cppr_option::Planar));
    assert!((consistent - 5.040).abs() < 5e-3 && (planar - 5.040).abs() < 5e-3, "{consistent} {planar}");
    assert!((tension(Some(cppr_option::Printed)) - 3.777).abs() < 5e-3);
    for (option, value) in [
        (cppr_option::Refine, 0.0),
        (cppr_option::Refine, 1.5),
        (cppr_option::Refine, f64::NAN),
        (cppr_option::Tolerance, 1.0),
        (cppr_option::Planar, 2.0),
        (cppr_option::Iterations, -1.0),
    ] {
        // SAFETY: the solver lives.
        let code = unsafe { cppr_solver_set_option(held.solver, option as u32, value) };
        assert_eq!(code, cppr_code::BadArgument as i32, "{option:?} {value}");
        assert!(text(cppr_error_text()).contains("cannot be"));
    }
}

/// As few modes as poses bear with are an option of what follows; robots of parts have none.
#[test]
fn loops_take_as_few_modes_as_they_need() {
    let held = Held::open(c"../../robots/r3.toml");
    let (inputs, tubes, pulls) = ([cppr_input::Pull as u32], [2], [0.0, 4e-3]);
    let fewest = |solver, accuracy: f64, values: &[f64; 2]| {
        let mut refine = f64::NAN;
        // SAFETY: the solver lives, the arrays have the sizes given.
        let code = unsafe {
            cppr_solver_fewest_modes(
                solver,
                accuracy,
                2,
                1,
                inputs.as_ptr(),
                tubes.as_ptr(),
                values.as_ptr(),
                &raw mut refine,
            )
        };
        (code, refine)
    };
    let robot = cppr_io::read_robot("../../robots/r3.toml").unwrap();
    let commands = pulls.map(|pull| Command::pull(&[pull]));
    let mut solver = Solver::new(&robot);
    let usual = solver.settings().resolution;
    let mut met = Vec::new();
    for accuracy in [1e-2, 1e-5, 1e-9] {
        let found = solver.fewest_modes(&commands, accuracy).settings;
        let (code, refine) = fewest(held.solver, accuracy, &pulls);
        assert_eq!((code, found.resolution), (OK, usual.multiplied(refine).unwrap()), "{accuracy}");
        held.set(cppr_input::Pull, 2, pulls[1]);
        assert_eq!(held.solve(), OK);
        let mut own = Solver::with_settings(&robot, found).unwrap();
        let tip = own.solve(&commands[1]).unwrap().tip().centre;
        assert!(held.get(cppr_value::TipPosition).iter().zip(&tip).all(|(a, b)| (a - b).abs() < 1e-12));
        met.push(refine);
    }
    assert!(met[0] < 1.0 && met[2] > 1.0, "{met:?}");
    for (accuracy, pull, code, part) in
        [(0.0, 1e-3, cppr_code::BadArgument, "above 0"), (1e-4, f64::NAN, cppr_code::BadCommand, "pose 1")]
    {
        refused(fewest(held.solver, accuracy, &[0.0, pull]).0, code, part);
    }
    let parts = Held::open(c"../../robots/bundles/two_sections.toml");
    refused(fewest(parts.solver, 1e-4, &pulls).0, cppr_code::BadArgument, "has no modes");
}

/// A loop of a robot of parts integrates as coarsely as it is told.
#[test]
fn loops_of_parts_have_a_tolerance() {
    let tracked = |tolerance: f64| {
        let held = Held::open(c"../../robots/bundles/s_shape.toml");
        let option = cppr_option::LoopTolerance as u32;
        // SAFETY: the solver lives.
        assert_eq!(unsafe { cppr_solver_set_option(held.solver, option, tolerance) }, OK);
        held.set(cppr_input::Pull, 2, 2e-3);
        assert_eq!(held.solve(), OK);
        for step in 1..=10 {
            held.set(cppr_input::Pull, 2, 2e-3 + 5e-5 * f64::from(step));
            // SAFETY: the solver lives.
            assert_eq!(unsafe { cppr_solver_track(held.solver) }, OK);
        }
        held.get(cppr_value::TipPosition)
    };
    let own = |tolerance: f64| {
        let design = cppr_io::read_bundle("../../robots/bundles/s_shape.toml").unwrap();
        let bundle = Bundle::new(&design).unwrap();
        let mut solver = BundleSolver::new(&bundle).with_loop_tolerance(tolerance);
        let mut command = solver.held();
        command.drives[1].translation = Drive::Motion(2e-3);
        let mut found = solver.solve(&command);
        for step in 1..=10 {
            command.drives[1].translation = Drive::Motion(2e-3 + 5e-5 * f64::from(step));
            solver.solve_into(&command, &mut found);
        }
        found.tip
    };
    let [fine, coarse] = [1e-8, 1e-5].map(tracked);
    assert!(fine != coarse, "{fine:?}");
    assert!(
        fine.iter().zip(&own(1e-8)).chain(coarse.iter().zip(&own(1e-5))).all(|(a, b)| (a - b).abs() < 1e-13)
    );
    let modal = Held::open(c"../../robots/r3.toml");
    for (held, value, part) in [
        (&modal, 1e-6, "nothing is integrated"),
        (&modal, 0.0, "cannot be 0"),
        (&modal, 1e-3, "cannot be 0.001"),
    ] {
        // SAFETY: the solver lives.
        let code = unsafe { cppr_solver_set_option(held.solver, cppr_option::LoopTolerance as u32, value) };
        refused(code, cppr_code::BadArgument, part);
    }
}

/// A table with steps is integrated, and what says so is that of the program; the right tip is that of its tests.
#[test]
fn sudden_changes_are_integrated_and_modes_can_be_kept() {
    let steps = c"../cppr-cli/tests/data/steps_in_a_table.toml";
    let held = Held::open(steps);
    held.set(cppr_input::Pull, 2, 2e-3);
    assert_eq!(held.solve(), OK);
    let off = |tip: &[f64]| (tip[0] - 88.599e-3).hypot(tip[1] + 50.173e-3);
    assert!(off(&held.get(cppr_value::TipPosition)) < 1e-5);
    assert!((held.get(cppr_value::Tension)[1] - 1.8538).abs() < 1e-3);
    // SAFETY: robots live and are freed once, solvers too.
    unsafe {
        let places = text(cppr_robot_sudden_changes(held.robot));
        assert_eq!(places, "notch depth of tube 1 at 30 mm, notch depth of tube 2 at 30 mm");
        assert!(cppr_robot_has_parts(held.robot));
        let robot = cppr_robot_with_modes(held.robot);
        assert!(!cppr_robot_has_parts(robot) && cppr_robot_sudden_changes(robot).is_null());
        let modes = Held { robot, solver: cppr_solver_new(robot) };
        modes.set(cppr_input::Pull, 2, 2e-3);
        assert_eq!(modes.solve(), OK);
        let (tip, error) = (modes.get(cppr_value::TipPosition), modes.get(cppr_value::Error)[0]);
        assert!(off(&tip) > 1e-3 && (error - off(&tip)).abs() < 1e-4, "{error}");

        let again = cppr_robot_with_modes(robot);
        assert_eq!(text(cppr_robot_name(again)), "MyNiTi");
        cppr_robot_free(again);
        let parts = Held::open(c"../../robots/bundles/two_sections.toml");
        assert!(cppr_robot_sudden_changes(parts.robot).is_null());
        assert!(cppr_robot_with_modes(parts.robot).is_null());
        assert!(text(cppr_error_text()).contains("has no modes"));
        assert!(cppr_robot_sudden_changes(null()).is_null() && cppr_robot_with_modes(null()).is_null());
    }
}

/// One notch that is deeper than the others needs more modes than usual: they are taken where an accuracy is asked for, from rest, and kept by
/// warm starts.
#[test]
fn as_many_modes_are_taken_as_the_accuracy_needs() {
    let r1 = std::fs::read_to_string("../../robots/r1.toml").unwrap();
    let deeper = "depth_mm = [5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.3, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0, 5.0]";
    let file = std::ffi::CString::new(r1.replacen("depth_mm = 5.0", deeper, 1)).unwrap();
    // SAFETY: the text ends with 0, the robot lives.
    let held = unsafe {
        let robot = cppr_robot_from_text(file.as_ptr());
        assert!(!robot.is_null() && !cppr_robot_has_parts(robot));
        Held { robot, solver: cppr_solver_new(robot) }
    };
    let accept = |accuracy: f64| {
        // SAFETY: the solver lives.
        let code = unsafe { cppr_solver_set_option(held.solver, cppr_option::Accuracy as u32, accuracy) };
        assert_eq!(code, OK);
    };
    // SAFETY: the solver lives.
    let track = || assert_eq!(unsafe { cppr_solver_track(held.solver) }, OK);
    let error = || held.get(cppr_value::Error)[0];
    let tip = || held.get(cppr_value::TipPosition);
    held.set(cppr_input::Pull, 2, 5e-3);
    assert_eq!(held.solve(), OK);
    let (usual, usual_tip) = (error(), tip());
    assert!(usual > 1e-4 * 0.15, "{usual}");

    accept(1e-4);
    assert_eq!(held.solve(), OK);
    let (finer, finer_tip) = (error(), tip());
    assert!(finer < 0.5 * usual, "{finer} {usual}");
    track();
    assert!((error() - finer).abs() < 1e-9);
    let many = |start: cppr_start| {
        let (pulls, mut out) = ([4e-3, 5e-3], [0.0; 6]);
        // SAFETY: the solver lives, the arrays have the sizes given.
        let code = unsafe {
            let (inputs, values) = (&[cppr_input::Pull as u32], &[cppr_value::TipPosition as u32]);
            let (inputs, values) = (inputs.as_ptr(), values.as_ptr());
            let (start, tubes) = (start as u32, [2].as_ptr());
            let out = out.as_mut_ptr();
            cppr_solve_many(held.solver, start, 2, 1, inputs, tubes, pulls.as_ptr(), 1, values, out, 6, 1)
        };
        assert_eq!(code, OK);
        out[3..].to_vec()
    };
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near(&many(cppr_start::Rest), &finer_tip));

    accept(0.0);
    assert!(near(&many(cppr_start::Rest), &usual_tip));
    track();
    assert!((error() - usual).abs() < 1e-9, "{}", error());
    for wrong in [-1e-4, 2.0, f64::NAN] {
        // SAFETY: the solver lives.
        let code = unsafe { cppr_solver_set_option(held.solver, cppr_option::Accuracy as u32, wrong) };
        assert_eq!(code, cppr_code::BadArgument as i32, "{wrong}");
    }
    let parts = Held::open(c"../../robots/bundles/two_sections.toml");
    // SAFETY: the solver lives.
    assert_eq!(unsafe { cppr_solver_set_option(parts.solver, cppr_option::Accuracy as u32, 1e-4) }, OK);
}

/// Null pointers, wrong sizes, unknown numbers, wrong tubes, broken files: a code and a sentence each.
#[test]
fn what_is_wrong_is_said() {
    // SAFETY: null pointers are what is tested; all others live and have the sizes given.
    unsafe {
        assert_eq!((cppr_abi(), text(cppr_version()).as_str()), (CPPR_ABI, env!("CARGO_PKG_VERSION")));
        assert!(cppr_robot_from_file(null()).is_null());
        assert!(cppr_robot_from_file(c"no such file".as_ptr()).is_null());
        assert!(text(cppr_error_text()).starts_with("no such file: the file cannot be read"));
        assert!(cppr_robot_from_text(c"length_mm = -1".as_ptr()).is_null());
        assert!(text(cppr_error_text()).contains("line 1"), "{}", text(cppr_error_text()));
        assert!(cppr_robot_from_text([0xff_u8, 0].as_ptr().cast()).is_null());
        assert!(text(cppr_error_text()).contains("UTF-8"));
        assert!(cppr_solver_new(null()).is_null() && cppr_solver_clone(null()).is_null());
        assert!(cppr_robot_name(null()).is_null() && cppr_robot_length(null()).is_nan());
        assert_eq!((cppr_robot_tubes(null()), cppr_robot_is_actuated(null(), 2)), (0, false));
        cppr_robot_free(std::ptr::null_mut());
        cppr_solver_free(std::ptr::null_mut());
        refused(cppr_solver_solve(std::ptr::null_mut()), cppr_code::BadArgument, "solver is a null pointer");

        let held = Held::open(c"../../robots/r1.toml");
        assert_eq!(text(cppr_robot_name(held.robot)), "R1");
        assert_eq!((cppr_robot_tubes(held.robot), cppr_robot_length(held.robot)), (2, 0.15));
        assert!(cppr_robot_is_planar(held.robot));
        assert_eq!(
            [0, 1, 2, 3].map(|tube| cppr_robot_is_actuated(held.robot, tube)),
            [false, false, true, false]
        );
        let solver = held.solver;
        let mut out = [0.0; 24];
        let place = out.as_mut_ptr();
        let code = cppr_solver_get(solver, cppr_value::TipPosition as u32, place, 3);
        refused(code, cppr_code::NoValue, "nothing has been solved yet");
        refused(
            cppr_solver_get(solver, 10, place, 2),
            cppr_code::BadArgument,
            "takes 3 numbers here; there is room for 2",
        );
        refused(
            cppr_solver_get(solver, 10, std::ptr::null_mut(), 3),
            cppr_code::BadArgument,
            "out is a null pointer",
        );
        let odd = place.cast::<u8>().add(1).cast::<f64>();
        refused(cppr_solver_get(solver, 10, odd, 3), cppr_code::BadArgument, "out points to no whole number");
        refused(cppr_solver_get(solver, 999, place, 3), cppr_code::BadArgument, "there is no value 999");
        refused(cppr_solver_set(solver, 1, 1, 0.0), cppr_code::BadCommand, "tube 1 is the leader");
        refused(
            cppr_solver_set(solver, 1, 3, 0.0),
            cppr_code::BadCommand,
            "there is no tube 3; this robot has tubes 1 to 2",
        );
        refused(cppr_solver_set(solver, 1, 0, 0.0), cppr_code::BadCommand, "there is no tube 0");
        refused(cppr_solver_set(solver, 5, 2, 0.0), cppr_code::BadCommand, "belongs to no tube");
        refused(cppr_solver_set(solver, 0, 2, 0.0), cppr_code::BadArgument, "there is no input 0");
        refused(cppr_solver_set_option(solver, 99, 0.0), cppr_code::BadArgument, "there is no option 99");
        refused(
            cppr_solver_add_wrench(solver, null(), null(), 7, null(), null()),
            cppr_code::BadArgument,
            "no frame 7",
        );
        refused(
            cppr_solver_add_gravity(solver, null()),
            cppr_code::BadArgument,
            "acceleration is a null pointer",
        );
        held.set(cppr_input::Pull, 2, 5.0);
        refused(held.solve(), cppr_code::BadCommand, "Check the unit");
        refused(held.solve(), cppr_code::BadCommand, "tube 2 cannot slide by 5000.000 mm");
        held.set(cppr_input::Pull, 2, 1e-3);
        held.set(cppr_input::Rotate, 2, 90.0);
        assert!(text(cppr_solver_doubt(solver)).contains("Check number and unit"));
        held.set(cppr_input::Rotate, 2, 1.5);
        assert!(cppr_solver_doubt(solver).is_null());
        assert_eq!(cppr_solver_hold(solver), OK);
        assert_eq!(held.solve(), OK);
        assert_eq!(text(cppr_solver_explain(solver)), "converged, stable");
        assert_eq!(held.get(cppr_value::TipPosition), [0.15, 0.0, 0.0]);
        refused(
            cppr_solver_get_field(solver, 1, [0.2].as_ptr(), 1, place, 3),
            cppr_code::BadArgument,
            "the robot reaches from 0 to 0.15 m",
        );
        let many = |columns: usize, inputs: &[u32], tubes: &[u32], values: &[f64], count: usize| {
            let (i, t, v) = (inputs.as_ptr(), tubes.as_ptr(), values.as_ptr());
            cppr_solve_many(
                solver,
                0,
                2,
                columns,
                i,
                t,
                v,
                1,
                [10].as_ptr(),
                out.as_ptr().cast_mut(),
                count,
                1,
            )
        };
        refused(
            many(1, &[1], &[2], &[0.0, f64::NAN], 6),
            cppr_code::BadCommand,
            "pose 1: the actuator of tube 2",
        );
        refused(many(1, &[1], &[2], &[0.0, 0.0], 5), cppr_code::BadArgument, "3 numbers for each of 2 poses");
        refused(many(1, &[1], &[1], &[0.0, 0.0], 6), cppr_code::BadCommand, "column 0: tube 1 is the leader");
        refused(
            many(2, &[1, 1], &[2, 2], &[0.0; 4], 6),
            cppr_code::BadCommand,
            "column 1 varies the same input",
        );
        refused(many(usize::MAX, &[1], &[2], &[], 6), cppr_code::BadArgument, "so many poses cannot be");
    }
}

/// A second thread is turned away, and every thread has its own sentence.
#[test]
fn a_solver_serves_one_thread_at_a_time() {
    use std::sync::atomic::{AtomicBool, Ordering};
    struct Sent(*mut cppr_solver);
    // SAFETY: the interface keeps a solver to one thread at a time by itself: that is what is tested.
    unsafe impl Sync for Sent {}
    let held = Held::open(c"../../robots/childs3.toml");
    held.set(cppr_input::Pull, 2, 1e-3);
    let (sent, done) = (Sent(held.solver), AtomicBool::new(false));
    let (sent, done) = (&sent, &done);
    std::thread::scope(|scope| {
        let busy = scope.spawn(move || {
            let mut busy = 0;
            while !done.load(Ordering::Relaxed) {
                // SAFETY: the solver lives.
                let code = unsafe { cppr_solver_set(sent.0, cppr_input::Pull as u32, 2, 1e-3) };
                assert!([OK, cppr_code::Busy as i32].contains(&code));
                if code == cppr_code::Busy as i32 {
                    assert!(text(cppr_error_text()).contains("one solver per thread"));
                    busy += 1;
                }
            }
            busy
        });
        let mut solved = 0;
        let begin = std::time::Instant::now();
        while begin.elapsed().as_millis() < 300 {
            // SAFETY: the solver lives.
            solved += u32::from(unsafe { cppr_solver_solve(sent.0) } == OK);
        }
        done.store(true, Ordering::Relaxed);
        assert!(busy.join().unwrap() > 0 && solved > 0);
    });
}
