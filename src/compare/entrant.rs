//! A method entered for a problem, with its types forgotten: what is timed inside is compiled for both.

use super::label;
use crate::solve::ivp::Ivp;
use crate::solve::leg::{Adaptive, Fixed, Pace};
use crate::solve::outcome::{Solution, Stats, Stopped, Why};
use crate::solve::watch::Step;
use crate::step::method::Method;
use crate::step::state::State;
use crate::step::system::System;
use std::hint::black_box;
use std::marker::PhantomData;
use std::ops::{ControlFlow, Range};
use std::time::{Duration, Instant};

/// A problem, posed: for y'' = f(t, y) there is a velocity.
#[derive(Clone)]
pub(super) struct Posed<Y, S> {
    pub system: S,
    pub y0: Y,
    pub v0: Option<Y>,
    pub span: Range<f64>,
}

/// How a method fared at one tolerance or step size.
pub(super) struct Trial {
    /// The state at the end, and at each requested time; or why there is none.
    pub states: Result<(Vec<f64>, Vec<Vec<f64>>), String>,
    pub stats: Stats,
    /// It was given up because it took too long.
    pub slow: bool,
    /// One plain run.
    pub seconds: f64,
}

pub(super) trait Entrant {
    fn name(&self) -> &str;
    fn adaptive(&self) -> bool;
    /// The length of the span.
    fn span(&self) -> f64;
    /// Runs twice: watched, for the states at `times`, and plain. An adaptive run has atol = rtol * `scale`.
    fn attempt(&self, setting: f64, scale: f64, times: &[f64], longest: Duration) -> Trial;
    /// The time of `runs` plain runs.
    fn seconds(&self, setting: f64, scale: f64, runs: u32) -> f64;
}

/// What a setting means for a pace.
pub(super) trait Paced: Pace + Sized {
    fn set<'w, Y: State<Scalar = f64>, S: System<Y>, M: Method>(
        ivp: Ivp<'w, Y, S, M>,
        setting: f64,
        scale: f64,
    ) -> Ivp<'w, Y, S, M, Self>;
}

impl Paced for Adaptive {
    fn set<'w, Y: State<Scalar = f64>, S: System<Y>, M: Method>(
        ivp: Ivp<'w, Y, S, M>,
        rtol: f64,
        scale: f64,
    ) -> Ivp<'w, Y, S, M, Self> {
        ivp.rtol(rtol).atol(rtol * scale)
    }
}

impl Paced for Fixed {
    fn set<'w, Y: State<Scalar = f64>, S: System<Y>, M: Method>(
        ivp: Ivp<'w, Y, S, M>,
        h: f64,
        _scale: f64,
    ) -> Ivp<'w, Y, S, M, Self> {
        ivp.step(h)
    }
}

pub(super) struct Typed<Y, S, M, P> {
    posed: Posed<Y, S>,
    method: M,
    pace: PhantomData<P>,
}

impl<Y: State<Scalar = f64>, S: System<Y> + Clone, M: Method, P: Paced> Typed<Y, S, M, P> {
    pub fn new(method: M, posed: Posed<Y, S>) -> Self {
        Self { posed, method, pace: PhantomData }
    }

    /// One run, with the states at some times and a limit to its duration if it is watched. The loop is
    /// compiled here alone: once for all callers.
    #[inline(never)]
    fn go(
        &self,
        setting: f64,
        scale: f64,
        watched: Option<(&[f64], Duration)>,
    ) -> Result<Solution<Y>, Stopped<Y>> {
        let Posed { system, y0, v0, span } = &self.posed;
        let mut ivp = Ivp::new(system.clone(), y0.clone(), span.clone()).with(self.method.clone());
        ivp.v0.clone_from(v0);
        let mut ivp = P::set(ivp, setting, scale);
        if let Some((times, longest)) = watched {
            ivp = ivp.at(times).observe(in_time(longest));
        }
        ivp.run()
    }

    /// The failed part of a trial, in words that name the usual reasons.
    fn failed(stopped: &Stopped<Y>) -> Trial {
        let failure = match stopped.why {
            Why::NonFinite { .. } if !P::ADAPTIVE => format!("unstable: {stopped}"),
            _ => stopped.to_string(),
        };
        Trial { states: Err(failure), stats: stopped.solution.stats, slow: false, seconds: 0.0 }
    }
}

/// How much longer than a plain run a watched one may take: small systems spend more on the clock and on
/// looking on than on stepping.
const WATCHED: u32 = 4;

impl<Y: State<Scalar = f64>, S: System<Y> + Clone, M: Method, P: Paced> Entrant for Typed<Y, S, M, P> {
    fn name(&self) -> &str {
        label(&self.method)
    }

    fn adaptive(&self) -> bool {
        P::ADAPTIVE
    }

    fn span(&self) -> f64 {
        self.posed.span.end - self.posed.span.start
    }

    fn attempt(&self, setting: f64, scale: f64, times: &[f64], longest: Duration) -> Trial {
        let start = Instant::now();
        let watched = match self.go(setting, scale, Some((times, longest * WATCHED))) {
            Ok(solution) => solution,
            Err(stopped) => return Self::failed(&stopped),
        };
        let slow = |solution: &Solution<Y>, seconds| Trial {
            states: Err(format!("given up: took longer than {} s", longest.as_secs_f64())),
            stats: solution.stats,
            slow: true,
            seconds,
        };
        if watched.t != self.posed.span.end {
            return slow(&watched, start.elapsed().as_secs_f64());
        }
        let start = Instant::now();
        let plain = match self.go(setting, scale, None) {
            Ok(solution) => solution,
            Err(stopped) => return Self::failed(&stopped),
        };
        let seconds = start.elapsed().as_secs_f64();
        if seconds > longest.as_secs_f64() {
            return slow(&plain, seconds);
        }
        let end = flat(&plain.y, plain.v.as_ref());
        let along = (0..watched.ys.len()).map(|i| flat(&watched.ys[i], watched.vs.get(i))).collect();
        let states = match end.iter().all(|y| y.is_finite()) {
            true => Ok((end, along)),
            false => Err("the state at the end is not finite".to_string()),
        };
        Trial { states, stats: plain.stats, slow: false, seconds }
    }

    fn seconds(&self, setting: f64, scale: f64, runs: u32) -> f64 {
        let start = Instant::now();
        for _ in 0..runs {
            // A failure shows in the trial; one that comes only now and then would be one of f itself.
            let _ = black_box(self.go(black_box(setting), scale, None));
        }
        start.elapsed().as_secs_f64()
    }
}

/// An observer that ends the run when the time is up.
pub(super) fn in_time<Y: State>(longest: Duration) -> impl FnMut(&Step<Y>) -> ControlFlow<()> {
    let start = Instant::now();
    move |_| if start.elapsed() > longest { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

fn flat<Y: State<Scalar = f64>>(y: &Y, v: Option<&Y>) -> Vec<f64> {
    let mut flat = y.as_slice().to_vec();
    flat.extend(v.into_iter().flat_map(State::as_slice));
    flat
}
