//! A VTK file as a sequence of words, whatever its line breaks.

use super::{Line, Lines, Word};
use crate::mesh::error::{Defect, MeshError};
use crate::mesh::word::At;

/// Keywords that begin or end the data that is read.
const SECTIONS: [&str; 9] =
    ["POINTS", "CELLS", "CELL_TYPES", "VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELL_DATA", "POINT_DATA"];

pub(super) struct Words<'a> {
    lines: Lines<'a>,
    line: Option<Line<'a>>,
}

impl<'a> Words<'a> {
    pub fn new(lines: Lines<'a>) -> Self {
        Self { lines, line: None }
    }

    /// Place of the line that was read last.
    pub fn at(&self) -> At<'a> {
        self.lines.at()
    }

    pub fn required(&mut self, what: &'static str) -> Result<Word<'a>, MeshError> {
        self.next().ok_or_else(|| self.at().error(Defect::Truncated { what }))
    }

    pub fn whole(&mut self, what: &'static str) -> Result<u64, MeshError> {
        self.required(what)?.whole(what)
    }

    /// The next value of entry `found` out of `announced`; a keyword in its place means that the
    /// section is too short.
    pub fn value(
        &mut self,
        section: &'static str,
        items: &'static str,
        announced: u64,
        found: u64,
    ) -> Result<Word<'a>, MeshError> {
        match self.next() {
            Some(word) if !is_keyword(word.text) => Ok(word),
            _ => Err(self.at().error(Defect::TooFew { section, items, announced, found })),
        }
    }

    /// The keyword of the next section. `FIELD` and `METADATA` may occur between sections and are
    /// skipped; anything else there means that a count is wrong.
    pub fn next_section(&mut self) -> Result<Option<Word<'a>>, MeshError> {
        while let Some(word) = self.next() {
            match word.text.to_ascii_uppercase().as_str() {
                "FIELD" => self.skip_field()?,
                "METADATA" => {
                    if let Some(section) = self.skip_metadata() {
                        return Ok(Some(section));
                    }
                }
                _ if is_section(word.text) => return Ok(Some(word)),
                _ => return Err(word.unexpected("the next section (the counts before it are too low)")),
            }
        }
        Ok(None)
    }

    /// Skips the rest of `FIELD name count`: arrays `name components tuples type values...`, where
    /// each tuple of text has a line of its own.
    pub fn skip_field(&mut self) -> Result<(), MeshError> {
        self.required("the name of the FIELD")?;
        for _ in 0..self.whole("the number of arrays")? {
            let mut name = self.required("an array of the FIELD")?;
            // an array may be followed by what describes it
            while name.text.eq_ignore_ascii_case("METADATA") {
                name = match self.skip_metadata() {
                    Some(next) => next,
                    None => self.required("an array of the FIELD")?,
                };
            }
            let (components, tuples) = (self.whole("the number of components")?, self.whole("the number of tuples")?);
            let kind = self.required("a type of number")?;
            let values = components.saturating_mul(tuples);
            if kind.text.eq_ignore_ascii_case("string") {
                for _ in 0..values {
                    self.lines.any_line().ok_or_else(|| self.at().error(Defect::Truncated { what: "the end of a FIELD" }))?;
                }
                continue;
            }
            for _ in 0..values {
                self.required("the end of a FIELD")?;
            }
        }
        Ok(())
    }

    /// Skips what describes an array: the lines up to a blank one, or up to a section, whose
    /// keyword it returns.
    fn skip_metadata(&mut self) -> Option<Word<'a>> {
        self.line = None;
        while let Some(mut line) = self.lines.any_line() {
            let first = line.next()?;
            if is_section(first.text) {
                self.line = Some(line);
                return Some(first);
            }
        }
        None
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = Word<'a>;

    fn next(&mut self) -> Option<Word<'a>> {
        loop {
            if let Some(word) = self.line.as_mut().and_then(Line::next) {
                return Some(word);
            }
            self.line = Some(self.lines.next()?);
        }
    }
}

fn is_section(text: &str) -> bool {
    SECTIONS.iter().any(|name| text.eq_ignore_ascii_case(name))
}

fn is_keyword(text: &str) -> bool {
    is_section(text) || ["FIELD", "METADATA", "OFFSETS", "CONNECTIVITY"].iter().any(|name| text.eq_ignore_ascii_case(name))
}
