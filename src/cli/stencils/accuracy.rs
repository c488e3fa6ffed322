//! `kutta stencils --accuracy`: the error of baked normals on surfaces whose normals are known.

use super::super::{Failure, print, print_json};
use kutta::normals::Stencil;
use kutta::normals::accuracy::{Error, Field, Input, Output, Surface};
use serde::Serialize;
use std::fmt::Write;

const NOISE: Surface = Surface::Noise { shortest: 8.0 };

/// Each surface with the title of its column.
const SURFACES: [(&str, Surface); 8] = [
    ("sine 64", Surface::Sine { wavelength: 64.0 }),
    ("sine 16", Surface::Sine { wavelength: 16.0 }),
    ("sine 8", Surface::Sine { wavelength: 8.0 }),
    ("diagonal", Surface::Diagonal),
    ("gaussian", Surface::Gaussian),
    ("dome", Surface::Dome),
    ("noise 8", NOISE),
    ("noise 4", Surface::Noise { shortest: 4.0 }),
];

/// Ways to store heights and normals, on the surfaces where that shows.
const STORED: [(&str, Input, Output); 6] = [
    ("16>float", Input::Sixteen, Output::Float),
    ("8>float", Input::Eight, Output::Float),
    ("8d>float", Input::EightDithered, Output::Float),
    ("8>rgb8", Input::Eight, Output::Rgb8),
    ("float>rgb8", Input::Float, Output::Rgb8),
    ("float>cut", Input::Float, Output::Rgb8Cut),
];

#[derive(Serialize)]
struct Measured<'n> {
    stencil: &'n str,
    surface: &'static str,
    /// `float>float`, heights before the arrow.
    stored: &'static str,
    /// Degrees.
    rms: f64,
    max: f64,
}

pub fn run(all: &[(&str, Stencil)], json: bool) -> Result<(), Failure> {
    let mut measured = vec![];
    for (surface, of) in SURFACES {
        let field = Field::of(of);
        let few_bits = STORED.iter().filter(|_| of == Surface::Dome || of == NOISE);
        let ways: Vec<_> =
            [("float>float", Input::Float, Output::Float)].iter().chain(few_bits).copied().collect();
        for &(stencil, ref table) in all {
            for &(stored, input, output) in &ways {
                let Error { rms, max } = field
                    .error(table, input, output)
                    .map_err(|error| Failure::Input(format!("{stencil} cannot bake: {error}")))?;
                measured.push(Measured { stencil, surface, stored, rms, max });
            }
        }
    }
    if json { print_json(&measured) } else { print(&tables(all, &measured)) }
}

fn tables(all: &[(&str, Stencil)], measured: &[Measured]) -> String {
    let mut out = "Angles between baked and exact normals in degrees, root mean square / largest; heights and \
                   normals are\nfloat. Sine waves of 64, 16, 8 texels, of 8 along the diagonal; a bell 4 texels \
                   wide; a dome of radius 200;\nnoise without waves shorter than 8 or 4 texels. Slopes to 45 \
                   degrees, of the noise 1/2 in the mean.\n\n"
        .to_string();
    let find = |stencil: &str, surface: &str, stored: &str| {
        measured.iter().find(|m| m.stencil == stencil && m.surface == surface && m.stored == stored)
    };
    let float = SURFACES.map(|(surface, _)| (surface.to_string(), surface, "float>float"));
    table(&mut out, all, &float, |stencil, surface, stored| {
        find(stencil, surface, stored).map(|m| format!("{}/{}", degrees(m.rms), degrees(m.max)))
    });
    out += "\nThe same where heights > normals are stored in 16 or 8 bits (8d: dithered; cut: not rounded), \
            root mean\nsquare.\n";
    for surface in ["dome", "noise 8"] {
        let _ = writeln!(out, "\n{surface}");
        let columns = STORED.map(|(stored, ..)| (stored.to_string(), surface, stored));
        table(&mut out, all, &columns, |stencil, surface, stored| {
            find(stencil, surface, stored).map(|m| degrees(m.rms))
        });
    }
    out
}

fn table(
    out: &mut String,
    all: &[(&str, Stencil)],
    columns: &[(String, &str, &str)],
    cell: impl Fn(&str, &str, &str) -> Option<String>,
) {
    let mut rows = vec![[vec!["name".to_string()], columns.iter().map(|c| c.0.clone()).collect()].concat()];
    for (name, _) in all {
        let cells =
            columns.iter().map(|(_, surface, stored)| cell(name, surface, stored).unwrap_or_default());
        rows.push([vec![name.to_string()], cells.collect()].concat());
    }
    let widths: Vec<_> =
        (0..=columns.len()).map(|j| rows.iter().map(|row| row[j].len()).max().unwrap_or(0)).collect();
    for row in rows {
        let line: String = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}  ")).collect();
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// Three digits: `12.3`, `.0387`, `7.4e-5`.
fn degrees(x: f64) -> String {
    if x < 1e-3 {
        return format!("{x:.1e}");
    }
    let decimals = (2 - x.log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    text.strip_prefix('0').map_or(text.clone(), str::to_string)
}
