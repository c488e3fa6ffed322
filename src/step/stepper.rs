//! The one stepper: Runge–Kutta, Adams, predictor–corrector, Störmer–Verlet and Nyström methods.

use super::implicit::Solver;
use super::method::{Known, Method};
use super::norm::Tolerance;
use super::row::{
    CarryRow, ErrorRow, Read, RowAt, StageRow, assemble, error_square, form_of, powers, unroll,
};
use super::scalar::{Arith, Real};
use super::state::{RealOf, State};
use super::system::System;
use crate::tableau::{DoubleDouble, Form, Meaning, Row};
use num_traits::{One, Zero};
use std::marker::PhantomData;

/// Why an attempted step has no result.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Refused {
    /// The stage that has none, from 0.
    pub stage: usize,
    pub why: Unsolved,
}

/// Why a stage has no result.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unsolved {
    /// The right-hand side refused the point.
    Domain,
    /// Newton's iteration diverged or was too slow, with a Jacobian of this step.
    Diverged,
    /// The matrix M - h g J has no pivot in this column.
    Singular { component: usize },
    /// The matrix M - h g J is that of a smaller step with a determinant of the other sign: between the two a solution
    /// grows without bound.
    Outgrown,
    /// The rounding of the Jacobian may have left no digit of this component that is asked for.
    Rounding { component: usize },
    /// The right-hand side gave a NaN or an infinity in this component.
    NonFinite { component: usize },
    /// The Jacobian has one in this row.
    Jacobian { component: usize },
    /// The Jacobian was written to outside its pattern.
    OutsidePattern { row: usize, column: usize },
}

/// What a stepper holds, whatever its method: code off the hot path is compiled once for a state.
pub struct View<'s, Y> {
    pub form: &'s Form,
    words: &'s [Y],
}

impl<Y> Clone for View<'_, Y> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<Y> Copy for View<'_, Y> {}

impl<'s, Y: State> View<'s, Y> {
    /// The carried vectors z_0 .. z_(r-1), then the slopes F_0 .. F_(s-1).
    pub fn read(self) -> &'s [Y] {
        &self.words[..self.form.r + self.form.s]
    }

    /// The state at the start of the step.
    pub fn y(self) -> &'s Y {
        &self.words[0]
    }

    pub fn word(self, i: usize) -> &'s Y {
        &self.words[i]
    }

    /// z'_j of the step just attempted.
    pub fn next(self, j: usize) -> &'s Y {
        &self.words[target(self.form, j)]
    }

    /// Where the slope at the end of the step stands after an attempt, if the method computes it.
    pub fn next_slope_at(self) -> Option<usize> {
        let form = self.form;
        (0..form.r).find(|&j| form.means[j] == Meaning::F(0)).map(|j| target(form, j))
    }
}

/// The vectors of a run: z, F | Y, z'. What is read stands before what is written.
#[derive(Clone)]
pub struct Stepper<M: Method, Y: State> {
    pub method: M,
    words: M::Words<Y>,
}

impl<M: Method, Y: State> Stepper<M, Y> {
    /// Room for a run; `z` must be filled before the first step.
    pub fn new(method: M, y: &Y) -> Self {
        let words = method.words(y);
        Self { method, words }
    }

    pub fn view(&self) -> View<'_, Y> {
        View { form: self.form(), words: self.words.as_ref() }
    }

    #[inline(always)]
    pub fn form(&self) -> &Form {
        form_of(&self.method)
    }

    /// The carried vectors z_0 .. z_(r-1), then the slopes F_0 .. F_(s-1).
    #[inline(always)]
    pub fn read(&self) -> &[Y] {
        &self.words.as_ref()[..self.form().r + self.form().s]
    }

    /// The state at the start of the step.
    #[inline(always)]
    pub fn y(&self) -> &Y {
        &self.words.as_ref()[0]
    }

    /// Where z'_j stands between [`attempt`](Self::attempt) and [`accept`](Self::accept).
    #[inline(always)]
    pub fn next_at(&self, j: usize) -> usize {
        target(self.form(), j)
    }

    /// z'_j of the step just attempted.
    #[inline(always)]
    pub fn next(&self, j: usize) -> &Y {
        &self.words.as_ref()[self.next_at(j)]
    }

    /// Evaluates the stages and assembles z', leaving z as it is. The step of size `h` from `t` ends at `end`,
    /// which may differ from t + h by rounding; stages at the end of the step see that time.
    ///
    /// `known` says that F_0 is there already: the step is a retry, or the slope was needed before.
    ///
    /// # Errors
    /// The stage at which the right-hand side refused.
    #[inline(always)]
    pub fn attempt<A: Arith, S: System<Y>>(
        &mut self,
        system: &mut S,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        known: bool,
        solver: &mut Option<Box<Solver<Y>>>,
    ) -> Result<(), Refused> {
        if const { M::READ || !Known::<M>::FORM.explicit() }
            && let Some(solver) = solver
        {
            let form = form_of(&self.method);
            return solver.attempt(form, self.words.as_mut(), system, (t, end), h, known);
        }
        let powers = powers(h);
        if const { Known::<M>::UNROLLED && A::UNROLLED } {
            let form = Known::<M>::FORM;
            let (x, out) = self.words.as_mut().split_at_mut(form.r + form.s);
            unroll!(Known::<M>::FORM.s, I => {
                let c = RealOf::<Y>::of(const { Known::<M>::FORM.c[I] });
                let at = if const { is_one(Known::<M>::FORM.c[I]) } { end } else { t + c * h };
                let row = StageRow::<M, I>(PhantomData);
                stage::<A, Y, S, _>(system, row, form.r, I, at, &powers, x, out, known)?;
            });
            unroll!(Known::<M>::FORM.r, J => {
                carry::<A, Y, _>(CarryRow::<M, J>(PhantomData), J, &powers, x, out);
            });
        } else {
            let form = self.method.form();
            let (x, out) = self.words.as_mut().split_at_mut(form.r + form.s);
            for i in 0..form.s {
                let c = RealOf::<Y>::of(form.c[i]);
                let at = if is_one(form.c[i]) { end } else { t + c * h };
                stage::<A, Y, S, _>(system, Read(&form.stage[i]), form.r, i, at, &powers, x, out, known)?;
            }
            for j in 0..form.r {
                carry::<A, Y, _>(Read(&form.carry[j]), j, &powers, x, out);
            }
        }
        Ok(())
    }

    /// Makes z' the new z. What is on the heap is swapped, not copied.
    #[inline(always)]
    pub fn accept(&mut self) {
        if const { Known::<M>::UNROLLED } {
            let words = self.words.as_mut();
            // The oldest vector moves first, so a shift of the history overwrites nothing it still needs.
            unroll!(Known::<M>::FORM.r, I => {
                let j = const { back(Known::<M>::FORM.r, I) };
                take(words, j, const { target(Known::<M>::FORM, back(Known::<M>::FORM.r, I)) });
            });
        } else {
            let form = self.method.form();
            for j in (0..form.r).rev() {
                take(self.words.as_mut(), j, target(form, j));
            }
        }
    }

    /// The square of the error norm of the step just attempted; the step is good where it is at most 1.
    ///
    /// Two embedded rows of different order are combined as in DOP853 (Hairer, Nørsett, Wanner I, II.10);
    /// of two of the same order the larger estimate counts.
    #[inline(always)]
    pub fn error_square<A: Arith>(&self, h: RealOf<Y>, tolerance: &Tolerance<RealOf<Y>>) -> RealOf<Y> {
        let powers = powers(h);
        let form = self.form();
        let x = self.read();
        let y1 = self.next(0);
        let share = RealOf::<Y>::one() / RealOf::<Y>::from_f64(y1.as_slice().len().max(1) as f64);
        let (first, second) = if const { Known::<M>::UNROLLED && A::UNROLLED } {
            let first = error_square::<A, Y, _>(ErrorRow::<M, 0>(PhantomData), &powers, x, y1, tolerance);
            if const { Known::<M>::FORM.errors < 2 } {
                return first * share;
            }
            (first, error_square::<A, Y, _>(ErrorRow::<M, 1>(PhantomData), &powers, x, y1, tolerance))
        } else {
            let first = error_square::<A, Y, _>(Read(&form.error[0]), &powers, x, y1, tolerance);
            if form.errors < 2 {
                return first * share;
            }
            (first, error_square::<A, Y, _>(Read(&form.error[1]), &powers, x, y1, tolerance))
        };
        if form.embedded[0] == form.embedded[1] {
            return first.maximum(second) * share;
        }
        if first.is_zero() && second.is_zero() {
            return first;
        }
        first * share * (first / (first + RealOf::<Y>::from_f64(0.01) * second))
    }

    pub fn word(&self, i: usize) -> &Y {
        &self.words.as_ref()[i]
    }

    pub fn form_and_words(&mut self) -> (&Form, &mut [Y]) {
        (form_of(&self.method), self.words.as_mut())
    }

    pub fn words_mut(&mut self) -> &mut [Y] {
        self.words.as_mut()
    }
}

/// The word that holds the slope at the end of a step which no error row looks at, as in DOP853: a NaN there
/// would pass the error test and spoil every try of the next step.
pub const fn unseen_slope(form: &Form) -> Option<usize> {
    let mut j = 0;
    while j < form.r {
        if matches!(form.means[j], Meaning::F(0)) {
            let at = target(form, j);
            let (mut seen, mut e) = (false, 0);
            while e < form.errors {
                let mut i = 0;
                while i < form.error[e].len {
                    seen = seen || form.error[e].at[i] == at;
                    i += 1;
                }
                e += 1;
            }
            return if seen { None } else { Some(at) };
        }
        j += 1;
    }
    None
}

/// The word that holds f(t_n, y_n) after an attempt, if the method evaluates it.
pub fn start_slope_at(form: &Form) -> Option<usize> {
    let carried = (0..form.r).find(|&j| form.means[j] == Meaning::F(0));
    carried.or_else(|| (!form.split() && copied(Some(&form.stage[0])) == Some(0)).then_some(form.r))
}

/// The word that z'_j is moved from.
const fn target(form: &Form, j: usize) -> usize {
    let row = &form.carry[j];
    if row.last_y {
        form.r + form.s
    } else if row.copies() {
        match row.base {
            Some(i) => i,
            None => j,
        }
    } else {
        form.r + form.s + 1 + j
    }
}

const fn back(r: usize, i: usize) -> usize {
    if i < r { r - 1 - i } else { 0 }
}

#[inline(always)]
fn take<Y: State>(words: &mut [Y], to: usize, from: usize) {
    if to != from {
        let [to, from] = words.get_disjoint_mut([to, from]).expect("two words of the form");
        to.take(from);
    }
}

#[allow(clippy::too_many_arguments)] // inlined into the two branches of `attempt`, which it spares from being written twice
#[inline(always)]
fn stage<A: Arith, Y: State, S: System<Y>, R: RowAt>(
    system: &mut S,
    row: R,
    r: usize,
    i: usize,
    t: RealOf<Y>,
    powers: &[RealOf<Y>; 3],
    x: &mut [Y],
    out: &mut [Y],
    known: bool,
) -> Result<(), Refused> {
    let copied = if const { R::ROW.is_some() } { const { copied(R::ROW) } } else { copied(Some(row.row())) };
    let verdict = if let Some(base) = copied {
        let (z, f) = x.split_at_mut(r);
        if known && i == 0 { Ok(()) } else { system.rhs(t, &z[base], &mut f[i]) }
    } else {
        assemble::<A, Y, R>(&mut out[0], row, powers, x);
        system.rhs(t, &out[0], &mut x[r + i])
    };
    verdict.map_err(|_| Refused { stage: i, why: Unsolved::Domain })
}

/// To the fewest digits that a table may have: a sum of printed decimals misses 1 by some of them, and a stage beyond
/// the end of a step would look across a break.
pub(super) const fn is_one(c: DoubleDouble) -> bool {
    (c.hi() - 1.0).abs() < 1e-11
}

/// The source of a row that computes nothing.
const fn copied(row: Option<&Row>) -> Option<usize> {
    match row {
        Some(row) if row.copies() => row.base,
        _ => None,
    }
}

/// z' is moved there by `accept`, not assembled.
const fn moved(row: Option<&Row>) -> bool {
    match row {
        Some(row) => row.copies() || row.last_y,
        None => true,
    }
}

#[inline(always)]
fn carry<A: Arith, Y: State, R: RowAt>(row: R, j: usize, powers: &[RealOf<Y>; 3], x: &[Y], out: &mut [Y]) {
    let moved = if const { R::ROW.is_some() } { const { moved(R::ROW) } } else { moved(Some(row.row())) };
    if !moved {
        assemble::<A, Y, R>(&mut out[1 + j], row, powers, x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::{Dp54, Verner87Efficient};
    use crate::step::scalar::{Plain, Rolled};

    fn steps<A: Arith, M: Method>(method: M) -> (Vec<[f64; 2]>, f64) {
        let mut pendulum = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [y[1], -y[0].sin()];
        let mut stepper = Stepper::new(method, &[0.0; 2]);
        let (mut seen, mut errors) = (vec![], 0.0);
        stepper.words_mut()[0] = [1.0, 0.3];
        if let Some(j) = stepper.form().means.iter().position(|&m| m == Meaning::F(0)) {
            stepper.words_mut()[j] = [0.3, -1f64.sin()];
        }
        for i in 0..20 {
            let t = 0.1 * i as f64;
            stepper.attempt::<A, _>(&mut pendulum, (t, t + 0.1), 0.1, false, &mut None).unwrap();
            errors += stepper.error_square::<A>(0.1, &Tolerance::Scalar { rtol: 1e-6, atol: 1e-6 });
            stepper.accept();
            seen.push(*stepper.y());
        }
        (seen, errors)
    }

    #[test]
    fn a_loop_over_the_rows_gives_the_bits_of_the_unrolled_step() {
        assert_eq!(steps::<Plain, _>(Dp54), steps::<Rolled, _>(Dp54));
        assert_eq!(steps::<Plain, _>(Verner87Efficient), steps::<Rolled, _>(Verner87Efficient));
    }
}
