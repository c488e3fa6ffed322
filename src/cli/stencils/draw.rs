//! A stencil as a picture: its weights where they stand.

use super::super::words::short;
use kutta::normals::{Stencil, Taps};

/// Largest common denominator that is looked for.
const DENOMINATOR: u32 = 20_000;

/// The two-dimensional array of weights, rows from top to bottom, of the slope to the right. Whole numbers over
/// a common denominator where there is a small one. A compact stencil has its left side above.
pub fn draw(stencil: &Stencil) -> String {
    let mut out = String::new();
    let mut picture = |heading: &str, along: &Taps, across: &Taps| {
        let row = |(_, across)| along.iter().map(|(_, along)| (along * across).hi()).collect();
        // Rows go down, t goes up.
        let rows: Vec<Vec<f64>> = across.iter().rev().map(row).collect();
        out += heading;
        out += &array(&rows, along, across);
    };
    if stencil.left.len > 1 {
        picture("weights of the slopes\n", &stencil.left, &single());
        picture("weights of the heights\n", &stencil.along, &stencil.across);
    } else {
        picture("", &stencil.along, &stencil.across);
    }
    out
}

fn single() -> Taps {
    let mut taps =
        Taps { first: 0, len: 1, weight: [kutta::tableau::DoubleDouble::ZERO; kutta::normals::TAPS] };
    taps.weight[0] = kutta::tableau::DoubleDouble::ONE;
    taps
}

fn array(rows: &[Vec<f64>], along: &Taps, across: &Taps) -> String {
    let whole = |d: &u32| {
        let scaled = rows.iter().flatten().map(|w| w * f64::from(*d));
        scaled.into_iter().all(|w| (w - w.round()).abs() < 1e-9)
    };
    let denominator = (1..=DENOMINATOR).find(whole);
    let cell = |w: &f64| match denominator {
        Some(d) => format!("{}", (w * f64::from(d)).round() as i64),
        None => short(*w),
    };
    let cells: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(cell).collect()).collect();
    let offsets: Vec<_> = along.iter().map(|(i, _)| i.to_string()).collect();
    let width = cells.iter().flatten().chain(&offsets).map(String::len).max().unwrap_or(0);
    let line = |label: String, cells: &[String]| {
        let cells: String = cells.iter().map(|cell| format!("  {cell:>width$}")).collect();
        format!("{label:>4} │{cells}\n")
    };
    let mut out = line(String::new(), &offsets);
    out += &format!("─────┼{}\n", "─".repeat((width + 2) * offsets.len()));
    for ((j, _), row) in across.iter().rev().zip(&cells) {
        out += &line(j.to_string(), row);
    }
    if let Some(d) = denominator.filter(|d| *d > 1) {
        out += &format!("     │  all over {d}\n");
    }
    out
}
