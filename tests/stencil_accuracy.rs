//! The accuracy of baked normals on known surfaces, against figures of another program.

use kutta::normals::accuracy::{Error, Field, Input, Output, Surface};
use kutta::normals::stencils;

/// How far a figure may be from the printed one beside half a unit of its last digit.
struct Slack {
    /// In degrees, of the root mean square and of the largest error.
    floor: [f64; 2],
    /// As a share of the printed figure.
    share: [f64; 2],
}

/// Heights of 10 texels in f32 have an error of 5e-7 texels, 3e-5 degrees; which texels it hits differs with the
/// order of the sums.
const SMOOTH: Slack = Slack { floor: [1.5e-5, 4e-5], share: [0.0; 2] };
/// Heights of 200 texels have twenty times that. The other program rounded in every product too, or worked in
/// f64, so that its floor lies up to 1e-3 above or below.
const DOME: Slack = Slack { floor: [3.5e-4, 1.2e-3], share: [0.0; 2] };
/// Another random field of the same statistics. Half of the 6434 waves of 8 texels or longer have independent
/// amplitudes whose squares are spread exponentially, so that a mean square scatters by 1.2 % and its root by 0.6 %,
/// in both fields: 3 % are more than three standard deviations. The largest of 262144 angles scatters more.
const NOISE: Slack = Slack { floor: [0.0; 2], share: [0.03, 0.25] };

/// Compares all columns of the surface in a section of the table.
fn check(section: &str, word: &str, surface: Surface, slack: &Slack) {
    let table: toml::Table = include_str!("data/accuracy.toml").parse().unwrap();
    let table = table[section].as_table().unwrap();
    let field = Field::of(surface);
    let mut wrong = vec![];
    let columns = table["columns"].as_array().unwrap().iter().map(|column| column.as_str().unwrap());
    let columns: Vec<_> = columns.enumerate().filter(|(_, column)| column.starts_with(word)).collect();
    assert!(!columns.is_empty());
    for (i, column) in columns {
        let (input, output) = match column.strip_prefix(word).unwrap().trim() {
            "16" => (Input::Sixteen, Output::Float),
            "8" => (Input::Eight, Output::Float),
            "8 dithered" => (Input::EightDithered, Output::Float),
            "8 rgb8" => (Input::Eight, Output::Rgb8),
            "rgb8" => (Input::Float, Output::Rgb8),
            "cut" => (Input::Float, Output::Rgb8Cut),
            _ => (Input::Float, Output::Float),
        };
        for (name, row) in table.iter().filter(|(name, _)| *name != "columns") {
            let stencil = stencils::find(name).unwrap_or_else(|| panic!("{name} is missing")).stencil;
            let Error { rms, max } = field.error(stencil, input, output).unwrap();
            for (which, (found, printed)) in
                [rms, max].into_iter().zip(row[i].as_str().unwrap().split('/')).enumerate()
            {
                let known: f64 = printed.parse().unwrap();
                let off = (found - known).abs();
                if !(off <= half_a_unit(printed) + slack.floor[which] + slack.share[which] * known) {
                    wrong.push(format!(
                        "{name}, {column}: {found:.4e}, not {printed} ({})",
                        ["rms", "max"][which]
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Of the last digit that is printed: `.0387`, `9.1`, `7e-5`.
fn half_a_unit(printed: &str) -> f64 {
    let (digits, exponent) = printed.split_once('e').unwrap_or((printed, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, part)| part.len() as i32);
    // Ties are no matter of the last bit.
    0.5000001 * 10f64.powi(exponent.parse::<i32>().unwrap() - decimals)
}

#[test]
fn sine_waves() {
    for wavelength in [64.0, 16.0, 8.0] {
        check("float", &format!("sine {wavelength}"), Surface::Sine { wavelength }, &SMOOTH);
    }
    check("float", "diagonal", Surface::Diagonal, &SMOOTH);
}

#[test]
fn a_bell() {
    check("float", "gaussian", Surface::Gaussian, &SMOOTH);
}

#[test]
fn a_dome_in_float() {
    check("float", "dome", Surface::Dome, &DOME);
}

#[test]
fn a_dome_in_few_bits() {
    check("stored", "dome", Surface::Dome, &DOME);
}

#[test]
fn noise_of_8_texels() {
    check("float", "noise 8", Surface::Noise { shortest: 8.0 }, &NOISE);
}

#[test]
fn noise_of_4_texels() {
    check("float", "noise 4", Surface::Noise { shortest: 4.0 }, &NOISE);
}

#[test]
fn noise_in_few_bits() {
    check("stored", "noise", Surface::Noise { shortest: 8.0 }, &NOISE);
}

/// The field is what it claims to be: slopes of its heights, 1/2 in the mean, heights over about 35 texels.
#[test]
fn noise_has_its_statistics() {
    let field = Field::of(Surface::Noise { shortest: 8.0 });
    let square: f64 = field.slopes.iter().flatten().flatten().map(|x| x * x).sum();
    assert!(((square / field.heights.len() as f64).sqrt() - 0.5).abs() < 1e-12);
    let most = field.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = field.heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((25.0..45.0).contains(&(most - least)), "{}", most - least);
}
