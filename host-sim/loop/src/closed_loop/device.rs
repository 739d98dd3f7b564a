//! Devices as data, read from a profile file.

use std::path::Path;

use palpate::Vector3;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::limits::LoopLimitSettings;
use serde::Deserialize;

use super::wiring::WiringTable;
use crate::day::day_of;
use palpate_tissue::error::Error;
use palpate_tissue::exact;
use palpate_tissue::scene::SceneError;

/// The profiles that ship, by name; the first is the default.
pub const PROFILES: [(&str, &str); 8] = [
    ("touch", include_str!("../../../devices/touch.toml")),
    ("omni", include_str!("../../../devices/omni.toml")),
    ("touch-x", include_str!("../../../devices/touch-x.toml")),
    ("falcon", include_str!("../../../devices/falcon.toml")),
    ("omega3", include_str!("../../../devices/omega3.toml")),
    ("inverse3", include_str!("../../../devices/inverse3.toml")),
    ("hapkit", include_str!("../../../devices/hapkit.toml")),
    ("frictionless", include_str!("../../../devices/frictionless.toml")),
];

/// Profile of a haptic device.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct DeviceProfile {
    /// Name in tables and pictures.
    pub name: String,
    /// Source of the numbers.
    pub source: String,
    /// Number of axes along which the device moves: 3, or 1 for a paddle, which moves only in the
    /// direction of the press.
    pub axes: u8,
    /// Largest force that the device can exert in every direction [N].
    pub max_force_n: f64,
    /// Largest force that the loop outputs [N].
    pub force_limit_n: f64,
    /// Largest stiffness that the manufacturer specifies [N/m].
    pub stiffness_ceiling_n_per_m: f64,
    /// One encoder count at the probe [m]; zero for an ideal sensor.
    pub count_m: f64,
    /// Mass at the probe [kg].
    #[serde(default = "lightest_kg")]
    pub mass_kg: f64,
    /// Viscous friction [N s/m].
    pub damping_n_s_per_m: f64,
    /// Coulomb friction [N].
    #[serde(default)]
    pub friction_n: f64,
    /// Time constant of amplifier and motor [s].
    #[serde(default = "long_lag_s")]
    pub amplifier_lag_s: f64,
    /// Delay from computing a force to its arrival at the amplifier, in whole ticks.
    pub delay_ticks: u8,
    /// Sides of the workspace [m], centred on the site.
    pub workspace_m: [f64; 3],
    /// Whether a hand switch or a pedal is wired to the board and must be held for any force to
    /// act; the desktop's loop ignores it.
    #[serde(default)]
    pub operator_switch: bool,
    /// Joints, motors and dimensions, for a board that reads the encoders of the joints; the
    /// desktop's loop uses only the motion of the probe.
    #[serde(default)]
    pub mechanism: Option<toml::Table>,
    /// Day on which sign, order, unit, friction, delay and lag were measured on the device itself,
    /// such as "2026-11-27". Without it a real device gets half a newton at most; the emulated one
    /// is what the profile says in any case.
    #[serde(default)]
    pub commissioned: Option<String>,
    /// Sensors and motors of the axes, as the commissioning found them.
    #[serde(default)]
    pub wiring: Option<WiringTable>,
    /// Text of the file.
    #[serde(skip)]
    pub text: String,
}

/// The lightest handle of a desktop device [kg]: that of a small pantograph. A light handle is
/// accelerated most by its own motors.
fn lightest_kg() -> f64 {
    LIGHTEST_KG
}

/// A long lag of amplifier and motor [s]: voltage-driven motors without current control have it.
/// The loop damps more for a longer lag, so a shorter one than assumed does no harm.
fn long_lag_s() -> f64 {
    LONG_LAG_S
}

const LIGHTEST_KG: f64 = 0.03;
const LONG_LAG_S: f64 = 3e-3;

impl DeviceProfile {
    /// Loads a profile by name, or from a file.
    ///
    /// # Errors
    /// No profile has this name, or the file has an unknown key or a number out of range; the
    /// message names key and line.
    pub fn load(name_or_file: &str) -> Result<Self, Error> {
        if let Some((name, text)) = PROFILES.iter().find(|(name, _)| *name == name_or_file) {
            return Self::parse(text, name);
        }
        let path = Path::new(name_or_file);
        if path.extension().is_none_or(|e| e != "toml") {
            let names: Vec<&str> = PROFILES.iter().map(|p| p.0).collect();
            return Err(Error::Usage(format!(
                "device \"{name_or_file}\" is no profile: give one of {}, or the path of a .toml file",
                names.join(", ")
            )));
        }
        let text = std::fs::read_to_string(path).map_err(|source| Error::Read { path: path.into(), source })?;
        Self::parse(&text, name_or_file)
    }

    pub(crate) fn parse(text: &str, file: &str) -> Result<Self, Error> {
        let like = "profiles under host-sim/devices";
        let refused = |error| Error::Usage(SceneError::of_toml_like(like, file, text, &error).to_string());
        let mut profile: Self = exact::from_toml(text).map_err(refused)?;
        profile.check(&|key| {
            let line = text.lines().position(|l| l.trim_start().starts_with(key)).map_or(1, |n| n + 1);
            format!("{file}:{line}: {key}")
        })?;
        profile.text = text.into();
        Ok(profile)
    }

    /// Checks that every number is in its range; `place` returns the position of a key in the file.
    ///
    /// # Errors
    /// Returns the first number that is out of range, with its position.
    pub fn check(&self, place: &dyn Fn(&str) -> String) -> Result<(), Error> {
        let sides = self.workspace_m.map(|side| ("workspace_m", side, 0.02, 2.0));
        for (key, value, least, most) in [
            ("axes", f64::from(self.axes), 1.0, 3.0),
            ("max_force_n", self.max_force_n, 0.01, 20.0),
            ("force_limit_n", self.force_limit_n, 0.01, self.max_force_n),
            ("stiffness_ceiling_n_per_m", self.stiffness_ceiling_n_per_m, 1.0, 1e5),
            ("count_m", self.count_m, 0.0, 1e-3),
            ("mass_kg", self.mass_kg, 1e-3, 5.0),
            ("damping_n_s_per_m", self.damping_n_s_per_m, 0.0, 50.0),
            ("friction_n", self.friction_n, 0.0, 5.0),
            ("amplifier_lag_s", self.amplifier_lag_s, 0.0, f64::from(DeviceSpec::MOST_LAG_S)),
            ("delay_ticks", f64::from(self.delay_ticks), 0.0, f64::from(DeviceSpec::MOST_DELAY_TICKS)),
        ]
        .into_iter()
        .chain(sides)
        {
            // NaN is outside every range
            if !(least <= value && value <= most) {
                // some ranges are single precision: 0.006, not 0.006000000052
                let (place, least, most) = (place(key), least as f32, most as f32);
                return Err(Error::Usage(format!("{place} = {value} is outside {least} .. {most}: give a number in that range")));
            }
        }
        if let Some(day) = &self.commissioned
            && day_of(day).is_none()
        {
            let place = place("commissioned");
            return Err(Error::Usage(format!(
                "{place} = \"{day}\" is no day: give one such as \"2026-11-27\", or leave the key out"
            )));
        }
        if let Some(wiring) = &self.wiring
            && let Err(cause) = wiring.wiring().check()
        {
            return Err(Error::Usage(format!("{}: {cause}", place("[wiring]"))));
        }
        if self.axes == 2 {
            return Err(Error::Usage(format!("{} = 2 is not emulated: give 1 or 3", place("axes"))));
        }
        Ok(())
    }

    /// Returns the limits of the emulated device for the loop, with the workspace centred on a site
    /// [m].
    #[must_use]
    pub fn limits(&self, site_m: Vector3<f32>) -> DeviceSpec {
        let half = Vector3::from(self.workspace_m.map(|side| 0.5 * side as f32));
        DeviceSpec {
            max_force_n: self.max_force_n as f32,
            workspace_low_m: site_m - half,
            workspace_high_m: site_m + half,
            count_m: self.count_m as f32,
            delay_ticks: self.delay_ticks,
            lag_s: self.amplifier_lag_s as f32,
            mass_kg: self.mass_kg as f32,
            stiffness_ceiling_n_per_m: self.stiffness_ceiling_n_per_m as f32,
            commissioned: true,
        }
    }

    /// Returns the limits of the real device, which was commissioned only if its profile says so.
    #[must_use]
    pub fn real_limits(&self, site_m: Vector3<f32>) -> DeviceSpec {
        DeviceSpec { commissioned: self.commissioned.is_some(), ..self.limits(site_m) }
    }

    /// Values that the profile does not state, with the cautious one that is taken, one sentence
    /// each.
    #[must_use]
    pub fn assumed(&self) -> Vec<String> {
        let keys = self.text.parse::<toml::Table>().unwrap_or_default();
        let absent = |key: &str| !self.text.is_empty() && !keys.contains_key(key);
        let mut sentences = Vec::new();
        if absent("friction_n") {
            sentences.push("friction_n is not in the profile: no friction is assumed".into());
        }
        if absent("mass_kg") {
            sentences.push(format!("mass_kg is not in the profile: the lightest handle is assumed, {LIGHTEST_KG} kg"));
        }
        if absent("amplifier_lag_s") {
            sentences.push(format!("amplifier_lag_s is not in the profile: a long lag is assumed, {LONG_LAG_S} s"));
        }
        sentences
    }

    /// As [`Self::assumed`], and what a real device gets that was not commissioned.
    #[must_use]
    pub fn cautions(&self) -> Vec<String> {
        let mut sentences = self.assumed();
        if self.commissioned.is_none() {
            sentences.push(format!(
                "the profile is not commissioned: the force is at most {} N until its signs, units and delays are measured (`palpate board commission`, or the call `commission` of a session)",
                DeviceSpec::UNCOMMISSIONED_N
            ));
        }
        sentences
    }

    /// Limits of the loop on this device.
    #[must_use]
    pub fn limit_values(&self) -> LoopLimitSettings {
        LoopLimitSettings { max_force_n: self.force_limit_n as f32, ..LoopLimitSettings::DESKTOP }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_profile_reads_and_is_told_apart() {
        let all = PROFILES.map(|(name, _)| DeviceProfile::load(name).unwrap());
        for (profile, (name, _)) in all.iter().zip(PROFILES) {
            assert!(profile.limits(Vector3::zeros()).check().is_ok(), "{name}");
            assert!(profile.source.len() > 20, "{name} says where its numbers are from");
            assert_eq!(all.iter().filter(|p| p.name == profile.name).count(), 1);
        }
    }

    #[test]
    fn an_impossible_number_and_an_unknown_key_are_named_with_their_line() {
        let (_, text) = PROFILES[0];
        for (from, to, says) in [
            ("mass_kg", "mass_kg = -1.0 #", "mass_kg = -1"),
            ("count_m", "count_m = nan #", "count_m = NaN"),
            ("max_force_n", "max_force_n = 1e9 #", "max_force_n"),
            ("delay_ticks", "delay_ticks = 9 #", "delay_ticks = 9"),
            ("workspace_m", "workspace_m = [0.1, nan, 0.1] #", "workspace_m = NaN"),
            ("workspace_m", "workspace_m = [0.1, 0.1, 0.1, 0.1] #", "workspace_m is a list of length 4: give 3 entries"),
            ("delay_ticks", "delay_ticks = -1 #", "delay_ticks: invalid value: integer `-1`"),
            ("friction_n", "frictoin_n", "unknown key \"frictoin_n\": did you mean \"friction_n\"?"),
        ] {
            let bad = text.replacen(from, to, 1);
            let line = bad.lines().position(|l| l.starts_with(to)).unwrap() + 1;
            let said = DeviceProfile::parse(&bad, "my.toml").unwrap_err().to_string();
            assert!(said.contains(says) && said.starts_with(&format!("my.toml:{line}:")), "{said}");
        }
    }
}
