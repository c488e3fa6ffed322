//! The matrices of implicit stages: dense, banded and sparse ones give the same solutions, patterns are told from
//! wrong ones, and differences are taken by groups of columns.

use kutta::problems::{Brusselator1dN40, Problem};
use kutta::tableau::DoubleDouble;
use kutta::{Dual, DualNum, Field, Ivp, Jacobian, Loaded, OutOfDomain, Pattern, System, Why, methods, solve};
use num_complex::Complex;

const N: usize = 80;

fn method(name: &str) -> Loaded {
    let entry = methods::find(name).unwrap();
    Loaded::parse(entry.name, entry.text).unwrap()
}

/// The Brusselator on the heap.
fn rhs(t: f64, y: &Vec<f64>, dy: &mut Vec<f64>) {
    let (Ok(y), Ok(dy)) = (y.as_slice().try_into(), dy.as_mut_slice().try_into()) else {
        panic!("80 components")
    };
    Brusselator1dN40.rhs(t, y, dy);
}

fn jacobian(t: f64, y: &Vec<f64>, j: &mut Jacobian<f64>) {
    let Ok(y) = y.as_slice().try_into() else { panic!("80 components") };
    Brusselator1dN40.jacobian(t, y, |row, column, value| j[(row, column)] += value);
}

fn heap<'w>() -> Ivp<'w, Vec<f64>, fn(f64, &Vec<f64>, &mut Vec<f64>)> {
    Ivp::new(rhs as fn(f64, &Vec<f64>, &mut Vec<f64>), Brusselator1dN40.y0().to_vec(), 0.0..10.0)
}

fn sparse() -> Pattern {
    let mut places = vec![];
    let y = Brusselator1dN40.y0();
    Brusselator1dN40.jacobian(0.0, &y, |row, column, _| places.push((row, column)));
    Pattern::sparse(N, places).unwrap()
}

#[test]
fn every_storage_gives_the_solution_of_the_array() {
    let reference = Brusselator1dN40.reference().unwrap();
    let off = |y: &[f64]| y.iter().zip(&reference).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
    for name in ["rodas5p", "radau-iia3"] {
        let f = |t: f64, y: &[f64; N], dy: &mut [f64; N]| Brusselator1dN40.rhs(t, y, dy);
        let small = solve(f, Brusselator1dN40.y0(), 0.0..10.0).with(method(name)).rtol(1e-4).atol(1e-4);
        let small = small.run().unwrap();
        for (what, pattern) in [
            ("dense", Pattern::dense(N)),
            ("banded", Pattern::banded(N, 2, 2)),
            ("wider band", Pattern::banded(N, 5, 3)),
            ("sparse", sparse()),
        ] {
            for given in [true, false] {
                // One of the two is enough where a Jacobian by differences takes eighty evaluations.
                if what == "dense" && !given {
                    continue;
                }
                let ivp = heap().with(method(name)).pattern(pattern.clone()).rtol(1e-4).atol(1e-4);
                let run = if given { ivp.jacobian(jacobian).run() } else { ivp.run() }.unwrap();
                let what = format!("{name}, {what}, Jacobian given: {given}");
                assert!(off(&run.y) < 2.0 * off(&small.y), "{what}: {:e}", off(&run.y));
                // The last bits of the factors differ, and with them now and then a step.
                let ratio = run.stats.accepted as f64 / small.stats.accepted as f64;
                assert!((0.95..1.05).contains(&ratio), "{what}: {:?} {:?}", run.stats, small.stats);
            }
        }
    }
}

#[test]
fn a_group_of_columns_takes_one_evaluation() {
    let run = |pattern: Option<Pattern>| {
        let ivp =
            Ivp::new(rhs as fn(f64, &Vec<f64>, &mut Vec<f64>), Brusselator1dN40.y0().to_vec(), 0.0..0.1);
        let ivp = ivp.with(methods::Rodas5p).step(0.01);
        let ivp = match pattern {
            Some(pattern) => ivp.pattern(pattern),
            None => ivp,
        };
        let stats = ivp.run().unwrap().stats;
        assert_eq!((stats.jacobians, stats.accepted), (10, 10));
        // Eight stages, and the derivative by time.
        stats.evaluations / 10 - 9
    };
    assert_eq!(run(None), N as u64);
    assert_eq!(run(Some(Pattern::dense(N))), N as u64);
    assert_eq!(run(Some(Pattern::banded(N, 2, 2))), 5);
    assert_eq!(run(Some(Pattern::banded(N, 3, 2))), 6);
    // A row has four entries, or five columns side by side with one that misses: four groups are the least.
    let groups = run(Some(sparse()));
    assert!((4..=6).contains(&groups), "{groups}");
}

#[test]
fn a_pattern_is_detected() {
    let span = 0.0..0.1;
    let ivp = || {
        let f = rhs as fn(f64, &Vec<f64>, &mut Vec<f64>);
        Ivp::new(f, Brusselator1dN40.y0().to_vec(), span.clone()).with(methods::Rodas5p).step(0.01)
    };
    let given = ivp().pattern(Pattern::banded(N, 2, 2)).run().unwrap();
    let found = ivp().detect_pattern().run().unwrap();
    assert_eq!(given.y, found.y);
    // Three points, and from each every component moved.
    assert_eq!(found.stats.evaluations - given.stats.evaluations, 3 * (N as u64 + 1));
    // An entry that f has at no such point is missed: it costs steps, not digits, where stages are iterated.
    let hidden = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
        for i in 0..20 {
            dy[i] = -(1.0 + i as f64) * y[i];
        }
        dy[0] += (y[19] - 1.5).max(0.0);
    };
    let run = solve(hidden, vec![1.0; 20], 0.0..1.0).with(methods::Kvaerno5).detect_pattern();
    let run = run.rtol(1e-8).atol(1e-8).run().unwrap();
    for (i, y) in run.y.iter().enumerate() {
        assert!((y - (-(1.0 + i as f64)).exp()).abs() < 1e-7, "{i}: {y}");
    }
}

/// y_0' sees every component and every component sees y_0: an arrow, far from a band.
struct Arrow {
    stray: bool,
}

impl System<Vec<f64>> for Arrow {
    fn rhs(&mut self, _t: f64, y: &Vec<f64>, dy: &mut Vec<f64>) -> Result<(), OutOfDomain> {
        let n = y.len() as f64;
        dy[0] = y[1..].iter().sum::<f64>() / n - y[0];
        for i in 1..y.len() {
            dy[i] = -(i as f64) * (y[i] - y[0]);
        }
        Ok(())
    }
    fn jacobian(&mut self, _t: f64, y: &Vec<f64>, j: &mut Jacobian<f64>) -> bool {
        let n = y.len();
        j[(0, 0)] = -1.0;
        for i in 1..n {
            (j[(0, i)], j[(i, 0)], j[(i, i)]) = (1.0 / n as f64, i as f64, -(i as f64));
        }
        // A zero beside the pattern is none.
        j[(3, 7)] += 0.0;
        if self.stray {
            j[(5, 9)] = 2.0;
            j[(6, 9)] = 3.0;
        }
        true
    }
    fn pattern(&self) -> Option<Pattern> {
        Pattern::of(60, (0..60).flat_map(|i| [(0, i), (i, 0)])).ok()
    }
}

#[test]
fn a_system_may_have_its_pattern() {
    let start: Vec<f64> = (0..60).map(|i| f64::from(i % 7)).collect();
    let f = |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| Arrow { stray: false }.rhs(t, y, dy).unwrap();
    let full = solve(f, start.clone(), 0.0..5.0).with(methods::Rodas5p).rtol(1e-8).run().unwrap();
    let run = Ivp::new(Arrow { stray: false }, start.clone(), 0.0..5.0)
        .with(methods::Rodas5p)
        .rtol(1e-8)
        .run()
        .unwrap();
    for (a, b) in run.y.iter().zip(&full.y) {
        assert!((a - b).abs() < 1e-8 * (1.0 + a.abs()), "{a} {b}");
    }
    let stop = Ivp::new(Arrow { stray: true }, start, 0.0..5.0).with(methods::Rodas5p).run().unwrap_err();
    assert_eq!(stop.why, Why::OutsidePattern { row: 5, column: 9 });
    assert!(stop.to_string().contains("(5, 9)"), "{stop}");
    assert_eq!(stop.solution.stats.rejected.total(), 1);
}

#[test]
fn a_pattern_that_does_not_fit_is_told() {
    let stop = heap().with(methods::Rodas5p).pattern(Pattern::banded(79, 2, 2)).run().unwrap_err();
    assert_eq!(stop.to_string(), "the pattern has 79 rows but y0 80 components");
    let outside = Pattern::sparse(3, [(0, 1), (3, 2)]).unwrap_err();
    assert_eq!((outside.row, outside.column, outside.n), (3, 2, 3));
    assert!(outside.to_string().contains("(3, 2)"));
    // An index beyond the matrix is no other entry.
    let f = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-y[0], -y[1]];
    let far = |_t: f64, _y: &[f64; 2], j: &mut Jacobian<f64>| j[(2, 0)] = 1.0;
    let stop = solve(f, [1.0, 1.0], 0.0..1.0).with(methods::Rodas5p).jacobian(far).run().unwrap_err();
    assert_eq!(stop.why, Why::OutsidePattern { row: 2, column: 0 });
}

#[test]
fn singular_matrices_and_nans_are_told_in_every_storage() {
    let n = 60;
    let patterns = [
        Pattern::dense(n),
        Pattern::banded(n, 1, 1),
        Pattern::sparse(n, (1..n).map(|i| (i, i - 1))).unwrap(),
    ];
    for pattern in patterns {
        let f = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
            dy.iter_mut().zip(y).for_each(|(d, y)| *d = -y);
            dy[17] = 10.0 * y[17];
        };
        // I - h J is zero in column 17 for h = 0.1.
        let ten = |_t: f64, _y: &Vec<f64>, j: &mut Jacobian<f64>| {
            (0..60).for_each(|i| j[(i, i)] = -1.0);
            j[(17, 17)] = 10.0;
        };
        let ivp = || solve(f, vec![1.0; n], 0.0..1.0).pattern(pattern.clone());
        let stop = ivp().jacobian(ten).with(methods::BackwardEuler).step(0.1).run().unwrap_err();
        // faer exchanges columns for sparsity, so that a later one may be named.
        assert!(matches!(stop.why, Why::Singular { .. }), "{pattern:?}: {stop}");
        let nan = |_t: f64, _y: &Vec<f64>, j: &mut Jacobian<f64>| j[(40, 39)] = f64::NAN;
        let stop = ivp().jacobian(nan).with(methods::Rodas5p).run();
        if pattern.contains(40, 39) {
            assert_eq!(stop.unwrap_err().why, Why::Jacobian { component: 40 }, "{pattern:?}");
        }
    }
}

/// y' = -(i + 1) y + y of the neighbour before.
#[allow(clippy::ptr_arg)] // the state is a Vec
fn chain<T: kutta::Scalar>(_t: T::Real, y: &Vec<T>, dy: &mut Vec<T>) {
    let mut rate = T::zero();
    for i in 0..y.len() {
        rate = rate + T::one();
        dy[i] = -(rate * y[i]);
        if i > 0 {
            dy[i] = dy[i] + y[i - 1];
        }
    }
}

#[test]
fn every_number_can_be_stored_in_every_way() {
    fn check<T: kutta::Scalar>(rtol: f64, real: impl Fn(f64) -> T::Real, one: T) {
        let n = 50;
        let places = (1..n).map(|i| (i, i - 1));
        let run = |pattern: Pattern, name: &str| {
            let f = chain::<T> as fn(T::Real, &Vec<T>, &mut Vec<T>);
            let ivp = Ivp::new(f, vec![one; n], real(0.0)..real(1.0)).with(method(name));
            ivp.pattern(pattern).rtol(real(rtol)).atol(real(rtol)).run().unwrap().y
        };
        for name in ["rodas5p", "radau-iia3"] {
            let dense = run(Pattern::dense(n), name);
            for pattern in [Pattern::banded(n, 1, 0), Pattern::sparse(n, places.clone()).unwrap()] {
                let other = run(pattern, name);
                for (a, b) in dense.iter().zip(&other) {
                    assert!(kutta::Real::to_f64((*a - *b).modulus()) < 10.0 * rtol, "{name}: {a:?} {b:?}");
                }
            }
        }
    }
    check::<f64>(1e-8, |x| x, 1.0);
    check::<f32>(1e-4, |x| x as f32, 1.0);
    check::<Complex<f64>>(1e-8, |x| x, Complex::new(0.5, 1.0));
    check::<DoubleDouble>(1e-12, DoubleDouble::of, DoubleDouble::ONE);
}

/// A reaction with a rate that varies with time, generic over its numbers.
struct Reaction;

impl Field for Reaction {
    fn rhs<T: DualNum<Primitive = f64> + Copy>(&self, t: T, y: &[T], dy: &mut [T]) {
        let rate = (t * 3.0).sin() + 2.0;
        dy[0] = -rate * y[0] * y[1].exp();
        dy[1] = rate * y[0] - y[1].powi(2) * 50.0;
    }
}

#[test]
fn dual_numbers_give_the_derivatives_to_rounding() {
    let (t, y) = (0.7f64, [0.4f64, 0.3]);
    let mut dual = Dual::of(Reaction);
    let rate = (3.0 * t).sin() + 2.0;
    let e = y[1].exp();
    let exact = [[-rate * e, -rate * y[0] * e], [rate, -100.0 * y[1]]];
    let mut dfdt = [0.0; 2];
    assert!(dual.time_derivative(t, &y, &mut dfdt));
    let slope = 3.0 * (3.0 * t).cos();
    assert!((dfdt[0] + slope * y[0] * e).abs() < 1e-14 && (dfdt[1] - slope * y[0]).abs() < 1e-14, "{dfdt:?}");
    // A run sees the Jacobian: one that writes both down takes the same steps.
    let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| Reaction.rhs(t, y, dy);
    let given = |t: f64, y: &[f64; 2], j: &mut Jacobian<f64>| {
        let rate = (3.0 * t).sin() + 2.0;
        (j[(0, 0)], j[(0, 1)]) = (-rate * y[1].exp(), -rate * y[0] * y[1].exp());
        (j[(1, 0)], j[(1, 1)]) = (rate, -100.0 * y[1]);
        if t == 0.7 {
            assert_eq!([[j[(0, 0)], j[(0, 1)]], [j[(1, 0)], j[(1, 1)]]], exact);
        }
    };
    let ivp = solve(f, y, 0.7..3.0).with(methods::RadauIia3).rtol(1e-9).atol(1e-9);
    let written = ivp.jacobian(given).run().unwrap();
    let found = Ivp::new(dual, y, 0.7..3.0).with(methods::RadauIia3).rtol(1e-9).atol(1e-9).run().unwrap();
    assert_eq!(
        (found.stats.accepted, found.stats.evaluations),
        (written.stats.accepted, written.stats.evaluations)
    );
    assert!((found.y[0] - written.y[0]).abs() < 1e-13 && (found.y[1] - written.y[1]).abs() < 1e-13);
}

/// Diffusion with a cubic source, with its pattern.
struct Rod;

impl Field for Rod {
    fn rhs<T: DualNum<Primitive = f64> + Copy>(&self, _t: T, y: &[T], dy: &mut [T]) {
        for i in 0..y.len() {
            let left = if i > 0 { y[i - 1] } else { y[i] };
            let right = if i + 1 < y.len() { y[i + 1] } else { y[i] };
            dy[i] = (left - y[i] * 2.0 + right) * 1e3 - y[i].powi(3);
        }
    }
    fn pattern(&self) -> Option<Pattern> {
        Some(Pattern::banded(100, 1, 1))
    }
}

#[test]
fn dual_numbers_take_groups_of_columns() {
    let start: Vec<f64> = (0..100).map(|i| f64::from(i % 10)).collect();
    let dual =
        Ivp::new(Dual::of(Rod), start.clone(), 0.0..1.0).with(methods::RadauIia3).rtol(1e-8).run().unwrap();
    let f = |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| Rod.rhs(t, y, dy);
    let plain = solve(f, start, 0.0..1.0).with(methods::RadauIia3).rtol(1e-8).run().unwrap();
    for (a, b) in dual.y.iter().zip(&plain.y) {
        assert!((a - b).abs() < 1e-7, "{a} {b}");
    }
    assert!(dual.stats.evaluations < plain.stats.evaluations);
}
