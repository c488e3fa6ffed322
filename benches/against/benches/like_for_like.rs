//! DP5 against DP5, DOP853 against DOP853: time to the same error, in one run.
//!
//! For each error the loosest tolerance is taken with which a package reaches it; the repeats of the
//! packages take turns, and the table shows medians and ratios.

use against::{DifferentialEquations, Kutta, OdeSolvers, Package};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use kutta::problems::{Arenstorf4Loop, KeplerE06, Lorenz63, Pleiades, Problem, RigidBody};
use std::hint::black_box;
use std::time::Instant;

const ERRORS: [f64; 3] = [1e-3, 1e-6, 1e-9];
const ROUNDS: usize = 61;

type Run<const N: usize, P> = fn(P, f64) -> Result<[f64; N], String>;

fn error<const N: usize, P: Problem<Y = [f64; N]>>(problem: &P, y: &[f64; N]) -> f64 {
    let reference = problem.reference().expect("a problem with a reference");
    let off = |(a, b): (&f64, &f64)| (a - b).abs() / (b.abs() + problem.scale());
    y.iter().zip(&reference).map(off).fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a })
}

/// The loosest tolerance of a sweep by tenths of a decade that reaches the error and is not lucky: the next
/// tighter one reaches it too.
fn tolerance<const N: usize, P: Problem<Y = [f64; N]>>(
    problem: &P,
    run: Run<N, P>,
    goal: f64,
) -> Option<f64> {
    let mut before = None;
    for k in 20..140 {
        let tolerance = 10f64.powf(-k as f64 / 10.0);
        let good = run(problem.clone(), tolerance).is_ok_and(|y| error(problem, &y) <= goal);
        match (good, before) {
            (true, Some(loose)) => return Some(loose),
            (true, None) => before = Some(tolerance),
            (false, _) => before = None,
        }
    }
    None
}

fn compare<const N: usize, P: Problem<Y = [f64; N]>>(c: &mut Criterion, problem: P) {
    let packages: [(&str, Run<N, P>, Run<N, P>); 3] = [
        (Kutta::NAME, Kutta::dp5, Kutta::dop853),
        (OdeSolvers::NAME, OdeSolvers::dp5, OdeSolvers::dop853),
        (DifferentialEquations::NAME, DifferentialEquations::dp5, DifferentialEquations::dop853),
    ];
    for (method, of) in [("dp5", 0), ("dop853", 1)] {
        for goal in ERRORS {
            let runs = packages.map(|(name, dp5, dop853)| {
                let run = if of == 0 { dp5 } else { dop853 };
                (name, run, tolerance(&problem, run, goal))
            });
            let mut times = [const { vec![] }; 3];
            for _ in 0..ROUNDS {
                for ((_, run, tolerance), times) in runs.iter().zip(&mut times) {
                    if let Some(tolerance) = tolerance {
                        let start = Instant::now();
                        black_box(run(black_box(problem.clone()), *tolerance)).expect("it ran before");
                        times.push(start.elapsed().as_secs_f64());
                    }
                }
            }
            let median = |times: &mut Vec<f64>| {
                times.sort_by(f64::total_cmp);
                times.get(times.len() / 2).copied()
            };
            let medians = times.each_mut().map(median);
            print!("{:16} {method:7} to {goal:.0e}:", P::NAME);
            for ((name, _, _), time) in runs.iter().zip(medians) {
                match (time, medians[0]) {
                    (Some(time), Some(own)) => print!("  {name} {:.1} us ({:.2})", 1e6 * time, time / own),
                    _ => print!("  {name} not reached"),
                }
            }
            println!();
            let mut group = c.benchmark_group(format!("{}/{method}", P::NAME));
            for (name, run, tolerance) in runs {
                if let Some(tolerance) = tolerance {
                    group.bench_with_input(
                        BenchmarkId::new(name, format!("{goal:.0e}")),
                        &tolerance,
                        |b, &tolerance| b.iter(|| run(black_box(problem.clone()), tolerance)),
                    );
                }
            }
            group.finish();
        }
    }
}

fn all(c: &mut Criterion) {
    compare(c, Lorenz63);
    compare(c, Arenstorf4Loop);
    compare(c, Pleiades);
    compare(c, KeplerE06);
    compare(c, RigidBody);
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_millis(800))
        .warm_up_time(std::time::Duration::from_millis(200));
    targets = all
}
criterion_main!(benches);
