//! A file that is there when it is complete, or not at all.

use std::fmt::Arguments;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use rusty_contract::Replacement;

use super::error::ExportError;

/// Lines on their way into a file. Dropped before [`finish`](Self::finish),
/// nothing is left.
pub struct Sheet {
    path: PathBuf,
    out: BufWriter<Replacement>,
    /// Number of lines, without the heads.
    pub lines: u64,
    force: bool,
}

impl Sheet {
    /// A file to be at `path`; with `force` also over one that is there.
    pub fn create(path: &Path, force: bool) -> Result<Self, ExportError> {
        if !force && path.is_file() {
            return Err(ExportError::InTheWay(path.display().to_string()));
        }
        let file = Replacement::of(path).map_err(ExportError::io(path))?;
        let out = BufWriter::with_capacity(1 << 16, file);
        Ok(Self { path: path.to_owned(), out, lines: 0, force })
    }

    /// Adds a line that is not counted.
    pub fn head(&mut self, text: Arguments<'_>) -> Result<(), ExportError> {
        let written = self.out.write_fmt(text).and_then(|()| self.out.write_all(b"\n"));
        written.map_err(ExportError::io(&self.path))
    }

    /// Adds a line.
    pub fn line(&mut self, text: Arguments<'_>) -> Result<(), ExportError> {
        self.lines += 1;
        self.head(text)
    }

    /// Where the bytes of a file that has no lines go.
    pub fn out(&mut self) -> &mut BufWriter<Replacement> {
        &mut self.out
    }

    /// Leaves no file, and none that was there before if it may be replaced.
    pub fn discard(self) -> Result<(), ExportError> {
        if !self.force || !self.path.is_file() {
            return Ok(());
        }
        std::fs::remove_file(&self.path).map_err(ExportError::io(&self.path))
    }

    /// Puts the file in its place; says where that is.
    pub fn finish(self) -> Result<String, ExportError> {
        let Self { path, out, force, .. } = self;
        let shown = path.display().to_string();
        let file = out.into_inner().map_err(|e| ExportError::io(&path)(e.into_error()))?;
        let put = if force { file.commit(&path) } else { file.commit_new(&path) };
        match put {
            Ok(()) => Ok(shown),
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
                Err(ExportError::InTheWay(shown))
            }
            Err(e) => Err(ExportError::io(&path)(e)),
        }
    }
}
