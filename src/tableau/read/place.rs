//! A place in the text of a file, and steps forward from it.

use super::file::syntax;
use crate::tableau::error::{TableauError, Text};

/// `"word"`, its end left out where it is long; control characters become question marks.
pub(super) const fn quote(mut text: Text, word: &[u8]) -> Text {
    const LONGEST: usize = 60;
    let mut end = if word.len() < LONGEST { word.len() } else { LONGEST };
    // Bytes 10xxxxxx continue a character.
    while end < word.len() && word[end] & 0xc0 == 0x80 {
        end -= 1;
    }
    text = text.str("\"");
    let mut i = 0;
    while i < end {
        text = if word[i].is_ascii_control() { text.str("?") } else { text.bytes(word, i, i + 1) };
        i += 1;
    }
    text.str(if end < word.len() { "..\"" } else { "\"" })
}

/// A place in a file: `rest` is what follows in `all`.
#[derive(Clone, Copy)]
pub(super) struct Place<'b> {
    pub all: &'b [u8],
    pub rest: &'b [u8],
}

impl<'b> Place<'b> {
    pub const fn at(&self) -> usize {
        self.all.len() - self.rest.len()
    }

    pub const fn line(&self) -> usize {
        line(self.all, self.at())
    }

    pub const fn refuse(&self, text: Text) -> TableauError {
        syntax(self.line(), text)
    }

    pub const fn skip_blanks(&mut self) {
        loop {
            match self.rest {
                [b' ' | b'\t', rest @ ..] => self.rest = rest,
                [b'\r', rest @ ..] if matches!(rest, [b'\n', ..]) => self.rest = rest,
                _ => break,
            }
        }
    }

    /// The bytes up to a blank, a line's end, or `stop`.
    pub const fn word(&mut self, stop: u8) -> &'b [u8] {
        let word = self.rest;
        loop {
            match self.rest {
                [] | [b' ' | b'\t' | b'\n', ..] | [b'\r', b'\n', ..] => break,
                [first, ..] if *first == stop => break,
                [_, rest @ ..] => self.rest = rest,
            }
        }
        word.split_at(word.len() - self.rest.len()).0
    }

    /// Goes on to the line's end or to `stop`, in quotes to a backslash too. TOML allows no control
    /// characters on the way.
    pub const fn pass(&mut self, stop: u8) -> Result<(), TableauError> {
        loop {
            match self.rest {
                [] | [b'\n', ..] | [b'\r', b'\n', ..] => return Ok(()),
                [first, ..] if *first == stop => return Ok(()),
                [b'\\', ..] if stop == b'"' => return Ok(()),
                [0..=8 | 11..=31 | 127, ..] => {
                    return Err(self.refuse(Text::new().str("remove the control character from this line")));
                }
                [_, rest @ ..] => self.rest = rest,
            }
        }
    }

    /// Steps over `mark` if it comes next.
    pub const fn eat(&mut self, mark: u8) -> bool {
        match self.rest {
            [first, rest @ ..] if *first == mark => {
                self.rest = rest;
                true
            }
            _ => false,
        }
    }

    /// Goes on to the next single quote or to the end, sixteen bytes at a time where it can.
    pub const fn find_quote(&mut self) {
        const ONES: u128 = u128::from_le_bytes([1; 16]);
        let (blocks, mut at) = (self.all.as_chunks::<16>().0, self.at());
        while at < self.all.len() && self.all[at] != b'\'' {
            at += 1;
            while at % 16 == 0 && at / 16 < blocks.len() {
                // A quote is a zero byte of x: the first byte to borrow, though it is below 128.
                let x = u128::from_le_bytes(blocks[at / 16]) ^ (b'\'' as u128 * ONES);
                if x.wrapping_sub(ONES) & !x & (128 * ONES) != 0 {
                    break;
                }
                at += 16;
            }
        }
        self.rest = self.all.split_at(at).1;
    }
}

/// The line of a byte, counted from 1.
pub(super) const fn line(bytes: &[u8], at: usize) -> usize {
    let (mut line, mut i) = (1, 0);
    while i < at {
        line += (bytes[i] == b'\n') as usize;
        i += 1;
    }
    line
}

pub(super) const fn is(bytes: &[u8], word: &str) -> bool {
    let word = word.as_bytes();
    if bytes.len() != word.len() {
        return false;
    }
    let mut i = 0;
    while i < word.len() {
        if bytes[i] != word[i] {
            return false;
        }
        i += 1;
    }
    true
}
