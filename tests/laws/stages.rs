//! Order conditions of everything with stages: Runge-Kutta methods, pairs of arrays, Rosenbrock methods, and
//! their embedded rows and dense output.

use std::collections::HashMap;

use super::exact::{Number, Rational, integer};
use super::file::{Array, File, Matrix, Row, Scheme};
use super::report::Report;
use super::trees::{Tree, rooted, two_coloured};

/// Entries that are not zero, row by row.
type Sparse<N> = Vec<Vec<(usize, N)>>;

fn sparse<N: Number>(rows: &Matrix) -> Sparse<N> {
    let row = |row: &Row| row.iter().map(N::of).enumerate().filter(|(_, x)| !x.vanishes()).collect();
    rows.iter().map(row).collect()
}

fn dot<N: Number>(row: &[(usize, N)], x: &[N]) -> N {
    row.iter().fold(N::of(&integer(0)), |sum, (j, a)| sum.plus(&a.times(&x[*j])))
}

/// Elementary weights of the stages.
struct Weights<N> {
    /// For each colour of a child: its matrix under a father with other children, and as an only child.
    matrices: Vec<[Sparse<N>; 2]>,
    known: HashMap<(Tree, bool), Vec<N>>,
    stages: usize,
}

impl<N: Number> Weights<N> {
    /// Phi_i(t): the product over the children u of sum_j a_ij Phi_j(u).
    fn phi(&mut self, tree: &Tree) -> Vec<N> {
        let only = tree.children.len() == 1;
        let mut phi = vec![N::of(&integer(1)); self.stages];
        for child in &tree.children {
            let inner = self.inner(child, only);
            phi = phi.iter().zip(&inner).map(|(x, y)| x.times(y)).collect();
        }
        phi
    }

    fn inner(&mut self, tree: &Tree, only: bool) -> Vec<N> {
        let key = (tree.clone(), only);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let phi = self.phi(tree);
        let inner: Vec<N> =
            self.matrices[tree.colour][only as usize].iter().map(|row| dot(row, &phi)).collect();
        self.known.insert(key, inner.clone());
        inner
    }
}

/// One solution of a method: a name for messages, and for each power of theta the weights of each colour.
struct Solution<N> {
    name: String,
    rows: Vec<(Option<usize>, Sparse<N>)>,
    order: usize,
}

impl<N: Number> Solution<N> {
    fn fixed(name: String, weights: Matrix, order: usize) -> Self {
        Self { name, rows: vec![(None, sparse(&weights))], order }
    }

    /// y(theta) has theta^|t| / gamma(t) for every tree: zero at every other power.
    fn off<'a>(&'a self, tree: &'a Tree, phi: &'a [N]) -> impl Iterator<Item = (Option<usize>, f64)> + 'a {
        let order = tree.order();
        self.rows.iter().map(move |(power, weights)| {
            let wanted = if power.is_none_or(|k| k == order) { tree.weight() } else { integer(0) };
            (*power, dot(&weights[tree.colour], phi).minus(&wanted).size())
        })
    }
}

pub fn check<N: Number>(file: &File, report: &mut Report) {
    match &file.scheme {
        Scheme::RungeKutta(array) => {
            row_sums(array, "", report);
            solutions::<N>(file, &[array], None, rooted, report);
        }
        Scheme::Imex(arrays) | Scheme::Partitioned(arrays) => {
            let names = match file.scheme {
                Scheme::Imex(_) => ["explicit ", "implicit "],
                _ => ["position ", "velocity "],
            };
            arrays.iter().zip(names).for_each(|(array, name)| row_sums(array, name, report));
            solutions::<N>(file, &arrays.each_ref(), None, two_coloured, report);
        }
        Scheme::Rosenbrock { alpha, gamma, .. } => {
            // An only child hangs on alpha + gamma (Hairer, Wanner II, IV.7, theorem 7.4).
            let add = |(x, y): (&Row, &Row)| x.iter().zip(y).map(|(x, y)| x + y).collect();
            let both = alpha.a.iter().zip(gamma).map(add).collect();
            solutions::<N>(file, &[alpha], Some(&both), rooted, report);
        }
        _ => {}
    }
}

fn row_sums(array: &Array, name: &str, report: &mut Report) {
    for (i, (row, c)) in array.a.iter().zip(&array.c).enumerate() {
        let off = (row.iter().sum::<Rational>() - c).size();
        report.expect(off, || format!("the sum of row {} of the {name}array", i + 1));
    }
}

fn solutions<N: Number>(
    file: &File,
    arrays: &[&Array],
    only_child: Option<&Matrix>,
    trees: fn(usize) -> Vec<Tree>,
    report: &mut Report,
) {
    let mut weights = Weights::<N> {
        matrices: arrays.iter().map(|array| [&array.a, only_child.unwrap_or(&array.a)].map(sparse)).collect(),
        known: HashMap::new(),
        stages: arrays[0].a.len(),
    };
    let rows = |row: &dyn Fn(&Array) -> Row| arrays.iter().map(|array| row(array)).collect::<Matrix>();
    let mut list = vec![Solution::fixed("b".to_string(), rows(&|array| array.b.clone()), file.order)];
    for array in arrays {
        assert_eq!(array.bhat.len(), file.embedded.len(), "{}: an order for each embedded row", file.path);
    }
    for (i, &order) in file.embedded.iter().enumerate() {
        list.push(Solution::fixed(format!("bhat {}", i + 1), rows(&|array| array.bhat[i].clone()), order));
    }
    if file.dense_order > 0 {
        let [array] = arrays else { panic!("{}: dense output of a pair", file.path) };
        let power = |k: usize| sparse(&vec![array.dense.iter().map(|row| row[k].clone()).collect()]);
        let rows = (0..array.dense[0].len()).map(|k| (Some(k + 1), power(k))).collect();
        list.push(Solution { name: "dense output".to_string(), rows, order: file.dense_order });
        // theta = 1 is the end of the step.
        for (i, row) in array.dense.iter().enumerate() {
            let off = (row.iter().sum::<Rational>() - &array.b[i]).size();
            report.expect(off, || format!("the weight of stage {} in the dense output at theta = 1", i + 1));
        }
    }
    for solution in &list {
        prove(solution, &mut weights, trees, report);
    }
}

/// Stops at the first broken condition: it breaks most of those above it.
fn prove<N: Number>(
    solution: &Solution<N>,
    weights: &mut Weights<N>,
    trees: fn(usize) -> Vec<Tree>,
    report: &mut Report,
) {
    let mut sharpest: f64 = 0.0;
    for order in 1..=solution.order + 1 {
        for tree in trees(order) {
            let phi = weights.phi(&tree);
            for (power, off) in solution.off(&tree, &phi) {
                if order > solution.order {
                    sharpest = sharpest.max(off);
                } else if !report.expect(off, || {
                    let at = power.map_or(String::new(), |k| format!(" at theta^{k}"));
                    format!("{}: the order {order} condition of the tree {tree}{at}", solution.name)
                }) {
                    return;
                }
            }
        }
    }
    report.expect_sharp(&solution.name, solution.order, sharpest);
}
