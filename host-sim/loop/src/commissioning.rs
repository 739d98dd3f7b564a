//! Result of a commissioning in a device's profile: the measured values, the wiring and the
//! day.

use std::fmt::Write as _;
use std::path::Path;

use palpate::haptic::commission::{Commissioned, Plan, Stage};
use palpate_tissue::error::Error;

use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::wiring::WiringTable;

/// Signs of the encoders and motors of a mechanism's joints.
pub type Signs = [Vec<i8>; 2];

/// Instruction to the user, or the work in progress, in one sentence. `names` are those of the axes
/// or joints.
#[must_use]
pub fn sentence(stage: Stage, names: [&str; 3], distance_m: f32) -> String {
    let name = |n: u8| names.get(usize::from(n)).copied().unwrap_or("?");
    match stage {
        Stage::Start(n) => {
            format!("hold the handle still, with room to move it {:.0} mm {}; then confirm", distance_m * 1e3, name(n))
        }
        Stage::Move(n) => {
            format!("move the handle {:.0} mm {}, straight, and hold it still there; then confirm", distance_m * 1e3, name(n))
        }
        Stage::LetGo => "put the handle into the middle of its workspace, take the hand off and stay clear; then confirm".into(),
        Stage::Drive(n) => format!("hand off: motor {} is measured, with 0.5 N at most", n + 1),
        Stage::Done => "commissioned".into(),
        Stage::Stopped(trouble) => format!("not commissioned, the profile stays as it was: {trouble}"),
    }
}

/// Directions of the device's axes in sentences: x to the user, y to the user's right, z up.
pub const DIRECTIONS: [&str; 3] = ["along x, towards you", "along y, to your right", "along z, up"];

/// The profile's text with the measured values, the wiring and the day. Comments and all other keys
/// stay. `signs` are those of a mechanism's joints, whose units are not changed.
///
/// # Errors
/// The text that results is no profile; the message says why.
pub fn completed(profile: &DeviceProfile, found: &Commissioned, signs: Option<&Signs>, day: &str) -> Result<String, Error> {
    // the axis with the least friction and the least mass is the one that shakes first
    let least = |all: [f32; 3]| all.into_iter().filter(|x| *x > 0.0).fold(f32::INFINITY, f32::min);
    let (friction_n, mass_kg) = (least(found.friction_n), least(found.mass_kg));
    let count_m = found.count_m.into_iter().fold(0.0, f32::max);
    let mut keys = vec![
        ("friction_n", format!("{:.3}", if friction_n.is_finite() { friction_n } else { 0.0 })),
        ("mass_kg", format!("{mass_kg:.4}")),
        ("delay_ticks", found.delay_ticks.to_string()),
        ("amplifier_lag_s", format!("{:.4}", found.lag_s)),
        ("commissioned", format!("\"{day}\"")),
    ];
    let same = (f64::from(count_m) - profile.count_m).abs() <= f64::from(Plan::SAME_UNIT) * profile.count_m;
    if signs.is_none() && count_m > 0.0 && !same {
        keys.push(("count_m", format!("{count_m:.3e}")));
    }
    let mut text = with_keys(&without_table(&profile.text, "wiring"), None, &keys);
    if let Some([encoder, motor]) = signs {
        let keys = [("encoder_sign", format!("{encoder:?}")), ("motor_sign", format!("{motor:?}"))];
        text = with_keys(&text, Some("mechanism"), &keys);
    }
    let table = WiringTable::from(&found.wiring);
    // writing to a string does not fail
    let _ = write!(
        text,
        "\n[wiring]\nsensor = {:?}\nm_per_unit = {:?}\nmotor = {:?}\nmotor_sign = {:?}\n",
        table.sensor, table.m_per_unit, table.motor, table.motor_sign
    );
    DeviceProfile::parse(&text, "the commissioned profile")?;
    Ok(text)
}

/// Writes a file as a whole: it appears under its name only when it is complete.
///
/// # Errors
/// The file cannot be written; a file that was there stays.
pub fn write_whole(path: &Path, text: &str) -> Result<(), Error> {
    let failed = |source| Error::Write { path: path.into(), source };
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    std::fs::write(&part, text).map_err(failed)?;
    std::fs::rename(&part, path).map_err(failed)
}

/// Whether a line begins a table, and its name.
fn table_of(line: &str) -> Option<&str> {
    line.trim().strip_prefix('[').map(|rest| rest.trim_matches(['[', ']', ' ']))
}

/// Sets keys of a table, or of the part before the first table.
fn with_keys(text: &str, table: Option<&str>, keys: &[(&str, String)]) -> String {
    let mut lines: Vec<String> = Vec::new();
    let (mut inside, mut end) = (table.is_none(), None);
    let mut left: Vec<&(&str, String)> = keys.iter().collect();
    for line in text.lines() {
        if let Some(name) = table_of(line) {
            if inside {
                end = Some(lines.len());
            }
            inside = Some(name) == table;
        }
        let key = line.split('=').next().unwrap_or_default().trim();
        match left.iter().position(|(name, _)| inside && *name == key) {
            Some(at) => {
                let (name, value) = left.remove(at);
                lines.push(format!("{name} = {value}"));
            }
            None => lines.push(line.into()),
        }
    }
    let end = if inside { lines.len() } else { end.unwrap_or(lines.len()) };
    // not behind the empty lines and comments that lead to the next table
    let end = (0..end)
        .rev()
        .find(|n| lines.get(*n).is_some_and(|line| !line.trim().is_empty() && !line.starts_with('#')))
        .map_or(end, |n| n + 1);
    for (name, value) in left.into_iter().rev() {
        lines.insert(end, format!("{name} = {value}"));
    }
    lines.join("\n") + "\n"
}

/// Removes a table.
fn without_table(text: &str, table: &str) -> String {
    let mut inside = false;
    let kept: Vec<&str> = text
        .lines()
        .filter(|line| {
            if let Some(name) = table_of(line) {
                inside = name == table;
            }
            !inside
        })
        .collect();
    kept.join("\n").trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use palpate::haptic::commission::Wiring;

    use super::*;

    fn found() -> Commissioned {
        Commissioned {
            wiring: Wiring { sensor: [1, 0, 2], per_unit: [1e-3, -1e-3, 1e-3], motor: [0, 2, 1], motor_sign: [1.0, -1.0, 1.0] },
            friction_n: [0.03, 0.04, 0.05],
            mass_kg: [0.046, 0.045, 0.05],
            count_m: [1e-5; 3],
            delay_ticks: 2,
            lag_s: 1.5e-3,
        }
    }

    #[test]
    fn measured_values_replace_those_of_the_file_and_everything_else_stays() {
        let mut profile = DeviceProfile::load("touch").unwrap();
        profile.text = profile.text.replace("friction_n = 0.03\n", "");
        let once = completed(&profile, &found(), None, "2026-11-27").unwrap();
        let read = DeviceProfile::parse(&once, "x").unwrap();
        assert_eq!((read.friction_n, read.mass_kg, read.amplifier_lag_s, read.delay_ticks), (0.03, 0.045, 1.5e-3, 2));
        assert_eq!((read.count_m, read.commissioned.as_deref()), (1e-5, Some("2026-11-27")));
        assert_eq!(read.wiring.unwrap().wiring(), found().wiring);
        assert_eq!(
            (read.max_force_n, read.workspace_m, &read.source),
            (profile.max_force_n, profile.workspace_m, &profile.source)
        );
        for comment in profile.text.lines().filter(|line| line.starts_with('#')) {
            assert!(once.contains(comment), "{comment}");
        }
        assert_eq!(read.cautions(), Vec::<String>::new());
        // again: nothing is doubled
        let twice = completed(&read, &found(), None, "2026-11-27").unwrap();
        assert_eq!(twice, once);
    }

    #[test]
    fn a_mechanism_gets_its_signs_in_its_own_table() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../firmware/controller/devices/paddle.toml");
        let profile = DeviceProfile::load(file).unwrap();
        let signs = [vec![-1], vec![1]];
        let text = completed(&profile, &found(), Some(&signs), "2026-11-27").unwrap();
        let read = DeviceProfile::parse(&text, "x").unwrap();
        let mechanism = read.mechanism.unwrap();
        assert_eq!(mechanism["encoder_sign"].as_array().unwrap()[0].as_integer(), Some(-1));
        assert_eq!(mechanism["motor_sign"].as_array().unwrap()[0].as_integer(), Some(1));
        assert_eq!(read.count_m, profile.count_m, "the data sheet's");
    }

    #[test]
    fn what_a_profile_does_not_say_is_named_with_the_value_taken() {
        let touch = DeviceProfile::load("touch").unwrap();
        let mut bare: String = touch.text.clone();
        for key in ["friction_n", "mass_kg", "amplifier_lag_s"] {
            bare = bare.lines().filter(|line| !line.starts_with(key)).map(|line| format!("{line}\n")).collect();
        }
        let bare = DeviceProfile::parse(&bare, "x").unwrap();
        assert_eq!((bare.friction_n, bare.mass_kg, bare.amplifier_lag_s), (0.0, 0.03, 3e-3));
        let said = bare.cautions().join("\n");
        for words in ["friction_n", "0.03 kg", "0.003 s", "0.5 N"] {
            assert!(said.contains(words), "{said}");
        }
        assert_eq!(touch.cautions().len(), 1, "only that it is not commissioned");
    }
}
