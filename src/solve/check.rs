//! What a problem and its options must fulfil before the first step.

use super::control::Controller;
use super::dense::Dense;
use super::event::Then;
use super::ivp::{Options, Structure};
use super::start::steps_behind;
use crate::linear::{self, ConstantMass, Pattern, Square, factor_shifted};
use crate::methods::{RadauIia5, Ros34pw2};
use crate::step::coupled;
use crate::step::method::Method;
use crate::step::norm::Tolerance;
use crate::step::scalar::{Real, Scalar, Shown};
use crate::step::state::first_non_finite;
use crate::step::state::{RealOf, State};
use crate::tableau::{Form, Meaning, Stages};
use num_traits::Zero;
use std::ops::Range;
use std::sync::Arc;

/// What is wrong and what to do about it, or nothing.
pub(crate) fn check<Y: State>(
    (name, form): (&str, &Form),
    (adaptive, approximate): (bool, bool),
    y0: &Y,
    v0: Option<&Y>,
    span: &Range<RealOf<Y>>,
    options: &Options<Y>,
) -> Option<String> {
    let zero = RealOf::<Y>::zero();
    if form.s == 0 {
        return Some(format!(
            "{name} cannot be stepped: it is a pair whose stages would have to be found together"
        ));
    }
    match (form.d, v0) {
        (2, None) => return Some(format!("{name} is for y'' = f(t, y): use solve_second with a velocity")),
        (1, Some(_)) => return Some(format!("{name} is for y' = f(t, y): use solve, or a Nyström method")),
        (2, Some(v0)) if v0.as_slice().len() != y0.as_slice().len() => {
            let (x, v) = (y0.as_slice().len(), v0.as_slice().len());
            return Some(format!("the position has {x} components but the velocity {v}"));
        }
        _ => {}
    }
    if let Some(text) = matrices((name, form), adaptive, y0.as_slice().len(), options) {
        return Some(text);
    }
    if approximate && let Some(text) = inexact((name, form), adaptive, y0, options) {
        return Some(text);
    }
    if form.d == 1 && options.events.iter().any(|event| matches!(event.then, Then::ChangeMotion(_))) {
        return Some("change_motion_at is for y'' = f(t, y): use change_at".to_string());
    }
    for (what, t) in [("start", span.start), ("end", span.end)] {
        if !t.finite() {
            return Some(format!("the span's {what} is {t}: it must be finite"));
        }
    }
    if !(span.end - span.start).finite() {
        return Some(format!("the span from {} to {} is too long for the numbers", span.start, span.end));
    }
    for (what, state) in [("y0", Some(y0)), ("v0", v0)] {
        if let Some(i) = state.and_then(first_non_finite) {
            return Some(format!("component {i} of {what} is a NaN or an infinity"));
        }
    }
    if adaptive {
        if !form.adaptive() {
            return Some(format!("{name} has no error estimate: give it a step with .step(h)"));
        }
        let set = if options.late { Some(".late") } else { options.controller.map(|_| ".controller") };
        if let Some(set) = set
            && form.orders > 0
        {
            return Some(format!("{name} chooses its steps with its order: leave out {set}"));
        }
        if let Some(text) = tolerance(&options.tolerance, y0.as_slice().len()) {
            return Some(text);
        }
        for (what, h) in [
            ("max_step", options.max_step),
            ("min_step", Some(options.min_step)),
            ("first_step", options.step),
        ] {
            if let Some(h) = h
                && !(h.finite() && (h > zero || what == "min_step" && h.is_zero()))
            {
                return Some(format!("{what} is {}: it must be positive", Shown(h)));
            }
        }
        if let Some(max_step) = options.max_step
            && max_step < options.min_step
        {
            return Some(format!(
                "min_step is {} but max_step is {}",
                Shown(options.min_step),
                Shown(max_step)
            ));
        }
        if let Some(Controller { safety, shrink, grow, .. }) = options.controller
            && !(shrink > 0.0
                && shrink < 1.0
                && safety > 0.0
                && safety <= 1.0
                && grow >= 1.0
                && grow.is_finite())
        {
            let wants = "0 < shrink < 1, 0 < safety <= 1 and 1 <= grow";
            return Some(format!(
                "the controller has shrink {shrink}, safety {safety}, grow {grow}: it needs {wants}"
            ));
        }
    } else {
        if form.orders > 0 {
            return Some(format!("{name} chooses its steps with its order: leave out .step(h)"));
        }
        let h = options.step.unwrap_or(zero);
        if !(h.finite() && h > zero) {
            return Some(format!(
                "the step is {}: it must be positive, also where time runs backwards",
                Shown(h)
            ));
        }
        let steps = ((span.end - span.start).modulus() / h).to_f64();
        if !(steps < 9e15) {
            return Some(format!("the step {} is too small for the span: {steps:e} steps", Shown(h)));
        }
        if let Some(starter) = &options.starter
            && steps_behind(form) > 0
            && !(starter.form().one_step()
                && starter.form().explicit() == options.mass.is_none()
                && starter.form().d == form.d
                && starter.form().s > 0)
        {
            let kind = if options.mass.is_none() { "explicit" } else { "implicit" };
            return Some(format!(
                "{} cannot start {name}: it needs an {kind} one-step method",
                starter.name()
            ));
        }
    }
    let forward = span.end > span.start;
    let ordered = |a: RealOf<Y>, b: RealOf<Y>| if forward { a <= b } else { a >= b };
    let mut last = span.start;
    for &time in &options.times {
        if !(ordered(last, time) && ordered(time, span.end)) {
            return Some(format!("the requested time {time} is outside the span or out of order"));
        }
        last = time;
    }
    options.breaks.iter().find(|b| !b.finite()).map(|b| format!("the break at {b} is not a time"))
}

/// The pattern and the mass matrix.
fn matrices<Y: State>(
    (name, form): (&str, &Form),
    adaptive: bool,
    n: usize,
    options: &Options<Y>,
) -> Option<String> {
    if let Structure::Given(pattern) = &options.structure
        && pattern.n() != n
    {
        return Some(format!("the pattern has {} rows but y0 {n} components", pattern.n()));
    }
    let mass = match &options.mass {
        None if options.mend => {
            return Some("consistent() is for M y' = f(t, y): give the mass matrix".to_string());
        }
        None => return None,
        Some(Err(misplaced)) => return Some(format!("the mass matrix: {misplaced}")),
        Some(Ok(mass)) => mass,
    };
    if let Some((row, column)) = mass.flaw() {
        return Some(format!("the mass matrix has a NaN or an infinity at ({row}, {column})"));
    }
    if mass.places().next().is_none() {
        return Some("the mass matrix is zero: there is nothing to integrate".to_string());
    }
    let why = if form.d == 2 {
        "is for y'' = f(t, y)"
    } else if form.explicit() {
        "is explicit"
    } else if form.orders > 0 && !form.damped {
        "iterates on f without a matrix"
    } else if form.means[..form.r].iter().any(|m| matches!(m, Meaning::F(k) if *k > 0)) {
        "uses f of older steps"
    } else if matches!(form.stages(), Stages::Diagonal)
        && form.stage[..form.s].iter().any(|row| row.diagonal.hi() == 0.0)
    {
        "has an explicit stage that is not the last one of the step before"
    } else if matches!(form.stages(), Stages::Full) && singular(form) {
        "has a singular matrix A"
    } else if adaptive && form.estimated() && !form.carry[0].last_y {
        return Some(format!(
            "{name} leaves the algebraic equations of M y' = f(t, y) by what its error estimate takes for an error: \
             give it a step with .step(h), or take a stiffly accurate method"
        ));
    } else if (!options.times.is_empty() || !options.events.is_empty()) && !Dense::<Y>::can_serve_mass(form) {
        return Some(format!(
            "{name} has no values between steps for M y' = f(t, y), which at() and events ask for: take one with dense \
             output, a stiffly accurate or a fully implicit one"
        ));
    } else {
        return None;
    };
    Some(format!("{name} {why}: M y' = f(t, y) needs a method whose slopes are all found implicitly"))
}

/// An approximate Jacobian: what takes its order from df/dy has lost it.
fn inexact<Y: State>(
    (name, form): (&str, &Form),
    adaptive: bool,
    y0: &Y,
    options: &Options<Y>,
) -> Option<String> {
    if let Some(Ok(mass)) = &options.mass
        && !regular(y0, mass)
    {
        return Some(
            "the mass matrix is singular: what its algebraic equations determine takes the Jacobian itself, \
             not an approximate one"
                .to_string(),
        );
    }
    let starter = options.starter.as_ref().filter(|_| !adaptive && steps_behind(form) > 0);
    let others = starter.map(|starter| (starter.name(), starter.form()));
    std::iter::once((name, form)).chain(others).find_map(|(name, form)| {
        let left = form.inexact;
        let lost = [
            ("step", form.order, left.step, true),
            ("dense output", form.dense_order, left.dense, true),
            ("error estimate", form.embedded[0], left.embedded[0], adaptive),
            ("error estimate", form.embedded[1], left.embedded[1], adaptive),
        ];
        let (what, order, left, _) = lost.into_iter().find(|&(_, order, left, asked)| asked && left < order)?;
        let [iterates, w] = [RadauIia5.name(), Ros34pw2.name()];
        form.linear.then(|| {
            format!(
                "{name} needs the Jacobian itself: with an approximate one the order of its {what} falls from {order} \
                 to {left}. Take a method that iterates, such as {iterates}, or a W-method, such as {w}"
            )
        })
    })
}

/// M has an inverse.
fn regular<Y: State>(y0: &Y, mass: &ConstantMass<Y::Scalar>) -> bool {
    let pattern = Arc::new(Pattern::banded(y0.as_slice().len(), 0, 0).with(mass.places()));
    let nothing = Y::Square::new(&pattern);
    factor_shifted(&mut nothing.clone(), &nothing, Some(mass), |m| m, |j| j).is_ok()
}

fn singular(form: &Form) -> bool {
    let mut a: Vec<f64> = coupled::matrix(form).concat();
    linear::factor(form.s, &mut a, &mut vec![0; form.s]).is_err()
}

fn tolerance<R: Real>(tolerance: &Tolerance<R>, n: usize) -> Option<String> {
    let one = |rtol: R, atol: R| {
        let good = |x: R| x.finite() && x >= R::zero();
        if !good(rtol) || !good(atol) || (rtol.is_zero() && atol.is_zero()) {
            return Some(format!(
                "rtol = {}, atol = {}: both must be at least 0, and one positive",
                Shown(rtol),
                Shown(atol)
            ));
        }
        None
    };
    match tolerance {
        Tolerance::Scalar { rtol, atol } => one(*rtol, *atol),
        Tolerance::Each(each) if each.len() != n => {
            Some(format!("{} tolerances are given for {n} components", each.len()))
        }
        Tolerance::Each(each) => each.iter().find_map(|&(rtol, atol)| one(rtol, atol)),
    }
}
