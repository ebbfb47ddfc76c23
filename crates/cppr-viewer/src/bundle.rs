//! Robots with parts and joints on the page: their description, and their poses in the same form as those of other robots.
//!
//! Tubes end apart. In the floats a tube keeps its last values beyond its tip, and the head says at which section it ends.

use crate::describe::{Control, body, nice, offset_and_bending, radii};
use crate::drag;
use crate::message::{self, Message};
use crate::session::{ActuatorState, NotchLimit, Send, Solve, exceeded, ranges, text};
use crate::touch::{Touch, Written};
use cppr::analysis::{BundleAnalysis, RangeProblem, SafeRange, SectionLimit, Teeth};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, load_behind_plate};
use cppr::bundle::{Bundle, BundleDesign, BundleSection, Friction, TubeParts};
use cppr::design::{Outline, TubeDesign};
use cppr::solve::Input;
use cppr::{Matrix3, Vector3};
use cppr_io::Scenario;
use nalgebra::{Rotation3, UnitQuaternion};
use serde::Serialize;
use serde_json::json;
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use web_time::Instant;

/// Values of one tube at one section, as in [`message::COLUMNS`]. Curvatures and twist are those beyond rest; `tension` is the force that
/// its motor would pull with here.
pub(crate) const COLUMNS: [&str; 18] = [
    "abscissa",
    "x",
    "y",
    "z",
    "qx",
    "qy",
    "qz",
    "qw",
    "centroid_x",
    "centroid_y",
    "centroid_z",
    "twist",
    "curvature_y",
    "curvature_z",
    "offset",
    "direction",
    "torque",
    "tension",
];

/// Reach of the control that moves all tubes, as a part of the length.
const ADVANCE: f64 = 0.25;
/// What of a tube is drawn below the plate: as far as its controls push it, and some more.
const BELOW: f64 = 1.2;
/// Labels this close (as a part of themselves) are the same.
const SAME: f64 = 1e-6;

/// A bundle as it is solved.
pub(crate) struct BundleModel {
    design: BundleDesign,
    bundle: Bundle,
    friction: Option<Friction>,
    /// Where sudden changes are for which a robot of tubes of one length is integrated.
    sudden: Option<String>,
    /// Last stable equilibrium, with its command and whether tubes stretched.
    stable: Option<(BundleEquilibrium, BundleCommand, bool)>,
}

/// Safe ranges that are found one after another, while the page asks nothing else: each takes up to some seconds.
pub(crate) struct Ranges {
    command: BundleCommand,
    stretch: bool,
    /// Still to be found, the next one last.
    inputs: Vec<Input>,
    found: Vec<SafeRange>,
}

impl Ranges {
    /// Is every range known?
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty()
    }
}

/// Head of the message that carries a pose; [`crate::session::Pose`] has the words that are not told here.
#[derive(Serialize)]
struct Pose {
    kind: &'static str,
    id: u32,
    dragged: bool,
    status: &'static str,
    text: String,
    exceeded: Option<String>,
    tip_mm: [f64; 3],
    direction: [f64; 3],
    bend_deg: f64,
    actuators: Vec<ActuatorState>,
    limits: Vec<NotchLimit>,
    iterations: usize,
    solve_us: f64,
    sections: usize,
    tubes: usize,
    /// How far the tip moves when every step of the integration is halved.
    error_mm: f64,
    /// Length of the centreline up to each section.
    along_mm: Vec<f64>,
    /// Last section of each tube; −1 where it was drawn in behind the plate.
    ends: Vec<i64>,
    /// The tube that reaches the tip.
    spine: usize,
    /// Section and outermost tube of each joint that is there.
    joints: Vec<[usize; 2]>,
}

impl BundleModel {
    /// `sudden`: places of sudden changes for which a robot of tubes of one length is integrated.
    pub fn new(
        design: BundleDesign,
        friction: Option<Friction>,
        sudden: Option<String>,
    ) -> Result<Self, Vec<String>> {
        let bundle =
            Bundle::new(&design).map_err(|p| p.0.iter().map(ToString::to_string).collect::<Vec<_>>())?;
        Ok(Self { design, bundle, friction, sudden, stable: None })
    }

    /// Tells the page all about the robot; false where the page is gone.
    pub fn describe(&self, send: Send) -> bool {
        let controls = self.controls();
        let length = self.bundle.length();
        let bending: f64 = self.design.tubes.iter().map(|tube| softest(tube)[1]).sum();
        let tubes: Vec<_> = self.design.tubes.iter().map(shown).collect();
        let note = self.sudden.as_ref().map(|places| {
            format!("Modes do not follow sudden changes ({places}): this robot is integrated along its length, as one of parts and joints.")
        });
        send(text(&json!({
            "kind": "robot", "bundle": true, "changed": false, "name": self.design.name, "length_mm": length * 1e3,
            "tubes": tubes, "controls": controls, "advance_mm": advance(length) * 1e3,
            "force_N": nice(3.0 * bending / (length * length)), "has_mass": self.design.has_mass(),
            "can_stretch": self.design.has_axial_stiffness(), "columns": COLUMNS,
            "note": note, "friction": self.friction.map(Written::from),
        }))) && [false, true].into_iter().all(|coarse| {
            controls.iter().enumerate().all(|(tube, control)| {
                let below = BELOW * (advance(length) + control.pull_mm * 1e-3);
                // A tube that is given by its stiffness is drawn as its centroid line.
                let made = body(&self.design, tube, coarse, length, below);
                made.is_none_or(|bytes| send(Message::Binary(bytes)))
            })
        })
    }

    /// Reach of the controls of every tube: about half a turn of the tip where it is joined to another, else a quarter of the length.
    fn controls(&self) -> Vec<Control> {
        let length = self.bundle.length();
        let soft: Vec<[f64; 2]> = self.design.tubes.iter().map(softest).collect();
        let bending: f64 = soft.iter().map(|own| own[1]).sum();
        let control = |tube: usize| {
            let joined = self.design.joints.iter().filter(|joint| joint.iter().any(|own| own.0 == tube));
            let others = joined.flatten().filter(|other| other.0 != tube);
            let lever = others.map(|other| soft[tube][0] + soft[other.0][0]).fold(0.0, f64::max);
            let pull = if lever > 0.0 { (PI * lever).min(ADVANCE * length) } else { ADVANCE * length };
            Control {
                tube: tube + 1,
                pull_mm: nice(pull * 1e3),
                tension: nice(bending * PI / (length * lever.max(0.01 * length))),
                rotate_deg: 180.0,
                torque: nice(bending * PI / length * 1e3),
            }
        };
        (0..self.design.tubes.len()).map(control).collect()
    }

    /// The message that carries the pose; status and reasons where there is none.
    pub fn solve(&mut self, asked: &Solve) -> Result<Vec<u8>, (&'static str, Vec<String>)> {
        let wrong = |reason: String| ("wrong", vec![reason]);
        let (command, stretch) = asked.scenario.bundle_command(&self.design).map_err(|all| ("wrong", all))?;
        if let Some((tube, label)) = self.bundle.joint_behind_plate(&command.drives) {
            return Err(wrong(format!(
                "tube {} is joined to another at {:.3} mm, which would lie behind the plate; pull less",
                tube + 1,
                label * 1e3
            )));
        }
        let mut analysis = self.analysis(stretch);
        let start = self.stable.as_ref().filter(|own| !asked.from_rest && own.2 == stretch);
        // Dragged on from where the robot is, not from where the page had it.
        let mut command = match start {
            Some((_, own, _)) if asked.target_mm.is_some() && own.loads == command.loads => own.clone(),
            _ => command,
        };
        let clock = Instant::now();
        let mut found = match start {
            Some((stable, ..)) => analysis.solver.solve_from(&command, stable),
            None => analysis.solver.solve(&command),
        };
        let solve_us = clock.elapsed().as_secs_f64() * 1e6;
        let none = |found: &BundleEquilibrium| ("not_converged", vec![found.verdict()]);
        if !found.converged {
            return Err(none(&found));
        }
        if let Some(label) = load_behind_plate(&command, &found) {
            return Err(wrong(format!("a load acts at {:.3} mm on tube 1, behind the plate", label * 1e3)));
        }
        if let Some(target) = asked.target_mm {
            let controls = self.controls();
            let target = Vector3::from(target) * 1e-3;
            (found, command) = drag::bundle_towards(&mut analysis.solver, found, command, &controls, target);
        }
        let limits = analysis.section_limits(&found, Teeth::Rigid);
        let shape = analysis.solver.shape(&found, found.length / (message::SECTIONS - 1) as f64);
        if shape.is_empty() {
            return Err(none(&found));
        }
        let pose = self.pose(asked, &found, &shape, &limits, solve_us);
        let bytes = message::encode(&pose, &floats(&self.design, &found, &shape));
        if found.stable {
            self.stable = Some((found, command, stretch));
        }
        Ok(bytes)
    }

    /// How the tubes of the last stable equilibrium touch; `None` where there is none.
    pub fn touch(&self, asked: &Touch) -> Option<Message> {
        let (found, _, stretch) = self.stable.as_ref()?;
        let solver = BundleSolver::new(&self.bundle).with_stretch(*stretch);
        Some(asked.answer(Some((&solver, found))))
    }

    fn analysis(&self, stretch: bool) -> BundleAnalysis<'_> {
        BundleAnalysis::new(BundleSolver::new(&self.bundle).with_stretch(stretch), &self.design)
    }

    /// The ranges that a scenario asks for, all still to be found; `None` where it cannot be asked.
    pub fn ranges(&self, scenario: &Scenario) -> Option<Ranges> {
        let (command, stretch) = scenario.bundle_command(&self.design).ok()?;
        let mut inputs = command.inputs();
        inputs.reverse();
        Some(Ranges { command, stretch, inputs, found: Vec::new() })
    }

    /// Finds the next range and tells the page all that are known, unless `stop` is set meanwhile: then it is found another time.
    /// False where the page is gone.
    pub fn next_range(&self, asked: &mut Ranges, stop: &Arc<AtomicBool>, send: Send) -> bool {
        let Some(&input) = asked.inputs.last() else { return true };
        let mut analysis = self.analysis(asked.stretch);
        analysis.stop_by(Some(Arc::clone(stop)));
        match analysis.safe_range(&asked.command, input, Teeth::Rigid) {
            Ok(range) => {
                asked.found.push(range);
                asked.inputs.pop();
            }
            Err(RangeProblem::Stopped) => return true,
            // The pose itself is not safe.
            Err(_) => asked.inputs.clear(),
        }
        send(ranges(&asked.found))
    }

    fn pose(
        &self,
        asked: &Solve,
        found: &BundleEquilibrium,
        shape: &[BundleSection],
        limits: &[SectionLimit],
        solve_us: f64,
    ) -> Pose {
        let count = self.design.tubes.len();
        let end = |tube| shape.iter().rposition(|s| s.tubes.iter().any(|own| own.tube == tube));
        let ends: Vec<Option<usize>> = (0..count).map(end).collect();
        let actuators = found.efforts.iter().zip(&self.design.tubes).enumerate().map(|(i, (at, tube))| {
            // The motors' motions, which scenarios prescribe.
            let wound = tube.shaft.map_or([0.0; 2], |s| [at.force / s.axial, at.torque / s.torsional]);
            ActuatorState {
                tube: i + 1,
                pull_mm: (at.label + wound[0]) * 1e3,
                rotate_deg: (at.rotation + wound[1]).to_degrees(),
                tension: at.force,
                torque: at.torque * 1e3,
            }
        });
        let direction: Vector3<f64> = found.frame.column(0).into();
        Pose {
            kind: "pose",
            id: asked.id,
            dragged: asked.target_mm.is_some(),
            status: found.status().word(),
            text: found.verdict(),
            exceeded: exceeded(limits),
            tip_mm: (found.tip * 1e3).into(),
            direction: direction.into(),
            bend_deg: direction.x.clamp(-1.0, 1.0).acos().to_degrees(),
            actuators: actuators.collect(),
            limits: limits.iter().map(NotchLimit::from).collect(),
            iterations: found.iterations,
            solve_us,
            sections: shape.len(),
            tubes: count,
            error_mm: found.error[0] * 1e3,
            along_mm: shape.iter().map(|s| s.length * 1e3).collect(),
            spine: (0..count).max_by_key(|&tube| ends[tube]).unwrap_or(0),
            ends: ends.iter().map(|end| end.and_then(|s| i64::try_from(s).ok()).unwrap_or(-1)).collect(),
            joints: self.design.joints.iter().filter_map(|joint| place(joint, shape)).collect(),
        }
    }
}

/// Section and outermost tube of a joint, unless it lies behind the plate.
fn place(joint: &[(usize, f64)], shape: &[BundleSection]) -> Option<[usize; 2]> {
    let &(tube, label) = joint.iter().min_by_key(|own| own.0)?;
    let near =
        |s: &BundleSection| s.tubes.iter().any(|t| t.tube == tube && (t.label - label).abs() <= SAME * label);
    Some([shape.iter().position(near)?, tube])
}

/// The way by which all tubes are moved together (m).
fn advance(length: f64) -> f64 {
    nice(ADVANCE * length * 1e3) * 1e-3
}

/// Greatest centroid offset (m) and least bending stiffness (N m²) of a tube's parts.
fn softest(tube: &TubeParts) -> [f64; 2] {
    let parts = tube.parts.iter().filter(|part| part.length > 0.0);
    parts
        .map(|part| offset_and_bending(&part.body, part.length))
        .fold([0.0, f64::INFINITY], |all, own| [all[0].max(own[0]), all[1].min(own[1])])
}

/// A tube for the page. Its notches are in its body; there is no control that changes them.
fn shown(tube: &TubeParts) -> serde_json::Value {
    let outline = tube.parts.iter().find_map(|part| match &part.body {
        TubeDesign::Notched(own) => Some(&own.outline),
        TubeDesign::Stiffness(_) => None,
    });
    let sides = match outline {
        Some(&Outline::Polygon { sides, .. }) => sides,
        _ => 0,
    };
    let radii = outline.map(radii);
    json!({
        "outer_mm": radii.map(|r| r[0] * 1e3), "inner_mm": radii.map(|r| r[1] * 1e3), "sides": sides, "depth_mm": [],
    })
}

fn floats(design: &BundleDesign, found: &BundleEquilibrium, shape: &[BundleSection]) -> Vec<f32> {
    // Behind the plate a tube lies along the axis.
    let mut rows: Vec<[f64; COLUMNS.len()]> = found
        .efforts
        .iter()
        .map(|at| {
            let mut row = [0.0; COLUMNS.len()];
            row[0] = at.label * 1e3;
            (row[4], row[7]) = (0.5 * at.rotation).sin_cos();
            row
        })
        .collect();
    let mut out = Vec::with_capacity(shape.len() * design.tubes.len() * COLUMNS.len());
    for section in shape {
        for own in &section.tubes {
            let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), own.rotation);
            let material: Matrix3<f64> = section.frame * turn.matrix();
            let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(material)).coords;
            let (sin, cos) = own.angle.sin_cos();
            let c = section.centre * 1e3;
            let centroid = c + section.frame * Vector3::new(0.0, cos, sin) * (own.centroid_offset * 1e3);
            let [curvature_y, curvature_z, twist] = own.strains;
            rows[own.tube] = [
                own.label * 1e3,
                c.x,
                c.y,
                c.z,
                q.x,
                q.y,
                q.z,
                q.w,
                centroid.x,
                centroid.y,
                centroid.z,
                twist,
                curvature_y,
                curvature_z,
                own.centroid_offset * 1e3,
                own.angle - own.rotation,
                own.torque * 1e3,
                own.tension,
            ];
        }
        #[allow(clippy::cast_possible_truncation, reason = "for drawing")]
        out.extend(rows.iter().flatten().map(|&v| v as f32));
    }
    out
}
