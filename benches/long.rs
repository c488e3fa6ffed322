//! Long vectors against the memory: time per step beside the time its traffic takes at the bandwidth of a
//! triad measured in the same run.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use kutta::methods::{Dp54, Rk4};
use kutta::{Method, solve};
use std::hint::black_box;
use std::time::Instant;

const H: f64 = 1e-3;

/// Bytes per second of `a = b + s c`, 24 bytes a component, the best of several passes.
fn triad(n: usize) -> f64 {
    let (mut a, b, c) = (vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let rounds = (4_000_000 / n).max(2);
    let mut best = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
            *a = *b + 3.0 * *c;
        }
        black_box(&mut a);
        best = best.min(start.elapsed().as_secs_f64());
    }
    24.0 * n as f64 / best
}

/// Vectors that a step reads and writes: each stage reads y and the slopes of its row and writes its
/// argument, then f reads that and writes a slope. Taken from the method's own rows.
fn streams(method: &impl Method) -> usize {
    let form = method.form();
    let row = |row: &kutta::tableau::Row| match row.copies() || row.last_y {
        true => 0,
        false => row.len + usize::from(row.base.is_some()) + 1,
    };
    let stages: usize = form.stage[..form.s].iter().map(|r| row(r) + 2).sum();
    let carried: usize = form.carry[..form.r].iter().map(row).sum();
    stages + carried
}

/// Seconds of a run of that many steps.
fn run(method: &impl Method, n: usize, steps: usize) -> f64 {
    // One multiplication and addition per component: f reads y and writes dy, no more.
    let decay = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        for (dy, y) in dy.iter_mut().zip(y) {
            *dy = 0.25 - 0.5 * y;
        }
    };
    let start = Instant::now();
    let ivp = solve(decay, vec![1.0; n], 0.0..steps as f64 * H).with(method.clone()).step(H);
    black_box(ivp.run().expect("a smooth problem"));
    start.elapsed().as_secs_f64()
}

fn measure(c: &mut Criterion, method: impl Method) {
    let mut group = c.benchmark_group(format!("long/{}", method.name()));
    group.sample_size(10);
    for n in [10_000, 1_000_000, 8_000_000] {
        let steps = (8_000_000 / n).clamp(4, 400);
        group.throughput(Throughput::Elements((n * steps) as u64));
        group.bench_with_input(BenchmarkId::from_parameter(n), &n, |b, &n| {
            b.iter(|| run(&method, n, steps));
        });
        // Room for the vectors is taken before the first step: two runs of different length differ by steps
        // alone. The triad is timed between them, and the best of each counts.
        let (mut short, mut long, mut bandwidth) = (f64::INFINITY, f64::INFINITY, 0.0f64);
        for _ in 0..10 {
            short = short.min(run(&method, n, 1));
            bandwidth = bandwidth.max(triad(n));
            long = long.min(run(&method, n, 1 + steps));
        }
        let step = (long - short) / steps as f64;
        let bound = 8.0 * n as f64 * streams(&method) as f64 / bandwidth;
        println!(
            "long/{}/{n}: {:.4} ms a step; its {} streams at the triad's {:.1} GB/s: {:.4} ms; ratio {:.2}",
            method.name(),
            1e3 * step,
            streams(&method),
            1e-9 * bandwidth,
            1e3 * bound,
            step / bound
        );
    }
    group.finish();
}

fn long(c: &mut Criterion) {
    measure(c, Rk4);
    measure(c, Dp54);
}

criterion_group!(benches, long);
criterion_main!(benches);
