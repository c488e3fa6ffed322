//! When an iteration on implicit stages has converged, and when there is no hope.

use super::stepper::Unsolved;

/// Most iterations on one stage where a smaller step is the better remedy, and where there is none: with a
/// contraction of two thirds, two hundred reach any precision.
const MOST: [i32; 2] = [10, 200];

/// With a Jacobian of the past at least this share of a first correction is taken to be left.
const DOUBT: f64 = 0.03;

/// How an iteration converges.
#[derive(Clone, Copy)]
pub(super) struct Iteration {
    /// It ends where its error is below this in the norm of the weights.
    enough: f64,
    /// Below this an iteration that no longer converges has met rounding.
    rounding: f64,
    most: i32,
    /// Corrections made, and the size of the last.
    count: i32,
    last: f64,
    /// Between the last correction and the error that is left.
    factor: f64,
    /// The slowest convergence since the Jacobian was taken.
    slowest: f64,
    /// The Jacobian is one of the past, and has not been seen to serve in this step. A matrix that is much too large
    /// makes a first correction small, wherever the solution is: the second one tells.
    unproven: bool,
}

/// How the corrections of a multistep formula converge. Its predictions are good, and its equations alike from step
/// to step: the rate of the last one serves to judge the first correction of the next.
#[derive(Clone, Copy)]
pub(super) struct Corrections {
    /// Below this they no longer converge because of rounding.
    rounding: f64,
    rate: f64,
    last: f64,
    count: i32,
}

impl Corrections {
    /// Most corrections: with more a new matrix or a smaller step is cheaper (Hindmarsh 1983).
    const MOST: i32 = 3;
    /// The rate that is assumed where none was seen.
    const UNSEEN: f64 = 0.7;

    pub fn new(rounding: f64) -> Self {
        Self { rounding, rate: Self::UNSEEN, last: 0.0, count: 0 }
    }

    /// Another equation: nothing is known of its rate.
    pub fn forget(&mut self) {
        self.rate = Self::UNSEEN;
    }

    pub fn begin(&mut self) {
        self.count = 0;
    }

    /// Judges a correction of that size: `None` to go on.
    pub fn judge(&mut self, size: f64, enough: f64) -> Option<Result<(), Unsolved>> {
        if !size.is_finite() {
            return Some(Err(Unsolved::Diverged));
        }
        if self.count > 0 {
            self.rate = (0.2 * self.rate).max(size / self.last);
        }
        if size * (1.5 * self.rate).min(1.0) <= enough {
            return Some(Ok(()));
        }
        self.count += 1;
        if self.count == Self::MOST || self.count > 1 && size > 2.0 * self.last {
            return Some(if size <= self.rounding { Ok(()) } else { Err(Unsolved::Diverged) });
        }
        self.last = size;
        None
    }
}

impl Iteration {
    /// One that ends below `enough`; without an error test (`adaptive` false) stages are solved to rounding.
    pub fn new(enough: f64, rounding: f64, adaptive: bool) -> Self {
        let most = MOST[!adaptive as usize];
        Self { enough, rounding, most, count: 0, last: 0.0, factor: 1.0, slowest: 1.0, unproven: false }
    }

    /// A new Jacobian, of which nothing is known yet.
    pub fn forget(&mut self) {
        (self.slowest, self.factor) = (0.0, 1.0);
    }

    /// A step, with the Jacobian of its start (`here`) or of one before.
    pub fn begin_step(&mut self, here: bool) {
        self.unproven = !here;
    }

    /// The Jacobian is one of the past: what it was good for says less of what it is.
    pub fn doubt(mut self, here: bool) -> Self {
        if !here {
            self.factor = self.factor.max(DOUBT);
        }
        self
    }

    /// The Jacobian serves well.
    pub fn quick(&self) -> bool {
        self.slowest <= 1e-2
    }

    /// Judges a correction of that size: `None` to go on.
    pub fn judge(&mut self, size: f64) -> Option<Result<(), Unsolved>> {
        if !size.is_finite() {
            return Some(Err(Unsolved::Diverged));
        }
        if self.count > 0 {
            let rate = size / self.last;
            if rate >= 1.0 {
                return Some(if size <= self.rounding { Ok(()) } else { Err(Unsolved::Diverged) });
            }
            self.slowest = self.slowest.max(rate);
            self.unproven = false;
            self.factor = rate / (1.0 - rate);
            // What the iterations that are left can do at this rate.
            let hopeless = self.factor * size * rate.powi(self.most - 1 - self.count) > self.enough;
            if size > self.rounding
                && (hopeless || self.count + 1 == self.most)
                && self.factor * size > self.enough
            {
                return Some(Err(Unsolved::Diverged));
            }
        }
        let proven = !self.unproven || size <= self.rounding;
        if proven && self.factor * size <= self.enough || self.count + 1 == self.most {
            return Some(Ok(()));
        }
        self.count += 1;
        self.last = size;
        None
    }

    /// Starts the next iteration with what one has shown.
    pub fn learn(&mut self, from: &Self) {
        // To rounding, every iteration has to show its own convergence.
        let rounding = self.most == MOST[1];
        self.factor = if rounding { 1.0 } else { from.factor.max(f64::EPSILON).powf(0.8) };
        (self.slowest, self.unproven) = (from.slowest, from.unproven);
    }
}
