//! A tube whose section is not linear, at a section of the bundle: its length is found instead of given by a formula.
//!
//! With w(e, b_Y, b_Z) of [`Metal`], E of a tube (see [`super::section`]) is the least over the length g of its centroid line per centreline length of
//!
//! ```text
//! g w + g Q ,   1 + e = h/g ,   b_Y + k_Y = w_Y/g ,   b_Z + k_Z = w_Z/g ,   Q = T/h° − ½ π²/GJ .
//! ```
//!
//! It is convex in (g, w_Y, w_Z) since w is convex. With s = (1 + e, b_Y + k_Y, b_Z + k_Z), N = w_e and M = (w_Y, w_Z) the slopes of w and H its second slopes:
//!
//! ```text
//! w − s·∇w + Q = 0 ,   ∂E/∂w_Y = M_Y ,   ∂E/∂w_Z = M_Z − D N ,   ∂²E = (dᵢ·H dⱼ − (dᵢ·H s)(dⱼ·H s)/(s·H s))/g ,  d_Y = (0, 1, 0) ,  d_Z = (−D, 0, 1) .
//! ```

use super::number::Number;
use crate::design::metal::{Metal, Potential};

/// What a tube does at a section, in the numbers of its inputs.
pub(super) struct Balanced<L> {
    /// g.
    pub length: L,
    /// N, M_Y and M_Z.
    pub efforts: [L; 3],
    /// E.
    pub energy: L,
}

/// Steps for g, and the relative one with which they end: the next would be of its square.
const STEPS: usize = 80;
const SETTLED: f64 = 1e-8;

fn strains(bent: [f64; 3], rest: [f64; 2], length: f64) -> [f64; 3] {
    [bent[0] / length - 1.0, bent[1] / length - rest[0], bent[2] / length - rest[1]]
}

fn along(matrix: &[[f64; 3]; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * (0..3).map(|j| matrix[i][j] * b[j]).sum::<f64>()).sum()
}

/// g and w there for (h, w_Y, w_Z), by Newton's method for 1/g², which a linear section ends with one step, kept between bounds; not finite where there is none.
fn length(metal: &Metal, bent: [f64; 3], rest: [f64; 2], pull: f64) -> (f64, Potential) {
    let mut length = bent[0];
    let (mut least, mut most) = (0.0, f64::INFINITY);
    let mut potential = metal.at(strains(bent, rest, length));
    for _ in 0..STEPS {
        let s = bent.map(|b| b / length);
        let slope = potential.value - (0..3).map(|i| s[i] * potential.slopes[i]).sum::<f64>() + pull;
        if slope < 0.0 {
            least = length;
        } else {
            most = length;
        }
        let mut next = length / (1.0 + 2.0 * slope / along(&potential.second, s, s)).sqrt();
        if !(next >= least && next <= most) {
            next = if most.is_finite() { 0.5 * (least + most) } else { 2.0 * length };
        }
        let step = next - length;
        length = next;
        potential = metal.at(strains(bent, rest, length));
        if step.abs() <= SETTLED * length {
            break;
        }
    }
    (length, potential)
}

/// Slopes of E by (w_Y, w_Z) and second ones: (Y, Z, YY, YZ, ZZ); `offset` is D (m).
pub(super) fn slopes(
    metal: &Metal,
    bent: [f64; 3],
    rest: [f64; 2],
    pull: f64,
    offset: f64,
) -> Option<[f64; 5]> {
    let (length, p) = length(metal, bent, rest, pull);
    let (s, y, z) = (bent.map(|b| b / length), [0.0, 1.0, 0.0], [-offset, 0.0, 1.0]);
    let stiff = along(&p.second, s, s);
    let second =
        |a, b| (along(&p.second, a, b) - along(&p.second, a, s) * along(&p.second, b, s) / stiff) / length;
    let found = [p.slopes[1], p.slopes[2] - offset * p.slopes[0], second(y, y), second(y, z), second(z, z)];
    found.iter().all(|v| v.is_finite()).then_some(found)
}

/// The same in numbers with slopes, by one more step for g with them.
pub(super) fn balanced<L: Number>(metal: &Metal, bent: [L; 3], rest: [L; 2], pull: L) -> Balanced<L> {
    let values = bent.map(Number::value);
    let (at, potential) = length(metal, values, rest.map(Number::value), pull.value());
    let of = |length: L| {
        let inverse = length.inverse();
        let s = bent.map(|b| b * inverse);
        let strains = [s[0] - 1.0, s[1] - rest[0], s[2] - rest[1]];
        let efforts: [L; 3] =
            std::array::from_fn(|i| L::function(potential.slopes[i], &potential.second[i], &strains));
        (s, efforts, L::function(potential.value, &potential.slopes, &strains))
    };
    let fixed = L::constant(at);
    let (s, efforts, value) = of(fixed);
    let residual = value - (s[0] * efforts[0] + s[1] * efforts[1] + s[2] * efforts[2]) + pull;
    let s = s.map(Number::value);
    let length = fixed.plus(-at / along(&potential.second, s, s), residual);
    let (_, efforts, value) = of(length);
    Balanced { length, efforts, energy: (value + pull) * length }
}
