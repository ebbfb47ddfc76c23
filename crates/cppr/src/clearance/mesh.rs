//! Nodes and elements between the places where something changes, which move with the pose: loads, edges, joints and tips.

use super::element::TubeFields;
use super::state::{Event, Node, Span, State};
use super::system::{Problem, SAME, Settled};
use crate::bundle::BundleTube;
use crate::bundle::solve::{BundleEquilibrium, BundleSolver};
use crate::statics::Station;
use nalgebra::{Rotation3, UnitQuaternion, Vector2, Vector3};
use std::f64::consts::PI;

/// Sections from which a start is interpolated.
const SECTIONS: f64 = 200.0;
/// Least part of the usual length that an element beside a moving edge has, and meshes that are tried.
const SHORTEST: f64 = 0.1;
const MESHES: usize = 8;
/// Part of the usual length below which two edges stand at one node, and where edges pass each other on the way.
const NARROW: [f64; 2] = [1e-3, 1e-2];
/// Elements that every stretch of the guide has at least.
const GUIDED: usize = 4;

/// A section of tubes on one axis, scaled.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Length of the centreline from the plate.
    place: f64,
    centre: Vector3<f64>,
    /// A frame along the tangent.
    turn: UnitQuaternion<f64>,
    /// Per tube: turn of its material against the frame, its label (it goes on beyond its tip), and the force it carries.
    twists: Vec<f64>,
    labels: Vec<f64>,
    forces: Vec<Vector3<f64>>,
}

/// An angle but for full turns, nearest to another.
pub(super) fn near(angle: f64, other: f64) -> f64 {
    angle - 2.0 * PI * ((angle - other) / (2.0 * PI)).round()
}

/// Turn about X of a rotation that is nearly one.
pub(super) fn about(turn: &UnitQuaternion<f64>) -> f64 {
    2.0 * turn.i.atan2(turn.w)
}

pub(super) fn spin(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle)
}

impl Row {
    /// Sections of an equilibrium without clearance.
    pub fn of(solver: &BundleSolver, start: &BundleEquilibrium, length: f64, force: f64) -> Vec<Self> {
        let mut rows: Vec<Self> = Vec::new();
        for section in solver.shape(start, start.length / SECTIONS) {
            let place = section.length / length;
            let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(section.frame));
            let tangent = turn * Vector3::x();
            let mut row = match rows.last() {
                Some(last) if place - last.place < SAME => continue,
                Some(last) => last.beyond(place),
                None => Self {
                    place,
                    centre: section.centre,
                    turn,
                    twists: start.efforts.iter().map(|own| own.rotation).collect(),
                    labels: start.efforts.iter().map(|own| own.label / length).collect(),
                    forces: vec![Vector3::zeros(); start.efforts.len()],
                },
            };
            (row.centre, row.turn) = (section.centre / length, turn);
            for own in &section.tubes {
                row.twists[own.tube] = own.rotation;
                row.labels[own.tube] = own.label / length;
                row.forces[own.tube] = tangent * (own.tension / force);
            }
            rows.push(row);
        }
        rows
    }

    /// Further along, straight on.
    fn beyond(&self, place: f64) -> Self {
        let way = place - self.place;
        let mut own = self.clone();
        own.place = place;
        own.centre += self.turn * Vector3::x() * way;
        for label in &mut own.labels {
            *label += way;
        }
        own
    }

    /// Between rows; below the first one all goes on straight.
    fn at(rows: &[Self], place: f64) -> Self {
        if place <= rows[0].place {
            return rows[0].beyond(place);
        }
        let next = rows.partition_point(|row| row.place < place).clamp(1, rows.len() - 1);
        let (a, b) = (&rows[next - 1], &rows[next]);
        let share = (place - a.place) / (b.place - a.place);
        let mix = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + share * (b - a)).collect();
        Self {
            place,
            centre: a.centre.lerp(&b.centre, share),
            turn: a.turn.nlerp(&b.turn, share),
            twists: mix(&a.twists, &b.twists),
            labels: mix(&a.labels, &b.labels),
            forces: a.forces.iter().zip(&b.forces).map(|(a, b)| a.lerp(b, share)).collect(),
        }
    }

    /// Where a label of a tube stands.
    fn find(rows: &[Self], tube: usize, label: f64) -> f64 {
        let next = rows.partition_point(|row| row.labels[tube] < label);
        if next == 0 {
            return rows[0].place - (rows[0].labels[tube] - label);
        }
        let next = next.min(rows.len() - 1);
        let (a, b) = (&rows[next - 1], &rows[next]);
        let share = (label - a.labels[tube]) / (b.labels[tube] - a.labels[tube]);
        a.place + share.min(1.0) * (b.place - a.place)
    }
}

/// Solves on meshes that end elements where something changes, until these stand well. `below` is the length of the guide.
pub(super) fn remeshed(problem: &Problem, elements: usize, below: f64, rows: &[Row]) -> Option<Settled> {
    NARROW.into_iter().find_map(|narrow| {
        let mut rows = rows.to_vec();
        for _ in 0..MESHES {
            let places = Places::new(problem, elements, below, &rows, narrow);
            let found = problem.settle(places.mesh(problem, &rows))?;
            rows = found.state.rows();
            if found.state.stands(problem, places.usual, narrow)
                && Places::new(problem, elements, below, &rows, narrow).meet_as(&places)
            {
                return Some(found);
            }
        }
        None
    })
}

/// Where something changes, and what.
#[derive(Clone, Debug)]
struct Stop {
    place: f64,
    /// Tubes whose labels are given, and these.
    held: Vec<(usize, f64)>,
    joined: bool,
    /// Tubes that end here.
    ends: Vec<usize>,
    /// Loads by number.
    loads: Vec<usize>,
}

impl Stop {
    /// May another one stand at the same node? Two joints may not, and not two labels of one tube.
    fn admits(&self, other: &Self, narrow: f64) -> bool {
        let apart =
            |own: &(usize, f64)| other.held.iter().any(|to| to.0 == own.0 && (to.1 - own.1).abs() > SAME);
        (other.place - self.place).abs() < narrow
            && !(self.joined && other.joined)
            && !self.held.iter().any(apart)
    }
}

/// Stretches between changes.
struct Places {
    stops: Vec<Stop>,
    /// Per tube, where it ends.
    tips: Vec<f64>,
    base: f64,
    /// Usual length of an element.
    usual: f64,
}

impl Places {
    fn new(problem: &Problem, elements: usize, below: f64, rows: &[Row], narrow: f64) -> Self {
        let end = rows[rows.len() - 1].place;
        let (base, usual) = (-below, end / elements as f64);
        let ends = |held: &[(usize, f64)]| {
            let ends = held.iter().filter(|own| own.1 >= problem.tubes[own.0].tip() - SAME);
            ends.map(|own| own.0).collect()
        };
        let stop = |held: Vec<(usize, f64)>| Stop {
            place: Row::find(rows, held[0].0, held[0].1),
            joined: held.len() > 1,
            ends: ends(&held),
            held,
            loads: Vec::new(),
        };
        // Joints and tips before what may stand at one node with them.
        let mut stops: Vec<Stop> = problem.stations.iter().map(|own| stop(own.clone())).collect();
        for (number, own) in problem.loads.wrenches.iter().enumerate() {
            if let Station::Label(label) = own.station {
                stops.push(Stop { loads: vec![number], ..stop(vec![(0, label)]) });
            }
        }
        let spread = problem.loads.distributed.iter().flat_map(|own| [own.from, own.to]);
        stops.extend(spread.map(|label| stop(vec![(0, label)])));
        for (tube, own) in problem.tubes.iter().enumerate() {
            let jumps = own.tube.pieces.iter().filter(|piece| piece.jumps && piece.to < own.tube.tip);
            stops.extend(jumps.map(|piece| stop(vec![(tube, piece.to / own.units[0])])));
        }
        let least = narrow * usual;
        let guided =
            |own: &Stop| below > 0.0 && own.held.iter().all(|own| own.0 > 0) && own.place > base + least;
        // What stands nearer to the plate than this stands at it.
        stops.retain(|own| own.place > least || guided(own) && own.place < -least);
        let mut met: Vec<Stop> = Vec::new();
        for own in stops {
            match met.iter_mut().find(|to| to.admits(&own, least)) {
                Some(to) => {
                    to.loads.extend(own.loads);
                    to.ends.extend(own.ends);
                }
                None => met.push(own),
            }
        }
        met.sort_by(|a, b| a.place.total_cmp(&b.place));
        // A tube that is drawn in behind the plate is nowhere.
        let mut tips = vec![f64::NEG_INFINITY; problem.tubes.len()];
        for own in &met {
            for tube in &own.ends {
                tips[*tube] = own.place;
            }
        }
        Self { stops: met, tips, base, usual }
    }

    /// Do the same tubes meet the same changes in the same order?
    fn meet_as(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|own| own.stops.iter().map(|stop| &stop.held));
        a.eq(b)
    }

    /// Straight tubes on one axis, where the rows say.
    fn mesh(&self, problem: &Problem, rows: &[Row]) -> State {
        let mut ends: Vec<(f64, Option<&Stop>)> = vec![(self.base, None)];
        let (below, above) = self.stops.split_at(self.stops.partition_point(|own| own.place < 0.0));
        ends.extend(below.iter().map(|own| (own.place, Some(own))));
        if self.base < 0.0 {
            ends.push((0.0, None));
        }
        ends.extend(above.iter().map(|own| (own.place, Some(own))));
        let mut places: Vec<(f64, Option<&Stop>, bool)> = Vec::new();
        for pair in ends.windows(2) {
            let (from, to) = (pair[0], pair[1].0);
            // As many as come near the usual length.
            let wanted = (to - from.0) / self.usual;
            let mut count = if from.0 < 0.0 { GUIDED } else { 1 };
            while count as f64 + 0.5 <= wanted {
                count += 1;
            }
            places.push((from.0, from.1, false));
            let between = (1..count).map(|i| from.0 + (to - from.0) * i as f64 / count as f64);
            places.extend(between.map(|place| (place, None, true)));
        }
        places.extend(ends.last().map(|own| (own.0, own.1, false)));
        let all = problem.tubes.len();
        let spans: Vec<Span> = places
            .windows(2)
            .map(|pair| {
                let middle = 0.5 * (pair[0].0 + pair[1].0);
                let own = Row::at(rows, middle);
                let [from, to] = [0, 1].map(|i| Row::at(rows, pair[i].0));
                let turn = |row: &Row, tube: usize| row.turn * spin(row.twists[tube]);
                let tubes = (0..all)
                    .filter(|tube| middle < self.tips[*tube] && (*tube > 0 || middle > 0.0))
                    .collect();
                let parts = problem.tubes.iter().zip(&own.labels);
                Span {
                    tubes,
                    middles: (0..all)
                        .map(|tube| (turn(&from, tube).inverse() * turn(&to, tube)).scaled_axis() * 0.5)
                        .collect(),
                    forces: own.forces,
                    parts: parts.map(|(tube, label)| stretch(tube.tube, label * tube.units[0])).collect(),
                }
            })
            .collect();
        let guided = places.iter().filter(|own| own.0 < 0.0).count();
        let last = Some(places.len() - 1);
        let wrenches = problem.loads.wrenches.iter();
        let mut loaded: Vec<Option<usize>> =
            wrenches.map(|own| if own.station == Station::Tip { last } else { None }).collect();
        let mut nodes: Vec<Node> = Vec::with_capacity(places.len());
        for (number, (place, stop, between)) in places.into_iter().enumerate() {
            let Row { centre, turn, twists, mut labels, .. } = Row::at(rows, place);
            let straight = place <= 0.0;
            let span = if number > guided { number - 1 } else { number };
            let frame = if number < guided { 0 } else { spans[span].tubes[0] };
            let mut at = Event { between, ..Event::default() };
            if let Some(stop) = stop {
                for load in &stop.loads {
                    loaded[*load] = Some(number);
                }
                for (tube, label) in &stop.held {
                    labels[*tube] = *label;
                }
                at.joined = if stop.joined { stop.held.clone() } else { Vec::new() };
                let held = if problem.give > 0.0 { &stop.held[..1] } else { &stop.held[..] };
                at.held = held.iter().map(|own| own.0).collect();
            } else if between && !straight {
                at.held = vec![frame];
            }
            let leader = if straight { UnitQuaternion::identity() } else { turn };
            let mut turns: Vec<_> = twists.iter().map(|twist| leader * spin(*twist)).collect();
            for (tube, _) in &at.joined {
                turns[*tube] = turns[at.joined[0].0];
            }
            nodes.push(Node {
                frame,
                centre: if straight { Vector3::x() * place } else { centre },
                turns,
                labels,
                offsets: vec![Vector2::zeros(); all],
                axes: (0..all).collect(),
                turned: vec![UnitQuaternion::identity(); all],
                at,
            });
        }
        State { nodes, spans, guided, loaded }
    }
}

/// First and last piece of the stretch without jumps around a label (m).
fn stretch(tube: &BundleTube, label: f64) -> [usize; 2] {
    let pieces = &tube.pieces;
    let own = pieces.partition_point(|piece| piece.to <= label).min(pieces.len() - 1);
    let first = pieces[..own].iter().rposition(|piece| piece.jumps).map_or(0, |before| before + 1);
    let last =
        pieces[own..].iter().position(|piece| piece.jumps).map_or(pieces.len() - 1, |after| own + after);
    [first, last]
}

impl State {
    /// What another mesh starts from.
    fn rows(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = Vec::with_capacity(self.nodes.len());
        for (number, node) in self.nodes.iter().enumerate().skip(self.guided) {
            let at = rows.last().map_or(0.0, |last| last.place + self.advance(number - 1));
            let mut row = match rows.last() {
                Some(last) => last.beyond(at),
                None => Row {
                    place: at,
                    centre: node.centre,
                    turn: UnitQuaternion::identity(),
                    twists: node.turns.iter().map(about).collect(),
                    labels: node.labels.clone(),
                    forces: Vec::new(),
                },
            };
            // The outermost tube keeps its turn against the frame.
            row.turn = node.turns[node.frame] * spin(-row.twists[node.frame]);
            row.centre = node.centre;
            for &tube in self.tubes(number) {
                let twist = about(&(row.turn.inverse() * node.turns[tube]));
                row.twists[tube] = near(twist, row.twists[tube]);
                row.labels[tube] = node.labels[tube];
            }
            row.forces.clone_from(&self.spans[number.min(self.spans.len() - 1)].forces);
            rows.push(row);
        }
        rows
    }

    /// Are elements beside what moves neither too short nor too long, and is every one on its own side of all edges?
    fn stands(&self, problem: &Problem, usual: f64, narrow: f64) -> bool {
        (0..self.spans.len()).all(|number| {
            let (span, pair) = (&self.spans[number], &self.nodes[number..number + 2]);
            // Where two things happen near each other, what is between them is short, and a short guide has as many elements as a long one.
            let filled = number >= self.guided && pair.iter().any(|node| node.at.between);
            let least = if filled { SHORTEST } else { 0.0 };
            let fits = (least..2.0).contains(&(self.advance(number) / usual));
            fits && span.tubes.iter().all(|&tube| {
                let TubeFields { tube: own, units: [length, _], .. } = problem.tubes[tube];
                let middle = 0.5 * (pair[0].labels[tube] + pair[1].labels[tube]) * length;
                let at = stretch(own, middle);
                let close = |label: f64| (label - middle).abs() < narrow * usual * length;
                at == span.parts[tube]
                    || close(own.pieces[at[1]].to)
                    || at[0] > 0 && close(own.pieces[at[0] - 1].to)
            })
        })
    }
}
