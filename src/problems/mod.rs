//! The catalogue: initial value problems with their Jacobians, references and sources.
//!
//! Each is a type, so that a right-hand side is compiled into the loop that calls it. [`visit_all`] hands
//! every one of them to a [`Visit`], and is the only list of them.

mod bodies;
mod brusselator;
mod chemistry;
mod cycles;
mod heat;
mod linear;
mod orbits;
mod pollution;
mod relaxation;
mod springs;

pub use bodies::{NBodyRing, Pleiades};
pub use brusselator::{Brusselator1dN40, Brusselator2d};
pub use chemistry::{E5Until1e11, E5Until1e13, Hires, Orego, RobertsonUntil1e11, RobertsonUntil40};
pub use cycles::{Lorenz63, LotkaVolterra, RigidBody, VdpEps1e6, VdpMu1, VdpMu1000};
pub use heat::{Heat1d, Heat2d, HeatN100};
pub use linear::{Jump, NonNormal, StiffOscillator};
pub use orbits::{Arenstorf4Loop, KeplerE06};
pub use pollution::Pollution;
pub use relaxation::{CurtissHirschfelder, ExponentialDecay, ProtheroRobinson};
pub use springs::{HarmonicOscillator, SpringChain, StiffSpringOverdamped, StiffSpringUnderdamped};

use crate::{Jacobian, OutOfDomain, Pattern, State, System};
use std::f64::consts::PI;

/// An initial value problem y' = f(t, y), y(t0) = y0.
///
/// All numbers are the `f64` nearest to the printed ones, and the reference is the solution for exactly
/// these: where a problem magnifies the rounding of its numbers, the two differ by more than a method errs.
pub trait Problem: Clone + Send + Sync + 'static {
    /// `[f64; N]` for a problem of fixed size, `Vec<f64>` for one built to size.
    type Y: State<Scalar = f64> + Send + Sync + AsRef<[f64]> + AsMut<[f64]> + 'static;
    /// Lower case, with hyphens.
    const NAME: &'static str;
    /// One line: what it is, and what it asks of a method.
    const ABOUT: &'static str;
    /// Author, year, section.
    const SOURCE: &'static str;
    /// Whether an explicit method must take steps far smaller than the solution asks for.
    const STIFF: bool;

    fn y0(&self) -> Self::Y;

    /// The start and the end, t0 and t1.
    fn span(&self) -> (f64, f64);

    fn rhs(&self, t: f64, y: &Self::Y, dy: &mut Self::Y);

    /// Calls `add(row, column, value)` for the entries of df/dy that can be other than zero. The places, and
    /// their order, are the same at every point; values given for the same place add up.
    fn jacobian(&self, t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64));

    /// df/dy as a full matrix of n * n entries, row by row.
    fn dense_jacobian(&self, t: f64, y: &Self::Y, j: &mut [f64]) {
        let n = self.n();
        j.fill(0.0);
        self.jacobian(t, y, |row, column, value| j[row * n + column] += value);
    }

    /// The number of components.
    fn n(&self) -> usize {
        self.y0().as_ref().len()
    }

    /// y(t1) in decimal, with every digit that is known (19 to 30); empty where it is not known.
    fn reference_text(&self) -> &'static [&'static str] {
        &[]
    }

    /// y(t1), from the text if there is one, else from the closed form. What is below the range of f64 is 0.
    fn reference(&self) -> Option<Self::Y> {
        let text = self.reference_text();
        if text.is_empty() {
            return self.exact(self.span().1);
        }
        let mut y = self.y0();
        for (y, text) in y.as_mut().iter_mut().zip(text) {
            *y = text.parse().expect("a reference is a decimal number");
        }
        Some(y)
    }

    /// The size below which a component counts as zero: an absolute tolerance is best a multiple of it.
    fn scale(&self) -> f64 {
        1.0
    }

    /// Times at which f jumps.
    fn breaks(&self) -> &'static [f64] {
        &[]
    }

    /// y(t) where there is a closed form, for t from t0 on.
    fn exact(&self, _t: f64) -> Option<Self::Y> {
        None
    }
}

/// A problem x'' = f(t, x): the first half of y is the position x, the second the velocity v = x'.
pub trait SecondOrder: Problem {
    /// Half of `Y`.
    type X: State<Scalar = f64> + Send + Sync + AsRef<[f64]> + AsMut<[f64]> + 'static;

    fn x0(&self) -> Self::X;

    fn v0(&self) -> Self::X;

    /// a = f(t, x).
    fn acceleration(&self, t: f64, x: &Self::X, a: &mut Self::X);
}

/// A problem as a system with its Jacobian.
#[derive(Clone, Copy, Debug)]
pub struct Equation<P>(pub P);

impl<P: Problem> System<P::Y> for Equation<P> {
    #[inline(always)]
    fn rhs(&mut self, t: f64, y: &P::Y, dy: &mut P::Y) -> Result<(), OutOfDomain> {
        self.0.rhs(t, y, dy);
        Ok(())
    }
    fn jacobian(&mut self, t: f64, y: &P::Y, j: &mut Jacobian<f64>) -> bool {
        self.0.jacobian(t, y, |row, column, value| j[(row, column)] += value);
        true
    }
    fn pattern(&self) -> Option<Pattern> {
        // Small matrices are dense, and their places not worth the search.
        if P::Y::INLINE {
            return None;
        }
        let (y, mut places) = (self.0.y0(), vec![]);
        self.0.jacobian(self.0.span().0, &y, |row, column, _| places.push((row, column)));
        Pattern::of(y.as_ref().len(), places).ok()
    }
}

/// What to do with each problem, whatever its type.
pub trait Visit {
    fn visit<P: Problem>(&mut self, problem: P);

    /// A problem of second order is visited here only; without a body of its own this treats it as any other.
    fn visit_second_order<P: SecondOrder>(&mut self, problem: P) {
        self.visit(problem);
    }
}

/// Visits the whole catalogue. Those that can be built to size come in a size that solves in a moment.
pub fn visit_all(v: &mut impl Visit) {
    v.visit(ExponentialDecay);
    v.visit_second_order(HarmonicOscillator);
    v.visit(Lorenz63);
    v.visit(LotkaVolterra);
    v.visit(RigidBody);
    v.visit_second_order(KeplerE06);
    v.visit(Arenstorf4Loop);
    v.visit_second_order(Pleiades);
    v.visit_second_order(NBodyRing::new(50));
    v.visit_second_order(SpringChain::new(1000));
    v.visit(VdpMu1);
    v.visit(VdpMu1000);
    v.visit(VdpEps1e6);
    v.visit(ProtheroRobinson);
    v.visit(CurtissHirschfelder);
    v.visit(StiffSpringOverdamped);
    v.visit(StiffSpringUnderdamped);
    v.visit(StiffOscillator);
    v.visit(NonNormal);
    v.visit(Jump);
    v.visit(RobertsonUntil40);
    v.visit(RobertsonUntil1e11);
    v.visit(Hires);
    v.visit(Orego);
    v.visit(Pollution);
    v.visit(E5Until1e11);
    v.visit(E5Until1e13);
    v.visit(HeatN100);
    v.visit(Heat1d::new(200));
    v.visit(Heat2d::new(40));
    v.visit(Brusselator1dN40);
    v.visit(Brusselator2d::new(64));
}

/// A line of the [`catalogue`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    pub name: &'static str,
    pub about: &'static str,
    pub source: &'static str,
    pub stiff: bool,
    /// Whether it is a [`SecondOrder`] problem.
    pub second_order: bool,
    /// The number of components, in the size that [`visit_all`] builds.
    pub n: usize,
}

/// All problems, to be read by people, in the order of [`visit_all`].
pub fn catalogue() -> Vec<Entry> {
    struct Collect(Vec<Entry>);
    impl Visit for Collect {
        fn visit<P: Problem>(&mut self, problem: P) {
            self.0.push(Entry {
                name: P::NAME,
                about: P::ABOUT,
                source: P::SOURCE,
                stiff: P::STIFF,
                second_order: false,
                n: problem.n(),
            });
        }
        fn visit_second_order<P: SecondOrder>(&mut self, problem: P) {
            self.visit(problem);
            self.0.last_mut().expect("just pushed").second_order = true;
        }
    }
    let mut all = Collect(Vec::new());
    visit_all(&mut all);
    all.0
}

/// sin(pi k/m), folded into a quarter turn while k and m are integers: as good at any k as at small ones.
fn sine(k: usize, m: usize) -> f64 {
    let (k, sign) = if k % (2 * m) < m { (k % m, 1.0) } else { (k % m, -1.0) };
    sign * (PI * k.min(m - k) as f64 / m as f64).sin()
}

/// Hands a small matrix over, entry by entry.
#[inline]
fn each<const N: usize>(matrix: [[f64; N]; N], mut add: impl FnMut(usize, usize, f64)) {
    for (i, row) in matrix.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            add(i, j, value);
        }
    }
}
