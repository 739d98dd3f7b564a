//! The emulated hands on the emulated board: forces and motions equal those of the desktop's loop,
//! to the last bit in every tick, even if the tissue changes under the probe.

use std::path::Path;

use palpate_board::EmulatedBoard;
use palpate_board::in_loop::InLoop;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::Hand;
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::report::Target;
use palpate_loop::closed_loop::run::Run;
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_tests::emulator::build_firmware;
use palpate_tests::packed;
use palpate_tissue::fit_record::press_packed;
use palpate_tissue::scene::Scene;

fn prepared(scene: &str, patch: &str, device: &DeviceProfile) -> (InLoop, Target) {
    let mut scene = Scene::load(scene).unwrap();
    press_packed(&mut scene, &packed::shipped(patch));
    let tissue = Prepared::as_packed(&scene, device).unwrap();
    let image = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let board = InLoop::new(image, EmulatedBoard::M4f, &tissue).unwrap();
    (board, Target::Tissue(Box::new(tissue), scene.tissue.youngs_modulus_pa))
}

/// All values that a tick reported and applied, as bits.
fn bits(run: &Run) -> Vec<[u64; 14]> {
    let rows = run.rows.iter().map(|row| {
        let telemetry = &row.telemetry;
        let single = |x: f32| u64::from(x.to_bits());
        let [a, f, w] = [telemetry.applied_n, telemetry.output.force_n, telemetry.wanted_n].map(|v| [v.x, v.y, v.z].map(single));
        let at = [row.at_m.x, row.at_m.y, row.at_m.z].map(f64::to_bits);
        let rest = [u64::from(telemetry.tick), single(telemetry.output.depth_m)];
        [a[0], a[1], a[2], f[0], f[1], f[2], w[0], w[1], w[2], at[0], at[1], at[2], rest[0], rest[1]]
    });
    rows.collect()
}

#[test]
fn hands_feel_the_board_as_they_feel_the_desktop() {
    let device = DeviceProfile::load("touch").unwrap();
    let (board, target) = prepared("block", "block-m4f-168.patch", &device);
    for (hand, stimulus) in [("H2", "S1-0.2"), ("H0", "S7"), ("H1", "S11")] {
        let (hand, stimulus) = (Hand::named(hand).unwrap(), Stimulus::named(stimulus).unwrap());
        let there = board.run(&target.setup(&device, hand, stimulus)).unwrap();
        let here = board.desktop(&target.setup(&device, hand, stimulus)).unwrap();
        let in_organ = target.run(&device, hand, stimulus).unwrap();
        println!(
            "{} {}: {} ticks, {:.4} N at most, {:.4} in the organ's frame",
            hand.id,
            stimulus.id,
            there.rows.len(),
            there.peak_n,
            in_organ.peak_n
        );
        assert!((there.peak_n / in_organ.peak_n - 1.0).abs() < 0.01 && there.quiet() == in_organ.quiet());
        assert!(there.peak_n > 0.05 && there.broken.is_empty() && there.fault.is_none(), "{:?} {:?}", there.broken, there.fault);
        let first = bits(&there).iter().zip(bits(&here)).position(|(a, b)| *a != b);
        assert_eq!(first, None, "{} {}: the first tick that differs", hand.id, stimulus.id);
        assert_eq!(there.rows.len(), here.rows.len());
    }
    // the workspace, counts and force limit of another device are sent over the link
    let falcon = DeviceProfile::load("falcon").unwrap();
    let setup = target.setup(&falcon, Hand::named("H5").unwrap(), Stimulus::named("S3").unwrap());
    let there = board.run(&setup).unwrap();
    assert!(there.peak_n > 0.05 && bits(&there) == bits(&board.desktop(&setup).unwrap()));
}

#[test]
fn an_organ_pressed_along_its_own_axis_is_followed_and_its_far_field_is_not() {
    let device = DeviceProfile::load("touch").unwrap();
    let (board, target) = prepared("organ-liver", "liver-m4f-168.patch", &device);
    assert!(board.cannot_follow(&Stimulus::named("S12").unwrap()));
    let setup = target.setup(&device, Hand::named("H2").unwrap(), Stimulus::named("S1-0.5").unwrap());
    let run = board.run(&setup).unwrap();
    assert!(run.peak_n > 0.05 && run.fault.is_none(), "{} N, {:?}", run.peak_n, run.fault);
    assert!(bits(&run) == bits(&board.desktop(&setup).unwrap()));
}
