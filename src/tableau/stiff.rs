//! The order that a method keeps on stiff problems, by the equation of Prothero and Robinson (1974).
//!
//! For y' = lambda (y - phi) + phi' a step from phi(t) misses phi(t + h) by sum_k E_k(z) h^k phi^(k) / k!, with
//! z = h lambda. As z goes to infinity E_k goes like z^-m; the smallest m wins, and with it the smallest k
//! (Hairer, Wanner II, IV.15).
//!
//! The errors e_n of a linear multistep formula follow sum_j (alpha_j - z beta_j) e_(n+j) = -d with the miss
//! d = C h^(p+1) phi^(p+1) of its order conditions. Where the start is forgotten e settles at d / (z sigma(1)): the
//! whole order is kept (Hairer, Wanner II, V.7).

use super::Array;
use super::double_double::DoubleDouble as D;
use super::form::STAGES;

/// What a method leaves of its order on a stiff problem: the error goes like h^order lambda^-damping.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct StiffOrder {
    pub order: usize,
    pub damping: usize,
}

/// Of a Runge-Kutta method, or with `gamma` of a Rosenbrock one. `at_infinity` is R there, with its sign. `None`
/// where no power shows up to the order, or where the error grows with lambda.
pub(super) fn stiff_order(
    array: &Array,
    gamma: Option<&Array>,
    order: usize,
    at_infinity: f64,
    tolerance: f64,
) -> Option<StiffOrder> {
    let error = |k: usize, z: f64| miss(array, gamma, k, D::of(z)).map(|x| x.abs().hi());
    let (mut best, zs): (Option<(usize, usize)>, _) = (None, [-1e4, -1e5]);
    for k in 1..=order + 1 {
        let (Some(near), Some(far)) = (error(k, zs[0]), error(k, zs[1])) else { return None };
        if far <= 1e3 * tolerance {
            continue;
        }
        let m = (near / far).log10().round();
        // A miss that grows with z leaves nothing.
        if m < 0.0 {
            return None;
        }
        let m = m as usize;
        if best.is_none_or(|(least, _)| m < least) {
            best = Some((m, k));
        }
    }
    // Misses of steps that R neither damps nor turns about add up.
    let sums = (at_infinity - 1.0).abs() < 1e-9;
    best.map(|(m, k)| StiffOrder { order: (k - sums as usize).saturating_sub(m), damping: m })
}

/// Of a linear multistep formula of some order, A(alpha)-stable for some `alpha`: else errors grow where z is large.
pub(super) fn of_formula(order: usize, alpha: f64) -> Option<StiffOrder> {
    (alpha > 0.0).then_some(StiffOrder { order, damping: 1 })
}

/// E_k(z): a step of 1 from 0 on y' = z (y - t^k) + k t^(k-1), less 1.
fn miss(array: &Array, gamma: Option<&Array>, k: usize, z: D) -> Option<D> {
    let n = array.stages;
    let weight = |i: usize, j: usize| array.a[i][j] + gamma.map_or(D::ZERO, |gamma| gamma.a[i][j]);
    let power = |c: D, k: usize| c.powi(k as u32);
    let factor = D::of_integer(k as i64);
    let slope_in_time = match k {
        1 => -z,
        2 => D::of_integer(2),
        _ => D::ZERO,
    };
    let mut matrix: Vec<Vec<D>> = (0..n)
        .map(|i| {
            let c = (0..n).fold(D::ZERO, |sum, j| sum + array.a[i][j]);
            let row = (0..n).map(|j| -(z * weight(i, j)) + if i == j { D::ONE } else { D::ZERO });
            let time = gamma.map_or(D::ZERO, |gamma| (0..n).fold(D::ZERO, |sum, j| sum + gamma.a[i][j]));
            let right = factor * power(c, k - 1) - z * power(c, k) + time * slope_in_time;
            row.chain([right]).collect()
        })
        .collect();
    let slopes = eliminate(&mut matrix)?;
    Some((0..n).fold(-D::ONE, |sum, i| sum + array.b[i] * slopes[i]))
}

/// Solves a linear system, its right-hand side in the last column.
fn eliminate(matrix: &mut [Vec<D>]) -> Option<[D; STAGES]> {
    let n = matrix.len();
    for column in 0..n {
        let size = |row: &usize| matrix[*row][column].abs().hi();
        let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        matrix.swap(column, pivot);
        if matrix[column][column].hi() == 0.0 {
            return None;
        }
        for row in column + 1..n {
            let share = matrix[row][column] / matrix[column][column];
            let (above, below) = matrix.split_at_mut(row);
            for (x, &pivot) in below[0][column..=n].iter_mut().zip(&above[column][column..=n]) {
                *x += -(share * pivot);
            }
        }
    }
    let mut x = [D::ZERO; STAGES];
    for i in (0..n).rev() {
        let rest = (i + 1..n).fold(matrix[i][n], |sum, j| sum - matrix[i][j] * x[j]);
        x[i] = rest / matrix[i][i];
    }
    Some(x)
}
