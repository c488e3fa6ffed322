//! Lowering of Rosenbrock methods, to the variables in which no product with the Jacobian is left.
//!
//! With F = Gamma k (Hairer, Wanner 1996, section IV.7, whose U is h F), the stages
//!
//! ```text
//! k_i = f(y + h sum_j alpha_ij k_j) + h J sum_j gamma_ij k_j + h gamma_i f_t,    gamma_i = sum_j gamma_ij
//! ```
//!
//! become, with L the inverse of Gamma,
//!
//! ```text
//! (I - h gamma_ii J) F_i = gamma_ii (f(y + h sum_j (alpha L)_ij F_j) - sum_(j<i) L_ij F_j + h gamma_i f_t)
//! ```

use super::double_double::DoubleDouble as D;
use super::form::{Form, Row, STAGES};
use super::inexact::inexact;
use super::lower::{finish, slopes};
use super::{Array, Tableau};

/// z = (y); F_i is source 1 + i.
pub(super) const fn rosenbrock(t: &Tableau, alpha: &Array, gamma: &Array, form: &mut Form) {
    let s = alpha.stages;
    let inverse = inverse(&gamma.a, s);
    form.linear = true;
    form.s = s;
    let mut i = 0;
    while i < s {
        form.c[i] = alpha.c[i];
        form.stage[i] = slopes(Some(0), 1, &times(&alpha.a[i], &inverse, s), s, 1);
        form.stage[i].diagonal = gamma.a[i][i];
        form.time[i] = gamma.c[i];
        let mut j = 0;
        while j < i {
            form.couple[i][j] = inverse[i][j].neg();
            j += 1;
        }
        i += 1;
    }
    let b = times(&alpha.b, &inverse, s);
    form.carry[0] = slopes(Some(0), 1, &b, s, 1);
    form.errors = alpha.lower;
    form.embedded = t.embedded;
    let mut e = 0;
    while e < alpha.lower {
        let (mut weights, mut i) = ([D::ZERO; STAGES], 0);
        while i < s {
            weights[i] = alpha.b[i].minus(alpha.bhat[e][i]);
            i += 1;
        }
        form.error[e] = slopes(None, 1, &times(&weights, &inverse, s), s, 1);
        e += 1;
    }
    form.dense_order = t.dense_order;
    form.powers = alpha.powers;
    let mut k = 0;
    while k < alpha.powers {
        let (mut weights, mut i) = ([D::ZERO; STAGES], 0);
        while i < s {
            weights[i] = alpha.dense[i][k];
            i += 1;
        }
        form.dense[k] = slopes(None, 1, &times(&weights, &inverse, s), s, 1);
        k += 1;
    }
    finish(t, form);
    // A stage's F is no slope of its Y here, and y' none of its stages.
    form.carry[0] = Row { last_y: false, ..form.carry[0] };
    form.inexact = inexact(t, alpha, gamma);
}

/// The inverse of a lower triangular matrix whose diagonal has no zero.
const fn inverse(a: &[[D; STAGES]; STAGES], s: usize) -> [[D; STAGES]; STAGES] {
    let (mut inverse, mut i) = ([[D::ZERO; STAGES]; STAGES], 0);
    while i < s {
        let mut row = times(&a[i], &inverse, i);
        let mut j = 0;
        while j < i {
            row[j] = row[j].over(a[i][i]).neg();
            j += 1;
        }
        row[i] = D::ONE.over(a[i][i]);
        inverse[i] = row;
        i += 1;
    }
    inverse
}

/// A row times the first `s` rows of a lower triangular matrix. Sums that cancel to their rounding are zero:
/// tables published in these variables come back as they were.
const fn times(row: &[D; STAGES], matrix: &[[D; STAGES]; STAGES], s: usize) -> [D; STAGES] {
    let (mut product, mut size) = ([D::ZERO; STAGES], [0.0; STAGES]);
    let mut k = 0;
    while k < s {
        let mut j = 0;
        while j <= k && row[k].hi() != 0.0 {
            let term = row[k].times(matrix[k][j]);
            product[j] = product[j].plus(term);
            size[j] += term.abs().hi();
            j += 1;
        }
        k += 1;
    }
    let mut j = 0;
    while j < s {
        if product[j].abs().hi() <= 1e-28 * size[j] {
            product[j] = D::ZERO;
        }
        j += 1;
    }
    product
}
