//! One robot's command, buffers and last equilibrium.

use crate::names::{Numbered, cppr_field, cppr_frame, cppr_input, cppr_option, cppr_value};
use crate::pointer;
use crate::robot::cppr_robot;
use crate::session::Session;
use crate::status::{cppr_code, cppr_error_text, guard, guard_or, say};
use crate::values::{field_size, size};
use cppr::Vector3;
use cppr::statics::{DistributedForce, Frame, Loads, Station, Thread, Wrench};
use std::ffi::c_char;
use std::sync::{Mutex, MutexGuard, TryLockError};

/// A command, buffers and the last equilibrium of one robot. One thread at a time may use it, not always the same; a second one meanwhile
/// gets CPPR_CODE_BUSY. Take one solver per thread.
#[allow(non_camel_case_types)]
pub struct cppr_solver(Mutex<Session>);

type Done = Result<cppr_code, cppr_code>;

/// The session of a solver, for this thread alone. A panic may have left it half changed: it begins anew then.
///
/// # Safety
/// `solver` is null or a living solver.
pub(crate) unsafe fn session<'a>(solver: *const cppr_solver) -> Result<MutexGuard<'a, Session>, cppr_code> {
    // SAFETY: the caller's promise; what changes lies behind the lock.
    let own = unsafe { pointer::object(solver, "solver") }?;
    match own.0.try_lock() {
        Ok(session) => Ok(session),
        Err(TryLockError::WouldBlock) => {
            let text = "another thread is using this solver: take one solver per thread";
            Err(say(cppr_code::Busy, format_args!("{text}")))
        }
        Err(TryLockError::Poisoned(broken)) => {
            let mut session = broken.into_inner();
            *session = Session::new(&session.model);
            own.0.clear_poison();
            Ok(session)
        }
    }
}

/// A solver of a robot: all actuators held, no load, at rest. Null for a null pointer. It keeps what it needs of the robot, which may be
/// freed first. Free it with cppr_solver_free().
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_new(robot: *const cppr_robot) -> *mut cppr_solver {
    guard_or(std::ptr::null_mut(), || {
        // SAFETY: the caller's promise.
        let robot = unsafe { pointer::object(robot, "robot") }?;
        Ok(Box::into_raw(Box::new(cppr_solver(Mutex::new(Session::new(&robot.model))))))
    })
}

/// Another solver with the same command, options and equilibrium, and buffers of its own: for another thread, or to come back to this
/// equilibrium. Null where it fails.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_clone(solver: *const cppr_solver) -> *mut cppr_solver {
    guard_or(std::ptr::null_mut(), || {
        // SAFETY: the caller's promise.
        let copied = unsafe { session(solver) }?.copied();
        Ok(Box::into_raw(Box::new(cppr_solver(Mutex::new(copied)))))
    })
}

/// Frees a solver; nothing for a null pointer.
///
/// # Safety
/// `solver` is null or comes from this library, has not been freed, and no thread is using it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_free(solver: *mut cppr_solver) {
    guard_or((), || {
        if !solver.is_null() {
            // SAFETY: it was boxed above and is given back once.
            drop(unsafe { Box::from_raw(solver) });
        }
        Ok(())
    });
}

/// Sets an option (cppr_option). The next warm start may take longer.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_set_option(solver: *mut cppr_solver, option: u32, value: f64) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        let mut session = unsafe { session(solver) }?;
        let chosen = session.choose(cppr_option::of(option)?, value);
        let refuse =
            |why| say(cppr_code::BadArgument, format_args!("option {option} cannot be {value}: {why}"));
        chosen.map(|()| cppr_code::Ok).map_err(refuse)
    })
}

/// Prescribes an input (cppr_input): of a tube, numbered from 1 as in the robot file, or 0 for an input on the tip. What is not prescribed
/// is held, and not loaded. The number itself is checked by the solve.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_set(solver: *mut cppr_solver, input: u32, tube: u32, value: f64) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        let mut session = unsafe { session(solver) }?;
        let put = session.put(cppr_input::of(input)?, tube, value);
        put.map_err(|problem| say(cppr_code::BadCommand, format_args!("{problem}")))?;
        Ok(cppr_code::Ok)
    })
}

/// Holds all actuators where they are at rest and takes all loads away. Options and the last equilibrium stay.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_hold(solver: *mut cppr_solver) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        unsafe { session(solver) }?.hold();
        Ok(cppr_code::Ok)
    })
}

/// Takes all loads away, those on the tip too.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_unload(solver: *mut cppr_solver) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        unsafe { session(solver) }?.asked.unload();
        Ok(cppr_code::Ok)
    })
}

/// Adds a load.
unsafe fn add(solver: *mut cppr_solver, load: impl FnOnce(&mut Loads) -> Done) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        let mut session = unsafe { session(solver) }?;
        load(session.asked.loads())
    })
}

/// Adds a concentrated force (N) and moment (N m; null: none), both of three components in a frame (cppr_frame).
/// `at` is the label of the loaded section, the rest abscissa of the leader, which is tube 1 (m), or null for the tip; `point` the point of action in the
/// section's frame (m), or null for its centre. The number itself is checked by the solve, as with every load.
///
/// # Safety
/// `solver` is null or a living solver; `force`, `moment` and `point` point to three numbers, `at` to one, unless null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_add_wrench(
    solver: *mut cppr_solver,
    force: *const f64,
    moment: *const f64,
    frame: u32,
    at: *const f64,
    point: *const f64,
) -> i32 {
    // SAFETY: the caller's promises.
    unsafe {
        add(solver, |loads| {
            let station =
                if at.is_null() { Station::Tip } else { Station::Label(*pointer::object(at, "at")?) };
            loads.wrenches.push(Wrench {
                force: pointer::vector_or_zero(force, "force")?,
                moment: pointer::vector_or_zero(moment, "moment")?,
                frame: match cppr_frame::of(frame)? {
                    cppr_frame::Base => Frame::World,
                    cppr_frame::Section => Frame::Section,
                },
                station,
                point: pointer::vector_or_zero(point, "point")?,
            });
            Ok(cppr_code::Ok)
        })
    }
}

/// Adds a dead force per length (N/m, three components in the base frame) between two labels (m).
///
/// # Safety
/// `solver` is null or a living solver; `force` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_add_distributed(
    solver: *mut cppr_solver,
    force: *const f64,
    from: f64,
    to: f64,
) -> i32 {
    // SAFETY: the caller's promises.
    unsafe {
        add(solver, |loads| {
            loads.distributed.push(DistributedForce { force: pointer::vector(force, "force")?, from, to });
            Ok(cppr_code::Ok)
        })
    }
}

/// Adds gravity (m/s², three components in the base frame), which acts on every tube that has mass.
///
/// # Safety
/// `solver` is null or a living solver; `acceleration` points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_add_gravity(solver: *mut cppr_solver, acceleration: *const f64) -> i32 {
    // SAFETY: the caller's promises.
    unsafe {
        add(solver, |loads| {
            let own = pointer::vector(acceleration, "acceleration")?;
            loads.gravity = Some(loads.gravity.unwrap_or_else(Vector3::zeros) + own);
            Ok(cppr_code::Ok)
        })
    }
}

/// Adds a thread under a tension (N) from the tip over a pulley, whose axle is parallel to Z, with its centre at three coordinates in the base
/// frame and a radius (m; 0 is an eyelet). It runs onto the pulley on its left, seen from the tip along the thread with +Z
/// up, or on its right. `point` is where it is tied in the tip section's frame (m), or null for its centre.
///
/// # Safety
/// `solver` is null or a living solver; `pulley` and `point` point to three numbers, `point` unless null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_add_thread(
    solver: *mut cppr_solver,
    tension: f64,
    pulley: *const f64,
    radius: f64,
    left: bool,
    point: *const f64,
) -> i32 {
    // SAFETY: the caller's promises.
    unsafe {
        add(solver, |loads| {
            let (pulley, point) =
                (pointer::vector(pulley, "pulley")?, pointer::vector_or_zero(point, "point")?);
            loads.threads.push(Thread { tension, pulley, radius, left, point });
            Ok(cppr_code::Ok)
        })
    }
}

unsafe fn solve(solver: *mut cppr_solver, warm: bool) -> i32 {
    guard(|| {
        // SAFETY: the caller's promise.
        let mut session = unsafe { session(solver) }?;
        session.solve(warm).map_err(|problem| say(cppr_code::BadCommand, format_args!("{problem}")))
    })
}

/// Solves for the equilibrium under the command, from rest. Gives CPPR_CODE_OK, CPPR_CODE_UNSTABLE, CPPR_CODE_NO_EQUILIBRIUM or what
/// went wrong. Of several stable equilibria it finds one; which one does not depend on earlier solves.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_solve(solver: *mut cppr_solver) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { solve(solver, false) }
}

/// The same from the last equilibrium that this solver found (at first, rest): a warm start, for control loops. It stays on the branch of that
/// equilibrium where that goes on. Allocates nothing from the second call on, as long as the kinds of inputs and loads, the options and which
/// tubes are pushed in stay; with a robot of parts and joints everything allocates.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_track(solver: *mut cppr_solver) -> i32 {
    // SAFETY: the caller's promise.
    unsafe { solve(solver, true) }
}

/// How many numbers a value (cppr_value) has; 0 where it is unknown or `solver` null.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_size(solver: *const cppr_solver, value: u32) -> usize {
    guard_or(0, || {
        // SAFETY: the caller's promise.
        let session = unsafe { session(solver) }?;
        Ok(size(&session.model, cppr_value::of(value)?))
    })
}

/// How many numbers a field (cppr_field) has per section; 0 where it is unknown or `solver` null.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_field_size(solver: *const cppr_solver, field: u32) -> usize {
    guard_or(0, || {
        // SAFETY: the caller's promise.
        let session = unsafe { session(solver) }?;
        Ok(field_size(&session.model, cppr_field::of(field)?))
    })
}

fn right_size(what: &str, number: u32, wanted: usize, given: usize) -> Result<(), cppr_code> {
    if wanted == given {
        return Ok(());
    }
    let text = format_args!("{what} {number} takes {wanted} numbers here; there is room for {given}");
    Err(say(cppr_code::BadArgument, text))
}

/// Writes a value (cppr_value) of the last solve into `out`, which has room for `count` numbers: exactly as many as
/// cppr_solver_size() says. CPPR_CODE_NO_VALUE where there is none; `out` is NaN then. Allocates nothing from the second call on,
/// except for margin, total bend and error.
///
/// # Safety
/// `solver` is null or a living solver; `out` points to room for `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_get(
    solver: *mut cppr_solver,
    value: u32,
    out: *mut f64,
    count: usize,
) -> i32 {
    guard(|| {
        // SAFETY: the caller's promises.
        let (mut session, own) = unsafe { (session(solver)?, cppr_value::of(value)?) };
        right_size("value", value, size(&session.model, own), count)?;
        // SAFETY: the caller's promise.
        let out = unsafe { pointer::output(out, count, "out") }?;
        if session.read(own, out) { Ok(cppr_code::Ok) } else { Err(no_value(&session)) }
    })
}

fn no_value(session: &Session) -> cppr_code {
    say(cppr_code::NoValue, format_args!("there is no such value: {}", session.why_not()))
}

/// Writes a field (cppr_field) of the last equilibrium at `sections` labels, section by section into `out`, which has room for exactly `count`
/// numbers. Labels are rest abscissae of the leader, or for a robot of parts and joints lengths of the centreline, from 0 to CPPR_VALUE_LENGTH (m). Allocates.
///
/// # Safety
/// `solver` is null or a living solver; `labels` points to `sections` numbers, `out` to room for `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_get_field(
    solver: *mut cppr_solver,
    field: u32,
    labels: *const f64,
    sections: usize,
    out: *mut f64,
    count: usize,
) -> i32 {
    guard(|| {
        // SAFETY: the caller's promises.
        let (mut session, own) = unsafe { (session(solver)?, cppr_field::of(field)?) };
        let wanted = field_size(&session.model, own).saturating_mul(sections);
        right_size("field", field, wanted, count)?;
        // SAFETY: the caller's promises.
        let (labels, out) =
            unsafe { (pointer::array(labels, sections, "labels")?, pointer::output(out, count, "out")?) };
        let reach = session.reach();
        if let Some(label) = labels.iter().find(|label| !(0.0..=reach).contains(*label)) {
            let text = format_args!("label {label} m: the robot reaches from 0 to {reach} m");
            return Err(say(cppr_code::BadArgument, text));
        }
        if session.field(own, labels, out) { Ok(cppr_code::Ok) } else { Err(no_value(&session)) }
    })
}

/// How the last solve ended, in one or more sentences, UTF-8; for one without equilibrium, why and what to do. Valid until the next
/// failure or explanation in this thread. Allocates.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_explain(solver: *const cppr_solver) -> *const c_char {
    guard_or((), || {
        // SAFETY: the caller's promise.
        let explained = unsafe { session(solver) }?.explain();
        say(cppr_code::Ok, format_args!("{explained}"));
        Ok(())
    });
    cppr_error_text()
}

/// What of the command would bend or turn the robot by several turns and so looks like a mistaken unit (90 for 90°): a sentence, valid as
/// that of cppr_solver_explain(), or null where there is none. Allocates.
///
/// # Safety
/// `solver` is null or a living solver.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_solver_doubt(solver: *const cppr_solver) -> *const c_char {
    let doubted = guard_or(false, || {
        // SAFETY: the caller's promise.
        let doubt = unsafe { session(solver) }?.doubt();
        Ok(doubt.map(|text| say(cppr_code::Ok, format_args!("{text}"))).is_some())
    });
    if doubted { cppr_error_text() } else { std::ptr::null() }
}
