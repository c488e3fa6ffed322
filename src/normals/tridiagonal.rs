//! The left-hand side of a compact stencil along a line: a tridiagonal system, cyclic where the map repeats.

use crate::step::scalar::Real;
use crate::tableau::DoubleDouble as D;

/// The matrix by its rows: `(lower, diagonal, upper)`. The first lower and the last upper entry stand in the
/// corners.
pub(super) type Rows = Vec<[D; 3]>;

/// A factored tridiagonal matrix (Thomas), with its corners brought in by Sherman and Morrison's formula.
/// Diagonally dominant rows need no pivoting.
pub(super) struct Tridiagonal<T> {
    lower: Vec<T>,
    /// One over the pivot.
    pivot: Vec<T>,
    upper: Vec<T>,
    corner: Option<Corner<T>>,
}

struct Corner<T> {
    /// The answer to the corner's column, over 1 + v z.
    z: Vec<T>,
    /// The last entry of v; the first is 1.
    last: T,
}

pub(super) fn transposed(rows: &Rows) -> Rows {
    let n = rows.len();
    (0..n).map(|i| [rows[(i + n - 1) % n][2], rows[i][1], rows[(i + 1) % n][0]]).collect()
}

impl<T: Real> Tridiagonal<T> {
    pub(super) fn new(mut rows: Rows) -> Self {
        let n = rows.len();
        let (low, high) = (rows[0][0], rows[n - 1][2]);
        let cyclic = n > 2 && (low.hi() != 0.0 || high.hi() != 0.0);
        let g = -rows[0][1];
        if cyclic {
            rows[0][1] -= g;
            rows[n - 1][1] -= low * high / g;
        }
        let mut pivot = Vec::with_capacity(n);
        let mut upper: Vec<D> = Vec::with_capacity(n);
        for i in 0..n {
            let below = if i > 0 { rows[i][0] * upper[i - 1] } else { D::ZERO };
            pivot.push(D::ONE / (rows[i][1] - below));
            upper.push(rows[i][2] * pivot[i]);
        }
        let corner = cyclic.then(|| {
            let mut z = vec![D::ZERO; n];
            (z[0], z[n - 1]) = (g, high);
            for i in 0..n {
                let below = if i > 0 { rows[i][0] * z[i - 1] } else { D::ZERO };
                z[i] = (z[i] - below) * pivot[i];
            }
            for i in (0..n - 1).rev() {
                z[i] = z[i] - upper[i] * z[i + 1];
            }
            let last = low / g;
            let scale = D::ONE + z[0] + last * z[n - 1];
            Corner { z: z.iter().map(|z| T::of(*z / scale)).collect(), last: T::of(last) }
        });
        let round = |all: &[D]| all.iter().map(|x| T::of(*x)).collect();
        let lower: Vec<D> = rows.iter().map(|row| row[0]).collect();
        Self { lower: round(&lower), pivot: round(&pivot), upper: round(&upper), corner }
    }

    /// Solves for many right-hand sides at once, in place: `x[i]` holds row i of each.
    #[inline(always)]
    pub(super) fn solve<const L: usize>(&self, x: &mut [[T; L]]) {
        let n = self.pivot.len();
        for i in 0..n {
            let before = if i > 0 { x[i - 1] } else { [T::zero(); L] };
            for (x, before) in x[i].iter_mut().zip(before) {
                *x = (*x - self.lower[i] * before) * self.pivot[i];
            }
        }
        for i in (0..n - 1).rev() {
            let after = x[i + 1];
            for (x, after) in x[i].iter_mut().zip(after) {
                *x = *x - self.upper[i] * after;
            }
        }
        if let Some(corner) = &self.corner {
            let (first, last) = (x[0], x[n - 1]);
            for (x, z) in x.iter_mut().zip(&corner.z) {
                for l in 0..L {
                    x[l] = x[l] - *z * (first[l] + corner.last * last[l]);
                }
            }
        }
    }
}
