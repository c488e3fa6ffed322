//! Zero-stability: as h goes to 0 a method must not amplify what it carries.
//!
//! Only the older y can: a carried f is a slope of the last steps and forgotten after as many, y and v are
//! taken over with weight one. So the matrix V is power-bounded if the polynomial of the rows of y is.

use super::double_double::DoubleDouble as D;
use super::error::{Broken, TableauError, Text};
use super::form::{CARRIED, Form, Meaning};
use super::sums::within;

/// Coefficients in ascending order.
type Polynomial = [D; CARRIED + 1];

/// Roots on the unit circle are recognised to this accuracy, 12 digits short of the arithmetic.
const NEAR: f64 = 1e-20;

/// Demands that no root of the characteristic polynomial lies outside the unit disc, and that those on the
/// unit circle are simple (double where d = 2: y' is carried as a difference of two y).
pub(super) const fn zero_stable(form: &Form, tolerance: f64) -> Result<(), TableauError> {
    let near = if tolerance > NEAR { tolerance } else { NEAR };
    let (rho, n) = characteristic(form);
    if bounded(rho, n, form.d, near) {
        return Ok(());
    }
    // The largest modulus is the least radius that has all roots inside.
    let (mut inner, mut outer) = (1.0, 1.0);
    let mut i = 0;
    while i < n {
        outer += rho[i].abs().hi();
        i += 1;
    }
    let mut i = 0;
    while i < 60 {
        let middle = (inner + outer) / 2.0;
        if bounded(scaled(rho, n, middle), n, 0, NEAR) {
            outer = middle;
        } else {
            inner = middle;
        }
        i += 1;
    }
    let text = Text::new().str("zero-stability: the characteristic polynomial has a ");
    let text = if outer > 1.0 + 1e-6 {
        decimal(text.str("root of modulus "), outer)
    } else if form.d == 1 {
        text.str("double root on the unit circle")
    } else {
        text.str("triple root on the unit circle")
    };
    Err(TableauError::new(Broken::ZeroStability, 0, outer - 1.0, text))
}

/// All roots of a polynomial of degree n lie in the open unit disc.
pub(super) const fn all_inside(p: &[D; CARRIED], n: usize) -> bool {
    let (mut q, mut i) = ([D::ZERO; CARRIED + 1], 0);
    while i <= n {
        q[i] = p[i];
        i += 1;
    }
    bounded(q, n, 0, NEAR)
}

/// zeta^n - sum w_k zeta^(n-1-k), w_k being the weight of y_(n-k) in y_(n+1).
const fn characteristic(form: &Form) -> (Polynomial, usize) {
    let mut n = 0;
    while n < form.r && matches!(form.means[n], Meaning::Y(_)) {
        n += 1;
    }
    let (row, mut rho) = (&form.carry[0], [D::ZERO; CARRIED + 1]);
    rho[n] = D::ONE;
    if let Some(j) = row.base {
        rho[n - 1 - j] = D::of(-1.0);
    }
    let mut i = 0;
    while i < row.len {
        if row.at[i] < n {
            let k = n - 1 - row.at[i];
            rho[k] = rho[k].minus(row.a[i]);
        }
        i += 1;
    }
    (rho, n)
}

/// The polynomial whose roots are those of p over the radius.
const fn scaled(mut p: Polynomial, n: usize, radius: f64) -> Polynomial {
    let (mut power, mut i) = (D::ONE, 0);
    while i <= n {
        p[i] = p[i].times(power);
        power = power.times(D::of(radius));
        i += 1;
    }
    p
}

/// All roots in the unit disc, those on the circle of multiplicity at most `most` (0: none there).
///
/// Schur (1918) lowers the degree by one as long as the product of the roots is less than 1. Where it is 1,
/// all roots lie on the circle or none of the demands holds; then p is its own mirror image, and the roots of
/// its derivative lie inside but for the multiple ones (Miller 1971, J. Inst. Math. Appl. 8, 397).
const fn bounded(mut p: Polynomial, mut n: usize, mut most: usize, near: f64) -> bool {
    while n > 0 {
        let lead = p[n];
        let mut i = 0;
        while i <= n {
            p[i] = p[i].over(lead);
            i += 1;
        }
        let last = p[0];
        let gap = last.abs().minus(D::ONE).hi();
        if gap.is_nan() || gap > near {
            return false;
        }
        let mut next = [D::ZERO; CARRIED + 1];
        let mut i = 0;
        if gap < -near {
            while i < n {
                next[i] = p[i + 1].minus(last.times(p[n - 1 - i]));
                i += 1;
            }
        } else {
            if most == 0 {
                return false;
            }
            while i < n {
                let off = p[i].minus(last.times(p[n - i])).hi();
                if !within(off, near * (1.0 + p[i].hi().abs())) {
                    return false;
                }
                next[i] = p[i + 1].times(D::of_integer(i as i64 + 1));
                i += 1;
            }
            most -= 1;
        }
        p = next;
        n -= 1;
    }
    true
}

/// Appends a number with four decimals, cut.
const fn decimal(text: Text, x: f64) -> Text {
    let (mut text, mut rest) = (text.number(x as usize).str("."), x - (x as usize) as f64);
    let mut i = 0;
    while i < 4 {
        rest *= 10.0;
        text = text.number(rest as usize);
        rest -= (rest as usize) as f64;
        i += 1;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::lower::{lower, tests::file};
    use super::super::{CARRIED, Scheme, Steps, Tableau};
    use super::*;

    /// The verdict on sum alpha_j y_(n+j) = h^d f.
    fn verdict(alpha: &[f64], d: usize) -> Result<(), String> {
        let mut steps = Steps { k: alpha.len() - 1, alpha: [D::ZERO; CARRIED], beta: [D::ZERO; CARRIED] };
        alpha.iter().enumerate().for_each(|(j, a)| steps.alpha[j] = D::of(*a));
        steps.beta[0] = D::ONE;
        let scheme = if d == 1 { Scheme::Multistep(steps) } else { Scheme::Stormer(steps) };
        let form = lower(&Tableau { scheme, ..file("multistep/ab4") }).unwrap();
        zero_stable(&form, 0.0).map_err(|error| error.text.as_str().to_string())
    }

    fn refused(alpha: &[f64], d: usize, why: &str) {
        assert_eq!(
            verdict(alpha, d).unwrap_err(),
            format!("zero-stability: the characteristic polynomial has a {why}")
        );
    }

    #[test]
    fn roots_may_lie_on_the_circle_once() {
        assert_eq!(verdict(&[-1.0, 0.0, 1.0], 1), Ok(())); // 1, -1
        assert_eq!(verdict(&[-1.0, 1.0, -1.0, 1.0], 1), Ok(())); // 1, i, -i
        assert_eq!(verdict(&[0.5, -1.5, 1.0], 1), Ok(())); // 1, 1/2
        refused(&[1.0, -2.0, 1.0], 1, "double root on the unit circle");
        refused(&[-1.0, -1.0, 1.0, 1.0], 1, "double root on the unit circle"); // 1, -1, -1
        assert_eq!(verdict(&[1.0, -2.0, 1.0], 2), Ok(()));
        refused(&[-1.0, 3.0, -3.0, 1.0], 2, "triple root on the unit circle");
    }

    #[test]
    fn no_root_may_lie_outside() {
        refused(&[-5.0, 4.0, 1.0], 1, "root of modulus 5.0000");
        refused(&[2.0, -3.0, 1.0], 2, "root of modulus 2.0000");
        // 1, 2, 1/2: the product alone tells nothing.
        refused(&[-1.0, 3.5, -3.5, 1.0], 1, "root of modulus 2.0000");
        // Backward differentiation of seven steps; six are stable.
        refused(
            &[-60.0, 490.0, -1764.0, 3675.0, -4900.0, 4410.0, -2940.0, 1089.0],
            1,
            "root of modulus 1.0222",
        );
        assert_eq!(verdict(&[10.0, -72.0, 225.0, -400.0, 450.0, -360.0, 147.0], 1), Ok(()));
    }
}
