//! Linear multistep methods and predictor-corrector pairs: what of the past is carried, and their rows.

use super::double_double::DoubleDouble as D;
use super::form::{Form, Meaning, Row};
use super::lower::{finish, with_diagonal};
use super::{Steps, Tableau};

/// What steps of given ages are read: age 0 is t_(n+1), age 1 is t_n.
#[derive(Clone, Copy)]
pub(super) struct History {
    /// y is carried for the ages 1 ..= y.
    y: usize,
    /// f is carried for the ages from ..= f.
    f: usize,
    /// 1, or 2 where f_n is evaluated anew in the step.
    from: usize,
}

const fn longer(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

impl History {
    pub const fn of(steps: &Steps, from: usize) -> Self {
        let (mut y, mut f, mut age) = (1, from - 1, 1);
        while age <= steps.k {
            if steps.alpha[steps.k - age].hi() != 0.0 {
                y = longer(y, age);
            }
            if steps.beta[steps.k - age].hi() != 0.0 {
                f = longer(f, age);
            }
            age += 1;
        }
        Self { y, f, from }
    }

    /// What either reads.
    pub const fn or(self, o: Self) -> Self {
        Self { y: longer(self.y, o.y), f: longer(self.f, o.f), from: self.from }
    }

    pub const fn vectors(self) -> usize {
        self.y + (self.f + 1 - self.from)
    }

    /// z is y, older y, f, older f, and what leaves one age enters the next; `newest` is the f that enters.
    const fn carried(self, form: &mut Form, newest: usize) {
        form.r = self.vectors();
        let mut j = 1;
        while j < form.r {
            let source = if j == self.y { newest } else { j - 1 };
            form.carry[j] = Row { base: Some(source), ..Row::EMPTY };
            form.means[j] = if j < self.y { Meaning::Y(j) } else { Meaning::F(j - self.y + self.from - 1) };
            j += 1;
        }
    }

    /// y_(n+1) of a linear multistep formula, the terms of f_(n+1) and, where it is no part of z, f_n being
    /// the sources `new` and `now`.
    const fn row(self, steps: &Steps, d: usize, new: usize, now: usize) -> Row {
        let lead = steps.alpha[steps.k];
        let (mut row, mut age) = (Row::EMPTY, 1);
        while age <= steps.k {
            row = row.with(age - 1, steps.alpha[steps.k - age].neg().over(lead), 0);
            age += 1;
        }
        let mut age = 0;
        while age <= steps.k {
            let at = if age == 0 {
                new
            } else if age < self.from {
                now
            } else {
                self.y + age - self.from
            };
            row = row.with(at, steps.beta[steps.k - age].over(lead), d);
            age += 1;
        }
        row.based()
    }
}

/// Explicit: z = (y, older y, f_(n-1), ..), the one stage evaluates f_n.
/// Implicit: z = (y, older y, f_n, f_(n-1), ..), the one stage solves for y_(n+1).
pub(super) const fn multistep(t: &Tableau, steps: &Steps, d: usize, form: &mut Form) {
    let implicit = steps.beta[steps.k].hi() != 0.0;
    let history = History::of(steps, if implicit { 1 } else { 2 });
    let r = history.vectors();
    form.d = d;
    history.carried(form, r);
    form.carry[0] = history.row(steps, d, r, r);
    if implicit {
        form.stage[0] = with_diagonal(form.carry[0], r);
        form.c[0] = abscissa(form, &form.carry[0]);
    } else {
        form.stage[0] = Row { base: Some(0), ..Row::EMPTY };
    }
    finish(t, form);
}

/// z = (y, older y, f_n, f_(n-1), ..). Stage 1 evaluates f at the prediction; with PECE stage 2 evaluates it
/// at the corrected value, which is then y'.
pub(super) const fn predictor_corrector(
    t: &Tableau,
    predictor: &Steps,
    corrector: &Steps,
    evaluates: bool,
    form: &mut Form,
) {
    let history = History::of(predictor, 1).or(History::of(corrector, 1));
    let r = history.vectors();
    form.s = if evaluates { 2 } else { 1 };
    history.carried(form, r + form.s - 1);
    form.stage[0] = history.row(predictor, 1, r, r);
    form.carry[0] = history.row(corrector, 1, r, r);
    form.c[0] = abscissa(form, &form.stage[0]);
    if evaluates {
        form.stage[1] = form.carry[0];
        form.c[1] = abscissa(form, &form.carry[0]);
    }
    finish(t, form);
}

/// When a row's value is taken, in steps after t_n: the same row applied to the equation t' = 1.
const fn abscissa(form: &Form, row: &Row) -> D {
    let mut c = match row.base {
        Some(j) => age(form, j),
        None => D::ZERO,
    };
    let mut i = 0;
    while i < row.len {
        c = c.plus(row.a[i].times(age(form, row.at[i])));
        i += 1;
    }
    c
}

/// A source applied to t' = 1 at t_n = 0, h = 1.
const fn age(form: &Form, source: usize) -> D {
    let slope = if form.d == 1 { D::ONE } else { D::ZERO };
    if source >= form.r {
        return slope;
    }
    match form.means[source] {
        Meaning::Y(k) => D::of_integer(-(k as i64)),
        Meaning::V => D::ONE,
        Meaning::F(_) => slope,
        Meaning::Taylor(k) => {
            if k == 1 {
                D::ONE
            } else {
                D::ZERO
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scheme;
    use super::super::form::CARRIED;
    use super::super::lower::misfit;
    use super::super::lower::tests::{file, form};
    use super::*;
    use Meaning::{F, V, Y};

    #[test]
    fn histories_hold_what_is_read_and_no_more() {
        let means = |path| {
            let form = form(path);
            (form.s, form.means[..form.r].to_vec())
        };
        assert_eq!(means("multistep/ab4"), (1, vec![Y(0), F(1), F(2), F(3)]));
        assert_eq!(means("multistep/abm4-pece"), (2, vec![Y(0), F(0), F(1), F(2), F(3)]));
        assert_eq!(means("multistep/abm4-pec"), (1, vec![Y(0), F(0), F(1), F(2), F(3)]));
        assert_eq!(means("multistep/bdf2"), (1, vec![Y(0), Y(1)]));
        assert_eq!(means("multistep/nystrom2"), (1, vec![Y(0), Y(1)]));
        assert_eq!(means("multistep/bdf1"), (1, vec![Y(0)]));
        assert_eq!(means("nystrom/verlet"), (1, vec![Y(0), Y(1)]));
        assert_eq!(means("nystrom/forest-ruth4"), (3, vec![Y(0), V]));
    }

    #[test]
    fn a_corrected_or_implicit_value_is_the_last_stage() {
        let pece = form("multistep/abm4-pece");
        assert!(pece.carry[0].last_y && pece.explicit());
        assert_eq!((pece.c[0].hi(), pece.c[1].hi()), (1.0, 1.0));
        assert!(!form("multistep/abm4-pec").carry[0].last_y);
        let bdf2 = form("multistep/bdf2");
        assert!(bdf2.carry[0].last_y && !bdf2.explicit());
        assert_eq!(bdf2.stage[0].diagonal, D::of(2.0) / D::of(3.0));
        assert!(form("implicit/sdirk2-alexander").carry[0].last_y);
    }

    #[test]
    fn too_long_a_history_is_a_misfit() {
        let steps = Steps { k: 13, alpha: [D::ONE; CARRIED], beta: [D::ONE; CARRIED] };
        let scheme = Scheme::Multistep(steps);
        let t = Tableau { scheme, ..file("multistep/ab4") };
        assert!(misfit(&t).is_some_and(|why| why.contains("14 vectors")));
        assert!(misfit(&file("multistep/ab8")).is_none());
    }
}
