//! No bytes panic the readers of height maps. With cargo-fuzz installed, from the folder of the library:
//! `cargo +nightly fuzz run image fuzz/corpus/image docs`.
#![no_main]

#[allow(dead_code, unused_imports)]
#[path = "../../src/cli/image/mod.rs"]
mod image;

use image::{Channel, Size, read};
use std::io::Cursor;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    for channel in [None, Some(Channel::R)] {
        if let Err(line) = read(Cursor::new(bytes), channel, None) {
            assert!(!line.is_empty() && !line.contains('\n'));
        }
    }
    let _ = read(Cursor::new(bytes), None, Some(Size { width: 7, height: 3 }));
});
