//! Spans of no length, of a few units in the last place, backwards, long; steps that divide them.

use crate::{EVERY, PAIRS, pair, uncalled};
use kutta::methods::{Ab4, Rk4, VelocityVerlet};
use kutta::{Method, solve, solve_second};

fn decay(_: f64, y: &[f64; 1], dy: &mut [f64; 1]) {
    dy[0] = -y[0];
}

#[test]
fn a_span_of_no_length_gives_the_start_back() {
    let f = uncalled;
    for t0 in [0.0, 2.5, -1e9] {
        let adaptive = || solve(f, [7.0], t0..t0);
        let solutions = [
            adaptive().run().unwrap(),
            adaptive().at(&[t0]).run().unwrap(),
            adaptive().every_step().run().unwrap(),
            adaptive().breaks(&[t0]).record(Default::default(), |_, y| y[0] - 7.0).run().unwrap(),
            adaptive().with(Rk4).step(0.1).run().unwrap(),
            adaptive().with(Ab4).step(0.1).at(&[t0]).run().unwrap(),
            solve_second(f, [7.0], [1.0], t0..t0).step(0.1).run().unwrap(),
        ];
        for (s, saved) in solutions.iter().zip([0, 1, 1, 0, 0, 1, 0]) {
            assert_eq!((s.t, s.y, s.stats.accepted, s.stats.evaluations), (t0, [7.0], 0, 0));
            assert_eq!((&s.ts, &s.ys), (&vec![t0; saved], &vec![[7.0]; saved]));
        }
        assert_eq!(solutions[6].v, Some([1.0]));
        assert_eq!(adaptive().steps().count(), 0);
    }
}

#[test]
fn a_span_of_a_few_spacings_is_crossed() {
    for method in PAIRS.iter() {
        for t0 in [1.0, -1.0, 1e9, 0.3] {
            for (n, forward) in [(1, true), (2, true), (5, false), (40, true)] {
                let t1 = (0..n).fold(t0, |t: f64, _| if forward { t.next_up() } else { t.next_down() });
                let s = solve(decay, [1.0], t0..t1)
                    .with(method.clone())
                    .run()
                    .unwrap_or_else(|e| panic!("{}: {e}", method.name()));
                assert_eq!(s.t, t1);
                assert!((s.y[0] - (t0 - t1).exp()).abs() < 1e-15, "{}", method.name());
            }
        }
    }
}

/// The same problem in units of time from 2^-900 to 2^900: powers of two scale without rounding, so that
/// all steps and the result must be the same to the last bit.
#[test]
fn units_of_time_do_not_matter() {
    for method in EVERY.iter() {
        let run = |unit: f64| {
            let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
                *dy = [y[1] / unit, (-y[0] + 0.1 * (t / unit).cos()) / unit];
            };
            // Hairer's rule for the first step knows units, the loop must not.
            let run = solve(f, [1.0, 0.5], 0.0..5.0 * unit).with(method.clone()).rtol(1e-7);
            run.first_step(0.01 * unit).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()))
        };
        let one = run(1.0);
        assert!(one.stats.accepted > 5);
        for exponent in [-900, -700, -300, 300, 900] {
            let other = run(2f64.powi(exponent));
            assert_eq!((one.y, one.stats), (other.y, other.stats), "{}, 2^{exponent}", method.name());
        }
    }
    // Single precision has units of 2^-149 to 2^127.
    for exponent in [-100, -60, 60, 100] {
        let run = |unit: f32| {
            let f = |_: f32, y: &[f32; 2], dy: &mut [f32; 2]| *dy = [y[1] / unit, -y[0] / unit];
            let run = solve(f, [1.0, 0.5], 0.0..5.0 * unit).rtol(1e-4).atol(1e-6);
            run.first_step(0.01 * unit).run().unwrap()
        };
        let (one, other) = (run(1.0), run(2f32.powi(exponent)));
        assert_eq!((one.y, one.stats), (other.y, other.stats), "2^{exponent}");
    }
}

/// y0 = t/(t + 10), y1 = 10 t/(t + 10)^2, from 5 to 9 and back to 1: SciPy's problem, and its bound.
#[test]
fn backwards_is_as_good_as_forwards() {
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        *dy = [y[1] / t, y[1] * (y[0] + 2.0 * y[1] - 1.0) / (t * (y[0] - 1.0))];
    };
    let exact = |t: f64| [t / (t + 10.0), 10.0 * t / (t + 10.0).powi(2)];
    for method in PAIRS.iter() {
        let errors = [9.0, 1.0].map(|t1| {
            let run = solve(f, exact(5.0), 5.0..t1).with(method.clone()).rtol(1e-3).atol(1e-6).every_step();
            let s = run.run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
            assert_eq!((s.t, s.ts[0], s.ts.last()), (t1, 5.0, Some(&t1)));
            assert!(s.ts.is_sorted() == (t1 > 5.0) && s.ts.is_sorted_by(|a, b| a > b) == (t1 < 5.0));
            let ratio = |(y, e): (&f64, f64)| (y - e).abs() / (1e-6 + 1e-3 * e.abs());
            let worst = |(t, y): (&f64, &[f64; 2])| y.iter().zip(exact(*t)).map(ratio).fold(0.0, f64::max);
            s.ts.iter().zip(&s.ys).map(worst).fold(0.0, f64::max)
        });
        assert!(errors.iter().all(|&e| e < 5.0), "{}: {errors:?}", method.name());
    }
    // There and back again.
    let there = solve(f, exact(5.0), 5.0..9.0).rtol(1e-10).atol(1e-10).run().unwrap();
    let back = solve(f, there.y, 9.0..5.0).rtol(1e-10).atol(1e-10).run().unwrap();
    assert!((back.y[0] - exact(5.0)[0]).abs() < 1e-9);
}

#[test]
fn fixed_steps_divide_the_span() {
    for span in [1.0, 0.3, 10.0, 1e-3, 7.0, 1e6] {
        for n in (1..40).chain([100, 999, 1000]) {
            // As a user would write it, and as it comes out of a sum of rounded numbers.
            for h in [span / n as f64, span / n as f64 * (1.0 + 3e-16), span / n as f64 * (1.0 - 4e-16)] {
                for (t0, t1) in [(0.0, span), (2.0, 2.0 + span), (0.0, -span)] {
                    let s = solve(decay, [0.0], t0..t1).with(Rk4).step(h).every_step().run().unwrap();
                    assert_eq!((s.stats.accepted, s.t, s.ts.last()), (n, t1, Some(&t1)), "{span}/{n}");
                    for (i, &t) in s.ts.iter().enumerate() {
                        let exact = t0 + (t1 - t0) * (i as f64 / n as f64);
                        assert!((t - exact).abs() <= 4.0 * f64::EPSILON * (t0.abs() + span), "{t} {exact}");
                    }
                }
            }
        }
    }
    // Where it does not divide, the nearest count is taken: 2.5 and 0.4 steps.
    for (h, n) in [(0.4, 3), (0.41, 2), (2.5, 1), (1.0, 1)] {
        let s = solve(decay, [1.0], 0.0..1.0).with(Rk4).step(h).run().unwrap();
        assert_eq!((s.stats.accepted, s.t), (n, 1.0));
    }
}

/// At t = 1e9 times are 1.2e-7 apart: a thousand steps, each off by half of that, would shift the result in
/// its sixth digit if what rounding takes from t were not kept.
#[test]
fn steps_are_not_lost_to_the_rounding_of_late_times() {
    for t0 in [1e6, 1e9, -1e9, 1e12] {
        for direction in [1.0, -1.0] {
            let f = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -direction * y[0];
            let run = solve(f, [1.0], t0..t0 + 2.0 * direction).rtol(1e-11).atol(1e-11).max_step(0.01);
            let s = run.run().unwrap();
            assert!((s.y[0] - (-2f64).exp()).abs() < 1e-10, "{t0:e}: {:e}", s.y[0] - (-2f64).exp());
            let s = solve(f, [1.0], t0..t0 + 2.0 * direction).with(Rk4).step(0.01).run().unwrap();
            assert!((s.y[0] - (-2f64).exp()).abs() < 1e-10, "{t0:e}: {:e}", s.y[0] - (-2f64).exp());
        }
    }
    // In single precision 0.001 is lost by a hundredth at t = 100.
    let f = |_: f32, _: &[f32; 1], dy: &mut [f32; 1]| dy[0] = 0.0;
    let s = solve(f, [1.0], 0f32..100.0).max_step(1e-3).run().unwrap();
    assert!((100_000..100_010).contains(&s.stats.accepted), "{}", s.stats.accepted);
}

/// Ten thousand periods: what the tolerance allows adds up, and nothing beside it.
#[test]
fn long_runs() {
    let f = |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -y[0]];
    let t1 = 6e4;
    let s = solve(f, [0.0, 1.0], 0.0..t1).with(pair("dop853")).rtol(1e-12).atol(1e-12).run().unwrap();
    let error = (s.y[0] - t1.sin()).hypot(s.y[1] - t1.cos());
    // Local errors of at most 1e-12 in each of the steps, all in the same direction at worst.
    assert!(error < 1e-12 * s.stats.accepted as f64, "{error:e} after {} steps", s.stats.accepted);
    // The leapfrog's energy swings by h^2/8 and does not drift.
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let s = solve_second(a, [0.0], [1.0], 0.0..t1).with(VelocityVerlet).step(0.1).run().unwrap();
    let energy = s.y[0].powi(2) + s.v.unwrap()[0].powi(2);
    assert!((energy - 1.0).abs() < 0.01 / 4.0, "{energy}");
}

/// f is never asked for a time outside the span, not even by one unit in the last place.
#[test]
fn f_is_not_called_outside_the_span() {
    for method in PAIRS.iter() {
        for (t0, t1) in [(0.1, 0.7), (1.0 / 3.0, 2.0 / 3.0), (0.7, 0.1), (-0.3, 1.1), (1e9, 1e9 + 0.1)] {
            let (low, high) = (f64::min(t0, t1), f64::max(t0, t1));
            let check = |t: f64| assert!(low <= t && t <= high, "{}: {t:?} of {t0} .. {t1}", method.name());
            let f = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
                check(t);
                dy[0] = -y[0] * (3.0 * t).cos();
            };
            let run = solve(f, [1.0], t0..t1).with(method.clone()).rtol(1e-4);
            run.at(&[t0 + 0.99 * (t1 - t0)]).run().unwrap();
            for n in 1..20 {
                let run = solve(f, [1.0], t0..t1).with(method.clone()).step((high - low) / n as f64);
                run.at(&[t0 + 0.99 * (t1 - t0)]).run().unwrap();
            }
        }
    }
}
