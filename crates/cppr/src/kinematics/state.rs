//! The bundle at given coordinates: strains, angles and face-to-face functions at every node, and their
//! exact derivatives with respect to the coordinates.
//!
//! Follower angle and face-to-face function are integrals from the tip, where the tubes are joined:
//! Δθ_k(X) = −∫_X^L Δθ_k' dX and x_k(X) = L − ∫_X^L |h_k| dX. The second is implicit, since |h_k| holds
//! D_k(x_k); its fixed point contracts by ∫|D_k' K| dX, a few thousandths.

use super::follower::{Facing, Row, local};
use super::layout::{Element, Layout, field};
use crate::dense::{Lu, axpy, axpy_table, dot_table};
use crate::design::Robot;
use crate::design::fields::{Jet, Part};
use crate::real::{Real, every};

/// The coordinates describe no bundle: a tube would have to pass through itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Infeasible;

/// Of which robot and layout something is kept: their serial numbers, 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Origin {
    robot: u64,
    layout: u64,
}

impl Origin {
    pub fn of(robot: &Robot, layout: &Layout) -> Self {
        Self { robot: robot.serial(), layout: layout.serial }
    }
}

/// Everything about the bundle at the nodes. Buffers are reused from one evaluation to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct State<S = f64> {
    /// Unknowns n_u of the layout it was last evaluated for.
    pub unknowns: usize,
    rows: usize,
    followers: usize,
    /// Per element: length ℓ (m).
    pub lengths: Vec<S>,
    /// Per node and row: the local variables.
    pub local: Vec<S>,
    /// Per node: D_1 with derivatives.
    pub leader_offset: Vec<Jet<S>>,
    /// Per node: φ_1 of the leader's pattern, first to third derivative.
    leader_turn: Vec<[S; 3]>,
    /// Per node and follower: θ_k at rest and its first three derivatives.
    pub rest: Vec<[S; 4]>,
    /// Per node and follower.
    pub facing: Vec<Facing<S>>,
    /// Per element and follower, at the element's start: x_k and Δθ_k; one more entry for the tip.
    pub joints: Vec<[S; 2]>,
    /// Per element: dℓ/du.
    pub length_rows: Vec<S>,
    /// Per node and row: derivatives of the local variables, rows of length n_u.
    pub z: Vec<S>,
    /// Per element (and tip) and follower: dx_k/du and dΔθ_k/du at the start.
    pub joint_rows: Vec<S>,
    collocation: Vec<S>,
    rates: Vec<S>,
    nodal: Vec<S>,
    matrix: Vec<S>,
    lu: Lu<S>,
    /// Of what the last values and rows are: what depends on robot and layout alone stays.
    values_of: Origin,
    rows_of: Origin,
    /// Lanes that describe no bundle.
    broken: u64,
}

/// |h| below this is no bundle any more: the follower would be crushed to nothing.
const LEAST_RATE: f64 = 0.02;
/// Turns of the fixed point of x_k.
const TURNS: usize = 60;

/// Which part of a tube faces an element.
pub(crate) fn part(element: &Element, tube: usize) -> Part {
    if element.below[tube] { Part::Below } else { Part::Pattern }
}

impl<S: Real> State<S> {
    fn resize(&mut self, layout: &Layout) {
        let (nodes, elements) = (layout.nodes, layout.elements.len());
        self.unknowns = layout.unknowns();
        self.rows = layout.rows();
        self.followers = layout.tubes - 1;
        self.rows_of = Origin::default();
        self.lengths.resize(elements, S::zero());
        self.local.clear();
        self.local.resize(nodes * self.rows, S::zero());
        self.leader_offset.resize(nodes, [S::zero(); 3]);
        self.leader_turn.resize(nodes, [S::zero(); 3]);
        self.rest.resize(nodes * self.followers, [S::zero(); 4]);
        self.facing.resize(nodes * self.followers, Facing::default());
        self.joints.resize((elements + 1) * self.followers, [S::zero(); 2]);
        for (rows, count) in [
            (&mut self.length_rows, elements),
            (&mut self.z, nodes * self.rows),
            (&mut self.joint_rows, (elements + 1) * self.followers * 2),
        ] {
            rows.clear();
            rows.resize(count * self.unknowns, S::zero());
        }
    }

    /// The local variables of one follower at one node.
    #[inline]
    pub fn variables(&self, node: usize, follower: usize) -> Row<S> {
        let base = node * self.rows;
        let own = base + row(follower, local::TH);
        let mut v = [S::zero(); local::COUNT];
        let (shared, following) = v.split_at_mut(local::SHARED);
        shared.copy_from_slice(&self.local[base..base + local::SHARED]);
        following.copy_from_slice(&self.local[own..own + local::OWN]);
        v
    }

    /// Derivatives of one local variable at a node.
    #[inline]
    pub fn z_row(&self, node: usize, row: usize) -> &[S] {
        let start = (node * self.rows + row) * self.unknowns;
        &self.z[start..start + self.unknowns]
    }

    /// dℓ/du of an element.
    #[inline]
    pub fn length_row(&self, e: usize) -> &[S] {
        &self.length_rows[e * self.unknowns..(e + 1) * self.unknowns]
    }

    /// Second and third derivative of φ_1 at a node.
    #[inline]
    pub fn leader_twist(&self, node: usize) -> [S; 2] {
        let [_, second, third] = self.leader_turn[node];
        [second, third]
    }

    /// dx_k/du (`what` = 0) or dΔθ_k/du (1) at the start of an element, or at the tip.
    #[inline]
    pub fn joint_row(&self, element: usize, follower: usize, what: usize) -> &[S] {
        let start = ((element * self.followers + follower) * 2 + what) * self.unknowns;
        &self.joint_rows[start..start + self.unknowns]
    }

    /// Evaluates the values. Returns the lanes that describe no bundle.
    pub fn evaluate(&mut self, robot: &Robot, layout: &Layout, coordinates: &[S]) -> u64 {
        let origin = Origin::of(robot, layout);
        // Without edges labels stay where they are.
        let fresh = self.values_of != origin || !layout.edges.is_empty();
        if self.values_of != origin {
            self.resize(layout);
            self.find_lengths(layout);
        }
        self.values_of = Origin::default();
        self.broken = 0;
        let last = layout.elements.len();
        for f in 0..self.followers {
            self.joints[last * self.followers + f] = [S::splat(robot.length()), S::zero()];
        }
        for e in (0..last).rev() {
            self.leader_at_nodes(robot, layout, e, coordinates, fresh);
            for f in 0..self.followers {
                // Angles that no unknown turns stay where they are.
                if fresh || layout.elements[e].modes[field::angle(f)].1 > 0 {
                    self.angles(layout, e, f);
                }
                self.face(robot, layout, e, f);
            }
            if self.broken == every::<S>() {
                return self.broken;
            }
        }
        self.values_of = origin;
        self.broken
    }

    /// Adds the rows of derivatives to the values. Returns the lanes that describe no bundle.
    pub fn differentiate(&mut self, robot: &Robot, layout: &Layout, coordinates: &[S]) -> u64 {
        // Without edges rows that hold nothing but polynomials stay as they are.
        let fresh = self.rows_of != self.values_of || !layout.edges.is_empty();
        for e in (0..layout.elements.len()).rev() {
            if fresh {
                self.leader_rows(layout, e, coordinates);
            }
            for f in 0..self.followers {
                if fresh {
                    self.angle_rows(layout, e, f);
                }
                self.face_rows(robot, layout, e, f);
            }
        }
        self.rows_of = self.values_of;
        self.broken
    }

    /// dℓ/du does not depend on the coordinates.
    fn find_lengths(&mut self, layout: &Layout) {
        let unset = vec![S::zero(); layout.edges.len()];
        for (e, element) in layout.elements.iter().enumerate() {
            for (joint, sign) in [(element.start, -1.0), (element.end, 1.0)] {
                if let (_, Some(unknown)) = Layout::label(joint, &unset) {
                    self.length_rows[e * self.unknowns + unknown] = S::splat(sign);
                }
            }
        }
    }

    fn leader_at_nodes(&mut self, robot: &Robot, layout: &Layout, e: usize, u: &[S], fresh: bool) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (a, _) = Layout::label(element.start, u);
        let (b, _) = Layout::label(element.end, u);
        let length = b - a;
        self.broken |= length.unless(|l| l > 0.0);
        self.lengths[e] = length;
        for i in 0..rule.n {
            let node = element.first_node + i;
            let base = node * self.rows;
            if fresh {
                let label = a + length * rule.nodes[i];
                let [_, direction @ ..] = robot.fields()[0].direction(label, Part::Pattern);
                self.leader_turn[node] = direction;
                self.leader_offset[node] = robot.fields()[0].offset(label, Part::Pattern);
                self.local[base + local::X] = label;
                for f in 0..self.followers {
                    self.rest[node * self.followers + f] = robot.rest_angle(f + 1, label);
                }
            }
            self.local[base + local::KX] = self.leader_turn[node][0];
            for f in 0..self.followers {
                self.local[base + row(f, local::DTH)] = self.rest[node * self.followers + f][1];
            }
            for variable in [local::KY, local::KZ, local::E1] {
                self.local[base + variable] = S::zero();
            }
            for f in 0..self.followers {
                self.local[base + row(f, local::EK)] = S::zero();
            }
        }
        let followers = self.followers;
        let own = (0..followers).map(|f| (field::angle(f), row(f, local::DTH)));
        let stretch = (0..followers).map(|f| (field::stretch(followers, f + 1), row(f, local::EK)));
        let stretch = [(field::stretch(followers, 0), local::E1)].into_iter().chain(stretch);
        let fields = (0..field::CURVATURES).map(|axis| (axis, axis)).chain(own);
        for (number, row) in fields.chain(stretch.take(if layout.stretch { usize::MAX } else { 0 })) {
            let (first, count) = element.modes[number];
            if count > 0 {
                for i in 0..rule.n {
                    let p = &rule.legendre[i * rule.n..i * rule.n + count];
                    let value = dot_table(p, &u[first..first + count]);
                    self.local[(element.first_node + i) * self.rows + row] += value;
                }
            }
        }
        if layout.stretch {
            for node in element.first_node..element.first_node + rule.n {
                let stretch = self.local[node * self.rows + local::E1];
                self.broken |= stretch.unless(|e| 1.0 + e >= LEAST_RATE);
            }
        }
    }

    /// Δθ_k at the nodes and at the element's start, from the tip side.
    fn angles(&mut self, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, self.lengths[e]);
        let end = self.joints[(e + 1) * self.followers + f][1];
        self.nodal.clear();
        for j in element.first_node..element.first_node + n {
            let rest = self.rest[j * self.followers + f][1];
            self.nodal.push(self.local[j * self.rows + row(f, local::DTH)] - rest);
        }
        for i in 0..n {
            let node = element.first_node + i;
            let sum = dot_table(&rule.to_end[i * n..(i + 1) * n], &self.nodal);
            let rest = self.rest[node * self.followers + f][0];
            let angle = rest + end - length * sum;
            self.local[node * self.rows + row(f, local::TH)] = angle;
            let facing = &mut self.facing[node * self.followers + f];
            (facing.sin, facing.cos) = angle.sin_cos();
        }
        self.joints[e * self.followers + f][1] = end - length * dot_table(&rule.weights, &self.nodal);
    }

    /// x_k at the nodes and at the element's start.
    fn face(&mut self, robot: &Robot, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, self.lengths[e]);
        let end = self.joints[(e + 1) * self.followers + f][0];
        let part = part(element, f + 1);
        let (rows, followers) = (self.rows, self.followers);
        let place = |i: usize| (element.first_node + i) * rows + row(f, local::FACE);
        for i in 0..n {
            // Unstrained guess.
            self.local[place(i)] = end - length * (1.0 - rule.nodes[i]);
        }
        let (mut waiting, mut varying) = (every::<S>(), false);
        for _ in 0..TURNS {
            self.nodal.clear();
            for i in 0..n {
                let node = element.first_node + i;
                let v = self.variables(node, f);
                let offset = robot.fields()[f + 1].offset(v[local::FACE], part);
                let Facing { sin, cos, .. } = self.facing[node * followers + f];
                let facing = Facing::new(&v, [sin, cos], &self.leader_offset[node], &offset);
                self.broken |= facing.h.unless(|h| h > LEAST_RATE && h < 1.0 / LEAST_RATE);
                if layout.stretch {
                    self.broken |= v[local::EK].unless(|e| 1.0 + e > LEAST_RATE);
                }
                varying |= !facing.dh[local::FACE].vanishes();
                self.facing[node * followers + f] = facing;
                self.nodal.push(facing.h);
            }
            if waiting == 0 || self.broken == every::<S>() {
                break;
            }
            let mut moved = 0;
            for i in 0..n {
                let sum = dot_table(&rule.to_end[i * n..(i + 1) * n], &self.nodal);
                let face = end - length * sum;
                let tolerance = 2.0 * f64::EPSILON * robot.length();
                moved |= (face - self.local[place(i)]).unless(|change| change.abs() <= tolerance);
                self.local[place(i)] = face;
            }
            if !varying {
                // |h| does not depend on where it is evaluated.
                waiting = 0;
                break;
            }
            waiting = moved & !self.broken;
        }
        self.broken |= waiting;
        self.joints[e * followers + f][0] = end - length * dot_table(&rule.weights, &self.nodal);
    }

    fn leader_rows(&mut self, layout: &Layout, e: usize, u: &[S]) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let n_u = self.unknowns;
        let ends = [Layout::label(element.start, u).1, Layout::label(element.end, u).1];
        for i in 0..rule.n {
            let node = element.first_node + i;
            let p = &rule.legendre[i * rule.n..(i + 1) * rule.n];
            let shares = [1.0 - rule.nodes[i], rule.nodes[i]];
            let block = &mut self.z[node * self.rows * n_u..(node + 1) * self.rows * n_u];
            let mut set = |row: usize, number: usize, slope: S| {
                let (first, count) = element.modes[number];
                for (entry, p) in block[row * n_u + first..row * n_u + first + count].iter_mut().zip(p) {
                    *entry = S::splat(*p);
                }
                for (end, share) in ends.iter().zip(shares) {
                    if let Some(unknown) = end {
                        block[row * n_u + unknown] = slope * share;
                    }
                }
            };
            set(local::KX, local::KX, self.leader_turn[node][1]);
            set(local::KY, local::KY, S::zero());
            set(local::KZ, local::KZ, S::zero());
            if layout.stretch {
                set(local::E1, field::stretch(self.followers, 0), S::zero());
            }
            for f in 0..self.followers {
                set(row(f, local::DTH), field::angle(f), self.rest[node * self.followers + f][2]);
                if layout.stretch {
                    set(row(f, local::EK), field::stretch(self.followers, f + 1), S::zero());
                }
            }
            for (end, share) in ends.iter().zip(shares) {
                if let Some(unknown) = end {
                    block[local::X * n_u + unknown] = S::splat(share);
                }
            }
        }
    }

    fn angle_rows(&mut self, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, rows, length) = (rule.n, self.unknowns, self.rows, self.lengths[e]);
        let (first, count) = element.modes[field::angle(f)];
        let end = ((e + 1) * self.followers + f) * 2 + 1;
        let start = (e * self.followers + f) * 2 + 1;
        self.nodal.clear();
        for j in element.first_node..element.first_node + n {
            let rest = self.rest[j * self.followers + f][1];
            self.nodal.push(self.local[j * rows + row(f, local::DTH)] - rest);
        }
        for i in 0..=n {
            // The last pass is the element's start.
            let weights = if i < n { &rule.to_end[i * n..(i + 1) * n] } else { &rule.weights[..] };
            let change = dot_table(weights, &self.nodal);
            let target = if i < n {
                let row = ((element.first_node + i) * rows + row(f, local::TH)) * n_u;
                &mut self.z[row..row + n_u]
            } else {
                &mut self.joint_rows[start * n_u..(start + 1) * n_u]
            };
            for (entry, moves) in target.iter_mut().zip(&self.length_rows[e * n_u..(e + 1) * n_u]) {
                *entry = -change * *moves;
            }
            let shares = &rule.legendre_to_end[i * n..i * n + count];
            axpy_table(&mut target[first..first + count], -length, shares);
        }
        for i in 0..n {
            let node = element.first_node + i;
            let slope = self.rest[node * self.followers + f][1];
            let row = (node * rows + row(f, local::TH)) * n_u;
            let label = (node * rows + local::X) * n_u;
            for column in 0..n_u {
                let change = self.joint_rows[end * n_u + column] + slope * self.z[label + column];
                self.z[row + column] += change;
            }
        }
        for column in 0..n_u {
            let change = self.joint_rows[end * n_u + column];
            self.joint_rows[start * n_u + column] += change;
        }
    }

    fn face_rows(&mut self, robot: &Robot, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, rows, length) = (rule.n, self.unknowns, self.rows, self.lengths[e]);
        // ℓ d|h|/du at the nodes without the part through x_k, plus |h| dℓ/du.
        self.rates.clear();
        self.rates.resize(n * n_u, S::zero());
        let mut implicit = false;
        for j in 0..n {
            let node = element.first_node + j;
            let facing = &self.facing[node * self.followers + f];
            implicit |= !facing.dh[local::FACE].vanishes();
            let target = &mut self.rates[j * n_u..(j + 1) * n_u];
            for active in &element.active[f] {
                let variable = active.variable;
                let slope = facing.dh[variable];
                if variable != local::FACE && !slope.vanishes() {
                    let row = (node * rows + active.row) * n_u;
                    let range = active.unknowns.clone();
                    let z = &self.z[row + range.start..row + range.end];
                    axpy(&mut target[range], length * slope, z);
                }
            }
            if !layout.edges.is_empty() {
                axpy(target, facing.h, &self.length_rows[e * n_u..(e + 1) * n_u]);
            }
        }
        let end = ((e + 1) * self.followers + f) * 2;
        let start = (e * self.followers + f) * 2;
        // Where all fields of the follower are constant nothing asks how x_k moves at the nodes.
        let constant = robot.fields()[f + 1].is_constant(part(element, f + 1));
        self.collocation.clear();
        for i in 0..if constant { 0 } else { n } {
            self.collocation.extend_from_slice(&self.joint_rows[end * n_u..(end + 1) * n_u]);
            let target = &mut self.collocation[i * n_u..];
            for j in 0..n {
                let share = S::splat(-rule.to_end[i * n + j]);
                axpy(target, share, &self.rates[j * n_u..(j + 1) * n_u]);
            }
        }
        if implicit {
            let slope = |j: usize| self.facing[(element.first_node + j) * self.followers + f].dh[local::FACE];
            self.matrix.clear();
            for i in 0..n {
                for j in 0..n {
                    let unit = if i == j { 1.0 } else { 0.0 };
                    self.matrix.push(length * slope(j) * rule.to_end[i * n + j] + unit);
                }
            }
            // Near the identity: x_k changes |h| by some thousandths.
            self.broken |= every::<S>() & !self.lu.factor_in_order(&self.matrix, n, n);
            self.lu.solve(&mut self.collocation[..n * n_u], n_u);
        }
        for (i, own) in self.collocation.chunks_exact(n_u).enumerate() {
            let row = ((element.first_node + i) * rows + row(f, local::FACE)) * n_u;
            self.z[row..row + n_u].copy_from_slice(own);
        }
        let (before, after) = self.joint_rows.split_at_mut(end * n_u);
        let target = &mut before[start * n_u..(start + 1) * n_u];
        target.copy_from_slice(&after[..n_u]);
        for j in 0..n {
            axpy(target, S::splat(-rule.weights[j]), &self.rates[j * n_u..(j + 1) * n_u]);
            let node = element.first_node + j;
            let slope = self.facing[node * self.followers + f].dh[local::FACE];
            if !slope.vanishes() {
                let factor = -slope * length * rule.weights[j];
                axpy(target, factor, &self.collocation[j * n_u..(j + 1) * n_u]);
            }
        }
    }
}

/// The rows of the leader and those of one follower among a node's rows.
#[inline]
pub(crate) fn split<S>(
    rows: &mut [S],
    follower: usize,
) -> Option<(&mut [S; local::SHARED], &mut [S; local::OWN])> {
    let (leader, own) = rows.split_first_chunk_mut()?;
    Some((leader, own[local::OWN * follower..].first_chunk_mut()?))
}

/// Row number of local variable `variable` of a follower among a node's rows.
#[inline]
pub(crate) fn row(follower: usize, variable: usize) -> usize {
    if variable < local::SHARED { variable } else { local::OWN * follower + variable }
}
