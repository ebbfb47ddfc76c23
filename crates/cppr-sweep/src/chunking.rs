//! How the rows of a task are cut into chunks, and in which order the rows of a chunk are solved.
//!
//! A chunk is a block of the grid: the leading axes stand still, one axis runs over a piece of its values, all
//! axes behind it run over theirs. Its rows are contiguous. They are solved along a reflected path (each axis turns
//! back where it has arrived), so that from one pose to the next a single input makes a single step.

use std::ops::Range;

/// Most rows of a chunk. Between the costs of a cold start per chunk and of what an interruption loses.
const MOST: u64 = 1024;
/// Chunks that a task is cut into at least, so that the threads share small ones.
const LEAST_CHUNKS: u64 = 32;
/// Fewer rows than this are not worth a chunk.
const LEAST: u64 = 64;

/// The cut of one task.
#[derive(Clone, Debug)]
pub(crate) struct Chunking {
    /// Values per axis, slowest first.
    counts: Vec<u64>,
    /// The axis that is cut.
    axis: usize,
    /// Pieces of that axis.
    pieces: u64,
    /// Rows of all axes behind it.
    inner: u64,
    /// Chunks in all.
    pub chunks: u64,
    /// Rows in all.
    pub rows: u64,
}

impl Chunking {
    /// Axes with the given counts, slowest first; their product has been checked.
    pub fn new(counts: &[u64]) -> Self {
        let rows: u64 = counts.iter().product();
        let most = (rows / LEAST_CHUNKS).clamp(LEAST, MOST);
        let (mut axis, mut inner) = (counts.len() - 1, 1);
        while axis > 0 && inner * counts[axis] <= most {
            inner *= counts[axis];
            axis -= 1;
        }
        let run = (most / inner).max(1);
        let pieces = counts[axis].div_ceil(run);
        let outer: u64 = counts[..axis].iter().product();
        Self { counts: counts.to_vec(), axis, pieces, inner, chunks: outer * pieces, rows }
    }

    /// Values of the cut axis in a chunk, and the number of its block of leading axes.
    fn piece(&self, chunk: u64) -> (u64, Range<u64>) {
        let (block, piece) = (chunk / self.pieces, chunk % self.pieces);
        let count = self.counts[self.axis];
        (block, piece * count / self.pieces..(piece + 1) * count / self.pieces)
    }

    /// Rows of a chunk.
    pub fn rows_of(&self, chunk: u64) -> Range<u64> {
        let (block, run) = self.piece(chunk);
        let start = block * self.counts[self.axis];
        (start + run.start) * self.inner..(start + run.end) * self.inner
    }

    /// Row of the chunk that is solved at turn `turn`, counted from the chunk's first row.
    pub fn turn(&self, chunk: u64, turn: u64) -> u64 {
        let (_, run) = self.piece(chunk);
        let (mut rest, mut size) = (turn, (run.end - run.start) * self.inner);
        let (mut row, mut odd) = (0, false);
        for axis in self.axis..self.counts.len() {
            let count = if axis == self.axis { run.end - run.start } else { self.counts[axis] };
            size /= count;
            let digit = rest / size;
            rest %= size;
            // An axis runs backwards where the digits before it make an odd number.
            let digit_reflected = if odd { count - 1 - digit } else { digit };
            row = row * count + digit_reflected;
            odd = (odd && count % 2 == 1) != (digit % 2 == 1);
        }
        row
    }

    /// Which value of each axis a row has.
    pub fn digits(&self, row: u64, digits: &mut [u64]) {
        let mut rest = row;
        for (digit, count) in digits.iter_mut().zip(&self.counts).rev() {
            *digit = rest % count;
            rest /= count;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Chunking;

    const SHAPES: [&[u64]; 8] =
        [&[1], &[7], &[5000], &[141, 361], &[3, 5, 4], &[2, 2, 100_000], &[60, 7, 9, 11], &[1, 1, 3000, 1]];

    #[test]
    fn chunks_cover_all_rows_in_order() {
        for counts in SHAPES {
            let cut = Chunking::new(counts);
            let mut next = 0;
            for chunk in 0..cut.chunks {
                let rows = cut.rows_of(chunk);
                assert_eq!(rows.start, next, "{counts:?}");
                assert!(rows.end > rows.start && rows.end - rows.start <= 1024, "{counts:?}: {rows:?}");
                next = rows.end;
            }
            assert_eq!(next, cut.rows);
            assert_eq!(next, counts.iter().product::<u64>());
        }
    }

    #[test]
    fn turns_visit_every_row_once_by_single_steps() {
        for counts in SHAPES {
            let cut = Chunking::new(counts);
            let (mut digits, mut before) = (vec![0; counts.len()], vec![0; counts.len()]);
            for chunk in [0, cut.chunks / 2, cut.chunks - 1] {
                let rows = cut.rows_of(chunk);
                let size = rows.end - rows.start;
                let mut seen: Vec<u64> = (0..size).map(|turn| cut.turn(chunk, turn)).collect();
                for (turn, row) in seen.iter().enumerate() {
                    cut.digits(rows.start + row, &mut digits);
                    let moved: u64 = digits.iter().zip(&before).map(|(a, b)| a.abs_diff(*b)).sum();
                    assert!(turn == 0 || moved == 1, "{counts:?}, turn {turn}: {before:?} to {digits:?}");
                    before.copy_from_slice(&digits);
                }
                seen.sort_unstable();
                assert!(seen.iter().enumerate().all(|(i, row)| i as u64 == *row), "{counts:?}");
            }
        }
    }
}
