//! The widest vectors of the machine, found at run time.

use crate::step::scalar::{Arith, Fused, Plain};

/// A loop to be compiled for every width.
pub(super) trait Kernel {
    type Output;
    fn run<A: Arith>(self) -> Self::Output;
}

#[derive(Clone, Copy)]
pub(super) enum Simd {
    Plain,
    #[cfg(target_arch = "x86_64")]
    V3(pulp::x86::V3),
    #[cfg(target_arch = "x86_64")]
    V4(pulp::x86::V4),
}

impl Simd {
    pub(super) fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(simd) = pulp::x86::V4::try_new() {
                return Simd::V4(simd);
            }
            if let Some(simd) = pulp::x86::V3::try_new() {
                return Simd::V3(simd);
            }
        }
        Simd::Plain
    }

    /// All that this machine has.
    #[cfg(test)]
    pub(super) fn all() -> Vec<Self> {
        let mut all = vec![Simd::Plain];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Simd::V3));
            all.extend(pulp::x86::V4::try_new().map(Simd::V4));
        }
        all
    }

    #[inline(always)]
    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Simd::Plain => kernel.run::<Plain>(),
            #[cfg(target_arch = "x86_64")]
            Simd::V3(simd) => simd.vectorize(Wide(kernel)),
            #[cfg(target_arch = "x86_64")]
            Simd::V4(simd) => simd.vectorize(Wide(kernel)),
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct Wide<K>(K);

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Wide<K> {
    type Output = K::Output;
    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run::<Fused>()
    }
}
