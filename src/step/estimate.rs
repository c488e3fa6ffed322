//! The error of a step whose stages are found together, of a table without embedded rows.

use super::scalar::{Real, Scalar};
use super::state::{RealOf, State};
use crate::linear::ConstantMass;
use crate::tableau::Form;

/// `h (gamma f_n + M sum (bhat - b)_i F_i)`: an embedded formula of as many powers as there are stages, which uses f at
/// the start (Hairer, Wanner II, IV.8).
#[derive(Clone)]
pub(super) struct Estimate<Y: State> {
    pub gamma: RealOf<Y>,
    /// bhat - b
    weights: Vec<RealOf<Y>>,
    error: Y,
}

impl<Y: State> Estimate<Y> {
    /// For distinct times `c` of the stages, none of them 0.
    pub fn new(form: &Form, c: &[f64], gamma: f64, y: &Y) -> Self {
        let real = RealOf::<Y>::from_f64;
        let (b, hat) = (form.weights(), interpolatory(c, gamma));
        let weights = hat.iter().zip(&b).map(|(hat, b)| real(hat - b.to_f64())).collect();
        Self { gamma: real(gamma), weights, error: y.clone() }
    }

    pub fn of(
        &mut self,
        h: RealOf<Y>,
        start: &Y,
        slopes: &[Y],
        mass: Option<&ConstantMass<Y::Scalar>>,
    ) -> &mut Y {
        let error = self.error.as_mut_slice();
        for (e, f) in error.iter_mut().zip(start.as_slice()) {
            *e = f.scale(h * self.gamma);
        }
        for (&weight, f) in self.weights.iter().zip(slopes) {
            match mass {
                None => {
                    for (e, f) in error.iter_mut().zip(f.as_slice()) {
                        *e = *e + f.scale(h * weight);
                    }
                }
                Some(mass) => mass.add_product(error, h * weight, f.as_slice()),
            }
        }
        &mut self.error
    }
}

/// The weights of the slopes at c that make `gamma f(0) + sum weight_i f(c_i)` exact for as many powers.
fn interpolatory(c: &[f64], gamma: f64) -> Vec<f64> {
    let s = c.len();
    // sum_i weight_i c_i^(k-1) = 1/k - gamma [k = 1], by elimination column by column.
    let mut matrix: Vec<f64> = c.iter().flat_map(|&c| (0..s).map(move |k| c.powi(k as i32))).collect();
    let mut x: Vec<f64> = (1..=s).map(|k| 1.0 / k as f64 - if k == 1 { gamma } else { 0.0 }).collect();
    let mut pivots = vec![0; s];
    match crate::linear::factor(s, &mut matrix, &mut pivots) {
        Ok(()) => crate::linear::solve(s, &matrix, &pivots, &mut x),
        // Nodes are distinct where an estimate is asked for.
        Err(_) => x.fill(f64::NAN),
    }
    x
}
