//! Butcher arrays from their grids: Runge-Kutta methods, pairs, Rosenbrock and Nystrom methods.

use super::file::{File, Key, about, shape};
use super::grid::{Grid, Layout, count};
use super::ok;
use crate::tableau::error::{TableauError, Text};
use crate::tableau::{Array, D, POWERS, STAGES, Scheme};

const EMPTY: Array = Array {
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

/// Where the rows of A may have entries.
#[derive(Clone, Copy)]
enum Filled {
    Anywhere,
    ToDiagonal,
    BelowDiagonal,
}

/// What stands before the bar of a stage.
#[derive(Clone, Copy)]
enum Before {
    C,
    /// c is the sum of the row.
    Nothing,
}

/// The first `stages` rows of a grid: c and A.
const fn matrix(grid: &Grid, stages: usize, before: Before, filled: Filled) -> Result<Array, TableauError> {
    if stages > STAGES {
        let text = Text::new().str("the method has ").number(stages).str(" stages; at most ");
        return Err(shape(grid.line(STAGES), text.number(STAGES).str(" are possible")));
    }
    let mut array = EMPTY;
    array.stages = stages;
    let mut i = 0;
    while i < stages {
        if grid.width[i] > stages {
            return Err(grid.misfit(i, stages));
        }
        array.a[i] = grid.entry[i];
        array.c[i] = match before {
            Before::C => ok!(grid.c(i)),
            Before::Nothing => {
                ok!(grid.unlabelled(i));
                sum(&array.a[i])
            }
        };
        let mut j = match filled {
            Filled::Anywhere => stages,
            Filled::ToDiagonal => i + 1,
            Filled::BelowDiagonal => i,
        };
        while j < stages {
            if array.a[i][j].hi() != 0.0 {
                let place = if j == i {
                    " array has an entry on the diagonal"
                } else {
                    " array has an entry above the diagonal"
                };
                return Err(shape(grid.line(i), Text::new().str("the ").str(grid.key.text()).str(place)));
            }
            j += 1;
        }
        i += 1;
    }
    Ok(array)
}

const fn sum(row: &[D; STAGES]) -> D {
    let (mut sum, mut j) = (D::ZERO, 0);
    while j < STAGES {
        sum = sum.plus(row[j]);
        j += 1;
    }
    sum
}

/// A grid of stages alone, without c.
const fn square(file: &File, key: Key, stages: usize, filled: Filled) -> Result<Array, TableauError> {
    let grid = ok!(Grid::read(file, key, Layout::Bar));
    ok!(grid.unruled());
    if grid.rows != stages {
        return Err(rows(&grid, stages));
    }
    matrix(&grid, stages, Before::Nothing, filled)
}

/// Stages, rule, b, at most two rows of bhat.
const fn array(file: &File, key: Key, before: Before, filled: Filled) -> Result<Array, TableauError> {
    let grid = ok!(Grid::read(file, key, Layout::Bar));
    let s = grid.above;
    if s == 0 {
        return Err(grid.refuse(0, "the stages are missing above the rule"));
    }
    if grid.rows == s {
        return Err(grid.refuse(s - 1, "below the stages a rule of dashes and a row of b are missing"));
    }
    if grid.rows > s + 3 {
        return Err(grid.refuse(s + 3, "below the rule stand b and at most two rows of bhat"));
    }
    let mut array = ok!(matrix(&grid, s, before, filled));
    array.lower = grid.rows - s - 1;
    let mut r = s;
    while r < grid.rows {
        ok!(grid.unlabelled(r));
        ok!(grid.complete(r, s));
        if r == s {
            array.b = grid.entry[r];
        } else {
            array.bhat[r - s - 1] = grid.entry[r];
        }
        r += 1;
    }
    Ok(array)
}

pub(super) const fn imex(file: &File) -> Result<Scheme, TableauError> {
    let explicit = ok!(array(file, Key::Explicit, Before::C, Filled::BelowDiagonal));
    let implicit = ok!(array(file, Key::Implicit, Before::C, Filled::Anywhere));
    ok!(alike(file.line(Key::Implicit), &explicit, &implicit));
    Ok(Scheme::Imex { explicit, implicit })
}

pub(super) const fn partitioned(file: &File) -> Result<Scheme, TableauError> {
    let position = ok!(array(file, Key::Position, Before::C, Filled::Anywhere));
    let velocity = ok!(array(file, Key::Velocity, Before::C, Filled::Anywhere));
    ok!(alike(file.line(Key::Velocity), &position, &velocity));
    Ok(Scheme::Partitioned { position, velocity })
}

/// Both arrays of a pair have the same stages and the same rows of weights.
const fn alike(line: usize, one: &Array, other: &Array) -> Result<(), TableauError> {
    if one.stages == other.stages && one.lower == other.lower {
        return Ok(());
    }
    let text = "the arrays of a pair need the same number of stages and of rows of weights";
    Err(shape(line, Text::new().str(text)))
}

pub(super) const fn rosenbrock(file: &File) -> Result<Scheme, TableauError> {
    let alpha = ok!(array(file, Key::Alpha, Before::Nothing, Filled::BelowDiagonal));
    let gamma = ok!(square(file, Key::Gamma, alpha.stages, Filled::ToDiagonal));
    Ok(Scheme::Rosenbrock { alpha, gamma })
}

pub(super) const fn runge_kutta(file: &File) -> Result<Scheme, TableauError> {
    let mut array = ok!(array(file, Key::Tableau, Before::C, Filled::Anywhere));
    let s = array.stages;
    if file.has(Key::DenseStages) {
        let grid = ok!(Grid::read(file, Key::DenseStages, Layout::Bar));
        ok!(grid.unruled());
        let mut i = 0;
        while i < grid.rows {
            if s + i == STAGES {
                let text =
                    Text::new().str("stages and dense_stages are at most ").number(STAGES).str(" together");
                return Err(shape(grid.line(i), text));
            }
            if grid.width[i] > s + i {
                return Err(
                    grid.refuse(i, "a stage of the dense output may use none but the stages before it")
                );
            }
            array.a[s + i] = grid.entry[i];
            array.c[s + i] = ok!(grid.c(i));
            i += 1;
        }
        array.extra = grid.rows;
    }
    if file.has(Key::Dense) {
        let grid = ok!(Grid::read(file, Key::Dense, Layout::Plain));
        if grid.rows != s + array.extra {
            return Err(rows(&grid, s + array.extra));
        }
        let mut i = 0;
        while i < grid.rows {
            if grid.width[i] > POWERS {
                return Err(too_many_powers(grid.line(i)));
            }
            if grid.width[i] > array.powers {
                array.powers = grid.width[i];
            }
            let mut k = 0;
            while k < POWERS {
                array.dense[i][k] = grid.entry[i][k];
                k += 1;
            }
            i += 1;
        }
    }
    Ok(Scheme::RungeKutta(array))
}

const fn rows(grid: &Grid, stages: usize) -> TableauError {
    let text = count(about("the grid ", grid.key, " has "), grid.rows, " row", " rows");
    shape(grid.line(grid.rows - 1), count(text.str(" but the method has "), stages, " stage", " stages"))
}

const fn too_many_powers(line: usize) -> TableauError {
    shape(line, Text::new().str("a dense output has at most ").number(POWERS).str(" powers of theta"))
}

/// From the variables U = Gamma k of a published table to k itself (Hairer, Wanner 1996, section IV.7):
/// Gamma = (diag(1 / gamma) - C)^-1, alpha = A Gamma, b = m Gamma.
pub(super) const fn transformed(file: &File) -> Result<Scheme, TableauError> {
    let mut alpha = ok!(array(file, Key::A, Before::Nothing, Filled::BelowDiagonal));
    let s = alpha.stages;
    let c = ok!(square(file, Key::C, s, Filled::BelowDiagonal));
    let one = ok!(Grid::read(file, Key::Gamma, Layout::Bar));
    if one.rows != 1 || one.ruled || one.width[0] != 1 || one.entry[0][0].hi() == 0.0 {
        return Err(
            one.refuse(0, "beside \"a\" and \"c\", \"gamma\" is one row with one number other than 0")
        );
    }
    ok!(one.unlabelled(0));
    let g = one.entry[0][0];
    let mut gamma = Array { stages: s, ..EMPTY };
    let mut i = 0;
    while i < s {
        let mut row = times(&c.a[i], &gamma.a);
        row[i] = D::ONE;
        let mut j = 0;
        while j <= i {
            gamma.a[i][j] = g.times(row[j]);
            j += 1;
        }
        gamma.c[i] = sum(&gamma.a[i]);
        i += 1;
    }
    if file.has(Key::Dense) {
        let grid = ok!(Grid::read(file, Key::Dense, Layout::Plain));
        if grid.rows >= POWERS {
            return Err(too_many_powers(grid.line(POWERS - 1)));
        }
        alpha.powers = grid.rows + 1;
        let mut r = 0;
        while r < grid.rows {
            ok!(grid.complete(r, s));
            r += 1;
        }
        // y + theta (m U + (1 - theta) (H_1 U + theta H_2 U + ..)), sorted by powers of theta.
        let mut k = 0;
        while k <= grid.rows {
            let (mut row, mut j) = ([D::ZERO; STAGES], 0);
            while j < s {
                let before = if k == 0 { alpha.b[j] } else { grid.entry[k - 1][j].neg() };
                row[j] = if k < grid.rows { before.plus(grid.entry[k][j]) } else { before };
                j += 1;
            }
            let row = times(&row, &gamma.a);
            let mut j = 0;
            while j < s {
                alpha.dense[j][k] = row[j];
                j += 1;
            }
            k += 1;
        }
    }
    let mut i = 0;
    while i < s {
        alpha.a[i] = times(&alpha.a[i], &gamma.a);
        alpha.c[i] = sum(&alpha.a[i]);
        i += 1;
    }
    alpha.b = times(&alpha.b, &gamma.a);
    alpha.bhat = [times(&alpha.bhat[0], &gamma.a), times(&alpha.bhat[1], &gamma.a)];
    Ok(Scheme::Rosenbrock { alpha, gamma })
}

/// A row times a lower triangular matrix.
const fn times(row: &[D; STAGES], matrix: &[[D; STAGES]; STAGES]) -> [D; STAGES] {
    let (mut product, mut k) = ([D::ZERO; STAGES], 0);
    while k < STAGES {
        let mut j = 0;
        while j <= k && row[k].hi() != 0.0 {
            product[j] = product[j].plus(row[k].times(matrix[k][j]));
            j += 1;
        }
        k += 1;
    }
    product
}

/// Stages, rule, the weights of y, the weights of y'.
pub(super) const fn nystrom(file: &File) -> Result<Scheme, TableauError> {
    let grid = ok!(Grid::read(file, Key::Nystrom, Layout::Bar));
    let s = grid.above;
    if s == 0 || grid.rows != s + 2 || !grid.labelled(s, "y") || !grid.labelled(s + 1, "v") {
        let text = "a Nystrom grid is stages, a rule of dashes, a row y | .. and a row v | ..";
        return Err(grid.refuse(grid.rows - 1, text));
    }
    ok!(grid.complete(s, s));
    ok!(grid.complete(s + 1, s));
    let mut array = ok!(matrix(&grid, s, Before::C, Filled::BelowDiagonal));
    array.b = grid.entry[s + 1];
    Ok(Scheme::Nystrom { array, bbar: grid.entry[s] })
}
