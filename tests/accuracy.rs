//! Error against tolerance: what is asked for is what is got, for every pair on every problem of the catalogue
//! that is not stiff and small enough for an unoptimised build.

use kutta::problems::{Problem, Visit, visit_all};
use kutta::{Loaded, Method, methods, solve};

/// The loosest tolerance tried, in digits, and the error at the end in units of the tolerance, at most.
///
/// A step errs by up to its tolerance. What that makes at the end is the number of steps, between ten and some
/// hundred, times what the problem makes of an error on its way.
fn expected(problem: &str) -> (i32, f64) {
    match problem {
        // Errors decay with the solution.
        "exponential-decay" => (3, 1.0),
        // Errors are kept. The 4(5) pair of Fehlberg goes on with its lower order, so that its error falls with
        // the power 4/5 of the tolerance: by 1e-9 it has lost a factor of 16.
        "harmonic-oscillator" => (3, 50.0),
        "lotka-volterra" | "rigid-body" | "vdp-mu1" => (3, 100.0),
        // Ten times in 2.5 of 10 units of time.
        "lorenz63" => (3, 1e4),
        // Three turns, each through a point of four times the least speed; an error there is one of period, and
        // grows with every turn.
        "kepler-e06" => (3, 5e3),
        // Near misses of two bodies: a tolerance of 1e-3 does not tell them from collisions.
        "pleiades" => (5, 1e4),
        // From 1e-3 beside the smaller body round once and back there: small errors grow 1e5-fold, and at 1e-3
        // nothing of the orbit is left.
        "arenstorf-4loop" => (5, 2e5),
        other => panic!("no expectation for {other}"),
    }
}

struct Ladder {
    pairs: Vec<Loaded>,
    problems: Vec<&'static str>,
}

impl Visit for Ladder {
    fn visit<P: Problem>(&mut self, problem: P) {
        if P::STIFF || problem.n() > 30 {
            return;
        }
        self.problems.push(P::NAME);
        for pair in &self.pairs {
            climb(&problem, pair);
        }
    }
}

fn climb<P: Problem>(problem: &P, pair: &Loaded) {
    let (first, factor) = expected(P::NAME);
    // Below these a pair of low order would take millions of steps.
    let last = match pair.form().order {
        2 => 5,
        3 => 7,
        4 => 9,
        _ => 11,
    };
    let digits: Vec<i32> = (first..=last).step_by(2).collect();
    let errors: Vec<f64> = digits.iter().map(|&digits| error(problem, pair, 10f64.powi(-digits))).collect();
    // Weights b are rounded, and some tables have weights of hundreds that add up to one. Rounding adds up over
    // thousands of steps and is magnified like any error.
    let row = &pair.form().carry[0];
    let weights: f64 = row.a[..row.len].iter().map(|b| b.hi().abs()).sum();
    let rounding = 1e-14 * weights * factor;
    let what = format!("{} on {}: {errors:?}", pair.name(), P::NAME);
    for (error, digits) in errors.iter().zip(&digits) {
        let bound = factor * 10f64.powi(-digits) + rounding;
        assert!(*error < bound, "{what}: beyond {bound:e}");
    }
    for pair in errors.windows(2) {
        // A hundredth of the tolerance; an error that happened to cancel is followed by one that did not.
        assert!(pair[1] < 0.5 * pair[0] || pair[1] < rounding, "{what}: no gain from less tolerance");
    }
    if let ([from, .., to], true) = (&errors[..], *errors.last().unwrap() > 10.0 * rounding) {
        let slope = (from / to).log10() / (digits[digits.len() - 1] - digits[0]) as f64;
        // Fehlberg's 4/5, and chance at both ends.
        assert!(
            slope > 0.65 && slope < 1.6,
            "{what}: error falls with the power {slope:.2} of the tolerance"
        );
    }
}

/// At the end, each component relative to the larger of its own size and the problem's scale.
fn error<P: Problem>(problem: &P, pair: &Loaded, tol: f64) -> f64 {
    let (mut y, mut dy) = (problem.y0(), problem.y0());
    let f = |t: f64, x: &Vec<f64>, dx: &mut Vec<f64>| {
        y.as_mut().copy_from_slice(x);
        problem.rhs(t, &y, &mut dy);
        dx.copy_from_slice(dy.as_ref());
    };
    let (t0, t1) = problem.span();
    let run = solve(f, problem.y0().as_ref().to_vec(), t0..t1).with(pair.clone());
    let s = run.rtol(tol).atol(tol * problem.scale()).run();
    let s = s.unwrap_or_else(|stopped| panic!("{} on {} at {tol:e}: {stopped}", pair.name(), P::NAME));
    let reference = problem.reference().expect("a problem that is not stiff has a reference");
    let relative = |(y, r): (&f64, &f64)| (y - r).abs() / r.abs().max(problem.scale());
    s.y.iter().zip(reference.as_ref()).map(relative).fold(0.0, f64::max)
}

#[test]
fn errors_follow_the_tolerance() {
    let loaded = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
    let mut ladder = Ladder {
        pairs: loaded.filter(|m| m.form().errors > 0 && m.form().explicit()).collect(),
        problems: vec![],
    };
    assert!(ladder.pairs.len() > 20, "the list of pairs is short");
    visit_all(&mut ladder);
    assert_eq!(ladder.problems.len(), 9, "{:?}", ladder.problems);
}

/// Fehlberg's 7(8) pair has an estimate of zero on pure quadrature, as its error weights belong to two pairs of
/// stages at the same times: it cannot see any error there, and takes the largest steps it may.
#[test]
fn a_blind_estimate_is_blind_on_quadrature_only() {
    let f = |t: f64, _: &[f64; 1], dy: &mut [f64; 1]| dy[0] = (20.0 * t).cos();
    let steps = |name: &str| {
        let entry = methods::find(name).unwrap();
        let pair = Loaded::parse(name, entry.text).unwrap();
        solve(f, [0.0], 0.0..30.0).with(pair).rtol(1e-9).atol(1e-9).run().unwrap().stats.accepted
    };
    assert!(steps("rkf87") < 20 && steps("dop853") > 100, "{} {}", steps("rkf87"), steps("dop853"));
    // With a bound on the steps it is as good as its order.
    let entry = methods::find("rkf87").unwrap();
    let run = solve(f, [0.0], 0.0..30.0).with(Loaded::parse("rkf87", entry.text).unwrap()).max_step(0.05);
    assert!((run.run().unwrap().y[0] - 600f64.sin() / 20.0).abs() < 1e-10);
}
