//! `kutta stencils`: all stencils and what is derived of them, and their accuracy.

mod draw;

use super::words::{short, yes};
use super::{Failure, Source, print, print_json};
use draw::draw;
use kutta::normals::{Properties, Stencil, stencils};
use kutta::tableau::{DoubleDouble, entries, value};
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::fmt::Write;

/// List the stencils that normal maps are baked with
#[derive(clap::Args)]
pub struct Args {
    /// Add a stencil file of yours; may be given more than once
    #[arg(long, value_name = "FILE")]
    stencil: Vec<String>,
    /// Print JSON for scripts
    #[arg(long)]
    json: bool,
}

/// Wavelengths in texels at which the modified wavenumber is shown.
const WAVES: [f64; 3] = [16.0, 8.0, 4.0];

/// What the JSON says of every stencil.
#[derive(Serialize)]
struct Item<'t> {
    name: &'t str,
    title: &'t str,
    order: usize,
    /// The order of its slope taken as that at the texel.
    order_at_texel: usize,
    taps: usize,
    compact: bool,
    symmetric: bool,
    at: f64,
    e_xx: f64,
    e_yy: f64,
    /// Coefficients of h^order times derivatives, as `[coefficient, times along, times across]`.
    leading: Vec<(f64, usize, usize)>,
    isotropic: usize,
    noise_gain: f64,
    /// k'/k for waves along the axis of 16, 8 and 4 texels, real and imaginary part.
    wavenumber: [[f64; 2]; 3],
    /// The factor on waves of 16, 8 and 4 texels across.
    across: [f64; 3],
    one_percent: f64,
    direction_error: [f64; 2],
}

impl<'t> Item<'t> {
    fn of(name: &'t str, stencil: &Stencil<'t>) -> Self {
        let p = stencil.properties();
        Self {
            name,
            title: stencil.title,
            order: p.order,
            order_at_texel: at_texel(stencil).order,
            taps: p.taps,
            compact: p.compact,
            symmetric: p.symmetric,
            at: stencil.at.hi(),
            e_xx: p.e_xx,
            e_yy: p.e_yy,
            leading: p.leading.iter().map(|t| (t.coefficient, t.derivative[0], t.derivative[1])).collect(),
            isotropic: p.isotropic,
            noise_gain: p.noise_gain,
            wavenumber: WAVES.map(|wave| ratio(stencil, wave)),
            across: WAVES.map(|wave| across(stencil, wave)),
            one_percent: stencil.shortest_wave(0.01),
            direction_error: [8.0, 4.0].map(|wave| stencil.direction_error(wave)),
        }
    }

    fn lives(&self) -> String {
        let place = if self.at == 0.0 { "the texel" } else { half(self.at) };
        match self.order_at_texel {
            order if order == self.order => place.to_string(),
            order => format!("{place} (order {order} at the texel)"),
        }
    }
}

fn half(at: f64) -> &'static str {
    if at > 0.0 { "+1/2" } else { "-1/2" }
}

fn at_texel(stencil: &Stencil) -> Properties {
    Stencil { at: DoubleDouble::ZERO, ..*stencil }.properties()
}

fn ratio(stencil: &Stencil, wave: f64) -> [f64; 2] {
    let k = 2.0 * PI / wave;
    let ratio = stencil.modified_wavenumber([k, 0.0]) / k;
    // What rounding leaves of nothing.
    [ratio.re, if ratio.im.abs() < 1e-14 { 0.0 } else { ratio.im }]
}

fn across(stencil: &Stencil, wave: f64) -> f64 {
    let k = 2.0 * PI / wave;
    (stencil.modified_wavenumber([k, k]) / stencil.modified_wavenumber([k, 0.0])).re
}

/// `0.9745`, `1.2+0.3i`
fn complex([re, im]: [f64; 2]) -> String {
    if im == 0.0 { format!("{re:.4}") } else { format!("{re:.3}{im:+.3}i") }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let given: Vec<_> = args.stencil.iter().map(|path| Source::file(path)).collect::<Result<_, _>>()?;
    let mut all: Vec<_> = stencils::all().iter().map(|entry| (entry.name, *entry.stencil)).collect();
    for source in &given {
        let stencil = source.stencil().map_err(|error| Failure::Input(source.message(&error)))?;
        all.push((&source.name, stencil));
    }
    let items: Vec<_> = all.iter().map(|(name, stencil)| Item::of(name, stencil)).collect();
    if args.json { print_json(&items) } else { print(&table(&items)) }
}

fn table(items: &[Item]) -> String {
    let width = items.iter().map(|item| item.name.len()).max().unwrap_or(0);
    let mut out = format!("{:94}k'/k for waves of\n", "");
    let _ = writeln!(
        out,
        "{:width$}  order  taps  e_xx      e_yy      noise gain  {:15} {:15} {:15} lives at",
        "name", "16 texels", "8", "4"
    );
    out = out.replacen(&format!("{:94}", ""), &" ".repeat(width + 49), 1);
    for item in items {
        let waves: String = item.wavenumber.map(|k| format!("{:15} ", complex(k))).concat();
        let _ = writeln!(
            out,
            "{:width$}  {:>5}  {:>4}  {:8}  {:8}  {:10.3}  {waves}{}",
            item.name,
            item.order,
            item.taps,
            short(item.e_xx),
            short(item.e_yy),
            item.noise_gain,
            item.lives()
        );
    }
    let _ = writeln!(
        out,
        "\n{} stencils. The error is e_xx h^2 f_xxx + e_yy h^2 f_xyy + ..; the noise gain is the noise of the slope \
         over that of\nthe heights. `kutta show NAME` draws one.",
        items.len()
    );
    out
}

/// A line for each property.
pub fn words(stencil: &Stencil) -> String {
    let (p, item) = (stencil.properties(), Item::of("", stencil));
    let mut out = String::new();
    let mut line = |label: &str, text: String| {
        let _ = writeln!(out, "{label:<16}{text}");
    };
    line("order", p.order.to_string());
    line("lives at", item.lives());
    let taps = if p.compact { "; the slopes of a row follow from a tridiagonal system" } else { "" };
    line("taps", format!("{}{taps}", p.taps));
    line("error", error(&p));
    let isotropic = match p.isotropic {
        n if n > p.order => format!("to h^{}, the leading error with it", n - n % 2),
        _ => "no".to_string(),
    };
    line("isotropic", isotropic);
    line("noise gain", short(p.noise_gain));
    let at = |values: [String; 3]| {
        format!("{}, {}, {} for waves of 16, 8, 4 texels", values[0], values[1], values[2])
    };
    line("k'/k along", at(item.wavenumber.map(complex)));
    line("across", at(item.across.map(|x| format!("{x:.4}"))));
    line("right to 1 %", format!("for waves from {} texels on", short(item.one_percent)));
    let [eight, four] = item.direction_error.map(|x| format!("{x:.2}"));
    line("direction", format!("off by up to {eight} degrees for waves of 8 texels, {four} of 4"));
    line("symmetric", yes(p.symmetric).to_string());
    out
}

/// `h^2 (0.16667 f_xxx + 0.25 f_xyy)`
fn error(p: &Properties) -> String {
    let mut terms = String::new();
    for term in &p.leading {
        let [along, across] = term.derivative;
        let sign = match (terms.is_empty(), term.coefficient < 0.0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        let derivative = format!("f_{}{}", "x".repeat(along), "y".repeat(across));
        let _ = write!(terms, "{sign}{} {derivative}", short(term.coefficient.abs()));
    }
    format!("h^{} ({terms})", p.order)
}

/// `kutta show NAME` of a stencil.
pub fn show(source: &Source, json: bool) -> Result<(), Failure> {
    let stencil = source.stencil().map_err(|error| Failure::Input(source.message(&error)))?;
    if json {
        let rows = |key: &str| {
            entries(&source.text, key).map(|rows| {
                rows.into_iter()
                    .map(|row| json!({ "offset": row[0].parse::<i64>().ok(), "text": row[1], "value": value(row[1]).map(DoubleDouble::hi) }))
                    .collect::<Vec<Value>>()
            })
        };
        let mut shown = json!(Item::of(&source.name, &stencil));
        for (key, value) in [
            ("cite", json!(stencil.cite)),
            ("note", json!(stencil.note)),
            ("digits", json!((stencil.digits > 0).then_some(stencil.digits))),
            ("stencil", json!(rows("stencil"))),
            ("smooth", json!(rows("smooth"))),
            ("left", json!(rows("left"))),
        ] {
            shown[key] = value;
        }
        return print_json(&shown);
    }
    let mut out = format!("{}: {}\n\n{}\n{}", source.name, stencil.title, draw(&stencil), words(&stencil));
    let _ = writeln!(out, "\n{}", stencil.cite);
    if !stencil.note.is_empty() {
        let _ = writeln!(out, "{}", stencil.note);
    }
    print(&out)
}
