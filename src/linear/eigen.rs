//! Eigenvalues and eigenvectors of a table's matrix A, to decouple the stages of a fully implicit method.
//!
//! A has a row for each stage, so anything works; the numbers steer Newton's iteration and enter no solution.

use super::lu;
use num_complex::Complex;

type C = Complex<f64>;

/// A = T diag(values) T^-1. Of two conjugate values the one above the real axis is kept, so that
/// `A x = Re sum_k weight_k values_k T_k (T^-1 x)_k` with weight 2 for a pair.
#[derive(Clone, Debug)]
pub struct Eigen {
    /// Real ones first.
    pub values: Vec<C>,
    pub real: usize,
    /// `vectors[i][k]`: component i of eigenvector k.
    pub vectors: Vec<Vec<C>>,
    /// `inverse[k][i]`.
    pub inverse: Vec<Vec<C>>,
}

impl Eigen {
    /// `None` where A has too few eigenvectors.
    pub fn of(a: &[Vec<f64>]) -> Option<Self> {
        let s = a.len();
        let mut roots = roots(&characteristic(a));
        let near = |x: &C| x.im.abs() <= 1e-9 * (1.0 + x.norm());
        roots.iter_mut().filter(|x| near(x)).for_each(|x| x.im = 0.0);
        roots.sort_by(|x, y| y.re.total_cmp(&x.re));
        let real: Vec<C> = roots.iter().filter(|x| x.im == 0.0).copied().collect();
        let above: Vec<C> = roots.iter().filter(|x| x.im > 0.0).copied().collect();
        if real.len() + 2 * above.len() != s {
            return None;
        }
        let values: Vec<C> = real.iter().chain(&above).copied().collect();
        let columns: Option<Vec<Vec<C>>> = values.iter().map(|&value| vector(a, value)).collect();
        let columns = columns?;
        // All columns, the conjugate ones too, to be inverted.
        let all: Vec<Vec<C>> = columns
            .iter()
            .cloned()
            .chain(columns[real.len()..].iter().map(|c| c.iter().map(C::conj).collect()))
            .collect();
        let mut matrix: Vec<C> = all.concat();
        let mut pivots = vec![0; s];
        lu::factor(s, &mut matrix, &mut pivots).ok()?;
        let unit = |j: usize| {
            let mut x = vec![C::ZERO; s];
            x[j] = C::ONE;
            lu::solve(s, &matrix, &pivots, &mut x);
            x
        };
        let inverse: Vec<Vec<C>> = (0..s).map(unit).collect();
        // Vectors that nearly depend on each other are none.
        if inverse.iter().flatten().any(|x| !(x.norm() < 1e8)) {
            return None;
        }
        Some(Self {
            real: real.len(),
            vectors: (0..s).map(|i| columns.iter().map(|c| c[i]).collect()).collect(),
            inverse: (0..values.len()).map(|k| (0..s).map(|i| inverse[i][k]).collect()).collect(),
            values,
        })
    }
}

/// Coefficients of det(x I - A) from x^0 up to x^s (Faddeev, LeVerrier).
fn characteristic(a: &[Vec<f64>]) -> Vec<f64> {
    let s = a.len();
    let mut c = vec![0.0; s + 1];
    c[s] = 1.0;
    let mut m = vec![vec![0.0; s]; s];
    for k in 1..=s {
        // M <- A M + c I, c <- - trace(A M) / k.
        let mut next = vec![vec![0.0; s]; s];
        for i in 0..s {
            for j in 0..s {
                next[i][j] = (0..s).map(|l| a[i][l] * m[l][j]).sum();
            }
            next[i][i] += c[s + 1 - k];
        }
        let trace: f64 = (0..s).map(|i| (0..s).map(|l| a[i][l] * next[l][i]).sum::<f64>()).sum();
        c[s - k] = -trace / k as f64;
        m = next;
    }
    c
}

/// All roots at once, of a polynomial whose leading coefficient is 1 (Aberth 1973, Math. Comp. 27, 339).
pub(crate) fn roots<T: Copy + Into<C>>(c: &[T]) -> Vec<C> {
    let s = c.len() - 1;
    let horner = |x: C| c.iter().rev().fold((C::ZERO, C::ZERO), |(p, d), &a| (p * x + a.into(), d * x + p));
    let radius = 1.0 + c[..s].iter().fold(0.0f64, |m, &x| m.max(x.into().norm()));
    let start = |i: usize| C::from_polar(0.5 * radius, 0.4 + std::f64::consts::TAU * i as f64 / s as f64);
    let mut x: Vec<C> = (0..s).map(start).collect();
    for _ in 0..200 {
        let mut moved = 0.0f64;
        for i in 0..s {
            let (p, d) = horner(x[i]);
            if p == C::ZERO {
                continue;
            }
            let newton = p / d;
            let repelled: C = (0..s).filter(|&j| j != i).map(|j| C::ONE / (x[i] - x[j])).sum();
            let step = newton / (C::ONE - newton * repelled);
            if step.is_finite() {
                x[i] -= step;
                moved = moved.max(step.norm());
            }
        }
        if moved < 1e-15 {
            break;
        }
    }
    x
}

/// The eigenvector of a value, by inverse iteration from a vector that is orthogonal to none in practice.
fn vector(a: &[Vec<f64>], value: C) -> Option<Vec<C>> {
    let s = a.len();
    // A hair beside the value, where the matrix still has its pivots.
    let shift = value + C::new(1e-10, if value.im == 0.0 { 0.0 } else { 1e-10 });
    let mut matrix = vec![C::ZERO; s * s];
    for i in 0..s {
        for j in 0..s {
            matrix[i + j * s] = C::from(a[i][j]) - if i == j { shift } else { C::ZERO };
        }
    }
    let mut pivots = vec![0; s];
    lu::factor(s, &mut matrix, &mut pivots).ok()?;
    let mut x: Vec<C> = (0..s).map(|i| C::new(1.0 + 0.3 * i as f64, 0.0)).collect();
    for _ in 0..4 {
        lu::solve(s, &matrix, &pivots, &mut x);
        let largest = x.iter().copied().max_by(|p, q| p.norm().total_cmp(&q.norm()))?;
        x.iter_mut().for_each(|x| *x /= largest);
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rebuilt(a: &[Vec<f64>]) -> f64 {
        let eigen = Eigen::of(a).unwrap();
        let mut worst = 0.0f64;
        for (i, row) in a.iter().enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                let sum: f64 = (0..eigen.values.len())
                    .map(|k| {
                        let weight = if k < eigen.real { 1.0 } else { 2.0 };
                        weight * (eigen.vectors[i][k] * eigen.values[k] * eigen.inverse[k][j]).re
                    })
                    .sum();
                worst = worst.max((sum - entry).abs());
            }
        }
        worst
    }

    #[test]
    fn a_matrix_is_rebuilt_from_its_eigenvectors() {
        assert!(rebuilt(&[vec![5.0 / 12.0, -1.0 / 12.0], vec![0.75, 0.25]]) < 1e-13);
        let r = 6f64.sqrt();
        let radau = [
            vec![(88.0 - 7.0 * r) / 360.0, (296.0 - 169.0 * r) / 1800.0, (-2.0 + 3.0 * r) / 225.0],
            vec![(296.0 + 169.0 * r) / 1800.0, (88.0 + 7.0 * r) / 360.0, (-2.0 - 3.0 * r) / 225.0],
            vec![(16.0 - r) / 36.0, (16.0 + r) / 36.0, 1.0 / 9.0],
        ];
        assert!(rebuilt(&radau) < 1e-12);
        // 1 / 3.637834252744496 is the real eigenvalue in RADAU5 (Hairer, Wanner 1996, IV.8).
        let eigen = Eigen::of(&radau).unwrap();
        assert!((eigen.real, eigen.values.len()) == (1, 2));
        assert!((1.0 / eigen.values[0].re - 3.637834252744496).abs() < 1e-12);
    }

    #[test]
    fn a_matrix_with_too_few_eigenvectors_has_none() {
        assert!(Eigen::of(&[vec![1.0, 1.0], vec![0.0, 1.0]]).is_none());
    }
}
