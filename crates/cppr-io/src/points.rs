//! Points along a robot's centreline, as CSV: one row per point.
//!
//! Columns, in any order: `x_mm`, `y_mm`, `z_mm` in the base frame, and optionally `at_mm` (distance of the section from the
//! baseplate along the robot at rest) and `sigma_mm` (standard deviation of each coordinate). Rows that begin with # are left out.

use cppr::Vector3;
use cppr::analysis::inverse::ShapePoint;

const COLUMNS: [&str; 5] = ["x_mm", "y_mm", "z_mm", "at_mm", "sigma_mm"];
/// Largest coordinate that is no slip of the unit (mm).
const LARGEST: f64 = 1e5;

/// Reads points; those without a deviation of their own get `deviation` (m).
///
/// # Errors
/// Every problem, each with its line.
pub fn read_points(text: &str, deviation: f64) -> Result<Vec<ShapePoint>, Vec<String>> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let head = reader.headers().map_err(|error| vec![format!("line 1: not a table: {error}")])?.clone();
    let mut problems: Vec<String> = head
        .iter()
        .filter(|name| !COLUMNS.contains(name))
        .map(|name| format!("line 1: the column {name} is not known here. Known are {}", COLUMNS.join(", ")))
        .collect();
    for name in &COLUMNS[..3] {
        if !head.iter().any(|own| own == *name) {
            problems.push(format!("line 1: the column {name} is missing"));
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut points = Vec::new();
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                problems.push(error.to_string());
                break;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        let mut read = |name: &str| -> Option<f64> {
            let column = head.iter().position(|own| own == name)?;
            let text = record.get(column).unwrap_or_default();
            let optional = !COLUMNS[..3].contains(&name);
            if optional && text.is_empty() {
                return None;
            }
            let value = text.parse::<f64>().ok().filter(|v| v.is_finite() && v.abs() <= LARGEST);
            if value.is_none() {
                problems.push(format!("line {line}: {name} is \"{text}\"; write a number of millimetres"));
            }
            value.map(|v| v * 1e-3)
        };
        let position = [read("x_mm"), read("y_mm"), read("z_mm")];
        let (label, own) = (read("at_mm"), read("sigma_mm"));
        if own.is_some_and(|sigma| sigma <= 0.0) {
            problems.push(format!("line {line}: sigma_mm must be above 0"));
        }
        if let [Some(x), Some(y), Some(z)] = position {
            let position = Vector3::new(x, y, z);
            points.push(ShapePoint { label, position, deviation: own.unwrap_or(deviation) });
        }
    }
    if points.is_empty() && problems.is_empty() {
        problems.push("there is no point; write one row per point".into());
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
            let said = read_points(text, 1e-3).unwrap_err().join("\n");
            assert!(said.contains(part), "{said}");
        };
        says("", "the column x_mm is missing");
        says("x_mm,y_mm\n1,2\n", "the column z_mm is missing");
        says("x_mm,y_mm,z\n1,2,3\n", "the column z is not known here");
        says("x_mm,y_mm,z_mm\n", "there is no point");
        says("x_mm,y_mm,z_mm\n1,2,3\n1,two,3\n", "line 3: y_mm is \"two\"");
        says("x_mm,y_mm,z_mm\n1,2\n", "line 2: z_mm is \"\"");
        says("x_mm,y_mm,z_mm\n1,NaN,3\n", "line 2: y_mm");
        says("x_mm,y_mm,z_mm,sigma_mm\n1,2,3,-1\n", "line 2: sigma_mm must be above 0");
    }
}
