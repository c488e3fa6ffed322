//! Rooted trees, grown by grafting: every tree is a smaller one, its stump, with one more tree grafted on the
//! root. Grafts are made in ascending order, so each tree comes once and none can be forgotten.
//!
//! One rule serves every order d of the derivative: a root f counts d and carries any trees; the initial
//! y^(k), 0 < k < d, is a leaf of order k that carries nothing. With |t| the sum, the exact y(t_n + theta h)
//! has the coefficient theta^|t| / gamma(t), where gamma(t) = |t| (|t| - 1) .. (|t| - d + 1) times the
//! gamma of each child. For d = 1 these are Butcher's trees, for d = 2 the SN-trees of Hairer, Norsett,
//! Wanner I, II.14.

use super::error::Text;

/// Which trees a method's order is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// y' = f(t, y).
    Rooted,
    /// y' = f(t, y), the method having the Jacobian in its stages: the same trees, other weights.
    Rosenbrock,
    /// The same with any matrix A in place of the Jacobian: every vertex is an f or an A, and an A has one child
    /// (Hairer, Wanner II, IV.7). The exact solution knows no A: gamma is 0 where there is one.
    Inexact,
    /// y'' = f(t, y).
    Nystrom,
    /// y' = f(t, y) + g(t, y): every vertex is an f or a g.
    Coloured,
    /// q' = f(p), p' = g(q): f and g alternate from parent to child.
    Alternating,
}

#[derive(Clone, Copy)]
pub(super) struct Tree {
    pub order: usize,
    /// 0, or 1 where the root is a g or an A.
    pub colour: usize,
    pub children: usize,
    /// The tree without its last child, and that child; meaningless where there is none.
    pub stump: usize,
    pub graft: usize,
    /// How many of the last children are equal.
    repeats: i64,
    /// gamma of all children, multiplied.
    below: i64,
    /// 0 where the exact solution has no such tree.
    pub gamma: i64,
    /// The number of symmetries.
    pub sigma: i64,
}

impl Tree {
    pub const NONE: Tree = Tree {
        order: 0,
        colour: 0,
        children: 0,
        stump: 0,
        graft: 0,
        repeats: 0,
        below: 1,
        gamma: 1,
        sigma: 1,
    };
}

/// Highest order of a tree in the lists below.
const ROOTED: usize = 8;
const NYSTROM: usize = ROOTED + 1;
const COLOURED: usize = 6;

impl Kind {
    /// Order of the derivative.
    pub const fn d(self) -> usize {
        match self {
            Kind::Nystrom => 2,
            _ => 1,
        }
    }

    /// Highest order of a method that the compiler proves; beyond it the trees are too many.
    pub const fn limit(self) -> usize {
        match self {
            Kind::Coloured | Kind::Alternating | Kind::Inexact => COLOURED,
            _ => ROOTED,
        }
    }

    /// All trees a proof to the limit needs, in ascending order.
    pub const fn trees(self) -> &'static [Tree] {
        const R: &[Tree] = &all::<200>(Kind::Rooted, ROOTED);
        const N: &[Tree] = &all::<80>(Kind::Nystrom, NYSTROM);
        const C: &[Tree] = &all::<1202>(Kind::Coloured, COLOURED);
        const A: &[Tree] = &all::<74>(Kind::Alternating, COLOURED);
        const I: &[Tree] = &all::<167>(Kind::Inexact, COLOURED);
        match self {
            Kind::Rooted | Kind::Rosenbrock => R,
            Kind::Nystrom => N,
            Kind::Coloured => C,
            Kind::Alternating => A,
            Kind::Inexact => I,
        }
    }

    /// All trees to any order.
    pub fn trees_to(self, order: usize) -> Vec<Tree> {
        let mut trees = vec![Tree::NONE; 256];
        loop {
            match grow(self, order, &mut trees) {
                Some(count) => {
                    trees.truncate(count);
                    return trees;
                }
                None => trees.resize(2 * trees.len(), Tree::NONE),
            }
        }
    }

    const fn colours(self) -> usize {
        match self {
            Kind::Coloured | Kind::Alternating | Kind::Inexact => 2,
            _ => 1,
        }
    }

    /// What a root multiplies gamma with, |t| (|t| - 1) .. (|t| - d + 1) of an f.
    const fn root(self, colour: usize, order: usize, d: usize) -> i64 {
        match self {
            Kind::Inexact if colour == 1 => 0,
            _ => falling(order, d),
        }
    }

    /// Whether `graft` may hang on the root of `stump` as its last child.
    const fn may_hang(self, stump: &Tree, graft: &Tree) -> bool {
        stump.order >= self.d()
            && match self {
                Kind::Alternating => stump.colour != graft.colour,
                // A childless A is a stump and no tree: it is listed, and its weight is zero.
                Kind::Inexact => {
                    !(stump.colour == 1 && stump.children == 1 || graft.colour == 1 && graft.children == 0)
                }
                _ => true,
            }
    }
}

const fn all<const N: usize>(kind: Kind, order: usize) -> [Tree; N] {
    let mut out = [Tree::NONE; N];
    match grow(kind, order, &mut out) {
        Some(count) if count == N => out,
        _ => panic!("the number of trees is wrong"),
    }
}

/// |t| (|t| - 1) .. (|t| - d + 1), 0 where |t| < d.
pub(super) const fn falling(order: usize, d: usize) -> i64 {
    let (mut product, mut k) = (1, 0);
    while k < d {
        product *= order as i64 - k as i64;
        k += 1;
    }
    product
}

/// Writes all trees to an order into `out`; `None` where they are more than it holds.
const fn grow(kind: Kind, order: usize, out: &mut [Tree]) -> Option<usize> {
    let d = kind.d();
    let (mut count, mut n) = (0, 1);
    while n <= order {
        let smaller = count;
        // A leaf y^(n) where n < d; a root f without children where n = d.
        let mut colour = 0;
        while n <= d && colour < kind.colours() {
            if count == out.len() {
                return None;
            }
            let gamma = kind.root(colour, n, n);
            out[count] = Tree { order: n, colour, gamma, ..Tree::NONE };
            count += 1;
            colour += 1;
        }
        let mut u = 0;
        while u < smaller {
            let stump = out[u];
            let mut v = if stump.children > 0 { stump.graft } else { 0 };
            while v < smaller && stump.order + out[v].order <= n {
                let graft = out[v];
                if stump.order + graft.order == n && kind.may_hang(&stump, &graft) {
                    if count == out.len() {
                        return None;
                    }
                    let repeats = if stump.children > 0 && stump.graft == v { stump.repeats + 1 } else { 1 };
                    let below = stump.below * graft.gamma;
                    out[count] = Tree {
                        order: n,
                        colour: stump.colour,
                        children: stump.children + 1,
                        stump: u,
                        graft: v,
                        repeats,
                        below,
                        gamma: kind.root(stump.colour, n, d) * below,
                        sigma: stump.sigma * graft.sigma * repeats,
                    };
                    count += 1;
                }
                v += 1;
            }
            u += 1;
        }
        n += 1;
    }
    Some(count)
}

/// A tree as nested brackets, one pair for each f: `[[][]]`; a g or an A is `()`, the initial y' is `v`.
pub(super) const fn write(text: Text, trees: &[Tree], t: usize, d: usize) -> Text {
    if trees[t].order < d {
        return text.str("v");
    }
    let (open, close) = if trees[t].colour == 0 { ("[", "]") } else { ("(", ")") };
    write_children(text.str(open), trees, t, d).str(close)
}

const fn write_children(text: Text, trees: &[Tree], t: usize, d: usize) -> Text {
    if trees[t].children == 0 {
        return text;
    }
    write(write_children(text, trees, trees[t].stump, d), trees, trees[t].graft, d)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(kind: Kind, order: usize) -> Vec<usize> {
        let trees = kind.trees_to(order);
        (1..=order).map(|n| trees.iter().filter(|t| t.order == n).count()).collect()
    }

    #[test]
    fn trees_are_as_many_as_the_literature_counts() {
        // Hairer, Norsett, Wanner I, table II.2.1 and II.14.1; OEIS A000081 and A038055.
        assert_eq!(counts(Kind::Rooted, 10), [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]);
        assert_eq!(counts(Kind::Coloured, 6), [2, 4, 14, 52, 214, 916]);
        assert_eq!(counts(Kind::Alternating, 6), [2, 2, 4, 8, 18, 40]);
        // Hairer, Wanner II, IV.7: 1, 3, 8, 21, 58, 166 conditions to each order. The stump is one more.
        assert_eq!(counts(Kind::Inexact, 6), [2, 2, 5, 13, 37, 108]);
        let snt: Vec<_> = (2..=9).map(|n| Kind::Nystrom.trees_to(n).len()).collect();
        assert_eq!(snt, [2, 3, 5, 8, 14, 24, 44, 80]);
    }

    #[test]
    fn gamma_and_sigma_count_labellings() {
        // The number of monotonic labellings n! / (gamma sigma), summed, is (n - 1)!.
        let trees = Kind::Rooted.trees_to(9);
        let mut factorial = 1;
        for n in 1..=9 {
            let labellings: i64 = trees
                .iter()
                .filter(|t| t.order == n)
                .map(|t| {
                    assert_eq!(factorial * n as i64 % (t.gamma * t.sigma), 0);
                    factorial * n as i64 / (t.gamma * t.sigma)
                })
                .sum();
            assert_eq!(labellings, factorial);
            factorial *= n as i64;
        }
    }

    #[test]
    fn trees_are_written_as_brackets() {
        let text = |kind: Kind, t| write(Text::new(), kind.trees(), t, kind.d()).as_str().to_string();
        let rooted: Vec<_> = (0..8).map(|t| text(Kind::Rooted, t)).collect();
        assert_eq!(
            rooted,
            ["[]", "[[]]", "[[[]]]", "[[][]]", "[[[[]]]]", "[[[][]]]", "[[][[]]]", "[[][][]]"]
        );
        let nystrom: Vec<_> = (0..8).map(|t| text(Kind::Nystrom, t)).collect();
        assert_eq!(nystrom, ["v", "[]", "[v]", "[[]]", "[vv]", "[[v]]", "[v[]]", "[vvv]"]);
        assert_eq!(text(Kind::Alternating, 4), "[([])]");
    }
}
