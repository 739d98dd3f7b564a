//! Decodes the image's log to text: the frames contain only references to format strings, which are
//! in the ELF file.

use std::path::PathBuf;

use defmt_decoder::{DecodeError, Table};
use object::{Object, ObjectSection, ObjectSymbol};

/// Symbol of an image's checksum, which a board reports in its identity.
const IMAGE: &str = "PALPATE_IMAGE";

/// Why an ELF file cannot explain a board's log.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be read.
    #[error("{path}: {source}: give the ELF file that was flashed, as `cargo fw-...` leaves it", path = .path.display())]
    Unread {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not an image with a log.
    #[error("{path}: no image of palpate with a log ({cause}): give the ELF file that was flashed", path = .path.display())]
    NoImage {
        /// Path of the file.
        path: PathBuf,
        /// Statement of the part that is missing or unreadable.
        cause: String,
    },
    /// The file is not the image that the board runs.
    #[error(
        "{path}: not the image that the board runs ({found:08x}, the board's is {board:08x}): give the ELF file that was flashed",
        path = .path.display()
    )]
    Other {
        /// Path of the file.
        path: PathBuf,
        /// Checksum of the image in the file.
        found: u32,
        /// Checksum of the board's image.
        board: u32,
    },
}

/// Format strings of an image.
pub struct LogTable(Table);

impl LogTable {
    /// Reads the format strings from an ELF file; `Err` says whether they are missing or
    /// unreadable.
    ///
    /// # Errors
    /// The file has no format strings, or they are of another version of defmt.
    pub fn parse(elf: &[u8]) -> Result<Self, String> {
        match Table::parse(elf) {
            Ok(Some(table)) => Ok(Self(table)),
            Ok(None) => Err("it holds no defmt table".into()),
            Err(error) => Err(format!("its defmt table is unreadable: {error:#}")),
        }
    }

    /// Reads the format strings of the image that a board runs, whose checksum the board reports.
    ///
    /// # Errors
    /// The file is not that image, or not an image with a log.
    pub fn of_board(path: PathBuf, board: u32) -> Result<Self, LogError> {
        let elf = match std::fs::read(&path) {
            Ok(elf) => elf,
            Err(source) => return Err(LogError::Unread { path, source }),
        };
        match checksum(&elf) {
            None => Err(LogError::NoImage { path, cause: format!("it holds no {IMAGE}") }),
            Some(found) if found != board => Err(LogError::Other { path, found, board }),
            Some(_) => Self::parse(&elf).map_err(|cause| LogError::NoImage { path, cause }),
        }
    }

    /// Decodes the frames to one line each, with time and level; a frame that cannot be decoded is
    /// marked in its place.
    #[must_use]
    pub fn lines(&self, frames: &[u8]) -> Vec<String> {
        let mut decoder = self.0.new_stream_decoder();
        decoder.received(frames);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(frame.display(false).to_string()),
                Err(DecodeError::Malformed) => lines.push("(a frame that does not decode)".into()),
                Err(DecodeError::UnexpectedEof) => return lines,
            }
        }
    }
}

/// Checksum of an image's sources and features, from its ELF file.
#[must_use]
pub fn checksum(elf: &[u8]) -> Option<u32> {
    let file = object::File::parse(elf).ok()?;
    let symbol = file.symbols().find(|symbol| symbol.name() == Ok(IMAGE))?;
    let section = file.section_by_index(symbol.section_index()?).ok()?;
    let at = usize::try_from(symbol.address().checked_sub(section.address())?).ok()?;
    section.data().ok()?.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
}

/// Decodes a log to lines, each with its line end, or returns the reason why it cannot be decoded.
#[must_use]
pub fn decode(elf: &[u8], frames: &[u8]) -> String {
    match LogTable::parse(elf) {
        Ok(table) => table.lines(frames).into_iter().map(|line| line + "\n").collect(),
        Err(cause) => format!("(the log is lost: {cause})\n"),
    }
}
