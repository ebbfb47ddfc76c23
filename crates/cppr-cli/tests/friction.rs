//! Friction from the shell: bounds of a pose, and histories; gaps between the tubes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{cppr, cppr_in, json, refused, text};
use serde_json::Value;

fn force(side: &Value, tube: u64) -> f64 {
    let actuators = side["actuators"].as_array().unwrap();
    actuators.iter().find(|own| own["tube"] == tube).unwrap()["tension_N"].as_f64().unwrap()
}

/// Pushed tubes whose edges stand above the plate, parts, joints, free tips, tapered tubes: wherever stiffness jumps, contact does too.
#[test]
fn full_slip_is_found_for_every_robot() {
    let mut met = 0;
    for (robot, pulls) in [
        ("r1", &["-5mm", "-1mm", "6mm"][..]),
        ("r2", &["-4mm", "8mm"]),
        ("r3", &["-1mm", "9mm"]),
        ("r4", &["-1mm", "4mm"]),
        ("childs2", &["-1mm", "4mm"]),
        ("childs3", &["1mm"]),
        ("bundles/s_shape", &["-4mm", "5mm"]),
        ("bundles/two_sections", &["4mm"]),
        ("bundles/hybrid", &["2=1mm"]),
    ] {
        for pull in pulls {
            let friction = if robot == "bundles/hybrid" { "0.1" } else { "0.3" };
            let found = json(&[
                "solve",
                &format!("robots/{robot}.toml"),
                "--pull",
                pull,
                "--friction",
                friction,
                "--json",
                "-",
            ]);
            let [loading, own, unloading] =
                [&found["friction"]["loading"], &found, &found["friction"]["unloading"]]
                    .map(|side| force(side, 2).abs());
            assert!(
                loading > 1.01 * own && 0.99 * own > unloading,
                "{robot} {pull}: {loading} {own} {unloading}"
            );
            met += 1;
        }
    }
    assert_eq!(met, 16);
}

#[test]
fn contact_is_told_where_it_is_asked_for() {
    let solve = ["solve", "robots/r1.toml", "--pull", "3mm", "--samples", "5"];
    let whole = json(&[&solve[..], &["--contact", "--json", "-"]].concat());
    let forces = whole["contact"]["pairs"][0]["force_N_m"].as_array().unwrap();
    assert!(forces.iter().any(|force| force[1].as_f64().unwrap().abs() > 1.0));
    let output = cppr(&[&solve[..], &["--contact", "--csv", "-"]].concat());
    assert!(text(&output.stdout).lines().next().unwrap().ends_with(",contact_1_2_N_m"));
    assert!(text(&output.stderr).contains("tube 1 on tube 2 with up to"), "{}", text(&output.stderr));
    assert!(json(&[&solve[..], &["--json", "-"]].concat()).get("contact").is_none());
}

#[test]
fn a_cycle_closes_and_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = "0..2..-2..2mm";
    let all = ["cycle", "robots/r1.toml", "--pull", path, "--friction", "0.2", "--steps", "4"];
    let run = |more: &[&str]| cppr_in(folder.path(), &[&all[..], more].concat());
    let output = run(&["--json", "c.json", "--csv", "c.csv", "--plot", "c.svg"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let found: Value = serde_json::from_str(&read("c.json")).unwrap();
    let points = found["points"].as_array().unwrap();
    assert_eq!((points.len(), read("c.csv").lines().count()), (13, 14));
    // Slip goes one way all along at the ends of both legs: the same state, whatever came before.
    let [first, last] = [4, 12].map(|at| force(&points[at], 2));
    assert!((first / last - 1.0).abs() < 1e-3, "{first} {last}");
    assert!(found["loop"]["energy_J"].as_f64().unwrap() > 1e-4);
    assert_eq!(found["turns"].as_array().unwrap().len(), 2);
    for word in ["R1, friction 0.2", "leg 3", "pull"] {
        assert!(read("c.svg").contains(word), "{word} is missing");
    }
    assert!(text(&output.stdout).contains("lost motion"));
}

#[test]
fn what_friction_cannot_do_is_said() {
    let solve = ["solve", "robots/r1.toml", "--pull", "1mm"];
    let cycle = ["cycle", "robots/r1.toml", "--friction", "0.2"];
    for (arguments, fragment) in [
        ([&solve[..], &["--friction", "-0.1"]].concat(), "from 0 to 2"),
        ([&solve[..], &["--guide", "10mm"]].concat(), "--friction"),
        ([&solve[..], &["--friction", "0.1", "--guide", "0mm"]].concat(), "above 0"),
        ([&solve[..], &["--friction", "0.1", "--formulation", "printed"]].concat(), "consistent"),
        ([&cycle[..], &["--pull", "1mm"]].concat(), "no motor moves"),
        ([&cycle[..], &["--pull", "0..1mm", "--rotate", "0..1..0deg"]].concat(), "as many"),
    ] {
        refused(&arguments, fragment);
    }
    // Where friction and contact find no common answer, no number is given.
    let folder = tempfile::tempdir().unwrap();
    let beyond = ["robots/bundles/hybrid.toml", "--pull", "2=4mm", "--friction", "0.6", "--json", "f.json"];
    let output = cppr_in(folder.path(), &[&["solve"], &beyond[..]].concat());
    assert_eq!((output.status.code(), output.stdout.len()), (Some(3), 0));
    assert!(
        text(&output.stderr).contains("no equilibrium with full slip was found"),
        "{}",
        text(&output.stderr)
    );
    assert!(!folder.path().join("f.json").exists());
    let output =
        cppr(&["cycle", "robots/r1.toml", "--pull", "0..140mm", "--friction", "0.2", "--steps", "2"]);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(3), 0));
    assert!(text(&output.stderr).contains("leg 1"), "{}", text(&output.stderr));
}

/// What friction does to a pose is the same in a table, in a search and, read backwards, in a force that is sensed.
#[test]
fn sweeps_searches_and_sensing_know_friction() {
    let folder = tempfile::tempdir().unwrap();
    let rub = ["--friction", "0.2", "--guide", "20mm"];
    let sweep = ["sweep", "robots/r1.toml", "--pull", "3..5mm:3", "--output", "table.csv"];
    let output = cppr_in(folder.path(), &[&sweep[..], &rub].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = std::fs::read_to_string(folder.path().join("table.csv")).unwrap();
    let mut rows = table.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(','));
    let header: Vec<&str> = rows.next().unwrap().collect();
    let last: Vec<&str> = rows.next_back().unwrap().collect();
    let at = |name: &str| last[header.iter().position(|h| *h == name).unwrap()].parse::<f64>().unwrap();
    let pose = ["robots/r1.toml", "--pull", "5mm", "--json", "-"];
    let own = json(&[&["solve"][..], &pose, &rub].concat());
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-4;
    for way in ["loading", "unloading"] {
        assert!(near(at(&format!("{way}_tube2_tension_N")), force(&own["friction"][way], 2)), "{way}");
    }
    // Driven on to 5 mm without a force on the tip.
    let tension = format!("{}N", force(&own["friction"]["loading"], 2));
    let tip: Vec<String> = own["friction"]["loading"]["tip_position_m"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| (c.as_f64().unwrap() * 1e3).to_string())
        .collect();
    let tip = format!("{}mm", tip.join(","));
    let measured = ["--measured-tension", &tension, "--measured-position", &tip];
    let sensed = json(&[&["sense"][..], &pose, &measured, &rub].concat());
    let size = |own: &Value| {
        own["force_N"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap().powi(2)).sum::<f64>().sqrt()
    };
    assert!(size(&sensed["friction"]["loading"]) < 1e-3, "{sensed}");
    assert!(size(&sensed) > 0.01 && size(&sensed["friction"]["unloading"]) > 0.02, "{sensed}");
    let there = ["--rotate", "0deg", "--pull-bounds", "0..6mm", "--json", "-"];
    let target = ["reach", "robots/r1.toml", "--position", "128,-58.3,0mm"];
    let reached = json(&[&target[..], &there, &rub].concat());
    let sides = ["loading", "unloading"].map(|way| force(&reached["friction"][way], 2));
    assert!(sides[0] > force(&reached, 2) && force(&reached, 2) > sides[1]);
    assert!(json(&[&target[..], &there].concat())["friction"].is_null());
}

/// A robot file that says how its tubes rub is asked as with the options, which take its place.
#[test]
fn a_robot_file_holds_friction() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, robot: &str| {
        let text = std::fs::read_to_string(format!("../../robots/{robot}.toml")).unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text + "\n[friction]\ncoefficient = 0.2\nguide_mm = 20.0\n").unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (one, bundle) = (put("one.toml", "r1"), put("two.toml", "bundles/two_sections"));
    let rub = ["--friction", "0.2", "--guide", "20mm"];
    let (plain, sections) = ("robots/r1.toml", "robots/bundles/two_sections.toml");
    for (command, file, plain, more) in [
        ("solve", &one, plain, &["--pull", "5mm"][..]),
        ("solve", &bundle, sections, &["--pull", "2mm"]),
        ("sense", &one, plain, &["--pull", "5mm", "--measured-tension", "5.2N"]),
        (
            "reach",
            &one,
            plain,
            &["--position", "128,-58.3,0mm", "--rotate", "0deg", "--pull-bounds", "0..6mm"],
        ),
        ("cycle", &one, plain, &["--pull", "0..1mm", "--steps", "2"]),
    ] {
        let ask = |robot: &str, options: &[&str]| {
            json(&[&[command, robot][..], more, options, &["--json", "-"]].concat())
        };
        let (own, told) = (ask(file, &[]), ask(plain, &rub));
        assert_eq!(own["friction"], told["friction"], "{command}");
        assert!(own["friction"]["guide_m"].as_f64().unwrap() > 0.0, "{command}: {own}");
        let other = ask(file, &["--friction", "0.1"]);
        assert_eq!(other["friction"], ask(plain, &["--friction", "0.1", "--guide", "20mm"])["friction"]);
        if command != "cycle" {
            assert_eq!(ask(file, &["--friction", "0"]), ask(plain, &[]), "{command}");
        }
    }
    // Without modes there is no printed formulation, unless friction is left out.
    let printed = ["solve", &one, "--pull", "1mm", "--formulation", "printed"];
    refused(&printed, "--friction 0");
    assert!(cppr(&[&printed[..], &["--friction", "0"]].concat()).status.success());
    refused(&["cycle", plain, "--pull", "0..1mm"], "say how the tubes rub");
    let table = |name: &str, more: &[&str]| {
        let asked = ["sweep", &one, "--pull", "4..5mm:2", "--output", name];
        let output = cppr_in(folder.path(), &[&asked[..], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let whole = std::fs::read_to_string(folder.path().join(name)).unwrap();
        let rows: Vec<String> = whole.lines().filter(|l| !l.starts_with('#')).map(str::to_owned).collect();
        let at = rows[0].split(',').position(|name| name == "loading_tube2_tension_N");
        rows[1..].iter().filter_map(|row| row.split(',').nth(at?)?.parse().ok()).collect::<Vec<f64>>()
    };
    let own = table("own.csv", &[]);
    assert_eq!(own.len(), 2);
    assert!(table("without.csv", &["--friction", "0"]).is_empty());
    // What varies of it is as the key says, the rest as the option.
    let varied = table("varied.csv", &["--vary", "friction.coefficient=0.1..0.2:2", "--guide", "20mm"]);
    assert!(
        varied.len() == 4 && varied[0] < varied[2] && (varied[3] / own[1] - 1.0).abs() < 1e-9,
        "{varied:?}"
    );
    let idle = ["--vary", "friction.coefficient=0.1..0.2:2", "--friction", "0", "--output", "idle.csv"];
    refused(&[&["sweep", &one, "--pull", "1mm"], &idle[..]].concat(), "leaves friction out");
}

/// Robots are solved with contact, near what is estimated; where metal is not linear the estimate is told, and why it is one.
#[test]
fn gaps_are_solved_for_or_estimated() {
    let pose = ["robots/r1.toml", "--pull", "6mm", "--json", "-"];
    let whole = json(&[&["solve"][..], &pose, &["--clearance", "radii"]].concat());
    let estimate = json(&[&["limits"][..], &pose].concat());
    let (own, told) = (&whole["clearance"], &estimate["clearance"]);
    assert_eq!(own["method"], "solved");
    let near = |a: &Value, b: &Value| (a.as_f64().unwrap() / b.as_f64().unwrap() - 1.0).abs() < 0.02;
    assert!(near(&own["pairs"][0]["mean_offset_m"], &told["pairs"][0]["offset_m"]));
    assert!((force(own, 2) / force(told, 2) - 1.0).abs() < 0.01 && force(own, 2) < 0.9 * force(&whole, 2));
    let output = cppr(&["solve", "robots/r1.toml", "--pull", "6mm", "--clearance", "0.5mm"]);
    let said = text(&output.stdout);
    assert!(said.contains("on the wall at 180 deg"), "{said}");
    // An edge at the plate, and next to it: the tip moves by no more than the pull and its lever make it.
    let tip = |pull: &str| {
        let load = ["--tip-force", "0,-0.1962,0N", "--clearance", "radii", "--json", "-"];
        let whole = json(&[&["solve", "robots/r1.toml", "--pull", pull][..], &load].concat());
        assert_eq!(whole["clearance"]["method"], "solved", "{pull}");
        whole["clearance"]["tip_position_m"][1].as_f64().unwrap()
    };
    let at_plate = tip("0mm");
    for pull in ["-0.001mm", "0.001mm", "-1e-6mm"] {
        assert!((tip(pull) - at_plate).abs() < 5e-5, "{pull}");
    }
    let winding =
        json(&["solve", "robots/helicoid.toml", "--pull", "5mm", "--clearance", "radii", "--json", "-"]);
    let zone = &winding["clearance"]["pairs"][0]["zones"][0];
    let [first, last] = [0, 1].map(|i| zone["angle_rad"][i].as_f64().unwrap());
    assert!((last - first).abs() > 3.0, "the wall that is touched winds with the notches: {zone}");
    let parts = "robots/bundles/s_shape.toml";
    let whole = json(&["solve", parts, "--pull", "5mm", "--clearance", "0.1mm", "--json", "-"]);
    let own_parts = &whole["clearance"];
    assert_eq!(own_parts["method"], "solved");
    assert!((0.8..0.99).contains(&(force(own_parts, 2) / force(&whole, 2))), "{}", own_parts["actuators"]);
    let sides: Vec<bool> = own_parts["pairs"][0]["zones"]
        .as_array()
        .unwrap()
        .iter()
        .map(|zone| zone["angle_rad"][0].as_f64().unwrap().abs() > 1.0)
        .collect();
    assert!(sides.contains(&true) && sides.contains(&false), "the bend of an S has two insides: {sides:?}");
    let estimated = "robots/wrists/superelastic.toml";
    let whole = json(&["solve", estimated, "--pull", "2=0.2mm", "--clearance", "0.05mm", "--json", "-"]);
    assert_eq!(whole["clearance"]["method"], "estimated");
    assert!(whole["clearance"]["because"].as_str().unwrap().contains("not, or its teeth"));
    // Play in the guide is less force for the same pull.
    let guide = ["--guide", "20mm", "--guide-gap", "0.5mm"];
    let guided = json(&[&["solve"][..], &pose, &["--clearance", "radii"], &guide].concat());
    assert!(force(&guided["clearance"], 2) < force(own, 2) - 0.02);
    assert!(guided["clearance"]["x_m"][0].as_f64().unwrap() < -0.0199);
    let asked = ["solve", "robots/r1.toml", "--pull", "1mm", "--clearance", "radii"];
    refused(&[&asked[..], &["--guide", "20mm"]].concat(), "--guide-gap");
    refused(&[&asked[..], &["--guide-gap", "1mm"]].concat(), "--guide <LENGTH>");
    refused(&[&asked[..], &["--guide", "20mm", "--guide-gap", "radii"]].concat(), "for instance 0.1mm");
    let metal = ["solve", estimated, "--pull", "2=0.2mm", "--clearance", "0.05mm"];
    refused(&[&metal[..], &guide].concat(), "linear tubes");
    let telescope =
        ["solve", "robots/bundles/concentric3.toml", "--rotate", "3=60deg", "--clearance", "radii"];
    let said = text(&cppr(&telescope).stdout);
    assert!(said.contains("tube 3 lies") && said.contains("on the wall"), "{said}");
    for (robot, gap, words) in [
        ("r1", "-0.1mm", "cannot be negative"),
        ("r1", "0.1", "unit"),
        ("childs3", "radii", "give the gap"),
        ("bundles/s_shape", "radii", "give the gap"),
    ] {
        let robot = format!("robots/{robot}.toml");
        refused(&["solve", &robot, "--pull", "1mm", "--clearance", gap], words);
    }
}
