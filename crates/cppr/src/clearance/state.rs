//! Unknowns of a bundle with clearance: nodes and elements along it, and which of their values are free.

use super::element::{Element, FORCE, INPUTS, LABELS, MIDDLE, PLACES, TURNS};
use super::mesh::spin;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// A section of the bundle: that of its outermost tube, with what lies beside it (scaled). Below the plate stands a straight guide in its place.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The outermost tube, whose material axes are those of the section; tube 0 in the guide.
    pub frame: usize,
    /// Its centre.
    pub centre: Vector3<f64>,
    /// Per tube: rotation of its material against that of the straight tube at rest, label, and axis beside the outermost one's, along the axes Y and Z of the section.
    pub turns: Vec<UnitQuaternion<f64>>,
    pub labels: Vec<f64>,
    pub offsets: Vec<Vector2<f64>>,
    /// Per tube: the outermost of those with which it has one axis, and one tangent, here.
    pub axes: Vec<usize>,
    /// How it is turned against that one.
    pub turned: Vec<UnitQuaternion<f64>>,
    pub at: Event,
}

/// What a node stands at.
#[derive(Clone, Debug, Default)]
pub(super) struct Event {
    /// Tubes whose labels are given.
    pub held: Vec<usize>,
    /// Tubes that are joined, with their labels, from outside to inside.
    pub joined: Vec<(usize, f64)>,
    /// Is it one of the nodes with which elements fill up a stretch, and stands at nothing?
    pub between: bool,
}

impl Node {
    /// From the centre to the axis of a tube, in the section's axes.
    fn arm(&self, tube: usize) -> Vector3<f64> {
        Vector3::new(0.0, self.offsets[tube].x, self.offsets[tube].y)
    }

    /// Where the axis of a tube is.
    pub fn place(&self, tube: usize) -> Vector3<f64> {
        self.centre + self.turns[self.frame] * self.arm(tube)
    }

    /// Is a tube joined to others here?
    pub fn joins(&self, tube: usize) -> bool {
        self.at.joined.iter().any(|own| own.0 == tube)
    }

    /// Offset of a tube's axis against that of one around it.
    pub fn offset(&self, [outer, inner]: [usize; 2]) -> Vector2<f64> {
        self.offsets[inner] - self.offsets[outer]
    }
}

/// What belongs to an element alone.
#[derive(Clone, Debug)]
pub(super) struct Span {
    /// Tubes that have it, from outside to inside.
    pub tubes: Vec<usize>,
    /// Per tube: rotation vector of its middle against its first end, the force it carries, and the first and the last piece of the stretch without jumps that its labels are on.
    pub middles: Vec<Vector3<f64>>,
    pub forces: Vec<Vector3<f64>>,
    pub parts: Vec<[usize; 2]>,
}

/// A shape.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub nodes: Vec<Node>,
    pub spans: Vec<Span>,
    /// How many elements lie below the plate, in the guide.
    pub guided: usize,
    /// Per wrench, the node on which it acts.
    pub loaded: Vec<Option<usize>>,
}

impl State {
    /// The node at which a motor holds a tube.
    pub fn base(&self, tube: usize) -> usize {
        if tube == 0 { self.guided } else { 0 }
    }

    /// Tubes at a node: those of the element that ends there, at the plate of that which begins.
    pub fn tubes(&self, node: usize) -> &[usize] {
        &self.spans[if node > self.guided { node - 1 } else { node }].tubes
    }

    /// Neighbours at a node; the guide stands in place of tube 0.
    pub fn pairs(&self, node: usize) -> impl Iterator<Item = [usize; 2]> + '_ {
        let tubes = self.tubes(node);
        let guide = (node < self.guided).then_some(0);
        guide
            .into_iter()
            .chain(tubes.iter().copied())
            .zip(tubes[usize::from(guide.is_none())..].iter().copied())
            .map(|(a, b)| [a, b])
    }

    /// Gives those of neighbours one axis that have no gap between them, and what is joined.
    pub fn bind(&mut self, tight: impl Fn([usize; 2]) -> bool) {
        // At the base every tube is held on its own.
        for number in 1..self.nodes.len() {
            let pairs: Vec<[usize; 2]> = self.pairs(number).filter(|pair| tight(*pair)).collect();
            let node = &mut self.nodes[number];
            let joined: Vec<[usize; 2]> =
                node.at.joined.windows(2).map(|pair| [pair[0].0, pair[1].0]).collect();
            node.axes = (0..node.turns.len()).collect();
            for [a, b] in pairs.into_iter().chain(joined) {
                let (one, other) = (node.axes[a].min(node.axes[b]), node.axes[a].max(node.axes[b]));
                for axis in node.axes.iter_mut().filter(|axis| **axis == other) {
                    *axis = one;
                }
            }
            let turned = node.axes.iter().zip(&node.turns);
            node.turned = turned.map(|(axis, turn)| node.turns[*axis].inverse() * turn).collect();
        }
    }

    /// Along the outermost tube of an element, or the guide: how long it is.
    pub fn advance(&self, element: usize) -> f64 {
        let ends = &self.nodes[element..element + 2];
        if element < self.guided {
            return ends[1].centre.x - ends[0].centre.x;
        }
        let tube = self.spans[element].tubes[0];
        ends[1].labels[tube] - ends[0].labels[tube]
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

type Three = [Option<usize>; 3];

struct NodeNumbers {
    frame: usize,
    centre: Three,
    /// Of the tube whose axis it shares where it shares one, and how it is turned against that about the axis.
    turns: Vec<Three>,
    twists: Vec<Option<usize>>,
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
    /// `held` says of every tube whether translation and rotation of its motor are.
    pub fn new(state: &State, held: &[[bool; 2]]) -> Self {
        let mut count = 0;
        let mut is_force = Vec::new();
        let mut next = |force: bool| {
            count += 1;
            is_force.push(force);
            Some(count - 1)
        };
        let (mut nodes, mut spans): (Vec<NodeNumbers>, Vec<SpanNumbers>) = (Vec::new(), Vec::new());
        for (place, node) in state.nodes.iter().enumerate() {
            let free = place > state.guided;
            // An edge in the guide stands where it does.
            let along = place > 0 && place < state.guided && !node.at.between;
            let mut own = NodeNumbers {
                frame: node.frame,
                centre: if free {
                    [(); 3].map(|()| next(false))
                } else {
                    [if along { next(false) } else { None }, None, None]
                },
                turns: vec![[None; 3]; held.len()],
                twists: vec![None; held.len()],
                labels: vec![None; held.len()],
                offsets: vec![[None; 2]; held.len()],
            };
            let first = node.at.joined.first().map(|own| own.0);
            for &tube in state.tubes(place) {
                let lowest = place == state.base(tube);
                let [pulled, turned] = held[tube];
                let axis = node.axes[tube];
                if lowest {
                    own.turns[tube][0] = if turned { None } else { next(false) };
                } else if axis == tube {
                    own.turns[tube] = [(); 3].map(|()| next(false));
                } else {
                    own.turns[tube] = own.turns[axis];
                    own.twists[tube] = match first {
                        Some(first) if first != tube && node.joins(tube) => own.twists[first],
                        _ => next(false),
                    };
                }
                own.offsets[tube] = if axis == node.frame || place == 0 {
                    [None; 2]
                } else if axis == tube {
                    [(); 2].map(|()| next(false))
                } else {
                    own.offsets[axis]
                };
                let fixed = lowest && pulled || node.at.held.contains(&tube);
                own.labels[tube] = if fixed { None } else { next(false) };
            }
            nodes.push(own);
            if let Some(span) = state.spans.get(place) {
                let mut of = |force: bool| {
                    let own =
                        |tube| [(); 3].map(|()| if span.tubes.contains(&tube) { next(force) } else { None });
                    (0..held.len()).map(own).collect()
                };
                spans.push(SpanNumbers { middles: of(false), forces: of(true) });
            }
        }
        let mut numbering = Self { count, reach: 0, is_force, nodes, spans };
        for element in 0..numbering.spans.len() {
            let all = state.spans[element].tubes.iter();
            let all = all.flat_map(|tube| numbering.sums(state, element, *tube)).flatten();
            let (low, high) = all.fold((usize::MAX, 0), |(low, high), (i, _)| (low.min(i), high.max(i)));
            numbering.reach = numbering.reach.max(high.saturating_sub(low));
        }
        numbering
    }

    /// What the inputs of an element are.
    pub fn sums(&self, state: &State, element: usize, tube: usize) -> [Sum; INPUTS] {
        let mut sums: [Sum; INPUTS] = Default::default();
        let put = |sums: &mut [Sum], first: usize, three: &Three| {
            for (i, number) in three.iter().enumerate() {
                sums[first + i].extend(number.map(|number| (number, 1.0)));
            }
        };
        let (ends, span) = (&self.nodes[element..element + 2], &self.spans[element]);
        put(&mut sums, MIDDLE, &span.middles[tube]);
        put(&mut sums, FORCE, &span.forces[tube]);
        for (end, own) in ends.iter().enumerate() {
            put(&mut sums, PLACES[end], &own.centre);
            let turned = state.nodes[element + end].turned[tube].to_rotation_matrix();
            for i in 0..3 {
                let sum = &mut sums[TURNS[end] + i];
                for (axis, number) in own.turns[tube].iter().enumerate() {
                    let factor = turned[(axis, i)];
                    sum.extend(number.filter(|_| factor.abs() > 0.0).map(|number| (number, factor)));
                }
            }
            sums[TURNS[end]].extend(own.twists[tube].map(|number| (number, 1.0)));
        }
        for (end, own) in ends.iter().enumerate() {
            sums[LABELS[end]].extend(own.labels[tube].map(|number| (number, 1.0)));
            let node = &state.nodes[element + end];
            let matrix = node.turns[node.frame].to_rotation_matrix();
            let arm = node.arm(tube);
            for i in 0..3 {
                let sum = &mut sums[PLACES[end] + i];
                for axis in 0..2 {
                    sum.extend(own.offsets[tube][axis].map(|number| (number, matrix[(i, axis + 1)])));
                }
                if tube != node.frame {
                    // A small turn δ of the section moves the place by R (δ×arm).
                    let turned = arm.cross(&Vector3::from(matrix.matrix().row(i).transpose()));
                    for (axis, number) in own.turns[own.frame].iter().enumerate() {
                        sum.extend(number.map(|number| (number, turned[axis])));
                    }
                }
            }
        }
        sums
    }

    /// Of the outermost tube at a node: its centre and its turn.
    pub fn section(&self, node: usize) -> [Three; 2] {
        let own = &self.nodes[node];
        [own.centre, own.turns[own.frame]]
    }

    /// Of the turn of the tube whose axis another one shares, and of that of this one against it.
    pub fn twist(&self, node: usize, tube: usize) -> (Three, Option<usize>) {
        (self.nodes[node].turns[tube], self.nodes[node].twists[tube])
    }

    /// Of a tube's label at a node.
    pub fn label(&self, node: usize, tube: usize) -> Option<usize> {
        self.nodes[node].labels[tube]
    }

    /// Of a tube's offset at a node.
    pub fn offset(&self, node: usize, tube: usize) -> [Option<usize>; 2] {
        self.nodes[node].offsets[tube]
    }

    /// Of a tube's label and turn about its axis at the node where its motor holds it.
    pub fn motor(&self, node: usize, tube: usize) -> [Option<usize>; 2] {
        [self.nodes[node].labels[tube], self.nodes[node].turns[tube][0]]
    }

    /// The state moved by a share of a step.
    pub fn moved(&self, state: &State, step: &[f64], share: f64) -> State {
        let mut state = state.clone();
        let one = |number: Option<usize>| number.map_or(0.0, |i| share * step[i]);
        let three = |numbers: &Three| Vector3::from(numbers.map(one));
        for (node, own) in state.nodes.iter_mut().zip(&self.nodes) {
            node.centre += three(&own.centre);
            for tube in 0..node.turns.len() {
                let axis = node.axes[tube];
                node.turns[tube] = if axis == tube {
                    node.turns[tube] * UnitQuaternion::from_scaled_axis(three(&own.turns[tube]))
                } else {
                    node.turned[tube] *= spin(one(own.twists[tube]));
                    node.turns[axis] * node.turned[tube]
                };
                node.turns[tube].renormalize();
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
        let all =
            self.nodes.iter().flat_map(|node| node.turns.iter().flatten().chain(&node.twists).flatten());
        all.fold(0.0, |most: f64, i| most.max(step[*i].abs()))
    }
}
