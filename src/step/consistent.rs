//! How M y' = f(t, y) with a singular M starts: the slope, which M does not give in every direction, and whether y
//! fulfils the algebraic equations.

use super::derivative::subtract;
use super::implicit::{Solver, finite};
use super::norm::Tolerance;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::Unsolved;
use super::system::System;
use crate::linear::{ConstantMass, Square, factor_shifted, time_derivative};
use num_traits::{One, Zero};

/// Why a run cannot start.
pub(crate) enum Astray {
    Unsolved(Unsolved),
    /// The equation of this row is off by that much.
    Inconsistent {
        row: usize,
        residual: f64,
    },
}

impl From<Unsolved> for Astray {
    fn from(why: Unsolved) -> Self {
        Astray::Unsolved(why)
    }
}

/// Most iterations towards a consistent start.
const MOST: usize = 50;

impl<Y: State> Solver<Y> {
    /// The slope F with M F = f(t, y) that stays on the algebraic equations. They must hold to the tolerance;
    /// with `mend`, Newton's iteration changes y until they do, M y held.
    ///
    /// One step of the linearly implicit Euler method, far too short to move what moves by itself, does both:
    /// `(M - d J) F = f` makes d F the Newton correction of y on the equations that M does not see, and with M F
    /// for f on the right, which fulfils them, and d df/dt beside it F is the slope.
    pub fn enter<S: System<Y>>(
        &mut self,
        system: &mut S,
        mass: &ConstantMass<Y::Scalar>,
        (t, end): (RealOf<Y>, RealOf<Y>),
        y: &mut Y,
        tolerance: &Tolerance<RealOf<Y>>,
        mend: bool,
    ) -> Result<Y, Astray> {
        let weight = |y: &Y, i: usize| {
            let (rtol, atol) = tolerance.at(i);
            RealOf::<Y>::one() / (atol + rtol * y.as_slice()[i].modulus())
        };
        let norm = |y: &Y, x: &Y| {
            let each = x.as_slice().iter().enumerate().map(|(i, x)| (x.modulus() * weight(y, i)).to_f64());
            each.fold(0.0, f64::max)
        };
        let (mut matrix, mut slope) = (self.jacobian.clone(), y.clone());
        let span = (end - t).modulus().to_f64();
        let mut turns = 0;
        let (d, lasts) = loop {
            self.weigh(y, RealOf::<Y>::zero());
            self.restart();
            self.take(system, t, end - t, y)?;
            self.slope(system, t, y)?;
            let moves = norm(y, &self.slope) / mass.largest();
            // The time in which y would change by its own size, or by its tolerance where that is more.
            let lasts = norm(y, y).max(1.0) / moves;
            let lasts = if lasts < span { lasts } else { span };
            let d = (1e-10 * lasts).min(1e-2 / moves);
            let d = RealOf::<Y>::from_f64(if end > t { d } else { -d });
            let singular = |component| Unsolved::Singular { component };
            factor_shifted(&mut matrix, &self.jacobian, Some(mass), |m| m, |j| j.scale(-d))
                .map_err(singular)?;
            slope.as_mut_slice().copy_from_slice(self.slope.as_slice());
            matrix.solve(slope.as_mut_slice());
            finite(&slope)?;
            let correction = norm(y, &slope) * d.modulus().to_f64();
            // A start that is asked for is found to well below the tolerance.
            if correction <= if mend && turns > 0 { 1e-2 } else { 1.0 } {
                break (d, lasts);
            }
            if !mend || turns == MOST || !correction.is_finite() {
                self.residual.as_mut_slice().copy_from_slice(self.slope.as_slice());
                subtract(&mut self.residual, Some(mass), &slope);
                let size = |i: &usize| self.residual.as_slice()[*i].modulus().to_f64();
                let n = self.residual.as_slice().len();
                let row = (0..n).max_by(|i, j| size(i).total_cmp(&size(j))).unwrap_or(0);
                return Err(Astray::Inconsistent { row, residual: size(&row) });
            }
            for (y, f) in y.as_mut_slice().iter_mut().zip(slope.as_slice()) {
                *y = *y + f.scale(d);
            }
            turns += 1;
        };
        let ahead = RealOf::<Y>::from_f64(if end > t { 1e-2 * lasts } else { -1e-2 * lasts });
        time_derivative(system, (t, t + ahead), y, &self.slope, &mut self.time, &mut self.effort)
            .map_err(|_| Unsolved::Domain)?;
        finite(&self.time)?;
        let right = self.residual.as_mut_slice();
        let share = if (t + ahead) == t { RealOf::<Y>::zero() } else { d / ahead };
        for (right, time) in right.iter_mut().zip(self.time.as_slice()) {
            *right = time.scale(share);
        }
        mass.add_product(right, RealOf::<Y>::one(), slope.as_slice());
        matrix.solve(right);
        slope.as_mut_slice().copy_from_slice(right);
        finite(&slope)?;
        self.restart();
        Ok(slope)
    }
}
