//! `kutta compare`: speed against error on the catalogue's problems, as a table, plots and JSON.

mod contest;
mod files;
mod table;

use super::plot;
use contest::{Contest, Contestant};
use files::Folder;
use indicatif::{ProgressBar, ProgressStyle};
use kutta::compare::{Outcome, Row};
use kutta::problems;
use kutta::{Loaded, Method, methods};
use serde::Serialize;
use std::path::PathBuf;

/// Problems compared on unless others are named: not stiff, small, and one of middle size.
const PROBLEMS: [&str; 9] = [
    "lorenz63",
    "lotka-volterra",
    "rigid-body",
    "vdp-mu1",
    "arenstorf-4loop",
    "kepler-e06",
    "harmonic-oscillator",
    "pleiades",
    "brusselator2d",
];

/// Compares methods by the time they need for an error
///
/// Every method runs at every tolerance, or, where it has fixed steps, at step sizes halved from coarse to
/// fine. The error is the one at the end of the problem's span, relative to its known solution.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Problems, by name; default: nine that are not stiff
    #[arg(long = "problem", alias = "problems", value_name = "NAME", value_delimiter = ',')]
    pub problems: Vec<String>,
    /// Methods, by name; default: about ten of all kinds
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// A method file to be compared with the others
    #[arg(long = "table", value_name = "FILE")]
    pub tables: Vec<PathBuf>,
    /// Relative tolerances of the adaptive runs; default: 1e-2 to 1e-14
    #[arg(long, value_name = "RTOL", value_delimiter = ',', allow_hyphen_values = true)]
    pub tolerances: Vec<String>,
    /// Folder for the plots and compare.json
    #[arg(long, value_name = "DIR", default_value = "compare")]
    pub out: PathBuf,
    /// Print the rows as JSON in place of the tables
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong with the arguments, before anything is computed or written.
pub fn run(args: &Args) -> Result<(), String> {
    let tolerances = tolerances(&args.tolerances)?;
    let problems = chosen_problems(&args.problems)?;
    let contestants = contestants(&args.methods, &args.tables)?;
    let contests: Vec<Contest> = problems
        .into_iter()
        .map(|problem| Contest::new(problem, &contestants, &tolerances))
        .filter(|contest| !contest.methods.is_empty())
        .collect();
    if contests.is_empty() {
        return Err(
            "these methods are for y'' = f(t, y): choose a problem of second order, such as kepler-e06"
                .into(),
        );
    }
    let folder = Folder::open(&args.out)?;

    // Drawn on stderr, and only where that is a terminal.
    let bar = ProgressBar::new(1000 * contests.len() as u64);
    let style = ProgressStyle::with_template("{bar:40} {percent}% {msg} (about {eta} left)");
    bar.set_style(style.expect("a constant template"));
    let mut rows: Vec<Row> = vec![];
    for (i, contest) in contests.iter().enumerate() {
        bar.set_message(contest.problem.name);
        let advance = bar.clone();
        let progress = move |part: f64| advance.set_position(1000 * i as u64 + (1000.0 * part) as u64);
        let Outcome { rows: found, reference } =
            contest.run(progress).map_err(|unfit| format!("{}: {unfit}", contest.problem.name))?;
        if !args.json {
            let text = table::of(contest, &found, &reference);
            bar.suspend(|| print(&text))?;
        }
        let names: Vec<&str> = contest.methods.iter().map(|method| method.name.as_str()).collect();
        let drawing = plot::Plot::of(contest.problem.name, &names, &found);
        folder.write(&format!("{}.svg", contest.problem.name), |path| drawing.svg(path))?;
        folder.write(&format!("{}.png", contest.problem.name), |path| drawing.png(path))?;
        rows.extend(found);
    }
    bar.finish_and_clear();
    let json = serde_json::to_string_pretty(&rows.iter().map(Line::of).collect::<Vec<_>>())
        .map_err(|error| format!("the rows cannot be written as JSON: {error}"))?;
    folder.write("compare.json", |path| std::fs::write(path, json.as_bytes()).map_err(|e| e.to_string()))?;
    if args.json {
        return print(&json);
    }
    print(&format!("Plots and compare.json are in {}.", args.out.display()))
}

/// A line to stdout; a reader that has gone away, like `head`, is no error.
fn print(text: &str) -> Result<(), String> {
    use std::io::{ErrorKind, Write};
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("stdout: {error}")),
        _ => Ok(()),
    }
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
            accepted: row.accepted,
            rejected: row.rejected,
            failure: row.failure.as_deref(),
        }
    }
}

fn tolerances(texts: &[String]) -> Result<Vec<f64>, String> {
    let parse = |text: &String| match text.trim().parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("--tolerances: `{text}` is not a positive number, such as 1e-6")),
    };
    texts.iter().map(parse).collect()
}

fn chosen_problems(names: &[String]) -> Result<Vec<problems::Entry>, String> {
    let all = problems::catalogue();
    let default: Vec<String> = PROBLEMS.map(String::from).to_vec();
    let mut chosen: Vec<problems::Entry> = vec![];
    for name in if names.is_empty() { &default } else { names } {
        let Some(entry) = all.iter().find(|entry| entry.name == name) else {
            let known: Vec<&str> = all.iter().map(|entry| entry.name).collect();
            return Err(format!("there is no problem `{name}`: choose from {}", known.join(", ")));
        };
        if !chosen.contains(entry) {
            chosen.push(*entry);
        }
    }
    Ok(chosen)
}

fn contestants(names: &[String], tables: &[PathBuf]) -> Result<Vec<Contestant>, String> {
    let default = contest::default_methods();
    let mut chosen: Vec<Contestant> = vec![];
    for name in if names.is_empty() { &default } else { names } {
        let Some(entry) = methods::find(name) else {
            return Err(format!("there is no method `{name}`: `kutta list` shows all"));
        };
        if chosen.iter().all(|method| method.name != *name) {
            let loaded = Loaded::parse(name, entry.text).map_err(|error| format!("{name}: {error}"))?;
            chosen.push(Contestant::new(loaded, true));
        }
    }
    for path in tables {
        let shown = path.display();
        let text = std::fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        if chosen.iter().any(|method| method.name == name) {
            return Err(format!("{shown}: another method compared is called `{name}`: rename the file"));
        }
        let loaded = Loaded::parse(name, &text)
            .map_err(|error| error.message(&shown.to_string()).as_str().to_string())?;
        chosen.push(Contestant::new(loaded, false));
    }
    Ok(chosen)
}

impl Contestant {
    fn new(loaded: Loaded, shipped: bool) -> Self {
        let form = loaded.form();
        let (adaptive, second_order) = (form.errors > 0, form.d == 2);
        Self { name: loaded.name().to_string(), compiled: shipped, adaptive, second_order, loaded }
    }
}
