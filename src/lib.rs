//! kutta
pub mod methods;
pub mod problems;
mod solve;
mod step;
pub mod tableau;

pub use solve::control::Controller;
pub use solve::event::Crossing;
pub use solve::ivp::{Ivp, solve, solve_second};
pub use solve::outcome::{Interpolant, Occurrence, Rejections, Solution, Stats, Stopped, Why};
pub use solve::run::{Adaptive, Fixed, Pace};
pub use solve::steps::Steps;
pub use solve::watch::Step;
pub use step::method::{Loaded, Method};
pub use step::norm::Tolerance;
pub use step::scalar::{Real, Scalar};
pub use step::state::{RealOf, State};
pub use step::system::{OutOfDomain, System, Verdict};
