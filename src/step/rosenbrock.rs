//! Rosenbrock stages: one linear equation each, with the Jacobian of the step (Hairer, Wanner 1996, IV.7).

use super::implicit::{Solver, finite, stage_time};
use super::row::{assemble_read, powers};
use super::scalar::{Plain, Real, Scalar};
use super::state::{RealOf, State, add};
use super::stepper::{Refused, Unsolved};
use super::system::System;
use crate::linear::{Square, time_derivative};
use crate::tableau::Form;

impl<Y: State> Solver<Y> {
    /// Stage after stage, in the variables of the lowered table.
    pub(super) fn linear<S: System<Y>>(
        &mut self,
        form: &Form,
        x: &mut [Y],
        out: &mut [Y],
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
    ) -> Result<(), Refused> {
        let powers = powers(h);
        if !self.here {
            self.begin_linear(system, (t, end), &x[0]).map_err(|why| Refused { stage: 0, why })?;
        }
        for (i, row) in form.stage[..form.s].iter().enumerate() {
            let refused = |why| Refused { stage: i, why };
            let factors = self.factored(row.diagonal, h).map_err(refused)?;
            let (before, own) = x.split_at_mut(form.r + i);
            let own = &mut own[0];
            if row.len == 0 {
                own.as_mut_slice().copy_from_slice(self.slope.as_slice());
            } else {
                assemble_read::<Plain, Y>(&mut out[0], row, &powers, before);
                self.effort.evaluations += 1;
                let at = stage_time(form.c[i], t, end, h);
                system.rhs(at, &out[0], own).map_err(|_| refused(Unsolved::Domain))?;
                finite(own).map_err(refused)?;
            }
            for j in 0..i {
                let couple = form.couple[i][j];
                if couple.hi() != 0.0 {
                    let (couple, f) = (RealOf::<Y>::of(couple), &before[form.r + j]);
                    match &self.mass {
                        None => add(own, couple, f),
                        Some(mass) => mass.add_product(own.as_mut_slice(), couple, f.as_slice()),
                    }
                }
            }
            if form.time[i].hi() != 0.0 {
                add(own, h / self.span * RealOf::<Y>::of(form.time[i]), &self.time);
            }
            let g = RealOf::<Y>::of(row.diagonal);
            own.as_mut_slice().iter_mut().for_each(|f| *f = f.scale(g));
            self.factors[factors].matrix.solve(own.as_mut_slice());
        }
        Ok(())
    }

    /// f, its Jacobian and its derivative by time at the start of a step.
    fn begin_linear<S: System<Y>>(
        &mut self,
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        y: &Y,
    ) -> Result<(), Unsolved> {
        self.take(system, t, end - t, y)?;
        self.span = end - t;
        self.slope(system, t, y)?;
        // Nothing is kept of a start that is not whole.
        self.here = false;
        time_derivative(system, (t, end), y, &self.slope, &mut self.time, &mut self.effort)
            .map_err(|_| Unsolved::Domain)?;
        finite(&self.time)?;
        self.here = true;
        Ok(())
    }
}
