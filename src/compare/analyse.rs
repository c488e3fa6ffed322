//! Time to a given error, read off the rows.

use super::Row;

/// What a method needs for an error.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cost<'r> {
    pub method: &'r str,
    pub seconds: f64,
    pub evaluations: f64,
    /// Jacobians taken, and matrices factored.
    pub jacobians: f64,
    pub factorizations: f64,
}

/// What `method` needs on `problem` for an `error` at the end; `None` where no run got there.
///
/// Of its runs, those count that no other run beats in error and time (`seconds_min`) both. Between the two
/// of them whose errors bracket the one asked for, time and evaluations are interpolated in logarithms. Where
/// the fastest run is better already, its time counts.
pub fn cost_at<'r>(rows: &'r [Row], problem: &str, method: &str, error: f64) -> Option<Cost<'r>> {
    let mut runs: Vec<(f64, f64, &Row)> = rows
        .iter()
        .filter(|row| row.problem == problem && row.method == method)
        .filter_map(|row| Some((row.error?.max(f64::MIN_POSITIVE), row.seconds_min?, row)))
        .filter(|(error, ..)| error.is_finite())
        .collect();
    runs.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut before: Option<(f64, f64, &Row)> = None;
    for (e, seconds, row) in runs {
        if before.is_some_and(|(least, ..)| e >= least) {
            continue;
        }
        if e <= error {
            // Of a run, and of the one before, which is it itself where there is none.
            let (e0, seconds0, row0) = before.unwrap_or((e, seconds, row));
            let part = if before.is_some() { (e0 / error).ln() / (e0 / e).ln() } else { 1.0 };
            let between = |a: f64, b: f64| a * (b / a).powf(part);
            let count = |of: fn(&Row) -> u64| match of(row0) {
                // An explicit method factors nothing, and one that is chosen may begin to.
                0 => of(row) as f64,
                before => between(before as f64, of(row) as f64),
            };
            return Some(Cost {
                method: row.method.as_str(),
                seconds: between(seconds0, seconds),
                evaluations: count(|row| row.evaluations),
                jacobians: count(|row| row.jacobians),
                factorizations: count(|row| row.factorizations),
            });
        }
        before = Some((e, seconds, row));
    }
    None
}

/// What each method needs on `problem` for an `error` at the end, the fastest first; those that never get
/// there are left out.
pub fn ranking_at<'r>(rows: &'r [Row], problem: &str, error: f64) -> Vec<Cost<'r>> {
    let mut methods: Vec<&str> = vec![];
    for row in rows.iter().filter(|row| row.problem == problem) {
        if !methods.contains(&row.method.as_str()) {
            methods.push(&row.method);
        }
    }
    let mut costs: Vec<_> =
        methods.into_iter().filter_map(|method| cost_at(rows, problem, method, error)).collect();
    costs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    costs
}

/// The method that takes least time on `problem` to an `error` at the end.
pub fn fastest_at<'r>(rows: &'r [Row], problem: &str, error: f64) -> Option<Cost<'r>> {
    ranking_at(rows, problem, error).first().copied()
}
