//! The short table that a person reads.

use crate::exceeded::Exceeded;
use crate::resolved::Resolved;
use crate::rubbing::Touch;
use crate::unstable::Unstable;
use cppr::analysis::{Shape, absurd_demand, total_bend};
use cppr::design::Robot;
use cppr::kinematics::Resolution;
use cppr::solve::{Equilibrium, Formulation, Status};
use cppr_io::sudden_changes;
use std::fmt::Write;
use std::time::Duration;

/// −0.000 reads as a finding; it is none.
pub fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        text.trim_start_matches('-').into()
    } else {
        text
    }
}

/// The status in words. The printed formulation has no energy to judge stability by.
pub fn status(found: &Equilibrium) -> String {
    match (found.status(), found.settings().formulation) {
        (Status::Converged, Formulation::Printed) => "converged; its stability is not known".into(),
        (status, _) => status.to_string(),
    }
}

/// What the usual solver makes of tubes whose notches end before the tip, and of sudden changes.
pub fn doubts(robot: &Robot) -> Vec<String> {
    let one = |(tube, end): (usize, f64)| {
        format!(
            "the notches of tube {tube} end at {} mm, but it bends as if notched up to the tip; where it is uncut, write depth_mm \
             as a table over x_mm that ends at 0",
            millimetres(end)
        )
    };
    let sudden = sudden_changes(robot.design()).map(|places| {
        format!(
            "modes may not follow sudden changes and uneven turns ({places}): commands that solve integrate along the robot instead, unless an option or \
             --margin keeps the modes; a [[tube.part]] on either side says the step as one"
        )
    });
    robot.ends_of_patterns().into_iter().map(one).chain(sudden).collect()
}

fn duration(time: Duration) -> String {
    let time = time.as_secs_f64() * 1e6;
    if time < 1e3 { format!("{time:.0} µs") } else { format!("{:.1} ms", time * 1e-3) }
}

/// A length in m as millimetres without the noise of the conversion.
pub fn millimetres(length: f64) -> String {
    format!("{}", (length * 1e9).round() / 1e6)
}

/// A number of things: `1 tube`, `3 tubes`.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Bends that differ by less (deg) read the same.
const SAME_BEND: f64 = 5e-3;

/// Name, status, tip, efforts, error, margin with its error and the direction in which the tip would go, limits exceeded, where an unstable robot goes, cost
/// of the solve and of its error.
pub fn table(
    resolved: &Resolved,
    shape: &Shape,
    margin: Option<(f64, Option<f64>, [f64; 3])>,
    exceeded: Option<&Exceeded>,
    unstable: Option<&Unstable>,
    touch: &Touch,
    [time, checked]: [Duration; 2],
) -> String {
    let found = &resolved.found;
    let mut text = String::new();
    let formulation = match found.settings().formulation {
        Formulation::Consistent => "consistent formulation",
        Formulation::Printed => "formulation as printed",
    };
    let stretch = if found.settings().resolution.stretch > 0 { ", with stretch" } else { "" };
    let plane =
        if found.settings().resolution.angle == 0 && found.settings().resolution != Resolution::SPATIAL {
            ", in the plane"
        } else {
            ""
        };
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<22}{value}");
    };
    line("formulation", format!("{formulation}{stretch}{plane}"));
    line("status", status(found));
    if let Some(tip) = shape.sections.last() {
        let three = |v: [f64; 3], digits| v.map(|c| format!("{:>10}", plain(c, digits))).join(" ");
        line("tip position", format!("{} mm", three((tip.centre * 1e3).into(), 3)));
        let direction = tip.rotation.column(0);
        line("tip direction", three([direction.x, direction.y, direction.z], 5));
        let bend = direction.y.hypot(direction.z).atan2(direction.x).to_degrees();
        let total = total_bend(found).to_degrees();
        let along = if (total - bend).abs() < SAME_BEND {
            String::new()
        } else {
            format!(" between tip and base, {} deg along the robot", plain(total, 3))
        };
        line("bend angle", format!("{:>10} deg{along}", plain(bend, 3)));
    }
    for (tube, a) in found.followers() {
        let name = format!("tube {tube}");
        let motion = format!("pulled {:>9} mm with {:>9} N", plain(a.motion * 1e3, 3), plain(a.tension, 4));
        let turn = format!(
            "turned {:>9} deg with {:>9} N mm",
            plain(a.rotation.to_degrees(), 3),
            plain(a.torque * 1e3, 4)
        );
        line(&name, motion);
        line("", turn);
    }
    for (name, value) in touch.lines() {
        line(&name, value);
    }
    line("elastic energy", format!("{:>10} mJ", plain(found.elastic_energy() * 1e3, 4)));
    line("accuracy", resolved.text());
    if let Some((margin, error, direction)) = margin {
        let within = error.map_or("; its error is not known".into(), |own| format!(", within {own:.0e}"));
        line(
            "margin to instability",
            format!("{:>10}{within} (1 at rest, 0 where it snaps)", plain(margin, 4)),
        );
        // At rest all motions are alike.
        if margin < 1.0 - 1e-6 && direction.iter().any(|c| c.abs() > 0.0) {
            let way = direction.map(|c| format!("{:>10}", plain(c, 5))).join(" ");
            line("softest motion", format!("{way} of the tip, or against it"));
        }
    }
    let s = found.statistics();
    let steps = match s.load_steps {
        0 => String::new(),
        n => format!(", {}", counted(n, "load step")),
    };
    let limit = exceeded.map_or(String::new(), |e| format!("; the limit {}", duration(e.time)));
    let aside = unstable.map_or(String::new(), |u| format!("; the stable shape {}", duration(u.time)));
    let steps = format!("{}{steps}", counted(s.iterations, "Newton step"));
    let [time, checked] = [time, checked].map(duration);
    line("cost", format!("{steps}, {time}; the accuracy {checked}{limit}{aside}"));
    for text in resolved.warning().into_iter().chain(resolved.snap()) {
        line("warning", text);
    }
    for sentence in unstable.into_iter().flat_map(Unstable::text) {
        line("warning", sentence);
    }
    if let Some(exceeded) = exceeded {
        line("warning", exceeded.text());
    }
    let robot = found.robot();
    for text in doubts(robot) {
        line("warning", text);
    }
    if let Some(demand) = absurd_demand(robot, found.command()) {
        line("warning", demand.to_string());
    }
    let tubes = counted(robot.tube_count(), "tube");
    format!("{}: {tubes}, {} mm\n{text}", robot.design().name, millimetres(robot.length()))
}
