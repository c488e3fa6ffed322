//! Families of variable order: their order and step follow the solution, their errors the tolerance.

use kutta::methods::{Adams, Bdf};
use kutta::problems::{
    Arenstorf4Loop, Equation, Hires, KeplerE06, Lorenz63, Orego, Pleiades, Problem, RobertsonUntil1e11,
    VdpMu1000,
};
use kutta::tableau::DoubleDouble;
use kutta::{Controller, Crossing, Interpolant, Ivp, Jacobian, Loaded, Method, Solution, Stats, Why, solve};
use num_complex::Complex;

/// The error at the end, each component relative to itself and the problem's scale, and what it took.
fn solved<P: Problem, M: Method>(problem: P, method: M, tol: f64) -> (f64, Stats) {
    let (t0, t1) = problem.span();
    let run = Ivp::new(Equation(problem.clone()), problem.y0(), t0..t1).with(method);
    let s = run.rtol(tol).atol(tol * problem.scale()).run();
    let s = s.unwrap_or_else(|e| panic!("{} at {tol:e}: {e}", P::NAME));
    let off = |(y, r): (&f64, &f64)| (y - r).abs() / (r.abs() + problem.scale());
    let reference = problem.reference().unwrap();
    (s.y.as_ref().iter().zip(reference.as_ref()).map(off).fold(0.0, f64::max), s.stats)
}

/// The error is a power of the tolerance near the first: the slope of a line through seven decades, in logarithms,
/// of which single rungs are off by a factor of ten.
fn ladder<P: Problem, M: Method>(problem: P, method: M, most: f64) -> Vec<(f64, Stats)> {
    let decades = [5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0f64];
    let rungs = decades.map(|k| solved(problem.clone(), method.clone(), 10f64.powf(-k)));
    for (k, (error, _)) in decades.iter().zip(&rungs) {
        assert!(*error < most * 10f64.powf(-k), "{} at 1e-{k}: off by {error:e}", P::NAME);
    }
    let sum: f64 = decades.iter().zip(&rungs).map(|(k, (error, _))| -(k - 8.0) * error.log10()).sum();
    let slope = sum / 28.0;
    assert!((0.75..1.3).contains(&slope), "{}: error like the tolerance to the power {slope}", P::NAME);
    rungs.to_vec()
}

#[test]
fn errors_of_bdf_follow_the_tolerance_on_stiff_problems() {
    // The jumps of the relaxing oscillators move in time by every error before them.
    for rungs in [
        ladder(VdpMu1000, Bdf, 1e3),
        ladder(RobertsonUntil1e11, Bdf, 1e3),
        ladder(Hires, Bdf, 1e3),
        ladder(Orego, Bdf, 1e3),
    ] {
        assert!(rungs.iter().all(|(_, stats)| (4..=5).contains(&stats.order)), "{rungs:?}");
        // One Jacobian serves many steps, one factorization several.
        for (_, s) in &rungs {
            assert!(s.jacobians * 8 < s.accepted && s.factorizations * 2 < s.accepted, "{s:?}");
            assert!(s.evaluations < 3 * s.accepted, "{s:?}");
        }
    }
}

#[test]
fn errors_of_adams_follow_the_tolerance_and_its_order_rises() {
    // An error grows by 1e4 in ten units of Lorenz's time, by as much on the way round the moon.
    for rungs in [
        ladder(Lorenz63, Adams, 1e5),
        ladder(KeplerE06, Adams, 1e5),
        ladder(Pleiades, Adams, 1e5),
        ladder(Arenstorf4Loop, Adams, 1e7),
    ] {
        let orders: Vec<_> = rungs.iter().map(|(_, stats)| stats.order).collect();
        assert!(orders[0] >= 4 && orders[6] > orders[0] + 1, "{orders:?}");
        // One correction is enough in most steps, two in some.
        assert!(rungs.iter().all(|(_, s)| s.evaluations < 2 * s.accepted && s.factorizations == 0));
    }
}

/// What CVODE 6.4 takes (BDF and Adams with functional iteration, exact Jacobians, dense), at the tolerance
/// at which it errs as much: these runs must not take more evaluations.
#[test]
fn evaluations_at_an_error_are_no_more_than_those_of_cvode() {
    // Error and evaluations at 1e-3, 1e-6, 1e-9, measured once with that program.
    fn check<P: Problem, M: Method>(problem: P, method: M, peer: [(f64, f64); 3], share: f64) {
        for tol in [1e-6, 1e-9] {
            let (error, stats) = solved(problem.clone(), method.clone(), tol);
            let (a, b) = if error > peer[1].0 { (peer[0], peer[1]) } else { (peer[1], peer[2]) };
            // Straight lines between errors and evaluations in logarithms.
            let share_of = (error / a.0).ln() / (b.0 / a.0).ln();
            let theirs = a.1 * (b.1 / a.1).powf(share_of);
            let ours = stats.evaluations as f64;
            assert!(ours < share * theirs, "{} at {tol:e}: {ours} to {error:e}, not {theirs}", P::NAME);
        }
    }
    // Single runs scatter by a tenth about the line.
    check(VdpMu1000, Bdf, [(8.88e-3, 580.0), (5.92e-5, 1446.0), (2.60e-7, 3945.0)], 1.1);
    check(RobertsonUntil1e11, Bdf, [(4.67e-4, 675.0), (7.68e-6, 1474.0), (1.73e-8, 3800.0)], 1.1);
    check(Hires, Bdf, [(5.17e-3, 378.0), (2.77e-5, 829.0), (1.98e-8, 1691.0)], 1.1);
    check(Orego, Bdf, [(2.43e-1, 1372.0), (1.05e-4, 3649.0), (1.86e-7, 7530.0)], 1.1);
    check(Lorenz63, Adams, [(6.83e-1, 528.0), (1.01e-4, 1560.0), (1.60e-7, 3366.0)], 1.1);
    check(KeplerE06, Adams, [(6.49e-1, 216.0), (1.86e-4, 545.0), (1.14e-6, 1218.0)], 1.1);
}

/// y' = A (y - g) + g' with A = ((-d, w), (-w, -d)): the solution is smooth, and errors turn w times in a unit of time.
fn turning(damping: f64, speed: f64, tol: f64) -> Solution<[f64; 2]> {
    let f = move |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        let (a, b, slope) = (y[0] - t.sin(), y[1] - t.sin(), t.cos());
        *dy = [speed * b - damping * a + slope, -speed * a - damping * b + slope];
    };
    let j = move |_: f64, _: &[f64; 2], j: &mut Jacobian<f64>| {
        (j[(0, 0)], j[(0, 1)], j[(1, 0)], j[(1, 1)]) = (-damping, speed, -speed, -damping);
    };
    solve(f, [0.0; 2], 0.0..100.0).jacobian(j).with(Bdf).rtol(tol).atol(tol).run().unwrap()
}

#[test]
fn the_order_falls_where_a_stiff_oscillation_would_be_amplified() {
    for damping in [1.0, 10.0] {
        for tol in [1e-3, 1e-6, 1e-9] {
            let s = turning(damping, 1000.0, tol);
            let off = s.y.iter().map(|y| (y - 100f64.sin()).abs()).fold(0.0, f64::max);
            assert!(off < tol, "{damping}, {tol:e}: off by {off:e}");
            // Steps that follow the sine. With the order held high they stay where h w is less than one, which takes
            // a hundred thousand.
            assert!(s.stats.accepted < 6000, "{damping}, {tol:e}: {:?}", s.stats);
        }
    }
}

#[test]
fn a_complex_oscillation_is_seen_as_well() {
    let lambda = Complex::new(-1.0, 1000.0);
    let f = move |t: f64, y: &[Complex<f64>; 1], dy: &mut [Complex<f64>; 1]| {
        dy[0] = lambda * (y[0] - t.sin()) + t.cos();
    };
    let j = move |_: f64, _: &[Complex<f64>; 1], j: &mut Jacobian<Complex<f64>>| j[(0, 0)] = lambda;
    let run = solve(f, [Complex::new(0.0, 0.0)], 0.0..100.0).jacobian(j).with(Bdf);
    let s = run.rtol(1e-9).atol(1e-9).run().unwrap();
    assert!((s.y[0] - 100f64.sin()).norm() < 1e-9 && s.stats.accepted < 6000, "{:?}", s.stats);
}

/// y = (sin t, cos t).
fn circle(_: f64, y: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [y[1], -y[0]];
}

fn distance(y: &[f64; 2], t: f64) -> f64 {
    (y[0] - t.sin()).abs().max((y[1] - t.cos()).abs())
}

#[test]
fn values_between_steps_are_as_good_as_those_at_their_ends() {
    fn check<M: Method>(method: M, (t0, t1): (f64, f64)) {
        let times: Vec<_> = (0..=400).map(|i| t0 + (t1 - t0) * f64::from(i) / 400.0).collect();
        for tol in [1e-4, 1e-7, 1e-10] {
            let run = || solve(circle, [t0.sin(), t0.cos()], t0..t1).with(method.clone()).rtol(tol).atol(tol);
            let (at, ends) = (run().at(&times).run().unwrap(), run().every_step().run().unwrap());
            let largest = |s: &Solution<[f64; 2]>| {
                s.ts.iter().zip(&s.ys).map(|(&t, y)| distance(y, t)).fold(0.0, f64::max)
            };
            let (between, end) = (largest(&at), largest(&ends));
            assert_eq!(at.stats, ends.stats);
            assert!(between < 2.0 * end + tol, "{}: {between:e}, {end:e}", method.name());
            // The phase drifts through three turns, in the order at most five of BDF by the most.
            assert!(end < 1000.0 * tol, "{} at {tol:e}: {end:e}", method.name());
        }
    }
    for span in [(0.0, 20.0), (20.0, 0.0)] {
        check(Bdf, span);
        check(Adams, span);
    }
    let s = solve(circle, [0.0, 1.0], 0.0..1.0).with(Adams).run().unwrap();
    assert_eq!(s.interpolant, Interpolant::Nordsieck { lowest: 1, highest: 12 });
    assert_eq!(s.interpolant.order(), 1);
}

#[test]
fn a_run_starts_with_order_one_and_a_step_that_holds() {
    fn check<M: Method>(method: M) {
        let run = || solve(circle, [0.0, 1.0], 0.0..10.0).with(method.clone()).rtol(1e-8).atol(1e-8);
        let first = run().steps().next().unwrap().unwrap();
        // Euler's error of a first step is h^2/2.
        assert!(first.0 < 2e-4 && distance(&first.1, first.0) < 1e-8, "{first:?}");
        let stopped = run().max_steps(2).run().unwrap_err();
        assert!(stopped.solution.stats.order <= 2 && stopped.why == Why::TooManySteps { attempts: 2 });
        // A first step that is much too long is cut, and does no harm.
        let s = run().first_step(5.0).run().unwrap();
        assert!(s.stats.rejected.total() > 0 && distance(&s.y, 10.0) < 3e-6, "{:?}", s.stats);
        // Steps are bounded, and the order rises all the same.
        let s = run().max_step(0.01).run().unwrap();
        assert!(s.stats.accepted >= 1000 && s.stats.order >= 3 && distance(&s.y, 10.0) < 1e-6);
    }
    check(Bdf);
    check(Adams);
}

#[test]
fn breaks_events_and_changes_start_anew() {
    fn check<M: Method>(method: M) {
        // A saw: the slope turns at every whole time.
        let saw = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| {
            dy[0] = if t.rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 }
        };
        let breaks: Vec<_> = (1..10).map(f64::from).collect();
        let s = solve(saw, [0.0], 0.0..9.5).with(method.clone()).breaks(&breaks).run().unwrap();
        assert!((s.y[0] - 0.5).abs() < 1e-12 && s.stats.rejected.total() == 0, "{:?}, {:?}", s.y, s.stats);
        let run = solve(circle, [0.0, 1.0], 0.0..10.0).with(method.clone()).rtol(1e-9).atol(1e-9);
        // Turned back by a quarter at each maximum: it never comes down.
        let s = run.change_at(Crossing::Falling, |_, y| y[1], |_, y| *y = [0.0, 1.0]).run().unwrap();
        assert_eq!(s.events.len(), 6);
        let quarter = std::f64::consts::FRAC_PI_2;
        for (i, event) in s.events.iter().enumerate() {
            assert!((event.t - quarter * (i as f64 + 1.0)).abs() < 1e-6, "{}", event.t);
        }
    }
    check(Bdf);
    check(Adams);
}

#[test]
fn what_a_family_does_not_take_is_refused() {
    let entry = kutta::methods::find("bdf").unwrap();
    let read = Loaded::parse("bdf", entry.text).unwrap();
    let run = || solve(circle, [0.0, 1.0], 0.0..1.0).with(read.clone());
    for (stopped, what) in [
        (run().step(0.1).run().unwrap_err(), ".step"),
        (run().late(true).run().unwrap_err(), ".late"),
        (run().controller(Controller::I).run().unwrap_err(), ".controller"),
    ] {
        assert!(matches!(&stopped.why, Why::Invalid(text) if text.contains(what)), "{stopped}");
    }
    // Read or compiled, it is the same method.
    let (read, known) = (run().run().unwrap(), solve(circle, [0.0, 1.0], 0.0..1.0).with(Bdf).run().unwrap());
    assert_eq!((read.y, read.stats), (known.y, known.stats));
}

#[test]
fn points_outside_the_domain_and_numbers_that_are_none_cut_the_step() {
    fn check<M: Method>(method: M) {
        // y = (1 - t/2)^2 until it is zero; behind that the root is none.
        let root = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
            if y[0] < 0.0 {
                return Err(kutta::OutOfDomain);
            }
            dy[0] = -y[0].sqrt();
            Ok(())
        };
        let run = |end: f64| solve(root, [1.0], 0.0..end).with(method.clone()).rtol(1e-6).atol(1e-9);
        assert!((run(1.9).run().unwrap().y[0] - 0.0025).abs() < 1e-6);
        let nan = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = if t > 1.0 { f64::NAN } else { 1.0 };
        let stopped = solve(nan, [0.0], 0.0..2.0).with(method.clone()).run().unwrap_err();
        assert!(matches!(stopped.why, Why::NonFinite { component: 0, .. }), "{stopped}");
        assert!((stopped.t - 1.0).abs() < 1e-9 && stopped.solution.y[0] <= 1.0 + 1e-9, "{stopped}");
    }
    check(Bdf);
    check(Adams);
}

#[test]
fn every_kind_of_number_and_container_is_stepped() {
    let flat = |_: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        for (dy, y) in dy.chunks_exact_mut(2).zip(y.chunks_exact(2)) {
            (dy[0], dy[1]) = (y[1], -y[0]);
        }
    };
    // Twenty copies on the heap, in blocks that do not end with the vector.
    let y0: Vec<f64> = (0..21).flat_map(|_| [0.0, 1.0]).collect();
    let s = solve(flat, y0, 0.0..5.0).with(Adams).rtol(1e-8).atol(1e-8).run().unwrap();
    assert!(s.y.chunks_exact(2).all(|y| distance(&[y[0], y[1]], 5.0) < 1e-6), "{:?}", s.y);
    let single = |_: f32, y: &[f32; 1], dy: &mut [f32; 1]| dy[0] = -50.0 * (y[0] - 1.0);
    let s = solve(single, [0.0f32], 0.0..3.0).with(Bdf).rtol(1e-4).atol(1e-5).run().unwrap();
    assert!((s.y[0] - 1.0).abs() < 1e-3);
    let wide = |_: DoubleDouble, y: &[DoubleDouble; 1], dy: &mut [DoubleDouble; 1]| dy[0] = -y[0];
    let n = DoubleDouble::of;
    let s = solve(wide, [n(1.0)], n(0.0)..n(1.0)).with(Adams).rtol(n(1e-18)).atol(n(1e-18)).run().unwrap();
    // 1/e to 32 digits.
    let e = kutta::tableau::value("0.36787944117144232159552377016146").unwrap();
    assert!((s.y[0] - e).abs().hi() < 1e-16 && s.stats.order >= 8, "{:e}, {:?}", (s.y[0] - e).hi(), s.stats);
}

/// Correctors, errors and sectors of the members: Gear 1971, tables 9.1 and 11.1; Hairer, Wanner II, V.2.
#[test]
fn members_have_the_properties_of_the_books() {
    let of = |name: &str| kutta::methods::find(name).unwrap().tableau().properties();
    let (bdf, adams) = (of("bdf"), of("adams"));
    let orders = |p: &kutta::tableau::Properties| p.members.iter().map(|m| m.order).collect::<Vec<_>>();
    assert_eq!((orders(&bdf), orders(&adams)), ((1..=5).collect(), (1..=12).collect()));
    for (m, alpha) in bdf.members.iter().zip([90.0, 90.0, 86.03, 73.35, 51.84]) {
        assert!((m.alpha - alpha).abs() < 0.01 && m.at_infinity == 0.0, "{m:?}");
        assert!((m.error_constant + 1.0 / (m.order as f64 + 1.0)).abs() < 1e-15, "{m:?}");
    }
    assert!((bdf.members[1].l[0].hi() - 2.0 / 3.0).abs() < 1e-16);
    // Backward Euler and the trapezoid are A-stable, no other formula of Adams and Moulton is.
    let sectors: Vec<_> = adams.members.iter().map(|m| m.alpha == 90.0).collect();
    assert_eq!(sectors.iter().filter(|&&a| a).count(), 2, "{sectors:?}");
    let third: Vec<_> = adams.members[2].l.iter().map(|l| l.hi()).collect();
    assert_eq!(third, [5.0 / 12.0, 1.0, 0.75, 1.0 / 6.0]);
}
