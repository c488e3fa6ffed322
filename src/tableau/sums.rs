//! What must add up and what the trees do not see, or would name less plainly.

use super::double_double::DoubleDouble as D;
use super::error::{Broken, TableauError, Text};
use super::form::{Form, Meaning, STAGES};
use super::series::Forms;
use super::{Array, Scheme};

/// Row sums, and the weights of y.
pub(super) const fn sums(scheme: &Scheme, forms: &Forms, tolerance: f64) -> Result<(), TableauError> {
    let laws = match scheme {
        Scheme::RungeKutta(array) => row_sums(array, "", tolerance),
        Scheme::Imex { explicit, implicit } => {
            match row_sums(explicit, " of the explicit table", tolerance) {
                Ok(()) => row_sums(implicit, " of the implicit table", tolerance),
                error => error,
            }
        }
        Scheme::Partitioned { position, velocity } => {
            match row_sums(position, " of the position table", tolerance) {
                // The second table of a pair may state the nodes of the first.
                Ok(()) if !alike(&position.c, &velocity.c, position.stages) => {
                    row_sums(velocity, " of the velocity table", tolerance)
                }
                other => other,
            }
        }
        Scheme::Rosenbrock { gamma, .. } => one_gamma(gamma, tolerance),
        Scheme::PredictorCorrector { .. } => {
            // A corrector of low order is right with any prediction.
            let off = forms.form[0].c[0].minus(D::ONE).hi;
            close(off, tolerance, Text::new().str("the prediction is not at t + h"))
        }
        _ => Ok(()),
    };
    match laws {
        Ok(()) => weights_of_y(&forms.form[0], tolerance),
        error => error,
    }
}

/// NaN is not.
pub(super) const fn within(off: f64, tolerance: f64) -> bool {
    off.abs() <= tolerance
}

/// Refuses what is off by more than the tolerance.
const fn close(off: f64, tolerance: f64, what: Text) -> Result<(), TableauError> {
    if within(off, tolerance) {
        return Ok(());
    }
    Err(TableauError::new(Broken::RowSum, 0, off, what.str(": off by ").size(off)))
}

const fn alike(a: &[D; STAGES], b: &[D; STAGES], n: usize) -> bool {
    let mut i = 0;
    while i < n && a[i].hi == b[i].hi && a[i].lo == b[i].lo {
        i += 1;
    }
    i == n
}

const fn row_sums(array: &Array, whose: &str, tolerance: f64) -> Result<(), TableauError> {
    let (all, mut i) = (array.stages + array.extra, 0);
    while i < all {
        let (mut sum, mut j) = (D::ZERO, 0);
        while j < all {
            sum = sum.plus(array.a[i][j]);
            j += 1;
        }
        let row = Text::new().str("row ").number(i + 1).str(" of A").str(whose);
        match close(sum.minus(array.c[i]).hi, tolerance, row.str(" does not sum to its c")) {
            Ok(()) => i += 1,
            error => return error,
        }
    }
    Ok(())
}

/// All stages of a Rosenbrock method share one matrix, I - h gamma J.
const fn one_gamma(gamma: &Array, tolerance: f64) -> Result<(), TableauError> {
    let mut i = 1;
    while i < gamma.stages {
        let row = Text::new().str("row ").number(i + 1).str(" of gamma has another diagonal than the first");
        match close(gamma.a[i][i].minus(gamma.a[0][0]).hi, tolerance, row) {
            Ok(()) => i += 1,
            error => return error,
        }
    }
    Ok(())
}

/// The tree of order 0: whatever is no slope adds up to y, in every stage and in y'.
const fn weights_of_y(form: &Form, tolerance: f64) -> Result<(), TableauError> {
    let mut i = 0;
    while i <= form.s + form.extra {
        let row = if i == 0 { &form.carry[0] } else { &form.stage[i - 1] };
        let mut sum = if row.base.is_some() { D::ONE } else { D::ZERO };
        let mut j = 0;
        while j < row.len {
            if row.at[j] < form.r && matches!(form.means[row.at[j]], Meaning::Y(_)) {
                sum = sum.plus(row.a[j]);
            }
            j += 1;
        }
        let text = Text::new().str("the weights of y");
        let text = if i > 0 { text.str(" in stage ").number(i) } else { text };
        match close(sum.minus(D::ONE).hi, tolerance, text.str(" do not sum to 1")) {
            Ok(()) => i += 1,
            error => return error,
        }
    }
    Ok(())
}
