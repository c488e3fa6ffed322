//! A finite-difference stencil as data.

use super::prove::prove;
use crate::tableau::{self, DoubleDouble as D, TableauError};

/// Most taps of a row.
pub const TAPS: usize = 16;

/// A row of taps: the weights at the whole offsets `first`, `first + 1`, .. in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    pub first: isize,
    pub len: usize,
    pub weight: [D; TAPS],
}

impl Taps {
    /// The offset of the last tap.
    pub const fn last(&self) -> isize {
        self.first + self.len as isize - 1
    }

    /// Each offset with its weight.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (isize, D)> + ExactSizeIterator + Clone + '_ {
        (0..self.len).map(|j| (self.first + j as isize, self.weight[j]))
    }
}

/// A stencil for the slope along one axis, in texels: `along` takes the difference along that axis, `across`
/// smooths along the other one, and `left`, where it has more than one tap, is the left-hand side of a compact
/// scheme: sum left_j b'_(i+j) = sum along_j b_(i+j).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil<'t> {
    pub title: &'t str,
    /// Author, year, publication.
    pub cite: &'t str,
    pub note: &'t str,
    /// Claimed order along the axis.
    pub order: usize,
    /// Correct decimal digits of the entries; 0 where they are exact.
    pub digits: usize,
    /// Where the difference lives, in texels from the texel it is stored at: 0, 1/2 or -1/2.
    pub at: D,
    pub along: Taps,
    /// One tap of weight 1 where there is no smoothing.
    pub across: Taps,
    /// One tap of weight 1 where the stencil is explicit.
    pub left: Taps,
}

impl<'t> Stencil<'t> {
    /// Reads and proves a stencil file.
    ///
    /// # Errors
    /// The line, the entry or the moment that is wrong, in the words of the compiler.
    pub fn parse(text: &'t str) -> Result<Self, TableauError> {
        let (stencil, isotropic) = tableau::stencil(text)?;
        prove(&stencil, isotropic)?;
        Ok(stencil)
    }
}

/// What [`stencil!`](crate::stencil!) makes of a file.
///
/// # Panics
/// Where [`Stencil::parse`] gives an error; in a constant that stops the compiler.
pub const fn compile<'t>(path: &str, text: &'t str) -> Stencil<'t> {
    let (stencil, isotropic) = match tableau::stencil(text) {
        Ok(read) => read,
        Err(error) => panic!("{}", error.message(path).as_str()),
    };
    match prove(&stencil, isotropic) {
        Ok(()) => stencil,
        Err(error) => panic!("{}", error.message(path).as_str()),
    }
}

/// The stencil of a file, read and proven by the compiler: a constant expression.
///
/// ```
/// use kutta::normals::Stencil;
///
/// const SOBEL: Stencil = kutta::stencil!("../../tableaus/stencils/sobel3.toml");
/// assert_eq!(SOBEL.along.weight[2].hi(), 0.5);
/// ```
///
/// The path is relative to the calling file. A wrong digit does not compile: the message names the file,
/// the line or the moment that is off, and by how much.
#[macro_export]
macro_rules! stencil {
    ($path:expr) => {
        const { $crate::normals::compile($path, include_str!($path)) }
    };
}
