//! Normal maps: a height field is a grid function, baking it is a finite-difference operator, and its
//! [stencils](Stencil) are data, proven by the compiler like the methods.

pub mod accuracy;
mod derive;
mod moments;
mod prove;
pub mod stencil;
pub mod stencils;

pub use derive::{Properties, Term};
pub use stencil::{Stencil, TAPS, Taps, compile};
