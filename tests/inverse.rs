//! Heights had back from what was baked of them.

#[path = "bake/stencils.rs"]
mod stencils;

use kutta::normals::{Axis, Bake, BakeError, Border, Green, Heights, Operator, Stencil};
use stencils as of;

/// Waves that no stencil here is blind to, of mean 0, on a torus.
fn waves(w: usize, h: usize) -> Vec<f64> {
    let tau = std::f64::consts::TAU;
    (0..w * h)
        .map(|i| {
            let (x, y) = ((i % w) as f64 / w as f64, (i / w) as f64 / h as f64);
            // On a line of one texel the waves along it are constant.
            let s = if w > 2 { (tau * x + 0.3).sin() } else { 0.0 };
            let t = if h > 2 { (tau * y).cos() } else { 0.0 };
            let both = if w > 4 && h > 4 { 0.5 * (tau * (2.0 * x - y) + 1.0).sin() } else { 0.0 };
            s + t + both
        })
        .collect()
}

fn back(stencil: &Stencil, [w, h]: [usize; 2], b: &[f64]) -> (f64, usize) {
    let operator = Operator::<f64>::new(stencil, [w, h], [Border::Wrap; 2]).unwrap();
    let slopes = [Axis::S, Axis::T].map(|axis| {
        let mut slopes = vec![0.0; b.len()];
        operator.apply(axis, b, &mut slopes).unwrap();
        slopes
    });
    let integral = operator.integrate(&slopes[0], &slopes[1]).unwrap();
    let worst = integral.heights.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (worst, integral.lost)
}

/// The least symbol of the waves that the stencil sees; 1 where there are none.
fn least(stencil: &Stencil, [w, h]: [usize; 2]) -> f64 {
    let operator = Operator::<f64>::new(stencil, [w, h], [Border::Wrap; 2]).unwrap();
    let symbol = |i: usize| {
        let k = [(i % w) as f64 / w as f64, (i / w) as f64 / h as f64].map(|k| k * std::f64::consts::TAU);
        [Axis::S, Axis::T].map(|axis| operator.symbol(axis, k).norm_sqr()).iter().sum::<f64>().sqrt()
    };
    (1..w * h).map(symbol).filter(|size| *size > 1e-10).fold(1.0, f64::min)
}

#[test]
fn waves_come_back_to_rounding() {
    for stencil in &of::ALL {
        for [w, h] in [[16, 16], [31, 8], [9, 15], [1, 12], [20, 1], [1, 1], [100, 63]] {
            let (worst, _) = back(stencil, [w, h], &waves(w, h));
            // Slopes are rounded at some epsilons of the weights times heights of 2.5, and the least symbol divides.
            let weights: f64 = (0..stencil.along.len).map(|j| stencil.along.weight[j].hi().abs()).sum();
            let allowed = 16.0 * f64::EPSILON * (1.0 + weights / least(stencil, [w, h]));
            assert!(worst < allowed, "{} {w} x {h}: {worst:e}, {allowed:e}", stencil.title);
        }
    }
}

#[test]
fn any_map_of_odd_size_comes_back_from_central_stencils() {
    // Random texels: on odd sizes no wave alternates, so the symbol vanishes for the mean alone.
    let (w, h) = (33, 21);
    let mut b: Vec<f64> = (0..w * h).map(|i| ((i * i * 7919 + 31 * i) % 1009) as f64 / 1009.0).collect();
    let mean = b.iter().sum::<f64>() / b.len() as f64;
    b.iter_mut().for_each(|b| *b -= mean);
    for stencil in [&of::CENTRAL2, &of::CENTRAL4, &of::CENTRAL6, &of::CENTRAL8, &of::FORWARD2, &of::COMPACT6]
    {
        let (worst, lost) = back(stencil, [w, h], &b);
        assert!(worst < 1e-12 && lost == 0, "{}: {worst}, {lost}", stencil.title);
    }
}

#[test]
fn what_a_stencil_does_not_see_is_counted() {
    let lost = |stencil: &Stencil, size: [usize; 2]| back(stencil, size, &vec![0.0; size[0] * size[1]]).1;
    // sin k vanishes at k = pi: three corners of the torus of waves besides the mean.
    assert_eq!(lost(&of::CENTRAL2, [12, 8]), 3);
    assert_eq!(lost(&of::CENTRAL8, [12, 8]), 3);
    assert_eq!(lost(&of::COMPACT6, [12, 8]), 3);
    assert_eq!(lost(&of::CENTRAL2, [12, 9]), 1);
    // exp(i k) - 1 vanishes at 0 alone.
    assert_eq!(lost(&of::FORWARD2, [12, 8]), 0);
    // (1 + cos k)/2 as well: both lines of Nyquist, 12 + 8 - 1 waves.
    assert_eq!(lost(&of::SOBEL3, [12, 8]), 19);
    // 5/8 + 3/8 cos k does not vanish: the corners again.
    assert_eq!(lost(&of::SCHARR3, [12, 8]), 3);
}

#[test]
fn normals_give_heights_back() {
    let (w, h) = (24, 18);
    let b: Vec<f32> = waves(w, h).iter().map(|b| *b as f32 / 4.0).collect();
    let heights = Heights::new(&b, w, h).unwrap();
    for green in [Green::Up, Green::Down] {
        let bake = Bake::new(&of::CENTRAL4).height_scale(3.0).texel_size([0.5, 2.0]).green(green);
        let worst = |found: Vec<f64>| {
            found.iter().zip(&b).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max)
        };
        let normals: Vec<[f32; 3]> = bake.normals(&heights).unwrap();
        // Slopes to 2, normals to 6e-8.
        assert!(worst(bake.heights_of_normals(&normals, [w, h]).unwrap().heights) < 2e-6);
        let rough: Vec<[u16; 3]> = bake.normals(&heights).unwrap();
        // A quantum of 3e-5 in the normal.
        assert!(worst(bake.heights_of_normals(&rough, [w, h]).unwrap().heights) < 2e-4);
        let slopes = bake.slopes(&heights).unwrap();
        let slopes = slopes.iter().map(|slope| slope.map(f64::from));
        assert!(worst(bake.heights_of_slopes(slopes, [w, h]).unwrap().heights) < 2e-6);
    }
    let bake = Bake::new(&of::CENTRAL4);
    let flat = [[0f32, 0.0, 1.0]; 4];
    assert_eq!(bake.heights_of_normals(&flat, [3, 2]).err(), Some(BakeError::Length { len: 4, need: 6 }));
    assert_eq!(
        bake.border([Border::Clamp; 2]).heights_of_normals(&flat, [2, 2]).err(),
        Some(BakeError::NotWrapped)
    );
    assert_eq!(
        bake.height_scale(0.0).heights_of_normals(&flat, [2, 2]).err(),
        Some(BakeError::HeightScale(0.0))
    );
}
