//! The emulated finger: moves the probe's tip along one line, into the tissue and back.
//!
//! Position along the line is the tip's depth below the rest surface [m], negative outside.

use crate::scene::Drive;

/// Impedance of a finger that holds the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance {
    /// Mass that moves with the handle [kg].
    pub mass_kg: f64,
    /// Damping of the tip's speed [N s/m].
    pub damping_n_s_per_m: f64,
    /// Stiffness of the spring between the tip and the hand's target [N/m].
    pub stiffness_n_per_m: f64,
}

/// A firm fingertip (order of magnitude of Hajian & Howe 1997, scaled up for a grip).
pub const FINGER: Impedance = Impedance { mass_kg: 0.020, damping_n_s_per_m: 4.0, stiffness_n_per_m: 800.0 };

/// Motion of the finger in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Commanded depth of the tip [m].
    pub depth_m: f64,
    /// Index of the hold that ends with this tick.
    pub hold_ends: Option<usize>,
}

/// One leg of the motion: the way to a target and the wait there.
#[derive(Clone, Copy, Debug)]
struct Leg {
    target: f64,
    wait_ticks: usize,
    hold: Option<usize>,
}

/// Rule by which the finger follows its targets.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The tip follows the target exactly.
    Stiff,
    /// Targets are forces [N]. The target force pushes a mass against the tissue, with critical
    /// damping for the stiffness of the contact.
    Pushed,
    /// Targets are positions of the hand [m]. A spring pulls a damped mass towards the hand, and
    /// the tissue pushes it back.
    Compliant,
}

/// The emulated finger: its program of targets and its present state.
#[derive(Clone, Debug)]
pub struct Finger {
    kind: Kind,
    legs: Vec<Leg>,
    leg: usize,
    waited: usize,
    ramp_m_per_s: f64,
    tick_s: f64,
    clear_m: f64,
    /// Commanded position reached so far [m]: of the tip, or of a compliant finger's hand.
    command: f64,
    depth_m: f64,
    speed_m_per_s: f64,
}

impl Finger {
    /// A finger that starts `clear_m` above the surface, makes every hold of the drive, returns and
    /// waits `settle_s`. `None` for a recorded trace, which needs no finger.
    #[must_use]
    pub fn new(drive: &Drive, clear_m: f64, tick_s: f64, settle_s: f64) -> Option<Self> {
        let (kind, holds, ramp_m_per_s, hold_s) = match drive {
            Drive::Depth { holds_m, ramp_m_per_s, hold_s } => (Kind::Stiff, holds_m, *ramp_m_per_s, *hold_s),
            Drive::Hand { holds_m, ramp_m_per_s, hold_s } => (Kind::Compliant, holds_m, *ramp_m_per_s, *hold_s),
            Drive::Force { holds_n, ramp_m_per_s, hold_s } => (Kind::Pushed, holds_n, *ramp_m_per_s, *hold_s),
            Drive::Trace { .. } => return None,
        };
        let ticks = |seconds: f64| (seconds / tick_s).round().max(1.0) as usize;
        let mut legs: Vec<Leg> =
            holds.iter().enumerate().map(|(n, &target)| Leg { target, wait_ticks: ticks(hold_s), hold: Some(n) }).collect();
        legs.push(Leg { target: -clear_m, wait_ticks: ticks(settle_s), hold: None });
        Some(Self {
            kind,
            legs,
            leg: 0,
            waited: 0,
            ramp_m_per_s,
            tick_s,
            clear_m,
            command: if matches!(kind, Kind::Pushed) { 0.0 } else { -clear_m },
            depth_m: -clear_m,
            speed_m_per_s: 0.0,
        })
    }

    /// Advances by one tick; `force_n` is the force of the last tick along the line [N], positive
    /// if it pushes the finger out. Returns `None` once the motion has ended.
    pub fn next(&mut self, force_n: f64) -> Option<Step> {
        let leg = *self.legs.get(self.leg)?;
        let there = match self.kind {
            Kind::Stiff => {
                let there = self.approach(leg.target);
                self.depth_m = self.command;
                there
            }
            Kind::Compliant => {
                let there = self.approach(leg.target);
                let Impedance { mass_kg: mass, damping_n_s_per_m: damping, stiffness_n_per_m: stiffness } = FINGER;
                let push = stiffness * (self.command - self.depth_m) - damping * self.speed_m_per_s - force_n;
                self.accelerate(push / mass);
                there
            }
            // the retreat is commanded as a motion, not as a force
            Kind::Pushed if leg.hold.is_none() => {
                self.command = self.depth_m;
                let there = self.approach(-self.clear_m);
                self.depth_m = self.command;
                there
            }
            Kind::Pushed => {
                let Impedance { mass_kg: mass, damping_n_s_per_m: damping, .. } = FINGER;
                let felt = if self.depth_m > 0.0 { 1.5 * force_n.max(0.0) / self.depth_m } else { 0.0 };
                let critical = 2.0 * (felt * mass).sqrt();
                let push = leg.target - force_n - critical.max(damping / 4.0) * self.speed_m_per_s;
                self.accelerate(push / mass);
                true
            }
        };
        let mut hold_ends = None;
        if there {
            self.waited += 1;
            if self.waited >= leg.wait_ticks {
                self.waited = 0;
                self.leg += 1;
                hold_ends = leg.hold;
            }
        }
        Some(Step { depth_m: self.depth_m, hold_ends })
    }

    /// Moves the command toward the target at the ramp speed; true once it is there.
    fn approach(&mut self, target: f64) -> bool {
        let step = self.ramp_m_per_s * self.tick_s;
        let left = target - self.command;
        if left.abs() <= step {
            self.command = target;
            return true;
        }
        self.command += step.copysign(left);
        false
    }

    fn accelerate(&mut self, acceleration_m_per_s2: f64) {
        let speed = self.speed_m_per_s + acceleration_m_per_s2 * self.tick_s;
        self.speed_m_per_s = speed.clamp(-self.ramp_m_per_s, self.ramp_m_per_s);
        self.depth_m += self.speed_m_per_s * self.tick_s;
    }
}
