//! Parallax mapping: a texture that shifts with the view, as if the surface had depth.
//!
//! V is the way to the eye in texture space ([`Frame::to_texture`](super::frame::Frame::to_texture)), of
//! unit length, and b the height above the surface, both in the units of the texture coordinates: world
//! units over the size of a tile.

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
