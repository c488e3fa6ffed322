//! Linear systems that mislead: one that turns, one that grows before it falls, one that jumps. All in closed
//! form.

use super::{Problem, each};

/// ```text
/// y1' = -10 (y1 - cos t) - 1000 (y2 - sin t) - sin t
/// y2' = 1000 (y1 - cos t) - 10 (y2 - sin t) + cos t,  y(0) = (1, 0),  0 <= t <= 10;  y = (cos t, sin t)
/// ```
///
/// The eigenvalues are -10 + 1000 i and -10 - 1000 i: near the imaginary axis, where BDF from order 3 on is
/// unstable.
#[derive(Clone, Copy, Debug, Default)]
pub struct StiffOscillator;

impl Problem for StiffOscillator {
    type Y = [f64; 2];
    const NAME: &'static str = "stiff-oscillator";
    const ABOUT: &'static str =
        "follows a circle with a pull that turns at 1000: eigenvalues near the imaginary axis";
    const SOURCE: &'static str = "after Prothero, Robinson 1974, with complex lambda: Hairer, Wanner II, V.1";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, t: f64, [x, y]: &Self::Y, dy: &mut Self::Y) {
        let (sin, cos) = t.sin_cos();
        let (x, y) = (x - cos, y - sin);
        *dy = [-10.0 * x - 1000.0 * y - sin, 1000.0 * x - 10.0 * y + cos];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-10.0, -1000.0], [1000.0, -10.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-0.839071529076452452258863947824", "-0.544021110889369813404747661851"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some([t.cos(), t.sin()])
    }
}

/// ```text
/// y1' = -y1 + 1e6 y2,  y2' = -1000 y2,  y(0) = (0, 1),  0 <= t <= 5
/// y1 = 1e6/999 (exp(-t) - exp(-1000 t)),  y2 = exp(-1000 t)
/// ```
///
/// The eigenvalues say that all falls, and y1 grows a thousandfold first.
#[derive(Clone, Copy, Debug, Default)]
pub struct NonNormal;

impl Problem for NonNormal {
    type Y = [f64; 2];
    const NAME: &'static str = "non-normal";
    const ABOUT: &'static str = "eigenvalues -1 and -1000, yet it grows a thousandfold before it falls";
    const SOURCE: &'static str =
        "Trefethen, Embree 2005, Spectra and Pseudospectra, section 14: transient growth";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [0.0, 1.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 5.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [x, y]: &Self::Y, dy: &mut Self::Y) {
        *dy = [-x + 1e6 * y, -1000.0 * y];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-1.0, 1e6], [0.0, -1000.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["6.74469169077624333997602444760", "3.36969414830891751445003232381e-2172"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let (slow, fast) = ((-t).exp(), (-1000.0 * t).exp());
        Some([1e6 * (slow - fast) / 999.0, fast])
    }
}

/// ```text
/// y' = -50 (y - cos t - s),  s = 0 before t = 1 and 2 from there on,  y(0) = 2500/2501,  0 <= t <= 1.1
/// y = (2500 cos t + 50 sin t)/2501 + s (1 - exp(50 - 50 t))
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Jump;

impl Problem for Jump {
    type Y = [f64; 1];
    const NAME: &'static str = "jump";
    const ABOUT: &'static str = "a stiff pull whose aim jumps at t = 1";
    const SOURCE: &'static str = "after Curtiss, Hirschfelder 1952; jumps: Hairer, Norsett, Wanner I, II.6";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [2500.0 / 2501.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 1.1)
    }
    fn breaks(&self) -> &'static [f64] {
        &[1.0]
    }
    #[inline]
    fn rhs(&self, t: f64, [y]: &Self::Y, dy: &mut Self::Y) {
        let aim = if t < 1.0 { 0.0 } else { 2.0 };
        *dy = [-50.0 * (y - t.cos() - aim)];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-50.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["2.45775588191826856609658134247"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        let gone = if t < 1.0 { 0.0 } else { 2.0 * -(50.0 - 50.0 * t).exp_m1() };
        Some([(2500.0 * t.cos() + 50.0 * t.sin()) / 2501.0 + gone])
    }
}
