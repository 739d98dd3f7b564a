//! Writes rows to the files on a thread of its own: a disk that stalls must not silence the thread
//! whose keep-alive messages keep the force on.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use palpate_controller::link::{Identity, Record};
use palpate_tissue::Error as TissueError;

use crate::error::Error;

/// Largest number of rows that wait for the disk: ten seconds of a board's records.
const QUEUE: usize = 5_000;
/// Longest wait for the disk at the end, when no force acts any more.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two checks whether the writer is done.
const LOOK: Duration = Duration::from_millis(1);

/// Destination of rows.
pub(super) trait Sink: Send + 'static {
    /// Writes a row; this may take any time.
    fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error>;
}

/// A thread that writes rows. Unless [`Self::end`] is called, it goes on alone with the rows that
/// wait.
pub(super) struct Writer<S> {
    rows: SyncSender<(Record, Identity)>,
    thread: JoinHandle<Result<S, Error>>,
    dropped: usize,
}

/// A run of which every row has been written.
pub(super) struct Written<S> {
    pub(super) sink: S,
    /// Number of rows that were dropped because the queue was full.
    pub(super) dropped: usize,
}

impl<S: Sink> Writer<S> {
    pub(super) fn start(sink: S) -> Self {
        let (rows, waiting) = sync_channel(QUEUE);
        Self { rows, thread: std::thread::spawn(move || write(sink, &waiting)), dropped: 0 }
    }

    /// Passes a row on without waiting. Returns false if nothing is written any more; [`Self::end`]
    /// returns the reason.
    pub(super) fn add(&mut self, record: &Record, identity: &Identity) -> bool {
        match self.rows.try_send((*record, *identity)) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.dropped += 1;
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }

    /// Waits until all rows are written.
    pub(super) fn end(self) -> Result<Written<S>, Error> {
        drop(self.rows);
        let begun = Instant::now();
        while !self.thread.is_finished() {
            if begun.elapsed() > PATIENCE {
                return Err(stuck());
            }
            std::thread::sleep(LOOK);
        }
        // a panic of the writing thread continues in this one
        let sink = self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        Ok(Written { sink, dropped: self.dropped })
    }
}

impl<S> Written<S> {
    /// Says how many rows are missing, if any.
    pub(super) fn gap(&self) -> Option<String> {
        (self.dropped > 0).then(|| {
            format!(
                "{} rows are missing in what was written: the disk did not keep up; write to a faster one, or end what else uses it",
                self.dropped
            )
        })
    }
}

fn write<S: Sink>(mut sink: S, waiting: &Receiver<(Record, Identity)>) -> Result<S, Error> {
    while let Ok((record, identity)) = waiting.recv() {
        sink.add(&record, &identity)?;
    }
    Ok(sink)
}

fn stuck() -> Error {
    let why = format!("the disk has taken no row for {} s: rows are missing in what was written", PATIENCE.as_secs());
    TissueError::Check(why).into()
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::super::stream::example::{RECORD, identity};
    use super::*;

    /// A disk that reports every row that it is asked to write, and writes one row for every word
    /// that it receives.
    struct Disk {
        given: Sender<u32>,
        words: Receiver<()>,
        taken: Vec<u32>,
    }

    impl Sink for Disk {
        fn add(&mut self, record: &Record, _: &Identity) -> Result<(), Error> {
            self.given.send(record.tick).unwrap();
            self.words.recv().map_err(|_| stuck())?;
            self.taken.push(record.tick);
            Ok(())
        }
    }

    fn disk() -> (Writer<Disk>, Receiver<u32>, Sender<()>) {
        let ((given, told), (word, words)) = (channel(), channel());
        (Writer::start(Disk { given, words, taken: Vec::new() }), told, word)
    }

    fn rows(writer: &mut Writer<Disk>, ticks: std::ops::Range<u32>) -> bool {
        ticks.filter(|tick| !writer.add(&Record { tick: *tick, ..RECORD }, &identity())).count() == 0
    }

    #[test]
    fn a_disk_that_stalls_delays_nobody_and_what_it_missed_is_counted() {
        let (mut writer, told, word) = disk();
        assert!(rows(&mut writer, 0..1));
        assert_eq!(told.recv(), Ok(0), "the disk has it, and takes it for ever");
        let most = QUEUE as u32 + 1;
        assert!(rows(&mut writer, 1..most), "room for these");
        assert!(rows(&mut writer, most..most + 7), "no room, and no wait either");
        (0..most).for_each(|_| word.send(()).unwrap());
        let written = writer.end().unwrap();
        assert_eq!(written.sink.taken, (0..most).collect::<Vec<_>>(), "in order, without those of the end");
        assert!(written.gap().unwrap().starts_with("7 rows are missing"));
    }

    #[test]
    fn without_a_stall_nothing_is_missing() {
        let (mut writer, _told, word) = disk();
        assert!(rows(&mut writer, 0..20));
        (0..20).for_each(|_| word.send(()).unwrap());
        let written = writer.end().unwrap();
        assert_eq!((written.sink.taken.len(), written.gap()), (20, None));
    }

    #[test]
    fn a_disk_that_fails_is_noticed_and_named() {
        let (mut writer, told, word) = disk();
        assert!(rows(&mut writer, 0..1));
        assert_eq!(told.recv(), Ok(0));
        drop(word);
        while rows(&mut writer, 1..2) {
            std::thread::sleep(LOOK);
        }
        assert!(writer.end().is_err());
    }
}
