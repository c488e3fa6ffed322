//! The moments of a stencil: M_pq = sum w_ij (i - at)^p j^q over its two-dimensional weights.

use super::stencil::{Stencil, Taps};
use crate::tableau::DoubleDouble as D;

/// Highest moment.
pub(super) const MOMENTS: usize = 22;

/// M_pq is `along[p]` times `across[q]`. A compact stencil has the moments of the infinite one that solving
/// its left side makes of it.
pub(super) struct Moments {
    pub along: [D; MOMENTS],
    pub across: [D; MOMENTS],
    /// Sums of the absolute terms, by which rounding is judged.
    pub scale_along: [f64; MOMENTS],
    pub scale_across: [f64; MOMENTS],
}

impl Moments {
    /// The moments to the power `highest`, with offsets along the axis counted from `at`.
    pub const fn of(stencil: &Stencil, at: D, highest: usize) -> Self {
        let mut moments = Self {
            along: [D::ZERO; MOMENTS],
            across: [D::ZERO; MOMENTS],
            scale_along: [0.0; MOMENTS],
            scale_across: [0.0; MOMENTS],
        };
        let mut left = [D::ZERO; MOMENTS];
        let mut p = 0;
        while p <= highest && p < MOMENTS {
            (moments.across[p], moments.scale_across[p]) = moment(&stencil.across, D::ZERO, p);
            left[p] = moment(&stencil.left, D::ZERO, p).0;
            // sum_q C(p, q) left_q M_(p-q) is the moment of the right side.
            let (mut sum, mut scale) = moment(&stencil.along, at, p);
            let (mut q, mut binomial) = (1, 1);
            while q <= p {
                binomial = binomial * (p + 1 - q) / q;
                let term = left[q].times(moments.along[p - q]).times(D::of(binomial as f64));
                sum = sum.minus(term);
                scale += term.hi().abs();
                q += 1;
            }
            moments.along[p] = sum.over(left[0]);
            moments.scale_along[p] = scale / left[0].hi().abs();
            p += 1;
        }
        moments
    }

    /// How far M_pq is from that of an isotropic error of degree p + q, and the size of its terms: the symbol
    /// sum M_pq z_x^p z_y^q / (p! q!) has no terms of even degree, and in those of odd degree z_x
    /// (z_x^2 + z_y^2)^m with the factor that M_(p+q),0 gives.
    pub const fn anisotropy(&self, p: usize, q: usize) -> (D, f64) {
        let moment = self.along[p].times(self.across[q]);
        let scale = self.scale_along[p] * self.scale_across[q];
        let (degree, m) = (p + q, (p + q) / 2);
        if degree.is_multiple_of(2) || !q.is_multiple_of(2) {
            return (moment, scale);
        }
        // p! q! / degree! C(m, q/2) M_(degree),0
        let (mut share, mut i) = (self.along[degree], 0);
        while i < q {
            share = share.times(D::of((i + 1) as f64)).over(D::of((degree - i) as f64));
            i += 1;
        }
        let mut i = 0;
        while i < q / 2 {
            share = share.times(D::of((m - i) as f64)).over(D::of((i + 1) as f64));
            i += 1;
        }
        (moment.minus(share), scale + share.hi().abs())
    }
}

/// sum w_j (j - at)^p, and the sum of the sizes of its terms.
const fn moment(taps: &Taps, at: D, p: usize) -> (D, f64) {
    let (mut sum, mut scale, mut j) = (D::ZERO, 0.0, 0);
    while j < taps.len {
        let mut term = taps.weight[j];
        if p > 0 && term.hi() != 0.0 {
            let x = D::of((taps.first + j as isize) as f64).minus(at);
            let mut power = 0;
            while power < p {
                term = term.times(x);
                power += 1;
            }
        }
        sum = sum.plus(term);
        scale += term.hi().abs();
        j += 1;
    }
    (sum, scale)
}
