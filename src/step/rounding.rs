//! What the rounding of the Jacobian makes of a Rosenbrock run.
//!
//! Such a stage multiplies with J as it is in floating point. What that spoils in a motion that is damped is gone at
//! once. A sum of components that f conserves keeps it: the columns of J add up to zero but for the rounding of their
//! entries, and where the components end far smaller than those entries made them, no digit of them is right. (An
//! iteration, by contrast, ends where f itself agrees.) An error of that size and of chance signs is carried from step
//! to step, damped and kept as the solution is.

use super::implicit::Solver;
use super::measure::largest;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::Unsolved;
use crate::linear::{Square, each_run};
use crate::tableau::Form;
use num_traits::{One, Zero};

/// It may exceed the tolerance by so much.
const ALLOWED: f64 = 100.0;
/// Rounding of a step below this share of the absolute tolerance is none.
const NONE: f64 = 1e-4;

/// The error, component by component.
#[derive(Clone)]
pub(super) struct Rounding<Y> {
    /// After the last accepted step, and after the one being tried.
    lost: Y,
    tried: Y,
    /// The step being tried has one.
    fresh: bool,
    /// Where the signs come from.
    chance: u64,
}

impl<Y: State> Rounding<Y> {
    pub fn new(y: &Y) -> Self {
        let mut lost = y.clone();
        lost.as_mut_slice().fill(Y::Scalar::zero());
        Self { tried: lost.clone(), lost, fresh: false, chance: 1 }
    }

    /// The step was accepted.
    pub fn moved(&mut self) {
        if std::mem::take(&mut self.fresh) {
            std::mem::swap(&mut self.lost, &mut self.tried);
        }
    }
}

impl<Y: State> Solver<Y> {
    /// Carries the error over a step from `y` to `end` with these slopes.
    ///
    /// # Errors
    /// The component that is spoiled for good, or [`Unsolved::Diverged`] where this step alone would do it.
    pub(super) fn round(
        &mut self,
        form: &Form,
        h: RealOf<Y>,
        (y, end): (&Y, &Y),
        slopes: &[Y],
    ) -> Result<(), Unsolved> {
        let Some(rounding) = self.rounding.as_mut().filter(|_| self.mass.is_none()) else { return Ok(()) };
        rounding.fresh = false;
        let real = RealOf::<Y>::from_f64;
        let unit = RealOf::<Y>::EPSILON * (h * RealOf::<Y>::of(form.stage[0].diagonal)).modulus();
        let change = largest(end.as_slice().iter().zip(y.as_slice()).map(|(&a, &b)| (a - b).modulus()));
        let steepest = largest(self.jacobian.entries().iter().map(|x| x.modulus()));
        if unit * steepest * change <= real(NONE) * self.tolerance.least() {
            return Ok(());
        }
        let (error, sizes) = (rounding.tried.as_mut_slice(), self.residual.as_mut_slice());
        sizes.fill(Y::Scalar::zero());
        each_run(&self.jacobian, |j, row, entries| {
            let by = largest(slopes.iter().map(|f| f.as_slice()[j].modulus())) * h.modulus() * unit;
            for (size, entry) in sizes[row..].iter_mut().zip(entries) {
                *size = *size + Y::Scalar::one().scale(entry.modulus() * by);
            }
        });
        for ((error, &lost), &size) in error.iter_mut().zip(rounding.lost.as_slice()).zip(&*sizes) {
            // Knuth's linear congruences: their highest bits are the best.
            rounding.chance =
                rounding.chance.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            *error = if rounding.chance >> 63 == 0 { lost + size } else { lost - size };
        }
        // As many as come nearest to exp(h J).
        let times = (1.0 / form.stage[0].diagonal.hi()).round().max(1.0) as usize;
        (0..times).for_each(|_| self.factors[0].matrix.solve(error));
        for (component, y) in end.as_slice().iter().enumerate() {
            let (rtol, atol) = self.tolerance.at(component);
            let limit = real(ALLOWED) * (atol + rtol * y.modulus());
            if error[component].modulus() > limit {
                // What this step alone has spoiled a smaller one may leave.
                let before = rounding.lost.as_slice()[component].modulus();
                return Err(if before + before > limit {
                    Unsolved::Rounding { component }
                } else {
                    Unsolved::Diverged
                });
            }
        }
        rounding.fresh = true;
        Ok(())
    }
}
