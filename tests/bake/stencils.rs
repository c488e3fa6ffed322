//! The stencils of the library.

pub use kutta::normals::stencils::*;

use kutta::normals::Stencil;

#[rustfmt::skip]
pub static ALL: [Stencil; 19] = [
    FORWARD2, BACKWARD2, CENTRAL2, CENTRAL4, CENTRAL6, CENTRAL8, DRP7, PREWITT3, SOBEL3, SCHARR3, ISO3, SOBEL5,
    FARID5, FARID7, COMPACT6, ONESIDED2, ONESIDED4, ONESIDED6, ONESIDED8,
];
