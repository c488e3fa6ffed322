//! Small laws that a table may fulfil.

use super::derive::Stages;
use super::double_double::DoubleDouble as D;
use super::form::{CARRIED, Form, Meaning, Row, STAGES};
use super::{Array, Splitting, Steps};

/// The last stage of a one-step method is its next step's first.
pub(super) fn fsal(form: &Form) -> bool {
    form.one_step() && form.means[..form.r].contains(&Meaning::F(0))
}

pub(super) fn sum(x: &[D]) -> D {
    x.iter().fold(D::ZERO, |sum, &x| sum + x)
}

pub(super) fn kind(a: &[[D; STAGES]; STAGES], n: usize) -> Stages {
    let any =
        |from: fn(usize) -> usize| (0..n).any(|i| a[i][from(i).min(n)..n].iter().any(|x| x.hi() != 0.0));
    match (any(|i| i), any(|i| i + 1)) {
        (false, _) => Stages::Explicit,
        (true, false) => Stages::Diagonal,
        (true, true) => Stages::Full,
    }
}

/// A of the positions' stages once those of the velocities are eliminated.
pub(super) fn product(position: &Array, velocity: &Array) -> [[D; STAGES]; STAGES] {
    let (mut product, n) = ([[D::ZERO; STAGES]; STAGES], position.stages);
    for (i, row) in product.iter_mut().enumerate().take(n) {
        for (k, a) in position.a[i].iter().enumerate().take(n).filter(|(_, a)| a.hi() != 0.0) {
            (0..n).for_each(|j| row[j] += *a * velocity.a[k][j]);
        }
    }
    product
}

pub(super) fn last_row_is(a: &[[D; STAGES]; STAGES], b: &[D; STAGES], n: usize, tolerance: f64) -> bool {
    (0..n).all(|j| (a[n - 1][j] - b[j]).abs().hi() <= tolerance)
}

/// B(q): sum b_i c_i^(k-1) = 1/k, and C(q): sum_j a_ij c_j^(k-1) = c_i^k / k, for k = 1 .. q.
pub(super) fn stage_order(array: &Array, tolerance: f64) -> usize {
    let n = array.stages;
    let holds = |k: u32| {
        let power = |row: &[D; STAGES]| (0..n).fold(D::ZERO, |sum, j| sum + row[j] * array.c[j].powi(k - 1));
        let is = |x: D, y: D| (x - y / D::of(f64::from(k))).abs().hi() <= tolerance;
        is(power(&array.b), D::ONE) && (0..n).all(|i| is(power(&array.a[i]), array.c[i].powi(k)))
    };
    (1..=2 * n as u32).take_while(|&k| holds(k)).count()
}

/// On y' = f(t) an estimate is a sum over the distinct nodes; it vanishes for every f where the weights at
/// each node add up to 0, as those of Fehlberg's 7(8) do. A Rosenbrock estimate has df/dt in it as well.
pub(super) fn blind(array: &Array, gamma: Option<&Array>, tolerance: f64) -> Vec<bool> {
    let n = array.stages;
    let c: Vec<D> = match gamma {
        Some(_) => array.a[..n].iter().map(|row| sum(&row[..n])).collect(),
        None => array.c[..n].to_vec(),
    };
    let blind = |bhat: &[D; STAGES]| {
        let e = |i: usize| array.b[i] - bhat[i];
        let steep = |i: usize| gamma.map_or(D::ZERO, |gamma| sum(&gamma.a[i][..n]));
        (0..n).all(|i| {
            let same = (0..n).filter(|&j| (c[j] - c[i]).abs().hi() <= tolerance);
            let (weight, slope) = same.fold((D::ZERO, D::ZERO), |(w, s), j| (w + e(j), s + e(j) * steep(j)));
            weight.abs().hi() <= tolerance && slope.abs().hi() <= tolerance
        })
    };
    array.bhat[..array.lower].iter().map(blind).collect()
}

/// What a step errs over its first estimate of that, the larger of two: on y' = -y with h = 1/10; and, of implicit
/// stages, on y' = lambda (y - t^k) + k t^(k-1), the slow motion of a stiff equation, over h lambda = -1, -2, -4, -8
/// together, k being the first power that is missed. Far above 1 the estimate says too little there. `None` without an
/// embedded row, or where stages are not found one after the other.
pub(crate) fn estimate_misses(form: &Form) -> Option<f64> {
    let known = form.means[..form.r].iter().all(|mean| matches!(mean, Meaning::Y(0) | Meaning::F(0)));
    if form.errors == 0 || form.d != 1 || form.linear || !known || matches!(form.stages(), Stages::Full) {
        return None;
    }
    let z = D::of(-1.0) / D::of(10.0);
    let exact = (1..=20).rev().fold(D::ONE, |sum, k| D::ONE + z / D::of_integer(k) * sum);
    let (end, estimate) = step_of_lambda(form, z, None);
    let alone = ((end - exact) / estimate).abs().hi();
    if form.explicit() {
        return Some(alone);
    }
    let forced = (2..=form.order as u32 + 1).find_map(|k| {
        let size = |x: D| x.hi() * x.hi();
        let sums = [-1.0, -2.0, -4.0, -8.0].iter().fold([0.0; 2], |[errors, estimates], &z| {
            let (end, estimate) = step_of_lambda(form, D::of(z), Some(k));
            [errors + size(end - D::ONE), estimates + size(estimate)]
        });
        (sums[0] > 1e-20).then(|| (sums[0] / sums[1]).sqrt())
    });
    Some(alone.max(forced.unwrap_or(0.0)))
}

/// The end and the estimate of a step of y' = z y from 1, h = 1; with a power k, of y' = z (y - t^k) + k t^(k-1) from
/// 0, which ends at 1. All of f is in the part that is not explicit.
fn step_of_lambda(form: &Form, z: D, power: Option<u32>) -> (D, D) {
    let mut x = [D::ZERO; CARRIED + STAGES];
    if power.is_none() {
        for (x, mean) in x.iter_mut().zip(&form.means[..form.r]) {
            *x = if matches!(mean, Meaning::Y(0)) { D::ONE } else { z };
        }
    }
    let value = |row: &Row, x: &[D]| {
        let base = row.base.map_or(D::ZERO, |base| x[base]);
        (0..row.len).fold(base, |sum, k| sum + row.a[k] * x[row.at[k]])
    };
    for i in (0..form.s).filter(|&i| !form.nonstiff[i]) {
        let (row, c) = (&form.stage[i], form.c[i]);
        let pull = power.map_or(D::ZERO, |k| D::of(f64::from(k)) * c.powi(k - 1) - z * c.powi(k));
        x[form.r + i] = (z * value(row, &x) + pull) / (D::ONE - z * row.diagonal);
    }
    let end = match form.carry[0].last_y {
        true => value(&form.stage[form.s - 1], &x) + form.stage[form.s - 1].diagonal * x[form.r + form.s - 1],
        false => value(&form.carry[0], &x),
    };
    (end, value(&form.error[0], &x))
}

/// b_i a^_ij + b^_j a_ji = b_i b^_j and b = b^; for a single array: Sanz-Serna 1988, Lasagni 1988.
pub(super) fn symplectic(one: &Array, other: &Array, tolerance: f64) -> bool {
    let n = one.stages;
    let off =
        |i: usize, j: usize| one.b[i] * other.a[i][j] + other.b[j] * one.a[j][i] - one.b[i] * other.b[j];
    (0..n).all(|i| {
        (one.b[i] - other.b[i]).abs().hi() <= tolerance && (0..n).all(|j| off(i, j).abs().hi() <= tolerance)
    })
}

/// The conditions of Suris (1988) for Runge-Kutta-Nystrom methods: bbar_i = b_i (1 - c_i) and
/// b_i (bbar_j - a_ij) = b_j (bbar_i - a_ji). Stage i is source 2 + i, whether it is shared with the last
/// step or not.
pub(super) fn canonical(form: &Form, tolerance: f64) -> bool {
    let first = fsal(form) as usize;
    let n = form.s + first;
    let weight = |row: &Row, at: usize| {
        (0..row.len).filter(|&j| row.at[j] == at).fold(D::ZERO, |sum, j| sum + row.a[j])
    };
    let a = |i: usize, j: usize| if i < first { D::ZERO } else { weight(&form.stage[i - first], 2 + j) };
    let c = |i: usize| if i < first { D::ZERO } else { weight(&form.stage[i - first], 1) };
    let (bbar, b) = (|i| weight(&form.carry[0], 2 + i), |i| weight(&form.carry[1], 2 + i));
    let small = |x: D| x.abs().hi() <= tolerance;
    (0..n).all(|i| {
        small(bbar(i) - b(i) * (D::ONE - c(i)))
            && (0..n).all(|j| small(b(i) * (bbar(j) - a(i, j)) - b(j) * (bbar(i) - a(j, i))))
    })
}

pub(super) fn palindrome(splitting: &Splitting, tolerance: f64) -> bool {
    let (n, w) = (splitting.len, &splitting.weight);
    (0..n).all(|i| {
        splitting.kick[i] == splitting.kick[n - 1 - i] && (w[i] - w[n - 1 - i]).abs().hi() <= tolerance
    })
}

/// C_q = (sum alpha_j j^q - q .. (q-d+1) sum beta_j j^(q-d)) / q!, q = p + d, over sigma(1).
pub(super) fn error_constant(steps: &Steps, d: usize, order: usize) -> f64 {
    let (q, all) = ((order + d) as u32, 0..=steps.k);
    let power = |j: usize, n: u32| D::of_integer(j as i64).powi(n);
    let y = all.clone().fold(D::ZERO, |sum, j| sum + steps.alpha[j] * power(j, q));
    let f = all.fold(D::ZERO, |sum, j| sum + steps.beta[j] * power(j, q - d as u32));
    let factor = |from: u32, to: u32| (from..=to).fold(D::ONE, |x, k| x * D::of(f64::from(k)));
    let c = (y - factor(q - d as u32 + 1, q) * f) / factor(1, q);
    (c / sum(&steps.beta[..=steps.k])).hi()
}
