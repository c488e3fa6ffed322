//! Jumps of the right-hand side at declared times.

use crate::PAIRS;
use kutta::methods::{Ab4, Dp54, Rk4};
use kutta::{Method, Why, solve};
use std::cell::Cell;

/// 0 before the break, 1 from it on: y' = step - y from y = 1.
fn relax(at: f64) -> impl Fn(f64, &[f64; 1], &mut [f64; 1]) + Copy {
    move |t, y, dy| dy[0] = if t < at { 0.0 } else { 1.0 } - y[0]
}

fn relaxed(at: f64, t0: f64, t: f64) -> f64 {
    let rise = if t < at { 0.0 } else { 1.0 - (at - t).exp() };
    (t0 - t).exp() + rise
}

#[test]
fn a_declared_jump_costs_no_accuracy() {
    for method in PAIRS.iter() {
        for at in [0.0, 0.7, 1.0 / 3.0, -0.25] {
            let tol = 1e-9;
            let run = solve(relax(at), [1.0], -1.0..2.0).with(method.clone()).rtol(tol).atol(tol);
            let s = run.breaks(&[at]).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
            let error = (s.y[0] - relaxed(at, -1.0, 2.0)).abs();
            // Errors of tol a step in each of two smooth parts, which decay.
            assert!(error < 5.0 * tol, "{}, {at}: {error:e}", method.name());
        }
    }
}

/// Until a break f is asked for times before it only, from there on for times at or behind it only: the
/// slope right at the break is the one of the side that the step is on.
#[test]
fn each_side_sees_its_own_values() {
    for method in PAIRS.iter() {
        for (t0, t1) in [(-1.0, 1.0), (1.0, -1.0)] {
            for at in [0.0, 0.1, -0.3, 1e-300] {
                let passed = Cell::new(false);
                let forward = t1 > t0;
                let f = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
                    let behind = if forward { t >= at } else { t <= at };
                    assert!(behind || !passed.get(), "{}: {t:e} after {at:e}", method.name());
                    passed.set(behind);
                    dy[0] = -y[0];
                };
                for fixed in [false, true] {
                    passed.set(false);
                    let run = solve(f, [1.0], t0..t1).with(method.clone()).breaks(&[at]);
                    let s = if fixed { run.step(0.3).run() } else { run.run() }.unwrap();
                    assert!(passed.get() && s.t == t1, "{}", method.name());
                }
            }
        }
    }
}

#[test]
fn breaks_are_met_to_the_last_bit_in_any_order_and_number() {
    let steps = |breaks: &[f64], span: std::ops::Range<f64>| {
        let s = solve(relax(0.5), [1.0], span).breaks(breaks).every_step().run().unwrap();
        s.ts
    };
    for (breaks, met) in [
        (&[0.5, 0.25, 0.75][..], &[0.25, 0.5, 0.75][..]),
        (&[0.5, 0.5, 0.5], &[0.5]),
        // At the ends and outside the span there is nothing to meet.
        (&[0.0, 1.0, -1.0, 2.0, 0.5], &[0.5]),
        (&[1.0 / 3.0, 0.1 + 0.2], &[0.1 + 0.2, 1.0 / 3.0]),
        (&[1e-300, 0.5], &[0.5]),
    ] {
        for span in [0.0..1.0, 1.0..0.0] {
            let ts = steps(breaks, span.clone());
            for at in met {
                assert_eq!(ts.iter().filter(|t| *t == at).count(), 1, "{breaks:?} {span:?}: {ts:?}");
            }
            assert!(ts.windows(2).all(|t| t[0] != t[1]), "{ts:?}");
        }
    }
    let stopped = solve(relax(0.5), [1.0], 0.0..1.0).breaks(&[f64::NAN]).run().unwrap_err();
    assert!(matches!(stopped.why, Why::Invalid(_)));
}

/// A dose and a break one unit in the last place beside it are one: the run goes on, neither lost nor twice.
#[test]
fn breaks_a_few_spacings_apart_are_one() {
    let at = 0.7;
    let near: Vec<f64> = std::iter::successors(Some(at), |t: &f64| Some(t.next_up())).take(5).collect();
    for span in [0.0..2.0, 2.0..0.0] {
        let s = solve(relax(at), [1.0], span.clone()).breaks(&near).every_step().run().unwrap();
        let met = s.ts.iter().filter(|t| (*t - at).abs() < 1e-12).count();
        assert_eq!(met, 1, "{span:?}: {:?}", s.ts);
    }
    let s = solve(relax(at), [1.0], 0.0..2.0).breaks(&near).rtol(1e-10).atol(1e-10).run().unwrap();
    assert!((s.y[0] - relaxed(at, 0.0, 2.0)).abs() < 1e-9);
}

/// The history of a multistep method, and the slope carried by a pair, belong to the old side.
#[test]
fn fixed_steps_keep_their_order_across_a_break() {
    let at = 0.4;
    let error = |n: f64| {
        let run = solve(relax(at), [1.0], 0.0..1.0).breaks(&[at]);
        let s = run.with(Ab4).step(1.0 / n).run().unwrap();
        assert_eq!(s.stats.accepted, n as u64);
        (s.y[0] - relaxed(at, 0.0, 1.0)).abs()
    };
    let order = (error(80.0) / error(160.0)).log2();
    assert!((order - 4.0).abs() < 0.2, "{order}");
    let run = || solve(relax(at), [1.0], 0.0..1.0).breaks(&[at]).step(0.01);
    for s in [run().with(Dp54).run().unwrap(), run().with(Rk4).run().unwrap()] {
        // The error constants of methods of order 4 and 5 are below 1/100.
        assert!((s.y[0] - relaxed(at, 0.0, 1.0)).abs() < 1e-10);
    }
}

#[test]
fn times_asked_for_at_a_break() {
    let at = 0.7;
    for times in [&[0.7][..], &[0.7, 0.7], &[0.2, 0.7, 0.7000000000000001, 0.9]] {
        for fixed in [false, true] {
            let run = solve(relax(at), [1.0], 0.0..1.0).rtol(1e-10).atol(1e-10).breaks(&[at]).at(times);
            let s = if fixed { run.step(0.02).run().unwrap() } else { run.run().unwrap() };
            assert_eq!(s.ts, times);
            for (t, y) in s.ts.iter().zip(&s.ys) {
                assert!((y[0] - relaxed(at, 0.0, *t)).abs() < 1e-8, "{t}: {}", y[0]);
            }
        }
    }
}
