//! Energy of one element of one tube: a rod between two nodes, in space.
//!
//! R(ξ), 0 ≤ ξ ≤ 1, is the rotation of the tube's material against that of the straight tube, x(ξ) its label, a length of its axis when free, linear in ξ. With
//!
//! ```text
//! R(ξ) = R_a exp(Θ(ξ)^) ,   Θ(0) = 0 ,  Θ(½) = Θ_m ,  Θ(1) = log(R_aᵀ R_b) ,   Θ quadratic,   k = J(Θ)ᵀ dΘ/dξ ,
//! ```
//!
//! k are the rates of twist and bending per ξ. A tube that is curved by κ° when free has the centroid line Δℓ = Δx (1 − D κ°_Z) there. Where the centroid stands at D in the direction φ of the section, the axis advances along its tangent t = R e_x by
//! a = Δℓ (1 + e) + D k_Z per ξ. The force n that the element carries, constant along it, holds its ends at their places p:
//!
//! ```text
//! W = ∫ ½ (GJ k_x² + EI_Y (k_Y − κ°_Y Δx)² + EI_Z (k_Z − κ°_Z Δx)²)/Δℓ − (n·t) a + ½ EA e² Δℓ dξ + n·(p_b − p_a) ,
//! ```
//!
//! where a tube that stretches has e = n·t/EA. A force f per label (the weight of the tube, or a load) does the work ∫ f·p dx with p of the same formula:
//! (1 − ξ) Δx f is added to n in the integral, and Δx f·p_a taken off. Everything is in units of the length L, of EI and of EI/L².

use super::number::Second;
use crate::bundle::BundleTube;
use crate::bundle::curve::Piece;
use nalgebra::{UnitQuaternion, Vector3};
use std::array::from_fn;

/// Places of an element's inputs: small turns of both ends about their own axes, with Θ_m between; labels; force; places of the ends. Each but the labels has three components.
pub(super) const TURNS: [usize; 2] = [0, 6];
pub(super) const MIDDLE: usize = 3;
pub(super) const LABELS: [usize; 2] = [9, 10];
pub(super) const FORCE: usize = 11;
pub(super) const PLACES: [usize; 2] = [14, 17];
pub(super) const INPUTS: usize = 20;
pub(super) type Number = Second<INPUTS>;

/// Inputs of the rotation alone.
const ROTATIONS: usize = 9;
type Turning = Second<ROTATIONS>;

/// Inputs of the energy at a point: k, label, Δx; t along the force, the gravity and the load; gravity along the section's material axes; gravity and load along p_a.
const LOCAL: usize = 12;
type Local = Second<LOCAL>;
const ALONG_FORCE: usize = 5;

/// Gauss points on [0, 1] and their weights.
const RULE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// Series in the squared angle of sin ϑ/ϑ, (1 − cos ϑ)/ϑ², (ϑ − sin ϑ)/ϑ³ and, in the squared sine, of asin(s)/s: the angle of an element is small.
const SINE: [f64; 7] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];
const COSINE: [f64; 7] = [
    0.5,
    -1.0 / 24.0,
    1.0 / 720.0,
    -1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    -1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
];
const THIRD: [f64; 7] = [
    1.0 / 6.0,
    -1.0 / 120.0,
    1.0 / 5040.0,
    -1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    -1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
];
const ARC: [f64; 7] =
    [1.0, 1.0 / 6.0, 3.0 / 40.0, 5.0 / 112.0, 35.0 / 1152.0, 63.0 / 2816.0, 231.0 / 13_312.0];

/// One tube, in scaled units.
#[derive(Clone, Copy, Debug)]
pub(super) struct TubeFields<'a> {
    pub tube: &'a BundleTube,
    /// Units of length (m) and of bending stiffness (N m²).
    pub units: [f64; 2],
    pub stretches: bool,
}

/// Forces per label on a tube: gravity, times its mass per length, and a load.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    pub gravity: Vector3<f64>,
    pub load: Vector3<f64>,
}

/// An element and the values of its inputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub turns: [UnitQuaternion<f64>; 2],
    pub middle: Vector3<f64>,
    pub labels: [f64; 2],
    pub force: Vector3<f64>,
    pub places: [Vector3<f64>; 2],
    /// First and last piece of its tube that it may lie on.
    pub part: [usize; 2],
}

type Triple = [Turning; 3];

fn cross(a: &Triple, b: &Triple) -> Triple {
    from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

fn series(square: &Turning, coefficients: &[f64; 7]) -> Turning {
    let t = square.value;
    let [mut value, mut slope, mut bend] = [0.0; 3];
    for own in coefficients.iter().rev() {
        (value, slope, bend) = (value * t + own, slope * t + value, bend * t + 2.0 * slope);
    }
    square.chain([value, slope, bend])
}

fn square(v: &Triple) -> Turning {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
}

/// Quaternions a b.
fn product(a: &[Turning; 4], b: &[Turning; 4]) -> [Turning; 4] {
    let ([s, x, y, z], [t, u, v, w]) = (*a, *b);
    [
        s * t - x * u - y * v - z * w,
        s * u + x * t + y * w - z * v,
        s * v + y * t + z * u - x * w,
        s * w + z * t + x * v - y * u,
    ]
}

/// exp(±δ/2) of three inputs whose value is 0, to second order.
fn turn(first: usize, sign: f64) -> [Turning; 4] {
    let own: Triple = from_fn(|i| Turning::input(0.0, first + i));
    [square(&own) * -0.125 + 1.0, own[0] * (0.5 * sign), own[1] * (0.5 * sign), own[2] * (0.5 * sign)]
}

/// Rotation within an element.
struct Course {
    middle: Triple,
    last: Triple,
}

impl Course {
    fn of(element: &Element) -> Self {
        let between = element.turns[0].inverse() * element.turns[1];
        let sign = if between.w < 0.0 { -1.0 } else { 1.0 };
        let between = [between.w, between.i, between.j, between.k].map(|own| Turning::constant(sign * own));
        let [_, v @ ..] = product(&product(&turn(TURNS[0], -1.0), &between), &turn(TURNS[1], 1.0));
        let arc = series(&square(&v), &ARC) * 2.0;
        Self {
            middle: from_fn(|i| Turning::input(element.middle[i], MIDDLE + i)),
            last: v.map(|own| own * arc),
        }
    }

    /// Θ and dΘ/dξ.
    fn at(&self, xi: f64) -> [Triple; 2] {
        let mix = |m: f64, l: f64| from_fn(|i| self.middle[i] * m + self.last[i] * l);
        [mix(4.0 * xi * (1.0 - xi), xi * (2.0 * xi - 1.0)), mix(4.0 - 8.0 * xi, 4.0 * xi - 1.0)]
    }
}

/// Twist and bending per ξ.
fn rates([theta, rate]: &[Triple; 2]) -> Triple {
    let across = cross(theta, rate);
    let twice = cross(theta, &across);
    let angle = square(theta);
    let (c, third) = (series(&angle, &COSINE), series(&angle, &THIRD));
    from_fn(|i| rate[i] - c * across[i] + third * twice[i])
}

impl Element {
    /// A material axis in the base frame where the rotation vector against the first end is Θ.
    fn axis(&self, theta: &Triple, which: usize) -> Triple {
        let unit: Triple = from_fn(|i| Turning::constant(if i == which { 1.0 } else { 0.0 }));
        let across = cross(theta, &unit);
        let twice = cross(theta, &across);
        let angle = square(theta);
        let (s, c) = (series(&angle, &SINE), series(&angle, &COSINE));
        let own: Triple = from_fn(|i| unit[i] + s * across[i] + c * twice[i]);
        // The first end turns by a small δ of its own axes.
        let small: Triple = from_fn(|i| Turning::input(0.0, TURNS[0] + i));
        let once = cross(&small, &own);
        let twice = cross(&small, &once);
        let turned: Triple = from_fn(|i| own[i] + once[i] + twice[i] * 0.5);
        let matrix = self.turns[0].to_rotation_matrix();
        from_fn(|i| turned[0] * matrix[(i, 0)] + turned[1] * matrix[(i, 1)] + turned[2] * matrix[(i, 2)])
    }

    /// W with its derivatives by all inputs.
    pub fn energy(&self, tube: &TubeFields, spread: &Spread) -> Number {
        let course = Course::of(self);
        let mut whole = Number::constant(0.0);
        let [from, to] = self.labels;
        let heavy = spread.gravity.norm() > 0.0;
        for (xi, weight) in RULE {
            let at = course.at(xi);
            let k = rates(&at);
            let tangent = self.axis(&at[0], 0);
            let along = |v: &Vector3<f64>, axis: &Triple| axis[0] * v.x + axis[1] * v.y + axis[2] * v.z;
            let mut inputs = [Turning::constant(0.0); LOCAL];
            inputs[..3].copy_from_slice(&k);
            inputs[3].value = from * (1.0 - xi) + to * xi;
            inputs[4].value = to - from;
            inputs[ALONG_FORCE] = along(&self.force, &tangent);
            inputs[6] = along(&spread.gravity, &tangent);
            inputs[7] = along(&spread.load, &tangent);
            if heavy {
                inputs[8] = along(&spread.gravity, &self.axis(&at[0], 1));
                inputs[9] = along(&spread.gravity, &self.axis(&at[0], 2));
            }
            inputs[10].value = spread.gravity.dot(&self.places[0]);
            inputs[11].value = spread.load.dot(&self.places[0]);
            let local = tube.energy(&inputs.map(|own| own.value), self.part, xi) * weight;
            // Slopes of the local inputs by those of the element.
            let mut slopes = [[0.0; INPUTS]; LOCAL];
            for (own, input) in slopes.iter_mut().zip(&inputs) {
                own[..ROTATIONS].copy_from_slice(&input.slopes);
            }
            (slopes[3][LABELS[0]], slopes[3][LABELS[1]]) = (1.0 - xi, xi);
            (slopes[4][LABELS[0]], slopes[4][LABELS[1]]) = (-1.0, 1.0);
            for i in 0..3 {
                slopes[ALONG_FORCE][FORCE + i] = tangent[i].value;
                slopes[10][PLACES[0] + i] = spread.gravity[i];
                slopes[11][PLACES[0] + i] = spread.load[i];
            }
            whole.value += local.value;
            for (a, by) in slopes.iter().enumerate() {
                let mut row = [0.0; INPUTS];
                for (b, other) in slopes.iter().enumerate() {
                    let bend = local.bends[a][b];
                    for (own, other) in row.iter_mut().zip(other) {
                        *own += bend * other;
                    }
                }
                for (i, factor) in by.iter().enumerate() {
                    whole.slopes[i] += local.slopes[a] * factor;
                    for (own, value) in whole.bends[i].iter_mut().zip(&row) {
                        *own += factor * value;
                    }
                }
                for (own, bends) in whole.bends.iter_mut().zip(&inputs[a].bends) {
                    for (own, bend) in own.iter_mut().zip(bends) {
                        *own += local.slopes[a] * bend;
                    }
                }
            }
            for (i, tangent) in tangent.iter().enumerate() {
                for (r, slope) in tangent.slopes.iter().enumerate() {
                    let bend = local.slopes[ALONG_FORCE] * slope;
                    whole.bends[r][FORCE + i] += bend;
                    whole.bends[FORCE + i][r] += bend;
                }
            }
        }
        let way = self.places[1] - self.places[0];
        whole.value += self.force.dot(&way);
        for i in 0..3 {
            whole.slopes[FORCE + i] += way[i];
            for (place, sign) in PLACES.into_iter().zip([-1.0, 1.0]) {
                whole.slopes[place + i] += sign * self.force[i];
                whole.bends[FORCE + i][place + i] += sign;
                whole.bends[place + i][FORCE + i] += sign;
            }
        }
        whole
    }
}

impl TubeFields<'_> {
    /// Label of its tip.
    pub fn tip(&self) -> f64 {
        self.tube.tip / self.units[0]
    }

    /// Least bending stiffness where its pieces end.
    pub fn softest(&self) -> f64 {
        let ends = self.tube.pieces.iter().map(|own| own.field(2, own.to)[0].min(own.field(1, own.to)[0]));
        ends.fold(f64::INFINITY, f64::min) / self.units[1]
    }

    /// The piece at a label (m).
    fn piece(&self, label: f64, [first, last]: [usize; 2]) -> &Piece {
        let pieces = &self.tube.pieces[first..=last];
        &pieces[pieces.partition_point(|own| own.to <= label).min(pieces.len() - 1)]
    }

    /// Direction of its centroid (rad) at a label.
    pub fn direction(&self, label: f64, part: [usize; 2]) -> f64 {
        let x = label * self.units[0];
        self.piece(x, part).direction(x)[0]
    }

    /// Energy per ξ, with the work of force and loads, of the local inputs.
    fn energy(&self, values: &[f64; LOCAL], part: [usize; 2], xi: f64) -> Local {
        let [k_x, k_y, k_z, label, way, force, gravity, load, side_y, side_z, lifted, carried] =
            from_fn(|i| Local::input(values[i], i));
        let [length, stiffness] = self.units;
        let x = label.value * length;
        let own = self.piece(x, part);
        let [offset, bending_y, bending_z, torsion, axial, mass, rest_y, rest_z] =
            own.jets(x).unwrap_or_else(|| from_fn(|which| own.field(which, x)));
        let scaled = |[value, slope, bend]: [f64; 3], unit: f64| {
            label.chain([value / unit, slope * length / unit, bend * length * length / unit])
        };
        let [phi, slope, bend] = own.direction(x);
        let (sin, cos) = label.chain([phi, slope * length, bend * length * length]).sin_cos();
        let (bent_y, bent_z) = (k_y * cos + k_z * sin, k_z * cos - k_y * sin);
        let offset = scaled(offset, length);
        let [mut strain_y, mut strain_z, mut line] = [bent_y, bent_z, way];
        if [rest_y, rest_z].iter().flatten().any(|own| own.abs() > 0.0) {
            let [rest_y, rest_z] = [rest_y, rest_z].map(|own| scaled(own, 1.0 / length) * way);
            line = way - offset * rest_z;
            (strain_y, strain_z) = (bent_y - rest_y, bent_z - rest_z);
        }
        let strained = scaled(torsion, stiffness) * k_x * k_x
            + scaled(bending_y, stiffness) * strain_y * strain_y
            + scaled(bending_z, stiffness) * strain_z * strain_z;
        let mass = scaled(mass, 1.0);
        let drawn = force + way * (mass * gravity + load) * (1.0 - xi);
        let mut energy = strained * line.inverse() * 0.5
            - drawn * (line + offset * bent_z)
            - way * (mass * (lifted + offset * (side_y * cos + side_z * sin)) + carried);
        if self.stretches {
            let axial = scaled(axial, stiffness / (length * length));
            energy = energy - drawn * drawn * line * axial.inverse() * 0.5;
        }
        energy
    }
}

#[cfg(test)]
mod tests {
    use super::{Element, FORCE, INPUTS, LABELS, MIDDLE, Number, PLACES, Spread, TURNS, TubeFields};
    use crate::bundle::{Bundle, BundleDesign, Part, TubeParts};
    use crate::design::{Profile, StiffnessTube};
    use nalgebra::{UnitQuaternion, Vector3};

    /// An element with its inputs moved.
    fn moved(element: &Element, step: &[f64; INPUTS]) -> Element {
        let three = |at: usize| Vector3::new(step[at], step[at + 1], step[at + 2]);
        Element {
            turns: [0, 1].map(|i| element.turns[i] * UnitQuaternion::from_scaled_axis(three(TURNS[i]))),
            middle: element.middle + three(MIDDLE),
            labels: [0, 1].map(|i| element.labels[i] + step[LABELS[i]]),
            force: element.force + three(FORCE),
            places: [0, 1].map(|i| element.places[i] + three(PLACES[i])),
            part: element.part,
        }
    }

    /// Slopes and second derivatives by all inputs against differences, with fields that vary, loads, with and without stretch.
    #[test]
    fn derivatives_are_those_of_the_energy() {
        let tube = StiffnessTube {
            centroid_offset: Profile::linear(3e-3, 2e-3),
            direction: Profile::linear(0.2, 1.4),
            bending_z: Profile::linear(1.5e-3, 1e-3),
            axial: Some(Profile::linear(900.0, 700.0)),
            mass_per_length: Profile::linear(0.2, 0.1),
            ..StiffnessTube::uniform(3e-3, 0.0, [4e-3, 1.5e-3], 2e-3)
        };
        let part = Part { length: 0.1, body: tube.into(), rest_curvature: 4.0, rest_direction: 0.6 };
        let tubes = vec![TubeParts::new(vec![part], None)];
        let bundle = Bundle::new(&BundleDesign { name: "one".into(), tubes, joints: Vec::new() }).unwrap();
        let own = &bundle.tubes[0];
        let turn = |x: f64, y: f64, z: f64| UnitQuaternion::from_scaled_axis(Vector3::new(x, y, z));
        let first = turn(0.4, -0.3, 1.0);
        let element = Element {
            turns: [first, first * turn(0.05, -0.1, 0.12)],
            middle: Vector3::new(0.02, -0.06, 0.05),
            labels: [0.31, 0.42],
            force: Vector3::new(1.0, -2.0, 3.0),
            places: [Vector3::new(0.3, 0.1, -0.1), Vector3::new(0.36, 0.18, -0.05)],
            part: [1, own.pieces.len() - 1],
        };
        let spread = Spread { gravity: Vector3::new(0.5, -2.0, 1.0), load: Vector3::new(-0.3, 0.4, 1.0) };
        for stretches in [false, true] {
            let tube = TubeFields { tube: own, units: [0.1, 2.3e-3], stretches };
            let known = element.energy(&tube, &spread);
            let h = 1e-4;
            let at = |steps: [(usize, f64); 2]| -> Number {
                let mut step = [0.0; INPUTS];
                for (i, way) in steps {
                    step[i] += way;
                }
                moved(&element, &step).energy(&tube, &spread)
            };
            for i in 0..INPUTS {
                let [before, after] = [-h, h].map(|s| at([(i, s), (i, 0.0)]).value);
                let slope = (after - before) / (2.0 * h);
                assert!((slope - known.slopes[i]).abs() < 1e-5, "{i}: {slope} for {}", known.slopes[i]);
                for j in 0..INPUTS {
                    let four = [(h, h), (-h, -h), (h, -h), (-h, h)].map(|(a, b)| at([(i, a), (j, b)]).value);
                    let bend = (four[0] + four[1] - four[2] - four[3]) / (4.0 * h * h);
                    let known = known.bends[i][j];
                    assert!(
                        (bend - known).abs() < 1e-5 * known.abs().max(1.0),
                        "{i}, {j}: {bend} for {known}"
                    );
                }
            }
        }
    }
}
