//! Methods with implicit stages on what breaks such codes: values between steps, long relaxations, drift below the
//! tolerance, matrices that are singular or old, and slopes that belong to the past.

use kutta::problems::{E5Until1e11, Equation, Problem, RobertsonUntil1e11, RobertsonUntil40};
use kutta::tableau::Stages;
use kutta::{Crossing, Ivp, Jacobian, Loaded, Mass, Method, OutOfDomain, System, Why, methods, solve};
use std::cell::Cell;
use std::ops::ControlFlow;

/// Methods with implicit stages that solve them with a Jacobian.
fn implicit() -> Vec<Loaded> {
    let loaded = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
    let takes = |m: &Loaded| m.form().orders == 0 || m.form().damped;
    loaded.filter(|m| m.form().d == 1 && !m.form().explicit() && takes(m)).collect()
}

fn adaptive() -> impl Iterator<Item = Loaded> {
    implicit().into_iter().filter(|m| m.form().adaptive())
}

/// Those whose stages are found by iteration, with a Jacobian that may be old.
fn iterating() -> impl Iterator<Item = Loaded> {
    adaptive().filter(|m| !matches!(m.form().stages(), Stages::Linear))
}

fn property(name: &str) -> kutta::tableau::Properties {
    methods::find(name).unwrap().tableau().properties()
}

/// What an error test per step asks of methods of low order, and of others.
fn tolerance(method: &Loaded) -> f64 {
    if method.form().order < 4 && method.form().orders == 0 { 1e-3 } else { 1e-5 }
}

#[test]
fn ends_of_stiff_steps_are_met_bit_for_bit() {
    let p = RobertsonUntil40;
    let f = |t: f64, y: &[f64; 3], dy: &mut [f64; 3]| p.rhs(t, y, dy);
    let mut count = 0;
    for method in adaptive() {
        let run = || solve(f, p.y0(), 0.0..1.0).with(method.clone()).rtol(1e-3).atol(1e-7);
        let every = run().every_step().run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        let between = |t: &[f64]| [t[0], 0.5 * (t[0] + t[1])];
        let mut times: Vec<f64> = every.ts.windows(2).flat_map(between).collect();
        times.push(1.0);
        let at = run().at(&times).run().unwrap();
        let ends: Vec<_> = at.ys.iter().step_by(2).copied().collect();
        assert_eq!((ends, at.y), (every.ys, every.y), "{}", method.name());
        // Looking on changes no step, and what lies between two ends is near them: y1 falls all the way.
        assert_eq!(at.stats.accepted, every.stats.accepted, "{}", method.name());
        for y in at.ys.windows(3).step_by(2) {
            assert!(y[0][0] + 1e-4 > y[1][0] && y[1][0] + 1e-4 > y[2][0], "{}: {y:?}", method.name());
        }
        count += 1;
    }
    assert!(count > 30, "{count}");
}

/// 0 before the break, 1 from it on: y' = -10 (y - step).
fn relaxed(at: f64, t: f64) -> f64 {
    (-10.0 * (t + 1.0)).exp() + if t < at { 0.0 } else { -(10.0 * (at - t)).exp_m1() }
}

/// Until a break f is asked for times before it only, from there on for times at or behind it only, also by the
/// differences of a Jacobian; values between steps keep to their side.
#[test]
fn each_side_of_a_break_has_its_own_values() {
    // A stage outside the step looks across.
    let within = |m: &Loaded| m.form().c[..m.form().s].iter().all(|c| (0.0..=1.0).contains(&c.hi()));
    for method in adaptive().filter(within) {
        for at in [0.0, 0.1, -0.3, 1e-300] {
            let passed = Cell::new(false);
            let f = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
                assert!(t >= at || !passed.get(), "{}: {t:e} after {at:e}", method.name());
                passed.set(t >= at);
                dy[0] = -10.0 * (y[0] - if t < at { 0.0 } else { 1.0 });
            };
            let times = [at - 0.2, at - 1e-3, at, at + 1e-3, at + 0.2];
            let tol = tolerance(&method);
            let run = || solve(f, [1.0], -1.0..1.0).with(method.clone()).breaks(&[at]).at(&times);
            let s = run().rtol(tol).atol(tol).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
            assert!(passed.replace(false) && s.ts == times, "{}", method.name());
            for (t, y) in s.ts.iter().zip(&s.ys) {
                let off = (y[0] - relaxed(at, *t)).abs();
                // An interpolant of lower order than the step errs by more than the step, most where the steps are
                // the longest for the tolerance: where the estimate says too little.
                assert!(off < 60.0 * tol, "{} at {t}, break {at}: off by {off:e}", method.name());
            }
            if method.form().orders == 0 {
                let s = run().step(0.01).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
                assert!(passed.get() && s.ts == times, "{}", method.name());
            }
        }
    }
}

/// y' = -z, 0 = z (1 + y) - y (1 + t): z = y (1 + t)/(1 + y).
#[test]
fn algebraic_components_are_good_along_the_way() {
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        *dy = [-y[1], y[1] * (1.0 + y[0]) - y[0] * (1.0 + t)];
    };
    let mass = |m: &mut Mass<f64>| m[(0, 0)] = 1.0;
    // ln y + y = 1 - t - t^2/2, from y = 1.
    let exact = |t: f64| {
        let (aim, mut y) = (1.0 - t - 0.5 * t * t, 1.0f64);
        (0..60).for_each(|_| y *= (1.0 + aim - y.ln()) / (1.0 + y));
        [y, y * (1.0 + t) / (1.0 + y)]
    };
    let times: Vec<f64> = (0..=60).map(|k| 0.05 * f64::from(k)).collect();
    let mut count = 0;
    for method in adaptive() {
        let tol = tolerance(&method);
        let run = solve(f, exact(0.0), 0.0..3.0).with(method.clone()).mass(mass).at(&times);
        let s = match run.rtol(tol).atol(tol).run() {
            Err(stop) if matches!(stop.why, Why::Invalid(_)) => continue,
            run => run.unwrap_or_else(|e| panic!("{}: {e}", method.name())),
        };
        let worst = |i: usize| {
            let off = |(t, y): (&f64, &[f64; 2])| (y[i] - exact(*t)[i]).abs();
            s.ts.iter().zip(&s.ys).map(off).fold(0.0, f64::max)
        };
        let (y, z) = (worst(0), worst(1));
        // Between steps z is that of slopes, of one order less than y: of order two where y is drawn as a cubic.
        assert!(y < 10.0 * tol && z < 200.0 * tol, "{}: y {y:e}, z {z:e}", method.name());
        count += 1;
    }
    assert!(count > 15, "{count}");
}

/// Van der Pol's equation on the slow time t/mu, eps = 1/mu^2: it creeps from y = 2 along ln y - y^2/2 = c + t to
/// y = 1, jumps to about -2 and creeps back.
#[test]
fn relaxation_oscillations_of_any_stiffness_are_followed() {
    let creep = |c: f64| {
        let mut y = 1.7f64;
        (0..50).for_each(|_| y -= (y.ln() - 0.5 * y * y - c) / (1.0 / y - y));
        y
    };
    let start = 2f64.ln() - 2.0;
    let half = 1.5 - 2f64.ln();
    let mut jumped = 0;
    for mu in [1e3, 1e6, 1e9f64] {
        let per = mu * mu;
        let f = move |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
            *dy = [y[1], per * ((1.0 - y[0] * y[0]) * y[1] - y[0])];
        };
        let j = move |_: f64, y: &[f64; 2], j: &mut Jacobian<f64>| {
            (j[(0, 1)], j[(1, 0)], j[(1, 1)]) =
                (1.0, per * (-2.0 * y[0] * y[1] - 1.0), per * (1.0 - y[0] * y[0]));
        };
        // A pair in two parts evaluates f anew where a step begins, which magnifies what an iteration has left of its
        // error by the stiffness: at 1e18 it runs out of steps.
        let fit = |m: &Loaded| m.form().order > 3 && !m.form().split() || m.form().orders > 0;
        for method in adaptive().filter(fit) {
            let p = property(method.name());
            if p.l_stable != Some(true) && method.form().orders == 0 {
                continue;
            }
            let run = solve(f, [2.0, -2.0 / 3.0], 0.0..1.2).jacobian(j).with(method.clone());
            let (s, why) = match run.at(&[0.5, 1.2]).rtol(1e-5).atol(1e-6).max_steps(5000).run() {
                Ok(s) => (s, None),
                Err(stop) => (*stop.solution, Some(stop.why)),
            };
            let Some(half_way) = s.ys.first() else {
                panic!("{} at mu = {mu:e}: {why:?}, {:?}", method.name(), s.stats)
            };
            let off = (half_way[0] - creep(start + 0.5)).abs();
            assert!(off < 2e-4 + 10.0 / per, "{} at mu = {mu:e}: off by {off:e}", method.name());
            match why {
                None => {
                    // The jump takes 3.5 mu^(-4/3) (Dorodnitsyn 1947: 7.014 a period in all), to leading order; y
                    // moves about as fast as the slow time.
                    let off = (s.ys[1][0] + creep(start + 1.2 - half)).abs();
                    let bound = 2e-4 + 5.0 * mu.powf(-4.0 / 3.0);
                    // Their estimates weigh what damps too little to see that y stays beyond the fold for a while.
                    let late = matches!(method.name(), "kencarp5-esdirk" | "esdirk436l2sa");
                    let bound = if late { 0.1 } else { bound };
                    assert!(off < bound, "{} at mu = {mu:e}: off by {off:e}", method.name());
                    jumped += 1;
                }
                // A jump of 1/mu^2 is shorter than the spacing of times from 1e8 on.
                Some(why) => {
                    assert!(mu > 1e8 && s.t < half + 1e-4, "{} at {}: {why}", method.name(), s.t);
                }
            }
        }
    }
    assert!(jumped > 30, "{jumped}");
}

/// From a y1 that is a little below zero the equation itself runs away, y1' = -4.8e-4 y1^2, to minus millions at 1e11.
/// What is left of y1 there is 2e-8: an atol below that keeps every method from it, and none says that it is there
/// when it is not.
#[test]
fn a_tight_atol_keeps_robertsons_amounts_from_running_away() {
    let p = RobertsonUntil1e11;
    let f = |t: f64, y: &[f64; 3], dy: &mut [f64; 3]| p.rhs(t, y, dy);
    let reference = p.reference().unwrap();
    let mut ended = 0;
    for method in adaptive().filter(|m| m.form().order > 2 || m.form().orders > 0) {
        for atol in [1e-10, 1e-13] {
            let j = |t: f64, y: &[f64; 3], j: &mut Jacobian<f64>| {
                p.jacobian(t, y, |row, column, value| j[(row, column)] += value);
            };
            let run = solve(f, p.y0(), 0.0..1e11).jacobian(j).with(method.clone()).rtol(1e-4).atol(atol);
            match run.max_steps(2000).every_step().run() {
                Ok(s) => {
                    let off = |(y, r): (&f64, &f64)| (y - r).abs() / (atol + 1e-4 * r.abs());
                    let worst = s.y.iter().zip(&reference).map(off).fold(0.0, f64::max);
                    // Eleven decades, each with its own errors, in a thousand steps and more of low orders.
                    assert!(worst < 300.0, "{} with {atol:e}: {:?}, {worst:e}", method.name(), s.y);
                    assert!(s.ys.iter().all(|y| y[0] > 0.0), "{} with {atol:e}", method.name());
                    ended += 1;
                }
                Err(stop) => {
                    assert!(matches!(stop.why, Why::TooManySteps { .. }), "{}: {stop}", method.name());
                    assert!(stop.solution.y[0] > 0.0, "{}: {:?}", method.name(), stop.solution.y);
                }
            }
        }
    }
    assert!(ended > 30, "{ended}");
}

/// y' = A (y - g) + g' with eigenvalues -1 +- 1000 i: the solution is smooth, and errors turn.
#[test]
fn stiff_oscillations_are_followed_in_long_steps() {
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        let (a, b, slope) = (y[0] - t.sin(), y[1] - t.sin(), t.cos());
        *dy = [1000.0 * b - a + slope, -1000.0 * a - b + slope];
    };
    for method in adaptive() {
        if property(method.name()).a_stable != Some(true) && method.form().orders == 0 {
            continue;
        }
        let tol = tolerance(&method);
        let run = solve(f, [0.0; 2], 0.0..10.0).with(method.clone()).rtol(tol).atol(tol).run();
        let s = run.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        let off = s.y.iter().map(|y| (y - 10f64.sin()).abs()).fold(0.0, f64::max);
        assert!(off < 10.0 * tol, "{}: off by {off:e}, {:?}", method.name(), s.stats);
        // h |lambda| = 1 would ask for ten thousand.
        assert!(s.stats.accepted < 2000, "{}: {:?}", method.name(), s.stats);
    }
}

/// y' = lambda y, with a Jacobian of its own.
struct Linear {
    lambda: f64,
    j: f64,
}

impl System<[f64; 1]> for Linear {
    fn rhs(&mut self, _t: f64, y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
        dy[0] = self.lambda * y[0];
        Ok(())
    }
    fn jacobian(&mut self, _t: f64, _y: &[f64; 1], j: &mut Jacobian<f64>) -> bool {
        j[(0, 0)] = self.j;
        true
    }
}

/// The step at which 1 - h g J is zero for J = 8, of a form with one g; coupled stages have complex ones.
fn singular_step(method: &Loaded) -> Option<f64> {
    let form = method.form();
    let g = form.stage[..form.s].iter().map(|row| row.diagonal.hi()).find(|&g| g != 0.0)?;
    let near = 0.125 / g;
    let steps = [near, near.next_up(), near.next_down()];
    (!matches!(form.stages(), Stages::Full)).then(|| steps.into_iter().find(|h| h * g == 0.125))?
}

#[test]
fn a_singular_matrix_is_factored_anew_at_another_step() {
    let mut count = 0;
    for method in adaptive().filter(|m| m.form().orders == 0) {
        let Some(h) = singular_step(&method) else { continue };
        let tol = tolerance(&method);
        let ivp = Ivp::new(Linear { lambda: 8.0, j: 8.0 }, [1.0], 0.0..2.0).with(method.clone());
        let run = ivp.first_step(h).rtol(tol).atol(tol).every_step().run();
        let s = run.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        assert_eq!(s.stats.rejected.singular, 1, "{}: {:?}", method.name(), s.stats);
        assert!(s.ts[1] < h && s.stats.factorizations > 1, "{}: {:?}", method.name(), s.stats);
        // Errors grow as the solution does, and each step adds one.
        let off = (s.y[0] / 16f64.exp() - 1.0).abs();
        assert!(off < 300.0 * tol, "{}: {off:e}", method.name());
        count += 1;
    }
    assert!(count > 20, "{count}");
}

#[test]
fn an_iteration_that_fails_cuts_the_step_and_is_counted_apart() {
    for method in iterating() {
        let ivp = Ivp::new(Linear { lambda: -50.0, j: 50.0 }, [1.0], 0.0..1.0).with(method.clone());
        let run = ivp.rtol(1e-3).atol(1e-6).first_step(0.5).every_step().run();
        let s = run.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        assert!(s.stats.rejected.newton > 0 && s.ts[1] < 0.5, "{}: {:?}", method.name(), s.stats);
        let rejected = s.stats.rejected;
        // The wrong Jacobian tells of growth, too.
        let counted = rejected.newton + rejected.error + rejected.singular;
        assert_eq!(rejected.total(), counted, "{}", method.name());
        assert!((s.y[0] - (-50f64).exp()).abs() < 1e-4, "{}: {:?}", method.name(), s.y);
    }
}

/// A pull to cos t that is a thousand times as strong after 1/2, where a step ends: the solution is smooth, and only
/// the Jacobian is old. A new one is taken, and no iteration cuts the step. (Where the iterations before converged at
/// once, a first correction may pass for good, and the error test cut the step.)
#[test]
fn an_old_jacobian_is_taken_anew_before_the_step_is_cut() {
    let pull = |late: bool| if late { 1000.0 } else { 1.0 };
    for method in iterating().filter(|m| m.form().orders == 0) {
        let f = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -pull(t > 0.5) * (y[0] - t.cos()) - t.sin();
        let j = |t: f64, _: &[f64; 1], j: &mut Jacobian<f64>| j[(0, 0)] = -pull(t >= 0.5);
        let run = solve(f, [1.0], 0.0..1.0).jacobian(j).with(method.clone()).rtol(1e-2).atol(1e-2);
        let s = run.first_step(0.125).max_step(0.125).every_step().run();
        let s = s.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
        assert_eq!(s.ts[..5], [0.0, 0.125, 0.25, 0.375, 0.5], "{}", method.name());
        // A third one where the second was slow on the way to the new solution.
        let taken = (2..=3).contains(&s.stats.jacobians);
        assert!(taken && s.stats.rejected.newton == 0, "{}: {:?}", method.name(), s.stats);
        assert!(s.stats.accepted + s.stats.rejected.error < 30, "{}: {:?}", method.name(), s.stats);
        assert!((s.y[0] - 1f64.cos()).abs() < 2e-2, "{}: {:?}", method.name(), s.y);
    }
}

/// Eigenvalues -1 beside an entry of ten thousand: no step is limited by stability, whatever the norm of the
/// matrix. With -1000 in its place there is one that is.
#[test]
fn a_matrix_far_from_normal_is_not_called_stiff() {
    for (fast, stiff) in [(-1.0, false), (-3.0, false), (-1000.0, true)] {
        let f = move |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-y[0] + 1e4 * y[1], fast * y[1]];
        let s = solve(f, [0.0, 1.0], 0.0..20.0).rtol(1e-7).atol(1e-7).run().unwrap();
        assert_eq!(s.choices.len() > 1, stiff, "{fast}: {:?}", s.choices);
        let exact = match fast == -1.0 {
            true => 1e4 * 20.0 * (-20f64).exp(),
            false => 1e4 / (-1.0 - fast) * ((-20f64).exp() - (20.0 * fast).exp()),
        };
        // It grows ten thousandfold on the way.
        assert!((s.y[0] - exact).abs() < 1e-6 * 1e4, "{fast}: {} {exact}", s.y[0]);
    }
}

/// Van der Pol's equation with a force that jumps at t = 1/2.
fn forced(t: f64, y: &[f64; 2], dy: &mut [f64; 2]) {
    let force = if t < 0.5 { 0.0 } else { 3.0 };
    *dy = [y[1], 2.0 * (1.0 - y[0] * y[0]) * y[1] - y[0] + force];
}

/// Behind a change of state or a break every bit is that of a run that starts there.
#[test]
fn nothing_of_the_past_is_used_after_a_change_or_a_break() {
    for method in implicit() {
        for change in [false, true] {
            for fixed in [false, true] {
                if !fixed && !method.form().adaptive() || fixed && method.form().orders > 0 {
                    continue;
                }
                let run = |t: f64, y: [f64; 2]| {
                    let run = solve(forced, y, t..1.0).with(method.clone()).rtol(1e-3).atol(1e-3);
                    run.max_step(0.1).every_step()
                };
                let whole = run(0.0, [2.0, 0.0]);
                let whole = match change {
                    true => whole.change_at(Crossing::Any, |t, _| t - 0.625, |_, y| y[1] += 1.0),
                    false => whole.breaks(&[0.5]),
                };
                let whole = if fixed { whole.step(0.03).run() } else { whole.run() };
                let whole = whole.unwrap_or_else(|e| panic!("{}: {e}", method.name()));
                let at = if change { whole.events[0].t } else { 0.5 };
                let here = whole.ts.iter().position(|&t| t == at).unwrap();
                let rest = run(at, whole.ys[here]);
                let rest = if fixed { rest.step(0.03).run() } else { rest.run() }.unwrap();
                let what = if change { "change" } else { "break" };
                assert_eq!(whole.ts[here..], rest.ts, "{}, {what}", method.name());
                assert_eq!(whole.ys[here..], rest.ys, "{}, {what}", method.name());
            }
        }
    }
}

/// A step after a rejection is the one that a run would begin with; an iteration knows how the last one converged,
/// and may end elsewhere within its tolerance.
#[test]
fn nothing_of_a_rejected_step_is_used() {
    for method in adaptive() {
        let first = |h: f64| {
            let run = solve(forced, [2.0, 3.0], 0.0..10.0).with(method.clone()).rtol(1e-5).atol(1e-5);
            let run = run.first_step(h).every_step().observe(|_| ControlFlow::Break(()));
            run.run().unwrap_or_else(|e| panic!("{}: {e}", method.name()))
        };
        let cut = first(5.0);
        assert!(cut.stats.rejected.total() > 0 && cut.stats.accepted == 1, "{}", method.name());
        let anew = first(cut.t);
        assert_eq!((anew.t, anew.stats.rejected.total()), (cut.t, 0), "{}", method.name());
        if matches!(method.form().stages(), Stages::Linear) {
            assert_eq!(anew.y, cut.y, "{}", method.name());
        } else {
            for (a, b) in anew.y.iter().zip(&cut.y) {
                // A family keeps the differences of its first try, as coarse as that was long, and one correction.
                let most = if method.form().orders > 0 { 2.0 } else { 0.1 };
                assert!((a - b).abs() < most * 1e-5 * (1.0 + b.abs()), "{}: {a} {b}", method.name());
            }
        }
    }
}

/// y' = y^2 from 1 has its pole at t = 1. A matrix 1 - 2 h g y of the other sign leads to the solution beyond it.
#[test]
fn no_method_steps_over_a_pole() {
    let f = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = y[0] * y[0];
    let mut count = 0;
    for method in adaptive() {
        for tol in [1e-3, 1e-6] {
            let run =
                solve(f, [1.0], 0.0..2.0).with(method.clone()).rtol(tol).atol(tol).max_steps(10_000).run();
            let name = method.name();
            let stop = run.err().unwrap_or_else(|| panic!("{name} at {tol:e} crossed the pole"));
            assert!(stop.t < 1.0 + 100.0 * tol, "{name} at {tol:e}: {stop}");
            assert!(stop.solution.y[0] > 1.0, "{name} at {tol:e}: {stop}");
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
}

/// On E5, where y2 - y3 - y4 stays 0 and all three fall by ten decades, products with a rounded Jacobian leave no digit.
#[test]
fn a_sum_lost_in_rounding_is_told() {
    let p = E5Until1e11;
    let run =
        |method: Loaded| Ivp::new(Equation(p), p.y0(), 0.0..1e11).with(method).rtol(1e-5).atol(1e-27).run();
    let mut count = 0;
    for method in adaptive() {
        let linear = matches!(method.form().stages(), Stages::Linear);
        if !linear || method.form().order < 4 {
            continue;
        }
        let stop =
            run(method.clone()).err().unwrap_or_else(|| panic!("{} says that all is well", method.name()));
        assert!(matches!(stop.why, Why::Rounding { .. }), "{}: {stop}", method.name());
        count += 1;
    }
    assert!(count > 4, "{count}");
}
