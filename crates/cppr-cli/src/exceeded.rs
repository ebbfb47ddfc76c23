//! What a pose asks beyond the limits of the robot, which the mechanics does not know: it bends notches on after their teeth have met.
//! Strain, closure and shear over what is allowed, per notch, as `cppr::analysis::limits` has them; and the greatest part of the command, in
//! [0, 1] from rest, that keeps all limits.

use crate::limits;
use crate::table::plain;
use cppr::analysis::{BundleAnalysis, Governing, RangeEnd, RangeProblem, SectionLimit, Teeth, governing};
use cppr::bundle::solve::BundleEquilibrium;
use cppr::solve::{Drive, Equilibrium, Freedom, Input, Solver};
use cppr::statics::Loads;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// The limit of a notch or section that a pose exceeds most.
pub struct Exceeded {
    limit: Governing,
    /// Greatest part of the command, from rest, that keeps all limits.
    safe: f64,
    /// Everything that moves or pulls, and whether loads act besides.
    drives: Vec<(Input, Drive)>,
    loaded: bool,
    /// What that part took to find.
    pub time: Duration,
}

impl Exceeded {
    /// `None` within all limits. Stability is for the status to tell.
    pub fn of(solver: &mut Solver, found: &Equilibrium, teeth: Teeth) -> Option<Self> {
        let command = found.command().clone();
        let inputs = command.inputs().map(|(input, value)| (input, input.prescribed(value))).collect();
        let sections = solver.section_limits(found, teeth);
        Self::new(&sections, inputs, &command.loads, || solver.safe_part(&command, teeth))
    }

    /// The same of a bundle.
    pub fn of_bundle(analysis: &mut BundleAnalysis, found: &BundleEquilibrium, teeth: Teeth) -> Option<Self> {
        let sections = analysis.section_limits(found, teeth);
        let command = found.command().clone();
        let drives = command.drives.iter().flat_map(|own| [own.translation, own.rotation]);
        let inputs = command.inputs().into_iter().zip(drives).collect();
        Self::new(&sections, inputs, &command.loads, || analysis.safe_part(&command, teeth))
    }

    fn new(
        sections: &[SectionLimit],
        mut drives: Vec<(Input, Drive)>,
        loads: &Loads,
        safe: impl FnOnce() -> Result<RangeEnd, RangeProblem>,
    ) -> Option<Self> {
        let limit = governing(sections, None).filter(|worst| worst.utilisation > 1.0)?;
        drives.retain(|(_, drive)| drive.value().abs() > 0.0);
        let start = Instant::now();
        let safe = safe().ok()?.value;
        Some(Self { limit, safe, drives, loaded: !loads.is_empty(), time: start.elapsed() })
    }

    /// In a sentence.
    pub fn text(&self) -> String {
        format!("{}; all limits are kept up to {}", self.limit.exceeded(), self.safe())
    }

    /// The value of a command that has no other, or a part of the whole.
    fn safe(&self) -> String {
        let (false, &[(Input { tube, freedom, .. }, drive)]) = (self.loaded, &self.drives[..]) else {
            return format!("{} % of this command", plain(100.0 * self.safe, 1));
        };
        let turns = freedom == Freedom::Rotation;
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
