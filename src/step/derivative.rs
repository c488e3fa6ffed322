//! The Jacobian of a step, and the mass matrix in a residual.

use super::implicit::Solver;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::Unsolved;
use super::system::System;
use crate::linear::{ConstantMass, Jacobian, Square, by_differences};
use num_traits::{One, Zero};

impl<Y: State> Solver<Y> {
    /// Takes the Jacobian at the start of the step.
    pub(super) fn take<S: System<Y>>(
        &mut self,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        y: &Y,
    ) -> Result<(), Unsolved> {
        // Should it fail, there is none.
        (self.here, self.known) = (false, false);
        self.taken = h;
        self.iteration.forget();
        if let Some(coupled) = &mut self.coupled {
            coupled.forget();
        }
        self.factors.iter_mut().for_each(|f| f.hg = RealOf::<Y>::zero());
        let mut given = Jacobian::zero(&mut self.jacobian);
        if system.jacobian(t, y, &mut given) {
            if let Some((row, column)) = given.outside() {
                return Err(Unsolved::OutsidePattern { row, column });
            }
            self.effort.jacobians += 1;
            self.noise = RealOf::<Y>::EPSILON;
        } else {
            // A difference is good to half the digits.
            self.noise = RealOf::<Y>::from_f64(RealOf::<Y>::EPSILON.to_f64().sqrt());
            self.slope(system, t, y)?;
            by_differences(
                system,
                t,
                y,
                &self.slope,
                (&mut self.time, &mut self.residual),
                &self.weights,
                h,
                if self.mass.is_some() { RealOf::<Y>::one() } else { RealOf::<Y>::zero() },
                self.groups.as_ref(),
                &mut self.jacobian,
                &mut self.effort,
            )
            .map_err(|_| Unsolved::Domain)?;
        }
        match self.jacobian.entries().iter().position(|x| !x.finite()) {
            Some(at) => Err(Unsolved::Jacobian { component: self.jacobian.layout().row_at(at) }),
            None => {
                (self.here, self.known) = (true, true);
                Ok(())
            }
        }
    }
}

/// `residual -= M slope`.
#[inline(always)]
pub(super) fn subtract<Y: State>(residual: &mut Y, mass: Option<&ConstantMass<Y::Scalar>>, slope: &Y) {
    match mass {
        None => {
            for (r, f) in residual.as_mut_slice().iter_mut().zip(slope.as_slice()) {
                *r = *r - *f;
            }
        }
        Some(mass) => {
            mass.add_product(residual.as_mut_slice(), -RealOf::<Y>::one(), slope.as_slice());
        }
    }
}
