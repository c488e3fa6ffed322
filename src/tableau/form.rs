//! The one form: everything that steps is a general linear method (Butcher 1966), generalised by the
//! order `d` of the derivative in `y^(d) = f(t, y)`:
//!
//! ```text
//! Y_i  = sum_j u_ij z_j + sum_j a_ij F_j        F_j = f(t + c_j h, Y_j)      (stages)
//! z'_j = sum_k v_jk z_k + sum_i b_ji F_i                                     (what is carried on)
//! ```
//!
//! Nothing but a Nordsieck array is stored scaled by h: a term carries h to the power (power of its source - power of its
//! target), where y has power 0, v = y' of a second-order equation 1, and f power d.

use super::derive::Stages;
use super::double_double::DoubleDouble as D;
use super::nordsieck::{Corrector, ORDERS};

/// Most stages of a method, those of its dense output included.
pub const STAGES: usize = 20;
/// Most vectors carried from step to step.
pub const CARRIED: usize = 14;
/// Most terms of one row.
pub const TERMS: usize = 24;
/// Highest power of theta in a dense output.
pub const POWERS: usize = 8;

/// What a carried vector stands for at the time t_n of the step about to be taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Meaning {
    /// y at t_n - k h: the state itself (k = 0) or an older one.
    Y(usize),
    /// f at t_n - k h.
    F(usize),
    /// y' of a second-order equation at t_n.
    V,
    /// h^k y^(k) / k! at t_n.
    Taylor(usize),
}

impl Meaning {
    /// The power of h that scales this vector against y.
    pub const fn power(self, d: usize) -> usize {
        match self {
            Meaning::Y(_) | Meaning::Taylor(_) => 0,
            Meaning::V => 1,
            Meaning::F(_) => d,
        }
    }
}

/// One linear combination, zeros left out: `base + sum_j h^power_j a_j x_at_j`.
///
/// Sources are numbered z_0 .. z_(r-1), F_0 .. F_(s-1), then the F of extra dense-output stages.
#[derive(Clone, Copy)]
pub struct Row {
    /// A source of weight one that is added last: the shortest chain, and one rounding against y.
    pub base: Option<usize>,
    pub len: usize,
    pub at: [usize; TERMS],
    pub a: [D; TERMS],
    pub power: [usize; TERMS],
    /// The weight of the row's own F (an implicit stage); zero where the stage is explicit.
    pub diagonal: D,
    /// This output row equals the last stage: its Y is moved, nothing is computed.
    pub last_y: bool,
}

impl Row {
    pub const EMPTY: Row = Row {
        base: None,
        len: 0,
        at: [0; TERMS],
        a: [D::ZERO; TERMS],
        power: [0; TERMS],
        diagonal: D::ZERO,
        last_y: false,
    };

    /// Nothing to compute: the row is one source, moved as it is.
    pub const fn copies(&self) -> bool {
        self.len == 0 && self.base.is_some() && self.diagonal.hi() == 0.0
    }

    /// One more term; a zero is left out.
    pub const fn with(mut self, at: usize, a: D, power: usize) -> Row {
        if a.hi() != 0.0 {
            assert!(self.len < TERMS, "a row has more than 24 terms");
            self.at[self.len] = at;
            self.a[self.len] = a;
            self.power[self.len] = power;
            self.len += 1;
        }
        self
    }

    /// Takes weight one from the first unscaled source that has at least that much and makes it the base.
    pub const fn based(mut self) -> Row {
        let mut j = 0;
        while j < self.len {
            if self.power[j] == 0 && !self.a[j].less(D::ONE) {
                self.base = Some(self.at[j]);
                let rest = self.a[j].minus(D::ONE);
                if rest.hi() == 0.0 {
                    let mut k = j;
                    while k + 1 < self.len {
                        self.at[k] = self.at[k + 1];
                        self.a[k] = self.a[k + 1];
                        self.power[k] = self.power[k + 1];
                        k += 1;
                    }
                    self.len -= 1;
                } else {
                    self.a[j] = rest;
                }
                return self;
            }
            j += 1;
        }
        self
    }

    /// The same sources with the same weights, whatever the order of the terms.
    pub const fn equals(&self, o: &Row) -> bool {
        let same_base = match (self.base, o.base) {
            (Some(i), Some(j)) => i == j,
            (None, None) => true,
            _ => false,
        };
        if !same_base || self.len != o.len {
            return false;
        }
        let mut i = 0;
        while i < self.len {
            let mut j = 0;
            while j < o.len && o.at[j] != self.at[i] {
                j += 1;
            }
            if j == o.len
                || o.power[j] != self.power[i]
                || o.a[j].hi() != self.a[i].hi()
                || o.a[j].lo() != self.a[i].lo()
            {
                return false;
            }
            i += 1;
        }
        self.diagonal.hi() == o.diagonal.hi()
    }
}

/// Orders of a method's three solutions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Orders {
    pub step: usize,
    /// Of each embedded row.
    pub embedded: [usize; 2],
    /// Of the dense output.
    pub dense: usize,
}

/// A method, lowered: what the one stepper runs.
#[derive(Clone, Copy)]
pub struct Form {
    /// Order of the derivative: 1 for y' = f(t, y), 2 for y'' = f(t, y).
    pub d: usize,
    /// Carried vectors; `means[0]` is always `Y(0)`.
    pub r: usize,
    /// Stages, each one evaluation of f.
    pub s: usize,
    pub means: [Meaning; CARRIED],
    pub c: [D; STAGES],
    pub stage: [Row; STAGES],
    pub carry: [Row; CARRIED],
    /// Error rows b - bhat, with no base: none, one, or two.
    pub errors: usize,
    pub error: [Row; 2],
    pub order: usize,
    /// Order of each embedded solution.
    pub embedded: [usize; 2],
    /// Order of the dense output; 0 where the table has none.
    pub dense_order: usize,
    /// Dense output: y(t + theta h) = y + sum_k theta^k (row k-1), rows k = 1 ..= powers, no base.
    pub powers: usize,
    pub dense: [Row; POWERS],
    /// A stage's F solves one linear equation with the Jacobian (Rosenbrock): `(I - h g J) F_i = g (f(Y_i) +
    /// sum_j couple_ij F_j + h time_i df/dt)` with g its diagonal.
    pub linear: bool,
    pub couple: [[D; STAGES]; STAGES],
    pub time: [D; STAGES],
    /// What is left of the orders of a Rosenbrock method with any matrix in place of the Jacobian, and any vector
    /// in place of df/dt: all of them for a W-method. Looked for to order 6.
    pub inexact: Orders,
    /// Stage i evaluates the part of f that is not stiff, of an IMEX pair; all others evaluate the stiff part.
    pub nonstiff: [bool; STAGES],
    /// Extra stages of the dense output; stage s + i evaluates f at c[s + i], row stage[s + i].
    pub extra: usize,
    /// Members of a family of variable order, those of order 1 to this; 0 for every other method.
    pub orders: usize,
    pub correctors: [Corrector; ORDERS],
    /// Every member forgets at infinity what it carries: its corrector is solved by Newton's iteration.
    pub damped: bool,
}

impl Form {
    /// No stages, nothing carried.
    pub const EMPTY: Form = Form {
        d: 1,
        r: 0,
        s: 0,
        means: [Meaning::Y(0); CARRIED],
        c: [D::ZERO; STAGES],
        stage: [Row::EMPTY; STAGES],
        carry: [Row::EMPTY; CARRIED],
        errors: 0,
        error: [Row::EMPTY; 2],
        order: 0,
        embedded: [0; 2],
        dense_order: 0,
        powers: 0,
        dense: [Row::EMPTY; POWERS],
        linear: false,
        couple: [[D::ZERO; STAGES]; STAGES],
        time: [D::ZERO; STAGES],
        inexact: Orders { step: 0, embedded: [0; 2], dense: 0 },
        nonstiff: [false; STAGES],
        extra: 0,
        orders: 0,
        correctors: [Corrector::EMPTY; ORDERS],
        damped: false,
    };

    /// Vectors a stepper holds: z, F | Y, z'.
    pub const fn words(&self) -> usize {
        2 * self.r + self.s + 1
    }

    /// How the stages are found.
    pub const fn stages(&self) -> Stages {
        let (mut explicit, mut i) = (true, 0);
        while i < self.s + self.extra {
            explicit = explicit && self.stage[i].diagonal.hi() == 0.0;
            let mut j = 0;
            while j < self.stage[i].len {
                if self.stage[i].at[j] >= self.r + i {
                    return Stages::Full;
                }
                j += 1;
            }
            i += 1;
        }
        match explicit {
            true => Stages::Explicit,
            false if self.linear => Stages::Linear,
            false => Stages::Diagonal,
        }
    }

    /// The first stage is y itself, so that its slope may be known before the step.
    pub const fn starts_at_y(&self) -> bool {
        self.stage[0].copies() && !matches!(self.stages(), Stages::Full) && !self.split()
    }

    /// The two parts of f are evaluated apart: an IMEX pair.
    pub const fn split(&self) -> bool {
        self.s > 1 && self.nonstiff[1]
    }

    /// The weights of the slopes in y', of a Runge-Kutta method.
    pub fn weights(&self) -> Vec<D> {
        let row = if self.carry[0].last_y { self.stage[self.s - 1] } else { self.carry[0] };
        let mut weights = vec![D::ZERO; self.s];
        (0..row.len).filter(|&j| row.at[j] >= self.r).for_each(|j| weights[row.at[j] - self.r] = row.a[j]);
        if self.carry[0].last_y {
            weights[self.s - 1] = row.diagonal;
        }
        weights
    }

    /// Without embedded rows, but with an estimate made of f at the start and the slopes, which stand at
    /// distinct times after it: those of a fully implicit method.
    pub const fn estimated(&self) -> bool {
        let (mut i, mut apart) = (0, self.errors == 0 && self.r == 1);
        while i < self.s {
            apart = apart && self.c[i].hi() != 0.0;
            let mut j = 0;
            while j < i {
                apart = apart && self.c[i].hi() != self.c[j].hi();
                j += 1;
            }
            i += 1;
        }
        apart && matches!(self.stages(), Stages::Full)
    }

    /// Steps can be chosen from an error estimate.
    pub const fn adaptive(&self) -> bool {
        self.errors > 0 || self.estimated() || self.orders > 0
    }

    /// An explicit form evaluates its stages one after the other.
    pub const fn explicit(&self) -> bool {
        matches!(self.stages(), Stages::Explicit)
    }

    /// Nothing but states at t_n is carried, so the next step may have any size.
    pub const fn one_step(&self) -> bool {
        let mut j = 0;
        while j < self.r {
            match self.means[j] {
                Meaning::Y(0) | Meaning::F(0) | Meaning::V => {}
                _ => return false,
            }
            j += 1;
        }
        true
    }
}
