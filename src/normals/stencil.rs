//! A finite-difference stencil as data.

use crate::tableau::DoubleDouble as D;

/// Most taps of a row.
pub const TAPS: usize = 16;

/// A row of taps: the weights at the whole offsets `first`, `first + 1`, .. in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taps {
    pub first: isize,
    pub len: usize,
    pub weight: [D; TAPS],
}

/// A stencil for the slope along one axis, in texels: `along` takes the difference along that axis, `across`
/// smooths along the other one, and `left`, where it has more than one tap, is the left-hand side of a compact
/// scheme: sum left_j b'_(i+j) = sum along_j b_(i+j).
#[derive(Clone, Copy)]
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
