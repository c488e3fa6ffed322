//! Values between steps from the stages of a fully implicit method: their slopes' polynomial, integrated.

use crate::step::scalar::{Real, Scalar};
use crate::step::state::{RealOf, State};
use crate::step::stepper::View;
use crate::tableau::{DoubleDouble as D, Form, Stages};

/// y(t + theta h) = y + h sum_k theta^k sum_i `weights[k - 1][i]` F_i.
#[derive(Clone, Debug)]
pub(crate) struct Collocation {
    weights: Vec<Vec<D>>,
}

impl Collocation {
    /// `None` where stages are not found together, or two of them stand at the same time.
    pub fn of(form: &Form) -> Option<Self> {
        let c = &form.c[..form.s];
        let apart = (0..c.len()).all(|i| c[..i].iter().all(|other| other.hi() != c[i].hi()));
        if !matches!(form.stages(), Stages::Full) || !apart {
            return None;
        }
        // Lagrange's polynomials, power by power, and the integral of each power.
        let lagrange = |i: usize| {
            let mut polynomial = vec![D::ONE];
            for j in (0..c.len()).filter(|&j| j != i) {
                let per = D::ONE.over(c[i].minus(c[j]));
                let mut next = vec![D::ZERO; polynomial.len() + 1];
                for (k, &a) in polynomial.iter().enumerate() {
                    next[k] = next[k].minus(a.times(c[j]).times(per));
                    next[k + 1] = next[k + 1].plus(a.times(per));
                }
                polynomial = next;
            }
            polynomial
        };
        let stages: Vec<Vec<D>> = (0..c.len()).map(lagrange).collect();
        let power = |k: usize| {
            stages.iter().map(|polynomial| polynomial[k].over(D::of_integer(k as i64 + 1))).collect()
        };
        Some(Self { weights: (0..c.len()).map(power).collect() })
    }

    pub fn at<Y: State>(&self, view: View<Y>, h: RealOf<Y>, theta: RealOf<Y>, out: &mut Y) {
        out.as_mut_slice().copy_from_slice(view.y().as_slice());
        let mut power = h;
        for weights in &self.weights {
            power = power * theta;
            for (&weight, slope) in weights.iter().zip(&view.read()[view.form.r..]) {
                let a = power * RealOf::<Y>::of(weight);
                for (out, f) in out.as_mut_slice().iter_mut().zip(slope.as_slice()) {
                    *out = *out + f.scale(a);
                }
            }
        }
    }
}
