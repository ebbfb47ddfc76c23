//! The figure of a traced path: effort against motion, or the factor of the loads against the tip's deflection; stable
//! parts solid, unstable ones dashed, folds and branch points marked.

use crate::continuation::Shown;
use cppr::analysis::continuation::{Branch, Parameter, PathPoint, PointKind};
use cppr_plot::{Axis, Colour, Dash, Figure, Marker, MarkerShape, Panel, Series, Stroke, tube_stroke};

/// A path has one panel.
pub fn draw<E>(
    title: String,
    varies: Parameter,
    branches: &[Branch<E>],
    conjugate: impl Fn(&PathPoint<E>) -> Option<f64>,
) -> Figure {
    let parameter = Shown::parameter(varies);
    let axis = |shown: &Shown| {
        let label = match shown.unit {
            "" => shown.words.to_string(),
            _ => format!("{} {}", shown.words, subscripted(&shown.symbol)),
        };
        Axis::new(label, shown.unit.replace("deg", "°")).with_zero_line()
    };
    let answer = Shown::conjugate(varies);
    let component = telling(branches);
    let rest = branches.first().and_then(|b| b.points.first()).map_or(0.0, |p| p.tip[component]);
    let mut panel = match &answer {
        Some(answer) => Panel::new(axis(&parameter), axis(answer)),
        None => Panel::new(Axis::new(DEFLECTIONS[component], "mm").with_zero_line(), axis(&parameter)),
    };
    let place = |p: &PathPoint<E>| match &answer {
        Some(answer) => [p.parameter * parameter.scale, conjugate(p).unwrap_or(0.0) * answer.scale],
        None => [(p.tip[component] - rest) * 1e3, p.parameter],
    };
    for branch in branches {
        panel.series.extend(pieces(branch, &place));
    }
    for (name, shape, filled, wanted) in MARKS {
        let points = branches.iter().flat_map(|b| &b.points).filter(|p| wanted(p.kind)).map(&place);
        let points: Vec<[f64; 2]> = points.collect();
        if !points.is_empty() {
            let marker = Some(Marker { shape, size: 7.0, colour: Colour::INK, filled });
            panel.series.push(Series { name: name.into(), points, marker, ..Series::default() });
        }
    }
    Figure { title, panels: vec![panel], max_width: 520.0, ..Figure::default() }
}

const DEFLECTIONS: [&str; 3] =
    ["axial deflection of the tip u_{x}", "deflection of the tip u_{y}", "deflection of the tip u_{z}"];

type Mark = (&'static str, MarkerShape, bool, fn(PointKind) -> bool);
const MARKS: [Mark; 3] = [
    ("fold", MarkerShape::Triangle, true, |kind| kind == PointKind::Fold),
    ("branch point", MarkerShape::Circle, false, |kind| matches!(kind, PointKind::BranchPoint { .. })),
    ("edge of the pattern", MarkerShape::Cross, false, |kind| matches!(kind, PointKind::Edge { .. })),
];

/// Δa_2 as the figures write it.
fn subscripted(symbol: &str) -> String {
    symbol.split_once('_').map_or(symbol.into(), |(letter, tube)| format!("{letter}_{{{tube}}}"))
}

/// The stable and unstable parts of a branch. A piece between a stable and an unstable point counts as what its far end
/// is: the change lies at the special point between both.
fn pieces<E>(branch: &Branch<E>, place: &dyn Fn(&PathPoint<E>) -> [f64; 2]) -> Vec<Series> {
    let solid = tube_stroke(1);
    let dashed = Stroke { width: 0.75 * solid.width, dash: Dash::Dashed, ..tube_stroke(2) };
    let known = branch.points.iter().all(|p| p.inertia.is_some());
    let mut out: Vec<(bool, Series)> = Vec::new();
    for pair in branch.points.windows(2) {
        let special = |p: &PathPoint<E>| matches!(p.kind, PointKind::Fold | PointKind::BranchPoint { .. });
        // At the special point itself one eigenvalue is zero: its neighbour tells.
        let stable = if special(&pair[1]) { pair[0].is_stable() } else { pair[1].is_stable() };
        match out.last_mut() {
            Some((kind, series)) if *kind == stable => series.points.push(place(&pair[1])),
            _ => {
                let (name, line) = match (stable, known) {
                    (true, true) => ("stable", solid),
                    (false, _) => ("unstable", dashed),
                    (true, false) => ("stability not known", solid),
                };
                let points = pair.iter().map(place).collect();
                out.push((
                    stable,
                    Series { name: name.into(), points, line: Some(line), ..Series::default() },
                ));
            }
        }
    }
    out.into_iter().map(|(_, series)| series).collect()
}

/// The component of the tip's position in which the two ways to leave a branch point differ the most; without branches
/// the one that moves the most.
fn telling<E>(branches: &[Branch<E>]) -> usize {
    let moved = |component: usize| {
        let all = branches.iter().flat_map(|b| &b.points).map(|p| p.tip[component]);
        all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
    };
    let apart = |component: usize| {
        let pairs = branches.windows(2).filter_map(|pair| {
            let [one, other] = [pair.first()?, pair.last()?];
            let (a, b) = (one.origin?, other.origin?);
            let opposite = (a.branch, a.point, a.mode) == (b.branch, b.point, b.mode);
            opposite.then_some((one.points.last()?.tip - other.points.last()?.tip)[component].abs())
        });
        pairs.fold(0.0, f64::max)
    };
    let most = |score: &dyn Fn(usize) -> f64| (0..3).max_by(|&a, &b| score(a).total_cmp(&score(b)));
    let best = most(&apart).filter(|&c| apart(c) > 0.0).or_else(|| most(&moved));
    best.unwrap_or(1)
}
