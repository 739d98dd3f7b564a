//! Paths of a result and its draft, and the exchange of the two.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::record::RECORD;
use super::{RECORD_SUFFIX, Record};
use crate::error::Error;

/// Paths of a result's folder and its draft, absolute and without links.
#[derive(Debug)]
pub(super) struct Place {
    folder: PathBuf,
    draft: PathBuf,
}

impl Place {
    /// Resolves a path and creates its parents; returns those that were created, innermost first.
    pub(super) fn of(path: &Path) -> io::Result<(Self, Vec<PathBuf>)> {
        let mut made = Vec::new();
        let folder = if path.symlink_metadata().is_ok() {
            let folder = path.canonicalize()?;
            if !folder.is_dir() {
                return Err(ErrorKind::NotADirectory.into());
            }
            folder
        } else {
            let (parent, name) =
                (path.parent().ok_or(ErrorKind::InvalidInput)?, path.file_name().ok_or(ErrorKind::InvalidInput)?);
            let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
            made.extend(parent.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).map(Path::to_owned));
            fs::create_dir_all(parent)?;
            parent.canonicalize()?.join(name)
        };
        if folder.file_name().is_none() {
            return Err(ErrorKind::InvalidInput.into());
        }
        let mut place = Self { folder, draft: PathBuf::new() };
        place.draft = place.beside("draft");
        Ok((place, made))
    }

    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    pub(super) fn draft(&self) -> &Path {
        &self.draft
    }

    pub(super) fn lock(&self) -> PathBuf {
        self.beside("lock")
    }

    pub(super) fn notes(&self) -> PathBuf {
        self.beside("notes")
    }

    fn old(&self) -> PathBuf {
        self.beside("old")
    }

    /// Path of a hidden neighbour of the folder, on the same file system, so that a rename can
    /// exchange them.
    fn beside(&self, role: &str) -> PathBuf {
        let mut name = OsString::from(".");
        name.push(self.folder.file_name().unwrap_or_default());
        name.push(format!(".{role}"));
        self.folder.with_file_name(name)
    }

    /// Refuses to replace a folder that cannot be replaced, or must not be because of its content.
    pub(super) fn refuse_foreign(&self, shown: &Path) -> Result<(), Error> {
        if !self.folder.exists() {
            return Ok(());
        }
        let refuse = |source| Error::Write { path: shown.into(), source };
        let shown = shown.display();
        if std::env::current_dir().is_ok_and(|here| here == self.folder) || is_mount(&self.folder).map_err(refuse)? {
            return Err(Error::Usage(format!(
                "--out {shown}: a result replaces its folder, which the current folder and a mounted one do not allow: give a new folder inside it"
            )));
        }
        if Record::read(&self.folder).is_none()
            && let Some(first) = fs::read_dir(&self.folder).map_err(refuse)?.next().transpose().map_err(refuse)?
        {
            return Err(Error::Usage(format!(
                "--out {shown}: it holds {:?} but no result of palpate, whose folder may be replaced: choose a new or an empty folder",
                first.file_name()
            )));
        }
        Ok(())
    }

    /// Removes the remains of a killed run, at whatever step it was killed.
    pub(super) fn recover(&self) -> io::Result<()> {
        let old = self.old();
        if old.exists() {
            // killed between the two renames: restores the earlier result
            if self.folder.exists() { self.settle(&old)? } else { fs::rename(&old, &self.folder)? }
        }
        if self.draft.exists() {
            // only a complete result has a record
            if Record::read(&self.draft).is_some() { self.settle(&self.draft)? } else { fs::remove_dir_all(&self.draft)? }
        }
        Ok(())
    }

    /// Exchanges draft and folder, then moves the files that are kept from the earlier result.
    pub(super) fn replace(&self, dropped: &[String]) -> io::Result<()> {
        let earlier = Record::read(&self.folder).unwrap_or_default();
        let mut record = Record { run: earlier.run + 1, names: flushed(&self.draft)? };
        for name in &record.names {
            if self.folder.join(name).is_dir() {
                return Err(io::Error::new(ErrorKind::IsADirectory, format!("{name} is a folder")));
            }
        }
        // a patch and the record of its fit are kept together
        let patch = |name: &&String| {
            let patch = name.strip_suffix(RECORD_SUFFIX).unwrap_or(name);
            patch.ends_with(".patch") && !dropped.iter().any(|gone| gone == patch)
        };
        record.names.extend(earlier.names.iter().filter(patch).cloned());
        record.write(&self.draft)?;
        if !self.folder.join(RECORD).exists() {
            // the folder does not exist or is empty
            return fs::rename(&self.draft, &self.folder);
        }
        // the folder keeps its permissions: a private one stays private
        fs::set_permissions(&self.draft, self.folder.metadata()?.permissions())?;
        if exchange(&self.draft, &self.folder).is_ok() {
            return self.settle(&self.draft);
        }
        fs::rename(&self.folder, self.old())?;
        fs::rename(&self.draft, &self.folder)?;
        self.settle(&self.old())
    }

    /// Moves each file of the draft into the folder.
    pub(super) fn add(&self) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let names = flushed(&self.draft)?;
        let earlier = Record::read(&self.folder);
        // a folder with foreign files gets no record, so that no result ever replaces it
        if earlier.is_some() || fs::read_dir(&self.folder)?.next().is_none() {
            let mut record = earlier.unwrap_or_default();
            record.names.extend(names.iter().cloned());
            record.write(&self.folder)?;
        }
        names.iter().try_for_each(|name| fs::rename(self.draft.join(name), self.folder.join(name)))
    }

    /// Empties and removes the folder of a replaced result: its files are deleted; foreign files
    /// and patches to be kept move to the new folder. `from` is the earlier result after an
    /// exchange, or a newer one that was never moved into place, of which nothing is kept.
    fn settle(&self, from: &Path) -> io::Result<()> {
        let ours = Record::read(from).unwrap_or_default();
        let kept = Record::read(&self.folder).filter(|now| now.run > ours.run).unwrap_or_default();
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            let name = entry.file_name();
            let listed = |names: &BTreeSet<String>| name.to_str().is_some_and(|name| names.contains(name));
            let to = self.folder.join(&name);
            if name == RECORD {
                continue;
            } else if listed(&ours.names) && !listed(&kept.names) || to.symlink_metadata().is_ok() {
                fs::remove_file(entry.path())?;
            } else {
                fs::create_dir_all(&self.folder)?;
                fs::rename(entry.path(), to)?;
            }
        }
        match fs::remove_file(from.join(RECORD)) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        fs::remove_dir(from)
    }
}

/// Final path of a file in a draft; `None` if its folder is not a draft.
pub(super) fn published(file: &Path) -> Option<PathBuf> {
    let draft = file.parent()?;
    let name = draft.file_name()?.to_str()?.strip_prefix('.')?.strip_suffix(".draft")?;
    Some(draft.with_file_name(name).join(file.file_name()?))
}

/// Writes the files of a draft through to the disk, since a full disk may be reported only then;
/// returns their names.
fn flushed(draft: &Path) -> io::Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(draft)? {
        let entry = entry?;
        fs::File::options().write(true).open(entry.path())?.sync_all()?;
        names.insert(entry.file_name().into_string().map_err(|_| ErrorKind::InvalidFilename)?);
    }
    Ok(names)
}

/// Exchanges two folders in one step.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

#[cfg(unix)]
fn is_mount(folder: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let Some(parent) = folder.parent() else { return Ok(true) };
    Ok(folder.metadata()?.dev() != parent.metadata()?.dev())
}

#[cfg(not(unix))]
fn is_mount(folder: &Path) -> io::Result<bool> {
    Ok(folder.parent().is_none())
}
