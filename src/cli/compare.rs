//! `kutta compare`: speed against error on the catalogue's problems, as a table, plots and JSON.

mod contest;
pub mod files;
mod table;

use super::pen::Picture;
use super::{Failure, Source, plot, positive, print, print_json, problem};
use contest::{Contest, Contestant};
use files::Folder;
use indicatif::{ProgressBar, ProgressStyle};
use kutta::compare::{Outcome, Row};
use kutta::{Auto, problems};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Problems compared on unless others are named: small ones, one of middle size, and stiff ones.
const PROBLEMS: [&str; 13] = [
    "lorenz63",
    "lotka-volterra",
    "rigid-body",
    "vdp-mu1",
    "arenstorf-4loop",
    "kepler-e06",
    "pleiades",
    "brusselator2d",
    "vdp-mu1000",
    "robertson-40",
    "hires",
    "orego",
    "pollution",
];

/// Compare methods by the time they need for an error
///
/// Every method runs at every tolerance, or, where it has fixed steps, at step sizes halved from coarse to
/// fine. The error is the one at the end of the problem's span, relative to its known solution.
#[derive(clap::Args)]
pub struct Args {
    /// Problems of the catalogue; default: eight that are not stiff and five that are
    #[arg(long = "problem", value_name = "NAME", value_delimiter = ',')]
    problems: Vec<String>,
    /// Methods by name, paths of .toml files, or `auto`, the choice of the library; default: about ten of all kinds,
    /// and for stiff problems eight and `auto`
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    methods: Vec<String>,
    /// A method file that joins the others
    #[arg(long = "table", value_name = "FILE")]
    tables: Vec<PathBuf>,
    /// Relative tolerances of the adaptive runs; default: 1e-2 to 1e-14
    #[arg(long, value_name = "RTOL", value_delimiter = ',', allow_hyphen_values = true)]
    tolerances: Vec<String>,
    /// Folder for the plots and compare.json
    #[arg(long, value_name = "DIR", default_value = "compare")]
    out: PathBuf,
    /// Print the rows as JSON in place of the tables
    #[arg(long)]
    json: bool,
}

/// Runs the command. What is wrong with the arguments shows before anything is computed or written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let tolerances = args.tolerances.iter().map(|text| tolerance(text)).collect::<Result<Vec<_>, _>>()?;
    let problems = chosen_problems(&args.problems)?;
    let contestants = contestants(args)?;
    let mut contests: Vec<_> =
        problems.into_iter().map(|problem| Contest::new(problem, &contestants, &tolerances)).collect();
    contests.retain(|contest| !contest.methods.is_empty());
    if contests.is_empty() {
        let line = "these methods are for y'' = f(t, y): choose a problem of that kind, such as kepler-e06";
        return Err(Failure::Input(line.to_string()));
    }
    let folder = Folder::open(&args.out).map_err(Failure::Input)?;

    // Drawn on stderr, and only where that is a terminal.
    let bar = ProgressBar::new(1000 * contests.len() as u64);
    let style = ProgressStyle::with_template("{bar:40} {percent}% {msg} (about {eta} left)");
    bar.set_style(style.expect("a constant template"));
    let mut rows: Vec<Row> = vec![];
    for (contest, begun) in contests.iter().zip((0..).step_by(1000)) {
        let name = contest.problem.name;
        bar.set_message(name);
        let advance = bar.clone();
        let progress = move |part: f64| advance.set_position(begun + (1000.0 * part) as u64);
        let Outcome { rows: found, reference } =
            contest.run(progress).map_err(|unfit| Failure::Outcome(format!("{name}: {unfit}")))?;
        if !args.json {
            let text = table::of(contest, &found, &reference) + "\n";
            bar.suspend(|| print(&text))?;
        }
        let names: Vec<&str> = contest.methods.iter().map(|method| method.name.as_str()).collect();
        let drawing = plot::Plot::of(name, &names, &found);
        folder.write(&format!("{name}.svg"), |path| drawing.svg(path)).map_err(Failure::Outcome)?;
        folder.write(&format!("{name}.png"), |path| drawing.png(path)).map_err(Failure::Outcome)?;
        rows.extend(found);
    }
    bar.finish_and_clear();
    let lines: Vec<Line> = rows.iter().map(Line::of).collect();
    folder.write("compare.json", |path| written(&lines, path)).map_err(Failure::Outcome)?;
    if args.json {
        return print_json(&lines);
    }
    print(&format!("Plots and compare.json are in {}.\n", args.out.display()))
}

fn written(lines: &[Line], path: &Path) -> Result<(), String> {
    let json = serde_json::to_string_pretty(lines).map_err(|error| error.to_string())?;
    std::fs::write(path, json + "\n").map_err(|error| error.to_string())
}

/// A row as scripts read it.
#[derive(Serialize)]
struct Line<'r> {
    problem: &'r str,
    method: &'r str,
    tolerance: f64,
    error: Option<f64>,
    max_error: Option<f64>,
    seconds_min: Option<f64>,
    seconds_median: Option<f64>,
    evaluations: u64,
    jacobians: u64,
    factorizations: u64,
    accepted: u64,
    rejected: u64,
    failure: Option<&'r str>,
}

impl<'r> Line<'r> {
    fn of(row: &'r Row) -> Self {
        Self {
            problem: &row.problem,
            method: &row.method,
            tolerance: row.tolerance,
            error: row.error,
            max_error: row.max_error,
            seconds_min: row.seconds_min,
            seconds_median: row.seconds_median,
            evaluations: row.evaluations,
            jacobians: row.jacobians,
            factorizations: row.factorizations,
            accepted: row.accepted,
            rejected: row.rejected,
            failure: row.failure.as_deref(),
        }
    }
}

fn tolerance(text: &str) -> Result<f64, Failure> {
    let advice = "such as 1e-6";
    let number = text.trim().parse();
    let rtol =
        number.map_err(|_| Failure::Input(format!("--tolerances: {text:?} is not a number, {advice}")))?;
    positive("--tolerances", rtol, advice).map(|()| rtol)
}

fn chosen_problems(names: &[String]) -> Result<Vec<problems::Entry>, Failure> {
    let mut chosen: Vec<problems::Entry> = vec![];
    let default = PROBLEMS.map(String::from);
    for name in if names.is_empty() { &default } else { names } {
        let entry = problem(name)?;
        if !chosen.contains(&entry) {
            chosen.push(entry);
        }
    }
    Ok(chosen)
}

/// The methods, in the order of their curves' colours.
fn contestants(args: &Args) -> Result<Vec<Contestant>, Failure> {
    let default = contest::default_methods();
    let names = if args.methods.is_empty() { &default } else { &args.methods };
    let load = |source: Source, named: bool| {
        Contestant::new(&source, named).map_err(|error| Failure::Input(source.message(&error)))
    };
    let mut all = vec![];
    for name in names {
        let named = !args.methods.is_empty();
        all.push(match name.as_str() {
            Auto::NAME => Contestant::auto(named).expect("the compiler has proven it"),
            name => load(Source::find(name)?, named)?,
        });
    }
    for path in &args.tables {
        all.push(load(Source::file(&path.to_string_lossy())?, true)?);
    }
    let mut chosen: Vec<Contestant> = vec![];
    for method in all {
        match chosen.iter().find(|other| other.name == method.name) {
            Some(other) if other.path == method.path => {}
            Some(other) => {
                let Contestant { path, name, .. } = &method;
                let line =
                    format!("{path}: {name} is compared already, from {}: rename the file", other.path);
                return Err(Failure::Input(line));
            }
            None => chosen.push(method),
        }
    }
    Ok(chosen)
}
