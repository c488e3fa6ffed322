//! Multistep forms: the classical order conditions, the series of predictor-corrector pairs, and the root
//! condition.

use std::collections::HashMap;

use num_traits::{Signed, Zero};

use super::exact::{Number, Rational, integer};
use super::file::{File, Row, Scheme, Steps};
use super::report::Report;
use super::trees::{Tree, rooted};

pub fn check(file: &File, report: &mut Report) {
    match &file.scheme {
        Scheme::Multistep(steps) => {
            classical(steps, 1, file.order, report);
            roots(steps, 1, report);
        }
        Scheme::Nordsieck(members) => {
            if members.len() != file.order {
                report.say(format!("{} members, but order {}", members.len(), file.order));
            }
            for (q, steps) in members.iter().enumerate() {
                classical(steps, 1, q + 1, report);
                roots(steps, 1, report);
            }
        }
        Scheme::Stormer(steps) => {
            classical(steps, 2, file.order, report);
            roots(steps, 2, report);
        }
        Scheme::PredictorCorrector { predictor, corrector, evaluates } => {
            pair(predictor, corrector, *evaluates, file, report);
            roots(corrector, 1, report);
        }
        _ => {}
    }
}

/// sum alpha_j j^q = q sum beta_j j^(q-1) for y', q (q-1) sum beta_j j^(q-2) for y'', to q = order + d - 1;
/// divided by q! they are the coefficients of h^q.
fn classical(steps: &Steps, d: usize, order: usize, report: &mut Report) {
    let moment = |row: &Row, q: usize| -> Rational {
        row.iter().zip(0..).map(|(x, j)| x * integer(j).pow(q as i32)).sum()
    };
    let residual = |q: usize| {
        let falling: i64 = (0..d).map(|i| q as i64 - i as i64).product();
        // Below q = d the factor is 0 and the power would be negative.
        let forces = if q < d { integer(0) } else { moment(&steps.beta, q - d) * integer(falling) };
        ((moment(&steps.alpha, q) - forces) / integer((1..=q as i64).product())).size()
    };
    let highest = order + d - 1;
    for q in 0..=highest {
        report.expect(residual(q), || format!("the condition of the polynomial t^{q}"));
    }
    report.expect_sharp("the step", order, residual(highest + 1));
}

/// One step from exact values: y_(n+j) and f_(n+j) lie at theta = j - (k - 1), the new point at theta = 1.
fn pair(predictor: &Steps, corrector: &Steps, evaluates: bool, file: &File, report: &mut Report) {
    // y(theta) has theta^|t|/gamma(t), and h f(theta) its derivative.
    let history = |steps: &Steps, tree: &Tree| -> Rational {
        let k = steps.alpha.len() - 1;
        let n = tree.order() as i32;
        let term = |j: usize| {
            let theta = integer(j as i64 + 1 - k as i64);
            let slope = integer(n.into()) * theta.pow(n - 1);
            &steps.beta[j] * slope - &steps.alpha[j] * theta.pow(n)
        };
        (0..k).map(term).sum::<Rational>() * tree.weight()
    };
    // h f(Y) has the product of what Y has for the children.
    let slope = |y: &HashMap<Tree, Rational>, tree: &Tree| -> Rational {
        tree.children.iter().map(|u| &y[u]).product()
    };
    let newest = |steps: &Steps| (steps.alpha.last().unwrap().clone(), steps.beta.last().unwrap().clone());
    let (alpha, beta) = newest(predictor);
    report.expect(beta.size(), || "the predictor's weight of the value it predicts".to_string());

    let [mut predicted, mut corrected] = [HashMap::new(), HashMap::new()];
    let mut sharpest: f64 = 0.0;
    for order in 1..=file.order + 1 {
        for tree in rooted(order) {
            let (last, implicit) = newest(corrector);
            let guess = slope(&predicted, &tree);
            let y = (history(corrector, &tree) + implicit * &guess) / last;
            predicted.insert(tree.clone(), history(predictor, &tree) / &alpha);
            corrected.insert(tree.clone(), y.clone());
            let kept = if evaluates { slope(&corrected, &tree) } else { guess };
            let off = (y - tree.weight()).size();
            // What later steps take for f at this point.
            let off_slope = (kept - tree.weight() * integer(order as i64)).size();
            if order > file.order {
                sharpest = sharpest.max(off);
            } else {
                report.expect(off, || format!("y: the order {order} condition of the tree {tree}"));
                report.expect(off_slope, || format!("f: the order {order} condition of the tree {tree}"));
            }
        }
    }
    // y at time 0 is carried by the tree without nodes.
    for (name, steps) in [("predictor", predictor), ("corrector", corrector)] {
        let off = steps.alpha.iter().sum::<Rational>().size();
        report.expect(off, || format!("the sum of alpha of the {name}"));
    }
    report.expect_sharp("the step", file.order, sharpest);
}

/// Zero-stability: rho(z) = sum alpha_j z^j has no root outside the unit circle, and on it none of more than
/// d-fold.
fn roots(steps: &Steps, d: usize, report: &mut Report) {
    // A greatest common divisor is lost when its roots are rounded.
    assert!(report.file.exact(), "{}: multistep rows are rationals", report.file.path);
    if !bounded(&steps.alpha, d) {
        report.say("rho breaks the root condition".to_string());
    }
}

/// Exact, without computing a root: p = g q, where g has the roots that come in pairs z, 1/z, and so all of
/// modulus 1. q must be a Schur polynomial. By Cohn (1922) all roots of the self-reciprocal g lie on the
/// circle if and only if those of g' lie in the closed disc; from g to g' multiplicities on it fall by one.
fn bounded(p: &[Rational], multiplicity: usize) -> bool {
    let p = trimmed(p);
    let g = divisor(&p, &reversed(&p));
    if g.len() > 1 && multiplicity == 0 {
        return false;
    }
    let derivative: Row = g.iter().zip(0..).skip(1).map(|(x, j)| x * integer(j)).collect();
    schur(&divide(&p, &g).0) && (g.len() == 1 || bounded(&derivative, multiplicity - 1))
}

/// All roots in the open unit disc (Schur 1918): |p_0| < |p_n|, and the same for (p_n p - p_0 p*) / z.
fn schur(p: &[Rational]) -> bool {
    let [first, .., last] = p else { return true };
    let rest = || p.iter().zip(reversed(p)).map(|(x, y)| x * last - y * first).skip(1).collect::<Row>();
    first.abs() < last.abs() && schur(&rest())
}

fn reversed(p: &[Rational]) -> Row {
    p.iter().rev().cloned().collect()
}

/// Without roots at zero and without a zero leading coefficient.
fn trimmed(p: &[Rational]) -> Row {
    let from = p.iter().position(|x| !Zero::is_zero(x)).unwrap();
    let to = p.iter().rposition(|x| !Zero::is_zero(x)).unwrap();
    p[from..=to].to_vec()
}

/// Quotient and remainder.
fn divide(p: &[Rational], q: &[Rational]) -> (Row, Row) {
    let mut rest = p.to_vec();
    let mut quotient = vec![integer(0); (p.len() + 1).saturating_sub(q.len())];
    for i in (0..quotient.len()).rev() {
        quotient[i] = &rest[i + q.len() - 1] / q.last().unwrap();
        for (j, x) in q.iter().enumerate() {
            rest[i + j] -= x * &quotient[i];
        }
    }
    rest.truncate(q.len() - 1);
    (quotient, rest)
}

/// Greatest common divisor (Euclid).
fn divisor(p: &[Rational], q: &[Rational]) -> Row {
    if q.iter().all(Zero::is_zero) {
        return p.to_vec();
    }
    let to = q.iter().rposition(|x| !Zero::is_zero(x)).unwrap();
    divisor(&q[..=to], &divide(p, &q[..=to]).1)
}

#[test]
fn the_root_condition_tells_stable_from_unstable() {
    let row = |x: &[i64]| x.iter().map(|&n| integer(n)).collect::<Row>();
    // rho of: Adams, leapfrog, BDF2, a cube root of unity, Stormer for y''.
    for (p, d) in [(&[-1, 1][..], 1), (&[-1, 0, 1], 1), (&[1, -4, 3], 1), (&[1, 1, 1], 1), (&[1, -2, 1], 2)] {
        assert!(bounded(&row(p), d), "{p:?}");
    }
    // A double root at 1; a root at 2; the pair 2, 1/2; a root at -5; a triple root at 1.
    for (p, d) in
        [(&[1, -2, 1][..], 1), (&[2, -3, 1], 1), (&[2, -5, 2], 1), (&[-5, 4, 1], 1), (&[-1, 3, -3, 1], 2)]
    {
        assert!(!bounded(&row(p), d), "{p:?}");
    }
    // A double pair i, -i on the circle: z^4 + 2 z^2 + 1.
    assert!(!bounded(&row(&[1, 0, 2, 0, 1]), 1));
    assert!(bounded(&row(&[1, 0, 2, 0, 1]), 2));
    // BDF7 (Cryer 1972): 420 rho has two roots outside.
    assert!(!bounded(&row(&[-60, 490, -1764, 3675, -4900, 4410, -2940, 1089]), 1));
    // BDF6: 60 rho.
    assert!(bounded(&row(&[10, -72, 225, -400, 450, -360, 147]), 1));
}
