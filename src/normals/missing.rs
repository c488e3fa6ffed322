//! Heights that are not there: the map ends at them.

use super::bake::Bake;
use super::border::Border;
use super::heights::{Height, Heights};
use super::line::{Line, Spec};
use super::normal::sealed::Write;
use super::operator::{self, Axis};
use crate::tableau::DoubleDouble as D;
use std::collections::HashMap;

/// Texels to either side that a compact stencil's slope is made of, here: its weights fall by 2.6 or more with
/// each, to below 1e-10.
const COMPACT: usize = 24;

/// A row of the map or a column, and a place on it.
struct Walk<'a, H> {
    heights: &'a Heights<'a, H>,
    axis: Axis,
    wrap: bool,
    at: [usize; 2],
}

impl<H: Height> Walk<'_, H> {
    fn length(&self) -> usize {
        self.heights.size()[self.axis as usize]
    }

    /// The height so many texels further, where there is one.
    fn height(&self, by: isize) -> Option<f64> {
        let (n, i) = (self.length() as isize, self.axis as usize);
        let mut at = self.at;
        let to = at[i] as isize + by;
        if !self.wrap && !(0..n).contains(&to) {
            return None;
        }
        at[i] = to.rem_euclid(n) as usize;
        let height = self.heights.row(at[1])[at[0]];
        height.finite().then(|| height.steps().into())
    }

    /// How many texels follow without a gap, up to `most`.
    fn run(&self, sign: isize, most: usize) -> usize {
        (1..=most).take_while(|i| self.height(sign * *i as isize).is_some()).count()
    }
}

/// How many texels to either side decide about a one-sided difference.
fn reach(spec: &Spec) -> usize {
    let last = spec.taps.first + spec.taps.len as isize;
    let taps = spec.taps.first.unsigned_abs().max(last.unsigned_abs());
    taps.max(spec.degree + 1) + if spec.left.len > 1 { COMPACT } else { 0 }
}

/// Whether a bad texel is near along an axis: a compact stencil has no end.
pub(super) fn near<H: Height>(bake: &Bake, heights: &Heights<H>, axis: Axis, at: [usize; 2]) -> bool {
    let [spec, _] = operator::specs(bake.stencil, axis, Border::OneSided, D::ONE);
    let (i, reach) = (axis as usize, reach(&spec) as isize);
    (-reach..=reach).any(|by| {
        let mut to = at;
        let found = bake.border[i].find(at[i] as isize + by, heights.size()[i]);
        found.is_some_and(|(found, _)| {
            to[i] = found;
            heights.bad(to[0], to[1])
        })
    })
}

/// Writes again the texels whose stencil touches a height that is not finite: `touches` tells which do along an
/// axis, `slope` what the others' slopes are.
pub(super) fn repair<H: Height, W: Write>(
    bake: &Bake,
    heights: &Heights<H>,
    scale: [D; 2],
    slope: impl Fn(usize, usize) -> [f64; 2],
    touches: impl Fn(Axis, usize, usize) -> bool,
    out: &mut [W],
) {
    let specs = [(Axis::S, 0), (Axis::T, 1)]
        .map(|(axis, i)| operator::specs(bake.stencil, axis, Border::OneSided, scale[i])[0]);
    // Rows of a one-sided line, by axis and by the texels there are on either side.
    let mut rows = HashMap::<_, Vec<(usize, f64)>>::new();
    for (i, out) in out.iter_mut().enumerate() {
        let (x, y) = (i % heights.width, i / heights.width);
        let touched = [Axis::S, Axis::T].map(|axis| touches(axis, x, y));
        if heights.bad(x, y) {
            *out = W::one(0.0, 0.0, bake.best_fit);
        } else if touched != [false; 2] {
            let mut slope = slope(x, y);
            for (i, axis) in [Axis::S, Axis::T].into_iter().enumerate().filter(|(i, _)| touched[*i]) {
                let walk = Walk { heights, axis, wrap: bake.border[i] == Border::Wrap, at: [x, y] };
                let most = reach(&specs[i]).min(walk.length() - 1);
                let before = walk.run(-1, most);
                let after = walk.run(1, most.min(walk.length() - 1 - before));
                let row = rows
                    .entry((i, before, after))
                    .or_insert_with(|| Line::new(&specs[i], before + 1 + after).row(before));
                let height = |at: usize| walk.height(at as isize - before as isize).unwrap_or(0.0);
                slope[i] = row.iter().map(|&(at, w)| w * height(at)).sum();
            }
            *out = W::one(slope[0], slope[1], bake.best_fit);
        }
    }
}
