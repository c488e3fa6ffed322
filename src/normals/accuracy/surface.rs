//! Height fields with their exact slopes.

use super::noise;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// A height field in texels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Surface {
    /// A sine wave to the right, with slopes up to 45 degrees. The wavelength, in texels, divides 512.
    Sine { wavelength: f64 },
    /// The same along the diagonal, 45 waves on 512 texels each way: a wavelength of 8.05.
    Diagonal,
    /// A bell of standard deviation 4 with slopes up to 45 degrees, out to four times that.
    Gaussian,
    /// A hemisphere of radius 200, out to nine tenths of that.
    Dome,
    /// Waves of random phase on 512 x 512 texels, none shorter than `shortest`, of amplitude k^(-3/2), the root
    /// mean square of the gradient 1/2.
    Noise { shortest: f64 },
}

/// Heights, and slopes to the right and up where they count; rows from top to bottom, periodic.
#[derive(Clone, Debug)]
pub struct Field {
    pub size: [usize; 2],
    pub heights: Vec<f64>,
    pub slopes: Vec<Option<[f64; 2]>>,
}

/// Side of the fields that repeat.
pub(super) const SIDE: usize = 512;

impl Field {
    pub fn of(surface: Surface) -> Self {
        match surface {
            Surface::Sine { wavelength } => {
                // A phase that lets no texel sit on a crest.
                let k = 2.0 * PI / wavelength;
                Self::sampled([SIDE, 8], |[x, _]| {
                    let phase = k * x + 0.3;
                    (phase.sin() / k, Some([phase.cos(), 0.0]))
                })
            }
            Surface::Diagonal => {
                let along = 2.0 * PI * 45.0 / SIDE as f64;
                let k = along / FRAC_1_SQRT_2;
                Self::sampled([SIDE, SIDE], |[x, y]| {
                    let phase = along * (x + y) + 0.3;
                    (phase.sin() / k, Some([FRAC_1_SQRT_2 * phase.cos(); 2]))
                })
            }
            Surface::Gaussian => {
                const S: f64 = 4.0;
                let top = S * 0.5f64.exp();
                Self::sampled([64, 64], |[x, y]| {
                    let [x, y] = [x - 32.3, y - 31.6];
                    let height = top * (-(x * x + y * y) / (2.0 * S * S)).exp();
                    let slopes = [-x / (S * S) * height, -y / (S * S) * height];
                    (height, (x * x + y * y <= 16.0 * S * S).then_some(slopes))
                })
            }
            Surface::Dome => {
                const R: f64 = 200.0;
                Self::sampled([448, 448], |[x, y]| {
                    let [x, y] = [x - 223.5, y - 223.5];
                    let square = x * x + y * y;
                    let height = (R * R - square).max(0.0).sqrt();
                    (height, (square <= 0.81 * R * R).then(|| [-x / height, -y / height]))
                })
            }
            Surface::Noise { shortest } => noise::field(shortest),
        }
    }

    /// `f` gives the height and the slopes at x to the right and y up.
    fn sampled(size: [usize; 2], f: impl Fn([f64; 2]) -> (f64, Option<[f64; 2]>)) -> Self {
        let [width, height] = size;
        let texels = (0..width * height).map(|i| f([(i % width) as f64, (height - 1 - i / width) as f64]));
        let (heights, slopes) = texels.unzip();
        Self { size, heights, slopes }
    }
}
