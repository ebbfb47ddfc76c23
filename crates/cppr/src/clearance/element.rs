//! Energy of one element: a stretch of the leader with what every follower does beside it, in the plane.
//!
//! The leader's label X, a length of its centroid line at rest, counts the sections; θ is the leader's angle, K = θ' its turning. With the centroid of the leader at σ_1 D_1 in the direction Y, and its stretch e,
//! a line at the height y over the leader's axis advances by a_c − y K per label, a_c = 1 + e + σ_1 D_1 K. So for a follower whose axis stands at the height y(X)
//!
//! ```text
//! a = a_c − y K ,  y' = a tan α ,  g = √(a² + y'²) ,  K_k = K + α' ,  α' = (y'' a − y' a')/g² ,  G = g − σ_k D_k K_k .
//! ```
//!
//! G is the length of the follower's centroid line per label. Where it does not stretch it is x', x the follower's own label, and ½ EI_k K_k²/G its energy; the
//! tension λ holds the condition. With stretch, x' = h is free, ½ EI_k K_k²/h + ½ EA_k (G − h)²/h + λ h is least for
//! h² = (½ EI_k K_k² + ½ EA_k G²)/(½ EA_k + λ), which leaves
//!
//! ```text
//! W = √((EI_k K_k² + EA_k G²)(EA_k + 2 λ)) − EA_k G .
//! ```
//!
//! Of these θ is a quadratic polynomial of X in the element, e and x are linear, y is Hermite's cubic with the slopes a tan α at the nodes: what joins
//! the elements is the angle α, which stays continuous where a jumps. λ is constant. Everything is in units of the length L, of EI and of EI/L².

use super::number::Second;
use crate::design::fields::{Fields, Jet, Part};
use std::array::from_fn;

/// Inputs of an element.
pub(super) const INPUTS: usize = 14;
pub(super) type Number = Second<INPUTS>;

/// Places of the inputs: the leader's angles at both ends and the middle, its stretch at both ends; angle α, height y and label x of the follower at both ends, its tension; labels of the ends.
pub(super) const ANGLES: [usize; 3] = [0, 1, 2];
pub(super) const STRETCHES: [usize; 2] = [3, 4];
pub(super) const FIRST: [usize; 3] = [5, 6, 7];
pub(super) const LAST: [usize; 3] = [8, 9, 10];
pub(super) const TENSION: usize = 11;
pub(super) const LABELS: [usize; 2] = [12, 13];

/// Gauss points on [0, 1] and their weights.
const RULE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// One tube, in scaled units.
#[derive(Clone, Copy, Debug)]
pub(super) struct TubeFields<'a> {
    pub fields: &'a Fields,
    /// +1 where its centroid lies towards +Y.
    pub side: f64,
    /// Units of length (m) and of bending stiffness (N m²).
    pub units: [f64; 2],
}

impl TubeFields<'_> {
    /// σ D, EI and EA at a label of its own.
    fn at(&self, label: &Number, part: Part) -> [Number; 3] {
        let [length, stiffness] = self.units;
        let jets = self.fields.jets(label.value * length, part);
        let scaled = |[value, slope, bend]: Jet, unit: f64| {
            label.chain([value / unit, slope * length / unit, bend * length * length / unit])
        };
        [
            scaled(jets.offset, length) * self.side,
            scaled(jets.bending_z, stiffness),
            scaled(jets.axial, stiffness / (length * length)),
        ]
    }

    /// σ D and its slope by the label.
    fn offset(&self, label: &Number) -> [Number; 2] {
        let [length, _] = self.units;
        let [value, slope, bend] = self.fields.offset(label.value * length, Part::Pattern);
        // The third derivative of a cubic spline is constant on its cells; it would enter with K alone and is left out.
        [
            label.chain([value / length, slope, bend * length]) * self.side,
            label.chain([slope, bend * length, 0.0]) * self.side,
        ]
    }
}

/// Where in the element, and what the leader does there.
struct Place {
    label: Number,
    angle: Number,
    turning: Number,
    bending: Number,
    stretch: Number,
    /// a_c and its slope.
    advance: [Number; 2],
}

/// An element and the values of its inputs.
pub(super) struct Element<'a> {
    pub leader: TubeFields<'a>,
    pub inputs: [Number; INPUTS],
    pub stretches: bool,
}

impl Element<'_> {
    fn length(&self) -> Number {
        self.inputs[LABELS[1]] - self.inputs[LABELS[0]]
    }

    fn place(&self, xi: f64) -> Place {
        let [a, m, b] = ANGLES.map(|i| self.inputs[i]);
        let inverse = self.length().inverse();
        let angle =
            a * ((1.0 - xi) * (1.0 - 2.0 * xi)) + m * (4.0 * xi * (1.0 - xi)) + b * (xi * (2.0 * xi - 1.0));
        let turning = (a * (4.0 * xi - 3.0) + m * (4.0 - 8.0 * xi) + b * (4.0 * xi - 1.0)) * inverse;
        let bending = (a * 4.0 - m * 8.0 + b * 4.0) * inverse * inverse;
        let label = self.inputs[LABELS[0]] * (1.0 - xi) + self.inputs[LABELS[1]] * xi;
        let [offset, slope] = self.leader.offset(&label);
        let (mut advance, mut rate) = (offset * turning + 1.0, slope * turning + offset * bending);
        let mut stretch = Number::constant(0.0);
        if self.stretches {
            let [a, b] = STRETCHES.map(|i| self.inputs[i]);
            stretch = a * (1.0 - xi) + b * xi;
            advance = advance + stretch;
            rate = rate + (b - a) * inverse;
        }
        Place { label, angle, turning, bending, stretch, advance: [advance, rate] }
    }

    /// Energy of the leader, and the potential of dead forces on its axis: `beyond` gives the force on all beyond a label, and its slope.
    pub fn leader_energy(&self, beyond: impl Fn(f64) -> [[f64; 2]; 2]) -> Number {
        let length = self.length();
        let each = RULE.map(|(xi, weight)| {
            let at = self.place(xi);
            let [_, bending, axial] = self.leader.at(&at.label, Part::Pattern);
            let mut energy = bending * at.turning * at.turning * 0.5;
            if self.stretches {
                energy = energy + axial * at.stretch * at.stretch * 0.5;
            }
            let [force, rate] = beyond(at.label.value);
            if force[0].abs() + force[1].abs() > 0.0 {
                let (sin, cos) = at.angle.sin_cos();
                let [x, y] = from_fn(|i| at.label.chain([force[i], rate[i], 0.0]));
                energy = energy - at.advance[0] * (cos * x + sin * y);
            }
            energy * length * weight
        });
        each[0] + each[1] + each[2]
    }

    /// How far the axis of the leader advances from end to end.
    pub fn advance(&self) -> [f64; 2] {
        let length = self.length().value;
        RULE.iter().fold([0.0; 2], |[x, y], (xi, weight)| {
            let at = self.place(*xi);
            let (sin, cos) = at.angle.value.sin_cos();
            let way = at.advance[0].value * length * weight;
            [x + cos * way, y + sin * way]
        })
    }

    /// Energy of a follower, with λ times what its label misses.
    pub fn follower_energy(&self, tube: &TubeFields, part: Part) -> Number {
        let length = self.length();
        let inverse = length.inverse();
        let [first, last] = [FIRST, LAST].map(|ends| ends.map(|i| self.inputs[i]));
        let slopes: [Number; 2] = from_fn(|end| {
            let at = self.place(if end == 0 { 0.0 } else { 1.0 });
            let [alpha, height, _] = if end == 0 { first } else { last };
            (at.advance[0] - height * at.turning) * alpha.tan()
        });
        let drop = (first[1] - last[1]) * inverse;
        let tension = self.inputs[TENSION];
        let each = RULE.map(|(xi, weight)| {
            let at = self.place(xi);
            let (x2, x3) = (xi * xi, xi * xi * xi);
            let y = first[1] * (1.0 - 3.0 * x2 + 2.0 * x3)
                + last[1] * (3.0 * x2 - 2.0 * x3)
                + length * (slopes[0] * (xi - 2.0 * x2 + x3) + slopes[1] * (x3 - x2));
            let slope = drop * (6.0 * x2 - 6.0 * xi)
                + slopes[0] * (1.0 - 4.0 * xi + 3.0 * x2)
                + slopes[1] * (3.0 * x2 - 2.0 * xi);
            let bend = inverse
                * (drop * (12.0 * xi - 6.0) + slopes[0] * (6.0 * xi - 4.0) + slopes[1] * (6.0 * xi - 2.0));
            let a = at.advance[0] - y * at.turning;
            let rate = at.advance[1] - slope * at.turning - y * at.bending;
            let square = a * a + slope * slope;
            let turning = at.turning + (bend * a - slope * rate) * square.inverse();
            let label = first[2] * (1.0 - xi) + last[2] * xi;
            let [offset, bending, axial] = tube.at(&label, part);
            let line = square.sqrt() - offset * turning;
            let bent = bending * turning * turning;
            let energy = if self.stretches {
                ((bent + axial * line * line) * (axial + tension * 2.0)).sqrt() - axial * line
            } else {
                bent * line.inverse() * 0.5 + tension * line
            };
            energy * length * weight
        });
        each[0] + each[1] + each[2] - tension * (last[2] - first[2])
    }
}

#[cfg(test)]
mod tests {
    use super::{Element, INPUTS, Number, TubeFields};
    use crate::design::fields::Part;
    use crate::design::{Profile, Robot, RobotDesign, StiffnessTube};
    use std::f64::consts::PI;

    /// Slopes and second derivatives by all inputs against differences, with fields that vary, with and without stretch.
    #[test]
    fn derivatives_are_those_of_the_energy() {
        let tube = |offset: f64, stiffness: f64, direction: f64| StiffnessTube {
            centroid_offset: Profile::constant(offset),
            bending_z: Profile::linear(stiffness, 0.7 * stiffness),
            axial: Some(Profile::linear(900.0, 700.0)),
            ..StiffnessTube::uniform(offset, direction, [stiffness; 2], stiffness)
        };
        let tubes = vec![tube(3e-3, 1.5e-3, 0.0).into(), tube(1e-3, 0.8e-3, PI).into()];
        let robot = Robot::from_design(RobotDesign { name: "pair".into(), length: 0.1, tubes }).unwrap();
        let units = [0.1, 2.3e-3];
        let fields =
            [(0, 1.0), (1, -1.0)].map(|(i, side)| TubeFields { fields: &robot.fields()[i], side, units });
        let at = [0.1, 0.12, 0.15, 1e-3, 2e-3, 0.03, 4e-3, 0.31, -0.02, 5e-3, 0.42, 6.0, 0.3, 0.4];
        for stretches in [false, true] {
            let energy = |values: [f64; INPUTS]| -> Number {
                let inputs = std::array::from_fn(|i| Number::input(values[i], i));
                let element = Element { leader: fields[0], inputs, stretches };
                element.follower_energy(&fields[1], Part::Pattern)
                    + element.leader_energy(|label| [[2.0, 3.0 - 0.5 * label], [0.0, -0.5]])
            };
            let own = energy(at);
            for i in 0..INPUTS {
                let step = 1e-5;
                let [before, after] = [-step, step].map(|s| {
                    let mut moved = at;
                    moved[i] += s;
                    energy(moved)
                });
                let slope = (after.value - before.value) / (2.0 * step);
                let size = own.slopes[i].abs().max(1.0);
                assert!((slope - own.slopes[i]).abs() < 1e-6 * size, "{i}: {slope} for {}", own.slopes[i]);
                for j in 0..INPUTS {
                    let bend = (after.slopes[j] - before.slopes[j]) / (2.0 * step);
                    let size = own.bends[j][j].abs().max(own.bends[i][i].abs()).max(1.0);
                    assert!(
                        (bend - own.bends[i][j]).abs() < 1e-5 * size,
                        "{i}, {j}: {bend} for {}",
                        own.bends[i][j]
                    );
                }
            }
        }
    }
}
