//! In a control loop over the C interface nothing is allocated, and neither by a command that is refused.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use cppr_c::robot::{cppr_robot_free, cppr_robot_from_file};
use cppr_c::solver::{
    cppr_solver_free, cppr_solver_get, cppr_solver_new, cppr_solver_set, cppr_solver_set_option,
    cppr_solver_track,
};
use cppr_c::status::cppr_code;
use cppr_c::{cppr_input, cppr_option, cppr_value};

const OK: i32 = cppr_code::Ok as i32;

#[test]
fn a_loop_allocates_nothing_after_its_first_turn() {
    for planar in [true, false] {
        // SAFETY: all pointers are those of living objects and of arrays of the sizes given.
        unsafe {
            let robot = cppr_robot_from_file(c"../../robots/r3.toml".as_ptr());
            assert!(!robot.is_null());
            let solver = cppr_solver_new(robot);
            cppr_robot_free(robot);
            let flag = f64::from(u8::from(planar));
            assert_eq!(cppr_solver_set_option(solver, cppr_option::Planar as u32, flag), OK);
            let mut turn = |cycle: u32| {
                let pull = 1e-3 + 1e-5 * f64::from(cycle);
                assert_eq!(cppr_solver_set(solver, cppr_input::Pull as u32, 2, pull), OK);
                if !planar {
                    assert_eq!(cppr_solver_set(solver, cppr_input::Rotate as u32, 2, 10.0 * pull), OK);
                    assert_eq!(cppr_solver_set(solver, cppr_input::TipForceZ as u32, 0, 5.0 * pull), OK);
                }
                assert_eq!(cppr_solver_track(solver), OK);
                let mut cells = [0.0; 36];
                for (value, count) in [
                    (cppr_value::TipPosition, 3),
                    (cppr_value::TipRotation, 9),
                    (cppr_value::Tension, 2),
                    (cppr_value::Jacobian, 24),
                    (cppr_value::Compliance, 36),
                    (cppr_value::ElasticEnergy, 1),
                ] {
                    assert_eq!(cppr_solver_get(solver, value as u32, cells.as_mut_ptr(), count), OK);
                    let known = cells[..count].iter().filter(|v| v.is_finite()).count();
                    assert!(known >= count / 2, "{value:?}");
                }
                assert_eq!(cppr_solver_set(solver, cppr_input::Pull as u32, 2, f64::NAN), OK);
                assert_eq!(cppr_solver_track(solver), cppr_code::BadCommand as i32);
                assert_eq!(
                    cppr_solver_set(solver, cppr_input::Pull as u32, 1, 1e-3),
                    cppr_code::BadCommand as i32
                );
                let read = cppr_solver_get(solver, 10, cells.as_mut_ptr(), 3);
                assert_eq!(read, cppr_code::NoValue as i32);
            };
            turn(0);
            let counted = measure(|| (1..100).for_each(&mut turn));
            assert_eq!(counted.count_total, 0, "planar: {planar}");
            cppr_solver_free(solver);
        }
    }
}
