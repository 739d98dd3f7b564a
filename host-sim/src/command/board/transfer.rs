//! The commands `palpate board upload`, `modulus`, `profile` and `ping`.

use std::path::Path;
use std::time::{Duration, Instant};

use palpate::PatchFile;
use palpate_controller::config::Profile;
use palpate_controller::link::{FromBoard, Refusal, ToBoard, upload};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_tissue::Error as TissueError;
use palpate_tissue::fit_record::FitRecord;

use crate::command::options::board::PortArgs;
use crate::error::Error;
use crate::port::session::SILENCE;
use crate::port::{PortError, Session, device_file};

/// Longest wait until a patch is opened, which takes a second for a large patch on a small board.
const OPENED: Duration = Duration::from_secs(5);
/// Longest wait for an answer: a new modulus opens the patch again, and a profile is written to
/// flash.
const ANSWER: Duration = Duration::from_secs(5);
/// Number of attempts to send a patch; a poor line loses pieces of it.
const SENDINGS: usize = 3;
/// Longest round trip of a message.
const ROUND_TRIP: Duration = Duration::from_secs(1);

pub(super) fn upload(path: &Path, port: &PortArgs) -> Result<(), Error> {
    let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.into(), source })?;
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut::<_, u8>(&mut words)[..bytes.len()].copy_from_slice(&bytes);
    let patch = &bytemuck::cast_slice::<_, u8>(&words)[..bytes.len()];
    // a damaged file is detected here, not after it has been sent for one second
    PatchFile::open(patch).map_err(|cause| TissueError::Patch { path: path.into(), cause })?;
    port.with(|session| send_patch(path, patch, session))
}

fn send_patch(path: &Path, patch: &[u8], session: &mut Session) -> Result<(), Error> {
    let begun = Instant::now();
    let mut nodes = Err(Refusal::PatchPieces);
    for _ in 0..SENDINGS {
        nodes = sent(session, patch)?;
        if nodes != Err(Refusal::PatchPieces) {
            break;
        }
    }
    let nodes = nodes.map_err(|refusal| PortError::Refused { port: session.port().into(), refusal })?;
    let seconds = begun.elapsed().as_secs_f64();
    session.identify()?;
    if Some(session.identity.patch_checksum) != PatchFile::checksum(patch) {
        let what = "the board took a patch and holds another one: send it again".into();
        return Err(PortError::Undone { port: session.port().into(), what }.into());
    }
    println!(
        "{}: {} bytes in {seconds:.1} s; the board holds {nodes} nodes, checksum {:08x}, until its power goes",
        path.display(),
        patch.len(),
        session.identity.patch_checksum
    );
    match FitRecord::of_file(path) {
        Some(record) => println!("{}", record.sentence()),
        None => println!("how wrong it is is unknown: there is no record of its fit (.patch.json) beside it"),
    }
    Ok(())
}

/// Sends a patch once; returns its number of nodes, or why it was refused.
fn sent(session: &mut Session, patch: &[u8]) -> Result<Result<u32, Refusal>, Error> {
    let answer = |message| match message {
        FromBoard::PatchTaken(nodes) => Some(Ok(nodes)),
        FromBoard::Refused(refusal) => Some(Err(refusal)),
        _ => None,
    };
    for message in upload::messages(patch) {
        session.send(&message)?;
        // reads what arrived meanwhile, so that the system's queue does not overflow
        while let Some(came) = session.next(Duration::ZERO)? {
            if let Some(answer) = answer(came) {
                return Ok(answer);
            }
        }
    }
    let begun = Instant::now();
    while let Some(came) = session.next(OPENED.saturating_sub(begun.elapsed()))? {
        if let Some(answer) = answer(came) {
            return Ok(answer);
        }
    }
    let what = "the patch was sent and the board does not say what it makes of it: try again, on a shorter or slower line".into();
    Err(PortError::Undone { port: session.port().into(), what }.into())
}

pub(super) fn modulus(pascal: f32, session: &mut Session) -> Result<(), Error> {
    let was = session.identity.youngs_modulus_pa;
    session.send(&ToBoard::YoungsModulus(pascal))?;
    let begun = Instant::now();
    while let Some(came) = session.next(ANSWER.saturating_sub(begun.elapsed()))? {
        match came {
            FromBoard::PatchTaken(nodes) => {
                session.identify()?;
                println!("Young's modulus {} Pa, was {was} Pa; {nodes} nodes", session.identity.youngs_modulus_pa);
                return Ok(());
            }
            FromBoard::Modulus(taken) => {
                println!("Young's modulus {taken} Pa as soon as nothing touches, was {was} Pa");
                return Ok(());
            }
            FromBoard::Refused(refusal) => return Err(PortError::Refused { port: session.port().into(), refusal }.into()),
            _ => {}
        }
    }
    let what = format!("the board did not say that it took a modulus of {pascal} Pa: try again");
    Err(PortError::Undone { port: session.port().into(), what }.into())
}

pub(super) fn profile(device: &str, port: &PortArgs) -> Result<(), Error> {
    let (device, profile) = device_file::load(device)?;
    port.with(|session| send_profile(&device, &profile, session))
}

/// Sends a profile. A board with flash restarts to store it and erases a sector for up to two
/// seconds.
pub(super) fn send_profile(device: &DeviceProfile, profile: &Profile, session: &mut Session) -> Result<(), Error> {
    session.silence = ANSWER;
    session.send(&ToBoard::Store(*profile))?;
    let begun = Instant::now();
    while let Some(came) = session.next(ANSWER.saturating_sub(begun.elapsed()))? {
        match came {
            FromBoard::Stored(generation) => {
                session.silence = SILENCE;
                let kept = match generation {
                    0 => "until the power goes or the board resets: its memory keeps no profile".into(),
                    _ => format!("profile number {generation} of this board"),
                };
                println!(
                    "{}: at most {} N, workspace {} mm, a count of {} um; {kept}",
                    device.name,
                    device.force_limit_n,
                    device.workspace_m.map(|side| format!("{:.0}", side * 1e3)).join(" x "),
                    device.count_m * 1e6
                );
                device.cautions().iter().for_each(|caution| println!("{caution}"));
                if profile.mechanism.is_some_and(|mechanism| mechanism.homing) {
                    println!("hold the device in its home pose and run `palpate board home --port {}`", session.port());
                }
                return Ok(());
            }
            FromBoard::Refused(refusal) => return Err(PortError::Refused { port: session.port().into(), refusal }.into()),
            _ => {}
        }
    }
    let what = "the board did not say that it keeps the profile: try again".into();
    Err(PortError::Undone { port: session.port().into(), what }.into())
}

pub(super) fn home(session: &mut Session) -> Result<(), Error> {
    let answer = session.ask(&ToBoard::Home, ANSWER, |message| match message {
        FromBoard::Homed => Some(Ok(())),
        FromBoard::Refused(refusal) => Some(Err(refusal)),
        _ => None,
    })?;
    match answer {
        Some(Ok(())) => {
            println!("the home pose is known, until the power goes, the board resets or an encoder fails");
            Ok(())
        }
        Some(Err(refusal)) => Err(PortError::Refused { port: session.port().into(), refusal }.into()),
        None => {
            let what = "the board did not say that it took the home pose: try again".into();
            Err(PortError::Undone { port: session.port().into(), what }.into())
        }
    }
}

pub(super) fn ping(count: u32, session: &mut Session) -> Result<(), Error> {
    let mut trips_ms = Vec::new();
    let mut lost = 0_u32;
    for _ in 0..count {
        let begun = Instant::now();
        session.send(&ToBoard::Identify)?;
        let back = loop {
            let left = ROUND_TRIP.saturating_sub(begun.elapsed());
            match session.next(left)? {
                Some(FromBoard::Identity(_)) => break true,
                Some(FromBoard::Refused(refusal)) => {
                    return Err(PortError::Refused { port: session.port().into(), refusal }.into());
                }
                Some(_) if !left.is_zero() => {}
                _ => break false,
            }
        };
        if back { trips_ms.push(begun.elapsed().as_secs_f64() * 1e3) } else { lost += 1 }
    }
    trips_ms.sort_by(f64::total_cmp);
    let at = |share: f64| trips_ms.get(((trips_ms.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied();
    let (Some(median), Some(most), Some(worst)) = (at(0.5), at(0.99), trips_ms.last()) else {
        let what = format!("none of {count} messages came back: check the wiring and the board's power");
        return Err(PortError::Undone { port: session.port().into(), what }.into());
    };
    println!(
        "round trip: median {median:.2} ms, 99 % within {most:.2} ms, longest {worst:.2} ms; {} of {count} came back, {lost} lost; up to 1 ms of it is the wait for a tick",
        trips_ms.len()
    );
    Ok(())
}
