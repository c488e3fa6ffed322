//! What looks on while a run goes: saved states, the observer, events.

use super::dense::Dense;
use super::event::{Event, Then, find_roots};
use super::outcome::{Occurrence, Why};
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::stepper::View;
use crate::step::system::System;
use num_traits::One;
use std::ops::ControlFlow;

/// One accepted step, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Step<'s, Y: State> {
    /// The time at the end of the step.
    pub t: RealOf<Y>,
    /// Its size, negative where time runs backwards.
    pub h: RealOf<Y>,
    pub y: &'s Y,
}

/// An observer: it sees every accepted step and may end the run.
pub(crate) type Observer<'w, Y> = dyn FnMut(&Step<Y>) -> ControlFlow<()> + 'w;

/// What the loop does next.
#[derive(PartialEq, Debug)]
pub(crate) enum Flow<R> {
    Go,
    /// Accept this step, then wait.
    Pause,
    /// Accept this step, then end the run.
    Stop,
    /// Dense output left the domain or the numbers: try a smaller step.
    Retry(Why),
    /// An event ends the leg at this time, inside the step; the state there is in `landed`.
    Change(R),
}

/// Everything that looks on.
pub(crate) struct Watch<'w, Y: State> {
    /// Requested times in the order of the run, and the next of them.
    pub times: Vec<RealOf<Y>>,
    pub next: usize,
    pub every_step: bool,
    /// Pause after each step: an iterator takes them one by one.
    pub one_by_one: bool,
    pub ts: Vec<RealOf<Y>>,
    pub ys: Vec<Y>,
    pub vs: Vec<Y>,
    pub observer: Option<Box<Observer<'w, Y>>>,
    pub events: Vec<Event<'w, Y>>,
    pub occurrences: Vec<Occurrence<Y>>,
    /// Room for a state between steps.
    pub point: Y,
    /// The state and velocity at which an event ended a leg, after its change.
    pub landed: Option<(Y, Option<Y>)>,
    /// An event or the observer ended the run for good.
    pub over: bool,
    pub dense: Dense<Y>,
    pub second_order: bool,
}

impl<Y: State> Watch<'_, Y> {
    pub fn active(&self) -> bool {
        self.every_step
            || self.one_by_one
            || self.next < self.times.len()
            || self.observer.is_some()
            || !self.events.is_empty()
    }

    /// The slope at the end of the step just accepted, if dense output had to evaluate it; forgets the step.
    pub fn end_slope(&mut self) -> Option<&Y> {
        if self.dense.next_step() { Some(self.dense.carried_slope()) } else { None }
    }

    /// A step was attempted and is good. Returns what to do, and counts the evaluations of the dense output. f is
    /// asked no later than at `asked`, which lies right before `t1` where that is a break.
    #[cold]
    #[inline(never)]
    pub fn show(
        &mut self,
        view: View<Y>,
        system: &mut dyn System<Y>,
        t: RealOf<Y>,
        h: RealOf<Y>,
        (asked, t1): (RealOf<Y>, RealOf<Y>),
        evaluations: &mut u64,
    ) -> Flow<RealOf<Y>> {
        self.look(view, system, (t, asked, t1), h, evaluations).unwrap_or_else(Flow::Retry)
    }

    fn look(
        &mut self,
        view: View<Y>,
        system: &mut dyn System<Y>,
        (t, asked, t1): (RealOf<Y>, RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        evaluations: &mut u64,
    ) -> Result<Flow<RealOf<Y>>, Why> {
        let mut flow = if self.one_by_one { Flow::Pause } else { Flow::Go };
        let forward = t1 > t;
        let reached = |time: RealOf<Y>, end: RealOf<Y>| if forward { time <= end } else { time >= end };

        if self.dense.follows() {
            self.dense.prepare(view, system, t, h, asked, evaluations)?;
        }
        // Events first: one of them may end the step early.
        let mut end = t1;
        if !self.events.is_empty() {
            self.dense.prepare(view, system, t, h, asked, evaluations)?;
            let dense = &self.dense;
            let at = |theta: RealOf<Y>, out: &mut Y| match theta == RealOf::<Y>::one() {
                true => out.as_mut_slice().copy_from_slice(view.next(0).as_slice()),
                false => dense.at(view, h, theta, out),
            };
            let roots = find_roots(&mut self.events, &at, view.y(), t, h, t1, &mut self.point);
            for root in roots {
                // Only roots at the very same time still count after one that ended the step.
                if flow == Flow::Change(end) && root.t != end {
                    break;
                }
                let (mut y, mut v) = self.landed.take().unwrap_or_else(|| {
                    let mut y = view.y().clone();
                    at(root.theta, &mut y);
                    let v = self.second_order.then(|| {
                        let mut v = view.y().clone();
                        dense.velocity_at(view, h, root.theta, &mut v);
                        v
                    });
                    (y, v)
                });
                self.occurrences.push(Occurrence { event: root.event, t: root.t, y: y.clone() });
                let event = &mut self.events[root.event];
                match &mut event.then {
                    Then::Record if flow != Flow::Change(end) => continue,
                    Then::Record => {}
                    Then::Stop => self.over = true,
                    Then::Change(change) => {
                        event.root = Some((event.g)(root.t, &y));
                        change(root.t, &mut y);
                    }
                    Then::ChangeMotion(change) => {
                        event.root = Some((event.g)(root.t, &y));
                        if let Some(v) = &mut v {
                            change(root.t, &mut y, v);
                        }
                    }
                }
                self.landed = Some((y, v));
                end = root.t;
                flow = Flow::Change(end);
            }
            if let Some((y, _)) = &self.landed {
                self.events.iter_mut().for_each(|event| event.restart(end, y));
            }
        }

        let mut saved = false;
        while self.next < self.times.len() && reached(self.times[self.next], end) {
            let time = self.times[self.next];
            // The ends of a step are given back as they were computed, to the last bit.
            if time == t1 && end == t1 {
                self.save_end(view, system, (t, asked, t1), h, evaluations)?;
                saved = true;
            } else {
                self.dense.prepare(view, system, t, h, asked, evaluations)?;
                let theta = (time - t) / h;
                let mut y = view.y().clone();
                self.dense.at(view, h, theta, &mut y);
                self.ts.push(time);
                self.ys.push(y);
                if self.second_order {
                    let mut v = view.y().clone();
                    self.dense.velocity_at(view, h, theta, &mut v);
                    self.vs.push(v);
                }
            }
            self.next += 1;
        }
        if self.every_step && (!saved || self.landed.is_some()) {
            match &self.landed {
                Some((y, v)) => {
                    self.ts.push(end);
                    self.ys.push(y.clone());
                    self.vs.extend(v.clone());
                }
                None => self.save_end(view, system, (t, asked, t1), h, evaluations)?,
            }
        }
        if let Some(observer) = &mut self.observer {
            let y = match &self.landed {
                Some((y, _)) => y,
                None => view.next(0),
            };
            let size = if end == t1 { h } else { end - t };
            if observer(&Step { t: end, h: size, y }).is_break() {
                self.over = true;
                if !matches!(flow, Flow::Change(_)) {
                    flow = Flow::Stop;
                }
            }
        }
        Ok(flow)
    }

    /// Saves the state at the end of the step, and the velocity there.
    fn save_end(
        &mut self,
        view: View<Y>,
        system: &mut dyn System<Y>,
        (t, asked, t1): (RealOf<Y>, RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        evaluations: &mut u64,
    ) -> Result<(), Why> {
        if self.second_order {
            let mut v = view.y().clone();
            self.dense.end_velocity(view, system, t, h, asked, &mut v, evaluations)?;
            self.vs.push(v);
        }
        self.ts.push(t1);
        self.ys.push(view.next(0).clone());
        Ok(())
    }

    /// A ball that comes to rest bounces without end: the times between its events shrink to nothing.
    pub fn guard_against_endless_events(&mut self) -> Result<(), Why> {
        let occurred = &self.occurrences;
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
