//! How a map is baked: chunk after chunk, slopes and normals of each while it stays in the nearest cache.

use super::heights::{Height, Heights};
use super::mix::{Mix, Mixes};
use super::normal::sealed::Write;
use super::normal::{CHUNK, Pack};
use super::operator::Axis;
use super::simd::{Kernel, Simd};
use super::stream::{self, Ahead, Bytes};
use crate::step::scalar::Arith;

/// Maps of more bytes than this are stored past the cache.
const CACHE: usize = 4 << 20;
/// Rows that one thread takes at a time.
#[cfg(feature = "rayon")]
const BAND: usize = 32;

/// A height map with the weights of every texel.
pub(super) struct Map<'a, H> {
    pub heights: Heights<'a, H>,
    /// For s and t: the difference along the axis, the smoothing along it for the other one.
    pub along: [Mixes; 2],
    pub across: [Mixes; 2],
    pub best: bool,
    pub simd: Simd,
}

/// What one thread works in.
struct Work {
    x: Vec<f32>,
    y: Vec<f32>,
    mixed: Vec<f32>,
    packed: Vec<u32>,
}

struct Finite<'a, H>(&'a [H]);

impl<H: Height> Kernel for Finite<'_, H> {
    type Output = bool;
    #[inline(always)]
    fn run<A: Arith>(self) -> bool {
        H::all_finite(self.0)
    }
}

impl<H: Height> Map<'_, H> {
    /// Bakes all rows. False where a height is not finite.
    pub(super) fn bake<W: Write + Bytes + Default + Send>(&self, out: &mut [W]) -> bool {
        self.rows(out, size_of_val(out) > CACHE)
    }

    /// The same, past the cache or into it.
    fn rows<W: Write + Bytes + Default + Send>(&self, out: &mut [W], past: bool) -> bool {
        let width = self.heights.width;
        let band = |(first, rows): (usize, &mut [W])| {
            let mut work = self.work();
            let mut finite = true;
            for (y, row) in rows.chunks_mut(width).enumerate() {
                for (i, out) in row.chunks_mut(CHUNK).enumerate() {
                    finite &= self.chunk(first + y, i * CHUNK, out, past, &mut work);
                }
            }
            if past {
                stream::fence();
            }
            finite
        };
        #[cfg(feature = "rayon")]
        if self.heights.height > BAND {
            use rayon::prelude::*;
            let bands = out.par_chunks_mut(BAND * width).enumerate();
            return bands.map(|(i, rows)| band((i * BAND, rows))).reduce(|| true, |a, b| a & b);
        }
        band((0, out))
    }

    fn work(&self) -> Work {
        let most = |mixes: &[Mixes; 2]| mixes[0].reach[0] + mixes[0].reach[1];
        let reach = most(&self.along).max(most(&self.across));
        Work {
            x: vec![0.0; CHUNK],
            y: vec![0.0; CHUNK],
            mixed: vec![0.0; CHUNK + reach],
            packed: vec![0; CHUNK],
        }
    }

    fn chunk<W: Write + Bytes + Default>(
        &self,
        y: usize,
        x0: usize,
        out: &mut [W],
        past: bool,
        work: &mut Work,
    ) -> bool {
        let n = out.len();
        let [along_s, along_t] = &self.along;
        let [across_s, across_t] = &self.across;
        self.sum(y, x0, across_t, along_s, &mut work.x[..n], &mut work.mixed);
        self.sum(y, x0, along_t, across_s, &mut work.y[..n], &mut work.mixed);
        // A row that is new to the cache is on its way while this one is worked out.
        let next = (y + 1 + along_t.reach[1].max(across_t.reach[1])).min(self.heights.height - 1);
        let ahead = Ahead::of(&self.heights.row(next)[x0..x0 + n]);
        let (x, slopes_t) = (&work.x[..n], &work.y[..n]);
        let pack = Pack { best: self.best, past, x, y: slopes_t, work: &mut work.packed, out, ahead };
        if !self.simd.run(pack) {
            for (i, out) in out.iter_mut().enumerate() {
                let [x, y] = self.slope(x0 + i, y);
                *out = W::one(x, y, self.best);
            }
        }
        self.simd.run(Finite(&self.heights.row(y)[x0..x0 + n]))
    }

    /// The weights down the column, then those along the row, of a run of texels.
    fn sum(&self, y: usize, x0: usize, down: &Mixes, along: &Mixes, out: &mut [f32], mixed: &mut [f32]) {
        let column = down.of(y);
        let fetch = |dy: isize| self.heights.row((y as isize + dy) as usize);
        let (end, inner) = (x0 + out.len(), &along.line.inner);
        let (from, to) = (inner.start.clamp(x0, end), inner.end.clamp(x0, end));
        if from < to {
            let out = &mut out[from - x0..to - x0];
            let shift = |x: usize, dx: isize| (x as isize + dx) as usize;
            if along.line.identity() {
                column.sum(self.simd, out, |dy| &fetch(dy)[from..to]);
            } else if down.line.identity() {
                let row = fetch(0);
                along.inner().sum(self.simd, out, |dx| &row[shift(from, dx)..shift(to, dx)]);
            } else {
                let [before, after] = along.reach;
                let (first, last) = (from - before, to + after);
                let mixed = &mut mixed[..last - first];
                column.sum(self.simd, mixed, |dy| &fetch(dy)[first..last]);
                let mixed = &*mixed;
                along.inner().sum(self.simd, out, |dx| &mixed[shift(before, dx)..][..to - from]);
            }
        }
        let one = |x: usize| match down.line.identity() {
            true => along.of(x).single(fetch(0), x),
            false => self.point(x, y, column, along.of(x)) as f32,
        };
        for x in (x0..from).chain(to.max(from)..end) {
            out[x - x0] = one(x);
        }
    }

    fn point(&self, x: usize, y: usize, column: &Mix, row: &Mix) -> f64 {
        let fetch = |dx: isize, dy: isize| {
            self.heights.row((y as isize + dy) as usize)[(x as isize + dx) as usize].steps()
        };
        row.at(|dx| column.at(|dy| fetch(dx, dy)))
    }

    /// Both sums of a texel in `f64`, where they do not overflow.
    pub(super) fn slope(&self, x: usize, y: usize) -> [f64; 2] {
        let [along_s, along_t] = &self.along;
        let [across_s, across_t] = &self.across;
        [self.point(x, y, across_t.of(y), along_s.of(x)), self.point(x, y, along_t.of(y), across_s.of(x))]
    }

    /// Whether the slope of a texel along an axis is made of a height that is not finite.
    pub(super) fn touches(&self, axis: Axis, x: usize, y: usize) -> bool {
        let (column, row) = match axis {
            Axis::S => (self.across[1].of(y), self.along[0].of(x)),
            Axis::T => (self.along[1].of(y), self.across[0].of(x)),
        };
        let to = |at: usize, by: isize| (at as isize + by) as usize;
        column.touches(|dy| row.touches(|dx| self.heights.bad(to(x, dx), to(y, dy))))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Bake, Border, Heights, Normal, Stencil, Taps};
    use super::*;
    use crate::tableau::DoubleDouble as D;

    const fn taps<const N: usize>(first: isize, of: [f64; N]) -> Taps {
        let (mut weight, mut i) = ([D::ZERO; 16], 0);
        while i < N {
            weight[i] = D::of(of[i]);
            i += 1;
        }
        Taps { first, len: N, weight }
    }

    const SMOOTH: Stencil = Stencil {
        title: "",
        cite: "",
        note: "",
        order: 2,
        digits: 0,
        at: D::ZERO,
        along: taps(-2, [-0.125, -0.25, 0.0, 0.25, 0.125]),
        across: taps(-1, [0.25, 0.5, 0.25]),
        left: taps(0, [1.0]),
    };

    fn agree<N: Normal, H: Height>(heights: Heights<H>, stencil: &Stencil, level: f32) {
        let bake = Bake::new(stencil).border([Border::Mirror, Border::OneSided]);
        for past in [false, true] {
            let all = Simd::all().into_iter().map(|simd| {
                let mut map = bake.map(heights, [D::of(3.0 / H::WHITE); 2]);
                map.simd = simd;
                let mut out = vec![N::default(); heights.texels.len()];
                assert!(map.rows(&mut out, past));
                out.into_iter().map(N::decode).collect::<Vec<_>>()
            });
            let all: Vec<_> = all.collect();
            for (a, b) in all[1..].iter().flat_map(|other| all[0].iter().zip(other)) {
                // Two channels leave z to a root.
                let stored = if size_of::<N>().is_multiple_of(3) { 3 } else { 2 };
                assert!(a[..stored].iter().zip(b).all(|(a, b)| (a - b).abs() < 1.01 * level));
            }
        }
    }

    #[test]
    fn every_width_of_vectors_gives_the_same() {
        // Odd widths, beyond one chunk: remainders of every kind, and stores that start anywhere.
        let stencils = [SMOOTH, Stencil { across: taps(0, [1.0]), ..SMOOTH }];
        for (stencil, width) in stencils.iter().flat_map(|s| [3, 37, 531].map(|w| (s, w))) {
            let floats: Vec<f32> = (0..width * 5).map(|i| (i * 7919 % 1009) as f32 / 1009.0).collect();
            let bytes: Vec<u8> = floats.iter().map(|h| (h * 255.0) as u8).collect();
            let [a, b] =
                [Heights::new(&floats, width, 5), Heights::new(&floats, width, 5)].map(Result::unwrap);
            // A fused sum may round to the other side of a tie.
            agree::<[f32; 3], f32>(a, stencil, 1e-6);
            agree::<[u8; 3], f32>(b, stencil, 2.0 / 255.0);
            agree::<[u8; 2], u8>(Heights::new(&bytes, width, 5).unwrap(), stencil, 2.0 / 255.0);
            agree::<[u16; 3], u8>(Heights::new(&bytes, width, 5).unwrap(), stencil, 2.0 / 65535.0);
        }
    }
}
