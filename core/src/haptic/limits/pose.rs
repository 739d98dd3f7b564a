//! Accepts, holds or rejects each sensor reading.
//!
//! A single reading that no hand can have caused is a glitch: the last good pose is held, so that
//! the glitch does not affect the force. Two in a row mean a hand out of control or a broken
//! sensor. Displacement is measured from the last *accepted* pose, so a jump there and back counts
//! once.
//!
//! Bad readings between good ones are counted as well: more than one in twenty that is missing, or
//! jumps while a force acts, means a broken cable or encoder, whatever the readings between them
//! say.
//!
//! * in: a reading, whether a force acts on the hand
//! * out: position [m], whether it is new
//! * cost: up to 145 instructions of a Cortex-M4F
//! * failures: [`Fault::SensorFault`], [`Fault::PoseNotFinite`], [`Fault::PoseStale`],
//!   [`Fault::OverSpeed`], [`Fault::OutOfWorkspace`]

use nalgebra::Vector3;

use super::LoopLimits;
use super::freeze::Freeze;
use crate::fault::Fault;
use crate::haptic::device::{Sensed, SensorStatus};
use crate::haptic::length;

/// A pose that was accepted or held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Tip [m], patch frame.
    pub position_m: Vector3<f32>,
    /// The pose is an older one: the newest reading is missing or a glitch.
    pub held: bool,
    /// Ticks since the reading before it, or, if it is held, since that one.
    pub ticks: u16,
}

/// Accepts, holds or rejects the readings, one per tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct PoseGate {
    believed_m: Option<Vector3<f32>>,
    sequence: Option<u32>,
    /// Ticks since a new reading came.
    age_ticks: u16,
    /// Ticks since a reading was accepted.
    since_ticks: u16,
    /// Implausible readings in a row.
    odd: u16,
    /// Readings that are missing or that jumped while a force acted.
    bad: Share,
    freeze: Freeze,
}

/// Ticks that one bad reading counts for: more than one bad reading in that many ticks is too many.
/// Source: derived; the hand misses a twentieth of the motion at most, less than the 7 % of a force
/// that it can tell (Jones, Perception 18, 1989). At 15 and at 25
/// `readings_that_are_missing_or_jump_too_often_are_a_fault_and_now_and_then_they_are_not` fails.
const TICKS_PER_BAD: u16 = 20;
/// Ticks counted above which the share is too large: 25 bad readings at once, or every third
/// reading for a tenth of a second.
/// Source: chosen; twenty bad readings within 40 ticks, once a second, are borne, and every third
/// reading is not for longer than 0.1 s: at 300 and at 650 the same test fails.
const TOO_MANY: u16 = 500;

/// Counts bad readings; the count decays at the permitted rate.
#[derive(Clone, Copy, Debug, Default)]
struct Share(u16);

impl Share {
    /// Runs one tick; returns true if it is one bad reading too many.
    fn count(&mut self, bad: bool) -> bool {
        self.0 = self.0.saturating_sub(1);
        if bad && self.0 <= TOO_MANY {
            self.0 += TICKS_PER_BAD;
        }
        bad && self.0 > TOO_MANY
    }
}

impl PoseGate {
    /// Takes one reading per tick. After a fault the next good reading is accepted wherever it is.
    ///
    /// # Errors
    /// Fails with the faults that the module lists. `force_acts` decides whether speed is a fault:
    /// without a force, a fast hand is merely tracked.
    pub fn admit(&mut self, limits: &LoopLimits, sensed: &Sensed, force_acts: bool) -> Result<Pose, Fault> {
        let answer = self.judge(limits, sensed, force_acts);
        if answer.is_err() {
            // this resets the sequence number too: a sensor or a host that restarts may count from
            // any number
            *self = Self::default();
        }
        answer
    }

    /// Counts periods that passed without a cycle, in which the hand may have moved further.
    pub fn skip(&mut self, late_ticks: u16) {
        self.since_ticks = self.since_ticks.saturating_add(late_ticks);
    }

    /// The position of a reading [m]; `None` if it is bad or not newer than the last one.
    #[must_use]
    pub fn news(&self, sensed: &Sensed) -> Option<Vector3<f32>> {
        // signed difference: a lower number is an old reading, and the count may wrap
        let newer = self.sequence.is_none_or(|last| sensed.sequence.wrapping_sub(last).cast_signed() > 0_i32);
        let good = sensed.status == SensorStatus::Good && sensed.position_m.iter().all(|c| c.is_finite());
        (newer && good).then_some(sensed.position_m)
    }

    fn judge(&mut self, limits: &LoopLimits, sensed: &Sensed, force_acts: bool) -> Result<Pose, Fault> {
        if sensed.status != SensorStatus::Good {
            return Err(Fault::SensorFault);
        }
        if !sensed.position_m.iter().all(|c| c.is_finite()) {
            return Err(Fault::PoseNotFinite);
        }
        self.since_ticks = self.since_ticks.saturating_add(1);
        let ticks = self.since_ticks;
        if self.news(sensed).is_none() {
            if self.bad.count(true) && force_acts {
                return Err(Fault::PoseStale);
            }
            self.age_ticks = self.age_ticks.saturating_add(1);
            return match self.believed_m {
                Some(position_m) if self.age_ticks <= limits.values.max_age_ticks => Ok(Pose { position_m, held: true, ticks }),
                _ => Err(Fault::PoseStale),
            };
        }
        (self.sequence, self.age_ticks) = (Some(sensed.sequence), 0);

        if let Some(position_m) = self.believed_m {
            let most_m = limits.displacement_m * f32::from(self.since_ticks) + limits.counts_m;
            let jumped = length(&(sensed.position_m - position_m)) > most_m;
            // in free space a hand may be faster than one that feels a force
            if self.bad.count(jumped && force_acts) {
                return Err(Fault::SensorFault);
            }
            if jumped {
                self.odd = self.odd.saturating_add(1);
                if self.odd < limits.values.odd_poses {
                    return Ok(Pose { position_m, held: true, ticks });
                }
                if force_acts {
                    return Err(Fault::OverSpeed);
                }
            }
            let displacement_m = sensed.position_m - position_m;
            self.freeze.judge(limits, &sensed.position_m, &displacement_m, self.since_ticks, force_acts)?;
        }
        let inside = (0..3).all(|k| limits.low_m[k] <= sensed.position_m[k] && sensed.position_m[k] <= limits.high_m[k]);
        if !inside {
            return Err(Fault::OutOfWorkspace);
        }
        self.believed_m = Some(sensed.position_m);
        (self.since_ticks, self.odd) = (0, 0);
        Ok(Pose { position_m: sensed.position_m, held: false, ticks })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::limits;
    use super::*;

    fn at(z_m: f32, sequence: u32) -> Sensed {
        Sensed { position_m: Vector3::new(0.0, 0.0, z_m), sequence, status: SensorStatus::Good }
    }

    /// A gate that has accepted z = 0 with the sequence number 0.
    fn gate() -> PoseGate {
        let mut gate = PoseGate::default();
        gate.admit(&limits(), &at(0.0, 0), true).unwrap();
        gate
    }

    #[test]
    fn one_glitch_is_held_two_are_a_fault() {
        let (limits, mut gate) = (limits(), gate());
        assert_eq!(gate.admit(&limits, &at(0.05, 1), true), Ok(Pose { position_m: Vector3::zeros(), held: true, ticks: 1 }));
        assert!(!gate.admit(&limits, &at(0.001, 2), true).unwrap().held, "back again");
        gate.admit(&limits, &at(0.05, 3), true).unwrap();
        assert_eq!(gate.admit(&limits, &at(0.05, 4), true), Err(Fault::OverSpeed));
    }

    #[test]
    fn speed_is_a_fault_only_while_a_force_acts() {
        for (force_acts, step_m, ends) in [(true, 1.7e-3, true), (true, 1.5e-3, false), (false, 10e-3, false)] {
            let (limits, mut gate) = (limits(), gate());
            let faults = (1..6_u8).filter(|&n| gate.admit(&limits, &at(step_m * f32::from(n), n.into()), force_acts).is_err());
            assert_eq!(faults.count() > 0, ends, "{step_m} m a tick, force {force_acts}");
        }
    }

    #[test]
    fn a_reading_that_repeats_or_goes_back_is_old() {
        for sequence in [0, u32::MAX, 0x8000_0001] {
            let (limits, mut gate) = (limits(), gate());
            for _ in 0..2 {
                assert!(gate.admit(&limits, &at(1e-4, sequence), true).unwrap().held);
            }
            assert_eq!(gate.admit(&limits, &at(1e-4, sequence), true), Err(Fault::PoseStale));
        }
        let (limits, mut gate) = (limits(), PoseGate::default());
        gate.admit(&limits, &at(0.0, u32::MAX), true).unwrap();
        assert!(!gate.admit(&limits, &at(0.0, 0), true).unwrap().held, "the count wraps");
    }

    #[test]
    fn a_pose_outside_the_workspace_and_a_bad_sensor() {
        let (limits, mut gate) = (limits(), PoseGate::default());
        assert!(gate.admit(&limits, &at(0.0719, 0), true).is_ok(), "a tenth of 0.12 m beyond 0.06 m");
        assert_eq!(gate.admit(&limits, &at(0.0721, 1), true), Err(Fault::OutOfWorkspace));
        assert_eq!(gate.admit(&limits, &at(f32::NAN, 2), true), Err(Fault::PoseNotFinite));
        let failed = Sensed { status: SensorStatus::Failed, ..at(0.0, 3) };
        assert_eq!(gate.admit(&limits, &failed, false), Err(Fault::SensorFault));
        assert!(!gate.admit(&limits, &at(0.03, 4), true).unwrap().held, "believed anew after a fault");
    }

    /// Ticks until the fault of a gate at rest under force, if these readings are bad.
    fn fault_at(force_acts: bool, bad: impl Fn(u32) -> bool, spoil: fn(&mut Sensed)) -> Option<(u32, Fault)> {
        let (limits, mut gate) = (limits(), gate());
        (1..5_000).find_map(|n| {
            let mut reading = at(0.0, n);
            if bad(n) {
                spoil(&mut reading);
            }
            gate.admit(&limits, &reading, force_acts).err().map(|fault| (n, fault))
        })
    }

    #[test]
    fn readings_that_are_missing_or_jump_too_often_are_a_fault_and_now_and_then_they_are_not() {
        type Spoil = fn(&mut Sensed);
        let kinds: [(Spoil, Fault); 2] =
            [(|r| r.sequence -= 1, Fault::PoseStale), (|r| r.position_m.x = 5e-3, Fault::SensorFault)];
        for (spoil, fault) in kinds {
            for (every, latest) in [(2, 60), (3, 100), (5, 180), (10, 510)] {
                let found = fault_at(true, |n| n.is_multiple_of(every), spoil);
                assert!(found.is_some_and(|(n, f)| f == fault && n > 40 && n <= latest), "every {every}th: {found:?}");
                assert_eq!(fault_at(false, |n| n.is_multiple_of(every), spoil), None, "nobody feels it");
            }
            assert_eq!(fault_at(true, |n| n.is_multiple_of(20), spoil), None, "one in twenty is borne");
            // twenty bad readings within 40 ticks, once a second
            assert_eq!(fault_at(true, |n| n % 1000 < 40 && n.is_multiple_of(2), spoil), None);
        }
    }

    #[test]
    fn a_fast_hand_in_free_space_does_not_use_up_what_a_touch_may_suffer() {
        for comes_to_rest in 1_000..1_040 {
            let (limits, mut gate) = (limits(), gate());
            let mut z_m = 0.0;
            for n in 1..comes_to_rest {
                z_m = if n % 20 < 10 { z_m + 4e-3 } else { z_m - 4e-3 };
                gate.admit(&limits, &at(z_m, n), false).unwrap();
            }
            for n in comes_to_rest..comes_to_rest + 100 {
                assert!(gate.admit(&limits, &at(z_m, n), n > comes_to_rest + 3).is_ok(), "tick {n}");
            }
        }
    }

    #[test]
    fn late_ticks_widen_what_a_hand_may_have_travelled() {
        for (late, believed) in [(0, false), (3, true)] {
            let (limits, mut gate) = (limits(), gate());
            gate.skip(late);
            assert_eq!(!gate.admit(&limits, &at(5e-3, 1), true).unwrap().held, believed, "{late} periods late");
        }
    }

    #[test]
    fn every_side_of_the_workspace_is_a_bound() {
        let limits = limits();
        for (axis, half_m) in [(0, 0.096), (1, 0.072), (2, 0.072)] {
            for side in [1.0, -1.0] {
                for (share, inside) in [(0.999, true), (1.001, false)] {
                    let mut reading = at(0.0, 0);
                    reading.position_m[axis] = side * share * half_m;
                    let answer = PoseGate::default().admit(&limits, &reading, false);
                    assert_eq!(answer.is_ok(), inside, "axis {axis}: {}", reading.position_m);
                }
            }
        }
    }
}
