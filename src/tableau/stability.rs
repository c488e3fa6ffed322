//! Linear stability: what a step makes of y' = lambda y, or of y'' = -omega^2 y.
//!
//! With F_j = z Y_j, z being h lambda or -(h omega)^2, a step multiplies what is carried by
//! M(z) = V + z B (I - z A)^-1 U. It is stable where no eigenvalue w of M(z) lies outside the unit disc and
//! those on its border are simple. One polynomial in w and z has them all as roots; for a one-step method it
//! is Q(z) w - P(z), R = P/Q being the stability function (Hairer, Wanner II, IV.3 and V.1).

use super::double_double::DoubleDouble as D;
use super::evidence::{Evidence, bounded_on_the_axis, right_of_the_axis};
use super::form::{Form, Row};
use super::{Array, Steps};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// A number x + i y.
#[derive(Clone, Copy)]
pub(super) struct Complex(pub D, pub D);

impl Complex {
    const ZERO: Complex = Complex(D::ZERO, D::ZERO);
    const ONE: Complex = Complex(D::ONE, D::ZERO);

    fn conjugate(self) -> Complex {
        Complex(self.0, -self.1)
    }

    fn times(self, a: D) -> Complex {
        Complex(a * self.0, a * self.1)
    }

    /// |z|^2
    fn square(self) -> D {
        self.0 * self.0 + self.1 * self.1
    }

    fn over(self, o: Complex) -> Complex {
        (self * o.conjugate()).times(D::ONE / o.square())
    }
}

impl Add for Complex {
    type Output = Complex;
    fn add(self, o: Complex) -> Complex {
        Complex(self.0 + o.0, self.1 + o.1)
    }
}

impl Sub for Complex {
    type Output = Complex;
    fn sub(self, o: Complex) -> Complex {
        Complex(self.0 - o.0, self.1 - o.1)
    }
}

impl Mul for Complex {
    type Output = Complex;
    fn mul(self, o: Complex) -> Complex {
        Complex(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
}

/// sum p_k z^k
fn horner(p: &[D], z: Complex) -> Complex {
    p.iter().rev().fold(Complex::ZERO, |sum, &a| sum * z + Complex(a, D::ZERO))
}

/// All roots of sum p_k w^k lie in the unit disc, those on its border being simple; with `border` false none
/// may lie there. Schur's reduction, as in `roots`, for complex coefficients; a NaN is unstable.
fn inside(mut p: Vec<Complex>, mut border: bool, near: f64) -> bool {
    while let Some(lead) = p.pop().filter(|_| !p.is_empty()) {
        let p1: Vec<_> = p.iter().map(|&a| a.over(lead)).chain([Complex::ONE]).collect();
        let (n, last) = (p.len(), p1[0]);
        let gap = (last.square() - D::ONE).hi();
        if gap < -near {
            p = (0..n).map(|i| p1[i + 1] - last * p1[n - 1 - i].conjugate()).collect();
        } else {
            // All roots lie on the border or none of the demands holds: then p is its own mirror image, and
            // the roots of its derivative lie inside but for the double ones (Miller 1971).
            let mirrored = |i: usize| (p1[i] - last * p1[n - i].conjugate()).square().hi().sqrt();
            let bound = |i: usize| near * (1.0 + p1[i].square().hi().sqrt());
            if !(border && gap <= near && (0..n).all(|i| mirrored(i) <= bound(i))) {
                return false;
            }
            p = (0..n).map(|i| p1[i + 1].times(D::of_integer(i as i64 + 1))).collect();
            border = false;
        }
    }
    true
}

type Matrix = Vec<Vec<D>>;

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = b.first().map_or(0, Vec::len);
    let entry = |row: &[D], j: usize| {
        row.iter().zip(b).filter(|(x, _)| x.hi() != 0.0).fold(D::ZERO, |sum, (&x, b)| sum + x * b[j])
    };
    a.iter().map(|row| (0..columns).map(|j| entry(row, j)).collect()).collect()
}

fn identity(n: usize) -> Matrix {
    (0..n).map(|i| (0..n).map(|j| if i == j { D::ONE } else { D::ZERO }).collect()).collect()
}

/// Faddeev and Leverrier: the coefficients of det(I - z A), and N_m of det(I - z A) (I - z A)^-1 = sum z^m N_m.
fn resolvent(a: &Matrix) -> (Vec<D>, Vec<Matrix>) {
    let s = a.len();
    let (mut q, mut n) = (vec![D::ONE], vec![]);
    let mut last = identity(s);
    for m in 1..=s {
        n.push(last.clone());
        last = times(a, &last);
        let trace = (0..s).fold(D::ZERO, |sum, i| sum + last[i][i]);
        let qm = -trace / D::of_integer(m as i64);
        (0..s).for_each(|i| last[i][i] += qm);
        q.push(qm);
    }
    // An explicit stage makes the determinant of A zero, but for rounding.
    let largest = q.iter().map(|q| q.abs().hi()).fold(0.0, f64::max);
    while q.last().is_some_and(|q| q.abs().hi() < 1e-20 * largest) {
        q.pop();
    }
    (q, n)
}

/// The coefficient of w^k is c_k(z) q(z)^k.
pub(super) struct Characteristic {
    q: Vec<D>,
    c: Vec<Vec<D>>,
}

impl Characteristic {
    pub fn of(form: &Form) -> Self {
        let weights = |row: &Row, own: usize| {
            let mut weights = vec![D::ZERO; form.r + form.s];
            row.base.into_iter().for_each(|j| weights[j] += D::ONE);
            (0..row.len).for_each(|j| weights[row.at[j]] += row.a[j]);
            weights[own] += row.diagonal;
            weights
        };
        let halves = |weights: Vec<D>| (weights[..form.r].to_vec(), weights[form.r..].to_vec());
        let stage = |i: usize| halves(weights(&form.stage[i], form.r + i));
        let (u, a) = (0..form.s).map(stage).unzip();
        let (v, b) = form.carry[..form.r].iter().map(|row| halves(weights(row, 0))).unzip();
        Self::new(&a, &u, &b, v)
    }

    /// A partitioned pair on q' = p, p' = -omega^2 q: without the stages of p it is a Nystrom method with A
    /// times the other A.
    pub fn of_pair(position: &Array, velocity: &Array) -> Self {
        let n = position.stages;
        let rows = |array: &Array| -> Matrix { array.a[..n].iter().map(|row| row[..n].to_vec()).collect() };
        let (a, one) = (rows(position), vec![vec![D::ONE]; n]);
        let b = vec![position.b[..n].to_vec()];
        let u = times(&a, &one).iter().map(|c| vec![D::ONE, c[0]]).collect();
        let v = vec![vec![D::ONE, times(&b, &one)[0][0]], vec![D::ZERO, D::ONE]];
        let hat = rows(velocity);
        let b = vec![times(&b, &hat).remove(0), velocity.b[..n].to_vec()];
        Self::new(&times(&a, &hat), &u, &b, v)
    }

    fn new(a: &Matrix, u: &Matrix, b: &Matrix, v: Matrix) -> Self {
        let (q, n) = resolvent(a);
        let (s, r) = (a.len(), v.len());
        // Without a denominator, det(w I - M(z)) has the degree of the rank of M(z) - V; else q(z) is a factor
        // of it and was not divided out.
        let degree = if q.len() == 1 { s } else { r * s };
        // w[i][j] is the polynomial q(z) M(z).
        let polynomial = |v: &D| q.iter().map(|q| *q * *v).collect::<Vec<_>>();
        let mut w: Vec<Vec<Vec<D>>> = v.iter().map(|row| row.iter().map(polynomial).collect()).collect();
        for (m, n) in n.iter().enumerate() {
            for (w, product) in w.iter_mut().zip(times(b, &times(n, u))) {
                for (w, x) in w.iter_mut().zip(product) {
                    w.resize(w.len().max(m + 2), D::ZERO);
                    w[m + 1] += x;
                }
            }
        }
        // Faddeev and Leverrier again, over polynomials in z.
        let mut c = vec![vec![]; r + 1];
        c[r] = vec![D::ONE];
        let mut adj: Vec<Vec<Vec<D>>> = vec![vec![vec![]; r]; r];
        for k in 1..=r {
            let mut next = adj.clone();
            for (i, row) in next.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    *entry = if i == j { c[r - k + 1].clone() } else { vec![] };
                    (0..r).for_each(|l| add_product(entry, &w[i][l], &adj[l][j], degree));
                }
            }
            adj = next;
            let mut trace = vec![];
            (0..r).for_each(|i| (0..r).for_each(|l| add_product(&mut trace, &w[i][l], &adj[l][i], degree)));
            c[r - k] = trace.iter().map(|x| -*x / D::of_integer(k as i64)).collect();
        }
        Self { q, c }
    }

    /// The polynomial in w.
    pub fn at(&self, z: Complex) -> Vec<Complex> {
        let (q, mut power) = (horner(&self.q, z), Complex::ONE);
        let mut coefficient = |c: &Vec<D>| {
            let x = horner(c, z) * power;
            power = power * q;
            x
        };
        self.c.iter().map(&mut coefficient).collect()
    }

    pub fn stable(&self, z: Complex, near: f64) -> bool {
        inside(self.at(z), true, near)
    }

    /// How far the stable stretch of a ray from 0 reaches; 0 where it is unstable from `least` on.
    fn reach(&self, ray: impl Fn(f64) -> Complex, least: f64, near: f64) -> f64 {
        const FARTHEST: f64 = 1e6;
        let stable = |x: f64| self.stable(ray(x), near);
        let (mut good, mut bad) = (0.0, least);
        while stable(bad) {
            if bad > FARTHEST {
                return f64::INFINITY;
            }
            (good, bad) = (bad, 1.01 * bad);
        }
        // Halved until the two are neighbours.
        while good > 0.0 && good < 0.5 * (good + bad) && 0.5 * (good + bad) < bad {
            let middle = 0.5 * (good + bad);
            if stable(middle) { good = middle } else { bad = middle }
        }
        good
    }

    /// The largest x up to which -x is stable.
    pub fn real(&self, near: f64) -> f64 {
        self.reach(|x| Complex(D::of(-x), D::ZERO), 1e-4, near)
    }

    /// The largest y up to which i y is stable.
    ///
    /// There |w| differs from 1 by a power of y that no arithmetic resolves close to 0. It starts where
    /// double-double does: the more carefully the smaller the region may be.
    pub fn imaginary(&self, near: f64) -> f64 {
        let least = if self.c.len() > 2 { 1.0 / 256.0 } else { 1.0 / 32.0 };
        self.reach(|y| Complex(D::ZERO, D::of(y)), least, near)
    }

    /// How far the ray that makes this angle with the negative real axis is stable.
    pub fn along(&self, degrees: f64, near: f64) -> f64 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        self.reach(|x| Complex(D::of(-x * cos), D::of(x * sin)), 1e-4, near)
    }

    /// The largest h omega up to which y'' = -omega^2 y is stable.
    pub fn oscillation(&self, near: f64) -> f64 {
        self.reach(|y| Complex(-(D::of(y) * D::of(y)), D::ZERO), 1.0 / 32.0, near)
    }

    /// No pole of R lies in the left half-plane or on its border: with z = (1 - w) / (1 + w) the poles are the
    /// roots of a polynomial in w, and these must lie inside the unit disc.
    fn poles_right(&self) -> bool {
        let n = self.q.len() - 1;
        let mut p = vec![D::ZERO; n + 1];
        for (m, q) in self.q.iter().enumerate() {
            let mut term = vec![*q];
            for i in 0..n {
                let mut next = vec![];
                add_product(&mut next, &term, &[D::ONE, D::of(if i < m { -1.0 } else { 1.0 })], n);
                term = next;
            }
            p.iter_mut().zip(term).for_each(|(p, x)| *p += x);
        }
        inside(p.into_iter().map(|x| Complex(x, D::ZERO)).collect(), false, 1e-20)
    }

    /// P of R = P/Q, without powers above that of Q that are rounding. For one-step methods.
    fn numerator(&self, near: f64) -> Vec<D> {
        // Q w - P vanishes.
        let mut p: Vec<D> = self.c[0].iter().map(|&c| -c).collect();
        let rounding = near.max(1e-20) * p.iter().map(|p| p.abs().hi()).fold(0.0, f64::max);
        while p.len() >= self.q.len() && p.last().is_some_and(|p| p.abs().hi() <= rounding) {
            p.pop();
        }
        p
    }

    /// R at infinity, with its sign where it is finite. For one-step methods.
    pub fn at_infinity(&self, near: f64) -> f64 {
        let (p, q) = (self.numerator(near), &self.q);
        match p.len().cmp(&q.len()) {
            Ordering::Less => 0.0,
            Ordering::Equal => (p[p.len() - 1] / q[q.len() - 1]).hi(),
            Ordering::Greater => f64::INFINITY,
        }
    }

    /// The angle in degrees of the largest sector about the negative real axis that is stable, and how it is known; 90
    /// for an A-stable method. It suffices to look at its two rays: |R| is largest on the border. For one-step methods
    /// of some order.
    pub fn angle(&self, order: usize, near: f64) -> (f64, Evidence) {
        const WIDTH: f64 = 1e-4;
        // A point that is not stable proves that.
        if !self.poles_right() || self.at_infinity(near).abs() > 1.0 + 1e-9 || self.real(near).is_finite() {
            return (0.0, Evidence::Proven);
        }
        if bounded_on_the_axis(&self.numerator(near), &self.q, order, near) {
            return (90.0, Evidence::Proven);
        }
        let found = Evidence::Found { degrees: WIDTH };
        if self.imaginary(near) == f64::INFINITY {
            return (90.0, found);
        }
        let stable = |degrees: f64| self.along(degrees, near) == f64::INFINITY;
        let (mut good, mut bad) = (0.0, 90.0);
        while bad - good > WIDTH {
            let middle = 0.5 * (good + bad);
            if stable(middle) { good = middle } else { bad = middle }
        }
        (good, found)
    }
}

/// sum += a b, without powers above the degree.
fn add_product(sum: &mut Vec<D>, a: &[D], b: &[D], degree: usize) {
    for (i, &a) in a.iter().enumerate().filter(|(_, a)| a.hi() != 0.0) {
        for (j, &b) in b.iter().enumerate().take(degree + 1 - i.min(degree + 1)) {
            sum.resize(sum.len().max(i + j + 1), D::ZERO);
            sum[i + j] += a * b;
        }
    }
}

/// rho and sigma of a linear multistep method.
pub(super) struct Locus {
    rho: Vec<D>,
    sigma: Vec<D>,
}

impl Locus {
    pub fn of(steps: &Steps) -> Self {
        Self { rho: steps.alpha[..=steps.k].to_vec(), sigma: steps.beta[..=steps.k].to_vec() }
    }

    /// The largest modulus of a root of sigma: the amplification at infinity.
    pub fn at_infinity(&self) -> f64 {
        let lead = self.sigma.last().map_or(1.0, |x| x.abs().hi());
        let within = |radius: f64| {
            let (mut power, mut p) = (D::ONE, vec![]);
            for &x in &self.sigma {
                p.push(Complex(x * power, D::ZERO));
                power *= D::of(radius);
            }
            inside(p, false, 0.0)
        };
        if self.sigma[..self.sigma.len() - 1].iter().all(|x| x.hi() == 0.0) {
            return 0.0;
        }
        let (mut good, mut bad) = (1.0 + self.sigma.iter().map(|x| x.abs().hi() / lead).sum::<f64>(), 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (good + bad);
            if within(middle) { good = middle } else { bad = middle }
        }
        good
    }

    /// Half the angle in degrees, about the negative real axis, of the sector that the locus z = rho / sigma
    /// of w on the unit circle leaves free: that of A(alpha)-stability, if infinity and the axis are stable.
    pub fn angle(&self, near: f64) -> (f64, Evidence) {
        if right_of_the_axis(&self.rho, &self.sigma, near) {
            return (90.0, Evidence::Proven);
        }
        let angle = |theta: f64| {
            let w = Complex(D::of(theta.cos()), D::of(theta.sin()));
            let z = horner(&self.rho, w).over(horner(&self.sigma, w));
            let (x, y) = (z.0.hi(), z.1.hi().abs());
            // On the border but for rounding.
            if x.is_nan() || x > -1e-13 * y { 90.0 } else { y.atan2(-x).to_degrees() }
        };
        const POINTS: usize = 4000;
        let step = std::f64::consts::PI / POINTS as f64;
        let sharpest = (1..POINTS).min_by(|&i, &j| angle(i as f64 * step).total_cmp(&angle(j as f64 * step)));
        let (mut middle, mut width) = (sharpest.unwrap_or(1) as f64 * step, step);
        for _ in 0..40 {
            width *= 0.7;
            for x in [middle - width, middle + width] {
                if angle(x) < angle(middle) {
                    middle = x;
                }
            }
        }
        // The last steps are of 5e-10 about a minimum, where the angle changes with their square.
        (angle(middle), Evidence::Found { degrees: 1e-9 })
    }
}
