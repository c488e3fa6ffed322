//! Every method of `tableaus/`: a type each, and the list of all.

use crate::tableau::{Form, Tableau};

include!(concat!(env!("OUT_DIR"), "/methods.rs"));

/// A method file as it is shipped.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The file's name without its ending.
    pub name: &'static str,
    /// `tableaus/explicit/rk4.toml`.
    pub path: &'static str,
    pub text: &'static str,
}

impl Entry {
    /// Its numbers, which the compiler has proven.
    pub fn tableau(&self) -> Tableau<'static> {
        Tableau::proven(self.text)
    }
}

/// All methods, in the order of their paths.
pub fn all() -> &'static [Entry] {
    ENTRIES
}

/// The method of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}

/// For each order up to 8 the one-step method for y^(d) = f of at least that order with the fewest stages.
pub(crate) const fn one_step(d: usize) -> [(&'static str, &'static Form); 9] {
    let mut found = [("", &Form::EMPTY); 9];
    let mut order = 0;
    while order < found.len() {
        let mut i = 0;
        while i < FORMS.len() {
            if let (name, Some(form)) = FORMS[i]
                && form.d == d
                && form.one_step()
                && form.explicit()
                && form.order >= order
                && (found[order].1.s == 0 || form.s < found[order].1.s)
            {
                found[order] = (name, form);
            }
            i += 1;
        }
        order += 1;
    }
    found
}
