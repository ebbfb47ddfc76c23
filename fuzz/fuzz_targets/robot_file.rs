//! Any bytes are a robot or a list of problems; neither reading nor printing them may panic.
#![no_main]

use cppr_io::robot_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| match robot_file::parse_bytes(bytes) {
    Ok(robot) => assert_eq!(robot.design.tubes.len(), robot.tubes.len()),
    Err(problems) => assert!(!problems.list.is_empty() && !problems.to_string().is_empty()),
});
