//! A stencil file: grids whose rows are `offset | weight`.

use super::file::{File, Key, about, shape, syntax};
use super::grid::{Grid, Layout};
use super::place::is;
use super::{Family, HIGHEST, MOST_DIGITS, fits, missing, named, ok, scan};
use crate::normals::stencil::{Stencil, TAPS, Taps};
use crate::tableau::D;
use crate::tableau::error::{TableauError, Text};

const FAMILY: Family = Family {
    title: "a stencil",
    needs: &[Key::Stencil],
    may: &[Key::At, Key::Isotropic, Key::Smooth, Key::Left],
};

/// Farthest offset of a tap.
const FARTHEST: isize = TAPS as isize - 1;

/// Reads a stencil file: the stencil, and the power of h up to which its error is claimed to be isotropic.
pub(crate) const fn stencil(text: &str) -> Result<(Stencil<'_>, usize), TableauError> {
    let file =
        ok!(scan(text, "the file is empty: it needs name, order, cite and a stencil", "every stencil"));
    if !file.has(Key::Stencil) {
        return Err(match named(&file) {
            Some((family, key)) => syntax(
                file.line(key),
                about("the grid ", key, " makes this ").str(family.title).str(", not a stencil"),
            ),
            None => missing(Key::Stencil, FAMILY.title),
        });
    }
    ok!(fits(&file, &FAMILY));
    let stencil = Stencil {
        title: file.string(Key::Name),
        cite: file.string(Key::Cite),
        note: file.string(Key::Note),
        order: ok!(file.integer(Key::Order, HIGHEST)),
        digits: ok!(file.integer(Key::Digits, MOST_DIGITS)),
        at: ok!(place(&file)),
        along: ok!(taps(&file, Key::Stencil)),
        across: ok!(taps(&file, Key::Smooth)),
        left: ok!(left(&file)),
    };
    Ok((stencil, ok!(file.integer(Key::Isotropic, HIGHEST))))
}

/// Where the difference lives.
const fn place(file: &File) -> Result<D, TableauError> {
    let text = file.string(Key::At).as_bytes();
    if !file.has(Key::At) {
        Ok(D::ZERO)
    } else if is(text, "1/2") {
        Ok(D::of(0.5))
    } else if is(text, "-1/2") {
        Ok(D::of(-0.5))
    } else {
        let text = about("", Key::At, " is \"1/2\" or \"-1/2\"; without it the slope is that at the texel");
        Err(syntax(file.line(Key::At), text))
    }
}

/// The tridiagonal left side of a compact stencil.
const fn left(file: &File) -> Result<Taps, TableauError> {
    let taps = ok!(taps(file, Key::Left));
    if taps.first < -1 || taps.first + taps.len as isize > 2 {
        let text = about("the grid ", Key::Left, " takes the offsets -1, 0 and 1");
        return Err(shape(file.line(Key::Left), text));
    }
    Ok(taps)
}

/// Rows `offset | weight`, offsets ascending; one tap of weight 1 where the grid is left out.
const fn taps(file: &File, key: Key) -> Result<Taps, TableauError> {
    let mut taps = Taps { first: 0, len: 1, weight: [D::ZERO; TAPS] };
    taps.weight[0] = D::ONE;
    if !file.has(key) {
        return Ok(taps);
    }
    let grid = ok!(Grid::read(file, key, Layout::Bar));
    ok!(grid.unruled());
    let mut r = 0;
    while r < grid.rows {
        let offset = ok!(offset(&grid, r));
        if grid.width[r] != 1 {
            return Err(grid.refuse(r, "a row of a stencil is an offset, a bar and one weight"));
        }
        if r == 0 {
            (taps.first, taps.len) = (offset, 0);
        }
        let j = offset - taps.first;
        if j < taps.len as isize {
            return Err(grid.refuse(r, "the offsets must ascend"));
        }
        if j >= TAPS as isize {
            let text = Text::new().str("a row of taps spans at most ").number(TAPS).str(" texels");
            return Err(shape(grid.line(r), text));
        }
        if grid.entry[r][0].hi() == 0.0 {
            return Err(grid.refuse(r, "this tap has the weight 0: leave it out"));
        }
        taps.weight[j as usize] = grid.entry[r][0];
        taps.len = j as usize + 1;
        r += 1;
    }
    Ok(taps)
}

const fn offset(grid: &Grid, r: usize) -> Result<isize, TableauError> {
    let x = ok!(grid.before(r, "the offset"));
    let whole = x.hi() as isize;
    if x.hi().abs() <= FARTHEST as f64 && whole as f64 == x.hi() && x.lo() == 0.0 {
        return Ok(whole);
    }
    let text = Text::new().str("an offset is a whole number of texels from -").number(FARTHEST as usize);
    Err(shape(grid.line(r), text.str(" to ").number(FARTHEST as usize)))
}
