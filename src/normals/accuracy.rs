//! How far baked normals are from the exact ones, on height fields whose slopes are known.
//!
//! ```
//! use kutta::normals::accuracy::{Field, Input, Output, Surface};
//! use kutta::normals::stencils::{CENTRAL2, CENTRAL4};
//!
//! let waves = Field::of(Surface::Sine { wavelength: 16.0 });
//! let error = waves.error(&CENTRAL2, Input::Float, Output::Float)?;
//! assert!(error.rms < 0.63 && error.max < 0.75); // degrees
//! assert!(waves.error(&CENTRAL4, Input::Float, Output::Float)?.rms < 0.02);
//! # Ok::<(), kutta::normals::BakeError>(())
//! ```

mod noise;
mod surface;

pub use surface::{Field, Surface};

use super::{Bake, BakeError, Height, Heights, Normal, Stencil};

/// How the heights are stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Input {
    /// `f32`.
    Float,
    /// Whole numbers to 65535, over the range of the heights.
    Sixteen,
    /// Whole numbers to 255.
    Eight,
    /// The same with triangular noise of one unit before rounding.
    EightDithered,
}

/// How the normals are stored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Output {
    Float,
    /// Three bytes, rounded.
    Rgb8,
    /// Three bytes, cut: what a cast from float to byte does.
    Rgb8Cut,
}

/// The angle between baked and exact normals, in degrees.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Error {
    pub rms: f64,
    pub max: f64,
}

impl Field {
    /// Bakes the field with a stencil and compares with its normals at the texels.
    ///
    /// # Errors
    /// A stencil that [`Bake`] cannot use.
    pub fn error(&self, stencil: &Stencil, input: Input, output: Output) -> Result<Error, BakeError> {
        let [least, most] = self.extremes();
        let (bake, range) = (Bake::new(stencil), most - least);
        let mut random = noise::Random::new(2);
        let mut whole = |height: f64, top: f64| {
            let dithered = input == Input::EightDithered;
            let dither = if dithered { random.uniform() - random.uniform() } else { 0.0 };
            ((height - least) / range * top + dither).round().clamp(0.0, top)
        };
        match input {
            Input::Float => self.compare(&bake, self.heights.iter().map(|h| *h as f32).collect(), output),
            Input::Sixteen => {
                let heights = self.heights.iter().map(|h| whole(*h, 65535.0) as u16).collect();
                self.compare(&bake.height_scale(range), heights, output)
            }
            Input::Eight | Input::EightDithered => {
                let heights = self.heights.iter().map(|h| whole(*h, 255.0) as u8).collect();
                self.compare(&bake.height_scale(range), heights, output)
            }
        }
    }

    fn extremes(&self) -> [f64; 2] {
        let fold = |start, f: fn(f64, f64) -> f64| self.heights.iter().copied().fold(start, f);
        [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
    }

    fn compare(&self, bake: &Bake, heights: Vec<impl Height>, output: Output) -> Result<Error, BakeError> {
        let [width, height] = self.size;
        let heights = Heights::new(&heights, width, height)?;
        let normals = match output {
            Output::Float => bake.normals::<[f32; 3]>(&heights)?,
            Output::Rgb8 => bake.normals::<[u8; 3]>(&heights)?.into_iter().map(Normal::unpack).collect(),
            Output::Rgb8Cut => bake.normals::<[f32; 3]>(&heights)?.into_iter().map(cut).collect(),
        };
        let (mut sum, mut max, mut count) = (0.0, 0f64, 0usize);
        for (normal, slopes) in normals.into_iter().zip(&self.slopes) {
            // Outside of the part that counts there is no exact slope.
            let Some([s, t]) = slopes else { continue };
            let angle = angle(normal.map(f64::from), [-s, -t, 1.0]);
            sum += angle * angle;
            max = max.max(angle);
            count += 1;
        }
        Ok(Error { rms: (sum / count as f64).sqrt(), max })
    }
}

/// A normal whose bytes were cut, read back.
fn cut(normal: [f32; 3]) -> [f32; 3] {
    normal.map(|x| ((x + 1.0) / 2.0 * 255.0) as u8).unpack()
}

/// The angle between two vectors in degrees, exact for small angles too.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let sine = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    let cosine: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    sine.atan2(cosine).to_degrees()
}
