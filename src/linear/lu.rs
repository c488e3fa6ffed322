//! LU factors with partial pivoting, in place, column by column. For a constant n the compiler unrolls it.

use crate::step::scalar::Scalar;
use num_traits::Zero;

/// # Errors
/// The first column without a pivot.
#[inline(always)]
pub fn factor<T: Scalar>(n: usize, a: &mut [T], pivots: &mut [usize]) -> Result<(), usize> {
    for k in 0..n {
        let (mut p, mut largest) = (k, a[k + k * n].modulus());
        for i in k + 1..n {
            let size = a[i + k * n].modulus();
            if size > largest {
                (p, largest) = (i, size);
            }
        }
        // A NaN is not above zero either.
        if !(largest > T::Real::zero() && largest.finite()) {
            return Err(k);
        }
        pivots[k] = p;
        if p != k {
            for j in 0..n {
                a.swap(k + j * n, p + j * n);
            }
        }
        // The diagonal keeps the inverse: a solve then only multiplies.
        let inverse = T::one() / a[k + k * n];
        a[k + k * n] = inverse;
        for i in k + 1..n {
            a[i + k * n] = a[i + k * n] * inverse;
        }
        let (left, right) = a.split_at_mut((k + 1) * n);
        let below = &left[k * n + k + 1..];
        for column in right.chunks_exact_mut(n) {
            let by = column[k];
            for (x, &l) in column[k + 1..].iter_mut().zip(below) {
                *x = *x - l * by;
            }
        }
    }
    Ok(())
}

/// Whether a matrix has a negative determinant, by its pivots, as many of them inverse as there are, and by whether the
/// rows of each changed places. A complex one has none.
pub fn negative<T: Scalar>(pivots: impl Iterator<Item = (T, bool)>) -> bool {
    pivots.fold(false, |odd, (pivot, swapped)| odd ^ swapped ^ (pivot == -T::one().scale(pivot.modulus())))
}

/// Solves with the factors.
#[inline(always)]
pub fn solve<T: Scalar>(n: usize, a: &[T], pivots: &[usize], x: &mut [T]) {
    // All exchanges first: those of later columns moved the rows of the earlier ones too.
    for (k, &pivot) in pivots[..n].iter().enumerate() {
        x.swap(k, pivot);
    }
    for k in 0..n {
        let by = x[k];
        for i in k + 1..n {
            x[i] = x[i] - a[i + k * n] * by;
        }
    }
    for k in (0..n).rev() {
        let by = x[k] * a[k + k * n];
        x[k] = by;
        for i in 0..k {
            x[i] = x[i] - a[i + k * n] * by;
        }
    }
}
