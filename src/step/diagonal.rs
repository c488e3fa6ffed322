//! Implicit stages one after the other: Newton's iteration on each.

use super::derivative::subtract;
use super::implicit::{Factors, Solver, finite, stage_time};
use super::measure::weighted_square;
use super::row::{assemble_read, powers};
use super::scalar::{Plain, Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::{Refused, Unsolved};
use super::system::System;
use crate::linear::Square;
use crate::tableau::{Form, Meaning};
use num_traits::{One, Zero};

impl<Y: State> Solver<Y> {
    /// Stage after stage: Y = g + h a f(t, Y) by Newton's iteration on the slope F, so that no residual is
    /// multiplied by the stiffness: (M - h a J) dF = f(t, g + h a F) - M F.
    pub(super) fn diagonal<S: System<Y>>(
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
                    self.effort.evaluations += counted(form.nonstiff[i], system);
                    let base = row.base.unwrap_or(0);
                    let given = match form.nonstiff[i] {
                        true => system.nonstiff(at, &z[base], &mut f[i]),
                        false => system.rhs(at, &z[base], &mut f[i]),
                    };
                    given.map_err(|_| refused(Unsolved::Domain))?;
                    finite(&f[i]).map_err(refused)?;
                }
                continue;
            }
            assemble_read::<Plain, Y>(&mut out[0], row, &powers, x);
            if row.diagonal.hi() == 0.0 {
                self.effort.evaluations += counted(form.nonstiff[i], system);
                let slope = &mut x[form.r + i];
                let given = match form.nonstiff[i] {
                    true => system.nonstiff(at, &out[0], slope),
                    false => system.rhs(at, &out[0], slope),
                };
                given.map_err(|_| refused(Unsolved::Domain))?;
                finite(&x[form.r + i]).map_err(refused)?;
                continue;
            }
            if form.split() {
                self.guess_split(form, i, h, x, &out[0]);
            } else {
                self.guess(form, i, x);
            }
            let factors = self.factored(row.diagonal, powers[form.d]).map_err(refused)?;
            self.iterate(factors, system, at, &mut out[0], &mut x[form.r + i]).map_err(refused)?;
        }
        Ok(())
    }

    /// The slope of the stage before, drawn on; the first stage's is the newest there is.
    fn guess(&self, form: &Form, i: usize, x: &mut [Y]) {
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
        if let Some((before, share)) = trend(form, i)
            && let Ok([to, old]) = x.get_disjoint_mut([form.r + i, before])
        {
            for (to, &old) in to.as_mut_slice().iter_mut().zip(old.as_slice()) {
                *to = *to + (*to - old).scale(RealOf::<Y>::from_f64(share));
            }
        }
    }

    /// Of a pair in two parts: what takes g to y + c h (F + G), F the last slope of the step before and G the other
    /// part's at the start. The slopes of this step will not do: the first is f at the start, where the error that an
    /// iteration left is multiplied by the stiffness, and those after it undo that.
    fn guess_split(&self, form: &Form, i: usize, h: RealOf<Y>, x: &mut [Y], g: &Y) {
        let (r, last) = (form.r, form.r + form.s - 2);
        let c = RealOf::<Y>::of(form.c[i]);
        let per = RealOf::<Y>::one() / (h * RealOf::<Y>::of(form.stage[i].diagonal));
        // In a step too small for that nothing moves.
        let per = if per.finite() { per } else { RealOf::<Y>::zero() };
        for n in 0..g.as_slice().len() {
            let kept = if self.begun { x[last].as_slice()[n] } else { Y::Scalar::zero() };
            let slope = kept + x[r + 1].as_slice()[n];
            let there = x[0].as_slice()[n] - g.as_slice()[n] + slope.scale(c * h);
            x[r + i].as_mut_slice()[n] = there.scale(per);
        }
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
        let mut iteration = self.iteration.doubt(self.here);
        loop {
            self.effort.evaluations += 1;
            self.effort.iterations += 1;
            system.rhs(t, y, &mut self.residual).map_err(|_| Unsolved::Domain)?;
            finite(&self.residual)?;
            subtract(&mut self.residual, self.mass.as_deref(), slope);
            matrix.solve(self.residual.as_mut_slice());
            let mut square = 0.0;
            let unknowns = y.as_mut_slice().iter_mut().zip(slope.as_mut_slice());
            let corrections = self.residual.as_mut_slice().iter_mut().zip(self.weights.as_slice());
            for ((y, f), (d, &w)) in unknowns.zip(corrections) {
                *f = *f + *d;
                let change = d.scale(hg);
                *y = *y + change;
                match const { Y::INLINE } {
                    true => square += (change * w).square().to_f64(),
                    false => *d = change,
                }
            }
            if const { !Y::INLINE } {
                square = weighted_square(&self.residual, &self.weights);
            }
            if let Some(done) = iteration.judge((square / n).sqrt()) {
                self.iteration.learn(&iteration);
                return done;
            }
        }
    }
}

/// Of a system in one part, the other is nothing to evaluate.
fn counted<Y: State, S: System<Y>>(nonstiff: bool, system: &S) -> u64 {
    u64::from(!nonstiff || system.is_split())
}

/// Where the two stages before this one tell how its slope goes on: the earlier one's place, and how far the line
/// through both reaches beyond the later one. No farther than it is long.
fn trend(form: &Form, i: usize) -> Option<(usize, f64)> {
    if form.r > 2 || i < 2 {
        return None;
    }
    let [now, last, before] = [0, 1, 2].map(|back| form.c[i - back].hi());
    let share = (now - last) / (last - before);
    (share.abs() <= 1.0).then_some((form.r + i - 2, share))
}
