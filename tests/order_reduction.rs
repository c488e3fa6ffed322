//! The order left on the stiff equation of Prothero and Robinson (1974), measured against the derived one.

use kutta::tableau::StiffOrder;
use kutta::{Jacobian, Loaded, methods, solve};

/// The error at t = 3.7 of y' = lambda (y - sin t) + cos t, from t = 0.5 on in some steps.
fn error(method: &Loaded, lambda: f64, steps: i32) -> f64 {
    let f = move |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = lambda * (y[0] - t.sin()) + t.cos();
    let jacobian = move |_t: f64, _y: &[f64; 1], j: &mut Jacobian<f64>| j[(0, 0)] += lambda;
    let run = solve(f, [0.5f64.sin()], 0.5..3.7).jacobian(jacobian).with(method.clone());
    let run = run.step(3.2 / f64::from(steps)).run();
    (run.expect("a linear equation").y[0] - 3.7f64.sin()).abs()
}

#[test]
fn measured_order_is_the_derived_one() {
    let (mut seen, mut bad) = (0, vec![]);
    for entry in methods::all() {
        let Some(StiffOrder { order, damping }) = entry.tableau().properties().stiff_order else { continue };
        let Ok(method) = Loaded::parse(entry.name, entry.text) else { continue };
        // The smallest steps that rounding, 1e-16 of y in each, leaves a digit and a half of. All counts are even:
        // where R is -1 at infinity the misses take turns.
        let runs = [(-1e8, 512), (-1e7, 256), (-1e6, 64), (-1e6, 32), (-1e5, 16), (-1e4, 32), (-1e4, 16)];
        let found = runs.into_iter().find(|&(lambda, n)| error(&method, lambda, n) > 1e-13);
        let (lambda, n) = found.expect("some error");
        let coarse = error(&method, lambda, n / 2);
        let by_step = (coarse / error(&method, lambda, n)).log2();
        let by_lambda = (coarse / error(&method, 10.0 * lambda, n / 2)).log10();
        if !((by_step - order as f64).abs() < 0.3 && (by_lambda - damping as f64).abs() < 0.2) {
            let name = entry.name;
            bad.push(format!(
                "{name}: h^{by_step:.2} lambda^-{by_lambda:.2}, not h^{order} lambda^-{damping}"
            ));
        }
        seen += 1;
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(seen > 35, "{seen}");
}

/// Hairer, Wanner II, table IV.15.1: the error of collocation with s stages goes like h^s / lambda where the last
/// node is the end (Radau IIA); without it (Gauss) like h^(s+1), or like h^s where R is 1 at infinity. The
/// conditions of Rodas4P and Rodas5P (Steinebach 1995, 2023) save what Rodas4 and Rodas5 lose.
#[test]
fn the_derived_order_is_that_of_the_books() {
    let of = |name: &str| {
        let stiff = methods::find(name).expect(name).tableau().properties().stiff_order.expect(name);
        (stiff.order, stiff.damping)
    };
    assert_eq!(["radau-iia2", "radau-iia3", "radau-iia5"].map(of), [(2, 1), (3, 1), (5, 1)]);
    assert_eq!(["implicit-midpoint", "gauss2", "gauss3", "gauss4"].map(of), [(2, 0), (2, 0), (4, 0), (4, 0)]);
    let rosenbrock = ["rodas4", "rodas4p", "rodas5", "rodas5p"].map(of);
    assert_eq!(rosenbrock, [(1, 1), (3, 1), (1, 1), (3, 1)]);
    // Singly diagonal stages have stage order 1, or 2 where the first one is explicit.
    assert_eq!(["sdirk4-hw", "kvaerno5"].map(of), [(1, 1), (2, 1)]);
}
