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
        (1, 1) => solve_narrow::<T, 1, 2>(n, a, pivots, x),
        (2, 2) => solve_narrow::<T, 2, 4>(n, a, pivots, x),
        (3, 3) => solve_narrow::<T, 3, 6>(n, a, pivots, x),
        _ => solve_wide(n, lower, lower + upper, a, pivots, x),
    }
}

/// The unknowns in reach of a column stay in registers.
#[inline(always)]
fn solve_narrow<T: Scalar, const LOWER: usize, const ABOVE: usize>(
    n: usize,
    a: &[T],
    pivots: &[usize],
    x: &mut [T],
) {
    if n == 0 {
        return;
    }
    let stride = LOWER + ABOVE + 1;
    let mut below = [T::zero(); LOWER];
    for (below, &x) in below.iter_mut().zip(&x[1..n]) {
        *below = x;
    }
    let mut head = x[0];
    for (k, (column, &p)) in a.chunks_exact(stride).zip(&pivots[..n]).enumerate() {
        if p != 0 {
            for (i, below) in below.iter_mut().enumerate() {
                if p == i + 1 {
                    std::mem::swap(&mut head, below);
                }
            }
        }
        x[k] = head;
        let next = if k + LOWER + 1 < n { x[k + LOWER + 1] } else { T::zero() };
        let by = head;
        head = below[0] - column[ABOVE + 1] * by;
        for i in 1..LOWER {
            below[i - 1] = below[i] - column[ABOVE + 1 + i] * by;
        }
        below[LOWER - 1] = next;
    }
    // The unknowns behind, the nearest first. That one is waited for and comes last.
    let mut behind = [T::zero(); ABOVE];
    let mut back = |k: usize, reach: usize, rows: &[T]| {
        let mut head = x[k];
        for i in (0..reach).rev() {
            head = head - rows[(i + 1) * stride + ABOVE - 1 - i] * behind[i];
        }
        for i in (1..ABOVE).rev() {
            behind[i] = behind[i - 1];
        }
        behind[0] = head;
        x[k] = head * rows[ABOVE];
    };
    let whole = n.saturating_sub(ABOVE);
    for k in (whole..n).rev() {
        back(k, n - 1 - k, &a[k * stride..n * stride]);
    }
    for (k, rows) in a[..n * stride].windows((ABOVE + 1) * stride).step_by(stride).enumerate().rev() {
        back(k, ABOVE, rows);
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
