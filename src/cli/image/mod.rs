//! Image files: heights from PNG, TIFF, PFM and raw numbers; normals to PNG, PFM and raw numbers.
//!
//! Numbers are read and written as stored: no gamma, no colour profile. Errors are one line without the
//! path, which the caller knows.

mod pfm;
mod png;
mod raw;
mod tiff;
mod write;

pub use write::{Format, Pixels, write};

use std::io::{BufRead, Seek, SeekFrom};
use std::str::FromStr;

/// Most texels of an image: 16384 x 16384. A header that claims more is refused before anything is allocated.
pub const MOST_TEXELS: u64 = 1 << 28;

/// No compression of PNG or TIFF makes a file more than this many times smaller: deflate reaches 1032, LZW
/// 2730. A header that claims more bytes lies, and is refused before they are allocated.
const MOST_SQUEEZED: u64 = 4096;

/// A height map as stored, rows from the top.
#[derive(Debug, PartialEq)]
pub struct Grey {
    pub width: usize,
    pub height: usize,
    pub texels: Texels,
}

#[derive(Debug, PartialEq)]
pub enum Texels {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Texels {
    pub fn words(&self) -> &'static str {
        match self {
            Self::U8(_) => "8-bit",
            Self::U16(_) => "16-bit",
            Self::F32(_) => "float",
        }
    }
}

/// Where the height is in a file of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    R,
    G,
    B,
    A,
}

impl FromStr for Channel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "r" => Ok(Self::R),
            "g" => Ok(Self::G),
            "b" => Ok(Self::B),
            "a" => Ok(Self::A),
            _ => Err("a channel is r, g, b or a".to_string()),
        }
    }
}

/// Width and height of a raw file, which has no header: `640x480`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: usize,
    pub height: usize,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        let (width, height) = parts.ok_or("a size is WIDTHxHEIGHT, such as 640x480")?;
        Ok(Self { width, height })
    }
}

/// Reads one channel of an image. Its first bytes tell PNG, TIFF and PFM apart; raw numbers, little-endian,
/// need a size and are 8-bit, 16-bit or float by the length of the file.
pub fn read(
    mut file: impl BufRead + Seek,
    channel: Option<Channel>,
    size: Option<Size>,
) -> Result<Grey, String> {
    let length = file.seek(SeekFrom::End(0)).map_err(failed)?;
    file.seek(SeekFrom::Start(0)).map_err(failed)?;
    if let Some(size) = size {
        return raw::read(file, length, size);
    }
    let start = file.fill_buf().map_err(failed)?;
    match start {
        [0x89, b'P', b'N', b'G', ..] => png::read(file, length, channel),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => tiff::read(file, length, channel),
        [b'P', b'f' | b'F', ..] => pfm::read(file, length, channel),
        [] => Err("the file is empty".to_string()),
        _ => Err("neither PNG, TIFF nor PFM; raw numbers need --size WIDTHxHEIGHT".to_string()),
    }
}

/// Refuses what a header claims, if it is too much or cannot be true.
fn check(width: u64, height: u64, bits_a_texel: u64, length: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("{width} x {height} texels are no image"));
    }
    if width.checked_mul(height).is_none_or(|texels| texels > MOST_TEXELS) {
        return Err(format!("{width} x {height} texels are more than the {MOST_TEXELS} that are read"));
    }
    if width * height * bits_a_texel / 8 / MOST_SQUEEZED > length {
        return Err(format!("{width} x {height} texels in {length} bytes: the file is cut short"));
    }
    Ok(())
}

/// Which of `samples` a texel holds is the height: 1 is grey, 2 grey and alpha, 3 and 4 a colour.
fn sample(samples: usize, channel: Option<Channel>) -> Result<usize, String> {
    match (samples, channel) {
        (1 | 2, None) => Ok(0),
        (1, Some(_)) => Err("the image is grey: it has no channels to choose from".to_string()),
        (2, Some(Channel::A)) => Ok(1),
        (2, Some(_)) => Err("the image is grey: of its channels only a can be chosen".to_string()),
        (3 | 4, None) => {
            Err("the image is in colour: say where the height is by --channel r, g, b or a".to_string())
        }
        (3, Some(Channel::A)) => Err("the image has no alpha channel".to_string()),
        (3 | 4, Some(channel)) => Ok(channel as usize),
        _ => Err(format!("{samples} samples a texel are neither grey nor a colour")),
    }
}

/// Every `step`th number from `first` on.
fn pick<T: Copy>(all: Vec<T>, first: usize, step: usize) -> Vec<T> {
    if step == 1 { all } else { all.into_iter().skip(first).step_by(step).collect() }
}

fn failed(error: impl std::fmt::Display) -> String {
    // Some libraries break their messages.
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
