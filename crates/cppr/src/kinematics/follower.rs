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
use crate::real::Real;

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
    /// How many of them, K_X to X, belong to the leader and are the same for all followers.
    pub const SHARED: usize = TH;
    /// How many, θ_k to e_k, each follower has of its own.
    pub const OWN: usize = COUNT - SHARED;
}
use local::{COUNT, DTH, E1, EK, FACE, KX, KY, KZ, TH, X};

/// A vector over the local variables.
pub(crate) type Row<S = f64> = [S; COUNT];

/// |h| and what it is made of, with first derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Facing<S = f64> {
    pub sin: S,
    pub cos: S,
    /// a = K_X − θ'.
    pub a: S,
    /// p = c K_Y − s K_Z.
    pub p: S,
    /// r = s K_Y + c K_Z.
    pub r: S,
    pub h: S,
    /// Derivatives of |h|.
    pub dh: Row<S>,
}

impl<S: Real> Facing<S> {
    /// At the given local variables, sine and cosine of θ; D_1(X) and D_k(x) with derivatives.
    #[inline]
    pub fn new(v: &Row<S>, [sin, cos]: [S; 2], leader_offset: &Jet<S>, offset: &Jet<S>) -> Self {
        let r = sin * v[KY] + cos * v[KZ];
        let p = cos * v[KY] - sin * v[KZ];
        let inverse = S::one() / (v[EK] + 1.0);
        let h = (v[E1] + 1.0 + leader_offset[0] * v[KZ] + offset[0] * r) * inverse;
        let mut dh = [S::zero(); COUNT];
        dh[KY] = offset[0] * sin * inverse;
        dh[KZ] = (leader_offset[0] + offset[0] * cos) * inverse;
        dh[E1] = inverse;
        dh[X] = leader_offset[1] * v[KZ] * inverse;
        dh[TH] = offset[0] * p * inverse;
        dh[FACE] = offset[1] * r * inverse;
        dh[EK] = -h * inverse;
        Self { sin, cos, a: v[KX] - v[DTH], p, r, h, dh }
    }

    /// Adds `factor` times the second derivatives of |h|: `add(i, j, value)` takes each once.
    #[inline]
    pub fn second(
        &self,
        v: &Row<S>,
        leader_offset: &Jet<S>,
        offset: &Jet<S>,
        factor: S,
        add: &mut impl FnMut(usize, usize, S),
    ) {
        let inverse = S::one() / (v[EK] + 1.0);
        let f = factor * inverse;
        let [d, d1, d2] = *offset;
        add(KY, TH, f * d * self.cos);
        add(KZ, TH, -f * d * self.sin);
        add(TH, TH, -f * d * self.r);
        add(KY, FACE, f * d1 * self.sin);
        add(KZ, FACE, f * d1 * self.cos);
        add(TH, FACE, f * d1 * self.p);
        add(FACE, FACE, f * d2 * self.r);
        add(KZ, X, f * leader_offset[1]);
        add(X, X, f * leader_offset[2] * v[KZ]);
        for i in [KY, KZ, E1, X, TH, FACE] {
            add(i, EK, -f * self.dh[i]);
        }
        add(EK, EK, f * self.h * inverse * 2.0);
    }
}
