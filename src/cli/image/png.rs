//! PNG: 8 and 16 bits a sample; fewer bits, palettes and transparency expanded to 8.

use super::{Channel, Grey, Texels, check, failed, pick, sample};
use png::{BitDepth, Decoder, Limits, Transformations};
use std::io::{BufRead, Seek};

/// Room for texts and profiles that are skipped, and for a row.
const LIMIT: usize = 1 << 28;

pub fn read(file: impl BufRead + Seek, length: u64, channel: Option<Channel>) -> Result<Grey, String> {
    let mut decoder = Decoder::new_with_limits(file, Limits { bytes: LIMIT });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(failed)?;
    let (width, height) = (header.width, header.height);
    check(width.into(), height.into(), header.bits_per_pixel() as u64, length)?;
    let mut reader = decoder.read_info().map_err(failed)?;
    let (colour, depth) = reader.output_color_type();
    let at = sample(colour.samples(), channel)?;
    let size = reader.output_buffer_size().ok_or("the image does not fit into memory")?;
    let mut bytes = vec![0; size];
    reader.next_frame(&mut bytes).map_err(failed)?;
    let texels = match depth {
        BitDepth::Sixteen => {
            let words = bytes.chunks_exact(2).skip(at).step_by(colour.samples());
            Texels::U16(words.map(|word| u16::from_be_bytes([word[0], word[1]])).collect())
        }
        _ => Texels::U8(pick(bytes, at, colour.samples())),
    };
    Ok(Grey { width: width as usize, height: height as usize, texels })
}
