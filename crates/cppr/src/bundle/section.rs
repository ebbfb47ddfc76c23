//! One section of the bundle: how its tubes share the curvature.
//!
//! At given labels x_i, tensions T_i, angles α_i, torques π_i of the tubes and moment m on the section, the rates of rotation
//! ω = (0, ω_y, ω_z) of the centreline (and the stretch of every tube, where it is asked for) make
//!
//! ```text
//! G = Σ_i E_i − m·ω ,   E_i = min over strains of { elastic energy of tube i per centreline length − π_i α_i' + T_i g_i/h°_i }
//! ```
//!
//! stationary. With w_Y = ω·b_iY and w_Z = ω·b_iZ, h = 1 − D w_Z the length of the centroid line per centreline length, g the same
//! at rest (g = h without stretch), k_Y and k_Z the rest curvatures per centroid length:
//!
//! ```text
//! E = ½ (EI_Y w_Y² + EI_Z w_Z²)/g + ½ g P − EI_Y w_Y k_Y − EI_Z w_Z k_Z  [+ ½ EA (h − g)²/g] ,
//! P = EI_Y k_Y² + EI_Z k_Z² − π²/GJ + 2 T/h°
//! ```
//!
//! Slopes of G are the equations of the bundle (Hamilton's): x' = ∂G/∂T, T' = −∂G/∂x, α' = −∂G/∂π, π' = ∂G/∂α.

use super::curve::{FIELDS, Piece};
use super::metal::{balanced, slopes};
use super::number::{Dual, Field, Number};
use crate::design::metal::Metal;
use nalgebra::SMatrix;
use std::ops::{Add, Mul, Sub};

/// State of one tube at a section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TubeState<S> {
    /// Axis label x (m).
    pub label: S,
    /// Tension T (N): the force that holds the tube's motor is T at the plate.
    pub tension: S,
    /// Rotation α of the material against the untwisted frame (rad).
    pub angle: S,
    /// Torque π carried by the tube, towards the tip (N m).
    pub torque: S,
}

/// Weight per label that acts on a tube at its centroid: potential −m γ·(c + D b_Y).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weight<S> {
    /// γ·c (m²/s²), plus what a distributed force adds per mass.
    pub height: S,
    /// γ in the untwisted frame, its components y and z.
    pub across: [S; 2],
}

/// Fields in numbers that do or do not depend on the label.
#[derive(Clone, Copy, Debug)]
struct Fields<F> {
    offset: F,
    bend_y: F,
    bend_z: F,
    torsion: F,
    axial: F,
    mass: F,
    rest_y: F,
    rest_z: F,
}

impl<F: Copy> Fields<F> {
    fn from_table(v: [F; FIELDS]) -> Self {
        let [offset, bend_y, bend_z, torsion, axial, mass, rest_y, rest_z] = v;
        Self { offset, bend_y, bend_z, torsion, axial, mass, rest_y, rest_z }
    }
}

/// What a tube contributes at the rates of rotation found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contribution<S> {
    /// E.
    pub energy: S,
    /// ∂E/∂ω in the untwisted frame.
    pub moment: [S; 2],
    /// x' = g/h°.
    pub advance: S,
    /// α'.
    pub twist: S,
    /// ∂E/∂α.
    pub by_angle: S,
    /// ∂E/∂x.
    pub by_label: S,
    /// Mass per centreline length and the arm of its centroid: D (cos ψ, sin ψ).
    pub mass: S,
    pub arm: [S; 2],
}

/// One tube at a section.
pub(crate) struct Tube<'a> {
    pub piece: &'a Piece,
    state: TubeState<f64>,
    weight: Option<Weight<f64>>,
    /// Of ψ = α + φ(x).
    sin: f64,
    cos: f64,
    direction: [f64; 3],
    /// Fields with their slopes where the piece is not uniform.
    jets: Option<[[f64; 3]; FIELDS]>,
    /// For the search of ω: fields and shares in plain numbers.
    plain: Plain<'a>,
}

/// The plain numbers of a tube that ω depends on.
#[derive(Clone, Copy, Debug)]
struct Plain<'a> {
    sin: f64,
    cos: f64,
    offset: f64,
    bend: [f64; 2],
    rest: [f64; 2],
    /// P, with EA where stretch is asked for.
    push: f64,
    axial: Option<f64>,
    /// Where the section is not linear, with Q.
    metal: Option<(&'a Metal, f64)>,
}

impl Plain<'_> {
    /// Slopes and second slopes of E by (w_Y, w_Z), in the untwisted frame: (y, z, yy, yz, zz).
    #[inline]
    fn slopes(&self, omega: [f64; 2]) -> Option<[f64; 5]> {
        let (s, c) = (self.sin, self.cos);
        let (wy, wz) = (omega[0] * c + omega[1] * s, omega[1] * c - omega[0] * s);
        let h = 1.0 - self.offset * wz;
        let [ey, ez] = self.bend;
        if let Some((metal, pull)) = self.metal {
            let (c, s) = (self.cos, self.sin);
            let bent = (h > LEAST_RATE).then_some([h, wy, wz])?;
            let [a, b, yy, yz, zz] = slopes(metal, bent, self.rest, pull, self.offset)?;
            return Some(turned([a, b, yy, yz, zz], [s, c]));
        }
        let square = ey * wy * wy + ez * wz * wz;
        let (a, b, yy, yz, zz);
        match self.axial {
            None => {
                if h < LEAST_RATE {
                    return None;
                }
                let i = 1.0 / h;
                let (d, i2) = (self.offset, i * i);
                let tension = 0.5 * (self.push - square * i2);
                a = ey * (wy * i - self.rest[0]);
                b = ez * (wz * i - self.rest[1]) - d * tension;
                yy = ey * i;
                yz = d * ey * wy * i2;
                zz = ez * i + 2.0 * d * ez * wz * i2 + d * d * square * i2 * i;
            }
            Some(ea) => {
                let (d, q, p) = (self.offset, square + ea * h * h, self.push);
                if !(p > 0.0 && q > 0.0 && h > LEAST_RATE) {
                    return None;
                }
                let i = (p / q).sqrt();
                let (qy, qz) = (ey * wy, ez * wz - ea * h * d);
                a = qy * i - ey * self.rest[0];
                b = qz * i - ez * self.rest[1] + ea * d;
                yy = i * (ey - qy * qy / q);
                yz = -i * qy * qz / q;
                zz = i * (ez + ea * d * d - qz * qz / q);
            }
        }
        Some(turned([a, b, yy, yz, zz], [s, c]))
    }
}

/// Slopes and second slopes by (w_Y, w_Z), in the untwisted frame; sine and cosine of ψ.
#[inline]
fn turned([a, b, yy, yz, zz]: [f64; 5], [s, c]: [f64; 2]) -> [f64; 5] {
    [
        a * c - b * s,
        a * s + b * c,
        yy * c * c - 2.0 * yz * c * s + zz * s * s,
        (yy - zz) * c * s + yz * (c * c - s * s),
        yy * s * s + 2.0 * yz * c * s + zz * c * c,
    ]
}

/// Shortest centroid line per centreline length; below, the tube would be crushed.
const LEAST_RATE: f64 = 0.02;
/// Newton steps for ω.
const TURNS: usize = 30;

/// The section describes no bundle: no rates of rotation balance it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unbalanced;

/// What a tube's contribution depends on, in this order: label, tension, angle, torque, ω_y, ω_z, then what its weight depends on:
/// height, across y and z.
pub(crate) const INPUTS: usize = 9;
/// Lanes of numbers with slopes by all of them, and by the six that matter without weight: as many as vector registers take.
const WEIGHTED: usize = 12;
const UNWEIGHTED: usize = 8;

/// A tube's contribution and its slopes by its inputs.
pub(crate) struct Local {
    values: [f64; OUTPUTS],
    slopes: Slopes,
}

/// Slopes of a contribution.
struct Slopes {
    rows: [[f64; INPUTS]; OUTPUTS],
}

/// How many numbers a contribution has.
const OUTPUTS: usize = 10;

impl<L: Number> Contribution<L> {
    fn numbers(&self) -> [L; OUTPUTS] {
        let Self { energy, moment, advance, twist, by_angle, by_label, mass, arm } = *self;
        [energy, moment[0], moment[1], advance, twist, by_angle, by_label, mass, arm[0], arm[1]]
    }
}

impl Local {
    fn of<L: Number>(found: &Contribution<L>) -> Self {
        let all = found.numbers();
        let mut slopes = Slopes { rows: [[0.0; INPUTS]; OUTPUTS] };
        for (own, number) in slopes.rows.iter_mut().zip(&all) {
            for (own, slope) in own.iter_mut().zip(number.slopes()) {
                *own = *slope;
            }
        }
        Self { values: all.map(Number::value), slopes }
    }

    /// Slopes of E by the inputs.
    pub fn gradient(&self) -> [f64; INPUTS] {
        let [_, my, mz, advance, twist, by_angle, by_label, mass, ay, az] = self.values;
        [by_label, advance, by_angle, -twist, my, mz, -mass, -mass * ay, -mass * az]
    }

    /// Second slopes of E by the inputs.
    pub fn hessian(&self) -> SMatrix<f64, INPUTS, INPUTS> {
        let [.., mass, ay, az] = self.values;
        let [_, my, mz, advance, twist, by_angle, by_label, by_mass, by_ay, by_az] = &self.slopes.rows;
        SMatrix::from_fn(|i, j| match i {
            0 => by_label[j],
            1 => advance[j],
            2 => by_angle[j],
            3 => -twist[j],
            4 => my[j],
            5 => mz[j],
            6 => -by_mass[j],
            7 => -(by_mass[j] * ay + mass * by_ay[j]),
            _ => -(by_mass[j] * az + mass * by_az[j]),
        })
    }
}

/// A contribution in the numbers of the integration: each is made when it is asked for.
pub(crate) struct Seen<'b, S> {
    values: &'b [f64; OUTPUTS],
    slopes: Option<&'b Slopes>,
    /// What the contribution depends on: label, tension, angle, torque; ω; and what its weight depends on.
    state: &'b [S],
    omega: &'b [S; 2],
    weight: &'b [S],
}

impl<S: Number> Seen<'_, S> {
    #[inline]
    fn output(&self, which: usize) -> S {
        let mut own = S::constant(0.0);
        self.put(which, 1.0, &mut own);
        own
    }

    /// One number of the contribution, times a factor.
    #[inline]
    fn put(&self, which: usize, factor: f64, out: &mut S) {
        let inputs = self.state.iter().chain(self.omega).chain(self.weight);
        let slopes = self.slopes.map_or(&[][..], |slopes| &slopes.rows[which]);
        out.become_function(factor, self.values[which], slopes, inputs);
    }

    /// Slopes of the tube's state by the centreline length: label, tension, angle, torque.
    #[inline]
    pub fn put_slopes(&self, out: &mut [S]) {
        for (own, (which, factor)) in out.iter_mut().zip([(3, 1.0), (6, -1.0), (4, 1.0), (5, 1.0)]) {
            self.put(which, factor, own);
        }
    }

    pub fn energy(&self) -> S {
        self.output(0)
    }

    pub fn moment(&self) -> [S; 2] {
        [self.output(1), self.output(2)]
    }

    pub fn advance(&self) -> S {
        self.output(3)
    }

    pub fn twist(&self) -> S {
        self.output(4)
    }

    pub fn mass(&self) -> S {
        self.output(7)
    }

    pub fn arm(&self) -> [S; 2] {
        [self.output(8), self.output(9)]
    }
}

impl<'a> Tube<'a> {
    pub fn new(piece: &'a Piece, state: TubeState<f64>, weight: Option<Weight<f64>>, stretch: bool) -> Self {
        let direction = piece.direction(state.label);
        let (sin, cos) = (state.angle + direction[0]).sin_cos();
        let jets = piece.jets(state.label);
        let f = Fields::from_table(match (&piece.uniform, &jets) {
            (Some(values), _) => *values,
            (None, Some(jets)) => jets.map(|[value, ..]| value),
            (None, None) => [f64::NAN; FIELDS],
        });
        let h0 = 1.0 - f.offset * f.rest_z;
        let rest = [f.rest_y / h0, f.rest_z / h0];
        let mut tension = state.tension;
        if let Some(w) = &weight {
            tension -= f.mass * (w.height + f.offset * (w.across[0] * cos + w.across[1] * sin));
        }
        let torque = state.torque;
        let push = f.bend_y * rest[0] * rest[0] + f.bend_z * rest[1] * rest[1] - torque * torque / f.torsion
            + 2.0 * tension / h0
            + if stretch { f.axial } else { 0.0 };
        let plain = Plain {
            sin,
            cos,
            offset: f.offset,
            bend: [f.bend_y, f.bend_z],
            rest,
            push,
            axial: stretch.then_some(f.axial),
            metal: piece
                .metal
                .as_deref()
                .map(|metal| (metal, tension / h0 - 0.5 * torque * torque / f.torsion)),
        };
        Self { piece, state, weight, sin, cos, direction, jets, plain }
    }

    /// The contribution at ω with its slopes.
    pub fn local(&self, omega: [f64; 2]) -> Local {
        if self.weight.is_some() {
            Local::of(&self.contribution(omega, Dual::<WEIGHTED>::input))
        } else {
            Local::of(&self.contribution(omega, Dual::<UNWEIGHTED>::input))
        }
    }

    /// The contribution at ω.
    pub fn plain(&self, omega: [f64; 2]) -> Contribution<f64> {
        self.contribution(omega, |value, _| value)
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // One for each kind of number.
    fn contribution<L: Number>(&self, omega: [f64; 2], input: impl Fn(f64, usize) -> L) -> Contribution<L> {
        let TubeState { label, tension, angle, torque } = self.state;
        let state = TubeState {
            label: input(label, 0),
            tension: input(tension, 1),
            angle: input(angle, 2),
            torque: input(torque, 3),
        };
        let omega = [input(omega[0], 4), input(omega[1], 5)];
        let weight = self.weight.map(|w| Weight {
            height: input(w.height, 6),
            across: [input(w.across[0], 7), input(w.across[1], 8)],
        });
        if let Some(values) = &self.piece.uniform {
            return self.with_fields(&state, omega, weight, Fields::from_table(*values), None);
        }
        let jets = self.jets.unwrap_or([[f64::NAN; 3]; FIELDS]);
        let fields = Fields::from_table(jets.map(|[v, d, _]| state.label.chain(v, d)));
        let slopes = Fields::from_table(jets.map(|[_, d, dd]| state.label.chain(d, dd)));
        self.with_fields(&state, omega, weight, fields, Some(slopes))
    }

    #[inline(always)]
    #[allow(clippy::inline_always)]
    fn with_fields<L, F>(
        &self,
        state: &TubeState<L>,
        omega: [L; 2],
        weight: Option<Weight<L>>,
        f: Fields<F>,
        slopes: Option<Fields<L>>,
    ) -> Contribution<L>
    where
        F: Field,
        L: Number + Mul<F, Output = L> + Add<F, Output = L> + Sub<F, Output = L>,
    {
        let TubeState { label, tension, angle, torque } = *state;
        let turned = angle + label.chain(self.direction[0], self.direction[1]);
        let (sin, cos) = (turned.chain(self.sin, self.cos), turned.chain(self.cos, -self.sin));
        let (wy, wz) = (omega[0] * cos + omega[1] * sin, omega[1] * cos - omega[0] * sin);
        let one = L::constant(1.0);
        let h = one - wz * f.offset;
        let h0 = (f.offset * f.rest_z).one_minus();
        let inverse_h0 = h0.inverse();
        let (ky, kz) = (f.rest_y * inverse_h0, f.rest_z * inverse_h0);
        // The weight of the tube pulls at its label like a tension.
        let lifted = weight.as_ref().map(|w| {
            let along = w.across[0] * cos + w.across[1] * sin;
            let across = w.across[1] * cos - w.across[0] * sin;
            let potential = w.height + along * f.offset;
            (potential, along, across)
        });
        let pull = match &lifted {
            Some((potential, ..)) => tension - *potential * f.mass,
            None => tension,
        };
        let inverse_gj = f.torsion.inverse();
        let turned = torque * torque * inverse_gj;
        let square = wy * wy * f.bend_y + wz * wz * f.bend_z;
        let rest = f.bend_y * ky * ky + f.bend_z * kz * kz;
        let push = pull * inverse_h0 * 2.0 - turned + rest;
        let metal = self.plain.metal.map(|(metal, _)| {
            balanced(metal, [h, wy, wz], [one * ky, one * kz], pull * inverse_h0 - turned * 0.5)
        });
        let (g, line) = if let Some(found) = &metal {
            (found.length, found.efforts[0])
        } else if self.plain.axial.is_some() {
            let g = ((square + h * h * f.axial) / (push + f.axial)).sqrt();
            (g, (h / g - 1.0) * f.axial)
        } else {
            let inverse = one / h;
            (h, (push - square * inverse * inverse) * 0.5)
        };
        let inverse = one / g;
        // Curvature strains, and the moments that they make.
        let (by, bz) = (wy * inverse - ky, wz * inverse - kz);
        let [moment_y, about_z] = metal
            .as_ref()
            .map_or([by * f.bend_y, bz * f.bend_z], |found| [found.efforts[1], found.efforts[2]]);
        let moment_z = about_z - line * f.offset;
        let mut energy = match &metal {
            Some(found) => found.energy,
            None => (square * inverse + g * push) * 0.5 - wy * (f.bend_y * ky) - wz * (f.bend_z * kz),
        };
        if self.plain.axial.is_some() && metal.is_none() {
            let gap = h - g;
            energy += gap * gap * inverse * f.axial * 0.5;
        }
        let advance = g * inverse_h0;
        let twist = torque * inverse_gj * g;
        let mut by_angle = moment_y * wz - moment_z * wy;
        let mass = advance * f.mass;
        if let Some((_, _, across)) = &lifted {
            by_angle = by_angle - mass * f.offset * *across;
        }
        let mut by_label = L::constant(0.0);
        if let Some(d) = slopes {
            let h0_slope = -(d.offset * f.rest_z + d.rest_z * f.offset);
            let ky_slope = (d.rest_y - h0_slope * ky) * inverse_h0;
            let kz_slope = (d.rest_z - h0_slope * kz) * inverse_h0;
            by_label = -(line * wz * d.offset)
                + (d.bend_y * by * by + d.bend_z * bz * bz + turned * inverse_gj * d.torsion) * g * 0.5
                - g * (moment_y * ky_slope + bz * f.bend_z * kz_slope)
                - pull * advance * inverse_h0 * h0_slope;
            if self.plain.axial.is_some() {
                let stretch = h * inverse - 1.0;
                by_label += d.axial * stretch * stretch * g * 0.5;
            }
            if let Some((potential, along, _)) = &lifted {
                by_label = by_label - (d.mass * *potential + d.offset * *along * f.mass) * advance;
            }
        }
        if !self.piece.is_straight() {
            by_label += by_angle * label.chain(self.direction[1], self.direction[2]);
        }
        Contribution {
            energy,
            moment: [moment_y * cos - moment_z * sin, moment_y * sin + moment_z * cos],
            advance,
            twist,
            by_angle,
            by_label,
            mass,
            arm: [cos * f.offset, sin * f.offset],
        }
    }
}

/// The tubes of a section, what they depend on besides their state and what they contribute; kept from one section to the next.
pub(crate) struct Scratch<'a, S> {
    pub tubes: Vec<Tube<'a>>,
    /// State of the first tube where it is not as the integration has it.
    pub first: Option<[S; 4]>,
    /// Per tube, where there is gravity: height, across y and z.
    pub weights: Vec<[S; 3]>,
    locals: Vec<Local>,
    plain: Vec<[f64; OUTPUTS]>,
}

impl<S> Default for Scratch<'_, S> {
    fn default() -> Self {
        Self { tubes: Vec::new(), first: None, weights: Vec::new(), locals: Vec::new(), plain: Vec::new() }
    }
}

/// Finds ω for a moment (N m) from `guess`, which becomes its value. `each` receives the contributions of the tubes in order, whose states are in
/// `values`.
pub(crate) fn balance<S: Number>(
    scratch: &mut Scratch<S>,
    values: &[S],
    moment: [S; 2],
    guess: &mut [f64; 2],
    mut each: impl FnMut(usize, &Seen<S>),
) -> Result<[S; 2], Unbalanced> {
    let Scratch { tubes, first, weights, locals, plain } = scratch;
    let [yy, yz, zz] = rates(tubes, moment.map(Number::value), guess)?;
    let omega = *guess;
    if moment[0].slopes().is_empty() {
        plain.clear();
        plain.extend(tubes.iter().map(|tube| tube.plain(omega).numbers()));
        for (i, values) in plain.iter().enumerate() {
            each(i, &Seen { values, slopes: None, state: &[], omega: &moment, weight: &[] });
        }
        return Ok(omega.map(S::constant));
    }
    let first = &*first;
    let state = |place: usize| match first {
        Some(first) if place == 0 => first,
        _ => &values[4 * place..4 * place + 4],
    };
    let weight = |place: usize| weights.get(place).map_or(&[][..], |own| &own[..]);
    locals.clear();
    locals.extend(tubes.iter().map(|tube| tube.local(omega)));
    let at = omega.map(S::constant);
    // One more step with numbers that carry slopes gives the slopes of ω.
    let mut residual = [-moment[0], -moment[1]];
    for (i, Local { values, slopes }) in locals.iter().enumerate() {
        let own =
            Seen { values, slopes: Some(slopes), state: state(i), omega: &at, weight: weight(i) }.moment();
        residual[0].add_scaled(1.0, &own[0]);
        residual[1].add_scaled(1.0, &own[1]);
    }
    let inverse = 1.0 / (yy * zz - yz * yz);
    let omega = [
        at[0].plus(-zz * inverse, residual[0]).plus(yz * inverse, residual[1]),
        at[1].plus(-yy * inverse, residual[1]).plus(yz * inverse, residual[0]),
    ];
    for (i, Local { values, slopes }) in locals.iter().enumerate() {
        let (state, omega, weight) = (state(i), &omega, weight(i));
        each(i, &Seen { values, slopes: Some(slopes), state, omega, weight });
    }
    Ok(omega)
}

/// Finds the rates of rotation ω for a moment (N m) by Newton's method from `guess`, which becomes its value; G is convex in ω, so that steps halved where
/// the residual grows arrive. Gives the second slopes of G there: yy, yz, zz.
pub(crate) fn rates(tubes: &[Tube], load: [f64; 2], guess: &mut [f64; 2]) -> Result<[f64; 3], Unbalanced> {
    let slopes = |omega: [f64; 2]| {
        let mut sum = [-load[0], -load[1], 0.0, 0.0, 0.0];
        for tube in tubes {
            for (sum, own) in sum.iter_mut().zip(tube.plain.slopes(omega)?) {
                *sum += own;
            }
        }
        Some(sum)
    };
    let mut omega = *guess;
    let mut here = if let Some(here) = slopes(omega) {
        here
    } else {
        omega = [0.0; 2];
        slopes(omega).ok_or(Unbalanced)?
    };
    let mut settled = false;
    for _ in 0..TURNS {
        let [a, b, yy, yz, zz] = here;
        let det = yy * zz - yz * yz;
        let step = [(b * yz - a * zz) / det, (a * yz - b * yy) / det];
        let decrement = -(a * step[0] + b * step[1]);
        if !(det > 0.0 && decrement.is_finite()) {
            return Err(Unbalanced);
        }
        let mut factor = 1.0;
        loop {
            let trial = [omega[0] + factor * step[0], omega[1] + factor * step[1]];
            match slopes(trial) {
                // The slope along the step has not turned far beyond the minimum.
                Some(there)
                    if there[0] * step[0] + there[1] * step[1] <= 0.5 * decrement + f64::MIN_POSITIVE =>
                {
                    (omega, here) = (trial, there);
                    break;
                }
                _ => factor *= 0.5,
            }
            if factor < 1e-6 {
                // Rounding is all that is left, or nothing balances.
                settled = true;
                break;
            }
        }
        let size = 1.0 + omega[0].abs().max(omega[1].abs());
        if settled || (factor * step[0]).abs().max((factor * step[1]).abs()) <= 1e-7 * size {
            settled = true;
            break;
        }
    }
    if !settled {
        return Err(Unbalanced);
    }
    *guess = omega;
    let [_, _, second @ ..] = here;
    Ok(second)
}
