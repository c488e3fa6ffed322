//! Stiff problems and implicit stages: every method that steps them, on what breaks such codes.

use kutta::compare::hard;
use kutta::problems::{Equation, Problem, RobertsonUntil40, Visit, visit_all};
use kutta::tableau::Stages;
use kutta::{Ivp, Jacobian, Loaded, Method, OutOfDomain, Solution, Stopped, System, Why, methods, solve};

/// Methods with implicit stages.
fn implicit() -> Vec<Loaded> {
    let loaded = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
    loaded.filter(|m| m.form().d == 1 && !m.form().explicit()).collect()
}

fn property(name: &str) -> kutta::tableau::Properties {
    methods::find(name).unwrap().tableau().properties()
}

struct Contest {
    /// Low orders run out of steps, Gauss methods do not damp, and parts of f evaluated apart see stiffness. All others
    /// get there, which those who are weak need not.
    methods: Vec<(Loaded, bool)>,
    met: usize,
}

impl Visit for Contest {
    fn visit<P: Problem>(&mut self, problem: P) {
        let (true, Some(reference)) = (P::STIFF && problem.n() <= 100, problem.reference()) else { return };
        self.met += 1;
        let mut cases = hard::cases().into_iter();
        // Its jumps are declared below.
        let name =
            if problem.breaks().is_empty() { P::NAME.to_string() } else { format!("{}-declared", P::NAME) };
        let case = cases.find(|case| case.name == name).expect("a stiff problem is a hard one");
        let (t0, t1) = problem.span();
        for (method, weak) in &self.methods {
            let (tol, name) = (if method.form().order < 4 { 1e-4 } else { 1e-6 }, method.name());
            let small = 1e-2 * problem.scale();
            let run = Ivp::new(Equation(problem.clone()), problem.y0(), t0..t1).with(method.clone());
            let run = run.breaks(problem.breaks());
            let most = match weak {
                false => 10_000,
                // A matrix of a hundred columns takes an unoptimised build a thousandth of a second.
                true if problem.n() > 50 => 30,
                true => 1500,
            };
            match run.rtol(tol).atol(tol * small).max_steps(most).run() {
                Ok(s) => {
                    let off = |(y, r): (&f64, &f64)| (y - r).abs() / (r.abs() + small);
                    let worst = s.y.as_ref().iter().zip(reference.as_ref()).map(off).fold(0.0, f64::max);
                    let bound = case.allowed(method, tol).0 * tol;
                    assert!(worst < bound, "{name} on {}: off by {worst:e}, {:?}", P::NAME, s.stats);
                }
                // Its sums are beyond a product with a Jacobian.
                Err(stopped) if matches!(stopped.why, Why::Rounding { .. }) => {
                    let linear = matches!(method.form().stages(), Stages::Linear);
                    assert!(linear && P::NAME.starts_with("e5"), "{name} on {}: {stopped}", P::NAME);
                }
                Err(stopped) => {
                    assert!(*weak, "{name} on {}: {stopped}", P::NAME);
                    assert!(matches!(stopped.why, Why::TooManySteps { .. }), "{name}: {stopped}");
                }
            }
        }
    }
}

#[test]
fn every_adaptive_method_solves_the_stiff_problems_or_says_that_it_does_not() {
    let weak =
        |m: &Loaded| property(m.name()).l_stable != Some(true) || m.form().order < 5 || m.form().split();
    let adaptive = implicit().into_iter().filter(|m| m.form().adaptive());
    let mut contest = Contest { methods: adaptive.map(|m| (m.clone(), weak(&m))).collect(), met: 0 };
    assert!(contest.methods.len() > 30, "{}", contest.methods.len());
    visit_all(&mut contest);
    assert!(contest.met > 10, "{}", contest.met);
}

#[test]
fn a_stable_methods_damp_whatever_is_fast() {
    let mut count = [0, 0];
    for method in implicit() {
        let p = property(method.name());
        if p.a_stable != Some(true) {
            continue;
        }
        // h lambda = -1e10, and 1e10 i.
        let fast = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -1e11 * y[0];
        let run = solve(fast, [1.0], 0.0..2.0).with(method.clone()).step(0.1).run();
        let end = run.unwrap_or_else(|e| panic!("{}: {e}", method.name())).y[0].abs();
        // Rounding of h lambda times the amplification: 20 steps of 1e10 spacings, times the sum of the weights.
        assert!(end <= 1.0 + 1e-3, "{}: {end}", method.name());
        count[0] += 1;
        if p.l_stable == Some(true) {
            assert!(end < 1e-8, "{}: {end}", method.name());
            count[1] += 1;
        }
        let turn = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-1e11 * y[1], 1e11 * y[0]];
        let run = solve(turn, [1.0, 0.0], 0.0..2.0).with(method.clone()).step(0.1).run();
        let [x, y] = run.unwrap_or_else(|e| panic!("{}: {e}", method.name())).y;
        assert!(x.hypot(y) <= 1.0 + 1e-3, "{}: {x} {y}", method.name());
    }
    assert!(count[0] > 25 && count[1] > 12, "{count:?}");
}

#[test]
fn differences_serve_where_no_jacobian_is_given() {
    let p = RobertsonUntil40;
    // A family that is not damped takes no Jacobian.
    let takes = |m: &Loaded| m.form().orders == 0 || m.form().damped;
    let high = |m: &Loaded| m.form().adaptive() && m.form().order > 3;
    for method in implicit().into_iter().filter(|m| high(m) && takes(m)) {
        let run = |given: bool| -> Solution<[f64; 3]> {
            let f = |t: f64, y: &[f64; 3], dy: &mut [f64; 3]| p.rhs(t, y, dy);
            let ivp = solve(f, p.y0(), 0.0..40.0).with(method.clone()).rtol(1e-6).atol(1e-10);
            match given {
                false => ivp.run().unwrap(),
                true => {
                    let add = |t: f64, y: &[f64; 3], j: &mut Jacobian<f64>| {
                        p.jacobian(t, y, |row, column, value| j[(row, column)] += value);
                    };
                    ivp.jacobian(add).run().unwrap()
                }
            }
        };
        let (exact, near) = (run(true), run(false));
        for (a, b) in exact.y.iter().zip(&near.y) {
            assert!((a - b).abs() < 1e-5 * a.abs(), "{}: {a:e} {b:e}", method.name());
        }
        assert!(exact.stats.jacobians > 0);
        assert!(near.stats.evaluations > exact.stats.evaluations, "{}", method.name());
        // Both see nearly the same derivatives, so nearly the same steps.
        let ratio = near.stats.accepted as f64 / exact.stats.accepted as f64;
        assert!((0.8..1.25).contains(&ratio), "{}: {ratio}", method.name());
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

fn stopped(run: Result<Solution<[f64; 1]>, Stopped<[f64; 1]>>) -> Stopped<[f64; 1]> {
    run.map(|s| s.t).expect_err("it cannot reach the end")
}

#[test]
fn a_singular_matrix_is_told() {
    // I - h J is zero for h = 0.1, J = 10.
    let grow = || Ivp::new(Linear { lambda: 10.0, j: 10.0 }, [1.0], 0.0..1.0);
    let stop = stopped(grow().with(methods::BackwardEuler).step(0.1).run());
    assert_eq!((stop.why, stop.t), (Why::Singular { component: 0 }, 0.0));
    assert_eq!(stop.solution.stats.rejected.singular, 1);
    // An adaptive run takes another step: gamma of sdirk4-hw is 1/4.
    let run = grow().with(methods::Sdirk4Hw).first_step(0.4).rtol(1e-6).run().unwrap();
    assert_eq!(run.stats.rejected.singular, 1);
    assert!((run.y[0] / 10f64.exp() - 1.0).abs() < 1e-4);
}

#[test]
fn a_jacobian_that_is_not_finite_is_told() {
    let bad = || Ivp::new(Linear { lambda: -1.0, j: f64::NAN }, [1.0], 0.0..1.0);
    let stop = stopped(bad().with(methods::Rodas4).run());
    assert_eq!(stop.why, Why::Jacobian { component: 0 });
    let stop = stopped(bad().with(methods::Kvaerno5).run());
    assert!(stop.solution.stats.rejected.non_finite > 0, "{:?}", stop.solution.stats);
    let stop = stopped(bad().with(methods::RadauIia3).run());
    assert!(stop.solution.stats.rejected.non_finite > 0, "{:?}", stop.solution.stats);
}

#[test]
fn a_jacobian_of_the_wrong_sign_costs_steps_and_no_digits() {
    // Newton's iteration diverges with long steps; with short ones it converges all the same.
    let run = Ivp::new(Linear { lambda: -50.0, j: 50.0 }, [1.0], 0.0..1.0).with(methods::Kvaerno5);
    let run = run.rtol(1e-6).atol(1e-12).first_step(0.5).run().unwrap();
    assert!(run.stats.rejected.newton > 0, "{:?}", run.stats);
    assert!((run.y[0] - (-50f64).exp()).abs() < 1e-10);
}

#[test]
fn a_rosenbrock_method_sees_the_time() {
    // y' = -1000 (y - sin t) + cos t follows sin t.
    let f = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -1000.0 * (y[0] - t.sin()) + t.cos();
    for method in implicit().into_iter().filter(|m| matches!(m.form().stages(), Stages::Linear)) {
        if !method.form().adaptive() {
            continue;
        }
        let run = solve(f, [0.0], 0.0..3.0).with(method.clone()).rtol(1e-5).atol(1e-5).run().unwrap();
        assert!((run.y[0] - 3f64.sin()).abs() < 1e-4, "{}: {:e}", method.name(), run.y[0] - 3f64.sin());
    }
}

#[test]
fn large_systems_run_on_the_heap_like_small_ones_on_the_stack() {
    let p = RobertsonUntil40;
    let small = solve(|t, y: &[f64; 3], dy: &mut [f64; 3]| p.rhs(t, y, dy), p.y0(), 0.0..40.0);
    let small = small.with(methods::Rodas5p).rtol(1e-6).atol(1e-10).run().unwrap();
    let f = |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        let mut d = [0.0; 3];
        p.rhs(t, &[y[0], y[1], y[2]], &mut d);
        dy.copy_from_slice(&d);
    };
    let large =
        solve(f, p.y0().to_vec(), 0.0..40.0).with(methods::Rodas5p).rtol(1e-6).atol(1e-10).run().unwrap();
    assert_eq!(small.y.to_vec(), large.y);
    assert_eq!(small.stats, large.stats);
}
