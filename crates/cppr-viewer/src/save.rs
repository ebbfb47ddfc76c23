//! A page to send: poses computed beforehand, and everything that shows them, in one HTML file.
//!
//! The file holds the page, its style and script, and the messages that a server would have sent: the robot, the
//! bodies of its tubes, and one message for every pose of a grid. It opens from anywhere and talks to nobody.

use crate::message::Message;
use crate::session::{Request, Session, Solve};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use cppr_io::Scenario;
use cppr_io::bundle_file::Described;
use cppr_io::scenario::ActuatorEntry;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt;

/// Most poses of a page: some 50 MB.
pub const MOST_POSES: usize = 2000;

/// What is swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Swept {
    /// Translation (mm).
    Pull,
    /// Force (N).
    Tension,
    /// Rotation (°).
    Rotate,
    /// Torque (N mm).
    Torque,
}

/// One quantity and its values, in the unit of [`Swept`].
#[derive(Clone, Debug)]
pub struct Axis {
    /// Which.
    pub swept: Swept,
    /// Of which tube.
    pub tube: usize,
    /// Two or more values.
    pub values: Vec<f64>,
}

/// Why no page is made.
#[derive(Clone, Debug, PartialEq)]
pub enum SaveProblem {
    /// More poses than a page can hold.
    TooMany(usize),
    /// The robot or what is asked of it is wrong.
    Wrong(String),
    /// No pose has an equilibrium.
    NoEquilibrium,
}

impl fmt::Display for SaveProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooMany(count) => {
                write!(f, "{count} poses are more than a page holds ({MOST_POSES}): sweep fewer values")
            }
            Self::Wrong(problem) => write!(f, "{problem}"),
            Self::NoEquilibrium => {
                write!(f, "no pose of the sweep has an equilibrium: sweep a smaller range")
            }
        }
    }
}

impl std::error::Error for SaveProblem {}

impl Axis {
    /// Sets the value in a scenario; the other way to prescribe this degree of freedom is taken away.
    fn apply(&self, scenario: &mut Scenario, value: f64) {
        let list = &mut scenario.actuator;
        let at = list.iter().position(|a| a.tube == self.tube).unwrap_or_else(|| {
            list.push(ActuatorEntry { tube: self.tube, ..ActuatorEntry::default() });
            list.len() - 1
        });
        let entry = &mut list[at];
        match self.swept {
            Swept::Pull => (entry.pull_mm, entry.tension_N) = (Some(value), None),
            Swept::Tension => (entry.pull_mm, entry.tension_N) = (None, Some(value)),
            Swept::Rotate => (entry.rotate_deg, entry.torque_Nmm) = (Some(value), None),
            Swept::Torque => (entry.rotate_deg, entry.torque_Nmm) = (None, Some(value)),
        }
    }

    fn record(&self) -> impl Serialize {
        let (name, unit) = match self.swept {
            Swept::Pull => ("Pull", "mm"),
            Swept::Tension => ("Pull", "N"),
            Swept::Rotate => ("Turn", "°"),
            Swept::Torque => ("Turn", "N mm"),
        };
        let nearest = |(_, a): &(usize, &f64), (_, b): &(usize, &f64)| a.abs().total_cmp(&b.abs());
        let start = self.values.iter().enumerate().min_by(nearest).map_or(0, |(i, _)| i);
        json!({"name": format!("{name} {}", self.tube), "unit": unit, "values": self.values, "start": start})
    }
}

/// The page. `base` says everything that is not swept; the last axis varies fastest.
///
/// # Errors
/// [`SaveProblem`].
pub fn page(robot: Described, base: &Scenario, axes: &[Axis]) -> Result<String, SaveProblem> {
    let count =
        axes.iter().map(|a| a.values.len()).try_fold(1_usize, usize::checked_mul).unwrap_or(usize::MAX);
    if count > MOST_POSES {
        return Err(SaveProblem::TooMany(count));
    }
    let name = robot.name().to_owned();
    let mut session = Session::new(robot, Some(base.clone()));
    let mut scenario = base.clone();
    let mut messages = Vec::new();
    let mut poses = Vec::with_capacity(count);
    for index in 0..count {
        let mut rest = index;
        for axis in axes.iter().rev() {
            axis.apply(&mut scenario, axis.values[rest % axis.values.len()]);
            rest /= axis.values.len();
        }
        if index == 0 {
            session.show_first(&mut |m| keep(&mut messages, m));
        }
        // Each pose by itself, as the program solves it: what a pose is does not depend on its neighbours.
        let solve = Solve { scenario: scenario.clone(), from_rest: true, resolved: true, ..Solve::default() };
        let mut answers = Vec::new();
        session.answer(Request::Solve(Box::new(solve)), &mut |m| keep(&mut answers, m));
        let pose = answers.pop().unwrap_or(Value::Null);
        if pose["status"] == "wrong" {
            return Err(SaveProblem::Wrong(sentences(&pose["reasons"])));
        }
        // Other notches than those of the file come with the first pose.
        messages.extend(answers);
        poses.push(pose);
    }
    if !poses.iter().any(Value::is_string) {
        return Err(SaveProblem::NoEquilibrium);
    }
    let data = json!({
        "axes": axes.iter().map(Axis::record).collect::<Vec<_>>(),
        "scenario": scenario,
        "messages": messages,
        "poses": poses,
        "text": format!("{count} poses, computed beforehand by cppr {}.", env!("CARGO_PKG_VERSION")),
    });
    Ok(html(&name, &data))
}

/// Keeps a message as the page reads it: JSON as it is, binary in base 64.
fn keep(list: &mut Vec<Value>, message: Message) -> bool {
    list.push(match message {
        Message::Binary(bytes) => BASE64_STANDARD.encode(bytes).into(),
        Message::Text(text) => serde_json::from_str(&text).unwrap_or(Value::Null),
    });
    true
}

fn sentences(reasons: &Value) -> String {
    let list = reasons.as_array().into_iter().flatten().filter_map(Value::as_str);
    list.collect::<Vec<_>>().join("\n")
}

/// Everything in one file. Inside a script element nothing may look like its end.
fn html(name: &str, data: &Value) -> String {
    let policy =
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src blob: data:";
    let name = name.replace('&', "&amp;").replace('<', "&lt;");
    let data = data.to_string().replace('<', "\\u003c");
    let style = include_str!("../dist/viewer.css");
    let script = include_str!("../dist/viewer.js").replace("</script", "<\\/script");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{name}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{style}</style>\n</head>\n<body>\n<div id=\"app\"></div>\n\
         <script id=\"saved\" type=\"application/json\">{data}</script>\n<script>\n{script}</script>\n</body>\n</html>\n"
    )
}
