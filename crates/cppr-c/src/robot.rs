//! The robot: read, checked, immutable.

use crate::model::Model;
use crate::pointer;
use crate::status::{cppr_code, guard_or, say};
use cppr_io::bundle_file::{self, Described};
use cppr_io::{Problems, RobotFile};
use std::ffi::{CString, c_char};
use std::fmt::Display;
use std::sync::Arc;

/// A checked robot. Immutable: any number of threads may use it at the same time.
#[allow(non_camel_case_types)]
pub struct cppr_robot {
    pub(crate) model: Arc<Model>,
    name: CString,
    /// Places of sudden changes for which it is integrated, and the robot as its file has it.
    sudden: Option<(CString, RobotFile)>,
}

/// What a file says, checked; `place` begins what is wrong with it as a whole.
fn opened(read: Result<Described, Problems>, place: &str) -> Result<*mut cppr_robot, cppr_code> {
    let refuse = |problems: &dyn Display| say(cppr_code::BadRobot, format_args!("{problems}"));
    let described = read.map_err(|problems| refuse(&problems))?;
    let written = described.clone();
    let (described, sudden) = described.integrated();
    let model = Model::new(described).map_err(|problems| {
        let each: Vec<String> = problems.0.iter().map(|problem| format!("{place}{problem}")).collect();
        refuse(&each.join("\n"))
    })?;
    let sudden = match (sudden, written) {
        (Some(places), Described::Robot(file)) => Some((CString::new(places).unwrap_or_default(), file)),
        _ => None,
    };
    Ok(boxed(Arc::new(model), sudden))
}

fn boxed(model: Arc<Model>, sudden: Option<(CString, RobotFile)>) -> *mut cppr_robot {
    let name = CString::new(model.name()).unwrap_or_default();
    Box::into_raw(Box::new(cppr_robot { model, name, sudden }))
}

/// Reads a robot file of either kind: tubes of one length joined at the tip, or parts and joints. Null where it cannot be read or describes no
/// robot; cppr_error_text() then lists every problem with its line. Free it with cppr_robot_free().
///
/// Tubes of one length with sudden changes along them, which modes do not follow, become a robot of parts and joints, which is integrated:
/// cppr_robot_sudden_changes() tells, and cppr_robot_with_modes() gives the other one.
///
/// # Safety
/// `path` points to a text that ends with 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_from_file(path: *const c_char) -> *mut cppr_robot {
    guard_or(std::ptr::null_mut(), || {
        // SAFETY: the caller's promise.
        let path = unsafe { pointer::text(path, "path") }?;
        opened(bundle_file::read(path), &format!("{path}: "))
    })
}

/// The same from the text of a robot file.
///
/// # Safety
/// `text` points to a text that ends with 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_from_text(text: *const c_char) -> *mut cppr_robot {
    guard_or(std::ptr::null_mut(), || {
        // SAFETY: the caller's promise.
        let text = unsafe { pointer::text(text, "text") }?;
        opened(bundle_file::parse_either(text), "")
    })
}

/// Where tubes of one length have sudden changes for which they became a robot of parts and joints, in words such as "notch depth of tube 1 at 30 mm",
/// valid as long as the robot; null for any other robot and for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_sudden_changes(robot: *const cppr_robot) -> *const c_char {
    guard_or(std::ptr::null(), || {
        // SAFETY: the caller's promise.
        let own = unsafe { pointer::object(robot, "robot") }?;
        Ok(own.sudden.as_ref().map_or(std::ptr::null(), |(places, _)| places.as_ptr()))
    })
}

/// The robot of the same file with modes, which do not follow its sudden changes: faster, less exact, with all options. A robot that has modes already is given once
/// more. Null where the file says parts or joints itself. Free it with cppr_robot_free().
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_with_modes(robot: *const cppr_robot) -> *mut cppr_robot {
    guard_or(std::ptr::null_mut(), || {
        // SAFETY: the caller's promise.
        let own = unsafe { pointer::object(robot, "robot") }?;
        match &own.sudden {
            Some((_, file)) => {
                let model = Model::new(Described::Robot(file.clone()));
                let model = model.map_err(|problems| say(cppr_code::BadRobot, format_args!("{problems}")))?;
                Ok(boxed(Arc::new(model), None))
            }
            None if own.model.has_parts() => {
                let text =
                    "a robot whose file has parts, joints, curved tubes or metal that softens has no modes";
                Err(say(cppr_code::BadRobot, format_args!("{text}")))
            }
            None => Ok(boxed(Arc::clone(&own.model), None)),
        }
    })
}

/// Frees a robot; nothing for a null pointer. Its solvers stay valid.
///
/// # Safety
/// `robot` is null or comes from this library and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_free(robot: *mut cppr_robot) {
    guard_or((), || {
        if !robot.is_null() {
            // SAFETY: it was boxed in `boxed` and is given back once.
            drop(unsafe { Box::from_raw(robot) });
        }
        Ok(())
    });
}

/// Name of the robot, valid as long as the robot; null for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_name(robot: *const cppr_robot) -> *const c_char {
    // SAFETY: the caller's promise.
    guard_or(std::ptr::null(), || Ok(unsafe { pointer::object(robot, "robot") }?.name.as_ptr()))
}

/// Rest length, of parts and joints that of the longest tube (m); NaN for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_length(robot: *const cppr_robot) -> f64 {
    // SAFETY: the caller's promise.
    guard_or(f64::NAN, || Ok(unsafe { pointer::object(robot, "robot") }?.model.length()))
}

/// Number of tubes, which are numbered from 1 as in the robot file; 0 for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_tubes(robot: *const cppr_robot) -> usize {
    // SAFETY: the caller's promise.
    guard_or(0, || Ok(unsafe { pointer::object(robot, "robot") }?.model.tubes()))
}

/// Is it of parts and joints, by its file or for sudden changes? Then every tube has an actuator, tube 1 too, and what depends on modes is not there:
/// see cppr_value, cppr_field and cppr_option. False for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_has_parts(robot: *const cppr_robot) -> bool {
    // SAFETY: the caller's promise.
    guard_or(false, || Ok(unsafe { pointer::object(robot, "robot") }?.model.has_parts()))
}

/// Has a tube an actuator? Without one it is clamped in the baseplate. False for a null pointer and for a tube that does not exist.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_is_actuated(robot: *const cppr_robot, tube: u32) -> bool {
    // SAFETY: the caller's promise.
    guard_or(false, || Ok(unsafe { pointer::object(robot, "robot") }?.model.actuator(tube).is_ok()))
}

/// Do all centroid lines at rest lie in the X-Y plane? False for a null pointer.
///
/// # Safety
/// `robot` is null or a living robot.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cppr_robot_is_planar(robot: *const cppr_robot) -> bool {
    // SAFETY: the caller's promise.
    guard_or(false, || Ok(unsafe { pointer::object(robot, "robot") }?.model.is_planar()))
}
