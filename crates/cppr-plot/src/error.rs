//! What a figure can be refused for.

use std::fmt;

/// Why a figure was not drawn. `what` names the offending series, line or axis.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PlotError {
    /// Nothing to draw.
    Empty {
        /// The list that is empty.
        what: String,
    },
    /// A line of one point cannot be seen.
    SinglePoint {
        /// The line.
        what: String,
    },
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// The list holding the value.
        what: String,
        /// Position in that list, from 0.
        index: usize,
    },
    /// A coordinate is so large that differences of coordinates may overflow.
    TooLarge {
        /// The list holding the value.
        what: String,
        /// Position in that list, from 0.
        index: usize,
    },
    /// The ends of a prescribed axis range are equal or in the wrong order.
    BadRange {
        /// Label of the axis.
        what: String,
        /// Lower end as given.
        low: f64,
        /// Upper end as given.
        high: f64,
    },
    /// Two lists that go together differ in length.
    LengthMismatch {
        /// The second list.
        what: String,
        /// Length of the first list.
        expected: usize,
        /// Length of the second list.
        found: usize,
    },
    /// Tubes are numbered from 1.
    TubeZero {
        /// The pose or panel that names tube 0.
        what: String,
    },
    /// The picture would have no pixels, or more than 16384 along a side.
    ImageSize {
        /// Width asked for, in pixels.
        width: f64,
        /// Height asked for, in pixels.
        height: f64,
    },
    /// The embedded font could not be read.
    Font,
    /// The PNG encoder failed.
    Encode,
}

impl fmt::Display for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty { what } => write!(f, "nothing to draw: {what} is empty"),
            Self::SinglePoint { what } => {
                write!(f, "{what} has one point only, a line needs two")
            }
            Self::NotFinite { what, index } => {
                write!(f, "{what}: value {index} (counted from 0) is not a finite number")
            }
            Self::TooLarge { what, index } => {
                write!(f, "{what}: value {index} (counted from 0) is beyond ±1e100")
            }
            Self::BadRange { what, low, high } => {
                write!(f, "axis {what}: the range {low} to {high} has no extent")
            }
            Self::LengthMismatch { what, expected, found } => {
                write!(f, "{what}: {found} values where {expected} are needed")
            }
            Self::TubeZero { what } => write!(f, "{what}: tubes are numbered from 1"),
            Self::ImageSize { width, height } => {
                write!(f, "a picture of {width} × {height} pixels cannot be made (1 to 16384)")
            }
            Self::Font => write!(f, "the embedded font could not be read"),
            Self::Encode => write!(f, "the PNG encoder failed"),
        }
    }
}

impl std::error::Error for PlotError {}

/// Beyond this a difference or a square of coordinates may overflow on the way to pixels.
const LARGEST: f64 = 1e100;

/// Refuses the first value that is not finite or too large to be drawn.
pub(crate) fn check_values<'a>(
    what: &str,
    values: impl IntoIterator<Item = &'a [f64]>,
) -> Result<(), PlotError> {
    for (index, row) in values.into_iter().enumerate() {
        if row.iter().any(|v| !v.is_finite()) {
            return Err(PlotError::NotFinite { what: what.to_owned(), index });
        }
        if row.iter().any(|v| v.abs() > LARGEST) {
            return Err(PlotError::TooLarge { what: what.to_owned(), index });
        }
    }
    Ok(())
}
