//! What looks on while a run goes: saved states, the observer, events.

use super::dense::Dense;
use super::event::{Event, Then, find_roots};
use super::outcome::Occurrence;
use crate::step::method::Method;
use crate::step::state::{RealOf, State};
use crate::step::stepper::Stepper;
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
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Flow<R> {
    Go,
    /// Accept this step, then end the run.
    Stop,
    /// Dense output left the domain: try a smaller step.
    Retry,
    /// An event ends the leg at this time, inside the step; the state there is in `landed`.
    Change(R),
}

/// Everything that looks on.
pub(crate) struct Watch<'w, Y: State> {
    /// Requested times in the order of the run, and the next of them.
    pub times: Vec<RealOf<Y>>,
    pub next: usize,
    pub every_step: bool,
    /// End the leg after each step: an iterator takes them one by one.
    pub one_by_one: bool,
    pub ts: Vec<RealOf<Y>>,
    pub ys: Vec<Y>,
    pub vs: Vec<Y>,
    pub observer: Option<Box<Observer<'w, Y>>>,
    pub events: Vec<Event<'w, Y>>,
    pub occurrences: Vec<Occurrence<Y>>,
    /// The state and velocity at which an event ended a leg, after its change.
    pub landed: Option<(Y, Option<Y>)>,
    /// The event that ended the run for good.
    pub stopped_by: Option<usize>,
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

    /// A step was attempted and is good. Returns what to do and the evaluations of the dense output.
    #[cold]
    #[inline(never)]
    pub fn show<M: Method, S: System<Y>>(
        &mut self,
        stepper: &Stepper<M, Y>,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        t1: RealOf<Y>,
    ) -> (Flow<RealOf<Y>>, u64) {
        let mut evaluations = 0;
        let mut flow = if self.one_by_one { Flow::Stop } else { Flow::Go };
        let forward = t1 > t;
        let reached = |time: RealOf<Y>, end: RealOf<Y>| if forward { time <= end } else { time >= end };

        // Events first: one of them may end the step early.
        let mut end = t1;
        if !self.events.is_empty() {
            match self.dense.prepare(stepper, system, t, h) {
                Ok(n) => evaluations += n,
                Err(_) => return (Flow::Retry, evaluations),
            }
            let dense = &self.dense;
            let at = |theta: RealOf<Y>, out: &mut Y| match theta == RealOf::<Y>::one() {
                true => out.as_mut_slice().copy_from_slice(stepper.next(0).as_slice()),
                false => dense.at(stepper, h, theta, out),
            };
            let roots = find_roots(&mut self.events, &at, stepper.y(), t, h, t1);
            for root in roots {
                let mut y = stepper.y().clone();
                at(root.theta, &mut y);
                self.occurrences.push(Occurrence { event: root.event, t: root.t, y: y.clone() });
                match &mut self.events[root.event].then {
                    Then::Record => continue,
                    Then::Stop => {
                        self.stopped_by = Some(root.event);
                        self.landed = Some((y, None));
                    }
                    Then::Change(change) => {
                        change(root.t, &mut y);
                        self.landed = Some((y, None));
                    }
                }
                if self.second_order {
                    let mut v = stepper.y().clone();
                    self.dense.velocity_at(stepper, h, root.theta, &mut v);
                    if let Some(landed) = &mut self.landed {
                        landed.1 = Some(v);
                    }
                }
                end = root.t;
                flow = Flow::Change(root.t);
                break;
            }
        }

        while self.next < self.times.len() && reached(self.times[self.next], end) {
            let time = self.times[self.next];
            // The ends of a step are given back as they were computed, to the last bit.
            if time == t1 && end == t1 {
                match self.save_end(stepper, system, t, h, t1) {
                    Some(n) => evaluations += n,
                    None => return (Flow::Retry, evaluations),
                }
            } else {
                match self.dense.prepare(stepper, system, t, h) {
                    Ok(n) => evaluations += n,
                    Err(_) => return (Flow::Retry, evaluations),
                }
                let theta = (time - t) / h;
                let mut y = stepper.y().clone();
                self.dense.at(stepper, h, theta, &mut y);
                self.ts.push(time);
                self.ys.push(y);
                if self.second_order {
                    let mut v = stepper.y().clone();
                    self.dense.velocity_at(stepper, h, theta, &mut v);
                    self.vs.push(v);
                }
            }
            self.next += 1;
        }
        if self.every_step {
            match (&self.landed, flow) {
                (Some((y, v)), Flow::Change(at)) => {
                    self.ts.push(at);
                    self.ys.push(y.clone());
                    self.vs.extend(v.clone());
                }
                _ => match self.save_end(stepper, system, t, h, t1) {
                    Some(n) => evaluations += n,
                    None => return (Flow::Retry, evaluations),
                },
            }
        }
        if let Some(observer) = &mut self.observer {
            let y = match &self.landed {
                Some((y, _)) => y,
                None => stepper.next(0),
            };
            let size = if end == t1 { h } else { end - t };
            if observer(&Step { t: end, h: size, y }).is_break() && flow == Flow::Go {
                flow = Flow::Stop;
            }
        }
        (flow, evaluations)
    }

    /// Saves the state at the end of the step; None where the velocity there could not be had.
    fn save_end<M: Method, S: System<Y>>(
        &mut self,
        stepper: &Stepper<M, Y>,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        t1: RealOf<Y>,
    ) -> Option<u64> {
        let mut evaluations = 0;
        if self.second_order {
            let mut v = stepper.y().clone();
            evaluations = self.dense.end_velocity(stepper, system, t, h, &mut v).ok()?;
            self.vs.push(v);
        }
        self.ts.push(t1);
        self.ys.push(stepper.next(0).clone());
        Some(evaluations)
    }
}
