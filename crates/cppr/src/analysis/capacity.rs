//! What notches and bundle can bear by their geometry alone, before anything is solved.
//!
//! With the share s of a cell's bending that its notch takes per length (`limits`: (ℓ + t)/ℓ for rigid teeth, 1 else), bending
//! in the plane closes the notch at the mean curvature 1/(s (ρ̄ + D)) and reaches the allowable strain ε at
//! ε/(s max(Y_top − D, D − α)). Euler's load of a pinned rod is π² EI_Z / L² (Tummers et al. 2024, eq 99); guided push-pull
//! tubes bear several times as much, so it is for comparison only.

use super::limits::Teeth;
use crate::design::{NotchPattern, NotchedTube, Robot, TubeDesign};
use std::f64::consts::PI;

/// One notch as it was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotchCapacity {
    /// Tube number, 1 is the leader.
    pub tube: usize,
    /// Notch number from 1 at the baseplate.
    pub number: u32,
    /// Rest abscissa of its middle (m).
    pub abscissa: f64,
    /// Depth γ (m).
    pub depth: f64,
    /// Thinnest wall of the section (m).
    pub thinnest_wall: f64,
    /// Height of what is left across the notch (m).
    pub kept_height: f64,
    /// Mean curvature of the cell at which bending towards the opening brings the teeth together (1/m).
    pub closing_curvature: f64,
    /// Mean curvature of the cell at which bending in the plane reaches the allowable strain (1/m), where there is one.
    pub straining_curvature: Option<f64>,
}

/// Curvature in a notch over the mean curvature of its cell.
pub(crate) fn concentration(pattern: &NotchPattern, teeth: Teeth) -> f64 {
    match teeth {
        Teeth::Rigid => pattern.pitch() / pattern.length,
        Teeth::Bending => 1.0,
    }
}

/// Every notch of every tube whose notches are known, tube by tube from the baseplate on.
#[must_use]
pub fn notch_capacities(robot: &Robot, teeth: Teeth) -> Vec<NotchCapacity> {
    let mut list = Vec::new();
    for (index, tube) in robot.design().tubes.iter().enumerate() {
        let TubeDesign::Notched(design) = tube else { continue };
        let Some(pattern) = design.pattern else { continue };
        for (number, abscissa) in (1..).zip(pattern.middles()) {
            list.extend(capacity(index + 1, number, abscissa, design, &pattern, robot.length(), teeth));
        }
    }
    list
}

fn capacity(
    tube: usize,
    number: u32,
    abscissa: f64,
    design: &NotchedTube,
    pattern: &NotchPattern,
    length: f64,
    teeth: Teeth,
) -> Option<NotchCapacity> {
    let outline = &design.outline;
    let depth = design.depth.eval(abscissa, length)[0];
    let fibres = outline.fibres(depth).filter(|_| depth > 0.0)?;
    let peak = design.cell_factors(depth).ok().flatten().and_then(|factors| factors.peak);
    let offset = fibres.offset;
    let share = concentration(pattern, teeth);
    // Farthest fibres on both sides of the centroid's line.
    let farthest =
        (fibres.greatest_kept([1.0, 0.0]) - offset).max(fibres.greatest_kept([-1.0, 0.0]) + offset);
    let per_curvature = peak.map_or(share * farthest, |peak| peak.bending_z[0].max(-peak.bending_z[1]));
    let edge = fibres.greatest_removed([-1.0, 0.0]) + offset;
    Some(NotchCapacity {
        tube,
        number,
        abscissa,
        depth,
        thinnest_wall: outline.thinnest_wall(depth),
        kept_height: outline.kept_height(depth),
        closing_curvature: 1.0 / (share * edge),
        straining_curvature: design.material.allowable_strain.map(|strain| strain / per_curvature),
    })
}

/// Sections at which the stiffness is looked at, less one.
const SAMPLES: u32 = 150;

/// Euler's load of a pinned rod with the bundle's least stiffness Σ EI_Z along the robot at rest (N), eq 99.
#[must_use]
pub fn euler_load(robot: &Robot) -> f64 {
    let length = robot.length();
    let stiffness = (0..=SAMPLES)
        .map(|i| length * f64::from(i) / f64::from(SAMPLES))
        .map(|x| (0..robot.tube_count()).map(|tube| robot.fields_at(tube, x).bending_z).sum::<f64>())
        .fold(f64::INFINITY, f64::min);
    PI * PI * stiffness / (length * length)
}
