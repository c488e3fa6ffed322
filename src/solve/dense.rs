//! Values between steps: the table's own interpolant, else Hermite interpolation of matching order.

use super::outcome::{Interpolant, Why};
use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State, add, first_non_finite};
use crate::step::stepper::{View, start_slope_at};
use crate::step::system::System;
use crate::tableau::{DoubleDouble as D, Form, Meaning, Row};
use num_traits::{One, Zero};

/// Interior points of the Hermite interpolants in the order they are added, over 840: chosen one by one
/// so that no value grows by more than 1.04 on the way from the data to the curve.
const NODES: [i64; 6] = [294, 462, 120, 630, 84, 735];

/// The interpolant of the step just attempted.
///
/// Hermite interpolation takes y and f at both ends of the step: order 3. Each interior point raises the
/// order by one: f is evaluated there at the values of the interpolant one order lower, level by level
/// (Enright, Jackson, Nørsett, Thomsen 1986, ACM TOMS 12). For y'' = f(t, y) it is the quintic through
/// y, y' and y'' at both ends.
#[derive(Clone)]
pub(crate) struct Dense<Y: State> {
    pub interpolant: Interpolant,
    /// Interior points of the Hermite interpolant.
    interior: usize,
    /// With a mass matrix f gives no slopes: those of the stages have to do.
    mass: bool,
    /// Hermite levels with 0, 1, .. interior points, made when first needed.
    levels: Vec<Level>,
    /// Own: slopes of the extra stages. Hermite: slopes at the start, the end, the interior points.
    slopes: Vec<Y>,
    value: Y,
    /// The slopes belong to the step in hand.
    ready: bool,
    /// `slopes[1]` is the slope at the start of the step about to be taken.
    carried: bool,
}

impl<Y: State> Dense<Y> {
    pub fn new(form: &Form, y: &Y, mass: bool) -> Self {
        let (interpolant, interior) = if form.orders > 0 {
            (Interpolant::Nordsieck { lowest: 1, highest: form.orders }, 0)
        } else if form.dense_order > 0 {
            (Interpolant::Own { order: form.dense_order }, 0)
        } else if mass {
            (Interpolant::Hermite { order: form.order.min(3) }, 0)
        } else if form.d == 2 {
            let order = if form.means[..form.r].contains(&Meaning::V) { 5 } else { 2 };
            (Interpolant::Hermite { order }, 0)
        } else {
            // Between the ends of a stiff step f would magnify the errors of the values it is given.
            let interior = if form.explicit() { form.order.saturating_sub(3).min(NODES.len()) } else { 0 };
            (Interpolant::Hermite { order: interior + 3 }, interior)
        };
        Self {
            interpolant,
            interior,
            mass,
            levels: vec![],
            slopes: vec![],
            value: y.clone(),
            ready: false,
            carried: false,
        }
    }

    /// A new step begins where this one ended. Whether the slope there was evaluated, so that the method
    /// need not do it again.
    pub fn next_step(&mut self) -> bool {
        self.carried = self.ready && !self.is_own();
        self.ready = false;
        self.carried
    }

    /// The slope at the start of the step that begins, after [`next_step`](Self::next_step) said yes.
    pub fn carried_slope(&self) -> &Y {
        &self.slopes[1]
    }

    /// A leg begins with this slope, which f does not give.
    pub fn begin(&mut self, slope: &Y) {
        if self.slopes.len() < 2 {
            self.slopes = vec![self.value.clone(); 2];
        }
        copy(&mut self.slopes[1], slope);
        (self.ready, self.carried) = (false, !self.is_own());
    }

    /// Looks at every step: the slope at its end is that at the start of the next.
    pub fn follows(&self) -> bool {
        self.mass && !self.is_own()
    }

    /// With a mass matrix: the stages give what lies between steps, by an interpolant of their own or by the slope
    /// at the end of the step.
    pub fn can_serve_mass(form: &Form) -> bool {
        form.dense_order > 0 || end_stage(form).is_some()
    }

    /// A new leg begins somewhere else.
    pub fn forget(&mut self) {
        (self.ready, self.carried) = (false, false);
    }

    fn is_own(&self) -> bool {
        !matches!(self.interpolant, Interpolant::Hermite { .. })
    }

    /// Evaluates what the interpolant needs beside the stages, once per step, and counts it.
    pub fn prepare(
        &mut self,
        view: View<Y>,
        system: &mut dyn System<Y>,
        t: RealOf<Y>,
        h: RealOf<Y>,
        t1: RealOf<Y>,
        evaluations: &mut u64,
    ) -> Result<(), Why> {
        if self.ready {
            return Ok(());
        }
        let form = view.form;
        let mut ask = |t: RealOf<Y>, y: &Y, slope: &mut Y| {
            *evaluations += 1;
            system.rhs(t, y, slope).map_err(|_| Why::OutOfDomain { stage: form.s })?;
            match first_non_finite(slope) {
                Some(component) => Err(Why::NonFinite { component, stage: None }),
                None => Ok(()),
            }
        };
        // Rounding does not carry f beyond the end of the step.
        let end = if ((t + h) > t1) == (t1 > t) { t1 } else { t + h };
        let count = if self.is_own() { form.extra } else { 2 + self.interior };
        if self.slopes.len() < count {
            self.slopes = vec![self.value.clone(); count];
        }
        if self.levels.is_empty() && !self.is_own() && form.d == 1 {
            self.levels = (0..=self.interior).map(Level::new).collect();
        }
        if self.is_own() {
            for i in 0..form.extra {
                let row = &form.stage[form.s + i];
                self.stage_value(form, view.read(), row, h);
                let c = RealOf::<Y>::of(form.c[form.s + i]);
                let at = if c == RealOf::<Y>::one() { end } else { t + c * h };
                ask(at, &self.value, &mut self.slopes[i])?;
            }
            self.ready = true;
            return Ok(());
        }
        if self.carried {
            self.slopes.swap(0, 1);
        } else if let Some(i) = start_slope_at(form) {
            copy(&mut self.slopes[0], view.word(i));
        } else {
            ask(t, view.y(), &mut self.slopes[0])?;
        }
        self.carried = false;
        // The slope of a stage at the end was found with its value, whose errors f would magnify.
        if let Some(i) = view.next_slope_at().or_else(|| end_stage(form)) {
            copy(&mut self.slopes[1], view.word(i));
        } else {
            ask(end, view.next(0), &mut self.slopes[1])?;
        }
        for level in 1..self.levels.len() {
            // A value of the level below is good enough at every node, so slopes may be renewed in place.
            for (i, &node) in NODES[..level].iter().enumerate() {
                let theta = RealOf::<Y>::of(D::of_integer(node).over(D::of_integer(840)));
                let weights = self.levels[level - 1].weights(theta);
                let slopes = &self.slopes[..level + 1];
                hermite(&mut self.value, &weights, h, view.y(), view.next(0), slopes);
                ask(t + theta * h, &self.value, &mut self.slopes[2 + i])?;
            }
        }
        self.ready = true;
        Ok(())
    }

    /// y at t + theta h, after [`prepare`](Self::prepare).
    pub fn at(&self, view: View<Y>, h: RealOf<Y>, theta: RealOf<Y>, out: &mut Y) {
        let form = view.form;
        match self.levels.last() {
            Some(level) => hermite(out, &level.weights(theta), h, view.y(), view.next(0), &self.slopes),
            None if form.d == 2 => {
                let (v0, v1) = self.velocities(view, h);
                let (x0, x1) = (view.y().as_slice(), view.next(0).as_slice());
                let (a0, a1) = (self.slopes[0].as_slice(), self.slopes[1].as_slice());
                let w = quintic(theta, h);
                for (i, out) in out.as_mut_slice().iter_mut().enumerate() {
                    let change = (x1[i] - x0[i]).scale(w[2]);
                    let slopes = v0(i).scale(w[0]) + v1(i).scale(w[3]);
                    *out = x0[i] + (change + slopes + (a0[i].scale(w[1]) + a1[i].scale(w[4])));
                }
            }
            None if form.orders > 0 => {
                // About the end of the step; vectors above its order are zero.
                let past = theta - RealOf::<Y>::one();
                copy(out, view.next(form.orders));
                for k in (0..form.orders).rev() {
                    for (out, &z) in out.as_mut_slice().iter_mut().zip(view.next(k).as_slice()) {
                        *out = z + out.scale(past);
                    }
                }
            }
            None => {
                copy(out, view.y());
                let x = view.read();
                let source = |i: usize| if i < x.len() { &x[i] } else { &self.slopes[i - x.len()] };
                let mut power = h;
                // theta (row 1 + theta (row 2 + ..)) would need room for each row; the powers do not.
                for row in &form.dense[..form.powers] {
                    power = power * theta;
                    for j in 0..row.len {
                        add(out, power * RealOf::<Y>::of(row.a[j]), source(row.at[j]));
                    }
                }
            }
        }
    }

    /// y' at t + theta h of y'' = f(t, y), after [`prepare`](Self::prepare).
    pub fn velocity_at(&self, view: View<Y>, h: RealOf<Y>, theta: RealOf<Y>, out: &mut Y) {
        let (v0, v1) = self.velocities(view, h);
        let (x0, x1) = (view.y().as_slice(), view.next(0).as_slice());
        let (a0, a1) = (self.slopes[0].as_slice(), self.slopes[1].as_slice());
        let w = quintic_slope(theta, h);
        for (i, out) in out.as_mut_slice().iter_mut().enumerate() {
            let change = (x1[i] - x0[i]).scale(w[2]);
            *out = change + (v0(i).scale(w[0]) + v1(i).scale(w[3])) + (a0[i].scale(w[1]) + a1[i].scale(w[4]));
        }
    }

    /// y' at the end of the step.
    pub fn end_velocity(
        &mut self,
        view: View<Y>,
        system: &mut dyn System<Y>,
        t: RealOf<Y>,
        h: RealOf<Y>,
        t1: RealOf<Y>,
        out: &mut Y,
        evaluations: &mut u64,
    ) -> Result<(), Why> {
        let form = view.form;
        if let Some(j) = (0..form.r).find(|&j| form.means[j] == Meaning::V) {
            copy(out, view.next(j));
            return Ok(());
        }
        self.prepare(view, system, t, h, t1, evaluations)?;
        let (_, end) = self.velocities(view, h);
        out.as_mut_slice().iter_mut().enumerate().for_each(|(i, v)| *v = end(i));
        Ok(())
    }

    /// Velocities at both ends: carried, or of second order from the positions, as in Störmer–Verlet:
    /// `(x1 - x0)/h -+ h/2 a`.
    #[allow(clippy::type_complexity)] // two closures over the same step
    fn velocities<'s>(
        &'s self,
        view: View<'s, Y>,
        h: RealOf<Y>,
    ) -> (impl Fn(usize) -> Y::Scalar + 's, impl Fn(usize) -> Y::Scalar + 's) {
        let form = view.form;
        let carried = (0..form.r).find(|&j| form.means[j] == Meaning::V);
        let half = h * RealOf::<Y>::from_f64(0.5);
        let per = RealOf::<Y>::one() / h;
        let secant = move |i: usize| (view.next(0).as_slice()[i] - view.y().as_slice()[i]).scale(per);
        let start = move |i: usize| match carried {
            Some(j) => view.word(j).as_slice()[i],
            None => secant(i) - self.slopes[0].as_slice()[i].scale(half),
        };
        let end = move |i: usize| match carried {
            Some(j) => view.next(j).as_slice()[i],
            None => secant(i) + self.slopes[1].as_slice()[i].scale(half),
        };
        (start, end)
    }

    /// The argument of an extra stage.
    fn stage_value(&mut self, form: &Form, x: &[Y], row: &Row, h: RealOf<Y>) {
        let powers = [RealOf::<Y>::one(), h, h * h];
        self.value.as_mut_slice().fill(Y::Scalar::zero());
        for j in 0..row.len {
            let source = if row.at[j] < x.len() { &x[row.at[j]] } else { &self.slopes[row.at[j] - x.len()] };
            add(&mut self.value, powers[row.power[j]] * RealOf::<Y>::of(row.a[j]), source);
        }
        debug_assert!(form.d == 1);
        if let Some(base) = row.base {
            add(&mut self.value, RealOf::<Y>::one(), &x[base]);
        }
    }
}

/// The slope of a last stage that is y' itself.
fn end_stage(form: &Form) -> Option<usize> {
    (form.carry[0].last_y && !form.linear && !form.explicit()).then(|| form.r + form.s - 1)
}

/// A Hermite polynomial with some interior points, as a map from data to coefficients of theta^1, theta^2, ..
#[derive(Clone, Debug)]
struct Level {
    /// `coefficients[k][i]`: of theta^(k+1) for the slope i, the last column for y1 - y0.
    coefficients: Vec<Vec<D>>,
}

impl Level {
    fn new(interior: usize) -> Self {
        let degree = interior + 3;
        let theta = |i: usize| match i {
            0 => D::ZERO,
            1 => D::ONE,
            i => D::of_integer(NODES[i - 2]).over(D::of_integer(840)),
        };
        // Slopes sum_k k c_k theta_i^(k-1) at every node, and sum_k c_k = y1 - y0: inverted by elimination.
        let mut rows: Vec<Vec<D>> = (0..degree)
            .map(|i| {
                let entry = |k: usize| match i {
                    i if i + 1 == degree => D::ONE,
                    i => D::of_integer(k as i64).times(theta(i).powi(k as u32 - 1)),
                };
                let unit = (0..degree).map(|j| if i == j { D::ONE } else { D::ZERO });
                (1..=degree).map(entry).chain(unit).collect()
            })
            .collect();
        for k in 0..degree {
            let size = |i: usize, rows: &[Vec<D>]| rows[i][k].abs().hi();
            let pivot = (k..degree).max_by(|&i, &j| size(i, &rows).total_cmp(&size(j, &rows))).unwrap_or(k);
            rows.swap(k, pivot);
            let head = rows[k][k];
            rows[k].iter_mut().for_each(|x| *x /= head);
            let row = rows[k].clone();
            for other in (0..degree).filter(|&i| i != k) {
                let by = rows[other][k];
                rows[other].iter_mut().zip(&row).for_each(|(x, y)| *x -= by * *y);
            }
        }
        Self { coefficients: rows.into_iter().map(|row| row[degree..].to_vec()).collect() }
    }

    /// The weight of each slope, and last that of y1 - y0, at theta.
    fn weights<R: Real>(&self, theta: R) -> [R; NODES.len() + 3] {
        let mut weights = [R::zero(); NODES.len() + 3];
        for row in self.coefficients.iter().rev() {
            for (w, &c) in weights.iter_mut().zip(row) {
                *w = (*w + R::of(c)) * theta;
            }
        }
        weights
    }
}

/// `y0 + h sum_i w_i slope_i + w (y1 - y0)`, one pass; the weight of the change follows those of the slopes.
fn hermite<Y: State>(out: &mut Y, weights: &[RealOf<Y>], h: RealOf<Y>, y0: &Y, y1: &Y, slopes: &[Y]) {
    let (y0, y1) = (y0.as_slice(), y1.as_slice());
    for (i, out) in out.as_mut_slice().iter_mut().enumerate() {
        let mut sum = (y1[i] - y0[i]).scale(weights[slopes.len()]);
        for (slope, &w) in slopes.iter().zip(weights) {
            sum = sum + slope.as_slice()[i].scale(h * w);
        }
        *out = y0[i] + sum;
    }
}

/// Weights of v0, a0, x1 - x0, v1, a1 in the quintic.
fn quintic<R: Real>(s: R, h: R) -> [R; 5] {
    let n = R::from_f64;
    let (s2, s3) = (s * s, s * s * s);
    let half = n(0.5) * h * h;
    [
        h * (s - s3 * (n(6.0) - s * (n(8.0) - n(3.0) * s))),
        half * s2 * (R::one() - s * (n(3.0) - s * (n(3.0) - s))),
        s3 * (n(10.0) - s * (n(15.0) - n(6.0) * s)),
        -h * s3 * (n(4.0) - s * (n(7.0) - n(3.0) * s)),
        half * s3 * (R::one() - s * (n(2.0) - s)),
    ]
}

/// The derivatives of [`quintic`] by t.
fn quintic_slope<R: Real>(s: R, h: R) -> [R; 5] {
    let n = R::from_f64;
    let s2 = s * s;
    let half = n(0.5) * h;
    [
        R::one() - s2 * (n(18.0) - s * (n(32.0) - n(15.0) * s)),
        half * s * (n(2.0) - s * (n(9.0) - s * (n(12.0) - n(5.0) * s))),
        s2 * (n(30.0) - s * (n(60.0) - n(30.0) * s)) / h,
        -s2 * (n(12.0) - s * (n(28.0) - n(15.0) * s)),
        half * s2 * (n(3.0) - s * (n(8.0) - n(5.0) * s)),
    ]
}

fn copy<Y: State>(to: &mut Y, from: &Y) {
    to.as_mut_slice().copy_from_slice(from.as_slice());
}
