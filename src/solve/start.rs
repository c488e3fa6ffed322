//! How a run starts: the carried vectors filled from what they mean, and the size of the first step.

use super::leg::Rules;
use super::outcome::Stats;
use crate::methods;
use crate::step::method::{Loaded, Method};
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State, first_non_finite};
use crate::step::stepper::{Refused, Unsolved};
use crate::step::system::System;
use crate::tableau::{Form, Meaning};
use num_traits::{One, Zero};

/// Steps that lie behind the first step of the method: the oldest vector it carries.
pub(crate) fn steps_behind(form: &Form) -> usize {
    let age = |m: &Meaning| match *m {
        Meaning::Y(k) | Meaning::F(k) => k,
        Meaning::V | Meaning::Taylor(_) => 0,
    };
    form.means[..form.r].iter().map(age).max().unwrap_or(0)
}

/// States and slopes at the first times of a run, oldest first.
pub(crate) struct History<Y> {
    pub ys: Vec<Y>,
    pub slopes: Vec<Y>,
}

/// Fills z from a history whose last entry is the state at t, with the velocity there.
///
/// Every carried vector is a state, a slope or the velocity at one of these times, so this serves every
/// method; one that carries nothing old has a history of one entry. `slope` is y' at t, where f does not give it.
pub(crate) fn fill<Y: State>(
    form: &Form,
    words: &mut [Y],
    system: &mut dyn System<Y>,
    t: RealOf<Y>,
    history: &History<Y>,
    v: Option<&Y>,
    slope: Option<&Y>,
) -> Result<u64, Refused> {
    let last = history.ys.len() - 1;
    let mut evaluations = 0;
    for (j, meaning) in form.means.into_iter().enumerate().take(form.r) {
        let z = &mut words[j];
        match meaning {
            Meaning::Y(k) => z.as_mut_slice().copy_from_slice(history.ys[last - k].as_slice()),
            // Made of the first slope once the step is known.
            Meaning::Taylor(_) => z.as_mut_slice().fill(Y::Scalar::zero()),
            Meaning::V => match v {
                Some(v) => z.as_mut_slice().copy_from_slice(v.as_slice()),
                None => z.as_mut_slice().fill(Y::Scalar::zero()),
            },
            Meaning::F(0) => {
                if let Some(slope) = slope {
                    z.as_mut_slice().copy_from_slice(slope.as_slice());
                    continue;
                }
                system
                    .rhs(t, &history.ys[last], z)
                    .map_err(|_| Refused { stage: 0, why: Unsolved::Domain })?;
                evaluations += 1;
            }
            Meaning::F(k) => z.as_mut_slice().copy_from_slice(history.slopes[last - k].as_slice()),
        }
    }
    Ok(evaluations)
}

/// The one-step method that starts a multistep one: of its order at least, with the fewest stages.
/// With a mass matrix it is an implicit one, whose order serves every multistep method that takes one (BDF).
pub(crate) fn starter(form: &Form, mass: bool) -> Loaded {
    if mass {
        return Loaded::of(methods::RadauIia3.name(), methods::RadauIia3.form());
    }
    let of_d = if form.d == 1 { const { methods::one_step(1) } } else { const { methods::one_step(2) } };
    let (name, form) = of_d[form.order.min(8)];
    Loaded::of(name, form)
}

/// Hairer's first step (Hairer, Nørsett, Wanner I, II.4), from the sizes of y, f and the change of f.
///
/// `slope` is f(t0, y0). The probe stays inside the span; where it is refused or not finite, it is tried
/// nearer, and at last the small step is taken as it is.
pub(crate) fn first_step<Y: State>(
    system: &mut dyn System<Y>,
    (t0, t1): (RealOf<Y>, RealOf<Y>),
    y0: &Y,
    slope: &Y,
    order: usize,
    rules: &Rules<RealOf<Y>>,
    stats: &mut Stats,
) -> RealOf<Y> {
    let size = |x: &[Y::Scalar], minus: Option<&[Y::Scalar]>| size(rules, y0, x, minus);
    let longest = (t1 - t0).modulus().minimum(rules.max_step).to_f64();
    let (d1, mut small) = (size(slope.as_slice(), None), small_step(rules, y0, slope));
    small = small.min(longest);
    let sign = if t1 > t0 { RealOf::<Y>::one() } else { -RealOf::<Y>::one() };
    let (mut probe, mut f1) = (y0.clone(), y0.clone());
    for _ in 0..3 {
        let h = sign * RealOf::<Y>::from_f64(small);
        for ((p, &y), &f) in probe.as_mut_slice().iter_mut().zip(y0.as_slice()).zip(slope.as_slice()) {
            *p = y + f.scale(h);
        }
        stats.evaluations += 1;
        // Rounding must not carry the probe past the end.
        let at = if ((t0 + h) > t1) == (t1 > t0) { t1 } else { t0 + h };
        if system.rhs(at, &probe, &mut f1).is_ok() && first_non_finite(&f1).is_none() {
            let d2 = size(f1.as_slice(), Some(slope.as_slice())) / small;
            let largest = d1.max(d2);
            let next = if largest <= 1e-15 {
                (small * 1e-3).max(1e-6)
            } else {
                (0.01 / largest).powf(1.0 / (order as f64 + 1.0))
            };
            // Hairer allows 100. For a fast y' = lambda y that is h lambda = 1 to the last bit, and there
            // the estimate of one pair, bs32, is zero.
            let h = (80.0 * small).min(next).min(longest);
            return sign * RealOf::<Y>::from_f64(if h > 0.0 && h.is_finite() { h } else { small });
        }
        small *= 1e-3;
    }
    sign * RealOf::<Y>::from_f64(small)
}

/// The step that changes y by a hundredth of itself.
pub(crate) fn small_step<Y: State>(rules: &Rules<RealOf<Y>>, y0: &Y, slope: &Y) -> f64 {
    let (d0, d1) = (size(rules, y0, y0.as_slice(), None), size(rules, y0, slope.as_slice(), None));
    let small = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * (d0 / d1) };
    if small > 0.0 && small.is_finite() { small } else { 1e-6 }
}

/// The size of `x`, or of `x` minus another, in units of the tolerances at y0.
fn size<Y: State>(rules: &Rules<RealOf<Y>>, y0: &Y, x: &[Y::Scalar], minus: Option<&[Y::Scalar]>) -> f64 {
    let ratio = |(i, y): (usize, &Y::Scalar)| {
        let (rtol, atol) = rules.tolerance.at(i);
        let weight = (atol + rtol * y.modulus()).to_f64();
        let value = minus.map_or(x[i], |minus| x[i] - minus[i]).modulus().to_f64();
        if value == 0.0 { 0.0 } else { value / weight }
    };
    let ratios = || y0.as_slice().iter().enumerate().map(ratio);
    // In units of the largest, whose square need not be a number.
    let largest = ratios().fold(0.0, f64::max);
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    let sum: f64 = ratios().map(|ratio| (ratio / largest).powi(2)).sum();
    largest * (sum / x.len() as f64).sqrt()
}
