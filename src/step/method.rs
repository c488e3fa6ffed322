//! A method as a type: its rows are constants, and the stepper is unrolled over them.

use crate::tableau::{Form, Tableau, TableauError};

/// What the stepper runs. [`tableau!`](crate::tableau!) makes one of a file; [`Loaded`] reads one at run time.
pub trait Method: Clone {
    /// The lowered table, where the compiler knows it and the stepper can run it.
    const FORM: Option<&'static Form>;
    /// The form is only known at run time.
    const READ: bool = false;
    /// The run leaves it where it no longer fits.
    const AUTO: bool = false;
    /// One vector for each z, F, Y and z' of the form.
    type Words<Y: Clone>: AsRef<[Y]> + AsMut<[Y]> + Clone;

    /// The name of the file without its ending.
    fn name(&self) -> &str;
    fn form(&self) -> &Form;
    fn words<Y: Clone>(&self, y: &Y) -> Self::Words<Y>;
}

/// The form of a method known to the compiler; an empty one where it is only known at run time.
pub(crate) struct Known<M>(std::marker::PhantomData<M>);

impl<M: Method> Known<M> {
    /// A copy: the static of another crate is opaque to the optimiser, a constant of this one folds away.
    pub const FORM: &'static Form = &match M::FORM {
        Some(form) => *form,
        None => Form::EMPTY,
    };
    pub const UNROLLED: bool = M::FORM.is_some();
}

/// A table read at run time. It steps through the same code as a compiled one, row by row in a loop.
#[derive(Clone)]
pub struct Loaded {
    name: String,
    pub(crate) form: Box<Form>,
}

impl Loaded {
    /// Reads and proves `text`; refuses what cannot be stepped yet.
    ///
    /// # Errors
    /// What the compiler would say of the same file, or that it is a pair whose stages would have to be found together.
    pub fn parse(name: &str, text: &str) -> Result<Self, TableauError> {
        let form = Tableau::parse(text)?.steppable_form().ok_or_else(TableauError::not_steppable)?;
        Ok(Self::of(name, &form))
    }

    pub(crate) fn of(name: &str, form: &Form) -> Self {
        Self { name: name.to_string(), form: Box::new(*form) }
    }
}

impl Method for Loaded {
    const FORM: Option<&'static Form> = None;
    const READ: bool = true;
    type Words<Y: Clone> = Vec<Y>;

    fn name(&self) -> &str {
        &self.name
    }
    fn form(&self) -> &Form {
        &self.form
    }
    fn words<Y: Clone>(&self, y: &Y) -> Vec<Y> {
        vec![y.clone(); self.form.words()]
    }
}

/// Makes a method type of a tableau file, read and proven by the compiler.
///
/// ```
/// kutta::tableau!(
///     /// The classical method.
///     ClassicalFour,
///     "../../tableaus/explicit/rk4.toml"
/// );
/// # fn main() {}
/// ```
///
/// The path is relative to the calling file. A wrong digit does not compile: the message names the file,
/// the line or the tree of the broken order condition, and by how much it is off.
#[macro_export]
macro_rules! tableau {
    ($(#[$attribute:meta])* $name:ident, $path:expr) => {
        $crate::tableau!(@ $(#[$attribute])* $name, $path, $path);
    };
    // The file to read, and the path that messages show.
    (@ $(#[$attribute:meta])* $name:ident, $path:expr, $shown:expr) => {
        $(#[$attribute])*
        ///
        /// ```toml
        #[doc = include_str!($path)]
        /// ```
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name;

        const _: () = {
            // A static is evaluated once, in the crate that holds it; a constant would be in every crate.
            static FORM: Option<$crate::tableau::Form> =
                $crate::tableau::compile($shown, include_str!($path));
            const WORDS: usize = match &FORM {
                Some(form) => form.words(),
                None => 0,
            };

            impl $crate::Method for $name {
                const FORM: Option<&'static $crate::tableau::Form> = FORM.as_ref();
                type Words<Y: Clone> = [Y; WORDS];

                fn name(&self) -> &str {
                    $crate::tableau::stem($shown)
                }
                fn form(&self) -> &$crate::tableau::Form {
                    FORM.as_ref().expect("only steppable methods are run")
                }
                fn words<Y: Clone>(&self, y: &Y) -> [Y; WORDS] {
                    std::array::from_fn(|_| y.clone())
                }
            }
        };
    };
}
