//! How many directions there are in which the energy of an equilibrium falls: the Morse index, by elimination along the bundle.
//!
//! The second variation of the energy is that of an optimal control problem in time t = s (Bryson and Ho 1975, chapter 6). Between
//! two events the configuration q holds the labels x and angles α of the tubes, and under loads the displacement ξ = (θ, τ) of the section,
//! g → exp(ξ) g. Its controls are the change of ω and, in place of those of the twists, of the torques π (where a tube stretches, of its
//! tension T). With E of [`section`](super::section), y what E depends on besides z = (π, T), and η the stretch of the time of the
//! span, whose end moves until the event is met:
//!
//! ```text
//! δ²U = ∫ δyᵀ E_yy δy − δzᵀ E_zz δz + 2 η E_q·δq − ⟨μ, [ξ, ξ']⟩ ds + second variations of the loads' potentials,
//! δx' = E_T· + η x' ,  δα' = −E_π· + η α' ,  ξ' = Ad_g (δω, 0) + η Ad_g (ω, e₁)
//! ```
//!
//! μ are moment about the origin and force on the section. Conditions at events, joints and plate have multipliers ν. Controls are eliminated
//! interval by interval from the tip on (a discrete Riccati recursion in q, η and ν); by Haynsworth's theorem (1968) the negative
//! eigenvalues of the pivots add up to those of the whole, and every multiplier brings one of its own. What is counted so sees any number
//! of directions at once, which the sign of a determinant does not.

use super::Bundle;
use super::flow::Section;
use super::number::{Dual, Number};
use super::prepared::{Applied, Prepared, Stop, array};
use super::section::Local;
use super::solve::{BundleCommand, BundleEquilibrium, BundleSolver};
use super::vector::{columns, cross, dot, sum};
use super::walk::Walk;
use crate::solve::Drive;
use nalgebra::DMatrix;
use std::ops::AddAssign;

/// Intervals of a bundle's length at least.
const INTERVALS: f64 = 32.0;
/// Steps of the integration at least; sections between their ends are interpolated.
const STEPS: f64 = 8.0;
/// θ, τ and a turn about the tangent.
const MOVES: usize = 7;
const LANES: usize = 1 + MOVES;
/// Pivots below this are none, in rows of size one.
const NOTHING: f64 = 1e-11;
/// A pivot is a single one where it is at least this part of what stands off the diagonal: (1 + √17)/8.
const SINGLE: f64 = 0.64;
/// Times that rows are scaled.
const EQUAL: usize = 3;

/// Moves and rates of a section's pose.
#[derive(Clone, Copy, Debug)]
struct Pose {
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    force: [f64; 3],
    moment: [f64; 3],
}

/// Coefficients at one section. Columns are q, η, and the controls.
struct Cut {
    span: usize,
    length: f64,
    present: Vec<usize>,
    angles: Vec<f64>,
    pose: Option<Pose>,
    /// Rates of q.
    rates: DMatrix<f64>,
    form: DMatrix<f64>,
}

/// The units in which all is counted: length (m), and energy (N m).
struct Units {
    length: f64,
    force: f64,
}

impl BundleSolver<'_> {
    /// Number of negative eigenvalues of the second variation, with the motors' conditions: 0 where the equilibrium is stable. Loads without
    /// potential enter with their symmetric part. `None` where it cannot be told: an eigenvalue vanishes.
    #[must_use]
    pub fn inertia(&self, equilibrium: &BundleEquilibrium) -> Option<usize> {
        let command = Prepared::new(self.bundle, &equilibrium.command.loads, equilibrium.lengthening);
        let units = Units { length: self.bundle.length, force: command.force_scale };
        let mut cuts = Vec::new();
        let keys = self.with_walk(equilibrium, |walk, base| {
            let walk = Walk {
                longest: self.bundle.length / STEPS,
                spacing: self.bundle.length / INTERVALS,
                posed: walk.command.loaded,
                ..walk
            };
            let mut see = |section: &Section<f64>| cuts.push(Cut::new(section, &units));
            let mut steps = equilibrium.between.clone();
            walk.run(base, &mut steps, Some(&mut see)).ok()?;
            Some((0..).map_while(|number| steps.key(number)).collect::<Vec<_>>())
        })?;
        let mut count = Count::default();
        for (span, &(tube, stop)) in keys.iter().enumerate().rev() {
            let own: Vec<&Cut> = cuts.iter().filter(|cut| cut.span == span).collect();
            let last = own.last()?;
            count.begin(last);
            let (_, stop) = command.stops.get(tube)?.get(stop)?;
            count.event(tube, *stop, last, self.bundle, &command, &units)?;
            for pair in own.windows(2).rev() {
                count.interval(pair[0], pair[1])?;
            }
            let first = own.first()?;
            if last.length - first.length <= 0.0 {
                count.between_events(first);
            }
            count.end()?;
        }
        count.plate(cuts.first()?, self.bundle, &equilibrium.command, &units)
    }
}

impl Cut {
    fn new(section: &Section<f64>, units: &Units) -> Self {
        let flow = section.flow;
        let locals = flow.locals(section.omega);
        let pose = flow.command.loaded.then(|| {
            let (centre, turn) = flow.pose();
            let (force, moment) = flow.loads();
            Pose { centre, axes: columns(turn), force, moment }
        });
        let tubes = locals.len();
        let places = 2 * tubes + if pose.is_some() { 6 } else { 0 };
        let extensible: Vec<usize> =
            (0..tubes).filter(|place| locals[*place].hessian()[(1, 1)] < 0.0).collect();
        let controls = 2 + tubes + extensible.len();
        let width = places + 1 + controls;
        let (mut rates, mut form) = (DMatrix::zeros(places, width), DMatrix::zeros(width, width));
        let first = places + 1;
        let own = Sources { section, pose: pose.as_ref(), units, places, first, extensible: &extensible };
        for (place, local) in locals.iter().enumerate() {
            own.tube(place, local, &mut rates, &mut form);
        }
        if let Some(pose) = &pose {
            own.displacement(pose, &mut rates, &mut form);
        }
        Self {
            span: flow.span,
            length: flow.length() / units.length,
            present: flow.present.clone(),
            angles: (0..tubes).map(|place| flow.angle_of_section(place)).collect(),
            pose,
            rates,
            form,
        }
    }
}

/// Where coefficients of a section come from.
struct Sources<'a> {
    section: &'a Section<'a, f64>,
    pose: Option<&'a Pose>,
    units: &'a Units,
    /// How many q there are, and the column of the first control.
    places: usize,
    first: usize,
    /// Places of tubes that stretch.
    extensible: &'a [usize],
}

impl Sources<'_> {
    /// What one tube adds.
    fn tube(&self, place: usize, local: &Local, rates: &mut DMatrix<f64>, form: &mut DMatrix<f64>) {
        let flow = self.section.flow;
        let Units { length, force } = *self.units;
        let hessian = local.hessian();
        let tubes = flow.present.len();
        // Inputs of the tube that a column moves, and by how much: y, and z.
        let mut y = vec![
            (0, 2 * place, length),
            (2, 2 * place + 1, 1.0),
            (4, self.first, 1.0 / length),
            (5, self.first + 1, 1.0 / length),
        ];
        let mut z = vec![(3, self.first + 2 + place, force * length)];
        if let Some(number) = self.extensible.iter().position(|own| *own == place) {
            z.push((1, self.first + 2 + tubes + number, force));
        }
        let slopes = local.gradient();
        if let Some(pose) = self.pose {
            let at = 2 * tubes;
            // What moves along `by` does with ξ, and how it bends: the form of by·(θ × (θ × point + τ)).
            let mut follow = |row: usize, by: [f64; 3], point: [f64; 3], moves: f64, weight: f64| {
                let turned = cross(point, by);
                for i in 0..3 {
                    y.push((row, at + i, turned[i]));
                    if moves != 0.0 {
                        y.push((row, at + 3 + i, moves * by[i] * length));
                    }
                }
                bend(form, at, by, point, moves * length, weight / force);
            };
            if let Some(gravity) = flow.command.gravity {
                let [_, b_y, b_z] = pose.axes;
                for (row, point, moves) in [(6, pose.centre, 1.0), (7, b_y, 0.0), (8, b_z, 0.0)] {
                    follow(row, gravity, point, moves, slopes[row]);
                }
            }
            if flow.present[place] == 0 {
                for &number in &flow.distributed {
                    let pull = array(&flow.command.distributed[number].force).map(|f| -f);
                    follow(1, pull, pose.centre, 1.0, slopes[1]);
                }
            }
        }
        for &(row, column, factor) in y.iter().chain(&z) {
            rates[(2 * place, column)] += hessian[(1, row)] * factor;
            rates[(2 * place + 1, column)] -= hessian[(3, row)] * factor * length;
        }
        let eta = self.places;
        rates[(2 * place, eta)] = slopes[1];
        rates[(2 * place + 1, eta)] = -slopes[3] * length;
        for (inputs, sign) in [(&y, 1.0 / force), (&z, -1.0 / force)] {
            for &(row, column, factor) in inputs {
                for &(other, with, share) in inputs {
                    form[(column, with)] += sign * factor * share * hessian[(row, other)];
                }
            }
        }
        for &(row, column, factor) in y.iter().filter(|(_, column, _)| *column < eta) {
            let slope = slopes[row] * factor / force;
            form[(eta, column)] += slope;
            form[(column, eta)] += slope;
        }
    }

    /// ξ' and −⟨μ, [ξ, ξ']⟩.
    fn displacement(&self, pose: &Pose, rates: &mut DMatrix<f64>, form: &mut DMatrix<f64>) {
        let Units { length, force } = *self.units;
        let at = self.places - 6;
        let [t, b_y, b_z] = pose.axes;
        let [wy, wz] = self.section.omega;
        let turn = [0, 1, 2].map(|i| b_y[i] * wy + b_z[i] * wz);
        for (column, spin, along) in [
            (self.first, b_y.map(|b| b / length), [0.0; 3]),
            (self.first + 1, b_z.map(|b| b / length), [0.0; 3]),
            (self.places, turn, t),
        ] {
            let shift = sum(cross(pose.centre, spin), along);
            // M·(θ × θ') + F·(θ × τ' − θ' × τ), by θ and τ.
            let by_turn = sum(cross(spin, pose.moment), cross(shift, pose.force));
            let by_shift = cross(spin, pose.force);
            for i in 0..3 {
                rates[(at + i, column)] = spin[i] * length;
                rates[(at + 3 + i, column)] = shift[i];
                for (row, value) in [(at + i, by_turn[i]), (at + 3 + i, by_shift[i] * length)] {
                    form[(row, column)] -= 0.5 * value / force;
                    form[(column, row)] -= 0.5 * value / force;
                }
            }
        }
    }
}

/// Adds weight · by·(θ × (θ × point + moves τ)) to a form whose columns from `at` on are θ and τ.
fn bend(form: &mut DMatrix<f64>, at: usize, by: [f64; 3], point: [f64; 3], moves: f64, weight: f64) {
    let along = dot(by, point);
    for i in 0..3 {
        for j in 0..3 {
            form[(at + i, at + j)] += weight * 0.5 * (by[i] * point[j] + by[j] * point[i]);
        }
        form[(at + i, at + i)] -= weight * along;
    }
    // by·(θ × τ) = θ·(τ × by).
    let [x, y, z] = by.map(|b| 0.5 * weight * moves * b);
    for (i, j, value) in [(0, 1, z), (0, 2, -y), (1, 0, -z), (1, 2, x), (2, 0, y), (2, 1, -x)] {
        form[(at + i, at + 3 + j)] += value;
        form[(at + 3 + j, at + i)] += value;
    }
}

/// The elimination so far: the form that is left of what lies beyond, in q, η, and multipliers.
#[derive(Default)]
struct Count {
    form: DMatrix<f64>,
    present: Vec<usize>,
    /// How many q there are.
    places: usize,
    negative: usize,
    multipliers: usize,
}

impl Count {
    /// Takes up the tubes of a section before the event, and the η of its span.
    fn begin(&mut self, cut: &Cut) {
        let places = cut.rates.nrows();
        let old = self.form.ncols() - self.places;
        let mut map: Vec<usize> = Vec::with_capacity(self.form.ncols());
        for tube in &self.present {
            let place = cut.present.iter().position(|own| own == tube).unwrap_or_default();
            map.extend([2 * place, 2 * place + 1]);
        }
        let pose = 2 * cut.present.len();
        map.extend((map.len()..self.places).enumerate().map(|(i, _)| pose + i));
        map.extend((0..old).map(|i| places + 1 + i));
        let mut form = DMatrix::zeros(places + 1 + old, places + 1 + old);
        for (i, &to) in map.iter().enumerate() {
            for (j, &other) in map.iter().enumerate() {
                form[(to, other)] = self.form[(i, j)];
            }
        }
        (self.form, self.places, self.present) = (form, places, cut.present.clone());
    }

    /// A condition on q, with its multiplier, to which it gives way by a factor.
    fn condition(&mut self, row: &[(usize, f64)], give: f64) {
        let last = self.form.ncols();
        let form = std::mem::take(&mut self.form);
        self.form = form.resize(last + 1, last + 1, 0.0);
        for &(column, factor) in row {
            self.form[(last, column)] = factor;
            self.form[(column, last)] = factor;
        }
        self.form[(last, last)] = -give;
        self.multipliers += 1;
    }

    fn event(
        &mut self,
        tube: usize,
        stop: Stop,
        cut: &Cut,
        bundle: &Bundle,
        command: &Prepared,
        units: &Units,
    ) -> Option<()> {
        let place = cut.present.iter().position(|own| *own == tube)?;
        match stop {
            Stop::Piece(_) | Stop::Begin(_) | Stop::End(_) => {}
            Stop::Load(load) => self.load(&command.points.get(load)?.1, place, cut, units)?,
            Stop::Station(number) => {
                let station = bundle.stations.get(number)?;
                let places: Vec<usize> =
                    station.iter().filter_map(|(t, _)| cut.present.iter().position(|own| own == t)).collect();
                for &other in places.iter().filter(|other| **other != place) {
                    self.condition(&[(2 * other, 1.0)], command.lengthening.give);
                    self.condition(&[(2 * other + 1, 1.0), (2 * place + 1, -1.0)], 0.0);
                }
                let goes_on =
                    |tube: &usize| !station.iter().any(|(t, l)| t == tube && *l >= bundle.tubes[*t].tip);
                if !cut.present.iter().any(goes_on) {
                    for load in &command.tip {
                        self.load(load, *places.first()?, cut, units)?;
                    }
                }
            }
        }
        // The event of the span, last.
        self.condition(&[(2 * place, 1.0)], 0.0);
        Some(())
    }

    /// A load on the section of the tube at `place`. What has no energy enters with its symmetric part.
    fn load(&mut self, load: &Applied, place: usize, cut: &Cut, units: &Units) -> Option<()> {
        let Units { length, force } = *units;
        let pose = cut.pose.as_ref()?;
        let (sin, cos) = cut.angles[place].sin_cos();
        let [t, b_y, b_z] = pose.axes;
        let across = [0, 1, 2].map(|i| [b_y[i] * cos + b_z[i] * sin, b_z[i] * cos - b_y[i] * sin]);
        let axes = [t, across.map(|a| a[0]), across.map(|a| a[1])];
        // Moved by θ and τ, and turned about the tangent by ζ.
        let turn = [0, 1, 2].map(|i| Dual::<LANES>::input(0.0, i));
        let shift = [3, 4, 5].map(|i| Dual::input(0.0, i) * length);
        let spin = sum(turn, t.map(Dual::constant).map(|c| c * Dual::input(0.0, 6)));
        let moved = |v: [f64; 3], by: [Dual<LANES>; 3]| {
            let v = v.map(Dual::constant);
            sum(v, cross(by, v))
        };
        let centre = sum(moved(pose.centre, turn), shift);
        let (pull, moment, arm) = load.at(&centre, &axes.map(|a| moved(a, spin)));
        let point = sum(centre, arm);
        let (pull_now, arm) = (pull.map(Number::value), arm.map(Number::value));
        let weight = -1.0 / (force * length);
        let (at, own) = (self.places - 6, 2 * place + 1);
        let column = |i: usize| if i < 6 { at + i } else { own };
        for i in 0..MOVES {
            for j in 0..MOVES {
                let work: f64 = pull.iter().zip(&point).map(|(f, p)| f.slopes()[i] * p.slopes()[j]).sum();
                self.form[(column(i), column(j))] += 0.5 * weight * work;
                self.form[(column(j), column(i))] += 0.5 * weight * work;
            }
        }
        bend(&mut self.form, at, pull_now, point.map(Number::value), length, weight);
        // 2 ζ F·(θ × (t × arm)) + ζ² F·(t × (t × arm)), and ζ M·(θ × t).
        let turned = cross(t, arm);
        let with_turn = cross(turned, pull_now);
        let with_moment = cross(t, moment.map(Number::value));
        for i in 0..3 {
            let value = weight * (with_turn[i] + 0.5 * with_moment[i]);
            self.form[(own, at + i)] += value;
            self.form[(at + i, own)] += value;
        }
        self.form[(own, own)] += weight * dot(pull_now, cross(t, turned));
        Some(())
    }

    /// Goes back over one interval: midpoint rule, controls constant.
    fn interval(&mut self, before: &Cut, after: &Cut) -> Option<()> {
        let step = after.length - before.length;
        if step <= 0.0 {
            return Some(());
        }
        let rates = (&before.rates + &after.rates) * (0.5 * step);
        let form = (&before.form + &after.form) * (0.5 * step);
        let (n, width) = (self.places, rates.ncols());
        let kept = self.form.ncols();
        // q after the interval by q before it, η and the controls.
        let mut left = rates.columns(0, n) * -0.5;
        let mut after = rates;
        after.columns_mut(0, n).scale_mut(0.5);
        for i in 0..n {
            left[(i, i)] += 1.0;
            after[(i, i)] += 1.0;
        }
        if !left.lu().solve_mut(&mut after) {
            return None;
        }
        let mut middle = &after * 0.5;
        for i in 0..n {
            middle[(i, i)] += 0.5;
        }
        let by_others = form.view((0, n), (n, width - n));
        let mut by_middle = form.view((0, 0), (n, n)) * &middle;
        by_middle.columns_mut(n, width - n).add_assign(&by_others);
        let beyond = self.form.columns(0, n) * &after;
        let mut own = middle.tr_mul(&by_middle);
        own.gemm_tr(1.0, &after, &beyond.rows(0, n), 1.0);
        own.rows_mut(n, width - n).gemm_tr(1.0, &by_others, &middle, 1.0);
        own.view_mut((n, n), (width - n, width - n)).add_assign(&form.view((n, n), (width - n, width - n)));
        // Columns: q, η and multipliers as before, then the controls.
        let place = |column: usize| if column <= n { column } else { kept + column - n - 1 };
        let mut all = std::mem::take(&mut self.form).resize(kept + width - n - 1, kept + width - n - 1, 0.0);
        all.view_mut((0, 0), (kept, n)).fill(0.0);
        all.view_mut((0, n), (n, kept - n)).fill(0.0);
        for column in 0..width {
            for row in 0..width {
                all[(place(row), place(column))] += own[(row, column)];
            }
            for row in n..kept {
                all[(row, place(column))] += beyond[(row, column)];
                all[(place(column), row)] += beyond[(row, column)];
            }
        }
        self.form = all;
        self.eliminate(kept)
    }

    /// Goes back over a span without length, between events that coincide: its η is the length that it gets.
    fn between_events(&mut self, cut: &Cut) {
        let n = self.places;
        let (moved, slope) = (cut.rates.column(n), cut.form.view((0, n), (n, 1)));
        let mut beyond = DMatrix::identity(self.form.ncols(), self.form.ncols());
        beyond.view_mut((0, n), (n, 1)).copy_from(&moved);
        self.form = beyond.transpose() * &self.form * &beyond;
        for i in 0..n {
            self.form[(i, n)] += slope[i];
            self.form[(n, i)] += slope[i];
            self.form[(n, n)] += slope[i] * moved[i];
        }
    }

    /// The span is over: its η and the multiplier of its event go.
    fn end(&mut self) -> Option<()> {
        let last = self.form.ncols() - 1;
        // η goes where the last but one multiplier is, and all between move up.
        let mut order: Vec<usize> = (0..last).filter(|own| *own != self.places).collect();
        order.extend([self.places, last]);
        self.form = self.form.select_rows(&order).select_columns(&order);
        self.eliminate(last - 1)
    }

    /// Makes the form stationary by all but its first columns.
    fn eliminate(&mut self, kept: usize) -> Option<()> {
        self.negative += eliminate(&mut self.form, kept)?;
        Some(())
    }

    /// What motors leave free at the plate.
    fn plate(mut self, cut: &Cut, bundle: &Bundle, command: &BundleCommand, units: &Units) -> Option<usize> {
        let Units { length, force } = *units;
        let mut free = Vec::new();
        for (place, &tube) in cut.present.iter().enumerate() {
            let drive = command.drives.get(tube)?;
            let shaft = bundle.tubes[tube].shaft;
            for (column, drive, spring) in [
                (2 * place, drive.translation, shaft.map(|s| s.axial * length / force)),
                (2 * place + 1, drive.rotation, shaft.map(|s| s.torsional / (force * length))),
            ] {
                match (drive, spring) {
                    (Drive::Motion(_), None) => {}
                    (Drive::Motion(_), Some(spring)) => {
                        self.form[(column, column)] += spring;
                        free.push(column);
                    }
                    (Drive::Effort(_), _) => free.push(column),
                }
            }
        }
        free.extend(self.places..self.form.ncols());
        let mut left = self.form.select_rows(&free).select_columns(&free);
        (self.negative + eliminate(&mut left, 0)?).checked_sub(self.multipliers)
    }
}

/// Makes a symmetric form stationary by all but its first columns, with pivots of one or two columns (Bunch and Parlett 1971): how many of
/// their eigenvalues are negative; `None` where one is neither.
fn eliminate(form: &mut DMatrix<f64>, kept: usize) -> Option<usize> {
    let total = form.ncols();
    // In units in which every row has the same size, which changes no sign.
    for _ in 0..EQUAL {
        for i in kept..total {
            let size = form.view((kept, i), (total - kept, 1)).amax().sqrt();
            if size > 0.0 {
                form.column_mut(i).unscale_mut(size);
                form.row_mut(i).unscale_mut(size);
            }
        }
    }
    let (mut left, mut negative) = (total, 0);
    while left > kept {
        let (mut single, mut pair) = ((0.0, left - 1), (0.0, [left - 1, left - 1]));
        for i in kept..left {
            if form[(i, i)].abs() > single.0 {
                single = (form[(i, i)].abs(), i);
            }
            for j in kept..i {
                if form[(j, i)].abs() > pair.0 {
                    pair = (form[(j, i)].abs(), [j, i]);
                }
            }
        }
        if f64::max(single.0, pair.0) <= NOTHING || !(single.0 + pair.0).is_finite() {
            return None;
        }
        let size = if single.0 >= SINGLE * pair.0 {
            exchange(form, single.1, left - 1);
            1
        } else {
            exchange(form, pair.1[1], left - 1);
            exchange(form, pair.1[0], left - 2);
            2
        };
        left -= size;
        let (rest, pivots) = form.as_mut_slice().split_at_mut(left * total);
        let first = &pivots[..total];
        if size == 1 {
            let pivot = first[left];
            negative += usize::from(pivot < 0.0);
            for (column, own) in rest.chunks_exact_mut(total).zip(first) {
                subtract(&mut column[..left], own / pivot, first);
            }
        } else {
            let second = &pivots[total..2 * total];
            let (a, b, d) = (first[left], second[left], second[left + 1]);
            // Off the diagonal it is greater than on it: one eigenvalue of either sign.
            let determinant = a * d - b * b;
            negative += 1;
            for (j, column) in rest.chunks_exact_mut(total).enumerate() {
                let (own, other) = (first[j] / determinant, second[j] / determinant);
                subtract(&mut column[..left], d * own - b * other, first);
                subtract(&mut column[..left], a * other - b * own, second);
            }
        }
    }
    *form = form.view((0, 0), (kept, kept)).into_owned();
    Some(negative)
}

/// Exchanges two columns, and their rows.
fn exchange(form: &mut DMatrix<f64>, i: usize, j: usize) {
    form.swap_columns(i, j);
    form.swap_rows(i, j);
}

/// y −= a x, as far as y goes.
fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    if a != 0.0 {
        for (y, x) in y.iter_mut().zip(x) {
            *y -= a * x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::eliminate;
    use nalgebra::{DMatrix, DVector};

    fn negative(form: &DMatrix<f64>) -> usize {
        if form.is_empty() {
            return 0;
        }
        form.clone().symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count()
    }

    /// Negative eigenvalues of the pivots and of what is left add up to those of the whole, whatever the units of its rows are, and with nothing on the diagonal too.
    #[test]
    fn pivots_have_as_many_negative_eigenvalues_as_they_take_away() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        let mut seen = [0; 3];
        for case in 0..300 {
            let (n, kept) = (2 + case % 9, case % 3);
            let units = DVector::from_fn(n, |_, _| (20.0 * random()).exp());
            let mut form = DMatrix::zeros(n, n);
            for i in 0..n {
                for j in 0..=i {
                    let value = if i == j && case % 2 == 0 { 0.0 } else { random() };
                    (form[(i, j)], form[(j, i)]) = (value, value);
                }
            }
            let all = negative(&form);
            let mut left = DMatrix::from_fn(n, n, |i, j| units[i] * units[j] * form[(i, j)]);
            let Some(taken) = eliminate(&mut left, kept) else { continue };
            assert_eq!(left.shape(), (kept, kept));
            // The rows that stay keep their units.
            let own = DMatrix::from_fn(kept, kept, |i, j| left[(i, j)] / (units[i] * units[j]));
            assert_eq!(taken + negative(&own), all, "case {case}: {form}");
            seen[kept] += 1;
        }
        assert!(seen.iter().all(|count| *count > 90), "{seen:?}");
        assert_eq!(eliminate(&mut DMatrix::zeros(2, 2), 0), None);
    }
}
