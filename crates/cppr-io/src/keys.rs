//! Unknown keys: which known key was meant, and what to write.

use crate::quantity::print;

/// Units that people write in keys: suffix, the suffix of this format, factor from one to the other.
const FOREIGN: [(&str, &str, f64); 25] = [
    ("_um", "_mm", 1e-3),
    ("_cm", "_mm", 10.0),
    ("_dm", "_mm", 100.0),
    ("_m", "_mm", 1000.0),
    ("_in", "_mm", 25.4),
    ("_inch", "_mm", 25.4),
    ("_Pa", "_GPa", 1e-9),
    ("_kPa", "_GPa", 1e-6),
    ("_MPa", "_GPa", 1e-3),
    ("_N_mm2", "_GPa", 1e-3),
    ("_rad", "_deg", 180.0 / std::f64::consts::PI),
    ("_turns", "_deg", 360.0),
    ("_g_cm3", "_kg_m3", 1000.0),
    ("_gcm3", "_kg_m3", 1000.0),
    ("_Ncm2", "_Nmm2", 100.0),
    ("_Nm2", "_Nmm2", 1e6),
    ("_kN", "_N", 1000.0),
    ("_mN", "_N", 1e-3),
    ("_kg_m", "_g_m", 1000.0),
    ("_g_mm", "_g_m", 1000.0),
    ("_mg_mm", "_g_m", 1.0),
    ("_1_mm", "_1_m", 1000.0),
    ("_per_m", "_1_m", 1.0),
    ("_N_m", "_N_mm", 1e-3),
    ("_Nm_rad", "_Nmm_deg", 1000.0 * std::f64::consts::PI / 180.0),
];
/// Suffixes of this format, the longer ones before those that they end with.
const OWN: [&str; 11] =
    ["_Nmm_deg", "_N_mm", "_1_m", "_kg_m3", "_percent", "_g_m", "_Nmm2", "_GPa", "_mm", "_deg", "_N"];

/// Other names for what keys of this format say, without units, and what to do where another name for the key is not all.
/// A name that ends in `*` stands for all that begin so.
const MEANING: [(&[&str], &str, &str); 17] = [
    (&["diameter", "od", "outer_dia", "outside_diameter"], "outer_diameter_mm", ""),
    (&["id", "inner_dia", "bore*", "inside_diameter", "lumen*"], "inner_diameter_mm", ""),
    (&["radius"], "outer_radius_mm", ""),
    (
        &["wall*", "thickness"],
        "inner_diameter_mm",
        "Write inner_diameter_mm, the outer diameter less twice the wall.",
    ),
    (&["e", "modulus", "elastic_modulus", "young*"], "youngs_modulus_GPa", ""),
    (&["nu", "poisson*"], "poissons_ratio", ""),
    (&["rho"], "density_kg_m3", ""),
    (&["mu", "friction*"], "coefficient", ""),
    (&["guide_*"], "guide_mm", ""),
    (
        &["plateau*", "upper_plateau*", "lower_plateau*", "transformation*", "yield*", "onset*"],
        "allowable_strain_percent",
        "A robot of one pattern is linear. Write the modulus below the plateau or yield as youngs_modulus_GPa, and the strain \
         up to which it holds (stress over modulus) as allowable_strain_percent. A bundle softens, at onset_strain_percent to second_modulus_GPa, and unloads from \
         unloading_onset_strain_percent down.",
    ),
    (
        &["max_strain", "strain_limit", "strain", "recoverable_strain", "elongation*"],
        "allowable_strain_percent",
        "",
    ),
    (&["notch_depth", "cut_depth", "slot_depth"], "depth_mm", ""),
    (
        &["width", "notch_length", "notch_width", "cut_length", "cut_width", "slot_*", "height", "gap"],
        "length_mm",
        "",
    ),
    (&["pitch", "period", "spacing"], "tooth_mm", "Write tooth_mm, the pitch less length_mm."),
    (&["tooth_*", "uncut*", "ring_*"], "tooth_mm", ""),
    (&["number*", "n", "notch_count", "n_notches", "num_*"], "count", ""),
    (&["direction*", "orientation*", "angle", "notch_direction", "notch_angle"], "opening_deg", ""),
];

/// What an unknown key is taken for.
pub(crate) struct Guess {
    /// The known key that it stands for, where one is near.
    pub meant: Option<&'static str>,
    pub message: String,
    pub help: String,
}

/// Splits a known key into its stem and unit.
fn split(key: &str) -> (&str, &str) {
    OWN.iter().find_map(|unit| key.strip_suffix(unit).map(|stem| (stem, *unit))).unwrap_or((key, ""))
}

/// Explains an unknown key among the known ones; `value` is its number, where it has a plain one.
pub(crate) fn guess(key: &str, value: Option<f64>, known: &[&'static str]) -> Guess {
    let assign = |known: &str, value: Option<f64>| match value {
        Some(number) => format!("{known} = {}", print(number)),
        None => known.to_owned(),
    };
    for &candidate in known {
        let (stem, unit) = split(candidate);
        if unit.is_empty() {
            continue;
        }
        if key == stem {
            return Guess {
                meant: Some(candidate),
                message: "the unit is missing".to_owned(),
                help: format!("Write {}.", assign(candidate, value)),
            };
        }
        let given = key.strip_prefix(stem).unwrap_or_default();
        if let Some((_, _, factor)) = FOREIGN.iter().find(|(from, to, _)| *from == given && *to == unit) {
            return Guess {
                meant: Some(candidate),
                message: "this unit is not used here".to_owned(),
                help: format!("Write {}.", assign(candidate, value.map(|v| v * factor))),
            };
        }
    }
    let lower = key.to_lowercase();
    if let Some((_, meant, how)) = MEANING.iter().find(|(names, ..)| {
        let stem = FOREIGN.iter().map(|(from, ..)| *from).chain(OWN).find_map(|unit| key.strip_suffix(unit));
        let stem = stem.map_or(lower.clone(), str::to_lowercase);
        names.iter().any(|name| match name.strip_suffix('*') {
            Some(start) => stem.starts_with(start),
            None => stem == *name,
        })
    }) && let Some(meant) = known.iter().find(|candidate| *candidate == meant)
    {
        return Guess {
            meant: Some(meant),
            message: "this key is not known here".to_owned(),
            help: if how.is_empty() { format!("Did you mean {meant}?") } else { (*how).to_owned() },
        };
    }
    // Keys of absurd length would cost quadratic time and resemble nothing.
    let comparable = if key.len() <= 64 { known } else { &[] };
    let near = comparable.iter().copied().map(|candidate| {
        let candidate_lower = candidate.to_lowercase();
        let whole = strsim::damerau_levenshtein(&lower, &candidate_lower);
        let stem = strsim::damerau_levenshtein(&lower, &split(candidate).0.to_lowercase());
        (whole.min(stem + 1), candidate)
    });
    match near.min_by_key(|(distance, _)| *distance) {
        // A third of the letters may be wrong: more of them and the likeness is chance.
        Some((distance, candidate)) if distance <= (candidate.len() + 1) / 3 => Guess {
            meant: Some(candidate),
            message: "this key is not known here".to_owned(),
            help: format!("Did you mean {candidate}?"),
        },
        _ => Guess {
            meant: None,
            message: "this key is not known here".to_owned(),
            help: if known.is_empty() { String::new() } else { format!("Known are {}.", list(known)) },
        },
    }
}

/// "a, b and c".
pub(crate) fn list(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
