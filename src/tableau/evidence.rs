//! A-stability by algebra, where the signs of a few numbers decide it.
//!
//! R = P/Q is A-stable where it has no pole on the left and E(y) = |Q(iy)|^2 - |P(iy)|^2 is nowhere negative
//! (Hairer, Wanner II, IV.3). E is a polynomial in y^2, and of order p its first coefficients vanish up to y^p.
//! A multistep formula is A-stable where sigma has no root outside the unit disc and rho / sigma no negative real part
//! on its border: Re(rho conj(sigma)) is a polynomial in cos theta.

use super::double_double::DoubleDouble as D;

/// How a sector of stability is known.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Evidence {
    /// By the signs of the coefficients of a polynomial, or by Sturm's count of its roots, in 32 digits; to the digits
    /// of the table where its entries are decimals.
    Proven,
    /// Located on the border of the region: alpha to this accuracy in degrees.
    Found { degrees: f64 },
}

/// Sums of products are zero where they cancel to this part of their terms.
const NOTHING: f64 = 1e-24;

/// |Q(iy)|^2 as a polynomial in y^2, and the same with all terms added up by size.
fn square(q: &[D]) -> [Vec<D>; 2] {
    let mut sums = [vec![D::ZERO; q.len()], vec![D::ZERO; q.len()]];
    for (i, &a) in q.iter().enumerate() {
        for (j, &b) in q.iter().enumerate().filter(|(j, _)| (i + j) % 2 == 0) {
            // i^i (-i)^j
            let term = if (i + 3 * j) % 4 == 0 { a * b } else { -(a * b) };
            sums[0][(i + j) / 2] += term;
            sums[1][(i + j) / 2] += term.abs();
        }
    }
    sums
}

/// Whether E is nowhere negative, of a stability function of some order whose numerator has no higher degree than its
/// denominator; `false` where that is not decided.
pub(super) fn bounded_on_the_axis(p: &[D], q: &[D], order: usize, near: f64) -> bool {
    if p.len() > q.len() {
        return false;
    }
    let near = near.max(NOTHING);
    let ([below, of_p], [above, of_q]) = (square(p), square(q));
    let at = |x: &[D], k: usize| x.get(k).copied().unwrap_or(D::ZERO);
    let coefficient = |k: usize| {
        let e = at(&above, k) - at(&below, k);
        let rounding = near * (at(&of_p, k) + at(&of_q, k)).hi();
        if 2 * k <= order || e.abs().hi() <= rounding { D::ZERO } else { e }
    };
    nowhere_negative(&(0..q.len()).map(coefficient).collect::<Vec<_>>(), near)
}

/// Whether a polynomial is nowhere negative for x >= 0.
fn nowhere_negative(e: &[D], near: f64) -> bool {
    if e.iter().all(|c| c.hi() >= 0.0) {
        return true;
    }
    let low = e.iter().position(|c| c.hi() != 0.0).unwrap_or(0);
    let high = e.iter().rposition(|c| c.hi() != 0.0).unwrap_or(0);
    let e = &e[low..=high];
    e[0].hi() > 0.0 && positive_roots(e, near) == Some(0)
}

/// The number of different roots in x > 0, by Sturm's sequence; `None` where one may be double, or a sign is lost in
/// rounding.
fn positive_roots(p: &[D], near: f64) -> Option<usize> {
    let derivative = p.iter().enumerate().skip(1).map(|(k, &c)| D::of_integer(k as i64) * c).collect();
    let mut all: Vec<Vec<D>> = vec![p.to_vec(), derivative];
    while all[all.len() - 1].len() > 1 {
        let [a, b] = [&all[all.len() - 2], &all[all.len() - 1]];
        let (mut rest, lead) = (a.clone(), b[b.len() - 1]);
        let size = a.iter().map(|c| c.abs().hi()).fold(0.0, f64::max);
        while rest.len() >= b.len() {
            let shift = rest.len() - b.len();
            let share = rest[rest.len() - 1] / lead;
            b.iter().enumerate().for_each(|(k, &c)| rest[shift + k] += -(share * c));
            rest.pop();
        }
        let lost = 1e6 * near * size;
        if !rest.iter().all(|c| c.hi().is_finite()) || rest.last().is_none_or(|c| c.abs().hi() <= lost) {
            return None;
        }
        all.push(rest.into_iter().map(|c| -c).collect());
    }
    let changes = |sign: fn(&Vec<D>) -> f64| {
        let signs: Vec<_> = all.iter().map(sign).filter(|&s| s != 0.0).collect();
        signs.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count()
    };
    let (at_zero, at_infinity) = (changes(|p| p[0].hi()), changes(|p| p[p.len() - 1].hi()));
    at_zero.checked_sub(at_infinity)
}

/// Whether Re(rho conj(sigma)) is nowhere negative on the unit circle; `false` where that is not decided.
pub(super) fn right_of_the_axis(rho: &[D], sigma: &[D], near: f64) -> bool {
    // The coefficients of cos(m theta), and T_m(1 - u) in powers of u = 1 - cos theta.
    let n = rho.len();
    let (mut sum, mut sizes) = (vec![D::ZERO; n], vec![0.0; n]);
    let mut chebyshev = vec![vec![D::ONE], vec![D::ONE, -D::ONE]];
    while chebyshev.len() < n {
        let [last, now] = [&chebyshev[chebyshev.len() - 2], &chebyshev[chebyshev.len() - 1]];
        let mut next = vec![D::ZERO; now.len() + 1];
        for (k, &c) in now.iter().enumerate() {
            next[k] += c + c;
            next[k + 1] += -(c + c);
        }
        last.iter().enumerate().for_each(|(k, &c)| next[k] += -c);
        chebyshev.push(next);
    }
    for (i, &a) in rho.iter().enumerate() {
        for (j, &b) in sigma.iter().enumerate() {
            for (k, &c) in chebyshev[i.abs_diff(j)].iter().enumerate() {
                sum[k] += a * b * c;
                sizes[k] += (a * b * c).abs().hi();
            }
        }
    }
    let vanishes = |k: usize| sum[k].abs().hi() <= near.max(NOTHING) * sizes[k];
    (0..n).all(|k| vanishes(k) || sum[k].hi() > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(p: &[f64]) -> Vec<D> {
        p.iter().map(|&c| D::of(c)).collect()
    }

    #[test]
    fn signs_and_roots_decide() {
        for (p, decided) in [
            (&[0.0, 0.0, 1.0][..], true),
            (&[0.0, 0.0], true),
            (&[2.0, -2.0, 1.0], true),  // (x - 1)^2 + 1
            (&[2.0, -3.0, 1.0], false), // (x - 1) (x - 2)
            (&[0.0, -1.0], false),
            (&[-1.0, 1.0], false),
            (&[1.0, -2.0, 1.0], false),            // A double root is never decided.
            (&[0.0, 6.0, 11.0, 6.0, -1.0], false), // Negative from 7.6 on.
            (&[6.0, -12.0, 11.0, -5.0, 1.0], true), // (x^2 - 2 x + 2) (x^2 - 3 x + 3)
        ] {
            assert_eq!(nowhere_negative(&of(p), NOTHING), decided, "{p:?}");
        }
        assert_eq!(positive_roots(&of(&[-6.0, 11.0, -6.0, 1.0]), NOTHING), Some(3));
        assert_eq!(positive_roots(&of(&[6.0, 11.0, 6.0, 1.0]), NOTHING), Some(0));
    }

    /// Q = (1 - gamma z)^s and P of degree s - 1 and order s - 1: Hairer, Wanner II, table IV.6.4.
    #[test]
    fn singly_diagonal_methods_are_l_stable_where_the_book_says() {
        let decided = |s: usize, gamma: f64| {
            let (g, one) = (D::of(gamma), D::ONE);
            let mut q = vec![one];
            for _ in 0..s {
                let mut next = q.clone();
                next.push(D::ZERO);
                q.iter().enumerate().for_each(|(k, &c)| next[k + 1] += -(g * c));
                q = next;
            }
            let factorial = |k: usize| (1..=k).fold(one, |x, j| x * D::of_integer(j as i64));
            let p: Vec<_> =
                (0..s).map(|k| (0..=k).fold(D::ZERO, |sum, j| sum + q[j] / factorial(k - j))).collect();
            bounded_on_the_axis(&p, &q, s - 1, 0.0)
        };
        for (s, least, most) in [
            (2, 1.0 - 0.5f64.sqrt(), 1.0 + 0.5f64.sqrt()),
            (3, 0.18042531, 2.18560010),
            (4, 0.22364780, 0.57281606),
        ] {
            let near = 1e-7;
            assert!(decided(s, least + near) && decided(s, most - near), "{s}");
            assert!(!decided(s, least - near) && !decided(s, most + near), "{s}");
        }
    }

    #[test]
    fn formulas_right_of_the_axis() {
        let decided = |rho: &[f64], sigma: &[f64]| right_of_the_axis(&of(rho), &of(sigma), 0.0);
        assert!(decided(&[-1.0, 1.0], &[0.5, 0.5]));
        assert!(decided(&[0.5, -2.0, 1.5], &[0.0, 0.0, 1.0]));
        assert!(!decided(&[-1.0, 1.0], &[1.0, 0.0]));
        // Beyond order 2 nothing is (Dahlquist 1963).
        assert!(!decided(&[-2.0, 9.0, -18.0, 11.0], &[0.0, 0.0, 0.0, 6.0]));
    }
}
