//! Fast oscillations that a formula of high order amplifies.
//!
//! Near the imaginary axis backward differentiation of order 3 and more is unstable for steps in between. What it
//! amplifies soon dominates the error, and then the eigenvalue belongs to the plane that the error e and J e span:
//! J (J e) = a J e + b e. The formula's own roots at h lambda tell whether it is to blame. Where it is, the
//! order falls, and no order is taken that would be again, as long as the Jacobian stays.

use super::implicit::Solver;
use super::nordsieck::Nordsieck;
use super::scalar::{Real, Scalar};
use super::state::State;
use crate::linear::each_run;
use crate::tableau::{Corrector, Form};
use num_complex::Complex;
use num_traits::{One, Zero};

/// What may be left of J (J e) outside the plane, in squares.
const OUTSIDE: f64 = 1e-2;
/// Growth in a step by less than this is within what tolerances allow.
const GROWTH: f64 = 5e-3;

impl<Y: State> Solver<Y> {
    /// Takes back what an unstable order is allowed: factors of the step for the order below, at hand and above.
    /// Whether the order at hand is unstable at the step at hand.
    pub(super) fn threatened(
        &mut self,
        family: &mut Nordsieck<Y>,
        form: &Form,
        e: &Y,
        factors: &mut [f64; 3],
    ) -> bool {
        let q = family.order;
        if let Some(found) = self.dominant(e) {
            family.threat = Some(found);
        }
        let Some((re, im)) = family.threat else { return false };
        let h = family.h.to_f64().abs();
        let sign = if family.h.to_f64() < 0.0 { -1.0 } else { 1.0 };
        let unstable = |q: usize, factor: f64| {
            let z = Complex::new(sign * re, im) * (h * factor);
            !stable(&form.correctors[q - 1], z)
        };
        if factors[2] > 0.0 && unstable(q + 1, factors[2].min(family.grow)) {
            factors[2] = 0.0;
        }
        if !unstable(q, factors[1].min(family.grow)) {
            return false;
        }
        factors[1] = factors[1].min(1.0);
        if q == 1 || !unstable(q, 1.0) {
            return false;
        }
        factors[0] = factors[0].clamp(0.5, family.grow);
        factors[1] = 0.0;
        factors[2] = 0.0;
        true
    }

    /// The eigenvalue, real part and modulus of the imaginary one, that e belongs to, if it is one of an
    /// oscillation.
    fn dominant(&mut self, e: &Y) -> Option<(f64, f64)> {
        self.times_jacobian(e, false);
        self.times_jacobian(e, true);
        let (v, p, s) = (e.as_slice(), self.residual.as_slice(), self.time.as_slice());
        let weights = self.weights.as_slice();
        // All at once: one sum does not wait for the others.
        let mut products = [Y::Scalar::zero(); 5];
        for (((&v, &p), &s), &w) in v.iter().zip(p).zip(s).zip(weights) {
            let [v, p, s] = [v * w, p * w, s * w];
            for (sum, term) in products.iter_mut().zip([v * v, v * p, p * p, v * s, p * s]) {
                *sum = *sum + term;
            }
        }
        let [vv, vp, pp, vs, ps] = products;
        let outside = |a: Y::Scalar, b: Y::Scalar| {
            let (mut rest, mut all) = (0.0, 0.0);
            for (((&v, &p), &s), &w) in v.iter().zip(p).zip(s).zip(weights) {
                rest += ((s - (a * p + b * v)) * w).square().to_f64();
                all += (s * w).square().to_f64();
            }
            rest <= OUTSIDE * all && all > 0.0
        };
        // A complex state may hold the eigenvector itself.
        let lambda = vp / vv;
        if lambda.finite() && outside(lambda, Y::Scalar::zero()) {
            let size = lambda.modulus().to_f64();
            let turn = lambda.scale(Real::from_f64(1.0 / size));
            let cosine = 0.5 * (turn + Y::Scalar::one()).square().to_f64() - 1.0;
            let im = size * (1.0 - cosine * cosine).max(0.0).sqrt();
            return (im > 1e-6 * size).then_some((size * cosine, im));
        }
        let determinant = pp * vv - vp * vp;
        let (a, b) = ((ps * vv - vs * vp) / determinant, (vs * pp - ps * vp) / determinant);
        if !a.finite() || !b.finite() || !outside(a, b) {
            return None;
        }
        // lambda^2 = a lambda + b, of a conjugate pair.
        let (a, b) = (real(a)?, real(b)?);
        let square = -b - 0.25 * a * a;
        (square > 0.0).then(|| (0.5 * a, square.sqrt()))
    }

    /// J e into the residual, or J times the residual into `time`.
    fn times_jacobian(&mut self, e: &Y, again: bool) {
        let (to, from) = if again { (&mut self.time, &self.residual) } else { (&mut self.residual, e) };
        let to = to.as_mut_slice();
        to.fill(Y::Scalar::zero());
        let from = from.as_slice();
        each_run(&self.jacobian, |j, row, entries| {
            let by = from[j];
            to[row..].iter_mut().zip(entries).for_each(|(to, &entry)| *to = *to + entry * by);
        });
    }
}

/// The value of a number that is real.
fn real<T: Scalar>(x: T) -> Option<f64> {
    let size = x.modulus();
    let signed = [size, -size].into_iter().find(|&r| T::one().scale(r) == x)?;
    Some(signed.to_f64())
}

/// No root of rho - z sigma has a modulus that a step of y' = lambda y itself would not have, but for rounding
/// and tolerances (Schur 1918).
fn stable(corrector: &Corrector, z: Complex<f64>) -> bool {
    let radius = z.re.exp().max(1.0) + GROWTH;
    let mut p = [Complex::new(0.0, 0.0); crate::tableau::CARRIED];
    let mut power = 1.0;
    for (j, p) in p[..=corrector.k].iter_mut().enumerate() {
        *p = (corrector.alpha[j] - z * corrector.beta[j]) * power;
        power *= radius;
    }
    for n in (1..=corrector.k).rev() {
        let (first, last) = (p[0], p[n]);
        if first.norm_sqr() >= last.norm_sqr() {
            return false;
        }
        let old = p;
        for i in 0..n {
            p[i] = old[i + 1] * last.conj() - first * old[n - 1 - i].conj();
        }
        // Only ratios matter.
        let size = p[..n].iter().map(|p| p.norm()).fold(0.0, f64::max);
        p[..n].iter_mut().for_each(|p| *p /= size);
    }
    true
}
