//! What can be stepped: arrays, vectors and columns of real, complex and double-double numbers, closures and
//! structs.

use kutta::methods::{
    self, Ab4, Abm4Pece, CashKarp54, Dop853, Dp54, ForestRuth4, Rk4, Tsit54, VelocityVerlet, Verlet,
    Verner98Efficient,
};
use kutta::problems::{KeplerE06, Lorenz63, LotkaVolterra, Problem, VdpMu1};
use kutta::tableau::DoubleDouble as D;
use kutta::{Ivp, Loaded, Method, OutOfDomain, State, System, solve, solve_second};
use num_complex::Complex;

/// Each component is drawn to the next one round the ring, nonlinearly and with time.
fn ring<Y: State<Scalar = f64>>(t: f64, y: &Y, dy: &mut Y) {
    let y = y.as_slice();
    for (i, dy) in dy.as_mut_slice().iter_mut().enumerate() {
        *dy = (y[(i + 1) % y.len()] - y[i]) * (1.0 + 0.5 * t.cos()) - 0.1 * y[i] * y[i];
    }
}

fn begun(i: usize) -> f64 {
    1.0 / (1.0 + i as f64)
}

/// The same run with N numbers in an array, a nalgebra vector, a `Vec` and a faer column.
fn in_every_container<const N: usize>(run: impl Fn(&dyn Run) -> Vec<Vec<f64>>) -> [Vec<Vec<f64>>; 4] {
    [
        run(&Held(std::array::from_fn::<f64, N, _>(begun))),
        run(&Held(nalgebra::SVector::<f64, N>::from_fn(|i, _| begun(i)))),
        run(&Held((0..N).map(begun).collect::<Vec<f64>>())),
        run(&Held(faer::Col::<f64>::from_fn(N, begun))),
    ]
}

/// Runs whose results do not show what they were held in: at the end and at two times between steps.
trait Run {
    fn fixed(&self) -> Vec<Vec<f64>>;
    fn adaptive(&self) -> Vec<Vec<f64>>;
}

struct Held<Y>(Y);

const TIMES: [f64; 3] = [0.33, 1.7, 3.0];

fn flat<Y: State<Scalar = f64>>(ys: &[Y]) -> Vec<Vec<f64>> {
    ys.iter().map(|y| y.as_slice().to_vec()).collect()
}

impl<Y: State<Scalar = f64>> Run for Held<Y> {
    fn fixed(&self) -> Vec<Vec<f64>> {
        fn first<Y: State<Scalar = f64>, M: Method>(y: &Y, method: M) -> Vec<Vec<f64>> {
            let run = solve(ring, y.clone(), 0.0..3.0).with(method).step(0.1);
            flat(&run.at(&TIMES).run().unwrap().ys)
        }
        fn second<Y: State<Scalar = f64>, M: Method>(y: &Y, method: M) -> Vec<Vec<f64>> {
            let run = solve_second(ring, y.clone(), y.clone(), 0.0..3.0).with(method).step(0.1);
            let s = run.at(&TIMES).run().unwrap();
            [flat(&s.ys), flat(&s.vs)].concat()
        }
        let y = &self.0;
        [
            first(y, Rk4),
            first(y, Dp54),
            first(y, Dop853),
            first(y, Ab4),
            first(y, Abm4Pece),
            second(y, Verlet),
            second(y, VelocityVerlet),
            second(y, ForestRuth4),
        ]
        .concat()
    }

    fn adaptive(&self) -> Vec<Vec<f64>> {
        fn run<Y: State<Scalar = f64>, M: Method>(y: &Y, method: M) -> Vec<Vec<f64>> {
            let run = solve(ring, y.clone(), 0.0..3.0).with(method).rtol(1e-9).atol(1e-9);
            flat(&run.at(&TIMES).run().unwrap().ys)
        }
        let y = &self.0;
        [run(y, Tsit54), run(y, Dop853), run(y, CashKarp54)].concat()
    }
}

#[test]
fn fixed_steps_give_the_same_bits_in_every_container() {
    for [array, svector, vec, column] in
        [in_every_container::<3>(|held| held.fixed()), in_every_container::<40>(|held| held.fixed())]
    {
        assert!(array.iter().flatten().all(|x| x.is_finite()));
        assert!(array == svector && array == vec && array == column);
    }
}

#[test]
fn adaptive_steps_agree_in_every_container() {
    for runs in
        [in_every_container::<3>(|held| held.adaptive()), in_every_container::<40>(|held| held.adaptive())]
    {
        for other in &runs[1..] {
            for (a, b) in runs[0].iter().flatten().zip(other.iter().flatten()) {
                // The norm adds up in another order, so steps differ in their last digits: far below the
                // tolerance of 1e-9.
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        }
    }
}

/// A table that the compiler unrolls and the same table read at run time.
#[test]
fn compiled_and_read_tables_give_the_same_bits() {
    fn check<M: Method>(method: M) {
        let entry = methods::find(method.name()).unwrap();
        let read = Loaded::parse(entry.name, entry.text).unwrap();
        let y0: [f64; 5] = std::array::from_fn(begun);
        if method.form().d == 2 {
            let run = || solve_second(ring, y0, y0, 0.0..3.0).step(0.07).every_step();
            let (a, b) = (run().with(method).run().unwrap(), run().with(read).run().unwrap());
            assert_eq!((a.ts, a.ys, a.vs, a.stats), (b.ts, b.ys, b.vs, b.stats), "{}", entry.name);
            return;
        }
        let run = || solve(ring, y0, 0.0..3.0).step(0.07).every_step();
        let (a, b) = (run().with(method.clone()).run().unwrap(), run().with(read.clone()).run().unwrap());
        assert_eq!((a.ts, a.ys, a.stats), (b.ts, b.ys, b.stats), "{}", entry.name);
    }
    check(Rk4);
    check(Dp54);
    check(Dop853);
    check(Ab4);
    check(Abm4Pece);
    check(methods::Abm4Pec);
    check(methods::MilneSimpson);
    check(methods::Nystrom2);
    check(Verlet);
    check(VelocityVerlet);
    check(ForestRuth4);
    let run = || solve(ring, std::array::from_fn::<f64, 5, _>(begun), 0.0..3.0).rtol(1e-8).every_step();
    let read = Loaded::parse("dop853", methods::find("dop853").unwrap().text).unwrap();
    let (a, b) = (run().with(Dop853).run().unwrap(), run().with(read).run().unwrap());
    assert_eq!((a.ts, a.ys, a.stats), (b.ts, b.ys, b.stats));
}

#[test]
fn nothing_to_step_is_stepped() {
    let f = |_: f64, _: &Vec<f64>, _: &mut Vec<f64>| {};
    assert_eq!(solve(f, vec![], 0.0..1.0).run().unwrap().y, Vec::<f64>::new());
    assert_eq!(solve(f, vec![], 0.0..1.0).with(Rk4).step(0.1).run().unwrap().stats.accepted, 10);
    let f = |_: f64, _: &[f64; 0], _: &mut [f64; 0]| {};
    assert_eq!(solve(f, [], 0.0..1.0).with(Dop853).run().unwrap().t, 1.0);
}

#[test]
fn single_precision_is_solved_to_its_digits() {
    // y = 1/(1 + t).
    let f = |_: f32, y: &[f32; 2], dy: &mut [f32; 2]| *dy = [-y[0] * y[0], -y[1] * y[1]];
    // One rounding of 6e-8 for each of some tens of steps, as they come.
    let exact = 0.25f32;
    for y in [
        solve(f, [1.0, 1.0], 0f32..3.0).with(Rk4).step(0.05).run().unwrap().y,
        solve(f, [1.0, 1.0], 0f32..3.0).with(Ab4).step(0.01).run().unwrap().y,
        solve(f, [1.0, 1.0], 0f32..3.0).rtol(1e-6).atol(1e-7).run().unwrap().y,
        solve(f, [1.0, 1.0], 0f32..3.0).with(Dop853).rtol(1e-6).atol(1e-7).run().unwrap().y,
    ] {
        assert!((y[0] - exact).abs() < 1e-6 && y[0] == y[1], "{y:?}");
    }
    let a = |_: f32, x: &[f32; 1], a: &mut [f32; 1]| a[0] = -x[0];
    let s = solve_second(a, [1f32], [0.0], 0.0..10.0).with(ForestRuth4).step(0.02).run().unwrap();
    assert!((s.y[0] - 10f32.cos()).abs() < 1e-5, "{:?}", s.y);
    // Coefficients are those of f64 rounded once more, so results are as near as single precision can be.
    let double = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0] * y[0];
    let single = |_: f32, y: &[f32; 1], dy: &mut [f32; 1]| dy[0] = -y[0] * y[0];
    let (d, s) = (
        solve(double, [1.0], 0.0..0.125).with(Dop853).step(0.125).run().unwrap().y[0],
        solve(single, [1.0], 0f32..0.125).with(Dop853).step(0.125).run().unwrap().y[0],
    );
    assert!((s as f64 - d).abs() < 2.0 * f32::EPSILON as f64, "{s} {d}");
}

#[test]
fn complex_numbers() {
    type C = Complex<f64>;
    // y = e^(i t): modulus one, and the phase is t.
    let turn = |_: f64, y: &[C; 1], dy: &mut [C; 1]| dy[0] = C::i() * y[0];
    let exact = C::from_polar(1.0, 5.0);
    for y in [
        solve(turn, [C::from(1.0)], 0.0..5.0).rtol(1e-12).atol(1e-12).with(Dop853).run().unwrap().y[0],
        solve(turn, [C::from(1.0)], 0.0..5.0).with(Dp54).step(1e-3).run().unwrap().y[0],
        solve(turn, [C::from(1.0)], 0.0..5.0).with(Abm4Pece).step(1e-3).run().unwrap().y[0],
    ] {
        assert!((y - exact).norm() < 1e-11, "{y}");
    }
    // y = y0/(1 - y0 t), nonlinear, between steps too.
    let square = |_: f64, y: &Vec<C>, dy: &mut Vec<C>| dy[0] = y[0] * y[0];
    let y0 = C::new(0.5, 1.0);
    let times = [0.2, 0.9, 2.0];
    let s = solve(square, vec![y0], 0.0..2.0).rtol(1e-10).atol(1e-10).at(&times).run().unwrap();
    for (t, y) in times.iter().zip(&s.ys) {
        assert!((y[0] - y0 / (C::from(1.0) - y0 * *t)).norm() < 1e-8, "{t}: {}", y[0]);
    }
    // x'' = -x with complex amplitudes.
    let a = |_: f64, x: &[C; 1], a: &mut [C; 1]| a[0] = -x[0];
    let s = solve_second(a, [y0], [C::i()], 0.0..3.0).with(ForestRuth4).step(1e-3).run().unwrap();
    assert!((s.y[0] - (y0 * 3f64.cos() + C::i() * 3f64.sin())).norm() < 1e-10);
    // In single precision, and a NaN in the imaginary part alone is one.
    let turn = |_: f32, y: &[Complex<f32>; 1], dy: &mut [Complex<f32>; 1]| dy[0] = Complex::<f32>::i() * y[0];
    let s = solve(turn, [Complex::from(1f32)], 0.0..5.0).rtol(1e-6).atol(1e-6).run().unwrap();
    assert!((s.y[0] - Complex::from_polar(1.0, 5f32)).norm() < 1e-4, "{}", s.y[0]);
    let bad =
        |t: f64, y: &[C; 1], dy: &mut [C; 1]| dy[0] = if t > 0.5 { C::new(0.0, f64::NAN) } else { y[0] };
    let stopped = solve(bad, [C::from(1.0)], 0.0..1.0).run().unwrap_err();
    assert!(stopped.t <= 0.5 && stopped.t > 0.5 - 1e-14, "{stopped}");
}

/// A decimal number of up to thirty digits.
fn decimal(text: &str) -> D {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1.0, digits),
        None => (1.0, text),
    };
    let (whole, part) = digits.split_once('.').expect("a point");
    let ten = D::of(10.0);
    let mut value = D::ZERO;
    for digit in whole.chars().chain(part.chars()) {
        value = value * ten + D::of(digit.to_digit(10).expect("a digit").into());
    }
    value / ten.powi(part.len() as u32) * D::of(sign)
}

/// The distance from a reference, all of its digits taken.
fn miss<const N: usize>(y: &[D; N], reference: &[&str]) -> f64 {
    assert_eq!(reference.len(), N);
    y.iter().zip(reference).map(|(y, text)| (*y - decimal(text)).abs().hi()).fold(0.0, f64::max)
}

#[test]
fn double_doubles_have_thirty_digits() {
    let tol = D::of(1e-29);
    // Kepler's problem, three turns: its reference has 30 digits.
    let kepler = |_: D, y: &[D; 4], dy: &mut [D; 4]| {
        let r2 = y[0] * y[0] + y[1] * y[1];
        let pull = D::ONE / (r2 * r2.sqrt());
        *dy = [y[2], y[3], -(y[0] * pull), -(y[1] * pull)];
    };
    let run = solve(kepler, KeplerE06.y0().map(D::of), D::ZERO..D::of(20.0)).with(Verner98Efficient);
    let s = run.rtol(tol).atol(tol).run().unwrap();
    assert!(miss(&s.y, KeplerE06.reference_text()) < 1e-26, "{:e}", miss(&s.y, KeplerE06.reference_text()));

    let prey = |_: D, y: &[D; 2], dy: &mut [D; 2]| {
        *dy = [D::of(1.5) * y[0] - y[0] * y[1], y[0] * y[1] - D::of(3.0) * y[1]];
    };
    let run = solve(prey, [D::ONE; 2], D::ZERO..D::of(10.0)).with(Verner98Efficient).rtol(tol).atol(tol);
    let s = run.run().unwrap();
    assert!(
        miss(&s.y, LotkaVolterra.reference_text()) < 1e-26,
        "{:e}",
        miss(&s.y, LotkaVolterra.reference_text())
    );

    let van_der_pol = |_: D, y: &[D; 2], dy: &mut [D; 2]| {
        *dy = [y[1], (D::ONE - y[0] * y[0]) * y[1] - y[0]];
    };
    let (t0, t1) = VdpMu1.span();
    let run = solve(van_der_pol, VdpMu1.y0().map(D::of), D::of(t0)..D::of(t1)).with(Verner98Efficient);
    let s = run.rtol(tol).atol(tol).run().unwrap();
    assert!(miss(&s.y, VdpMu1.reference_text()) < 1e-26, "{:e}", miss(&s.y, VdpMu1.reference_text()));

    // Lorenz's errors grow ten thousandfold; its reference has 19 digits, two before the point.
    let lorenz = |_: D, [x, y, z]: &[D; 3], dy: &mut [D; 3]| {
        let beta = D::of(8.0 / 3.0);
        *dy = [D::of(10.0) * (*y - *x), *x * (D::of(28.0) - *z) - *y, *x * *y - beta * *z];
    };
    let run = solve(lorenz, [D::ONE; 3], D::ZERO..D::of(10.0)).with(Verner98Efficient);
    let s = run.rtol(D::of(1e-24)).atol(D::of(1e-24)).run().unwrap();
    assert!(miss(&s.y, Lorenz63.reference_text()) < 1.1e-17, "{:e}", miss(&s.y, Lorenz63.reference_text()));
}

/// Dense output, events and second-order equations keep the digits too.
#[test]
fn double_doubles_between_steps() {
    // y = 1/(1 + t).
    let f = |_: D, y: &[D; 1], dy: &mut [D; 1]| dy[0] = -(y[0] * y[0]);
    let times = [D::of(0.3), D::of(1.0) / D::of(3.0), D::of(2.0)];
    let run =
        solve(f, [D::ONE], D::ZERO..D::of(2.0)).with(Verner98Efficient).rtol(D::of(1e-28)).atol(D::of(1e-28));
    let s = run.at(&times).record(kutta::Crossing::Any, |_, y| y[0] - D::of(0.6)).run().unwrap();
    assert_eq!(s.ts, times);
    for (t, y) in s.ts.iter().zip(&s.ys) {
        // Hermite interpolation of order 9 in steps that keep an error of order 9 below 1e-28.
        assert!((y[0] - D::ONE / (D::ONE + *t)).abs().hi() < 1e-25, "{t}");
    }
    let root = D::ONE / D::of(0.6) - D::ONE;
    assert!(s.events.len() == 1 && (s.events[0].t - root).abs().hi() < 1e-25);
    // From (1, 0) x'' = -x turns once round in 2 pi, of which 32 digits are known.
    let turn = D::sum(2.0 * std::f64::consts::PI, 2.4492935982947064e-16);
    let a = |_: D, x: &[D; 1], a: &mut [D; 1]| a[0] = -x[0];
    let run = solve_second(a, [D::ONE], [D::ZERO], D::ZERO..turn).with(methods::KahanLi8S17);
    let s = run.step(turn / D::of(2000.0)).run().unwrap();
    // (h/1)^8 times a constant far below one, h = 0.003.
    assert!((s.y[0] - D::ONE).abs().hi() < 1e-20 && s.v.unwrap()[0].abs().hi() < 1e-20);
}

/// A struct with parameters is a system; so are closures that answer and closures that do not.
#[test]
fn structs_and_closures() {
    struct Decay {
        rate: f64,
        calls: u64,
    }
    impl System<[f64; 1]> for Decay {
        fn rhs(&mut self, _t: f64, y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
            self.calls += 1;
            if y[0] < 0.0 {
                return Err(OutOfDomain);
            }
            dy[0] = -self.rate * y[0];
            Ok(())
        }
    }
    let exact = (-3f64).exp();
    let s = Ivp::new(Decay { rate: 1.5, calls: 0 }, [1.0], 0.0..2.0).rtol(1e-10).atol(1e-10).run().unwrap();
    assert!((s.y[0] - exact).abs() < 1e-9);
    let s = Ivp::new(Decay { rate: 1.5, calls: 0 }, [1.0], 0.0..2.0).with(Rk4).step(1e-3).run().unwrap();
    assert!((s.y[0] - exact).abs() < 1e-9);
    let answering = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
        dy[0] = -1.5 * y[0];
        if y[0] < 0.0 { Err(OutOfDomain) } else { Ok(()) }
    };
    let s = solve(answering, [1.0], 0.0..2.0).rtol(1e-10).atol(1e-10).run().unwrap();
    assert!((s.y[0] - exact).abs() < 1e-9);
    // A second-order system, and what borrows its surroundings mutably.
    struct Spring {
        k: f64,
    }
    impl System<[f64; 1]> for Spring {
        fn rhs(&mut self, _t: f64, x: &[f64; 1], a: &mut [f64; 1]) -> Result<(), OutOfDomain> {
            a[0] = -self.k * x[0];
            Ok(())
        }
    }
    let s = Ivp::second(Spring { k: 4.0 }, [1.0], [0.0], 0.0..1.0).step(1e-3).run().unwrap();
    assert!((s.y[0] - 2f64.cos()).abs() < 1e-6);
    let mut calls = 0;
    let counting = |_: f64, y: &[f64; 1], dy: &mut [f64; 1]| {
        calls += 1;
        dy[0] = -y[0];
    };
    let evaluations = solve(counting, [1.0], 0.0..1.0).run().unwrap().stats.evaluations;
    assert_eq!(evaluations, calls);
}
