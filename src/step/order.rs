//! Which order and step come next in a family of multistep formulas.
//!
//! The error is estimated from e for the order q at hand, from z_q for q - 1, from the change of e for q + 1. Order
//! and step change q + 1 steps after the last change at the earliest: by then the history is one of even steps
//! (Gear 1971, ch. 9; Hindmarsh 1983, Scientific Computing, 55).

use super::implicit::Solver;
use super::measure::square_sum;
use super::nordsieck::{Nordsieck, Start};
use super::norm::Tolerance;
use super::scalar::{Plain, Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::View;
use crate::tableau::Form;
use num_traits::One;

/// The first change of step may be any: it makes up for a careful start.
pub(super) const FIRST_GROWTH: f64 = 1e4;
/// Growth at once after all others.
const GROWTH: f64 = 10.0;
/// Growth after a step that failed.
pub(super) const CAREFUL: f64 = 2.0;
/// What the estimates at q - 1, q and q + 1 are multiplied with, to the power 1/(p + 1): they favour the order at
/// hand. A tenth more each than Hindmarsh's (1983): on Van der Pol's, Robertson's and the Oregonator's equations
/// and HIRES it rejects fewer steps and takes a twentieth fewer evaluations to the same error.
const BIAS: [f64; 3] = [1.4, 1.3, 1.5];
/// A change of step by less does not pay.
const WORTHWHILE: f64 = 1.1;
/// Error tests failed in a row after which the run starts anew, with order 1.
const FAILURES: u32 = 3;

/// The factor of the step that an error of that order, in units of its tolerance, allows.
fn allowed(error: f64, order: usize, bias: f64) -> f64 {
    1.0 / (bias * error.powf(1.0 / (order as f64 + 1.0)) + 1e-6 * bias)
}

/// What an estimate multiplies: z_q for the error of order q - 1, e for that of order q, the change of e for
/// that of order q + 1. With q! l_q e the change of h^q y^(q) in a step, each is C h^(p+1) y^(p+1).
pub(super) fn estimates(form: &Form, q: usize) -> [f64; 3] {
    let factorial: f64 = (1..=q).map(|i| i as f64).product();
    let constant = |p: usize| match p {
        0 => 0.0,
        p if p > form.orders => 0.0,
        p => form.correctors[p - 1].constant.hi().abs(),
    };
    let l = form.correctors[q - 1].l[q].hi() * factorial;
    [constant(q - 1) * factorial, constant(q) * l, constant(q + 1) * l]
}

impl<Y: State> Solver<Y> {
    /// The square of the error of the step just attempted.
    pub(super) fn nordsieck_error(
        &mut self,
        view: View<Y>,
        tolerance: &Tolerance<RealOf<Y>>,
    ) -> Option<RealOf<Y>> {
        let family = self.nordsieck.as_mut()?;
        let one = RealOf::<Y>::one();
        let unit = RealOf::<Y>::from_f64(estimates(view.form, family.order)[1]);
        let e = view.word(view.form.r);
        let share = one / RealOf::<Y>::from_f64(e.as_slice().len().max(1) as f64);
        let square = view.next(0).error_square::<Plain, 1>(view.y(), tolerance, one, |_| unit, |_| e) * share;
        family.error = square.to_f64().sqrt();
        Some(square)
    }

    /// The root of the mean square over what matters of x less `from`.
    fn size(&self, x: &Y, from: Option<&Y>) -> f64 {
        let (x, weights) = (x.as_slice(), self.weights.as_slice());
        let n = weights.len();
        let (x, weights) = (&x[..n], &weights[..n]);
        let sum = match from {
            None => square_sum(n, |i| x[i] * weights[i]),
            Some(from) => {
                let from = &from.as_slice()[..n];
                square_sum(n, |i| (x[i] - from[i]) * weights[i])
            }
        };
        (sum / n.max(1) as f64).sqrt()
    }

    /// Chooses the order of the next step, after an accepted one; gives the factor of its size.
    pub(crate) fn chosen(&mut self, form: &Form, words: &mut [Y]) -> f64 {
        let Some(mut family) = self.nordsieck.take() else { return 1.0 };
        let factor = self.choose(&mut family, form, words);
        self.nordsieck = Some(family);
        factor
    }

    fn choose(&mut self, family: &mut Nordsieck<Y>, form: &Form, words: &mut [Y]) -> f64 {
        let q = family.order;
        let (z, rest) = words.split_at_mut(form.r);
        let e = &rest[0];
        family.wait -= 1;
        if family.wait > 0 {
            if family.wait == 1 {
                family.last.as_mut_slice().copy_from_slice(e.as_slice());
            }
            return 1.0;
        }
        let [down, _, up] = estimates(form, q);
        let mut factors = [0.0, allowed(family.error, q, BIAS[1]), 0.0];
        if q > 1 {
            factors[0] = allowed(down * self.size(&z[q], None), q - 1, BIAS[0]);
        }
        if q < form.orders {
            factors[2] = allowed(up * self.size(e, Some(&family.last)), q + 1, BIAS[2]);
        }
        let threatened = form.damped && self.threatened(family, form, e, &mut factors);
        let best = if factors[2] > factors[1].max(factors[0]) {
            2
        } else if factors[0] > factors[1] || threatened {
            0
        } else {
            1
        };
        let factor = factors[best].min(family.grow);
        if factor < WORTHWHILE && !threatened {
            family.wait = 3;
            return 1.0;
        }
        if best == 2 {
            let share = RealOf::<Y>::of(form.correctors[q - 1].l[q]) / RealOf::<Y>::from_f64(q as f64 + 1.0);
            for (z, &e) in z[q + 1].as_mut_slice().iter_mut().zip(e.as_slice()) {
                *z = e.scale(share);
            }
            family.order = q + 1;
        } else if best == 0 {
            family.set_order(q - 1, z);
        }
        (family.wait, family.grow) = (family.order + 1, GROWTH);
        factor
    }

    /// Chooses the order in which a step is tried again whose error was too large; gives the factor of its size.
    pub(crate) fn rechosen(&mut self, form: &Form, words: &mut [Y]) -> f64 {
        let Some(mut family) = self.nordsieck.take() else { return 0.5 };
        let q = family.order;
        family.failures += 1;
        (family.grow, family.wait) = (CAREFUL, q + 1);
        let mut factor = 0.1;
        if !family.error.is_finite() {
            // The history is of no use where an attempt left the numbers.
        } else if family.failures >= FAILURES {
            family.start = Start::Anew;
            // An order cannot be judged by a slope alone.
            family.wait = 5;
        } else {
            factor = allowed(family.error, q, BIAS[1]);
            let lower = match q {
                1 => 0.0,
                _ => {
                    let power = (self.tried / family.h).to_f64().abs().powi(q as i32);
                    allowed(estimates(form, q)[0] * self.size(&words[q], None) * power, q - 1, BIAS[0])
                }
            };
            if lower > factor {
                family.set_order(q - 1, &mut words[..form.r]);
                family.wait = q;
                factor = lower;
            }
            factor = factor.min(if family.failures > 1 { 0.2 } else { 0.9 }).max(0.1);
        }
        self.nordsieck = Some(family);
        factor
    }
}
