//! Input of a cycle from the host, and its telemetry.

use nalgebra::Vector3;

use crate::fault::{ClampFlags, Fault};
use crate::haptic::account::Energy;
use crate::haptic::mode::Mode;
use crate::stages::output::Output;

/// Request of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Memory, clock and patch are ready: start the self-test.
    Booted,
    /// The board's self-test passed.
    TestPassed,
    /// Arm: allow a force.
    Arm,
    /// Stop: end the force and disarm.
    Stop,
    /// Clear the latched fault.
    Clear,
}

/// Messages of the host and findings of the board since the last cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Command {
    /// The host sent a keep-alive. A loop without a host sets this in every cycle.
    pub heard: bool,
    /// The request, if any.
    pub asked: Option<Ask>,
    /// Fault found by the board: the supply, the self-test, a tick that never ended.
    pub found: Option<Fault>,
    /// Periods that passed without a new force since the last cycle: 0 if this one is in time.
    pub late_ticks: u16,
    /// The hand switch is open or the pedal is up: no force, and no arming. It stays false on a
    /// board whose profile names no such switch.
    pub operator_absent: bool,
}

impl Command {
    /// A keep-alive without a request.
    pub const HEARD: Self = Self { heard: true, asked: None, found: None, late_ticks: 0, operator_absent: false };
}

/// Telemetry of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Telemetry {
    /// Number of cycles begun (wraps).
    pub tick: u32,
    /// Mode at the end of the cycle.
    pub mode: Mode,
    /// Fault that is latched until the host clears it.
    pub fault: Option<Fault>,
    /// Tip that was rendered [m]; the last good one on a fault.
    pub position_m: Vector3<f32>,
    /// Output of the renderer; [`Output::NONE`] where it did not run.
    pub output: Output,
    /// Force with damping, before gains and limits [N].
    pub wanted_n: Vector3<f32>,
    /// Force on the device [N].
    pub applied_n: Vector3<f32>,
    /// Energy given to the hand, up to this tick's pose.
    pub energy: Energy,
    /// Quantities that were limited, by the patch's guard and by the loop.
    pub limiters: ClampFlags,
    /// A request was made that the mode does not accept, or does not accept yet.
    pub refused: bool,
}

impl Telemetry {
    /// Telemetry at the start of a tick: a request counts as refused until it is followed.
    pub(super) fn begin(tick: u32, mode: Mode, command: Command) -> Self {
        Self {
            tick,
            mode,
            fault: None,
            position_m: Vector3::zeros(),
            output: Output::NONE,
            wanted_n: Vector3::zeros(),
            applied_n: Vector3::zeros(),
            energy: Energy::default(),
            limiters: ClampFlags::default(),
            refused: command.asked.is_some(),
        }
    }
}
