//! One run: arm outside, follow a stimulus, evaluate.

use palpate::haptic::cycle::{Command, Settings, Telemetry};
use palpate::haptic::device::HapticDevice;
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Fault, Vector3};

use super::device::DeviceProfile;
use super::hand::{Grip, Hand};
use super::plant::{Plant, PortEnergy};
use super::rig::{Beside, Rig};
use super::stimulus::{CLEAR_M, Stimulus, Trajectory};
use super::surface::Surface;
use super::verdict::{Hold, largest_turn_deg, rms_above};
use super::watch::Broken;

/// Force below which its direction is not evaluated [N].
const TURN_LEAST_N: f64 = 0.05;
/// Largest push of a released hand [N].
const RELEASED_PUSH_N: f64 = 0.5;

/// Device, hand, motion and settings of one run.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a> {
    /// Profile of the device.
    pub device: &'a DeviceProfile,
    /// Hand that holds the device.
    pub hand: Hand,
    /// Stimulus that the hand follows.
    pub stimulus: Stimulus,
    /// Settings of the controller.
    pub settings: Settings,
    /// Depth at which a press rests [m].
    pub depth_m: f64,
    /// Force of the tissue at that depth [N].
    pub static_n: f64,
}

/// One tick of a run.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Time from the start of the stimulus [s].
    pub t_s: f64,
    /// Position of the handle [m].
    pub at_m: Vector3<f64>,
    /// Target of the hand [m].
    pub target_m: Vector3<f64>,
    /// Force of the motors at the end of the tick [N].
    pub acting_n: Vector3<f64>,
    /// Energy at the port between device and hand.
    pub energy: PortEnergy,
    /// Telemetry of the loop.
    pub telemetry: Telemetry,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Run {
    /// One row per tick, from the start of the stimulus.
    pub rows: Vec<Row>,
    /// The final hold, if there is one.
    pub hold: Option<Hold>,
    /// Energy created by the worst contact, at the true port [J].
    pub created_j: f64,
    /// Force above 50 Hz while pressing slowly, RMS [N], if the stimulus is a slow press.
    pub buzz_n: Option<f64>,
    /// Force above 50 Hz in the hold, RMS [N].
    pub hold_buzz_n: f64,
    /// Force that the controller adds to the model's force at the end, relative to the model's
    /// force (1).
    pub static_error: f64,
    /// Largest rotation of the force in a tick [degrees], if the stimulus crosses edges.
    pub turn_deg: Option<f64>,
    /// Largest force [N].
    pub peak_n: f64,
    /// Invariants that were broken, each once.
    pub broken: Vec<Broken>,
    /// The fault that ended the run, if any.
    pub fault: Option<Fault>,
}

impl Run {
    /// Whether nothing is felt but the tissue.
    #[must_use]
    pub fn quiet(&self) -> bool {
        self.fault.is_none() && self.broken.is_empty() && !self.hold.is_some_and(|h| h.limit_cycle())
    }
}

/// Runs the loop once.
///
/// # Errors
/// Propagates errors from [`Cycle::build`].
pub fn run(setup: &Setup, surface: &mut impl Surface) -> Result<Run, BuildError> {
    run_beside(setup, surface, &mut ())
}

/// Runs the loop once, with a second controller.
///
/// # Errors
/// Propagates errors from [`Cycle::build`].
pub fn run_beside(setup: &Setup, surface: &mut impl Surface, beside: &mut impl Beside) -> Result<Run, BuildError> {
    let site = surface.site();
    let trajectory = trajectory_of(setup, surface);
    let start_m = site.point_m(-CLEAR_M, 0.0, 0.0);
    let mut plant = Plant::new(setup.device, setup.hand, site.at_m.cast(), site.normal.cast(), start_m);
    let mut rig = Rig::on(&setup.settings, &plant.limits(), surface)?;
    rig.arm(&mut plant, surface, beside, |_, plant| plant.rest());
    plant.set_velocity_m_per_s(-site.normal * trajectory.entry_m_per_s());

    let mut rows = Vec::with_capacity((trajectory.seconds() * 1e3) as usize + 1);
    let (mut t_s, mut ticks) = (0.0, 0_u32);
    while t_s < trajectory.seconds() {
        if let Some(change) = trajectory.change(t_s) {
            surface.change(change);
            beside.change(change);
        }
        let telemetry = rig.tick_beside(&mut plant, surface, Command::HEARD, beside, Surface::unsound);
        surface.settle(rig.cycle().in_contact());
        let aim = trajectory.aim(t_s);
        let touched = telemetry.output.depth_m > 0.0 || telemetry.applied_n != Vector3::zeros();
        plant.step(&aim, touched);
        rig.acted(&plant.truth());
        rows.push(Row {
            t_s,
            at_m: plant.at_m(),
            target_m: aim.at_m,
            acting_n: plant.acting_n(),
            energy: plant.energy(),
            telemetry,
        });
        if telemetry.mode == Mode::Fault {
            break;
        }
        ticks += 1;
        t_s = f64::from(ticks) * 1e-3;
    }
    Ok(judge(setup, &trajectory, surface.creeps(), rows, rig.broken().iter().map(|(broken, _)| *broken).collect()))
}

/// Builds the trajectory of a stimulus for this hand on this surface.
#[must_use]
pub fn trajectory_of(setup: &Setup, surface: &impl Surface) -> Trajectory {
    let push_n = if setup.hand.grip == Grip::Released { setup.static_n.min(RELEASED_PUSH_N) } else { 0.0 };
    Trajectory {
        stimulus: setup.stimulus,
        site: surface.site(),
        depth_m: setup.depth_m,
        reach_m: setup.hand.reach_m(setup.static_n),
        push_n,
    }
}

fn judge(setup: &Setup, trajectory: &Trajectory, creeps: bool, rows: Vec<Row>, broken: Vec<Broken>) -> Run {
    let at_m: Vec<Vector3<f64>> = rows.iter().map(|r| r.at_m).collect();
    let force_n: Vec<Vector3<f64>> = rows.iter().map(|r| r.telemetry.applied_n.cast()).collect();
    let ends = setup.stimulus.ends_in_hold();
    let fault = rows.last().and_then(|r| r.telemetry.fault);
    let held_from = rows.len().saturating_sub(super::verdict::JUDGED);
    // the press lasts from the first touch until the hand stops
    let pressing = || {
        let from = rows.iter().position(|r| r.telemetry.output.depth_m > 0.3e-3)?;
        let stop_s = trajectory.seconds() - super::stimulus::HOLD_S - 0.5;
        let to = rows.iter().position(|r| r.t_s >= stop_s)?;
        (to > from + 50).then(|| rms_above(force_n.get(..to).unwrap_or_default(), 50.0, from))
    };
    let static_error = rows.last().map_or(0.0, |r| {
        let model_n = r.telemetry.output.force_n;
        if model_n.norm() > 0.0 { f64::from((r.telemetry.applied_n - model_n).norm() / model_n.norm()) } else { 0.0 }
    });
    Run {
        hold: ends.then(|| Hold::judge(&at_m, &force_n, setup.device.count_m, creeps)),
        created_j: rows.last().map_or(0.0, |r| r.energy.worst_j),
        buzz_n: if setup.stimulus.is_slow_press() { pressing() } else { None },
        hold_buzz_n: if ends { rms_above(&force_n, 50.0, held_from) } else { 0.0 },
        static_error,
        turn_deg: setup.stimulus.crosses_edges().then(|| largest_turn_deg(&force_n, TURN_LEAST_N)),
        peak_n: force_n.iter().map(|f| f.norm()).fold(0.0, f64::max),
        broken,
        fault,
        rows,
    }
}
