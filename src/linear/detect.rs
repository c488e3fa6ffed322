//! Which components of f depend on which of y, found by trying.

use super::pattern::Pattern;
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::system::System;
use num_traits::One;

/// The entries of df/dy that were seen to be other than zero, with the number of evaluations: each component is
/// changed in turn, at `y` and at two points beside it, and what of f changes with it is noted. A column that f
/// refuses to have changed counts as full.
///
/// What it misses: an entry that is zero, or lost in rounding, at all three points; a branch of f that none of
/// them takes.
pub(crate) fn detect<Y: State>(system: &mut dyn System<Y>, t: RealOf<Y>, y: &Y) -> (Pattern, u64) {
    let n = y.as_slice().len();
    let real = RealOf::<Y>::from_f64;
    let largest = y.as_slice().iter().fold(0.0f64, |m, y| m.max(y.modulus().to_f64()));
    let typical = if largest > 0.0 { largest } else { 1.0 };
    // Zeros move too, by less: to either side of them f may not be defined.
    let moved = |y: Y::Scalar, by: f64| {
        let size = y.modulus().to_f64();
        y + Y::Scalar::one().scale(real(by * if size > 0.0 { size } else { 1e-3 * typical }))
    };
    let mut places: Vec<(usize, usize)> = vec![];
    let mut evaluations = 0;
    let (mut at, mut from, mut to) = (y.clone(), y.clone(), y.clone());
    for point in 0..3 {
        for (i, (at, &y)) in at.as_mut_slice().iter_mut().zip(y.as_slice()).enumerate() {
            // Another share for every component, so that differences do not cancel.
            let share = (0.37 + 0.618_033_988_749_895 * (point * n + i) as f64).fract();
            *at = if point == 0 { y } else { moved(y, 0.02 * share) };
        }
        evaluations += 1;
        if system.rhs(t, &at, &mut from).is_err() {
            continue;
        }
        for j in 0..n {
            let was = at.as_slice()[j];
            let mut seen = false;
            for by in [1e-3, -1e-3] {
                at.as_mut_slice()[j] = moved(was, by);
                evaluations += 1;
                if system.rhs(t, &at, &mut to).is_ok() {
                    let changed = from.as_slice().iter().zip(to.as_slice()).enumerate();
                    // A NaN differs from itself: what f cannot tell here counts as dependent.
                    places.extend(changed.filter(|(_, (a, b))| a != b).map(|(i, _)| (i, j)));
                    seen = true;
                    break;
                }
            }
            at.as_mut_slice()[j] = was;
            if !seen {
                places.extend((0..n).map(|i| (i, j)));
            }
        }
    }
    // Every place lies inside.
    let pattern = Pattern::of(n, places).unwrap_or_else(|_| Pattern::dense(n));
    (pattern, evaluations)
}
