//! A measured wrist beside what its robot file says: tube 1 with notches, tube 2 its tendon.
//!
//!     cargo run --release -p cppr-cli --example wrists -- ROBOT DATA FRICTION [FIGURE.svg | --what-if]
//!
//! DATA is a CSV table with columns `force_N`, `total_deg` and, where rows are means, `readings`. Each cell of the wrist, a notch and a tooth, is solved under the tension at its
//! place: the capstan takes exp(−μ) of it per radian that the tendon has turned on its way from the motor, here up to the middle of the cell. `--what-if` says what other depths, cuts, teeth and
//! metals would do.
#![allow(clippy::print_stdout, reason = "a program")]

use cppr::bundle::solve::{BundleEquilibrium, BundleSolver};
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::TubeDesign;
use cppr::solve::Drive;
use cppr_io::bundle_file;
use cppr_plot::{Axis, XyCurve, XyInput, xy_figure};
use std::error::Error;

/// Tensions at which cells are solved, less one.
const SPACES: u32 = 100;
/// Below this force (N) the slope is compared.
const LOW: f64 = 0.5;

/// A row of measurements: force (N), total angle (°), readings behind it.
type Row = [f64; 3];

fn read(path: &str) -> Result<Vec<Row>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name);
    let find = |name: &str| column(name).ok_or(format!("{path}: there is no column {name}"));
    let (force, total, readings) = (find("force_N")?, find("total_deg")?, column("readings"));
    let rows = lines
        .enumerate()
        .map(|(i, line)| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |at: usize| -> Result<f64, String> {
                let cell = cells.get(at).copied().unwrap_or_default();
                cell.parse::<f64>().map_err(|_| format!("{path}, row {}: '{cell}' is no number", i + 2))
            };
            Ok([number(force)?, number(total)?, readings.map_or(Ok(1.0), number)?])
        })
        .collect::<Result<Vec<Row>, String>>()?;
    Ok(rows)
}

/// Ends of all cells along tube 1 (m).
fn cells(design: &BundleDesign) -> Vec<[f64; 2]> {
    let mut from = 0.0;
    let mut cells = Vec::new();
    for part in &design.tubes[0].parts {
        if let TubeDesign::Notched(tube) = &part.body
            && let Some(pattern) = tube.pattern
        {
            let half = 0.5 * pattern.pitch();
            cells.extend(pattern.middles().iter().map(|middle| [from + middle - half, from + middle + half]));
        }
        from += part.length;
    }
    cells
}

/// Angle (rad) of every cell over the tension in it (N).
struct Wrist {
    greatest: f64,
    angles: Vec<Vec<f64>>,
}

impl Wrist {
    fn solve(text: &str, greatest: f64) -> Result<Self, Box<dyn Error>> {
        let design = bundle_file::parse(text)?;
        let cells = cells(&design);
        let bundle = Bundle::new(&design)?;
        let mut solver = BundleSolver::new(&bundle);
        let mut last: Option<BundleEquilibrium> = None;
        let mut angles = Vec::new();
        for i in 0..=SPACES {
            let mut command = solver.held();
            command.drives[1].translation = Drive::Effort(greatest * f64::from(i) / f64::from(SPACES));
            let found = match &last {
                Some(last) => solver.solve_from(&command, last),
                None => solver.solve(&command),
            };
            if !found.converged {
                return Err(format!("no equilibrium at {:?}", command.drives[1].translation).into());
            }
            // Turn of the tangent since the plate, over the label of tube 1.
            let mut turns: Vec<[f64; 2]> = Vec::new();
            for section in solver.shape(&found, 1e-4) {
                let tangent = section.frame.column(0);
                let turn = tangent.y.atan2(tangent.x);
                let before = turns.last().map_or(0.0, |t| t[1]);
                let whole = std::f64::consts::TAU * ((before - turn) / std::f64::consts::TAU).round();
                turns.push([section.tubes[0].label, turn + whole]);
            }
            let at = |label: f64| interpolated(&turns, label);
            angles.push(cells.iter().map(|[from, to]| (at(*to) - at(*from)).abs()).collect());
            last = Some(found);
        }
        Ok(Self { greatest, angles })
    }

    /// Total angle (°) under a force at the motor (N).
    fn total(&self, force: f64, friction: f64) -> f64 {
        let mut behind = 0.0;
        for cell in 0..self.angles[0].len() {
            let mut own: f64 = 0.0;
            // A fixed point: half of the cell's own angle lies before its middle.
            for _ in 0..50 {
                let tension = force.max(0.0) * (-friction * (behind + 0.5 * own)).exp();
                let place = tension / self.greatest * f64::from(SPACES);
                let curve: Vec<[f64; 2]> =
                    self.angles.iter().enumerate().map(|(i, a)| [i as f64, a[cell]]).collect();
                own = 0.5 * (own + interpolated(&curve, place));
            }
            behind += own;
        }
        behind.to_degrees()
    }
}

/// Between points of rising abscissa.
fn interpolated(points: &[[f64; 2]], x: f64) -> f64 {
    let next = points.partition_point(|p| p[0] < x).clamp(1, points.len() - 1);
    let [[a, u], [b, v]] = [points[next - 1], points[next]];
    if b > a { u + (v - u) * ((x - a) / (b - a)).clamp(0.0, 1.0) } else { v }
}

/// Slope (°/N) below [`LOW`] of angles beside the rows.
fn slope(rows: &[Row], angle: &dyn Fn(&Row) -> f64) -> f64 {
    let low: Vec<&Row> = rows.iter().filter(|row| row[0] < LOW).collect();
    let sum = |f: &dyn Fn(&Row) -> f64| low.iter().map(|row| row[2] * f(row)).sum::<f64>();
    let count = sum(&|_| 1.0);
    let (force, mean) = (sum(&|row| row[0]) / count, sum(angle) / count);
    sum(&|row| (row[0] - force) * (angle(row) - mean)) / sum(&|row| (row[0] - force).powi(2))
}

/// Slope relative to the measured one, and rms of the total angle relative to that of the measured one and in degrees.
fn compare(wrist: &Wrist, rows: &[Row], friction: f64) -> [f64; 3] {
    let own = |row: &Row| wrist.total(row[0], friction);
    let sum = |f: &dyn Fn(&Row) -> f64| rows.iter().map(|row| row[2] * f(row)).sum::<f64>();
    let off = sum(&|row| (own(row) - row[1]).powi(2));
    [
        slope(rows, &own) / slope(rows, &|row| row[1]) - 1.0,
        (off / sum(&|row| row[1] * row[1])).sqrt(),
        (off / sum(&|_| 1.0)).sqrt(),
    ]
}

fn report(name: &str, wrist: &Wrist, rows: &[Row], friction: f64) {
    for (word, friction) in [("no friction", 0.0), ("friction", friction)] {
        let [slope, share, off] = compare(wrist, rows, friction);
        println!("{name:<44}{word:<13}{:>+8.1} %{:>8.1} %{off:>8.1}°", slope * 100.0, share * 100.0);
    }
}

/// What is changed in the text of the robot file.
const WHAT_IF: [(&str, &[[&str; 2]]); 10] = [
    ("teeth as soft as notches", &[["teeth = \"cell\"", "teeth = \"flexible\""]]),
    ("rigid teeth", &[["teeth = \"cell\"", "teeth = \"rigid\""]]),
    ("0.02 mm deeper", &[["depth_mm = 1.40", "depth_mm = 1.42"]]),
    ("corners of 0.05 mm", &[["teeth = \"cell\"", "teeth = \"cell\"\ncorner_radius_mm = 0.05"]]),
    ("cut radially, corners of 0.05 mm", &[["teeth = \"cell\"", RADIAL]]),
    ("the same, 1.45 mm deep", &[["teeth = \"cell\"", RADIAL], ["depth_mm = 1.40", "depth_mm = 1.45"]]),
    ("the same, 1.46 mm deep", &[["teeth = \"cell\"", RADIAL], ["depth_mm = 1.40", "depth_mm = 1.46"]]),
    ("linear metal", &[["onset_strain_percent = 2.0\nsecond_modulus_GPa = 3.2\n", ""]]),
    ("softening from 1 % on", &[["onset_strain_percent = 2.0", "onset_strain_percent = 1.0"]]),
    (
        "a modulus of 30 GPa, softening from 1 % on",
        &[
            ["youngs_modulus_GPa = 40.0", "youngs_modulus_GPa = 30.0"],
            ["onset_strain_percent = 2.0", "onset_strain_percent = 1.0"],
        ],
    ),
];
const RADIAL: &str = "teeth = \"cell\"\ncut = \"radial\"\ncorner_radius_mm = 0.05";

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let (robot, data, friction, more) = match &given[..] {
        [robot, data, friction] => (robot, data, friction, None),
        [robot, data, friction, more] => (robot, data, friction, Some(more.as_str())),
        _ => return Err("write ROBOT DATA FRICTION [FIGURE.svg | --what-if]".into()),
    };
    let (text, rows, friction) = (std::fs::read_to_string(robot)?, read(data)?, friction.parse::<f64>()?);
    let greatest = rows.iter().map(|row| row[0]).fold(0.0, f64::max);
    let wrist = Wrist::solve(&text, greatest)?;
    println!("{:<57}{:>10}{:>10}{:>9}", "", "slope", "rms", "");
    report("as the file says", &wrist, &rows, friction);
    if more == Some("--what-if") {
        for (name, changes) in WHAT_IF {
            let text = changes.iter().fold(text.clone(), |text, [from, to]| text.replace(from, to));
            report(name, &Wrist::solve(&text, greatest)?, &rows, friction);
        }
        return Ok(());
    }
    for row in &rows {
        println!(
            "{:8.3} N  measured {:6.1}°  without friction {:6.1}°  with {:6.1}°",
            row[0],
            row[1],
            wrist.total(row[0], 0.0),
            wrist.total(row[0], friction)
        );
    }
    if let Some(path) = more {
        let curve = |friction: f64| {
            let at = (0..=SPACES).map(|i| greatest * f64::from(i) / f64::from(SPACES));
            at.map(|force| [force, wrist.total(force, friction)]).collect()
        };
        let measured = XyCurve {
            scattered: true,
            ..XyCurve::new("measured", rows.iter().map(|row| [row[0], row[1]]).collect())
        };
        let input = XyInput {
            title: bundle_file::parse(&text)?.name,
            x: Axis::new("force on the tendon", "N"),
            y: Axis::new("angle of all notches", "°"),
            curves: vec![
                measured,
                XyCurve::new(format!("friction {friction}"), curve(friction)),
                XyCurve::new("no friction", curve(0.0)),
            ],
        };
        std::fs::write(path, xy_figure(&input)?.to_svg()?)?;
    }
    Ok(())
}
