//! Order conditions of y'' = f(y): Nystrom arrays, and compositions of drifts and kicks.
//!
//! A tree's even levels are positions, its odd ones forces. With a position at the root it is a term of q
//! of weight 1/gamma at h^|t|, and the same term of h p has |t|/gamma. Order n: q to |t| = n, p to n + 1.

use std::collections::HashMap;

use super::exact::{Number, Rational, integer};
use super::file::{Array, File, Row, Scheme};
use super::report::Report;
use super::trees::{Tree, second_order};

pub fn check<N: Number>(file: &File, report: &mut Report) {
    let trees: Vec<Vec<Tree>> = (1..=file.order + 2).map(second_order).collect();
    let weights: HashMap<&Tree, [N; 2]> = match &file.scheme {
        Scheme::Nystrom { array, bbar } => nystrom(array, bbar, &trees),
        Scheme::Splitting(parts) => composition(parts, &trees),
        _ => return,
    };
    let mut sharpest: f64 = 0.0;
    for (order, trees) in (1..).zip(&trees) {
        for tree in trees {
            let exact = [tree.weight(), tree.weight() * integer(order as i64)];
            for (k, (computed, exact)) in weights[tree].iter().zip(&exact).enumerate() {
                let off = computed.minus(exact).size();
                // The velocity is one power of h ahead of its tree.
                let of_order = order - k;
                if of_order > file.order {
                    sharpest = sharpest.max(if of_order == file.order + 1 { off } else { 0.0 });
                } else if !report.expect(off, || {
                    let row = ["position", "velocity"][k];
                    format!("{row}: the order {of_order} condition of the tree {tree}")
                }) {
                    return;
                }
            }
        }
    }
    report.expect_sharp("the step", file.order, sharpest);
}

/// Weights of every tree in (q, h p) after one step; smaller trees come first in `trees`.
fn composition<'t, N: Number>(
    parts: &[(bool, Rational)],
    trees: &'t [Vec<Tree>],
) -> HashMap<&'t Tree, [N; 2]> {
    let [zero, one] = [0, 1].map(|n| N::of(&integer(n)));
    // At the start q = y, h p = v: of all trees only v, the single node, has a weight, in p.
    let start =
        |t: &'t Tree| (t, [zero.clone(), if t.children.is_empty() { one.clone() } else { zero.clone() }]);
    let mut weights: HashMap<&Tree, [N; 2]> = trees.iter().flatten().map(start).collect();
    for (kick, w) in parts {
        let w = N::of(w);
        if *kick {
            // p += w h f(q): the force's children are terms of q, which a kick leaves as it is.
            for tree in trees.iter().flatten().filter(|t| !t.children.is_empty()) {
                let children = &tree.children[0].children;
                let product = children.iter().fold(w.clone(), |product, u| product.times(&weights[u][0]));
                let p = &mut weights.get_mut(tree).unwrap()[1];
                *p = p.plus(&product);
            }
        } else {
            for [q, p] in weights.values_mut() {
                *q = q.plus(&p.times(&w));
            }
        }
    }
    weights
}

/// Weights of every tree in (q, h p) after one step of stages Q_i = y + c_i h v + h^2 sum a_ij f(Q_j).
fn nystrom<'t, N: Number>(array: &Array, bbar: &Row, trees: &'t [Vec<Tree>]) -> HashMap<&'t Tree, [N; 2]> {
    let numbers = |row: &Row| row.iter().map(N::of).collect::<Vec<N>>();
    let dot = |row: &Row, x: &[N]| {
        numbers(row).iter().zip(x).fold(N::of(&integer(0)), |sum, (a, x)| sum.plus(&a.times(x)))
    };
    // Of each tree: its weight in every Q_i.
    let mut stages: HashMap<&Tree, Vec<N>> = HashMap::new();
    let mut weights = HashMap::new();
    for tree in trees.iter().flatten() {
        let Some(force) = tree.children.first() else {
            stages.insert(tree, numbers(&array.c));
            weights.insert(tree, [N::of(&integer(1)), N::of(&integer(1))]);
            continue;
        };
        let mut phi = vec![N::of(&integer(1)); array.stages];
        for child in &force.children {
            phi = phi.iter().zip(&stages[child]).map(|(x, y)| x.times(y)).collect();
        }
        stages.insert(tree, array.a.iter().map(|row| dot(row, &phi)).collect());
        weights.insert(tree, [dot(bbar, &phi), dot(&array.b, &phi)]);
    }
    weights
}
