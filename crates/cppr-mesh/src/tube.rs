//! The body of one tube at rest, as designed.
//!
//! Frame: the robot's base frame, x along the axis from the baseplate (the rest abscissa), y and z across; lengths
//! in m. At abscissa x inside a notch the section is what the mechanics computes with: the uncut ring without
//! its part Y ≤ α, α = γ(x) − ρ̄, Y along the centroid direction φ(x) ([`cppr::design::section`]). A notch thus
//! has a floor parallel to Z and flat flanks across the axis; where depth or direction change along the tube, they
//! change inside a notch too, and its floor is a ruled surface. Between notches, and where their depth is 0, the ring is whole.
//! Where the direction jumps, from one part to the next, so do the places at which a whole ring is sampled ([`Whole::turned`]).

use crate::body::{Body, Whole};
use crate::contour::Contour;
use crate::error::MeshError;
use crate::mesh::Mesh;
use crate::options::{Flange, TubeOptions, check};
use crate::ring::{Cut, Sampling, fractions};
use crate::stretch::{Span, Stretch, Tubes, stretches};
use cppr::design::Outline;
use std::f64::consts::TAU;

/// Most triangles of a tube: 250 MB as STL.
const MOST_TRIANGLES: f64 = 5e6;
/// Deepest bisection of a stretch whose outline curves.
const DEPTH: u32 = 8;
/// Angle (rad) by which the sides of a polygon may miss each other from one part to the next.
const SAME_SIDES: f64 = 1e-6;

/// The surface of tube `tube` (from 0, the leader first) at rest: closed, without flaws, in the base frame (m).
///
/// # Errors
/// [`MeshError`]: there is no such tube, it has no geometry, or options make no sense.
pub fn tube_mesh(robot: &dyn Tubes, tube: usize, options: &TubeOptions) -> Result<Mesh, MeshError> {
    Ok(TubeBody::new(robot, tube, options)?.build())
}

/// Volume of the same body by integration of its section area along the axis (m³).
///
/// # Errors
/// As [`tube_mesh`].
pub fn tube_volume(robot: &dyn Tubes, tube: usize, options: &TubeOptions) -> Result<f64, MeshError> {
    Ok(TubeBody::new(robot, tube, options)?.volume())
}

/// A notch, or the part of one that cuts anything.
pub(crate) struct Notch {
    /// Number of its stretch.
    pub stretch: usize,
    pub span: Span,
}

/// A tube, its notches and how it is sampled.
pub(crate) struct TubeBody<'a> {
    /// From base to tip.
    pub stretches: Vec<Stretch<'a>>,
    pub length: f64,
    /// From the lower end to the tip.
    pub notches: Vec<Notch>,
    options: TubeOptions,
    sampling: Sampling,
}

impl<'a> TubeBody<'a> {
    pub fn new(robot: &'a dyn Tubes, tube: usize, options: &TubeOptions) -> Result<Self, MeshError> {
        let stretches = stretches(robot, tube)?;
        let Some(first) = stretches.first() else { return Err(MeshError::NoGeometry { tube: tube + 1 }) };
        let [outer, bore] = contours(&first.design.outline);
        check(options, &outer)?;
        let widest = options.flange.map_or(0.0, |f| f.radius).max(outer.reach());
        let sagging = 2.0 * (1.0 - (options.detail.chord / widest).min(1.0)).acos();
        let step = sagging.min(options.detail.turn);
        let cut: Vec<&Stretch> = stretches.iter().filter(|s| s.design.pattern.is_some()).collect();
        let sides = outer.sides.filter(|_| cut.len() > 1);
        // The flats of a polygon that winds are divided as circles are.
        let winds = stretches.iter().any(|s| !s.design.direction.is_constant());
        let divided = options.flange.is_some() || winds || sides.is_some();
        let sampling = Sampling::new(outer, bore, divided, step, sides);
        let length = robot.length(tube);
        let mut body = Self { stretches, length, notches: Vec::new(), options: *options, sampling };
        let mut notches = Vec::new();
        for (stretch, own) in body.stretches.iter().enumerate() {
            let spans = own.notches(options.below).into_iter();
            let parts = spans.flat_map(|span| body.parts_that_cut(own, span));
            notches.extend(parts.map(|span| Notch { stretch, span }));
        }
        body.notches = notches;
        body.check_sides(tube + 1)?;
        body.limit()?;
        Ok(body)
    }

    /// Refuses a polygon whose sides would have to turn between two parts.
    fn check_sides(&self, tube: usize) -> Result<(), MeshError> {
        let Some(sides) = self.sampling.outer.sides else { return Ok(()) };
        for pair in self.notches.windows(2).filter(|pair| pair[0].stretch != pair[1].stretch) {
            let [turn, rest] = self.seam(pair[0].stretch, pair[1].stretch).1;
            if rest.abs() > SAME_SIDES {
                let turn = turn + rest;
                return Err(MeshError::Sides { tube, sides, turn: turn - TAU * (turn / TAU).round() });
            }
        }
        Ok(())
    }

    /// Where one stretch gives way to a later one, how a whole ring is sampled anew: by how many samples and through what angle (rad)
    /// they go on, and what angle then is left.
    fn seam(&self, from: usize, to: usize) -> (usize, [f64; 2]) {
        let [from, to] = [from, to].map(|i| &self.stretches[i]);
        let jump = to.direction(to.from) - from.direction(to.from);
        let (count, turn) = self.sampling.turn(jump);
        let rest = jump - turn;
        (count, [turn, rest - TAU * (rest / TAU).round()])
    }

    /// Refuses what would fill the memory.
    fn limit(&self) -> Result<(), MeshError> {
        let wound: f64 = self.stretches.iter().map(|s| self.wound(s, -self.options.below, self.length)).sum();
        let stations = (self.length + self.options.below) / self.options.detail.step
            + 4.0 * self.notches.len() as f64
            + wound / self.sampling.step;
        let triangles = 4.0 * self.sampling.kept(0.0).count() as f64 * stations;
        if triangles > MOST_TRIANGLES {
            return Err(MeshError::TooFine { triangles });
        }
        Ok(())
    }

    /// The parts of a notch that cut anything: none where its depth is 0, and not all where that begins or ends inside it.
    fn parts_that_cut(&self, own: &Stretch, [from, to]: Span) -> Vec<Span> {
        const SAMPLES: u32 = 32;
        let cuts = |x: f64| self.cut(own, x).alpha > -self.sampling.outer.inradius;
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

    pub fn cut(&self, own: &Stretch, x: f64) -> Cut {
        self.sampling.cut(own.depth(x))
    }

    /// Abscissae strictly inside a span, so many that no two sections differ too much, with a change (rad) besides the turning.
    fn between(&self, own: &Stretch, [from, to]: Span, change: f64) -> Vec<f64> {
        let turned = own.turned(from, to).max(change);
        let parts = ((to - from) / self.options.detail.step).max(turned / self.sampling.step).ceil();
        fractions(parts).map(|share| from + (to - from) * share).collect()
    }

    /// Angle that counts for the floor of a notch, which winds: its facets, up to a radius wide, lie within a quarter of
    /// the radius times the angle between sections from it.
    fn wound(&self, own: &Stretch, from: f64, to: f64) -> f64 {
        let allowed = 4.0 * self.options.detail.chord / self.sampling.outer.inradius;
        own.turned(from, to) * (self.sampling.step / allowed).max(1.0)
    }

    /// The same for a notch, whose outline may curve.
    pub fn inside(&self, own: &Stretch, [from, to]: Span) -> Vec<f64> {
        let mut inside = Vec::new();
        let mut start = from;
        for end in self.between(own, [from, to], self.wound(own, from, to)).into_iter().chain([to]) {
            self.bisect(own, [start, end], DEPTH, &mut inside);
            inside.push(end);
            start = end;
        }
        inside.pop();
        inside
    }

    fn bisect(&self, own: &Stretch, [from, to]: Span, depth: u32, inside: &mut Vec<f64>) {
        let middle = 0.5 * (from + to);
        let [a, m, b] = [from, middle, to].map(|x| self.edges(own, x));
        let off = |i: usize| (m[i][0] - 0.5 * (a[i][0] + b[i][0])).hypot(m[i][1] - 0.5 * (a[i][1] + b[i][1]));
        if depth > 0 && (0..a.len()).any(|i| off(i) > self.options.detail.chord) {
            self.bisect(own, [from, middle], depth - 1, inside);
            inside.push(middle);
            self.bisect(own, [middle, to], depth - 1, inside);
        }
    }

    /// Where the cut leaves the outer surface and the bore (y, z in m).
    fn edges(&self, own: &Stretch, x: f64) -> [[f64; 2]; 4] {
        let cut = self.cut(own, x);
        let (sin, cos) = own.direction(x).sin_cos();
        let Sampling { outer, bore, .. } = &self.sampling;
        [(outer, cut.outer), (outer, -cut.outer), (bore, cut.bore), (bore, -cut.bore)].map(
            |(contour, angle)| {
                let [y, z] = contour.point(angle);
                [cos * y - sin * z, sin * y + cos * z]
            },
        )
    }

    /// Surfaces from `lower`, at the beginning of a whole span, almost to its end. There the sampling has caught up with the
    /// direction, from which it is `behind` (rad) at first.
    fn advance(
        &self,
        body: &mut Body,
        mut lower: Whole,
        (own, behind): (&Stretch, f64),
        [from, to]: Span,
        [first, last]: [Cut; 2],
    ) -> Whole {
        let change = (last.outer - first.outer).abs().max((last.bore - first.bore).abs()).max(behind.abs());
        for x in self.between(own, [from, to], change) {
            let share = (x - from) / (to - from);
            let split = [
                first.outer + share * (last.outer - first.outer),
                first.bore + share * (last.bore - first.bore),
            ];
            let direction = own.direction(x) - behind * (1.0 - share);
            let next = body.station(x, direction).whole(&self.sampling, self.tube(), split);
            body.whole(&lower, &next);
            lower = next;
        }
        lower
    }

    /// The same where a stretch begins on the way.
    fn cross(
        &self,
        body: &mut Body,
        lower: Whole,
        [before, after]: [usize; 2],
        [from, to]: Span,
        [first, last]: [Cut; 2],
    ) -> Whole {
        let [own, next] = [before, after].map(|i| &self.stretches[i]);
        let (seam, (count, [_, behind])) = (next.from, self.seam(before, after));
        let open = self.sampling.cut(0.0);
        let lower = self.advance(body, lower, (own, 0.0), [from, seam], [first, open]);
        let whole = body.station(seam, own.direction(seam)).whole(
            &self.sampling,
            self.tube(),
            [open.outer, open.bore],
        );
        body.whole(&lower, &whole);
        self.advance(body, whole.turned(count), (next, behind), [seam, to], [open, last])
    }

    #[cfg(feature = "files")]
    pub fn outer(&self) -> &Contour {
        &self.sampling.outer
    }

    #[cfg(feature = "files")]
    pub fn bore(&self) -> &Contour {
        &self.sampling.bore
    }

    fn tube(&self) -> [&Contour; 2] {
        [&self.sampling.outer, &self.sampling.bore]
    }

    fn build(&self) -> Mesh {
        let mut body = Body::default();
        let mut x = 0.0 - self.options.below;
        let (mut stretch, mut cut) = self.notches.first().map_or_else(
            || (0, self.sampling.cut(0.0)),
            |notch| (notch.stretch, self.cut(&self.stretches[notch.stretch], notch.span[0])),
        );
        let mut lower = self.lower_end(&mut body, &self.stretches[stretch], x, &cut);
        for &Notch { stretch: next, span: [from, to] } in &self.notches {
            let own = &self.stretches[next];
            let first = self.cut(own, from);
            lower = if next == stretch {
                self.advance(&mut body, lower, (own, 0.0), [x, from], [cut, first])
            } else {
                self.cross(&mut body, lower, [stretch, next], [x, from], [cut, first])
            };
            let mut station = body.station(from, own.direction(from));
            let whole = station.whole(&self.sampling, self.tube(), [first.outer, first.bore]);
            let mut notched = station.notched(&self.sampling, &first);
            body.whole(&lower, &whole);
            body.step(&whole, &notched, true);
            for x in self.inside(own, [from, to]) {
                let next = body.station(x, own.direction(x)).notched(&self.sampling, &self.cut(own, x));
                body.notched(&notched, &next);
                notched = next;
            }
            let last = self.cut(own, to);
            let mut station = body.station(to, own.direction(to));
            lower = station.whole(&self.sampling, self.tube(), [last.outer, last.bore]);
            let end = station.notched(&self.sampling, &last);
            body.notched(&notched, &end);
            body.step(&lower, &end, false);
            (stretch, x, cut) = (next, to, last);
        }
        let own = &self.stretches[stretch];
        lower = self.advance(&mut body, lower, (own, 0.0), [x, self.length], [cut, cut]);
        self.upper_end(&mut body, own, &lower, &cut);
        body.finish()
    }

    fn lower_end(&self, body: &mut Body, own: &Stretch, x: f64, cut: &Cut) -> Whole {
        let (direction, split) = (own.direction(x), [cut.outer, cut.bore]);
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

    fn upper_end(&self, body: &mut Body, own: &Stretch, lower: &Whole, cut: &Cut) {
        let (direction, split) = (own.direction(self.length), [cut.outer, cut.bore]);
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
        for &Notch { stretch, span: [from, to] } in &self.notches {
            let own = &self.stretches[stretch];
            let sum: f64 = (0..=PARTS)
                .map(|i| {
                    let weight = match i {
                        0 | PARTS => 1.0,
                        i if i % 2 == 1 => 4.0,
                        _ => 2.0,
                    };
                    weight * (own.area(from + (to - from) * f64::from(i) / f64::from(PARTS)) - whole)
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
