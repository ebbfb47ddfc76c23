//! `cppr solve`: the equilibrium of a robot.

use crate::Failure;
use crate::bundle;
use crate::clearance::{Gap, Gapped, gap, guide_gap};
use crate::command::{CommandArgs, build, no_equilibrium, thread_has_direction};
use crate::exceeded::Exceeded;
use crate::figure;
use crate::hysteresis;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::resolved::AccuracyArgs;
use crate::rubbing::{FrictionArgs, Touch};
use crate::scenario;
use crate::table::table;
use crate::unstable::Unstable;
use cppr::analysis::{Followed, Teeth};
use cppr::bundle::Friction;
use cppr::clearance::Guide;
use cppr::solve::{Equilibrium, Solver};
use cppr_io::bundle_file::Described;
use cppr_io::result::{AccuracyRecord, ResultRecord};
use cppr_io::result_csv;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr solve robots/r3.toml --pull 5mm
  cppr solve robots/r3.toml --pull 5mm --plot r3.svg
  cppr solve robots/childs3.toml --pull 2=1mm --pull 3=-0.5mm --rotate 2=30deg
  cppr solve robots/childs2.toml --pull 1mm --tip-force 0,0,-0.5N
  cppr solve robots/r1.toml --tension 3N --torque 20Nmm --formulation printed --stretch --plot shape.svg --json shape.json
  cppr solve robots/r1.toml --pull 2mm --rotate 60deg --relative-angle
  cppr solve robots/r2.toml --pull 2mm --point-force 60mm:0,0.1,0N --distributed 0..100mm:0,-1,0N/m
  cppr solve robots/r4.toml --pull -4mm --tip-force 0,0.1,0N --tip-point 0,3.056,0mm
  cppr solve robots/r4.toml --pull -4mm --gravity 0,0,-1g --csv fields.csv
  cppr solve robots/r1.toml --pull 3mm --thread 0.1962N:150,-24,0mm
  cppr solve robots/helicoid.toml --pull 10mm --json -
  cppr solve robots/childs3.toml --scenario examples/scenario.toml
  cppr solve robots/r1.toml --pull 6mm --friction 0.2 --guide 20mm
  cppr solve robots/r3.toml --pull 9mm --contact --plot contact.svg
  cppr solve robots/r1.toml --pull 6mm --clearance radii --plot gaps.svg
  cppr solve robots/r1.toml --pull 6mm --clearance radii --guide 20mm --guide-gap 0.5mm
  cppr solve robots/helicoid.toml --pull 8mm --clearance radii --plot winding.svg
  cppr solve robots/bundles/s_shape.toml --pull 5mm --clearance 0.3mm --plot gaps_s.svg
  cppr solve robots/bundles/two_sections.toml --pull 2=3mm --pull 4=2mm
  cppr solve robots/bundles/s_shape.toml --pull 1=-20mm --pull 2=-15mm --plot s.svg
  cppr solve robots/wrists/superelastic.toml --tension 2=1N --hysteresis --plot hysteresis.svg

Values carry units: mm, cm, m, um; deg, rad; N, mN, kN; Nmm, Nm, mNm; N/m; m/s2, g. Base frame: the robot
at rest lies along +X, tube 1's centroid towards +Y. The bend angle is that between the tip and +X;
where the bends along the robot add up to another, that follows.
Exit codes: 0 solved (also where the equilibrium is unstable: the table says so), 2 wrong input,
3 no equilibrium found.";

/// Arguments of `cppr solve`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    pub robot: PathBuf,
    #[command(flatten)]
    pub command: CommandArgs,
    /// Scenario file (TOML) that says what the options from --pull to --refine say, as the live view writes it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["DriveArgs", "RestArgs"])]
    pub scenario: Option<PathBuf>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    #[command(flatten)]
    pub friction: FrictionArgs,
    /// Give the answer for superelastic metal that unloads too: between the two its hysteresis leaves the robot
    #[arg(long)]
    pub hysteresis: bool,
    /// Tell how hard the tubes press on each other along the robot, in the results and in a panel of the figure too
    #[arg(long)]
    pub contact: bool,
    /// Solve with a radial gap of this size between all tubes, or with those that the `radii` leave, and contact at the walls; estimated where metal is not linear
    #[arg(long, value_name = "GAP", allow_hyphen_values = true, value_parser = gap)]
    pub clearance: Option<Gap>,
    /// Radial gap between tube 2 and the --guide below the plate, at whose lower end the motors hold the tubes; without it they leave the plate on the axis and straight
    #[arg(long, value_name = "GAP", allow_hyphen_values = true, requires_all = ["clearance", "guide"], value_parser = guide_gap)]
    pub guide_gap: Option<f64>,
    /// Sections at which fields are written
    #[arg(long, default_value_t = 101, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub samples: u32,
    /// Write the whole result, - for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the fields along the robot, - for standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw the shape, .svg or .png
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
}

/// Solves, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [&args.json, &args.csv, &args.plot].map(Option::as_deref))?;
    let Outputs { json, csv, .. } = outputs;
    let keeps_modes = match &args.scenario {
        Some(path) => scenario::read(path)?.needs_modes(),
        None => args.command.rest.needs_modes(),
    };
    let described = args.accuracy.described(&args.robot, keeps_modes)?;
    let friction = match args.guide_gap {
        Some(_) => args.friction.or(described.friction()),
        None => args.friction.alone(described.friction())?,
    };
    let file = match described {
        Described::Robot(_) if args.hysteresis => return Err(hysteresis::without()),
        Described::Robot(file) => file,
        Described::Bundle { design, .. } => return bundle::run(args, &outputs, &design, friction),
    };
    let (mut solver, command) = if let Some(path) = &args.scenario {
        scenario::apply(path, &args.robot)?
    } else {
        let robot = build(&file, &args.robot)?;
        let command = args.command.command(&robot)?;
        (args.command.solver(&robot)?, command)
    };
    let start = Instant::now();
    let Followed { equilibrium: found, folds } = AccuracyArgs::solve(&mut solver, &command)?;
    let time = start.elapsed();
    if !found.status().is_equilibrium() {
        if let Some(path) = json {
            write_json(path, &ResultRecord::status_only(&found))?;
        }
        return Err(match (no_equilibrium(&found), &args.scenario) {
            (Failure::NoEquilibrium(why), Some(path)) => {
                Failure::NoEquilibrium(format!("{}: {why}", path.display()))
            }
            (failure, _) => failure,
        });
    }
    let start = Instant::now();
    let mut resolved = args.accuracy.resolve(&mut solver, found)?;
    resolved.folds = folds;
    let checked = start.elapsed();
    let found = &resolved.found;
    let shape = solver.shape(found, args.samples as usize);
    thread_has_direction(&found.command().loads, &solver.tip(found))?;
    let stability = solver.stability(found);
    let margin = stability.as_ref().map(|s| s.margin);
    let margin_error = solver.margin_error(found);
    let direction = stability.map(|s| s.tip_direction.into());
    let unstable = Unstable::of(&mut solver, found, &args.robot);
    let exceeded = Exceeded::of(&mut solver, found, Teeth::Rigid);
    let touch = touch(&mut solver, found, args, friction)?;
    if let Some(path) = json {
        let mut record = ResultRecord::new(found, &shape, margin, direction);
        record.accuracy = resolved
            .accuracy
            .map(|own| AccuracyRecord { margin: margin_error, ..AccuracyRecord::new(found.robot(), &own) });
        record.snaps_at.clone_from(&resolved.folds);
        record.limit_exceeded = exceeded.as_ref().map(Exceeded::json);
        record.stable_aside = unstable.as_ref().and_then(Unstable::json);
        record.contact = touch.contact_json();
        record.friction = touch.friction_json();
        record.clearance = touch.clearance_json();
        write_json(path, &record)?;
    }
    if let Some(path) = csv {
        write_or_print(path, &result_csv::csv(&shape, &touch.contact))?;
    }
    outputs.draw(|| {
        let mut figure = figure::shape(&mut solver, found, args.samples as usize)?;
        touch.draw(&mut figure);
        Ok(figure)
    })?;
    let margin = margin.zip(direction).map(|(margin, direction)| (margin, margin_error, direction));
    let text =
        table(&resolved, &shape, margin, exceeded.as_ref(), unstable.as_ref(), &touch, [time, checked]);
    outputs.report(&text)
}

impl Args {
    /// The guide in which tube 2 has play.
    pub fn guide(&self) -> Option<Guide> {
        self.friction.guide.zip(self.guide_gap).map(|(length, gap)| Guide { length, gap })
    }
}

/// What the tubes do to each other, where that is asked for.
fn touch(
    solver: &mut Solver,
    found: &Equilibrium,
    args: &Args,
    friction: Option<Friction>,
) -> Result<Touch, Failure> {
    let gapped = args.clearance.map(|gap| Gapped::of(solver, found, gap, args.guide())).transpose()?;
    if !(args.contact || friction.is_some()) {
        return Ok(Touch { gapped, ..Touch::default() });
    }
    let own = solver.integrated(found).ok_or_else(|| {
        Failure::Input(
            "contact and friction need an equilibrium of the consistent formulation, rotations of the motors, and a pose that the integration along the robot \
             confirms; leave --formulation printed and --relative-angle away, or --contact, and the friction of the robot file with --friction 0"
                .into(),
        )
    })?;
    let touch = Touch::of(&own.solver(), &own.equilibrium, friction, args.contact)?;
    Ok(Touch { gapped, ..touch })
}

fn write_json(path: &Path, record: &ResultRecord) -> Result<(), Failure> {
    let text = record.to_json().map_err(|e| Failure::Input(format!("{}: {e}", path.display())))?;
    write_or_print(path, &text)
}
