//! Replay of a recording of `palpate live` on the emulated board.
//!
//! The patch of the trace is placed on the board with its site at the device's centre. If the patch
//! is pressed along z, the device's frame is then that of the trace, and every bit can be compared.
//! This machine replays the trace at the same time, and compares its replay with the recorded
//! values.
//!
//! * in: a trace
//! * out: this machine's replay, every tick of which the board answered with the same bits
//! * fails for a trace that a board cannot repeat (a board hears its host in every tick, and
//!   has one patch, with half to twice its stiffness), or with [`EmulateError::Differs`]

use std::path::{Path, PathBuf};

use palpate::haptic::cycle::{Ask, Command, Telemetry};
use palpate::haptic::device::Sensed;
use palpate::{BuildError, Params, Vector3};
use palpate_controller::config::Profile;
use palpate_controller::link::Refusal;

use super::in_loop::{There, started};
use super::{Board, EmulateError, EmulatedBoard, image};
use palpate_loop::closed_loop::rig::Beside;
use palpate_loop::live::replay::{Replayed, Witness, aligned, replay_beside, unpack};
use palpate_loop::live::trace::{Piece, Trace};
use palpate_tissue::stable_step::StableStep;

/// Longest patch that can be sent over the link [bytes]; longer ones are built into an image.
const LONGEST_UPLOAD: usize = 4 * palpate_controller::link::upload::UPLOAD_WORDS;
/// Requests that a board makes by itself in its first ticks.
const START_UP: [Ask; 2] = [Ask::Booted, Ask::TestPassed];

/// Repeats a trace on an emulated board, and builds an image if none is given.
///
/// # Errors
/// A trace that the board cannot repeat, or a tick in which board and desktop differ.
pub fn replay(trace: &Trace, given: Option<&Path>, machine: EmulatedBoard) -> Result<Replayed, EmulateError> {
    let (patch, params) = packed(trace)?;
    let (_folder, image, upload) = match given {
        Some(_) => (None, image::find(given)?, Some(&patch[..])),
        None if patch.len() <= LONGEST_UPLOAD => (None, image::build()?, Some(&patch[..])),
        None => {
            let (folder, image) = built_in(&patch)?;
            (Some(folder), image, None)
        }
    };
    let board = started(Board::start(&image, machine, None)?, upload, &trace.settings, &trace.device)?;
    let mut there = There::new(board, params.youngs_modulus_pa);
    let here = replay_beside(trace, &mut there)?;
    there.ended(here.hash)?;
    Ok(here)
}

/// Builds an image with the patch in its flash.
fn built_in(patch: &[u8]) -> Result<(tempfile::TempDir, PathBuf), EmulateError> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("trace.patch");
    std::fs::write(&path, patch)?;
    let image = image::build_with(Some(&path))?;
    Ok((folder, image))
}

/// Packs the trace's patch for a board.
fn packed(trace: &Trace) -> Result<(Vec<u8>, Params), EmulateError> {
    let refuse = |why: String| EmulateError::LiveTrace(why);
    let Some(Piece::Tissue(bytes)) = trace.pieces.first() else {
        return Err(refuse("it has no patch: record it again".into()));
    };
    let tissue = unpack(bytes)?;
    let (mut patch, params) = (tissue.patch().clone(), *tissue.params());
    let [settings, safe] = [trace.settings, Profile::of(&trace.settings, &trace.device).split().0];
    if settings != safe {
        return Err(refuse("settings of its loop are not a board's: record it again with this program".into()));
    }
    if params.probe.axis != Vector3::z() {
        return Err(refuse("its probe does not press along z, and a board turns it: record it on a block".into()));
    }
    let mut tick = 0;
    for piece in &trace.pieces[1..] {
        match piece {
            Piece::Tissue(_) => return Err(refuse("its patch changes on the way: record one patch at a time".into())),
            Piece::Retuned([youngs_modulus_pa, node_damping_per_s]) => {
                let ratio = youngs_modulus_pa / params.youngs_modulus_pa;
                if *node_damping_per_s != params.node_damping_per_s {
                    return Err(refuse(format!("tick {tick}: a board's damping does not change: record it with one damping")));
                }
                if !(0.5..=2.0).contains(&ratio) {
                    return Err(refuse(format!(
                        "tick {tick}: {ratio:.2} times as stiff, and a board goes from half to twice: change it less while it records"
                    )));
                }
            }
            Piece::Rows(rows) => {
                for row in rows {
                    let own = START_UP.get(tick);
                    if row.command.asked.as_ref().filter(|a| own.is_some() || START_UP.contains(a)) != own {
                        return Err(refuse(format!("tick {tick}: a board starts up by itself: record it again")));
                    }
                    if !row.command.heard {
                        return Err(refuse(format!(
                            "tick {tick}: nobody was heard, and in lock-step a board hears its host in every tick: keep the window awake"
                        )));
                    }
                    tick += 1;
                }
            }
            Piece::Hash(_) => {}
        }
    }
    patch.set_site_m([0.0; 3]);
    let stable = StableStep::measure(&patch.wide_model(), &params, tissue.patch().site_m())?;
    let stable = stable.ok_or(EmulateError::Refused(Refusal::PatchStep))?;
    let packed = patch.pack(&params, stable.pressed_s as f32);
    fits(&packed).map_err(|why| EmulateError::Refused(why.into()))?;
    Ok((packed, params))
}

/// Opens a patch as a board does, so that an unsuitable patch is refused here with a reason, and
/// not by a board that then stays idle.
///
/// # Errors
/// Returns the reason for which a board would refuse the patch.
pub fn fits(packed: &[u8]) -> Result<(), BuildError> {
    let words = aligned(packed);
    let mut memory = Box::new(palpate_controller::patch::Memory::RESERVED);
    palpate_controller::patch::Patch::open(&bytemuck::cast_slice(&words)[..packed.len()], &mut memory, None).map(|_| ())
}

impl Witness for There {
    fn retuned(&mut self, youngs_modulus_pa: f32) {
        self.modulus(youngs_modulus_pa);
    }

    fn tick(&mut self, reading: Sensed, command: Command, telemetry: &Telemetry, got_n: Option<Vector3<f32>>) {
        let _there_n = Beside::tick(self, Some(reading), command, telemetry, got_n);
    }
}
