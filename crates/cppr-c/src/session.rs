//! A robot's command and its last equilibrium, whichever kind of robot it is.

use crate::asked::{Asked, Misplaced, place, put};
use crate::bundle::Integrated;
use crate::modal::Modal;
use crate::model::Model;
use crate::names::{cppr_field, cppr_input, cppr_option, cppr_value};
use crate::status::cppr_code;
use cppr::bundle::BundleProblem;
use cppr::solve::CommandProblem;
use std::fmt;
use std::sync::Arc;

/// Why a command was refused. Said without allocating.
pub(crate) enum Refused {
    Modal(CommandProblem),
    Bundle(BundleProblem),
    /// A load acts at this label (m) of tube 1, which was drawn in there.
    BehindPlate(f64),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Modal(problem) => write!(f, "{problem}"),
            Self::Bundle(problem) => write!(f, "{problem}"),
            Self::BehindPlate(label) => write!(
                f,
                "a load acts at {:.3} mm on tube 1, which was drawn in behind the plate there; load what stands before it",
                label * 1e3
            ),
        }
    }
}

/// Solver and last equilibrium of either kind of robot.
#[derive(Clone)]
pub(crate) enum Work {
    Modal(Box<Modal>),
    Bundle(Box<Integrated>),
}

/// A command and the last equilibrium.
pub(crate) struct Session {
    pub model: Arc<Model>,
    pub asked: Asked,
    pub work: Work,
    /// Can what the last solve left be read?
    solved: bool,
}

impl Session {
    pub fn new(model: &Arc<Model>) -> Self {
        let work = match &**model {
            Model::Modal { robot, .. } => Work::Modal(Box::new(Modal::new(robot))),
            Model::Bundle(parts) => Work::Bundle(Box::new(Integrated::new(parts))),
        };
        Self { model: Arc::clone(model), asked: Asked::new(model.actuators()), work, solved: false }
    }

    /// The same command at the same equilibrium, with buffers of its own.
    pub fn copied(&self) -> Self {
        let (asked, work) = (self.asked.clone(), self.work.clone());
        Self { model: Arc::clone(&self.model), asked, work, solved: self.solved }
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
        match &mut self.work {
            Work::Modal(own) => own.choose(&self.asked, &asked)?,
            Work::Bundle(own) => own.choose(&asked)?,
        }
        self.asked = asked;
        Ok(())
    }

    /// Solves from rest, or from the last equilibrium found.
    pub fn solve(&mut self, warm: bool) -> Result<cppr_code, Refused> {
        self.solved = false;
        let code = match &mut self.work {
            Work::Modal(own) => own.solve(&self.asked, warm).map_err(Refused::Modal)?,
            Work::Bundle(own) => own.solve(&self.asked, warm)?,
        };
        self.solved = true;
        Ok(code)
    }

    /// Writes a value of the last solve; false where there is none.
    pub fn read(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        self.solved
            && match &mut self.work {
                Work::Modal(own) => own.read(value, out),
                Work::Bundle(own) => own.read(value, out),
            }
    }

    /// Writes a field of the last solve at labels (m); false where there is none.
    pub fn field(&mut self, field: cppr_field, labels: &[f64], out: &mut [f64]) -> bool {
        self.solved
            && match &mut self.work {
                Work::Modal(own) => own.field(field, labels, out),
                Work::Bundle(own) => own.field(field, labels, out),
            }
    }

    /// Greatest label at which fields can be read (m).
    pub fn reach(&self) -> f64 {
        match &self.work {
            Work::Bundle(own) => own.reach().filter(|_| self.solved).unwrap_or(f64::INFINITY),
            Work::Modal(_) => self.model.length(),
        }
    }

    fn is_equilibrium(&self) -> bool {
        match &self.work {
            Work::Modal(own) => own.is_equilibrium(),
            Work::Bundle(own) => own.reach().is_some(),
        }
    }

    /// How the last solve ended, in sentences.
    pub fn explain(&self) -> String {
        match &self.work {
            _ if !self.solved => self.why_not().into(),
            Work::Modal(own) => own.explain(),
            Work::Bundle(own) => own.explain(),
        }
    }

    /// Why a value cannot be read.
    pub fn why_not(&self) -> &'static str {
        match &self.work {
            _ if !self.solved => "nothing has been solved yet, or the last command was refused",
            _ if !self.is_equilibrium() => "the last solve found no equilibrium",
            Work::Modal(_) => {
                "the equilibrium stands at a fold, where it has no derivative, or the formulation printed in the paper does not have it"
            }
            Work::Bundle(_) => {
                "the equilibrium stands at a fold, where it has no derivative, or robots of parts and joints do not have it"
            }
        }
    }

    /// What of the command looks like a mistaken unit.
    pub fn doubt(&self) -> Option<String> {
        match &self.work {
            Work::Modal(own) => own.doubt(&self.asked.command),
            Work::Bundle(own) => own.doubt(&self.asked),
        }
    }
}
