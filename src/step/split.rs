//! A right-hand side in two parts, f = stiff + nonstiff, for IMEX pairs.

use super::state::{RealOf, State};
use super::system::{OutOfDomain, System, Verdict};
use crate::linear::Jacobian;

/// Two closures `|t, y, dy|` whose sum is f. [`solve_split`](crate::solve_split) makes it.
pub struct Split<F, G, Y> {
    stiff: F,
    nonstiff: G,
    /// Room for one part while the sum is made.
    part: Y,
}

impl<F, G, Y: State> Split<F, G, Y> {
    pub(crate) fn new(stiff: F, nonstiff: G, y: &Y) -> Self {
        Self { stiff, nonstiff, part: y.clone() }
    }
}

impl<Y, R1, R2, F, G> System<Y> for Split<F, G, Y>
where
    Y: State,
    R1: Verdict,
    R2: Verdict,
    F: FnMut(RealOf<Y>, &Y, &mut Y) -> R1,
    G: FnMut(RealOf<Y>, &Y, &mut Y) -> R2,
{
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        (self.stiff)(t, y, dy).verdict()?;
        (self.nonstiff)(t, y, &mut self.part).verdict()?;
        for (dy, &part) in dy.as_mut_slice().iter_mut().zip(self.part.as_slice()) {
            *dy = *dy + part;
        }
        Ok(())
    }
    fn is_split(&self) -> bool {
        true
    }
    fn stiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        (self.stiff)(t, y, dy).verdict()
    }
    fn nonstiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        (self.nonstiff)(t, y, dy).verdict()
    }
}

/// The stiff part of a system, for the stages that solve for it.
pub(super) struct Stiff<'s, Y>(pub &'s mut dyn System<Y>);

impl<Y: State> System<Y> for Stiff<'_, Y> {
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.0.stiff(t, y, dy)
    }
    fn jacobian(&mut self, t: RealOf<Y>, y: &Y, j: &mut Jacobian<Y::Scalar>) -> bool {
        self.0.stiff_jacobian(t, y, j)
    }
    fn is_split(&self) -> bool {
        self.0.is_split()
    }
    fn nonstiff(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.0.nonstiff(t, y, dy)
    }
}
