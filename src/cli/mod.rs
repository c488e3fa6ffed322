//! The command line: one file for each command.

mod bake;
mod check;
mod compare;
mod grid;
mod hard;
mod image;
mod light;
mod list;
mod pen;
mod plot;
mod relief;
mod show;
mod solve;
mod stability;
mod stencils;
mod whole;
mod words;

use clap::{Parser, Subcommand};
use kutta::normals::{Stencil, stencils as all_stencils};
use kutta::tableau::{Tableau, TableauError, entries, stem};
use kutta::{methods, problems};
use std::borrow::Cow;
use std::fs;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

/// Solves ordinary differential equations with methods that are data, and shows speed against error.
#[derive(Parser)]
#[command(name = "kutta", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List all methods by family
    List(list::Args),
    /// Print a method's tableau or a stencil, and everything that follows from it
    Show(show::Args),
    /// Prove a method or stencil file as the compiler would
    Check(check::Args),
    Stability(stability::Args),
    Stencils(stencils::Args),
    /// Solve a problem of the catalogue
    Solve(solve::Args),
    Compare(compare::Args),
    Hard(hard::Args),
    Bake(bake::Args),
    Light(light::Args),
}

/// Why a command fails, in one line.
pub enum Failure {
    /// The input makes no sense; the line says what to do. Exit code 2.
    Input(String),
    /// The input is right, the outcome is not. Exit code 1.
    Outcome(String),
}

pub fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Err(error) => return refuse(&error),
        Ok(cli) => match &cli.command {
            Command::List(args) => list::run(args),
            Command::Show(args) => show::run(args),
            Command::Check(args) => check::run(args),
            Command::Stability(args) => stability::run(args),
            Command::Stencils(args) => stencils::run(args),
            Command::Solve(args) => solve::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Hard(args) => hard::run(args),
            Command::Bake(args) => bake::run(args),
            Command::Light(args) => light::run(args),
        },
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Outcome(line)) => complain(&line, 1),
        Err(Failure::Input(line)) => complain(&line, 2),
    }
}

fn complain(line: &str, code: u8) -> ExitCode {
    // Where nobody listens, the code tells.
    let _ = writeln!(std::io::stderr(), "{line}");
    ExitCode::from(code)
}

/// Arguments that clap refuses: its first paragraph and its advice as one line. Help is printed as it is.
fn refuse(error: &clap::Error) -> ExitCode {
    let text = error.to_string();
    if !text.starts_with("error: ") {
        let _ = error.print();
        return ExitCode::from(error.exit_code() as u8);
    }
    let wanted = |part: &&str| part.starts_with("error: ") || part.trim_start().starts_with("tip: ");
    let parts = text.split("\n\n").filter(wanted);
    let words: Vec<_> = parts.flat_map(str::split_whitespace).skip(1).collect();
    complain(&words.join(" ").replace(" tip: ", "; "), 2)
}

/// Prints to standard output. A reader that has seen enough is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Outcome(format!("the output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a value as JSON.
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => print(&(text + "\n")),
        Err(error) => Err(Failure::Outcome(format!("the output is no JSON: {error}"))),
    }
}

/// A method or stencil file, from the library or from a path.
pub struct Source {
    pub name: String,
    pub path: String,
    pub text: Cow<'static, str>,
    /// The compiler has proven it.
    pub proven: bool,
}

impl Source {
    /// The method of that name, or the file at that path.
    pub fn find(name: &str) -> Result<Self, Failure> {
        if let Some(entry) = methods::find(name) {
            return Ok(Self::shipped(entry.name, entry.path, entry.text));
        }
        if name.ends_with(".toml") || name.contains(['/', '\\']) {
            return Self::file(name);
        }
        let all = methods::all().iter().map(|entry| entry.name);
        Err(unknown("method", name, all, "`kutta list` shows all, and a path to a .toml file will do"))
    }

    /// The method or the stencil of that name, or the file at that path.
    pub fn find_any(name: &str) -> Result<Self, Failure> {
        if let Some(entry) = all_stencils::find(name) {
            return Ok(Self::shipped(entry.name, entry.path, entry.text));
        }
        Self::find(name).map_err(|failure| match failure {
            Failure::Input(line) if line.starts_with("there is no method") => {
                let methods = methods::all().iter().map(|entry| entry.name);
                let all = methods.chain(all_stencils::all().iter().map(|entry| entry.name));
                let advice = "`kutta list` and `kutta stencils` show all, and a path to a .toml file will do";
                unknown("method or stencil", name, all, advice)
            }
            failure => failure,
        })
    }

    fn shipped(name: &str, path: &str, text: &'static str) -> Self {
        Self { name: name.to_string(), path: path.to_string(), text: text.into(), proven: true }
    }

    pub fn file(path: &str) -> Result<Self, Failure> {
        let text = fs::read_to_string(path).map_err(|error| {
            Failure::Input(format!("{path} cannot be read as a method or stencil file: {error}"))
        })?;
        Ok(Self { name: stem(path).to_string(), path: path.to_string(), text: text.into(), proven: false })
    }

    /// What it holds is a stencil.
    pub fn is_stencil(&self) -> bool {
        entries(&self.text, "stencil").is_some()
    }

    pub fn stencil(&self) -> Result<Stencil<'_>, TableauError> {
        Stencil::parse(&self.text)
    }

    /// Its numbers, proven now if they are not yet.
    pub fn tableau(&self) -> Result<Tableau<'_>, TableauError> {
        let tableau = Tableau::parse(&self.text)?;
        if !self.proven {
            tableau.prove_all()?;
        }
        Ok(tableau)
    }

    /// Says where a file is wrong, in the compiler's words.
    pub fn message(&self, error: &TableauError) -> String {
        error.message(&self.path).as_str().to_string()
    }
}

/// `there is no method rk5: did you mean rk4 or rk38? ..`
pub fn unknown<'n>(what: &str, name: &str, all: impl Iterator<Item = &'n str>, advice: &str) -> Failure {
    let wanted = name.to_lowercase().replace('_', "-");
    let mut near: Vec<_> = all
        .map(|candidate| {
            let begins = wanted.len() > 2 && candidate.starts_with(&wanted);
            (if begins { 1 } else { distance(&wanted, candidate) }, candidate)
        })
        .filter(|&(distance, _)| distance <= (wanted.chars().count() / 3).max(1))
        .collect();
    near.sort();
    let near: Vec<_> = near.iter().take(4).map(|(_, candidate)| *candidate).collect();
    let guess = match near.as_slice() {
        [] => String::new(),
        [one] => format!("did you mean {one}? "),
        [most @ .., last] => format!("did you mean {} or {last}? ", most.join(", ")),
    };
    Failure::Input(format!("there is no {what} {name:?}: {guess}{advice}"))
}

/// Edits of a letter, and swaps of two neighbours, that turn one word into the other (Damerau's distance).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<_>, Vec<_>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let above = &rows[i - 1];
            let changed = above[j - 1] + (a[i - 1] != b[j - 1]) as usize;
            let mut best = changed.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// Demands a positive, finite number for an option.
pub fn positive(option: &str, x: f64, advice: &str) -> Result<(), Failure> {
    if x > 0.0 && x.is_finite() {
        return Ok(());
    }
    Err(Failure::Input(format!("{option} is {x:?}: it must be a positive number, {advice}")))
}

/// The problem of that name in the catalogue.
pub fn problem(name: &str) -> Result<problems::Entry, Failure> {
    let all = problems::catalogue();
    if let Some(entry) = all.iter().find(|entry| entry.name == name) {
        return Ok(*entry);
    }
    let names = all.iter().map(|entry| entry.name);
    let advice = format!("the problems are {}", names.clone().collect::<Vec<_>>().join(", "));
    Err(unknown("problem", name, names, &advice))
}
