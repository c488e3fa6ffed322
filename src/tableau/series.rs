//! B-series: what a method makes of every tree, given the exact solution to start from.
//!
//! With eta_i the stages' coefficients and zeta_j those of the carried vectors, a stage's row gives
//! eta_i(t) = sum u_ij zeta_j(t) + sum a_ij D_j(t), where D_j(t), the coefficient of h^d F_j, is the product of
//! eta_j over the children of t. So trees in ascending order need no equation solved, implicit stages or not.

use super::double_double::DoubleDouble as D;
use super::form::{CARRIED, Form, Meaning, Row, STAGES};
use super::lower;
use super::trees::{Kind, Tree, falling};
use super::{Array, Scheme, Tableau};

/// What the trees are evaluated on: the one form; one for each colour of a vertex, with the same stages; or
/// that of alpha and that of alpha + gamma for a Rosenbrock method, of alpha and of gamma with any matrix.
#[derive(Clone, Copy)]
pub(super) struct Forms {
    pub kind: Kind,
    pub form: [Form; 2],
}

impl Forms {
    pub const fn of(t: &Tableau) -> Forms {
        let mut forms = Forms { kind: Kind::Rooted, form: [lower::BLANK; 2] };
        let [form, other] = &mut forms.form;
        match &t.scheme {
            Scheme::Imex { explicit, implicit } => {
                lower::runge_kutta(t, explicit, false, form);
                lower::runge_kutta(t, implicit, false, other);
                forms.kind = Kind::Coloured;
            }
            Scheme::Partitioned { position, velocity } => {
                lower::runge_kutta(t, position, false, form);
                lower::runge_kutta(t, velocity, false, other);
                forms.kind = Kind::Alternating;
            }
            Scheme::Rosenbrock { alpha, gamma } => {
                let (mut beta, mut i) = (*alpha, 0);
                while i < alpha.stages {
                    let mut j = 0;
                    while j < alpha.stages {
                        beta.a[i][j] = alpha.a[i][j].plus(gamma.a[i][j]);
                        j += 1;
                    }
                    i += 1;
                }
                lower::runge_kutta(t, alpha, false, form);
                lower::runge_kutta(t, &beta, false, other);
                forms.kind = Kind::Rosenbrock;
            }
            // The member of the highest order stands for its family.
            Scheme::Nordsieck(members) => {
                lower::lower_to(&members.of(t, members.count), form);
            }
            _ => {
                lower::lower_to(t, form);
                forms.kind = if form.d == 2 { Kind::Nystrom } else { Kind::Rooted };
            }
        }
        forms
    }

    /// Those of a Rosenbrock method with any matrix in place of the Jacobian.
    pub const fn inexact(t: &Tableau, alpha: &Array, gamma: &Array) -> Forms {
        let mut forms = Forms { kind: Kind::Inexact, form: [lower::BLANK; 2] };
        lower::runge_kutta(t, alpha, false, &mut forms.form[0]);
        lower::runge_kutta(t, &Array { a: gamma.a, ..*alpha }, false, &mut forms.form[1]);
        forms
    }

    /// The form whose rows weight the slopes of a tree.
    pub const fn of_colour(&self, colour: usize) -> &Form {
        match self.kind {
            Kind::Coloured | Kind::Alternating => &self.form[colour],
            _ => &self.form[0],
        }
    }
}

/// The coefficients of one tree in the sources of a row: those of z_j at t_n, then those of h^d F_i.
pub(super) type Sources = [D; CARRIED + STAGES];

/// What a row makes of a tree; `own` is the source that the diagonal multiplies.
///
/// The sum of products is compensated (Ogita, Rump, Oishi 2005, algorithm 5.3, with both parts of the factors):
/// as accurate as double-double sums, in a third of the operations. The compiler interprets them one by one.
pub(super) const fn apply(row: &Row, x: &Sources, own: usize) -> D {
    let (mut sum, mut rest) = match row.base {
        Some(j) => (x[j].hi, x[j].lo),
        None => (0.0, 0.0),
    };
    let mut i = 0;
    while i <= row.len {
        let (a, x) = if i < row.len { (row.a[i], x[row.at[i]]) } else { (row.diagonal, x[own]) };
        if x.hi != 0.0 && a.hi != 0.0 {
            let p = a.hi * x.hi;
            let s = sum + p;
            let c = s - sum;
            rest += a.hi.mul_add(x.hi, -p) + (a.hi * x.lo + a.lo * x.hi) + ((sum - (s - c)) + (p - c));
            sum = s;
        }
        i += 1;
    }
    D::sum(sum, rest)
}

/// gamma times the exact solution's coefficient of a tree of order n in a carried vector, `later` steps after
/// t_n.
const fn exact(meaning: Meaning, later: i64, n: usize, d: usize) -> D {
    let (derivative, back) = match meaning {
        Meaning::Y(k) => (0, k),
        Meaning::F(k) => (d, k),
        Meaning::V => (1, 0),
        // Carried by families alone, whose members are proven one by one.
        Meaning::Taylor(_) => return D::ZERO,
    };
    if n < derivative {
        return D::ZERO;
    }
    let theta = D::of_integer(later - back as i64);
    D::of_integer(falling(n, derivative)).times(theta.powi((n - derivative) as u32))
}

/// Evaluates a method on one tree after the other.
pub(super) struct Series<'m> {
    pub forms: &'m Forms,
    pub trees: &'m [Tree],
    /// Of the tree at hand: what the rows combine, and the exact y one step later, 1 / gamma.
    pub x: Sources,
    pub exact: D,
    /// `exact` at t_n and one step later, for this order.
    order: usize,
    of_order: [[D; CARRIED]; 2],
    /// The smaller trees, which the larger ones are made of: their coefficients, and those of the stages.
    smaller: &'m mut [Sources],
    eta: &'m mut [[D; STAGES]],
}

impl<'m> Series<'m> {
    /// `smaller` and `eta` hold as many trees as others can be made of.
    pub const fn new(
        forms: &'m Forms,
        trees: &'m [Tree],
        smaller: &'m mut [Sources],
        eta: &'m mut [[D; STAGES]],
    ) -> Self {
        let (x, of_order) = ([D::ZERO; CARRIED + STAGES], [[D::ZERO; CARRIED]; 2]);
        Self { forms, trees, x, exact: D::ONE, order: 0, of_order, smaller, eta }
    }

    /// The exact z_j one step later.
    pub const fn later(&self, j: usize) -> D {
        self.of_order[1][j].times(self.exact)
    }

    /// Tree t; all before it must have been evaluated.
    pub const fn evaluate(&mut self, t: usize) {
        let (tree, d) = (&self.trees[t], self.forms.kind.d());
        let form = self.forms.of_colour(tree.colour);
        self.x = [D::ZERO; CARRIED + STAGES];
        self.exact = match tree.gamma {
            0 => D::ZERO,
            gamma => D::ONE.over(D::of_integer(gamma)),
        };
        let mut j = 0;
        while j < form.r {
            if self.order != tree.order {
                self.of_order[0][j] = exact(form.means[j], 0, tree.order, d);
                self.of_order[1][j] = exact(form.means[j], 1, tree.order, d);
            }
            self.x[j] = self.of_order[0][j].times(self.exact);
            j += 1;
        }
        self.order = tree.order;
        let all = if tree.order <= form.dense_order { form.s + form.extra } else { form.s };
        let rosenbrock = matches!(self.forms.kind, Kind::Rosenbrock);
        let by_matrix = match self.forms.kind {
            Kind::Rosenbrock => tree.children == 1,
            Kind::Inexact => tree.colour == 1,
            _ => false,
        };
        let (r, mut i) = (form.r, 0);
        while i < all {
            self.x[r + i] = if tree.children == 0 {
                if tree.order == d && tree.gamma != 0 { D::ONE } else { D::ZERO }
            } else if by_matrix {
                // J times the increments: an only child is weighted with alpha + gamma. A times them: with gamma.
                apply(&self.forms.form[1].stage[i], &self.smaller[tree.graft], r + i)
            } else {
                let stump = &self.trees[tree.stump];
                let product = if rosenbrock && stump.children == 1 {
                    self.eta[stump.graft][i]
                } else {
                    self.smaller[tree.stump][r + i]
                };
                if product.hi == 0.0 { product } else { product.times(self.eta[tree.graft][i]) }
            };
            i += 1;
        }
        if t < self.smaller.len() {
            self.smaller[t] = self.x;
        }
        if t < self.eta.len() {
            let mut i = 0;
            while i < all {
                self.eta[t][i] = apply(&form.stage[i], &self.x, r + i);
                i += 1;
            }
        }
    }
}

/// Which solution a coefficient belongs to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Solution {
    /// y' of the step.
    Step,
    /// v' of the step, for y'' = f(t, y).
    Velocity,
    /// The solution of an embedded row.
    Embedded(usize),
}

/// How far a solution is off on one tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Defect {
    /// Order of the tree.
    pub order: usize,
    /// Symmetries: the tree's share of the local error is `off` / sigma times its elementary differential.
    pub sigma: i64,
    /// Weight of the method less weight of the exact solution, 1 / gamma.
    pub off: D,
    /// The largest |z_j|, at least 1: the size of what the rows combine.
    pub size: f64,
}

/// The defects on all trees to an order, smaller trees first.
pub(super) fn defects(forms: &Forms, solution: Solution, order: usize) -> Vec<Defect> {
    let trees = forms.kind.trees_to(order);
    let stored = trees.iter().filter(|tree| tree.order < order).count();
    let (mut smaller, mut eta) = (vec![[D::ZERO; CARRIED + STAGES]; stored], vec![[D::ZERO; STAGES]; stored]);
    let mut series = Series::new(forms, &trees, &mut smaller, &mut eta);
    let defect = |(t, tree): (usize, &Tree)| {
        series.evaluate(t);
        let form = forms.of_colour(tree.colour);
        let row = (solution == Solution::Velocity) as usize;
        let mut off = apply(&form.carry[row], &series.x, 0) - series.later(row);
        if let Solution::Embedded(e) = solution {
            off -= apply(&form.error[e], &series.x, 0);
        }
        let size = series.x[..form.r].iter().map(|z| z.abs().hi()).fold(1.0, f64::max);
        Defect { order: tree.order, sigma: tree.sigma, off, size }
    };
    trees.iter().enumerate().map(defect).collect()
}

#[cfg(test)]
mod tests {
    use super::super::lower::tests::file;
    use super::*;

    /// Euclidean norm of the local error's coefficients at one order.
    fn constant(path: &str, solution: Solution, order: usize) -> f64 {
        let defects = defects(&Forms::of(&file(path)), solution, order);
        let squares =
            defects.iter().filter(|d| d.order == order).map(|d| (d.off.hi() / d.sigma as f64).powi(2));
        squares.sum::<f64>().sqrt()
    }

    #[test]
    fn error_constants_are_those_worked_out_by_hand() {
        // Midpoint: 0 for 1/6 on the tall tree, 1/4 for 1/3 on the bushy one, which has two symmetries.
        let midpoint = (1f64 / 36.0 + 1.0 / 576.0).sqrt();
        assert!((constant("explicit/explicit-midpoint", Solution::Step, 3) - midpoint).abs() < 1e-15);
        // Heun less Euler, on the tree of order 2.
        assert!((constant("explicit/heun-euler21", Solution::Embedded(0), 2) - 0.5).abs() < 1e-15);
        // Adams-Bashforth 4 lacks 251/720 h^5 y^(5), and y^(5) weighs the bushy tree with 4!.
        let ab4 = defects(&Forms::of(&file("multistep/ab4")), Solution::Step, 5);
        assert!((ab4.last().unwrap().off.hi() + 251.0 / 720.0 * 24.0).abs() < 1e-14);
    }

    #[test]
    fn a_solution_of_order_p_has_no_defect_to_order_p() {
        for (path, solution, order) in [
            ("explicit/dop853", Solution::Step, 8),
            ("explicit/verner98-efficient", Solution::Embedded(0), 8),
            ("nystrom/forest-ruth4", Solution::Step, 4),
            ("multistep/milne-simpson", Solution::Step, 4),
            ("rosenbrock/ros3p", Solution::Step, 3),
            ("imex/kencarp3-imex", Solution::Embedded(0), 2),
            ("partitioned/lobatto-iiia-iiib3", Solution::Step, 4),
        ] {
            let defects = defects(&Forms::of(&file(path)), solution, order + 1);
            let largest = |n: usize| {
                defects.iter().filter(|d| d.order == n).map(|d| d.off.hi().abs()).fold(0.0, f64::max)
            };
            assert!((1..=order).all(|n| largest(n) < 1e-15), "{path}");
            assert!(largest(order + 1) > 1e-6, "{path}");
        }
    }

    #[test]
    fn compensated_rows_are_double_double() {
        // 1e16 + third - 1e16: the third survives with 16 digits, as it does in double-double sums.
        let third = D::ONE / D::of(3.0);
        let mut x = [D::ZERO; CARRIED + STAGES];
        (x[0], x[1], x[2]) = (D::of(1e16), third, D::of(-1e8));
        let row = Row { base: Some(0), ..Row::EMPTY }.with(1, D::ONE, 0).with(2, D::of(1e8), 0);
        assert!((apply(&row, &x, 0) - third).abs().hi() < 1e-15);
    }
}
