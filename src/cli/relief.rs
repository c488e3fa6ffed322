//! What `bake` and `light` read: a height map, and how its numbers become slopes.

use super::image::{self, Channel, Grey, Size, Texels};
use super::{Failure, Source, unknown};
use indicatif::ProgressBar;
use kutta::normals::{Bake, BakeError, Border, Heights, Normal, Stencil, stencils};
use std::fs::File;
use std::io::BufReader;
use std::str::FromStr;

#[derive(clap::Args)]
pub struct Relief {
    /// Height map: PNG, TIFF or PFM as stored, without gamma; raw numbers with --size
    #[arg(value_name = "HEIGHT")]
    pub input: String,
    /// Where the height is in a colour image: r, g, b or a
    #[arg(long, value_name = "CHANNEL")]
    channel: Option<Channel>,
    /// Width and height of a raw file of u8, u16 or f32 (by its length), little-endian
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// A stencil's name (`kutta stencils` lists them), or the path of a .toml file
    #[arg(long, value_name = "NAME", default_value = "central4")]
    stencil: String,
    /// What white (of floats: 1) stands for, in the unit of --texel-size; negative for a depth map
    #[arg(long, value_name = "X", default_value = "1", allow_hyphen_values = true)]
    height_scale: Scale,
    /// Width of a texel, and its height if it differs
    #[arg(long, value_name = "X[,Y]", default_value = "1", allow_hyphen_values = true)]
    texel_size: TexelSize,
    /// Beyond the edges, along s and t: wrap, clamp, mirror or one-sided
    #[arg(long, value_name = "BORDER[,BORDER]", default_value = "wrap")]
    border: Borders,
    /// Take heights that are NaN or infinite for a border, instead of refusing them
    #[arg(long, value_name = "border", value_parser = ["border"])]
    missing: Option<String>,
}

#[derive(Clone, Copy)]
struct Scale(f64);

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        number(text).map(Self)
    }
}

#[derive(Clone, Copy)]
struct TexelSize([f64; 2]);

impl FromStr for TexelSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (x, y) = text.split_once(',').unwrap_or((text, text));
        let size = [number(x)?, number(y)?];
        if size.iter().any(|x| *x <= 0.0) {
            return Err("a texel is wider and higher than 0".to_string());
        }
        Ok(Self(size))
    }
}

#[derive(Clone, Copy)]
struct Borders([Border; 2]);

impl FromStr for Borders {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let one = |text: &str| match text {
            "wrap" => Ok(Border::Wrap),
            "clamp" => Ok(Border::Clamp),
            "mirror" => Ok(Border::Mirror),
            "one-sided" => Ok(Border::OneSided),
            _ => Err("a border is wrap, clamp, mirror or one-sided".to_string()),
        };
        let (s, t) = text.split_once(',').unwrap_or((text, text));
        Ok(Self([one(s)?, one(t)?]))
    }
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or("not a finite number".to_string())
}

impl Relief {
    /// Reads the map; the bar follows the bytes.
    pub fn read(&self, bar: &ProgressBar) -> Result<Grey, Failure> {
        let refused = |error: String| Failure::Input(format!("{}: {error}", self.input));
        let file = File::open(&self.input).map_err(|error| refused(error.to_string()))?;
        let about = file.metadata().map_err(|error| refused(error.to_string()))?;
        if about.is_dir() {
            return Err(refused("it is a folder".to_string()));
        }
        bar.set_length(about.len());
        image::read(bar.wrap_read(BufReader::with_capacity(1 << 18, file)), self.channel, self.size)
            .map_err(refused)
    }

    /// The stencil of that name, or in the file at that path.
    pub fn source(&self) -> Result<Source, Failure> {
        let name = &self.stencil;
        if let Some(entry) = stencils::find(name) {
            return Ok(Source::shipped(entry.name, entry.path, entry.text));
        }
        if name.ends_with(".toml") || name.contains(['/', '\\']) {
            return Source::file(name);
        }
        let all = stencils::all().iter().map(|entry| entry.name);
        Err(unknown("stencil", name, all, "`kutta stencils` shows all, and a path to a .toml file will do"))
    }

    pub fn bake<'s>(&self, stencil: &'s Stencil<'s>) -> Bake<'s> {
        Bake::new(stencil)
            .height_scale(self.height_scale())
            .texel_size(self.texel_size())
            .border(self.border())
            .missing_as_border(self.missing.is_some())
    }

    pub fn height_scale(&self) -> f64 {
        self.height_scale.0
    }

    pub fn texel_size(&self) -> [f64; 2] {
        self.texel_size.0
    }

    pub fn border(&self) -> [Border; 2] {
        self.border.0
    }

    pub fn refused(&self, error: &BakeError) -> Failure {
        let advice = match error.to_string() {
            line if line.contains("finite") => "; --missing border takes such heights for a border",
            _ => "",
        };
        Failure::Input(format!("{}: {error}{advice}", self.input))
    }
}

/// Runs a generic function on the texels, whatever they are.
macro_rules! with_heights {
    ($image:expr, $heights:ident => $body:expr) => {
        match &$image.texels {
            $crate::cli::image::Texels::U8(all) => {
                Heights::new(all, $image.width, $image.height).and_then(|$heights| $body)
            }
            $crate::cli::image::Texels::U16(all) => {
                Heights::new(all, $image.width, $image.height).and_then(|$heights| $body)
            }
            $crate::cli::image::Texels::F32(all) => {
                Heights::new(all, $image.width, $image.height).and_then(|$heights| $body)
            }
        }
    };
}
pub(super) use with_heights;

/// Slopes in world units, rows from the top.
pub fn slopes(bake: &Bake, image: &Grey) -> Result<Vec<[f32; 2]>, BakeError> {
    with_heights!(image, heights => bake.slopes(&heights))
}

/// Unit normals, rows from the top.
pub fn normals<N: Normal>(bake: &Bake, image: &Grey) -> Result<Vec<N>, BakeError> {
    with_heights!(image, heights => bake.normals(&heights))
}

/// The heights of a map as numbers, white being 1; what is missing is 0.
pub fn values(texels: &Texels) -> Vec<f64> {
    match texels {
        Texels::U8(all) => all.iter().map(|x| f64::from(*x) / 255.0).collect(),
        Texels::U16(all) => all.iter().map(|x| f64::from(*x) / 65535.0).collect(),
        Texels::F32(all) => all.iter().map(|x| if x.is_finite() { f64::from(*x) } else { 0.0 }).collect(),
    }
}
