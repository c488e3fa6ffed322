//! Makes the two height maps of `docs/`: a brick wall that tiles and a dome, PNGs of 16-bit grey.
//!
//! `cargo run --release --features cli --example height_maps`

use std::io::BufWriter;

/// Of the brick wall, in texels; a course is two bricks long, and there are four.
const WALL: usize = 256;
const COURSE: f64 = 64.0;
const BRICK: f64 = 128.0;
const MORTAR: f64 = 4.5;
/// Heights are multiples of 1/1024: finer noise would only make the file large.
const STEPS: f64 = 1024.0;

/// A spherical cap of 24 texels' height: the sphere has a radius of 60, the base one of 48. White is its top,
/// so `--height-scale 24` makes it true.
const DOME: usize = 128;
const SPHERE: f64 = 60.0;
const BASE: f64 = 48.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    save("docs/brick.png", WALL, |x, y| (wall(x, y) * STEPS).round() / STEPS)?;
    save("docs/dome.png", DOME, dome)
}

fn dome(x: f64, y: f64) -> f64 {
    let middle = DOME as f64 / 2.0;
    let level = (x - middle).powi(2) + (y - middle).powi(2);
    let rim = (SPHERE * SPHERE - BASE * BASE).sqrt();
    (((SPHERE * SPHERE - level).max(0.0).sqrt() - rim) / (SPHERE - rim)).max(0.0)
}

/// Bricks in running bond, with round edges, a height and a lean of their own, and a grain.
fn wall(x: f64, y: f64) -> f64 {
    let course = (y / COURSE).floor();
    let shifted = x + if course % 2.0 == 1.0 { BRICK / 2.0 } else { 0.0 };
    let brick = (shifted / BRICK).floor().rem_euclid(WALL as f64 / BRICK);
    let random = |k: i64| chance(brick as i64 + 100 * k, course as i64 + 7);
    // From the middle of the brick, and how far within its edge, the corners being round.
    let (u, v) = (shifted.rem_euclid(BRICK) - BRICK / 2.0, y.rem_euclid(COURSE) - COURSE / 2.0);
    let worn = 2.5 * (noise(x, y, 16) - 0.5) + 1.5 * (noise(x, y, 32) - 0.5);
    let half = [BRICK / 2.0 - MORTAR, COURSE / 2.0 - MORTAR];
    let corner = 7.0;
    let [a, b] = [(u.abs() - half[0] + corner).max(0.0), (v.abs() - half[1] + corner).max(0.0)];
    let within = corner + worn - a.hypot(b);
    let edge = smooth((within / 6.0).clamp(0.0, 1.0));
    let lean = (random(1) - 0.5) * u / BRICK + (random(2) - 0.5) * v / COURSE;
    let grain =
        0.10 * (noise(x, y, 8) - 0.5) + 0.07 * (noise(x, y, 32) - 0.5) + 0.05 * (noise(x, y, 64) - 0.5);
    let pits = 0.16 * smooth(((noise(x + 31.0, y + 17.0, 32) - 0.78) / 0.2).clamp(0.0, 1.0));
    let face = 0.74 + 0.18 * (random(3) - 0.5) + 0.2 * lean + grain - pits;
    let joint = 0.16 + 0.06 * (noise(x, y, 32) - 0.5) + 0.08 * (noise(x, y, 64) - 0.5);
    (joint + (face - joint) * edge).clamp(0.0, 1.0)
}

/// Value noise from 0 to 1 of `cells` cells along the wall, repeating with it.
fn noise(x: f64, y: f64, cells: i64) -> f64 {
    let scale = cells as f64 / WALL as f64;
    let (x, y) = (x * scale, y * scale);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let at = |di: i64, dj: i64| chance((i + di).rem_euclid(cells) + 1000 * cells, (j + dj).rem_euclid(cells));
    let (p, q) = (smooth(x - x.floor()), smooth(y - y.floor()));
    let mix = |a: f64, b: f64, p: f64| a + (b - a) * p;
    mix(mix(at(0, 0), at(1, 0), p), mix(at(0, 1), at(1, 1), p), q)
}

/// 3 x^2 - 2 x^3
fn smooth(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

/// A number from 0 to 1 for each pair, the same on every machine: two rounds of SplitMix64.
fn chance(a: i64, b: i64) -> f64 {
    let mut z =
        (a as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (b as u64).wrapping_mul(0xd1b5_4a32_d192_ed03);
    for _ in 0..2 {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
    }
    (z >> 11) as f64 / (1u64 << 53) as f64
}

/// Writes heights from 0 to 1, taken at the middles of the texels, row 0 on top.
fn save(path: &str, size: usize, b: impl Fn(f64, f64) -> f64) -> Result<(), Box<dyn std::error::Error>> {
    let texel = |i: usize| b((i % size) as f64 + 0.5, (i / size) as f64 + 0.5);
    let bytes = (0..size * size).flat_map(|i| ((texel(i) * 65535.0).round() as u16).to_be_bytes());
    let file = BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, size as u32, size as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes.collect::<Vec<_>>())?;
    writer.finish()?;
    println!("{path}: {size} x {size}, {} bytes", std::fs::metadata(path)?.len());
    Ok(())
}
