//! `kutta light HEIGHT OUT`: a small picture that shows what a height map does to a lit surface.

mod scene;
mod shade;

use super::image::{Format, Pixels, write};
use super::relief::{self, Relief, number};
use super::whole::Whole;
use super::{Failure, print};
use indicatif::ProgressBar;
use nalgebra::{Vector2, Vector3};
use scene::{Scene, Shape, direction};
use shade::{Mode, Texture};
use std::path::PathBuf;
use std::str::FromStr;

/// Between the panels, and around what is in sight.
const GAP: usize = 8;
const GROUND: Vector3<f64> = Vector3::new(0.13, 0.13, 0.13);
/// Points a pixel each way.
const FINE: usize = 2;
/// Most pixels of a panel's width, and of the whole picture.
const MOST: usize = 4096;
const MOST_PIXELS: f64 = 268435456.0;

/// Render a lit quad or cylinder with a height map on it, one panel for each mode
///
/// Light and eye are far away. The light's azimuth counts counterclockwise from the right of the map (90: from
/// its top), elevations count from the surface, and the eye stands over the lower edge.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    relief: Relief,
    /// Picture: a PNG
    #[arg(value_name = "OUT")]
    out: PathBuf,
    #[arg(long, value_enum, default_value = "quad")]
    shape: Shape,
    /// Azimuth and elevation of the light in degrees
    #[arg(long, value_name = "AZ,EL", default_value = "135,45", allow_hyphen_values = true)]
    light: Angles,
    /// Elevation of the eye in degrees; 90 looks straight down
    #[arg(long, value_name = "EL", default_value = "50", allow_hyphen_values = true)]
    view: Elevation,
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "flat,bump,normal-map,parallax,offset-limited"
    )]
    modes: Vec<Mode>,
    /// Width of a panel in pixels
    #[arg(long, value_name = "N", default_value = "256")]
    pixels: usize,
}

#[derive(Clone, Copy)]
struct Angles([f64; 2]);

impl FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (azimuth, elevation) = text.split_once(',').ok_or("azimuth and elevation, such as 135,45")?;
        let angles = [number(azimuth)?, number(elevation)?];
        if !(-90.0..=90.0).contains(&angles[1]) {
            return Err("an elevation is from -90 to 90 degrees".to_string());
        }
        Ok(Self(angles))
    }
}

#[derive(Clone, Copy)]
struct Elevation(f64);

impl FromStr for Elevation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let elevation = number(text)?;
        if !(1.0..=90.0).contains(&elevation) {
            return Err("the eye's elevation is from 1 to 90 degrees".to_string());
        }
        Ok(Self(elevation))
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let out = args.out.display();
    if Format::of(&args.out.to_string_lossy()) != Some(Format::Png) {
        return Err(Failure::Input(format!("{out}: the picture is a PNG, by its ending")));
    }
    if !(1..=MOST).contains(&args.pixels) {
        return Err(Failure::Input(format!("--pixels is {}: it must be from 1 to {MOST}", args.pixels)));
    }
    let source = args.relief.source()?;
    let stencil = source.stencil().map_err(|error| Failure::Input(source.message(&error)))?;
    let file = Whole::create(&args.out).map_err(|error| Failure::Input(format!("{out}: {error}")))?;
    let texture = texture(&args.relief, &stencil)?;
    let scene = Scene::new(args.shape, texture.tile.into(), args.view.0);
    let [azimuth, elevation] = args.light.0;
    let light = scene.seen(direction(azimuth, elevation));

    let [low, high] = scene.extent();
    let pixel = (high.x - low.x) / args.pixels as f64;
    let lines = ((high.y - low.y) / pixel).round().max(1.0);
    let width = GAP + args.modes.len() * (args.pixels + GAP);
    if lines * width as f64 > MOST_PIXELS {
        let line = format!("{lines} lines of {width} pixels are more than the {MOST_PIXELS} that are drawn");
        return Err(Failure::Input(format!("{}: {line}: --pixels makes them fewer", args.relief.input)));
    }
    let height = lines as usize + 2 * GAP;
    let mut picture = vec![GROUND.map(byte).into(); width * height];
    for (panel, mode) in args.modes.iter().enumerate() {
        let left = GAP + panel * (args.pixels + GAP);
        for y in 0..lines as usize {
            for x in 0..args.pixels {
                let colour = mean(|dx, dy| {
                    let view =
                        Vector2::new(low.x + (x as f64 + dx) * pixel, high.y - (y as f64 + dy) * pixel);
                    scene.hit(view).map_or(GROUND, |hit| texture.colour(&hit, *mode, light))
                });
                picture[(y + GAP) * width + left + x] = colour.map(byte).into();
            }
        }
    }
    let failed = |error: String| Failure::Outcome(format!("{out} cannot be written: {error}"));
    let mut file = file;
    write(&mut file, Format::Png, width, Pixels::Rgb8(&picture), |_| ()).map_err(failed)?;
    file.finish().map_err(|error| failed(error.to_string()))?;
    let names: Vec<_> = args.modes.iter().map(clap::ValueEnum::to_possible_value).collect();
    let names: Vec<_> = names.iter().flatten().map(|value| value.get_name()).collect();
    print(&format!("{out}: {width} x {height} pixels: {}\n", names.join(", ")))
}

fn texture(args: &Relief, stencil: &kutta::normals::Stencil) -> Result<Texture, Failure> {
    let image = args.read(&ProgressBar::hidden())?;
    let bake = args.bake(stencil);
    let slopes = relief::slopes(&bake, &image).map_err(|error| args.refused(&error))?;
    let normals = relief::normals(&bake, &image).map_err(|error| args.refused(&error))?;
    let scale = args.height_scale();
    let [w, h] = args.texel_size();
    let heights: Vec<_> = relief::values(&image.texels).into_iter().map(|b| scale * b).collect();
    // Of the sign that prevails, so that a depth map is drawn as it is stored.
    let white = heights.iter().copied().fold(0.0, |most: f64, b| if b.abs() > most.abs() { b } else { most });
    Ok(Texture {
        width: image.width,
        height: image.height,
        tile: Vector2::new(w * image.width as f64, h * image.height as f64),
        border: args.border(),
        heights,
        white: if white == 0.0 { 1.0 } else { white },
        slopes,
        normals,
    })
}

/// The mean of a pixel's points.
fn mean(colour: impl Fn(f64, f64) -> Vector3<f64>) -> Vector3<f64> {
    let place = |i: usize| (i as f64 + 0.5) / FINE as f64;
    let all = (0..FINE * FINE).map(|i| colour(place(i % FINE), place(i / FINE)));
    all.sum::<Vector3<f64>>() / (FINE * FINE) as f64
}

fn byte(x: f64) -> u8 {
    (255.0 * x).round() as u8
}
