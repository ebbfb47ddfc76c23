//! Unknowns of a bundle with clearance: nodes and elements along the leader, and which of their values are free.

use super::element::{ANGLES, FIRST, INPUTS, LABELS, LAST, Number, STRETCHES, TENSION};
use crate::design::fields::Part;

/// A follower at a node: angle α to the leader, height y of its axis over the leader's, own label x (scaled).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beside {
    pub angle: f64,
    pub height: f64,
    pub label: f64,
}

/// A section between two elements.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The leader's label X.
    pub label: f64,
    pub angle: f64,
    /// The follower (from 0) whose edge stands here: its label is 0, and X is unknown.
    pub edge: Option<usize>,
    pub beside: Vec<Beside>,
}

/// What belongs to an element alone.
#[derive(Clone, Debug)]
pub(super) struct Span {
    /// The leader's angle in its middle, and its stretch at both ends.
    pub angle: f64,
    pub stretch: [f64; 2],
    /// Of every follower.
    pub tension: Vec<f64>,
    pub parts: Vec<Part>,
}

/// A shape.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub nodes: Vec<Node>,
    pub spans: Vec<Span>,
}

impl State {
    pub fn followers(&self) -> usize {
        self.nodes.first().map_or(0, |node| node.beside.len())
    }

    /// Inputs of an element with one of its followers.
    pub fn inputs(&self, element: usize, follower: usize) -> [f64; INPUTS] {
        let (a, b, span) = (&self.nodes[element], &self.nodes[element + 1], &self.spans[element]);
        let mut inputs = [0.0; INPUTS];
        for (i, value) in ANGLES.into_iter().zip([a.angle, span.angle, b.angle]) {
            inputs[i] = value;
        }
        for (i, value) in STRETCHES.into_iter().zip(span.stretch) {
            inputs[i] = value;
        }
        for (ends, node) in [(FIRST, a), (LAST, b)] {
            let own = &node.beside[follower];
            for (i, value) in ends.into_iter().zip([own.angle, own.height, own.label]) {
                inputs[i] = value;
            }
        }
        inputs[TENSION] = span.tension[follower];
        inputs[LABELS[0]] = a.label;
        inputs[LABELS[1]] = b.label;
        inputs
    }
}

/// Which number in the system every value of a state has, if it is free.
pub(super) struct Numbering {
    pub count: usize,
    /// Diagonals on either side.
    pub reach: usize,
    /// Which of them are tensions: no motions.
    pub is_tension: Vec<bool>,
    nodes: Vec<NodeNumbers>,
    spans: Vec<SpanNumbers>,
}

struct NodeNumbers {
    label: Option<usize>,
    angle: Option<usize>,
    beside: Vec<[Option<usize>; 3]>,
}

struct SpanNumbers {
    angle: Option<usize>,
    stretch: [Option<usize>; 2],
    tension: Vec<usize>,
}

/// What is held.
pub(super) struct Held<'a> {
    /// Is the tube's motor held, not driven by force?
    pub motors: &'a [bool],
    /// Has the pair of this follower and the tube around it no gap?
    pub tight: &'a [bool],
    pub stretches: bool,
}

impl Numbering {
    pub fn new(state: &State, held: &Held) -> Self {
        let (mut count, followers, last) = (0, state.followers(), state.nodes.len() - 1);
        let mut next = || {
            count += 1;
            Some(count - 1)
        };
        let (mut nodes, mut spans): (Vec<NodeNumbers>, Vec<SpanNumbers>) = (Vec::new(), Vec::new());
        for (place, node) in state.nodes.iter().enumerate() {
            let at_plate = place == 0;
            let mut own = NodeNumbers {
                label: node.edge.and_then(|_| next()),
                angle: if at_plate { None } else { next() },
                beside: Vec::with_capacity(followers),
            };
            for k in 0..followers {
                let on_axis = place == last || at_plate;
                let mut three = [None; 3];
                if held.tight[k] {
                    if k > 0 {
                        let [angle, height, _] = own.beside[k - 1];
                        three = [angle, height, None];
                    }
                } else if !on_axis {
                    three = [next(), next(), None];
                }
                let fixed = place == last || at_plate && held.motors[k] || node.edge == Some(k);
                if !fixed {
                    three[2] = next();
                }
                own.beside.push(three);
            }
            nodes.push(own);
            if place < last {
                spans.push(SpanNumbers {
                    angle: next(),
                    stretch: [(); 2].map(|()| if held.stretches { next() } else { None }),
                    tension: (0..followers).filter_map(|_| next()).collect(),
                });
            }
        }
        let mut numbering = Self { count, reach: 0, is_tension: vec![false; count], nodes, spans };
        for span in &numbering.spans {
            for number in &span.tension {
                numbering.is_tension[*number] = true;
            }
        }
        for element in 0..numbering.spans.len() {
            let all = (0..followers).flat_map(|k| numbering.of(element, k)).flatten();
            let (low, high) = all.fold((usize::MAX, 0), |(low, high), i| (low.min(i), high.max(i)));
            numbering.reach = numbering.reach.max(high.saturating_sub(low));
        }
        numbering
    }

    /// Numbers of an element's inputs with one of its followers.
    pub fn of(&self, element: usize, follower: usize) -> [Option<usize>; INPUTS] {
        let (a, b, span) = (&self.nodes[element], &self.nodes[element + 1], &self.spans[element]);
        let mut numbers = [None; INPUTS];
        for (i, own) in ANGLES.into_iter().zip([a.angle, span.angle, b.angle]) {
            numbers[i] = own;
        }
        for (i, own) in STRETCHES.into_iter().zip(span.stretch) {
            numbers[i] = own;
        }
        for (ends, node) in [(FIRST, a), (LAST, b)] {
            for (i, own) in ends.into_iter().zip(node.beside[follower]) {
                numbers[i] = own;
            }
        }
        numbers[TENSION] = Some(span.tension[follower]);
        numbers[LABELS[0]] = a.label;
        numbers[LABELS[1]] = b.label;
        numbers
    }

    /// Of the leader's angle at a node.
    pub fn angle(&self, node: usize) -> Option<usize> {
        self.nodes[node].angle
    }

    /// Of a follower's height at a node; follower 0 is the leader itself, whose height is 0.
    pub fn height(&self, node: usize, tube: usize) -> Option<usize> {
        tube.checked_sub(1).and_then(|k| self.nodes[node].beside[k][1])
    }

    /// Of a follower's label at a node.
    pub fn label(&self, node: usize, follower: usize) -> Option<usize> {
        self.nodes[node].beside[follower][2]
    }

    /// The state moved by a share of a step.
    pub fn moved(&self, state: &State, step: &[f64], share: f64) -> State {
        let mut state = state.clone();
        let add = |value: &mut f64, number: Option<usize>| {
            if let Some(i) = number {
                *value += share * step[i];
            }
        };
        for (node, own) in state.nodes.iter_mut().zip(&self.nodes) {
            add(&mut node.label, own.label);
            add(&mut node.angle, own.angle);
            for (beside, [angle, height, label]) in node.beside.iter_mut().zip(&own.beside) {
                add(&mut beside.angle, *angle);
                add(&mut beside.height, *height);
                add(&mut beside.label, *label);
            }
        }
        for (span, own) in state.spans.iter_mut().zip(&self.spans) {
            add(&mut span.angle, own.angle);
            for (value, number) in span.stretch.iter_mut().zip(own.stretch) {
                add(value, number);
            }
            for (value, number) in span.tension.iter_mut().zip(&own.tension) {
                add(value, Some(*number));
            }
        }
        state
    }
}

/// Inputs with derivatives by those that are free.
pub(super) fn seeded(values: [f64; INPUTS], numbers: &[Option<usize>; INPUTS]) -> [Number; INPUTS] {
    std::array::from_fn(|i| match numbers[i] {
        Some(_) => Number::input(values[i], i),
        None => Number::constant(values[i]),
    })
}
