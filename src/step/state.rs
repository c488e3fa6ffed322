//! What can be stepped: arrays, nalgebra vectors, faer columns and `Vec`, through one kernel.

use super::norm::Tolerance;
use super::scalar::{Arith, Real, Scalar};
use crate::linear::{Large, Pair, Small, Square};
use num_traits::Zero;

/// The real numbers of a state: its times, steps, tolerances.
pub type RealOf<Y> = <<Y as State>::Scalar as Scalar>::Real;

/// A state of a system: a contiguous run of numbers.
pub trait State: Clone {
    type Scalar: Scalar;
    /// A matrix with a row and a column for each component.
    type Square: Square<Self::Scalar>;
    /// The same for pairs of components, and a vector of such.
    type PairSquare: Square<Pair<Self::Scalar>>;
    type Pairs: AsMut<[Pair<Self::Scalar>]> + Clone;
    /// Held by value, without the heap.
    const INLINE: bool;

    fn as_slice(&self) -> &[Self::Scalar];
    /// As many pairs as components, of zeros.
    fn pairs(&self) -> Self::Pairs;
    fn as_mut_slice(&mut self) -> &mut [Self::Scalar];

    /// `self = base + scale sum_j a(j) x(j)`, j < K, in one pass; without a scale it is one.
    fn combine<'a, A: Arith, const K: usize>(
        &mut self,
        base: Option<&'a Self>,
        scale: Option<RealOf<Self>>,
        a: impl Fn(usize) -> RealOf<Self>,
        x: impl Fn(usize) -> &'a Self,
    ) where
        Self: 'a;

    /// The sum over components of the square of `scale sum_j a(j) x(j)` over its tolerance, for a step from
    /// `y0` to `self`. Not a number where `self` is not finite.
    fn error_square<'a, A: Arith, const K: usize>(
        &self,
        y0: &Self,
        tolerance: &Tolerance<RealOf<Self>>,
        scale: RealOf<Self>,
        a: impl Fn(usize) -> RealOf<Self>,
        x: impl Fn(usize) -> &'a Self,
    ) -> RealOf<Self>
    where
        Self: 'a;

    /// Takes over what `from` holds, and may leave there whatever it held itself.
    fn take(&mut self, from: &mut Self);
}

/// The first component that is a NaN or an infinity.
#[inline(always)]
pub(crate) fn first_non_finite<Y: State>(y: &Y) -> Option<usize> {
    y.as_slice().iter().position(|x| !x.finite())
}

/// `out += a x`.
#[inline(always)]
pub(crate) fn add<Y: State>(out: &mut Y, a: RealOf<Y>, x: &Y) {
    for (out, &x) in out.as_mut_slice().iter_mut().zip(x.as_slice()) {
        *out = *out + x.scale(a);
    }
}

#[inline(always)]
fn added<A: Arith, T: Scalar>(base: T, scale: Option<T::Real>, sum: T) -> T {
    match scale {
        Some(scale) => A::term(scale, sum, base),
        None => base + sum,
    }
}

#[inline(always)]
fn scaled<T: Scalar>(scale: Option<T::Real>, sum: T) -> T {
    match scale {
        Some(scale) => sum.scale(scale),
        None => sum,
    }
}

/// Component by component, all terms of one before the next: one pass over memory.
#[inline(always)]
fn combine_long<'a, A: Arith, T: Scalar, const K: usize>(
    out: &mut [T],
    base: Option<&'a [T]>,
    scale: Option<T::Real>,
    a: impl Fn(usize) -> T::Real,
    x: impl Fn(usize) -> &'a [T],
) {
    let n = out.len();
    let a: [T::Real; K] = std::array::from_fn(&a);
    let x: [&[T]; K] = std::array::from_fn(|j| &x(j)[..n]);
    let sum = |i: usize| {
        let mut s = T::NEG_ZERO;
        for j in 0..K {
            // Every slice was cut to n above, so no bounds are checked here.
            s = if j == 0 { x[j][i].scale(a[j]) } else { A::term(a[j], x[j][i], s) };
        }
        s
    };
    match base {
        Some(base) => {
            let base = &base[..n];
            for i in 0..n {
                out[i] = added::<A, T>(base[i], scale, sum(i));
            }
        }
        None => {
            for (i, out) in out.iter_mut().enumerate() {
                *out = scaled(scale, sum(i));
            }
        }
    }
}

/// Term by term over a few components that all stay in registers.
#[inline(always)]
fn combine_short<'a, A: Arith, T: Scalar, const N: usize, const K: usize>(
    out: &mut [T; N],
    base: Option<&'a [T; N]>,
    scale: Option<T::Real>,
    a: impl Fn(usize) -> T::Real,
    x: impl Fn(usize) -> &'a [T; N],
) {
    let mut s = [T::NEG_ZERO; N];
    for j in 0..K {
        let (a, x) = (a(j), x(j));
        for i in 0..N {
            s[i] = if j == 0 { x[i].scale(a) } else { A::term(a, x[i], s[i]) };
        }
    }
    for i in 0..N {
        out[i] = match base {
            Some(base) => added::<A, T>(base[i], scale, s[i]),
            None => scaled(scale, s[i]),
        };
    }
}

/// The square of one component's error over its tolerance. The scale meets the weight first: neither waits
/// for the error, and no product leaves the range of numbers that the ratio itself is in.
#[inline(always)]
fn ratio_square<T: Scalar>(scale: T::Real, e: T, y0: T, y1: T, (rtol, atol): (T::Real, T::Real)) -> T::Real {
    // A NaN in y1 passes through this maximum; `f64::max` would drop it.
    let weight = atol + rtol * y0.modulus().maximum(y1.modulus());
    // Nothing for a finite weight, else a NaN: an infinite state would divide any error to zero.
    let flaw = T::Real::zero() * weight;
    e.scale((scale + flaw) / weight).square()
}

/// Eight sums side by side, so that no addition waits for the one before.
const LANES: usize = 8;

#[inline(always)]
fn error_square_long<'a, A: Arith, T: Scalar, const K: usize>(
    y0: &[T],
    y1: &[T],
    tolerance: &Tolerance<T::Real>,
    scale: T::Real,
    a: impl Fn(usize) -> T::Real,
    x: impl Fn(usize) -> &'a [T],
) -> T::Real {
    let n = y0.len();
    let y1 = &y1[..n];
    let a: [T::Real; K] = std::array::from_fn(&a);
    let x: [&[T]; K] = std::array::from_fn(|j| &x(j)[..n]);
    let error = |i: usize| {
        let mut s = T::NEG_ZERO;
        for j in 0..K {
            s = if j == 0 { x[j][i].scale(a[j]) } else { A::term(a[j], x[j][i], s) };
        }
        s
    };
    let mut sums = [T::Real::zero(); LANES];
    let whole = n - n % LANES;
    match tolerance {
        Tolerance::Scalar { rtol, atol } => {
            for block in (0..whole).step_by(LANES) {
                for (lane, sum) in sums.iter_mut().enumerate() {
                    let i = block + lane;
                    *sum = *sum + ratio_square(scale, error(i), y0[i], y1[i], (*rtol, *atol));
                }
            }
            for i in whole..n {
                sums[0] = sums[0] + ratio_square(scale, error(i), y0[i], y1[i], (*rtol, *atol));
            }
        }
        Tolerance::Each(each) => {
            for (i, &tolerance) in each.iter().enumerate().take(n) {
                sums[i % LANES] = sums[i % LANES] + ratio_square(scale, error(i), y0[i], y1[i], tolerance);
            }
        }
    }
    sums.iter().fold(T::Real::zero(), |s, &x| s + x)
}

#[inline(always)]
fn error_square_short<'a, A: Arith, T: Scalar, const N: usize, const K: usize>(
    y0: &[T; N],
    y1: &[T; N],
    tolerance: &Tolerance<T::Real>,
    scale: T::Real,
    a: impl Fn(usize) -> T::Real,
    x: impl Fn(usize) -> &'a [T; N],
) -> T::Real {
    let mut e = [T::NEG_ZERO; N];
    combine_short::<A, T, N, K>(&mut e, None, None, a, x);
    let mut sum = T::Real::zero();
    for i in 0..N {
        sum = sum + ratio_square(scale, e[i], y0[i], y1[i], tolerance.at(i));
    }
    sum
}

/// Above this many components an array is worked through like a long vector.
const SHORT: usize = 32;

impl<T: Scalar, const N: usize> State for [T; N] {
    type Scalar = T;
    type Square = Small<T, N>;
    type PairSquare = Small<Pair<T>, N>;
    type Pairs = [Pair<T>; N];
    const INLINE: bool = true;
    fn pairs(&self) -> [Pair<T>; N] {
        [Pair::zero(); N]
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self
    }
    #[inline(always)]
    fn combine<'a, A: Arith, const K: usize>(
        &mut self,
        base: Option<&'a Self>,
        scale: Option<T::Real>,
        a: impl Fn(usize) -> T::Real,
        x: impl Fn(usize) -> &'a Self,
    ) {
        if const { N <= SHORT } {
            combine_short::<A, T, N, K>(self, base, scale, a, x);
        } else {
            combine_long::<A, T, K>(self, base.map(|b| b.as_slice()), scale, a, |j| x(j).as_slice());
        }
    }
    #[inline(always)]
    fn error_square<'a, A: Arith, const K: usize>(
        &self,
        y0: &Self,
        tolerance: &Tolerance<RealOf<Self>>,
        scale: RealOf<Self>,
        a: impl Fn(usize) -> RealOf<Self>,
        x: impl Fn(usize) -> &'a Self,
    ) -> RealOf<Self> {
        if const { N <= SHORT } {
            error_square_short::<A, T, N, K>(y0, self, tolerance, scale, a, x)
        } else {
            error_square_long::<A, T, K>(y0.as_slice(), self.as_slice(), tolerance, scale, a, |j| {
                x(j).as_slice()
            })
        }
    }
    #[inline(always)]
    fn take(&mut self, from: &mut Self) {
        *self = *from;
    }
}

impl<T: Scalar + nalgebra::Scalar, const N: usize> State for nalgebra::SVector<T, N> {
    type Scalar = T;
    type Square = Small<T, N>;
    type PairSquare = Small<Pair<T>, N>;
    type Pairs = [Pair<T>; N];
    const INLINE: bool = true;
    fn pairs(&self) -> [Pair<T>; N] {
        [Pair::zero(); N]
    }
    #[inline(always)]
    fn as_slice(&self) -> &[T] {
        self.as_slice()
    }
    #[inline(always)]
    fn as_mut_slice(&mut self) -> &mut [T] {
        self.as_mut_slice()
    }
    #[inline(always)]
    fn combine<'a, A: Arith, const K: usize>(
        &mut self,
        base: Option<&'a Self>,
        scale: Option<T::Real>,
        a: impl Fn(usize) -> T::Real,
        x: impl Fn(usize) -> &'a Self,
    ) {
        // A column of N is one array of N.
        let out = &mut self.data.0[0];
        if const { N <= SHORT } {
            combine_short::<A, T, N, K>(out, base.map(|b| &b.data.0[0]), scale, a, |j| &x(j).data.0[0]);
        } else {
            combine_long::<A, T, K>(out, base.map(|b| b.as_slice()), scale, a, |j| x(j).as_slice());
        }
    }
    #[inline(always)]
    fn error_square<'a, A: Arith, const K: usize>(
        &self,
        y0: &Self,
        tolerance: &Tolerance<RealOf<Self>>,
        scale: RealOf<Self>,
        a: impl Fn(usize) -> RealOf<Self>,
        x: impl Fn(usize) -> &'a Self,
    ) -> RealOf<Self> {
        if const { N <= SHORT } {
            error_square_short::<A, T, N, K>(&y0.data.0[0], &self.data.0[0], tolerance, scale, a, |j| {
                &x(j).data.0[0]
            })
        } else {
            error_square_long::<A, T, K>(y0.as_slice(), self.as_slice(), tolerance, scale, a, |j| {
                x(j).as_slice()
            })
        }
    }
    #[inline(always)]
    fn take(&mut self, from: &mut Self) {
        self.data = from.data;
    }
}

macro_rules! on_the_heap {
    ($t:ty, $view:ident => $slice:expr, $mut_slice:expr) => {
        impl<T: Scalar> State for $t {
            type Scalar = T;
            type Square = Large<T>;
            type PairSquare = Large<Pair<T>>;
            type Pairs = Vec<Pair<T>>;
            const INLINE: bool = false;
            fn pairs(&self) -> Vec<Pair<T>> {
                vec![Pair::zero(); State::as_slice(self).len()]
            }
            #[inline(always)]
            fn as_slice(&self) -> &[T] {
                let $view = self;
                $slice
            }
            #[inline(always)]
            fn as_mut_slice(&mut self) -> &mut [T] {
                let $view = self;
                $mut_slice
            }
            #[inline(always)]
            fn combine<'a, A: Arith, const K: usize>(
                &mut self,
                base: Option<&'a Self>,
                scale: Option<T::Real>,
                a: impl Fn(usize) -> T::Real,
                x: impl Fn(usize) -> &'a Self,
            ) {
                let base = base.map(State::as_slice);
                combine_long::<A, T, K>(State::as_mut_slice(self), base, scale, a, |j| State::as_slice(x(j)));
            }
            #[inline(always)]
            fn error_square<'a, A: Arith, const K: usize>(
                &self,
                y0: &Self,
                tolerance: &Tolerance<RealOf<Self>>,
                scale: RealOf<Self>,
                a: impl Fn(usize) -> RealOf<Self>,
                x: impl Fn(usize) -> &'a Self,
            ) -> RealOf<Self> {
                let (y0, y1) = (State::as_slice(y0), State::as_slice(self));
                error_square_long::<A, T, K>(y0, y1, tolerance, scale, a, |j| State::as_slice(x(j)))
            }
            #[inline(always)]
            fn take(&mut self, from: &mut Self) {
                std::mem::swap(self, from);
            }
        }
    };
}
on_the_heap!(Vec<T>, y => y.as_slice(), y.as_mut_slice());
// An owned column is stored without gaps, so its slice is always there.
on_the_heap!(
    faer::Col<T>,
    y => y.as_ref().try_as_col_major().expect("an owned column is contiguous").as_slice(),
    y.as_mut().try_as_col_major_mut().expect("an owned column is contiguous").as_slice_mut()
);
