//! Speed against error: methods on one problem, each swept over tolerances or step sizes.
//!
//! ```
//! use kutta::compare::{Comparison, fastest_at};
//! use kutta::methods::{Dp54, Rk4, Tsit54};
//!
//! let swing = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -y[0].sin()];
//! let outcome = Comparison::new("swing", swing, [1.0, 0.0], 0.0..10.0)
//!     .method(Dp54)
//!     .method(Tsit54)
//!     .fixed(Rk4)
//!     .tolerances(&[1e-3, 1e-5, 1e-7])
//!     .run()?;
//! let best = fastest_at(&outcome.rows, "swing", 1e-4).expect("one of them gets there");
//! println!("{}: {:.1} us", best.method, best.seconds * 1e6);
//! # Ok::<(), kutta::compare::Unfit>(())
//! ```
//!
//! Speed alone says nothing: a method is fast if it needs little time *for the error it leaves*. Every row
//! has both, and [`fastest_at`] reads the time to a given error off them.

mod analyse;
mod entrant;
pub mod hard;
mod measure;
mod truth;

pub use analyse::{Cost, cost_at, fastest_at, ranking_at};
pub use truth::Reference;

use crate::solve::auto::Auto;
use crate::solve::leg::{Adaptive, Fixed};
use crate::step::method::Method;
use crate::step::state::State;
use crate::step::system::{System, Verdict};
use entrant::{Entrant, Posed, Typed};
use std::fmt;
use std::ops::Range;
use std::time::Duration;

/// One method at one tolerance or step size.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    pub problem: String,
    pub method: String,
    /// rtol of an adaptive run, whose atol is rtol times the scale; the step size of a fixed-step run.
    pub tolerance: f64,
    /// Largest |y - reference| / (|reference| + scale) over the components at the end of the span.
    pub error: Option<f64>,
    /// The same, largest over 32 times along the way, between steps through dense output.
    pub max_error: Option<f64>,
    /// Shortest of the repeats, from nothing to the state at the end.
    pub seconds_min: Option<f64>,
    pub seconds_median: Option<f64>,
    /// Evaluations of the right-hand side; up to the failure if there is one, like all counts.
    pub evaluations: u64,
    /// Jacobians taken and matrices factored, by methods with implicit stages.
    pub jacobians: u64,
    pub factorizations: u64,
    pub accepted: u64,
    pub rejected: u64,
    /// Why there is no error and no time. A run that ends, however wrong, is not a failure.
    pub failure: Option<String>,
}

/// What a comparison found.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Method by method in the order they were entered, each from loose to tight.
    pub rows: Vec<Row>,
    /// What the errors at the end are measured against.
    pub reference: Reference,
}

/// A comparison that cannot be run.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum Unfit {
    NoMethod,
    /// A tolerance or a step size that is not a positive number.
    NotPositive(f64),
    /// The reference or the exact solution has another number of components than the state.
    Length {
        given: usize,
        needed: usize,
    },
    /// No reference was given, and the tight run in its place failed.
    NoReference(String),
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Unfit::NoMethod => f.write_str("there is no method to compare: add one with method or fixed"),
            Unfit::NotPositive(x) => write!(f, "a tolerance or step is {x}: it must be positive"),
            Unfit::Length { given, needed } => {
                write!(f, "the reference has {given} components: the state has {needed}")
            }
            Unfit::NoReference(why) => write!(f, "give a reference: the run that should make one {why}"),
        }
    }
}

impl std::error::Error for Unfit {}

/// The name of a method in [`Row`]s: [`Auto::NAME`] where it is chosen in the course of the run.
pub fn label<M: Method>(method: &M) -> &str {
    if M::AUTO { Auto::NAME } else { method.name() }
}

/// A problem and the methods that are to solve it.
pub struct Comparison<'w, Y, S> {
    posed: Posed<Y, S>,
    problem: String,
    plan: Plan,
    entrants: Vec<Box<dyn Entrant + 'w>>,
    end: Option<Vec<f64>>,
    exact: Option<Box<dyn Fn(f64) -> Vec<f64> + 'w>>,
    progress: Box<dyn FnMut(f64) + 'w>,
}

/// What every entrant is put through.
pub(crate) struct Plan {
    tolerances: Vec<f64>,
    /// Empty: halved from a coarse one on.
    steps: Vec<f64>,
    scale: f64,
    budget: Duration,
    longest: Duration,
}

impl<'w, Y: State<Scalar = f64> + 'w, S: System<Y> + Clone + 'w> Comparison<'w, Y, S> {
    /// Methods for y' = f(t, y) from `y0` over a span of time; `f` is a closure as for
    /// [`solve`](crate::solve).
    pub fn new<R: Verdict>(problem: &str, f: S, y0: Y, span: Range<f64>) -> Self
    where
        S: FnMut(f64, &Y, &mut Y) -> R,
    {
        Self::of(problem, Posed { system: f, y0, v0: None, span })
    }

    /// The same as [`new`](Self::new), for a struct that is a [`System`], which may know its Jacobian.
    pub fn of_system(problem: &str, system: S, y0: Y, span: Range<f64>) -> Self {
        Self::of(problem, Posed { system, y0, v0: None, span })
    }

    /// Methods for y'' = f(t, y) from the position `y0` and the velocity `v0`. States of the reference and
    /// of the exact solution are the position followed by the velocity.
    pub fn second_order<R: Verdict>(problem: &str, f: S, y0: Y, v0: Y, span: Range<f64>) -> Self
    where
        S: FnMut(f64, &Y, &mut Y) -> R,
    {
        Self::of(problem, Posed { system: f, y0, v0: Some(v0), span })
    }

    fn of(problem: &str, posed: Posed<Y, S>) -> Self {
        let plan = Plan {
            tolerances: (2..=14).map(|k| 10f64.powi(-k)).collect(),
            steps: vec![],
            scale: 1.0,
            budget: Duration::from_secs(3),
            longest: Duration::from_millis(200),
        };
        let progress = Box::new(|_| {});
        let problem = problem.to_string();
        Self { posed, problem, plan, entrants: vec![], end: None, exact: None, progress }
    }

    /// Enters a method with an error estimate, which runs at each tolerance.
    pub fn method<M: Method + 'w>(mut self, method: M) -> Self {
        self.entrants.push(Box::new(Typed::<Y, S, M, Adaptive>::new(method, self.posed.clone())));
        self
    }

    /// Enters a method that runs at each step size. Methods with an error estimate may enter here as well.
    pub fn fixed<M: Method + 'w>(mut self, method: M) -> Self {
        self.entrants.push(Box::new(Typed::<Y, S, M, Fixed>::new(method, self.posed.clone())));
        self
    }

    /// Takes over the methods of another comparison of the same problem: those for y'' = f(t, y) to those
    /// for its first-order system, whose state must then be the position followed by the velocity.
    pub fn and<Y2, S2>(mut self, other: Comparison<'w, Y2, S2>) -> Self {
        self.entrants.extend(other.entrants);
        self
    }

    /// rtol for each adaptive run. Default 1e-2, 1e-3, ..., 1e-14.
    pub fn tolerances(mut self, tolerances: &[f64]) -> Self {
        self.plan.tolerances = tolerances.to_vec();
        self
    }

    /// The step size of each fixed-step run. Default: the span over 16, 32, 64, ..., until rounding stops the
    /// gain or a run takes too long.
    pub fn steps(mut self, steps: &[f64]) -> Self {
        self.plan.steps = steps.to_vec();
        self
    }

    /// The state at the end of the span, known from elsewhere. Default: the exact solution, else a tight run.
    pub fn reference(mut self, end: &[f64]) -> Self {
        self.end = Some(end.to_vec());
        self
    }

    /// The solution as a function of time. Default: a tight run.
    pub fn exact<A: AsRef<[f64]>>(mut self, exact: impl Fn(f64) -> A + 'w) -> Self {
        self.exact = Some(Box::new(move |t| exact(t).as_ref().to_vec()));
        self
    }

    /// The size below which a component does not matter, in errors and in atol. Default 1.
    pub fn scale(mut self, scale: f64) -> Self {
        self.plan.scale = scale;
        self
    }

    /// Time spent on repeats, over and above three of each run. Default three seconds.
    pub fn budget(mut self, budget: Duration) -> Self {
        self.plan.budget = budget;
        self
    }

    /// A run that takes longer is given up, and with it the tighter runs of its method. Default 0.2 s.
    pub fn longest(mut self, longest: Duration) -> Self {
        self.plan.longest = longest;
        self
    }

    /// Hears from time to time which part of the work is done, from 0 to 1.
    pub fn progress(mut self, progress: impl FnMut(f64) + 'w) -> Self {
        self.progress = Box::new(progress);
        self
    }

    /// Runs every method at every tolerance or step size: once to learn its error, then, all by turns, for
    /// its time.
    ///
    /// # Errors
    /// What makes no sense or is missing. A method that fails is a row, not an error.
    pub fn run(mut self) -> Result<Outcome, Unfit> {
        if self.entrants.is_empty() {
            return Err(Unfit::NoMethod);
        }
        let numbers = [&self.plan.tolerances[..], &self.plan.steps, &[self.plan.scale]];
        if let Some(&x) = numbers.concat().iter().find(|&&x| !(x > 0.0 && x.is_finite())) {
            return Err(Unfit::NotPositive(x));
        }
        let truth = truth::find(&self.posed, self.plan.scale, self.end, self.exact)?;
        let rows = measure::measure(&self.problem, &self.entrants, &self.plan, &truth, &mut self.progress);
        Ok(Outcome { rows, reference: truth.reference })
    }
}
