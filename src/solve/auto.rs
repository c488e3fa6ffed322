//! The method chosen in the course of the run: explicit until stability, not accuracy, sets the steps; then one for
//! stiff problems until that has an end.

use super::stiffness::{Stiffness, real_limit};
use crate::linear::{Jacobian, Pattern};
use crate::methods::{RadauIia5, Rodas5p, Tsit54};
use crate::step::method::{Known, Loaded, Method};
use crate::step::norm::Tolerance;
use crate::step::row::form_of;
use crate::step::scalar::{Real, Scalar, Shown};
use crate::step::state::{RealOf, State};
use crate::step::system::{OutOfDomain, System};
use crate::tableau::Form;
use num_traits::Zero;
use std::fmt;

/// What [`solve`](crate::solve) uses when no method is named.
///
/// A run begins with the explicit method. From two stages at the same time it estimates h |lambda|, the step against
/// the fastest motion that the equation has (Hairer, Wanner 1996, IV.2). Where that stands at nine tenths of the
/// method's stability limit or above, in fifteen looks with no six in between that say otherwise, stability sets the
/// steps: the problem is stiff here, and the run goes on with `Rodas5p`, or with `RadauIia5` where rtol is below
/// 1e-8, where an atol is below the spacing of numbers at the largest component of the start (a Rosenbrock method
/// keeps no sum of components to less than that), or where the Jacobian is an approximate one. It returns to the
/// explicit method where the norm of h J has been below half the limit for ten steps, twice as many after each return of
/// stiffness. [`Solution::choices`](crate::Solution::choices) tells what was chosen, when and why.
///
/// Above 2000 components without a [`Pattern`](crate::Pattern) it stays explicit: a Jacobian would be larger than what
/// is asked for. With a mass matrix it begins with the method for stiff problems and stays with it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Auto<E = Tsit54>(E);

impl Auto {
    /// What tables and plots call it; [`name`](Method::name) is that of the explicit method.
    pub const NAME: &'static str = "auto";

    /// With `Tsit54`, as where no method is named.
    pub const fn new() -> Self {
        Self(Tsit54)
    }
}

impl<E: Method> Auto<E> {
    /// With another explicit method, which has two stages at the same time.
    pub fn from(explicit: E) -> Self {
        Self(explicit)
    }
}

impl<E: Method> Method for Auto<E> {
    const FORM: Option<&'static Form> = E::FORM;
    const READ: bool = E::READ;
    const AUTO: bool = true;
    type Words<Y: Clone> = E::Words<Y>;

    fn name(&self) -> &str {
        self.0.name()
    }
    fn form(&self) -> &Form {
        self.0.form()
    }
    fn words<Y: Clone>(&self, y: &Y) -> Self::Words<Y> {
        self.0.words(y)
    }
}

/// More components than this have no dense Jacobian.
const DENSE: usize = 2000;
/// Below this rtol the steps of a method of order five are too many.
const TIGHT: f64 = 1e-8;

/// A method that [`Auto`] took up.
#[derive(Clone, PartialEq, Debug)]
pub struct Choice<R> {
    /// From this time on.
    pub t: R,
    pub method: String,
    pub reason: Reason,
}

/// Why [`Auto`] took up a method.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub enum Reason {
    /// Every run begins with the explicit one.
    Start,
    /// M y' = f(t, y) takes no explicit one.
    Mass,
    /// Stability set the steps of the explicit method: its h |lambda|, and its limit.
    Stiff { reach: f64, limit: f64 },
    /// Stability would no longer limit the explicit method: a bound of h |lambda|, and its limit.
    NoLongerStiff { reach: f64, limit: f64 },
}

impl<R: Real> fmt::Display for Choice<R> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} from t = {}", self.method, Shown(self.t))?;
        match self.reason {
            Reason::Start => Ok(()),
            Reason::Mass => f.write_str(": M y' = f(t, y) takes no explicit method"),
            Reason::Stiff { reach, limit } => {
                write!(f, ": stability set the steps, h |lambda| = {reach:.2} of at most {limit:.2}")
            }
            Reason::NoLongerStiff { reach, limit } => {
                write!(
                    f,
                    ": stability would not limit the steps, h |lambda| <= {reach:.2e} of at most {limit:.2}"
                )
            }
        }
    }
}

/// The state of the choice in a run.
pub(crate) struct Chooser<R> {
    /// The method in hand is one for stiff problems.
    pub stiff: bool,
    /// The method for stiff problems has to be one that iterates.
    iterating: bool,
    /// Taken along by the leg that runs.
    pub stiffness: Option<Stiffness>,
    pub choices: Vec<Choice<R>>,
}

impl<R: Real> Chooser<R> {
    /// Of a run whose method was named.
    pub fn named() -> Self {
        Self { stiff: false, iterating: false, stiffness: None, choices: vec![] }
    }

    /// Of a run from `t` that begins with an explicit `method`, unless there is a mass matrix. `patterned` says whether
    /// a Jacobian needs no more room than the problem.
    pub fn new<M: Method>(
        method: &M,
        (t, n): (R, usize),
        (mass, iterating): (bool, bool),
        patterned: impl FnOnce() -> bool,
        tolerance: &Tolerance<R>,
    ) -> Self {
        let limit = match const { if M::READ { 0.0 } else { real_limit(Known::<M>::FORM) } } {
            0.0 => real_limit(form_of(method)),
            known => known,
        };
        let watched = !mass && (n <= DENSE || patterned());
        let first = match mass {
            true => {
                let stiff = stiff_method(tolerance, iterating);
                Choice { t, method: stiff.name().to_string(), reason: Reason::Mass }
            }
            false => Choice { t, method: method.name().to_string(), reason: Reason::Start },
        };
        Self {
            stiff: mass,
            iterating,
            stiffness: watched.then(|| Stiffness::new(form_of(method), limit)),
            choices: vec![first],
        }
    }

    /// The leg's watch asked for another method.
    pub fn turn(&mut self, t: R, explicit: &str, tolerance: &Tolerance<R>) {
        self.stiff = !self.stiff;
        let (mut reach, mut limit) = (0.0, 0.0);
        if let Some(stiffness) = &mut self.stiffness {
            (reach, limit) = (stiffness.seen, stiffness.limit);
            stiffness.turned(self.stiff);
        }
        let (method, reason) = match self.stiff {
            true => (self.stiff_method(tolerance).name().to_string(), Reason::Stiff { reach, limit }),
            false => (explicit.to_string(), Reason::NoLongerStiff { reach, limit }),
        };
        self.choices.push(Choice { t, method, reason });
    }

    pub fn stiff_method(&self, tolerance: &Tolerance<R>) -> Loaded {
        stiff_method(tolerance, self.iterating)
    }
}

/// Whether amounts are asked for that are lost in the rounding of the largest component.
pub(crate) fn beyond_rounding<Y: State>(tolerance: &Tolerance<RealOf<Y>>, y: &Y) -> bool {
    let sizes = y.as_slice().iter().map(|y| y.modulus());
    tolerance.least() < sizes.fold(RealOf::<Y>::zero(), Real::maximum) * RealOf::<Y>::EPSILON
}

/// The method for stiff problems: one that iterates, or a Rosenbrock method.
pub(crate) fn stiff_method<R: Real>(tolerance: &Tolerance<R>, iterating: bool) -> Loaded {
    let tightest = match tolerance {
        Tolerance::Scalar { rtol, .. } => rtol.to_f64(),
        Tolerance::Each(each) => each.iter().map(|(rtol, _)| rtol.to_f64()).fold(1.0, f64::min),
    };
    if tightest < TIGHT || iterating {
        Loaded::of(RadauIia5.name(), RadauIia5.form())
    } else {
        Loaded::of(Rodas5p.name(), Rodas5p.form())
    }
}

/// A system lent to a leg of another type than the run's own: compiled once for a state.
pub(super) struct Lent<'s, Y>(pub &'s mut dyn System<Y>);

impl<Y: State> System<Y> for Lent<'_, Y> {
    fn time_derivative(&mut self, t: RealOf<Y>, y: &Y, dfdt: &mut Y) -> bool {
        self.0.time_derivative(t, y, dfdt)
    }
    fn pattern(&self) -> Option<Pattern> {
        self.0.pattern()
    }
    fn rhs(&mut self, t: RealOf<Y>, y: &Y, dy: &mut Y) -> Result<(), OutOfDomain> {
        self.0.rhs(t, y, dy)
    }
    fn jacobian(&mut self, t: RealOf<Y>, y: &Y, j: &mut Jacobian<Y::Scalar>) -> bool {
        self.0.jacobian(t, y, j)
    }
    fn is_approximate(&self) -> bool {
        self.0.is_approximate()
    }
}
