//! Tangents for a normal map that another program baked: those of MikkTSpace, from `bevy_mikktspace`, beside
//! kutta's own for the same mesh.
//!
//! A baker and a renderer must agree on the tangents to the last step, or seams show. Most bakers agree on
//! MikkTSpace, so assets from elsewhere need exactly that; what kutta bakes from a height map needs no more than
//! the directions of s and t.
//!
//! `cargo run --example mikktspace`

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use kutta::normals::tangents::{Mesh, Weight, tangents};
use nalgebra::{Vector2, Vector3};
use std::f32::consts::TAU;

/// A torus of indexed triangles, as an exporter splits it along its seams, and a tangent for each corner.
#[derive(Default)]
struct Torus {
    positions: Vec<Vector3<f32>>,
    normals: Vec<Vector3<f32>>,
    coordinates: Vec<Vector2<f32>>,
    triangles: Vec<[usize; 3]>,
    /// P_s, and the handedness as the last number.
    tangents: Vec<[[f32; 4]; 3]>,
}

impl Torus {
    fn new(round: usize, about: usize) -> Self {
        let mut torus = Self::default();
        for (i, j) in (0..=round).flat_map(|i| (0..=about).map(move |j| (i, j))) {
            let (s, t) = (i as f32 / round as f32, j as f32 / about as f32);
            let ((sin, cos), (sin_t, cos_t)) = ((TAU * s).sin_cos(), (TAU * t).sin_cos());
            torus.normals.push(Vector3::new(cos_t * cos, cos_t * sin, sin_t));
            let middle = Vector3::new(3.0 * cos, 3.0 * sin, 0.0);
            torus.positions.push(middle + torus.normals[torus.normals.len() - 1]);
            torus.coordinates.push(Vector2::new(s, t));
            if i > 0 && j > 0 {
                let (c, d) = (i * (about + 1) + j, (i - 1) * (about + 1) + j);
                torus.triangles.extend([[d - 1, c - 1, c], [d - 1, c, d]]);
            }
        }
        torus.tangents = vec![[[0.0; 4]; 3]; torus.triangles.len()];
        torus
    }
}

impl Geometry for Torus {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.triangles[face][corner]].into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.triangles[face][corner]].into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.coordinates[self.triangles[face][corner]].into()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face][corner] = space.unwrap_or_default().tangent_encoded();
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut torus = Torus::new(48, 24);
    generate_tangents(&mut torus)?;
    let Torus { positions, normals, coordinates, triangles, tangents: theirs } = &torus;
    let ours = tangents(&Mesh { positions, normals, coordinates, triangles }, Weight::Angle)?;
    let (mut most, mut same) = (0f32, true);
    for (triangle, corners) in triangles.iter().zip(theirs) {
        for (&vertex, &[x, y, z, w]) in triangle.iter().zip(corners) {
            let frame = &ours.frames[vertex];
            most = most.max(frame.p_s.angle(&Vector3::new(x, y, z)).to_degrees());
            same &= frame.handedness() == w;
        }
    }
    println!("{} vertices, {} triangles, {} degenerate", positions.len(), triangles.len(), ours.degenerate);
    println!("P_s of kutta and of MikkTSpace differ by at most {most:.3} degrees");
    println!("their handedness {}", if same { "agrees" } else { "differs" });
    Ok(())
}
