//! Random fields of limited band.

use super::surface::{Field, SIDE};
use num_complex::Complex;
use std::f64::consts::PI;

/// Steele, Lea, Flood 2014, OOPSLA, 453: splitmix64.
pub(super) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// From 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A complex number with normally distributed parts (Box, Muller 1958).
    fn normal(&mut self) -> Complex<f64> {
        Complex::from_polar((-2.0 * (1.0 - self.uniform()).ln()).sqrt(), 2.0 * PI * self.uniform())
    }
}

/// Sums the waves exp(i (p x + q y) 2 pi / SIDE), first over p for each q, then over q: the height and both
/// slopes are real and imaginary parts of the same sums.
pub(super) fn field(shortest: f64) -> Field {
    let most = (SIDE as f64 / shortest) as i64;
    let unit = 2.0 * PI / SIDE as f64;
    let roots: Vec<_> = (0..SIDE).map(|i| Complex::cis(unit * i as f64)).collect();
    let root = |p: i64, x: usize| roots[(p * x as i64).rem_euclid(SIDE as i64) as usize];
    let mut random = Random::new(1);
    // Half of the waves: the real part of their sum has the other half.
    let mut rows: Vec<(i64, Vec<[Complex<f64>; 2]>)> = Vec::new();
    for q in 0..=most {
        let mut row = vec![[Complex::ZERO; 2]; SIDE];
        for p in -most..=most {
            let square = (p * p + q * q) as f64;
            if square > (most * most) as f64 || (q == 0 && p <= 0) {
                continue;
            }
            let wave = random.normal() * square.powf(-0.75);
            for (x, sums) in row.iter_mut().enumerate() {
                let wave = wave * root(p, x);
                sums[0] += wave;
                sums[1] += wave * (p as f64 * unit);
            }
        }
        rows.push((q, row));
    }
    let (mut heights, mut slopes) = (vec![0.0; SIDE * SIDE], vec![[0.0; 2]; SIDE * SIDE]);
    for (q, row) in &rows {
        for y in 0..SIDE {
            let up = root(*q, SIDE - 1 - y);
            for (x, [sum, along]) in row.iter().enumerate() {
                let wave = sum * up;
                heights[y * SIDE + x] += wave.re;
                slopes[y * SIDE + x][0] -= (along * up).im;
                slopes[y * SIDE + x][1] -= wave.im * *q as f64 * unit;
            }
        }
    }
    let square: f64 = slopes.iter().flatten().map(|x| x * x).sum();
    let scale = 0.5 / (square / slopes.len() as f64).sqrt();
    Field {
        size: [SIDE, SIDE],
        heights: heights.iter().map(|h| h * scale).collect(),
        slopes: slopes.iter().map(|slopes| Some(slopes.map(|x| x * scale))).collect(),
    }
}
