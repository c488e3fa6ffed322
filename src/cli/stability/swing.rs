//! The growth of a swing, y'' = -omega^2 y, over h omega.

use super::region::nice;
use crate::cli::pen::{Drawn, FONT, GRID, INK, Pen, Picture};
use crate::cli::words::short;
use kutta::tableau::Stability;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// The picture in units, and the frame of the axes in it.
const SIZE: (f64, f64) = (860.0, 560.0);
const LEFT: f64 = 78.0;
const RIGHT: f64 = 836.0;
const TOP: f64 = 74.0;
const BOTTOM: f64 = 504.0;
const POINTS: usize = 1200;
/// Growth is shown up to this factor a step.
const MOST: f64 = 1.6;
const LEAST: f64 = 0.8;
const SHADE: RGBColor = RGBColor(0xcf, 0xe2, 0xf1);
const CURVE: RGBColor = RGBColor(0x1f, 0x77, 0xb4);

pub struct Swing {
    name: String,
    limit: f64,
    /// The largest h omega shown.
    end: f64,
    /// The factor of a step at evenly spaced h omega from 0 on.
    growth: Vec<f64>,
}

impl Swing {
    pub fn of(name: &str, stability: &Stability) -> Self {
        let limit = stability.limit(0.0);
        let end = if limit > 0.0 && limit.is_finite() { 1.5 * limit } else { 4.0 };
        let at = |i: usize| end * i as f64 / POINTS as f64;
        let growth = (0..=POINTS).map(|i| stability.amplification((-at(i) * at(i)).into())).collect();
        Self { name: name.to_string(), limit, end, growth }
    }

    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (LEFT + x / self.end * (RIGHT - LEFT), BOTTOM - (y - LEAST) / (MOST - LEAST) * (BOTTOM - TOP))
    }
}

impl Picture for Swing {
    fn size(&self) -> (f64, f64) {
        SIZE
    }

    fn draw<DB: DrawingBackend>(&self, pen: &Pen<DB>) -> Drawn {
        let limit = self.limit.min(self.end);
        pen.block((LEFT, TOP), (self.at((limit, 0.0)).0, BOTTOM), SHADE)?;
        let step = nice(self.end / 10.0);
        for k in 0..=(self.end / step) as i32 {
            let (x, _) = self.at((f64::from(k) * step, 0.0));
            pen.line(&[(x, TOP), (x, BOTTOM)], GRID, 1.0)?;
            pen.text(&short(f64::from(k) * step), (x, BOTTOM + 8.0), FONT, INK, (HPos::Center, VPos::Top))?;
        }
        for k in 0..=8 {
            let y = LEAST + 0.1 * f64::from(k);
            let (_, py) = self.at((0.0, y));
            pen.line(&[(LEFT, py), (RIGHT, py)], if k == 2 { INK } else { GRID }, 1.0)?;
            pen.text(&short(y), (LEFT - 8.0, py), FONT, INK, (HPos::Right, VPos::Center))?;
        }
        let at = |i: usize| self.end * i as f64 / POINTS as f64;
        let points: Vec<_> = self.growth.iter().enumerate().map(|(i, &y)| (at(i), y)).collect();
        for piece in points.split(|(_, y)| *y > MOST) {
            let piece: Vec<_> = piece.iter().map(|&point| self.at(point)).collect();
            pen.line(&piece, CURVE, 2.5)?;
        }
        if self.limit > 0.0 && self.limit.is_finite() {
            let (x, y) = self.at((self.limit, 1.0));
            pen.marker(0, (x, y), 5.0, INK.to_rgba())?;
            let label = format!("h omega = {}", short(self.limit));
            pen.text(&label, (x - 8.0, y + 8.0), FONT + 1.0, INK, (HPos::Right, VPos::Top))?;
        }
        pen.line(&[(LEFT, TOP), (LEFT, BOTTOM), (RIGHT, BOTTOM), (RIGHT, TOP), (LEFT, TOP)], INK, 1.0)?;
        let (middle, below) = (0.5 * (LEFT + RIGHT), (HPos::Center, VPos::Top));
        pen.text(&format!("{}: stability on a swing", self.name), (middle, 14.0), 19.0, INK, below)?;
        pen.text("y'' = -omega^2 y, stable where no step makes it larger", (middle, 44.0), 15.0, INK, below)?;
        pen.text("h omega", (middle, BOTTOM + 32.0), 15.0, INK, below)?;
        pen.upright("factor of a step", (10.0, 0.5 * (TOP + BOTTOM)), 15.0, INK)
    }
}
