//! Parallax mapping: a texture that shifts with the view, as if the surface had depth.
//!
//! V is the way to the eye in texture space ([`Frame::to_texture`](super::frame::Frame::to_texture)), of
//! unit length, and b the height above the surface, both in the units of the texture coordinates: world
//! units over the size of a tile.
//!
//! # Why limit the offset?
//!
//! The division by V_z makes the shift right for level ground, b / tan of the eye's elevation, and lets it grow
//! without bound as the eye goes down; without it the shift stays within b. Both against the point that a ray,
//! marched into the relief, meets first, for a smooth relief a twentieth of a tile high (`docs/parallax.svg`, by
//! the example `parallax`): RMS error; RMS way that a texel swims over the surface while the eye rises by one
//! degree, both in heights of the relief; and the part of the surface, in percent, on which the texture runs
//! backwards.
//!
//! | elevation | error, full | swim | backwards | error, limited | swim | backwards |
//! |---|---|---|---|---|---|---|
//! | 5 | 1.95 | 1.19 | 23.4 | 5.61 | 0.0008 | 0.0 |
//! | 10 | 0.94 | 0.298 | 7.1 | 2.46 | 0.0016 | 0.0 |
//! | 20 | 0.37 | 0.077 | 0.0 | 0.95 | 0.0031 | 0.0 |
//! | 45 | 0.06 | 0.018 | 0.0 | 0.16 | 0.0063 | 0.0 |
//! | 75 | 0.00 | 0.010 | 0.0 | 0.01 | 0.0087 | 0.0 |
//!
//! So the limited shift is better not by being nearer to the truth, which it nowhere is, but by what it never
//! does. At grazing angles the full one moves neighbouring texels, each by its own height, further apart than
//! they are: the texture tears, runs backwards and swims with every move of the eye. The limited one is flatter
//! and fades to the plain normal map: wrong, but at rest. From 45 degrees upwards there is little between them.

use nalgebra::{RealField, Vector2, Vector3};

/// T = T_0 + b V_xy / V_z: the texture coordinates that the eye would meet, were the height b everywhere.
///
/// The surface seen edge on or from behind, V_z <= 0, stays as it is.
pub fn parallax<T: RealField + Copy>(at: Vector2<T>, b: T, view: Vector3<T>) -> Vector2<T> {
    if view.z > T::zero() { at + view.xy() * (b / view.z) } else { at }
}

/// T = T_0 + b V_xy: parallax with offset limiting (Welsh 2004, "Parallax mapping with offset limiting").
pub fn parallax_limited<T: RealField + Copy>(at: Vector2<T>, b: T, view: Vector3<T>) -> Vector2<T> {
    at + view.xy() * b
}
