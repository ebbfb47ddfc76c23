//! Scrambled Halton points: quasi-random samples of the unit cube.
//!
//! Coordinate j of point i is the radical inverse of i in the j-th prime b, every digit sent through a random
//! permutation of its own (Owen, "A randomized Halton algorithm in R", 2017; `scipy.stats.qmc.Halton` does the same). Unlike
//! plain Halton points these do not line up in high dimensions, unlike 32-bit Sobol tables they go on for ever.

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Permuted digits of every coordinate.
#[derive(Clone, Debug)]
pub(crate) struct Halton {
    coordinates: Vec<Coordinate>,
}

#[derive(Clone, Debug)]
struct Coordinate {
    base: u64,
    /// One permutation per digit, most significant digit of the result first.
    permutations: Vec<Vec<u32>>,
    /// What the digits from each on add where they are all zero.
    tails: Vec<f64>,
}

impl Halton {
    pub fn new(dimensions: usize, seed: u64) -> Self {
        let coordinates = primes().take(dimensions).enumerate().map(|(j, base)| {
            // A stream per coordinate: an axis more does not change those before it.
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(j as u64);
            // Digits to the precision of f64.
            let mut permutations = Vec::new();
            let mut resolved = 1.0;
            while resolved > f64::EPSILON {
                let mut permutation: Vec<u32> = (0..base).collect();
                permutation.shuffle(&mut random);
                permutations.push(permutation);
                resolved /= f64::from(base);
            }
            let mut tails = vec![0.0; permutations.len() + 1];
            for (digit, permutation) in permutations.iter().enumerate().rev() {
                tails[digit] = (tails[digit + 1] + f64::from(permutation[0])) / f64::from(base);
            }
            Coordinate { base: u64::from(base), permutations, tails }
        });
        Self { coordinates: coordinates.collect() }
    }

    /// Coordinate `dimension` of point `index`, in (0, 1).
    pub fn at(&self, index: u64, dimension: usize) -> f64 {
        let Coordinate { base, permutations, tails } = &self.coordinates[dimension];
        let (mut rest, mut scale, mut value) = (index, 1.0, 0.0);
        for (permutation, tail) in permutations.iter().zip(tails) {
            if rest == 0 {
                value += scale * tail;
                break;
            }
            scale /= *base as f64;
            // A remainder by the base is a small number.
            #[allow(clippy::cast_possible_truncation)]
            let digit = (rest % base) as usize;
            value += scale * f64::from(permutation[digit]);
            rest /= base;
        }
        // Neither 0 nor, after rounding, 1.
        value.clamp(f64::MIN_POSITIVE, 1.0 - 0.5 * f64::EPSILON)
    }
}

fn primes() -> impl Iterator<Item = u32> {
    (2..).filter(|n: &u32| (2..=n.isqrt()).all(|d| n % d != 0))
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
mod tests {
    use super::{Halton, primes};

    #[test]
    fn the_first_primes() {
        assert_eq!(primes().take(8).collect::<Vec<_>>(), [2, 3, 5, 7, 11, 13, 17, 19]);
    }

    /// bᵏ successive points have exactly one coordinate in each of the bᵏ equal intervals.
    #[test]
    fn every_coordinate_is_stratified() {
        let points = Halton::new(6, 7);
        for (dimension, size) in [(0, 1024_u32), (1, 729), (2, 625), (5, 169)] {
            let mut seen = vec![0; size as usize];
            for i in 0..u64::from(size) {
                seen[(points.at(i, dimension) * f64::from(size)) as usize] += 1;
            }
            assert!(seen.iter().all(|n| *n == 1), "dimension {dimension}: {seen:?}");
        }
    }

    /// The integral of Π 2 u_j over the cube is 1; 10⁴ random points miss it by some per cent.
    #[test]
    fn integrates_far_better_than_chance() {
        let (dimensions, count) = (5, 10_000);
        for seed in 0..4 {
            let points = Halton::new(dimensions, seed);
            let mean: f64 = (0..count)
                .map(|i| (0..dimensions).map(|j| 2.0 * points.at(i, j)).product::<f64>())
                .sum::<f64>()
                / count as f64;
            assert!((mean - 1.0).abs() < 2e-3, "seed {seed}: {mean}");
        }
    }

    #[test]
    fn seeds_differ_and_repeat_and_axes_are_apart() {
        let (one, other, more) = (Halton::new(2, 1), Halton::new(2, 2), Halton::new(3, 1));
        assert!(one.at(5, 0) != other.at(5, 0));
        assert_eq!(one.at(5, 1), more.at(5, 1));
        let all = (0..100_000).flat_map(|i| [one.at(i, 0), one.at(i, 1)]);
        assert!(all.into_iter().all(|u| u > 0.0 && u < 1.0));
    }
}
