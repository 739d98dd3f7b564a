//! The log of a board in the terminal.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate::haptic::mode::Mode;
use palpate_board::defmt_log::LogTable;
use palpate_board::image::repository;
use palpate_controller::link::{FromBoard, Log as Piece, ToBoard};
use palpate_tissue::Error as TissueError;

use crate::error::Error;
use crate::port::Session;

/// Folders below the target folder in which `cargo fw-...` puts images.
const IMAGES: [&str; 2] =
    ["thumbv7em-none-eabihf/firmware/palpate-firmware", "thumbv8m.main-none-eabihf/firmware/palpate-firmware"];
/// Longest wait for the rest of a log.
const GATHERED: Duration = Duration::from_secs(2);
/// Time between two requests for the log, which stays on the board unless a host listens.
pub(super) const LISTENING: Duration = Duration::from_millis(20);

/// Decodes the log that arrives from a board to lines.
pub(super) struct Log {
    /// Checksum of the board's image.
    board: u32,
    table: Table,
    /// Number of lost frames that were already reported.
    lost: u32,
    /// Number of frames that no image here explains.
    unread: usize,
}

enum Table {
    /// The table is searched for when the first frame arrives.
    Unsought,
    Found(LogTable),
    Missing,
}

impl Log {
    /// Opens the log of the board on this session, with the ELF file that the command line names,
    /// and asks the board to send it.
    pub(super) fn of(given: Option<&Path>, session: &mut Session) -> Result<Self, Error> {
        let board = session.identity.image;
        let table = match given {
            None => Table::Unsought,
            Some(path) => match LogTable::of_board(path.into(), board) {
                Ok(table) => Table::Found(table),
                Err(error) => return Err(TissueError::Usage(format!("--image {error}")).into()),
            },
        };
        session.send(&ToBoard::Listen(true))?;
        Ok(Self { board, table, lost: 0, unread: 0 })
    }

    /// Lines that have arrived since the last call.
    pub(super) fn lines(&mut self, session: &mut Session) -> Vec<String> {
        session.log.drain(..).flat_map(|piece| self.piece(&piece)).collect()
    }

    /// Decodes the frames of one piece into lines.
    fn piece(&mut self, piece: &Piece) -> Vec<String> {
        let mut lines = Vec::new();
        if piece.lost > self.lost {
            lines.push(format!("({} lines lost on the board: its memory for them was full)", piece.lost - self.lost));
            self.lost = piece.lost;
        }
        let frames = piece.frames.bytes();
        if !frames.is_empty() && matches!(self.table, Table::Unsought) {
            self.table = built(self.board).map_or(Table::Missing, Table::Found);
        }
        match &self.table {
            Table::Found(table) => lines.extend(table.lines(frames)),
            _ => self.unread += frames.iter().filter(|byte| **byte == 0).count(),
        }
        lines
    }

    /// Advice on how to read a log that no image here explains, if one arrived.
    pub(super) fn unread(&self) -> Option<String> {
        (self.unread > 0).then(|| {
            format!(
                "{} lines came and no image here explains them: give the ELF file that was flashed with --image ELF",
                self.unread
            )
        })
    }

    /// Waits for the rest of the log while the board is at rest. Requests for the log also count as
    /// keep-alive messages, and must not prolong a force.
    pub(super) fn gather(session: &mut Session) {
        let begun = Instant::now();
        while at_rest(session) && begun.elapsed() < GATHERED {
            if session.last_sent().elapsed() >= LISTENING && session.send(&ToBoard::Listen(true)).is_err() {
                return; // return; // the outcome of the command itself says more
            }
            match session.next(LISTENING) {
                // a piece without a frame means that no line waits
                Ok(Some(FromBoard::Log(piece))) if piece.frames.bytes().is_empty() => return,
                Ok(_) => {}
                Err(_) => return,
            }
        }
    }

    /// Asks the board to keep later lines. A board that exerts a force is not asked: it notices the
    /// silence by itself.
    pub(super) fn leave(session: &mut Session) {
        if at_rest(session) {
            // the outcome of the command itself says whether the port has gone
            let _ = session.send(&ToBoard::Listen(false));
        }
    }

    /// Gathers and prints the remaining lines.
    pub(super) fn end(&mut self, session: &mut Session) {
        Self::gather(session);
        Self::leave(session);
        for line in self.lines(session).into_iter().chain(self.unread()) {
            eprintln!("log: {line}");
        }
    }
}

fn at_rest(session: &Session) -> bool {
    !session.record.enabled && matches!(session.record.mode(), Some(Mode::Idle | Mode::Fault))
}

/// The image that was built last in the repository around the working folder, if it is the board's.
fn built(board: u32) -> Option<LogTable> {
    images().find_map(|image| LogTable::of_board(image, board).ok())
}

/// Images that were built in the repository around the working folder.
pub(super) fn images() -> impl Iterator<Item = PathBuf> {
    repository().into_iter().flat_map(|root| {
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(PathBuf::from(folder)));
        IMAGES.map(|image| target.join(image))
    })
}

#[cfg(test)]
mod tests {
    use palpate_controller::link::log::Frames;

    use super::{Log, Piece, Table};

    #[test]
    fn lost_lines_are_told_once_and_lines_without_an_image_are_counted() {
        let mut log = Log { board: 7, table: Table::Missing, lost: 0, unread: 0 };
        let piece = |lost, bytes: &[u8]| Piece { lost, frames: Frames::of(bytes.iter().copied()) };
        assert!(log.piece(&piece(0, &[1, 2, 0])).is_empty() && log.unread().unwrap().starts_with("1 lines came"));
        assert_eq!(log.piece(&piece(3, &[])), ["(3 lines lost on the board: its memory for them was full)"]);
        assert!(log.piece(&piece(3, &[1, 0, 1, 0])).is_empty(), "told once");
        assert_eq!(log.piece(&piece(5, &[])), ["(2 lines lost on the board: its memory for them was full)"]);
        let says = log.unread().unwrap();
        assert!(says.starts_with("3 lines came") && says.contains("--image ELF"), "{says}");
    }
}
