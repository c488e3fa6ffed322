//! The derivatives of f: given by the system, else by differences.

use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::system::{OutOfDomain, System};
use num_traits::{One, Zero};
use std::ops::{Index, IndexMut};

/// df_i/dy_j, to be written at `[(i, j)]`. It is zero where nothing is written.
pub struct Jacobian<'m, T> {
    n: usize,
    entries: &'m mut [T],
}

impl<'m, T: Scalar> Jacobian<'m, T> {
    pub(crate) fn zero(n: usize, entries: &'m mut [T]) -> Self {
        entries.fill(T::zero());
        Self { n, entries }
    }
}

impl<T> Index<(usize, usize)> for Jacobian<'_, T> {
    type Output = T;
    fn index(&self, (i, j): (usize, usize)) -> &T {
        &self.entries[i + j * self.n]
    }
}

impl<T> IndexMut<(usize, usize)> for Jacobian<'_, T> {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut T {
        &mut self.entries[i + j * self.n]
    }
}

/// What the stage solver spent in an attempt.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Effort {
    pub evaluations: u64,
    pub jacobians: u64,
    pub factorizations: u64,
    pub iterations: u64,
    /// The highest order, of a family that chooses it.
    pub order: usize,
}

/// The Jacobian by forward differences, one evaluation a column, into `entries` column after column.
///
/// `slope` is f(t, y), `weights` are one over the sizes that matter, `h` is the step. A component changes by the
/// root of the spacing of numbers times its size, or, where it is near zero, by what rounding in f leaves of
/// its change in a step (CVODE's choice: Hindmarsh et al. 2005, ACM TOMS 31, 363, section 2.1). Units of y and
/// of t make no difference.
#[allow(clippy::too_many_arguments)] // a system, where it is, and room
pub(crate) fn by_differences<Y: State>(
    system: &mut dyn System<Y>,
    t: RealOf<Y>,
    y: &mut Y,
    slope: &Y,
    changed: &mut Y,
    weights: &Y,
    h: RealOf<Y>,
    entries: &mut [Y::Scalar],
    effort: &mut Effort,
) -> Result<(), OutOfDomain> {
    let n = slope.as_slice().len();
    let real = RealOf::<Y>::from_f64;
    let root = real(RealOf::<Y>::EPSILON.to_f64().sqrt());
    // The largest slope in units of what matters, times the step: what one step moves, or 1 at rest.
    let mut moves = RealOf::<Y>::zero();
    for (&f, &w) in slope.as_slice().iter().zip(weights.as_slice()) {
        moves = moves.maximum((f.scale(h.modulus()) * w).modulus());
    }
    let moves = if moves > RealOf::<Y>::zero() && moves.finite() { moves } else { RealOf::<Y>::one() };
    let least = real(1e3 * n as f64) * RealOf::<Y>::EPSILON * moves;
    for (j, column) in entries.chunks_exact_mut(n).enumerate() {
        let was = y.as_slice()[j];
        let size = RealOf::<Y>::one() / weights.as_slice()[j].modulus();
        let mut delta = (root * was.modulus()).maximum(least * size);
        // Towards where the solution goes: there f is defined.
        if ahead(slope.as_slice()[j]) < RealOf::<Y>::zero() {
            delta = -delta;
        }
        let mut done = Err(OutOfDomain);
        for turn in [RealOf::<Y>::one(), -RealOf::<Y>::one()] {
            y.as_mut_slice()[j] = was + Y::Scalar::one().scale(turn * delta);
            effort.evaluations += 1;
            done = system.rhs(t, y, changed);
            if done.is_ok() {
                // The step that was taken, after rounding.
                let per = RealOf::<Y>::one() / signed(y.as_slice()[j] - was, turn * delta);
                for ((entry, &to), &from) in column.iter_mut().zip(changed.as_slice()).zip(slope.as_slice()) {
                    *entry = (to - from).scale(per);
                }
                break;
            }
        }
        y.as_mut_slice()[j] = was;
        done?;
    }
    effort.jacobians += 1;
    Ok(())
}

/// The real part as far as its sign goes: for complex numbers any direction will do.
fn ahead<T: Scalar>(slope: T) -> T::Real {
    let forth = (slope + T::one().scale(slope.modulus())).modulus();
    if forth >= slope.modulus() { slope.modulus() } else { -slope.modulus() }
}

fn signed<T: Scalar>(step: T, like: T::Real) -> T::Real {
    if like < T::Real::zero() { -step.modulus() } else { step.modulus() }
}

/// h df/dt by a difference inside the step of size h from `t` to `end`, into `out`: times may be so short that
/// df/dt alone is beyond the numbers.
pub(crate) fn time_derivative<Y: State>(
    system: &mut dyn System<Y>,
    (t, end): (RealOf<Y>, RealOf<Y>),
    y: &Y,
    slope: &Y,
    out: &mut Y,
    effort: &mut Effort,
) -> Result<(), OutOfDomain> {
    let root = RealOf::<Y>::from_f64(RealOf::<Y>::EPSILON.to_f64().sqrt());
    let ahead = root * t.modulus().maximum((end - t).modulus());
    let at = if end > t { (t + ahead).minimum(end) } else { (t - ahead).maximum(end) };
    effort.evaluations += 1;
    system.rhs(at, y, out)?;
    let per = (end - t) / (at - t);
    for (out, &from) in out.as_mut_slice().iter_mut().zip(slope.as_slice()) {
        *out = (*out - from).scale(per);
    }
    Ok(())
}
