//! Pascal's triangle on a history in Nordsieck form: Taylor's series, a step later.

use super::scalar::Scalar;
use super::state::{RealOf, State};
use crate::tableau::CARRIED;

/// `next_k = sum_(j >= k) (j over k) powers_j z_j` for k = 0 .. q: the compiler writes out each order.
pub(super) fn pascal<Y: State>(q: usize, powers: &[RealOf<Y>; CARRIED], z: &[Y], next: &mut [Y]) {
    match q {
        1 => triangle::<Y, 2>(powers, z, next),
        2 => triangle::<Y, 3>(powers, z, next),
        3 => triangle::<Y, 4>(powers, z, next),
        4 => triangle::<Y, 5>(powers, z, next),
        5 => triangle::<Y, 6>(powers, z, next),
        6 => triangle::<Y, 7>(powers, z, next),
        7 => triangle::<Y, 8>(powers, z, next),
        8 => triangle::<Y, 9>(powers, z, next),
        9 => triangle::<Y, 10>(powers, z, next),
        10 => triangle::<Y, 11>(powers, z, next),
        11 => triangle::<Y, 12>(powers, z, next),
        _ => triangle::<Y, 13>(powers, z, next),
    }
}

/// Pascal's triangle on so many vectors: blocks of components run through it in registers.
fn triangle<Y: State, const K: usize>(powers: &[RealOf<Y>; CARRIED], z: &[Y], next: &mut [Y]) {
    const WIDTH: usize = 8;
    let n = z[0].as_slice().len();
    let z: [&[Y::Scalar]; K] = std::array::from_fn(|k| &z[k].as_slice()[..n]);
    let Some(next) = next.first_chunk_mut::<K>() else { return };
    let mut next = next.each_mut().map(|next| &mut next.as_mut_slice()[..n]);
    let whole = n - n % WIDTH;
    for at in (0..whole).step_by(WIDTH) {
        block::<_, K, WIDTH>(powers, &z, &mut next, at);
    }
    for at in whole..n {
        block::<_, K, 1>(powers, &z, &mut next, at);
    }
}

#[inline(always)]
fn block<T: Scalar, const K: usize, const WIDTH: usize>(
    powers: &[T::Real; CARRIED],
    z: &[&[T]; K],
    next: &mut [&mut [T]; K],
    at: usize,
) {
    let mut block = [[T::zero(); WIDTH]; K];
    for k in 0..K {
        let z = &z[k][at..at + WIDTH];
        block[k].iter_mut().zip(z).for_each(|(to, z)| *to = z.scale(powers[k]));
    }
    for k in 0..K - 1 {
        for j in (k..K - 1).rev() {
            let (low, high) = block.split_at_mut(j + 1);
            low[j].iter_mut().zip(&high[0]).for_each(|(low, &high)| *low = *low + high);
        }
    }
    for k in 0..K {
        next[k][at..at + WIDTH].copy_from_slice(&block[k]);
    }
}
