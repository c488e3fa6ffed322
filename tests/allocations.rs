//! Steps do not allocate: a run of four times as many takes as many allocations, whatever is stepped.

use kutta::methods::{
    Ab4, Abm4Pece, Adams, Bdf, Bdf3, CashKarp54, Dop853, Dp54, Euler, ForestRuth4, Kvaerno5, RadauIia3, Rk4,
    Rodas5p, VelocityVerlet, Verlet,
};
use kutta::{Crossing, Ivp, Loaded, Method, Pattern, Scalar, State, Stats, methods, solve, solve_second};
use num_complex::Complex;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // The allocator is asked once more while a thread ends, when the counter is gone.
    let _ = COUNT.try_with(|count| count.set(count.get() + 1));
}

// SAFETY: all is passed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }
    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocations<T>(of: impl FnOnce() -> T) -> (u64, T) {
    let before = COUNT.get();
    let result = of();
    (COUNT.get() - before, result)
}

/// Runs over a span and over four times that: at least fifty steps more, not one allocation more.
fn assert_steps_do_not_allocate(what: &str, run: impl Fn(f64) -> Stats) {
    let (short, few) = allocations(|| run(10.0));
    let (long, many) = allocations(|| run(40.0));
    let steps = |stats: &Stats| stats.accepted + stats.rejected.total();
    assert!(steps(&many) >= steps(&few) + 50, "{what}: {} and {} steps", steps(&few), steps(&many));
    assert_eq!(long, short, "{what}: {} and {} steps", steps(&few), steps(&many));
}

/// Turns each pair of components, at a rate that varies: y' = (2 + cos t)(y2, -y1).
fn turn<Y: State<Scalar: Scalar<Real = f64>>>(t: f64, y: &Y, dy: &mut Y) {
    let rate = 2.0 + t.cos();
    for (dy, y) in dy.as_mut_slice().chunks_exact_mut(2).zip(y.as_slice().chunks_exact(2)) {
        (dy[0], dy[1]) = (y[1].scale(rate), y[0].scale(-rate));
    }
}

fn pull<Y: State<Scalar: Scalar<Real = f64>>>(t: f64, x: &Y, a: &mut Y) {
    for (a, x) in a.as_mut_slice().iter_mut().zip(x.as_slice()) {
        *a = x.scale(-2.0 - t.cos());
    }
}

fn read(name: &str) -> Loaded {
    let entry = methods::find(name).expect(name);
    Loaded::parse(entry.name, entry.text).expect(name)
}

/// Every family of methods on one type of state.
fn every_family<Y: State<Scalar: Scalar<Real = f64>>>(what: &str, y: &Y) {
    let run = |t1: f64| solve(turn, y.clone(), 0.0..t1).rtol(1e-7).atol(1e-7);
    let check = |method: &str, run: &dyn Fn(f64) -> Stats| {
        assert_steps_do_not_allocate(&format!("{what}, {method}"), run);
    };
    check("auto", &|t1| run(t1).run().unwrap().stats);
    check("dp54", &|t1| run(t1).with(Dp54).run().unwrap().stats);
    check("dop853", &|t1| run(t1).with(Dop853).run().unwrap().stats);
    check("cash-karp54", &|t1| run(t1).with(CashKarp54).run().unwrap().stats);
    check("rk4", &|t1| run(t1).with(Rk4).step(0.1).run().unwrap().stats);
    check("ab4", &|t1| run(t1).with(Ab4).step(0.1).run().unwrap().stats);
    check("abm4-pece", &|t1| run(t1).with(Abm4Pece).step(0.1).run().unwrap().stats);
    let second = |t1: f64| solve_second(pull, y.clone(), y.clone(), 0.0..t1).step(0.1);
    check("verlet", &|t1| second(t1).with(Verlet).run().unwrap().stats);
    check("velocity-verlet", &|t1| second(t1).with(VelocityVerlet).run().unwrap().stats);
    check("forest-ruth4", &|t1| second(t1).with(ForestRuth4).run().unwrap().stats);
    // Read at run time.
    check("dop853, read", &|t1| run(t1).with(read("dop853")).run().unwrap().stats);
    check("ab4, read", &|t1| run(t1).with(read("ab4")).step(0.1).run().unwrap().stats);
    // Implicit stages: room for the matrices is taken once.
    if y.as_slice().len() <= 40 {
        let run = |t1: f64| solve(turn, y.clone(), 0.0..t1).rtol(1e-5).atol(1e-5);
        check("adams", &|t1| run(t1).with(Adams).run().unwrap().stats);
        check("bdf", &|t1| run(t1).with(Bdf).run().unwrap().stats);
        check("bdf, read", &|t1| run(t1).with(read("bdf")).run().unwrap().stats);
        check("kvaerno5", &|t1| run(t1).with(Kvaerno5).run().unwrap().stats);
        check("rodas5p", &|t1| run(t1).with(Rodas5p).run().unwrap().stats);
        check("radau-iia3", &|t1| run(t1).with(RadauIia3).run().unwrap().stats);
        check("gauss2, read", &|t1| run(t1).with(read("gauss2")).step(0.1).run().unwrap().stats);
        check("bdf3", &|t1| run(t1).with(Bdf3).step(0.1).run().unwrap().stats);
    }
}

#[test]
fn arrays() {
    every_family("[f64; 2]", &[1.0, 0.5]);
    every_family("[f64; 40]", &[0.25; 40]);
    every_family("[Complex; 2]", &[Complex::new(1.0, 0.5), Complex::new(0.0, 1.0)]);
}

/// A method that is chosen takes its room when it is taken up.
#[test]
fn a_change_of_method() {
    let pull = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -1e4 * (y[0] - (9.0 * t).cos());
    let run = |t1: f64| {
        let run = solve(pull, [1.0], 0.0..t1).rtol(1e-6).atol(1e-6).run().unwrap();
        assert_eq!(run.choices.len(), 2);
        run.stats
    };
    assert_steps_do_not_allocate("auto, stiff", run);
}

#[test]
fn vectors() {
    every_family("Vec of 2", &vec![1.0, 0.5]);
    every_family("Vec of 1000", &vec![0.25; 1000]);
}

#[test]
fn nalgebra_vectors() {
    every_family("SVector of 2", &nalgebra::SVector::<f64, 2>::new(1.0, 0.5));
    every_family("SVector of 40", &nalgebra::SVector::<f64, 40>::repeat(0.25));
}

#[test]
fn faer_columns() {
    every_family("Col of 2", &faer::Col::from_fn(2, |i| 1.0 - 0.5 * i as f64));
    every_family("Col of 1000", &faer::Col::from_fn(1000, |i| 1.0 / (1.0 + i as f64)));
}

/// Matrices of every storage are taken once, whatever factors them; those that faer factors too.
#[test]
fn matrices() {
    // faer chooses its kernels when it is called first.
    let first = solve(turn::<Vec<f64>>, vec![0.25; 60], 0.0..1.0).with(Rodas5p).run();
    assert!(first.is_ok());
    let turn = turn::<Vec<f64>>;
    let pairs = (0..60).map(|i| (i, i ^ 1));
    for (what, pattern) in [
        ("small dense", Pattern::dense(20)),
        ("dense", Pattern::dense(60)),
        ("banded", Pattern::banded(60, 1, 1)),
        ("sparse", Pattern::sparse(60, pairs).unwrap()),
    ] {
        let n = pattern.n();
        let run = |t1: f64| {
            let ivp = solve(turn, vec![0.25; n], 0.0..t1).rtol(1e-5).atol(1e-5);
            ivp.pattern(pattern.clone()).mass(|m| (0..n).for_each(|i| m[(i, i)] = 1.0))
        };
        let check = |method: &str, run: &dyn Fn(f64) -> Stats| {
            assert_steps_do_not_allocate(&format!("{what} matrix, {method}"), run);
        };
        check("rodas5p", &|t1| run(t1).with(Rodas5p).run().unwrap().stats);
        check("kvaerno5", &|t1| run(t1).with(Kvaerno5).run().unwrap().stats);
        check("radau-iia3", &|t1| run(t1).with(RadauIia3).run().unwrap().stats);
    }
}

/// What looks on allocates when it saves, and not before.
#[test]
fn onlookers() {
    let watched = |what: &str, y: &Vec<f64>| {
        let run = |t1: f64| solve(turn, y.clone(), 0.0..t1).rtol(1e-7).atol(1e-7);
        let check = |onlooker: &str, run: &dyn Fn(f64) -> Stats| {
            assert_steps_do_not_allocate(&format!("{what}, {onlooker}"), run);
        };
        let far = |_: f64, y: &Vec<f64>| y[0] - 100.0;
        check("observer", &|t1| run(t1).observe(|_| ControlFlow::Continue(())).run().unwrap().stats);
        check("event", &|t1| run(t1).with(Dp54).record(Crossing::Any, far).run().unwrap().stats);
        check("event, extra stages", &|t1| {
            run(t1).with(Dop853).record(Crossing::Any, far).run().unwrap().stats
        });
        check("event, Hermite", &|t1| {
            run(t1).with(CashKarp54).record(Crossing::Any, far).run().unwrap().stats
        });
        check("event, read", &|t1| {
            run(t1).with(read("rkf45")).record(Crossing::Any, far).run().unwrap().stats
        });
        check("event, multistep", &|t1| {
            run(t1).with(Ab4).step(0.1).record(Crossing::Any, far).run().unwrap().stats
        });
    };
    watched("Vec of 2", &vec![1.0, 0.5]);
    // One state saved at the end is one allocation, however many steps lie before.
    let at_end = |t1: f64| solve(turn, vec![1.0, 0.5], 0.0..t1).rtol(1e-7).at(&[t1]).run().unwrap().stats;
    assert_steps_do_not_allocate("requested end", at_end);
    let array = |t1: f64| {
        let run = solve(turn, [1.0, 0.5], 0.0..t1).rtol(1e-7).with(read("rkf45"));
        run.record(Crossing::Any, |_, y| y[0] - 100.0).run().unwrap().stats
    };
    assert_steps_do_not_allocate("[f64; 2], event, read", array);
}

/// Steps that are refused, rejected or spoiled are as cheap.
#[test]
fn rejected_steps() {
    let rejecting = |t1: f64| {
        let mut calls = 0;
        let f = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
            calls += 1;
            turn(t, y, dy);
            match calls % 50 {
                20 => dy[0] = f64::NAN,
                40 => return Err(kutta::OutOfDomain),
                10 => dy[1] += 1.0,
                _ => {}
            }
            Ok(())
        };
        let s = solve(f, [1.0, 0.5], 0.0..t1).rtol(1e-7).atol(1e-7).with(read("rkf45")).run().unwrap();
        let rejected = s.stats.rejected;
        assert!(rejected.error > 5 && rejected.domain > 5 && rejected.non_finite > 5, "{rejected:?}");
        s.stats
    };
    assert_steps_do_not_allocate("rejections", rejecting);
}

/// An iterator over arrays hands them out by value.
#[test]
fn iterated_steps() {
    type Rhs = fn(f64, &[f64; 2], &mut [f64; 2]);
    fn stepped<M: Method, P: kutta::Pace>(ivp: Ivp<'_, [f64; 2], Rhs, M, P>) -> u64 {
        ivp.steps().filter(|step| step.is_ok()).count() as u64
    }
    let f: Rhs = turn;
    let count = |t1: f64| {
        let accepted = stepped(solve(f, [1.0, 0.5], 0.0..t1).rtol(1e-9))
            + stepped(solve(f, [1.0, 0.5], 0.0..t1).with(Euler).step(0.1));
        let mut stats = Stats::default();
        stats.accepted = accepted;
        stats
    };
    assert_steps_do_not_allocate("iterator", count);
}
