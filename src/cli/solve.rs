//! `kutta solve`: a problem of the catalogue by a method of your choice.

use super::{Failure, Source, positive, print, print_json, problem};
use kutta::problems::{self, Problem, SecondOrder, Visit};
use kutta::{Loaded, Method, Solution, State, Stopped, Why, solve, solve_second};
use serde::Serialize;
use std::fmt::Write;
use std::ops::Range;

#[derive(clap::Args)]
pub struct Args {
    /// A problem of the catalogue
    #[arg(long)]
    problem: String,
    /// A method's name, or the path of a .toml file
    #[arg(long)]
    method: String,
    /// Relative tolerance of adaptive steps
    #[arg(long, default_value_t = 1e-6, allow_hyphen_values = true)]
    rtol: f64,
    /// Absolute tolerance of adaptive steps; default: rtol times the problem's scale
    #[arg(long, allow_hyphen_values = true)]
    atol: Option<f64>,
    /// Take fixed steps of this size; methods without an error estimate need it
    #[arg(long = "h", value_name = "H", allow_hyphen_values = true)]
    h: Option<f64>,
    /// Print a JSON object for scripts
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    problem: &'static str,
    method: String,
    t: f64,
    /// The state at t; of a second-order method the position, then the velocity.
    y: Vec<f64>,
    /// Largest |y - reference| / (|reference| + scale) over the components; null where there is no reference.
    error: Option<f64>,
    stats: Counts,
}

#[derive(Serialize)]
struct Counts {
    evaluations: u64,
    accepted: u64,
    rejected: u64,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let problem = problem(&args.problem)?;
    let source = Source::find(&args.method)?;
    let tableau = source.tableau().map_err(|error| Failure::Input(source.message(&error)))?;
    let name = &source.name;
    let refuse = |line: String| Err(Failure::Input(line));
    if !tableau.steppable() {
        return refuse(format!("{name} cannot be stepped yet: `kutta list` shows which methods can"));
    }
    if tableau.second_order() && !problem.second_order {
        let all = problems::catalogue();
        let fit: Vec<_> = all.iter().filter(|entry| entry.second_order).map(|entry| entry.name).collect();
        return refuse(format!(
            "{name} is for y'' = f(t, y), which {} is not: solve {}",
            problem.name,
            fit.join(", ")
        ));
    }
    match args.h {
        Some(h) => positive("--h", h, "such as 0.01")?,
        None if tableau.form().is_none_or(|form| !form.adaptive()) => {
            return refuse(format!(
                "{name} has no error estimate: give it steps of one size, such as --h 0.01"
            ));
        }
        None => {}
    }
    positive("--rtol", args.rtol, "such as 1e-6")?;
    args.atol.map_or(Ok(()), |atol| positive("--atol", atol, "such as 1e-9"))?;
    let method = Loaded::parse(name, &source.text).map_err(|error| Failure::Input(source.message(&error)))?;
    let mut solver = Solver { args, method, name: problem.name, report: None };
    problems::visit_all(&mut solver);
    match solver.report {
        Some(Ok(report)) if args.json => print_json(&report),
        Some(Ok(report)) => print(&in_words(&report, args)),
        Some(Err(failure)) => Err(failure),
        None => refuse(format!("{} is not in the catalogue", problem.name)),
    }
}

/// f(t, y), written into the last one.
type Rhs<'f> = &'f mut dyn FnMut(f64, &[f64], &mut [f64]);

/// Finds the problem by its name and solves it.
struct Solver<'a> {
    args: &'a Args,
    method: Loaded,
    name: &'static str,
    report: Option<Result<Report, Failure>>,
}

impl Visit for Solver<'_> {
    fn visit<P: Problem>(&mut self, problem: P) {
        if P::NAME == self.name {
            // One solver for states of every size: the problem's own type is forgotten.
            let (mut y, mut dy) = (problem.y0(), problem.y0());
            let mut f = |t: f64, from: &[f64], to: &mut [f64]| {
                y.as_mut().copy_from_slice(from);
                problem.rhs(t, &y, &mut dy);
                to.copy_from_slice(dy.as_ref());
            };
            let (t0, t1) = problem.span();
            self.run(&problem, &mut f, problem.y0().as_ref(), None, t0..t1);
        }
    }

    fn visit_second_order<P: SecondOrder>(&mut self, problem: P) {
        if self.method.form().d == 1 {
            return self.visit(problem);
        }
        if P::NAME == self.name {
            let (mut x, mut a) = (problem.x0(), problem.x0());
            let mut f = |t: f64, from: &[f64], to: &mut [f64]| {
                x.as_mut().copy_from_slice(from);
                problem.acceleration(t, &x, &mut a);
                to.copy_from_slice(a.as_ref());
            };
            let (t0, t1) = problem.span();
            let v0 = problem.v0();
            self.run(&problem, &mut f, problem.x0().as_ref(), Some(v0.as_ref()), t0..t1);
        }
    }
}

impl Solver<'_> {
    fn run<P: Problem>(&mut self, problem: &P, f: Rhs, y0: &[f64], v0: Option<&[f64]>, span: Range<f64>) {
        let found = self.solve(problem.scale(), f, y0, v0, span);
        self.report = Some(found.map(|solution| {
            let mut y = solution.y;
            y.extend(solution.v.unwrap_or_default());
            let reference = problem.reference();
            let error = reference.map(|reference| distance(&y, reference.as_slice(), problem.scale()));
            let stats = Counts {
                evaluations: solution.stats.evaluations,
                accepted: solution.stats.accepted,
                rejected: solution.stats.rejected.total(),
            };
            Report {
                problem: P::NAME,
                method: self.method.name().to_string(),
                t: solution.t,
                y,
                error,
                stats,
            }
        }));
    }

    fn solve(
        &self,
        scale: f64,
        f: Rhs,
        y0: &[f64],
        v0: Option<&[f64]>,
        span: Range<f64>,
    ) -> Result<Solution<Vec<f64>>, Failure> {
        let f = |t: f64, y: &Vec<f64>, dy: &mut Vec<f64>| f(t, y, dy);
        let (y0, method) = (y0.to_vec(), self.method.clone());
        let atol = self.args.atol.unwrap_or(self.args.rtol * scale);
        let done = match (v0, self.args.h) {
            (None, None) => solve(f, y0, span).with(method).rtol(self.args.rtol).atol(atol).run(),
            (None, Some(h)) => solve(f, y0, span).with(method).step(h).run(),
            (Some(v0), None) => {
                solve_second(f, y0, v0.to_vec(), span).with(method).rtol(self.args.rtol).atol(atol).run()
            }
            (Some(v0), Some(h)) => solve_second(f, y0, v0.to_vec(), span).with(method).step(h).run(),
        };
        done.map_err(|stopped: Stopped<Vec<f64>>| match stopped.why {
            Why::Invalid(line) => Failure::Input(line),
            _ => Failure::Outcome(stopped.to_string()),
        })
    }
}

/// NaN where a component is one.
fn distance(y: &[f64], reference: &[f64], scale: f64) -> f64 {
    let each = y.iter().zip(reference).map(|(y, r)| (y - r).abs() / (r.abs() + scale));
    each.fold(0.0, |largest, d| if d <= largest { largest } else { d })
}

/// Components printed for people; scripts get all of them.
const SHOWN: usize = 12;

fn in_words(report: &Report, args: &Args) -> String {
    let mut out = format!("{} by {}, ", report.problem, report.method);
    out += &match args.h {
        Some(h) => format!("fixed steps of {h:e}\n"),
        None => format!("rtol {:e}\n", args.rtol),
    };
    let _ = writeln!(out, "t     {}", report.t);
    for (i, y) in report.y.iter().take(SHOWN).enumerate() {
        let _ = writeln!(out, "y[{i}]  {y:>23.16e}");
    }
    if report.y.len() > SHOWN {
        let _ = writeln!(out, "...   {} more components: --json prints all", report.y.len() - SHOWN);
    }
    let _ = match report.error {
        Some(error) => writeln!(out, "error {error:.3e}, largest of a component, relative to |y| + scale"),
        None => writeln!(out, "error unknown: the problem has no reference"),
    };
    let Counts { evaluations, accepted, rejected } = report.stats;
    let _ = writeln!(out, "steps {accepted} accepted, {rejected} rejected; {evaluations} evaluations");
    out
}
