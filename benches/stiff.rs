//! Stiff problems at several tolerances, each labelled with the error it reached: speed at equal error.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use kutta::methods::{Bdf, Kvaerno5, RadauIia3, RadauIia5, Rodas4, Rodas5p};
use kutta::problems::{
    Brusselator1dN40, Equation, Hires, Orego, Pollution, Problem, RobertsonUntil40, VdpMu1000,
};
use kutta::{Auto, Ivp, Method, State};
use std::hint::black_box;

/// The state at the end; nothing where the method does not get there in a reasonable time.
fn run<P: Problem, M: Method>(problem: &P, method: M, tolerance: f64) -> Option<P::Y> {
    let (t0, t1) = problem.span();
    let ivp = Ivp::new(Equation(problem.clone()), black_box(problem.y0()), t0..t1).with(method);
    let ivp = ivp.rtol(tolerance).atol(1e-2 * tolerance * problem.scale()).max_steps(20_000);
    ivp.run().ok().map(|run| run.y)
}

fn measure<P: Problem, M: Method>(c: &mut Criterion, problem: P, name: &str, method: M) {
    let mut group = c.benchmark_group(format!("stiff/{}/{name}", P::NAME));
    let reference = problem.reference().expect("a problem with a reference");
    for tolerance in [1e-3, 1e-5, 1e-8] {
        let Some(y) = run(&problem, method.clone(), tolerance) else { continue };
        let small = 1e-2 * problem.scale();
        let off = |(a, b): (&f64, &f64)| (a - b).abs() / (b.abs() + small);
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
            measure(c, $problem, "rodas4", Rodas4);
            measure(c, $problem, "rodas5p", Rodas5p);
            measure(c, $problem, "radau-iia3", RadauIia3);
            measure(c, $problem, "radau-iia5", RadauIia5);
            measure(c, $problem, "kvaerno5", Kvaerno5);
            measure(c, $problem, "bdf", Bdf);
            measure(c, $problem, "auto", Auto::new());
        )* };
    }
    each!(VdpMu1000 RobertsonUntil40 Hires Orego Pollution Brusselator1dN40);
}

criterion_group!(benches, all);
criterion_main!(benches);
