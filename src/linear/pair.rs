//! a + b i over any scalar: the matrices of coupled stages are complex though the equation is not.

use crate::step::scalar::{Real, Scalar};
use num_traits::{One, Zero};
use std::ops::{Add, Div, Mul, Neg, Sub};

#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pair<T> {
    pub re: T,
    pub im: T,
}

impl<T: Scalar> Add for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { re: self.re + o.re, im: self.im + o.im }
    }
}

impl<T: Scalar> Sub for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { re: self.re - o.re, im: self.im - o.im }
    }
}

impl<T: Scalar> Neg for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl<T: Scalar> Mul for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}

impl<T: Scalar> Div for Pair<T> {
    type Output = Self;
    /// Scaled by the larger part, so that no square leaves the range of numbers (Smith 1962, CACM 5, 435).
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        if o.re.modulus() >= o.im.modulus() {
            let ratio = o.im / o.re;
            let per = T::one() / (o.re + o.im * ratio);
            Self { re: (self.re + self.im * ratio) * per, im: (self.im - self.re * ratio) * per }
        } else {
            let ratio = o.re / o.im;
            let per = T::one() / (o.re * ratio + o.im);
            Self { re: (self.re * ratio + self.im) * per, im: (self.im * ratio - self.re) * per }
        }
    }
}

impl<T: Scalar> Zero for Pair<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self { re: T::zero(), im: T::zero() }
    }
    fn is_zero(&self) -> bool {
        self.re.is_zero() && self.im.is_zero()
    }
}

impl<T: Scalar> One for Pair<T> {
    #[inline(always)]
    fn one() -> Self {
        Self { re: T::one(), im: T::zero() }
    }
}

impl<T: Scalar> Scalar for Pair<T> {
    type Real = T::Real;
    const NEG_ZERO: Self = Self { re: T::NEG_ZERO, im: T::NEG_ZERO };
    #[inline(always)]
    fn scale(self, by: T::Real) -> Self {
        Self { re: self.re.scale(by), im: self.im.scale(by) }
    }
    #[inline(always)]
    fn fused(a: T::Real, x: Self, s: Self) -> Self {
        Self { re: T::fused(a, x.re, s.re), im: T::fused(a, x.im, s.im) }
    }
    #[inline(always)]
    fn square(self) -> T::Real {
        self.re.square() + self.im.square()
    }
    /// The larger part: enough to choose a pivot by, and without a root.
    #[inline(always)]
    fn modulus(self) -> T::Real {
        self.re.modulus().maximum(self.im.modulus())
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.re.finite() && self.im.finite()
    }
}
