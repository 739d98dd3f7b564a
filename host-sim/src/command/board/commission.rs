//! `palpate board commission`: the steps of the user and of the board, and the profile that
//! results.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use palpate::haptic::commission::{Commissioned, Plan, Stage};
use palpate::haptic::mode::Mode;
use palpate_controller::commission::Setup;
use palpate_controller::config::Profile;
use palpate_controller::link::{FromBoard, ToBoard};
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::commissioning::{self, DIRECTIONS, Signs, completed, write_whole};
use palpate_loop::day::today;
use palpate_tissue::Error as TissueError;

use super::hold::{ENDED, end_at_ctrl_c};
use super::{status, transfer};
use crate::command::options::board::Commission;
use crate::error::Error;
use crate::port::{PortError, Session, device_file};

/// Longest wait for a message before Ctrl-C and Enter are looked at.
const STEP: Duration = Duration::from_millis(20);
/// Names of the joints of a mechanism in sentences.
const JOINTS: [&str; 3] = [
    "at its tip by joint 1 alone, in the direction in which its angle grows",
    "at its tip by joint 2 alone, in the direction in which its angle grows",
    "at its tip by joint 3 alone, in the direction in which its angle grows",
];

impl Commission {
    pub(super) fn run(&self) -> Result<(), Error> {
        let out = self.target()?;
        let (device, profile) = device_file::load(&self.device)?;
        let setup = Setup::of(&profile.split().1, device.force_limit_n as f32, self.distance as f32);
        if !setup.sound() {
            let what = format!("--distance {} m: give one between 5mm and 0.5m", self.distance);
            return Err(TissueError::Usage(what).into());
        }
        end_at_ctrl_c()?;
        let entered = lines();
        self.port.with(|session| {
            let found = measure(session, &setup, profile.mechanism.is_some(), &entered)?;
            let text = measured(&device, &profile, &found)?;
            table(&found);
            write_whole(&out, &text)?;
            println!("wrote {}", out.display());
            let (device, profile) = device_file::load(&out.to_string_lossy())?;
            transfer::send_profile(&device, &profile, session)
        })
    }

    /// File that the profile is written to.
    fn target(&self) -> Result<PathBuf, Error> {
        match &self.out {
            Some(out) => Ok(out.clone()),
            None if PROFILES.iter().any(|(name, _)| *name == self.device) => Err(TissueError::Usage(format!(
                "--device {}: this profile ships with palpate; name the file for your device's with --out FILE.toml",
                self.device
            ))
            .into()),
            None => Ok(Path::new(&self.device).into()),
        }
    }
}

/// Lines of the standard input, one message each, until it ends.
fn lines() -> Receiver<()> {
    let (said, heard) = channel();
    std::thread::spawn(move || {
        let mut line = String::new();
        while std::io::stdin().read_line(&mut line).is_ok_and(|bytes| bytes > 0) && said.send(()).is_ok() {
            line.clear();
        }
    });
    heard
}

/// Runs the commissioning on the board; whatever ends it, the outputs are off.
fn measure(session: &mut Session, setup: &Setup, joints: bool, entered: &Receiver<()>) -> Result<Commissioned, Error> {
    if session.record.mode() != Some(Mode::Idle) {
        let what = format!("not commissioned: the board is not idle ({})", status::mode(&session.record));
        return Err(PortError::Undone { port: session.port().into(), what }.into());
    }
    session.keep_alive = true;
    session.send(&ToBoard::Commission(*setup))?;
    let outcome = follow(session, setup, if joints { JOINTS } else { DIRECTIONS }, entered);
    if outcome.is_err() && !matches!(outcome, Err(Error::Port(PortError::Lost { .. }))) {
        session.stop()?;
    }
    session.keep_alive = false;
    outcome
}

fn follow(session: &mut Session, setup: &Setup, names: [&str; 3], entered: &Receiver<()>) -> Result<Commissioned, Error> {
    let failed = |what: String| Error::from(TissueError::Check(what));
    let mut shown = None;
    // the first message of this commissioning is a start; one before may be of the last
    let mut begun = false;
    loop {
        if ENDED.load(Ordering::Relaxed) {
            return Err(failed("interrupted: the profile stays as it was".into()));
        }
        let message = session.next(STEP)?;
        match message {
            Some(FromBoard::Refused(refusal)) => {
                return Err(PortError::Refused { port: session.port().into(), refusal }.into());
            }
            Some(FromBoard::Commissioned(result)) if begun => return Ok(Commissioned::from(&result)),
            Some(FromBoard::Commissioning(progress)) => {
                let Some(stage) = progress.stage() else { continue };
                begun |= !stage.ended();
                if !begun || shown == Some(stage) {
                    continue;
                }
                let sentence = commissioning::sentence(stage, names, setup.distance_m);
                if let Stage::Stopped(_) = stage {
                    return Err(failed(sentence));
                }
                // an Enter of before the step is shown belongs to no step
                while entered.try_recv().is_ok() {}
                println!("{sentence}{}", if stage.asks() { " (Enter)" } else { "" });
                shown = Some(stage);
            }
            _ => {}
        }
        if shown.is_some_and(Stage::asks) {
            match entered.try_recv() {
                Ok(()) => session.send(&ToBoard::Confirm)?,
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    return Err(failed("interrupted, the input has ended: the profile stays as it was".into()));
                }
            }
        }
    }
}

/// The profile's text with what was found.
fn measured(device: &DeviceProfile, profile: &Profile, found: &Commissioned) -> Result<String, Error> {
    let Some(mechanism) = &profile.mechanism else { return Ok(completed(device, found, None, &today())?) };
    let (_, stated, _) = profile.split().1.joints();
    let joints = mechanism.kind.joints();
    for (joint, (m_per_count, stated)) in found.wiring.per_unit.into_iter().zip(stated).enumerate().take(joints) {
        let ratio = m_per_count.abs() / stated;
        if (ratio - 1.0).abs() > Plan::SAME_UNIT {
            return Err(TissueError::Check(format!(
                "joint {}: a count is {ratio:.3} times what the profile says: correct counts_per_turn or gear_ratio, and begin again; the profile stays as it was",
                joint + 1
            ))
            .into());
        }
    }
    let sign = |x: f32| if x < 0.0 { -1_i8 } else { 1 };
    let signs: Signs =
        [found.wiring.per_unit, found.wiring.motor_sign].map(|all| all.into_iter().take(joints).map(sign).collect());
    let mut ordered = *found;
    (ordered.wiring.per_unit, ordered.wiring.motor_sign) = ([1.0; 3], [1.0; 3]);
    Ok(completed(device, &ordered, Some(&signs), &today())?)
}

fn table(found: &Commissioned) {
    println!("axis  encoder  um per count  motor  sign  friction N  mass kg");
    for axis in 0..3 {
        if found.mass_kg[axis] > 0.0 {
            println!(
                "{:<4}  {:<7}  {:<12.3}  {:<5}  {:<4}  {:<10.3}  {:.3}",
                axis + 1,
                found.wiring.sensor[axis] + 1,
                found.wiring.per_unit[axis] * 1e6,
                found.wiring.motor[axis] + 1,
                found.wiring.motor_sign[axis],
                found.friction_n[axis],
                found.mass_kg[axis]
            );
        }
    }
    println!("delay {} ticks, lag {:.1} ms", found.delay_ticks, found.lag_s * 1e3);
}
