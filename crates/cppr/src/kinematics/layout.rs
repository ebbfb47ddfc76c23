//! The Ritz coordinates: which unknown belongs to which field on which element.
//!
//! The robot's labels X ∈ [0, L] are cut into elements at joints. On every element each strain field
//! (ΔK_X, ΔK_Y, ΔK_Z, Δθ_k', e_i) is a sum of shifted Legendre polynomials of the element's own coordinate.
//! A joint is fixed (base, tip, the point of a concentrated load) or an **edge**: the section where the
//! pattern of a follower begins, x_k(X) = 0. Stiffness and offset jump there, so the joint moves with
//! the robot; its label is one more unknown and x_k = 0 one more condition.
//!
//! Unknowns are numbered edges first, then what moves the leader (ΔK and e_1 of all elements), then the followers'
//! fields: poses depend on the first part alone.

use super::follower::local;
use super::rule::{Rule, legendre_values};
use super::state::row;
use crate::real::Real;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The fields of an element in the order of [`Element::modes`]: the leader's ΔK_X, ΔK_Y, ΔK_Z under their numbers in `local`, then
/// Δθ_k' of every follower, then e_i of every tube.
pub(crate) mod field {
    /// How many curvatures the leader has.
    pub const CURVATURES: usize = 3;

    /// Δθ_k' of a follower; 0 is the first.
    pub fn angle(follower: usize) -> usize {
        CURVATURES + follower
    }

    /// e_i of a tube; 0 is the leader.
    pub fn stretch(followers: usize, tube: usize) -> usize {
        CURVATURES + followers + tube
    }
}

/// How finely the fields are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Resolution {
    /// Modes of ΔK_X; 0 leaves the leader untwisted.
    pub twist: usize,
    /// Modes of ΔK_Y; 0 leaves the bundle in its bending plane.
    pub bending_y: usize,
    /// Modes of ΔK_Z.
    pub bending_z: usize,
    /// Modes of each follower's Δθ_k' (so that Δθ_k has as many modes vanishing at the tip); 0 locks the angles.
    pub angle: usize,
    /// Modes of each tube's stretch e_i; 0, the default, is inextensible.
    pub stretch: usize,
    /// Quadrature and collocation nodes on the element.
    pub nodes: usize,
}

impl Resolution {
    /// Within 1e-4 L of the converged tip for every robot shipped, loaded or not.
    pub const SPATIAL: Self = Self { twist: 6, bending_y: 8, bending_z: 8, angle: 6, stretch: 0, nodes: 14 };

    /// The modes that the paper takes in space, 3 + 3 + 3 + 2: a third of the unknowns of [`Self::SPATIAL`]. How far off
    /// the tip is depends on robot and load.
    pub const PAPER: Self = Self { twist: 3, bending_y: 3, bending_z: 3, angle: 2, stretch: 0, nodes: 6 };

    /// Five modes of K_Z, as the paper uses in the plane: nothing can leave the plane.
    pub const PLANAR: Self = Self { twist: 0, bending_y: 0, bending_z: 5, angle: 0, stretch: 0, nodes: 8 };

    /// The most by which [`Resolution::refined`] may multiply where people choose.
    pub const FINEST_REFINEMENT: usize = 8;

    /// With stretch resolved as finely as the bending in the plane.
    #[must_use]
    pub fn with_stretch(self) -> Self {
        Self { stretch: self.bending_z, ..self }
    }

    /// Modes and nodes multiplied, for convergence studies.
    #[must_use]
    pub fn refined(self, factor: usize) -> Self {
        Self {
            twist: self.twist * factor,
            bending_y: self.bending_y * factor,
            bending_z: self.bending_z * factor,
            angle: self.angle * factor,
            stretch: self.stretch * factor,
            nodes: self.nodes * factor,
        }
    }

    /// Modes and nodes in eighths of these, rounded up: for loops that need no more.
    pub(crate) fn eighths(self, eighths: usize) -> Self {
        let part = |count: usize| (count * eighths).div_ceil(8);
        Self {
            twist: part(self.twist),
            bending_y: part(self.bending_y),
            bending_z: part(self.bending_z),
            angle: part(self.angle),
            stretch: part(self.stretch),
            nodes: part(self.nodes),
        }
    }

    /// Modes and nodes multiplied by a whole number from 1 to [`Self::FINEST_REFINEMENT`], or by 3/8, 1/2 or 3/4 and rounded up, as
    /// [`crate::solve::Solver::fewest_modes`] tries them; `None` for any other factor.
    #[must_use]
    pub fn multiplied(self, factor: f64) -> Option<Self> {
        Self::factors().find(|own| (own.1 - factor).abs() <= 0.0).map(|own| self.eighths(own.0))
    }

    /// The factor with which [`Self::multiplied`] makes this of another; `None` where there is none.
    #[must_use]
    pub fn multiple_of(self, other: Self) -> Option<f64> {
        Self::factors().find(|own| other.eighths(own.0) == self).map(|own| own.1)
    }

    /// Those of [`Self::multiplied`], in eighths as well.
    fn factors() -> impl Iterator<Item = (usize, f64)> {
        let eighths = [3, 4, 6].into_iter().chain((1..=Self::FINEST_REFINEMENT).map(|own| 8 * own));
        eighths.map(|own| (own, 0.125 * own as f64))
    }

    /// The resolution of an element that takes only a small part of the length.
    fn short(self) -> Self {
        let few = |modes: usize| modes.div_ceil(2);
        Self {
            twist: few(self.twist),
            bending_y: few(self.bending_y),
            bending_z: few(self.bending_z),
            angle: few(self.angle),
            stretch: few(self.stretch),
            nodes: few(self.nodes).max(4),
        }
    }
}

/// Where an element begins or ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Joint {
    /// A fixed label X (m).
    Fixed(f64),
    /// The edge of follower `follower` (tube index, 1 is the first follower), unknown number `unknown`.
    Edge {
        /// Tube index of the follower.
        follower: usize,
        /// Index among the unknowns.
        unknown: usize,
    },
}

/// A local variable that unknowns move, and the range outside which none does.
#[derive(Clone, Debug)]
pub(crate) struct Active {
    /// Which of a follower's local variables it is, and its row at a node.
    pub variable: usize,
    pub row: usize,
    pub unknowns: Range<usize>,
}

/// One element and the places of its unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub start: Joint,
    pub end: Joint,
    /// Which rule: 0 for long elements, 1 for short ones.
    pub rule: usize,
    /// Index of the first node among all nodes.
    pub first_node: usize,
    /// Per tube: does the part from below the plate face this element?
    pub below: Vec<bool>,
    /// Per follower: its local variables that depend on any unknown; the others are skipped. A robot without followers has
    /// one list, of its leader's.
    pub active: Vec<Vec<Active>>,
    /// Which of a follower's local variables they are.
    pub variables: Vec<usize>,
    /// The unknowns of ΔK_X, ΔK_Y, ΔK_Z on this element: with the edges, what turns its steps.
    pub turning: Range<usize>,
    /// Per field (ΔK_X, ΔK_Y, ΔK_Z, then per follower Δθ_k', then per tube e_i): first unknown and count.
    pub modes: Vec<(usize, usize)>,
}

/// Elements, unknowns and rules.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub tubes: usize,
    pub stretch: bool,
    pub elements: Vec<Element>,
    pub rules: [Rule; 2],
    /// Unknowns in all.
    unknowns: usize,
    /// Followers whose edge is inside, in the order of their unknowns.
    pub edges: Vec<usize>,
    /// How many unknowns, from the first on, move the leader.
    pub leader_unknowns: usize,
    /// Nodes in all.
    pub nodes: usize,
    /// Serial number: no other layout has it.
    pub serial: u64,
    length: f64,
    resolution: Resolution,
    cuts: Vec<Cut>,
}

/// An end of an element: at a fixed label, or near an estimated one where an edge is.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cut {
    at: f64,
    /// Tube index of the follower whose edge it is.
    follower: Option<usize>,
    /// Is the element that begins here short?
    short: bool,
}

impl Cut {
    pub fn fixed(at: f64) -> Self {
        Self { at, follower: None, short: false }
    }

    pub fn edge(follower: usize, estimate: f64) -> Self {
        Self { at: estimate, follower: Some(follower), short: false }
    }

    /// Do both make the same layout? Edges do wherever they are.
    fn same(&self, other: &Self) -> bool {
        self.follower == other.follower
            && self.short == other.short
            && (self.follower.is_some() || (self.at - other.at).abs() <= 0.0)
    }
}

/// Serial number of the layout made next.
static NEXT_SERIAL: AtomicU64 = AtomicU64::new(1);

/// Elements shorter than this part of the length take fewer modes.
const SHORT: f64 = 0.25;
/// Layouts that are remembered; a sweep over pushes and pulls of three tubes needs a dozen.
const REMEMBERED: usize = 16;

/// The layouts used last: making one costs more than a solve on it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layouts {
    list: Vec<Arc<Layout>>,
    cuts: Vec<Cut>,
}

impl Element {
    /// The unknowns of ΔK_Z.
    pub fn bends_z(&self) -> Range<usize> {
        let (first, count) = self.modes[local::KZ];
        first..first + count
    }

    /// Which of the leader's curvatures (0 to 2) and which of its modes stands in place `i` of `turning`.
    #[inline]
    pub fn turned(&self, i: usize) -> (usize, usize) {
        let twist = self.modes[local::KX].1;
        let bending = twist + self.modes[local::KY].1;
        match i {
            i if i < twist => (local::KX, i),
            i if i < bending => (local::KY, i - twist),
            i => (local::KZ, i - bending),
        }
    }
}

impl Layouts {
    /// The layout of [0, L] cut at the given places.
    pub fn get(
        &mut self,
        tubes: usize,
        length: f64,
        resolution: Resolution,
        cuts: impl Iterator<Item = Cut>,
    ) -> Arc<Layout> {
        self.cuts.clear();
        self.cuts.extend(cuts.filter(|c| c.follower.is_some() || (c.at > 0.0 && c.at < length)));
        self.cuts.extend([Cut::fixed(0.0), Cut::fixed(length)]);
        self.cuts.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
        self.cuts.dedup_by(|b, a| {
            a.follower.is_none() && b.follower.is_none() && (b.at - a.at).abs() <= 1e-12 * length
        });
        for i in 1..self.cuts.len() {
            self.cuts[i - 1].short = self.cuts[i].at - self.cuts[i - 1].at < SHORT * length;
        }
        let same = |layout: &&Arc<Layout>| {
            layout.tubes == tubes
                && (layout.length - length).abs() <= 0.0
                && layout.resolution == resolution
                && layout.cuts.len() == self.cuts.len()
                && layout.cuts.iter().zip(&self.cuts).all(|(a, b)| a.same(b))
        };
        if let Some(layout) = self.list.iter().find(same) {
            return Arc::clone(layout);
        }
        let layout = Arc::new(Layout::new(tubes, length, resolution, &self.cuts));
        if self.list.len() == REMEMBERED {
            self.list.remove(0);
        }
        self.list.push(Arc::clone(&layout));
        layout
    }
}

impl Layout {
    /// What it was cut at: enough to make it again.
    #[cfg(feature = "serde")]
    pub fn cuts(&self) -> &[Cut] {
        &self.cuts
    }

    fn new(tubes: usize, length: f64, resolution: Resolution, cuts: &[Cut]) -> Self {
        let stretch = resolution.stretch > 0;
        let rules = [Rule::new(resolution.nodes), Rule::new(resolution.short().nodes)];
        let mut layout = Self {
            tubes,
            stretch,
            elements: Vec::new(),
            rules,
            unknowns: 0,
            edges: Vec::new(),
            leader_unknowns: 0,
            nodes: 0,
            serial: NEXT_SERIAL.fetch_add(1, Ordering::Relaxed),
            length,
            resolution,
            cuts: cuts.to_vec(),
        };
        let mut below: Vec<bool> = (0..tubes).map(|t| cuts.iter().any(|c| c.follower == Some(t))).collect();
        for pair in cuts.windows(2) {
            if let Some(follower) = pair[0].follower {
                below[follower] = false;
            }
            let ends = [pair[0], pair[1]].map(|c| (c.at, c.follower));
            layout.push(ends[0], ends[1], below.clone(), resolution, pair[0].short);
        }
        layout.number_unknowns();
        layout.find_active();
        layout
    }

    /// Steps of an element are turned by its own ΔK, angles are moved by the modes of elements towards the tip too, faces
    /// by everything there; edges may move all.
    fn find_active(&mut self) {
        let (followers, stretch) = (self.tubes - 1, self.stretch);
        let (unknowns, edges) = (self.unknowns(), self.edges.len());
        let angles = self
            .elements
            .iter()
            .any(|e| e.modes[field::angle(0)..field::angle(followers)].iter().any(|m| m.1 > 0));
        for element in &mut self.elements {
            let own = |number: usize| {
                let (first, count) = element.modes[number];
                if edges > 0 { 0..first + count } else { first..first + count }
            };
            let leader = |number: usize| (element.modes[number].1 > 0 || edges > 0).then(|| own(number));
            let after = if edges > 0 { 0 } else { element.modes.get(field::angle(0)).map_or(0, |m| m.0) };
            let active = |variable: usize, follower: usize| {
                let unknowns = match variable {
                    local::KX | local::KY | local::KZ => leader(variable)?,
                    local::E1 => stretch.then(|| own(field::stretch(followers, 0)))?,
                    local::X => (edges > 0).then_some(0..edges)?,
                    local::TH => (angles || edges > 0).then_some(after..unknowns)?,
                    local::DTH => (angles || edges > 0).then(|| own(field::angle(follower)))?,
                    local::FACE => 0..unknowns,
                    _ => stretch.then(|| own(field::stretch(followers, follower + 1)))?,
                };
                Some(Active { variable, row: row(follower, variable), unknowns })
            };
            let count = if followers > 0 { local::COUNT } else { local::TH };
            element.active = (0..followers.max(1))
                .map(|follower| (0..count).filter_map(|variable| active(variable, follower)).collect())
                .collect();
            element.variables = element.active[0].iter().map(|a| a.variable).collect();
            element.turning = element.modes[local::KX].0..element.bends_z().end;
        }
    }

    fn push(
        &mut self,
        start: (f64, Option<usize>),
        end: (f64, Option<usize>),
        below: Vec<bool>,
        resolution: Resolution,
        short: bool,
    ) {
        let r = if short { resolution.short() } else { resolution };
        let mut counts = vec![r.twist, r.bending_y, r.bending_z];
        counts.extend(std::iter::repeat_n(r.angle, self.tubes - 1));
        counts.extend(std::iter::repeat_n(r.stretch, self.tubes));
        let rule = usize::from(short);
        let modes = counts.into_iter().map(|count| (0, count.min(self.rules[rule].n))).collect();
        let joint = |(x, follower): (f64, Option<usize>)| match follower {
            None => Joint::Fixed(x),
            Some(follower) => Joint::Edge { follower, unknown: 0 },
        };
        let (start, end) = (joint(start), joint(end));
        self.elements.push(Element {
            start,
            end,
            rule,
            first_node: self.nodes,
            below,
            active: Vec::new(),
            variables: Vec::new(),
            turning: 0..0,
            modes,
        });
        self.nodes += self.rules[rule].n;
    }

    fn number_unknowns(&mut self) {
        let Self { elements, edges, tubes, .. } = self;
        for element in elements.iter_mut() {
            for joint in [&mut element.start, &mut element.end] {
                if let Joint::Edge { follower, unknown } = joint {
                    *unknown = edges.iter().position(|f| f == follower).unwrap_or_else(|| {
                        edges.push(*follower);
                        edges.len() - 1
                    });
                }
            }
        }
        let mut next = edges.len();
        let followers = *tubes - 1;
        let leader = |number: usize| number < field::CURVATURES || number == field::stretch(followers, 0);
        for of_leader in [true, false] {
            for element in elements.iter_mut() {
                for (number, modes) in element.modes.iter_mut().enumerate() {
                    if leader(number) == of_leader {
                        modes.0 = next;
                        next += modes.1;
                    }
                }
            }
            if of_leader {
                self.leader_unknowns = next;
            }
        }
        self.unknowns = next;
    }

    /// Unknown configuration coordinates: modes and edges.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Rows of local variables at a node: K_X, K_Y, K_Z, e_1, X, then θ_k, θ_k', x_k, e_k of every follower.
    pub fn rows(&self) -> usize {
        local::SHARED + local::OWN * (self.tubes - 1)
    }

    /// Label of a joint (m) and, for an edge, its unknown.
    #[inline]
    pub fn label<S: Real>(joint: Joint, coordinates: &[S]) -> (S, Option<usize>) {
        match joint {
            Joint::Fixed(x) => (S::splat(x), None),
            Joint::Edge { unknown, .. } => (coordinates[unknown], Some(unknown)),
        }
    }

    /// The element that holds label X, and the coordinate ξ there.
    pub fn locate(&self, coordinates: &[f64], label: f64) -> (usize, f64) {
        let last = self.elements.len() - 1;
        for (e, element) in self.elements.iter().enumerate() {
            let (a, _) = Self::label(element.start, coordinates);
            let (b, _) = Self::label(element.end, coordinates);
            if label < b || e == last {
                return (e, ((label - a) / (b - a)).clamp(0.0, 1.0));
            }
        }
        (last, 1.0)
    }

    /// Puts the fields into another layout of the same robot: the best approximation, element by element. The
    /// places of the target's edges are given in `result`. Fields jump at edges, and move with them: labels in between are
    /// stretched.
    pub fn transfer(&self, coordinates: &[f64], target: &Self, result: &mut [f64]) {
        if coordinates.iter().all(|&c| c == 0.0) {
            return;
        }
        let mut values = vec![0.0; target.rules[0].n];
        let mut anchors = vec![(0.0, 0.0), (self.length, self.length)];
        for (i, follower) in target.edges.iter().enumerate() {
            if let Some(own) = self.edges.iter().position(|f| f == follower) {
                anchors.push((result[i], coordinates[own]));
            }
        }
        anchors.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let stretched = |label: f64| {
            let next = anchors.partition_point(|a| a.0 < label).clamp(1, anchors.len() - 1);
            let [(from, to), (after, beyond)] = [anchors[next - 1], anchors[next]];
            if after > from { to + (label - from) / (after - from) * (beyond - to) } else { to }
        };
        for element in &target.elements {
            let rule = &target.rules[element.rule];
            let (a, _) = Self::label(element.start, result);
            let (b, _) = Self::label(element.end, result);
            for (i, (&x, &weight)) in rule.nodes.iter().zip(&rule.weights).enumerate() {
                let (e, local) = self.locate(coordinates, stretched(a + x * (b - a)));
                for (field, &(first, count)) in element.modes.iter().enumerate() {
                    let value = self.field(coordinates, e, local, field, &mut values);
                    for m in 0..count {
                        result[first + m] +=
                            (2 * m + 1) as f64 * weight * rule.legendre[i * rule.n + m] * value;
                    }
                }
            }
        }
    }

    /// Value of a field of an element at ξ; `buffer` is scratch.
    pub fn field(
        &self,
        coordinates: &[f64],
        element: usize,
        x: f64,
        field: usize,
        buffer: &mut Vec<f64>,
    ) -> f64 {
        let (first, count) = self.elements[element].modes[field];
        buffer.resize(count, 0.0);
        legendre_values(x, &mut buffer[..count]);
        buffer[..count].iter().zip(&coordinates[first..first + count]).map(|(p, c)| p * c).sum()
    }
}
