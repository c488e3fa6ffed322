//! Why a map is not baked.

use std::fmt;

/// Why a height map cannot be baked, with the numbers at fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BakeError {
    /// A map of no texels, or of more than memory can number.
    Size { width: usize, height: usize },
    /// A slice of `len` where the map needs `need` entries.
    Length { len: usize, need: usize },
    /// Heights that are NaN or infinite: how many, and the column and row of the first one, row 0 on top.
    NotFinite { count: usize, first: [usize; 2] },
    /// A height scale that is not finite.
    HeightScale(f64),
    /// The size of a texel is not above zero and finite.
    TexelSize([f64; 2]),
    /// Height scale over texel size leaves the range of `f32`.
    Slope { height_scale: f64, texel_size: [f64; 2] },
    /// The left-hand side of a compact stencil is not one of three taps around a larger middle one.
    LeftSide { taps: usize },
    /// Heights are had back from slopes of a map that wraps both ways only.
    NotWrapped,
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            BakeError::Size { width, height } => write!(f, "a map of {width} x {height} texels"),
            BakeError::Length { len, need } => write!(f, "{len} entries for a map of {need} texels"),
            BakeError::NotFinite { count: 1, first: [x, y] } => {
                write!(f, "the height at column {x}, row {y} is not finite")
            }
            BakeError::NotFinite { count, first: [x, y] } => {
                write!(f, "{count} heights are not finite, the first at column {x}, row {y}")
            }
            BakeError::HeightScale(scale) => write!(f, "a height scale of {scale}"),
            BakeError::TexelSize([s, t]) => write!(f, "a texel of {s} by {t}"),
            BakeError::Slope { height_scale, texel_size: [s, t] } => {
                write!(f, "a height scale of {height_scale} on a texel of {s} by {t} overflows")
            }
            BakeError::LeftSide { taps } => {
                write!(f, "a left-hand side of {taps} taps is not three around a larger middle one")
            }
            BakeError::NotWrapped => write!(f, "heights are had back from a map that wraps both ways only"),
        }
    }
}

impl std::error::Error for BakeError {}
