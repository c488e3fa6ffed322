//! A stencil on a grid as the linear map it is, with its transpose and its symbol.

use super::border::Border;
use super::error::BakeError;
use super::line::{LANES, Line, Spec, reversed};
use super::stencil::{Stencil, Taps};
use crate::step::scalar::Real;
use crate::tableau::DoubleDouble as D;
use faer::{Mat, MatMut, MatRef};
use num_complex::Complex;

/// A direction of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// To the right, along a row.
    S,
    /// Up, against the order of the rows.
    T,
}

/// The slopes d/ds and d/dt of a grid of heights, in heights per texel: `f64`, `f32` or
/// [`DoubleDouble`](crate::tableau::DoubleDouble).
///
/// Grids hold the top row first, in slices of width x height and matrices of height rows.
pub struct Operator<T> {
    size: [usize; 2],
    border: [Border; 2],
    taps: [Taps; 3],
    /// For each axis: the difference along it, the smoothing along the same lines for the other axis.
    along: [Line<T>; 2],
    across: [Line<T>; 2],
}

const ONE: Taps = Taps { first: 0, len: 1, weight: [D::ONE; super::stencil::TAPS] };

/// What the lines of an axis are made of: differences, times `scale`, and smoothing.
pub(super) fn specs(stencil: &Stencil, axis: Axis, border: Border, scale: D) -> [Spec; 2] {
    // Rows run down and t runs up.
    let turn = |taps: &Taps| if axis == Axis::T { reversed(taps) } else { *taps };
    let sign = D::of(if axis == Axis::T { -1.0 } else { 1.0 });
    let along = Spec {
        taps: turn(&stencil.along),
        left: turn(&stencil.left),
        at: sign * stencil.at,
        degree: stencil.order,
        border,
        sign,
        scale,
    };
    [along, Spec { taps: turn(&stencil.across), left: ONE, scale: D::ONE, ..along }]
}

pub(super) fn lines<T: Real>(
    stencil: &Stencil,
    axis: Axis,
    n: usize,
    border: Border,
    scale: D,
) -> [Line<T>; 2] {
    specs(stencil, axis, border, scale).map(|spec| Line::new(&spec, n))
}

/// A compact left-hand side must be one whose solution needs no pivoting.
pub(super) fn check(stencil: &Stencil, [width, height]: [usize; 2]) -> Result<(), BakeError> {
    if width == 0 || height == 0 || width.checked_mul(height).is_none() {
        return Err(BakeError::Size { width, height });
    }
    let left = &stencil.left;
    let w = |j: usize| left.weight[j].hi().abs();
    match left.len {
        1 => Ok(()),
        3 if left.first == -1 && w(0) + w(2) < w(1) => Ok(()),
        taps => Err(BakeError::LeftSide { taps }),
    }
}

impl<T: Real> Operator<T> {
    /// For grids of `[width, height]` texels, with what lies beyond their edges along s and t.
    pub fn new(stencil: &Stencil, size: [usize; 2], border: [Border; 2]) -> Result<Self, BakeError> {
        Self::scaled(stencil, size, border, [D::ONE; 2])
    }

    pub(super) fn scaled(
        stencil: &Stencil,
        size: [usize; 2],
        border: [Border; 2],
        scale: [D; 2],
    ) -> Result<Self, BakeError> {
        check(stencil, size)?;
        let [along_s, across_s] = lines(stencil, Axis::S, size[0], border[0], scale[0]);
        let [along_t, across_t] = lines(stencil, Axis::T, size[1], border[1], scale[1]);
        let taps = [stencil.along, stencil.across, stencil.left];
        Ok(Self { size, border, taps, along: [along_s, along_t], across: [across_s, across_t] })
    }

    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    pub fn border(&self) -> [Border; 2] {
        self.border
    }

    /// The slopes along an axis, one per texel.
    pub fn apply(&self, axis: Axis, heights: &[T], slopes: &mut [T]) -> Result<(), BakeError> {
        let (heights, slopes) = self.views(heights, slopes)?;
        self.apply_mat(axis, heights, slopes)
    }

    /// The transpose of [`apply`](Self::apply): <A x, y> = <x, A^T y>, whatever the borders.
    pub fn adjoint(&self, axis: Axis, slopes: &[T], heights: &mut [T]) -> Result<(), BakeError> {
        let (slopes, heights) = self.views(slopes, heights)?;
        self.adjoint_mat(axis, slopes, heights)
    }

    /// The slopes of a matrix of heights, its first row on top.
    pub fn apply_mat(
        &self,
        axis: Axis,
        heights: MatRef<'_, T>,
        slopes: MatMut<'_, T>,
    ) -> Result<(), BakeError> {
        self.both(axis, heights, slopes, |line, x, y| line.apply(x, y))
    }

    /// The transpose of [`apply_mat`](Self::apply_mat).
    pub fn adjoint_mat(
        &self,
        axis: Axis,
        slopes: MatRef<'_, T>,
        heights: MatMut<'_, T>,
    ) -> Result<(), BakeError> {
        self.both(axis, slopes, heights, |line, x, y| line.adjoint(x, y))
    }

    /// What the wave exp(i (k_s s + k_t t)) is multiplied by, k in radians per texel: i k_s or i k_t, were the
    /// stencil exact. It holds for waves that wrap.
    pub fn symbol(&self, axis: Axis, [k_s, k_t]: [f64; 2]) -> Complex<f64> {
        symbol_of(&self.taps, axis, [k_s, k_t])
    }

    /// One line map after the other: they act on different axes, so their order is free.
    fn both(
        &self,
        axis: Axis,
        x: MatRef<'_, T>,
        y: MatMut<'_, T>,
        run: impl Fn(&Line<T>, &mut [[T; LANES]], &mut [[T; LANES]]),
    ) -> Result<(), BakeError> {
        let [width, height] = self.size;
        let need = width * height;
        for (rows, columns) in [(x.nrows(), x.ncols()), (y.nrows(), y.ncols())] {
            if (rows, columns) != (height, width) {
                return Err(BakeError::Length { len: rows * columns, need });
            }
        }
        let (i, other) = if axis == Axis::S { (0, Axis::T) } else { (1, Axis::S) };
        if self.across[1 - i].identity() {
            pass(&self.along[i], axis, x, y, &run);
        } else {
            let mut smooth = Mat::from_fn(height, width, |_, _| T::zero());
            pass(&self.across[1 - i], other, x, smooth.as_mut(), &run);
            pass(&self.along[i], axis, smooth.as_ref(), y, &run);
        }
        Ok(())
    }

    fn views<'a>(&self, x: &'a [T], y: &'a mut [T]) -> Result<(MatRef<'a, T>, MatMut<'a, T>), BakeError> {
        let [width, height] = self.size;
        let need = width * height;
        for len in [x.len(), y.len()] {
            if len != need {
                return Err(BakeError::Length { len, need });
            }
        }
        Ok((
            MatRef::from_row_major_slice(x, height, width),
            MatMut::from_row_major_slice_mut(y, height, width),
        ))
    }
}

pub(super) fn symbol(stencil: &Stencil, axis: Axis, k: [f64; 2]) -> Complex<f64> {
    symbol_of(&[stencil.along, stencil.across, stencil.left], axis, k)
}

fn symbol_of([along, across, left]: &[Taps; 3], axis: Axis, [k_s, k_t]: [f64; 2]) -> Complex<f64> {
    let (k, other) = if axis == Axis::S { (k_s, k_t) } else { (k_t, k_s) };
    wave(along, k) * wave(across, other) / wave(left, k)
}

fn wave(taps: &Taps, k: f64) -> Complex<f64> {
    (0..taps.len).map(|j| Complex::cis(k * (taps.first + j as isize) as f64) * taps.weight[j].hi()).sum()
}

/// Runs a line map on all lines along an axis, many at once.
fn pass<T: Real>(
    line: &Line<T>,
    axis: Axis,
    x: MatRef<'_, T>,
    mut y: MatMut<'_, T>,
    run: impl Fn(&Line<T>, &mut [[T; LANES]], &mut [[T; LANES]]),
) {
    let lines = if axis == Axis::S { x.nrows() } else { x.ncols() };
    let (mut from, mut to) = (vec![[T::zero(); LANES]; line.n], vec![[T::zero(); LANES]; line.n]);
    let place = |i: usize, line: usize| if axis == Axis::S { (line, i) } else { (i, line) };
    for first in (0..lines).step_by(LANES) {
        let lanes = LANES.min(lines - first);
        for (i, from) in from.iter_mut().enumerate() {
            for (l, from) in from.iter_mut().enumerate().take(lanes) {
                *from = x[place(i, first + l)];
            }
        }
        run(line, &mut from, &mut to);
        for (i, to) in to.iter().enumerate() {
            for (l, to) in to.iter().enumerate().take(lanes) {
                y[place(i, first + l)] = *to;
            }
        }
    }
}
