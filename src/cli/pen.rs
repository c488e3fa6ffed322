//! Pictures drawn in units finer than a pixel, as SVG and as PNG.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, register_font};
use std::path::Path;

/// The size of names and numbers.
pub const FONT: f64 = 14.0;
/// Pixels a unit in the PNG: two each way, for sharp screens, each the mean of two by two drawn ones, which
/// makes lines smooth.
const SHARP: usize = 2;
const SMOOTH: usize = 2;
pub const INK: RGBColor = RGBColor(0x33, 0x33, 0x33);
pub const GRID: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

type Area<DB> = DrawingArea<DB, Shift>;
pub type Drawn = Result<(), String>;

fn text_of(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// What can be drawn, and how large it is in units.
pub trait Picture {
    fn size(&self) -> (f64, f64);

    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn;

    fn svg(&self, path: &Path) -> Drawn {
        // plotters rounds to whole pixels: it draws on many, and the picture is shown smaller.
        let (fine, size) = ((SHARP * SMOOTH) as f64, self.size());
        let (w, h) = ((fine * size.0) as u32, (fine * size.1) as u32);
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, (w, h)).into_drawing_area();
        self.fill(&Pen { area: &area, scale: fine, sink: 0.0 })?;
        drop(area);
        let shown = format!("width=\"{}\" height=\"{}\"", size.0, size.1);
        let text = text.replacen(&format!("width=\"{w}\" height=\"{h}\""), &shown, 1);
        std::fs::write(path, text).map_err(text_of)
    }

    fn png(&self, path: &Path) -> Drawn {
        let (w, h) = (self.size().0 as usize * SHARP, self.size().1 as usize * SHARP);
        let fine = (w * SMOOTH, h * SMOOTH);
        let mut drawn = vec![0; 3 * fine.0 * fine.1];
        let area = BitMapBackend::with_buffer(&mut drawn, (fine.0 as u32, fine.1 as u32)).into_drawing_area();
        self.fill(&Pen { area: &area, scale: (SHARP * SMOOTH) as f64, sink: 0.17 })?;
        drop(area);
        let mean = |i: usize| {
            let (row, column, channel) = (i / (3 * w), i / 3 % w, i % 3);
            let at = |y: usize, x: usize| 3 * ((SMOOTH * row + y) * fine.0 + SMOOTH * column + x) + channel;
            let block = (0..SMOOTH).flat_map(|y| (0..SMOOTH).map(move |x| (y, x)));
            let sum: u32 = block.map(|(y, x)| u32::from(drawn[at(y, x)])).sum();
            (sum / (SMOOTH * SMOOTH) as u32) as u8
        };
        let pixels: Vec<u8> = (0..3 * w * h).map(mean).collect();
        let size = (w as u32, h as u32);
        let picture = BitMapElement::with_owned_buffer((0, 0), size, pixels).ok_or("a picture of no size")?;
        let area = BitMapBackend::new(path, size).into_drawing_area();
        area.draw(&picture).map_err(text_of)?;
        area.present().map_err(text_of)
    }

    /// Draws on white.
    fn fill<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        // Text must be measured wherever a picture is made; this font is compiled in.
        register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular())
            .map_err(|_| "the compiled-in font cannot be read".to_string())?;
        pen.area.fill(&WHITE).map_err(text_of)?;
        self.draw(pen)?;
        pen.area.present().map_err(text_of)
    }
}

/// Draws in units.
pub struct Pen<'a, DB: DrawingBackend> {
    area: &'a Area<DB>,
    scale: f64,
    /// How far, in font sizes, text must be moved down to stand in the middle of its line.
    sink: f64,
}

impl<DB: DrawingBackend> Pen<'_, DB> {
    fn pixel(&self, (x, y): (f64, f64)) -> (i32, i32) {
        ((self.scale * x).round() as i32, (self.scale * y).round() as i32)
    }

    pub fn line(&self, points: &[(f64, f64)], colour: impl Color, width: f64) -> Drawn {
        let points: Vec<(i32, i32)> = points.iter().map(|&point| self.pixel(point)).collect();
        let style = ShapeStyle::from(&colour).stroke_width((self.scale * width).round() as u32);
        self.area.draw(&PathElement::new(points, style)).map_err(text_of)
    }

    /// A rectangle between two corners.
    pub fn block(&self, from: (f64, f64), to: (f64, f64), colour: impl Color) -> Drawn {
        let corners = [self.pixel(from), self.pixel(to)];
        self.area.draw(&Rectangle::new(corners, colour.filled())).map_err(text_of)
    }

    /// One of six shapes of about the same size round a point.
    pub fn marker(&self, kind: usize, (x, y): (f64, f64), size: f64, colour: RGBAColor) -> Drawn {
        let corners = |turn: f64, n: usize, r: f64| -> Vec<(i32, i32)> {
            let angle = |i: usize| std::f64::consts::TAU * (turn + i as f64 / n as f64);
            (0..n).map(|i| self.pixel((x + r * angle(i).sin(), y - r * angle(i).cos()))).collect()
        };
        let shape = match kind % 6 {
            0 => {
                let r = (self.scale * size).round() as i32;
                return self.area.draw(&Circle::new(self.pixel((x, y)), r, colour.filled())).map_err(text_of);
            }
            1 => corners(0.125, 4, 1.25 * size),
            2 => corners(0.0, 3, 1.4 * size),
            3 => corners(0.0, 4, 1.4 * size),
            4 => corners(0.5, 3, 1.4 * size),
            _ => corners(0.0, 5, 1.25 * size),
        };
        self.area.draw(&Polygon::new(shape, colour.filled())).map_err(text_of)
    }

    pub fn text(
        &self,
        text: &str,
        at: (f64, f64),
        size: f64,
        colour: RGBColor,
        (h, v): (HPos, VPos),
    ) -> Drawn {
        let font = ("sans-serif", self.scale * size).into_font();
        let down = if matches!(v, VPos::Center) { self.sink * size } else { 0.0 };
        self.write(text, (at.0, at.1 + down), font.color(&colour).pos(Pos::new(h, v)))
    }

    /// Text that reads from the bottom to the top.
    pub fn upright(&self, text: &str, at: (f64, f64), size: f64, colour: RGBColor) -> Drawn {
        let font = ("sans-serif", self.scale * size).into_font().transform(FontTransform::Rotate270);
        self.write(text, at, font.color(&colour).pos(Pos::new(HPos::Center, VPos::Top)))
    }

    fn write(&self, text: &str, at: (f64, f64), style: TextStyle) -> Drawn {
        self.area.draw(&Text::new(text.to_string(), self.pixel(at), style)).map_err(text_of)
    }
}
