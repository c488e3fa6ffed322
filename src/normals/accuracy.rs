//! How far baked normals are from the exact ones, on height fields whose slopes are known.
//!
//! ```
//! use kutta::normals::accuracy::{Field, Input, Output, Surface};
//! use kutta::normals::stencils::{CENTRAL2, CENTRAL4};
//!
//! let waves = Field::of(Surface::Sine { wavelength: 16.0 });
//! let error = waves.error(&CENTRAL2, Input::Float, Output::Float);
//! assert!(error.rms < 0.63 && error.max < 0.75); // degrees
//! assert!(waves.error(&CENTRAL4, Input::Float, Output::Float).rms < 0.02);
//! ```

mod noise;
mod surface;

pub use surface::{Field, Surface};

use super::Stencil;

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
    pub fn error(&self, stencil: &Stencil, input: Input, output: Output) -> Error {
        let slopes = reference::slopes(stencil, &self.stored(input), self.size);
        let (mut sum, mut max, mut count) = (0.0, 0f64, 0usize);
        for (found, exact) in slopes.iter().zip(&self.slopes) {
            // Outside of the part that counts there is no exact slope.
            let Some(exact) = exact else { continue };
            let angle = angle(coded(normal(found.map(f64::from)), output), normal(*exact));
            sum += angle * angle;
            max = max.max(angle);
            count += 1;
        }
        Error { rms: (sum / count as f64).sqrt(), max }
    }

    /// The heights as they are read back.
    fn stored(&self, input: Input) -> Vec<f32> {
        let least = self.heights.iter().copied().fold(f64::INFINITY, f64::min);
        let most = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let range = most - least;
        let mut random = noise::Random::new(2);
        let mut whole = |height: f64, top: f64, dithered: bool| {
            let dither = if dithered { random.uniform() - random.uniform() } else { 0.0 };
            let whole = ((height - least) / range * top + dither).round().clamp(0.0, top);
            ((whole / top) as f32) * range as f32
        };
        let stored = |height: &f64| match input {
            Input::Float => *height as f32,
            Input::Sixteen => whole(*height, 65535.0, false),
            Input::Eight => whole(*height, 255.0, false),
            Input::EightDithered => whole(*height, 255.0, true),
        };
        self.heights.iter().map(stored).collect()
    }
}

/// The unit normal of a surface with these slopes to the right and up.
fn normal([s, t]: [f64; 2]) -> [f64; 3] {
    unit([-s, -t, 1.0])
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// A normal after it was stored and read back.
fn coded(normal: [f64; 3], output: Output) -> [f64; 3] {
    let byte = |x: f64| (x + 1.0) / 2.0 * 255.0;
    let read = |q: f64| 2.0 * q / 255.0 - 1.0;
    match output {
        Output::Float => normal.map(|x| f64::from(x as f32)),
        Output::Rgb8 => unit(normal.map(|x| read((byte(x) + 0.5).floor()))),
        Output::Rgb8Cut => unit(normal.map(|x| read(byte(x).floor()))),
    }
}

/// In degrees; exact for small angles too.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let sine = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    let cosine: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    sine.atan2(cosine).to_degrees()
}
