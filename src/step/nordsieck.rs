//! A step of a family of multistep formulas in Nordsieck form.
//!
//! z = (y, h y', h^2 y''/2, ..) is moved on by Pascal's triangle and corrected by e l, where e solves
//! `h f(t, z_0 + l_0 e) = M (z_1 + e)` (Gear 1971, ch. 9; Brown, Byrne, Hindmarsh 1989, SIAM J. Sci. Stat. Comput. 10).

use super::implicit::{Solver, finite};
use super::iteration::Corrections;
use super::measure::weighted_square;
use super::order::{CAREFUL, FIRST_GROWTH, estimates};
use super::pascal::pascal;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::{Refused, Unsolved};
use super::system::System;
use crate::linear::Square;
use crate::tableau::{CARRIED, Form};
use num_traits::{One, Zero};

/// Accepted steps after which factors are made anew, and a Jacobian is taken anew.
const AGES: [u32; 2] = [20, 50];
/// h l_0 may differ by this share from the one that was factored.
const NEAR: f64 = 0.2;

/// The order and the memory of a run in Nordsieck form.
#[derive(Clone)]
pub(crate) struct Nordsieck<Y: State> {
    pub(super) order: usize,
    /// The step that z is scaled with.
    pub(super) h: RealOf<Y>,
    /// z_1 is to be made of the slope: before the first step, and where the history is given up.
    pub(super) start: Start,
    /// Vectors of z and z' above this one are zero.
    top: usize,
    /// Steps until order and step may change.
    pub(super) wait: usize,
    /// The correction of the step before.
    pub(super) last: Y,
    pub(super) grow: f64,
    pub(super) failures: u32,
    corrections: Corrections,
    /// Steps since the matrix was factored, and since the Jacobian was taken.
    ages: [u32; 2],
    /// An eigenvalue, real part and modulus of the imaginary one, whose part of the error grew.
    pub(super) threat: Option<(f64, f64)>,
    /// The last error, over its tolerance.
    pub(super) error: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Start {
    /// From the slope that stands in the place of the correction.
    Given,
    /// From a slope still to be evaluated.
    Anew,
    Done,
}

impl<Y: State> Nordsieck<Y> {
    pub fn new(y: &Y, rounding: f64) -> Self {
        Self {
            order: 1,
            h: RealOf::<Y>::one(),
            start: Start::Given,
            top: 0,
            wait: 2,
            last: y.clone(),
            grow: FIRST_GROWTH,
            failures: 0,
            corrections: Corrections::new(rounding),
            ages: [0; 2],
            threat: None,
            error: 0.0,
        }
    }

    /// The step was accepted: z is z'.
    pub fn moved(&mut self, h: RealOf<Y>) {
        self.h = h;
        self.failures = 0;
        self.ages[0] += 1;
        self.ages[1] += 1;
    }

    /// Goes on with another order.
    pub(super) fn set_order(&mut self, order: usize, z: &mut [Y]) {
        self.order = order;
        for z in &mut z[order + 1..] {
            z.as_mut_slice().fill(Y::Scalar::zero());
        }
    }

    /// z' = P z, scaled from the step of z to `h`.
    fn predict(&mut self, z: &[Y], next: &mut [Y], h: RealOf<Y>) {
        let q = self.order;
        let mut powers = [RealOf::<Y>::one(); CARRIED];
        for k in 1..=q {
            powers[k] = powers[k - 1] * (h / self.h);
        }
        pascal(q, &powers, z, next);
        for next in &mut next[q + 1..=self.top.max(q)] {
            next.as_mut_slice().fill(Y::Scalar::zero());
        }
        self.top = q;
    }
}

impl<Y: State> Solver<Y> {
    /// The step, as [`attempt`](Self::attempt): z' from z, the correction in place of the slope.
    pub(super) fn nordsieck<S: System<Y>>(
        &mut self,
        form: &Form,
        x: &mut [Y],
        out: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
    ) -> Result<(), Refused> {
        let refused = |why| Refused { stage: 0, why };
        let Some(mut family) = self.nordsieck.take() else { return Err(refused(Unsolved::Diverged)) };
        let solved = self.correct(&mut family, form, x, out, system, (t, end), h);
        if solved.is_err() {
            (family.grow, family.wait) = (CAREFUL, family.order + 1);
        }
        self.nordsieck = Some(family);
        solved.map_err(refused)
    }

    #[allow(clippy::too_many_arguments)] // a step, and the memory of the run beside its solver
    fn correct<S: System<Y>>(
        &mut self,
        family: &mut Nordsieck<Y>,
        form: &Form,
        x: &mut [Y],
        out: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
    ) -> Result<(), Unsolved> {
        self.tried = h;
        let (z, rest) = x.split_at_mut(form.r);
        let e = &mut rest[0];
        if family.start != Start::Done {
            // With a mass matrix f is no slope: that of the last step has to do.
            let kept = family.start == Start::Anew && self.mass.is_some();
            if family.start == Start::Anew && !kept {
                self.slope(system, t, &z[0])?;
                e.as_mut_slice().copy_from_slice(self.slope.as_slice());
            } else if kept {
                let per = RealOf::<Y>::one() / family.h;
                e.as_mut_slice().iter_mut().zip(z[1].as_slice()).for_each(|(e, z)| *e = z.scale(per));
            }
            family.set_order(1, z);
            for (z, &slope) in z[1].as_mut_slice().iter_mut().zip(e.as_slice()) {
                *z = slope.scale(h);
            }
            // Whatever stood in z' is none of its past.
            (family.start, family.h, family.top) = (Start::Done, h, form.orders);
        }
        if family.h != h {
            family.wait = family.order + 1;
            family.corrections.forget();
        }
        let (y, next) = out.split_at_mut(1);
        let y = &mut y[0];
        family.predict(z, next, h);
        let q = family.order;
        self.effort.order = self.effort.order.max(q);
        let corrector = &form.correctors[q - 1];
        let hg = h * RealOf::<Y>::of(corrector.l[0]);
        let unit = estimates(form, q)[1];
        let mut anew = false;
        loop {
            y.as_mut_slice().copy_from_slice(next[0].as_slice());
            if !anew {
                self.effort.evaluations += 1;
                system.rhs(end, y, &mut self.residual).map_err(|_| Unsolved::Domain)?;
                finite(&self.residual)?;
            }
            if form.damped {
                self.matrix(family, system, end, h, y, hg, anew)?;
            }
            match self.iterate_on(family, form, system, end, h, (&next[0], &next[1]), y, e, unit) {
                Ok(()) => break,
                // A new Jacobian before a smaller step.
                Err(Unsolved::Diverged) if form.damped && !self.here => {
                    self.effort.evaluations += 1;
                    system.rhs(end, &next[0], &mut self.residual).map_err(|_| Unsolved::Domain)?;
                    finite(&self.residual)?;
                    anew = true;
                }
                Err(why) => return Err(why),
            }
        }
        for (k, next) in next[..=q].iter_mut().enumerate() {
            let l = RealOf::<Y>::of(corrector.l[k]);
            for (next, &e) in next.as_mut_slice().iter_mut().zip(e.as_slice()) {
                *next = *next + e.scale(l);
            }
        }
        Ok(())
    }

    /// Factors of M - h l_0 J that serve this step. The residual holds f at `y`, the prediction, and does so
    /// afterwards.
    #[allow(clippy::too_many_arguments)] // a step, and the memory of the run beside its solver
    fn matrix<S: System<Y>>(
        &mut self,
        family: &mut Nordsieck<Y>,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        y: &Y,
        hg: RealOf<Y>,
        anew: bool,
    ) -> Result<(), Unsolved> {
        if anew || !self.known || family.ages[1] >= AGES[1] {
            self.slope.as_mut_slice().copy_from_slice(self.residual.as_slice());
            self.sloped = true;
            let taken = self.take(system, t, h, y);
            self.residual.as_mut_slice().copy_from_slice(self.slope.as_slice());
            self.sloped = false;
            taken?;
            (family.ages, family.threat) = ([0; 2], None);
        }
        let made = self.factors[0].hg;
        let near = !made.is_zero() && (hg / made - RealOf::<Y>::one()).modulus().to_f64() <= NEAR;
        if !near || family.ages[0] >= AGES[0] {
            match self.refactor(0, hg) {
                // Of an old Jacobian it says nothing.
                Err(Unsolved::Outgrown) if !self.here => {
                    return self.matrix(family, system, t, h, y, hg, true);
                }
                made => made?,
            }
            family.ages[0] = 0;
            family.corrections.forget();
        }
        Ok(())
    }

    /// Finds e with h f(t, y_0 + l_0 e) = M (z_1 + e): by Newton's iteration where the family is damped, else by the
    /// equation itself. The residual holds f at the prediction.
    #[allow(clippy::too_many_arguments)] // a step, and the memory of the run beside its solver
    fn iterate_on<S: System<Y>>(
        &mut self,
        family: &mut Nordsieck<Y>,
        form: &Form,
        system: &mut S,
        t: RealOf<Y>,
        h: RealOf<Y>,
        (predicted, slope): (&Y, &Y),
        y: &mut Y,
        e: &mut Y,
        unit: f64,
    ) -> Result<(), Unsolved> {
        let q = family.order;
        let l0 = RealOf::<Y>::of(form.correctors[q - 1].l[0]);
        e.as_mut_slice().fill(Y::Scalar::zero());
        // A matrix of another h l_0 takes too much or too little (Hindmarsh 1983).
        let two = RealOf::<Y>::from_f64(2.0);
        let share = match self.factors.first() {
            Some(made) if form.damped => two / (RealOf::<Y>::one() + h * l0 / made.hg),
            _ => RealOf::<Y>::one(),
        };
        family.corrections.begin();
        loop {
            self.effort.iterations += 1;
            let scaled =
                self.residual.as_mut_slice().iter_mut().zip(slope.as_slice().iter().zip(e.as_slice()));
            match &self.mass {
                None => scaled.for_each(|(r, (&z1, &e))| *r = r.scale(h) - (z1 + e)),
                Some(mass) => {
                    let slope = self.time.as_mut_slice();
                    for ((r, (&z1, &e)), slope) in scaled.zip(slope) {
                        (*r, *slope) = (r.scale(h), z1 + e);
                    }
                    mass.add_product(self.residual.as_mut_slice(), -RealOf::<Y>::one(), self.time.as_slice());
                }
            }
            if form.damped {
                self.factors[0].matrix.solve(self.residual.as_mut_slice());
            }
            let mut square = 0.0;
            let parts = e.as_mut_slice().iter_mut().zip(y.as_mut_slice()).zip(predicted.as_slice());
            let corrections = self.residual.as_mut_slice().iter_mut().zip(self.weights.as_slice());
            for (((e, y), &p), (d, &w)) in parts.zip(corrections) {
                *d = d.scale(share);
                *e = *e + *d;
                *y = p + e.scale(l0);
                if const { Y::INLINE } {
                    square += (*d * w).square().to_f64();
                }
            }
            if const { !Y::INLINE } {
                square = weighted_square(&self.residual, &self.weights);
            }
            let size = (square / self.residual.as_slice().len().max(1) as f64).sqrt();
            if let Some(done) = family.corrections.judge(size * unit, 0.5 / (q as f64 + 2.0)) {
                return done;
            }
            self.effort.evaluations += 1;
            system.rhs(t, y, &mut self.residual).map_err(|_| Unsolved::Domain)?;
            finite(&self.residual)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Known;
    use crate::methods::{Adams, Bdf};
    use crate::step::method::Method;
    use crate::step::norm::Tolerance;
    use crate::tableau::DoubleDouble as D;

    fn n(x: f64) -> D {
        D::of(x)
    }

    /// y = 1/(1 + t), to which a damped family is pulled.
    fn exact(t: D) -> D {
        n(1.0) / (n(1.0) + t)
    }

    /// So many steps of size h with one member, from the exact history: t, y and h f after each.
    fn steps(form: &Form, q: usize, h: D, count: usize) -> Vec<(D, D, D)> {
        let pull = if form.damped { n(-1.0) } else { D::ZERO };
        let f = |t: D, y: D| pull * (y - exact(t)) - exact(t) * exact(t);
        let mut system = |t: D, y: &[D; 1], dy: &mut [D; 1]| dy[0] = f(t, y[0]);
        // Every first correction is good enough: the equation is linear, and without a pull it has no y.
        let tolerance = Tolerance::Scalar { rtol: n(1.0), atol: n(1.0) };
        let mut solver = Solver::new(form, &[exact(D::ZERO)], &Known::new(1, None, None), &tolerance, true);
        let mut words = vec![[D::ZERO; 1]; form.words()];
        let family = solver.nordsieck.as_mut().unwrap();
        (family.order, family.start, family.h, family.top) = (q, Start::Done, h, form.orders);
        for (k, z) in words[..=q].iter_mut().enumerate() {
            z[0] = (-h).powi(k as u32);
        }
        let mut seen = vec![];
        for i in 0..count {
            let (t, end) = (h * n(i as f64), h * n(i as f64 + 1.0));
            solver.attempt(form, &mut words, &mut system, (t, end), h, false).unwrap();
            let (z, next) = words.split_at_mut(form.r + 2);
            z[..form.r].copy_from_slice(&next[..form.r]);
            solver.moved();
            let y = words[0][0];
            seen.push((end, y, h * f(end, y)));
        }
        seen
    }

    #[test]
    fn steps_of_one_size_are_those_of_the_formula() {
        for (form, orders) in [(Bdf.form(), 5), (Adams.form(), 12)] {
            for q in 1..=orders {
                let seen = steps(form, q, n(1.0 / 32.0), 40);
                let corrector = &form.correctors[q - 1];
                for window in seen.windows(corrector.k + 1) {
                    let mut off = D::ZERO;
                    for (j, &(_, y, f)) in window.iter().enumerate() {
                        off += n(corrector.alpha[j]) * y - n(corrector.beta[j]) * f;
                    }
                    // The formula's coefficients are f64 here.
                    assert!(off.abs().hi() < 1e-14, "order {q}: off by {:e}", off.hi());
                }
            }
        }
    }

    #[test]
    fn every_member_has_its_order() {
        for (form, orders) in [(Bdf.form(), 5), (Adams.form(), 12)] {
            for q in 1..=orders {
                let error = |per: usize| {
                    let last = *steps(form, q, n(1.0 / per as f64), 2 * per).last().unwrap();
                    (last.1 - exact(last.0)).abs().hi()
                };
                let (coarse, fine) = (error(128), error(256));
                let found = (coarse / fine).log2();
                assert!((found - q as f64).abs() < 0.2, "{found}, not {q}: {coarse:e} {fine:e}");
            }
        }
    }
}
