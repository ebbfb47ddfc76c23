//! An equilibrium with its discretisation error, and what is said of it.

use crate::Failure;
use crate::table::plain;
use cppr::analysis::{Accuracy, Against};
use cppr::kinematics::Resolution;
use cppr::solve::{Equilibrium, Solver, Status};

/// An equilibrium with as many modes as the accuracy asks for.
pub struct Resolved {
    pub found: Equilibrium,
    pub accuracy: Option<Accuracy>,
    /// Error of the tip that is accepted, as a part of the length; infinite where the modes were chosen.
    wanted: f64,
    /// How many times as many modes as usual were taken.
    factor: usize,
}

impl Resolved {
    /// Takes more modes where an equilibrium found from rest needs them. Modes that somebody chose stay.
    pub fn new(solver: &mut Solver, found: Equilibrium, wanted: f64) -> Result<Self, Failure> {
        let modes = found.settings().resolution;
        let usual = Resolution { stretch: 0, ..modes };
        let chosen = usual != Resolution::SPATIAL && usual != Resolution::PLANAR;
        let wanted = if chosen { f64::INFINITY } else { wanted };
        let (found, accuracy) = solver.resolve(found, wanted).map_err(|p| Failure::Input(p.to_string()))?;
        let factor = found.settings().resolution.nodes / modes.nodes;
        Ok(Self { found, accuracy, wanted, factor })
    }

    /// The error in words.
    pub fn text(&self) -> String {
        let Some(Accuracy { tip, force, torque, against, .. }) = self.accuracy else {
            return "not known".into();
        };
        let part = tip / self.found.robot().length();
        let against = match against {
            Against::Integration => "",
            Against::HalfTheModes => "; against half the modes",
        };
        let modes = match self.factor {
            1 => String::new(),
            n => format!("; {n} times as many modes as usual"),
        };
        format!(
            "tip within {part:.0e} of the length, forces within {} N, torques within {} N mm{against}{modes}",
            digits(force),
            digits(torque * 1e3)
        )
    }

    /// What is missing to the accuracy that was asked for.
    pub fn warning(&self) -> Option<String> {
        let own = self.accuracy?;
        if !own.confirms(self.found.status()) {
            let (own, other) = match self.found.status() {
                Status::Converged => ("stable", "unstable"),
                _ => ("unstable", "stable"),
            };
            return Some(format!(
                "{own} by its modes, {other} where it is integrated without modes: the robot is next to a snap; --refine 4 may settle it"
            ));
        }
        let part = own.tip / self.found.robot().length();
        if part <= self.wanted {
            return None;
        }
        let better = match own.against {
            Against::Integration => {
                let [x, y, z] = (own.reference * 1e3).into();
                format!(
                    "; integrated without modes its tip is at {} {} {} mm",
                    plain(x, 3),
                    plain(y, 3),
                    plain(z, 3)
                )
            }
            Against::HalfTheModes => "; --refine 8 gives more".into(),
        };
        Some(format!(
            "the tip is within {part:.0e} of the length only, not {:.0e}: the fields of this robot change faster along it than its modes \
             follow{better}",
            self.wanted
        ))
    }
}

/// One digit that counts, without an exponent where that is short; nothing is known better than to within 1e-9.
fn digits(value: f64) -> String {
    if value < 1e-4 { format!("{:.0e}", value.max(1e-9)) } else { plain(value, 4) }
}
