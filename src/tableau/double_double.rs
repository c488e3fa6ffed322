//! Double-double arithmetic: an unevaluated sum of two `f64`, about 32 decimal digits.
//!
//! Coefficients are read and proven in it, by the compiler and at run time alike, and rounded once
//! to the scalar of a run. It is a scalar of its own too. Sums and products follow Dekker (1971) and
//! Joldes, Muller, Popescu (2017), ACM TOMS 44, algorithms 6, 12 and 17.

/// `hi + lo` with `hi` the sum rounded to the nearest `f64`.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct DoubleDouble {
    pub(super) hi: f64,
    pub(super) lo: f64,
}

const fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let c = s - a;
    (s, (a - (s - c)) + (b - c))
}

const fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

impl DoubleDouble {
    pub const ZERO: Self = Self::of(0.0);
    pub const ONE: Self = Self::of(1.0);
    /// Relative rounding error of one operation, about 2^-104.
    pub const EPSILON: f64 = 4.93e-32;

    /// The `f64` itself.
    pub const fn of(x: f64) -> Self {
        Self { hi: x, lo: 0.0 }
    }

    /// The sum of two `f64`, whatever their sizes.
    pub const fn sum(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Self { hi, lo }
    }

    pub const fn of_integer(n: i64) -> Self {
        // Halves of 32 bits are exact, so is their double-double sum.
        let high = (n >> 32) as f64 * 4294967296.0;
        Self::sum(high, (n & 0xffff_ffff) as f64)
    }

    pub const fn hi(self) -> f64 {
        self.hi
    }

    pub const fn lo(self) -> f64 {
        self.lo
    }

    /// The nearest `f32`, rounded once: a tie of `hi` is broken by `lo`.
    pub const fn to_f32(self) -> f32 {
        let near = self.hi as f32;
        let rest = self.hi - near as f64;
        if self.lo == 0.0 || rest == 0.0 || !near.is_finite() {
            return near;
        }
        let next = if rest > 0.0 { near.next_up() } else { near.next_down() };
        let half = (next as f64 - near as f64) / 2.0;
        // `hi` sits on the tie and was sent to even, yet the value lies beyond it.
        if rest == half && (self.lo > 0.0) == (rest > 0.0) { next } else { near }
    }

    pub const fn is_finite(self) -> bool {
        self.hi.is_finite()
    }

    pub const fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    pub const fn abs(self) -> Self {
        if self.hi < 0.0 { self.neg() } else { self }
    }

    pub const fn plus(self, o: Self) -> Self {
        // Written out: the compiler's interpreter pays for every call.
        let s = self.hi + o.hi;
        let c = s - self.hi;
        let e = (self.hi - (s - c)) + (o.hi - c);
        let t = self.lo + o.lo;
        let c = t - self.lo;
        let f = (self.lo - (t - c)) + (o.lo - c);
        let e = e + t;
        let hi = s + e;
        let e = (e - (hi - s)) + f;
        let sum = hi + e;
        Self { hi: sum, lo: e - (sum - hi) }
    }

    pub const fn minus(self, o: Self) -> Self {
        self.plus(o.neg())
    }

    pub const fn times(self, o: Self) -> Self {
        let p = self.hi * o.hi;
        let e = self.hi.mul_add(o.hi, -p) + self.hi.mul_add(o.lo, self.lo * o.hi);
        let hi = p + e;
        Self { hi, lo: e - (hi - p) }
    }

    pub const fn over(self, o: Self) -> Self {
        let q = self.hi / o.hi;
        let r = self.minus(o.times(Self::of(q)));
        let q2 = r.hi / o.hi;
        let r = r.minus(o.times(Self::of(q2)));
        let (hi, lo) = fast_two_sum(q, q2);
        Self { hi, lo }.plus(Self::of(r.hi / o.hi))
    }

    /// Square root; NaN of a negative number.
    pub const fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        if self.hi < 0.0 {
            return Self::of(f64::NAN);
        }
        let (mut x, mut i) = (newton_start(self.hi, 2), 0);
        while i < 6 {
            x = 0.5 * (x + self.hi / x);
            i += 1;
        }
        // One more step doubles the 53 bits of x.
        let x = Self::of(x);
        x.plus(self.over(x)).times(Self::of(0.5))
    }

    /// Real cube root, of negative numbers too.
    pub const fn cbrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        if self.hi < 0.0 {
            return self.neg().cbrt().neg();
        }
        let (mut x, mut i) = (newton_start(self.hi, 3), 0);
        while i < 8 {
            x = (2.0 * x + self.hi / (x * x)) / 3.0;
            i += 1;
        }
        let x = Self::of(x);
        x.plus(x).plus(self.over(x.times(x))).over(Self::of(3.0))
    }

    pub const fn powi(self, n: u32) -> Self {
        let (mut x, mut i) = (Self::ONE, 0);
        while i < n {
            x = x.times(self);
            i += 1;
        }
        x
    }

    pub const fn less(self, o: Self) -> bool {
        self.hi < o.hi || (self.hi == o.hi && self.lo < o.lo)
    }
}

/// A first guess of the n-th root within a factor of two: the exponent divided by n.
const fn newton_start(x: f64, n: i64) -> f64 {
    let exponent = ((x.abs().to_bits() >> 52) as i64 - 1023) / n;
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, o: &Self) -> Option<std::cmp::Ordering> {
        match self.hi.partial_cmp(&o.hi) {
            Some(std::cmp::Ordering::Equal) => self.lo.partial_cmp(&o.lo),
            other => other,
        }
    }
}

macro_rules! operator {
    ($($op:ident $method:ident $assign:ident $method_assign:ident $by:ident;)*) => { $(
        impl std::ops::$op for DoubleDouble {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                self.$by(o)
            }
        }
        impl std::ops::$assign for DoubleDouble {
            #[inline(always)]
            fn $method_assign(&mut self, o: Self) {
                *self = self.$by(o)
            }
        }
    )* };
}
operator! {
    Add add AddAssign add_assign plus;
    Sub sub SubAssign sub_assign minus;
    Mul mul MulAssign mul_assign times;
    Div div DivAssign div_assign over;
}

impl std::ops::Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        DoubleDouble::neg(self)
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self::of(x)
    }
}

#[cfg(test)]
mod tests {
    use super::DoubleDouble as D;

    #[test]
    fn a_third_has_32_digits() {
        let third = D::ONE / D::of(3.0);
        assert!((third * D::of(3.0) - D::ONE).abs().hi() < 1e-31);
        assert_eq!(third.hi(), 1.0 / 3.0);
        // 1/3 - f64(1/3) = f64(1/3) * 2^-54 exactly (the bits repeat), so lo is its nearest f64.
        assert_eq!(third.lo(), 1.0 / 3.0 * 2f64.powi(-54));
    }

    #[test]
    fn roots_square_and_cube_back() {
        for x in [2.0, 6.0, 21.0, 1e-9, 3e20, 0.7] {
            let x = D::of(x);
            assert!(((x.sqrt() * x.sqrt() - x) / x).abs().hi() < 1e-30);
            let c = x.cbrt();
            assert!(((c * c * c - x) / x).abs().hi() < 1e-30);
        }
        assert_eq!(D::of(-8.0).cbrt(), D::of(-2.0));
        assert!(D::of(-1.0).sqrt().hi().is_nan());
    }

    #[test]
    fn integers_of_63_bits_are_exact() {
        for n in [i64::MAX, i64::MIN, 1 << 53, (1 << 53) + 1, -7] {
            let d = D::of_integer(n);
            assert_eq!(d.hi() as i128 + d.lo() as i128, n as i128);
        }
    }

    #[test]
    fn f32_is_rounded_once() {
        // 1 + 2^-24 is a tie in f32 and goes to even, down to 1; a little more must go up.
        let tie = 1.0 + 2f64.powi(-24);
        assert_eq!(D::of(tie).to_f32(), 1.0);
        assert_eq!(D::sum(tie, 1e-20).to_f32(), 1.0f32.next_up());
        assert_eq!(D::sum(tie, -1e-20).to_f32(), 1.0);
    }
}
