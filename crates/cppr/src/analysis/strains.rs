//! Curvatures κ_Y, κ_Z (1/m, about the axes of the section itself), stretch e and rate of twist Δτ (rad/m) of one tube by its rest
//! abscissa (m), from an evaluated state, in all lanes alike.
//!
//! The section's own Y points to its centroid. Those of the leader are K_Y, K_Z and e_1. A follower's own axes are turned by π about X
//! from those in which `kinematics::follower` has its curvatures: with p, r and |h| from there
//!
//!   κ_Y = −p/|h|     κ_Z = −r/|h|     dx_k/dX = |h| .
//!
//! Between the nodes of an element all are interpolated by the polynomial through them, kept by its Legendre modes; the label
//! X that a rest abscissa faces is found by Newton's method on x_k(X).

use crate::kinematics::follower::local;
use crate::kinematics::layout::Layout;
use crate::kinematics::rule::legendre_values;
use crate::kinematics::state::State;
use crate::real::{Real, every};

/// κ_Y, κ_Z, e, Δτ + φ', x_k and |h_k| of a node or mode.
type Values<S> = [S; 6];
const FACE: usize = 4;
const RATE: usize = 5;

/// Newton's method on x_k(ξ) stops at steps of ξ below this.
const SETTLED: f64 = 1e-12;

pub(super) struct Strains<'a, S: Real> {
    state: &'a State<S>,
    layout: &'a Layout,
    coordinates: &'a [S],
    tube: usize,
    /// As many modes per element as it has nodes, in the places of these.
    modes: Vec<Values<S>>,
}

impl<'a, S: Real> Strains<'a, S> {
    pub fn new(state: &'a State<S>, layout: &'a Layout, coordinates: &'a [S], tube: usize) -> Self {
        let mut strains = Self { state, layout, coordinates, tube, modes: Vec::with_capacity(layout.nodes) };
        for element in &layout.elements {
            let rule = &layout.rules[element.rule];
            let nodes: Vec<Values<S>> = (0..rule.n).map(|i| strains.node(element.first_node + i)).collect();
            for m in 0..rule.n {
                let mut mode = [S::zero(); 6];
                for (j, node) in nodes.iter().enumerate() {
                    let share = (2 * m + 1) as f64 * rule.weights[j] * rule.legendre[j * rule.n + m];
                    mode.iter_mut().zip(node).for_each(|(sum, value)| *sum += *value * share);
                }
                strains.modes.push(mode);
            }
        }
        strains
    }

    /// At a node, in the section's own axes.
    fn node(&self, node: usize) -> Values<S> {
        let (layout, state) = (self.layout, self.state);
        let Some(f) = self.tube.checked_sub(1) else {
            let own = &state.local[node * layout.rows()..];
            let [turn, y, z] = [own[local::KX], own[local::KY], own[local::KZ]];
            return [y, z, own[local::E1], turn, own[local::X], S::one()];
        };
        let facing = &state.facing[node * (layout.tubes - 1) + f];
        let own = state.variables(node, f);
        let per_length = |value: S| value / facing.h;
        let [y, z, turn] = [-facing.p, -facing.r, facing.a].map(per_length);
        [y, z, own[local::EK], turn, own[local::FACE], facing.h]
    }

    /// Rest abscissae at the ends of an element (m).
    fn ends(&self, e: usize) -> [S; 2] {
        let Some(f) = self.tube.checked_sub(1) else {
            let element = &self.layout.elements[e];
            return [element.start, element.end].map(|j| Layout::label(j, self.coordinates).0);
        };
        [e, e + 1].map(|joint| self.state.joints[joint * (self.layout.tubes - 1) + f][0])
    }

    /// Rest abscissa at the baseplate (m).
    pub fn base(&self) -> S {
        self.ends(0)[0]
    }

    /// Label X that a rest abscissa faces (m), and κ_Y, κ_Z, e and Δτ + φ' there; what stands in lanes other than `lanes` means nothing.
    /// The curvature jumps where the uncut part ends; `uncut` tells the sides apart.
    pub fn at(&self, abscissa: S, uncut: bool, lanes: u64) -> (S, [S; 4]) {
        let last = self.layout.elements.len() - 1;
        let mut left = lanes;
        let (mut label, mut values) = (S::zero(), [S::zero(); 4]);
        for e in 0..=last {
            let all = e == last || (uncut && !self.layout.elements[e + 1].below[self.tube]);
            let here = if all { left } else { left & (abscissa - self.ends(e)[1]).mask(|d| d < 0.0) };
            if here != 0 {
                let (own_label, own) = self.within(e, abscissa);
                label = own_label.in_lanes(here, label);
                values.iter_mut().zip(own).for_each(|(value, own)| *value = own.in_lanes(here, *value));
            }
            left &= !here;
        }
        (label, values)
    }

    fn within(&self, e: usize, abscissa: S) -> (S, [S; 4]) {
        let element = &self.layout.elements[e];
        let modes = &self.modes[element.first_node..element.first_node + self.layout.rules[element.rule].n];
        let [from, to] = self.ends(e);
        let inside = |x: S| x.map(|x| x.clamp(0.0, 1.0));
        let mut x = inside((abscissa - from) / (to - from));
        let mut polynomials = vec![S::zero(); modes.len()];
        legendre_values(x, &mut polynomials);
        let sum = |polynomials: &[S], which: usize| {
            polynomials.iter().zip(modes).fold(S::zero(), |sum, (p, mode)| sum.plus(*p, mode[which]))
        };
        let length = self.state.lengths[e];
        if self.tube > 0 {
            // x_k(ξ) is smooth and nearly linear: Newton's method settles in two or three turns.
            let mut moving = every::<S>();
            for _ in 0..10 {
                let step = (abscissa - sum(&polynomials, FACE)) / (sum(&polynomials, RATE) * length);
                x = inside(x + step).in_lanes(moving, x);
                legendre_values(x, &mut polynomials);
                moving &= step.unless(|s| s.abs() < SETTLED);
                if moving == 0 {
                    break;
                }
            }
        }
        let start = Layout::label(element.start, self.coordinates).0;
        (start + x * length, [0, 1, 2, 3].map(|which| sum(&polynomials, which)))
    }
}
