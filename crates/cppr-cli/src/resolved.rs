//! How exactly equilibria are solved: what is asked for, what is reached, and what is said of it.

use crate::Failure;
use crate::command::{described, no_equilibrium};
use crate::output::note;
use crate::rubbing::FrictionArgs;
use crate::table::plain;
use cppr::analysis::{ACCURACY, Accuracy, Against, Followed};
use cppr::bundle::Friction;
use cppr::solve::{Command, Equilibrium, Settings, Solver, Status};
use cppr_io::bundle_file::Described;
use cppr_io::result::AccuracyRecord;
use serde_json::{Value, json};
use std::path::Path;

/// How exactly to solve; shared by all sub-commands that solve.
#[derive(Clone, clap::Args)]
pub struct AccuracyArgs {
    /// Error of the tip that is accepted, as a part of the robot's length: where the usual modes exceed it, twice or four times as many are
    /// taken. Modes chosen by --modes or --refine stay as they are
    #[arg(long, value_name = "PART", default_value_t = ACCURACY, value_parser = part_of_length)]
    accuracy: f64,
    /// Integrate along the robot instead of taking modes: for fields that change faster than modes follow, and for many loads. So it is by itself for a robot
    /// with sudden changes along it, unless an option is given that only modes have (--refine, --modes, --planar, --formulation, --relative-angle)
    #[arg(long)]
    integrate: bool,
}

fn part_of_length(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(part) if 0.0 < part && part <= 1.0 => Ok(part),
        _ => Err("write a part of the length above 0 and up to 1, for instance 1e-4".into()),
    }
}

impl AccuracyArgs {
    /// Reads a robot file. What is to be integrated is described as parts and joints: robots for which that is asked for, and those with sudden changes
    /// that modes do not follow, unless `keeps_modes`: unless something is asked for that only modes have.
    pub fn described(&self, path: &Path, keeps_modes: bool) -> Result<Described, Failure> {
        let own = described(path)?;
        if self.integrate {
            return Ok(Described::Bundle { friction: own.friction(), design: own.into_bundle() });
        }
        if keeps_modes {
            return Ok(own);
        }
        let (robot, sudden) = own.integrated();
        if let Some(places) = sudden {
            note(&format!(
                "{}: modes do not follow sudden changes ({places}): integrated along the robot, as with --integrate\n",
                path.display()
            ));
        }
        Ok(robot)
    }

    /// The same with the friction that is asked for, with which every robot is integrated.
    pub fn rubbing(
        &self,
        path: &Path,
        keeps_modes: bool,
        args: FrictionArgs,
    ) -> Result<(Described, Option<Friction>), Failure> {
        let friction = args.alone(described(path)?.friction())?;
        let own = Self { integrate: self.integrate || friction.is_some(), ..*self };
        Ok((own.described(path, keeps_modes)?, friction))
    }

    /// Solves from rest; where that finds no stable equilibrium, follows the path of equilibria from rest to the command. What is found may be no equilibrium.
    pub fn solve(solver: &mut Solver, command: &Command) -> Result<Followed, Failure> {
        let equilibrium = solver.solve(command).map_err(|p| Failure::Input(p.to_string()))?;
        let found = Followed { equilibrium, folds: Vec::new() };
        if found.equilibrium.status() == Status::Converged {
            return Ok(found);
        }
        Ok(solver.follow(command).unwrap_or(found))
    }

    /// The same with as many modes as it needs, which the solver keeps.
    pub fn solve_resolved(&self, solver: &mut Solver, command: &Command) -> Result<Resolved, Failure> {
        let Followed { equilibrium, folds } = Self::solve(solver, command)?;
        if !equilibrium.status().is_equilibrium() {
            return Err(no_equilibrium(&equilibrium));
        }
        Ok(Resolved { folds, ..self.resolve(solver, equilibrium)? })
    }

    /// Takes more modes where an equilibrium found from rest needs them. The solver keeps them.
    pub fn resolve(&self, solver: &mut Solver, found: Equilibrium) -> Result<Resolved, Failure> {
        let wanted = self.accepted(solver.settings());
        let modes = found.settings().resolution;
        let (found, accuracy) = solver.resolve(found, wanted).map_err(|p| Failure::Input(p.to_string()))?;
        let settings = *found.settings();
        solver.set_settings(settings).map_err(|p| Failure::Input(p.to_string()))?;
        let factor = settings.resolution.nodes / modes.nodes;
        Ok(Resolved { found, accuracy, wanted, factor, folds: Vec::new() })
    }

    /// What a search finds, once more where the equilibrium in it needs more modes.
    pub fn search<T>(
        &self,
        solver: &mut Solver,
        mut find: impl FnMut(&mut Solver) -> Result<T, Failure>,
        equilibrium: impl Fn(&T) -> &Equilibrium,
    ) -> Result<(T, Resolved), Failure> {
        let answer = find(solver)?;
        let resolved = self.resolve(solver, equilibrium(&answer).clone())?;
        if resolved.factor == 1 {
            return Ok((answer, resolved));
        }
        let answer = find(solver)?;
        let found = equilibrium(&answer).clone();
        let accuracy = solver.accuracy(&found);
        Ok((answer, Resolved { found, accuracy, ..resolved }))
    }

    /// Error of the tip that is accepted with some settings, as a part of the length; infinite where the modes were chosen.
    pub fn accepted(&self, settings: &Settings) -> f64 {
        if settings.modes_are_chosen() { f64::INFINITY } else { self.accuracy }
    }
}

/// An equilibrium with as many modes as the accuracy asks for.
pub struct Resolved {
    pub found: Equilibrium,
    pub accuracy: Option<Accuracy>,
    /// Error of the tip that is accepted, as a part of the length; infinite where the modes were chosen.
    wanted: f64,
    /// How many times as many modes as usual were taken.
    factor: usize,
    /// Parts of the command at which the path from rest turns back.
    pub folds: Vec<f64>,
}

impl Resolved {
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

    /// Accuracy and warning, each with its head.
    pub fn lines(&self) -> impl Iterator<Item = (&'static str, String)> {
        let warnings = self.warning().into_iter().chain(self.snap());
        std::iter::once(("accuracy", self.text())).chain(warnings.map(|text| ("warning", text)))
    }

    /// That the robot snaps on its way.
    pub fn snap(&self) -> Option<String> {
        let first = self.folds.first()?;
        Some(format!(
            "driven from rest the robot snaps at {} % of this command; this stable shape lies beyond, where the path of equilibria leads past its folds",
            plain(100.0 * first, 1)
        ))
    }

    /// For the JSON; null where the error is not known.
    pub fn json(&self) -> Value {
        json!(self.accuracy.map(|own| AccuracyRecord::new(self.found.robot(), &own)))
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
                    "; integrated without modes (--integrate) its tip is at {} {} {} mm",
                    plain(x, 3),
                    plain(y, 3),
                    plain(z, 3)
                )
            }
            Against::HalfTheModes => "; --integrate solves without modes".into(),
        };
        Some(format!(
            "the tip is within {part:.0e} of the length only, not {:.0e}: the fields of this robot change faster along it than its modes \
             follow{better}",
            self.wanted
        ))
    }
}

/// The greatest error among some poses as a line of a summary.
pub fn told(error: f64, known: usize, poses: &str, accepted: f64) -> String {
    let more = if error > accepted {
        format!("; more than {accepted:.0e}: --refine takes more modes, --integrate none")
    } else {
        String::new()
    };
    format!("  tip within {error:.0e} of the length in {known} {poses} looked at{more}\n")
}

/// One digit that counts, without an exponent where that is short; nothing is known better than to within 1e-9.
fn digits(value: f64) -> String {
    if value < 1e-4 { format!("{:.0e}", value.max(1e-9)) } else { plain(value, 4) }
}
