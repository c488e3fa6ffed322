//! W-methods (Steihaug, Wolfbrandt 1979, Math. Comp. 33, 521): Rosenbrock methods whose orders hold with any matrix A
//! in place of the Jacobian.
//!
//! Nothing of A may be left in the solution to h^order: over the trees of f and A (Hairer, Wanner 1996, section IV.7,
//! theorem 7.7) those of f alone weigh 1/gamma, all others 0. A method whose order needs A = df/dy has it from sums of
//! the two in which the A cancel.
//!
//! f(t, y) is the autonomous f(y) with t' = 1 beside it, whose matrix has df/dt in a column of its own. What holds
//! with any matrix holds with any column: neither an exact df/dt beside an A that is not exact, which is what a step
//! takes, nor a difference in its place needs a condition of its own.

use super::double_double::DoubleDouble as D;
use super::form::{CARRIED, Orders, STAGES};
use super::prove::tolerance;
use super::series::{Forms, Series, apply};
use super::sums::within;
use super::trees::Kind;
use super::{Array, Tableau};

/// Trees that are part of others.
const SMALLER: usize = 59;

/// What any matrix leaves of the orders that a table claims, and has with the Jacobian.
pub(super) const fn inexact(t: &Tableau, alpha: &Array, gamma: &Array) -> Orders {
    let (forms, trees) = (Forms::inexact(t, alpha, gamma), Kind::Inexact.trees());
    let (mut smaller, mut eta) = ([[D::ZERO; CARRIED + STAGES]; SMALLER], [[D::ZERO; STAGES]; SMALLER]);
    let mut series = Series::new(&forms, trees, &mut smaller, &mut eta);
    let (form, tolerance) = (&forms.form[0], tolerance(t.digits));
    let mut left = Orders {
        step: to_limit(t.order),
        embedded: [to_limit(t.embedded[0]), to_limit(t.embedded[1])],
        dense: to_limit(t.dense_order),
    };
    let mut n = 0;
    while n < trees.len() {
        let order = trees[n].order;
        if order > left.step && order > left.dense && order > left.embedded[0] && order > left.embedded[1] {
            return left;
        }
        series.evaluate(n);
        let (x, exact) = (&series.x, series.exact);
        let y = apply(&form.carry[0], x, 0);
        if order <= left.step && !within(y.minus(exact).hi, tolerance) {
            left.step = order - 1;
        }
        let mut e = 0;
        while e < form.errors {
            let off = y.minus(apply(&form.error[e], x, 0)).minus(exact).hi;
            if order <= left.embedded[e] && !within(off, tolerance) {
                left.embedded[e] = order - 1;
            }
            e += 1;
        }
        let mut k = 1;
        while order <= left.dense && k <= form.powers {
            let weight = apply(&form.dense[k - 1], x, 0);
            let off = if k == order { weight.minus(exact).hi } else { weight.hi };
            if !within(off, tolerance) {
                left.dense = order - 1;
            }
            k += 1;
        }
        n += 1;
    }
    left
}

const fn to_limit(order: usize) -> usize {
    if order < Kind::Inexact.limit() { order } else { Kind::Inexact.limit() }
}

#[cfg(test)]
mod tests {
    use super::super::lower::tests::{file, form};
    use super::super::series::{Solution, defects};
    use super::super::{Scheme, read};
    use super::*;

    #[test]
    fn the_literature_knows_which_are_w_methods() {
        let left = |name: &str| form(&format!("rosenbrock/{name}")).inexact;
        let orders = |step, embedded, dense| Orders { step, embedded: [embedded, 0], dense };
        // Verwer, Spee, Blom, Hundsdorfer 1999: of order 2 with any matrix. Shampine, Reichelt 1997: so is ode23s.
        assert_eq!(left("ros2"), orders(2, 1, 0));
        assert_eq!(left("rosenbrock23-shampine"), orders(2, 0, 0));
        // Rang, Angermann 2005, Rang 2015: W-methods of order 3.
        assert_eq!(left("ros34pw2"), orders(3, 2, 0));
        assert_eq!(left("ros34prw").step, 3);
        // Hairer, Wanner II, IV.7: order 2 takes sum b_i gamma_ij = 0 beside the condition of Rosenbrock methods.
        // These do not fulfil it.
        for name in ["ros3p", "rodas3", "rodas4", "rodas42", "rodas4p", "rodas5"] {
            assert_eq!(left(name).step, 1, "{name}");
        }
        // Rodas5P does, and is no W-method of its order 5 for that: as tests/laws finds in exact arithmetic.
        assert_eq!(left("rodas5p").step, 2);
    }

    #[test]
    fn ros2_is_a_w_method_for_every_gamma() {
        for gamma in ["1/7", "1-sqrt(2)/2", "3"] {
            let text = format!(
                "name = \"t\"\norder = 2\nembedded = 1\ncite = \"t\"\nalpha = '''\n|\n| 1\n---\n| 1/2 1/2\n| 1 0\n'''\n\
                 gamma = '''\n| {gamma}\n| -2*({gamma}) {gamma}\n'''\n"
            );
            let table = read::read(&text).unwrap();
            assert_eq!(
                table.form().unwrap().inexact,
                Orders { step: 2, embedded: [1, 0], dense: 0 },
                "{gamma}"
            );
        }
    }

    /// What the compiler finds of the step is where the defects of the trees begin.
    #[test]
    fn what_is_left_is_sharp() {
        for name in ["ros2", "ros34pw2", "ros34prw", "rodas5p"] {
            let table = file(&format!("rosenbrock/{name}"));
            let Scheme::Rosenbrock { alpha, gamma } = &table.scheme else { panic!("{name}") };
            let forms = Forms::inexact(&table, alpha, gamma);
            let step = inexact(&table, alpha, gamma).step;
            let largest = |n: usize| {
                let of = defects(&forms, Solution::Step, n).into_iter().filter(|d| d.order == n);
                of.map(|d| d.off.hi().abs()).fold(0.0, f64::max)
            };
            assert!((1..=step).all(|n| largest(n) < 1e-12) && largest(step + 1) > 1e-3, "{name}");
        }
    }
}
