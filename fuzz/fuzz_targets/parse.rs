//! No text panics the reader or the proof. With cargo-fuzz installed, from the folder of the library:
//! `cargo +nightly fuzz run parse fuzz/corpus/parse tableaus/*`.
#![no_main]

use kutta::tableau::Tableau;

libfuzzer_sys::fuzz_target!(|text: &str| {
    match Tableau::parse(text) {
        Ok(tableau) => assert!(tableau.form().is_none_or(|form| form.s > 0)),
        Err(error) => assert!(!error.text.as_str().is_empty()),
    }
});
