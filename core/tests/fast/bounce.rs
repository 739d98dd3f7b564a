//! A light handle that a soft hand rests on a wall, with the delays that a device may declare: the
//! motors may not drive it for ever.

use palpate::Fault;
use palpate::haptic::device::DeviceSpec;

use crate::bench::{Bench, TICK_S, stylus};

/// Steps of the handle per tick.
const STEPS: u16 = 20;
/// Energy that the motors may give within ten seconds [J]: the allowance and its refill are 0.32
/// mJ, and the hand, lighter than the handle, may be thrown more sharply than the account reserves
/// for.
const MOST_J: f32 = 1e-3;

/// Work of the motors on a handle of 16 g [J], and the fault, within ten seconds. The hand is a
/// spring of 100 N/m whose rest position is 0.65 mm below the surface, with 0.5 N s/m.
fn rest(n_per_m: f32, delay_ticks: u8, lag_s: f32) -> (f32, Option<Fault>) {
    let mut bench = Bench::with(n_per_m, DeviceSpec { delay_ticks, lag_s, mass_kg: 0.016, ..stylus() }, |_| ()).active();
    let mut line_n = vec![0.0; usize::from(delay_ticks)];
    let (mut z_m, mut m_per_s, mut acting_n, mut work_j) = (2e-3_f32, -0.1_f32, 0.0_f32, 0.0);
    let step_s = TICK_S / f32::from(STEPS);
    let share = if lag_s > 0.0 { 1.0 - (-step_s / lag_s).exp() } else { 1.0 };
    for _ in 0..10_000 {
        let record = bench.at(z_m);
        if record.fault.is_some() {
            return (work_j, record.fault);
        }
        line_n.push(record.applied_n.z);
        let asked_n = line_n.remove(0);
        for _ in 0..STEPS {
            acting_n += (asked_n - acting_n) * share;
            let force_n = acting_n - (z_m + 0.65e-3) * 100.0 - m_per_s * 0.6;
            m_per_s += force_n / 0.016 * step_s;
            z_m += m_per_s * step_s;
            work_j += acting_n * m_per_s * step_s;
        }
    }
    (work_j, None)
}

#[test]
fn bounces_further_apart_than_twenty_ticks_do_not_go_on_for_ever() {
    for (n_per_m, delay_ticks) in [(400.0, 4), (250.0, 5), (400.0, 6), (150.0, 7)] {
        let (work_j, fault) = rest(n_per_m, delay_ticks, 0.0);
        assert!(work_j < MOST_J, "{n_per_m} N/m, {delay_ticks} ticks: {work_j} J, {fault:?}");
    }
}

#[test]
fn a_lag_that_a_device_may_declare_does_not_hide_the_energy_that_it_creates() {
    for lag_s in [1e-3, 3e-3, DeviceSpec::MOST_LAG_S] {
        for (n_per_m, delay_ticks) in [(400.0, 1), (250.0, 1), (400.0, 2), (400.0, 4), (250.0, 5), (150.0, 7)] {
            let (work_j, fault) = rest(n_per_m, delay_ticks, lag_s);
            assert!(work_j < MOST_J, "{n_per_m} N/m, {delay_ticks} ticks, {lag_s} s: {work_j} J, {fault:?}");
        }
    }
}
