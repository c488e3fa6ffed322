//! One component that is pulled towards a slow curve; all in closed form.

use super::{Problem, each};

/// ```text
/// y' = -y,  y(0) = 1,  0 <= t <= 10;  y = exp(-t)
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ExponentialDecay;

impl Problem for ExponentialDecay {
    type Y = [f64; 1];
    const NAME: &'static str = "exponential-decay";
    const ABOUT: &'static str = "y' = -y, the first example of every book";
    const SOURCE: &'static str = "Dahlquist 1963, BIT 3, 27: the test equation with lambda = -1";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [1.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y]: &Self::Y, dy: &mut Self::Y) {
        *dy = [-y];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-1.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["4.53999297624848515355915155606e-5"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some([(-t).exp()])
    }
}

/// ```text
/// y' = lambda (y - cos t) - sin t,  lambda = -1e6,  y(0) = 1,  0 <= t <= 10;  y = cos t
/// ```
///
/// The solution does not know lambda, but the errors of stages do: the order falls to the stage order.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProtheroRobinson;

impl Problem for ProtheroRobinson {
    type Y = [f64; 1];
    const NAME: &'static str = "prothero-robinson";
    const ABOUT: &'static str = "follows cos t with a pull of 1e6: shows order reduction";
    const SOURCE: &'static str = "Prothero, Robinson 1974, Math. Comp. 28, 145";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [1.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, t: f64, [y]: &Self::Y, dy: &mut Self::Y) {
        let (sin, cos) = t.sin_cos();
        *dy = [-1e6 * (y - cos) - sin];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-1e6]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-0.839071529076452452258863947824"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some([t.cos()])
    }
}

/// ```text
/// y' = -50 (y - cos t),  y(0) = 0,  0 <= t <= 3/2;  y = (2500 cos t + 50 sin t - 2500 exp(-50 t))/2501
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct CurtissHirschfelder;

impl Problem for CurtissHirschfelder {
    type Y = [f64; 1];
    const NAME: &'static str = "curtiss-hirschfelder";
    const ABOUT: &'static str = "the first stiff equation: a fast start, then nearly cos t";
    const SOURCE: &'static str =
        "Curtiss, Hirschfelder 1952, Proc. Nat. Acad. Sci. 38, 235; Hairer, Wanner II, IV.1";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 1.5)
    }
    #[inline]
    fn rhs(&self, t: f64, [y]: &Self::Y, dy: &mut Self::Y) {
        *dy = [-50.0 * (y - t.cos())];
    }
    fn jacobian(&self, _t: f64, _y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-50.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["0.0906508410633586552449263483178"]
    }
    fn exact(&self, t: f64) -> Option<Self::Y> {
        Some([(2500.0 * t.cos() + 50.0 * t.sin() - 2500.0 * (-50.0 * t).exp()) / 2501.0])
    }
}
