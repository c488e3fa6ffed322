//! Weighted sums of whole rows: what a stencil costs.

use super::heights::Height;
use super::line::Line;
use super::simd::{Kernel, Simd};
use crate::step::scalar::Arith;

/// Most runs summed in one pass: so many the compiler tells apart from where the sum goes, and with more it would
/// go texel by texel.
const TERMS: usize = 8;

/// A row of weights by offset. Opposite weights are kept as one, for a difference: it rounds where heights
/// differ, not where they are large.
#[derive(Default)]
pub(super) struct Mix {
    pairs: Vec<(isize, isize, f32)>,
    singles: Vec<(isize, f32)>,
}

/// The weights of every texel of a line.
pub(super) struct Mixes {
    pub line: Line<f32>,
    inner: Mix,
    ends: Vec<Mix>,
    /// How far the inner weights reach to either side.
    pub reach: [usize; 2],
}

impl Mix {
    fn new(entries: &[(isize, f32)]) -> Self {
        let mut mix = Mix::default();
        for &(at, w) in entries {
            match mix.singles.iter().position(|single| single.1 == -w) {
                // The positive weight goes first.
                Some(i) if w > 0.0 => mix.pairs.push((at, mix.singles.remove(i).0, w)),
                Some(i) => mix.pairs.push((mix.singles.remove(i).0, at, -w)),
                None => mix.singles.push((at, w)),
            }
        }
        mix.refer();
        mix
    }

    /// Where the single weights sum to zero but for their rounding, each but the largest becomes a difference
    /// from the texel of that one: equal heights then give zero, whatever the rounding of the weights.
    fn refer(&mut self) {
        let (sum, size) = self
            .singles
            .iter()
            .fold((0.0, 0.0), |(sum, size), single| (sum + single.1, size + single.1.abs()));
        // As many roundings of half an epsilon as there are weights, of the weights and of the sum.
        if sum.abs() > f32::EPSILON * self.singles.len() as f32 * size {
            return;
        }
        let Some(largest) =
            self.singles.iter().copied().reduce(|a, b| if b.1.abs() > a.1.abs() { b } else { a })
        else {
            return;
        };
        let others = self.singles.drain(..).filter(|single| single.0 != largest.0);
        self.pairs.extend(others.map(|(at, w)| (at, largest.0, w)));
    }

    /// The sum where a texel is fetched one at a time.
    pub(super) fn at<T: Into<f64>>(&self, fetch: impl Fn(isize) -> T) -> f64 {
        let fetch = |at| -> f64 { fetch(at).into() };
        let pairs = self.pairs.iter().map(|&(plus, minus, w)| (fetch(plus) - fetch(minus)) * f64::from(w));
        let singles = self.singles.iter().map(|&(at, w)| fetch(at) * f64::from(w));
        pairs.chain(singles).sum()
    }

    /// The sum of texel x of a row.
    pub(super) fn single<E: Height>(&self, row: &[E], x: usize) -> f32 {
        let fetch = |at: isize| row[(x as isize + at) as usize].steps();
        let pairs = self.pairs.iter().map(|&(plus, minus, w)| w * (fetch(plus) - fetch(minus)));
        pairs.chain(self.singles.iter().map(|&(at, w)| w * fetch(at))).sum()
    }

    /// The offsets it touches.
    pub(super) fn touches(&self, touched: impl FnMut(isize) -> bool) -> bool {
        let pair = self.pairs.iter().flat_map(|&(plus, minus, _)| [plus, minus]);
        pair.chain(self.singles.iter().map(|single| single.0)).any(touched)
    }

    /// The sums of a run: `fetch(offset)` gives the run that lies at that offset.
    pub(super) fn sum<'a, E: Height>(&self, simd: Simd, out: &mut [f32], fetch: impl Fn(isize) -> &'a [E]) {
        let mut add = false;
        for pairs in self.pairs.chunks(TERMS / 2) {
            let mut terms = Terms::new();
            for (k, &(plus, minus, w)) in pairs.iter().enumerate() {
                (terms.plus[k], terms.minus[k], terms.w[k]) = (fetch(plus), fetch(minus), w);
            }
            simd.run(Sum::<E, true> { out, terms: &terms, len: pairs.len(), add });
            add = true;
        }
        for singles in self.singles.chunks(TERMS) {
            let mut terms = Terms::new();
            for (k, &(at, w)) in singles.iter().enumerate() {
                (terms.plus[k], terms.w[k]) = (fetch(at), w);
            }
            simd.run(Sum::<E, false> { out, terms: &terms, len: singles.len(), add });
            add = true;
        }
        if !add {
            out.fill(0.0);
        }
    }
}

impl Mixes {
    pub(super) fn new(line: Line<f32>) -> Self {
        let inner = Mix::new(&line.taps);
        let end = |i: usize| {
            let entries: Vec<_> = line.end(i).iter().map(|&(at, w)| (at as isize - i as isize, w)).collect();
            Mix::new(&entries)
        };
        let ends = (0..line.inner.start).chain(line.inner.end..line.n).map(end).collect();
        let reach = |sign: isize| line.taps.iter().map(|tap| (sign * tap.0).max(0)).max().unwrap_or(0);
        let reach = [reach(-1) as usize, reach(1) as usize];
        Self { line, inner, ends, reach }
    }

    pub(super) fn inner(&self) -> &Mix {
        &self.inner
    }

    /// The weights of texel i, by offset from it.
    pub(super) fn of(&self, i: usize) -> &Mix {
        if self.line.inner.contains(&i) {
            &self.inner
        } else if i < self.line.inner.start {
            &self.ends[i]
        } else {
            &self.ends[self.line.inner.start + i - self.line.inner.end]
        }
    }
}

struct Terms<'a, E> {
    plus: [&'a [E]; TERMS],
    minus: [&'a [E]; TERMS],
    w: [f32; TERMS],
}

impl<E> Terms<'_, E> {
    fn new() -> Self {
        Self { plus: [&[]; TERMS], minus: [&[]; TERMS], w: [0.0; TERMS] }
    }
}

struct Sum<'a, E, const PAIRS: bool> {
    out: &'a mut [f32],
    terms: &'a Terms<'a, E>,
    len: usize,
    add: bool,
}

impl<E: Height, const PAIRS: bool> Kernel for Sum<'_, E, PAIRS> {
    type Output = ();
    #[inline(always)]
    fn run<A: Arith>(self) {
        let Self { out, terms, len, add } = self;
        match len {
            1 => sum::<A, E, PAIRS, 1>(out, terms, add),
            2 => sum::<A, E, PAIRS, 2>(out, terms, add),
            3 => sum::<A, E, PAIRS, 3>(out, terms, add),
            4 => sum::<A, E, PAIRS, 4>(out, terms, add),
            5 => sum::<A, E, PAIRS, 5>(out, terms, add),
            6 => sum::<A, E, PAIRS, 6>(out, terms, add),
            7 => sum::<A, E, PAIRS, 7>(out, terms, add),
            _ => sum::<A, E, PAIRS, 8>(out, terms, add),
        }
    }
}

/// The number of terms is a constant, so that the sum stays in registers.
#[inline(always)]
fn sum<A: Arith, E: Height, const PAIRS: bool, const K: usize>(out: &mut [f32], terms: &Terms<E>, add: bool) {
    let n = out.len();
    let plus: [&[E]; K] = std::array::from_fn(|k| &terms.plus[k][..n]);
    let minus: [&[E]; K] = std::array::from_fn(|k| if PAIRS { &terms.minus[k][..n] } else { plus[k] });
    let w: [f32; K] = std::array::from_fn(|k| terms.w[k]);
    let term = |k: usize, i: usize| {
        if PAIRS { plus[k][i].steps() - minus[k][i].steps() } else { plus[k][i].steps() }
    };
    if add {
        for (i, out) in out.iter_mut().enumerate() {
            *out = (0..K).fold(*out, |sum, k| A::term(w[k], term(k, i), sum));
        }
    } else {
        for (i, out) in out.iter_mut().enumerate() {
            *out = (1..K).fold(w[0] * term(0, i), |sum, k| A::term(w[k], term(k, i), sum));
        }
    }
}
