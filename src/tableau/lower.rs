//! Lowering: each family's own arrays become the rows of the one form.
//!
//! What is carried is written z = (y, older y, f) below. Every vector of it is a state or a slope of the
//! solution at t_n or at t_n - k h, so whoever can integrate k steps by other means can start the method.

use super::collocation::collocation;
use super::double_double::DoubleDouble as D;
use super::form::{CARRIED, Form, Meaning, POWERS, Row, STAGES};
use super::history::{History, multistep, predictor_corrector};
use super::linear::rosenbrock;
use super::nordsieck::nordsieck;
use super::pairs::{imex, partitioned};
use super::{Array, Scheme, Splitting, Tableau};

/// The one form of a method. `None` where it has none: a pair whose stages would have to be found together.
pub(super) const fn lower(t: &Tableau) -> Option<Form> {
    let mut form = BLANK;
    if lower_to(t, &mut form) { Some(form) } else { None }
}

/// Writes the one form into a blank one, false where there is none. A form has 40 kB: what is built in place
/// is not copied from frame to frame.
pub(super) const fn lower_to(t: &Tableau, form: &mut Form) -> bool {
    match &t.scheme {
        Scheme::RungeKutta(array) => {
            runge_kutta(t, array, !full(array), form);
            if full(array) && array.powers == 0 {
                collocation(array, form);
            }
        }
        Scheme::Multistep(steps) => multistep(t, steps, 1, form),
        Scheme::Stormer(steps) => multistep(t, steps, 2, form),
        Scheme::Nordsieck(members) => nordsieck(t, members, form),
        Scheme::PredictorCorrector { predictor, corrector, evaluates } => {
            predictor_corrector(t, predictor, corrector, *evaluates, form)
        }
        Scheme::Nystrom { array, bbar } => nystrom(t, array, bbar, D::ONE, form),
        Scheme::Splitting(splitting) => {
            let (array, bbar, end) = kicks(splitting);
            nystrom(t, &array, &bbar, end, form)
        }
        Scheme::Rosenbrock { alpha, gamma } => rosenbrock(t, alpha, gamma, form),
        Scheme::Imex { explicit, implicit } => return imex(t, explicit, implicit, form),
        Scheme::Partitioned { position, velocity } => return partitioned(t, position, velocity, form),
    }
    true
}

/// Why a method does not fit the form's arrays, which lowering takes for granted.
pub(super) const fn misfit(t: &Tableau) -> Option<&'static str> {
    let vectors = match &t.scheme {
        Scheme::Multistep(steps) | Scheme::Stormer(steps) => {
            History::of(steps, if steps.beta[steps.k].hi() != 0.0 { 1 } else { 2 }).vectors()
        }
        Scheme::PredictorCorrector { predictor, corrector, .. } => {
            History::of(predictor, 1).or(History::of(corrector, 1)).vectors()
        }
        Scheme::Splitting(splitting) if kicks(splitting).0.stages == 0 => return Some("there is no kick"),
        _ => 1,
    };
    if vectors > CARRIED { Some("more than 14 vectors are carried from step to step") } else { None }
}

/// One stage, y carried.
pub(super) const BLANK: Form = Form { r: 1, s: 1, ..Form::EMPTY };

/// Moves the term of the row's own F, source `own`, to the diagonal.
pub(super) const fn with_diagonal(row: Row, own: usize) -> Row {
    let (mut out, mut i) = (Row { len: 0, ..row }, 0);
    while i < row.len {
        if row.at[i] == own {
            out.diagonal = row.a[i];
        } else {
            out = out.with(row.at[i], row.a[i], row.power[i]);
        }
        i += 1;
    }
    out
}

/// Ends every lowering: y' that equals the last stage is the last stage, moved.
pub(super) const fn finish(t: &Tableau, form: &mut Form) {
    let (own, last) = (form.r + form.s - 1, form.stage[form.s - 1]);
    let whole = Row { diagonal: D::ZERO, ..last.with(own, last.diagonal, form.d) };
    form.carry[0].last_y = whole.equals(&form.carry[0]);
    form.order = t.order;
}

/// z = (y), or (y, f) where the last stage is y' itself and the first one y: then the step's last F is the
/// next one's first, and the first stage falls away. Stage i's F (counted from 0) is source 1 + i either way.
///
/// `share` allows the latter; pairs of tables number their stages alike and do without.
pub(super) const fn runge_kutta(t: &Tableau, array: &Array, share: bool, form: &mut Form) {
    let all = array.stages + array.extra;
    let first = (share && first_is_last(array, &array.b, D::ONE)) as usize;
    form.r = 1 + first;
    form.s = array.stages - first;
    form.extra = array.extra;
    let mut i = first;
    while i < all {
        // The typed c, which is proven to be the row's sum: a stage at t + h is there to the last bit.
        form.c[i - first] = array.c[i];
        form.stage[i - first] = with_diagonal(slopes(Some(0), 1, &array.a[i], all, 1), 1 + i);
        i += 1;
    }
    form.carry[0] = slopes(Some(0), 1, &array.b, array.stages, 1);
    if first == 1 {
        form.means[1] = Meaning::F(0);
        form.carry[1] = Row { base: Some(array.stages), ..Row::EMPTY };
    }
    form.errors = array.lower;
    form.embedded = t.embedded;
    let mut e = 0;
    while e < array.lower {
        let (mut weights, mut i) = ([D::ZERO; STAGES], 0);
        while i < array.stages {
            weights[i] = array.b[i].minus(array.bhat[e][i]);
            i += 1;
        }
        form.error[e] = slopes(None, 1, &weights, array.stages, 1);
        e += 1;
    }
    form.dense_order = t.dense_order;
    form.powers = array.powers;
    let mut k = 0;
    while k < array.powers {
        let (mut weights, mut i) = ([D::ZERO; STAGES], 0);
        while i < all {
            weights[i] = array.dense[i][k];
            i += 1;
        }
        form.dense[k] = slopes(None, 1, &weights, all, 1);
        k += 1;
    }
    finish(t, form);
}

/// An entry stands above the diagonal: the stages are found together, and the first one is one of them.
pub(super) const fn full(array: &Array) -> bool {
    let mut i = 0;
    while i < array.stages {
        let mut j = i + 1;
        while j < array.stages {
            if array.a[i][j].hi() != 0.0 {
                return true;
            }
            j += 1;
        }
        i += 1;
    }
    false
}

/// base + h^power sum weights_i F_i, F_0 being source `from`.
pub(super) const fn slopes(
    base: Option<usize>,
    from: usize,
    weights: &[D; STAGES],
    n: usize,
    power: usize,
) -> Row {
    let (mut row, mut i) = (Row { base, ..Row::EMPTY }, 0);
    while i < n {
        row = row.with(from + i, weights[i], power);
        i += 1;
    }
    row
}

/// The first stage is y at t, the last one y' at t + h, which is built with the weights `b`.
pub(super) const fn first_is_last(array: &Array, b: &[D; STAGES], end: D) -> bool {
    let last = array.stages - 1;
    if last == 0 || !same(array.c[0], D::ZERO) || !same(array.c[last], end) {
        return false;
    }
    let mut j = 0;
    while j < array.stages {
        if !same(array.a[0][j], D::ZERO) || !same(array.a[last][j], b[j]) {
            return false;
        }
        j += 1;
    }
    true
}

const fn same(a: D, b: D) -> bool {
    a.hi() == b.hi() && a.lo() == b.lo()
}

/// z = (x, v), or (x, v, f) where the last stage is x' itself and the first one x. Stage i's F is source 2 + i
/// either way. The step ends at t + `end` h, which is 1 up to rounding.
pub(super) const fn nystrom(t: &Tableau, array: &Array, bbar: &[D; STAGES], end: D, form: &mut Form) {
    form.d = 2;
    let n = array.stages;
    let first = first_is_last(array, bbar, end) as usize;
    form.r = 2 + first;
    form.s = n - first;
    form.means[1] = Meaning::V;
    let mut i = first;
    while i < n {
        form.c[i - first] = array.c[i];
        form.stage[i - first] = with_diagonal(position(&array.a[i], n, array.c[i]), 2 + i);
        i += 1;
    }
    form.carry[0] = position(bbar, n, end);
    form.carry[1] = slopes(Some(1), 2, &array.b, n, 1);
    if first == 1 {
        form.means[2] = Meaning::F(0);
        form.carry[2] = Row { base: Some(1 + n), ..Row::EMPTY };
    }
    finish(t, form);
}

/// x + c h v + h^2 sum weights_i F_i.
const fn position(weights: &[D; STAGES], n: usize, c: D) -> Row {
    let (mut row, mut i) = (Row { base: Some(0), ..Row::EMPTY }.with(1, c, 1), 0);
    while i < n {
        row = row.with(2 + i, weights[i], 2);
        i += 1;
    }
    row
}

/// A composition as a Nystrom array: each kick is a stage, seen through the drifts that come after it.
/// Kicks with no drift between them are one; the time after the last drift comes third.
const fn kicks(splitting: &Splitting) -> (Array, [D; STAGES], D) {
    let mut array = Array {
        stages: 0,
        c: [D::ZERO; STAGES],
        a: [[D::ZERO; STAGES]; STAGES],
        b: [D::ZERO; STAGES],
        lower: 0,
        bhat: [[D::ZERO; STAGES]; 2],
        extra: 0,
        powers: 0,
        dense: [[D::ZERO; POWERS]; STAGES],
    };
    let (mut time, mut moved, mut i) = (D::ZERO, true, 0);
    while i < splitting.len {
        let weight = splitting.weight[i];
        if !splitting.kick[i] {
            time = time.plus(weight);
            moved = moved || weight.hi() != 0.0;
        } else if moved {
            array.c[array.stages] = time;
            array.b[array.stages] = weight;
            array.stages += 1;
            moved = false;
        } else {
            let last = array.stages - 1;
            array.b[last] = array.b[last].plus(weight);
        }
        i += 1;
    }
    let (mut bbar, mut i) = ([D::ZERO; STAGES], 0);
    while i < array.stages {
        let mut j = 0;
        while j < i {
            array.a[i][j] = array.b[j].times(array.c[i].minus(array.c[j]));
            j += 1;
        }
        bbar[i] = array.b[i].times(time.minus(array.c[i]));
        i += 1;
    }
    (array, bbar, time)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::tableau::read::read;

    pub(in crate::tableau) fn file(path: &str) -> Tableau<'static> {
        let path = format!("{}/tableaus/{path}.toml", env!("CARGO_MANIFEST_DIR"));
        read(std::fs::read_to_string(path).unwrap().leak()).unwrap()
    }

    pub(in crate::tableau) fn form(path: &str) -> Form {
        lower(&file(path)).unwrap()
    }

    fn terms(row: &Row) -> Vec<(usize, f64)> {
        (0..row.len).map(|i| (row.at[i], row.a[i].hi())).collect()
    }

    use Meaning::{F, V, Y};

    #[test]
    fn first_same_as_last_carries_the_slope_and_drops_a_stage() {
        let dp = form("explicit/dp54");
        assert_eq!((dp.s, &dp.means[..dp.r]), (6, &[Y(0), F(0)][..]));
        assert!(dp.carry[0].last_y && dp.carry[1].copies());
        assert_eq!(dp.carry[1].base, Some(dp.r + dp.s - 1));
        let rk4 = form("explicit/rk4");
        assert_eq!((rk4.r, rk4.s, rk4.carry[0].last_y), (1, 4, false));
        assert!(rk4.stage[0].copies());
    }

    #[test]
    fn verlet_adds_x_last() {
        let row = form("nystrom/verlet").carry[0];
        assert_eq!((row.base, terms(&row)), (Some(0), vec![(0, 1.0), (1, -1.0), (2, 1.0)]));
        assert_eq!(row.power[..3], [0, 0, 2]);
        assert_eq!(form("multistep/nystrom2").carry[0].base, Some(1));
    }

    #[test]
    fn kick_drift_kick_is_velocity_verlet() {
        let (kdk, nystrom) = (form("nystrom/verlet-kdk"), form("nystrom/velocity-verlet"));
        for form in [&kdk, &nystrom] {
            assert_eq!((form.s, &form.means[..form.r]), (1, &[Y(0), V, F(0)][..]));
            assert!(form.carry[0].last_y);
        }
        assert!(kdk.stage[0].equals(&nystrom.stage[0]) && kdk.carry[1].equals(&nystrom.carry[1]));
    }

    #[test]
    fn kicks_without_a_drift_between_are_one() {
        let mut splitting = Splitting { len: 4, kick: [true; 2 * STAGES], weight: [D::of(0.25); 2 * STAGES] };
        (splitting.kick[2], splitting.weight[2]) = (false, D::ONE);
        let (array, _, end) = kicks(&splitting);
        assert_eq!((array.stages, end), (2, D::ONE));
        assert_eq!(array.b[..2], [D::of(0.5), D::of(0.25)]);
    }

    #[test]
    fn every_term_has_the_power_of_its_source_less_that_of_its_target() {
        for path in ["explicit/dop853", "multistep/abm4-pece", "nystrom/velocity-verlet", "nystrom/verlet"] {
            let form = form(path);
            let power = |at: usize| if at < form.r { form.means[at].power(form.d) } else { form.d };
            let check = |row: &Row, target: usize| {
                assert!((0..row.len).all(|i| row.power[i] + target == power(row.at[i])), "{path}");
                assert!(row.base.is_none_or(|j| power(j) == target), "{path}");
            };
            form.stage[..form.s + form.extra].iter().for_each(|row| check(row, 0));
            (0..form.r).for_each(|j| check(&form.carry[j], power(j)));
            form.error[..form.errors].iter().chain(&form.dense[..form.powers]).for_each(|row| check(row, 0));
        }
    }
}
