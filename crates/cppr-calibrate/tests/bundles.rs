//! Parameters of the shipped robots of parts and joints are recovered from exact synthetic data, and written back so that the file means them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::solve::Drive;
use cppr::statics::Loads;
use cppr::{Matrix3, Vector3};
use cppr_calibrate::{Design, Fit, FitProblem, Parameter, fit, fitted_file, read};
use std::fmt::Write;

type Pose<'a> = (&'a [(usize, f64, f64)], [f64; 3]);

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/../../robots/bundles/{name}.toml", env!("CARGO_MANIFEST_DIR")))
        .unwrap()
}

fn changed(name: &str, truth: &[(&str, f64)]) -> BundleDesign {
    let mut design = Design::from(cppr_io::bundle_file::parse(&text(name)).unwrap());
    for (parameter, value) in truth {
        Parameter::parse(parameter).unwrap().set(&mut design, *value);
    }
    let Design::Bundle(design) = design else { panic!("{name} is no bundle") };
    design
}

/// Equilibria of the true robot under motions (tube, mm, degrees) and forces (N), written by `see` into rows behind the command.
fn table(
    name: &str,
    truth: &[(&str, f64)],
    poses: &[Pose<'_>],
    head: &str,
    see: impl Fn(&BundleSolver<'_>, &BundleEquilibrium) -> Vec<String>,
) -> String {
    let design = changed(name, truth);
    let bundle = Bundle::new(&design).unwrap();
    let mut solver = BundleSolver::new(&bundle);
    let tubes = design.tubes.len();
    let mut csv = String::new();
    for k in 1..=tubes {
        write!(csv, "pull{k}_mm,rotate{k}_deg,").unwrap();
    }
    writeln!(csv, "tip_force_x_N,tip_force_y_N,tip_force_z_N,sigma_mm,sigma_deg,{head}").unwrap();
    for (motions, force) in poses {
        let mut drives = vec![TubeDrive::HELD; tubes];
        let mut told = vec![[0.0; 2]; tubes];
        for &(tube, pull, turn) in *motions {
            told[tube - 1] = [pull, turn];
            drives[tube - 1] = TubeDrive {
                translation: Drive::Motion(pull * 1e-3),
                rotation: Drive::Motion(f64::to_radians(turn)),
            };
        }
        let command = BundleCommand { drives, loads: Loads::tip_force(Vector3::from(*force)) };
        let found = solver.solve(&command);
        assert!(found.converged && found.stable, "{motions:?}");
        let told: Vec<String> = told.iter().flatten().chain(force).map(f64::to_string).collect();
        for row in see(&solver, &found) {
            writeln!(csv, "{},1e-3,1e-3,{row}", told.join(",")).unwrap();
        }
    }
    csv
}

const TIP: &str = "x_mm,y_mm,z_mm";

fn tip(_: &BundleSolver<'_>, found: &BundleEquilibrium) -> Vec<String> {
    let at = found.tip * 1e3;
    vec![format!("{},{},{}", at.x, at.y, at.z)]
}

fn fitted(name: &str, csv: &str, names: &[&str]) -> Result<Fit, FitProblem> {
    let design = changed(name, &[]);
    let rows = read(csv, design.tubes.len()).unwrap();
    let list: Vec<_> = names.iter().map(|name| Parameter::parse(name).unwrap()).collect();
    fit(&[design.into()], &rows, &list, None, None)
}

/// The fit finds the truth, and the file it writes is the fitted design.
fn recovers(name: &str, truth: &[(&str, f64)], csv: &str, within: f64) {
    let names: Vec<&str> = truth.iter().map(|t| t.0).collect();
    let fit = fitted(name, csv, &names).unwrap_or_else(|problem| panic!("{name}: {problem}"));
    for (estimate, (parameter, want)) in fit.estimates.iter().zip(truth) {
        let miss = estimate.value / want - 1.0;
        assert!(miss.abs() < within, "{name}: {parameter} is {miss:.1e} of its value off");
        assert!((estimate.before / want - 1.0).abs() > 0.01, "{name}: {parameter} was there before");
    }
    assert!(fit.rms < 1e-3 * fit.rms_before || fit.rms.is_nan(), "{name}: {} {}", fit.rms, fit.rms_before);
    let written = fitted_file(&text(name), &fit.estimates, None).unwrap();
    let Design::Bundle(meant) = &fit.designs[0] else { panic!("no bundle") };
    let read = cppr_io::bundle_file::parse(&written).unwrap();
    let tip = |design: &BundleDesign| {
        let bundle = Bundle::new(design).unwrap();
        let mut solver = BundleSolver::new(&bundle);
        let mut command = solver.held();
        for drive in &mut command.drives[1..] {
            *drive = TubeDrive { translation: Drive::Motion(3e-4), rotation: Drive::Motion(0.5) };
        }
        command.loads = Loads::tip_force(Vector3::new(0.0, 0.02, 0.02));
        let found = solver.solve(&command);
        assert!(found.converged);
        found.tip
    };
    let apart = (tip(&read) - tip(meant)).norm();
    assert!(apart < 1e-8, "{name}: the file written is another robot by {apart:.1e} m");
    let moved = (tip(&changed(name, &[])) - tip(meant)).norm();
    assert!(
        moved > 1e-5,
        "{name}: the fit changes the robot, so that the comparison means something: {moved:.1e} m"
    );
}

#[test]
fn offsets_and_moduli_of_notched_parts() {
    let truth = [("centroid_offset_factor", 1.12), ("youngs_modulus@1", 52e9), ("youngs_modulus@2", 71e9)];
    let poses: Vec<Pose<'_>> = vec![
        (&[(2, 0.5, 0.0)], [0.0, 0.0, 0.0]),
        (&[(2, -0.5, 0.0)], [0.0, 0.05, 0.0]),
        (&[(2, 0.3, 60.0)], [0.0, 0.03, 0.04]),
        (&[(2, -0.4, -80.0)], [0.0, 0.0, -0.05]),
        (&[(1, -5.0, 0.0), (2, -4.7, 20.0)], [0.0, 0.04, 0.0]),
    ];
    let csv = table("uncut_ends", &truth, &poses, TIP, tip);
    recovers("uncut_ends", &truth, &csv, 1e-5);
}

#[test]
fn offsets_of_parts_given_by_stiffness() {
    let truth = [("centroid_offset_factor@1", 1.2), ("centroid_offset_factor@2", 0.9)];
    let poses: Vec<Pose<'_>> = vec![
        (&[(2, 3.0, 0.0)], [0.0, 0.0, 0.0]),
        (&[(2, -3.0, 40.0)], [0.0, 0.1, 0.0]),
        (&[(2, 2.0, -70.0)], [0.0, 0.0, 0.1]),
    ];
    let csv = table("s_shape", &truth, &poses, TIP, tip);
    recovers("s_shape", &truth, &csv, 1e-5);
    let problem = fitted("s_shape", &csv, &["youngs_modulus"]).unwrap_err().to_string();
    assert!(problem.contains("has no modulus to fit"), "{problem}");
}

#[test]
fn curvatures_of_free_tubes_and_their_shear_modulus() {
    let truth = [("rest_curvature_factor", 1.06), ("shear_modulus", 20e9)];
    let poses: Vec<Pose<'_>> = vec![
        (&[(2, 0.0, 60.0), (3, 0.0, 150.0)], [0.0; 3]),
        (&[(2, -10.0, -40.0), (3, -20.0, 90.0)], [0.0; 3]),
        (&[(3, 0.0, -120.0)], [0.0; 3]),
        (&[(2, 5.0, 90.0), (3, 10.0, -60.0)], [0.0; 3]),
    ];
    let csv = table("concentric3", &truth, &poses, TIP, tip);
    recovers("concentric3", &truth, &csv, 1e-5);
    // Curvatures alone, of single tubes.
    let truth = [("rest_curvature_factor@2", 1.1), ("rest_curvature_factor@3", 0.93)];
    let csv = table("concentric3", &truth, &poses, TIP, tip);
    recovers("concentric3", &truth, &csv, 1e-5);
    let problem = fitted("concentric3", &csv, &["rest_curvature_factor", "youngs_modulus"]).unwrap_err();
    assert!(matches!(problem, FitProblem::Invisible { .. }), "motions show no common modulus: {problem}");
}

/// The shaft of the curved tube is 300 mm of its own material: it follows the fitted moduli, in the fit and in the file.
#[test]
fn a_shaft_follows_the_moduli_of_its_tube() {
    let truth = [("youngs_modulus@3", 50e9), ("shear_modulus@3", 17e9)];
    let poses: Vec<Pose<'_>> = vec![
        (&[(2, 0.5, 0.0), (3, -10.0, -60.0)], [0.0, 0.02, 0.0]),
        (&[(3, -20.0, 90.0)], [0.0, 0.0, 0.02]),
        (&[(2, -0.5, 0.0), (3, 0.0, 120.0)], [0.0, -0.02, 0.01]),
    ];
    let csv = table("hybrid", &truth, &poses, TIP, tip);
    recovers("hybrid", &truth, &csv, 1e-5);
    let shaft = |design: &BundleDesign| design.tubes[2].shaft.unwrap();
    let [before, after] = [&[][..], &truth].map(|truth| shaft(&changed("hybrid", truth)));
    assert!((after.axial / before.axial / (50.0 / 60.0) - 1.0).abs() < 1e-12);
    assert!((after.torsional / before.torsional / (17.0 / (60.0 / 2.6)) - 1.0).abs() < 1e-12);
}

/// Points along the centreline and along the centroid line of a tube that ends on the way, each with a direction.
#[test]
fn shapes_give_the_values_too() {
    let truth = [("centroid_offset_factor@2", 1.15), ("centroid_offset_factor@4", 0.9)];
    let poses: Vec<Pose<'_>> = vec![
        (&[(2, 2.0, 0.0), (4, 2.0, 0.0)], [0.0, 0.1, 0.0]),
        (&[(2, -1.0, 30.0), (4, 1.0, -40.0)], [0.0, 0.0, 0.1]),
    ];
    let see = |solver: &BundleSolver<'_>, found: &BundleEquilibrium| {
        // Sections between those that the fit looks at: far finer, and the nearest.
        let shape = solver.shape(found, found.length / 2e4);
        let mut rows = Vec::new();
        for part in [0.4, 0.9] {
            let s = &shape[shape.partition_point(|s| s.length < part * found.length)];
            let row = |line: &str, at: f64, point: Vector3<f64>| {
                let (p, d) = (point * 1e3, Matrix3::from(s.frame).column(0).into_owned());
                format!("{line},{},{},{},{},{},{},{}", at * 1e3, p.x, p.y, p.z, d.x, d.y, d.z)
            };
            rows.push(row("centre", s.length, s.centre));
            for tube in [1, 3] {
                if let Some(own) = s.tube(tube) {
                    let (sin, cos) = own.angle.sin_cos();
                    let towards = s.frame.column(1) * cos + s.frame.column(2) * sin;
                    let line = format!("tube{}", tube + 1);
                    rows.push(row(&line, own.label, s.centre + towards * own.centroid_offset));
                }
            }
        }
        rows
    };
    let head = "line,at_mm,x_mm,y_mm,z_mm,direction_x,direction_y,direction_z";
    let csv = table("two_sections", &truth, &poses, head, see);
    assert_eq!(csv.lines().count(), 1 + 2 * (2 + 1 + 2), "tube 2 ends at 60 mm:\n{csv}");
    recovers("two_sections", &truth, &csv, 1e-4);
}

#[test]
fn what_cannot_be_measured_is_refused_with_its_line() {
    let fails = |name: &str, csv: &str, fragment: &str| {
        let problem = fitted(name, csv, &["centroid_offset_factor"]).unwrap_err().to_string();
        assert!(problem.starts_with("line 2: ") && problem.contains(fragment), "{problem}");
    };
    fails("s_shape", "pull2_mm,x_mm,y_mm\n200,150,0\n", "behind the plate");
    fails("s_shape", "at_mm,x_mm,y_mm\n151,150,0\n", "goes from 0.000 to 150.000 mm");
    fails("two_sections", "line,at_mm,x_mm,y_mm\ntube2,61,60,0\n", "goes from 0.000 to 60.000 mm");
    fails("two_sections", "line,x_mm,y_mm\ntube5,61,60\n", "has tubes 1 to 4");
    fails("s_shape", "pull1_mm,x_mm,y_mm\n-20,250,0\n", "out of reach");
}
