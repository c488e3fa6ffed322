//! Mip levels.

use crate::noise;
use kutta::normals::{BakeError, mips};

#[test]
fn a_level_is_the_mean_of_what_it_covers() {
    for (w, h) in [(1, 1), (2, 2), (8, 4), (3, 3), (5, 7), (12, 10), (1, 9), (6, 1), (13, 16)] {
        let random = noise(2 * w * h);
        let slopes: Vec<[f32; 2]> = random.chunks(2).map(|c| [c[0] as f32, c[1] as f32 - 3.0]).collect();
        let levels = mips(slopes.clone(), w, h).unwrap();
        assert_eq!(levels[0].slopes, slopes);
        for (k, level) in levels.iter().enumerate() {
            assert_eq!((level.width, level.height), ((w >> k).max(1), (h >> k).max(1)));
            // The map as a function that is constant on texels, its mean over a rectangle by overlaps.
            for (i, slope) in level.slopes.iter().enumerate() {
                let side = |i: usize, n: usize, size: usize| {
                    let f = size as f64 / n as f64;
                    (i as f64 * f, (i + 1) as f64 * f)
                };
                let (left, right) = side(i % level.width, level.width, w);
                let (top, bottom) = side(i / level.width, level.height, h);
                let over = |x: usize, from: f64, to: f64| ((x + 1) as f64).min(to) - (x as f64).max(from);
                let mut mean = [0.0; 2];
                for (j, slope) in slopes.iter().enumerate() {
                    let part = over(j % w, left, right).max(0.0) * over(j / w, top, bottom).max(0.0);
                    for (mean, slope) in mean.iter_mut().zip(slope) {
                        *mean += part * f64::from(*slope) / ((right - left) * (bottom - top));
                    }
                }
                // Rounded once a level, numbers below 4.
                let near = |a: f32, b: f64| (f64::from(a) - b).abs() < 1e-6;
                assert!(near(slope[0], mean[0]) && near(slope[1], mean[1]), "{w} x {h}, level {k}");
            }
        }
        assert_eq!(levels.last().map(|level| level.slopes.len()), Some(1));
    }
    assert_eq!(mips(vec![[0.0; 2]; 5], 2, 3), Err(BakeError::Length { len: 5, need: 6 }));
    assert_eq!(mips(vec![], 0, 3), Err(BakeError::Size { width: 0, height: 3 }));
}
