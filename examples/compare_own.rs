//! Which method is the fastest for a system of your own?
//!
//! `cargo run --release --example compare_own`

use kutta::compare::{Comparison, ranking_at};
use kutta::methods::{Dp54, Rk4, Tsit54, Verner76Efficient, Verner87Efficient};

fn main() -> Result<(), kutta::compare::Unfit> {
    // A pendulum, pushed: angle and angular velocity. Nobody knows its solution, so a tight run serves.
    let pushed = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        *dy = [y[1], -y[0].sin() - 0.1 * y[1] + 0.5 * (1.5 * t).cos()];
    };
    let outcome = Comparison::new("pushed pendulum", pushed, [0.5, 0.0], 0.0..20.0)
        .method(Dp54)
        .method(Tsit54)
        .method(Verner76Efficient)
        .method(Verner87Efficient)
        .fixed(Rk4)
        .run()?;
    for error in [1e-3, 1e-6, 1e-9] {
        println!("to an error of {error:e}:");
        for cost in ranking_at(&outcome.rows, "pushed pendulum", error) {
            println!("{:>22}{:8.1} us", cost.method, 1e6 * cost.seconds);
        }
    }
    println!("Errors are measured against {:?}.", outcome.reference);
    Ok(())
}
