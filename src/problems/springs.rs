//! Masses on springs: one free, two damped hard, and a chain to size. All in closed form.

use super::{Problem, SecondOrder, each, sine};

/// ```text
/// x'' = -x,  x(0) = 1,  x'(0) = 0,  0 <= t <= 10;  x = cos t
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct HarmonicOscillator;

impl Problem for HarmonicOscillator {
    type Y = [f64; 2];
    const NAME: &'static str = "harmonic-oscillator";
    const ABOUT: &'static str = "x'' = -x, a mass on a spring: shows gain and loss of energy";
    const SOURCE: &'static str = "Hooke 1678";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [x, v]: &Self::Y, dy: &mut Self::Y) {
        *dy = [*v, -x];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[0.0, 1.0], [-1.0, 0.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-0.839071529076452452258863947824", "0.544021110889369813404747661851"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some([t.cos(), -t.sin()])
    }
}

impl SecondOrder for HarmonicOscillator {
    type X = [f64; 1];

    fn x0(&self) -> Self::X {
        [1.0]
    }
    fn v0(&self) -> Self::X {
        [0.0]
    }
    #[inline]
    fn acceleration(&self, _t: f64, [x]: &Self::X, a: &mut Self::X) {
        *a = [-x];
    }
}

/// A spring of stiffness k with a damper c, on a mass of 1; released from x = 1 at rest.
#[inline]
fn damped(k: f64, c: f64, [x, v]: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [*v, -k * x - c * v];
}

fn damped_jacobian(k: f64, c: f64, add: impl FnMut(usize, usize, f64)) {
    each([[0.0, 1.0], [-k, -c]], add);
}

/// ```text
/// x'' = -k x - c x',  k = 1e6,  c = 1000001,  x(0) = 1,  x'(0) = 0,  0 <= t <= 2
/// x = (1e6 exp(-t) - exp(-1e6 t))/(1e6 - 1)
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct StiffSpringOverdamped;

impl Problem for StiffSpringOverdamped {
    type Y = [f64; 2];
    const NAME: &'static str = "stiff-spring-overdamped";
    const ABOUT: &'static str = "a hard spring in honey: rates 1 and 1e6";
    const SOURCE: &'static str = "the damped oscillator of every mechanics book";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 2.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        damped(1e6, 1000001.0, y, dy);
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        damped_jacobian(1e6, 1000001.0, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["0.135335418572031263925263420236", "-0.135335418572031263925263420236"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let (slow, fast) = ((-t).exp(), (-1e6 * t).exp());
        Some([(1e6 * slow - fast) / 999999.0, 1e6 * (fast - slow) / 999999.0])
    }
}

/// ```text
/// x'' = -k x - c x',  k = 1e6,  c = 20,  x(0) = 1,  x'(0) = 0,  0 <= t <= 1/2
/// x = exp(-10 t) (cos w t + 10/w sin w t),  w = sqrt(1e6 - 100)
/// ```
///
/// 80 swings, of which 1 in 150 of the amplitude is left: stiff to an eye that cares for slow motion only.
#[derive(Clone, Copy, Debug, Default)]
pub struct StiffSpringUnderdamped;

impl Problem for StiffSpringUnderdamped {
    type Y = [f64; 2];
    const NAME: &'static str = "stiff-spring-underdamped";
    const ABOUT: &'static str = "a hard spring that rings 80 times: eigenvalues near the imaginary axis";
    const SOURCE: &'static str = "the damped oscillator of every mechanics book";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 0.5)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        damped(1e6, 20.0, y, dy);
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        damped_jacobian(1e6, 20.0, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-0.00606227897898382630798279583385", "3.00211534733567894900413030669"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let w = 999900f64.sqrt();
        let (sin, cos) = (w * t).sin_cos();
        let left = (-10.0 * t).exp();
        Some([left * (cos + 10.0 / w * sin), -1e6 / w * left * sin])
    }
}

/// A chain of n masses of 1 between two walls, joined by springs of stiffness 1:
///
/// ```text
/// x_i'' = x_(i-1) - 2 x_i + x_(i+1),  x_0 = x_(n+1) = 0,  0 <= t <= 50
/// x_i = sin(i phi) cos(2 sin(phi/2) t),  phi = m pi/(n + 1)
/// ```
///
/// One mode m is plucked, of waves about 12 masses long. The stiffest mode swings four times as fast:
/// accuracy, not stability, sets the step at all but loose tolerances. y holds n positions, n velocities.
#[derive(Clone, Copy, Debug)]
pub struct SpringChain {
    n: usize,
}

impl SpringChain {
    /// A chain of `n` masses, 2 n components.
    ///
    /// # Panics
    /// If n is 0.
    pub fn new(n: usize) -> Self {
        assert!(n > 0, "a chain of springs needs at least one mass");
        Self { n }
    }

    fn mode(&self) -> usize {
        (self.n + 1).div_ceil(6).min(self.n)
    }

    /// sin(i phi)
    fn shape(&self, i: usize) -> f64 {
        sine(i * self.mode(), self.n + 1)
    }

    #[inline]
    fn pull(&self, x: &[f64], a: &mut [f64]) {
        let n = self.n;
        let (x, a) = (&x[..n], &mut a[..n]);
        if n == 1 {
            a[0] = -2.0 * x[0];
            return;
        }
        a[0] = x[1] - 2.0 * x[0];
        for (a, x) in a[1..n - 1].iter_mut().zip(x.windows(3)) {
            *a = x[0] - 2.0 * x[1] + x[2];
        }
        a[n - 1] = x[n - 2] - 2.0 * x[n - 1];
    }
}

impl Problem for SpringChain {
    type Y = Vec<f64>;
    const NAME: &'static str = "spring-chain";
    const ABOUT: &'static str =
        "masses between walls, joined by springs, in one mode of swing; built to size";
    const SOURCE: &'static str = "Lagrange 1788, Mecanique analytique: the loaded string";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        let mut y = self.x0();
        y.extend(self.v0());
        y
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 50.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        let (x, v) = y.split_at(self.n);
        let (dx, a) = dy.split_at_mut(self.n);
        dx.copy_from_slice(v);
        self.pull(x, a);
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, mut add: impl FnMut(usize, usize, f64)) {
        let n = self.n;
        for i in 0..n {
            add(i, n + i, 1.0);
            add(n + i, i, -2.0);
            if i > 0 {
                add(n + i, i - 1, 1.0);
                add(n + i - 1, i, 1.0);
            }
        }
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let w = 2.0 * sine(self.mode(), 2 * (self.n + 1));
        let (sin, cos) = (w * t).sin_cos();
        let place = (1..=self.n).map(|i| self.shape(i) * cos);
        let speed = (1..=self.n).map(|i| -w * self.shape(i) * sin);
        Some(place.chain(speed).collect())
    }
}

impl SecondOrder for SpringChain {
    type X = Vec<f64>;

    fn x0(&self) -> Self::X {
        (1..=self.n).map(|i| self.shape(i)).collect()
    }
    fn v0(&self) -> Self::X {
        vec![0.0; self.n]
    }
    #[inline]
    fn acceleration(&self, _t: f64, x: &Self::X, a: &mut Self::X) {
        self.pull(x, a);
    }
}
