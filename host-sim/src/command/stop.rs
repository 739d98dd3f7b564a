//! Ctrl-C during a run: it ends at once, and says what it leaves.

use std::path::Path;

/// Lets Ctrl-C end this run, which writes into a folder, with one line about what stays.
#[cfg(feature = "stop")]
pub(super) fn says_what_stays(out: &Path) {
    /// Exit code after Ctrl-C, as shells know it.
    const STOPPED: i32 = 130;
    let out = out.to_owned();
    // without the handler the run ends the same way, without the line
    let _ = ctrlc::set_handler(move || {
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
