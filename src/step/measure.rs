//! What is large and what is small in an implicit step.

use super::implicit::Solver;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::{Refused, Unsolved};
use super::system::System;
use crate::linear::each_run;
use crate::tableau::Form;
use num_traits::{One, Zero};

/// A step that could grow by no more than this is kept.
const KEPT: f64 = 1.2;

/// Of sizes, none of them below zero.
pub(super) fn largest<R: Real>(x: impl Iterator<Item = R>) -> R {
    x.fold(R::zero(), R::maximum)
}

/// The sum over components of the square of what `x` gives for each, in lanes that do not wait for each other. (Short
/// vectors are summed where they are written: read back at once, they would have to be waited for.)
#[inline(always)]
pub(super) fn square_sum<T: Scalar>(n: usize, x: impl Fn(usize) -> T) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let whole = n - n % LANES;
    for block in (0..whole).step_by(LANES) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += x(block + lane).square().to_f64();
        }
    }
    let rest = (whole..n).fold(0.0, |sum, i| sum + x(i).square().to_f64());
    sums.iter().fold(rest, |all, sum| all + sum)
}

/// The sum of the squares of x over what matters.
#[inline(always)]
pub(super) fn weighted_square<Y: State>(x: &Y, weights: &Y) -> f64 {
    let (x, weights) = (x.as_slice(), weights.as_slice());
    let weights = &weights[..x.len()];
    square_sum(x.len(), |i| x[i] * weights[i])
}

impl<Y: State> Solver<Y> {
    /// The largest change of a component in the step, from the last slopes, or from f where there are none.
    pub(super) fn moves<S: System<Y>>(
        &mut self,
        form: &Form,
        x: &[Y],
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
    ) -> Result<RealOf<Y>, Refused> {
        let slopes = match self.begun {
            true => &x[form.r..form.r + form.s],
            false => {
                self.effort.evaluations += 1;
                let refused = |_| Refused { stage: 0, why: Unsolved::Domain };
                system.rhs(t, &x[0], &mut self.residual).map_err(refused)?;
                std::slice::from_ref(&self.residual)
            }
        };
        let sizes = slopes.iter().flat_map(State::as_slice).map(|f| f.scale(h).modulus());
        Ok(sizes.fold(RealOf::<Y>::zero(), RealOf::<Y>::maximum))
    }

    /// One over the size that matters, component by component. Without a tolerance rounding is measured against the
    /// whole vector and what it `moves`.
    pub(super) fn weigh(&mut self, y: &Y, moves: RealOf<Y>) {
        let least = RealOf::<Y>::TINY;
        let mut largest = moves;
        for y in y.as_slice() {
            largest = largest.maximum(y.modulus());
        }
        for (i, (w, y)) in self.weights.as_mut_slice().iter_mut().zip(y.as_slice()).enumerate() {
            let (rtol, atol) = self.tolerance.at(i);
            let size = if self.adaptive { atol + rtol * y.modulus() } else { rtol * largest };
            let size = size.maximum(RealOf::<Y>::EPSILON * RealOf::<Y>::EPSILON * largest).maximum(least);
            *w = Y::Scalar::one().scale(RealOf::<Y>::one() / size);
        }
    }

    /// The step to take instead of the one that the error allows: the same again where it gains little, since its
    /// factors are there (Hairer, Wanner 1996, IV.8).
    pub fn settled(&self, step: RealOf<Y>, next: RealOf<Y>) -> RealOf<Y> {
        let gain = (next / step).to_f64();
        if (1.0..=KEPT).contains(&gain) && self.iteration.quick() { step } else { next }
    }

    /// A bound of h |lambda| for all eigenvalues lambda of the Jacobian last taken: its largest row sum in units of
    /// what matters.
    pub fn reach(&mut self, h: RealOf<Y>) -> f64 {
        let weights = self.weights.as_slice();
        let sums = self.residual.as_mut_slice();
        sums.fill(Y::Scalar::zero());
        each_run(&self.jacobian, |j, row, entries| {
            for ((sum, &entry), &weight) in sums[row..].iter_mut().zip(entries).zip(&weights[row..]) {
                *sum = *sum + Y::Scalar::one().scale((entry * weight / weights[j]).modulus());
            }
        });
        let largest = sums.iter().map(|sum| sum.modulus().to_f64()).fold(0.0, f64::max);
        h.modulus().to_f64() * largest
    }
}
