//! `kutta stability NAME`: the stability region as a picture, with its limits.

mod outline;
mod region;
mod swing;

use super::compare::files::Folder;
use super::pen::Picture;
use super::words::words;
use super::{Failure, Source, print};
use region::Region;
use std::path::PathBuf;
use swing::Swing;

/// Draw the stability region of a method, with its limits
///
/// Shaded is where y' = lambda y does not grow, over h lambda; for a method for y'' = -omega^2 y, where a swing
/// does not grow, over h omega. Along the border of an explicit pair the colour tells whether the default
/// controller settles there or makes the steps swing.
#[derive(clap::Args)]
pub struct Args {
    /// A method's name, or the path of a .toml file
    name: String,
    /// Folder for NAME-stability.svg and NAME-stability.png
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let source = Source::find(&args.name)?;
    let tableau = source.tableau().map_err(|error| Failure::Input(source.message(&error)))?;
    let folder = Folder::open(&args.out).map_err(Failure::Input)?;
    let (stability, properties) = (tableau.stability(), tableau.properties());
    let stated = words(&properties);
    let lines = stated.lines().filter(|line| line.starts_with("stable for") || line.starts_with("stability"));
    let mut out: String = lines.map(|line| format!("{line}\n")).collect();
    let name = format!("{}-stability", source.name);
    match stability.second_order() {
        true => draw(&folder, &name, &Swing::of(&source.name, &stability))?,
        false => {
            let region = Region::of(&source.name, &stability, &properties);
            draw(&folder, &name, &region)?;
            out += &region.control();
        }
    }
    print(&format!("{out}{0}.svg and {0}.png are in {1}\n", name, args.out.display()))
}

fn draw(folder: &Folder, name: &str, picture: &impl Picture) -> Result<(), Failure> {
    folder.write(&format!("{name}.svg"), |path| picture.svg(path)).map_err(Failure::Outcome)?;
    folder.write(&format!("{name}.png"), |path| picture.png(path)).map_err(Failure::Outcome)
}
