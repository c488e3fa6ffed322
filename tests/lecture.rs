//! The integration methods of a lecture for game programmers, formula by formula, under the names it uses.

use kutta::methods::{
    self, Ab2, Dp54, Euler, ExplicitMidpoint, Heun2, HeunPece, Kutta3, Rk4, VelocityVerlet, Verlet,
};
use kutta::problems::{KeplerE06, Problem};
use kutta::{Method, Solution, solve, solve_second};

/// A few roundings of numbers around one.
const FEW_ULP: f64 = 4.0 * f64::EPSILON;

/// x'' = -k x as a system (x, v), k = 4.
fn spring(_: f64, y: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [y[1], -4.0 * y[0]];
}

fn spring_energy(y: &[f64; 2]) -> f64 {
    0.5 * y[1] * y[1] + 0.5 * 4.0 * y[0] * y[0]
}

/// A slope that depends on time and state, for formulas written out.
fn slope(t: f64, x: f64) -> f64 {
    (2.0 * t).cos() - x * x * x
}

fn slope_of(t: f64, x: &[f64; 1], dx: &mut [f64; 1]) {
    dx[0] = slope(t, x[0]);
}

fn saved<M: Method>(method: M, h: f64, n: usize) -> Solution<[f64; 1]> {
    solve(slope_of, [0.5], 0.0..h * n as f64).with(method).step(h).every_step().run().unwrap()
}

/// The order of an error seen as the step is halved.
fn order(error: impl Fn(f64) -> f64) -> f64 {
    (error(1.0 / 64.0) / error(1.0 / 128.0)).log2()
}

#[test]
fn the_names_of_the_lecture_are_found() {
    for name in ["euler", "verlet", "velocity-verlet", "ab2", "heun-pece", "rk4"] {
        assert!(methods::find(name).is_some(), "{name}");
    }
}

// 1. Euler: x_{i+1} = x_i + v_i dt, v_{i+1} = v_i + a dt.

#[test]
fn euler_is_its_formula() {
    let (h, n) = (0.0625, 100);
    let s = solve(spring, [1.0, 0.5], 0.0..h * n as f64).with(Euler).step(h).every_step().run().unwrap();
    let (mut x, mut v) = (1.0, 0.5);
    for y in &s.ys {
        assert_eq!(*y, [x, v]);
        (x, v) = (x + v * h, v + -4.0 * x * h);
    }
}

#[test]
fn euler_is_exact_for_a_constant_slope_only() {
    let end = |f: fn(f64) -> f64| {
        let f = |t: f64, _: &[f64; 1], dx: &mut [f64; 1]| dx[0] = f(t);
        solve(f, [1.0], 0.0..2.0).with(Euler).step(0.125).run().unwrap().y[0]
    };
    assert_eq!(end(|_| -0.75), 1.0 - 1.5);
    // The left sum of 0, h, 2h, ..: short of t^2/2 = 2 by h t/2.
    assert_eq!(end(|t| t), 1.0 + 2.0 - 0.125);
}

/// Each step multiplies the energy by 1 + h^2 k, whatever the state: at a step that is too large for the
/// spring the oscillation takes over.
#[test]
fn a_spring_gains_energy_under_euler() {
    for (h, n) in [(0.01, 1000), (0.1, 100), (0.5, 20)] {
        let s = solve(spring, [1.0, 0.0], 0.0..h * n as f64).with(Euler).step(h).run().unwrap();
        let gain = spring_energy(&s.y) / spring_energy(&[1.0, 0.0]);
        let exact = (1.0 + 4.0 * h * h).powi(n);
        assert!((gain / exact - 1.0).abs() < 1e-12, "{h}: {gain}, not {exact}");
    }
    // With friction, x'' = -4 x - 0.4 x', Euler is stable below h = 0.4/4 and not above, where the spring
    // itself comes to rest either way.
    let damped = |_: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -4.0 * y[0] - 0.4 * y[1]];
    let energy_at_100 = |h: f64| {
        let s = solve(damped, [1.0, 0.0], 0.0..100.0).with(Euler).step(h).run().unwrap();
        spring_energy(&s.y)
    };
    assert!(energy_at_100(0.09) < 0.2 && energy_at_100(0.01) < 1e-10);
    assert!(energy_at_100(0.12) > 1e3 && energy_at_100(0.2) > 1e10);
}

/// "A higher frame rate, or several steps per frame": half the step, half the error.
#[test]
fn the_error_of_euler_falls_with_the_step() {
    let error = |h: f64| {
        let s = solve(spring, [1.0, 0.0], 0.0..1.0).with(Euler).step(h).run().unwrap();
        (s.y[0] - 2f64.cos()).abs()
    };
    let found = order(error);
    assert!((found - 1.0).abs() < 0.05, "{found}");
}

// 2. Taylor: x(t + h) = x + h x' + h^2/2 x'' + ..; Euler keeps two terms and errs by O(h^2) per step.

#[test]
fn methods_are_taylor_sums_of_their_order() {
    // For x' = x one step from 1 is 1 + h + h^2/2 + .. as far as the order goes.
    let step = |h: f64, order: usize| {
        let f = |_: f64, x: &[f64; 1], dx: &mut [f64; 1]| dx[0] = x[0];
        let run = solve(f, [1.0], 0.0..h).step(h);
        let s = match order {
            1 => run.with(Euler).run(),
            2 => run.with(ExplicitMidpoint).run(),
            3 => run.with(Kutta3).run(),
            _ => run.with(Rk4).run(),
        };
        s.unwrap().y[0]
    };
    for h in [0.25, 0.5, 1.0, 2.0] {
        let mut sum = 1.0;
        let mut term = 1.0;
        for order in 1..=4 {
            term *= h / order as f64;
            sum += term;
            assert!((step(h, order) - sum).abs() < FEW_ULP * sum, "order {order}, h = {h}");
        }
    }
}

/// The first term that is left out is the error of a step: h^2 for Euler, h^3 for Taylor's second order.
#[test]
fn the_first_lost_term_is_the_error_of_a_step() {
    let exact = |h: f64| {
        let run = solve(slope_of, [0.5], 0.0..h).with(methods::Verner87Efficient);
        run.rtol(1e-15).atol(1e-16).first_step(h).run().unwrap().y[0]
    };
    let euler = order(|h| (saved(Euler, h, 1).y[0] - exact(h)).abs());
    let second = order(|h| (saved(Heun2, h, 1).y[0] - exact(h)).abs());
    assert!((euler - 2.0).abs() < 0.1 && (second - 3.0).abs() < 0.1, "{euler} {second}");
}

// 3. Verlet: x(t + h) = 2 x(t) - x(t - h) + h^2 a(t) + O(h^4).

fn pendulum(_: f64, x: &[f64; 1], a: &mut [f64; 1]) {
    a[0] = -x[0].sin();
}

#[test]
fn verlet_is_its_formula() {
    let (h, n) = (0.05, 400);
    let s = solve_second(pendulum, [1.0], [0.3], 0.0..h * n as f64).with(Verlet).step(h).every_step();
    let s = s.run().unwrap();
    let a = |x: f64| -x.sin();
    // It does not start itself: the first step is Taylor's with the velocity that is given.
    assert!((s.ys[1][0] - (1.0 + h * 0.3 + 0.5 * h * h * a(1.0))).abs() < FEW_ULP);
    for x in s.ys.windows(3) {
        let next = 2.0 * x[1][0] - x[0][0] + h * h * a(x[1][0]);
        assert!((x[2][0] - next).abs() < FEW_ULP, "{} {next}", x[2][0]);
    }
}

/// The h^3 terms of the two expansions cancel: from exact positions a step errs by h^4. For x = cos t the
/// first step errs by h^4 too, since x''' vanishes at 0.
#[test]
fn verlet_errs_by_h4_a_step() {
    let spring = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -x[0];
    let found = order(|h| {
        let s = solve_second(spring, [1.0], [0.0], 0.0..2.0 * h).with(Verlet).step(h).run().unwrap();
        (s.y[0] - (2.0 * h).cos()).abs()
    });
    assert!((found - 4.0).abs() < 0.1, "{found}");
}

/// Velocity is not integrated: it follows from the positions.
#[test]
fn the_velocity_of_verlet_follows_from_positions() {
    let (h, n) = (0.05, 100);
    let s = solve_second(pendulum, [1.0], [0.3], 0.0..h * n as f64).with(Verlet).step(h).every_step();
    let s = s.run().unwrap();
    for ((x, v), i) in s.ys.windows(2).zip(&s.vs[1..]).zip(1..) {
        let from_positions = (x[1][0] - x[0][0]) / h - 0.5 * h * x[1][0].sin();
        // A difference of positions divided by h magnifies their rounding.
        assert!((v[0] - from_positions).abs() < FEW_ULP / h, "step {i}: {} {from_positions}", v[0]);
    }
    assert_eq!(s.v.as_ref(), s.vs.last());
}

/// "It looks like a tiny change and is much better": after a thousand swings the energy is what it was.
#[test]
fn verlet_keeps_the_energy_that_euler_does_not() {
    let spring_a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -4.0 * x[0];
    let (h, t1) = (0.05, 3000.0);
    let verlet = solve_second(spring_a, [1.0], [0.0], 0.0..t1).with(Verlet).step(h).run().unwrap();
    let gain = spring_energy(&[verlet.y[0], verlet.v.unwrap()[0]]) / spring_energy(&[1.0, 0.0]);
    // It swings by a share of h^2 k/4 = 0.0025.
    assert!((gain - 1.0).abs() < 0.003, "{gain}");
    let euler = solve(spring, [1.0, 0.0], 0.0..100.0).with(Euler).step(h).run().unwrap();
    assert!(spring_energy(&euler.y) > 1e8 * spring_energy(&[1.0, 0.0]));
}

#[test]
fn velocity_verlet_carries_the_velocity_and_agrees_with_stormer() {
    let (h, n) = (0.05, 1000);
    let run = || solve_second(pendulum, [1.0], [0.3], 0.0..h * n as f64).step(h).every_step();
    let (positions, both) = (run().with(Verlet).run().unwrap(), run().with(VelocityVerlet).run().unwrap());
    let (mut x, mut v) = (1.0, 0.3);
    for i in 0..=n {
        let (stormer, carried) = (&positions.ys[i][0], &both.ys[i][0]);
        // Rounding adds up along a thousand steps, twice in Störmer's second sum.
        assert!((stormer - carried).abs() < 1e-11, "step {i}: {stormer} {carried}");
        assert!((carried - x).abs() < 1e-12 && (both.vs[i][0] - v).abs() < 1e-12, "step {i}");
        // x + h v + h^2/2 a, then v + h/2 (a + a').
        let a = -f64::sin(x);
        x += h * v + 0.5 * h * h * a;
        v += 0.5 * h * (a - x.sin());
    }
    // One evaluation a step: the acceleration at its end is that at the next one's start.
    assert_eq!(run().with(VelocityVerlet).run().unwrap().stats.evaluations, n as u64 + 1);
}

// 4. Adams-Bashforth: x_{i+1} = x_i + h/2 (3 v_i - v_{i-1}), started by one Euler step.

#[test]
fn adams_bashforth_started_by_euler_is_its_formula() {
    let (h, n) = (0.03125, 200);
    let s = solve(slope_of, [0.5], 0.0..h * n as f64).with(Ab2).start_with(Euler).step(h).every_step();
    let s = s.run().unwrap();
    assert_eq!(s.ys[1][0], 0.5 + h * slope(0.0, 0.5), "the first step is Euler's");
    for (t, x) in s.ts.windows(3).zip(s.ys.windows(3)) {
        let (before, now) = (slope(t[0], x[0][0]), slope(t[1], x[1][0]));
        let next = x[1][0] + h / 2.0 * (3.0 * now - before);
        assert!((x[2][0] - next).abs() < FEW_ULP, "{} {next}", x[2][0]);
    }
    // One evaluation a step, and two for the start.
    let run = solve(slope_of, [0.5], 0.0..h * n as f64).with(Ab2).start_with(Euler).step(h);
    assert!(run.run().unwrap().stats.evaluations <= n as u64 + 2);
}

/// "Error O(h^3) per step instead of O(h^2)": order 2 over a span, even though Euler's one step errs by h^2.
#[test]
fn adams_bashforth_errs_by_h3_a_step() {
    let decay = |_: f64, x: &[f64; 1], dx: &mut [f64; 1]| dx[0] = -x[0];
    let span = |h: f64| {
        let s = solve(decay, [1.0], 0.0..1.0).with(Ab2).start_with(Euler).step(h).run().unwrap();
        (s.y[0] - (-1f64).exp()).abs()
    };
    assert!((order(span) - 2.0).abs() < 0.1, "{}", order(span));
    let step = |h: f64| {
        let s = solve(decay, [1.0], 0.0..2.0 * h).with(Ab2).start_with(Rk4).step(h).run().unwrap();
        (s.y[0] - (-2.0 * h).exp()).abs()
    };
    assert!((order(step) - 3.0).abs() < 0.1, "{}", order(step));
}

// 5. Predictor-corrector: a preliminary step, the slope there, then a step with the mean of the two slopes.

#[test]
fn predictor_corrector_is_its_formula() {
    let (h, n) = (0.0625, 100);
    let s = saved(HeunPece, h, n);
    for (t, x) in s.ts.windows(2).zip(s.ys.windows(2)) {
        let first = slope(t[0], x[0][0]);
        let predicted = x[0][0] + h * first;
        let next = x[0][0] + h * (first + slope(t[1], predicted)) / 2.0;
        assert!((x[1][0] - next).abs() < FEW_ULP, "{} {next}", x[1][0]);
    }
}

// 6. Runge-Kutta.

#[test]
fn runge_kutta_is_its_formula() {
    let (h, n) = (0.1, 200);
    let s = saved(Rk4, h, n);
    for (t, x) in s.ts.windows(2).zip(s.ys.windows(2)) {
        let (t, x0) = (t[0], x[0][0]);
        let k1 = slope(t, x0);
        let k2 = slope(t + h / 2.0, x0 + h / 2.0 * k1);
        let k3 = slope(t + h / 2.0, x0 + h / 2.0 * k2);
        let k4 = slope(t + h, x0 + h * k3);
        let next = x0 + h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
        assert!((x[1][0] - next).abs() < FEW_ULP, "{} {next}", x[1][0]);
    }
    assert_eq!(s.stats.evaluations, 4 * n as u64);
}

/// Item 8. "Euler is easy but errs much; Verlet is simple and much better; Runge-Kutta is more work, with
/// fine results": at the same step on the same swing.
#[test]
fn the_order_of_merit() {
    let (h, t1) = (0.02, 5.0f64);
    let exact = (2.0 * t1).cos();
    let first = |s: Solution<[f64; 2]>| (s.y[0] - exact).abs();
    let euler = first(solve(spring, [1.0, 0.0], 0.0..t1).with(Euler).step(h).run().unwrap());
    let rk4 = first(solve(spring, [1.0, 0.0], 0.0..t1).with(Rk4).step(h).run().unwrap());
    let a = |_: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -4.0 * x[0];
    let s = solve_second(a, [1.0], [0.0], 0.0..t1).with(Verlet).step(h).run().unwrap();
    let verlet = (s.y[0] - exact).abs();
    assert!(euler > 50.0 * verlet && verlet > 50.0 * rk4, "{euler:e} {verlet:e} {rk4:e}");
}

// 7. Adaptive steps.

/// A comet rounds its sun at 4 times the speed and 1/4 of the distance that it has far out, where the motion
/// varies 8 times as slowly (Kepler's third law between circles of these radii).
#[test]
fn adaptive_steps_are_small_where_the_solution_varies_fast() {
    let kepler = |t: f64, y: &[f64; 4], dy: &mut [f64; 4]| KeplerE06.rhs(t, y, dy);
    let adaptive = || solve(kepler, KeplerE06.y0(), 0.0..20.0).with(Dp54).rtol(1e-7).atol(1e-7);
    let s = adaptive().every_step().run().unwrap();
    let (mut near, mut far) = (f64::INFINITY, 0.0);
    for (t, y) in s.ts.windows(2).zip(&s.ys) {
        let r = y[0].hypot(y[1]);
        let h = t[1] - t[0];
        if r < 0.5 {
            near = f64::min(near, h);
        }
        // The last step is cut short by the end.
        if r > 1.5 && t[1] < 20.0 {
            far = f64::max(far, h);
        }
    }
    assert!(far > 5.0 * near, "{near} near the sun, {far} far out");
    // Equal steps need more work for the same error.
    let reference = KeplerE06.reference().unwrap();
    let error = |y: &[f64; 4]| y.iter().zip(&reference).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
    let (goal, work) = (error(&s.y), s.stats.evaluations);
    let fixed =
        solve(kepler, KeplerE06.y0(), 0.0..20.0).with(Dp54).step(20.0 * 6.0 / work as f64).run().unwrap();
    assert!(error(&fixed.y) > 10.0 * goal, "{:e} with equal steps, {goal:e}", error(&fixed.y));
}
