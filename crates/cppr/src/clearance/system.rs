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
use super::mesh::{about, spin};
use super::state::{Numbering, State};
use crate::kinematics::so3::{about_x, hat};
use crate::statics::{Applied, Frame, Loads};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Nodes nearer than this part of the length are one.
pub(super) const SAME: f64 = 1e-7;

/// What a motor does: it pulls or turns with an effort, and with a spring that is at rest at a motion; or it holds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motor {
    pub holds: bool,
    pub effort: f64,
    pub stiffness: f64,
    pub motion: f64,
}

/// What does not change during a solve, scaled.
pub(super) struct Problem<'a> {
    /// From outside to inside.
    pub tubes: Vec<TubeFields<'a>>,
    /// Per pair of neighbours: gap between both; and per tube the thickness of its wall, which adds to the gaps on both sides beyond its tip.
    pub gaps: Vec<f64>,
    pub walls: Vec<f64>,
    /// Gap around tube 2 in the guide.
    pub guide: f64,
    /// Joints and free tips: tubes and labels.
    pub stations: Vec<Vec<(usize, f64)>>,
    /// How much tubes give way at joints for a force of 1.
    pub give: f64,
    /// Per tube: translation and rotation.
    pub motors: Vec<[Motor; 2]>,
    /// In units of the length and of EI/L²; gravity is a force per mass.
    pub loads: Loads,
}

/// Where an inner tube has play: a node, both tubes, and the gap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Play {
    pub node: usize,
    pub pair: [usize; 2],
    pub gap: f64,
}

/// Force of the wall at every node on every tube.
pub(super) type Walls = Vec<Vec<f64>>;

/// Gradient and tangent of the energy.
struct Evaluated {
    energy: f64,
    gradient: Vec<f64>,
    matrix: Banded,
    /// Per tube: force and torque of its motor.
    efforts: Vec<[f64; 2]>,
}

/// A solved state.
pub(super) struct Settled {
    pub state: State,
    pub walls: Walls,
    /// Potential of tubes and loads.
    pub energy: f64,
    /// Per tube: force and torque of its motor.
    pub efforts: Vec<[f64; 2]>,
    pub iterations: usize,
}

/// From one value of μ to the next, and where they begin and end, in units of EI/L (at the end of the softest tube) times the gap and the part of the length that a node has.
const FALL: f64 = 0.1;
const MOST: f64 = 1e3;
const LEAST: f64 = 1e-6;
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
    /// Gap between two tubes, where those between them have ended.
    pub fn gap(&self, [outer, inner]: [usize; 2]) -> f64 {
        self.gaps[outer..inner].iter().chain(&self.walls[outer + 1..inner]).sum()
    }

    /// Where inner tubes have play.
    pub fn plays(&self, state: &State) -> Vec<Play> {
        let mut plays = Vec::new();
        for (node, own) in state.nodes.iter().enumerate().skip(1) {
            for pair in state.pairs(node).filter(|pair| own.axes[pair[0]] != own.axes[pair[1]]) {
                let gap = match self.gap(pair) {
                    _ if node < state.guided && pair[0] == 0 => self.guide,
                    gap if node == state.guided && pair[0] == 0 => gap.min(self.guide),
                    gap => gap,
                };
                plays.push(Play { node, pair, gap });
            }
        }
        plays
    }

    /// Of every tube, whether its motor holds translation and rotation.
    fn held(&self) -> Vec<[bool; 2]> {
        self.motors.iter().map(|own| own.map(|motor| motor.holds)).collect()
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
            efforts: vec![[0.0; 2]; self.tubes.len()],
        };
        for (place, span) in state.spans.iter().enumerate() {
            for &tube in &span.tubes {
                let element = state.element(place, tube);
                let energy = element.energy(&self.tubes[tube], &self.spread(state, place, tube));
                own.energy += energy.value;
                if place == state.base(tube) {
                    // What motors hold has slopes all the same.
                    own.efforts[tube] = [energy.slopes[LABELS[0]], energy.slopes[TURNS[0]]];
                }
                own.add(state, numbering, [place, tube], &energy);
            }
        }
        self.add_loads(state, numbering, &mut own);
        for (tube, motors) in self.motors.iter().enumerate() {
            let node = state.base(tube);
            let start = &state.nodes[node];
            let pulled = start.labels[tube] - motors[0].motion;
            let turned = about(&(spin(-motors[1].motion) * start.turns[tube]));
            own.energy -= motors[0].effort * start.labels[tube];
            for ((motor, moved), number) in
                motors.iter().zip([pulled, turned]).zip(numbering.motor(node, tube))
            {
                if let Some(i) = number {
                    own.spring(i, motor.stiffness, moved);
                    own.gradient[i] -= motor.effort;
                }
            }
        }
        for (node, section) in state.nodes.iter().enumerate() {
            for &(tube, label) in &section.at.joined {
                if let Some(i) = numbering.label(node, tube) {
                    own.spring(i, 1.0 / self.give, section.labels[tube] - label);
                }
            }
        }
        own.energy.is_finite().then_some(own)
    }

    /// Concentrated loads.
    fn add_loads(&self, state: &State, numbering: &Numbering, to: &mut Evaluated) {
        let last = state.nodes.len() - 1;
        let mut put = |node: usize, of: &dyn Fn(&Matrix3<f64>, &Vector3<f64>) -> Applied| {
            let own = &state.nodes[node];
            let material = own.turns[own.frame].to_rotation_matrix().into_inner();
            let part = state.spans[node - 1].parts[own.frame];
            let phi = self.tubes[own.frame].direction(own.labels[own.frame], part);
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
            let numbers = numbering.section(node);
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
        for (own, node) in self.loads.wrenches.iter().zip(&state.loaded) {
            let Some(node) = *node else { continue };
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

    /// From tubes on one axis.
    pub fn settle(&self, mut start: State) -> Option<Settled> {
        let part = 1.0 / start.spans.len() as f64;
        let mut tau = MOST;
        let mut walls: Walls =
            start.nodes.iter().map(|_| self.tubes.iter().map(|_| 2.0 * tau * part).collect()).collect();
        start.bind(|pair| self.gap(pair) <= SAME);
        let mut state = start;
        let mut iterations = 0;
        let mut fall = FALL;
        let least = LEAST * self.tubes.iter().map(TubeFields::softest).fold(1.0, f64::min);
        let mut done: Option<(State, Walls, f64)> = None;
        loop {
            let last = tau <= least;
            let settled = if last { SETTLED } else { NEAR };
            if let Some((found, forces, steps)) =
                self.newton(state.clone(), walls.clone(), tau * part, settled)
            {
                iterations += steps;
                if last {
                    let numbering = Numbering::new(&found, &self.held());
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
            tau = (tau * fall).max(least);
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
        let numbering = Numbering::new(&state, &self.held());
        let plays = self.plays(&state);
        let mut now = self.evaluate(&state, &numbering)?;
        for iteration in 1..=STEPS {
            let Evaluated { gradient, mut matrix, .. } = now;
            let mut right: Vec<f64> = gradient.iter().map(|g| -g).collect();
            for &play in &plays {
                let Play { node, pair: [outer, inner], gap } = play;
                let (wall, room, out) = (walls[node][inner], Room::of(&state, &play), mu * gap);
                let block = nalgebra::Matrix2::identity() * (wall / gap)
                    + room.normal * room.normal.transpose() * (wall / room.left);
                let push = room.normal * (out / room.left);
                let ends =
                    [(inner, 1.0), (outer, -1.0)].map(|(tube, sign)| (numbering.offset(node, tube), sign));
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
            for &play in &plays {
                let Play { node, pair: [outer, inner], gap } = play;
                let of = |tube: usize| {
                    Vector2::from(numbering.offset(node, tube).map(|number| number.map_or(0.0, |i| step[i])))
                };
                let moved = of(inner) - of(outer);
                let (wall, room) = (walls[node][inner], Room::of(&state, &play));
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
                let ordered = (0..next.spans.len()).all(|element| next.advance(element) > 0.0);
                match ordered.then(|| self.evaluate(&next, &numbering)).flatten() {
                    Some(evaluated) => break (next, evaluated),
                    None if tried == HALVINGS => return None,
                    None => primal *= 0.5,
                }
                tried += 1;
            };
            for (play, push) in plays.iter().zip(&pushes) {
                walls[play.node][play.pair[1]] += dual * push;
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
    fn of(state: &State, &Play { node, pair, gap }: &Play) -> Self {
        let offset = state.nodes[node].offset(pair);
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
    /// A spring on an unknown, stretched so far.
    fn spring(&mut self, unknown: usize, stiffness: f64, stretched: f64) {
        self.energy += 0.5 * stiffness * stretched * stretched;
        self.gradient[unknown] += stiffness * stretched;
        self.matrix.add(unknown, unknown, stiffness);
    }

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
        for end in 0..2 {
            let node = place + end;
            if let (numbers, Some(column)) = numbering.twist(node, tube) {
                // Turned with the tube whose axis it shares, and then about the axis: both do not commute.
                let slopes = Vector3::from_fn(|i, _| energy.slopes[TURNS[end] + i]);
                let turned = state.nodes[node].turned[tube];
                for (axis, row) in numbers.into_iter().enumerate() {
                    let Some(row) = row else { continue };
                    let turn = turned.inverse() * Vector3::ith(axis, 1.0);
                    let bend = 0.5 * slopes.dot(&turn.cross(&Vector3::x()));
                    self.matrix.add(row, column, bend);
                    self.matrix.add(column, row, bend);
                }
            }
            // Places depend on the turn of the section and the offset in second order.
            let [_, turns] = numbering.section(node);
            let section = &state.nodes[node];
            if tube == section.frame || turns[0].is_none() {
                continue;
            }
            let first = PLACES[end];
            let matrix = section.turns[section.frame].to_rotation_matrix();
            let force = matrix.inverse() * Vector3::from_fn(|i, _| energy.slopes[first + i]);
            let offset = section.offsets[tube];
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
