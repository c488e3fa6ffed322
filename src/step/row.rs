//! How a row of the form is worked out: unrolled where it is a constant, in a loop where it was read.

use super::method::{Known, Method};
use super::scalar::{Arith, Real};
use super::state::{RealOf, State};
use crate::tableau::{Form, Row, TERMS};
use std::marker::PhantomData;

/// A row of a form, and its value where the compiler knows it.
pub trait RowAt {
    const ROW: Option<&'static Row>;
    fn row(&self) -> &Row;
}

/// A row read at run time.
pub struct Read<'f>(pub &'f Row);

impl RowAt for Read<'_> {
    const ROW: Option<&'static Row> = None;
    #[inline(always)]
    fn row(&self) -> &Row {
        self.0
    }
}

/// Row i, or an empty one: a constant in a branch that is never taken is evaluated all the same.
const fn pick<const N: usize>(rows: &[Row; N], i: usize) -> Row {
    if i < N { rows[i] } else { Row::EMPTY }
}

macro_rules! constant_row {
    ($(#[$attribute:meta])* $name:ident, $rows:ident) => {
        $(#[$attribute])*
        pub struct $name<M, const I: usize>(pub PhantomData<M>);
        impl<M: Method, const I: usize> RowAt for $name<M, I> {
            const ROW: Option<&'static Row> = Some(&pick(&Known::<M>::FORM.$rows, I));
            #[inline(always)]
            fn row(&self) -> &Row {
                const { &pick(&Known::<M>::FORM.$rows, I) }
            }
        }
    };
}
constant_row!(
    /// The row of stage I.
    StageRow,
    stage
);
constant_row!(
    /// The row of z'_I.
    CarryRow,
    carry
);
constant_row!(
    /// The I-th error row.
    ErrorRow,
    error
);

/// h to the powers that rows need.
#[inline(always)]
pub fn powers<T: Real>(h: T) -> [T; 3] {
    [T::one(), h, h * h]
}

/// Calls a function of a constant number of terms: 0 to 24.
macro_rules! by_length {
    ($len:expr, $k:ident => $body:expr) => {
        by_length!(@ $len, $k => $body,
            0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24)
    };
    (@ $len:expr, $k:ident => $body:expr, $($n:literal)*) => {
        match $len {
            $( $n => { const $k: usize = $n; $body } )*
            _ => unreachable!("a row has at most {TERMS} terms"),
        }
    };
}

/// `out = base + sum_j h^power_j a_j x_at_j`.
#[inline(always)]
pub fn assemble<A: Arith, Y: State, R: RowAt>(out: &mut Y, row: R, h: &[RealOf<Y>; 3], x: &[Y]) {
    if const { R::ROW.is_some() } {
        by_length!(const { length::<R>() }, K => fill::<A, Y, K>(out, row.row(), h, x));
    } else {
        assemble_read::<A, Y>(out, row.row(), h, x);
    }
}

const fn length<R: RowAt>() -> usize {
    match R::ROW {
        Some(row) => row.len,
        None => 0,
    }
}

/// One copy of every length for all rows that are read at run time.
#[inline(never)]
pub(super) fn assemble_read<A: Arith, Y: State>(out: &mut Y, row: &Row, h: &[RealOf<Y>; 3], x: &[Y]) {
    by_length!(row.len, K => fill::<A, Y, K>(out, row, h, x));
}

#[inline(always)]
fn fill<A: Arith, Y: State, const K: usize>(out: &mut Y, row: &Row, h: &[RealOf<Y>; 3], x: &[Y]) {
    let base = row.base.map(|i| &x[i]);
    if A::FUSED && one_power(row) {
        // base + h sum: one fused operation at the end instead of a product for every coefficient.
        let scale = if row.len > 0 { Some(h[row.power[0]]) } else { None };
        out.combine::<A, K>(base, scale, |j| RealOf::<Y>::of(row.a[j]), |j| &x[row.at[j]]);
    } else {
        // h is multiplied in where the coefficient is used: adding the base is then all that waits for the sum.
        out.combine::<A, K>(base, None, |j| coefficient(row, h, j), |j| &x[row.at[j]]);
    }
}

/// Every term carries the same power of h, and one at least.
#[inline(always)]
fn one_power(row: &Row) -> bool {
    let mut j = 1;
    while j < row.len {
        if row.power[j] != row.power[0] {
            return false;
        }
        j += 1;
    }
    row.len > 0 && row.power[0] > 0
}

#[inline(always)]
fn coefficient<T: Real>(row: &Row, h: &[T; 3], j: usize) -> T {
    let a = T::of(row.a[j]);
    if row.power[j] == 0 { a } else { h[row.power[j]] * a }
}

/// The sum of squares of `error_i / (atol_i + rtol_i max(|y0_i|, |y1_i|))`.
#[inline(always)]
pub fn error_square<A: Arith, Y: State, R: RowAt>(
    row: R,
    h: &[RealOf<Y>; 3],
    x: &[Y],
    y1: &Y,
    tolerance: &super::norm::Tolerance<RealOf<Y>>,
) -> RealOf<Y> {
    if const { R::ROW.is_some() } {
        by_length!(const { length::<R>() }, K => squares::<A, Y, K>(row.row(), h, x, y1, tolerance))
    } else {
        error_read::<A, Y>(row.row(), h, x, y1, tolerance)
    }
}

#[inline(never)]
fn error_read<A: Arith, Y: State>(
    row: &Row,
    h: &[RealOf<Y>; 3],
    x: &[Y],
    y1: &Y,
    tolerance: &super::norm::Tolerance<RealOf<Y>>,
) -> RealOf<Y> {
    by_length!(row.len, K => squares::<A, Y, K>(row, h, x, y1, tolerance))
}

#[inline(always)]
fn squares<A: Arith, Y: State, const K: usize>(
    row: &Row,
    h: &[RealOf<Y>; 3],
    x: &[Y],
    y1: &Y,
    tolerance: &super::norm::Tolerance<RealOf<Y>>,
) -> RealOf<Y> {
    // An error row has no base: every term carries h^d, which is multiplied in once.
    let scale = h[row.power[0]];
    y1.error_square::<A, K>(&x[0], tolerance, scale, |j| RealOf::<Y>::of(row.a[j]), |j| &x[row.at[j]])
}

/// Repeats the body for I = 0, 1, .. as a constant item, up to the most stages a method may have.
macro_rules! unroll {
    ($count:expr, $i:ident => $body:expr) => {
        unroll!(@ $count, $i => $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19)
    };
    (@ $count:expr, $i:ident => $body:expr, $($n:literal)*) => { $( {
        const $i: usize = $n;
        if const { $i < $count } { $body }
    } )* };
}
pub(crate) use unroll;

/// The form a stepper runs, constant or read.
#[inline(always)]
pub fn form_of<M: Method>(method: &M) -> &Form {
    if const { Known::<M>::UNROLLED } { Known::<M>::FORM } else { method.form() }
}
