//! Records that cross the boundary, in SI; vectors are x, y, z in the scene's frame.

use palpate::haptic::commission::Stage;
use palpate::haptic::cycle::Telemetry;
use palpate::haptic::mode::Mode;
use palpate::{ContactMap, Output, Vector3};
use palpate_loop::haptic_session::{HapticSession, Input};

use crate::code::Failure;

/// Operating mode. A force may act in `PALPATE_MODE_ACTIVE`, `PALPATE_MODE_DEGRADED` and, while it
/// falls, in `PALPATE_MODE_SAFE_RAMP`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum PalpateMode {
    /// Before the first tick.
    Boot = 0,
    /// The first tick.
    SelfTest = 1,
    /// Waits for `palpate_arm`.
    Idle = 2,
    /// Waits for a calm probe outside the tissue.
    Arming = 3,
    /// The force acts.
    Active = 4,
    /// The force acts, scaled down for the rest of this contact.
    Degraded = 5,
    /// The force is being ramped down to zero.
    SafeRamp = 6,
    /// No force until `palpate_clear`.
    Fault = 7,
}

impl From<Mode> for PalpateMode {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Boot => Self::Boot,
            Mode::SelfTest => Self::SelfTest,
            Mode::Idle => Self::Idle,
            Mode::Arming => Self::Arming,
            Mode::Active => Self::Active,
            Mode::Degraded => Self::Degraded,
            Mode::SafeRamp => Self::SafeRamp,
            Mode::Fault => Self::Fault,
        }
    }
}

/// Step of a commissioning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum PalpateStage {
    /// Waits for the user to hold the handle still before a motion along an axis.
    Start = 0,
    /// Waits for the user to move the handle along that axis.
    Move = 1,
    /// Waits for the user to let the handle go.
    LetGo = 2,
    /// Measures, hand off.
    Drive = 3,
    /// The profile of the session is the measured one.
    Done = 4,
    /// It ended without a result.
    Stopped = 5,
}

impl PalpateStage {
    pub(crate) fn of(stage: Stage) -> Self {
        match stage {
            Stage::Start(_) => Self::Start,
            Stage::Move(_) => Self::Move,
            Stage::LetGo => Self::LetGo,
            Stage::Drive(_) => Self::Drive,
            Stage::Done => Self::Done,
            Stage::Stopped(_) => Self::Stopped,
        }
    }
}

/// Input of `palpate_tick_with`. If every field but the position is zero, the reading is new, good
/// and on time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PalpateInput {
    /// Tip of the probe [m].
    pub tip_m: [f64; 3],
    /// Number of periods of 1 ms that passed without a tick since the last tick.
    pub late_ticks: u32,
    /// Not zero if the position is an old one, because no new reading has arrived.
    pub stale: u8,
    /// Not zero if the device reports that its reading cannot be trusted.
    pub sensor_failed: u8,
    /// Not zero if the hand switch is released: there is then no force and no arming.
    pub operator_absent: u8,
    /// Reserved; set it to zero.
    pub reserved: u8,
}

impl PalpateInput {
    /// Converts the input to the core's precision.
    pub(crate) fn to_core(self) -> Input {
        Input {
            stale: self.stale != 0,
            sensor_failed: self.sensor_failed != 0,
            operator_absent: self.operator_absent != 0,
            late_ticks: u16::try_from(self.late_ticks).unwrap_or(u16::MAX),
            ..Input::at(Vector3::from(self.tip_m).cast())
        }
    }
}

/// Record of the last tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PalpateReport {
    /// Tip that was rendered [m]; the last good one on a fault.
    pub tip_m: [f64; 3],
    /// Force on the device [N].
    pub force_n: [f64; 3],
    /// Force of the tissue before damping, gains and limits [N].
    pub tissue_n: [f64; 3],
    /// Outward unit normal of the contact; zero without contact.
    pub normal: [f64; 3],
    /// Depth of the tip below the undeformed surface, along the normal [m]; zero without contact.
    pub depth_m: f64,
    /// Energy given to the hand since the touch [J]; negative while the tissue stores energy.
    pub given_j: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Requested increase of Young's modulus that waits until the probe does not touch [Pa]; zero
    /// if there is none.
    pub waiting_modulus_pa: f64,
    /// Number of ticks begun; it wraps.
    pub ticks: u32,
    /// Operating mode, a value of `palpate_mode`.
    pub mode: i32,
    /// Number of the latched fault, for `palpate_fault_text`; zero if there is none.
    pub fault: i32,
    /// Sum of the limits that acted: 1 speed, 2 depth, 4 force, 8 started inside the tissue, 16
    /// slew, 32 held reading, 64 gain, 128 energy.
    pub limiters: u32,
    /// 1 while the probe touches the tissue.
    pub contact: u8,
    /// 1 if the tick refused a request that came too early, or that the mode does not accept.
    pub refused: u8,
    /// Reserved; always zero.
    pub reserved: [u8; 6],
}

impl PalpateReport {
    /// Copies the last tick of a session.
    pub(crate) fn of(session: &HapticSession) -> Result<Self, Failure> {
        let Telemetry { tick, mode, fault, position_m, output, applied_n, energy, limiters, refused, .. } =
            session.telemetry().ok_or(Failure::NoTick)?;
        let Output { force_n, depth_m, normal, .. } = output;
        Ok(Self {
            tip_m: wide(position_m),
            force_n: wide(applied_n),
            tissue_n: wide(force_n),
            normal: wide(normal),
            depth_m: f64::from(*depth_m),
            given_j: f64::from(energy.given_j),
            youngs_modulus_pa: f64::from(session.tissue().params().youngs_modulus_pa),
            waiting_modulus_pa: f64::from(session.waiting_modulus_pa().unwrap_or(0.0)),
            ticks: *tick,
            mode: PalpateMode::from(*mode) as i32,
            fault: fault.map_or(0, |fault| i32::from(fault as u8)),
            limiters: u32::from(limiters.bits()),
            contact: u8::from(*normal != Vector3::zeros()),
            refused: u8::from(*refused),
            reserved: [0; 6],
        })
    }
}

/// Contact of the tissue with the probe after the last tick, for `palpate_read_contact`. All is
/// zero without contact, after a fault, and for a law, which has no surface.
///
/// Forces and torque are those that the tissue exerts on the probe, before damping, gains and
/// limits of the loop. The wrench on the probe is the force `normal_n + friction_n` and the torque
/// `torque_nm`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PalpateContact {
    /// Normal force [N]; it points out of the tissue.
    pub normal_n: [f64; 3],
    /// Friction force [N]; it acts along the surface.
    pub friction_n: [f64; 3],
    /// Torque of both forces about the probe's tip [N m], right-handed.
    pub torque_nm: [f64; 3],
    /// Centre of pressure [m].
    pub centre_m: [f64; 3],
    /// Unit vectors along the principal axes of the contact area, the longer one first.
    pub axes: [[f64; 3]; 2],
    /// Semi-axes of the contact area along `axes` [m].
    pub half_lengths_m: [f64; 2],
    /// Contact area on the deformed surface [m^2].
    pub area_m2: f64,
    /// Largest of the mean pressures on single surface triangles [Pa].
    pub peak_pressure_pa: f64,
    /// Number of surface triangles that push.
    pub triangles: u32,
    /// Reserved; always zero.
    pub reserved: u32,
}

impl PalpateContact {
    /// Copies a contact map.
    pub(crate) fn of(map: &ContactMap) -> Self {
        Self {
            normal_n: wide(&map.force_n),
            friction_n: wide(&map.friction_n),
            torque_nm: wide(&map.torque_nm),
            centre_m: wide(&map.centre_m),
            axes: map.axes.map(|axis| wide(&axis)),
            half_lengths_m: map.half_lengths_m.map(f64::from),
            area_m2: f64::from(map.area_m2),
            peak_pressure_pa: f64::from(map.peak_pressure_pa),
            triangles: u32::from(map.triangles),
            reserved: 0,
        }
    }
}

/// Tissue, probe and device of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PalpateInfo {
    /// Site of the press on the surface at rest [m]; add it to positions relative to your device's
    /// centre.
    pub site_m: [f64; 3],
    /// Unit vector that points out of the tissue at the site.
    pub axis: [f64; 3],
    /// Corner of the device's workspace with the smallest coordinates [m].
    pub workspace_low_m: [f64; 3],
    /// Corner of the device's workspace with the largest coordinates [m].
    pub workspace_high_m: [f64; 3],
    /// Radius of the probe [m].
    pub probe_radius_m: f64,
    /// Largest depth of the probe that is passed to the patch [m].
    pub depth_limit_m: f64,
    /// Maximum force of the loop [N].
    pub max_force_n: f64,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Number of nodes of the patch.
    pub nodes: u64,
    /// Number of surface triangles of the patch.
    pub triangles: u64,
}

impl PalpateInfo {
    /// Copies the properties of a session.
    pub(crate) fn of(session: &HapticSession) -> Self {
        let (tissue, device) = (session.tissue(), session.device());
        let (patch, params) = (tissue.patch(), tissue.params());
        let model = patch.model();
        Self {
            site_m: wide(&patch.site_m()),
            axis: wide(&params.probe.axis),
            workspace_low_m: wide(&device.workspace_low_m),
            workspace_high_m: wide(&device.workspace_high_m),
            probe_radius_m: f64::from(params.probe.radius_m),
            depth_limit_m: f64::from(model.depth_limit_m),
            max_force_n: f64::from(session.limits().max_force_n),
            youngs_modulus_pa: f64::from(params.youngs_modulus_pa),
            nodes: model.nodes.len() as u64,
            triangles: model.triangles.len() as u64,
        }
    }
}

/// A vector in double precision.
pub(crate) fn wide(v: &Vector3<f32>) -> [f64; 3] {
    v.cast::<f64>().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_the_core_s_numbers() {
        for mode in Mode::ALL {
            assert_eq!(PalpateMode::from(mode) as u8, mode as u8);
        }
    }
}
