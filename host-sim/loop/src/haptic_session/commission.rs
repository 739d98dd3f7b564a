//! The commissioning of the caller's device.

use std::path::Path;

use palpate::haptic::commission::{Commissioning, Plan, Stage, Trouble, Wiring};
use palpate::haptic::cycle::{Cycle, Settings};
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Vector3};
use palpate_tissue::error::Error;
use palpate_tissue::scene::TICK_S;

use super::{CallersDevice, HapticSession, OutOfOrder};
use crate::closed_loop::device::DeviceProfile;
use crate::commissioning;

fn check_distance(distance_m: f32) -> Result<(), OutOfOrder> {
    if (5e-3..=0.5).contains(&distance_m) { Ok(()) } else { Err(OutOfOrder::Distance) }
}

/// A step of a commissioning.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Stage after this tick.
    pub stage: Stage,
    /// Forces for the motors [N], in the order of your device's wires.
    pub force_n: Vector3<f32>,
}

impl Step {
    /// Next instruction, or the finding, in one sentence.
    #[must_use]
    pub fn sentence(&self, distance_m: f32) -> String {
        commissioning::sentence(self.stage, commissioning::DIRECTIONS, distance_m)
    }
}

impl HapticSession {
    /// Runs one tick of a commissioning in place of [`Self::tick`]: it measures order, sign, unit,
    /// friction, mass, delay and lag of the device. The first call begins; after an end, the next
    /// call begins anew. `reading` are the values of the sensors, in any unit; `confirmed` says
    /// that the user has done what [`Step::sentence`] asks for. Send the returned forces to the
    /// motors at once.
    ///
    /// The result replaces the session's profile when the last motor is measured, and
    /// [`Self::write_profile`] stores it. Until then, and whenever it ends early, everything stays
    /// as it was.
    ///
    /// # Errors
    /// [`OutOfOrder::Armed`] while a force may act, [`OutOfOrder::Distance`].
    pub fn commission(&mut self, reading: Vector3<f32>, distance_m: f32, confirmed: bool) -> Result<Step, OutOfOrder> {
        if !matches!(self.mode(), Mode::Boot | Mode::SelfTest | Mode::Idle) || self.arms {
            self.commissioning = None;
            return Err(OutOfOrder::Armed);
        }
        check_distance(distance_m)?;
        let plan = Plan {
            axes: if self.profile.axes == 1 { [false, false, true] } else { [true; 3] },
            distance_m,
            force_limit_n: self.profile.force_limit_n as f32,
            stated_m_per_unit: self.wiring.per_unit,
            tick_s: TICK_S as f32,
        };
        let begun = self.commissioning.take().filter(|commissioning| !commissioning.stage().ended());
        let mut commissioning = begun.unwrap_or_else(|| Commissioning::new(plan));
        let force_n = commissioning.tick(reading.into(), confirmed).into();
        let stage = match commissioning.result() {
            Some(found) if commissioning.stage() == Stage::Done => {
                let done = commissioning::completed(&self.profile, found, None, &crate::day::today())
                    .and_then(|text| DeviceProfile::parse(&text, &self.profile.name.clone()))
                    .ok()
                    .and_then(|profile| self.take_profile(profile).ok());
                // a value out of a profile's range, such as a handle of 6 kg
                if done.is_some() { Stage::Done } else { Stage::Stopped(Trouble::Unclear) }
            }
            _ => commissioning.stage(),
        };
        self.commissioning = Some(commissioning);
        Ok(Step { stage, force_n })
    }

    /// Instruction to the user in the present step of a commissioning, or its outcome.
    ///
    /// # Errors
    /// [`OutOfOrder::Distance`].
    pub fn commission_sentence(&self, distance_m: f32) -> Result<String, OutOfOrder> {
        check_distance(distance_m)?;
        let stage = self.commissioning.as_ref().map_or(Stage::Start(0), Commissioning::stage);
        Ok(commissioning::sentence(stage, commissioning::DIRECTIONS, distance_m))
    }

    /// Ends a commissioning without a result.
    pub fn stop_commissioning(&mut self) {
        self.commissioning = None;
    }

    /// Text of the profile that the last commissioning completed.
    ///
    /// # Errors
    /// [`OutOfOrder::NotCommissioned`]
    pub fn measured_profile(&self) -> Result<&str, OutOfOrder> {
        if self.measured { Ok(&self.profile.text) } else { Err(OutOfOrder::NotCommissioned) }
    }

    /// Writes the profile that the last commissioning completed, as a whole.
    ///
    /// # Errors
    /// The file cannot be written, or this session has measured nothing.
    pub fn write_profile(&self, path: &Path) -> Result<(), Error> {
        let text = self.measured_profile().map_err(|error| Error::Usage(error.to_string()))?;
        commissioning::write_whole(path, text)
    }

    fn take_profile(&mut self, profile: DeviceProfile) -> Result<(), BuildError> {
        let spec = profile.real_limits(self.tissue.patch().site_m());
        let mut limits = profile.limit_values();
        limits.max_force_n = limits.max_force_n.min(self.most_force_n);
        let settings = Settings { limits, ..Settings::safe(&spec) };
        self.cycle = Cycle::build(&settings, &spec)?;
        self.wiring = profile.wiring.map_or(Wiring::STRAIGHT, |table| table.wiring());
        (self.settings, self.profile, self.measured) = (settings, profile, true);
        self.device = CallersDevice::new(spec);
        self.tissue.restart();
        (self.telemetry, self.asked, self.arms) = (None, None, false);
        Ok(())
    }
}
