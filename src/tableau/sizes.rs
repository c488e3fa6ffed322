//! How large: the local error, the weights, and the table with its numbers rounded.

use super::double_double::DoubleDouble as D;
use super::form::{Form, Meaning, Row};
use super::series::{Defect, Forms};

/// Root of the sum of squares over the trees of the highest order.
pub(super) fn norm(defects: &[Defect]) -> f64 {
    let order = defects.last().map_or(0, |defect| defect.order);
    let highest = defects.iter().filter(|defect| defect.order == order);
    highest.map(|defect| (defect.off.hi() / defect.sigma as f64).powi(2)).sum::<f64>().sqrt()
}

pub(super) fn rounded(mut forms: Forms, round: fn(D) -> D) -> Forms {
    let each = |row: &mut Row| {
        row.a.iter_mut().for_each(|a| *a = round(*a));
        row.diagonal = round(row.diagonal);
    };
    forms.form.iter_mut().for_each(|form| form.stage.iter_mut().chain(&mut form.carry).for_each(each));
    forms
}

/// The weights of slopes in a row, the row's own among them.
fn slopes<'f>(form: &'f Form, row: &'f Row) -> impl Iterator<Item = D> + 'f {
    let slope = |at: usize| at >= form.r || matches!(form.means[at], Meaning::F(_));
    let terms = (0..row.len).filter(move |&j| slope(row.at[j])).map(|j| row.a[j].abs());
    terms.chain([row.diagonal.abs()])
}

/// Of the row whose terms are slopes times h: y', or the velocity of y'' = f.
pub(super) fn amplification(forms: &Forms) -> f64 {
    let of = |form: &Form| {
        let row = (0..form.r).find(|&j| form.means[j] == Meaning::V).unwrap_or(0);
        slopes(form, &form.carry[row]).fold(D::ZERO, |sum, a| sum + a).hi()
    };
    forms.form.iter().map(of).fold(0.0, f64::max)
}

pub(super) fn largest_a(forms: &Forms) -> f64 {
    let rows = forms.form.iter().flat_map(|form| form.stage[..form.s].iter().map(move |row| (form, row)));
    rows.flat_map(|(form, row)| slopes(form, row)).map(D::hi).fold(0.0, f64::max)
}
