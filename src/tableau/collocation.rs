//! The dense output that a fully implicit table has of itself: y' between the ends of a step is the polynomial
//! through the slopes of the stages (Hairer, Wanner 1996, IV.8, (8.22) and II.7 of volume I).

use super::Array;
use super::double_double::DoubleDouble as D;
use super::form::{Form, POWERS};
use super::lower::slopes;

/// Adds it where the nodes lie apart and the weights b are the integrals of their Lagrange polynomials, so that it
/// ends in y'. Its order is the number of stages, or one above the order of the stages where that is less.
pub(super) const fn collocation(array: &Array, form: &mut Form) {
    let s = array.stages;
    let (mut weights, mut i) = ([[D::ZERO; super::STAGES]; POWERS], 0);
    if s > POWERS {
        return;
    }
    while i < s {
        // prod_(j /= i) (x - c_j) / (c_i - c_j), coefficients from x^0 on.
        let (mut basis, mut degree, mut j) = ([D::ZERO; POWERS + 1], 0, 0);
        basis[0] = D::ONE;
        while j < s {
            if j != i {
                let gap = array.c[i].minus(array.c[j]);
                if gap.hi() == 0.0 {
                    return;
                }
                let mut k = degree + 1;
                while k > 0 {
                    basis[k] = basis[k - 1].minus(array.c[j].times(basis[k])).over(gap);
                    k -= 1;
                }
                basis[0] = array.c[j].times(basis[0]).neg().over(gap);
                degree += 1;
            }
            j += 1;
        }
        let (mut whole, mut k) = (D::ZERO, 0);
        while k < s {
            weights[k][i] = basis[k].over(D::of_integer(k as i64 + 1));
            whole = whole.plus(weights[k][i]);
            k += 1;
        }
        // As good as the entries of any file that is read.
        if whole.minus(array.b[i]).abs().hi() > 1e-13 {
            return;
        }
        i += 1;
    }
    let mut k = 0;
    while k < s {
        form.dense[k] = slopes(None, 1, &weights[k], s, 1);
        k += 1;
    }
    form.powers = s;
    form.dense_order = stage_order(array) + 1;
    if form.dense_order > s {
        form.dense_order = s;
    }
}

/// The largest q with sum_j a_ij c_j^(k-1) = c_i^k / k for k = 1 .. q.
const fn stage_order(array: &Array) -> usize {
    let s = array.stages;
    let mut k = 1;
    while k <= s {
        let mut i = 0;
        while i < s {
            let (mut sum, mut j) = (D::ZERO, 0);
            while j < s {
                sum = sum.plus(array.a[i][j].times(array.c[j].powi(k as u32 - 1)));
                j += 1;
            }
            let exact = array.c[i].powi(k as u32).over(D::of_integer(k as i64));
            if sum.minus(exact).abs().hi() > 1e-13 {
                return k - 1;
            }
            i += 1;
        }
        k += 1;
    }
    s
}

#[cfg(test)]
mod tests {
    use crate::tableau::lower::tests::form;

    #[test]
    fn collocation_has_the_order_of_its_stages() {
        for (name, order) in [("radau-iia3", 3), ("gauss3", 3), ("lobatto-iiia3", 3), ("radau-iia5", 5)] {
            let form = form(&format!("implicit/{name}"));
            assert_eq!((form.dense_order, form.powers), (order, order), "{name}");
        }
        // Stages of order 1 only.
        assert_eq!(form("implicit/lobatto-iiib3").dense_order, 2);
    }

    #[test]
    fn radau_dense_output_is_that_of_the_book() {
        // With theta = 1 the weights are b; at theta = c_1 they are the first row of A.
        let (form, root) = (form("implicit/radau-iia3"), 6f64.sqrt());
        let at = |theta: f64| {
            let weight =
                |i: usize| (0..3).map(|k| form.dense[k].a[i].hi() * theta.powi(k as i32 + 1)).sum::<f64>();
            [weight(0), weight(1), weight(2)]
        };
        let near = |x: [f64; 3], y: [f64; 3]| x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-14);
        assert!(near(at(1.0), [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0]));
        let row = [(88.0 - 7.0 * root) / 360.0, (296.0 - 169.0 * root) / 1800.0, (-2.0 + 3.0 * root) / 225.0];
        assert!(near(at((4.0 - root) / 10.0), row));
    }
}
