//! How a follower faces a section of the leader: the rate |h| of the face-to-face function and the
//! follower's curvatures, with exact derivatives.
//!
//! With c = cos θ, s = sin θ (eq 79 and 74, stretch included):
//!
//! ```text
//! r = s K_Y + c K_Z            p = c K_Y − s K_Z            a = K_X − θ'
//! |h| = [(1 + e_1) + D_1 K_Z + D_k(x) r] / (1 + e_k)
//! κ_Z = r/|h|,  κ_Y = p/|h|,  Δτ = a/|h| − φ_k'(x)
//! ```

use crate::design::fields::Jet;

/// Local variables of one follower at one label, in this order everywhere.
pub(crate) mod local {
    /// K_X of the leader (1/m).
    pub const KX: usize = 0;
    /// K_Y.
    pub const KY: usize = 1;
    /// K_Z.
    pub const KZ: usize = 2;
    /// Stretch e_1 of the leader.
    pub const E1: usize = 3;
    /// The label X itself (m).
    pub const X: usize = 4;
    /// θ_k (rad).
    pub const TH: usize = 5;
    /// θ_k' (rad/m).
    pub const DTH: usize = 6;
    /// Facing rest abscissa x_k (m).
    pub const FACE: usize = 7;
    /// Stretch e_k of the follower.
    pub const EK: usize = 8;
    /// How many.
    pub const COUNT: usize = 9;
}
use local::{COUNT, DTH, E1, EK, FACE, KX, KY, KZ, TH, X};

/// A vector over the local variables.
pub(crate) type Row = [f64; COUNT];
/// A symmetric matrix over the local variables.
pub(crate) type Block = [[f64; COUNT]; COUNT];

/// |h| and what it is made of, with first derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facing {
    pub sin: f64,
    pub cos: f64,
    /// a = K_X − θ'.
    pub a: f64,
    /// p = c K_Y − s K_Z.
    pub p: f64,
    /// r = s K_Y + c K_Z.
    pub r: f64,
    pub h: f64,
    /// Derivatives of |h|.
    pub dh: Row,
}

impl Facing {
    /// At the given local variables; D_1(X) and D_k(x) with derivatives.
    #[inline]
    pub fn new(v: &Row, leader_offset: &Jet, offset: &Jet) -> Self {
        let (sin, cos) = v[TH].sin_cos();
        let r = sin * v[KY] + cos * v[KZ];
        let p = cos * v[KY] - sin * v[KZ];
        let inverse = 1.0 / (1.0 + v[EK]);
        let h = (1.0 + v[E1] + leader_offset[0] * v[KZ] + offset[0] * r) * inverse;
        let mut dh = [0.0; COUNT];
        dh[KY] = offset[0] * sin * inverse;
        dh[KZ] = (leader_offset[0] + offset[0] * cos) * inverse;
        dh[E1] = inverse;
        dh[X] = leader_offset[1] * v[KZ] * inverse;
        dh[TH] = offset[0] * p * inverse;
        dh[FACE] = offset[1] * r * inverse;
        dh[EK] = -h * inverse;
        Self { sin, cos, a: v[KX] - v[DTH], p, r, h, dh }
    }

    /// Adds `factor` times the second derivatives of |h|.
    #[inline]
    pub fn add_second(&self, v: &Row, leader_offset: &Jet, offset: &Jet, factor: f64, block: &mut Block) {
        let inverse = 1.0 / (1.0 + v[EK]);
        let f = factor * inverse;
        let mut add = |i: usize, j: usize, value: f64| {
            block[i][j] += value;
            if i != j {
                block[j][i] += value;
            }
        };
        add(KZ, X, f * leader_offset[1]);
        add(X, X, f * leader_offset[2] * v[KZ]);
        add(KY, TH, f * offset[0] * self.cos);
        add(KZ, TH, -f * offset[0] * self.sin);
        add(TH, TH, -f * offset[0] * self.r);
        add(KY, FACE, f * offset[1] * self.sin);
        add(KZ, FACE, f * offset[1] * self.cos);
        add(TH, FACE, f * offset[1] * self.p);
        add(FACE, FACE, f * offset[2] * self.r);
        for i in [KY, KZ, E1, X, TH, FACE] {
            add(i, EK, -f * self.dh[i]);
        }
        add(EK, EK, 2.0 * f * self.h * inverse);
    }
}
