//! A device with an injected fault.

use std::collections::VecDeque;

use palpate::Vector3;
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::Rng;

use super::{ForceFault, Reading};

/// Number of past readings that are stored, for faults that return an old one.
const KEPT: usize = 16;
/// Step of the sequence number of a sensor that counts too fast: the number wraps every 16
/// readings.
const LEAP: u32 = 0x1000_0000;

/// Any device, with a fault in its readings or its forces.
#[derive(Clone, Debug)]
pub struct Faulty<D> {
    device: D,
    /// Unit vectors out of the tissue, and along its surface.
    normal: Vector3<f32>,
    along: Vector3<f32>,
    site_m: Vector3<f32>,
    reading: Option<Reading>,
    drive: Option<ForceFault>,
    /// True readings, newest last.
    past: VecDeque<Sensed>,
    /// Reading that the loop received last.
    telemetry: Option<Sensed>,
    /// Position at the start of the fault [m].
    stuck_m: Vector3<f32>,
    /// Offset that is added to every sequence number.
    number_offset: u32,
    line_n: VecDeque<Vector3<f32>>,
    given_n: Vector3<f32>,
    random: SplitMix64,
}

impl<D: HapticDevice> Faulty<D> {
    /// Wraps a device, at first without a fault. A fault displaces a reading in the plane of
    /// `normal` and `along`; coordinates of the wrong sign are mirrored at `site_m`.
    pub fn new(device: D, site_m: Vector3<f32>, normal: Vector3<f32>, along: Vector3<f32>, random: SplitMix64) -> Self {
        Self {
            device,
            normal,
            along,
            site_m,
            reading: None,
            drive: None,
            past: VecDeque::with_capacity(KEPT),
            telemetry: None,
            stuck_m: Vector3::zeros(),
            number_offset: 0,
            line_n: VecDeque::new(),
            given_n: Vector3::zeros(),
            random,
        }
    }

    /// The wrapped device.
    pub fn device(&mut self) -> &mut D {
        &mut self.device
    }

    /// Sets the offset of all sequence numbers, so that this device can take over from another one.
    pub fn number_from(&mut self, number: u32) {
        self.number_offset = number;
    }

    /// Applies a fault from the next reading on; `None` ends it.
    pub fn break_reading(&mut self, fault: Option<Reading>) {
        self.reading = fault;
        if let Some(last) = self.past.back() {
            self.stuck_m = last.position_m;
        }
    }

    /// Applies a fault from the next force on; `None` ends it.
    pub fn break_drive(&mut self, fault: Option<ForceFault>) {
        self.drive = fault;
        self.line_n.clear();
    }

    /// Index of the axis closest to the direction of the press; a fault of a single axis affects
    /// this one.
    fn axis(&self) -> usize {
        self.normal.iamax()
    }

    fn wrong(&mut self, fault: Reading, mut now: Sensed) -> Sensed {
        let axis = self.axis();
        let position_m = &mut now.position_m;
        match fault {
            Reading::Is(value) => position_m[axis] = value,
            Reading::Shifted { out_m, aside_m } => *position_m += self.normal * out_m + self.along * aside_m,
            Reading::Repeated => return self.telemetry.unwrap_or(now),
            Reading::Behind(by) => now.sequence = now.sequence.wrapping_sub(by),
            Reading::Failed => now.status = SensorStatus::Failed,
            Reading::Stuck => *position_m = self.stuck_m,
            Reading::Frozen => position_m[axis] = self.stuck_m[axis],
            Reading::Mirrored => *position_m = self.site_m * 2.0 - *position_m,
            Reading::MirroredAxis => position_m[axis] = 2.0 * self.site_m[axis] - position_m[axis],
            Reading::Noise(counts) => {
                let count_m = self.device.limits().count_m;
                for c in position_m.iter_mut() {
                    let span = u64::from(counts) * 2 + 1;
                    *c += ((self.random.next_u64() % span) as f32 - f32::from(counts)) * count_m;
                }
            }
            Reading::Late(ticks) => *position_m = self.ago_m(ticks),
            Reading::Jitter => {
                let late = self.random.next_u64().is_multiple_of(4);
                *position_m = self.ago_m(late.into());
            }
            Reading::Wraps => {
                self.number_offset = self.number_offset.wrapping_add(LEAP);
                now.sequence = now.sequence.wrapping_add(LEAP);
            }
        }
        now
    }

    fn ago_m(&self, ticks: usize) -> Vector3<f32> {
        let at = self.past.len().saturating_sub(1 + ticks);
        self.past.get(at).map_or(Vector3::zeros(), |s| s.position_m)
    }
}

impl<D: HapticDevice> HapticDevice for Faulty<D> {
    fn limits(&self) -> DeviceSpec {
        self.device.limits()
    }

    fn sense(&mut self) -> Sensed {
        let mut now = self.device.sense();
        now.sequence = now.sequence.wrapping_add(self.number_offset);
        if self.past.len() == KEPT {
            self.past.pop_front();
        }
        self.past.push_back(now);
        let telemetry = match self.reading {
            Some(fault) => self.wrong(fault, now),
            None => now,
        };
        self.telemetry = Some(telemetry);
        telemetry
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        let given_n = match self.drive {
            Some(ForceFault::Saturated(most_n)) => force_n.map(|c| c.clamp(-most_n, most_n)),
            Some(ForceFault::Stuck) => self.given_n,
            Some(ForceFault::Scaled(times)) => force_n * times,
            Some(ForceFault::Dropped) => Vector3::zeros(),
            Some(ForceFault::Late(ticks)) => {
                self.line_n.push_back(force_n);
                if self.line_n.len() > ticks { self.line_n.pop_front().unwrap_or_default() } else { self.given_n }
            }
            Some(ForceFault::Lag(_) | ForceFault::Friction(_)) | None => force_n,
        };
        self.given_n = given_n;
        self.device.actuate(given_n);
    }

    fn release(&mut self) {
        self.line_n.clear();
        self.given_n = Vector3::zeros();
        self.device.release();
    }
}
