//! Predicted against observed stability: steps that are really taken grow exactly where the stability function
//! says that they do.

use kutta::tableau::Stability;
use kutta::{Controller, Jacobian, Loaded, Method, methods, solve, solve_second, solve_split};
use std::sync::LazyLock;

type Complex = num_complex::Complex<f64>;

struct Known {
    method: Loaded,
    stability: Stability,
    /// Earlier steps count.
    history: bool,
}

/// Every method that takes steps of one size.
static ALL: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let known = |m: &methods::Entry| {
        let method = Loaded::parse(m.name, m.text).ok().filter(|m| m.form().orders == 0)?;
        Some(Known { method, stability: m.tableau().stability(), history: m.path.contains("/multistep/") })
    };
    methods::all().iter().filter_map(known).collect()
});

fn of(name: &str) -> &'static Known {
    ALL.iter().find(|m| m.method.name() == name).unwrap_or_else(|| panic!("{name} steps"))
}

fn first_order() -> impl Iterator<Item = &'static Known> {
    ALL.iter().filter(|m| m.method.form().d == 1)
}

/// A point at this distance from 0, at this angle to the negative real axis.
fn ray(degrees: f64, x: f64) -> Complex {
    let (sin, cos) = degrees.to_radians().sin_cos();
    if degrees == 90.0 { Complex::new(0.0, x) } else { Complex::new(-x * cos, x * sin) }
}

/// lambda as a matrix.
fn of_lambda(lambda: Complex) -> [[f64; 2]; 2] {
    [[lambda.re, -lambda.im], [lambda.im, lambda.re]]
}

/// The sizes of y along y' = M y from (1, 0), in steps of h; infinite at the end where f overflows.
fn sizes(method: &Loaded, m: [[f64; 2]; 2], h: f64, steps: usize) -> Vec<f64> {
    let f = move |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        *dy = [m[0][0] * y[0] + m[0][1] * y[1], m[1][0] * y[0] + m[1][1] * y[1]];
    };
    let jacobian = move |_t: f64, _y: &[f64; 2], j: &mut Jacobian<f64>| {
        (0..4).for_each(|k| j[(k / 2, k % 2)] += m[k / 2][k % 2]);
    };
    let span = 0.0..h * steps as f64;
    let run = if method.form().split() {
        // What is told of a pair is its explicit table.
        let none = |_t: f64, _y: &[f64; 2], dy: &mut [f64; 2]| *dy = [0.0; 2];
        solve_split(none, f, [1.0, 0.0], span).with(method.clone()).step(h).every_step().run()
    } else {
        // A rough start wakes every root of a method with a history.
        let ivp = solve(f, [1.0, 0.0], span).jacobian(jacobian).with(method.clone());
        ivp.start_with(methods::Euler).step(h).every_step().run()
    };
    let (ys, more) = match run {
        Ok(solution) => (solution.ys, None),
        Err(stopped) => (stopped.solution.ys, Some(f64::INFINITY)),
    };
    ys.iter().map(|y| y[0].hypot(y[1])).chain(more).collect()
}

/// Whether the largest of the last quarter is more than `factor` times that of the quarter before.
fn grows(sizes: &[f64], factor: f64) -> bool {
    if !(sizes[sizes.len() - 1] < f64::INFINITY) {
        return true;
    }
    let (n, quarter) = (sizes.len(), sizes.len() / 4);
    let largest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let (before, last) = (largest(&sizes[n - 2 * quarter..n - quarter]), largest(&sizes[n - quarter..]));
    // Below 1e-12 of the start nothing is left but what Newton's iteration leaves of its stages.
    !(last <= (before * factor).max(1e-12))
}

/// What tells growth from none.
#[derive(Clone, Copy)]
struct Trial {
    steps: usize,
    /// Of the largest of a quarter over that of the quarter before.
    factor: f64,
}

impl Trial {
    /// By a root of modulus `w`. A method that carries y alone multiplies by it from the first step on. One with a
    /// history holds other roots too, which the growing one must outgrow: a hundredfold in a quarter of the steps, or
    /// what 8000 steps allow, which is less only where all other roots are forgotten long before. Below the limit a
    /// quarter is no larger than the one before, but for the beat of roots that stay on the circle together; the
    /// geometric mean of growing and not growing parts the two.
    fn of(w: f64, history: bool) -> Self {
        let needed = 4.0 * 100f64.ln() / w.ln();
        let steps = if history { needed.clamp(400.0, 8000.0) as usize } else { 40 };
        Self { steps, factor: w.powf(0.5 * (steps / 4) as f64) }
    }

    /// Where nothing may grow, but for rounding.
    fn of_none(history: bool, h: f64) -> Self {
        Self { steps: if history { 400 } else { 40 }, factor: 1.0 + 1e-9 + 4e-15 * h }
    }
}

/// Bisects on h until the last step that does not grow and the first that does are half a percent apart.
fn bisect(mut good: f64, mut bad: f64, unstable: impl Fn(f64) -> bool) -> f64 {
    while bad > 1.005 * good {
        let middle = 0.5 * (good + bad);
        if unstable(middle) { bad = middle } else { good = middle }
    }
    0.5 * (good + bad)
}

/// The limit that bisection finds; none where steps far below the predicted one grow, or those above do not.
fn observed(predicted: f64, unstable: impl Fn(f64) -> bool) -> Option<f64> {
    let (far, good, bad) = (0.3 * predicted, 0.96 * predicted, 1.04 * predicted);
    (!unstable(far) && !unstable(good) && unstable(bad)).then(|| bisect(good, bad, unstable))
}

/// Steps begin to grow where it is predicted, to one percent.
fn assert_begins(what: &str, predicted: f64, unstable: impl Fn(f64) -> bool) {
    let found = observed(predicted, unstable);
    assert!(found.is_some_and(|h| (h / predicted - 1.0).abs() < 0.01), "{what}: {found:?}, not {predicted}");
}

#[test]
fn steps_grow_from_the_predicted_limit_on() {
    let mut count = [0, 0, 0];
    for Known { method, stability, history } in first_order() {
        for degrees in [0.0, 45.0, 90.0] {
            let (name, limit) = (method.name(), stability.limit(degrees));
            let unstable = |h: f64, trial: Trial| {
                grows(&sizes(method, of_lambda(ray(degrees, 1.0)), h, trial.steps), trial.factor)
            };
            let by = |h: f64| stability.amplification(ray(degrees, h));
            if limit == f64::INFINITY {
                for h in [0.3, 30.0, 1e10] {
                    let grows = unstable(h, Trial::of_none(*history, h));
                    assert!(!grows, "{name} at {degrees} degrees grows with h |lambda| = {h}");
                }
                count[0] += 1;
            } else if limit == 0.0 {
                // Near 0, |w| - 1 is a power of h that no arithmetic shows: the step of these that shows most.
                let h =
                    [1.0 / 32.0, 0.125, 0.25, 0.5, 1.0].into_iter().max_by(|&a, &b| by(a).total_cmp(&by(b)));
                let h = h.expect("there are some");
                assert!(by(h) > 1.0 + 1e-9, "{name} at {degrees} degrees has some limit");
                let grows = unstable(h, Trial::of(by(h), *history));
                assert!(grows, "{name} at {degrees} degrees does not grow with h |lambda| = {h}");
                count[1] += 1;
            } else {
                let trial = Trial::of(by(1.01 * limit), *history);
                assert_begins(&format!("{name} at {degrees} degrees"), limit, |h| unstable(h, trial));
                count[2] += 1;
            }
        }
    }
    assert!(count[0] > 100 && count[1] > 5 && count[2] > 30, "{count:?}");
}

#[test]
fn a_step_multiplies_by_the_stability_function() {
    let mut count = 0;
    for Known { method, stability, .. } in first_order().filter(|m| !m.history) {
        for z in [
            Complex::new(-0.7, 0.0),
            Complex::new(-1.1, 0.9),
            Complex::new(0.2, 2.0),
            Complex::new(-30.0, 5.0),
        ] {
            let sizes = sizes(method, of_lambda(z), 1.0, 1);
            let (took, says) = (sizes[1] / sizes[0], stability.amplification(z));
            // Newton's iteration ends at a thousandth of the default tolerance at worst.
            assert!(
                (took - says).abs() < 1e-8 * (1.0 + says),
                "{} at {z}: {took}, not {says}",
                method.name()
            );
            count += 1;
        }
    }
    assert!(count > 150, "{count}");
}

/// The springs of the lecture: stiffness 400, drag 0 or 4, on a mass of 1. By hand, Euler's |w|^2 is
/// 1 - 4 h + 400 h^2: it swings up at any step without drag, and from h = 4/400 on with it.
#[test]
fn springs_start_to_swing_up_where_predicted() {
    // For 20 x and v, whose squares add up to the energy.
    let spring = |c: f64| [[0.0, 20.0], [-20.0, -c]];
    let unstable = |method: &Loaded, c: f64, h: f64, trial: Trial| {
        grows(&sizes(method, spring(c), h, trial.steps), trial.factor)
    };
    let (euler, rounding) = (&of("euler").method, 1.0 + 1e-9);
    let long = Trial { steps: 1000, factor: rounding };
    assert!([1e-3, 1e-2].iter().all(|&h| unstable(euler, 0.0, h, Trial { steps: 40, factor: rounding })));
    assert!((bisect(1e-3, 0.02, |h| unstable(euler, 4.0, h, long)) - 0.01).abs() < 1e-4);
    let mut count = 0;
    // Without drag they are the oscillation on the imaginary axis above.
    for Known { method, stability, history } in first_order() {
        let c = 4.0f64;
        // Both eigenvalues have the modulus 20, and c / 40 is the cosine of their angle.
        let degrees = (c / 40.0).acos().to_degrees();
        let limit = stability.limit(degrees) / 20.0;
        if limit == 0.0 || limit == f64::INFINITY {
            continue;
        }
        let w = stability.amplification(ray(degrees, 1.01 * 20.0 * limit));
        let mut trial = Trial::of(w, *history);
        // A quarter must hold some swings.
        if trial.steps < 1000 {
            trial = Trial { steps: 1000, factor: w.powf(125.0) };
        }
        let what = format!("{}, drag {c}", method.name());
        assert_begins(&what, limit, |h| unstable(method, c, h, trial));
        count += 1;
    }
    assert!(count > 20, "{count}");
}

/// x'' = -400 x by methods for second-order equations.
#[test]
fn springs_of_second_order_methods_likewise() {
    let mut count = 0;
    for Known { method, stability, .. } in ALL.iter().filter(|m| m.method.form().d == 2) {
        let unstable = |h: f64| {
            let f = |_t: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -400.0 * x[0];
            let run = solve_second(f, [1.0], [0.0], 0.0..1000.0 * h).with(method.clone()).step(h).run();
            // Where two roots meet on the circle, at the limit and wherever they pass through each other, a swing
            // grows with the number of steps at most; beyond the limit it grows like a power.
            run.is_err() || run.is_ok_and(|s| s.y[0].abs() > 1e6)
        };
        let limit = stability.limit(0.0) / 20.0;
        // Beyond the limit a composition may be stable again: the first step that is not counts.
        let mut h = 0.05 * limit;
        let next = |h: f64| h + if h < 0.9 * limit { 0.07 } else { 0.005 } * limit;
        while !unstable(next(h)) && h < 2.0 * limit {
            h = next(h);
        }
        assert!((h / limit - 1.0).abs() < 0.01, "{}: {h}, not {limit}", method.name());
        count += 1;
    }
    assert!(count >= methods::all().iter().filter(|m| m.path.contains("/nystrom/")).count(), "{count}");
}

/// Where stability alone limits the step, it settles or swings as the spectral radius of step and controller
/// says.
#[test]
fn the_step_settles_where_the_controller_is_stable() {
    let mut count = [0, 0];
    for Known { method, stability, .. } in first_order().filter(|m| m.method.form().errors > 0) {
        for (what, controller) in [
            ("I", Controller::I),
            ("PI", Controller::PI),
            ("PID", Controller::PID),
            ("H211b", Controller::H211B),
        ] {
            let (name, limit) = (method.name(), stability.limit(0.0));
            let Some(radius) = stability.step_control(Complex::new(-limit, 0.0), &controller) else {
                continue;
            };
            // The factor of a step is read off in straight pieces, a few percent of its power off.
            if (0.95..1.06).contains(&radius) {
                continue;
            }
            let mut times = vec![];
            let f = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0];
            let run = solve(f, [1.0], 0.0..1500.0 * limit).with(method.clone()).rtol(1e-12).atol(1e-6);
            for step in run.controller(controller).steps() {
                times.push(step.unwrap().0);
            }
            let h: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
            let late = &h[h.len() - 300..h.len() - 2];
            let (least, most) = late.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &h| (a.min(h), b.max(h)));
            match radius < 1.0 {
                true => assert!(most < (1.0 + 1e-6) * least, "{name}, {what}: {least} to {most}"),
                false => assert!(most > 1.2 * least, "{name}, {what}: {least} to {most}"),
            }
            // Either way the border is where the steps are.
            assert!(least < 1.001 * limit && most > 0.999 * limit, "{name}, {what}: {least} to {most}");
            count[(radius > 1.0) as usize] += 1;
        }
    }
    assert!(count[0] > 5 && count[1] > 5, "{count:?}");
}
