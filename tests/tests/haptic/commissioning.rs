//! The commissioning finds every mistake of a device's wiring and unit, and its friction, mass,
//! delay and lag; a handle that is held or moves ends it, and a session then has the measured
//! profile.

use std::path::Path;

use palpate::Vector3;
use palpate::haptic::commission::{Commissioned, Stage, Trouble};
use palpate::haptic::cycle::Settings;
use palpate::haptic::device::HapticDevice;
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::closed_loop::hand::{Aim, HANDS};
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::run::{Setup, run as run_loop};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::Wall;
use palpate_loop::haptic_session::{HapticSession, Input, OutOfOrder};
use palpate_tests::mistakes::{HandsOff, MISTAKES, Mistake, commissioned};

fn touch() -> DeviceProfile {
    DeviceProfile::load("touch").unwrap()
}

fn run(device: &DeviceProfile, mistake: &Mistake) -> Commissioned {
    commissioned(device, mistake, HandsOff::Free, 0.0).unwrap_or_else(|trouble| panic!("{} {mistake:?}: {trouble}", device.name))
}

#[test]
fn every_mistake_is_found() {
    for mistake in &MISTAKES {
        let (found, right) = (run(&touch(), mistake).wiring, mistake.wiring());
        assert_eq!(
            (found.sensor, found.motor, found.motor_sign),
            (right.sensor, right.motor, right.motor_sign),
            "{}",
            mistake.name
        );
        for (found, right) in found.per_unit.into_iter().zip(right.per_unit) {
            assert!((found / right - 1.0).abs() < 5e-3, "{}: {found} for {right}", mistake.name);
        }
    }
}

#[test]
fn a_distance_that_is_a_little_wrong_keeps_the_data_sheets_unit() {
    for (error, unit) in [(0.05, 1.0), (-0.08, 1.0), (0.15, 1.0 / 1.15)] {
        let found = commissioned(&touch(), &MISTAKES[0], HandsOff::Free, error).unwrap().wiring;
        assert!(found.per_unit.iter().all(|found| (found / unit - 1.0).abs() < 5e-3), "{error}: {found:?}");
    }
}

/// Friction within 5 mN; the sum of delay and lag never below the true one, and up to 0.5 ms above
/// it, 2.5 ms for counts of 55 um and 100 um; the mass within 5 %, 20 % and 30 %. The worst are
/// those of 0.3 N of friction, which brings the handle to rest within a few counts.
#[test]
fn friction_mass_delay_and_lag_are_measured() {
    for friction_n in [0.0, 0.03, 0.1, 0.2, 0.3] {
        for (delay_ticks, lag_s) in [(0, 0.0), (1, 1e-3), (2, 3e-3), (4, 0.5e-3), (7, 6e-3), (0, 6e-3), (7, 0.0)] {
            for (count_m, late_s, kg) in [(0.0, 0.5e-3, 0.05), (10e-6, 0.5e-3, 0.05), (55e-6, 2.5e-3, 0.2), (100e-6, 2.5e-3, 0.3)]
            {
                let device = DeviceProfile { friction_n, delay_ticks, amplifier_lag_s: lag_s, count_m, ..touch() };
                let found = run(&device, &MISTAKES[0]);
                let wrong_s =
                    f64::from(found.delay_ticks) * 1e-3 + f64::from(found.lag_s) - f64::from(delay_ticks) * 1e-3 - lag_s;
                let case = format!("{friction_n} N, {delay_ticks} ticks, {lag_s} s, {count_m} m: {found:?}");
                assert!(wrong_s > -1e-6 && wrong_s < late_s + 1e-6, "{case}");
                assert!(found.friction_n.iter().all(|n| (f64::from(*n) - friction_n).abs() < 5e-3), "{case}");
                assert!(found.mass_kg.iter().all(|m| (f64::from(*m) / device.mass_kg - 1.0).abs() < kg), "{case}");
                assert!(found.count_m.iter().all(|m| (f64::from(*m) - count_m).abs() < 0.02 * count_m + 1e-7), "{case}");
            }
        }
    }
}

#[test]
fn every_shipped_device_is_measured() {
    for (name, _) in PROFILES {
        let device = DeviceProfile::load(name).unwrap();
        let found = run(&device, &MISTAKES[0]);
        for axis in (0..3).filter(|axis| device.axes == 3 || *axis == 2) {
            assert!((f64::from(found.friction_n[axis]) - device.friction_n).abs() < 0.02, "{name}: {found:?}");
            assert!((f64::from(found.mass_kg[axis]) / device.mass_kg - 1.0).abs() < 0.2, "{name}: {found:?}");
        }
        let late_s = f64::from(device.delay_ticks) * 1e-3 + device.amplifier_lag_s;
        let spare_s = f64::from(found.delay_ticks) * 1e-3 + f64::from(found.lag_s) - late_s;
        assert!((0.0..1.1e-3).contains(&spare_s), "{name}: {found:?}");
    }
}

#[test]
fn a_handle_that_is_held_or_moves_ends_it() {
    for hand in HANDS.into_iter().skip(1) {
        let held = commissioned(&touch(), &MISTAKES[0], HandsOff::Held(hand), 0.0);
        assert!(matches!(held, Err(Trouble::Held(0))), "{}: {held:?}", hand.id);
    }
    for m_per_s in [1e-3, 5e-3, 0.05] {
        let moved = commissioned(&touch(), &MISTAKES[0], HandsOff::Moved(m_per_s), 0.0);
        assert!(matches!(moved, Err(Trouble::Moving)), "{m_per_s} m/s: {moved:?}");
    }
    let stuck = DeviceProfile { friction_n: 0.6, ..touch() };
    assert!(matches!(commissioned(&stuck, &MISTAKES[0], HandsOff::Free, 0.0), Err(Trouble::Stuck(0))));
}

fn session() -> HapticSession {
    let patch = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/patches/block-m4f-168.patch");
    HapticSession::open_patch(Path::new(patch), "touch").unwrap()
}

/// Runs a commissioning of a session on an emulated device until a stage is met.
fn until(session: &mut HapticSession, plant: &mut Plant, mistake: &Mistake, wanted: impl Fn(Stage) -> bool) -> Stage {
    let site_m = session.tissue().patch().site_m();
    let free =
        Aim { at_m: Vector3::zeros(), velocity_m_per_s: Vector3::zeros(), push_n: Vector3::zeros(), let_go: true, steady: true };
    let (mut stage, mut since) = (Stage::Start(0), 0_u32);
    for _ in 0..300_000 {
        let share = f64::from(since.min(1_000)) / 1e3;
        match stage {
            Stage::Start(_) | Stage::LetGo => plant.put(Vector3::repeat(1.3e-4)),
            Stage::Move(axis) => {
                let mut at_m = Vector3::repeat(1.3e-4);
                at_m[usize::from(axis)] += 0.05 * share;
                plant.put(at_m);
            }
            _ => {}
        }
        let reading = site_m + Vector3::from(mistake.readings(plant.sense().position_m));
        let step = session.commission(reading, 0.05, stage.asks() && since > 1_000).unwrap();
        assert!(step.force_n.amax() <= 0.5);
        since = if step.stage == stage { since + 1 } else { 0 };
        stage = step.stage;
        if wanted(stage) {
            return stage;
        }
        assert!(!matches!(stage, Stage::Stopped(_)), "{}", step.sentence(0.05));
        plant.actuate(mistake.force_n(step.force_n.into()));
        if matches!(stage, Stage::Drive(_)) {
            plant.step(&free, false);
        }
    }
    stage
}

fn plant() -> Plant {
    Plant::new(&touch(), HANDS[0], Vector3::zeros(), Vector3::z(), Vector3::zeros())
}

#[test]
fn a_force_that_was_lowered_stays_so() {
    let (mut session, mut plant) = (session(), plant());
    session.lower_force(0.2).unwrap();
    assert_eq!(until(&mut session, &mut plant, &MISTAKES[0], |stage| stage == Stage::Done), Stage::Done);
    assert_eq!((session.limits().max_force_n, session.device().commissioned), (0.2, true));
    session.reset().unwrap();
    assert_eq!(session.limits().max_force_n, 0.2);
}

#[test]
fn a_session_is_capped_until_it_is_commissioned_and_reads_and_drives_right_afterwards() {
    let mistake = MISTAKES.last().unwrap();
    let (mut session, mut plant) = (session(), plant());
    assert_eq!(session.limits().max_force_n, 0.5);
    assert!(session.cautions().join(" ").contains("not commissioned"), "{:?}", session.cautions());
    assert_eq!(until(&mut session, &mut plant, mistake, |stage| stage == Stage::Done), Stage::Done);
    assert_eq!((session.limits().max_force_n, session.device().commissioned), (3.0, true));
    assert_eq!(session.cautions(), Vec::<String>::new());

    // pressed by 3 mm: the force on the real device points out of the tissue
    let site_m = session.tissue().patch().site_m();
    let outward = session.tissue().params().probe.axis;
    session.arm().unwrap();
    let mut applied_n = Vector3::zeros();
    for n in 0..2_000_u16 {
        let depth_m = 3e-3 - 6e-3 * (f32::from(n.saturating_sub(1_000)) / 500.0).min(1.0);
        let reading = site_m + Vector3::from(mistake.readings(outward * depth_m));
        let record = *session.tick(&Input::at(reading));
        assert_eq!(record.fault, None, "tick {n}");
        applied_n = record.applied_n;
    }
    assert!(applied_n.dot(&outward) > 0.05, "{applied_n}");
    let driven_n = mistake.force_n(session.drive_n().into());
    assert!((driven_n - applied_n).norm() < 1e-6, "{driven_n} for {applied_n}");

    let file = std::env::temp_dir().join(format!("palpate-commissioned-{}.toml", std::process::id()));
    session.write_profile(&file).unwrap();
    let kept = DeviceProfile::load(file.to_str().unwrap()).unwrap();
    std::fs::remove_file(&file).unwrap();
    assert_eq!(kept.wiring.unwrap().wiring().motor, mistake.wiring().motor);
    assert!(kept.commissioned.is_some() && (kept.friction_n - 0.03).abs() < 5e-3 && kept.delay_ticks <= 1, "{kept:?}");
}

#[test]
fn a_commissioning_that_is_interrupted_leaves_the_session_as_it_was() {
    let (mut session, mut plant) = (session(), plant());
    assert_eq!(until(&mut session, &mut plant, &MISTAKES[0], |stage| stage == Stage::Drive(1)), Stage::Drive(1));
    session.stop_commissioning();
    assert_eq!((session.limits().max_force_n, session.device().commissioned), (0.5, false));
    assert!(session.write_profile(Path::new("never.toml")).is_err() && !Path::new("never.toml").exists());
    // a tick ends it too, and an armed loop has none
    let site_m = session.tissue().patch().site_m();
    session.commission(site_m, 0.05, false).unwrap();
    assert_eq!(session.commission(site_m, 1e-3, false).err(), Some(OutOfOrder::Distance));
    session.tick(&Input::at(site_m));
    session.arm().unwrap();
    assert_eq!(session.commission(site_m, 0.05, false).err(), Some(OutOfOrder::Armed));
    assert_eq!(session.limits().max_force_n, 0.5);
    session.reset().unwrap();
    assert_eq!(session.limits().max_force_n, 0.5);
}

/// A handle that is really faster than the profile's cautious values assume: the loop damps for a
/// lag of 3 ms that is not there.
#[test]
fn a_loop_with_the_cautious_values_stays_quiet_on_a_device_that_is_faster() {
    let real = DeviceProfile { count_m: 10e-6, ..touch() };
    let assumed = DeviceProfile { amplifier_lag_s: 3e-3, friction_n: 0.0, mass_kg: 0.03, ..real.clone() };
    let settings = Settings { limits: real.limit_values(), ..Settings::safe(&assumed.limits(Vector3::zeros())) };
    for hand in HANDS {
        for stimulus in ["S1-0.05", "S1-0.2", "S2"].into_iter().filter_map(Stimulus::named) {
            for n_per_m in [100.0, 300.0] {
                let depth_m = 4e-3;
                let setup = Setup { device: &real, hand, stimulus, settings, depth_m, static_n: n_per_m * depth_m };
                let run = run_loop(&setup, &mut Wall::new(n_per_m, real.force_limit_n, Vector3::z())).unwrap();
                assert!(run.quiet(), "{} {} {n_per_m} N/m: {:?} {:?}", hand.id, stimulus.id, run.fault, run.broken);
            }
        }
    }
}
