//! Speed against error of every stencil: megapixels per second on one thread beside the root mean square of the
//! angle to the exact normals, as a table and as `docs/stencils.svg`.
//!
//! `cargo run --release --features cli --example stencil_speed`

mod plot;

use kutta::normals::accuracy::{Field, Input, Output, Surface};
use kutta::normals::{Bake, BakeError, Heights, Normal, stencils};
use plot::{Point, svg};
use std::time::Instant;

/// Heights and normals of this size are 28 bytes for each of four million texels: more than a core's own cache.
const SIZE: usize = 2048;
/// The best of them counts.
const ROUNDS: usize = 30;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let noise = Field::of(Surface::Noise { shortest: 8.0 });
    let mut points = vec![];
    for entry in stencils::all() {
        let degrees = noise.error(entry.stencil, Input::Float, Output::Float)?.rms;
        points.push(Point { name: entry.name, degrees, floats: 0.0, bytes: 0.0 });
    }
    rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(|| measure(&mut points))?;
    points.sort_by(|a, b| b.degrees.total_cmp(&a.degrees));
    println!("{:10} {:>11} {:>13} {:>12}", "stencil", "RMS degrees", "f32x3 Mpx/s", "RGB8 Mpx/s");
    for Point { name, degrees, floats, bytes } in &points {
        println!("{name:10} {degrees:>11.2e} {floats:>13.0} {bytes:>12.0}");
    }
    std::fs::write("docs/stencils.svg", svg(&points))?;
    Ok(())
}

/// All stencils in turn in each round, so that what else the machine does falls on all alike.
fn measure(points: &mut [Point]) -> Result<(), BakeError> {
    let texels: Vec<f32> = (0..SIZE * SIZE).map(|i| (i * 7919 % 100_003) as f32 / 1e5).collect();
    let heights = Heights::new(&texels, SIZE, SIZE)?;
    let (mut floats, mut bytes) = (vec![[0f32; 3]; SIZE * SIZE], vec![[0u8; 3]; SIZE * SIZE]);
    for _ in 0..ROUNDS {
        for (point, entry) in points.iter_mut().zip(stencils::all()) {
            let bake = Bake::new(entry.stencil);
            point.floats = point.floats.max(speed(&bake, &heights, &mut floats)?);
            point.bytes = point.bytes.max(speed(&bake, &heights, &mut bytes)?);
        }
    }
    Ok(())
}

/// Megapixels per second.
fn speed<N: Normal>(bake: &Bake, heights: &Heights<f32>, out: &mut [N]) -> Result<f64, BakeError> {
    let start = Instant::now();
    bake.normals_into(heights, out)?;
    Ok(out.len() as f64 / 1e6 / start.elapsed().as_secs_f64())
}
