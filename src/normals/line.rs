//! A row of taps as a linear map on a line of texels, its ends folded into the weights.

use super::border::Border;
use super::polynomial;
use super::stencil::Taps;
use super::tridiagonal::{Rows, Tridiagonal, transposed};
use crate::step::scalar::Real;
use crate::tableau::DoubleDouble as D;
use std::ops::Range;

/// Lines worked on at once.
pub(super) const LANES: usize = 16;

/// What a line is made of.
#[derive(Clone, Copy)]
pub(super) struct Spec {
    pub taps: Taps,
    /// The left-hand side of a compact stencil; one tap where it is explicit.
    pub left: Taps,
    /// Where the value lives, in texels from the texel it is stored at.
    pub at: D,
    /// The degree of the polynomials that ghost texels continue.
    pub degree: usize,
    pub border: Border,
    /// -1 where the axis runs against the line: what the taps are turned for, a slope's polynomial is not.
    pub sign: D,
    pub scale: D,
}

/// The map: row i is `sum w b_j` over a few texels j. Rows away from the ends are all alike.
pub(super) struct Line<T> {
    pub n: usize,
    /// The rows that are alike.
    pub inner: Range<usize>,
    /// Their weights, by offset.
    pub taps: Vec<(isize, T)>,
    /// The other rows, in order.
    ends: Vec<Vec<(usize, T)>>,
    /// A compact stencil's left-hand side and its transpose.
    left: Option<[Tridiagonal<T>; 2]>,
}

/// The same taps seen from the other side: t runs up where rows run down.
pub(super) fn reversed(taps: &Taps) -> Taps {
    let mut out = *taps;
    out.first = -(taps.first + taps.len as isize - 1);
    for j in 0..taps.len {
        out.weight[j] = taps.weight[taps.len - 1 - j];
    }
    out
}

fn add(row: &mut Vec<(usize, D)>, at: usize, weight: D) {
    match row.iter_mut().find(|entry| entry.0 == at) {
        Some(entry) => entry.1 += weight,
        None => row.push((at, weight)),
    }
}

impl Spec {
    /// Row i of the right-hand side on a line of n texels.
    fn row(&self, i: usize, n: usize) -> Vec<(usize, D)> {
        let mut row = vec![];
        if self.left.len > 1 && self.cut(i, n) {
            // No neighbour to couple to: the slope of the polynomial through the nearest texels.
            let len = self.degree.min(n - 1) + 1;
            let first = i.saturating_sub(self.degree / 2).min(n - len);
            let x = D::of((i - first) as f64) + self.at;
            for k in 0..len {
                add(&mut row, first + k, polynomial::slope(k, len, x) * self.sign * self.scale);
            }
            return row;
        }
        for j in 0..self.taps.len {
            let (at, weight) = (i as isize + self.taps.first + j as isize, self.taps.weight[j] * self.scale);
            match self.border.find(at, n) {
                Some((at, _)) => add(&mut row, at, weight),
                None => {
                    let len = self.degree.min(n - 1) + 1;
                    let first = if at < 0 { 0 } else { n - len };
                    let x = D::of((at - first as isize) as f64);
                    for k in 0..len {
                        add(&mut row, first + k, weight * polynomial::value(k, len, x));
                    }
                }
            }
        }
        row
    }

    /// Row i would need a texel that is not there.
    fn cut(&self, i: usize, n: usize) -> bool {
        let reach = |taps: &Taps| {
            let first = i as isize + taps.first;
            first < 0 || first + taps.len as isize > n as isize
        };
        self.border == Border::OneSided && (reach(&self.taps) || reach(&self.left))
    }

    /// The left-hand side on a line of n texels.
    fn left_rows(&self, n: usize) -> Rows {
        let mut rows = vec![[D::ZERO; 3]; n];
        for (i, row) in rows.iter_mut().enumerate() {
            if self.cut(i, n) {
                row[1] = D::ONE;
                continue;
            }
            for j in 0..self.left.len {
                let at = i as isize + self.left.first + j as isize;
                let Some((to, sign)) = self.border.find(at, n) else { continue };
                // On a line of two texels both neighbours are the same one, which is no corner.
                let place = match (to as isize - i as isize, n) {
                    (0, _) => 1,
                    (_, 2) => 2 * usize::from(to > i),
                    _ if at < i as isize => 0,
                    _ => 2,
                };
                row[place] += self.left.weight[j] * D::of(sign);
            }
        }
        rows
    }
}

impl<T: Real> Line<T> {
    pub(super) fn new(spec: &Spec, n: usize) -> Self {
        let end = |taps: &Taps| taps.first + taps.len as isize - 1;
        let first = spec.taps.first.min(spec.left.first).min(0).unsigned_abs();
        let last = end(&spec.taps).max(end(&spec.left)).max(0) as usize;
        // With no room between the ends every row is an end.
        let inner = if first + last < n { first..n - last } else { n..n };
        // What cancels leaves the rounding of 32 digits.
        let size: f64 = (0..spec.taps.len).map(|j| (spec.taps.weight[j] * spec.scale).hi().abs()).sum();
        let of = |row: Vec<(usize, D)>| {
            let kept = row.into_iter().filter(|(_, w)| w.hi().abs() > 1e-27 * size);
            let mut row: Vec<_> = kept.map(|(at, w)| (at, T::of(w))).collect();
            row.sort_by_key(|entry| entry.0);
            row
        };
        let ends = (0..inner.start).chain(inner.end..n).map(|i| of(spec.row(i, n))).collect();
        let taps = (0..spec.taps.len).map(|j| {
            let weight = T::of(spec.taps.weight[j] * spec.scale);
            (spec.taps.first + j as isize, weight)
        });
        let left = (spec.left.len > 1).then(|| {
            let rows = spec.left_rows(n);
            [Tridiagonal::new(rows.clone()), Tridiagonal::new(transposed(&rows))]
        });
        Self { n, inner, taps: taps.filter(|(_, w)| *w != T::zero()).collect(), ends, left }
    }

    /// The entries of an end row.
    pub(super) fn end(&self, i: usize) -> &[(usize, T)] {
        let i = if i < self.inner.start { i } else { self.inner.start + i - self.inner.end };
        &self.ends[i]
    }

    /// The map that changes nothing.
    pub(super) fn identity(&self) -> bool {
        self.inner.len() == self.n && self.left.is_none() && self.taps == [(0, T::one())]
    }

    /// Calls with every entry of the right-hand side's row i.
    #[inline(always)]
    pub(super) fn entries(&self, i: usize, mut entry: impl FnMut(usize, T)) {
        if self.inner.contains(&i) {
            for &(offset, w) in &self.taps {
                entry((i as isize + offset) as usize, w);
            }
        } else {
            for &(at, w) in self.end(i) {
                entry(at, w);
            }
        }
    }

    /// y = A x: texel i of every lane in `x[i]`.
    #[inline(always)]
    pub(super) fn apply<const L: usize>(&self, x: &[[T; L]], y: &mut [[T; L]]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = [T::NEG_ZERO; L];
            self.entries(i, |at, w| {
                for (y, x) in y.iter_mut().zip(x[at]) {
                    *y = *y + w * x;
                }
            });
        }
        if let Some([left, _]) = &self.left {
            left.solve(y);
        }
    }

    /// y = A^T x; x is used up.
    pub(super) fn adjoint<const L: usize>(&self, x: &mut [[T; L]], y: &mut [[T; L]]) {
        if let Some([_, left]) = &self.left {
            left.solve(x);
        }
        y.fill([T::zero(); L]);
        for (i, x) in x.iter().enumerate() {
            self.entries(i, |at, w| {
                for (y, x) in y[at].iter_mut().zip(x) {
                    *y = *y + w * *x;
                }
            });
        }
    }

    /// Row i of the whole map, the left-hand side's inverse included.
    pub(super) fn row(&self, i: usize) -> Vec<(usize, T)> {
        let (mut unit, mut row) = (vec![[T::zero()]; self.n], vec![[T::zero()]; self.n]);
        unit[i] = [T::one()];
        self.adjoint(&mut unit, &mut row);
        row.iter().enumerate().map(|(at, w)| (at, w[0])).filter(|(_, w)| *w != T::zero()).collect()
    }
}
