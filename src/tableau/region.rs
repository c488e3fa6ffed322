//! The stability region of a method, point by point, and the control of the step size on its border.

use super::double_double::DoubleDouble as D;
use super::form::Form;
use super::series::Forms;
use super::stability::{Characteristic, Complex as Exact};
use super::{Scheme, Tableau};
use crate::linear::roots;
use crate::solve::control::Controller;
use num_complex::Complex;

/// What a step makes of y' = lambda y as a function of z = h lambda; for y'' = -omega^2 y, where positions
/// and velocities are carried, of z = -(h omega)^2.
///
/// ```
/// let rk4 = kutta::methods::find("rk4").expect("a method").tableau().stability();
/// // R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24, and |R| <= 1 on the real axis down to -2.7853.
/// assert!((rk4.amplification((-2.0).into()) - 1.0 / 3.0).abs() < 1e-14);
/// assert!((rk4.limit(0.0) - 2.7853).abs() < 1e-4);
/// ```
pub struct Stability {
    characteristic: Characteristic,
    /// The form with embedded rows, where the stages are explicit and nothing but y is carried.
    pair: Option<Form>,
    second_order: bool,
    tolerance: f64,
}

impl Tableau<'_> {
    /// Its stability region. Of an IMEX pair: that of the explicit table.
    pub fn stability(&self) -> Stability {
        let mut forms = Forms::of(self);
        if let Scheme::RungeKutta(array) = &self.scheme {
            super::lower::runge_kutta(self, array, false, &mut forms.form[0]);
        }
        let second_order = self.second_order() || matches!(self.scheme, Scheme::Partitioned { .. });
        let characteristic = match &self.scheme {
            Scheme::Partitioned { position, velocity } => Characteristic::of_pair(position, velocity),
            Scheme::Rosenbrock { .. } => Characteristic::of(&forms.form[1]),
            _ => Characteristic::of(&forms.form[0]),
        };
        let form = forms.form[0];
        let pair = matches!(self.scheme, Scheme::RungeKutta(_)) && form.explicit() && form.errors > 0;
        Stability { characteristic, pair: pair.then_some(form), second_order, tolerance: self.tolerance() }
    }

    /// Decimals are as good as their digits, exact entries as the arithmetic.
    pub(super) fn tolerance(&self) -> f64 {
        if self.digits == 0 { 1e-28 } else { 10f64.powi(-(self.digits as i32)).max(1e-28) }
    }
}

impl Stability {
    /// Whether z stands for -(h omega)^2.
    pub fn second_order(&self) -> bool {
        self.second_order
    }

    /// By how much a step multiplies what is carried, in the long run: the largest |w| of the characteristic
    /// polynomial; |R(z)| of a one-step method.
    pub fn amplification(&self, z: Complex<f64>) -> f64 {
        let exact = Exact(D::of(z.re), D::of(z.im));
        let p: Vec<_> =
            self.characteristic.at(exact).iter().map(|c| Complex::new(c.0.hi(), c.1.hi())).collect();
        let Some((&lead, rest)) = p.split_last() else { return 0.0 };
        let monic: Vec<_> = rest.iter().map(|&c| c / lead).chain([Complex::ONE]).collect();
        match monic.iter().all(|c| c.is_finite()) {
            true => roots(&monic).iter().map(|w| w.norm()).fold(0.0, f64::max),
            // A pole.
            false => f64::INFINITY,
        }
    }

    /// Whether the region holds z: no root of the characteristic polynomial lies outside the unit disc, and
    /// those on its border are simple.
    pub fn stable(&self, z: Complex<f64>) -> bool {
        self.characteristic.stable(Exact(D::of(z.re), D::of(z.im)), self.tolerance)
    }

    /// How far the stable stretch of the ray from 0 reaches that makes this angle with the negative real axis:
    /// 0 where none is, infinite where all is stable. Of a method for y'' = -omega^2 y: the largest h omega,
    /// whatever the angle.
    pub fn limit(&self, degrees: f64) -> f64 {
        let near = self.tolerance;
        if self.second_order {
            return self.characteristic.oscillation(near);
        }
        match degrees.abs() {
            0.0 => self.characteristic.real(near),
            90.0 => self.characteristic.imaginary(near),
            angle => self.characteristic.along(angle, near),
        }
    }

    /// The spectral radius of step and controller together at a point z of the region's border, where the
    /// solution neither grows nor falls and the error estimate alone sets the step: below 1, the step settles
    /// there; above, it swings across the border and steps are rejected (Hall 1985, ACM TOMS 11, 289; Gustafsson
    /// 1991; Hairer, Wanner II, IV.2). `None` for methods without embedded rows, with implicit stages, or
    /// with a history.
    pub fn step_control(&self, z: Complex<f64>, controller: &Controller) -> Option<f64> {
        let form = self.pair.as_ref()?;
        let (r, e) = responses(form, z);
        let k = (estimate_power(form)) as f64;
        let [b1, b2, b3] = controller.errors.map(|b| b / k);
        let a2 = controller.steps;
        // In logarithms, off the fixed point: y' = y + r h, e' = y + e h and
        // h' = h - b1 e' - b2 e - b3 e'' - a2 (h - h''), with e, h'' and e'' those of the steps before.
        let matrix = nalgebra::SMatrix::<f64, 5, 5>::from_row_slice(&[
            1.0,
            r,
            0.0,
            0.0,
            0.0, // y
            -b1,
            1.0 - a2 - b1 * e,
            a2,
            -b2,
            -b3, // h
            0.0,
            1.0,
            0.0,
            0.0,
            0.0, // the last h
            1.0,
            e,
            0.0,
            0.0,
            0.0, // the last error
            0.0,
            0.0,
            0.0,
            1.0,
            0.0, // the last but one
        ]);
        Some(matrix.complex_eigenvalues().iter().map(|w| w.norm()).fold(0.0, f64::max))
    }
}

/// The power of h in the estimate: of two rows of different order, that of their combination.
fn estimate_power(form: &Form) -> usize {
    let of = |k: usize| form.embedded[k].min(form.order) + 1;
    if form.errors == 2 && form.embedded[0] != form.embedded[1] { 2 * of(0) - of(1) } else { of(0) }
}

/// d log|R| / d log h and d log|E| / d log h, E being the estimate for y = 1.
fn responses(form: &Form, z: Complex<f64>) -> (f64, f64) {
    // Of each source, its value and z times its derivative.
    let mut sources = vec![(Complex::ONE, Complex::ZERO)];
    let combine = |row: &super::form::Row, sources: &[(Complex<f64>, Complex<f64>)]| {
        let from = row.base.map_or((Complex::ZERO, Complex::ZERO), |j| sources[j]);
        (0..row.len).fold(from, |sum, j| {
            let (a, x) = (row.a[j].hi(), sources[row.at[j]]);
            (sum.0 + x.0 * a, sum.1 + x.1 * a)
        })
    };
    for stage in &form.stage[..form.s] {
        let y = combine(stage, &sources);
        sources.push((z * y.0, z * (y.0 + y.1)));
    }
    let y = combine(&form.carry[0], &sources);
    let errors: Vec<_> = form.error[..form.errors].iter().map(|row| combine(row, &sources)).collect();
    let relative = |x: (Complex<f64>, Complex<f64>)| (x.1 / x.0).re;
    let estimate = match errors[..] {
        [first, second] if form.embedded[0] != form.embedded[1] => {
            // e1^2 / sqrt(e1^2 + 0.01 e2^2)
            let (one, two) = (first.0.norm_sqr(), 0.01 * second.0.norm_sqr());
            let share = (one * relative(first) + two * relative(second)) / (one + two);
            2.0 * relative(first) - share
        }
        [first, second] if second.0.norm_sqr() > first.0.norm_sqr() => relative(second),
        _ => relative(errors[0]),
    };
    (relative(y), estimate)
}
