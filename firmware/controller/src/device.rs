//! The device between the board's pins and the haptic cycle: it converts a reading to a tip
//! position and a force to converter codes.
//!
//! * in: a reading of encoders or of a tip / a command to the actuators
//! * out: a tip position with the sensor's status / converter codes
//! * cost: that of [`crate::kinematics`]; some ten instructions for three orthogonal axes
//! * failures: impossible joint angles count as a failed sensor

use palpate::haptic::commission::Wiring;
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::{Vector3, square_root};

use crate::force_out::{self, ActuatorCommand, DacCode, Outputs};
use crate::kinematics::{Linkage, MechanismProfile};
use crate::probe_in::{EncoderCounts, JointReading, Reading, pose};

/// Mechanism, encoders and amplifiers.
#[derive(Clone, Copy, Debug)]
pub struct Device {
    drivetrain: Drivetrain,
    /// Encoders and motors of the axes or joints, and the ratio of each count to its nominal size.
    wiring: Wiring,
    /// Encoder counts in the home pose.
    home_counts: [i32; 3],
    /// Whether the home pose is known.
    homed: bool,
}

/// Everything between encoders and amplifiers.
#[derive(Clone, Copy, Debug)]
enum Drivetrain {
    /// Three orthogonal axes of [`EncoderCounts::LENGTH_M`] and [`DacCode::FULL_SCALE_N`].
    Axes,
    /// A mechanism that a profile describes.
    Driven(Driven),
    /// An impossible mechanism: its sensor counts as failed, and it gives no force.
    Invalid,
}

/// A mechanism with its joints.
#[derive(Clone, Copy, Debug)]
struct Driven {
    linkage: Linkage,
    rad_per_count: [f32; 3],
    home_rad: [f32; 3],
    /// Share of the converter's range per torque [1/(N m)]; zero where there is no joint.
    per_n_m: [f32; 3],
    homing: bool,
}

impl Device {
    /// Three orthogonal axes that count from the device's centre.
    pub const AXES: Self = Self { drivetrain: Drivetrain::Axes, wiring: Wiring::STRAIGHT, home_counts: [0; 3], homed: true };

    /// A device with a mechanism, or with three orthogonal axes. `home_counts` are the encoder
    /// counts in the home pose, the centre of three axes; a device with incremental encoders has to
    /// be homed first ([`Self::show_home`]).
    #[must_use]
    pub fn new(mechanism: Option<&MechanismProfile>, home_counts: [i32; 3]) -> Self {
        let Some(profile) = mechanism else { return Self { home_counts, ..Self::AXES } };
        let drivetrain = profile.build().map_or(Drivetrain::Invalid, |linkage| {
            Drivetrain::Driven(Driven {
                linkage,
                rad_per_count: profile.rad_per_count,
                home_rad: profile.home_rad,
                per_n_m: profile.full_scale_n_m.map(|full| if full == 0.0 { 0.0 } else { 1.0 / full }),
                homing: profile.homing,
            })
        });
        Self { drivetrain, wiring: Wiring::STRAIGHT, home_counts, homed: !profile.homing }
    }

    /// Sets which encoder and which motor belong to which axis or joint.
    #[must_use]
    pub fn with_wiring(self, wiring: Wiring) -> Self {
        Self { wiring, ..self }
    }

    /// Axes or joints that there are, metres at the tip per count by the profile, and share of the
    /// converter's range per newton at the tip.
    pub(crate) fn joints(&self) -> ([bool; 3], [f32; 3], [f32; 3]) {
        match &self.drivetrain {
            Drivetrain::Axes => ([true; 3], [EncoderCounts::LENGTH_M; 3], [1.0 / DacCode::FULL_SCALE_N; 3]),
            Drivetrain::Driven(driven) => driven.joints(),
            Drivetrain::Invalid => ([false; 3], [0.0; 3], [0.0; 3]),
        }
    }

    /// Returns the device with an unknown home pose. It becomes known through [`Self::show_home`],
    /// or when the host sends tip positions in place of encoder counts.
    #[must_use]
    pub const fn without_home(self) -> Self {
        Self { homed: false, ..self }
    }

    /// Whether the home pose is known; the board does not arm before that.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// Records the present joint positions as the home pose. Returns false if `reading` has no
    /// valid encoder counts.
    pub fn show_home(&mut self, reading: &Reading) -> bool {
        let Reading::Joints(JointReading { counts, status: SensorStatus::Good, .. }) = reading else { return false };
        self.home_counts = self.in_order(*counts).map(|counts| counts.0);
        self.homed = true;
        true
    }

    /// Counts in the order of the axes or joints.
    fn in_order(&self, counts: [EncoderCounts; 3]) -> [EncoderCounts; 3] {
        self.wiring.sensor.map(|sensor| counts.get(usize::from(sensor)).copied().unwrap_or(EncoderCounts(0)))
    }

    /// The mechanism at its joint angles as last read, if there is one.
    #[must_use]
    pub(crate) fn linkage(&self) -> Option<Linkage> {
        match &self.drivetrain {
            Drivetrain::Driven(driven) => Some(driven.linkage),
            Drivetrain::Axes | Drivetrain::Invalid => None,
        }
    }

    /// Restores the joint angles of an earlier reading after a reading that the cycle rejected,
    /// since torques must be computed for the pose that the force was computed for.
    pub(crate) fn go_back(&mut self, linkage: Option<Linkage>) {
        if let (Drivetrain::Driven(driven), Some(linkage)) = (&mut self.drivetrain, linkage) {
            driven.linkage = linkage;
        }
    }

    /// The encoders may have lost counts: a device with homing has to be homed again.
    pub(crate) fn forget_home(&mut self) {
        if let Drivetrain::Driven(driven) = &self.drivetrain {
            self.homed &= !driven.homing;
        }
    }

    /// The tip position for a reading, device frame. While the home pose is unknown, the device is
    /// assumed to be in it. After a failed sensor or impossible joint angles, a mechanism has to be
    /// homed again.
    pub fn sensed(&mut self, reading: &Reading) -> Sensed {
        let reading = &match *reading {
            Reading::Joints(joints) => Reading::Joints(JointReading { counts: self.in_order(joints.counts), ..joints }),
            tip @ Reading::Tip(_) => tip,
        };
        match (&mut self.drivetrain, *reading) {
            (Drivetrain::Axes, Reading::Tip(sensed)) => {
                // the host sends tip positions in the device's frame
                self.homed = true;
                sensed
            }
            (Drivetrain::Axes, Reading::Joints(JointReading { counts, sequence, status })) => {
                let from_home = since(counts, self.home_counts).map(EncoderCounts);
                let position_m = pose(from_home).tip_m.component_mul(&Vector3::from(self.wiring.per_unit));
                Sensed { position_m, sequence, status }
            }
            (Drivetrain::Driven(driven), Reading::Joints(joints)) if joints.status == SensorStatus::Good => {
                let from_home = if self.homed { since(joints.counts, self.home_counts) } else { [0; 3] };
                match driven.tip_m(from_home) {
                    Some(position_m) => Sensed { position_m, sequence: joints.sequence, status: SensorStatus::Good },
                    None => self.lost(joints.sequence),
                }
            }
            // a tip position alone does not determine the joint angles, which the torques depend on
            (_, Reading::Tip(Sensed { sequence, .. }) | Reading::Joints(JointReading { sequence, .. })) => self.lost(sequence),
        }
    }

    #[cold]
    fn lost(&mut self, sequence: u32) -> Sensed {
        self.forget_home();
        Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Failed }
    }

    /// Converter codes for a command, at the joint angles as last read. If a joint needs more than
    /// its converter can give, all codes are scaled by the same factor, so that the force keeps its
    /// direction.
    #[must_use]
    pub fn outputs(&self, drive: ActuatorCommand) -> Outputs {
        let outputs = match (&self.drivetrain, drive) {
            (Drivetrain::Axes, drive) => force_out::outputs(drive),
            (Drivetrain::Driven(driven), ActuatorCommand::Force(force_n)) => {
                Outputs { enabled: true, codes: driven.codes(force_n) }
            }
            (Drivetrain::Driven(_) | Drivetrain::Invalid, _) => Outputs::OFF,
        };
        Outputs { codes: self.by_wire(outputs.codes), ..outputs }
    }

    /// Codes in the order of the motors' wires.
    fn by_wire(&self, codes: [DacCode; 3]) -> [DacCode; 3] {
        let mut wires = [DacCode::ZERO; 3];
        for (code, (motor, sign)) in codes.into_iter().zip(self.wiring.motor.into_iter().zip(self.wiring.motor_sign)) {
            if let Some(wire) = wires.get_mut(usize::from(motor)) {
                // no code is i16::MIN
                *wire = if sign < 0.0 { DacCode(code.0.saturating_neg()) } else { code };
            }
        }
        wires
    }
}

impl Driven {
    /// As [`Device::joints`], with the levers of the home pose.
    #[inline(never)]
    fn joints(&self) -> ([bool; 3], [f32; 3], [f32; 3]) {
        let mut linkage = self.linkage;
        // the profile was checked: the mechanism can be in its home pose
        let _possible = linkage.tip_m(self.home_rad);
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| Vector3::from(linkage.torques_n_m(axis)));
        let squares = x.component_mul(&x) + y.component_mul(&y) + z.component_mul(&z);
        let levers_m: [f32; 3] = squares.map(square_root).into();
        let (mut stated, mut shares) = (levers_m, levers_m);
        stated.iter_mut().zip(self.rad_per_count).for_each(|(lever, rad)| *lever *= rad.abs());
        shares.iter_mut().zip(self.per_n_m).for_each(|(lever, per_n_m)| *lever *= per_n_m.abs());
        (self.per_n_m.map(|per_n_m| per_n_m != 0.0), stated, shares)
    }

    #[inline(never)]
    fn tip_m(&mut self, from_home: [i32; 3]) -> Option<Vector3<f32>> {
        let [a, b, c] = from_home.map(|counts| counts as f32);
        let ([per_a, per_b, per_c], [home_a, home_b, home_c]) = (self.rad_per_count, self.home_rad);
        self.linkage.tip_m([home_a + a * per_a, home_b + b * per_b, home_c + c * per_c])
    }

    #[inline(never)]
    fn codes(&self, force_n: Vector3<f32>) -> [DacCode; 3] {
        let ([a, b, c], [per_a, per_b, per_c]) = (self.linkage.torques_n_m(force_n), self.per_n_m);
        let shares = [a * per_a, b * per_b, c * per_c];
        if !shares.iter().all(|share| share.is_finite()) {
            return [DacCode::ZERO; 3];
        }
        let most = shares.iter().fold(1.0_f32, |most, share| most.max(share.abs()));
        shares.map(|share| DacCode::from_share(share / most))
    }
}

/// Counts relative to those in the home pose; the counters wrap.
fn since(counts: [EncoderCounts; 3], home: [i32; 3]) -> [i32; 3] {
    let ([a, b, c], [home_a, home_b, home_c]) = (counts, home);
    [a.0.wrapping_sub(home_a), b.0.wrapping_sub(home_b), c.0.wrapping_sub(home_c)]
}
