//! The log of a serving board: the events that it reports, and the memory in which their frames
//! wait for the link.
//!
//! A board encodes an event (with defmt, in `firmware/src/board/log.rs`); [`crate::serve`] sends
//! the pending frames, between two records, to a host that reads the log.

use palpate::Fault;
use palpate::haptic::mode::Mode;

use crate::link::Refusal;
use crate::link::log::{Frames, LOG_BYTES, Log};
use crate::snapshot::Snapshot;

/// Capacity for pending frames [bytes]: some thirty lines.
pub const RING_BYTES: usize = 512;

/// An event that a serving board logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A patch is ready, at rest.
    PatchOpened {
        /// Number of nodes.
        nodes: u32,
        /// Checksum of the patch file.
        checksum: u32,
        /// Young's modulus [Pa].
        youngs_modulus_pa: f32,
    },
    /// A patch of this many bytes is announced.
    UploadBegun(u32),
    /// The mode has changed.
    Mode {
        /// The new mode.
        to: Mode,
        /// The mode before.
        from: Mode,
    },
    /// A fault is latched.
    Fault(Fault),
    /// A request was not carried out.
    Refused(Refusal),
    /// Counts since the start; at least one of them has increased.
    Late {
        /// Ticks that ended after their period.
        overruns: u32,
        /// Periods without a tick.
        missed_periods: u32,
    },
    /// A profile is in use, stored under this generation number; 0 if it is not stored.
    Profile(u32),
    /// The home pose has been recorded.
    Homed,
}

/// State of the haptic loop as the log has reported it.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    mode: Mode,
    fault: Option<Fault>,
    overruns: u32,
    missed_periods: u32,
}

impl Told {
    /// State before the first report.
    pub const NOTHING: Self = Self { mode: Mode::Boot, fault: None, overruns: 0, missed_periods: 0 };

    /// The next event that the log has not reported. Late ticks are reported only if `late` is
    /// true, because each of them would be an event. Not generic, so that its code is compiled in
    /// this crate, which images build for size.
    #[inline(never)]
    pub fn next(&mut self, now: &Snapshot, late: bool) -> Option<Event> {
        let Self { mode: from, fault, overruns, missed_periods } = *self;
        if fault != now.fault {
            self.fault = now.fault;
            if let Some(fault) = now.fault {
                return Some(Event::Fault(fault));
            }
        }
        if from != now.mode {
            self.mode = now.mode;
            return Some(Event::Mode { to: now.mode, from });
        }
        if late && (overruns, missed_periods) != (now.overruns, now.missed_periods) {
            (self.overruns, self.missed_periods) = (now.overruns, now.missed_periods);
            return Some(Event::Late { overruns: now.overruns, missed_periods: now.missed_periods });
        }
        None
    }
}

/// Frames that wait for the link, in a ring. A frame that does not fit is dropped whole and
/// counted, so the ring keeps the first events of a failure, and a reader sees how many are
/// missing.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    bytes: [u8; RING_BYTES],
    /// Index of the oldest byte.
    first: usize,
    /// Number of bytes of complete frames.
    waiting: usize,
    /// Number of bytes of the frame that is being written, after the complete ones.
    begun: usize,
    /// Whether the frame that is being written did not fit.
    cut: bool,
    lost: u32,
    /// Number of lost frames that has been reported.
    told: u32,
}

impl Ring {
    /// A ring without pending frames.
    pub const EMPTY: Self = Self { bytes: [0; RING_BYTES], first: 0, waiting: 0, begun: 0, cut: false, lost: 0, told: 0 };

    /// Begins a frame. A frame that was begun and not ended is discarded.
    pub fn begin(&mut self) {
        (self.begun, self.cut) = (0, false);
    }

    /// Adds bytes of the frame in its encoding, including the zero that closes it. A leading zero
    /// is dropped.
    pub fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if *byte == 0 && self.begun == 0 {
                continue;
            }
            let at = (self.first + self.waiting + self.begun) % RING_BYTES;
            match self.bytes.get_mut(at) {
                Some(place) if self.begun < LOG_BYTES && self.waiting + self.begun < RING_BYTES => {
                    *place = *byte;
                    self.begun += 1;
                }
                _ => self.cut = true,
            }
        }
    }

    /// Ends the frame: it becomes pending, or is counted as lost if it did not fit.
    pub fn end(&mut self) {
        if self.cut {
            self.lost = self.lost.saturating_add(1);
        } else {
            self.waiting += self.begun;
        }
        self.begin();
    }

    /// Removes the oldest frames, as many whole ones as fit into a message; `None` if there is
    /// nothing to report.
    pub fn take(&mut self) -> Option<Log> {
        if self.waiting == 0 && self.told == self.lost {
            return None;
        }
        let most = self.waiting.min(LOG_BYTES);
        let at = |n: usize| self.bytes.get((self.first + n) % RING_BYTES).copied().unwrap_or(0);
        // no frame is longer than a message, so at least one ends within it
        let length = (0..most).rev().find(|n| at(*n) == 0).map_or(most, |end| end + 1);
        let frames = Frames::of((0..length).map(at));
        self.first = (self.first + length) % RING_BYTES;
        self.waiting -= length;
        self.told = self.lost;
        Some(Log { lost: self.lost, frames })
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    /// A frame of `length` bytes, including its closing zero.
    fn frame(length: usize, byte: u8) -> Vec<u8> {
        [[byte].repeat(length - 1), [0].to_vec()].concat()
    }

    fn put(ring: &mut Ring, frame: &[u8]) {
        ring.begin();
        // in pieces, as an encoder writes
        frame.chunks(3).for_each(|piece| ring.push(piece));
        ring.end();
    }

    /// Removes all pending frames, message by message.
    fn drain(ring: &mut Ring) -> Vec<(u32, Vec<u8>)> {
        core::iter::from_fn(|| ring.take()).map(|log| (log.lost, log.frames.bytes().to_vec())).collect()
    }

    #[test]
    fn frames_come_out_whole_and_in_order_wherever_the_ring_begins() {
        let mut ring = Ring::EMPTY;
        for round in 0..200_usize {
            let lengths = [round % 90 + 2, 7, round % 13 + 2];
            let frames: Vec<Vec<u8>> = lengths.iter().zip(1..).map(|(length, byte)| frame(*length, byte)).collect();
            frames.iter().for_each(|frame| put(&mut ring, frame));
            let messages = drain(&mut ring);
            assert!(messages.iter().all(|(lost, bytes)| *lost == 0 && bytes.len() <= LOG_BYTES && bytes.last() == Some(&0)));
            let came: Vec<u8> = messages.into_iter().flat_map(|(_, bytes)| bytes).collect();
            assert_eq!(came, frames.concat(), "round {round}");
        }
        assert!(ring.take().is_none());
    }

    #[test]
    fn a_full_ring_drops_whole_frames_and_counts_them_and_keeps_what_waits() {
        let mut ring = Ring::EMPTY;
        let frames: Vec<Vec<u8>> = (1..=9).map(|byte| frame(60, byte)).collect();
        frames.iter().for_each(|frame| put(&mut ring, frame));
        put(&mut ring, &frame(20, 10)); // there is room for this one
        let messages = drain(&mut ring);
        assert!(messages.iter().all(|(lost, _)| *lost == 1), "{messages:?}");
        let came: Vec<u8> = messages.into_iter().flat_map(|(_, bytes)| bytes).collect();
        assert_eq!(came, [frames[..8].concat(), frame(20, 10)].concat());
        put(&mut ring, &frames[8]);
        assert_eq!(drain(&mut ring), [(1, frames[8].clone())], "once there is room it goes on");
    }

    #[test]
    fn a_frame_longer_than_a_message_is_lost_and_told_even_if_nothing_waits() {
        let mut ring = Ring::EMPTY;
        put(&mut ring, &frame(LOG_BYTES + 1, 1));
        assert_eq!(drain(&mut ring), [(1, Vec::new())], "told once");
        put(&mut ring, &frame(LOG_BYTES, 2));
        assert_eq!(drain(&mut ring), [(1, frame(LOG_BYTES, 2))]);
    }

    #[test]
    fn a_frame_that_never_ends_leaves_nothing_behind() {
        let mut ring = Ring::EMPTY;
        put(&mut ring, &frame(5, 1));
        ring.begin();
        ring.push(&[9, 9, 9]);
        put(&mut ring, &[&[0][..], &frame(6, 2)].concat());
        put(&mut ring, &[0]);
        assert_eq!(drain(&mut ring), [(0, [frame(5, 1), frame(6, 2)].concat())], "nor does a zero alone");
    }

    #[test]
    fn changes_are_told_once_and_late_ticks_when_they_are_asked_for() {
        let mut told = Told::NOTHING;
        let mut now = Snapshot::START;
        assert_eq!(told.next(&now, true), None);
        (now.mode, now.fault, now.overruns) = (Mode::Fault, Some(Fault::OverSpeed), 3);
        assert_eq!(told.next(&now, false), Some(Event::Fault(Fault::OverSpeed)));
        assert_eq!(told.next(&now, false), Some(Event::Mode { to: Mode::Fault, from: Mode::Boot }));
        assert_eq!(told.next(&now, false), None);
        now.missed_periods = 2;
        assert_eq!(told.next(&now, true), Some(Event::Late { overruns: 3, missed_periods: 2 }));
        (now.mode, now.fault) = (Mode::Idle, None);
        assert_eq!(told.next(&now, true), Some(Event::Mode { to: Mode::Idle, from: Mode::Fault }));
        assert_eq!(told.next(&now, true), None);
    }
}
