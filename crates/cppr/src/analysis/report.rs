//! Limits in words: where a notch is, and what a pose asks beyond what is allowed.

use super::limits::{Governing, Limit, Place, SectionLimit};
use std::fmt;

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Strain => "strain",
            Self::Closure => "closure",
            Self::Torsion => "torsion",
            Self::Stability => "stability",
        })
    }
}

impl SectionLimit {
    /// Which notch of which tube, such as `tube 2 notch 7 (x = 61.5 mm)`.
    #[must_use]
    pub fn whereabouts(&self) -> String {
        let (tube, x) = (self.tube, self.abscissa * 1e3);
        // −0.0 reads as a finding; it is none.
        let x = if x.abs() < 0.05 { 0.0 } else { x };
        match self.place {
            Place::Notch(number) => format!("tube {tube} notch {number} (x = {x:.1} mm)"),
            Place::Section => format!("tube {tube} at x = {x:.1} mm"),
            Place::Uncut => format!("tube {tube}, uncut part at x = {x:.1} mm"),
        }
    }
}

impl Governing {
    /// What the pose would do to its nearest limit, as a clause; empty while the limit is kept.
    #[must_use]
    pub fn exceeded(&self) -> String {
        if self.utilisation <= 1.0 {
            return String::new();
        }
        let used = 100.0 * self.utilisation;
        match (self.limit, &self.section) {
            (Limit::Strain, Some(section)) => {
                let (place, strain) = (section.whereabouts(), 100.0 * section.strain);
                format!("{place} would be strained by {strain:.1} %, {used:.0} % of what is allowed")
            }
            (Limit::Torsion, Some(section)) => {
                let (place, shear) = (section.whereabouts(), 100.0 * section.shear);
                format!("{place} would be sheared by {shear:.1} %, {used:.0} % of what is allowed")
            }
            (Limit::Closure, Some(section)) => {
                format!("{} would close by {used:.0} %, but its teeth touch at 100 %", section.whereabouts())
            }
            _ => "the equilibrium is unstable".into(),
        }
    }
}
