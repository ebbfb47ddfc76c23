//! From a design to the material fields of a bundle.

use super::curve::{Piece, Values};
use super::{Bundle, BundleTube, Shaft};
use crate::design::metal::Metal;
use crate::design::robot::{barycentric, chebyshev, gap, misfit};
use crate::design::{
    BelowPlate, CellFactors, DesignProblem, DesignProblems, JointProblem, NotchedTube, Outline, Profile,
    Robot, RobotDesign, SectionError, StiffnessTube, Torsion, TubeDesign,
};
use std::cell::RefCell;
use std::sync::Arc;

/// One part of a tube, from base to tip.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Part {
    /// Length along the axis (m).
    pub length: f64,
    /// What it is made of; its profiles run from 0 to the length of the part.
    pub body: TubeDesign,
    /// Curvature of the free part's axis (1/m).
    pub rest_curvature: f64,
    /// Direction towards which it curves, about the axis from +Y towards +Z (rad).
    pub rest_direction: f64,
}

/// A tube made of parts. Below the plate its first part goes on with what it has at its base; a first part without length is
/// what lies below the plate alone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TubeParts {
    /// From base to tip.
    pub parts: Vec<Part>,
    /// Between motor and plate; `None` is rigid.
    pub shaft: Option<Shaft>,
}

impl TubeParts {
    /// A tube of parts, from base to tip. Below the plate a notched tube is uncut unless its pattern goes on there: a first part without length that
    /// says so is put before them.
    #[must_use]
    pub fn new(mut parts: Vec<Part>, shaft: Option<Shaft>) -> Self {
        if let Some(first) = parts.first()
            && let TubeDesign::Notched(tube) = &first.body
            && first.length > 0.0
            && tube.below == BelowPlate::Plain
        {
            let direction = Profile::constant(tube.direction.eval(0.0, first.length)[0]);
            let plain =
                NotchedTube { depth: Profile::constant(0.0), direction, pattern: None, ..tube.clone() };
            let below = Part { length: 0.0, body: TubeDesign::Notched(plain), ..first.clone() };
            parts.insert(0, below);
        }
        Self { parts, shaft }
    }

    /// Label of the tip (m).
    #[must_use]
    pub fn length(&self) -> f64 {
        self.parts.iter().map(|part| part.length).sum()
    }
}

/// A bundle as designed: plain data, unchecked. [`Bundle::new`] checks it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BundleDesign {
    /// Name, for people.
    pub name: String,
    /// From outside to inside.
    pub tubes: Vec<TubeParts>,
    /// Joints: tubes (index from 0) and the labels (m) at which they are bonded. A tip in no joint is free.
    pub joints: Vec<Vec<(usize, f64)>>,
}

impl From<&RobotDesign> for BundleDesign {
    /// A robot whose tubes have one length and are joined at the tip: each tube is one part.
    fn from(design: &RobotDesign) -> Self {
        let RobotDesign { name, length, tubes } = design;
        let whole = |body: &TubeDesign| {
            let part = Part { length: *length, body: body.clone(), rest_curvature: 0.0, rest_direction: 0.0 };
            TubeParts::new(vec![part], None)
        };
        // A tube alone is bonded to nothing.
        let joint: Vec<_> = (0..tubes.len()).map(|tube| (tube, *length)).collect();
        let joints = if joint.len() > 1 { vec![joint] } else { Vec::new() };
        Self { name: name.clone(), tubes: tubes.iter().map(whole).collect(), joints }
    }
}

impl BundleDesign {
    /// Has any part mass?
    #[must_use]
    pub fn has_mass(&self) -> bool {
        self.bodies().any(|body| match body {
            TubeDesign::Notched(t) => t.material.density > 0.0,
            TubeDesign::Stiffness(t) => t.mass_per_length.eval(0.0, 1.0)[0] > 0.0,
        })
    }

    /// Is the axial stiffness of every part known?
    #[must_use]
    pub fn has_axial_stiffness(&self) -> bool {
        !self.bodies().any(|body| matches!(body, TubeDesign::Stiffness(t) if t.axial.is_none()))
    }

    /// Least radial gap (m) between every tube and the one inside it, from outside to inside; `None` where a part of either is given by its
    /// stiffness.
    #[must_use]
    pub fn gaps(&self) -> Vec<Option<f64>> {
        let least = |pair: &[TubeParts]| {
            let each = pair[0].parts.iter().flat_map(|a| pair[1].parts.iter().map(|b| gap(&a.body, &b.body)));
            let all: Option<Vec<f64>> = each.collect();
            all.and_then(|gaps| gaps.into_iter().reduce(f64::min))
        };
        self.tubes.windows(2).map(least).collect()
    }

    /// The same robot with all of its metal on the curve along which it unloads (see [`Softening::unloading`](crate::design::Softening::unloading)); `None`
    /// where that of every part is the curve of loading. Between the equilibria of both lies the hysteresis of the metal.
    #[must_use]
    pub fn unloading(&self) -> Option<Self> {
        let mut lower = self.clone();
        let mut unloads = false;
        for part in lower.tubes.iter_mut().flat_map(|tube| &mut tube.parts) {
            if let TubeDesign::Notched(tube) = &mut part.body
                && let Some(unloading) = tube.material.softening.and_then(|own| own.unloading())
            {
                tube.material.softening = Some(unloading);
                unloads = true;
            }
        }
        unloads.then_some(lower)
    }

    fn bodies(&self) -> impl Iterator<Item = &TubeDesign> {
        self.tubes.iter().flat_map(|tube| &tube.parts).map(|part| &part.body)
    }
}

impl Bundle {
    /// Checks a design and fits its fields.
    ///
    /// # Errors
    /// All problems of the design that were found.
    pub fn new(design: &BundleDesign) -> Result<Self, DesignProblems> {
        let mut problems = Vec::new();
        let mut tubes = Vec::new();
        for (index, tube) in design.tubes.iter().enumerate() {
            match parts(index + 1, tube) {
                Ok(built) => tubes.push(built),
                Err(mut found) => problems.append(&mut found),
            }
        }
        if design.tubes.is_empty() {
            problems.push(DesignProblem::NoTube);
        }
        for (index, pair) in design.tubes.windows(2).enumerate() {
            let pairs = pair[0].parts.iter().flat_map(|a| pair[1].parts.iter().map(move |b| (a, b)));
            if let Some((reach, bore)) = pairs.into_iter().find_map(|(a, b)| misfit(&a.body, &b.body)) {
                problems.push(DesignProblem::TooWide { tube: index + 2, reach, bore });
            }
        }
        for (index, joint) in design.joints.iter().enumerate() {
            if let Some(problem) = joint_problem(joint, &design.tubes) {
                problems.push(DesignProblem::Joint { joint: index + 1, problem });
            }
        }
        if problems.is_empty() {
            Ok(Self::assemble(tubes, design.joints.clone()))
        } else {
            Err(DesignProblems(problems))
        }
    }

    /// The bundle of a robot whose tubes have one length and are joined at the tip.
    ///
    /// # Errors
    /// A section that cannot be built; a checked robot has none.
    pub fn from_robot(robot: &Robot) -> Result<Self, DesignProblems> {
        Self::new(&robot.design().into())
    }
}

/// What is wrong with a joint.
fn joint_problem(joint: &[(usize, f64)], tubes: &[TubeParts]) -> Option<JointProblem> {
    if joint.len() < 2 {
        return Some(JointProblem::TooFew);
    }
    joint.iter().enumerate().find_map(|(i, &(tube, label))| {
        let Some(parts) = tubes.get(tube) else { return Some(JointProblem::NoSuchTube(tube + 1)) };
        let length = parts.length();
        if joint[..i].iter().any(|other| other.0 == tube) {
            Some(JointProblem::Twice(tube + 1))
        } else if !(label > 0.0 && label <= length * (1.0 + 1e-9)) {
            Some(JointProblem::Outside { tube: tube + 1, label, length })
        } else {
            None
        }
    })
}

/// A part below the plate that is like the uniform one above makes one with it.
fn merge_uniform(pieces: &mut Vec<Piece>) {
    if pieces[0].continues(&pieces[1]) {
        pieces.remove(0);
    } else {
        pieces[0].jumps = !pieces[0].meets(&pieces[1]);
    }
}

fn parts(number: usize, tube: &TubeParts) -> Result<BundleTube, Vec<DesignProblem>> {
    let mut pieces: Vec<Piece> = Vec::new();
    let mut from = 0.0;
    for part in &tube.parts {
        let below = pieces.is_empty() && part.length.abs() <= 0.0;
        if !(part.length > 0.0 && part.length.is_finite() || below) {
            return Err(vec![DesignProblem::Length(part.length)]);
        }
        let rest = [part.rest_curvature, part.rest_direction];
        let own = body(number, &part.body, from, if below { 1.0 } else { part.length }, rest)?;
        if let (true, Some(first)) = (pieces.is_empty(), own.first()) {
            pieces.push(first.before(from));
        }
        if below {
            continue;
        }
        pieces.extend(own);
        from += part.length;
    }
    if pieces.len() < 2 {
        return Err(vec![DesignProblem::Length(0.0)]);
    }
    merge_uniform(&mut pieces);
    let radius = tube.parts.iter().map(|part| reach(&part.body)).fold(0.0, f64::max);
    let bore = tube.parts.iter().map(|part| bore(&part.body)).fold(radius, f64::min);
    Ok(BundleTube { pieces, tip: from, shaft: tube.shaft, radius, wall: radius - bore })
}

/// Outer radius of a body (m); 0 where it is not known.
fn reach(body: &TubeDesign) -> f64 {
    match body {
        TubeDesign::Notched(tube) => tube.outline.outer_reach(),
        TubeDesign::Stiffness(_) => 0.0,
    }
}

/// Inner radius of a body (m), beyond all others where it is not known.
fn bore(body: &TubeDesign) -> f64 {
    match body {
        TubeDesign::Notched(tube) => tube.outline.inner_clearance(),
        TubeDesign::Stiffness(_) => f64::INFINITY,
    }
}

/// Pieces of a body whose profiles run over `length` from label `from` on; `rest` is its curvature and direction when free.
fn body(
    number: usize,
    tube: &TubeDesign,
    from: f64,
    length: f64,
    rest: [f64; 2],
) -> Result<Vec<Piece>, Vec<DesignProblem>> {
    let failed: RefCell<Option<DesignProblem>> = RefCell::new(None);
    let [curvature, towards] = rest;
    let curved = |mut values: Values| {
        let (sin, cos) = (towards - values.direction).sin_cos();
        values.rest_curvature = [-curvature * sin, curvature * cos];
        values
    };
    let notched = match tube {
        TubeDesign::Notched(t) => Some(Notched::new(t, length)),
        TubeDesign::Stiffness(_) => None,
    };
    let field = |label: f64| {
        let x = label - from;
        match (tube, &notched) {
            (TubeDesign::Stiffness(t), _) => curved(given(t, x, length)),
            (_, Some(fields)) => match fields.at(x) {
                Ok(values) => curved(values),
                Err(error) => {
                    failed.borrow_mut().get_or_insert(DesignProblem::Section {
                        tube: number,
                        x: label,
                        error,
                    });
                    Values::default()
                }
            },
            (TubeDesign::Notched(_), None) => Values::default(),
        }
    };
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut start, kinks) = ((0.0, 0.0), kinks(tube, length));
    for end in steps(breaks(tube, length), length).into_iter().chain([(length, length)]) {
        // The fields of a piece are those between the flanks of the steps at its ends.
        let (from_middle, to_middle) = (0.5 * (start.0 + start.1), 0.5 * (end.0 + end.1));
        let inside = |label: f64| field(from + (label - from).clamp(start.1, end.0));
        let mut last = from_middle;
        let own = kinks.iter().copied().filter(|kink| start.1 < *kink && *kink < end.0);
        for until in own.chain([to_middle]) {
            pieces.extend(Piece::fit(from + last, from + until, length, &inside));
            last = until;
        }
        start = end;
    }
    if let Some(problem) = failed.into_inner() {
        return Err(vec![problem]);
    }
    check_fields(number, &pieces)?;
    if let TubeDesign::Notched(t) = tube
        && t.is_nonlinear()
    {
        let at = |error| vec![DesignProblem::Section { tube: number, x: from, error }];
        for piece in &mut pieces {
            if piece.uniform.is_none() {
                return Err(at(SectionError::Varying));
            }
            let [_, bend_y, bend_z, _, axial, ..] = piece.table_at(piece.to);
            piece.metal = Some(Arc::new(Metal::new(t, [axial, bend_y, bend_z]).map_err(at)?));
        }
    }
    for i in 1..pieces.len() {
        let smooth = pieces[i - 1].meets(&pieces[i]);
        pieces[i - 1].jumps = !smooth;
    }
    Ok(pieces)
}

/// Every field of every piece is finite and has its sign.
fn check_fields(number: usize, pieces: &[Piece]) -> Result<(), Vec<DesignProblem>> {
    for piece in pieces {
        for x in piece.samples() {
            let [offset, bend_y, bend_z, torsion, axial, mass, rest_y, rest_z] = piece.table_at(x);
            for (field, value, ok) in [
                ("the centroid offset", offset, offset >= -1e-12),
                ("the bending stiffness EI_Y", bend_y, bend_y > 0.0),
                ("the bending stiffness EI_Z", bend_z, bend_z > 0.0),
                ("the torsional stiffness", torsion, torsion > 0.0),
                ("the axial stiffness", axial, axial.is_nan() || axial > 0.0),
                ("the mass per length", mass, mass >= -1e-12),
                ("the rest curvature", rest_y + rest_z, (rest_y + rest_z).is_finite()),
                ("the direction", piece.direction(x)[0], piece.direction(x)[0].is_finite()),
            ] {
                if !ok || value.is_infinite() {
                    return Err(vec![DesignProblem::Field { tube: number, field, x, value }]);
                }
            }
        }
    }
    Ok(())
}

/// Places at which the fields are cut, each with the beginning and the end of its flank: two cuts that are very near make one step.
fn steps(cuts: Vec<f64>, length: f64) -> Vec<(f64, f64)> {
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for cut in cuts {
        match steps.last_mut() {
            Some(last) if cut - last.1 <= STEEP * length => last.1 = cut,
            _ => steps.push((cut, cut)),
        }
    }
    steps
}

/// Abscissae at which a derivative of some profile jumps.
fn breaks(tube: &TubeDesign, length: f64) -> Vec<f64> {
    let profiles: Vec<&Profile> = match tube {
        TubeDesign::Notched(t) => {
            let given = match &t.torsion {
                Torsion::Given(profile) => Some(profile),
                Torsion::SaintVenant | Torsion::Polar => None,
            };
            [&t.depth, &t.direction].into_iter().chain(given).collect()
        }
        TubeDesign::Stiffness(t) => {
            let StiffnessTube {
                centroid_offset,
                direction,
                bending_y,
                bending_z,
                torsion,
                axial,
                mass_per_length,
                centroid_offset_factor: _,
            } = t;
            [centroid_offset, direction, bending_y, bending_z, torsion, mass_per_length]
                .into_iter()
                .chain(axial)
                .collect()
        }
    };
    let mut cuts: Vec<f64> = profiles.iter().flat_map(|p| p.breaks(length)).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup_by(|b, a| *b - *a <= 1e-9 * length);
    cuts
}

/// Abscissae at which the notch of a tube comes to open its ring, or passes its bore: there the properties of the section have a kink.
fn kinks(tube: &TubeDesign, length: f64) -> Vec<f64> {
    let TubeDesign::Notched(tube) = tube else { return Vec::new() };
    let depths = [tube.outline.opening_depth(), tube.outline.passing_depth()];
    let mut kinks: Vec<f64> = depths.iter().flat_map(|depth| tube.depth.passes(*depth, length)).collect();
    kinks.sort_unstable_by(f64::total_cmp);
    kinks.dedup_by(|b, a| *b - *a <= 1e-9 * length);
    kinks
}

fn given(tube: &StiffnessTube, x: f64, length: f64) -> Values {
    let value = |profile: &Profile| profile.eval(x, length)[0];
    Values {
        centroid_offset: tube.centroid_offset_factor * value(&tube.centroid_offset),
        bending_y: value(&tube.bending_y),
        bending_z: value(&tube.bending_z),
        torsion: value(&tube.torsion),
        axial: tube.axial.as_ref().map_or(f64::NAN, value),
        mass_per_length: value(&tube.mass_per_length),
        rest_curvature: [0.0; 2],
        direction: value(&tube.direction),
    }
}

/// Least and greatest depth (m) and samples of the torsion constant between them.
type Range = (f64, f64, Vec<(f64, f64)>);

/// Fields of a notched tube. Its torsion constant costs a boundary-value problem each, and is interpolated over depth.
struct Notched<'a> {
    tube: &'a NotchedTube,
    length: f64,
    /// Least and greatest depth.
    depths: [f64; 2],
    /// Chebyshev samples of the constant on the ranges of depth on which it is smooth.
    constants: RefCell<Vec<Range>>,
}

impl<'a> Notched<'a> {
    fn new(tube: &'a NotchedTube, length: f64) -> Self {
        // A cubic stays within its ends and stationary points, which this many samples of every cell find well enough: beyond them,
        // single depths are solved for.
        let samples =
            (0..=SAMPLES).map(|i| tube.depth.eval(length * f64::from(i) / f64::from(SAMPLES), length)[0]);
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for depth in samples {
            (least, greatest) = (least.min(depth), greatest.max(depth));
        }
        Self { tube, length, depths: [least, greatest], constants: RefCell::new(Vec::new()) }
    }

    fn at(&self, x: f64) -> Result<Values, SectionError> {
        let depth = self.tube.depth.eval(x, self.length)[0];
        let direction = self.tube.direction.eval(x, self.length)[0];
        let torsion = match &self.tube.torsion {
            Torsion::Given(profile) => Some(profile.eval(x, self.length)[0]),
            Torsion::SaintVenant | Torsion::Polar => None,
        };
        Ok(Values { direction, ..self.at_depth(depth, torsion)? })
    }

    fn at_depth(&self, depth: f64, torsion: Option<f64>) -> Result<Values, SectionError> {
        let NotchedTube { outline, material, .. } = self.tube;
        let inertia = outline.inertia(depth)?;
        let cell = self.tube.cell_factors(depth).map_err(SectionError::Cells)?;
        let by = |factor: fn(&CellFactors) -> f64| cell.as_ref().map_or(1.0, factor);
        let e = material.youngs_modulus;
        let g = material.shear_modulus();
        let torsion = match (torsion, &self.tube.torsion) {
            (Some(given), _) => given,
            (None, Torsion::Polar) if depth > 0.0 => g * inertia.polar_about_centre,
            _ => g * self.constant(outline, depth)? * by(|c| c.torsion),
        };
        Ok(Values {
            centroid_offset: self.tube.centroid_offset_factor
                * inertia.centroid_offset
                * by(|c| c.centroid_offset),
            bending_y: e * inertia.inertia_y * by(|c| c.bending_y),
            bending_z: e * inertia.inertia_z * by(|c| c.bending_z),
            torsion,
            axial: e * inertia.area * by(|c| c.axial),
            mass_per_length: material.density * inertia.area * by(|c| c.mass),
            rest_curvature: [0.0; 2],
            direction: 0.0,
        })
    }

    /// Saint-Venant constant (m⁴). It has kinks where the notch opens the ring and where it passes the bore, and falls like
    /// a square root before the first of them, where every depth is solved for.
    fn constant(&self, outline: &Outline, depth: f64) -> Result<f64, SectionError> {
        let solve = |depth: f64| outline.notched(depth).map(|s| s.torsion_constant);
        let mut known = self.constants.borrow_mut();
        if let Some(range) = known.iter().find(|range| range.0 <= depth && depth <= range.1) {
            return Ok(barycentric(&range.2, depth));
        }
        let (opening, passing) = (outline.opening_depth(), outline.passing_depth());
        let near = NEAR * opening;
        let [least, greatest] = self.depths;
        let ends = [least, opening - near, opening + near, passing, greatest];
        let (mut from, mut to) = (least, greatest);
        for end in ends {
            if end <= depth {
                from = from.max(end);
            }
            if end >= depth {
                to = to.min(end);
            }
        }
        let single = to - from <= 1e-12 || from >= opening - near && to <= opening + near;
        let range = if single || depth < least || depth > greatest {
            (depth, depth, vec![(depth, solve(depth)?)])
        } else {
            (from, to, chebyshev(from, to, &solve)?)
        };
        let value = barycentric(&range.2, depth);
        known.push(range);
        Ok(value)
    }
}

/// A flank narrower than this part of the length is a step.
const STEEP: f64 = 5e-4;
/// Samples in which the range of depths is sought.
const SAMPLES: u16 = 4096;
/// Part of the wall on both sides of the depth at which the ring opens that is not interpolated.
const NEAR: f64 = 0.1;
