//! Rooted trees from level sequences (Beyer, Hedetniemi 1980), plain, two-coloured, and for y'' = f(y).

use std::collections::BTreeSet;
use std::fmt;

use super::exact::{Rational, integer};

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tree {
    pub colour: usize,
    pub children: Vec<Tree>,
}

impl Tree {
    fn of_levels(levels: &[usize]) -> Self {
        let mut children = Vec::new();
        let mut from = 1;
        while from < levels.len() {
            let same = levels[from + 1..].iter().position(|&l| l <= levels[from]);
            let to = same.map_or(levels.len(), |n| from + 1 + n);
            children.push(Self::of_levels(&levels[from..to]));
            from = to;
        }
        Self { colour: 0, children }
    }

    pub fn order(&self) -> usize {
        1 + self.children.iter().map(Self::order).sum::<usize>()
    }

    /// gamma(t): the product of the orders of all subtrees.
    pub fn density(&self) -> i64 {
        self.children.iter().map(Self::density).product::<i64>() * self.order() as i64
    }

    /// 1/gamma(t), the weight of t in the exact solution.
    pub fn weight(&self) -> Rational {
        integer(1) / integer(self.density())
    }

    /// The nodes take the binary digits of `colours` in turn. Children are sorted: equal trees become equal.
    fn coloured(&self, colours: &mut usize) -> Self {
        let colour = *colours & 1;
        *colours >>= 1;
        let mut children: Vec<_> = self.children.iter().map(|t| t.coloured(colours)).collect();
        children.sort();
        Self { colour, children }
    }

    /// Whether the nodes at even depth have one child at most: the tree belongs to q' = p, p' = f(q).
    fn alternates(&self, depth: usize) -> bool {
        (depth % 2 == 1 || self.children.len() <= 1) && self.children.iter().all(|t| t.alternates(depth + 1))
    }
}

/// Butcher's brackets; the second colour is written with braces.
impl fmt::Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(["[", "{"][self.colour])?;
        self.children.iter().try_for_each(|t| t.fmt(f))?;
        f.write_str(["]", "}"][self.colour])
    }
}

/// All rooted trees with n nodes: canonical level sequences in falling order, from the path to the star.
pub fn rooted(n: usize) -> Vec<Tree> {
    let mut levels: Vec<usize> = (0..n).collect();
    let mut trees = Vec::new();
    loop {
        trees.push(Tree::of_levels(&levels));
        let Some(last) = levels.iter().rposition(|&l| l > 1) else { return trees };
        let parent = levels[..last].iter().rposition(|&l| l + 1 == levels[last]).unwrap();
        for i in last..n {
            levels[i] = levels[i - (last - parent)];
        }
    }
}

/// All rooted trees with n nodes of two colours.
pub fn two_coloured(n: usize) -> Vec<Tree> {
    let mut trees = BTreeSet::new();
    for tree in rooted(n) {
        for colours in 0..1 << n {
            trees.insert(tree.coloured(&mut { colours }));
        }
    }
    trees.into_iter().collect()
}

/// The trees of y'' = f(y) with n nodes: positions at even depth, forces at odd depth.
pub fn second_order(n: usize) -> Vec<Tree> {
    rooted(n).into_iter().filter(|t| t.alternates(0)).collect()
}

#[test]
fn trees_are_as_many_as_the_literature_counts() {
    let count = |trees: fn(usize) -> Vec<Tree>, to| (1..=to).map(|n| trees(n).len()).collect::<Vec<_>>();
    // Hairer, Norsett, Wanner I, table II.2.1, and Sloane's A000081, A000151 and A007562.
    assert_eq!(count(rooted, 11), [1, 1, 2, 4, 9, 20, 48, 115, 286, 719, 1842]);
    assert_eq!(count(two_coloured, 6), [2, 4, 14, 52, 214, 916]);
    assert_eq!(count(second_order, 11), [1, 1, 1, 2, 3, 6, 10, 20, 36, 72, 137]);
    // All trees, each once: the n!/(sigma gamma) count the (n - 1)! monotone labellings (Butcher 2016, 302b).
    for n in 1..=10 {
        let labelled = |t: &Tree| factorial(n) / (symmetry(t) * t.density());
        assert_eq!(rooted(n).iter().map(labelled).sum::<i64>(), factorial(n - 1));
        assert_eq!(rooted(n).into_iter().collect::<BTreeSet<_>>().len(), rooted(n).len());
    }
}

fn factorial(n: usize) -> i64 {
    (1..=n as i64).product()
}

/// sigma(t), for children that stand sorted.
fn symmetry(t: &Tree) -> i64 {
    let equal = t.children.chunk_by(|s, t| s == t);
    equal.map(|same| same.iter().map(symmetry).product::<i64>() * factorial(same.len())).product()
}
