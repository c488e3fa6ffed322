//! States at requested times: at both ends, between steps, on their ends, backwards; what they are made of.

use kutta::methods::{self, Ab4, Abm4Pece, Bs32, Dop853, Dp54, Euler, Rk4, Tsit54, VelocityVerlet, Verlet};
use kutta::{Interpolant, Loaded, Method, OutOfDomain, Why, solve, solve_second};

type Y = [f64; 2];

/// y = (sin t, cos t).
fn circle(_: f64, y: &Y, dy: &mut Y) {
    *dy = [y[1], -y[0]];
}

fn on_circle(t: f64) -> Y {
    [t.sin(), t.cos()]
}

fn distance(a: &Y, b: &Y) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

fn steppable() -> impl Iterator<Item = Loaded> {
    methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok())
}

/// Times all over the span, with both ends, in the order of the run.
fn all_over(t0: f64, t1: f64) -> Vec<f64> {
    (0..=97).map(|i| if i == 97 { t1 } else { t0 + (t1 - t0) * (i as f64 / 97.0) }).collect()
}

#[test]
fn requested_times_are_met_to_the_last_bit_in_both_directions() {
    for (t0, t1) in [(0.3, 5.3), (5.3, 0.3), (-1.0, 1.0)] {
        let times = all_over(t0, t1);
        for method in steppable().filter(|m| m.form().d == 1) {
            let run = solve(circle, on_circle(t0), t0..t1).with(method.clone());
            // h^1 at worst, and at best what 500 steps can do.
            let solutions = if method.form().orders > 0 {
                vec![run.rtol(1e-9).atol(1e-9).at(&times).run().unwrap()]
            } else if method.form().errors > 0 {
                let run = solve(circle, on_circle(t0), t0..t1).with(method.clone()).rtol(1e-9).atol(1e-9);
                vec![
                    run.at(&times).run().unwrap(),
                    solve(circle, on_circle(t0), t0..t1)
                        .with(method.clone())
                        .step(0.01)
                        .at(&times)
                        .run()
                        .unwrap(),
                ]
            } else {
                vec![run.step(0.01).at(&times).run().unwrap()]
            };
            for s in solutions {
                assert_eq!(s.ts, times, "{}", method.name());
                assert_eq!((s.ys[0], s.ys[97]), (on_circle(t0), s.y), "{}", method.name());
                let largest =
                    s.ts.iter().zip(&s.ys).map(|(t, y)| distance(y, &on_circle(*t))).fold(0.0, f64::max);
                let end = distance(&s.y, &on_circle(t1));
                // Between steps the error is of the same kind as at the end, where it may have turned to be small;
                // an interpolant of lower order errs more in long steps.
                let lower = s.interpolant.order() < method.form().order;
                assert!(
                    largest < 30.0 * end + if lower { 1e-4 } else { 1e-8 },
                    "{}: {largest:e} along the way, {end:e} at the end",
                    method.name()
                );
            }
        }
    }
}

/// Asking for times changes no step, and a time that is a step's end gives that state to the last bit.
#[test]
fn looking_on_changes_nothing() {
    for method in steppable().filter(|m| m.form().d == 1) {
        let runs = |at: &[f64], every: bool| {
            let run = solve(circle, on_circle(0.0), 0.0..7.0).with(method.clone()).at(at);
            let run = if every { run.every_step() } else { run };
            if method.form().errors > 0 || method.form().orders > 0 {
                run.run()
            } else {
                run.step(0.05).run()
            }
            .unwrap()
        };
        let plain = runs(&[], false);
        let every = runs(&[], true);
        let looked = runs(&all_over(0.0, 7.0), false);
        let again = runs(&every.ts, false);
        assert_eq!((plain.y, plain.stats.accepted), (every.y, every.stats.accepted), "{}", method.name());
        assert_eq!((plain.y, plain.stats), (every.y, every.stats), "{}: saving steps is free", method.name());
        assert_eq!((again.ts, again.ys, again.stats), (every.ts, every.ys, every.stats), "{}", method.name());
        assert_eq!(looked.stats.accepted, plain.stats.accepted, "{}", method.name());
        // A slope that dense output shares with the next step has the same bits either way.
        assert_eq!(looked.y, plain.y, "{}", method.name());
    }
}

#[test]
fn both_kinds_of_saving_go_together() {
    let run = || solve(circle, on_circle(0.0), 0.0..1.0).with(Rk4).step(0.25).every_step();
    let s = run().at(&[0.0, 0.1, 0.25, 0.6, 1.0]).run().unwrap();
    assert_eq!(s.ts, [0.0, 0.1, 0.25, 0.5, 0.6, 0.75, 1.0]);
    assert_eq!(s.ts.len(), s.ys.len());
    // A time that is asked for twice is given twice.
    let s = solve(circle, on_circle(0.0), 0.0..1.0).at(&[0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).run().unwrap();
    assert_eq!(s.ts, [0.0, 0.0, 0.5, 0.5, 1.0, 1.0]);
    assert_eq!((s.ys[2], s.ys[4]), (s.ys[3], s.ys[5]));
}

#[test]
fn the_solution_says_what_it_was_made_of() {
    let of = |interpolant: Interpolant| interpolant;
    let run = || solve(circle, on_circle(0.0), 0.0..1.0);
    assert_eq!(of(run().with(Dp54).run().unwrap().interpolant), Interpolant::Own { order: 4 });
    assert_eq!(of(run().with(Dop853).run().unwrap().interpolant), Interpolant::Own { order: 7 });
    assert_eq!(of(run().with(Euler).step(0.1).run().unwrap().interpolant), Interpolant::Hermite { order: 3 });
    assert_eq!(of(run().with(Rk4).step(0.1).run().unwrap().interpolant), Interpolant::Hermite { order: 4 });
    assert_eq!(of(run().with(Rk4).step(0.1).run().unwrap().interpolant).order(), 4);
}

/// Neighbouring steps agree where they meet, in value and, for Hermite interpolation, in slope.
#[test]
fn the_curve_has_no_kinks() {
    let near = 1e-7;
    let smooth = |times: &[f64], ys: &[Y]| {
        for (t, y) in times.chunks(3).zip(ys.chunks(3)) {
            // Left of a step's end, there, right of it: the difference is the slope to four digits.
            let (left, right) = ((y[1][0] - y[0][0]) / near, (y[2][0] - y[1][0]) / near);
            assert!(
                (left - t[1].cos()).abs() < 1e-3 && (right - t[1].cos()).abs() < 1e-3,
                "{t:?}: {left} {right}"
            );
        }
    };
    let ends: Vec<f64> = solve(circle, on_circle(0.0), 0.0..6.0).every_step().run().unwrap().ts;
    let around = |ends: &[f64]| -> Vec<f64> {
        ends[1..ends.len() - 1].iter().flat_map(|&t| [t - near, t, t + near]).collect()
    };
    let s = solve(circle, on_circle(0.0), 0.0..6.0).at(&around(&ends)).run().unwrap();
    smooth(&s.ts, &s.ys);
    let ends: Vec<f64> = (0..=60).map(|i| i as f64 * 0.1).collect();
    for s in [
        solve(circle, on_circle(0.0), 0.0..6.0).with(Rk4).step(0.1).at(&around(&ends)).run().unwrap(),
        solve(circle, on_circle(0.0), 0.0..6.0).with(Ab4).step(0.1).at(&around(&ends)).run().unwrap(),
        solve(circle, on_circle(0.0), 0.0..6.0).with(Abm4Pece).step(0.1).at(&around(&ends)).run().unwrap(),
        solve(circle, on_circle(0.0), 0.0..6.0).with(Bs32).step(0.1).at(&around(&ends)).run().unwrap(),
    ] {
        smooth(&s.ts, &s.ys);
    }
}

/// x'' = -x: positions and velocities between steps of methods that carry the velocity, and of Störmer's.
#[test]
fn second_order_equations_give_positions_and_velocities() {
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    for (t0, t1) in [(0.3, 5.3), (5.3, 0.3)] {
        let times = all_over(t0, t1);
        for method in steppable().filter(|m| m.form().d == 2) {
            let run = || solve_second(a, [t0.sin()], [t0.cos()], t0..t1).with(method.clone()).step(1e-3);
            let s = run().at(&times).run().unwrap();
            assert_eq!((&s.ts, s.ys[97], s.vs.len()), (&times, s.y, 98), "{}", method.name());
            assert_eq!((s.vs[0], Some(s.vs[97])), ([t0.cos()], s.v), "{}", method.name());
            for ((t, x), v) in s.ts.iter().zip(&s.ys).zip(&s.vs) {
                let error = (x[0] - t.sin()).abs().max((v[0] - t.cos()).abs());
                // Order one errs by h/2 for a unit of time, order two by h^2/12 and more for an unlucky choice.
                let bound = if method.form().order == 1 { 1e-3 } else { 1e-6 };
                assert!(error < bound, "{} at {t}: {error:e}", method.name());
            }
            let every = run().every_step().run().unwrap();
            assert_eq!(
                (every.ts.len(), every.vs.len(), every.y, every.v),
                (5001, 5001, s.y, s.v),
                "{}",
                method.name()
            );
        }
    }
    let run = || solve_second(a, [0.0], [1.0], 0.0..1.0).step(0.1);
    assert_eq!(run().with(VelocityVerlet).run().unwrap().interpolant, Interpolant::Hermite { order: 5 });
    assert_eq!(run().with(Verlet).run().unwrap().interpolant, Interpolant::Hermite { order: 2 });
}

#[test]
fn times_outside_the_span_or_out_of_order_are_refused() {
    for times in [&[-0.1][..], &[1.1], &[0.5, 0.4], &[f64::NAN], &[0.5, f64::NAN, 0.6]] {
        let stopped = solve(circle, on_circle(0.0), 0.0..1.0).at(times).run().unwrap_err();
        assert!(matches!(&stopped.why, Why::Invalid(text) if text.contains("time")), "{times:?}: {stopped}");
    }
    assert!(solve(circle, on_circle(1.0), 1.0..0.0).at(&[0.2, 0.8]).run().is_err());
    assert!(solve(circle, on_circle(1.0), 1.0..0.0).at(&[0.8, 0.2]).run().is_ok());
}

/// Hermite interpolation asks f for slopes at points of its own: where f refuses, or is no number, the step
/// is tried again, smaller, and no NaN is handed out.
#[test]
fn interpolation_does_not_leave_the_domain() {
    for method in steppable().filter(|m| m.form().d == 1 && m.form().errors > 0) {
        for nan in [false, true] {
            let mut calls = 0;
            let f = |_: f64, y: &Y, dy: &mut Y| {
                circle(0.0, y, dy);
                calls += 1;
                // Now and then, wherever it falls.
                match calls % 211 {
                    90 if nan => dy[0] = f64::NAN,
                    90 => return Err(OutOfDomain),
                    _ => {}
                }
                Ok(())
            };
            let times = all_over(0.0, 5.0);
            let run = solve(f, on_circle(0.0), 0.0..5.0).with(method.clone()).rtol(1e-6).atol(1e-6);
            let s = run.at(&times).run().unwrap_or_else(|s| panic!("{}: {s}", method.name()));
            assert_eq!((&s.ts, s.ts.len()), (&times, s.ys.len()), "{}", method.name());
            assert!(s.stats.rejected.total() > 0, "{}", method.name());
            for (t, y) in s.ts.iter().zip(&s.ys) {
                // A local error of 1e-6 in each of some thousand steps of the lowest order.
                assert!(distance(y, &on_circle(*t)) < 1e-3, "{} at {t}: {y:?}", method.name());
            }
            assert_eq!(s.stats.evaluations, calls, "{}", method.name());
        }
    }
}

/// Default method, default tolerances: values between steps are as good as those at their ends.
#[test]
fn the_default_is_smooth_enough() {
    let times = all_over(0.0, 20.0);
    let s =
        solve(circle, on_circle(0.0), 0.0..20.0).with(Tsit54).rtol(1e-8).atol(1e-8).at(&times).run().unwrap();
    let largest = s.ts.iter().zip(&s.ys).map(|(t, y)| distance(y, &on_circle(*t))).fold(0.0, f64::max);
    assert!(largest < 1e-6 && s.stats.accepted < 97 * 3, "{largest:e} in {} steps", s.stats.accepted);
}
