//! Verdict of a command in one line, which is both the first and the last line on standard output.

use std::fmt;
use std::io::IsTerminal;

use crate::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::scene::Scene;

/// Outcome of a command: the promise that it kept, or why it did not keep it.
#[derive(Clone, Debug)]
pub struct Verdict {
    outcome: Result<String, String>,
    doubtful: bool,
}

impl Verdict {
    /// Verdict for a kept promise, described by `words`.
    pub fn ok(words: impl Into<String>) -> Self {
        Self { outcome: Ok(words.into()), doubtful: false }
    }

    /// A kept promise whose result should not be relied on is a warning.
    pub fn warning_if(self, doubtful: bool) -> Self {
        Self { doubtful, ..self }
    }

    /// Puts the warnings of the scene's values in front.
    pub fn about(self, scene: &Scene) -> Self {
        let odd: String = scene.warnings().iter().map(|warning| format!("{warning}; ")).collect();
        let doubtful = self.doubtful || !odd.is_empty();
        Self { outcome: self.outcome.map(|words| odd + &words), doubtful }
    }

    /// Verdict of a check; `words` describe a kept promise.
    pub fn of(check: Result<(), impl Into<Error>>, words: impl FnOnce() -> String) -> Result<Self, Error> {
        match check.map_err(Into::into) {
            Ok(()) => Ok(Self::ok(words())),
            Err(Error::Tissue(TissueError::Check(why))) => Ok(Self { outcome: Err(why), doubtful: false }),
            Err(error) => Err(error),
        }
    }

    /// Prints the verdict before the details.
    pub fn first(self) -> Self {
        println!("{self}");
        self
    }

    /// Prints the verdict after the details. On a terminal a failed check is already visible on
    /// standard error, so it is not repeated there.
    pub fn last(self) -> Result<(), Error> {
        if self.outcome.is_ok() || !std::io::stdout().is_terminal() {
            println!("{self}");
        }
        self.outcome.map(|_| ()).map_err(|why| TissueError::Check(why).into())
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.outcome {
            Ok(words) if self.doubtful => write!(f, "warning: {words}"),
            Ok(words) => write!(f, "ok: {words}"),
            Err(why) => write!(f, "failed: {why}"),
        }
    }
}
