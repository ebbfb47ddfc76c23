//! The modal solver of a robot, and its last equilibrium. With `bundle`, `values` and `poses` this is all that calls the mechanics.

use crate::asked::{Asked, LOOP_TOLERANCE};
use crate::names::{cppr_field, cppr_value};
use crate::status::cppr_code;
use crate::values::Reader;
use cppr::analysis::{Sensitivity, absurd_demand, explained};
use cppr::design::Robot;
use cppr::solve::{Command, CommandProblem, Equilibrium, Settings, Solver, Status};

/// Solver and equilibria.
#[derive(Clone)]
pub(crate) struct Modal {
    pub solver: Solver,
    rest: Equilibrium,
    /// The last one found: where a warm start starts.
    found: Equilibrium,
    /// What the last solve left.
    result: Equilibrium,
    sensitivity: Sensitivity,
    derived: Option<bool>,
    /// Settings that were asked for, and those with as many modes as the accuracy needed then.
    taken: Option<[Settings; 2]>,
}

impl Modal {
    pub fn new(robot: &Robot) -> Self {
        let mut solver = Solver::new(robot);
        let rest = solver.rest();
        let (found, result) = (rest.clone(), rest.clone());
        Self { solver, rest, found, result, sensitivity: Sensitivity::default(), derived: None, taken: None }
    }

    /// Takes over new settings, or says why they cannot be.
    pub fn choose(&mut self, before: &Asked, asked: &Asked) -> Result<(), String> {
        if asked.loop_tolerance.to_bits() != LOOP_TOLERANCE.to_bits() {
            return Err("nothing is integrated in the loops of a robot with modes".into());
        }
        self.solver.set_settings(asked.settings).map_err(|problem| problem.to_string())?;
        if asked.settings.resolution != before.settings.resolution {
            self.rest = self.solver.rest();
        }
        Ok(())
    }

    /// Solves from rest, or from the last equilibrium found.
    pub fn solve(&mut self, asked: &Asked, warm: bool) -> Result<cppr_code, CommandProblem> {
        let Self { solver, rest, found, result, derived, taken, .. } = self;
        *derived = None;
        let adapts = asked.accuracy > 0.0;
        let settings = match *taken {
            Some([usual, finer]) if adapts && warm && usual == asked.settings => finer,
            _ => asked.settings,
        };
        take(solver, settings);
        match (warm, result.status().is_equilibrium()) {
            (true, true) => {}
            (true, false) => result.copy(found),
            (false, _) => result.copy(rest),
        }
        solver.solve_into(&asked.command, result)?;
        if adapts && !warm {
            *result = solver.resolve(result.clone(), asked.accuracy)?.0;
            *taken = Some([asked.settings, *result.settings()]);
            take(solver, *result.settings());
        }
        if result.status().is_equilibrium() {
            found.copy(result);
        }
        Ok(match result.status() {
            Status::Converged => cppr_code::Ok,
            Status::Unstable => cppr_code::Unstable,
            Status::NotConverged(_) => cppr_code::NoEquilibrium,
        })
    }

    /// A solver for many poses, with as many modes as the accuracy needs in some of them.
    pub fn for_many(&self, asked: &Asked, some: &[Command]) -> Solver {
        let mut solver = self.solver.clone();
        take(&mut solver, asked.settings);
        if asked.accuracy > 0.0 {
            let settings = solver.settings_for(some, asked.accuracy).settings;
            take(&mut solver, settings);
        }
        solver
    }

    /// How many times as many modes as `usual` some commands need or bear with; `None` where no error is known.
    pub fn fewest_modes(&self, usual: &Asked, commands: &[Command], accuracy: f64) -> Option<f64> {
        let mut solver = self.solver.clone();
        take(&mut solver, usual.settings);
        let found = solver.fewest_modes(commands, accuracy);
        (found.known > 0).then_some(())?;
        found.settings.resolution.multiple_of(usual.settings.resolution)
    }

    /// Writes a value of the last solve; false where there is none.
    pub fn read(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let Self { solver, result, sensitivity, derived, .. } = self;
        let mut reader = Reader { solver, found: result, pose: None, sensitivity, derived };
        reader.read(value, out)
    }

    /// Writes a field of the last solve at labels of the leader (m); false where there is no equilibrium.
    pub fn field(&mut self, field: cppr_field, labels: &[f64], out: &mut [f64]) -> bool {
        if !self.is_equilibrium() {
            return false;
        }
        let shape = self.solver.shape_at(&self.result, labels);
        let mut cells = out.iter_mut();
        let mut write = |values: &[f64]| cells.by_ref().zip(values).for_each(|(cell, value)| *cell = *value);
        for section in &shape.sections {
            let tubes = &section.tubes;
            match field {
                cppr_field::Centre => write(section.centre.as_slice()),
                // Column by column is the transpose row by row.
                cppr_field::Rotation => write(section.rotation.transpose().as_slice()),
                cppr_field::Curvature => write(section.curvature.as_slice()),
                cppr_field::Abscissa => tubes.iter().for_each(|tube| write(&[tube.abscissa])),
                cppr_field::Centroid => tubes.iter().for_each(|tube| write(tube.centroid.as_slice())),
                cppr_field::Moment => tubes.iter().for_each(|tube| write(tube.moment.as_slice())),
                cppr_field::Force => tubes.iter().for_each(|tube| write(tube.force.as_slice())),
                cppr_field::EnergyDensity => write(&[section.energy_density]),
            }
        }
        true
    }

    pub fn is_equilibrium(&self) -> bool {
        self.result.status().is_equilibrium()
    }

    pub fn explain(&self) -> String {
        explained(self.result.robot(), self.result.command(), self.result.status())
    }

    pub fn doubt(&self, command: &Command) -> Option<String> {
        absurd_demand(self.result.robot(), command).map(|demand| demand.to_string())
    }
}

/// Brings a solver to settings that it has had before, and so does not refuse.
fn take(solver: &mut Solver, settings: Settings) {
    if *solver.settings() != settings {
        let _ = solver.set_settings(settings);
    }
}
