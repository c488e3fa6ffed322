//! Parallax mapping measured against the point that the eye really meets.

use kutta::normals::parallax::{parallax, parallax_limited};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::TAU;

/// Height of the relief in tiles, a usual one.
pub const DEPTH: f64 = 0.05;

/// A relief of one tile that repeats, from 0 to [`DEPTH`]: waves of three lengths in nine directions.
pub fn relief(at: Vector2<f64>) -> f64 {
    const WAVES: [(f64, f64, f64); 9] = [
        (2.0, 1.0, 0.0),
        (1.0, -2.0, 0.3),
        (0.0, 2.0, 0.7),
        (3.0, 3.0, 0.1),
        (4.0, -1.0, 0.5),
        (-2.0, 4.0, 0.9),
        (6.0, 2.0, 0.2),
        (1.0, 6.0, 0.6),
        (5.0, -4.0, 0.4),
    ];
    let sum: f64 = WAVES.iter().map(|(i, j, phase)| (TAU * (i * at.x + j * at.y + phase)).sin()).sum();
    DEPTH * (0.5 + 0.5 * sum / WAVES.len() as f64)
}

/// Where the ray to T_0 from the direction of the eye meets the relief first: marched in steps of a
/// thousandth of a tile, then halved.
pub fn met(at: Vector2<f64>, view: Vector3<f64>) -> Vector2<f64> {
    let ray = |b: f64| at + view.xy() * (b / view.z);
    let above = |b: f64| b - relief(ray(b));
    let steps = (DEPTH * view.xy().norm() / view.z * 1000.0).ceil().max(10.0);
    let (mut high, mut low) = (DEPTH, 0.0);
    for i in 1..=steps as usize {
        let b = DEPTH * (1.0 - i as f64 / steps);
        if above(b) <= 0.0 {
            low = b;
            break;
        }
        high = b;
    }
    for _ in 0..50 {
        let middle = (high + low) / 2.0;
        if above(middle) > 0.0 { high = middle } else { low = middle }
    }
    ray(low)
}

/// What each way of shifting does at one elevation of the eye; lengths in heights of the relief.
#[derive(Debug)]
pub struct Measured {
    pub elevation: f64,
    /// RMS distance from the point that the eye meets.
    pub error: f64,
    /// RMS way of a texel over the surface while the eye rises by one degree.
    pub swim: f64,
    /// Part of the surface on which the texture runs backwards.
    pub folded: f64,
}

pub type Shift = fn(Vector2<f64>, Vector3<f64>) -> Vector2<f64>;

/// The ways of shifting.
pub const SHIFTS: [(&str, Shift); 4] = [
    ("none", |at, _| at),
    ("parallax", |at, view| parallax(at, relief(at), view)),
    ("offset-limited", |at, view| parallax_limited(at, relief(at), view)),
    ("ray marching", met),
];

pub fn direction(azimuth: f64, elevation: f64) -> Vector3<f64> {
    let ((sin, cos), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
    Vector3::new(cos * level, sin * level, up)
}

/// Over a tile, from all sides.
pub fn measure(shift: Shift, elevation: f64) -> Measured {
    const SIDE: usize = 16;
    const AZIMUTHS: usize = 8;
    let (mut error, mut swim, mut folded) = (0.0, 0.0, 0usize);
    for i in 0..SIDE * SIDE * AZIMUTHS {
        let azimuth = 7.0 + 360.0 / AZIMUTHS as f64 * (i / (SIDE * SIDE)) as f64;
        let at = Vector2::new((i % SIDE) as f64, (i / SIDE % SIDE) as f64) / SIDE as f64;
        let view = direction(azimuth, elevation);
        let here = shift(at, view);
        error += (here - met(at, view)).norm_squared();
        swim += (shift(at, direction(azimuth, elevation + 0.5))
            - shift(at, direction(azimuth, elevation - 0.5)))
        .norm_squared();
        // Along the view, where shifts are.
        let step = view.xy().normalize() * 1e-5;
        folded += usize::from((shift(at + step, view) - shift(at - step, view)).dot(&step) < 0.0);
    }
    let count = (SIDE * SIDE * AZIMUTHS) as f64;
    Measured {
        elevation,
        error: (error / count).sqrt() / DEPTH,
        swim: (swim / count).sqrt() / DEPTH,
        folded: folded as f64 / count,
    }
}
