//! The numbers a system can be made of, and how a term is added to a sum.

use crate::tableau::DoubleDouble;
use num_complex::Complex;
use num_traits::{One, Zero};
use std::fmt::{self, Debug, Display, LowerExp};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A component of a state: `f64`, `f32`, [`DoubleDouble`], or a complex number of the first two.
pub trait Scalar:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + Zero
    + One
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// The type of times, steps and coefficients.
    type Real: Real;
    /// Minus zero, from which sums start: the compiler folds `-0.0 + x` away, but not `0.0 + x`.
    const NEG_ZERO: Self;

    fn scale(self, by: Self::Real) -> Self;
    /// `a x + s` with one rounding where the machine has the instruction.
    fn fused(a: Self::Real, x: Self, s: Self) -> Self;
    /// The square of the absolute value.
    fn square(self) -> Self::Real;
    fn modulus(self) -> Self::Real;
    fn finite(self) -> bool;
}

/// An ordered [`Scalar`]: `f64`, `f32` or [`DoubleDouble`].
pub trait Real: Scalar<Real = Self> + PartialOrd + Display + LowerExp {
    const EPSILON: Self;
    /// What stands for a tolerance of zero: it divides a zero error to zero, and any other to a rejection,
    /// in steps of any size that a unit of time may ask for.
    const TINY: Self;
    /// A coefficient, rounded once from its 32 digits.
    fn of(coefficient: DoubleDouble) -> Self;
    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;
    /// The spacing of numbers around this one.
    fn ulp(self) -> Self {
        self.modulus() * Self::EPSILON
    }
    fn maximum(self, o: Self) -> Self {
        if self > o { self } else { o }
    }
    fn minimum(self, o: Self) -> Self {
        if self < o { self } else { o }
    }
}

/// A number in a message: in powers of ten where it would be a row of zeros.
pub(crate) struct Shown<R>(pub R);

impl<R: Real> fmt::Display for Shown<R> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let x = self.0.to_f64();
        let plain = x == 0.0 || !x.is_finite() || (1e-4..1e16).contains(&x.abs());
        if plain { Display::fmt(&self.0, f) } else { LowerExp::fmt(&self.0, f) }
    }
}

macro_rules! hardware {
    ($t:ident, $of:expr, $tiny:expr) => {
        impl Scalar for $t {
            type Real = $t;
            const NEG_ZERO: $t = -0.0;
            #[inline(always)]
            fn scale(self, by: $t) -> $t {
                by * self
            }
            #[inline(always)]
            fn fused(a: $t, x: $t, s: $t) -> $t {
                a.mul_add(x, s)
            }
            #[inline(always)]
            fn square(self) -> $t {
                self * self
            }
            #[inline(always)]
            fn modulus(self) -> $t {
                self.abs()
            }
            #[inline(always)]
            fn finite(self) -> bool {
                self.is_finite()
            }
        }
        impl Real for $t {
            const EPSILON: $t = $t::EPSILON;
            const TINY: $t = $tiny;
            #[inline(always)]
            fn of(coefficient: DoubleDouble) -> $t {
                $of(coefficient)
            }
            #[inline(always)]
            fn from_f64(x: f64) -> $t {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
        }
        impl Scalar for Complex<$t> {
            type Real = $t;
            const NEG_ZERO: Self = Complex { re: -0.0, im: -0.0 };
            #[inline(always)]
            fn scale(self, by: $t) -> Self {
                Complex { re: by * self.re, im: by * self.im }
            }
            #[inline(always)]
            fn fused(a: $t, x: Self, s: Self) -> Self {
                Complex { re: a.mul_add(x.re, s.re), im: a.mul_add(x.im, s.im) }
            }
            #[inline(always)]
            fn square(self) -> $t {
                self.norm_sqr()
            }
            #[inline(always)]
            fn modulus(self) -> $t {
                self.norm()
            }
            #[inline(always)]
            fn finite(self) -> bool {
                self.re.is_finite() && self.im.is_finite()
            }
        }
    };
}
hardware!(f64, DoubleDouble::hi, 1e-280);
hardware!(f32, DoubleDouble::to_f32, 1e-30);

impl Zero for DoubleDouble {
    fn zero() -> Self {
        Self::ZERO
    }
    fn is_zero(&self) -> bool {
        self.hi() == 0.0
    }
}

impl One for DoubleDouble {
    fn one() -> Self {
        Self::ONE
    }
}

impl Display for DoubleDouble {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        Display::fmt(&self.to_f64(), f)
    }
}

impl LowerExp for DoubleDouble {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        LowerExp::fmt(&self.to_f64(), f)
    }
}

impl Scalar for DoubleDouble {
    type Real = Self;
    const NEG_ZERO: Self = Self::of(-0.0);
    fn scale(self, by: Self) -> Self {
        by * self
    }
    fn fused(a: Self, x: Self, s: Self) -> Self {
        a * x + s
    }
    fn square(self) -> Self {
        self * self
    }
    fn modulus(self) -> Self {
        self.abs()
    }
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for DoubleDouble {
    const EPSILON: Self = Self::of(DoubleDouble::EPSILON);
    const TINY: Self = Self::of(1e-280);
    fn of(coefficient: DoubleDouble) -> Self {
        coefficient
    }
    fn from_f64(x: f64) -> Self {
        Self::of(x)
    }
    fn to_f64(self) -> f64 {
        self.hi()
    }
}

/// How `a x + s` is formed: a type, so that a whole run is compiled for one of the two.
pub trait Arith {
    /// One rounding for a product and a sum.
    const FUSED: bool;
    /// The rows of a known form are spelled out, not read in a loop.
    const UNROLLED: bool;
    fn term<T: Scalar>(a: T::Real, x: T, s: T) -> T;
}

/// A product rounded, then a sum rounded: every machine gives the same bits.
pub struct Plain;
/// The same bits, with rows read in a loop: for processors that cannot run the fused kind, so that not every
/// adaptive method is compiled twice for their sake.
pub struct Rolled;
/// One rounding, on machines that have the instruction. Elsewhere it would call a slow routine.
pub struct Fused;

impl Arith for Plain {
    const FUSED: bool = false;
    const UNROLLED: bool = true;
    #[inline(always)]
    fn term<T: Scalar>(a: T::Real, x: T, s: T) -> T {
        s + x.scale(a)
    }
}

impl Arith for Rolled {
    const FUSED: bool = false;
    const UNROLLED: bool = false;
    #[inline(always)]
    fn term<T: Scalar>(a: T::Real, x: T, s: T) -> T {
        Plain::term(a, x, s)
    }
}

impl Arith for Fused {
    const FUSED: bool = true;
    const UNROLLED: bool = true;
    #[inline(always)]
    fn term<T: Scalar>(a: T::Real, x: T, s: T) -> T {
        T::fused(a, x, s)
    }
}
