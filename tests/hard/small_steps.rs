//! Steps that shrink without end: poles, noise, limits.

use crate::{EVERY, PAIRS};
use kutta::{Controller, Method, Why, solve};

/// y' = y^2, y(0) = 1: y = 1/(1 - t).
fn pole(_: f64, y: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [y[0] * y[0], 0.0];
}

#[test]
fn a_pole_ends_the_run_with_where_why_and_the_solution_so_far() {
    for method in PAIRS.iter() {
        let name = method.name();
        let run = solve(pole, [1.0, 1.0], 0.0..2.0).with(method.clone()).rtol(1e-6).atol(1e-6).every_step();
        let stopped = run.run().expect_err(name);
        assert!(matches!(stopped.why, Why::StepTooSmall { .. }), "{name}: {stopped}");
        // Near the pole the relative error of y is that of 1 - t, so the pole is off by about rtol a step.
        assert!((stopped.t - 1.0).abs() < 1e-4, "{name}: {stopped}");
        assert!(stopped.h > 0.0 && stopped.h < 1e-14, "{name}: h = {:e}", stopped.h);
        let s = stopped.solution;
        assert!((s.t, s.ts.len()) == (stopped.t, s.ys.len()) && s.y[0] > 1e10, "{name}: {:e}", s.y[0]);
        assert_eq!(s.ts.last(), Some(&s.t), "{name}");
        let middle = s.ts.iter().position(|&t| t > 0.5).expect("a step past the middle");
        assert!((s.ys[middle][0] * (1.0 - s.ts[middle]) - 1.0).abs() < 1e-4, "{name}");
    }
}

#[test]
fn the_limiting_component_is_named() {
    // Two slow components around a fast pair.
    let f = |_: f64, y: &[f64; 4], dy: &mut [f64; 4]| *dy = [-y[0], 50.0 * y[2], -50.0 * y[1], 0.1 * y[3]];
    for method in PAIRS.iter() {
        let run = solve(f, [1.0; 4], 0.0..3.0).with(method.clone()).rtol(0.0).atol(1e-6).first_step(1.0);
        let s = run.controller(Controller::I).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        if s.stats.rejected.error > 0 {
            assert!(matches!(s.stats.limiting, Some(1 | 2)), "{}: {:?}", method.name(), s.stats);
        }
    }
    let stopped = solve(pole, [1.0, 1.0], 0.0..2.0).first_step(1.0).run().unwrap_err();
    assert_eq!(stopped.why, Why::StepTooSmall { limiting: Some(0) });
    assert!(stopped.to_string().contains("component 0"), "{stopped}");
}

/// Slopes that never agree with each other: no step passes, and the run must find out soon.
#[test]
fn endless_rejection_ends() {
    for method in PAIRS.iter() {
        for t0 in [0.0, 1.0, -3.0] {
            // Numbers between -1e300 and 1e300 without a pattern.
            let mut state = 1u32;
            let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| {
                state = state.wrapping_mul(1664525).wrapping_add(1013904223);
                dy[0] = if t == t0 { 0.0 } else { 1e300 * (state as f64 / 2f64.powi(31) - 1.0) };
            };
            let run = solve(f, [0.0], t0..t0 + 1.0).with(method.clone()).max_steps(10_000);
            let stopped = run.run().expect_err(method.name());
            let rejected = stopped.solution.stats.rejected;
            assert!(rejected.total() < 3000, "{}: {stopped:?}", method.name());
            assert!(rejected.error > 5 && rejected.non_finite == 0, "{}: {stopped:?}", method.name());
            // From t = 0 steps can shrink to the least number, from elsewhere only to the spacing there.
            if t0 != 0.0 {
                let why = &stopped.why;
                assert_eq!(why, &Why::StepTooSmall { limiting: Some(0) }, "{}", method.name());
                assert_eq!(stopped.t, t0, "{}", method.name());
            }
        }
    }
}

#[test]
fn a_slope_that_is_good_at_one_point_only_ends_the_run() {
    for method in EVERY.iter() {
        for t0 in [0.0, 1.0] {
            let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if t == t0 { 1.0 } else { f64::NAN };
            let stopped = solve(f, [0.0], t0..2.0).with(method.clone()).run().expect_err(method.name());
            assert!(
                matches!(stopped.why, Why::NonFinite { component: 0, .. } | Why::Jacobian { component: 0 }),
                "{stopped}"
            );
            assert!(stopped.t == t0 && stopped.solution.stats.rejected.non_finite < 400, "{stopped:?}");
        }
    }
}

#[test]
fn min_step_is_a_floor() {
    for method in PAIRS.iter() {
        let run = solve(pole, [1.0, 1.0], 0.0..2.0).with(method.clone()).min_step(1e-4).every_step();
        let stopped = run.run().expect_err(method.name());
        assert!(matches!(stopped.why, Why::StepTooSmall { .. }), "{}: {stopped}", method.name());
        assert!(stopped.h < 1e-4, "the step that was asked for: {}", stopped.h);
        assert!(stopped.t < 1.0, "{}: {stopped}", method.name());
        let least = stopped.solution.ts.windows(2).map(|t| t[1] - t[0]).fold(1.0, f64::min);
        assert!(least >= 1e-4 * (1.0 - 1e-9), "{}: a step of {least:e}", method.name());
    }
    // A first step from Hairer's rule is lifted to the floor, and steps of exactly that size are allowed.
    let flat = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 0.0;
    let s = solve(flat, [1.0], 0.0..1.0).min_step(0.125).max_step(0.125).run().unwrap();
    assert_eq!(s.stats.accepted, 8);
    // The cause of the last rejection is kept.
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if t > 0.5 { f64::NAN } else { 1.0 };
    let stopped = solve(f, [1.0], 0.0..1.0).min_step(1e-3).run().unwrap_err();
    assert!(
        matches!(stopped.why, Why::NonFinite { component: 0, .. } | Why::Jacobian { component: 0 }),
        "{stopped}"
    );
    // Limits that exclude each other are refused.
    let stopped = solve(flat, [1.0], 0.0..1.0).min_step(0.5).max_step(0.1).run().unwrap_err();
    assert!(matches!(stopped.why, Why::Invalid(_)), "{stopped}");
}

#[test]
fn max_step_is_a_ceiling() {
    let f = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0];
    for (span, most) in [(0.0..1.0, 0.1), (0.0..-1.0, 0.03), (0.0..10.0, 1.0 / 3.0)] {
        for late in [false, true] {
            let s = solve(f, [1.0], span.clone())
                .rtol(1e-2)
                .max_step(most)
                .late(late)
                .every_step()
                .run()
                .unwrap();
            let sizes = s.ts.windows(2).map(|t| (t[1] - t[0]).abs());
            // The difference of two times is rounded.
            let largest = sizes.fold(0.0, f64::max);
            assert!(largest <= most * (1.0 + 1e-12) && largest > 0.9 * most, "{largest} of {most}, {late}");
        }
    }
}

#[test]
fn max_steps_counts_attempts() {
    for most in [0, 1, 7, 30] {
        let stopped = solve(pole, [1.0, 1.0], 0.0..2.0).max_steps(most).run().unwrap_err();
        let stats = stopped.solution.stats;
        assert_eq!(stopped.why, Why::TooManySteps { attempts: most });
        assert_eq!(stats.accepted + stats.rejected.total(), most);
    }
}
