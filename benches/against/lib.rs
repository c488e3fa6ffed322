//! The same problem and the same method in kutta and in two other packages, each asked for its final state.
//! The other packages run as their documentation shows; whichever saves more than the last state is given
//! the leanest output it offers.

use kutta::problems::Problem;

/// A solver under comparison: the state at the end for one tolerance, relative and absolute alike.
pub trait Package {
    const NAME: &'static str;
    fn dp5<P: Problem<Y = [f64; N]>, const N: usize>(problem: P, tolerance: f64) -> Result<[f64; N], String>;
    fn dop853<P: Problem<Y = [f64; N]>, const N: usize>(
        problem: P,
        tolerance: f64,
    ) -> Result<[f64; N], String>;
}

pub struct Kutta;

fn kutta_run<P: Problem<Y = [f64; N]>, const N: usize>(
    problem: P,
    method: impl kutta::Method,
    tolerance: f64,
) -> Result<[f64; N], String> {
    let (t0, t1) = problem.span();
    let f = |t: f64, y: &[f64; N], dy: &mut [f64; N]| problem.rhs(t, y, dy);
    let run = kutta::Ivp::new(f, problem.y0(), t0..t1).rtol(tolerance).atol(tolerance);
    run.with(method).run().map(|s| s.y).map_err(|e| e.to_string())
}

impl Package for Kutta {
    const NAME: &'static str = "kutta";
    fn dp5<P: Problem<Y = [f64; N]>, const N: usize>(problem: P, tolerance: f64) -> Result<[f64; N], String> {
        kutta_run(problem, kutta::methods::Dp54, tolerance)
    }
    fn dop853<P: Problem<Y = [f64; N]>, const N: usize>(
        problem: P,
        tolerance: f64,
    ) -> Result<[f64; N], String> {
        kutta_run(problem, kutta::methods::Dop853, tolerance)
    }
}

pub struct OdeSolvers;

#[derive(Clone)]
struct Nalgebra<P>(P);

impl<P: Problem<Y = [f64; N]>, const N: usize> ode_solvers::System<f64, ode_solvers::SVector<f64, N>>
    for Nalgebra<P>
{
    fn system(&self, t: f64, y: &ode_solvers::SVector<f64, N>, dy: &mut ode_solvers::SVector<f64, N>) {
        self.0.rhs(t, &y.data.0[0], &mut dy.data.0[0])
    }
}

macro_rules! ode_solvers_run {
    ($solver:ident, $beta:expr, $shrink:expr, $grow:expr, $problem:ident, $tolerance:ident) => {{
        let (t0, t1) = $problem.span();
        let y0 = ode_solvers::SVector::from($problem.y0());
        // Every step, not dense output: with a dense spacing that divides the span the last point is wrong.
        let output = ode_solvers::dop_shared::OutputType::Sparse;
        let (h_max, n) = (t1 - t0, 20_000_000);
        let mut run = ode_solvers::$solver::from_param(
            Nalgebra($problem),
            t0,
            t1,
            h_max,
            y0,
            $tolerance,
            $tolerance,
            0.9,
            $beta,
            $shrink,
            $grow,
            h_max,
            0.0,
            n,
            u32::MAX,
            output,
        );
        run.integrate().map_err(|e| e.to_string())?;
        run.y_out().last().map(|y| y.data.0[0]).ok_or("no output".to_string())
    }};
}

impl Package for OdeSolvers {
    const NAME: &'static str = "ode_solvers";
    fn dp5<P: Problem<Y = [f64; N]>, const N: usize>(problem: P, tolerance: f64) -> Result<[f64; N], String> {
        ode_solvers_run!(Dopri5, 0.04, 0.2, 10.0, problem, tolerance)
    }
    fn dop853<P: Problem<Y = [f64; N]>, const N: usize>(
        problem: P,
        tolerance: f64,
    ) -> Result<[f64; N], String> {
        ode_solvers_run!(Dop853, 0.0, 0.333, 6.0, problem, tolerance)
    }
}

pub use others::DifferentialEquations;

mod others {
    use super::{Package, Problem};
    use differential_equations::ode::{OrdinaryNumericalMethod, solve_ode};
    use differential_equations::prelude::*;

    pub struct DifferentialEquations;

    struct System<P>(P);

    impl<P: Problem<Y = [f64; N]>, const N: usize> ODE<f64, [f64; N]> for System<P> {
        fn diff(&self, t: f64, y: &[f64; N], dy: &mut [f64; N]) {
            self.0.rhs(t, y, dy)
        }
    }

    /// Keeps the last state only.
    struct Last<Y>(Option<Y>);

    impl<const N: usize> Solout<f64, [f64; N]> for Last<[f64; N]> {
        fn solout<I: Interpolation<f64, [f64; N]> + ?Sized>(
            &mut self,
            _: f64,
            _: f64,
            y: &[f64; N],
            _: &[f64; N],
            _: &mut I,
            _: &mut Solution<f64, [f64; N]>,
        ) -> ControlFlag<f64, [f64; N]> {
            self.0 = Some(*y);
            ControlFlag::Continue
        }
    }

    fn drive<P: Problem<Y = [f64; N]>, const N: usize>(
        problem: P,
        mut solver: impl OrdinaryNumericalMethod<f64, [f64; N]> + Interpolation<f64, [f64; N]>,
    ) -> Result<[f64; N], String> {
        let ((t0, t1), y0) = (problem.span(), problem.y0());
        let mut last = Last(None);
        solve_ode(&mut solver, &System(problem), t0, t1, &y0, &mut last).map_err(|e| format!("{e:?}"))?;
        last.0.ok_or("no output".to_string())
    }

    impl Package for DifferentialEquations {
        const NAME: &'static str = "differential-equations";
        fn dp5<P: Problem<Y = [f64; N]>, const N: usize>(
            problem: P,
            tolerance: f64,
        ) -> Result<[f64; N], String> {
            drive(problem, ExplicitRungeKutta::dopri5().rtol(tolerance).atol(tolerance).max_steps(20_000_000))
        }
        fn dop853<P: Problem<Y = [f64; N]>, const N: usize>(
            problem: P,
            tolerance: f64,
        ) -> Result<[f64; N], String> {
            drive(problem, ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(20_000_000))
        }
    }
}
