//! Methods as data: a file becomes a [`Tableau`], is proven, and is lowered to the one [`Form`] that steps.

mod collocation;
pub(crate) mod criteria;
mod derive;
mod double_double;
mod error;
mod evidence;
mod form;
mod history;
mod inexact;
mod linear;
mod lower;
mod nordsieck;
mod number;
mod pairs;
mod prove;
mod read;
mod region;
mod roots;
mod series;
mod sizes;
mod stability;
mod stiff;
mod sums;
mod trees;

pub use derive::{Member, Properties, Stages};
pub use double_double::DoubleDouble;
pub use error::{Broken, TableauError, Text};
pub use evidence::Evidence;
pub use form::{CARRIED, Form, Meaning, Orders, POWERS, Row, STAGES, TERMS};
pub use nordsieck::{Corrector, Members, ORDERS};
pub(crate) use prove::tolerance;
pub(crate) use read::stencil;
pub use read::{entries, value};
pub use region::Stability;
pub use stiff::StiffOrder;

use double_double::DoubleDouble as D;

impl<'t> Tableau<'t> {
    /// Reads and proves a method file.
    ///
    /// # Errors
    /// The line, the entry or the order condition that is wrong, in the words of the compiler.
    pub fn parse(text: &'t str) -> Result<Self, TableauError> {
        let tableau = read::read(text)?;
        prove::prove(&tableau)?;
        Ok(tableau)
    }

    /// Reads a file that the compiler has proven.
    pub(crate) fn proven(text: &'t str) -> Self {
        match read::read(text) {
            Ok(tableau) => tableau,
            Err(error) => panic!("the compiler has read it: {error}"),
        }
    }

    /// The lowered table; `None` for pairs of tables whose stages would have to be found together.
    pub fn form(&self) -> Option<Form> {
        lower::lower(self)
    }

    /// The form that the stepper can run.
    pub(crate) fn steppable_form(&self) -> Option<Form> {
        steppable(self)
    }
}

const fn steppable(tableau: &Tableau) -> Option<Form> {
    lower::lower(tableau)
}

/// What [`tableau!`](crate::tableau!) makes of a file: its form if the stepper can run it.
///
/// # Panics
/// Where [`Tableau::parse`] gives an error; in a constant that stops the compiler.
pub const fn compile(path: &str, text: &str) -> Option<Form> {
    let tableau = match read::read(text) {
        Ok(tableau) => tableau,
        Err(error) => panic!("{}", error.message(path).as_str()),
    };
    match prove::prove(&tableau) {
        Ok(()) => steppable(&tableau),
        Err(error) => panic!("{}", error.message(path).as_str()),
    }
}

/// The name of a file without folders and ending.
pub fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    name.strip_suffix(".toml").unwrap_or(name)
}

/// A method file, read: its family's own arrays, not yet lowered.
#[derive(Clone, Copy)]
pub struct Tableau<'t> {
    pub title: &'t str,
    /// Author, year, publication.
    pub cite: &'t str,
    /// What a user should know beside the numbers; may be empty.
    pub note: &'t str,
    /// Claimed order.
    pub order: usize,
    /// Claimed order of each embedded row; 0 where there is none.
    pub embedded: [usize; 2],
    /// Claimed order of the dense output; 0 where there is none.
    pub dense_order: usize,
    /// Correct decimal digits of the entries; 0 where they are exact.
    pub digits: usize,
    pub scheme: Scheme,
}

/// The arrays of each family, as books write them.
#[derive(Clone, Copy)]
#[allow(clippy::large_enum_variant)] // a const value, never moved in a loop
pub enum Scheme {
    RungeKutta(Array),
    /// y' = f(t, y) + g(t, y): an explicit array for f, an implicit one for g, the same stages.
    Imex {
        explicit: Array,
        implicit: Array,
    },
    /// q' = f(p), p' = g(q): one array for each variable.
    Partitioned {
        position: Array,
        velocity: Array,
    },
    /// (I - h gamma J) k_i = f(y + h sum alpha_ij k_j) + h J sum gamma_ij k_j, written with k_i unscaled;
    /// `gamma.a` has the diagonal, `alpha` has b and bhat.
    Rosenbrock {
        alpha: Array,
        gamma: Array,
    },
    Multistep(Steps),
    /// Formulas of ascending order, stepped in Nordsieck form.
    Nordsieck(Members),
    /// sum alpha_j y_(n+j) = h^2 sum beta_j f_(n+j) for y'' = f(t, y).
    Stormer(Steps),
    /// `evaluates`: f is evaluated once more at the corrected value (PECE); else PEC.
    PredictorCorrector {
        predictor: Steps,
        corrector: Steps,
        evaluates: bool,
    },
    /// Runge-Kutta-Nystrom for y'' = f(t, y): `b` holds the weights of y', `bbar` those of y.
    Nystrom {
        array: Array,
        bbar: [D; STAGES],
    },
    Splitting(Splitting),
}

/// A Butcher array with its embedded weights and dense output.
#[derive(Clone, Copy)]
pub struct Array {
    pub stages: usize,
    pub c: [D; STAGES],
    pub a: [[D; STAGES]; STAGES],
    pub b: [D; STAGES],
    /// Rows of `bhat` that are given.
    pub lower: usize,
    pub bhat: [[D; STAGES]; 2],
    /// Stages of the dense output alone; their c and a stand at `stages ..`.
    pub extra: usize,
    /// Powers of theta in the dense output; 0 where there is none.
    pub powers: usize,
    /// `dense[i][k]`: weight of stage i at theta^(k+1).
    pub dense: [[D; POWERS]; STAGES],
}

/// sum alpha_j y_(n+j) = h^d sum beta_j f_(n+j), j = 0 ..= k ascending.
#[derive(Clone, Copy)]
pub struct Steps {
    /// Number of steps.
    pub k: usize,
    pub alpha: [D; CARRIED],
    pub beta: [D; CARRIED],
}

/// A composition of drifts (q += a h p) and kicks (p += b h f(q)), applied in order.
#[derive(Clone, Copy)]
pub struct Splitting {
    pub len: usize,
    pub kick: [bool; 2 * STAGES],
    pub weight: [D; 2 * STAGES],
}
