//! The energy account: what it charges, what it reserves, and what it lets out.

use palpate::haptic::account::{AccountSettings, Energy, EnergyAccount};
use palpate::haptic::cycle::Ask;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::seen::{Monitor, Seen, Shaper};
use palpate::{ClampFlags, Fault, Output, Vector3};

use crate::bench::{Bench, limits, pushing, set, stylus};

/// An account with the position of its probe.
pub struct Port {
    pub account: EnergyAccount,
    pub at_m: Vector3<f32>,
    pub touched: bool,
    /// Whether the next reading is missing, and whether the period before it was missed.
    pub held: bool,
    pub late: bool,
}

impl Port {
    pub fn with(device: DeviceSpec, settings: AccountSettings) -> Self {
        let account = EnergyAccount::build(&settings, &device, 1e-3).unwrap();
        Self { account, at_m: Vector3::zeros(), touched: true, held: false, late: false }
    }

    pub fn new(delay_ticks: u8, lag_s: f32, count_m: f32) -> Self {
        Self::with(DeviceSpec { delay_ticks, lag_s, count_m, ..stylus() }, AccountSettings::DEFAULT)
    }

    /// A handle so light that a millimetre in a tick is a motion and no jump of its sensor.
    pub fn light(delay_ticks: u8, lag_s: f32) -> Self {
        let device = DeviceSpec { delay_ticks, lag_s, mass_kg: 2e-3, ..stylus() };
        Self::with(device, AccountSettings::DEFAULT)
    }

    /// The probe moves [m].
    pub fn moves(&mut self, way_m: [f32; 3]) -> Result<Energy, Fault> {
        self.at_m += Vector3::from(way_m);
        let limits = limits();
        let read_m = if self.held { None } else { Some(self.at_m) };
        self.account.charge(u16::from(self.late), read_m, self.touched);
        self.account.judge(&Seen::none(&limits))?;
        Ok(self.account.energy())
    }

    /// The probe moves along z [m], then a force along z is sent [N], whatever the account says.
    pub fn step(&mut self, way_m: f32, force_n: f32) -> Energy {
        let energy = self.moves([0.0, 0.0, way_m]).unwrap();
        self.account.sent(Vector3::z() * force_n);
        energy
    }

    /// Force that the account pays for [N] when tissue at this depth [m] asks for `force_n`.
    pub fn pays(&mut self, force_n: [f32; 3], depth_m: f32) -> Vector3<f32> {
        let (limits, mut flags) = (limits(), ClampFlags::default());
        let output = Output { force_n: force_n.into(), depth_m, ..Output::NONE };
        let paid_n = self.account.shape(force_n.into(), &Seen { output, ..Seen::none(&limits) }, &mut flags);
        assert_eq!(flags.contains(ClampFlags::ENERGY), paid_n != Vector3::from(force_n), "a shortened force is flagged");
        paid_n
    }
}

/// Balance [J] without the refill of these ticks.
fn balance_j(energy: Energy, ticks: u16) -> f32 {
    energy.balance_j - 30e-9 * f32::from(ticks)
}

#[test]
fn work_is_force_times_motion_with_the_force_that_acts() {
    for delay in 0..=7_u8 {
        let mut port = Port::light(delay, 0.0);
        for n in 0..=delay {
            assert_eq!(port.moves([0.0, 0.0, 0.1e-3]).unwrap().given_j, 0.0, "tick {n}: nothing sent has arrived");
            port.account.sent(Vector3::new(0.5, 0.0, 2.0));
        }
        let energy = port.moves([0.2e-3, 0.9e-3, -0.1e-3]).unwrap();
        assert!((energy.given_j + 0.1e-3).abs() < 1e-9, "delay {delay}: {energy:?}");
        let refilled = if delay == 0 { 1 } else { u16::from(delay) + 1 };
        assert!((balance_j(energy, refilled) - 0.1e-3).abs() < 1e-8, "what the hand gave is there: {energy:?}");
        assert_eq!(energy.created_j, 0.0, "what the tissue holds is not created");
    }
}

#[test]
fn the_most_that_was_given_since_the_touch_stays_until_the_contact_ends() {
    let mut port = Port::light(0, 0.0);
    port.step(0.0, 1.0);
    let out = port.step(0.2e-3, 1.0);
    assert!((out.created_j - 0.2e-3).abs() < 1e-9 && out.created_j == out.given_j, "{out:?}");
    let back = port.step(-0.1e-3, 1.0);
    assert!((back.given_j - 0.1e-3).abs() < 1e-9 && back.created_j == out.created_j, "{back:?}");
}

#[test]
fn the_ring_of_forces_outlasts_its_index() {
    let mut port = Port::light(7, 0.0);
    for n in 0..700_u16 {
        port.step(0.0, f32::from(n));
    }
    let energy = port.moves([0.0, 0.0, -1e-3]).unwrap();
    assert!((energy.given_j + 0.692).abs() < 1e-5, "the force sent eight ticks ago: {energy:?}");
}

#[test]
fn a_lagging_force_acts_as_a_first_order_low_pass_says() {
    // means over three ticks, for a force that is sent once
    for (lag_s, tolerance) in [(0.25e-3_f32, 0.02), (1e-3, 1e-3), (6e-3, 1e-3), (10e-3, 1e-3)] {
        let mut port = Port::light(0, lag_s);
        port.step(0.0, 1.0);
        let x = 1e-3 / lag_s;
        let falls = 1.0 - (-x).exp();
        for (tick, mean_n) in [1.0 - falls / x, falls * falls / x, (1.0 - falls) * falls * falls / x].into_iter().enumerate() {
            let before_j = port.account.energy().given_j;
            let found_n = (port.step(-1e-3, 0.0).given_j - before_j) / -1e-3;
            assert!((found_n / mean_n - 1.0).abs() < tolerance, "{lag_s} s, tick {tick}: {found_n} N, closed form {mean_n} N");
        }
    }
}

#[test]
fn the_balance_is_capped_by_what_tissue_can_return_and_by_the_allowance_after_the_contact() {
    let mut port = Port::light(1, 0.0);
    for _ in 0..10 {
        port.step(-1e-3, 2.0);
    }
    assert!(port.account.energy().balance_j > 15e-3);
    port.pays([0.0, 0.0, 2.0], 4e-3);
    let balance_j = port.account.energy().balance_j;
    assert!((balance_j - (20e-6 + 0.5 * 2.0 * 4e-3)).abs() < 1e-8, "F d / 2 and the allowance: {balance_j}");
    (0..100).for_each(|_| _ = port.step(0.0, 0.0));
    assert!(port.account.energy().balance_j > 1e-3, "a tip that rests in the tissue without a force is in contact");
    port.step(0.0, 1e-3);
    // the contact is over twenty ticks after the last force has acted
    port.touched = false;
    for n in 0..=21 {
        assert!(port.step(0.0, 0.0).balance_j > 1e-3, "tick {n}");
    }
    let energy = port.step(0.0, 0.0);
    assert!((energy.balance_j - 20e-6).abs() < 1e-8 && energy.given_j == 0.0, "{energy:?}");
}

#[test]
fn what_tissue_can_return_is_forgotten_while_its_force_rings() {
    let mut port = Port::light(1, 0.0);
    (0..20).for_each(|_| _ = port.step(-1e-3, 2.0));
    port.pays([0.0, 0.0, 2.0], 4e-3);
    // 4 mJ, which the tissue no longer holds, with a time constant of 0.2 s
    for (ticks, left) in [(1, 0.995), (199, 0.367), (400, 0.0495)] {
        (0..ticks).for_each(|_| _ = port.pays([0.0, 0.0, 2.0], 0.0));
        let balance_j = port.account.energy().balance_j;
        assert!((balance_j / (20e-6 + left * 4e-3) - 1.0).abs() < 2e-3, "{ticks} ticks: {balance_j}");
    }
}

#[test]
fn touches_belong_together_by_time_whatever_the_tick() {
    for (tick_s, lag_s, kept) in [(1e-3, 0.0, 21), (0.5e-3, 0.0, 41), (1e-3, 2e-3, 27)] {
        let device = DeviceSpec { delay_ticks: 1, lag_s, count_m: 0.0, ..stylus() };
        let account = EnergyAccount::build(&AccountSettings::DEFAULT, &device, tick_s).unwrap();
        let mut port = Port { account, at_m: Vector3::zeros(), touched: false, held: false, late: false };
        (0..3).for_each(|_| _ = port.step(-1e-3, 1.0));
        let ends = (0..100).find(|_| port.step(0.0, 0.0).given_j == 0.0);
        assert_eq!(ends, Some(kept + 1), "{tick_s} s, {lag_s} s");
    }
}

#[test]
fn a_guard_that_holds_the_shown_tip_back_returns_its_force_over_that_way() {
    let mut port = Port::light(1, 0.0);
    (0..20).for_each(|_| _ = port.step(-1e-3, 2.0));
    let limits = limits();
    let output = Output { force_n: Vector3::z() * 2.0, depth_m: 4e-3, apart_m: 3e-3, ..Output::NONE };
    port.account.shape(Vector3::z() * 2.0, &Seen { output, ..Seen::none(&limits) }, &mut ClampFlags::default());
    let balance_j = port.account.energy().balance_j;
    assert!((balance_j - (20e-6 + 4e-3 + 6e-3)).abs() < 1e-7, "{balance_j}");
}

#[test]
fn the_allowance_comes_back_at_its_rate_and_no_further() {
    let mut port = Port::new(1, 0.0, 0.0);
    port.step(0.0, 1.0);
    port.step(0.0, 0.0);
    let spent = port.step(1e-4, 0.0);
    assert!((balance_j(spent, 3) + 1e-4).abs() < 1e-8, "{spent:?}");
    let ticks = (1..20_000).find(|_| port.step(0.0, 0.0).balance_j >= 20e-6);
    assert!(ticks.is_some_and(|ticks| (3_990..4_010).contains(&ticks)), "0.12 mJ at 30 uW: {ticks:?}");
    (0..1000).for_each(|_| _ = port.step(0.0, 0.0));
    assert!(port.account.energy().balance_j < 20.1e-6);
}

#[test]
fn the_refill_goes_on_up_to_what_the_tissue_can_return() {
    let mut port = Port::new(1, 0.0, 0.0);
    (0..1000).for_each(|_| _ = port.step(0.0, 0.0));
    port.pays([0.0, 0.0, 2.0], 4e-3);
    (0..100).for_each(|_| _ = port.step(0.0, 0.0));
    let balance_j = port.account.energy().balance_j;
    assert!((balance_j - 23e-6).abs() < 0.1e-6, "the allowance and a tenth of a second of the refill: {balance_j}");
}

/// Longest displacement along a force of this length [N] that the account reserves for [m], from
/// the force that it pays for out of an allowance, on a probe that has moved evenly [m per tick].
fn reserved_m(device: DeviceSpec, way_m: f32, asked_n: f32) -> f32 {
    let settings = AccountSettings { allowance_j: 1e-3, refill_w: 1.0, ..AccountSettings::DEFAULT };
    let mut port = Port::with(device, settings);
    (0..100).for_each(|_| _ = port.step(way_m, 0.0));
    let paid_n = port.pays([0.0, 0.0, asked_n], 0.0).z;
    port.account.energy().balance_j / paid_n
}

#[test]
fn a_force_is_paid_for_over_its_delay_its_lag_a_count_and_the_acceleration() {
    let heavy = DeviceSpec { mass_kg: 5.0, ..stylus() };
    // the window of an ideal sensor is one tick: half of its acceleration is unseen
    let a_m = |force_n: f32| (3.0 + 0.7 * force_n / 5.0) * 1e-6;
    for (delay_ticks, lag_s) in [(0, 0.0), (1, 0.0), (4, 0.0), (7, 0.0), (0, 2e-3), (3, 5e-3)] {
        let way_m = 40e-6;
        let found_m = reserved_m(DeviceSpec { delay_ticks, lag_s, ..heavy }, way_m, 100.0);
        // a force that can be held: one in each tick of the delay, and the amplifier's
        let (ticks, lag) = (1.0 + f32::from(delay_ticks), lag_s * 1e3);
        let late = ticks * (0.5 * ticks + lag) + lag * (0.5 + lag);
        let right_m = (way_m + 0.5 * a_m(100.0)) * (ticks + lag) + a_m(100.0) * late;
        assert!((found_m / right_m - 1.0).abs() < 2e-2, "{delay_ticks} ticks, {lag_s} s: {found_m} m, not {right_m} m");
    }
    // counts of 54 um: a window of six ticks leaves a sixth of a count and three ticks of
    // acceleration
    let found_m = reserved_m(DeviceSpec { delay_ticks: 0, count_m: 54e-6, ..heavy }, 54e-6, 10.0);
    // and a rise pays for a count
    let right_m = 54e-6 + 9e-6 + a_m(10.0) * (3.0 + 0.5) + 54e-6;
    assert!((found_m / right_m - 1.0).abs() < 2e-2, "{found_m} m, not {right_m} m");
    // a light handle is driven by the force itself
    let light_m = reserved_m(DeviceSpec { delay_ticks: 0, mass_kg: 0.02, ..stylus() }, 40e-6, 100.0);
    assert!(light_m > 1.3 * reserved_m(DeviceSpec { delay_ticks: 0, ..heavy }, 40e-6, 100.0), "{light_m} m");
}

#[test]
fn a_force_into_which_the_probe_moves_costs_nothing_and_keeps_its_direction() {
    let mut port = Port::new(1, 0.0, 0.0);
    (0..10).for_each(|_| _ = port.step(-0.2e-3, 0.0));
    assert_eq!(port.pays([0.0, 0.0, 2.0], 1e-3), Vector3::new(0.0, 0.0, 2.0));
    let mut port = Port::new(1, 0.0, 0.0);
    (0..1000).for_each(|_| _ = port.step(0.05e-3, 0.0));
    let paid_n = port.pays([0.3, 0.0, 1.0], 0.0);
    assert!(paid_n.z > 0.0 && paid_n.norm() < 0.9, "{paid_n}");
    assert!(paid_n.cross(&Vector3::new(0.3, 0.0, 1.0)).norm() < 1e-6, "{paid_n}");
}

#[test]
fn forces_on_their_way_are_reserved_for() {
    let settings = AccountSettings { allowance_j: 1e-3, refill_w: 1.0, ..AccountSettings::DEFAULT };
    let paid_n = |sent_n: f32, delay_ticks: u8, lag_s: f32| {
        let mut port = Port::with(DeviceSpec { delay_ticks, lag_s, ..stylus() }, settings);
        (0..100).for_each(|_| _ = port.step(20e-6, 0.0));
        (0..6).for_each(|_| {
            port.moves([0.0, 0.0, 0.0]).unwrap();
            port.at_m.z += 20e-6;
            port.account.sent(Vector3::z() * sent_n);
        });
        port.pays([0.0, 0.0, 100.0], 0.0).z
    };
    let [none, two, more] = [0.0, 2.0, 2.1].map(|n| paid_n(n, 4, 0.0));
    assert!(two < 0.9 * none && more < two, "{none} {two} {more}");
    assert!(paid_n(2.0, 4, 5e-3) < 0.9 * paid_n(0.0, 4, 5e-3));
    // without a delay, the amplifier alone holds a force that goes on
    assert!(paid_n(2.0, 0, 5e-3) < 0.9 * paid_n(0.0, 0, 5e-3));
    // of a heavy handle, in closed form: every force on its way acts for a tick, when its turn
    // comes
    let heavy = DeviceSpec { delay_ticks: 4, mass_kg: 5.0, ..stylus() };
    let mut port = Port::with(heavy, settings);
    (0..100).for_each(|_| _ = port.step(0.0, 0.0));
    (0..4).for_each(|_| _ = port.step(0.0, 15.0));
    port.moves([0.0; 3]).unwrap();
    let a_m = |force_n: f32| (3.0 + 0.7 * force_n / 5.0) * 1e-6;
    let reserved_j: f32 = (0..4_u8).map(|late| 15.0 * a_m(15.0) * (f32::from(late) + 1.0)).sum();
    let found_n = port.pays([0.0, 0.0, 100.0], 0.0).z;
    let right_n = (port.account.energy().balance_j - reserved_j) / (a_m(100.0) * 5.0);
    assert!((found_n / right_n - 1.0).abs() < 1e-3, "{found_n} N, not {right_n} N: {reserved_j} J");
}

/// Without that, a force at rest that the account cannot pay for would alternate from tick to tick,
/// and every rise would cost a count.
#[test]
fn a_force_at_rest_that_is_not_paid_for_does_not_alternate() {
    for delay in [1, 2, 4, 7] {
        let mut port = Port::new(delay, 0.0, 10e-6);
        (0..300).for_each(|_| _ = port.step(0.0, 0.0));
        let mut last_n = 0.0;
        for tick in 0..2_000 {
            let sent_n = port.pays([0.0, 0.0, 3.0], 0.0).z;
            assert!(tick < 10 || sent_n >= 0.999 * last_n, "delay {delay}, tick {tick}: {sent_n} N after {last_n}");
            port.step(0.0, sent_n);
            last_n = sent_n;
        }
        assert!(last_n > 0.01, "delay {delay}: {last_n} N");
    }
}

#[test]
fn work_that_the_hand_may_still_do_is_not_credited_in_advance() {
    let settings = AccountSettings { allowance_j: 1e-3, refill_w: 1.0, ..AccountSettings::DEFAULT };
    let paid_n = |sent_n: f32| {
        let mut port = Port::with(DeviceSpec { delay_ticks: 4, ..stylus() }, settings);
        (0..100).for_each(|_| _ = port.step(-0.2e-3, sent_n));
        port.pays([100.0, 0.0, 0.0], 0.0).x
    };
    // the probe moves into the forces on their way, which then cost nothing
    assert_eq!(paid_n(2.0), paid_n(0.0));
}

#[test]
fn an_empty_account_pays_for_nothing() {
    let free = AccountSettings { acceleration_m_per_s2: 0.0, handle_share: 0.0, ..AccountSettings::DEFAULT };
    let mut port = Port::with(stylus(), free);
    assert_eq!(port.pays([0.0, 0.0, 2.0], 1e-3), Vector3::zeros(), "not even for what costs nothing");
    port.step(0.0, 0.0);
    assert_eq!(port.pays([0.0, 0.0, 2.0], 1e-3).z, 2.0);
}

#[test]
fn below_zero_there_is_no_force_and_far_below_it_a_fault() {
    let mut port = Port::new(0, 0.0, 0.0);
    port.step(0.0, 2.0);
    port.step(0.1e-3, 0.0);
    assert!(port.account.energy().balance_j < 0.0);
    (0..10).for_each(|_| _ = port.step(-0.2e-3, 0.0));
    assert_eq!(port.pays([0.0, 0.0, 2.0], 1e-3), Vector3::zeros(), "not even where it would cost nothing");
    let bound = EnergyAccount::bound(&AccountSettings::DEFAULT, &stylus(), 1e-3, 0);
    // ever faster along 3 N
    let moved = |way_m: f32| {
        let mut port = Port::with(stylus(), AccountSettings::DEFAULT);
        port.step(0.0, 3.0);
        (0..4).for_each(|tenths| _ = port.step(0.1 * way_m * tenths as f32, 3.0));
        port.moves([0.0, 0.0, 0.4 * way_m])
    };
    let inside_m = 0.99 * bound.at_once_j / 3.0;
    assert!(moved(inside_m).is_ok(), "{bound:?}");
    assert_eq!(moved(1.02 * inside_m), Err(Fault::EnergyCreated));
}

#[test]
fn a_fault_charges_the_force_that_acted_and_ends_those_on_their_way() {
    // a probe that moves along 1 N by 20 um a tick, and a fault before the next reading
    let owes_j = |device: DeviceSpec, reads: bool| {
        let mut port = Port::with(device, AccountSettings { refill_w: 0.0, ..AccountSettings::DEFAULT });
        (0..10).for_each(|_| _ = port.step(0.02e-3, 1.0));
        let before_j = port.account.energy().balance_j;
        assert!(before_j < 0.0);
        port.held = !reads;
        port.moves([0.0, 0.0, 0.02e-3]).unwrap();
        Monitor::reset(&mut port.account);
        let after_j = port.account.energy().balance_j;
        port.at_m = Vector3::repeat(7e-3);
        assert_eq!(port.step(0.3e-3, 0.0).given_j, 0.0, "neither the jump nor a force that was cut off does work");
        before_j - after_j
    };
    for delay_ticks in [0, 2] {
        let device = DeviceSpec { delay_ticks, lag_s: 0.0, count_m: 0.0, ..stylus() };
        // it may have moved on by its last displacement and by the sharpest acceleration
        let way_m = 0.02e-3 + (200.0 + 3.3 / 0.045) * 1e-6;
        for (reads, way_m) in [(false, way_m), (true, 0.02e-3)] {
            let owed_j = owes_j(device, reads);
            assert!((owed_j / way_m - 1.0).abs() < 1e-2, "reads {reads}: {owed_j} J for {way_m} m");
        }
    }
    let mut rich = Port::new(2, 0.0, 0.0);
    (0..10).for_each(|_| _ = rich.step(-0.2e-3, 1.0));
    Monitor::reset(&mut rich.account);
    assert!(rich.account.energy().balance_j <= 20e-6, "what the hand gave does not outlive the contact");
}

#[test]
fn the_bound_grows_with_force_delay_lag_count_and_a_lighter_handle() {
    let bound = |device: DeviceSpec| EnergyAccount::bound(&AccountSettings::DEFAULT, &device, 1e-3, 0);
    let plain = DeviceSpec { count_m: 10e-6, ..stylus() };
    let base = bound(plain);
    for larger in [
        DeviceSpec { max_force_n: 6.0, ..plain },
        DeviceSpec { delay_ticks: 2, ..plain },
        DeviceSpec { lag_s: 2e-3, ..plain },
        DeviceSpec { count_m: 55e-6, ..plain },
        DeviceSpec { mass_kg: 0.02, ..plain },
    ] {
        assert!(bound(larger).within_j(10.0) > 1.01 * base.within_j(10.0), "{larger:?}");
    }
    assert!((base.within_j(10.0) - base.at_once_j - 10.0 * base.lasting_w).abs() < 1e-9);
    assert!((base.lasting_w / (30e-6 + 75.0 * 10e-6) - 1.0).abs() < 1e-4, "{base:?}");
    // 3.3 N over two ticks of flight and seven of window, at 200 m/s^2 and 73 m/s^2 of its own
    let way_m = (200.0 + 3.3 / 0.045) * 1e-6 * 2.0 * 0.5 * 9.0;
    assert!((base.at_once_j / (20e-6 + 3.3 * (way_m + 10e-6)) - 1.0).abs() < 1e-4, "{base:?}");
    // a period that is missed is a tick of delay
    let missed = EnergyAccount::bound(&AccountSettings::DEFAULT, &plain, 1e-3, 4);
    assert_eq!(missed, bound(DeviceSpec { delay_ticks: 5, ..plain }));
}

/// The largest force on every place of the line fades behind the lag, while the probe moves further
/// than was reserved for, by `tick + (window - 1) / 2` times the excess in each tick.
#[test]
fn the_bound_counts_the_tail_of_a_lag() {
    let device = DeviceSpec { delay_ticks: 4, lag_s: 6e-3, count_m: 0.0, ..stylus() };
    let bound = EnergyAccount::bound(&AccountSettings::DEFAULT, &device, 1e-3, 0);
    let left = (-1.0_f32 / 6.0).exp();
    let (mut acts, mut way) = (1.0_f32, 0.0_f32);
    for tick in 1..500_u16 {
        let delayed = if tick <= 5 { 1.0 } else { 0.0 };
        way += (delayed + (acts - delayed) * 6.0 * (1.0 - left)) * (f32::from(tick) + 3.0);
        acts = delayed + (acts - delayed) * left;
    }
    let given_j = 3.3 * (200.0 + 3.3 / 0.045) * 1e-6 * way;
    assert!(bound.at_once_j > given_j && bound.at_once_j < 1.05 * given_j, "{bound:?}: {given_j} J");
}

#[test]
fn forces_that_a_fault_cut_off_do_no_work_and_the_next_contact_is_as_strong() {
    for (delay_ticks, lag_s) in [(0, 0.0), (1, 0.0), (1, 1e-3), (2, 0.0), (4, 0.0), (7, 6e-3)] {
        let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks, lag_s, ..stylus() }, |_| ()).active();
        let felt_n = bench.press_n(1.0).applied_n.z;
        bench.move_to(10e-3, 0.05);
        bench.ticks(100);
        bench.press_n(2.0);
        let z_m = |bench: &Bench| bench.device.sensed.position_m.z;
        bench.device.sensed.position_m.z += 0.5e-3;
        bench.find(Fault::SupplyLow);
        let energy = (0..40).map(|_| bench.at(z_m(&bench) + 0.5e-3).energy).fold(0.0_f32, |most_j, e| most_j.max(e.given_j));
        assert_eq!(energy, 0.0, "{delay_ticks} ticks, {lag_s} s: the device was released");
        bench.ticks(100);
        bench.ask(Ask::Clear);
        bench.ask(Ask::TestPassed);
        bench.arm();
        bench.ticks(600);
        bench.move_to(10e-3, 0.05);
        let again_n = bench.press_n(1.0).applied_n.z;
        assert!((again_n / felt_n - 1.0).abs() < 0.05, "{delay_ticks} ticks, {lag_s} s: {again_n} N after {felt_n} N");
    }
}

#[test]
fn tissue_that_pushes_without_having_been_pressed_gives_no_more_than_the_allowance() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    let mut work_j = 0.0;
    let mut last_n = 0.0;
    for _ in 0..300 {
        let z_m = bench.device.sensed.position_m.z + 0.02e-3;
        let acted_n = last_n;
        last_n = bench.at(z_m).applied_n.z;
        work_j += acted_n * 0.02e-3;
    }
    // 20 uJ, and 30 uW for 0.3 s; forces act a tick later than this sum takes them
    assert!((10e-6..31e-6).contains(&work_j), "{work_j} J");
    assert!(set(&bench.tick(), ClampFlags::ENERGY), "and the record says so");
}
