//! Scenario files: which robots, which motions and loads.

use crate::PaperError;
use serde::Deserialize;

/// One page's scenario. Lengths in mm, angles in degrees, forces in N.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Heading.
    pub title: String,
    /// Section of the paper.
    pub section: String,
    /// What is shown and what was assumed.
    pub text: String,
    /// Names of robot files.
    pub robots: Vec<String>,
    /// Motions of the follower (mm), pull positive.
    #[serde(default)]
    pub pulls_mm: Vec<f64>,
    /// Rotations of the follower (deg).
    #[serde(default)]
    pub rotations_deg: Vec<f64>,
    /// Dead force on the tip's centre (N).
    #[serde(default, rename = "tip_force_N")]
    pub tip_force: [f64; 3],
    /// Tension of a thread (N).
    #[serde(default, rename = "thread_N")]
    pub thread: f64,
    /// Pulley for the left side (mm); the right one is its mirror image in Y.
    #[serde(default)]
    pub pulley_mm: [f64; 3],
    /// Another place of the pulley, to see what it matters.
    #[serde(default)]
    pub far_pulley_mm: [f64; 3],
    /// Numbers that the paper states.
    #[serde(default)]
    pub stated: Vec<Stated>,
}

/// A number that the paper states.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stated {
    /// Of what.
    pub what: String,
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Key of our number on the same page; none where only the unpublished measurements could tell.
    pub number: Option<String>,
}

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// What the TOML reader says.
    pub fn parse(text: &str) -> Result<Self, PaperError> {
        toml::from_str(text).map_err(|e| PaperError(e.to_string()))
    }
}
