//! One body in a given field: a comet round its sun, a satellite between Earth and Moon.

use super::{Problem, SecondOrder, each};

/// Kepler's problem, a body held by one fixed mass, on an ellipse of eccentricity e = 0.6 and period 2 pi:
///
/// ```text
/// q'' = -q/|q|^3,  q(0) = (1 - e, 0),  q'(0) = (0, sqrt((1 + e)/(1 - e))) = (0, 2),  0 <= t <= 20
/// q = (cos E - e, sqrt(1 - e^2) sin E)  where  E - e sin E = t
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct KeplerE06;

impl Problem for KeplerE06 {
    type Y = [f64; 4];
    const NAME: &'static str = "kepler-e06";
    const ABOUT: &'static str = "a planet on an ellipse of eccentricity 0.6, three turns";
    const SOURCE: &'static str = "Kepler 1609; Hairer, Lubich, Wanner, Geometric Numerical Integration, I.2";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [0.4, 0.0, 0.0, 2.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 20.0)
    }
    #[inline]
    fn rhs(&self, t: f64, &[q1, q2, p1, p2]: &Self::Y, dy: &mut Self::Y) {
        let mut a = [0.0; 2];
        self.acceleration(t, &[q1, q2], &mut a);
        *dy = [p1, p2, a[0], a[1]];
    }
    fn jacobian(&self, _t: f64, &[q1, q2, ..]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        let tide = tide(q1, q2, 1.0);
        each(
            [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [tide[0], tide[1], 0.0, 0.0],
                [tide[1], tide[2], 0.0, 0.0],
            ],
            add,
        );
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &[
            "-0.770075578411233384515674226092",
            "0.788344816994425559451194844583",
            "-0.894183731988696101108815934886",
            "-0.123461764158436076818693851799",
        ]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        // 0.4 as f64 is larger by 2.2e-17. The orbit through it has e = 0.6 + 4 * 2.2e-17, which is the f64
        // beside 0.6, and turns slower by 18.75 * 2.2e-17: both would show in the last digits.
        const E: f64 = 0.6000000000000001;
        let mean = t - 4.163336342e-16 * t;
        let mut eccentric = mean;
        for _ in 0..20 {
            let miss = eccentric - E * eccentric.sin() - mean;
            eccentric -= miss / (1.0 - E * eccentric.cos());
        }
        let (sin, cos) = eccentric.sin_cos();
        let (b, rate) = ((1.0 - E * E).sqrt(), 1.0 / (1.0 - E * cos));
        Some([cos - E, b * sin, -sin * rate, b * cos * rate])
    }
}

impl SecondOrder for KeplerE06 {
    type X = [f64; 2];

    fn x0(&self) -> Self::X {
        [0.4, 0.0]
    }
    fn v0(&self) -> Self::X {
        [0.0, 2.0]
    }
    #[inline]
    fn acceleration(&self, _t: f64, [q1, q2]: &Self::X, a: &mut Self::X) {
        let r2 = q1 * q1 + q2 * q2;
        let pull = 1.0 / (r2 * r2.sqrt());
        *a = [-q1 * pull, -q2 * pull];
    }
}

/// The derivative of the pull -m x/|x|^3 of a mass m on a body at (x, y) from it: xx, xy (which is yx), yy.
fn tide(x: f64, y: f64, m: f64) -> [f64; 3] {
    let r2 = x * x + y * y;
    let pull = m / (r2 * r2.sqrt());
    let stretch = 3.0 * pull / r2;
    [stretch * x * x - pull, stretch * x * y, stretch * y * y - pull]
}

/// A satellite in the frame that turns with Earth (at (-mu, 0)) and Moon (at (1 - mu, 0)), on a closed orbit
/// of four loops; lengths in Earth-Moon distances, one month is 2 pi.
///
/// ```text
/// y1'' = y1 + 2 y2' - mu1 (y1 + mu)/D1 - mu (y1 - mu1)/D2
/// y2'' = y2 - 2 y1' - mu1 y2/D1 - mu y2/D2
/// D1 = ((y1 + mu)^2 + y2^2)^(3/2),  D2 = ((y1 - mu1)^2 + y2^2)^(3/2),  mu = 0.012277471,  mu1 = 1 - mu
/// y(0) = (0.994, 0),  y'(0) = (0, -2.00158510637908252240537862224),  t to 17.0652165601579625588917206249
/// ```
///
/// One period, so y(t1) = y(0) in decimal; rounding the printed numbers to `f64` moves the end by 1e-11.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arenstorf4Loop;

const MU: f64 = 0.012277471;
const MU1: f64 = 1.0 - MU;

impl Problem for Arenstorf4Loop {
    type Y = [f64; 4];
    const NAME: &'static str = "arenstorf-4loop";
    const ABOUT: &'static str = "a satellite round Earth and Moon in four loops: close passes, closed orbit";
    const SOURCE: &'static str = "Arenstorf 1963, Amer. J. Math. 85, 27; Hairer, Norsett, Wanner I, II.0";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [0.994, 0.0, 0.0, -2.0015851063790824]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 17.065216560157964)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y1, y2, v1, v2]: &Self::Y, dy: &mut Self::Y) {
        let (earth, moon) = (y1 + MU, y1 - MU1);
        let (r2, s2) = (earth * earth + y2 * y2, moon * moon + y2 * y2);
        let (pull, pull_moon) = (MU1 / (r2 * r2.sqrt()), MU / (s2 * s2.sqrt()));
        *dy = [
            *v1,
            *v2,
            y1 + 2.0 * v2 - pull * earth - pull_moon * moon,
            y2 - 2.0 * v1 - pull * y2 - pull_moon * y2,
        ];
    }
    fn jacobian(&self, _t: f64, [y1, y2, ..]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        let (earth, moon) = (tide(y1 + MU, *y2, MU1), tide(y1 - MU1, *y2, MU));
        let both = [0, 1, 2].map(|i| earth[i] + moon[i]);
        each(
            [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [1.0 + both[0], both[1], 0.0, 2.0],
                [both[1], 1.0 + both[2], -2.0, 0.0],
            ],
            add,
        );
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &[
            "0.99399999999997399577",
            "-8.8551346201210834053e-14",
            "-1.4388667357318093583e-11",
            "-2.0015851063831290198",
        ]
    }
}
