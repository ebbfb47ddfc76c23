//! `[material]` of the robot and `[tube.material]`, whose keys take the place of the robot's.

use crate::cursor::{Cursor, Field};
use crate::problems::Collector;
use crate::quantity::{DENSITY, MODULUS, ONSET, POISSON, STRAIN, print};
use cppr::design::{Branch, Material, Softening};
use std::ops::Range;

const KEYS: [&str; 11] = [
    "youngs_modulus_GPa",
    "poissons_ratio",
    "shear_modulus_GPa",
    "density_kg_m3",
    "allowable_strain_percent",
    "onset_strain_percent",
    "second_modulus_GPa",
    "compression_onset_strain_percent",
    "compression_second_modulus_GPa",
    "unloading_onset_strain_percent",
    "compression_unloading_onset_strain_percent",
];
/// Keys of a material that softens; the mechanics of bundles takes them.
pub(crate) const SOFTENING: [&str; 6] = [KEYS[5], KEYS[6], KEYS[7], KEYS[8], KEYS[9], KEYS[10]];

/// What one table says.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Written {
    youngs_modulus: Field,
    poissons_ratio: Field,
    shear_modulus: Field,
    density: Field,
    allowable_strain: Field,
    /// Onset and second modulus, under tension and under compression, and the onsets of unloading.
    softening: [Field; 6],
}

impl Written {
    /// Reads the table `material` of a cursor, where there is one.
    pub fn read(parent: &Cursor<'_, '_>, out: &mut Collector) -> Self {
        let Some(cursor) = parent.child("material", &KEYS, out) else {
            return Self::default();
        };
        let written = Self {
            youngs_modulus: cursor.field("youngs_modulus_GPa", &MODULUS, out),
            poissons_ratio: cursor.field("poissons_ratio", &POISSON, out),
            shear_modulus: cursor.field("shear_modulus_GPa", &MODULUS, out),
            density: cursor.field("density_kg_m3", &DENSITY, out),
            allowable_strain: cursor.field("allowable_strain_percent", &STRAIN, out),
            softening: [
                cursor.field(SOFTENING[0], &ONSET, out),
                cursor.field(SOFTENING[1], &MODULUS, out),
                cursor.field(SOFTENING[2], &ONSET, out),
                cursor.field(SOFTENING[3], &MODULUS, out),
                cursor.field(SOFTENING[4], &ONSET, out),
                cursor.field(SOFTENING[5], &ONSET, out),
            ],
        };
        if let (Some(ratio), Some(entry)) = (written.poissons_ratio.value, cursor.get("poissons_ratio"))
            && !(ratio > -1.0 && ratio < 0.5)
        {
            let message = format!("Poisson's ratio lies between -1 and 0.5, and this is {}", print(ratio));
            entry.wrong(message, "Write a number in between, such as 0.35.", out);
        }
        if let (true, Some(entry)) = (written.poissons_ratio.present, cursor.get("shear_modulus_GPa")) {
            let message = "Poisson's ratio is given too, and either of them fixes the other";
            entry.wrong(message, "Keep one of poissons_ratio and shear_modulus_GPa.", out);
        }
        written
    }
}

/// The robot's material and what was already said about its gaps.
#[derive(Clone, Debug)]
pub(crate) struct Common {
    written: Written,
    /// Where to report what is missing.
    span: Range<usize>,
    reported: Vec<&'static str>,
}

impl Common {
    pub fn read(root: &Cursor<'_, '_>, out: &mut Collector) -> Self {
        let written = Written::read(root, out);
        let entry = root.get("material");
        // A [material] that is misspelt or no table has its own problem: its keys are not missing.
        let broken = root.has("material") && !entry.as_ref().is_some_and(|e| e.value.is_table());
        let span = entry.map_or(root.span(), |e| e.key_span);
        let reported = if broken { KEYS.to_vec() } else { Vec::new() };
        Self { written, span, reported }
    }

    /// The material of a tube.
    pub fn resolve(&mut self, own: &Written, out: &mut Collector) -> Option<Material> {
        let common = self.written;
        let pick = |own: Field, common: Field| if own.present { own } else { common };
        let modulus = pick(own.youngs_modulus, common.youngs_modulus);
        let density = pick(own.density, common.density);
        let allowable_strain = pick(own.allowable_strain, common.allowable_strain).value;
        // Ratio and shear modulus say the same thing: a tube that gives one overrides both.
        let shear = if own.poissons_ratio.present || own.shear_modulus.present { own } else { &common };
        let has_shear = shear.poissons_ratio.present || shear.shear_modulus.present;
        self.need(modulus.present, "youngs_modulus_GPa", "Write youngs_modulus_GPa = 5.39.", out);
        let help = "Write poissons_ratio = 0.35, or shear_modulus_GPa if that is what is known.";
        self.need(has_shear, "poissons_ratio", help, out);
        let help = "Write density_kg_m3 = 1240, or 0 for a robot without weight.";
        self.need(density.present, "density_kg_m3", help, out);
        let youngs_modulus = modulus.value?;
        let poissons_ratio = match shear.shear_modulus.value {
            Some(shear_modulus) => youngs_modulus / (2.0 * shear_modulus) - 1.0,
            None => shear.poissons_ratio.value?,
        };
        let softening = self.softening(own, youngs_modulus, out)?;
        Some(Material {
            youngs_modulus,
            poissons_ratio,
            density: density.value?,
            allowable_strain,
            softening,
        })
    }

    /// How a tube's material softens, `Some(None)` where it does not. Compression is as tension where it is not said; it unloads from the same part of its onset
    /// on.
    #[allow(clippy::option_option)] // The outer one is a problem.
    fn softening(
        &mut self,
        own: &Written,
        youngs_modulus: f64,
        out: &mut Collector,
    ) -> Option<Option<Softening>> {
        let all: [Field; 6] = std::array::from_fn(|i| {
            if own.softening[i].present { own.softening[i] } else { self.written.softening[i] }
        });
        if !all.iter().any(|field| field.present) {
            return Some(None);
        }
        let [onset, modulus, other_onset, other_modulus, unloading, other_unloading] = all;
        self.need(onset.present, SOFTENING[0], "Write onset_strain_percent = 1.5.", out);
        self.need(modulus.present, SOFTENING[1], "Write second_modulus_GPa = 3.2.", out);
        // Outer `None`: its value is a problem.
        let of_unloading = |field: Field| if field.present { field.value.map(Some) } else { Some(None) };
        let tension = Branch {
            onset: onset.value?,
            modulus: modulus.value?,
            unloading_onset: of_unloading(unloading)?,
        };
        let as_tension = |field: Field, tension: f64| if field.present { field.value } else { Some(tension) };
        let onset = as_tension(other_onset, tension.onset)?;
        let like_tension = tension.unloading_onset.map(|strain| strain * (onset / tension.onset));
        let compression = Branch {
            onset,
            modulus: as_tension(other_modulus, tension.modulus)?,
            unloading_onset: of_unloading(other_unloading)?.or(like_tension),
        };
        for (branch, key) in [(tension, SOFTENING[4]), (compression, SOFTENING[5])] {
            if let Some(strain) = branch.unloading_onset.filter(|strain| *strain > branch.onset) {
                let [strain, onset] = [strain, branch.onset].map(|own| print(own * 1e2));
                let message = format!(
                    "a metal unloads below the stress at which it softens, and {strain} % is above its onset of {onset} %"
                );
                let key = format!("material.{key}");
                let help = "Write the stress at which the lower plateau ends, over Young's modulus.";
                out.wrong(self.span.clone(), key, message, help);
                return None;
            }
        }
        for (branch, key) in [(tension, SOFTENING[1]), (compression, SOFTENING[3])] {
            if branch.modulus > youngs_modulus {
                let message = format!(
                    "a metal softens, and {} GPa is more than its Young's modulus",
                    print(branch.modulus * 1e-9)
                );
                let key = format!("material.{key}");
                out.wrong(
                    self.span.clone(),
                    key,
                    message,
                    "Write the slope beyond the onset, below Young's modulus.",
                );
                return None;
            }
        }
        Some(Some(Softening { tension, compression }))
    }

    /// Reports a key that no table gives, once per file.
    fn need(&mut self, present: bool, key: &'static str, help: &str, out: &mut Collector) {
        if !present && !self.reported.contains(&key) {
            self.reported.push(key);
            let message = "this key is missing";
            out.missing(
                self.span.clone(),
                format!("material.{key}"),
                message,
                format!("{help} It belongs under [material]."),
            );
        }
    }
}
