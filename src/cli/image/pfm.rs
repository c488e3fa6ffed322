//! PFM: `Pf` (grey) or `PF` (colour), width, height, a scale whose sign is the byte order, then floats, rows
//! from the bottom. The size of the scale is a unit nobody agrees on; it is left alone.

use super::{Channel, Grey, Texels, check, failed, sample};
use std::io::{BufRead, Seek, Write};

pub fn read(mut file: impl BufRead + Seek, length: u64, channel: Option<Channel>) -> Result<Grey, String> {
    let samples = if word(&mut file)? == "PF" { 3 } else { 1 };
    let [width, height] = [word(&mut file)?, word(&mut file)?];
    let number = |text: &str| text.parse::<u64>().map_err(|_| format!("PFM: {text:?} is no size"));
    let (width, height) = (number(&width)?, number(&height)?);
    let scale = word(&mut file)?;
    let scale = scale.parse::<f32>().ok().filter(|x| x.is_finite() && *x != 0.0);
    let little = scale.ok_or("PFM: the scale is no number")? < 0.0;
    let at = sample(samples, channel)?;
    let texel = 4 * samples;
    check(width, height, 8 * texel as u64, length)?;
    let rest = length - file.stream_position().map_err(failed)?;
    if rest < width * height * texel as u64 {
        return Err(format!("{rest} bytes for {width} x {height} texels: the file is cut short"));
    }
    let (width, height) = (width as usize, height as usize);
    let mut texels = vec![0.0; width * height];
    let mut bytes = vec![0; width * texel];
    for row in texels.chunks_exact_mut(width).rev() {
        file.read_exact(&mut bytes).map_err(failed)?;
        for (height, texel) in row.iter_mut().zip(bytes.chunks_exact(texel)) {
            let four = [0, 1, 2, 3].map(|i| texel[4 * at + i]);
            *height = if little { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) };
        }
    }
    Ok(Grey { width, height, texels: Texels::F32(texels) })
}

/// The next word of the header and the one blank behind it.
fn word(file: &mut impl BufRead) -> Result<String, String> {
    let mut word = String::new();
    while word.len() < 32 {
        let mut byte = [0];
        file.read_exact(&mut byte).map_err(|_| "PFM: the file ends within its header")?;
        match byte[0] {
            b' ' | b'\t' | b'\r' | b'\n' if !word.is_empty() => return Ok(word),
            b' ' | b'\t' | b'\r' | b'\n' => {}
            byte if byte.is_ascii_graphic() => word.push(byte.into()),
            _ => break,
        }
    }
    Err("PFM: the header is no text".to_string())
}

/// The header of what we write: little-endian.
pub fn head(out: &mut impl Write, width: usize, height: usize, grey: bool) -> std::io::Result<()> {
    write!(out, "{}\n{width} {height}\n-1.0\n", if grey { "Pf" } else { "PF" })
}
