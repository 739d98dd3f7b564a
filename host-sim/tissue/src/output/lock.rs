//! Lock of an output folder, into which only one run at a time may write.

use std::fs::{File, TryLockError};
use std::io;
use std::path::PathBuf;

/// A file that is locked while a run writes, and removed afterwards. If a run is killed, the system
/// releases its lock.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    /// Folders made for this run, innermost first; they are removed if the run leaves them empty.
    made: Vec<PathBuf>,
    _file: File,
}

impl Lock {
    /// Takes the lock; `None` if another run holds it.
    pub(super) fn take(path: PathBuf, made: Vec<PathBuf>) -> io::Result<Option<Self>> {
        loop {
            let file = File::options().create(true).truncate(false).write(true).open(&path)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => return Err(error),
            }
            // between opening and locking, the run that held the lock may have removed its file
            if is_at(&file, &path) {
                return Ok(Some(Self { path, made, _file: file }));
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // removed while still locked: a run that opened it earlier notices that it is gone
        let _ = std::fs::remove_file(&self.path);
        for folder in &self.made {
            // folders that are not empty cannot be removed and stay
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &std::path::Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |meta: std::fs::Metadata| (meta.dev(), meta.ino());
    let (held, there) = (file.metadata().map(id), path.metadata().map(id));
    held.is_ok_and(|held| there.is_ok_and(|there| held == there))
}

/// Always true: on other systems an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &std::path::Path) -> bool {
    true
}
