//! Lowering of pairs of tables.

use super::double_double::DoubleDouble as D;
use super::form::{Form, Row, STAGES};
use super::lower::{finish, full, nystrom, with_diagonal};
use super::{Array, Tableau};

/// Two stages for each of the pair's, at the same Y: the first evaluates the stiff part of f, which the implicit
/// table weights, the second the rest. z = (y); stage i's slopes are the sources 1 + 2i and 2 + 2i.
pub(super) const fn imex(t: &Tableau, explicit: &Array, implicit: &Array, form: &mut Form) -> bool {
    let s = implicit.stages;
    if 2 * s > STAGES || full(implicit) {
        return false;
    }
    form.s = 2 * s;
    let mut i = 0;
    while i < s {
        let (own, row) = (1 + 2 * i, both(Some(0), &implicit.a[i], &explicit.a[i], s));
        form.c[2 * i] = implicit.c[i];
        form.c[2 * i + 1] = implicit.c[i];
        form.stage[2 * i] = with_diagonal(row, own);
        form.stage[2 * i + 1] = row;
        form.nonstiff[2 * i + 1] = true;
        i += 1;
    }
    form.carry[0] = both(Some(0), &implicit.b, &explicit.b, s);
    form.errors = implicit.lower;
    form.embedded = t.embedded;
    let mut e = 0;
    while e < implicit.lower {
        form.error[e] = both(
            None,
            &difference(&implicit.b, &implicit.bhat[e], s),
            &difference(&explicit.b, &explicit.bhat[e], s),
            s,
        );
        e += 1;
    }
    finish(t, form);
    true
}

/// base + h sum (stiff_i F_i + rest_i G_i), source by source.
const fn both(base: Option<usize>, stiff: &[D; STAGES], rest: &[D; STAGES], s: usize) -> Row {
    let (mut row, mut i) = (Row { base, ..Row::EMPTY }, 0);
    while i < s {
        row = row.with(1 + 2 * i, stiff[i], 1).with(2 + 2 * i, rest[i], 1);
        i += 1;
    }
    row
}

const fn difference(b: &[D; STAGES], bhat: &[D; STAGES], s: usize) -> [D; STAGES] {
    let (mut weights, mut i) = ([D::ZERO; STAGES], 0);
    while i < s {
        weights[i] = b[i].minus(bhat[i]);
        i += 1;
    }
    weights
}

/// q' = v, v' = f(t, q): with the velocities of the stages eliminated, a Nystrom method. `false` where its stages
/// would have to be found together.
pub(super) const fn partitioned(t: &Tableau, position: &Array, velocity: &Array, form: &mut Form) -> bool {
    let s = position.stages;
    let (mut array, mut i) = (*position, 0);
    array.b = velocity.b;
    while i < s {
        array.a[i] = times(&position.a[i], velocity, s);
        i += 1;
    }
    if full(&array) {
        return false;
    }
    nystrom(t, &array, &times(&position.b, velocity, s), D::ONE, form);
    true
}

/// A row of the positions' table times the velocities' table.
const fn times(row: &[D; STAGES], velocity: &Array, s: usize) -> [D; STAGES] {
    let (mut product, mut k) = ([D::ZERO; STAGES], 0);
    while k < s {
        let mut j = 0;
        while j < s {
            product[j] = product[j].plus(row[k].times(velocity.a[k][j]));
            j += 1;
        }
        k += 1;
    }
    product
}

#[cfg(test)]
mod tests {
    use crate::tableau::lower::tests::form;

    #[test]
    fn lobatto_pair_of_order_two_is_velocity_verlet() {
        let (pair, verlet) = (form("partitioned/lobatto-iiia-iiib2"), form("nystrom/velocity-verlet"));
        assert_eq!((pair.d, pair.s, pair.r), (2, 1, 3));
        assert!(pair.stage[0].equals(&verlet.stage[0]) && pair.carry[1].equals(&verlet.carry[1]));
    }

    #[test]
    fn a_stage_of_an_imex_pair_is_seen_by_both_parts() {
        let form = form("imex/kencarp4-imex");
        assert_eq!((form.s, form.r, form.errors), (12, 1, 1));
        for i in (0..form.s).step_by(2) {
            let (stiff, rest) = (&form.stage[i], &form.stage[i + 1]);
            assert!(!form.nonstiff[i] && form.nonstiff[i + 1]);
            assert_eq!(rest.len, stiff.len + (stiff.diagonal.hi() != 0.0) as usize);
            assert_eq!(form.c[i], form.c[i + 1]);
        }
    }
}
