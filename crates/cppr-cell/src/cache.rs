//! Stiffness of cells that were computed before: in memory, and as small files in the user's cache folder.
//!
//! The folder is `cppr/cells` below the cache folder of the system, or what the environment variable `CPPR_CELL_CACHE` names; `off` there keeps nothing
//! on disk. A file holds the whole description of its cell and is believed only if that is the same; it is written beside its place and
//! then moved there, so that no reader sees half of it. A folder that cannot be read or written costs time, never an answer.

use crate::cell::{Cell, CellError, CellStiffness};
use etcetera::{BaseStrategy, choose_base_strategy};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

/// Goes up whenever the same cell gets other numbers.
const VERSION: u32 = 1;

static MEMORY: LazyLock<Mutex<HashMap<String, CellStiffness>>> = LazyLock::new(Mutex::default);

#[derive(Serialize, Deserialize)]
struct Entry {
    cell: String,
    stiffness: CellStiffness,
}

/// [`Cell::stiffness`], computed once per cell and user.
///
/// # Errors
/// As [`Cell::stiffness`].
pub fn stiffness(cell: &Cell) -> Result<CellStiffness, CellError> {
    let key = format!("{VERSION} {cell:?}");
    let known = MEMORY.lock().unwrap_or_else(PoisonError::into_inner).get(&key).copied();
    if let Some(known) = known {
        return Ok(known);
    }
    let path = folder().map(|folder| folder.join(format!("{:016x}.json", hash(&key))));
    let found = if let Some(stored) = path.as_ref().and_then(|path| load(path, &key)) {
        stored
    } else {
        let computed = cell.stiffness()?;
        if let Some(path) = path {
            // What cannot be kept is computed again next time.
            let _ = store(&path, &Entry { cell: key.clone(), stiffness: computed });
        }
        computed
    };
    MEMORY.lock().unwrap_or_else(PoisonError::into_inner).insert(key, found);
    Ok(found)
}

fn folder() -> Option<PathBuf> {
    match std::env::var_os("CPPR_CELL_CACHE") {
        Some(named) if named == "off" => None,
        Some(named) if !named.is_empty() => Some(named.into()),
        _ => choose_base_strategy().ok().map(|system| system.cache_dir().join("cppr").join("cells")),
    }
}

fn load(path: &Path, key: &str) -> Option<CellStiffness> {
    let entry: Entry = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    (entry.cell == key).then_some(entry.stiffness)
}

fn store(path: &Path, entry: &Entry) -> std::io::Result<()> {
    let folder = path.parent().ok_or(std::io::ErrorKind::InvalidInput)?;
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(&serde_json::to_vec(entry)?)?;
    file.persist(path)?;
    Ok(())
}

/// FNV-1a: names of files only, what they hold is compared.
fn hash(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use cppr::design::PeakStrain;

    #[test]
    fn a_file_is_believed_for_its_own_cell_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new").join("cell.json");
        let peak = PeakStrain { bending_z: [1.25, -0.1], stretch: [2.0, -0.3], bending_y: 0.7, twist: 0.3 };
        let stiffness = CellStiffness {
            axial: 0.1,
            centroid_offset: 1.0 / 3.0,
            bending_y: 1e-13,
            bending_z: 3.2e-13,
            torsion: 5e-324,
            mean_area: 2.0,
            peak: Some(peak),
            change: 0.004,
            peak_change: 0.02,
            unknowns: 17,
        };
        store(&path, &Entry { cell: "this".into(), stiffness }).unwrap();
        assert_eq!(load(&path, "this"), Some(stiffness));
        assert_eq!(load(&path, "another"), None);
        std::fs::write(&path, b"{\"cell\": \"this\", \"stiff").unwrap();
        assert_eq!(load(&path, "this"), None);
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1,
            "a half-written file is left"
        );
    }
}
