//! The sweep: every method at every setting, first for its error, then all by turns for their times.

use super::entrant::Entrant;
use super::truth::{Truth, distance};
use super::{Plan, Row};

/// A sample is a batch of runs that takes at least this, far above what reading the clock costs.
const SAMPLE: f64 = 100e-6;
/// Samples of each cell: at least, whatever it costs, and at most.
const SAMPLES: (u32, u32) = (3, 25);
/// Powers of two: the numbers of steps in the first and the last run of a search for the best step.
const COUNTS: (u32, u32) = (4, 26);
/// An error below this may be one of rounding; above, a method that stops gaining is only unlucky.
const ROUNDING: f64 = 1e-8;

struct Cell<'e> {
    entrant: &'e dyn Entrant,
    row: Row,
    /// The time of the trial's plain run.
    once: f64,
    /// Runs in a sample, and the number of samples.
    runs: u32,
    quota: u32,
    samples: Vec<f64>,
}

pub(super) fn measure<'w>(
    problem: &str,
    entrants: &[Box<dyn Entrant + 'w>],
    plan: &Plan,
    truth: &Truth,
    progress: &mut dyn FnMut(f64),
) -> Vec<Row> {
    let mut cells = vec![];
    for (i, entrant) in entrants.iter().enumerate() {
        progress(0.5 * i as f64 / entrants.len() as f64);
        sweep(problem, &**entrant, plan, truth, &mut cells);
    }
    let share = plan.budget.as_secs_f64() / cells.len() as f64;
    let mut rounds = 0;
    for cell in cells.iter_mut().filter(|cell| cell.row.failure.is_none()) {
        cell.runs = (SAMPLE / cell.once).ceil().clamp(1.0, 1e6) as u32;
        let affordable = share / (cell.once * f64::from(cell.runs));
        cell.quota = (affordable as u32).clamp(SAMPLES.0, SAMPLES.1);
        rounds = rounds.max(cell.quota);
    }
    for round in 0..rounds {
        progress(0.5 + 0.5 * f64::from(round) / f64::from(rounds));
        for cell in &mut cells {
            // The turns of a cell with few are spread over all rounds, so that drift hits all alike.
            let turns = |round: u32| round * cell.quota / rounds;
            if turns(round + 1) > turns(round) {
                let seconds = cell.entrant.seconds(cell.row.tolerance, plan.scale, cell.runs);
                cell.samples.push(seconds / f64::from(cell.runs));
            }
        }
    }
    progress(1.0);
    cells.into_iter().map(Cell::finish).collect()
}

impl Cell<'_> {
    fn finish(mut self) -> Row {
        self.samples.sort_by(f64::total_cmp);
        if self.row.failure.is_none() {
            let n = self.samples.len();
            self.row.seconds_min = self.samples.first().copied();
            self.row.seconds_median = Some(0.5 * (self.samples[n / 2] + self.samples[(n - 1) / 2]));
        }
        self.row
    }
}

/// All settings of one method, from loose to tight.
fn sweep<'e>(problem: &str, entrant: &'e dyn Entrant, plan: &Plan, truth: &Truth, cells: &mut Vec<Cell<'e>>) {
    let search = !entrant.adaptive() && plan.steps.is_empty();
    let mut settings: Vec<f64> = match entrant.adaptive() {
        _ if search => (COUNTS.0..=COUNTS.1).map(|k| entrant.span().abs() / f64::from(1 << k)).collect(),
        true => plan.tolerances.clone(),
        false => plan.steps.clone(),
    };
    settings.sort_by(|a, b| b.total_cmp(a));
    let (mut slow, mut best, mut without_gain) = (None, f64::INFINITY, 0);
    for setting in settings {
        let mut row = Row {
            problem: problem.to_string(),
            method: entrant.name().to_string(),
            tolerance: setting,
            error: None,
            max_error: None,
            seconds_min: None,
            seconds_median: None,
            evaluations: 0,
            jacobians: 0,
            factorizations: 0,
            accepted: 0,
            rejected: 0,
            failure: None,
        };
        let mut once = 0.0;
        if let Some(looser) = slow {
            row.failure = Some(format!("not run: took too long at {looser:.1e} already"));
        } else {
            let trial = entrant.attempt(setting, plan.scale, &truth.times, plan.longest);
            row.evaluations = trial.stats.evaluations;
            row.jacobians = trial.stats.jacobians;
            row.factorizations = trial.stats.factorizations;
            row.accepted = trial.stats.accepted;
            row.rejected = trial.stats.rejected.total();
            match trial.states {
                Err(failure) => row.failure = Some(failure),
                Ok((end, along)) => {
                    let error = distance(&end, &truth.end, plan.scale);
                    let pairs = along.iter().zip(&truth.along);
                    let far = pairs.map(|(y, r)| distance(y, r, plan.scale));
                    row.max_error = far.reduce(f64::max).map(|far| far.max(error));
                    row.error = Some(error);
                    once = trial.seconds;
                    without_gain = if error < best { 0 } else { without_gain + 1 };
                    best = best.min(error);
                }
            }
            if trial.slow {
                slow = Some(setting);
            }
        }
        cells.push(Cell { entrant, row, once, runs: 1, quota: 0, samples: vec![] });
        if search && (slow.is_some() || without_gain > 1 && best < ROUNDING) {
            break;
        }
    }
}
