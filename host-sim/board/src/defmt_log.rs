//! Decodes the image's log to text: its frames refer to format strings in the ELF file.

use std::fmt::Write as _;

use defmt_decoder::{DecodeError, Table};

/// One message per line with its time; a frame that cannot be decoded is marked in its place.
#[must_use]
pub fn decode(elf: &[u8], frames: &[u8]) -> String {
    let table = match Table::parse(elf) {
        Ok(Some(table)) => table,
        Ok(None) => return "(the image holds no defmt table)\n".into(),
        Err(error) => return format!("(the image's defmt table is unreadable: {error:#})\n"),
    };
    let mut decoder = table.new_stream_decoder();
    decoder.received(frames);
    let mut lines = String::new();
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let _ = writeln!(lines, "{}", frame.display(false)); // writing to a string does not fail
            }
            Err(DecodeError::Malformed) => lines.push_str("(a frame that does not decode)\n"),
            Err(DecodeError::UnexpectedEof) => return lines,
        }
    }
}
