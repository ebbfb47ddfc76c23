//! `cppr limits`: how far each actuator may go, and how near a pose is to the limits of every notch.

use crate::Failure;
use crate::bundle::{self, Ready};
use crate::bundle_figure;
use crate::clearance::{Gap, Play, RADII, gap};
use crate::command::{CommandArgs, build};
use crate::exceeded::Exceeded;
use crate::figure;
use crate::output::write_or_print;
use crate::outputs::Outputs;
use crate::resolved::{AccuracyArgs, Resolved};
use crate::table::{millimetres, plain};
use cppr::analysis::{
    Bound, Governing, NotchCapacity, Place, RangeEnd, SafeRange, SectionLimit, Teeth, euler_load,
    first_greatest, governing, notch_capacities,
};
use cppr::bundle::BundleDesign;
use cppr::design::Robot;
use cppr::solve::{Command, Input, Solver, Status};
use cppr_io::bundle_file::Described;
use cppr_plot::{ProfileCurve, ProfileInput, Quantity, profile_figure};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Shown by `--help`.
pub const EXAMPLES: &str = "\
Examples:
  cppr limits robots/r1.toml
  cppr limits robots/r3.toml --pull 5mm --tip-force 0,0,0.1N
  cppr limits robots/r4.toml --pull -4mm --plot utilisation.svg --csv notches.csv --json -
  cppr limits robots/childs3.toml --pull 2=1mm --pull 3=-0.5mm
  cppr limits robots/bundles/uncut_ends.toml --pull 1mm
  cppr limits robots/r1.toml --pull 5mm --tip-force 0,0.1962,0N --clearance 0.2mm

Each range is that of one actuator while the others and the loads stay as given. The strain counts where the robot
file has allowable_strain_percent; docs/src/limits.md derives what is computed.";

/// Arguments of `cppr limits`.
#[derive(clap::Args)]
pub struct Args {
    /// Robot file (TOML)
    robot: PathBuf,
    #[command(flatten)]
    command: CommandArgs,
    #[command(flatten)]
    accuracy: AccuracyArgs,
    /// Let the teeth bend as the notches do: the least strain and closure there can be
    #[arg(long)]
    bending_teeth: bool,
    /// Estimate the effect of a radial gap of this size between all tubes; by default, of those that the radii leave
    #[arg(long, value_name = "GAP", allow_hyphen_values = true, default_value = RADII, value_parser = gap)]
    clearance: Gap,
    /// Write ranges, notches and the pose, - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write every notch of the pose, - for standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the utilisation along the robot, .svg or .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Strains below this are rounding.
const STRAIGHT: f64 = 1e-12;

/// Everything that is written.
struct Report {
    name: String,
    length: f64,
    tubes: usize,
    teeth: Teeth,
    /// Of the figure.
    title: String,
    stable: bool,
    /// Tube and tension (N) of every actuator.
    tensions: Vec<(usize, f64)>,
    /// Euler's load (N) of tubes of one length.
    euler_load: Option<f64>,
    sections: Vec<SectionLimit>,
    margin: Option<f64>,
    ranges: Result<Vec<SafeRange>, String>,
    notches: Vec<NotchCapacity>,
    /// Of the pose.
    resolved: Option<Resolved>,
    /// What clearance would change.
    play: Option<Play>,
}

/// Computes, prints, writes.
pub fn run(args: &Args) -> Result<(), Failure> {
    let outputs = Outputs::new(&args.robot, [&args.json, &args.csv, &args.plot].map(Option::as_deref))?;
    let Outputs { json, csv, .. } = outputs;
    let teeth = if args.bending_teeth { Teeth::Bending } else { Teeth::Rigid };
    let report = match args.accuracy.described(&args.robot, args.command.rest.needs_modes())? {
        Described::Robot(file) => of_robot(args, &build(&file, &args.robot)?, teeth)?,
        Described::Bundle { design, .. } => of_bundle(args, &design, teeth)?,
    };
    if (csv.is_some() || outputs.plot.is_some()) && report.sections.is_empty() {
        return Err(Failure::Input(
            "the tubes of this robot are given by their stiffness and have no fibres to judge; --csv and --plot \
             need radii and notches in its file"
                .into(),
        ));
    }
    if let Some(path) = json {
        write_or_print(path, &format!("{:#}\n", report.json()))?;
    }
    if let Some(path) = csv {
        write_or_print(path, &report.csv())?;
    }
    outputs.draw(|| report.figure())?;
    let text = report.table();
    outputs.report(&text)
}

fn of_robot(args: &Args, robot: &Robot, teeth: Teeth) -> Result<Report, Failure> {
    let command = args.command.command(robot)?;
    let mut solver = args.command.solver(robot)?;
    let resolved = args.accuracy.solve_resolved(&mut solver, &command)?;
    let found = &resolved.found;
    let sections = solver.section_limits(found, teeth);
    let margin = solver.stability(found).map(|s| s.margin);
    let ranges = match Exceeded::of(&mut solver, found, teeth) {
        Some(exceeded) => Err(exceeded.text()),
        None => ranges(args, &mut solver, &command, teeth)?,
    };
    let gaps = args.clearance.between(robot.gaps());
    let integrated =
        if gaps.iter().flatten().any(|gap| *gap > 0.0) { solver.integrated(found) } else { None };
    let play = integrated.and_then(|own| Play::of(&mut own.solver(), &own.equilibrium, &gaps));
    Ok(Report {
        name: robot.design().name.clone(),
        length: robot.length(),
        tubes: robot.tube_count(),
        teeth,
        title: figure::title(found),
        stable: found.status() != Status::Unstable,
        tensions: found.followers().map(|(tube, actuator)| (tube, actuator.tension)).collect(),
        euler_load: Some(euler_load(robot)),
        sections,
        margin,
        ranges,
        notches: notch_capacities(robot, teeth),
        resolved: Some(resolved),
        play,
    })
}

/// Safe ranges, with as many modes as their ends need.
fn ranges(
    args: &Args,
    solver: &mut Solver,
    command: &Command,
    teeth: Teeth,
) -> Result<Result<Vec<SafeRange>, String>, Failure> {
    let accepted = args.accuracy.accepted(solver.settings());
    let ranges = solver.safe_ranges(command, teeth);
    let ends = ranges.iter().flatten().flat_map(|own| [(own.input, own.low), (own.input, own.high)]);
    let at = |(input, end): (Input, RangeEnd)| {
        let mut moved = command.clone();
        moved.set(input, end.value).ok().map(|()| moved)
    };
    let ends: Vec<Command> = ends.filter_map(at).collect();
    let usual = *solver.settings();
    let settings = solver.settings_for(&ends, accepted).settings;
    if settings == usual {
        return Ok(ranges.map_err(|problem| problem.to_string()));
    }
    solver.set_settings(settings).map_err(|problem| Failure::Input(problem.to_string()))?;
    Ok(solver.safe_ranges(command, teeth).map_err(|problem| problem.to_string()))
}

fn of_bundle(args: &Args, design: &BundleDesign, teeth: Teeth) -> Result<Report, Failure> {
    let ready = Ready::new(&args.command, &args.robot, design)?;
    let mut analysis = ready.analysis(design);
    let found = analysis.solver.solve(&ready.command);
    if !found.converged {
        return Err(bundle::no_equilibrium(&design.name, &found));
    }
    let ranges = match Exceeded::of_bundle(&mut analysis, &found, teeth) {
        Some(exceeded) => Err(exceeded.text()),
        None => analysis.safe_ranges(&ready.command, teeth).map_err(|p| p.to_string()),
    };
    Ok(Report {
        name: design.name.clone(),
        length: ready.bundle.length(),
        tubes: design.tubes.len(),
        teeth,
        title: bundle_figure::title(design, &ready.command),
        stable: found.stable,
        tensions: (1..).zip(&found.efforts).map(|(tube, own)| (tube, own.force)).collect(),
        euler_load: None,
        sections: analysis.section_limits(&found, teeth),
        margin: None,
        ranges,
        notches: Vec::new(),
        resolved: None,
        play: Play::of(&mut analysis.solver, &found, &args.clearance.between(design.gaps())),
    })
}

/// Number and unit of an input's value for people.
fn shown(input: Input, value: f64) -> String {
    let quantity = input.quantity();
    format!("{:>9} {}", plain(quantity.shown(value), 3), quantity.shown_unit)
}

fn bound(end: &RangeEnd) -> String {
    match end.bound {
        Bound::Limit(Governing { limit: kind, section: Some(section), .. }) => {
            format!("{kind}, {}", section.whereabouts())
        }
        Bound::Limit(Governing { limit: kind, .. }) => kind.to_string(),
        Bound::BranchEnds => "no equilibrium was found beyond that continues this one".into(),
        Bound::Open => {
            let used = end.nearest.map_or(String::new(), |g| {
                let place = g.section.map_or(String::new(), |section| format!(", {}", section.whereabouts()));
                format!(", {:.0} % used of {}{place}", (100.0 * g.utilisation).max(0.0), g.limit)
            });
            format!("nothing met up to here{used}")
        }
    }
}

impl Report {
    /// The worst section of a tube.
    fn worst(
        &self,
        tube: usize,
        value: impl Fn(&SectionLimit) -> Option<f64>,
    ) -> Option<(f64, &SectionLimit)> {
        let own = self.sections.iter().filter(|s| s.tube == tube);
        first_greatest(own.filter_map(|s| value(s).map(|v| (v, s))), |pair| pair.0)
    }

    fn table(&self) -> String {
        let mut text = String::new();
        let teeth = match self.teeth {
            Teeth::Rigid => "rigid teeth: the notches take all bending",
            Teeth::Bending => "teeth bend as the notches do",
        };
        let _ = writeln!(text, "{}: {} mm, {teeth}", self.name, millimetres(self.length));
        self.ranges_table(&mut text);
        self.pose_table(&mut text);
        if let Some(play) = &self.play {
            play.write(&mut text);
        }
        self.notches_table(&mut text);
        text
    }

    fn ranges_table(&self, text: &mut String) {
        match &self.ranges {
            Err(why) => {
                let _ = writeln!(text, "  no safe range: {why}");
            }
            Ok(ranges) if ranges.is_empty() => {
                let _ = writeln!(text, "  nothing to actuate");
            }
            Ok(ranges) => {
                let _ = writeln!(text, "  safe range of each actuator, the others as given");
                for range in ranges {
                    for (which, end) in [("from", &range.low), ("to", &range.high)] {
                        let head = if which == "from" {
                            format!("tube {} {}", range.input.tube, range.input.quantity().keyword)
                        } else {
                            String::new()
                        };
                        let value = shown(range.input, end.value);
                        let _ = writeln!(text, "    {head:<16}{which:<5}{value:<16}{}", bound(end));
                    }
                }
            }
        }
    }

    fn pose_table(&self, text: &mut String) {
        let _ = writeln!(text, "  at this pose");
        let mut line = |head: &str, value: String, unit: &str, rest: String| {
            let _ = writeln!(text, "    {head:<16}{value:>9} {unit:<4}{rest}");
        };
        let straight = self.sections.iter().all(|s| s.strain.abs().max(s.shear.abs()) < STRAIGHT);
        for tube in 1..=self.tubes {
            if straight {
                break;
            }
            if let Some((strain, section)) = self.worst(tube, |s| Some(s.strain.abs())) {
                let used = section.strain_utilisation().map_or("no allowable strain given".into(), |u| {
                    format!("{:.1} % of what is allowed", 100.0 * u)
                });
                let value = plain(strain.copysign(section.strain) * 100.0, 4);
                line(
                    &format!("tube {tube} strain"),
                    value,
                    "%",
                    format!("{used}, {}", section.whereabouts()),
                );
            }
            if let Some((shear, section)) =
                self.worst(tube, |s| Some(s.shear.abs()).filter(|s| *s > STRAIGHT))
            {
                let used = section.torsion_utilisation().map_or("no allowable strain given".into(), |u| {
                    format!("{:.1} % of what is allowed", 100.0 * u)
                });
                let value = plain(shear.copysign(section.shear) * 100.0, 4);
                line(
                    &format!("tube {tube} torsion"),
                    value,
                    "%",
                    format!("{used}, {}", section.whereabouts()),
                );
            }
            if let Some((closure, section)) = self.worst(tube, |s| s.closure) {
                let gap =
                    section.gap.map_or(String::new(), |gap| format!("{} mm left, ", plain(gap * 1e3, 3)));
                let value = plain(closure * 100.0, 4);
                line(&format!("tube {tube} closure"), value, "%", gap + &section.whereabouts());
            }
        }
        if let Some(margin) = self.margin {
            line("margin", plain(margin, 4), "", "1 at rest, 0 where it snaps".into());
        }
        for &(tube, tension) in &self.tensions {
            let rest = self.euler_load.map_or(String::new(), |load| {
                let times = plain(tension.abs() / load, 2);
                format!("{times} times Euler's load (eq 99; guided tubes bear more)")
            });
            line(&format!("tube {tube} tension"), plain(tension, 4), "N", rest);
        }
        for (head, value) in self.resolved.iter().flat_map(Resolved::lines) {
            line(head, String::new(), "", value);
        }
        if !self.stable {
            line("warning", String::new(), "", "this equilibrium is unstable".into());
        }
    }

    /// Least values over each tube's notches.
    fn notches_table(&self, text: &mut String) {
        for tube in 1..=self.tubes {
            let least = |value: fn(&NotchCapacity) -> f64| {
                let own = self.notches.iter().filter(|n| n.tube == tube);
                own.min_by(|a, b| value(a).total_cmp(&value(b)))
            };
            let (Some(wall), Some(height), Some(closing)) =
                (least(|n| n.thinnest_wall), least(|n| n.kept_height), least(|n| n.closing_curvature))
            else {
                continue;
            };
            let strain = least(|n| n.straining_curvature.unwrap_or(f64::INFINITY))
                .and_then(|n| n.straining_curvature)
                .map_or(String::new(), |k| format!(", strain is allowed to {} 1/m", plain(k, 2)));
            let _ = writeln!(
                text,
                "  tube {tube}, all notches: wall from {} mm, height from {} mm; in the plane teeth touch at {} 1/m{strain}",
                plain(wall.thinnest_wall * 1e3, 3),
                plain(height.kept_height * 1e3, 3),
                plain(closing.closing_curvature, 2)
            );
        }
    }

    fn csv(&self) -> String {
        let mut text = String::from(
            "tube,place,notch,x_m,label_m,curvature_y_1_m,curvature_z_1_m,strain,allowable_strain,shear,allowable_shear,closure,gap_m\n",
        );
        let cell = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
        for s in &self.sections {
            let (place, notch) = kind(s.place);
            let notch = notch.map_or(String::new(), |n| n.to_string());
            let [y, z] = s.curvature;
            let _ = writeln!(
                text,
                "{},{place},{notch},{},{},{y},{z},{},{},{},{},{},{}",
                s.tube,
                s.abscissa,
                s.label,
                s.strain,
                cell(s.allowable_strain),
                s.shear,
                cell(s.allowable_shear),
                cell(s.closure),
                cell(s.gap)
            );
        }
        text
    }

    fn json(&self) -> Value {
        let ranges = match &self.ranges {
            Ok(ranges) => ranges.iter().map(range_json).collect(),
            Err(why) => json!({ "none_because": why }),
        };
        let notches: Vec<Value> = self
            .notches
            .iter()
            .map(|n| {
                json!({
                    "tube": n.tube, "notch": n.number, "x_m": n.abscissa, "depth_m": n.depth,
                    "thinnest_wall_m": n.thinnest_wall, "kept_height_m": n.kept_height,
                    "closing_curvature_1_m": n.closing_curvature,
                    "straining_curvature_1_m": n.straining_curvature,
                })
            })
            .collect();
        let status = if self.stable { "converged" } else { "unstable" };
        json!({
            "schema": "cppr/limits", "schema_version": 1, "robot": self.name,
            "teeth": match self.teeth { Teeth::Rigid => "rigid", Teeth::Bending => "bending" },
            "euler_load_N": self.euler_load, "notches": notches, "ranges": ranges,
            "clearance": self.play.as_ref().map(Play::json),
            "pose": {
                "status": status, "margin_to_instability": self.margin,
                "tensions_N": self.tensions.iter().map(|own| own.1).collect::<Vec<_>>(),
                "governing": governing(&self.sections, self.margin).map(|g| governing_json(&g)),
                "sections": self.sections.iter().map(section_json).collect::<Vec<_>>(),
                "accuracy": self.resolved.as_ref().map(Resolved::json),
            },
        })
    }

    fn figure(&self) -> Result<cppr_plot::Figure, Failure> {
        let allowed = self.sections.iter().all(|s| s.allowable_strain.is_some());
        let strain =
            |s: &SectionLimit| Some(if allowed { s.strain_utilisation()? } else { s.strain.abs() } * 100.0);
        let closure = |s: &SectionLimit| s.closure.map(|c| 100.0 * c);
        let label = if allowed { "strain / allowable" } else { "strain" };
        let quantities = [(label, &strain as &dyn Fn(&SectionLimit) -> Option<f64>), ("closure", &closure)]
            .into_iter()
            .map(|(label, value)| Quantity {
                label: label.into(),
                unit: "%".into(),
                include_zero: true,
                curves: (1..=self.tubes)
                    .flat_map(|tube| [true, false].map(|uncut| self.curve(tube, uncut, value)))
                    .flatten()
                    .collect(),
            })
            .filter(|quantity| !quantity.curves.is_empty())
            .collect();
        let input = ProfileInput { title: self.title.clone(), x_label: "X".into(), quantities };
        profile_figure(&input).map_err(|e| figure::plot_failure(&e))
    }

    /// A value along one tube, over the label that its sections face.
    fn curve(
        &self,
        tube: usize,
        uncut: bool,
        value: &dyn Fn(&SectionLimit) -> Option<f64>,
    ) -> Option<ProfileCurve> {
        let own = self.sections.iter().filter(|s| s.tube == tube && (s.place == Place::Uncut) == uncut);
        let (x_m, values): (Vec<f64>, Vec<f64>) = own.filter_map(|s| Some((s.label, value(s)?))).unzip();
        (values.len() > 1).then(|| ProfileCurve { name: format!("tube {tube}"), tube, x_m, values })
    }
}

fn kind(place: Place) -> (&'static str, Option<i32>) {
    match place {
        Place::Notch(number) => ("notch", Some(number)),
        Place::Section => ("section", None),
        Place::Uncut => ("uncut", None),
    }
}

fn section_json(s: &SectionLimit) -> Value {
    let (place, notch) = kind(s.place);
    json!({
        "tube": s.tube, "place": place, "notch": notch, "x_m": s.abscissa, "label_m": s.label,
        "curvature_y_1_m": s.curvature[0], "curvature_z_1_m": s.curvature[1], "strain": s.strain,
        "allowable_strain": s.allowable_strain, "shear": s.shear, "allowable_shear": s.allowable_shear,
        "closure": s.closure, "gap_m": s.gap,
    })
}

/// The nearest limit, for JSON.
pub fn governing_json(g: &Governing) -> Value {
    json!({ "limit": g.limit.to_string(), "utilisation": g.utilisation, "section": g.section.as_ref().map(section_json) })
}

fn range_json(range: &SafeRange) -> Value {
    let unit = range.input.quantity().unit;
    let end = |end: &RangeEnd| {
        let (why, governing) = match end.bound {
            Bound::Limit(g) => (g.limit.to_string(), Some(governing_json(&g))),
            Bound::BranchEnds => ("branch_ends".into(), None),
            Bound::Open => ("open".into(), end.nearest.map(|g| governing_json(&g))),
        };
        json!({ "value": end.value, "bound": why, "governing": governing })
    };
    json!({
        "tube": range.input.tube, "actuator": range.input.quantity().keyword, "unit": unit, "start": range.start,
        "low": end(&range.low), "high": end(&range.high),
    })
}
