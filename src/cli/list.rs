//! `kutta list`: all methods by family.

use super::{Failure, print, print_json};
use kutta::methods;
use kutta::tableau::Tableau;
use serde::Serialize;
use std::fmt::Write;

#[derive(clap::Args)]
pub struct Args {
    /// Print a JSON array for scripts
    #[arg(long)]
    json: bool,
}

/// What the JSON says of every method.
#[derive(Serialize)]
pub struct Item {
    pub name: String,
    pub title: String,
    pub family: &'static str,
    pub order: usize,
    /// The order of each embedded row.
    pub embedded: Vec<usize>,
    /// The order of the dense output.
    pub dense: Option<usize>,
    pub stages: usize,
    pub steppable: bool,
    #[serde(skip)]
    adaptive: bool,
}

impl Item {
    pub fn of(name: &str, tableau: &Tableau) -> Self {
        Self {
            name: name.to_string(),
            title: tableau.title.to_string(),
            family: tableau.family(),
            order: tableau.order,
            embedded: tableau.embedded.into_iter().filter(|&order| order > 0).collect(),
            dense: (tableau.dense_order > 0).then_some(tableau.dense_order),
            stages: tableau.stages(),
            steppable: tableau.steppable(),
            adaptive: tableau.form().is_some_and(|form| form.adaptive()),
        }
    }

    fn purpose(&self) -> &'static str {
        match (self.family, !self.adaptive, self.order) {
            ("explicit Runge-Kutta", true, _) => "fixed steps",
            ("explicit Runge-Kutta", false, ..=3) => "adaptive, loose tolerances",
            ("explicit Runge-Kutta", false, ..=6) => "adaptive, 1e-3 to 1e-8",
            ("explicit Runge-Kutta", false, _) => "adaptive, tight tolerances",
            ("explicit multistep" | "predictor-corrector", ..) => "fixed steps, costly f",
            ("variable-order multistep", ..) => "adaptive, order varies",
            ("Stormer" | "Nystrom" | "splitting", ..) => "fixed steps, long runs",
            (_, true, _) => "fixed steps",
            (_, false, _) => "adaptive",
        }
    }
}

/// Every family, those that can be stepped first, and what it is for.
const FAMILIES: [(&str, &str); 13] = [
    ("explicit Runge-Kutta", "y' = f(t, y), not stiff"),
    ("explicit multistep", "y' = f(t, y), not stiff, one evaluation a step"),
    ("predictor-corrector", "y' = f(t, y), not stiff, one or two evaluations a step"),
    ("Stormer", "y'' = f(t, y), positions alone"),
    ("Nystrom", "y'' = f(t, y)"),
    ("splitting", "y'' = f(t, y), energy kept over long runs"),
    ("diagonally implicit Runge-Kutta", "stiff"),
    ("fully implicit Runge-Kutta", "stiff, or high order"),
    ("implicit multistep", "stiff (BDF), or the corrector of a pair (Adams-Moulton)"),
    ("variable-order multistep", "stiff (BDF), or not stiff and f costly (Adams); order and step vary"),
    ("Rosenbrock", "stiff, with the Jacobian at hand"),
    ("IMEX pair", "y' = f + g, g stiff"),
    ("partitioned pair", "q' = f(p), p' = g(q)"),
];

pub fn run(args: &Args) -> Result<(), Failure> {
    let items: Vec<_> = methods::all().iter().map(|entry| Item::of(entry.name, &entry.tableau())).collect();
    if args.json { print_json(&items) } else { print(&table(&items)) }
}

fn table(items: &[Item]) -> String {
    let mut out = String::new();
    let width = items.iter().map(|item| item.name.len()).max().unwrap_or(0);
    for (family, what) in FAMILIES {
        let members: Vec<_> = items.iter().filter(|item| item.family == family).collect();
        let Some(first) = members.first() else { continue };
        let later = if first.steppable { "" } else { " (read and proven, not stepped yet)" };
        let _ = writeln!(out, "{family}: {what}{later}");
        let _ = writeln!(out, "  {:width$}  order  embedded  dense  stages  {:26}  title", "name", "for");
        for item in members {
            let embedded = item.embedded.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let dense = item.dense.map_or(String::new(), |order| order.to_string());
            let _ = writeln!(
                out,
                "  {:width$}  {:>5}  {embedded:>8}  {dense:>5}  {:>6}  {:26}  {}",
                item.name,
                item.order,
                item.stages,
                item.purpose(),
                item.title
            );
        }
        out.push('\n');
    }
    let _ = writeln!(out, "{} methods. `kutta show NAME` prints one of them.", items.len());
    out
}
