//! The table of a problem: which method is the fastest to each error, and what failed.

use super::contest::Contest;
use comfy_table::{CellAlignment, Table, TableComponent, presets};
use kutta::compare::{Cost, Reference, Row, ranking_at};

/// Errors at which the fastest method is named.
const ERRORS: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

pub fn of(contest: &Contest, rows: &[Row], reference: &Reference) -> String {
    let problem = &contest.problem;
    let mut text = format!("{}: {}\n", problem.name, problem.about);
    if let Reference::Run { method, rtol, spread } = reference {
        text += &format!("errors against {method} at rtol {rtol:e}, itself good to about {spread:.0e}\n");
    }
    if !contest.unfit.is_empty() {
        text += &format!("left out, being for y'' = f(t, y) only: {}\n", contest.unfit.join(", "));
    }
    if !contest.not_compiled.is_empty() {
        let which = match contest.not_compiled.len() == contest.methods.len() {
            true => "no method is".to_string(),
            false => format!("not all methods are (not {})", contest.not_compiled.join(", ")),
        };
        text += &format!("{which} compiled with this problem, so all are interpreted: ");
        text += "their times compare with each other only\n";
    }
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY);
    for between_rows in [TableComponent::HorizontalLines, TableComponent::MiddleIntersections] {
        table.remove_style(between_rows);
    }
    table.set_header(["error", "fastest", "time", "evaluations", "Jacobians", "factored", "then"]);
    for error in ERRORS {
        let ranking = ranking_at(rows, problem.name, error);
        let error = format!("{error:e}");
        match ranking.split_first() {
            None => table.add_row([error.as_str(), "none gets there"]),
            Some((best, rest)) => table.add_row([
                error,
                best.method.to_string(),
                time(best.seconds),
                format!("{:.0}", best.evaluations),
                format!("{:.0}", best.jacobians),
                format!("{:.0}", best.factorizations),
                runners_up(best, rest),
            ]),
        };
    }
    for column in [2, 3, 4, 5] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    text += &table.trim_fmt();
    text.push('\n');
    for (reason, runs) in failures(contest, rows) {
        text += &format!("{reason}: {}\n", runs.join(", "));
    }
    text
}

/// The next three, with their times over the best.
fn runners_up(best: &Cost, rest: &[Cost]) -> String {
    let each = |next: &Cost| format!("{} x{:.2}", next.method, next.seconds / best.seconds);
    rest.iter().take(3).map(each).collect::<Vec<_>>().join(", ")
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-5 => format!("{:.2} us", s * 1e6),
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.2} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

/// Reasons of failures, each with the runs that it ended: methods with their tolerances or steps.
fn failures(contest: &Contest, rows: &[Row]) -> Vec<(String, Vec<String>)> {
    let mut reasons: Vec<(String, Vec<String>)> = vec![];
    for method in &contest.methods {
        let runs: Vec<&Row> = rows.iter().filter(|row| row.method == method.name).collect();
        let what = if method.adaptive { "rtol" } else { "h" };
        for stretch in runs.chunk_by(|a, b| a.failure.is_some() == b.failure.is_some()) {
            let Some(why) = &stretch[0].failure else { continue };
            // Where an unstable run ended tells nothing; the rows have it.
            let reason = why.split(": stopped").next().unwrap_or(why).to_string();
            let (first, last) = (stretch[0].tolerance, stretch[stretch.len() - 1].tolerance);
            let runs = match stretch.len() {
                1 => format!("{} ({what} {first:.1e})", method.name),
                _ => format!("{} ({what} {first:.1e} to {last:.1e})", method.name),
            };
            match reasons.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, all)) => all.push(runs),
                None => reasons.push((reason, vec![runs])),
            }
        }
    }
    reasons
}
