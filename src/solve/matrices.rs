//! What a problem tells of its matrices: the Jacobian of f, its pattern, and the mass matrix.

use super::ivp::{Ivp, Structure};
use super::leg::Pace;
use crate::linear::{Jacobian, Mass, Pattern};
use crate::step::method::Method;
use crate::step::state::{RealOf, State};
use crate::step::system::{System, WithJacobian};

impl<'w, Y: State, S: System<Y>, M: Method, P: Pace> Ivp<'w, Y, S, M, P> {
    /// The derivatives of f: `jacobian(t, y, j)` writes df_i/dy_k into `j[(i, k)]`, zeros left out. Methods with
    /// implicit stages take differences of f where there is none.
    pub fn jacobian<J>(self, jacobian: J) -> Ivp<'w, Y, WithJacobian<S, J>, M, P>
    where
        J: FnMut(RealOf<Y>, &Y, &mut Jacobian<Y::Scalar>),
    {
        self.with_jacobian(jacobian, false)
    }

    /// A matrix near df/dy, in the form of [`jacobian`](Self::jacobian): one of the past, one without the couplings
    /// that make it dear. Implicit methods that iterate correct it, in more iterations and smaller steps the farther
    /// it is off. A Rosenbrock method takes it where its table is proven to keep its orders with any matrix, as
    /// `Ros34pw2`, `Ros2` and `Rosenbrock23Shampine` do (W-methods: Steihaug, Wolfbrandt 1979); others are refused,
    /// and so is a singular mass matrix. df/dt is taken as ever; no order rests on that either. Stability is that of
    /// the matrix: one that leaves out what is stiff costs small steps.
    ///
    /// ```
    /// use kutta::{methods::Ros34pw2, solve};
    ///
    /// // A stiff decay, weakly coupled: the matrix leaves the coupling out.
    /// let f = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-1e4 * y[0] + y[1], y[0] - y[1] * y[1]];
    /// let run = solve(f, [1.0, 1.0], 0.0..1.0)
    ///     .with(Ros34pw2)
    ///     .approximate_jacobian(|_t, y, j| {
    ///         j[(0, 0)] = -1e4;
    ///         j[(1, 1)] = -2.0 * y[1];
    ///     })
    ///     .run()?;
    /// assert!((run.y[1] - 0.5).abs() < 1e-3);
    /// # Ok::<(), kutta::Stopped<[f64; 2]>>(())
    /// ```
    pub fn approximate_jacobian<J>(self, jacobian: J) -> Ivp<'w, Y, WithJacobian<S, J>, M, P>
    where
        J: FnMut(RealOf<Y>, &Y, &mut Jacobian<Y::Scalar>),
    {
        self.with_jacobian(jacobian, true)
    }

    fn with_jacobian<J>(self, jacobian: J, approximate: bool) -> Ivp<'w, Y, WithJacobian<S, J>, M, P> {
        let Self { system, y0, v0, span, method, options, pace } = self;
        let system = WithJacobian { system, jacobian, approximate };
        Ivp { system, y0, v0, span, method, options, pace }
    }

    /// The entries of df/dy that can be other than zero: large systems are then solved banded or sparse, and
    /// differences of f are taken for many columns at once.
    pub fn pattern(mut self, pattern: Pattern) -> Self {
        self.options.structure = Structure::Given(pattern);
        self
    }

    /// Finds the pattern of the Jacobian by trying, with three evaluations of f a component. It misses an entry
    /// that is zero at y0 and at two points beside it: where f has such, give the pattern.
    pub fn detect_pattern(mut self) -> Self {
        self.options.structure = Structure::Detected;
        self
    }

    /// M y' = f(t, y): `mass(m)` writes M's entries into `m[(i, k)]`, zeros left out. M is constant and may be
    /// singular, where the algebraic equations that it leaves determine the rest of y (index 1). For methods with
    /// implicit stages.
    ///
    /// ```
    /// use kutta::{methods::Rodas5p, solve};
    ///
    /// // y' = -z, 0 = z - y.
    /// let f = |_t: f64, y: &[f64; 2], dy: &mut [f64; 2]| *dy = [-y[1], y[1] - y[0]];
    /// let run = solve(f, [1.0, 1.0], 0.0..1.0).with(Rodas5p).mass(|m| m[(0, 0)] = 1.0).run()?;
    /// assert!((run.y[1] - (-1f64).exp()).abs() < 1e-6);
    /// # Ok::<(), kutta::Stopped<[f64; 2]>>(())
    /// ```
    pub fn mass(mut self, mass: impl FnOnce(&mut Mass<Y::Scalar>)) -> Self {
        let mut entries = Mass::zero(self.y0.as_slice().len());
        mass(&mut entries);
        self.options.mass = Some(entries.constant());
        self
    }

    /// Changes y0 until the algebraic equations of M y' = f(t, y) hold, M y0 held. Else a start that breaks them by
    /// more than the tolerance is refused.
    pub fn consistent(mut self) -> Self {
        self.options.mend = true;
        self
    }
}
