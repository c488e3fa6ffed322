//! Roots of functions of the solution: where, how many, in which order, and what happens there.

use kutta::methods::{Ab4, Adams, Bdf, Dop853, Euler, Rk4, Tsit54, VelocityVerlet, Verlet};
use kutta::{Crossing, Ivp, Occurrence, Solution, Why, solve, solve_second};
use std::f64::consts::PI;

type Y = [f64; 2];

/// y = (sin t, cos t).
fn circle(_: f64, y: &Y, dy: &mut Y) {
    *dy = [y[1], -y[0]];
}

fn on_circle<'w>(t0: f64, t1: f64) -> Ivp<'w, Y, fn(f64, &Y, &mut Y)> {
    let f: fn(f64, &Y, &mut Y) = circle;
    solve(f, [t0.sin(), t0.cos()], t0..t1).rtol(1e-11).atol(1e-11)
}

fn times<T: kutta::State<Scalar = f64>>(events: &[Occurrence<T>]) -> Vec<f64> {
    events.iter().map(|e| e.t).collect()
}

/// The tolerance of the runs leaves phases off by 1e-10 a turn.
fn assert_times(found: &[f64], wanted: &[f64], what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}: {found:?}, not {wanted:?}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < 2e-9, "{what}: {found}, not {wanted}");
    }
}

#[test]
fn roots_are_found_in_both_directions_of_time() {
    let roots = |crossing, t0: f64, t1: f64| {
        times(&on_circle(t0, t1).record(crossing, |_, y| y[0]).run().unwrap().events)
    };
    assert_times(&roots(Crossing::Any, 0.5, 10.0), &[PI, 2.0 * PI, 3.0 * PI], "any");
    assert_times(&roots(Crossing::Rising, 0.5, 10.0), &[2.0 * PI], "rising");
    assert_times(&roots(Crossing::Falling, 0.5, 10.0), &[PI, 3.0 * PI], "falling");
    // Backwards the sine falls where it rises forwards.
    assert_times(&roots(Crossing::Any, 10.0, 0.5), &[3.0 * PI, 2.0 * PI, PI], "any, backwards");
    assert_times(&roots(Crossing::Rising, 10.0, 0.5), &[3.0 * PI, PI], "rising, backwards");
    assert_times(&roots(Crossing::Falling, 10.0, 0.5), &[2.0 * PI], "falling, backwards");
}

#[test]
fn the_state_at_a_root_is_on_it() {
    for (t0, t1) in [(0.5, 20.0), (1e6 + 0.5, 1e6 + 20.0), (20.0, -0.1)] {
        let s = on_circle(t0, t1).record(Crossing::Any, |_, y| y[0] - 0.3).run().unwrap();
        assert!(s.events.len() >= 6);
        for e in &s.events {
            // The slope there is 0.95: g is as near to zero as the spacing of times, and of y, allows.
            let spacing = 4.0 * f64::EPSILON * (1.0 + e.t.abs());
            assert!((e.y[0] - 0.3).abs() <= spacing, "{:e} at {}", e.y[0] - 0.3, e.t);
            assert!((e.y[1].abs() - 0.91f64.sqrt()).abs() < 1e-9);
        }
    }
}

/// The interpolants of every kind: a table's own, Hermite for pairs, for fixed steps, for multistep methods
/// and during their start, for second-order equations.
#[test]
fn every_family_finds_roots() {
    let wanted = [PI, 2.0 * PI, 3.0 * PI];
    let g = |_: f64, y: &Y| y[0];
    let of = |s: Solution<Y>| times(&s.events);
    assert_times(
        &of(on_circle(0.5, 10.0).with(Tsit54).record(Crossing::Any, g).run().unwrap()),
        &wanted,
        "Tsit54",
    );
    assert_times(
        &of(on_circle(0.5, 10.0).with(Dop853).record(Crossing::Any, g).run().unwrap()),
        &wanted,
        "Dop853",
    );
    // The phase of a formula of order 5 or less drifts by more than a pair's: some hundred tolerances.
    let family = |s: Solution<Y>| close_to(&of(s), &wanted, 1e-7);
    family(on_circle(0.5, 10.0).with(Adams).record(Crossing::Any, g).run().unwrap());
    family(on_circle(0.5, 10.0).with(Bdf).record(Crossing::Any, g).run().unwrap());
    let fixed = || on_circle(0.5, 10.0).step(1e-2).record(Crossing::Any, g);
    // Errors of fixed steps: h^4 times a constant below 1 for each unit of time.
    let close = |found: Vec<f64>, tolerance: f64| {
        assert_eq!(found.len(), 3, "{found:?}");
        found.iter().zip(wanted).for_each(|(t, w)| assert!((t - w).abs() < tolerance, "{t} {w}"));
    };
    close(of(fixed().with(Rk4).run().unwrap()), 1e-8);
    close(of(fixed().with(Ab4).run().unwrap()), 1e-7);
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let second = || {
        let run = solve_second(a, [0.5f64.sin()], [0.5f64.cos()], 0.5..10.0).step(1e-3);
        run.record(Crossing::Any, |_, x| x[0])
    };
    // h^2/24 for each unit of time.
    close(times(&second().with(Verlet).run().unwrap().events), 1e-6);
    close(times(&second().with(VelocityVerlet).run().unwrap().events), 1e-6);
    // Within the three steps that start the multistep method.
    let run = solve(circle, [-0.01, 1.0], 0.0..1.0).with(Ab4).step(0.1).record(Crossing::Any, g);
    close_to(&times(&run.run().unwrap().events), &[0.01f64.atan()], 1e-6);
}

fn close_to(found: &[f64], wanted: &[f64], tolerance: f64) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    found.iter().zip(wanted).for_each(|(t, w)| assert!((t - w).abs() < tolerance, "{t} {w}"));
}

#[test]
fn a_root_at_the_start_is_not_one() {
    for (t0, t1) in [(0.0, 4.0), (PI, 0.5), (0.0, -4.0)] {
        for crossing in [Crossing::Any, Crossing::Rising, Crossing::Falling] {
            let s = on_circle(t0, t1).record(crossing, |t, _| t - t0).run().unwrap();
            assert!(s.events.is_empty(), "{:?}", times(&s.events));
        }
    }
    // But one soon after is: t (t - 0.001) from a first step of 1.
    let flat = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 0.0;
    for soon in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let g = |t: f64, _: &[f64; 1]| t * (t - soon);
        let s = solve(flat, [0.0], 0.0..2.0).first_step(1.0).record(Crossing::Any, g).run().unwrap();
        close_to(&times(&s.events), &[soon], 1e-15);
    }
}

/// Half-open steps (t, t + h]: a root exactly where two steps meet is found once, and at the end of the span.
#[test]
fn a_root_at_the_end_of_a_step_is_found_once() {
    // Euler's method follows a line without rounding.
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    for t1 in [0.5, 1.0, 2.0] {
        for (crossing, count) in [(Crossing::Any, 1), (Crossing::Rising, 1), (Crossing::Falling, 0)] {
            let run = solve(line, [-0.5], 0.0..t1).with(Euler).step(0.125).record(crossing, |_, y| y[0]);
            let s = run.run().unwrap();
            assert_eq!(s.events.len(), count, "{t1} {crossing:?}");
            assert!(s.events.iter().all(|e| e.t == 0.5 && e.y == [0.0]));
        }
        let run = solve(line, [0.5], 0.0..-t1).with(Euler).step(0.125).record(Crossing::Any, |_, y| y[0]);
        assert_eq!(times(&run.run().unwrap().events), [-0.5]);
        // At a point inside a step that is looked at.
        let run = solve(line, [-0.5], 0.0..t1).with(Euler).step(t1).record(Crossing::Any, |_, y| y[0]);
        assert_eq!(times(&run.run().unwrap().events), [0.5]);
    }
}

#[test]
fn several_roots_in_one_step_come_in_order() {
    // y = t in one step from 0 to 1; g has roots at 0.2, 0.45, 0.7 and h one at 0.5.
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    for (t0, t1) in [(0.0, 1.0), (1.0, 0.0)] {
        let run = solve(line, [t0], t0..t1).with(Euler).step(1.0);
        let run = run.record(Crossing::Any, |_, y| (y[0] - 0.2) * (y[0] - 0.45) * (y[0] - 0.7));
        let s = run.record(Crossing::Any, |_, y| 3.0 * (y[0] - 0.5)).run().unwrap();
        let mut wanted = [(0, 0.2), (0, 0.45), (1, 0.5), (0, 0.7)];
        if t1 < t0 {
            wanted.reverse();
        }
        assert_eq!(s.stats.accepted, 1);
        assert_eq!(
            s.events.iter().map(|e| e.event).collect::<Vec<_>>(),
            wanted.iter().map(|w| w.0).collect::<Vec<_>>()
        );
        close_to(&times(&s.events), &wanted.iter().map(|w| w.1).collect::<Vec<_>>(), 1e-14);
    }
    // SciPy's three crossings of which it missed two: sin(20 t) within long steps of y' = 1.
    let s =
        solve(line, [0.0], 0.0..1.0).with(Euler).step(0.5).record(Crossing::Any, |_, y| (20.0 * y[0]).sin());
    let wanted: Vec<f64> = (1..=6).map(|k| k as f64 * PI / 20.0).collect();
    close_to(&times(&s.run().unwrap().events), &wanted, 1e-14);
}

/// A double root changes no sign: the documentation says that it is missed, and a near miss is two roots.
#[test]
fn double_roots() {
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    let count = |lift: f64| {
        let run = solve(line, [0.0], 0.0..1.0).with(Rk4).step(0.25);
        run.record(Crossing::Any, |_, y| (y[0] - 0.53).powi(2) + lift).run().unwrap().events.len()
    };
    assert_eq!((count(1e-3), count(0.0), count(-0.01)), (0, 0, 2));
}

#[test]
fn a_terminal_event_ends_the_run_there() {
    let s = on_circle(0.5, 100.0).every_step().stop_at(Crossing::Rising, |_, y| y[0]).run().unwrap();
    assert_times(&[s.t], &[2.0 * PI], "stop");
    assert!(s.y[0].abs() < 1e-14 && (s.y[1] - 1.0).abs() < 1e-9);
    assert_eq!((s.ts.last(), s.ys.last(), s.events.len()), (Some(&s.t), Some(&s.y), 1));
    // What was asked for after it is not there; before it everything is, recorded roots too.
    let run = on_circle(0.5, 100.0).at(&[1.0, 6.0, 6.25, 6.3, 50.0]).record(Crossing::Any, |_, y| y[1]);
    let s = run.stop_at(Crossing::Rising, |_, y| y[0]).run().unwrap();
    assert_eq!(s.ts, [1.0, 6.0, 6.25]);
    assert_times(&times(&s.events), &[0.5 * PI, 1.5 * PI, 2.0 * PI], "before the stop");
    // Roots of the same step behind the one that stops are not recorded.
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    let run = solve(line, [0.0], 0.0..1.0).with(Euler).step(1.0).stop_at(Crossing::Any, |_, y| y[0] - 0.4);
    let s = run.record(Crossing::Any, |_, y| (y[0] - 0.3) * (y[0] - 0.6)).run().unwrap();
    close_to(&times(&s.events), &[0.3, 0.4], 1e-15);
    // With the velocity, for second-order equations.
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let run = solve_second(a, [0.0], [1.0], 0.0..100.0).with(VelocityVerlet).step(1e-3);
    let s = run.stop_at(Crossing::Falling, |_, x| x[0]).run().unwrap();
    // h^2/24 for each unit of time.
    assert!((s.t - PI).abs() < 1e-6 && (s.v.unwrap()[0] + 1.0).abs() < 1e-6);
}

/// A ball let fall from a height of 1 that keeps the share e of its speed at each bounce: it touches the
/// ground at T (1 + 2 e + 2 e^2 + ..), T = sqrt(2/g).
fn bounces<'w>(e: f64, t1: f64, crossing: Crossing) -> Ivp<'w, Y, impl FnMut(f64, &Y, &mut Y)> {
    let fall = |_: f64, y: &Y, dy: &mut Y| *dy = [y[1], -9.81];
    solve(fall, [1.0, 0.0], 0.0..t1).change_at(crossing, |_, y| y[0], move |_, y| y[1] *= -e)
}

fn touch_downs(e: f64, count: i32) -> Vec<f64> {
    let first = (2.0 / 9.81f64).sqrt();
    (0..count).map(|n| first * (1.0 + 2.0 * (e - e.powi(n + 1)) / (1.0 - e))).collect()
}

#[test]
fn a_bouncing_ball_follows_its_closed_form() {
    for e in [0.9, 0.5] {
        for crossing in [Crossing::Falling, Crossing::Any] {
            let wanted = touch_downs(e, 6);
            let t1 = 0.5 * (wanted[5] + touch_downs(e, 7)[6]);
            let s = bounces(e, t1, crossing).run().unwrap();
            // A parabola is followed without error by methods of order two and more.
            close_to(&times(&s.events), &wanted, 1e-12);
            for (n, event) in s.events.iter().enumerate() {
                let speed = (2.0 * 9.81f64).sqrt() * e.powi(n as i32);
                assert!((event.y[1] + speed).abs() < 1e-11, "before the change: {:?}", event.y);
            }
            let (since, speed) = (t1 - wanted[5], (2.0 * 9.81f64).sqrt() * e.powi(6));
            assert!((s.y[0] - (speed * since - 0.5 * 9.81 * since * since)).abs() < 1e-11);
        }
    }
}

/// The same ball as a second-order equation, where the velocity is not a part of the state.
#[test]
fn velocities_of_second_order_equations_can_be_changed() {
    let fall = |_: f64, _: &[f64; 1], a: &mut [f64; 1]| a[0] = -9.81;
    let (e, wanted) = (0.8, touch_downs(0.8, 6));
    let run = || {
        let run = solve_second(fall, [1.0], [0.0], 0.0..wanted[5] + 0.01).step(0.01);
        run.change_motion_at(Crossing::Falling, |_, x| x[0], |_, _, v| v[0] *= -e)
    };
    let speed = (2.0 * 9.81f64).sqrt() * e.powi(6);
    for s in [run().run().unwrap(), run().with(Verlet).run().unwrap()] {
        close_to(&times(&s.events), &wanted, 1e-11);
        assert!((s.v.unwrap()[0] - (speed - 9.81 * 0.01)).abs() < 1e-9);
    }
    let run = solve(circle, [0.0, 1.0], 0.0..1.0).change_motion_at(Crossing::Any, |_, y| y[0], |_, _, _| {});
    assert!(matches!(run.run().unwrap_err().why, Why::Invalid(text) if text.contains("change_at")));
}

/// A function that is no number for a while hides its roots there and nothing else.
#[test]
fn an_event_function_may_have_gaps() {
    let g = |t: f64, y: &Y| if (2.0..4.0).contains(&t) { f64::NAN } else { y[0] };
    let s = on_circle(0.5, 10.0).max_step(0.2).record(Crossing::Any, g).run().unwrap();
    assert_times(&times(&s.events), &[2.0 * PI, 3.0 * PI], "outside the gap");
}

/// The ball comes to rest at T (1 + e)/(1 - e) after endlessly many bounces: the run stops there and says so.
#[test]
fn bounces_without_end_have_a_name() {
    for e in [0.5, 0.8] {
        for (rtol, atol) in [(1e-6, 1e-9), (1e-3, 1e-3), (1e-10, 1e-12)] {
            for crossing in [Crossing::Falling, Crossing::Any] {
                let stopped = bounces(e, 100.0, crossing).rtol(rtol).atol(atol).run().unwrap_err();
                assert_eq!(stopped.why, Why::TooManyEvents { event: 0 }, "{stopped}");
                let rest = (2.0 / 9.81f64).sqrt() * (1.0 + e) / (1.0 - e);
                assert!((stopped.t - rest).abs() < 1e-9, "{} {rest}", stopped.t);
                assert!(stopped.solution.events.len() > 20 && stopped.solution.y[0].abs() < 1e-9);
            }
        }
    }
}

/// Ten million switches a second, half a year in: close to each other against t, but evenly so.
#[test]
fn many_events_late_in_time_are_not_endless() {
    let t0 = 2f64.powi(24);
    let period = 2f64.powi(-23);
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0 / period;
    let run = solve(line, [0.0], t0..t0 + 30.5 * period).with(Euler).step(0.125 * period);
    let s = run.change_at(Crossing::Rising, |_, y| y[0] - 0.9375, |_, y| y[0] = 0.0).run().unwrap();
    assert!(s.events.len() >= 30, "{}", s.events.len());
}

/// y' = 1 until y = 1, where it falls to 0: a saw of period 1. The new state is far from the root.
#[test]
fn a_change_may_leap_away_from_its_root() {
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    let saw =
        |t1: f64| solve(line, [0.0], 0.0..t1).change_at(Crossing::Any, |_, y| y[0] - 1.0, |_, y| y[0] = 0.0);
    let s = saw(5.5).run().unwrap();
    close_to(&times(&s.events), &[1.0, 2.0, 3.0, 4.0, 5.0], 1e-13);
    assert!((s.y[0] - 0.5).abs() < 1e-13);
    let s = saw(5.5).with(Rk4).step(0.15).run().unwrap();
    close_to(&times(&s.events), &[1.0, 2.0, 3.0, 4.0, 5.0], 1e-13);
    // Right at the end of the span: changed there, and nothing after it.
    let s = saw(1.0).with(Euler).step(0.25).run().unwrap();
    assert_eq!((s.t, s.y, s.events.len(), s.stats.accepted), (1.0, [0.0], 1, 4));
}

/// A thermostat, whose event function knows on and off alone: g is far from zero on both sides.
#[test]
fn event_functions_may_jump() {
    let heating = std::cell::Cell::new(true);
    // Towards 30 while heating, towards 10 while not, switched at 22 and 18.
    let f = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if heating.get() { 30.0 } else { 10.0 } - y[0];
    let run = solve(f, [20.0], 0.0..3.0).rtol(1e-10).atol(1e-10);
    let run = run.change_at(
        Crossing::Rising,
        |_, y| if y[0] > 22.0 { 1.0 } else { -1.0 },
        |_, _| heating.set(false),
    );
    let run = run.change_at(
        Crossing::Falling,
        |_, y| if y[0] > 18.0 { 1.0 } else { -1.0 },
        |_, _| heating.set(true),
    );
    let s = run.run().unwrap();
    // From 20 to 22: ln(10/8); from 22 to 18, and back: ln(12/8).
    let mut wanted = vec![1.25f64.ln()];
    while wanted.last().unwrap() + 1.5f64.ln() < 3.0 {
        wanted.push(wanted.last().unwrap() + 1.5f64.ln());
    }
    close_to(&times(&s.events), &wanted, 1e-8);
    assert!(s.events.iter().enumerate().all(|(i, e)| e.event == i % 2));
}

/// A change makes the slope carried by a pair, the history of a multistep method and the last position of
/// Störmer's worthless.
#[test]
fn every_family_starts_anew_after_a_change() {
    // y = e^-t until 1/2, where it is doubled: 2 e^-t from then on.
    let decay = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0];
    let run = || solve(decay, [1.0], 0.0..2.0).change_at(Crossing::Any, |t, _| t - 0.5, |_, y| y[0] *= 2.0);
    let exact = 2.0 * (-2f64).exp();
    let adaptive = || run().rtol(1e-10).atol(1e-10);
    let ends = [
        adaptive().with(Tsit54).run().unwrap().y[0],
        adaptive().with(Dop853).run().unwrap().y[0],
        adaptive().with(Adams).run().unwrap().y[0],
        adaptive().with(Bdf).run().unwrap().y[0],
        run().with(Tsit54).step(0.01).run().unwrap().y[0],
        run().with(Ab4).step(0.003).run().unwrap().y[0],
        run().with(kutta::methods::Abm4Pece).step(0.003).run().unwrap().y[0],
        run().with(kutta::methods::Abm4Pec).step(0.003).run().unwrap().y[0],
    ];
    for (i, y) in ends.iter().enumerate() {
        assert!((y - exact).abs() < 1e-9, "{i}: {:e}", y - exact);
    }
    // x'' = 1 from rest, moved back from 1/2 to 0 and keeping its speed, is there at the roots of 1, 2, 3.
    let a = |_: f64, _: &[f64; 1], a: &mut [f64; 1]| a[0] = 1.0;
    let run = || {
        let run = solve_second(a, [0.0], [0.0], 0.0..1.9).step(0.03);
        run.change_at(Crossing::Rising, |_, x| x[0] - 0.5, |_, x| x[0] -= 0.5)
    };
    for s in [run().with(Verlet).run().unwrap(), run().with(VelocityVerlet).run().unwrap()] {
        let roots = [1.0, 2f64.sqrt(), 3f64.sqrt()];
        close_to(&times(&s.events), &roots, 1e-12);
        let since = 1.9 - roots[2];
        assert!((s.y[0] - (roots[2] * since + 0.5 * since * since)).abs() < 1e-12, "{:?}", s.y);
        assert!((s.v.unwrap()[0] - 1.9).abs() < 1e-11);
    }
}

#[test]
fn roots_at_the_same_time_are_all_heard() {
    let line = |_: f64, _: &[f64; 2], dy: &mut [f64; 2]| *dy = [1.0, 1.0];
    let run = solve(line, [0.0; 2], 0.0..2.0);
    let run = run.change_at(Crossing::Any, |t, _| t - 1.0, |_, y| y[0] = -9.0);
    let run = run.change_at(Crossing::Any, |t, _| 2.0 * (t - 1.0), |_, y| y[1] = -7.0);
    let s = run.record(Crossing::Any, |t, _| t - 1.0).run().unwrap();
    assert_eq!(s.events.iter().map(|e| e.event).collect::<Vec<_>>(), [0, 1, 2]);
    assert!((s.y[0] + 8.0).abs() < 1e-13 && (s.y[1] + 6.0).abs() < 1e-13, "{:?}", s.y);
}

/// An event between breaks, on one, and a change right before one.
#[test]
fn events_and_breaks_keep_out_of_each_others_way() {
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if t < 1.0 { 1.0 } else { -2.0 };
    for at in [0.5, 1.0, 1.0f64.next_down(), 1.0f64.next_up(), 1.0 - 1e-15, 1.5] {
        let run = solve(f, [0.0], 0.0..2.0).breaks(&[1.0]);
        let s = run.change_at(Crossing::Rising, |t, _| t - at, |_, y| y[0] += 10.0).run().unwrap();
        assert_eq!(s.events.len(), 1, "{at:?}");
        assert!((s.events[0].t - at).abs() < 1e-15 && s.t == 2.0, "{at:?}: {:?}", times(&s.events));
        assert!((s.y[0] - 9.0).abs() < 1e-12, "{at:?}: {:?}", s.y);
    }
}

/// Events are looked for in accepted steps only.
#[test]
fn rejected_steps_have_no_events() {
    let run = on_circle(0.5, 10.0).first_step(9.0).record(Crossing::Any, |_, y| y[0]);
    let s = run.run().unwrap();
    assert!(s.stats.rejected.error > 0);
    assert_times(&times(&s.events), &[PI, 2.0 * PI, 3.0 * PI], "after rejections");
}
