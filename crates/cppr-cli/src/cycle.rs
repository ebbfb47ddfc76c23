//! `cppr cycle`: a history of commands with friction between the tubes.

use crate::Failure;
use crate::bundle;
use crate::checkpoint::Checkpoint;
use crate::command::{CommandArgs, DriveArgs, RestArgs, build, described};
use crate::cycle_figure;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::quantity::{ForTube, Kind, path_for_any_tube, vector};
use crate::rubbing::{coefficient, guide};
use crate::table::plain;
use cppr::bundle::solve::{BundleCommand, BundleSolver, TubeEffort};
use cppr::bundle::{Bundle, Friction, HistoryPoint, SlipHistory};
use cppr::solve::{Input, Quantity};
use cppr_io::bundle_file::Described;
use cppr_io::contact_record;
use indicatif::ProgressBar;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr cycle robots/r1.toml --pull 0..7..-7..7mm --friction 0.2 --plot loop.svg
  cppr cycle robots/r1.toml --pull 0..7..-7..7mm --friction 0.2 --guide 20mm --steps 7 --csv loop.csv
  cppr cycle robots/childs3.toml --pull 2=0..1..0..1mm --rotate 3=0..40..0..40deg --friction 0.1 --steps 4 --json -
  cppr cycle robots/r1.toml --pull 4mm --rotate 0..90..-90..90deg --friction 0.2 --steps 5 --checkpoint kept.json

A path names the values at which the motors turn back, with one unit behind the last. Motors with a path move together, from one value to the next;
the others, and the loads, come first and stay. The robot begins at rest, where nothing has slipped yet.
Exit codes: 0 done, 2 wrong input, 3 the robot does not get there.";

/// Arguments of `cppr cycle`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    pub robot: PathBuf,
    /// Pull a tube along a path of lengths, for instance 0..7..-7..7mm, or by one. Without K= tube 2; repeat for more tubes
    #[arg(long, value_name = "[K=]PATH", allow_hyphen_values = true, value_parser = |t: &str| path_for_any_tube(t, Kind::Length))]
    pub pull: Vec<ForTube<Vec<f64>>>,
    /// Turn a tube's base along a path of angles, or by one
    #[arg(long, value_name = "[K=]PATH", allow_hyphen_values = true, value_parser = |t: &str| path_for_any_tube(t, Kind::Angle))]
    pub rotate: Vec<ForTube<Vec<f64>>>,
    /// Pull a tube with forces instead
    #[arg(long, value_name = "[K=]PATH", allow_hyphen_values = true, value_parser = |t: &str| path_for_any_tube(t, Kind::Force))]
    pub tension: Vec<ForTube<Vec<f64>>>,
    /// Turn a tube with torques instead
    #[arg(long, value_name = "[K=]PATH", allow_hyphen_values = true, value_parser = |t: &str| path_for_any_tube(t, Kind::Moment))]
    pub torque: Vec<ForTube<Vec<f64>>>,
    /// Force on the tip, base frame
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = |t: &str| vector(t, Kind::Force))]
    pub tip_force: Option<[f64; 3]>,
    #[command(flatten)]
    pub rest: RestArgs,
    /// Coefficient of friction between the tubes; default: that of the robot file
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, value_parser = coefficient)]
    pub friction: Option<f64>,
    /// Length of the guide below the plate in which tubes are held: adds its friction; default: that of the robot file
    #[arg(long, value_name = "LENGTH", value_parser = guide)]
    pub guide: Option<f64>,
    /// Steps from one value of the path to the next, short after the turn and longer further on
    #[arg(long, default_value_t = 14, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub steps: u32,
    /// Keep what is done in this file, and go on with what is in it: a history that was stopped loses a second. It is removed at the end
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Write the points of the history and what they tell, - for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the points of the history, - for standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw effort and tip against the motor, .svg or .png
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
}

/// One point of a history.
pub struct Point {
    /// Number of the leg, from one value of the path to the next.
    pub leg: usize,
    pub reached: HistoryPoint,
}

/// A history that was driven.
pub struct History {
    pub name: String,
    pub points: Vec<Point>,
    /// The motor that the loops are drawn over.
    pub motor: Input,
    /// Index of the point at the end of every leg.
    pub turns: Vec<usize>,
}

/// Effort and tip on the two ways of the last closed loop.
pub struct Loop {
    /// First and last point.
    pub range: [usize; 2],
    /// Work of all motors (J).
    pub energy: f64,
}

/// Part of the length over which slip has to turn round for the motion not to be lost any more: next to the joint of the tips there is none.
const TURNED: f64 = 0.95;

impl History {
    /// What its motor does, and with which effort, at a point (SI).
    pub fn motion(&self, own: &Point) -> [f64; 2] {
        let at = &own.reached.efforts[self.motor.tube - 1];
        match self.motor.freedom {
            cppr::solve::Freedom::PushPull => [at.label, at.force],
            cppr::solve::Freedom::Rotation => [at.rotation, at.torque],
        }
    }

    /// The last loop that closes: from an end of a leg at which the motors stood as they do last.
    fn closed(&self, waypoints: &[Vec<f64>]) -> Option<Loop> {
        let last = waypoints.len().checked_sub(1)?;
        let same = |a: usize| waypoints[a].iter().zip(&waypoints[last]).all(|(x, y)| (x - y).abs() <= 0.0);
        let from = (0..last).rev().find(|&a| same(a) && last - a > 1)?;
        let range = [self.turns[from], self.turns[last]];
        let work = |pair: &[Point]| -> f64 {
            let both = pair[0].reached.efforts.iter().zip(&pair[1].reached.efforts);
            both.map(|(a, b)| {
                0.5 * ((a.force + b.force) * (b.label - a.label)
                    + (a.torque + b.torque) * (b.rotation - a.rotation))
            })
            .sum()
        };
        let energy = self.points[range[0]..=range[1]].windows(2).map(work).sum();
        Some(Loop { range, energy })
    }

    /// From the end of every leg but the last on: how far the motor moves until slip has turned round, where it does on that leg.
    fn lost(&self) -> Vec<(usize, Option<f64>)> {
        let legs = self.turns.windows(2).filter(|pair| pair[0] > 0);
        legs.map(|pair| {
            let [start, _] = self.motion(&self.points[pair[0]]);
            let mut before = (0.0, 0.0);
            let found = self.points[pair[0] + 1..=pair[1]].iter().find_map(|point| {
                let here = ((self.motion(point)[0] - start).abs(), point.reached.slipping);
                let share = (TURNED - before.1) / (here.1 - before.1);
                let reached =
                    (here.1 >= TURNED).then(|| before.0 + share.clamp(0.0, 1.0) * (here.0 - before.0));
                before = here;
                reached
            });
            (pair[0], found)
        })
        .collect()
    }
}

/// Drives, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [&args.json, &args.csv, &args.plot].map(Option::as_deref))?;
    let paths = Paths::new(args)?;
    let command = CommandArgs {
        drive: DriveArgs { tip_force: args.tip_force, ..paths.drives(0) },
        rest: args.rest.clone(),
    };
    let described = described(&args.robot)?;
    let friction = friction(args, described.friction())?;
    let (name, bundle, base, stretch) = match described {
        Described::Robot(file) => {
            let robot = build(&file, &args.robot)?;
            let settings = command.settings();
            let asked = command.command(&robot)?;
            asked.check(&robot, &settings).map_err(|problem| Failure::Input(problem.to_string()))?;
            if asked.rotation_means != cppr::statics::RotationMeans::Base
                || settings.formulation != cppr::solve::Formulation::Consistent
            {
                return Err(Failure::Input(
                    "friction is for motors that turn bases, in the consistent formulation; leave --relative-angle and --formulation printed away".into(),
                ));
            }
            let bundle = Bundle::from_robot(&robot).map_err(|p| Failure::Input(p.to_string()))?;
            (file.design.name, bundle, BundleCommand::from(&asked), settings.resolution.stretch > 0)
        }
        Described::Bundle { design, .. } => {
            let bundle::Ready { bundle, command, stretch } =
                bundle::Ready::new(&command, &args.robot, &design)?;
            (design.name.clone(), bundle, command, stretch)
        }
    };
    let course = Course { name, base, stretch, friction, paths, steps: args.steps };
    let mut solver = BundleSolver::new(&bundle).with_stretch(course.stretch);
    let kept = args.checkpoint.as_deref().map(|path| Checkpoint::new(path, args, &course)).transpose()?;
    let history = course.drive(&mut solver, kept)?;
    let Course { paths, friction, .. } = course;
    let closed = history.closed(&paths.waypoints);
    if let Some(path) = outputs.json {
        write_or_print(path, &format!("{:#}\n", record(&history, &friction, closed.as_ref())))?;
    }
    if let Some(path) = outputs.csv {
        write_or_print(path, &csv(&history))?;
    }
    outputs.draw(|| Ok(cycle_figure::draw(&history, &friction)))?;
    outputs.report(&table(&history, &friction, closed.as_ref()))
}

/// How the tubes rub: as the options say, else as the robot file does.
fn friction(args: &Args, own: Option<Friction>) -> Result<Friction, Failure> {
    let coefficient = args.friction.or(own.map(|own| own.coefficient)).ok_or_else(|| {
        let text = "say how the tubes rub: give --friction, or write [friction] in the robot file";
        Failure::Input(text.into())
    })?;
    Ok(Friction { coefficient, guide: args.guide.or(own.and_then(|own| own.guide)) })
}

/// Motors that move, and the values at which they turn back.
#[derive(Debug)]
struct Paths {
    given: Vec<(Quantity, ForTube<Vec<f64>>)>,
    /// Motors with a path.
    moving: Vec<Input>,
    /// Per end of a leg: values of the moving motors.
    waypoints: Vec<Vec<f64>>,
}

impl Paths {
    fn new(args: &Args) -> Result<Self, Failure> {
        let lists = [&args.pull, &args.tension, &args.rotate, &args.torque];
        let given: Vec<_> = Quantity::ALL
            .into_iter()
            .zip(lists)
            .flat_map(|(quantity, list)| list.iter().map(move |own| (quantity, own.clone())))
            .collect();
        let paths: Vec<_> = given.iter().filter(|own| own.1.value.len() > 1).collect();
        let Some(first) = paths.first() else {
            return Err(Failure::Input(
                "no motor moves: give a path, for instance --pull 0..7..-7..7mm".into(),
            ));
        };
        let length = first.1.value.len();
        if let Some((quantity, own)) = paths.iter().find(|own| own.1.value.len() != length) {
            return Err(Failure::Input(format!(
                "--{}: the path of tube {} has {} values and another has {length}; motors move together, give both as many",
                quantity.keyword,
                own.tube,
                own.value.len()
            )));
        }
        let moving = paths.iter().map(|(quantity, own)| quantity.of_tube(own.tube)).collect();
        let waypoints = (0..length).map(|i| paths.iter().map(|own| own.1.value[i]).collect()).collect();
        Ok(Self { given, moving, waypoints })
    }

    /// All motors at a value of the path.
    fn drives(&self, at: usize) -> DriveArgs {
        let mut drives = DriveArgs::default();
        for (quantity, own) in &self.given {
            let value = own.value.get(at).or(own.value.first()).copied().unwrap_or_default();
            let list = match (quantity.freedom, quantity.is_motion) {
                (cppr::solve::Freedom::PushPull, true) => &mut drives.pull,
                (cppr::solve::Freedom::PushPull, false) => &mut drives.tension,
                (cppr::solve::Freedom::Rotation, true) => &mut drives.rotate,
                (cppr::solve::Freedom::Rotation, false) => &mut drives.torque,
            };
            list.push(ForTube { tube: own.tube, value });
        }
        drives
    }
}

/// What is driven.
#[derive(Debug)]
pub struct Course {
    name: String,
    base: BundleCommand,
    stretch: bool,
    friction: Friction,
    paths: Paths,
    steps: u32,
}

impl Course {
    pub fn friction(&self) -> Friction {
        self.friction
    }

    /// The command at the end of a step, by its number from 0 on.
    pub fn command(&self, number: usize) -> (usize, BundleCommand) {
        let steps = self.steps as usize;
        let (leg, step) = (number / steps, number % steps + 1);
        // After a turn slip spreads like the root of the travel.
        let share = (step as f64 / steps as f64).powi(2);
        let ends = self.paths.waypoints[leg].iter().zip(&self.paths.waypoints[leg + 1]);
        let moved = self.paths.moving.iter().zip(ends);
        let command = moved.fold(self.base.clone(), |command, (input, (from, to))| {
            command.with_input(*input, from + share * (to - from))
        });
        (leg + 1, command)
    }

    fn drive(&self, solver: &mut BundleSolver, mut kept: Option<Checkpoint>) -> Result<History, Failure> {
        let name = &self.name;
        let lost =
            |what: String| Failure::NoEquilibrium(format!("{name}: {what}; move less, or in more steps"));
        let restored = kept.as_mut().map(|own| own.restored(solver, self)).transpose()?.flatten();
        let (mut state, mut points) = if let Some(restored) = restored {
            restored
        } else {
            let mut state = SlipHistory::new(solver, self.friction)
                .ok_or_else(|| Failure::NoEquilibrium(format!("{name}: its rest was not found")))?;
            // What stays, and the loads, come first.
            if self.base != solver.held() && !state.drive(&self.base) {
                return Err(lost("the start of the path was not reached".into()));
            }
            let points = vec![Point { leg: 0, reached: state.point() }];
            (state, points)
        };
        let legs = self.paths.waypoints.len() - 1;
        let all = legs * self.steps as usize;
        let bar = ProgressBar::new(all as u64);
        for number in points.len() - 1..all {
            bar.set_position(number as u64);
            let (leg, command) = self.command(number);
            if !state.drive(&command) {
                bar.finish_and_clear();
                return Err(lost(format!(
                    "step {} of leg {leg} found no equilibrium",
                    number % self.steps as usize + 1
                )));
            }
            points.push(Point { leg, reached: state.point() });
            if let Some(kept) = &mut kept {
                kept.keep(&state, &points)?;
            }
        }
        bar.finish_and_clear();
        if let Some(kept) = kept {
            kept.remove()?;
        }
        let turns = (0..=legs).map(|leg| leg * self.steps as usize).collect();
        Ok(History { name: name.clone(), points, motor: self.paths.moving[0], turns })
    }
}

fn table(history: &History, friction: &Friction, closed: Option<&Loop>) -> String {
    let mut text =
        format!("{}: {} points, friction {}\n", history.name, history.points.len(), friction.coefficient);
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<22}{value}");
    };
    let (motion, effort) = units(history.motor);
    for (i, &turn) in history.turns.iter().enumerate() {
        let point = &history.points[turn];
        let [moved, with] = history.motion(point);
        let tip = <[f64; 3]>::from(point.reached.tip * 1e3).map(|c| format!("{:>9}", plain(c, 3))).join(" ");
        let name = if i == 0 { "start".into() } else { format!("after leg {i}") };
        let [moved, with] = [plain(moved * motion.0, 3), plain(with * effort.0, 4)];
        line(&name, format!("{moved:>9} {} with {with:>9} {}, tip {tip} mm", motion.1, effort.1));
    }
    for (turn, lost) in history.lost() {
        let [moved, _] = history.motion(&history.points[turn]);
        let value = lost.map_or("not over on this leg".into(), |lost| {
            format!("{} {}", plain(lost * motion.0, 3), motion.1)
        });
        line("lost motion", format!("{value} after the turn at {} {}", plain(moved * motion.0, 3), motion.1));
    }
    let energy = closed.map_or("no loop closes: end the path where an earlier leg ended".into(), |own| {
        format!("{} mJ, all motors together", plain(own.energy * 1e3, 4))
    });
    line("energy of the loop", energy);
    let corrected = history.points.iter().fold([0.0; 2], |most: [f64; 2], own| {
        [most[0].max(own.reached.corrected[0]), most[1].max(own.reached.corrected[1])]
    });
    line(
        "corrected by at most",
        format!("{:.0e} mm, {:.0e} N, for the elasticity of what sticks", corrected[0] * 1e3, corrected[1]),
    );
    text
}

/// Factor and unit of a motor's motion and of its effort.
pub fn units(motor: Input) -> ((f64, &'static str), (f64, &'static str)) {
    match motor.freedom {
        cppr::solve::Freedom::PushPull => ((1e3, "mm"), (1.0, "N")),
        cppr::solve::Freedom::Rotation => ((180.0 / std::f64::consts::PI, "deg"), (1e3, "N mm")),
    }
}

fn record(history: &History, friction: &Friction, closed: Option<&Loop>) -> Value {
    let points = history.points.iter().map(|own| {
        let HistoryPoint { tip, efforts, slipping, corrected } = &own.reached;
        json!({
            "leg": own.leg, "tip_position_m": <[f64; 3]>::from(*tip), "actuators": contact_record::actuators(efforts),
            "slipping": slipping, "corrected_m": corrected[0], "corrected_N": corrected[1],
        })
    });
    let lost = history.lost().into_iter().map(|(turn, lost)| json!({ "point": turn, "lost_motion": lost }));
    json!({
        "schema": "cppr/cycle", "schema_version": 1, "cppr_version": env!("CARGO_PKG_VERSION"),
        "robot": { "name": history.name, "tubes": history.points[0].reached.efforts.len() },
        "friction": { "coefficient": friction.coefficient, "guide_m": friction.guide },
        "motor": { "tube": history.motor.tube, "freedom": match history.motor.freedom {
            cppr::solve::Freedom::PushPull => "push_pull",
            cppr::solve::Freedom::Rotation => "rotation",
        } },
        "turns": lost.collect::<Vec<_>>(),
        "loop": closed.map(|own| json!({ "from_point": own.range[0], "to_point": own.range[1], "energy_J": own.energy })),
        "points": points.collect::<Vec<_>>(),
    })
}

fn csv(history: &History) -> String {
    let mut text = "leg,tip_x_m,tip_y_m,tip_z_m,slipping".to_owned();
    for tube in 1..=history.points[0].reached.efforts.len() {
        let _ = write!(
            text,
            ",tube{tube}_pull_m,tube{tube}_rotation_rad,tube{tube}_tension_N,tube{tube}_torque_Nm"
        );
    }
    text.push('\n');
    for own in &history.points {
        let HistoryPoint { tip, efforts, slipping, .. } = &own.reached;
        let _ = write!(text, "{},{},{},{},{slipping}", own.leg, tip.x, tip.y, tip.z);
        for TubeEffort { label, rotation, force, torque } in efforts {
            let _ = write!(text, ",{label},{rotation},{force},{torque}");
        }
        text.push('\n');
    }
    text
}
