//! Files that appear whole or not at all.

use std::path::{Path, PathBuf};
use std::{fs, process};

/// The folder that results go to.
pub struct Folder(PathBuf);

impl Folder {
    /// Makes the folder if it is not there, and makes sure that a file can be written to it.
    pub fn open(path: &Path) -> Result<Self, String> {
        let shown = path.display();
        let unfit = |error| format!("{shown} cannot be written to ({error}): choose a folder with --out");
        fs::create_dir_all(path).map_err(unfit)?;
        let folder = Self(path.to_path_buf());
        let probe = folder.unfinished("probe");
        fs::write(&probe, []).and_then(|()| fs::remove_file(&probe)).map_err(unfit)?;
        Ok(folder)
    }

    /// The ending stays: it decides the format of a picture.
    fn unfinished(&self, name: &str) -> PathBuf {
        self.0.join(format!(".{}-{name}", process::id()))
    }

    /// Lets `fill` write a file beside its place, and moves it there.
    pub fn write(&self, name: &str, fill: impl FnOnce(&Path) -> Result<(), String>) -> Result<(), String> {
        let unfinished = self.unfinished(name);
        let moved = |()| fs::rename(&unfinished, self.0.join(name)).map_err(|error| error.to_string());
        fill(&unfinished).and_then(moved).map_err(|error| {
            // What is left of it is of no use; that it cannot be removed either adds nothing to the message.
            let _ = fs::remove_file(&unfinished);
            format!("{}: {error}", self.0.join(name).display())
        })
    }
}
