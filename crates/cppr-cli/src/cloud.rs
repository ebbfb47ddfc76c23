//! The workspace of a sweep as a figure: stable tip positions, coloured by a column of its table.

use crate::Failure;
use crate::figure::plot_failure;
use cppr_plot::{Axis, Cloud, CloudInput, Figure, cloud_figure};
use cppr_sweep::{Chunk, Subject, Task, Variable, Verdict};

/// Gathers tips while a table is read.
pub struct Workspace {
    cloud: Cloud,
    /// Columns of status, tip and colour.
    columns: [usize; 5],
    /// Robots that differ by little: the figure has the scale of the scatter.
    of_tolerances: bool,
    /// From the column's unit to that of the figure.
    factor: f64,
    axis: Axis,
}

/// Short names of columns.
const SHORT: [(&str, &str); 8] = [
    ("tension", "tube2_tension_N"),
    ("torque", "tube2_torque_Nm"),
    ("energy", "elastic_energy_J"),
    ("margin", "margin_to_instability"),
    ("bend", "bend_angle_rad"),
    ("strain", "strain_utilisation"),
    ("closure", "closure_utilisation"),
    ("torsion", "torsion_utilisation"),
];

/// Units of columns, what a figure shows instead, and the factor between them.
const UNITS: [(&str, &str, f64); 5] = [
    ("_Nm", "N mm", 1e3),
    ("_N", "N", 1.0),
    ("_m", "mm", 1e3),
    ("_rad", "°", 180.0 / std::f64::consts::PI),
    ("_J", "mJ", 1e3),
];

impl Workspace {
    /// For a task, coloured by a column or by one of the short names.
    pub fn new(task: &Task, colour: Option<&str>) -> Result<Self, Failure> {
        let columns = task.columns();
        let place = |name: &str| columns.iter().position(|column| column.name == name);
        let usual = ["tube2_tension_N", "elastic_energy_J"].into_iter().find(|name| place(name).is_some());
        let asked = colour.or(usual).unwrap_or("bend");
        let name = SHORT.iter().find(|(short, _)| *short == asked).map_or(asked, |(_, name)| *name);
        let Some(value) = place(name) else {
            let add = match name {
                "margin_to_instability" => "; add --margin",
                name if name.ends_with("_utilisation") => "; add --limits",
                _ => "",
            };
            let there: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            return Err(Failure::Input(format!(
                "--colour {asked}: the table has no such column{add}. There are {}",
                there.join(", ")
            )));
        };
        let (label, unit, factor) = in_shown_unit(name);
        let place = |name| place(name).unwrap_or_default();
        let of_tolerances = task.axes.iter().any(|axis| matches!(axis.variable, Variable::Design(_)));
        Ok(Self {
            cloud: Cloud::new(task.length() * if of_tolerances { CLOSE } else { 1.0 }),
            of_tolerances,
            columns: [place("status"), place("tip_x_m"), place("tip_y_m"), place("tip_z_m"), value],
            factor,
            axis: Axis::new(label, unit),
        })
    }

    /// Takes the stable poses of a chunk.
    pub fn visit(&mut self, chunk: &Chunk) {
        let [status, x, y, z, value] = self.columns.map(|index| chunk.column(index));
        for row in 0..chunk.rows {
            if Verdict::from_code(status[row]) == Some(Verdict::Converged) {
                self.cloud.add([x[row], y[row], z[row]], self.factor * value[row]);
            }
        }
    }

    /// The figure.
    pub fn figure(self, task: &Task) -> Result<Figure, Failure> {
        let title = format!("{}: {} stable of {} poses", task.name(), self.cloud.total, task.rows());
        let straight = match &task.subject {
            Subject::Robot(_) => true,
            Subject::Bundle(own) => own
                .design
                .tubes
                .iter()
                .flat_map(|tube| &tube.parts)
                .all(|part| part.rest_curvature.abs() <= 0.0),
        };
        let length = (straight && !self.of_tolerances).then(|| task.length());
        let input = CloudInput { title, cloud: self.cloud, value: self.axis, length };
        cloud_figure(&input).map_err(|error| plot_failure(&error))
    }
}

/// Detail of a scatter, as part of that of a workspace.
const CLOSE: f64 = 1e-3;

/// A column in words, the unit that people read, and the factor to it.
pub fn in_shown_unit(name: &str) -> (String, &'static str, f64) {
    let (stem, unit, factor) = UNITS
        .iter()
        .find_map(|(suffix, unit, factor)| Some((name.strip_suffix(suffix)?, *unit, *factor)))
        .unwrap_or((name, "", 1.0));
    (label(stem), unit, factor)
}

/// `tube2_tension` is the tension of tube 2.
fn label(stem: &str) -> String {
    let words = stem.replace('_', " ");
    let tube = words.strip_prefix("tube").and_then(|rest| rest.split_once(' '));
    match tube {
        Some((number, what)) if number.parse::<u8>().is_ok() => format!("{what} of tube {number}"),
        _ => words,
    }
}
