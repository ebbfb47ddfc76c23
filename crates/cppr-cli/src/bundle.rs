//! `cppr solve` for bundles: robots with parts, joints, shafts, free tips and curved tubes.

use crate::Failure;
use crate::bundle_figure::{self, Named};
use crate::clearance::Gapped;
use crate::command::{CommandArgs, thread_has_direction, unsound};
use crate::exceeded::Exceeded;
use crate::hysteresis::Unloading;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::rubbing::Touch;
use crate::scenario;
use crate::solve::Args;
use crate::table::{counted, millimetres, plain};
use cppr::analysis::{BundleAnalysis, Teeth};
use cppr::bundle::solve::{BundleCommand, BundleEquilibrium, BundleSolver, TubeEffort, load_behind_plate};
use cppr::bundle::{Bundle, BundleDesign, BundleSection, Friction, Shaft, TubeParts};
use cppr::kinematics::TipPose;
use cppr_io::contact_record;
use cppr_plot::Figure;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

/// Errors below this part of the length are what is promised.
const PROMISED: f64 = 1e-4;
/// Sections through which lines are drawn, at least.
const SMOOTH: f64 = 200.0;

/// Solves, prints, writes.
pub fn run(
    args: &Args,
    outputs: &Outputs,
    design: &BundleDesign,
    friction: Option<Friction>,
) -> Result<(), Failure> {
    let Ready { bundle, command, stretch } = match &args.scenario {
        Some(path) => Ready::with(scenario::bundle_command(path, design)?, &args.robot, design)?,
        None => Ready::new(&args.command, &args.robot, design)?,
    };
    let mut analysis = BundleAnalysis::new(BundleSolver::new(&bundle).with_stretch(stretch), design);
    let start = Instant::now();
    let found = analysis.solver.solve(&command);
    let time = start.elapsed();
    let exceeded = Exceeded::of_bundle(&mut analysis, &found, Teeth::Rigid);
    let solver = &mut analysis.solver;
    check_loads(&command, &found)?;
    let shape = if found.converged {
        solver.shape(&found, found.length / f64::from(args.samples - 1))
    } else {
        Vec::new()
    };
    let touch = if found.converged {
        let touch = Touch::of(solver, &found, friction, args.contact)?;
        let of = |gap| Gapped::of_bundle(solver, &found, design.gaps(), gap, args.guide());
        let gapped = args.clearance.map(of);
        Touch { gapped: gapped.transpose()?, ..touch }
    } else {
        Touch::default()
    };
    let unloading = (args.hysteresis && found.converged)
        .then(|| Unloading::of(design, &command, stretch, &args.robot))
        .transpose()?;
    if let Some(path) = outputs.json {
        let mut whole = record(design, &found, exceeded.as_ref(), &touch, &shape);
        if let (Value::Object(whole), Some(unloading)) = (&mut whole, &unloading) {
            whole.insert("unloading".to_owned(), unloading.json());
        }
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    if !found.converged || shape.is_empty() {
        return Err(no_equilibrium(&design.name, &found));
    }
    thread_has_direction(&command.loads, &TipPose { rotation: found.frame, centre: found.tip })?;
    if let Some(path) = outputs.csv {
        write_or_print(path, &csv(design, &shape, &touch))?;
    }
    outputs.draw(|| {
        let beside = unloading.as_ref().map(|own| ("unloading", own.shape(found.length / SMOOTH)));
        let mut figure = figure(&mut analysis, &found, None, beside)?;
        touch.draw(&mut figure);
        Ok(figure)
    })?;
    let aside = [touch.lines(), unloading.as_ref().map_or(Vec::new(), Unloading::lines)].concat();
    outputs.report(&table(design, &bundle, &found, exceeded.as_ref(), aside, time))
}

/// A bundle, and what is asked of it.
pub struct Ready {
    pub bundle: Bundle,
    pub command: BundleCommand,
    pub stretch: bool,
}

impl Ready {
    /// Builds and checks.
    pub fn new(args: &CommandArgs, robot: &Path, design: &BundleDesign) -> Result<Self, Failure> {
        Self::with(args.bundle_command(design)?, robot, design)
    }

    /// The same for a command, and whether tubes may stretch.
    pub fn with(
        (command, stretch): (BundleCommand, bool),
        robot: &Path,
        design: &BundleDesign,
    ) -> Result<Self, Failure> {
        let bundle = Bundle::new(design).map_err(|problems| unsound(robot, &problems))?;
        check(design, &bundle, &command, stretch)?;
        Ok(Self { bundle, command, stretch })
    }

    /// What it can be asked.
    pub fn analysis<'a>(&'a self, design: &'a BundleDesign) -> BundleAnalysis<'a> {
        BundleAnalysis::new(BundleSolver::new(&self.bundle).with_stretch(self.stretch), design)
    }
}

/// The figure of a pose and marks, over the robot at rest.
pub fn marked(
    analysis: &mut BundleAnalysis,
    found: &BundleEquilibrium,
    marks: Named<[f64; 3]>,
) -> Result<Figure, Failure> {
    figure(analysis, found, marks, None)
}

/// The same with the shape of another pose.
fn figure(
    analysis: &mut BundleAnalysis,
    found: &BundleEquilibrium,
    marks: Named<[f64; 3]>,
    beside: Named<BundleSection>,
) -> Result<Figure, Failure> {
    let design = analysis.design();
    let solver = &mut analysis.solver;
    let spacing = found.length / SMOOTH;
    let pose = solver.shape(found, spacing);
    let rest = solver.rest().cloned();
    let rest = rest.map_or(Vec::new(), |rest| solver.shape(&rest, spacing));
    bundle_figure::draw(design, found, found.command(), &pose, &rest, (marks, beside))
}

/// That a solve found nothing.
pub fn no_equilibrium(robot: &str, found: &BundleEquilibrium) -> Failure {
    Failure::NoEquilibrium(format!("{robot}: {}", found.verdict()))
}

/// What robot and material must allow for this command.
pub fn check(
    design: &BundleDesign,
    bundle: &Bundle,
    command: &BundleCommand,
    stretch: bool,
) -> Result<(), Failure> {
    if let Some((tube, label)) = bundle.joint_behind_plate(&command.drives) {
        return Err(Failure::Input(format!(
            "--pull: tube {} is joined to another at {} mm, which would lie behind the plate; pull less",
            tube + 1,
            millimetres(label)
        )));
    }
    if command.loads.gravity.is_some() && !design.has_mass() {
        return Err(Failure::Input(
            "--gravity: this robot has no mass; add density_kg_m3 or mass_per_length_g_m to its file".into(),
        ));
    }
    if stretch && !design.has_axial_stiffness() {
        return Err(Failure::Input(
            "--stretch: the axial stiffness of a part is not known; add axial_N to its stiffness".into(),
        ));
    }
    Ok(())
}

/// Refuses loads on what was drawn in behind the plate.
pub fn check_loads(command: &BundleCommand, found: &BundleEquilibrium) -> Result<(), Failure> {
    match load_behind_plate(command, found) {
        None => Ok(()),
        Some(label) => Err(Failure::Input(format!(
            "a load acts at {:.3} mm on tube 1, which was drawn in behind the plate there; load what stands before it",
            label * 1e3
        ))),
    }
}

/// Travel (m) and rotation (rad) of the motor behind a shaft.
fn motor(shaft: Shaft, at: &TubeEffort) -> [f64; 2] {
    [at.label + at.force / shaft.axial, at.rotation + at.torque / shaft.torsional]
}

fn table(
    design: &BundleDesign,
    bundle: &Bundle,
    found: &BundleEquilibrium,
    exceeded: Option<&Exceeded>,
    aside: Vec<(String, String)>,
    time: Duration,
) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<22}{value}");
    };
    let three = |v: [f64; 3], digits| v.map(|c| format!("{:>10}", plain(c, digits))).join(" ");
    line("status", found.verdict());
    line("tip position", format!("{} mm", three((found.tip * 1e3).into(), 3)));
    let direction = found.frame.column(0);
    line("tip direction", three([direction.x, direction.y, direction.z], 5));
    line("bend angle", format!("{:>10} deg", plain(bend(found).to_degrees(), 3)));
    line("length of centreline", format!("{:>10} mm", plain(found.length * 1e3, 3)));
    for (i, (at, tube)) in found.efforts.iter().zip(&design.tubes).enumerate() {
        let name = format!("tube {}", i + 1);
        if at.label >= tube.length() {
            line(&name, "behind the plate".into());
            continue;
        }
        let moved = |[label, rotation]: [f64; 2]| (plain(label * 1e3, 3), plain(rotation.to_degrees(), 3));
        let (pull, turn) = moved([at.label, at.rotation]);
        line(&name, format!("pulled {pull:>9} mm with {:>9} N", plain(at.force, 4)));
        line("", format!("turned {turn:>9} deg with {:>9} N mm", plain(at.torque * 1e3, 4)));
        if let Some(shaft) = tube.shaft {
            let (pull, turn) = moved(motor(shaft, at));
            line("", format!("motor  {pull:>9} mm, {turn:>9} deg, behind the shaft"));
        }
    }
    for (name, value) in aside {
        line(&name, value);
    }
    let [tip, force] = found.error;
    line("estimated error", format!("{:.1e} mm of the tip, {force:.1e} N", tip * 1e3));
    let time = time.as_secs_f64() * 1e3;
    line(
        "cost",
        format!("{} Newton steps, {} steps along the robot, {time:.1} ms", found.iterations, found.steps),
    );
    if !found.stable {
        line("warning", "a real robot may be in another shape; approach this one in small steps".into());
    }
    if let Some(exceeded) = exceeded {
        line("beyond limits", exceeded.text());
    }
    let promised = PROMISED * bundle.length();
    if tip.is_nan() || tip > promised {
        line("warning", format!("the tip is not known to within {} mm", plain(promised * 1e3, 3)));
    }
    let (tubes, joints) = (counted(design.tubes.len(), "tube"), counted(design.joints.len(), "joint"));
    format!("{}: {tubes}, {joints}, {} mm\n{text}", design.name, millimetres(bundle.length()))
}

/// Angle between the tip and +X (rad).
pub fn bend(found: &BundleEquilibrium) -> f64 {
    let direction = found.frame.column(0);
    direction.y.hypot(direction.z).atan2(direction.x)
}

/// Motions and efforts of all tubes.
pub fn actuators(design: &BundleDesign, found: &BundleEquilibrium) -> Vec<Value> {
    let own = |(i, (at, tube)): (usize, (&TubeEffort, &TubeParts))| {
        let [travel, turn] = tube.shaft.map_or([at.label, at.rotation], |shaft| motor(shaft, at));
        json!({
            "tube": i + 1, "pull_m": at.label, "rotation_rad": at.rotation,
            "tension_N": at.force, "torque_Nm": at.torque,
            "motor_pull_m": travel, "motor_rotation_rad": turn,
        })
    };
    found.efforts.iter().zip(&design.tubes).enumerate().map(own).collect()
}

fn record(
    design: &BundleDesign,
    found: &BundleEquilibrium,
    exceeded: Option<&Exceeded>,
    touch: &Touch,
    shape: &[BundleSection],
) -> Value {
    let head = json!({
        "schema": "cppr/bundle", "schema_version": 1, "cppr_version": env!("CARGO_PKG_VERSION"),
        "robot": { "name": design.name, "tubes": design.tubes.len() },
        "status": found.status().word(),
    });
    if !found.converged {
        return head;
    }
    let rows = |m: &cppr::Matrix3<f64>| [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
    let sections = shape.iter().map(|s| {
        let tubes = s.tubes.iter().map(|t| {
            json!({
                "tube": t.tube + 1, "abscissa_m": t.label, "angle_rad": t.angle,
                "tension_N": t.tension, "torque_Nm": t.torque,
                "curvature_y_1_m": t.strains[0], "curvature_z_1_m": t.strains[1], "twist_rad_m": t.strains[2],
            })
        });
        json!({
            "length_m": s.length, "centre_m": <[f64; 3]>::from(s.centre), "rotation": rows(&s.frame),
            "tubes": tubes.collect::<Vec<_>>(),
        })
    });
    let mut whole = head;
    let solution = json!({
        "tip_position_m": <[f64; 3]>::from(found.tip), "tip_rotation": rows(&found.frame),
        "bend_angle_rad": bend(found), "length_m": found.length,
        "actuators": actuators(design, found),
        "error": { "tip_m": found.error[0], "force_N": found.error[1] },
        "statistics": { "iterations": found.iterations, "steps": found.steps },
        "sections": sections.collect::<Vec<_>>(),
    });
    if let (Value::Object(whole), Value::Object(solution)) = (&mut whole, solution) {
        whole.extend(solution);
        whole.extend(exceeded.map(|own| ("limit_exceeded".to_owned(), own.json())));
        whole.extend(touch.contact_json().map(|own| ("contact".to_owned(), own)));
        whole.extend(touch.friction_json().map(|own| ("friction".to_owned(), own)));
        whole.extend(touch.clearance_json().map(|own| ("clearance".to_owned(), own)));
    }
    whole
}

fn csv(design: &BundleDesign, shape: &[BundleSection], touch: &Touch) -> String {
    let columns = [
        "abscissa_m",
        "angle_rad",
        "tension_N",
        "torque_Nm",
        "curvature_y_1_m",
        "curvature_z_1_m",
        "twist_rad_m",
    ];
    let mut text = "length_m,centre_x_m,centre_y_m,centre_z_m".to_owned();
    for number in 1..=design.tubes.len() {
        for column in columns {
            let _ = write!(text, ",tube{number}_{column}");
        }
    }
    for pair in &touch.contact.pairs {
        let _ = write!(text, ",{}", contact_record::column(pair));
    }
    text.push('\n');
    for s in shape {
        let _ = write!(text, "{},{},{},{}", s.length, s.centre.x, s.centre.y, s.centre.z);
        for tube in 0..design.tubes.len() {
            match s.tubes.iter().find(|t| t.tube == tube) {
                Some(t) => {
                    let [y, z, twist] = t.strains;
                    for value in [t.label, t.angle, t.tension, t.torque, y, z, twist] {
                        let _ = write!(text, ",{value}");
                    }
                }
                // Beyond its tip a tube has no fields.
                None => text.push_str(&",".repeat(columns.len())),
            }
        }
        for pair in &touch.contact.pairs {
            let outer = s.tubes.iter().find(|t| t.tube == pair.outer);
            let pressed = outer.and_then(|t| pair.at(t.label));
            let _ = write!(text, ",{}", pressed.map_or(String::new(), |force| force.norm().to_string()));
        }
        text.push('\n');
    }
    text
}
