//! A run from leg to leg: between breaks and events, with a start at each.

use super::control::{Control, Controller};
use super::dense::Dense;
use super::ivp::{Ivp, Options};
use super::outcome::{Solution, Stats, Stopped, Why, first_non_finite};
use super::run::{Ended, Leg, Pace, Rules, drive, not_finite};
use super::start::{History, fill, first_step, starter, steps_behind};
use super::watch::{Flow, Watch};
use crate::step::method::{Known, Method};
use crate::step::norm::Tolerance;
use crate::step::row::form_of;
use crate::step::scalar::{Fused, Plain, Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::stepper::Stepper;
use crate::step::system::System;
use crate::tableau::{Form, Meaning};
use num_traits::{One, Zero};
use std::collections::VecDeque;
use std::marker::PhantomData;

/// A run in progress. As an iterator it gives the time and the state after each accepted step, and at
/// last, if it stopped early, why.
pub struct Steps<'w, Y: State, S, M: Method, P> {
    method: M,
    /// Lent to a leg while it runs.
    system: Option<S>,
    leg: Option<Leg<M, Y, S>>,
    t: RealOf<Y>,
    y: Y,
    v: Option<Y>,
    /// The size of the last step that was accepted, and of the one in hand.
    h: RealOf<Y>,
    tried: RealOf<Y>,
    end: RealOf<Y>,
    /// Times at which a leg ends, the next one last.
    stops: Vec<RealOf<Y>>,
    rules: Rules<RealOf<Y>>,
    controller: Controller,
    options: Options<'w, Y>,
    watch: Watch<'w, Y>,
    stats: Stats,
    /// Why the run cannot go on.
    failed: Option<Why>,
    /// Steps that started a multistep method and are still to be given by the iterator.
    early: VecDeque<(RealOf<Y>, Y)>,
    done: bool,
    pace: PhantomData<P>,
}

impl<'w, Y: State, S: System<Y>, M: Method, P: Pace> Steps<'w, Y, S, M, P> {
    pub(crate) fn new(ivp: Ivp<'w, Y, S, M, P>) -> Self {
        const {
            assert!(M::READ || M::FORM.is_some(), "this method cannot be stepped yet: its stages are implicit");
            if let Some(form) = M::FORM {
                assert!(!P::ADAPTIVE || form.errors > 0, "no error estimate: give a step with `.step(h)`");
            }
        }
        let Ivp { system, y0, v0, span, method, mut options, .. } = ivp;
        let failed = super::check::check::<M, Y, P>(&method, &y0, v0.as_ref(), &span, &options).map(Why::Invalid);
        let (t, end) = (span.start, span.end);
        let form = form_of(&method);
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
            dense: Dense::new(form, &y0),
            point: y0.clone(),
            second_order: form.d == 2,
        };
        let controller = options.controller.unwrap_or(Controller::default_of(form.order));
        let stats = Stats::default();
        let h = RealOf::<Y>::zero();
        let mut run = Self {
            method,
            system: Some(system),
            leg: None,
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
        let leg = match self.leg.take() {
            Some(leg) => leg,
            None => match self.stops.last() {
                Some(&stop) => match self.begin(stop)? {
                    Some(leg) if self.early.is_empty() => leg,
                    leg => {
                        self.leg = leg;
                        return Ok(());
                    }
                },
                None => {
                    self.done = true;
                    return Ok(());
                }
            },
        };
        let (leg, ended) = run_leg::<M, Y, S, P>(leg, &self.rules, &mut self.watch);
        self.stats = leg.stats;
        (self.t, self.h, self.tried) = (leg.t, leg.last, leg.h);
        if let Ended::Changed = ended {
            self.system = Some(leg.system);
            self.land(leg.t);
            return self.guard_against_endless_events();
        }
        self.y.as_mut_slice().copy_from_slice(leg.stepper.y().as_slice());
        match ended {
            Ended::Paused => {
                self.leg = Some(leg);
                return Ok(());
            }
            Ended::Reached => self.t = self.stops.pop().unwrap_or(leg.t),
            Ended::Stopped => self.done = true,
            Ended::Failed(_) | Ended::Changed => {}
        }
        self.velocity_here(leg);
        self.watch.dense.forget();
        match ended {
            Ended::Failed(why) => Err(why),
            _ => {
                self.done |= self.stops.is_empty() && self.watch_is_served();
                Ok(())
            }
        }
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
    fn velocity_here(&mut self, leg: Leg<M, Y, S>) {
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
        self.system = Some(system);
    }

    /// Sets out for `stop` from where the run is. None where the starting steps already reached it.
    fn begin(&mut self, stop: RealOf<Y>) -> Result<Option<Leg<M, Y, S>>, Why> {
        let Some(mut system) = self.system.take() else { return Ok(None) };
        let method = self.method.clone();
        let form = form_of(&method);
        let mut stepper = Stepper::new(self.method.clone(), &self.y);
        // A break is met a few spacings early, where f still has its left value; spacings of zero are those
        // of what rounding leaves of the way there.
        let nudge = (stop.ulp() * RealOf::<Y>::from_f64(4.0)).maximum((stop - self.t).ulp().ulp());
        let end = match stop == self.end {
            true => stop,
            false if stop > self.t => stop - nudge,
            false => stop + nudge,
        };
        // An event may have left nothing of the way.
        if stop == self.t || (end > self.t) != (stop > self.t) {
            self.t = stop;
            self.stops.pop();
            self.system = Some(system);
            return Ok(None);
        }
        let (mut steps, mut h) = (0, RealOf::<Y>::zero());
        if !P::ADAPTIVE {
            let size = self.options.step.unwrap_or(end - self.t);
            let span = end - self.t;
            steps = (span.modulus() / size.modulus()).to_f64().round().max(1.0) as u64;
            h = span / RealOf::<Y>::from_f64(steps as f64);
            self.tried = h;
        }
        let origin = self.t;
        let mut history = History { ys: vec![self.y.clone()], slopes: vec![] };
        let behind = (steps_behind(form) as u64).min(steps);
        // Compiled only where there may be old steps to make.
        if const { M::READ || !Known::<M>::FORM.one_step() } && behind > 0 {
            let begun = Begun { origin, h, steps, end, stop, behind };
            match self.first_steps(system, form, begun, &mut history)? {
                Some(lent) => system = lent,
                None => return Ok(None),
            }
        }
        self.stats.evaluations += fill(&mut stepper, &mut system, self.t, &history, self.v.as_ref())
            .map_err(|_| Why::OutOfDomain { stage: 0 })?;

        let mut known = false;
        if P::ADAPTIVE {
            let at = match (0..form.r).find(|&j| form.means[j] == Meaning::F(0)) {
                Some(j) => j,
                None => {
                    known = form.stage[0].copies();
                    let slope = &mut stepper.words_mut()[form.r];
                    system.rhs(self.t, &self.y, slope).map_err(|_| Why::OutOfDomain { stage: 0 })?;
                    self.stats.evaluations += 1;
                    form.r
                }
            };
            let slope = stepper.word(at);
            if let Some(component) = first_non_finite(slope) {
                return Err(Why::NonFinite { component, stage: Some(0) });
            }
            let order = form.order.min(form.embedded[0].max(form.embedded[1]));
            let size = match self.options.step.take() {
                Some(size) => size,
                None => {
                    let span = (self.t, end);
                    let h = first_step(&mut system, span, &self.y, slope, order, &self.rules, &mut self.stats);
                    // Its guesses know neither the spacing of late times nor the least step.
                    h.modulus().maximum(self.t.ulp() * RealOf::<Y>::from_f64(16.0)).maximum(self.rules.min_step)
                }
            };
            let size = size.minimum((end - self.t).modulus()).minimum(self.rules.max_step);
            h = if end > self.t { size } else { -size };
        }
        Ok(Some(Leg {
            stepper,
            system,
            t: self.t,
            end,
            stop,
            h,
            origin,
            index: behind,
            steps,
            lost: RealOf::<Y>::zero(),
            control: Control::new(self.controller, estimate_order(form)),
            stats: self.stats,
            known,
            last: self.h,
        }))
    }

    /// Takes the steps that lie behind the first step of a multistep method, with a one-step one. Gives the
    /// system back, or nothing where the run ended, changed course or reached its stop on the way.
    #[inline(never)]
    fn first_steps(
        &mut self,
        mut system: S,
        form: &Form,
        Begun { origin, h, steps, end, stop, behind }: Begun<RealOf<Y>>,
        history: &mut History<Y>,
    ) -> Result<Option<S>, Why> {
        let mut first = Stepper::new(self.options.starter.clone().unwrap_or_else(|| starter(form)), &self.y);
        let lone = History { ys: vec![self.y.clone()], slopes: vec![] };
        self.stats.evaluations += fill(&mut first, &mut system, self.t, &lone, self.v.as_ref())
            .map_err(|refused| self.refused(refused.stage))?;
        for i in 1..=behind {
            let next = if i == steps { end } else { origin + RealOf::<Y>::from_f64(i as f64) * h };
            let mut slope = self.y.clone();
            self.stats.evaluations += 1;
            system.rhs(self.t, first.y(), &mut slope).map_err(|_| self.refused(0))?;
            history.slopes.push(slope);
            self.stats.evaluations += first.form().s as u64;
            first
                .attempt::<Plain, S>(&mut system, (self.t, next), h, false)
                .map_err(|refused| self.refused(refused.stage))?;
            if first_non_finite(first.next(0)).is_some()
                && let Some(why) = not_finite(&first)
            {
                self.stats.rejected.non_finite += 1;
                return Err(why);
            }
            let next = if i == steps { stop } else { next };
            if self.watch.active() {
                let calls = &mut self.stats.evaluations;
                let flow = self.watch.show(&first, &mut system, self.t, h, next, calls);
                self.watch.dense.forget();
                match flow {
                    Flow::Go | Flow::Pause => {}
                    Flow::Retry(why) => {
                        self.stats.rejected.count(&why);
                        return Err(why);
                    }
                    Flow::Stop => self.done = true,
                    Flow::Change(at) => {
                        self.stats.accepted += 1;
                        self.system = Some(system);
                        self.land(at);
                        self.note_early();
                        return self.guard_against_endless_events().map(|()| None);
                    }
                }
            }
            first.accept();
            self.stats.accepted += 1;
            (self.t, self.h) = (next, h);
            self.y.as_mut_slice().copy_from_slice(first.y().as_slice());
            self.note_early();
            history.ys.push(self.y.clone());
            if let Some(j) = first.form().means[..first.form().r].iter().position(|&m| m == Meaning::V) {
                self.v = Some(first.word(j).clone());
            }
            if self.done || i == steps {
                self.system = Some(system);
                if i == steps {
                    self.stops.pop();
                    self.done |= self.stops.is_empty();
                }
                return Ok(None);
            }
        }
        Ok(Some(system))
    }

    /// A step of fixed size was refused.
    fn refused(&mut self, stage: usize) -> Why {
        self.stats.rejected.domain += 1;
        Why::OutOfDomain { stage }
    }

    /// Hands a step that starts a multistep method to the iterator.
    fn note_early(&mut self) {
        if self.watch.one_by_one {
            self.early.push_back((self.t, self.y.clone()));
        }
    }

    /// An event ended a leg at this time.
    fn land(&mut self, at: RealOf<Y>) {
        if let Some((y, v)) = self.watch.landed.take() {
            (self.t, self.y, self.v) = (at, y, v);
        }
        self.watch.dense.forget();
        self.done = self.watch.over;
    }

    /// A ball that comes to rest bounces without end: the times between its events shrink to nothing.
    fn guard_against_endless_events(&mut self) -> Result<(), Why> {
        let occurred = &self.watch.occurrences;
        let Some(last) = occurred.last() else { return Ok(()) };
        let mut times = occurred.iter().rev().filter(|o| o.event == last.event).map(|o| o.t);
        let mut gap = || Some((times.next()? - times.next()?).modulus());
        let (Some(newest), Some(oldest)) = (gap(), times.nth(5).zip(times.next())) else { return Ok(()) };
        let all = (last.t - oldest.1).modulus();
        let ulps = |n: f64| last.t.ulp() * RealOf::<Y>::from_f64(n);
        // At even times, however short against t, something is switched on and off.
        let shrinking = newest + newest <= (oldest.0 - oldest.1).modulus() || all <= ulps(100.0);
        if all <= ulps(1e5) && shrinking { Err(Why::TooManyEvents { event: last.event }) } else { Ok(()) }
    }
}

/// A leg of fixed steps, as far as its start must know it.
struct Begun<R> {
    origin: R,
    h: R,
    steps: u64,
    end: R,
    stop: R,
    behind: u64,
}

/// The power of h in the error estimate; of two embedded rows of different order, that of DOP853's
/// combination e1^2 / sqrt(e1^2 + 0.01 e2^2).
fn estimate_order(form: &Form) -> usize {
    let of = |k: usize| form.embedded[k].min(form.order) + 1;
    match form.errors {
        2 if form.embedded[0] != form.embedded[1] => 2 * of(0) - of(1),
        0 => form.order + 1,
        _ => of(0),
    }
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
    let apart = |a: R, b: R| (a - b).modulus() > a.modulus().maximum(b.modulus()) * R::EPSILON * R::from_f64(32.0);
    for b in sorted {
        if apart(b, end) && apart(b, *stops.last().unwrap_or(&start)) {
            stops.push(b);
        }
    }
    stops.push(end);
    stops.reverse();
    stops
}

/// Runs a leg with the widest arithmetic that keeps its promise: adaptive steps may fuse products and
/// sums; fixed steps give the same bits on every machine, so only long vectors are dispatched, unfused.
fn run_leg<M: Method, Y: State, S: System<Y>, P: Pace>(
    leg: Leg<M, Y, S>,
    rules: &Rules<RealOf<Y>>,
    watch: &mut Watch<'_, Y>,
) -> (Leg<M, Y, S>, Ended) {
    #[cfg(target_arch = "x86_64")]
    if (P::ADAPTIVE || !Y::INLINE)
        && let Some(simd) = pulp::x86::V3::try_new()
    {
        return simd.vectorize(Wide::<'_, '_, M, Y, S, P> { leg, rules, watch, pace: PhantomData });
    }
    drive::<Plain, P, M, Y, S>(leg, rules, watch)
}

#[cfg(target_arch = "x86_64")]
struct Wide<'a, 'w, M: Method, Y: State, S, P> {
    leg: Leg<M, Y, S>,
    rules: &'a Rules<RealOf<Y>>,
    watch: &'a mut Watch<'w, Y>,
    pace: PhantomData<P>,
}

#[cfg(target_arch = "x86_64")]
impl<M: Method, Y: State, S: System<Y>, P: Pace> pulp::NullaryFnOnce for Wide<'_, '_, M, Y, S, P> {
    type Output = (Leg<M, Y, S>, Ended);
    #[inline(always)]
    fn call(self) -> Self::Output {
        if const { P::ADAPTIVE } {
            drive::<Fused, P, M, Y, S>(self.leg, self.rules, self.watch)
        } else {
            drive::<Plain, P, M, Y, S>(self.leg, self.rules, self.watch)
        }
    }
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
