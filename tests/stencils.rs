//! What is derived of the stencils, against values from elsewhere and against theory.

use std::f64::consts::{FRAC_PI_2, PI};

use kutta::normals::{Stencil, stencils};
use kutta::tableau::DoubleDouble;
/// `x` is the printed number to half a unit of its last digit.
fn rounds_to(x: f64, printed: &str) -> bool {
    let decimals = printed.split_once('.').map_or(0, |(_, part)| part.len());
    // Printed figures may themselves have been rounded in the last bit.
    let half = 0.5 * 10f64.powi(-(decimals as i32)) + 1e-12;
    (x - printed.parse::<f64>().unwrap()).abs() <= half
}

#[test]
fn properties_are_those_of_the_table() {
    let text = include_str!("data/stencils.toml");
    let table: toml::Table = text.parse().unwrap();
    assert_eq!(table.len(), 13);
    let mut wrong = vec![];
    for (name, known) in &table {
        let stencil = Stencil { at: DoubleDouble::ZERO, ..*find(name) };
        let p = stencil.properties();
        let whole = |key: &str| known[key].as_integer().unwrap() as usize;
        assert_eq!((p.taps, p.order), (whole("taps"), whole("order")), "{name}");
        let mut expect = |what: &str, x: f64, printed: &toml::Value| {
            let printed = printed.as_str().unwrap();
            if !rounds_to(x, printed) {
                wrong.push(format!("{name}: {what} is {x}, not {printed}"));
            }
        };
        expect("e_xx", p.e_xx, &known["e_xx"]);
        expect("e_yy", p.e_yy, &known["e_yy"]);
        expect("noise gain", p.noise_gain, &known["gain"]);
        for (i, wave) in [16.0, 8.0, 4.0].into_iter().enumerate() {
            let k = 2.0 * PI / wave;
            expect("k'/k", (stencil.modified_wavenumber([k, 0.0]) / k).re, &known["k"][i]);
        }
        expect("wave for 1 %", stencil.shortest_wave(0.01), &known["one_percent"]);
        for (i, wave) in [8.0, 4.0].into_iter().enumerate() {
            expect("direction", stencil.direction_error(wave), &known["direction"][i]);
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

fn find(name: &str) -> &'static Stencil<'static> {
    stencils::find(name).unwrap_or_else(|| panic!("{name} is missing")).stencil
}

/// Half a texel on, the forward difference is half as long a central one.
#[test]
fn a_difference_is_judged_where_it_lives() {
    for (name, at) in [("forward2", 0.5), ("backward2", -0.5)] {
        let stencil = find(name);
        let p = stencil.properties();
        assert_eq!((p.order, p.symmetric, stencil.at.hi()), (2, true, at), "{name}");
        assert!((p.e_xx - 1.0 / 24.0).abs() < 1e-16 && p.e_yy == 0.0);
        let k = 2.0 * PI / 5.0;
        let wave = stencil.modified_wavenumber([k, 0.0]);
        assert!((wave.re - 2.0 * (k / 2.0).sin()).abs() < 1e-15 && wave.im.abs() < 1e-15);
        assert!(!Stencil { at: DoubleDouble::ZERO, ..*stencil }.properties().symmetric);
    }
}

/// Lele 1992, table 1 and equation 3.1.4: the leading error is 4/7! h^6 f^(7), k' = (14/9 sin k + 1/18 sin 2k) /
/// (1 + 2/3 cos k).
#[test]
fn the_compact_stencil_is_that_of_lele() {
    let stencil = find("compact6");
    let p = stencil.properties();
    assert_eq!((p.order, p.compact, p.symmetric), (6, true, true));
    let [term] = p.leading[..] else { panic!("{:?}", p.leading) };
    // Lele's 4/7! is in the equation times 1 + 2 alpha = 5/3.
    assert!((term.coefficient.abs() - 4.0 / 5040.0 / (5.0 / 3.0)).abs() < 1e-17, "{term:?}");
    for k in [0.1, 1.0, FRAC_PI_2, 3.0] {
        let exact = (14.0 / 9.0 * f64::sin(k) + (2.0 * k).sin() / 18.0) / (1.0 + 2.0 / 3.0 * k.cos());
        let wave = stencil.modified_wavenumber([k, 0.0]);
        assert!((wave.re - exact).abs() < 1e-14 && wave.im.abs() < 1e-14, "{k}: {wave}");
    }
    // The gain of the infinite stencil, from the weights that solving the left side for one texel gives:
    // 1/3 r^2 + r + 1/3 = 0, and the inverse has the weights r^|j| / (1 + 2/3 r).
    let r = (-3.0 + 5f64.sqrt()) / 2.0;
    let inverse = |j: i32| r.powi(j.abs()) / (1.0 + 2.0 / 3.0 * r);
    let weight = |j| 7.0 / 9.0 * (inverse(j - 1) - inverse(j + 1)) + (inverse(j - 2) - inverse(j + 2)) / 36.0;
    let gain = (-60..=60).map(|j| f64::powi(weight(j), 2)).sum::<f64>().sqrt();
    assert!((p.noise_gain - gain).abs() < 1e-14, "{} {gain}", p.noise_gain);
}

/// The one-sided difference of order p on p + 1 points has the error (-1)^p / (p + 1) h^p f^(p+1).
#[test]
fn one_sided_stencils_have_the_error_of_newton() {
    for p in [2, 4, 6, 8] {
        let stencil = find(&format!("onesided{p}"));
        let properties = stencil.properties();
        assert_eq!((properties.order, properties.symmetric), (p, false));
        let [term] = properties.leading[..] else { panic!("{:?}", properties.leading) };
        assert_eq!(term.derivative, [p + 1, 0]);
        assert!((term.coefficient.abs() - 1.0 / (p + 1) as f64).abs() < 1e-15, "{term:?}");
        assert!(stencil.modified_wavenumber([1.0, 0.0]).im.abs() > 1e-3);
    }
}

/// The wave across meets the smoothing row alone, and only iso3 has no preferred direction to h^2.
#[test]
fn smoothing_rows_act_across() {
    let sobel = find("sobel3");
    let k: f64 = 0.7;
    let ratio = sobel.modified_wavenumber([0.3, k]) / sobel.modified_wavenumber([0.3, 0.0]);
    assert!((ratio.re - (1.0 + k.cos()) / 2.0).abs() < 1e-15 && ratio.im.abs() < 1e-15);
    for name in ["prewitt3", "sobel3", "scharr3", "central2", "farid5", "farid7"] {
        assert_eq!(find(name).properties().isotropic, 1, "{name}");
    }
    // The term in h^4 would need weights on more texels.
    assert_eq!(find("iso3").properties().isotropic, 3);
}
