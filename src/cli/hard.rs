//! `kutta hard`: the errors that stiff methods reach on hard problems, against the tolerance.

use super::{Failure, Source, print, print_json, unknown};
use comfy_table::{CellAlignment, Table, TableComponent, presets};
use kutta::compare::hard::{Case, PROMISED, Reached, TOLERANCES, cases};
use kutta::compare::label;
use kutta::{Auto, Loaded, Method, Why, methods};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Tried unless others are named: the best of each kind, and what a run takes whose method is not named.
const METHODS: [&str; 8] =
    ["kencarp4-esdirk", "kvaerno5", "rodas4", "rodas5p", "radau-iia3", "radau-iia5", "bdf", Auto::NAME];
/// A method that needs more steps to a tolerance is not the one for it.
const STEPS: u64 = 10_000;
/// A run that takes longer ends the tighter ones of its method on that problem.
const LONGEST: Duration = Duration::from_millis(600);

/// Show the error of stiff methods on hard problems, over the tolerance
///
/// Every method runs at tolerances from 1e-3 to 1e-11, with an absolute one a hundredth of the problem's scale. A
/// cell is the error at the end over the tolerance: an error test per step promises some units. Where more is
/// no fault of the method, a letter gives the reason; `!` marks what has none.
#[derive(clap::Args)]
pub struct Args {
    /// Methods by name, paths of .toml files, or `auto`, the choice of the library; default: seven of all kinds and `auto`
    #[arg(long = "method", value_name = "NAME", value_delimiter = ',')]
    methods: Vec<String>,
    /// Hard problems by name; default: all
    #[arg(long = "problem", value_name = "NAME", value_delimiter = ',')]
    problems: Vec<String>,
    /// Take every adaptive method with implicit stages, and `auto`
    #[arg(long, conflicts_with = "methods")]
    all: bool,
    /// Print the rows as JSON in place of the tables
    #[arg(long)]
    json: bool,
}

/// A run as scripts read it.
#[derive(Serialize)]
struct Line {
    method: String,
    problem: String,
    tolerance: f64,
    /// Null where the run stopped.
    error: Option<f64>,
    /// Largest error over the tolerance that is no fault.
    allowed: f64,
    reason: Option<&'static str>,
    stopped: Option<String>,
    accepted: u64,
    evaluations: u64,
    jacobians: u64,
    factorizations: u64,
    #[serde(skip)]
    mark: &'static str,
}

/// Who solves.
enum Solver {
    Named(Loaded),
    Auto(Auto),
}

impl Solver {
    fn name(&self) -> &str {
        match self {
            Self::Named(method) => label(method),
            Self::Auto(auto) => label(auto),
        }
    }

    fn attempt(&self, case: &Case, tolerance: f64) -> Result<Reached, Why> {
        match self {
            Self::Named(method) => case.attempt(method, tolerance, STEPS),
            Self::Auto(auto) => case.attempt(auto, tolerance, STEPS),
        }
    }

    fn allowed(&self, case: &Case, tolerance: f64) -> (f64, Option<&'static str>) {
        match self {
            Self::Named(method) => case.allowed(method, tolerance),
            Self::Auto(auto) => case.allowed(auto, tolerance),
        }
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let cases = chosen(&args.problems)?;
    let mut lines = vec![];
    for method in contestants(args)? {
        let found: Vec<Vec<Line>> = cases.iter().map(|case| ladder(case, &method)).collect();
        if !args.json {
            print(&table(method.name(), &found))?;
        }
        lines.extend(found.into_iter().flatten());
    }
    if args.json { print_json(&lines) } else { Ok(()) }
}

fn chosen(names: &[String]) -> Result<Vec<Case>, Failure> {
    let all = cases();
    for name in names {
        if !all.iter().any(|case| case.name == *name) {
            let known = all.iter().map(|case| case.name.as_str());
            let advice = format!("the hard problems are {}", known.clone().collect::<Vec<_>>().join("; "));
            return Err(unknown("hard problem", name, known, &advice));
        }
    }
    Ok(all.into_iter().filter(|case| names.is_empty() || names.contains(&case.name)).collect())
}

fn contestants(args: &Args) -> Result<Vec<Solver>, Failure> {
    let fits = |method: &Loaded| {
        let form = method.form();
        form.d == 1 && form.adaptive() && !form.explicit() && (form.orders == 0 || form.damped)
    };
    if args.all {
        let all = methods::all().iter().filter_map(|m| Loaded::parse(m.name, m.text).ok());
        return Ok(all.filter(fits).map(Solver::Named).chain([Solver::Auto(Auto::new())]).collect());
    }
    let default = METHODS.map(String::from);
    let names = if args.methods.is_empty() { &default[..] } else { &args.methods };
    let load = |name: &String| {
        if name == Auto::NAME {
            return Ok(Solver::Auto(Auto::new()));
        }
        let source = Source::find(name)?;
        source.tableau().map_err(|error| Failure::Input(source.message(&error)))?;
        let loaded = Loaded::parse(&source.name, &source.text);
        let method = loaded.map_err(|error| Failure::Input(source.message(&error)))?;
        match fits(&method) {
            true => Ok(Solver::Named(method)),
            false => Err(Failure::Input(format!(
                "{name} is not for stiff problems with adaptive steps: its stages are explicit or it has no error estimate, or it solves them without a matrix"
            ))),
        }
    };
    names.iter().map(load).collect()
}

/// A problem at every tolerance; after a run that is too long the tighter ones are left out.
fn ladder(case: &Case, method: &Solver) -> Vec<Line> {
    let (mut lines, mut ended): (_, Option<&'static str>) = (vec![], None);
    for tolerance in TOLERANCES {
        let (allowed, reason) = method.allowed(case, tolerance);
        let mut line = Line {
            method: method.name().to_string(),
            problem: case.name.clone(),
            tolerance,
            error: None,
            allowed,
            reason: None,
            stopped: ended.map(|mark| format!("not run: {mark} at a looser tolerance")),
            accepted: 0,
            evaluations: 0,
            jacobians: 0,
            factorizations: 0,
            mark: ended.unwrap_or(""),
        };
        if ended.is_none() {
            let start = Instant::now();
            match method.attempt(case, tolerance) {
                Ok(reached) => {
                    line.error = Some(reached.error);
                    line.reason = reason.filter(|_| !(reached.error <= PROMISED * tolerance));
                    line.accepted = reached.stats.accepted;
                    line.evaluations = reached.stats.evaluations;
                    line.jacobians = reached.stats.jacobians;
                    line.factorizations = reached.stats.factorizations;
                }
                Err(why) => {
                    line.mark = if matches!(why, Why::TooManySteps { .. }) { "steps" } else { "stops" };
                    line.stopped = Some(why.to_string());
                    ended = matches!(why, Why::TooManySteps { .. }).then_some("steps");
                }
            }
            if start.elapsed() > LONGEST {
                ended = Some(ended.unwrap_or("time"));
            }
        }
        lines.push(line);
    }
    lines
}

impl Line {
    /// Its error is within what is allowed.
    fn passes(&self) -> bool {
        self.error.is_some_and(|error| error <= self.allowed * self.tolerance)
    }

    fn cell(&self, reasons: &mut Vec<&'static str>) -> String {
        let Some(error) = self.error else { return self.mark.to_string() };
        let ratio = error / self.tolerance;
        let shown = if ratio < 99.95 { format!("{ratio:.1}") } else { format!("{ratio:.0e}") };
        match self.reason {
            _ if !self.passes() => format!("{shown} !"),
            Some(reason) => {
                let known = reasons.iter().position(|other| *other == reason).unwrap_or_else(|| {
                    reasons.push(reason);
                    reasons.len() - 1
                });
                format!("{shown} {}", char::from(b'a' + known as u8))
            }
            None => format!("{shown}  "),
        }
    }
}

fn table(method: &str, found: &[Vec<Line>]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY);
    for between_rows in [TableComponent::HorizontalLines, TableComponent::MiddleIntersections] {
        table.remove_style(between_rows);
    }
    let mut header = vec![method.to_string()];
    header.extend(TOLERANCES.map(|tolerance| format!("{tolerance:.0e}")));
    table.set_header(header);
    let mut reasons = vec![];
    for lines in found {
        let mut row = vec![lines[0].problem.clone()];
        row.extend(lines.iter().map(|line| line.cell(&mut reasons)));
        table.add_row(row);
    }
    for column in 1..=TOLERANCES.len() {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = table.trim_fmt() + "\n";
    let all = || found.iter().flatten();
    let count = |keep: fn(&&Line) -> bool| all().filter(keep).count();
    let (ended, passed) = (count(|line| line.error.is_some()), count(|line| line.passes()));
    let within = count(|line| line.error.is_some_and(|error| error <= PROMISED * line.tolerance));
    text += &format!(
        "{method}: {passed} of {ended} runs that ended pass, {within} of them below {PROMISED} times the tolerance; {} stopped\n",
        count(|line| line.error.is_none())
    );
    if passed < ended {
        text += "!: more than the problem explains\n";
    }
    for (i, reason) in reasons.iter().enumerate() {
        text += &format!("{}: {reason}\n", char::from(b'a' + i as u8));
    }
    text + "\n"
}
