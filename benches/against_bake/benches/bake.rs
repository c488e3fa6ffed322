//! Sobel normals of a map of 4096 x 4096 in RGB8, on one thread: kutta, and imageproc's two gradient images with
//! the normal worked out texel by texel, as its users do.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use image::{ImageBuffer, Luma, Rgb, RgbImage};
use kutta::normals::{Bake, Border, Heights, stencils};
use std::hint::black_box;
use std::time::Instant;

const SIZE: u32 = 4096;

fn imageproc(map: &ImageBuffer<Luma<u8>, Vec<u8>>) -> RgbImage {
    let right = imageproc::gradients::horizontal_sobel(map);
    let down = imageproc::gradients::vertical_sobel(map);
    // Sobel's sums are 8 times the difference, and of bytes.
    let scale = 1.0 / (8.0 * 255.0);
    RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let [s, t] = [right[(x, y)][0], down[(x, y)][0]].map(|d| f32::from(d) * scale);
        let length = (s * s + t * t + 1.0).sqrt();
        Rgb([-s, t, 1.0].map(|n| ((n / length + 1.0) * 127.5 + 0.5) as u8))
    })
}

fn bake(c: &mut Criterion) {
    let n = (SIZE * SIZE) as usize;
    let bytes: Vec<u8> = (0..n).map(|i| (i * 7919 % 256) as u8).collect();
    let map = ImageBuffer::from_raw(SIZE, SIZE, bytes.clone()).expect("as many texels as the size says");
    let heights = Heights::new(&bytes, SIZE as usize, SIZE as usize).expect("as many texels");
    let bake = Bake::new(&stencils::SOBEL3).border([Border::Clamp; 2]);
    let mut rgb = vec![[0u8; 3]; n];
    bake.normals_into(&heights, &mut rgb).expect("a map of bytes");

    let theirs = imageproc(&map);
    let near = |a: &u8, b: &u8| a.abs_diff(*b) <= 1;
    assert!(rgb.as_flattened().iter().zip(theirs.as_raw()).all(|(a, b)| near(a, b)), "the same normals");
    let (mut ours, mut other) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..8 {
        let start = Instant::now();
        bake.normals_into(&heights, &mut rgb).expect("a map of bytes");
        ours = ours.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        black_box(imageproc(&map));
        other = other.min(start.elapsed().as_secs_f64());
    }
    let speed = |seconds: f64| n as f64 / 1e6 / seconds;
    let (a, b) = (speed(ours), speed(other));
    println!("sobel3, u8 to RGB8: kutta {a:.0} Mpx/s, imageproc {b:.0} Mpx/s: {:.1} times", other / ours);

    let mut group = c.benchmark_group("against_bake");
    group.sample_size(10).throughput(Throughput::Elements(n as u64));
    group.bench_function("kutta", |b| b.iter(|| bake.normals_into(&heights, black_box(&mut rgb))));
    group.bench_function("imageproc", |b| b.iter(|| imageproc(black_box(&map))));
    group.finish();
}

criterion_group!(benches, bake);
criterion_main!(benches);
