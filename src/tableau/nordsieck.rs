//! Families of linear multistep formulas in Nordsieck's form (1962, Math. Comp. 16, 22): what is carried is
//! h^k y^(k)/k!, so a change of step is a product by powers, and a change of order one vector more or less.

use super::double_double::DoubleDouble as D;
use super::error::{Broken, TableauError, Text};
use super::form::{CARRIED, Form, Meaning, Row};
use super::roots::all_inside;
use super::sums::within;
use super::{Scheme, Steps, Tableau};

/// Most members of a family, one for each order from 1 on.
pub const ORDERS: usize = CARRIED - 2;

/// Formulas of order 1, 2, .., `count`.
#[derive(Clone, Copy)]
pub struct Members {
    pub count: usize,
    pub steps: [Steps; ORDERS],
}

impl Members {
    /// The member of order `q` as a method of its own.
    pub const fn of<'t>(&self, t: &Tableau<'t>, q: usize) -> Tableau<'t> {
        Tableau { order: q, scheme: Scheme::Multistep(self.steps[q - 1]), ..*t }
    }
}

/// How the member of order q corrects: z'_k = (P z)_k + l_k e, where P z is z moved on by a step and e the
/// correction of h y', which makes h f(t, z'_0) = z'_1.
#[derive(Clone, Copy)]
pub struct Corrector {
    /// l_0 .. l_q; l_1 = 1, l_0 is the weight of h f in y'.
    pub l: [D; CARRIED],
    /// C_(q+1) / sigma(1).
    pub constant: D,
    /// Steps of the formula, and its coefficients from the oldest on.
    pub k: usize,
    pub alpha: [f64; CARRIED],
    pub beta: [f64; CARRIED],
}

impl Corrector {
    pub const EMPTY: Corrector = Corrector {
        l: [D::ZERO; CARRIED],
        constant: D::ZERO,
        k: 0,
        alpha: [0.0; CARRIED],
        beta: [0.0; CARRIED],
    };

    const fn of(steps: &Steps, order: usize) -> Corrector {
        let mut corrector = Corrector { l: vector(steps, order), k: steps.k, ..Corrector::EMPTY };
        corrector.constant = constant(steps, order);
        let mut j = 0;
        while j <= steps.k {
            corrector.alpha[j] = steps.alpha[j].hi();
            corrector.beta[j] = steps.beta[j].hi();
            j += 1;
        }
        corrector
    }
}

/// z = (y, h y', h^2 y''/2, ..).
pub(super) const fn nordsieck(t: &Tableau, members: &Members, form: &mut Form) {
    form.r = members.count + 1;
    form.orders = members.count;
    form.order = t.order;
    form.damped = true;
    let mut q = 1;
    while q <= members.count {
        let steps = &members.steps[q - 1];
        form.means[q] = Meaning::Taylor(q);
        form.correctors[q - 1] = Corrector::of(steps, q);
        form.damped = form.damped && all_inside(&steps.beta, steps.k);
        q += 1;
    }
    // The one stage solves for y at the end of the step; what it gives is the correction.
    form.c[0] = D::ONE;
    form.stage[0] = Row { base: Some(0), diagonal: form.correctors[0].l[0], ..Row::EMPTY };
    form.error[0] = Row::EMPTY.with(form.r, D::ONE, 0);
}

/// Old values that a formula reads: those of y and those of f.
pub(super) const fn reads(steps: &Steps) -> usize {
    let (mut count, mut j) = (0, 0);
    while j < steps.k {
        count += (steps.alpha[j].hi() != 0.0) as usize + (steps.beta[j].hi() != 0.0) as usize;
        j += 1;
    }
    count
}

/// The coefficients of the polynomial l of degree q that leaves alone whatever the formula reads of the past,
/// so that z and the formula know the same: l(-j) = 0 where it reads y at t_(n+1) - j h, l'(-j) = 0 where it
/// reads f, and l'(0) = 1. By elimination; not numbers where the conditions are not independent.
const fn vector(steps: &Steps, order: usize) -> [D; CARRIED] {
    let n = order + 1;
    let mut rows = [[D::ZERO; CARRIED + 1]; CARRIED];
    (rows[0][1], rows[0][n]) = (D::ONE, D::ONE);
    let (mut count, mut age) = (1, 1);
    while age <= steps.k {
        let x = D::of_integer(-(age as i64));
        let mut derivative = 0;
        while derivative < 2 {
            let row = if derivative == 0 { &steps.alpha } else { &steps.beta };
            if row[steps.k - age].hi() != 0.0 && count < n {
                let mut i = derivative;
                while i < n {
                    let factor = if derivative == 0 { 1 } else { i as i64 };
                    rows[count][i] = D::of_integer(factor).times(x.powi((i - derivative) as u32));
                    i += 1;
                }
                count += 1;
            }
            derivative += 1;
        }
        age += 1;
    }
    let mut c = 0;
    while c < n {
        let (mut pivot, mut r) = (c, c + 1);
        while r < n {
            if rows[pivot][c].abs().less(rows[r][c].abs()) {
                pivot = r;
            }
            r += 1;
        }
        (rows[c], rows[pivot]) = (rows[pivot], rows[c]);
        let head = rows[c][c];
        let mut i = c;
        while i <= n {
            rows[c][i] = rows[c][i].over(head);
            i += 1;
        }
        let mut r = 0;
        while r < n {
            let by = rows[r][c];
            let mut i = c;
            while i <= n && r != c {
                rows[r][i] = rows[r][i].minus(by.times(rows[c][i]));
                i += 1;
            }
            r += 1;
        }
        c += 1;
    }
    let (mut l, mut i) = ([D::ZERO; CARRIED], 0);
    while i < n {
        l[i] = rows[i][n];
        i += 1;
    }
    l
}

/// C_(q+1) = (sum alpha_j j^(q+1) - (q+1) sum beta_j j^q) / (q+1)!, over sigma(1). Times are counted from the
/// new point, where the powers are smallest.
const fn constant(steps: &Steps, order: usize) -> D {
    let (mut sum, mut sigma, mut factorial) = (D::ZERO, D::ZERO, D::ONE);
    let mut j = 0;
    while j <= steps.k {
        let x = D::of_integer(j as i64 - steps.k as i64);
        let y = steps.alpha[j].times(x.powi(order as u32 + 1));
        let f = steps.beta[j].times(x.powi(order as u32)).times(D::of_integer(order as i64 + 1));
        sum = sum.plus(y.minus(f));
        sigma = sigma.plus(steps.beta[j]);
        j += 1;
    }
    let mut i = 2;
    while i <= order as i64 + 1 {
        factorial = factorial.times(D::of_integer(i));
        i += 1;
    }
    sum.over(sigma).over(factorial)
}

/// `member q: ` before what is wrong with one.
pub(super) const fn of_member(error: TableauError, q: usize) -> TableauError {
    let text = Text::new().str("the member of order ").number(q).str(": ").str(error.text.as_str());
    TableauError { text, ..error }
}

/// Demands that l is the formula: it gives h f the weight that the formula gives it.
pub(super) const fn determined(members: &Members, tolerance: f64) -> Result<(), TableauError> {
    let mut q = 1;
    while q <= members.count {
        let steps = &members.steps[q - 1];
        let l = vector(steps, q);
        let off = l[0].minus(steps.beta[steps.k].over(steps.alpha[steps.k])).hi();
        // Elimination loses digits to the powers of the oldest time.
        if !within(off, tolerance * 1e6) {
            let text = Text::new().str("what it reads of the past does not determine its correction");
            return Err(of_member(TableauError::new(Broken::Order, 0, off, text), q));
        }
        q += 1;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::lower::tests::{file, form};
    use super::super::read::{read, value};
    use super::super::{Form, prove::prove};
    use super::*;

    fn l(form: &Form, q: usize) -> Vec<D> {
        form.correctors[q - 1].l[..=q].to_vec()
    }

    fn assert_l(form: &Form, q: usize, wanted: &str) {
        let wanted: Vec<D> = wanted.split(' ').map(|entry| value(entry).unwrap()).collect();
        let found = l(form, q);
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(wanted) {
            // Elimination by powers of up to eleven steps: 24 digits are left at order 12.
            assert!((*found - wanted).abs().hi() < 1e-24 * (1.0 + wanted.hi()), "{q}: {found:?}");
        }
    }

    #[test]
    fn correctors_are_those_of_the_books() {
        // Gear 1971, tables 9.1 and 11.1; order 12 by exact fractions.
        let (adams, bdf) = (form("nordsieck/adams"), form("nordsieck/bdf"));
        assert_l(&adams, 1, "1 1");
        assert_l(&adams, 2, "1/2 1 1/2");
        assert_l(&adams, 3, "5/12 1 3/4 1/6");
        assert_l(&adams, 4, "3/8 1 11/12 1/3 1/24");
        assert_l(&adams, 6, "95/288 1 137/120 5/8 17/96 1/40 1/720");
        assert_l(
            &adams,
            12,
            "4777223/17418240 1 83711/55440 190553/151200 341747/518400 139381/604800 242537/4354560 \
             1903/201600 10831/9676800 11/120960 1/207360 1/6652800 1/479001600",
        );
        assert_l(&bdf, 1, "1 1");
        assert_l(&bdf, 2, "2/3 1 1/3");
        assert_l(&bdf, 3, "6/11 1 6/11 1/11");
        assert_l(&bdf, 5, "60/137 1 225/274 85/274 15/274 1/274");
        // Backward differentiation errs by -1/(q + 1), Moulton's formulas by 1/2, 1/12, 1/24, 19/720, ..
        for q in 1..=5 {
            let constant = bdf.correctors[q - 1].constant.hi();
            assert!((constant + 1.0 / (q as f64 + 1.0)).abs() < 1e-15, "{q}: {constant}");
        }
        for (q, wanted) in [(1, 0.5), (2, 1.0 / 12.0), (3, 1.0 / 24.0), (4, 19.0 / 720.0)] {
            assert!((adams.correctors[q - 1].constant.hi() + wanted).abs() < 1e-15, "{q}");
        }
    }

    #[test]
    fn what_forgets_at_infinity_takes_newtons_iteration() {
        assert!(form("nordsieck/bdf").damped && !form("nordsieck/adams").damped);
        assert_eq!((form("nordsieck/bdf").r, form("nordsieck/adams").r), (6, 13));
    }

    #[test]
    fn every_member_is_proven_to_its_order() {
        for path in ["nordsieck/bdf", "nordsieck/adams"] {
            let t = file(path);
            prove(&t).unwrap();
            t.prove_all().unwrap();
        }
    }

    /// The file of a family of order 2 with these rows.
    fn refusal(rows: &str) -> String {
        let text = format!("name = \"t\"\norder = 2\ncite = \"t\"\nnordsieck = '''\n{rows}\n'''\n");
        let read = read(text.leak());
        read.and_then(|t| prove(&t)).unwrap_err().text.as_str().to_string()
    }

    #[test]
    fn wrong_members_are_named() {
        let one = "alpha | -1 1\nbeta | 0 1\n";
        for (rows, why) in [
            (
                "alpha | 1/2 -2 3/2\nbeta | 0 0 1.002",
                "the member of order 2: the order 1 condition of the tree [] is off by 1e-3",
            ),
            (
                "alpha | -1/3 1/3 1\nbeta | 0 0 1",
                "the member of order 2: the weights of y do not sum to 1: off by 1",
            ),
            ("alpha | -1 1\nbeta | 1 0", "the last entry of beta is 0: a member must be implicit"),
            ("alpha | -1 1\nbeta | 0 1", "the member of order 2 must read as many old y and f, not 1"),
            (
                "beta | 0 1\nalpha | -1 1",
                "a member is a row alpha | .. and a row beta | .., from the oldest step on",
            ),
            (
                "",
                "a family of order 2 has a row alpha | .. and a row beta | .. for each order from 1 on, to at most 12",
            ),
        ] {
            let found = refusal(&format!("{one}{rows}"));
            assert!(found.starts_with(why), "{rows}: {found}");
        }
    }
}
