//! The loop: from a start to an end, step by step, fixed or adaptive.

use super::blame::{first_slope_is_finite, not_finite, vote};
use super::leg::{Ended, Leg, Pace, Rules};
use super::outcome::Why;
use super::watch::{Flow, Watch};
use crate::step::method::{Known, Method};
use crate::step::row::form_of;
use crate::step::scalar::{Arith, Fused, Plain, Real, Rolled, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::stepper::{Stepper, View, unseen_slope};
use crate::step::system::System;
use crate::tableau::Stages;
use num_traits::One;
use std::marker::PhantomData;

/// Runs a leg with the widest arithmetic that keeps its promise: adaptive steps may fuse products and
/// sums; fixed steps give the same bits on every machine, so only long vectors are dispatched, unfused.
pub(crate) fn run_leg<M: Method, Y: State, S: System<Y>, P: Pace>(
    leg: Leg<M, Y, S>,
    rules: &Rules<RealOf<Y>>,
    watch: &mut Watch<'_, Y>,
) -> (Leg<M, Y, S>, Ended) {
    #[cfg(target_arch = "x86_64")]
    if P::ADAPTIVE || !Y::INLINE {
        return match pulp::x86::V3::try_new() {
            Some(simd) => simd.vectorize(Wide::<'_, '_, M, Y, S, P> { leg, rules, watch, pace: PhantomData }),
            None => drive::<Rolled, P, M, Y, S>(leg, rules, watch),
        };
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

/// Runs to the end of the leg. It owns the leg: a stepper behind a reference would live in memory, and
/// what is stored by component and read as a pair waits for the store.
#[inline(always)]
pub(crate) fn drive<A: Arith, P: Pace, M: Method, Y: State, S: System<Y>>(
    leg: Leg<M, Y, S>,
    rules: &Rules<RealOf<Y>>,
    watch: &mut Watch<'_, Y>,
) -> (Leg<M, Y, S>, Ended) {
    let Leg { mut stepper, mut system, mut t, end, stop, mut h, .. } = leg;
    let Leg {
        origin,
        mut index,
        steps,
        mut lost,
        mut control,
        mut solver,
        mut stats,
        mut known,
        mut last,
        mut stiffness,
        ..
    } = leg;
    let form = form_of(&stepper.method);
    let (stages, first_is_copy) = if const { Known::<M>::UNROLLED } {
        (const { Known::<M>::FORM.s as u64 }, const { Known::<M>::FORM.starts_at_y() })
    } else {
        (form.s as u64, form.starts_at_y())
    };
    let unseen = if const { Known::<M>::UNROLLED } {
        const { unseen_slope(Known::<M>::FORM) }
    } else {
        unseen_slope(form)
    };
    let mut before = h;
    let mut look = stiffness.as_ref().map_or(u64::MAX, |stiffness| stiffness.look);
    let longest = rules.max_step * (RealOf::<Y>::one() + RealOf::<Y>::from_f64(16.0) * RealOf::<Y>::EPSILON);
    let watching = watch.active();
    let implicit = const { M::READ || !Known::<M>::FORM.explicit() } && solver.is_some();
    // The order is chosen with the step.
    let varies = const { M::READ || Known::<M>::FORM.orders > 0 } && form.orders > 0;
    // The factors of stages found together are dear, and serve for as long as the step is the same.
    let settles = implicit && matches!(form.stages(), Stages::Full);
    // The stage that was refused when the step was last cut, until the step grows again.
    let mut edge = None;
    // Steps of one size that nobody looks at: the method and nothing else. The one that fails, if one does, is
    // judged below with the others.
    let mut tried = None;
    if !P::ADAPTIVE && !watching && !known {
        let from = index;
        while index + 1 < steps {
            let next = origin + RealOf::<Y>::from_f64((index + 1) as f64) * h;
            let attempted = stepper.attempt::<A, S>(&mut system, (t, next), h, false, &mut solver);
            if attempted.is_err() || !all_finite(stepper.next(0).as_slice()) {
                tried = Some(attempted);
                break;
            }
            stepper.accept();
            if implicit && let Some(solver) = &mut solver {
                solver.moved();
                stats.spend(std::mem::take(&mut solver.effort));
            }
            (t, index, last) = (next, index + 1, h);
        }
        stats.accepted += index - from;
        if !implicit {
            stats.evaluations += (index - from) * stages;
        }
    }
    let ended = loop {
        if P::ADAPTIVE && stats.accepted + stats.rejected.total() >= rules.max_steps {
            break Ended::Failed(Why::TooManySteps { attempts: rules.max_steps });
        }
        // The time after this step, exact where it is the end.
        let (step, next, lands) = if P::ADAPTIVE {
            let left = (end - t) - lost;
            // A little more than h is taken at once, lest a sliver be left.
            let reach = (h.modulus() * RealOf::<Y>::from_f64(1.0 + 1e-3)).minimum(longest);
            if left.modulus() <= reach {
                (left, end, true)
            } else {
                if too_small(h, t, rules.min_step) {
                    break Ended::Failed(match edge {
                        Some(why) => why,
                        None => Why::StepTooSmall { limiting: stats.limiting },
                    });
                }
                (h, t + (h + lost), false)
            }
        } else {
            let lands = index + 1 == steps;
            (h, if lands { end } else { origin + RealOf::<Y>::from_f64((index + 1) as f64) * h }, lands)
        };

        let attempted = match tried.take() {
            Some(attempted) => attempted,
            None => stepper.attempt::<A, S>(&mut system, (t, next), step, known, &mut solver),
        };
        let (asked, next) = (next, if lands { stop } else { next });
        if implicit && let Some(solver) = &mut solver {
            stats.spend(std::mem::take(&mut solver.effort));
        } else {
            stats.evaluations += stages - u64::from(known && first_is_copy);
        }
        // A second try finds the first slope in place; a step that failed in its first stage does not.
        known = false;

        let mut square = 0.0;
        let good = attempted.is_ok()
            && if P::ADAPTIVE {
                let made = match &mut solver {
                    Some(solver) if implicit => solver.error_square(stepper.view(), &rules.tolerance),
                    _ => None,
                };
                square = match made {
                    Some(square) => square.to_f64(),
                    None => stepper.error_square::<A>(step, &rules.tolerance).to_f64(),
                };
                if let Some(at) = unseen
                    && !all_finite(stepper.word(at).as_slice())
                {
                    square = f64::NAN;
                }
                square <= 1.0
            } else {
                all_finite(stepper.next(0).as_slice())
            };
        if !good {
            let why = match attempted {
                Err(refused) => {
                    let why = refused.reason();
                    stats.rejected.count(&why);
                    if !implicit {
                        stats.evaluations -= stages - 1 - refused.stage as u64;
                    }
                    known = refused.stage > 0 && first_is_copy;
                    let factor = match why {
                        Why::NonFinite { .. } | Why::Jacobian { .. } => control.rejected(f64::NAN),
                        Why::NewtonFailed { .. } => control.diverged(),
                        _ => control.refused(),
                    };
                    h = step * RealOf::<Y>::from_f64(factor);
                    edge = Some(why.clone());
                    why
                }
                Ok(()) => {
                    edge = None;
                    known = first_is_copy && lend(&stepper, first_slope_is_finite);
                    let factor = match &mut solver {
                        Some(solver) if varies => {
                            let (form, words) = stepper.form_and_words();
                            solver.rechosen(form, words)
                        }
                        _ => control.rejected(square),
                    };
                    h = step * RealOf::<Y>::from_f64(factor);
                    // An error beyond the range of numbers is an error all the same.
                    let flaw =
                        if P::ADAPTIVE && square.is_finite() { None } else { lend(&stepper, not_finite) };
                    if let Some(why) = flaw {
                        stats.rejected.non_finite += 1;
                        why
                    } else {
                        stats.rejected.error += 1;
                        stats = lend(&stepper, |s| vote(stats, s, step, &rules.tolerance));
                        Why::StepTooSmall { limiting: stats.limiting }
                    }
                }
            };
            let hopeless = implicit && matches!(why, Why::OutsidePattern { .. } | Why::Rounding { .. });
            if !P::ADAPTIVE || hopeless || too_small(h, t, rules.min_step) {
                h = if P::ADAPTIVE { h } else { step };
                break Ended::Failed(why);
            }
            before = h;
            continue;
        }

        let mut flow = Flow::Go;
        if watching {
            let calls = &mut stats.evaluations;
            flow = lend(&stepper, |s| watch.show(s, &mut system, t, step, (asked, next), calls));
            match flow {
                Flow::Go | Flow::Pause | Flow::Stop => {}
                Flow::Retry(why) => {
                    stats.rejected.count(&why);
                    known = first_is_copy;
                    h = step * RealOf::<Y>::from_f64(control.refused());
                    if !P::ADAPTIVE || too_small(h, t, rules.min_step) {
                        h = if P::ADAPTIVE { h } else { step };
                        break Ended::Failed(why);
                    }
                    before = h;
                    continue;
                }
                Flow::Change(at) => {
                    (t, last) = (at, at - t);
                    stats.accepted += 1;
                    break Ended::Changed;
                }
            }
        }
        let mut turned = false;
        if const { P::ADAPTIVE && (M::AUTO || M::READ) }
            && stats.accepted >= look
            && let Some(stiffness) = &mut stiffness
        {
            turned = match &mut solver {
                Some(solver) if const { M::READ } => stiffness.ends(solver.reach(step)),
                _ => lend(&stepper, |s| stiffness.begins(s, &rules.tolerance)),
            };
            look = stiffness.next_look(stats.accepted);
            stiffness.look = look;
        }
        stepper.accept();
        if implicit && let Some(solver) = &mut solver {
            solver.moved();
        }
        if watching
            && let Some(slope) = watch.end_slope()
            && first_is_copy
        {
            let r = form_of(&stepper.method).r;
            stepper.words_mut()[r].as_mut_slice().copy_from_slice(slope.as_slice());
            known = true;
        }
        stats.accepted += 1;
        let before_last = std::mem::replace(&mut last, step);
        if P::ADAPTIVE {
            lost = (step - (next - t)) + lost;
            let factor = match &mut solver {
                Some(solver) if varies => {
                    let (form, words) = stepper.form_and_words();
                    solver.chosen(form, words)
                }
                _ => control.accepted(square, || (step / before_last).to_f64()),
            };
            let next_step = step * RealOf::<Y>::from_f64(factor);
            let next_step = match &solver {
                Some(solver) if settles => solver.settled(step, next_step),
                _ => next_step,
            };
            // A step cut short by the end says nothing about the size that was wanted.
            let next_step = if lands && next_step.modulus() < h.modulus() { h } else { next_step };
            let fresh = next_step.minimum(rules.max_step).maximum(-rules.max_step);
            if fresh.modulus() > step.modulus() {
                edge = None;
            }
            h = if rules.late { before } else { fresh };
            before = fresh;
        } else {
            index += 1;
        }
        t = next;
        match flow {
            Flow::Stop => break Ended::Stopped,
            _ if lands => break Ended::Reached,
            _ if turned => break Ended::Turned,
            Flow::Pause => break Ended::Paused,
            _ => {}
        }
    };
    (
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
        },
        ended,
    )
}

/// The step does not move the time, or not as far as it must at least.
#[inline(always)]
fn too_small<R: Real>(h: R, t: R, min_step: R) -> bool {
    h.modulus() < min_step || h.modulus() <= t.ulp() * R::from_f64(4.0)
}

/// Looked at a block at a time, so that a long vector is read at the speed of memory.
#[inline(always)]
fn all_finite<T: Scalar>(x: &[T]) -> bool {
    x.chunks(64).all(|block| block.iter().fold(true, |good, x| good & x.finite()))
}

/// Shows the stepper to a function that is not inlined: a copy where it lives in registers, since an
/// address that escapes would keep it in memory; itself where the vectors are on the heap anyway.
#[inline(always)]
fn lend<M: Method, Y: State, T>(stepper: &Stepper<M, Y>, to: impl FnOnce(View<Y>) -> T) -> T {
    if const { Y::INLINE && !M::READ } {
        let copy = stepper.clone();
        to(copy.view())
    } else {
        to(stepper.view())
    }
}
