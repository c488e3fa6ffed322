//! A stretch of a run without breaks, and how its steps are chosen.

use super::control::Control;
use super::outcome::{Stats, Why};
use super::stiffness::Stiffness;
use crate::step::implicit::Solver;
use crate::step::method::Method;
use crate::step::norm::Tolerance;
use crate::step::state::{RealOf, State};
use crate::step::stepper::Stepper;

/// How the step is chosen: a type, so that only one of the two loops is compiled into a run.
pub trait Pace {
    const ADAPTIVE: bool;
}

/// Steps of one size.
#[derive(Clone, Copy, Debug)]
pub struct Fixed;
/// Steps chosen from the error estimate.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive;

impl Pace for Fixed {
    const ADAPTIVE: bool = false;
}

impl Pace for Adaptive {
    const ADAPTIVE: bool = true;
}

/// Limits and tolerances of a run.
#[derive(Clone)]
pub(crate) struct Rules<R> {
    pub tolerance: Tolerance<R>,
    pub min_step: R,
    pub max_step: R,
    pub max_steps: u64,
    /// Take the step that the last but one error asks for, so that no step waits for its own error.
    pub late: bool,
}

/// A stretch of a run without breaks: everything the loop works on.
pub(crate) struct Leg<M: Method, Y: State, S> {
    pub stepper: Stepper<M, Y>,
    pub system: S,
    pub t: RealOf<Y>,
    /// Where the last step ends: at `stop`, or right before it where f jumps there.
    pub end: RealOf<Y>,
    /// The time that then has come.
    pub stop: RealOf<Y>,
    /// Signed. Fixed: the size of all steps; adaptive: of the next one.
    pub h: RealOf<Y>,
    /// Fixed: `t = origin + index h`, up to `steps`.
    pub origin: RealOf<Y>,
    pub index: u64,
    pub steps: u64,
    /// Adaptive: what rounding took from t so far.
    pub lost: RealOf<Y>,
    pub control: Control,
    /// For implicit stages.
    pub solver: Option<Box<Solver<Y>>>,
    pub stats: Stats,
    /// F_0 is there before the first attempt.
    pub known: bool,
    /// The size of the last accepted step.
    pub last: RealOf<Y>,
    /// Looks for the beginning or the end of stiffness.
    pub stiffness: Option<Stiffness>,
}

impl<M: Method, Y: State, S> Leg<M, Y, S> {
    /// The same leg with another system.
    pub fn with<T>(self, system: T) -> Leg<M, Y, T> {
        let Leg { stepper, t, end, stop, h, origin, index, steps, lost, .. } = self;
        let Leg { control, solver, stats, known, last, stiffness, .. } = self;
        Leg {
            stepper,
            system,
            t,
            end,
            stop,
            h,
            origin,
            index,
            steps,
            lost,
            control,
            solver,
            stats,
            known,
            last,
            stiffness,
        }
    }
}

/// How a leg ended.
pub(crate) enum Ended {
    Reached,
    /// A step was taken, and the next is to wait.
    Paused,
    /// The observer asked for it.
    Stopped,
    /// An event changed the state: a new leg begins at the leg's `t`.
    Changed,
    /// Stiffness began, or ended.
    Turned,
    Failed(Why),
}
