//! Every stencil of `tableaus/stencils/`: a constant each, and the list of all.

use super::Stencil;

include!(concat!(env!("OUT_DIR"), "/stencils.rs"));

/// A stencil file as it is shipped.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The file's name without its ending.
    pub name: &'static str,
    /// `tableaus/stencils/central4.toml`.
    pub path: &'static str,
    pub text: &'static str,
    /// Its numbers, which the compiler has proven.
    pub stencil: &'static Stencil<'static>,
}

/// All stencils, in the order of their names.
pub fn all() -> &'static [Entry] {
    ENTRIES
}

/// The stencil of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}
