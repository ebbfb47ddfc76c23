//! `cppr calibrate`: parameters from measurements.

use crate::Failure;
use crate::command::{build, described, unsound};
use crate::figure;
use crate::output::{check, print, write, write_or_print};
use crate::rubbing::{FrictionArgs, coefficient, guide};
use cppr::analysis::ACCURACY;
use cppr::bundle::Bundle;
use cppr::solve::Quantity;
use cppr_calibrate::{
    Design, Fit, FitProblem, Observed, Parameter, ParameterKind, common_friction, fit, fitted_file, read,
};
use cppr_io::bundle_file::Described;
use cppr_plot::{Axis, XyCurve, XyInput, xy_figure};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr calibrate robots/r1.toml robots/r2.toml --data examples/calibration/measured.csv --fit centroid_offset_factor,youngs_modulus
  cppr calibrate robots/r1.toml --data examples/calibration/r1.csv --fit centroid_offset_factor --output fitted --plot residuals.svg
  cppr calibrate robots/bundles/concentric3.toml --data examples/calibration/concentric3.csv --fit rest_curvature_factor,shear_modulus
  cppr calibrate robots/r1.toml --data examples/calibration/loop.csv --fit youngs_modulus,friction

Parameters: centroid_offset_factor, youngs_modulus, shear_modulus, rest_curvature_factor, onset_strain, second_modulus, tooth_factor; with @K for tube K
alone; gap, with @K between tubes K and K + 1. friction is one for all tubes. All robots share them. Without --fit the robots are compared as they are.
The table: one row per measurement, columns robot, pull2_mm, rotate2_deg, tension2_N, tip_force_y_N, driven, x_mm, y_mm, z_mm, bend_deg,
measured_tension2_N, sigma_mm, ... (docs/src/calibration.md has them all). What the data cannot determine is refused with exit code 2.";

/// Arguments of `cppr calibrate`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot files (TOML)
    #[arg(required = true, value_name = "ROBOT")]
    robots: Vec<PathBuf>,
    /// Measurements (CSV)
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Parameters to fit
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    fit: Vec<String>,
    /// Coefficient of friction between the tubes: where its fit begins, or what holds where it is not fitted; default: that of the robot files, if any; 0 leaves it out
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, value_parser = coefficient)]
    friction: Option<f64>,
    /// Length of the guide below the plate in which tubes are held: adds its friction; default: that of the robot files
    #[arg(long, value_name = "LENGTH", value_parser = guide)]
    guide: Option<f64>,
    /// Folder for the robot files with the fitted values
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Draw the residuals, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write the result, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Reads, fits, reports.
pub fn run(args: &Args) -> Result<(), Failure> {
    let format = args.plot.as_deref().map(figure::format).transpose()?;
    check(&args.data, &[("--plot", args.plot.as_deref()), ("--json", args.json.as_deref())])?;
    if let Some(folder) = &args.output {
        place(folder, &args.robots)?;
    }
    let list = args.fit.iter().map(|name| Parameter::parse(name.trim())).collect::<Result<Vec<_>, _>>();
    let list = list.map_err(|e| Failure::Input(format!("--fit: {e}")))?;
    let (mut designs, mut frictions) = (Vec::new(), Vec::new());
    for path in &args.robots {
        let described = described(path)?;
        match &described {
            Described::Robot(file) => drop(build(file, path)?),
            Described::Bundle { design, .. } => {
                drop(Bundle::new(design).map_err(|problems| unsound(path, &problems))?);
            }
        }
        frictions.push(described.friction());
        designs.push(Design::from(described));
    }
    let shown = args.data.display();
    let text = fs::read_to_string(&args.data)
        .map_err(|e| Failure::Input(format!("{shown}: cannot be read: {e}")))?;
    let tubes = designs.iter().map(Design::tube_count).max().unwrap_or(0);
    let rows = read(&text, tubes).map_err(|problems| {
        let lines: Vec<String> = problems.iter().map(|p| format!("{shown}: {p}")).collect();
        Failure::Input(lines.join("\n"))
    })?;
    let own = match common_friction(&frictions) {
        Err(problem) if args.friction.is_none() => return Err(Failure::Input(problem.to_string())),
        own => own.ok().flatten(),
    };
    let friction = FrictionArgs { friction: args.friction, guide: args.guide }.alone(own)?;
    let found = fit(&designs, &rows, &list, friction, None).map_err(|problem| match problem {
        FitProblem::NoEquilibrium(..) => Failure::NoEquilibrium(format!("{shown}: {problem}")),
        FitProblem::Measurement(..) => Failure::Input(format!("{shown}: {problem}")),
        _ => Failure::Input(problem.to_string()),
    })?;
    if let Some(folder) = &args.output {
        fs::create_dir_all(folder).map_err(|e| Failure::Input(format!("{}: {e}", folder.display())))?;
        for path in &args.robots {
            put(path, folder, &found, friction.and_then(|own| own.guide))?;
        }
    }
    if let (Some(path), Some(format)) = (&args.plot, format) {
        figure::write(path, format, &residuals(&found)?)?;
    }
    if let Some(path) = &args.json {
        write_or_print(path, &json(&found))?;
        if crate::output::is_stdout(path) {
            return Ok(());
        }
    }
    print(&table(&found))
}

/// Refuses, before anything is fitted, a folder that is none and one in which the robots themselves lie.
fn place(folder: &Path, robots: &[PathBuf]) -> Result<(), Failure> {
    let refuse = |what: String| Err(Failure::Input(format!("--output {}: {what}", folder.display())));
    if folder.exists() && !folder.is_dir() {
        return refuse("this is no folder; give another name".into());
    }
    for (i, robot) in robots.iter().enumerate() {
        if robots[..i].iter().any(|other| other.file_name() == robot.file_name()) {
            return refuse(format!("two robots would be written as {}; rename one", robot.display()));
        }
        let own = robot.file_name().and_then(|name| fs::canonicalize(folder.join(name)).ok());
        if own.is_some() && own == fs::canonicalize(robot).ok() {
            return refuse(format!("{} would be overwritten; give another folder", robot.display()));
        }
    }
    Ok(())
}

fn put(robot: &Path, folder: &Path, found: &Fit, guide: Option<f64>) -> Result<(), Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::Input(format!("{}: {e}", robot.display()));
    let text = fs::read_to_string(robot).map_err(|e| failed(&e))?;
    let fitted = fitted_file(&text, &found.estimates, guide).map_err(|e| failed(&e))?;
    let name = robot.file_name().ok_or_else(|| failed(&"is no file"))?;
    write(&folder.join(name), fitted.as_bytes())
}

fn table(found: &Fit) -> String {
    let mut text = String::new();
    if !found.estimates.is_empty() {
        let _ = writeln!(text, "{:<28}{:>12}{:>12}  95 % interval", "parameter", "before", "fitted");
    }
    for e in &found.estimates {
        let (unit, size) = e.parameter.unit();
        let _ = writeln!(
            text,
            "{:<28}{:>12.5}{:>12.5}  ± {:.5} {unit}",
            e.parameter.to_string(),
            e.before / size,
            e.value / size,
            e.interval / size
        );
    }
    for i in 0..found.estimates.len() {
        for j in 0..i {
            let (a, b) = (&found.estimates[i].parameter, &found.estimates[j].parameter);
            let _ = writeln!(text, "correlation of {b} and {a}: {:+.2}", found.correlation[i][j]);
        }
    }
    let mut squares = |name: &str, unit: &str, size: f64, [before, fitted]: [f64; 2], of: &str| {
        let name = format!("root mean square {name}");
        let fitted = match found.estimates.len() {
            0 => String::new(),
            _ => format!(" before, {:.3} {unit} fitted", fitted / size),
        };
        let _ = writeln!(text, "{name:<28}{:.3} {unit}{fitted}{of}", before / size);
    };
    if found.rms.is_finite() {
        squares("distance", "mm", 1e-3, [found.rms_before, found.rms], "");
    }
    for own in &found.misses {
        let (unit, size) = shown(own.what);
        let of = format!("; of the measured {:.3} {unit}", own.measured / size);
        squares(&own.what.to_string(), unit, size, [own.before, own.fitted], &of);
    }
    let _ = writeln!(
        text,
        "noise against stated        {:.2} (1 where the stated deviations are right and the model is)",
        found.scale
    );
    let (error, known) = found.accuracy;
    let accuracy = match known {
        0 => "of the model is not known".into(),
        n => format!("tip within {error:.0e} of the length in {n} measurements looked at"),
    };
    let _ = writeln!(text, "accuracy                    {accuracy}");
    if error > ACCURACY {
        let _ = writeln!(
            text,
            "warning: the model's modes do not follow its fields; what was fitted is no better than its tip"
        );
    }
    for e in found.estimates.iter().filter(|e| e.at_bound) {
        let (unit, size) = e.parameter.unit();
        let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
        let _ = writeln!(
            text,
            "bound: {} ends at {:.5}{unit}, where its values end; the data ask for one beyond, which a wrong model does as well",
            e.parameter,
            e.value / size
        );
    }
    for e in found.estimates.iter().filter(|e| e.parameter.kind == ParameterKind::Gap) {
        let _ = writeln!(
            text,
            "{} stands in no robot file: with --clearance {:.4}mm, for all tubes, cppr solve takes it",
            e.parameter,
            e.value * 1e3
        );
    }
    for r in found.residuals.iter().filter(|r| r.outlier) {
        let _ = writeln!(
            text,
            "outlier: line {}, {}: {:.1} standard deviations away; look at it, it was not left out",
            r.row, r.what, r.studentised
        );
    }
    text
}

fn json(found: &Fit) -> String {
    let estimates: Vec<serde_json::Value> = found
        .estimates
        .iter()
        .map(|e| {
            let (unit, size) = e.parameter.unit();
            serde_json::json!({
                "parameter": e.parameter.to_string(), "unit": unit, "before": e.before / size,
                "value": e.value / size, "standard_deviation": e.deviation / size,
                "interval_95": e.interval / size, "at_bound": e.at_bound,
            })
        })
        .collect();
    let residuals: Vec<serde_json::Value> = found
        .residuals
        .iter()
        .map(|r| {
            let key = format!("value_{}", r.what.unit());
            serde_json::json!({ "line": r.row, "what": r.what.to_string(), key: r.value, "studentised": r.studentised,
                "outlier": r.outlier })
        })
        .collect();
    let misses: Vec<serde_json::Value> = found
        .misses
        .iter()
        .map(|own| {
            serde_json::json!({ "what": own.what.to_string(), "unit": own.what.unit(), "before": own.before,
                "fitted": own.fitted, "measured": own.measured })
        })
        .collect();
    let whole = serde_json::json!({
        "schema": "cppr/calibration", "schema_version": 1, "estimates": estimates,
        "correlation": found.correlation, "rms_distance_m": found.rms, "rms_distance_before_m": found.rms_before,
        "rms": misses,
        "noise_against_stated": found.scale, "residuals": residuals,
        "accuracy": { "tip_of_length": (found.accuracy.1 > 0).then_some(found.accuracy.0), "measurements": found.accuracy.1 },
    });
    format!("{whole:#}\n")
}

/// Unit of what was measured for people, with its size in SI.
fn shown(what: Observed) -> (&'static str, f64) {
    match what {
        Observed::Coordinate(_) => ("mm", 1e-3),
        Observed::Direction(_) | Observed::Bend => ("deg", 1_f64.to_radians()),
        Observed::Effort(_, freedom) => {
            let effort = Quantity::of(freedom, false);
            (effort.shown_unit, effort.shown_size)
        }
    }
}

/// Studentised residuals over the lines of the file, with ±2 as a guide.
fn residuals(found: &Fit) -> Result<cppr_plot::Figure, Failure> {
    let mut curves: Vec<XyCurve> = Vec::new();
    for r in &found.residuals {
        let point = [r.row as f64, r.studentised];
        let what = r.what.to_string();
        match curves.iter_mut().find(|c| c.name == what) {
            Some(curve) => curve.points.push(point),
            None => curves.push(XyCurve { scattered: true, ..XyCurve::new(what, vec![point]) }),
        }
    }
    let rows = found.residuals.iter().map(|r| r.row as f64);
    let (first, last) = rows.fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
    for (limit, name) in [(2.0, "±2 deviations"), (-2.0, "")] {
        let line = vec![[first, limit], [last, limit]];
        curves.push(XyCurve { reference: true, ..XyCurve::new(name, line) });
    }
    let input = XyInput {
        title: "Residuals of the fit".into(),
        x: Axis::new("line of the file", "-"),
        y: Axis::new("studentised residual", "-"),
        curves,
    };
    xy_figure(&input).map_err(|e| figure::plot_failure(&e))
}
