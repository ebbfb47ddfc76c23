//! Where results go: standard output, or files that are written whole or not at all.

use crate::Failure;
use std::fs::{File, Metadata, canonicalize, metadata};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Writes to standard output; a reader that has gone away (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes to standard error. Where that is closed, nobody reads it.
pub fn note(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Refuses, before anything is solved, what could not or should not be written: files in folders that are
/// not there, two results in one place, a result in place of the robot.
pub fn check(robot: &Path, outputs: &[(&str, Option<&Path>)]) -> Result<(), Failure> {
    let fail = |message: String| Err(Failure::Input(message));
    let given: Vec<(&str, &Path)> = outputs.iter().filter_map(|&(name, path)| Some((name, path?))).collect();
    for (i, &(name, path)) in given.iter().enumerate() {
        if let Some((other, _)) = given[..i].iter().find(|(_, p)| *p == path) {
            let place = if is_stdout(path) { "standard output".into() } else { path.display().to_string() };
            return fail(format!("{other} and {name} cannot both go to {place}"));
        }
        if is_stdout(path) {
            continue;
        }
        let shown = path.display();
        if metadata(path).is_ok_and(|m| m.is_dir()) {
            return fail(format!("{name} {shown}: this is a folder; add the name of a file"));
        }
        let folder = folder(path);
        if !metadata(&folder).is_ok_and(|m| m.is_dir()) {
            let folder = folder.display();
            return fail(format!("{name} {shown}: there is no folder {folder}; make it first"));
        }
        if let (Ok(one), Ok(other)) = (canonicalize(path), canonicalize(robot))
            && one == other
        {
            return fail(format!("{name} {shown}: this would overwrite the robot; choose another name"));
        }
    }
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => ".".into(),
    }
}

/// Writes a file under another name first, so that a crash leaves the old one. Through a link, the file it
/// points to is replaced; a device or a pipe is written into.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let target = canonicalize(path).unwrap_or_else(|_| path.into());
    let old = metadata(&target).ok();
    let done = match &old {
        Some(old) if !old.is_file() => {
            File::options().write(true).open(&target).and_then(|mut file| file.write_all(bytes))
        }
        _ => replace(&target, old.as_ref(), bytes),
    };
    done.map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", path.display())))
}

fn replace(target: &Path, old: Option<&Metadata>, bytes: &[u8]) -> std::io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".cppr-");
    // As any new file: what the user's mask leaves of it.
    #[cfg(unix)]
    let open = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(open);
    let mut file = builder.tempfile_in(folder(target))?;
    file.write_all(bytes)?;
    if let Some(old) = old {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.persist(target).map_err(|e| e.error)?;
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
