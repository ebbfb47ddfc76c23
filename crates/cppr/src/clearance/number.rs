//! Numbers with their first and second derivatives by N inputs.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// A value, its slopes and its second derivatives by N inputs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Second<const N: usize> {
    pub value: f64,
    pub slopes: [f64; N],
    pub bends: [[f64; N]; N],
}

impl<const N: usize> Second<N> {
    pub fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; N], bends: [[0.0; N]; N] }
    }

    /// Input number `which`.
    pub fn input(value: f64, which: usize) -> Self {
        Self { slopes: from_fn(|i| if i == which { 1.0 } else { 0.0 }), ..Self::constant(value) }
    }

    /// A function of the number: its value and derivatives there.
    pub fn chain(mut self, [value, slope, bend]: [f64; 3]) -> Self {
        self.value = value;
        for (i, row) in self.bends.iter_mut().enumerate() {
            let across = bend * self.slopes[i];
            for (own, other) in row.iter_mut().zip(&self.slopes) {
                *own = slope * *own + across * other;
            }
        }
        for own in &mut self.slopes {
            *own *= slope;
        }
        self
    }

    /// Adds a factor times another number.
    fn plus(mut self, factor: f64, other: &Self) -> Self {
        self.value += factor * other.value;
        for (own, other) in self.slopes.iter_mut().zip(&other.slopes) {
            *own += factor * other;
        }
        for (own, other) in self.bends.as_flattened_mut().iter_mut().zip(other.bends.as_flattened()) {
            *own += factor * other;
        }
        self
    }

    pub fn inverse(self) -> Self {
        let v = 1.0 / self.value;
        self.chain([v, -v * v, 2.0 * v * v * v])
    }

    pub fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain([s, c, -s]), self.chain([c, -s, -c]))
    }
}

impl<const N: usize> Add for Second<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.plus(1.0, &other)
    }
}

impl<const N: usize> Sub for Second<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.plus(-1.0, &other)
    }
}

impl<const N: usize> Mul for Second<N> {
    type Output = Self;

    #[allow(clippy::suspicious_arithmetic_impl)] // The rule for products adds.
    fn mul(mut self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        for (i, (row, rows)) in self.bends.iter_mut().zip(&other.bends).enumerate() {
            let (s, t) = (self.slopes[i], other.slopes[i]);
            for (j, (own, bend)) in row.iter_mut().zip(rows).enumerate() {
                *own = b * *own + a * bend + s * other.slopes[j] + t * self.slopes[j];
            }
        }
        for (own, slope) in self.slopes.iter_mut().zip(&other.slopes) {
            *own = b * *own + a * slope;
        }
        self.value = a * b;
        self
    }
}

impl<const N: usize> Add<f64> for Second<N> {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Second<N> {
    type Output = Self;

    fn mul(mut self, other: f64) -> Self {
        self.value *= other;
        for own in self.slopes.iter_mut().chain(self.bends.as_flattened_mut()) {
            *own *= other;
        }
        self
    }
}
