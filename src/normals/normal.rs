//! Unit normals and the texels they are packed into.

use super::best_fit;
use super::heights::Height;
use super::simd::Kernel;
use super::stream::{self, Ahead, Bytes};
use crate::step::scalar::{Arith, Plain};

/// Texels worked on at once: what belongs to them stays in the nearest cache.
pub(super) const CHUNK: usize = 1024;

pub(super) mod sealed {
    use super::Arith;

    /// Packs a chunk.
    pub trait Write: Sized {
        /// (x, y, 1) made unit and packed; `work` holds a number for every texel. False where x^2 + y^2
        /// overflows or is no number: what is written is then to be written again.
        fn write<A: Arith>(x: &[f32], y: &[f32], work: &mut [u32], out: &mut [Self]) -> bool;
        /// The same with the length that keeps the direction best, where that is a choice.
        #[inline(always)]
        fn write_best<A: Arith>(x: &[f32], y: &[f32], work: &mut [u32], out: &mut [Self]) -> bool {
            Self::write::<A>(x, y, work, out)
        }
        /// Of (x, y, 1), whatever its size.
        fn one(x: f64, y: f64, best: bool) -> Self;
    }
}

/// A texel of a normal map: its type says the packing.
///
/// `[f32; 3]` is the unit normal. The others store channels of n bits, R = (x + 1)/2, G = (y + 1)/2 and, where
/// there are three, B = (z + 1)/2, as q = floor(R (2^n - 1) + 1/2), which [`decode`](Self::decode) takes back
/// to 2 q/(2^n - 1) - 1. Zero is halfway between two q and goes up: the flat normal is (128, 128, 255) in RGB8
/// and leans by 0.32 degrees once decoded, (32768, 32768, 65535) in RGB16 by 0.0012. With two channels z
/// follows as the positive root.
pub trait Normal: sealed::Write + Bytes + Default + Send + Sync + 'static {
    /// Of a unit normal.
    fn pack(normal: [f32; 3]) -> Self;
    /// What is stored: `pack(decode(q)) = q`.
    fn decode(self) -> [f32; 3];
    /// What is stored, made unit. Stored zero is flat.
    fn unpack(self) -> [f32; 3] {
        let [x, y, z] = self.decode();
        let length = (x * x + y * y + z * z).sqrt();
        if length > 0.0 { [x / length, y / length, z / length] } else { [0.0, 0.0, 1.0] }
    }
}

/// floor((x + 1)/2 (2^n - 1) + 1/2), of -1 <= x <= 1, in the lowest bits; those above are to be cut off.
#[inline(always)]
pub(super) fn quantise<A: Arith>(x: f32, most: f32) -> u32 {
    // Numbers from 2^23 to 2^24 are the integers: adding 2^23 rounds, and the lowest bits are the answer. It
    // is far cheaper than a conversion that must saturate.
    const INTEGERS: f32 = 8388608.0;
    let half = most / 2.0;
    (A::term::<f32>(half, x, half) + INTEGERS).to_bits()
}

/// 2 q/(2^n - 1) - 1
fn level(q: u32, most: f32) -> f32 {
    // q and its double are exact, so is their distance from the middle: one rounding.
    (2.0 * q as f32 - most) / most
}

/// (x, y, 1) over its length: squares of products of two `f32` do not overflow.
fn unit_f64(x: f64, y: f64) -> [f32; 3] {
    let length = (x * x + y * y + 1.0).sqrt();
    [x / length, y / length, 1.0 / length].map(|x| x as f32)
}

/// 1/sqrt(x) of x >= 1 to 9e-8: a start from the halved exponent, off by 3.5e-2, a step of third order to 1e-4 and
/// one of Newton's, which rounds its correction, not the root. The root and the division of the hardware, which
/// are rounded twice as well, take several times as long.
#[inline(always)]
fn one_over_root<A: Arith>(x: f32) -> f32 {
    let y = f32::from_bits(0x5f37_5a86u32.wrapping_sub(x.to_bits() >> 1));
    // 1/sqrt(x) = y (1 - e)^(-1/2) = y (1 + e/2 + 3 e^2/8 + ..)
    let off = |y: f32| A::term::<f32>(-(x * y), y, 1.0);
    let e = off(y);
    let y = A::term::<f32>(y * e, A::term::<f32>(0.375, e, 0.5), y);
    A::term::<f32>(0.5 * y, off(y), y)
}

/// (x, y, 1) over its length, and the square of that.
#[inline(always)]
fn unit<A: Arith>(x: f32, y: f32) -> ([f32; 3], f32) {
    let square = A::term::<f32>(x, x, A::term::<f32>(y, y, 1.0));
    let z = one_over_root::<A>(square);
    ([x * z, y * z, z], square)
}

/// One pass over a chunk: `put` stores a unit normal.
#[inline(always)]
fn each<A: Arith, O>(x: &[f32], y: &[f32], out: &mut [O], put: impl Fn(&mut O, [f32; 3])) -> bool {
    let n = out.len();
    let (x, y) = (&x[..n], &y[..n]);
    let mut wrong = 0;
    for i in 0..n {
        let (normal, square) = unit::<A>(x[i], y[i]);
        // A number that is none compares false.
        wrong |= u32::from(!(square <= f32::MAX));
        put(&mut out[i], normal);
    }
    wrong == 0
}

impl sealed::Write for [f32; 3] {
    #[inline(always)]
    fn write<A: Arith>(x: &[f32], y: &[f32], _: &mut [u32], out: &mut [Self]) -> bool {
        each::<A, _>(x, y, out, |out, normal| *out = normal)
    }
    fn one(x: f64, y: f64, _: bool) -> Self {
        Self::pack(unit_f64(x, y))
    }
}

impl Normal for [f32; 3] {
    fn pack(normal: [f32; 3]) -> Self {
        normal
    }
    fn decode(self) -> [f32; 3] {
        self
    }
}

impl sealed::Write for [u8; 3] {
    #[inline(always)]
    fn write<A: Arith>(x: &[f32], y: &[f32], work: &mut [u32], out: &mut [Self]) -> bool {
        let work = &mut work[..out.len()];
        let fine = each::<A, _>(x, y, work, |out, n| {
            let [r, g, b] = n.map(|x| quantise::<A>(x, 255.0));
            *out = (r | g << 8 | b << 16) & 0xff_ffff;
        });
        squeeze(work, out);
        fine
    }
    #[inline(always)]
    fn write_best<A: Arith>(x: &[f32], y: &[f32], work: &mut [u32], out: &mut [Self]) -> bool {
        best_fit::write::<A>(x, y, work, out)
    }
    fn one(x: f64, y: f64, best: bool) -> Self {
        let normal = unit_f64(x, y);
        if best { best_fit::pack_best_fit(normal) } else { Self::pack(normal) }
    }
}

/// The three lower bytes of each number: four numbers make three.
#[inline(always)]
pub(super) fn squeeze(texels: &[u32], out: &mut [[u8; 3]]) {
    let (fours, rest) = texels.as_chunks::<4>();
    let (twelves, end) = out.as_flattened_mut().as_chunks_mut::<12>();
    for (q, out) in fours.iter().zip(twelves) {
        let three = [q[0] | q[1] << 24, q[1] >> 8 | q[2] << 16, q[2] >> 16 | q[3] << 8];
        for (out, q) in out.as_chunks_mut::<4>().0.iter_mut().zip(three) {
            *out = q.to_le_bytes();
        }
    }
    for (q, out) in rest.iter().zip(end.as_chunks_mut::<3>().0) {
        let [r, g, b, _] = q.to_le_bytes();
        *out = [r, g, b];
    }
}

macro_rules! channels {
    ($t:ident) => {
        impl Normal for [$t; 3] {
            fn pack(normal: [f32; 3]) -> Self {
                normal.map(|x| quantise::<Plain>(x.clamp(-1.0, 1.0), $t::MAX.into()) as $t)
            }
            fn decode(self) -> [f32; 3] {
                self.map(|q| level(q.into(), $t::MAX.into()))
            }
        }

        impl sealed::Write for [$t; 2] {
            #[inline(always)]
            fn write<A: Arith>(x: &[f32], y: &[f32], _: &mut [u32], out: &mut [Self]) -> bool {
                each::<A, _>(x, y, out, |out, [x, y, _]| {
                    *out = [x, y].map(|x| quantise::<A>(x, $t::MAX.into()) as $t);
                })
            }
            fn one(x: f64, y: f64, _: bool) -> Self {
                Self::pack(unit_f64(x, y))
            }
        }

        impl Normal for [$t; 2] {
            fn pack([x, y, _]: [f32; 3]) -> Self {
                [x, y].map(|x| quantise::<Plain>(x.clamp(-1.0, 1.0), $t::MAX.into()) as $t)
            }
            fn decode(self) -> [f32; 3] {
                let [x, y] = self.map(|q| level(q.into(), $t::MAX.into()));
                [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]
            }
        }
    };
}
channels!(u8);
channels!(u16);

impl sealed::Write for [u16; 3] {
    #[inline(always)]
    fn write<A: Arith>(x: &[f32], y: &[f32], _: &mut [u32], out: &mut [Self]) -> bool {
        each::<A, _>(x, y, out, |out, normal| {
            *out = normal.map(|x| quantise::<A>(x, 65535.0) as u16);
        })
    }
    fn one(x: f64, y: f64, _: bool) -> Self {
        Self::pack(unit_f64(x, y))
    }
}

/// Slopes as they are.
impl sealed::Write for [f32; 2] {
    #[inline(always)]
    fn write<A: Arith>(x: &[f32], y: &[f32], _: &mut [u32], out: &mut [Self]) -> bool {
        let n = out.len();
        for ((x, y), out) in x[..n].iter().zip(&y[..n]).zip(out) {
            *out = [*x, *y];
        }
        // Where a sum overflowed on the way, or the slope itself does.
        f32::all_finite(&x[..n]) & f32::all_finite(&y[..n])
    }
    fn one(x: f64, y: f64, _: bool) -> Self {
        [x, y].map(|x| x.clamp(f32::MIN.into(), f32::MAX.into()) as f32)
    }
}

/// Texels staged before they are stored past the cache: few enough that the stores drain while the next ones are
/// worked out.
const STAGE: usize = 64;

/// A chunk of normals, or of slopes, to be written.
pub(super) struct Pack<'a, W> {
    pub best: bool,
    /// Past the cache.
    pub past: bool,
    pub x: &'a [f32],
    pub y: &'a [f32],
    pub work: &'a mut [u32],
    pub out: &'a mut [W],
    /// Texels that are new to the cache, on their way while these are worked out.
    pub ahead: Ahead,
}

impl<W: sealed::Write + Bytes + Default> Kernel for Pack<'_, W> {
    type Output = bool;
    #[inline(always)]
    fn run<A: Arith>(self) -> bool {
        let Self { best, past, x, y, work, out, mut ahead } = self;
        if best {
            return W::write_best::<A>(x, y, work, out);
        }
        if !past {
            return W::write::<A>(x, y, work, out);
        }
        let share = ahead.share(out.len().div_ceil(STAGE));
        let (mut staged, mut fine) = ([W::default(); STAGE], true);
        for ((x, y), out) in x.chunks(STAGE).zip(y.chunks(STAGE)).zip(out.chunks_mut(STAGE)) {
            let staged = &mut staged[..out.len()];
            ahead.ask(share);
            fine &= W::write::<A>(x, y, work, staged);
            // SAFETY: who asks for it ends with a fence.
            unsafe { stream::copy(staged, out) };
        }
        fine
    }
}

#[cfg(test)]
mod tests {
    use super::one_over_root;
    use crate::step::scalar::{Fused, Plain};

    #[test]
    fn one_over_root_is_good_to_1e_7() {
        // All of two octaves in steps of 7, for the halved exponent takes the parity along, and the far end.
        let octaves = (1f32.to_bits()..4f32.to_bits()).step_by(7).map(f32::from_bits);
        for x in octaves.chain([1e10, 1e20, 3e30, f32::MAX]) {
            let exact = 1.0 / f64::from(x).sqrt();
            for y in [one_over_root::<Plain>(x), one_over_root::<Fused>(x)] {
                // Without fused products the correction is rounded as well.
                assert!((f64::from(y) / exact - 1.0).abs() < 1.2e-7, "{x}: {y}");
            }
            assert!((f64::from(one_over_root::<Fused>(x)) / exact - 1.0).abs() < 1e-7, "{x}");
        }
    }
}
