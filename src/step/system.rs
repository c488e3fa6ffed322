//! The right-hand side: a closure or a struct.

use super::state::{RealOf, State};
use crate::linear::{Jacobian, Pattern};
use num_traits::Zero;

/// The right-hand side refuses a point (a root of a negative number, a density below zero): the step
/// is retried with a smaller size.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct OutOfDomain;

impl std::fmt::Display for OutOfDomain {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("the right-hand side is not defined at this point")
    }
}

impl std::error::Error for OutOfDomain {}

/// y' = f(t, y), or y'' = f(t, y) for second-order methods, written into `dy`; with a mass matrix M
/// (see [`Ivp::mass`](crate::Ivp::mass)), `dy` is M y'.
///
/// Every closure `|t, y, dy|` is one; it may return nothing or `Result<(), OutOfDomain>`.
pub trait System<Y: State> {
    /// # Errors
    /// [`OutOfDomain`] where f is not defined.
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain>;

    /// Writes df_i/dy_j, where the system knows it, and answers whether it does. Methods for stiff problems
    /// take differences of f otherwise.
    fn jacobian(&mut self, _t: RealOf<Y>, _y: &Y, _j: &mut Jacobian<Y::Scalar>) -> bool {
        false
    }

    /// What [`jacobian`](Self::jacobian) writes is only near df/dy. Methods that iterate take any such matrix,
    /// Rosenbrock methods where their table is proven to keep its orders with it (W-methods).
    fn is_approximate(&self) -> bool {
        false
    }

    /// Writes df_i/dt, where the system knows it, and answers whether it does. Rosenbrock methods take a difference
    /// of f otherwise.
    fn time_derivative(&mut self, _t: RealOf<Y>, _y: &Y, _dfdt: &mut Y) -> bool {
        false
    }

    /// Which entries of df/dy can be other than zero, where the system knows it.
    fn pattern(&self) -> Option<Pattern> {
        None
    }

    /// f is a sum of two parts, of which IMEX pairs treat one implicitly.
    fn is_split(&self) -> bool {
        false
    }

    /// The stiff part. All of f is stiff where a system is not split.
    ///
    /// # Errors
    /// [`OutOfDomain`] where it is not defined.
    fn stiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.rhs(t, y, dy)
    }

    /// The Jacobian of the stiff part, as [`jacobian`](Self::jacobian) gives that of f.
    fn stiff_jacobian(&mut self, t: RealOf<Y>, y: &Y, j: &mut Jacobian<Y::Scalar>) -> bool {
        !self.is_split() && self.jacobian(t, y, j)
    }

    /// The rest, so that `rhs = stiff + nonstiff`.
    ///
    /// # Errors
    /// [`OutOfDomain`] where it is not defined.
    fn nonstiff(&mut self, _t: RealOf<Y>, _y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        dy.as_mut_slice().fill(Y::Scalar::zero());
        Ok(())
    }
}

/// A system with its Jacobian in a closure of its own.
pub struct WithJacobian<S, J> {
    pub(crate) system: S,
    pub(crate) jacobian: J,
    pub(crate) approximate: bool,
}

impl<Y: State, S: System<Y>, J: FnMut(RealOf<Y>, &Y, &mut Jacobian<Y::Scalar>)> System<Y>
    for WithJacobian<S, J>
{
    #[inline(always)]
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.system.rhs(t, y, dy)
    }
    fn jacobian(&mut self, t: RealOf<Y>, y: &Y, j: &mut Jacobian<Y::Scalar>) -> bool {
        // Of a sum it is that of the stiff part.
        let whole = !self.system.is_split();
        if whole {
            (self.jacobian)(t, y, j);
        }
        whole
    }
    fn is_approximate(&self) -> bool {
        self.approximate
    }
    fn is_split(&self) -> bool {
        self.system.is_split()
    }
    fn stiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.system.stiff(t, y, dy)
    }
    fn stiff_jacobian(&mut self, t: RealOf<Y>, y: &Y, j: &mut Jacobian<Y::Scalar>) -> bool {
        (self.jacobian)(t, y, j);
        true
    }
    fn nonstiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.system.nonstiff(t, y, dy)
    }
    fn time_derivative(&mut self, t: RealOf<Y>, y: &Y, dfdt: &mut Y) -> bool {
        self.system.time_derivative(t, y, dfdt)
    }
    fn pattern(&self) -> Option<Pattern> {
        self.system.pattern()
    }
}

/// What a closure may answer: nothing, or whether the point was in the domain.
pub trait Verdict {
    fn verdict(self) -> Result<(), OutOfDomain>;
}

impl Verdict for () {
    #[inline(always)]
    fn verdict(self) -> Result<(), OutOfDomain> {
        Ok(())
    }
}

impl Verdict for Result<(), OutOfDomain> {
    #[inline(always)]
    fn verdict(self) -> Result<(), OutOfDomain> {
        self
    }
}

impl<Y: State, R: Verdict, F: FnMut(RealOf<Y>, &Y, &mut Y) -> R> System<Y> for F {
    #[inline(always)]
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self(t, y, dy).verdict()
    }
}
