//! Errors of scene files, with the line and a suggestion.

use std::path::PathBuf;

use super::PRESETS;

/// Methods that `palpate chart` compares; `press` runs only "palpate" and "springs".
pub const CHARTED_METHODS: [&str; 14] = [
    "springs",
    "volume-preserved",
    "local-compression",
    "springs-volume-tet",
    "springs-volume-nodal",
    "palpate",
    "palpate-calibrated",
    "corotational",
    "neo-hookean",
    "neo-hookean-nodal",
    "meshless",
    "xpbd",
    "implicit",
    "compliance",
];

/// Words between a key and the tip that has it, in the message about a tip without it.
pub(super) const FOREIGN: &str = " belongs to ";

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read scene {path}: {source}: check the path, or use a preset ({})", presets())]
    Read {
        /// Path of the scene file.
        path: PathBuf,
        /// Cause of the failure.
        source: std::io::Error,
    },
    /// A scene file of a command that has scenes of another kind cannot be read.
    #[error("cannot read scene {path}: {source}: check the path, or leave it out for \"{preset}\"")]
    ReadOther {
        /// Path of the scene file.
        path: PathBuf,
        /// Cause of the failure.
        source: std::io::Error,
        /// Preset of that kind, which is used if no file is given.
        preset: &'static str,
    },
    /// The name is neither that of a preset nor of a file.
    #[error("no scene \"{name}\": {}presets: {}; or give the path of a .toml file", meant(*nearest), presets())]
    UnknownName {
        /// The requested name.
        name: String,
        /// The preset with a similar spelling, if there is one.
        nearest: Option<&'static str>,
    },
    /// Bad TOML, a missing or unknown key, a value of the wrong kind.
    #[error("{file}:{line}: {what}")]
    Toml {
        /// Name of the scene in messages: preset or path.
        file: String,
        /// Line number, counted from 1.
        line: usize,
        /// Defect and how to fix it.
        what: String,
        /// Key that the scene has and must not have, if that is the defect.
        surplus: Option<String>,
    },
    /// A parameter that the core refuses.
    #[error("{file}: {table}{cause}")]
    Parameter {
        /// Name of the scene in messages: preset or path.
        file: String,
        /// Table of the key with its dot; empty if the core's name for the parameter already has
        /// one.
        table: &'static str,
        /// The core's message: parameter, value and range.
        cause: palpate::BuildError,
    },
    /// A change on the command line that cannot be applied.
    #[error("--set {changes}: {what}")]
    Change {
        /// The changes as given on the command line.
        changes: String,
        /// Defect and how to fix it.
        what: String,
    },
    /// An impossible value.
    #[error("{file}: {key} {why}")]
    Value {
        /// Name of the scene in messages: preset or path.
        file: String,
        /// Key with its table.
        key: String,
        /// Defect and how to fix it.
        why: String,
    },
}

fn meant(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |nearest| format!("did you mean \"{nearest}\"? "))
}

fn presets() -> String {
    PRESETS.map(|(name, _)| name).join(", ")
}

impl SceneError {
    pub(super) fn unknown_name(name: &str) -> Self {
        let nearest = nearest(name, PRESETS.iter().map(|(n, _)| *n));
        Self::UnknownName { name: name.into(), nearest }
    }

    /// An error for a value of `key` in `file` that cannot be used; `why` gives the reason.
    #[must_use]
    pub fn value(file: &str, key: &str, why: &str) -> Self {
        Self::Value { file: file.into(), key: key.into(), why: why.into() }
    }

    /// An error for a scene in bad TOML, with the line and a suggestion.
    #[must_use]
    pub fn of_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        Self::of_toml_like("presets under host-sim/scenes", file, text, error)
    }

    /// An error for bad TOML in `file`, with the line and a suggestion; `like` names files that are
    /// right.
    #[must_use]
    pub fn of_toml_like(like: &str, file: &str, text: &str, error: &toml::de::Error) -> Self {
        let before = error.span().map_or("", |span| &text[..span.start.min(text.len())]);
        let mut line = before.matches('\n').count() + 1;
        let at = text.lines().nth(line - 1).unwrap_or_default();
        let mut surplus = None;
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        let what = if let Some((key, near)) = unknown(&message, "unknown field `") {
            // serde reports the line of the table, not that of the key
            line += text.lines().skip(line - 1).position(|l| key_of(l) == Some(key)).unwrap_or(0);
            surplus = Some(key.to_owned());
            match near {
                Some(near) => format!("unknown key \"{key}\": did you mean \"{near}\"?"),
                None => format!("unknown key \"{key}\": remove it, or use one of {}", listed(&message)),
            }
        } else if let Some((word, near)) = unknown(&message, "unknown variant `") {
            not_known(word, near, &message)
        } else if let Some(key) = message.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
            let table = if at.trim_start().starts_with('[') { at.trim() } else { "the file" };
            format!("key \"{key}\" is missing in {table}: add it, as in the {like}")
        } else if let Some((key, why)) = message.split_once(FOREIGN) {
            surplus = Some(key.to_owned());
            format!("probe.{key}{FOREIGN}{why}: remove it")
        } else {
            // the key of the value at which the span begins, also inside a table on one line
            let own =
                before.lines().last().and_then(|line| line.rsplit_once('=')).and_then(|(keys, _)| keys.split_whitespace().last());
            let key = own.or(key_of(at));
            if let (Some(key), Some((found, entries))) = (key, lengths(&message)) {
                format!("{key} is a list of length {found}: give {entries} entries")
            } else {
                let key = key.map_or(String::new(), |key| format!("{key}: "));
                format!("{key}{}: see the {like} for the form", in_toml_words(&message))
            }
        };
        Self::Toml { file: file.into(), line, what, surplus }
    }
}

/// Number of entries of a list, and that of the array that it fills.
fn lengths(message: &str) -> Option<(&str, &str)> {
    message.strip_prefix("invalid length ")?.split_once(", expected an array of length ")
}

/// Message for a word that is not a variant; for a charted method, it says which commands run it.
fn not_known(word: &str, near: Option<&str>, message: &str) -> String {
    if CHARTED_METHODS.contains(&word) {
        let names = CHARTED_METHODS.join(", ");
        return format!(
            "method \"{word}\" runs in palpate chart (as do {names}), press runs \"palpate\" and \"springs\": use one of these two, or palpate chart"
        );
    }
    match near {
        Some(near) => format!("\"{word}\" is not known here: did you mean \"{near}\"?"),
        None => format!("\"{word}\" is not known here: give one of {}", listed(message)),
    }
}

/// The key that a line sets.
fn key_of(line: &str) -> Option<&str> {
    line.split_once('=').map(|(key, _)| key.trim())
}

/// Rewrites Rust names in a serde message as TOML terms.
fn in_toml_words(message: &str) -> String {
    [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number from 0"),
        ("expected a sequence", "expected a list [..]"),
        ("invalid type: sequence", "invalid type: a list"),
    ]
    .iter()
    .fold(message.to_owned(), |text, (rust, toml)| text.replace(rust, toml))
}

/// The word that serde does not know, and the known word with a similar spelling.
fn unknown<'a>(message: &'a str, prefix: &str) -> Option<(&'a str, Option<&'a str>)> {
    let (word, _) = message.strip_prefix(prefix)?.split_once('`')?;
    Some((word, nearest(word, known_words(message))))
}

fn listed(message: &str) -> String {
    known_words(message).collect::<Vec<_>>().join(", ")
}

/// The words that serde knows in place of an unknown one.
fn known_words(message: &str) -> impl Iterator<Item = &str> {
    message.split('`').skip(3).step_by(2)
}

/// The known word that begins with `word`, or else the one with the most similar spelling; `None`
/// if more than half of its letters differ.
fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let ranked = known.map(|k| (word.is_empty() || !k.starts_with(word), strsim::damerau_levenshtein(word, k), k));
    let (differs, changes, near) = ranked.min()?;
    (!differs || 2 * changes <= word.len().max(near.len())).then_some(near)
}
