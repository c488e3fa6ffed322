//! Bodies that pull on each other.

use super::{Problem, SecondOrder};
use std::f64::consts::{PI, TAU};

/// The derivative of w d, w = 1/|d|^3, after the difference d: xx, xy (which is yx), yy.
fn stretch(dx: f64, dy: f64) -> [f64; 3] {
    let r2 = dx * dx + dy * dy;
    let w = 1.0 / (r2 * r2.sqrt());
    let w3 = 3.0 * w / r2;
    [w - w3 * dx * dx, -w3 * dx * dy, w - w3 * dy * dy]
}

/// Enters the pull between bodies i and j of masses mi and mj into the Jacobian, given n bodies whose x, y,
/// velocities in x and in y follow each other, and the [`stretch`] of their difference.
fn add_pair(
    n: usize,
    (i, mi): (usize, f64),
    (j, mj): (usize, f64),
    [xx, xy, yy]: [f64; 3],
    add: &mut impl FnMut(usize, usize, f64),
) {
    for (of, by, m) in [(i, j, mj), (j, i, mi)] {
        for (row, column, value) in [(0, 0, xx), (0, n, xy), (n, 0, xy), (n, n, yy)] {
            add(2 * n + row + of, column + by, m * value);
            add(2 * n + row + of, column + of, -m * value);
        }
    }
}

/// Seven stars in a plane, of masses m_i = i:
///
/// ```text
/// x_i'' = sum over j != i of m_j (x_j - x_i)/r_ij^3,  the same for y,  r_ij = |(x_i - x_j, y_i - y_j)|
/// x(0) = (3, 3, -1, -3, 2, -2, 2),  y(0) = (3, -3, 2, 0, 0, -4, 4)
/// x'(0) = (0, 0, 0, 0, 0, 1.75, -1.5),  y'(0) = (0, 0, 0, -1.25, 1, 0, 0),  0 <= t <= 3
/// ```
///
/// The state holds seven x, seven y, seven x', seven y'. The first and the last pass within 0.034 of each
/// other at t = 1.68.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pleiades;

impl Problem for Pleiades {
    type Y = [f64; 28];
    const NAME: &'static str = "pleiades";
    const ABOUT: &'static str = "seven stars in a plane with close passes: the step must shrink and grow";
    const SOURCE: &'static str = "Hairer, Norsett, Wanner I, II.10: PLEI";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        let mut y = [0.0; 28];
        y[..14].copy_from_slice(&self.x0());
        y[14..].copy_from_slice(&self.v0());
        y
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 3.0)
    }
    #[inline]
    fn rhs(&self, t: f64, y: &Self::Y, dy: &mut Self::Y) {
        let (x, v) = y.split_first_chunk::<14>().expect("28 components");
        let (dx, a) = dy.split_first_chunk_mut::<14>().expect("28 components");
        dx.copy_from_slice(v);
        self.acceleration(t, x, a.first_chunk_mut().expect("14 components"));
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        for i in 0..14 {
            add(i, 14 + i, 1.0);
        }
        for i in 0..7 {
            for j in i + 1..7 {
                let stretch = stretch(y[j] - y[i], y[7 + j] - y[7 + i]);
                add_pair(7, (i, (i + 1) as f64), (j, (j + 1) as f64), stretch, &mut add);
            }
        }
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &REFERENCE
    }
}

impl SecondOrder for Pleiades {
    type X = [f64; 14];

    fn x0(&self) -> Self::X {
        [3.0, 3.0, -1.0, -3.0, 2.0, -2.0, 2.0, 3.0, -3.0, 2.0, 0.0, 0.0, -4.0, 4.0]
    }
    fn v0(&self) -> Self::X {
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.75, -1.5, 0.0, 0.0, 0.0, -1.25, 1.0, 0.0, 0.0]
    }
    #[inline]
    fn acceleration(&self, _t: f64, x: &Self::X, a: &mut Self::X) {
        // All w = 1/r^3 in a loop of their own: root and quotient take longest, and here the processor takes
        // several of them at a time.
        let (mut dx, mut dy, mut w) = ([0.0; 21], [0.0; 21], [0.0; 21]);
        let mut pair = 0;
        for i in 0..7 {
            for j in i + 1..7 {
                (dx[pair], dy[pair]) = (x[j] - x[i], x[7 + j] - x[7 + i]);
                pair += 1;
            }
        }
        for pair in 0..21 {
            let r2 = dx[pair] * dx[pair] + dy[pair] * dy[pair];
            w[pair] = 1.0 / (r2 * r2.sqrt());
        }
        *a = [0.0; 14];
        let mut pair = 0;
        for i in 0..7 {
            for j in i + 1..7 {
                let (on_i, on_j) = ((j + 1) as f64 * w[pair], (i + 1) as f64 * w[pair]);
                a[i] += on_i * dx[pair];
                a[7 + i] += on_i * dy[pair];
                a[j] -= on_j * dx[pair];
                a[7 + j] -= on_j * dy[pair];
                pair += 1;
            }
        }
    }
}

/// Maxwell's ring: n equal moons, evenly spread on a circle of radius 1 round a planet at rest, every body
/// pulling on every other. The whole turns like a wheel, once in 2 pi:
///
/// ```text
/// x_i'' = sum over j != i of m_j (x_j - x_i)/|x_j - x_i|^3,  0 <= t <= 2 pi
/// x_i = (cos(t + 2 pi i/n), sin(t + 2 pi i/n)),  i = 0, ..., n - 1,  the planet at (0, 0)
/// a moon's mass is n^-3, the planet's is 1 - n^-3 sum over k = 1, ..., n - 1 of 1/(4 sin(k pi/n))
/// ```
///
/// Moons below 2.3 n^-3 planets leave the ring stable for n >= 7; without the planet a disturbance would grow
/// by more than e^n in a turn, and no method could follow. The state holds x of the n moons and of the
/// planet, then y, then the velocities in x and in y: 4 n + 4 components.
#[derive(Clone, Copy, Debug)]
pub struct NBodyRing {
    moons: usize,
    moon: f64,
    planet: f64,
}

impl NBodyRing {
    /// A ring of `n` moons and their planet.
    ///
    /// # Panics
    /// If n is less than 2.
    pub fn new(n: usize) -> Self {
        assert!(n >= 2, "a ring of bodies needs at least two");
        let moon = 1.0 / (n as f64).powi(3);
        let pull: f64 = (1..n).map(|k| 0.25 / (PI * k as f64 / n as f64).sin()).sum();
        Self { moons: n, moon, planet: 1.0 - moon * pull }
    }

    #[inline]
    fn pull(&self, x: &[f64], a: &mut [f64]) {
        let n = self.moons;
        let (x, y) = x.split_at(n + 1);
        let (ax, ay) = a.split_at_mut(n + 1);
        let (x, y, ax, ay) = (&x[..n + 1], &y[..n + 1], &mut ax[..n + 1], &mut ay[..n + 1]);
        ax.fill(0.0);
        ay.fill(0.0);
        for i in 0..n {
            let (xi, yi) = (x[i], y[i]);
            let (mut sum_x, mut sum_y) = (0.0, 0.0);
            for j in i + 1..n {
                let (dx, dy) = (x[j] - xi, y[j] - yi);
                let r2 = dx * dx + dy * dy;
                let w = self.moon / (r2 * r2.sqrt());
                sum_x += w * dx;
                sum_y += w * dy;
                ax[j] -= w * dx;
                ay[j] -= w * dy;
            }
            let (dx, dy) = (x[n] - xi, y[n] - yi);
            let r2 = dx * dx + dy * dy;
            let w = 1.0 / (r2 * r2.sqrt());
            ax[i] += sum_x + self.planet * w * dx;
            ay[i] += sum_y + self.planet * w * dy;
            ax[n] -= self.moon * w * dx;
            ay[n] -= self.moon * w * dy;
        }
    }

    /// x of all bodies at t, then y.
    fn places(&self, t: f64) -> Vec<f64> {
        let n = self.moons as f64;
        let angle = move |i: usize| t + TAU * (i as f64 / n);
        let x = (0..self.moons).map(|i| angle(i).cos()).chain([0.0]);
        let y = (0..self.moons).map(|i| angle(i).sin()).chain([0.0]);
        x.chain(y).collect()
    }

    fn velocities(&self, t: f64) -> Vec<f64> {
        let mut v = self.places(t);
        let (x, y) = v.split_at_mut(self.moons + 1);
        x.swap_with_slice(y);
        x.iter_mut().for_each(|x| *x = -*x);
        v
    }
}

impl Problem for NBodyRing {
    type Y = Vec<f64>;
    const NAME: &'static str = "nbody-ring";
    const ABOUT: &'static str = "a planet and its ring of moons, all pulling on all; built to size";
    const SOURCE: &'static str = "Maxwell 1859, On the Stability of the Motion of Saturn's Rings";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        let mut y = self.x0();
        y.extend(self.v0());
        y
    }
    fn span(&self) -> (f64, f64) {
        (0.0, TAU)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        let half = 2 * (self.moons + 1);
        let (x, v) = y.split_at(half);
        let (dx, a) = dy.split_at_mut(half);
        dx.copy_from_slice(v);
        self.pull(x, a);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        let bodies = self.moons + 1;
        let mass = |i| if i < self.moons { self.moon } else { self.planet };
        for i in 0..2 * bodies {
            add(i, 2 * bodies + i, 1.0);
        }
        for i in 0..bodies {
            for j in i + 1..bodies {
                let stretch = stretch(y[j] - y[i], y[bodies + j] - y[bodies + i]);
                add_pair(bodies, (i, mass(i)), (j, mass(j)), stretch, &mut add);
            }
        }
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let mut y = self.places(t);
        y.extend(self.velocities(t));
        Some(y)
    }
}

impl SecondOrder for NBodyRing {
    type X = Vec<f64>;

    fn x0(&self) -> Self::X {
        self.places(0.0)
    }
    fn v0(&self) -> Self::X {
        self.velocities(0.0)
    }
    #[inline]
    fn acceleration(&self, _t: f64, x: &Self::X, a: &mut Self::X) {
        self.pull(x, a);
    }
}

/// The [`Pleiades`] at t = 3.
const REFERENCE: [&str; 28] = [
    "0.370613914397051290093950918",
    "3.23728409205723309280333039",
    "-3.22255903241832334710013147",
    "0.659709145577530835934995556",
    "0.342558170715657979037735981",
    "1.56217210140063101604570821",
    "-0.700309292221249538514732671",
    "-3.94343758551739205527788317",
    "-3.27138097397254992802067685",
    "5.22508184345654419243873814",
    "-2.59061243497746951081119136",
    "1.19821369339227463751400241",
    "-0.242968234493582340916111633",
    "1.09144924042897974788206366",
    "3.4170038063143147522918926",
    "1.35458450162550122147698199",
    "-2.59006559781077541961863144",
    "2.02505373471424110648501306",
    "-1.15581510016044909271194592",
    "-0.807298817022302172565972073",
    "0.595239635420871876660792501",
    "-3.7412449612340084712047454",
    "0.377345968575062903655827116",
    "0.938685886955107888694681526",
    "0.366792222720056986669641069",
    "-0.347404635380849436600716533",
    "2.34491544818093692314231718",
    "-1.94702043426329190067426259",
];
