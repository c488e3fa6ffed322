//! What lies beyond the edge of a map.

/// What a stencil finds beyond the edge of the map, along one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// The map repeats: for tiles.
    #[default]
    Wrap,
    /// The texel at the edge goes on for ever.
    Clamp,
    /// The map is reflected at the outer edge of its last texel, which is seen twice: b(-1) = b(0), as a
    /// sampler set to mirrored repeat has it.
    Mirror,
    /// Nothing: near the edge the stencil becomes the one-sided difference of the same order, the one that is
    /// exact for the polynomials of that degree.
    OneSided,
}

impl Border {
    /// The texel of a line of `n` found at offset `i`, and the sign that a slope there carries over: a
    /// reflected slope is reversed and one beyond a clamped edge is zero. None where nothing is there.
    pub(super) fn find(self, i: isize, n: usize) -> Option<(usize, f64)> {
        let size = n as isize;
        if (0..size).contains(&i) {
            return Some((i as usize, 1.0));
        }
        match self {
            Border::Wrap => Some((i.rem_euclid(size) as usize, 1.0)),
            Border::Clamp => Some((i.clamp(0, size - 1) as usize, 0.0)),
            Border::Mirror => {
                let i = i.rem_euclid(2 * size);
                Some(if i < size { (i as usize, 1.0) } else { ((2 * size - 1 - i) as usize, -1.0) })
            }
            Border::OneSided => None,
        }
    }
}
