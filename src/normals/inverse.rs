//! Heights from slopes: the operator inverted by its own symbol.
//!
//! Dividing by i k would give the heights whose exact slopes these are. Dividing by what the stencil made of
//! each wave gives those that were baked.

use super::bake::Bake;
use super::border::Border;
use super::error::BakeError;
use super::normal::Normal;
use super::operator::{Axis, Operator};
use crate::step::scalar::Real;
use num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Heights of mean 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Integral<T> {
    /// The top row first.
    pub heights: Vec<T>,
    /// How many waves besides the mean the stencil does not see: they are left out. Central stencils lose the
    /// three that alternate from texel to texel, on maps of even size; those that smooth lose whole lines.
    pub lost: usize,
}

/// Below this a wave's symbol is zero but for rounding: the longest wave on a map of 10^5 texels has 6e-5.
const UNSEEN: f64 = 1e-10;

impl<T: Real + FftNum> Operator<T> {
    /// The heights whose slopes are nearest to these in least squares, on a map that wraps both ways.
    pub fn integrate(&self, ds: &[T], dt: &[T]) -> Result<Integral<T>, BakeError> {
        let [width, height] = self.size();
        let need = width * height;
        if let Some(len) = [ds.len(), dt.len()].into_iter().find(|len| *len != need) {
            return Err(BakeError::Length { len, need });
        }
        if self.border() != [Border::Wrap; 2] {
            return Err(BakeError::NotWrapped);
        }
        let mut planner = FftPlanner::new();
        let forward = [width, height].map(|n| planner.plan_fft_forward(n));
        let back = [width, height].map(|n| planner.plan_fft_inverse(n));
        // Both are real: one transform does for the two.
        let mut waves: Vec<_> = ds.iter().zip(dt).map(|(s, t)| Complex::new(*s, *t)).collect();
        transform(&mut waves, [width, height], &forward);
        let mut lost = 0;
        let real = <T as Real>::from_f64;
        let half = real(0.5);
        let mut sum = vec![Complex::new(T::zero(), T::zero()); need];
        for y in 0..height {
            for x in 0..width {
                let wave = waves[y * width + x];
                let mirror = waves[(height - y) % height * width + (width - x) % width].conj();
                let s = (wave + mirror) * half;
                let t = (wave - mirror) * Complex::new(T::zero(), -half);
                // Rows run down and t runs up.
                let k = [TAU * x as f64 / width as f64, -TAU * y as f64 / height as f64];
                let [a, b] = [Axis::S, Axis::T].map(|axis| self.symbol(axis, k));
                let square = a.norm_sqr() + b.norm_sqr();
                if (x, y) == (0, 0) {
                } else if square < UNSEEN * UNSEEN {
                    lost += 1;
                } else {
                    let [a, b] = [a, b].map(|a| a.conj() / square);
                    let [a, b] = [a, b].map(|a| Complex::new(real(a.re), real(a.im)));
                    sum[y * width + x] = a * s + b * t;
                }
            }
        }
        transform(&mut sum, [width, height], &back);
        let scale = real(1.0 / need as f64);
        Ok(Integral { heights: sum.iter().map(|h| h.re * scale).collect(), lost })
    }
}

/// Along the rows, then along the columns, in place.
fn transform<T: FftNum>(grid: &mut [Complex<T>], [width, height]: [usize; 2], ffts: &[Arc<dyn Fft<T>>; 2]) {
    ffts[0].process(grid);
    let mut turned: Vec<_> =
        (0..width).flat_map(|x| (0..height).map(move |y| y * width + x)).map(|i| grid[i]).collect();
    ffts[1].process(&mut turned);
    for (x, column) in turned.chunks(height).enumerate() {
        for (y, value) in column.iter().enumerate() {
            grid[y * width + x] = *value;
        }
    }
}

impl Bake<'_> {
    /// The heights, of mean 0, that this bakes into these slopes, in the units of [`Bake::slopes`]: heights of
    /// 1 are one height scale. On a map that wraps both ways.
    pub fn heights_of_slopes(
        &self,
        slopes: impl ExactSizeIterator<Item = [f64; 2]>,
        size: [usize; 2],
    ) -> Result<Integral<f64>, BakeError> {
        let scale = self.scale()?;
        if scale[0].hi() == 0.0 {
            return Err(BakeError::HeightScale(0.0));
        }
        let operator = Operator::<f64>::scaled(self.stencil, size, self.border, [1.0.into(); 2])?;
        let [s, t] = scale.map(|scale| scale.hi());
        let (ds, dt): (Vec<_>, Vec<_>) = slopes.map(|[x, y]| (x / s, y / t)).unzip();
        operator.integrate(&ds, &dt)
    }

    /// The same from a normal map. A normal of no height counts as one of a slope of 10^4.
    pub fn heights_of_normals<N: Normal>(
        &self,
        normals: &[N],
        size: [usize; 2],
    ) -> Result<Integral<f64>, BakeError> {
        let [s, t] = self.tilt();
        let slopes = normals.iter().map(|normal| {
            let [x, y, z] = normal.unpack().map(f64::from);
            let z = z.max(1e-4);
            [s * x / z, t * y / z]
        });
        self.heights_of_slopes(slopes, size)
    }
}
