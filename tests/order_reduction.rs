//! The order left on the stiff equation of Prothero and Robinson (1974), measured against the derived one.

use kutta::tableau::{Meaning, StiffOrder, entries};
use kutta::{Jacobian, Loaded, Method, Why, methods, solve, solve_split};

/// Whether y of earlier steps is carried, and no slopes.
fn older_steps(method: &Loaded) -> bool {
    let carried = &method.form().means[..method.form().r];
    carried.len() > 1 && carried.iter().all(|means| matches!(means, Meaning::Y(_)))
}

/// The error at t = 3.7 of y' = lambda (y - sin t) + cos t, from t = 0.5 on in some steps; by a pair as the part that
/// is solved for, beside nothing.
fn error(method: &Loaded, lambda: f64, steps: i32) -> f64 {
    let f = move |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = lambda * (y[0] - t.sin()) + t.cos();
    let jacobian = move |_t: f64, _y: &[f64; 1], j: &mut Jacobian<f64>| j[(0, 0)] += lambda;
    let (y0, span, h) = ([0.5f64.sin()], 0.5..3.7, 3.2 / f64::from(steps));
    let run = if method.form().split() {
        let none = |_t: f64, _y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = 0.0;
        solve_split(f, none, y0, span).with(method.clone()).step(h).run()
    } else {
        let run = solve(f, y0, span).jacobian(jacobian).with(method.clone());
        // What an explicit method makes of the first steps is beyond all numbers: with a mass matrix, be it 1, an
        // implicit one starts.
        if older_steps(method) { run.mass(|m| m[(0, 0)] = 1.0).step(h).run() } else { run.step(h).run() }
    };
    match run {
        Ok(run) => (run.y[0] - 3.7f64.sin()).abs(),
        Err(stop) if matches!(stop.why, Why::NonFinite { .. }) => f64::INFINITY,
        Err(stop) => panic!("{}: {stop}", method.name()),
    }
}

/// Every method with implicit stages and its derived order; of a family each member, as a method of its own.
fn derived() -> Vec<(Loaded, Option<StiffOrder>)> {
    let mut all = vec![];
    for entry in methods::all() {
        let p = entry.tableau().properties();
        let rows = entries(entry.text, "nordsieck").unwrap_or_default();
        for (member, rows) in p.members.iter().zip(rows.chunks(2)) {
            let (q, [alpha, beta]) = (member.order, [&rows[0], &rows[1]].map(|row| row[1..].join(" ")));
            let text = format!(
                "name = \"m\"\norder = {q}\ncite = \"c\"\nmultistep = '''\nalpha | {alpha}\nbeta | {beta}\n'''\n"
            );
            let method =
                Loaded::parse(&format!("{} {q}", entry.name), &text).expect("proven with the family");
            all.push((method, member.stiff_order));
        }
        if p.members.is_empty() && p.a_stable.is_some() {
            all.push((Loaded::parse(entry.name, entry.text).expect("proven"), p.stiff_order));
        }
    }
    all
}

#[test]
fn measured_order_is_the_derived_one() {
    let (mut seen, mut grow, mut bad) = (0, 0, vec![]);
    for (method, stiff_order) in derived() {
        let Some(StiffOrder { order, damping }) = stiff_order else {
            // The faster the motion, the larger the error.
            let (slow, fast) = (error(&method, -1e3, 64), error(&method, -1e4, 64));
            assert!(fast > 0.1 && fast >= 2.0 * slow, "{}: {slow:e}, {fast:e}", method.name());
            grow += 1;
            continue;
        };
        // The smallest steps that rounding, 1e-16 of y in each, leaves a digit and a half of. All counts are even:
        // where R is -1 at infinity the misses take turns. A formula of k steps sees the derivative k/2 steps ago and
        // needs smaller ones to show its order; a lambda that is large beside them is enough for it.
        let runs = match older_steps(&method) {
            true => &[(-1e8, 512), (-1e7, 256), (-1e4, 128), (-3e3, 128), (-1e4, 64)][..],
            false => &[(-1e8, 512), (-1e7, 256), (-1e6, 64), (-1e6, 32), (-1e5, 16), (-1e4, 32), (-1e4, 16)],
        };
        let found = runs.iter().copied().find(|&(lambda, n)| error(&method, lambda, n) > 1e-13);
        let (lambda, n) = found.expect("some error");
        let coarse = error(&method, lambda, n / 2);
        let by_step = (coarse / error(&method, lambda, n)).log2();
        let by_lambda = (coarse / error(&method, 10.0 * lambda, n / 2)).log10();
        if !((by_step - order as f64).abs() < 0.3 && (by_lambda - damping as f64).abs() < 0.2) {
            let name = method.name();
            bad.push(format!(
                "{name}: h^{by_step:.2} lambda^-{by_lambda:.2}, not h^{order} lambda^-{damping}"
            ));
        }
        seen += 1;
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(seen > 60 && grow > 10, "{seen}, {grow}");
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
    // Backward differentiation loses nothing (II, V.7); the trapezoid is the last Adams-Moulton formula that is of use.
    assert_eq!(["bdf1", "bdf3", "bdf6", "am1"].map(of), [(1, 1), (3, 1), (6, 1), (2, 1)]);
    assert_eq!(methods::find("am2").expect("a formula").tableau().properties().stiff_order, None);
    // Singly diagonal stages have stage order 1, or 2 where the first one is explicit.
    assert_eq!(["sdirk4-hw", "kvaerno5"].map(of), [(1, 1), (2, 1)]);
}
