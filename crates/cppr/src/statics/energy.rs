//! Elastic energy of follower and leader per unit of the leader's label, with exact first and second derivatives.
//!
//! ω = |h| · ½ [GJ Δτ² + EI_Y κ_Y² + EI_Z κ_Z² + EA e²] in the strains of `kinematics::follower`; all
//! stiffnesses are taken at the facing abscissa x_k and differentiated with it.

use crate::design::fields::{FieldJets, Jet};
use crate::kinematics::follower::{Facing, Row, local};
use crate::real::Real;
use local::{COUNT, DTH, E1, EK, FACE, KX, KY, KZ, TH, X};

/// ω with its slopes by (|h|, a, p, r, x, e).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inner<S = f64> {
    value: S,
    slope: [S; 6],
    inverse: S,
    tau: S,
    stretched: S,
}

/// ω of one follower at one node.
pub(crate) fn inner<S: Real>(facing: &Facing<S>, stretch: S, fields: &FieldJets<S>) -> Inner<S> {
    let Facing { h, a, p, r, .. } = *facing;
    // The offset is in |h|; mass has no elastic energy.
    let FieldJets { torsion, bending_y, bending_z, axial, direction, offset: _, mass: _ } = fields;
    let [gj, gj1, _] = *torsion;
    let [y, y1, _] = *bending_y;
    let [z, z1, _] = *bending_z;
    let [_, f, f1, _] = *direction;
    // Without stretch the axial stiffness may be NaN and must not enter.
    let [ea, ea1] = if stretch.vanishes() { [S::zero(); 2] } else { [axial[0], axial[1]] };
    // With τ = a/|h| − φ' and q = EI_Y p² + EI_Z r² (so that EI_Y κ_Y² + EI_Z κ_Z² = q/|h|²) the density per length of the
    // leader is
    //
    //   ω = |h| (½ GJ τ² + ½ EA e²) + ½ q/|h| .
    //
    // Its six arguments are independent here; what they depend on comes with the chain rule in `gradient` and `second`.
    // From ∂τ/∂|h| = −a/|h|², ∂τ/∂a = 1/|h|, ∂τ/∂x = −φ'':
    //
    //   ω_h = ½ GJ τ² − GJ τ a/|h| + ½ EA e² − ½ q/|h|²        ω_a = GJ τ
    //   ω_p = EI_Y p/|h|     ω_r = EI_Z r/|h|                  ω_e = |h| EA e
    //   ω_x = |h| (½ GJ' τ² − GJ τ φ'' + ½ EA' e²) + ½ q'/|h|   (' by x, q' at fixed p and r)
    let inverse = S::one() / h;
    let tau = a * inverse - f;
    let (q, q1) = (y * p * p + z * r * r, y1 * p * p + z1 * r * r);
    let stretched = stretch * stretch * 0.5;
    let half_tau2 = tau * tau * 0.5;
    let half_q = q * inverse * 0.5;
    let value = h * (gj * half_tau2 + ea * stretched) + half_q;
    let slope = [
        gj * half_tau2 - gj * tau * a * inverse + ea * stretched - half_q * inverse,
        gj * tau,
        y * p * inverse,
        z * r * inverse,
        h * (gj1 * half_tau2 - gj * tau * f1 + ea1 * stretched) + q1 * inverse * 0.5,
        h * ea * stretch,
    ];
    Inner { value, slope, inverse, tau, stretched }
}

/// Slopes of p and r by the local variables.
fn bends<S: Real>(facing: &Facing<S>) -> [Row<S>; 2] {
    let Facing { sin, cos, p, r, .. } = *facing;
    let mut rows = [[S::zero(); COUNT]; 2];
    (rows[0][KY], rows[0][KZ], rows[0][TH]) = (cos, -sin, -r);
    (rows[1][KY], rows[1][KZ], rows[1][TH]) = (sin, cos, p);
    rows
}

/// Energy density and its gradient over the local variables.
pub(crate) fn gradient<S: Real>(facing: &Facing<S>, stretch: S, fields: &FieldJets<S>) -> (S, Row<S>) {
    let inner = inner(facing, stretch, fields);
    (inner.value, inner.gradient(facing))
}

impl<S: Real> Inner<S> {
    /// ω (N).
    pub fn value(&self) -> S {
        self.value
    }

    /// Its slopes by the local variables.
    #[inline]
    pub fn gradient(&self, facing: &Facing<S>) -> Row<S> {
        let [by_h, by_a, by_p, by_r, by_x, by_e] = self.slope;
        let Facing { sin, cos, p, r, dh, .. } = facing;
        let mut gradient = *dh;
        for slope in &mut gradient {
            *slope *= by_h;
        }
        // p = c K_Y − s K_Z and r = s K_Y + c K_Z.
        gradient[KY] = gradient[KY].plus(by_p, *cos).plus(by_r, *sin);
        gradient[KZ] = gradient[KZ].plus(by_r, *cos).plus(-by_p, *sin);
        gradient[TH] = gradient[TH].plus(by_r, *p).plus(-by_p, *r);
        gradient[KX] += by_a;
        gradient[DTH] -= by_a;
        gradient[FACE] += by_x;
        gradient[EK] += by_e;
        gradient
    }
}

/// ∂ω/∂|h|.
pub(crate) fn by_rate<S: Real>(facing: &Facing<S>, stretch: S, fields: &FieldJets<S>) -> S {
    inner(facing, stretch, fields).slope[0]
}

/// Second derivatives of `weight` times ω by the given local variables: `add(i, j, value)` takes each pair once.
/// Returns the slope of ω by |h|, whose part in them (ω_h times the second derivatives of |h|) the caller
/// adds together with its own.
pub(crate) fn second<S: Real>(
    facing: &Facing<S>,
    inner: &Inner<S>,
    stretch: S,
    fields: &FieldJets<S>,
    weight: f64,
    variables: &[usize],
    add: &mut impl FnMut(usize, usize, S),
) -> S {
    let Inner { slope, inverse, tau, stretched, .. } = *inner;
    let Facing { h, a, p, r, sin, cos, dh } = facing;
    let FieldJets { torsion, bending_y, bending_z, axial, direction, offset: _, mass: _ } = *fields;
    let weighted = |[a, b, c]: Jet<S>| (a * weight, b * weight, c * weight);
    let (gj, gj1, gj2) = weighted(torsion);
    let (y, y1, y2) = weighted(bending_y);
    let (z, z1, z2) = weighted(bending_z);
    let [_, _, f1, f2] = direction;
    let (ea, ea1, ea2) = weighted(axial_or_zero(axial));
    let i2 = inverse * inverse;
    let half_tau2 = tau * tau * 0.5;
    let q = y * *p * *p + z * *r * *r;
    let (q1, q2) = (y1 * *p * *p + z1 * *r * *r, y2 * *p * *p + z2 * *r * *r);
    // Second derivatives ω_uv by u, v of (|h|, a, p, r, x, e): the slopes of `inner` differentiated once more, with
    // τ_hh = 2a/|h|³, τ_ha = −1/|h|² and τ_xx = −φ‴. Of ω_hh the terms with τ cancel: (GJ a² + q)/|h|³ is left. What
    // vanishes is left out (ω_ap, ω_ar, ω_pr, ω_ae, ω_pe, ω_re); ω_aa, ω_pp, ω_rr and ω_ee are added below.
    let hh = (gj * *a * *a + q) * i2 * inverse;
    let ha = -gj * *a * i2;
    let (hp, hr) = (-y * *p * i2, -z * *r * i2);
    let ax = gj1 * tau - gj * f1;
    let turned = gj1 * half_tau2 - gj * tau * f1;
    let hx = turned - ax * *a * inverse + ea1 * stretched - q1 * i2 * 0.5;
    let aa = gj * inverse;
    let (pp, rr) = (y * inverse, z * inverse);
    let (px, rx) = (y1 * *p * inverse, z1 * *r * inverse);
    let xx = *h * (gj2 * half_tau2 - gj1 * tau * f1 * 2.0 + gj * f1 * f1 - gj * tau * f2 + ea2 * stretched)
        + q2 * inverse * 0.5;
    let [by_p, by_r] = bends(facing);
    // The chain rule: with v the local variables, ω_vv = Σ ω_ab a_v ⊗ b_v + Σ ω_a a_vv over a, b of the six, of which |h|, p and
    // r are not linear in v:
    //
    //   hh h_v⊗h_v + h_v⊗(hp p_v + hr r_v + ha a_v + hx x_v + …) + transposed       by_h: the bracket
    //   + pp p_v⊗p_v + rr r_v⊗r_v + x_v⊗(px p_v + rx r_v + ax a_v + ½ xx x_v) + …   by_x: the bracket
    //   + ω_p p_vv + ω_r r_vv                                      at the end: p_θθ = −p, r_θθ = −r, …
    //
    // ω_h |h|_vv is the caller's, who adds it together with the adjoint's share of |h|_vv.
    let (mut by_h, mut by_x) = ([S::zero(); COUNT], [S::zero(); COUNT]);
    for v in [KY, KZ, TH] {
        by_h[v] = (hp * by_p[v]).plus(hr, by_r[v]);
        by_x[v] = (px * by_p[v]).plus(rx, by_r[v]);
    }
    by_h[KX] += ha;
    by_h[DTH] -= ha;
    by_h[FACE] += hx;
    by_h[EK] += ea * stretch;
    by_x[KX] += ax;
    by_x[DTH] -= ax;
    by_x[FACE] += xx * 0.5;
    by_x[EK] += *h * ea1 * stretch;
    for (n, &i) in variables.iter().enumerate() {
        for &j in &variables[..=n] {
            let mut value = hh * dh[i] * dh[j] + dh[i] * by_h[j] + by_h[i] * dh[j];
            if let (KY | KZ | TH, KY | KZ | TH) = (i, j) {
                value += pp * by_p[i] * by_p[j] + rr * by_r[i] * by_r[j];
            }
            if i == FACE {
                value += by_x[j];
            }
            if j == FACE {
                value += by_x[i];
            }
            add(i, j, value);
        }
    }
    let has = |v: usize| variables.contains(&v);
    if has(KX) {
        add(KX, KX, aa);
    }
    if has(DTH) {
        add(DTH, DTH, aa);
        if has(KX) {
            add(DTH, KX, -aa);
        }
    }
    if has(EK) {
        add(EK, EK, *h * ea);
    }
    if has(TH) {
        let (of_p, of_r) = (slope[2] * weight, slope[3] * weight);
        add(TH, TH, -of_p * *p - of_r * *r);
        add(KY, TH, of_r * *cos - of_p * *sin);
        add(KZ, TH, -of_p * *cos - of_r * *sin);
    }
    slope[0]
}

/// The axial stiffness, or zero where the design gives none (NaN).
fn axial_or_zero<S: Real>(axial: Jet<S>) -> Jet<S> {
    if axial[0].mask(f64::is_finite) != 0 { axial } else { [S::zero(); 3] }
}

/// ω_1 and its gradient by (K_X, K_Y, K_Z, e_1, X).
pub(crate) fn leader<S: Real>(fields: &FieldJets<S>, v: &[S]) -> (S, [S; local::SHARED]) {
    // No strain of the leader depends on its offset; mass has no elastic energy.
    let FieldJets { torsion, bending_y, bending_z, axial, direction, offset: _, mass: _ } = fields;
    let [_, rest, bend, _] = *direction;
    let twist = v[KX] - rest;
    let (ky, kz, stretch) = (v[KY], v[KZ], v[E1]);
    let axial = if stretch.vanishes() { [S::zero(); 3] } else { *axial };
    let form = |order: usize| {
        (torsion[order] * twist * twist
            + bending_y[order] * ky * ky
            + bending_z[order] * kz * kz
            + axial[order] * stretch * stretch)
            * 0.5
    };
    let gj = torsion[0];
    let slopes =
        [gj * twist, bending_y[0] * ky, bending_z[0] * kz, axial[0] * stretch, form(1) - gj * twist * bend];
    (form(0), slopes)
}

/// Second derivatives of ω_1: `add(i, j, value)` takes each pair once; those by X only where `moving`.
pub(crate) fn leader_second<S: Real>(
    fields: &FieldJets<S>,
    v: &[S],
    moving: bool,
    add: &mut impl FnMut(usize, usize, S),
) {
    let FieldJets { torsion, bending_y, bending_z, axial, direction, offset: _, mass: _ } = *fields;
    let [_, rest, bend, jerk] = direction;
    let twist = v[KX] - rest;
    let stretch = v[E1];
    let axial = axial_or_zero(axial);
    let [gj, gj1, gj2] = torsion;
    add(KX, KX, gj);
    add(KY, KY, bending_y[0]);
    add(KZ, KZ, bending_z[0]);
    add(E1, E1, axial[0]);
    if !moving {
        return;
    }
    add(KX, X, gj1 * twist - gj * bend);
    add(KY, X, bending_y[1] * v[KY]);
    add(KZ, X, bending_z[1] * v[KZ]);
    add(E1, X, axial[1] * stretch);
    let by_label_twice = (gj2 * twist * twist
        + bending_y[2] * v[KY] * v[KY]
        + bending_z[2] * v[KZ] * v[KZ]
        + axial[2] * stretch * stretch)
        * 0.5
        - gj1 * twist * bend * 2.0
        + gj * (bend * bend - twist * jerk);
    add(X, X, by_label_twice);
}
