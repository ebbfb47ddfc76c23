//! Fitted values put into a robot file in place; everything else in it stays as it is.

use crate::fit::Estimate;
use crate::parameter::ParameterKind;
use std::fmt;
use toml_edit::{DocumentMut, Item, Table, Value, value};

/// Why a file cannot be edited.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileProblem(String);

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the fitted values cannot be put into the robot file: {}", self.0)
    }
}

impl std::error::Error for FileProblem {}

/// The text of a robot file with the fitted values; comments and order stay. `guide` (m) is the guide beside which friction was fitted.
///
/// # Errors
/// Where the text is no robot file.
pub fn fitted_file(text: &str, estimates: &[Estimate], guide: Option<f64>) -> Result<String, FileProblem> {
    let mut document: DocumentMut =
        text.parse().map_err(|e: toml_edit::TomlError| FileProblem(e.to_string()))?;
    let mut sorted: Vec<&Estimate> = estimates.iter().collect();
    // A shear modulus replaces Poisson's ratio; it comes after Young's modulus.
    sorted.sort_by_key(|e| e.parameter.kind == ParameterKind::ShearModulus);
    for estimate in sorted {
        let number = estimate.value / estimate.parameter.unit().1;
        match (estimate.parameter.kind, estimate.parameter.tube) {
            // No robot file has it.
            (ParameterKind::Gap, _) => {}
            (ParameterKind::Friction, _) => {
                let own = table(document.as_table_mut(), "friction")?;
                put(own, "coefficient", number);
                if let Some(length) = guide {
                    put(own, "guide_mm", length * 1e3);
                }
            }
            (ParameterKind::ToothFactor, None) => each_tube(&mut document, |tube| teeth(tube, number))?,
            (ParameterKind::ToothFactor, Some(k)) => teeth(own_tube(&mut document, k)?, number)?,
            (ParameterKind::OnsetStrain, tube) => {
                soften(
                    &mut document,
                    tube,
                    ["onset_strain_percent", "unloading_onset_strain_percent"],
                    number,
                )?;
            }
            (ParameterKind::SecondModulus, tube) => {
                soften(&mut document, tube, ["second_modulus_GPa"], number)?;
            }
            (ParameterKind::RestCurvatureFactor, None) => {
                each_tube(&mut document, |tube| curve(tube, number))?;
            }
            (ParameterKind::RestCurvatureFactor, Some(k)) => curve(own_tube(&mut document, k)?, number)?,
            (ParameterKind::CentroidOffsetFactor, None) => {
                put(table(document.as_table_mut(), "calibration")?, "centroid_offset_factor", number);
                each_tube(&mut document, |tube| {
                    if tube.contains_key("centroid_offset_factor") {
                        put(tube, "centroid_offset_factor", number);
                    }
                    Ok(())
                })?;
            }
            (ParameterKind::CentroidOffsetFactor, Some(k)) => {
                put(own_tube(&mut document, k)?, "centroid_offset_factor", number);
            }
            (kind, None) => {
                material(table(document.as_table_mut(), "material")?, kind, number);
                each_tube(&mut document, |tube| {
                    if tube.contains_key("material") {
                        material(table(tube, "material")?, kind, number);
                    }
                    Ok(())
                })?;
            }
            (kind, Some(k)) => material(table(own_tube(&mut document, k)?, "material")?, kind, number),
        }
    }
    Ok(document.to_string())
}

fn material(table: &mut Table, kind: ParameterKind, number: f64) {
    if kind == ParameterKind::ShearModulus {
        table.remove("poissons_ratio");
        put(table, "shear_modulus_GPa", number);
    } else {
        put(table, "youngs_modulus_GPa", number);
    }
}

/// Sets the first of some keys of softening metal; the others and those of compression, where they are, keep their ratio to it.
fn soften<const N: usize>(
    document: &mut DocumentMut,
    tube: Option<usize>,
    keys: [&str; N],
    number: f64,
) -> Result<(), FileProblem> {
    let keys: Vec<String> =
        keys.iter().flat_map(|key| [(*key).to_owned(), format!("compression_{key}")]).collect();
    let read = |table: &Table| -> Vec<Option<f64>> {
        keys.iter().map(|key| table.get(key).and_then(as_number)).collect()
    };
    let common = document.get("material").and_then(Item::as_table).map(read);
    // `all` writes what the table has not said before as well.
    let change = |table: &mut Table, all: bool| {
        let own = read(table);
        let known = |i: usize| own[i].or(common.as_ref().and_then(|common| common[i]));
        let Some(tension) = known(0) else { return };
        for (i, key) in keys.iter().enumerate() {
            if let Some(value) = known(i).filter(|_| all || own[i].is_some()) {
                put(table, key, value / tension * number);
            }
        }
    };
    if let Some(k) = tube {
        change(table(own_tube(document, k)?, "material")?, true);
        return Ok(());
    }
    if let Some(own) = document.get_mut("material").and_then(Item::as_table_mut) {
        change(own, false);
    }
    each_tube(document, |tube| {
        if tube.contains_key("material") {
            change(table(tube, "material")?, false);
        }
        Ok(())
    })
}

fn as_number(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|n| n as f64))
}

/// Multiplies the rest curvatures of a tube and of its parts.
fn curve(tube: &mut Table, factor: f64) -> Result<(), FileProblem> {
    let key = "rest_curvature_1_m";
    with_parts(tube, |own| {
        if let Some(old) = own.get(key).and_then(as_number) {
            put(own, key, old * factor);
        }
    })
}

/// Sets the factor on teeth whose cells are computed, of a tube and of its parts.
fn teeth(tube: &mut Table, factor: f64) -> Result<(), FileProblem> {
    with_parts(tube, |own| {
        let notches = own.get_mut("notches").and_then(Item::as_table_mut);
        let computed = |own: &&mut Table| own.get("teeth").and_then(Item::as_str) == Some("cell");
        if let Some(own) = notches.filter(computed) {
            put(own, "tooth_factor", factor);
        }
    })
}

/// Changes a tube and its parts.
fn with_parts(tube: &mut Table, mut change: impl FnMut(&mut Table)) -> Result<(), FileProblem> {
    change(tube);
    if let Some(parts) = tube.get_mut("part") {
        let parts = parts.as_array_of_tables_mut();
        let parts = parts.ok_or_else(|| FileProblem("part is not written as [[tube.part]] tables".into()))?;
        parts.iter_mut().for_each(change);
    }
    Ok(())
}

/// Sets a number; the comment behind it stays. Eight digits are more than a fit knows.
fn put(table: &mut Table, key: &str, number: f64) {
    let rounded: f64 = format!("{number:.7e}").parse().unwrap_or(number);
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            let decor = old.decor().clone();
            *old = Value::from(rounded);
            *old.decor_mut() = decor;
        }
        None => {
            table.insert(key, value(rounded));
        }
    }
}

fn table<'a>(parent: &'a mut Table, key: &str) -> Result<&'a mut Table, FileProblem> {
    let entry = parent.entry(key).or_insert_with(|| Item::Table(Table::new()));
    entry.as_table_mut().ok_or_else(|| FileProblem(format!("{key} is not a [{key}] table")))
}

fn each_tube(
    document: &mut DocumentMut,
    mut change: impl FnMut(&mut Table) -> Result<(), FileProblem>,
) -> Result<(), FileProblem> {
    let tubes = document.get_mut("tube").and_then(Item::as_array_of_tables_mut);
    let tubes = tubes.ok_or_else(|| FileProblem("there is no [[tube]]".into()))?;
    tubes.iter_mut().try_for_each(&mut change)
}

fn own_tube(document: &mut DocumentMut, number: usize) -> Result<&mut Table, FileProblem> {
    let tubes = document.get_mut("tube").and_then(Item::as_array_of_tables_mut);
    tubes
        .and_then(|t| t.get_mut(number - 1))
        .ok_or_else(|| FileProblem(format!("there is no [[tube]] {number}")))
}
