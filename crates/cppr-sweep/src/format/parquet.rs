//! Parquet: one row group per some ten thousand rows, nulls where there is no number.

use super::Source;
use crate::table::{Chunk, Column, ColumnKind, Verdict};
use crate::task::Task;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::File;
use std::io;
use std::sync::Arc;

/// Rows of a group, at least; held in memory together.
const GROUP: usize = 32_768;

pub(super) fn write(source: &mut Source, file: File) -> io::Result<File> {
    // A dictionary serves the few words of the status; numbers hardly repeat.
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .set_column_dictionary_enabled("status_text".into(), true)
        .set_column_dictionary_enabled("reason".into(), true)
        .set_key_value_metadata(Some(vec![KeyValue::new("cppr".into(), Some(source.manifest.into()))]))
        .set_created_by(format!("cppr {}", env!("CARGO_PKG_VERSION")))
        .build();
    let schema = Arc::new(schema(source.columns).map_err(io::Error::other)?);
    let mut writer =
        SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(io::Error::other)?;
    let mut group: Vec<Chunk> = Vec::new();
    for number in 0..source.chunks {
        group.extend(source.journal.read(number)?);
        if number + 1 == source.chunks || group.iter().map(|chunk| chunk.rows).sum::<usize>() >= GROUP {
            put(&mut writer, source.task, source.columns, &group).map_err(io::Error::other)?;
            group.clear();
        }
    }
    writer.into_inner().map_err(io::Error::other)
}

fn schema(columns: &[Column]) -> Result<Type, ParquetError> {
    let text = |name, repetition| {
        let text = Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
            .with_repetition(repetition)
            .with_logical_type(Some(LogicalType::String));
        text.build().map(Arc::new)
    };
    let mut fields = Vec::new();
    for Column { name, kind } in columns {
        let (physical, repetition) = match kind {
            ColumnKind::Number => (Physical::DOUBLE, Repetition::OPTIONAL),
            ColumnKind::Count => (Physical::INT32, Repetition::OPTIONAL),
            ColumnKind::Status => (Physical::INT32, Repetition::REQUIRED),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        fields.push(Arc::new(field.build()?));
        if *kind == ColumnKind::Status {
            fields.push(text("status_text", Repetition::REQUIRED)?);
        }
    }
    fields.push(text("reason", Repetition::OPTIONAL)?);
    Type::group_type_builder("sweep").with_fields(fields).build()
}

fn put(
    writer: &mut SerializedFileWriter<File>,
    task: &Task,
    columns: &[Column],
    group: &[Chunk],
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General("a column is missing".into());
    let mut rows = writer.next_row_group()?;
    for (index, column) in columns.iter().enumerate() {
        let values = || group.iter().flat_map(|chunk| chunk.column(index)).copied();
        let there = || values().filter(|v| !v.is_nan());
        // 1 where there is a number, 0 for a null; not asked for where a number is required.
        let levels: Vec<i16> = values().map(|v| i16::from(!v.is_nan())).collect();
        let mut out = rows.next_column()?.ok_or_else(missing)?;
        if column.kind == ColumnKind::Number {
            let numbers: Vec<f64> = there().collect();
            out.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None)?;
        } else {
            // Codes and counts are small whole numbers.
            #[allow(clippy::cast_possible_truncation)]
            let whole: Vec<i32> = there().map(|v| v as i32).collect();
            out.typed::<Int32Type>().write_batch(&whole, Some(&levels), None)?;
        }
        out.close()?;
        if column.kind == ColumnKind::Status {
            let words: Vec<ByteArray> =
                values().map(|v| Verdict::from_code(v).map_or("", Verdict::text).into()).collect();
            let mut out = rows.next_column()?.ok_or_else(missing)?;
            out.typed::<ByteArrayType>().write_batch(&words, None, None)?;
            out.close()?;
        }
    }
    let reasons_of =
        |chunk: &Chunk| -> Vec<_> { (0..chunk.rows).map(|row| task.reason(chunk, row)).collect() };
    let reasons: Vec<Option<String>> = group.iter().flat_map(reasons_of).collect();
    let levels: Vec<i16> = reasons.iter().map(|reason| i16::from(reason.is_some())).collect();
    let there: Vec<ByteArray> =
        reasons.into_iter().flatten().map(|reason| reason.into_bytes().into()).collect();
    let mut out = rows.next_column()?.ok_or_else(missing)?;
    out.typed::<ByteArrayType>().write_batch(&there, Some(&levels), None)?;
    out.close()?;
    rows.close()?;
    Ok(())
}
