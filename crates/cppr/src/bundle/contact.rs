//! The force with which neighbouring tubes press on each other, per length of the centreline, where there is no clearance.
//!
//! A round tube in a round one is pressed in the plane of the section through the common centreline, and so without a couple about it. Every tube carries
//! a force F = N t + F_y y + F_z z and a moment M = π t + M_y y + M_z z about the centreline, y and z of the untwisted frame with the rates
//! ω = (0, ω_y, ω_z). M_y and M_z are ∂E/∂ω, the tube's bending with its axial force times its offset; N = E − M·ω. With the weight w per length that acts at
//! the arm a, balance of one tube alone gives its shear and what its neighbours press on it:
//!
//! ```text
//! M' + ω×M + t×F + a×w = 0 :   F_y = −(M_z' − π ω_y) − (a×w)_z ,   F_z = M_y' + π ω_z + (a×w)_y
//! F' + ω×F + q + w = 0     :   q_y = −(F_y' + N ω_z) − w_y ,       q_z = −(F_z' − N ω_y) − w_z
//! ```
//!
//! M' is exact, by the slopes of the state; F' is that of a polynomial through five sections. The outer tube of a pair presses p = Σ q on all tubes inside
//! it. Over all tubes Σ q = 0, which tells how exact the forces are. Where fields jump, at the plate, at joints and tips, shear jumps: there stand point forces.

use super::flow::{Carried, Flow, Section};
use super::number::{Dual, Number};
use super::prepared::array;
use super::rubbing::{Side, slopes};
use super::section::{Tube, TubeState, Unbalanced};
use super::solve::{BundleEquilibrium, BundleSolver};
use super::vector::{columns, dot};
use super::walk::Walk;
use super::{Bundle, SAME};
use nalgebra::Vector3;

/// Contact of two neighbours at one place.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint {
    /// Length of the centreline from the plate (m).
    pub length: f64,
    /// Labels of the outer and the inner tube (m).
    pub labels: [f64; 2],
    /// Force of the outer tube on the inner one per length of the centreline (N/m), y and z of the untwisted frame, which at the plate is that of the base.
    pub across: [f64; 2],
    /// The same in the base frame.
    pub force: Vector3<f64>,
}

/// Contact of two neighbours.
#[derive(Clone, Debug)]
pub struct PairContact {
    /// Tubes (index from 0).
    pub outer: usize,
    /// The one inside it.
    pub inner: usize,
    /// From the base to the tip; two places of the same length are the sides of a jump.
    pub points: Vec<ContactPoint>,
}

impl PairContact {
    /// Greatest force per length (N/m).
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.points.iter().fold(0.0, |most, point| most.max(point.force.norm()))
    }

    /// The force (N/m), base frame, at a label of the outer tube (m), linear between points; `None` where the pair does not reach.
    #[must_use]
    pub fn at(&self, label: f64) -> Option<Vector3<f64>> {
        let next = self.points.partition_point(|point| point.labels[0] < label).max(1);
        let (a, b) = (self.points.get(next - 1)?, self.points.get(next)?);
        let way = b.labels[0] - a.labels[0];
        let share = if way > 0.0 { (label - a.labels[0]) / way } else { 1.0 };
        (share >= -BEFORE).then(|| a.force + (b.force - a.force) * share)
    }
}

/// A force at one place: at the plate, where stiffness jumps, at joints and tips.
#[derive(Clone, Copy, Debug)]
pub struct PointContact {
    /// Length of the centreline from the plate (m).
    pub length: f64,
    /// Tube (index from 0) on which, with those inside it, its neighbour or the plate presses.
    pub inner: usize,
    /// Force (N), base frame.
    pub force: Vector3<f64>,
    /// Couple (N m), base frame: without clearance that of a pair of forces.
    pub couple: Vector3<f64>,
}

/// How the tubes of an equilibrium press on each other.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// From outside to inside.
    pub pairs: Vec<PairContact>,
    /// Point forces from the base to the tip; those at the plate come first.
    pub points: Vec<PointContact>,
    /// Greatest sum of the forces on all tubes, loads included (N/m): none in exact arithmetic.
    pub residual: f64,
}

/// One section.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    /// Events that were passed before it, and before the smooth span that it belongs to.
    pub passed: usize,
    pub span: usize,
    pub length: f64,
    pub tubes: Vec<usize>,
    /// Label at which the piece of every tube ends (m), and whether its fields jump there.
    pieces: Vec<(f64, bool)>,
    pub sides: Vec<Side<f64>>,
    states: Vec<TubeState<f64>>,
    /// Per tube: N, then y and z of F, of M and of w.
    axial: Vec<f64>,
    shear: Vec<[f64; 2]>,
    moment: Vec<[f64; 2]>,
    weight: Vec<[f64; 2]>,
    omega: [f64; 2],
    across: [Vector3<f64>; 2],
    /// Per tube: q.
    pressed: Vec<[f64; 2]>,
}

/// Sections nearer than this part of their greatest distance are one.
const NEAR: f64 = 0.3;
/// Part of a distance by which the first point of a pair may lie behind a label.
const BEFORE: f64 = 0.3;
/// Jumps below this part of the greatest value are those of fitted fields, where nothing jumps.
const SMOOTH: f64 = 1e-5;

impl BundleSolver<'_> {
    /// How the tubes press on each other in an equilibrium, at places at most `spacing` (m) apart. `None` where a section does not balance.
    #[must_use]
    pub fn contact(&self, equilibrium: &BundleEquilibrium, spacing: f64) -> Option<Contact> {
        let cuts = self.cuts(equilibrium, spacing, &mut Vec::new())?;
        Some(contact(self.bundle, &cuts))
    }

    /// Sections with what every tube carries. Spans between which nothing jumps are one: `spans` names those that
    /// are left by the events passed before them, or is filled where it is empty.
    pub(super) fn cuts(
        &self,
        equilibrium: &BundleEquilibrium,
        spacing: f64,
        spans: &mut Vec<usize>,
    ) -> Option<Vec<Cut>> {
        let mut cuts: Vec<Cut> = Vec::new();
        let mut balanced = true;
        let mut see = |section: &Section<f64>| match cut(section) {
            Ok(cut) => cuts.push(cut),
            Err(Unbalanced) => balanced = false,
        };
        let walked = self.with_walk(equilibrium, |walk, base| {
            let walk = Walk { posed: true, longest: spacing, ..walk };
            walk.run(base, &mut equilibrium.between.clone(), Some(&mut see)).is_ok()
        });
        if !(balanced && walked) {
            return None;
        }
        if spans.is_empty() {
            *spans = smooth(&cuts);
        }
        for cut in &mut cuts {
            let beyond = spans.partition_point(|span| *span <= cut.passed).max(1);
            cut.span = spans.get(beyond - 1).copied().unwrap_or_default();
        }
        let mut cuts = thinned(cuts, NEAR * spacing);
        for span in cuts.chunk_by_mut(|a, b| a.span == b.span) {
            press(span);
        }
        Some(cuts)
    }
}

/// Spans before which something jumps, and the first.
fn smooth(cuts: &[Cut]) -> Vec<usize> {
    let most = |of: fn(&Cut) -> &Vec<[f64; 2]>| {
        cuts.iter().flat_map(of).flatten().fold(f64::MIN_POSITIVE, |most: f64, own| most.max(own.abs()))
    };
    let sizes = [most(|cut| &cut.shear), most(|cut| &cut.moment)];
    let apart = |a: &[[f64; 2]], b: &[[f64; 2]], size: f64| {
        a.iter().flatten().zip(b.iter().flatten()).any(|(a, b)| (a - b).abs() > SMOOTH * size)
    };
    let jumps = |[before, beyond]: [&Cut; 2]| {
        before.tubes != beyond.tubes
            || before.pieces.iter().zip(&beyond.pieces).any(|(a, b)| (a.0 - b.0).abs() > 0.0 && a.1)
            || apart(&before.shear, &beyond.shear, sizes[0])
            || apart(&before.moment, &beyond.moment, sizes[1])
    };
    let pairs = cuts.windows(2).map(|pair| [&pair[0], &pair[1]]);
    let next = pairs.filter(|pair| pair[0].span != pair[1].span && jumps(*pair)).map(|pair| pair[1].span);
    cuts.first().map(|first| first.span).into_iter().chain(next).collect()
}

/// The first and last section of every span, and between them those that stand no closer than `close` (m).
fn thinned(cuts: Vec<Cut>, close: f64) -> Vec<Cut> {
    let mut kept: Vec<Cut> = Vec::with_capacity(cuts.len());
    for cut in cuts {
        let same = |other: &Cut| other.span == cut.span;
        if kept.last().is_some_and(|last| same(last) && cut.length - last.length < close) {
            // The last of a span takes the place of what stands close before it; the first stays.
            if kept.len() > 1 && same(&kept[kept.len() - 2]) {
                kept.pop();
            } else if kept.last().is_some_and(|last| cut.length <= last.length) {
                continue;
            }
        }
        kept.push(cut);
    }
    // A section between two events at one place has no length along which a force could act.
    let alone = |i: usize| {
        let other =
            |j: Option<usize>| j.and_then(|j| kept.get(j)).is_some_and(|other| other.span == kept[i].span);
        !other(i.checked_sub(1)) && !other(Some(i + 1))
    };
    let lone: Vec<bool> = (0..kept.len()).map(alone).collect();
    kept.into_iter().zip(lone).filter(|(_, lone)| !lone).map(|(cut, _)| cut).collect()
}

fn cut(section: &Section<f64>) -> Result<Cut, Unbalanced> {
    let flow = section.flow;
    let mut along: Flow<Dual<2>> = flow.along()?;
    let ([wy, wz], carried) = along.carried()?;
    let (omega, command) = ([wy.value(), wz.value()], flow.command);
    let [x, y, z] = columns(flow.pose().1);
    let mut cut = Cut {
        passed: flow.passed,
        span: flow.passed,
        length: flow.length(),
        tubes: flow.present.clone(),
        pieces: flow.pieces.iter().map(|piece| (piece.to, piece.jumps)).collect(),
        sides: Vec::new(),
        states: Vec::new(),
        axial: Vec::new(),
        shear: Vec::new(),
        moment: Vec::new(),
        weight: Vec::new(),
        omega,
        across: [y, z].map(Vector3::from),
        pressed: Vec::new(),
    };
    for (place, (&tube, own)) in flow.present.iter().zip(carried).enumerate() {
        let [advance, twist] = section.rates[place];
        let values = &flow.values[4 * place..];
        let state = TubeState { label: values[0], tension: values[1], angle: values[2], torque: values[3] };
        cut.states.push(state);
        cut.sides.push(Side { label: values[0], angle: values[2], advance, twist });
        let Carried { axial, moment: [about, my, mz], mass, arm } = own;
        let gravity = command.gravity.unwrap_or_default();
        let [gx, gy, gz] = [x, y, z].map(|axis| dot(axis, gravity) * mass.value());
        let mut weight = [gy, gz];
        if tube == 0 {
            for &number in &flow.distributed {
                let force = array(&command.distributed[number].force);
                weight = [weight[0] + advance * dot(force, y), weight[1] + advance * dot(force, z)];
            }
        }
        let couple = [arm[1].value() * gx, -arm[0].value() * gx];
        cut.shear.push([
            -(mz.slopes()[0] - about.value() * omega[0]) - couple[1],
            my.slopes()[0] + about.value() * omega[1] + couple[0],
        ]);
        cut.axial.push(axial.value());
        cut.moment.push([my.value(), mz.value()]);
        cut.weight.push(weight);
    }
    Ok(cut)
}

/// Finds q along one span.
fn press(span: &mut [Cut]) {
    let at: Vec<f64> = span.iter().map(|cut| cut.length).collect();
    let tubes = span.first().map_or(0, |cut| cut.tubes.len());
    for tube in 0..tubes {
        let slope = [0, 1].map(|axis| {
            let shear: Vec<f64> = span.iter().map(|cut| cut.shear[tube][axis]).collect();
            slopes(&at, &shear)
        });
        for (i, cut) in span.iter_mut().enumerate() {
            let (axial, [y, z]) = (cut.axial[tube], cut.weight[tube]);
            let [wy, wz] = cut.omega;
            cut.pressed.push([-(slope[0][i] + axial * wz) - y, -(slope[1][i] - axial * wy) - z]);
        }
    }
}

impl Cut {
    /// Force on the tubes from one place on inwards per length (N/m).
    pub fn on_those_inside(&self, place: usize) -> [f64; 2] {
        self.pressed[place..].iter().fold([0.0; 2], |sum, q| [sum[0] + q[0], sum[1] + q[1]])
    }

    fn turned(&self, [y, z]: [f64; 2]) -> Vector3<f64> {
        self.across[0] * y + self.across[1] * z
    }

    /// Sum over the tubes from one (index) on inwards, in the base frame.
    fn inwards(&self, tube: usize, of: &[[f64; 2]]) -> Vector3<f64> {
        let own = self.tubes.iter().zip(of).filter(|(t, _)| **t >= tube);
        own.map(|(_, value)| self.turned(*value)).sum()
    }
}

fn contact(bundle: &Bundle, cuts: &[Cut]) -> Contact {
    let mut found = Contact::default();
    for cut in cuts {
        found.residual = cut.on_those_inside(0).iter().fold(found.residual, |most, q| most.max(q.abs()));
        for (place, tubes) in cut.tubes.windows(2).enumerate() {
            let (outer, inner) = (tubes[0], tubes[1]);
            let across = cut.on_those_inside(place + 1);
            let labels = [place, place + 1].map(|p| cut.sides[p].label);
            let point = ContactPoint { length: cut.length, labels, across, force: cut.turned(across) };
            match found.pairs.iter_mut().find(|pair| (pair.outer, pair.inner) == (outer, inner)) {
                Some(pair) => pair.points.push(point),
                None => found.pairs.push(PairContact { outer, inner, points: vec![point] }),
            }
        }
    }
    found.pairs.sort_by_key(|pair| (pair.outer, pair.inner));
    let Some(first) = cuts.first() else { return found };
    let held = plate(bundle, first);
    for (place, &tube) in first.tubes.iter().enumerate().skip(1) {
        found.points.push(PointContact {
            length: 0.0,
            inner: tube,
            force: -first.inwards(tube, &first.shear),
            couple: held[place..].iter().map(|couple| first.turned(*couple)).sum(),
        });
    }
    for (place, before) in cuts.iter().enumerate() {
        let beyond = cuts.get(place + 1);
        if beyond.is_some_and(|beyond| beyond.span == before.span) {
            continue;
        }
        for &tube in before.tubes.iter().skip(1) {
            let jump = |of: fn(&Cut) -> &Vec<[f64; 2]>| {
                before.inwards(tube, of(before)) - beyond.map_or(Vector3::zeros(), |b| b.inwards(tube, of(b)))
            };
            let [force, couple] = [jump(|cut| &cut.shear), jump(|cut| &cut.moment)];
            found.points.push(PointContact { length: before.length, inner: tube, force, couple });
        }
    }
    found
}

/// Couple (N m) in y and z of the untwisted frame with which guide and plate hold every tube: in the guide it is straight.
pub(super) fn plate(bundle: &Bundle, first: &Cut) -> Vec<[f64; 2]> {
    let each = first.tubes.iter().zip(&first.states).zip(&first.moment);
    each.map(|((&tube, state), moment)| {
        let piece = bundle.tubes[tube].piece_at(state.label - SAME * bundle.length);
        let below = Tube::new(piece, *state, None, false).plain([0.0; 2]).moment;
        [below[0] - moment[0], below[1] - moment[1]]
    })
    .collect()
}
