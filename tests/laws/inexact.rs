//! W-methods: what any matrix A in place of the Jacobian leaves of the orders of a Rosenbrock method. A vertex is an f
//! or an A, an A has one child, and a solution of order p weighs every tree with an A by zero up to order p (Hairer,
//! Wanner II, IV.7, theorem 7.7).

use std::path::Path;

use kutta::methods;
use kutta::tableau::Orders;

use super::exact::{Fixed, Number, Rational, integer};
use super::file::{File, Matrix, Row, Scheme};
use super::report::Report;
use super::trees::{Tree, two_coloured};

/// Trees of f, colour 0, and of A, colour 1.
fn trees(n: usize) -> Vec<Tree> {
    fn grows(t: &Tree) -> bool {
        (t.colour == 0 || t.children.len() == 1) && t.children.iter().all(grows)
    }
    two_coloured(n).into_iter().filter(grows).collect()
}

fn has_matrix(t: &Tree) -> bool {
    t.colour == 1 || t.children.iter().any(has_matrix)
}

/// Phi_i(t): under an f the product over the children u of sum_j alpha_ij Phi_j(u), under an A sum_j gamma_ij Phi_j(u).
fn phi<N: Number>(tree: &Tree, arrays: [&Matrix; 2]) -> Vec<N> {
    let mut phi = vec![N::of(&integer(1)); arrays[0].len()];
    for child in &tree.children {
        let inner = self::phi::<N>(child, arrays);
        for (x, row) in phi.iter_mut().zip(arrays[tree.colour]) {
            *x = x.times(&dot(row, &inner));
        }
    }
    phi
}

fn dot<N: Number>(row: &Row, x: &[N]) -> N {
    row.iter().zip(x).fold(N::of(&integer(0)), |sum, (a, x)| sum.plus(&N::of(a).times(x)))
}

/// The order that is left of a claimed one: of the weights of one solution, or of those of each power of theta.
fn left<N: Number>(
    file: &File,
    arrays: [&Matrix; 2],
    rows: &[(Option<usize>, Row)],
    claimed: usize,
) -> usize {
    let holds = |tree: &Tree| {
        let phi = phi::<N>(tree, arrays);
        rows.iter().all(|(power, b)| {
            let absent = has_matrix(tree) || power.is_some_and(|k| k != tree.order());
            let wanted = if absent { integer(0) } else { tree.weight() };
            dot(b, &phi).minus(&wanted).size() <= file.tolerance()
        })
    };
    (1..=claimed).take_while(|&n| trees(n).iter().all(holds)).count()
}

pub fn check(file: &File, report: &mut Report) {
    let Scheme::Rosenbrock { alpha, gamma, .. } = &file.scheme else { return };
    let arrays = [&alpha.a, gamma];
    let left = |rows: &[(Option<usize>, Row)], claimed: usize| match file.exact() {
        true => left::<Rational>(file, arrays, rows, claimed),
        false => left::<Fixed>(file, arrays, rows, claimed),
    };
    let solution = |b: &Row, claimed: usize| left(&[(None, b.clone())], claimed);
    let mut embedded = [0; 2];
    for (found, (b, &claimed)) in embedded.iter_mut().zip(alpha.bhat.iter().zip(&file.embedded)) {
        *found = solution(b, claimed);
    }
    let powers = alpha.dense.first().map_or(0, Row::len);
    let power = |k: usize| (Some(k + 1), alpha.dense.iter().map(|row| row[k].clone()).collect());
    let dense = left(&(0..powers).map(power).collect::<Vec<_>>(), file.dense_order);
    let wanted = Orders { step: solution(&alpha.b, file.order), embedded, dense };

    let name = Path::new(&file.path).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let table = methods::find(name).unwrap().tableau();
    let (found, derived) = (table.form().unwrap().inexact, table.properties());
    if found != wanted {
        report.say(format!("any matrix leaves the orders {wanted:?}, not {found:?}"));
    }
    let shown = (derived.w_order, &derived.w_embedded[..]);
    assert_eq!(shown, (Some(found.step), &found.embedded[..file.embedded.len()]), "{name}");
}

#[test]
fn trees_are_as_many_as_hairer_and_wanner_count() {
    let count: Vec<_> = (1..=5).map(|n| trees(n).len()).collect();
    assert_eq!(count, [1, 2, 5, 13, 37]);
}
