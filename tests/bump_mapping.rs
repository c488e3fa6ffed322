//! Bump mapping (the lecture's items 11 to 15) in view space, in texture space, as it was taught, and by parallax.

use kutta::normals::bump::{forward_slopes, from_colour, texture_normal, to_colour};
use kutta::normals::frame::Frame;
use kutta::normals::parallax::{parallax, parallax_limited};
use kutta::normals::{Bake, Heights, stencils};
use nalgebra::{Rotation3, Vector2, Vector3};
use proptest::prelude::*;

type V = Vector3<f64>;

fn v(x: f64, y: f64, z: f64) -> V {
    V::new(x, y, z)
}

fn uv(s: f64, t: f64) -> Vector2<f64> {
    Vector2::new(s, t)
}

fn vector_of(size: f64) -> impl Strategy<Value = V> {
    [-size..size, -size..size, -size..size].prop_map(V::from)
}

proptest! {
    /// The same light whether the normal goes to the light's space or the light to the texture's.
    #[test]
    fn view_space_and_texture_space_agree(turn in vector_of(3.0), mirrored: bool, light in vector_of(1.0),
                                          b_s in -9.0..9.0f64, b_t in -9.0..9.0f64) {
        let turn = Rotation3::new(turn);
        let side = if mirrored { -1.0 } else { 1.0 };
        let frame = Frame { p_s: turn * V::x(), p_t: turn * V::y() * side, n: turn * V::z() };
        let (seen, stored) = (frame.bump(b_s, b_t), texture_normal(b_s, b_t));
        prop_assert!((seen.dot(&light) - stored.dot(&(frame.rows() * light))).abs() < 1e-13);
        prop_assert!((seen.norm() - stored.norm()).abs() < 1e-13);
        // Single precision agrees to its own rounding.
        let frame = Frame { p_s: frame.p_s.cast::<f32>(), p_t: frame.p_t.cast(), n: frame.n.cast() };
        let (b_s, b_t, light) = (b_s as f32, b_t as f32, light.cast::<f32>());
        let there = texture_normal(b_s, b_t).dot(&(frame.rows() * light));
        prop_assert!((frame.bump(b_s, b_t).dot(&light) - there).abs() < 1e-5);
    }

    /// In any frame: the normal of the raised surface is the cross product of its tangents.
    #[test]
    fn a_skew_frame_takes_the_dual(p_s in vector_of(2.0), p_t in vector_of(2.0), b_s in -2.0..2.0f64, b_t in -2.0..2.0f64) {
        let frame = Frame::new(p_s, p_t);
        prop_assume!(frame.is_some_and(|frame| frame.p_s.cross(&frame.p_t).norm() > 0.1));
        let frame = frame.unwrap();
        let raised: V = (p_s + frame.n * b_s).cross(&(p_t + frame.n * b_t)).normalize();
        let bumped = (frame.to_texture().unwrap().transpose() * texture_normal(b_s, b_t)).normalize();
        prop_assert!((raised - bumped).norm() < 1e-11, "of condition 1e2");
        // The short form holds once the frame is orthonormal.
        let straight = frame.orthonormal().unwrap();
        let raised = (straight.p_s + straight.n * b_s).cross(&(straight.p_t + straight.n * b_t));
        prop_assert!((straight.bump(b_s, b_t) - raised).norm() < 1e-12);
    }
}

/// A height that rises to the right leans the normal to the left; a depth, the other way.
#[test]
fn the_sign_is_the_slopes() {
    let frame = Frame { p_s: V::x(), p_t: V::y(), n: V::z() };
    assert_eq!(frame.bump(0.5, 0.0), v(-0.5, 0.0, 1.0));
    assert_eq!(frame.bump(0.0, 0.25), v(0.0, -0.25, 1.0));
    assert_eq!(frame.bump(-0.5, 0.0), v(0.5, 0.0, 1.0));
}

/// The lecture's normal map, worked out by hand: -b_s = b[s, t] - b[s+1, t], -b_t = b[s, t] - b[s, t+1],
/// not normalised, R = (x + 1)/2. All in quarters and eighths, so every digit is exact.
#[test]
fn the_lectures_precomputation() {
    // t upwards: b[s, t] is the row t from the bottom. The border repeats.
    let b = [[0.0, 0.5, 0.25], [0.75, 0.5, 1.0], [0.25, 0.0, 0.5]];
    let at = |s: isize, t: isize| b[t.rem_euclid(3) as usize][s.rem_euclid(3) as usize];
    let stored = |s, t, sign: f64| {
        let [b_s, b_t] = forward_slopes(at, s, t).map(|slope| sign * slope);
        to_colour(texture_normal(b_s, b_t))
    };
    // At (0, 0): -b_s = 0 - 0.5, -b_t = 0 - 0.75, so R = 0.25, G = 0.125, B = 1.
    assert_eq!(stored(0, 0, 1.0), v(0.25, 0.125, 1.0));
    // At (1, 1): -b_s = 0.5 - 1 = -0.5, -b_t = 0.5 - 0 = 0.5.
    assert_eq!(stored(1, 1, 1.0), v(0.25, 0.75, 1.0));
    // At (2, 2), over both borders: -b_s = 0.5 - 0.25 = 0.25, -b_t = 0.5 - 0.25 = 0.25.
    assert_eq!(stored(2, 2, 1.0), v(0.625, 0.625, 1.0));
    // Depths: x and y change sign.
    assert_eq!(stored(0, 0, -1.0), v(0.75, 0.875, 1.0));
    assert_eq!(from_colour(stored(0, 0, 1.0)), v(-0.5, -0.75, 1.0));
    assert_eq!(to_colour(V::z()), v(0.5, 0.5, 1.0));
}

/// The same from the bake: forward2 is the lecture's difference, and its first row of texels is the top one.
#[test]
fn the_lectures_slopes_are_those_of_forward2() {
    let b = [[0.25, 0.0, 0.5], [0.75, 0.5, 1.0], [0.0, 0.5, 0.25f32]];
    let heights = Heights::new(b.as_flattened(), 3, 3).unwrap();
    let at = |s: isize, t: isize| b[(2 - t).rem_euclid(3) as usize][s.rem_euclid(3) as usize];
    for scale in [1.0f32, -2.0] {
        let slopes = Bake::new(&stencils::FORWARD2).height_scale(scale.into()).slopes(&heights).unwrap();
        for (i, slope) in slopes.iter().enumerate() {
            let lecture = forward_slopes(at, (i % 3) as isize, 2 - (i / 3) as isize);
            assert_eq!(*slope, lecture.map(|b| scale * b), "texel {i}");
        }
    }
}

/// A raised plane: parallax is exact, and goes towards the eye.
#[test]
fn parallax_meets_a_raised_plane() {
    let (at, b) = (uv(0.3, 0.6), 0.05);
    for view in [v(0.3, -0.4, 0.5), v(-0.9, 0.1, 0.05)].map(|view| view.normalize()) {
        let met = parallax(at, b, view);
        // From the point on the raised plane along -V down to the surface: back at T_0.
        let down = met.push(b) - view * (b / view.z);
        assert!((down - at.push(0.0)).norm() < 1e-15, "{down}");
        let limited = parallax_limited(at, b, view);
        assert!((limited - at - view.xy() * b).norm() < 1e-16);
        assert!(((met - at) * view.z - (limited - at)).norm() < 1e-15, "the denominator is all that differs");
    }
    // From straight above nothing shifts; from the edge or behind, nothing breaks.
    assert_eq!((parallax(at, b, V::z()), parallax_limited(at, b, V::z())), (at, at));
    for view in [v(1.0, 0.0, 0.0), v(0.6, 0.0, -0.8)] {
        assert_eq!(parallax(at, b, view), at);
        assert_eq!(parallax_limited(at, b, view), at + view.xy() * b);
    }
}

proptest! {
    /// Why offset limiting: the shift stays within b, while the other grows as 1/tan of the view's elevation.
    #[test]
    fn the_limited_shift_is_bounded(azimuth in 0.0..6.2f64, elevation in 1e-6..1.5f64, b in -1.0..1.0f64) {
        let level = Vector2::new(f64::cos(azimuth), f64::sin(azimuth)) * elevation.cos();
        let view = level.push(elevation.sin());
        let zero = Vector2::zeros();
        prop_assert!(parallax_limited(zero, b, view).norm() <= b.abs());
        let expected = b.abs() / elevation.tan();
        prop_assert!((parallax(zero, b, view).norm() - expected).abs() <= 1e-12 * expected);
    }
}
