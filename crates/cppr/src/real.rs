//! What the mechanics compute with: one number, or several side by side (`Pack`, one pose in each lane).
// Operations that are not inlined take their lanes through memory.
#![allow(clippy::inline_always)]

use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Scalar};
use num_traits::{One, Zero};
use std::array::from_fn;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use wide::f64x8;

/// A real number in every lane. Arithmetic never mixes lanes.
pub(crate) trait Real:
    Scalar
    + Copy
    + Default
    + Zero
    + One
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// How many numbers stand side by side.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// One number for each lane.
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self;
    /// The number in one lane.
    fn lane(self, lane: usize) -> f64;

    /// A function of each lane.
    #[inline(always)]
    fn map(self, function: impl Fn(f64) -> f64) -> Self {
        Self::from_lanes(|l| function(self.lane(l)))
    }

    /// One bit for each lane in which the condition holds.
    #[inline(always)]
    fn mask(self, condition: impl Fn(f64) -> bool) -> u64 {
        (0..Self::LANES).fold(0, |mask, l| mask | u64::from(condition(self.lane(l))) << l)
    }

    /// One bit for each lane in which the condition does not hold, as none does for NaN.
    #[inline(always)]
    fn unless(self, condition: impl Fn(f64) -> bool) -> u64 {
        every::<Self>() & !self.mask(condition)
    }

    /// This number in the lanes of a mask, the other one in the rest.
    #[inline(always)]
    fn in_lanes(self, lanes: u64, other: Self) -> Self {
        Self::from_lanes(|l| if lanes >> l & 1 == 1 { self.lane(l) } else { other.lane(l) })
    }

    /// Zero in every lane: what it is multiplied by need not be computed.
    #[inline(always)]
    fn vanishes(self) -> bool {
        (0..Self::LANES).all(|l| self.lane(l) == 0.0)
    }

    /// self + a b, rounded once where the processor that is compiled for can.
    #[inline(always)]
    fn plus(self, a: Self, b: Self) -> Self {
        Self::from_lanes(|l| fused(a.lane(l), b.lane(l), self.lane(l)))
    }

    /// Sine and cosine.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        (self.map(f64::sin), self.map(f64::cos))
    }
}

#[inline(always)]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    // Elsewhere it would be a call into a library.
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}

/// How many numbers stand side by side in a `Pack`.
pub(crate) const MOST_LANES: usize = Pack::LANES;

/// All lanes of a mask.
pub(crate) fn every<S: Real>() -> u64 {
    (1 << S::LANES) - 1
}

/// One of something for each lane.
#[derive(Debug)]
pub(crate) struct Each<'a, T: ?Sized>(pub [&'a T; MOST_LANES]);

impl<T: ?Sized> Clone for Each<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for Each<'_, T> {}

impl<'a, T: ?Sized> Each<'a, T> {
    /// The same in every lane.
    pub fn same(one: &'a T) -> Self {
        Self([one; MOST_LANES])
    }

    /// What stands for all lanes where only kinds matter.
    pub fn first(&self) -> &'a T {
        self.0[0]
    }
}

impl Real for f64 {
    const LANES: usize = 1;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        value(0)
    }

    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
}

/// Eight numbers side by side, in the vector registers of the processor that is compiled for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pack(f64x8);

impl Real for Pack {
    const LANES: usize = 8;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(f64x8::splat(value))
    }

    #[inline(always)]
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self {
        Self(f64x8::new(from_fn(value)))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0.as_array()[lane]
    }

    #[inline(always)]
    fn vanishes(self) -> bool {
        self.0.simd_eq(f64x8::ZERO).all()
    }

    #[inline(always)]
    fn plus(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_add(b.0, self.0))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.0.sin_cos();
        (Self(sin), Self(cos))
    }
}

impl Zero for Pack {
    #[inline(always)]
    fn zero() -> Self {
        Self(f64x8::ZERO)
    }

    #[inline(always)]
    fn is_zero(&self) -> bool {
        self.vanishes()
    }
}

impl One for Pack {
    #[inline(always)]
    fn one() -> Self {
        Self(f64x8::ONE)
    }
}

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! lanewise {
    ($($operator:ident $function:ident $assign:ident $in_place:ident $sign:tt),*) => {$(
        impl $operator for Pack {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0 $sign other.0)
            }
        }

        impl $operator<f64> for Pack {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0 $sign f64x8::splat(other))
            }
        }

        impl $assign for Pack {
            #[inline(always)]
            fn $in_place(&mut self, other: Self) {
                *self = *self $sign other;
            }
        }
    )*};
}

lanewise!(
    Add add AddAssign add_assign +,
    Sub sub SubAssign sub_assign -,
    Mul mul MulAssign mul_assign *,
    Div div DivAssign div_assign /
);
