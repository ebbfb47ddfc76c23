//! Equilibrium of a state between the walls: gradient and tangent of its energy, and Newton's method with a primal-dual interior point.
//!
//! For the heights y_k of the tubes' axes over the leader's (y of the leader is 0) and the gaps δ_k, at every node the conditions are
//!
//! ```text
//! ∂Π/∂u + Σ (z⁺ − z⁻) ∂d/∂u = 0 ,   d = y_k − y_{k−1} ,   z⁺ (δ − d) = μ ,  z⁻ (δ + d) = μ ,   all factors above 0 ,
//! ```
//!
//! with μ → 0: z⁺ and z⁻ are the forces of the walls. A large μ keeps every tube on the axis, so that the path of falling μ leads from the shape without clearance to
//! that with it.

use super::banded::Banded;
use super::element::{Element, FIRST, Number, TubeFields};
use super::state::{Held, Numbering, State, seeded};
use crate::design::fields::Part;
use nalgebra::Vector3;

/// What does not change during a solve, scaled.
pub(super) struct Problem<'a> {
    /// From outside to inside.
    pub tubes: Vec<TubeFields<'a>>,
    /// Per follower: gap between it and the tube around it.
    pub gaps: Vec<f64>,
    pub held: Held<'a>,
    /// Per follower: force of the motor where that is given.
    pub forces: Vec<Option<f64>>,
    pub loads: Dead,
}

/// Dead loads in the plane, scaled.
#[derive(Clone, Debug, Default)]
pub(super) struct Dead {
    /// Force per label between two labels.
    pub distributed: Vec<([f64; 2], [f64; 2])>,
    pub points: Vec<PointLoad>,
}

/// A force with its point of action in the frame of the section, and a moment, at a label.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLoad {
    pub label: f64,
    pub force: [f64; 2],
    pub point: [f64; 2],
    pub moment: f64,
}

impl Dead {
    /// Force on all that lies beyond a label, and its slope.
    fn beyond(&self, label: f64) -> [[f64; 2]; 2] {
        let (mut sum, mut rate) = ([0.0; 2], [0.0; 2]);
        for axis in 0..2 {
            for &([from, to], force) in &self.distributed {
                sum[axis] += force[axis] * (to - label.max(from)).max(0.0);
                rate[axis] -= if from < label && label < to { force[axis] } else { 0.0 };
            }
            sum[axis] +=
                self.points.iter().filter(|own| own.label > label).map(|own| own.force[axis]).sum::<f64>();
        }
        [sum, rate]
    }
}

/// Wall forces z⁺ and z⁻ of every node and pair.
pub(super) type Walls = Vec<Vec<[f64; 2]>>;

/// Gradient and tangent of the energy.
struct Evaluated {
    energy: f64,
    gradient: Vec<f64>,
    matrix: Banded,
    /// Per follower: what the motor pulls with.
    pull: Vec<f64>,
}

/// A solved state.
pub(super) struct Settled {
    pub state: State,
    pub walls: Walls,
    /// Potential of tubes and loads.
    pub energy: f64,
    /// Per follower: force of its motor.
    pub pull: Vec<f64>,
    pub iterations: usize,
}

/// From one value of μ to the next, and where they begin and end, in units of EI/L times the gap and the part of the length that a node has.
const FALL: f64 = 0.2;
const MOST: f64 = 1e3;
const LEAST: f64 = 1e-4;
/// Part of the way to a wall, or of a wall force to zero, that a step goes at most.
const SHY: f64 = 0.995;
/// Steps of one μ; greatest step of a last one, in units of the length, and of an earlier one.
const STEPS: usize = 60;
const SETTLED: f64 = 1e-9;
const NEAR: f64 = 1e-4;
/// Greatest turn (rad) in a step.
const TURN: f64 = 0.3;
const HALVINGS: u32 = 8;

impl Problem<'_> {
    fn evaluate(&self, state: &State, numbering: &Numbering) -> Option<Evaluated> {
        let mut gradient = vec![0.0; numbering.count];
        let mut matrix = Banded::zeros(numbering.count, numbering.reach);
        let (mut energy, mut pull) = (0.0, vec![0.0; state.followers()]);
        for (place, span) in state.spans.iter().enumerate() {
            for (k, (tube, part)) in self.tubes[1..].iter().zip(&span.parts).enumerate() {
                let numbers = numbering.of(place, k);
                let inputs = seeded(state.inputs(place, k), &numbers);
                let element = Element { leader: self.tubes[0], inputs, stretches: self.held.stretches };
                let mut own = element.follower_energy(tube, *part);
                if k == 0 {
                    own = own + element.leader_energy(|label| self.loads.beyond(label));
                }
                energy += own.value;
                // The label at the base is held or driven: its slope tells the force all the same.
                if place == 0 {
                    pull[k] = Self::base_slope(&element, state, k, tube, *part);
                }
                for (i, row) in numbers.iter().enumerate() {
                    let Some(row) = *row else { continue };
                    gradient[row] += own.slopes[i];
                    for (j, column) in numbers.iter().enumerate() {
                        if let Some(column) = *column {
                            matrix.add(row, column, own.bends[i][j]);
                        }
                    }
                }
            }
        }
        for &PointLoad { label, force: [x, y], point: [a, b], moment } in &self.loads.points {
            let Some(node) = state.nodes.iter().position(|node| (node.label - label).abs() < 1e-9) else {
                continue;
            };
            let (sin, cos) = state.nodes[node].angle.sin_cos();
            // −F·(R r) − M θ and its derivatives by θ.
            let (along, across) = (
                x * (a * cos - b * sin) + y * (a * sin + b * cos),
                x * (-a * sin - b * cos) + y * (a * cos - b * sin),
            );
            energy -= along + moment * state.nodes[node].angle;
            if let Some(i) = numbering.angle(node) {
                gradient[i] -= across + moment;
                matrix.add(i, i, along);
            }
        }
        for (k, force) in self.forces.iter().enumerate() {
            if let (Some(force), Some(i)) = (force, numbering.label(0, k)) {
                gradient[i] -= force;
                energy -= force * state.nodes[0].beside[k].label;
            }
        }
        energy.is_finite().then_some(Evaluated { energy, gradient, matrix, pull })
    }

    /// Slope of the energy by the label that stands at the base.
    fn base_slope(element: &Element, state: &State, k: usize, tube: &TubeFields, part: Part) -> f64 {
        let mut inputs = element.inputs;
        inputs[FIRST[2]] = Number::input(state.nodes[0].beside[k].label, FIRST[2]);
        let own = Element { leader: element.leader, inputs, stretches: element.stretches };
        own.follower_energy(tube, part).slopes[FIRST[2]]
    }

    /// Distance of a follower's axis from that of the tube around it.
    pub fn offset(state: &State, node: usize, follower: usize) -> f64 {
        let height = |k: usize| state.nodes[node].beside[k].height;
        height(follower) - follower.checked_sub(1).map_or(0.0, height)
    }

    /// Is there play at a node?
    pub fn has_play(&self, state: &State, node: usize, follower: usize) -> bool {
        !(self.held.tight[follower] || node == 0 || node + 1 == state.nodes.len())
    }

    /// From a state in which every tube with play lies between its walls.
    pub fn settle(&self, start: State) -> Option<Settled> {
        let part = 1.0 / start.spans.len() as f64;
        let mut tau = MOST;
        let mut walls: Walls =
            start.nodes.iter().map(|_| self.gaps.iter().map(|_| [tau * part; 2]).collect()).collect();
        let mut state = start;
        let mut iterations = 0;
        let mut fall = FALL;
        let mut done: Option<(State, Walls, f64)> = None;
        loop {
            let last = tau <= LEAST;
            let settled = if last { SETTLED } else { NEAR };
            if let Some((found, forces, steps)) =
                self.newton(state.clone(), walls.clone(), tau * part, settled)
            {
                iterations += steps;
                if last {
                    let numbering = Numbering::new(&found, &self.held);
                    let Evaluated { energy, pull, .. } = self.evaluate(&found, &numbering)?;
                    return Some(Settled { state: found, walls: forces, energy, pull, iterations });
                }
                done = Some((found.clone(), forces.clone(), tau));
                (state, walls) = (found, forces);
                fall = (fall * fall).max(FALL);
            } else {
                // Back to where it went, to go on in shorter steps.
                fall = fall.sqrt();
                (state, walls, tau) = done.clone()?;
                if fall > 0.97 {
                    return None;
                }
            }
            tau = (tau * fall).max(LEAST);
        }
    }

    /// Newton's method for one μ, given in units of the gap.
    fn newton(
        &self,
        mut state: State,
        mut walls: Walls,
        mu: f64,
        settled: f64,
    ) -> Option<(State, Walls, usize)> {
        let numbering = Numbering::new(&state, &self.held);
        let plays: Vec<(usize, usize)> = (0..state.nodes.len())
            .flat_map(|node| (0..self.gaps.len()).map(move |k| (node, k)))
            .filter(|&(node, k)| self.has_play(&state, node, k))
            .collect();
        let mut now = self.evaluate(&state, &numbering)?;
        for iteration in 1..=STEPS {
            let Evaluated { gradient, mut matrix, .. } = now;
            let mut right: Vec<f64> = gradient.iter().map(|g| -g).collect();
            for &(node, k) in &plays {
                let (gap, offset) = (self.gaps[k], Self::offset(&state, node, k));
                let [up, down] = walls[node][k];
                let [above, below] = [gap - offset, gap + offset];
                let mu = mu * gap;
                let ends = [(k + 1, 1.0), (k, -1.0)].map(|(tube, sign)| (numbering.height(node, tube), sign));
                for (row, a) in ends {
                    let Some(row) = row else { continue };
                    right[row] += a * (mu / below - mu / above);
                    for (column, b) in ends {
                        if let Some(column) = column {
                            matrix.add(row, column, a * b * (up / above + down / below));
                        }
                    }
                }
            }
            let step = matrix.solve(right)?;
            let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
            let mut pushes = Vec::with_capacity(plays.len());
            for &(node, k) in &plays {
                let (gap, offset) = (self.gaps[k], Self::offset(&state, node, k));
                let of = |tube: usize| numbering.height(node, tube).map_or(0.0, |i| step[i]);
                let moved = of(k + 1) - of(k);
                let [up, down] = walls[node][k];
                let [above, below] = [gap - offset, gap + offset];
                let mu = mu * gap;
                let push = [mu / above - up + up / above * moved, mu / below - down - down / below * moved];
                let least = |value: f64, change: f64, share: f64| {
                    if change < 0.0 { share.min(-SHY * value / change) } else { share }
                };
                primal = least(above, -moved, least(below, moved, primal));
                dual = least(up, push[0], least(down, push[1], dual));
                pushes.push(push);
            }
            let turn = (0..state.nodes.len())
                .filter_map(|node| numbering.angle(node))
                .fold(0.0, |most: f64, i| most.max(step[i].abs()));
            primal = primal.min(TURN / turn.max(f64::MIN_POSITIVE));
            let mut tried = 0;
            (state, now) = loop {
                let next = numbering.moved(&state, &step, primal);
                let ordered = next.nodes.windows(2).all(|pair| pair[1].label > pair[0].label);
                match ordered.then(|| self.evaluate(&next, &numbering)).flatten() {
                    Some(evaluated) => break (next, evaluated),
                    None if tried == HALVINGS => return None,
                    None => primal *= 0.5,
                }
                tried += 1;
            };
            for (&(node, k), push) in plays.iter().zip(&pushes) {
                for (own, push) in walls[node][k].iter_mut().zip(push) {
                    *own += dual * push;
                }
            }
            let size = step.iter().zip(&numbering.is_tension).filter(|own| !own.1);
            let size = size.fold(0.0, |most: f64, (own, _)| most.max(own.abs()));
            if primal >= 1.0 && dual >= 1.0 && size < settled {
                return Some((state, walls, iteration));
            }
        }
        None
    }

    /// Centre of the leader's section at every node.
    pub fn centreline(&self, state: &State) -> Vec<Vector3<f64>> {
        let mut centre = Vector3::zeros();
        let mut line = vec![centre];
        for place in 0..state.spans.len() {
            let inputs = state.inputs(place, 0).map(Number::constant);
            let [x, y] = Element { leader: self.tubes[0], inputs, stretches: self.held.stretches }.advance();
            centre += Vector3::new(x, y, 0.0);
            line.push(centre);
        }
        line
    }
}
