//! From a file to a [`Tableau`]: which family it is, and that its grids have the shape of that family.
//! What the numbers must fulfil is proven elsewhere.

mod array;
mod file;
mod grid;
mod place;
mod stencil;
#[cfg(test)]
mod tests;

/// `?` for a `const fn`.
macro_rules! ok {
    ($result:expr) => {
        match $result {
            Ok(x) => x,
            Err(error) => return Err(error),
        }
    };
}
use ok;

use super::error::{TableauError, Text};
use super::nordsieck::reads;
use super::number::number;
use super::{CARRIED, D, Members, ORDERS, STAGES, Scheme, Splitting, Steps, Tableau};
use array::{imex, nystrom, partitioned, rosenbrock, runge_kutta, transformed};
use file::{File, Key, about, shape, syntax};
use grid::{Grid, Layout, ROWS, count};
use place::is;
pub(crate) use stencil::stencil;

/// Highest order a file may claim.
const HIGHEST: usize = 20;
const MOST_DIGITS: usize = 1000;

/// The keys of one family besides name, order, cite, note and digits.
struct Family {
    title: &'static str,
    needs: &'static [Key],
    may: &'static [Key],
}

/// The first of a family's keys is its own; `gamma` alone names none.
const FAMILIES: [Family; 11] = [
    Family {
        title: "a Runge-Kutta method",
        needs: &[Key::Tableau],
        may: &[Key::Embedded, Key::Dense, Key::DenseOrder, Key::DenseStages],
    },
    Family { title: "an IMEX pair", needs: &[Key::Explicit, Key::Implicit], may: &[Key::Embedded] },
    Family { title: "a partitioned pair", needs: &[Key::Position, Key::Velocity], may: &[Key::Embedded] },
    Family { title: "a Rosenbrock method", needs: &[Key::Alpha, Key::Gamma], may: &[Key::Embedded] },
    Family {
        title: "a Rosenbrock method in transformed variables",
        needs: &[Key::A, Key::C, Key::Gamma],
        may: &[Key::Embedded, Key::Dense, Key::DenseOrder],
    },
    Family { title: "a multistep method", needs: &[Key::Multistep], may: &[] },
    Family { title: "a family in Nordsieck form", needs: &[Key::Nordsieck], may: &[] },
    Family { title: "a Stormer method", needs: &[Key::Stormer], may: &[] },
    Family {
        title: "a predictor-corrector pair",
        needs: &[Key::Predictor, Key::Corrector, Key::Mode],
        may: &[],
    },
    Family { title: "a Nystrom method", needs: &[Key::Nystrom], may: &[] },
    Family { title: "a splitting", needs: &[Key::Splitting], may: &[] },
];

const COMMON: [Key; 5] = [Key::Name, Key::Order, Key::Cite, Key::Note, Key::Digits];

const fn has(keys: &[Key], key: Key) -> bool {
    let mut i = 0;
    while i < keys.len() {
        if keys[i] as usize == key as usize {
            return true;
        }
        i += 1;
    }
    false
}

/// The family whose keys the file has: all it needs, none of another.
const fn family(file: &File) -> Result<Key, TableauError> {
    match named(file) {
        Some((family, _)) => match fits(file, family) {
            Ok(()) => Ok(family.needs[0]),
            Err(error) => Err(error),
        },
        None if file.has(Key::Stencil) => {
            let text = "this is a stencil, not a method: Stencil::parse and stencil! read it";
            Err(syntax(file.line(Key::Stencil), Text::new().str(text)))
        }
        None => Err(syntax(0, Text::new().str("the file has no numbers: add a grid such as \"tableau\""))),
    }
}

/// The first family that a key of the file names, and the key.
const fn named(file: &File) -> Option<(&'static Family, Key)> {
    let mut f = 0;
    while f < FAMILIES.len() {
        let mut i = 0;
        while i < FAMILIES[f].needs.len() {
            let key = FAMILIES[f].needs[i];
            if file.has(key) && !matches!(key, Key::Gamma | Key::Mode) {
                return Some((&FAMILIES[f], key));
            }
            i += 1;
        }
        f += 1;
    }
    None
}

const fn fits(file: &File, family: &Family) -> Result<(), TableauError> {
    let mut i = 0;
    while i < family.needs.len() {
        if !file.has(family.needs[i]) {
            return Err(missing(family.needs[i], family.title));
        }
        i += 1;
    }
    let mut i = 0;
    while i < Key::ALL.len() {
        let key = Key::ALL[i];
        if file.has(key) && !has(&COMMON, key) && !has(family.needs, key) && !has(family.may, key) {
            return Err(syntax(
                file.line(key),
                about("the key ", key, " does not belong to ").str(family.title),
            ));
        }
        i += 1;
    }
    if file.has(Key::DenseOrder) != file.has(Key::Dense) {
        return Err(missing(
            if file.has(Key::Dense) { Key::DenseOrder } else { Key::Dense },
            "a dense output",
        ));
    }
    if file.has(Key::DenseStages) && !file.has(Key::Dense) {
        return Err(missing(Key::Dense, "a file with dense_stages"));
    }
    Ok(())
}

const fn missing(key: Key, title: &str) -> TableauError {
    syntax(0, about("the key ", key, " is missing; ").str(title).str(" needs it"))
}

/// The keys of a file, with a name, an order and a source among them.
const fn scan<'t>(text: &'t str, empty: &str, which: &str) -> Result<File<'t>, TableauError> {
    let file = ok!(File::scan(text));
    if file.is_empty() {
        return Err(syntax(1, Text::new().str(empty)));
    }
    let mut i = 0;
    while i < 3 {
        let key = COMMON[i];
        if !file.has(key) {
            return Err(missing(key, which));
        }
        if file.string(key).is_empty() {
            return Err(syntax(file.line(key), about("the key ", key, " is empty")));
        }
        i += 1;
    }
    Ok(file)
}

/// Reads a method file; see [`Tableau`] for what its grids mean.
pub(super) const fn read(text: &str) -> Result<Tableau<'_>, TableauError> {
    let file = ok!(scan(text, "the file is empty: it needs name, order, cite and a tableau", "every method"));
    let tableau = Tableau {
        title: file.string(Key::Name),
        cite: file.string(Key::Cite),
        note: file.string(Key::Note),
        order: ok!(file.integer(Key::Order, HIGHEST)),
        embedded: ok!(file.integers(Key::Embedded, HIGHEST)),
        dense_order: ok!(file.integer(Key::DenseOrder, HIGHEST)),
        digits: ok!(file.integer(Key::Digits, MOST_DIGITS)),
        scheme: ok!(scheme(&file, ok!(family(&file)))),
    };
    let (rows, powers) = match &tableau.scheme {
        Scheme::RungeKutta(a) | Scheme::Rosenbrock { alpha: a, .. } => (a.lower, a.powers),
        Scheme::Imex { explicit: a, .. } | Scheme::Partitioned { position: a, .. } => (a.lower, 0),
        _ => (0, 0),
    };
    let orders = (tableau.embedded[0] > 0) as usize + (tableau.embedded[1] > 0) as usize;
    if rows != orders {
        let text = count(Text::new().str("the tableau has "), rows, " row of bhat", " rows of bhat");
        let text = count(text.str(" but \"embedded\" gives "), orders, " order", " orders");
        return Err(shape(file.line(Key::Embedded), text));
    }
    if tableau.dense_order > powers {
        let text = Text::new().str("dense_order is ").number(tableau.dense_order);
        let text = count(text.str(" but \"dense\" has "), powers, " power of theta", " powers of theta");
        return Err(shape(file.line(Key::DenseOrder), text));
    }
    Ok(tableau)
}

const fn scheme(file: &File, family: Key) -> Result<Scheme, TableauError> {
    match family {
        Key::Tableau => runge_kutta(file),
        Key::Explicit => imex(file),
        Key::Position => partitioned(file),
        Key::Alpha => rosenbrock(file),
        Key::A => transformed(file),
        Key::Multistep => Ok(Scheme::Multistep(ok!(steps(file, Key::Multistep)))),
        Key::Nordsieck => members(file),
        Key::Stormer => Ok(Scheme::Stormer(ok!(steps(file, Key::Stormer)))),
        Key::Predictor => predictor_corrector(file),
        Key::Nystrom => nystrom(file),
        _ => splitting(file),
    }
}

/// The rows `alpha | ..` and `beta | ..`.
const fn steps(file: &File, key: Key) -> Result<Steps, TableauError> {
    let grid = ok!(Grid::read(file, key, Layout::Bar));
    ok!(grid.unruled());
    if grid.rows != 2 || !grid.labelled(0, "alpha") || !grid.labelled(1, "beta") {
        let text = "a multistep grid is a row alpha | .. and a row beta | .., from the oldest step on";
        return Err(grid.refuse(grid.rows - 1, text));
    }
    formula(&grid, 0)
}

/// The rows `alpha | ..` at `r` and `beta | ..` below it.
const fn formula(grid: &Grid, r: usize) -> Result<Steps, TableauError> {
    let n = grid.width[r];
    if n != grid.width[r + 1] {
        let text = count(Text::new().str("alpha has "), n, " entry", " entries").str(" but beta has ");
        return Err(shape(grid.line(r + 1), text.number(grid.width[r + 1]).str("; write zeros out")));
    }
    if n < 2 || n > CARRIED {
        return Err(shape(
            grid.line(r),
            Text::new().str("alpha takes 2 to ").number(CARRIED).str(" entries"),
        ));
    }
    if grid.entry[r][n - 1].hi() == 0.0 {
        return Err(grid.refuse(r, "the last entry of alpha is 0: it belongs to the new y and cannot be"));
    }
    let mut steps = Steps { k: n - 1, alpha: [D::ZERO; CARRIED], beta: [D::ZERO; CARRIED] };
    let mut j = 0;
    while j < n {
        steps.alpha[j] = grid.entry[r][j];
        steps.beta[j] = grid.entry[r + 1][j];
        j += 1;
    }
    Ok(steps)
}

/// Rows `alpha | ..` and `beta | ..` in turn, for order 1, 2, .., up to that of the file.
const fn members(file: &File) -> Result<Scheme, TableauError> {
    let grid = ok!(Grid::read(file, Key::Nordsieck, Layout::Bar));
    ok!(grid.unruled());
    let order = ok!(file.integer(Key::Order, HIGHEST));
    if grid.rows != 2 * order || order > ORDERS {
        let text =
            Text::new().str("a family of order ").number(order).str(" has a row alpha | .. and a row ");
        let text = text.str("beta | .. for each order from 1 on, to at most ").number(ORDERS);
        return Err(shape(file.line(Key::Nordsieck), text));
    }
    let empty = Steps { k: 0, alpha: [D::ZERO; CARRIED], beta: [D::ZERO; CARRIED] };
    let mut members = Members { count: order, steps: [empty; ORDERS] };
    let mut q = 1;
    while q <= order {
        let r = 2 * (q - 1);
        if !grid.labelled(r, "alpha") || !grid.labelled(r + 1, "beta") {
            return Err(
                grid.refuse(r, "a member is a row alpha | .. and a row beta | .., from the oldest step on")
            );
        }
        let steps = ok!(formula(&grid, r));
        if steps.beta[steps.k].hi() == 0.0 {
            return Err(grid.refuse(r + 1, "the last entry of beta is 0: a member must be implicit"));
        }
        if reads(&steps) != q {
            let text =
                Text::new().str("the member of order ").number(q).str(" must read as many old y and f, not ");
            return Err(shape(grid.line(r), text.number(reads(&steps))));
        }
        members.steps[q - 1] = steps;
        q += 1;
    }
    Ok(Scheme::Nordsieck(members))
}

const fn predictor_corrector(file: &File) -> Result<Scheme, TableauError> {
    let predictor = ok!(steps(file, Key::Predictor));
    let corrector = ok!(steps(file, Key::Corrector));
    if predictor.beta[predictor.k].hi() != 0.0 {
        let text = "the last entry of the predictor's beta must be 0: it belongs to f at the new y";
        return Err(shape(file.line(Key::Predictor), Text::new().str(text)));
    }
    if corrector.beta[corrector.k].hi() == 0.0 {
        let text = "the last entry of the corrector's beta is 0: the predicted value is never used";
        return Err(shape(file.line(Key::Corrector), Text::new().str(text)));
    }
    let mode = file.string(Key::Mode).as_bytes();
    let evaluates = is(mode, "PECE");
    if !evaluates && !is(mode, "PEC") {
        return Err(syntax(file.line(Key::Mode), Text::new().str("\"mode\" is \"PECE\" or \"PEC\"")));
    }
    Ok(Scheme::PredictorCorrector { predictor, corrector, evaluates })
}

/// Lines `drift w` and `kick w`.
const fn splitting(file: &File) -> Result<Scheme, TableauError> {
    let grid = ok!(Grid::read(file, Key::Splitting, Layout::Word));
    let mut splitting = Splitting { len: grid.rows, kick: [false; ROWS], weight: [D::ZERO; ROWS] };
    let (mut i, mut kicks) = (0, 0);
    while i < grid.rows {
        let kick = grid.labelled(i, "kick");
        if !kick && !grid.labelled(i, "drift") || grid.width[i] != 1 {
            return Err(grid.refuse(i, "a row of a splitting is drift or kick and one number"));
        }
        kicks += kick as usize;
        if kicks > STAGES {
            let text = Text::new().str("a splitting has at most ").number(STAGES).str(" kicks");
            return Err(shape(grid.line(i), text));
        }
        splitting.kick[i] = kick;
        splitting.weight[i] = grid.entry[i][0];
        i += 1;
    }
    Ok(Scheme::Splitting(splitting))
}

/// The entries of a grid as they are printed, row by row: what stands before a bar first, then the rest;
/// a rule is an empty row. `None` where `text` is no method file or has no such grid.
pub fn entries<'t>(text: &'t str, key: &str) -> Option<Vec<Vec<&'t str>>> {
    let file = File::scan(text).ok()?;
    let key = Key::ALL.iter().copied().find(|k| k.text() == key && k.is_grid() && file.has(*k))?;
    let rows = file.string(key).lines().map(str::trim).filter(|row| !row.is_empty());
    Some(
        rows.map(|row| match row.split_once('|') {
            _ if row.trim_matches(['-', '+', ' ', '\t']).is_empty() => Vec::new(),
            Some((before, after)) => {
                std::iter::once(before.trim()).chain(after.split_ascii_whitespace()).collect()
            }
            None => row.split_ascii_whitespace().collect(),
        })
        .collect(),
    )
}

/// The value of one entry, as [`entries`] gives it; `None` where it is no number.
pub fn value(entry: &str) -> Option<D> {
    match number(entry.as_bytes()) {
        Ok((x, [])) => Some(x),
        _ => None,
    }
}
