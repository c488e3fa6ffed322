//! Why limit the offset of parallax mapping? Measures both shifts against ray marching over the angle of view
//! and draws `docs/parallax.svg`.
//!
//! `cargo run --release --features cli --example parallax`

mod measure;

use measure::{Measured, SHIFTS, measure};
use plotters::prelude::*;
use plotters::style::register_font;

const COLOURS: [RGBColor; 4] = [
    RGBColor(0x88, 0x88, 0x88),
    RGBColor(0xd6, 0x27, 0x28),
    RGBColor(0x1f, 0x77, 0xb4),
    RGBColor(0x2c, 0x8f, 0x2c),
];

/// A chart: its title, what it shows of a measurement, the top of its axis, and the ways it shows.
type Chart = (&'static str, fn(&Measured) -> f64, f64, &'static [usize]);

const CHARTS: [Chart; 3] = [
    ("RMS error, in heights of the relief", |m| m.error, 6.5, &[0, 1, 2]),
    ("RMS way of a texel per degree, in heights", |m| m.swim, 0.5, &[1, 2, 3]),
    ("surface shown backwards, in %", |m| 100.0 * m.folded, 26.0, &[1, 2, 3]),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let elevations: Vec<f64> =
        (5..90).step_by(1).map(f64::from).filter(|e| *e < 30.0 || e % 5.0 == 0.0).collect();
    let runs = SHIFTS.map(|(_, shift)| elevations.iter().map(|e| measure(shift, *e)).collect::<Vec<_>>());
    println!("elevation  way             error   swim     folded");
    for (i, elevation) in
        elevations.iter().enumerate().filter(|(_, e)| [5.0, 10.0, 20.0, 45.0, 75.0].contains(*e))
    {
        for ((name, _), run) in SHIFTS.iter().zip(&runs) {
            let Measured { error, swim, folded, .. } = run[i];
            println!("{elevation:9}  {name:15} {error:6.3} {swim:7.4} {:8.1} %", 100.0 * folded);
        }
    }
    register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "no font")?;
    let path = "docs/parallax.svg";
    let area = SVGBackend::new(path, (960, 300)).into_drawing_area();
    area.fill(&WHITE)?;
    for ((title, value, top, shown), panel) in CHARTS.iter().zip(area.split_evenly((1, 3))) {
        let mut chart = ChartBuilder::on(&panel)
            .caption(title, ("sans-serif", 14))
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(40)
            .build_cartesian_2d(0.0..90.0, 0.0..*top)?;
        chart
            .configure_mesh()
            .x_desc("elevation of the eye, degrees")
            .x_labels(7)
            .y_labels(6)
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(0xdd, 0xdd, 0xdd))
            .label_style(("sans-serif", 12))
            .draw()?;
        for &way in *shown {
            let points = runs[way].iter().map(|m| (m.elevation, value(m))).filter(|(_, y)| y <= top);
            let style = COLOURS[way].stroke_width(2);
            chart
                .draw_series(LineSeries::new(points, style))?
                .label(SHIFTS[way].0)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        chart.configure_series_labels().label_font(("sans-serif", 12)).border_style(TRANSPARENT).draw()?;
    }
    area.present()?;
    println!("{path}");
    Ok(())
}
