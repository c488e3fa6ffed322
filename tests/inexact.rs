//! Approximate Jacobians: W-methods keep their orders with any matrix, methods that iterate correct it, all others
//! are refused.

use kutta::problems::{Problem, RobertsonUntil40};
use kutta::tableau::DoubleDouble as D;
use kutta::{Jacobian, Loaded, Method, OutOfDomain, Stopped, System, Why, methods, solve};

type State = [D; 2];

fn n(x: f64) -> D {
    D::of(x)
}

/// u = 1/sqrt(1 + t^2) and w = t u.
fn f(t: D, [u, w]: &State, dy: &mut State) {
    *dy = [-(t * u.powi(3)), *u * (n(1.0) - *w * *w)];
}

fn exact(t: D) -> State {
    let u = n(1.0) / (n(1.0) + t * t).sqrt();
    [u, t * u]
}

/// Far from df/dy: 0.7 of it, and as much again that has nothing to do with it.
fn wrong(t: D, [u, w]: &State, j: &mut Jacobian<D>) {
    j[(0, 0)] = n(-2.1) * t * *u * *u + n(0.3);
    j[(0, 1)] = n(-0.2);
    j[(1, 0)] = n(0.7) * (n(1.0) - *w * *w) + n(0.5);
    j[(1, 1)] = n(-1.4) * *u * *w + n(0.1);
}

fn nothing(_t: D, _y: &State, _j: &mut Jacobian<D>) {}

fn rosenbrock() -> impl Iterator<Item = Loaded> {
    let loaded = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
    loaded.filter(|m| m.form().linear)
}

fn named(name: &str) -> Loaded {
    Loaded::parse(name, methods::find(name).unwrap().text).unwrap()
}

/// The slope between the errors at the end of 128 and of 256 steps.
fn order(method: &Loaded, matrix: fn(D, &State, &mut Jacobian<D>)) -> f64 {
    let error = |steps: usize| {
        // Told that it is df/dy, a method of any kind takes it.
        let run = solve(f, exact(n(0.0)), n(0.0)..n(1.5)).with(method.clone()).jacobian(matrix);
        let y = run.step(n(1.5) / n(steps as f64)).run().unwrap().y;
        let exact = exact(n(1.5));
        (y[0] - exact[0]).abs().hi().max((y[1] - exact[1]).abs().hi())
    };
    (error(128) / error(256)).log2()
}

#[test]
fn the_order_that_is_derived_is_the_order_that_is_left() {
    let mut w_methods = vec![];
    for method in rosenbrock() {
        let left = method.form().inexact.step;
        let found = order(&method, wrong);
        assert!((found - left as f64).abs() < 0.2, "{}: order {found:.2}, not {left}", method.name());
        if left == method.form().order {
            // No matrix at all makes an explicit method of it.
            let found = order(&method, nothing);
            assert!(found > left as f64 - 0.2, "{}: order {found:.2} without a matrix", method.name());
            w_methods.push(method.name().to_string());
        }
    }
    assert_eq!(w_methods, ["ros2", "ros34prw", "ros34pw2", "rosenbrock23-shampine"]);
}

/// The least tolerance that accepts one step is its error estimate, which falls with the order of the embedded
/// solution and one more.
#[test]
fn the_estimate_has_the_order_that_is_derived() {
    for name in ["ros2", "ros34pw2", "ros34prw"] {
        let method = named(name);
        let estimate = |h: f64| {
            let accepts = |exponent: f64| {
                let run = solve(f, exact(n(0.25)), n(0.25)..n(0.25 + h)).with(method.clone()).jacobian(wrong);
                run.rtol(n(0.0)).atol(n(exponent.exp2())).first_step(n(h)).max_steps(1).run().is_ok()
            };
            let (mut below, mut above) = (-100.0, 10.0);
            assert!(!accepts(below) && accepts(above), "{name}");
            while above - below > 1e-3 {
                let middle = 0.5 * (below + above);
                if accepts(middle) { above = middle } else { below = middle }
            }
            above
        };
        let found = estimate(1.0 / 256.0) - estimate(1.0 / 512.0);
        let left = method.form().inexact.embedded[0] + 1;
        assert!((found - left as f64).abs() < 0.2, "{name}: {found:.2}, not {left}");
    }
}

/// A matrix near df/dy of Robertson's problem: its entries are off by a fifth, and two are left out.
fn near(_t: f64, y: &[f64; 3], j: &mut Jacobian<f64>) {
    let [fast, back] = [0.8 * 6e7 * y[1], 0.8 * 1e4 * y[2]];
    (j[(0, 0)], j[(0, 1)]) = (-0.032, back);
    (j[(1, 0)], j[(1, 1)]) = (0.032, -fast - back);
    j[(2, 1)] = fast;
}

fn robertson(t: f64, y: &[f64; 3], dy: &mut [f64; 3]) {
    Problem::rhs(&RobertsonUntil40, t, y, dy);
}

fn right(t: f64, y: &[f64; 3], j: &mut Jacobian<f64>) {
    Problem::jacobian(&RobertsonUntil40, t, y, |i, k, x| j[(i, k)] += x);
}

fn off(y: &[f64; 3]) -> f64 {
    let reference = RobertsonUntil40.reference().unwrap();
    y.iter().zip(&reference).map(|(y, r)| ((y - r) / r).abs()).fold(0.0, f64::max)
}

#[test]
fn iterations_correct_the_matrix() {
    for name in ["radau-iia3", "radau-iia5", "kvaerno5", "kencarp4-esdirk", "bdf"] {
        let ivp = || solve(robertson, [1.0, 0.0, 0.0], 0.0..40.0).with(named(name)).rtol(1e-6).atol(1e-12);
        let best = ivp().jacobian(right).run().unwrap();
        let run = ivp().approximate_jacobian(near).run().unwrap_or_else(|e| panic!("{name}: {e}"));
        // What is left of the iterations is below what the error test lets pass.
        assert!(off(&run.y) < 3e-5 && off(&best.y) < 3e-5, "{name}: {:e} {:e}", off(&run.y), off(&best.y));
        assert!(run.stats.iterations > best.stats.iterations, "{name}: {:?}", run.stats);
        assert!(run.stats.accepted < 10 * best.stats.accepted, "{name}: {:?}", run.stats);
    }
}

#[test]
fn a_w_method_solves_a_stiff_problem_with_it() {
    let ivp = solve(robertson, [1.0, 0.0, 0.0], 0.0..40.0).with(methods::Ros34pw2);
    let run = ivp.rtol(1e-6).atol(1e-12).approximate_jacobian(near).run().unwrap();
    assert!(off(&run.y) < 3e-5, "{:e} {:?}", off(&run.y), run.stats);
}

#[test]
fn where_no_method_is_named_one_that_iterates_is_taken() {
    let ivp = solve(robertson, [1.0, 0.0, 0.0], 0.0..40.0).rtol(1e-6).atol(1e-12);
    let run = ivp.approximate_jacobian(near).run().unwrap();
    let names: Vec<_> = run.choices.iter().map(|choice| choice.method.as_str()).collect();
    assert_eq!(names[..2], ["tsit54", "radau-iia5"], "{:?}", run.choices);
    assert!(off(&run.y) < 3e-5, "{:e} {:?}", off(&run.y), run.stats);
    // With a mass matrix it is there from the start.
    let ivp = solve(robertson, [1.0, 0.0, 0.0], 0.0..1.0).mass(|m| (0..3).for_each(|i| m[(i, i)] = 1.0));
    let run = ivp.approximate_jacobian(near).run().unwrap();
    assert_eq!((run.choices.len(), run.choices[0].method.as_str()), (1, "radau-iia5"));
}

fn refusal<Y: kutta::State>(run: Result<kutta::Solution<Y>, Stopped<Y>>) -> String {
    match run.map_err(|stopped| stopped.why) {
        Err(Why::Invalid(text)) => text,
        Err(why) => panic!("{why}"),
        Ok(run) => panic!("ran: {:?}", run.stats),
    }
}

#[test]
fn a_method_that_needs_the_jacobian_is_refused() {
    let ivp = || solve(robertson, [1.0, 0.0, 0.0], 0.0..1.0).approximate_jacobian(near);
    assert_eq!(
        refusal(ivp().with(methods::Rodas4).run()),
        "rodas4 needs the Jacobian itself: with an approximate one the order of its step falls from 4 to 1. Take a \
         method that iterates, such as radau-iia5, or a W-method, such as ros34pw2"
    );
    let text = refusal(ivp().with(methods::Rodas5p).step(0.1).run());
    assert!(text.starts_with("rodas5p needs the Jacobian itself"), "{text}");
    // Its steps keep their order, the choice of their sizes would not.
    let text = refusal(ivp().with(methods::Ros34prw).run());
    assert!(text.contains("the order of its error estimate falls from 2 to 1"), "{text}");
    assert!(ivp().with(methods::Ros34prw).step(1e-4).run().is_ok());
    // A later Jacobian is the one that counts.
    assert!(ivp().jacobian(right).with(methods::Rodas4).run().is_ok());
}

/// A system that says so itself.
struct Near;

impl System<[f64; 3]> for Near {
    fn rhs(&mut self, t: f64, y: &[f64; 3], dy: &mut [f64; 3]) -> Result<(), OutOfDomain> {
        robertson(t, y, dy);
        Ok(())
    }
    fn jacobian(&mut self, t: f64, y: &[f64; 3], j: &mut Jacobian<f64>) -> bool {
        near(t, y, j);
        true
    }
    fn is_approximate(&self) -> bool {
        true
    }
}

#[test]
fn a_system_can_say_that_its_jacobian_is_an_approximate_one() {
    let ivp = || kutta::Ivp::new(Near, [1.0, 0.0, 0.0], 0.0..1.0);
    let text = refusal(ivp().with(methods::Rodas5).run());
    assert!(text.contains("the order of its step falls from 5 to 1"), "{text}");
    assert!(ivp().with(methods::Ros34pw2).run().is_ok());
}

#[test]
fn a_mass_matrix_must_have_an_inverse() {
    // M = [1 1; 0 2]: M y' = f is y' = M^-1 f, and no matrix is exact.
    let f = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-100.0 * y[0] + y[1], -2.0 * y[1] * y[1]];
    let near = |_t: f64, _y: &[f64; 2], j: &mut Jacobian<f64>| j[(0, 0)] = -90.0;
    let ivp = || solve(f, [1.0, 1.0], 0.0..1.0).rtol(1e-7).atol(1e-9).approximate_jacobian(near);
    let regular = |m: &mut kutta::Mass<f64>| (m[(0, 0)], m[(0, 1)], m[(1, 1)]) = (1.0, 1.0, 2.0);
    for name in ["ros34pw2", "radau-iia3", "kvaerno5"] {
        let run = ivp().with(named(name)).mass(regular).run().unwrap_or_else(|e| panic!("{name}: {e}"));
        // y2' = -y2^2.
        assert!((run.y[1] - 0.5).abs() < 1e-5, "{name}: {:?}", run.y);
    }
    for name in ["ros34pw2", "radau-iia3"] {
        let text = refusal(ivp().with(named(name)).mass(|m| (m[(0, 0)], m[(0, 1)]) = (1.0, 1.0)).run());
        assert!(text.starts_with("the mass matrix is singular"), "{text}");
    }
    // What starts a multistep method is held to the same.
    let bdf = ivp().with(methods::Bdf3).mass(regular).step(1e-3);
    let text = refusal(bdf.start_with(methods::Rodas4).run());
    assert!(text.starts_with("rodas4 needs the Jacobian itself"), "{text}");
}
