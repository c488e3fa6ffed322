//! A run from leg to leg: between breaks and events, with a start at each.

use super::auto::{Chooser, Lent, beyond_rounding, stiff_method};
use super::check::check;
use super::control::Controller;
use super::dense::Dense;
use super::ivp::{Ivp, Options, Structure};
use super::leg::{Ended, Leg, Pace, Rules};
use super::outcome::{Solution, Stats, Stopped, Why};
use super::run::run_leg;
use super::watch::Watch;
use crate::linear::Known;
use crate::step::method::{Loaded, Method};
use crate::step::norm::Tolerance;
use crate::step::row::form_of;
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::system::System;
use crate::tableau::Meaning;
use num_traits::{One, Zero};
use std::collections::VecDeque;
use std::marker::PhantomData;
use std::ops::ControlFlow;

/// A run in progress. As an iterator it gives the time and the state after each accepted step, and at
/// last, if it stopped early, why.
pub struct Steps<'w, Y: State, S, M: Method, P> {
    pub(super) method: M,
    /// Lent to a leg while it runs.
    pub(super) system: Option<S>,
    pub(super) leg: Option<Leg<M, Y, S>>,
    /// A leg of another method than the run's own, at rest.
    pub(super) stiff_leg: Option<Leg<Loaded, Y, ()>>,
    pub(super) chooser: Chooser<RealOf<Y>>,
    pub(super) t: RealOf<Y>,
    pub(super) y: Y,
    pub(super) v: Option<Y>,
    /// The size of the last step that was accepted, and of the one in hand.
    pub(super) h: RealOf<Y>,
    pub(super) tried: RealOf<Y>,
    pub(super) end: RealOf<Y>,
    /// Times at which a leg ends, the next one last.
    pub(super) stops: Vec<RealOf<Y>>,
    pub(super) rules: Rules<RealOf<Y>>,
    pub(super) controller: Option<Controller>,
    pub(super) options: Options<'w, Y>,
    pub(super) watch: Watch<'w, Y>,
    pub(super) stats: Stats,
    /// What is known of the matrices of implicit stages, from the first leg on.
    pub(super) matrices: Option<Known<Y::Scalar>>,
    /// Why the run cannot go on.
    pub(super) failed: Option<Why>,
    /// Steps that started a multistep method and are still to be given by the iterator.
    pub(super) early: VecDeque<(RealOf<Y>, Y)>,
    pub(super) done: bool,
    pub(super) pace: PhantomData<P>,
}

impl<'w, Y: State, S: System<Y>, M: Method, P: Pace> Steps<'w, Y, S, M, P> {
    pub(crate) fn new(ivp: Ivp<'w, Y, S, M, P>) -> Self {
        const {
            assert!(
                M::READ || M::FORM.is_some(),
                "this method cannot be stepped: it is a pair whose stages would have to be found together"
            );
            if let Some(form) = M::FORM {
                assert!(!P::ADAPTIVE || form.adaptive(), "no error estimate: give a step with `.step(h)`");
                assert!(
                    P::ADAPTIVE || form.orders == 0,
                    "a family of variable order chooses its steps: leave out `.step(h)`"
                );
            }
        }
        let Ivp { system, y0, v0, span, method, mut options, .. } = ivp;
        let mass = options.mass.is_some();
        let auto = const { M::AUTO && P::ADAPTIVE };
        let approximate = system.is_approximate();
        let iterating = approximate || auto && beyond_rounding(&options.tolerance, &y0);
        let stiff = (auto && mass).then(|| stiff_method(&options.tolerance, iterating));
        let (name, form) = match &stiff {
            Some(stiff) => (stiff.name(), stiff.form()),
            None => (method.name(), form_of(&method)),
        };
        let named = (name, form);
        let failed =
            check(named, (P::ADAPTIVE, approximate), &y0, v0.as_ref(), &span, &options).map(Why::Invalid);
        let (t, end) = (span.start, span.end);
        let stops = stops(t, end, &options.breaks);
        let tiny = |x: RealOf<Y>| x.maximum(RealOf::<Y>::TINY);
        let tolerance = match &options.tolerance {
            Tolerance::Scalar { rtol, atol } => Tolerance::Scalar { rtol: *rtol, atol: tiny(*atol) },
            Tolerance::Each(each) => Tolerance::Each(each.iter().map(|&(r, a)| (r, tiny(a))).collect()),
        };
        let rules = Rules {
            tolerance,
            min_step: options.min_step,
            max_step: options.max_step.unwrap_or((end - t).modulus()),
            max_steps: options.max_steps,
            late: options.late,
        };
        let watch = Watch {
            times: std::mem::take(&mut options.times),
            next: 0,
            every_step: options.every_step,
            one_by_one: false,
            ts: vec![],
            ys: vec![],
            vs: vec![],
            observer: options.observer.take(),
            events: std::mem::take(&mut options.events),
            occurrences: vec![],
            landed: None,
            over: false,
            dense: Dense::new(form, &y0, mass),
            point: y0.clone(),
            second_order: form.d == 2,
        };
        let controller = options.controller;
        let stats = Stats::default();
        let h = RealOf::<Y>::zero();
        let chooser = match auto {
            true => {
                let patterned =
                    || !matches!(options.structure, Structure::System) || system.pattern().is_some();
                let size = (t, y0.as_slice().len());
                Chooser::new(&method, size, (mass, iterating), patterned, &rules.tolerance)
            }
            false => Chooser::named(),
        };
        let mut run = Self {
            method,
            system: Some(system),
            leg: None,
            stiff_leg: None,
            chooser,
            t,
            y: y0,
            v: v0,
            h,
            tried: h,
            end,
            stops,
            rules,
            controller,
            options,
            watch,
            stats,
            matrices: None,
            failed,
            early: VecDeque::new(),
            done: false,
            pace: PhantomData,
        };
        if run.failed.is_none() && run.watch.every_step && run.watch.times.first() != Some(&t) {
            run.save_here();
        }
        run
    }

    /// Runs to the end.
    pub(crate) fn finish(mut self) -> Result<Solution<Y>, Stopped<Y>> {
        while !self.done {
            if let Err(why) = self.advance() {
                return Err(self.stopped(why));
            }
        }
        Ok(self.solution())
    }

    fn stopped(&mut self, why: Why) -> Stopped<Y> {
        self.done = true;
        Stopped { t: self.t, h: self.tried, why, solution: Box::new(self.solution()) }
    }

    fn solution(&mut self) -> Solution<Y> {
        let watch = &mut self.watch;
        Solution {
            t: self.t,
            y: self.y.clone(),
            v: self.v.clone(),
            ts: std::mem::take(&mut watch.ts),
            ys: std::mem::take(&mut watch.ys),
            vs: std::mem::take(&mut watch.vs),
            events: std::mem::take(&mut watch.occurrences),
            stats: self.stats,
            h: self.h,
            interpolant: watch.dense.interpolant,
            choices: std::mem::take(&mut self.chooser.choices),
        }
    }

    /// Runs until something happens: the end of a leg, or one step where they are taken one by one.
    fn advance(&mut self) -> Result<(), Why> {
        if let Some(why) = self.failed.take() {
            return Err(why);
        }
        while self.watch.next < self.watch.times.len() && self.watch.times[self.watch.next] == self.t {
            self.save_here();
            self.watch.next += 1;
        }
        let Some(&stop) = self.stops.last() else {
            self.done = true;
            return Ok(());
        };
        if const { M::AUTO } && self.chooser.stiff {
            return self.advance_stiff(stop);
        }
        let leg = match (self.leg.take(), self.system.take()) {
            (Some(leg), _) => leg,
            (None, Some(system)) => match self.begin(self.method.clone(), system, stop)? {
                ControlFlow::Continue(leg) if self.early.is_empty() => leg,
                ControlFlow::Continue(leg) => {
                    self.leg = Some(leg);
                    return Ok(());
                }
                ControlFlow::Break(system) => {
                    self.system = Some(system);
                    return Ok(());
                }
            },
            (None, None) => return Ok(()),
        };
        let (left, result) = self.go(leg);
        match left {
            Left::Leg(leg) => self.leg = Some(leg),
            Left::System(system) => self.system = Some(system),
        }
        result
    }

    /// The same with the method for stiff problems, to which the system is lent.
    fn advance_stiff(&mut self, stop: RealOf<Y>) -> Result<(), Why> {
        let Some(mut system) = self.system.take() else { return Ok(()) };
        let lent = Lent(&mut system);
        let leg = match self.stiff_leg.take() {
            Some(leg) => ControlFlow::Continue(leg.with(lent)),
            None => self.begin(self.chooser.stiff_method(&self.rules.tolerance), lent, stop)?,
        };
        let result = match leg {
            ControlFlow::Break(_) => Ok(()),
            ControlFlow::Continue(leg) => {
                let (left, result) = self.go(leg);
                if let Left::Leg(leg) = left {
                    self.stiff_leg = Some(leg.with(()));
                }
                result
            }
        };
        self.system = Some(system);
        result
    }

    /// Runs a leg until something happens, and takes note of where it came.
    fn go<N: Method, T: System<Y>>(&mut self, leg: Leg<N, Y, T>) -> (Left<N, Y, T>, Result<(), Why>) {
        let (mut leg, ended) = run_leg::<N, Y, T, P>(leg, &self.rules, &mut self.watch);
        self.stats = leg.stats;
        (self.t, self.h, self.tried) = (leg.t, leg.last, leg.h);
        if !matches!(ended, Ended::Paused) {
            self.chooser.stiffness = leg.stiffness.take();
        }
        if let Ended::Changed = ended {
            self.land(leg.t);
            return (Left::System(leg.system), self.watch.guard_against_endless_events());
        }
        self.y.as_mut_slice().copy_from_slice(leg.stepper.y().as_slice());
        match ended {
            Ended::Paused => return (Left::Leg(leg), Ok(())),
            Ended::Reached => self.t = self.stops.pop().unwrap_or(leg.t),
            Ended::Stopped => self.done = true,
            Ended::Turned => {
                self.options.step = Some(leg.h.modulus());
                self.chooser.turn(leg.t, self.method.name(), &self.rules.tolerance);
                self.watch.dense = match self.chooser.stiff {
                    true => {
                        Dense::new(&self.chooser.stiff_method(&self.rules.tolerance).form, &self.y, false)
                    }
                    false => Dense::new(form_of(&self.method), &self.y, false),
                };
            }
            Ended::Failed(_) | Ended::Changed => {}
        }
        let system = self.velocity_here(leg);
        self.watch.dense.forget();
        let result = match ended {
            Ended::Failed(why) => Err(why),
            Ended::Turned => Ok(()),
            _ => {
                self.done |= self.stops.is_empty() && self.watch_is_served();
                Ok(())
            }
        };
        (Left::System(system), result)
    }

    /// No requested time is left at the end of the span.
    fn watch_is_served(&mut self) -> bool {
        while self.watch.next < self.watch.times.len() && self.watch.times[self.watch.next] == self.t {
            self.save_here();
            self.watch.next += 1;
        }
        true
    }

    fn save_here(&mut self) {
        self.watch.ts.push(self.t);
        self.watch.ys.push(self.y.clone());
        self.watch.vs.extend(self.v.clone());
    }

    /// The velocity at the end of a leg of y'' = f(t, y): carried, or `(x_n - x_(n-1))/h + h/2 f_n`.
    fn velocity_here<N: Method, T: System<Y>>(&mut self, leg: Leg<N, Y, T>) -> T {
        let Leg { stepper, mut system, t, h, mut stats, .. } = leg;
        let form = form_of(&stepper.method);
        if form.d == 2 {
            let find = |meaning| (0..form.r).find(|&j| form.means[j] == meaning);
            if let Some(j) = find(Meaning::V) {
                self.v = Some(stepper.word(j).clone());
            } else if let Some(j) = find(Meaning::Y(1))
                && stats.accepted > 0
            {
                let (x, old) = (stepper.y(), stepper.word(j));
                let mut v = x.clone();
                stats.evaluations += 1;
                if system.rhs(t, x, &mut v).is_ok() {
                    let (per, half) = (RealOf::<Y>::one() / h, RealOf::<Y>::from_f64(0.5) * h);
                    for ((v, &x), &old) in v.as_mut_slice().iter_mut().zip(x.as_slice()).zip(old.as_slice()) {
                        *v = (x - old).scale(per) + v.scale(half);
                    }
                    self.v = Some(v);
                }
            }
        }
        self.stats = stats;
        system
    }

    /// An event ended a leg at this time.
    pub(super) fn land(&mut self, at: RealOf<Y>) {
        if let Some((y, v)) = self.watch.landed.take() {
            (self.t, self.y, self.v) = (at, y, v);
        }
        self.watch.dense.forget();
        self.done = self.watch.over;
    }
}

/// What is left of a leg that was run: itself, where it only paused.
#[allow(clippy::large_enum_variant)] // a box would be an allocation a step
enum Left<M: Method, Y: State, S> {
    Leg(Leg<M, Y, S>),
    System(S),
}

/// The breaks inside the span and its end, in reverse order; those closer than a few spacings are one.
fn stops<R: Real>(start: R, end: R, breaks: &[R]) -> Vec<R> {
    let mut stops: Vec<R> = vec![];
    if start == end {
        return stops;
    }
    let inside = |b: &&R| if end > start { **b > start && **b < end } else { **b < start && **b > end };
    let mut sorted: Vec<R> = breaks.iter().filter(inside).copied().collect();
    sorted.sort_by(|a, b| {
        let order = a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
        if end > start { order } else { order.reverse() }
    });
    let apart =
        |a: R, b: R| (a - b).modulus() > a.modulus().maximum(b.modulus()) * R::EPSILON * R::from_f64(32.0);
    for b in sorted {
        if apart(b, end) && apart(b, *stops.last().unwrap_or(&start)) {
            stops.push(b);
        }
    }
    stops.push(end);
    stops.reverse();
    stops
}

impl<Y: State, S: System<Y>, M: Method, P: Pace> Iterator for Steps<'_, Y, S, M, P> {
    type Item = Result<(RealOf<Y>, Y), Stopped<Y>>;

    fn next(&mut self) -> Option<Self::Item> {
        self.watch.one_by_one = true;
        loop {
            if let Some(step) = self.early.pop_front() {
                return Some(Ok(step));
            }
            if self.done {
                return None;
            }
            if let Some(why) = self.failed.take() {
                return Some(Err(self.stopped(why)));
            }
            let accepted = self.stats.accepted;
            match self.advance() {
                Err(why) => self.failed = Some(why),
                Ok(()) if self.early.is_empty() && self.stats.accepted > accepted => {
                    return Some(Ok((self.t, self.y.clone())));
                }
                Ok(()) => {}
            }
        }
    }
}
