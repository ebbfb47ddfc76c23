//! Where results go: standard output, or files that are written whole or not at all.

use crate::Failure;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Writes to standard output; a reader that has gone away (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a file under another name first, so that a crash leaves the old one.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let failed = |what: &str, error: &dyn std::fmt::Display| {
        Failure::Input(format!("{}: cannot {what}: {error}", path.display()))
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut file = tempfile::Builder::new()
        .prefix(".cppr-")
        .tempfile_in(folder)
        .map_err(|e| failed("write into its folder", &e))?;
    file.write_all(bytes).map_err(|e| failed("be written", &e))?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let readable = std::fs::Permissions::from_mode(0o644);
        file.as_file().set_permissions(readable).map_err(|e| failed("be made readable", &e))?;
    }
    file.persist(path).map_err(|e| failed("be put in place", &e.error))?;
    Ok(())
}

/// To a file, or to standard output for `-`.
pub fn write_or_print(path: &Path, text: &str) -> Result<(), Failure> {
    if is_stdout(path) { print(text) } else { write(path, text.as_bytes()) }
}

/// Is this the sign for standard output?
pub fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}
