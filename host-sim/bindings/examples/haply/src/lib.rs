//! Inverse3 through Haply's Inverse Service 3.5 and the `haply` crate. UNTESTED ON A DEVICE: it was
//! tested against a mock of the service's socket.

use std::error::Error;
use std::time::{Duration, Instant};

use haply::HaplyDevice;
use haply::device_model::{Force, ForceInput, Linear3D};
use palpate::{Fault, Vector3};
use palpate_loop::haptic_session::{HapticSession, Input};

/// Error of the service, or a sentence of ours.
pub type ServiceError = Box<dyn Error + Send + Sync>;

/// Height of the device's pose at the start above the site of the press [m].
pub const START_ABOVE_M: f32 = 0.02;

const TICK: Duration = Duration::from_millis(1);
/// Time after which a service that sends nothing counts as gone. Its last force is then held by the
/// device until the service lets it go.
pub const SILENCE: Duration = Duration::from_millis(100);
/// Ticks in which a force is ramped down.
const RAMP_TICKS: u32 = 200;

/// Runs the loop on the first Inverse3 of the service until `ends` is true or a fault is latched,
/// which is returned; the device's force is then zero. The service may send more than a thousand
/// frames per second: each tick takes the newest. `now` is the time since any instant; `silence` is
/// [`SILENCE`].
///
/// # Errors
/// The service has no Inverse3, falls silent, or refuses a command.
pub async fn run(
    device: &mut HaplyDevice,
    session: &mut HapticSession,
    now: impl FnMut() -> Duration,
    ends: impl FnMut() -> bool,
    silence: Duration,
) -> Result<Option<Fault>, ServiceError> {
    let mut seen = None;
    let (id, start) = newer(device, &mut seen, silence).await?;
    let site_m = session.tissue().patch().site_m() + Vector3::z() * START_ABOVE_M;
    session.arm()?;
    send(device, &id, Vector3::zeros()).await?; // the service sends states once it has a command
    let ended = ticks(device, session, (&id, start, site_m), &mut seen, now, ends, silence).await;
    if ended.is_err() {
        // the device would keep its last force; a service that is gone takes none
        let _gone = send(device, &id, Vector3::zeros()).await;
    }
    ended
}

/// Runs ticks until the end; `start` is the device's position at the start, and `site_m` the tip's.
async fn ticks(
    device: &mut HaplyDevice,
    session: &mut HapticSession,
    (id, start, site_m): (&str, Linear3D, Vector3<f32>),
    seen: &mut Option<Instant>,
    mut now: impl FnMut() -> Duration,
    mut ends: impl FnMut() -> bool,
    silence: Duration,
) -> Result<Option<Fault>, ServiceError> {
    let (mut due, mut ticks_left) = (now() + TICK, None);
    loop {
        let (_, position) = newer(device, seen, silence).await?;
        let late = now().checked_sub(due);
        let Some(late) = late else { continue };
        let late_ticks = u16::try_from(late.as_millis()).unwrap_or(u16::MAX);
        due += TICK * (u32::from(late_ticks) + 1);
        let tip_m = site_m + to_scene(position - start);
        let fault = session.tick(&Input { late_ticks, ..Input::at(tip_m) }).fault;
        send(device, id, session.drive_n()).await?; // zero on a fault
        ticks_left = match ticks_left {
            _ if fault.is_some() => return Ok(fault),
            Some(0) => return Ok(None),
            Some(left) => Some(left - 1),
            None if ends() => {
                session.stop();
                Some(RAMP_TICKS)
            }
            None => None,
        };
    }
}

/// Waits for a frame that is newer than the one seen last; returns the device and its position [m].
async fn newer(device: &HaplyDevice, seen: &mut Option<Instant>, silence: Duration) -> Result<(String, Linear3D), ServiceError> {
    let began = Instant::now();
    loop {
        let is_late = began.elapsed() > silence;
        {
            let state = device.state.lock().await;
            match state.data.inverse3.first() {
                None if is_late => return Err("the service has no Inverse3: plug it in".into()),
                Some(first) if *seen != Some(state.timestamp) => {
                    *seen = Some(state.timestamp);
                    let position = first.state.cursor_position.ok_or("the Inverse3 sends no position: calibrate it")?;
                    return Ok((first.device_id.clone(), position));
                }
                Some(_) if is_late => return Err("the service sends no more states: start it again".into()),
                _ => {}
            }
        }
        tokio::task::yield_now().await;
    }
}

async fn send(device: &mut HaplyDevice, id: &str, force_n: Vector3<f32>) -> Result<(), ServiceError> {
    let forces = vec![ForceInput { device_id: id.into(), forces: to_haply(force_n) }];
    device.update_force(forces, Some(true), Some(true)).await
}

/// From Haply's axes, x right, y away from the operator, z up, to the scene's.
fn to_scene(v: Linear3D) -> Vector3<f32> {
    Vector3::new(-v.y, v.x, v.z)
}

fn to_haply(v: Vector3<f32>) -> Force {
    Force { x: v.y, y: -v.x, z: v.z }
}
