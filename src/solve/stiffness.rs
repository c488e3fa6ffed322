//! Whether stability or accuracy sets the steps of a run.

use crate::step::norm::Tolerance;
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::stepper::View;
use crate::tableau::{CARRIED, Form, Meaning, Row, STAGES};
use num_traits::{One, Zero};

/// Steps between two looks while nothing is suspected.
const SELDOM: u64 = 32;
/// So many looks must find the steps at the limit, with fewer than [`CLEAR`] in between that do not (Hairer,
/// Wanner 1996, IV.2: one look may mislead where the Jacobian is far from normal).
const SUSPECT: u32 = 15;
const CLEAR: u32 = 6;

/// The watch over one run, in explicit steps for the beginning of stiffness, in implicit ones for its end.
#[derive(Clone, Debug)]
pub(crate) struct Stiffness {
    /// How far the real axis is stable with the explicit method: the largest -h lambda.
    pub limit: f64,
    /// Two stages of it at the same time.
    pair: Option<(usize, usize)>,
    hits: u32,
    misses: u32,
    /// Looks that must agree that the end has come; twice as many each time stiffness came back.
    patience: u32,
    /// The count of accepted steps at which the next look is due.
    pub look: u64,
    /// The last h |lambda| that counted.
    pub seen: f64,
}

impl Stiffness {
    /// `limit` is the explicit method's [`real_limit`].
    pub fn new(explicit: &Form, limit: f64) -> Self {
        let pairs = (0..explicit.s).flat_map(|j| (0..j).map(move |i| (i, j)));
        let mut together = pairs.filter(|&(i, j)| explicit.c[i].hi() == explicit.c[j].hi());
        Self { limit, pair: together.next_back(), hits: 0, misses: 0, patience: 10, look: 1, seen: 0.0 }
    }

    /// When the next look is due, in accepted steps.
    pub fn next_look(&self, accepted: u64) -> u64 {
        accepted + if self.hits > 0 { 1 } else { SELDOM }
    }

    /// Of an explicit step: h |lambda| from two stages at the same time, |F_j - F_i| h / |Y_j - Y_i|.
    #[cold]
    #[inline(never)]
    pub fn begins<Y: State>(&mut self, view: View<Y>, tolerance: &Tolerance<RealOf<Y>>) -> bool {
        let Some((i, j)) = self.pair else { return false };
        let (form, x) = (view.form, view.read());
        // (Y_j - Y_i) / h: what both rows start from falls out.
        let mut weights = [RealOf::<Y>::zero(); CARRIED + STAGES];
        let [plus, minus] = [&form.stage[j], &form.stage[i]];
        (0..plus.len).for_each(|k| weights[plus.at[k]] = RealOf::<Y>::of(plus.a[k]));
        (0..minus.len)
            .for_each(|k| weights[minus.at[k]] = weights[minus.at[k]] - RealOf::<Y>::of(minus.a[k]));
        let [before, after] = [i, j].map(|stage| x[form.r + stage].as_slice());
        let (mut slopes, mut values) = (0.0, 0.0);
        for (n, y) in view.y().as_slice().iter().enumerate() {
            let (rtol, atol) = tolerance.at(n);
            let per = RealOf::<Y>::one() / (atol + rtol * y.modulus());
            let mut value = Y::Scalar::zero();
            for (x, &weight) in x.iter().zip(&weights) {
                value = value + x.as_slice()[n].scale(weight);
            }
            slopes += (after[n] - before[n]).scale(per).square().to_f64();
            values += value.scale(per).square().to_f64();
        }
        let reach = (slopes / values).sqrt();
        if !(reach > 0.9 * self.limit && reach.is_finite()) {
            self.misses += 1;
            if self.misses >= CLEAR {
                self.hits = 0;
            }
            return false;
        }
        (self.hits, self.misses, self.seen) = (self.hits + 1, 0, reach);
        self.hits >= SUSPECT
    }

    /// Of an implicit step: `reach` is at least h |lambda| for all lambda.
    pub fn ends(&mut self, reach: f64) -> bool {
        let calm = reach < 0.5 * self.limit;
        (self.hits, self.seen) = if calm { (self.hits + 1, reach) } else { (0, self.seen) };
        self.hits >= self.patience
    }

    /// The method was changed.
    pub fn turned(&mut self, stiff: bool) {
        (self.hits, self.misses) = (0, 0);
        if stiff {
            self.patience = (2 * self.patience).min(1000);
        }
    }
}

/// The largest x for which y' = -y/h shrinks in a step of x h, from the rows of an explicit one-step method.
pub(crate) const fn real_limit(form: &Form) -> f64 {
    let (mut stable, mut step) = (0.0, 0.5);
    while step > 1e-3 {
        let growth = growth(form, -stable - step);
        if -1.0 <= growth && growth <= 1.0 && stable < 100.0 {
            stable += step;
        } else {
            step *= 0.5;
        }
    }
    stable
}

/// y after a step of y' = z y, h = 1, from y = 1.
const fn growth(form: &Form, z: f64) -> f64 {
    let (mut x, mut i) = ([0.0; CARRIED + STAGES], 0);
    while i < form.r {
        x[i] = if matches!(form.means[i], Meaning::F(0)) { z } else { 1.0 };
        i += 1;
    }
    let mut i = 0;
    while i < form.s {
        x[form.r + i] = z * value(&form.stage[i], &x);
        i += 1;
    }
    value(if form.carry[0].last_y { &form.stage[form.s - 1] } else { &form.carry[0] }, &x)
}

const fn value(row: &Row, x: &[f64; CARRIED + STAGES]) -> f64 {
    let mut sum = match row.base {
        Some(base) => x[base],
        None => 0.0,
    };
    let mut k = 0;
    while k < row.len {
        sum += row.a[k].hi() * x[row.at[k]];
        k += 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Method;
    use crate::methods::{Dp54, Rk4, Tsit54};

    #[test]
    fn the_limit_is_that_of_the_stability_function() {
        // Hairer, Wanner II, table IV.2.1 and figure 2.1: 3.3066 and 2.7853.
        assert!((real_limit(Dp54.form()) - 3.3066).abs() < 2e-3);
        assert!((real_limit(Rk4.form()) - 2.7853).abs() < 2e-3);
        assert!((real_limit(Tsit54.form()) - 3.5068).abs() < 2e-3, "{}", real_limit(Tsit54.form()));
    }
}
