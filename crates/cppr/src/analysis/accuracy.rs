//! How far an equilibrium of the modal solver is from the equations themselves: the same bundle is integrated, which knows no modes,
//! beginning with the forces found.

use crate::bundle::Bundle;
use crate::bundle::course::{Course, POSE};
use crate::bundle::frame::Unknowns;
use crate::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeDrive};
use crate::design::Robot;
use crate::kinematics::TipPose;
use crate::solve::{Command, CommandProblem, Drive, Equilibrium, Formulation, Settings, Solver, Status};
use crate::statics::{Frame, Loads, RotationMeans, Station};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// The discretisation error of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Error of the tip (m).
    pub tip: f64,
    /// Greatest error of an actuation force (N).
    pub force: f64,
    /// Greatest error of an actuation torque (N m).
    pub torque: f64,
    /// Is that what it was compared with stable? `None` where an eigenvalue cannot be told from zero.
    pub stable: Option<bool>,
    /// What it was compared with.
    pub against: Against,
    /// Tip of that (m).
    pub reference: Vector3<f64>,
}

impl Accuracy {
    /// Is what the equilibrium was compared with stable or not as the equilibrium is, as far as that can be told?
    #[must_use]
    pub fn confirms(&self, status: Status) -> bool {
        self.stable.is_none_or(|stable| stable == (status == Status::Converged))
    }
}

/// What an equilibrium was compared with for its error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The same bundle integrated from the plate to the tip, which leaves out no mode.
    Integration,
    /// The equilibrium at half as many modes, where the integration did not find it: twice as many change less.
    HalfTheModes,
}

/// Settings that resolve some commands, see [`Solver::settings_for`] and [`Solver::fewest_modes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsFound {
    /// With as many modes as the most demanding command needs.
    pub settings: Settings,
    /// Greatest error of a tip (m) with as many; `None` where none is known.
    pub error: Option<f64>,
    /// Of how many commands it is known.
    pub known: usize,
}

/// Greatest tip error that is accepted, as a part of the length.
pub const ACCURACY: f64 = 1e-4;
/// Factors on the resolution that are tried where that of the settings does not suffice.
const FACTORS: [usize; 2] = [2, 4];
/// Eighths of the resolution of the settings that are tried where fewer modes are looked for.
const PARTS: [usize; 3] = [3, 4, 6];

impl Solver {
    /// Discretisation error of a stable or unstable equilibrium. `None` where there is none to compare with: the printed formulation,
    /// rotations that are counted at the plate relative to the leader, an equilibrium that the integration does not find, or a
    /// state that is none.
    #[must_use]
    pub fn accuracy(&mut self, equilibrium: &Equilibrium) -> Option<Accuracy> {
        let (_, found) = self.integration(equilibrium)?;
        let tip = equilibrium.tip();
        let efforts = found.efforts[1..].iter().map(|own| [own.force, own.torque]);
        let [force, torque] = greatest_differences(equilibrium, efforts);
        Some(Accuracy {
            tip: (found.tip - tip.centre).norm(),
            force,
            torque,
            stable: found.inertia.map(|negative| negative == 0),
            against: Against::Integration,
            reference: found.tip,
        })
    }

    /// Discretisation error of the stability margin of an equilibrium: its distance from that at twice as many modes, to which Newton's method leads. `None` where there is
    /// no margin, or where it leads to none or to another equilibrium.
    #[must_use]
    pub fn margin_error(&mut self, equilibrium: &Equilibrium) -> Option<f64> {
        let margin = self.stability(equilibrium)?.margin;
        let settings = *equilibrium.settings();
        let resolution = settings.resolution.refined(2);
        let mut finer = Self::with_settings(equilibrium.robot(), Settings { resolution, ..settings }).ok()?;
        let found = finer.beside(equilibrium);
        let away = (found.tip().centre - equilibrium.tip().centre).norm();
        let same = found.status().is_equilibrium() && away < NEAR * equilibrium.robot().length();
        same.then(|| finer.stability(&found))?.map(|own| (own.margin - margin).abs())
    }

    /// The equilibrium of the same bundle that is integrated along its length, and the bundle. `None` as for [`Self::accuracy`].
    pub(crate) fn integration(
        &mut self,
        equilibrium: &Equilibrium,
    ) -> Option<(Arc<Bundle>, BundleEquilibrium)> {
        let settings = equilibrium.settings();
        if !equilibrium.status().is_equilibrium()
            || settings.formulation != Formulation::Consistent
            || equilibrium.command().rotation_means != RotationMeans::Base
        {
            return None;
        }
        let bundle = self.bundle_of(equilibrium.robot())?;
        let tip = equilibrium.tip();
        let command = command(equilibrium);
        let start = self.start(equilibrium, &tip);
        let solver = BundleSolver::new(&bundle)
            .with_tolerance(TOLERANCE)
            .with_stretch(settings.resolution.stretch > 0);
        let course = self.course(equilibrium, &bundle);
        let found = solver.near(&command, &start, &course)?;
        Some((bundle, found))
    }

    /// Solves for an equilibrium from rest whose tip is within `accuracy` times the length of that of the robot that knows no modes, as far
    /// as [`Self::resolve`] reaches that.
    ///
    /// # Errors
    /// As [`Solver::solve`].
    pub fn solve_resolved(
        &mut self,
        command: &Command,
        accuracy: f64,
    ) -> Result<(Equilibrium, Option<Accuracy>), CommandProblem> {
        let found = self.solve(command)?;
        self.resolve(found, accuracy)
    }

    /// The discretisation error of an equilibrium that was found from rest, and where its tip is not within `accuracy` times the length or
    /// its stability is not that of what it was compared with, the equilibrium at twice or four times as many modes and nodes. Where none of them is, the best is returned with its error. Settings
    /// stay. An equilibrium of another robot keeps its modes. There is no error where there is no equilibrium, and in the printed formulation.
    ///
    /// # Errors
    /// As [`Solver::solve`].
    pub fn resolve(
        &mut self,
        found: Equilibrium,
        accuracy: f64,
    ) -> Result<(Equilibrium, Option<Accuracy>), CommandProblem> {
        self.resolve_with(found, accuracy, &FACTORS)
    }

    /// Settings with as many modes as the most demanding of some commands needs, each solved from rest, and the greatest error that is left. The
    /// solver's own settings stay. What cannot be asked or has no equilibrium is left out.
    #[must_use]
    pub fn settings_for(&mut self, commands: &[Command], accuracy: f64) -> SettingsFound {
        let usual = self.settings;
        let mut found = SettingsFound { settings: usual, error: None, known: 0 };
        // Those that are left to try.
        let mut factors = &FACTORS[..];
        for command in commands {
            let solved = self.solve(command).and_then(|own| self.resolve_with(own, accuracy, factors));
            let Ok((own, Some(error))) = solved else { continue };
            found.error = Some(found.error.unwrap_or(0.0).max(error.tip));
            found.known += 1;
            self.settings = *own.settings();
            let factor = self.settings.resolution.nodes / usual.resolution.nodes;
            factors =
                &FACTORS[..FACTORS.iter().filter(|own| factor * **own <= FACTORS[FACTORS.len() - 1]).count()];
        }
        found.settings = std::mem::replace(&mut self.settings, usual);
        found
    }

    /// Settings with as few modes as all of some commands bear, for a loop that moves between them: every one, solved from rest, has its tip within
    /// `accuracy` times the length, by its error and by the solver's own settings, and is as stable as with these, which the integration confirms.
    /// Forces and derivatives become coarser with the tip. Where fewer modes do not suffice, or no error is known, this is what [`Self::settings_for`] finds.
    #[must_use]
    pub fn fewest_modes(&mut self, commands: &[Command], accuracy: f64) -> SettingsFound {
        let needed = self.settings_for(commands, accuracy);
        let usual = self.settings;
        if needed.settings != usual || needed.known == 0 {
            return needed;
        }
        let solved: Vec<Equilibrium> = commands.iter().filter_map(|own| self.solve(own).ok()).collect();
        for eighths in PARTS {
            self.settings.resolution = usual.resolution.eighths(eighths);
            let found = self.greatest_error(&solved, accuracy * self.robot.length());
            let settings = std::mem::replace(&mut self.settings, usual);
            if let Some((error, known)) = found {
                return SettingsFound { settings, error: Some(error), known };
            }
        }
        needed
    }

    /// Greatest error (m) of the tips of some equilibria solved again, and of how many it is known. `None` where one is lost, is off by more
    /// than `bound` (m), or where the stability of one is another than before or than that of what is integrated.
    fn greatest_error(&mut self, solved: &[Equilibrium], bound: f64) -> Option<(f64, usize)> {
        let (mut greatest, mut known) = (0.0_f64, 0);
        for usual in solved.iter().filter(|own| own.status().is_equilibrium()) {
            let own = self.solve(usual.command()).ok().filter(|own| own.status() == usual.status())?;
            let error = self.accuracy(&own)?;
            let away = (own.tip().centre - usual.tip().centre).norm();
            if error.stable != Some(own.status() == Status::Converged) || error.tip.max(away) > bound {
                return None;
            }
            greatest = greatest.max(error.tip);
            known += 1;
        }
        Some((greatest, known))
    }

    /// [`Self::resolve`] with some factors on the modes.
    fn resolve_with(
        &mut self,
        found: Equilibrium,
        accuracy: f64,
        factors: &[usize],
    ) -> Result<(Equilibrium, Option<Accuracy>), CommandProblem> {
        let settings = *found.settings();
        let command = found.command().clone();
        let bound = accuracy * self.robot.length();
        let mut best = (found, None);
        // The printed formulation is no discretisation of anything: more modes lead it elsewhere.
        if !best.0.status().is_equilibrium() || settings.formulation == Formulation::Printed {
            return Ok(best);
        }
        best.1 = self.accuracy(&best.0);
        if best.0.robot().serial() != self.robot.serial() {
            return Ok(best);
        }
        let mut coarser = best.0.clone();
        for factor in factors {
            let sure = |own: Accuracy| own.confirms(best.0.status()) || bound.is_infinite();
            if best.1.is_some_and(|own| own.tip <= bound && sure(own)) {
                break;
            }
            let before = self.settings;
            self.settings = Settings { resolution: settings.resolution.refined(*factor), ..settings };
            let solved = self.solve(&command);
            self.settings = before;
            let mut found = solved?;
            if best.0.status() == Status::Converged && found.status() != Status::Converged {
                // What was found at the end of a path is found there again.
                let before = std::mem::replace(&mut self.settings, *found.settings());
                let followed = self.follow(&command);
                self.settings = before;
                found = followed.map_or(found, |own| own.equilibrium);
            }
            if !found.status().is_equilibrium() {
                break;
            }
            let own = self.accuracy(&found).unwrap_or_else(|| {
                let efforts = coarser.actuators().iter().map(|own| [own.tension, own.torque]);
                let [force, torque] = greatest_differences(&found, efforts);
                let tip = (found.tip().centre - coarser.tip().centre).norm();
                let reference = coarser.tip().centre;
                let stable = Some(coarser.status() == Status::Converged);
                Accuracy { tip, force, torque, stable, against: Against::HalfTheModes, reference }
            });
            coarser = found.clone();
            if best.1.is_none_or(|before| own.tip < before.tip) {
                best = (found, Some(own));
            }
        }
        Ok(best)
    }

    /// The robot's tubes for the integration, kept for the next time. `None` where a section between samples cannot be built.
    fn bundle_of(&mut self, robot: &Robot) -> Option<Arc<Bundle>> {
        if let Some((serial, kept)) = &self.kept
            && *serial == robot.serial()
        {
            return Arc::clone(kept).downcast().ok();
        }
        let bundle = Arc::new(Bundle::from_robot(robot).ok()?);
        self.kept = Some((robot.serial(), Arc::clone(&bundle) as Arc<_>));
        Some(bundle)
    }

    /// Labels and rotations of all tubes along the leader.
    fn course(&mut self, equilibrium: &Equilibrium, bundle: &Bundle) -> Course {
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(SECTIONS + 1);
        let mut frame: Option<(Matrix3<f64>, Vector3<f64>)> = None;
        let mut rotations: Vec<f64> =
            std::iter::once(0.0).chain(equilibrium.actuators().iter().map(|a| a.rotation)).collect();
        for section in &self.shape(equilibrium, SECTIONS + 1).sections {
            let tangent: Vector3<f64> = section.tubes[0].rotation.column(0).into();
            // The frame that does not turn about the tangent, from one section to the next.
            let own = match &frame {
                None => Matrix3::identity(),
                Some((before, centre)) => transported(before, &(section.centre - centre), &tangent),
            };
            let mut row = Vec::with_capacity(2 * rotations.len() + POSE);
            for ((tube, rotation), parts) in section.tubes.iter().zip(&mut rotations).zip(&bundle.tubes) {
                let towards = own.transpose() * tube.rotation.column(1);
                let label = tube.abscissa;
                let turned = towards.z.atan2(towards.y) - parts.piece_at(label).direction(label)[0];
                // The turn nearest to that of the section before.
                *rotation += (turned - *rotation + PI).rem_euclid(2.0 * PI) - PI;
                row.extend([label, *rotation]);
            }
            row.extend(section.centre.iter());
            let turn = UnitQuaternion::from_matrix(&own);
            let [x, y, z, w] = turn.coords.into();
            let sign = match rows.last() {
                Some(last) => {
                    last[row.len()..].iter().zip([w, x, y, z]).map(|(a, b)| a * b).sum::<f64>().signum()
                }
                None => 1.0,
            };
            row.extend([w, x, y, z].map(|c| sign * c));
            rows.push(row);
            frame = Some((own, section.centre));
        }
        Course { length: equilibrium.robot().length(), rows }
    }

    /// What the integration starts with: actuators and loads of the equilibrium. They only have to lead to it.
    fn start(&mut self, equilibrium: &Equilibrium, tip: &TipPose) -> Unknowns {
        let mut force = Vector3::zeros();
        let mut moment = Vector3::zeros();
        let Loads { wrenches, distributed, gravity, threads } = &equilibrium.command().loads;
        let mut add = |f: Vector3<f64>, m: Vector3<f64>, at: Vector3<f64>| {
            force += f;
            moment += m + at.cross(&f);
        };
        for w in wrenches {
            let (rotation, centre) = match w.station {
                Station::Tip => (tip.rotation, tip.centre),
                Station::Label(label) => {
                    let section = &self.shape_at(equilibrium, &[label]).sections[0];
                    (section.rotation, section.centre)
                }
            };
            let turn = if w.frame == Frame::World { Matrix3::identity() } else { rotation };
            add(turn * w.force, turn * w.moment, centre + rotation * w.point);
        }
        for thread in threads {
            let from = tip.centre + tip.rotation * thread.point;
            add((thread.pulley - from).normalize() * thread.tension, Vector3::zeros(), from);
        }
        for d in distributed {
            let middle = self.shape_at(equilibrium, &[0.5 * (d.from + d.to)]).sections[0].centre;
            add(d.force * (d.to - d.from), Vector3::zeros(), middle);
        }
        if let Some(gravity) = gravity {
            let robot = equilibrium.robot();
            for section in &self.shape(equilibrium, WEIGHED).sections {
                let mass: f64 =
                    (0..robot.tube_count()).map(|t| robot.fields_at(t, section.label).mass_per_length).sum();
                add(gravity * (mass * robot.length() / WEIGHED as f64), Vector3::zeros(), section.centre);
            }
        }
        let actuators = equilibrium.actuators();
        let pulled: f64 = actuators.iter().map(|a| a.tension).sum();
        let turned: f64 = actuators.iter().map(|a| a.torque).sum();
        let mut tubes = vec![[0.0, -force.x - pulled, 0.0, moment.x + turned]];
        tubes.extend(actuators.iter().map(|a| [a.motion, a.tension, a.rotation, -a.torque]));
        Unknowns { tubes, force: force.into(), moment: [moment.y, moment.z], handed: Vec::new() }
    }
}

/// Tips nearer to each other than this part of the length are of one equilibrium.
const NEAR: f64 = 1e-2;
/// Error allowed in one step of the integration: far below what is asked of the answer.
const TOLERANCE: f64 = 1e-6;
/// Sections between which the course of the tubes is interpolated.
const SECTIONS: usize = 48;
/// Sections at which the weight is summed for the start.
const WEIGHED: usize = 32;

/// Greatest differences of the actuation forces (N) and torques (N m) from others.
fn greatest_differences(equilibrium: &Equilibrium, others: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    equilibrium.actuators().iter().zip(others).fold([0.0; 2], |[force, torque]: [f64; 2], (own, other)| {
        [force.max((own.tension - other[0]).abs()), torque.max((own.torque - other[1]).abs())]
    })
}

/// A frame moved along a chord to another tangent without turning about it, by two reflections (Wang et al. 2008).
fn transported(frame: &Matrix3<f64>, chord: &Vector3<f64>, tangent: &Vector3<f64>) -> Matrix3<f64> {
    let reflect = |v: Vector3<f64>, normal: &Vector3<f64>| {
        let square = normal.norm_squared();
        if square > 0.0 { v - normal * (2.0 * normal.dot(&v) / square) } else { v }
    };
    let first: Vector3<f64> = reflect(frame.column(0).into(), chord);
    let second = tangent - first;
    let across = reflect(reflect(frame.column(1).into(), chord), &second);
    Matrix3::from_columns(&[*tangent, across, tangent.cross(&across)])
}

/// The command of the equilibrium as that of a bundle whose leader is held.
fn command(equilibrium: &Equilibrium) -> BundleCommand {
    let locked = equilibrium.settings().resolution.angle == 0;
    let mut drives = vec![TubeDrive::HELD];
    drives.extend(equilibrium.drives().iter().map(|a| TubeDrive {
        translation: a.push_pull,
        rotation: if locked { Drive::Motion(0.0) } else { a.rotation },
    }));
    BundleCommand { drives, loads: equilibrium.command().loads.clone() }
}
