//! A robot, its solver and its last equilibrium. With `asked`, `values` and `poses` this is all that calls the mechanics.

use crate::asked::{Asked, Misplaced, place, put};
use crate::names::{cppr_field, cppr_input, cppr_option, cppr_value};
use crate::status::cppr_code;
use crate::values::Reader;
use cppr::analysis::{Sensitivity, absurd_demand, explained};
use cppr::design::Robot;
use cppr::solve::{CommandProblem, Equilibrium, Solver, Status};
use cppr_io::robot_file;
use cppr_sweep::Memory;
use std::sync::Arc;

/// A robot and the buffers of its calls for many poses.
pub(crate) struct Model {
    pub robot: Robot,
    pub memory: Memory,
}

impl Model {
    pub fn from_file(path: &str) -> Result<Self, String> {
        let robot = cppr_io::read_robot(path).map_err(|problems| problems.to_string())?;
        Ok(Self { robot, memory: Memory::new() })
    }

    pub fn from_text(text: &str) -> Result<Self, String> {
        let design = robot_file::parse(text).map_err(|problems| problems.to_string())?.design;
        let robot = Robot::from_design(design).map_err(|problems| problems.to_string())?;
        Ok(Self { robot, memory: Memory::new() })
    }

    pub fn name(&self) -> &str {
        &self.robot.design().name
    }

    pub fn length(&self) -> f64 {
        self.robot.length()
    }

    pub fn tubes(&self) -> usize {
        self.robot.tube_count()
    }

    pub fn is_planar(&self) -> bool {
        self.robot.is_planar()
    }

    /// Place of a tube's actuator in a command.
    pub fn actuator(&self, tube: u32) -> Result<usize, Misplaced> {
        let tubes = self.tubes();
        let index = usize::try_from(tube).ok().filter(|tube| (1..=tubes).contains(tube));
        match index {
            None => Err(Misplaced::NoTube { tube, tubes }),
            Some(tube) => self.robot.followers().position(|own| own == tube).ok_or(Misplaced::Leader),
        }
    }
}

/// A command and the last equilibrium.
pub(crate) struct Session {
    pub model: Arc<Model>,
    pub asked: Asked,
    pub solver: Solver,
    rest: Equilibrium,
    /// The last one found: where a warm start starts.
    found: Equilibrium,
    /// What the last solve left, and whether it can be read.
    result: Equilibrium,
    solved: bool,
    sensitivity: Sensitivity,
    derived: Option<bool>,
}

impl Session {
    pub fn new(model: &Arc<Model>) -> Self {
        let asked = Asked::new(&model.robot);
        let mut solver = Solver::new(&model.robot);
        let rest = solver.rest();
        Self {
            model: Arc::clone(model),
            asked,
            solver,
            found: rest.clone(),
            result: rest.clone(),
            rest,
            solved: false,
            sensitivity: Sensitivity::default(),
            derived: None,
        }
    }

    /// The same command at the same equilibrium, with buffers of its own.
    pub fn copied(&self) -> Self {
        Self {
            asked: self.asked.clone(),
            solver: self.solver.clone(),
            rest: self.rest.clone(),
            found: self.found.clone(),
            result: self.result.clone(),
            solved: self.solved,
            ..Self::new(&self.model)
        }
    }

    pub fn put(&mut self, input: cppr_input, tube: u32, value: f64) -> Result<(), Misplaced> {
        let place = place(&self.model, input, tube)?;
        self.asked.provide(input);
        put(&mut self.asked.command, input, place, value);
        Ok(())
    }

    pub fn hold(&mut self) {
        self.asked.hold();
    }

    /// Sets an option, or says why it cannot be.
    pub fn choose(&mut self, option: cppr_option, value: f64) -> Result<(), String> {
        let mut asked = self.asked.clone();
        if !asked.choose(option, value) {
            return Err("see its range in cppr_option".into());
        }
        self.solver.set_settings(asked.settings).map_err(|problem| problem.to_string())?;
        if asked.settings.resolution != self.asked.settings.resolution {
            self.rest = self.solver.rest();
        }
        self.asked = asked;
        Ok(())
    }

    /// Solves from rest, or from the last equilibrium found.
    pub fn solve(&mut self, warm: bool) -> Result<cppr_code, CommandProblem> {
        let Self { asked, solver, rest, found, result, .. } = self;
        (self.solved, self.derived) = (false, None);
        match (warm, result.status().is_equilibrium()) {
            (true, true) => {}
            (true, false) => result.copy(found),
            (false, _) => result.copy(rest),
        }
        solver.solve_into(&asked.command, result)?;
        self.solved = true;
        if result.status().is_equilibrium() {
            found.copy(result);
        }
        Ok(match result.status() {
            Status::Converged => cppr_code::Ok,
            Status::Unstable => cppr_code::Unstable,
            Status::NotConverged(_) => cppr_code::NoEquilibrium,
        })
    }

    /// Writes a value of the last solve; false where there is none.
    pub fn read(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let Self { solver, result, sensitivity, derived, .. } = self;
        if !self.solved {
            return false;
        }
        let mut reader = Reader { solver, found: result, pose: None, sensitivity, derived };
        reader.read(value, out)
    }

    /// Writes a field of the last solve at labels of the leader (m); false where there is no equilibrium.
    pub fn field(&mut self, field: cppr_field, labels: &[f64], out: &mut [f64]) -> bool {
        if !(self.solved && self.result.status().is_equilibrium()) {
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

    /// How the last solve ended, in sentences.
    pub fn explain(&self) -> String {
        if self.solved {
            explained(&self.model.robot, self.result.command(), self.result.status())
        } else {
            self.why_not().into()
        }
    }

    /// Why a value cannot be read.
    pub fn why_not(&self) -> &'static str {
        if !self.solved {
            "nothing has been solved yet, or the last command was refused"
        } else if self.result.status().is_equilibrium() {
            "the equilibrium stands at a fold, where it has no derivative, or the formulation printed in the paper does not have it"
        } else {
            "the last solve found no equilibrium"
        }
    }

    /// What of the command looks like a mistaken unit.
    pub fn doubt(&self) -> Option<String> {
        absurd_demand(&self.model.robot, &self.asked.command).map(|demand| demand.to_string())
    }
}
