//! What a pose asks beyond the limits of the robot, which the mechanics does not know: it bends notches on after their teeth have met.
//! Strain, closure and shear over what is allowed, per notch, as `cppr::analysis::limits` has them; and the greatest part of the command, in
//! [0, 1] from rest, that keeps all limits.

use crate::limits;
use crate::table::plain;
use cppr::analysis::{Governing, Teeth, governing};
use cppr::solve::{Command, Drive, Equilibrium, Solver};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// The limit of a notch or section that a pose exceeds most.
pub struct Exceeded {
    limit: Governing,
    /// Greatest part of the command, from rest, that keeps all limits.
    safe: f64,
    command: Command,
    /// What that part took to find.
    pub time: Duration,
}

impl Exceeded {
    /// `None` within all limits. Stability is for the status to tell.
    pub fn of(solver: &mut Solver, found: &Equilibrium, teeth: Teeth) -> Option<Self> {
        let sections = solver.section_limits(found, teeth);
        let limit = governing(&sections, None).filter(|worst| worst.utilisation > 1.0)?;
        let (command, start) = (found.command().clone(), Instant::now());
        let safe = solver.safe_part(&command, teeth).ok()?.value;
        Some(Self { limit, safe, command, time: start.elapsed() })
    }

    /// In a sentence.
    pub fn text(&self) -> String {
        format!("{}; all limits are kept up to {}", self.limit.exceeded(), self.safe())
    }

    /// The value of a command that has no other, or a part of the whole.
    fn safe(&self) -> String {
        let drives = self.command.actuators.iter().zip(2..);
        let only: Vec<(usize, bool, Drive)> = drives
            .flat_map(|(actuator, tube)| [(tube, false, actuator.push_pull), (tube, true, actuator.rotation)])
            .filter(|(.., drive)| drive.value().abs() > 0.0)
            .collect();
        let (true, &[(tube, turns, drive)]) = (self.command.loads.is_empty(), &only[..]) else {
            return format!("{} % of this command", plain(100.0 * self.safe, 1));
        };
        let value = self.safe * drive.value();
        let verb = match (turns, value >= 0.0) {
            (true, _) => "turned",
            (false, true) => "pulled",
            (false, false) => "pushed",
        };
        let size = if turns { value } else { value.abs() };
        let amount = match (turns, drive.is_motion()) {
            (false, true) => format!("by {} mm", plain(size * 1e3, 3)),
            (false, false) => format!("with {} N", plain(size, 3)),
            (true, true) => format!("by {} deg", plain(size.to_degrees(), 3)),
            (true, false) => format!("with {} N mm", plain(size * 1e3, 3)),
        };
        format!("tube {tube} {verb} {amount}")
    }

    /// For JSON.
    pub fn json(&self) -> Value {
        json!({ "governing": limits::governing_json(&self.limit), "safe_part": self.safe, "text": self.text() })
    }
}
