//! The slopes of a compact stencil: each is made of a whole line of texels, so lines are solved whole, many at once.

use super::border::Border;
use super::heights::{Height, Heights};
use super::line::Line;
use super::operator::{self, Axis};
use super::simd::{Kernel, Simd};
use super::stencil::Stencil;
use super::stream::Ahead;
use crate::step::scalar::Arith;
use crate::tableau::DoubleDouble as D;

/// Lines solved at once: two of the widest vectors of `f64`.
const LANES: usize = 16;
/// Rows asked for before they are read.
const AHEAD: usize = 16;

/// The slopes of a map, solved for in `f64`; what exceeds `f32` is its largest number.
pub(super) struct Slopes {
    size: [usize; 2],
    s: Vec<f32>,
    t: Columns,
}

/// A map by blocks of columns, as they are solved, each block row by row.
struct Columns {
    height: usize,
    blocks: Vec<[f32; LANES]>,
}

struct Solve<'a> {
    line: &'a Line<f64>,
    from: &'a [[f64; LANES]],
    to: &'a mut [[f64; LANES]],
}

impl Kernel for Solve<'_> {
    type Output = ();
    #[inline(always)]
    fn run<A: Arith>(self) {
        self.line.apply(self.from, self.to);
    }
}

impl Slopes {
    /// Differences times `scale`. A height that is not finite counts as zero.
    pub(super) fn new<H: Height>(
        stencil: &Stencil,
        heights: &Heights<H>,
        border: [Border; 2],
        scale: [D; 2],
    ) -> Self {
        let size = heights.size();
        let lines = |axis: Axis| {
            let i = axis as usize;
            operator::lines(stencil, axis, size[i], border[i], scale[i])
        };
        let ([along_s, across_s], [along_t, across_t]) = (lines(Axis::S), lines(Axis::T));
        // What is smoothed is smoothed first, along the other axis.
        let s = if across_t.identity() {
            rows(heights, &along_s)
        } else {
            let smooth = columns(heights, &across_t).in_rows(size[0]);
            rows(&Heights { texels: &smooth, width: size[0], height: size[1] }, &along_s)
        };
        let t = if across_s.identity() {
            columns(heights, &along_t)
        } else {
            let smooth = rows(heights, &across_s);
            columns(&Heights { texels: &smooth, width: size[0], height: size[1] }, &along_t)
        };
        Self { size, s, t }
    }

    pub(super) fn at(&self, x: usize, y: usize) -> [f64; 2] {
        [self.s[x + y * self.size[0]], self.t.at(x, y)].map(f64::from)
    }

    /// Those from a texel on, row after row.
    pub(super) fn run(&self, first: usize, s: &mut [f32], t: &mut [f32]) {
        s.copy_from_slice(&self.s[first..first + s.len()]);
        let (width, mut done) = (self.size[0], 0);
        while done < t.len() {
            let (x, y) = ((first + done) % width, (first + done) / width);
            let len = (LANES - x % LANES).min(width - x).min(t.len() - done);
            t[done..done + len]
                .copy_from_slice(&self.t.blocks[x / LANES * self.t.height + y][x % LANES..][..len]);
            done += len;
        }
    }
}

impl Columns {
    fn in_rows(&self, width: usize) -> Vec<f32> {
        (0..self.height).flat_map(|y| (0..width).map(move |x| self.at(x, y))).collect()
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        self.blocks[x / LANES * self.height + y][x % LANES]
    }
}

#[inline(always)]
fn known(height: impl Height) -> f64 {
    if height.finite() { height.steps().into() } else { 0.0 }
}

#[inline(always)]
fn store(x: f64) -> f32 {
    x.clamp(f32::MIN.into(), f32::MAX.into()) as f32
}

/// What is read of some lines, and what is made of it.
type Room = [Vec<[f64; LANES]>; 2];

fn room(n: usize) -> Room {
    [vec![[0.0; LANES]; n], vec![[0.0; LANES]; n]]
}

/// The line map on all rows.
fn rows<H: Height>(heights: &Heights<H>, line: &Line<f64>) -> Vec<f32> {
    let [width, height] = heights.size();
    let (simd, mut all) = (Simd::widest(), vec![0.0; width * height]);
    let work = |[from, to]: &mut Room, block: usize, out: &mut [f32]| {
        let lanes = out.len() / width;
        // By tiles: what one lane writes to is near for the next.
        for (first, tile) in (0..).step_by(LANES).zip(from.chunks_mut(LANES)) {
            for lane in 0..lanes {
                let row = &heights.row(LANES * block + lane)[first..];
                for (from, height) in tile.iter_mut().zip(row) {
                    from[lane] = known(*height);
                }
            }
        }
        simd.run(Solve { line, from, to });
        for (first, tile) in (0..).step_by(LANES).zip(to.chunks(LANES)) {
            for (lane, row) in out.chunks_mut(width).enumerate() {
                for (out, to) in row[first..].iter_mut().zip(tile) {
                    *out = store(to[lane]);
                }
            }
        }
    };
    each(&mut all, LANES * width, || room(width), work);
    all
}

/// The line map on all columns.
fn columns<H: Height>(heights: &Heights<H>, line: &Line<f64>) -> Columns {
    let [width, height] = heights.size();
    let (simd, mut blocks) = (Simd::widest(), vec![[0.0; LANES]; width.div_ceil(LANES) * height]);
    let work = |[from, to]: &mut Room, block: usize, out: &mut [[f32; LANES]]| {
        let (first, last) = (LANES * block, (LANES * (block + 1)).min(width));
        for (y, from) in from.iter_mut().enumerate() {
            // A line of the cache from each row: nothing but this asks for it in time.
            let below = &heights.row((y + AHEAD).min(height - 1))[first..last];
            Ahead::of(below).ask(size_of_val(below));
            for (from, height) in from.iter_mut().zip(&heights.row(y)[first..last]) {
                *from = known(*height);
            }
        }
        simd.run(Solve { line, from, to });
        for (out, to) in out.iter_mut().zip(&*to) {
            for (out, to) in out.iter_mut().zip(to) {
                *out = store(*to);
            }
        }
    };
    each(&mut blocks, height, || room(height), work);
    Columns { height, blocks }
}

/// Works on blocks of `size`, with the feature `rayon` on all threads.
pub(super) fn each<T: Send, R: Send>(
    all: &mut [T],
    size: usize,
    room: impl Fn() -> R + Send + Sync,
    work: impl Fn(&mut R, usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        all.par_chunks_mut(size)
            .enumerate()
            .for_each_init(room, |room, (block, part)| work(room, block, part));
    }
    #[cfg(not(feature = "rayon"))]
    {
        let mut room = room();
        all.chunks_mut(size).enumerate().for_each(|(block, part)| work(&mut room, block, part));
    }
}
