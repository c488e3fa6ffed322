//! Hard problems: the error reached against the tolerance asked for.
//!
//! ```
//! use kutta::{Loaded, compare::hard};
//!
//! let robertson = hard::cases().into_iter().find(|case| case.name == "robertson-40").expect("it is one");
//! let entry = kutta::methods::find("radau-iia3").expect("a method");
//! let method = Loaded::parse(entry.name, entry.text).expect("the compiler has proven it");
//! let run = robertson.attempt(&method, 1e-6, 10_000)?;
//! assert!(run.error < 10.0 * 1e-6);
//! # Ok::<(), kutta::Why>(())
//! ```

use crate::linear::Jacobian;
use crate::problems::{Problem, Visit, visit_all};
use crate::solve::ivp::Ivp;
use crate::solve::outcome::{Stats, Why};
use crate::step::method::Loaded;
use crate::step::system::{OutOfDomain, System};
use std::rc::Rc;

/// Tolerances that a hard problem is tried at.
pub const TOLERANCES: [f64; 5] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11];

/// An error up to this many times the tolerance is what an error test per step promises on a problem that
/// does not magnify errors.
pub const PROMISED: f64 = 10.0;

/// Largest problem that is solved with full matrices in a moment.
const LARGEST: usize = 200;

type Rhs = Rc<dyn Fn(f64, &Vec<f64>, &mut Vec<f64>)>;
type Derivatives = Rc<dyn Fn(f64, &Vec<f64>, &mut Jacobian<f64>)>;

/// A stiff problem of the catalogue, its types forgotten, so that the solver is compiled once for all.
#[derive(Clone)]
pub struct Case {
    /// The problem's; with its jumps told to the solver, `jump, declared`.
    pub name: String,
    pub about: &'static str,
    /// The number of components.
    pub n: usize,
    system: Erased,
    y0: Vec<f64>,
    span: (f64, f64),
    breaks: &'static [f64],
    /// The size below which a component counts as zero.
    scale: f64,
    reference: Vec<f64>,
}

/// A run that reached the end.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reached {
    /// Largest |y - reference| / (|reference| + scale/100) over the components at the end.
    pub error: f64,
    pub stats: Stats,
}

impl Case {
    /// Runs an adaptive method with atol = rtol scale/100.
    ///
    /// # Errors
    /// Why it did not reach the end.
    pub fn attempt(&self, method: &Loaded, rtol: f64, max_steps: u64) -> Result<Reached, Why> {
        let small = 0.01 * self.scale;
        let run =
            Ivp::new(self.system.clone(), self.y0.clone(), self.span.0..self.span.1).with(method.clone());
        let run = run.rtol(rtol).atol(rtol * small).max_steps(max_steps).breaks(self.breaks).run();
        let solution = run.map_err(|stopped| stopped.why)?;
        let off = |(y, r): (&f64, &f64)| (y - r).abs() / (r.abs() + small);
        // A NaN is the worst.
        let worse = |worst: f64, off: f64| if off <= worst { worst } else { off };
        let error = solution.y.iter().zip(&self.reference).map(off).fold(0.0, worse);
        Ok(Reached { error, stats: solution.stats })
    }

    /// Why errors larger than [`PROMISED`] times the tolerance lie in the problem, and how many times larger at
    /// most.
    pub fn magnifies(&self) -> Option<(f64, &'static str)> {
        let start = |names: &[&str]| names.iter().any(|name| self.name.starts_with(name));
        match () {
            _ if start(&["stiff-spring-underdamped"]) => Some((
                1e4,
                "80 swings, and what is left is 1/150 of the start: the phase gathers every error",
            )),
            _ if start(&["e5"]) => {
                Some((1e4, "the concentrations at the end carry every relative error of the way"))
            }
            _ if start(&["orego", "vdp"]) => {
                Some((1e3, "a jump of the cycle turns an error in time into one of the state"))
            }
            _ if self.name == "jump" => {
                Some((1e3, "the jump is not declared: one step's error is no power of it"))
            }
            _ => None,
        }
    }
}

/// The stiff problems whose solution is known, of moderate size; those with jumps come a second time with the
/// jumps declared.
pub fn cases() -> Vec<Case> {
    struct Collect(Vec<Case>);
    impl Visit for Collect {
        fn visit<P: Problem>(&mut self, problem: P) {
            let (true, Some(reference)) = (P::STIFF && problem.n() <= LARGEST, problem.reference()) else {
                return;
            };
            let case = Case {
                name: P::NAME.to_string(),
                about: P::ABOUT,
                n: problem.n(),
                y0: problem.y0().as_ref().to_vec(),
                span: problem.span(),
                breaks: &[],
                scale: problem.scale(),
                reference: reference.as_ref().to_vec(),
                system: Erased::of(&problem),
            };
            self.0.push(case.clone());
            if !problem.breaks().is_empty() {
                self.0.push(Case {
                    name: format!("{}, declared", P::NAME),
                    breaks: problem.breaks(),
                    ..case
                });
            }
        }
    }
    let mut all = Collect(vec![]);
    visit_all(&mut all);
    all.0
}

#[derive(Clone)]
struct Erased {
    rhs: Rhs,
    jacobian: Derivatives,
}

impl Erased {
    fn of<P: Problem>(problem: &P) -> Self {
        let state = |y: &[f64], of: &P| {
            let mut state = of.y0();
            state.as_mut().copy_from_slice(y);
            state
        };
        let (p, q) = (problem.clone(), problem.clone());
        Self {
            rhs: Rc::new(move |t, y, dy| {
                let mut slope = p.y0();
                p.rhs(t, &state(y, &p), &mut slope);
                dy.copy_from_slice(slope.as_ref());
            }),
            jacobian: Rc::new(move |t, y, j| {
                q.jacobian(t, &state(y, &q), |row, column, value| j[(row, column)] += value);
            }),
        }
    }
}

impl System<Vec<f64>> for Erased {
    fn rhs(&mut self, t: f64, y: &Vec<f64>, dy: &mut Vec<f64>) -> Result<(), OutOfDomain> {
        (self.rhs)(t, y, dy);
        Ok(())
    }
    fn jacobian(&mut self, t: f64, y: &Vec<f64>, j: &mut Jacobian<f64>) -> bool {
        (self.jacobian)(t, y, j);
        true
    }
}
