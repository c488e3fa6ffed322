//! Step by step: the iterator, the observer, the statistics, the options, and what is refused.

use kutta::methods::{Ab4, Abm4Pece, CashKarp54, Dop853, Dp54, Euler, Rk4, VelocityVerlet, Verlet};
use kutta::{Controller, Crossing, Ivp, Method, Pace, Solution, Stats, Why, solve, solve_second};
use std::cell::Cell;
use std::ops::ControlFlow;

type Y = [f64; 2];
type Circle = fn(f64, &Y, &mut Y);

fn circle(_: f64, y: &Y, dy: &mut Y) {
    *dy = [y[1], -y[0]];
}

fn start<'w>(t1: f64) -> Ivp<'w, Y, Circle> {
    solve(circle as Circle, [0.0, 1.0], 0.0..t1)
}

/// The iterator gives what `every_step` saves, and then ends.
fn assert_same<M: Method, P: Pace>(make: impl Fn() -> Ivp<'static, Y, Circle, M, P>) {
    let s: Solution<Y> = make().every_step().run().unwrap();
    let mut seen = vec![(s.ts[0], s.ys[0])];
    let mut steps = make().steps();
    for step in steps.by_ref() {
        seen.push(step.unwrap());
        assert!(seen.len() <= s.ts.len(), "the iterator goes on after the end: {:?}", seen.last());
    }
    assert!(steps.next().is_none());
    assert_eq!(seen.len(), s.ts.len());
    for (i, (t, y)) in seen.into_iter().enumerate() {
        assert_eq!((t, y), (s.ts[i], s.ys[i]), "step {i} of {}", s.ts.len());
    }
}

#[test]
fn the_iterator_gives_every_step_and_ends() {
    assert_same(|| start(10.0));
    assert_same(|| start(-10.0).with(Dp54));
    assert_same(|| start(10.0).with(Rk4).step(0.1));
    assert_same(|| start(1.0).with(Rk4).step(2.0));
    // The steps that start a multistep method are steps too, even when there are no others.
    assert_same(|| start(10.0).with(Ab4).step(0.1));
    assert_same(|| start(0.2).with(Ab4).step(0.1));
    assert_same(|| start(0.3).with(Abm4Pece).step(0.1));
    assert_same(|| start(10.0).breaks(&[3.0, 7.0]));
    assert_same(|| start(10.0).with(Ab4).step(0.1).breaks(&[0.2, 3.0, 7.0]));
    assert_same(|| start(10.0).change_at(Crossing::Any, |_, y| y[0] - 0.5, |_, y| y[1] *= -1.0));
    assert_same(|| {
        start(1.0).with(Ab4).step(0.1).change_at(Crossing::Any, |t, _| t - 0.15, |_, y| y[0] = 0.0)
    });
    assert_same(|| start(10.0).stop_at(Crossing::Falling, |_, y| y[0]));
    assert_same(|| start(10.0).at(&[0.0, 10.0]));
}

#[test]
fn the_iterator_ends_with_the_error() {
    let pole = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = y[0] * y[0];
    let mut last = (0.0, [1.0]);
    let mut error = None;
    for step in solve(pole, [1.0], 0.0..2.0).steps() {
        assert!(error.is_none(), "nothing comes after the error");
        match step {
            Ok(step) => last = step,
            Err(stopped) => error = Some(stopped),
        }
    }
    let stopped = error.expect("there is a pole at 1");
    assert!(matches!(stopped.why, Why::StepTooSmall { .. }));
    assert_eq!((stopped.t, stopped.solution.y), last);
    // Two good steps before the start of a multistep method fails.
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if t > 0.25 { f64::NAN } else { 1.0 };
    let steps: Vec<_> = solve(f, [0.0], 0.0..1.0).with(Ab4).step(0.1).steps().collect();
    assert!(steps.len() == 3 && steps[..2].iter().all(|s| s.is_ok()) && steps[2].is_err(), "{}", steps.len());
    // What makes no sense is said once.
    let steps: Vec<_> = start(1.0).rtol(-1.0).steps().collect();
    assert!(matches!(&steps[..], [Err(stopped)] if matches!(stopped.why, Why::Invalid(_))));
}

#[test]
fn the_observer_sees_every_step_and_may_end_the_run() {
    let mut seen = vec![];
    let s = start(10.0).observe(|step| {
        seen.push((step.t, step.h, *step.y));
        ControlFlow::Continue(())
    });
    let s = s.every_step().run().unwrap();
    assert_eq!(seen.len() as u64, s.stats.accepted);
    for (i, (t, h, y)) in seen.iter().enumerate() {
        assert_eq!((*t, *y), (s.ts[i + 1], s.ys[i + 1]));
        assert!((t - h - s.ts[i]).abs() < 1e-14);
    }
    let ends =
        |t: f64, late: f64| if t.abs() >= late { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    for late in [0.05, 0.25, 0.55, 3.0] {
        let s = start(10.0).with(Ab4).step(0.1).observe(|step| ends(step.t, late)).run().unwrap();
        let steps = (late / 0.1f64).ceil();
        assert_eq!(s.stats.accepted, steps as u64, "{late}");
        assert!((s.t - 0.1 * steps).abs() < 1e-14 && (s.y[0] - s.t.sin()).abs() < 1e-4);
        let s = start(-10.0).observe(|step| ends(step.t, late)).run().unwrap();
        assert!(s.t <= -late && (s.y[0] - s.t.sin()).abs() < 1e-5, "{}", s.t);
        // An iterator ends with it.
        let steps = start(10.0).with(Rk4).step(0.1).observe(|step| ends(step.t, late)).steps().count();
        assert_eq!(steps as u64, (late / 0.1f64).ceil() as u64);
        let steps = start(10.0).with(Ab4).step(0.1).observe(|step| ends(step.t, late)).steps().count();
        assert_eq!(steps as u64, (late / 0.1f64).ceil() as u64);
    }
    // Of a step that an event cut short it sees the part that was taken, after the change.
    let mut cut = vec![];
    let line = |_: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 1.0;
    let run = solve(line, [0.0], 0.0..1.0).with(Euler).step(0.25).observe(|step| {
        cut.push((step.t, step.h, step.y[0]));
        if step.y[0] == 7.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let s = run.change_at(Crossing::Any, |t, _| t - 0.375, |_, y| y[0] = 7.0).run().unwrap();
    assert_eq!((s.t, s.y), (0.375, [7.0]));
    assert_eq!(cut, [(0.25, 0.25, 0.25), (0.375, 0.125, 7.0)]);
}

/// Every call of f is counted, whatever it is for: starts, probes, stages, dense output, events, velocities.
#[test]
fn evaluations_are_counted() {
    let calls = Cell::new(0);
    let f = |t: f64, y: &Y, dy: &mut Y| {
        calls.set(calls.get() + 1);
        circle(t, y, dy);
    };
    let check = |what: &str, stats: Stats| assert_eq!(calls.replace(0), stats.evaluations, "{what}");
    let run = || solve(f, [0.0, 1.0], 0.0..5.0);
    let times = [0.1, 0.2, 2.0, 2.05, 3.0, 4.99, 5.0];
    check("adaptive", run().run().unwrap().stats);
    check("without a carried slope", run().with(CashKarp54).run().unwrap().stats);
    check("rejections", run().first_step(5.0).with(CashKarp54).run().unwrap().stats);
    check("own dense output", run().with(Dop853).at(&times).run().unwrap().stats);
    check("Hermite", run().with(CashKarp54).at(&times).run().unwrap().stats);
    check("breaks", run().with(CashKarp54).at(&times).breaks(&[2.0, 3.1]).run().unwrap().stats);
    check("events", run().with(CashKarp54).record(Crossing::Any, |_, y| y[0] - 0.3).run().unwrap().stats);
    let flip = |run: Ivp<Y, _>| {
        run.change_at(Crossing::Any, |_, y| y[0] - 0.3, |_, y| y[1] *= -1.0).run().unwrap().stats
    };
    check("changes", flip(run()));
    check("fixed", run().with(Rk4).step(0.1).run().unwrap().stats);
    check("fixed, dense", run().with(Rk4).step(0.1).at(&times).run().unwrap().stats);
    check("fixed, carried", run().with(Dp54).step(0.1).at(&times).run().unwrap().stats);
    check("multistep", run().with(Ab4).step(0.1).at(&times).run().unwrap().stats);
    check("predictor-corrector", run().with(Abm4Pece).step(0.1).at(&times).run().unwrap().stats);
    check("start alone", run().with(Ab4).step(2.5).at(&times).run().unwrap().stats);
    let run = || solve_second(f, [0.0, 1.0], [1.0, 0.0], 0.0..5.0).step(0.1);
    check("velocity Verlet", run().with(VelocityVerlet).at(&times).run().unwrap().stats);
    check("Verlet", run().with(Verlet).run().unwrap().stats);
    check("Verlet, dense", run().with(Verlet).at(&times).breaks(&[1.0]).every_step().run().unwrap().stats);
}

#[test]
fn methods_that_do_not_fit_are_refused() {
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let text = |why: Why| match why {
        Why::Invalid(text) => text,
        why => panic!("{why:?}"),
    };
    // A first-order method for a second-order problem, and the other way round.
    let why = text(solve_second(a, [1.0], [0.0], 0.0..1.0).with(Rk4).step(0.1).run().unwrap_err().why);
    assert!(why.contains("rk4 is for y' = f(t, y)"), "{why}");
    let why = text(start(1.0).with(VelocityVerlet).step(0.1).run().unwrap_err().why);
    assert!(why.contains("velocity-verlet is for y'' = f(t, y)"), "{why}");
    // Positions and velocities of different length.
    let long = |_: f64, _: &Vec<f64>, _: &mut Vec<f64>| {};
    let run = solve_second(long, vec![1.0; 3], vec![0.0; 2], 0.0..1.0).step(0.1);
    let why = text(run.run().unwrap_err().why);
    assert!(why.contains('3') && why.contains('2'), "{why}");
    // A table read at run time without an error estimate needs a step; the compiler says so of the others.
    let rk4 = kutta::methods::find("rk4").unwrap();
    let rk4 = kutta::Loaded::parse(rk4.name, rk4.text).unwrap();
    let why = text(start(1.0).with(rk4.clone()).run().unwrap_err().why);
    assert!(why.contains("rk4") && why.contains(".step(h)"), "{why}");
    assert!(start(1.0).with(rk4).step(0.1).run().is_ok());
    // What starts a multistep method takes one step.
    let why = text(start(1.0).with(Ab4).start_with(kutta::methods::Ab2).step(0.1).run().unwrap_err().why);
    assert!(why.contains("ab2 cannot start ab4"), "{why}");
    let why = text(start(1.0).with(Ab4).start_with(VelocityVerlet).step(0.1).run().unwrap_err().why);
    assert!(why.contains("velocity-verlet cannot start ab4"), "{why}");
}

#[test]
fn senseless_steps_are_refused() {
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY, 1e-300] {
        let stopped = start(1.0).with(Rk4).step(bad).run().unwrap_err();
        assert!(matches!(&stopped.why, Why::Invalid(text) if text.contains("step")), "{bad}: {stopped}");
    }
    for bad in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        for stopped in
            [start(1.0).max_step(bad).run().unwrap_err(), start(1.0).first_step(bad).run().unwrap_err()]
        {
            assert!(matches!(&stopped.why, Why::Invalid(text) if text.contains("step")), "{bad}: {stopped}");
        }
    }
    assert!(start(1.0).min_step(-0.1).run().is_err() && start(1.0).min_step(0.0).run().is_ok());
    let stopped = solve(circle, [0.0, 1.0], -1e308..1.5e308).run().unwrap_err();
    assert!(matches!(stopped.why, Why::Invalid(_)), "{stopped}");
    for bad in [
        Controller { shrink: 0.0, ..Controller::I },
        Controller { shrink: 1.5, ..Controller::I },
        Controller { safety: 0.0, ..Controller::I },
        Controller { safety: f64::NAN, ..Controller::I },
        Controller { grow: 0.5, ..Controller::I },
        Controller { grow: f64::INFINITY, ..Controller::I },
    ] {
        let stopped = start(1.0).controller(bad).run().unwrap_err();
        assert!(
            matches!(&stopped.why, Why::Invalid(text) if text.contains("controller")),
            "{bad:?}: {stopped}"
        );
    }
}

/// Each controller, and steps taken late, follow the tolerance without rejecting many steps.
#[test]
fn every_controller_controls() {
    let van_der_pol = |_: f64, y: &Y, dy: &mut Y| *dy = [y[1], 5.0 * (1.0 - y[0] * y[0]) * y[1] - y[0]];
    let run = || solve(van_der_pol, [2.0, 0.0], 0.0..20.0);
    let reference = run().rtol(1e-12).atol(1e-12).run().unwrap().y;
    for controller in [Controller::I, Controller::PI, Controller::PID, Controller::H211B] {
        for late in [false, true] {
            let mut last = f64::INFINITY;
            for tol in [1e-4, 1e-6, 1e-8] {
                let s = run().rtol(tol).atol(tol).controller(controller).late(late).run().unwrap();
                let error = (s.y[0] - reference[0]).abs().max((s.y[1] - reference[1]).abs());
                // The steep phases, where errors grow by the steepness of 5 times 3, are passed four times.
                assert!(error < 300.0 * tol && error < last, "{controller:?}, {late}, {tol}: {error:e}");
                last = error;
                let share = s.stats.rejected.error as f64 / s.stats.accepted as f64;
                let most = if late { 0.7 } else { 0.35 };
                assert!(share < most, "{controller:?}, {late}, {tol}: {:?}", s.stats);
            }
        }
    }
}
