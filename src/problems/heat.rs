//! Heat that spreads between cold walls: in one and two dimensions, in closed form after the grid is laid.

use super::{Problem, sine};

/// du = c (left - 2 u + right), with 0 beyond both ends.
#[inline]
fn spread(c: f64, u: &[f64], du: &mut [f64]) {
    let n = u.len();
    let du = &mut du[..n];
    if n == 1 {
        du[0] = -2.0 * c * u[0];
        return;
    }
    du[0] = c * (u[1] - 2.0 * u[0]);
    for (du, u) in du[1..n - 1].iter_mut().zip(u.windows(3)) {
        *du = c * (u[0] - 2.0 * u[1] + u[2]);
    }
    du[n - 1] = c * (u[n - 2] - 2.0 * u[n - 1]);
}

/// du = c (the four neighbours - 4 u) in a row of the plane, with 0 beyond both ends.
#[inline]
fn spread_in_plane(c: f64, above: &[f64], row: &[f64], below: &[f64], du: &mut [f64]) {
    let n = du.len();
    let (above, row, below) = (&above[..n], &row[..n], &below[..n]);
    let end = |j: usize, beside: f64| c * (above[j] + below[j] + beside - 4.0 * row[j]);
    if n == 1 {
        du[0] = end(0, 0.0);
        return;
    }
    du[0] = end(0, row[1]);
    du[n - 1] = end(n - 1, row[n - 2]);
    let beyond = above[1..].iter().zip(&below[1..]);
    for ((du, u), (above, below)) in du[1..n - 1].iter_mut().zip(row.windows(3)).zip(beyond) {
        *du = c * (above + below + u[0] + u[2] - 4.0 * u[1]);
    }
}

fn spread_jacobian(c: f64, n: usize, mut add: impl FnMut(usize, usize, f64)) {
    for i in 0..n {
        if i > 0 {
            add(i, i - 1, c);
        }
        add(i, i, -2.0 * c);
        if i + 1 < n {
            add(i, i + 1, c);
        }
    }
}

/// The start 16 x^2 (1 - x)^2 at x = i/(n + 1): a quotient of integers, rounded once while (n + 1)^4 < 2^53.
fn bump(n: usize) -> impl Iterator<Item = f64> {
    let m = (n + 1) as f64;
    (1..=n).map(move |i| 16.0 * (i as f64 * (m - i as f64)).powi(2) / m.powi(4))
}

/// The discrete sine expansion of the solution on n points at t, in n^2 operations:
///
/// ```text
/// u_i = sum over k of b_k sin(k pi i/(n + 1)) exp(-4 (n + 1)^2 sin^2(k pi/(2 (n + 1))) t)
/// b_k = 2/(n + 1) sum over i of u_i(0) sin(k pi i/(n + 1))
/// ```
fn sine_expansion(n: usize, t: f64) -> Vec<f64> {
    let m = n + 1;
    let sines: Vec<f64> = (0..2 * m).map(|k| sine(k, m)).collect();
    let start: Vec<f64> = bump(n).collect();
    let mut u = vec![0.0; n];
    for k in 1..=n {
        let b: f64 = start.iter().zip(1..).map(|(u, i)| u * sines[k * i % (2 * m)]).sum();
        let rate = 2.0 * m as f64 * sine(k, 2 * m);
        let left = 2.0 / m as f64 * b * (-rate * rate * t).exp();
        for (u, i) in u.iter_mut().zip(1..) {
            *u += left * sines[k * i % (2 * m)];
        }
    }
    u
}

/// The heat equation u_t = u_xx on n = 100 inner points of the unit interval, cold at both ends:
///
/// ```text
/// u_i' = (n + 1)^2 (u_(i-1) - 2 u_i + u_(i+1)),  u_0 = u_(n+1) = 0
/// u_i(0) = 16 x^2 (1 - x)^2,  x = i/(n + 1),  0 <= t <= 0.1
/// ```
///
/// Eigenvalues from -10 to -4e4. The reference is the [`Heat1d`] expansion at 60 digits, for the `f64` start
/// and 0.1.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeatN100;

impl Problem for HeatN100 {
    type Y = [f64; 100];
    const NAME: &'static str = "heat-n100";
    const ABOUT: &'static str = "heat in a bar of 100 points between cold ends: the plainest stiff system";
    const SOURCE: &'static str = "Fourier 1822; central differences in space";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        let mut u = [0.0; 100];
        u.iter_mut().zip(bump(100)).for_each(|(u, start)| *u = start);
        u
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 0.1)
    }
    #[inline]
    fn rhs(&self, _t: f64, u: &Self::Y, du: &mut Self::Y) {
        spread(10201.0, u, du);
    }
    fn jacobian(&self, _t: f64, _u: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        spread_jacobian(10201.0, 100, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &REFERENCE
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        sine_expansion(100, t).try_into().ok()
    }
}

/// The heat equation u_t = u_xx on n inner points of the unit interval, cold at both ends:
///
/// ```text
/// u_i' = (n + 1)^2 (u_(i-1) - 2 u_i + u_(i+1)),  u_0 = u_(n+1) = 0
/// u_i(0) = 16 x^2 (1 - x)^2,  x = i/(n + 1),  0 <= t <= 0.1
/// u_i = sum over k of b_k sin(k pi i/(n + 1)) exp(-4 (n + 1)^2 sin^2(k pi/(2 (n + 1))) t)
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Heat1d {
    n: usize,
}

impl Heat1d {
    /// A bar of `n` points.
    ///
    /// # Panics
    /// If n is 0.
    pub fn new(n: usize) -> Self {
        assert!(n > 0, "a bar needs at least one point");
        Self { n }
    }

    fn rate(&self) -> f64 {
        ((self.n + 1) * (self.n + 1)) as f64
    }
}

impl Problem for Heat1d {
    type Y = Vec<f64>;
    const NAME: &'static str = "heat1d";
    const ABOUT: &'static str = "heat in a bar between cold ends; built to size";
    const SOURCE: &'static str = "Fourier 1822; central differences in space";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        bump(self.n).collect()
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 0.1)
    }
    #[inline]
    fn rhs(&self, _t: f64, u: &Self::Y, du: &mut Self::Y) {
        spread(self.rate(), u, du);
    }
    fn jacobian(&self, _t: f64, _u: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        spread_jacobian(self.rate(), self.n, add);
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some(sine_expansion(self.n, t))
    }
}

/// The heat equation u_t = u_xx + u_yy on n * n inner points of the unit square, cold all round:
///
/// ```text
/// u_ij' = (n + 1)^2 (u_(i-1)j + u_(i+1)j + u_i(j-1) + u_i(j+1) - 4 u_ij),  u = 0 beyond the edge
/// u_ij(0) = b(i) b(j),  b(i) = 16 x^2 (1 - x)^2,  x = i/(n + 1),  0 <= t <= 0.1
/// ```
///
/// Start and equation separate, so the solution is the product of two bars of [`Heat1d`]. The state is
/// row by row.
#[derive(Clone, Debug)]
pub struct Heat2d {
    /// A row of zeros, as long as the square: what lies beyond its first and last row.
    wall: Vec<f64>,
}

impl Heat2d {
    /// A square of `n` by `n` points.
    ///
    /// # Panics
    /// If n is 0.
    pub fn new(n: usize) -> Self {
        assert!(n > 0, "a square needs at least one point");
        Self { wall: vec![0.0; n] }
    }

    fn product(bar: &[f64]) -> Vec<f64> {
        bar.iter().flat_map(|u| bar.iter().map(move |v| u * v)).collect()
    }

    fn rate(&self) -> f64 {
        ((self.wall.len() + 1) * (self.wall.len() + 1)) as f64
    }
}

impl Problem for Heat2d {
    type Y = Vec<f64>;
    const NAME: &'static str = "heat2d";
    const ABOUT: &'static str = "heat in a square plate with cold edges; built to size";
    const SOURCE: &'static str = "Fourier 1822; five-point differences in space";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        Self::product(&bump(self.wall.len()).collect::<Vec<_>>())
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 0.1)
    }
    fn rhs(&self, _t: f64, u: &Self::Y, du: &mut Self::Y) {
        let (n, c) = (self.wall.len(), self.rate());
        let mut above = &self.wall[..];
        let mut rows = u.chunks_exact(n).peekable();
        for du in du.chunks_exact_mut(n) {
            let row = rows.next().expect("u is as long as du");
            let below = rows.peek().copied().unwrap_or(&self.wall);
            spread_in_plane(c, above, row, below, du);
            above = row;
        }
    }
    fn jacobian(&self, _t: f64, _u: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        let (n, c) = (self.wall.len(), self.rate());
        for i in 0..n {
            spread_jacobian(c, n, |row, column, value| add(i * n + row, i * n + column, value));
            spread_jacobian(c, n, |row, column, value| add(row * n + i, column * n + i, value));
        }
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some(Self::product(&sine_expansion(self.wall.len(), t)))
    }
}

/// [`HeatN100`] at t = 0.1.
const REFERENCE: [&str; 100] = [
    "0.0103278531528118153507414095949",
    "0.0206457280852694199753713772461",
    "0.0309436561144831210818841499268",
    "0.0412116876242731600800962608437",
    "0.0514399015779761079521057096061",
    "0.0616184150065907624589645797100",
    "0.0717373924640399248582640910696",
    "0.0817870554413219300577340738849",
    "0.0917576917313232427163747979775",
    "0.101639664736061183558939742098",
    "0.111423422708124352164709567798",
    "0.121099507918078063834360446500",
    "0.130658565739603675157044975296",
    "0.140091353644144643765105425749",
    "0.149388750096839206598049376403",
    "0.158541763345530361514809262549",
    "0.167541540094659125833830882312",
    "0.176379374055867574594103202732",
    "0.185046714367164701574647902348",
    "0.193535173872541478627710309114",
    "0.201836537253962397821995181082",
    "0.209942769007710045452034654365",
    "0.217846021257117643510385004430",
    "0.225538641393792748445517662016",
    "0.233013179539514136285629201509",
    "0.240262395821074008973321698442",
    "0.247279267450439667382250824567",
    "0.254056995602723300275767676615",
    "0.260589012084576067121146065736",
    "0.266868985785763675188804508306",
    "0.272890828906835568429283223258",
    "0.278648702955968984543388407637",
    "0.284137024508252746912412832434",
    "0.289350470720873907427217134405",
    "0.294283984597883327692854796828",
    "0.298932779998443975218345401211",
    "0.303292346382708024591055866577",
    "0.307358453289725607763586887655",
    "0.311127154542058978584148351210",
    "0.314594792172060580856268181251",
    "0.317758000065071584174696977924",
    "0.320613707315108338560054303297",
    "0.323159141288927274569972263294",
    "0.325391830394693336626437740925",
    "0.327309606551822303839351911689",
    "0.328910607358922472965687003450",
    "0.330193277957125234259763558370",
    "0.331156372586466084265000549012",
    "0.331798955833356557374055589064",
    "0.332120403567572340280016893603",
    "0.332120403567572340280016893603",
    "0.331798955833356557374055589064",
    "0.331156372586466084265000549012",
    "0.330193277957125234259763558370",
    "0.328910607358922472965687003450",
    "0.327309606551822303839351911689",
    "0.325391830394693336626437740925",
    "0.323159141288927274569972263294",
    "0.320613707315108338560054303297",
    "0.317758000065071584174696977924",
    "0.314594792172060580856268181251",
    "0.311127154542058978584148351210",
    "0.307358453289725607763586887655",
    "0.303292346382708024591055866577",
    "0.298932779998443975218345401211",
    "0.294283984597883327692854796828",
    "0.289350470720873907427217134405",
    "0.284137024508252746912412832434",
    "0.278648702955968984543388407637",
    "0.272890828906835568429283223258",
    "0.266868985785763675188804508306",
    "0.260589012084576067121146065736",
    "0.254056995602723300275767676615",
    "0.247279267450439667382250824567",
    "0.240262395821074008973321698442",
    "0.233013179539514136285629201509",
    "0.225538641393792748445517662016",
    "0.217846021257117643510385004430",
    "0.209942769007710045452034654365",
    "0.201836537253962397821995181082",
    "0.193535173872541478627710309114",
    "0.185046714367164701574647902348",
    "0.176379374055867574594103202732",
    "0.167541540094659125833830882312",
    "0.158541763345530361514809262549",
    "0.149388750096839206598049376403",
    "0.140091353644144643765105425749",
    "0.130658565739603675157044975296",
    "0.121099507918078063834360446500",
    "0.111423422708124352164709567798",
    "0.101639664736061183558939742098",
    "0.0917576917313232427163747979775",
    "0.0817870554413219300577340738849",
    "0.0717373924640399248582640910696",
    "0.0616184150065907624589645797100",
    "0.0514399015779761079521057096061",
    "0.0412116876242731600800962608437",
    "0.0309436561144831210818841499268",
    "0.0206457280852694199753713772461",
    "0.0103278531528118153507414095949",
];
