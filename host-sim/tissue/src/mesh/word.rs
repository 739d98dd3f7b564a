//! One word of a mesh file, with its place and its possible meanings.

use super::error::{Defect, MeshError, quoted};

/// A line of a file, as a place for messages.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub file: &'a str,
    /// Line number, counted from 1.
    pub line: usize,
}

impl At<'_> {
    pub fn error(self, defect: Defect) -> MeshError {
        MeshError { file: self.file.to_owned(), line: Some(self.line), defect }
    }
}

/// One word of a file.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    pub at: At<'a>,
    pub text: &'a str,
}

impl Word<'_> {
    /// Reads the word as a count, number or code: a whole number of at least 0.
    pub fn whole(self, what: &'static str) -> Result<u64, MeshError> {
        self.text.parse().map_err(|_| self.unexpected(what))
    }

    /// Reads the word as a region; a whole number may be written as a real.
    pub fn region(self) -> Result<u32, MeshError> {
        let whole = match self.text.split_once('.') {
            Some((whole, fraction)) if fraction.bytes().all(|digit| digit == b'0') => whole,
            _ => self.text,
        };
        whole.parse().map_err(|_| self.unexpected("a region number (whole, from 0)"))
    }

    /// Reads the word as a finite coordinate, in file units.
    pub fn coordinate(self) -> Result<f64, MeshError> {
        let what = "a coordinate";
        // Fortran writes the exponent of a double as D
        let number = self.text.parse::<f64>().or_else(|_| self.text.replace(['d', 'D'], "e").parse());
        let value = number.map_err(|_| self.unexpected(what))?;
        if value.is_finite() {
            Ok(value)
        } else {
            let found = quoted(self.text);
            Err(self.at.error(Defect::NotFinite { what, found }))
        }
    }

    pub fn unexpected(self, what: &'static str) -> MeshError {
        let found = quoted(self.text);
        self.at.error(Defect::Expected { what, found })
    }
}
