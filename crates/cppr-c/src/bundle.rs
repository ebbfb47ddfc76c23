//! The solver of a robot of parts and joints, and its last equilibrium.

use crate::asked::Asked;
use crate::model::Parts;
use crate::names::{cppr_field, cppr_value};
use crate::session::Refused;
use crate::status::cppr_code;
use crate::values::write_derivatives;
use cppr::analysis::{Sensitivity, absurd_bundle_demand};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive, load_behind_plate};
use cppr::bundle::{Bundle, BundleSection, TubeSection};
use cppr::solve::{Command, Reason, Settings, Status};
use cppr::statics::RotationMeans;
use cppr::{Matrix3, Vector3};
use std::sync::Arc;

/// Sections between which fields are interpolated, per length.
const SECTIONS: f64 = 1000.0;
/// Lengths that differ by less than this part are the same.
const SAME: f64 = 1e-9;

/// Derivatives, as far as there are any.
#[derive(Clone)]
enum Derived {
    Known(Box<Sensitivity>),
    /// An equilibrium at a fold has none.
    Fold,
}

/// Solver and equilibria.
#[derive(Clone)]
pub(crate) struct Integrated {
    /// Borrows from `parts`. It is kept from call to call because it finds rest, and what stability is judged by, once.
    solver: BundleSolver<'static>,
    stretch: bool,
    /// The last one found: where a warm start starts.
    found: Option<BundleEquilibrium>,
    /// What the last solve left.
    result: Option<BundleEquilibrium>,
    /// Of the result, where they were asked for.
    derived: Option<Derived>,
    parts: Arc<Parts>,
}

/// A command of the interface, which has an actuator for every tube of a bundle.
pub(crate) fn command_of(asked: &Command) -> BundleCommand {
    let drive =
        |own: &cppr::solve::Actuator| TubeDrive { translation: own.push_pull, rotation: own.rotation };
    BundleCommand { drives: asked.actuators.iter().map(drive).collect(), loads: asked.loads.clone() }
}

impl Integrated {
    pub fn new(parts: &Arc<Parts>) -> Self {
        let parts = Arc::clone(parts);
        // SAFETY: what an `Arc` holds stays where it is and is not changed as long as one of its handles lives. The solver goes before the
        // handle beside it, and neither the reference nor a solver with it leaves this type.
        let bundle: &'static Bundle = unsafe { &*std::ptr::from_ref(&parts.bundle) };
        let solver = BundleSolver::new(bundle);
        Self { solver, stretch: false, found: None, result: None, derived: None, parts }
    }

    /// Takes over options, of which a bundle has one, or says why they cannot be.
    pub fn choose(&mut self, asked: &Asked) -> Result<(), String> {
        let stretch = asked.settings.resolution.stretch > 0;
        let plain = if stretch { Settings::default().with_stretch() } else { Settings::default() };
        if asked.settings != plain || asked.command.rotation_means != RotationMeans::Base {
            return Err(
                "of a robot with parts or joints only the stretch can be chosen and the tolerance of loops: nothing there has modes"
                    .into(),
            );
        }
        if stretch && !self.parts.design.has_axial_stiffness() {
            return Err("the axial stiffness of a part is not known".into());
        }
        if stretch != self.stretch {
            self.solver = self.solver.clone().with_stretch(stretch);
            self.stretch = stretch;
        }
        self.solver = self.solver.clone().with_loop_tolerance(asked.loop_tolerance);
        Ok(())
    }

    /// Solves from rest, or from the last equilibrium found.
    pub fn solve(&mut self, asked: &Asked, warm: bool) -> Result<cppr_code, Refused> {
        (self.result, self.derived) = (None, None);
        let command = command_of(&asked.command);
        self.check(&command)?;
        let found = match self.found.clone().filter(|_| warm) {
            Some(mut found) => {
                self.solver.solve_into(&command, &mut found);
                found
            }
            None => self.solver.solve(&command),
        };
        if let Some(label) = load_behind_plate(&command, &found) {
            return Err(Refused::BehindPlate(label));
        }
        if found.converged {
            self.found = Some(found.clone());
        }
        let code = match found.status() {
            Status::Converged => cppr_code::Ok,
            Status::Unstable => cppr_code::Unstable,
            Status::NotConverged(_) => cppr_code::NoEquilibrium,
        };
        self.result = Some(found);
        Ok(code)
    }

    /// Refuses what cannot be asked.
    pub fn check(&self, command: &BundleCommand) -> Result<(), Refused> {
        command.check(&self.parts.design, &self.parts.bundle, self.stretch).map_err(Refused::Bundle)
    }

    /// Takes over the equilibrium under one of many commands that have been checked: from the one before it where there is one that is stable, else from
    /// rest. One whose load acts behind the plate is none.
    pub fn go_to(&mut self, command: &BundleCommand, warm: bool) {
        let near = self.result.take().filter(|found| warm && found.converged && found.stable);
        let near = near.map(|start| self.solver.solve_from(command, &start));
        let found = match near.filter(|found| found.converged && found.stable) {
            Some(found) => found,
            None => self.solver.solve(command),
        };
        self.derived = None;
        self.result = Some(found).filter(|found| load_behind_plate(command, found).is_none());
    }

    /// Finds what all solves begin with.
    pub fn prepare(&mut self) {
        let _ = self.solver.rest();
    }

    fn equilibrium(&self) -> Option<&BundleEquilibrium> {
        self.result.as_ref().filter(|found| found.converged)
    }

    /// Length of the centreline of the last equilibrium (m).
    pub fn reach(&self) -> Option<f64> {
        self.equilibrium().map(|found| found.length)
    }

    /// Writes a value of the last solve; false where there is none.
    pub fn read(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let status = self.result.as_ref().map(BundleEquilibrium::status);
        let single = match (value, status) {
            (cppr_value::Status, Some(Status::Converged)) => 0.0,
            (cppr_value::Status, Some(Status::Unstable)) => 1.0,
            (cppr_value::Status, _) => 2.0,
            (cppr_value::Fraction, Some(Status::NotConverged(Reason::PathEnds { fraction }))) => fraction,
            (cppr_value::Fraction, Some(Status::NotConverged(_)) | None) => 0.0,
            (cppr_value::Fraction, Some(_)) => 1.0,
            _ => return self.read_found(value, out),
        };
        out.fill(single);
        true
    }

    fn read_found(&mut self, value: cppr_value, out: &mut [f64]) -> bool {
        let Some(found) = self.result.as_ref().filter(|found| found.converged) else { return false };
        match value {
            cppr_value::Iterations => out.fill(found.iterations as f64),
            cppr_value::Length => out.fill(found.length),
            cppr_value::TotalBend => out.fill(total_bend(&self.solver.shape(found, found.length / SECTIONS))),
            cppr_value::Error => {
                // A warm start leaves the error to those who ask for it.
                let known = found.error[0].is_finite();
                let [tip, force] = if known { found.error } else { self.solver.error(found) };
                out.copy_from_slice(&[tip, force, f64::NAN]);
            }
            cppr_value::TipPosition => out.copy_from_slice(found.tip.as_slice()),
            // Column by column is the transpose row by row.
            cppr_value::TipRotation => out.copy_from_slice(found.frame.transpose().as_slice()),
            cppr_value::Pull | cppr_value::Rotation | cppr_value::Tension | cppr_value::Torque => {
                for (cell, own) in out.iter_mut().zip(&found.efforts) {
                    *cell = match value {
                        cppr_value::Pull => own.label,
                        cppr_value::Rotation => own.rotation,
                        cppr_value::Tension => own.force,
                        _ => own.torque,
                    };
                }
            }
            cppr_value::Jacobian if self.derived.is_none() => {
                // In rows.
                let Some(jacobian) = self.solver.tip_jacobian(found) else { return false };
                out.copy_from_slice(jacobian.transpose().as_slice());
            }
            cppr_value::Jacobian
            | cppr_value::JacobianBody
            | cppr_value::Response
            | cppr_value::Compliance
            | cppr_value::ResponseByWrench => {
                let solver = &self.solver;
                let derived = self.derived.get_or_insert_with(|| match solver.sensitivity(found) {
                    Some(own) => Derived::Known(Box::new(own)),
                    None => Derived::Fold,
                });
                let Derived::Known(own) = derived else { return false };
                write_derivatives(value, own, 0, out);
            }
            _ => return false,
        }
        true
    }

    /// Writes a field of the last solve at lengths of the centreline (m); false where there is none.
    pub fn field(&mut self, field: cppr_field, labels: &[f64], out: &mut [f64]) -> bool {
        let tubes = self.parts.bundle.tube_count();
        let width = match field {
            cppr_field::Centre => 3,
            cppr_field::Rotation => 9,
            cppr_field::Abscissa => tubes,
            cppr_field::Centroid => 3 * tubes,
            _ => return false,
        };
        let Some(found) = self.equilibrium() else { return false };
        let shape = self.solver.shape(found, found.length / SECTIONS);
        for (label, row) in labels.iter().zip(out.chunks_exact_mut(width)) {
            let Some(place) = Place::new(&shape, *label) else { return false };
            match field {
                cppr_field::Centre => row.copy_from_slice(place.centre.as_slice()),
                cppr_field::Rotation => row.copy_from_slice(place.section_frame().transpose().as_slice()),
                _ => {
                    let each = row.chunks_exact_mut(width / tubes).enumerate();
                    for (tube, cells) in each {
                        // What is not there stays NaN.
                        let Some(own) = place.tube(tube) else { continue };
                        if field == cppr_field::Abscissa {
                            cells.fill(own.label);
                        } else {
                            cells.copy_from_slice((place.centre + place.offset(&own)).as_slice());
                        }
                    }
                }
            }
        }
        true
    }

    pub fn explain(&self) -> String {
        let Some(found) = &self.result else { return String::new() };
        let verdict = found.verdict();
        match absurd_bundle_demand(&self.parts.bundle, found.command()) {
            Some(demand) => format!("{verdict}. {demand}"),
            None => verdict,
        }
    }

    pub fn doubt(&self, asked: &Asked) -> Option<String> {
        let demand = absurd_bundle_demand(&self.parts.bundle, &command_of(&asked.command));
        demand.map(|demand| demand.to_string())
    }
}

/// Angle by which the centreline turns in all (rad): that between the tangents of neighbouring sections, summed.
fn total_bend(shape: &[BundleSection]) -> f64 {
    let turn = |pair: &[BundleSection]| {
        let [a, b] = [0, 1].map(|i| Vector3::from(pair[i].frame.column(0)));
        a.cross(&b).norm().atan2(a.dot(&b))
    };
    shape.windows(2).map(turn).sum()
}

/// One tube at a place.
struct Own {
    label: f64,
    angle: f64,
    centroid_offset: f64,
}

/// A place between two sections.
struct Place<'a> {
    ends: [&'a BundleSection; 2],
    share: f64,
    centre: Vector3<f64>,
    /// Untwisted: tangent first.
    frame: Matrix3<f64>,
}

impl<'a> Place<'a> {
    /// At a length of the centreline; where fields jump, on the side of the plate.
    fn new(shape: &'a [BundleSection], label: f64) -> Option<Self> {
        let near = SAME * shape.last()?.length;
        let next = shape.partition_point(|s| s.length < label - near).clamp(1, shape.len().max(2) - 1);
        let ends = [shape.get(next - 1)?, shape.get(next)?];
        let way = ends[1].length - ends[0].length;
        let share = if way > 0.0 { ((label - ends[0].length) / way).clamp(0.0, 1.0) } else { 0.0 };
        let [centre, tangent] = ends[0].towards(ends[1], share);
        let across = ends[0].frame.column(1) * (1.0 - share) + ends[1].frame.column(1) * share;
        let across = (across - tangent * tangent.dot(&across)).try_normalize(0.0)?;
        let frame = Matrix3::from_columns(&[tangent, across, tangent.cross(&across)]);
        Some(Self { ends, share, centre, frame })
    }

    fn tube(&self, tube: usize) -> Option<Own> {
        let [a, b] = [self.ends[0].tube(tube)?, self.ends[1].tube(tube)?];
        let mix = |get: fn(&TubeSection) -> f64| get(a) + self.share * (get(b) - get(a));
        Some(Own {
            label: mix(|t| t.label),
            angle: mix(|t| t.angle),
            centroid_offset: mix(|t| t.centroid_offset),
        })
    }

    /// Towards the centroid of a tube, in the base frame.
    fn direction(&self, own: &Own) -> Vector3<f64> {
        let (sin, cos) = own.angle.sin_cos();
        self.frame.column(1) * cos + self.frame.column(2) * sin
    }

    fn offset(&self, own: &Own) -> Vector3<f64> {
        self.direction(own) * own.centroid_offset
    }

    /// Columns tangent, towards the centroid of the outermost tube that is there, normal.
    fn section_frame(&self) -> Matrix3<f64> {
        let outermost = self.ends[0].tubes.iter().find_map(|own| self.tube(own.tube));
        let Some(own) = outermost else { return self.frame };
        let (tangent, towards) = (Vector3::from(self.frame.column(0)), self.direction(&own));
        Matrix3::from_columns(&[tangent, towards, tangent.cross(&towards)])
    }
}
