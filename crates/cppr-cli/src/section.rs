//! `cppr section`: section properties along the tubes (Figure 7 of the paper).

use crate::Failure;
use crate::command::read_robot;
use crate::figure;
use crate::output::{self, is_stdout, note, print, write_or_print};
use crate::table::{millimetres, plain};
use cppr::design::{NotchedTube, Robot, TubeDesign};
use cppr_io::RobotFile;
use cppr_plot::{ProfileCurve, ProfileInput, Quantity, profile_figure};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr section robots/r3.toml
  cppr section robots/r3.toml --tube 2 --samples 31 --csv r3-sections.csv
  cppr section robots/r4.toml --plot r4-sections.png
  cppr section robots/r1.toml --tube 1 --json -

Stiffness and offset are as the mechanics takes them at every x. Unless the file says what the teeth do (teeth = \"cell\"), they are those
of the notched section: the teeth between notches count as notched too, whatever tooth_mm is.";

/// Arguments of `cppr section`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Only this tube
    #[arg(long, value_name = "K")]
    tube: Option<usize>,
    /// Sections from baseplate to tip
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    samples: u32,
    /// Write the table, - for standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the table in SI units, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the properties, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// One section of one tube; what the design does not say is NaN.
struct Row {
    x_mm: f64,
    depth_mm: f64,
    area_mm2: f64,
    offset_mm: f64,
    kinematic_offset_mm: f64,
    bending_y: f64,
    bending_z: f64,
    torsion: f64,
    mass_g_m: f64,
}

/// Name and unit, as table and plot print them.
const COLUMNS: [(&str, &str); 9] = [
    ("x", "mm"),
    ("depth", "mm"),
    ("A", "mm²"),
    ("D", "mm"),
    ("f_D D", "mm"),
    ("EI_Y", "N mm²"),
    ("EI_Z", "N mm²"),
    ("GJ", "N mm²"),
    ("mass", "g/m"),
];
const KEYS: [&str; 9] = [
    "x_mm",
    "notch_depth_mm",
    "area_mm2",
    "centroid_offset_mm",
    "kinematic_centroid_offset_mm",
    "bending_y_Nmm2",
    "bending_z_Nmm2",
    "torsion_Nmm2",
    "mass_per_length_g_m",
];

impl Row {
    fn new(file: &RobotFile, robot: &Robot, tube: usize, x: f64) -> Self {
        let fields = robot.fields_at(tube, x);
        let (depth, area) = match &file.design.tubes[tube] {
            TubeDesign::Notched(t) => {
                let depth = t.depth.eval(x, robot.length())[0];
                (depth * 1e3, t.outline.inertia(depth).map_or(f64::NAN, |i| i.area * 1e6))
            }
            TubeDesign::Stiffness(_) => (f64::NAN, f64::NAN),
        };
        let factor = file.tubes.get(tube).map_or(1.0, |t| t.centroid_offset_factor);
        Self {
            x_mm: x * 1e3,
            depth_mm: depth,
            area_mm2: area,
            offset_mm: fields.centroid_offset / factor * 1e3,
            kinematic_offset_mm: fields.centroid_offset * 1e3,
            bending_y: fields.bending_y * 1e6,
            bending_z: fields.bending_z * 1e6,
            torsion: fields.torsion * 1e6,
            // A design by stiffness that leaves its mass out has none.
            mass_g_m: if fields.mass_per_length > 0.0 { fields.mass_per_length * 1e3 } else { f64::NAN },
        }
    }

    /// In SI units; null where the design does not say.
    fn json(&self) -> Value {
        json!({
            "x_m": self.x_mm * 1e-3, "notch_depth_m": self.depth_mm * 1e-3, "area_m2": self.area_mm2 * 1e-6,
            "centroid_offset_m": self.offset_mm * 1e-3,
            "kinematic_centroid_offset_m": self.kinematic_offset_mm * 1e-3,
            "bending_y_Nm2": self.bending_y * 1e-6, "bending_z_Nm2": self.bending_z * 1e-6,
            "torsion_Nm2": self.torsion * 1e-6, "mass_per_length_kg_m": self.mass_g_m * 1e-3,
        })
    }

    fn values(&self) -> [f64; 9] {
        [
            self.x_mm,
            self.depth_mm,
            self.area_mm2,
            self.offset_mm,
            self.kinematic_offset_mm,
            self.bending_y,
            self.bending_z,
            self.torsion,
            self.mass_g_m,
        ]
    }
}

/// Prints, writes, draws.
pub fn run(args: &Args) -> Result<(), Failure> {
    let plot = args.plot.as_deref().map(figure::format).transpose()?;
    let (json, csv) = (args.json.as_deref(), args.csv.as_deref());
    output::check(&args.robot, &[("--json", json), ("--csv", csv), ("--plot", args.plot.as_deref())])?;
    let (file, robot) = read_robot(&args.robot)?;
    let count = robot.tube_count();
    let tubes: Vec<usize> = match args.tube {
        None => (0..count).collect(),
        Some(tube) if (1..=count).contains(&tube) => vec![tube - 1],
        Some(tube) => {
            return Err(Failure::Input(format!(
                "--tube: there is no tube {tube}; this robot has 1 to {count}"
            )));
        }
    };
    let rows = |tube: usize, samples: u32| -> Vec<Row> {
        let last = f64::from(samples - 1);
        (0..samples).map(|i| Row::new(&file, &robot, tube, robot.length() * f64::from(i) / last)).collect()
    };
    if let Some(path) = json {
        let tubes: Vec<Value> = tubes
            .iter()
            .map(|&tube| {
                let sections: Vec<Value> = rows(tube, args.samples).iter().map(Row::json).collect();
                json!({ "tube": tube + 1, "sections": sections })
            })
            .collect();
        let name = &robot.design().name;
        let whole = json!({ "schema": "cppr/section", "schema_version": 1, "robot": name, "tubes": tubes });
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    if let Some(path) = csv {
        let mut text = format!("tube,{}\n", KEYS.join(","));
        for &tube in &tubes {
            for row in rows(tube, args.samples) {
                // An empty field where the design does not say.
                let numbers =
                    row.values().map(|v| if v.is_nan() { String::new() } else { (v + 0.0).to_string() });
                let _ = writeln!(text, "{},{}", tube + 1, numbers.join(","));
            }
        }
        write_or_print(path, &text)?;
    }
    if let (Some(path), Some(format)) = (&args.plot, plot) {
        let drawn = args.samples.max(201);
        let quantities = [2, 4, 5, 6, 7]
            .into_iter()
            .map(|column| Quantity {
                label: COLUMNS[column].0.replace("_Y", "_{Y}").replace("_Z", "_{Z}").replace("f_D", "f_{D}"),
                unit: COLUMNS[column].1.into(),
                include_zero: true,
                curves: tubes
                    .iter()
                    .map(|&tube| {
                        let rows = rows(tube, drawn);
                        ProfileCurve {
                            name: format!("tube {}", tube + 1),
                            tube: tube + 1,
                            x_m: rows.iter().map(|r| r.x_mm * 1e-3).collect(),
                            values: rows.iter().map(|r| r.values()[column]).collect(),
                        }
                    })
                    .filter(|c| c.values.iter().all(|v| v.is_finite()))
                    .collect(),
            })
            .filter(|q: &Quantity| !q.curves.is_empty())
            .collect();
        let title = robot.design().name.clone();
        let input = ProfileInput { title, x_label: "X".into(), quantities };
        let drawn = profile_figure(&input).map_err(|e| figure::plot_failure(&e))?;
        figure::write(path, format, &drawn)?;
    }
    let mut text = String::new();
    for &tube in &tubes {
        let _ = writeln!(text, "{}, tube {}", robot.design().name, tube + 1);
        let head: Vec<String> =
            COLUMNS.iter().map(|(name, unit)| format!("{:>12}", format!("{name} {unit}"))).collect();
        let _ = writeln!(text, "{}", head.join(" "));
        for row in rows(tube, args.samples) {
            let cells =
                row.values().map(|v| format!("{:>12}", if v.is_nan() { "-".into() } else { plain(v, 4) }));
            let _ = writeln!(text, "{}", cells.join(" "));
        }
        if let TubeDesign::Notched(NotchedTube { pattern: Some(pattern), .. }) = &file.design.tubes[tube] {
            let tooth = millimetres(pattern.tooth);
            let _ = writeln!(
                text,
                "the teeth of {tooth} mm count as notched: stiffness does not depend on their length"
            );
        }
    }
    if [json, csv].into_iter().flatten().any(is_stdout) {
        note(&text);
        Ok(())
    } else {
        print(&text)
    }
}
