//! Tangent frames: which way the texture coordinates s and t run on a surface.
//!
//! Four sources, each with its place:
//!
//! | what is known | frame |
//! |---|---|
//! | a flat polygon with texture coordinates at its corners | [`Frame::polygon`] |
//! | the surface as a function P(s, t) | [`Frame::surface`], or [`Frame::new`] with exact derivatives |
//! | a mesh with normals and texture coordinates | [`tangents`](super::tangents::tangents) |
//! | a normal and nothing else | [`Frame::about`], with its limits |
//!
//! A normal map that another program baked assumes that program's frames, most often MikkTSpace; the example
//! `mikktspace` takes them from the crate `bevy_mikktspace`.

use nalgebra::{Matrix2, Matrix3, RealField, Vector2, Vector3, convert};

/// A tangent frame at a point of a surface: P_s and P_t, along which s and t grow, and the unit normal n.
///
/// P_t is the bitangent, also called binormal. From [`polygon`](Frame::polygon) and
/// [`surface`](Frame::surface) P_s and P_t are derivatives: their lengths say how far the surface goes per unit
/// of texture coordinate, and they need not be orthogonal.
/// [`orthonormal`](Frame::orthonormal) drops both, which is what a normal map in world units asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<T> {
    pub p_s: Vector3<T>,
    pub p_t: Vector3<T>,
    pub n: Vector3<T>,
}

impl<T: RealField + Copy> Frame<T> {
    /// The frame of two tangents, with n along P_s x P_t. `None` where they are parallel, zero or not finite.
    pub fn new(p_s: Vector3<T>, p_t: Vector3<T>) -> Option<Self> {
        let n = p_s.cross(&p_t);
        let sine = n.norm() / (p_s.norm() * p_t.norm());
        // Not a number where a length is zero or infinite, and then no frame.
        (sine > tiny()).then(|| Self { p_s, p_t, n: n.normalize() })
    }

    /// The frame of a polygon, from three of its corners, counterclockwise seen from outside, and the texture
    /// coordinates there: \[P_s P_t\] = \[dP1 dP2\] \[duv1 duv2\]^-1.
    ///
    /// n follows the corners, not the texture: where the texture lies mirrored, the frame is left-handed.
    /// `None` where corners or coordinates lie on one line or are not finite.
    pub fn polygon(corners: [Vector3<T>; 3], coordinates: [Vector2<T>; 3]) -> Option<Self> {
        let [p0, p1, p2] = corners;
        let [c0, c1, c2] = coordinates;
        let n = Self::new(p1 - p0, p2 - p0)?.n;
        let (a, b) = (c1 - c0, c2 - c0);
        let sine = a.perp(&b) / (a.norm() * b.norm());
        if !(sine.abs() > tiny()) {
            return None;
        }
        let inverse = Matrix2::from_columns(&[a, b]).try_inverse()?;
        let (e1, e2) = (p1 - p0, p2 - p0);
        let p_s = e1 * inverse[(0, 0)] + e2 * inverse[(1, 0)];
        let p_t = e1 * inverse[(0, 1)] + e2 * inverse[(1, 1)];
        finite(&p_s, &p_t).then_some(Self { p_s, p_t, n })
    }

    /// The frame of a surface P(s, t) at a point of it, by central differences of fourth order.
    ///
    /// On a surface that bends once round per unit of s and t, P_s and P_t are right to about 1e-9 in `f64`
    /// and 1e-3 in `f32`; [`Frame::new`] takes exact ones. `None` where P_s and P_t are parallel or not
    /// finite, as at the pole of a sphere.
    pub fn surface(p: impl Fn(T, T) -> Vector3<T>, s: T, t: T) -> Option<Self> {
        // Truncation of h^4 against rounding of eps/h.
        let h = T::default_epsilon().powf(convert(0.2));
        let two = h + h;
        let slope = |p2: Vector3<T>, p1: Vector3<T>, m1: Vector3<T>, m2: Vector3<T>| {
            ((p1 - m1) * convert::<_, T>(8.0) - (p2 - m2)) / (h * convert(12.0))
        };
        Self::new(
            slope(p(s + two, t), p(s + h, t), p(s - h, t), p(s - two, t)),
            slope(p(s, t + two), p(s, t + h), p(s, t - h), p(s, t - two)),
        )
    }

    /// The hack for demonstrations, a normal crossed with anything: P_s = anything x n, P_t = n x P_s, both
    /// of unit length.
    ///
    /// It knows nothing of the texture. The azimuth is arbitrary, so only bumps that look alike in every
    /// direction, such as isotropic noise, look right; anything with a grain is turned. And no vector serves
    /// a closed surface: near points where n is parallel to it the frame spins, at them it is `None`, and a
    /// second vector for those leaves a seam.
    pub fn about(n: Vector3<T>, anything: Vector3<T>) -> Option<Self> {
        // The normal of these two is P_s up to its length.
        let p_s = Self::new(anything, n)?.n;
        let n = n.normalize();
        Some(Self { p_s, p_t: n.cross(&p_s), n })
    }

    /// This frame with unit vectors at right angles: n stays, P_s keeps its azimuth (Gram-Schmidt), P_t keeps
    /// its side. `None` where P_s is parallel to n or has no length.
    pub fn orthonormal(&self) -> Option<Self> {
        let n = self.n.normalize();
        let flat = self.p_s - n * n.dot(&self.p_s);
        if !(flat.norm() > self.p_s.norm() * tiny()) {
            return None;
        }
        let p_s = flat.normalize();
        Some(Self { p_s, p_t: n.cross(&p_s) * self.handedness(), n })
    }

    /// 1 where P_s, P_t and n are right-handed, -1 where the texture lies mirrored: glTF's `tangent.w`.
    pub fn handedness(&self) -> T {
        if self.p_s.cross(&self.p_t).dot(&self.n) < T::zero() { -T::one() } else { T::one() }
    }

    /// M_vt with the rows P_s, P_t and n. It takes a vector, such as the way to the light or to the eye, to
    /// texture space where the frame is orthonormal, and only there: see [`to_texture`](Self::to_texture).
    pub fn rows(&self) -> Matrix3<T> {
        Matrix3::from_rows(&[self.p_s.transpose(), self.p_t.transpose(), self.n.transpose()])
    }

    /// M_vt for every frame: the inverse of the matrix with columns P_s, P_t and n. For an orthonormal frame
    /// the inverse is the transpose, hence [`rows`](Self::rows); for a skew one it is not, and the rows bend
    /// the light. Its own rows are the dual vectors P_t x n and n x P_s over n . (P_s x P_t), and a normal in
    /// texture space goes back by its transpose. `None` where the frame spans no volume.
    pub fn to_texture(&self) -> Option<Matrix3<T>> {
        Matrix3::from_columns(&[self.p_s, self.p_t, self.n]).try_inverse()
    }

    /// This frame in view coordinates: tangents by the matrix, the normal by its [`normal_matrix`].
    ///
    /// The lecture sends all three through the normal matrix. For turns and uniform scaling that is the same
    /// up to length; for any other matrix it would tear P_s and P_t off the surface. `None` where the matrix
    /// has no inverse.
    pub fn transformed(&self, model_view: &Matrix3<T>) -> Option<Self> {
        let n = (normal_matrix(model_view)? * self.n).try_normalize(T::zero())?;
        Some(Self { p_s: model_view * self.p_s, p_t: model_view * self.p_t, n })
    }
}

/// The matrix that takes normals where `model_view` takes points: its inverse, transposed. `None` where it
/// has no inverse.
pub fn normal_matrix<T: RealField + Copy>(model_view: &Matrix3<T>) -> Option<Matrix3<T>> {
    Some(model_view.try_inverse()?.transpose())
}

/// Sines below this are rounding.
fn tiny<T: RealField + Copy>() -> T {
    T::default_epsilon() * convert(16.0)
}

pub(super) fn finite<T: RealField + Copy>(a: &Vector3<T>, b: &Vector3<T>) -> bool {
    a.iter().chain(b.iter()).all(|x| x.is_finite())
}
