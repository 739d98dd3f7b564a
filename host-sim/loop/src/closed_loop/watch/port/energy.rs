//! I11: the work given to the hand in any window of time is at most the bound for that window and
//! what the tissue could return when it began.
//!
//! **The bound** follows from the profile and from how sharply a hand can turn round. A loop can
//! withdraw a force only after the force has acted for the time `t` of delay, lag and one tick, and
//! it learns a velocity from positions that are up to `n` = 7 ms old. A hand that turns by
//! `A = a + F / m` (its own sharpest acceleration, and that of the bare handle by the motors) is
//! carried along the largest force `F` by `A t^2 / 2` meanwhile, and by `A t n / 2` because the
//! velocity was an old one; behind a lag `l` the force fades away and acts over `A l (l + T) / 2`
//! more. Where the probe is within a count `q` nobody can see, so that the work of a force is known
//! to half a count times its variation. A press with the largest force and a retreat vary it by
//! `2 F`, and a hand at work by up to `f` per second; a loop that is to take nothing from such a
//! hand may be wrong by as much:
//!
//! ```text
//! at once   e + F (A (t (t + n) + l (l + T)) / 2 + q)
//! lasting   p + f q / 2
//! ```
//!
//! `e` and `p` are what a hand does not feel. SAFETY.md prints the numbers; a test compares them
//! with those that the loop states.
//!
//! **What the tissue could return** at the start of a window is at most the largest force that
//! acted in this contact times the true depth: the force grows with depth, so it does no more work
//! on the way out than at its largest. A window could instead start only where nothing touches and
//! no force acts, where nothing can be returned. That needs no geometry, but a contact that took
//! 10 mJ could then shake the hand with 10 mJ. The start of every tick is used here, and the
//! shallowest moments of a motion make the sharpest windows. The product costs one query of the
//! geometry in each tick with a force. The force of the moment would be smaller than the largest of
//! the contact, but damping takes most of it away while a probe leaves, and the tissue returns that
//! energy once the probe is slow.

use palpate::haptic::device::DeviceSpec;

use super::Truth;
use crate::closed_loop::watch::Broken;
use palpate_tissue::scene::TICK_S;

/// Sharpest acceleration of a hand [m/s^2]: a stylus that is stopped dead at 1.5 m/s within 7 ms.
const HAND_M_PER_S2: f64 = 200.0;
/// Age of the oldest position from which a velocity is computed [s].
const VELOCITY_S: f64 = 7e-3;
/// Energy [J] and power [W] that no hand feels.
const UNFELT_J: f64 = 20e-6;
const UNFELT_W: f64 = 30e-6;
/// Largest variation of the force under a hand that kneads or slides, rises and falls [N/s].
const VARIES_N_PER_S: f64 = 150.0;

/// The most energy that a hand may be given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortBound {
    /// In a window however short [J].
    pub at_once_j: f64,
    /// And for as long as the window lasts [W].
    pub lasting_w: f64,
}

impl PortBound {
    /// The bound for this device.
    #[must_use]
    pub fn of(device: &DeviceSpec) -> Self {
        let (most_n, count_m) = (f64::from(device.max_force_n), f64::from(device.count_m));
        let acts_s = (f64::from(device.delay_ticks) + 1.0) * TICK_S + f64::from(device.lag_s);
        let sharpest_m_per_s2 = HAND_M_PER_S2 + most_n / f64::from(device.mass_kg);
        let lag_s = f64::from(device.lag_s);
        let way_m = 0.5 * sharpest_m_per_s2 * (acts_s * (acts_s + VELOCITY_S) + lag_s * (lag_s + TICK_S));
        Self { at_once_j: UNFELT_J + most_n * (way_m + count_m), lasting_w: UNFELT_W + 0.5 * VARIES_N_PER_S * count_m }
    }
}

/// Adds up the work at the port and checks it.
#[derive(Clone, Copy, Debug)]
pub struct EnergyWatch {
    bound: PortBound,
    /// Work given since the first tick, less what the bound allows for that time [J].
    beyond_j: f64,
    /// The least that this may be compared with: the work at the start of a window, and what the
    /// tissue could return then [J].
    least_j: f64,
    /// Largest force in this contact [N].
    most_n: f64,
    contact: Contact,
}

/// Energy of a contact and of the worst one so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Given to the hand since the touch [J]; negative while the tissue stores energy.
    pub given_j: f64,
    /// Largest `given_j` so far, at least zero: the energy created [J].
    pub created_j: f64,
    /// Energy created by the worst contact [J].
    pub worst_j: f64,
}

impl EnergyWatch {
    /// Creates the watch for this device.
    #[must_use]
    pub fn of(device: &DeviceSpec) -> Self {
        let bound = PortBound::of(device);
        Self { bound, beyond_j: 0.0, least_j: 0.0, most_n: 0.0, contact: Contact::default() }
    }

    /// Whether a force has acted since the tip was last outside without a force.
    pub(super) fn in_contact(&self) -> bool {
        self.most_n > 0.0
    }

    /// The bound that is checked.
    #[must_use]
    pub fn bound(&self) -> PortBound {
        self.bound
    }

    /// Energy of the present contact and of the worst.
    #[must_use]
    pub fn contact(&self) -> Contact {
        self.contact
    }

    /// Checks a tick that ends at this depth [m]; `free` if a contact is over: the tip is outside,
    /// and no force acts.
    pub(super) fn check(&mut self, truth: &Truth, depth_m: f64, free: bool) -> Result<(), Broken> {
        self.beyond_j += truth.work_j - self.bound.lasting_w * TICK_S;
        self.contact.given_j += truth.work_j;
        self.contact.created_j = self.contact.created_j.max(self.contact.given_j);
        self.contact.worst_j = self.contact.worst_j.max(self.contact.created_j);
        if free {
            self.contact = Contact { worst_j: self.contact.worst_j, ..Contact::default() };
        }
        let given_j = self.beyond_j - self.least_j;
        self.most_n = if free { 0.0 } else { self.most_n.max(truth.mean_n.norm()) };
        self.least_j = self.least_j.min(self.beyond_j + self.most_n * depth_m);
        // written so that NaN fails
        if given_j <= self.bound.at_once_j { Ok(()) } else { Err(Broken { id: "I11", what: "energy given" }) }
    }
}
