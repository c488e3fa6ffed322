//! What rounded heights do, and what is advised.

use crate::stencils as of;
use kutta::normals::{Bake, Border, Heights, Stencil};

const SIZE: usize = 420;

/// A half ball of radius 200 and height 200, and its slopes where they are below 72 degrees.
fn ball() -> (Vec<f64>, Vec<Option<[f64; 2]>>) {
    let place = |i: usize| ((i % SIZE) as f64 - 209.3, 209.6 - (i / SIZE) as f64);
    let z = |(x, y): (f64, f64)| (40000.0 - x * x - y * y).max(0.0).sqrt();
    let heights = (0..SIZE * SIZE).map(|i| z(place(i)) / 200.0).collect();
    let slopes = (0..SIZE * SIZE).map(place).map(|(x, y)| {
        let z = z((x, y));
        (z > 200.0 * 72f64.to_radians().cos()).then(|| [-x / z, -y / z])
    });
    (heights, slopes.collect())
}

/// RMS angle in degrees against the ball's normals.
fn error(stencil: &Stencil, heights: &Heights<u8>, slopes: &[Option<[f64; 2]>]) -> f64 {
    let bake = Bake::new(stencil).height_scale(200.0).border([Border::Clamp; 2]);
    let (mut sum, mut count) = (0.0, 0.0);
    for ([a, b], exact) in bake.slopes(heights).unwrap().into_iter().zip(slopes) {
        if let Some([c, d]) = exact {
            let (a, b) = (f64::from(a), f64::from(b));
            let cross = (b - d).hypot(c - a).hypot(a * d - b * c);
            sum += cross.atan2(a * c + b * d + 1.0).to_degrees().powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(sum / count)
}

#[test]
fn the_noise_of_rounded_heights_is_gain_times_quantum() {
    let central2 = Bake::new(&of::CENTRAL2).height_scale(200.0);
    // .7071 x 200/255/sqrt(12) = .160 radians.
    let noise = central2.noise::<u8>().unwrap();
    assert!((noise - 0.5f64.sqrt() * 200.0 / 255.0 / 12f64.sqrt()).abs() < 1e-12);
    assert!((noise.to_degrees() - 9.2).abs() < 0.05);
    assert_eq!(central2.noise::<f32>().unwrap(), 0.0);
    // Gains of the literature: sqrt(130)/12, sqrt(3/16).
    let gain = |stencil| Bake::new(stencil).noise::<u8>().unwrap() * 255.0 * 12f64.sqrt();
    assert!((gain(&of::CENTRAL4) - 130f64.sqrt() / 12.0).abs() < 1e-12);
    assert!((gain(&of::SOBEL3) - 3f64.sqrt() / 4.0).abs() < 1e-12);
    // And measured: 9.1 degrees on a half ball of that height.
    let (b, slopes) = ball();
    let b8: Vec<u8> = b.iter().map(|b| (b * 255.0).round() as u8).collect();
    let measured = error(&of::CENTRAL2, &Heights::new(&b8, SIZE, SIZE).unwrap(), &slopes);
    assert!((measured - 9.1).abs() < 0.5, "{measured}");
}

#[test]
fn advice_is_what_the_truth_would_say() {
    // A sine of 24 texels and an amplitude of 4: steep enough for the stencils to differ.
    let n = 192;
    let k = std::f64::consts::TAU / 24.0;
    let wave = |i: usize| (k * ((i % n) + 2 * (i / n)) as f64).sin() / 2.0 + 0.5;
    let others = [
        ("central2", &of::CENTRAL2),
        ("central4", &of::CENTRAL4),
        ("central8", &of::CENTRAL8),
        ("scharr3", &of::SCHARR3),
    ];
    let b32: Vec<f32> = (0..n * n).map(|i| wave(i) as f32).collect();
    let b8: Vec<u8> = (0..n * n).map(|i| (wave(i) * 255.0).round() as u8).collect();
    let bake = |stencil| Bake::new(stencil).height_scale(8.0);
    let fine = bake(&of::CENTRAL2).advice(&Heights::new(&b32, n, n).unwrap(), &others).unwrap();
    assert!(!fine.higher_order_is_pointless());
    assert_eq!(fine.best.name, "central8");
    // The truncation of central2 along s is 4 (k - sin k) cos, along t 4 (2k - sin 2k) cos.
    let rms = 4.0 * ((k - k.sin()).powi(2) / 4.0 + (2.0 * k - (2.0 * k).sin()).powi(2) / 4.0).sqrt();
    assert!((fine.own.truncation / rms - 1.0).abs() < 1e-2, "{} for {rms}", fine.own.truncation);

    let map8 = Heights::new(&b8, n, n).unwrap();
    let coarse = bake(&of::CENTRAL8).advice(&map8, &others).unwrap();
    assert!(coarse.higher_order_is_pointless());
    assert!(coarse.best.total() < coarse.own.total());
    // The truncation of central2 is still seen through the rounding.
    let coarse2 = bake(&of::CENTRAL2).advice(&map8, &others).unwrap();
    assert!((coarse2.own.truncation / rms - 1.0).abs() < 0.15, "{} for {rms}", coarse2.own.truncation);
    let line = coarse.to_string();
    assert!(line.contains("a higher order is pointless") && !line.contains('\n'), "{line}");
    // On what is smooth and steep in few levels, the stencil that smooths most: a dome without a rim.
    let side = |x: usize| (x as f64 - 209.4) / 210.0;
    let dome = |i: usize| 1.0 - (side(i % SIZE).powi(2) + side(i / SIZE).powi(2)) / 2.0;
    let b8: Vec<u8> = (0..SIZE * SIZE).map(|i| (dome(i) * 255.0).round() as u8).collect();
    let map = Heights::new(&b8, SIZE, SIZE).unwrap();
    let bake = Bake::new(&of::CENTRAL4).height_scale(200.0).border([Border::OneSided; 2]);
    let others = [("central2", &of::CENTRAL2), ("central4", &of::CENTRAL4), ("farid5", &of::FARID5)];
    let advice = bake.advice(&map, &others).unwrap();
    assert!(advice.higher_order_is_pointless() && advice.best.name == "farid5", "{advice}");
}

#[test]
fn the_error_map_is_the_angle_between_two_bakes() {
    // Slopes of a sine along s: A k cos, and A sin k cos by central2.
    let (w, h, k) = (16, 3, std::f64::consts::TAU / 16.0);
    let b: Vec<f32> = (0..w * h).map(|i| 2.0 * (k * (i % w) as f64).sin() as f32).collect();
    let map = Bake::new(&of::CENTRAL8).error_map(&of::CENTRAL2, &Heights::new(&b, w, h).unwrap()).unwrap();
    for (i, angle) in map.into_iter().enumerate() {
        let cos = (k * (i % w) as f64).cos();
        let exact = ((2.0 * k * cos).atan() - (2.0 * k.sin() * cos).atan()).abs().to_degrees();
        // central8's own error at 16 texels is 1e-6 of the slope.
        assert!((f64::from(angle) - exact).abs() < 1e-3, "{angle} {exact}");
    }
}
