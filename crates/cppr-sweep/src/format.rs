//! The formats of results: CSV, NPZ, Parquet.

pub(crate) mod csv;
mod npz;
mod parquet;

use crate::journal::Journal;
use crate::table::Column;
use crate::task::Task;
use std::fs::File;
use std::io;
use std::path::Path;

/// Format of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text; the description of the sweep is its first line, behind `#`.
    Csv,
    /// One NumPy array per column, and the description as bytes in `metadata`.
    Npz,
    /// Columns with nulls for missing numbers, the description in the file's key `cppr`.
    Parquet,
}

impl Format {
    /// By the ending of a file.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "csv" => Some(Self::Csv),
            "npz" => Some(Self::Npz),
            "parquet" => Some(Self::Parquet),
            _ => None,
        }
    }
}

/// What a writer needs.
pub(crate) struct Source<'s, 'j> {
    pub journal: &'s mut Journal<'j>,
    pub columns: &'s [Column],
    pub task: &'s Task,
    /// Is there a row with a reason?
    pub has_reasons: bool,
    pub manifest: &'s str,
    pub rows: u64,
    pub chunks: u64,
}

pub(crate) fn write(format: Format, source: &mut Source, file: File) -> io::Result<File> {
    match format {
        Format::Csv => csv::write(source, file),
        Format::Npz => npz::write(source, file),
        Format::Parquet => parquet::write(source, file),
    }
}
