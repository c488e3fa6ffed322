//! A problem of the catalogue and the methods that meet on it: all compiled, or all interpreted.

use crate::cli::Source;
use kutta::compare::{Comparison, Outcome, Unfit, label};
use kutta::methods::*;
use kutta::problems::{self, *};
use kutta::tableau::TableauError;
use kutta::{Auto, Loaded, Method, State, System};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

/// A method to be compared.
#[derive(Clone)]
pub struct Contestant {
    pub name: String,
    pub path: String,
    /// It comes with the library and may be among the compiled.
    shipped: bool,
    pub adaptive: bool,
    /// It is for y'' = f(t, y).
    second_order: bool,
    /// Its stages are implicit: it is for stiff problems.
    implicit: bool,
    /// It was asked for, not taken by default.
    named: bool,
    /// A run leaves it for another where it does not fit.
    auto: bool,
    loaded: Loaded,
}

impl Contestant {
    pub fn new(source: &Source, named: bool) -> Result<Self, TableauError> {
        let tableau = source.tableau()?;
        let loaded = Loaded::parse(&source.name, &source.text)?;
        Ok(Self {
            name: source.name.clone(),
            path: source.path.clone(),
            shipped: source.proven,
            adaptive: loaded.form().adaptive(),
            second_order: tableau.second_order(),
            implicit: !loaded.form().explicit(),
            named,
            auto: false,
            loaded,
        })
    }

    /// What a run takes whose method is not named: it begins with an explicit one, and is for stiff problems too.
    pub fn auto(named: bool) -> Result<Self, TableauError> {
        let start = kutta::methods::find(Tsit54.name()).expect("it is in the library");
        Ok(Self {
            name: Auto::NAME.to_string(),
            path: "the library".to_string(),
            shipped: true,
            adaptive: true,
            second_order: false,
            implicit: true,
            named,
            auto: true,
            loaded: Loaded::parse(start.name, start.text)?,
        })
    }
}

pub struct Contest {
    pub problem: problems::Entry,
    pub methods: Vec<Contestant>,
    /// Methods that were asked for but are not for this kind of problem.
    pub unfit: Vec<String>,
    /// Methods that are not compiled with the problem. If there is one, all are interpreted, so that times
    /// compare.
    pub not_compiled: Vec<String>,
    tolerances: Vec<f64>,
}

/// Methods compiled with every problem in [`meet`], and entered as adaptive or with fixed steps.
macro_rules! compiled {
    ($names:ident, $enter:ident: $($how:ident $method:expr,)*) => {
        fn $names() -> Vec<String> {
            vec![$(label(&$method).to_string()),*]
        }

        fn $enter<'w, Y: State<Scalar = f64> + 'w, S: System<Y> + Clone + 'w>(
            mut comparison: Comparison<'w, Y, S>,
            chosen: &[Contestant],
        ) -> Comparison<'w, Y, S> {
            for Contestant { name, .. } in chosen {
                $(if name == label(&$method) {
                    comparison = comparison.$how($method);
                })*
            }
            comparison
        }
    };
}
compiled! {
    first_order, enter_first:
    method Bs32,
    method Dp54,
    method Tsit54,
    method Verner65Efficient,
    method Verner76Efficient,
    method Dop853,
    method Verner87Efficient,
    method Verner98Robust,
    fixed Rk4,
    fixed Abm4Pece,
}
compiled! {
    second_order, enter_second:
    fixed VelocityVerlet,
    fixed Pefrl4,
    fixed BlanesMoanRkn6A14,
}

compiled! {
    stiff_order, enter_stiff:
    method Trbdf2,
    method Kencarp4Esdirk,
    method Kvaerno5,
    method Rodas4,
    method Rodas5p,
    method RadauIia3,
    method RadauIia5,
    method Bdf,
    method Auto::new(),
}

/// The methods compared unless others are named, each where it belongs: implicit ones on stiff problems.
pub fn default_methods() -> Vec<String> {
    [first_order(), second_order(), stiff_order()].concat()
}

/// Compiles a problem with the methods above. Each pair costs about a second to compile.
macro_rules! meet {
    ($($order:ident $problem:expr,)*) => {
        fn is_compiled(name: &str) -> bool {
            [$(name_of(&$problem)),*].contains(&name)
        }

        fn run_compiled(contest: &Contest, progress: impl FnMut(f64) + 'static) -> Result<Outcome, Unfit> {
            $(if contest.problem.name == name_of(&$problem) {
                return $order(contest, $problem, progress);
            })*
            unreachable!("asked before whether it is compiled")
        }
    };
}
meet! {
    first Lorenz63,
    first LotkaVolterra,
    first RigidBody,
    first VdpMu1,
    first Arenstorf4Loop,
    second KeplerE06,
    second Pleiades,
    first Brusselator2d::new(64),
    stiff VdpMu1000,
    stiff RobertsonUntil40,
    stiff Hires,
    stiff Orego,
    stiff Pollution,
}

fn name_of<P: Problem>(_: &P) -> &'static str {
    P::NAME
}

impl Contest {
    pub fn new(problem: problems::Entry, chosen: &[Contestant], tolerances: &[f64]) -> Self {
        let (methods, others): (Vec<_>, Vec<_>) =
            chosen.iter().cloned().partition(|method| problem.second_order || !method.second_order);
        let methods: Vec<_> =
            methods.into_iter().filter(|method| method.named || method.implicit == problem.stiff).collect();
        let unfit = others.into_iter().filter(|method| method.named).map(|method| method.name).collect();
        let matrix = match problem.stiff {
            true => stiff_order(),
            false => [first_order(), second_order()].concat(),
        };
        let compiled = |m: &&Contestant| is_compiled(problem.name) && m.shipped && matrix.contains(&m.name);
        let not_compiled = methods.iter().filter(|m| !compiled(m)).map(|m| m.name.clone()).collect();
        Self { problem, methods, unfit, not_compiled, tolerances: tolerances.to_vec() }
    }

    pub fn run(&self, progress: impl FnMut(f64) + 'static) -> Result<Outcome, Unfit> {
        if self.not_compiled.is_empty() {
            return run_compiled(self, progress);
        }
        let mut find = Find { contest: self, progress: Some(progress), outcome: None };
        visit_all(&mut find);
        find.outcome.expect("the problem is of the catalogue")
    }
}

fn first<P: Problem>(
    contest: &Contest,
    problem: P,
    progress: impl FnMut(f64) + 'static,
) -> Result<Outcome, Unfit> {
    let comparison = enter_first(posed(&problem), &contest.methods);
    finish(contest, &problem, comparison, progress)
}

fn stiff<P: Problem>(
    contest: &Contest,
    problem: P,
    progress: impl FnMut(f64) + 'static,
) -> Result<Outcome, Unfit> {
    let comparison = enter_stiff(posed(&problem), &contest.methods);
    finish(contest, &problem, comparison, progress)
}

fn second<P: SecondOrder>(
    contest: &Contest,
    problem: P,
    progress: impl FnMut(f64) + 'static,
) -> Result<Outcome, Unfit> {
    let (t0, t1) = problem.span();
    let p = problem.clone();
    let f = move |t: f64, x: &P::X, a: &mut P::X| p.acceleration(t, x, a);
    let second = Comparison::second_order(P::NAME, f, problem.x0(), problem.v0(), t0..t1);
    let comparison = enter_first(posed(&problem), &contest.methods);
    finish(contest, &problem, comparison.and(enter_second(second, &contest.methods)), progress)
}

fn posed<'w, P: Problem>(problem: &P) -> Comparison<'w, P::Y, impl System<P::Y> + Clone + 'w> {
    let (t0, t1) = problem.span();
    Comparison::of_system(P::NAME, Equation(problem.clone()), problem.y0(), t0..t1)
}

/// What is known of the problem, how long to run, and off.
fn finish<P: Problem, Y: State<Scalar = f64> + 'static, S: System<Y> + Clone + 'static>(
    contest: &Contest,
    problem: &P,
    mut comparison: Comparison<'static, Y, S>,
    progress: impl FnMut(f64) + 'static,
) -> Result<Outcome, Unfit> {
    if let Some(reference) = problem.reference() {
        comparison = comparison.reference(reference.as_ref());
    }
    if problem.exact(problem.span().0).is_some() {
        let p = problem.clone();
        comparison = comparison.exact(move |t| p.exact(t).expect("it has a closed form"));
    }
    if !contest.tolerances.is_empty() {
        comparison = comparison.tolerances(&contest.tolerances);
    }
    let (budget, longest) = (Duration::from_secs(2), Duration::from_millis(150));
    comparison.scale(problem.scale()).budget(budget).longest(longest).progress(progress).run()
}

/// Finds the problem by its name and runs it with every method interpreted.
struct Find<'c, F> {
    contest: &'c Contest,
    progress: Option<F>,
    outcome: Option<Result<Outcome, Unfit>>,
}

impl<F: FnMut(f64) + 'static> Visit for Find<'_, F> {
    fn visit<P: Problem>(&mut self, problem: P) {
        if P::NAME == self.contest.problem.name {
            let first = interpreted(self.contest, rhs(&problem), &problem.y0(), None, problem.span());
            self.outcome = self.progress.take().map(|bar| finish(self.contest, &problem, first, bar));
        }
    }

    fn visit_second_order<P: SecondOrder>(&mut self, problem: P) {
        if P::NAME == self.contest.problem.name {
            let p = problem.clone();
            let a = erased(problem.x0(), move |t, x, a| p.acceleration(t, x, a));
            let (x0, v0, span) = (problem.x0(), problem.v0(), problem.span());
            let second = interpreted(self.contest, a, &x0, Some(&v0), span);
            let first = interpreted(self.contest, rhs(&problem), &problem.y0(), None, span).and(second);
            self.outcome = self.progress.take().map(|bar| finish(self.contest, &problem, first, bar));
        }
    }
}

/// A right-hand side whose type is forgotten, so that the interpreter is compiled once for all problems.
type Erased = Rc<dyn Fn(f64, &[f64], &mut [f64])>;

fn rhs<P: Problem>(problem: &P) -> Erased {
    let p = problem.clone();
    erased(problem.y0(), move |t, y, dy| p.rhs(t, y, dy))
}

fn erased<Y: State<Scalar = f64> + 'static>(y: Y, f: impl Fn(f64, &Y, &mut Y) + 'static) -> Erased {
    let scratch = RefCell::new((y.clone(), y));
    Rc::new(move |t, from, to| {
        let (y, dy) = &mut *scratch.borrow_mut();
        y.as_mut_slice().copy_from_slice(from);
        f(t, y, dy);
        to.copy_from_slice(dy.as_slice());
    })
}

/// The chosen methods for y' = f, or with a velocity those for y'' = f, all interpreted.
fn interpreted(
    contest: &Contest,
    f: Erased,
    y0: &dyn AsRef<[f64]>,
    v0: Option<&dyn AsRef<[f64]>>,
    (t0, t1): (f64, f64),
) -> Comparison<'static, Vec<f64>, impl System<Vec<f64>> + Clone + 'static> {
    let f = move |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| f(t, y, dy);
    let y0 = y0.as_ref().to_vec();
    let name = contest.problem.name;
    let mut comparison = match v0 {
        None => Comparison::new(name, f, y0, t0..t1),
        Some(v0) => Comparison::second_order(name, f, y0, v0.as_ref().to_vec(), t0..t1),
    };
    for method in contest.methods.iter().filter(|method| method.second_order == v0.is_some()) {
        let loaded = method.loaded.clone();
        comparison = match (method.auto, method.adaptive) {
            (true, _) => comparison.method(Auto::from(loaded)),
            (false, true) => comparison.method(loaded),
            (false, false) => comparison.fixed(loaded),
        };
    }
    comparison
}
