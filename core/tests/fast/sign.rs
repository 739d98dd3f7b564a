//! A motor or an encoder with the wrong sign: the force is switched off during the first touch, the
//! third touch ends in a fault, and a device with the right signs is not mistaken for one.

use palpate::haptic::cycle::{Ask, Command, Telemetry};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Vector3};

use crate::bench::{Bench, CLEAR_M, TICK_S, set};

/// Longest contact that is followed [ticks].
const TICKS: usize = 400;

/// Lets a released handle of this mass [kg] enter at this speed [m/s] while the force acts on it
/// with this sign, up to the tick in which the force is switched off.
fn comes_in(bench: &mut Bench, mass_kg: f32, m_per_s: f32, sign: f32) -> Option<Telemetry> {
    let (mut z_m, mut speed) = (bench.move_to(0.2e-3, 0.2).position_m.z, -m_per_s);
    let mut felt = false;
    for _ in 0..TICKS {
        let record = bench.at(z_m);
        let acts = record.applied_n != Vector3::zeros();
        felt |= acts;
        // damping may cancel the whole force on a probe that leaves
        let taken = felt && !acts && record.output.depth_m > 0.0 && record.mode == Mode::Degraded;
        if record.mode == Mode::Fault || taken {
            return Some(record);
        }
        speed += sign * record.applied_n.z / mass_kg * TICK_S;
        z_m += speed * TICK_S;
        if z_m > 0.5e-3 {
            break;
        }
    }
    None
}

/// Withdraws the probe.
fn goes_back(bench: &mut Bench) {
    bench.move_to(CLEAR_M, 0.2);
    bench.ticks(20);
}

#[test]
fn a_force_that_drives_the_probe_on_is_off_in_the_first_touch_and_a_fault_in_the_third() {
    for (mass_kg, m_per_s) in [(0.05, 0.05), (0.05, 0.15), (0.2, 0.05), (0.6, 0.03)] {
        let mut bench = Bench::new(400.0).active();
        let first = comes_in(&mut bench, mass_kg, m_per_s, -1.0).unwrap();
        assert_eq!((first.mode, first.fault), (Mode::Degraded, None), "{mass_kg} kg, {m_per_s} m/s");
        assert!(set(&first, ClampFlags::GAIN) && first.output.force_n.norm() < 3.0, "before the limit: {first:?}");
        goes_back(&mut bench);
        assert_eq!(bench.cycle.mode(), Mode::Active, "the next contact is felt again");
        let second = comes_in(&mut bench, mass_kg, m_per_s, -1.0).unwrap();
        assert_eq!((second.mode, second.fault), (Mode::Degraded, None));
        goes_back(&mut bench);
        let third = comes_in(&mut bench, mass_kg, m_per_s, -1.0).unwrap();
        assert_eq!((third.fault, third.applied_n), (Some(Fault::WrongSign), Vector3::zeros()));
        assert_eq!(bench.device.drive_n, None);
    }
}

#[test]
fn a_device_with_the_right_sign_bounces_and_is_watched_no_longer() {
    for (mass_kg, m_per_s) in [(0.05, 0.05), (0.05, 0.3), (0.2, 0.2), (0.6, 0.1)] {
        let mut bench = Bench::new(400.0).active();
        for _ in 0..4 {
            assert_eq!(comes_in(&mut bench, mass_kg, m_per_s, 1.0), None, "{mass_kg} kg, {m_per_s} m/s");
            goes_back(&mut bench);
        }
    }
    // once proven, a sign that reverses is left to another check
    let mut bench = Bench::new(400.0).active();
    bench.move_to(-5e-3, 0.1);
    goes_back(&mut bench);
    assert!(comes_in(&mut bench, 0.05, 0.05, -1.0).is_none_or(|record| record.fault != Some(Fault::WrongSign)));
}

#[test]
fn the_first_touch_after_another_arming_is_judged_anew() {
    let mut bench = Bench::new(400.0).active();
    bench.move_to(-5e-3, 0.1);
    goes_back(&mut bench);
    bench.ask(Ask::Stop);
    (0..200).for_each(|_| _ = bench.run(Command::HEARD));
    assert_eq!(bench.cycle.mode(), Mode::Idle);
    bench.arm();
    bench.ticks(600);
    let first = comes_in(&mut bench, 0.05, 0.05, -1.0).unwrap();
    assert_eq!((first.mode, first.applied_n), (Mode::Degraded, Vector3::zeros()));
}
