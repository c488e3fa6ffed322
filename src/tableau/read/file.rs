//! A method or stencil file as lines `key = value`: a strict subset of TOML, each key known and given once.

use super::ok;
use super::place::{Place, is, line, quote};
use crate::tableau::error::{Broken, TableauError, Text};

/// What stands behind a key's `=`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// `"..."` without escapes.
    Text,
    /// `4` or `[5, 3]`.
    Integers,
    /// `'''`, rows, `'''`.
    Grid,
}

macro_rules! keys {
    ($($key:ident $text:literal $kind:ident;)*) => {
        #[derive(Clone, Copy)]
        pub(super) enum Key { $($key),* }

        impl Key {
            pub const ALL: &[Key] = &[$(Key::$key),*];

            pub const fn text(self) -> &'static str {
                match self { $(Key::$key => $text),* }
            }

            pub const fn is_grid(self) -> bool {
                matches!(self.kind(), Kind::Grid)
            }

            const fn kind(self) -> Kind {
                match self { $(Key::$key => Kind::$kind),* }
            }
        }
    };
}
keys! {
    Name "name" Text;
    Cite "cite" Text;
    Note "note" Text;
    Mode "mode" Text;
    Order "order" Integers;
    Embedded "embedded" Integers;
    DenseOrder "dense_order" Integers;
    Digits "digits" Integers;
    Tableau "tableau" Grid;
    Dense "dense" Grid;
    DenseStages "dense_stages" Grid;
    Explicit "explicit" Grid;
    Implicit "implicit" Grid;
    Position "position" Grid;
    Velocity "velocity" Grid;
    Alpha "alpha" Grid;
    Gamma "gamma" Grid;
    A "a" Grid;
    C "c" Grid;
    Multistep "multistep" Grid;
    Stormer "stormer" Grid;
    Nordsieck "nordsieck" Grid;
    Predictor "predictor" Grid;
    Corrector "corrector" Grid;
    Nystrom "nystrom" Grid;
    Splitting "splitting" Grid;
    At "at" Text;
    Isotropic "isotropic" Integers;
    Stencil "stencil" Grid;
    Smooth "smooth" Grid;
    Left "left" Grid;
}

/// The bytes of a value, those of a text without its quotes; 0, 0 where the key is absent.
#[derive(Clone, Copy)]
struct Value {
    from: usize,
    to: usize,
}

#[derive(Clone, Copy)]
pub(super) struct File<'t> {
    text: &'t str,
    values: [Value; Key::ALL.len()],
}

pub(super) const fn syntax(line: usize, text: Text) -> TableauError {
    TableauError::new(Broken::Syntax, line, 0.0, text)
}

pub(super) const fn shape(line: usize, text: Text) -> TableauError {
    TableauError::new(Broken::Shape, line, 0.0, text)
}

/// `before "key" after`, the usual message about a key.
pub(super) const fn about(before: &str, key: Key, after: &str) -> Text {
    Text::new().str(before).str("\"").str(key.text()).str("\"").str(after)
}

impl<'t> File<'t> {
    pub const fn scan(text: &'t str) -> Result<Self, TableauError> {
        let all = text.as_bytes();
        let mut file = Self { text, values: [Value { from: 0, to: 0 }; Key::ALL.len()] };
        let mut place = Place { all, rest: all };
        loop {
            place.skip_blanks();
            match place.rest {
                [] => return Ok(file),
                [b'\n', rest @ ..] => place.rest = rest,
                [b'#', ..] => ok!(place.pass(b'\n')),
                _ => ok!(file.take(&mut place)),
            }
        }
    }

    /// Takes `key = value`.
    const fn take(&mut self, place: &mut Place) -> Result<(), TableauError> {
        let word = place.word(b'=');
        place.skip_blanks();
        if word.is_empty() || !place.eat(b'=') {
            return Err(place.refuse(Text::new().str("expected key = value")));
        }
        let mut k = 0;
        while k < Key::ALL.len() && !is(word, Key::ALL[k].text()) {
            k += 1;
        }
        if k == Key::ALL.len() {
            return Err(place.refuse(quote(Text::new().str("unknown key "), word)));
        }
        let key = Key::ALL[k];
        if self.has(key) {
            return Err(
                place.refuse(about("the key ", key, " was given already on line ").number(self.line(key)))
            );
        }
        place.skip_blanks();
        self.values[k] = match key.kind() {
            Kind::Text => ok!(string(place, key)),
            Kind::Integers => integers(place),
            Kind::Grid => ok!(grid(place, key)),
        };
        place.skip_blanks();
        match place.rest {
            [] | [b'\n' | b'#', ..] => Ok(()),
            _ => Err(place.refuse(about("nothing but a comment may follow the value of ", key, ""))),
        }
    }

    pub const fn has(&self, key: Key) -> bool {
        self.values[key as usize].from > 0
    }

    /// No key at all is given.
    pub const fn is_empty(&self) -> bool {
        let mut k = 0;
        while k < self.values.len() && self.values[k].from == 0 {
            k += 1;
        }
        k == self.values.len()
    }

    /// Line of a key; 0 where it is absent.
    pub const fn line(&self, key: Key) -> usize {
        // The byte before a value is still in the line of its key: a quote, a blank, a grid's first line end.
        if self.has(key) { line(self.text.as_bytes(), self.values[key as usize].from - 1) } else { 0 }
    }

    /// A value as it is written; empty where the key is absent.
    pub const fn string(&self, key: Key) -> &'t str {
        let Value { from, to } = self.values[key as usize];
        self.text.split_at(to).0.split_at(from).1
    }

    /// The first row of a grid; its last one is the end.
    pub const fn rows(&self, key: Key) -> Place<'t> {
        let Value { from, to } = self.values[key as usize];
        let all = self.text.as_bytes().split_at(to).0;
        Place { all, rest: all.split_at(from).1 }
    }

    /// A whole number from 1 to `largest`; 0 where the key is absent.
    pub const fn integer(&self, key: Key, largest: usize) -> Result<usize, TableauError> {
        match whole(self.string(key).as_bytes(), largest) {
            (0, _) if !self.has(key) => Ok(0),
            (n, []) if n > 0 => Ok(n),
            _ => Err(syntax(self.line(key), about("", key, " is a whole number from 1 to ").number(largest))),
        }
    }

    /// `4` or `[5, 3]`; 0 for what is absent.
    pub const fn integers(&self, key: Key, largest: usize) -> Result<[usize; 2], TableauError> {
        let mut place = self.rows(key);
        let list = place.eat(b'[');
        place.skip_blanks();
        let (first, rest) = whole(place.rest, largest);
        place.rest = rest;
        if !list {
            return match self.integer(key, largest) {
                Ok(n) => Ok([n, 0]),
                Err(error) => Err(syntax(error.line, error.text.str(", or two as in [5, 3]"))),
            };
        }
        place.skip_blanks();
        let comma = place.eat(b',');
        place.skip_blanks();
        let (second, rest) = whole(place.rest, largest);
        place.rest = rest;
        place.skip_blanks();
        if first > 0 && comma && second > 0 && matches!(place.rest, [b']']) {
            return Ok([first, second]);
        }
        let text = about("", key, " takes two whole numbers from 1 to ").number(largest);
        Err(syntax(self.line(key), text.str(", as in [5, 3]")))
    }
}

/// The number that `text` begins with, 0 where it is none from 1 to `largest`, and what follows it.
const fn whole(mut text: &[u8], largest: usize) -> (usize, &[u8]) {
    let (mut n, padded) = (0, matches!(text, [b'0', ..]));
    while let [digit @ b'0'..=b'9', rest @ ..] = text
        && n <= largest
    {
        n = 10 * n + (*digit - b'0') as usize;
        text = rest;
    }
    (if padded || n > largest { 0 } else { n }, text)
}

/// `"..."`
const fn string(place: &mut Place, key: Key) -> Result<Value, TableauError> {
    let opens = place.eat(b'"');
    let from = place.at();
    ok!(place.pass(b'"'));
    let value = Value { from, to: place.at() };
    if opens && place.eat(b'"') {
        return Ok(value);
    }
    Err(place.refuse(about("", key, " is a text in double quotes, with no quotes or backslashes in it")))
}

/// Whatever stands before the line's end or a comment.
const fn integers(place: &mut Place) -> Value {
    let mut value = Value { from: place.at(), to: place.at() };
    while !matches!(place.rest, [] | [b'\n' | b'#', ..]) {
        place.word(b'#');
        value.to = place.at();
        place.skip_blanks();
    }
    value
}

/// `'''`, lines without a single quote in them, a line that begins with `'''`.
const fn grid(place: &mut Place, key: Key) -> Result<Value, TableauError> {
    let opening = *place;
    let opens = place.eat(b'\'') && place.eat(b'\'') && place.eat(b'\'');
    place.skip_blanks();
    if !opens || !place.eat(b'\n') {
        let text =
            about("", key, " is a grid: ''' at the end of this line, rows below, ''' in a line of its own");
        return Err(opening.refuse(text));
    }
    let from = place.at();
    place.find_quote();
    let closing = *place;
    let mut to = closing.at();
    while to > from && matches!(closing.all[to - 1], b' ' | b'\t') {
        to -= 1;
    }
    let alone = closing.all[to - 1] == b'\n';
    if alone && place.eat(b'\'') && place.eat(b'\'') && place.eat(b'\'') {
        return Ok(Value { from, to });
    }
    let text = about("the grid ", key, " ends with ''' in a line of its own");
    Err(if closing.rest.is_empty() { opening.refuse(text) } else { closing.refuse(text) })
}
