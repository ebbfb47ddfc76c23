//! Elastic energy of follower and leader per unit of the leader's label, with exact first and second derivatives.
//!
//! ω = |h| · ½ [GJ Δτ² + EI_Y κ_Y² + EI_Z κ_Z² + EA e²] in the strains of `kinematics::follower`; all
//! stiffnesses are taken at the facing abscissa x_k and differentiated with it.

use crate::design::fields::FieldJets;
use crate::kinematics::follower::{Block, Facing, Row, local};
use local::{COUNT, DTH, EK, FACE, KX, KY, KZ, TH};

/// First and second derivatives by (|h|, a, p, r, x, e).
struct Inner {
    value: f64,
    slope: [f64; 6],
    curvature: [[f64; 6]; 6],
}

fn inner(facing: &Facing, stretch: f64, fields: &FieldJets, second: bool) -> Inner {
    let Facing { h, a, p, r, .. } = *facing;
    let [gj, gj1, gj2] = fields.torsion;
    let [y, y1, y2] = fields.bending_y;
    let [z, z1, z2] = fields.bending_z;
    // Without stretch the axial stiffness may be unknown and must not enter.
    let [ea, ea1, ea2] = if stretch == 0.0 { [0.0; 3] } else { fields.axial };
    let [_, f, f1, _] = fields.direction;
    let inverse = 1.0 / h;
    let tau = a * inverse - f;
    let (q, q1, q2) = (y * p * p + z * r * r, y1 * p * p + z1 * r * r, y2 * p * p + z2 * r * r);
    let e2 = 0.5 * stretch * stretch;
    let half_tau2 = 0.5 * tau * tau;
    let value = h * (gj * half_tau2 + ea * e2) + 0.5 * q * inverse;
    let slope = [
        gj * half_tau2 - gj * tau * a * inverse + ea * e2 - 0.5 * q * inverse * inverse,
        gj * tau,
        y * p * inverse,
        z * r * inverse,
        h * (gj1 * half_tau2 - gj * tau * f1 + ea1 * e2) + 0.5 * q1 * inverse,
        h * ea * stretch,
    ];
    let mut c = [[0.0; 6]; 6];
    if second {
        let i2 = inverse * inverse;
        c[0][0] = (gj * a * a + q) * i2 * inverse;
        c[0][1] = -gj * a * i2;
        c[0][2] = -y * p * i2;
        c[0][3] = -z * r * i2;
        c[0][4] =
            gj1 * half_tau2 - gj * tau * f1 - (gj1 * tau - gj * f1) * a * inverse + ea1 * e2 - 0.5 * q1 * i2;
        c[0][5] = ea * stretch;
        c[1][1] = gj * inverse;
        c[1][4] = gj1 * tau - gj * f1;
        c[2][2] = y * inverse;
        c[2][4] = y1 * p * inverse;
        c[3][3] = z * inverse;
        c[3][4] = z1 * r * inverse;
        c[4][4] = h
            * (gj2 * half_tau2 - 2.0 * gj1 * tau * f1 + gj * f1 * f1 - gj * tau * fields.direction[3]
                + ea2 * e2)
            + 0.5 * q2 * inverse;
        c[4][5] = h * ea1 * stretch;
        c[5][5] = if fields.axial[0].is_finite() { h * fields.axial[0] } else { 0.0 };
        for i in 0..6 {
            for j in 0..i {
                c[i][j] = c[j][i];
            }
        }
    }
    Inner { value, slope, curvature: c }
}

/// Jacobian of (|h|, a, p, r, x, e) by the local variables.
fn chain(facing: &Facing) -> [Row; 6] {
    let Facing { sin, cos, p, r, .. } = *facing;
    let mut rows = [[0.0; COUNT]; 6];
    rows[0] = facing.dh;
    rows[1][KX] = 1.0;
    rows[1][DTH] = -1.0;
    rows[2][KY] = cos;
    rows[2][KZ] = -sin;
    rows[2][TH] = -r;
    rows[3][KY] = sin;
    rows[3][KZ] = cos;
    rows[3][TH] = p;
    rows[4][FACE] = 1.0;
    rows[5][EK] = 1.0;
    rows
}

/// Energy density and its gradient over the local variables.
pub(crate) fn gradient(facing: &Facing, stretch: f64, fields: &FieldJets) -> (f64, Row) {
    let inner = inner(facing, stretch, fields, false);
    let mut gradient = [0.0; COUNT];
    for (row, slope) in chain(facing).iter().zip(inner.slope) {
        for (g, r) in gradient.iter_mut().zip(row) {
            *g += slope * r;
        }
    }
    (inner.value, gradient)
}

/// ∂ω/∂|h|.
pub(crate) fn by_rate(facing: &Facing, stretch: f64, fields: &FieldJets) -> f64 {
    inner(facing, stretch, fields, false).slope[0]
}

/// Adds `weight` times the Hessian of ω to `block` and returns the slope of ω by |h|, whose part in the
/// Hessian (ω_h times the second derivatives of |h|) the caller adds together with its own.
pub(crate) fn add_hessian(
    facing: &Facing,
    stretch: f64,
    fields: &FieldJets,
    weight: f64,
    block: &mut Block,
) -> f64 {
    let inner = inner(facing, stretch, fields, true);
    let rows = chain(facing);
    for (i, row_i) in rows.iter().enumerate() {
        // Only the columns that this row of the curvature couples to.
        let mut coupled = [0.0; COUNT];
        for (j, row_j) in rows.iter().enumerate() {
            let c = weight * inner.curvature[i][j];
            if c != 0.0 {
                for (t, r) in coupled.iter_mut().zip(row_j) {
                    *t += c * r;
                }
            }
        }
        for (target, &factor) in block.iter_mut().zip(row_i) {
            if factor != 0.0 {
                for (t, c) in target.iter_mut().zip(&coupled) {
                    *t += factor * c;
                }
            }
        }
    }
    let Facing { sin, cos, p, r, .. } = *facing;
    let (by_p, by_r) = (weight * inner.slope[2], weight * inner.slope[3]);
    let mut add = |i: usize, j: usize, value: f64| {
        block[i][j] += value;
        if i != j {
            block[j][i] += value;
        }
    };
    add(TH, TH, -by_p * p - by_r * r);
    add(KY, TH, -by_p * sin + by_r * cos);
    add(KZ, TH, -by_p * cos - by_r * sin);
    inner.slope[0]
}

/// ω_1 and its gradient by (K_X, K_Y, K_Z, e_1, X).
pub(crate) fn leader(fields: &FieldJets, v: &[f64]) -> (f64, [f64; 5]) {
    let [_, rest, bend, _] = fields.direction;
    let twist = v[local::KX] - rest;
    let (ky, kz, stretch) = (v[local::KY], v[local::KZ], v[local::E1]);
    let axial = if stretch == 0.0 { [0.0; 3] } else { fields.axial };
    let form = |order: usize| {
        0.5 * (fields.torsion[order] * twist * twist
            + fields.bending_y[order] * ky * ky
            + fields.bending_z[order] * kz * kz
            + axial[order] * stretch * stretch)
    };
    let gj = fields.torsion[0];
    (
        form(0),
        [
            gj * twist,
            fields.bending_y[0] * ky,
            fields.bending_z[0] * kz,
            axial[0] * stretch,
            form(1) - gj * twist * bend,
        ],
    )
}

pub(crate) fn add_leader_hessian(fields: &FieldJets, v: &[f64], weight: f64, full: &mut [f64], rows: usize) {
    let [_, rest, bend, jerk] = fields.direction;
    let twist = v[local::KX] - rest;
    let stretch = v[local::E1];
    let axial = if fields.axial[0].is_finite() { fields.axial } else { [0.0; 3] };
    let [gj, gj1, gj2] = fields.torsion;
    let x = local::X;
    let mut add = |i: usize, j: usize, value: f64| {
        full[i * rows + j] += weight * value;
        if i != j {
            full[j * rows + i] += weight * value;
        }
    };
    add(local::KX, local::KX, gj);
    add(local::KY, local::KY, fields.bending_y[0]);
    add(local::KZ, local::KZ, fields.bending_z[0]);
    add(local::E1, local::E1, axial[0]);
    add(local::KX, x, gj1 * twist - gj * bend);
    add(local::KY, x, fields.bending_y[1] * v[local::KY]);
    add(local::KZ, x, fields.bending_z[1] * v[local::KZ]);
    add(local::E1, x, axial[1] * stretch);
    let curvature = 0.5
        * (gj2 * twist * twist
            + fields.bending_y[2] * v[local::KY] * v[local::KY]
            + fields.bending_z[2] * v[local::KZ] * v[local::KZ]
            + axial[2] * stretch * stretch)
        - 2.0 * gj1 * twist * bend
        + gj * (bend * bend - twist * jerk);
    add(x, x, curvature);
}
