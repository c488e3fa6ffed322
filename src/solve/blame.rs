//! Whom to blame for a step that failed: off the hot path, compiled once for a state.

use super::outcome::{Stats, Why};
use crate::step::norm::Tolerance;
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State, first_non_finite};
use crate::step::stepper::View;
use num_traits::Zero;

/// Names the stage and the component where the first NaN or infinity arose, if there is one.
#[cold]
#[inline(never)]
pub(crate) fn not_finite<Y: State>(view: View<Y>) -> Option<Why> {
    let form = view.form;
    let stage =
        (0..form.s).find_map(|stage| Some((first_non_finite(view.word(form.r + stage))?, Some(stage))));
    let (component, stage) = stage.or_else(|| Some((first_non_finite(view.next(0))?, None)))?;
    Some(Why::NonFinite { component, stage })
}

#[cold]
#[inline(never)]
pub(super) fn first_slope_is_finite<Y: State>(view: View<Y>) -> bool {
    first_non_finite(view.word(view.form.r)).is_none()
}

/// Boyer and Moore's majority vote over the components that dominate rejected steps.
#[cold]
#[inline(never)]
pub(super) fn vote<Y: State>(
    mut stats: Stats,
    view: View<Y>,
    h: RealOf<Y>,
    tolerance: &Tolerance<RealOf<Y>>,
) -> Stats {
    let form = view.form;
    let (x, y0, y1) = (view.read(), view.y().as_slice(), view.next(0).as_slice());
    let row = &form.error[0];
    let mut worst = (0, RealOf::<Y>::zero());
    for i in 0..y0.len() {
        let mut e = Y::Scalar::zero();
        for j in 0..row.len {
            e = e + x[row.at[j]].as_slice()[i].scale(h * RealOf::<Y>::of(row.a[j]));
        }
        let (rtol, atol) = tolerance.at(i);
        let ratio = e.modulus() / (atol + rtol * y0[i].modulus().maximum(y1[i].modulus()));
        if ratio > worst.1 {
            worst = (i, ratio);
        }
    }
    if stats.limiting == Some(worst.0) {
        stats.votes += 1;
    } else if stats.votes == 0 {
        stats.limiting = Some(worst.0);
        stats.votes = 1;
    } else {
        stats.votes -= 1;
    }
    stats
}
