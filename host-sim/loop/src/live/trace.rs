//! The trace of a recording: every input and every output of the cycle, to the bit.
//!
//! ```text
//! "PALPLIVE" version  ( kind length payload )*        little-endian
//!   S  scene, device, hand; settings of loop and device     T  patch file, parameters in it
//!   R  rows: reading, request, force, digest of the rest    E  Young's modulus, damping
//!   H  hash of all nodes                                    Z  ticks, FNV-1a of all before
//! ```
//!
//! The trace contains the patch itself: if it were built again on another machine, its last bits
//! could differ.

use std::fmt;

use palpate::haptic::account::AccountSettings;
use palpate::haptic::cycle::{ArmingSettings, Ask, Command, Settings, Telemetry};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::device::{DeviceSpec, Sensed};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::{Fnv, Params, Vector3};
use serde::{Deserialize, Serialize};

use super::tissue::LiveTissue;

/// First bytes of every trace.
pub const MAGIC: [u8; 8] = *b"PALPLIVE";
/// Version written and read. Before version 2 a patch was put to rest within a tick, not in a
/// separate one; before version 3 the energy watch had no allowance, and before version 4 it was no
/// account.
pub const VERSION: u32 = 4;
/// Longest recording [ticks]: ten minutes, about 17 MB.
pub const MOST_TICKS: u32 = 600_000;
/// Length of a row [bytes].
const ROW: usize = 29;
/// Rows between two hashes of all nodes.
const HASHED_EVERY: u32 = 256;
/// Count of the numbers that describe settings and device.
const NUMBERS: usize = 38;

/// Description of a recording, in words.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Head {
    /// Name of the scene.
    pub scene: String,
    /// Name of the device profile.
    pub device: String,
    /// Name of the hand.
    pub hand: String,
}

/// Inputs and outputs of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Position that the device read [m].
    pub position_m: Vector3<f32>,
    /// Command to the loop.
    pub command: Command,
    /// Force on the device [N].
    pub applied_n: Vector3<f32>,
    /// Digest of everything else that the loop reported.
    pub digest: u32,
}

/// One piece of a trace, in order.
#[derive(Clone, Debug)]
pub enum Piece {
    /// A patch file.
    Tissue(Vec<u8>),
    /// Young's modulus [Pa], damping of the nodes [1/s].
    Retuned([f32; 2]),
    /// Ticks, one row each.
    Rows(Vec<Row>),
    /// Hash of all nodes at this point.
    Hash(u64),
}

/// A trace that was read.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Head of the trace, as text.
    pub head: Head,
    /// Settings of the loop.
    pub settings: Settings,
    /// Limits of the device.
    pub device: DeviceSpec,
    /// Recorded pieces, in order.
    pub pieces: Vec<Piece>,
    /// Total number of ticks.
    pub ticks: u32,
}

/// Why bytes are not a valid trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceError {
    /// The bytes do not begin as a trace does.
    NotATrace,
    /// The trace has another version of the format.
    Version(u32),
    /// The trace ends too early.
    Cut,
    /// The checksum of the trace does not match.
    Damaged,
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotATrace => write!(f, "not a live trace: give a file that `palpate live` recorded"),
            Self::Version(found) => {
                write!(
                    f,
                    "trace of version {found}, this program reads version {VERSION}: record it again, or take the program that wrote it"
                )
            }
            Self::Cut => write!(f, "the trace ends too early: copy the file again, whole"),
            Self::Damaged => write!(f, "the trace's checksum does not match: the file was changed, copy it again"),
        }
    }
}

impl std::error::Error for TraceError {}

/// Digest of everything that a tick reported besides the force, in 32 bits.
#[must_use]
pub fn digest(telemetry: &Telemetry) -> u32 {
    let o = &telemetry.output;
    let fault = telemetry.fault.map_or(0, |f| f as u8);
    let model_fault = o.fault.map_or(0, |f| f as u8);
    let mut bytes =
        vec![telemetry.mode as u8, fault, model_fault, telemetry.limiters.bits(), o.limiters.bits(), u8::from(telemetry.refused)];
    bytes.extend(telemetry.tick.to_le_bytes());
    bytes.extend(o.active_nodes.to_le_bytes());
    for v in [telemetry.position_m, o.force_n, o.point_m, o.normal, telemetry.wanted_n, telemetry.applied_n] {
        v.iter().for_each(|c| bytes.extend(c.to_bits().to_le_bytes()));
    }
    for c in [o.depth_m, telemetry.energy.given_j, telemetry.energy.created_j, telemetry.energy.balance_j] {
        bytes.extend(c.to_bits().to_le_bytes());
    }
    let hash = fnv(&bytes);
    (hash ^ (hash >> 32)) as u32
}

fn fnv(bytes: &[u8]) -> u64 {
    let mut hash = Fnv::default();
    hash.bytes(bytes);
    hash.finish()
}

/// Writes a trace, tick by tick.
#[derive(Clone, Debug)]
pub struct Recorder {
    bytes: Vec<u8>,
    rows: Vec<u8>,
    ticks: u32,
}

impl Recorder {
    /// Begins a trace, from the first tick of a loop on.
    #[must_use]
    pub fn new(head: &Head, settings: &Settings, device: &DeviceSpec, tissue: &LiveTissue) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        let mut recorder = Self { bytes, rows: Vec::new(), ticks: 0 };
        let mut start: Vec<u8> = numbers(settings, device).iter().flat_map(|n| n.to_le_bytes()).collect();
        start.extend(serde_json::to_vec(head).unwrap_or_default());
        recorder.piece(b'S', &start);
        recorder.piece(b'T', &tissue.patch().pack(tissue.params(), 0.0));
        recorder
    }

    /// Number of ticks so far.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Records that the tissue received other parameters.
    pub fn retuned(&mut self, params: &Params) {
        self.flush();
        let bytes: Vec<u8> = [params.youngs_modulus_pa, params.node_damping_per_s].iter().flat_map(|n| n.to_le_bytes()).collect();
        self.piece(b'E', &bytes);
    }

    /// Records a tick.
    pub fn row(&mut self, reading: &Sensed, command: &Command, telemetry: &Telemetry) {
        let asked = command.asked.map_or(0, |a| 1 + a as u8);
        for v in [reading.position_m, telemetry.applied_n] {
            v.iter().for_each(|c| self.rows.extend(c.to_le_bytes()));
        }
        self.rows.push(u8::from(command.heard) | asked << 1);
        self.rows.extend(digest(telemetry).to_le_bytes());
        self.ticks += 1;
    }

    /// Whether a hash of all nodes is due.
    #[must_use]
    pub fn hash_due(&self) -> bool {
        self.ticks.is_multiple_of(HASHED_EVERY)
    }

    /// Records the hash of all nodes at this point.
    pub fn hash(&mut self, hash: u64) {
        self.flush();
        self.piece(b'H', &hash.to_le_bytes());
    }

    /// Ends the trace with this hash of all nodes, and returns its bytes.
    #[must_use]
    pub fn finish(mut self, hash: u64) -> Vec<u8> {
        self.hash(hash);
        let mut end = self.ticks.to_le_bytes().to_vec();
        end.extend(fnv(&self.bytes).to_le_bytes());
        self.piece(b'Z', &end);
        self.bytes
    }

    fn flush(&mut self) {
        let rows = std::mem::take(&mut self.rows);
        if !rows.is_empty() {
            self.piece(b'R', &rows);
        }
    }

    fn piece(&mut self, kind: u8, payload: &[u8]) {
        self.bytes.push(kind);
        self.bytes.extend((payload.len() as u32).to_le_bytes());
        self.bytes.extend(payload);
    }
}

impl Trace {
    /// Reads a whole trace.
    ///
    /// # Errors
    /// The bytes are not a valid trace.
    pub fn read(bytes: &[u8]) -> Result<Self, TraceError> {
        let magic = bytes.get(..MAGIC.len()).ok_or(TraceError::NotATrace)?;
        if magic != MAGIC {
            return Err(TraceError::NotATrace);
        }
        let mut at = Bytes(bytes.get(MAGIC.len()..).unwrap_or_default());
        let version = at.number()?;
        if version != VERSION {
            return Err(TraceError::Version(version));
        }
        let (mut start, mut pieces, mut counted) = (None, Vec::new(), 0);
        loop {
            let before = bytes.len() - at.0.len();
            let kind = at.take(1)?.first().copied().unwrap_or_default();
            let length = at.number()? as usize;
            let mut payload = Bytes(at.take(length)?);
            match kind {
                b'S' => start = Some(read_start(&mut payload)?),
                b'T' => pieces.push(Piece::Tissue(payload.0.to_vec())),
                b'E' => pieces.push(Piece::Retuned([payload.float()?, payload.float()?])),
                b'H' => pieces.push(Piece::Hash(payload.long()?)),
                b'R' => {
                    let mut rows = Vec::with_capacity(payload.0.len() / ROW);
                    while !payload.0.is_empty() {
                        rows.push(read_row(&mut payload)?);
                    }
                    counted += rows.len();
                    pieces.push(Piece::Rows(rows));
                }
                b'Z' => {
                    let (ticks, sum) = (payload.number()?, payload.long()?);
                    let whole = at.0.is_empty() && counted == ticks as usize;
                    if !whole || sum != fnv(bytes.get(..before).unwrap_or_default()) {
                        return Err(TraceError::Damaged);
                    }
                    let (head, settings, device) = start.ok_or(TraceError::Damaged)?;
                    return Ok(Self { head, settings, device, pieces, ticks });
                }
                _ => return Err(TraceError::Damaged),
            }
        }
    }
}

fn read_start(payload: &mut Bytes) -> Result<(Head, Settings, DeviceSpec), TraceError> {
    let mut numbers = [0.0; NUMBERS];
    for number in &mut numbers {
        *number = payload.float()?;
    }
    let head = serde_json::from_slice(payload.0).map_err(|_| TraceError::Damaged)?;
    let (settings, device) = of_numbers(&numbers);
    Ok((head, settings, device))
}

fn read_row(payload: &mut Bytes) -> Result<Row, TraceError> {
    let position_m = payload.vector()?;
    let applied_n = payload.vector()?;
    let flags = payload.take(1)?.first().copied().unwrap_or_default();
    let asked = match flags >> 1 {
        0 => None,
        1 => Some(Ask::Booted),
        2 => Some(Ask::TestPassed),
        3 => Some(Ask::Arm),
        4 => Some(Ask::Stop),
        5 => Some(Ask::Clear),
        _ => return Err(TraceError::Damaged),
    };
    let command = Command { heard: flags & 1 == 1, asked, ..Command::default() };
    Ok(Row { position_m, command, applied_n, digest: payload.number()? })
}

/// Bytes left to read.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], TraceError> {
        let (taken, rest) = self.0.split_at_checked(length).ok_or(TraceError::Cut)?;
        self.0 = rest;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32, TraceError> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().map_err(|_| TraceError::Cut)?))
    }

    fn long(&mut self) -> Result<u64, TraceError> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into().map_err(|_| TraceError::Cut)?))
    }

    fn float(&mut self) -> Result<f32, TraceError> {
        Ok(f32::from_bits(self.number()?))
    }

    fn vector(&mut self) -> Result<Vector3<f32>, TraceError> {
        Ok(Vector3::new(self.float()?, self.float()?, self.float()?))
    }
}

/// Every number that determines a loop; counts are exact in single precision.
fn numbers(settings: &Settings, device: &DeviceSpec) -> [f32; NUMBERS] {
    let (l, d, p, a) = (&settings.limits, &settings.damping, &settings.account, &settings.arming);
    let [low, high] = [device.workspace_low_m, device.workspace_high_m];
    #[rustfmt::skip]
    let all = [
        settings.tick_s,
        l.max_force_n, l.max_slew_n_per_s, l.max_speed_m_per_s, l.odd_poses.into(), l.max_age_ticks.into(),
        l.workspace_margin, l.implausible_ratio, l.implausible_ticks.into(), l.saturated_ticks.into(),
        d.tau_s, d.constant_n_s_per_m, d.velocity_share,
        p.allowance_j, p.refill_w, p.acceleration_m_per_s2, p.handle_share,
        a.weak_n, a.slow_m_per_s, a.calm_ticks.into(), a.ramp_in_per_tick, a.relief_per_tick, a.least_relief,
        a.silence_ticks.into(), a.ramp_ticks.into(),
        device.max_force_n, low.x, low.y, low.z, high.x, high.y, high.z,
        device.count_m, device.delay_ticks.into(), device.lag_s,
        device.mass_kg, device.stiffness_ceiling_n_per_m, u8::from(device.commissioned).into(),
    ];
    all
}

/// Converts `numbers` back to settings and device limits. A number out of range is refused when the
/// cycle is built.
fn of_numbers(n: &[f32; NUMBERS]) -> (Settings, DeviceSpec) {
    let [
        tick_s,
        max_force_n,
        max_slew_n_per_s,
        max_speed_m_per_s,
        odd_poses,
        max_age_ticks,
        workspace_margin,
        implausible_ratio,
        implausible_ticks,
        saturated_ticks,
        tau_s,
        constant_n_s_per_m,
        velocity_share,
        allowance_j,
        refill_w,
        acceleration_m_per_s2,
        handle_share,
        weak_n,
        slow_m_per_s,
        calm_ticks,
        ramp_in_per_tick,
        relief_per_tick,
        least_relief,
        silence_ticks,
        ramp_ticks,
        device_force_n,
        x0,
        y0,
        z0,
        x1,
        y1,
        z1,
        count_m,
        delay_ticks,
        lag_s,
        mass_kg,
        stiffness_ceiling_n_per_m,
        commissioned,
    ] = *n;
    let settings = Settings {
        tick_s,
        limits: LoopLimitSettings {
            max_force_n,
            max_slew_n_per_s,
            max_speed_m_per_s,
            odd_poses: odd_poses as u16,
            max_age_ticks: max_age_ticks as u16,
            workspace_margin,
            implausible_ratio,
            implausible_ticks: implausible_ticks as u16,
            saturated_ticks: saturated_ticks as u16,
        },
        damping: DampingSettings { tau_s, constant_n_s_per_m, velocity_share },
        account: AccountSettings { allowance_j, refill_w, acceleration_m_per_s2, handle_share },
        arming: ArmingSettings {
            weak_n,
            slow_m_per_s,
            calm_ticks: calm_ticks as u16,
            ramp_in_per_tick,
            relief_per_tick,
            least_relief,
            silence_ticks: silence_ticks as u16,
            ramp_ticks: ramp_ticks as u16,
        },
    };
    let device = DeviceSpec {
        max_force_n: device_force_n,
        workspace_low_m: Vector3::new(x0, y0, z0),
        workspace_high_m: Vector3::new(x1, y1, z1),
        count_m,
        delay_ticks: delay_ticks as u8,
        lag_s,
        mass_kg,
        stiffness_ceiling_n_per_m,
        commissioned: commissioned != 0.0,
    };
    (settings, device)
}
