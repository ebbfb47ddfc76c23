//! `cppr limits` as a user meets it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, text};
use serde_json::Value;

#[test]
fn the_ends_of_a_range_are_where_the_pose_says_the_limit_is_reached() {
    let limits = |arguments: &[&str]| -> Value {
        let output = cppr(&[&["limits", "robots/r4.toml", "--json", "-"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let rest = limits(&[]);
    let (ranges, notches) = (rest["ranges"].as_array().unwrap(), rest["notches"].as_array().unwrap());
    assert_eq!((ranges.len(), notches.len()), (2, 30));
    for end in ["low", "high"] {
        assert_eq!(ranges[0][end]["bound"], "strain");
        let value = ranges[0][end]["value"].as_f64().unwrap();
        let there = limits(&["--pull", &format!("{value}m")]);
        let (pose, said) = (&there["pose"]["governing"], &ranges[0][end]["governing"]);
        assert!((pose["utilisation"].as_f64().unwrap() - 1.0).abs() < 1e-6, "{pose}");
        for key in ["tube", "notch"] {
            assert_eq!(pose["section"][key], said["section"][key]);
        }
    }
}

#[test]
fn every_notch_of_the_pose_is_a_row() {
    let csv = text(&cppr(&["limits", "robots/r3.toml", "--pull", "5mm", "--csv", "-"]).stdout);
    let mut lines = csv.lines();
    let columns = lines.next().unwrap().split(',').count();
    let rows: Vec<&str> = lines.collect();
    // All of the leader's; the follower's first notch has just left with its middle.
    assert!((29..=30).contains(&rows.len()), "{}", rows.len());
    assert!(rows.iter().all(|row| row.split(',').count() == columns && row.contains("notch")));
}

#[test]
fn what_cannot_be_judged_is_said() {
    let stiff = cppr(&["limits", "robots/childs3.toml", "--csv", "-"]);
    assert_eq!(stiff.status.code(), Some(2));
    assert!(text(&stiff.stderr).contains("given by their stiffness"));
    let beyond = cppr(&["limits", "robots/r1.toml", "--pull", "12mm"]);
    assert!(
        text(&beyond.stdout)
            .contains("% of what is allowed; all limits are kept up to tube 2 pulled by 7.684 mm")
    );
    let none = cppr(&["limits", "robots/r1.toml", "--tension", "1e6N"]);
    assert_eq!(none.status.code(), Some(3), "{}", text(&none.stderr));
}

/// What gaps change is estimated for robots of either kind, and a gap can be given where radii are not known.
#[test]
fn gaps_are_estimated() {
    let limits = |arguments: &[&str]| -> Value {
        let output = cppr(&[&["limits"], arguments, &["--json", "-"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let bent = limits(&["robots/r1.toml", "--pull", "5mm", "--tip-force", "0,0.1962,0N"]);
    let pair = &bent["clearance"]["pairs"][0];
    assert_eq!((&pair["outer"], &pair["inner"], &pair["touches"]), (&1.into(), &2.into(), &true.into()));
    assert!((pair["gap_m"].as_f64().unwrap() - 0.5e-3).abs() < 1e-12);
    let follower = &bent["clearance"]["actuators"][1];
    assert!(follower["backlash_m"].as_f64().unwrap() > 1e-4);
    let tension = follower["tension_N"].as_f64().unwrap();
    assert!(tension < 0.9 * bent["pose"]["tensions_N"][0].as_f64().unwrap(), "{tension}");
    let narrow = limits(&["robots/r1.toml", "--pull", "5mm", "--clearance", "0.05mm"]);
    assert!(narrow["clearance"]["pairs"][0]["offset_m"].as_f64().unwrap() < 0.05e-3);
    let sections = limits(&["robots/bundles/s_shape.toml", "--pull", "2=1mm", "--clearance", "0.1mm"]);
    assert!(!sections["clearance"]["pairs"].as_array().unwrap().is_empty());
    let output = cppr(&["limits", "robots/r1.toml", "--pull", "5mm", "--tip-force", "0,0.1962,0N"]);
    assert!(text(&output.stdout).contains("(backlash)"));
    let output = cppr(&["limits", "robots/r1.toml", "--clearance", "-1mm"]);
    assert_eq!(output.status.code(), Some(2));
}
