//! Converts a device's profile file to the form for a board: limits, and the `[mechanism]` table if
//! there is one.

use std::collections::BTreeMap;

use palpate::Vector3;
use palpate::haptic::cycle::Settings;
use palpate_controller::config::{Profile, ProfileError, WireOrder};
use palpate_controller::kinematics::{DIMENSIONS, Kind, MechanismError, MechanismProfile};
use palpate_controller::probe_in::EncoderCounts;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::day::day_of;
use palpate_tissue::Error;
use serde::Deserialize;
use serde::de::IgnoredAny;

/// `[mechanism]` as the user wrote it: one value per joint, and the dimensions of its kind by name.
#[derive(Deserialize)]
struct Written {
    kind: String,
    /// Counts of the encoder per turn of its shaft, with all four edges counted.
    counts_per_turn: Vec<f64>,
    /// Turns of motor and encoder per turn of the joint.
    gear_ratio: Vec<f64>,
    /// 1, or -1 where the encoder counts down as the joint's angle grows.
    encoder_sign: Option<Vec<f64>>,
    torque_constant_n_m_per_a: Vec<f64>,
    /// Current of the amplifier at the largest code [A].
    full_scale_a: Vec<f64>,
    /// 1, or -1 where a positive code lowers the joint's angle.
    motor_sign: Option<Vec<f64>>,
    /// Joint angles in the home pose [degrees].
    home_deg: Vec<f64>,
    /// Whether the encoders count from their position at power-on, so that the board needs a home
    /// pose.
    homing: bool,
    /// Counts of absolute encoders in the home pose.
    home_counts: Option<Vec<i32>>,
    /// All other keys, so that a misspelt one can be named.
    #[serde(flatten)]
    dimensions: BTreeMap<String, Dimension>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Dimension {
    Number(f64),
    Other(IgnoredAny),
}

/// Loads a device by name or from a file: its data for the loop, and the board's checked profile.
pub fn load(name_or_file: &str) -> Result<(DeviceProfile, Profile), Error> {
    of(DeviceProfile::load(name_or_file)?, name_or_file)
}

/// Like [`load`], for a profile that is known by this name or file.
pub fn of(device: DeviceProfile, name_or_file: &str) -> Result<(DeviceProfile, Profile), Error> {
    // the centre of the device is its site
    let limits = device.real_limits(Vector3::zeros());
    let settings = Settings { limits: device.limit_values(), ..Settings::safe(&limits) };
    let mut profile = Profile { operator_switch: device.operator_switch, ..Profile::of(&settings, &limits) };
    profile.commissioned_day = device.commissioned.as_deref().and_then(day_of).unwrap_or(0);
    if let Some(table) = &device.wiring {
        let per_count = if device.mechanism.is_some() { 1.0 } else { EncoderCounts::LENGTH_M };
        profile.wiring = WireOrder {
            encoder: table.sensor,
            ratio: table.m_per_unit.map(|m| m / per_count),
            motor: table.motor,
            motor_sign: table.motor_sign.map(|sign| if sign < 0.0 { -1 } else { 1 }),
        };
    }
    let place = |what: String| Error::Usage(format!("{name_or_file}: [mechanism]: {what}"));
    if let Some(table) = &device.mechanism {
        let written: Written = table.clone().try_into().map_err(|cause| place(cause.message().trim().into()))?;
        (profile.mechanism, profile.home_counts) = taken(&written).map(|(it, home)| (Some(it), home)).map_err(place)?;
    }
    // the error is named here, since the board would report only that the profile is wrong
    match (profile.check(), &profile.mechanism) {
        (Ok(()), _) => Ok((device, profile)),
        (Err(ProfileError::Mechanism(cause @ MechanismError::Count)), Some(mechanism)) => {
            let count_um = mechanism.count_m().unwrap_or_default() * 1e6;
            Err(place(format!("{cause}: it is {} um, and there it is {count_um:.3} um", device.count_m * 1e6)))
        }
        (Err(ProfileError::Mechanism(cause)), _) => Err(place(cause.to_string())),
        (Err(ProfileError::Range(cause)), _) => Err(Error::Usage(format!("{name_or_file}: {cause}"))),
    }
}

fn taken(written: &Written) -> Result<(MechanismProfile, [i32; 3]), String> {
    let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    let kind = Kind::ALL.iter().find(|kind| kind.name() == written.kind);
    let kind = *kind.ok_or_else(|| format!("kind = \"{}\" is none: give one of {}", written.kind, names.join(", ")))?;
    let joints = kind.joints();
    let per_joint = |key: &str, given: &[f64]| -> Result<[f64; 3], String> {
        if given.len() != joints {
            return Err(number_of_values(key, given.len(), kind));
        }
        let mut all = [0.0; 3];
        all.iter_mut().zip(given).for_each(|(place, value)| *place = *value);
        Ok(all)
    };
    let signs = |key: &str, given: &Option<Vec<f64>>| {
        let signs = per_joint(key, given.as_deref().unwrap_or(&[1.0; 3][..joints]))?;
        match signs[..joints].iter().find(|sign| sign.abs() != 1.0) {
            Some(sign) => Err(format!("{key} has {sign}: give 1 or -1")),
            None => Ok(signs),
        }
    };
    let positive = |key: &str, given: &[f64]| {
        let values = per_joint(key, given)?;
        match values[..joints].iter().find(|value| !(**value > 0.0 && value.is_finite())) {
            Some(value) => Err(format!("{key} has {value}: give a number above zero; signs have keys of their own")),
            None => Ok(values),
        }
    };
    let counts = positive("counts_per_turn", &written.counts_per_turn)?;
    let gear = positive("gear_ratio", &written.gear_ratio)?;
    let constant = positive("torque_constant_n_m_per_a", &written.torque_constant_n_m_per_a)?;
    let current = positive("full_scale_a", &written.full_scale_a)?;
    let encoder = signs("encoder_sign", &written.encoder_sign)?;
    let motor = signs("motor_sign", &written.motor_sign)?;
    let home = per_joint("home_deg", &written.home_deg)?;
    let each = |value: &dyn Fn(usize) -> f64| std::array::from_fn(|joint| if joint < joints { value(joint) as f32 } else { 0.0 });
    let mut home_counts = [0; 3];
    if let Some(given) = &written.home_counts {
        if given.len() != joints {
            return Err(number_of_values("home_counts", given.len(), kind));
        }
        home_counts.iter_mut().zip(given).for_each(|(place, counts)| *place = *counts);
    }
    let mechanism = MechanismProfile {
        kind,
        rad_per_count: each(&|joint| encoder[joint] * std::f64::consts::TAU / (counts[joint] * gear[joint])),
        full_scale_n_m: each(&|joint| motor[joint] * constant[joint] * current[joint] * gear[joint]),
        home_rad: each(&|joint| home[joint].to_radians()),
        dimensions: dimensions(kind, &written.dimensions)?,
        homing: written.homing,
    };
    Ok((mechanism, home_counts))
}

fn number_of_values(key: &str, values: usize, kind: Kind) -> String {
    format!("{key} has {values} values: a {} has {} joints, give one for each", kind.name(), kind.joints())
}

/// Dimensions in the order of the mechanism's kind.
fn dimensions(kind: Kind, given: &BTreeMap<String, Dimension>) -> Result<[f32; DIMENSIONS], String> {
    let names = kind.dimension_names();
    if let Some(unknown) = given.keys().find(|key| !names.contains(&key.as_str())) {
        return Err(format!("{unknown} is no key of a {}: it has {}", kind.name(), names.join(", ")));
    }
    let mut all = [0.0; DIMENSIONS];
    for (place, name) in all.iter_mut().zip(names) {
        *place = match given.get(*name) {
            Some(Dimension::Number(number)) => *number as f32,
            Some(Dimension::Other(_)) => return Err(format!("{name} is not a number: give one, in SI units")),
            None => return Err(format!("{name} is missing: a {} needs it", kind.name())),
        };
    }
    Ok(all)
}
