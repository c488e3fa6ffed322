//! The stencils tested with, by the textbook.

use kutta::normals::{Stencil, Taps};
use kutta::tableau::DoubleDouble as D;

const fn taps<const N: usize>(first: isize, weights: [(i64, i64); N]) -> Taps {
    let (mut weight, mut i) = ([D::ZERO; 16], 0);
    while i < N {
        weight[i] = D::of_integer(weights[i].0).over(D::of_integer(weights[i].1));
        i += 1;
    }
    Taps { first, len: N, weight }
}

const ONE: Taps = taps(0, [(1, 1)]);

const fn stencil(
    title: &'static str,
    order: usize,
    along: Taps,
    across: Taps,
    left: Taps,
) -> Stencil<'static> {
    Stencil { title, cite: "", note: "", order, digits: 0, at: D::ZERO, along, across, left }
}

const HALVES: Taps = taps(-1, [(-1, 2), (0, 1), (1, 2)]);

pub const CENTRAL2: Stencil = stencil("central2", 2, HALVES, ONE, ONE);
pub const CENTRAL4: Stencil =
    stencil("central4", 4, taps(-2, [(1, 12), (-2, 3), (0, 1), (2, 3), (-1, 12)]), ONE, ONE);
pub const CENTRAL6: Stencil = stencil(
    "central6",
    6,
    taps(-3, [(-1, 60), (3, 20), (-3, 4), (0, 1), (3, 4), (-3, 20), (1, 60)]),
    ONE,
    ONE,
);
pub const CENTRAL8: Stencil = stencil(
    "central8",
    8,
    taps(-4, [(1, 280), (-4, 105), (1, 5), (-4, 5), (0, 1), (4, 5), (-1, 5), (4, 105), (-1, 280)]),
    ONE,
    ONE,
);
/// Lives half a texel further.
pub const FORWARD2: Stencil =
    Stencil { at: D::of(0.5), ..stencil("forward2", 2, taps(0, [(-1, 1), (1, 1)]), ONE, ONE) };
pub const SOBEL3: Stencil = stencil("sobel3", 2, HALVES, taps(-1, [(1, 4), (1, 2), (1, 4)]), ONE);
pub const SCHARR3: Stencil = stencil("scharr3", 2, HALVES, taps(-1, [(3, 16), (5, 8), (3, 16)]), ONE);
/// Farid and Simoncelli (2004), five taps, rounded to rationals; the difference's first moment is 1.
pub const FARID5: Stencil = stencil(
    "farid5",
    2,
    taps(-2, [(-109604, 1000000), (-280792, 1000000), (0, 1), (280792, 1000000), (109604, 1000000)]),
    taps(-2, [(37659, 1000000), (249153, 1000000), (426376, 1000000), (249153, 1000000), (37659, 1000000)]),
    ONE,
);
/// Lele (1992), alpha = 1/3.
pub const COMPACT6: Stencil = stencil(
    "compact6",
    6,
    taps(-2, [(-1, 36), (-7, 9), (0, 1), (7, 9), (1, 36)]),
    ONE,
    taps(-1, [(1, 3), (1, 1), (1, 3)]),
);

pub const ALL: [Stencil; 9] =
    [FORWARD2, CENTRAL2, CENTRAL4, CENTRAL6, CENTRAL8, SOBEL3, SCHARR3, FARID5, COMPACT6];
