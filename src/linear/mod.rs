//! Jacobians and the linear systems of implicit stages: small ones on the stack, large ones on the heap.

mod band;
mod detect;
mod dual;
mod eigen;
mod faer_lu;
mod jacobian;
mod large;
mod lu;
mod mass;
mod pair;
mod pattern;

pub(crate) use detect::detect;
pub use dual::{Dual, Field};
pub(crate) use eigen::{Eigen, roots};
pub(crate) use jacobian::{Effort, Groups, by_differences, time_derivative};
pub use jacobian::{Jacobian, Layout};
pub use large::Large;
pub(crate) use lu::{factor, solve};
pub(crate) use mass::ConstantMass;
pub use mass::Mass;
pub use pair::Pair;
pub use pattern::{Misplaced, Pattern};

use crate::step::scalar::Scalar;
use std::sync::Arc;

/// A square matrix, and in its place or beside it its LU factors.
pub trait Square<T: Scalar>: Clone {
    /// Zeros.
    fn new(pattern: &Arc<Pattern>) -> Self;
    /// Where the entries are.
    fn layout(&self) -> Layout<'_>;
    /// Those that are stored, column after column; places of a band outside the matrix are zero.
    fn entries(&self) -> &[T];
    fn split(&mut self) -> (Layout<'_>, &mut [T]);
    fn add_identity(&mut self);
    /// Factors it.
    ///
    /// # Errors
    /// The column without a pivot: the matrix is singular, or not finite.
    fn factor(&mut self) -> Result<(), usize>;
    /// Solves for a right-hand side, in place, after [`factor`](Self::factor).
    fn solve(&mut self, x: &mut [T]);
    /// Whether the determinant of the matrix last factored is negative. That of a complex matrix is not, and that of
    /// one whose factors keep no pivots in the order of its columns counts as positive.
    fn negative(&self) -> bool;
}

/// Calls `with` for all entries that can be other than zero: a column, a row, and the entries from there downwards.
pub(crate) fn each_run<T: Scalar>(matrix: &impl Square<T>, mut with: impl FnMut(usize, usize, &[T])) {
    let entries = matrix.entries();
    match matrix.layout() {
        Layout::Dense { n } => {
            entries.chunks_exact(n.max(1)).enumerate().for_each(|(j, column)| with(j, 0, column));
        }
        Layout::In(pattern) => {
            for j in 0..pattern.n() {
                for (row, places) in pattern.runs(j) {
                    with(j, row, &entries[places]);
                }
            }
        }
    }
}

/// What is known of the matrices of a problem before it runs.
#[derive(Clone)]
pub(crate) struct Known<T> {
    /// Of the Jacobian and the mass matrix; `None` where it is dense.
    pub groups: Option<Groups>,
    pub pattern: Arc<Pattern>,
    /// `None` for the identity.
    pub mass: Option<Arc<ConstantMass<T>>>,
}

impl<T: Scalar> Known<T> {
    pub fn new(n: usize, pattern: Option<Pattern>, mass: Option<ConstantMass<T>>) -> Self {
        let widened = pattern.map(|pattern| match &mass {
            Some(mass) => Arc::new(pattern.with(mass.places())),
            None => Arc::new(pattern),
        });
        Self {
            groups: widened.as_ref().map(Groups::of),
            pattern: widened.unwrap_or_else(|| Arc::new(Pattern::dense(n))),
            mass: mass.map(Arc::new),
        }
    }
}

/// Makes `matrix` the factors of M - hg J; without a mass matrix M is the identity. `as_entry` takes an entry of
/// M over, `scaled` the product of one of J and -hg.
///
/// # Errors
/// The column without a pivot.
pub(crate) fn factor_shifted<T: Scalar, U: Scalar>(
    matrix: &mut impl Square<U>,
    jacobian: &impl Square<T>,
    mass: Option<&ConstantMass<T>>,
    as_entry: impl Fn(T) -> U,
    scaled: impl Fn(T) -> U,
) -> Result<(), usize> {
    for (to, &from) in matrix.split().1.iter_mut().zip(jacobian.entries()) {
        *to = scaled(from);
    }
    match mass {
        None => matrix.add_identity(),
        Some(mass) => mass.add_to(matrix, as_entry),
    }
    matrix.factor()
}

/// N by N on the stack.
#[derive(Clone, Debug)]
pub struct Small<T, const N: usize> {
    columns: [[T; N]; N],
    pivots: [usize; N],
}

impl<T: Scalar, const N: usize> Square<T> for Small<T, N> {
    fn new(_: &Arc<Pattern>) -> Self {
        Self { columns: [[T::zero(); N]; N], pivots: [0; N] }
    }
    #[inline(always)]
    fn layout(&self) -> Layout<'_> {
        Layout::Dense { n: N }
    }
    #[inline(always)]
    fn entries(&self) -> &[T] {
        self.columns.as_flattened()
    }
    #[inline(always)]
    fn split(&mut self) -> (Layout<'_>, &mut [T]) {
        (Layout::Dense { n: N }, self.columns.as_flattened_mut())
    }
    #[inline(always)]
    fn add_identity(&mut self) {
        for entry in self.columns.as_flattened_mut().iter_mut().step_by(N + 1) {
            *entry = T::one() + *entry;
        }
    }
    fn factor(&mut self) -> Result<(), usize> {
        lu::factor(N, self.columns.as_flattened_mut(), &mut self.pivots)
    }
    fn solve(&mut self, x: &mut [T]) {
        if let Some(x) = x.first_chunk_mut::<N>() {
            lu::solve(N, self.columns.as_flattened(), &self.pivots, x);
        }
    }
    fn negative(&self) -> bool {
        let swapped = self.pivots.iter().enumerate().map(|(k, &p)| p != k);
        lu::negative((0..N).map(|k| self.columns[k][k]).zip(swapped))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex;

    /// Solves A x = b for a matrix with a zero in its first pivot, and looks at A x - b.
    fn residual<T: Scalar, S: Square<T>>(n: usize, entry: impl Fn(usize, usize) -> T) -> f64 {
        let mut matrix = S::new(&Arc::new(Pattern::dense(n)));
        for j in 0..n {
            for i in 0..n {
                matrix.split().1[i + j * n] = entry(i, j);
            }
        }
        let whole = matrix.clone();
        let b: Vec<T> = (0..n).map(|i| entry(i, (i + 1) % n)).collect();
        let mut x = b.clone();
        matrix.factor().unwrap();
        matrix.solve(&mut x);
        let mut worst = 0.0f64;
        for (i, &b) in b.iter().enumerate() {
            let ax = (0..n).fold(T::zero(), |s, j| s + whole.entries()[i + j * n] * x[j]);
            worst = worst.max(crate::step::scalar::Real::to_f64((ax - b).modulus()));
        }
        worst
    }

    /// Large entries stand beside the diagonal, so that rows change places in every column.
    fn wave(n: usize) -> impl Fn(usize, usize) -> f64 {
        move |i, j| 0.3 * ((3 * i + 7 * j * j) as f64).sin() + if (i + 1) % n == j { 4.0 } else { 0.0 }
    }

    #[test]
    fn a_system_is_solved_to_rounding() {
        assert!(residual::<f64, Small<f64, 1>>(1, |_, _| 3.0) < 1e-15);
        assert!(residual::<f64, Small<f64, 3>>(3, wave(3)) < 1e-14);
        assert!(residual::<f64, Small<f64, 8>>(8, wave(8)) < 1e-13);
        assert!(residual::<f64, Large<f64>>(40, wave(40)) < 1e-12);
        let turned = |i, j| Complex::new(wave(9)(i, j), wave(9)(j + 1, i));
        assert!(residual::<Complex<f64>, Large<Complex<f64>>>(9, turned) < 1e-13);
    }

    /// Solves A x = b for a pattern whose diagonal is small, so that rows change places, and looks at A x - b.
    fn residual_in<T: Scalar>(pattern: Pattern, entry: impl Fn(usize, usize) -> T) -> f64 {
        let n = pattern.n();
        let mut matrix = Large::<T>::new(&Arc::new(pattern.clone()));
        for j in 0..n {
            for i in pattern.column(j) {
                let (layout, entries) = matrix.split();
                entries[layout.place(i, j).unwrap()] = entry(i, j);
            }
        }
        let mut worst = 0.0f64;
        // A second factorization in the room of the first.
        for turn in 0..2 {
            let b: Vec<T> = (0..n).map(|i| entry(i, (3 * i + turn) % n.max(1))).collect();
            let (mut factors, mut x) = (matrix.clone(), b.clone());
            if turn == 1 {
                factors.factor().unwrap();
                let (_, entries) = factors.split();
                entries.copy_from_slice(matrix.entries());
            }
            factors.factor().unwrap();
            factors.clone().solve(&mut x);
            let mut ax = vec![T::zero(); n];
            for (j, &x) in x.iter().enumerate() {
                pattern.column(j).for_each(|i| ax[i] = ax[i] + entry(i, j) * x);
            }
            for (ax, b) in ax.into_iter().zip(b) {
                worst = worst.max(crate::step::scalar::Real::to_f64((ax - b).modulus()));
            }
        }
        worst
    }

    #[test]
    fn every_storage_solves_to_rounding() {
        use crate::tableau::DoubleDouble;
        // Below every third place of the diagonal stands a larger entry.
        let real = |i: usize, j: usize| {
            let large = if i % 3 == 1 && i == j + 1 { 4.0 } else { f64::from(i == j) };
            0.1 * ((3 * i + 7 * j * j) as f64).sin() + large
        };
        let pair = |i, j| Pair { re: real(i, j), im: real(j + 1, i) };
        let turned = |i, j| Complex::new(real(i, j), real(j + 1, i));
        for n in [1, 2, 3, 5, 60] {
            let scattered = (0..n).flat_map(|i| [(i, (7 * i + 3) % n), ((5 * i + 1) % n, i)]);
            let patterns = [
                Pattern::dense(n),
                Pattern::banded(n, 1, 1),
                Pattern::banded(n, 2, 2),
                Pattern::banded(n, 3, 3),
                Pattern::banded(n, 4, 1),
                Pattern::banded(n, 0, 2),
                Pattern::sparse(n, scattered).unwrap(),
            ];
            for pattern in patterns {
                // The dense ones have conditions of a few hundred.
                let what = format!("{n}, {pattern:?}");
                assert!(residual_in::<f64>(pattern.clone(), real) < 1e-12, "{what}");
                assert!(residual_in::<f32>(pattern.clone(), |i, j| real(i, j) as f32) < 1e-3, "{what}");
                assert!(residual_in::<Complex<f64>>(pattern.clone(), turned) < 1e-12, "{what}");
                assert!(residual_in::<Pair<f64>>(pattern.clone(), pair) < 1e-12, "{what}");
                let double = |i, j| DoubleDouble::of(real(i, j));
                assert!(residual_in::<DoubleDouble>(pattern.clone(), double) < 1e-27, "{what}");
            }
        }
    }

    #[test]
    fn a_singular_matrix_is_told_in_every_storage() {
        let n = 60;
        for pattern in [Pattern::dense(n), Pattern::banded(n, 1, 1), Pattern::sparse(n, [(0, 50)]).unwrap()] {
            let mut matrix = Large::<f64>::new(&Arc::new(pattern.clone()));
            matrix.add_identity();
            assert_eq!(matrix.factor(), Ok(()), "{pattern:?}");
            let at = matrix.layout().place(17, 17).unwrap();
            let mut matrix = Large::<f64>::new(&Arc::new(pattern.clone()));
            matrix.add_identity();
            matrix.split().1[at] = 0.0;
            assert!(matrix.factor().is_err(), "{pattern:?}");
            matrix.split().1[at] = f64::NAN;
            assert!(matrix.factor().is_err(), "{pattern:?}");
        }
    }

    #[test]
    fn a_singular_matrix_names_its_column() {
        let mut matrix = Small::<f64, 3>::new(&Arc::new(Pattern::dense(3)));
        matrix.split().1.copy_from_slice(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 1.0, 1.0]);
        assert_eq!(matrix.factor(), Err(1));
        let mut matrix = Large::<f64>::new(&Arc::new(Pattern::dense(2)));
        matrix.split().1.copy_from_slice(&[f64::NAN, 1.0, 1.0, 1.0]);
        assert_eq!(matrix.factor(), Err(0));
    }
}
