//! Exact derivatives of a right-hand side that is generic over its numbers, through dual numbers.

use super::jacobian::{Groups, Jacobian};
use super::pattern::Pattern;
use crate::step::state::State;
use crate::step::system::{OutOfDomain, System};
use num_dual::{Dual64, DualNum};
use std::sync::Arc;

/// f(t, y), written once for numbers and for dual numbers: [`Dual`] makes a system of it that knows df/dy and df/dt
/// exactly.
///
/// ```
/// use kutta::{Dual, DualNum, Field, Ivp, methods::Rodas5p};
///
/// /// Van der Pol (1926).
/// struct Oscillator;
///
/// impl Field for Oscillator {
///     fn rhs<T: DualNum<Primitive = f64> + Copy>(&self, _t: T, y: &[T], dy: &mut [T]) {
///         dy[0] = y[1];
///         dy[1] = (-y[0] * y[0] + 1.0) * y[1] * 1e3 - y[0];
///     }
/// }
///
/// let run = Ivp::new(Dual::of(Oscillator), [2.0, 0.0], 0.0..500.0).with(Rodas5p).run()?;
/// assert!(run.stats.evaluations < 10 * run.stats.accepted + 100);
/// # Ok::<(), kutta::Stopped<[f64; 2]>>(())
/// ```
pub trait Field {
    /// Writes f(t, y) into `dy`. For dual numbers a number stands on the right of an operator: `y * 2.0`.
    fn rhs<T: DualNum<Primitive = f64> + Copy>(&self, t: T, y: &[T], dy: &mut [T]);

    /// Which entries of df/dy can be other than zero, where it is known.
    fn pattern(&self) -> Option<Pattern> {
        None
    }
}

/// A [`Field`] as a system with its Jacobian and its derivative by time: one evaluation in dual numbers a column, or
/// a group of columns that share no row.
pub struct Dual<F> {
    field: F,
    groups: Option<Groups>,
    /// Room for dual numbers.
    y: Vec<Dual64>,
    dy: Vec<Dual64>,
}

impl<F: Field> Dual<F> {
    pub fn of(field: F) -> Self {
        let groups = field.pattern().map(|pattern| Groups::of(&Arc::new(pattern)));
        Self { field, groups, y: vec![], dy: vec![] }
    }

    /// y without derivatives, in dual numbers.
    fn lift(&mut self, y: &[f64]) {
        self.y.clear();
        self.y.extend(y.iter().map(|&y| Dual64::from_re(y)));
        self.dy.resize(y.len(), Dual64::from_re(0.0));
    }
}

impl<Y: State<Scalar = f64>, F: Field> System<Y> for Dual<F> {
    fn rhs(&mut self, t: f64, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.field.rhs(t, y.as_slice(), dy.as_mut_slice());
        Ok(())
    }

    fn jacobian(&mut self, t: f64, y: &Y, j: &mut Jacobian<f64>) -> bool {
        self.lift(y.as_slice());
        let (n, t) = (y.as_slice().len(), Dual64::from_re(t));
        let Self { field, groups, y, dy } = self;
        let groups = groups.as_ref();
        // The derivative along the sum of the columns' coordinates.
        let mut along = |columns: &[usize]| {
            columns.iter().for_each(|&k| y[k].eps = 1.0);
            field.rhs(t, y, dy);
            columns.iter().for_each(|&k| y[k].eps = 0.0);
            for &k in columns {
                match groups {
                    None => (0..n).for_each(|i| j[(i, k)] = dy[i].eps),
                    Some(groups) => groups.pattern().column(k).for_each(|i| j[(i, k)] = dy[i].eps),
                }
            }
        };
        match groups {
            None => (0..n).for_each(|k| along(&[k])),
            Some(groups) => groups.columns().iter().for_each(|columns| along(columns)),
        }
        true
    }

    fn time_derivative(&mut self, t: f64, y: &Y, dfdt: &mut Y) -> bool {
        self.lift(y.as_slice());
        self.field.rhs(Dual64::from_re(t).derivative(), &self.y, &mut self.dy);
        for (to, from) in dfdt.as_mut_slice().iter_mut().zip(&self.dy) {
            *to = from.eps;
        }
        true
    }

    fn pattern(&self) -> Option<Pattern> {
        self.field.pattern()
    }
}
