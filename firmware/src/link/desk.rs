//! What the controller does with each message: what is for the cycle is kept for its next tick, what changes the patch is handed up.

use palpate::Fault;
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::haptic::mode::{Mode, Request};

use super::message::{HostAsk, Refusal, ToBoard};
use super::upload::Upload;
use crate::config::Profile;
use crate::controller::Controller;

/// Something that only the owner of the patch can do; no tick in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Put the patch away: another one of so many bytes will come.
    MakeRoom(u32),
    /// Take the patch that has come.
    Take,
    /// Take the same patch with another Young's modulus [Pa].
    Modulus(f32),
}

/// What a message leads to, besides the next tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// Nothing.
    None,
    /// The tick's input is complete.
    Tick,
    /// It is not done.
    Refused(Refusal),
    /// Only the owner of the patch can do it.
    Change(Change),
    /// The patch under the hand takes another Young's modulus [Pa], as soon as it may.
    Modulus(f32),
    /// Say how you are.
    Report,
    /// Keep this profile.
    Store(Profile),
}

/// What came since the last tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Desk {
    heard: bool,
    asked: Option<Ask>,
    sensed: Option<Sensed>,
    found: Option<Fault>,
}

impl Desk {
    /// Takes a message. `upload` is the memory for a patch while no patch lies in it.
    pub fn take(&mut self, message: &ToBoard<'_>, controller: &mut Controller, upload: Option<&mut Upload>) -> Reply {
        self.heard = true;
        match *message {
            ToBoard::Heartbeat => Reply::None,
            ToBoard::Pose { position_m, sequence, good } => {
                let status = if good { SensorStatus::Good } else { SensorStatus::Failed };
                self.sensed = Some(Sensed { position_m: position_m.into(), sequence, status });
                Reply::Tick
            }
            ToBoard::Ask(HostAsk::Arm) if upload.is_some() => Reply::Refused(Refusal::NoPatch),
            // who wants to stop is stopped, whatever comes behind it before the next tick
            ToBoard::Ask(asked) => {
                if self.asked != Some(Ask::Stop) {
                    self.asked = Some(asked.into());
                }
                Reply::None
            }
            ToBoard::LowerLimits(bounds) => match controller.lower_limits(&(&bounds).into()) {
                Ok(()) => Reply::None,
                Err(_) => Reply::Refused(Refusal::LimitRises),
            },
            ToBoard::YoungsModulus(pascal) => match controller.mode() {
                Mode::Idle => Reply::Change(Change::Modulus(pascal)),
                mode if mode.accepts(Request::Parameter) => Reply::Modulus(pascal),
                _ => Reply::Refused(Refusal::NotIdle),
            },
            ToBoard::PatchBegin(bytes) => idle(controller.mode(), Change::MakeRoom(bytes)),
            ToBoard::PatchPart { at, bytes } => match upload.map_or(Err(Refusal::PatchPieces), |memory| memory.part(at, bytes)) {
                Ok(()) => Reply::None,
                Err(refusal) => Reply::Refused(refusal),
            },
            ToBoard::PatchEnd => match upload {
                Some(_) => idle(controller.mode(), Change::Take),
                None => Reply::Refused(Refusal::PatchPieces),
            },
            ToBoard::SupplyLow => {
                self.found = Some(Fault::SupplyLow);
                Reply::None
            }
            ToBoard::Report => Reply::Report,
            ToBoard::Store(profile) if controller.mode().accepts(Request::Config) => Reply::Store(profile),
            ToBoard::Store(_) => Reply::Refused(Refusal::NotIdle),
        }
    }

    /// The newest reading that the host sent, and what it said, for one tick. A desk without a new reading repeats nothing: the cycle sees its age.
    pub fn clear(&mut self) -> (Option<Sensed>, Command) {
        let Self { heard, asked, sensed, found } = core::mem::take(self);
        (sensed, Command { heard, asked, found, ..Command::default() })
    }
}

fn idle(mode: Mode, change: Change) -> Reply {
    if mode.accepts(Request::Mesh) { Reply::Change(change) } else { Reply::Refused(Refusal::NotIdle) }
}
