//! Ctrl-C during a run: it ends at once, and says what it leaves.

use std::path::Path;
#[cfg(feature = "stop")]
use std::{path::PathBuf, sync::Mutex};

/// Lets Ctrl-C end this run, which writes into a folder, with one line about what stays. A command
/// that goes on to another folder says so again.
#[cfg(feature = "stop")]
pub(super) fn says_what_stays(out: &Path) {
    /// Exit code after Ctrl-C, as shells know it.
    const STOPPED: i32 = 130;
    static OUT: Mutex<PathBuf> = Mutex::new(PathBuf::new());
    let last = || OUT.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    *last() = out.to_owned();
    // the first handler stays; without it the run ends the same way, without the line
    let _ = ctrlc::set_handler(move || {
        let out = last();
        let stays = if out.exists() { "is as it was before this run" } else { "was not written" };
        let notes = palpate_tissue::output::has_notes(&out);
        let resumes = if notes { ": the same command goes on where this one stopped" } else { "" };
        eprintln!("\npalpate: stopped: {} {stays}{resumes}", out.display());
        std::process::exit(STOPPED);
    });
}

/// Without the handler, Ctrl-C leaves the same, silently.
#[cfg(not(feature = "stop"))]
pub(super) fn says_what_stays(_: &Path) {}
