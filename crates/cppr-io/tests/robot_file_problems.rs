//! What is said of files that are wrong.
#![allow(clippy::panic, clippy::unwrap_used, clippy::expect_used, reason = "a test fails by panicking")]

use cppr_io::{Problem, Problems, robot_file};

const R1: &str = include_str!("../../../robots/r1.toml");
const CHILDS2: &str = include_str!("../../../robots/childs2.toml");

fn problems(text: &str) -> Problems {
    robot_file::parse(text).expect_err("a file that is wrong")
}

/// R1 with a piece replaced; the piece must be there. Returns the line of its first place as well.
fn changed(file: &str, from: &str, to: &str) -> (String, usize) {
    let at = file.find(from).unwrap_or_else(|| panic!("{from:?} is not in the file"));
    (file.replacen(from, to, 1), file[..at].matches('\n').count() + 1)
}

/// The only problem of a file.
fn only(text: &str) -> Problem {
    let problems = problems(text);
    assert_eq!(problems.list.len(), 1, "{problems}");
    problems.list[0].clone()
}

/// One change makes one problem, on the line of the change, that says all the fragments.
fn expect_in(file: &str, from: &str, to: &str, fragments: &[&str]) {
    let (text, line) = changed(file, from, to);
    let problem = only(&text);
    let said = problem.to_string();
    assert_eq!(problem.line, line, "{said}");
    for fragment in fragments {
        assert!(said.contains(fragment), "{fragment:?} is not in\n{said}");
    }
    assert!(!problem.help.is_empty(), "{said}");
}

fn expect(from: &str, to: &str, fragments: &[&str]) {
    expect_in(R1, from, to, fragments);
}

#[test]
fn the_whole_text_of_a_message() {
    let (text, _) = changed(R1, "depth_mm = 2.0", "depth_mm = 3.5");
    let said = problems(&text).in_file("robots/r1.toml").to_string();
    let expected = "\
robots/r1.toml:34: tube 2, notches.depth_mm: 3.5 mm is deeper than the tube is wide (3.0 mm). \
Write a depth below 3.0, or leave notches out for an uncut tube.
   |
34 | depth_mm = 3.5
   |            ^^^";
    assert_eq!(said, expected);
}

#[test]
fn other_names_for_what_is_known() {
    let in_material = |key: &str| format!("{key} = 1.0\nyoungs_modulus_GPa");
    let meant = [
        ("plateau_stress_MPa", "Write the modulus below the plateau or yield as youngs_modulus_GPa"),
        ("yield_strength_MPa", "allowable_strain_percent"),
        ("elastic_modulus_GPa", "Did you mean youngs_modulus_GPa?"),
        ("E_GPa", "Did you mean youngs_modulus_GPa?"),
        ("nu", "Did you mean poissons_ratio?"),
        ("rho_kg_m3", "Did you mean density_kg_m3?"),
        ("max_strain_percent", "Did you mean allowable_strain_percent?"),
    ];
    for (key, help) in meant {
        expect(
            "youngs_modulus_GPa",
            &in_material(key),
            &[&format!("material.{key}"), "not known here", help],
        );
    }
    for (from, to, help) in [
        ("inner_radius_mm", "wall_mm", "Write inner_diameter_mm, the outer diameter less twice the wall."),
        ("outer_radius_mm", "OD_mm", "Did you mean outer_diameter_mm?"),
        ("outer_radius_mm = 3.0", "outer_diameter = 6.0", "Write outer_diameter_mm = 6.0."),
        ("depth_mm", "notch_depth_mm", "Did you mean depth_mm?"),
        ("tooth_mm", "pitch_mm", "Write tooth_mm, the pitch less length_mm."),
        ("opening_deg", "direction_deg", "Did you mean opening_deg?"),
        ("below_plate", "number_of_notches", "Did you mean count?"),
    ] {
        expect(from, to, &[help]);
    }
}

#[test]
fn diameters_that_are_wrong() {
    let both = "outer_radius_mm = 3.0\nouter_diameter_mm = 6.0";
    let problem = only(&changed(R1, "outer_radius_mm = 3.0", both).0);
    assert!(problem.to_string().contains("Keep one of outer_radius_mm and outer_diameter_mm"), "{problem}");
    expect(
        "inner_radius_mm = 2.0",
        "inner_diameter_mm = 6.0",
        &["6.0 mm leaves no wall in a tube of outer radius 3.0 mm", "Write a diameter below 6.0."],
    );
    expect("outer_radius_mm = 3.0", "outer_diameter_mm = -6.0", &["a diameter cannot be negative"]);
    expect(
        "outer_radius_mm = 3.0",
        "outer_diameter_mm = 400",
        &["a diameter of 400.0 mm is larger than the tube is long (150.0 mm)"],
    );
    expect(
        "outer_radius_mm = 1.5",
        "outer_diameter_mm = 4.2",
        &["tube 2, outer_diameter_mm", "reaches 2.1 mm", "Write an outer diameter of at most 4.0"],
    );
    let missing = only(&changed(R1, "inner_radius_mm = 2.0\n", "").0).to_string();
    assert!(missing.contains("Write inner_radius_mm = 2.0, or inner_diameter_mm = 4.0."), "{missing}");
}

#[test]
fn unknown_keys() {
    expect("tooth_mm", "tooht_mm", &["tube 1, notches.tooht_mm", "not known here", "Did you mean tooth_mm?"]);
    expect("outer_radius_mm", "outer_raduis", &["Did you mean outer_radius_mm?"]);
    expect("[calibration]", "[calibrations]", &["calibrations", "Did you mean calibration?"]);
    expect("below_plate", "colour", &["not known here", "Known are depth_mm, length_mm,"]);
}

#[test]
fn units() {
    expect("length_mm = 150.0", "length = 150.0", &["the unit is missing", "Write length_mm = 150.0."]);
    expect("length_mm = 150.0", "length_cm = 15.0", &["this unit is not used", "Write length_mm = 150.0."]);
    expect("youngs_modulus_GPa = 5.39", "youngs_modulus_MPa = 5390", &["Write youngs_modulus_GPa = 5.39."]);
    expect("opening_deg = 180.0", "opening = 180", &["Write opening_deg = 180.0."]);
    expect(
        "length_mm = 150.0",
        "length_mm = \"150 mm\"",
        &["must be a number", "Write length_mm = 150; the unit"],
    );
}

#[test]
fn wrong_types() {
    expect("name = \"R1\"", "name = 1", &["must be a text in quotes", "it is a number", "Write name ="]);
    expect(
        "depth_mm = 5.0",
        "depth_mm = true",
        &["must be a number", "true or false", "Write depth_mm = 5.0"],
    );
    expect("[material]", "[[material]]", &["must be a table, and it is a list", "single brackets"]);
    let inline = "[tube.material]\nyoungs_modulus_GPa = 1979-05-27\n[tube.notches]";
    let (text, line) = changed(R1, "[tube.notches]", inline);
    assert_eq!(only(&text).line, line + 1);
    let problem = only("name = \"a\"\nlength_mm = 1\ntube = 3\n");
    assert!((problem.line, problem.key.as_str()) == (3, "tube"), "{problem}");
    let problem = only("name = \"a\"\nlength_mm = 1\ntube = [3]\n");
    assert!((problem.line, problem.key.as_str()) == (3, "tube 1"), "{problem}");
}

#[test]
fn one_bracket_around_tube() {
    let text = R1.split("[[tube]] # the follower").next().unwrap().replace("[[tube]]", "[tube]");
    let problem = only(&text);
    assert!(problem.to_string().contains("Write [[tube]]."), "{problem}");
    assert!(problem.excerpt.as_ref().is_some_and(|e| e.text.starts_with("[tube]")), "{problem}");
}

#[test]
fn missing_keys() {
    for (key, line) in [
        ("name = \"R1\"", 1),
        ("length_mm = 150.0", 1),
        ("youngs_modulus_GPa = 5.39", 9),
        ("poissons_ratio = 0.35", 9),
        ("density_kg_m3 = 1240", 9),
        ("inner_radius_mm = 2.0", 18),
        ("depth_mm = 5.0", 22),
        ("tooth_mm = 5.0", 22),
        ("opening_deg = 0.0", 33),
    ] {
        let (text, _) = changed(R1, key, "#");
        let problem = only(&text);
        let name = key.split(' ').next().unwrap();
        assert!(problem.key.ends_with(name), "{problem}");
        assert!(problem.message.contains("missing") && problem.help.contains(name), "{problem}");
        assert_eq!(problem.line, line, "{problem}");
    }
    let (text, _) = changed(CHILDS2, "bending_z_Nmm2 = 125", "");
    assert!(only(&text).key == "tube 1, stiffness.bending_z_Nmm2");
    let problem = only("name = \"a\"\nlength_mm = 10\n");
    assert!(problem.to_string().contains("[[tube]]"), "{problem}");
}

#[test]
fn numbers_that_cannot_be() {
    expect("depth_mm = 5.0", "depth_mm = nan", &["must be a finite number"]);
    expect("length_mm = 150.0", "length_mm = inf", &["must be a finite number"]);
    expect("length_mm = 150.0", "length_mm = 1e999", &["length_mm"]);
    expect(
        "length_mm = 150.0",
        "length_mm = -150.0",
        &["cannot be negative, and this is -150.0 mm", "above 0"],
    );
    expect("length_mm = 150.0", "length_mm = 0", &["cannot be zero"]);
    expect("outer_radius_mm = 3.0", "outer_radius_mm = -3.0", &["cannot be negative"]);
    expect("depth_mm = 5.0", "depth_mm = 0", &["a notch without depth", "leave notches out"]);
    expect(
        "youngs_modulus_GPa = 5.39",
        "youngs_modulus_GPa = -1",
        &["an elastic modulus cannot be negative"],
    );
    expect("poissons_ratio = 0.35", "poissons_ratio = 0.7", &["between -1 and 0.5", "0.7"]);
    expect("poissons_ratio = 0.35", "poissons_ratio = -1", &["between -1 and 0.5"]);
    expect("centroid_offset_factor = 1.27", "centroid_offset_factor = 0", &["cannot be zero"]);
    expect_in(CHILDS2, "bending_z_Nmm2 = 125", "bending_z_Nmm2 = -125", &["a stiffness cannot be negative"]);
    expect_in(CHILDS2, "torsion_Nmm2 = 108", "torsion_Nmm2 = 0", &["a stiffness cannot be zero"]);
}

#[test]
fn sizes_that_are_slips_of_the_unit() {
    expect(
        "length_mm = 150.0",
        "length_mm = 150000",
        &["150000.0 mm is more than any robot has", "millimetres"],
    );
    expect("length_mm = 150.0", "length_mm = 1e-4", &["less than any robot has"]);
    expect("youngs_modulus_GPa = 5.39", "youngs_modulus_GPa = 5390", &["more than any", "5.39 for 5390 MPa"]);
    expect("density_kg_m3 = 1240", "density_kg_m3 = 1.24", &["less than any", "1.24 g/cm³ is 1240 kg/m³"]);
    expect("opening_deg = 180.0", "opening_deg = 1e9", &["a hundred turns"]);
    expect("outer_radius_mm = 3.0", "outer_radius_mm = 300.0", &["larger than the tube is long (150.0 mm)"]);
    let text =
        R1.replace("radius_mm = 3.0", "radius_mm = 0.003").replace("radius_mm = 2.0", "radius_mm = 0.002");
    assert!(problems(&text).to_string().contains("less than a ten-thousandth of the length"));
}

#[test]
fn geometry_that_cannot_be() {
    expect(
        "outer_radius_mm = 1.5",
        "outer_radius_mm = 2.4",
        &["tube 2, outer_radius_mm", "reaches 2.4 mm", "bore of tube 1 (2.0 mm)", "at most 2.0"],
    );
    expect(
        "outer_radius_mm = 1.5",
        "outer_radius_mm = 1.5\nshape = \"square\"",
        &["reaches 2.12132 mm", "at most 1.414214"],
    );
    expect("inner_radius_mm = 2.0", "inner_radius_mm = 3.0", &["leaves no wall", "below 3.0"]);
    expect(
        "inner_radius_mm = 2.0",
        "inner_radius_mm = 2.9999999",
        &["thinner wall than any robot has (0.001 mm)", "below 2.999"],
    );
    expect(
        "depth_mm = 5.0",
        "depth_mm = 9.3",
        &["9.3 mm is deeper than the tube is wide (6.0 mm)", "below 6.0"],
    );
    expect("depth_mm = 5.0", "depth_mm = 6.0", &["cuts the tube through", "below 6.0"]);
    expect(
        "depth_mm = 5.0",
        "depth_mm = 5.9999999",
        &["leaves less of the tube than any robot has (0.001 mm)", "below 5.999"],
    );
    expect("depth_mm = 5.0", "depth_mm = [5.0, 7.0]", &["notches.depth_mm, number 2: 7.0 mm is deeper"]);
}

#[test]
fn words() {
    expect("below_plate = \"plain\"", "below_plate = \"plane\"", &["not known", "Did you mean \"plain\"?"]);
    expect("below_plate = \"plain\"", "torsion = \"saint venant\"", &["Did you mean \"saint-venant\"?"]);
    expect("below_plate = \"plain\"", "torsion = 170", &["torsion = { stiffness_Nmm2 = 170.0 }"]);
    expect(
        "[tube.notches]",
        "shape = \"triangle\"\n[tube.notches]",
        &["\"round\", \"square\" and \"hexagon\""],
    );
    expect("name = \"R1\"", "name = \" \"", &["the name is empty"]);
}

#[test]
fn patterns() {
    expect("length_mm = 5.0", "length_mm = 200.0", &["longer than the tube", "(200.0 + 5.0) mm", "150.0 mm"]);
    expect("tooth_mm = 5.0", "count = 0\ntooth_mm = 5.0", &["a whole number from 1"]);
    let (text, line) = changed(R1, "tooth_mm = 5.0", "tooth_mm = 5.0\ncount = 16");
    let problem = only(&text);
    assert_eq!(problem.line, line + 1);
    assert!(
        problem.to_string().contains("16 × (5.0 + 5.0) mm is more than 150.0 mm. There is room for 15."),
        "{problem}"
    );
    expect("depth_mm = 5.0", "depth_mm = [5, 5, 5]", &["3 values stand for 15 notches", "or count = 3"]);
    let sixteen = format!("depth_mm = {:?}", [5.0; 16]);
    expect("depth_mm = 5.0", &sixteen, &["longer than the tube: 16 ×", "room for 15"]);
    expect("depth_mm = 5.0", "depth_mm = []", &["the list is empty"]);
    expect("depth_mm = 5.0", "depth_mm = [5, \"5\"]", &["number 2: this must be a number, and it is a text"]);
    let (text, line) = changed(R1, "depth_mm = 5.0\nlength_mm = 5.0\ntooth_mm = 5.0", "depth_mm = [1, 2, 1]");
    let problem = only(&text);
    assert_eq!(problem.line, line);
    assert!(problem.to_string().contains("needs the places of the notches"), "{problem}");
    // A natural spline through these swings below zero.
    let swing = "depth_mm = [0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]";
    expect("depth_mm = 5.0", swing, &["the curve through these depths is -"]);
}

#[test]
fn tables() {
    let table = |x: &str, depth: &str| format!("depth_mm = {{ x_mm = {x}, depth_mm = {depth} }}");
    expect(
        "depth_mm = 5.0",
        &table("[0, 9, 8]", "[1, 2, 3]"),
        &["8.0 mm does not lie beyond 9.0 mm", "increasing"],
    );
    expect("depth_mm = 5.0", &table("[0, 151]", "[1, 2]"), &["151.0 mm lies beyond the tip at 150.0 mm"]);
    expect("depth_mm = 5.0", &table("[-1, 100]", "[1, 2]"), &["notches.depth_mm.x_mm, number 1", "negative"]);
    expect("depth_mm = 5.0", &table("[0, 1, 2]", "[1, 2]"), &["2 values stand at 3 abscissae"]);
    expect("depth_mm = 5.0", &table("[0]", "[1]"), &["two or more"]);
    expect("depth_mm = 5.0", &table("[0, 1]", "2"), &["must be a list", "a number"]);
    expect("depth_mm = 5.0", &table("[0, 1]", "[2, 7]"), &["deeper than the tube"]);
    expect("depth_mm = 5.0", "depth_mm = { x = [0, 1], depth_mm = [1, 2] }", &["Write x_mm."]);
    expect("depth_mm = 5.0", "depth_mm = { x_mm = [0, 1] }", &["depth_mm.depth_mm: this key is missing"]);
    expect_in(
        CHILDS2,
        "bending_z_Nmm2 = 125",
        "bending_z_Nmm2 = [1, 2, 3]",
        &["base and tip, and this has 3", "x_mm"],
    );
}

#[test]
fn contradictions() {
    let (text, _) =
        changed(CHILDS2, "[tube.stiffness]", "outer_radius_mm = 3\ninner_radius_mm = 2\n[tube.stiffness]");
    let said = problems(&text).to_string();
    assert!(said.contains("line 10: tube 1, stiffness: a geometry is given too (outer_radius_mm)"), "{said}");
    let problem = only("name = \"a\"\nlength_mm = 10\n[[tube]]\n");
    assert_eq!(problem.line, 3);
    assert!(problem.to_string().contains("neither a geometry nor a stiffness"), "{problem}");
    let (text, line) = changed(R1, "poissons_ratio = 0.35", "poissons_ratio = 0.35\nshear_modulus_GPa = 2");
    assert_eq!(only(&text).line, line + 1);
    let turned = "opening_deg = [0, 90]\ntwist_deg = 10";
    let (text, line) = changed(R1, "opening_deg = 180.0", turned);
    assert_eq!(only(&text).line, line + 1);
}

#[test]
fn offences_against_toml() {
    expect(
        "length_mm = 150.0",
        "length_mm = 150.0 mm",
        &["neither a number nor a text in quotes", "without their unit"],
    );
    expect("name = \"R1\"", "name = R1", &["double quotes"]);
    expect("[material]", "[material", &[]);
    expect("length_mm = 150.0", "length_mm = 150,0", &[]);
    let (text, line) = changed(R1, "length_mm = 150.0", "length_mm = 150.0\nlength_mm = 151.0");
    let problem = only(&text);
    assert_eq!(problem.line, line + 1);
    assert!(problem.to_string().contains("Keep one of the two."), "{problem}");
    // A header that comes twice is one problem, not one for each of its keys.
    let again = R1.replace("[[tube]] # the follower", "# the follower").replace("outer_radius_mm = 1.5", "");
    let problem = only(&again.replace("inner_radius_mm = 0.5", ""));
    assert_eq!(problem.line, 33, "{problem}");
    assert!(problem.help.contains("[[tube]]"), "{problem}");
    // What stands before the first offence is still checked, and nothing seems to be missing after it.
    let text = R1
        .replace("youngs_modulus_GPa = 5.39", "youngs_modulus_GPa = -1")
        .replace("depth_mm = 5.0", "depth_mm = ");
    let problems = problems(&text);
    assert_eq!(problems.list.iter().map(|p| p.line).collect::<Vec<_>>(), [10, 23], "{problems}");
}

#[test]
fn files_that_are_no_text_of_a_robot() {
    for (text, fragment) in [("", "empty"), (" \n\n", "empty"), ("\u{feff}", "empty")] {
        assert!(only(text).to_string().contains(fragment));
    }
    let large = "#".repeat(robot_file::LARGEST + 1);
    assert!(only(&large).to_string().contains("larger than 1 MiB"));
    let said = robot_file::parse_bytes(b"name = \"a\"\nlength_mm = \xff").unwrap_err().to_string();
    assert!(said.contains("not UTF-8 text: line 2"), "{said}");
    let said = robot_file::read("no/such/robot.toml").unwrap_err().to_string();
    assert!(said.starts_with("no/such/robot.toml: the file cannot be read"), "{said}");
    assert!(robot_file::read(env!("CARGO_MANIFEST_DIR")).is_err(), "a folder is no robot");
    let said = problems("# only a comment").to_string();
    assert!(said.contains("name") && said.contains("length_mm") && said.contains("[[tube]]"), "{said}");
    let with_mark = format!("\u{feff}{}", R1.replace('\n', "\r\n"));
    assert!(robot_file::parse(&with_mark).is_ok(), "a byte order mark and Windows line ends are sound");
}

#[test]
fn ten_problems_are_ten_problems() {
    let text = "\
name = 4
length = 150
[material]
youngs_modulus_MPa = 5390
poissons_ratio = 0.6
density_kg_m3 = nan
[[tube]]
outer_radius_mm = 3.0
inner_radius_mm = 2.0
[tube.notches]
depth_mm = 6.5
tooht_mm = 5.0
length_mm = 5.0
torsion = \"polr\"
[[tube]]
outer_radius_mm = 2.5
inner_radius_mm = -0.5
[tube.notches]
depth_mm = 2.0
";
    let problems = problems(text);
    let lines: Vec<usize> = problems.list.iter().map(|p| p.line).collect();
    assert_eq!(lines, [1, 2, 4, 5, 6, 11, 12, 14, 17, 18], "{problems}");
    // The width of the second tube is not judged: its outline is not known.
    let text = text.replace("-0.5", "0.5");
    let problems = robot_file::parse(&text).unwrap_err();
    let lines: Vec<usize> = problems.list.iter().map(|p| p.line).collect();
    assert_eq!(lines, [1, 2, 4, 5, 6, 11, 12, 14, 16, 18], "{problems}");
}

fn distinct_keys(count: u32) -> String {
    (0..count).map(|i| format!("key{i} = 1")).collect::<Vec<_>>().join("\n") + "\n"
}

/// Files of the greatest length with as many offences as they can hold are refused in linear time.
#[test]
fn hostile_files_are_refused_quickly() {
    let fill = |piece: &str| piece.repeat(robot_file::LARGEST / piece.len());
    let keys = distinct_keys(60_000);
    for text in [
        fill("["),
        fill("a = [\n"),
        fill("= "),
        fill("a\n"),
        fill("a = 1\n"),
        fill("[a]\nb = 1\n"),
        fill("[[tube]]\n"),
        fill("a."),
        format!("x = {{{}", fill("a=1,").split_at(1_000_000).0),
        format!("tube = [{}]", fill("1,").split_at(1_000_000).0),
        keys,
    ] {
        let start = std::time::Instant::now();
        let found = problems(&text);
        assert!(found.to_string().len() < 50_000);
        // A second per file in an unoptimised build; quadratic time would take minutes.
        assert!(start.elapsed().as_secs() < 20, "{:?}: {:?}", start.elapsed(), &text[..20]);
    }
}

#[test]
fn long_lists_of_problems_and_long_lines_are_cut() {
    let keys = distinct_keys(200);
    let found = problems(&format!("{keys}{R1}"));
    assert_eq!((found.list.len(), found.omitted), (50, 150));
    assert!(found.to_string().ends_with("150 more problems are not listed."));
    let (text, _) = changed(R1, "depth_mm = 5.0", &format!("depth_mm = {:?}", vec![-1.0; 3000]));
    let found = problems(&text);
    assert!(found.list.iter().all(|p| p.to_string().chars().count() < 500), "{found}");
    assert!(found.list.iter().all(|p| {
        p.excerpt.as_ref().is_some_and(|e| e.text.chars().skip(e.start).take(4).collect::<String>() == "-1.0")
    }));
}

/// Carets are counted in columns of a terminal, of which some characters take two.
#[test]
fn carets_stand_below_wide_characters() {
    let (text, _) = changed(R1, "name = \"R1\"", "name = \"管\" + \"棒\"");
    let shown = problems(&text).to_string();
    let lines: Vec<&str> = shown.lines().collect();
    let quoted = lines.iter().position(|l| l.contains("管")).unwrap();
    // The sign after the string: two columns for one character before it.
    let before = lines[quoted].split(" + ").next().unwrap().chars().count() + 2;
    assert_eq!(lines[quoted + 1].find('^'), Some(before), "{shown}");
}
