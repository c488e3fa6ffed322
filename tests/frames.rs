//! Tangent frames (the lecture's items 9 and 10) against surfaces whose tangents are known.

use kutta::normals::frame::{Frame, normal_matrix};
use kutta::normals::tangents::{Mesh, MeshError, Weight, tangents};
use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;

type V = Vector3<f64>;

fn v(x: f64, y: f64, z: f64) -> V {
    V::new(x, y, z)
}

fn uv(s: f64, t: f64) -> Vector2<f64> {
    Vector2::new(s, t)
}

/// Rounding of a handful of operations on numbers of size ten.
const ROUNDING: f64 = 1e-12;

fn near(a: V, b: V, tolerance: f64) -> bool {
    (a - b).norm() <= tolerance
}

fn is_orthonormal(frame: &Frame<f64>) -> bool {
    let rows = frame.rows();
    (rows * rows.transpose() - Matrix3::identity()).norm() < ROUNDING
}

#[test]
fn a_polygon_gives_its_frame() {
    let corners = [v(1.0, 1.0, 5.0), v(3.0, 1.0, 5.0), v(1.0, 4.0, 5.0)];
    let upright = [uv(0.0, 0.0), uv(0.5, 0.0), uv(0.0, 3.0)];
    let frame = Frame::polygon(corners, upright).unwrap();
    // Two units of way for half a unit of s, three for three of t.
    assert_eq!(frame, Frame { p_s: v(4.0, 0.0, 0.0), p_t: v(0.0, 1.0, 0.0), n: V::z() });
    assert_eq!(frame.handedness(), 1.0);
    // The same texture mirrored: s runs back, n stays outside.
    let frame = Frame::polygon(corners, upright.map(|c| uv(-c.x, c.y))).unwrap();
    assert_eq!(frame, Frame { p_s: v(-4.0, 0.0, 0.0), p_t: v(0.0, 1.0, 0.0), n: V::z() });
    assert_eq!(frame.handedness(), -1.0);
    let kept = frame.orthonormal().unwrap();
    assert_eq!(kept, Frame { p_s: -V::x(), p_t: V::y(), n: V::z() });
    // No frame without an area, here or in the texture.
    assert_eq!(Frame::polygon(corners, [uv(0.0, 0.0), uv(0.1, 0.3), uv(0.2, 0.6)]), None);
    assert_eq!(Frame::polygon(corners, [uv(0.5, 0.5); 3]), None);
    assert_eq!(Frame::polygon([corners[0], corners[1], corners[1]], upright), None);
    assert_eq!(Frame::polygon(corners, [uv(0.0, 0.0), uv(f64::NAN, 0.0), upright[2]]), None);
}

#[test]
fn a_surface_gives_its_frame() {
    let cylinder = |s: f64, t: f64| v(2.0 * (TAU * s).cos(), 2.0 * (TAU * s).sin(), 3.0 * t);
    let torus = |s: f64, t: f64| {
        let r = 3.0 + (TAU * t).cos();
        v(r * (TAU * s).cos(), r * (TAU * s).sin(), (TAU * t).sin())
    };
    for (s, t) in [(0.0, 0.0), (0.2, 0.7), (0.61, 0.35), (0.9, -3.2)] {
        let ((sin, cos), (sin_t, cos_t)) = ((TAU * s).sin_cos(), (TAU * t).sin_cos());
        let frame = Frame::surface(cylinder, s, t).unwrap();
        let p_s = v(-sin, cos, 0.0) * (2.0 * TAU);
        assert!(near(frame.p_s, p_s, 1e-9 * p_s.norm()) && near(frame.p_t, v(0.0, 0.0, 3.0), 1e-9));
        assert!(near(frame.n, v(cos, sin, 0.0), 1e-9));
        let frame = Frame::surface(torus, s, t).unwrap();
        let p_s = v(-sin, cos, 0.0) * (TAU * (3.0 + cos_t));
        let p_t = v(-sin_t * cos, -sin_t * sin, cos_t) * TAU;
        assert!(near(frame.p_s, p_s, 1e-9 * p_s.norm()), "{}", (frame.p_s - p_s).norm());
        assert!(near(frame.p_t, p_t, 1e-9 * p_t.norm()));
        assert!(near(frame.n, v(cos_t * cos, cos_t * sin, sin_t), 1e-9));
        assert_eq!(Some(frame.n), Frame::new(frame.p_s, frame.p_t).map(|frame| frame.n));
        let single = |s: f32, t: f32| torus(s.into(), t.into()).cast::<f32>();
        let frame = Frame::surface(single, s as f32, t as f32).unwrap();
        assert!(near(frame.p_s.cast(), p_s, 1e-3 * p_s.norm()), "{}", frame.p_s);
    }
    // At the pole of a sphere s has no direction.
    let sphere = |s: f64, t: f64| {
        let ((sin, cos), (sin_t, cos_t)) = ((TAU * s).sin_cos(), (TAU * t).sin_cos());
        v(cos_t * cos, cos_t * sin, sin_t)
    };
    assert!(Frame::surface(sphere, 0.1, 0.2).is_some());
    assert_eq!(Frame::surface(|s, _| sphere(s, 0.25), 0.1, 0.0), None);
}

/// n crossed with anything: a frame, but its azimuth is an accident.
#[test]
fn a_normal_crossed_with_anything() {
    let up = V::z();
    let frame = Frame::about(v(0.6, 0.0, 0.8) * 3.0, up).unwrap();
    assert!(is_orthonormal(&frame) && frame.handedness() == 1.0);
    assert!(near(frame.p_s, V::y(), ROUNDING), "horizontal: {}", frame.p_s);
    assert_eq!(Frame::about(up, up), None);
    assert_eq!(Frame::about(-up * 2.0, up), None);
    assert_eq!(Frame::about(V::zeros(), up), None);
    // Across the pole, two neighbours a thousandth apart get opposite frames: the seam.
    let [a, b] = [1e-3, -1e-3].map(|x| Frame::about(v(x, 0.0, 1.0), up).unwrap());
    assert!(a.p_s.dot(&b.p_s) < -0.999, "{} {}", a.p_s, b.p_s);
}

/// An open cylinder of radius 2 and height 3, 24 faces round, its seam split, and its exact frames.
struct Tube {
    positions: Vec<V>,
    normals: Vec<V>,
    coordinates: Vec<Vector2<f64>>,
    triangles: Vec<[usize; 3]>,
}

impl Tube {
    const ROUND: usize = 24;
    const RINGS: usize = 5;

    /// `mirrored` runs s the other way.
    fn new(mirrored: bool) -> Self {
        let (mut tube, columns) = (
            Self { positions: vec![], normals: vec![], coordinates: vec![], triangles: vec![] },
            Self::ROUND + 1,
        );
        for ring in 0..Self::RINGS {
            for column in 0..columns {
                let (s, t) = (column as f64 / Self::ROUND as f64, ring as f64 / (Self::RINGS - 1) as f64);
                let n = v((TAU * s).cos(), (TAU * s).sin(), 0.0);
                tube.positions.push(n * 2.0 + V::z() * (3.0 * t));
                // Of any length.
                tube.normals.push(n * 7.0);
                tube.coordinates.push(uv(if mirrored { -s } else { s }, t));
                if ring > 0 && column > 0 {
                    let (d, c) = (ring * columns + column - 1, ring * columns + column);
                    let (a, b) = (d - columns, c - columns);
                    tube.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        tube
    }

    fn mesh(&self) -> Mesh<'_, f64> {
        let Self { positions, normals, coordinates, triangles } = self;
        Mesh { positions, normals, coordinates, triangles }
    }
}

#[test]
fn a_mesh_gives_the_frames_of_its_surface() {
    for (mirrored, side) in [(false, 1.0), (true, -1.0)] {
        let tube = Tube::new(mirrored);
        for weight in [Weight::Area, Weight::Angle] {
            let found = tangents(&tube.mesh(), weight).unwrap();
            assert_eq!((found.degenerate, found.arbitrary), (0, 0));
            for (frame, normal) in found.frames.iter().zip(&tube.normals) {
                let n = normal / 7.0;
                // Every face's P_s is level, so what lies along the level normal is all that Gram-Schmidt takes.
                let p_s = v(-n.y, n.x, 0.0) * side;
                assert!(near(frame.p_s, p_s, ROUNDING), "{weight:?}: {} for {p_s}", frame.p_s);
                assert!(near(frame.p_t, V::z(), ROUNDING) && near(frame.n, n, ROUNDING));
                assert_eq!(frame.handedness(), side);
            }
        }
    }
}

#[test]
fn degenerate_coordinates_are_skipped_and_counted() {
    let mut tube = Tube::new(false);
    let whole = tangents(&tube.mesh(), Weight::Angle).unwrap();
    // A face without texture area, one without area, and a vertex that no triangle has.
    tube.triangles.extend([[0, 1, 0], [3, 4, 4]]);
    let mut found = tangents(&tube.mesh(), Weight::Angle).unwrap();
    assert_eq!((found.degenerate, found.arbitrary), (2, 0));
    assert_eq!(found.frames, whole.frames);
    tube.positions.push(V::zeros());
    tube.normals.push(-V::y());
    tube.coordinates.push(uv(0.0, 0.0));
    found = tangents(&tube.mesh(), Weight::Angle).unwrap();
    assert_eq!((found.degenerate, found.arbitrary), (2, 1));
    assert!(is_orthonormal(found.frames.last().unwrap()));
    // All coordinates alike: nothing is known, and nothing is NaN.
    tube.coordinates.fill(uv(0.3, 0.3));
    for weight in [Weight::Area, Weight::Angle] {
        found = tangents(&tube.mesh(), weight).unwrap();
        assert_eq!((found.degenerate, found.arbitrary), (tube.triangles.len(), tube.positions.len()));
        assert!(found.frames.iter().all(is_orthonormal));
    }
}

/// A fold of two faces, one of them cut in two: by angle the cut does not show, by area the larger face leads.
#[test]
fn weights_differ_where_they_should() {
    // A ridge along y; the left face level, the right one falling, both textured by x and y.
    let build = |cut: bool| {
        let positions =
            [v(0.0, 0.0, 0.0), v(-1.0, 1.0, 0.0), v(0.0, 1.0, 0.0), v(3.0, 0.0, -3.0), v(1.5, 0.5, -1.5)];
        let coordinates = positions.map(|p: V| uv(p.x, p.y));
        let right = if cut { vec![[0, 3, 4], [0, 4, 2]] } else { vec![[0, 3, 2]] };
        let triangles: Vec<_> = [vec![[0, 2, 1]], right].concat();
        (positions, coordinates, triangles)
    };
    let at_ridge = |cut, weight| {
        let (positions, coordinates, triangles) = build(cut);
        // A normal along y leaves the x-z plane, in which the faces' P_s lie, as it is.
        let normals = [V::y(); 5];
        let mesh = Mesh {
            positions: &positions,
            normals: &normals,
            coordinates: &coordinates,
            triangles: &triangles,
        };
        tangents(&mesh, weight).unwrap().frames[0].p_s
    };
    let falling = v(1.0, 0.0, -1.0).normalize();
    // By angle: 45 degrees at the left face's corner, 90 at the right one's.
    let by_angle = (V::x() * 45.0 + falling * 90.0).normalize();
    assert!(near(at_ridge(false, Weight::Angle), by_angle, ROUNDING));
    assert!(near(at_ridge(true, Weight::Angle), by_angle, ROUNDING));
    // By area: 1/2 on the left, 3/2 times the root of 2 on the right.
    let by_area = (V::x() * 0.5 + falling * (1.5 * 2f64.sqrt())).normalize();
    assert!(near(at_ridge(false, Weight::Area), by_area, ROUNDING));
}

#[test]
fn a_bad_mesh_is_refused_by_place() {
    let refused = |spoil: &dyn Fn(&mut Tube)| {
        let mut tube = Tube::new(false);
        spoil(&mut tube);
        tangents(&tube.mesh(), Weight::Area).unwrap_err()
    };
    let short = refused(&|tube| tube.normals.truncate(124));
    assert_eq!(short, MeshError::Lengths { positions: 125, normals: 124, coordinates: 125 });
    let index = refused(&|tube| tube.triangles[7] = [1, 125, 2]);
    assert_eq!(index, MeshError::Index { triangle: 7, index: 125, vertices: 125 });
    assert_eq!(index.to_string(), "triangle 7 has the vertex 125 of 125");
    let at = |vertex| MeshError::NotFinite { vertex };
    assert_eq!(refused(&|tube| tube.positions[3].y = f64::NAN), at(3));
    assert_eq!(refused(&|tube| tube.coordinates[4].y = f64::INFINITY), at(4));
    assert_eq!(refused(&|tube| tube.normals[5] = V::zeros()), MeshError::ZeroNormal { vertex: 5 });
}

/// M = diag(1, 1, 4): a slope of 45 degrees becomes one of atan 4, its normal flatter.
#[test]
fn the_normal_takes_the_inverse_transpose() {
    let stretch = Matrix3::from_diagonal(&v(1.0, 1.0, 4.0));
    let frame = Frame::new(v(1.0, 0.0, 1.0), V::y()).unwrap();
    let seen = frame.transformed(&stretch).unwrap();
    assert!(near(seen.n, v(-4.0, 0.0, 1.0).normalize(), ROUNDING));
    assert!(seen.n.dot(&seen.p_s).abs() < ROUNDING && seen.n.dot(&seen.p_t).abs() < ROUNDING);
    assert_eq!(seen.p_s, v(1.0, 0.0, 4.0));
    // A mirror keeps n outside and turns the hand.
    let mirror = Matrix3::from_diagonal(&v(-1.0, 1.0, 1.0));
    let seen = frame.transformed(&mirror).unwrap();
    assert!(near(seen.n, v(1.0, 0.0, 1.0).normalize(), ROUNDING) && seen.handedness() == -1.0);
    assert_eq!(frame.transformed(&Matrix3::from_diagonal(&v(1.0, 0.0, 1.0))), None);
}

fn vector_of(size: f64) -> impl Strategy<Value = V> {
    [-size..size, -size..size, -size..size].prop_map(V::from)
}

proptest! {
    /// The lecture's P_s, P_t = normal matrix times V_s, V_t agrees with ours for turns.
    #[test]
    fn a_turn_takes_tangents_as_normals(axis in vector_of(3.0), p_s in vector_of(2.0), p_t in vector_of(2.0)) {
        let turn = Rotation3::new(axis).into_inner();
        if let Some(frame) = Frame::new(p_s, p_t) {
            let seen = frame.transformed(&turn).unwrap();
            let normal = normal_matrix(&turn).unwrap();
            prop_assert!(near(seen.p_s, normal * p_s, ROUNDING) && near(seen.p_t, normal * p_t, ROUNDING));
            prop_assert!(near(seen.n, normal * frame.n, ROUNDING));
        }
    }

    /// M_vt finds the components of a vector in the frame: exactly by the inverse, by the rows only
    /// where the frame is orthonormal.
    #[test]
    fn m_vt_takes_vectors_to_texture_space(p_s in vector_of(2.0), p_t in vector_of(2.0), parts in vector_of(1.0)) {
        let frame = Frame::new(p_s, p_t);
        prop_assume!(frame.is_some_and(|frame| frame.p_s.cross(&frame.p_t).norm() > 0.1));
        let frame = frame.unwrap();
        let along = |frame: &Frame<f64>| frame.p_s * parts.x + frame.p_t * parts.y + frame.n * parts.z;
        prop_assert!(near(frame.to_texture().unwrap() * along(&frame), parts, 1e-11), "of condition 1e2");
        let straight = frame.orthonormal().unwrap();
        prop_assert!(is_orthonormal(&straight) && straight.handedness() == 1.0);
        prop_assert!(near(straight.rows() * along(&straight), parts, ROUNDING));
        prop_assert!((straight.rows() - straight.to_texture().unwrap()).norm() < ROUNDING);
        // P_s keeps its azimuth.
        prop_assert!((straight.p_s * p_s.norm() - p_s).norm() < 1e-11);
    }
}

/// How wrong the rows are in a skew frame: P_s and P_t at 60 degrees, a light along P_t.
#[test]
fn rows_bend_the_light_of_a_skew_frame() {
    let frame = Frame::new(V::x(), v(0.5, 0.75f64.sqrt(), 0.0)).unwrap();
    let light = frame.p_t;
    assert!(near(frame.to_texture().unwrap() * light, V::y(), ROUNDING));
    assert!(near(frame.rows() * light, v(0.5, 1.0, 0.0), ROUNDING));
}
