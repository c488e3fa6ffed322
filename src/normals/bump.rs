//! Bump mapping: the normal of a surface that a height field raises, without raising it.
//!
//! A point P moves to P + b n, so its tangents become P_s + b_s n and P_t + b_t n, and their cross product,
//! in an orthonormal frame, n - b_s P_s - b_t P_t. Texts write "+-": minus is for heights, plus for depths.
//! Here the sign is the slope's own: a depth map is a height map with a negative `height_scale`.
//!
//! - In view space: [`Frame::bump`], lit by the light as it comes.
//! - In texture space: [`texture_normal`], lit by the light that M_vt ([`Frame::rows`]) took there. Simpler,
//!   and it depends on the texture alone, so it can be stored: the normal map.
//!
//! Both give the same light: L . n' = (M_vt L) . (-b_s, -b_t, 1).

use super::frame::Frame;
use nalgebra::{RealField, Vector3};

impl<T: RealField + Copy> Frame<T> {
    /// n' = n - b_s P_s - b_t P_t, not normalised, for slopes b_s and b_t of the height along P_s and P_t.
    ///
    /// Right in an orthonormal frame. In a skew one, with b_s and b_t the derivatives by s and t, the
    /// normal is the transpose of [`to_texture`](Frame::to_texture) times [`texture_normal`].
    pub fn bump(&self, b_s: T, b_t: T) -> Vector3<T> {
        self.n - self.p_s * b_s - self.p_t * b_t
    }
}

/// (-b_s, -b_t, 1): the same normal in texture coordinates, not normalised.
pub fn texture_normal<T: RealField + Copy>(b_s: T, b_t: T) -> Vector3<T> {
    Vector3::new(-b_s, -b_t, T::one())
}

/// The lecture's slopes, differences to the next texel: b_s = b\[s+1, t\] - b\[s, t\] and
/// b_t = b\[s, t+1\] - b\[s, t\], t upwards. What lies beyond the border `b` decides.
///
/// As a stencil that is `forward2`: good, but at home half a texel further along s and t.
/// [`texture_normal`] of these, stored by [`to_colour`], is the lecture's normal map.
pub fn forward_slopes<T: RealField + Copy>(b: impl Fn(isize, isize) -> T, s: isize, t: isize) -> [T; 2] {
    let here = b(s, t);
    [b(s + 1, t) - here, b(s, t + 1) - here]
}

/// R = (x + 1)/2, G = (y + 1)/2, B = (z + 1)/2: components from -1 to 1 as colours from 0 to 1.
pub fn to_colour<T: RealField + Copy>(n: Vector3<T>) -> Vector3<T> {
    let one = T::one();
    n.map(|x| (x + one) / (one + one))
}

/// x = 2R - 1, y = 2G - 1, z = 2B - 1: the inverse of [`to_colour`].
pub fn from_colour<T: RealField + Copy>(colour: Vector3<T>) -> Vector3<T> {
    colour.map(|r| r + r - T::one())
}
