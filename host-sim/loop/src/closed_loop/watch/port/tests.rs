use std::f64::consts::TAU;
use std::sync::Arc;

use palpate::Vector3;
use palpate::haptic::device::DeviceSpec;

use super::{PortWatch, Truth};
use crate::closed_loop::drive::Drive;
use crate::closed_loop::watch::HalfSpace;
use palpate_tissue::scene::TICK_S;

const DEVICE: DeviceSpec = DeviceSpec { count_m: 50e-6, delay_ticks: 0, ..DeviceSpec::STYLUS };

/// A watch over tissue below z = 0, and what it has noticed.
struct Port {
    watch: PortWatch,
    last: Truth,
    broken: Vec<&'static str>,
}

impl Port {
    fn new() -> Self {
        let shape = HalfSpace { at_m: Vector3::zeros(), normal: Vector3::z() };
        let at_m = Vector3::z() * 1e-3;
        Self { watch: PortWatch::over(Arc::new(shape), &DEVICE), last: Truth { at_m, ..Truth::default() }, broken: Vec::new() }
    }

    /// Moves the tip to this depth and place along the surface [m] under this force [N].
    fn tick(&mut self, depth_m: f64, aside_m: f64, force_n: f64) {
        let (at_m, mean_n) = (Vector3::new(aside_m, 0.0, -depth_m), Vector3::z() * force_n);
        self.last = Truth { at_m, mean_n, work_j: mean_n.dot(&(at_m - self.last.at_m)) };
        self.broken.extend(self.watch.check(&self.last).err().map(|b| b.id));
    }

    /// Runs a motion: depth, place and force of each time [s].
    fn run(mut self, seconds: f64, motion: impl Fn(f64) -> (f64, f64, f64)) -> Vec<&'static str> {
        for n in 0..(seconds / TICK_S) as u32 {
            let (depth_m, aside_m, force_n) = motion(f64::from(n) * TICK_S);
            self.tick(depth_m, aside_m, force_n);
        }
        self.broken.dedup();
        self.broken
    }
}

fn spring_n(depth_m: f64) -> f64 {
    400.0 * depth_m.max(0.0)
}

#[test]
fn a_spring_returns_what_it_took_and_no_more() {
    // 5 mJ each way, more than the bound gives at once
    let depth_m = |t: f64| 5e-3 * (1.0 - (TAU * t).cos()) - 1e-3;
    assert_eq!(Port::new().run(4.0, |t| (depth_m(t), 0.0, spring_n(depth_m(t)))), [""; 0]);
    // 30 ms late it gives 6 mJ in every cycle of a second, more than counts of 50 um explain
    let late = Port::new().run(30.0, |t| (depth_m(t), 0.0, spring_n(depth_m(t - 30e-3))));
    assert_eq!(late, ["I11"]);
}

#[test]
fn the_bound_holds_to_within_a_hundredth_and_for_as_long_as_the_window() {
    let bound = Port::new().watch.energy().bound();
    for (share, seconds, noticed) in [(0.99, 0.1, false), (1.01, 0.1, true), (0.99, 20.0, false), (1.01, 20.0, true)] {
        let mut port = Port::new();
        let ticks = (seconds / TICK_S) as u32;
        // a force on a tip in free space, where no tissue can return anything
        let each_m = share * (bound.at_once_j + bound.lasting_w * seconds) / f64::from(ticks);
        for n in 0..ticks {
            port.tick(-1e-3 - each_m * f64::from(n + 1), 0.0, 1.0);
        }
        assert_eq!(port.broken.contains(&"I11"), noticed, "{share} of the bound in {seconds} s");
    }
}

#[test]
fn energy_that_a_press_dissipated_is_no_licence_to_give_it_back() {
    for (swings, noticed) in [(10, false), (60, true)] {
        let mut port = Port::new();
        // in under 2 N and out under none, by half the depth: 5 mJ are lost each time
        for n in 0..5000_i32 {
            let phase = n.rem_euclid(1000);
            let depth_m = 1e-5 * f64::from(if n < 500 { n } else { 250 + (phase - 500).abs() / 2 });
            let goes_in = depth_m > -port.last.at_m.z;
            port.tick(depth_m, 0.0, if goes_in { 2.0 } else { 0.0 });
        }
        // each swing gives 0.3 mJ, at a depth at which the tissue could return 10 mJ once
        let depth_m = |n: u32| 5e-3 + if n.is_multiple_of(2) { 0.0 } else { 0.2e-3 };
        (0..2 * swings).for_each(|n| port.tick(depth_m(n), 0.0, if n.is_multiple_of(2) { 2.0 } else { 0.5 }));
        assert_eq!(port.broken.contains(&"I11"), noticed, "{swings} swings");
    }
}

#[test]
fn a_force_that_shakes_is_noticed_whether_the_hand_rests_or_moves() {
    for (amplitude_n, noticed) in [(0.06, false), (0.08, true)] {
        for swing_m in [0.0, 1e-3] {
            let motion = |t: f64| {
                let depth_m = 4e-3 + swing_m * (TAU * t).sin();
                (depth_m, 0.0, spring_n(depth_m) + amplitude_n * (TAU * 55.0 * t).sin())
            };
            assert_eq!(Port::new().run(3.0, motion).contains(&"I15"), noticed, "{amplitude_n} N, swing {swing_m} m");
        }
    }
}

/// A spring that answers late gives a vibrating hand energy, as a limit cycle does; one that is
/// damped takes energy from it, so that the hand is the source.
#[test]
fn a_vibration_counts_if_the_force_feeds_it() {
    for (late_s, noticed) in [(3e-3, true), (1e-3, true), (-1e-3, false), (-3e-3, false)] {
        let depth_m = |t: f64| 4e-3 + 0.2e-3 * (TAU * 30.0 * t).sin();
        let found = Port::new().run(3.0, |t| (depth_m(t), 0.0, 1.6 + 1000.0 * (depth_m(t - late_s) - 4e-3)));
        assert_eq!(found.contains(&"I15"), noticed, "{late_s} s late: {found:?}");
    }
}

/// An amplifier's lag changes the force within a tick. Paired with the force at the tick's end, the
/// way seemed to give the device what the hand was given.
#[test]
fn under_a_lag_a_vibration_counts_if_the_force_feeds_it() {
    for (early_s, noticed) in [(0.6e-3, true), (0.8e-3, false)] {
        let depth_m = |t: f64| 4e-3 + 0.5e-3 * (TAU * 60.0 * t).sin();
        let (mut port, mut drive) = (Port::new(), Drive::new(0, 0.2e-3));
        for n in 0..3000_i32 {
            let t = f64::from(n) * TICK_S;
            drive.send(Vector3::z() * spring_n(depth_m(t + early_s)));
            let [from_m, to_m] = [t, t + TICK_S].map(|t| -Vector3::z() * depth_m(t));
            port.broken.extend(port.watch.check(&drive.carry(&from_m, &to_m)).err().map(|b| b.id));
        }
        assert_eq!(port.broken.contains(&"I15"), noticed, "{early_s} s early: {:?}", port.broken.first());
    }
}

#[test]
fn taps_slides_and_a_tissue_that_rings_are_no_shaking() {
    let tap_m = |t: f64| 3e-3 * (TAU * 4.0 * t).sin();
    assert_eq!(Port::new().run(6.0, |t| (tap_m(t), 0.0, spring_n(tap_m(t)))), [""; 0]);
    // elements of 2 mm change the force by 15 % at 0.1 m/s
    let slide_m = |t: f64| 0.1 * t;
    let ripple = |x: f64| 1.0 + 0.15 * (TAU * x / 2e-3).sin();
    assert_eq!(Port::new().run(6.0, |t| (3e-3, slide_m(t), 1.2 * ripple(slide_m(t)))), [""; 0]);
    let ring_n = |t: f64| (-t / 0.1).exp() * (TAU * 40.0 * t).sin();
    assert_eq!(Port::new().run(6.0, |t| (3e-3, 0.0, 1.2 + ring_n(t))), [""; 0]);
}
