//! Numbers with their first and second derivatives by N inputs.

use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

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
    pub fn chain(self, [value, slope, bend]: [f64; 3]) -> Self {
        let own = self.slopes;
        Self {
            value,
            slopes: own.map(|s| slope * s),
            bends: from_fn(|i| {
                let across = bend * own[i];
                from_fn(|j| slope * self.bends[i][j] + across * own[j])
            }),
        }
    }

    pub fn inverse(self) -> Self {
        let v = 1.0 / self.value;
        self.chain([v, -v * v, 2.0 * v * v * v])
    }

    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain([root, 0.5 / root, -0.25 / (root * self.value)])
    }

    pub fn tan(self) -> Self {
        let t = self.value.tan();
        let slope = 1.0 + t * t;
        self.chain([t, slope, 2.0 * t * slope])
    }

    pub fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain([s, c, -s]), self.chain([c, -s, -c]))
    }
}

impl<const N: usize> Add for Second<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slopes: from_fn(|i| self.slopes[i] + other.slopes[i]),
            bends: from_fn(|i| from_fn(|j| self.bends[i][j] + other.bends[i][j])),
        }
    }
}

impl<const N: usize> Neg for Second<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Sub for Second<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            slopes: from_fn(|i| self.slopes[i] - other.slopes[i]),
            bends: from_fn(|i| from_fn(|j| self.bends[i][j] - other.bends[i][j])),
        }
    }
}

impl<const N: usize> Mul for Second<N> {
    type Output = Self;

    #[allow(clippy::suspicious_arithmetic_impl)] // The rule for products adds.
    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self, &other);
        Self {
            value: a.value * b.value,
            slopes: from_fn(|i| a.value * b.slopes[i] + b.value * a.slopes[i]),
            bends: from_fn(|i| {
                from_fn(|j| {
                    a.value * b.bends[i][j]
                        + b.value * a.bends[i][j]
                        + a.slopes[i] * b.slopes[j]
                        + b.slopes[i] * a.slopes[j]
                })
            }),
        }
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

    fn mul(self, other: f64) -> Self {
        Self {
            value: self.value * other,
            slopes: self.slopes.map(|s| s * other),
            bends: self.bends.map(|row| row.map(|b| b * other)),
        }
    }
}
