//! What a tube is along its axis: one stretch after the other, each cut in one pattern or uncut.
//!
//! A tube of a robot file is one stretch, cut from baseplate to tip; one of a bundle has a stretch for each of its parts. Depth and
//! direction run over a stretch, and so do the places of its notches.

use crate::error::MeshError;
use cppr::bundle::BundleDesign;
use cppr::design::{BelowPlate, NotchedTube, TubeDesign};
use cppr_io::RobotFile;

/// A robot whose tubes may have bodies.
pub trait Tubes {
    /// Its name.
    fn name(&self) -> &str;
    /// Number of its tubes.
    fn count(&self) -> usize;
    /// Length (m) and make of the parts of tube `index` (from 0), from base to tip. A first part without length lies below the
    /// baseplate alone.
    fn parts(&self, index: usize) -> Vec<(f64, &TubeDesign)>;

    /// Is tube `index` curved when free?
    fn is_curved(&self, index: usize) -> bool;

    /// Length of tube `index` above the baseplate at rest (m).
    fn length(&self, index: usize) -> f64 {
        self.parts(index).iter().map(|(length, _)| length).sum()
    }
}

impl Tubes for RobotFile {
    fn name(&self) -> &str {
        &self.design.name
    }

    fn count(&self) -> usize {
        self.design.tubes.len()
    }

    fn parts(&self, index: usize) -> Vec<(f64, &TubeDesign)> {
        vec![(self.design.length, &self.design.tubes[index])]
    }

    fn is_curved(&self, _: usize) -> bool {
        false
    }
}

impl Tubes for BundleDesign {
    fn name(&self) -> &str {
        &self.name
    }

    fn count(&self) -> usize {
        self.tubes.len()
    }

    fn parts(&self, index: usize) -> Vec<(f64, &TubeDesign)> {
        self.tubes[index].parts.iter().map(|part| (part.length, &part.body)).collect()
    }

    fn is_curved(&self, index: usize) -> bool {
        self.tubes[index].parts.iter().any(|part| part.rest_curvature.abs() > 0.0)
    }
}

/// Between two abscissae (m).
pub(crate) type Span = [f64; 2];

/// A part of a tube.
pub(crate) struct Stretch<'a> {
    pub design: &'a NotchedTube,
    /// Abscissa of its base (m).
    pub from: f64,
    /// Its length (m).
    length: f64,
    /// Does its pattern go on below the baseplate?
    goes_on_below: bool,
}

/// The parts of tube `tube` (from 0), all of one outline, from base to tip.
pub(crate) fn stretches(robot: &dyn Tubes, tube: usize) -> Result<Vec<Stretch<'_>>, MeshError> {
    let number = tube + 1;
    if tube >= robot.count() {
        return Err(MeshError::NoSuchTube { tube: number, count: robot.count() });
    }
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut from = 0.0;
    for (length, design) in robot.parts(tube) {
        let TubeDesign::Notched(design) = design else {
            return Err(MeshError::NoGeometry { tube: number });
        };
        if design.pattern.is_none() && !(design.depth.is_constant() && design.depth.eval(0.0, 1.0)[0] <= 0.0)
        {
            return Err(MeshError::NoPattern { tube: number });
        }
        if stretches.first().is_some_and(|first| first.design.outline != design.outline) {
            return Err(MeshError::Outlines { tube: number });
        }
        let below_alone = stretches.is_empty() && length <= 0.0;
        let goes_on_below = stretches.is_empty() && (below_alone || design.below == BelowPlate::Continued);
        stretches.push(Stretch { design, from, length, goes_on_below });
        from += length;
    }
    Ok(stretches)
}

impl Stretch<'_> {
    /// Abscissa along the part, that of its base below it.
    fn inside(&self, x: f64) -> f64 {
        (x - self.from).max(0.0).min(self.length)
    }

    /// Over what profiles run (m).
    fn run(&self) -> f64 {
        if self.length > 0.0 { self.length } else { 1.0 }
    }

    /// Depth of the notches γ (m).
    pub fn depth(&self, x: f64) -> f64 {
        self.design.depth.eval(self.inside(x), self.run())[0]
    }

    /// Direction of the centroid φ (rad).
    pub fn direction(&self, x: f64) -> f64 {
        let [value, slope, _] = self.design.direction.eval(self.inside(x), self.run());
        if self.goes_on_below && x < 0.0 { value + slope * x } else { value }
    }

    /// Area of the section in a notch at x (m²).
    pub fn area(&self, x: f64) -> f64 {
        self.design.outline.inertia(self.depth(x)).map_or(f64::NAN, |i| i.area)
    }

    /// Angle through which the direction turns (rad).
    pub fn turned(&self, from: f64, to: f64) -> f64 {
        (self.direction(to) - self.direction(from)).abs()
    }

    /// Where the notches lie that are wholly on the tube, from the lower end on, `below` (m) under the baseplate.
    pub fn notches(&self, below: f64) -> Vec<Span> {
        let Some(pattern) = &self.design.pattern else { return Vec::new() };
        let around = |middle: f64| [middle - 0.5 * pattern.length, middle + 0.5 * pattern.length];
        let pitch = pattern.length + pattern.tooth;
        let mut spans: Vec<Span> = Vec::new();
        if self.goes_on_below {
            let mut next = around(-0.5 * pitch);
            while next[0] > -below + 1e-9 * pitch {
                spans.push(next);
                next = next.map(|x| x - pitch);
            }
            spans.reverse();
        }
        spans.extend(pattern.middles().into_iter().map(around).map(|span| span.map(|x| self.from + x)));
        spans
    }
}
