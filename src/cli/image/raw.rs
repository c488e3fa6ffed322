//! Raw numbers, little-endian, rows from the top: 1, 2 or 4 bytes a texel are u8, u16 or f32.

use super::{Grey, Size, Texels, check, failed};
use std::io::BufRead;

pub fn read(mut file: impl BufRead, length: u64, size: Size) -> Result<Grey, String> {
    let Size { width, height } = size;
    // Before the product, which might overflow.
    check(width as u64, height as u64, 0, length)?;
    let texels = (width * height) as u64;
    let bytes = if length.is_multiple_of(texels) { length / texels } else { 0 };
    if ![1, 2, 4].contains(&bytes) {
        return Err(format!(
            "{length} bytes: {width} x {height} raw texels are {texels}, {} or {} (u8, u16, f32)",
            2 * texels,
            4 * texels
        ));
    }
    let mut all = vec![0; length as usize];
    file.read_exact(&mut all).map_err(failed)?;
    let texels = match bytes {
        1 => Texels::U8(all),
        2 => Texels::U16(all.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()),
        _ => Texels::F32(all.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()),
    };
    Ok(Grey { width, height, texels })
}
