//! A NaN or an infinity in the start, in the first slope, in one component, in one stage, or later.

use crate::{EVERY, PAIRS, pair, uncalled};
use kutta::methods::{Ab4, Dop853, Rk4, Tsit54, VelocityVerlet};
use kutta::{Loaded, Method, Why, solve, solve_second};

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn message(why: &Why) -> String {
    match why {
        Why::Invalid(text) => text.clone(),
        other => panic!("not refused as invalid: {other:?}"),
    }
}

#[test]
fn a_bad_start_is_refused_before_f_is_called() {
    for bad in BAD {
        let f = uncalled;
        let adaptive = solve(f, [1.0, bad, bad], 0.0..1.0).run().unwrap_err();
        let fixed = solve(f, [1.0, bad, bad], 0.0..1.0).with(Rk4).step(0.1).run().unwrap_err();
        for stopped in [adaptive, fixed] {
            assert!(message(&stopped.why).contains("component 1 of y0"), "{stopped}");
            assert_eq!((stopped.t, stopped.solution.stats.evaluations), (0.0, 0));
        }
        let second = solve_second(f, [1.0; 3], [0.0, 0.0, bad], 0.0..1.0).with(VelocityVerlet).step(0.1);
        assert!(message(&second.run().unwrap_err().why).contains("component 2 of v0"));
        for span in [bad..1.0, 0.0..bad] {
            let stopped = solve(f, [1.0; 3], span).run().unwrap_err();
            assert!(message(&stopped.why).contains("span"), "{stopped}");
        }
    }
}

#[test]
fn a_bad_first_slope_is_named_before_the_first_step() {
    for bad in BAD {
        let f = |_: f64, y: &[f64; 3], dy: &mut [f64; 3]| *dy = [y[0], bad, y[2]];
        // With the slope carried and without.
        let stopped = [
            solve(f, [1.0; 3], 2.0..3.0).with(Tsit54).run().unwrap_err(),
            solve(f, [1.0; 3], 2.0..3.0).with(Dop853).run().unwrap_err(),
            solve(f, [1.0; 3], 2.0..3.0).with(Rk4).step(0.1).run().unwrap_err(),
            solve(f, [1.0; 3], 2.0..3.0).with(Ab4).step(0.1).run().unwrap_err(),
        ];
        for stopped in stopped {
            assert_eq!(stopped.why, Why::NonFinite { component: 1, stage: Some(0) }, "{stopped}");
            assert_eq!((stopped.t, stopped.solution.t, stopped.solution.y), (2.0, 2.0, [1.0; 3]));
            assert_eq!(stopped.solution.stats.accepted, 0);
        }
    }
}

/// y' = 1 until t = 0.3, and from there a NaN or an infinity in one component of a hundred.
#[test]
fn a_slope_that_turns_bad_ends_the_run_where_it_does() {
    // A method that looks at no end of a step passes the point by as much as its last stage stands before it.
    let looks = |m: &&Loaded| m.form().c[..m.form().s].iter().any(|c| c.hi() == 1.0);
    for method in EVERY.iter().filter(looks) {
        for bad in BAD {
            let f = |t: f64, _: &Vec<f64>, dy: &mut Vec<f64>| {
                dy.fill(1.0);
                if t > 0.3 {
                    dy[57] = bad;
                }
            };
            let stopped = solve(f, vec![0.0; 100], 0.0..1.0).with(method.clone()).run().unwrap_err();
            let name = method.name();
            let Why::NonFinite { component: 57, stage: Some(_) } = stopped.why else {
                panic!("{name}, {bad}: {stopped}");
            };
            assert!(stopped.t <= 0.3 && stopped.t > 0.3 - 1e-14, "{name}, {bad}: {stopped}");
            assert!(stopped.h > 0.0 && stopped.h < 1e-14, "{name}, {bad}: h = {}", stopped.h);
            let solution = stopped.solution;
            assert_eq!(solution.t, stopped.t);
            // The rounding of some hundred sums.
            assert!(solution.y.iter().all(|y| (y - solution.t).abs() < 1e-14), "{name}, {bad}");
            assert!(solution.stats.rejected.non_finite > 10, "{name}: {:?}", solution.stats);
            assert_eq!(solution.stats.rejected.domain, 0, "{name}");
        }
    }
}

/// A single bad answer, whichever stage it falls to, costs one rejected step and nothing else.
#[test]
fn one_bad_stage_is_stepped_again() {
    for name in ["tsit54", "dop853", "rkf45", "verner76-efficient"] {
        let (mut whole, mut hits) = (0, 0);
        // Call 0 is f(t0), call 1 the probe for the first step.
        for bad_call in 1..60 {
            for bad in BAD {
                let mut call = 0;
                let f = |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
                    *dy = [y[1], -y[0]];
                    if call == bad_call {
                        dy[1] = bad;
                    }
                    call += 1;
                };
                let run = solve(f, [0.0, 1.0], 0.0..3.0).with(pair(name)).rtol(1e-8).atol(1e-8);
                let s = run.run().unwrap_or_else(|stopped| panic!("{name}, call {bad_call}: {stopped}"));
                // Twenty local errors of at most 1e-8 that do not grow.
                let error = (s.y[0] - 3f64.sin()).abs().max((s.y[1] - 3f64.cos()).abs());
                assert!(error < 2e-7, "{name}, call {bad_call}: {error:e}");
                let rejected = s.stats.rejected;
                assert!(rejected.non_finite <= 1 && rejected.domain == 0, "{name}: {rejected:?}");
                hits += rejected.non_finite;
                whole += 1;
            }
        }
        assert!(hits > whole / 2, "{name}: only {hits} of {whole} bad answers were in a step");
    }
}

/// f is finite at every point, but y grows beyond the numbers: no infinity may pass for a state.
#[test]
fn a_state_that_overflows_is_no_solution() {
    for method in PAIRS.iter() {
        // From 1.79e308 the largest number, 1.797693e308, is reached at t = 7.693.
        let f = |_: f64, _: &[f64; 2], dy: &mut [f64; 2]| *dy = [1e305, 1.0];
        let stopped = solve(f, [1.79e308, 0.0], 0.0..20.0).with(method.clone()).max_steps(10_000).run();
        let stopped = stopped.expect_err(method.name());
        assert!(stopped.solution.y.iter().all(|y| y.is_finite()), "{}: {stopped}", method.name());
        assert!(stopped.t > 7.69 && stopped.t < 7.7, "{}: {stopped}", method.name());
        // Or it creeps on below the largest number, in steps that are rounded away.
        let why = matches!(stopped.why, Why::NonFinite { component: 0, .. } | Why::TooManySteps { .. });
        assert!(why, "{}: {stopped}", method.name());
    }
}

#[test]
fn a_fixed_step_stops_at_the_first_bad_number() {
    // The third stage of rk4 is at the middle of the step; the step from 0.4 to 0.5 sees it first.
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[0], if t > 0.42 { f64::NAN } else { 1.0 }];
    let stopped = solve(f, [1.0, 0.0], 0.0..1.0).with(Rk4).step(0.1).every_step().run().unwrap_err();
    assert_eq!(stopped.why, Why::NonFinite { component: 1, stage: Some(1) });
    assert_eq!((stopped.solution.stats.accepted, stopped.solution.stats.rejected.non_finite), (4, 1));
    assert_eq!((stopped.h, stopped.t), (0.1, 0.4));
    assert_eq!(stopped.solution.ts, [0.0, 0.1, 0.2, 0.30000000000000004, 0.4]);
    assert!((stopped.solution.y[1] - 0.4).abs() < 1e-15);
    // In the starting steps of a multistep method too.
    let stopped = solve(f, [1.0, 0.0], 0.4..1.0).with(Ab4).step(0.1).run().unwrap_err();
    assert_eq!(stopped.why, Why::NonFinite { component: 1, stage: Some(1) });
    assert_eq!((stopped.t, stopped.solution.stats.rejected.non_finite), (0.4, 1));
}
