//! A mesh file as lines of words.

use std::str::SplitWhitespace;

use super::error::{Defect, MeshError, quoted};
use super::word::{At, Word};

/// One line of a file, with its words read from the left.
pub(super) struct Line<'a> {
    pub at: At<'a>,
    /// The whole line, trimmed.
    pub text: &'a str,
    words: SplitWhitespace<'a>,
}

impl<'a> Line<'a> {
    pub fn word(&mut self, what: &'static str) -> Result<Word<'a>, MeshError> {
        self.next().ok_or_else(|| self.at.error(Defect::Missing { what }))
    }

    pub fn whole(&mut self, what: &'static str) -> Result<u64, MeshError> {
        self.word(what)?.whole(what)
    }

    pub fn position(&mut self) -> Result<[f64; 3], MeshError> {
        Ok([
            self.word("the x coordinate")?.coordinate()?,
            self.word("the y coordinate")?.coordinate()?,
            self.word("the z coordinate")?.coordinate()?,
        ])
    }

    /// Skips `count` words.
    pub fn skip_words(&mut self, count: u64, what: &'static str) -> Result<(), MeshError> {
        for _ in 0..count {
            self.word(what)?;
        }
        Ok(())
    }

    /// Checks that no words are left, since a line that was joined to the next one must not be
    /// accepted.
    pub fn finish(mut self) -> Result<(), MeshError> {
        match self.next() {
            None => Ok(()),
            Some(word) => Err(self.at.error(Defect::Surplus { found: quoted(word.text) })),
        }
    }
}

impl<'a> Iterator for Line<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        let at = self.at;
        self.words.next().map(|text| Word { at, text })
    }
}

/// The lines of a file that contain at least one word. A line may end as on any system, now or
/// long ago: with a line feed, a carriage return, or both.
pub(super) struct Lines<'a> {
    file: &'a str,
    rest: &'a str,
    reached: usize,
}

impl<'a> Lines<'a> {
    pub fn new(file: &'a str, text: &'a str) -> Self {
        // some programs fill the last block of a file with zeros, or mark its end
        Self { file, rest: text.trim_end_matches(['\0', '\u{1a}']), reached: 0 }
    }

    /// The lines of a part of a file, after the first `before`.
    pub fn following(file: &'a str, text: &'a str, before: usize) -> Self {
        Self { reached: before, ..Self::new(file, text) }
    }

    /// Place of the line that was read last.
    pub fn at(&self) -> At<'a> {
        At { file: self.file, line: self.reached.max(1) }
    }

    /// The next line even if it is blank.
    pub fn any_line(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.bytes().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix(['\r', '\n'])).unwrap_or(rest);
        self.reached += 1;
        Some(Line { at: self.at(), text: line.trim(), words: line.split_whitespace() })
    }

    /// The next line, without which the file is incomplete.
    pub fn required(&mut self, what: &'static str) -> Result<Line<'a>, MeshError> {
        self.next().ok_or_else(|| self.at().error(Defect::Truncated { what }))
    }

    /// Passes the next `count` lines to `read`. A line that starts with `$` ends a Gmsh section, so
    /// it is never one of them. The count is only a loop bound: no memory is allocated for it.
    pub fn rows(
        &mut self,
        section: &'static str,
        items: &'static str,
        count: u64,
        mut read: impl FnMut(Line<'a>) -> Result<(), MeshError>,
    ) -> Result<(), MeshError> {
        for found in 0..count {
            match self.next() {
                Some(line) if !line.text.starts_with('$') => read(line)?,
                _ => {
                    return Err(self.at().error(Defect::TooFew { section, items, announced: count, found }));
                }
            }
        }
        Ok(())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.any_line()?;
            if !line.text.is_empty() {
                return Some(line);
            }
        }
    }
}
