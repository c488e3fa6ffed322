//! The mass matrix M of M y' = f(t, y).

use super::Square;
use super::pattern::Misplaced;
use crate::step::scalar::{Real, Scalar};
use std::collections::BTreeMap;
use std::ops::{Index, IndexMut};

/// M of M y' = f(t, y), to be written at `[(i, j)]`. It is zero where nothing is written.
pub struct Mass<T> {
    n: usize,
    entries: BTreeMap<(usize, usize), T>,
    nothing: T,
}

impl<T: Scalar> Mass<T> {
    pub(crate) fn zero(n: usize) -> Self {
        Self { n, entries: BTreeMap::new(), nothing: T::zero() }
    }

    /// The entries row by row, zeros left out.
    pub(crate) fn constant(self) -> Result<ConstantMass<T>, Misplaced> {
        if let Some(&(row, column)) = self.entries.keys().find(|&&(i, j)| i >= self.n || j >= self.n) {
            return Err(Misplaced { row, column, n: self.n });
        }
        let entries: Vec<_> = self.entries.into_iter().map(|((i, j), x)| (i, j, x)).collect();
        Ok(ConstantMass { entries: entries.into_iter().filter(|e| !e.2.is_zero()).collect() })
    }
}

impl<T> Index<(usize, usize)> for Mass<T> {
    type Output = T;
    fn index(&self, at: (usize, usize)) -> &T {
        self.entries.get(&at).unwrap_or(&self.nothing)
    }
}

impl<T: Scalar> IndexMut<(usize, usize)> for Mass<T> {
    fn index_mut(&mut self, at: (usize, usize)) -> &mut T {
        self.entries.entry(at).or_insert(T::zero())
    }
}

/// M, complete: (row, column, value) row by row.
#[derive(Clone, Debug)]
pub(crate) struct ConstantMass<T> {
    entries: Vec<(usize, usize, T)>,
}

impl<T: Scalar> ConstantMass<T> {
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + Clone + '_ {
        self.entries.iter().map(|&(i, j, _)| (i, j))
    }

    /// The first entry that is not finite.
    pub fn flaw(&self) -> Option<(usize, usize)> {
        self.entries.iter().find(|(_, _, x)| !x.finite()).map(|&(i, j, _)| (i, j))
    }

    /// `out += a M x`.
    pub fn add_product(&self, out: &mut [T], a: T::Real, x: &[T]) {
        for &(i, j, m) in &self.entries {
            out[i] = out[i] + (m * x[j]).scale(a);
        }
    }

    /// Adds M to a matrix whose pattern holds it.
    pub fn add_to<U: Scalar, Q: Square<U>>(&self, matrix: &mut Q, as_entry: impl Fn(T) -> U) {
        let (layout, entries) = matrix.split();
        for &(i, j, m) in &self.entries {
            if let Some(at) = layout.place(i, j) {
                entries[at] = as_entry(m) + entries[at];
            }
        }
    }

    /// The size of its largest entry.
    pub fn largest(&self) -> f64 {
        self.entries.iter().map(|(_, _, m)| m.modulus().to_f64()).fold(0.0, f64::max)
    }
}
