//! How implicit stages are solved: Newton's iteration on one stage after the other, or on all of them
//! ([`coupled`](super::coupled)), or one linear equation a stage ([`rosenbrock`](super::rosenbrock)). Rows are
//! read in a loop: the matrices cost more than that.

use super::coupled::Coupled;
use super::derivative::subtract;
use super::iteration::Iteration;
use super::norm::Tolerance;
use super::row::{assemble_read, powers};
use super::scalar::{Plain, Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::{Refused, Unsolved, View, is_one};
use super::system::System;
use crate::linear::{ConstantMass, Effort, Groups, Known, Square, factor_shifted};
use crate::tableau::{DoubleDouble, Form, Meaning, Stages};
use num_traits::{One, Zero};
use std::sync::Arc;

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
    /// A step was accepted: its slopes are there.
    begun: bool,
    pub(super) factors: Vec<Factors<RealOf<Y>, Y::Square>>,
    /// f at the start of the step, and `span` df/dt, where a Rosenbrock method took the Jacobian.
    pub(super) slope: Y,
    pub(super) time: Y,
    pub(super) span: RealOf<Y>,
    /// One over the size that matters, component by component.
    pub(super) weights: Y,
    pub(super) residual: Y,
    tolerance: Tolerance<RealOf<Y>>,
    adaptive: bool,
    pub(super) iteration: Iteration,
    pub(super) coupled: Option<Coupled<Y>>,
    /// The slope at the start of the step is there.
    sloped: bool,
    /// The size of the last attempt, if it was accepted.
    accepted: Option<RealOf<Y>>,
    tried: RealOf<Y>,
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
        let matrix = Y::Square::new(&known.pattern);
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
            // Hairer and Wanner's stopping rule (1996, IV.8): the iteration errs less than the step. Where nothing
            // is asked for relative to y, its largest number serves.
            let spacing = if rtol > 0.0 { epsilon / rtol } else { 0.0 };
            let enough = if rtol > 0.0 { rtol.sqrt().min(0.03) } else { 0.03 };
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
            effort: Effort::default(),
        }
    }

    /// The step was accepted: the Jacobian is one of the past.
    pub fn moved(&mut self) {
        (self.here, self.sloped, self.begun) = (false, false, true);
        self.accepted = Some(self.tried);
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
        self.weigh(&x[0]);
        match form.stages() {
            Stages::Linear => self.linear(form, x, out, system, (t, end), h)?,
            stages => {
                // A Jacobian that served well serves on.
                if !self.known || !self.here && !self.iteration.quick() {
                    self.take(system, t, h, &x[0]).map_err(|why| Refused { stage: 0, why })?;
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
                        _ => self.diagonal(form, x, out, system, (t, end), h, known),
                    };
                    let Err(refused) = solved else { break };
                    // A new Jacobian before a smaller step.
                    if self.here || refused.why != Unsolved::Diverged {
                        return Err(refused);
                    }
                    self.take(system, t, h, &x[0]).map_err(|why| Refused { stage: 0, why })?;
                }
            }
        }
        for (j, row) in form.carry[..form.r].iter().enumerate() {
            if !row.copies() && !row.last_y {
                assemble_read::<Plain, Y>(&mut out[1 + j], row, &powers, x);
            }
        }
        Ok(())
    }

    pub(super) fn weigh(&mut self, y: &Y) {
        let least = RealOf::<Y>::TINY;
        let mut largest = RealOf::<Y>::zero();
        for y in y.as_slice() {
            largest = largest.maximum(y.modulus());
        }
        for (i, (w, y)) in self.weights.as_mut_slice().iter_mut().zip(y.as_slice()).enumerate() {
            let (rtol, atol) = self.tolerance.at(i);
            // Without a tolerance, rounding is measured against the whole vector.
            let size = if self.adaptive { atol + rtol * y.modulus() } else { rtol * largest };
            let size = size.maximum(RealOf::<Y>::EPSILON * RealOf::<Y>::EPSILON * largest).maximum(least);
            *w = Y::Scalar::one().scale(RealOf::<Y>::one() / size);
        }
    }

    /// Factors of M - h g J for the diagonal g, made where they are not there.
    pub(super) fn factored(&mut self, diagonal: DoubleDouble, h: RealOf<Y>) -> Result<usize, Unsolved> {
        let hg = h * RealOf::<Y>::of(diagonal);
        let at = self.factors.iter().position(|f| f.diagonal.hi() == diagonal.hi()).unwrap_or(0);
        let factors = &mut self.factors[at];
        if factors.hg != hg {
            self.effort.factorizations += 1;
            factors.hg = RealOf::<Y>::zero();
            factor_shifted(
                &mut factors.matrix,
                &self.jacobian,
                self.mass.as_deref(),
                |m| m,
                |j| j.scale(-hg),
            )
            .map_err(|component| Unsolved::Singular { component })?;
            factors.hg = hg;
        }
        Ok(at)
    }

    /// Stage after stage: Y = g + h a f(t, Y) by Newton's iteration on the slope F, so that no residual is
    /// multiplied by the stiffness: (M - h a J) dF = f(t, g + h a F) - M F.
    fn diagonal<S: System<Y>>(
        &mut self,
        form: &Form,
        x: &mut [Y],
        out: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        known: bool,
    ) -> Result<(), Refused> {
        let powers = powers(h);
        for (i, row) in form.stage[..form.s].iter().enumerate() {
            let refused = |why| Refused { stage: i, why };
            let at = stage_time(form.c[i], t, end, h);
            if row.copies() {
                if !(known && i == 0) {
                    let (z, f) = x.split_at_mut(form.r);
                    self.effort.evaluations += 1;
                    let base = row.base.unwrap_or(0);
                    system.rhs(at, &z[base], &mut f[i]).map_err(|_| refused(Unsolved::Domain))?;
                }
                continue;
            }
            assemble_read::<Plain, Y>(&mut out[0], row, &powers, x);
            if row.diagonal.hi() == 0.0 {
                self.effort.evaluations += 1;
                system.rhs(at, &out[0], &mut x[form.r + i]).map_err(|_| refused(Unsolved::Domain))?;
                continue;
            }
            // The first guess is the slope of the stage before; the first stage's is the newest there is.
            let from = match i {
                0 => (0..form.r).find(|&j| form.means[j] == Meaning::F(0)).unwrap_or(form.r + form.s - 1),
                i => form.r + i - 1,
            };
            if i == 0 && from >= form.r && !self.begun {
                // A slope far from where the solution wants to be would be larger than all that follows.
                x[form.r].as_mut_slice().fill(Y::Scalar::zero());
            } else if let Ok([to, from]) = x.get_disjoint_mut([form.r + i, from]) {
                to.as_mut_slice().copy_from_slice(from.as_slice());
            }
            let factors = self.factored(row.diagonal, powers[form.d]).map_err(refused)?;
            self.iterate(factors, system, at, &mut out[0], &mut x[form.r + i]).map_err(refused)?;
        }
        Ok(())
    }

    /// `y` comes in as g and leaves as Y, `slope` comes in as a guess of F.
    fn iterate<S: System<Y>>(
        &mut self,
        factors: usize,
        system: &mut S,
        t: RealOf<Y>,
        y: &mut Y,
        slope: &mut Y,
    ) -> Result<(), Unsolved> {
        let Factors { hg, matrix, .. } = &mut self.factors[factors];
        let (hg, n) = (*hg, slope.as_slice().len() as f64);
        for (y, f) in y.as_mut_slice().iter_mut().zip(slope.as_slice()) {
            *y = *y + f.scale(hg);
        }
        let mut iteration = self.iteration;
        loop {
            self.effort.evaluations += 1;
            self.effort.iterations += 1;
            system.rhs(t, y, &mut self.residual).map_err(|_| Unsolved::Domain)?;
            finite(&self.residual)?;
            subtract(&mut self.residual, self.mass.as_deref(), slope);
            matrix.solve(self.residual.as_mut_slice());
            let mut square = 0.0;
            let corrections = self.residual.as_slice().iter().zip(self.weights.as_slice());
            let unknowns = y.as_mut_slice().iter_mut().zip(slope.as_mut_slice());
            for ((y, f), (&d, &w)) in unknowns.zip(corrections) {
                *f = *f + d;
                let change = d.scale(hg);
                *y = *y + change;
                square += (change * w).square().to_f64();
            }
            if let Some(done) = iteration.judge((square / n).sqrt()) {
                self.iteration.learn(&iteration);
                return done;
            }
        }
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
        let solved = coupled.solve(
            system,
            (&self.jacobian, self.mass.as_deref()),
            (t, end),
            h,
            &z[0],
            slopes,
            &mut out[0],
            &self.weights,
            self.iteration,
            &mut self.effort,
        );
        self.iteration.learn(&solved.map_err(refused)?);
        Ok(())
    }
}

/// What f gave is a number.
pub(super) fn finite<Y: State>(slope: &Y) -> Result<(), Unsolved> {
    match slope.as_slice().iter().position(|x| !x.finite()) {
        Some(component) => Err(Unsolved::NonFinite { component }),
        None => Ok(()),
    }
}

pub(super) fn stage_time<R: Real>(c: DoubleDouble, t: R, end: R, h: R) -> R {
    if is_one(c) { end } else { t + R::of(c) * h }
}

/// `out += a x`.
#[inline(always)]
pub(super) fn add<Y: State>(out: &mut Y, a: RealOf<Y>, x: &Y) {
    for (out, &x) in out.as_mut_slice().iter_mut().zip(x.as_slice()) {
        *out = *out + x.scale(a);
    }
}
