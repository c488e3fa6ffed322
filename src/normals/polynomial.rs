//! Weights of the polynomial through a run of texels: its value, and its slope, anywhere.

use crate::tableau::DoubleDouble as D;

/// The product of (x - x_m) / (x_k - x_m) over the texels 0..len without those two.
fn product(k: usize, without: usize, len: usize, x: D) -> D {
    (0..len)
        .filter(|&m| m != k && m != without)
        .fold(D::ONE, |product, m| product * (x - D::of(m as f64)) / D::of(k as f64 - m as f64))
}

/// The weight of texel k in the value at x of the polynomial through the texels 0..len.
pub(super) fn value(k: usize, len: usize, x: D) -> D {
    product(k, k, len, x)
}

/// The weight of texel k in its slope at x.
pub(super) fn slope(k: usize, len: usize, x: D) -> D {
    (0..len)
        .filter(|&m| m != k)
        .fold(D::ZERO, |sum, m| sum + product(k, m, len, x) / D::of(k as f64 - m as f64))
}
