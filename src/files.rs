//! Output files, whole or not at all.
//!
//! ```text
//! fine.obj.tmp… ─ written, closed ─► renamed to fine.obj      (in the same folder, so the rename is one step)
//!        └─ anything fails: removed, and an older fine.obj stays as it was
//! ```

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a file whole or not at all.
///
/// # Errors
/// [`crate::Kind::Input`], with the path.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> Result<()> {
    write_whole_with(path, |file| file.write_all(bytes.as_ref()))
}

/// The same for content that comes piece by piece. When `fill` fails, nothing is left behind.
///
/// A link is followed; a device or pipe (`/dev/stdout`) is written to as it is, since it cannot be replaced.
/// The content is not forced to the disk: whole means whole after a crash of the program, not of the machine.
pub fn write_whole_with(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let failed = |error: io::Error| {
        Error::input(format!("cannot write the file: {error}"))
            .at(path.display())
            .help("check that its folder exists, can be written to and has room")
    };
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match fs::metadata(&target) {
        Ok(found) if found.is_dir() => {
            return Err(Error::input("this is a folder, not a file")
                .at(path.display())
                .help("name a file in it"));
        }
        Ok(found) if !found.is_file() => {
            let mut device = BufWriter::new(File::options().write(true).open(&target).map_err(failed)?);
            return fill(&mut device).and_then(|()| device.flush()).map_err(failed);
        }
        _ => {}
    }
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    let mut prefix = target.file_name().unwrap_or_default().to_owned();
    prefix.push(".tmp");
    builder.prefix(&prefix);
    readable_by_all(&mut builder);
    let mut file = BufWriter::new(builder.tempfile_in(folder).map_err(failed)?);
    fill(&mut file).map_err(failed)?;
    let file = file.into_inner().map_err(|error| failed(error.into_error()))?;
    file.persist(&target).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Temporary files are private by default; an output has the usual rights, cut by the umask.
fn readable_by_all(_builder: &mut tempfile::Builder) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        _builder.permissions(fs::Permissions::from_mode(0o666));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_older_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, "old").unwrap();
        let error = write_whole_with(&path, |file| {
            file.write_all(b"new")?;
            Err(io::Error::other("no more"))
        });
        assert!(error.unwrap_err().what.contains("no more"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn success_replaces_the_older_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, "a long older text").unwrap();
        write_whole(&path, "new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_an_error_with_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.txt");
        let error = write_whole(&path, "x").unwrap_err();
        assert_eq!(error.place, Some(path.display().to_string()));
        assert!(write_whole(folder.path(), "x").unwrap_err().what.contains("folder"));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_not_replaced_and_a_link_is_followed() {
        use std::os::unix::fs::FileTypeExt;
        write_whole(Path::new("/dev/null"), "x").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        write_whole(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_whole(&link, "new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
