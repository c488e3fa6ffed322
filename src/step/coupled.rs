//! All stages at once: Newton's iteration on a fully implicit table, decoupled by the eigenvectors of its A
//! (Butcher 1976, BIT 16, 237; Hairer, Wanner 1996, IV.8).

use super::derivative::subtract;
use super::estimate::Estimate;
use super::implicit::finite;
use super::iteration::Iteration;
use super::measure::weighted_square;
use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use super::stepper::Unsolved;
use super::system::System;
use crate::linear::{ConstantMass, Effort, Eigen, Known, Pair, Square, factor_shifted};
use crate::tableau::Form;
use num_traits::{One, Zero};

/// M - h lambda J for a real eigenvalue.
#[derive(Clone)]
struct Single<R, Q> {
    value: R,
    /// `(T^-1)_ki`, `T_ik`, for all stages i.
    into: Vec<R>,
    back: Vec<R>,
    matrix: Q,
}

/// M - h lambda J for a pair of conjugate eigenvalues.
#[derive(Clone)]
struct Double<R, Q> {
    value: [R; 2],
    /// Real and imaginary parts.
    into: [Vec<R>; 2],
    back: Vec<[R; 2]>,
    matrix: Q,
}

#[derive(Clone)]
pub(super) struct Coupled<Y: State> {
    single: Vec<Single<RealOf<Y>, Y::Square>>,
    double: Vec<Double<RealOf<Y>, Y::PairSquare>>,
    /// The h of the factors; zero where there are none.
    h: RealOf<Y>,
    /// A by rows, c.
    a: Vec<Vec<RealOf<Y>>>,
    c: Vec<RealOf<Y>>,
    stages: Vec<Y>,
    residuals: Vec<Y>,
    changes: Vec<Y>,
    /// Slopes of the last accepted step and its size, to extrapolate from, with the weights that do; one over
    /// `prod (c_j - c_k)` for all j.
    old: Vec<Y>,
    old_h: RealOf<Y>,
    drawn: Vec<RealOf<Y>>,
    lagrange: Vec<RealOf<Y>>,
    w: Y,
    pairs: Y::Pairs,
    /// Where the table has none of its own.
    estimate: Option<Estimate<Y>>,
    /// The factors that belong to it, where its gamma is no eigenvalue.
    own: Option<Y::Square>,
}

impl<Y: State> Coupled<Y> {
    /// `None` where A has too few eigenvectors to decouple its stages.
    pub fn new(form: &Form, y: &Y, known: &Known<Y::Scalar>) -> Option<Self> {
        let real = RealOf::<Y>::from_f64;
        let a = matrix::<RealOf<Y>>(form);
        let plain: Vec<Vec<f64>> = a.iter().map(|row| row.iter().map(|x| x.to_f64()).collect()).collect();
        let eigen = Eigen::of(&plain)?;
        let s = form.s;
        let single = (0..eigen.real).map(|k| Single {
            value: real(eigen.values[k].re),
            into: (0..s).map(|i| real(eigen.inverse[k][i].re)).collect(),
            back: (0..s).map(|i| real(eigen.vectors[i][k].re)).collect(),
            matrix: Y::Square::new(&known.pattern),
        });
        let parts = |x: num_complex::Complex<f64>| [real(x.re), real(x.im)];
        let double = (eigen.real..eigen.values.len()).map(|k| Double {
            value: parts(eigen.values[k]),
            into: [0, 1].map(|part| (0..s).map(|i| parts(eigen.inverse[k][i])[part]).collect()),
            back: (0..s).map(|i| parts(eigen.vectors[i][k])).collect(),
            matrix: Y::PairSquare::new(&known.pattern),
        });
        let single: Vec<_> = single.collect();
        let c: Vec<f64> = (0..s).map(|i| form.c[i].to_f64()).collect();
        let eigenvalue = single.first().map(|x| x.value.to_f64());
        let estimated = form.estimated();
        // Without a real one: as far from zero as the pair nearest to it.
        let gamma = eigenvalue.unwrap_or_else(|| eigen.values[0].norm());
        Some(Self {
            double: double.collect(),
            single,
            h: RealOf::<Y>::zero(),
            a,
            c: (0..s).map(|i| RealOf::<Y>::of(form.c[i])).collect(),
            stages: vec![y.clone(); s],
            residuals: vec![y.clone(); s],
            changes: vec![y.clone(); s],
            old: vec![y.clone(); s],
            old_h: RealOf::<Y>::zero(),
            drawn: vec![RealOf::<Y>::zero(); s],
            lagrange: (0..s).map(|j| real(1.0 / apart(&c, j))).collect(),
            w: y.clone(),
            pairs: y.pairs(),
            estimate: estimated.then(|| Estimate::new(form, &c, gamma, y)),
            own: (estimated && eigenvalue.is_none()).then(|| Y::Square::new(&known.pattern)),
        })
    }

    /// The factors are those of another Jacobian.
    pub fn forget(&mut self) {
        self.h = RealOf::<Y>::zero();
    }

    /// Keeps the slopes of an accepted step of size `h`.
    pub fn keep(&mut self, slopes: &[Y], h: RealOf<Y>) {
        for (to, from) in self.old.iter_mut().zip(slopes) {
            to.as_mut_slice().copy_from_slice(from.as_slice());
        }
        self.old_h = h;
    }

    /// Makes the factors for a step of size `h`, where they are not there. Whether those of the real eigenvalues have
    /// an odd number of negative determinants.
    pub fn factor(
        &mut self,
        jacobian: &Y::Square,
        mass: Option<&ConstantMass<Y::Scalar>>,
        h: RealOf<Y>,
        effort: &mut Effort,
    ) -> Result<bool, Unsolved> {
        if self.h == h {
            return Ok(false);
        }
        self.h = RealOf::<Y>::zero();
        let singular = |component| Unsolved::Singular { component };
        let real = |matrix: &mut Y::Square, value: RealOf<Y>| {
            let hg = h * value;
            factor_shifted(matrix, jacobian, mass, |m| m, |j| j.scale(-hg)).map_err(singular)
        };
        for block in &mut self.single {
            real(&mut block.matrix, block.value)?;
            effort.factorizations += 1;
        }
        if let (Some(estimate), Some(matrix)) = (&self.estimate, &mut self.own) {
            real(matrix, estimate.gamma)?;
            effort.factorizations += 1;
        }
        for block in &mut self.double {
            let [re, im] = block.value.map(|v| -h * v);
            let as_pair = |m: Y::Scalar| Pair { re: m, im: Y::Scalar::zero() };
            let scaled = |j: Y::Scalar| Pair { re: j.scale(re), im: j.scale(im) };
            factor_shifted(&mut block.matrix, jacobian, mass, as_pair, scaled).map_err(singular)?;
            effort.factorizations += 1;
        }
        self.h = h;
        Ok(self.single.iter().fold(false, |odd, block| odd ^ block.matrix.negative()))
    }

    /// Solves the stages: `slopes` come out as the F_i, `last` as the last Y.
    #[allow(clippy::too_many_arguments)] // what one Newton iteration works on
    pub fn solve<S: System<Y>>(
        &mut self,
        system: &mut S,
        mass: Option<&ConstantMass<Y::Scalar>>,
        (t, end): (RealOf<Y>, RealOf<Y>),
        h: RealOf<Y>,
        y: &Y,
        slopes: &mut [Y],
        last: &mut Y,
        weights: &Y,
        mut iteration: Iteration,
        effort: &mut Effort,
    ) -> Result<Iteration, Unsolved> {
        self.guess(h, slopes);
        let s = slopes.len();
        for (stage, row) in self.stages.iter_mut().zip(&self.a) {
            let stage = stage.as_mut_slice();
            stage.copy_from_slice(y.as_slice());
            for (slope, &a) in slopes.iter().zip(row) {
                let a = h * a;
                for (stage, f) in stage.iter_mut().zip(slope.as_slice()) {
                    *stage = *stage + f.scale(a);
                }
            }
        }
        loop {
            for (((stage, residual), &c), slope) in
                self.stages.iter().zip(&mut self.residuals).zip(&self.c).zip(&*slopes)
            {
                let at = if c == RealOf::<Y>::one() { end } else { t + c * h };
                effort.evaluations += 1;
                system.rhs(at, stage, residual).map_err(|_| Unsolved::Domain)?;
                finite(residual)?;
                subtract(residual, mass, slope);
            }
            effort.iterations += 1;
            let square = self.correct(h, slopes, weights);
            match iteration.judge((square / (s * y.as_slice().len()) as f64).sqrt()) {
                None => {}
                Some(Ok(())) => break,
                Some(Err(why)) => return Err(why),
            }
        }
        last.as_mut_slice().copy_from_slice(self.stages[s - 1].as_slice());
        Ok(iteration)
    }

    /// Adds the corrections of slopes and stages; the sum of squares of the latter over their weights.
    fn correct(&mut self, h: RealOf<Y>, slopes: &mut [Y], weights: &Y) -> f64 {
        let zero = Y::Scalar::zero();
        self.changes.iter_mut().for_each(|x| x.as_mut_slice().fill(zero));
        for block in &mut self.single {
            let w = self.w.as_mut_slice();
            w.fill(zero);
            for (&into, r) in block.into.iter().zip(&self.residuals) {
                for (w, r) in w.iter_mut().zip(r.as_slice()) {
                    *w = *w + r.scale(into);
                }
            }
            block.matrix.solve(w);
            for (change, &back) in self.changes.iter_mut().zip(&block.back) {
                for (d, w) in change.as_mut_slice().iter_mut().zip(&*w) {
                    *d = *d + w.scale(back);
                }
            }
        }
        let two = RealOf::<Y>::from_f64(2.0);
        for block in &mut self.double {
            let w = self.pairs.as_mut();
            w.fill(Pair::zero());
            for ((&re, &im), r) in block.into[0].iter().zip(&block.into[1]).zip(&self.residuals) {
                for (w, r) in w.iter_mut().zip(r.as_slice()) {
                    *w = *w + Pair { re: r.scale(re), im: r.scale(im) };
                }
            }
            block.matrix.solve(w);
            for (change, &[re, im]) in self.changes.iter_mut().zip(&block.back) {
                let (re, im) = (two * re, two * im);
                for (d, w) in change.as_mut_slice().iter_mut().zip(&*w) {
                    *d = *d + (w.re.scale(re) - w.im.scale(im));
                }
            }
        }
        for (slope, change) in slopes.iter_mut().zip(&self.changes) {
            for (f, &d) in slope.as_mut_slice().iter_mut().zip(change.as_slice()) {
                *f = *f + d;
            }
        }
        // By A itself, not by its eigenvectors: stages and slopes agree to the last digit of A.
        let mut square = 0.0;
        for (i, stage) in self.stages.iter_mut().enumerate() {
            let w = self.w.as_mut_slice();
            w.fill(zero);
            for (&a, change) in self.a[i].iter().zip(&self.changes) {
                for (w, d) in w.iter_mut().zip(change.as_slice()) {
                    *w = *w + d.scale(a);
                }
            }
            for ((y, w), &weight) in stage.as_mut_slice().iter_mut().zip(&mut *w).zip(weights.as_slice()) {
                let change = w.scale(h);
                *y = *y + change;
                match const { Y::INLINE } {
                    true => square += (change * weight).square().to_f64(),
                    false => *w = change,
                }
            }
            if const { !Y::INLINE } {
                square += weighted_square(&self.w, weights);
            }
        }
        square
    }

    /// The collocation polynomial of the last step, drawn out; nothing where there was none: the slope at a start far
    /// from where the solution wants to be would be larger than all that follows.
    fn guess(&mut self, h: RealOf<Y>, slopes: &mut [Y]) {
        match slopes.len() {
            2 => self.guess_stages(2, h, slopes),
            3 => self.guess_stages(3, h, slopes),
            4 => self.guess_stages(4, h, slopes),
            5 => self.guess_stages(5, h, slopes),
            s => self.guess_stages(s, h, slopes),
        }
    }

    #[inline(always)]
    fn guess_stages(&mut self, s: usize, h: RealOf<Y>, slopes: &mut [Y]) {
        if self.old_h.is_zero() {
            slopes.iter_mut().for_each(|slope| slope.as_mut_slice().fill(Y::Scalar::zero()));
            return;
        }
        let ratio = h / self.old_h;
        let (c, lagrange, drawn) = (&self.c[..s], &self.lagrange[..s], &mut self.drawn[..s]);
        let old = &self.old[..s];
        for (i, slope) in slopes[..s].iter_mut().enumerate() {
            let theta = RealOf::<Y>::one() + ratio * c[i];
            for j in 0..s {
                drawn[j] = lagrange[j];
                for (k, &node) in c.iter().enumerate() {
                    if k != j {
                        drawn[j] = drawn[j] * (theta - node);
                    }
                }
            }
            weighted(drawn, old, slope);
        }
    }

    /// The error of the step, freed of the stiff components (Shampine's filter): `(M - h gamma J)^-1` times the
    /// [`Estimate`]. `None` where the table has rows of its own.
    pub fn error(
        &mut self,
        h: RealOf<Y>,
        start: &Y,
        slopes: &[Y],
        mass: Option<&ConstantMass<Y::Scalar>>,
    ) -> Option<&Y> {
        let error = self.estimate.as_mut()?.of(h, start, slopes, mass);
        match (&mut self.own, self.single.first_mut()) {
            (Some(matrix), _) => matrix.solve(error.as_mut_slice()),
            (None, Some(block)) => block.matrix.solve(error.as_mut_slice()),
            (None, None) => {}
        }
        Some(error)
    }
}

/// prod_k (c_j - c_k)
fn apart(c: &[f64], j: usize) -> f64 {
    (0..c.len()).filter(|&k| k != j).map(|k| c[j] - c[k]).product()
}

/// Writes a weighted sum of vectors.
#[inline(always)]
fn weighted<Y: State>(weights: &[RealOf<Y>], of: &[Y], to: &mut Y) {
    let to = to.as_mut_slice();
    for (j, (&weight, x)) in weights.iter().zip(of).enumerate() {
        for (to, x) in to.iter_mut().zip(x.as_slice()) {
            let term = x.scale(weight);
            *to = if j == 0 { term } else { *to + term };
        }
    }
}

/// A by rows, from the rows of the stages.
pub(crate) fn matrix<R: Real>(form: &Form) -> Vec<Vec<R>> {
    let mut a = vec![vec![R::zero(); form.s]; form.s];
    for (i, row) in form.stage[..form.s].iter().enumerate() {
        for j in 0..row.len {
            if row.at[j] >= form.r {
                a[i][row.at[j] - form.r] = R::of(row.a[j]);
            }
        }
        a[i][i] = R::of(row.diagonal);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tableau::Stages;

    #[test]
    fn every_coupled_table_is_rebuilt_from_its_eigenvectors() {
        let mut count = 0;
        for entry in crate::methods::all() {
            let Some(form) = entry.tableau().form() else { continue };
            if !matches!(form.stages(), Stages::Full) {
                continue;
            }
            let a = matrix::<f64>(&form);
            let Some(eigen) = Eigen::of(&a) else { panic!("{} has too few eigenvectors", entry.name) };
            for (i, row) in a.iter().enumerate() {
                for (j, &entry_ij) in row.iter().enumerate() {
                    let term = |k: usize| {
                        let weight = if k < eigen.real { 1.0 } else { 2.0 };
                        weight * (eigen.vectors[i][k] * eigen.values[k] * eigen.inverse[k][j]).re
                    };
                    let sum: f64 = (0..eigen.values.len()).map(term).sum();
                    assert!((sum - entry_ij).abs() < 1e-9, "{}: {i}, {j}: {sum} {entry_ij}", entry.name);
                }
            }
            count += 1;
        }
        assert!(count >= 3, "{count}");
    }
}
