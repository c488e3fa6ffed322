//! The derivatives of f: given by the system, else by differences.

use super::Square;
use super::pattern::Pattern;
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::system::{OutOfDomain, System};
use num_traits::{One, Zero};
use std::ops::{Index, IndexMut};
use std::sync::Arc;

/// df_i/dy_j, to be written at `[(i, j)]`. It is zero where nothing is written. Where the problem has a
/// [`Pattern`], a value other than zero outside it stops the run.
pub struct Jacobian<'m, T> {
    layout: Layout<'m>,
    entries: &'m mut [T],
    /// What was last written outside the pattern, and where.
    stray: T,
    stray_at: (usize, usize),
    /// Where the first value other than zero was.
    outside: Option<(usize, usize)>,
    nothing: T,
}

/// Where a matrix keeps its entries.
#[derive(Clone, Copy)]
pub enum Layout<'m> {
    /// Entry (i, j) at `i + j n`.
    Dense {
        n: usize,
    },
    In(&'m Pattern),
}

impl Layout<'_> {
    /// Where the entry is stored, if it can be other than zero.
    #[inline(always)]
    pub(crate) fn place(&self, row: usize, column: usize) -> Option<usize> {
        match self {
            Layout::Dense { n } => (row < *n && column < *n).then(|| row + column * n),
            Layout::In(pattern) => pattern.place(row, column),
        }
    }

    pub(crate) fn row_at(&self, place: usize) -> usize {
        match self {
            Layout::Dense { n } => place % n,
            Layout::In(pattern) => pattern.row_at(place),
        }
    }
}

impl<'m, T: Scalar> Jacobian<'m, T> {
    pub(crate) fn zero(matrix: &'m mut impl Square<T>) -> Self {
        let (layout, entries) = matrix.split();
        entries.fill(T::zero());
        let zero = T::zero();
        Self { layout, entries, stray: zero, stray_at: (0, 0), outside: None, nothing: zero }
    }

    fn note_stray(&mut self) {
        if self.outside.is_none() && !self.stray.is_zero() {
            self.outside = Some(self.stray_at);
        }
    }

    /// The first place outside the pattern, or the matrix, where something other than zero was written.
    pub(crate) fn outside(mut self) -> Option<(usize, usize)> {
        self.note_stray();
        self.outside
    }

    #[cold]
    fn stray(&mut self, at: (usize, usize)) -> &mut T {
        self.note_stray();
        (self.stray, self.stray_at) = (T::zero(), at);
        &mut self.stray
    }
}

impl<T> Index<(usize, usize)> for Jacobian<'_, T> {
    type Output = T;
    fn index(&self, (i, j): (usize, usize)) -> &T {
        match self.layout.place(i, j) {
            Some(at) => &self.entries[at],
            None => &self.nothing,
        }
    }
}

impl<T: Scalar> IndexMut<(usize, usize)> for Jacobian<'_, T> {
    #[inline(always)]
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut T {
        match self.layout.place(i, j) {
            Some(at) => &mut self.entries[at],
            None => self.stray((i, j)),
        }
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

/// The Jacobian by forward differences into `matrix`: one evaluation a column, or, with `groups` of columns that
/// share no row, one a group.
///
/// `slope` is f(t, y), `weights` are one over the sizes that matter, `h` is the step. A component changes by the
/// root of the spacing of numbers times its size, or, where it is near zero, by what rounding in f leaves of
/// its change in a step (CVODE's choice: Hindmarsh et al. 2005, ACM TOMS 31, 363, section 2.1), and at least by
/// `least` of the size that matters: an algebraic equation moves in no step. Units of y and of t make no
/// difference.
#[allow(clippy::too_many_arguments)] // a system, where it is, and room
pub(crate) fn by_differences<Y: State>(
    system: &mut dyn System<Y>,
    t: RealOf<Y>,
    y: &Y,
    slope: &Y,
    (moved, changed): (&mut Y, &mut Y),
    weights: &Y,
    h: RealOf<Y>,
    least: RealOf<Y>,
    groups: Option<&Groups>,
    matrix: &mut Y::Square,
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
    let least = (real(1e3 * n as f64) * RealOf::<Y>::EPSILON * moves).maximum(least);
    let size = |j: usize| {
        let was = y.as_slice()[j];
        let size = RealOf::<Y>::one() / weights.as_slice()[j].modulus();
        let delta = (root * was.modulus()).maximum(least * size);
        // Towards where the solution goes: there f is defined.
        if ahead(slope.as_slice()[j]) < RealOf::<Y>::zero() { -delta } else { delta }
    };
    moved.as_mut_slice().copy_from_slice(y.as_slice());
    let (layout, entries) = matrix.split();
    let mut difference = |columns: &[usize]| -> Result<(), OutOfDomain> {
        let mut done = Err(OutOfDomain);
        for turn in [RealOf::<Y>::one(), -RealOf::<Y>::one()] {
            for &j in columns {
                moved.as_mut_slice()[j] = y.as_slice()[j] + Y::Scalar::one().scale(turn * size(j));
            }
            effort.evaluations += 1;
            done = system.rhs(t, moved, changed);
            if done.is_ok() {
                for &j in columns {
                    // The step that was taken, after rounding.
                    let per = RealOf::<Y>::one() / ahead(moved.as_slice()[j] - y.as_slice()[j]);
                    let entry = |i: usize| (changed.as_slice()[i] - slope.as_slice()[i]).scale(per);
                    match groups {
                        None => {
                            let column = &mut entries[j * n..(j + 1) * n];
                            column.iter_mut().enumerate().for_each(|(i, to)| *to = entry(i));
                        }
                        Some(groups) => {
                            for i in groups.pattern.column(j) {
                                if let Some(at) = layout.place(i, j) {
                                    entries[at] = entry(i);
                                }
                            }
                        }
                    }
                }
                break;
            }
        }
        columns.iter().for_each(|&j| moved.as_mut_slice()[j] = y.as_slice()[j]);
        done
    };
    match groups {
        None => (0..n).try_for_each(|j| difference(&[j]))?,
        Some(groups) => groups.columns.iter().try_for_each(|columns| difference(columns))?,
    }
    effort.jacobians += 1;
    Ok(())
}

/// Columns of a pattern whose differences are taken together.
#[derive(Clone)]
pub(crate) struct Groups {
    pattern: Arc<Pattern>,
    columns: Arc<Vec<Vec<usize>>>,
}

impl Groups {
    pub fn of(pattern: &Arc<Pattern>) -> Self {
        Self { pattern: pattern.clone(), columns: Arc::new(pattern.groups()) }
    }

    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    pub fn columns(&self) -> &[Vec<usize>] {
        &self.columns
    }
}

/// The real part as far as its sign goes: for complex numbers any direction will do.
fn ahead<T: Scalar>(slope: T) -> T::Real {
    let forth = (slope + T::one().scale(slope.modulus())).modulus();
    if forth >= slope.modulus() { slope.modulus() } else { -slope.modulus() }
}

/// h df/dt, given or by a difference inside the step of size h from `t` to `end`, into `out`: times may be so short that
/// df/dt alone is beyond the numbers.
pub(crate) fn time_derivative<Y: State>(
    system: &mut dyn System<Y>,
    (t, end): (RealOf<Y>, RealOf<Y>),
    y: &Y,
    slope: &Y,
    out: &mut Y,
    effort: &mut Effort,
) -> Result<(), OutOfDomain> {
    if system.time_derivative(t, y, out) {
        out.as_mut_slice().iter_mut().for_each(|x| *x = x.scale(end - t));
        return Ok(());
    }
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
