//! How implicit stages are solved: Newton's iteration on one stage after the other, or on all of them
//! ([`coupled`](super::coupled)), or one linear equation a stage ([`rosenbrock`](super::rosenbrock)), or that of
//! a multistep formula ([`nordsieck`](super::nordsieck)). Rows are read in a loop: the matrices cost more than that.

use super::coupled::Coupled;
use super::iteration::Iteration;
use super::measure::largest;
use super::nordsieck::Nordsieck;
use super::norm::Tolerance;
use super::rounding::Rounding;
use super::row::{assemble_read, powers};
use super::scalar::{Plain, Real, Scalar};
use super::split::Stiff;
use super::state::{RealOf, State, first_non_finite};
use super::stepper::{Refused, Unsolved, View, is_one};
use super::system::System;
use crate::linear::{ConstantMass, Effort, Groups, Known, Pattern, Square, factor_shifted};
use crate::tableau::{DoubleDouble, Form, Stages};
use num_traits::{One, Zero};
use std::sync::Arc;

/// A Jacobian is taken anew for a step so many times as long as that which it was taken for.
const GROWN: f64 = 5.0;

/// M - h g J, factored, for one of the numbers g on the table's diagonal.
#[derive(Clone)]
pub(super) struct Factors<R, Q> {
    diagonal: DoubleDouble,
    /// h g of the factors; zero where there are none.
    pub(super) hg: R,
    pub(super) matrix: Q,
}

/// The Jacobian of a run, its factors and the state of the iteration.
#[derive(Clone)]
pub(crate) struct Solver<Y: State> {
    pub(super) jacobian: Y::Square,
    /// Columns whose differences are taken together.
    pub(super) groups: Option<Groups>,
    /// M of M y' = f(t, y); `None` for the identity.
    pub(super) mass: Option<Arc<ConstantMass<Y::Scalar>>>,
    /// The Jacobian is that of the start of the step.
    pub(super) here: bool,
    /// There is a Jacobian at all.
    pub(super) known: bool,
    /// The size of the step that it was taken for.
    pub(super) taken: RealOf<Y>,
    /// What its entries miss, relative to the largest.
    pub(super) noise: RealOf<Y>,
    /// A step was accepted: its slopes are there.
    pub(super) begun: bool,
    pub(super) factors: Vec<Factors<RealOf<Y>, Y::Square>>,
    /// f at the start of the step, and `span` df/dt, where a Rosenbrock method took the Jacobian.
    pub(super) slope: Y,
    pub(super) time: Y,
    pub(super) span: RealOf<Y>,
    /// One over the size that matters, component by component.
    pub(super) weights: Y,
    pub(super) residual: Y,
    pub(super) tolerance: Tolerance<RealOf<Y>>,
    pub(super) adaptive: bool,
    pub(super) iteration: Iteration,
    pub(super) coupled: Option<Coupled<Y>>,
    /// The slope at the start of the step is there.
    pub(super) sloped: bool,
    /// The size of the last attempt, if it was accepted.
    accepted: Option<RealOf<Y>>,
    pub(super) tried: RealOf<Y>,
    /// The history of a family of multistep formulas.
    pub(super) nordsieck: Option<Box<Nordsieck<Y>>>,
    /// What the rounding of J has made of y, where no iteration mends it and an error is judged.
    pub(super) rounding: Option<Rounding<Y>>,
    pub effort: Effort,
}

impl<Y: State> Solver<Y> {
    /// Room for the matrices. Without an error test (`adaptive` false) stages are solved to rounding.
    pub fn new(
        form: &Form,
        y: &Y,
        known: &Known<Y::Scalar>,
        tolerance: &Tolerance<RealOf<Y>>,
        adaptive: bool,
    ) -> Self {
        let n = y.as_slice().len();
        // A family that is not damped needs none.
        let matrix = match form.orders > 0 && !form.damped {
            true => Y::Square::new(&Arc::new(Pattern::dense(0))),
            false => Y::Square::new(&known.pattern),
        };
        let mut factors: Vec<Factors<_, _>> = vec![];
        for row in &form.stage[..form.s] {
            let new = |f: &Factors<_, _>| f.diagonal.hi() != row.diagonal.hi();
            if row.diagonal.hi() != 0.0 && factors.iter().all(new) {
                let (diagonal, hg) = (row.diagonal, RealOf::<Y>::zero());
                factors.push(Factors { diagonal, hg, matrix: matrix.clone() });
            }
        }
        let epsilon = RealOf::<Y>::EPSILON.to_f64();
        let (tolerance, enough, rounding) = if adaptive {
            let rtol =
                (0..n).map(|i| tolerance.at(i).0.to_f64()).fold(f64::MAX, |a, b| if b < a { b } else { a });
            // The iteration errs less than the step (Hairer, Wanner 1996, IV.8). Stages found together share the
            // error of all, and one that is left in them spoils the steps that the estimate allows at small tolerances.
            // Where nothing is asked for relative to y, its largest number serves.
            let spacing = if rtol > 0.0 { epsilon / rtol } else { 0.0 };
            let together = matches!(form.stages(), Stages::Full) && rtol > 0.0;
            let enough = if together { rtol.sqrt().min(0.03) } else { 0.03 };
            (tolerance.clone(), enough.max(10.0 * spacing).min(0.1), 100.0 * spacing)
        } else {
            let least = RealOf::<Y>::from_f64(4.0 * epsilon);
            (Tolerance::Scalar { rtol: least, atol: least }, 1.0, 1e3)
        };
        Self {
            jacobian: matrix,
            groups: known.groups.clone(),
            mass: known.mass.clone(),
            here: false,
            known: false,
            taken: RealOf::<Y>::zero(),
            noise: RealOf::<Y>::EPSILON,
            begun: false,
            factors,
            slope: y.clone(),
            time: y.clone(),
            span: RealOf::<Y>::one(),
            weights: y.clone(),
            residual: y.clone(),
            tolerance,
            adaptive,
            iteration: Iteration::new(enough, rounding, adaptive),
            coupled: matches!(form.stages(), Stages::Full).then(|| Coupled::new(form, y, known)).flatten(),
            sloped: false,
            accepted: None,
            tried: RealOf::<Y>::zero(),
            nordsieck: (form.orders > 0).then(|| Box::new(Nordsieck::new(y, rounding))),
            rounding: (adaptive && form.linear).then(|| Rounding::new(y)),
            effort: Effort::default(),
        }
    }

    /// The step was accepted: the Jacobian is one of the past.
    pub fn moved(&mut self) {
        (self.here, self.sloped, self.begun) = (false, false, true);
        self.accepted = Some(self.tried);
        if let Some(family) = &mut self.nordsieck {
            family.moved(self.tried);
        }
        if let Some(rounding) = &mut self.rounding {
            rounding.moved();
        }
    }

    /// What belongs to the start of a step belongs to another one.
    pub(super) fn restart(&mut self) {
        (self.here, self.sloped) = (false, false);
    }

    /// The stages and the carried vectors of a step, as in an explicit attempt.
    pub fn attempt<S: System<Y>>(
        &mut self,
        form: &Form,
        words: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        known: bool,
    ) -> Result<(), Refused> {
        let powers = powers(h);
        let (x, out) = words.split_at_mut(form.r + form.s);
        let moves =
            if self.adaptive { RealOf::<Y>::zero() } else { self.moves(form, x, system, t, powers[form.d])? };
        self.weigh(&x[0], moves);
        if form.orders > 0 {
            return self.nordsieck(form, x, out, system, (t, end), h);
        }
        match form.stages() {
            Stages::Linear => self.linear(form, x, out, system, (t, end), h)?,
            stages => {
                let serves = self.here || self.iteration.quick() && self.lasts(h);
                if !(self.known && serves) {
                    self.renew(form, system, t, h, &x[0])?;
                }
                if let Some(coupled) = &mut self.coupled
                    && let Some(h) = self.accepted.take()
                {
                    coupled.keep(&x[form.r..], h);
                }
                self.tried = h;
                loop {
                    let solved = match stages {
                        Stages::Full => self.all(form, x, out, system, (t, end), h),
                        _ if form.split() => {
                            self.diagonal(form, x, out, &mut Stiff(system), (t, end), h, known)
                        }
                        _ => self.diagonal(form, x, out, system, (t, end), h, known),
                    };
                    let Err(refused) = solved else { break };
                    // A new Jacobian before a smaller step.
                    if self.here || !matches!(refused.why, Unsolved::Diverged | Unsolved::Outgrown) {
                        return Err(refused);
                    }
                    self.renew(form, system, t, h, &x[0])?;
                }
            }
        }
        for (j, row) in form.carry[..form.r].iter().enumerate() {
            if !row.copies() && !row.last_y {
                assemble_read::<Plain, Y>(&mut out[1 + j], row, &powers, x);
            }
        }
        if form.linear {
            let end = if form.carry[0].last_y { &out[0] } else { &out[1] };
            let (z, slopes) = x.split_at(form.r);
            self.round(form, h, (&z[0], end), slopes).map_err(|why| Refused { stage: form.s - 1, why })?;
        }
        Ok(())
    }

    /// The Jacobian may still serve a step of that size, if it did up to now. One that was taken in a fast motion hides
    /// in the slow one after it what is left of an iteration: it is a thousand times larger, and all corrections are as
    /// small.
    fn lasts(&self, h: RealOf<Y>) -> bool {
        h.modulus() <= (self.taken * RealOf::<Y>::from_f64(GROWN)).modulus()
    }

    /// Takes the Jacobian of what the stages solve for.
    fn renew<S: System<Y>>(
        &mut self,
        form: &Form,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        y: &Y,
    ) -> Result<(), Refused> {
        let taken =
            if form.split() { self.take(&mut Stiff(system), t, h, y) } else { self.take(system, t, h, y) };
        taken.map_err(|why| Refused { stage: 0, why })
    }

    /// Factors of M - h g J for the diagonal g, made where they are not there.
    pub(super) fn factored(&mut self, diagonal: DoubleDouble, h: RealOf<Y>) -> Result<usize, Unsolved> {
        let hg = h * RealOf::<Y>::of(diagonal);
        let at = self.factors.iter().position(|f| f.diagonal.hi() == diagonal.hi()).unwrap_or(0);
        if self.factors[at].hg != hg {
            self.refactor(at, hg)?;
        }
        Ok(at)
    }

    /// Makes factors of M - hg J.
    pub(super) fn refactor(&mut self, at: usize, hg: RealOf<Y>) -> Result<(), Unsolved> {
        let factors = &mut self.factors[at];
        self.effort.factorizations += 1;
        factors.hg = RealOf::<Y>::zero();
        factor_shifted(&mut factors.matrix, &self.jacobian, self.mass.as_deref(), |m| m, |j| j.scale(-hg))
            .map_err(|component| Unsolved::Singular { component })?;
        if factors.matrix.negative() && self.outgrown(hg) {
            return Err(Unsolved::Outgrown);
        }
        self.factors[at].hg = hg;
        Ok(())
    }

    /// A determinant of I - hg J below 0 means that an eigenvalue of J is real and larger than 1/(hg): what grows like
    /// that would be damped, and the solution left for one that is not there. Steps that are chosen avoid it, unless
    /// the sign may be that of what the entries of J miss.
    fn outgrown(&self, hg: RealOf<Y>) -> bool {
        let steepest = largest(self.jacobian.entries().iter().map(|x| x.modulus()));
        let missed = (hg * steepest).modulus() * self.noise;
        self.adaptive && self.mass.is_none() && missed * RealOf::<Y>::from_f64(1e2) < RealOf::<Y>::one()
    }

    /// f at the start of the step.
    pub(super) fn slope<S: System<Y>>(
        &mut self,
        system: &mut S,
        t: RealOf<Y>,
        y: &Y,
    ) -> Result<(), Unsolved> {
        if !self.sloped {
            self.effort.evaluations += 1;
            system.rhs(t, y, &mut self.slope).map_err(|_| Unsolved::Domain)?;
            finite(&self.slope)?;
            self.sloped = true;
        }
        Ok(())
    }

    /// The error of the step just attempted, for a table whose estimate is made, not given.
    pub fn error_square(&mut self, view: View<Y>, tolerance: &Tolerance<RealOf<Y>>) -> Option<RealOf<Y>> {
        if view.form.orders > 0 {
            return self.nordsieck_error(view, tolerance);
        }
        let h = self.tried;
        let slopes = &view.read()[view.form.r..];
        let error = self.coupled.as_mut()?.error(h, &self.slope, slopes, self.mass.as_deref())?;
        let one = RealOf::<Y>::one();
        let share = one / RealOf::<Y>::from_f64(error.as_slice().len().max(1) as f64);
        let square = view.next(0).error_square::<Plain, 1>(view.y(), tolerance, one, |_| one, |_| error);
        Some(square * share)
    }

    /// All stages together.
    fn all<S: System<Y>>(
        &mut self,
        form: &Form,
        x: &mut [Y],
        out: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
    ) -> Result<(), Refused> {
        let refused = |why| Refused { stage: 0, why };
        let (z, slopes) = x.split_at_mut(form.r);
        self.slope(system, t, &z[0]).map_err(refused)?;
        let Some(coupled) = &mut self.coupled else { return Err(refused(Unsolved::Diverged)) };
        let negative =
            coupled.factor(&self.jacobian, self.mass.as_deref(), h, &mut self.effort).map_err(refused)?;
        if negative && self.outgrown(h) {
            return Err(refused(Unsolved::Outgrown));
        }
        let Some(coupled) = &mut self.coupled else { return Err(refused(Unsolved::Diverged)) };
        let solved = coupled.solve(
            system,
            self.mass.as_deref(),
            (t, end),
            h,
            &z[0],
            slopes,
            &mut out[0],
            &self.weights,
            self.iteration.doubt(self.here),
            &mut self.effort,
        );
        self.iteration.learn(&solved.map_err(refused)?);
        Ok(())
    }
}

/// What f gave is a number.
#[inline(always)]
pub(super) fn finite<Y: State>(slope: &Y) -> Result<(), Unsolved> {
    first_non_finite(slope).map_or(Ok(()), |component| Err(Unsolved::NonFinite { component }))
}

pub(super) fn stage_time<R: Real>(c: DoubleDouble, t: R, end: R, h: R) -> R {
    if is_one(c) { end } else { t + R::of(c) * h }
}
