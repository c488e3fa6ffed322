//! The border of a region of the plane, as lines: where a grid's neighbours differ, found to the last bit.

use std::collections::BTreeMap;

pub type Point = (f64, f64);

/// A rectangle of the plane, from its lower left corner to its upper right one.
#[derive(Clone, Copy)]
pub struct Window {
    pub from: Point,
    pub to: Point,
}

/// The edge of a cell that starts at a grid point and leads right, or else up.
type Edge = (usize, usize, bool);

/// Lines along the border of what is `inside`, in cells of a grid (marching squares).
pub fn outline(window: Window, cells: (usize, usize), inside: impl Fn(Point) -> bool) -> Vec<Vec<Point>> {
    let part = |from: f64, to: f64, i: usize, n: usize| from + (to - from) * i as f64 / n as f64;
    let at = |i: usize, j: usize| {
        (part(window.from.0, window.to.0, i, cells.0), part(window.from.1, window.to.1, j, cells.1))
    };
    let grid: Vec<Vec<bool>> =
        (0..=cells.0).map(|i| (0..=cells.1).map(|j| inside(at(i, j))).collect()).collect();
    let mut joined: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    let mut join = |a: Edge, b: Edge| {
        joined.entry(a).or_default().push(b);
        joined.entry(b).or_default().push(a);
    };
    for i in 0..cells.0 {
        for j in 0..cells.1 {
            // Round the cell, each edge with the corner before it.
            let corners = [grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1]];
            let edges = [(i, j, true), (i + 1, j, false), (i, j + 1, true), (i, j, false)];
            let crossed: Vec<usize> = (0..4).filter(|&k| corners[k] != corners[(k + 1) % 4]).collect();
            match crossed[..] {
                [a, b] => join(edges[a], edges[b]),
                [..] if crossed.len() == 4 => {
                    let (low, high) = (at(i, j), at(i + 1, j + 1));
                    let middle = inside((0.5 * (low.0 + high.0), 0.5 * (low.1 + high.1)));
                    // The middle belongs with the corners like it: the border goes round the others.
                    let from = if middle == corners[0] { 0 } else { 3 };
                    join(edges[from], edges[(from + 1) % 4]);
                    join(edges[(from + 2) % 4], edges[(from + 3) % 4]);
                }
                _ => {}
            }
        }
    }
    let crossing = |(i, j, right): Edge| {
        let (mut a, mut b) = (at(i, j), if right { at(i + 1, j) } else { at(i, j + 1) });
        let here = grid[i][j];
        for _ in 0..30 {
            let middle = (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
            if inside(middle) == here { a = middle } else { b = middle }
        }
        (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1))
    };
    let mut lines = vec![];
    // Lines that end at the window first, then the closed ones.
    while let Some(start) = joined
        .iter()
        .find(|(_, next)| next.len() == 1)
        .or_else(|| joined.iter().next())
        .map(|(edge, _)| *edge)
    {
        let (mut line, mut edge) = (vec![crossing(start)], start);
        while let Some(next) = joined.get_mut(&edge).and_then(Vec::pop) {
            let back = joined.entry(next).or_default();
            back.retain(|&other| other != edge);
            line.push(crossing(next));
            edge = next;
        }
        joined.retain(|_, next| !next.is_empty());
        lines.push(line);
    }
    lines
}
