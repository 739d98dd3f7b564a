//! The boundary to C: it converts pointers to values and failures to codes, and catches panics.
//!
//! Every function may be called at any time and from any thread, with any number in place of a
//! handle; pointers are checked for NULL and may be unaligned. The caller guarantees that they
//! point to memory of the stated type and length, which is the only condition that cannot be
//! checked here.
#![expect(unsafe_code, reason = "pointers of C are followed here and in `pointers`, and nowhere else")]

use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::LazyLock;

use palpate::haptic::commission::Stage;
use palpate::{Fault, Vector3};
use palpate_loop::haptic_session::{HapticSession, Input};

use crate::code::{Failure, PalpateCode};
use crate::pointers::{array, fits, maybe_text, read, text, write, write_text, write_threes};
use crate::records::{PalpateContact, PalpateInfo, PalpateInput, PalpateReport, PalpateStage, wide};
use crate::{message, sessions};

/// Handle of a session; 0 is no session.
type Session = u64;

/// Device profile that is used if the caller passes NULL.
const DEFAULT_DEVICE: &str = "touch";

/// Opens a scene. `scene` is a preset's name or the path of a scene file; `patch` is the path of a
/// patch file in place of the scene's own, or NULL. `device` is a profile's name or the path of a
/// .toml file; NULL selects "touch". The call may take some seconds, and allocates all memory that
/// the session needs. `session` receives the handle, 0 on failure.
///
/// # Safety
/// Texts end with a zero byte; `session` points to one handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_open_scene(
    scene: *const c_char,
    patch: *const c_char,
    device: *const c_char,
    session: *mut Session,
) -> PalpateCode {
    // SAFETY: the caller guarantees all four pointers
    let texts = unsafe { (text("scene", scene), maybe_text("patch", patch), maybe_text("device", device)) };
    // SAFETY: the caller guarantees the pointer
    unsafe {
        open(session, || {
            let (scene, patch, device) = (texts.0?, texts.1?, texts.2?);
            Ok(HapticSession::open(scene, patch.map(Path::new), device.unwrap_or(DEFAULT_DEVICE))?)
        })
    }
}

/// Opens a patch file without a scene: tissue, probe and site are those with which it was packed.
/// `device` and `session` are as in `palpate_open_scene`.
///
/// # Safety
/// Texts end with a zero byte; `session` points to one handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_open_patch(path: *const c_char, device: *const c_char, session: *mut Session) -> PalpateCode {
    // SAFETY: the caller guarantees the pointer
    let texts = unsafe { (text("path", path), maybe_text("device", device)) };
    // SAFETY: the caller guarantees the pointer
    unsafe {
        open(session, || {
            let (path, device) = (texts.0?, texts.1?);
            Ok(HapticSession::open_patch(Path::new(path), device.unwrap_or(DEFAULT_DEVICE))?)
        })
    }
}

/// Like `palpate_open_patch`, but from the bytes of the file, which are not needed after the call.
///
/// # Safety
/// `bytes` points to `length` bytes; texts end with a zero byte; `session` points to one handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_open_patch_bytes(
    bytes: *const u8,
    length: usize,
    device: *const c_char,
    session: *mut Session,
) -> PalpateCode {
    // SAFETY: the caller guarantees the pointer
    let (bytes, device) = unsafe { (array("bytes", bytes, length), maybe_text("device", device)) };
    // SAFETY: the caller guarantees the pointer
    unsafe { open(session, || Ok(HapticSession::of_patch_bytes(bytes?, device?.unwrap_or(DEFAULT_DEVICE))?)) }
}

/// Closes a session and frees its memory. The device keeps the last force that you gave it, so give
/// it zero first.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_close(session: Session) -> PalpateCode {
    code(|| sessions::remove(session))
}

/// Runs one tick: takes the position of the probe's tip [m], x y z in the scene's frame, and writes
/// the force on the device [N] to `force_n`. Call it every millisecond; it cannot see periods that
/// you missed, which `palpate_tick_with` takes. `force_n` is zero on every failure; with a NULL
/// `tip_m` the sensor counts as failed and the fault is latched. `PALPATE_CODE_FAULT` is returned
/// while a fault is latched. If the device was commissioned, the position is the site plus the
/// values that were the readings of `palpate_commission`.
///
/// # Safety
/// `tip_m` and `force_n` point to three doubles each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_tick(session: Session, tip_m: *const f64, force_n: *mut f64) -> PalpateCode {
    // SAFETY: the caller guarantees the pointer
    let tip_m = unsafe { read::<[f64; 3]>("tip_m", tip_m.cast()) };
    let input = tip_m.map(|tip_m| PalpateInput { tip_m, ..PalpateInput::default() });
    // SAFETY: the caller guarantees the pointer
    unsafe { tick(session, input, force_n) }
}

/// Like `palpate_tick`, for devices that report more about a reading than its position.
/// `input_bytes` is `sizeof(palpate_input)`.
///
/// # Safety
/// `input` points to `input_bytes` bytes, `force_n` to three doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_tick_with(
    session: Session,
    input: *const PalpateInput,
    input_bytes: usize,
    force_n: *mut f64,
) -> PalpateCode {
    let sized = fits::<PalpateInput>("input_bytes", input_bytes);
    // SAFETY: the caller guarantees the pointer, and the size is ours
    let input = sized.and_then(|()| unsafe { read("input", input) });
    // SAFETY: the caller guarantees the pointer
    unsafe { tick(session, input, force_n) }
}

/// Runs one tick of a commissioning in place of `palpate_tick`: it measures order, sign, unit,
/// friction, mass, delay and lag of the device, with 0.5 N at most. `reading` are the values of the
/// three sensors, in any unit, as you add them to the site for `palpate_tick`; `distance_m` is the
/// distance by which the user moves the handle along each axis, such as 0.05. Pass 1 for
/// `confirmed` in the one tick in which the user says that the present step is done, otherwise 0;
/// `palpate_commission_text` says what the step is. `force_n` receives the forces for the three
/// motors [N], to be sent at once, and `stage` one of `palpate_stage`.
///
/// The session's profile changes only at `PALPATE_STAGE_DONE`; `palpate_write_profile` then stores
/// it. If the measurement ends early, `PALPATE_CODE_NOT_COMMISSIONED` is returned once,
/// `palpate_last_message` says why, and the next call begins anew.
///
/// # Safety
/// `reading` and `force_n` point to three doubles each, `stage` to one `int32_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_commission(
    session: Session,
    reading: *const f64,
    distance_m: f64,
    confirmed: i32,
    force_n: *mut f64,
    stage: *mut i32,
) -> PalpateCode {
    code(|| {
        // SAFETY: the caller guarantees the pointers. The force is set to zero first, and stays
        // zero if anything below fails
        unsafe {
            write("force_n", force_n.cast(), [0.0_f64; 3])?;
            write("stage", stage, PalpateStage::Stopped as i32)?;
        }
        // SAFETY: the caller guarantees the pointer
        let reading = unsafe { read::<[f64; 3]>("reading", reading.cast()) }?.map(|x| x as f32);
        let step = sessions::with(session, |it| Ok(it.commission(Vector3::from(reading), distance_m as f32, confirmed != 0)?))?;
        if let Stage::Stopped(trouble) = step.stage {
            return Err(Failure::NotCommissioned(trouble));
        }
        // SAFETY: the caller guarantees the pointers
        unsafe {
            write("stage", stage, PalpateStage::of(step.stage) as i32)?;
            write("force_n", force_n.cast(), wide(&step.force_n))
        }
    })
}

/// Writes what the user has to do in the present step of a commissioning, as one sentence of at
/// most `capacity` bytes with its closing zero. `distance_m` is that of `palpate_commission`.
///
/// # Safety
/// `text` points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_commission_text(
    session: Session,
    distance_m: f64,
    text: *mut c_char,
    capacity: usize,
) -> PalpateCode {
    code(|| {
        let sentence = sessions::with(session, |session| Ok(session.commission_sentence(distance_m as f32)?))?;
        // SAFETY: the caller guarantees the pointer
        unsafe { write_text("text", text, capacity, &sentence) }
    })
}

/// Writes what the device's profile does not say, with the cautious values that are taken, and
/// whether it is uncommissioned: one line each, at most `capacity` bytes with the closing zero;
/// empty if there is nothing to say.
///
/// # Safety
/// `text` points to `capacity` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_cautions(session: Session, text: *mut c_char, capacity: usize) -> PalpateCode {
    code(|| {
        let lines = sessions::with(session, |session| Ok(session.cautions().join("\n")))?;
        // SAFETY: the caller guarantees the pointer
        unsafe { write_text("text", text, capacity, &lines) }
    })
}

/// Writes the profile that the last commissioning completed to a file, as a whole.
///
/// # Safety
/// `path` ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_write_profile(session: Session, path: *const c_char) -> PalpateCode {
    // SAFETY: the caller guarantees the pointer
    let path = unsafe { text("path", path) };
    code(|| {
        let path = path?;
        sessions::with(session, |session| {
            session.measured_profile()?;
            Ok(session.write_profile(Path::new(path))?)
        })
    })
}

/// Copies the record of the last tick to `report`. `report_bytes` is `sizeof(palpate_report)`.
///
/// # Safety
/// `report` points to `report_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_report(session: Session, report: *mut PalpateReport, report_bytes: usize) -> PalpateCode {
    code(|| {
        fits::<PalpateReport>("report_bytes", report_bytes)?;
        let record = sessions::with(session, |session| PalpateReport::of(session))?;
        // SAFETY: the caller guarantees the pointer, and the size is ours
        unsafe { write("report", report, record) }
    })
}

/// Computes the contact of the tissue with the probe after the last tick and writes it to
/// `contact`: normal and friction force, torque about the tip, centre of pressure, axes, area and
/// peak. It changes no tick, and costs nothing where it is not called. `contact_bytes` is
/// `sizeof(palpate_contact)`.
///
/// # Safety
/// `contact` points to `contact_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_contact(
    session: Session,
    contact: *mut PalpateContact,
    contact_bytes: usize,
) -> PalpateCode {
    code(|| {
        fits::<PalpateContact>("contact_bytes", contact_bytes)?;
        let record = sessions::with(session, |session| Ok(PalpateContact::of(&session.contact(&mut []))))?;
        // SAFETY: the caller guarantees the pointer, and the size is ours
        unsafe { write("contact", contact, record) }
    })
}

/// Copies the properties of tissue, probe and device to `info`. `info_bytes` is
/// `sizeof(palpate_info)`.
///
/// # Safety
/// `info` points to `info_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_info(session: Session, info: *mut PalpateInfo, info_bytes: usize) -> PalpateCode {
    code(|| {
        fits::<PalpateInfo>("info_bytes", info_bytes)?;
        let record = sessions::with(session, |session| Ok(PalpateInfo::of(session)))?;
        // SAFETY: the caller guarantees the pointer, and the size is ours
        unsafe { write("info", info, record) }
    })
}

/// Copies the positions of all nodes [m] to `positions_m`, x y z of one node after the other, for
/// drawing. `capacity` is the length of `positions_m` in doubles, at least three times
/// `palpate_info.nodes`.
///
/// # Safety
/// `positions_m` points to `capacity` doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_nodes(session: Session, positions_m: *mut f64, capacity: usize) -> PalpateCode {
    code(|| {
        sessions::with(session, |session| {
            let nodes = session.tissue().nodes().iter().map(|node| wide(&node.position_m()));
            // SAFETY: the caller guarantees the pointer
            unsafe { write_threes("positions_m", positions_m, capacity, nodes) }
        })
    })
}

/// Copies the triangles of the surface to `corners`, for drawing: three indices of nodes for each,
/// counter-clockwise seen from outside. They never change. `capacity` is the length of `corners`,
/// at least three times `palpate_info.triangles`.
///
/// # Safety
/// `corners` points to `capacity` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_read_triangles(session: Session, corners: *mut u32, capacity: usize) -> PalpateCode {
    code(|| {
        sessions::with(session, |session| {
            let triangles = session.tissue().patch().model().triangles.iter().map(|t| t.node.map(u32::from));
            // SAFETY: the caller guarantees the pointer
            unsafe { write_threes("corners", corners, capacity, triangles) }
        })
    })
}

/// Writes a hash of all positions and velocities of the tissue to `hash`; it is equal on every
/// machine after the same ticks.
///
/// # Safety
/// `hash` points to one `uint64_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_state_hash(session: Session, hash: *mut u64) -> PalpateCode {
    code(|| {
        let found = sessions::with(session, |session| Ok(session.hash()))?;
        // SAFETY: the caller guarantees the pointer
        unsafe { write("hash", hash, found) }
    })
}

/// Requests force output. It begins once the probe has been outside the tissue and calm for a tenth
/// of a second, and is then ramped up over half a second in free space.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_arm(session: Session) -> PalpateCode {
    code(|| sessions::with(session, |session| Ok(session.arm()?)))
}

/// Ramps the force down to zero within an eighth of a second of ticks, and disarms.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_stop(session: Session) -> PalpateCode {
    code(|| {
        sessions::with(session, |session| {
            session.stop();
            Ok(())
        })
    })
}

/// Requests that the next tick clear the fault. The tick refuses the request, as
/// `palpate_report.refused` shows, until readings have been good for a tenth of a second. Arm again
/// afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_clear(session: Session) -> PalpateCode {
    code(|| sessions::with(session, |session| Ok(session.clear()?)))
}

/// Restarts the session: tissue at rest, no force, no fault, not armed. Modulus and lowered limits
/// are kept.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_reset(session: Session) -> PalpateCode {
    code(|| sessions::with(session, |session| session.reset().map_err(Failure::Number)))
}

/// Sets Young's modulus [Pa], between half and twice the one with which the session was opened. An
/// increase takes effect only when the probe does not touch the tissue.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_set_modulus(session: Session, youngs_modulus_pa: f64) -> PalpateCode {
    code(|| sessions::with(session, |session| session.set_modulus(youngs_modulus_pa as f32).map_err(Failure::Number)))
}

/// Turns the probe about its tip from the next tick on: `orientation` is its rotation from the
/// upright pose, a unit quaternion x, y, z, w in the scene's frame, by at most 45 degrees. It
/// replaces the scene's tilt until the next call; a device that measures it calls this before each
/// tick. The probe turns no faster than its farthest point may sink into the tissue. Positions are
/// then those of the point of the turned probe that is lowest when it is upright. Damping and
/// friction act on the displacement of that point alone, not on the rotation.
///
/// # Safety
/// `orientation` points to four doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_turn(session: Session, orientation: *const f64) -> PalpateCode {
    code(|| {
        // SAFETY: the caller guarantees the pointer
        let turn = unsafe { read::<[f64; 4]>("orientation", orientation.cast())? };
        sessions::with(session, |session| session.turn(turn.map(|part| part as f32)).map_err(Failure::Number))
    })
}

/// Lowers the maximum force [N] until the session is closed; no limit can be raised or switched
/// off.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_lower_force(session: Session, max_force_n: f64) -> PalpateCode {
    code(|| sessions::with(session, |session| session.lower_force(max_force_n as f32).map_err(Failure::Number)))
}

/// Returns the description of a code; never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_error_text(code: i32) -> *const c_char {
    let known = PalpateCode::ALL.into_iter().find(|known| *known as i32 == code);
    known.map_or(c"no code of this library", PalpateCode::text).as_ptr()
}

/// Returns the name of a mode; never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_mode_text(mode: i32) -> *const c_char {
    let names = [c"boot", c"self-test", c"idle", c"arming", c"active", c"degraded", c"ramping down", c"fault"];
    let name = usize::try_from(mode).ok().and_then(|n| names.get(n));
    name.map_or(c"no mode of this library", |name| name).as_ptr()
}

/// Returns the description of the fault number in a report; never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_fault_text(fault: i32) -> *const c_char {
    static TEXTS: LazyLock<Vec<CString>> =
        LazyLock::new(|| Fault::ALL.iter().map(|fault| CString::new(fault.text()).unwrap_or_default()).collect());
    match fault {
        0 => c"no fault",
        _ => Fault::ALL
            .iter()
            .zip(&*TEXTS)
            .find(|(f, _)| i32::from(**f as u8) == fault)
            .map_or(c"no fault of this library", |f| f.1),
    }
    .as_ptr()
}

/// Says in one line why the last failed call of this thread failed; empty if none has failed. Never
/// NULL; valid in this thread until its next call that fails.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_last_message() -> *const c_char {
    message::last()
}

/// Version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn palpate_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// Runs a call. If it fails or panics, returns the code and stores the thread's message.
fn code(call: impl FnOnce() -> Result<(), Failure>) -> PalpateCode {
    let done = catch_unwind(AssertUnwindSafe(call)).unwrap_or(Err(Failure::Internal));
    done.map_or_else(
        |failure| {
            message::keep(&failure);
            failure.code()
        },
        |()| PalpateCode::Ok,
    )
}

/// # Safety
/// `handle` is NULL or points to one handle.
unsafe fn open(handle: *mut u64, work: impl FnOnce() -> Result<HapticSession, Failure>) -> PalpateCode {
    code(|| {
        // SAFETY: the caller guarantees the pointer
        unsafe { write("session", handle, 0)? };
        let opened = sessions::insert(work()?)?;
        // SAFETY: the caller guarantees the pointer
        unsafe { write("session", handle, opened) }
    })
}

/// # Safety
/// `force_n` is NULL or points to three doubles.
unsafe fn tick(session: Session, input: Result<PalpateInput, Failure>, force_n: *mut f64) -> PalpateCode {
    code(|| {
        // SAFETY: the caller guarantees the pointer. The force is set to zero first, and stays zero
        // if anything below fails
        let room = unsafe { write("force_n", force_n.cast(), [0.0_f64; 3]) };
        let failed = Input { sensor_failed: true, ..PalpateInput::default().to_core() };
        let read = if room.is_ok() { input.as_ref().map_or(failed, |input| input.to_core()) } else { failed };
        let (applied_n, fault) = sessions::with(session, |session| {
            let fault = session.tick(&read).fault;
            Ok((wide(&session.drive_n()), fault))
        })?;
        room.and(input.map(drop))?;
        fault.map_or(Ok(()), |fault| Err(Failure::Fault(fault)))?;
        // SAFETY: the caller guarantees the pointer
        unsafe { write("force_n", force_n.cast(), applied_n) }
    })
}
