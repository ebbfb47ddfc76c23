//! What keeps a robot from becoming a body.

use std::fmt;

/// Why there is no mesh. Tubes are numbered from 1; lengths in m, shown in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshError {
    /// The robot has fewer tubes.
    NoSuchTube {
        /// The tube asked for.
        tube: usize,
        /// How many there are.
        count: usize,
    },
    /// The tube is described by its stiffness.
    NoGeometry {
        /// The tube.
        tube: usize,
    },
    /// The tube has notches of a depth, but it is not said where.
    NoPattern {
        /// The tube.
        tube: usize,
    },
    /// The parts of the tube have different outlines.
    Outlines {
        /// The tube.
        tube: usize,
    },
    /// The sides of a polygon would have to turn from one part to the next.
    Sides {
        /// The tube.
        tube: usize,
        /// Their number.
        sides: usize,
        /// The angle through which the notches turn (rad).
        turn: f64,
    },
    /// The tolerance is not a number, too fine to be made, or too coarse to be a tube.
    Tolerance {
        /// The tolerance (m).
        tolerance: f64,
        /// The largest one (m).
        coarsest: f64,
    },
    /// Sections would be no distance apart, or circles would have too few corners, or too many.
    Step {
        /// Distance of sections (m).
        step: f64,
        /// Angle of a chord (rad).
        turn: f64,
    },
    /// More triangles than a program could work with.
    TooFine {
        /// About how many.
        triangles: f64,
    },
    /// The flange lies inside the tube.
    Flange {
        /// Its radius (m).
        radius: f64,
        /// The tube's largest radius (m).
        least: f64,
    },
    /// Only round tubes are unrolled.
    NotRound {
        /// The tube.
        tube: usize,
    },
    /// The tool is wider than the notch.
    Kerf {
        /// The notch, from 1 at the lower end.
        notch: usize,
        /// Width of the cut (m).
        kerf: f64,
    },
    /// A length is negative, zero, not a number, or absurd.
    Length {
        /// Which length.
        quantity: &'static str,
        /// Its value (m).
        value: f64,
    },
}

impl MeshError {
    /// Finest tolerance, least thickness (m): 0.1 µm.
    pub const FINEST: f64 = 1e-7;
    /// Greatest length of an addition to a tube (m).
    pub const LARGEST: f64 = 10.0;
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Without the noise of the conversion.
        let mm = |length: &f64| (length * 1e15).round() / 1e12;
        match self {
            Self::NoSuchTube { tube, count } => {
                write!(f, "there is no tube {tube}; this robot has 1 to {count}")
            }
            Self::NoGeometry { tube } => write!(
                f,
                "tube {tube} is given by its stiffness, which has no shape; describe it by radii and notches instead"
            ),
            Self::NoPattern { tube } => write!(
                f,
                "the robot file says how deep the notches of tube {tube} are, not where: add length_mm and tooth_mm"
            ),
            Self::Outlines { tube } => {
                write!(
                    f,
                    "the parts of tube {tube} have different outlines, and a body needs one; give all of them the same radii"
                )
            }
            Self::Sides { tube, sides, turn } => write!(
                f,
                "the notches of tube {tube} turn by {}° from one part to the next, its {sides} sides cannot follow; write \
                 opening_deg that differ by a multiple of {}°",
                (turn.to_degrees() * 1e6).round() / 1e6,
                360.0 / *sides as f64
            ),
            Self::Tolerance { tolerance, coarsest } => write!(
                f,
                "a tolerance of {} mm is not between {} mm and a tenth of the tube's radius, {} mm",
                mm(tolerance),
                mm(&Self::FINEST),
                mm(coarsest)
            ),
            Self::Step { step, turn } => write!(
                f,
                "sections {} mm apart with chords over {turn} rad make no surface: write a positive step and 0.001 to 1 rad",
                mm(step)
            ),
            Self::TooFine { triangles } => {
                write!(f, "that would be about {triangles:.1e} triangles; choose a coarser tolerance")
            }
            Self::Flange { radius, least } => write!(
                f,
                "a flange of radius {} mm lies inside the tube; write more than {:.6} mm",
                mm(radius),
                mm(least)
            ),
            Self::NotRound { tube } => {
                write!(
                    f,
                    "tube {tube} is a polygon, and only round tubes are unrolled; export its body instead"
                )
            }
            Self::Kerf { notch, kerf } => {
                write!(f, "notch {notch} is narrower than a kerf of {} mm; take a finer tool", mm(kerf))
            }
            Self::Length { quantity, value } => write!(
                f,
                "{quantity} is {} mm; write a length between {} mm and {} mm",
                mm(value),
                mm(&Self::FINEST),
                mm(&Self::LARGEST)
            ),
        }
    }
}

impl std::error::Error for MeshError {}
