//! An initial value problem and how to solve it.

use super::auto::Auto;
use super::control::Controller;
use super::event::{Crossing, Event, Then};
use super::leg::{Adaptive, Fixed, Pace};
use super::outcome::{Solution, Stopped};
use super::steps::Steps;
use super::watch::Step;
use crate::linear::{ConstantMass, Misplaced, Pattern};
use crate::step::method::{Loaded, Method};
use crate::step::norm::Tolerance;
use crate::step::scalar::Real;
use crate::step::split::Split;
use crate::step::state::{RealOf, State};
use crate::step::system::{System, Verdict};
use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};

/// Solves y' = f(t, y) from `y0` over a span of time, which may run backwards.
///
/// `f` is a closure `|t, y, dy|` that writes the slope into `dy`.
///
/// ```
/// let decay = kutta::solve(|_t, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0], [1.0], 0.0..10.0)
///     .rtol(1e-9)
///     .run()?;
/// assert!((decay.y[0] - (-10f64).exp()).abs() < 1e-9);
/// # Ok::<(), kutta::Stopped<[f64; 1]>>(())
/// ```
pub fn solve<'w, Y: State, R: Verdict, F>(f: F, y0: Y, span: Range<RealOf<Y>>) -> Ivp<'w, Y, F>
where
    F: FnMut(RealOf<Y>, &Y, &mut Y) -> R,
{
    Ivp::new(f, y0, span)
}

/// Solves y'' = f(t, y) from the position `y0` and the velocity `v0`.
///
/// `f` is a closure `|t, y, a|` that writes the acceleration into `a`. It takes methods for second-order
/// equations: Störmer–Verlet, velocity Verlet, Nyström and symplectic ones.
pub fn solve_second<'w, Y: State, R: Verdict, F>(
    f: F,
    y0: Y,
    v0: Y,
    span: Range<RealOf<Y>>,
) -> Ivp<'w, Y, F, crate::methods::VelocityVerlet>
where
    F: FnMut(RealOf<Y>, &Y, &mut Y) -> R,
{
    Ivp::second(f, y0, v0, span)
}

/// Solves y' = f(t, y) with f the sum of two parts, of which only `stiff` is treated implicitly.
///
/// Both are closures `|t, y, dy|`. It takes IMEX pairs; every other method sees the sum.
/// [`Ivp::jacobian`] is then that of the stiff part.
///
/// ```
/// // A stiff pull towards a slow wave, and the wave's own motion.
/// let pull = |t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -1e4 * (y[0] - t.cos());
/// let wave = |t: f64, _y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -t.sin();
/// let run = kutta::solve_split(pull, wave, [1.0], 0.0..10.0).run()?;
/// // Stability alone would ask an explicit method for 30 000 steps.
/// assert!((run.y[0] - 10f64.cos()).abs() < 1e-6 && run.stats.accepted < 4000);
/// # Ok::<(), kutta::Stopped<[f64; 1]>>(())
/// ```
pub fn solve_split<'w, Y: State, R1: Verdict, R2: Verdict, F, G>(
    stiff: F,
    nonstiff: G,
    y0: Y,
    span: Range<RealOf<Y>>,
) -> Ivp<'w, Y, Split<F, G, Y>, crate::methods::Kencarp4Imex>
where
    F: FnMut(RealOf<Y>, &Y, &mut Y) -> R1,
    G: FnMut(RealOf<Y>, &Y, &mut Y) -> R2,
{
    let system = Split::new(stiff, nonstiff, &y0);
    Ivp::new(system, y0, span).with(crate::methods::Kencarp4Imex)
}

/// An initial value problem with its method and options. Every option has a default.
pub struct Ivp<'w, Y: State, S, M = Auto, P = Adaptive> {
    pub(crate) system: S,
    pub(crate) y0: Y,
    pub(crate) v0: Option<Y>,
    pub(crate) span: Range<RealOf<Y>>,
    pub(crate) method: M,
    pub(crate) options: Options<'w, Y>,
    pub(crate) pace: PhantomData<P>,
}

pub(crate) struct Options<'w, Y: State> {
    pub tolerance: Tolerance<RealOf<Y>>,
    pub step: Option<RealOf<Y>>,
    pub min_step: RealOf<Y>,
    pub max_step: Option<RealOf<Y>>,
    pub max_steps: u64,
    pub controller: Option<Controller>,
    pub late: bool,
    pub starter: Option<Loaded>,
    pub times: Vec<RealOf<Y>>,
    pub every_step: bool,
    pub breaks: Vec<RealOf<Y>>,
    pub events: Vec<Event<'w, Y>>,
    pub observer: Option<Box<super::watch::Observer<'w, Y>>>,
    pub structure: Structure,
    pub mass: Option<Result<ConstantMass<Y::Scalar>, Misplaced>>,
    pub mend: bool,
}

/// Where the pattern of the Jacobian comes from.
pub(crate) enum Structure {
    /// From the system, should it have one.
    System,
    Given(Pattern),
    Detected,
}

impl<'w, Y: State, S: System<Y>> Ivp<'w, Y, S> {
    /// The same as [`solve`], for a struct that is a [`System`].
    pub fn new(system: S, y0: Y, span: Range<RealOf<Y>>) -> Self {
        let zero = RealOf::<Y>::from_f64(0.0);
        let options = Options {
            tolerance: Tolerance::Scalar {
                rtol: RealOf::<Y>::from_f64(1e-6),
                atol: RealOf::<Y>::from_f64(1e-9),
            },
            step: None,
            min_step: zero,
            max_step: None,
            max_steps: 10_000_000,
            controller: None,
            late: false,
            starter: None,
            times: vec![],
            every_step: false,
            breaks: vec![],
            events: vec![],
            observer: None,
            structure: Structure::System,
            mass: None,
            mend: false,
        };
        Self { system, y0, v0: None, span, method: Auto::new(), options, pace: PhantomData }
    }

    /// The same as [`solve_second`], for a struct that is a [`System`].
    pub fn second(
        system: S,
        y0: Y,
        v0: Y,
        span: Range<RealOf<Y>>,
    ) -> Ivp<'w, Y, S, crate::methods::VelocityVerlet> {
        let mut ivp = Self::new(system, y0, span).with(crate::methods::VelocityVerlet);
        ivp.v0 = Some(v0);
        ivp
    }
}

impl<'w, Y: State, S: System<Y>, M: Method, P: Pace> Ivp<'w, Y, S, M, P> {
    /// The method. Default: [`Auto`]; for y'' = f(t, y): `VelocityVerlet`; for f in two parts: `Kencarp4Imex`.
    pub fn with<N: Method>(self, method: N) -> Ivp<'w, Y, S, N, P> {
        let Self { system, y0, v0, span, options, pace, .. } = self;
        Ivp { system, y0, v0, span, method, options, pace }
    }

    /// Steps of one size: `round(span / h)` of them, so that the last one ends where the span does. Methods of
    /// variable order, `Bdf` and `Adams`, take none.
    ///
    /// ```compile_fail
    /// let decay = kutta::solve(|_t, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0], [1.0], 0.0..10.0);
    /// decay.with(kutta::methods::Bdf).step(0.1).run();
    /// ```
    pub fn step(self, h: RealOf<Y>) -> Ivp<'w, Y, S, M, Fixed> {
        let Self { system, y0, v0, span, method, mut options, .. } = self;
        options.step = Some(h);
        Ivp { system, y0, v0, span, method, options, pace: PhantomData }
    }

    /// Relative error allowed per step and component. Default 1e-6. Too small a number takes many steps,
    /// below the rounding error it never succeeds.
    pub fn rtol(mut self, rtol: RealOf<Y>) -> Self {
        match &mut self.options.tolerance {
            Tolerance::Scalar { rtol: r, .. } => *r = rtol,
            Tolerance::Each(each) => each.iter_mut().for_each(|(r, _)| *r = rtol),
        }
        self
    }

    /// Absolute error allowed per step and component, in the units of y: the size below which a component
    /// does not matter. Default 1e-9. Zero demands relative accuracy of every component, also near zero.
    pub fn atol(mut self, atol: RealOf<Y>) -> Self {
        match &mut self.options.tolerance {
            Tolerance::Scalar { atol: a, .. } => *a = atol,
            Tolerance::Each(each) => each.iter_mut().for_each(|(_, a)| *a = atol),
        }
        self
    }

    /// `(rtol, atol)` for each component.
    pub fn tolerances(mut self, each: Vec<(RealOf<Y>, RealOf<Y>)>) -> Self {
        self.options.tolerance = Tolerance::Each(each);
        self
    }

    /// The first step tried by an adaptive run. Default: from the sizes of y and f (Hairer).
    pub fn first_step(mut self, h: RealOf<Y>) -> Self {
        self.options.step = Some(h);
        self
    }

    /// An adaptive run stops rather than take a smaller step. Default: a few spacings of the time.
    pub fn min_step(mut self, h: RealOf<Y>) -> Self {
        self.options.min_step = h;
        self
    }

    /// Default: the span. A smaller one keeps short events from being stepped over.
    pub fn max_step(mut self, h: RealOf<Y>) -> Self {
        self.options.max_step = Some(h);
        self
    }

    /// Most attempts of an adaptive run. Default ten million.
    pub fn max_steps(mut self, n: u64) -> Self {
        self.options.max_steps = n;
        self
    }

    /// How the next step follows from the errors of the last ones. Default: [`Controller::PI`] for explicit methods,
    /// [`Controller::PREDICTIVE`] for implicit ones. Methods of variable order have a rule of their own and refuse another.
    pub fn controller(mut self, controller: Controller) -> Self {
        self.options.controller = Some(controller);
        self
    }

    /// Takes each step as the last error but one asks for, so that no step waits for its own error. It saves
    /// a fifth of the time where f costs a few nanoseconds, and costs rejected steps where the step must
    /// change fast. Methods of variable order refuse it. Default: off.
    pub fn late(mut self, late: bool) -> Self {
        self.options.late = late;
        self
    }

    /// The one-step method that starts a multistep one. Default: one of at least its order.
    pub fn start_with<N: Method>(mut self, starter: N) -> Self {
        const {
            assert!(
                N::READ || N::FORM.is_some(),
                "this method cannot be stepped: it is a pair whose stages would have to be found together"
            )
        };
        self.options.starter = Some(Loaded::of(starter.name(), starter.form()));
        self
    }

    /// Saves the state at these times of the span, which are met to the last bit; between steps the state
    /// comes from dense output. In the order of the run.
    pub fn at(mut self, times: &[RealOf<Y>]) -> Self {
        self.options.times = times.to_vec();
        self
    }

    /// Saves the start and the end of every step.
    pub fn every_step(mut self) -> Self {
        self.options.every_step = true;
        self
    }

    /// Times at which f or one of its derivatives jumps: a step ends right before each, with the left values
    /// of f, and the run starts anew behind it with the right ones.
    pub fn breaks(mut self, times: &[RealOf<Y>]) -> Self {
        self.options.breaks = times.to_vec();
        self
    }

    /// Sees every accepted step; `ControlFlow::Break` ends the run there.
    pub fn observe(mut self, observer: impl FnMut(&Step<Y>) -> ControlFlow<()> + 'w) -> Self {
        self.options.observer = Some(Box::new(observer));
        self
    }

    /// Records the roots of `g(t, y)`.
    ///
    /// Sign changes are looked for at eight points of each step: two roots nearer to each other, and roots
    /// where g touches zero without a change of sign, are missed.
    pub fn record(self, crossing: Crossing, g: impl FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w) -> Self {
        self.event(crossing, g, Then::Record)
    }

    /// Ends the run at the first root of `g(t, y)`.
    pub fn stop_at(self, crossing: Crossing, g: impl FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w) -> Self {
        self.event(crossing, g, Then::Stop)
    }

    /// Changes the state at each root of `g(t, y)` and starts anew from there.
    pub fn change_at(
        self,
        crossing: Crossing,
        g: impl FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w,
        change: impl FnMut(RealOf<Y>, &mut Y) + 'w,
    ) -> Self {
        self.event(crossing, g, Then::Change(Box::new(change)))
    }

    /// Changes position and velocity of y'' = f(t, y) at each root of `g(t, y)` and starts anew from there.
    pub fn change_motion_at(
        self,
        crossing: Crossing,
        g: impl FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w,
        change: impl FnMut(RealOf<Y>, &mut Y, &mut Y) + 'w,
    ) -> Self {
        self.event(crossing, g, Then::ChangeMotion(Box::new(change)))
    }

    fn event(
        mut self,
        crossing: Crossing,
        g: impl FnMut(RealOf<Y>, &Y) -> RealOf<Y> + 'w,
        then: Then<'w, Y>,
    ) -> Self {
        let miss = RealOf::<Y>::from_f64(0.0);
        self.options.events.push(Event { g: Box::new(g), crossing, then, last: None, root: None, miss });
        self
    }

    /// Runs to the end of the span.
    ///
    /// # Errors
    /// Why it stopped early, with t, h and everything computed so far.
    pub fn run(self) -> Result<Solution<Y>, Stopped<Y>> {
        Steps::new(self).finish()
    }

    /// Runs step by step: an iterator over the accepted steps.
    ///
    /// ```
    /// let fall = kutta::solve(|_t, _y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -9.81, [0.0], 0.0..1.0);
    /// for step in fall.steps() {
    ///     let (t, y) = step?;
    ///     assert!((y[0] + 9.81 * t).abs() < 1e-6);
    /// }
    /// # Ok::<(), kutta::Stopped<[f64; 1]>>(())
    /// ```
    pub fn steps(self) -> Steps<'w, Y, S, M, P> {
        Steps::new(self)
    }
}
