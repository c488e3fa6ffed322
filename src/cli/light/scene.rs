//! One shape before the eye: which point of it a ray of the view meets, and the tangent frame there.

use kutta::normals::frame::Frame;
use nalgebra::{Matrix3, Vector2, Vector3};
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Shape {
    /// One tile, lying flat
    Quad,
    /// Two tiles wound round an upright cylinder, one of them in sight
    Cylinder,
}

/// A tile of the texture in world units, x to the right along s and y up along t, its middle the origin. The
/// eye is far away over the lower edge, so all its rays are parallel.
pub struct Scene {
    shape: Shape,
    tile: Vector2<f64>,
    /// Sine and cosine of the eye's elevation over the tile.
    sin: f64,
    cos: f64,
    to_view: Matrix3<f64>,
}

/// Where a ray meets the shape.
pub struct Hit {
    /// Texture coordinates in world units: s from the left, t from the bottom.
    pub at: Vector2<f64>,
    /// In view coordinates: x to the right, y up, z to the eye.
    pub frame: Frame<f64>,
}

/// The direction at this azimuth, counterclockwise from the right, and elevation over the tile, in degrees.
pub fn direction(azimuth: f64, elevation: f64) -> Vector3<f64> {
    let ((sin, cos), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
    Vector3::new(cos * level, sin * level, up)
}

impl Scene {
    /// The eye at an elevation above 0 and up to 90 degrees, from where it looks straight down.
    pub fn new(shape: Shape, tile: [f64; 2], elevation: f64) -> Self {
        let (sin, cos) = if elevation == 90.0 { (1.0, 0.0) } else { elevation.to_radians().sin_cos() };
        let to_view = Matrix3::new(1.0, 0.0, 0.0, 0.0, sin, cos, 0.0, -cos, sin);
        Self { shape, tile: tile.into(), sin, cos, to_view }
    }

    /// Turns a direction of the world into one of the view.
    pub fn seen(&self, direction: Vector3<f64>) -> Vector3<f64> {
        self.to_view * direction
    }

    fn radius(&self) -> f64 {
        self.tile.x / PI
    }

    /// The lower left and upper right corner of what is in sight, in view coordinates.
    pub fn extent(&self) -> [Vector2<f64>; 2] {
        let half = self.tile.y / 2.0 * self.sin;
        match self.shape {
            Shape::Quad => [-1.0, 1.0].map(|side| Vector2::new(side * self.tile.x / 2.0, side * half)),
            Shape::Cylinder => {
                let r = self.radius();
                [Vector2::new(-r, -half), Vector2::new(r, half + r * self.cos)]
            }
        }
    }

    /// What the ray through a point of the view meets first.
    pub fn hit(&self, view: Vector2<f64>) -> Option<Hit> {
        let (x, z, s, p_s, n) = match self.shape {
            Shape::Quad => (view.x, 0.0, view.x, Vector3::x(), Vector3::z()),
            Shape::Cylinder => {
                let r = self.radius();
                let z = (r * r - view.x * view.x).max(0.0).sqrt();
                let (sin, cos) = (view.x / r, z / r);
                let n = Vector3::new(sin, 0.0, cos);
                (view.x, z, r * view.x.atan2(z), Vector3::new(cos, 0.0, -sin), n)
            }
        };
        // view.y = y sin + z cos
        let y = (view.y - z * self.cos) / self.sin;
        let half = self.tile / 2.0;
        let inside = y.abs() <= half.y && (self.shape == Shape::Cylinder || x.abs() <= half.x);
        inside.then(|| {
            let frame = Frame { p_s, p_t: Vector3::y(), n };
            let seen = |v| self.to_view * v;
            let frame = Frame { p_s: seen(frame.p_s), p_t: seen(frame.p_t), n: seen(frame.n) };
            Hit { at: Vector2::new(s, y) + half, frame }
        })
    }
}
