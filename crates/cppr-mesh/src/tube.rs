//! The body of one tube at rest, as designed.
//!
//! Frame: the robot's base frame, x along the axis from the baseplate (the rest abscissa), y and z across; lengths
//! in m. At abscissa x inside a notch the section is what the mechanics computes with: the uncut ring without
//! its part Y ≤ α, α = γ(x) − ρ̄, Y along the centroid direction φ(x) ([`cppr::design::section`]). A notch thus
//! has a floor parallel to Z and flat flanks across the axis; where depth or direction change along the tube, they
//! change inside a notch too, and its floor is a ruled surface. Between notches, and where their depth is 0, the ring is whole.

use crate::body::{Body, Whole};
use crate::contour::Contour;
use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::ring::{Cut, Sampling, fractions};
use cppr::design::{BelowPlate, NotchedTube, Outline, TubeDesign};
use cppr_io::{NotchPattern, RobotFile};

/// Most triangles of a tube: 250 MB as STL.
const MOST_TRIANGLES: f64 = 5e6;
/// Deepest bisection of a stretch whose outline curves.
const DEPTH: u32 = 8;

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

/// The surface of tube `tube` (from 0, the leader first) at rest: closed, without flaws, in the base frame (m).
///
/// # Errors
/// [`MeshError`]: there is no such tube, it has no geometry, or options make no sense.
pub fn tube_mesh(file: &RobotFile, tube: usize, options: &TubeOptions) -> Result<Mesh, MeshError> {
    Ok(TubeBody::new(file, tube, options)?.build())
}

/// Volume of the same body by integration of its section area along the axis (m³).
///
/// # Errors
/// As [`tube_mesh`].
pub fn tube_volume(file: &RobotFile, tube: usize, options: &TubeOptions) -> Result<f64, MeshError> {
    Ok(TubeBody::new(file, tube, options)?.volume())
}

/// A notch between two abscissae (m).
pub(crate) type Span = [f64; 2];

/// A tube, its notches and how it is sampled.
pub(crate) struct TubeBody<'a> {
    pub design: &'a NotchedTube,
    pub length: f64,
    /// From the lower end to the tip.
    pub notches: Vec<Span>,
    options: TubeOptions,
    sampling: Sampling,
}

impl<'a> TubeBody<'a> {
    pub fn new(file: &'a RobotFile, tube: usize, options: &TubeOptions) -> Result<Self, MeshError> {
        let count = file.design.tubes.len();
        let number = tube + 1;
        let Some(design) = file.design.tubes.get(tube) else {
            return Err(MeshError::NoSuchTube { tube: number, count });
        };
        let TubeDesign::Notched(design) = design else {
            return Err(MeshError::NoGeometry { tube: number });
        };
        let pattern = file.tubes.get(tube).and_then(|t| t.notches);
        if pattern.is_none() && !(design.depth.is_constant() && design.depth.eval(0.0, 1.0)[0] <= 0.0) {
            return Err(MeshError::NoPattern { tube: number });
        }
        let [outer, bore] = contours(&design.outline);
        check(options, &outer)?;
        let length = file.design.length;
        let spans = pattern.map_or_else(Vec::new, |p| notches(&p, options.below, design.below));
        let widest = options.flange.map_or(0.0, |f| f.radius).max(outer.reach());
        let sagging = 2.0 * (1.0 - (options.detail.chord / widest).min(1.0)).acos();
        let step = sagging.min(options.detail.turn);
        // The flats of a polygon that winds are divided as circles are.
        let divided = options.flange.is_some() || !design.direction.is_constant();
        let sampling = Sampling::new(outer, bore, divided, step);
        let mut body = Self { design, length, notches: Vec::new(), options: *options, sampling };
        body.notches = spans.into_iter().flat_map(|span| body.notched(span)).collect();
        body.limit()?;
        Ok(body)
    }

    /// Refuses what would fill the memory.
    fn limit(&self) -> Result<(), MeshError> {
        let stations = (self.length + self.options.below) / self.options.detail.step
            + 4.0 * self.notches.len() as f64
            + self.wound(-self.options.below, self.length) / self.sampling.step;
        let triangles = 4.0 * self.sampling.kept(0.0).count() as f64 * stations;
        if triangles > MOST_TRIANGLES {
            return Err(MeshError::TooFine { triangles });
        }
        Ok(())
    }

    /// The parts of a notch that cut anything: none where its depth is 0, and not all where that begins or ends inside it.
    fn notched(&self, [from, to]: Span) -> Vec<Span> {
        const SAMPLES: u32 = 32;
        let cuts = |x: f64| self.cut(x).alpha > -self.sampling.outer.inradius;
        let mut parts: Vec<Span> = Vec::new();
        let mut begun = cuts(from).then_some(from);
        let mut last = from;
        for i in 1..=SAMPLES {
            let x = if i == SAMPLES { to } else { from + (to - from) * f64::from(i) / f64::from(SAMPLES) };
            if cuts(x) != begun.is_some() {
                // Halved to rounding: where depth jumps, so does the cut.
                let (mut off, mut on) = if begun.is_some() { (x, last) } else { (last, x) };
                while (0.5 * (off + on) - off).abs() > f64::EPSILON * self.length {
                    let middle = 0.5 * (off + on);
                    *(if cuts(middle) { &mut on } else { &mut off }) = middle;
                }
                match begun.take() {
                    Some(start) => parts.push([start, on]),
                    None => begun = Some(on),
                }
            }
            last = x;
        }
        parts.extend(begun.map(|start| [start, to]));
        parts
    }

    /// Depth of the notches γ (m).
    fn depth(&self, x: f64) -> f64 {
        self.design.depth.eval(x.max(0.0), self.length)[0]
    }

    /// Direction of the centroid φ (rad).
    pub fn direction(&self, x: f64) -> f64 {
        let [value, slope, _] = self.design.direction.eval(x.max(0.0), self.length);
        match self.design.below {
            BelowPlate::Continued if x < 0.0 => value + slope * x,
            _ => value,
        }
    }

    /// Angle through which the direction turns (rad).
    fn turned(&self, from: f64, to: f64) -> f64 {
        (self.direction(to) - self.direction(from)).abs()
    }

    pub fn cut(&self, x: f64) -> Cut {
        self.sampling.cut(self.depth(x))
    }

    /// Abscissae strictly inside a stretch, so many that no two sections differ too much.
    fn between(&self, [from, to]: Span, change: f64) -> Vec<f64> {
        let turned = self.turned(from, to).max(change);
        let parts = ((to - from) / self.options.detail.step).max(turned / self.sampling.step).ceil();
        fractions(parts).map(|share| from + (to - from) * share).collect()
    }

    /// Angle that counts for the floor of a notch, which winds: its facets, up to a radius wide, lie within a quarter of
    /// the radius times the angle between sections from it.
    fn wound(&self, from: f64, to: f64) -> f64 {
        let allowed = 4.0 * self.options.detail.chord / self.sampling.outer.inradius;
        self.turned(from, to) * (self.sampling.step / allowed).max(1.0)
    }

    /// The same for a notch, whose outline may curve.
    pub fn inside(&self, [from, to]: Span) -> Vec<f64> {
        let mut inside = Vec::new();
        let mut start = from;
        for end in self.between([from, to], self.wound(from, to)).into_iter().chain([to]) {
            self.bisect([start, end], DEPTH, &mut inside);
            inside.push(end);
            start = end;
        }
        inside.pop();
        inside
    }

    fn bisect(&self, [from, to]: Span, depth: u32, inside: &mut Vec<f64>) {
        let middle = 0.5 * (from + to);
        let [a, m, b] = [from, middle, to].map(|x| self.edges(x));
        let off = |i: usize| (m[i][0] - 0.5 * (a[i][0] + b[i][0])).hypot(m[i][1] - 0.5 * (a[i][1] + b[i][1]));
        if depth > 0 && (0..a.len()).any(|i| off(i) > self.options.detail.chord) {
            self.bisect([from, middle], depth - 1, inside);
            inside.push(middle);
            self.bisect([middle, to], depth - 1, inside);
        }
    }

    /// Where the cut leaves the outer surface and the bore (y, z in m).
    fn edges(&self, x: f64) -> [[f64; 2]; 4] {
        let cut = self.cut(x);
        let (sin, cos) = self.direction(x).sin_cos();
        let Sampling { outer, bore, .. } = &self.sampling;
        [(outer, cut.outer), (outer, -cut.outer), (bore, cut.bore), (bore, -cut.bore)].map(
            |(contour, angle)| {
                let [y, z] = contour.point(angle);
                [cos * y - sin * z, sin * y + cos * z]
            },
        )
    }

    /// Surfaces from `lower`, at the beginning of a whole stretch, almost to its end.
    fn advance(&self, body: &mut Body, mut lower: Whole, [from, to]: Span, [first, last]: [Cut; 2]) -> Whole {
        let change = (last.outer - first.outer).abs().max((last.bore - first.bore).abs());
        for x in self.between([from, to], change) {
            let share = (x - from) / (to - from);
            let split = [
                first.outer + share * (last.outer - first.outer),
                first.bore + share * (last.bore - first.bore),
            ];
            let next = body.station(x, self.direction(x)).whole(&self.sampling, self.tube(), split);
            body.whole(&lower, &next);
            lower = next;
        }
        lower
    }

    #[cfg(feature = "files")]
    pub fn outer(&self) -> &Contour {
        &self.sampling.outer
    }

    #[cfg(feature = "files")]
    pub fn bore(&self) -> &Contour {
        &self.sampling.bore
    }

    /// Area of the section in a notch at x (m²).
    pub fn area(&self, x: f64) -> f64 {
        self.design.outline.inertia(self.depth(x)).map_or(f64::NAN, |i| i.area)
    }

    fn tube(&self) -> [&Contour; 2] {
        [&self.sampling.outer, &self.sampling.bore]
    }

    fn build(&self) -> Mesh {
        let mut body = Body::default();
        let mut x = 0.0 - self.options.below;
        let mut cut = self.notches.first().map_or_else(|| self.sampling.cut(0.0), |notch| self.cut(notch[0]));
        let mut lower = self.lower_end(&mut body, x, &cut);
        for &[from, to] in &self.notches {
            let first = self.cut(from);
            lower = self.advance(&mut body, lower, [x, from], [cut, first]);
            let mut station = body.station(from, self.direction(from));
            let whole = station.whole(&self.sampling, self.tube(), [first.outer, first.bore]);
            let mut notched = station.notched(&self.sampling, &first);
            body.whole(&lower, &whole);
            body.step(&whole, &notched, true);
            for x in self.inside([from, to]) {
                let next = body.station(x, self.direction(x)).notched(&self.sampling, &self.cut(x));
                body.notched(&notched, &next);
                notched = next;
            }
            let last = self.cut(to);
            let mut station = body.station(to, self.direction(to));
            lower = station.whole(&self.sampling, self.tube(), [last.outer, last.bore]);
            let next = station.notched(&self.sampling, &last);
            body.notched(&notched, &next);
            body.step(&lower, &next, false);
            (x, cut) = (to, last);
        }
        lower = self.advance(&mut body, lower, [x, self.length], [cut, cut]);
        self.upper_end(&mut body, &lower, &cut);
        body.finish()
    }

    fn lower_end(&self, body: &mut Body, x: f64, cut: &Cut) -> Whole {
        let (direction, split) = (self.direction(x), [cut.outer, cut.bore]);
        let Some(Flange { radius, thickness }) = self.options.flange else {
            let tube = body.station(x, direction).whole(&self.sampling, self.tube(), split);
            body.end(&tube, false);
            return tube;
        };
        let disk = [&Contour { sides: None, inradius: radius }, &self.sampling.bore];
        let low = body.station(x - thickness, direction).whole(&self.sampling, disk, split);
        let mut station = body.station(x, direction);
        let high = station.whole(&self.sampling, disk, split);
        let tube = station.whole(&self.sampling, self.tube(), split);
        body.end(&low, false);
        body.whole(&low, &high);
        body.shoulder(&high, &tube, true);
        tube
    }

    fn upper_end(&self, body: &mut Body, lower: &Whole, cut: &Cut) {
        let (direction, split) = (self.direction(self.length), [cut.outer, cut.bore]);
        let mut station = body.station(self.length, direction);
        let tube = station.whole(&self.sampling, self.tube(), split);
        let Some(thickness) = self.options.tip_cap else {
            body.whole(lower, &tube);
            body.end(&tube, true);
            return;
        };
        let disk = [&self.sampling.outer, &Contour { sides: None, inradius: 0.0 }];
        let low = station.whole(&self.sampling, disk, split);
        let high = body.station(self.length + thickness, direction).whole(&self.sampling, disk, split);
        body.whole(lower, &tube);
        body.shoulder(&low, &tube, false);
        body.whole(&low, &high);
        body.end(&high, true);
    }

    /// ∫A dx by Simpson's rule over each notch.
    fn volume(&self) -> f64 {
        const PARTS: u32 = 64;
        let TubeOptions { below, flange, tip_cap, .. } = self.options;
        let [solid, bore] = self.tube().map(Contour::area);
        let whole = solid - bore;
        let mut volume = (below + self.length) * whole;
        for &[from, to] in &self.notches {
            let sum: f64 = (0..=PARTS)
                .map(|i| {
                    let weight = match i {
                        0 | PARTS => 1.0,
                        i if i % 2 == 1 => 4.0,
                        _ => 2.0,
                    };
                    weight * (self.area(from + (to - from) * f64::from(i) / f64::from(PARTS)) - whole)
                })
                .sum();
            volume += sum * (to - from) / f64::from(3 * PARTS);
        }
        volume
            + flange.map_or(0.0, |f| f.thickness * (std::f64::consts::PI * f.radius * f.radius - bore))
            + tip_cap.map_or(0.0, |thickness| thickness * solid)
    }
}

fn contours(outline: &Outline) -> [Contour; 2] {
    match *outline {
        Outline::Round { outer_radius, inner_radius } => {
            [outer_radius, inner_radius].map(|inradius| Contour { sides: None, inradius })
        }
        Outline::Polygon { sides, outer_apothem, inner_apothem } => {
            [outer_apothem, inner_apothem].map(|inradius| Contour { sides: Some(sides), inradius })
        }
    }
}

/// Where the notches lie that are wholly on the tube, from the lower end on.
fn notches(pattern: &NotchPattern, below: f64, kind: BelowPlate) -> Vec<Span> {
    let around = |middle: f64| [middle - 0.5 * pattern.length, middle + 0.5 * pattern.length];
    let pitch = pattern.length + pattern.tooth;
    let mut spans: Vec<Span> = Vec::new();
    if kind == BelowPlate::Continued {
        let mut next = around(-0.5 * pitch);
        while next[0] > -below + 1e-9 * pitch {
            spans.push(next);
            next = next.map(|x| x - pitch);
        }
        spans.reverse();
    }
    spans.extend(pattern.middles().into_iter().map(around));
    spans
}

fn check(options: &TubeOptions, outer: &Contour) -> Result<(), MeshError> {
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
