//! Fixed steps against straight-line code written by hand: nanoseconds per step.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kutta::methods::{Ab4, Dop853, Dp54, Rk4, VelocityVerlet};
use kutta::{Method, State, solve, solve_second};
use std::hint::black_box;

#[path = "hand/mod.rs"]
mod hand;
use hand::{lorenz, oscillators};

const STEPS: u64 = 10_000;
const H: f64 = 1e-4;

fn kutta<M: Method, Y: State<Scalar = f64>>(method: M, f: impl FnMut(f64, &Y, &mut Y), y0: Y) -> Y {
    solve(f, y0, 0.0..STEPS as f64 * H).with(method).step(H).run().expect("a smooth problem").y
}

fn step(c: &mut Criterion) {
    let mut group = c.benchmark_group("step/lorenz");
    group.throughput(Throughput::Elements(STEPS));
    let y0 = [1.0, 1.0, 1.0];
    group.bench_function("rk4 by hand", |b| b.iter(|| hand::run(hand::rk4, lorenz, black_box(y0), H, STEPS)));
    group.bench_function("rk4", |b| b.iter(|| kutta(Rk4, lorenz, black_box(y0))));
    group.bench_function("dp54 by hand", |b| {
        b.iter(|| hand::run_fsal(hand::dp54, lorenz, black_box(y0), H, STEPS))
    });
    group.bench_function("dp54", |b| b.iter(|| kutta(Dp54, lorenz, black_box(y0))));
    group.bench_function("dop853 by hand", |b| {
        b.iter(|| hand::run(hand::dop853, lorenz, black_box(y0), H, STEPS))
    });
    group.bench_function("dop853", |b| b.iter(|| kutta(Dop853, lorenz, black_box(y0))));
    group.bench_function("ab4", |b| b.iter(|| kutta(Ab4, lorenz, black_box(y0))));
    group.bench_function("rk4 on SVector", |b| {
        let f = |t: f64, y: &nalgebra::SVector<f64, 3>, dy: &mut nalgebra::SVector<f64, 3>| {
            lorenz(t, &y.data.0[0], &mut dy.data.0[0])
        };
        b.iter(|| kutta(Rk4, f, black_box(nalgebra::SVector::from(y0))))
    });
    group.bench_function("rk4 on Col", |b| {
        let f = |_: f64, y: &faer::Col<f64>, dy: &mut faer::Col<f64>| {
            dy[0] = 10.0 * (y[1] - y[0]);
            dy[1] = y[0] * (28.0 - y[2]) - y[1];
            dy[2] = y[0] * y[1] - 8.0 / 3.0 * y[2];
        };
        b.iter(|| kutta(Rk4, f, black_box(faer::Col::from_fn(3, |i| y0[i]))))
    });
    group.finish();

    let mut group = c.benchmark_group("step/oscillators");
    group.throughput(Throughput::Elements(STEPS));
    let y0 = [1.0, 0.0, 0.5, 0.2];
    group.bench_function("rk4 by hand", |b| {
        b.iter(|| hand::run(hand::rk4, oscillators, black_box(y0), H, STEPS))
    });
    group.bench_function("rk4", |b| b.iter(|| kutta(Rk4, oscillators, black_box(y0))));
    group.bench_function("dp54 by hand", |b| {
        b.iter(|| hand::run_fsal(hand::dp54, oscillators, black_box(y0), H, STEPS))
    });
    group.bench_function("dp54", |b| b.iter(|| kutta(Dp54, oscillators, black_box(y0))));
    group.bench_function("dop853 by hand", |b| {
        b.iter(|| hand::run(hand::dop853, oscillators, black_box(y0), H, STEPS))
    });
    group.bench_function("dop853", |b| b.iter(|| kutta(Dop853, oscillators, black_box(y0))));
    group.bench_function("velocity-verlet", |b| {
        let f = |_: f64, x: &[f64; 2], a: &mut [f64; 2]| {
            a[0] = -x[0] - 2.0 * x[0] * x[1];
            a[1] = -x[1] - x[0] * x[0] + x[1] * x[1];
        };
        b.iter(|| {
            let run = solve_second(f, black_box([0.1, 0.2]), [0.1, 0.3], 0.0..STEPS as f64 * H)
                .with(VelocityVerlet);
            run.step(H).run().expect("a smooth problem").y
        })
    });
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
