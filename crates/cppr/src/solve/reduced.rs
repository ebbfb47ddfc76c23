//! The tangent on the motions that the conditions leave free, in coordinates in which the elastic stiffness is the identity,
//! and its lowest eigenvalue; in all lanes alike, without pivoting.
//!
//! Householder reflections turn the conditions' rows one after another into single coordinates; what is left are the free
//! motions (Golub & Van Loan, Matrix Computations, 5.1 and 5.2). There the elastic stiffness is L Lᵀ (Cholesky) and the tangent
//! becomes L⁻¹ 𝓛 L⁻ᵀ (8.7.2). Reflections again make that tridiagonal (8.3.1), and counting signs in it finds the lowest
//! eigenvalue by bisection (8.4.1).

use crate::dense::{axpy, dot};
use crate::design::fields::FieldJets;
use crate::kinematics::follower::local;
use crate::kinematics::layout::field;
use crate::real::{Real, every};
use crate::solve::system::{Buffers, Scale, System};

/// A condition whose scaled row is less long than this on what the others leave free binds nothing: a locked angle.
const BINDS: f64 = 1e-13;

/// Symmetric matrices are row-major and square.
pub(crate) struct Reduced<S> {
    /// Unit of every coordinate.
    units: Vec<f64>,
    /// The reflections of the conditions, 1 − v vᵀ; the k-th begins with coordinate k.
    reflections: Vec<Vec<S>>,
    /// Lower Cholesky factor of the elastic stiffness.
    lower: Vec<S>,
    pub tangent: Vec<S>,
    /// Free motions: rows of both.
    pub free: usize,
    /// Lanes in which all this holds.
    pub fit: u64,
}

impl<S: Real> Reduced<S> {
    /// From the tangent evaluated last. Loads that have no potential enter with the symmetric part.
    pub fn new(buffers: &mut Buffers<S>, system: &System) -> Self {
        buffers.compose_matrix(system);
        let buffers = &*buffers;
        let n_u = system.layout.unknowns();
        let n = buffers.residual.len();
        let entry = |i: usize, j: usize| buffers.matrix[i * n + j];
        let mut tangent = Vec::with_capacity(n_u * n_u);
        for i in 0..n_u {
            tangent.extend((0..n_u).map(|j| (entry(i, j) + entry(j, i)) * 0.5));
        }
        let mut elastic = elastic_stiffness(buffers, system);
        let mut reflections: Vec<Vec<S>> = Vec::new();
        let mut fit = every::<S>();
        for condition in n_u..n {
            let mut row: Vec<S> = (0..n_u).map(|j| entry(condition, j)).collect();
            for (k, v) in reflections.iter().enumerate() {
                reflect(v, &mut row[k..]);
            }
            let k = reflections.len();
            let (v, length) = householder(&row[k..]);
            let binds = length.mask(|l| l >= BINDS);
            if binds == 0 {
                continue;
            }
            // It binds in some lanes only: they have nothing in common.
            fit &= binds;
            reflect_both(&v, &mut tangent, n_u);
            reflect_both(&v, &mut elastic, n_u);
            reflections.push(v);
        }
        let free = n_u - reflections.len();
        let (mut tangent, mut lower) = (trailing(&tangent, n_u, free), trailing(&elastic, n_u, free));
        fit &= cholesky(&mut lower, free);
        // L⁻¹ 𝓛, then the same of its transpose.
        for _ in 0..2 {
            for i in 0..free {
                let (done, rest) = tangent.split_at_mut(i * free);
                let row = &mut rest[..free];
                for (k, above) in done.chunks_exact(free).enumerate() {
                    axpy(row, -lower[i * free + k], above);
                }
                let inverse = S::one() / lower[i * free + i];
                for entry in row {
                    *entry *= inverse;
                }
            }
            for i in 0..free {
                for j in 0..i {
                    tangent.swap(i * free + j, j * free + i);
                }
            }
        }
        Self { units: buffers.units.clone(), reflections, lower, tangent, free, fit }
    }

    /// The lowest eigenvalue of the tangent in every lane.
    pub fn lowest(mut self) -> S {
        let n = self.free;
        let (mut diagonal, mut squares) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let matrix = &mut self.tangent;
        for j in 0..n {
            diagonal.push(matrix[j * n + j]);
            if j + 1 < n {
                let (v, length) = householder(&matrix[j * n + j + 1..(j + 1) * n]);
                squares.push(length * length);
                reflect_both(&v, matrix, n);
            }
        }
        lowest_of_tridiagonal(&diagonal, &squares)
    }
}

impl Reduced<f64> {
    /// The motion of an eigenvector, in the solver's coordinates.
    pub fn motion(&self, vector: &[f64]) -> Vec<f64> {
        let n = self.free;
        let mut motion = vec![0.0; self.reflections.len()];
        motion.extend_from_slice(vector);
        let own = &mut motion[self.reflections.len()..];
        for i in (0..n).rev() {
            let rest: f64 = (i + 1..n).map(|k| self.lower[k * n + i] * own[k]).sum();
            own[i] = (own[i] - rest) / self.lower[i * n + i];
        }
        for (k, v) in self.reflections.iter().enumerate().rev() {
            reflect(v, &mut motion[k..]);
        }
        motion.iter_mut().zip(&self.units).for_each(|(entry, unit)| *entry *= unit);
        motion
    }
}

/// v of the reflection 1 − v vᵀ that brings x onto its first coordinate, and the length of x.
fn householder<S: Real>(x: &[S]) -> (Vec<S>, S) {
    let length = dot(x, x).map(f64::sqrt);
    let mut v = x.to_vec();
    v[0] = S::from_lanes(|l| v[0].lane(l) + length.lane(l).copysign(v[0].lane(l)));
    // Nothing to turn: the identity.
    let scale = dot(&v, &v).map(|square| if square > 0.0 { (2.0 / square).sqrt() } else { 0.0 });
    for entry in &mut v {
        *entry *= scale;
    }
    (v, length)
}

/// x − v (v·x).
fn reflect<S: Real>(v: &[S], x: &mut [S]) {
    axpy(x, -dot(v, x), v);
}

/// H A H on the last coordinates of a symmetric matrix of n rows; the others are done with.
fn reflect_both<S: Real>(v: &[S], matrix: &mut [S], n: usize) {
    let first = n - v.len();
    let mut image = vec![S::zero(); v.len()];
    for (row, &entry) in matrix.chunks_exact(n).skip(first).zip(v) {
        axpy(&mut image, entry, &row[first..]);
    }
    let half = dot(v, &image) * 0.5;
    axpy(&mut image, -half, v);
    for ((row, &a), &b) in matrix.chunks_exact_mut(n).skip(first).zip(v).zip(&image) {
        for ((entry, &c), &d) in row[first..].iter_mut().zip(&image).zip(v) {
            *entry = entry.plus(-a, c).plus(-b, d);
        }
    }
}

/// The last `count` rows and columns of n.
fn trailing<S: Real>(matrix: &[S], n: usize, count: usize) -> Vec<S> {
    matrix.chunks_exact(n).skip(n - count).flat_map(|row| &row[n - count..]).copied().collect()
}

/// Lower Cholesky factor in the place of the lower triangle; returns the lanes in which there is one.
pub(crate) fn cholesky<S: Real>(matrix: &mut [S], n: usize) -> u64 {
    let mut positive = every::<S>();
    for i in 0..n {
        let (above, rest) = matrix.split_at_mut(i * n);
        let row = &mut rest[..n];
        for (j, other) in above.chunks_exact(n).enumerate() {
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let square = row[i] - dot(&row[..i], &row[..i]);
        positive &= square.mask(|s| s > 0.0);
        row[i] = square.map(f64::sqrt);
    }
    positive
}

/// The lowest eigenvalue of a symmetric tridiagonal matrix with the given squares off its diagonal, to rounding.
fn lowest_of_tridiagonal<S: Real>(diagonal: &[S], squares: &[S]) -> S {
    let smaller = |a: S, b: S| S::from_lanes(|l| a.lane(l).min(b.lane(l)));
    let off_diagonal = |i: usize| squares.get(i).map_or(S::zero(), |s| s.map(f64::sqrt));
    let mut high = diagonal.iter().fold(S::splat(f64::INFINITY), |least, d| smaller(least, *d));
    // Gershgorin's circles.
    let mut low = high;
    let mut size = S::zero();
    for (i, d) in diagonal.iter().enumerate() {
        let radius = off_diagonal(i) + if i > 0 { off_diagonal(i - 1) } else { S::zero() };
        low = smaller(low, *d - radius);
        size = S::from_lanes(|l| size.lane(l).max(d.lane(l).abs()));
    }
    let close = size * (0.25 * f64::EPSILON);
    loop {
        let middle = (low + high) * 0.5;
        let between = (middle - low).mask(|w| w > 0.0) & (high - middle).mask(|w| w > 0.0);
        let moves = between & (high - low - close).mask(|w| w > 0.0);
        if moves == 0 {
            return middle;
        }
        // The pivots of T − middle: one is negative where an eigenvalue lies below.
        let mut pivot = S::splat(f64::INFINITY);
        let mut least = pivot;
        for (i, d) in diagonal.iter().enumerate() {
            let square = if i > 0 { squares[i - 1] } else { S::zero() };
            // No zero by zero.
            pivot = *d - middle - (square + f64::MIN_POSITIVE) / pivot;
            least = smaller(least, pivot);
        }
        let below = least.mask(|p| p < 0.0);
        high = middle.in_lanes(moves & below, high);
        low = middle.in_lanes(moves & !below, low);
    }
}

/// Σ ℓ w Zᵀ B Z with the strains of the straight bundle and the stiffnesses that face each other now.
fn elastic_stiffness<S: Real>(buffers: &Buffers<S>, system: &System) -> Vec<S> {
    let System { robot, layout, .. } = *system;
    let Buffers { state, assembly, units, .. } = buffers;
    let inverse = 1.0 / Scale::of(robot).energy;
    let (n_u, followers) = (layout.unknowns(), layout.tubes - 1);
    let mut stiffness = vec![S::zero(); n_u * n_u];
    for (e, element) in layout.elements.iter().enumerate() {
        let rule = &layout.rules[element.rule];
        for i in 0..rule.n {
            let node = element.first_node + i;
            let weight = state.lengths[e] * (rule.weights[i] * inverse);
            let modes = &rule.legendre[i * rule.n..(i + 1) * rule.n];
            let mut add = |one: usize, other: usize, value: S| {
                let [(a, count), (b, columns)] = [element.modes[one], element.modes[other]];
                for (k, p) in (a..a + count).zip(modes) {
                    let row = &mut stiffness[k * n_u + b..k * n_u + b + columns];
                    let factor = weight * value * (p * units[k]);
                    for ((entry, p), unit) in row.iter_mut().zip(modes).zip(&units[b..]) {
                        *entry = entry.plus(factor, S::splat(p * unit));
                    }
                }
            };
            let jets = &assembly.jets[node * layout.tubes..(node + 1) * layout.tubes];
            // About the leader's axes: (c, −s) of a follower's Y and (s, c) of its Z.
            let (mut twist, mut yy, mut yz, mut zz) = (S::zero(), S::zero(), S::zero(), S::zero());
            for (tube, jets) in jets.iter().enumerate() {
                let (s, c) = match tube.checked_sub(1) {
                    None => (S::zero(), S::one()),
                    Some(f) => state.rest[node * followers + f][0].sin_cos(),
                };
                // Gravity's share is no elastic one; where the centroid lies does not matter without strain.
                let FieldJets { torsion, bending_y, bending_z, axial, offset: _, mass: _, direction: _ } =
                    jets;
                let (stiff, soft) = (bending_y[0], bending_z[0]);
                twist += torsion[0];
                yy += stiff * c * c + soft * s * s;
                yz += (soft - stiff) * s * c;
                zz += stiff * s * s + soft * c * c;
                if let Some(f) = tube.checked_sub(1) {
                    let angle = field::angle(f);
                    add(local::KX, angle, -torsion[0]);
                    add(angle, local::KX, -torsion[0]);
                    add(angle, angle, torsion[0]);
                }
                if layout.stretch {
                    let stretch = field::stretch(followers, tube);
                    add(stretch, stretch, axial[0]);
                }
            }
            add(local::KX, local::KX, twist);
            add(local::KY, local::KY, yy);
            add(local::KY, local::KZ, yz);
            add(local::KZ, local::KY, yz);
            add(local::KZ, local::KZ, zz);
        }
    }
    for edge in 0..layout.edges.len() {
        // Bound by its own condition; any positive number keeps the matrix definite.
        stiffness[edge * n_u + edge] = S::splat(f64::EPSILON);
    }
    stiffness
}
