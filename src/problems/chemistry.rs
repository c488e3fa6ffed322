//! Stiff chemical kinetics: rates apart by many powers of ten, amounts far below one.

use super::{Problem, each};

#[inline]
fn robertson([y1, y2, y3]: &[f64; 3], dy: &mut [f64; 3]) {
    let (r1, r2, r3) = (0.04 * y1, 3e7 * y2 * y2, 1e4 * y2 * y3);
    *dy = [r3 - r1, r1 - r3 - r2, r2];
}

fn robertson_jacobian([_, y2, y3]: &[f64; 3], add: impl FnMut(usize, usize, f64)) {
    let (r2, by2, by3) = (6e7 * y2, 1e4 * y3, 1e4 * y2);
    each([[-0.04, by2, by3], [0.04, -by2 - r2, -by3], [0.0, r2, 0.0]], add);
}

/// Robertson's autocatalysis, A -> B (k1), B + B -> C + B (k2), B + C -> A + C (k3); y the amounts of A, B,
/// C:
///
/// ```text
/// y1' = -k1 y1 + k3 y2 y3,  y2' = k1 y1 - k3 y2 y3 - k2 y2^2,  y3' = k2 y2^2
/// k1 = 0.04,  k2 = 3e7,  k3 = 1e4,  y(0) = (1, 0, 0),  0 <= t <= 40
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct RobertsonUntil40;

impl Problem for RobertsonUntil40 {
    type Y = [f64; 3];
    const NAME: &'static str = "robertson-40";
    const ABOUT: &'static str = "three species, one scarce and quick, to t = 40";
    const SOURCE: &'static str = "Robertson 1966; Hairer, Wanner II, IV.1";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 40.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        robertson(y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        robertson_jacobian(y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["0.71582706871940508694", "9.1855347645577639421e-6", "0.2841637457458303553"]
    }
    fn scale(&self) -> f64 {
        1e-6
    }
}

/// Robertson's autocatalysis, 0 <= t <= 1e11; the equations are those of [`RobertsonUntil40`].
///
/// Steps must grow by ten powers of ten, and a y2 driven below zero runs off to minus infinity.
#[derive(Clone, Copy, Debug, Default)]
pub struct RobertsonUntil1e11;

impl Problem for RobertsonUntil1e11 {
    type Y = [f64; 3];
    const NAME: &'static str = "robertson-1e11";
    const ABOUT: &'static str = "the same three species to t = 1e11: amounts below zero run away";
    const SOURCE: &'static str = "Robertson 1966; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 1e11)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        robertson(y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        robertson_jacobian(y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["2.0833401497012941438e-8", "8.3333607703347832272e-14", "0.99999997916651516938"]
    }
    fn scale(&self) -> f64 {
        1e-8
    }
}

/// How light steers the growth of a plant, the high irradiance response: eight forms of phytochrome.
///
/// ```text
/// y1' = -1.71 y1 + 0.43 y2 + 8.32 y3 + 0.0007     y5' = -1.745 y5 + 0.43 y6 + 0.43 y7
/// y2' = 1.71 y1 - 8.75 y2                         y6' = -280 y6 y8 + 0.69 y4 + 1.71 y5 - 0.43 y6 + 0.69 y7
/// y3' = -10.03 y3 + 0.43 y4 + 0.035 y5            y7' = 280 y6 y8 - 1.81 y7
/// y4' = 8.32 y2 + 1.71 y3 - 1.12 y4               y8' = -y7'
/// y(0) = (1, 0, 0, 0, 0, 0, 0, 0.0057),  0 <= t <= 321.8122
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Hires;

impl Problem for Hires {
    type Y = [f64; 8];
    const NAME: &'static str = "hires";
    const ABOUT: &'static str =
        "eight forms of a plant's pigment under light: the end comes in a sudden turn";
    const SOURCE: &'static str = "Schaefer 1975, J. Theor. Biol. 51, 427; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 321.8122)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y1, y2, y3, y4, y5, y6, y7, y8]: &Self::Y, dy: &mut Self::Y) {
        let r = 280.0 * y6 * y8;
        let y7_gain = r - 1.81 * y7;
        *dy = [
            -1.71 * y1 + 0.43 * y2 + 8.32 * y3 + 0.0007,
            1.71 * y1 - 8.75 * y2,
            -10.03 * y3 + 0.43 * y4 + 0.035 * y5,
            8.32 * y2 + 1.71 * y3 - 1.12 * y4,
            -1.745 * y5 + 0.43 * y6 + 0.43 * y7,
            -r + 0.69 * y4 + 1.71 * y5 - 0.43 * y6 + 0.69 * y7,
            y7_gain,
            -y7_gain,
        ];
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        let (by6, by8) = (280.0 * y[7], 280.0 * y[5]);
        let matrix = [
            [-1.71, 0.43, 8.32, 0.0, 0.0, 0.0, 0.0, 0.0],
            [1.71, -8.75, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, -10.03, 0.43, 0.035, 0.0, 0.0, 0.0],
            [0.0, 8.32, 1.71, -1.12, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, -1.745, 0.43, 0.43, 0.0],
            [0.0, 0.0, 0.0, 0.69, 1.71, -by6 - 0.43, 0.69, -by8],
            [0.0, 0.0, 0.0, 0.0, 0.0, by6, -1.81, by8],
            [0.0, 0.0, 0.0, 0.0, 0.0, -by6, 1.81, -by8],
        ];
        each(matrix, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &[
            "0.00073713125733255412273",
            "0.00014424857263161596769",
            "5.8887297409673389083e-5",
            "0.0011756513432831254628",
            "0.0023863561988309492578",
            "0.0062389682527415998192",
            "0.0028499983951855009938",
            "0.0028500016048144992116",
        ]
    }
    fn scale(&self) -> f64 {
        1e-4
    }
}

/// The Oregonator, a model of the Belousov-Zhabotinsky reaction: bromous acid, bromide, cerium ions.
///
/// ```text
/// y1' = s (y2 + y1 (1 - q y1 - y2)),  y2' = (y3 - (1 + y1) y2)/s,  y3' = w (y1 - y3)
/// s = 77.27,  q = 8.375e-6,  w = 0.161,  y(0) = (1, 2, 3),  0 <= t <= 360
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Orego;

const S: f64 = 77.27;
const Q: f64 = 8.375e-6;
const W: f64 = 0.161;

impl Problem for Orego {
    type Y = [f64; 3];
    const NAME: &'static str = "orego";
    const ABOUT: &'static str = "a reaction that beats like a clock: jumps of five powers of ten";
    const SOURCE: &'static str = "Field, Noyes 1974, J. Chem. Phys. 60, 1877; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 2.0, 3.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 360.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y1, y2, y3]: &Self::Y, dy: &mut Self::Y) {
        *dy = [S * (y2 + y1 * (1.0 - Q * y1 - y2)), (y3 - (1.0 + y1) * y2) / S, W * (y1 - y3)];
    }
    fn jacobian(&self, _t: f64, [y1, y2, _]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each(
            [
                [S * (1.0 - 2.0 * Q * y1 - y2), S * (1.0 - y1), 0.0],
                [-y2 / S, -(1.0 + y1) / S, 1.0 / S],
                [W, 0.0, -W],
            ],
            add,
        );
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["1.0008148703185227167", "1228.1785215498874263", "132.05549428465045463"]
    }
}

#[inline]
fn e5([y1, y2, y3, y4]: &[f64; 4], dy: &mut [f64; 4]) {
    let (r1, r2) = (7.89e-10 * y1, 1.1e7 * y1 * y3);
    let (r3, r4) = (1.13e9 * y2 * y3, 1.13e3 * y4);
    let (dy2, dy4) = (r1 - r3, r2 - r4);
    *dy = [-r1 - r2, dy2, dy2 - dy4, dy4];
}

fn e5_jacobian([y1, y2, y3, _]: &[f64; 4], add: impl FnMut(usize, usize, f64)) {
    let (a, c) = (7.89e-10, 1.13e3);
    let (r2_1, r2_3) = (1.1e7 * y3, 1.1e7 * y1);
    let (r3_2, r3_3) = (1.13e9 * y3, 1.13e9 * y2);
    each(
        [
            [-a - r2_1, 0.0, -r2_3, 0.0],
            [a, -r3_2, -r3_3, 0.0],
            [a - r2_1, -r3_2, -r3_3 - r2_3, c],
            [r2_1, 0.0, r2_3, -c],
        ],
        add,
    );
}

/// E5 of the stiff DETEST set; every amount is below 2e-3, the smallest that matter about 1e-20.
///
/// ```text
/// y1' = -A y1 - B y1 y3,                         y2' = A y1 - M C y2 y3
/// y3' = A y1 - B y1 y3 - M C y2 y3 + C y4,       y4' = B y1 y3 - C y4
/// A = 7.89e-10,  B = 1.1e7,  C = 1.13e3,  M = 1e6,  y(0) = (1.76e-3, 0, 0, 0),  0 <= t <= 1e11
/// ```
///
/// y2 = y3 + y4 holds throughout. Summed as printed, y3' leaves that relation by rounding; as y2' - y4',
/// which is how it is formed here, it keeps it; a solver's own rounding may drift off by 1e-25 and more.
#[derive(Clone, Copy, Debug, Default)]
pub struct E5Until1e11;

impl Problem for E5Until1e11 {
    type Y = [f64; 4];
    const NAME: &'static str = "e5-1e11";
    const ABOUT: &'static str = "a reaction with amounts down to 1e-20, to t = 1e11: needs a tiny atol";
    const SOURCE: &'static str = "Enright, Hull, Lindberg 1975, BIT 15, 10: E5; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.76e-3, 0.0, 0.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 1e11)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        e5(y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        e5_jacobian(y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &[
            "3.7693082197389863248e-49",
            "1.0192582568142705974e-20",
            "1.0192582568142705974e-20",
            "3.739901219464195745e-65",
        ]
    }
    fn scale(&self) -> f64 {
        1e-20
    }
}

/// E5 of the stiff DETEST set, 0 <= t <= 1e13; the equations are those of [`E5Until1e11`].
///
/// The reference often printed has y2 - y3 = 1e-25 with y4 = 0, against y2 = y3 + y4, and is right in two or
/// three digits only. y1 and y4 end far below the range of `f64` (1e-3441): read 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct E5Until1e13;

impl Problem for E5Until1e13 {
    type Y = [f64; 4];
    const NAME: &'static str = "e5-1e13";
    const ABOUT: &'static str = "the same reaction to t = 1e13, with amounts down to 1e-22";
    const SOURCE: &'static str = "Enright, Hull, Lindberg 1975, BIT 15, 10: E5; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.76e-3, 0.0, 0.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 1e13)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        e5(y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        e5_jacobian(y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &[
            "1.73210122523167250747751727e-3441",
            "8.8612335212910842411442557e-23",
            "8.8612335212910842411442557e-23",
            "1.49410697196754604230307453e-3459",
        ]
    }
    fn scale(&self) -> f64 {
        1e-22
    }
}
