//! Normal maps: a height field is a grid function, baking it is a finite-difference operator, and its
//! [stencils](Stencil) are data, proven by the compiler like the methods.
//!
//! Around the map: where the texture runs on the surface ([`frame`], [`tangents`](mod@tangents)), how its
//! slopes bend the normal ([`bump`]), and how its heights shift it ([`parallax`](mod@parallax)).

pub mod accuracy;
mod advice;
mod bake;
mod best_fit;
mod border;
pub mod bump;
mod compact;
mod derive;
mod error;
pub mod frame;
mod heights;
#[cfg(feature = "fft")]
mod inverse;
mod line;
mod map;
mod mips;
mod missing;
mod mix;
mod moments;
mod normal;
mod operator;
pub mod parallax;
mod polynomial;
mod prove;
mod simd;
pub mod stencil;
pub mod stencils;
mod stream;
pub mod tangents;
mod tridiagonal;

pub use advice::{Advice, Budget};
pub use bake::{Bake, Green};
pub use best_fit::pack_best_fit;
pub use border::Border;
pub use derive::{Properties, Term};
pub use error::BakeError;
pub use heights::{Height, Heights};
#[cfg(feature = "fft")]
pub use inverse::Integral;
pub use mips::{Level, mips};
pub use normal::Normal;
pub use operator::{Axis, Operator};
pub use stencil::{Stencil, TAPS, Taps, compile};
