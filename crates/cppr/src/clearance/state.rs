//! Unknowns of a bundle with clearance: nodes and elements along the leader, and which of their values are free.

use super::element::{Element, FORCE, INPUTS, LABELS, MIDDLE, PLACES, TURNS};
use crate::design::fields::Part;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// A section of the leader with what lies beside it (scaled). Below the plate stands a straight guide in place of the leader.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Centre of the leader.
    pub centre: Vector3<f64>,
    /// Per tube: rotation of its material against that of the straight tube at rest, label, and axis beside the leader's, along the leader's material axes Y and Z.
    pub turns: Vec<UnitQuaternion<f64>>,
    pub labels: Vec<f64>,
    pub offsets: Vec<Vector2<f64>>,
    /// The tube whose edge stands here: its label is 0, and the leader's is unknown.
    pub edge: Option<usize>,
}

impl Node {
    /// From the leader's centre to the axis of a tube, in the leader's material axes.
    fn arm(&self, tube: usize) -> Vector3<f64> {
        Vector3::new(0.0, self.offsets[tube].x, self.offsets[tube].y)
    }

    /// Where the axis of a tube is.
    pub fn place(&self, tube: usize) -> Vector3<f64> {
        self.centre + self.turns[0] * self.arm(tube)
    }

    /// Offset of a follower's axis (from 0) against that of the tube around it.
    pub fn offset(&self, follower: usize) -> Vector2<f64> {
        self.offsets[follower + 1] - self.offsets[follower]
    }
}

/// What belongs to an element alone.
#[derive(Clone, Debug)]
pub(super) struct Span {
    /// Per tube: rotation vector of its middle against its first end, the force it carries, and where its labels are.
    pub middles: Vec<Vector3<f64>>,
    pub forces: Vec<Vector3<f64>>,
    pub parts: Vec<Part>,
}

/// A shape.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub nodes: Vec<Node>,
    pub spans: Vec<Span>,
    /// How many elements lie below the plate, in the guide.
    pub guided: usize,
}

impl State {
    pub fn tubes(&self) -> usize {
        self.nodes.first().map_or(0, |node| node.turns.len())
    }

    /// Tubes that have the element.
    pub fn present(&self, element: usize) -> std::ops::Range<usize> {
        usize::from(element < self.guided)..self.tubes()
    }

    /// An element of one tube.
    pub fn element(&self, element: usize, tube: usize) -> Element {
        let (ends, span) = (&self.nodes[element..element + 2], &self.spans[element]);
        Element {
            turns: [0, 1].map(|i| ends[i].turns[tube]),
            middle: span.middles[tube],
            labels: [0, 1].map(|i| ends[i].labels[tube]),
            force: span.forces[tube],
            places: [0, 1].map(|i| ends[i].place(tube)),
            part: span.parts[tube],
        }
    }
}

/// What is held.
pub(super) struct Held {
    /// Per follower: are push-pull and rotation of its motor held, not driven by force and torque?
    pub motors: Vec<[bool; 2]>,
    /// Per follower: has it no gap around it?
    pub tight: Vec<bool>,
}

type Three = [Option<usize>; 3];

struct NodeNumbers {
    centre: Three,
    turns: Vec<Three>,
    labels: Vec<Option<usize>>,
    offsets: Vec<[Option<usize>; 2]>,
}

struct SpanNumbers {
    middles: Vec<Three>,
    forces: Vec<Three>,
}

/// Which number in the system every value of a state has, if it is free.
pub(super) struct Numbering {
    pub count: usize,
    /// Diagonals on either side.
    pub reach: usize,
    /// Which of them are forces: no motions.
    pub is_force: Vec<bool>,
    nodes: Vec<NodeNumbers>,
    spans: Vec<SpanNumbers>,
}

/// An input of an element as a sum of unknowns with factors.
pub(super) type Sum = Vec<(usize, f64)>;

impl Numbering {
    pub fn new(state: &State, held: &Held) -> Self {
        let (mut count, tubes, last) = (0, state.tubes(), state.nodes.len() - 1);
        let mut is_force = Vec::new();
        let mut next = |force: bool| {
            count += 1;
            is_force.push(force);
            Some(count - 1)
        };
        let (mut nodes, mut spans): (Vec<NodeNumbers>, Vec<SpanNumbers>) = (Vec::new(), Vec::new());
        for (place, node) in state.nodes.iter().enumerate() {
            let free = place > state.guided;
            // The motors hold the lowest section.
            let lowest = place == 0;
            let leader = node.edge.and_then(|_| next(false));
            let mut own = NodeNumbers {
                centre: if free { [(); 3].map(|()| next(false)) } else { [leader, None, None] },
                turns: vec![[(); 3].map(|()| if free { next(false) } else { None })],
                labels: vec![leader],
                offsets: vec![[None; 2]],
            };
            for k in 0..tubes - 1 {
                let [pulled, turned] = held.motors[k];
                own.turns.push(if place == last {
                    own.turns[0]
                } else if lowest {
                    [if turned { None } else { next(false) }, None, None]
                } else {
                    [(); 3].map(|()| next(false))
                });
                own.offsets.push(if held.tight[k] {
                    own.offsets[k]
                } else if place == last || lowest {
                    [None; 2]
                } else {
                    [(); 2].map(|()| next(false))
                });
                let fixed = place == last || lowest && pulled || node.edge == Some(k + 1);
                own.labels.push(if fixed { None } else { next(false) });
            }
            nodes.push(own);
            if place < last {
                let mut of = |force: bool| {
                    let present = state.present(place);
                    let own =
                        |tube| [(); 3].map(|()| if present.contains(&tube) { next(force) } else { None });
                    (0..tubes).map(own).collect()
                };
                spans.push(SpanNumbers { middles: of(false), forces: of(true) });
            }
        }
        let mut numbering = Self { count, reach: 0, is_force, nodes, spans };
        for element in 0..numbering.spans.len() {
            let all = state.present(element).flat_map(|tube| numbering.sums(state, element, tube)).flatten();
            let (low, high) = all.fold((usize::MAX, 0), |(low, high), (i, _)| (low.min(i), high.max(i)));
            numbering.reach = numbering.reach.max(high.saturating_sub(low));
        }
        numbering
    }

    /// What the inputs of an element are.
    pub fn sums(&self, state: &State, element: usize, tube: usize) -> [Sum; INPUTS] {
        let mut sums: [Sum; INPUTS] = Default::default();
        let mut put = |first: usize, three: &Three| {
            for (i, number) in three.iter().enumerate() {
                sums[first + i].extend(number.map(|number| (number, 1.0)));
            }
        };
        let (ends, span) = (&self.nodes[element..element + 2], &self.spans[element]);
        put(MIDDLE, &span.middles[tube]);
        put(FORCE, &span.forces[tube]);
        for (end, own) in ends.iter().enumerate() {
            put(TURNS[end], &own.turns[tube]);
            put(PLACES[end], &own.centre);
        }
        for (end, own) in ends.iter().enumerate() {
            sums[LABELS[end]].extend(own.labels[tube].map(|number| (number, 1.0)));
            let node = &state.nodes[element + end];
            let matrix = node.turns[0].to_rotation_matrix();
            let arm = node.arm(tube);
            for i in 0..3 {
                let sum = &mut sums[PLACES[end] + i];
                for axis in 0..2 {
                    sum.extend(own.offsets[tube][axis].map(|number| (number, matrix[(i, axis + 1)])));
                }
                if tube > 0 {
                    // A small turn δ of the leader moves the place by R (δ×arm).
                    let turned = arm.cross(&Vector3::from(matrix.matrix().row(i).transpose()));
                    for (axis, number) in own.turns[0].iter().enumerate() {
                        sum.extend(number.map(|number| (number, turned[axis])));
                    }
                }
            }
        }
        sums
    }

    /// Of the leader at a node: its centre and its turn.
    pub fn leader(&self, node: usize) -> [Three; 2] {
        [self.nodes[node].centre, self.nodes[node].turns[0]]
    }

    /// Of a tube's offset at a node.
    pub fn offset(&self, node: usize, tube: usize) -> [Option<usize>; 2] {
        self.nodes[node].offsets[tube]
    }

    /// Of a follower's label and turn about its axis where its motor holds it.
    pub fn motor(&self, follower: usize) -> [Option<usize>; 2] {
        [self.nodes[0].labels[follower + 1], self.nodes[0].turns[follower + 1][0]]
    }

    /// The state moved by a share of a step.
    pub fn moved(&self, state: &State, step: &[f64], share: f64) -> State {
        let mut state = state.clone();
        let one = |number: Option<usize>| number.map_or(0.0, |i| share * step[i]);
        let three = |numbers: &Three| Vector3::from(numbers.map(one));
        for (node, own) in state.nodes.iter_mut().zip(&self.nodes) {
            node.centre += three(&own.centre);
            for (turn, numbers) in node.turns.iter_mut().zip(&own.turns) {
                *turn *= UnitQuaternion::from_scaled_axis(three(numbers));
                turn.renormalize();
            }
            for (label, number) in node.labels.iter_mut().zip(&own.labels) {
                *label += one(*number);
            }
            for (offset, numbers) in node.offsets.iter_mut().zip(&own.offsets) {
                *offset += Vector2::from(numbers.map(one));
            }
        }
        for (span, own) in state.spans.iter_mut().zip(&self.spans) {
            for (middle, numbers) in span.middles.iter_mut().zip(&own.middles) {
                *middle += three(numbers);
            }
            for (force, numbers) in span.forces.iter_mut().zip(&own.forces) {
                *force += three(numbers);
            }
        }
        state
    }

    /// Greatest turn in a step (rad).
    pub fn turn(&self, step: &[f64]) -> f64 {
        let all = self.nodes.iter().flat_map(|node| node.turns.iter().flatten().flatten());
        all.fold(0.0, |most: f64, i| most.max(step[*i].abs()))
    }
}
