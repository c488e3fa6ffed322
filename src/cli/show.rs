//! `kutta show NAME`: the tableau as books print it, what follows from it, and where it comes from.

use super::grid::{Grid, grids};
use super::list::Item;
use super::words::{json, words};
use super::{Failure, Source, print, print_json, stencils};
use kutta::tableau::{Scheme, Tableau};
use serde::Serialize;
use serde_json::{Map, Value, json};

#[derive(clap::Args)]
pub struct Args {
    /// A method's or stencil's name, or the path of a .toml file
    name: String,
    /// Print a JSON object for scripts
    #[arg(long)]
    json: bool,
}

/// `list`'s items first, then the family's own rows, then what is derived.
#[derive(Serialize)]
struct Shown<'t> {
    #[serde(flatten)]
    item: Item,
    cite: &'t str,
    note: &'t str,
    /// Correct digits of the entries; null where they are exact.
    digits: Option<usize>,
    #[serde(flatten)]
    rows: Map<String, Value>,
    properties: Map<String, Value>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let source = Source::find_any(&args.name)?;
    if source.is_stencil() {
        return stencils::show(&source, args.json);
    }
    let tableau = source.tableau().map_err(|error| Failure::Input(source.message(&error)))?;
    let (grids, properties) = (grids(&source.text), tableau.properties());
    if args.json {
        return print_json(&Shown {
            item: Item::of(&source.name, &tableau),
            cite: tableau.cite,
            note: tableau.note,
            digits: (tableau.digits > 0).then_some(tableau.digits),
            rows: rows(&grids, &tableau),
            properties: json(&properties),
        });
    }
    let mut out = format!("{}: {}\n\n", source.name, tableau.title);
    let mut cut = false;
    for grid in &grids {
        let printed = grid.print();
        cut |= printed.contains('…');
        out += &printed;
        out.push('\n');
    }
    if cut {
        out += "… an entry is cut: `kutta show NAME --json` has it whole\n\n";
    }
    out += &words(&properties);
    out += &format!("\n{}\n", tableau.cite);
    if !tableau.note.is_empty() {
        out += &format!("{}\n", tableau.note);
    }
    print(&out)
}

/// The rows of each family under its own letters.
fn rows(grids: &[Grid], tableau: &Tableau) -> Map<String, Value> {
    let grid = |key: &str| grids.iter().find(|grid| grid.key == key);
    let n = tableau.stages();
    let array = |key: &str| grid(key).map_or(json!({}), |grid| grid.array(n));
    let steps = |key: &str| grid(key).map_or(json!({}), |grid| grid.labelled());
    let mut value = match &tableau.scheme {
        Scheme::RungeKutta(array) => {
            let all = n + array.extra;
            let mut value = grid("tableau").map_or(json!({}), |grid| grid.array(n));
            if let Some(dense) = grid("dense") {
                value["dense_weights"] = dense.square(array.powers);
            }
            if let Some(stages) = grid("dense_stages") {
                let stages = stages.array(all);
                value["dense_stages"] = json!({ "c": stages["c"], "a": stages["a"] });
            }
            value
        }
        Scheme::Imex { .. } => json!({ "explicit": array("explicit"), "implicit": array("implicit") }),
        Scheme::Partitioned { .. } => json!({ "position": array("position"), "velocity": array("velocity") }),
        Scheme::Rosenbrock { .. } if grid("alpha").is_some() => {
            let alpha = array("alpha");
            json!({
                "alpha": alpha["a"],
                "b": alpha["b"],
                "bhat": alpha["bhat"],
                "gamma": grid("gamma").map(|grid| grid.square(n)),
            })
        }
        Scheme::Rosenbrock { .. } => {
            let a = array("a");
            json!({
                "a": a["a"],
                "m": a["b"],
                "mhat": a["bhat"],
                "c": grid("c").map(|grid| grid.square(n)),
                "gamma": grid("gamma").map(|grid| grid.square(1)[0][0].clone()),
                "dense_weights": grid("dense").map(|grid| grid.square(n)),
            })
        }
        Scheme::Multistep(_) => steps("multistep"),
        Scheme::Nordsieck(_) => json!({ "formulas": grid("nordsieck").map(|grid| grid.rounds(2)) }),
        Scheme::Stormer(_) => steps("stormer"),
        Scheme::PredictorCorrector { evaluates, .. } => json!({
            "predictor": steps("predictor"),
            "corrector": steps("corrector"),
            "mode": if *evaluates { "PECE" } else { "PEC" },
        }),
        Scheme::Nystrom { .. } => {
            let mut value = array("nystrom");
            value["y"] = value["b"].take();
            value["v"] = value["bhat"][0].take();
            json!({ "c": value["c"], "a": value["a"], "y": value["y"], "v": value["v"] })
        }
        Scheme::Splitting(_) => json!({ "steps": grid("splitting").map(Grid::words) }),
    };
    let rows = value.as_object_mut().map(std::mem::take).unwrap_or_default();
    rows.into_iter().filter(|(_, value)| !value.is_null()).collect()
}
