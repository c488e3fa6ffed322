//! The error norm: root mean square of error over tolerance, component by component.

use super::scalar::Real;

/// How large an error may be: `atol_i + rtol_i max(|y0_i|, |y1_i|)` in each component.
#[derive(Clone, Debug)]
pub enum Tolerance<R> {
    /// The same numbers for every component.
    Scalar { rtol: R, atol: R },
    /// `(rtol_i, atol_i)` for each component.
    Each(Vec<(R, R)>),
}

impl<R: Real> Tolerance<R> {
    #[inline(always)]
    pub fn at(&self, i: usize) -> (R, R) {
        match self {
            Tolerance::Scalar { rtol, atol } => (*rtol, *atol),
            Tolerance::Each(each) => each[i],
        }
    }

    /// The smallest absolute one.
    pub(crate) fn least(&self) -> R {
        match self {
            Tolerance::Scalar { atol, .. } => *atol,
            Tolerance::Each(each) => {
                each.iter().fold(R::from_f64(f64::MAX), |least, &(_, atol)| least.minimum(atol))
            }
        }
    }
}
