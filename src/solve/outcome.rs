//! What a run gives back: a solution, or why it stopped and everything computed so far.

use super::auto::Choice;
use crate::linear::Effort;
use crate::step::scalar::Shown;
use crate::step::state::{RealOf, State};
use crate::step::stepper::{Refused, Unsolved};
use std::fmt;

/// Counts of a run.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Stats {
    /// Evaluations of the right-hand side, those of the start and of dense output included.
    pub evaluations: u64,
    /// Jacobians taken and matrices factored, by methods with implicit stages; iterations on their stages.
    pub jacobians: u64,
    pub factorizations: u64,
    pub iterations: u64,
    /// The highest order that a family of variable order took a step with; 0 for every other method.
    pub order: usize,
    pub accepted: u64,
    pub rejected: Rejections,
    /// The component that dominated most error-test rejections, by majority vote.
    pub limiting: Option<usize>,
    pub(crate) votes: u64,
}

/// Attempts that were not accepted, by cause.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Rejections {
    /// The error estimate exceeded the tolerance.
    pub error: u64,
    /// A NaN or an infinity came out of the right-hand side.
    pub non_finite: u64,
    /// The right-hand side refused a point ([`OutOfDomain`](crate::OutOfDomain)).
    pub domain: u64,
    /// Newton's iteration on an implicit stage diverged or was too slow.
    pub newton: u64,
    /// The matrix of an implicit stage could not be factored, or could not have been in a somewhat smaller step: the
    /// solution may grow faster than the step can follow.
    pub singular: u64,
}

impl Stats {
    /// Adds what the solver of the stages spent.
    pub(crate) fn spend(&mut self, effort: Effort) {
        self.evaluations += effort.evaluations;
        self.jacobians += effort.jacobians;
        self.factorizations += effort.factorizations;
        self.iterations += effort.iterations;
        self.order = self.order.max(effort.order);
    }
}

impl Refused {
    /// What stands in the way, should no smaller step avoid it.
    pub(crate) fn reason(self) -> Why {
        match self.why {
            Unsolved::Domain => Why::OutOfDomain { stage: self.stage },
            Unsolved::Diverged => Why::NewtonFailed { stage: self.stage },
            Unsolved::Singular { component } => Why::Singular { component },
            Unsolved::Outgrown => Why::Outgrown,
            Unsolved::Rounding { component } => Why::Rounding { component },
            Unsolved::NonFinite { component } => Why::NonFinite { component, stage: Some(self.stage) },
            Unsolved::Jacobian { component } => Why::Jacobian { component },
            Unsolved::OutsidePattern { row, column } => Why::OutsidePattern { row, column },
        }
    }
}

impl Rejections {
    pub fn total(&self) -> u64 {
        self.error + self.non_finite + self.domain + self.newton + self.singular
    }

    /// One more, for this reason.
    pub(crate) fn count(&mut self, why: &Why) {
        match why {
            Why::OutOfDomain { .. } => self.domain += 1,
            Why::NonFinite { .. } | Why::Jacobian { .. } | Why::OutsidePattern { .. } => self.non_finite += 1,
            Why::NewtonFailed { .. } => self.newton += 1,
            Why::Singular { .. } | Why::Outgrown => self.singular += 1,
            _ => self.error += 1,
        }
    }
}

/// Where the values between steps come from, and their order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Interpolant {
    /// The table's own dense output; of a fully implicit table its collocation polynomial.
    Own { order: usize },
    /// Hermite interpolation of values and slopes, with extra evaluations where the order asks for them.
    Hermite { order: usize },
    /// The Taylor polynomial of a Nordsieck array, of the order of the step: from `lowest`, with which a run
    /// starts, to `highest`.
    Nordsieck { lowest: usize, highest: usize },
}

impl Interpolant {
    /// The order; the lowest where it is that of the step.
    pub fn order(self) -> usize {
        match self {
            Interpolant::Own { order } | Interpolant::Hermite { order } => order,
            Interpolant::Nordsieck { lowest, .. } => lowest,
        }
    }
}

/// A solution from t0 to `t`.
#[derive(Clone, Debug)]
pub struct Solution<Y: State> {
    /// The time reached: the end of the span, to the last bit, unless a run was stopped.
    pub t: RealOf<Y>,
    /// The state there.
    pub y: Y,
    /// The velocity there, for y'' = f(t, y).
    pub v: Option<Y>,
    /// Times of the saved states, as asked for with `at` or `every_step`.
    pub ts: Vec<RealOf<Y>>,
    pub ys: Vec<Y>,
    /// Velocities at `ts`, for y'' = f(t, y).
    pub vs: Vec<Y>,
    /// Roots of the events, in the order of time.
    pub events: Vec<Occurrence<Y>>,
    pub stats: Stats,
    /// The step size last used.
    pub h: RealOf<Y>,
    /// What was or would be used between steps.
    pub interpolant: Interpolant,
    /// The methods that [`Auto`](crate::Auto) took up, the first one at the start; empty where one was named.
    pub choices: Vec<Choice<RealOf<Y>>>,
}

/// A root of an event function.
#[derive(Clone, Debug)]
pub struct Occurrence<Y: State> {
    /// Which event, in the order they were declared.
    pub event: usize,
    pub t: RealOf<Y>,
    /// The state at the root, before any change by the event.
    pub y: Y,
}

/// Why a run did not reach its end.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum Why {
    /// A setting makes no sense; the text says which, with its number, and what to do.
    Invalid(String),
    /// The error test asks for steps below the spacing of numbers at t.
    StepTooSmall { limiting: Option<usize> },
    /// More attempts than `max_steps`.
    TooManySteps { attempts: u64 },
    /// A NaN or an infinity that no smaller step avoids; the first such component.
    NonFinite { component: usize, stage: Option<usize> },
    /// The right-hand side refused the point and no smaller step avoids it.
    OutOfDomain { stage: usize },
    /// A NaN or an infinity in this row of the Jacobian.
    Jacobian { component: usize },
    /// The Jacobian has an entry other than zero outside its pattern.
    OutsidePattern { row: usize, column: usize },
    /// The start breaks the algebraic equation of this row: `residual` is what is left of f(t, y) - M y' there.
    Inconsistent { row: usize, residual: f64 },
    /// Newton's iteration on an implicit stage failed and no smaller step helped.
    NewtonFailed { stage: usize },
    /// The matrix of an implicit stage has no pivot in this column, and no smaller step helped.
    Singular { component: usize },
    /// However small the step, the solution may grow faster than an implicit step can follow: it has a pole there, or
    /// an eigenvalue of its Jacobian is too large.
    Outgrown,
    /// A Rosenbrock method multiplies with the Jacobian, whose rounding may have left no digit of this component that
    /// is asked for: its equations conserve a sum of components that were much larger before.
    Rounding { component: usize },
    /// An event recurs faster and faster, like a ball that comes to rest.
    TooManyEvents { event: usize },
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Why::Invalid(what) => f.write_str(what),
            Why::StepTooSmall { limiting } => {
                f.write_str("the step became too small for the numbers")?;
                if let Some(i) = limiting {
                    write!(f, "; component {i} limits it")?;
                }
                f.write_str(
                    ": the solution may be singular here, the problem stiff, or the tolerance too tight",
                )
            }
            Why::TooManySteps { attempts } => {
                write!(
                    f,
                    "{attempts} steps were attempted: raise max_steps, loosen the tolerance, or use a method for stiff problems"
                )
            }
            Why::NonFinite { component, stage: Some(stage) } => {
                write!(
                    f,
                    "the right-hand side gave a NaN or an infinity in component {component} at stage {stage}"
                )
            }
            Why::NonFinite { component, stage: None } => {
                write!(f, "component {component} of the state is a NaN or an infinity")
            }
            Why::OutOfDomain { stage } => {
                write!(f, "the right-hand side refused the point of stage {stage}, however small the step")
            }
            Why::Jacobian { component } => {
                write!(f, "the Jacobian has a NaN or an infinity in row {component}")
            }
            Why::OutsidePattern { row, column } => {
                write!(f, "the Jacobian has an entry at ({row}, {column}), outside its pattern")
            }
            Why::Inconsistent { row, residual } => {
                write!(
                    f,
                    "the start is not consistent: the algebraic equation of row {row} is off by {residual:e}; \
                     mend y0, or ask for it with .consistent()"
                )
            }
            Why::NewtonFailed { stage } => {
                write!(f, "the iteration on stage {stage} failed, however small the step")
            }
            Why::Singular { component } => {
                write!(
                    f,
                    "the matrix of the stages is singular in column {component}, however small the step"
                )
            }
            Why::Outgrown => f.write_str("the solution grows faster than any step can follow"),
            Why::Rounding { component } => write!(
                f,
                "rounding of the Jacobian may have spoiled component {component}: take a method that iterates, such as radau-iia5"
            ),
            Why::TooManyEvents { event } => write!(f, "event {event} recurs without end"),
        }
    }
}

/// A run that ended early: where, why, and the solution so far.
#[derive(Clone)]
pub struct Stopped<Y: State> {
    pub t: RealOf<Y>,
    /// The step size that was being tried.
    pub h: RealOf<Y>,
    pub why: Why,
    /// Everything computed before; its `t` and `y` are those of the last accepted step.
    pub solution: Box<Solution<Y>>,
}

impl<Y: State> fmt::Display for Stopped<Y> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.why {
            Why::Invalid(what) => f.write_str(what),
            why => write!(f, "stopped at t = {}, h = {}: {why}", Shown(self.t), Shown(self.h)),
        }
    }
}

impl<Y: State> fmt::Debug for Stopped<Y> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Stopped({self}; {:?})", self.solution.stats)
    }
}

impl<Y: State> std::error::Error for Stopped<Y> {}
