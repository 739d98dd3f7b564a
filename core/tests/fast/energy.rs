//! The energy given to the hand, and the reaction to too much of it.

use palpate::haptic::cycle::Ask;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::passivity::{Energy, PassivityObserver, PassivitySettings};
use palpate::{Fault, Vector3};

use crate::bench::{Bench, stylus};

fn observer(delay_ticks: u8, count_m: f32) -> PassivityObserver {
    PassivityObserver::build(&PassivitySettings::DEFAULT, &DeviceSpec { delay_ticks, count_m, ..stylus() }, 1e-3).unwrap()
}

fn lagging(delay_ticks: u8, lag_s: f32) -> PassivityObserver {
    PassivityObserver::build(&PassivitySettings::DEFAULT, &DeviceSpec { delay_ticks, lag_s, ..stylus() }, 1e-3).unwrap()
}

fn z(length: f32) -> Vector3<f32> {
    Vector3::new(0.0, 0.0, length)
}

/// Runs one tick: the probe moves, then a force is sent [m, N].
fn step(observer: &mut PassivityObserver, moved_m: f32, touched: bool, force_n: f32) -> Result<(), Fault> {
    let answer = observer.observe(&z(moved_m), touched);
    observer.sent(z(force_n));
    answer
}

/// Runs a contact in which 1 N pushes the probe this far out [m], or in if negative, and then 30
/// ticks in free space.
fn contact(observer: &mut PassivityObserver, moved_m: f32) -> Result<(), Fault> {
    step(observer, 0.0, true, 1.0)?;
    let answer = step(observer, moved_m, true, 0.0);
    for _ in 0..30 {
        step(observer, 0.0, false, 0.0)?;
    }
    answer
}

#[test]
fn energy_is_force_times_motion_with_the_force_that_acts() {
    for delay in 0..=7_u8 {
        let mut observer = observer(delay, 0.0);
        for n in 0..=delay {
            assert_eq!(observer.observe(&z(0.1e-3), true), Ok(()));
            observer.sent(Vector3::new(0.5, 0.0, 2.0));
            assert_eq!(observer.energy().given_j, 0.0, "tick {n}: nothing sent has arrived");
        }
        observer.observe(&Vector3::new(0.2e-3, 9.0, -0.1e-3), true).unwrap();
        assert!((observer.energy().given_j - (0.1e-3 - 0.2e-3)).abs() < 1e-9, "delay {delay}: {:?}", observer.energy());
        assert_eq!(observer.energy().created_j, 0.0, "what the tissue holds is not created");
    }
}

#[test]
fn the_ring_of_forces_outlasts_its_index() {
    let mut observer = observer(7, 0.0);
    for n in 0..700_u16 {
        step(&mut observer, 0.0, true, f32::from(n)).unwrap();
    }
    observer.observe(&z(-1e-3), true).unwrap();
    assert!((observer.energy().given_j + 0.692).abs() < 1e-5, "the force sent eight ticks ago: {:?}", observer.energy());
}

#[test]
fn created_is_the_most_that_was_given_beyond_what_was_taken() {
    let mut observer = observer(0, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    for (moved_m, given_j, created_j) in [(-0.3e-3, -0.3e-3, 0.0), (0.7e-3, 0.4e-3, 0.4e-3), (-0.2e-3, 0.2e-3, 0.4e-3)] {
        step(&mut observer, moved_m, true, 1.0).unwrap();
        let energy = observer.energy();
        assert!((energy.given_j - given_j).abs() < 1e-8 && (energy.created_j - created_j).abs() < 1e-8, "{energy:?}");
    }
    assert_eq!(observer.gain(), 1.0, "below the alarm");
    // free space: the contact is over 20 ticks after its last force has acted
    (0..22).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
    let energy = observer.energy();
    assert!((energy.total_created_j - 0.4e-3).abs() < 1e-8, "{energy:?}");
    assert_eq!((energy.given_j, energy.created_j), (0.0, 0.0));
}

#[test]
fn a_contact_lasts_until_its_last_force_has_acted() {
    let mut observer = observer(3, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    // the probe has left while the force is still on its way: its energy belongs to this contact
    for n in 0..3 {
        step(&mut observer, 0.0, false, 0.0).unwrap();
        assert_eq!(observer.energy(), Energy::default(), "tick {n}");
    }
    step(&mut observer, 0.3e-3, false, 0.0).unwrap();
    assert!((observer.energy().total_created_j + observer.energy().created_j - 0.3e-3).abs() < 1e-8, "{:?}", observer.energy());
    // a force is sent and cancelled: three ticks later it has acted, and the next 20 ticks belong
    // to the same contact
    let mut observer = self::observer(3, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    (0..3).for_each(|_| step(&mut observer, 0.0, true, 1.0).unwrap());
    step(&mut observer, 0.2e-3, true, 0.0).unwrap();
    for n in 0..23 {
        step(&mut observer, 0.0, false, 0.0).unwrap();
        assert!((observer.energy().created_j - 0.2e-3).abs() < 1e-8, "tick {n}");
    }
    step(&mut observer, 0.0, false, 0.0).unwrap();
    assert_eq!(observer.energy().created_j, 0.0);
}

#[test]
fn bounces_that_follow_each_other_soon_are_one_contact_and_raise_the_alarm() {
    // 10 uJ are created in each touch; the probe is off the tissue for `idle_ticks` after it
    let gain_after = |bounces: u16, idle_ticks: u16| {
        let mut observer = observer(1, 0.0);
        for _ in 0..bounces {
            step(&mut observer, 0.0, true, 0.25).unwrap();
            step(&mut observer, 0.0, true, 0.0).unwrap();
            step(&mut observer, 40e-6, false, 0.0).unwrap();
            (1..idle_ticks).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
        }
        observer.gain()
    };
    for idle_ticks in [3, 10, 20] {
        assert_eq!(gain_after(49, idle_ticks), 1.0, "0.49 mJ, {idle_ticks} ticks apart");
        assert!(gain_after(52, idle_ticks) < 0.8, "0.52 mJ, {idle_ticks} ticks apart");
    }
    assert_eq!(gain_after(500, 40), 1.0, "touches of a hand that trembles are contacts of their own");
}

#[test]
fn one_count_of_play_is_no_motion_and_three_counts_are() {
    let count_m = 50e-6;
    // each round trip of two counts beyond the backlash gives the difference of the forces times
    // two counts
    let round_trips = |counts: f32| {
        let mut observer = observer(0, count_m);
        step(&mut observer, 0.0, true, 0.5).unwrap();
        for _ in 0..5 {
            step(&mut observer, counts * count_m, true, 0.5).unwrap();
            observer.sent(z(0.5));
            step(&mut observer, -counts * count_m, true, 1.0).unwrap();
        }
        observer.energy().created_j
    };
    assert!(round_trips(1.0) < 0.02 * count_m, "{}", round_trips(1.0));
    let beyond = round_trips(3.0) / count_m;
    assert!(beyond > 1.9, "{beyond} N counts");
}

#[test]
fn the_alarm_fades_the_force_to_nothing_in_twenty_ticks() {
    let mut observer = observer(0, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    step(&mut observer, 0.5e-3, true, 1.0).unwrap();
    assert_eq!(observer.gain(), 1.0, "at the alarm, not beyond it");
    step(&mut observer, 0.1e-3, true, 1.0).unwrap();
    assert!((observer.gain() - 0.8).abs() < 1e-6);
    let ticks = (1..100).find(|_| {
        step(&mut observer, 0.0, true, 1.0).unwrap();
        observer.gain() == 0.0
    });
    assert_eq!(ticks, Some(20), "a hundredth is left after 20 ticks, then nothing");
}

#[test]
fn contacts_after_an_alarm_are_half_as_strong_until_a_good_one() {
    let mut observer = observer(0, 0.0);
    for gain in [0.5, 0.25, 0.125, 0.0625] {
        assert_eq!(contact(&mut observer, 1e-3), Ok(()));
        assert_eq!(observer.gain(), gain);
    }
    for gain in [0.125, 0.25, 0.5, 1.0, 1.0] {
        assert_eq!(contact(&mut observer, -1e-3), Ok(()));
        assert_eq!(observer.gain(), gain);
    }
}

#[test]
fn five_alarms_in_a_row_are_a_fault_and_a_good_contact_and_a_pause_break_the_row() {
    let mut observer = observer(0, 0.0);
    (0..4).for_each(|_| contact(&mut observer, 1e-3).unwrap());
    contact(&mut observer, -1e-3).unwrap();
    let mut soon = observer;
    assert!((0..2).any(|_| contact(&mut soon, 1e-3).is_err()), "a good contact alone does not");
    (0..20_000).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
    (0..4).for_each(|_| contact(&mut observer, 1e-3).unwrap());
    assert_eq!(contact(&mut observer, 1e-3), Err(Fault::EnergyCreated));
}

#[test]
fn one_long_contact_raises_one_alarm() {
    let mut observer = observer(0, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    assert!((0..50).all(|_| step(&mut observer, 1e-3, true, 1.0).is_ok()));
}

#[test]
fn clearing_forgets_the_alarms_and_keeps_the_total() {
    let mut observer = observer(0, 0.0);
    (0..4).for_each(|_| contact(&mut observer, 1e-3).unwrap());
    let total_j = observer.energy().total_created_j;
    assert!((total_j - 4e-3).abs() < 1e-6, "{total_j}");
    step(&mut observer, 0.0, true, 1.0).unwrap();
    step(&mut observer, 0.2e-3, true, 0.0).unwrap();
    observer.clear();
    let energy = observer.energy();
    assert_eq!((observer.gain(), energy.given_j, energy.created_j), (1.0, 0.0, 0.0));
    assert!((energy.total_created_j - 4.2e-3).abs() < 1e-6, "{energy:?}");
    (0..4).for_each(|_| assert_eq!(contact(&mut observer, 1e-3), Ok(())));
}

#[test]
fn forces_that_a_fault_cut_off_do_no_work_and_the_next_contact_has_its_full_force() {
    for (delay_ticks, lag_s) in [(0, 0.0), (1, 0.0), (1, 1e-3), (2, 0.0), (4, 0.0), (7, 6e-3)] {
        let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks, lag_s, ..stylus() }, |_| ()).active();
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
        let felt_n = bench.press_n(1.0).applied_n.z;
        assert!((felt_n - 1.0).abs() < 0.01, "{delay_ticks} ticks, {lag_s} s: {felt_n} N");
    }
}

#[test]
fn a_lagging_force_acts_as_a_first_order_low_pass_says() {
    // means over three ticks, for a force that is sent once
    for (lag_s, tolerance) in [(0.25e-3_f32, 0.02), (1e-3, 1e-3), (6e-3, 1e-3)] {
        let mut observer = lagging(0, lag_s);
        observer.sent(z(1.0));
        let x = 1e-3 / lag_s;
        let falls = 1.0 - (-x).exp();
        for (tick, mean_n) in [1.0 - falls / x, falls * falls / x, (1.0 - falls) * falls * falls / x].into_iter().enumerate() {
            let before_j = observer.energy().given_j;
            step(&mut observer, -1e-3, true, 0.0).unwrap();
            let found_n = (observer.energy().given_j - before_j) / -1e-3;
            assert!((found_n / mean_n - 1.0).abs() < tolerance, "{lag_s} s, tick {tick}: {found_n} N, closed form {mean_n} N");
        }
    }
}

#[test]
fn a_contact_ends_twenty_milliseconds_and_three_lags_after_its_last_force() {
    for (delay_ticks, lag_s, ticks) in [(0, 0.0, 20), (3, 0.0, 23), (0, 1e-3, 23), (1, 6e-3, 39)] {
        let mut observer = lagging(delay_ticks, lag_s);
        (0..10).for_each(|_| step(&mut observer, -1e-5, true, 1.0).unwrap());
        let lasts = (0..100).position(|_| {
            step(&mut observer, 0.0, false, 0.0).unwrap();
            observer.energy().given_j == 0.0
        });
        assert_eq!(lasts, Some(ticks + 1), "{delay_ticks} ticks, {lag_s} s");
    }
}

#[test]
fn contacts_below_the_alarm_are_a_fault_by_their_energy_in_five_seconds() {
    // 0.4 mJ each: more than half a millijoule per second, then less
    for (every_ticks, fault) in [(600, Some(10)), (1200, None)] {
        let mut observer = observer(0, 0.0);
        let ends = (0..40).position(|_| {
            let answer = contact(&mut observer, 0.4e-3);
            (32..every_ticks).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
            answer.is_err()
        });
        assert_eq!((ends, observer.gain()), (fault, 1.0), "every {every_ticks} ticks");
    }
}

#[test]
fn five_alarms_in_a_row_are_a_fault_however_far_apart() {
    let mut observer = observer(0, 0.0);
    let fault = (0..10).position(|_| {
        (0..20_000).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
        contact(&mut observer, 1e-3).is_err()
    });
    assert_eq!(fault, Some(4));
}

#[test]
fn a_faded_force_does_not_return_while_the_probe_presses() {
    let mut observer = observer(0, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    step(&mut observer, 1e-3, true, 0.0).unwrap();
    (0..200).for_each(|_| step(&mut observer, 0.0, true, 0.0).unwrap());
    assert_eq!(observer.gain(), 0.0);
    (0..30).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
    assert_eq!(observer.gain(), 0.5);
}

#[test]
fn clearing_ends_what_an_amplifier_gave_after_the_contact_too() {
    let mut observer = lagging(0, 6e-3);
    step(&mut observer, 0.0, true, 20.0).unwrap();
    (0..60).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
    step(&mut observer, 0.1, false, 0.0).unwrap();
    assert!(observer.energy().created_j > 0.0, "{:?}", observer.energy());
    observer.clear();
    assert_eq!((observer.energy().given_j, observer.energy().created_j), (0.0, 0.0));
}

/// Ratio of the work of the bounded form of a force [N] to that of the force itself, at a velocity
/// [m/s] (1). The normal is z.
fn share(observer: &PassivityObserver, force_n: Vector3<f32>, velocity_m_per_s: Vector3<f32>) -> f32 {
    let bound_n = observer.bound(&force_n, &velocity_m_per_s, &Vector3::z());
    if bound_n == force_n { 1.0 } else { bound_n.dot(&velocity_m_per_s) / force_n.dot(&velocity_m_per_s) }
}

#[test]
fn a_force_is_shortened_to_the_work_that_the_contact_took() {
    let build = |allowance_j: f32, delay_ticks: u8, lag_s: f32| {
        let settings = PassivitySettings { allowance_j, ..PassivitySettings::DEFAULT };
        PassivityObserver::build(&settings, &DeviceSpec { delay_ticks, lag_s, count_m: 0.0, ..stylus() }, 1e-3).unwrap()
    };
    let near = |share: f32, right: f32| assert!((share - right).abs() < 1e-5, "{share}, not {right}");
    // a contact that took nothing gives nothing to a probe that leaves, and the whole force to a
    // probe that rests, comes or slides
    let fresh = build(0.0, 0, 0.0);
    near(share(&fresh, z(1.0), z(0.1)), 0.0);
    for velocity_m_per_s in [z(0.0), z(-0.1), Vector3::new(0.3, -0.2, 0.0)] {
        near(share(&fresh, z(1.0), velocity_m_per_s), 1.0);
    }
    // 0.1 mJ were taken, and 2 N for a tick at 0.2 m/s would give 0.4 mJ; delay and lag lengthen
    // that time
    for (delay_ticks, lag_s, right) in [(0, 0.0, 0.25), (1, 0.0, 0.125), (0, 3e-3, 0.0625), (3, 4e-3, 0.03125)] {
        let mut observer = build(0.0, delay_ticks, lag_s);
        // until the amplifier has reached the force
        for _ in 0..100 {
            step(&mut observer, 0.0, true, 1.0).unwrap();
        }
        step(&mut observer, -0.1e-3, true, 0.0).unwrap();
        near(share(&observer, z(2.0), z(0.2)), right);
        near(share(&observer, Vector3::new(5.0, 0.0, 2.0), z(0.2)), right);
        // a quarter of that speed, or of that force, gives no more than was taken
        near(share(&observer, z(2.0 * right), z(0.199)), 1.0);
        near(share(&observer, z(1.99), z(0.2 * right)), 1.0);
    }
    near(share(&build(0.1e-3, 0, 0.0), z(2.0), z(0.2)), 0.25);
}

#[test]
fn the_push_gives_way_before_the_force_along_the_surface_and_nothing_pulls() {
    // nothing was taken: [force N, velocity m/s, remaining force N]
    let v = Vector3::new;
    for (force_n, velocity_m_per_s, right_n) in [
        // friction takes the energy that a smaller push gives
        (v(-0.4, 0.0, 1.0), v(0.1, 0.0, 0.1), v(-0.4, 0.0, 0.4)),
        (v(-0.4, 0.0, 1.0), v(0.2, 0.0, 0.1), v(-0.4, 0.0, 0.8)),
        (v(-0.4, 0.0, 1.0), v(0.3, 0.0, 0.1), v(-0.4, 0.0, 1.0)),
        (v(-0.4, 0.3, 1.0), v(0.0, 0.0, 0.1), v(-0.4, 0.3, 0.0)),
        // friction that gives, beside a push that gives or takes
        (v(0.4, 0.0, 1.0), v(0.1, 0.0, 0.1), v(0.0, 0.0, 0.0)),
        (v(0.4, 0.3, 0.1), v(0.1, 0.0, -0.1), v(0.1, 0.075, 0.1)),
        (v(0.4, 0.3, 1.0), v(0.1, 0.0, 0.0), v(0.0, 0.0, 1.0)),
        // a force into the tissue is reduced as a whole
        (v(0.4, 0.0, -0.1), v(0.1, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        (v(0.0, 0.0, -0.1), v(0.0, 0.0, -0.1), v(0.0, 0.0, 0.0)),
        // a probe that leaves at almost zero speed
        (v(0.0, 0.0, 1.0), v(0.1, 0.0, 1e-12), v(0.0, 0.0, 0.0)),
        (v(-1e-9, 0.0, 1.0), v(0.1, 0.0, 1e-10), v(-1e-9, 0.0, 1.0)),
    ] {
        let bound_n = observer(0, 0.0).bound(&force_n, &velocity_m_per_s, &Vector3::z());
        assert!((bound_n - right_n).norm() < 1e-5, "{force_n} at {velocity_m_per_s}: {bound_n}, not {right_n}");
    }
}

#[test]
fn a_bounded_force_is_finite_and_does_the_work_that_is_left() {
    let settings = PassivitySettings { allowance_j: 1e-5, ..PassivitySettings::DEFAULT };
    let device = DeviceSpec { delay_ticks: 0, lag_s: 0.0, count_m: 0.0, ..stylus() };
    let allowed = PassivityObserver::build(&settings, &device, 1e-3).unwrap();
    for n in 1..4000_u16 {
        let v = f32::from(n) * 1.37e-4;
        for force_n in [z(1.0), Vector3::new(0.3, 0.0, 1.0), Vector3::new(-0.3, 0.1, 1.0)] {
            for velocity_m_per_s in [z(v), Vector3::new(0.7 * v, 0.0, v), Vector3::new(v, 0.0, -0.1 * v)] {
                let bound_n = allowed.bound(&force_n, &velocity_m_per_s, &Vector3::z());
                let work_j = bound_n.dot(&velocity_m_per_s) * 1e-3;
                assert!(work_j <= 1e-5 * 1.00001 + 1e-10, "{force_n} at {velocity_m_per_s}: {bound_n}");
            }
        }
    }
}

#[test]
fn a_force_into_the_tissue_is_shortened_as_a_whole_and_one_that_takes_is_not() {
    let settings = PassivitySettings { allowance_j: 1e-5, ..PassivitySettings::DEFAULT };
    let device = DeviceSpec { delay_ticks: 0, lag_s: 0.0, count_m: 0.0, ..stylus() };
    let allowed = PassivityObserver::build(&settings, &device, 1e-3).unwrap();
    let force_n = Vector3::new(0.4, 0.0, -0.1);
    let bound_n = allowed.bound(&force_n, &Vector3::new(0.1, 0.0, 0.0), &Vector3::z());
    assert!((bound_n - force_n * 0.25).norm() < 1e-6, "10 of 40 uJ: {bound_n}");
    // a probe that comes back into an overdrawn contact feels friction as well
    let mut overdrawn = observer(0, 0.0);
    contact_of(&mut overdrawn, 0.1e-3);
    let force_n = Vector3::new(0.4, 0.0, 1.0);
    assert_eq!(overdrawn.bound(&force_n, &z(-1e-3), &Vector3::z()), force_n);
}

#[test]
fn a_contact_that_raised_the_alarm_leaves_nothing_to_the_next() {
    let mut observer = observer(0, 0.0);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    step(&mut observer, 1e-3, true, 1.0).unwrap();
    step(&mut observer, -3e-3, true, 0.0).unwrap();
    assert!(observer.energy().given_j < -1.9e-3);
    (0..21).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
    assert_eq!((observer.energy().given_j, observer.gain()), (0.0, 0.5));
}

#[test]
fn tissue_that_follows_a_probe_soon_gives_what_it_took() {
    // the tissue took 0.1 mJ; then nothing was sent for some ticks, with the probe outside
    let left = |idle_ticks: u8, moved_m: f32| {
        let mut observer = observer(1, 0.0);
        contact_of(&mut observer, moved_m);
        (0..idle_ticks).for_each(|_| step(&mut observer, 0.0, false, 0.0).unwrap());
        let share = share(&observer, z(1.0), z(0.1));
        (observer.energy(), share)
    };
    for idle_ticks in [3, 10, 22] {
        let (energy, share) = left(idle_ticks, -0.1e-3);
        assert!((energy.given_j / -0.1e-3 - 1.0).abs() < 1e-5 && energy.created_j == 0.0, "{idle_ticks}: {energy:?}");
        assert!((share - 0.5).abs() < 1e-5, "0.2 mJ in the two ticks that it acts: {share}");
    }
    let (energy, share) = left(23, -0.1e-3);
    assert_eq!((energy, share), (Energy::default(), 0.0), "later it has forgotten");
    // the energy that a contact created stays in the total, and the next contact begins at zero
    let (energy, _) = left(22, 0.1e-3);
    assert!((energy.given_j / 0.1e-3 - 1.0).abs() < 1e-5, "the same contact still: {energy:?}");
    let (energy, _) = left(23, 0.1e-3);
    assert!(energy.given_j == 0.0 && energy.created_j == 0.0 && energy.total_created_j > 0.9e-4, "{energy:?}");
}

/// Moves by one count every five ticks; the force is `first_n` in the tick after each count and 1 N
/// in the others. The probe slides at the same time.
fn by_counts(observer: &mut PassivityObserver, counts: u16, count_m: f32, first_n: f32) {
    for n in 0..5 * counts {
        let moved_m = if n % 5 == 0 { count_m } else { 0.0 };
        observer.observe(&Vector3::new(1e-4, 0.0, moved_m), true).unwrap();
        observer.sent(z(if n % 5 == 0 { first_n } else { 1.0 }));
    }
}

#[test]
fn the_work_of_a_count_is_that_of_the_mean_force_since_the_last_one() {
    let mut observer = observer(0, 55e-6);
    step(&mut observer, 0.0, true, 1.0).unwrap();
    // tissue that takes energy in both directions: 3 N after each count in, 0 N after each one out
    by_counts(&mut observer, 20, -55e-6, 3.0);
    let taken_j = -observer.energy().given_j;
    assert!((taken_j / (55e-6 * (19.0 * 1.4 + 0.5)) - 1.0).abs() < 1e-3, "{taken_j}");
    by_counts(&mut observer, 20, 55e-6, 0.0);
    // the first count out is within the backlash
    let given_j = observer.energy().given_j + taken_j;
    assert!((given_j / (55e-6 * (18.99 * 0.8)) - 1.0).abs() < 2e-2, "{given_j}");
}

#[test]
fn the_mean_force_is_of_this_contact_and_forgets_a_force_that_faded() {
    let fresh = || observer(0, 55e-6);
    let mut faded = fresh();
    (0..1000).for_each(|_| step(&mut faded, 0.0, true, 3.0).unwrap());
    (0..400).for_each(|_| step(&mut faded, 0.0, true, 1.0).unwrap());
    step(&mut faded, -55e-6, true, 0.0).unwrap();
    assert!((-faded.energy().given_j / 55e-6 - 1.0).abs() < 0.05, "{:?}", faded.energy());
    let mut touched = fresh();
    (0..50).for_each(|_| step(&mut touched, 0.0, false, 0.0).unwrap());
    step(&mut touched, 0.0, false, 1.0).unwrap();
    step(&mut touched, -55e-6, true, 0.0).unwrap();
    assert!((-touched.energy().given_j / 55e-6 - 1.0).abs() < 1e-5, "{:?}", touched.energy());
}

#[test]
fn the_remainder_of_a_low_passed_count_is_rest() {
    let share = |count_m: f32, m_per_s: f32| {
        let mut observer = observer(1, count_m);
        contact_of(&mut observer, 1e-4);
        share(&observer, z(2.0), z(m_per_s))
    };
    // 2 % of a count in the two ticks until the force has ended
    for (count_m, m_per_s, right) in [(55e-6, 0.54e-3, 1.0), (55e-6, 0.56e-3, 0.0), (0.0, 1e-9, 0.0), (0.0, 0.0, 1.0)] {
        assert!((share(count_m, m_per_s) - right).abs() < 1e-6, "{count_m} {m_per_s}");
    }
    // a probe that comes back into an overdrawn contact takes less than was given in excess
    assert_eq!(share(55e-6, -0.001), 1.0);
}

/// Lets 1 N push the probe this far out [m]; the contact does not end.
fn contact_of(observer: &mut PassivityObserver, moved_m: f32) {
    (0..2).for_each(|_| step(observer, 0.0, true, 1.0).unwrap());
    step(observer, moved_m, true, 1.0).unwrap();
}
