//! The bake: heights in, normals out.

use super::border::Border;
use super::compact::{self, Slopes};
use super::error::BakeError;
use super::heights::{Height, Heights};
use super::map::Map;
use super::missing;
use super::mix::Mixes;
use super::normal::sealed::Write;
use super::normal::{CHUNK, Normal, Pack};
use super::operator::{self, Axis};
use super::simd::Simd;
use super::stencil::Stencil;
use super::stream::{Ahead, Bytes};
use crate::tableau::DoubleDouble as D;

/// Which way green points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Green {
    /// Up the picture, along t: OpenGL, glTF.
    #[default]
    Up,
    /// Down the picture: DirectX.
    Down,
}

/// How a height map becomes a normal map: n = (-b_s, -b_t, 1) over its length, with the slopes
/// `height_scale (stencil . b) / texel_size`, s to the right and t up.
///
/// It starts with a height scale of 1, texels of 1 by 1, borders that wrap, green up, rounding to the nearest
/// level, and heights that are not finite refused.
#[derive(Clone, Copy)]
pub struct Bake<'s> {
    pub(super) stencil: &'s Stencil<'s>,
    height_scale: f64,
    texel_size: [f64; 2],
    pub(super) border: [Border; 2],
    green: Green,
    pub(super) best_fit: bool,
    missing_as_border: bool,
}

impl<'s> Bake<'s> {
    pub fn new(stencil: &'s Stencil<'s>) -> Self {
        Self {
            stencil,
            height_scale: 1.0,
            texel_size: [1.0; 2],
            border: [Border::Wrap; 2],
            green: Green::Up,
            best_fit: false,
            missing_as_border: false,
        }
    }

    /// The height of 1, white in a map of integers, in units of length. Negative for a depth map.
    pub fn height_scale(self, height_scale: f64) -> Self {
        Self { height_scale, ..self }
    }

    /// The width and height of a texel, in the same unit: the size of the tile over its pixels.
    pub fn texel_size(self, texel_size: [f64; 2]) -> Self {
        Self { texel_size, ..self }
    }

    /// What lies beyond the edges along s and along t.
    pub fn border(self, border: [Border; 2]) -> Self {
        Self { border, ..self }
    }

    pub fn green(self, green: Green) -> Self {
        Self { green, ..self }
    }

    /// Chooses the length of what RGB8 stores so that its direction is nearest, for decoders that make it unit
    /// again: about a quarter of the error of rounding, at some cost in time. Other packings are as before.
    pub fn best_fit(self, best_fit: bool) -> Self {
        Self { best_fit, ..self }
    }

    /// Takes heights that are NaN or infinite for places where there is no map, instead of refusing them.
    ///
    /// Such a texel is flat. One whose stencil touches such a texel takes, along that axis, the unsmoothed
    /// difference of the texels of its row or column up to the next missing one or the edge of the map, one-sided
    /// at either end: of the stencil's order, or of what their number allows; alone it is flat.
    pub fn missing_as_border(self, missing_as_border: bool) -> Self {
        Self { missing_as_border, ..self }
    }

    /// The slopes `[b_s, b_t]` in world units, the top row first; what exceeds `f32` is its largest number.
    pub fn slopes(&self, heights: &Heights<impl Height>) -> Result<Vec<[f32; 2]>, BakeError> {
        let mut out = vec![[0.0; 2]; heights.texels.len()];
        self.run(heights, [1.0, 1.0], &mut out)?;
        Ok(out)
    }

    /// The normal map, the top row first.
    pub fn normals<N: Normal>(&self, heights: &Heights<impl Height>) -> Result<Vec<N>, BakeError> {
        let mut out = vec![N::default(); heights.texels.len()];
        self.normals_into(heights, &mut out)?;
        Ok(out)
    }

    /// The same, written to where it is wanted. With the feature `rayon`, by all threads of the current pool.
    /// After an error what `out` holds has no meaning.
    pub fn normals_into<N: Normal>(
        &self,
        heights: &Heights<impl Height>,
        out: &mut [N],
    ) -> Result<(), BakeError> {
        let need = heights.texels.len();
        if out.len() != need {
            return Err(BakeError::Length { len: out.len(), need });
        }
        self.run(heights, self.tilt(), out)
    }

    /// The normal map of slopes, of one of their [`mips`](super::mips()) for instance.
    pub fn pack<N: Normal>(&self, slopes: &[[f32; 2]]) -> Vec<N> {
        let mut out = vec![N::default(); slopes.len()];
        let [s, t] = self.tilt();
        let one = |i: usize| [s * f64::from(slopes[i][0]), t * f64::from(slopes[i][1])];
        let run = |first: usize, x: &mut [f32], y: &mut [f32]| {
            for (i, (x, y)) in (first..).zip(x.iter_mut().zip(y)) {
                [*x, *y] = one(i).map(|slope| slope as f32);
            }
        };
        self.pack_slopes(run, one, &mut out);
        out
    }

    /// The same with another stencil.
    pub(super) fn with<'o>(&self, stencil: &'o Stencil<'o>) -> Bake<'o> {
        let Self { height_scale, texel_size, border, green, best_fit, missing_as_border, .. } = *self;
        Bake { stencil, height_scale, texel_size, border, green, best_fit, missing_as_border }
    }

    /// The signs that slopes take in a normal.
    pub(super) fn tilt(&self) -> [f64; 2] {
        [-1.0, if self.green == Green::Up { -1.0 } else { 1.0 }]
    }

    /// What a difference of heights is multiplied by, along s and t.
    pub(super) fn scale(&self) -> Result<[D; 2], BakeError> {
        let Self { height_scale, texel_size, .. } = *self;
        if !height_scale.is_finite() {
            return Err(BakeError::HeightScale(height_scale));
        }
        if !texel_size.iter().all(|size| *size > 0.0 && size.is_finite()) {
            return Err(BakeError::TexelSize(texel_size));
        }
        // Weights are larger than 1 by little: a billion leaves room for them.
        if texel_size.iter().any(|size| !((height_scale / size).abs() < f64::from(f32::MAX) / 1e9)) {
            return Err(BakeError::Slope { height_scale, texel_size });
        }
        Ok(texel_size.map(|size| D::of(height_scale) / D::of(size)))
    }

    fn run<H: Height, W: Write + Bytes + Default + Send>(
        &self,
        heights: &Heights<H>,
        sign: [f64; 2],
        out: &mut [W],
    ) -> Result<(), BakeError> {
        operator::check(self.stencil, heights.size())?;
        let scale = self.scale()?;
        let scale = [0, 1].map(|i| scale[i] * D::of(sign[i]) / D::of(H::WHITE));
        if self.stencil.left.len > 1 {
            return self.run_compact(heights, scale, out);
        }
        let map = self.map(*heights, scale);
        if map.bake(out) {
            return Ok(());
        }
        self.refuse(heights)?;
        let touches = |axis, x, y| map.touches(axis, x, y);
        missing::repair(self, heights, scale, |x, y| map.slope(x, y), touches, out);
        Ok(())
    }

    /// A compact stencil couples every texel of a line: the whole map at once, in `f64`.
    fn run_compact<H: Height, W: Write + Bytes + Default + Send>(
        &self,
        heights: &Heights<H>,
        scale: [D; 2],
        out: &mut [W],
    ) -> Result<(), BakeError> {
        let finite = H::all_finite(heights.texels);
        if !finite {
            self.refuse(heights)?;
        }
        let slopes = Slopes::new(self.stencil, heights, self.border, scale);
        let width = heights.width;
        self.pack_slopes(|first, x, y| slopes.run(first, x, y), |i| slopes.at(i % width, i / width), out);
        if !finite {
            let near = |axis, x, y| missing::near(self, heights, axis, [x, y]);
            missing::repair(self, heights, scale, |x, y| slopes.at(x, y), near, out);
        }
        Ok(())
    }

    fn refuse(&self, heights: &Heights<impl Height>) -> Result<(), BakeError> {
        match heights.missing() {
            Some(error) if !self.missing_as_border => Err(error),
            _ => Ok(()),
        }
    }

    /// Packs slopes that have their signs: `run` gives those from some texel on, `one` those of a texel.
    fn pack_slopes<W: Write + Bytes + Default + Send>(
        &self,
        run: impl Fn(usize, &mut [f32], &mut [f32]) + Sync,
        one: impl Fn(usize) -> [f64; 2] + Sync,
        out: &mut [W],
    ) {
        let simd = Simd::widest();
        let room = || (vec![0.0; CHUNK], vec![0.0; CHUNK], vec![0; CHUNK]);
        compact::each(out, CHUNK, room, |(x, y, work), chunk, out| {
            let (x, y) = (&mut x[..out.len()], &mut y[..out.len()]);
            run(chunk * CHUNK, x, y);
            let pack =
                Pack { best: self.best_fit, past: false, x, y, work, out, ahead: Ahead::of::<u8>(&[]) };
            if !simd.run(pack) {
                for (i, out) in (chunk * CHUNK..).zip(out) {
                    let [x, y] = one(i);
                    *out = W::one(x, y, self.best_fit);
                }
            }
        });
    }

    pub(super) fn map<'a, H: Height>(&self, heights: Heights<'a, H>, scale: [D; 2]) -> Map<'a, H> {
        let [width, height] = heights.size();
        let lines = |axis, n, i: usize| operator::lines(self.stencil, axis, n, self.border[i], scale[i]);
        let [along_s, across_s] = lines(Axis::S, width, 0).map(Mixes::new);
        let [along_t, across_t] = lines(Axis::T, height, 1).map(Mixes::new);
        Map {
            heights,
            along: [along_s, along_t],
            across: [across_s, across_t],
            best: self.best_fit,
            simd: Simd::widest(),
        }
    }
}
