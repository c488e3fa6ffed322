//! The method that is chosen in the course of a run, where none is named.

use kutta::methods::{Tsit54, Verner87Efficient};
use kutta::problems::{Equation, Lorenz63, Problem, RobertsonUntil40, VdpMu1000, Visit, visit_all};
use kutta::{Auto, Crossing, Ivp, Reason, solve};

/// Largest error at the end, relative to the component and the scale.
fn miss(y: &[f64], reference: &[f64], small: f64) -> f64 {
    y.iter().zip(reference).map(|(y, r)| (y - r).abs() / (r.abs() + small)).fold(0.0, f64::max)
}

struct Catalogue {
    stiff: usize,
    plain: usize,
}

impl Visit for Catalogue {
    fn visit<P: Problem>(&mut self, problem: P) {
        let Some(reference) = problem.reference().filter(|_| problem.n() <= 50) else { return };
        let (tol, small) = (1e-6, 1e-2 * problem.scale());
        let (t0, t1) = problem.span();
        let ivp = Ivp::new(Equation(problem.clone()), problem.y0(), t0..t1);
        let run = ivp.rtol(tol).atol(tol * small).run().unwrap_or_else(|e| panic!("{}: {e}", P::NAME));
        assert_eq!(run.choices[0].reason, Reason::Start, "{}", P::NAME);
        // Curtiss-Hirschfelder's rate of 50 over one unit of time is not worth a Jacobian, and the undamped spring
        // asks for small steps by accuracy, and so does a jump: all are called stiff, none limits the steps here.
        if P::STIFF && !["curtiss-hirschfelder", "stiff-spring-underdamped", "jump"].contains(&P::NAME) {
            assert!(run.choices.len() > 1, "{}: stayed explicit, {:?}", P::NAME, run.stats);
            assert!(matches!(run.choices[1].reason, Reason::Stiff { .. }), "{:?}", run.choices);
            self.stiff += 1;
            assert!(run.stats.accepted < 3000, "{}: {:?}", P::NAME, run.stats);
            // E5's end hangs on y2 = y3 + y4 to ten digits of what they were, and the tolerance asks for six.
            if !P::NAME.starts_with("e5") {
                let off = miss(run.y.as_ref(), reference.as_ref(), small);
                assert!(off < 10.0 * tol, "{}: off by {off:e}", P::NAME);
            }
        } else {
            assert_eq!(run.choices.len(), 1, "{}: {:?}", P::NAME, run.choices);
            self.plain += 1;
        }
    }
}

#[test]
fn stiff_problems_are_found_out_and_others_left_alone() {
    let mut seen = Catalogue { stiff: 0, plain: 0 };
    visit_all(&mut seen);
    assert!(seen.stiff > 8 && seen.plain > 8, "{} {}", seen.stiff, seen.plain);
}

/// y' = -k (y - cos t) - sin t, with k falling from 1e5 to 1 around t = 5.
fn fading(t: f64, y: &[f64; 1], dy: &mut [f64; 1]) {
    let k = 1.0 + 1e5 / (1.0 + (4.0 * (t - 5.0)).exp());
    dy[0] = -k * (y[0] - t.cos()) - t.sin();
}

#[test]
fn the_end_of_stiffness_is_seen_forwards_and_backwards() {
    let there = solve(fading, [1.0], 0.0..20.0).run().unwrap();
    let names: Vec<_> = there.choices.iter().map(|c| c.method.as_str()).collect();
    assert_eq!(names, ["tsit54", "rodas5p", "tsit54"], "{:?}", there.choices);
    assert!(matches!(there.choices[2].reason, Reason::NoLongerStiff { reach, limit } if reach < limit));
    assert!(there.choices[2].t > 5.0 && (there.y[0] - 20f64.cos()).abs() < 1e-5);
    // The same with time reversed.
    let mirrored = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
        fading(-t, y, dy);
        dy[0] = -dy[0];
    };
    let back = solve(mirrored, [1.0], 0.0..-20.0).run().unwrap();
    assert_eq!(back.choices.len(), 3, "{:?}", back.choices);
    // Differences are taken towards where the solution goes, so the Jacobians differ by a little.
    assert!((back.choices[2].t / there.choices[2].t + 1.0).abs() < 0.05, "{:?}", back.choices);
    assert!((back.y[0] - there.y[0]).abs() < 1e-6);
}

#[test]
fn a_choice_says_what_and_why() {
    let run = solve(fading, [1.0], 0.0..20.0).run().unwrap();
    let text: Vec<_> = run.choices.iter().map(ToString::to_string).collect();
    assert_eq!(text[0], "tsit54 from t = 0");
    assert!(text[1].starts_with("rodas5p from t = ") && text[1].contains("h |lambda| = 3."), "{}", text[1]);
    assert!(text[2].contains("would not limit"), "{}", text[2]);
}

#[test]
fn a_named_method_is_kept() {
    let run = solve(fading, [1.0], 0.0..1.0).with(Tsit54).run().unwrap();
    assert!(run.choices.is_empty() && run.stats.jacobians == 0 && run.stats.accepted > 10_000);
}

#[test]
fn the_explicit_method_may_be_another() {
    let run = solve(fading, [1.0], 0.0..20.0).with(Auto::from(Verner87Efficient)).rtol(1e-10).run().unwrap();
    let names: Vec<_> = run.choices.iter().map(|c| c.method.as_str()).collect();
    assert_eq!(names[..2], ["verner87-efficient", "radau-iia5"], "{:?}", run.choices);
    assert!((run.y[0] - 20f64.cos()).abs() < 1e-8, "{:e}", run.y[0] - 20f64.cos());
}

#[test]
fn who_looks_on_sees_one_run() {
    let p = RobertsonUntil40;
    let f = |t: f64, y: &[f64; 3], dy: &mut [f64; 3]| p.rhs(t, y, dy);
    let ivp = || solve(f, p.y0(), 0.0..40.0).rtol(1e-7).atol(1e-11);
    let whole = ivp().run().unwrap();
    assert!(whole.choices.len() == 2);
    // Step by step.
    let (mut steps, mut last) = (0, 0.0);
    for step in ivp().steps() {
        let (t, y) = step.unwrap();
        assert!(t > last && (y[0] + y[1] + y[2] - 1.0).abs() < 1e-12);
        (steps, last) = (steps + 1, t);
    }
    assert_eq!((steps, last), (whole.stats.accepted, 40.0));
    // Between steps, on both sides of the change of method.
    let times: Vec<f64> = (1..=60).map(|i| 1e-3 * 1.18f64.powi(i)).filter(|&t| t < 40.0).collect();
    let seen = ivp().at(&times).run().unwrap();
    let tight = solve(f, p.y0(), 0.0..40.0).with(kutta::methods::RadauIia5).rtol(1e-12).atol(1e-16);
    let tight = tight.at(&times).run().unwrap();
    assert_eq!((seen.ts.len(), seen.stats.accepted), (times.len(), whole.stats.accepted));
    for ((y, r), t) in seen.ys.iter().zip(&tight.ys).zip(&times) {
        // With steps at its stability limit an interpolant follows the fast component worse than the steps do.
        let bound = if *t < seen.choices[1].t { 1e-3 } else { 1e-5 };
        assert!(miss(y, r, 1e-6) < bound, "t = {t}: {y:?} {r:?}");
    }
    // Events: y1 falls through 0.8 once.
    let run = ivp().record(Crossing::Falling, |_, y| y[0] - 0.8).run().unwrap();
    assert_eq!(run.events.len(), 1);
    assert!((run.events[0].y[0] - 0.8).abs() < 1e-9);
}

#[test]
fn breaks_do_not_hide_stiffness() {
    // Seven steps a stretch at most: the count must outlive them.
    let breaks: Vec<f64> = (1..20_000).map(|i| 1e-3 * f64::from(i)).collect();
    let run = solve(fading, [1.0], 0.0..4.0).breaks(&breaks).max_step(2e-4).run().unwrap();
    assert!(run.choices.len() == 2, "{:?}", run.choices);
}

#[test]
fn many_components_have_no_dense_jacobian() {
    let n = 2001;
    let f = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        dy.iter_mut().zip(y).for_each(|(dy, y)| *dy = -1e3 * y);
    };
    let run = solve(f, vec![1.0; n], 0.0..0.2).run().unwrap();
    assert_eq!((run.choices.len(), run.stats.jacobians), (1, 0));
}

#[test]
fn a_relaxation_oscillation_changes_sides() {
    let p = VdpMu1000;
    let run = Ivp::new(Equation(p), p.y0(), 0.0..2000.0).rtol(1e-6).atol(1e-8).run().unwrap();
    assert!(run.choices.len() >= 4, "{:?}", run.choices);
    assert!(miss(&run.y, &p.reference().unwrap(), 1e-2) < 1e-5);
    let plain = Ivp::new(Equation(Lorenz63), Lorenz63.y0(), 0.0..10.0).run().unwrap();
    let named = Ivp::new(Equation(Lorenz63), Lorenz63.y0(), 0.0..10.0).with(Tsit54).run().unwrap();
    assert_eq!((plain.y, plain.stats), (named.y, named.stats));
}
