//! The bundle at given coordinates: strains, angles and face-to-face functions at every node, and their
//! exact derivatives with respect to the coordinates.
//!
//! Follower angle and face-to-face function are integrals from the tip, where the tubes are joined:
//! Δθ_k(X) = −∫_X^L Δθ_k' dX and x_k(X) = L − ∫_X^L |h_k| dX. The second is implicit, since |h_k| holds
//! D_k(x_k); its fixed point contracts by ∫|D_k' K| dX, a few thousandths.

use super::follower::{Facing, Row, local};
use super::layout::{Element, Layout};
use crate::dense::{Lu, axpy, dot};
use crate::design::Robot;
use crate::design::fields::{Jet, Part};

/// The coordinates describe no bundle: a tube would have to pass through itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Infeasible;

/// Everything about the bundle at the nodes. Buffers are reused from one evaluation to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct State {
    /// Unknowns n_u of the layout it was last evaluated for.
    pub unknowns: usize,
    rows: usize,
    followers: usize,
    /// Per element: length ℓ (m).
    pub lengths: Vec<f64>,
    /// Per node and row: the local variables.
    pub local: Vec<f64>,
    /// Per node: D_1 with derivatives.
    pub leader_offset: Vec<Jet>,
    /// Per node: second and third derivative of φ_1.
    pub leader_twist: Vec<[f64; 2]>,
    /// Per node and follower: second and third derivative of θ_k at rest; the slope is in `rest_slope`.
    pub rest: Vec<[f64; 4]>,
    /// Per node and follower.
    pub facing: Vec<Facing>,
    /// Per element and follower, at the element's start: x_k and Δθ_k; one more entry for the tip.
    pub joints: Vec<[f64; 2]>,
    /// Per element: dℓ/du.
    pub length_rows: Vec<f64>,
    /// Per node and row: derivatives of the local variables, rows of length n_u.
    pub z: Vec<f64>,
    /// Per element (and tip) and follower: dx_k/du and dΔθ_k/du at the start.
    pub joint_rows: Vec<f64>,
    collocation: Vec<f64>,
    rates: Vec<f64>,
    matrix: Vec<f64>,
    lu: Lu,
}

/// |h| below this is no bundle any more: the follower would be crushed to nothing.
const LEAST_RATE: f64 = 0.02;

/// Which part of a tube faces an element.
pub(crate) fn part(element: &Element, tube: usize) -> Part {
    if element.below[tube] { Part::Below } else { Part::Pattern }
}

impl State {
    fn resize(&mut self, layout: &Layout) {
        let (nodes, elements) = (layout.nodes, layout.elements.len());
        self.unknowns = layout.unknowns();
        self.rows = layout.rows();
        self.followers = layout.tubes - 1;
        self.lengths.resize(elements, 0.0);
        self.local.resize(nodes * self.rows, 0.0);
        self.leader_offset.resize(nodes, [0.0; 3]);
        self.leader_twist.resize(nodes, [0.0; 2]);
        self.rest.resize(nodes * self.followers, [0.0; 4]);
        self.facing.resize(nodes * self.followers, Facing::default());
        self.joints.resize((elements + 1) * self.followers, [0.0; 2]);
        self.length_rows.resize(elements * self.unknowns, 0.0);
        self.z.resize(nodes * self.rows * self.unknowns, 0.0);
        self.joint_rows.resize((elements + 1) * self.followers * 2 * self.unknowns, 0.0);
    }

    /// The local variables of one follower at one node.
    #[inline]
    pub fn variables(&self, node: usize, follower: usize) -> Row {
        let base = node * self.rows;
        let own = base + 5 + 4 * follower;
        let mut v = [0.0; local::COUNT];
        v[..5].copy_from_slice(&self.local[base..base + 5]);
        v[5..].copy_from_slice(&self.local[own..own + 4]);
        v
    }

    /// Row number of local variable `variable` of a follower among a node's rows.
    #[inline]
    pub fn row(follower: usize, variable: usize) -> usize {
        if variable < 5 { variable } else { 4 * follower + variable }
    }

    /// Derivatives of one local variable at a node.
    #[inline]
    pub fn z_row(&self, node: usize, row: usize) -> &[f64] {
        let start = (node * self.rows + row) * self.unknowns;
        &self.z[start..start + self.unknowns]
    }

    /// dx_k/du (`what` = 0) or dΔθ_k/du (1) at the start of an element, or at the tip.
    #[inline]
    pub fn joint_row(&self, element: usize, follower: usize, what: usize) -> &[f64] {
        let start = ((element * self.followers + follower) * 2 + what) * self.unknowns;
        &self.joint_rows[start..start + self.unknowns]
    }

    /// Evaluates the values; `derivatives` adds the rows z.
    pub fn evaluate(
        &mut self,
        robot: &Robot,
        layout: &Layout,
        coordinates: &[f64],
        derivatives: bool,
    ) -> Result<(), Infeasible> {
        self.resize(layout);
        let last = layout.elements.len();
        for f in 0..self.followers {
            self.joints[last * self.followers + f] = [robot.length(), 0.0];
        }
        if derivatives {
            self.z.fill(0.0);
            self.joint_rows.fill(0.0);
            self.length_rows.fill(0.0);
        }
        for e in (0..last).rev() {
            self.leader_at_nodes(robot, layout, e, coordinates)?;
            for f in 0..self.followers {
                self.angles(layout, e, f);
                self.face(robot, layout, e, f)?;
            }
            if derivatives {
                self.leader_rows(layout, e, coordinates);
                for f in 0..self.followers {
                    self.angle_rows(layout, e, f);
                    self.face_rows(layout, e, f)?;
                }
            }
        }
        Ok(())
    }

    fn leader_at_nodes(
        &mut self,
        robot: &Robot,
        layout: &Layout,
        e: usize,
        u: &[f64],
    ) -> Result<(), Infeasible> {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (a, _) = Layout::label(element.start, u);
        let (b, _) = Layout::label(element.end, u);
        let length = b - a;
        if length.is_nan() || length <= 0.0 {
            return Err(Infeasible);
        }
        self.lengths[e] = length;
        for i in 0..rule.n {
            let node = element.first_node + i;
            let label = a + rule.nodes[i] * length;
            let p = &rule.legendre[i * rule.n..(i + 1) * rule.n];
            let field = |f: usize| {
                let (first, count) = element.modes[f];
                dot(&u[first..first + count], &p[..count])
            };
            let direction = robot.fields[0].direction(label, Part::Pattern);
            self.leader_offset[node] = robot.fields[0].offset(label, Part::Pattern);
            self.leader_twist[node] = [direction[2], direction[3]];
            let stretch = if layout.stretch { field(3 + self.followers) } else { 0.0 };
            let own = [direction[1] + field(0), field(1), field(2), stretch, label];
            if 1.0 + stretch < LEAST_RATE {
                return Err(Infeasible);
            }
            self.local[node * self.rows..node * self.rows + 5].copy_from_slice(&own);
            for f in 0..self.followers {
                let rest = robot.rest_angle(f + 1, label);
                self.rest[node * self.followers + f] = rest;
                let row = node * self.rows + 5 + 4 * f;
                self.local[row + 1] = rest[1] + field(3 + f);
                self.local[row + 3] = if layout.stretch { field(4 + self.followers + f) } else { 0.0 };
            }
        }
        Ok(())
    }

    /// Δθ_k at the nodes and at the element's start, from the tip side.
    fn angles(&mut self, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let length = self.lengths[e];
        let end = self.joints[(e + 1) * self.followers + f][1];
        let rate = |state: &Self, j: usize| {
            let node = element.first_node + j;
            state.local[node * state.rows + 6 + 4 * f] - state.rest[node * state.followers + f][1]
        };
        let mut total = 0.0;
        for i in 0..rule.n {
            let node = element.first_node + i;
            let sum: f64 = (0..rule.n).map(|j| rule.to_end[i * rule.n + j] * rate(self, j)).sum();
            let rest = self.rest[node * self.followers + f][0];
            self.local[node * self.rows + 5 + 4 * f] = rest + end - length * sum;
            total += rule.weights[i] * rate(self, i);
        }
        self.joints[e * self.followers + f][1] = end - length * total;
    }

    /// x_k at the nodes and at the element's start.
    fn face(&mut self, robot: &Robot, layout: &Layout, e: usize, f: usize) -> Result<(), Infeasible> {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, length) = (rule.n, self.lengths[e]);
        let end = self.joints[(e + 1) * self.followers + f][0];
        let part = part(element, f + 1);
        let place = |node: usize, state: &Self| node * state.rows + 5 + 4 * f + 2;
        for i in 0..n {
            // Unstrained guess.
            let slot = place(element.first_node + i, self);
            self.local[slot] = end - length * (1.0 - rule.nodes[i]);
        }
        let mut settled = false;
        for _ in 0..60 {
            let mut varying = false;
            for i in 0..n {
                let node = element.first_node + i;
                let v = self.variables(node, f);
                let offset = robot.fields[f + 1].offset(v[local::FACE], part);
                let facing = Facing::new(&v, &self.leader_offset[node], &offset);
                if !(facing.h > LEAST_RATE && facing.h < 1.0 / LEAST_RATE && 1.0 + v[local::EK] > LEAST_RATE)
                {
                    return Err(Infeasible);
                }
                varying |= facing.dh[local::FACE] != 0.0;
                self.facing[node * self.followers + f] = facing;
            }
            if settled {
                break;
            }
            let mut change = 0.0_f64;
            for i in 0..n {
                let sum: f64 = (0..n)
                    .map(|j| {
                        rule.to_end[i * n + j] * self.facing[(element.first_node + j) * self.followers + f].h
                    })
                    .sum();
                let slot = place(element.first_node + i, self);
                let face = end - length * sum;
                change = change.max((face - self.local[slot]).abs());
                self.local[slot] = face;
            }
            settled = !varying || change <= 2.0 * f64::EPSILON * robot.length();
        }
        if !settled {
            return Err(Infeasible);
        }
        let total: f64 = (0..n)
            .map(|j| rule.weights[j] * self.facing[(element.first_node + j) * self.followers + f].h)
            .sum();
        self.joints[e * self.followers + f][0] = end - length * total;
        Ok(())
    }

    fn leader_rows(&mut self, layout: &Layout, e: usize, u: &[f64]) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let n_u = self.unknowns;
        let ends = [Layout::label(element.start, u).1, Layout::label(element.end, u).1];
        let length_row = &mut self.length_rows[e * n_u..(e + 1) * n_u];
        if let Some(start) = ends[0] {
            length_row[start] -= 1.0;
        }
        if let Some(end) = ends[1] {
            length_row[end] += 1.0;
        }
        for i in 0..rule.n {
            let node = element.first_node + i;
            let p = &rule.legendre[i * rule.n..(i + 1) * rule.n];
            let block = &mut self.z[node * self.rows * n_u..(node + 1) * self.rows * n_u];
            let mut set = |row: usize, field: usize, slope: f64| {
                let (first, count) = element.modes[field];
                block[row * n_u + first..row * n_u + first + count].copy_from_slice(&p[..count]);
                for (end, share) in ends.iter().zip([1.0 - rule.nodes[i], rule.nodes[i]]) {
                    if let Some(unknown) = end {
                        block[row * n_u + unknown] = share * slope;
                    }
                }
            };
            set(local::KX, 0, self.leader_twist[node][0]);
            set(local::KY, 1, 0.0);
            set(local::KZ, 2, 0.0);
            if layout.stretch {
                set(local::E1, 3 + self.followers, 0.0);
            }
            for f in 0..self.followers {
                set(State::row(f, local::DTH), 3 + f, self.rest[node * self.followers + f][2]);
                if layout.stretch {
                    set(State::row(f, local::EK), 4 + self.followers + f, 0.0);
                }
            }
            for (end, share) in ends.iter().zip([1.0 - rule.nodes[i], rule.nodes[i]]) {
                if let Some(unknown) = end {
                    block[local::X * n_u + unknown] = share;
                }
            }
        }
    }

    fn angle_rows(&mut self, layout: &Layout, e: usize, f: usize) {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, rows, length) = (rule.n, self.unknowns, self.rows, self.lengths[e]);
        let (first, count) = element.modes[3 + f];
        let end = ((e + 1) * self.followers + f) * 2 + 1;
        let start = (e * self.followers + f) * 2 + 1;
        let moves = self.length_rows[e * n_u..(e + 1) * n_u].iter().any(|&d| d != 0.0);
        for i in 0..=n {
            // The last pass is the element's start.
            let weights = if i < n { &rule.to_end[i * n..(i + 1) * n] } else { &rule.weights[..] };
            let values: f64 = (0..n)
                .map(|j| {
                    let node = element.first_node + j;
                    weights[j]
                        * (self.local[node * rows + 6 + 4 * f] - self.rest[node * self.followers + f][1])
                })
                .sum();
            let target = if i < n {
                let row = ((element.first_node + i) * rows + State::row(f, local::TH)) * n_u;
                &mut self.z[row..row + n_u]
            } else {
                &mut self.joint_rows[start * n_u..(start + 1) * n_u]
            };
            axpy(&mut target[first..first + count], -length, &rule.legendre_to_end[i * n..i * n + count]);
            if moves {
                axpy(target, -values, &self.length_rows[e * n_u..(e + 1) * n_u]);
            }
        }
        for i in 0..n {
            let node = element.first_node + i;
            let slope = self.rest[node * self.followers + f][1];
            let row = (node * rows + State::row(f, local::TH)) * n_u;
            let label = (node * rows + local::X) * n_u;
            for column in 0..n_u {
                self.z[row + column] += self.joint_rows[end * n_u + column] + slope * self.z[label + column];
            }
        }
        for column in 0..n_u {
            self.joint_rows[start * n_u + column] += self.joint_rows[end * n_u + column];
        }
    }

    fn face_rows(&mut self, layout: &Layout, e: usize, f: usize) -> Result<(), Infeasible> {
        let element = &layout.elements[e];
        let rule = &layout.rules[element.rule];
        let (n, n_u, rows, length) = (rule.n, self.unknowns, self.rows, self.lengths[e]);
        // ℓ d|h|/du at the nodes without the part through x_k, plus |h| dℓ/du.
        self.rates.resize(n * n_u, 0.0);
        self.rates.fill(0.0);
        for j in 0..n {
            let node = element.first_node + j;
            let facing = &self.facing[node * self.followers + f];
            let target = &mut self.rates[j * n_u..(j + 1) * n_u];
            for variable in 0..local::COUNT {
                let slope = facing.dh[variable];
                let known = variable != local::FACE && element.active.contains(&State::row(f, variable));
                if slope != 0.0 && known {
                    let row = (node * rows + State::row(f, variable)) * n_u;
                    axpy(target, length * slope, &self.z[row..row + n_u]);
                }
            }
            axpy(target, facing.h, &self.length_rows[e * n_u..(e + 1) * n_u]);
        }
        let end = ((e + 1) * self.followers + f) * 2;
        let start = (e * self.followers + f) * 2;
        let slopes = |state: &Self, j: usize| {
            state.facing[(element.first_node + j) * state.followers + f].dh[local::FACE]
        };
        let implicit = (0..n).any(|j| slopes(self, j) != 0.0);
        self.collocation.resize(n * n_u, 0.0);
        for i in 0..n {
            let target = &mut self.collocation[i * n_u..(i + 1) * n_u];
            target.copy_from_slice(&self.joint_rows[end * n_u..(end + 1) * n_u]);
            for j in 0..n {
                axpy(target, -rule.to_end[i * n + j], &self.rates[j * n_u..(j + 1) * n_u]);
            }
        }
        if implicit {
            self.matrix.resize(n * n, 0.0);
            for i in 0..n {
                for j in 0..n {
                    self.matrix[i * n + j] = length * rule.to_end[i * n + j] * slopes(self, j);
                }
                self.matrix[i * n + i] += 1.0;
            }
            self.lu.factor(&self.matrix, n).map_err(|_| Infeasible)?;
            self.lu.solve(&mut self.collocation[..n * n_u], n_u);
        }
        for i in 0..n {
            let row = ((element.first_node + i) * rows + State::row(f, local::FACE)) * n_u;
            self.z[row..row + n_u].copy_from_slice(&self.collocation[i * n_u..(i + 1) * n_u]);
        }
        let (before, after) = self.joint_rows.split_at_mut(end * n_u);
        let target = &mut before[start * n_u..(start + 1) * n_u];
        target.copy_from_slice(&after[..n_u]);
        for j in 0..n {
            axpy(target, -rule.weights[j], &self.rates[j * n_u..(j + 1) * n_u]);
            let node = element.first_node + j;
            let slope = self.facing[node * self.followers + f].dh[local::FACE];
            axpy(target, -rule.weights[j] * length * slope, &self.collocation[j * n_u..(j + 1) * n_u]);
        }
        Ok(())
    }
}
