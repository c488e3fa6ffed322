//! The brightness of a point of the scene, by each way of pretending that it has relief.

use super::scene::Hit;
use kutta::normals::Border;
use kutta::normals::bump::to_colour;
use kutta::normals::parallax::{parallax, parallax_limited};
use nalgebra::{Vector2, Vector3};

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Mode {
    /// The height map, not lit
    Height,
    /// The normal map, not lit
    Normals,
    /// Lit without bumps
    Flat,
    /// Bump mapping in view space
    Bump,
    /// The normal map, lit in texture space
    NormalMap,
    /// The normal map, shifted by parallax
    Parallax,
    /// The normal map, shifted by parallax with offset limiting
    OffsetLimited,
}

/// What a point in the shadow still gets.
pub const AMBIENT: f64 = 0.1;

/// The texture: its texels, rows from the top, and its size in world units.
pub struct Texture {
    pub width: usize,
    pub height: usize,
    pub tile: Vector2<f64>,
    pub border: [Border; 2],
    /// In world units.
    pub heights: Vec<f64>,
    /// The height, or the depth, that is drawn white.
    pub white: f64,
    pub slopes: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
}

impl Texture {
    /// The texel at texture coordinates in world units.
    fn texel(&self, at: Vector2<f64>) -> usize {
        let find = |x: f64, n: usize, border: Border| {
            let i = (x * n as f64).floor();
            let n = n as f64;
            (if border == Border::Wrap { i.rem_euclid(n) } else { i.clamp(0.0, n - 1.0) }) as usize
        };
        let column = find(at.x / self.tile.x, self.width, self.border[0]);
        let row = find(1.0 - at.y / self.tile.y, self.height, self.border[1]);
        row * self.width + column
    }

    fn normal(&self, at: Vector2<f64>) -> Vector3<f64> {
        Vector3::from(self.normals[self.texel(at)].map(f64::from))
    }

    /// The colour, each part from 0 to 1, of a point under a light from this direction in view coordinates.
    pub fn colour(&self, hit: &Hit, mode: Mode, light: Vector3<f64>) -> Vector3<f64> {
        let (at, frame) = (hit.at, &hit.frame);
        // Frames of our shapes are orthonormal.
        let m_vt = frame.rows();
        let eye = m_vt * Vector3::z();
        let lit_in_texture_space = |at| lambert(self.normal(at), m_vt * light);
        let height = |at| self.heights[self.texel(at)];
        match mode {
            Mode::Height => Vector3::repeat(height(at) / self.white),
            Mode::Normals => to_colour(self.normal(at)),
            Mode::Flat => lambert(frame.n, light),
            Mode::Bump => {
                let [b_s, b_t] = self.slopes[self.texel(at)].map(f64::from);
                lambert(frame.bump(b_s, b_t).normalize(), light)
            }
            Mode::NormalMap => lit_in_texture_space(at),
            Mode::Parallax => lit_in_texture_space(parallax(at, height(at), eye)),
            Mode::OffsetLimited => lit_in_texture_space(parallax_limited(at, height(at), eye)),
        }
    }
}

fn lambert(n: Vector3<f64>, light: Vector3<f64>) -> Vector3<f64> {
    Vector3::repeat(AMBIENT + (1.0 - AMBIENT) * n.dot(&light).max(0.0))
}
