//! The proof: what a method claims holds on every tree, to double-double accuracy.
//!
//! The exact solution's B-series is fed into the carried vectors and demanded back one step later. That every
//! carried vector is the state, y' or a slope of a solution at t_n - k h is how lowering builds the form, so
//! a start by other means serves every method and there is nothing to prove about it; that the history does
//! not blow up is proven in `roots`.

use super::double_double::DoubleDouble as D;
use super::error::{Broken, TableauError, Text};
use super::form::{CARRIED, Meaning, STAGES};
use super::lower;
use super::nordsieck::{determined, of_member};
use super::roots::zero_stable;
use super::series::{Forms, Series, Sources, apply};
use super::sums::{sums, within};
use super::trees::{Kind, Tree, write};
use super::{Scheme, Tableau};

/// What rounding may leave of a condition that holds exactly: six digits are granted to cancellation.
const FLOOR: f64 = 1e-26;

/// Proves the order to 8 (pairs: 6), the embedded and dense orders, the row sums and zero-stability.
pub(super) const fn prove(t: &Tableau) -> Result<(), TableauError> {
    if let Scheme::Nordsieck(members) = &t.scheme {
        let mut q = 1;
        while q <= members.count {
            if let Err(error) = prove(&members.of(t, q)) {
                return Err(of_member(error, q));
            }
            q += 1;
        }
        return determined(members, tolerance(t.digits));
    }
    let forms = match forms(t) {
        Ok(forms) => forms,
        Err(error) => return Err(error),
    };
    // As many trees as are part of others.
    match forms.kind {
        Kind::Coloured => prove_with::<286>(t, &forms),
        _ => prove_with::<85>(t, &forms),
    }
}

const fn prove_with<const N: usize>(t: &Tableau, forms: &Forms) -> Result<(), TableauError> {
    let claims = Claims::of(t, forms, forms.kind.limit());
    let trees = forms.kind.trees();
    let stored = claims.smaller(trees);
    let mut smaller = [[D::ZERO; CARRIED + STAGES]; N];
    let mut eta = [[D::ZERO; STAGES]; N];
    let (smaller, eta) = (smaller.split_at_mut(stored).0, eta.split_at_mut(stored).0);
    claims.prove(Series::new(forms, trees, smaller, eta), tolerance(t.digits))
}

/// Proves the same with orders to `limit`.
pub(super) fn prove_to(t: &Tableau, limit: usize) -> Result<(), TableauError> {
    if let Scheme::Nordsieck(members) = &t.scheme {
        for q in 1..=members.count {
            prove_to(&members.of(t, q), limit).map_err(|error| of_member(error, q))?;
        }
        return determined(members, tolerance(t.digits));
    }
    let forms = forms(t)?;
    let claims = Claims::of(t, &forms, limit);
    let trees = forms.kind.trees_to(claims.highest);
    let stored = claims.smaller(&trees);
    let (mut smaller, mut eta) = (vec![[D::ZERO; CARRIED + STAGES]; stored], vec![[D::ZERO; STAGES]; stored]);
    claims.prove(Series::new(&forms, &trees, &mut smaller, &mut eta), tolerance(t.digits))
}

/// 10^-digits, or what the arithmetic allows; 0 digits are those of exact entries.
pub(crate) const fn tolerance(digits: usize) -> f64 {
    let (mut tolerance, mut digit) = (1.0, 0);
    while tolerance > FLOOR && (digit < digits || digits == 0) {
        tolerance /= 10.0;
        digit += 1;
    }
    if tolerance > FLOOR { tolerance } else { FLOOR }
}

/// What the trees run over, its size and sums being right.
const fn forms(t: &Tableau) -> Result<Forms, TableauError> {
    if let Some(why) = lower::misfit(t) {
        return Err(TableauError::new(Broken::Shape, 0, 0.0, Text::new().str(why)));
    }
    let forms = Forms::of(t);
    match sums(&t.scheme, &forms, tolerance(t.digits)) {
        Ok(()) => Ok(forms),
        Err(error) => Err(error),
    }
}

/// The orders to prove, each at most the limit.
struct Claims {
    order: usize,
    embedded: [usize; 2],
    dense: usize,
    /// Nothing but positions is carried, though d = 2: their difference is h y'.
    positions: bool,
    /// Highest order of a tree that is needed.
    highest: usize,
}

const fn least(a: usize, b: usize) -> usize {
    if a < b { a } else { b }
}

const fn largest(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

impl Claims {
    const fn of(t: &Tableau, forms: &Forms, limit: usize) -> Claims {
        let form = &forms.form[0];
        let (mut positions, mut j) = (form.d == 2, 0);
        while j < form.r {
            positions = positions && !matches!(form.means[j], Meaning::V);
            j += 1;
        }
        let order = least(t.order, limit);
        let embedded = [least(t.embedded[0], limit), least(t.embedded[1], limit)];
        let dense = least(t.dense_order, limit);
        let highest = largest(largest(order + form.d - 1, dense), largest(embedded[0], embedded[1]));
        Claims { order, embedded, dense, positions, highest }
    }

    /// How many of the trees are part of others.
    const fn smaller(&self, trees: &[Tree]) -> usize {
        let mut i = 0;
        while i < trees.len() && trees[i].order < self.highest {
            i += 1;
        }
        i
    }

    const fn prove(&self, mut series: Series, tolerance: f64) -> Result<(), TableauError> {
        let (forms, trees) = (series.forms, series.trees);
        let mut t = 0;
        while t < trees.len() && trees[t].order <= self.highest {
            series.evaluate(t);
            if let Some(failed) = self.fail(&series, t, tolerance) {
                return Err(failed.error(forms, trees, t));
            }
            t += 1;
        }
        zero_stable(&forms.form[0], tolerance)
    }

    /// How many orders further than the method's own the trees of a carried vector must hold: y' enters y
    /// with h, f with h^d, and each may be off by h^order.
    const fn lift(&self, meaning: Meaning, d: usize) -> usize {
        match meaning {
            Meaning::Y(_) | Meaning::Taylor(_) => self.positions as usize,
            Meaning::V => 1,
            Meaning::F(_) => d - 1,
        }
    }

    /// The first condition of a tree that fails.
    const fn fail(&self, series: &Series, t: usize, tolerance: f64) -> Option<Failed> {
        let (tree, x) = (&series.trees[t], &series.x);
        let form = series.forms.of_colour(tree.colour);
        let tolerance = tolerance * size(x, form.r);
        let y = apply(&form.carry[0], x, 0);
        let mut j = 0;
        while j < form.r {
            let meaning = form.means[j];
            let lift = self.lift(meaning, form.d);
            // An older vector is a younger one moved, exact as it was.
            let moved = matches!(meaning, Meaning::Y(1..) | Meaning::F(1..));
            if tree.order <= self.order + lift && !moved {
                let weight = if j == 0 { y } else { apply(&form.carry[j], x, 0) };
                let off = weight.minus(series.later(j)).hi;
                if !within(off, tolerance) {
                    return Some(Failed { what: What::Carried(meaning), lift, off });
                }
            }
            j += 1;
        }
        let mut e = 0;
        while e < form.errors {
            if tree.order <= self.embedded[e] {
                let off = y.minus(apply(&form.error[e], x, 0)).minus(series.exact).hi;
                if !within(off, tolerance) {
                    return Some(Failed { what: What::Embedded, lift: 0, off });
                }
            }
            e += 1;
        }
        let mut k = 1;
        while tree.order <= self.dense && (k <= form.powers || k <= tree.order) {
            let weight = if k <= form.powers { apply(&form.dense[k - 1], x, 0) } else { D::ZERO };
            let off = if k == tree.order { weight.minus(series.exact).hi } else { weight.hi };
            if !within(off, tolerance) {
                return Some(Failed { what: What::Dense(k), lift: 0, off });
            }
            k += 1;
        }
        None
    }
}

/// The largest |z_j|, at least 1: the size of what the rows combine.
const fn size(x: &Sources, r: usize) -> f64 {
    let (mut size, mut j) = (1.0, 0);
    while j < r {
        let z = x[j].hi.abs();
        size = if z > size { z } else { size };
        j += 1;
    }
    size
}

#[derive(Clone, Copy)]
enum What {
    Carried(Meaning),
    Embedded,
    /// The power of theta.
    Dense(usize),
}

/// A condition that fails, and by how much.
struct Failed {
    what: What,
    lift: usize,
    off: f64,
}

impl Failed {
    const fn error(&self, forms: &Forms, trees: &[Tree], t: usize) -> TableauError {
        let (broken, text) = match self.what {
            What::Carried(_) => (Broken::Order, "the order "),
            What::Embedded => (Broken::EmbeddedOrder, "the embedded order "),
            What::Dense(_) => (Broken::DenseOrder, "the dense output's order "),
        };
        let text = Text::new().str(text).number(trees[t].order - self.lift).str(" condition of the tree ");
        let text = write(text, trees, t, forms.kind.d());
        let text = match forms.kind {
            Kind::Coloured => text.str(", () for the implicit table,"),
            Kind::Alternating => text.str(", () for the velocity table,"),
            _ => text,
        };
        let text = match self.what {
            What::Carried(Meaning::V) => text.str(" in v"),
            What::Carried(Meaning::F(_)) => text.str(" in f"),
            What::Dense(k) => text.str(" at theta^").number(k),
            _ => text,
        };
        TableauError::new(broken, 0, self.off, text.str(" is off by ").size(self.off))
    }
}

#[cfg(test)]
mod tests {
    use super::super::lower::tests::file;
    use super::super::read::read;
    use super::*;

    fn message(result: Result<(), TableauError>) -> String {
        result.unwrap_err().text.as_str().to_string()
    }

    #[test]
    fn every_claim_is_sharp() {
        for path in [
            "explicit/rk4",
            "explicit/dp54",
            "explicit/dop853",
            "implicit/gauss3",
            "multistep/ab4",
            "multistep/abm4-pece",
            "multistep/abm4-pec",
            "multistep/bdf6",
            "multistep/milne-simpson4",
            "nystrom/verlet",
            "nystrom/velocity-verlet",
            "nystrom/forest-ruth4",
            "rosenbrock/rodas4",
            "imex/kencarp4-imex",
            "partitioned/lobatto-iiia-iiib3",
        ] {
            let t = file(path);
            prove(&t).unwrap();
            let more = prove_to(&Tableau { order: t.order + 1, ..t }, 9);
            let claim = format!("the order {} condition of the tree ", t.order + 1);
            assert!(message(more).starts_with(&claim), "{path}");
            for e in 0..2 {
                if t.embedded[e] > 0 {
                    let mut more = t;
                    more.embedded[e] += 1;
                    let claim = format!("the embedded order {} condition", more.embedded[e]);
                    assert!(message(prove_to(&more, 9)).starts_with(&claim), "{path}");
                }
            }
            if t.dense_order > 0 {
                let more = prove_to(&Tableau { dense_order: t.dense_order + 1, ..t }, 9);
                let claim = format!("the dense output's order {} condition", t.dense_order + 1);
                assert!(message(more).starts_with(&claim), "{path}");
            }
        }
    }

    #[test]
    fn orders_beyond_the_compilers_limit_are_proven_at_run_time() {
        let t = file("explicit/verner98-efficient");
        prove_to(&t, 9).unwrap();
        let ten = Tableau { order: 10, ..t };
        prove(&ten).unwrap();
        assert!(message(prove_to(&ten, 10)).starts_with("the order 10 condition"));
    }

    /// The file of a method of order 2 with the given lines.
    fn text(lines: &str) -> String {
        format!("name = \"t\"\norder = 2\ncite = \"t\"\n{lines}\n")
    }

    #[test]
    fn wrong_digits_are_named() {
        for (lines, why) in [
            (
                "tableau = '''\n0 |\n1/2 | 1/2\n---\n| 0 1.002\n'''",
                "the order 1 condition of the tree [] is off by 2e-3",
            ),
            (
                "tableau = '''\n0 |\n2/3 | 2/3\n---\n| 1/2 1/2\n'''",
                "the order 2 condition of the tree [[]] is off by 2e-1",
            ),
            (
                "tableau = '''\n0 |\n1/2 | 1/3\n---\n| 0 1\n'''",
                "row 2 of A does not sum to its c: off by 2e-1",
            ),
            ("tableau = '''\n0 |\n---\n| 0\n'''", "the order 1 condition of the tree [] is off by 1"),
            (
                "embedded = 1\ntableau = '''\n0 |\n1/2 | 1/2\n---\n| 0 1\n| 1/2 1/3\n'''",
                "the embedded order 1 condition of the tree [] is off by 2e-1",
            ),
            (
                "dense_order = 1\ndense = '''\n1\n0 1/4\n'''\ntableau = '''\n0 |\n1/2 | 1/2\n---\n| 0 1\n'''",
                "the dense output's order 1 condition of the tree [] at theta^2 is off by 3e-1",
            ),
            (
                "multistep = '''\nalpha | 1/4 -1 1\nbeta | -1/2 3/2 0\n'''",
                "the weights of y do not sum to 1: off by 3e-1",
            ),
            (
                "predictor = '''\nalpha | -1 1\nbeta | 1/2 0\n'''\ncorrector = '''\nalpha | -1 1\nbeta | 1/2 1/2\n'''\n\
                 mode = \"PECE\"",
                "the prediction is not at t + h: off by 5e-1",
            ),
            (
                "splitting = '''\nkick 0.4\ndrift 1\nkick 0.6\n'''",
                "the order 2 condition of the tree [] is off by 1e-1",
            ),
            (
                "nystrom = '''\n1/2 |\n---\ny | 1/2\nv | 1.5\n'''",
                "the order 1 condition of the tree [] in v is off by 5e-1",
            ),
            ("splitting = '''\ndrift 1\n'''", "there is no kick"),
            (
                "stormer = '''\nalpha | 1 -2 1\nbeta | 0 0.9 0\n'''",
                "the order 1 condition of the tree [] is off by 1e-1",
            ),
            (
                "multistep = '''\nalpha | -5 4 1\nbeta | 2 4 0\n'''",
                "zero-stability: the characteristic polynomial has a root of modulus 5.0000",
            ),
            (
                "alpha = '''\n|\n| 1\n---\n| 1/2 1/2\n'''\ngamma = '''\n| 1/4\n| -1/2 1/3\n'''",
                "row 2 of gamma has another diagonal than the first: off by 8e-2",
            ),
            (
                "alpha = '''\n|\n| 1\n---\n| 1/2 1/2\n'''\ngamma = '''\n| 1/4\n| -1/4 1/4\n'''",
                "the order 2 condition of the tree [[]] is off by 1e-1",
            ),
            (
                "explicit = '''\n0 |\n1/2 | 1/2\n---\n| 0 1\n'''\nimplicit = '''\n0 |\n1/2 | 1/4 1/4\n---\n| 1/2 1/2\n'''",
                "the order 2 condition of the tree ([]), () for the implicit table, is off by 3e-1",
            ),
        ] {
            assert_eq!(message(prove(&read(&text(lines)).unwrap())), why);
        }
    }

    #[test]
    fn digits_set_the_tolerance() {
        // 2/3 to five digits: the order 2 condition is off by 2.5e-6.
        let table = "tableau = '''\n0 |\n0.66667 | 0.66667\n---\n| 1/4 3/4\n'''";
        let proven = |digits: &str| prove(&read(&text(&format!("{digits}\n{table}"))).unwrap());
        assert!(proven("digits = 5").is_ok());
        assert!(proven("digits = 6").is_err());
        assert!(proven("").is_err());
    }
}
