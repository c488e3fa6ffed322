//! Heights to normals: signs, units, borders, holes, and the fast path against the operator in f64.

use crate::stencils::{self as of, ALL};
use crate::{BORDERS, noise};
use kutta::normals::{Axis, Bake, BakeError, Border, Green, Height, Heights, Normal, Operator, Stencil};

/// Normals by the operator, in f64.
fn exact(
    stencil: &Stencil,
    b: &[f64],
    size: [usize; 2],
    border: [Border; 2],
    scale: [f64; 2],
    up: f64,
) -> Vec<[f64; 3]> {
    let operator = Operator::<f64>::new(stencil, size, border).unwrap();
    let slopes = [Axis::S, Axis::T].map(|axis| {
        let mut slopes = vec![0.0; b.len()];
        operator.apply(axis, b, &mut slopes).unwrap();
        slopes
    });
    (0..b.len())
        .map(|i| {
            let (s, t) = (slopes[0][i] * scale[0], slopes[1][i] * scale[1]);
            let length = (s * s + t * t + 1.0).sqrt();
            [-s / length, -up * t / length, 1.0 / length]
        })
        .collect()
}

/// Quanta of a packing that are off, less what rounding at a tie may be.
fn channels_agree<N: Normal, H: Height>(
    bake: &Bake,
    heights: &Heights<H>,
    exact: &[[f64; 3]],
    slack: f64,
    split: impl Fn(N) -> Vec<f64>,
    most: f64,
) {
    let normals: Vec<N> = bake.normals(heights).unwrap();
    for (i, (normal, exact)) in normals.iter().zip(exact).enumerate() {
        for (q, x) in split(*normal).into_iter().zip(exact) {
            let ideal = if most == 0.0 { *x } else { (x + 1.0) / 2.0 * most };
            let rounding = if most == 0.0 { 0.0 } else { 0.5 };
            let allowed = rounding + slack * most.max(1.0);
            assert!((q - ideal).abs() <= allowed, "texel {i} of {:?}: {q} for {ideal}", heights.size());
        }
    }
}

fn every_packing<H: Height>(bake: &Bake, heights: &Heights<H>, exact: &[[f64; 3]]) {
    // f32: sums of up to 25 terms, each rounded at 6e-8, weights of one-sided tables up to 60.
    let slack = 2e-5;
    channels_agree::<[f32; 3], H>(bake, heights, exact, slack, |n| n.map(f64::from).to_vec(), 0.0);
    channels_agree::<[u8; 3], H>(bake, heights, exact, slack, |n| n.map(f64::from).to_vec(), 255.0);
    channels_agree::<[u8; 2], H>(bake, heights, exact, slack, |n| n.map(f64::from).to_vec(), 255.0);
    channels_agree::<[u16; 3], H>(bake, heights, exact, slack, |n| n.map(f64::from).to_vec(), 65535.0);
    channels_agree::<[u16; 2], H>(bake, heights, exact, slack, |n| n.map(f64::from).to_vec(), 65535.0);
}

#[test]
fn the_fast_path_is_the_operator() {
    let sizes = [1, 2, 3, 5, 8, 13, 20].into_iter().flat_map(|w| [(w, 1), (1, w), (w, w), (w, 21 - w)]);
    // Wider than a chunk and than a vector, too.
    for (w, h) in sizes.chain([(513, 2), (1040, 1)]) {
        let random = noise(w * h);
        let b8: Vec<u8> = random.iter().map(|b| (b * 256.0) as u8).collect();
        let b16: Vec<u16> = random.iter().map(|b| (b * 65536.0) as u16).collect();
        let b32: Vec<f32> = random.iter().map(|b| *b as f32).collect();
        // What takes long is left to every third stencil.
        for (i, stencil) in ALL.iter().enumerate().step_by(if w > 20 { 3 } else { 1 }) {
            for (j, s) in BORDERS.into_iter().enumerate() {
                let border = [s, BORDERS[(i + j + w) % 4]];
                let green = if (i + j) % 2 == 0 { Green::Up } else { Green::Down };
                let up = if green == Green::Up { 1.0 } else { -1.0 };
                let bake =
                    Bake::new(stencil).height_scale(1.5).texel_size([0.5, 2.0]).border(border).green(green);
                let exact = |b: Vec<f64>| exact(stencil, &b, [w, h], border, [3.0, 0.75], up);
                let from8 = exact(b8.iter().map(|b| f64::from(*b) / 255.0).collect());
                every_packing(&bake, &Heights::new(&b8, w, h).unwrap(), &from8);
                let from16 = exact(b16.iter().map(|b| f64::from(*b) / 65535.0).collect());
                every_packing(&bake, &Heights::new(&b16, w, h).unwrap(), &from16);
                let from32 = exact(b32.iter().map(|b| f64::from(*b)).collect());
                every_packing(&bake, &Heights::new(&b32, w, h).unwrap(), &from32);
            }
        }
    }
}

#[test]
fn a_compact_stencil_may_smooth() {
    // No shipped one does. Sizes beyond what is solved at once, and not a multiple of it.
    let stencil = Stencil { across: of::SCHARR3.across, ..of::COMPACT6 };
    let (w, h) = (37, 21);
    let b: Vec<f32> = noise(w * h).iter().map(|b| *b as f32).collect();
    let b64: Vec<f64> = b.iter().map(|b| f64::from(*b)).collect();
    for (s, t) in BORDERS.into_iter().zip([1, 2, 3, 0].map(|i| BORDERS[i])) {
        let slopes = Bake::new(&stencil).border([s, t]).slopes(&Heights::new(&b, w, h).unwrap()).unwrap();
        let operator = Operator::<f64>::new(&stencil, [w, h], [s, t]).unwrap();
        for (i, axis) in [Axis::S, Axis::T].into_iter().enumerate() {
            let mut exact = vec![0.0; w * h];
            operator.apply(axis, &b64, &mut exact).unwrap();
            // Smoothed heights and slopes are rounded to f32; one-sided rows multiply that by up to 15.
            assert!(slopes.iter().zip(&exact).all(|(a, b)| (f64::from(a[i]) - b).abs() < 2e-6));
        }
    }
}

#[test]
fn large_maps_are_stored_the_same() {
    // Past the cache from 4 MB on, from a pointer that is aligned to no line.
    let (w, h) = (1111, 401);
    let b: Vec<f32> = noise(w * h).iter().map(|b| *b as f32).collect();
    let bake = Bake::new(&of::SCHARR3).border([Border::Mirror, Border::Clamp]);
    let heights = Heights::new(&b, w, h).unwrap();
    let mut room = vec![[0f32; 3]; w * h + 1];
    bake.normals_into(&heights, &mut room[1..]).unwrap();
    let b64: Vec<f64> = b.iter().map(|b| f64::from(*b)).collect();
    let exact = exact(&of::SCHARR3, &b64, [w, h], [Border::Mirror, Border::Clamp], [1.0; 2], 1.0);
    let near = |a: &[f32; 3], b: &[f64; 3]| a.iter().zip(b).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6);
    assert!(room[1..].iter().zip(&exact).all(|(a, b)| near(a, b)));
    assert!(room[1..].iter().all(|n| {
        let length: f64 = n.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
        (length - 1.0).abs() < 2e-7
    }));
    assert_eq!(room[0], [0.0; 3]);
}

#[test]
fn signs() {
    // The top row first: height rises to the right, then toward the top.
    let right: Vec<u8> = (0..25).map(|i| (i % 5 * 20) as u8).collect();
    let up: Vec<u8> = (0..25).map(|i| (80 - i / 5 * 20) as u8).collect();
    for stencil in &ALL {
        let bake = Bake::new(stencil).height_scale(10.0).border([Border::OneSided; 2]);
        let one = |heights: &[u8], bake: Bake| -> [u8; 3] {
            bake.normals(&Heights::new(heights, 5, 5).unwrap()).unwrap()[12]
        };
        let [r, g, _] = one(&right, bake);
        assert!(r < 128 && g == 128, "{}", stencil.title);
        let [r, g, _] = one(&up, bake);
        assert!(r == 128 && g < 128, "{}", stencil.title);
        assert!(one(&up, bake.green(Green::Down))[1] > 128);
        // A depth map is a height map upside down.
        assert!(one(&right, bake.height_scale(-10.0))[0] > 128);
    }
}

#[test]
fn slopes_are_in_world_units() {
    // 3 up for each texel to the right, 2 for each row down; texels of 0.5 by 4 and heights of 7.
    let b: Vec<f32> = (0..48).map(|i| 3.0 * (i % 8) as f32 + 2.0 * (i / 8) as f32).collect();
    for stencil in &ALL {
        let bake = Bake::new(stencil).height_scale(7.0).texel_size([0.5, 4.0]).border([Border::OneSided; 2]);
        for [s, t] in bake.slopes(&Heights::new(&b, 8, 6).unwrap()).unwrap() {
            // Farid's moment is 1 to six digits.
            assert!((s - 42.0).abs() < 1e-3 && (t + 3.5).abs() < 1e-4, "{}: {s} {t}", stencil.title);
        }
    }
}

#[test]
fn steep_slopes_give_unit_normals() {
    for scale in [1e12, 1e19, 1e25, 1e29] {
        let b = [0.0f32, 1.0, 0.0, 2.0, -3.0, 7.0, 1e8, -3e8, 0.5];
        let bake = Bake::new(&of::CENTRAL2).height_scale(scale).border([Border::OneSided; 2]);
        let heights = Heights::new(&b, 3, 3).unwrap();
        let slopes = bake.slopes(&heights).unwrap();
        for (n, [s, t]) in bake.normals::<[f32; 3]>(&heights).unwrap().iter().zip(slopes) {
            assert!(s.is_finite() && t.is_finite());
            let length = n.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            assert!((length - 1.0).abs() < 2e-7, "{n:?}");
            // And the direction is right as far as f32 tells the slopes.
            let (s, t) = (f64::from(s), f64::from(t));
            let exact = [-s, -t].map(|x| x / (s * s + t * t + 1.0).sqrt());
            assert!((f64::from(n[0]) - exact[0]).abs() < 1e-6 && (f64::from(n[1]) - exact[1]).abs() < 1e-6);
        }
    }
    // Heights at the end of f32, whose difference is beyond it.
    let b = [f32::MAX, f32::MIN, f32::MAX, f32::MIN];
    let bake = Bake::new(&of::CENTRAL4).height_scale(2.0).border([Border::OneSided; 2]);
    for n in bake.normals::<[f32; 3]>(&Heights::new(&b, 4, 1).unwrap()).unwrap() {
        assert!((n[0].abs() - 1.0).abs() < 1e-6 && n[1] == 0.0, "{n:?}");
    }
}

#[test]
fn heights_that_are_not_finite_are_refused_with_their_place() {
    let mut b = vec![0.5f32; 12];
    (b[7], b[9], b[11]) = (f32::NAN, f32::INFINITY, f32::NEG_INFINITY);
    for stencil in &ALL {
        for (width, first) in [(4, [3, 1]), (12, [7, 0]), (1, [0, 7])] {
            let heights = Heights::new(&b, width, 12 / width).unwrap();
            let error = Bake::new(stencil).normals::<[u8; 3]>(&heights).unwrap_err();
            assert_eq!(error, BakeError::NotFinite { count: 3, first });
        }
    }
    let error = Bake::new(&of::CENTRAL2).slopes(&Heights::new(&b[7..8], 1, 1).unwrap()).unwrap_err();
    assert_eq!(error.to_string(), "the height at column 0, row 0 is not finite");
}

#[test]
fn a_hole_is_a_border() {
    // A plane with holes has the plane's slopes, whichever texels are missing; texels with none beside them on
    // either side are flat along that axis, and the hole is flat.
    let (w, h) = (13, 12);
    let mut b: Vec<f32> = (0..w * h).map(|i| 0.25 * (i % w) as f32 - 0.5 * (i / w) as f32).collect();
    for i in [0, 40, 41, 43, 80, 81, 100, 155] {
        b[i] = if i % 2 == 0 { f32::NAN } else { f32::INFINITY };
    }
    for stencil in &ALL {
        let bake = Bake::new(stencil).border([Border::OneSided; 2]).missing_as_border(true);
        let heights = Heights::new(&b, w, h).unwrap();
        let slopes = bake.slopes(&heights).unwrap();
        for (i, [s, t]) in slopes.into_iter().enumerate() {
            let there = |i: usize, step: usize, ok: bool| ok && b[i.wrapping_add(step)].is_finite();
            let (x, y) = (i % w, i / w);
            let beside = there(i, 1, x + 1 < w) || there(i, 1usize.wrapping_neg(), x > 0);
            let above = there(i, w, y + 1 < h) || there(i, w.wrapping_neg(), y > 0);
            let expected = match b[i].is_finite() {
                false => [0.0, 0.0],
                true => [if beside { 0.25 } else { 0.0 }, if above { 0.5 } else { 0.0 }],
            };
            // f32 heights to 6, one-sided weights to 60; farid5's moment is 1 to six digits.
            assert!(
                (s - expected[0]).abs() < 1e-4 && (t - expected[1]).abs() < 1e-4,
                "{} at {x}, {y}: {s} {t} for {expected:?}",
                stencil.title
            );
        }
    }
    // On a torus a run goes on across the edge.
    let ring = [1.0f32, 2.0, f32::NAN, 0.0];
    let bake = Bake::new(&of::CENTRAL2).missing_as_border(true);
    let slopes = bake.slopes(&Heights::new(&ring, 4, 1).unwrap()).unwrap();
    assert_eq!(slopes, [[1.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]);
    // Nothing but holes.
    let bake = bake.border([Border::Mirror; 2]);
    let flat = bake.normals::<[u8; 3]>(&Heights::new(&[f32::NAN; 6], 3, 2).unwrap()).unwrap();
    assert_eq!(flat, [[128, 128, 255]; 6]);
}

#[test]
fn bad_numbers_and_sizes_are_refused() {
    let b = [0u8; 6];
    assert_eq!(Heights::new(&b, 2, 2).err(), Some(BakeError::Length { len: 6, need: 4 }));
    assert_eq!(Heights::new(&b, 0, 2).err(), Some(BakeError::Size { width: 0, height: 2 }));
    assert!(matches!(Heights::new(&b, usize::MAX, 2).err(), Some(BakeError::Size { .. })));
    let heights = Heights::new(&b, 3, 2).unwrap();
    let bake = Bake::new(&of::CENTRAL2);
    let error = |bake: Bake| bake.normals::<[u8; 3]>(&heights).unwrap_err();
    assert!(matches!(error(bake.height_scale(f64::NAN)), BakeError::HeightScale(_)));
    for size in [[0.0, 1.0], [1.0, -2.0], [f64::INFINITY, 1.0], [f64::NAN, 1.0]] {
        assert!(matches!(error(bake.texel_size(size)), BakeError::TexelSize(_)));
    }
    assert!(matches!(error(bake.height_scale(1e30)), BakeError::Slope { .. }));
    let short = bake.normals_into(&heights, &mut [[0u8; 3]; 5]);
    assert_eq!(short, Err(BakeError::Length { len: 5, need: 6 }));
}
