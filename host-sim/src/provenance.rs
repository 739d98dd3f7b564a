//! Origin of a result: `provenance` in every `summary.json`.

use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

use palpate_tissue::machine::{PROFILE, cores, processor};
use palpate_tissue::scene::Scene;
use serde::Serialize;
use serde_json::Value;

/// Options for the output folder, the cases or the printed rows, which do not affect the result.
const ELSEWHERE: [&str; 2] = ["--out", "--cases"];
const PRINTED: &str = "--all";

/// Origin of a result.
#[derive(Debug, Serialize)]
struct Provenance<'a> {
    /// Version of the program.
    version: &'static str,
    /// Commit from which the program was built, with `-dirty` if files were changed since.
    commit: Option<&'static str>,
    /// Cargo profile with which the program was built.
    profile: &'static str,
    /// Command that produced the result.
    command: &'a str,
    /// Arguments of the program that affect the result.
    command_line: &'a [String],
    /// Scene as read, with the keys that --set changed.
    scene: Option<Value>,
    machine: Computer,
    /// UTC time at which the run began.
    date: String,
}

#[derive(Debug, Serialize)]
struct Computer {
    processor: String,
    /// Number of processors available to the run.
    cores: usize,
}

/// Provenance of this process's results, with the scene if there is one.
pub fn of(scene: Option<&Scene>) -> Value {
    told(&command_line(), Computer { processor: processor(), cores: cores() }, scene)
}

/// Provenance of a result whose cases ran elsewhere, with this command line.
pub fn of_cases(command_line: &[String], processor: String, cores: usize, scene: Option<&Scene>) -> Value {
    told(command_line, Computer { processor, cores }, scene)
}

/// Commit of a program that contains this crate and changes apart from it.
static OTHER: OnceLock<&str> = OnceLock::new();

/// Says from which commit the program was built.
pub fn built_from(commit: &'static str) {
    // the first to say so is the program itself
    let _ = OTHER.set(commit);
}

fn told(command_line: &[String], machine: Computer, scene: Option<&Scene>) -> Value {
    let commit = OTHER.get().copied().unwrap_or(env!("PALPATE_COMMIT"));
    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION"),
        commit: (!commit.is_empty()).then_some(commit),
        profile: PROFILE,
        // without arguments the command is `press`
        command: command_line.first().map_or("press", String::as_str),
        command_line,
        scene: scene.map(Scene::as_read),
        machine,
        date: rfc3339(now_s()),
    };
    // text and whole numbers only, which JSON can represent
    serde_json::to_value(provenance).unwrap_or_default()
}

/// The present time [s since 1970-01-01], or the time set by a build that has to reproduce the same
/// bytes (reproducible-builds.org).
fn now_s() -> u64 {
    let asked = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| seconds.parse().ok());
    asked.unwrap_or_else(|| SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()))
}

/// Date and time of a number of seconds since 1970-01-01, in the Gregorian calendar. Years begin in
/// March, so that the day that a leap year adds is their last one; 400 years have 146 097 days.
fn rfc3339(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let date = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let (hour, minute) = (second / 3_600, second / 60 % 60);
    format!("{:04}-{month:02}-{date:02}T{hour:02}:{minute:02}:{:02}Z", 400 * era + year + next, second % 60)
}

/// Arguments of this process that affect a result. Those of `check chart` are those of `chart`.
pub fn command_line() -> Vec<String> {
    deciding(std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()))
}

fn deciding(arguments: impl Iterator<Item = String>) -> Vec<String> {
    let mut arguments = arguments.enumerate().filter(|(n, argument)| *n > 0 || argument != "check").map(|(_, argument)| argument);
    let mut kept = Vec::new();
    while let Some(argument) = arguments.next() {
        if ELSEWHERE.contains(&argument.as_str()) {
            arguments.next();
        } else if argument != PRINTED && !ELSEWHERE.iter().any(|name| argument.starts_with(&format!("{name}="))) {
            kept.push(argument);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        // as `date --utc --date @SECONDS` prints them
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (1_795_564_800, "2026-11-25T00:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(rfc3339(seconds), date);
        }
    }

    #[test]
    fn a_command_line_keeps_what_decides_a_result() {
        let kept = |line: &str| deciding(line.split(' ').map(str::to_owned)).join(" ");
        assert_eq!(kept("faults --cases 0..9 --runs 100 --out a --all"), "faults --runs 100");
        assert_eq!(kept("fit --out=a --tolerance-pct=3 --cases=1..2"), "fit --tolerance-pct=3");
        assert_eq!(kept("check chart --quick --out out/a"), "chart --quick");
        assert_eq!(kept("press --scene block"), "press --scene block");
    }
}
