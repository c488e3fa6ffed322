//! Motion in two or three dimensions that repeats, or never quite does.

use super::{Problem, each};

/// ```text
/// x' = sigma (y - x),  y' = x (rho - z) - y,  z' = x y - beta z
/// sigma = 10,  rho = 28,  beta = 8/3,  y(0) = (1, 1, 1),  0 <= t <= 10
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Lorenz63;

const BETA: f64 = 8.0 / 3.0;

impl Problem for Lorenz63 {
    type Y = [f64; 3];
    const NAME: &'static str = "lorenz63";
    const ABOUT: &'static str =
        "convection in a box, chaotic: an error grows tenfold every 2.5 units of time";
    const SOURCE: &'static str = "Lorenz 1963, J. Atmos. Sci. 20, 130";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [1.0, 1.0, 1.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [x, y, z]: &Self::Y, dy: &mut Self::Y) {
        *dy = [10.0 * (y - x), x * (28.0 - z) - y, x * y - BETA * z];
    }
    fn jacobian(&self, _t: f64, [x, y, z]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[-10.0, 10.0, 0.0], [28.0 - z, -1.0, -x], [*y, *x, -BETA]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-4.90268754113464813", "-3.7438729218029188727", "24.690858102790562894"]
    }
}

/// ```text
/// x' = a x - b x y,  y' = -c y + d x y
/// a = 1.5,  b = 1,  c = 3,  d = 1,  y(0) = (1, 1),  0 <= t <= 10
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct LotkaVolterra;

impl Problem for LotkaVolterra {
    type Y = [f64; 2];
    const NAME: &'static str = "lotka-volterra";
    const ABOUT: &'static str = "prey and predators: a closed cycle with sharp peaks";
    const SOURCE: &'static str = "Lotka 1920, Proc. Nat. Acad. Sci. 6, 410; Volterra 1926, Nature 118, 558";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [1.0, 1.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [x, y]: &Self::Y, dy: &mut Self::Y) {
        *dy = [1.5 * x - x * y, -3.0 * y + x * y];
    }
    fn jacobian(&self, _t: f64, [x, y]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[1.5 - y, -x], [*y, x - 3.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["1.0263447675750893191386867265", "0.90969107813604161754824588348"]
    }
}

/// Euler's equations of a free rigid body, y its angular velocity, I = (1/2, 2, 3) its moments of inertia:
///
/// ```text
/// y1' = (I2 - I3)/I1 y2 y3,  y2' = (I3 - I1)/I2 y3 y1,  y3' = (I1 - I2)/I3 y1 y2
/// y(0) = (1, 0, 0.9),  0 <= t <= 12
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct RigidBody;

impl Problem for RigidBody {
    type Y = [f64; 3];
    const NAME: &'static str = "rigid-body";
    const ABOUT: &'static str = "a body tumbling freely; energy and angular momentum stay";
    const SOURCE: &'static str = "Euler 1758; EULR of Hairer, Norsett, Wanner I, II.10, without its force";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [1.0, 0.0, 0.9]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 12.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y1, y2, y3]: &Self::Y, dy: &mut Self::Y) {
        *dy = [-2.0 * y2 * y3, 1.25 * y3 * y1, -0.5 * y1 * y2];
    }
    fn jacobian(&self, _t: f64, [y1, y2, y3]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[0.0, -2.0 * y3, -2.0 * y2], [1.25 * y3, 0.0, 1.25 * y1], [-0.5 * y2, -0.5 * y1, 0.0]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-0.99357571306456226954", "0.089468229026588766098", "0.89821944668212254406"]
    }
}

/// Van der Pol's equation y'' = mu (1 - y^2) y' - y as a system.
#[inline]
fn van_der_pol(mu: f64, [y1, y2]: &[f64; 2], dy: &mut [f64; 2]) {
    *dy = [*y2, mu * (1.0 - y1 * y1) * y2 - y1];
}

fn van_der_pol_jacobian(mu: f64, [y1, y2]: &[f64; 2], add: impl FnMut(usize, usize, f64)) {
    each([[0.0, 1.0], [-2.0 * mu * y1 * y2 - 1.0, mu * (1.0 - y1 * y1)]], add);
}

/// ```text
/// y1' = y2,  y2' = mu (1 - y1^2) y2 - y1,  mu = 1,  y(0) = (2, 0),  0 <= t <= 10
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct VdpMu1;

impl Problem for VdpMu1 {
    type Y = [f64; 2];
    const NAME: &'static str = "vdp-mu1";
    const ABOUT: &'static str = "Van der Pol's oscillator, smooth: every start ends on one cycle";
    const SOURCE: &'static str = "van der Pol 1926, Phil. Mag. 2, 978";
    const STIFF: bool = false;

    fn y0(&self) -> Self::Y {
        [2.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 10.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        van_der_pol(1.0, y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        van_der_pol_jacobian(1.0, y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["-2.008340782579712332780730147", "0.03290706586332406443147170072"]
    }
}

/// ```text
/// y1' = y2,  y2' = mu (1 - y1^2) y2 - y1,  mu = 1000,  y(0) = (2, 0),  0 <= t <= 2000
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct VdpMu1000;

impl Problem for VdpMu1000 {
    type Y = [f64; 2];
    const NAME: &'static str = "vdp-mu1000";
    const ABOUT: &'static str = "Van der Pol's oscillator, relaxing: long creeps and sudden jumps";
    const SOURCE: &'static str = "van der Pol 1926, Phil. Mag. 2, 978; the Bari test set's scaling";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [2.0, 0.0]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 2000.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, y: &Self::Y, dy: &mut Self::Y) {
        van_der_pol(1000.0, y, dy);
    }
    fn jacobian(&self, _t: f64, y: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        van_der_pol_jacobian(1000.0, y, add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["1.706167732170465008478", "-0.0008928097010248165477786"]
    }
}

/// ```text
/// y1' = y2,  y2' = ((1 - y1^2) y2 - y1)/eps,  eps = 1e-6,  y(0) = (2, -0.66),  0 <= t <= 2
/// ```
///
/// The mu = 1000 oscillator with time in units of mu. The reference often printed for it (1.706167732170469,
/// -0.8928097010248125) belongs to y(0) = (2, 0) and differs in the seventh digit.
#[derive(Clone, Copy, Debug, Default)]
pub struct VdpEps1e6;

impl Problem for VdpEps1e6 {
    type Y = [f64; 2];
    const NAME: &'static str = "vdp-eps1e-6";
    const ABOUT: &'static str = "Van der Pol's oscillator with mu = 1000 in slow time: stiffness 1e6";
    const SOURCE: &'static str = "Hairer, Wanner II, IV.10";
    const STIFF: bool = true;

    fn y0(&self) -> Self::Y {
        [2.0, -0.66]
    }
    fn span(&self) -> (f64, f64) {
        (0.0, 2.0)
    }
    #[inline]
    fn rhs(&self, _t: f64, [y1, y2]: &Self::Y, dy: &mut Self::Y) {
        *dy = [*y2, ((1.0 - y1 * y1) * y2 - y1) / 1e-6];
    }
    fn jacobian(&self, _t: f64, [y1, y2]: &Self::Y, add: impl FnMut(usize, usize, f64)) {
        each([[0.0, 1.0], [(-2.0 * y1 * y2 - 1.0) / 1e-6, (1.0 - y1 * y1) / 1e-6]], add);
    }
    fn reference_text(&self) -> &'static [&'static str] {
        &["1.706167437543195403956", "-0.8928100165510993266954"]
    }
}
