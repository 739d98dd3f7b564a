//! Errors of scene files, with line and a suggestion.

use std::path::PathBuf;

use super::PRESETS;

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read scene {path}: {source}: check the path, or use a preset ({})", presets())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// Neither a preset nor a file.
    #[error("no scene \"{name}\": did you mean \"{nearest}\"? Presets: {}; or give the path of a .toml file", presets())]
    UnknownName {
        /// What was asked for.
        name: String,
        /// The preset spelled most like it.
        nearest: &'static str,
    },
    /// Bad TOML, a missing or unknown key, a value of the wrong kind.
    #[error("{file}:{line}: {what}")]
    Toml {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong and how to fix it.
        what: String,
    },
    /// A value that cannot be.
    #[error("{file}: {key} {why}")]
    Value {
        /// The file.
        file: String,
        /// Key with its table.
        key: String,
        /// What is wrong and how to fix it.
        why: String,
    },
}

fn presets() -> String {
    PRESETS.map(|(name, _)| name).join(", ")
}

impl SceneError {
    pub(super) fn unknown_name(name: &str) -> Self {
        let nearest = nearest(name, PRESETS.iter().map(|(n, _)| *n)).unwrap_or(PRESETS[0].0);
        Self::UnknownName { name: name.into(), nearest }
    }

    pub(crate) fn value(file: &str, key: &str, why: &str) -> Self {
        Self::Value { file: file.into(), key: key.into(), why: why.into() }
    }

    pub(super) fn of_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        let message = error.message().lines().collect::<Vec<_>>().join(" ");
        let what = match unknown_key(&message) {
            Some((key, Some(known))) => format!("unknown key \"{key}\": did you mean \"{known}\"?"),
            Some((key, None)) => format!("unknown key \"{key}\": remove it"),
            None => format!("{message}: see the presets under host-sim/scenes for the form"),
        };
        Self::Toml { file: file.into(), line, what }
    }
}

/// The key that serde does not know, and the known one spelled most like it.
fn unknown_key(message: &str) -> Option<(&str, Option<&str>)> {
    let rest = message.strip_prefix("unknown field `").or_else(|| message.strip_prefix("unknown variant `"))?;
    let (key, expected) = rest.split_once('`')?;
    Some((key, nearest(key, expected.split('`').skip(1).step_by(2))))
}

fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    known.min_by_key(|k| strsim::damerau_levenshtein(word, k))
}
