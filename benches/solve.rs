//! Adaptive runs at several tolerances, each labelled with the error it reached: speed at equal error.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use kutta::methods::{Dop853, Dp54, Verner87Efficient};
use kutta::problems::{Arenstorf4Loop, KeplerE06, Lorenz63, Pleiades, Problem, RigidBody};
use kutta::{Method, State, solve};
use std::hint::black_box;

fn run<P: Problem, M: Method>(problem: &P, method: M, tolerance: f64) -> P::Y {
    let (t0, t1) = problem.span();
    let f = |t: f64, y: &P::Y, dy: &mut P::Y| problem.rhs(t, y, dy);
    let ivp = solve(f, black_box(problem.y0()), t0..t1).with(method).rtol(tolerance).atol(tolerance);
    ivp.run().expect("a smooth problem").y
}

fn measure<P: Problem, M: Method>(c: &mut Criterion, problem: P, method: M) {
    let mut group = c.benchmark_group(format!("solve/{}/{}", P::NAME, method.name()));
    let reference = problem.reference().expect("a problem with a reference");
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let y = run(&problem, method.clone(), tolerance);
        let off = |(a, b): (&f64, &f64)| (a - b).abs() / (b.abs() + problem.scale());
        let error = y.as_slice().iter().zip(reference.as_slice()).map(off).fold(0.0, f64::max);
        let label = BenchmarkId::from_parameter(format!("error {error:.1e}"));
        group.bench_with_input(label, &tolerance, |b, &tolerance| {
            b.iter(|| run(&problem, method.clone(), tolerance))
        });
    }
    group.finish();
}

fn all(c: &mut Criterion) {
    macro_rules! each {
        ($($problem:ident)*) => { $(
            measure(c, $problem, Dp54);
            measure(c, $problem, Dop853);
            measure(c, $problem, Verner87Efficient);
        )* };
    }
    each!(Lorenz63 Arenstorf4Loop Pleiades KeplerE06 RigidBody);
}

criterion_group!(benches, all);
criterion_main!(benches);
