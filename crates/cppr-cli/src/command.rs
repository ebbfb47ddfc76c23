//! The options that say what is asked of a robot, and the command they make.

use crate::Failure;
use crate::quantity::{ForTube, Kind, for_any_tube, scalar, vector};
use cppr::Vector3;
use cppr::analysis::explained;
use cppr::bundle::solve::{BundleCommand, TubeDrive};
use cppr::bundle::{BundleDesign, TubeParts};
use cppr::design::{DesignProblems, Robot};
use cppr::kinematics::{Resolution, TipPose};
use cppr::solve::{
    Command, CommandProblem, Draft, Equilibrium, Formulation, Freedom, Input, Quantity, Settings, Solver,
};
use cppr::statics::{DistributedForce, Frame, LoadPart, Loads, RotationMeans, Station, Thread, Wrench};
use cppr_io::RobotFile;
use cppr_io::bundle_file::{self, Described};
use std::path::Path;

/// Distance from an eyelet (m) up to which the tip is in it.
const CONTACT: f64 = 1e-6;

/// How finely the fields are resolved.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ModesArg {
    /// Tip within 1e-4 of the length, for every robot shipped.
    Default,
    /// The paper's 3 + 3 + 3 + 2: some times faster, tip within 2e-2 of the length.
    Paper,
}

/// Which conditions of equilibrium are solved.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum FormulationArg {
    /// Stationary total energy.
    Consistent,
    /// The paper's projection of wrenches, for comparison.
    Printed,
}

/// Actuators and tip load, each of one value.
#[derive(Clone, Default, clap::Args)]
pub struct DriveArgs {
    /// Pull a tube by a length (push: negative). Without K= tube 2; repeat for more tubes; 1 only where a file has parts or joints
    #[arg(long, value_name = "[K=]LENGTH", allow_hyphen_values = true, value_parser = |t: &str| for_any_tube(t, Kind::Length))]
    pub pull: Vec<ForTube>,
    /// Turn a tube's base, right-handed about the insertion axis
    #[arg(long, value_name = "[K=]ANGLE", allow_hyphen_values = true, value_parser = |t: &str| for_any_tube(t, Kind::Angle))]
    pub rotate: Vec<ForTube>,
    /// Pull a tube with a force instead
    #[arg(long, value_name = "[K=]FORCE", allow_hyphen_values = true, value_parser = |t: &str| for_any_tube(t, Kind::Force))]
    pub tension: Vec<ForTube>,
    /// Turn a tube with a torque instead
    #[arg(long, value_name = "[K=]MOMENT", allow_hyphen_values = true, value_parser = |t: &str| for_any_tube(t, Kind::Moment))]
    pub torque: Vec<ForTube>,
    /// Force on the tip, base frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Force))]
    pub tip_force: Option<[f64; 3]>,
    /// Moment on the tip, base frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Moment))]
    pub tip_moment: Option<[f64; 3]>,
}

/// Actuation, loads and how to solve; shared by all sub-commands that solve one pose.
#[derive(clap::Args)]
pub struct CommandArgs {
    #[command(flatten)]
    pub drive: DriveArgs,
    #[command(flatten)]
    pub rest: RestArgs,
}

/// Further loads and how to solve; shared by all sub-commands that solve.
// Flags of a command line are booleans by nature.
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, clap::Args)]
pub struct RestArgs {
    /// --rotate means the angle between follower and leader at the plate (the paper's Figure 22), not the motor
    #[arg(long)]
    relative_angle: bool,
    /// Where --tip-force acts, in the tip's frame; default its centre
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Length))]
    tip_point: Option<[f64; 3]>,
    /// Tip force and moment turn with the tip
    #[arg(long)]
    follower_load: bool,
    /// Force at a section along the robot, for instance 60mm:0,0.1,0N
    #[arg(long, value_name = "AT:X,Y,Z", allow_hyphen_values = true, value_parser = point_force)]
    point_force: Vec<(f64, [f64; 3])>,
    /// Force per length on a stretch of the robot, for instance 0..100mm:0,-1,0N/m
    #[arg(long, value_name = "FROM..TO:X,Y,Z", allow_hyphen_values = true, value_parser = distributed)]
    distributed: Vec<DistributedForce>,
    /// Gravity on all tubes, for instance 0,0,-9.81m/s2
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Acceleration))]
    gravity: Option<[f64; 3]>,
    /// Thread from the tip over a pulley, for instance 0.1962N:150,-24,0mm; with radius and side
    /// 0.1962N:150,-24,0mm:4mm:right; tied not to the tip's centre but at a point of its frame
    /// 0.1962N:150,-24,0mm:0mm:left:0,3,0mm
    #[arg(long, value_name = "FORCE:X,Y,Z[:RADIUS[:SIDE[:POINT]]]", allow_hyphen_values = true, value_parser = thread)]
    thread: Vec<Thread>,
    /// Conditions of equilibrium
    #[arg(long, value_enum, default_value_t = FormulationArg::Consistent)]
    formulation: FormulationArg,
    /// Let the tubes stretch
    #[arg(long)]
    stretch: bool,
    /// Five modes, nothing leaves the plane: fast, blind to lateral instability
    #[arg(long)]
    planar: bool,
    /// Modes of the fields in space
    #[arg(long, value_enum, default_value_t = ModesArg::Default, conflicts_with = "planar")]
    modes: ModesArg,
    /// Multiply modes and nodes, to see whether the answer stays
    #[arg(long, value_name = "FACTOR", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=8))]
    refine: u8,
}

impl RestArgs {
    /// Is something asked for that only the solver with modes has?
    pub fn needs_modes(&self) -> bool {
        let Self { relative_angle, formulation, planar, modes, refine, .. } = self;
        *relative_angle
            || *planar
            || *refine > 1
            || !matches!((formulation, modes), (FormulationArg::Consistent, ModesArg::Default))
    }
}

fn point_force(text: &str) -> Result<(f64, [f64; 3]), String> {
    let (at, force) =
        text.split_once(':').ok_or("write place and force, for instance 60mm:0,0.1,0N".to_string())?;
    Ok((scalar(at, Kind::Length)?, vector(force, Kind::Force)?))
}

fn distributed(text: &str) -> Result<DistributedForce, String> {
    let example = "write a stretch and a force per length, for instance 0..100mm:0,-1,0N/m";
    let (span, force) = text.split_once(':').ok_or(example.to_string())?;
    let (from, to) = span.split_once("..").ok_or(example.to_string())?;
    let end = scalar(to, Kind::Length)?;
    // The first end may share the unit of the second.
    let unit: String = to.chars().skip_while(|c| !c.is_alphabetic() && *c != 'µ').collect();
    let start = scalar(from, Kind::Length).or_else(|_| scalar(&format!("{from}{unit}"), Kind::Length))?;
    if start >= end {
        return Err(format!("{span} does not lead towards the tip: write the smaller abscissa first"));
    }
    let force = Vector3::from(vector(force, Kind::ForcePerLength)?);
    Ok(DistributedForce { force, from: start, to: end })
}

fn thread(text: &str) -> Result<Thread, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (tension, pulley, rest) = match parts[..] {
        [tension, pulley, ref rest @ ..] if rest.len() <= 3 => (tension, pulley, rest),
        _ => return Err("write tension and pulley, for instance 0.1962N:150,-24,0mm:4mm:left".into()),
    };
    let left = match rest.get(1) {
        None | Some(&"left") => true,
        Some(&"right") => false,
        Some(side) => return Err(format!("the side is left or right, not {side}")),
    };
    let not_negative = |what: &str, text: &str, kind| match scalar(text, kind)? {
        value if value < 0.0 => Err(format!("{what} is {text}; it cannot be negative")),
        value => Ok(value),
    };
    Ok(Thread {
        tension: not_negative("the tension of the thread", tension, Kind::Force)?,
        pulley: vector(pulley, Kind::Length)?.into(),
        radius: rest
            .first()
            .map_or(Ok(0.0), |r| not_negative("the radius of the pulley", r, Kind::Length))?,
        left,
        point: rest.get(2).map_or(Ok([0.0; 3]), |point| vector(point, Kind::Length))?.into(),
    })
}

impl CommandArgs {
    /// Every actuator that is given, with its value.
    fn drives(&self) -> impl Iterator<Item = (Quantity, ForTube)> + '_ {
        let DriveArgs { pull, rotate, tension, torque, .. } = &self.drive;
        let lists = Quantity::ALL.into_iter().zip([pull, tension, rotate, torque]);
        lists.flat_map(|(quantity, list)| list.iter().map(move |own| (quantity, *own)))
    }

    /// Inputs that are given.
    pub fn given(&self) -> Vec<Input> {
        self.drives().map(|(quantity, own)| quantity.of_tube(own.tube)).collect()
    }

    /// Settings of the solver.
    pub fn settings(&self) -> Settings {
        let base = match self.rest.modes {
            _ if self.rest.planar => Resolution::PLANAR,
            ModesArg::Default => Resolution::SPATIAL,
            ModesArg::Paper => Resolution::PAPER,
        };
        let resolution = base.refined(usize::from(self.rest.refine));
        let formulation = match self.rest.formulation {
            FormulationArg::Consistent => Formulation::Consistent,
            FormulationArg::Printed => Formulation::Printed,
        };
        let settings = Settings { formulation, ..Settings::default() }.with_resolution(resolution);
        if self.rest.stretch { settings.with_stretch() } else { settings }
    }

    /// A solver of the robot with these settings.
    pub fn solver(&self, robot: &Robot) -> Result<Solver, Failure> {
        Solver::with_settings(robot, self.settings()).map_err(|p| Failure::Input(p.to_string()))
    }

    /// Options that say something about a load that is not there.
    fn check(&self) -> Result<(), Failure> {
        let fail = |message: &str| Err(Failure::Input(message.into()));
        if self.rest.follower_load && self.drive.tip_force.is_none() && self.drive.tip_moment.is_none() {
            return fail("--follower-load says how a tip load turns: add --tip-force or --tip-moment");
        }
        if self.rest.tip_point.is_some() && self.drive.tip_force.is_none() {
            return fail(if self.rest.thread.is_empty() {
                "--tip-point says where the tip force acts: add --tip-force"
            } else {
                "--tip-point says where the tip force acts: add --tip-force, or write where a thread is tied behind it, as in \
                 --thread 0.2N:150,-24,0mm:0mm:left:0,3,0mm"
            });
        }
        Ok(())
    }

    /// The command for a robot.
    pub fn command(&self, robot: &Robot) -> Result<Command, Failure> {
        self.check()?;
        let mut draft = Draft::new(robot);
        draft.command.loads = self.loads();
        if self.rest.relative_angle {
            draft.command.rotation_means = RotationMeans::RelativeAngle;
        }
        for (quantity, ForTube { tube, value }) in self.drives() {
            let problem = |p| Failure::Input(format!("--{}: {p}", quantity.keyword));
            draft.set(quantity.of_tube(tube), value).map_err(problem)?;
        }
        match draft.command.check(robot, &self.settings()) {
            Err(problem @ CommandProblem::NotPlanar(None)) => {
                Err(Failure::Input(format!("--planar: {problem}; leave --planar away")))
            }
            Err(CommandProblem::NotPlanar(Some(part))) => Err(Failure::Input(format!(
                "{} acts out of the plane X-Y, which --planar does not see; leave --planar away",
                option(part)
            ))),
            // What else is wrong with it the solver says.
            _ => Ok(draft.command),
        }
    }

    /// The command for a bundle, and whether its tubes may stretch.
    pub fn bundle_command(&self, design: &BundleDesign) -> Result<(BundleCommand, bool), Failure> {
        let rest = &self.rest;
        let not_here = [
            ("--relative-angle", rest.relative_angle, "motors turn tubes against the plate"),
            (
                "--formulation printed",
                matches!(rest.formulation, FormulationArg::Printed),
                "the paper's equations know one joint",
            ),
            ("--planar", rest.planar, "its equations have no modes"),
            ("--modes", rest.modes == ModesArg::Paper, "its equations have no modes"),
            ("--refine", rest.refine != 1, "its steps follow their error, which the table states"),
        ];
        if let Some((name, _, why)) = not_here.into_iter().find(|(_, given, _)| *given) {
            return Err(Failure::Input(format!(
                "{name} is not for a robot with parts or joints, nor for friction: {why}; leave it away"
            )));
        }
        self.check()?;
        let loads = self.loads();
        let length = design.tubes.first().map_or(0.0, TubeParts::length);
        let outside = |label: &f64| !(0.0..=length * (1.0 + 1e-9)).contains(label);
        let places = rest.point_force.iter().map(|p| ("--point-force", p.0));
        let stretches =
            rest.distributed.iter().flat_map(|d| [("--distributed", d.from), ("--distributed", d.to)]);
        if let Some((name, label)) = places.chain(stretches).find(|(_, label)| outside(label)) {
            return Err(Failure::Input(format!(
                "{name}: {:.3} mm does not lie on tube 1, which is {:.3} mm long",
                label * 1e3,
                length * 1e3
            )));
        }
        let mut drives = vec![TubeDrive::HELD; design.tubes.len()];
        let mut given: Vec<Input> = Vec::new();
        for (quantity, ForTube { tube, value }) in self.drives() {
            let input = quantity.of_tube(tube);
            let fail = |problem: &dyn std::fmt::Display| {
                Failure::Input(format!("--{}: {problem}", quantity.keyword))
            };
            if let Some(&earlier) = given.iter().find(|own| own.is_same_freedom(input)) {
                return Err(fail(&CommandProblem::Twice { earlier, later: input }));
            }
            let Some(own) = tube.checked_sub(1).and_then(|index| drives.get_mut(index)) else {
                let count = design.tubes.len();
                return Err(fail(&format!("there is no tube {tube}; this robot has {count}")));
            };
            given.push(input);
            *(match input.freedom {
                Freedom::PushPull => &mut own.translation,
                Freedom::Rotation => &mut own.rotation,
            }) = input.prescribed(value);
        }
        Ok((BundleCommand { drives, loads }, rest.stretch))
    }

    fn loads(&self) -> Loads {
        let point = self.rest.tip_point.unwrap_or_default().into();
        let frame = if self.rest.follower_load { Frame::Section } else { Frame::World };
        let mut wrenches = Vec::new();
        if self.drive.tip_force.is_some() || self.drive.tip_moment.is_some() {
            wrenches.push(Wrench {
                force: self.drive.tip_force.unwrap_or_default().into(),
                moment: self.drive.tip_moment.unwrap_or_default().into(),
                frame,
                station: Station::Tip,
                point,
            });
        }
        for &(at, force) in &self.rest.point_force {
            let wrench = Wrench::tip_force(force.into());
            wrenches.push(Wrench { station: Station::Label(at), ..wrench });
        }
        Loads {
            wrenches,
            distributed: self.rest.distributed.clone(),
            gravity: self.rest.gravity.map(Vector3::from),
            threads: self.rest.thread.clone(),
        }
    }
}

/// The option that gives a part of the loads.
fn option(part: LoadPart) -> &'static str {
    match part {
        LoadPart::Force(Station::Tip) => "--tip-force",
        LoadPart::Moment(Station::Tip) => "--tip-moment",
        LoadPart::Point(Station::Tip) => "--tip-point",
        LoadPart::Force(Station::Label(_))
        | LoadPart::Moment(Station::Label(_))
        | LoadPart::Point(Station::Label(_)) => "--point-force",
        LoadPart::Distributed => "--distributed",
        LoadPart::Gravity => "--gravity",
        LoadPart::Thread => "--thread",
    }
}

/// That a solve found nothing, and what of its command may be mistaken.
pub fn no_equilibrium(found: &Equilibrium) -> Failure {
    let robot = found.robot();
    Failure::NoEquilibrium(format!(
        "{}: {}",
        robot.design().name,
        explained(robot, found.command(), found.status())
    ))
}

/// Refuses a tip that lies on a pulley: there the thread has no direction.
pub fn thread_has_direction(loads: &Loads, tip: &TipPose) -> Result<(), Failure> {
    let on_pulley = |t: &&Thread| {
        let knot = tip.centre + tip.rotation * t.point;
        (t.pulley - knot).norm() <= t.radius.max(CONTACT)
    };
    match loads.threads.iter().find(on_pulley) {
        None => Ok(()),
        Some(_) => Err(Failure::NoEquilibrium(
            "--thread: the tip lies on the pulley, where the thread pulls in no direction; move the pulley"
                .into(),
        )),
    }
}

/// Reads a robot file and builds its robot.
pub fn read_robot(path: &Path) -> Result<(RobotFile, Robot), Failure> {
    let file = cppr_io::robot_file::read(path).map_err(|p| Failure::Input(p.to_string()))?;
    let robot = build(&file, path)?;
    Ok((file, robot))
}

/// Reads a robot file, with or without parts and joints.
pub fn described(path: &Path) -> Result<Described, Failure> {
    bundle_file::read(path).map_err(|problem| Failure::Input(problem.to_string()))
}

/// Builds the robot of a file.
pub fn build(file: &RobotFile, path: &Path) -> Result<Robot, Failure> {
    Robot::from_design(file.design.clone()).map_err(|problems| unsound(path, &problems))
}

/// Problems of a design, each under the name of its file.
pub fn unsound(path: &Path, problems: &DesignProblems) -> Failure {
    let list: Vec<String> = problems.0.iter().map(|p| format!("{}: {p}", path.display())).collect();
    Failure::Input(list.join("\n"))
}
