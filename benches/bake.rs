//! Megapixels per second of 4096 x 4096 bakes, through the public API, beside what the memory allows: the same
//! bytes read and written, measured in the same rounds. The feature `rayon` adds a second thread.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kutta::normals::{Bake, Height, Heights, Normal, Stencil, stencils};
use std::hint::black_box;
use std::time::Instant;

const SIZE: usize = 4096;
const ROUNDS: usize = 12;
const MEGAPIXELS: f64 = (SIZE * SIZE) as f64 / 1e6;

/// Reads every height and writes `bytes` bytes for each, past the cache where the bake does.
mod bound {
    /// Heights that belong to whole lines of output.
    const BLOCK: usize = 64;

    pub fn run<const BYTES: usize>(heights: &[f32], out: &mut [[u8; BYTES]]) {
        let mut sum = [0f32; 16];
        for (heights, out) in heights.chunks_exact(BLOCK).zip(out.chunks_exact_mut(BLOCK)) {
            for heights in heights.as_chunks::<16>().0 {
                for (sum, h) in sum.iter_mut().zip(heights) {
                    *sum += h;
                }
            }
            store(sum[0].to_bits() as u8, out.as_flattened_mut());
        }
        std::hint::black_box(sum);
        fence();
    }

    #[cfg(target_arch = "x86_64")]
    fn store(value: u8, out: &mut [u8]) {
        use std::arch::x86_64::{__m128i, _mm_set1_epi8, _mm_stream_si128};
        let head = out.as_ptr().align_offset(16).min(out.len());
        let (head, body) = out.split_at_mut(head);
        head.fill(value);
        for block in body.as_chunks_mut::<16>().0 {
            // SAFETY: 16 bytes that are aligned to 16; SSE2 is part of x86-64.
            unsafe { _mm_stream_si128(block.as_mut_ptr().cast::<__m128i>(), _mm_set1_epi8(value as i8)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    fn store(value: u8, out: &mut [u8]) {
        out.fill(value);
    }

    fn fence() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: SSE is part of x86-64.
        unsafe {
            std::arch::x86_64::_mm_sfence()
        };
    }

    /// The same on every thread of the pool.
    #[cfg(feature = "rayon")]
    pub fn run_all<const BYTES: usize>(heights: &[f32], out: &mut [[u8; BYTES]]) {
        use rayon::prelude::*;
        let n = super::SIZE * 32;
        heights.par_chunks(n).zip(out.par_chunks_mut(n)).for_each(|(heights, out)| run(heights, out));
    }
    #[cfg(not(feature = "rayon"))]
    pub use run as run_all;
}

fn seconds(f: impl FnOnce()) -> f64 {
    let start = Instant::now();
    f();
    start.elapsed().as_secs_f64()
}

/// Megapixels per second of the best round: the bound, then each stencil.
fn table<N: Normal, H: Height, const BYTES: usize>(
    heights: &[H],
    floats: &[f32],
    out: &mut [N],
    plain: &mut [[u8; BYTES]],
) -> Vec<f64> {
    let heights = Heights::new(heights, SIZE, SIZE).expect("as many texels as the size says");
    let mut best = vec![f64::INFINITY; 1 + stencils::all().len()];
    for _ in 0..ROUNDS {
        best[0] = best[0].min(seconds(|| bound::run_all(floats, plain)));
        for (best, entry) in best[1..].iter_mut().zip(stencils::all()).filter(|(_, e)| explicit(e.stencil)) {
            let bake = Bake::new(entry.stencil);
            *best = best.min(seconds(|| bake.normals_into(&heights, out).expect("finite heights")));
        }
    }
    best.iter().map(|seconds| MEGAPIXELS / seconds).collect()
}

/// A compact stencil solves for whole lines: another kind of work.
fn explicit(stencil: &Stencil) -> bool {
    stencil.left.len == 1
}

fn with_threads(threads: usize, f: impl FnOnce() + Send) {
    #[cfg(feature = "rayon")]
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(f);
    #[cfg(not(feature = "rayon"))]
    if threads == 1 {
        f();
    }
}

fn bake(c: &mut Criterion) {
    let floats: Vec<f32> = (0..SIZE * SIZE).map(|i| (i * 7919 % 100_003) as f32 / 1e5).collect();
    let bytes: Vec<u8> = floats.iter().map(|h| (h * 255.0) as u8).collect();
    let mut normals = vec![[0f32; 3]; SIZE * SIZE];
    let mut rgb = vec![[0u8; 3]; SIZE * SIZE];
    // What the bound writes, as large as what the bake does.
    let (mut twelve, mut three) = (vec![[0u8; 12]; SIZE * SIZE], vec![[0u8; 3]; SIZE * SIZE]);
    println!("bake: Mpx/s of {SIZE} x {SIZE}, the part of the bound in brackets; on 1 and 2 threads");
    let columns = ["f32 to f32x3", "f32 to RGB8", "u8 to RGB8"];
    let mut all = vec![];
    for threads in [1, 2] {
        with_threads(threads, || {
            all.push(table(&floats, &floats, &mut normals, &mut twelve));
            all.push(table(&floats, &floats, &mut rgb, &mut three));
            all.push(table(&bytes, &floats, &mut rgb, &mut three));
        });
    }
    print!("{:10}", "");
    all.iter().enumerate().for_each(|(i, _)| print!(" {:>16}", columns[i % 3]));
    println!();
    let names = std::iter::once("bound").chain(stencils::all().iter().map(|entry| entry.name));
    for (row, name) in names.enumerate().filter(|(row, _)| all[0][*row] > 0.0) {
        print!("{name:10}");
        all.iter().for_each(|speed| print!(" {:>9.0} ({:3.0} %)", speed[row], 100.0 * speed[row] / speed[0]));
        println!();
    }

    let mut group = c.benchmark_group("bake");
    group.sample_size(10).throughput(Throughput::Elements((SIZE * SIZE) as u64));
    let heights = Heights::new(&floats, SIZE, SIZE).expect("as many texels as the size says");
    for stencil in [&stencils::CENTRAL2, &stencils::CENTRAL4, &stencils::SCHARR3] {
        let bake = Bake::new(stencil);
        group.bench_function(format!("{} to f32x3", stencil.title), |b| {
            b.iter(|| bake.normals_into(&heights, black_box(&mut normals)))
        });
        group.bench_function(format!("{} to RGB8", stencil.title), |b| {
            b.iter(|| bake.normals_into(&heights, black_box(&mut rgb)))
        });
    }
    // What the choice of length costs.
    let bake = Bake::new(&stencils::CENTRAL4).best_fit(true);
    let part = Heights::new(&floats[..SIZE * 256], SIZE, 256).expect("as many texels as the size says");
    group.throughput(Throughput::Elements((SIZE * 256) as u64));
    group.bench_function("central4 to RGB8 of the best length", |b| {
        b.iter(|| bake.normals_into(&part, black_box(&mut rgb[..SIZE * 256])))
    });
    group.finish();
}

criterion_group!(benches, bake);
criterion_main!(benches);
