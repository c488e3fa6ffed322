//! One entry of a grid: `-2187/6784`, `1.5e-3`, `1/4-sqrt(3)/6`, evaluated in double-double arithmetic.
//!
//! The compiler interprets this code and needs about half a microsecond for a statement. Hence slice patterns
//! instead of indices, eight digits at a time, and short cuts for short numbers.

use super::double_double::DoubleDouble as D;

/// Deepest nesting of parentheses; the compiler allows a `const fn` 128 frames in all.
const DEEPEST: usize = 16;
/// From here on a literal's digits count no more, not even in double-double.
const FULL: u128 = 10u128.pow(37);
/// Powers of ten, exact in double-double.
const TENS: [D; 39] = {
    let (mut tens, mut i) = ([D::ONE; 39], 0);
    while i < 39 {
        tens[i] = exact(10u128.pow(i as u32));
        i += 1;
    }
    tens
};

/// Why an entry is not a number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Flaw {
    Syntax,
    DividesByZero,
    NegativeRoot,
    TooLarge,
    TooDeep,
}

impl Flaw {
    /// What to say after the entry itself.
    pub const fn text(self) -> &'static str {
        match self {
            Flaw::Syntax => "is not a number",
            Flaw::DividesByZero => "divides by zero",
            Flaw::NegativeRoot => "takes the square root of a negative number",
            Flaw::TooLarge => "is too large",
            Flaw::TooDeep => "has parentheses more than 16 deep",
        }
    }
}

/// The value of the expression at the beginning of `text`, and what follows it.
pub(super) const fn number(text: &[u8]) -> Result<(D, &[u8]), Flaw> {
    // Most entries are 0 or 1.
    if let [digit @ b'0'..=b'9', rest @ ..] = text
        && matches!(rest, [b' ' | b'\n', ..])
    {
        return Ok((D::of((*digit - b'0') as f64), rest));
    }
    let mut entry = Entry { rest: text };
    match entry.expression(DEEPEST) {
        Ok(x) if x.is_finite() => Ok((x, entry.rest)),
        Ok(_) => Err(Flaw::TooLarge),
        Err(flaw) => Err(flaw),
    }
}

struct Entry<'b> {
    rest: &'b [u8],
}

impl<'b> Entry<'b> {
    /// `factor * factor / factor + ..`: a running sum and a running product, so that one level of
    /// parentheses costs three frames.
    const fn expression(&mut self, deep: usize) -> Result<D, Flaw> {
        let (mut sum, mut operator, mut product) = (D::ZERO, b'+', D::ZERO);
        loop {
            let factor = match self.factor(deep) {
                Ok(x) => x,
                Err(flaw) => return Err(flaw),
            };
            match operator {
                b'*' => product = product.times(factor),
                b'/' if factor.hi() == 0.0 => return Err(Flaw::DividesByZero),
                b'/' => product = quotient(product, factor),
                b'+' => (sum, product) = (total(sum, product), factor),
                _ => (sum, product) = (total(sum, product), factor.neg()),
            }
            match self.rest {
                [next @ (b'+' | b'-' | b'*' | b'/'), rest @ ..] => (operator, self.rest) = (*next, rest),
                _ => return Ok(total(sum, product)),
            }
        }
    }

    const fn factor(&mut self, deep: usize) -> Result<D, Flaw> {
        let (minus, rest) = match self.rest {
            [b'-', rest @ ..] => (true, rest),
            rest => (false, rest),
        };
        let x = match rest {
            [b'0'..=b'9', ..] => self.literal(rest),
            [b'(', rest @ ..] => self.group(rest, deep),
            [b's', b'q', b'r', b't', b'(', rest @ ..] => match self.group(rest, deep) {
                Ok(x) if x.hi() < 0.0 => Err(Flaw::NegativeRoot),
                Ok(x) => Ok(x.sqrt()),
                flaw => flaw,
            },
            [b'c', b'b', b'r', b't', b'(', rest @ ..] => match self.group(rest, deep) {
                Ok(x) => Ok(x.cbrt()),
                flaw => flaw,
            },
            _ => Err(Flaw::Syntax),
        };
        match x {
            Ok(x) if minus => Ok(x.neg()),
            x => x,
        }
    }

    /// What follows an opening parenthesis, and the closing one.
    const fn group(&mut self, rest: &'b [u8], deep: usize) -> Result<D, Flaw> {
        if deep == 0 {
            return Err(Flaw::TooDeep);
        }
        self.rest = rest;
        match (self.expression(deep - 1), self.rest) {
            (Ok(x), [b')', rest @ ..]) => {
                self.rest = rest;
                Ok(x)
            }
            (Ok(_), _) => Err(Flaw::Syntax),
            (flaw, _) => flaw,
        }
    }

    /// Digits, a point and more digits, an exponent.
    const fn literal(&mut self, text: &'b [u8]) -> Result<D, Flaw> {
        let (mut n, dropped, mut rest) = digits(0, text);
        let mut exponent = dropped as i64;
        if let [b'.', fraction @ ..] = rest {
            let dropped;
            (n, dropped, rest) = digits(n, fraction);
            if rest.len() == fraction.len() {
                return Err(Flaw::Syntax);
            }
            exponent -= (fraction.len() - rest.len() - dropped) as i64;
        }
        if let [b'e' | b'E', signed @ ..] = rest {
            let (sign, unsigned) = match signed {
                [b'-', unsigned @ ..] => (-1, unsigned),
                [b'+', unsigned @ ..] => (1, unsigned),
                unsigned => (1, unsigned),
            };
            let power;
            (power, _, rest) = digits(0, unsigned);
            if rest.len() == unsigned.len() {
                return Err(Flaw::Syntax);
            }
            // Far beyond the range of an f64 it does not matter how far.
            exponent += sign * if power < 1_000_000_000 { power as i64 } else { 1_000_000_000 };
        }
        self.rest = rest;
        Ok(scaled(exact(n), exponent))
    }
}

/// Appends the digits at the beginning of `text` to `n`: the number, how many digits it had no room for,
/// what follows them.
const fn digits(mut n: u128, mut text: &[u8]) -> (u128, usize, &[u8]) {
    const ROOM: u128 = FULL / 10_000_000;
    let (mut dropped, mut long) = (0, true);
    loop {
        if long && (n < ROOM || n >= FULL) {
            if let [a, b, c, d, e, f, g, h @ b'0'..=b'9', ref rest @ ..] = *text {
                let word = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
                if are_digits(word) {
                    if n < ROOM {
                        n = 100_000_000 * n + eight(word) as u128;
                    } else {
                        dropped += 8;
                    }
                    text = rest;
                    continue;
                }
            }
            long = false;
        }
        let [digit @ b'0'..=b'9', rest @ ..] = text else { return (n, dropped, text) };
        if n < FULL {
            n = 10 * n + (*digit - b'0') as u128;
        } else {
            dropped += 1;
        }
        text = rest;
    }
}

const ZEROS: u64 = u64::from_le_bytes([b'0'; 8]);

/// All eight bytes are from 0x30 to 0x39.
const fn are_digits(word: u64) -> bool {
    const UPPER: u64 = 0xf0f0_f0f0_f0f0_f0f0;
    word & UPPER == ZEROS && (word + 0x0606_0606_0606_0606) & UPPER == ZEROS
}

/// The number written in eight digits, the first one in the lowest byte: neighbours are joined thrice.
const fn eight(word: u64) -> u64 {
    let word = word - ZEROS;
    let word = (10 * word + (word >> 8)) & 0x00ff_00ff_00ff_00ff;
    let word = (100 * word + (word >> 16)) & 0x0000_ffff_0000_ffff;
    (10_000 * word + (word >> 32)) & 0xffff_ffff
}

/// An integer below 2^127: the nearest `f64` and the nearest to what is left.
const fn exact(n: u128) -> D {
    let hi = n as f64;
    if n < 1 << 53 {
        return D::of(hi);
    }
    let near = hi as u128;
    D::sum(hi, if near <= n { (n - near) as f64 } else { -((near - n) as f64) })
}

/// `x 10^exponent`, rounded once for every 38 powers.
const fn scaled(mut x: D, mut exponent: i64) -> D {
    while exponent != 0 && x.hi() != 0.0 && x.hi().is_finite() {
        if exponent > 0 {
            let power = if exponent < 38 { exponent } else { 38 };
            x = x.times(TENS[power as usize]);
            exponent -= power;
        } else {
            let power = if exponent > -38 { -exponent } else { 38 };
            x = quotient(x, TENS[power as usize]);
            exponent += power;
        }
    }
    x
}

/// `a / b`; of two f64 with one correction, since their remainder is exact.
const fn quotient(a: D, b: D) -> D {
    if a.lo() != 0.0 || b.lo() != 0.0 {
        return a.over(b);
    }
    let q = a.hi() / b.hi();
    D::sum(q, (-q).mul_add(b.hi(), a.hi()) / b.hi())
}

/// `a + b`; most entries have one term.
const fn total(a: D, b: D) -> D {
    if a.hi() == 0.0 { b } else { a.plus(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<D, Flaw> {
        match number(text.as_bytes())? {
            (x, []) => Ok(x),
            _ => Err(Flaw::Syntax),
        }
    }

    #[test]
    fn decimals_are_the_nearest_f64() {
        for text in [
            "0",
            "7",
            "0.1",
            "0.0526001519587677318785587544488",
            "0.526001519587677318785587544488e-01",
            "1.5e-3",
            "1E22",
            "9007199254740993",
            "179769313486231570000000000000000000000.5e+269",
            "0.1000000000000000055511151231257827021181583404541015625",
            "123456789012345678901234567890123456789012345678901234567890",
            "0.00000000000000000000000000000000000000000000000000012345678901234567890123",
        ] {
            assert_eq!(value(text).unwrap().hi(), text.parse::<f64>().unwrap(), "{text}");
        }
    }

    #[test]
    fn decimals_have_32_digits() {
        let third = "0.33333333333333333333333333333333333333333";
        assert!((value(third).unwrap() - D::ONE / D::of(3.0)).abs().hi() < 1e-32);
        assert_eq!(value("0.1").unwrap(), D::ONE / D::of(10.0));
    }

    #[test]
    fn long_rationals_are_correctly_rounded() {
        // (10^114 - 1) / 7 over 10^109 + 10, which is 1e5 / 7 to 108 digits.
        let text = format!("{}/1{}10", "142857".repeat(19), "0".repeat(107));
        assert_eq!(value(&text).unwrap().hi(), 1e5 / 7.0);
    }

    #[test]
    fn usual_precedence() {
        for (text, x) in [
            ("1+2*3", 7.0),
            ("1-2*-3", 7.0),
            ("8/2/2", 2.0),
            ("8/(2/2)", 8.0),
            ("-(1-3)*2", 4.0),
            ("-sqrt(4)+cbrt(-27)", -5.0),
            ("1-1-1", -1.0),
            ("((((1))))", 1.0),
            ("sqrt(0)", 0.0),
        ] {
            assert_eq!(value(text), Ok(D::of(x)), "{text}");
        }
        assert_eq!(value("1/4-sqrt(3)/6"), Ok(D::of(0.25) - D::of(3.0).sqrt() / D::of(6.0)));
    }

    #[test]
    fn flaws() {
        for (text, flaw) in [
            ("", Flaw::Syntax),
            ("-", Flaw::Syntax),
            ("--1", Flaw::Syntax),
            ("+1", Flaw::Syntax),
            ("1/2x", Flaw::Syntax),
            ("1..2", Flaw::Syntax),
            ("1.", Flaw::Syntax),
            (".5", Flaw::Syntax),
            ("1e", Flaw::Syntax),
            ("1e5.5", Flaw::Syntax),
            ("(1", Flaw::Syntax),
            ("1)", Flaw::Syntax),
            ("sqrt4", Flaw::Syntax),
            ("sqrtcbrt(4)", Flaw::Syntax),
            ("nan", Flaw::Syntax),
            ("1/", Flaw::Syntax),
            ("½", Flaw::Syntax),
            ("3/0", Flaw::DividesByZero),
            ("1/(1-1)", Flaw::DividesByZero),
            ("sqrt(1-2)", Flaw::NegativeRoot),
            ("1e400", Flaw::TooLarge),
            ("1e99999999999999999999999999999999999999999999", Flaw::TooLarge),
            ("1e300*1e300", Flaw::TooLarge),
        ] {
            assert_eq!(value(text), Err(flaw), "{text}");
        }
        let nest = |n| format!("{}1{}", "(".repeat(n), ")".repeat(n));
        assert_eq!(value(&nest(16)), Ok(D::ONE));
        assert_eq!(value(&nest(17)), Err(Flaw::TooDeep));
        assert_eq!(value("1e-99999999999999999999999999999999999999999999"), Ok(D::ZERO));
    }
}
