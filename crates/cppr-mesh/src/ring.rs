//! Sections as chains of points that correspond from one section to the next.
//!
//! Every section of a tube is described by the same chains, whatever its notch leaves of it: the kept and the
//! removed arc of the outer contour, and of the bore. All arcs are sampled at the same angles; angles beyond the
//! end of an arc move onto its end. Chains that are not there thus collapse to a point, and so does a bore that
//! a deep notch cuts away. Points that coincide get one vertex (bit by bit: they come from the same expression),
//! and what has no area is left out when chains are joined to surfaces.

use crate::contour::Contour;
use std::f64::consts::{PI, TAU};

/// Share of the outer radius below which a notch that all but touches the bore, its far side or the outer surface
/// is taken to touch: 30 nm for a radius of 3 mm, which single precision still resolves.
const TOUCH: f64 = 1e-5;
/// Angle (rad) from a vertex of a polygon within which the end of an arc takes it along.
const SNAP_POLYGON: f64 = 1e-5;
/// The same as a share of the step, where only circles are sampled.
const SNAP_ROUND: f64 = 0.25;

/// The places that divide a unit into equal parts.
pub(crate) fn fractions(parts: f64) -> impl Iterator<Item = f64> {
    (1_u32..).map(f64::from).take_while(move |k| *k < parts).map(move |k| k / parts)
}

/// Contours of a tube and the angles at which all are sampled.
#[derive(Clone, Debug)]
pub(crate) struct Sampling {
    pub outer: Contour,
    pub bore: Contour,
    /// Angles in [−π, π] for kept arcs, about +Y, 0 and both ends among them.
    kept: Vec<f64>,
    /// The same angles for removed arcs, about −Y.
    removed: Vec<f64>,
    snap: f64,
    /// Largest step (rad).
    pub step: f64,
}

impl Sampling {
    /// Angles at most `step` apart, snapping included; those of the vertices alone where neither contour is round
    /// nor `divided`. They are the same seen from each of `sides`.
    pub fn new(outer: Contour, bore: Contour, divided: bool, step: f64, sides: Option<usize>) -> Self {
        let round = divided || outer.sides.is_none() || bore.sides.is_none();
        let corners: Vec<f64> = outer.vertices().into_iter().chain(bore.vertices()).collect();
        let snap = if corners.is_empty() { SNAP_ROUND * step } else { SNAP_POLYGON };
        let mut angles = vec![0.0, PI];
        if round {
            // Quarter turns are among the angles.
            let sides = sides.unwrap_or(1) as f64;
            let half = 2.0 * ((0.5 * PI * (1.0 + SNAP_ROUND) / step).ceil().max(2.0) / sides).ceil() * sides;
            angles.extend(fractions(half).map(|share| PI * share));
        }
        angles.extend(corners.iter().copied().filter(|a| *a > 0.0));
        angles.sort_by(f64::total_cmp);
        angles.dedup_by(|a, b| (*a - *b).abs() < SNAP_POLYGON);
        let mirrored = |half: &[f64]| -> Vec<f64> {
            half.iter().rev().filter(|a| **a > 0.0).map(|a| -a).chain(half.iter().copied()).collect()
        };
        let opposite: Vec<f64> = angles.iter().rev().map(|a| PI - a).collect();
        Self { outer, bore, kept: mirrored(&angles), removed: mirrored(&opposite), snap, step }
    }

    /// Angles of the kept arc [−half, half].
    pub fn kept(&self, half: f64) -> impl Iterator<Item = f64> {
        let snap = self.snap;
        self.kept
            .iter()
            .map(move |&a| if a.abs() >= half - snap && a.abs() > 0.0 { half.copysign(a) } else { a })
    }

    /// The angle (rad) nearest to a turn through which the sampling of a whole circle turns into itself, and the number of samples that
    /// come before what then is the first.
    pub fn turn(&self, angle: f64) -> (usize, f64) {
        let off = |turn: f64| {
            let off = turn - angle;
            (off - TAU * (off / TAU).round()).abs()
        };
        let turns = self.kept.iter().map(|a| a + PI).enumerate();
        turns.min_by(|a, b| off(a.1).total_cmp(&off(b.1))).unwrap_or_default()
    }

    /// Angles of the removed arc from `half` over π to −`half`.
    pub fn removed(&self, half: f64) -> impl Iterator<Item = f64> {
        let snap = self.snap;
        self.removed.iter().map(move |&a| {
            if a.abs() >= PI - half - snap && a.abs() > 0.0 {
                if a < 0.0 { half } else { -half }
            } else if a > 0.0 {
                a - PI
            } else {
                a + PI
            }
        })
    }

    /// The cut of a notch of the given depth (m).
    pub fn cut(&self, depth: f64) -> Cut {
        let touch = TOUCH * self.outer.inradius;
        let mut alpha = depth - self.outer.inradius;
        if depth < touch {
            alpha = -self.outer.inradius;
        } else if (alpha - self.bore.top()).abs() < touch {
            alpha = self.bore.top();
        } else if (alpha + self.bore.inradius).abs() < touch {
            // The ring just opens. Without a gap its edges would touch along a line.
            alpha = touch - self.bore.inradius;
        }
        Cut { alpha, outer: self.outer.angle(alpha), bore: self.bore.angle(alpha) }
    }
}

/// Where a notch ends a section: Y > α is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// α (m).
    pub alpha: f64,
    /// Half the angle of the outer surface that is kept (rad).
    pub outer: f64,
    /// Half the angle of the bore that is kept (rad): 0 where the notch passes the bore, π where it does not reach it.
    pub bore: f64,
}

/// What a notch does to the bore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// It ends in the wall.
    Wall,
    /// It opens the bore.
    Bore,
    /// Nothing of the bore is left.
    Beyond,
}

impl Cut {
    pub fn reach(&self, bore: &Contour) -> Reach {
        if self.alpha <= -bore.inradius {
            Reach::Wall
        } else if self.alpha <= bore.top() {
            Reach::Bore
        } else {
            Reach::Beyond
        }
    }
}
