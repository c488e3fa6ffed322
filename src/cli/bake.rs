//! `kutta bake HEIGHT OUT`: a normal map from a height map.
//!
//! Files are what takes time: a map of 4096 x 4096 heights of 16 bits is read raw in 0.06 s and from a PNG in
//! 0.4 s, baked in 0.04 s and written as an RGB8 PNG in 0.18 s (2026-11-22, two virtual cores of an Intel Xeon).
//! A PNG is written with the fast compression: the balanced one took 5 s for a map of that size.

use super::image::{Format, Grey, Pixels, Texels, write};
use super::relief::{self, Relief};
use super::whole::Whole;
use super::{Failure, print};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use kutta::normals::{Bake, BakeError, Border, Green, Heights, Level, Stencil, mips, stencils};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Bake a normal map from a height map
///
/// OUT ends in .png (8 or 16 bits, no gamma; with two channels blue is 0), .pfm (floats) or .raw (little-endian,
/// rows from the top). Files are written whole: what was there before stays until the new one is complete.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    relief: Relief,
    /// Normal map, ending in .png, .pfm or .raw
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// Channels and their bits; default: rgb8 for .png, f32 for .pfm and .raw
    #[arg(long, value_enum)]
    format: Option<Kind>,
    /// Which way green grows: up (OpenGL, glTF) or down (DirectX)
    #[arg(long, value_enum, default_value = "up")]
    green: Way,
    /// Of the RGB8 texels along a normal take the one that points best, whatever its length
    #[arg(long)]
    best_fit: bool,
    /// Write all mip levels, the means of slopes, as OUT.mip1.png, OUT.mip2.png ..
    #[arg(long)]
    mips: bool,
    /// Write the angle in degrees between these normals and those of a stencil of another order: .pfm, .raw
    #[arg(long, value_name = "FILE")]
    error_map: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Way {
    Up,
    Down,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Rgb8,
    Rgb16,
    Rg8,
    Rg16,
    F32,
}

impl Kind {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string())
    }
}

/// A normal map as it is packed.
enum Packed {
    Rgb8(Vec<[u8; 3]>),
    Rgb16(Vec<[u16; 3]>),
    Rg8(Vec<[u8; 2]>),
    Rg16(Vec<[u16; 2]>),
    F32(Vec<[f32; 3]>),
}

impl Packed {
    fn of_heights(kind: Kind, bake: &Bake, image: &Grey) -> Result<Self, BakeError> {
        Ok(match kind {
            Kind::Rgb8 => Self::Rgb8(relief::normals(bake, image)?),
            Kind::Rgb16 => Self::Rgb16(relief::normals(bake, image)?),
            Kind::Rg8 => Self::Rg8(relief::normals(bake, image)?),
            Kind::Rg16 => Self::Rg16(relief::normals(bake, image)?),
            Kind::F32 => Self::F32(relief::normals(bake, image)?),
        })
    }

    fn of_slopes(kind: Kind, bake: &Bake, slopes: &[[f32; 2]]) -> Self {
        match kind {
            Kind::Rgb8 => Self::Rgb8(bake.pack(slopes)),
            Kind::Rgb16 => Self::Rgb16(bake.pack(slopes)),
            Kind::Rg8 => Self::Rg8(bake.pack(slopes)),
            Kind::Rg16 => Self::Rg16(bake.pack(slopes)),
            Kind::F32 => Self::F32(bake.pack(slopes)),
        }
    }

    fn pixels(&self) -> Pixels<'_> {
        match self {
            Self::Rgb8(all) => Pixels::Rgb8(all),
            Self::Rgb16(all) => Pixels::Rgb16(all),
            Self::Rg8(all) => Pixels::Rg8(all),
            Self::Rg16(all) => Pixels::Rg16(all),
            Self::F32(all) => Pixels::F32(all),
        }
    }
}

/// A file to be written: where, how wide, and what.
struct Leaf {
    path: PathBuf,
    width: usize,
    height: usize,
    packed: Packed,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let (format, kind) = args.target()?;
    let errors = args.error_target()?;
    let source = args.relief.source()?;
    let stencil = source.stencil().map_err(|error| Failure::Input(source.message(&error)))?;
    let green = if args.green == Way::Up { Green::Up } else { Green::Down };
    let bake = args.relief.bake(&stencil).green(green).best_fit(args.best_fit);
    // Before the work, so that a path that cannot be written costs none.
    let first = create(&args.out)?;

    // Drawn on stderr, and only where that is a terminal.
    let bar = ProgressBar::new(1);
    bar.set_style(ProgressStyle::with_template("{msg} {bar:40} {percent}%").expect("a constant template"));
    let (image, read) = timed(&bar, "reading", || args.relief.read(&bar))?;
    let (leaves, baked) = timed(&bar, "baking", || args.leaves(kind, &bake, &image))?;
    let (mut files, written) = timed(&bar, "writing", || {
        bar.set_length(leaves.iter().map(|leaf| leaf.height as u64).sum());
        let mut first = Some(first);
        leaves
            .iter()
            .map(|leaf| {
                let mut file = first.take().map_or_else(|| create(&leaf.path), Ok)?;
                write(&mut file, format, leaf.width, leaf.packed.pixels(), |_| bar.inc(1))
                    .map_err(|error| unwritten(&leaf.path, &error))?;
                Ok((file, leaf.path.as_path()))
            })
            .collect::<Result<Vec<_>, Failure>>()
    })?;
    let mut about = None;
    if let Some((path, format)) = errors {
        let (file, line) = args.error_map(path, format, &stencil, &image)?;
        files.push((file, path));
        about = Some(line);
    }
    for (file, path) in files {
        file.finish().map_err(|error| unwritten(path, &error.to_string()))?;
    }
    bar.finish_and_clear();

    let whole = (read + baked + written).as_secs_f64();
    let files = 100.0 * (read + written).as_secs_f64() / whole.max(f64::MIN_POSITIVE);
    let levels = if args.mips { format!(" and {} mip levels", leaves.len() - 1) } else { String::new() };
    let mut line = format!(
        "{}: {} x {} {}{levels} from {} heights; read in {}, baked in {}, written in {}: files took {files:.0} % of the time\n",
        args.out.display(),
        image.width,
        image.height,
        kind.name(),
        image.texels.words(),
        ms(read),
        ms(baked),
        ms(written),
    );
    line.extend(about);
    line.extend(advice(&bake, &image).map_err(|error| args.relief.refused(&error))?);
    print(&line)
}

impl Args {
    /// What is written, by the ending of the name and --format.
    fn target(&self) -> Result<(Format, Kind), Failure> {
        let out = self.out.display();
        let format = Format::of(&self.out.to_string_lossy());
        let format =
            format.ok_or_else(|| input(format!("{out}: the name must end in .png, .pfm or .raw")))?;
        let default = if format == Format::Png { Kind::Rgb8 } else { Kind::F32 };
        let kind = self.format.unwrap_or(default);
        match format {
            Format::Png if kind == Kind::F32 => {
                Err(input(format!("{out}: a PNG holds no floats: .pfm and .raw do")))
            }
            Format::Pfm if kind != Kind::F32 => {
                Err(input(format!("{out}: a PFM holds floats only, not {}", kind.name())))
            }
            _ if self.best_fit && kind != Kind::Rgb8 => {
                Err(input(format!("--best-fit chooses among rgb8 texels, not {}", kind.name())))
            }
            _ => Ok((format, kind)),
        }
    }

    fn error_target(&self) -> Result<Option<(&Path, Format)>, Failure> {
        let Some(path) = &self.error_map else { return Ok(None) };
        match Format::of(&path.to_string_lossy()) {
            _ if *path == self.out => Err(input(format!("{}: named for the error map too", path.display()))),
            Some(format @ (Format::Pfm | Format::Raw)) => Ok(Some((path, format))),
            _ => Err(input(format!("{}: an error map's name must end in .pfm or .raw", path.display()))),
        }
    }

    fn leaves(&self, kind: Kind, bake: &Bake, image: &Grey) -> Result<Vec<Leaf>, Failure> {
        let refused = |error: BakeError| self.relief.refused(&error);
        let Grey { width, height, .. } = *image;
        if !self.mips {
            let packed = Packed::of_heights(kind, bake, image).map_err(refused)?;
            return Ok(vec![Leaf { path: self.out.clone(), width, height, packed }]);
        }
        let slopes = relief::slopes(bake, image).map_err(refused)?;
        let levels = mips(slopes, width, height).map_err(refused)?;
        let leaf = |(i, level): (usize, &Level)| {
            let end = self.out.extension().map(|end| end.to_string_lossy()).unwrap_or_default();
            let path =
                if i == 0 { self.out.clone() } else { self.out.with_extension(format!("mip{i}.{end}")) };
            let packed = Packed::of_slopes(kind, bake, &level.slopes);
            Leaf { path, width: level.width, height: level.height, packed }
        };
        Ok(levels.iter().enumerate().map(leaf).collect())
    }
}

impl Args {
    /// Writes the angles to the other stencil's normals, in degrees, and has a line about them.
    fn error_map(
        &self,
        path: &Path,
        format: Format,
        stencil: &Stencil,
        image: &Grey,
    ) -> Result<(Whole, String), Failure> {
        let refused = |error: BakeError| self.relief.refused(&error);
        let name = if stencil.order > 2 { "central2" } else { "central4" };
        let other = stencils::find(name).ok_or_else(|| input(format!("there is no stencil {name}")))?;
        let bake = self.relief.bake(stencil);
        let angles = relief::with_heights!(image, heights => bake.error_map(other.stencil, &heights))
            .map_err(refused)?;
        let mut file = create(path)?;
        write(&mut file, format, image.width, Pixels::GreyF32(&angles), |_| ())
            .map_err(|error| unwritten(path, &error))?;
        let square = angles.iter().map(|a| f64::from(*a).powi(2)).sum::<f64>() / angles.len() as f64;
        let most = angles.iter().copied().fold(0.0, f32::max);
        let shown = path.display();
        Ok((file, format!("{shown}: degrees from {name}: RMS {:.2e}, at most {most:.2e}\n", square.sqrt())))
    }
}

/// Texels each way of the part of a map that stencils are weighed on.
const PART: usize = 512;

/// Of 8-bit heights: whether their rounding makes the stencil's order pointless, and which stencil would serve.
/// Judged on the middle of the map.
fn advice(bake: &Bake, image: &Grey) -> Result<Option<String>, BakeError> {
    let Texels::U8(texels) = &image.texels else { return Ok(None) };
    let [width, height] = [image.width, image.height].map(|size| size.min(PART));
    let (left, top) = ((image.width - width) / 2, (image.height - height) / 2);
    let rows = texels.chunks_exact(image.width).skip(top).take(height);
    let part: Vec<u8> = rows.flat_map(|row| &row[left..left + width]).copied().collect();
    let heights = Heights::new(&part, width, height)?;
    // The others that live where a texel is, on both sides of it.
    let serve = |stencil: &Stencil| stencil.at.hi() == 0.0 && stencil.along.first < 0;
    let others: Vec<_> = stencils::all()
        .iter()
        .filter(|entry| serve(entry.stencil))
        .map(|entry| (entry.name, entry.stencil))
        .collect();
    // What is cut out has edges of its own.
    let advice = bake.border([Border::Mirror; 2]).advice(&heights, &others)?;
    Ok(advice.higher_order_is_pointless().then(|| format!("8-bit heights: {advice}\n")))
}

fn input(line: String) -> Failure {
    Failure::Input(line)
}

fn create(path: &Path) -> Result<Whole, Failure> {
    Whole::create(path).map_err(|error| input(format!("{} cannot be written: {error}", path.display())))
}

fn unwritten(path: &Path, error: &str) -> Failure {
    Failure::Outcome(format!("{} cannot be written: {error}", path.display()))
}

fn timed<T>(
    bar: &ProgressBar,
    what: &'static str,
    work: impl FnOnce() -> Result<T, Failure>,
) -> Result<(T, Duration), Failure> {
    bar.reset();
    bar.set_message(what);
    let begun = Instant::now();
    let done = work()?;
    Ok((done, begun.elapsed()))
}

fn ms(time: Duration) -> String {
    let ms = 1e3 * time.as_secs_f64();
    if ms < 10.0 { format!("{ms:.1} ms") } else { format!("{ms:.0} ms") }
}
