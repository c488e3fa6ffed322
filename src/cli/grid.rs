//! The grids of a method file: printed as books do, or as JSON.

use kutta::tableau::{DoubleDouble, entries, value};
use serde_json::{Value, json};

/// A grid, its entries as they stand in the file.
pub struct Grid<'t> {
    pub key: &'static str,
    heading: &'static str,
    /// Each row has something, if only nothing, before a bar.
    barred: bool,
    above: Vec<Row<'t>>,
    /// Below the rule.
    below: Vec<Row<'t>>,
}

struct Row<'t> {
    label: &'t str,
    entries: Vec<&'t str>,
}

/// The keys of all grids, what stands over them, and whether their rows have a bar.
const KEYS: [(&str, &str, bool); 18] = [
    ("tableau", "", true),
    ("dense_stages", "further stages of the dense output", true),
    ("explicit", "explicit table, for f", true),
    ("implicit", "implicit table, for g", true),
    ("position", "positions", true),
    ("velocity", "velocities", true),
    ("alpha", "alpha over b", true),
    ("a", "in transformed variables: a over m", true),
    ("c", "c", true),
    ("gamma", "gamma", true),
    ("multistep", "sum alpha y = h sum beta f, the oldest step first", true),
    ("nordsieck", "members by order: sum alpha y = h sum beta f, the oldest step first", true),
    ("stormer", "sum alpha y = h^2 sum beta f, the oldest step first", true),
    ("predictor", "predictor", true),
    ("corrector", "corrector", true),
    ("nystrom", "", true),
    ("splitting", "", false),
    ("dense", "dense output: weights of theta, theta^2, .. of each stage", false),
];

pub fn grids(text: &str) -> Vec<Grid<'_>> {
    let grid = |&(key, heading, barred)| grid(text, key, heading, barred);
    let mut grids: Vec<_> = KEYS.iter().filter_map(grid).collect();
    let transformed = grids.iter().any(|grid| grid.key == "a");
    for grid in grids.iter_mut().filter(|grid| transformed && grid.key == "dense") {
        grid.heading = "dense output: the rows H";
    }
    grids
}

fn grid<'t>(text: &'t str, key: &'static str, heading: &'static str, barred: bool) -> Option<Grid<'t>> {
    let labelled = barred || key == "splitting";
    let row = |mut row: Vec<&'t str>| {
        let label = if labelled && !row.is_empty() { row.remove(0) } else { "" };
        Row { label, entries: row }
    };
    let mut rows = entries(text, key)?;
    let rule = rows.iter().position(Vec::is_empty).unwrap_or(rows.len());
    let below = rows.split_off(rule).into_iter().skip(1).map(row).collect();
    Some(Grid { key, heading, barred, above: rows.into_iter().map(row).collect(), below })
}

/// Longest line of a printed grid, if shorter entries can make it so.
const WIDEST: usize = 160;

impl Grid<'_> {
    /// Entries longer than 24 characters are cut to 20 digits, in a wide grid to fewer.
    pub fn print(&self) -> String {
        let widths = |text: &str| text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        let tries = [20, 12, 7].map(|digits| (digits, self.lay_out(digits)));
        let fit = tries.iter().position(|(_, text)| widths(text) <= WIDEST).unwrap_or(2);
        let heading = if self.heading.is_empty() { String::new() } else { format!("{}\n", self.heading) };
        heading + &tries[fit].1
    }

    fn lay_out(&self, digits: usize) -> String {
        let rows = || self.above.iter().chain(&self.below);
        let cut = |entry: &&str| match value(entry) {
            Some(x) if entry.chars().count() > digits + 4 && x.hi().is_normal() => decimal(x, digits) + "…",
            _ => (*entry).to_string(),
        };
        let mut cells: Vec<Vec<String>> =
            rows().map(|row| [row.label].iter().chain(&row.entries).map(cut).collect()).collect();
        let columns = cells.iter().map(Vec::len).max().unwrap_or(0);
        let mut widths = vec![0; columns];
        for (j, width) in widths.iter_mut().enumerate() {
            // Signs stand in a column of their own.
            let signed = cells.iter().any(|row| row.get(j).is_some_and(|cell| cell.starts_with('-')));
            for cell in cells.iter_mut().filter_map(|row| row.get_mut(j)) {
                if signed && !cell.starts_with('-') && !cell.is_empty() {
                    cell.insert(0, ' ');
                }
                *width = cell.chars().count().max(*width);
            }
        }
        let bar = if self.barred { " │ " } else { "  " };
        let line = |row: &Vec<String>| {
            let mut line = format!("{:1$}{bar}", row[0], widths[0]);
            row[1..].iter().zip(&widths[1..]).for_each(|(cell, width)| line += &format!("{cell:width$}  "));
            line.trim_end().to_string() + "\n"
        };
        let mut out: String = cells[..self.above.len()].iter().map(line).collect();
        if !self.below.is_empty() {
            let right: usize = widths[1..].iter().map(|width| width + 2).sum();
            out += &format!("{}─┼─{}\n", "─".repeat(widths[0]), "─".repeat(right.saturating_sub(2)));
        }
        out + &cells[self.above.len()..].iter().map(line).collect::<String>()
    }

    /// c, a, b, bhat; short rows are filled with zeros to n columns.
    pub fn array(&self, n: usize) -> Value {
        let below: Vec<_> = self.below.iter().map(|row| list(&row.entries, n)).collect();
        let c: Vec<_> = self.above.iter().map(|row| entry(row.label)).collect();
        json!({ "c": c, "a": self.square(n), "b": below.first(), "bhat": below.get(1..).unwrap_or(&[]) })
    }

    /// The rows above the rule, filled with zeros to n columns.
    pub fn square(&self, n: usize) -> Value {
        self.above.iter().map(|row| list(&row.entries, n)).collect()
    }

    /// Each row under its label.
    pub fn labelled(&self) -> Value {
        self.above.iter().map(|row| (row.label.to_string(), list(&row.entries, 0))).collect()
    }

    /// Rows under labels that come again and again: an object for each round of `n`.
    pub fn rounds(&self, n: usize) -> Value {
        let object = |rows: &[Row]| -> Value {
            rows.iter().map(|row| (row.label.to_string(), list(&row.entries, 0))).collect()
        };
        self.above.chunks(n).map(object).collect()
    }

    /// `drift` and `kick`, in order.
    pub fn words(&self) -> Value {
        let step = |row: &Row| {
            let mut step = entry(row.entries[0]);
            step["step"] = row.label.into();
            step
        };
        self.above.iter().map(step).collect()
    }
}

fn entry(text: &str) -> Value {
    json!({ "text": text, "value": value(text).map(DoubleDouble::hi) })
}

fn list(entries: &[&str], n: usize) -> Value {
    let missing = n.saturating_sub(entries.len());
    entries.iter().copied().chain(std::iter::repeat_n("0", missing)).map(entry).collect()
}

/// The first digits of a number, not rounded: more follow.
fn decimal(x: DoubleDouble, digits: usize) -> String {
    let ten = DoubleDouble::of(10.0);
    let (sign, x) = if x.hi() < 0.0 { ("-", -x) } else { ("", x) };
    let mut exponent = x.hi().log10().floor() as i32;
    let power = ten.powi(exponent.unsigned_abs());
    let mut rest = if exponent < 0 { x * power } else { x / power };
    if rest >= ten {
        (rest, exponent) = (rest / ten, exponent + 1);
    } else if rest < DoubleDouble::ONE {
        (rest, exponent) = (rest * ten, exponent - 1);
    }
    let mut text = String::new();
    for _ in 0..digits {
        // A whole number from below is the one before it.
        let below = rest.hi().fract() == 0.0 && rest.lo() < 0.0;
        let digit = rest.hi().floor() - if below { 1.0 } else { 0.0 };
        text.push(char::from(b'0' + digit as u8));
        rest = (rest - DoubleDouble::of(digit)) * ten;
    }
    match exponent {
        -4..0 => format!("{sign}0.{}{text}", "0".repeat((-exponent - 1) as usize)),
        0..=5 => {
            let (whole, fraction) = text.split_at(exponent as usize + 1);
            format!("{sign}{whole}.{fraction}")
        }
        _ => format!("{sign}{}.{}e{exponent}", &text[..1], &text[1..]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_cut_not_rounded() {
        let cut = |text: &str, digits| decimal(value(text).unwrap(), digits);
        assert_eq!(cut("2/3", 7), "0.6666666");
        assert_eq!(cut("-200/3", 7), "-66.66666");
        assert_eq!(cut("0.00012345678901234567890123456", 20), "0.00012345678901234567890");
        assert_eq!(cut("0.000012345678901", 7), "1.234567e-5");
        assert_eq!(cut("123456789.5", 7), "1.234567e8");
        assert_eq!(cut("9.9999999999999999999999999", 7), "9.999999");
        assert_eq!(cut("1000", 7), "1000.000");
    }

    #[test]
    fn signs_and_bars_are_aligned() {
        let text = "tableau = '''\n0 |\n1/2 | 1/2\n1 | -1 2\n--+---\n| 1/6 2/3 1/6\n'''\n";
        let printed = grids(text)[0].print();
        assert_eq!(printed, "0   │\n1/2 │  1/2\n1   │ -1    2\n────┼───────────────\n    │  1/6  2/3  1/6\n");
    }
}
