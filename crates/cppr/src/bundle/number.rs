//! Numbers that the integration runs on: plain ones, and ones that carry their derivatives along.
//!
//! `Dual<N>` holds a value and its slopes by N − 1 inputs; every operation follows the rules of differentiation, so that an
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

    /// Adds factor · other.
    fn add_scaled(&mut self, factor: f64, other: &Self);

    /// self + factor · other.
    #[inline]
    fn plus(mut self, factor: f64, other: Self) -> Self {
        self.add_scaled(factor, &other);
        self
    }

    /// The number with another value. By how much it differs is added to the last slope, see [`steps`](super::steps).
    fn moved_to(self, value: f64) -> Self;

    /// Slopes by the inputs.
    fn slopes(&self) -> &[f64];

    fn slopes_mut(&mut self) -> &mut [f64];

    /// Adds factor times the slopes of another number to those of this one.
    fn add_slopes(&mut self, factor: f64, other: &Self);

    /// Becomes a factor times a function of numbers, given its value and its slopes by them.
    #[inline]
    fn become_function<'a>(
        &mut self,
        factor: f64,
        value: f64,
        slopes: &[f64],
        numbers: impl IntoIterator<Item = &'a Self>,
    ) where
        Self: 'a,
    {
        *self = Self::constant(factor * value);
        for (slope, number) in slopes.iter().zip(numbers).filter(|(slope, _)| **slope != 0.0) {
            self.add_slopes(factor * slope, number);
        }
    }

    /// A function of numbers, given its value and its slopes by them.
    #[inline]
    fn function<'a>(value: f64, slopes: &[f64], numbers: impl IntoIterator<Item = &'a Self>) -> Self
    where
        Self: 'a,
    {
        let mut own = Self::constant(0.0);
        own.become_function(1.0, value, slopes, numbers);
        own
    }

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

    fn add_scaled(&mut self, factor: f64, other: &Self) {
        *self += factor * other;
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

    fn add_slopes(&mut self, _: f64, _: &Self) {}
}

/// A value and its slopes by N − 1 inputs: all in one row, so that vector instructions take them together.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(crate) struct Dual<const N: usize>([f64; N]);

impl<const N: usize> Dual<N> {
    /// Input number `which`.
    pub fn input(value: f64, which: usize) -> Self {
        Self::new(value, |i| if i == which { 1.0 } else { 0.0 })
    }

    /// From its slopes by every input.
    pub fn new(value: f64, slope: impl Fn(usize) -> f64) -> Self {
        Self(from_fn(|i| i.checked_sub(1).map_or(value, &slope)))
    }

    #[inline]
    fn with_value(mut self, value: f64) -> Self {
        self.0[0] = value;
        self
    }
}

impl<const N: usize> Field for Dual<N> {
    #[inline]
    fn one_minus(self) -> Self {
        self.chain(1.0 - self.value(), -1.0)
    }

    #[inline]
    fn inverse(self) -> Self {
        let inverse = 1.0 / self.value();
        self.chain(inverse, -inverse * inverse)
    }
}

impl<const N: usize> Number for Dual<N> {
    #[inline]
    fn constant(value: f64) -> Self {
        Self([0.0; N]).with_value(value)
    }

    #[inline]
    fn value(self) -> f64 {
        self.0[0]
    }

    #[inline]
    fn chain(self, value: f64, slope: f64) -> Self {
        (self * slope).with_value(value)
    }

    #[inline]
    fn add_scaled(&mut self, factor: f64, other: &Self) {
        for (own, other) in self.0.iter_mut().zip(&other.0) {
            *own += factor * other;
        }
    }

    fn moved_to(mut self, value: f64) -> Self {
        self.0[N - 1] += self.value() - value;
        self.with_value(value)
    }

    fn slopes(&self) -> &[f64] {
        &self.0[1..]
    }

    fn slopes_mut(&mut self) -> &mut [f64] {
        &mut self.0[1..]
    }

    #[inline]
    fn add_slopes(&mut self, factor: f64, other: &Self) {
        let value = self.value();
        self.add_scaled(factor, other);
        self.0[0] = value;
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // The rule for products adds.
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value(), other.value());
        Self(from_fn(|i| a * other.0[i] + b * self.0[i])).with_value(a * b)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value();
        let value = self.value() * inverse;
        Self(from_fn(|i| (self.0[i] - value * other.0[i]) * inverse)).with_value(value)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(self.0.map(|own| -own))
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;

    #[inline]
    fn add(self, other: f64) -> Self {
        self.with_value(self.value() + other)
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;

    #[inline]
    fn sub(self, other: f64) -> Self {
        self.with_value(self.value() - other)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    #[inline]
    fn mul(self, other: f64) -> Self {
        Self(self.0.map(|own| own * other))
    }
}
