//! Steps of the integration over one span, chosen by their estimated error or taken again as they were, and the states at their ends.
//!
//! Repeated steps make the result of an integration a smooth function of its inputs, which Newton's method needs. The states at the
//! ends of the steps are unknowns of that method too (multiple shooting, Bock and Plitt 1984): an integration begins every step at the state
//! that is kept there, so that errors of a start do not grow from one step to the next. By how much it arrives elsewhere is carried
//! on in the last slope of the numbers: with slopes A by the [coordinates](super::coordinates) v and that one c, Newton's change of a state is A Δv + c.

use super::coordinates::Coordinates;
use super::flow::{Flow, Visitor};
use super::number::Number;
use super::order::{Order, Seen, Taken};
use super::section::Unbalanced;
use super::tableau::{Method, STAGES};
use super::walk::{Lost, Walk};
use nalgebra::DMatrix;

/// The state vector at the end of a step; without values where none is kept.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Node {
    /// How many tubes it holds.
    tubes: usize,
    values: Vec<f64>,
    /// Slopes of every value, one row each, by the coordinates of a stage.
    #[cfg_attr(feature = "serde", serde(skip))]
    slopes: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(skip))]
    stage: usize,
    /// By how much every value left the tangent along which it was predicted; while the next one is sought, what the tangent predicts.
    #[cfg_attr(feature = "serde", serde(skip))]
    bend: Vec<f64>,
    /// Method of the step before.
    order: Order,
    /// Its estimated error as a part of what is allowed.
    error: f64,
    /// What was seen when it was taken last with the method of order 8.
    seen: Seen,
}

/// Steps of one span.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct SpanSteps {
    /// Tube and number of its stop at which the span ends.
    key: (usize, usize),
    /// How many stops every tube has passed where the span begins: in another order of the events the states are others.
    passed: Vec<usize>,
    /// Shares of the span at which the steps end.
    ends: Vec<f64>,
    /// States there; the last one is that beyond the event.
    nodes: Vec<Node>,
}

/// The steps of an integration.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Steps {
    spans: Vec<SpanSteps>,
    /// How many stops every tube has: spans are known by their numbers.
    stops: Vec<usize>,
    /// Of which the errors of the steps are parts.
    allowed: f64,
    /// May steps be cut whose error is too large?
    pub adapt: bool,
    /// Greatest distance, in scaled variables, at which a step arrived from the state that is kept there.
    pub defect: f64,
    /// What the step of order 8 showed that was taken last.
    #[cfg_attr(feature = "serde", serde(skip))]
    seen: Seen,
    /// Conditions and coordinates of the integration; every one begins with its own.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub coordinates: Coordinates,
}

impl Steps {
    /// The same with every step halved.
    pub fn halved(&self) -> Self {
        let halve = |span: &SpanSteps| {
            let (mut ends, mut nodes) = (Vec::new(), Vec::new());
            let mut last = 0.0;
            for (&end, node) in span.ends.iter().zip(&span.nodes) {
                ends.extend([0.5 * (last + end), end]);
                nodes.extend([Node { order: node.order, seen: node.seen, ..Node::default() }, node.clone()]);
                last = end;
            }
            SpanSteps { key: span.key, passed: span.passed.clone(), ends, nodes }
        };
        let (spans, stops) = (self.spans.iter().map(halve).collect(), self.stops.clone());
        Self { spans, stops, allowed: self.allowed, ..Self::default() }
    }

    /// Errors of this size are allowed from now on.
    pub fn allow(&mut self, tolerance: f64) {
        let part = self.allowed / tolerance;
        for node in self.spans.iter_mut().flat_map(|span| &mut span.nodes) {
            node.error *= part;
            node.seen = node.seen.times(part);
        }
        self.allowed = tolerance;
    }

    /// The same where errors of this size are allowed: two steps whose errors are far below make one, and every step takes the lowest order that does. Where far
    /// greater errors are allowed than before all steps of a span make one, which is cut again where that is needed.
    pub fn coarsened(&self, tolerance: f64) -> Self {
        let mut own = self.clone();
        let all = self.allowed < EASY.sqrt() * tolerance;
        own.allow(tolerance);
        for span in &mut own.spans {
            let easy = |node: &Node| all || node.order == Order::Eighth && node.error < EASY;
            let mut joined = false;
            let old = std::mem::take(&mut span.nodes).into_iter().zip(std::mem::take(&mut span.ends));
            let mut old = old.peekable();
            while let Some((mut node, end)) = old.next() {
                let next = old.peek().is_some_and(|(next, _)| easy(next));
                if next && easy(&node) && (all || !joined) {
                    joined = true;
                    continue;
                }
                node.order = if joined { Order::Eighth } else { node.seen.order() };
                joined = false;
                span.nodes.push(node);
                span.ends.push(end);
            }
        }
        own
    }

    /// Moves every state on by a multiple of how far it has come since it was what stands in `before`.
    pub fn extrapolate(&mut self, before: &Self, factor: f64) {
        for span in &mut self.spans {
            let same = |old: &&SpanSteps| old.key == span.key && old.passed == span.passed;
            let Some(old) = before.spans.iter().find(same) else { continue };
            for (end, node) in span.ends.iter().zip(&mut span.nodes) {
                let at = old.ends.iter().position(|other| (other - end).abs() < SHORTEST);
                let Some(old) = at.map(|at| &old.nodes[at]).filter(|old| old.tubes == node.tubes) else {
                    continue;
                };
                for (value, old) in node.values.iter_mut().zip(&old.values) {
                    *value += factor * (*value - old);
                }
            }
        }
    }

    /// Tube and stop at which span `number` ended last.
    pub fn key(&self, number: usize) -> Option<(usize, usize)> {
        self.spans.get(number).map(|span| span.key)
    }

    /// Span `number` ends at the stop of this key. Where tubes have come to pass their events in another order, the steps of that span are
    /// those that were kept for it.
    fn begin(&mut self, number: usize, key: (usize, usize), passed: &[usize]) {
        if self.key(number) != Some(key) {
            let later = self.spans[number.min(self.spans.len())..].iter().position(|span| span.key == key);
            let span = match later {
                Some(place) => self.spans.remove(number + place),
                None => SpanSteps { key, passed: passed.to_vec(), ends: Vec::new(), nodes: Vec::new() },
            };
            self.spans.insert(number, span);
        }
        let span = &mut self.spans[number];
        if span.passed != passed {
            span.passed = passed.to_vec();
            for node in &mut span.nodes {
                node.values.clear();
            }
        }
    }

    /// Keys of all spans in their order.
    pub fn keys(&self) -> Vec<(usize, usize)> {
        self.spans.iter().map(|span| span.key).collect()
    }

    /// Has one of them an error far above what is allowed? Steps that were repeated as they were may.
    pub fn are_coarse(&self) -> bool {
        self.spans.iter().flat_map(|span| &span.nodes).any(|node| node.error > COARSE)
    }

    /// How many steps there are.
    pub fn count(&self) -> usize {
        self.spans.iter().map(|span| span.ends.len()).sum()
    }

    /// There are no more spans than these.
    pub fn end(&mut self, spans: usize) {
        self.spans.truncate(spans);
    }

    /// An integration with so many unknowns begins: no state has been met by it. Steps of tubes with other stops (another bundle, other point
    /// loads) tell nothing of this one.
    pub fn begin_again(
        &mut self,
        unknowns: usize,
        tolerance: f64,
        stops: impl Iterator<Item = usize> + Clone,
    ) {
        self.allow(tolerance);
        if !self.stops.iter().copied().eq(stops.clone()) {
            self.spans.clear();
            self.stops = stops.collect();
        }
        self.defect = 0.0;
        self.seen = Seen::default();
        self.coordinates = Coordinates::begin(unknowns);
        for node in self.spans.iter_mut().flat_map(|span| &mut span.nodes) {
            node.slopes.clear();
        }
    }

    /// Forgets the slopes.
    pub fn settle(&mut self) {
        self.coordinates = Coordinates::default();
        for node in self.spans.iter_mut().flat_map(|span| &mut span.nodes) {
            node.slopes = Vec::new();
        }
    }

    /// The order of a step with so many values and of this length (m), and what was seen of it. One that is not known yet may be taken as the one before where both are `alike`.
    fn order(&self, number: usize, index: usize, width: usize, length: f64, alike: bool) -> (Order, Seen) {
        match self.spans[number].nodes.get(index) {
            Some(node) if node.seen.covers(width, length) => (node.order, node.seen),
            _ if alike && self.seen.covers(width, length) => (self.seen.order(), self.seen),
            _ => Default::default(),
        }
    }

    /// Notes how a step was taken.
    fn note(&mut self, number: usize, index: usize, order: Order, error: f64, seen: Seen) {
        let node = &mut self.spans[number].nodes[index];
        (node.error, node.order, node.seen) = (error, order, seen.after(&node.seen));
        if order == Order::Eighth {
            self.seen = node.seen;
        }
    }

    /// Takes over the state kept at the end of the last step of a span, or keeps what the integration arrived with.
    pub fn meet_event<S: Number>(&mut self, flow: &mut Flow<S>, walk: &Walk, number: usize) {
        if let Some(last) = self.spans[number].ends.len().checked_sub(1) {
            self.meet(flow, walk, number, last);
        }
    }

    /// The same at the end of any step.
    fn meet<S: Number>(&mut self, flow: &mut Flow<S>, walk: &Walk, number: usize, index: usize) {
        let node = &mut self.spans[number].nodes[index];
        let tubes = flow.present.len();
        if node.tubes != tubes {
            *node = Node { tubes, values: Vec::new(), bend: Vec::new(), ..std::mem::take(node) };
            if let Some(course) = walk.course {
                course.lay(flow);
            }
        }
        let mut kept = node.values.len().min(flow.values.len());
        if flow.values[0].slopes().is_empty() {
            // The pose does not grow apart; without slopes it goes on as it is integrated.
            kept = kept.min(4 * tubes);
        }
        let scales = scales(tubes, flow.values.len(), walk);
        for ((value, old), scale) in flow.values.iter_mut().zip(&node.values).zip(&scales).take(kept) {
            self.defect = self.defect.max((value.value() - old).abs() / scale);
            *value = value.moved_to(*old);
        }
        self.coordinates.exchange(&mut flow.values, &scales[..dependent(tubes, walk, &scales)]);
        node.stage = self.coordinates.stage();
        // As many values as there are: with slopes, one row of them for each.
        node.values.truncate(flow.values.len());
        let known = node.values.len();
        node.values.extend(flow.values.iter().skip(known).map(|v| v.value()));
        node.slopes.clear();
        for value in &flow.values {
            node.slopes.extend_from_slice(value.slopes());
        }
    }

    /// Coordinates and inputs at every stage, from a change of the last coordinates and of the inputs after them, with a part of the gaps.
    fn stages(&self, change: &[f64], gaps: f64) -> Vec<DMatrix<f64>> {
        let rows = self.spans.iter().flat_map(|span| &span.nodes).filter(|node| !node.slopes.is_empty());
        let width = rows.map(|node| node.slopes.len() / node.values.len()).next().unwrap_or(change.len() + 1);
        let mut last = DMatrix::zeros(width, 1);
        last.rows_mut(0, change.len()).copy_from_slice(change);
        last[width - 1] = gaps;
        self.coordinates.stages(last)
    }

    /// Calls `each` with every kept state and its change.
    fn changes(&mut self, stages: &[DMatrix<f64>], mut each: impl FnMut(&mut Node, &[f64])) {
        let mut change = Vec::new();
        for node in self.spans.iter_mut().flat_map(|span| &mut span.nodes) {
            let width = node.values.len();
            if width == 0 || node.slopes.is_empty() {
                continue;
            }
            let Some(by) = stages.get(node.stage) else { continue };
            change.clear();
            for row in node.slopes.chunks_exact(node.slopes.len() / width) {
                change.push(row.iter().zip(by.iter()).map(|(slope, by)| slope * by).sum::<f64>());
            }
            each(node, &change);
        }
    }

    /// The change at the plate of unknowns and inputs, as many as are given at the tip: Newton's, where the gaps close, and their greatest
    /// effect on a state, in scaled variables.
    pub fn at_plate(&mut self, change: &[f64], walk: &Walk) -> (Vec<f64>, f64) {
        let stages = self.stages(change, 1.0);
        let mut most: f64 = 0.0;
        self.changes(&stages, |node, change| {
            for (change, scale) in change.iter().zip(scales(node.tubes, change.len(), walk)) {
                // A change that is not a number is the greatest.
                let size = change.abs() / scale;
                most = if size.is_nan() { f64::INFINITY } else { most.max(size) };
            }
        });
        (stages[0].as_slice()[..change.len()].to_vec(), most)
    }

    /// Moves the kept states by a part of a change at the tip and of what closes the gaps. What moves at the plate is returned.
    pub fn advance(&mut self, change: &[f64], gaps: f64, factor: f64) -> Vec<f64> {
        let stages = self.stages(change, gaps);
        self.changes(&stages, |node, change| {
            for (value, change) in node.values.iter_mut().zip(change) {
                *value += factor * change;
            }
        });
        stages[0].as_slice()[..change.len()].iter().map(|own| factor * own).collect()
    }

    /// Moves the kept states along the tangent by a change at the tip, and on by a multiple of what they left it by before.
    pub fn predict(&mut self, change: &[f64], again: f64) {
        let stages = self.stages(change, 0.0);
        self.changes(&stages, |node, change| {
            node.bend.resize(node.values.len(), 0.0);
            for ((value, change), bend) in node.values.iter_mut().zip(change).zip(&mut node.bend) {
                let straight = *value + change;
                *value = straight + again * *bend;
                *bend = straight;
            }
        });
    }

    /// Notes by how much the states have left the tangent along which they were predicted.
    pub fn note_bend(&mut self) {
        for node in self.spans.iter_mut().flat_map(|span| &mut span.nodes) {
            for (bend, value) in node.bend.iter_mut().zip(&node.values) {
                *bend = value - *bend;
            }
        }
    }
}

/// Spans shorter than this part of the length are taken in one step of order one.
const TINY: f64 = 1e-9;
/// Two steps with errors below this part of what is allowed make one: its error is 2⁸ times as great.
const EASY: f64 = 1e-3;
/// Errors beyond this multiple of what is allowed are too large.
const COARSE: f64 = 10.0;
/// Steps shorter than this part of the length are like their neighbours.
const SHORT: f64 = 0.05;
/// Shortest step, as a share of its span.
const SHORTEST: f64 = 1e-6;

/// Steps per event after which none is cut any more.
const MOST_STEPS: usize = 50;

/// What a span is integrated to.
pub(super) struct Span<'a> {
    /// Place of the tube whose label is the independent variable, and the label at which the span ends (m).
    pub leading: usize,
    pub to: f64,
    /// Number of the span, and the tube and stop at its end.
    pub number: usize,
    pub key: (usize, usize),
    /// How many stops every tube has passed.
    pub passed: &'a [usize],
    /// Labels that the tubes may not pass.
    pub limits: &'a [f64],
}

/// Integrates until the leading tube has reached its label, or another one has passed its limit: then its place is returned.
pub(super) fn march<S: Number>(
    flow: &mut Flow<S>,
    span: &Span,
    steps: &mut Steps,
    walk: &Walk,
    visit: &mut Option<Visitor<S>>,
) -> Result<Option<usize>, Lost> {
    steps.begin(span.number, span.key, span.passed);
    let width = flow.values.len();
    let (mut stages, mut trial) = (std::mem::take(&mut flow.stages), std::mem::take(&mut flow.trial));
    stages.resize(width * STAGES, S::constant(0.0));
    trial.resize(width, S::constant(0.0));
    let found = try_march(flow, span, steps, walk, visit, [&mut stages, &mut trial]);
    (flow.stages, flow.trial) = (stages, trial);
    found
}

fn passed<S: Number>(flow: &Flow<S>, limits: &[f64]) -> Option<usize> {
    limits.iter().enumerate().position(|(place, limit)| flow.values[4 * place].value() > *limit)
}

fn try_march<S: Number>(
    flow: &mut Flow<S>,
    span: &Span,
    steps: &mut Steps,
    walk: &Walk,
    visit: &mut Option<Visitor<S>>,
    [slopes, trial]: [&mut Vec<S>; 2],
) -> Result<Option<usize>, Lost> {
    let Span { leading, to, number, limits, .. } = *span;
    let width = flow.values.len();
    let way = (to - flow.values[4 * leading].value()).abs();
    if way < TINY * walk.bundle.length {
        skip(flow, span, steps, &mut slopes[..width])?;
        return Ok(passed(flow, limits));
    }
    let scales = scales(flow.present.len(), width, walk);
    let dependent = dependent(flow.present.len(), walk, &scales);
    let longest = walk.longest / way;
    let stops: usize = walk.command.stops.iter().map(Vec::len).sum();
    let most = MOST_STEPS * (1 + stops);
    let (mut done, mut index) = (0.0, 0);
    // Is the first stage known?
    let mut begun = false;
    // Has it to be of order 8?
    let mut full = false;
    let mut share: f64 = 1.0;
    while done < 1.0 {
        let kept = steps.spans[number].ends.get(index).copied();
        let goal = kept.unwrap_or(f64::min(1.0, done + share));
        let goal = if goal > 1.0 - SHORTEST { 1.0 } else { goal };
        let end = if goal > done + longest { done + longest } else { goal };
        let step = (-flow.values[4 * leading] + to) * ((end - done) / (1.0 - done));
        let free = steps.adapt || kept.is_none();
        // A short step is like the one before: nothing grows far along it, and but for friction nothing is rough.
        let smooth = free && walk.command.rubbing.is_none();
        let alike = smooth && !full && step.value().abs() < SHORT * walk.bundle.length;
        // A step that is cut is of order 8.
        let (order, before) = if end >= goal {
            steps.order(number, index, width, step.value(), alike)
        } else {
            Default::default()
        };
        if !begun {
            flow.slopes(Some(leading), &mut slopes[..width])?;
            begun = true;
        }
        let taken = one_step(flow, leading, step, order, slopes, trial);
        let (error, seen) = match taken {
            Ok(()) => {
                let grown = steps.coordinates.overgrowth(&flow.values, trial, &scales[..dependent]);
                let taken = Taken { stages: slopes, arrived: trial, step, scales: &scales, dependent };
                let (own, seen) = match order {
                    Order::Eighth => taken.error(walk.tolerance),
                    _ => (taken.error_of_lower(order, &before, walk.tolerance), None),
                };
                (own.max(grown.max(0.0).powi(8)), seen)
            }
            Err(Unbalanced) => (f64::INFINITY, None),
        };
        let coarse = error > 1.0;
        if coarse && order != Order::Eighth && free {
            full = true;
            if let Some(node) = steps.spans[number].nodes.get_mut(index) {
                node.order = Order::Eighth;
            }
            continue;
        }
        let shorter = (end - done) * (0.9 * error.powf(-1.0 / 8.0)).clamp(0.1, 0.7);
        if coarse && free {
            if shorter < SHORTEST || steps.count() > most {
                return Err(Lost::Steps);
            }
            if kept.is_some() {
                let own = &mut steps.spans[number];
                own.ends.insert(index, 0.5 * (done + end));
                own.nodes.insert(index, Node::default());
            }
            share = shorter;
            continue;
        }
        taken?;
        std::mem::swap(&mut flow.values, trial);
        if kept.is_none() && end >= goal {
            let own = &mut steps.spans[number];
            own.ends.push(end);
            own.nodes.push(Node::default());
        }
        share = (end - done) * (0.9 * error.max(1e-12).powf(-1.0 / 8.0)).min(5.0);
        (begun, full) = (false, false);
        if end >= goal {
            steps.note(number, index, order, error, seen.unwrap_or(before));
            if end < 1.0 {
                steps.meet(flow, walk, number, index);
            }
            index += 1;
        }
        let before = std::mem::replace(&mut done, end);
        if let Some(place) = passed(flow, limits) {
            return Ok(Some(place));
        }
        if let Some(visit) = visit {
            // A step as long as the spacing has none between, whatever rounding says.
            let sections = (way * (end - before) / walk.spacing - 1e-6).ceil();
            if sections > 1.0 {
                visit_between(flow, leading, step, sections, [slopes, trial], *visit)?;
            }
            flow.visit(*visit)?;
        }
    }
    let own = &mut steps.spans[number];
    own.ends.truncate(index);
    own.nodes.truncate(index);
    Ok(None)
}

/// Passes a span that is hardly there.
fn skip<S: Number>(
    flow: &mut Flow<S>,
    span: &Span,
    steps: &mut Steps,
    slopes: &mut [S],
) -> Result<(), Unbalanced> {
    let way = -flow.values[4 * span.leading] + span.to;
    flow.slopes(Some(span.leading), slopes)?;
    for (value, slope) in flow.values.iter_mut().zip(slopes) {
        *value += *slope * way;
    }
    let own = &mut steps.spans[span.number];
    let last = own.nodes.pop().unwrap_or_default();
    (own.ends, own.nodes) = (vec![1.0], vec![last]);
    Ok(())
}

/// Shows sections inside a step that was taken, by Hermite's cubic from the state before it and its first stage to the state behind it.
fn visit_between<S: Number>(
    flow: &mut Flow<S>,
    leading: usize,
    step: S,
    sections: f64,
    [slopes, before]: [&mut Vec<S>; 2],
    visit: Visitor<S>,
) -> Result<(), Unbalanced> {
    let width = before.len();
    flow.slopes(Some(leading), &mut slopes[width..2 * width])?;
    let [first, last] = [&slopes[..width], &slopes[width..2 * width]];
    let arrived = flow.values.clone();
    let mut between = 1.0;
    while between < sections {
        let weights = hermite(between / sections);
        for (i, value) in flow.values.iter_mut().enumerate() {
            *value = before[i] * weights[0]
                + first[i] * step * weights[1]
                + arrived[i] * weights[2]
                + last[i] * step * weights[3];
        }
        flow.visit(visit)?;
        between += 1.0;
    }
    flow.values = arrived;
    Ok(())
}

/// Weights of Hermite's cubic at a share of a step: of the value and the slope at its beginning, then of those at its end.
fn hermite(share: f64) -> [f64; 4] {
    let (t, left) = (share, 1.0 - share);
    [(1.0 + 2.0 * t) * left * left, t * left * left, t * t * (3.0 - 2.0 * t), -t * t * left]
}

/// One step from its first stage.
fn one_step<S: Number>(
    flow: &mut Flow<S>,
    leading: usize,
    step: S,
    order: Order,
    slopes: &mut [S],
    trial: &mut [S],
) -> Result<(), Unbalanced> {
    let width = trial.len();
    let method = Method::of(order);
    let mut guess = flow.guess();
    for (stage, before) in method.before.iter().enumerate().skip(1) {
        combine(flow, before, step, slopes, trial);
        let own = &mut slopes[stage * width..(stage + 1) * width];
        flow.slopes_at(trial, Some(leading), &mut guess, own)?;
    }
    combine(flow, method.step, step, slopes, trial);
    Ok(())
}

/// trial = values + step Σ weight · slopes.
fn combine<S: Number>(flow: &Flow<S>, weights: &[(usize, f64)], step: S, slopes: &[S], trial: &mut [S]) {
    let width = trial.len();
    for (i, value) in trial.iter_mut().enumerate() {
        let mut sum = S::constant(0.0);
        for &(stage, weight) in weights {
            sum.add_scaled(weight, &slopes[stage * width + i]);
        }
        *value = sum * step;
        value.add_scaled(1.0, &flow.values[i]);
    }
}

/// How many values others depend on: without loads nothing depends on the pose.
fn dependent(tubes: usize, walk: &Walk, scales: &[f64]) -> usize {
    if walk.command.loaded { scales.len() } else { 4 * tubes }
}

/// Units of the state vector's first `width` values.
fn scales(tubes: usize, width: usize, walk: &Walk) -> Vec<f64> {
    let length = walk.bundle.length;
    let force = walk.command.force_scale;
    let mut scales = Vec::with_capacity(4 * tubes + 14);
    for _ in 0..tubes {
        scales.extend([length, force, 1.0, force * length]);
    }
    scales.push(length);
    scales.extend([length, length, length, 1.0, 1.0, 1.0, 1.0]);
    scales.extend([force, force, force, force * length, force * length, force * length]);
    scales.truncate(width);
    scales
}
