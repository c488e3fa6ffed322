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

mod algebraic;

use crate::linear::{Jacobian, Mass, Pattern};
use crate::problems::{Heat2d, Problem, Visit, visit_all};
use crate::solve::ivp::Ivp;
use crate::solve::outcome::{Stats, Why};
use crate::step::method::Method;
use crate::step::system::{OutOfDomain, System};
use crate::tableau::criteria::estimate_misses;
use std::rc::Rc;

/// Tolerances that a hard problem is tried at.
pub const TOLERANCES: [f64; 5] = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11];

/// An error up to this many times the tolerance is what an error test per step promises on a problem that
/// does not magnify errors.
pub const PROMISED: f64 = 10.0;

/// Largest problem that every method solves in a moment, with a band where it has one.
const LARGEST: usize = 200;
/// Points in a row of the plane that heats up: a sparse matrix of 36 rows.
const ROW: usize = 6;

type Rhs = Rc<dyn Fn(f64, &Vec<f64>, &mut Vec<f64>)>;
type Derivatives = Rc<dyn Fn(f64, &Vec<f64>, &mut Jacobian<f64>)>;

/// A hard problem, its types forgotten, so that the solver is compiled once for all.
#[derive(Clone)]
pub struct Case {
    /// The problem's; with its jumps told to the solver, `jump-declared`; with an equation of it replaced by a
    /// conserved sum, `robertson-40-algebraic`.
    pub name: String,
    pub about: &'static str,
    /// The number of components.
    pub n: usize,
    system: Erased,
    y0: Vec<f64>,
    span: (f64, f64),
    breaks: &'static [f64],
    /// M of M y' = f(t, y); the identity where there is none.
    mass: Option<fn(&mut Mass<f64>)>,
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
    /// Runs an adaptive method, or [`Auto`](crate::Auto), with atol = rtol scale/100.
    ///
    /// # Errors
    /// Why it did not reach the end.
    pub fn attempt<M: Method>(&self, method: &M, rtol: f64, max_steps: u64) -> Result<Reached, Why> {
        let small = 0.01 * self.scale;
        let run =
            Ivp::new(self.system.clone(), self.y0.clone(), self.span.0..self.span.1).with(method.clone());
        let run = run.rtol(rtol).atol(rtol * small).max_steps(max_steps).breaks(self.breaks);
        let run = if let Some(mass) = self.mass { run.mass(mass) } else { run };
        let solution = run.run().map_err(|stopped| stopped.why)?;
        let off = |(y, r): (&f64, &f64)| (y - r).abs() / (r.abs() + small);
        // A NaN is the worst.
        let worse = |worst: f64, off: f64| if off <= worst { worst } else { off };
        let error = solution.y.iter().zip(&self.reference).map(off).fold(0.0, worse);
        Ok(Reached { error, stats: solution.stats })
    }

    /// The largest error, over the tolerance, that is no fault; above [`PROMISED`] with the reason why.
    pub fn allowed(&self, method: &impl Method, rtol: f64) -> (f64, Option<&'static str>) {
        let form = method.form();
        let named = |names: &[&str]| names.iter().any(|name| self.name.starts_with(name));
        // Of the size of the error, and not of the tolerance.
        let mut least = 0.0;
        let (mut factor, mut why) = (PROMISED, None);
        // n steps err n times the tolerance, and n grows like this.
        let add_up = rtol.powf(-1.0 / (form.order as f64 + 1.0));
        let unlike =
            form.errors > 0 && form.embedded[0] < form.order || form.errors == 0 && form.order > form.s;
        if form.orders > 0 || !unlike {
            factor *= add_up;
            why = Some("the step has no higher order than its estimate: the errors of all steps add up");
        } else if let Some(misses) = estimate_misses(form).filter(|&misses| misses > 2.0) {
            factor *= add_up.max(misses);
            why = Some(
                "the estimate says too little of linear or of stiff equations: `kutta show` tells how much",
            );
        }
        if named(&["stiff-spring-underdamped"]) {
            factor *= 300.0;
            why = Some(
                "80 swings, of which 1/150 of the size is left: the phase gathers the errors of all steps",
            );
        } else if named(&["non-normal"]) {
            factor *= 5.0;
            why = Some("the matrix magnifies an error of y2 a thousandfold before it is weighed");
        } else if named(&["e5-1e13"]) && rtol > 1e-6 {
            least = 1e3;
            why = Some(
                "y1 must fall by 25 decades before y2 is right, and a step that damps it is judged by the size it comes from",
            );
        } else if named(&["e5"]) {
            (factor, least) = (factor * 100.0, 1e-2);
            why = Some("the numbers at the end are below the spacing of those at the start, 2e-19");
        } else if named(&["orego", "vdp"]) {
            factor *= if named(&["vdp"]) { 3.0 } else { 20.0 };
            why = Some("a jump of the cycle turns an error of time into one of the state");
        } else if self.name == "jump" {
            least = 5e-2;
            why = Some(
                "a jump that is not declared may fall between the stages of a step, where nothing sees it",
            );
        } else if named(&["robertson-1e11"]) {
            factor *= 5.0;
            why = Some("eleven decades, each of many steps with an error of their own");
        }
        (factor.max(least / rtol), why)
    }
}

/// The stiff problems of the catalogue whose solution is known, of moderate size; those with jumps come a second time
/// with the jumps declared, and Robertson's with an algebraic equation. The last is the transistor amplifier.
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
                mass: None,
                scale: problem.scale(),
                reference: reference.as_ref().to_vec(),
                system: Erased::of(&problem),
            };
            self.0.push(case.clone());
            if !problem.breaks().is_empty() {
                self.0.push(Case { name: format!("{}-declared", P::NAME), breaks: problem.breaks(), ..case });
            }
        }
    }
    let mut all = Collect(vec![]);
    visit_all(&mut all);
    all.visit(Heat2d::new(ROW));
    let algebraic = algebraic::cases(&all.0);
    all.0.extend(algebraic);
    all.0
}

#[derive(Clone)]
struct Erased {
    rhs: Rhs,
    jacobian: Derivatives,
    pattern: Option<Pattern>,
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
            pattern: pattern(problem),
        }
    }
}

/// Where the Jacobian of a problem can be other than zero.
fn pattern<P: Problem>(problem: &P) -> Option<Pattern> {
    let mut places = vec![];
    problem.jacobian(problem.span().0, &problem.y0(), |row, column, _| places.push((row, column)));
    Pattern::of(problem.n(), places).ok()
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
    fn pattern(&self) -> Option<Pattern> {
        self.pattern.clone()
    }
}
