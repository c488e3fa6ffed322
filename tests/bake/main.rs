//! Baking: the operator against its definition, the fast path against the operator, packings against their
//! formulas.

mod advice;
mod baking;
mod operator;
mod packing;
mod shapes;
mod stencils;

/// Numbers from 0 to 1 that look like none in particular.
pub fn noise(n: usize) -> Vec<f64> {
    let mut state = 0x9e3779b97f4a7c15u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..n).map(|_| next()).collect()
}

pub const BORDERS: [kutta::normals::Border; 4] = {
    use kutta::normals::Border::*;
    [Wrap, Clamp, Mirror, OneSided]
};
