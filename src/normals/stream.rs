//! Stores past the cache: a line written whole need not be read first, which is twice the speed on maps
//! that are larger than the cache.

/// Entries without padding, all of whose bytes may be copied.
pub trait Bytes: Copy {}
impl Bytes for [f32; 3] {}
impl Bytes for [f32; 2] {}
impl Bytes for [u8; 3] {}
impl Bytes for [u8; 2] {}
impl Bytes for [u16; 3] {}
impl Bytes for [u16; 2] {}

/// Copies past the cache.
///
/// # Safety
///
/// [`fence`] must run on this thread before anybody reads what was written or another thread is told of it.
#[inline]
pub(super) unsafe fn copy<T: Bytes>(from: &[T], to: &mut [T]) {
    let to = &mut to[..from.len()];
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    {
        use std::arch::x86_64::{__m128i, _mm_loadu_si128, _mm_stream_si128};
        let bytes = size_of_val(from);
        let (source, target) = (from.as_ptr().cast::<u8>(), to.as_mut_ptr().cast::<u8>());
        let head = target.align_offset(16).min(bytes);
        let blocks = (bytes - head) / 16;
        // SAFETY: both slices are `bytes` long, and all three copies stay within: head, then blocks of 16,
        // then the rest. The target of a block is aligned to 16, being `head` past the start. SSE2 is part of
        // x86-64. Every byte of `T` may be copied by its trait.
        unsafe {
            std::ptr::copy_nonoverlapping(source, target, head);
            for i in 0..blocks {
                let at = head + 16 * i;
                let block = _mm_loadu_si128(source.add(at).cast::<__m128i>());
                _mm_stream_si128(target.add(at).cast::<__m128i>(), block);
            }
            let rest = head + 16 * blocks;
            std::ptr::copy_nonoverlapping(source.add(rest), target.add(rest), bytes - rest);
        }
    }
    #[cfg(not(all(target_arch = "x86_64", not(miri))))]
    to.copy_from_slice(from);
}

/// Texels that are wanted soon, asked for a few lines at a time: more than can be under way is a wait.
pub(super) struct Ahead {
    at: *const i8,
    bytes: usize,
}

impl Ahead {
    pub(super) fn of<T>(texels: &[T]) -> Self {
        Self { at: texels.as_ptr().cast(), bytes: size_of_val(texels) }
    }

    /// Bytes of one of so many parts.
    pub(super) fn share(&self, parts: usize) -> usize {
        self.bytes.div_ceil(parts.max(1))
    }

    /// Asks for the next bytes.
    #[inline(always)]
    pub(super) fn ask(&mut self, bytes: usize) {
        let bytes = bytes.min(self.bytes);
        #[cfg(all(target_arch = "x86_64", not(miri)))]
        for line in (0..bytes).step_by(64) {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            // SAFETY: a prefetch reads nothing and faults nowhere. SSE is part of x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(self.at.wrapping_add(line)) };
        }
        self.at = self.at.wrapping_add(bytes);
        self.bytes -= bytes;
    }
}

/// Ends a run of [`copy`]: what it wrote is seen before what is written later.
#[inline]
pub(super) fn fence() {
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    // SAFETY: SSE is part of x86-64.
    unsafe {
        std::arch::x86_64::_mm_sfence()
    };
}
