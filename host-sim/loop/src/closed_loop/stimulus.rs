//! Stimuli of the hand: twelve kinds, from a tap to an organ that is swapped under the probe.

use palpate::Vector3;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::hand::Aim;

/// Height above the tissue at which every trajectory begins and the loop arms [m].
pub const CLEAR_M: f64 = 5e-3;
/// Duration of the hold that is evaluated at the end of a trajectory [s].
pub const HOLD_S: f64 = 2.0;
/// Time for a press to settle [s].
const SETTLE_S: f64 = 0.75;
/// Longest time for which a hand holds without moving [s]. After that time it has a tremor of this
/// amplitude [m] and frequency [Hz], and its force drifts by this share (1) at this frequency [Hz].
const STILL_S: f64 = 3.0;
const TREMOR: (f64, f64) = (0.1e-3, 9.0);
const DRIFT: (f64, f64) = (0.08, 0.2);

/// Times after the press at which stiffness or far field changes [s], and the factors.
const CHANGES: [(f64, f64); 3] = [(0.0, 2.0), (1.7, 0.5), (2.4, 1.0)];
/// Times after the press between which the hand is out of the tissue [s]: stiffening waits until
/// the hand leaves, softening does not.
const LEAVES_S: [[f64; 2]; 2] = [[0.2, 1.4], [2.6, 3.8]];

/// Change of the tissue during a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The stiffness of the tissue becomes this multiple of its initial value.
    Stiffness(f64),
    /// Another organ is behind the patch: the stiffness of the far field becomes this multiple of
    /// its initial value. If the patch has no far field, the stiffness of the tissue itself changes
    /// instead.
    FarField(f64),
}

/// Motion of the hand, or change of the tissue, that a run applies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stimulus {
    /// Short name, S1 .. S12, with the speed of a tap after a dash.
    pub id: &'static str,
    /// Name of the stimulus, such as `slow press`.
    pub name: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Tap { m_per_s: f64 },
    SlowPress,
    Step,
    Hold { s: f64 },
    Sine,
    Drag,
    Release,
    Chirp,
    Random { seed: u32 },
    Crossing,
    Stiffness,
    Swap,
}

/// Every stimulus. S4 is a hold of one minute.
pub const STIMULI: [Stimulus; 15] = [
    Stimulus { id: "S1-0.05", name: "tap 0.05 m/s", kind: Kind::Tap { m_per_s: 0.05 } },
    Stimulus { id: "S1-0.2", name: "tap 0.2 m/s", kind: Kind::Tap { m_per_s: 0.2 } },
    Stimulus { id: "S1-0.5", name: "tap 0.5 m/s", kind: Kind::Tap { m_per_s: 0.5 } },
    Stimulus { id: "S1-1", name: "tap 1 m/s", kind: Kind::Tap { m_per_s: 1.0 } },
    Stimulus { id: "S2", name: "slow press", kind: Kind::SlowPress },
    Stimulus { id: "S3", name: "target jumps in", kind: Kind::Step },
    Stimulus { id: "S4", name: "hold a minute", kind: Kind::Hold { s: 60.0 } },
    Stimulus { id: "S5", name: "sine 0.5-20 Hz", kind: Kind::Sine },
    Stimulus { id: "S6", name: "drag 0.1 m/s", kind: Kind::Drag },
    Stimulus { id: "S7", name: "let go", kind: Kind::Release },
    Stimulus { id: "S8", name: "chirp 1-400 Hz", kind: Kind::Chirp },
    Stimulus { id: "S9", name: "random motion", kind: Kind::Random { seed: 9 } },
    Stimulus { id: "S10", name: "crossing edges", kind: Kind::Crossing },
    Stimulus { id: "S11", name: "stiffness x2, /2", kind: Kind::Stiffness },
    Stimulus { id: "S12", name: "organ swapped", kind: Kind::Swap },
];

/// Id of a known stimulus. [`id`] reads it by looking the name up, since serde would borrow a
/// `&'static str` from the text.
pub type Id = &'static str;

/// Reads the id of a known stimulus.
///
/// # Errors
/// No stimulus has this name.
pub fn id<'de, D: Deserializer<'de>>(from: D) -> Result<Id, D::Error> {
    let name = String::deserialize(from)?;
    Stimulus::named(&name).map(|known| known.id).ok_or_else(|| D::Error::custom(format!("no stimulus is called {name}")))
}

impl Stimulus {
    /// Finds the stimulus with this id or name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        STIMULI.into_iter().find(|s| s.id.eq_ignore_ascii_case(name) || s.name == name)
    }

    /// A tap at this speed [m/s], followed by a hold.
    #[must_use]
    pub fn tap(m_per_s: f64) -> Self {
        Self { id: "S1", name: "tap", kind: Kind::Tap { m_per_s } }
    }

    /// A press followed by a hold of this duration [s], then by the hold that ends every
    /// trajectory.
    #[must_use]
    pub fn hold(s: f64) -> Self {
        Self { id: "S4", name: "hold", kind: Kind::Hold { s } }
    }

    /// Returns the stimulus shortened to a few seconds: a hold lasts three.
    #[must_use]
    pub fn short(self) -> Self {
        match self.kind {
            Kind::Hold { .. } => Self { kind: Kind::Hold { s: 3.0 }, ..self },
            _ => self,
        }
    }

    /// Whether the stimulus ends with a hold in contact, in which a limit cycle would show.
    #[must_use]
    pub fn ends_in_hold(&self) -> bool {
        self.kind != Kind::Release
    }

    /// Whether the stimulus presses slowly, so that any shaking comes from the loop.
    #[must_use]
    pub fn is_slow_press(&self) -> bool {
        self.kind == Kind::SlowPress
    }

    /// Whether the stimulus changes the tissue behind the patch.
    #[must_use]
    pub fn swaps_the_far_field(&self) -> bool {
        self.kind == Kind::Swap
    }

    /// Whether the stimulus crosses the edges of elements, where the direction of the force must
    /// not jump.
    #[must_use]
    pub fn crosses_edges(&self) -> bool {
        matches!(self.kind, Kind::Drag | Kind::Crossing)
    }
}

/// Site and directions of the press.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Position of the site on the rest surface [m].
    pub at_m: Vector3<f64>,
    /// Unit vector out of the tissue.
    pub normal: Vector3<f64>,
    /// Unit vector along the surface.
    pub along: Vector3<f64>,
}

impl Site {
    /// Creates a site from its position and normal, with some direction along the surface.
    #[must_use]
    pub fn new(at_m: Vector3<f64>, normal: Vector3<f64>) -> Self {
        let helper = if normal.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let along = (helper - normal * helper.dot(&normal)).normalize();
        Self { at_m, normal, along }
    }

    /// Direction along the surface, perpendicular to `along`.
    #[must_use]
    pub fn across(&self) -> Vector3<f64> {
        self.normal.cross(&self.along)
    }

    /// A point at a depth [m] and at distances along the surface [m].
    #[must_use]
    pub fn point_m(&self, depth_m: f64, along_m: f64, across_m: f64) -> Vector3<f64> {
        self.at_m - self.normal * depth_m + self.along * along_m + self.normal.cross(&self.along) * across_m
    }
}

/// A stimulus for a hand on a tissue.
#[derive(Clone, Copy, Debug)]
pub struct Trajectory {
    /// Stimulus that the hand follows.
    pub stimulus: Stimulus,
    /// Site of the touch.
    pub site: Site,
    /// Depth at which a press rests [m].
    pub depth_m: f64,
    /// Depth of the hand's target below the handle in that press [m].
    pub reach_m: f64,
    /// Push of a released hand in that press [N]; zero for other hands.
    pub push_n: f64,
}

impl Trajectory {
    /// Duration of the stimulus [s], of which the last [`HOLD_S`] are steady.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let displacement_m = CLEAR_M + self.depth_m + self.reach_m;
        let own = match self.stimulus.kind {
            Kind::Tap { m_per_s } => displacement_m / m_per_s + 2.0,
            Kind::SlowPress => displacement_m / 5e-3 + 0.5,
            Kind::Step => 1.5,
            Kind::Hold { s } => displacement_m / 0.05 + s,
            Kind::Sine | Kind::Chirp => displacement_m / 0.05 + SETTLE_S + 4.0 + SETTLE_S,
            Kind::Drag | Kind::Crossing => displacement_m / 0.05 + SETTLE_S + 0.4 + SETTLE_S,
            Kind::Release => displacement_m / 0.05 + SETTLE_S + 1.0,
            Kind::Random { .. } => displacement_m / 0.05 + 5.0 + SETTLE_S,
            Kind::Stiffness | Kind::Swap => displacement_m / 0.05 + SETTLE_S + LEAVES_S[1][1] + SETTLE_S,
        };
        own + HOLD_S
    }

    /// Approach speed of the handle [m/s].
    #[must_use]
    pub fn entry_m_per_s(&self) -> f64 {
        match self.stimulus.kind {
            Kind::Tap { m_per_s } => m_per_s,
            _ => 0.0,
        }
    }

    /// Target of the hand for a depth of the handle; the reach is proportional to the depth.
    fn target(&self, depth_m: f64, along_m: f64, across_m: f64) -> Vector3<f64> {
        let share = if self.depth_m > 0.0 { (depth_m / self.depth_m).max(0.0) } else { 0.0 };
        self.site.point_m(depth_m + self.reach_m * share, along_m, across_m)
    }

    /// Returns the aim of the hand at this time [s].
    #[must_use]
    pub fn aim(&self, t_s: f64) -> Aim {
        let (dt_s, end_s) = (1e-6, self.seconds());
        let at_m = self.at(t_s);
        let velocity_m_per_s = match self.stimulus.kind {
            Kind::Step => Vector3::zeros(),
            _ => (self.at(t_s + dt_s) - at_m) / dt_s,
        };
        let let_go = self.stimulus.kind == Kind::Release && t_s > self.press_s(0.05) + SETTLE_S;
        let mut push_n = -self.site.normal * (self.push_n * self.push_share(t_s));
        if self.stimulus.kind == Kind::Chirp {
            push_n += self.site.normal * self.chirp_n(t_s);
        }
        Aim { at_m, velocity_m_per_s, push_n, let_go, steady: t_s > end_s - HOLD_S }
    }

    /// Push of a released hand relative to the full one (1): it follows the sine, turns into a pull
    /// while a hand would leave the tissue, and is 1 otherwise.
    fn push_share(&self, t_s: f64) -> f64 {
        match self.stimulus.kind {
            Kind::Sine => 1.0 - self.sine(t_s) * 0.5,
            // a pull, since the device's friction would otherwise hold the handle in place
            Kind::Stiffness | Kind::Swap => 1.0 - self.left(t_s) * 1.3,
            _ => 1.0,
        }
    }

    /// Duration [s] of a press at a speed [m/s], from the start to its full depth.
    fn press_s(&self, m_per_s: f64) -> f64 {
        (CLEAR_M + self.depth_m + self.reach_m) / m_per_s
    }

    /// Depth of a press at a speed [m], without the reach.
    fn pressed_m(&self, t_s: f64, m_per_s: f64) -> f64 {
        let deep = self.depth_m + self.reach_m;
        let depth_m = (m_per_s * t_s - CLEAR_M).min(deep);
        if depth_m > 0.0 { depth_m * self.depth_m / deep } else { depth_m }
    }

    /// Displacement of the sine, from 0 to 1 and back, at a frequency that rises from 0.5 to 20 Hz
    /// over 4 s once pressed; 0 before and after.
    fn sine(&self, t_s: f64) -> f64 {
        let s = t_s - self.press_s(0.05) - SETTLE_S;
        if !(0.0..4.0).contains(&s) {
            return 0.0;
        }
        0.5 - 0.5 * sweep(s, 4.0, 0.5, 20.0).cos()
    }

    /// 1 while the hand has left the tissue, 0 while it presses, with a smooth transition.
    fn left(&self, t_s: f64) -> f64 {
        let s = t_s - self.press_s(0.05) - SETTLE_S;
        let window = |[from, to]: &[f64; 2]| {
            let edge = ((s - from).min(to - s) / 0.4).clamp(0.0, 1.0);
            0.5 - 0.5 * (std::f64::consts::PI * edge).cos()
        };
        LEAVES_S.iter().map(window).sum()
    }

    fn chirp_n(&self, t_s: f64) -> f64 {
        let s = t_s - self.press_s(0.05) - SETTLE_S;
        if (0.0..4.0).contains(&s) { 0.1 * sweep(s, 4.0, 1.0, 400.0).sin() } else { 0.0 }
    }

    fn at(&self, t_s: f64) -> Vector3<f64> {
        let press = |m_per_s| self.pressed_m(t_s, m_per_s);
        let moved_s = t_s - self.press_s(0.05) - SETTLE_S;
        match self.stimulus.kind {
            Kind::Tap { m_per_s } => self.target(press(m_per_s), 0.0, 0.0),
            Kind::SlowPress => self.target(press(5e-3), 0.0, 0.0),
            Kind::Step => self.target(if t_s < 0.1 { -CLEAR_M } else { self.depth_m }, 0.0, 0.0),
            Kind::Sine => self.target(press(0.05).min(self.depth_m * (1.0 - 0.8 * self.sine(t_s))), 0.0, 0.0),
            // 100 mm/s over the fine part of the patch and back to the middle
            Kind::Drag => self.target(press(0.05), zigzag(moved_s, 0.1, 8e-3), 0.0),
            Kind::Crossing => {
                let displacement_m = zigzag(moved_s, 0.2, 7e-3);
                self.target(press(0.05).min(0.5 * self.depth_m), 0.8 * displacement_m, 0.6 * displacement_m)
            }
            Kind::Random { seed } => {
                let s = t_s - self.press_s(0.05);
                let on = if (0.0..5.0).contains(&s) { (s * (5.0 - s) / 2.0).min(1.0) } else { 0.0 };
                let [a, b, c] = [0, 1, 2].map(|n| on * noise(s, seed.wrapping_mul(31).wrapping_add(n)));
                let depth_m = if s < 0.0 { press(0.05) } else { self.depth_m * (1.0 - on * 0.6 + 0.6 * a) };
                self.target(depth_m, 4e-3 * b, 4e-3 * c)
            }
            Kind::Stiffness | Kind::Swap => {
                let depth_m = press(0.05);
                self.target(depth_m - (depth_m + CLEAR_M) * self.left(t_s), 0.0, 0.0)
            }
            Kind::Hold { s } => {
                let held_s = t_s - self.press_s(0.05);
                // the steady end, which is evaluated, has no tremor
                let on = ((held_s - STILL_S) / 0.5).min((s - held_s) / 0.5).clamp(0.0, 1.0);
                let turns = std::f64::consts::TAU * (held_s - STILL_S);
                let drift_m = DRIFT.0 * self.reach_m * (DRIFT.1 * turns).sin();
                let restless_m = on * (TREMOR.0 * (TREMOR.1 * turns).sin() + drift_m);
                self.target(press(0.05), 0.0, 0.0) + self.site.normal * restless_m
            }
            Kind::Release | Kind::Chirp => self.target(press(0.05), 0.0, 0.0),
        }
    }

    /// Returns the change of the tissue, if any, in the tick that ends at this time [s].
    #[must_use]
    pub fn change(&self, t_s: f64) -> Option<Change> {
        let s = t_s - self.press_s(0.05) - SETTLE_S;
        let at = |when: f64| (s - when).abs() < 0.5e-3;
        let make = match self.stimulus.kind {
            Kind::Stiffness => Change::Stiffness,
            Kind::Swap => Change::FarField,
            _ => return None,
        };
        CHANGES.into_iter().find(|(when, _)| at(*when)).map(|(_, ratio)| make(ratio))
    }
}

/// Phase of a sweep from one frequency to another at a constant rate in octaves per second [rad].
fn sweep(s: f64, seconds: f64, from_hz: f64, to_hz: f64) -> f64 {
    let rate = (to_hz / from_hz).ln() / seconds;
    std::f64::consts::TAU * from_hz * ((rate * s).exp() - 1.0) / rate
}

/// Displacement to one side, to the other and back to the middle at a constant speed [m]; zero
/// before and after.
fn zigzag(s: f64, m_per_s: f64, half_m: f64) -> f64 {
    match m_per_s * s / half_m {
        legs if legs < 0.0 => 0.0,
        legs if legs < 1.0 => legs * half_m,
        legs if legs < 3.0 => (2.0 - legs) * half_m,
        legs if legs < 4.0 => (legs - 4.0) * half_m,
        _ => 0.0,
    }
}

/// Smooth noise between about -1 and 1 without components above 8 Hz, the same every time for a
/// given seed.
fn noise(s: f64, seed: u32) -> f64 {
    let tones = 8;
    let of = |n: u32| {
        // two numbers between 0 and 1 from a hash of seed and `n`
        let mixed = seed.wrapping_mul(0x9e37_79b9).wrapping_add(n.wrapping_mul(0x85eb_ca6b)) ^ 0x5bd1_e995;
        let mixed = (mixed ^ (mixed >> 15)).wrapping_mul(0x2c1b_3c6d);
        (f64::from(mixed & 0xffff) / 65536.0, f64::from(mixed >> 16) / 65536.0)
    };
    let tone = |n: u32| {
        let (hz, phase) = of(n);
        (std::f64::consts::TAU * ((0.3 + 7.7 * hz) * s + phase)).sin()
    };
    (0..tones).map(tone).sum::<f64>() / f64::from(tones).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory(stimulus: Stimulus) -> Trajectory {
        let site = Site::new(Vector3::new(0.01, 0.0, 0.02), Vector3::new(0.0, 0.6, 0.8));
        Trajectory { stimulus, site, depth_m: 4e-3, reach_m: 7e-3, push_n: 0.0 }
    }

    #[test]
    fn every_course_starts_outside_and_ends_in_a_steady_hold_without_a_jump() {
        for stimulus in STIMULI {
            let trajectory = trajectory(stimulus.short());
            let end = trajectory.seconds();
            assert!((trajectory.aim(0.0).at_m - trajectory.site.point_m(-CLEAR_M, 0.0, 0.0)).norm() < 1e-9, "{}", stimulus.id);
            let hold = trajectory.aim(end);
            assert!((trajectory.aim(end - HOLD_S + 0.02).at_m - hold.at_m).norm() < 1e-9 && hold.steady, "{}", stimulus.id);
            let depth = if stimulus.id == "S10" { 0.5 } else { 1.0 };
            assert!((hold.at_m - trajectory.site.point_m(11e-3 * depth, 0.0, 0.0)).norm() < 1e-9, "{}: {hold:?}", stimulus.id);
            let ticks = (end / 1e-3) as u32;
            let farthest = (0..ticks)
                .map(|n| f64::from(n) * 1e-3)
                .map(|t| (trajectory.aim(t + 1e-3).at_m - trajectory.aim(t).at_m).norm())
                .fold(0.0, f64::max);
            let jumps = stimulus.id == "S3";
            assert!(jumps == (farthest > 2e-3), "{}: {farthest} m in a tick", stimulus.id);
        }
    }

    #[test]
    fn tissue_changes_three_times_and_ends_as_it_began() {
        for id in ["S11", "S12"] {
            let trajectory = trajectory(Stimulus::named(id).unwrap());
            let changes: Vec<Change> =
                (0..(trajectory.seconds() * 1e3) as u32).filter_map(|n| trajectory.change(f64::from(n) * 1e-3)).collect();
            let ratio = |c: &Change| match c {
                Change::Stiffness(r) | Change::FarField(r) => *r,
            };
            assert_eq!(changes.iter().map(ratio).collect::<Vec<_>>(), [2.0, 0.5, 1.0], "{id}");
            let depth_m = |s: f64| {
                let aim = trajectory.aim(trajectory.press_s(0.05) + SETTLE_S + s);
                -(aim.at_m - trajectory.site.at_m).dot(&trajectory.site.normal)
            };
            assert!(LEAVES_S.iter().flatten().sum::<f64>() > 0.0 && depth_m(0.0) > 10e-3);
            assert!((depth_m(0.8) + CLEAR_M).abs() < 1e-9 && (depth_m(3.2) + CLEAR_M).abs() < 1e-9, "outside while it stiffens");
            assert!(depth_m(1.7) > 10e-3 && depth_m(2.4) > 10e-3, "inside where it softens");
        }
    }
}
