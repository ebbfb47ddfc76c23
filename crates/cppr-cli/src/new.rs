//! `cppr new`: a robot file from a few answers, with a comment on every line.
//!
//! What no option says is asked for on the terminal; every question has an answer that Enter takes. The text is read
//! as any robot file before it is written, so that nothing is written that `cppr check` would refuse.

use crate::Failure;
use crate::output::{self, is_stdout, note, print, write_or_print};
use crate::quantity::{Kind, scalar};
use crate::table::millimetres;
use cppr::design::Robot;
use std::fmt::Write;
use std::io::BufRead;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr new arm.toml --defaults
  cppr new needle.toml --name Needle --length 80mm --material nitinol --tube 1mm,0.85mm,1.7mm --tube 0.8mm,0.65mm,1.3mm --notch 0.6mm --tooth 0.6mm --defaults
  cppr new - --tube 3mm,2mm,5mm,180deg --tube 1.5mm,0.5mm,2mm,20deg --defaults
Asking for everything:
  $ cppr new arm.toml

The answers make a robot with the same notches from base to tip; the file says how to taper or turn them.
Exit codes: 0 written, 2 wrong input.";

/// Most tubes that are asked for; a file may have more.
const MOST_TUBES: usize = 8;

/// Arguments of `cppr new`.
#[derive(clap::Args)]
pub struct Args {
    /// File to write (TOML), which must not exist; - for standard output
    file: PathBuf,
    /// What the robot is called
    #[arg(long)]
    name: Option<String>,
    /// Length of all tubes above the baseplate
    #[arg(long, value_parser = length)]
    length: Option<f64>,
    /// What the tubes are made of
    #[arg(long)]
    material: Option<MaterialArg>,
    /// A tube, the outermost first; repeat for each. Radii and depth of the notches, and where the notches open to, from +Y towards +Z
    #[arg(long, value_name = "OUTER,INNER,DEPTH[,OPENING]", value_parser = tube)]
    tube: Vec<TubeAnswer>,
    /// Length of a notch along the tube
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    notch: Option<f64>,
    /// Length of the tooth between two notches
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    tooth: Option<f64>,
    /// Ask nothing: take the usual answer where no option says another
    #[arg(long)]
    defaults: bool,
}

/// Materials of which usual values are known.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MaterialArg {
    /// Printed polylactide, as the robots of the paper
    Pla,
    /// Superelastic nickel-titanium
    Nitinol,
    /// Stainless steel
    Steel,
}

impl MaterialArg {
    /// Word, Young's modulus (GPa), Poisson's ratio, density (kg/m³), allowable strain (%), and where they are from.
    fn values(self) -> (&'static str, f64, f64, f64, f64, &'static str) {
        match self {
            Self::Pla => (
                "pla",
                5.39,
                0.35,
                1240.0,
                1.5,
                "printed PLA: the modulus that Tummers et al. (2024) calibrated, the elongation at yield of data sheets",
            ),
            Self::Nitinol => (
                "nitinol",
                75.0,
                0.33,
                6450.0,
                1.0,
                "nitinol as long as it is austenite: usual values of data sheets, and the strain at which the plateau begins",
            ),
            Self::Steel => (
                "steel",
                193.0,
                0.29,
                8000.0,
                0.11,
                "stainless steel 304: usual values of data sheets, and its 0.2 % proof stress over its modulus",
            ),
        }
    }
}

/// One tube (m, rad).
#[derive(Clone, Copy)]
struct TubeAnswer {
    outer: f64,
    inner: f64,
    depth: f64,
    opening: Option<f64>,
}

fn length(text: &str) -> Result<f64, String> {
    match scalar(text, Kind::Length)? {
        value if value > 0.0 => Ok(value),
        _ => Err(format!("{text}: write a length above 0")),
    }
}

fn tube(text: &str) -> Result<TubeAnswer, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let (outer, inner, depth, opening) = match parts[..] {
        [outer, inner, depth] => (outer, inner, depth, None),
        [outer, inner, depth, opening] => (outer, inner, depth, Some(scalar(opening, Kind::Angle)?)),
        _ => return Err("write outer radius, inner radius and depth, for instance 3mm,2mm,5mm".into()),
    };
    Ok(TubeAnswer { outer: length(outer)?, inner: length(inner)?, depth: length(depth)?, opening })
}

/// Questions on standard error, answers from standard input.
struct Asker {
    asks: bool,
}

impl Asker {
    /// The answer of an option, or of the person, or the usual one.
    fn get<T>(
        &self,
        given: Option<T>,
        question: &str,
        usual: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, Failure> {
        if let Some(given) = given {
            return Ok(given);
        }
        loop {
            let mut answer = String::new();
            if self.asks {
                note(&format!("{question} [{usual}]: "));
                let read = std::io::stdin().lock().read_line(&mut answer);
                let read = read.map_err(|e| Failure::Input(format!("the answer cannot be read: {e}")))?;
                if read == 0 {
                    return Err(Failure::Input(format!(
                        "no answer to \"{question}\": answer, or add --defaults to take the usual ones"
                    )));
                }
            }
            let answer = answer.trim();
            match read(if answer.is_empty() { usual } else { answer }) {
                Ok(value) => return Ok(value),
                Err(problem) if self.asks => note(&format!("  {problem}\n")),
                Err(problem) => return Err(Failure::Input(problem)),
            }
        }
    }

    fn length(&self, given: Option<f64>, question: &str, usual: f64) -> Result<f64, Failure> {
        self.get(given, question, &format!("{}mm", millimetres(usual)), length)
    }
}

/// Asks, checks, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let shown = args.file.display();
    if !is_stdout(&args.file) && args.file.exists() {
        return Err(Failure::Input(format!("{shown}: this file exists; choose another name, or remove it")));
    }
    output::check(&args.file, &[("the robot file", Some(&args.file))])?;
    let text = ask(args)?;
    let refuse = |problems: String| {
        Failure::Input(format!("these answers make no robot, nothing is written.\n{problems}"))
    };
    let file = cppr_io::robot_file::parse(&text).map_err(|p| refuse(p.to_string()))?;
    Robot::from_design(file.design).map_err(|p| refuse(p.to_string()))?;
    write_or_print(&args.file, &text)?;
    let next = format!(
        "{shown} is written. See what it does:\n  cppr solve {shown} --pull 1mm\n  cppr view {shown}\n"
    );
    if is_stdout(&args.file) {
        note(&next);
        Ok(())
    } else {
        print(&next)
    }
}

/// The text of the file.
fn ask(args: &Args) -> Result<String, Failure> {
    let asker = Asker { asks: !args.defaults };
    let plain = |text: &str| match text {
        _ if text.trim().is_empty() => Err("write a name".to_string()),
        _ => Ok(text.to_owned()),
    };
    let name = asker.get(args.name.clone(), "Name of the robot", "Robot", plain)?;
    let whole = asker.length(args.length, "Length of the tubes above the baseplate", 0.15)?;
    let known = "pla, nitinol or steel";
    let material = asker.get(args.material, &format!("Material ({known})"), "pla", |text| {
        <MaterialArg as clap::ValueEnum>::from_str(text, true).map_err(|_| format!("write {known}"))
    })?;
    let tubes = tubes(args, &asker)?;
    let notch = asker.length(args.notch, "Length of a notch along the tube", whole / 30.0)?;
    let tooth = asker.length(args.tooth, "Length of the tooth between two notches", notch)?;
    Ok(file(&name, whole, material, &tubes, [notch, tooth]))
}

/// All tubes, each with its opening.
fn tubes(args: &Args, asker: &Asker) -> Result<Vec<(TubeAnswer, f64)>, Failure> {
    let count = |text: &str| match text.parse::<usize>() {
        Ok(count) if (2..=MOST_TUBES).contains(&count) => Ok(count),
        _ => Err(format!("write a number from 2 to {MOST_TUBES}")),
    };
    let given = Some(args.tube.len()).filter(|n| *n > 0);
    let count = asker.get(given, "Number of tubes", "2", count)?;
    let mut tubes: Vec<(TubeAnswer, f64)> = Vec::new();
    for k in 0..count {
        // Opposite to one another, or all around.
        let opening = (180.0 + 360.0 * k as f64 / count as f64) % 360.0;
        let own = if let Some(own) = args.tube.get(k) {
            *own
        } else {
            let number = k + 1;
            let bore = tubes.last().map(|(above, _)| above.inner);
            let question = format!("Tube {number}: outer radius");
            let outer = asker.length(None, &question, bore.map_or(3e-3, |bore| 0.75 * bore))?;
            let share = if k == 0 { 2.0 / 3.0 } else { 1.0 / 3.0 };
            let inner = asker.length(None, &format!("Tube {number}: inner radius"), share * outer)?;
            let depth = asker.length(None, &format!("Tube {number}: depth of its notches"), outer + inner)?;
            let question = format!("Tube {number}: direction its notches open to");
            let angle = |text: &str| scalar(text, Kind::Angle);
            let opening = asker.get(None, &question, &format!("{opening}deg"), angle)?;
            TubeAnswer { outer, inner, depth, opening: Some(opening) }
        };
        tubes.push((own, own.opening.unwrap_or(opening.to_radians())));
    }
    Ok(tubes)
}

fn file(
    name: &str,
    length: f64,
    material: MaterialArg,
    tubes: &[(TubeAnswer, f64)],
    [notch, tooth]: [f64; 2],
) -> String {
    let (_, modulus, ratio, density, strain, source) = material.values();
    // A basic string of TOML and a string of JSON are escaped alike.
    let name = serde_json::Value::from(name);
    let mm = millimetres;
    let mut text = format!(
        "# A concentric push-pull robot. Every number has its unit in its key. The base frame: the robot at rest lies along\n\
         # +X from the baseplate, directions are counted from +Y towards +Z.\n\
         name = {name}\n\
         length_mm = {length} # of all tubes at rest, from the baseplate to the tip\n\
         \n\
         [material] # {source}. Measure yours.\n\
         youngs_modulus_GPa = {modulus}\n\
         poissons_ratio = {ratio}\n\
         density_kg_m3 = {density}\n\
         allowable_strain_percent = {strain} # what cppr limits holds the strain of the notches against\n\
         \n\
         [calibration]\n\
         centroid_offset_factor = 1.0 # of the real robot over that of its section; cppr calibrate finds it\n",
        length = mm(length),
    );
    for (k, (tube, opening)) in tubes.iter().enumerate() {
        let what = match k {
            0 => "the leader: outermost, fixed to the baseplate".into(),
            _ => format!("follower {}: slides and turns in the tube above, joined to it at the tip", k + 1),
        };
        let _ = write!(
            text,
            "\n[[tube]] # {what}\n\
             outer_radius_mm = {}\n\
             inner_radius_mm = {}\n\
             \n\
             [tube.notches]\n\
             depth_mm = {} # from the outer surface; [base, tip] where it changes along the tube\n\
             length_mm = {} # of a notch along the tube\n\
             tooth_mm = {} # between two notches\n\
             opening_deg = {} # the tube bends to this side when the notches close\n\
             twist_deg = 0.0 # turn of the pattern from base to tip\n\
             below_plate = \"plain\" # uncut where it comes up from below the plate; \"continued\" where it is notched there too\n",
            mm(tube.outer),
            mm(tube.inner),
            mm(tube.depth),
            mm(notch),
            mm(tooth),
            (opening.to_degrees() * 1e6).round() / 1e6,
        );
    }
    text
}
