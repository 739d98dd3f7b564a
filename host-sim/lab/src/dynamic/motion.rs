//! Prescribed motions of the probe: ramps, taps, sinusoids and drags.
//!
//! A motion begins at time zero with the tip on the rest surface. It is a chain of legs, and the
//! velocity may jump where two legs meet. These instants are called *kinks*; a time step always
//! ends there.

use std::f64::consts::TAU;

use super::error::DynamicError;

/// Position of the tip relative to the place of the press.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Depth below the rest surface, along the press [m].
    pub depth_m: f64,
    /// Displacement at right angles to the press [m]; on a block along x and y.
    pub across_m: [f64; 2],
}

/// One leg of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leg {
    /// Constant velocity, or rest.
    Line { to: Pose, duration_s: f64 },
    /// The depth oscillates about that at the start of the leg, beginning inward.
    Wave { amplitude_m: f64, frequency_hz: f64, duration_s: f64 },
}

/// Prescribed motion of the probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    start: Pose,
    legs: Vec<Leg>,
    /// Parameters that must be above zero, with their names for error messages.
    asked: Vec<(&'static str, f64)>,
}

impl Motion {
    /// Presses to a depth at constant speed and holds there.
    pub fn ramp(speed_m_per_s: f64, depth_m: f64, hold_s: f64) -> Self {
        Self::asking(&[("speed_m_per_s", speed_m_per_s), ("depth_m", depth_m), ("hold_s", hold_s)])
            .go(Pose { depth_m, ..Pose::default() }, speed_m_per_s)
            .hold(hold_s)
    }

    /// Presses to a depth at constant speed, holds there, retracts at the same speed and waits
    /// equally long at the rest surface.
    pub fn tap(speed_m_per_s: f64, depth_m: f64, dwell_s: f64) -> Self {
        Self::ramp(speed_m_per_s, depth_m, dwell_s).go(Pose::default(), speed_m_per_s).hold(dwell_s)
    }

    /// Presses to the mean depth at constant speed, holds there and then oscillates about it.
    pub fn sinusoid(approach: [f64; 2], mean_depth_m: f64, amplitude_m: f64, frequency_hz: f64, periods: f64) -> Self {
        let [speed_m_per_s, hold_s] = approach;
        let duration_s = periods / frequency_hz;
        let mut motion = Self::ramp(speed_m_per_s, mean_depth_m, hold_s);
        motion.asked.extend([("amplitude_m", amplitude_m), ("frequency_hz", frequency_hz), ("periods", periods)]);
        motion.legs.push(Leg::Wave { amplitude_m, frequency_hz, duration_s });
        motion
    }

    /// Presses to a depth at constant speed, settles there, and moves at that depth along the first
    /// tangential direction. The middle of the travel is the place of the press.
    pub fn drag(approach: [f64; 2], depth_m: f64, speed_m_per_s: f64, travel_m: f64) -> Self {
        let [approach_m_per_s, settle_s] = approach;
        let asked = [
            ("approach_m_per_s", approach_m_per_s),
            ("settle_s", settle_s),
            ("depth_m", depth_m),
            ("speed_m_per_s", speed_m_per_s),
            ("travel_m", travel_m),
        ];
        let mut motion = Self::asking(&asked);
        motion.start.across_m = [-0.5 * travel_m, 0.0];
        motion
            .go(Pose { depth_m, across_m: [-0.5 * travel_m, 0.0] }, approach_m_per_s)
            .hold(settle_s)
            .go(Pose { depth_m, across_m: [0.5 * travel_m, 0.0] }, speed_m_per_s)
    }

    /// A motion without legs, with the tip on the rest surface; [`Self::go`] and [`Self::hold`] add
    /// legs.
    pub fn at_touch() -> Self {
        Self { start: Pose::default(), legs: Vec::new(), asked: Vec::new() }
    }

    fn asking(asked: &[(&'static str, f64)]) -> Self {
        Self { asked: asked.to_vec(), ..Self::at_touch() }
    }

    /// Adds a straight leg at constant speed.
    pub fn go(mut self, to: Pose, speed_m_per_s: f64) -> Self {
        let from = self.end();
        let [x, y] = [0, 1].map(|k| to.across_m[k] - from.across_m[k]);
        let displacement_m = (to.depth_m - from.depth_m).hypot(x).hypot(y);
        self.asked.push(("speed_m_per_s", speed_m_per_s));
        self.legs.push(Leg::Line { to, duration_s: displacement_m / speed_m_per_s });
        self
    }

    /// Adds a leg at rest.
    pub fn hold(mut self, duration_s: f64) -> Self {
        let to = self.end();
        self.asked.push(("hold_s", duration_s));
        self.legs.push(Leg::Line { to, duration_s });
        self
    }

    /// Checks the range of every parameter.
    pub fn check(&self) -> Result<(), DynamicError> {
        match self.asked.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            Some((key, value)) => Err(DynamicError::Motion { key, value: *value, range: "above zero and finite" }),
            None => Ok(()),
        }
    }

    /// Pose at a time; after the end, the last pose.
    pub fn pose(&self, t_s: f64) -> Pose {
        let (mut from, mut left_s) = (self.start, t_s);
        for leg in &self.legs {
            if left_s < leg.duration_s() {
                return leg.pose(from, left_s);
            }
            left_s -= leg.duration_s();
            from = leg.pose(from, leg.duration_s());
        }
        from
    }

    /// Instants at which the velocity may jump, including start and end [s].
    pub fn kinks_s(&self) -> Vec<f64> {
        let mut kinks_s = vec![0.0];
        for leg in &self.legs {
            let last_s = kinks_s[kinks_s.len() - 1];
            if leg.duration_s() > 0.0 {
                kinks_s.push(last_s + leg.duration_s());
            }
        }
        kinks_s
    }

    /// Time at the end of the motion [s].
    pub fn duration_s(&self) -> f64 {
        self.legs.iter().map(Leg::duration_s).sum()
    }

    /// Largest depth [m].
    pub fn deepest_m(&self) -> f64 {
        let (mut from, mut deepest_m) = (self.start, self.start.depth_m);
        for leg in &self.legs {
            deepest_m = deepest_m.max(match leg {
                Leg::Line { to, .. } => to.depth_m,
                Leg::Wave { amplitude_m, .. } => from.depth_m + amplitude_m,
            });
            from = leg.pose(from, leg.duration_s());
        }
        deepest_m
    }

    /// Minimum and maximum displacement along each direction at right angles to the press [m].
    pub fn reach_m(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|k| {
            let mut reach = [self.start.across_m[k]; 2];
            for leg in &self.legs {
                if let Leg::Line { to, .. } = leg {
                    reach = [reach[0].min(to.across_m[k]), reach[1].max(to.across_m[k])];
                }
            }
            reach
        })
    }

    fn end(&self) -> Pose {
        self.legs.iter().fold(self.start, |from, leg| leg.pose(from, leg.duration_s()))
    }
}

impl Leg {
    fn duration_s(&self) -> f64 {
        match self {
            Self::Line { duration_s, .. } | Self::Wave { duration_s, .. } => *duration_s,
        }
    }

    fn pose(&self, from: Pose, t_s: f64) -> Pose {
        match *self {
            Self::Line { to, duration_s } if t_s < duration_s => {
                let share = t_s / duration_s;
                let between = |a: f64, b: f64| a + (b - a) * share;
                let across_m = [0, 1].map(|k| between(from.across_m[k], to.across_m[k]));
                Pose { depth_m: between(from.depth_m, to.depth_m), across_m }
            }
            Self::Line { to, .. } => to,
            Self::Wave { amplitude_m, frequency_hz, .. } => {
                Pose { depth_m: from.depth_m + amplitude_m * (TAU * frequency_hz * t_s).sin(), ..from }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_presses_settles_and_crosses_the_place() {
        let drag = Motion::drag([0.04, 0.1], 0.003, 0.06, 0.012);
        assert_eq!(drag.kinks_s().len(), 4);
        assert!((drag.duration_s() - (0.075 + 0.1 + 0.2)).abs() < 1e-12);
        assert_eq!(drag.pose(0.0), Pose { depth_m: 0.0, across_m: [-0.006, 0.0] });
        let middle = drag.pose(0.275);
        assert!(middle.across_m[0].abs() < 1e-12 && (middle.depth_m - 0.003).abs() < 1e-12);
        assert_eq!((drag.deepest_m(), drag.reach_m()), (0.003, [[-0.006, 0.006], [0.0, 0.0]]));
    }

    #[test]
    fn a_sinusoid_swings_about_its_mean() {
        let swing = Motion::sinusoid([0.1, 0.05], 0.002, 0.001, 25.0, 2.0);
        assert!((swing.pose(0.02 + 0.05 + 0.01).depth_m - 0.003).abs() < 1e-12);
        assert!((swing.pose(0.02 + 0.05 + 0.03).depth_m - 0.001).abs() < 1e-12);
        assert!((swing.deepest_m() - 0.003).abs() < 1e-12);
    }

    #[test]
    fn a_tap_comes_back_and_bad_parameters_are_named() {
        let tap = Motion::tap(0.5, 0.004, 0.02);
        assert_eq!(tap.pose(tap.duration_s()), Pose::default());
        assert!(tap.check().is_ok());
        let refused = Motion::ramp(0.0, 0.004, 0.1).check();
        assert!(matches!(refused, Err(DynamicError::Motion { key: "speed_m_per_s", .. })));
        assert!(Motion::ramp(0.1, f64::NAN, 0.1).check().is_err());
    }
}
