//! Moduli, metal that softens and friction come back from exact forces and bends, and what these cannot tell apart is said.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive, TubeEffort};
use cppr::bundle::{Bundle, BundleDesign, Friction};
use cppr::clearance::Clearance;
use cppr::design::{CellFactors, CellRange, CellTable, Cut, Robot, TeethStiffness, TubeDesign};
use cppr::solve::{Command, Drive, Solver};
use cppr::statics::Loads;
use cppr_calibrate::{Design, Fit, FitProblem, Parameter, common_friction, fit, fitted_file, read};
use std::fmt::Write;

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// A wrist that softens from 0.8 % on; teeth that meet, and the finite elements of its cells, are left out.
fn wrist() -> String {
    text("wrists/wrist90")
        .replace("onset_strain_percent = 2.0", "onset_strain_percent = 0.8")
        .replace("teeth = \"cell\"\ncontact = true\n", "")
}

fn described(text: &str) -> Design {
    cppr_io::bundle_file::parse_either(text).unwrap().into()
}

fn truly(text: &str, truth: &[(&str, f64)]) -> Design {
    let mut design = described(text);
    for (name, value) in truth {
        Parameter::parse(name).unwrap().set(&mut design, *value);
    }
    design
}

fn bundle(design: &Design) -> BundleDesign {
    match design {
        Design::Robot(own) => own.into(),
        Design::Bundle(own) => own.clone(),
    }
}

fn bend(found: &BundleEquilibrium) -> f64 {
    found.frame[(0, 0)].acos().to_degrees()
}

fn fitted(text: &str, csv: &str, names: &[&str], friction: Option<f64>) -> Result<Fit, FitProblem> {
    let list: Vec<_> = names.iter().map(|name| Parameter::parse(name).unwrap()).collect();
    let friction = friction.map(|coefficient| Friction { coefficient, guide: None });
    fit(&[described(text)], &read(csv, 2).unwrap(), &list, friction, None)
}

fn recovers(text: &str, csv: &str, truth: &[(&str, f64)], within: f64) -> Fit {
    let names: Vec<&str> = truth.iter().map(|t| t.0).collect();
    let fit = fitted(text, csv, &names, None).unwrap_or_else(|problem| panic!("{names:?}: {problem}"));
    for (estimate, (name, want)) in fit.estimates.iter().zip(truth) {
        let miss = estimate.value / want - 1.0;
        assert!(miss.abs() < within, "{name} is {miss:.1e} of its value off");
        assert!((estimate.before / want - 1.0).abs() > 0.05 && !estimate.at_bound, "{name}");
    }
    fit
}

/// Tension of motors that pull, torque of motors that turn, and the pose of motors driven by force: all of the same robot.
#[test]
fn a_modulus_from_forces_of_a_plain_robot() {
    let truth = [("youngs_modulus", 4.6e9), ("shear_modulus", 1.5e9)];
    let Design::Robot(design) = truly(&text("r1"), &truth) else { panic!("a bundle") };
    let robot = Robot::from_design(design).unwrap();
    let mut solver = Solver::new(&robot);
    let mut csv = String::from(
        "pull2_mm,tension2_N,rotate2_deg,torque2_Nmm,measured_tension2_N,measured_torque2_Nmm,bend_deg,sigma_N,sigma_Nmm,sigma_deg\n",
    );
    let exact = "1e-4,1e-3,1e-3";
    for (pull, turn) in [(3.0, 0.0), (5.0, 60.0), (-4.0, 30.0)] {
        let mut command = Command::pull(&[pull * 1e-3]);
        command.actuators[0].rotation = Drive::Motion(f64::to_radians(turn));
        let found = solver.solve(&command).unwrap();
        let own = found.actuator(2).unwrap();
        let torque = own.torque * 1e3;
        writeln!(csv, "{pull},,{turn},,{},{torque},,{exact}", own.tension).unwrap();
    }
    for (force, torque) in [(3.0, 0.0), (4.0, 5.0)] {
        let mut command = Command::pull(&[0.0]);
        command.actuators[0].push_pull = Drive::Effort(force);
        command.actuators[0].rotation = Drive::Effort(torque * 1e-3);
        let found = solver.solve(&command).unwrap();
        let axis = found.tip().rotation.column(0).into_owned();
        writeln!(csv, ",{force},,{torque},,,{},{exact}", axis.x.acos().to_degrees()).unwrap();
    }
    let fit = recovers(&text("r1"), &csv, &truth, 1e-6);
    assert!(fit.rms.is_nan(), "no point was measured");
    let [tension, torque, bend] = &fit.misses[..] else { panic!("{:?}", fit.misses) };
    assert_eq!([tension, torque, bend].map(|own| own.what.to_string()), ["tension2", "torque2", "bend"]);
    assert!(tension.before > 0.1 && tension.fitted < 1e-6 * tension.before, "{tension:?}");
    assert!(bend.fitted < 1e-6 * bend.before && bend.measured > 0.3, "{bend:?}");
}

/// Bends of the wrist over the force of its tendon.
fn pulled(text: &str, truth: &[(&str, f64)], forces: &[f64]) -> String {
    let design = bundle(&truly(text, truth));
    let own = Bundle::new(&design).unwrap();
    let mut solver = BundleSolver::new(&own);
    let mut csv = String::from("tension2_N,bend_deg,sigma_deg\n");
    for force in forces {
        let mut command = solver.held();
        command.drives[1].translation = Drive::Effort(*force);
        let found = solver.solve(&command);
        assert!(found.converged && found.stable);
        writeln!(csv, "{force},{},1e-3", bend(&found)).unwrap();
    }
    csv
}

#[test]
fn metal_that_softens() {
    let truth = [("youngs_modulus", 36e9), ("onset_strain", 0.7e-2), ("second_modulus", 6e9)];
    let forces = [0.4, 0.8, 1.1, 1.2, 1.3, 1.4];
    let csv = pulled(&wrist(), &truth, &forces);
    let fit = recovers(&wrist(), &csv, &truth, 1e-4);
    let file = fitted_file(&wrist(), &fit.estimates, None).unwrap();
    assert!(
        file.contains("onset_strain_percent = 0.7") && file.contains("second_modulus_GPa = 6.0"),
        "{file}"
    );
    for (name, want) in truth {
        let got = Parameter::parse(name).unwrap().present(&[described(&file)]);
        assert!((got / want - 1.0).abs() < 2e-4, "{name}: {got}");
    }
    // Compression and unloading keep their ratios, in the design as in the file.
    let more = "[material]\nunloading_onset_strain_percent = 0.3\ncompression_onset_strain_percent = 1.2";
    let other = wrist().replace("[material]", more);
    let file = fitted_file(&other, &fit.estimates, None).unwrap();
    let changed = truly(&other, &[("onset_strain", fit.estimates[1].value)]);
    let onsets = |design: &Design| {
        let Design::Bundle(own) = design else { panic!("a robot") };
        let cppr::design::TubeDesign::Notched(tube) = &own.tubes[0].parts[0].body else {
            panic!("no notches")
        };
        let own = tube.material.softening.unwrap();
        [own.tension.onset, own.compression.onset, own.tension.unloading_onset.unwrap()]
    };
    for design in [changed, described(&file)] {
        let [tension, compression, unloading] = onsets(&design);
        assert!((unloading / tension - 0.375).abs() < 1e-6);
        assert!((compression / tension - 1.5).abs() < 1e-6 && (tension / 0.7e-2 - 1.0).abs() < 1e-3);
    }
}

#[test]
fn an_onset_that_no_strain_reaches_is_refused_with_the_strain() {
    let csv = pulled(&wrist(), &[], &[0.02, 0.04, 0.06, 0.08]);
    let problem = fitted(&wrist(), &csv, &["youngs_modulus", "onset_strain"], None).unwrap_err();
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    assert_eq!(combination[0].0.to_string(), "onset_strain");
    let told = problem.to_string();
    assert!(told.contains("The greatest strain in any pose") && told.contains("from 0.800 % on"), "{told}");
    let problem = fitted(&text("r1"), "x_mm,y_mm\n150,0\n", &["onset_strain"], None).unwrap_err();
    assert!(problem.to_string().contains("write onset_strain_percent and second_modulus_GPa"), "{problem}");
}

/// Metal that does not soften: its second modulus ends at the first.
#[test]
fn a_fit_that_ends_at_a_bound_says_so() {
    let linear = [("second_modulus", 40e9)];
    let mut csv = pulled(&wrist(), &linear, &[0.9, 1.0, 1.1]);
    // Stiffening, which no softening metal shows.
    csv = csv.replace("sigma_deg\n", "sigma_deg\n1.05,62.0,1e-3\n");
    let fit = fitted(&wrist(), &csv, &["second_modulus"], None).unwrap();
    let own = &fit.estimates[0];
    assert!(own.at_bound && (own.value / 40e9 - 1.0).abs() < 1e-9, "{own:?}");
}

/// A measured wrist whose cells are as if they had been computed: teeth of which 0.2 mm bend.
fn with_cells(name: &str) -> Design {
    let mut design = described(&text(name).replace("teeth = \"cell\"\ncontact = true\n", ""));
    let Design::Bundle(own) = &mut design else { panic!("a robot") };
    let part = own.tubes[0].parts.last_mut().unwrap();
    let TubeDesign::Notched(tube) = &mut part.body else { panic!("no notches") };
    let pattern = tube.pattern.unwrap();
    let share = pattern.pitch() / (pattern.length + 0.2e-3);
    let factors = CellFactors {
        centroid_offset: 1.0,
        bending_y: share,
        bending_z: share,
        torsion: share,
        axial: share,
        mass: 1.0,
        peak: None,
    };
    tube.teeth = TeethStiffness::Cells(CellTable {
        outline: tube.outline.clone(),
        notch: pattern.length,
        tooth: pattern.tooth,
        cut: Cut::Plane,
        corner_radius: None,
        poissons_ratio: tube.material.poissons_ratio,
        tooth_factor: 1.0,
        ranges: vec![CellRange { nodes: vec![(1.4e-3, factors)] }],
    });
    design
}

/// Wrists whose notches differ in length tell what teeth bend from the modulus; one alone does not.
#[test]
fn a_factor_on_teeth() {
    let truth = [("youngs_modulus", 46e9), ("tooth_factor", 1.4)];
    let list = truth.map(|(name, _)| Parameter::parse(name).unwrap());
    let designs = ["wrists/wrist150", "wrists/wrist90"].map(with_cells);
    let mut csv = String::from("robot,tension2_N,bend_deg,sigma_deg\n");
    for design in &designs {
        let mut own = design.clone();
        list.iter().zip(truth).for_each(|(parameter, (_, value))| parameter.set(&mut own, value));
        let bundle = Bundle::new(&bundle(&own)).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        for force in [0.1, 0.2, 0.3] {
            let mut command = solver.held();
            command.drives[1].translation = Drive::Effort(force);
            writeln!(csv, "{},{force},{},1e-3", design.name(), bend(&solver.solve(&command))).unwrap();
        }
    }
    let found = fit(&designs, &read(&csv, 2).unwrap(), &list, None, None).unwrap();
    for (own, (name, want)) in found.estimates.iter().zip(truth) {
        assert!((own.value / want - 1.0).abs() < 1e-4 && !own.at_bound, "{name}: {own:?}");
        assert!((own.before / want - 1.0).abs() > 0.1, "{name}");
    }
    let file = fitted_file(&text("wrists/wrist90"), &found.estimates, None).unwrap();
    assert!(file.contains("tooth_factor = 1.4"), "{file}");
    let one: String = csv
        .lines()
        .filter(|row| !row.starts_with("Wrist 90"))
        .fold(String::new(), |all, row| all + row + "\n");
    let rows = read(&one.replace("1e-3", "1"), 2).unwrap();
    let problem = fit(&designs[..1], &rows, &list, None, None).unwrap_err();
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    assert!(combination.iter().any(|(own, _)| own.to_string() == "tooth_factor"), "{problem}");
    assert!(problem.to_string().contains("differ in length tell them apart"), "{problem}");

    // Teeth that are not computed, and cuts that the factor is not for.
    let problem = fitted(&wrist(), &csv, &["tooth_factor"], None).unwrap_err().to_string();
    assert!(problem.contains("no tube of Wrist 90 has teeth = \"cell\""), "{problem}");
    let mut radial = designs[0].clone();
    if let Design::Bundle(own) = &mut radial
        && let TubeDesign::Notched(tube) = &mut own.tubes[0].parts[1].body
        && let TeethStiffness::Cells(table) = &mut tube.teeth
    {
        table.cut = Cut::Radial;
    }
    let problem = fit(&[radial], &rows, &list[1..], None, None).unwrap_err().to_string();
    assert!(problem.contains("tube 1 of Wrist 150 are cut radially"), "{problem}");
}

/// Tips and tensions of R1 with a gap (m) between its tubes, unloaded and under a force.
fn loose(truth: &[(&str, f64)], gap: f64, sigma: f64) -> String {
    let Design::Robot(design) = truly(&text("r1"), truth) else { panic!("a bundle") };
    let robot = Robot::from_design(design).unwrap();
    let mut solver = Solver::new(&robot);
    let clearance = Clearance { gaps: vec![gap], guide: None, elements: 60 };
    let mut csv = String::from(
        "pull2_mm,tip_force_y_N,x_mm,y_mm,bend_deg,measured_tension2_N,sigma_mm,sigma_deg,sigma_N\n",
    );
    for (pull, force) in [(6.0, 0.0), (4.0, -0.15)] {
        let loads = Loads::tip_force(Vector3::new(0.0, force, 0.0));
        let tight = solver.solve(&Command::pull(&[pull * 1e-3]).with_loads(loads)).unwrap();
        let found = solver.with_clearance(&tight, &clearance).unwrap().unwrap();
        let (tip, bend) = (found.tip() * 1e3, found.bend().to_degrees().abs());
        let tension = found.followers[0].tension;
        writeln!(csv, "{pull},{force},{},{},{bend},{tension},{sigma},{sigma},{sigma}", tip.x, tip.y).unwrap();
    }
    csv
}

#[test]
fn a_gap_between_tubes() {
    let truth = [("youngs_modulus", 4.8e9), ("gap", 0.32e-3)];
    let csv = loose(&truth[..1], 0.32e-3, 1e-3);
    let fit = recovers(&text("r1"), &csv, &truth, 1e-4);
    assert!((fit.estimates[1].before / 0.5e-3 - 1.0).abs() < 1e-9, "the radii leave 0.5 mm");
    assert!(fit.estimates[1].interval < 1e-6, "{:?}", fit.estimates);
    let file = fitted_file(&text("r1"), &fit.estimates, None).unwrap();
    assert!(file.contains("youngs_modulus_GPa = 4.8") && !file.contains("gap"), "{file}");
    // A longer lever does much the same to what was measured as coarsely as this.
    let coarse = loose(&truth[..1], 0.32e-3, 10.0);
    let problem = fitted(&text("r1"), &coarse, &["centroid_offset_factor", "gap"], None).unwrap_err();
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    assert!(combination.iter().any(|(own, _)| own.to_string() == "gap"), "{problem}");
    assert!(problem.to_string().contains("of gap by 0.1 mm"), "{problem}");
    assert!(problem.to_string().contains("fit no centroid_offset_factor beside it"), "{problem}");

    // What the model with gaps does not see is named.
    for (csv, names, said) in [
        (
            "pull2_mm,line,x_mm\n2,tube2,140\n2,,140\n",
            &["gap"][..],
            "line 2: points on the centroid line of tube 2",
        ),
        ("pull2_mm,x_mm\n2,140\n", &["gap@2"], "nothing lies inside tube 2 of R1"),
        ("pull2_mm,driven,x_mm\n2,on,140\n", &["gap", "friction"], "fit gap without it"),
    ] {
        let problem = fitted(&text("r1"), csv, names, None).unwrap_err().to_string();
        assert!(problem.contains(said), "{problem}");
    }
    let problem = fitted(&wrist(), &csv, &["gap"], None).unwrap_err().to_string();
    assert!(problem.contains("Wrist 90 has parts or joints"), "{problem}");
}

/// Tension and tip of R1 with tubes that rub, by motors driven on and back.
fn rubbed(truth: &[(&str, f64)], coefficient: f64, ways: &[&str], sigma: f64) -> String {
    let own = Bundle::new(&bundle(&truly(&text("r1"), truth))).unwrap();
    let mut solver = BundleSolver::new(&own);
    let mut csv = String::from("pull2_mm,driven,measured_tension2_N,sigma_N\n");
    for pull in [2.0, 4.0, 6.0] {
        let mut drives = vec![TubeDrive::HELD; 2];
        drives[1].translation = Drive::Motion(pull * 1e-3);
        let found = solver.solve(&BundleCommand { drives, ..solver.held() });
        let sides = solver.full_slip(&found, &Friction { coefficient, guide: None }).unwrap();
        for (way, side) in ["on", "back"].into_iter().zip(sides) {
            let TubeEffort { force, .. } = side.efforts[1];
            if ways.contains(&way) {
                writeln!(csv, "{pull},{way},{force},{sigma}").unwrap();
            }
        }
    }
    csv
}

#[test]
fn friction_from_motors_driven_on_and_back() {
    let truth = [("youngs_modulus", 4.6e9), ("friction", 0.23)];
    let csv = rubbed(&truth, 0.23, &["on", "back"], 1e-4);
    let fit = recovers(&text("r1"), &csv, &truth, 1e-4);
    assert!(fit.estimates[1].interval < 1e-3, "{:?}", fit.estimates);
    assert!(matches!(fit.designs[0], Design::Robot(_)), "the robot stays what it was");
    let file = fitted_file(&text("r1"), &fit.estimates, Some(0.02)).unwrap();
    let rubs = cppr_io::robot_file::parse(&file).unwrap().friction.unwrap();
    assert!((rubs.coefficient / 0.23 - 1.0).abs() < 1e-4 && rubs.guide == Some(0.02), "{file}");
    let again = fitted_file(&file, &fit.estimates, None).unwrap();
    assert_eq!(
        cppr_io::robot_file::parse(&again).unwrap().friction,
        Some(rubs),
        "another fit keeps the guide"
    );
    assert_eq!(common_friction(&[Some(rubs), Some(rubs)]), Ok(Some(rubs)));
    let other = common_friction(&[Some(rubs), None]).unwrap_err();
    assert!(other.to_string().contains("rub differently"), "{other}");
    // A known coefficient holds where it is not fitted; another gives another modulus on one side.
    let on = rubbed(&truth, 0.23, &["on"], 1e-4);
    let modulus = |friction: Option<f64>| fitted(&text("r1"), &on, &["youngs_modulus"], friction).unwrap();
    assert!((modulus(Some(0.23)).estimates[0].value / 4.6e9 - 1.0).abs() < 1e-4);
    assert!(modulus(None).estimates[0].value > 1.05 * 4.6e9);
    // Nothing fitted: the robots as they are.
    let none = fitted(&text("r1"), &csv, &[], Some(0.23)).unwrap();
    assert!(none.estimates.is_empty() && none.misses[0].fitted > 0.1, "{:?}", none.misses);
}

/// Normal noise by Box and Muller.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut uniform = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (-2.0 * uniform().max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

/// A table of tensions with noise of the deviation that it states in its last column.
fn noisy(csv: &str, seed: u64) -> String {
    let mut noise = noise(seed);
    let mut rows = csv.lines();
    let mut table = format!("{}\n", rows.next().unwrap());
    for row in rows {
        let (before, sigma) = row.rsplit_once(',').unwrap();
        let (before, force) = before.rsplit_once(',').unwrap();
        let [force, deviation] = [force, sigma].map(|text| text.parse::<f64>().unwrap());
        writeln!(table, "{before},{},{sigma}", force + deviation * noise()).unwrap();
    }
    table
}

#[test]
fn noisy_forces_give_modulus_and_friction_within_the_stated_intervals() {
    let csv = rubbed(&[("youngs_modulus", 4.6e9)], 0.23, &["on", "back"], 0.03);
    let seeds = 6;
    let mut inside = [0; 2];
    for seed in 1..=seeds {
        let fit = fitted(&text("r1"), &noisy(&csv, seed), &["youngs_modulus", "friction"], None).unwrap();
        for (i, (own, want)) in fit.estimates.iter().zip([4.6e9, 0.23]).enumerate() {
            inside[i] += usize::from((own.value - want).abs() < own.interval);
            assert!((1e-4..0.5).contains(&(own.interval / want)), "{own:?}");
        }
    }
    // Of 6 intervals at 95 % fewer than 4 hold the truth once in 450 times.
    assert!(inside.iter().all(|&n| n >= 4), "{inside:?} of {seeds}");
}

#[test]
fn friction_of_motors_driven_one_way_is_refused_by_name() {
    let csv = rubbed(&[("youngs_modulus", 4.6e9)], 0.23, &["on"], 0.6);
    let problem = fitted(&text("r1"), &csv, &["youngs_modulus", "friction"], None).unwrap_err();
    let both = rubbed(&[("youngs_modulus", 4.6e9)], 0.23, &["on", "back"], 0.6);
    assert!(fitted(&text("r1"), &both, &["youngs_modulus", "friction"], None).is_ok());
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    let names: Vec<String> = combination.iter().map(|(parameter, _)| parameter.to_string()).collect();
    assert!(names.len() == 2 && names.contains(&"friction".into()), "{problem}");
    assert!(problem.to_string().contains("driven back as well"), "{problem}");
    let blind = csv.replace(",on,", ",,");
    let problem = fitted(&text("r1"), &blind, &["friction"], None).unwrap_err().to_string();
    assert!(problem.starts_with("line 2: ") && problem.contains("column driven"), "{problem}");
    let problem = Parameter::parse("friction@2").unwrap_err().to_string();
    assert!(problem.contains("one for all tubes"), "{problem}");
}

/// Loops that run the wrong way: no coefficient is below zero.
#[test]
fn friction_ends_at_nothing_where_the_loop_runs_the_wrong_way() {
    let csv = rubbed(&[], 0.1, &["on", "back"], 1e-2).replace("on,", "swap,").replace("back,", "on,");
    let csv = csv.replace("swap,", "back,");
    let fit = fitted(&text("r1"), &csv, &["youngs_modulus", "friction"], None).unwrap();
    let own = &fit.estimates[1];
    assert!(own.at_bound && own.value.abs() < 1e-12, "{own:?}");
    assert!(!fit.estimates[0].at_bound && fit.estimates[0].value > 0.0);
}

/// Without friction, forces and bends of the integrated robot are those of its modes, and places are told by the leader's label.
#[test]
fn places_on_a_robot_that_rubs_are_labels_too() {
    let robot = Robot::from_design(match described(&text("r1")) {
        Design::Robot(own) => own,
        Design::Bundle(_) => panic!("a bundle"),
    })
    .unwrap();
    let mut solver = Solver::new(&robot);
    let found = solver.solve(&Command::pull(&[5e-3])).unwrap();
    let mut csv = String::from("pull2_mm,driven,at_mm,line,x_mm,y_mm,z_mm\n");
    for at in [50.0, 110.0] {
        let shape = solver.shape_at(&found, &[at * 1e-3]);
        let section = &shape.sections[0];
        for (line, point) in [("centre", section.centre), ("tube2", section.tubes[1].centroid)] {
            let p = point * 1e3;
            writeln!(csv, "5,on,{at},{line},{},{},{}", p.x, p.y, p.z).unwrap();
        }
    }
    let fit = fitted(&text("r1"), &csv, &[], Some(0.0)).unwrap();
    assert!(fit.rms < 2e-5, "{}", fit.rms);
}

#[test]
fn wrong_efforts_and_bends_are_refused_line_by_line() {
    for (csv, said) in [
        ("pull2_mm,tension2_N,x_mm\n1,2,3\n", "line 2: tension2_N: the pull of tube 2 is given as well"),
        ("driven,x_mm\nforth,1\n", "line 2: driven is on or back, not forth"),
        ("bend_deg\n190\n", "line 2: bend_deg: 190 is not between 0 and 180"),
        ("bend_deg,sigma_N\n10,0\n", "line 2: sigma_N: 0 is not positive"),
        ("measured_torque3_Nmm\n1\n", "measured_torque3_Nmm: the robots have tubes 1 to 2"),
        ("measured_pull2_mm,x_mm\n1,2\n", "there is no column measured_pull2_mm"),
    ] {
        let problems: Vec<String> = read(csv, 2).unwrap_err().iter().map(ToString::to_string).collect();
        assert!(problems.len() == 1 && problems[0].contains(said), "{csv}: {problems:?}");
    }
    for (csv, said) in [
        ("measured_tension1_N\n1\n2\n", "line 2: tube 1 of R1 stands still"),
        ("tension2_N,bend_deg\n1,20\n1e4,30\n", "line 3: "),
    ] {
        let problem = fitted(&text("r1"), csv, &["youngs_modulus"], None).unwrap_err().to_string();
        assert!(problem.contains(said), "{csv}: {problem}");
    }
}
