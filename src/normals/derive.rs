//! What follows from the numbers of a stencil, computed and never typed.

use super::moments::{MOMENTS, Moments};
use super::stencil::{Stencil, Taps};
use crate::tableau::tolerance;
use num_complex::Complex;
use std::f64::consts::PI;

/// What is derived of a stencil. The slope is judged where the stencil says that it lives; to judge it at the
/// texel, change `at`.
///
/// ```
/// use kutta::normals::{Stencil, stencils::FORWARD2};
/// use kutta::tableau::DoubleDouble;
///
/// assert_eq!(FORWARD2.properties().order, 2);
/// assert_eq!(Stencil { at: DoubleDouble::ZERO, ..FORWARD2 }.properties().order, 1);
/// ```
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct Properties {
    /// Taps of the two-dimensional stencil.
    pub taps: usize,
    /// Whether the slopes of a row follow from solving a tridiagonal system.
    pub compact: bool,
    /// The largest p such that polynomials of degree p have their exact slope.
    pub order: usize,
    /// Coefficient of h^2 f_xxx in the error of f_x.
    pub e_xx: f64,
    /// Coefficient of h^2 f_xyy in the error of f_x.
    pub e_yy: f64,
    /// The leading error: h^order times the sum of these derivatives of f.
    pub leading: Vec<Term>,
    /// The power of h up to which the error has no preferred direction.
    pub isotropic: usize,
    /// Standard deviation of the slope over that of independent noise in the heights: the root of the sum of
    /// the squared weights.
    pub noise_gain: f64,
    /// Taps that lie symmetrically have opposite weights: waves are not shifted.
    pub symmetric: bool,
}

/// `coefficient` times the derivative of f, `derivative[0]` times along the axis and `derivative[1]` across.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Term {
    pub coefficient: f64,
    pub derivative: [usize; 2],
}

impl Stencil<'_> {
    pub fn properties(&self) -> Properties {
        let moments = Moments::of(self, self.at, MOMENTS - 1);
        let tolerance = tolerance(self.digits);
        let along = |p: usize| moments.along[p].hi().abs() > tolerance * moments.scale_along[p];
        let across = |q: usize| moments.across[q].hi().abs() > tolerance * moments.scale_across[q];
        let holds = |p: &usize| !along(*p) && !across(p - 1);
        let order = (2..MOMENTS - 1).take_while(holds).last().unwrap_or(1);
        let isotropic = |n: &usize| {
            (0..=*n).all(|q| {
                let (off, scale) = moments.anisotropy(n + 1 - q, q);
                off.hi().abs() <= tolerance * scale
            })
        };
        let term = |p: usize, q: usize| {
            let moment = (moments.along[p] * moments.across[q]).hi();
            // What rounding leaves of nothing is nothing.
            let coefficient = if along(p) && across(q) { moment / factorial(p) / factorial(q) } else { 0.0 };
            Term { coefficient, derivative: [p, q] }
        };
        let leading = (0..=order).filter(|q| along(order + 1 - q) && across(*q));
        let (right, left, smooth) = (&self.along, &self.left, &self.across);
        let mirrored = right.iter().all(|(j, weight)| {
            let mirror = 2.0 * self.at.hi() - j as f64;
            let other = right.iter().find(|&(k, _)| k as f64 == mirror);
            other.is_some_and(|(_, other)| (weight + other).hi().abs() <= tolerance)
        });
        Properties {
            taps: count(right) * count(smooth),
            compact: left.len > 1,
            order,
            e_xx: term(3, 0).coefficient,
            e_yy: term(1, 2).coefficient,
            leading: leading.map(|q| term(order + 1 - q, q)).collect(),
            isotropic: (1..MOMENTS - 1).take_while(isotropic).last().unwrap_or(0),
            noise_gain: self.noise_gain(),
            symmetric: mirrored && left.iter().all(|(j, w)| left.iter().any(|(k, v)| k == -j && v == w)),
        }
    }

    /// The modified wavenumber k' of the wave f = exp(i (k_0 x + k_1 y)), x along the axis and y across, in
    /// radians per texel: the stencil takes i k' f for its slope, which is i k_0 f. Its imaginary part changes
    /// the amplitude; it is 0 where the stencil is symmetric.
    pub fn modified_wavenumber(&self, k: [f64; 2]) -> Complex<f64> {
        let phase = Complex::cis(-k[0] * self.at.hi());
        let slope = phase * symbol(&self.along, k[0]) / symbol(&self.left, k[0]) * symbol(&self.across, k[1]);
        slope / Complex::I
    }

    /// The shortest wave in texels from which on all waves along the axis have |k'/k - 1| of at most `share`.
    pub fn shortest_wave(&self, share: f64) -> f64 {
        let off = |k: f64| (self.modified_wavenumber([k, 0.0]) / k - 1.0).norm();
        const STEPS: usize = 1 << 14;
        let k = |step: usize| PI * step as f64 / STEPS as f64;
        let Some(first) = (1..=STEPS).find(|&step| off(k(step)) > share) else { return 2.0 };
        let (mut good, mut bad) = (k(first - 1), k(first));
        for _ in 0..60 {
            let middle = (good + bad) / 2.0;
            *(if off(middle) > share { &mut bad } else { &mut good }) = middle;
        }
        2.0 * PI / bad
    }

    /// The largest angle in degrees between the gradient of a wave and what the stencil finds on both axes, over
    /// all directions of a wave of this many texels. Shifts of the phase do not count.
    pub fn direction_error(&self, wavelength: f64) -> f64 {
        let k = 2.0 * PI / wavelength;
        let error = |step: usize| {
            let angle = PI * step as f64 / 7200.0;
            let (s, c) = angle.sin_cos();
            let x = self.modified_wavenumber([k * c, k * s]).re;
            let y = self.modified_wavenumber([k * s, k * c]).re;
            (y.atan2(x) - angle).abs().to_degrees()
        };
        (0..=1800).map(error).fold(0.0, f64::max)
    }

    /// The integral of the squared symbol over all waves; for periodic functions the sum over equal steps is
    /// exact to rounding.
    fn noise_gain(&self) -> f64 {
        const STEPS: usize = 1024;
        let along = |step: usize| {
            let k = 2.0 * PI * step as f64 / STEPS as f64;
            (symbol(&self.along, k) / symbol(&self.left, k)).norm_sqr()
        };
        let along = (0..STEPS).map(along).sum::<f64>() / STEPS as f64;
        (along * self.across.iter().map(|(_, w)| w.hi() * w.hi()).sum::<f64>()).sqrt()
    }
}

/// sum w_j exp(i k j)
fn symbol(taps: &Taps, k: f64) -> Complex<f64> {
    taps.iter().map(|(j, weight)| Complex::cis(k * j as f64) * weight.hi()).sum()
}

fn count(taps: &Taps) -> usize {
    taps.iter().filter(|(_, weight)| weight.hi() != 0.0).count()
}

fn factorial(n: usize) -> f64 {
    (1..=n).map(|i| i as f64).product()
}
