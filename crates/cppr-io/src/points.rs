//! Points along a robot's centreline, as CSV: one row per point.
//!
//! Columns, in any order: `x_mm`, `y_mm`, `z_mm` in the base frame, and optionally `at_mm` (distance of the section from the
//! baseplate along the robot at rest) and `sigma_mm` (standard deviation of each coordinate). How columns are separated and
//! numbers written, [`crate::csv_table`] says.

use crate::csv_table::{Row, Table, TableProblem};
use cppr::Vector3;
use cppr::analysis::inverse::ShapePoint;

const COLUMNS: [&str; 5] = ["x_mm", "y_mm", "z_mm", "at_mm", "sigma_mm"];
/// Largest coordinate that is no slip of the unit (mm).
const LARGEST: f64 = 1e5;

/// Reads points; those without a deviation of their own get `deviation` (m).
///
/// # Errors
/// Every problem, each with its line.
pub fn read_points(text: &str, deviation: f64) -> Result<Vec<ShapePoint>, Vec<TableProblem>> {
    let (table, mut problems) = Table::parse(text);
    let mut problem = |line: usize, message: String| problems.push(TableProblem { line, message });
    let head = table.head.line;
    for name in table.head.fields.iter().filter(|name| !COLUMNS.contains(&name.as_str())) {
        problem(head, format!("the column {name} is not known here. Known are {}", COLUMNS.join(", ")));
    }
    for name in COLUMNS[..3].iter().filter(|name| table.column(name).is_none()) {
        problem(head, format!("the column {name} is missing"));
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut points = Vec::new();
    for Row { line, fields } in &table.rows {
        let mut problem = |message: String| problems.push(TableProblem { line: *line, message });
        let mut read = |name: &str| -> Option<f64> {
            let text = &fields[table.column(name)?];
            let optional = !COLUMNS[..3].contains(&name);
            if optional && text.is_empty() {
                return None;
            }
            let value = text.parse::<f64>().ok().filter(|v| v.is_finite() && v.abs() <= LARGEST);
            if value.is_none() {
                problem(format!("{name} is \"{text}\"; write a number of millimetres"));
            }
            value.map(|v| v * 1e-3)
        };
        let position = [read("x_mm"), read("y_mm"), read("z_mm")];
        let (label, own) = (read("at_mm"), read("sigma_mm"));
        if own.is_some_and(|sigma| sigma <= 0.0) {
            problem("sigma_mm must be above 0".into());
        }
        if let [Some(x), Some(y), Some(z)] = position {
            let position = Vector3::new(x, y, z);
            points.push(ShapePoint { label, position, deviation: own.unwrap_or(deviation) });
        }
    }
    if points.is_empty() && problems.is_empty() {
        let message = "there is no point below the head; write one row per point".into();
        problems.push(TableProblem { line: head, message });
    }
    if problems.is_empty() { Ok(points) } else { Err(problems) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::read_points;

    #[test]
    fn columns_may_come_in_any_order() {
        let text = "# camera 2\nz_mm,y_mm,x_mm,at_mm,sigma_mm\n0,-5,30,30,\n1, -20 ,60,,0.2\n";
        let points = read_points(text, 5e-4).unwrap();
        assert_eq!(points.len(), 2);
        assert!((points[0].position.x - 0.03).abs() < 1e-15 && (points[0].deviation - 5e-4).abs() < 1e-15);
        assert!(points[0].label.is_some() && points[1].label.is_none());
        assert!((points[1].position.y + 0.02).abs() < 1e-15 && (points[1].deviation - 2e-4).abs() < 1e-15);
    }

    #[test]
    fn every_problem_has_its_line() {
        let says = |text: &str, part: &str| {
            let problems = read_points(text, 1e-3).unwrap_err();
            let said = problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
            assert!(said.contains(part), "{said}");
        };
        says("", "the column x_mm is missing");
        says("x_mm,y_mm\n1,2\n", "the column z_mm is missing");
        says("x_mm,y_mm,z\n1,2,3\n", "the column z is not known here");
        says("x_mm,y_mm,z_mm\n", "there is no point");
        says("x_mm,y_mm,z_mm\n1,2,3\n1,two,3\n", "line 3: y_mm is \"two\"");
        says("x_mm,y_mm,z_mm\n1,2\n", "line 2: 2 fields here");
        says("x_mm,y_mm,z_mm\n1,2,\n", "line 2: z_mm is \"\"");
        says("# a\n# b\n# c\nx_m;y_m;z_m\n0;0;0\n", "line 4: the column x_m is not known here");
        says("x_mm,y_mm,z_mm\n1,NaN,3\n", "line 2: y_mm");
        says("x_mm,y_mm,z_mm,sigma_mm\n1,2,3,-1\n", "line 2: sigma_mm must be above 0");
    }
}
