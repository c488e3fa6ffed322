//! Packing against its formula, decoding as its inverse, and the angles that are lost.

use crate::noise;
use kutta::normals::{Normal, pack_best_fit};

#[test]
fn packing_inverts_decoding() {
    for q in 0..=255u8 {
        for n in [[q, 255 - q, q / 2], [128, q, 255], [q, q, q]] {
            assert_eq!(<[u8; 3]>::pack(n.decode()), n);
            assert_eq!(<[u8; 2]>::pack([n[0], n[1]].decode()), [n[0], n[1]]);
        }
    }
    for q in 0..=65535u16 {
        let n = [q, 65535 - q, q ^ 0x5555];
        assert_eq!(<[u16; 3]>::pack(n.decode()), n);
        assert_eq!(<[u16; 2]>::pack([n[0], n[1]].decode()), [n[0], n[1]]);
    }
}

#[test]
fn packing_rounds_to_the_nearest_level() {
    // Against the formula in f64. The product is formed in f32, whose numbers near 2^n are 2^(n-23) apart: a
    // level may be off where the formula is that near to a tie.
    for i in 0..=400_000 {
        let x = (i as f32 / 200_000.0 - 1.0).clamp(-1.0, 1.0);
        let near = |q: f64, most: f64| {
            let level = (f64::from(x) + 1.0) / 2.0 * most;
            q == (level + 0.5).floor() || (level - q).abs() < 0.5 + most * 2f64.powi(-23)
        };
        assert!(near(<[u8; 3]>::pack([x, 0.0, 0.0])[0].into(), 255.0));
        assert!(near(<[u16; 3]>::pack([x, 0.0, 0.0])[0].into(), 65535.0));
    }
}

#[test]
fn the_flat_normal() {
    let flat = [0.0, 0.0, 1.0];
    assert_eq!(<[u8; 3]>::pack(flat), [128, 128, 255]);
    assert_eq!(<[u16; 3]>::pack(flat), [32768, 32768, 65535]);
    assert_eq!(<[u8; 2]>::pack(flat), [128, 128]);
    assert_eq!(<[f32; 3]>::pack(flat).unpack(), flat);
    let tilt = |n: [f32; 3]| f64::from(n[0].hypot(n[1])).atan2(f64::from(n[2])).to_degrees();
    // sqrt(2)/255 and sqrt(2)/65535 in degrees.
    assert!((tilt([128u8, 128, 255].unpack()) - 0.3178).abs() < 1e-4);
    assert!((tilt([32768u16, 32768, 65535].unpack()) - 0.001236).abs() < 1e-5);
}

#[test]
fn what_is_no_unit_normal_packs_all_the_same() {
    assert_eq!(<[u8; 3]>::pack([7.0, -7.0, f32::INFINITY]), [255, 0, 255]);
    let _ = <[u8; 3]>::pack([f32::NAN; 3]);
    let _ = pack_best_fit([f32::NAN; 3]);
    assert_eq!([0.0f32; 3].unpack(), [0.0, 0.0, 1.0]);
    // Past the unit circle there is no z.
    assert_eq!([255u8, 255].unpack(), [0.5f32.sqrt(), 0.5f32.sqrt(), 0.0]);
}

/// RMS and greatest angle in degrees between normals and what becomes of them.
fn angles(store: impl Fn([f32; 3]) -> [f32; 3]) -> [f64; 2] {
    let random = noise(200_000);
    let (mut sum, mut most) = (0.0, 0f64);
    for pair in random.chunks(2) {
        // Uniform on the sphere down to 72 degrees from its top.
        let z = 1.0 - pair[0] * (1.0 - 72f64.to_radians().cos());
        let (angle, turn) = (z.acos(), pair[1] * std::f64::consts::TAU);
        let n = [angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos()];
        let m = store(n.map(|x| x as f32)).map(f64::from);
        let cross = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| n[i] * m[j] - n[j] * m[i]);
        let sine = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        let dot: f64 = (0..3).map(|i| n[i] * m[i]).sum();
        let error = sine.atan2(dot).to_degrees();
        sum += error * error;
        most = most.max(error);
    }
    [(sum / (random.len() / 2) as f64).sqrt(), most]
}

#[test]
fn the_angle_that_each_packing_loses() {
    let near = |[rms, most]: [f64; 2], [to, at_most]: [f64; 2]| {
        // Other slopes than those the figures were taken on, of the same range.
        assert!((rms / to - 1.0).abs() < 0.1, "RMS {rms} for {to}");
        assert!(most <= at_most * 1.1 && most > at_most * 0.5, "at most {most} for {at_most}");
    };
    near(angles(|n| <[u8; 3]>::pack(n).unpack()), [0.184, 0.384]);
    // All lengths tried: at most the .049 of a coarser search. Nothing is nearer to the flat normal than
    // (1, 1, 255), sqrt(2)/255 away.
    let [rms, most] = angles(|n| pack_best_fit(n).unpack());
    assert!(rms < 0.049 && rms > 0.02 && most < 0.3179, "{rms} {most}");
    near(angles(|n| <[u8; 2]>::pack(n).unpack()), [0.270, 1.05]);
    near(angles(|n| <[u16; 3]>::pack(n).unpack()), [0.0007, 0.0015]);
    near(angles(|n| <[u16; 2]>::pack(n).unpack()), [0.0011, 0.0039]);
}
