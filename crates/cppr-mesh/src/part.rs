//! What goes into a file: named, coloured meshes.

use crate::mesh::Mesh;

/// One body of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name, for instance "R1, tube 1".
    pub name: String,
    /// Surface (m).
    pub mesh: Mesh,
    /// Colour, sRGB.
    pub colour: [u8; 3],
}

/// Why a file could not be made.
#[derive(Debug)]
pub struct FileError {
    /// The format.
    pub format: &'static str,
    /// What the library that writes it says.
    pub source: Box<dyn std::error::Error + Send + Sync>,
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} cannot be written: {}", self.format, self.source)
    }
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(self.source.as_ref())
    }
}

/// Millimetres, as workshop files have them.
#[cfg(feature = "files")]
pub(crate) fn millimetres(position: [f64; 3]) -> [f64; 3] {
    position.map(|v| v * 1e3)
}

/// Rounded to what the file holds.
#[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose; sizes are checked beforehand")]
pub(crate) fn single(position: [f64; 3]) -> [f32; 3] {
    position.map(|v| v as f32)
}
