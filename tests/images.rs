//! Image files: what is read is what was stored, what is written others read, and no bytes cause a panic.
#![cfg(feature = "cli")]

#[allow(dead_code)]
#[path = "../src/cli/image/mod.rs"]
mod image;
#[path = "../src/cli/whole.rs"]
mod whole;

use image::{Channel, Format, Grey, MOST_TEXELS, Pixels, Size, Texels, read, write};
use proptest::prelude::*;
use std::io::{Cursor, Write};
use tiff::encoder::{TiffEncoder, colortype};

fn png_of(colour: png::ColorType, depth: png::BitDepth, size: [u32; 2], bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![];
    let mut encoder = png::Encoder::new(&mut out, size[0], size[1]);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    // What other programs tag their heights with, and what must not change them.
    encoder.set_source_gamma(png::ScaledFloat::new(1.0 / 2.2));
    if colour == png::ColorType::Indexed {
        encoder.set_palette(&[10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120][..]);
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(bytes).unwrap();
    writer.finish().unwrap();
    out
}

fn tiff_of<C: colortype::ColorType>(size: [u32; 2], texels: &[C::Inner]) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut out = Cursor::new(vec![]);
    TiffEncoder::new(&mut out).unwrap().write_image::<C>(size[0], size[1], texels).unwrap();
    out.into_inner()
}

fn grey(bytes: &[u8]) -> Result<Grey, String> {
    read(Cursor::new(bytes), None, None)
}

fn channel(bytes: &[u8], channel: Channel) -> Result<Texels, String> {
    read(Cursor::new(bytes), Some(channel), None).map(|image| image.texels)
}

fn raw(bytes: &[u8], width: usize, height: usize) -> Result<Texels, String> {
    read(Cursor::new(bytes), None, Some(Size { width, height })).map(|image| image.texels)
}

/// 3 x 3 texels of 16 bits, 1000 y + 257 x + 5, interlaced: made by a program of its own with zlib.
const INTERLACED: [u8; 89] = [
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 3, 0, 0, 0, 3, 16, 0, 0, 0, 1, 84,
    212, 6, 182, 0, 0, 0, 32, 73, 68, 65, 84, 120, 218, 99, 96, 96, 101, 96, 98, 103, 96, 191, 202, 121, 157,
    129, 145, 141, 129, 227, 26, 3, 243, 91, 150, 119, 172, 239, 1, 43, 15, 5, 134, 146, 91, 51, 235, 0, 0,
    0, 0, 73, 69, 78, 68, 174, 66, 96, 130,
];

#[test]
fn png_heights_are_read_as_stored() {
    use png::BitDepth::{Eight, Four, One, Sixteen, Two};
    use png::ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
    let eight = png_of(Grayscale, Eight, [3, 2], &[0, 1, 127, 128, 254, 255]);
    let texels = Texels::U8(vec![0, 1, 127, 128, 254, 255]);
    assert_eq!(grey(&eight), Ok(Grey { width: 3, height: 2, texels }));
    let sixteen = png_of(Grayscale, Sixteen, [2, 1], &[0x12, 0x34, 0xff, 0xfe]);
    assert_eq!(grey(&sixteen).unwrap().texels, Texels::U16(vec![0x1234, 0xfffe]));
    let expected = (0..9).map(|i| 1000 * (i / 3) + 257 * (i % 3) + 5).collect();
    assert_eq!(grey(&INTERLACED).unwrap().texels, Texels::U16(expected));
    // Fewer bits fill the range from 0 to 255.
    let texels = |depth, bytes: &[u8]| grey(&png_of(Grayscale, depth, [4, 1], bytes)).unwrap().texels;
    assert_eq!(texels(One, &[0b0110_0000]), Texels::U8(vec![0, 255, 255, 0]));
    assert_eq!(texels(Two, &[0b00_01_10_11]), Texels::U8(vec![0, 85, 170, 255]));
    assert_eq!(texels(Four, &[0x01, 0x8f]), Texels::U8(vec![0, 17, 136, 255]));
    // One channel of colour, or of a palette's colours.
    let rgba = png_of(Rgba, Eight, [2, 1], &[1, 2, 3, 4, 5, 6, 7, 8]);
    for (at, (name, values)) in
        [("r", [1, 5]), ("g", [2, 6]), ("b", [3, 7]), ("a", [4, 8])].into_iter().enumerate()
    {
        let parsed: Channel = name.parse().unwrap();
        assert_eq!(parsed as usize, at);
        assert_eq!(channel(&rgba, parsed), Ok(Texels::U8(values.to_vec())));
    }
    let wide = png_of(Rgb, Sixteen, [1, 1], &[1, 2, 3, 4, 5, 6]);
    assert_eq!(channel(&wide, Channel::B), Ok(Texels::U16(vec![0x0506])));
    let indexed = png_of(Indexed, Two, [4, 1], &[0b00_01_10_11]);
    assert_eq!(channel(&indexed, Channel::G), Ok(Texels::U8(vec![20, 50, 80, 110])));
    // Alpha beside grey is left unless asked for.
    let both = png_of(GrayscaleAlpha, Eight, [2, 1], &[7, 0, 9, 255]);
    assert_eq!(grey(&both).unwrap().texels, Texels::U8(vec![7, 9]));
    assert_eq!(channel(&both, Channel::A), Ok(Texels::U8(vec![0, 255])));
    // And what makes no sense is said.
    assert!(grey(&rgba).unwrap_err().contains("--channel"));
    assert!(channel(&eight, Channel::R).unwrap_err().contains("grey"));
    assert!(channel(&wide, Channel::A).unwrap_err().contains("no alpha"));
}

#[test]
fn tiff_heights_are_read_as_stored() {
    let eight = tiff_of::<colortype::Gray8>([3, 1], &[0, 127, 255]);
    assert_eq!(grey(&eight), Ok(Grey { width: 3, height: 1, texels: Texels::U8(vec![0, 127, 255]) }));
    let sixteen = tiff_of::<colortype::Gray16>([1, 2], &[1, 65535]);
    assert_eq!(grey(&sixteen), Ok(Grey { width: 1, height: 2, texels: Texels::U16(vec![1, 65535]) }));
    let heights = [-1.5, 0.0, f32::MAX, 1e-30];
    let float = tiff_of::<colortype::Gray32Float>([2, 2], &heights);
    assert_eq!(grey(&float).unwrap().texels, Texels::F32(heights.to_vec()));
    let rgb = tiff_of::<colortype::RGB8>([2, 1], &[1, 2, 3, 4, 5, 6]);
    assert_eq!(channel(&rgb, Channel::G), Ok(Texels::U8(vec![2, 5])));
    assert!(grey(&rgb).unwrap_err().contains("--channel"));
    let whole = tiff_of::<colortype::Gray32>([2, 1], &[1, 2]);
    assert!(grey(&whole).unwrap_err().contains("32-bit float"));
}

#[test]
fn pfm_and_raw_heights_are_read_as_stored() {
    let number = |x: f32, little: bool| if little { x.to_le_bytes() } else { x.to_be_bytes() };
    for (little, scale) in [(true, "-1.0"), (false, "1"), (false, "0.25")] {
        let floats = |all: &[f32]| all.iter().flat_map(|x| number(*x, little)).collect::<Vec<_>>();
        // Rows from the bottom.
        let file =
            [format!("Pf\n3 2\n{scale}\n").as_bytes(), &floats(&[4.0, 5.0, 6.0, 1.0, 2.0, 3.0])].concat();
        let texels = Texels::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(grey(&file), Ok(Grey { width: 3, height: 2, texels }));
        let file = [format!("PF 1 1 {scale} ").as_bytes(), &floats(&[0.25, -7.0, 3.0])].concat();
        assert_eq!(channel(&file, Channel::G), Ok(Texels::F32(vec![-7.0])));
    }
    assert_eq!(raw(&[1, 2, 3, 4, 5, 6], 3, 2), Ok(Texels::U8(vec![1, 2, 3, 4, 5, 6])));
    assert_eq!(raw(&[1, 2, 3, 4, 5, 6], 3, 1), Ok(Texels::U16(vec![0x0201, 0x0403, 0x0605])));
    assert_eq!(raw(&1.5f32.to_le_bytes(), 1, 1), Ok(Texels::F32(vec![1.5])));
    assert!(raw(&[1, 2, 3, 4, 5], 3, 2).unwrap_err().contains("5 bytes: 3 x 2 raw texels are 6, 12 or 24"));
    assert!(raw(&[0; 48], 4, 4).unwrap_err().contains("48 bytes"), "3 bytes a texel are nothing");
    assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
    for text in ["640", "640x", "x480", "-1x2", "6x4x2", "1e3x2", ""] {
        assert!(text.parse::<Size>().is_err(), "{text}");
    }
}

/// Small valid files of every kind.
fn valid() -> Vec<(&'static str, Vec<u8>)> {
    use png::BitDepth::{Eight, Sixteen, Two};
    use png::ColorType::{Grayscale, Indexed, Rgba};
    let ramp: Vec<u8> = (0..240).collect();
    let words: Vec<u16> = (0..60).map(|x| x * 1000).collect();
    let floats: Vec<f32> = (0..60).map(|x| x as f32 / 7.0).collect();
    let mut pfm = vec![];
    write(&mut pfm, Format::Pfm, 6, Pixels::GreyF32(&floats), |_| ()).unwrap();
    vec![
        ("png 8", png_of(Grayscale, Eight, [12, 20], &ramp)),
        ("png 16", png_of(Grayscale, Sixteen, [12, 10], &ramp)),
        ("png rgba", png_of(Rgba, Eight, [6, 10], &ramp)),
        ("png palette", png_of(Indexed, Two, [24, 40], &ramp)),
        ("png interlaced", INTERLACED.to_vec()),
        ("tiff 8", tiff_of::<colortype::Gray8>([12, 20], &ramp)),
        ("tiff 16", tiff_of::<colortype::Gray16>([6, 10], &words)),
        ("tiff float", tiff_of::<colortype::Gray32Float>([6, 10], &floats)),
        ("tiff rgb", tiff_of::<colortype::RGB8>([8, 10], &ramp)),
        ("pfm", pfm),
    ]
}

/// Whatever the bytes: an image of the size it claims, or one line.
fn survives(bytes: &[u8], channel: Option<Channel>, size: Option<Size>) -> Result<(), TestCaseError> {
    match read(Cursor::new(bytes), channel, size) {
        Ok(Grey { width, height, texels }) => {
            let length = match texels {
                Texels::U8(all) => all.len(),
                Texels::U16(all) => all.len(),
                Texels::F32(all) => all.len(),
            };
            prop_assert_eq!(length, width * height);
            prop_assert!(length > 0 && length as u64 <= MOST_TEXELS);
        }
        Err(line) => prop_assert!(!line.is_empty() && !line.contains('\n'), "{:?}", line),
    }
    Ok(())
}

#[test]
fn no_truncation_panics() {
    for (name, file) in valid() {
        for end in 0..file.len() {
            survives(&file[..end], None, None).unwrap_or_else(|error| panic!("{name} to {end}: {error}"));
        }
        let half = &file[..file.len() / 2];
        for channel in [None, Some(Channel::R)] {
            assert!(read(Cursor::new(half), channel, None).is_err(), "half of {name} is no image");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_change_of_bytes_panics(
        which in 0..10usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        early: bool,
        channel in prop::sample::select(vec![None, Some(Channel::R), Some(Channel::A)]),
    ) {
        let (_, mut file) = valid().swap_remove(which);
        // Headers are where the harm is.
        let reach = if early { file.len().min(64) } else { file.len() };
        for (at, byte) in changes {
            file[at.index(reach)] = byte;
        }
        // A PNG checks its chunks; with the sums made right, the change is read.
        survives(&file, channel, None)?;
        survives(&summed(file), channel, None)?;
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), magic in 0..4usize,
                      width in 0..30usize, height in 0..30usize) {
        survives(&bytes, None, Some(Size { width, height }))?;
        let magic = [&b"\x89PNG\r\n\x1a\n"[..], b"II\x2a\0\x08\0\0\0", b"MM\0\x2a\0\0\0\x08", b"Pf 4 "][magic];
        survives(&[magic, &bytes].concat(), None, None)?;
    }
}

/// The file with the checksums of its PNG chunks made right.
fn summed(mut file: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while at + 12 <= file.len() {
        let length = u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= file.len()) else { break };
        let sum = crc(&file[at + 4..end]);
        file[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
    file
}

/// CRC-32 bit by bit, from the PNG specification.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn headers_that_lie_are_refused_before_anything_is_allocated() {
    let png = |width: u32, height: u32| {
        let mut file = png_of(png::ColorType::Grayscale, png::BitDepth::Eight, [1, 1], &[0]);
        file[16..20].copy_from_slice(&width.to_be_bytes());
        file[20..24].copy_from_slice(&height.to_be_bytes());
        grey(&summed(file)).unwrap_err()
    };
    assert!(png(1 << 20, 1 << 20).contains("more than the 268435456 that are read"));
    assert!(png(16384, 16384).contains("cut short"), "{}", png(16384, 16384));
    let pfm = |header: &str| grey(header.as_bytes()).unwrap_err();
    assert!(pfm("Pf\n4000000000 4000000000\n-1\n").contains("more than"));
    assert!(pfm("Pf\n99999999999999999999 1\n-1\n").contains("is no size"));
    assert!(pfm("Pf\n18446744073709551615 2\n-1\n").contains("more than"));
    assert!(pfm("Pf\n100 100\n-1\n1234").contains("4 bytes for 100 x 100 texels"));
    assert!(pfm("Pf\n0 5\n-1\n").contains("no image") && pfm("Pf\n1 1\nx\n").contains("scale"));
    assert!(pfm("Pf\n1 1\n0\n0000").contains("scale") && pfm("Pf\n1 1").contains("ends"));
    assert!(raw(&[0; 9], usize::MAX, 2).unwrap_err().contains("more than"));
    assert!(raw(&[0; 9], 0, 9).unwrap_err().contains("no image"));
    assert!(grey(b"").unwrap_err().contains("empty"));
    assert!(grey(b"GIF89a").unwrap_err().contains("--size"));
}

/// The names of a PNG's chunks.
fn chunks(file: &[u8]) -> Vec<String> {
    let (mut at, mut names) = (8, vec![]);
    while at < file.len() {
        let length = u32::from_be_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        names.push(String::from_utf8(file[at + 4..at + 8].to_vec()).unwrap());
        at += length + 12;
    }
    names.dedup();
    names
}

#[test]
fn what_is_written_is_read_back() {
    let png_of = |pixels| {
        let mut file = vec![];
        write(&mut file, Format::Png, 2, pixels, |_| ()).unwrap();
        assert_eq!(chunks(&file), ["IHDR", "IDAT", "IEND"], "no gamma, no profile, no colours");
        let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (2, 1));
        (info.color_type, info.bit_depth, bytes)
    };
    use png::BitDepth::{Eight, Sixteen};
    use png::ColorType::Rgb;
    assert_eq!(png_of(Pixels::Rgb8(&[[1, 2, 3], [4, 5, 6]])), (Rgb, Eight, vec![1, 2, 3, 4, 5, 6]));
    assert_eq!(png_of(Pixels::Rg8(&[[1, 2], [4, 5]])), (Rgb, Eight, vec![1, 2, 0, 4, 5, 0]));
    assert_eq!(
        png_of(Pixels::Rgb16(&[[0x102, 0x304, 0x506], [0x708, 9, 10]])),
        (Rgb, Sixteen, vec![1, 2, 3, 4, 5, 6, 7, 8, 0, 9, 0, 10])
    );
    let blue_is_0 = vec![1, 2, 3, 4, 0, 0, 5, 6, 7, 8, 0, 0];
    assert_eq!(png_of(Pixels::Rg16(&[[0x102, 0x304], [0x506, 0x708]])), (Rgb, Sixteen, blue_is_0));

    let raw_of = |pixels| {
        let mut file = vec![];
        write(&mut file, Format::Raw, 1, pixels, |_| ()).unwrap();
        file
    };
    assert_eq!(raw_of(Pixels::Rg8(&[[1, 2], [3, 4]])), [1, 2, 3, 4]);
    assert_eq!(raw_of(Pixels::Rg16(&[[0x102, 0x304]])), [2, 1, 4, 3]);
    let floats = [1.5f32, -0.25, 1e-9].map(f32::to_le_bytes).concat();
    assert_eq!(raw_of(Pixels::F32(&[[1.5, -0.25, 1e-9]])), floats);

    // PFM: the bottom row first, and every row told.
    let mut file = vec![];
    let told = std::cell::RefCell::new(vec![]);
    let two = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    write(&mut file, Format::Pfm, 1, Pixels::F32(&two), |row| told.borrow_mut().push(row)).unwrap();
    let floats = [4.0f32, 5.0, 6.0, 1.0, 2.0, 3.0].map(f32::to_le_bytes).concat();
    assert_eq!(file, [b"PF\n1 2\n-1.0\n", &floats[..]].concat());
    assert_eq!(told.into_inner(), [1, 2]);
    assert_eq!(channel(&file, Channel::B), Ok(Texels::F32(vec![3.0, 6.0])));
    assert!(write(vec![], Format::Png, 1, Pixels::F32(&two), |_| ()).is_err());
}

#[test]
fn a_file_is_written_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("kutta-whole-{}", std::process::id()));
    std::fs::create_dir(&folder).unwrap();
    let path = folder.join("out.raw");
    let names = || {
        let mut names: Vec<_> = std::fs::read_dir(&folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let mut file = whole::Whole::create(&path).unwrap();
    file.write_all(b"half").unwrap();
    assert!(!path.exists() && names().len() == 1);
    drop(file);
    assert!(names().is_empty(), "given up, it leaves nothing");
    std::fs::write(&path, "old").unwrap();
    let mut file = whole::Whole::create(&path).unwrap();
    file.write_all(b"new and whole").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    file.finish().unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"new and whole");
    assert_eq!(names(), ["out.raw"]);
    assert!(whole::Whole::create(&folder).is_err() && names().len() == 1);
    std::fs::remove_dir_all(folder).unwrap();
}
