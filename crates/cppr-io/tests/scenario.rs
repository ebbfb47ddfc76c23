//! A scenario says all that the options of the program can say.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::kinematics::Resolution;
use cppr::solve::{Formulation, Settings};
use cppr_io::Scenario;

#[test]
fn settings_are_all_there() {
    for (text, wanted) in [
        ("", Settings::default()),
        ("modes = \"planar\"", Settings::planar()),
        ("modes = \"paper\"", Settings::default().with_resolution(Resolution::PAPER)),
        ("refine = 3", Settings::default().with_resolution(Resolution::SPATIAL.refined(3))),
        ("modes = \"paper\"\nrefine = 2\nstretch = true", {
            Settings::default().with_resolution(Resolution::PAPER.refined(2)).with_stretch()
        }),
        ("formulation = \"printed\"", {
            Settings { formulation: Formulation::Printed, ..Settings::default() }
        }),
    ] {
        let scenario = Scenario::parse(text).unwrap();
        assert_eq!(scenario.settings(), wanted, "{text}");
        let again = Scenario::parse(&scenario.to_toml().unwrap()).unwrap();
        assert_eq!(again, scenario, "{text}");
    }
    for (text, words) in [
        ("refine = 0", "refine is 0; it must be from 1 to 8"),
        ("refine = 9", "refine is 9"),
        ("modes = \"fine\"", "unknown variant"),
    ] {
        let problem = Scenario::parse(text).unwrap_err();
        assert!(problem.contains(words), "{problem}");
    }
}
