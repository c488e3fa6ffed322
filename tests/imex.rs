//! IMEX pairs: f in two parts, one solved for and one evaluated.

use kutta::tableau::{DoubleDouble as D, Scheme};
use kutta::{Ivp, Jacobian, Loaded, Method, OutOfDomain, System, Why, methods, solve, solve_split};

fn pairs() -> Vec<Loaded> {
    let imex = methods::all().iter().filter(|m| matches!(m.tableau().scheme, Scheme::Imex { .. }));
    imex.map(|m| Loaded::parse(m.name, m.text).unwrap()).collect()
}

/// u = 1/sqrt(1 + t^2) and w = t u solve u' = -t u^3, w' = u (1 - w^2); what is added to one part and taken from
/// the other lets every mixed product of derivatives take part.
fn miss(method: &Loaded, steps: usize) -> f64 {
    let n = D::of;
    let add = |t: D, [u, w]: [D; 2]| [u * w - t * u, w * w * u + t * t * w];
    let stiff = |t: D, y: &[D; 2], dy: &mut [D; 2]| {
        let g = add(t, *y);
        *dy = [-(t * y[0].powi(3)) + g[0], g[1]];
    };
    let nonstiff = |t: D, y: &[D; 2], dy: &mut [D; 2]| {
        let g = add(t, *y);
        *dy = [-g[0], y[0] * (n(1.0) - y[1] * y[1]) - g[1]];
    };
    let (end, h) = (n(1.5), n(1.5) / n(steps as f64));
    let ivp = solve_split(stiff, nonstiff, [n(1.0), n(0.0)], n(0.0)..end);
    let run = ivp.with(method.clone()).step(h).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
    let u = n(1.0) / (n(1.0) + end * end).sqrt();
    let off = |x: D, y: D| (x - y).hi().abs();
    off(run.y[0], u).max(off(run.y[1], end * u))
}

#[test]
fn every_pair_has_its_order_on_two_coupled_parts() {
    assert!(pairs().len() >= 4, "{}", pairs().len());
    for method in pairs() {
        let order = (miss(&method, 64) / miss(&method, 128)).log2();
        let claimed = method.form().order as f64;
        assert!((order - claimed).abs() < 0.25, "{}: order {order:.2}, not {claimed}", method.name());
    }
}

/// y' = -1e5 (y - cos t) - sin t, the fast part stiff.
struct Pulled {
    stiff_jacobians: u64,
}

impl System<[f64; 1]> for Pulled {
    fn rhs(&mut self, t: f64, y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
        dy[0] = -1e5 * (y[0] - t.cos()) - t.sin();
        Ok(())
    }
    fn is_split(&self) -> bool {
        true
    }
    fn stiff(&mut self, t: f64, y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
        dy[0] = -1e5 * (y[0] - t.cos());
        Ok(())
    }
    fn stiff_jacobian(&mut self, _t: f64, _y: &[f64; 1], j: &mut Jacobian<f64>) -> bool {
        self.stiff_jacobians += 1;
        j[(0, 0)] = -1e5;
        true
    }
    fn nonstiff(&mut self, t: f64, _y: &[f64; 1], dy: &mut [f64; 1]) -> Result<(), OutOfDomain> {
        dy[0] = -t.sin();
        Ok(())
    }
}

#[test]
fn a_stiff_part_asks_for_no_small_steps() {
    for method in pairs() {
        for tol in [1e-4, 1e-6, 1e-8] {
            let ivp = Ivp::new(Pulled { stiff_jacobians: 0 }, [1.0], 0.0..10.0).with(method.clone());
            let run = ivp.rtol(tol).atol(tol).run().unwrap_or_else(|e| panic!("{}: {e}", method.name()));
            let off = (run.y[0] - 10f64.cos()).abs();
            // Of thousands of steps each leaves what its iteration leaves.
            assert!(off < 30.0 * tol, "{}: off by {off:e} at {tol:e}", method.name());
            // Stability would ask an explicit method for 4e5 steps.
            assert!(run.stats.accepted < 40_000, "{} at {tol:e}: {:?}", method.name(), run.stats);
            assert!(run.stats.jacobians > 0 && run.stats.jacobians < 100, "{:?}", run.stats);
        }
    }
}

#[test]
fn every_other_method_sees_the_sum() {
    let stiff = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-3.0 * y[0], y[0]];
    let nonstiff = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [t - y[1], 0.5];
    let sum = |t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-3.0 * y[0] + (t - y[1]), y[0] + 0.5];
    let split = solve_split(stiff, nonstiff, [1.0, 0.0], 0.0..2.0).with(methods::Dp54).run().unwrap();
    let whole = solve(sum, [1.0, 0.0], 0.0..2.0).with(methods::Dp54).run().unwrap();
    assert_eq!((split.y, split.stats), (whole.y, whole.stats));
    // Its Jacobian is found by differences: what is given is that of the stiff part.
    let given = |_t: f64, _y: &[f64; 2], j: &mut Jacobian<f64>| {
        (j[(0, 0)], j[(1, 0)]) = (-3.0, 1.0);
    };
    let split = solve_split(stiff, nonstiff, [1.0, 0.0], 0.0..2.0).jacobian(given);
    let split = split.with(methods::Rodas5p).rtol(1e-8).run().unwrap();
    let whole = solve(sum, [1.0, 0.0], 0.0..2.0).with(methods::Rodas5p).rtol(1e-8).run().unwrap();
    assert_eq!((split.y, split.stats), (whole.y, whole.stats));
}

#[test]
fn a_system_in_one_part_is_all_stiff() {
    let vdp = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| {
        *dy = [y[1], 1e3 * ((1.0 - y[0] * y[0]) * y[1]) - y[0]];
    };
    let of = |run: Result<kutta::Solution<[f64; 2]>, kutta::Stopped<[f64; 2]>>| run.unwrap();
    let pair = of(solve(vdp, [2.0, 0.0], 0.0..500.0).with(methods::Kencarp4Imex).rtol(1e-6).run());
    let one = of(solve(vdp, [2.0, 0.0], 0.0..500.0).with(methods::Kencarp4Esdirk).rtol(1e-6).run());
    assert!((pair.y[0] - one.y[0]).abs() < 1e-5 * one.y[0].abs());
    // Each stage of the pair evaluates a zero more.
    assert_eq!(pair.stats.accepted, one.stats.accepted);
}

#[test]
fn either_part_may_refuse_a_point() {
    let stiff = |_t: f64, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0];
    let edge = |t: f64, _y: &[f64; 1], dy: &mut [f64; 1]| {
        dy[0] = 1.0;
        if t > 1.0 { Err(OutOfDomain) } else { Ok(()) }
    };
    for method in pairs() {
        let stop = solve_split(stiff, edge, [1.0], 0.0..2.0).with(method.clone()).run().unwrap_err();
        assert!(matches!(stop.why, Why::OutOfDomain { .. }), "{}: {stop}", method.name());
        assert!(stop.t > 0.99 && stop.t <= 1.0, "{}: {stop}", method.name());
        let stop = solve_split(edge, stiff, [1.0], 0.0..2.0).with(method.clone()).run().unwrap_err();
        assert!(stop.t > 0.99 && stop.t <= 1.0, "{}: {stop}", method.name());
    }
}
