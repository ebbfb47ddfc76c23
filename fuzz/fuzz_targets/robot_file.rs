//! Any bytes are a robot or a list of problems; neither reading, printing nor building the robot may panic, and what was
//! built has finite fields everywhere.
#![no_main]

use cppr::design::Robot;
use cppr_io::robot_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| match robot_file::parse_bytes(bytes) {
    Ok(file) => {
        assert_eq!(file.design.tubes.len(), file.tubes.len());
        let length = file.design.length;
        match Robot::new(file.design) {
            Ok(robot) => {
                for share in [-0.1, 0.0, 0.37, 1.0] {
                    for tube in 0..robot.tube_count() {
                        let fields = robot.fields_at(tube, share * length);
                        assert!(fields.bending_z.is_finite() && fields.torsion.is_finite());
                        assert!(fields.centroid_offset.is_finite() && fields.bending_y.is_finite());
                    }
                }
            }
            Err(problems) => assert!(problems.iter().all(|p| !p.to_string().is_empty())),
        }
    }
    Err(problems) => assert!(!problems.list.is_empty() && !problems.to_string().is_empty()),
});
