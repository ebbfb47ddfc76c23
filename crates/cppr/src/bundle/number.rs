//! Numbers that the integration runs on: plain ones, and ones that carry their derivatives along.
//!
//! `Dual<P>` holds a value and its slopes by P inputs; every operation follows the rules of differentiation, so that an
//! integration with it gives the solution and its exact sensitivities at once. `num-dual` has the same arithmetic, with an optional
//! block of slopes whose branches keep the compiler from using vector instructions.

use std::array::from_fn;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// What the kernel asks of a material field: a plain number where it is uniform, one with slopes elsewhere.
pub(crate) trait Field: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn one_minus(self) -> Self;
    fn inverse(self) -> Self;
}

/// What the kernel asks of a number.
pub(crate) trait Number:
    Field
    + Debug
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
{
    /// A number that no input moves.
    fn constant(value: f64) -> Self;

    /// The value alone.
    fn value(self) -> f64;

    /// f(self), given value and slope of f at the value.
    fn chain(self, value: f64, slope: f64) -> Self;

    /// self + factor · other.
    fn plus(self, factor: f64, other: Self) -> Self;

    /// The number with another value. By how much it differs is added to the last slope, see [`steps`](super::steps).
    fn moved_to(self, value: f64) -> Self;

    /// Slopes by the inputs.
    fn slopes(&self) -> &[f64];

    fn slopes_mut(&mut self) -> &mut [f64];

    /// A function of numbers, given its value and its slopes by them.
    fn combine(value: f64, weights: &[f64], numbers: &[Self]) -> Self;

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value().sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, 0.5 / root)
    }
}

impl Field for f64 {
    fn one_minus(self) -> Self {
        1.0 - self
    }

    fn inverse(self) -> Self {
        1.0 / self
    }
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn chain(self, value: f64, _: f64) -> Self {
        value
    }

    fn plus(self, factor: f64, other: Self) -> Self {
        self + factor * other
    }

    fn moved_to(self, value: f64) -> Self {
        value
    }

    fn slopes(&self) -> &[f64] {
        &[]
    }

    fn slopes_mut(&mut self) -> &mut [f64] {
        &mut []
    }

    fn combine(value: f64, _: &[f64], _: &[Self]) -> Self {
        value
    }
}

/// A value and its slopes by P inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual<const P: usize> {
    pub value: f64,
    pub slopes: [f64; P],
}

impl<const P: usize> Dual<P> {
    /// Input number `which`.
    pub fn input(value: f64, which: usize) -> Self {
        Self { value, slopes: from_fn(|i| if i == which { 1.0 } else { 0.0 }) }
    }
}

impl<const P: usize> Field for Dual<P> {
    #[inline]
    fn one_minus(self) -> Self {
        self.chain(1.0 - self.value, -1.0)
    }

    #[inline]
    fn inverse(self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse)
    }
}

impl<const P: usize> Number for Dual<P> {
    fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; P] }
    }

    fn value(self) -> f64 {
        self.value
    }

    #[inline]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, slopes: self.slopes.map(|s| slope * s) }
    }

    #[inline]
    fn plus(mut self, factor: f64, other: Self) -> Self {
        self.value += factor * other.value;
        for (own, other) in self.slopes.iter_mut().zip(&other.slopes) {
            *own += factor * other;
        }
        self
    }

    fn moved_to(mut self, value: f64) -> Self {
        if let Some(last) = self.slopes.last_mut() {
            *last += self.value - value;
        }
        self.value = value;
        self
    }

    fn slopes(&self) -> &[f64] {
        &self.slopes
    }

    fn slopes_mut(&mut self) -> &mut [f64] {
        &mut self.slopes
    }

    #[inline]
    fn combine(value: f64, weights: &[f64], numbers: &[Self]) -> Self {
        let mut slopes = [0.0; P];
        for (weight, number) in weights.iter().zip(numbers) {
            for (own, slope) in slopes.iter_mut().zip(&number.slopes) {
                *own += weight * slope;
            }
        }
        Self { value, slopes }
    }
}

impl<const P: usize> Add for Dual<P> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.plus(1.0, other)
    }
}

impl<const P: usize> AddAssign for Dual<P> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const P: usize> Sub for Dual<P> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.plus(-1.0, other)
    }
}

impl<const P: usize> Mul for Dual<P> {
    type Output = Self;

    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // The rule for products adds.
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        Self { value: a * b, slopes: from_fn(|i| a * other.slopes[i] + b * self.slopes[i]) }
    }
}

impl<const P: usize> Div for Dual<P> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        Self { value, slopes: from_fn(|i| (self.slopes[i] - value * other.slopes[i]) * inverse) }
    }
}

impl<const P: usize> Neg for Dual<P> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const P: usize> Add<f64> for Dual<P> {
    type Output = Self;

    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const P: usize> Sub<f64> for Dual<P> {
    type Output = Self;

    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const P: usize> Mul<f64> for Dual<P> {
    type Output = Self;

    #[inline]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}
