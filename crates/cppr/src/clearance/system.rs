//! Equilibrium of a state between the walls: gradient and tangent of its energy, and Newton's method with a primal-dual interior point.
//!
//! For the offset d of every tube against the one around it and its gap δ, at every node the conditions are
//!
//! ```text
//! ∂Π/∂u − Σ z ∂c/∂u = 0 ,   c = (δ² − |d|²)/(2 δ) ,   z c = μ ,   z > 0 ,   c > 0 ,
//! ```
//!
//! with μ → 0: z is then the force of the wall, along d. A large μ keeps every tube on the axis, so that the path of falling μ leads from the shape without clearance to
//! that with it.

use super::banded::Banded;
use super::element::{INPUTS, LABELS, Number, PLACES, Spread, TURNS, TubeFields};
use super::state::{Held, Numbering, State};
use crate::design::fields::Part;
use crate::kinematics::so3::{about_x, hat};
use crate::statics::{Applied, Frame, Loads, Station};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Nodes nearer than this part of the length are one.
pub(super) const SAME: f64 = 1e-7;

/// What does not change during a solve, scaled.
pub(super) struct Problem<'a> {
    /// From outside to inside.
    pub tubes: Vec<TubeFields<'a>>,
    /// Per follower: gap between it and the tube around it.
    pub gaps: Vec<f64>,
    /// Gap around tube 2 in the guide.
    pub guide: f64,
    pub held: Held,
    /// Per follower: force and torque of the motor where these are given.
    pub efforts: Vec<[Option<f64>; 2]>,
    /// In units of the length and of EI/L²; gravity is a force per mass.
    pub loads: Loads,
}

/// Force of the wall at every node, per pair.
pub(super) type Walls = Vec<Vec<f64>>;

/// Gradient and tangent of the energy.
struct Evaluated {
    energy: f64,
    gradient: Vec<f64>,
    matrix: Banded,
    /// Per follower: force and torque of its motor.
    efforts: Vec<[f64; 2]>,
}

/// A solved state.
pub(super) struct Settled {
    pub state: State,
    pub walls: Walls,
    /// Potential of tubes and loads.
    pub energy: f64,
    /// Per follower: force and torque of its motor.
    pub efforts: Vec<[f64; 2]>,
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
    /// Gap of a pair at a node; `None` where the inner tube has no play.
    pub fn play(&self, state: &State, node: usize, follower: usize) -> Option<f64> {
        let held = node == 0 || node + 1 == state.nodes.len();
        if self.held.tight[follower] || held {
            return None;
        }
        Some(match follower {
            0 if node < state.guided => self.guide,
            0 if node == state.guided => self.guide.min(self.gaps[0]),
            _ => self.gaps[follower],
        })
    }

    /// Forces per label of a tube on an element.
    fn spread(&self, state: &State, element: usize, tube: usize) -> Spread {
        let mut spread = Spread::default();
        if element < state.guided {
            return spread;
        }
        spread.gravity = self.loads.gravity.unwrap_or_default();
        if tube == 0 {
            let middle = 0.5 * (state.nodes[element].labels[0] + state.nodes[element + 1].labels[0]);
            let along = self.loads.distributed.iter().filter(|own| own.from < middle && middle < own.to);
            spread.load = along.map(|own| own.force).sum();
        }
        spread
    }

    fn evaluate(&self, state: &State, numbering: &Numbering) -> Option<Evaluated> {
        let mut own = Evaluated {
            energy: 0.0,
            gradient: vec![0.0; numbering.count],
            matrix: Banded::zeros(numbering.count, numbering.reach),
            efforts: vec![[0.0; 2]; self.gaps.len()],
        };
        for place in 0..state.spans.len() {
            for tube in state.present(place) {
                let element = state.element(place, tube);
                let energy = element.energy(&self.tubes[tube], &self.spread(state, place, tube));
                own.energy += energy.value;
                if place == 0 && tube > 0 {
                    // What motors hold has slopes all the same.
                    own.efforts[tube - 1] = [energy.slopes[LABELS[0]], energy.slopes[TURNS[0]]];
                }
                own.add(state, numbering, [place, tube], &energy);
            }
        }
        self.add_loads(state, numbering, &mut own);
        for (k, efforts) in self.efforts.iter().enumerate() {
            for (effort, number) in efforts.iter().zip(numbering.motor(k)) {
                if let (Some(effort), Some(i)) = (effort, number) {
                    own.gradient[i] -= effort;
                }
            }
            own.energy -= efforts[0].unwrap_or(0.0) * state.nodes[0].labels[k + 1];
        }
        own.energy.is_finite().then_some(own)
    }

    /// Concentrated loads.
    fn add_loads(&self, state: &State, numbering: &Numbering, to: &mut Evaluated) {
        let last = state.nodes.len() - 1;
        let mut put = |node: usize, of: &dyn Fn(&Matrix3<f64>, &Vector3<f64>) -> Applied| {
            let own = &state.nodes[node];
            let material = own.turns[0].to_rotation_matrix().into_inner();
            let tube = &self.tubes[0];
            let [phi, ..] = tube.fields.direction(own.labels[0] * tube.units[0], Part::Pattern);
            let load = of(&(material * about_x(phi)), &own.centre);
            let Applied { force, moment, arm, force_by_point, force_by_spin, moment_by_spin } = load;
            let turning = material.transpose() * (moment + arm.cross(&force));
            let force_by_turn = force_by_spin - force_by_point * hat(&arm);
            let moment_by_turn = moment_by_spin + hat(&force) * hat(&arm) + hat(&arm) * force_by_turn;
            // A small turn δ about the material axes turns these too, by which the moment's work differs in second order.
            let blocks = [
                [force_by_point, force_by_turn * material],
                [
                    material.transpose() * hat(&arm) * force_by_point,
                    material.transpose() * moment_by_turn * material + hat(&turning) * 0.5,
                ],
            ];
            let numbers = numbering.leader(node);
            for (r, (rows, pull)) in numbers.iter().zip([force, turning]).enumerate() {
                for (i, row) in rows.iter().enumerate() {
                    let Some(row) = *row else { continue };
                    to.gradient[row] -= pull[i];
                    for (c, columns) in numbers.iter().enumerate() {
                        for (j, column) in columns.iter().enumerate() {
                            if let Some(column) = *column {
                                to.matrix.add(row, column, -blocks[r][c][(i, j)]);
                            }
                        }
                    }
                }
            }
            own.centre + arm
        };
        let mut potential = 0.0;
        for own in &self.loads.wrenches {
            let node = match own.station {
                Station::Tip => Some(last),
                Station::Label(label) => {
                    state.nodes.iter().position(|node| (node.labels[0] - label).abs() < SAME)
                }
            };
            let Some(node) = node else { continue };
            let at = put(node, &|rotation, _| {
                Applied::wrench(own.frame, rotation, &own.force, &own.moment, &own.point)
            });
            if own.frame == Frame::World {
                potential -= own.force.dot(&at);
            }
        }
        for own in &self.loads.threads {
            let at = put(last, &|rotation, centre| own.at(rotation, centre));
            potential += own.tension * (own.pulley - at).norm();
        }
        to.energy += potential;
    }

    /// From a state in which every tube with play lies between its walls.
    pub fn settle(&self, start: State) -> Option<Settled> {
        let part = 1.0 / start.spans.len() as f64;
        let mut tau = MOST;
        let mut walls: Walls =
            start.nodes.iter().map(|_| self.gaps.iter().map(|_| 2.0 * tau * part).collect()).collect();
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
                    let Evaluated { energy, efforts, .. } = self.evaluate(&found, &numbering)?;
                    return Some(Settled { state: found, walls: forces, energy, efforts, iterations });
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
        let plays: Vec<(usize, usize, f64)> = (0..state.nodes.len())
            .flat_map(|node| (0..self.gaps.len()).map(move |k| (node, k)))
            .filter_map(|(node, k)| self.play(&state, node, k).map(|gap| (node, k, gap)))
            .collect();
        let mut now = self.evaluate(&state, &numbering)?;
        for iteration in 1..=STEPS {
            let Evaluated { gradient, mut matrix, .. } = now;
            let mut right: Vec<f64> = gradient.iter().map(|g| -g).collect();
            for &(node, k, gap) in &plays {
                let (wall, room, out) = (walls[node][k], Room::of(&state, node, k, gap), mu * gap);
                let block = nalgebra::Matrix2::identity() * (wall / gap)
                    + room.normal * room.normal.transpose() * (wall / room.left);
                let push = room.normal * (out / room.left);
                let ends = [(k + 1, 1.0), (k, -1.0)].map(|(tube, sign)| (numbering.offset(node, tube), sign));
                for (rows, a) in ends {
                    for (i, row) in rows.into_iter().enumerate() {
                        let Some(row) = row else { continue };
                        right[row] -= a * push[i];
                        for (columns, b) in ends {
                            for (j, column) in columns.into_iter().enumerate() {
                                if let Some(column) = column {
                                    matrix.add(row, column, a * b * block[(i, j)]);
                                }
                            }
                        }
                    }
                }
            }
            let step = matrix.solve(right)?;
            let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
            let mut pushes = Vec::with_capacity(plays.len());
            for &(node, k, gap) in &plays {
                let of = |tube: usize| {
                    Vector2::from(numbering.offset(node, tube).map(|number| number.map_or(0.0, |i| step[i])))
                };
                let moved = of(k + 1) - of(k);
                let (wall, room) = (walls[node][k], Room::of(&state, node, k, gap));
                let push = mu * gap / room.left - wall + wall / room.left * room.normal.dot(&moved);
                primal = primal.min(room.share(&moved, gap));
                if push < 0.0 {
                    dual = dual.min(-SHY * wall / push);
                }
                pushes.push(push);
            }
            primal = primal.min(TURN / numbering.turn(&step).max(f64::MIN_POSITIVE));
            let mut tried = 0;
            (state, now) = loop {
                let next = numbering.moved(&state, &step, primal);
                let ordered = next.nodes.windows(2).all(|pair| pair[1].labels[0] > pair[0].labels[0]);
                match ordered.then(|| self.evaluate(&next, &numbering)).flatten() {
                    Some(evaluated) => break (next, evaluated),
                    None if tried == HALVINGS => return None,
                    None => primal *= 0.5,
                }
                tried += 1;
            };
            for (&(node, k, _), push) in plays.iter().zip(&pushes) {
                walls[node][k] += dual * push;
            }
            let size = step.iter().zip(&numbering.is_force).filter(|own| !own.1);
            let size = size.fold(0.0, |most: f64, (own, _)| most.max(own.abs()));
            if primal >= 1.0 && dual >= 1.0 && size < settled {
                return Some((state, walls, iteration));
            }
        }
        None
    }
}

/// How far a tube is from the wall around it.
struct Room {
    offset: Vector2<f64>,
    /// d/δ: towards the wall, of length 1 there.
    normal: Vector2<f64>,
    /// c.
    left: f64,
}

impl Room {
    fn of(state: &State, node: usize, follower: usize, gap: f64) -> Self {
        let offset = state.nodes[node].offset(follower);
        Self { offset, normal: offset / gap, left: 0.5 * (gap * gap - offset.norm_squared()) / gap }
    }

    /// Which part of a step leaves some of c.
    fn share(&self, step: &Vector2<f64>, gap: f64) -> f64 {
        let square = step.norm_squared();
        let along = self.offset.dot(step);
        let most = 2.0 * SHY * self.left * gap;
        if square + 2.0 * along < most {
            return 1.0;
        }
        // |d + s Δ|² = |d|² + most; the same as (√(…) − along)/square without the difference.
        most / (along + (along * along + square * most).sqrt())
    }
}

impl Evaluated {
    /// An element's energy.
    fn add(&mut self, state: &State, numbering: &Numbering, [place, tube]: [usize; 2], energy: &Number) {
        let sums = numbering.sums(state, place, tube);
        for i in 0..INPUTS {
            for &(row, a) in &sums[i] {
                self.gradient[row] += a * energy.slopes[i];
                for j in 0..INPUTS {
                    let bend = a * energy.bends[i][j];
                    for &(column, b) in &sums[j] {
                        self.matrix.add(row, column, b * bend);
                    }
                }
            }
        }
        // Places depend on the leader's turn and the offset in second order.
        for end in 0..2 {
            let node = place + end;
            let [_, turns] = numbering.leader(node);
            if tube == 0 || turns[0].is_none() {
                continue;
            }
            let first = PLACES[end];
            let matrix = state.nodes[node].turns[0].to_rotation_matrix();
            let force = matrix.inverse() * Vector3::from_fn(|i, _| energy.slopes[first + i]);
            let offset = state.nodes[node].offsets[tube];
            let arm = Vector3::new(0.0, offset.x, offset.y);
            let turned = (force * arm.transpose() + arm * force.transpose()) * 0.5
                - Matrix3::identity() * force.dot(&arm);
            for (i, row) in turns.iter().enumerate() {
                let Some(row) = *row else { continue };
                for (j, column) in turns.iter().enumerate() {
                    if let Some(column) = *column {
                        self.matrix.add(row, column, turned[(i, j)]);
                    }
                }
                for (axis, number) in numbering.offset(node, tube).into_iter().enumerate() {
                    let unit = if axis == 0 { Vector3::y() } else { Vector3::z() };
                    if let Some(column) = number {
                        let bend = unit.cross(&force)[i];
                        self.matrix.add(row, column, bend);
                        self.matrix.add(column, row, bend);
                    }
                }
            }
        }
    }
}
