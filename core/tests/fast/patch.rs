//! The whole path from a reading to a force, on a shipped patch.

use palpate::haptic::cycle::{Ask, Command, Cycle, PatchRenderer, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{ProbePose, ProbeShape, Vector3};

use crate::bench::{Bench, Device, pushing, stylus};
use crate::guard::Tissue;

/// Runs one cycle with the tip this high above the patch's site [m].
fn run(cycle: &mut Cycle, device: &mut Device, tissue: &mut Tissue, z_m: f32, asked: Option<Ask>) -> Telemetry {
    device.sensed.position_m = tissue.file.site_m + Vector3::new(0.0, 0.0, z_m);
    device.sensed.sequence += 1;
    let mut renderer = PatchRenderer { model: &tissue.file.model, tuned: &tissue.tuned, state: &mut tissue.state };
    cycle.tick(device, &mut renderer, Command { asked, ..Command::HEARD })
}

#[test]
fn a_press_is_felt_and_over_when_the_probe_has_left() {
    let mut tissue = Tissue::new();
    let mut device = Device {
        limits: stylus(),
        sensed: Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Good },
        drive_n: None,
    };
    let mut cycle = Cycle::build(&Settings::safe(&stylus()), &stylus()).unwrap();
    for asked in [Ask::Booted, Ask::TestPassed, Ask::Arm] {
        run(&mut cycle, &mut device, &mut tissue, 5e-3, Some(asked));
    }
    let mut at = |z_m: f32| run(&mut cycle, &mut device, &mut tissue, z_m, None);
    (0..700).for_each(|_| _ = at(5e-3));
    assert_eq!(at(5e-3).mode, Mode::Active);
    (0..200).for_each(|n| _ = at(5e-3 - 40e-6 * n as f32));
    let held = (0..200).map(|_| at(-3e-3)).last().expect("ticks");
    assert!(held.applied_n.z > 0.05 && held.output.depth_m > 2.5e-3, "{held:?}");
    assert!((held.applied_n - held.output.force_n).norm() < 1e-3, "at rest nothing is added");
    let left = (0..100).map(|n| at(-3e-3 + 0.1e-3 * f32::from(n as u8))).last().expect("ticks");
    assert_eq!((left.applied_n, left.fault), (Vector3::zeros(), None));
}

/// A flat tip enters stiff tissue at 20 mm/s and stops dead, as read by a coarse encoder: the
/// tissue rings for 0.1 s, and the force on the tip is neither faded nor reduced.
#[test]
fn a_press_that_stops_dead_keeps_its_force_while_the_tissue_rings() {
    let count_m = 55e-6;
    let limits = DeviceSpec { count_m, max_force_n: 6.0, ..stylus() };
    for shift_m in [5e-6, 25e-6, 45e-6] {
        let mut tissue = Tissue::fine(|p| (p.youngs_modulus_pa, p.probe.shape) = (20e3, ProbeShape::Flat));
        let sensed = Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Good };
        let mut device = Device { limits, sensed, drive_n: None };
        let mut cycle = Cycle::build(&Settings::safe(&limits), &limits).unwrap();
        for n in 0..2_075_u16 {
            let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(usize::from(n)).copied();
            let z_m = (5e-3 - 20e-6 * f32::from(n.saturating_sub(1000))).max(-0.5e-3) + shift_m;
            let record = run(&mut cycle, &mut device, &mut tissue, libm::floorf(z_m / count_m) * count_m, asked);
            if n >= 1_300 {
                let held = record.mode == Mode::Active && record.applied_n.z > 0.1;
                assert!(held, "{shift_m} m, {} ms after the stop: {record:?}", n - 1_275);
            }
        }
    }
}

/// A hand that trembles in soft contact: 0.5 mm deep, 0.2 mm up and down at 6 Hz, counts of 55 um.
#[test]
fn a_slow_motion_is_charged_its_true_energy_and_at_most_a_count_for_every_rise_beyond() {
    let mut tissue = Tissue::with(|params| params.youngs_modulus_pa = 60e3);
    let count_m = 55e-6;
    let limits = DeviceSpec { count_m, ..stylus() };
    let sensed = Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Good };
    let mut device = Device { limits, sensed, drive_n: None };
    let mut cycle = Cycle::build(&Settings::safe(&limits), &limits).unwrap();
    let (mut last_m, mut sent_n, mut true_j, mut energy_j, mut rises_n) = (5e-3, [0.0_f32; 2], 0.0, 0.0, 0.0);
    for n in 0..5_255_u16 {
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(usize::from(n)).copied();
        let z_m = match n {
            ..1000 => 5e-3,
            1000..1275 => 5e-3 - 20e-6 * f32::from(n - 1000),
            _ => -0.5e-3 + 0.2e-3 * libm::sinf(core::f32::consts::TAU * f32::from((n - 1275) % 166) / 166.0),
        };
        true_j += sent_n[0] * (z_m - last_m);
        let record = run(&mut cycle, &mut device, &mut tissue, libm::floorf(z_m / count_m) * count_m, asked);
        rises_n += (record.applied_n.z - sent_n[1]).max(0.0);
        (last_m, sent_n, energy_j) = (z_m, [sent_n[1], record.applied_n.z], record.energy.given_j);
    }
    // a reading is half a count off, so that a rise and its fall hide between nothing and two
    // counts
    let most_j = true_j + 2.0 * count_m * rises_n;
    assert!((true_j..most_j).contains(&energy_j) && true_j < -50e-6, "{true_j}, {energy_j}, {most_j} J");
}

#[test]
fn reset_puts_the_patch_to_rest() {
    let mut tissue = Tissue::new();
    tissue.press(3e-3);
    let pressed = tissue.state.hash();
    let mut renderer = PatchRenderer { model: &tissue.file.model, tuned: &tissue.tuned, state: &mut tissue.state };
    renderer.reset();
    assert_eq!(renderer.state.hash(), Tissue::new().state.hash(), "as it was built");
    let output = renderer.render(ProbePose { tip_m: tissue.file.site_m + Vector3::new(0.0, 0.0, 5e-3) });
    assert_eq!(output.force_n, Vector3::zeros());
    assert!(tissue.state.hash() != pressed);
}

#[test]
fn damping_follows_the_slope_of_the_contact() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(2e-3, 1.0));
    let wanted_n = (0..60).map(|_| bench.at(bench.device.sensed.position_m.z - 0.05e-3).wanted_n.z).last().expect("ticks");
    // 1.5 F / depth = 750 N/m for 3 ms, and 0.3 N s/m, at 50 mm/s
    assert!((wanted_n - (1.0 + (750.0 * 3e-3 + 0.3) * 0.05)).abs() < 1e-3, "{wanted_n}");
}
