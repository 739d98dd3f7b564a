//! Files of a desktop, which has a folder for recordings.

use std::io::{Error, Write};
use std::path::Path;

use eframe::egui::DroppedFileHandle;

use super::Arrived;

pub fn keeps_at_once() -> bool {
    true
}

/// The first number from `least` on that no file in the folder has, so that recordings of an
/// earlier window are kept.
pub fn free(folder: &Path, least: u32) -> u32 {
    let taken = |n: u32| ["trace", "csv", "png"].iter().any(|ending| folder.join(format!("live-{n}.{ending}")).exists());
    (least..u32::MAX).find(|n| !taken(*n)).unwrap_or(least)
}

/// Writes a file completely or not at all; returns a sentence, and whether it reports a failure.
pub fn put(folder: &Path, name: &str, bytes: &[u8]) -> (String, bool) {
    let path = folder.join(name);
    match whole(folder, name, bytes) {
        Ok(()) => (format!("Wrote {}, {} kB.", path.display(), bytes.len().div_ceil(1024)), false),
        Err(why) => (
            format!("Cannot write {}: {why}: make room or a folder that can be written, then save it with W.", path.display()),
            true,
        ),
    }
}

fn whole(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Error> {
    std::fs::create_dir_all(folder)?;
    let part = folder.join(format!(".{name}.{}.part", std::process::id()));
    let written = std::fs::File::create(&part)
        .and_then(|mut file| file.write_all(bytes))
        .and_then(|()| std::fs::rename(&part, folder.join(name)));
    if written.is_err() {
        // the file may not exist
        let _gone = std::fs::remove_file(&part);
    }
    written
}

pub fn fetch(file: &DroppedFileHandle, arrived: &Arrived) {
    if let (Ok(bytes), Ok(mut arrived)) = (file.bytes(), arrived.lock()) {
        arrived.push((file.path().display().to_string(), bytes));
    }
}

/// Returns `false`: on a desktop the user types the path in a line.
pub fn choose(_arrived: &Arrived) -> bool {
    false
}

/// Reads a file; if that fails, returns the reason.
pub fn read(path: &str, arrived: &Arrived) -> Option<String> {
    match std::fs::read(path) {
        Ok(bytes) => {
            if let Ok(mut arrived) = arrived.lock() {
                arrived.push((path.to_owned(), bytes));
            }
            None
        }
        Err(why) => Some(format!("Cannot read {path}: {why}: give the path of a trace or a scene.")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_not_written_over_and_nothing_is_left_half_written() {
        let folder = std::env::temp_dir().join(format!("palpate-live-{}", std::process::id()));
        assert_eq!(free(&folder, 1), 1);
        assert!(!put(&folder, "live-1.trace", b"one").1 && !put(&folder, "live-3.png", b"three").1);
        assert_eq!([free(&folder, 1), free(&folder, 3)], [2, 4]);
        assert!(put(&folder.join("live-1.trace"), "live-2.trace", b"in a file").1);
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
