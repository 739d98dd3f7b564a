//! The controller with a host on its link, in one of two modes.
//!
//! * **Timed**: the tick timer begins a tick, the board's own sensors give the pose, the link is
//!   read without blocking after the force was written, and a record is sent every second tick. A
//!   host that is silent for 20 ticks counts as lost, and the force is ramped down to zero.
//! * **Lock-step**: the host's pose begins a tick, and the record sent to the host ends it. No
//!   timer runs, so no tick is ever late. The emulator stops while the board waits for the host, so
//!   a run gives the same bits on a machine under any load.

mod line;
mod offer;

use crate::link::inbox::Reply;
use crate::link::{Change, FromBoard, Identity, Inbox, Receiver, Refusal, ToBoard, Upload};
use crate::log::Event;
use crate::patch::{Memory, Patch, PatchSlot, TICK_S};
use palpate::haptic::account::EnergyBound;
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};

use crate::board::Board;
use crate::config::{Profile, StoreError};
use crate::controller::Controller;
use crate::force_out::Outputs;
use crate::haptic_loop::HapticLoop;
use crate::probe_in::Reading;

use self::line::Line;
use self::offer::Offer;

/// In timed mode, number of ticks per record: 500 records per second take two thirds of the link.
pub const RECORD_TICKS: u32 = 2;
/// In timed mode, number of ticks per piece of the log, of at most 109 bytes.
pub const LOG_TICKS: u32 = 40;
/// Tick of every [`LOG_TICKS`] in which a piece is sent: between two records.
const LOG_AT: u32 = 11;
/// A host that asks for the log receives it for this many ticks; without a reader, frames stay on
/// the board.
pub const LISTENS_TICKS: u32 = 250;
/// After this many ticks of silence a host may return with any sequence number.
const FORGET_TICKS: u32 = 100;

/// Speed of the tap that is measured when a patch is opened [m/tick], that of the script's hand,
/// and the depth at which it begins [m].
const TAP_M: f32 = 0.23e-3;
const ABOVE_M: f32 = -3e-3;
/// Periods of the tick timer per second.
const PERIODS_PER_S: u32 = 1_000;

/// Trigger of a tick.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// The tick timer triggers a tick.
    Timed,
    /// The host's pose triggers a tick.
    LockStep,
}

/// Decodes the frame that is complete and returns the reply to its message. Not generic, so that
/// its code is compiled in this crate, which images build for size.
#[inline(never)]
fn replied(
    receiver: &mut Receiver,
    inbox: &mut Inbox,
    controller: &mut Controller,
    upload: Option<&mut Upload>,
) -> Option<Reply> {
    receiver.end_frame(|message: &ToBoard<'_>| inbox.take(message, controller, upload)).ok()
}

/// Serves a host. In timed mode the function never returns; in lock-step it returns, with the
/// outputs off, when the host has gone. `in_flash` is the patch that is built into the image.
pub async fn run<B: Board>(haptic: &mut HapticLoop<B>, in_flash: &[u8], memory: &mut Memory, upload: &mut Upload, pace: Pace) {
    let (mut line, mut offer) = (Line::silent(), Offer::IN_FLASH);
    let mut inbox = Inbox::default();
    if let Some(generation) = haptic.board.restarted_for() {
        stored(haptic, &mut line, generation);
    }
    loop {
        let wanted = match offer.bytes(in_flash, upload) {
            Ok(None) => Ok(serve(haptic, &mut PatchSlot(None), Some(&mut *upload), &mut inbox, &mut line, pace).await),
            Ok(Some(bytes)) => match open(haptic, bytes, memory, offer.modulus_pa) {
                Ok(patch) => {
                    let mut tissue = PatchSlot(Some(patch));
                    rehearse(haptic, &mut tissue);
                    let nodes = tissue.state().0 as u32;
                    let (checksum, youngs_modulus_pa, _) = tissue.identity();
                    haptic.board.log(Event::PatchOpened { nodes, checksum, youngs_modulus_pa });
                    if offer.asked {
                        line.send(&mut haptic.board, &FromBoard::PatchTaken(nodes));
                    }
                    offer.taken();
                    Ok(serve(haptic, &mut tissue, None, &mut inbox, &mut line, pace).await)
                }
                Err(refusal) => Err(refusal),
            },
            Err(refusal) => Err(refusal),
        };
        offer.asked = false;
        let changed = match wanted {
            Ok(None) => return,
            Ok(Some(change)) => {
                if let Change::MakeRoom(bytes) = change {
                    haptic.board.log(Event::UploadBegun(bytes));
                }
                offer.change(change, upload)
            }
            Err(refusal) => {
                offer.withdraw();
                Err(refusal)
            }
        };
        if let Err(refusal) = changed {
            line.refuse(&mut haptic.board, refusal);
        }
    }
}

/// Opens a patch between two ticks. That may take longer than the watchdog's time, so the watchdog
/// is fed in between, but only while the pins show that the outputs are off.
fn open<'a>(
    haptic: &mut HapticLoop<impl Board>,
    bytes: &'a [u8],
    memory: &'a mut Memory,
    modulus_pa: Option<f32>,
) -> Result<Patch<'a>, Refusal> {
    let (board, ceiling_n_per_m) = (&mut haptic.board, haptic.controller.stiffness_ceiling_n_per_m());
    Patch::open_for(&board.budget(), ceiling_n_per_m, bytes, memory, modulus_pa, &mut || keep_awake(board))
}

/// Measures the longest tick of a patch that was opened, in a tap to its depth limit with the
/// outputs off.
#[inline(never)]
fn rehearse(haptic: &mut HapticLoop<impl Board>, tissue: &mut PatchSlot<'_>) {
    let (Some(patch), board) = (&mut tissue.0, &mut haptic.board) else { return };
    let (mut longest_counts, mut depth_m) = (0, ABOVE_M);
    while depth_m < patch.model().depth_limit_m {
        depth_m += TAP_M;
        keep_awake(board);
        let started = board.clock_counts();
        patch.tap(depth_m);
        longest_counts = longest_counts.max(board.clock_counts().wrapping_sub(started));
    }
    patch.rest();
    let period_counts = board.about().clock_hz / PERIODS_PER_S;
    haptic.rehearsed(longest_counts, period_counts);
}

/// Feeds the watchdog while the pins show that the outputs are off.
fn keep_awake(board: &mut impl Board) {
    if board.outputs() == Outputs::OFF {
        board.feed_watchdog();
    }
}

/// Runs ticks with one patch until the host requests a change of it; `None` when the host has gone.
async fn serve<B: Board>(
    haptic: &mut HapticLoop<B>,
    tissue: &mut PatchSlot<'_>,
    mut upload: Option<&mut Upload>,
    inbox: &mut Inbox,
    line: &mut Line,
    pace: Pace,
) -> Option<Change> {
    let failed = Sensed { position_m: palpate::Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
    let mut newest = Reading::Tip(failed);
    let mut silent_ticks = 0_u32;
    loop {
        loop {
            let Some(byte) = line.byte(&mut haptic.board) else {
                if pace == Pace::LockStep {
                    haptic.board.outputs_off();
                    return None;
                }
                break;
            };
            if !line.receiver.collect(byte) {
                continue;
            }
            let Some(reply) = replied(&mut line.receiver, inbox, &mut haptic.controller, upload.as_deref_mut()) else { continue };
            match reply {
                Reply::Tick if pace == Pace::LockStep => break,
                Reply::None | Reply::Tick => {}
                Reply::Listen(asked) => (line.asked, line.listens_ticks) = (asked, if asked { LISTENS_TICKS } else { 0 }),
                Reply::Refused(refusal) => line.refuse(&mut haptic.board, refusal),
                Reply::Change(change) => {
                    haptic.end_commissioning();
                    return Some(change);
                }
                Reply::Modulus(pascal) => match tissue.ask_modulus(pascal, haptic.controller.stiffness_ceiling_n_per_m()) {
                    Ok(()) => line.send(&mut haptic.board, &FromBoard::Modulus(pascal)),
                    Err(refusal) => line.refuse(&mut haptic.board, refusal),
                },
                Reply::Store => match inbox.profile().map(|profile| store(haptic, tissue, profile)) {
                    Some(Ok(generation)) => stored(haptic, line, generation),
                    Some(Err(refusal)) => line.refuse(&mut haptic.board, refusal),
                    None => {}
                },
                Reply::Commission(setup) => haptic.commission(&setup, newest),
                Reply::Confirm => {
                    if let Some(bench) = haptic.bench() {
                        bench.confirm();
                    }
                }
                Reply::Home => {
                    if haptic.controller.show_home(&newest) {
                        haptic.board.log(Event::Homed);
                        line.send(&mut haptic.board, &FromBoard::Homed);
                    } else {
                        line.refuse(&mut haptic.board, Refusal::NoEncoders);
                    }
                }
                // scanning the stack takes a third of a tick, so neither is done while a force is
                // allowed
                Reply::Report | Reply::Identify if pace == Pace::Timed && haptic.controller.mode().allows_force() => {
                    line.refuse(&mut haptic.board, Refusal::NotIdle);
                }
                Reply::Report => report(tissue, haptic, line),
                Reply::Identify => identify(tissue, haptic, line),
            }
        }
        // the link was read before the period begins, so that the time at which the force is
        // written does not depend on its traffic
        let period = match pace {
            Pace::Timed => Some(haptic.board.next_period().await),
            Pace::LockStep => None,
        };
        let (reading, command) = inbox.clear();
        silent_ticks = if command.heard { 0 } else { silent_ticks.saturating_add(1) };
        if silent_ticks == FORGET_TICKS {
            line.receiver.forget();
        }
        newest = haptic.board.sense().or(reading).unwrap_or(newest);
        let record = haptic.tick(tissue, newest, command, period);
        // only after the force has been written, since recomputing the masses of 57 nodes takes
        // 4500 instructions, of 146 nodes 9200
        tissue.settle(haptic.controller.in_contact());
        if pace == Pace::LockStep || record.tick.is_multiple_of(RECORD_TICKS) {
            line.send(&mut haptic.board, &FromBoard::Record(record));
            tell(haptic, line);
        }
        let log_is_due = record.tick % LOG_TICKS == LOG_AT;
        while let Some(event) = line.told.next(haptic.seen(), log_is_due) {
            haptic.board.log(event);
        }
        if pace == Pace::Timed && log_is_due {
            line.send_log(&mut haptic.board);
        }
        line.listens_ticks = line.listens_ticks.saturating_sub(1);
    }
}

/// Stores a profile, restarts the controller with it and returns its generation number: 0 on a
/// board that cannot store it and uses it until power-off. A profile whose device does not render
/// the patch is not stored.
// not inlined into the loop, whose stack frame exists during every tick
#[inline(never)]
fn store<B: Board>(haptic: &mut HapticLoop<B>, tissue: &mut PatchSlot<'_>, profile: &Profile) -> Result<u32, Refusal> {
    haptic.end_commissioning();
    profile.check().map_err(StoreError::Profile)?;
    let (settings, edge) = profile.split();
    tissue.check_contact(edge.limits().ceiling_n_per_m(TICK_S), &mut || keep_awake(&mut haptic.board))?;
    let generation = match haptic.board.store_profile(profile) {
        Err(StoreError::Flash) => 0,
        kept => kept.map_err(Refusal::from)?,
    };
    haptic.controller.restart(&settings, edge).map_err(|_| Refusal::ProfileRange)?;
    Ok(generation)
}

#[inline(never)]
fn stored(haptic: &mut HapticLoop<impl Board>, line: &mut Line, generation: u32) {
    haptic.board.log(Event::Profile(generation));
    line.send(&mut haptic.board, &FromBoard::Stored(generation));
}

/// Sends the step of a commissioning, and its result once it is complete.
#[inline(never)]
fn tell<B: Board>(haptic: &mut HapticLoop<B>, line: &mut Line) {
    let Some((progress, result)) = haptic.bench().map(|bench| bench.told()) else { return };
    line.send(&mut haptic.board, &FromBoard::Commissioning(progress));
    if let Some(result) = result {
        line.send(&mut haptic.board, &FromBoard::Commissioned(result));
    }
}

fn report<B: Board>(tissue: &PatchSlot<'_>, haptic: &mut HapticLoop<B>, line: &mut Line) {
    let (nodes, state_hash) = tissue.state();
    let EnergyBound { at_once_j, lasting_w } = haptic.controller.energy_bound();
    let state = FromBoard::State {
        state_hash,
        stack_used_bytes: haptic.board.stack_used_bytes() as u32,
        bad_frames: line.receiver.counts().bad,
        nodes: nodes as u32,
        at_once_j,
        lasting_w,
        commissioned: haptic.controller.commissioned(),
    };
    line.send(&mut haptic.board, &state);
    if let Some(crash) = haptic.board.last_crash() {
        line.send(&mut haptic.board, &FromBoard::Crashed(crash));
    }
}

fn identify<B: Board>(tissue: &PatchSlot<'_>, haptic: &mut HapticLoop<B>, line: &mut Line) {
    let identity = Identity::new(&haptic.board.about(), tissue.identity(), haptic.longest_counts());
    line.send(&mut haptic.board, &FromBoard::Identity(identity));
}
