//! What is written: PNG of 8 or 16 bits without gamma or colour chunks, PFM, raw numbers.

use super::{failed, pfm};
use png::{BitDepth, ColorType, Compression, Encoder};
use std::io::Write;

/// The kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Png,
    Pfm,
    Raw,
}

impl Format {
    /// By the ending of the name.
    pub fn of(path: &str) -> Option<Self> {
        match path.rsplit_once('.')?.1.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "pfm" => Some(Self::Pfm),
            "raw" => Some(Self::Raw),
            _ => None,
        }
    }
}

/// Pixels of one kind, rows from the top.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'p> {
    GreyF32(&'p [f32]),
    Rgb8(&'p [[u8; 3]]),
    Rgb16(&'p [[u16; 3]]),
    /// In a PNG, which has no such kind, blue is 0.
    Rg8(&'p [[u8; 2]]),
    Rg16(&'p [[u16; 2]]),
    F32(&'p [[f32; 3]]),
}

impl Pixels<'_> {
    fn len(&self) -> usize {
        match self {
            Self::GreyF32(all) => all.len(),
            Self::Rgb8(all) => all.len(),
            Self::Rgb16(all) => all.len(),
            Self::Rg8(all) => all.len(),
            Self::Rg16(all) => all.len(),
            Self::F32(all) => all.len(),
        }
    }

    /// Appends the pixels of a range as bytes: big-endian with blue for PNG, little-endian as they are
    /// otherwise.
    fn bytes(&self, range: std::ops::Range<usize>, png: bool, out: &mut Vec<u8>) {
        let word = |x: u16| if png { x.to_be_bytes() } else { x.to_le_bytes() };
        match self {
            Self::GreyF32(all) => out.extend(all[range].iter().flat_map(|x| x.to_le_bytes())),
            Self::Rgb8(all) => out.extend(all[range].as_flattened()),
            Self::Rgb16(all) => out.extend(all[range].as_flattened().iter().flat_map(|x| word(*x))),
            Self::Rg8(all) if png => out.extend(all[range].iter().flat_map(|&[r, g]| [r, g, 0])),
            Self::Rg8(all) => out.extend(all[range].as_flattened()),
            Self::Rg16(all) if png => {
                out.extend(all[range].iter().flat_map(|&[r, g]| [r, g, 0]).flat_map(word));
            }
            Self::Rg16(all) => out.extend(all[range].as_flattened().iter().flat_map(|x| word(*x))),
            Self::F32(all) => {
                out.extend(all[range].as_flattened().iter().flat_map(|x| x.to_le_bytes()));
            }
        }
    }
}

/// Writes an image and tells after each row how many are done.
pub fn write(
    mut out: impl Write,
    format: Format,
    width: usize,
    pixels: Pixels,
    done: impl Fn(usize),
) -> Result<(), String> {
    let height = pixels.len() / width;
    let mut bytes = vec![];
    let mut row = |out: &mut dyn Write, at: usize, count: usize| {
        bytes.clear();
        pixels.bytes(at * width..(at + 1) * width, format == Format::Png, &mut bytes);
        out.write_all(&bytes).map_err(failed)?;
        done(count);
        Ok::<(), String>(())
    };
    match format {
        Format::Png => {
            let (colour, depth) = match pixels {
                Pixels::Rgb8(_) | Pixels::Rg8(_) => (ColorType::Rgb, BitDepth::Eight),
                Pixels::Rgb16(_) | Pixels::Rg16(_) => (ColorType::Rgb, BitDepth::Sixteen),
                Pixels::F32(_) | Pixels::GreyF32(_) => return Err("a PNG holds no floats".to_string()),
            };
            let mut encoder = Encoder::new(&mut out, width as u32, height as u32);
            encoder.set_color(colour);
            encoder.set_depth(depth);
            encoder.set_compression(Compression::Fast);
            let mut writer = encoder.write_header().map_err(failed)?;
            let mut stream = writer.stream_writer().map_err(failed)?;
            (0..height).try_for_each(|at| row(&mut stream, at, at + 1))?;
            stream.finish().map_err(failed)?;
            writer.finish().map_err(failed)?;
        }
        Format::Pfm => {
            pfm::head(&mut out, width, height, matches!(pixels, Pixels::GreyF32(_))).map_err(failed)?;
            (0..height).try_for_each(|i| row(&mut out, height - 1 - i, i + 1))?;
        }
        Format::Raw => (0..height).try_for_each(|at| row(&mut out, at, at + 1))?,
    }
    out.flush().map_err(failed)
}
