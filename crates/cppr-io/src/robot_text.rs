//! The text of a robot file that reads back as a given design: the inverse of [`crate::robot_file::parse`], and of [`crate::bundle_file::parse`] where metal softens or
//! teeth meet.
//!
//! Radii are written as diameters, which is what a caliper shows. Numbers are the shortest ones that read back to the same SI
//! value, or to its neighbour where none does.

use crate::bundle_file;
use crate::problems::Problems;
use crate::quantity::{self, Unit};
use cppr::bundle::Friction;
use cppr::design::{
    BelowPlate, Branch, CellTable, Cut, Made, Material, NotchPattern, NotchedTube, Outline, Profile,
    RobotDesign, Softening, StiffnessTube, TeethStiffness, Torsion, TubeDesign,
};
use std::f64::consts::PI;
use std::fmt::Write;

/// Writes a design, and how its tubes rub, as a robot file, complete and checked by reading it.
///
/// # Errors
/// What a robot file does not take: a value beyond what any robot has, a table that begins before the baseplate, a shape other than those of
/// files, a torsional stiffness of its own for a tube without notches.
pub fn write(design: &RobotDesign, friction: Option<Friction>) -> Result<String, Problems> {
    let RobotDesign { name, length, tubes } = design;
    let mut text = format!(
        "name = {}\nlength_mm = {}\n",
        toml::Value::String(name.clone()),
        number(*length, quantity::MM, 1.0)
    );
    let materials: Vec<&Material> = tubes.iter().filter_map(material_of).collect();
    let common = materials.first().filter(|first| materials.iter().all(|m| m == *first));
    if let Some(material) = common {
        text += &material_table("material", material);
    }
    let factor = tubes.first().map_or(1.0, factor_of);
    let one_factor = tubes.iter().all(|tube| factor_of(tube).to_bits() == factor.to_bits());
    if one_factor && factor.to_bits() != 1.0_f64.to_bits() {
        let _ = write!(text, "\n[calibration]\ncentroid_offset_factor = {factor}\n");
    }
    if let Some(Friction { coefficient, guide }) = friction {
        let _ = write!(text, "\n[friction]\ncoefficient = {coefficient:?}\n");
        if let Some(length) = guide {
            let _ = writeln!(text, "guide_mm = {}", number(length, quantity::MM, 1.0));
        }
    }
    for (index, tube) in tubes.iter().enumerate() {
        let _ = write!(text, "\n[[tube]] # {}\n", if index == 0 { "the leader" } else { "a follower" });
        let own_factor = (!one_factor).then(|| factor_of(tube));
        text += &match tube {
            TubeDesign::Notched(tube) => {
                let own = common.is_none().then_some(&tube.material);
                notched(tube, *length, own_factor, own)
                    .map_err(|(what, help)| Problems::of_file(format!("tube {}: {what}", index + 1), help))?
            }
            TubeDesign::Stiffness(tube) => stiffness(tube, *length, own_factor),
        };
    }
    bundle_file::parse_either(&text).map(|_| text)
}

fn material_of(tube: &TubeDesign) -> Option<&Material> {
    match tube {
        TubeDesign::Notched(tube) => Some(&tube.material),
        TubeDesign::Stiffness(_) => None,
    }
}

fn factor_of(tube: &TubeDesign) -> f64 {
    match tube {
        TubeDesign::Notched(tube) => tube.centroid_offset_factor,
        TubeDesign::Stiffness(tube) => tube.centroid_offset_factor,
    }
}

fn material_table(header: &str, material: &Material) -> String {
    let Material { youngs_modulus, poissons_ratio, density, allowable_strain, softening } = *material;
    let modulus = number(youngs_modulus, quantity::GPA, 1.0);
    let mut text = format!("\n[{header}]\nyoungs_modulus_GPa = {modulus}\n");
    // A shear modulus of its own may stand for a ratio that no isotropic material has.
    let _ = if poissons_ratio < 0.5 {
        writeln!(text, "poissons_ratio = {poissons_ratio:?}")
    } else {
        writeln!(text, "shear_modulus_GPa = {}", number(material.shear_modulus(), quantity::GPA, 1.0))
    };
    let _ = writeln!(text, "density_kg_m3 = {density:?}");
    if let Some(strain) = allowable_strain {
        let _ = writeln!(text, "allowable_strain_percent = {}", number(strain, quantity::PERCENT, 1.0));
    }
    if let Some(Softening { tension, compression }) = softening {
        for (side, branch) in [("", tension), ("compression_", compression)] {
            let Branch { onset, modulus, unloading_onset } = branch;
            let _ = writeln!(text, "{side}onset_strain_percent = {}", number(onset, quantity::PERCENT, 1.0));
            let _ = writeln!(text, "{side}second_modulus_GPa = {}", number(modulus, quantity::GPA, 1.0));
            // Compression that does not say it would unload as tension does.
            let unloading_onset = unloading_onset.or(tension.unloading_onset.map(|_| onset));
            if let Some(strain) = unloading_onset {
                let strain = number(strain, quantity::PERCENT, 1.0);
                let _ = writeln!(text, "{side}unloading_onset_strain_percent = {strain}");
            }
        }
    }
    text
}

/// What cannot be written, and what to do.
type Refusal = (&'static str, &'static str);

fn notched(
    tube: &NotchedTube,
    length: f64,
    factor: Option<f64>,
    own_material: Option<&Material>,
) -> Result<String, Refusal> {
    let NotchedTube {
        outline,
        depth,
        direction,
        pattern,
        teeth,
        contact,
        material: _,
        torsion,
        below,
        centroid_offset_factor: _,
    } = tube;
    let (shape, outer, inner) = match *outline {
        Outline::Round { outer_radius, inner_radius } => ("round", outer_radius, inner_radius),
        Outline::Polygon { sides: 4, outer_apothem, inner_apothem } => {
            ("square", outer_apothem, inner_apothem)
        }
        Outline::Polygon { sides: 6, outer_apothem, inner_apothem } => {
            ("hexagon", outer_apothem, inner_apothem)
        }
        Outline::Polygon { .. } => {
            return Err(("a polygon in a file has four or six sides", "Take square or hexagon."));
        }
    };
    let mut text = String::new();
    if shape != "round" {
        let _ = writeln!(text, "shape = \"{shape}\"");
    }
    let _ = writeln!(text, "outer_diameter_mm = {}", number(outer, quantity::MM, 0.5));
    let _ = writeln!(text, "inner_diameter_mm = {}", number(inner, quantity::MM, 0.5));
    text += &factor_line(factor);
    if let Some(material) = own_material {
        text += &material_table("tube.material", material);
    }
    if depth.is_constant() && depth.eval(0.0, length)[0] <= 0.0 {
        return match torsion {
            Torsion::Given(_) => Err((
                "a tube without notches has the torsional stiffness of its section in a file",
                "Give the tube as a StiffnessTube.",
            )),
            _ => Ok(text),
        };
    }
    let _ = writeln!(text, "\n[tube.notches]");
    let _ = writeln!(text, "depth_mm = {}", along("depth_mm", depth, length, pattern.as_ref(), quantity::MM));
    if let Some(NotchPattern { length, tooth, count }) = pattern {
        let _ = writeln!(text, "length_mm = {}", number(*length, quantity::MM, 1.0));
        let _ = writeln!(text, "tooth_mm = {}", number(*tooth, quantity::MM, 1.0));
        let _ = writeln!(text, "count = {count}");
    }
    let _ = writeln!(text, "opening_deg = {}", opening(direction, length, pattern.as_ref()));
    match torsion {
        Torsion::SaintVenant => {}
        Torsion::Polar => text += "torsion = \"polar\"\n",
        Torsion::Given(profile) => {
            let value = along("stiffness_Nmm2", profile, length, None, quantity::NMM2);
            let _ = writeln!(text, "torsion = {{ stiffness_Nmm2 = {value} }}");
        }
    }
    if *below == BelowPlate::Continued {
        text += "below_plate = \"continued\"\n";
    }
    if *contact {
        text += "contact = true\n";
    }
    match teeth {
        TeethStiffness::Flexible => {}
        TeethStiffness::Rigid => text += "teeth = \"rigid\"\n",
        TeethStiffness::Cells(CellTable { cut, corner_radius, tooth_factor, .. }) => {
            text += "teeth = \"cell\"\n";
            if *cut == Cut::Radial {
                text += "cut = \"radial\"\n";
            }
            if let Some(radius) = corner_radius {
                let _ = writeln!(text, "corner_radius_mm = {}", number(*radius, quantity::MM, 1.0));
            }
            if (tooth_factor - 1.0).abs() > 0.0 {
                let _ = writeln!(text, "tooth_factor = {tooth_factor}");
            }
        }
    }
    Ok(text)
}

fn stiffness(tube: &StiffnessTube, length: f64, factor: Option<f64>) -> String {
    let StiffnessTube {
        centroid_offset,
        direction,
        bending_y,
        bending_z,
        torsion,
        axial,
        mass_per_length,
        centroid_offset_factor: _,
    } = tube;
    let mut text = factor_line(factor) + "[tube.stiffness]\n";
    let mut line = |key: &str, profile: &Profile, unit: Unit| {
        let _ = writeln!(text, "{key} = {}", along(key, profile, length, None, unit));
    };
    line("centroid_offset_mm", centroid_offset, quantity::MM);
    line("bending_y_Nmm2", bending_y, quantity::NMM2);
    line("bending_z_Nmm2", bending_z, quantity::NMM2);
    line("torsion_Nmm2", torsion, quantity::NMM2);
    if let Some(axial) = axial {
        line("axial_N", axial, quantity::NEWTON);
    }
    line("mass_per_length_g_m", mass_per_length, quantity::G_M);
    let _ = writeln!(text, "opening_deg = {}", opening(direction, length, None));
    text
}

fn factor_line(factor: Option<f64>) -> String {
    factor.map_or(String::new(), |factor| format!("centroid_offset_factor = {factor}\n"))
}

/// The direction that the notches open to (degrees): half a turn from that of the centroid.
fn opening(direction: &Profile, length: f64, pattern: Option<&NotchPattern>) -> String {
    let back = if direction.eval(0.0, length)[0] > 0.0 { -PI } else { PI };
    along("opening_deg", &direction.shifted(back), length, pattern, quantity::DEG)
}

/// A value along the tube. Points of a spline that are not the middles of the file's notches are written as a table.
fn along(key: &str, profile: &Profile, length: f64, pattern: Option<&NotchPattern>, unit: Unit) -> String {
    let written = |value: &f64| {
        if unit.suffix == quantity::DEG.suffix { degrees(*value) } else { number(*value, unit, 1.0) }
    };
    let list = |values: &[f64], written: &dyn Fn(&f64) -> String| {
        format!("[{}]", values.iter().map(written).collect::<Vec<_>>().join(", "))
    };
    let table = |x: &[f64], values: &[f64]| {
        let x = list(x, &|x| number(*x, quantity::MM, 1.0));
        format!("{{ x_mm = {x}, {key} = {} }}", list(values, &written))
    };
    match profile.made() {
        Made::Constant(value) => written(&value),
        Made::Linear(ends) => list(&ends, &written),
        Made::Table { abscissae, values } => table(abscissae, &values),
        Made::PerNotch { middles, values } if middles.len() == 2 => {
            let slope = (values[1] - values[0]) / (middles[1] - middles[0]);
            let at = |x: f64| values[0] + slope * (x - middles[0]);
            list(&[at(0.0), at(length)], &written)
        }
        Made::PerNotch { middles, values } if pattern.is_some_and(|p| p.middles() == middles) => {
            list(&values, &written)
        }
        Made::PerNotch { .. } => {
            let x: Vec<f64> = (0..=CELLS).map(|i| length * f64::from(i) / f64::from(CELLS)).collect();
            let values: Vec<f64> = x.iter().map(|x| profile.eval(*x, length)[0]).collect();
            table(&x, &values)
        }
    }
}

/// Cells of a table that stands for a spline through other points than the notches.
const CELLS: u32 = 256;

/// An SI value in a unit of the file, of which 1 is `share` of the value.
fn number(value: f64, unit: Unit, share: f64) -> String {
    shortest(value, |text| share * unit.to_si(text))
}

fn degrees(value: f64) -> String {
    shortest(value, f64::to_radians)
}

/// The decimal number with the fewest digits that `read` takes for the value; with all digits where none does so exactly.
fn shortest(value: f64, read: impl Fn(f64) -> f64) -> String {
    let rough = value / read(1.0);
    let candidates = (0..17).map(|digits| format!("{rough:.digits$e}").parse::<f64>().unwrap_or(rough));
    let best = candidates.into_iter().find(|candidate| read(*candidate).to_bits() == value.to_bits());
    format!("{:?}", best.unwrap_or(rough))
}
