//! TIFF: 8 and 16 bits and 32-bit floats, grey or one channel of colour, the first image of a file.

use super::{Channel, Grey, Texels, check, failed, pick, sample};
use std::io::{BufRead, Seek};
use tiff::decoder::{Decoder, DecodingResult, Limits};

pub fn read(file: impl BufRead + Seek, length: u64, channel: Option<Channel>) -> Result<Grey, String> {
    let mut decoder = Decoder::new(file).map_err(failed)?;
    let (width, height) = decoder.dimensions().map_err(failed)?;
    let colour = decoder.colortype().map_err(failed)?;
    let bits = u64::from(colour.bit_depth()) * u64::from(colour.num_samples());
    check(width.into(), height.into(), bits, length)?;
    let at = sample(colour.num_samples().into(), channel)?;
    let mut limits = Limits::unlimited();
    limits.ifd_value_size = 1 << 24;
    // Strips and tiles may reach beyond the image, but not by much.
    limits.decoding_buffer_size = (u64::from(width) * u64::from(height) * bits / 8) as usize + (1 << 24);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    let mut decoder = decoder.with_limits(limits);
    let (width, height) = (width as usize, height as usize);
    let read = decoder.read_image().map_err(failed)?;
    let samples = usize::from(colour.num_samples());
    let texels = match read {
        DecodingResult::U8(all) if colour.bit_depth() == 8 => Texels::U8(pick(all, at, samples)),
        DecodingResult::U16(all) if colour.bit_depth() == 16 => Texels::U16(pick(all, at, samples)),
        DecodingResult::F32(all) => Texels::F32(pick(all, at, samples)),
        _ => return Err("a TIFF height is 8 or 16 bits or a 32-bit float".to_string()),
    };
    let found = match &texels {
        Texels::U8(all) => all.len(),
        Texels::U16(all) => all.len(),
        Texels::F32(all) => all.len(),
    };
    if found != width * height {
        return Err("a TIFF whose channels lie apart is not read".to_string());
    }
    Ok(Grey { width, height, texels })
}
