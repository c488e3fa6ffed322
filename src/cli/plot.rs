//! The work-precision plot of a problem: seconds against error, both in logarithms, a curve for each method.

use super::pen::{Drawn, FONT, GRID, INK, Pen, Picture};
use kutta::compare::Row;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// The picture in units that a scale turns into pixels, and the frame of the axes in it.
const SIZE: (f64, f64) = (960.0, 660.0);
const LEFT: f64 = 86.0;
const RIGHT: f64 = 784.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 598.0;
/// The distance between lines of text.
const LINE: f64 = 17.0;
const COLOURS: [RGBColor; 14] = [
    RGBColor(0x9c, 0x75, 0x5f),
    RGBColor(0x1f, 0x77, 0xb4),
    RGBColor(0x17, 0xa2, 0xb8),
    RGBColor(0x2c, 0x8f, 0x2c),
    RGBColor(0x9a, 0xa8, 0x1e),
    RGBColor(0xf0, 0x8c, 0x1a),
    RGBColor(0xd6, 0x27, 0x28),
    RGBColor(0x8e, 0x5b, 0xc0),
    RGBColor(0x55, 0x55, 0x55),
    RGBColor(0xe0, 0x6f, 0xb0),
    RGBColor(0x0b, 0x3d, 0x91),
    RGBColor(0x7a, 0x00, 0x40),
    RGBColor(0x00, 0x5f, 0x3c),
    RGBColor(0xb8, 0x86, 0x0b),
];

/// The runs of a method that no other of its runs beats in error and time both, from loose to tight, as
/// (log10 error, log10 seconds), and the beaten ones.
struct Curve {
    name: String,
    colour: RGBColor,
    marker: usize,
    best: Vec<(f64, f64)>,
    beaten: Vec<(f64, f64)>,
}

pub struct Plot {
    problem: String,
    curves: Vec<Curve>,
    /// log10 of the largest and the smallest error, of the shortest and the longest time.
    x: (f64, f64),
    y: (f64, f64),
}

impl Picture for Plot {
    fn size(&self) -> (f64, f64) {
        SIZE
    }

    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        self.axes(pen)?;
        for curve in &self.curves {
            curve.draw(pen, |point| self.at(point))?;
        }
        self.labels(pen)
    }
}

impl Plot {
    /// A curve for each of the methods, whose place in the list decides its colour.
    pub fn of(problem: &str, methods: &[&str], rows: &[Row]) -> Self {
        let mut curves = vec![];
        for (i, &name) in methods.iter().enumerate() {
            let runs = rows.iter().filter(|row| row.problem == problem && row.method == name);
            let mut points: Vec<(f64, f64)> = runs
                .filter_map(|row| Some((row.error?.max(1e-17).log10(), row.seconds_min?.log10())))
                .filter(|(error, _)| *error < 0.5)
                .collect();
            points.sort_by(|a, b| a.1.total_cmp(&b.1));
            let (mut best, mut beaten): (Vec<(f64, f64)>, Vec<(f64, f64)>) = (vec![], vec![]);
            for point in points {
                let gains = best.last().is_none_or(|last| point.0 < last.0);
                if gains { best.push(point) } else { beaten.push(point) }
            }
            if !best.is_empty() {
                let (colour, marker) = (COLOURS[i % COLOURS.len()], i);
                curves.push(Curve { name: name.to_string(), colour, marker, best, beaten });
            }
        }
        let mut plot = Self { problem: problem.to_string(), curves, x: (0.0, -12.0), y: (-6.0, -3.0) };
        let all = || plot.curves.iter().flat_map(|curve| curve.best.iter().copied());
        if all().next().is_some() {
            let range = |of: fn((f64, f64)) -> f64| {
                let values = all().map(of);
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
            };
            let (x, y) = (range(|p| p.0), range(|p| p.1));
            (plot.x, plot.y) = ((x.1 + 0.3, x.0 - 0.3), (y.0 - 0.15, y.1 + 0.15));
        }
        plot
    }

    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let part = |(from, to): (f64, f64), x: f64| (x - from) / (to - from);
        (LEFT + part(self.x, x) * (RIGHT - LEFT), BOTTOM - part(self.y, y) * (BOTTOM - TOP))
    }

    fn axes<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let step = if self.x.0 - self.x.1 > 9.0 { 2 } else { 1 };
        for k in self.x.1.ceil() as i32..=self.x.0.floor() as i32 {
            let (x, _) = self.at((f64::from(k), 0.0));
            pen.line(&[(x, TOP), (x, BOTTOM)], GRID, 1.0)?;
            if k % step == 0 {
                pen.text(&format!("1e{k}"), (x, BOTTOM + 8.0), FONT, INK, (HPos::Center, VPos::Top))?;
            }
        }
        let digits: &[i32] = if self.y.1 - self.y.0 > 2.0 { &[1] } else { &[1, 2, 5] };
        for k in self.y.0.floor() as i32..=self.y.1.floor() as i32 {
            for &digit in digits {
                let (_, y) = self.at((0.0, f64::from(k) + f64::from(digit).log10()));
                if (TOP..=BOTTOM).contains(&y) {
                    pen.line(&[(LEFT, y), (RIGHT, y)], GRID, 1.0)?;
                    pen.text(&duration(digit, k), (LEFT - 8.0, y), FONT, INK, (HPos::Right, VPos::Center))?;
                }
            }
        }
        pen.line(&[(LEFT, TOP), (LEFT, BOTTOM), (RIGHT, BOTTOM), (RIGHT, TOP), (LEFT, TOP)], INK, 1.0)?;
        let (middle, below) = (0.5 * (LEFT + RIGHT), (HPos::Center, VPos::Top));
        let title = format!("{}: time against error", self.problem);
        pen.text(&title, (middle, 14.0), 19.0, INK, below)?;
        pen.text("error at the end (smaller to the right)", (middle, BOTTOM + 34.0), 15.0, INK, below)?;
        pen.upright("time of a run (shorter below)", (16.0, 0.5 * (TOP + BOTTOM)), 15.0, INK)
    }

    /// The names, each right behind the end of its curve where nothing is in the way, the others in a column
    /// beside the frame, joined to their ends and moved up or down so that none covers another.
    fn labels<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let mut taken = self.taken();
        let (mut inside, mut outside) = (vec![], vec![]);
        for curve in &self.curves {
            let Some(&end) = curve.best.last() else { continue };
            let name = Name { curve, end: self.at(end) };
            let fits = name.right() < RIGHT && name.end.1 - LINE > TOP;
            if fits && !taken.iter().any(|&point| name.covers(point)) {
                taken.extend(between((name.end.0 + GAP, name.end.1), (name.right(), name.end.1)));
                inside.push(name);
            } else {
                outside.push(name);
            }
        }
        // A name that a line to the column would cross joins the column, whose lines then lie otherwise.
        let lines = loop {
            outside.sort_by(|a, b| a.end.1.total_cmp(&b.end.1));
            let wanted: Vec<f64> = outside.iter().map(|name| name.end.1).collect();
            let places = apart(&wanted, LINE, (TOP, BOTTOM));
            let lines: Vec<_> =
                outside.iter().zip(&places).map(|(name, &y)| (name.end, (RIGHT + 4.0, y))).collect();
            let crossed = |name: &Name| lines.iter().any(|&(a, b)| between(a, b).any(|p| name.covers(p)));
            match inside.iter().position(crossed) {
                Some(i) => outside.push(inside.swap_remove(i)),
                None => break lines,
            }
        };
        for name in inside {
            let at = (name.end.0 + GAP, name.end.1);
            pen.text(&name.curve.name, at, FONT, name.curve.colour, (HPos::Left, VPos::Center))?;
        }
        for (Name { curve, .. }, (end, beside)) in outside.iter().zip(lines) {
            let (start, y) = ((end.0 + 6.0, end.1), beside.1);
            pen.line(&[start, beside, (RIGHT + 16.0, y)], curve.colour.mix(0.5), 1.0)?;
            pen.text(&curve.name, (RIGHT + 20.0, y), FONT, curve.colour, (HPos::Left, VPos::Center))?;
        }
        Ok(())
    }

    /// Points so dense on all curves that no text fits between two neighbours.
    fn taken(&self) -> Vec<(f64, f64)> {
        let mut taken = vec![];
        for curve in &self.curves {
            taken.extend(curve.best.iter().chain(&curve.beaten).map(|&point| self.at(point)));
            for ends in curve.best.windows(2) {
                taken.extend(between(self.at(ends[0]), self.at(ends[1])));
            }
        }
        taken
    }
}

/// The name of a curve, at the end of it.
struct Name<'c> {
    curve: &'c Curve,
    end: (f64, f64),
}

/// From the end of a curve to its name.
const GAP: f64 = 8.0;

impl Name<'_> {
    fn right(&self) -> f64 {
        self.end.0 + GAP + 0.64 * FONT * self.curve.name.len() as f64
    }

    fn covers(&self, (x, y): (f64, f64)) -> bool {
        (self.end.0 + GAP - 2.0..self.right()).contains(&x) && (y - self.end.1).abs() < 0.7 * LINE
    }
}

/// Points on the line between two, a unit apart.
fn between((x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let n = (x1 - x0).hypot(y1 - y0).ceil();
    (1..n as u32).map(move |i| f64::from(i) / n).map(move |s| (x0 + s * (x1 - x0), y0 + s * (y1 - y0)))
}

/// Places for lines of text as near as can be to the wanted ones, which ascend: a distance apart, inside the
/// limits.
fn apart(wanted: &[f64], distance: f64, (low, high): (f64, f64)) -> Vec<f64> {
    // Less i distances, the places must not descend: where wants do, their mean serves all (isotonic
    // regression), and they become a stack of lines that touch.
    let mut stacks: Vec<(f64, usize)> = vec![];
    for (i, y) in wanted.iter().enumerate() {
        let mut stack = (y - distance * i as f64, 1);
        while let Some(&(mean, n)) = stacks.last()
            && mean > stack.0
        {
            stacks.pop();
            let sum = mean * n as f64 + stack.0 * stack.1 as f64;
            stack = (sum / (n + stack.1) as f64, n + stack.1);
        }
        stacks.push(stack);
    }
    let last = low.max(high - distance * wanted.len().saturating_sub(1) as f64);
    let places = stacks.into_iter().flat_map(|(mean, n)| vec![mean.clamp(low, last); n]);
    places.enumerate().map(|(i, place)| place + distance * i as f64).collect()
}

/// digit * 10^k seconds.
fn duration(digit: i32, k: i32) -> String {
    let unit = ["ns", "us", "ms", "s"];
    let thousands = (k + 9).div_euclid(3).clamp(0, 3);
    let power = k + 9 - 3 * thousands;
    match power {
        0..=2 => format!("{} {}", digit * 10i32.pow(power as u32), unit[thousands as usize]),
        _ => format!("{digit}e{k} s"),
    }
}

impl Curve {
    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>, at: impl Fn((f64, f64)) -> (f64, f64)) -> Drawn {
        let best: Vec<(f64, f64)> = self.best.iter().map(|&point| at(point)).collect();
        pen.line(&best, self.colour.to_rgba(), 2.0)?;
        for &point in &best {
            pen.marker(self.marker, point, 4.0, self.colour.to_rgba())?;
        }
        for &point in &self.beaten {
            pen.marker(self.marker, at(point), 2.5, self.colour.mix(0.4))?;
        }
        Ok(())
    }
}
