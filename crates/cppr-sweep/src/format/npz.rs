//! NPZ: an uncompressed zip of NumPy arrays, written column by column.

use super::Source;
use crate::table::ColumnKind;
use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use std::fs::File;
use std::io::{self, BufWriter};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Bytes beyond which an entry needs the long form of the zip format; headers included.
const LONG: u64 = 1 << 31;

type Zip = ZipWriter<BufWriter<File>>;

pub(super) fn write(source: &mut Source, file: File) -> io::Result<File> {
    let mut zip = ZipWriter::new(BufWriter::new(file));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(source.rows * 8 >= LONG);
    for (index, column) in source.columns.iter().enumerate() {
        zip.start_file(format!("{}.npy", column.name), options)?;
        match column.kind {
            ColumnKind::Number => put(source, &mut zip, index, |v| v)?,
            // Codes and counts are small whole numbers.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            ColumnKind::Status => put(source, &mut zip, index, |v| v as u8)?,
            #[allow(clippy::cast_possible_truncation)]
            ColumnKind::Count => put(source, &mut zip, index, |v| v as i32)?,
        }
    }
    zip.start_file("reasons.npy", options)?;
    let mut length = 0;
    reasons(source, |bytes| {
        length += bytes.len() as u64;
        Ok(())
    })?;
    let mut array = begin::<u8>(&mut zip, length)?;
    reasons(source, |bytes| array.extend(bytes.iter().copied()))?;
    array.finish()?;
    zip.start_file("metadata.npy", options)?;
    let mut array = begin(&mut zip, source.manifest.len() as u64)?;
    array.extend(source.manifest.bytes())?;
    array.finish()?;
    zip.finish()?.into_inner().map_err(io::IntoInnerError::into_error)
}

/// The bytes of a JSON object: row, counted from 0, and its reason. Text has no array of its own that grows with its longest entry only.
fn reasons(source: &mut Source, mut put: impl FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
    put(b"{")?;
    let mut first = true;
    for number in 0..if source.has_reasons { source.chunks } else { 0 } {
        let Some(chunk) = source.journal.read(number)? else { continue };
        for row in 0..chunk.rows {
            if let Some(reason) = source.task.reason(&chunk, row) {
                let comma = if std::mem::take(&mut first) { "" } else { "," };
                let reason = serde_json::Value::String(reason);
                put(format!("{comma}\"{}\":{reason}", chunk.first_row + row as u64).as_bytes())?;
            }
        }
    }
    put(b"}")
}

fn begin<T: AutoSerialize>(zip: &mut Zip, count: u64) -> io::Result<npyz::NpyWriter<T, &mut Zip>> {
    WriteOptions::new().default_dtype().shape(&[count]).writer(zip).begin_nd()
}

fn put<T: AutoSerialize>(
    source: &mut Source,
    zip: &mut Zip,
    column: usize,
    convert: impl Fn(f64) -> T,
) -> io::Result<()> {
    let mut array = begin(zip, source.rows)?;
    for chunk in 0..source.chunks {
        array.extend(source.journal.read_column(chunk, column)?.into_iter().map(&convert))?;
    }
    array.finish()
}
