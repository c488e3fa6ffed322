//! Step-size control: how the next step follows from the errors of the last ones.

use crate::tableau::Form;

/// A digital filter of the error (Söderlind 2003, ACM TOMS 29):
///
/// ```text
/// h_(n+1) / h_n = (s/e_n)^(b1/k) (s/e_(n-1))^(b2/k) (s/e_(n-2))^(b3/k) (h_n/h_(n-1))^(-a2)
/// ```
///
/// with e the error norm over its tolerance, k the order of the estimate plus one, s the safety factor.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Controller {
    /// b1, b2, b3.
    pub errors: [f64; 3],
    /// a2: how much of the last change of step is taken back. Below 0 the steps are expected to go on changing as they
    /// did; they then never grow by more than the last error alone allows.
    pub steps: f64,
    /// The error aimed at is this factor to the power k. Default 0.9, of implicit methods 0.8; nearer to 1 more steps are rejected.
    pub safety: f64,
    /// A step never shrinks by more than this at once. Default 0.2.
    pub shrink: f64,
    /// A step never grows by more than this at once. Default 10, of implicit methods 6.
    pub grow: f64,
}

impl Controller {
    const fn of(errors: [f64; 3], steps: f64) -> Self {
        Self { errors, steps, safety: 0.9, shrink: 0.2, grow: 10.0 }
    }

    /// The elementary controller: the last error alone. Quickest where the solution is smooth.
    pub const I: Self = Self::of([1.0, 0.0, 0.0], 0.0);
    /// Gustafsson (1991), ACM TOMS 17: fewer rejections where stability limits the step.
    pub const PI: Self = Self::of([0.7, -0.4, 0.0], 0.0);
    /// Proportional, integral and differential parts 1/18, 1/9, 1/18 (Söderlind's H312PID).
    pub const PID: Self = Self::of([1.0 / 18.0, 1.0 / 9.0, 1.0 / 18.0], 0.0);
    /// Söderlind's H211b with b = 4: smooth step sequences.
    pub const H211B: Self = Self::of([0.25, 0.25, 0.0], 0.25);
    /// Gustafsson (1994), ACM TOMS 20, 496; Hairer, Wanner II, IV.8: what the last two errors and the last change of
    /// step foretell, or what the last error alone allows, whichever is less.
    pub const PREDICTIVE: Self = Self { safety: 0.8, grow: 6.0, ..Self::of([2.0, -1.0, 0.0], -1.0) };

    /// What a run takes where none is given. Transients that die out let the steps of a stiff problem grow for
    /// decades; [`PI`](Self::PI), which a growing step keeps behind, stays at a fraction of the error allowed.
    pub(crate) fn of_form(form: &Form) -> Self {
        if form.forgets() { Self::PREDICTIVE } else { Self::PI }
    }
}

/// PI, the choice for explicit methods: with two pairs of order 8 on five problems it took 0.96 of the time of the
/// elementary controller to the same error (geometric mean; single cases 0.78 to 1.16) and rejected at most half as
/// many steps. The table sets its exponents through k.
impl Default for Controller {
    fn default() -> Self {
        Self::PI
    }
}

/// The memory of a controller. Logarithms are binary and in units of 2^-52, as [`log`] reads them off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    /// -b1/(2k), -b2/(2k), -b3/(2k): what the square of each error contributes.
    weights: [f64; 3],
    steps: f64,
    safety: f64,
    shrink: f64,
    grow: f64,
    /// -1/(2k), for a step that is tried again.
    retry: f64,
    /// Logarithms of the squares of the last two accepted errors, newest first.
    errors: [f64; 2],
    rejected: bool,
    /// A step was accepted.
    begun: bool,
}

impl Control {
    pub fn new(controller: Controller, k: usize) -> Self {
        let half = -0.5 / k as f64;
        let exact = |x: f64| x.log2() * MANTISSA;
        Self {
            weights: controller.errors.map(|b| half * b),
            steps: controller.steps,
            safety: exact(controller.safety),
            shrink: exact(controller.shrink),
            grow: exact(controller.grow),
            retry: half,
            errors: [0.0; 2],
            rejected: false,
            begun: false,
        }
    }

    /// The factor of the next step after an accepted one, from the square of its error. `change` gives the size of
    /// the step over that of the last accepted one.
    ///
    /// The next step waits for this number, so little stands between the error and the factor.
    #[inline(always)]
    pub fn accepted(&mut self, error_square: f64, change: impl FnOnce() -> f64) -> f64 {
        let e = log(error_square);
        let known = self.safety + self.weights[1] * self.errors[0] + self.weights[2] * self.errors[1];
        let mut limit = if self.rejected { 0.0 } else { self.grow };
        let mut next = self.weights[0] * e + known;
        if self.steps != 0.0 {
            if self.begun {
                next -= self.steps * change().log2() * MANTISSA;
            }
            if self.steps < 0.0 {
                // A first error has nothing before it.
                next = if self.begun { next } else { limit };
                limit = limit.min(self.retry * e + self.safety);
            }
        }
        self.errors = [e.max(FORGOTTEN), self.errors[0]];
        (self.rejected, self.begun) = (false, true);
        exp(next.min(limit).max(self.shrink))
    }

    /// The factor of the retry after a rejected step.
    pub fn rejected(&mut self, error_square: f64) -> f64 {
        self.rejected = true;
        if !error_square.is_finite() {
            return 0.5 * exp(self.shrink);
        }
        exp((self.retry * log(error_square) + self.safety).max(self.shrink).min(self.safety))
    }

    /// The factor after an iteration that did not converge: it starts nearer to the solution, and contracts better, in
    /// half the step (Hairer's RADAU5).
    pub fn diverged(&mut self) -> f64 {
        self.rejected = true;
        0.5
    }

    /// The factor after a refusal of the right-hand side.
    pub fn refused(&mut self) -> f64 {
        self.rejected = true;
        exp(self.shrink)
    }
}

/// Bits of a number a little below 1, chosen so that the largest error of the two functions below is least.
const ONE: i64 = 0x3fef_5000_0000_0000;
const MANTISSA: f64 = (1u64 << 52) as f64;

/// The square of an error of 1e-4. What was smaller says no more about the next one: after a zero, an error of
/// any size would seem to explode (Hairer's codes have the same floor).
const FORGOTTEN: f64 = -26.6 * MANTISSA;

/// log2 of a number that is not negative, in units of 2^-52, read off its bits as a piecewise linear
/// function. A step factor needs no more: its error of 3 % is a third of the safety margin.
#[inline(always)]
fn log(x: f64) -> f64 {
    (x.to_bits() as i64 - ONE) as f64
}

/// The inverse of [`log`].
#[inline(always)]
fn exp(y: f64) -> f64 {
    f64::from_bits((y as i64 + ONE) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_is_good_to_four_percent() {
        for k in 2..14 {
            let exponent = -1.0 / k as f64;
            let mut x = 1e-20;
            while x < 1e20 {
                let near = exp(exponent * log(x));
                let ratio = near / x.powf(exponent);
                assert!((ratio - 1.0).abs() < 0.04 + 0.03 * -exponent, "{x:e}^{exponent}: {ratio}");
                x *= 1.37;
            }
        }
    }

    #[test]
    fn a_zero_error_grows_a_nan_shrinks() {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.05;
        let mut control = Control::new(Controller::I, 5);
        assert!(near(control.accepted(0.0, || 1.0), 10.0));
        assert!(near(control.rejected(f64::NAN), 0.1));
        assert!(control.accepted(0.0, || 1.0) <= 1.0, "no growth right after a rejection");
        assert!(near(control.accepted(1.0, || 1.0), 0.9));
    }

    #[test]
    fn growth_is_foretold_but_not_beyond_what_the_error_allows() {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.06;
        // Squares of errors e = 0.9^4 of steps that grow by 1.2 each, with k = 4: 0.8 (1/e)^(1/4) by the last alone.
        let e = 0.9f64.powi(8);
        let mut control = Control::new(Controller::PREDICTIVE, 4);
        control.accepted(e, || 1.2);
        assert!(near(control.accepted(e, || 1.2), 0.8 / 0.9));
        // An error that grows tenfold while the step stays: 0.8 (1/e)^(1/4) 10^(-1/4).
        let mut control = Control::new(Controller::PREDICTIVE, 4);
        control.accepted(1e-2, || 1.0);
        assert!(near(control.accepted(1.0, || 1.0), 0.8 * 10f64.powf(-0.25)));
    }
}
