//! The region of y' = lambda y in the plane of h lambda.

use super::outline::{Point, Window, outline};
use crate::cli::pen::{Drawn, FONT, GRID, INK, Pen, Picture};
use crate::cli::words::short;
use kutta::Controller;
use kutta::tableau::{Properties, Stability};
use num_complex::Complex;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// The picture in units, and the frame of the axes in it.
const SIZE: (f64, f64) = (860.0, 720.0);
const LEFT: f64 = 64.0;
const RIGHT: f64 = 836.0;
const TOP: f64 = 74.0;
const BOTTOM: f64 = 664.0;
/// Cells of the grid that the border is sought on, across and up to the top.
const CELLS: (usize, usize) = (256, 112);
/// Where a border that goes on for ever is cut.
const FAR: f64 = 10.0;
const SHADE: RGBColor = RGBColor(0xcf, 0xe2, 0xf1);
const BORDER: RGBColor = RGBColor(0x1f, 0x77, 0xb4);
const SETTLES: RGBColor = RGBColor(0x2c, 0x8f, 0x2c);
const SWINGS: RGBColor = RGBColor(0xd6, 0x27, 0x28);

/// A piece of the border, and the spectral radius of step and controller along it.
struct Border {
    line: Vec<Point>,
    control: Vec<Option<f64>>,
}

pub struct Region {
    name: String,
    about: String,
    window: Window,
    /// In the upper half of the plane.
    borders: Vec<Border>,
    /// Whether the left end of each row of the upper half is stable; rows are a unit high.
    left: Vec<bool>,
    real: f64,
    imaginary: f64,
    /// The angle of A(alpha)-stability, where it is between 0 and 90 degrees.
    alpha: Option<f64>,
}

impl Region {
    pub fn of(name: &str, stability: &Stability, properties: &Properties) -> Self {
        let stable = |(x, y): Point| stability.stable(Complex::new(x, y));
        let window = window(stable);
        let half = Window { from: (window.from.0, 0.0), to: window.to };
        let control = |&(x, y): &Point| stability.step_control(Complex::new(x, y), &Controller::default());
        let borders = outline(half, CELLS, stable)
            .into_iter()
            .map(|line| Border { control: line.iter().map(control).collect(), line })
            .collect();
        let rows = (0.5 * (BOTTOM - TOP)) as usize;
        let height = |row: usize| window.to.1 * (row as f64 + 0.5) / rows as f64;
        Self {
            name: name.to_string(),
            about: about(properties),
            window,
            borders,
            left: (0..rows).map(|row| stable((window.from.0, height(row)))).collect(),
            real: stability.limit(0.0),
            imaginary: stability.limit(90.0),
            alpha: properties.alpha.filter(|alpha| *alpha > 0.0 && *alpha < 90.0),
        }
    }

    /// What the controller does along the border of the left half-plane, in a line; nothing of a method whose
    /// steps it does not choose, or that the border does not hold up.
    pub fn control(&self) -> String {
        let radii = self.borders.iter().flat_map(|b| b.line.iter().zip(&b.control));
        let left: Vec<f64> = radii.filter(|(z, _)| z.0 <= 0.0).filter_map(|(_, radius)| *radius).collect();
        if left.is_empty() {
            return String::new();
        }
        let largest = left.iter().copied().fold(0.0, f64::max);
        let part = left.iter().filter(|&&radius| radius < 1.0).count() as f64 / left.len() as f64;
        format!(
            "{:<16}with the default controller the step settles on {:.0} % of the border left of 0; spectral radius up to {}\n",
            "step control",
            100.0 * part,
            short(largest)
        )
    }

    fn at(&self, (x, y): Point) -> Point {
        let Window { from, to } = self.window;
        let part = |from: f64, to: f64, x: f64| (x - from) / (to - from);
        let down = part(from.1, to.1, y) * (BOTTOM - TOP);
        (LEFT + part(from.0, to.0, x) * (RIGHT - LEFT), BOTTOM - down)
    }

    fn shade<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let rows = self.left.len();
        for (row, &left) in self.left.iter().enumerate() {
            let y = self.window.to.1 * (row as f64 + 0.5) / rows as f64;
            let mut ends = vec![];
            for ends_of in self.borders.iter().flat_map(|border| border.line.windows(2)) {
                let (a, b) = (ends_of[0], ends_of[1]);
                if (a.1 > y) != (b.1 > y) {
                    ends.push(a.0 + (b.0 - a.0) * (y - a.1) / (b.1 - a.1));
                }
            }
            ends.sort_by(f64::total_cmp);
            let first = left.then_some(self.window.from.0);
            let mut ends = first.into_iter().chain(ends);
            while let Some(from) = ends.next() {
                let to = ends.next().unwrap_or(self.window.to.0);
                for side in [1.0, -1.0] {
                    let ((x0, y0), (x1, _)) = (self.at((from, side * y)), self.at((to, side * y)));
                    // Rows overlap, so that no white shines between them.
                    pen.block((x0, y0 - 0.75), (x1, y0 + 0.75), SHADE)?;
                }
            }
        }
        Ok(())
    }

    fn axes<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let Window { from, to } = self.window;
        let step = nice((to.0 - from.0) / 9.0);
        let ticks = |from: f64, to: f64| {
            let ends = ((from / step).ceil() as i64, (to / step).floor() as i64);
            (ends.0..=ends.1).map(move |k| k as f64 * step)
        };
        for x in ticks(from.0, to.0) {
            let (px, _) = self.at((x, 0.0));
            pen.line(&[(px, TOP), (px, BOTTOM)], if x == 0.0 { INK } else { GRID }, 1.0)?;
            pen.text(&short(x), (px, BOTTOM + 8.0), FONT, INK, (HPos::Center, VPos::Top))?;
        }
        for y in ticks(from.1, to.1) {
            let (_, py) = self.at((0.0, y));
            pen.line(&[(LEFT, py), (RIGHT, py)], if y == 0.0 { INK } else { GRID }, 1.0)?;
            pen.text(&short(y), (LEFT - 8.0, py), FONT, INK, (HPos::Right, VPos::Center))?;
        }
        Ok(())
    }

    /// Each piece of the border, and its image below the real axis.
    fn border<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        for Border { line, control } in &self.borders {
            let colour = |i: usize| match control[i] {
                None => BORDER,
                Some(radius) if radius < 1.0 => SETTLES,
                Some(_) => SWINGS,
            };
            let mut start = 0;
            for end in 1..line.len() {
                if end + 1 == line.len() || colour(end) != colour(start) {
                    for side in [1.0, -1.0] {
                        let piece: Vec<Point> =
                            line[start..=end].iter().map(|&(x, y)| self.at((x, side * y))).collect();
                        pen.line(&piece, colour(start), 2.5)?;
                    }
                    start = end;
                }
            }
        }
        Ok(())
    }

    fn limits<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let inside = |(x, y): Point| (LEFT..=RIGHT).contains(&x) && (TOP..=BOTTOM).contains(&y);
        if let Some(alpha) = self.alpha {
            let (sin, cos) = alpha.to_radians().sin_cos();
            let far = (self.window.to.1 / sin).min(-self.window.from.0 / cos);
            for side in [1.0, -1.0] {
                pen.line(&[self.at((0.0, 0.0)), self.at((-far * cos, side * far * sin))], INK, 1.5)?;
            }
            let label = format!("alpha = {alpha:.2} degrees");
            let (x, y) = self.at((-0.6 * far * cos, 0.6 * far * sin));
            pen.text(&label, (x - 10.0, y), FONT, INK, (HPos::Right, VPos::Center))?;
        }
        if self.real > 0.0 && self.real.is_finite() {
            let at = self.at((-self.real, 0.0));
            pen.line(&[at, self.at((0.0, 0.0))], INK, 2.5)?;
            pen.marker(0, at, 5.0, INK.to_rgba())?;
            let label = format!("-{}", short(self.real));
            pen.text(&label, (at.0 - 8.0, at.1 - 6.0), FONT + 1.0, INK, (HPos::Right, VPos::Bottom))?;
        }
        if self.imaginary > 0.0 && self.imaginary.is_finite() {
            for side in [1.0, -1.0] {
                let at = self.at((0.0, side * self.imaginary));
                pen.line(&[at, self.at((0.0, 0.0))], INK, 2.5)?;
                pen.marker(0, at, 5.0, INK.to_rgba())?;
            }
            let at = self.at((0.0, self.imaginary));
            if inside(at) {
                let label = format!("{} i", short(self.imaginary));
                pen.text(&label, (at.0 + 10.0, at.1 - 4.0), FONT + 1.0, INK, (HPos::Left, VPos::Bottom))?;
            }
        }
        Ok(())
    }

    fn legend<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        if self.borders.iter().all(|border| border.control.iter().all(Option::is_none)) {
            return Ok(());
        }
        let entries = [(SETTLES, "the step settles here"), (SWINGS, "the step swings and is rejected")];
        for (i, (colour, text)) in entries.into_iter().enumerate() {
            let y = TOP + 18.0 + 20.0 * i as f64;
            pen.block((LEFT + 8.0, y - 10.0), (LEFT + 272.0, y + 10.0), WHITE.mix(0.8))?;
            pen.line(&[(LEFT + 14.0, y), (LEFT + 38.0, y)], colour, 2.5)?;
            pen.text(text, (LEFT + 46.0, y), FONT, INK, (HPos::Left, VPos::Center))?;
        }
        Ok(())
    }
}

impl Picture for Region {
    fn size(&self) -> (f64, f64) {
        SIZE
    }

    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        self.shade(pen)?;
        self.axes(pen)?;
        self.border(pen)?;
        self.limits(pen)?;
        self.legend(pen)?;
        pen.line(&[(LEFT, TOP), (LEFT, BOTTOM), (RIGHT, BOTTOM), (RIGHT, TOP), (LEFT, TOP)], INK, 1.0)?;
        let (middle, below) = (0.5 * (LEFT + RIGHT), (HPos::Center, VPos::Top));
        pen.text(&format!("{}: stability region", self.name), (middle, 14.0), 19.0, INK, below)?;
        pen.text(&self.about, (middle, 44.0), 15.0, INK, below)?;
        pen.text("Re h lambda", (middle, BOTTOM + 32.0), 15.0, INK, below)?;
        pen.upright("Im h lambda", (6.0, 0.5 * (TOP + BOTTOM)), 15.0, INK)
    }
}

fn about(p: &Properties) -> String {
    let table = if p.family == "IMEX pair" { ", explicit table" } else { "" };
    let text = match (p.l_stable, p.a_stable, p.alpha) {
        _ if !table.is_empty() => String::new(),
        (Some(true), ..) => ", A-stable and L-stable".to_string(),
        (_, Some(true), _) => ", A-stable".to_string(),
        (.., Some(alpha)) if alpha > 0.0 => format!(", A({alpha:.1} degrees)-stable"),
        _ => String::new(),
    };
    format!("{} of order {}{table}{text}", p.family, p.order)
}

/// A window of the frame's shape that shows the border, and the origin.
fn window(stable: impl Fn(Point) -> bool) -> Window {
    const RINGS: usize = 120;
    let radius = |ring: usize| 0.01 * 1.08f64.powi(ring as i32);
    let (mut low, mut high, mut top) = (0.0f64, 0.0f64, 0.0f64);
    for k in 0..=60 {
        let (sin, cos) = (std::f64::consts::PI * f64::from(k) / 60.0).sin_cos();
        let mut before = stable((radius(0) * cos, radius(0) * sin));
        for ring in 1..RINGS {
            let r = radius(ring);
            let here = stable((r * cos, r * sin));
            if here != before && r < FAR * 6.0 {
                (low, high, top) = (low.min(r * cos), high.max(r * cos), top.max(r * sin));
            }
            before = here;
        }
    }
    // A border along an axis goes on for ever: it is shown near 0.
    if top < 1e-3 && high - low < 1e-3 {
        (low, high, top) = (-0.5 * FAR, 0.5 * FAR, 0.5 * FAR);
    }
    let size = high - low;
    let (low, high, top) =
        (low - 0.15 * size.max(top), high + 0.15 * size.max(top), 1.15 * top.max(0.1 * size));
    let shape = (RIGHT - LEFT) / (BOTTOM - TOP);
    let half = top.max(0.5 * (high - low) / shape);
    let (middle, wide) = (0.5 * (low + high), half * shape);
    Window { from: (middle - wide, -half), to: (middle + wide, half) }
}

/// 1, 2 or 5 times a power of ten, not below x.
pub fn nice(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|digit| digit * power).find(|step| *step >= x).unwrap_or(x)
}
