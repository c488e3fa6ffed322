//! kutta solves ordinary differential equations with methods written as data.
//!
//! ```
//! use kutta::{methods::Verner87Efficient, solve};
//!
//! // Lorenz (1963): dy = f(t, y), written into dy.
//! let lorenz = |_t: f64, y: &[f64; 3], dy: &mut [f64; 3]| {
//!     dy[0] = 10.0 * (y[1] - y[0]);
//!     dy[1] = y[0] * (28.0 - y[2]) - y[1];
//!     dy[2] = y[0] * y[1] - 8.0 / 3.0 * y[2];
//! };
//! let run = solve(lorenz, [1.0, 1.0, 1.0], 0.0..10.0).with(Verner87Efficient).rtol(1e-9).run()?;
//! assert!((run.y[2] - 24.69085810279056).abs() < 1e-5);
//! # Ok::<(), kutta::Stopped<[f64; 3]>>(())
//! ```
//!
//! # The map
//!
//! - [`solve`], [`solve_second`]: the way in, for y' = f(t, y) and y'' = f(t, y). They give an [`Ivp`],
//!   whose methods are the options; [`Ivp::run`] gives a [`Solution`], or a [`Stopped`] with everything
//!   computed so far.
//! - [`methods`]: a type for every method, one per file of `tableaus/`. [`tableau!`] makes one of a file of
//!   yours, [`Loaded`] reads one at run time.
//! - [`tableau`](mod@tableau): what a method file holds, its proof and its derived properties; the one form that steps.
//! - [`State`], [`Scalar`], [`System`]: what can be stepped: arrays, `Vec`, nalgebra vectors, faer columns
//!   of `f64`, `f32`, complex numbers or [`tableau::DoubleDouble`].
//! - [`problems`]: a catalogue with references to many digits.
//! - [`compare`]: speed against error, for the catalogue and for a system of your own.
//! - [`normals`]: normal maps from height maps, and what bump mapping needs around them; [`stencil!`] makes a
//!   stencil of a file of yours.
//!
//! # Stiff problems
//!
//! ```
//! use kutta::solve;
//!
//! // Robertson (1966): rates from 0.04 to 3e7, hopeless for an explicit method.
//! let robertson = |_t: f64, y: &[f64; 3], dy: &mut [f64; 3]| {
//!     dy[0] = -0.04 * y[0] + 1e4 * y[1] * y[2];
//!     dy[2] = 3e7 * y[1] * y[1];
//!     dy[1] = -dy[0] - dy[2];
//! };
//! let run = solve(robertson, [1.0, 0.0, 0.0], 0.0..40.0).rtol(1e-6).atol(1e-10).run()?;
//! assert!((run.y[0] - 0.7158270687).abs() < 1e-6 && run.stats.accepted < 200);
//! // From where on which method, and why.
//! assert_eq!(run.choices[1].method, "rodas5p");
//! # Ok::<(), kutta::Stopped<[f64; 3]>>(())
//! ```
//!
//! No method was named: the run began with an explicit one and found out ([`Auto`]). Any method with implicit
//! stages will do as well; the Jacobian is found by differences unless [`Ivp::jacobian`] or [`Dual`] gives it.
//! [`Ivp::approximate_jacobian`] gives a matrix near it, which iterations correct and W-methods such as
//! [`methods::Ros34pw2`] take as it is. [`methods::Bdf`] chooses its order with its step, and so does [`methods::Adams`] where nothing is stiff and f
//! costs much. [`solve_split`] takes f in two parts, of which an IMEX pair solves for one.
//!
//! # Large and differential-algebraic systems
//!
//! ```
//! use kutta::{Pattern, methods::Rodas5p, solve};
//!
//! // Heat in a rod of 500 points, both ends held: the first and the last equation are algebraic.
//! let n = 500;
//! let rod = |_t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| {
//!     for i in 1..n - 1 {
//!         dy[i] = 1e4 * (y[i - 1] - 2.0 * y[i] + y[i + 1]);
//!     }
//!     (dy[0], dy[n - 1]) = (y[0], y[n - 1] - 1.0);
//! };
//! let mut start = vec![0.0; n];
//! start[n - 1] = 1.0;
//! let run = solve(rod, start, 0.0..100.0)
//!     .with(Rodas5p)
//!     .pattern(Pattern::banded(n, 1, 1))
//!     .mass(|m| (1..n - 1).for_each(|i| m[(i, i)] = 1.0))
//!     .run()?;
//! assert!((run.y[250] - 250.0 / 499.0).abs() < 1e-5);
//! # Ok::<(), kutta::Stopped<Vec<f64>>>(())
//! ```
//!
//! A [`Pattern`] tells which entries of the Jacobian can be other than zero: the linear systems are then
//! banded or sparse, and a difference of f serves many columns at once. [`Ivp::detect_pattern`] finds it. [`Dual`]
//! makes the Jacobian of a right-hand side that is generic over its numbers. [`Ivp::mass`] solves
//! M y' = f(t, y), also where M is singular; [`Ivp::consistent`] mends a start that its algebraic equations
//! do not allow.
//!
//! # Steps of one size, for a scene
//!
//! ```
//! use kutta::{methods::VelocityVerlet, solve_second};
//!
//! // A spring at 60 frames a second: the force follows from the position.
//! let spring = |_t: f64, x: &[f64; 1], a: &mut [f64; 1]| a[0] = -40.0 * x[0];
//! let run = solve_second(spring, [1.0], [0.0], 0.0..2.0).with(VelocityVerlet).step(1.0 / 60.0).run()?;
//! let exact = (40f64.sqrt() * 2.0).cos();
//! assert!((run.y[0] - exact).abs() < 0.02 && run.stats.accepted == 120);
//! # Ok::<(), kutta::Stopped<[f64; 1]>>(())
//! ```
//!
//! Fixed steps give the same bits on every machine. Adaptive steps use fused products and sums where the
//! processor has them, so their last digits may differ between machines.

pub mod compare;
pub mod linear;
pub mod methods;
pub mod normals;
pub mod problems;
mod solve;
mod step;
pub mod tableau;

pub use linear::{Dual, Field, Jacobian, Mass, Misplaced, Pattern};
pub use num_dual::DualNum;
pub use solve::auto::{Auto, Choice, Reason};
pub use solve::control::Controller;
pub use solve::event::Crossing;
pub use solve::ivp::{Ivp, solve, solve_second, solve_split};
pub use solve::leg::{Adaptive, Fixed, Pace};
pub use solve::outcome::{Interpolant, Occurrence, Rejections, Solution, Stats, Stopped, Why};
pub use solve::steps::Steps;
pub use solve::watch::Step;
pub use step::method::{Loaded, Method};
pub use step::norm::Tolerance;
pub use step::scalar::{Real, Scalar};
pub use step::split::Split;
pub use step::state::{RealOf, State};
pub use step::system::{OutOfDomain, System, Verdict, WithJacobian};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
