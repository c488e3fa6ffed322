//! No text panics the reader of stencils or their proof. With cargo-fuzz installed, from the folder of the library:
//! `cargo +nightly fuzz run stencil fuzz/corpus/stencil tableaus/stencils`.
#![no_main]

use kutta::normals::Stencil;

libfuzzer_sys::fuzz_target!(|text: &str| {
    match Stencil::parse(text) {
        Ok(stencil) => assert!(stencil.properties().order >= stencil.order),
        Err(error) => assert!(!error.text.as_str().is_empty()),
    }
});
