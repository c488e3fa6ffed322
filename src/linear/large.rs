//! A matrix of a size known at run time, on the heap: dense, banded or sparse, as its pattern says.

use super::pattern::{Pattern, Shape};
use super::{Square, band, faer_lu, jacobian::Layout, lu};
use crate::step::scalar::Scalar;
use std::sync::Arc;

/// Of a size known at run time, on the heap.
pub struct Large<T> {
    pattern: Arc<Pattern>,
    entries: Vec<T>,
    /// Of `entries` in place, or beside them; none of a matrix that was never factored.
    factors: Option<Factors<T>>,
}

enum Factors<T> {
    InPlace { pivots: Vec<usize> },
    Beside(Box<dyn Factorize<T>>),
}

/// A factorization that keeps its factors.
pub(super) trait Factorize<T>: Send + Sync {
    /// # Errors
    /// The column without a pivot.
    fn factor(&mut self, entries: &[T]) -> Result<(), usize>;
    fn solve(&mut self, x: &mut [T]);
    fn again(&self) -> Box<dyn Factorize<T>>;
}

impl<T: Scalar> Clone for Large<T> {
    fn clone(&self) -> Self {
        let factors = self.factors.as_ref().map(|factors| match factors {
            Factors::InPlace { pivots } => Factors::InPlace { pivots: pivots.clone() },
            Factors::Beside(lu) => Factors::Beside(lu.again()),
        });
        Self { pattern: self.pattern.clone(), entries: self.entries.clone(), factors }
    }
}

/// From this many rows on faer's dense factors are the quicker ones (measured).
const BLOCKED: usize = 48;

impl<T: Scalar> Large<T> {
    fn room(&self) -> Option<Factors<T>> {
        let n = self.pattern.n();
        let own = match self.pattern.shape() {
            Shape::Dense => n < BLOCKED || !faer_lu::knows::<T>(),
            Shape::Banded { .. } => true,
            Shape::Sparse { .. } => false,
        };
        if own {
            return Some(Factors::InPlace { pivots: vec![0; n] });
        }
        faer_lu::room(&self.pattern).map(Factors::Beside)
    }
}

impl<T: Scalar> Square<T> for Large<T> {
    fn new(pattern: &Arc<Pattern>) -> Self {
        // faer alone factors sparse matrices; numbers it does not know are kept in the band around them.
        let sparse = matches!(pattern.shape(), Shape::Sparse { .. });
        let pattern =
            if sparse && !faer_lu::knows::<T>() { Arc::new(pattern.as_band()) } else { pattern.clone() };
        Self { entries: vec![T::zero(); pattern.stored()], pattern, factors: None }
    }
    fn layout(&self) -> Layout<'_> {
        Layout::In(&self.pattern)
    }
    fn entries(&self) -> &[T] {
        &self.entries
    }
    fn split(&mut self) -> (Layout<'_>, &mut [T]) {
        (Layout::In(&self.pattern), &mut self.entries)
    }
    fn add_identity(&mut self) {
        let add = |entry: &mut T| *entry = T::one() + *entry;
        match self.pattern.shape() {
            Shape::Dense => self.entries.iter_mut().step_by(self.pattern.n() + 1).for_each(add),
            Shape::Banded { lower, upper } => {
                self.entries.iter_mut().skip(lower + upper).step_by(2 * lower + upper + 1).for_each(add);
            }
            Shape::Sparse { .. } => {
                let diagonal = (0..self.pattern.n()).filter_map(|i| self.pattern.place(i, i));
                diagonal.for_each(|at| add(&mut self.entries[at]));
            }
        }
    }
    fn factor(&mut self) -> Result<(), usize> {
        if self.factors.is_none() {
            self.factors = self.room();
        }
        let n = self.pattern.n();
        match (&mut self.factors, self.pattern.shape()) {
            (Some(Factors::InPlace { pivots }), Shape::Banded { lower, upper }) => {
                band::factor(n, (*lower, *upper), &mut self.entries, pivots)
            }
            (Some(Factors::InPlace { pivots }), _) => lu::factor(n, &mut self.entries, pivots),
            (Some(Factors::Beside(lu)), _) => lu.factor(&self.entries),
            (None, _) => Err(0),
        }
    }
    fn solve(&mut self, x: &mut [T]) {
        let n = self.pattern.n();
        match (&mut self.factors, self.pattern.shape()) {
            (Some(Factors::InPlace { pivots }), Shape::Banded { lower, upper }) => {
                band::solve(n, (*lower, *upper), &self.entries, pivots, x);
            }
            (Some(Factors::InPlace { pivots }), _) => lu::solve(n, &self.entries, pivots, x),
            (Some(Factors::Beside(lu)), _) => lu.solve(x),
            (None, _) => {}
        }
    }
    fn negative(&self) -> bool {
        let Some(Factors::InPlace { pivots }) = &self.factors else { return false };
        let n = self.pattern.n();
        match self.pattern.shape() {
            Shape::Banded { lower, upper } => {
                let stride = 2 * lower + upper + 1;
                let diagonal = self.entries.iter().skip(lower + upper).step_by(stride).copied();
                lu::negative(diagonal.zip(pivots.iter().map(|&p| p != 0)))
            }
            _ => {
                let diagonal = self.entries.iter().step_by(n + 1).copied();
                lu::negative(diagonal.zip(pivots.iter().enumerate().map(|(k, &p)| p != k)))
            }
        }
    }
}
