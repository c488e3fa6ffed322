//! What errors are measured against: known values, the exact solution, else a tight run.

use super::Unfit;
use super::entrant::{Posed, in_time};
use crate::methods::Verner87Efficient;
use crate::solve::ivp::solve;
use crate::step::method::Method;
use crate::step::state::State;
use crate::step::system::{OutOfDomain, System};
use std::time::{Duration, Instant};

/// Times along the way, the end included.
const TIMES: usize = 32;
/// rtol of the tight run, and of a second one whose distance from it shows how good both are.
const TIGHT: f64 = 1e-14;
const SECOND: f64 = 1e-13;
/// The tight run is given up after this.
const PATIENCE: Duration = Duration::from_secs(5);

/// Where the values at the end of the span come from.
#[derive(Clone, PartialEq, Debug)]
pub enum Reference {
    /// They were given.
    Given,
    /// The exact solution was given.
    Exact,
    /// A run of `method` at `rtol`. One at ten times that differs from it by `spread`, measured like an error:
    /// smaller errors than that mean nothing.
    Run { method: String, rtol: f64, spread: f64 },
}

pub(super) struct Truth {
    pub times: Vec<f64>,
    pub end: Vec<f64>,
    /// At each of the times; empty where nothing is known and no run succeeded.
    pub along: Vec<Vec<f64>>,
    pub reference: Reference,
}

type Exact<'w> = Box<dyn Fn(f64) -> Vec<f64> + 'w>;

pub(super) fn find<Y: State<Scalar = f64>, S: System<Y> + Clone>(
    posed: &Posed<Y, S>,
    scale: f64,
    end: Option<Vec<f64>>,
    exact: Option<Exact>,
) -> Result<Truth, Unfit> {
    let (t0, t1) = (posed.span.start, posed.span.end);
    let n = posed.y0.as_slice().len() + posed.v0.as_ref().map_or(0, |v| v.as_slice().len());
    let fit = |y: &Vec<f64>| match y.len() == n {
        true => Ok(()),
        false => Err(Unfit::Length { given: y.len(), needed: n }),
    };
    end.as_ref().map_or(Ok(()), fit)?;
    let mut times: Vec<f64> = (1..=TIMES).map(|k| t0 + (t1 - t0) * (k as f64 / TIMES as f64)).collect();
    times[TIMES - 1] = t1;
    if let Some(exact) = exact {
        let along: Vec<Vec<f64>> = times.iter().map(|&t| exact(t)).collect();
        along.iter().try_for_each(fit)?;
        let (end, reference) = match end {
            Some(end) => (end, Reference::Given),
            None => (along[TIMES - 1].clone(), Reference::Exact),
        };
        return Ok(Truth { times, end, along, reference });
    }
    let mut rhs = rhs(posed);
    let mut y0 = posed.y0.as_slice().to_vec();
    y0.extend(posed.v0.iter().flat_map(State::as_slice));
    let mut tight = |rtol| tight(&mut rhs, &y0, t0, &times, rtol, rtol * scale);
    match (tight(TIGHT), end) {
        (Ok(along), Some(end)) => Ok(Truth { times, end, along, reference: Reference::Given }),
        (Err(_), Some(end)) => Ok(Truth { times, end, along: vec![], reference: Reference::Given }),
        (Err(why), None) => Err(Unfit::NoReference(why)),
        (Ok(along), None) => {
            let second = tight(SECOND).map_err(Unfit::NoReference)?;
            let end = along[TIMES - 1].clone();
            let spread = distance(&second[TIMES - 1], &end, scale);
            let method = Verner87Efficient.name().to_string();
            Ok(Truth { times, end, along, reference: Reference::Run { method, rtol: TIGHT, spread } })
        }
    }
}

/// Largest |y - reference| / (|reference| + scale) over the components; NaN if one is.
pub(super) fn distance(y: &[f64], reference: &[f64], scale: f64) -> f64 {
    let mut largest = 0.0;
    for (y, r) in y.iter().zip(reference) {
        let d = (y - r).abs() / (r.abs() + scale);
        if !(d <= largest) {
            largest = d;
        }
        if largest.is_nan() {
            break;
        }
    }
    largest
}

/// The states at the times, each at the end of a run from the one before: no interpolant is trusted.
fn tight(
    rhs: &mut Rhs,
    y0: &[f64],
    t0: f64,
    times: &[f64],
    rtol: f64,
    atol: f64,
) -> Result<Vec<Vec<f64>>, String> {
    let start = Instant::now();
    let (mut t, mut y) = (t0, y0.to_vec());
    let mut states = vec![];
    for &end in times {
        let f = |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| rhs(t, y, dy);
        let left = PATIENCE.saturating_sub(start.elapsed());
        let ivp = solve(f, y, t..end).with(Verner87Efficient).rtol(rtol).atol(atol);
        let solution = ivp.observe(in_time(left)).run().map_err(|stopped| stopped.to_string())?;
        if solution.t != end {
            return Err(format!("took longer than {} s", PATIENCE.as_secs()));
        }
        (t, y) = (end, solution.y);
        states.push(y.clone());
    }
    Ok(states)
}

/// A right-hand side whose types are forgotten, so that the tight run is compiled once for all problems.
type Rhs<'f> = dyn FnMut(f64, &[f64], &mut [f64]) -> Result<(), OutOfDomain> + 'f;

/// The right-hand side of a problem; that of x'' = f(t, x) as a system for x and v, one after the other.
fn rhs<Y: State<Scalar = f64>, S: System<Y> + Clone>(
    posed: &Posed<Y, S>,
) -> impl FnMut(f64, &[f64], &mut [f64]) -> Result<(), OutOfDomain> {
    let Posed { mut system, y0: mut y, v0, .. } = posed.clone();
    let mut dy = y.clone();
    move |t, from, to| {
        let n = dy.as_slice().len();
        y.as_mut_slice().copy_from_slice(&from[..n]);
        system.rhs(t, &y, &mut dy)?;
        let (first, last) = to.split_at_mut(if v0.is_some() { n } else { 0 });
        first.copy_from_slice(&from[from.len() - first.len()..]);
        last.copy_from_slice(dy.as_slice());
        Ok(())
    }
}
