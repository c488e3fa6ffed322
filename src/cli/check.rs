//! `kutta check FILE`: the proof that the compiler makes, of a file outside.

use super::words::words;
use super::{Failure, Source, print, stencils};

#[derive(clap::Args)]
pub struct Args {
    /// A method or stencil file
    file: String,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let source = Source::file(&args.file)?;
    let wrong = |error| Failure::Outcome(source.message(&error));
    if source.is_stencil() {
        let stencil = source.stencil().map_err(wrong)?;
        return print(&format!(
            "{} is right: {}\n\n{}",
            source.path,
            stencil.title,
            stencils::words(&stencil)
        ));
    }
    let tableau = source.tableau().map_err(wrong)?;
    print(&format!("{} is right: {}\n\n{}", source.path, tableau.title, words(&tableau.properties())))
}
