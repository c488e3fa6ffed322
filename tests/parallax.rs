//! What limiting the offset of parallax mapping gains and costs, as the documentation tells it.

#[allow(dead_code)]
#[path = "../examples/parallax/measure.rs"]
mod measure;

use measure::{DEPTH, SHIFTS, direction, measure, met, relief};
use nalgebra::Vector2;

/// The reference: the point lies on the relief, on the ray, and nothing of the ray before it is inside.
#[test]
fn the_ray_meets_the_relief_first_there() {
    for (i, elevation) in [5.0, 12.0, 30.0, 60.0, 88.0].into_iter().enumerate() {
        for j in 0..40 {
            let at = Vector2::new(0.37 * j as f64 % 1.0, 0.11 * j as f64 % 1.0);
            let view = direction(77.0 * (i + j) as f64, elevation);
            let found = met(at, view);
            let b = (found - at).dot(&view.xy()) / view.xy().norm_squared() * view.z;
            assert!((b - relief(found)).abs() < 1e-9, "on the relief: {b} for {}", relief(found));
            assert!((at + view.xy() * (b / view.z) - found).norm() < 1e-12, "on the ray");
            for k in 1..200 {
                let higher = b + (DEPTH - b) * f64::from(k) / 200.0;
                let open = higher - relief(at + view.xy() * (higher / view.z));
                assert!(open > -1e-4 * DEPTH, "{elevation}: the ray is inside at {higher}");
            }
        }
    }
}

/// The table of the documentation, to its digits: error and swim in heights of the relief, folds in percent.
#[test]
fn the_table_is_as_documented() {
    let table = include_str!("../src/normals/parallax.rs");
    let mut rows = 0;
    for line in table.lines().filter_map(|line| line.strip_prefix("//! | ")?.strip_suffix(" |")) {
        let cells: Vec<_> = line.split(" | ").map(str::trim).collect();
        let Ok(elevation) = cells[0].parse() else { continue };
        rows += 1;
        for (way, cells) in [(1, &cells[1..4]), (2, &cells[4..7])] {
            let found = measure(SHIFTS[way].1, elevation);
            let found = [found.error, found.swim, 100.0 * found.folded];
            for (cell, found) in cells.iter().zip(found) {
                let places = cell.split_once('.').map_or(0, |(_, behind)| behind.len());
                assert_eq!(format!("{found:.places$}"), *cell, "{elevation} degrees: {line}");
            }
        }
    }
    assert_eq!(rows, 5);
}
