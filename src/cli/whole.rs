//! Files written whole or not at all: under a name of their own beside the target, renamed when complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file on its way. Dropped before [`finish`](Whole::finish), it leaves nothing.
pub struct Whole {
    file: Option<BufWriter<File>>,
    part: PathBuf,
    path: PathBuf,
}

impl Whole {
    pub fn create(path: &Path) -> io::Result<Self> {
        if path.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
        }
        let name = path.file_name().ok_or_else(|| io::Error::other("it is no file name"))?;
        let part = path.with_file_name(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
        let file = OpenOptions::new().write(true).create_new(true).open(&part)?;
        Ok(Self { file: Some(BufWriter::with_capacity(1 << 18, file)), part, path: path.to_path_buf() })
    }

    /// Everything is written: takes the name of the target, in place of what was there.
    pub fn finish(mut self) -> io::Result<()> {
        if let Some(file) = self.file.take() {
            file.into_inner()?;
        }
        fs::rename(&self.part, &self.path)
    }
}

impl Write for Whole {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), |file| file.flush())
    }
}

impl Drop for Whole {
    fn drop(&mut self) {
        drop(self.file.take());
        // Gone already where it was renamed.
        let _ = fs::remove_file(&self.part);
    }
}
