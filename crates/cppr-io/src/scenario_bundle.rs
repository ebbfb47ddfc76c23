//! Scenarios for robots with parts and joints: every tube is driven, tube 1 as well, and nothing has modes.

use crate::Scenario;
use crate::scenario::{FormulationName, ModesName, Refinement, RotationName};
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{BundleDesign, TubeParts};
use cppr::solve::{Freedom, Input};

impl Scenario {
    /// Keys that only robots solved with modes take, and why a bundle does not.
    fn of_modes_alone(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let all = [
            (
                "rotation_means",
                self.rotation_means != RotationName::Base,
                "motors turn tubes against the plate",
            ),
            (
                "formulation",
                self.formulation != FormulationName::Consistent,
                "the paper's equations know one joint",
            ),
            ("modes", self.modes != ModesName::Default, "its equations have no modes"),
            ("refine", self.refine != Refinement::default(), "its steps follow their error"),
            ("notches", !self.notches.is_empty(), "its parts are changed in the robot file"),
        ];
        all.into_iter().filter(|(_, given, _)| *given).map(|(key, _, why)| (key, why))
    }

    /// Does it ask for what only the solver with modes has?
    #[must_use]
    pub fn needs_modes(&self) -> bool {
        self.of_modes_alone().next().is_some()
    }

    /// The command for a bundle, and whether its tubes stretch.
    ///
    /// # Errors
    /// Every entry that cannot be asked of it.
    pub fn bundle_command(&self, design: &BundleDesign) -> Result<(BundleCommand, bool), Vec<String>> {
        let mut problems: Vec<String> = self
            .of_modes_alone()
            .map(|(key, why)| format!("{key} is not for a robot with parts or joints: {why}"))
            .collect();
        let loads = self.loads();
        let length = design.tubes.first().map_or(0.0, TubeParts::length);
        if let Err(problem) = loads.check_on(length, design.has_mass()) {
            problems.push(problem.to_string());
        }
        if self.stretch && !design.has_axial_stiffness() {
            problems.push(
                "stretch: the axial stiffness of a part is not known; add axial_N to its stiffness".into(),
            );
        }
        let mut drives = vec![TubeDrive::HELD; design.tubes.len()];
        let mut given: Vec<Input> = Vec::new();
        for (index, entry) in self.actuator.iter().enumerate() {
            let number = entry.tube;
            if self.actuator[..index].iter().any(|other| other.tube == number) {
                problems.push(format!("actuator: tube {number} is given twice"));
                continue;
            }
            let Some(own) = number.checked_sub(1).and_then(|i| drives.get_mut(i)) else {
                let count = design.tubes.len();
                problems
                    .push(format!("actuator: there is no tube {number}; this robot has tubes 1 to {count}"));
                continue;
            };
            for (quantity, key, value) in entry.given() {
                let input = quantity.of_tube(number);
                if !value.is_finite() {
                    problems.push(format!("actuator of tube {number}: {key} is {value}"));
                } else if given.iter().any(|other| other.is_same_freedom(input)) {
                    problems.push(format!(
                        "actuator of tube {number}: give {key} or what moves it otherwise, not both"
                    ));
                }
                given.push(input);
                *(match input.freedom {
                    Freedom::PushPull => &mut own.translation,
                    Freedom::Rotation => &mut own.rotation,
                }) = input.prescribed(value);
            }
        }
        if problems.is_empty() { Ok((BundleCommand { drives, loads }, self.stretch)) } else { Err(problems) }
    }
}
