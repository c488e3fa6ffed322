//! How a leg begins: its steps, the old states of a multistep method, the first slope, the first step.

use super::blame::not_finite;
use super::control::{Control, Controller};
use super::ivp::Structure;
use super::leg::{Leg, Pace};
use super::outcome::Why;
use super::start::{History, fill, first_step, small_step, starter, steps_behind};
use super::steps::Steps;
use super::watch::Flow;
use crate::linear::{self, ConstantMass, detect};
use crate::step::consistent::Astray;
use crate::step::implicit::Solver;
use crate::step::method::{Known, Method};
use crate::step::row::form_of;
use crate::step::scalar::{Plain, Real, Scalar};
use crate::step::state::{RealOf, State, first_non_finite};
use crate::step::stepper::{Refused, Stepper};
use crate::step::system::System;
use crate::tableau::{Form, Meaning};
use num_traits::Zero;
use std::ops::ControlFlow;

impl<Y: State, S: System<Y>, M: Method, P: Pace> Steps<'_, Y, S, M, P> {
    /// Sets out for `stop` from where the run is. Gives the system back where the starting steps already
    /// reached it.
    pub(super) fn begin<N: Method, T: System<Y>>(
        &mut self,
        method: N,
        mut system: T,
        stop: RealOf<Y>,
    ) -> Result<ControlFlow<T, Leg<N, Y, T>>, Why> {
        let form = form_of(&method);
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
            return Ok(ControlFlow::Break(system));
        }
        let (mut steps, mut h) = (0, RealOf::<Y>::zero());
        if !P::ADAPTIVE {
            let size = self.options.step.unwrap_or(end - self.t);
            let span = end - self.t;
            steps = (span.modulus() / size.modulus()).to_f64().round().max(1.0) as u64;
            h = span / RealOf::<Y>::from_f64(steps as f64);
            self.tried = h;
        }
        let mut solver = None;
        let mut slope = None;
        if !form.explicit() {
            let known = self.known(&mut system);
            let mut fresh = Solver::new(form, &self.y, &known, &self.rules.tolerance, P::ADAPTIVE);
            if let Some(mass) = known.mass.as_deref() {
                slope = Some(self.enter(&mut fresh, &mut system, mass, end)?);
            }
            solver = Some(Box::new(fresh));
        }
        let mut stepper = Stepper::new(method.clone(), &self.y);
        let origin = self.t;
        let mut history = History { ys: vec![self.y.clone()], slopes: vec![] };
        let behind = (steps_behind(form) as u64).min(steps);
        // Compiled only where there may be old steps to make.
        if const { N::READ || !Known::<N>::FORM.one_step() } && behind > 0 {
            let begun = Begun { origin, h, steps, end, stop, behind };
            match self.first_steps(system, form, begun, &mut history)? {
                ControlFlow::Continue(lent) => system = lent,
                ControlFlow::Break(lent) => return Ok(ControlFlow::Break(lent)),
            }
        }
        self.stats.evaluations +=
            fill(form, stepper.words_mut(), &mut system, self.t, &history, self.v.as_ref(), slope.as_ref())
                .map_err(|_| Why::OutOfDomain { stage: 0 })?;

        let mut known = false;
        if P::ADAPTIVE {
            let at = match (0..form.r).find(|&j| form.means[j] == Meaning::F(0)) {
                Some(j) => j,
                None => {
                    let word = &mut stepper.words_mut()[form.r];
                    match &slope {
                        Some(slope) => word.as_mut_slice().copy_from_slice(slope.as_slice()),
                        None => {
                            known = form.starts_at_y();
                            system.rhs(self.t, &self.y, word).map_err(|_| Why::OutOfDomain { stage: 0 })?;
                            self.stats.evaluations += 1;
                        }
                    }
                    form.r
                }
            };
            let first = stepper.word(at);
            if let Some(component) = first_non_finite(first) {
                return Err(Why::NonFinite { component, stage: Some(0) });
            }
            let embedded = if form.estimated() { form.s } else { form.embedded[0].max(form.embedded[1]) };
            let order = if form.orders > 0 { 1 } else { form.order.min(embedded) };
            let size = match self.options.step.take() {
                Some(size) => size,
                None => {
                    let span = (self.t, end);
                    let h = match &slope {
                        // f beside the solution tells of no slope there.
                        Some(slope) => RealOf::<Y>::from_f64(small_step(&self.rules, &self.y, slope)),
                        None => {
                            first_step(&mut system, span, &self.y, first, order, &self.rules, &mut self.stats)
                        }
                    };
                    // Its guesses know neither the spacing of late times nor the least step.
                    h.modulus()
                        .maximum(self.t.ulp() * RealOf::<Y>::from_f64(16.0))
                        .maximum(self.rules.min_step)
                }
            };
            let size = size.minimum((end - self.t).modulus()).minimum(self.rules.max_step);
            h = if end > self.t { size } else { -size };
        }
        Ok(ControlFlow::Continue(Leg {
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
            solver,
            control: Control::new(
                self.controller.unwrap_or_else(|| Controller::of_form(form)),
                estimate_order(form),
            ),
            stats: self.stats,
            known,
            last: self.h,
            stiffness: self.chooser.stiffness.take(),
        }))
    }

    /// What is known of the matrices: the pattern given, detected or the system's own.
    fn known<T: System<Y>>(&mut self, system: &mut T) -> linear::Known<Y::Scalar> {
        if let Some(known) = &self.matrices {
            return known.clone();
        }
        let pattern = match std::mem::replace(&mut self.options.structure, Structure::System) {
            Structure::Given(pattern) => Some(pattern),
            Structure::System => system.pattern(),
            Structure::Detected => {
                let (pattern, evaluations) = detect(system, self.t, &self.y);
                self.stats.evaluations += evaluations;
                Some(pattern)
            }
        };
        let mass = self.options.mass.take().and_then(Result::ok);
        let known = linear::Known::new(self.y.as_slice().len(), pattern, mass);
        self.matrices = Some(known.clone());
        known
    }

    /// The slope at the start of M y' = f(t, y), after the algebraic equations were checked, or y mended.
    #[inline(never)]
    fn enter<T: System<Y>>(
        &mut self,
        solver: &mut Solver<Y>,
        system: &mut T,
        mass: &ConstantMass<Y::Scalar>,
        end: RealOf<Y>,
    ) -> Result<Y, Why> {
        let span = (self.t, end);
        let entered = solver.enter(system, mass, span, &mut self.y, &self.rules.tolerance, self.options.mend);
        self.stats.spend(std::mem::take(&mut solver.effort));
        let slope = entered.map_err(|astray| match astray {
            Astray::Unsolved(why) => Refused { stage: 0, why }.reason(),
            Astray::Inconsistent { row, residual } => Why::Inconsistent { row, residual },
        })?;
        // The start may have been saved before it was mended.
        if self.options.mend
            && self.watch.ts.last() == Some(&self.t)
            && let Some(saved) = self.watch.ys.last_mut()
        {
            saved.as_mut_slice().copy_from_slice(self.y.as_slice());
        }
        self.watch.dense.begin(&slope);
        Ok(slope)
    }

    /// Takes the steps that lie behind the first step of a multistep method, with a one-step one. Gives the
    /// system back, or nothing where the run ended, changed course or reached its stop on the way.
    #[inline(never)]
    fn first_steps<T: System<Y>>(
        &mut self,
        mut system: T,
        form: &Form,
        Begun { origin, h, steps, end, stop, behind }: Begun<RealOf<Y>>,
        history: &mut History<Y>,
    ) -> Result<ControlFlow<T, T>, Why> {
        let mass = self.matrices.as_ref().is_some_and(|known| known.mass.is_some());
        let starter = self.options.starter.clone().unwrap_or_else(|| starter(form, mass));
        let mut first = Stepper::new(starter.clone(), &self.y);
        let mut solver =
            self.matrices.as_ref().filter(|_| !starter.form().explicit()).map(|known| {
                Box::new(Solver::new(starter.form(), &self.y, known, &self.rules.tolerance, false))
            });
        let lone = History { ys: vec![self.y.clone()], slopes: vec![] };
        self.stats.evaluations +=
            fill(starter.form(), first.words_mut(), &mut system, self.t, &lone, self.v.as_ref(), None)
                .map_err(|refused| self.refused(refused.stage))?;
        for i in 1..=behind {
            let next = if i == steps { end } else { origin + RealOf::<Y>::from_f64(i as f64) * h };
            let mut slope = self.y.clone();
            self.stats.evaluations += 1;
            system.rhs(self.t, first.y(), &mut slope).map_err(|_| self.refused(0))?;
            history.slopes.push(slope);
            let attempted = first.attempt::<Plain, T>(&mut system, (self.t, next), h, false, &mut solver);
            match &mut solver {
                Some(solver) => {
                    self.stats.spend(std::mem::take(&mut solver.effort));
                    if let Err(refused) = attempted {
                        let why = refused.reason();
                        self.stats.rejected.count(&why);
                        return Err(why);
                    }
                }
                None => {
                    self.stats.evaluations += first.form().s as u64;
                    attempted.map_err(|refused| self.refused(refused.stage))?;
                }
            }
            if first_non_finite(first.next(0)).is_some()
                && let Some(why) = not_finite(first.view())
            {
                self.stats.rejected.non_finite += 1;
                return Err(why);
            }
            let (asked, next) = (next, if i == steps { stop } else { next });
            if self.watch.active() {
                let calls = &mut self.stats.evaluations;
                let flow = self.watch.show(first.view(), &mut system, self.t, h, (asked, next), calls);
                if mass {
                    self.watch.dense.next_step();
                } else {
                    self.watch.dense.forget();
                }
                match flow {
                    Flow::Go | Flow::Pause => {}
                    Flow::Retry(why) => {
                        self.stats.rejected.count(&why);
                        return Err(why);
                    }
                    Flow::Stop => self.done = true,
                    Flow::Change(at) => {
                        self.stats.accepted += 1;
                        self.land(at);
                        self.note_early();
                        return self
                            .watch
                            .guard_against_endless_events()
                            .map(|()| ControlFlow::Break(system));
                    }
                }
            }
            first.accept();
            if let Some(solver) = &mut solver {
                solver.moved();
            }
            self.stats.accepted += 1;
            (self.t, self.h) = (next, h);
            self.y.as_mut_slice().copy_from_slice(first.y().as_slice());
            self.note_early();
            history.ys.push(self.y.clone());
            if let Some(j) = first.form().means[..first.form().r].iter().position(|&m| m == Meaning::V) {
                self.v = Some(first.word(j).clone());
            }
            if self.done || i == steps {
                if i == steps {
                    self.stops.pop();
                    self.done |= self.stops.is_empty();
                }
                return Ok(ControlFlow::Break(system));
            }
        }
        Ok(ControlFlow::Continue(system))
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
        0 if form.estimated() => form.s + 1,
        0 => form.order + 1,
        _ => of(0),
    }
}
