//! Repeats a trace with the same core and says where the first bit differs.

use palpate::haptic::cycle::{Command, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::{Params, PatchFile, Vector3};

use super::tissue::LiveTissue;
use super::trace::{Piece, Trace, digest};
use crate::closed_loop::rig::Rig;
use crate::closed_loop::watch::Broken;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;

/// Result of a replay.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Telemetry of every tick, as computed here.
    pub telemetry: Vec<Telemetry>,
    /// Hash of all nodes at the end.
    pub hash: u64,
    /// The first difference: its tick and quantity.
    pub differs: Option<(u32, &'static str)>,
    /// Invariants of the loop that a tick broke, each once, with its tick.
    pub broken: Vec<(Broken, u32)>,
}

/// A second controller with the same inputs.
pub trait Witness {
    /// Changes Young's modulus after the next tick [Pa]: a board recomputes its masses after the
    /// force is output.
    fn retuned(&mut self, youngs_modulus_pa: f32);

    /// Called once per tick with what was read, asked, reported and applied to the device [N]; a
    /// force of `None` is its release.
    fn tick(&mut self, reading: Sensed, command: Command, telemetry: &Telemetry, got_n: Option<Vector3<f32>>);
}

/// Without a witness the calls have no effect.
impl Witness for () {
    fn retuned(&mut self, _: f32) {}

    fn tick(&mut self, _: Sensed, _: Command, _: &Telemetry, _: Option<Vector3<f32>>) {}
}

/// Replays a trace. The replay continues after a difference, so that the rest can be drawn.
///
/// # Errors
/// A patch or settings that the core refuses.
pub fn replay(trace: &Trace) -> Result<Replayed, Error> {
    replay_beside(trace, &mut ())
}

/// Replays a trace as [`replay`] does, with a witness.
///
/// # Errors
/// Errors of [`replay`].
pub fn replay_beside(trace: &Trace, witness: &mut impl Witness) -> Result<Replayed, Error> {
    let mut rig = Rig::build(&trace.settings, &trace.device)?;
    let mut device = Replay { limits: trace.device, reading: UNREAD };
    let mut tissue: Option<LiveTissue> = None;
    let mut telemetry = Vec::with_capacity(trace.ticks as usize);
    let mut replayed = Replayed { telemetry: Vec::new(), hash: 0, differs: None, broken: Vec::new() };
    for (n, piece) in trace.pieces.iter().enumerate() {
        match piece {
            Piece::Tissue(bytes) => {
                let unpacked = unpack(bytes)?;
                rig = rig.over(unpacked.rest_shape());
                tissue = Some(unpacked);
            }
            Piece::Retuned([youngs_modulus_pa, node_damping_per_s]) => {
                let tissue = tissue.as_mut().ok_or(palpate::BuildError::Empty)?;
                let (youngs_modulus_pa, node_damping_per_s) = (*youngs_modulus_pa, *node_damping_per_s);
                tissue.retune(Params { youngs_modulus_pa, node_damping_per_s, ..*tissue.params() })?;
            }
            Piece::Hash(expected) => {
                replayed.hash = tissue.as_mut().map_or(0, LiveTissue::hash);
                if replayed.hash != *expected && replayed.differs.is_none() {
                    replayed.differs = Some((telemetry.len() as u32, "the nodes"));
                }
            }
            Piece::Rows(rows) => {
                let tissue = tissue.as_mut().ok_or(palpate::BuildError::Empty)?;
                let coming = coming_pa(&trace.pieces[n + 1..]);
                for (k, row) in rows.iter().enumerate() {
                    if let (Some(pascal), true) = (coming, k + 1 == rows.len()) {
                        witness.retuned(pascal);
                    }
                    device.reading.position_m = row.position_m;
                    device.reading.sequence = device.reading.sequence.wrapping_add(1);
                    let now = rig.tick(&mut device, tissue, row.command);
                    let got_n = rig.last().and_then(|tick| tick.got_n);
                    witness.tick(device.reading, row.command, &now, got_n);
                    let same_force = now.applied_n.map(f32::to_bits) == row.applied_n.map(f32::to_bits);
                    if !same_force && replayed.differs.is_none() {
                        replayed.differs = Some((now.tick, "the force"));
                    }
                    if digest(&now) != row.digest && replayed.differs.is_none() {
                        replayed.differs = Some((now.tick, "what the loop told"));
                    }
                    telemetry.push(now);
                }
            }
        }
    }
    replayed.telemetry = telemetry;
    replayed.broken = rig.broken().to_vec();
    Ok(replayed)
}

/// Young's modulus of the next tick, if it changes [Pa].
fn coming_pa(pieces: &[Piece]) -> Option<f32> {
    let before = pieces.iter().take_while(|piece| !matches!(piece, Piece::Rows(_)));
    let retuned = before.filter_map(|piece| match piece {
        Piece::Retuned([youngs_modulus_pa, _]) => Some(*youngs_modulus_pa),
        _ => None,
    });
    retuned.last()
}

/// Copies bytes to a 4-byte boundary, where the core reads a patch in place.
pub fn aligned(bytes: &[u8]) -> Vec<u32> {
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
    words
}

/// Unpacks the tissue that a trace contains as a packed patch.
///
/// # Errors
/// A patch that the core refuses.
pub fn unpack(bytes: &[u8]) -> Result<LiveTissue, Error> {
    let words = aligned(bytes);
    let file = PatchFile::open(&bytemuck::cast_slice(&words)[..bytes.len()])?;
    file.model.check()?;
    Ok(LiveTissue::new(Patch::of_file(&file), file.params)?)
}

/// Reading before the first tick.
const UNREAD: Sensed = Sensed { position_m: Vector3::new(0.0, 0.0, 0.0), sequence: 0, status: SensorStatus::Good };

/// A device that repeats the recorded readings.
struct Replay {
    limits: DeviceSpec,
    reading: Sensed,
}

impl HapticDevice for Replay {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.reading
    }

    fn actuate(&mut self, _: Vector3<f32>) {}

    fn release(&mut self) {}
}

/// Telemetry of a replay as CSV, with one row per tick.
#[must_use]
pub fn table(replayed: &Replayed) -> String {
    use std::fmt::Write;
    let mut text = String::from("t_s,probe_x_m,probe_y_m,probe_z_m,depth_m,force_x_n,force_y_n,force_z_n,energy_given_j,mode\n");
    for (n, telemetry) in replayed.telemetry.iter().enumerate() {
        let (p, f) = (telemetry.position_m, telemetry.applied_n);
        let (depth_m, energy_j, mode) = (telemetry.output.depth_m, telemetry.energy.given_j, telemetry.mode);
        let t_s = n as f64 * palpate_tissue::scene::TICK_S;
        // writing to a string never fails
        let _taken = writeln!(text, "{t_s:.3},{},{},{},{depth_m},{},{},{},{energy_j},{mode:?}", p.x, p.y, p.z, f.x, f.y, f.z);
    }
    text
}
