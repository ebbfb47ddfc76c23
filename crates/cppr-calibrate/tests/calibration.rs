//! Known parameters are recovered from noisy synthetic data, within the intervals stated.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::Vector3;
use cppr::design::Robot;
use cppr::solve::{Command, Solver};
use cppr::statics::Loads;
use cppr_calibrate::{Design, Fit, FitProblem, Measurement, Parameter, fit, fitted_file, read};
use std::fmt::Write;

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn design(name: &str) -> Design {
    cppr_io::bundle_file::parse_either(&text(name)).unwrap().into()
}

fn robot(design: Design) -> Robot {
    let Design::Robot(design) = design else { panic!("{} is a bundle", design.name()) };
    Robot::from_design(design).unwrap()
}

struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal, by Box and Muller.
    fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

fn set(design: &mut Design, names: &[(&str, f64)]) {
    for (name, value) in names {
        Parameter::parse(name).unwrap().set(design, *value);
    }
}

/// Tips of robots with the true values, as a CSV file.
fn data(
    robots: &[&str],
    truth: &[(&str, f64)],
    loads: &[f64],
    turns: &[f64],
    noise_mm: f64,
    seed: u64,
) -> String {
    let mut noise = Noise(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut csv =
        String::from("robot,pull2_mm,rotate2_deg,tip_force_y_N,tip_force_z_N,x_mm,y_mm,z_mm,sigma_mm\n");
    for name in robots {
        let mut design = design(name);
        set(&mut design, truth);
        let robot = robot(design);
        let mut solver = Solver::new(&robot);
        for pull in [-6.0, -3.0, 0.0, 3.0, 6.0] {
            for &load in loads {
                for &turn in turns {
                    let mut command = Command::pull(&[pull * 1e-3])
                        .with_loads(Loads::tip_force(Vector3::new(0.0, load, 0.5 * load)));
                    command.actuators[0].rotation = cppr::solve::Drive::Motion(f64::to_radians(turn));
                    let found = solver.solve(&command).unwrap();
                    let tip = solver.tip(&found).centre * 1e3;
                    let mut seen = || noise_mm * noise.next();
                    let (x, y, z) = (tip.x + seen(), tip.y + seen(), tip.z + seen());
                    let half = 0.5 * load;
                    writeln!(
                        csv,
                        "{},{pull},{turn},{load},{half},{x},{y},{z},{}",
                        robot.design().name,
                        noise_mm.max(1e-3)
                    )
                    .unwrap();
                }
            }
        }
    }
    csv
}

fn parameters(names: &[&str]) -> Vec<Parameter> {
    names.iter().map(|n| Parameter::parse(n).unwrap()).collect()
}

fn fitted(robots: &[&str], csv: &str, names: &[&str]) -> Result<Fit, FitProblem> {
    let designs: Vec<Design> = robots.iter().map(|r| design(r)).collect();
    let rows: Vec<Measurement> = read(csv, 2).unwrap();
    fit(&designs, &rows, &parameters(names), None, None)
}

#[test]
fn exact_data_give_the_exact_values() {
    let truth = [("centroid_offset_factor", 1.21), ("youngs_modulus", 4.6e9)];
    let csv = data(&["r1", "r2"], &truth, &[0.0, 0.15], &[0.0], 0.0, 1);
    let fit = fitted(&["r1", "r2"], &csv, &["centroid_offset_factor", "youngs_modulus"]).unwrap();
    for (estimate, (name, want)) in fit.estimates.iter().zip(truth) {
        assert!((estimate.value / want - 1.0).abs() < 1e-6, "{name}: {} {want}", estimate.value);
    }
    assert!(fit.rms < 1e-8 && fit.rms_before > 1e-3, "{} {}", fit.rms, fit.rms_before);
    assert!(fit.residuals.iter().all(|r| r.value.abs() < 1e-8));
}

#[test]
fn a_far_start_finds_the_same_values() {
    let truth = [("centroid_offset_factor", 1.21), ("youngs_modulus", 4.6e9)];
    let csv = data(&["r1"], &truth, &[0.0, 0.15], &[0.0], 0.0, 1);
    let names = truth.map(|t| t.0);
    let rows = read(&csv, 2).unwrap();
    for start in [[3.0, 5e10], [0.8, 2e9]] {
        let mut far = design("r1");
        set(&mut far, &[(names[0], start[0]), (names[1], start[1])]);
        let fit = fit(&[far], &rows, &parameters(&names), None, None).unwrap();
        for (estimate, (name, want)) in fit.estimates.iter().zip(truth) {
            assert!((estimate.value / want - 1.0).abs() < 1e-6, "{name}: {} {want}", estimate.value);
        }
    }
}

#[test]
fn noisy_data_give_the_values_within_the_stated_intervals() {
    let truth = [("centroid_offset_factor", 1.21), ("youngs_modulus", 4.6e9)];
    let seeds = 16;
    let mut inside = [0; 2];
    for seed in 1..=seeds {
        let csv = data(&["r1", "r2"], &truth, &[0.0, 0.15], &[0.0], 0.5, seed);
        let fit = fitted(&["r1", "r2"], &csv, &["centroid_offset_factor", "youngs_modulus"]).unwrap();
        assert!((0.7..1.3).contains(&fit.scale), "the noise is 0.5 mm as stated: {}", fit.scale);
        for (i, (estimate, (_, want))) in fit.estimates.iter().zip(truth).enumerate() {
            inside[i] += usize::from((estimate.value - want).abs() < estimate.interval);
            assert!(estimate.interval < 0.05 * want, "the interval says nothing");
            assert!(estimate.interval > 1e-5 * want, "the interval is too good to be true");
        }
    }
    // Of 16 intervals at 95 % fewer than 12 hold the truth once in 3000 times.
    assert!(inside.iter().all(|&n| n >= 12), "{inside:?} of {seeds}");
}

#[test]
fn shear_moduli_and_offsets_of_single_tubes() {
    let truth = [("shear_modulus@1", 1.4e9), ("shear_modulus@2", 2.3e9), ("centroid_offset_factor@2", 1.35)];
    let names = truth.map(|t| t.0);
    let csv = data(&["r1"], &truth, &[0.0, 0.1], &[-60.0, 0.0, 90.0], 0.0, 3);
    let fit = fitted(&["r1"], &csv, &names).unwrap();
    for (estimate, (name, want)) in fit.estimates.iter().zip(truth) {
        assert!((estimate.value / want - 1.0).abs() < 1e-5, "{name}: {} {want}", estimate.value);
    }
}

/// Points along the centroid line of the follower and the centreline, with directions or without coordinates.
#[test]
fn shapes_and_directions_give_the_values_too() {
    let truth = [("centroid_offset_factor", 1.21), ("youngs_modulus@1", 4.6e9), ("shear_modulus@2", 1.7e9)];
    let mut truly = design("r1");
    set(&mut truly, &truth);
    let robot = robot(truly);
    let mut solver = Solver::new(&robot);
    let head = "pull2_mm,rotate2_deg,tip_force_y_N,tip_force_z_N,at_mm,line,x_mm,y_mm,z_mm,\
                direction_x,direction_y,direction_z,sigma_mm,sigma_deg\n";
    let (mut shapes, mut directions) = (String::from(head), String::from(head));
    for (pull, turn, load) in [(-5.0, 0.0, 0.1), (-2.0, 80.0, 0.0), (3.0, -60.0, 0.15), (6.0, 40.0, -0.1)] {
        let loads = Loads::tip_force(Vector3::new(0.0, load, load));
        let mut command = Command::pull(&[pull * 1e-3]).with_loads(loads);
        command.actuators[0].rotation = cppr::solve::Drive::Motion(f64::to_radians(turn));
        let found = solver.solve(&command).unwrap();
        for at in [40.0, 90.0, 150.0] {
            let shape = solver.shape_at(&found, &[at * 1e-3]);
            let section = &shape.sections[0];
            let (point, axis) = (section.tubes[1].centroid * 1e3, section.rotation.column(0));
            let given = format!("{pull},{turn},{load},{load},{at}");
            writeln!(shapes, "{given},tube2,{},{},{},,,,1e-3,", point.x, point.y, point.z).unwrap();
            writeln!(directions, "{given},centre,,,,{},{},{},,1e-3", axis.x, axis.y, axis.z).unwrap();
        }
    }
    for csv in [shapes, directions] {
        let fit = fitted(&["r1"], &csv, &truth.map(|t| t.0)).unwrap();
        for (estimate, (name, want)) in fit.estimates.iter().zip(truth) {
            assert!((estimate.value / want - 1.0).abs() < 1e-5, "{name}: {} {want}", estimate.value);
        }
    }
}

#[test]
fn what_the_data_cannot_see_is_refused_with_the_reason() {
    let truth = [("centroid_offset_factor", 1.21)];
    let unloaded = data(&["r1", "r2"], &truth, &[0.0], &[0.0], 0.3, 5);
    // Remark 19: the modulus changes forces, not shapes.
    let problem =
        fitted(&["r1", "r2"], &unloaded, &["centroid_offset_factor", "youngs_modulus"]).unwrap_err();
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    assert_eq!(combination[0].0.to_string(), "youngs_modulus");
    assert!(combination[0].1.abs() > 0.99 && problem.to_string().contains("Remark 19"), "{problem}");
    // Both offsets of one pair enter as their sum.
    let problem =
        fitted(&["r1"], &unloaded_of_one(), &["centroid_offset_factor@1", "centroid_offset_factor@2"])
            .unwrap_err();
    let FitProblem::Invisible { combination, .. } = &problem else { panic!("{problem}") };
    assert!(combination[0].1 * combination[1].1 < 0.0, "one grows as the other shrinks: {problem}");
    // What can be seen still is.
    let fit = fitted(&["r1", "r2"], &unloaded, &["centroid_offset_factor"]).unwrap();
    assert!((fit.estimates[0].value - 1.21).abs() < 0.02);
}

/// Directions of the tip only: they turn by Δa over the sum of the offsets.
fn unloaded_of_one() -> String {
    let mut csv = String::from("pull2_mm,direction_x,direction_y,direction_z,sigma_deg\n");
    let robot = robot(design("r1"));
    let sum: f64 = (0..2).map(|t| robot.fields_at(t, 0.0).centroid_offset).sum();
    for (i, pull) in [1.0, 2.0, 4.0, 5.0, 6.0].into_iter().enumerate() {
        let angle: f64 = -pull * 1e-3 / sum + 1e-3 * (f64::from(u8::try_from(i).unwrap()) - 2.0);
        writeln!(csv, "{pull},{},{},0,0.5", angle.cos(), angle.sin()).unwrap();
    }
    csv
}

#[test]
fn an_outlier_is_named() {
    let truth = [("centroid_offset_factor", 1.21)];
    let csv = data(&["r1", "r2"], &truth, &[0.0], &[0.0], 0.2, 9);
    let mut lines: Vec<String> = csv.lines().map(String::from).collect();
    // The motor stalled: line 4 was measured at another motion.
    lines[3] = lines[3].replacen(",0,0,", ",1.5,0,", 1);
    assert_ne!(lines[3], csv.lines().nth(3).unwrap());
    let fit = fitted(&["r1", "r2"], &lines.join("\n"), &["centroid_offset_factor"]).unwrap();
    let outliers: Vec<usize> = fit.residuals.iter().filter(|r| r.outlier).map(|r| r.row).collect();
    assert!(!outliers.is_empty() && outliers.iter().all(|row| *row == 4), "{outliers:?}");
    let clean = fitted(&["r1", "r2"], &csv, &["centroid_offset_factor"]).unwrap();
    assert!(clean.residuals.iter().all(|r| !r.outlier));
}

#[test]
fn fitted_values_go_into_the_file_and_nothing_else_changes() {
    let truth = [("centroid_offset_factor", 1.21), ("youngs_modulus", 4.6e9)];
    let csv = data(&["r1"], &truth, &[0.0, 0.15], &[0.0], 0.0, 1);
    let fit = fitted(&["r1"], &csv, &["centroid_offset_factor", "youngs_modulus"]).unwrap();
    let before = text("r1");
    let after = fitted_file(&before, &fit.estimates, None).unwrap();
    let changed: Vec<(&str, &str)> = before.lines().zip(after.lines()).filter(|(a, b)| a != b).collect();
    assert_eq!(before.lines().count(), after.lines().count());
    assert_eq!(changed.len(), 2, "{changed:?}");
    let again = Design::from(cppr_io::bundle_file::parse_either(&after).unwrap());
    assert!(
        (Parameter::parse("youngs_modulus").unwrap().present(std::slice::from_ref(&again)) / 4.6e9 - 1.0)
            .abs()
            < 1e-6
    );
    assert!(
        (Parameter::parse("centroid_offset_factor").unwrap().present(&[again]) / 1.21 - 1.0).abs() < 1e-6
    );
    // A shear modulus takes the place of Poisson's ratio, a factor of one tube gets a line of its own.
    let list = [("shear_modulus", 1.5e9), ("centroid_offset_factor@2", 1.4)];
    let estimates: Vec<_> = list
        .iter()
        .map(|(name, value)| {
            let mut estimate = fit.estimates[0].clone();
            (estimate.parameter, estimate.value) = (Parameter::parse(name).unwrap(), *value);
            estimate
        })
        .collect();
    let design = Design::from(
        cppr_io::bundle_file::parse_either(&fitted_file(&before, &estimates, None).unwrap()).unwrap(),
    );
    for (name, value) in list {
        let got = Parameter::parse(name).unwrap().present(std::slice::from_ref(&design));
        assert!((got / value - 1.0).abs() < 1e-6, "{name}: {got}");
    }
}

#[test]
fn wrong_files_are_refused_line_by_line() {
    let problems =
        |csv: &str| read(csv, 2).unwrap_err().iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(problems("").contains("nothing is measured"));
    assert!(problems("pull2_mm,x_mm\n").contains("no measurements"));
    assert!(problems("pull_mm,x_mm\n1,2\n").contains("there is no column pull_mm"));
    assert!(problems("pull3_mm,x_mm\n1,2\n").contains("tubes 1 to 2"));
    let both = problems("pull2_mm,x_mm,line\n1,nan,centre\n1,2,tube0\n1,,centre\n1,2\n");
    for part in ["line 2: x_mm: nan", "line 3: line is centre or", "line 4: nothing is measured", "line 5"] {
        assert!(both.contains(part), "{part} is missing in\n{both}");
    }
    assert!(problems("x_mm\n1e308\n").contains("more than any robot meets"));
    assert!(problems("x_mm,sigma_mm\n1,0\n").contains("not positive"));
    assert!(problems("direction_x,direction_y\n1,0\n").contains("all three"));
    let fails = |csv: &str, robots: &[&str], names: &[&str], part: &str| {
        let problem = fitted(robots, csv, names).unwrap_err().to_string();
        assert!(problem.contains(part), "{problem}");
    };
    let one = ["centroid_offset_factor"];
    fails("robot,x_mm\nR9,1\n", &["r1"], &one, "there is no robot R9; there are R1");
    fails("x_mm\n1\n", &["r1", "r2"], &one, "the column robot is needed");
    fails("x_mm\n150\n", &["r1"], &one, "cannot determine 1 parameters");
    fails("pull1_mm,x_mm\n1,150\n", &["r1"], &one, "stands still");
    fails("x_mm,y_mm\n150,0\n", &["r1"], &["rest_curvature_factor"], "straight when free");
    fails("at_mm,x_mm,y_mm\n200,1,1\n", &["r1"], &one, "reaches from 0 to 150 mm");
    fails("x_mm,y_mm\n150,0\n", &["childs2"], &["youngs_modulus"], "has no modulus to fit");
    fails("x_mm,y_mm\n150,0\n", &["r1"], &["shear_modulus@3"], "tubes 1 to 2, not 3");
    fails("x_mm,y_mm\n150,0\n", &["r1"], &["youngs_modulus", "youngs_modulus@1"], "twice");
    assert!(Parameter::parse("density").unwrap_err().to_string().contains("cannot be fitted"));
}
