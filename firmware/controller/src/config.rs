//! The profile that a board keeps while it is without power: two slots of flash, written
//! alternately.
//!
//! A slot is `magic, version, length, generation, profile as postcard, CRC-32`. A new profile is
//! written to the slot that is not in use: if the power fails, the other one still contains the
//! previous profile. A slot that is damaged, of another version or out of range counts as empty.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use palpate::BuildError;
use palpate::haptic::commission::Wiring;
use palpate::haptic::cycle::{Cycle, Settings};
use palpate::haptic::device::{DeviceSpec, HapticDevice};
use serde::{Deserialize, Serialize};

use crate::device::Device;
use crate::force_out::DacCode;
use crate::kinematics::{MechanismError, MechanismProfile};
use crate::port::Port;
use crate::wire_limits::WireLimits;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
const MAGIC: u32 = 0x5041_4C50;
const VERSION: u16 = 5;
const HEAD: usize = 12;
const TAIL: usize = 4;
/// Length of a slot's content [bytes]: head, profile, checksum and erased bytes.
pub const SLOT_BYTES: usize = 256;

/// Settings that a user makes once for a device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Limits of the loop.
    pub limits: WireLimits,
    /// Damping per tangent stiffness [s], constant damping [N s/m], share of the newest velocity
    /// (1).
    pub damping: [f32; 3],
    /// Largest force that the actuators can give [N].
    pub max_force_n: f32,
    /// Whole ticks from the computation of a force until it acts.
    pub delay_ticks: u8,
    /// Corners of the workspace with the smallest and the largest coordinates [m].
    pub workspace_m: [[f32; 3]; 2],
    /// One encoder count at the probe [m]; zero for an ideal sensor.
    pub count_m: f32,
    /// Time constant of amplifier and motor [s].
    pub lag_s: f32,
    /// Mass of the handle at the probe [kg].
    pub mass_kg: f32,
    /// Largest contact stiffness that the device renders without a limit cycle [N/m].
    pub stiffness_ceiling_n_per_m: f32,
    /// Day on which the device was commissioned, in days since 1970-01-01; zero if it was not.
    pub commissioned_day: u16,
    /// Encoder and motor of each axis or joint, ratio of each count to its nominal size (10 um on
    /// three orthogonal axes), and sign of each motor.
    pub wiring: WireOrder,
    /// Encoder counts in the mechanism's home pose, or at the centre of three orthogonal axes.
    pub home_counts: [i32; 3],
    /// A hand switch or pedal is fitted; there is a force only while it is pressed.
    pub operator_switch: bool,
    /// Mechanism; without one the device has three orthogonal axes of 10 um per count and 16 N at
    /// full scale.
    pub mechanism: Option<MechanismProfile>,
}

/// [`Wiring`] as it is stored and sent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireOrder {
    /// Encoder of each axis or joint.
    pub encoder: [u8; 3],
    /// Ratio of each count to its nominal size (1); negative where the encoder counts down.
    pub ratio: [f32; 3],
    /// Motor of each axis or joint.
    pub motor: [u8; 3],
    /// 1, or -1 where a positive code drives the axis backwards.
    pub motor_sign: [i8; 3],
}

impl WireOrder {
    /// Encoders and motors in the order of the axes, with the right signs.
    pub const STRAIGHT: Self = Self { encoder: [0, 1, 2], ratio: [1.0; 3], motor: [0, 1, 2], motor_sign: [1; 3] };
}

impl From<WireOrder> for Wiring {
    fn from(order: WireOrder) -> Self {
        let motor_sign = order.motor_sign.map(f32::from);
        Self { sensor: order.encoder, per_unit: order.ratio, motor: order.motor, motor_sign }
    }
}

impl Profile {
    /// The desktop stylus with safe damping.
    #[must_use]
    pub fn desktop() -> Self {
        let device = Port::DESKTOP.limits();
        Self::of(&Settings::safe(&device), &device)
    }

    /// Creates the profile of a device without a mechanism. Limits and damping come from
    /// `settings`; everything else becomes [`Settings::safe`] when the profile is used.
    #[must_use]
    pub fn of(settings: &Settings, device: &DeviceSpec) -> Self {
        let damping = settings.damping;
        Self {
            limits: (&settings.limits).into(),
            damping: [damping.tau_s, damping.constant_n_s_per_m, damping.velocity_share],
            max_force_n: device.max_force_n,
            delay_ticks: device.delay_ticks,
            workspace_m: [device.workspace_low_m.into(), device.workspace_high_m.into()],
            count_m: device.count_m,
            lag_s: device.lag_s,
            mass_kg: device.mass_kg,
            stiffness_ceiling_n_per_m: device.stiffness_ceiling_n_per_m,
            commissioned_day: u16::from(device.commissioned),
            wiring: WireOrder::STRAIGHT,
            home_counts: [0; 3],
            operator_switch: false,
            mechanism: None,
        }
    }

    /// Splits the profile into the settings of the loop and the device.
    #[must_use]
    pub fn split(&self) -> (Settings, Port) {
        let [low_m, high_m] = self.workspace_m.map(Into::into);
        let limits = DeviceSpec {
            max_force_n: self.max_force_n,
            workspace_low_m: low_m,
            workspace_high_m: high_m,
            count_m: self.count_m,
            delay_ticks: self.delay_ticks,
            lag_s: self.lag_s,
            mass_kg: self.mass_kg,
            stiffness_ceiling_n_per_m: self.stiffness_ceiling_n_per_m,
            commissioned: self.commissioned_day != 0,
        };
        let mut settings = Settings::safe(&limits);
        settings.limits = (&self.limits).into();
        let [tau_s, constant_n_s_per_m, velocity_share] = self.damping;
        settings.damping.tau_s = tau_s;
        settings.damping.constant_n_s_per_m = constant_n_s_per_m;
        settings.damping.velocity_share = velocity_share;
        let device = Device::new(self.mechanism.as_ref(), self.home_counts).with_wiring(self.wiring.into());
        (settings, Port::with_limits(limits).with_device(device).with_operator_switch(self.operator_switch))
    }

    /// Checks that every number is in range and that the mechanism can move as the profile says.
    ///
    /// # Errors
    /// [`ProfileError`] names the first condition that is not met.
    #[inline(never)]
    pub fn check(&self) -> Result<(), ProfileError> {
        let (settings, edge) = self.split();
        let (value, max) = (self.max_force_n, DacCode::FULL_SCALE_N);
        if value > max {
            let range = BuildError::OutOfRange { parameter: "max_force_n of the converters", value, min: 0.0, max };
            return Err(ProfileError::Range(range));
        }
        Cycle::build(&settings, &edge.limits()).map_err(ProfileError::Range)?;
        Wiring::from(self.wiring).check().map_err(ProfileError::Range)?;
        self.mechanism.map_or(Ok(()), |mechanism| mechanism.check(&edge.limits()).map_err(ProfileError::Mechanism))
    }
}

/// Two slots of flash. Erased bytes are 0xFF; a written byte keeps its value until its slot is
/// erased.
pub trait Flash {
    /// Copies the first [`SLOT_BYTES`] of a slot.
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]);

    /// Erases a slot.
    ///
    /// # Errors
    /// The flash reports a failure.
    fn erase(&mut self, slot: Slot) -> Result<(), FlashError>;

    /// Writes the first [`SLOT_BYTES`] of an erased slot.
    ///
    /// # Errors
    /// The flash reports a failure.
    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError>;
}

/// Flash that did not erase or write as commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashError;

/// One of the two places in flash that hold a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The slot for the first profile in erased flash.
    A,
    /// The slot for the second profile.
    B,
}

impl Slot {
    fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// Returns the newest profile that is complete and in range, its slot and its generation; `None` if
/// there is none.
#[must_use]
pub fn load(flash: &impl Flash) -> Option<(Profile, Slot, u32)> {
    let good = |slot| {
        let mut bytes = [0; SLOT_BYTES];
        flash.read(slot, &mut bytes);
        let (profile, generation) = parse(&bytes)?;
        Some((profile, slot, generation))
    };
    match (good(Slot::A), good(Slot::B)) {
        (Some(a), Some(b)) => Some(if a.2.wrapping_sub(b.2).cast_signed() > 0 { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// Stores a profile and returns its generation; called in `Idle`. The previous profile remains
/// valid until this one is complete.
///
/// # Errors
/// [`StoreError`]; the previous profile remains valid.
pub fn store(flash: &mut impl Flash, profile: &Profile) -> Result<u32, StoreError> {
    profile.check().map_err(StoreError::Profile)?;
    let (slot, generation) = load(flash).map_or((Slot::A, 1), |(_, slot, last)| (slot.other(), last.wrapping_add(1)));
    let mut bytes = [0xFF; SLOT_BYTES];
    format(&mut bytes, profile, generation).ok_or(StoreError::Flash)?;
    let failed = |FlashError| StoreError::Flash;
    flash.erase(slot).map_err(failed)?;
    flash.write(slot, &bytes).map_err(failed)?;
    match load(flash) {
        Some((read, _, found)) if (read, found) == (*profile, generation) => Ok(generation),
        _ => Err(StoreError::Flash),
    }
}

/// Why a profile was not stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoreError {
    /// The profile failed [`Profile::check`].
    Profile(ProfileError),
    /// The flash did not erase, write or return the profile as commanded.
    Flash,
}

/// Why a profile is invalid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfileError {
    /// A number is out of its range.
    Range(BuildError),
    /// The mechanism is impossible, or cannot move as the profile says.
    Mechanism(MechanismError),
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::Mechanism(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ProfileError {}

/// Writes head, profile and checksum of a slot; `None` if they do not fit.
#[inline(never)]
pub(crate) fn format(bytes: &mut [u8; SLOT_BYTES], profile: &Profile, generation: u32) -> Option<()> {
    let (head, body) = bytes.split_at_mut(HEAD);
    let length = postcard::to_slice(profile, body).ok()?.len();
    head.get_mut(..4)?.copy_from_slice(&MAGIC.to_le_bytes());
    head.get_mut(4..6)?.copy_from_slice(&VERSION.to_le_bytes());
    head.get_mut(6..8)?.copy_from_slice(&u16::try_from(length).ok()?.to_le_bytes());
    head.get_mut(8..)?.copy_from_slice(&generation.to_le_bytes());
    let end = HEAD + length;
    let crc = CRC.checksum(bytes.get(..end)?);
    bytes.get_mut(end..end + TAIL)?.copy_from_slice(&crc.to_le_bytes());
    Some(())
}

#[inline(never)]
pub(crate) fn parse(bytes: &[u8; SLOT_BYTES]) -> Option<(Profile, u32)> {
    let (magic, rest) = bytes.split_first_chunk()?;
    let (version, rest) = rest.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (generation, rest) = rest.split_first_chunk()?;
    if u32::from_le_bytes(*magic) != MAGIC || u16::from_le_bytes(*version) != VERSION {
        return None;
    }
    let length = usize::from(u16::from_le_bytes(*length));
    let crc = rest.get(length..)?.first_chunk()?;
    if CRC.checksum(bytes.get(..HEAD + length)?) != u32::from_le_bytes(*crc) {
        return None;
    }
    let (profile, rest): (Profile, _) = postcard::take_from_bytes(rest.get(..length)?).ok()?;
    (rest.is_empty() && profile.check().is_ok()).then(|| (profile, u32::from_le_bytes(*generation)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Kind;

    struct Ram([[u8; SLOT_BYTES]; 2]);

    impl Flash for Ram {
        fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
            *bytes = self.0[slot as usize];
        }

        fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
            self.0[slot as usize] = [0xFF; SLOT_BYTES];
            Ok(())
        }

        fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
            self.0[slot as usize] = *bytes;
            Ok(())
        }
    }

    #[test]
    fn a_profile_out_of_range_is_neither_kept_nor_read_back() {
        let spoil: [fn(&mut Profile); 4] = [
            |profile| profile.max_force_n = 1e3,
            |profile| profile.limits.scalars[0] = f32::NAN,
            |profile| profile.limits.counts[0] = 0,
            |profile| profile.damping[0] = -1.0,
        ];
        for (n, spoil) in spoil.into_iter().enumerate() {
            let mut bad = Profile::desktop();
            spoil(&mut bad);
            let mut flash = Ram([[0xFF; SLOT_BYTES]; 2]);
            assert!(matches!(store(&mut flash, &bad), Err(StoreError::Profile(_))), "{n}");
            // complete and with a correct checksum, as an older version may have written it
            format(&mut flash.0[0], &bad, 7).unwrap();
            assert_eq!(load(&flash), None, "{n}");
        }
    }

    #[test]
    fn wherever_an_erasure_or_a_write_is_cut_off_the_profile_before_stays() {
        let profile = |day| Profile { commissioned_day: day, ..Profile::desktop() };
        let mut before = Ram([[0xFF; SLOT_BYTES]; 2]);
        assert_eq!([1, 2].map(|day| store(&mut before, &profile(day))), [Ok(1), Ok(2)]);
        let mut complete = Ram(before.0);
        assert_eq!(store(&mut complete, &profile(3)), Ok(3));
        let (old, new, erased) = (before.0[0], complete.0[0], [0xFF; SLOT_BYTES]);
        for (from, to) in [(old, erased), (erased, new)] {
            for (cut, half) in (0..SLOT_BYTES).flat_map(|cut| [0x00, 0x0F, 0xAA, 0xFF].map(|half| (cut, half))) {
                let mut flash = Ram(before.0);
                flash.0[0][..cut].copy_from_slice(&to[..cut]);
                flash.0[0][cut] = from[cut] & !half | to[cut] & half;
                flash.0[0][cut + 1..].copy_from_slice(&from[cut + 1..]);
                let day = if flash.0[0] == new { 3 } else { 2 };
                let kept = load(&flash).map(|kept| kept.0.commissioned_day);
                assert_eq!(kept, Some(day), "cut off in byte {cut}, {half:x}");
                assert!(store(&mut flash, &profile(4)).is_ok(), "and the next one is stored");
            }
        }
    }

    #[test]
    fn the_longest_profile_fits_its_slot_and_comes_back() {
        let device = Port::DESKTOP.limits();
        let mut profile = Profile::of(&Settings::safe(&device), &device);
        (profile.home_counts, profile.operator_switch) = ([i32::MIN; 3], true);
        profile.commissioned_day = u16::MAX;
        profile.wiring = WireOrder { encoder: [2, 0, 1], ratio: [-1.0; 3], motor: [1, 2, 0], motor_sign: [-1; 3] };
        let (kind, large) = (Kind::YourDevice, [0.05, 0.1, 0.2]);
        let dimensions = [0.2, 0.2, 0.2, 0.0, 0.0];
        let (rad_per_count, home_rad) = ([5e-5; 3], [0.0; 3]);
        profile.mechanism = Some(MechanismProfile {
            kind,
            rad_per_count,
            full_scale_n_m: large.map(|n: f32| 10.0 * n),
            home_rad,
            dimensions,
            homing: true,
        });
        profile.count_m = 1e-5;
        profile.max_force_n = 2.5;
        profile.limits.scalars[0] = 2.0;
        let mut flash = Ram([[0xFF; SLOT_BYTES]; 2]);
        assert_eq!(store(&mut flash, &profile), Ok(1));
        assert_eq!(load(&flash).map(|kept| kept.0), Some(profile));
        let mut out = [0; crate::link::FRAME_BYTES];
        assert!(crate::link::encode(1, &crate::link::ToBoard::Store(profile), &mut out).is_ok(), "and fits a frame");
        assert!(profile.split().1.operator_switch());
    }
}
