//! Time to a given error, read off the rows.

use super::Row;

/// What a method needs for an error.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cost<'r> {
    pub method: &'r str,
    pub seconds: f64,
    pub evaluations: f64,
    /// Matrices factored.
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
        let (method, evaluations) = (row.method.as_str(), row.evaluations as f64);
        let factorizations = row.factorizations as f64;
        if e <= error {
            let Some((e0, seconds0, row0)) = before else {
                return Some(Cost { method, seconds, evaluations, factorizations });
            };
            let part = (e0 / error).ln() / (e0 / e).ln();
            let between = |a: f64, b: f64| a * (b / a).powf(part);
            let evaluations = between(row0.evaluations as f64, evaluations);
            // An explicit method factors nothing.
            let factorizations = match row0.factorizations {
                0 => factorizations,
                before => between(before as f64, factorizations),
            };
            return Some(Cost { method, seconds: between(seconds0, seconds), evaluations, factorizations });
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
