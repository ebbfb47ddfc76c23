//! `cppr export`: tubes as files for printing, cutting and display.

use crate::Failure;
use crate::bundle;
use crate::command::{CommandArgs, build, thread_has_direction, unsound};
use crate::output::{self, is_stdout, write_or_print};
use crate::outputs::Outputs;
use crate::quantity::{Kind, scalar};
use crate::resolved::AccuracyArgs;
use cppr::bundle::solve::BundleSolver;
use cppr::bundle::{Bundle, BundleDesign};
use cppr::design::Robot;
use cppr::kinematics::TipPose;
use cppr_io::RobotFile;
use cppr_io::bundle_file::Described;
use cppr_mesh::{
    Detail, Flange, Flaws, Mesh, Part, TubeOptions, Tubes, UnrolledOptions, bent_bundle, bent_tubes, dxf,
    glb, gltf, obj, stl, three_mf, tube_mesh, tube_volume, unrolled,
};
use serde_json::{Value, json};
use std::fmt::{Display, Write};
use std::path::{Path, PathBuf};

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr export robots/r1.toml --tube 1 --output tube1.stl
  cppr export robots/r1.toml --tube 2 --below 40mm --flange 6mm,2mm --tip-cap 1mm --output tube2.3mf
  cppr export robots/r3.toml --tube 1 --kerf 20um --output cuts.dxf
  cppr export robots/r1.toml --pull 5mm --output bent.glb
  cppr export robots/r1.toml --tube 2 --output tube2.stl --json -
  cppr export robots/helicoid.toml --pull 10mm --tip-force 0,0,-0.1N --output bent.obj
  cppr export robots/bundles/uncut_ends.toml --tube 1 --output cuts.dxf
  cppr export robots/bundles/uncut_ends.toml --pull 1=-20mm --pull 2=-19mm --output bent.glb

STL, OBJ, 3MF and DXF are in mm, glTF in m. Axes: the base frame, X along the robot at rest, Y towards the leader's
centroid (up in glTF). DXF: the outer surface seen from outside, X along the tube, notches on layer CUT.";

/// Most by which the volume of the mesh of a tube may differ from the integral of its section area.
const VOLUME: f64 = 1e-3;

/// What a file holds.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Binary STL
    Stl,
    /// 3D Manufacturing Format
    #[value(name = "3mf")]
    ThreeMf,
    /// Unrolled cut pattern, with --tube
    Dxf,
    /// glTF 2.0, data inside
    Gltf,
    /// glTF 2.0, binary
    Glb,
    /// Wavefront OBJ
    Obj,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::ThreeMf => "3mf",
            Self::Dxf => "dxf",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Obj => "obj",
        }
    }

    const ALL: [Self; 6] = [Self::Stl, Self::ThreeMf, Self::Dxf, Self::Gltf, Self::Glb, Self::Obj];
}

/// Arguments of `cppr export`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    /// This tube alone, at rest, for the workshop. Without it, all tubes where the equilibrium has them
    #[arg(long, value_name = "K", conflicts_with_all = ["pull", "rotate", "tension", "torque", "relative_angle", "tip_force",
        "tip_moment", "tip_point", "follower_load", "point_force", "distributed", "gravity", "thread", "formulation",
        "stretch", "planar", "refine"])]
    tube: Option<usize>,
    /// Where to; the ending says the format
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Format, where the ending does not say it
    #[arg(long)]
    format: Option<Format>,
    /// Largest distance between facets and the surface [default: 0.01mm for a tube, 0.02mm for a robot]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = |t: &str| scalar(t, Kind::Length))]
    tolerance: Option<f64>,
    /// Length of the tube below the baseplate; without --tube, of the followers [default: 0 for a tube, 20mm for a robot]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = |t: &str| scalar(t, Kind::Length))]
    below: Option<f64>,
    /// Flange at the lower end, for instance 8mm,2mm
    #[arg(long, value_name = "RADIUS,THICKNESS", allow_hyphen_values = true, requires = "tube", value_parser = flange)]
    flange: Option<Flange>,
    /// Platform that closes the tip
    #[arg(long, value_name = "THICKNESS", allow_hyphen_values = true, requires = "tube", value_parser = |t: &str| scalar(t, Kind::Length))]
    tip_cap: Option<f64>,
    /// Width that the laser takes away; for DXF
    #[arg(long, value_name = "WIDTH", allow_hyphen_values = true, requires = "tube", value_parser = |t: &str| scalar(t, Kind::Length))]
    kerf: Option<f64>,
    /// Write what the file holds, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
}

impl Args {
    /// Tolerance of a bent robot, and what of it is below the plate (m).
    fn bent(&self) -> [f64; 2] {
        [self.tolerance.unwrap_or(2e-5), self.below.unwrap_or(0.02)]
    }
}

fn flange(text: &str) -> Result<Flange, String> {
    let (radius, thickness) =
        text.split_once(',').ok_or("write radius and thickness, for instance 8mm,2mm".to_string())?;
    Ok(Flange { radius: scalar(radius, Kind::Length)?, thickness: scalar(thickness, Kind::Length)? })
}

fn input(problem: impl Display) -> Failure {
    Failure::Input(problem.to_string())
}

/// The format, from option and file name.
fn format(path: &Path, given: Option<Format>) -> Result<Format, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let said = Format::ALL.into_iter().find(|f| Some(f.name()) == ending.as_deref());
    match (given, said) {
        (Some(given), Some(said)) if given != said => Err(input(format!(
            "--format {} and the ending .{} contradict each other; change one of them",
            given.name(),
            said.name()
        ))),
        (Some(format), _) | (None, Some(format)) => Ok(format),
        (None, None) => {
            let known = Format::ALL.map(|f| format!(".{}", f.name())).join(", ");
            Err(input(format!(
                "--output {}: the ending says no known format; choose among {known}, or add --format",
                path.display()
            )))
        }
    }
}

/// Makes the file and says what is in it.
pub fn run(args: &Args) -> Result<(), Failure> {
    if is_stdout(&args.output) {
        return Err(input("--output -: an export goes into a file; write its name"));
    }
    let format = format(&args.output, args.format)?;
    let json = args.json.as_deref();
    output::check(&args.robot, &[("--output", Some(&args.output)), ("--json", json)])?;
    if args.tube.is_none() && format == Format::Dxf {
        return Err(input("a DXF holds the cut pattern of one tube at rest: add --tube 1"));
    }
    let (robot, bent): (Box<dyn Tubes>, _) =
        match args.accuracy.described(&args.robot, args.command.rest.needs_modes())? {
            Described::Robot(file) => {
                let robot = build(&file, &args.robot)?;
                let bent = if args.tube.is_none() { Some(solved(args, &file, &robot)?) } else { None };
                (Box::new(file), bent)
            }
            Described::Bundle { design, .. } => {
                let bundle = Bundle::new(&design).map_err(|problems| unsound(&args.robot, &problems))?;
                let bent =
                    if args.tube.is_none() { Some(solved_bundle(args, &design, &bundle)?) } else { None };
                (Box::new(design), bent)
            }
        };
    let robot = &*robot;
    let Made { bytes, mut text, content } = match (args.tube, bent) {
        (Some(tube), _) if format == Format::Dxf => cut_pattern(args, robot, tube)?,
        (Some(tube), _) => single(args, format, robot, tube)?,
        (None, bent) => assembly(format, robot, bent.unwrap_or_default())?,
    };
    if args.kerf.is_some() && format != Format::Dxf {
        return Err(input("--kerf is for cut patterns: write a .dxf, or leave it away"));
    }
    output::write(&args.output, &bytes)?;
    let _ = writeln!(text, "  written      {}", args.output.display());
    if let Some(path) = json {
        let mut whole = json!({
            "schema": "cppr/export", "schema_version": 1, "robot": robot.name(),
            "file": args.output.display().to_string(), "format": format.name(), "bodies": [], "volume_m3": null,
            "pattern": null,
        });
        for (key, value) in content {
            whole[key] = value;
        }
        write_or_print(path, &format!("{whole:#}\n"))?;
    }
    Outputs { json, csv: None, plot: None }.report(&text)
}

/// A file, what is said of it, and the same for JSON.
struct Made {
    bytes: Vec<u8>,
    text: String,
    content: Vec<(&'static str, Value)>,
}

/// A body for JSON.
fn body(part: &Part) -> Value {
    json!({ "name": part.name, "triangles": part.mesh.triangles.len(), "bounds_m": part.mesh.bounds() })
}

/// Index of a tube that the user counts from 1.
fn index(tube: usize, robot: &dyn Tubes) -> Result<usize, Failure> {
    let count = robot.count();
    tube.checked_sub(1)
        .filter(|i| *i < count)
        .ok_or_else(|| input(format!("--tube: there is no tube {tube}; this robot has 1 to {count}")))
}

fn part(robot: &dyn Tubes, index: usize, mesh: Mesh) -> Part {
    let colour = cppr_plot::tube_stroke(index + 1).colour;
    Part {
        name: format!("{}, tube {}", robot.name(), index + 1),
        mesh,
        colour: [colour.r, colour.g, colour.b],
    }
}

fn encode(format: Format, parts: &[Part]) -> Result<Vec<u8>, Failure> {
    match format {
        Format::Stl => stl(parts).map_err(input),
        Format::ThreeMf => three_mf(parts).map_err(input),
        Format::Gltf => Ok(gltf(parts).into_bytes()),
        Format::Glb => Ok(glb(parts)),
        Format::Obj | Format::Dxf => Ok(obj(parts).into_bytes()),
    }
}

/// A body that does not close is not written.
fn closed(part: &Part) -> Result<(), Failure> {
    match part.mesh.flaws() {
        flaws if flaws == Flaws::default() => Ok(()),
        flaws => Err(input(format!(
            "{}: the surface is not sound ({flaws:?}); nothing is written. Try another --tolerance",
            part.name
        ))),
    }
}

fn single(args: &Args, format: Format, robot: &dyn Tubes, tube: usize) -> Result<Made, Failure> {
    let tube = index(tube, robot)?;
    let options = TubeOptions {
        detail: Detail::workshop(args.tolerance.unwrap_or(1e-5)),
        below: args.below.unwrap_or(0.0),
        flange: args.flange,
        tip_cap: args.tip_cap,
    };
    let mesh = tube_mesh(robot, tube, &options).map_err(input)?;
    let (volume, exact) = (mesh.volume(), tube_volume(robot, tube, &options).map_err(input)?);
    let part = part(robot, tube, mesh);
    closed(&part)?;
    let off = volume / exact - 1.0;
    if off.abs() > VOLUME {
        return Err(input(format!(
            "the volume of the mesh differs by {:.2} % from that of the design; choose a finer --tolerance",
            off * 100.0
        )));
    }
    let [low, high] = part.mesh.bounds();
    let size: Vec<String> = (0..3).map(|i| format!("{:.3}", (high[i] - low[i]) * 1e3)).collect();
    let mut text = format!("{}, {}\n", part.name, made(robot, tube));
    let _ = writeln!(text, "  triangles    {}, closed", part.mesh.triangles.len());
    let _ = writeln!(text, "  size         {} mm", size.join(" × "));
    let _ = writeln!(
        text,
        "  volume       {:.3} mm³, {:+.4} % from the integral of the section area",
        volume * 1e9,
        off * 100.0
    );
    let content = vec![("bodies", json!([body(&part)])), ("volume_m3", volume.into())];
    Ok(Made { bytes: encode(format, &[part])?, text, content })
}

/// How a tube is made: a curved one is drawn before it is set to its shape.
fn made(robot: &dyn Tubes, tube: usize) -> &'static str {
    if robot.is_curved(tube) { "straight, before it is given its rest curvature" } else { "at rest" }
}

fn cut_pattern(args: &Args, robot: &dyn Tubes, tube: usize) -> Result<Made, Failure> {
    if args.flange.is_some() || args.tip_cap.is_some() {
        return Err(input("--flange and --tip-cap are no cuts: leave them away, or write a body"));
    }
    let tube = index(tube, robot)?;
    let kerf = args.kerf.unwrap_or(0.0);
    let options =
        UnrolledOptions { tolerance: args.tolerance.unwrap_or(1e-5), kerf, below: args.below.unwrap_or(0.0) };
    let pattern = unrolled(robot, tube, &options).map_err(input)?;
    let [[left, bottom], [right, top]] = pattern.outline;
    let mut text = format!("{}, tube {}, unrolled\n", robot.name(), tube + 1);
    let _ = writeln!(text, "  surface      {:.3} × {:.3} mm", (right - left) * 1e3, (top - bottom) * 1e3);
    let _ = writeln!(text, "  notches      {}, paths {:.4} mm inside", pattern.openings.len(), 500.0 * kerf);
    if let Some([straight, radial]) = pattern.kept_area {
        let _ = writeln!(
            text,
            "  first notch  leaves {:.4} mm² (design, cut straight across); a beam through the axis leaves {:.4} mm²",
            straight * 1e6,
            radial * 1e6
        );
    }
    let kept = pattern.kept_area;
    let content = json!({
        "tube": tube + 1, "length_m": right - left, "circumference_m": top - bottom, "notches": pattern.openings.len(),
        "kerf_m": kerf, "kept_area_straight_m2": kept.map(|k| k[0]), "kept_area_radial_m2": kept.map(|k| k[1]),
    });
    Ok(Made { bytes: dxf(&pattern).map_err(input)?, text, content: vec![("pattern", content)] })
}

/// The status of an equilibrium, and the tubes where it has them.
type Bent = (String, Vec<Mesh>);

fn solved(args: &Args, file: &RobotFile, robot: &Robot) -> Result<Bent, Failure> {
    let command = args.command.command(robot)?;
    let mut solver = args.command.solver(robot)?;
    let resolved = args.accuracy.solve_resolved(&mut solver, &command)?;
    let found = &resolved.found;
    thread_has_direction(&found.command().loads, &solver.tip(found))?;
    let [tolerance, below] = args.bent();
    let meshes = bent_tubes(file, &mut solver, found, tolerance, below).map_err(input)?;
    let warning = resolved
        .warning()
        .or(resolved.snap())
        .map_or(String::new(), |text| format!("\n  warning      {text}"));
    Ok((found.status().to_string() + &warning, meshes))
}

fn solved_bundle(args: &Args, design: &BundleDesign, bundle: &Bundle) -> Result<Bent, Failure> {
    let (command, stretch) = args.command.bundle_command(design)?;
    bundle::check(design, bundle, &command, stretch)?;
    let mut solver = BundleSolver::new(bundle).with_stretch(stretch);
    let found = solver.solve(&command);
    bundle::check_loads(&command, &found)?;
    if !found.converged {
        return Err(bundle::no_equilibrium(&design.name, &found));
    }
    thread_has_direction(&command.loads, &TipPose { rotation: found.frame, centre: found.tip })?;
    let [tolerance, below] = args.bent();
    let meshes = bent_bundle(design, &solver, &found, tolerance, below).map_err(input)?;
    Ok((found.verdict(), meshes))
}

fn assembly(format: Format, robot: &dyn Tubes, (status, meshes): Bent) -> Result<Made, Failure> {
    let parts: Vec<Part> = meshes.into_iter().enumerate().map(|(i, mesh)| part(robot, i, mesh)).collect();
    parts.iter().try_for_each(closed)?;
    let mut text = format!("{}, {status}\n", robot.name());
    for part in &parts {
        let [low, high] = part.mesh.bounds();
        let range: Vec<String> =
            (0..3).map(|i| format!("{:.1} … {:.1}", low[i] * 1e3, high[i] * 1e3)).collect();
        let _ = writeln!(
            text,
            "  {:<12} {} triangles, {} mm",
            part.name,
            part.mesh.triangles.len(),
            range.join(", ")
        );
    }
    let content = vec![("bodies", parts.iter().map(body).collect())];
    Ok(Made { bytes: encode(format, &parts)?, text, content })
}
