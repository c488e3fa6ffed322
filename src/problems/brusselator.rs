//! The Brusselator: two substances that react and spread, in one dimension and in two.

use super::{Problem, sine};

/// Two substances u and v on N = 40 inner points of the unit interval:
///
/// ```text
/// u_i' = 1 + u_i^2 v_i - 4 u_i + alpha (N + 1)^2 (u_(i-1) - 2 u_i + u_(i+1)),  u_0 = u_(N+1) = 1
/// v_i' = 3 u_i - u_i^2 v_i + alpha (N + 1)^2 (v_(i-1) - 2 v_i + v_(i+1)),      v_0 = v_(N+1) = 3
/// u_i(0) = 1 + sin(2 pi i/(N + 1)),  v_i(0) = 3,  alpha = 1/50,  0 <= t <= 10
/// ```
///
/// The state holds u_1, v_1, u_2, v_2, ..., so that the Jacobian has two diagonals on either side.
#[derive(Clone, Copy, Debug, Default)]
pub struct Brusselator1dN40;

/// alpha (N + 1)^2
const SPREAD: f64 = 0.02 * 1681.0;

impl Problem for Brusselator1dN40 {
    type Y = [f64; 80];
    const NAME: &'static str = "brusselator1d-n40";
    const ABOUT: &'static str = "two substances in a tube of 40 points: a chemical wave, with diffusion";
    const SOURCE: &'static str = "Prigogine, Lefever 1968, J. Chem. Phys. 48, 1695; Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        let mut y = [3.0; 80];
        for i in 1..=40 {
            y[2 * (i - 1)] = 1.0 + sine(2 * i, 41);
        }
        y
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        let point = |[ul, vl]: [f64; 2], [u, v]: [f64; 2], [ur, vr]: [f64; 2]| {
            let uuv = u * u * v;
            [1.0 + uuv - 4.0 * u + SPREAD * (ul - 2.0 * u + ur), 3.0 * u - uuv + SPREAD * (vl - 2.0 * v + vr)]
        };
        let (y, _) = y.as_chunks::<2>();
        let (dy, _) = dy.as_chunks_mut::<2>();
        let end = [1.0, 3.0];
        dy[0] = point(end, y[0], y[1]);
        for (dy, y) in dy[1..].iter_mut().zip(y.windows(3)) {
            *dy = point(y[0], y[1], y[2]);
        }
        dy[39] = point(y[38], y[39], end);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        for (i, [u, v]) in y.as_chunks::<2>().0.iter().enumerate() {
            let (iu, iv) = (2 * i, 2 * i + 1);
            add(iu, iu, 2.0 * u * v - 4.0 - 2.0 * SPREAD);
            add(iu, iv, u * u);
            add(iv, iu, 3.0 - 2.0 * u * v);
            add(iv, iv, -u * u - 2.0 * SPREAD);
            for j in [iu, iv] {
                if i > 0 {
                    add(j, j - 2, SPREAD);
                }
                if i < 39 {
                    add(j, j + 2, SPREAD);
                }
            }
        }
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &REFERENCE
    }
}

/// Two substances u and v on n * n points of the unit square, which is closed to a torus:
///
/// ```text
/// u' = 1 + u^2 v - 4.4 u + alpha n^2 (the four neighbours' u - 4 u)
/// v' = 3.4 u - u^2 v     + alpha n^2 (the four neighbours' v - 4 v)
/// u(0) = 22 (y (1 - y))^(3/2),  v(0) = 27 (x (1 - x))^(3/2),  x = j/n,  y = i/n
/// alpha = 1e-3,  0 <= t <= 10
/// ```
///
/// The state holds u, then v, row by row. Diffusion is weak enough for explicit methods up to n of about 200.
/// Unlike the book's, it is not forced. There is no reference: compare with a run at a tolerance far smaller.
#[derive(Clone, Copy, Debug)]
pub struct Brusselator2d {
    n: usize,
}

impl Brusselator2d {
    /// A torus of `n` by `n` points, 2 n^2 components.
    ///
    /// # Panics
    /// If n is less than 2.
    pub fn new(n: usize) -> Self {
        assert!(n >= 2, "a torus needs at least two points each way");
        Self { n }
    }

    /// alpha n^2
    fn spread(&self) -> f64 {
        1e-3 * (self.n * self.n) as f64
    }
}

impl Problem for Brusselator2d {
    type Y = Vec<f64>;
    const NAME: &'static str = "brusselator2d";
    const ABOUT: &'static str = "two substances on a torus, large and hardly stiff; built to size";
    const SOURCE: &'static str =
        "Prigogine, Lefever 1968, J. Chem. Phys. 48, 1695; after Hairer, Wanner II, IV.10";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        let n = self.n;
        let hill = |i: usize| {
            let s = i as f64 / n as f64;
            s * (1.0 - s) * (s * (1.0 - s)).sqrt()
        };
        let u = (0..n * n).map(|k| 22.0 * hill(k / n));
        let v = (0..n * n).map(|k| 27.0 * hill(k % n));
        u.chain(v).collect()
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        let (n, c) = (self.n, self.spread());
        let (u, v) = y.split_at(n * n);
        let (du, dv) = dy.split_at_mut(n * n);
        let rows = |s, i: usize| [(i + n - 1) % n, i, (i + 1) % n].map(|i| row(s, i, n));
        for (i, (du, dv)) in du.chunks_exact_mut(n).zip(dv.chunks_exact_mut(n)).enumerate() {
            react_and_spread(c, rows(u, i), rows(v, i), du, dv);
        }
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        let (n, c) = (self.n, self.spread());
        let (us, vs) = y.split_at(n * n);
        for k in 0..n * n {
            let (u, v, kv) = (us[k], vs[k], n * n + k);
            add(k, k, 2.0 * u * v - 4.4 - 4.0 * c);
            add(k, kv, u * u);
            add(kv, k, 3.4 - 2.0 * u * v);
            add(kv, kv, -u * u - 4.0 * c);
            let (i, j) = (k / n, k % n);
            let (up, down) = ((i + n - 1) % n * n + j, (i + 1) % n * n + j);
            let (left, right) = (i * n + (j + n - 1) % n, i * n + (j + 1) % n);
            for beside in [up, down, left, right] {
                add(k, beside, c);
                add(kv, n * n + beside, c);
            }
        }
    }
}

fn row(grid: &[f64], i: usize, n: usize) -> &[f64] {
    &grid[i * n..(i + 1) * n]
}

/// One row of the torus from the rows before, at and after it. On its own, and with slices cut to one length,
/// so that the compiler sees that nothing overlaps or ends early, and uses wide arithmetic.
#[inline(never)]
fn react_and_spread(c: f64, u: [&[f64]; 3], v: [&[f64]; 3], du: &mut [f64], dv: &mut [f64]) {
    let n = du.len();
    let point = |[ua, ul, u, ur, ub]: [f64; 5], [va, vl, v, vr, vb]: [f64; 5]| {
        let uuv = u * u * v;
        let (around_u, around_v) = (ua + ub + ul + ur - 4.0 * u, va + vb + vl + vr - 4.0 * v);
        (1.0 + uuv - 4.4 * u + c * around_u, 3.4 * u - uuv + c * around_v)
    };
    let around = |[above, row, below]: [&[f64]; 3], left: usize, j: usize, right: usize| {
        [above[j], row[left], row[j], row[right], below[j]]
    };
    (du[0], dv[0]) = point(around(u, n - 1, 0, 1), around(v, n - 1, 0, 1));
    (du[n - 1], dv[n - 1]) = point(around(u, n - 2, n - 1, 0), around(v, n - 2, n - 1, 0));
    let (du, dv) = (&mut du[1..n - 1], &mut dv[1..n - 1]);
    let ([ua, ul, u, ur, ub], [va, vl, v, vr, vb]) = (inner(u), inner(v));
    for j in 0..n - 2 {
        let (u, v) = ([ua[j], ul[j], u[j], ur[j], ub[j]], [va[j], vl[j], v[j], vr[j], vb[j]]);
        (du[j], dv[j]) = point(u, v);
    }
}

/// What lies above, left of, at, right of and below the points of a row that are not its ends.
#[inline]
fn inner([above, row, below]: [&[f64]; 3]) -> [&[f64]; 5] {
    let n = row.len() - 2;
    [&above[1..][..n], &row[..n], &row[1..][..n], &row[2..][..n], &below[1..][..n]]
}

/// [`Brusselator1dN40`] at t = 10.
const REFERENCE: [&str; 80] = [
    "0.93691334172072728227",
    "3.0796044720685494054",
    "0.87534781779737717856",
    "3.1572375798620696751",
    "0.81660587670359827683",
    "3.2311818165292058573",
    "0.76170267424857242787",
    "3.3000705127606001596",
    "0.71133855252042933238",
    "3.3629349009941918016",
    "0.66590857420326561189",
    "3.4192047041488852226",
    "0.62553963300184634253",
    "3.4686723648752707653",
    "0.59014354668274114497",
    "3.5114339997855617252",
    "0.55947537039030305141",
    "3.547819769248759921",
    "0.53318878985146963628",
    "3.5783238008661903812",
    "0.5108836288756002995",
    "3.6035404340083898631",
    "0.4921433426879174286",
    "3.6241103689040768232",
    "0.47656243937135088377",
    "3.6406778340936948557",
    "0.46376501554148748776",
    "3.6538582610524097356",
    "0.45341615561141031172",
    "3.6642150687644261096",
    "0.44522804110867546647",
    "3.6722438164535031613",
    "0.43896244619891414034",
    "3.6783619818393966479",
    "0.43443100593163595938",
    "3.6829028091069413232",
    "0.43149432833292922487",
    "3.6861119397362960883",
    "0.43006072969389687712",
    "3.6881458284308199114",
    "0.43008512305179957115",
    "3.6890712250840424427",
    "0.43156838300997085082",
    "3.6888652618508230285",
    "0.43455733547166085393",
    "3.687415923591783099",
    "0.43914536335682681365",
    "3.6845229080900125276",
    "0.44547346184755980867",
    "3.6798991098493154456",
    "0.45373140227952057952",
    "3.6731731981621945858",
    "0.46415845786391224414",
    "3.6638940138032409443",
    "0.47704289789284717221",
    "3.6515377798651960607",
    "0.49271917177225457429",
    "3.635519399253132664",
    "0.5115614013468671789",
    "3.615209361735914762",
    "0.53397153173270566431",
    "3.5899579430707004187",
    "0.56036035335506240318",
    "3.5591283405719228705",
    "0.59111974975725971834",
    "3.5221399983799442587",
    "0.62658514157005365635",
    "3.4785224399092822755",
    "0.66698838890323534064",
    "3.4279782615395025809",
    "0.71240350518154041458",
    "3.3704514702947734978",
    "0.76269033148340859728",
    "3.3061942336500538779",
    "0.81744435996907055336",
    "3.2358219109998881993",
    "0.87596327495570265393",
    "3.1603439669004854776",
    "0.93724129620197246747",
    "3.0811583242695847423",
];
