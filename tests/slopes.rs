//! The observed order of every method that can be stepped: halving the step divides the error by 2^order.
//!
//! In double-double, so that order nine shows before rounding does; read at run time, so that one program
//! steps them all. What the order proofs claim of the numbers is seen here in what the stepper makes of them.

use kutta::tableau::{DoubleDouble as D, Meaning};
use kutta::{Interpolant, Loaded, Method, Solution, methods};
use std::sync::LazyLock;

type State = [D; 2];

/// y' = f(t, y), nonlinear and not autonomous, with its solution.
struct First {
    f: fn(D, &State, &mut State),
    exact: fn(D) -> State,
    span: [f64; 2],
}

/// y'' = f(t, y), with its solution and the derivative of that.
struct Second {
    f: fn(D, &State, &mut State),
    exact: fn(D) -> State,
    slope: fn(D) -> State,
    span: [f64; 2],
}

fn n(x: f64) -> D {
    D::of(x)
}

/// u(t) = 1/sqrt(1 + t^2).
fn u(t: D) -> D {
    n(1.0) / (n(1.0) + t * t).sqrt()
}

const FIRST: [First; 2] = [
    // u = 1/sqrt(1 + t^2) and w = t u.
    First {
        f: |t, [u, w], dy| *dy = [-(t * u.powi(3)), *u * (n(1.0) - *w * *w)],
        exact: |t| [u(t), t * u(t)],
        span: [0.0, 1.5],
    },
    // a = 1/(1 + t) and c = 1/(1 + t^2), each leaning on the other, backwards in time.
    First {
        f: |t, [a, c], dy| {
            let one = *c * (n(1.0) + t * t);
            *dy = [-(*a * *a * one), -(n(2.0) * t * *c * *c * *a * (n(1.0) + t))]
        },
        exact: |t| [n(1.0) / (n(1.0) + t), n(1.0) / (n(1.0) + t * t)],
        span: [2.0, 0.25],
    },
];

const SECOND: [Second; 2] = [
    // u = 1/sqrt(1 + t^2) and w = t u.
    Second {
        f: |t, [u, w], a| *a = [u.powi(3) * (n(3.0) * *w * *w - n(1.0)), -(n(3.0) * t * u.powi(5))],
        exact: |t| [u(t), t * u(t)],
        slope: |t| [-(t * u(t).powi(3)), u(t).powi(3)],
        span: [0.0, 1.5],
    },
    // y = 1/(1 + t) and z = 1/(2 + t), backwards in time.
    Second {
        f: |t, [y, z], a| {
            let one = *y * (n(1.0) + t);
            *a = [(*y + *y) * *y / (n(1.0) + t), (*z + *z) * *z * *z * one * one]
        },
        exact: |t| [n(1.0) / (n(1.0) + t), n(1.0) / (n(2.0) + t)],
        slope: |t| [-(n(1.0) / (n(1.0) + t).powi(2)), -(n(1.0) / (n(2.0) + t).powi(2))],
        span: [2.0, 0.5],
    },
];

/// Every method that can be stepped.
static METHODS: LazyLock<Vec<Loaded>> =
    LazyLock::new(|| methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok()).collect());

fn of(d: usize) -> impl Iterator<Item = &'static Loaded> {
    METHODS.iter().filter(move |method| method.form().d == d)
}

/// Steps that lie behind the first step of the method itself.
fn behind(method: &Loaded) -> usize {
    let form = method.form();
    let age = |m: &Meaning| match *m {
        Meaning::Y(k) | Meaning::F(k) => k,
        Meaning::V => 0,
    };
    form.means[..form.r].iter().map(age).max().unwrap_or(0)
}

fn distance(a: &State, b: &State) -> f64 {
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().hi()).fold(0.0, f64::max)
}

/// The slope between the errors of two steps, one half the other. Steps are halved until the error nears
/// rounding, which leaves 1e-31 for each of some hundred steps, or are small enough for any leading term to
/// outweigh the next.
fn order(least: usize, error: impl Fn(usize) -> f64) -> f64 {
    let (mut steps, mut coarse) = (least, error(least));
    loop {
        steps *= 2;
        let fine = error(steps);
        if fine < 1e-25 || steps >= 2048 {
            assert!(fine > 1e-29, "the error {fine:e} is rounding: begin with larger steps");
            return (coarse / fine).log2();
        }
        coarse = fine;
    }
}

fn assert_order(found: f64, claimed: usize, what: &str) {
    assert!((found - claimed as f64).abs() < 0.2, "{what}: order {found:.2}, not {claimed}");
}

fn solve_first(p: &First, method: &Loaded, steps: usize, span: [D; 2], times: &[D]) -> Solution<State> {
    let h = (span[1] - span[0]).abs() / n(steps as f64);
    let run = kutta::solve(p.f, (p.exact)(span[0]), span[0]..span[1]).with(method.clone()).step(h);
    run.at(times).every_step().run().expect(method.name())
}

fn solve_second(p: &Second, method: &Loaded, steps: usize, span: [D; 2], times: &[D]) -> Solution<State> {
    let h = (span[1] - span[0]).abs() / n(steps as f64);
    let run = kutta::solve_second(p.f, (p.exact)(span[0]), (p.slope)(span[0]), span[0]..span[1]);
    run.with(method.clone()).step(h).at(times).run().expect(method.name())
}

#[test]
fn every_first_order_method_has_its_order() {
    let mut tried = 0;
    for method in of(1) {
        for (i, p) in FIRST.iter().enumerate() {
            let error = |steps| {
                let s = solve_first(p, method, steps, p.span.map(D::of), &[]);
                s.ts.iter().zip(&s.ys).map(|(&t, y)| distance(y, &(p.exact)(t))).fold(0.0, f64::max)
            };
            let found = order(16, error);
            println!("{} {i}: {found:.3} of {}", method.name(), method.form().order);
            let _ = found;
            tried += 1;
        }
    }
    assert!(tried >= 2 * 30, "only {tried} runs");
}
