//! A right-hand side that refuses points: roots of negative numbers, densities below zero.

use crate::{PAIRS, pair};
use kutta::methods::{Ab4, Rk4};
use kutta::{Ivp, Method, OutOfDomain, System, Why, solve};

/// y' = -2 sqrt(y), so y = (1 - t)^2.
struct Draining {
    refused: u64,
}

impl System<[f64; 1]> for Draining {
    fn rhs(&mut self, _t: f64, y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
        if y[0] < 0.0 {
            self.refused += 1;
            return Err(OutOfDomain);
        }
        dy[0] = -2.0 * y[0].sqrt();
        Ok(())
    }
}

#[test]
fn a_refused_step_is_retried_smaller() {
    let mut refused = 0;
    for method in PAIRS.iter() {
        // Most tables have a stage below zero in a first step as long as the span.
        let run = Ivp::new(Draining { refused: 0 }, [1.0], 0.0..0.99).with(method.clone());
        let s = run
            .first_step(0.99)
            .rtol(1e-8)
            .atol(1e-12)
            .run()
            .unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        refused += u64::from(s.stats.rejected.domain > 0);
        // An error at y = 1 grows as 1/sqrt(y) shrinks, by (1 - t) relative to y itself: it does not grow.
        assert!((s.y[0] - 1e-4).abs() < 1e-7, "{}: {:e}", method.name(), s.y[0] - 1e-4);
    }
    assert!(refused > 10, "only {refused} methods met the edge");
}

#[test]
fn where_no_step_is_small_enough_the_error_says_so() {
    for method in PAIRS.iter() {
        let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| {
            dy[0] = 1.0;
            if t > 0.6 { Err(OutOfDomain) } else { Ok(()) }
        };
        let stopped = solve(f, [0.0], 0.0..1.0).with(method.clone()).run().unwrap_err();
        let Why::OutOfDomain { stage } = stopped.why else { panic!("{}: {stopped}", method.name()) };
        assert!(stage < method.form().s, "{}: {stage}", method.name());
        assert!(stopped.t <= 0.6 && stopped.t > 0.6 - 1e-14, "{}: {stopped}", method.name());
        assert!((stopped.solution.y[0] - stopped.t).abs() < 1e-14);
        assert!(stopped.solution.stats.rejected.domain > 10);
    }
}

#[test]
fn a_refused_start_ends_the_run_at_once() {
    let f = |_: f64, _: &[f64; 1], _: &mut [f64; 1]| Err(OutOfDomain);
    let stopped = [
        solve(f, [1.0], 3.0..4.0).run().unwrap_err(),
        solve(f, [1.0], 3.0..4.0).with(pair("dop853")).run().unwrap_err(),
        solve(f, [1.0], 3.0..4.0).with(Rk4).step(0.1).run().unwrap_err(),
        solve(f, [1.0], 3.0..4.0).with(Ab4).step(0.1).run().unwrap_err(),
    ];
    for stopped in stopped {
        assert_eq!((&stopped.why, stopped.t), (&Why::OutOfDomain { stage: 0 }, 3.0), "{stopped}");
        assert_eq!(stopped.solution.y, [1.0]);
    }
}

#[test]
fn a_fixed_step_cannot_be_retried() {
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| {
        dy[0] = 2.0;
        if t > 0.52 { Err(OutOfDomain) } else { Ok(()) }
    };
    let stopped = solve(f, [0.0], 0.0..1.0).with(Rk4).step(0.1).run().unwrap_err();
    assert_eq!((&stopped.why, stopped.t, stopped.h), (&Why::OutOfDomain { stage: 1 }, 0.5, 0.1));
    assert_eq!(stopped.solution.stats.rejected.domain, 1);
    assert!((stopped.solution.y[0] - 1.0).abs() < 1e-15);
}

/// One step of each kind is spoiled: each cause has its own count, and evaluations are counted as made.
#[test]
fn rejections_are_counted_by_cause() {
    for name in ["tsit54", "dop853", "rkf45"] {
        let mut calls = 0;
        let f = |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
            *dy = [y[1], -y[0]];
            calls += 1;
            match calls {
                20 => dy[0] = f64::NAN,
                40 => return Err(OutOfDomain),
                60 => dy[1] = 1e3,
                _ => {}
            }
            Ok(())
        };
        let s = solve(f, [0.0, 1.0], 0.0..12.0).with(pair(name)).rtol(1e-6).atol(1e-6).run().unwrap();
        assert_eq!((s.stats.rejected.non_finite, s.stats.rejected.domain), (1, 1), "{name}: {:?}", s.stats);
        assert!(s.stats.rejected.error >= 1, "{name}: {:?}", s.stats);
        assert_eq!(s.stats.evaluations, calls, "{name}");
        assert_eq!(s.stats.rejected.total(), 2 + s.stats.rejected.error);
    }
}
