//! Normal maps: a height field is a grid function, baking it is a finite-difference operator, and its
//! [stencils](Stencil) are data, proven by the compiler like the methods.
//!
//! Around the map: where the texture runs on the surface ([`frame`], [`tangents`](mod@tangents)), how its
//! slopes bend the normal ([`bump`]), and how its heights shift it ([`parallax`](mod@parallax)).

pub mod bump;
pub mod frame;
pub mod parallax;
mod stand_in;
pub mod stencil;
pub mod tangents;

pub use stand_in::{Bake, BakeError, Border, Green, Height, Heights, Level, Normal, mips, stencils};
pub use stencil::{Stencil, Taps};
