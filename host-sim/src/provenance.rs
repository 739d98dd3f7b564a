//! How a result was made: `provenance` in every `summary.json`.

use std::time::{Duration, SystemTime};

use palpate_tissue::machine::{PROFILE, cores, processor};
use palpate_tissue::scene::Scene;
use palpate_tissue::shard::Part;
use serde::Serialize;
use serde_json::Value;

/// Options that say where a result goes, how it is cut up or what is printed of it: they decide
/// nothing in it.
const ELSEWHERE: [&str; 2] = ["--out", "--shard"];
const PRINTED: &str = "--all";

/// How a result was made.
#[derive(Debug, Serialize)]
struct Provenance<'a> {
    /// Version of the program.
    version: &'static str,
    /// Commit that it was built from, with `-dirty` where files were changed since.
    commit: Option<&'static str>,
    /// Build profile.
    profile: &'static str,
    /// Command that made it.
    command: &'a str,
    /// Arguments of the program that decide the result.
    command_line: &'a [String],
    /// Scene as read, with the keys that --set changed.
    scene: Option<Value>,
    machine: Machine,
    /// Universal time at which the run began.
    date: String,
}

#[derive(Debug, Serialize)]
struct Machine {
    processor: String,
    /// Processors that the system gave to the run.
    cores: usize,
}

/// Provenance of what this process makes, of a scene if there is one.
pub fn of(scene: Option<&Scene>) -> Value {
    told(&command_line(), Machine { processor: processor(), cores: cores() }, scene)
}

/// Provenance of what shards made that ran elsewhere: as of one run of all, but for the date.
pub fn of_shards(shards: &[Part], scene: Option<&Scene>) -> Value {
    let mut processors: Vec<&str> = shards.iter().map(|shard| shard.heading.processor.as_str()).collect();
    processors.dedup();
    let first = shards.first().map(|shard| &shard.heading);
    let machine = Machine { processor: processors.join("; "), cores: first.map_or(1, |heading| heading.cores) };
    told(first.map_or(&[], |heading| &heading.command_line), machine, scene)
}

fn told(command_line: &[String], machine: Machine, scene: Option<&Scene>) -> Value {
    let commit = env!("PALPATE_COMMIT");
    let provenance = Provenance {
        version: env!("CARGO_PKG_VERSION"),
        commit: (!commit.is_empty()).then_some(commit),
        profile: PROFILE,
        // without arguments, a press
        command: command_line.first().map_or("press", String::as_str),
        command_line,
        scene: scene.map(Scene::as_read),
        machine,
        date: humantime::format_rfc3339_seconds(now()).to_string(),
    };
    // text and whole numbers: nothing that JSON does not have
    serde_json::to_value(provenance).unwrap_or_default()
}

/// The time, or the one that a build asks for that wants the same bytes again
/// (reproducible-builds.org).
fn now() -> SystemTime {
    let asked = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| seconds.parse().ok());
    asked.map_or_else(SystemTime::now, |seconds| SystemTime::UNIX_EPOCH + Duration::from_secs(seconds))
}

/// Arguments of this process that decide a result.
pub fn command_line() -> Vec<String> {
    deciding(std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()))
}

fn deciding(mut arguments: impl Iterator<Item = String>) -> Vec<String> {
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
    fn a_command_line_keeps_what_decides_a_result() {
        let kept = |line: &str| deciding(line.split(' ').map(str::to_owned)).join(" ");
        assert_eq!(kept("faults --shard 1/3 --runs 100 --out a --all"), "faults --runs 100");
        assert_eq!(kept("plan --out=a --tolerance-pct=3 --shard=1/2"), "plan --tolerance-pct=3");
        assert_eq!(kept("press --scene block"), "press --scene block");
    }
}
