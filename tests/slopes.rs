//! The observed order of every method that can be stepped: halving the step divides the error by 2^order.
//!
//! In double-double, so that order nine shows before rounding does; read at run time, so that one program
//! steps them all. What the order proofs claim of the numbers is seen here in what the stepper makes of them.

use kutta::tableau::{DoubleDouble as D, Form, Meaning};
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
        span: [2.0, -0.25],
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

/// A method that can be stepped, and how far its numbers can be off.
struct Known {
    method: Loaded,
    digits: f64,
}

static METHODS: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let loaded = methods::all().iter().filter_map(|m| Some((Loaded::parse(m.name, m.text).ok()?, m.text)));
    // Families of variable order take no steps of one size; tests/nordsieck.rs has them.
    let fixed = loaded.filter(|(method, _)| method.form().orders == 0);
    let known = fixed.map(|(method, text)| {
        let digits = text.lines().find_map(|line| line.strip_prefix("digits")?.trim().strip_prefix('='));
        // Rounding leaves 1e-31 for each of some hundred steps.
        let digits = digits.map_or(29.0, |digits| digits.trim().parse().expect("a count of digits"));
        Known { method, digits: f64::min(digits, 29.0) }
    });
    known.collect()
});

fn of(d: usize) -> impl Iterator<Item = &'static Known> {
    METHODS.iter().filter(move |known| known.method.form().d == d)
}

impl Known {
    fn name(&self) -> &str {
        self.method.name()
    }

    fn form(&self) -> &Form {
        self.method.form()
    }

    /// Steps that lie behind the first step of the method itself.
    fn behind(&self) -> usize {
        let form = self.form();
        let age = |m: &Meaning| match *m {
            Meaning::Y(k) | Meaning::F(k) => k,
            Meaning::V | Meaning::Taylor(_) => 0,
        };
        form.means[..form.r].iter().map(age).max().unwrap_or(0)
    }

    /// The slope between the errors of two steps, one half the other. They are halved until the error nears
    /// what the digits of the numbers leave, or are small enough for the leading term to outweigh the next.
    fn order(&self, error: impl Fn(usize) -> f64) -> f64 {
        let floor = 10f64.powf(-self.digits);
        // Backward Euler has no solution at all in long steps of a problem that grows.
        let from = if !self.form().explicit() && self.form().order == 1 { 64 } else { 8 };
        let (mut per, mut coarse) = (from, error(from));
        loop {
            per *= 2;
            let fine = error(per);
            if fine < 1e4 * floor || per >= 2048 {
                assert!(fine > 10.0 * floor, "{}: the error {fine:e} is rounding", self.name());
                return (coarse / fine).log2();
            }
            coarse = fine;
        }
    }

    fn assert_order(&self, found: f64, claimed: usize, of: &str) {
        let miss = found - claimed as f64;
        // Numbers of 15 digits leave no room for steps so small that the leading term of an optimised method,
        // which is tiny, outweighs the next: its slope is steeper.
        // The interpolant of gauss3 has two terms of nearly the same size: 6.79.
        let steeper = if self.digits < 20.0 { 2.0 } else { 0.2 };
        assert!(-0.25 < miss && miss < steeper, "{}, {of}: order {found:.2}, not {claimed}", self.name());
    }

    /// A run of so many steps of one size, which has the sign of time. Without times every step is saved.
    fn first(&self, p: &First, (t0, h, steps): Steps, times: &[D]) -> Solution<State> {
        let run = kutta::solve(p.f, (p.exact)(t0), t0..t0 + h * n(steps as f64)).step(h.abs());
        let run = run.with(self.method.clone());
        let run = if times.is_empty() { run.every_step() } else { run.at(times) };
        run.run().unwrap_or_else(|e| panic!("{}: {e}", self.name()))
    }

    fn second(&self, p: &Second, (t0, h, steps): Steps, times: &[D]) -> Solution<State> {
        let run = kutta::solve_second(p.f, (p.exact)(t0), (p.slope)(t0), t0..t0 + h * n(steps as f64));
        let run = run.with(self.method.clone()).step(h.abs());
        let run = if times.is_empty() { run.every_step() } else { run.at(times) };
        run.run().unwrap_or_else(|e| panic!("{}: {e}", self.name()))
    }
}

/// The start, the step and how many of them.
type Steps = (D, D, usize);

/// The whole span in so many steps.
fn across(span: [f64; 2], steps: usize) -> Steps {
    (n(span[0]), n(span[1] - span[0]) / n(steps as f64), steps)
}

/// So many steps of size 1/per.
fn few(steps: usize, per: usize) -> Steps {
    (n(0.25), n(1.0) / n(per as f64), steps)
}

/// The largest distance of saved states from the solution.
fn largest(ts: &[D], ys: &[State], exact: fn(D) -> State) -> f64 {
    assert!(ts.len() == ys.len() && !ts.is_empty());
    let distance = |a: State, b: State| (a[0] - b[0]).abs().hi().max((a[1] - b[1]).abs().hi());
    ts.iter().zip(ys).map(|(&t, &y)| distance(y, exact(t))).fold(0.0, f64::max)
}

#[test]
fn every_first_order_method_has_its_order() {
    for known in of(1) {
        for (i, p) in FIRST.iter().enumerate() {
            let found = known.order(|steps| {
                let s = known.first(p, across(p.span, steps), &[]);
                largest(&s.ts, &s.ys, p.exact)
            });
            known.assert_order(found, known.form().order, &format!("problem {i}"));
        }
    }
    assert!(of(1).count() > 60, "the list of methods is short");
}

#[test]
fn every_second_order_method_has_its_order_in_positions_and_velocities() {
    for known in of(2) {
        for (i, p) in SECOND.iter().enumerate() {
            let solve = |steps| known.second(p, across(p.span, steps), &[]);
            let position = known.order(|steps| {
                let s = solve(steps);
                largest(&s.ts, &s.ys, p.exact)
            });
            known.assert_order(position, known.form().order, &format!("position of problem {i}"));
            let velocity = known.order(|steps| {
                let s = solve(steps);
                largest(&s.ts, &s.vs, p.slope)
            });
            known.assert_order(velocity, known.form().order, &format!("velocity of problem {i}"));
        }
    }
    assert!(of(2).count() > 20, "the list of methods is short");
}

/// A start of lower order would show in every later step: what the carried vectors hold after it must be
/// as good as a step of the method itself, which errs by h^(order + 1).
#[test]
fn starts_are_as_good_as_the_method() {
    let mut tried = 0;
    for known in METHODS.iter().filter(|known| known.behind() > 0) {
        let found = match known.form().d {
            1 => known.order(|per| {
                let s = known.first(&FIRST[0], few(known.behind(), per), &[]);
                largest(&s.ts, &s.ys, FIRST[0].exact)
            }),
            _ => known.order(|per| {
                let s = known.second(&SECOND[0], few(known.behind(), per), &[]);
                largest(&s.ts, &s.ys, SECOND[0].exact).max(largest(&s.ts, &s.vs, SECOND[0].slope))
            }),
        };
        let least = known.form().order as f64 + 1.0;
        assert!(found > least - 0.2, "{}: the start has order {found:.2}, not {least}", known.name());
        tried += 1;
    }
    assert!(tried > 20, "multistep methods are missing");
}

/// Values between steps: from the exact solution one step errs by h^(q + 1), q the lower of the orders of
/// the method and of the interpolant; y' of a second-order equation, which the interpolant differentiates,
/// by h^q.
#[test]
fn dense_output_has_its_order() {
    for known in METHODS.iter() {
        let (form, steps) = (known.form(), known.behind() + 1);
        let inside = |per: usize| {
            let (t0, h, _) = few(steps, per);
            [0.2, 0.45, 0.8].map(|theta| t0 + h * n((steps - 1) as f64 + theta))
        };
        let interpolant = if form.d == 1 {
            let p = &FIRST[0];
            let solve = |per| known.first(p, few(steps, per), &inside(per));
            let found = known.order(|per| largest(&inside(per), &solve(per).ys, p.exact));
            let interpolant = solve(64).interpolant;
            known.assert_order(found, interpolant.order().min(form.order) + 1, "between steps");
            interpolant
        } else {
            let p = &SECOND[0];
            let solve = |per| known.second(p, few(steps, per), &inside(per));
            let interpolant = solve(64).interpolant;
            let found = known.order(|per| largest(&inside(per), &solve(per).ys, p.exact));
            known.assert_order(found, interpolant.order().min(form.order) + 1, "position between steps");
            let found = known.order(|per| largest(&inside(per), &solve(per).vs, p.slope));
            known.assert_order(found, interpolant.order().min(form.order), "velocity between steps");
            interpolant
        };
        match interpolant {
            Interpolant::Nordsieck { .. } => panic!("{}: of a family", known.name()),
            Interpolant::Own { order } => assert_eq!(order, form.dense_order, "{}", known.name()),
            Interpolant::Hermite { order } => {
                // Implicit methods ask f for no slopes in between, which stiffness would spoil.
                let matching = order >= form.order.min(9) || form.d == 2 || !form.explicit();
                assert!(form.dense_order == 0 && matching, "{}: Hermite of order {order}", known.name());
            }
        }
    }
}

/// The error estimate of one step of size h, as the stepper has it: the least tolerance that accepts the step.
fn estimate(known: &Known, p: &First, h: D) -> f64 {
    let t0 = n(0.25);
    let accepts = |exponent: f64| {
        let run = kutta::solve(p.f, (p.exact)(t0), t0..t0 + h).with(known.method.clone());
        run.rtol(n(0.0)).atol(n(exponent.exp2())).first_step(h).max_steps(1).run().is_ok()
    };
    let (mut below, mut above) = (-150.0, 10.0);
    assert!(!accepts(below) && accepts(above), "{}", known.name());
    while above - below > 1e-3 {
        let middle = 0.5 * (below + above);
        if accepts(middle) { above = middle } else { below = middle }
    }
    above.exp2()
}

/// The estimate y - yhat of a solution of order q errs by h^(q + 1); DOP853's two estimates e5 and e3 enter as
/// e5^2/sqrt(e5^2 + e3^2/100), which has the order 2 (5 + 1) - (3 + 1) = 8.
#[test]
fn error_estimates_decay_with_the_embedded_order() {
    let mut tried = 0;
    for known in of(1).filter(|known| known.form().errors > 0) {
        let form = known.form();
        let of = |k: usize| form.embedded[k].min(form.order) + 1;
        let claimed = if form.errors == 2 && of(0) != of(1) { 2 * of(0) - of(1) } else { of(0) };
        let found = known.order(|per| estimate(known, &FIRST[0], n(1.0) / n(per as f64)));
        known.assert_order(found, claimed, "error estimate");
        tried += 1;
    }
    assert!(tried > 20, "pairs are missing");
}
