//! Why a tableau is refused, said by the compiler and at run time in the same words.

use std::fmt;

/// Longest message, in bytes; what is longer is cut.
const LONGEST: usize = 240;

/// A message a `const fn` can write.
#[derive(Clone, Copy)]
pub struct Text {
    bytes: [u8; LONGEST],
    len: usize,
}

impl Text {
    pub const fn new() -> Self {
        Self { bytes: [0; LONGEST], len: 0 }
    }

    /// Appends a string, byte by byte; a character is never cut in half.
    pub const fn str(self, s: &str) -> Self {
        self.bytes(s.as_bytes(), 0, s.len())
    }

    /// Appends `bytes[from..to]`, which must lie on character borders.
    pub const fn bytes(mut self, bytes: &[u8], from: usize, to: usize) -> Self {
        if self.len + (to - from) <= LONGEST {
            let mut i = from;
            while i < to {
                self.bytes[self.len] = bytes[i];
                self.len += 1;
                i += 1;
            }
        }
        self
    }

    pub const fn number(self, n: usize) -> Self {
        let text = if n >= 10 { self.number(n / 10) } else { self };
        text.bytes(&[b'0' + (n % 10) as u8], 0, 1)
    }

    /// Appends the size of a number to one digit: 2e-3.
    pub const fn size(self, x: f64) -> Self {
        let mut x = if x < 0.0 { -x } else { x };
        if !x.is_finite() {
            return self.str("infinity");
        }
        if x == 0.0 {
            return self.str("0");
        }
        let mut exponent = 0;
        while x >= 9.5 {
            x /= 10.0;
            exponent += 1;
        }
        while x < 0.95 {
            x *= 10.0;
            exponent -= 1;
        }
        let text = self.number((x + 0.5) as usize);
        if exponent == 0 {
            text
        } else if exponent > 0 {
            text.str("e").number(exponent as usize)
        } else {
            text.str("e-").number(-exponent as usize)
        }
    }

    pub const fn as_str(&self) -> &str {
        match std::str::from_utf8(self.bytes.split_at(self.len).0) {
            Ok(s) => s,
            Err(_) => "the message is not UTF-8",
        }
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::new()
    }
}

/// What kind of law a tableau breaks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Broken {
    /// The file is not of the accepted subset of TOML, or a key is unknown, missing or doubled.
    Syntax,
    /// An entry is not a number.
    Number,
    /// A grid has too few or too many rows, columns or stages.
    Shape,
    /// A row of A does not sum to its c.
    RowSum,
    /// A rooted-tree condition of the claimed order fails.
    Order,
    /// A condition of the claimed embedded order fails.
    EmbeddedOrder,
    /// A condition of the claimed dense-output order fails.
    DenseOrder,
    /// A moment of a stencil is not what its claims need.
    Moment,
    /// Weights of a stencil that lie symmetrically are neither alike nor opposite.
    Symmetry,
    /// The characteristic roots of a multistep method leave the unit disc, or a double one lies on it.
    ZeroStability,
    /// The table is right, but no stepper runs its family yet.
    NotSteppable,
}

/// A tableau was refused: where, why, and by how much.
#[derive(Clone, Copy)]
pub struct TableauError {
    /// Line of the file, counted from 1; 0 where the whole file is meant.
    pub line: usize,
    pub broken: Broken,
    /// How far a condition is off; 0 where nothing was measured.
    pub off_by: f64,
    pub text: Text,
}

impl TableauError {
    pub const fn new(broken: Broken, line: usize, off_by: f64, text: Text) -> Self {
        Self { line, broken, off_by, text }
    }

    pub(crate) fn not_steppable() -> Self {
        let text = Text::new().str(
            "it is a pair whose stages would have to be found together: read and proven, but not stepped",
        );
        Self::new(Broken::NotSteppable, 0, 0.0, text)
    }

    /// `path:line: text`, as the compiler prints it.
    pub const fn message(&self, path: &str) -> Text {
        let text = Text::new().str(path);
        let text = if self.line > 0 { text.str(":").number(self.line) } else { text };
        text.str(": ").str(self.text.as_str())
    }
}

impl fmt::Display for TableauError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.line > 0 {
            write!(f, "line {}: ", self.line)?;
        }
        f.write_str(self.text.as_str())
    }
}

impl fmt::Debug for TableauError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "TableauError({:?}, off by {:e}: {self})", self.broken, self.off_by)
    }
}

impl std::error::Error for TableauError {}
