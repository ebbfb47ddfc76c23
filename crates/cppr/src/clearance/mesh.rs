//! Nodes and elements between the places where something changes: loads, the plate, and the edges of followers, which move.

use super::state::{Node, Span, State};
use super::system::{Problem, SAME, Settled};
use crate::design::fields::Part;
use crate::kinematics::so3::about_x;
use crate::solve::{Equilibrium, Solver};
use crate::statics::Station;
use nalgebra::{Rotation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;

/// Sections from which a start is interpolated.
const SECTIONS: usize = 201;
/// Least part of the usual length that an element beside a moving edge has, and has at first next to the base; meshes that are tried.
const SHORTEST: f64 = 0.1;
const NARROW: f64 = 1e-3;
const MESHES: usize = 8;
/// Elements that every stretch of the guide has at least.
const GUIDED: usize = 4;

/// A section of tubes on one axis, scaled.
#[derive(Clone, Debug)]
pub(super) struct Row {
    label: f64,
    centre: Vector3<f64>,
    /// Of the leader's material.
    turn: UnitQuaternion<f64>,
    /// Per tube: turn of its material against the leader's about the axis, its label, and the force it carries.
    twists: Vec<f64>,
    abscissae: Vec<f64>,
    forces: Vec<Vector3<f64>>,
}

/// An angle but for full turns, nearest to another.
pub(super) fn near(angle: f64, other: f64) -> f64 {
    angle - 2.0 * PI * ((angle - other) / (2.0 * PI)).round()
}

/// Turn about X of a rotation that is nearly one.
fn about(turn: &UnitQuaternion<f64>) -> f64 {
    2.0 * turn.i.atan2(turn.w)
}

fn spin(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle)
}

impl Row {
    /// Sections of an equilibrium without clearance.
    pub fn of(solver: &mut Solver, start: &Equilibrium, force: f64) -> Vec<Self> {
        let robot = start.robot();
        let length = robot.length();
        let mut rows: Vec<Self> = Vec::with_capacity(SECTIONS);
        for section in solver.shape(start, SECTIONS).sections {
            let turns = section.tubes.iter().zip(robot.fields()).map(|(own, fields)| {
                let part = if own.abscissa < 0.0 { Part::Below } else { Part::Pattern };
                let [phi, ..] = fields.direction(own.abscissa, part);
                UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                    own.rotation * about_x(-phi),
                ))
            });
            let turns: Vec<UnitQuaternion<f64>> = turns.collect();
            let before = rows.last().map(|row| row.twists.clone());
            let commanded = start.actuators().iter().map(|own| own.rotation);
            let before = before.unwrap_or_else(|| std::iter::once(0.0).chain(commanded).collect());
            let twists = turns.iter().zip(before);
            rows.push(Self {
                label: section.label / length,
                centre: section.centre / length,
                turn: turns[0],
                twists: twists
                    .map(|(own, before)| near(about(&(turns[0].inverse() * own)), before))
                    .collect(),
                abscissae: section.tubes.iter().map(|own| own.abscissa / length).collect(),
                forces: section.tubes.iter().map(|own| own.rotation * own.force / force).collect(),
            });
        }
        rows
    }

    /// Between rows; below the first one all goes on straight.
    fn at(rows: &[Self], label: f64) -> Self {
        let below = label - rows[0].label;
        if below < 0.0 {
            let mut own = rows[0].clone();
            own.label = label;
            own.centre.x += below;
            for abscissa in &mut own.abscissae {
                *abscissa += below;
            }
            return own;
        }
        let next = rows.partition_point(|row| row.label < label).clamp(1, rows.len() - 1);
        let (a, b) = (&rows[next - 1], &rows[next]);
        let share = (label - a.label) / (b.label - a.label);
        let mix = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect();
        Self {
            label,
            centre: a.centre.lerp(&b.centre, share),
            turn: a.turn.nlerp(&b.turn, share),
            twists: mix(&a.twists, &b.twists),
            abscissae: mix(&a.abscissae, &b.abscissae),
            forces: a.forces.iter().zip(&b.forces).map(|(a, b)| a.lerp(b, share)).collect(),
        }
    }
}

/// Solves on meshes that end elements where edges stand, until these stand well. `below` is the length of the guide.
pub(super) fn remeshed(
    problem: &Problem,
    elements: usize,
    below: f64,
    mut rows: Vec<Row>,
) -> Option<Settled> {
    let usual = 1.0 / elements as f64;
    for _ in 0..MESHES {
        let found = problem.settle(mesh(problem, elements, below, &rows))?;
        let State { nodes, spans, guided } = &found.state;
        let stands = |place: usize| {
            let pair = &nodes[place..place + 2];
            let moves = pair.iter().any(|node| node.edge.is_some());
            // What an edge near the base, the plate or the tip leaves is short.
            let beside = place == 0 || place + 2 == nodes.len() || place == *guided || place + 1 == *guided;
            let least = if beside { 0.0 } else { SHORTEST };
            !moves || (least..2.0).contains(&((pair[1].labels[0] - pair[0].labels[0]) / usual))
        };
        let faced = spans.iter().zip(nodes.windows(2)).all(|(span, pair)| {
            span.parts.iter().enumerate().skip(1).all(|(tube, part)| {
                let middle = 0.5 * (pair[0].labels[tube] + pair[1].labels[tube]);
                problem.tubes[tube].fields.smooth_at_plate()
                    || middle.abs() < SAME
                    || (*part == Part::Below) == (middle < 0.0)
            })
        });
        if faced && (0..spans.len()).all(stands) {
            return Some(found);
        }
        rows = found.state.rows();
    }
    None
}

/// Straight tubes on the axis of the leader, at the labels of a start.
fn mesh(problem: &Problem, elements: usize, below: f64, rows: &[Row]) -> State {
    let base = -below;
    let mut ends: Vec<(f64, Option<usize>)> = vec![(base, None), (0.0, None), (1.0, None)];
    let usual = 1.0 / elements as f64;
    for (tube, own) in problem.tubes.iter().enumerate().skip(1) {
        if own.fields.smooth_at_plate() || Row::at(rows, base).abscissae[tube] > -NARROW * usual {
            // An edge that stands nearer to the base than this stands at it.
            continue;
        }
        let (mut low, mut high) = (base, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if Row::at(rows, middle).abscissae[tube] < 0.0 { low = middle } else { high = middle }
        }
        if below <= 0.0 {
            ends.push((low.max(NARROW * usual), Some(tube)));
        } else if low.abs() > NARROW * usual {
            ends.push((low, Some(tube)));
        }
    }
    ends.extend(problem.loads.wrenches.iter().filter_map(|own| match own.station {
        Station::Label(label) => Some((label, None)),
        Station::Tip => None,
    }));
    ends.extend(problem.loads.distributed.iter().flat_map(|own| [(own.from, None), (own.to, None)]));
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    ends.dedup_by(|a, b| a.0 - b.0 < SAME && a.1.is_none() && b.1.is_none());
    let mut labels: Vec<(f64, Option<usize>)> = Vec::with_capacity(elements + 8);
    for pair in ends.windows(2) {
        let (from, to) = (pair[0], pair[1].0);
        // As many as come near the usual length.
        let wanted = (to - from.0) * elements as f64;
        let fewest = if from.0 < 0.0 { GUIDED } else { 1 };
        let count = (fewest..=elements).find(|count| *count as f64 + 0.5 > wanted).unwrap_or(elements);
        labels.push(from);
        labels.extend((1..count).map(|i| (from.0 + (to - from.0) * i as f64 / count as f64, None)));
    }
    labels.extend(ends.last());
    let tubes = problem.tubes.len();
    let node = |&(label, edge): &(f64, Option<usize>)| {
        let own = Row::at(rows, label);
        let straight = label <= 0.0;
        let leader = if straight { UnitQuaternion::identity() } else { own.turn };
        let tip = label >= 1.0;
        let mut abscissae = own.abscissae;
        abscissae[0] = label;
        if let Some(tube) = edge {
            abscissae[tube] = 0.0;
        }
        Node {
            centre: if straight { Vector3::x() * label } else { own.centre },
            turns: own.twists.iter().map(|twist| if tip { leader } else { leader * spin(*twist) }).collect(),
            labels: if tip { vec![1.0; tubes] } else { abscissae },
            offsets: vec![Vector2::zeros(); tubes],
            edge,
        }
    };
    let nodes: Vec<Node> = labels.iter().map(node).collect();
    let spans = nodes.windows(2).map(|pair| {
        let own = Row::at(rows, 0.5 * (pair[0].labels[0] + pair[1].labels[0]));
        let turned = |tube: usize| (pair[0].turns[tube].inverse() * pair[1].turns[tube]).scaled_axis() * 0.5;
        Span {
            middles: (0..tubes).map(turned).collect(),
            forces: own.forces,
            parts: own.abscissae.iter().map(|x| if *x < 0.0 { Part::Below } else { Part::Pattern }).collect(),
        }
    });
    let spans = spans.collect();
    let guided = labels.iter().filter(|own| own.0 < 0.0).count();
    State { nodes, spans, guided }
}

impl State {
    /// What another mesh starts from.
    pub fn rows(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = Vec::with_capacity(self.nodes.len());
        for (place, node) in self.nodes.iter().enumerate() {
            let twists = node.turns.iter().enumerate().map(|(tube, own)| {
                let twist = about(&(node.turns[0].inverse() * own));
                rows.last().map_or(twist, |row| near(twist, row.twists[tube]))
            });
            let twists = twists.collect();
            rows.push(Row {
                label: node.labels[0],
                centre: node.centre,
                turn: node.turns[0],
                twists,
                abscissae: node.labels.clone(),
                forces: self.spans[place.min(self.spans.len() - 1)].forces.clone(),
            });
        }
        rows
    }
}
