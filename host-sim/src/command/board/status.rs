//! The command `palpate board status`.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use palpate::haptic::account::EnergyBound;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::mode::Mode;
use palpate_board::defmt_log::checksum;
use palpate_board::firmware_image::FirmwareImage;
use palpate_board::patch_record;
use palpate_controller::crash::Crash;
use palpate_controller::haptic_loop::MOST_PERCENT;
use palpate_controller::link::{FromBoard, Identity, Record, ToBoard};
use palpate_controller::words;

use super::log::{Log, images};
use crate::command::options::board::PortArgs;
use crate::error::Error;
use crate::port::session::force_words;

/// Longest wait for the status: the board scans its stack, which takes a third of a tick.
const ANSWER: Duration = Duration::from_millis(500);
/// Period of a tick [us].
const TICK_US: f64 = 1e3;

pub(super) fn run(port: &PortArgs) -> Result<(), Error> {
    let (mut session, mut log) = port.open()?;
    let state = session.ask(&ToBoard::Report, ANSWER, |message| match message {
        FromBoard::State { stack_used_bytes, bad_frames, nodes, commissioned, at_once_j, lasting_w, .. } => {
            Some((stack_used_bytes, bad_frames, nodes, commissioned, EnergyBound { at_once_j, lasting_w }))
        }
        _ => None,
    })?;
    // the record after the answer has the time of a tick without other work
    let wait = Duration::from_millis(100);
    let mut crashed = None;
    loop {
        match session.next(wait)? {
            Some(FromBoard::Record(_)) | None => break,
            Some(FromBoard::Crashed(crash)) => crashed = Some(crash),
            Some(_) => {}
        }
    }
    let (record, identity) = (&session.record, &session.identity);
    println!("board   {} on {}", image(identity), session.port());
    println!("mode    {}", mode(record));
    println!("fault   {}", fault(record));
    if let Some(crash) = &crashed {
        println!("crash   {}", last_crash(port, identity, crash));
    }
    println!("force   {}", force_words(record));
    if let Some((.., bound)) = &state {
        println!(
            "energy  at most {:.3} mJ at once and {:.3} mJ in ten seconds, beyond what the hand gives",
            bound.at_once_j * 1e3,
            bound.within_j(10.0) * 1e3
        );
    }
    let [x, y, z] = record.position_m.map(|m| m * 1e3);
    println!("tip     {x:.2}, {y:.2}, {z:.2} mm; the patch's site is at 0, 0, 0, outside is z > 0");
    if let Some((_, _, _, commissioned, _)) = state {
        println!("device  {}", device(commissioned));
    }
    match state {
        Some((_, _, 0, ..)) => println!("patch   none: send one with `palpate board upload`"),
        Some((stack, bad_frames, nodes, ..)) => {
            println!(
                "patch   {nodes} nodes, checksum {:08x}, Young's modulus {} Pa",
                identity.patch_checksum, identity.youngs_modulus_pa
            );
            println!("error   {}", error(port, identity));
            println!("tick    {}", tick(record, identity));
            println!("        {}", longest(identity));
            println!("stack   {stack} bytes at the deepest since power-on");
            println!("link    {bad_frames} frames dropped there, {} here", session.counts().bad);
        }
        None => println!("patch   not said"),
    }
    Log::gather(&mut session);
    Log::leave(&mut session);
    let lines: Vec<String> = log.lines(&mut session).into_iter().chain(log.unread()).collect();
    if lines.is_empty() {
        println!("log     nothing since it was last read");
    }
    lines.iter().for_each(|line| println!("log     {line}"));
    Ok(())
}

/// Whether the device was commissioned, and what follows.
pub(super) fn device(commissioned: bool) -> String {
    match commissioned {
        true => "commissioned".into(),
        false => format!(
            "not commissioned: the force is at most {} N; `palpate board commission` measures signs, units and delays",
            DeviceSpec::UNCOMMISSIONED_N
        ),
    }
}

/// The last crash since power-on, with the names of its functions from the ELF file of the image.
fn last_crash(port: &PortArgs, identity: &Identity, crash: &Crash) -> String {
    let files = port.image.clone().into_iter().chain(images()).filter_map(|path| std::fs::read(path).ok());
    let image = files.filter(|elf| checksum(elf) == Some(identity.image)).find_map(|elf| FirmwareImage::parse(&elf).ok());
    let named = |address: u32| image.as_ref().and_then(|image| image.function_at(address & !1)).map(|found| found.name.as_str());
    match (named(crash.pc), named(crash.lr)) {
        (Some(at), Some(caller)) => format!("since power-on: {crash} (in {at}, called from {caller})"),
        (Some(at), None) => format!("since power-on: {crash} (in {at})"),
        _ => format!("since power-on: {crash}"),
    }
}

/// Errors of the board's patch, from the record in the ELF file of its image.
fn error(port: &PortArgs, identity: &Identity) -> String {
    let found = port
        .image
        .clone()
        .into_iter()
        .chain(images())
        .find_map(|image| patch_record::of_board(&image, identity.image, identity.patch_checksum));
    found.map_or_else(
        || {
            "unknown: the image has no record of a fit of this patch; one that was sent has it beside its file (.patch.json)"
                .into()
        },
        |record| record.sentence(),
    )
}

/// Board, version and age of an image.
pub(super) fn image(identity: &Identity) -> String {
    let name = String::from_utf8_lossy(&identity.name);
    let name = name.trim_end_matches('\0').replace(char::is_control, "\u{fffd}");
    let today = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400);
    let age = match (identity.built_day, today.checked_sub(identity.built_day.into())) {
        (0, _) | (_, None) => "day of the build unknown".into(),
        (_, Some(0)) => "built today".into(),
        (_, Some(1)) => "built yesterday".into(),
        (_, Some(days)) => format!("built {days} days ago"),
    };
    format!("{name}, {age}")
}

pub(super) fn mode(record: &Record) -> String {
    let says = match record.mode() {
        Some(Mode::Idle) => "no force; `palpate board arm` enables it",
        Some(Mode::Fault) => "no force; see to the cause, then `palpate board clear`",
        Some(Mode::Arming) => "no force before the tip is still outside the tissue",
        Some(Mode::Boot | Mode::SelfTest) => "no force; starts up",
        Some(Mode::Active) => "the force is felt",
        Some(Mode::Degraded) => "the force is felt, scaled down for this contact",
        Some(Mode::SafeRamp) => "the force falls to nothing",
        None => return format!("{} (of another version than this palpate)", record.mode),
    };
    format!("{}: {says}", record.mode().map_or("", words::mode))
}

pub(super) fn fault(record: &Record) -> String {
    match (record.fault, record.fault()) {
        (0, _) => "none".into(),
        (_, Some(fault)) => fault.to_string(),
        (number, None) => format!("{number} (of another version than this palpate)"),
    }
}

/// Duration of a tick, from the sensors to the converters, in words.
fn tick(record: &Record, identity: &Identity) -> String {
    let Some(us) = spent_us(record, identity) else { return "not timed by this board".into() };
    format!(
        "{us:.1} us from sensors to outputs, {:.1} % of a period; {} counts of a clock of {} MHz",
        us / TICK_US * 1e2,
        record.spent_counts,
        f64::from(identity.clock_hz) / 1e6
    )
}

/// Longest tick as the board has measured it, beside the prediction, in words.
fn longest(identity: &Identity) -> String {
    if identity.clock_hz == 0 || identity.longest_counts == 0 {
        return "longest not measured by this board".into();
    }
    let share = f64::from(identity.longest_counts) / f64::from(identity.clock_hz) * 1e3;
    format!(
        "longest {:.1} % of a period, measured in a tap when the patch was opened; above {MOST_PERCENT} % the board does not \
         arm (predicted for the patch alone: {:.0} cycles of a Cortex-M4F without wait states)",
        share * 1e2,
        identity.predicted_cycles
    )
}

/// Duration of a tick [us], if the board has a clock to measure it.
pub(super) fn spent_us(record: &Record, identity: &Identity) -> Option<f64> {
    (identity.clock_hz > 0).then(|| f64::from(record.spent_counts) / f64::from(identity.clock_hz) * 1e6)
}
