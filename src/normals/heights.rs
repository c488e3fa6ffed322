//! Height maps as they come.

use super::error::BakeError;

/// A map of width x height texels, the top row first.
#[derive(Clone, Copy, Debug)]
pub struct Heights<'a, H> {
    pub(super) texels: &'a [H],
    pub(super) width: usize,
    pub(super) height: usize,
}

impl<'a, H: Height> Heights<'a, H> {
    /// The texels row by row, as many as width x height, and at least one.
    pub fn new(texels: &'a [H], width: usize, height: usize) -> Result<Self, BakeError> {
        match width.checked_mul(height) {
            None | Some(0) => Err(BakeError::Size { width, height }),
            Some(need) if need != texels.len() => Err(BakeError::Length { len: texels.len(), need }),
            Some(_) => Ok(Self { texels, width, height }),
        }
    }

    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    pub fn texels(&self) -> &'a [H] {
        self.texels
    }

    pub(super) fn row(&self, y: usize) -> &'a [H] {
        &self.texels[y * self.width..(y + 1) * self.width]
    }

    pub(super) fn bad(&self, x: usize, y: usize) -> bool {
        !self.row(y)[x].finite()
    }

    /// How many heights are not finite, and where the first one is.
    pub(super) fn missing(&self) -> Option<BakeError> {
        let mut bad = self.texels.iter().enumerate().filter(|(_, h)| !h.finite()).map(|(i, _)| i);
        let first = bad.next()?;
        Some(BakeError::NotFinite { count: 1 + bad.count(), first: [first % self.width, first / self.width] })
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

/// A texel of a height map: `u8` and `u16` from 0 to 1, white being 1; `f32` as it is.
pub trait Height: sealed::Sealed + Copy + Send + Sync + 'static {
    /// What stands for 1.
    const WHITE: f64;
    /// The distance of neighbouring heights; 0 where there are as many as matter.
    const QUANTUM: f64;
    /// In steps of 1/[`WHITE`](Self::WHITE).
    #[doc(hidden)]
    fn steps(self) -> f32;
    #[doc(hidden)]
    fn finite(self) -> bool;
    #[doc(hidden)]
    fn all_finite(texels: &[Self]) -> bool;
}

macro_rules! integer {
    ($t:ident) => {
        impl Height for $t {
            const WHITE: f64 = $t::MAX as f64;
            const QUANTUM: f64 = 1.0 / $t::MAX as f64;
            #[inline(always)]
            fn steps(self) -> f32 {
                self.into()
            }
            #[inline(always)]
            fn finite(self) -> bool {
                true
            }
            #[inline(always)]
            fn all_finite(_: &[Self]) -> bool {
                true
            }
        }
    };
}
integer!(u8);
integer!(u16);

impl Height for f32 {
    const WHITE: f64 = 1.0;
    const QUANTUM: f64 = 0.0;
    #[inline(always)]
    fn steps(self) -> f32 {
        self
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.is_finite()
    }
    #[inline(always)]
    fn all_finite(texels: &[Self]) -> bool {
        // Without a branch, so that it runs on whole vectors.
        texels.iter().fold(0, |worst, h| worst.max(h.to_bits() & 0x7fff_ffff)) < f32::INFINITY.to_bits()
    }
}
