//! LU factors of a band, with partial pivoting, in place: exchanges of rows widen the upper band by the lower
//! (the storage of LAPACK's `gbtrf`).
//!
//! The columns of U are divided by their diagonal, which keeps its inverse: in a solve each unknown then waits for
//! one product and one difference of the one before.

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
        let (left, right) = a.split_at_mut((k + 1) * stride);
        let (above, column) = left[k * stride..].split_at_mut(diagonal);
        let (mut p, mut largest) = (0, column[0].modulus());
        // Places below the last row hold zeros.
        for (i, x) in column[..lower + 1].iter().enumerate().skip(1) {
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
        if p != 0 {
            column.swap(0, p);
        }
        let inverse = T::one() / column[0];
        column[0] = inverse;
        for x in &mut column[1..lower + 1] {
            *x = *x * inverse;
        }
        for x in above {
            *x = *x * inverse;
        }
        // Row k stands one place higher in each column to the right.
        for (c, to) in right.chunks_exact_mut(stride).take(reach - k).enumerate() {
            let to = &mut to[diagonal - c - 1..][..lower + 1];
            if p != 0 {
                to.swap(0, p);
            }
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
        (1, 1) => solve_narrow::<T, 1, 2, 4>(n, a, pivots, x),
        (2, 2) => solve_narrow::<T, 2, 4, 7>(n, a, pivots, x),
        (3, 3) => solve_narrow::<T, 3, 6, 10>(n, a, pivots, x),
        _ => solve_wide(n, lower, lower + upper, a, pivots, x),
    }
}

/// The unknowns in reach of a column stay in registers.
#[inline(always)]
fn solve_narrow<T: Scalar, const LOWER: usize, const ABOVE: usize, const STRIDE: usize>(
    n: usize,
    a: &[T],
    pivots: &[usize],
    x: &mut [T],
) {
    let (columns, x) = (&a.as_chunks::<STRIDE>().0[..n], &mut x[..n]);
    let mut ahead: [T; LOWER] = std::array::from_fn(|i| x.get(i + 1).copied().unwrap_or(T::zero()));
    let mut head = x.first().copied().unwrap_or(T::zero());
    for (k, (column, &p)) in columns.iter().zip(pivots).enumerate() {
        if p != 0 {
            for (i, ahead) in ahead.iter_mut().enumerate() {
                if p == i + 1 {
                    std::mem::swap(&mut head, ahead);
                }
            }
        }
        x[k] = head;
        let next = x.get(k + LOWER + 1).copied().unwrap_or(T::zero());
        let by = head;
        head = ahead[0] - column[ABOVE + 1] * by;
        for i in 1..LOWER {
            ahead[i - 1] = ahead[i] - column[ABOVE + 1 + i] * by;
        }
        ahead[LOWER - 1] = next;
    }
    // What is left of the unknowns behind, the nearest first.
    let left = |k: usize, x: &[T]| if k < n { x[k] } else { T::zero() };
    let mut behind: [T; ABOVE] = std::array::from_fn(|i| left(n.wrapping_sub(i + 1), x));
    for (k, column) in columns.iter().enumerate().rev() {
        let by = behind[0];
        x[k] = by * column[ABOVE];
        for i in 1..ABOVE {
            behind[i - 1] = behind[i] - column[ABOVE - i] * by;
        }
        behind[ABOVE - 1] = left(k.wrapping_sub(ABOVE), x) - column[0] * by;
    }
}

fn solve_wide<T: Scalar>(n: usize, lower: usize, diagonal: usize, a: &[T], pivots: &[usize], x: &mut [T]) {
    let columns = a.chunks_exact(lower + diagonal + 1);
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
        let by = x[k];
        x[k] = by * column[diagonal];
        let above = diagonal.min(k);
        for (x, &u) in x[k - above..k].iter_mut().zip(&column[diagonal - above..diagonal]) {
            *x = *x - u * by;
        }
    }
}
