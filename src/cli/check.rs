//! `kutta check FILE`: the proof that the compiler makes, of a file outside.

use super::words::words;
use super::{Failure, Source, print};

#[derive(clap::Args)]
pub struct Args {
    /// A method file
    file: String,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let source = Source::file(&args.file)?;
    let tableau = source.tableau().map_err(|error| Failure::Outcome(source.message(&error)))?;
    print(&format!("{} is right: {}\n\n{}", source.path, tableau.title, words(&tableau.properties())))
}
