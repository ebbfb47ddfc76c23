//! What friction is limited by, and the fixed point at which that agrees with the contact force that friction changes.
//!
//! One turn makes limits g of limits x. Anderson's method (1965) goes on from the last few turns together: of f = g − x it takes those combinations in which f is least,
//!
//! ```text
//! x ← g − Σ γ_j (g − g_j) ,   |f − Σ γ_j (f − f_j)| least .
//! ```

use super::Bundle;
use super::contact::{Cut, plate};
use super::friction::{Friction, neighbours, rows};
use super::rubbing::{Columns, Table};
use nalgebra::{DMatrix, DVector};

/// Limits of friction: those of an equilibrium, or what a turn begins with.
#[derive(Clone, Debug)]
pub(super) struct Limits {
    /// μ |p| (N/m) along every pair.
    pub pairs: Vec<([usize; 2], Columns<1>)>,
    /// The same in the guide (N).
    pub guide: Vec<([usize; 2], f64)>,
}

/// Turns before the last that are gone on from.
const DEPTH: usize = 4;
/// Differences of turns below this part of the greatest are not told from rounding.
const SAME: f64 = 1e-6;

/// μ |p| (N/m) of one pair.
pub(super) fn along(cuts: &[Cut], pair: [usize; 2], friction: &Friction) -> Columns<1> {
    rows(cuts, pair, |cut, place| {
        let [y, z] = cut.on_those_inside(place + 1);
        [friction.coefficient * y.hypot(z)]
    })
}

impl Limits {
    pub fn new(bundle: &Bundle, friction: &Friction, cuts: &[Cut]) -> Self {
        let pairs = neighbours(cuts).into_iter().map(|pair| (pair, along(cuts, pair, friction)));
        let mut own = Self { pairs: pairs.collect(), guide: Vec::new() };
        let (Some(length), Some(first)) = (friction.guide, cuts.first()) else { return own };
        let couples = plate(bundle, first);
        for (place, pair) in first.tubes.windows(2).enumerate() {
            let [y, z] = couples[place + 1..].iter().fold([0.0; 2], |sum, c| [sum[0] + c[0], sum[1] + c[1]]);
            own.guide.push(([pair[0], pair[1]], 2.0 * friction.coefficient * y.hypot(z) / length));
        }
        own
    }

    /// What one pair can hold, by the outer tube's label.
    pub fn along(&self, pair: [usize; 2]) -> &[(usize, f64, [f64; 1])] {
        self.pairs.iter().find(|own| own.0 == pair).map_or(&[], |own| &own.1)
    }

    /// Force (N) with which every tube's motor has to pull more since tubes rub in the guide; `ways` tells which way each slides.
    pub fn more(&self, ways: &[f64]) -> Vec<f64> {
        let mut more = vec![0.0; ways.len()];
        for ([outer, inner], limit) in &self.guide {
            let force = limit * (ways[*inner] - ways[*outer]).clamp(-1.0, 1.0);
            more[*inner] += force;
            more[*outer] -= force;
        }
        more
    }

    /// Its numbers where others are known: along the pairs, and of the guide (its length aside) per `length` (m).
    fn numbers(&self, on: &Self, length: f64) -> DVector<f64> {
        let mut numbers = Vec::new();
        for (pair, nodes) in &on.pairs {
            let table = Table::new(self.along(*pair));
            numbers.extend(nodes.iter().map(|(span, label, _)| table.at(*span, *label)[0]));
        }
        for (pair, _) in &on.guide {
            numbers.push(self.guide.iter().find(|own| own.0 == *pair).map_or(0.0, |own| own.1) / length);
        }
        DVector::from_vec(numbers)
    }

    /// The same with other numbers in its places; limits are not negative.
    fn with(mut self, numbers: &DVector<f64>, length: f64) -> Self {
        let mut numbers = numbers.iter().map(|own| own.max(0.0));
        let along = self.pairs.iter_mut().flat_map(|own| &mut own.1);
        for (row, number) in along.zip(&mut numbers) {
            row.2 = [number];
        }
        for (own, number) in self.guide.iter_mut().zip(numbers) {
            own.1 = number * length;
        }
        self
    }
}

/// The last turns: what each began with, and what it made of it.
#[derive(Default)]
pub(super) struct Turns(Vec<[Limits; 2]>);

impl Turns {
    /// What the next turn begins with; `length` (m) is that of the robot.
    pub fn next(&mut self, began: Limits, found: Limits, length: f64) -> Limits {
        let numbers = |own: &Limits| own.numbers(&found, length);
        let (last, change) = (numbers(&found), numbers(&found) - numbers(&began));
        let past: Vec<[DVector<f64>; 2]> = self
            .0
            .iter()
            .map(|own| {
                let [began, found] = own.each_ref().map(numbers);
                [&change - (&found - began), &last - found]
            })
            .collect();
        self.0.push([began, found.clone()]);
        if self.0.len() > DEPTH {
            self.0.remove(0);
        }
        if past.is_empty() || last.is_empty() {
            return found;
        }
        let [changes, ways] =
            [0, 1].map(|k| DMatrix::from_columns(&past.iter().map(|own| own[k].clone()).collect::<Vec<_>>()));
        let svd = changes.svd(true, true);
        let least = SAME * svd.singular_values.max();
        match svd.solve(&change, least) {
            Ok(shares) => found.with(&(last - ways * shares), length),
            Err(_) => found,
        }
    }
}
