//! Sizes of states and slopes: huge, tiny, zero, mixed.

use crate::{EVERY, PAIRS, uncalled};
use kutta::methods::Dp54;
use kutta::{Method, solve};

/// A linear system in units from 2^-900 to 2^900: powers of two scale without rounding, so that all steps
/// and the result must be the same to the last bit.
#[test]
fn units_of_y_do_not_matter() {
    for method in EVERY.iter() {
        let run = |unit: f64| {
            let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -y[0] + 0.1 * unit * t.cos()];
            let run = solve(f, [unit, 0.5 * unit], 0.0..5.0).with(method.clone());
            run.rtol(1e-7).atol(1e-9 * unit).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()))
        };
        let one = run(1.0);
        for exponent in [-900, -660, 660, 900] {
            let unit = 2f64.powi(exponent);
            let other = run(unit);
            let same = one.y.map(|y| y * unit) == other.y && one.stats == other.stats;
            assert!(same, "{}, 2^{exponent}: {:?} {:?}", method.name(), one, other);
        }
    }
}

#[test]
fn components_of_every_size_have_their_own_tolerance() {
    let f = |_: f64, y: &[f64; 4], dy: &mut [f64; 4]| *dy = [-y[0], -2.0 * y[1], -3.0 * y[2], y[3]];
    let y0 = [1e200, 1e-200, 1.0, 1e-9];
    for method in EVERY.iter() {
        let each = y0.map(|y| (1e-8, y * 1e-8)).to_vec();
        let s = solve(f, y0, 0.0..1.0)
            .with(method.clone())
            .tolerances(each)
            .run()
            .unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        for (i, rate) in [-1f64, -2.0, -3.0, 1.0].into_iter().enumerate() {
            let relative = (s.y[i] / y0[i] / rate.exp() - 1.0).abs();
            // Local errors of at most twice 1e-8 of the larger y, e^3 of the smallest at the end: ten or so, or some
            // hundred of a pair of order two.
            assert!(relative < 3e-5, "{}, component {i}: {relative:e}", method.name());
        }
    }
    // A component without a tolerance of its own is not followed, and does not hold the others up.
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-y[0], 1e3 * (1e3 * t).sin()];
    let steps = |atol: f64| {
        let run = solve(f, [1.0, 0.0], 0.0..1.0).tolerances(vec![(1e-6, 1e-6), (0.0, atol)]);
        run.run().unwrap().stats.accepted
    };
    assert!(steps(1e9) < 20 && steps(1e-6) > 200, "{} {}", steps(1e9), steps(1e-6));
}

#[test]
fn a_zero_state_needs_no_absolute_tolerance() {
    for method in EVERY.iter() {
        // Zero and stays zero, beside a component that moves; in a span so long that steps grow large.
        let f = |_: f64, y: &[f64; 3], dy: &mut [f64; 3]| *dy = [0.0, y[1], -0.01 * y[2]];
        let run = solve(f, [0.0, 0.0, 1.0], 0.0..1e4).with(method.clone()).rtol(1e-6).atol(0.0);
        let s = run.run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        assert_eq!((s.y[0], s.y[1]), (0.0, 0.0), "{}", method.name());
        // All zero.
        let f = |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -y[0]];
        let s = solve(f, [0.0; 2], 0.0..1e4).with(method.clone()).rtol(1e-6).atol(0.0).run().unwrap();
        assert!(s.y == [0.0; 2] && s.stats.accepted < 40, "{}: {:?}", method.name(), s.stats);
        // Zero at the start only.
        let s = solve(f, [0.0, 1.0], 0.0..1.0).with(method.clone()).rtol(1e-6).atol(0.0).run().unwrap();
        assert!((s.y[0] - 1f64.sin()).abs() < 1e-4, "{}", method.name());
    }
    let f = |_: f32, y: &[f32; 2], dy: &mut [f32; 2]| *dy = [0.0, -0.01 * y[1]];
    let s = solve(f, [0.0, 1.0], 0f32..1e3).with(Dp54).rtol(1e-4).atol(0.0).run().unwrap();
    assert_eq!(s.y[0], 0.0);
}

/// A tolerance of zero throughout says nothing, and one that is no number neither.
#[test]
fn senseless_tolerances_are_refused() {
    let f = uncalled;
    for (rtol, atol) in [(0.0, 0.0), (-1e-6, 1e-6), (1e-6, -1e-9), (f64::NAN, 1.0), (1e-3, f64::INFINITY)] {
        assert!(solve(f, [1.0; 2], 0.0..1.0).rtol(rtol).atol(atol).run().is_err(), "{rtol} {atol}");
        let each = vec![(1e-6, 1e-6), (rtol, atol)];
        assert!(solve(f, [1.0; 2], 0.0..1.0).tolerances(each).run().is_err(), "{rtol} {atol}");
    }
    assert!(solve(f, [1.0; 2], 0.0..1.0).tolerances(vec![(1e-6, 1e-6)]).run().is_err());
}

/// Hairer's first step has a rule for each of: no slope, a constant one, a huge one, a state of zero.
#[test]
fn first_steps_of_flat_and_steep_problems() {
    for method in PAIRS.iter() {
        for slope in [0.0, 1.0, 1e-12, 1e12, 1e100, 1e280] {
            for y0 in [0.0, 1.0, 1e6] {
                let f = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = slope;
                let s = solve(f, [y0], 0.0..2.0)
                    .with(method.clone())
                    .run()
                    .unwrap_or_else(|e| panic!("{}: {e}", method.name()));
                let exact = y0 + 2.0 * slope;
                assert!((s.y[0] - exact).abs() <= 1e-13 * exact.abs(), "{}, {slope}", method.name());
                // Growing five- to tenfold a step from 1e-6, or from the y0/slope of a steep one.
                let most = 20.0 + 2.0 * f64::max(0.0, slope.log10());
                assert!((s.stats.accepted as f64) < most, "{}, {slope}: {:?}", method.name(), s.stats);
                assert!(s.stats.rejected.total() < 5, "{}, {slope}: {:?}", method.name(), s.stats);
            }
        }
        // Fast decay, resolved: y' = -1.3e12 y over five of its times.
        let f = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -1.3e12 * y[0];
        let s = solve(f, [1.0], 0.0..5e-12 / 1.3)
            .with(method.clone())
            .run()
            .unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        assert!((s.y[0] - (-5f64).exp()).abs() < 1e-5, "{}: {}", method.name(), s.y[0]);
    }
}

/// After steps without any error the next real error is met without a jolt: the memory of the controller
/// does not take a zero for a measure.
#[test]
fn a_zero_error_leaves_no_mark() {
    // y = 0 until t = 1, then y = (t - 1)^9 / 9! smoothly.
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = f64::max(t - 1.0, 0.0).powi(8);
    for method in PAIRS.iter() {
        let run = solve(f, [0.0], 0.0..3.0).with(method.clone()).max_step(0.125).rtol(1e-2).atol(1e-2);
        let s = run.every_step().run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        let sizes: Vec<f64> = s.ts.windows(2).map(|t| t[1] - t[0]).collect();
        let settled = sizes.iter().position(|&h| h > 0.12).expect("steps grow to the largest");
        // At a tolerance of 1e-2 the start of the rise asks for no smaller steps.
        let after = sizes[settled..].iter().zip(&s.ts[settled + 1..]).filter(|(_, t)| **t < 1.9);
        for (h, t) in after {
            assert!(*h > 0.06, "{}: a step of {h} to {t}", method.name());
        }
    }
}
