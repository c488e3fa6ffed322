//! Tangent frames of a mesh, by differentials from its vertex data.

use super::frame::{Frame, finite};
use nalgebra::{RealField, Vector2, Vector3};
use std::fmt;

/// A triangle mesh: a position, a normal and texture coordinates for each vertex, and triangles of three
/// vertices each, counterclockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'m, T> {
    pub positions: &'m [Vector3<T>],
    /// Of any length but zero.
    pub normals: &'m [Vector3<T>],
    pub coordinates: &'m [Vector2<T>],
    pub triangles: &'m [[usize; 3]],
}

/// How much a triangle counts at its vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// By its area: large faces lead.
    Area,
    /// By its angle at the vertex: cutting a face into more triangles changes nothing.
    Angle,
}

/// The frames of a mesh, and what stood in their way.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangents<T> {
    /// One orthonormal frame for each vertex. A shader needs `p_s` and [`Frame::handedness`].
    pub frames: Vec<Frame<T>>,
    /// Triangles left out, since their corners or their texture coordinates lie on one line.
    pub degenerate: usize,
    /// Vertices whose triangles were all left out or cancelled: their azimuth is arbitrary.
    pub arbitrary: usize,
}

/// Why a mesh is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshError {
    Lengths { positions: usize, normals: usize, coordinates: usize },
    Index { triangle: usize, index: usize, vertices: usize },
    NotFinite { vertex: usize },
    ZeroNormal { vertex: usize },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Lengths { positions, normals, coordinates } => write!(
                f,
                "{positions} positions, {normals} normals and {coordinates} texture coordinates: \
                 each vertex has one of each"
            ),
            Self::Index { triangle, index, vertices } => {
                write!(f, "triangle {triangle} has the vertex {index} of {vertices}")
            }
            Self::NotFinite { vertex } => write!(f, "vertex {vertex} is not finite"),
            Self::ZeroNormal { vertex } => write!(f, "the normal of vertex {vertex} is zero"),
        }
    }
}

impl std::error::Error for MeshError {}

/// The tangent frame of each vertex: P_s and P_t of each triangle from its edges and the differences of its
/// texture coordinates (see [`Frame::polygon`]), their directions summed over the triangles of the vertex by
/// weight, P_s made orthogonal to the vertex normal (Gram-Schmidt), P_t on the side where the sum has it.
///
/// Triangles of degenerate texture coordinates are skipped and counted. A vertex shared by a face and its
/// mirror image has no frame of its own: split it, as exporters do along such a seam.
pub fn tangents<T: RealField + Copy>(mesh: &Mesh<T>, weight: Weight) -> Result<Tangents<T>, MeshError> {
    mesh.check()?;
    // P_s, P_t, and for how much weight they are right-handed.
    let mut sums = vec![(Vector3::zeros(), Vector3::zeros(), T::zero()); mesh.positions.len()];
    let mut degenerate = 0;
    for triangle in mesh.triangles {
        let corners = triangle.map(|i| mesh.positions[i]);
        let Some(frame) = Frame::polygon(corners, triangle.map(|i| mesh.coordinates[i])) else {
            degenerate += 1;
            continue;
        };
        let (p_s, p_t) = (frame.p_s.normalize(), frame.p_t.normalize());
        for (corner, &vertex) in triangle.iter().enumerate() {
            let weight = weight.at(corners, corner);
            let side = p_s.cross(&p_t).dot(&mesh.normals[vertex]);
            let sum = &mut sums[vertex];
            sum.0 += p_s * weight;
            sum.1 += p_t * weight;
            sum.2 += if side < T::zero() { -weight } else { weight };
        }
    }
    let mut arbitrary = 0;
    let frames = sums.iter().zip(mesh.normals).map(|(&(p_s, p_t, side), n)| {
        let n = n.normalize();
        let p_t = if p_s.cross(&p_t).dot(&n) * side < T::zero() { -p_t } else { p_t };
        let summed = Frame { p_s, p_t, n };
        summed.orthonormal().filter(|frame| finite(&frame.p_s, &frame.p_t)).unwrap_or_else(|| {
            arbitrary += 1;
            any(n)
        })
    });
    Ok(Tangents { frames: frames.collect(), degenerate, arbitrary })
}

impl Weight {
    fn at<T: RealField + Copy>(self, corners: [Vector3<T>; 3], corner: usize) -> T {
        let [p, q, r] = [0, 1, 2].map(|i| corners[(corner + i) % 3]);
        match self {
            Self::Area => (q - p).cross(&(r - p)).norm(),
            Self::Angle => (q - p).angle(&(r - p)),
        }
    }
}

impl<T: RealField + Copy> Mesh<'_, T> {
    fn check(&self) -> Result<(), MeshError> {
        let [positions, normals, coordinates] =
            [self.positions.len(), self.normals.len(), self.coordinates.len()];
        if normals != positions || coordinates != positions {
            return Err(MeshError::Lengths { positions, normals, coordinates });
        }
        for vertex in 0..positions {
            let coordinates = self.coordinates[vertex].push(T::zero());
            let n = &self.normals[vertex];
            if !finite(&self.positions[vertex], n) || !finite(&coordinates, n) {
                return Err(MeshError::NotFinite { vertex });
            }
            if !(n.norm() > T::zero()) {
                return Err(MeshError::ZeroNormal { vertex });
            }
        }
        for (triangle, indices) in self.triangles.iter().enumerate() {
            if let Some(&index) = indices.iter().find(|&&index| index >= positions) {
                return Err(MeshError::Index { triangle, index, vertices: positions });
            }
        }
        Ok(())
    }
}

/// A frame about a normal for which no direction is better than another.
fn any<T: RealField + Copy>(n: Vector3<T>) -> Frame<T> {
    let axis = if n.y.abs() < n.x.abs() { Vector3::y() } else { Vector3::x() };
    let p_s = (axis - n * n.dot(&axis)).normalize();
    Frame { p_s, p_t: n.cross(&p_s), n }
}
