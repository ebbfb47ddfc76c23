//! The rows of an unfinished sweep: a folder beside the result with the task and the chunks solved so far.
//!
//! `task.json` is the manifest. `rows.bin` holds one record per chunk, in order: CRC-32 of the values, then the values as
//! little-endian f64, column after column. Where each record begins follows from the task. A record cut short by
//! a crash is found by its length or its sum, and solved again.

use crate::chunking::Chunking;
use crate::file::FileProblem;
use crate::manifest::differences;
use crate::table::Chunk;
use serde_json::Value;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes of a sum.
const CRC: usize = 4;

pub(crate) struct Journal<'a> {
    pub folder: PathBuf,
    file: File,
    chunking: &'a Chunking,
    /// Numbers per row.
    width: u64,
    /// Whole chunks in the file.
    pub done: u64,
    bytes: Vec<u8>,
}

impl<'a> Journal<'a> {
    /// Begins the journal of a task, or goes on with it where `resume` is set.
    pub fn open(
        folder: PathBuf,
        manifest: &Value,
        chunking: &'a Chunking,
        width: usize,
        resume: bool,
    ) -> Result<Self, FileProblem> {
        let task = folder.join("task.json");
        match fs::read(&task) {
            Ok(_) if !resume => return Err(FileProblem::Unfinished(folder)),
            Ok(bytes) => {
                let old: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                // As it reads back itself: a number may come out in its last bit otherwise.
                let own: Value = serde_json::from_str(&manifest.to_string()).unwrap_or_default();
                let differ = differences(&own, &old);
                if !differ.is_empty() {
                    return Err(FileProblem::OtherTask(folder, differ));
                }
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                fs::create_dir_all(&folder).map_err(FileProblem::at(&folder))?;
                // Whole or not at all: it says that the folder is a journal.
                let draft = folder.join("task.draft");
                let text = format!("{manifest:#}\n");
                fs::write(&draft, text)
                    .and_then(|()| fs::rename(&draft, &task))
                    .map_err(FileProblem::at(&task))?;
            }
            Err(error) => return Err(FileProblem::at(&task)(error)),
        }
        let rows = folder.join("rows.bin");
        let file = File::options().read(true).write(true).create(true).truncate(false).open(&rows);
        let file = file.map_err(FileProblem::at(&rows))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FileProblem::InUse(folder)),
            Err(TryLockError::Error(error)) => return Err(FileProblem::at(&rows)(error)),
        }
        let mut journal = Self { folder, file, chunking, width: width as u64, done: 0, bytes: Vec::new() };
        journal.recover().map_err(FileProblem::at(&rows))?;
        Ok(journal)
    }

    /// Counts the whole records and cuts off what is behind them.
    fn recover(&mut self) -> std::io::Result<()> {
        let length = self.file.metadata()?.len();
        while self.done < self.chunking.chunks && self.start(self.done + 1) <= length {
            if self.read(self.done)?.is_none() {
                break;
            }
            self.done += 1;
        }
        self.file.set_len(self.start(self.done))
    }

    /// First byte of a chunk's record.
    fn start(&self, chunk: u64) -> u64 {
        let rows = if chunk < self.chunking.chunks {
            self.chunking.rows_of(chunk).start
        } else {
            self.chunking.rows
        };
        rows * self.width * 8 + chunk * CRC as u64
    }

    /// Appends the next chunk.
    pub fn append(&mut self, chunk: &Chunk) -> Result<(), FileProblem> {
        self.bytes.clear();
        self.bytes.extend([0; CRC]);
        self.bytes.extend(chunk.values.iter().flat_map(|v| v.to_le_bytes()));
        let sum = crc32fast::hash(&self.bytes[CRC..]);
        self.bytes[..CRC].copy_from_slice(&sum.to_le_bytes());
        let start = self.start(self.done);
        let written = self.file.seek(SeekFrom::Start(start)).and_then(|_| self.file.write_all(&self.bytes));
        written.map_err(FileProblem::at(&self.folder))?;
        self.done += 1;
        Ok(())
    }

    /// A chunk; none where its sum is wrong.
    pub fn read(&mut self, number: u64) -> std::io::Result<Option<Chunk>> {
        let rows = self.chunking.rows_of(number);
        let start = self.start(number);
        // A chunk is some hundred kilobytes.
        #[allow(clippy::cast_possible_truncation)]
        self.bytes.resize((self.start(number + 1) - start) as usize, 0);
        self.file.seek(SeekFrom::Start(start))?;
        self.file.read_exact(&mut self.bytes)?;
        let (sum, values) = self.bytes.split_at(CRC);
        if sum != crc32fast::hash(values).to_le_bytes() {
            return Ok(None);
        }
        #[allow(clippy::cast_possible_truncation)]
        let count = (rows.end - rows.start) as usize;
        Ok(Some(Chunk { number, first_row: rows.start, rows: count, values: numbers(values).collect() }))
    }

    /// One column of a chunk.
    pub fn read_column(&mut self, number: u64, column: usize) -> std::io::Result<Vec<f64>> {
        let rows = self.chunking.rows_of(number);
        let bytes = (rows.end - rows.start) * 8;
        self.file.seek(SeekFrom::Start(self.start(number) + CRC as u64 + column as u64 * bytes))?;
        #[allow(clippy::cast_possible_truncation)]
        self.bytes.resize(bytes as usize, 0);
        self.file.read_exact(&mut self.bytes)?;
        Ok(numbers(&self.bytes).collect())
    }

    /// Removes the folder.
    pub fn remove(self) -> Result<(), FileProblem> {
        let Self { folder, file, .. } = self;
        drop(file);
        fs::remove_dir_all(&folder).map_err(FileProblem::at(&folder))
    }
}

fn numbers(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b))
}

/// The folder of an unfinished result.
#[must_use]
pub fn parts_of(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".parts");
    name.into()
}
