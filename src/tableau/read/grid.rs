//! Rows of entries as books print them: `label | entry entry ..`, a rule of dashes, more rows.

use super::file::{File, Key, about, shape};
use super::ok;
use super::place::{Place, is, quote};
use crate::tableau::error::{Broken, TableauError, Text};
use crate::tableau::number::{Flaw, number};
use crate::tableau::{D, STAGES};

/// Most rows of a grid: a splitting is the longest.
pub(super) const ROWS: usize = 2 * STAGES;

/// How the rows of a grid are written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// `1/2 | 1/4 1/4`, with `----` between stages and weights.
    Bar,
    /// `1/4 1/4`.
    Plain,
    /// `drift 1/2`.
    Word,
}

#[derive(Clone, Copy)]
pub(super) struct Grid<'b> {
    pub key: Key,
    pub rows: usize,
    pub ruled: bool,
    /// Rows above the rule; all of them where there is none.
    pub above: usize,
    places: [Place<'b>; ROWS],
    /// What stands before the bar, or the word.
    labels: [&'b [u8]; ROWS],
    pub width: [usize; ROWS],
    pub entry: [[D; STAGES]; ROWS],
}

impl<'b> Grid<'b> {
    pub const fn read(file: &File<'b>, key: Key, layout: Layout) -> Result<Self, TableauError> {
        let mut place = file.rows(key);
        let mut grid = Grid {
            key,
            rows: 0,
            ruled: false,
            above: 0,
            places: [place; ROWS],
            labels: [&[]; ROWS],
            width: [0; ROWS],
            entry: [[D::ZERO; STAGES]; ROWS],
        };
        loop {
            place.skip_blanks();
            if let [b'-' | b'+', ..] = place.rest
                && matches!(layout, Layout::Bar)
                && let Some(rest) = rule(place.rest)
            {
                if grid.ruled {
                    return Err(shape(place.line(), Text::new().str("remove this second rule of dashes")));
                }
                (grid.ruled, grid.above) = (true, grid.rows);
                place.rest = rest;
                continue;
            }
            match place.rest {
                [] => break,
                [b'\n', rest @ ..] => place.rest = rest,
                _ if grid.rows == ROWS => {
                    let text = Text::new().str("a grid has at most ").number(ROWS).str(" rows");
                    return Err(shape(place.line(), text));
                }
                _ => {
                    ok!(grid.row(&mut place, layout));
                    grid.rows += 1;
                }
            }
        }
        if grid.rows == 0 {
            return Err(shape(file.line(key), about("the grid ", key, " has no rows")));
        }
        if !grid.ruled {
            grid.above = grid.rows;
        }
        Ok(grid)
    }

    const fn row(&mut self, place: &mut Place<'b>, layout: Layout) -> Result<(), TableauError> {
        let r = self.rows;
        self.places[r] = *place;
        let mut labelled = matches!(layout, Layout::Plain);
        loop {
            match place.rest {
                [] | [b'\n', ..] if labelled => return Ok(()),
                [] | [b'\n', ..] => return Err(self.refuse(r, "this row has no bar |")),
                [b'|', ..] if labelled || !matches!(layout, Layout::Bar) => {
                    return Err(self.refuse(r, "there is a bar | too many in this row"));
                }
                [b'|', rest @ ..] => {
                    labelled = true;
                    place.rest = rest;
                }
                _ if labelled => {
                    let w = self.width[r];
                    if w == STAGES {
                        let text = Text::new().str("a row has at most ").number(STAGES).str(" entries");
                        return Err(shape(place.line(), text));
                    }
                    self.entry[r][w] = ok!(entry(place));
                    self.width[r] = w + 1;
                }
                _ if !self.labels[r].is_empty() => {
                    return Err(self.refuse(r, "put a bar | behind the first entry of this row"));
                }
                _ => {
                    self.labels[r] = place.word(b'|');
                    labelled = matches!(layout, Layout::Word);
                }
            }
            place.skip_blanks();
        }
    }

    pub const fn line(&self, r: usize) -> usize {
        self.places[r].line()
    }

    /// Refuses row `r`.
    pub const fn refuse(&self, r: usize, text: &str) -> TableauError {
        shape(self.line(r), Text::new().str(text))
    }

    /// The number before the bar of row `r`.
    pub const fn c(&self, r: usize) -> Result<D, TableauError> {
        self.before(r, "c")
    }

    /// The same where it is called otherwise.
    pub const fn before(&self, r: usize, what: &str) -> Result<D, TableauError> {
        if self.labels[r].is_empty() {
            return Err(shape(self.line(r), Text::new().str(what).str(" is missing before the bar |")));
        }
        entry(&mut { self.places[r] })
    }

    pub const fn unlabelled(&self, r: usize) -> Result<(), TableauError> {
        if self.labels[r].is_empty() {
            return Ok(());
        }
        Err(self.refuse(r, "nothing may stand before the bar | of this row"))
    }

    pub const fn labelled(&self, r: usize, word: &str) -> bool {
        is(self.labels[r], word)
    }

    /// Row `r` has an entry for each stage.
    pub const fn complete(&self, r: usize, stages: usize) -> Result<(), TableauError> {
        if self.width[r] == stages { Ok(()) } else { Err(self.misfit(r, stages)) }
    }

    pub const fn misfit(&self, r: usize, stages: usize) -> TableauError {
        let text = count(Text::new().str("the row has "), self.width[r], " entry", " entries");
        shape(self.line(r), count(text.str(" but the method has "), stages, " stage", " stages"))
    }

    /// Refuses a rule where all rows are alike.
    pub const fn unruled(&self) -> Result<(), TableauError> {
        if !self.ruled {
            return Ok(());
        }
        Err(shape(self.line(0), about("the grid ", self.key, " takes no rule of dashes")))
    }
}

/// `1 stage`, `2 stages`.
pub(super) const fn count(text: Text, n: usize, one: &str, many: &str) -> Text {
    text.number(n).str(if n == 1 { one } else { many })
}

/// One number, up to a blank, a bar or the line's end.
const fn entry(place: &mut Place) -> Result<D, TableauError> {
    let flaw = match number(place.rest) {
        Ok((x, rest)) if matches!(rest, [] | [b' ' | b'\t' | b'\n' | b'|', ..] | [b'\r', b'\n', ..]) => {
            place.rest = rest;
            return Ok(x);
        }
        Ok(_) => Flaw::Syntax,
        Err(flaw) => flaw,
    };
    let line = place.line();
    let text = quote(Text::new(), place.word(b'|')).str(" ").str(flaw.text());
    Err(TableauError::new(Broken::Number, line, 0.0, text))
}

/// What follows a row of dashes and plus signs alone; no entry is written so.
const fn rule(mut text: &[u8]) -> Option<&[u8]> {
    while let [b'-' | b'+' | b' ' | b'\t', rest @ ..] = text {
        text = rest;
    }
    match text {
        [] | [b'\n', ..] | [b'\r', b'\n', ..] => Some(text),
        _ => None,
    }
}
