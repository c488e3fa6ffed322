//! LU factors of a band, with partial pivoting, in place: exchanges of rows widen the upper band by the lower
//! (the storage of LAPACK's `gbtrf`).

use crate::step::scalar::Scalar;
use num_traits::Zero;

/// # Errors
/// The first column without a pivot.
pub fn factor<T: Scalar>(
    n: usize,
    (lower, upper): (usize, usize),
    a: &mut [T],
    pivots: &mut [usize],
) -> Result<(), usize> {
    // For a width the compiler knows, the short loops over it are unrolled.
    match (lower, upper) {
        (1, 1) => factor_width(n, 1, 1, a, pivots),
        (2, 2) => factor_width(n, 2, 2, a, pivots),
        (3, 3) => factor_width(n, 3, 3, a, pivots),
        _ => factor_width(n, lower, upper, a, pivots),
    }
}

#[inline(always)]
fn factor_width<T: Scalar>(
    n: usize,
    lower: usize,
    upper: usize,
    a: &mut [T],
    pivots: &mut [usize],
) -> Result<(), usize> {
    let (stride, diagonal) = (2 * lower + upper + 1, lower + upper);
    // The last column that the rows exchanged so far reach.
    let mut reach = 0;
    for k in 0..n {
        let below = lower.min(n - 1 - k);
        let (left, right) = a.split_at_mut((k + 1) * stride);
        let column = &mut left[k * stride + diagonal..][..lower + 1];
        let (mut p, mut largest) = (0, column[0].modulus());
        for (i, x) in column.iter().enumerate().take(below + 1).skip(1) {
            let size = x.modulus();
            if size > largest {
                (p, largest) = (i, size);
            }
        }
        // A NaN is not above zero either.
        if !(largest > T::Real::zero() && largest.finite()) {
            return Err(k);
        }
        pivots[k] = p;
        reach = (k + upper + p).min(n - 1).max(reach);
        column.swap(0, p);
        // The diagonal keeps the inverse: a solve then only multiplies.
        let inverse = T::one() / column[0];
        column[0] = inverse;
        for x in &mut column[1..] {
            *x = *x * inverse;
        }
        // Row k stands one place higher in each column to the right.
        for (c, to) in right.chunks_exact_mut(stride).take(reach - k).enumerate() {
            let to = &mut to[diagonal - c - 1..][..lower + 1];
            to.swap(0, p);
            let by = to[0];
            for (x, &l) in to[1..].iter_mut().zip(&column[1..]) {
                *x = *x - l * by;
            }
        }
    }
    Ok(())
}

/// Solves with the factors.
pub fn solve<T: Scalar>(n: usize, (lower, upper): (usize, usize), a: &[T], pivots: &[usize], x: &mut [T]) {
    match (lower, upper) {
        (1, 1) => solve_width(n, 1, 1, a, pivots, x),
        (2, 2) => solve_width(n, 2, 2, a, pivots, x),
        (3, 3) => solve_width(n, 3, 3, a, pivots, x),
        _ => solve_width(n, lower, upper, a, pivots, x),
    }
}

#[inline(always)]
fn solve_width<T: Scalar>(n: usize, lower: usize, upper: usize, a: &[T], pivots: &[usize], x: &mut [T]) {
    let (stride, diagonal) = (2 * lower + upper + 1, lower + upper);
    let columns = a.chunks_exact(stride);
    // Each column's exchange comes right before its elimination, as in the factorization.
    for (k, (column, &p)) in columns.clone().zip(&pivots[..n]).enumerate() {
        let end = (k + lower + 1).min(n);
        let x = &mut x[k..end];
        x.swap(0, p);
        let by = x[0];
        for (x, &l) in x[1..].iter_mut().zip(&column[diagonal + 1..]) {
            *x = *x - l * by;
        }
    }
    for (k, column) in columns.enumerate().rev() {
        let by = x[k] * column[diagonal];
        x[k] = by;
        let above = diagonal.min(k);
        for (x, &u) in x[k - above..k].iter_mut().zip(&column[diagonal - above..diagonal]) {
            *x = *x - u * by;
        }
    }
}
