//! CSV: shortest numbers that read back to the same bits, NaN where there is none.

use super::Source;
use crate::table::{Chunk, Column, ColumnKind, Verdict};
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Chunks that are formatted side by side.
const BATCH: u64 = 32;

pub(super) fn write(source: &mut Source, file: File) -> io::Result<File> {
    let mut out = BufWriter::new(file);
    writeln!(out, "# {}", source.manifest)?;
    head(&mut out, source.columns)?;
    let mut next = 0;
    while next < source.chunks {
        let batch = next..source.chunks.min(next + BATCH);
        next = batch.end;
        let chunks: Vec<Chunk> =
            batch.filter_map(|c| source.journal.read(c).transpose()).collect::<io::Result<_>>()?;
        let (task, columns) = (source.task, source.columns);
        let texts: Vec<Vec<u8>> =
            chunks.par_iter().map(|chunk| lines(chunk, columns, |row| task.reason(chunk, row))).collect();
        for text in texts {
            out.write_all(&text)?;
        }
    }
    out.into_inner().map_err(io::IntoInnerError::into_error)
}

/// The line of names.
pub(crate) fn head(out: &mut impl Write, columns: &[Column]) -> io::Result<()> {
    let names: Vec<&str> = columns
        .iter()
        .flat_map(|column| {
            let text = (column.kind == ColumnKind::Status).then_some("status_text");
            std::iter::once(column.name.as_str()).chain(text)
        })
        .chain(["reason"])
        .collect();
    writeln!(out, "{}", names.join(","))
}

/// The rows of a chunk; `reason` says why one was refused.
pub(crate) fn lines(chunk: &Chunk, columns: &[Column], reason: impl Fn(usize) -> Option<String>) -> Vec<u8> {
    let mut text = Vec::with_capacity(chunk.rows * columns.len() * 20);
    let mut number = zmij::Buffer::new();
    for row in 0..chunk.rows {
        for (c, column) in columns.iter().enumerate() {
            if c > 0 {
                text.push(b',');
            }
            let value = chunk.column(c)[row];
            let written = number.format(value);
            match column.kind {
                ColumnKind::Number => text.extend_from_slice(written.as_bytes()),
                ColumnKind::Count => text.extend_from_slice(written.trim_end_matches(".0").as_bytes()),
                ColumnKind::Status => {
                    text.extend_from_slice(written.trim_end_matches(".0").as_bytes());
                    text.push(b',');
                    let word = Verdict::from_code(value).map_or("", Verdict::text);
                    text.extend_from_slice(word.as_bytes());
                }
            }
        }
        text.push(b',');
        if let Some(reason) = reason(row) {
            text.extend_from_slice(format!("\"{}\"", reason.replace('"', "\"\"")).as_bytes());
        }
        text.push(b'\n');
    }
    text
}
