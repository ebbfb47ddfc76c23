//! What ranges and inverse problems ask of a robot: the modal solver of tubes of one length answers it, and so does the solver of any bundle.

use super::limits::{Governing, Teeth, governing};
use super::sensitivity::Sensitivity;
use crate::kinematics::TipPose;
use crate::solve::path::settle;
use crate::solve::{Command, Equilibrium, Freedom, Input, Quantity, Solver, Status};
use crate::statics::Wrench;
use nalgebra::{DMatrix, Vector3};

/// Part of the length that a tube may slide.
const STROKE: f64 = 0.9;
/// Turns that a tube is followed through, to each side.
const TURNS: f64 = 2.0 * std::f64::consts::PI;
/// Bend of the whole robot (rad) that efforts are followed up to, if bending and twist were linear in them.
const BEND: f64 = 20.0;

/// A robot that answers commands with equilibria.
pub(super) trait Model {
    type Command: Clone;
    type Found: Clone;

    /// Length (m).
    fn length(&self) -> f64;

    /// Has somebody asked to stop?
    fn is_stopped(&self) -> bool;

    /// EI and GJ of all tubes together (N m²), and the greatest centroid offset (m), halfway along.
    fn stiffness(&self) -> [f64; 3];

    /// What is prescribed of an input, whether as motion or as effort.
    fn value(command: &Self::Command, input: Input) -> Option<f64>;

    /// Is the motion of an input prescribed?
    fn is_motion(command: &Self::Command, input: Input) -> bool;

    /// The same command with one input at another value.
    fn with_input(command: &Self::Command, input: Input, value: f64) -> Self::Command;

    /// The same command with one more wrench.
    fn with_wrench(command: &Self::Command, wrench: Wrench) -> Self::Command;

    /// Is an equilibrium there, and stable?
    fn is_stable(found: &Self::Found) -> bool;

    /// The stable equilibrium near another one, or from rest.
    fn stable(&mut self, command: &Self::Command, near: Option<&Self::Found>) -> Option<Self::Found>;

    /// The same from rest for one of many commands, of which some may be missed for the sake of speed.
    fn scouted(&mut self, command: &Self::Command) -> Option<Self::Found> {
        self.stable(command, None)
    }

    /// The equilibrium under a command that continues another one.
    fn continued(&mut self, command: &Self::Command, from: &Self::Found) -> Option<Self::Found>;

    /// Pose of the tip.
    fn tip(&mut self, found: &Self::Found) -> TipPose;

    /// Derivatives; `None` where the tangent is singular.
    fn slopes(&mut self, found: &Self::Found) -> Option<Sensitivity>;

    /// Centres (m) and tangents of the sections with these labels: of the leader, or lengths of the centreline of a bundle.
    fn places(&mut self, found: &Self::Found, labels: &[f64]) -> Vec<[Vector3<f64>; 2]>;

    /// Slopes of those centres, three rows each, by some inputs.
    fn place_slopes(&mut self, found: &Self::Found, labels: &[f64], inputs: &[Input])
    -> Option<DMatrix<f64>>;

    /// Motion or effort of a tube's actuator.
    fn actual(found: &Self::Found, input: Input) -> Option<f64>;

    /// The limit that an equilibrium uses most.
    fn nearest_limit(&mut self, found: &Self::Found, teeth: Teeth) -> Option<Governing>;

    /// How far an input is followed to either side (m, rad, N or N m).
    fn extent(&self, input: Input) -> f64 {
        let (length, [bending, torsion, lever]) = (self.length(), self.stiffness());
        match (input.freedom, input.is_motion) {
            (Freedom::PushPull, true) => STROKE * length,
            (Freedom::Rotation, true) => TURNS,
            (Freedom::PushPull, false) => BEND * bending / (length * lever.max(f64::MIN_POSITIVE)),
            (Freedom::Rotation, false) => BEND * torsion / length,
        }
    }
}

impl Model for Solver {
    type Command = Command;
    type Found = Equilibrium;

    fn length(&self) -> f64 {
        self.robot.length()
    }

    fn is_stopped(&self) -> bool {
        Solver::is_stopped(self)
    }

    fn stiffness(&self) -> [f64; 3] {
        let middle = 0.5 * self.robot.length();
        let fields = (0..self.robot.tube_count()).map(|tube| self.robot.fields_at(tube, middle));
        fields.fold([0.0; 3], |[bending, torsion, lever], f| {
            [bending + f.bending_z, torsion + f.torsion, f64::max(lever, f.centroid_offset)]
        })
    }

    fn value(command: &Command, input: Input) -> Option<f64> {
        command.value(input)
    }

    fn is_motion(command: &Command, input: Input) -> bool {
        command.actuator(input.tube).is_some_and(|actuator| actuator.drive(input.freedom).is_motion())
    }

    fn with_input(command: &Command, input: Input, value: f64) -> Command {
        command.with_input(input, value)
    }

    fn with_wrench(command: &Command, wrench: Wrench) -> Command {
        let mut loaded = command.clone();
        loaded.loads.wrenches.push(wrench);
        loaded
    }

    fn is_stable(found: &Equilibrium) -> bool {
        found.status == Status::Converged
    }

    fn stable(&mut self, command: &Command, near: Option<&Equilibrium>) -> Option<Equilibrium> {
        let found = match near {
            Some(start) => self.solve_from(command, start),
            None => self.solve(command),
        };
        found.ok().filter(Self::is_stable)
    }

    fn continued(&mut self, command: &Command, from: &Equilibrium) -> Option<Equilibrium> {
        // Load stepping from rest may come out on another branch, and takes long to find none.
        let mut found = from.clone();
        let Solver { robot, settings, buffers, kept: _ } = self;
        settle(robot, buffers, command, settings, &mut found);
        found.status.is_equilibrium().then_some(found)
    }

    fn tip(&mut self, found: &Equilibrium) -> TipPose {
        Solver::tip(self, found)
    }

    fn slopes(&mut self, found: &Equilibrium) -> Option<Sensitivity> {
        self.sensitivity(found).ok()
    }

    fn places(&mut self, found: &Equilibrium, labels: &[f64]) -> Vec<[Vector3<f64>; 2]> {
        let shape = self.shape_at(found, labels);
        shape.sections.iter().map(|s| [s.centre, s.rotation.column(0).into()]).collect()
    }

    fn place_slopes(
        &mut self,
        found: &Equilibrium,
        labels: &[f64],
        inputs: &[Input],
    ) -> Option<DMatrix<f64>> {
        let centres = |solver: &mut Self, moved: &Equilibrium| -> Vec<f64> {
            let places = solver.places(moved, labels);
            places.iter().flat_map(|[centre, _]| [centre.x, centre.y, centre.z]).collect()
        };
        let all: Vec<Input> = found.command.inputs().map(|(input, _)| input).collect();
        let slopes = self.outputs_by_inputs(found, centres).ok()?;
        let place = |own: &Input| all.iter().position(|input| input.is_same_freedom(*own));
        Some(slopes.select_columns(&inputs.iter().filter_map(place).collect::<Vec<_>>()))
    }

    fn actual(found: &Equilibrium, input: Input) -> Option<f64> {
        Some(found.actuator(input.tube)?.get(Quantity::of(input.freedom, input.is_motion)))
    }

    fn nearest_limit(&mut self, found: &Equilibrium, teeth: Teeth) -> Option<Governing> {
        let sections = self.section_limits(found, teeth);
        let margin = self.margin(found);
        governing(&sections, margin)
    }
}
