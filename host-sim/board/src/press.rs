//! The scene's finger presses the emulated board; the result is a [`Press`] like that of the
//! desktop.
//!
//! The finger feels the force that the device applies, which includes the cycle's damping and
//! limits. Times are exact numbers of the board's instructions, converted into microseconds with
//! the mean number of cycles per instruction: an estimate, not hardware timing.

use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Output, Vector3};
use palpate_controller::link::Record;

use super::twin::Reading;
use super::{EmulateError, EmulatedBoard, Lockstep};
use palpate_tissue::finger::Finger;
use palpate_tissue::press::{Press, SETTLE_S, TickRow, clear_m, hold};
use palpate_tissue::scene::Scene;
use palpate_tissue::scene::TICK_S;
use palpate_tissue::session::Session;

/// Mean number of cycles per instruction of the tick on a Cortex-M4F, by the reference manual's
/// table for the logged mix (`emulate --timing` measures it).
pub const CYCLES_PER_INSTRUCTION: f64 = 1.45;

/// Estimated time of this many instructions [us].
#[must_use]
pub fn estimated_us(instructions: u64, machine: EmulatedBoard) -> f32 {
    (instructions as f64 * CYCLES_PER_INSTRUCTION / machine.clock_hz() * 1e6) as f32
}

/// Runs a scene on a twin, which is armed `clear_m` above the surface.
///
/// # Errors
/// The board has crashed.
pub fn run(
    scene: &Scene,
    session: &Session,
    twin: &mut Lockstep<'_>,
    mut progress: impl FnMut(usize),
) -> Result<Press, EmulateError> {
    let clear_m = clear_m(scene, session);
    twin.arm(device_m(-clear_m))?;
    twin.instructions.clear();
    let mut finger = Finger::new(&scene.drive, clear_m, TICK_S, SETTLE_S);
    let mut recorded = session.tips_m.iter();
    let targets = scene.drive.targets();
    let mut press = Press::empty(twin.machine().timed_on().into());
    let mut force_n = 0.0;
    loop {
        let (position_m, hold_ends) = match &mut finger {
            Some(finger) => match finger.next(force_n) {
                Some(step) => (device_m(step.depth_m), step.hold_ends),
                None => break,
            },
            None => match recorded.next() {
                Some(tip_m) => (twin.patch().placement().to_device((*tip_m).into()), None),
                None => break,
            },
        };
        let record = twin.tick(Reading::at(position_m), None)?;
        force_n = f64::from(record.applied_n[2]);
        let row = row(&record, twin, position_m, press.ticks.len());
        press.deadline_misses += usize::from(row.tick_us > 1e3);
        press.limiters.set(row.output.limiters);
        press.ticks.push(row);
        press.fault = record.fault();
        if let Some(n) = hold_ends {
            press.holds.push(hold(twin.patch().model(), &session.params.probe, twin.patch().state(), targets[n], force_n, &row));
        }
        progress(press.ticks.len());
        if record.mode() == Some(Mode::Fault) {
            break;
        }
    }
    press.residual_m = palpate_tissue::measure::largest_displacement_m(twin.patch().model(), twin.patch().state());
    press.state_hash = twin.state_hash()?.0;
    Ok(press)
}

/// Position of a tip at a depth, in the device's frame: the site is at its centre, and the press
/// moves along -z.
fn device_m(depth_m: f64) -> Vector3<f32> {
    Vector3::new(0.0, 0.0, -depth_m as f32)
}

/// Converts a record to a row of `press`: forces and positions are in the patch's frame, and the
/// force is the one that the device applied.
fn row(record: &Record, twin: &Lockstep<'_>, position_m: Vector3<f32>, n: usize) -> TickRow {
    let placement = twin.patch().placement();
    let instructions = twin.instructions.last().copied().unwrap_or(0);
    TickRow {
        t_s: n as f64 * TICK_S,
        tip_m: placement.to_patch(position_m),
        command_m: f64::from(-position_m.z),
        output: Output {
            force_n: placement.turn_to_patch(record.applied_n.into()),
            depth_m: record.depth_m,
            point_m: placement.to_patch(record.point_m.into()),
            normal: placement.turn_to_patch(record.normal.into()),
            active_nodes: record.active_nodes,
            limiters: limiters(record.patch_limiters),
            fault: record.fault(),
            ..Output::NONE
        },
        tick_us: estimated_us(instructions, twin.machine()),
    }
}

/// The patch's limiters, unpacked from their byte.
fn limiters(bits: u8) -> ClampFlags {
    let mut set = ClampFlags::DEFAULT;
    for flag in [ClampFlags::SPEED, ClampFlags::DEPTH, ClampFlags::FORCE, ClampFlags::BURIED] {
        if bits & flag.bits() != 0 {
            set.set(flag);
        }
    }
    set
}
