//! Jacobians and the linear systems of implicit stages: small ones on the stack, large ones on the heap.

mod eigen;
mod jacobian;
mod lu;
mod pair;

pub(crate) use eigen::{Eigen, roots};
pub use jacobian::Jacobian;
pub(crate) use jacobian::{Effort, by_differences, time_derivative};
pub(crate) use lu::{factor, solve};
pub use pair::Pair;

use crate::step::scalar::Scalar;

/// A square matrix, column after column, and in its place its LU factors.
pub trait Square<T: Scalar>: Clone {
    /// Zeros, with room for the pivots.
    fn new(n: usize) -> Self;
    /// Entry (i, j) at `i + j n`.
    fn entries(&self) -> &[T];
    fn entries_mut(&mut self) -> &mut [T];
    /// Factors it in place.
    ///
    /// # Errors
    /// The column without a pivot: the matrix is singular, or not finite.
    fn factor(&mut self) -> Result<(), usize>;
    /// Solves for a right-hand side, in place, after [`factor`](Self::factor).
    fn solve(&self, x: &mut [T]);
}

/// Makes `matrix` the factors of I - hg J.
///
/// # Errors
/// The column without a pivot.
pub(crate) fn factor_shifted<T: Scalar, Q: Square<T>>(
    matrix: &mut Q,
    jacobian: &Q,
    hg: T::Real,
) -> Result<(), usize> {
    for (to, &from) in matrix.entries_mut().iter_mut().zip(jacobian.entries()) {
        *to = from.scale(-hg);
    }
    let n = jacobian.entries().len().isqrt();
    for entry in matrix.entries_mut().iter_mut().step_by(n + 1) {
        *entry = T::one() + *entry;
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
    fn new(_: usize) -> Self {
        Self { columns: [[T::zero(); N]; N], pivots: [0; N] }
    }
    #[inline(always)]
    fn entries(&self) -> &[T] {
        self.columns.as_flattened()
    }
    #[inline(always)]
    fn entries_mut(&mut self) -> &mut [T] {
        self.columns.as_flattened_mut()
    }
    fn factor(&mut self) -> Result<(), usize> {
        lu::factor(N, self.columns.as_flattened_mut(), &mut self.pivots)
    }
    fn solve(&self, x: &mut [T]) {
        if let Some(x) = x.first_chunk_mut::<N>() {
            lu::solve(N, self.columns.as_flattened(), &self.pivots, x);
        }
    }
}

/// Of a size known at run time, on the heap.
#[derive(Clone, Debug)]
pub struct Large<T> {
    entries: Vec<T>,
    pivots: Vec<usize>,
}

impl<T: Scalar> Square<T> for Large<T> {
    fn new(n: usize) -> Self {
        Self { entries: vec![T::zero(); n * n], pivots: vec![0; n] }
    }
    fn entries(&self) -> &[T] {
        &self.entries
    }
    fn entries_mut(&mut self) -> &mut [T] {
        &mut self.entries
    }
    fn factor(&mut self) -> Result<(), usize> {
        lu::factor(self.pivots.len(), &mut self.entries, &mut self.pivots)
    }
    fn solve(&self, x: &mut [T]) {
        lu::solve(self.pivots.len(), &self.entries, &self.pivots, x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex;

    /// Solves A x = b for a matrix with a zero in its first pivot, and looks at A x - b.
    fn residual<T: Scalar, S: Square<T>>(n: usize, entry: impl Fn(usize, usize) -> T) -> f64 {
        let mut matrix = S::new(n);
        for j in 0..n {
            for i in 0..n {
                matrix.entries_mut()[i + j * n] = entry(i, j);
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

    #[test]
    fn a_singular_matrix_names_its_column() {
        let mut matrix = Small::<f64, 3>::new(3);
        matrix.entries_mut().copy_from_slice(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.0, 1.0, 1.0]);
        assert_eq!(matrix.factor(), Err(1));
        let mut matrix = Large::<f64>::new(2);
        matrix.entries_mut().copy_from_slice(&[f64::NAN, 1.0, 1.0, 1.0]);
        assert_eq!(matrix.factor(), Err(0));
    }
}
