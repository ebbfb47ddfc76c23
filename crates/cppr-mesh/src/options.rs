//! What of a tube is built, and how finely.

use crate::contour::Contour;
use crate::error::MeshError;

/// How finely a surface is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Largest distance between a chord and the curve that it stands for (m).
    pub chord: f64,
    /// Largest angle about the axis that a chord spans (rad).
    pub turn: f64,
    /// Largest distance between sections along the axis (m); infinite for a tube that is not bent afterwards.
    pub step: f64,
}

impl Detail {
    /// For making a tube at rest: chords within `tolerance` (m), and so many of them that polygons in place of circles
    /// and helices change the volume by less than 0.05 %.
    #[must_use]
    pub fn workshop(tolerance: f64) -> Self {
        Self { chord: tolerance, turn: 0.05, step: f64::INFINITY }
    }

    /// For looking at a tube that is bent: sections every `step` (m), circles of at least 24 chords.
    #[must_use]
    pub fn drawing(step: f64) -> Self {
        Self { chord: 5e-5, turn: 0.26, step }
    }
}

/// What of a tube is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeOptions {
    /// Fineness.
    pub detail: Detail,
    /// Length of the tube below the baseplate (m): uncut or with the pattern continued, as the robot file says.
    pub below: f64,
    /// A round flange below that, with the bore of the tube.
    pub flange: Option<Flange>,
    /// Thickness of a platform that closes the tube beyond its tip (m).
    pub tip_cap: Option<f64>,
}

/// A disk around the lower end of a tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flange {
    /// Radius (m).
    pub radius: f64,
    /// Thickness (m).
    pub thickness: f64,
}

impl TubeOptions {
    /// The tube from the baseplate to the tip.
    #[must_use]
    pub fn plain(detail: Detail) -> Self {
        Self { detail, below: 0.0, flange: None, tip_cap: None }
    }
}

/// Refuses what makes no sense for a tube with this outer contour.
pub(crate) fn check(options: &TubeOptions, outer: &Contour) -> Result<(), MeshError> {
    let Detail { chord, turn, step } = options.detail;
    let coarsest = 0.1 * outer.inradius;
    if !(chord >= MeshError::FINEST && chord <= coarsest) {
        return Err(MeshError::Tolerance { tolerance: chord, coarsest });
    }
    if !(step > 0.0 && (1e-3..=1.0).contains(&turn)) {
        return Err(MeshError::Step { step, turn });
    }
    if let Some(Flange { radius, .. }) = options.flange
        && (radius.is_nan() || radius <= outer.reach())
    {
        return Err(MeshError::Flange { radius, least: outer.reach() });
    }
    let lengths = [
        ("the length below the plate", Some(options.below), 0.0),
        ("the radius of the flange", options.flange.map(|f| f.radius), f64::MIN_POSITIVE),
        ("the thickness of the flange", options.flange.map(|f| f.thickness), MeshError::FINEST),
        ("the thickness of the tip platform", options.tip_cap, MeshError::FINEST),
    ];
    for (quantity, value, least) in lengths {
        if let Some(value) = value
            && !(value >= least && value <= MeshError::LARGEST)
        {
            return Err(MeshError::Length { quantity, value });
        }
    }
    Ok(())
}
