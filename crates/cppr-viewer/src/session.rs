//! What one page asks and what answers it: its robot, the last equilibrium, and the next one from there.
//!
//! Every solve starts at the last stable equilibrium, as a robot moves; from rest where the page asks for it.

pub use crate::cloud::{Cloud, Range};
pub use crate::touch::Touch;

use crate::bundle::{BundleModel, Ranges};
use crate::cloud::Remaining;
use crate::describe::{self, Description};
use crate::drag;
use crate::message::{self, Message, SECTIONS};
use cppr::analysis::{ACCURACY, Place, SafeRange, SectionLimit, Shape, Teeth, explained, governing};
use cppr::design::{DesignProblem, Robot};
use cppr::solve::{Equilibrium, Solver, Status};
use cppr_io::bundle_file::{self, Described};
use cppr_io::scenario::NotchChange;
use cppr_io::{Problems, RobotFile, Scenario};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use web_time::Instant;

/// A message of the page.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// Solve this.
    Solve(Box<Solve>),
    /// Show the robot of a file; without one that with which the program was started.
    Robot(Option<File>),
    /// Turn the text of a scenario file into a scenario.
    ReadScenario(File),
    /// Turn a scenario into the text of a file.
    WriteScenario(Box<Scenario>),
    /// Where the tip can go.
    Workspace(Box<Cloud>),
    /// How far each actuator may go from here.
    Ranges(Box<Scenario>),
    /// How far the modes put the tip of the last stable equilibrium off.
    Error,
    /// How the tubes of the last stable equilibrium press on each other, and between which poses friction leaves it.
    Touch(Touch),
}

/// A file that was given to the page.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct File {
    /// Its name, for messages.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// Solve a scenario.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Solve {
    /// Number of the request, given back with the answer.
    pub id: u32,
    /// What is asked.
    pub scenario: Scenario,
    /// Start at rest rather than at the last equilibrium.
    #[serde(default)]
    pub from_rest: bool,
    /// Bring the tip near this place with the actuators; the answer says where they stand.
    #[serde(default)]
    pub target_mm: Option<[f64; 3]>,
    /// Where the shape is unstable, go to the stable one to which it is left.
    #[serde(default)]
    pub aside: bool,
    /// Take as many modes as the accuracy of the program needs, which is for poses from rest.
    #[serde(default)]
    pub resolved: bool,
}

/// Head of the message that carries a pose.
#[derive(Clone, Debug, Serialize)]
pub struct Pose {
    /// `pose`.
    pub kind: &'static str,
    /// Of the request.
    pub id: u32,
    /// Did the actuators go where the tip was wanted, and not where the scenario has them?
    pub dragged: bool,
    /// `converged` or `unstable`.
    pub status: &'static str,
    /// The same as a sentence.
    pub text: String,
    /// Which limit is exceeded most, as a sentence; none where all are kept.
    pub exceeded: Option<String>,
    /// Centre of the tip section.
    pub tip_mm: [f64; 3],
    /// Direction of the axis there.
    pub direction: [f64; 3],
    /// Angle between that and +X.
    pub bend_deg: f64,
    /// One per follower.
    pub actuators: Vec<ActuatorState>,
    /// Elastic energy of all tubes.
    #[serde(rename = "energy_mJ")]
    pub energy: f64,
    /// 1 at rest, 0 where the robot snaps; none in the printed formulation.
    pub margin: Option<f64>,
    /// Error of the tip, where it was asked for and is known.
    pub error_mm: Option<f64>,
    /// Every notch.
    pub limits: Vec<NotchLimit>,
    /// Newton steps.
    pub iterations: usize,
    /// Time of the solve (µs).
    pub solve_us: f64,
    /// Sections in the floats.
    pub sections: usize,
    /// Tubes in the floats.
    pub tubes: usize,
}

/// Where an actuator stands and what it exerts.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ActuatorState {
    pub(crate) tube: usize,
    pub(crate) pull_mm: f64,
    pub(crate) rotate_deg: f64,
    #[serde(rename = "tension_N")]
    pub(crate) tension: f64,
    #[serde(rename = "torque_Nmm")]
    pub(crate) torque: f64,
}

/// How near a notch is to closing.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct NotchLimit {
    tube: usize,
    /// Number of the notch from the baseplate; none for a section of a tube without notches.
    notch: Option<i32>,
    /// Rest abscissa of its middle.
    x_mm: f64,
    /// 1 where the teeth touch, negative where the notch opens.
    closure: Option<f64>,
    /// Largest strain.
    strain: f64,
    /// The same over what the material may bear.
    strain_use: Option<f64>,
}

/// Takes a message to the page; false where the page is gone.
pub type Send<'a> = &'a mut dyn FnMut(Message) -> bool;

/// A robot as it is solved.
struct Model {
    file: RobotFile,
    solver: Solver,
    changes: Vec<NotchChange>,
    /// Last stable equilibrium.
    stable: Option<Equilibrium>,
}

/// The robot on the page.
enum Shown {
    /// Tubes of one length, joined at the tip.
    Robot(Box<Model>),
    /// Anything else.
    Bundle(Box<BundleModel>),
}

/// State of one connection.
pub struct Session {
    /// The robot with which the program was started.
    first: Described,
    /// What is asked of it at first.
    start: Option<Scenario>,
    model: Option<Shown>,
    background: Option<Background>,
    stop: Arc<AtomicBool>,
}

/// What is done while the page asks nothing.
enum Background {
    Cloud(Box<Remaining>),
    Ranges(Ranges),
}

/// Something that is wrong with a message, as a message.
#[must_use]
pub fn problem(text: &str) -> Message {
    Message::Text(json!({"kind": "problem", "text": text}).to_string())
}

pub(crate) fn text(value: &impl Serialize) -> Message {
    Message::Text(serde_json::to_string(value).unwrap_or_default())
}

/// The problems of a file, one by one.
fn list(problems: &Problems) -> Vec<String> {
    let place = |line| if line > 0 { format!("line {line}: ") } else { String::new() };
    let mut list: Vec<String> = problems.list.iter().map(|p| format!("{}{p}", place(p.line))).collect();
    if problems.omitted > 0 {
        list.push(format!("{} more problems are not listed.", problems.omitted));
    }
    list
}

fn sentences(problems: &[DesignProblem]) -> Vec<String> {
    problems.iter().map(ToString::to_string).collect()
}

impl Session {
    /// Of a page that will ask for its robot.
    #[must_use]
    pub fn new(first: Described, start: Option<Scenario>) -> Self {
        Self { first, start, model: None, background: None, stop: Arc::default() }
    }

    /// While this is set, what [`Self::background`] does is put off: the page asks something.
    #[must_use]
    pub fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Shows the robot with which the program was started; false where the page is gone.
    pub(crate) fn show_first(&mut self, send: Send) -> bool {
        let keeps_modes = self.start.as_ref().is_some_and(Scenario::needs_modes);
        self.show("The robot", self.first.clone(), keeps_modes, send)
    }

    /// Takes a robot and describes it to the page. One with sudden changes is integrated, unless what is asked of it needs modes.
    fn show(&mut self, name: &str, robot: Described, keeps_modes: bool, send: Send) -> bool {
        let (robot, sudden) = if keeps_modes { (robot, None) } else { robot.integrated() };
        let shown = match robot {
            Described::Robot(file) => Model::new(file).map(|model| Shown::Robot(Box::new(model))),
            Described::Bundle { design, friction } => {
                BundleModel::new(design, friction, sudden).map(|model| Shown::Bundle(Box::new(model)))
            }
        };
        match shown {
            Ok(shown) => {
                self.background = None;
                match self.model.insert(shown) {
                    Shown::Robot(model) => model.describe(false, send),
                    Shown::Bundle(model) => model.describe(send),
                }
            }
            Err(problems) => send(refused_file(name, &problems)),
        }
    }

    /// Answers one request; false where the page is gone.
    pub fn answer(&mut self, request: Request, send: Send) -> bool {
        match request {
            Request::Solve(solve) => self.solve(&solve, send),
            Request::Robot(None) => {
                let start = self.start.clone();
                self.show_first(send)
                    && start.is_none_or(|s| send(text(&json!({"kind": "start", "scenario": s}))))
            }
            Request::Robot(Some(given)) => match bundle_file::parse_either(&given.text) {
                Ok(robot) => self.show(&given.name, robot, false, send),
                Err(problems) => send(refused_file(&given.name, &list(&problems))),
            },
            Request::ReadScenario(given) => match Scenario::parse(&given.text) {
                Ok(scenario) => send(text(&json!({"kind": "scenario", "scenario": scenario}))),
                Err(problem) => send(refused_file(&given.name, &[problem])),
            },
            Request::WriteScenario(scenario) => match scenario.to_toml() {
                Ok(toml) => send(text(&json!({"kind": "file", "text": toml}))),
                Err(message) => send(problem(&message)),
            },
            Request::Workspace(cloud) => self.start_cloud(&cloud, send),
            Request::Ranges(scenario) => self.ranges(&scenario, send),
            Request::Error => self.error(send),
            Request::Touch(touch) => self.touch(&touch, send),
        }
    }

    fn solve(&mut self, asked: &Solve, send: Send) -> bool {
        let refuse = |status: &str, reasons: &[String], send: Send| {
            send(text(&json!({"kind": "refused", "id": asked.id, "status": status, "reasons": reasons})))
        };
        let model = match &mut self.model {
            None => return refuse("wrong", &["there is no robot".into()], send),
            Some(Shown::Bundle(model)) => {
                // Ranges are those of the pose that was.
                self.background = None;
                return match model.solve(asked) {
                    Ok(bytes) => send(Message::Binary(bytes)),
                    Err((status, reasons)) => refuse(status, &reasons, send),
                };
            }
            Some(Shown::Robot(model)) => model,
        };
        match model.change(&asked.scenario.notches) {
            Ok(false) => {}
            Ok(true) => {
                self.background = None;
                if !model.describe(true, send) {
                    return false;
                }
            }
            Err(problems) => return refuse("wrong", &problems, send),
        }
        let command = match asked.scenario.command(model.solver.robot()) {
            Ok(command) => command,
            Err(problems) => return refuse("wrong", &problems, send),
        };
        let settings = asked.scenario.settings();
        let controls = describe::controls(model.solver.robot());
        let solver = &mut model.solver;
        if let Err(problem) = solver.set_settings(settings) {
            return refuse("wrong", &[problem.to_string()], send);
        }
        let start = model.stable.take().filter(|_| !asked.from_rest);
        let mut found = match start {
            Some(stable) if *stable.settings() == settings => stable,
            _ => solver.rest(),
        };
        // Dragged on from where the robot is, not from where the page had it.
        let command = if asked.target_mm.is_some() && found.command().loads == command.loads {
            found.command().clone()
        } else {
            command
        };
        let before = found.clone();
        let clock = Instant::now();
        if let Err(problem) = solver.solve_into(&command, &mut found) {
            model.stable = Some(before);
            return refuse("wrong", &[problem.to_string()], send);
        }
        let solve_us = clock.elapsed().as_secs_f64() * 1e6;
        if !found.status().is_equilibrium() {
            model.stable = Some(before);
            return refuse("not_converged", &[explained(found.robot(), &command, found.status())], send);
        }
        if let Some(target) = asked.target_mm {
            found = drag::towards(solver, found, &controls, cppr::Vector3::from(target) * 1e-3);
        }
        if asked.aside {
            found = solver.stable_aside(&found).unwrap_or(found);
        }
        let mut error = None;
        if asked.resolved {
            match solver.resolve(found, ACCURACY) {
                Ok((finer, own)) => (found, error) = (finer, own),
                Err(problem) => return refuse("wrong", &[problem.to_string()], send),
            }
        }
        let shape = solver.shape(&found, SECTIONS);
        let margin = solver.stability(&found).map(|s| s.margin);
        let limits = solver.section_limits(&found, Teeth::Rigid);
        let mut pose = Pose::new(asked.id, &found, &shape, solve_us);
        pose.margin = margin;
        pose.error_mm = error.map(|own| own.tip * 1e3);
        pose.dragged = asked.target_mm.is_some();
        pose.exceeded = exceeded(&limits);
        pose.limits = limits.iter().map(NotchLimit::from).collect();
        let bytes = message::encode(&pose, &message::floats(found.robot(), &shape));
        model.stable = Some(if found.status() == Status::Converged { found } else { before });
        send(Message::Binary(bytes))
    }

    /// Tells the page how far each actuator may go while the others stay; nothing where the pose is not safe itself.
    fn ranges(&mut self, scenario: &Scenario, send: Send) -> bool {
        let model = match &mut self.model {
            None => return send(problem("there is no robot")),
            Some(Shown::Bundle(model)) => {
                self.background = model.ranges(scenario).map(Background::Ranges);
                return true;
            }
            Some(Shown::Robot(model)) => model,
        };
        let solver = &mut model.solver;
        let safe = scenario.command(solver.robot()).ok().and_then(|command| {
            solver.set_settings(scenario.settings()).ok()?;
            solver.safe_ranges(&command, Teeth::Rigid).ok()
        });
        send(ranges(&safe.unwrap_or_default()))
    }

    /// Tells the page how far the tip of the last stable equilibrium is off; nothing of a bundle, whose poses say it.
    fn error(&mut self, send: Send) -> bool {
        let Some(Shown::Robot(model)) = &mut self.model else { return true };
        let Some(found) = &model.stable else { return true };
        let error = model.solver.accuracy(found);
        let bound = ACCURACY * found.robot().length();
        let advice = error.filter(|own| own.tip > bound).map(|own| {
            let part = own.tip / found.robot().length();
            format!("The modes put the tip off by {part:.0e} of the length: take more of them under Model.")
        });
        send(text(&json!({"kind": "error", "error_mm": error.map(|own| own.tip * 1e3), "advice": advice})))
    }

    /// Tells the page how the tubes of the last stable equilibrium touch; nothing where there is none.
    fn touch(&mut self, asked: &Touch, send: Send) -> bool {
        match &mut self.model {
            Some(Shown::Robot(model)) => {
                let Some(found) = &model.stable else { return true };
                let own = model.solver.integrated(found);
                let own = own.as_ref().map(|own| (own.solver(), &own.equilibrium));
                send(asked.answer(own.as_ref().map(|(solver, found)| (solver, *found))))
            }
            Some(Shown::Bundle(model)) => model.touch(asked).is_none_or(send),
            _ => true,
        }
    }

    /// Is there something to do while the page asks nothing?
    #[must_use]
    pub fn has_background_work(&self) -> bool {
        self.background.is_some()
    }

    fn start_cloud(&mut self, cloud: &Cloud, send: Send) -> bool {
        self.background = None;
        let model = match &self.model {
            None => return send(problem("there is no robot")),
            Some(Shown::Bundle(_)) => {
                return send(problem(
                    "the workspace of a robot with parts or joints is not drawn yet; cppr sweep tabulates it",
                ));
            }
            Some(Shown::Robot(model)) => model,
        };
        match Remaining::new(cloud, model.solver.robot()) {
            Ok(remaining) => {
                self.background = Some(Background::Cloud(Box::new(remaining)));
                true
            }
            Err(text) => send(problem(&text)),
        }
    }

    /// Solves some poses of the cloud, or looks for the next range; false where the page is gone.
    pub fn background(&mut self, send: Send) -> bool {
        let (going, done) = match (&mut self.background, &self.model) {
            (Some(Background::Cloud(remaining)), _) => {
                let message = remaining.some();
                (send(Message::Binary(message)), remaining.is_empty())
            }
            (Some(Background::Ranges(asked)), Some(Shown::Bundle(model))) => {
                (model.next_range(asked, &self.stop, send), asked.is_empty())
            }
            _ => (true, true),
        };
        if done {
            self.background = None;
        }
        going
    }
}

impl Model {
    fn new(file: RobotFile) -> Result<Self, Vec<String>> {
        let robot = Robot::from_design(file.design.clone()).map_err(|p| sentences(&p.0))?;
        Ok(Self { file, solver: Solver::new(&robot), changes: Vec::new(), stable: None })
    }

    /// Tells the page all about the robot; false where the page is gone.
    fn describe(&self, changed: bool, send: Send) -> bool {
        let file = RobotFile { design: self.solver.robot().design().clone(), ..self.file.clone() };
        send(text(&Description::new(&file, self.solver.robot(), changed)))
            && describe::bodies(&file, self.solver.robot())
                .into_iter()
                .all(|body| send(Message::Binary(body)))
    }

    /// Brings the notches to the given changes; true where the robot is another one then.
    fn change(&mut self, changes: &[NotchChange]) -> Result<bool, Vec<String>> {
        if self.changes == changes {
            return Ok(false);
        }
        let scenario = Scenario { notches: changes.to_vec(), ..Scenario::default() };
        let design = scenario.changed(self.file.design.clone())?;
        let robot = Robot::from_design(design).map_err(|p| sentences(&p.0))?;
        self.solver = Solver::new(&robot);
        self.changes = changes.to_vec();
        self.stable = None;
        Ok(true)
    }
}

impl From<&SectionLimit> for NotchLimit {
    fn from(limit: &SectionLimit) -> Self {
        let SectionLimit { tube, abscissa, closure, strain, .. } = *limit;
        let notch = match limit.place {
            Place::Notch(number) => Some(number),
            Place::Section | Place::Uncut => None,
        };
        Self { tube, notch, x_mm: abscissa * 1e3, closure, strain, strain_use: limit.strain_utilisation() }
    }
}

/// How far one actuator may go, in the words and units of scenarios.
#[derive(Clone, Debug, Serialize)]
struct ActuatorRange {
    tube: usize,
    key: String,
    low: f64,
    high: f64,
}

impl From<&SafeRange> for ActuatorRange {
    fn from(range: &SafeRange) -> Self {
        let quantity = range.input.quantity();
        let key = format!("{}_{}", quantity.keyword, quantity.shown_unit.replace(' ', ""));
        let [low, high] = [range.low, range.high].map(|end| quantity.shown(end.value));
        Self { tube: range.input.tube, key, low, high }
    }
}

impl Pose {
    fn new(id: u32, found: &Equilibrium, shape: &Shape, solve_us: f64) -> Self {
        let tip = shape.sections.last();
        let direction = tip.map_or_else(cppr::Vector3::x, |s| s.rotation.column(0).into_owned());
        let actuators = found.followers();
        Self {
            kind: "pose",
            id,
            dragged: false,
            status: if found.status() == Status::Unstable { "unstable" } else { "converged" },
            text: found.status().to_string(),
            exceeded: None,
            tip_mm: tip.map_or([0.0; 3], |s| (s.centre * 1e3).into()),
            direction: direction.into(),
            bend_deg: direction.x.clamp(-1.0, 1.0).acos().to_degrees(),
            actuators: actuators
                .map(|(tube, a)| ActuatorState {
                    tube,
                    pull_mm: a.motion * 1e3,
                    rotate_deg: a.rotation.to_degrees(),
                    tension: a.tension,
                    torque: a.torque * 1e3,
                })
                .collect(),
            energy: found.elastic_energy() * 1e3,
            margin: None,
            error_mm: None,
            limits: Vec::new(),
            iterations: found.statistics().iterations,
            solve_us,
            sections: shape.sections.len(),
            tubes: describe::tubes(shape),
        }
    }
}

/// Which limit is exceeded most, as a sentence; `None` where all are kept.
pub(crate) fn exceeded(limits: &[SectionLimit]) -> Option<String> {
    governing(limits, None).map(|worst| worst.exceeded()).filter(|sentence| !sentence.is_empty())
}

/// Safe ranges for the page.
pub(crate) fn ranges(safe: &[SafeRange]) -> Message {
    let ranges: Vec<_> = safe.iter().map(ActuatorRange::from).collect();
    text(&json!({"kind": "ranges", "ranges": ranges}))
}

fn refused_file(name: &str, problems: &[String]) -> Message {
    text(&json!({"kind": "bad_file", "name": name, "problems": problems}))
}
