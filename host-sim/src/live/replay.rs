//! Repeats a trace with the same core and says where the first bit differs.

use palpate::haptic::cycle::{Cycle, Telemetry};
use palpate::haptic::device::{DeviceLimits, HapticDevice, Sensed, SensorStatus};
use palpate::{Params, PatchFile, Vector3};

use super::tissue::LiveTissue;
use super::trace::{Piece, Trace, digest};
use crate::error::Error;
use crate::patch::Patch;

/// What a replay showed.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// One a tick, as told here.
    pub told: Vec<Telemetry>,
    /// Hash of all nodes at the end.
    pub hash: u64,
    /// The first thing that differs: its tick, and what.
    pub differs: Option<(u32, &'static str)>,
}

/// Runs a trace again. It goes on after a difference, so that the rest can be drawn.
///
/// # Errors
/// A patch or settings that the core refuses.
pub fn replay(trace: &Trace) -> Result<Replayed, Error> {
    let mut cycle = Cycle::build(&trace.settings, &trace.device)?;
    let mut device = Replay { limits: trace.device, at_m: Vector3::zeros(), sequence: 0 };
    let mut tissue: Option<LiveTissue> = None;
    let mut told = Vec::with_capacity(trace.ticks as usize);
    let mut replayed = Replayed { told: Vec::new(), hash: 0, differs: None };
    for piece in &trace.pieces {
        match piece {
            Piece::Tissue(bytes) => tissue = Some(unpack(bytes)?),
            Piece::Retuned([youngs_modulus_pa, node_damping_per_s]) => {
                let tissue = tissue.as_mut().ok_or(palpate::BuildError::Empty)?;
                let (youngs_modulus_pa, node_damping_per_s) = (*youngs_modulus_pa, *node_damping_per_s);
                tissue.retune(Params { youngs_modulus_pa, node_damping_per_s, ..*tissue.params() })?;
            }
            Piece::Hash(expected) => {
                replayed.hash = tissue.as_mut().map_or(0, LiveTissue::hash);
                if replayed.hash != *expected && replayed.differs.is_none() {
                    replayed.differs = Some((told.len() as u32, "the nodes"));
                }
            }
            Piece::Rows(rows) => {
                let tissue = tissue.as_mut().ok_or(palpate::BuildError::Empty)?;
                for row in rows {
                    device.at_m = row.position_m;
                    let now = cycle.run(&mut device, tissue, row.command);
                    let same_force = now.applied_n.map(f32::to_bits) == row.applied_n.map(f32::to_bits);
                    if !same_force && replayed.differs.is_none() {
                        replayed.differs = Some((now.tick, "the force"));
                    }
                    if digest(&now) != row.digest && replayed.differs.is_none() {
                        replayed.differs = Some((now.tick, "what the loop told"));
                    }
                    told.push(now);
                }
            }
        }
    }
    replayed.told = told;
    Ok(replayed)
}

/// On a 4-byte boundary, where the core reads a patch in place.
fn unpack(bytes: &[u8]) -> Result<LiveTissue, Error> {
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
    let file = PatchFile::open(&bytemuck::cast_slice(&words)[..bytes.len()])?;
    file.model.check()?;
    Ok(LiveTissue::new(Patch::of_file(&file), file.params)?)
}

/// A device that reads what was read.
struct Replay {
    limits: DeviceLimits,
    at_m: Vector3<f32>,
    sequence: u32,
}

impl HapticDevice for Replay {
    fn limits(&self) -> DeviceLimits {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.sequence = self.sequence.wrapping_add(1);
        Sensed { position_m: self.at_m, sequence: self.sequence, status: SensorStatus::Good }
    }

    fn actuate(&mut self, _force_n: Vector3<f32>) {}

    fn release(&mut self) {}
}

/// One row a tick, as CSV.
#[must_use]
pub fn table(replayed: &Replayed) -> String {
    use std::fmt::Write;
    let mut text = String::from("t_s,probe_x_m,probe_y_m,probe_z_m,depth_m,force_x_n,force_y_n,force_z_n,energy_given_j,mode\n");
    for (n, told) in replayed.told.iter().enumerate() {
        let (p, f) = (told.position_m, told.applied_n);
        let (depth_m, energy_j, mode) = (told.output.depth_m, told.energy.given_j, told.mode);
        let t_s = n as f64 * crate::session::TICK_S;
        // a string takes every write
        let _taken = writeln!(text, "{t_s:.3},{},{},{},{depth_m},{},{},{},{energy_j},{mode:?}", p.x, p.y, p.z, f.x, f.y, f.z);
    }
    text
}
