//! What a history with friction has done so far, in a file.

use crate::Failure;
use crate::cycle::{Args, Course, Point};
use crate::output;
use cppr::Vector3;
use cppr::bundle::solve::{BundleSolver, TubeEffort};
use cppr::bundle::{HistoryPoint, SavedHistory, SlipHistory};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Between two writes of the file.
const SPARE: Duration = Duration::from_secs(1);

/// The file of a history.
pub struct Checkpoint {
    path: PathBuf,
    /// Robot and options: a history goes on only where they are the same.
    asked: String,
    written: Instant,
}

#[derive(Serialize, Deserialize)]
struct Content {
    schema: String,
    asked: String,
    points: Vec<Kept>,
    state: SavedHistory,
}

/// A point as numbers.
#[derive(Serialize, Deserialize)]
struct Kept {
    leg: usize,
    tip: [f64; 3],
    efforts: Vec<[f64; 4]>,
    slipping: f64,
    corrected: [f64; 2],
}

const SCHEMA: &str = "cppr/cycle-checkpoint 1";

impl From<&Point> for Kept {
    fn from(own: &Point) -> Self {
        let HistoryPoint { tip, efforts, slipping, corrected } = &own.reached;
        let efforts = efforts.iter().map(|e| [e.label, e.rotation, e.force, e.torque]);
        Self {
            leg: own.leg,
            tip: (*tip).into(),
            efforts: efforts.collect(),
            slipping: *slipping,
            corrected: *corrected,
        }
    }
}

impl From<Kept> for Point {
    fn from(own: Kept) -> Self {
        let efforts = own.efforts.into_iter();
        let efforts =
            efforts.map(|[label, rotation, force, torque]| TubeEffort { label, rotation, force, torque });
        let Kept { leg, slipping, corrected, .. } = own;
        Self {
            leg,
            reached: HistoryPoint {
                tip: Vector3::from(own.tip),
                efforts: efforts.collect(),
                slipping,
                corrected,
            },
        }
    }
}

impl Checkpoint {
    /// Of a robot and what is asked of it.
    pub fn new(path: &Path, args: &Args, course: &Course) -> Result<Self, Failure> {
        output::check(&args.robot, &[("--checkpoint", Some(path))])?;
        let robot = fs::read_to_string(&args.robot)
            .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", args.robot.display())))?;
        Ok(Self { path: path.into(), asked: format!("{course:?}\n{robot}"), written: Instant::now() })
    }

    /// State and points from the file; `None` where there is none yet.
    pub fn restored(
        &mut self,
        solver: &mut BundleSolver,
        course: &Course,
    ) -> Result<Option<(SlipHistory, Vec<Point>)>, Failure> {
        let shown = self.path.display();
        let text = match fs::read_to_string(&self.path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(Failure::Input(format!("--checkpoint {shown}: cannot be read: {error}")));
            }
        };
        let other = || {
            Failure::Input(format!(
                "--checkpoint {shown}: this is not what is kept of this history; take another file, or remove it"
            ))
        };
        let content: Content = serde_json::from_str(&text).map_err(|_| other())?;
        if content.schema != SCHEMA || content.asked != self.asked || content.points.len() < 2 {
            return Err(other());
        }
        let points: Vec<Point> = content.points.into_iter().map(Point::from).collect();
        let (_, command) = course.command(points.len() - 2);
        let state =
            SlipHistory::restored(solver, course.friction(), content.state, &command).ok_or_else(other)?;
        Ok(Some((state, points)))
    }

    /// Writes the file, once in a while.
    pub fn keep(&mut self, state: &SlipHistory, points: &[Point]) -> Result<(), Failure> {
        if self.written.elapsed() < SPARE {
            return Ok(());
        }
        let content = Content {
            schema: SCHEMA.into(),
            asked: self.asked.clone(),
            points: points.iter().map(Kept::from).collect(),
            state: state.saved(),
        };
        let text = serde_json::to_vec(&content)
            .map_err(|error| Failure::Input(format!("{}: {error}", self.path.display())))?;
        output::write(&self.path, &text)?;
        self.written = Instant::now();
        Ok(())
    }

    /// The history is done.
    pub fn remove(self) -> Result<(), Failure> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(Failure::Input(format!(
                "--checkpoint {}: cannot be removed: {error}",
                self.path.display()
            ))),
            _ => Ok(()),
        }
    }
}
