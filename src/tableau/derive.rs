//! What follows from the numbers of a method, computed and never typed.

use super::criteria::*;
use super::double_double::DoubleDouble as D;
use super::error::TableauError;
use super::evidence::Evidence;
use super::form::Meaning;
use super::inexact::inexact;
use super::lower::{first_is_last, runge_kutta};
use super::prove::prove_to;
use super::roots::zero_stable;
use super::series::{Forms, Solution, defects};
use super::sizes::*;
use super::stability::{Characteristic, Locus};
use super::stiff::{StiffOrder, of_formula, stiff_order};
use super::{Members, Scheme, Tableau};

/// How the stages of a method are found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stages {
    /// One after the other, by an evaluation each.
    Explicit,
    /// One after the other, some by solving an equation for it.
    Diagonal,
    /// All at once.
    Full,
    /// One after the other, by solving a linear equation with the Jacobian (Rosenbrock).
    Linear,
}

/// What is derived of a method. `None` stands where a property does not apply.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct Properties {
    /// `explicit Runge-Kutta`, `splitting`.
    pub family: &'static str,
    pub kind: Stages,
    /// Whether the stepper runs it.
    pub steppable: bool,
    /// Whether it is for y'' = f(t, y).
    pub second_order: bool,
    pub stages: usize,
    /// Evaluations of f per step; an implicit stage takes one for each iteration.
    pub evaluations: usize,
    pub order: usize,
    /// Order of each embedded row.
    pub embedded: Vec<usize>,
    /// Order of the dense output.
    pub dense: Option<usize>,
    /// First same as last: the last stage is evaluated at y', and is the next step's first.
    pub fsal: bool,
    /// The last stage is y', and implicit.
    pub stiffly_accurate: Option<bool>,
    /// Largest q with B(q) and C(q).
    pub stage_order: Option<usize>,
    /// What is left of the order on a stiff problem, of methods with implicit stages; of a pair for f + g where f is
    /// zero. `None` where errors grow.
    pub stiff_order: Option<StiffOrder>,
    /// Norm of the leading coefficients of the local error: the root of the sum, over the trees of the first
    /// order that fails, of (weight less 1/gamma)^2 / sigma^2. With y' carried, of y and y' together.
    pub principal_error: f64,
    /// The same for the solution of each embedded row.
    pub embedded_errors: Vec<f64>,
    /// C_(p+1) / sigma(1) of a linear multistep method; C_(p+2) / sigma(1) for y'' = f.
    pub error_constant: Option<f64>,
    /// The largest x such that h lambda from -x to 0 is stable; infinite where all of them are. Of a pair for
    /// f + g: that of the explicit table.
    pub real_limit: Option<f64>,
    /// The largest y such that h lambda from -i y to i y is stable.
    pub imaginary_limit: Option<f64>,
    /// The largest h omega for y'' = -omega^2 y.
    pub oscillation_limit: Option<f64>,
    /// Of implicit methods; of a pair for f + g: of the implicit table.
    pub a_stable: Option<bool>,
    /// A-stable, and the amplification at infinity is 0.
    pub l_stable: Option<bool>,
    /// A(alpha)-stability: alpha in degrees.
    pub alpha: Option<f64>,
    /// Whether alpha, and with it A- and L-stability, is proven or found.
    pub evidence: Option<Evidence>,
    /// |R| at infinity.
    pub at_infinity: Option<f64>,
    /// The history is not amplified as h goes to 0. Of methods that carry one.
    pub zero_stable: Option<bool>,
    /// The largest miss of an order condition once the coefficients are rounded to f64; relative to the size
    /// of the history where earlier steps are carried.
    pub residual_f64: f64,
    pub residual_f32: f64,
    /// Sum of the absolute weights of the slopes in y'; 1 where none is negative (y' = f).
    pub sum_b: f64,
    /// The largest absolute weight of a slope in a stage.
    pub max_a: f64,
    /// The order that is left of a Rosenbrock method with any matrix in place of the Jacobian: `order` where it is a
    /// W-method (Steihaug, Wolfbrandt 1979). Looked for to order 6.
    pub w_order: Option<usize>,
    /// The same of each embedded row.
    pub w_embedded: Vec<usize>,
    /// Whether each embedded row's estimate is zero for y' = f(t), whatever f.
    pub blind: Vec<bool>,
    /// What a step errs over its first estimate of that, on linear and on stiff equations: above 2 the estimate says
    /// too little there. The larger of that on y' = -y with h = 1/10 and, of implicit stages, on the equation of
    /// Prothero and Robinson with t^k, k the first power missed, over h lambda = -1, -2, -4, -8. Of Runge-Kutta pairs.
    pub estimate_misses: Option<f64>,
    /// Conserves quadratic invariants (pairs and second-order methods: symplectic).
    pub symplectic: Option<bool>,
    /// A composition that reads the same backwards: reversible in time.
    pub symmetric: Option<bool>,
    /// What is derived of each member of a family of variable order, from order 1 on. The other properties are
    /// those of the member of the highest order, the sector of stability that of all.
    pub members: Vec<Member>,
}

/// A member of a family of variable order.
#[derive(Clone, PartialEq, Debug)]
pub struct Member {
    pub order: usize,
    /// Its corrector in Nordsieck form: l_0 .. l_order.
    pub l: Vec<D>,
    /// C_(order+1) / sigma(1).
    pub error_constant: f64,
    /// A(alpha)-stability: alpha in degrees, and how it is known.
    pub alpha: f64,
    pub evidence: Evidence,
    /// The largest root of sigma: the amplification at infinity.
    pub at_infinity: f64,
    /// What is left of its order on a stiff problem; `None` where errors grow.
    pub stiff_order: Option<StiffOrder>,
}

impl Tableau<'_> {
    /// `explicit Runge-Kutta`, `predictor-corrector`, ...
    pub fn family(&self) -> &'static str {
        match (&self.scheme, self.kind()) {
            (Scheme::RungeKutta(_), Stages::Explicit) => "explicit Runge-Kutta",
            (Scheme::RungeKutta(_), Stages::Diagonal) => "diagonally implicit Runge-Kutta",
            (Scheme::RungeKutta(_), _) => "fully implicit Runge-Kutta",
            (Scheme::Imex { .. }, _) => "IMEX pair",
            (Scheme::Partitioned { .. }, _) => "partitioned pair",
            (Scheme::Rosenbrock { .. }, _) => "Rosenbrock",
            (Scheme::Multistep(_), Stages::Explicit) => "explicit multistep",
            (Scheme::Multistep(_), _) => "implicit multistep",
            (Scheme::Nordsieck(_), _) => "variable-order multistep",
            (Scheme::Stormer(_), _) => "Stormer",
            (Scheme::PredictorCorrector { .. }, _) => "predictor-corrector",
            (Scheme::Nystrom { .. }, _) => "Nystrom",
            (Scheme::Splitting(_), _) => "splitting",
        }
    }

    pub fn kind(&self) -> Stages {
        match &self.scheme {
            Scheme::RungeKutta(array) | Scheme::Imex { implicit: array, .. } => kind(&array.a, array.stages),
            Scheme::Partitioned { position, velocity } => kind(&product(position, velocity), position.stages),
            Scheme::Rosenbrock { .. } => Stages::Linear,
            Scheme::Nystrom { array, .. } => kind(&array.a, array.stages),
            Scheme::Multistep(steps) | Scheme::Stormer(steps) if steps.beta[steps.k].hi() != 0.0 => {
                Stages::Diagonal
            }
            Scheme::Nordsieck(_) => Stages::Diagonal,
            _ => Stages::Explicit,
        }
    }

    /// Evaluations of f in a step that shares none with its neighbours.
    pub fn stages(&self) -> usize {
        match &self.scheme {
            Scheme::RungeKutta(array)
            | Scheme::Imex { implicit: array, .. }
            | Scheme::Partitioned { position: array, .. }
            | Scheme::Rosenbrock { alpha: array, .. }
            | Scheme::Nystrom { array, .. } => array.stages,
            Scheme::Multistep(_) | Scheme::Stormer(_) | Scheme::Nordsieck(_) => 1,
            Scheme::PredictorCorrector { evaluates, .. } => 1 + *evaluates as usize,
            Scheme::Splitting(_) => self.form().map_or(0, |form| form.s + fsal(&form) as usize),
        }
    }

    /// The first stage of a Runge-Kutta method is y and the last one y', found together with the others or not.
    fn repeats(&self) -> bool {
        matches!(&self.scheme, Scheme::RungeKutta(array) if first_is_last(array, &array.b, D::ONE))
    }

    /// Whether it is for y'' = f(t, y).
    pub fn second_order(&self) -> bool {
        matches!(
            self.scheme,
            Scheme::Stormer(_) | Scheme::Nystrom { .. } | Scheme::Splitting(_) | Scheme::Partitioned { .. }
        )
    }

    /// Whether the stepper runs it.
    pub fn steppable(&self) -> bool {
        self.steppable_form().is_some()
    }

    /// Proves every claim, to whatever order. [`Tableau::parse`] stops at order 8 (pairs: 6), as the compiler
    /// does.
    ///
    /// # Errors
    /// The condition that fails.
    pub fn prove_all(&self) -> Result<(), TableauError> {
        prove_to(self, usize::MAX)
    }

    /// What follows from the numbers; takes milliseconds.
    pub fn properties(&self) -> Properties {
        let (mut forms, form) = (Forms::of(self), self.form());
        if let Scheme::RungeKutta(array) = &self.scheme {
            // Every stage anew in each step: one vector is carried, and R = P/Q can be read off.
            runge_kutta(self, array, false, &mut forms.form[0]);
            forms.form[1] = forms.form[0];
        }
        let forms = forms;
        let steps_back = matches!(
            self.scheme,
            Scheme::Multistep(_)
                | Scheme::Nordsieck(_)
                | Scheme::Stormer(_)
                | Scheme::PredictorCorrector { .. }
        );
        let first = &forms.form[0];
        let tolerance = self.tolerance();
        let loose = (10.0 * tolerance).max(1e-20);
        let embedded: Vec<usize> = self.embedded.iter().copied().take_while(|&order| order > 0).collect();
        let velocity = first.means[..first.r].contains(&Meaning::V);
        // Where only positions are carried, their difference is h y': they must be right by an order more.
        let lift = (first.d == 2 && !velocity) as usize;
        let mut principal = norm(&defects(&forms, Solution::Step, self.order + 1 + lift));
        if velocity {
            principal = principal.hypot(norm(&defects(&forms, Solution::Velocity, self.order + 2)));
        }
        let embedded_error =
            |(e, order): (usize, &usize)| norm(&defects(&forms, Solution::Embedded(e), order + 1));
        let residual = |round: fn(D) -> D| {
            let defects = defects(&rounded(forms, round), Solution::Step, self.order);
            defects.iter().map(|defect| defect.off.abs().hi() / defect.size).fold(0.0, f64::max)
        };
        let mut all = Properties {
            family: self.family(),
            kind: self.kind(),
            steppable: self.steppable(),
            second_order: self.second_order(),
            stages: self.stages(),
            evaluations: match (&form, self.kind()) {
                // Found together, but the first is the last of the step before.
                (_, Stages::Full) => self.stages() - self.repeats() as usize,
                // Of each part.
                (Some(form), _) if form.split() => self.stages(),
                (Some(form), _) => form.s,
                (None, _) => self.stages(),
            },
            order: self.order,
            dense: (self.dense_order > 0).then_some(self.dense_order),
            fsal: !steps_back && (form.as_ref().is_some_and(fsal) || self.repeats()),
            stiffly_accurate: None,
            stage_order: None,
            stiff_order: None,
            principal_error: principal,
            embedded_errors: embedded.iter().enumerate().map(embedded_error).collect(),
            embedded,
            error_constant: None,
            real_limit: None,
            imaginary_limit: None,
            oscillation_limit: None,
            a_stable: None,
            l_stable: None,
            alpha: None,
            evidence: None,
            at_infinity: None,
            zero_stable: None,
            residual_f64: residual(|x| D::of(x.hi())),
            residual_f32: residual(|x| D::of(f64::from(x.to_f32()))),
            sum_b: amplification(&forms),
            max_a: largest_a(&forms),
            w_order: None,
            w_embedded: vec![],
            blind: vec![],
            estimate_misses: match &self.scheme {
                Scheme::RungeKutta(_) => estimate_misses(first),
                Scheme::Imex { .. } => estimate_misses(&forms.form[1]),
                _ => None,
            },
            symplectic: None,
            symmetric: None,
            members: vec![],
        };
        match &self.scheme {
            Scheme::RungeKutta(array) => {
                let limits = Characteristic::of(first);
                all.limits(&limits, tolerance);
                if all.kind != Stages::Explicit {
                    all.implicit(&limits, tolerance);
                    all.stiff_order = stiff_order(array, None, self.order, limits.at_infinity(loose), loose);
                    all.stiffly_accurate = Some(last_row_is(&array.a, &array.b, array.stages, loose));
                }
                all.stage_order = Some(stage_order(array, loose));
                all.blind = blind(array, None, loose);
                all.symplectic = Some(symplectic(array, array, loose));
            }
            Scheme::Imex { explicit, implicit } => {
                all.limits(&Characteristic::of(first), tolerance);
                let limits = Characteristic::of(&forms.form[1]);
                all.implicit(&limits, tolerance);
                all.stiff_order = stiff_order(implicit, None, self.order, limits.at_infinity(loose), loose);
                all.stiffly_accurate = Some(last_row_is(&implicit.a, &implicit.b, implicit.stages, loose));
                all.blind = blind(explicit, None, loose);
            }
            Scheme::Partitioned { position, velocity } => {
                let limits = Characteristic::of_pair(position, velocity);
                all.oscillation_limit = Some(limits.oscillation(tolerance));
                all.symplectic = Some(symplectic(position, velocity, loose));
            }
            Scheme::Rosenbrock { alpha, gamma } => {
                let limits = Characteristic::of(&forms.form[1]);
                all.implicit(&limits, tolerance);
                all.stiff_order =
                    stiff_order(alpha, Some(gamma), self.order, limits.at_infinity(loose), loose);
                let (mut beta, n) = (alpha.a, alpha.stages);
                (0..n).for_each(|i| (0..n).for_each(|j| beta[i][j] += gamma.a[i][j]));
                let at_end = (sum(&alpha.a[n - 1][..n]) - D::ONE).abs().hi() <= loose;
                all.stiffly_accurate = Some(at_end && last_row_is(&beta, &alpha.b, n, loose));
                all.evaluations = (0..n).filter(|&i| !alpha.a[..i].contains(&alpha.a[i])).count();
                all.blind = blind(alpha, Some(gamma), loose);
                let left = inexact(self, alpha, gamma);
                all.w_order = Some(left.step);
                all.w_embedded = left.embedded[..alpha.lower].to_vec();
            }
            Scheme::Multistep(steps) => {
                let (limits, locus) = (Characteristic::of(first), Locus::of(steps));
                all.limits(&limits, tolerance);
                all.error_constant = Some(error_constant(steps, 1, self.order));
                if all.kind != Stages::Explicit {
                    let (alpha, at_infinity, evidence) = sector(&limits, &locus, tolerance);
                    all.sector(alpha, at_infinity, evidence);
                    all.stiff_order = of_formula(self.order, alpha);
                }
            }
            Scheme::Nordsieck(members) => {
                let (last, limits) = (&members.steps[members.count - 1], Characteristic::of(first));
                all.limits(&limits, tolerance);
                all.error_constant = Some(error_constant(last, 1, self.order));
                all.members = self.members(members, tolerance);
                all.stiff_order = all.members.last().and_then(|m| m.stiff_order);
                let least = all.members.iter().min_by(|a, b| a.alpha.total_cmp(&b.alpha));
                let (alpha, evidence) = least.map_or((0.0, Evidence::Proven), |m| (m.alpha, m.evidence));
                let at_infinity = all.members.iter().map(|m| m.at_infinity).fold(0.0, f64::max);
                all.sector(alpha, at_infinity, evidence);
            }
            Scheme::Stormer(steps) => {
                all.error_constant = Some(error_constant(steps, 2, self.order));
                all.oscillation_limit = Some(Characteristic::of(first).oscillation(tolerance));
            }
            Scheme::PredictorCorrector { .. } => all.limits(&Characteristic::of(first), tolerance),
            Scheme::Nystrom { .. } | Scheme::Splitting(_) => {
                all.oscillation_limit = Some(Characteristic::of(first).oscillation(tolerance));
                all.symplectic = Some(canonical(first, loose));
            }
        }
        if let Scheme::Splitting(splitting) = &self.scheme {
            all.symmetric = Some(palindrome(splitting, loose));
        }
        if steps_back {
            all.zero_stable = Some(zero_stable(first, loose).is_ok());
        }
        all
    }
}

/// Alpha of A(alpha)-stability in degrees, the amplification at infinity, and how they are known, of a multistep
/// formula.
fn sector(limits: &Characteristic, locus: &Locus, near: f64) -> (f64, f64, Evidence) {
    let at_infinity = locus.at_infinity();
    let half_line = limits.real(near) == f64::INFINITY && at_infinity < 1.0 + 1e-9;
    // A point of the axis that is not stable proves that.
    let (alpha, evidence) = if half_line { locus.angle(near) } else { (0.0, Evidence::Proven) };
    (alpha, at_infinity, evidence)
}

impl Tableau<'_> {
    fn members(&self, members: &Members, near: f64) -> Vec<Member> {
        let form = self.form();
        let member = |q: usize| {
            let (steps, limits) = (&members.steps[q - 1], Forms::of(&members.of(self, q)));
            let limits = Characteristic::of(&limits.form[0]);
            let (alpha, at_infinity, evidence) = sector(&limits, &Locus::of(steps), near);
            let l = form.iter().flat_map(|form| form.correctors[q - 1].l[..=q].to_vec()).collect();
            let (error_constant, stiff_order) = (error_constant(steps, 1, q), of_formula(q, alpha));
            Member { order: q, l, error_constant, alpha, evidence, at_infinity, stiff_order }
        };
        (1..=members.count).map(member).collect()
    }
}

impl Properties {
    fn limits(&mut self, characteristic: &Characteristic, near: f64) {
        self.real_limit = Some(characteristic.real(near));
        self.imaginary_limit = Some(characteristic.imaginary(near));
    }

    fn implicit(&mut self, characteristic: &Characteristic, near: f64) {
        let (alpha, evidence) = characteristic.angle(self.order, near);
        self.sector(alpha, characteristic.at_infinity(near).abs(), evidence);
    }

    fn sector(&mut self, alpha: f64, at_infinity: f64, evidence: Evidence) {
        self.alpha = Some(alpha);
        self.evidence = Some(evidence);
        self.at_infinity = Some(at_infinity);
        self.a_stable = Some(alpha == 90.0);
        self.l_stable = Some(alpha == 90.0 && at_infinity < 1e-9);
    }
}
