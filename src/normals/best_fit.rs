//! The length of a stored vector chosen for its direction: a decoder that makes it unit again loses nothing.
//!
//! The levels of a channel of 8 bits are the odd numbers from -255 to 255. The largest component is given each
//! of the 128 sizes in turn and the others the odd numbers nearest to where the direction goes; the vector
//! whose direction is nearest is kept. See Kaplanyan (2010), CryENGINE 3: reaching the speed of light.

use super::heights::Height;
use super::normal::squeeze;
use crate::step::scalar::{Arith, Plain};

/// Directions searched for at once.
const BLOCK: usize = 32;

/// The nearest odd number.
#[inline(always)]
fn odd(x: f32) -> f32 {
    // Adding 1.5 x 2^23 rounds to an integer, of either sign.
    const INTEGERS: f32 = 12582912.0;
    2.0 * ((x * 0.5 - 0.5 + INTEGERS) - INTEGERS) + 1.0
}

/// The level of an odd number.
#[inline(always)]
fn level(x: f32) -> u32 {
    (x * 0.5 + 127.5) as u32
}

/// The levels R | G << 8 | B << 16 nearest in direction to each of (x, y, z), whose largest component is 1.
#[inline(always)]
fn search<A: Arith>([x, y, z]: &[[f32; BLOCK]; 3], out: &mut [u32; BLOCK]) {
    let (mut error, mut length, mut size) = ([f32::MAX; BLOCK], [1f32; BLOCK], [255f32; BLOCK]);
    for m in (0..128).map(|i| (2 * i + 1) as f32) {
        for i in 0..BLOCK {
            let d = [x[i], y[i], z[i]];
            let v = d.map(|d| odd(m * d));
            // The sine between v and d: |v x d| = |(v - m d) x d|, of which the first factor is small and exact.
            let e = [0, 1, 2].map(|k| A::term::<f32>(-m, d[k], v[k]));
            let cross = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| A::term::<f32>(e[j], d[k], -e[k] * d[j]));
            let square = |v: [f32; 3]| A::term::<f32>(v[0], v[0], A::term::<f32>(v[1], v[1], v[2] * v[2]));
            let (cross, v) = (square(cross), square(v));
            let better = cross * length[i] < error[i] * v;
            error[i] = if better { cross } else { error[i] };
            length[i] = if better { v } else { length[i] };
            size[i] = if better { m } else { size[i] };
        }
    }
    for i in 0..BLOCK {
        let [r, g, b] = [x[i], y[i], z[i]].map(|d| level(odd(size[i] * d)));
        out[i] = r | g << 8 | b << 16;
    }
}

/// Packs (x, y, 1) for a chunk; false where one is not finite.
#[inline(always)]
pub(super) fn write<A: Arith>(x: &[f32], y: &[f32], work: &mut [u32], out: &mut [[u8; 3]]) -> bool {
    let n = out.len();
    for first in (0..n).step_by(BLOCK) {
        let len = BLOCK.min(n - first);
        let mut direction = [[0.0; BLOCK], [0.0; BLOCK], [1.0; BLOCK]];
        for i in 0..len {
            let (x, y) = (x[first + i], y[first + i]);
            let largest = x.abs().max(y.abs()).max(1.0);
            for (to, x) in direction.iter_mut().zip([x, y, 1.0]) {
                to[i] = x / largest;
            }
        }
        let mut block = [0; BLOCK];
        search::<A>(&direction, &mut block);
        work[first..first + len].copy_from_slice(&block[..len]);
    }
    squeeze(&work[..n], out);
    f32::all_finite(&x[..n]) & f32::all_finite(&y[..n])
}

/// A unit normal in RGB8 whose length is chosen so that its direction is nearest.
pub fn pack_best_fit(normal: [f32; 3]) -> [u8; 3] {
    let largest = normal.iter().fold(0f32, |largest, x| largest.max(x.abs()));
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let mut block = [0; BLOCK];
    search::<Plain>(&normal.map(|x| [x / largest; BLOCK]), &mut block);
    let [r, g, b, _] = block[0].to_le_bytes();
    [r, g, b]
}
