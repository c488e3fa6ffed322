//! The guard's numbers: entries evaluated exactly and rounded by integer division, and the two arithmetics
//! of the proofs.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{CheckedDiv, One, Signed, ToPrimitive, Zero};

pub type Rational = BigRational;

/// Decimal digits kept of a surd.
const SURD_DIGITS: u32 = 120;

pub fn integer(n: i64) -> Rational {
    Rational::from_integer(n.into())
}

/// Value of an entry, every root cut at `SURD_DIGITS` digits; `None` where it is no number.
pub fn evaluate(entry: &str) -> Option<Rational> {
    let mut rest = Rest(entry);
    rest.sum().filter(|_| rest.0.is_empty())
}

/// What is left to read of an entry.
struct Rest<'a>(&'a str);

impl<'a> Rest<'a> {
    fn take(&mut self, word: &str) -> bool {
        let rest = self.0.strip_prefix(word);
        self.0 = rest.unwrap_or(self.0);
        rest.is_some()
    }

    fn sum(&mut self) -> Option<Rational> {
        let mut value = self.product()?;
        loop {
            if self.take("+") {
                value += self.product()?;
            } else if self.take("-") {
                value -= self.product()?;
            } else {
                return Some(value);
            }
        }
    }

    fn product(&mut self) -> Option<Rational> {
        let mut value = self.signed()?;
        loop {
            if self.take("*") {
                value *= self.signed()?;
            } else if self.take("/") {
                value = value.checked_div(&self.signed()?)?;
            } else {
                return Some(value);
            }
        }
    }

    fn signed(&mut self) -> Option<Rational> {
        if self.take("-") {
            Some(-self.signed()?)
        } else if self.take("sqrt(") {
            root(self.closed()?, 2)
        } else if self.take("cbrt(") {
            root(self.closed()?, 3)
        } else if self.take("(") {
            self.closed()
        } else {
            self.decimal()
        }
    }

    fn closed(&mut self) -> Option<Rational> {
        let value = self.sum()?;
        self.take(")").then_some(value)
    }

    fn digits(&mut self) -> &'a str {
        let len = self.0.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.0.len());
        let (digits, rest) = self.0.split_at(len);
        self.0 = rest;
        digits
    }

    fn decimal(&mut self) -> Option<Rational> {
        let whole = self.digits();
        let part = if self.take(".") { self.digits() } else { "" };
        let mut power = -(part.len() as i32);
        if self.take("e") {
            let sign = if self.take("-") { -1 } else { 1 };
            power += sign * self.digits().parse::<i32>().ok()?;
        }
        let digits: BigInt = format!("{whole}{part}").parse().ok()?;
        Some(Rational::from_integer(digits) * integer(10).pow(power))
    }
}

/// The n-th root of p/q is that of p q^(n-1), over q.
fn root(x: Rational, n: u32) -> Option<Rational> {
    let (p, q) = (x.numer(), x.denom());
    if n == 2 && p.is_negative() {
        return None;
    }
    let scale = BigInt::from(10).pow(SURD_DIGITS);
    let whole = (p * q.pow(n - 1) * scale.pow(n)).nth_root(n);
    Some(Rational::new(whole, q * scale))
}

/// `x` rounded to `bits` binary digits, ties to even: 53 for f64, 24 for f32. Exact as f64.
fn rounded(x: &Rational, bits: i64) -> f64 {
    if x.is_zero() {
        return 0.0;
    }
    let (mut p, mut q) = (x.numer().abs(), x.denom().clone());
    // The quotient has `bits` or `bits + 1` digits after this shift; one more shift fixes the latter.
    let mut exponent = p.bits() as i64 - q.bits() as i64 - bits;
    if exponent > 0 {
        q <<= exponent as usize;
    } else {
        p <<= -exponent as usize;
    }
    if &p / &q >= BigInt::one() << bits as usize {
        q <<= 1;
        exponent += 1;
    }
    let mut digits = &p / &q;
    let twice = (&p - &digits * &q) * 2;
    if twice > q || (twice == q && digits.bit(0)) {
        digits += 1;
    }
    let size = digits.to_f64().unwrap() * 2f64.powi(exponent as i32);
    if x.is_negative() { -size } else { size }
}

/// The nearest f64 and f32. A surd is known to 1e-100, which must settle them.
pub fn nearest(x: &Rational, surds: bool) -> (f64, f32) {
    let round = |x: &Rational| (rounded(x, 53), rounded(x, 24) as f32);
    if !surds {
        return round(x);
    }
    let gap = integer(10).pow(-100);
    if x.abs() < gap {
        return (0.0, 0.0);
    }
    let (below, above) = (round(&(x - &gap)), round(&(x + &gap)));
    assert_eq!(below, above, "{SURD_DIGITS} digits do not settle the rounding of an entry");
    below
}

/// What a proof needs of its numbers.
pub trait Number: Clone {
    fn of(x: &Rational) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn vanishes(&self) -> bool;
    fn size(&self) -> f64;

    fn minus(&self, x: &Rational) -> Self {
        self.plus(&Self::of(&-x))
    }
}

impl Number for Rational {
    fn of(x: &Rational) -> Self {
        x.clone()
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn vanishes(&self) -> bool {
        self.is_zero()
    }
    fn size(&self) -> f64 {
        self.abs().to_f64().unwrap()
    }
}

/// An integer over 2^400: 120 decimal digits after the point.
#[derive(Clone)]
pub struct Fixed(BigInt);

const BITS: usize = 400;

impl Number for Fixed {
    fn of(x: &Rational) -> Self {
        Self((x.numer() << BITS) / x.denom())
    }
    fn plus(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }
    fn times(&self, other: &Self) -> Self {
        Self((&self.0 * &other.0) >> BITS)
    }
    fn vanishes(&self) -> bool {
        self.0.is_zero()
    }
    fn size(&self) -> f64 {
        Rational::new(self.0.abs(), BigInt::one() << BITS).to_f64().unwrap()
    }
}
