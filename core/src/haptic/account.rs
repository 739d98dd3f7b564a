//! The energy account, the last stage of the force path: it pays for every force before the force
//! is sent, and sends none that it cannot pay for.
//!
//! The balance is the energy that the hand may still be given. Work that the hand does on the loop
//! raises it and work that the loop does on the hand lowers it, as in the passivity observer of
//! Hannaford and Ryu (Time-domain passivity control of haptic interfaces, IEEE Trans. Robotics and
//! Automation 18, 2002). Their controller dissipates after energy has been created; ours reserves,
//! for every force that is on its way, the most work that it can still do, and shortens a new force
//! until the balance covers it. Energy bounding (Kim and Ryu, Robotics and Autonomous Systems 58,
//! 2010) bounds the change of the force in a sample in a similar way, from the hand's damping.
//!
//! ```text
//! charge    E <- E - W - q R         W: work by the readings; R: rise of the force along each axis
//! unread    E <- E - e |dF|          e: largest error of a position that no reading told
//! ceiling   E <- min(E, e0 + S)      S: what the tissue can return; zero once the contact is over
//! refill    E <- E + P T               while E < e0 + S
//! debt      E <- min(E + H T/0.2 s, 0)  while E < 0; H: what the ceiling withheld in this contact
//! send      s F, with s |F| D(F, d) + q R <= E - sum over the forces on their way of |G| D(G, j)
//!
//! D(G, j) = max(0, (v + q/(n T) + a n T/2) T + a T^2 (j + 1/2 + l)), v = u.G/|G|, a = a0 + c |G|/m
//! ```
//!
//! A force is also shortened to what the account could pay for in every tick of its way, as if all
//! forces on their way were as long: it would else alternate from tick to tick, and pay for rises.
//!
//! `D(G, j)` bounds the displacement along a force `G` that begins to act in `j` ticks, during one
//! tick, behind a lag of `l` ticks: `u` is the mean velocity over the last `n` ticks, known to one
//! count `q` and one window's acceleration. While the probe accelerates by less than `a`,
//! everything that was sent is paid for, and the hand is given at most `e0 + P t`. Beyond `a` the
//! balance falls below zero, and no force is sent until it has recovered, so that only what was on
//! its way is given beyond, once. What the ceiling withheld is lost within 0.2 s, so that a hand
//! that kneads saves up nothing that could shake it later. What of it meets a debt pays the debt,
//! because the hand gave it in the same contact, and at the contact's end all of it does.
//!
//! A reading is half a count off at most. Summed by parts, the work that the readings do not tell
//! is at most that times the variation of the force, so a rise of the force pays for what counts
//! can hide in it and in the fall that follows, `q R`. The refill `P` gives back what a hand's own
//! motion varies the force by (`VARIATION_N_PER_S` in `bound.rs`), and the allowance `e0` covers
//! one rise to the largest force: at the touch a rise is due before the hand has done the work.
//! SAFETY.md derives the bound; [`EnergyAccount::bound`] evaluates it.
//!
//! A tick without a reading is no tick without work: its position is extrapolated, and pays in the
//! same way, by its largest error. So do a period that was missed, and the tick of a fault. From
//! the second such tick on, and behind a jump, a force is also paid for the largest error of the
//! pace. A reading further off than any motion leads is as good as none. If the next one is as
//! well, the sensor has jumped: the largest error along the force is charged, and the readings
//! count from there.
//!
//! * in: position [m], force sent last [N], the tissue's force and depth [N, m]
//! * out: the force to send [N], in the same direction and not longer
//! * cost: 190 instructions of a Cortex-M4F and 30 per tick of delay, estimated
//! * failures: [`Fault::EnergyCreated`] if the balance is lower than any motion of a hand explains

mod bound;
mod settings;

use nalgebra::Vector3;

pub use bound::EnergyBound;
pub use settings::AccountSettings;

use super::device::DeviceSpec;
use super::seen::{Monitor, Seen, Shaper};
use super::{RINGS_S, between, length};
use crate::fault::{BuildError, ClampFlags, Fault};
use crate::lanes::sqrt;
use crate::stages::output::Output;

/// Number of sent forces that are kept until they act, and of positions for the velocity, whose
/// window is shorter than this.
/// Source: derived; the longest delay, and the force of this tick. The best window for counts of 55
/// um is six ticks ([`EnergyAccount::build`]).
const LINE: usize = DeviceSpec::MOST_DELAY_TICKS as usize + 1;
/// Time after the last force within which a new touch belongs to the same contact [s], besides
/// delay and lag: no hand taps faster, so touches that follow sooner are a limit cycle. Source:
/// chosen; above the 19 ms between the bounces of a flat tip, which drew 20 mJ in 30 s while each
/// touch was a contact of its own (DECISIONS.md).
const KEPT_S: f32 = 0.02;
/// Lags of the amplifier after which its force has all but faded (1): `exp(-3)` is 5 %.
/// Source: chosen; that share.
const LAGS: f32 = 3.0;

/// Most missed periods that are charged.
/// Source: derived; the watchdog of a board ends the force after 4.5 of them, so that a longer gap
/// is charged as twice that.
const MOST_MISSED: u16 = 9;

/// Energy at the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Energy that the hand may still be given [J]; below zero if it got more than was reserved.
    pub balance_j: f32,
    /// Energy given to the hand since the touch, as charged [J]; negative while the tissue stores
    /// energy.
    pub given_j: f32,
    /// Largest `given_j` so far in this contact, at least zero [J].
    pub created_j: f32,
}

/// The account: balance, forces on their way, and the last positions.
#[derive(Clone, Copy, Debug)]
pub struct EnergyAccount {
    allowance_j: f32,
    /// Refill per tick [J].
    refill_j: f32,
    /// A count of the position [m].
    count_m: f32,
    /// Force that the amplifier gives at the end of the tick: it follows the delayed force with the
    /// declared lag [N].
    lagging_n: Vector3<f32>,
    /// Share of the gap between the two that a tick leaves, and its mean over the tick (1).
    lag_left: f32,
    lag_mean: f32,
    lag_ticks: f32,
    /// Mean age of a force when it acts, and the same for a force that is held: the ticks for which
    /// its parts on the way act, and the sum of their ages [ticks].
    late: f32,
    held_ticks: f32,
    held_late: f32,
    /// Ring of the forces sent, and the index at which the next one is stored.
    line_n: [Vector3<f32>; LINE],
    next: u8,
    delay_ticks: u8,
    /// Ring of the last positions [m], the index of the newest, and the window of the velocity.
    past_m: [Vector3<f32>; LINE],
    newest: u8,
    window_ticks: u8,
    /// Last position that was read [m], and the mean displacement per tick since the one before it
    /// [m].
    read_m: Vector3<f32>,
    pace_m: Vector3<f32>,
    /// Ticks between these two readings, and since the last one [ticks].
    paced_ticks: f32,
    unread_ticks: f32,
    /// Distance that a tick may lead further than a pace tells that is older than a tick [m].
    astray_m: f32,
    /// Displacement of the readings by jumps of the sensor [m], and whether the last one was off.
    zero_m: Vector3<f32>,
    jumped: bool,
    /// Force that acted last [N].
    acted_n: Vector3<f32>,
    /// Mean displacement per tick over the window [m].
    moved_m: Vector3<f32>,
    /// Displacement per tick that the counts hide [m].
    hidden_m: f32,
    /// Displacement by the hand's acceleration within a tick, `a0 T^2` [m], that by a force,
    /// `c T^2 / m` [m/N], and that by the sharpest motion of a hand, `(b + F_max/m) T^2` [m].
    hand_m: f32,
    handle_m_per_n: f32,
    sharp_m: f32,
    /// Ticks since a force was sent, those after which it acts no longer, and those after which the
    /// contact is over.
    idle_ticks: u16,
    acts_ticks: u16,
    kept_ticks: u16,
    balance_j: f32,
    /// Energy that the tissue can return [J], and the share of it that a tick forgets (1).
    stored_j: f32,
    forgets: f32,
    /// Energy of the hand that the ceiling withheld in this contact, as far as it is not lost [J].
    withheld_j: f32,
    given_j: f32,
    created_j: f32,
    bound: EnergyBound,
}

impl EnergyAccount {
    /// Opens an empty account: the allowance is there after the time that arming takes.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting or the number of the device.
    #[inline]
    pub fn build(settings: &AccountSettings, device: &DeviceSpec, tick_s: f32) -> Result<Self, BuildError> {
        const { assert!(256 % LINE == 0, "the index wraps at 256") };
        settings.check()?;
        device.check()?;
        let (mut lag_left, mut lag_mean) = (0.0, 0.0);
        if device.lag_s > 0.0 {
            // exp(-x) from the series of exp(x / 4)
            let x = tick_s / device.lag_s;
            let y = 0.25 * x;
            let quarter = 1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y / 24.0)));
            let half = quarter * quarter;
            lag_left = 1.0 / (half * half);
            lag_mean = (1.0 - lag_left) / x;
        }
        let hand_m = settings.acceleration_m_per_s2 * tick_s * tick_s;
        // the window in which a count and the hand's acceleration leave the least doubt
        let best = if hand_m > 0.0 { sqrt(2.0 * device.count_m / hand_m) + 0.5 } else { 1.0 };
        let window = between(best, 1.0, f32::from(DeviceSpec::MOST_DELAY_TICKS)) as u8;
        let bound = Self::bound(settings, device, tick_s, 0);
        let acts_ticks = u16::from(device.delay_ticks) + (LAGS * device.lag_s / tick_s + 0.5) as u16;
        let (ticks, lag) = (f32::from(device.delay_ticks) + 1.0, device.lag_s / tick_s);
        Ok(Self {
            allowance_j: settings.allowance_j + device.count_m * device.max_force_n,
            refill_j: bound.lasting_w * tick_s,
            count_m: device.count_m,
            lagging_n: Vector3::zeros(),
            lag_left,
            lag_mean,
            lag_ticks: lag,
            late: ticks - 0.5 + lag,
            held_ticks: ticks + lag,
            held_late: ticks * (0.5 * ticks + lag) + lag * (0.5 + lag),
            line_n: [Vector3::zeros(); LINE],
            next: 0,
            delay_ticks: device.delay_ticks,
            past_m: [Vector3::zeros(); LINE],
            newest: 0,
            window_ticks: window,
            read_m: Vector3::zeros(),
            pace_m: Vector3::zeros(),
            paced_ticks: 1.0,
            unread_ticks: 0.0,
            astray_m: 0.0,
            zero_m: Vector3::zeros(),
            jumped: false,
            acted_n: Vector3::zeros(),
            moved_m: Vector3::zeros(),
            hidden_m: device.count_m / f32::from(window),
            hand_m,
            handle_m_per_n: settings.handle_share / device.mass_kg * tick_s * tick_s,
            sharp_m: Self::sharp_m_per_s2(device) * tick_s * tick_s,
            idle_ticks: u16::MAX,
            acts_ticks,
            kept_ticks: acts_ticks + (KEPT_S / tick_s + 0.5) as u16,
            balance_j: 0.0,
            stored_j: 0.0,
            forgets: tick_s / RINGS_S,
            withheld_j: 0.0,
            given_j: 0.0,
            created_j: 0.0,
            bound,
        })
    }

    /// Charges what the hand was given since the last tick: first for periods that passed without
    /// one, in which the device held the last force, then up to this reading [m], or without one.
    /// `touched` tells whether the patch was touched then. Call it once per tick, before anything
    /// can fail.
    pub fn charge(&mut self, missed: u16, read_m: Option<Vector3<f32>>, touched: bool) {
        for _ in 0..missed.min(MOST_MISSED) {
            self.charge_period(None, touched);
            self.sent(self.sent_n(1));
        }
        self.charge_period(read_m, touched);
    }

    /// Charges the work of the force that acted in one period.
    #[inline(never)] // inlined where it is called, it would take 200 bytes more of the flash
    fn charge_period(&mut self, read_m: Option<Vector3<f32>>, touched: bool) {
        let delayed_n = self.sent_n(1 + self.delay_ticks);
        let gap_n = self.lagging_n - delayed_n;
        let acting_n = delayed_n + gap_n * self.lag_mean;
        self.lagging_n = delayed_n + gap_n * self.lag_left;
        self.change_to(acting_n);
        let work_j = acting_n.dot(&self.moved_to(read_m, &acting_n));
        self.pay_out(work_j);
        let returned_j = self.withheld_j * self.forgets;
        self.withheld_j -= returned_j;
        self.pay_debt(returned_j);
        if self.balance_j < self.allowance_j + self.stored_j {
            self.balance_j += self.refill_j;
        }
        if !touched && self.idle_ticks > self.kept_ticks {
            self.pay_debt(self.withheld_j);
            self.end_contact();
        }
    }

    /// Records that this force [N] follows the one that acted. Where the position at the change was
    /// not read, the work that no reading will tell is the change times the largest error there.
    #[inline(never)]
    fn change_to(&mut self, acting_n: Vector3<f32>) {
        if self.unread_ticks > 0.0 {
            self.pay_out(self.error_m() * (acting_n - self.acted_n).abs().sum());
        }
        self.acted_n = acting_n;
    }

    /// Largest error along an axis of the position to which the last readings lead [m].
    fn error_m(&self) -> f32 {
        let (ago, paced) = (self.unread_ticks, self.paced_ticks);
        (ago + 0.5) * self.count_m + 0.5 * ago * (ago + paced) * self.sharp_m
    }

    /// Records a position and returns the displacement since the last tick [m], in which this force
    /// acted [N]. A position that is not read is the last one that was, moved on at the pace
    /// between the last two.
    fn moved_to(&mut self, read_m: Option<Vector3<f32>>, acting_n: &Vector3<f32>) -> Vector3<f32> {
        self.unread_ticks += 1.0;
        let ago = self.unread_ticks;
        let mut position_m = self.read_m + self.pace_m * ago;
        if let Some(read_m) = read_m {
            let off_m = read_m - self.zero_m - position_m;
            let most_m = self.error_m();
            if off_m.amax() <= most_m {
                position_m += off_m;
                self.pace_m = (position_m - self.read_m) / ago;
                (self.read_m, self.paced_ticks, self.unread_ticks, self.jumped) = (position_m, ago, 0.0, false);
            } else if self.jumped {
                self.pay_out(most_m * acting_n.abs().sum());
                self.zero_m += off_m;
                // the pace stays, and is older
                self.paced_ticks += 2.0 * ago;
                (self.read_m, self.unread_ticks, self.jumped) = (position_m, 0.0, false);
            } else {
                self.jumped = true;
            }
        }
        let stale_ticks = self.unread_ticks + 0.5 * (self.paced_ticks - 1.0);
        self.astray_m = if stale_ticks > 1.0 { self.count_m + (stale_ticks + 1.0) * self.sharp_m } else { 0.0 };
        let past_m = |ago: u8| self.past_m.get(usize::from(self.newest.wrapping_sub(ago)) % LINE).copied().unwrap_or_default();
        let displacement_m = position_m - past_m(0);
        self.moved_m = (position_m - past_m(self.window_ticks - 1)) / f32::from(self.window_ticks);
        self.newest = self.newest.wrapping_add(1);
        if let Some(newest) = self.past_m.get_mut(usize::from(self.newest) % LINE) {
            *newest = position_m;
        }
        displacement_m
    }

    /// Takes energy that the hand was given, or may have been, off the balance [J].
    fn pay_out(&mut self, energy_j: f32) {
        self.balance_j -= energy_j;
        self.given_j += energy_j;
        if self.given_j > self.created_j {
            self.created_j = self.given_j;
        }
    }

    /// Most work that counts can hide in a rise of the force to this one [N] and in its fall
    /// [J]. The error of a reading along an axis is that axis's own, so axes are added.
    #[inline(never)] // copies would take 300 bytes more of the board's flash
    fn hidden_j(&self, force_n: &Vector3<f32>) -> f32 {
        let last_n = self.sent_n(1);
        let rise_n = force_n.zip_map(&last_n, |now, last| {
            let rise = now.abs() - if now * last > 0.0 { last.abs() } else { 0.0 };
            if rise > 0.0 { rise } else { 0.0 }
        });
        self.count_m * rise_n.sum()
    }

    /// Lowers the balance to the allowance and what the tissue can return, and keeps the rest.
    fn cap(&mut self) {
        let most_j = self.allowance_j + self.stored_j;
        if self.balance_j > most_j {
            self.withheld_j += self.balance_j - most_j;
            self.balance_j = most_j;
        }
    }

    /// Raises a balance below zero by this energy [J], to zero at most: more would feed a limit
    /// cycle.
    fn pay_debt(&mut self, energy_j: f32) {
        if self.balance_j < 0.0 {
            self.balance_j = between(self.balance_j + energy_j, self.balance_j, 0.0);
        }
    }

    /// Forgets the contact: the balance is the allowance at most.
    fn end_contact(&mut self) {
        (self.given_j, self.created_j, self.stored_j) = (0.0, 0.0, 0.0);
        self.cap();
        self.withheld_j = 0.0;
    }

    /// The longest force along `force_n` [N] that the balance pays for. The tissue's force
    /// `tissue_n` at `depth_m` can return `F d / 2`, and `F` over the distance `apart_m` by which
    /// the guard holds the shown tip behind the sensed one [N, m].
    fn pay(&mut self, force_n: &Vector3<f32>, tissue_n: &Vector3<f32>, depth_m: f32, apart_m: f32) -> Vector3<f32> {
        let stored_j = length(tissue_n) * (0.5 * depth_m + apart_m);
        self.stored_j -= self.stored_j * self.forgets;
        if stored_j > self.stored_j {
            self.stored_j = stored_j;
        }
        self.cap();
        let length_n = length(force_n);
        if length_n == 0.0 {
            return *force_n;
        }
        let rise_j = self.hidden_j(force_n);
        let cost_j = rise_j + length_n * self.way_m(force_n, length_n, 1.0, self.late);
        // A force that the account cannot pay for in every tick of its way would fall again in the
        // next one, and each rise costs a count.
        let held_j = rise_j + length_n * self.way_m(force_n, length_n, self.held_ticks, self.held_late);
        let left_j = self.balance_j - self.reserved_j();
        if left_j <= 0.0 {
            return Vector3::zeros();
        }
        // both costs are convex in the length: a shorter force costs no more than its share
        let share = between(left_j / cost_j, 0.0, self.balance_j / held_j);
        if share < 1.0 { force_n * share } else { *force_n }
    }

    /// The force that was sent so many ticks ago [N]; the last one was sent one tick ago.
    #[inline(never)] // copies would take 100 bytes more of the board's flash
    fn sent_n(&self, ago: u8) -> Vector3<f32> {
        self.line_n.get(usize::from(self.next.wrapping_sub(ago)) % LINE).copied().unwrap_or_default()
    }

    /// The most work that the forces on their way can still do [J].
    fn reserved_j(&self) -> f32 {
        let lag = self.lag_ticks;
        let mut reserved_j = 0.0;
        for ago in 1..=self.delay_ticks {
            let sent_n = self.sent_n(ago);
            let length_n = length(&sent_n);
            if length_n > 0.0 {
                reserved_j += length_n * self.way_m(&sent_n, length_n, 1.0, self.late - f32::from(ago));
            }
        }
        let length_n = length(&self.lagging_n);
        if lag > 0.0 && length_n > 0.0 {
            reserved_j += length_n * self.way_m(&self.lagging_n, length_n, lag, lag * (0.5 + lag));
        }
        reserved_j
    }

    /// Largest displacement along a force [N] of this length that acts for `share` of a tick,
    /// `late` ticks from now [m].
    #[inline(never)] // as above
    fn way_m(&self, force_n: &Vector3<f32>, length_n: f32, share: f32, late: f32) -> f32 {
        let sharp_m = self.hand_m + self.handle_m_per_n * length_n;
        let unseen_m = self.hidden_m + self.astray_m + 0.5 * sharp_m * f32::from(self.window_ticks);
        let moves_m = self.moved_m.dot(force_n) / length_n + unseen_m;
        let way_m = moves_m * share + sharp_m * late;
        if way_m > 0.0 { way_m } else { 0.0 }
    }

    /// Records the force sent in this tick [N].
    #[inline(never)]
    pub fn sent(&mut self, force_n: Vector3<f32>) {
        self.pay_out(self.hidden_j(&force_n));
        if let Some(newest) = self.line_n.get_mut(usize::from(self.next) % LINE) {
            *newest = force_n;
        }
        self.next = self.next.wrapping_add(1);
        let idle = force_n.dot(&force_n) == 0.0;
        self.idle_ticks = if idle { self.idle_ticks.saturating_add(1) } else { 0 };
    }

    /// Ends the forces on their way, because the device is released.
    pub fn released(&mut self) {
        self.change_to(Vector3::zeros());
        (self.line_n, self.lagging_n) = ([Vector3::zeros(); LINE], Vector3::zeros());
        if self.acts() {
            self.idle_ticks = self.acts_ticks + 1;
        }
    }

    /// Whether a force may act on the hand, the last one that was sent or one on its way.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.idle_ticks <= self.acts_ticks
    }

    /// Energy at the hand.
    #[must_use]
    pub fn energy(&self) -> Energy {
        Energy { balance_j: self.balance_j, given_j: self.given_j, created_j: self.created_j }
    }
}

impl Monitor for EnergyAccount {
    fn judge(&mut self, _: &Seen) -> Result<(), Fault> {
        // further below zero than any motion of a hand: the device is not what its profile says
        if self.balance_j < -self.bound.at_once_j { Err(Fault::EnergyCreated) } else { Ok(()) }
    }

    /// Ends the contact and the forces on their way. The balance stays, or falls to the allowance
    /// if it is above it, so that clearing a fault raises it by nothing.
    fn reset(&mut self) {
        self.released();
        self.pay_debt(self.withheld_j);
        self.end_contact();
    }
}

impl Shaper for EnergyAccount {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        let Output { force_n: tissue_n, depth_m, apart_m, .. } = &seen.output;
        let paid_n = self.pay(&force_n, tissue_n, *depth_m, *apart_m);
        if paid_n != force_n {
            flags.set(ClampFlags::ENERGY);
        }
        paid_n
    }

    fn reset(&mut self) {}
}
