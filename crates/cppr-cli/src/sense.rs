//! `cppr sense`: the force on the tip from measured efforts and the tip's pose.

use crate::Failure;
use crate::bundle::Ready;
use crate::command::{CommandArgs, build};
use crate::free::{self, HALF, line, three};
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::{ForTube, Kind, direction, for_tube, scalar, vector};
use crate::resolved::{AccuracyArgs, Resolved};
use crate::rubbing::FrictionArgs;
use crate::table::{millimetres, plain};
use cppr::Vector3;
use cppr::analysis::inverse::{Measured, Principal, Sensed};
use cppr::bundle::Friction;
use cppr::solve::{Freedom, Quantity, Solver};
use cppr_io::bundle_file::Described;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A tip farther than this many lengths from the base is measured in another unit: tubes that stretch do so by percents.
const FARTHEST: f64 = 2.0;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr sense robots/r1.toml --pull 5mm --measured-tension 4.87N --measured-position 120.3,-66.6,7.2mm
  cppr sense robots/r1.toml --pull 5mm --rotate 20deg --measured-tension 5.07N --measured-torque 3.8Nmm --measured-position 120.9,-65.5,-2mm --measured-direction 0.37,-0.93,-0.04 --json -
  cppr sense robots/childs3.toml --pull 2=1mm --pull 3=-0.5mm --measured-tension 2=11.65N --measured-tension 3=-6.72N
  cppr sense robots/r1.toml --pull 5mm --measured-tension 5.2N --measured-position 120.3,-66.6,0mm --friction 0.2

Motions and known loads are given as for cppr solve. What the measurements do not see is named. With --friction
the force is given for motors that were driven on to where they are, and for motors that were driven back.";

/// Arguments of `cppr sense`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// Measured force of a follower, pull positive
    #[arg(long, value_name = "[K=]FORCE", allow_hyphen_values = true, value_parser = |t: &str| for_tube(t, Kind::Force))]
    measured_tension: Vec<ForTube>,
    /// Measured torque of a follower
    #[arg(long, value_name = "[K=]MOMENT", allow_hyphen_values = true, value_parser = |t: &str| for_tube(t, Kind::Moment))]
    measured_torque: Vec<ForTube>,
    /// Measured position of the tip
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Length))]
    measured_position: Option<[f64; 3]>,
    /// Measured direction of the tip
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = direction)]
    measured_direction: Option<[f64; 3]>,
    /// Standard deviation of measured forces
    #[arg(long, value_name = "FORCE", default_value = "0.05N", value_parser = |t: &str| scalar(t, Kind::Force))]
    tension_deviation: f64,
    /// Standard deviation of measured torques
    #[arg(long, value_name = "MOMENT", default_value = "1Nmm", value_parser = |t: &str| scalar(t, Kind::Moment))]
    torque_deviation: f64,
    /// Standard deviation of each coordinate of the position
    #[arg(long, value_name = "LENGTH", default_value = "0.5mm", value_parser = |t: &str| scalar(t, Kind::Length))]
    position_deviation: f64,
    /// Standard deviation of the direction
    #[arg(long, value_name = "ANGLE", default_value = "1deg", value_parser = |t: &str| scalar(t, Kind::Angle))]
    direction_deviation: f64,
    /// Look for a moment on the tip as well
    #[arg(long)]
    moment: bool,
    #[command(flatten)]
    command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    #[command(flatten)]
    friction: FrictionArgs,
    /// Write the answer, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Args {
    fn measured(&self) -> Vec<Measured> {
        let efforts = |list: &[ForTube], freedom: Freedom, deviation: f64| -> Vec<Measured> {
            list.iter().map(|m| Measured::Effort(m.tube, freedom, m.value, deviation)).collect()
        };
        let mut list = efforts(&self.measured_tension, Freedom::PushPull, self.tension_deviation);
        list.extend(efforts(&self.measured_torque, Freedom::Rotation, self.torque_deviation));
        let position = self.measured_position.map(|p| Measured::Position(p.into(), self.position_deviation));
        let direction =
            self.measured_direction.map(|d| Measured::Direction(d.into(), self.direction_deviation));
        list.extend(position.into_iter().chain(direction));
        list
    }
}

/// Fits, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [args.json.as_deref(), None, None])?;
    let measured = args.measured();
    if measured.is_empty() {
        return Err(Failure::Input(
            "say what was measured: --measured-tension, --measured-torque, --measured-position, --measured-direction"
                .into(),
        ));
    }
    let (described, friction) =
        args.accuracy.rubbing(&args.robot, args.command.rest.needs_modes(), args.friction)?;
    match described {
        Described::Robot(file) => {
            let robot = build(&file, &args.robot)?;
            let command = args.command.command(&robot)?;
            believable(robot.length(), args.measured_position)?;
            let mut solver = args.command.solver(&robot)?;
            let find = |solver: &mut Solver| {
                solver.sense(&command, &measured, args.moment).map_err(|p| free::failure(&p))
            };
            let (answer, resolved) = args.accuracy.search(&mut solver, find, |answer| &answer.equilibrium)?;
            finish(args, &outputs, &robot.design().name, &measured, (&answer, None), Some(&resolved))
        }
        Described::Bundle { design, .. } => {
            let ready = Ready::new(&args.command, &args.robot, &design)?;
            believable(ready.bundle.length(), args.measured_position)?;
            let mut analysis = ready.analysis(&design);
            let answer = analysis.sense(&ready.command, &measured, args.moment);
            let answer = answer.map_err(|p| free::failure(&p))?;
            let slipping = friction.map(|friction| {
                let sides = analysis.sense_rubbed(&answer, &ready.command, &measured, args.moment, &friction);
                Ok((friction, sides.map_err(|p| free::failure(&p))?))
            });
            let slipping = slipping.transpose()?;
            finish(args, &outputs, &design.name, &measured, (&answer, slipping.as_ref()), None)
        }
    }
}

/// What is sensed with motors driven on and driven back.
type Slipping<E> = (Friction, [Option<Sensed<E>>; 2]);

/// Writes and prints.
fn finish<E>(
    args: &Args,
    outputs: &Outputs,
    name: &str,
    measured: &[Measured],
    (answer, slipping): (&Sensed<E>, Option<&Slipping<E>>),
    resolved: Option<&Resolved>,
) -> Result<(), Failure> {
    if let Some(path) = outputs.json {
        let mut whole = as_json(name, answer, args.moment);
        whole["accuracy"] = json!(resolved.map(Resolved::json));
        whole["friction"] = json!(slipping.map(|(friction, [loading, unloading])| {
            let side = |own: &Option<Sensed<E>>| {
                own.as_ref().map(|own| {
                    let moment = args.moment.then(|| <[f64; 3]>::from(own.moment));
                    json!({ "force_N": <[f64; 3]>::from(own.force), "moment_Nm": moment })
                })
            };
            json!({ "coefficient": friction.coefficient, "guide_m": friction.guide,
                "loading": side(loading), "unloading": side(unloading) })
        }));
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    let mut text = table(name, answer, args.moment);
    for (head, value) in resolved.into_iter().flat_map(Resolved::lines) {
        line(&mut text, head, &value);
    }
    if let Some((friction, sides)) = slipping {
        for (way, side) in ["driven on", "driven back"].into_iter().zip(sides) {
            let head = format!("friction {}", friction.coefficient);
            let Some(side) = side else {
                line(
                    &mut text,
                    &head,
                    &format!("no force was found that explains this if the motors were {way}"),
                );
                continue;
            };
            let force = three(side.force.into(), 4);
            line(&mut text, &head, &format!("{force} N if the motors were {way}"));
            if args.moment {
                line(&mut text, "", &format!("{} N mm", three((side.moment * 1e3).into(), 4)));
            }
        }
    }
    for (one, miss) in measured.iter().zip(&answer.misses).filter(|(_, miss)| **miss > FAR) {
        line(&mut text, "not explained", &missed(one, *miss));
    }
    outputs.report(&text)
}

/// Refuses a position that no pose of the robot has: its unit is another.
fn believable(length: f64, position: Option<[f64; 3]>) -> Result<(), Failure> {
    let far = position.map_or(0.0, |p| Vector3::from(p).norm());
    if far <= FARTHEST * length {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "--measured-position: the tip of a robot of {} mm cannot be {} mm away from its base. Check the unit",
        millimetres(length),
        millimetres(far)
    )))
}

fn table<E>(name: &str, answer: &Sensed<E>, moment: bool) -> String {
    let mut text = format!("{name}: {} on the tip, base frame\n", if moment { "wrench" } else { "force" });
    let mut components = |name: &str, values: Vector3<f64>, from: usize, size: f64, unit: &str| {
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let deviation = answer.uncertainty.deviations[from + axis];
            let rest = if deviation.is_finite() {
                let value = format!("{:>9}", plain(values[axis] / size, 4));
                format!("{value} ± {} {unit}", plain(HALF * deviation / size, 4))
            } else {
                format!("{:>9}", "not seen")
            };
            line(&mut text, &format!("{name} {letter}"), &rest);
        }
    };
    components("force", answer.force, 0, 1.0, "N");
    if moment {
        components("moment", answer.moment, 3, 1e-3, "N mm");
    }
    let uncertainty = &answer.uncertainty;
    if uncertainty.principal.iter().any(|p| p.blind) {
        let loads = answer.force.iter().chain(answer.moment.iter());
        let shares: Vec<f64> = loads.zip(&uncertainty.units).map(|(load, unit)| load / unit).collect();
        let force = uncertainty.units.first().copied().unwrap_or(f64::NAN);
        for principal in &uncertainty.principal {
            if principal.blind {
                line(&mut text, "not seen", &along(principal));
            } else {
                let value: f64 = principal.direction.iter().zip(&shares).map(|(d, s)| d * s * force).sum();
                let spread = plain(HALF * principal.deviation * force, 4);
                line(
                    &mut text,
                    "seen",
                    &format!("{:>9} ± {spread} N along {}", plain(value, 4), along(principal)),
                );
            }
        }
    }
    let misfit = answer.uncertainty.misfit;
    if misfit.is_finite() {
        let rest =
            format!("{:>9} (1 where the stated deviations are right and the model is)", plain(misfit, 2));
        line(&mut text, "noise / stated", &rest);
    }
    text
}

/// A measurement that lies farther than this many standard deviations from the answer is not explained by it.
const FAR: f64 = 5.0;

fn missed(measured: &Measured, miss: f64) -> String {
    let what = match measured {
        Measured::Effort(tube, freedom, ..) => {
            format!("the measured {} of tube {tube}", Quantity::of(*freedom, false).name)
        }
        Measured::Position(..) => "the measured position".into(),
        Measured::Direction(..) => "the measured direction".into(),
    };
    format!("{what} is off by {miss:.0} of its deviations; check units, command, and what else acts")
}

/// The components that take part.
fn along(principal: &Principal) -> String {
    let names = ["force x", "force y", "force z", "moment x / L", "moment y / L", "moment z / L"];
    let parts = names.iter().zip(&principal.direction).filter(|(_, share)| share.abs() > 0.005);
    parts.map(|(name, share)| format!("{share:+.2} {name}")).collect::<Vec<_>>().join(", ")
}

fn as_json<E>(name: &str, answer: &Sensed<E>, moment: bool) -> Value {
    let n = answer.uncertainty.deviations.len();
    let covariance: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| answer.uncertainty.covariance[(i, j)]).collect()).collect();
    let blind: Vec<&Vec<f64>> =
        answer.uncertainty.principal.iter().filter(|p| p.blind).map(|p| &p.direction).collect();
    json!({
        "schema": "cppr/sense", "schema_version": 1, "robot": name,
        "force_N": <[f64; 3]>::from(answer.force),
        "moment_Nm": moment.then(|| <[f64; 3]>::from(answer.moment)),
        "standard_deviations": answer.uncertainty.deviations, "covariance": covariance, "not_seen": blind,
        "noise_against_stated": answer.uncertainty.misfit, "misses_in_deviations": answer.misses,
    })
}
