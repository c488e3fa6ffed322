//! What breaks programs that solve differential equations, each with the answer it should get.

mod breaks;
mod domain;
mod not_finite;
mod scales;
mod small_steps;
mod spans;

use kutta::{Loaded, Method, methods};
use std::sync::LazyLock;

/// Every method with an error estimate, read at run time: one program steps them all.
static EVERY: LazyLock<Vec<Loaded>> = LazyLock::new(|| {
    let loaded = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
    loaded.filter(|method| method.form().adaptive()).collect()
});

/// The explicit ones.
static PAIRS: LazyLock<Vec<Loaded>> =
    LazyLock::new(|| EVERY.iter().filter(|method| method.form().explicit()).cloned().collect());

/// One of them.
fn pair(name: &str) -> Loaded {
    PAIRS.iter().find(|method| method.name() == name).expect(name).clone()
}

/// A right-hand side that must not be needed.
fn uncalled<const N: usize>(_: f64, _: &[f64; N], _: &mut [f64; N]) {
    panic!("f was called");
}
