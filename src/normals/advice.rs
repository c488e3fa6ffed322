//! Two stencils on one map: where they differ, and which of several would serve.

use super::bake::Bake;
use super::error::BakeError;
use super::heights::{Height, Heights};
use super::operator::{self, Axis};
use super::stencil::Stencil;
use num_complex::Complex;
use std::f64::consts::{SQRT_2, TAU};
use std::fmt;

/// Waves along each axis that a mean over all is taken of: exact for fewer taps than that.
const WAVES: usize = 64;

/// What a stencil makes of a map, in radians of slope, root mean square of both axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget<'n> {
    pub name: &'n str,
    pub order: usize,
    /// From heights that are rounded to the levels of their type: gain x height x quantum / sqrt(12).
    pub noise: f64,
    /// From the stencil, as the difference from the one of highest order shows it; 0 for that one.
    pub truncation: f64,
}

impl Budget<'_> {
    pub fn total(&self) -> f64 {
        self.noise.hypot(self.truncation)
    }
}

/// Which stencil serves a map; shown, a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice<'n> {
    /// The stencil asked about.
    pub own: Budget<'n>,
    /// The one with the least total, which may be the same.
    pub best: Budget<'n>,
}

impl Advice<'_> {
    /// The heights are rounded more coarsely than the stencil errs.
    pub fn higher_order_is_pointless(&self) -> bool {
        self.own.noise > self.own.truncation
    }
}

impl fmt::Display for Advice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Budget { name, noise, truncation, .. } = self.own;
        let (noise, truncation) = (noise.to_degrees(), truncation.to_degrees());
        write!(f, "{name}: {noise:.2} degrees from rounded heights, {truncation:.2} from the stencil")?;
        if self.higher_order_is_pointless() {
            write!(f, ": a higher order is pointless")?;
        }
        match self.best.name == name {
            true => write!(f, "; none of the others serves better"),
            false => {
                let total = self.best.total().to_degrees();
                write!(f, "; {} would serve better: {total:.2} in all", self.best.name)
            }
        }
    }
}

/// The root mean square that a stencil, or the difference of two, makes of noise of size 1 in the heights.
fn gain(stencil: &Stencil, minus: Option<&Stencil>) -> f64 {
    let wave = |i: usize| TAU * i as f64 / WAVES as f64;
    let symbol = |stencil: &Stencil, k| operator::symbol(stencil, Axis::S, k);
    let square = |(i, j)| {
        let k = [wave(i), wave(j)];
        let other = minus.map_or(Complex::ZERO, |stencil| symbol(stencil, k));
        (symbol(stencil, k) - other).norm_sqr()
    };
    let all = (0..WAVES).flat_map(|i| (0..WAVES).map(move |j| (i, j)));
    (all.map(square).sum::<f64>() / (WAVES * WAVES) as f64).sqrt()
}

impl<'s> Bake<'s> {
    /// The angle between the normals of this stencil and of another, in degrees: where the other's order is
    /// lower, a local estimate of its error, as embedded pairs give one of a step.
    pub fn error_map(&self, other: &Stencil, heights: &Heights<impl Height>) -> Result<Vec<f32>, BakeError> {
        let (a, b) = (self.slopes(heights)?, self.with(other).slopes(heights)?);
        Ok(a.iter().zip(&b).map(|(a, b)| angle(*a, *b)).collect())
    }

    /// What rounded heights cause, in radians of slope, root mean square of both axes.
    pub fn noise<H: Height>(&self) -> Result<f64, BakeError> {
        self.noise_of::<H>(gain(self.stencil, None))
    }

    fn noise_of<H: Height>(&self, gain: f64) -> Result<f64, BakeError> {
        let [s, t] = self.scale()?.map(|scale| scale.hi());
        Ok(gain * s.hypot(t) / SQRT_2 * H::QUANTUM / 12f64.sqrt())
    }

    /// Weighs, for this stencil and for each of `others`, what rounded heights cause against what the stencil
    /// itself does.
    ///
    /// The stencil of highest order stands for the truth. Its difference from another one is that one's
    /// truncation and the rounding of the heights, whose part in it is known and taken off.
    pub fn advice<'n, H: Height>(
        &self,
        heights: &Heights<H>,
        others: &[(&'n str, &Stencil)],
    ) -> Result<Advice<'n>, BakeError>
    where
        's: 'n,
    {
        let highest = others.iter().map(|other| other.1).max_by_key(|stencil| stencil.order);
        let truth = highest.filter(|stencil| stencil.order > self.stencil.order).unwrap_or(self.stencil);
        let exact = self.with(truth).slopes(heights)?;
        let budget = |name: &'n str, stencil: &Stencil| {
            let slopes = self.with(stencil).slopes(heights)?;
            let difference =
                |(a, b): (&[f32; 2], &[f32; 2])| (0..2).map(|i| f64::from(a[i] - b[i]).powi(2)).sum::<f64>();
            let square = slopes.iter().zip(&exact).map(difference).sum::<f64>() / (2 * slopes.len()) as f64;
            let rounding = self.noise_of::<H>(gain(stencil, Some(truth)))?;
            Ok(Budget {
                name,
                order: stencil.order,
                noise: self.noise_of::<H>(gain(stencil, None))?,
                truncation: (square - rounding * rounding).max(0.0).sqrt(),
            })
        };
        let own = budget(self.stencil.title, self.stencil)?;
        let mut best = own;
        for (name, stencil) in others {
            let other = budget(name, stencil)?;
            if other.total() < best.total() {
                best = other;
            }
        }
        Ok(Advice { own, best })
    }
}

/// Between the normals of two slopes, in degrees.
fn angle(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [[a, b], [c, d]] = [a, b].map(|slope| slope.map(f64::from));
    // The sine from the cross product: a cosine near 1 has lost the angle.
    let cross = (b - d).hypot(c - a).hypot(a * d - b * c);
    cross.atan2(a * c + b * d + 1.0).to_degrees() as f32
}
