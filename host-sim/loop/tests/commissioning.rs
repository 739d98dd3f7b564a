//! The commissioning finds every mistake of a device's wiring and unit, and its friction, mass,
//! delay and lag; a handle that is held or moves ends it.

use palpate::haptic::commission::{Commissioned, Trouble};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::closed_loop::mistakes::{HandsOff, MISTAKES, Mistake, commissioned};

fn touch() -> DeviceProfile {
    DeviceProfile::load("touch").unwrap()
}

fn run(device: &DeviceProfile, mistake: &Mistake) -> Commissioned {
    commissioned(device, mistake, HandsOff::Free, 0.0).unwrap_or_else(|trouble| panic!("{device:?} {mistake:?}: {trouble}"))
}

#[test]
fn scan() {
    for friction_n in [0.0, 0.05, 0.1, 0.2, 0.3] {
        for (delay_ticks, lag_s) in [(0, 0.0), (1, 0.0), (1, 1e-3), (2, 3e-3), (4, 0.5e-3), (7, 6e-3), (0, 6e-3), (3, 2e-3)] {
            for count_m in [0.0, 10e-6, 55e-6, 100e-6] {
                let device = DeviceProfile { friction_n, delay_ticks, amplifier_lag_s: lag_s, count_m, ..touch() };
                match commissioned(&device, &MISTAKES[0], HandsOff::Free, 0.0) {
                    Ok(c) => println!(
                        "F {friction_n} d {delay_ticks} l {:.1} q {:.0} -> F {:.3?} d {} l {:.1} sum err {:+.1} kg {:.4?} q {:.1?}",
                        lag_s * 1e3,
                        count_m * 1e6,
                        c.friction_n,
                        c.delay_ticks,
                        c.lag_s * 1e3,
                        f32::from(c.delay_ticks) + c.lag_s * 1e3 - f32::from(delay_ticks) - lag_s as f32 * 1e3,
                        c.mass_kg,
                        c.count_m.map(|m| m * 1e6)
                    ),
                    Err(e) => println!("F {friction_n} d {delay_ticks} l {lag_s} q {count_m}: {e}"),
                }
            }
        }
    }
}

#[test]
fn every_mistake_is_found() {
    for mistake in &MISTAKES {
        let found = run(&touch(), mistake).wiring;
        println!("{found:?}");
        assert_eq!(found.sensor, mistake.wiring().sensor, "{}", mistake.name);
    }
}

#[test]
fn a_handle_that_is_held_or_moves_ends_it() {
    for hand in HANDS {
        println!("{} {:?}", hand.id, commissioned(&touch(), &MISTAKES[0], HandsOff::Held(hand), 0.0).map(|_| ()));
    }
    for m_per_s in [1e-3, 5e-3, 0.05] {
        let moved = commissioned(&touch(), &MISTAKES[0], HandsOff::Moved(m_per_s), 0.0);
        println!("{moved:?}");
        assert!(matches!(moved, Err(Trouble::Moving)), "{m_per_s}");
    }
}
