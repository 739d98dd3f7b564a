//! A tilted tip in the loop: fixed by the scene, turned by a device, watched, and refused.

use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::cycle::{Renderer, Settings};
use palpate::{Output, Params, Probe, ProbePose, ProbeShape, Vector3};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::Hand;
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::run::{Setup, run};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::with_tissue;
use palpate_loop::haptic_session::{HapticSession, Input};
use palpate_loop::live::LiveTissue;
use palpate_tests::bench::Bench;
use palpate_tissue::scene::{Scene, SceneError};
use palpate_tissue::session::calibrated;

const CAPSULE: &str = "shape = \"capsule\"\nradius_m = 0.006\nlength_m = 0.012\nalong = [1.0, 0.0, 0.0]";
const FLAT: &str = "shape = \"flat\"\nradius_m = 0.008";

fn text(tip: &str, tilt_deg: [f64; 3]) -> String {
    // Rust writes NaN, TOML nan
    let tilt_deg = format!("{tilt_deg:?}").to_lowercase();
    format!(
        "name = \"tilted\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = 3500.0\npoisson_ratio = 0.45\n\
         density_kg_per_m3 = 1060.0\nnodes = 410\n[probe]\n{tip}\ntilt_deg = {tilt_deg}\n\
         [drive]\nkind = \"depth\"\nholds_m = [0.003]\nramp_m_per_s = 0.04\nhold_s = 0.1\n"
    )
}

fn scene(tip: &str, tilt_deg: [f64; 3]) -> Result<Scene, SceneError> {
    Scene::parse("tilted", &text(tip, tilt_deg))
}

/// The quaternion of a tilt about y.
fn about_y(degrees: f32) -> [f32; 4] {
    let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
    [0.0, sin, 0.0, cos]
}

fn bench(shape: ProbeShape) -> Bench {
    Bench::calibrated(410).with(|p| p.probe = Probe { shape, radius_m: 6e-3, axis: Vector3::z() })
}

fn long() -> ProbeShape {
    ProbeShape::Capsule { length_m: 12e-3, along: Vector3::x() }
}

/// Outputs of a press to 3 mm at 20 mm/s, from 6 mm above the place where the tip touches.
fn pressed(tissue: &mut LiveTissue, touch_m: Vector3<f32>) -> Vec<Output> {
    let depths_m = (0_i16..450).map(|n| (f32::from(n) * 2e-5 - 6e-3).min(3e-3));
    depths_m.map(|depth_m| tissue.render(ProbePose { tip_m: touch_m - Vector3::z() * depth_m })).collect()
}

#[test]
fn what_cannot_tilt_is_refused_in_one_sentence() {
    for (tilt_deg, says) in [
        ([0.0, 60.0, 0.0], "probe.tilt_deg = [0.0, 60.0, 0.0] tilts the tip by 60.0 degrees: give at most 45"),
        ([0.0, 400.0, 0.0], "400.0 degrees: give at most 45"),
        ([0.0, 0.0, -50.0], "50.0 degrees: give at most 45"),
        ([40.0, 40.0, 0.0], "56.6 degrees: give at most 45"),
        ([0.0, f64::NAN, 0.0], "probe.tilt_deg[1] = NaN is not a number of degrees: give one"),
        ([f64::INFINITY, 0.0, 0.0], "probe.tilt_deg[0] = inf is not a number of degrees: give one"),
    ] {
        let refused = scene(CAPSULE, tilt_deg).unwrap_err().to_string();
        assert!(refused.contains(says), "{refused}");
    }
    assert!(scene(CAPSULE, [0.0, 45.0, 0.0]).is_ok());
    let tilted = scene(FLAT, [10.0, 0.0, 0.0]).unwrap();
    let refused = |refusal: Result<(), SceneError>| refusal.unwrap_err().to_string();
    let board = refused(tilted.refuse_what_boards_lack("m4f-168"));
    assert!(board.contains("probe.tilt_deg") && board.contains("a tip cannot tilt on m4f-168"), "{board}");
    assert!(refused(tilted.refuse_what_no_file_has()).contains("a patch is made for an upright tip"));
    assert!(refused(tilted.refuse_what_a_law_lacks("a law has no nodes")).contains("a tilted tip"));
    let upright = scene(FLAT, [0.0; 3]).unwrap();
    upright.refuse_what_boards_lack("m4f-168").and(upright.refuse_what_no_file_has()).unwrap();
    assert_eq!(upright.params([0.0, 0.0, 1.0]).orientation, Params::UPRIGHT);

    let mut session = HapticSession::of_patch_bytes(calibrated::bytes(130).unwrap(), "touch").unwrap();
    for wrong in [[0.0, 0.0, 0.0, 2.0], [0.0; 4], [f32::NAN, 0.0, 0.0, 1.0]] {
        let says = session.turn(wrong).unwrap_err().to_string();
        assert!(says.contains("length of the unit quaternion"), "{says}");
    }
    let says = session.turn(about_y(60.0)).unwrap_err().to_string();
    assert!(says.contains("tilt (at most 45 degrees)"), "{says}");
    session.turn(about_y(30.0)).unwrap();
}

#[test]
fn a_tip_that_a_device_turns_gives_the_bits_of_one_that_was_fixed_so() {
    for shape in [long(), ProbeShape::Flat] {
        let bench = bench(shape);
        let fixed = Params { orientation: about_y(20.0), ..bench.params };
        let touch_m = bench.patch.touch_m(&fixed);
        let mut right = LiveTissue::new(bench.patch.clone(), fixed).unwrap();
        let mut turned = LiveTissue::new(bench.patch.clone(), bench.params).unwrap();
        let clear_m = touch_m + Vector3::z() * 6e-3;
        turned.turn(about_y(20.0)).unwrap();
        for _ in 0..100 {
            right.render(ProbePose { tip_m: clear_m });
            turned.render(ProbePose { tip_m: clear_m });
        }
        let (right, turned) = (pressed(&mut right, touch_m), pressed(&mut turned, touch_m));
        assert!(right.last().unwrap().force_n.z > 0.05 && right == turned, "{shape:?}");
        // the deepest point is 3 mm deep, and the face or the segment is not
        let depth_m = right.last().unwrap().depth_m;
        assert!((2.5e-3..3.3e-3).contains(&depth_m), "{shape:?}: {depth_m}");
    }
}

/// A tip whose orientation jumps, as by a bad reading, turns at the speed at which the guard lets a
/// tip sink.
#[test]
fn a_jump_of_the_orientation_is_no_blow() {
    let bench = bench(long());
    let most_m = bench.params.limits.max_sink_m_per_s * bench.params.tick_s;
    let mut tissue = LiveTissue::new(bench.patch.clone(), bench.params).unwrap();
    tissue.turn(about_y(40.0)).unwrap();
    let (clear_m, end_m) = (bench.patch.site_m() + Vector3::z() * 0.02, bench.params.probe.reach_m());
    let mut before = bench.params.turned_probe().axis;
    let mut ticks = 0;
    while tissue.params().orientation != about_y(40.0) {
        tissue.render(ProbePose { tip_m: clear_m });
        let axis = tissue.params().turned_probe().axis;
        let sinks_m = (axis - before).norm() * end_m;
        assert!(sinks_m <= 1.001 * most_m, "{sinks_m}");
        (before, ticks) = (axis, ticks + 1);
        assert!(ticks < 1000, "it never arrives");
    }
    assert!(ticks > 10, "{ticks}");
}

#[test]
fn a_ball_feels_no_tilt() {
    let bench = bench(ProbeShape::Sphere);
    let [upright, tilted] = [0.0, 30.0].map(|degrees| {
        let params = Params { orientation: about_y(degrees), ..bench.params };
        let mut tissue = LiveTissue::new(bench.patch.clone(), params).unwrap();
        pressed(&mut tissue, bench.patch.touch_m(&params)).last().unwrap().force_n
    });
    assert!(upright.z > 0.03 && (upright - tilted).norm() < 1e-3 * upright.z, "{upright} {tilted}");
}

/// A hand that pushes a tilted capsule through the whole block and out of its underside feels
/// nothing there; slow presses and taps are quiet.
#[test]
fn a_tilted_capsule_is_quiet_in_the_loop() {
    let device = DeviceProfile::load("touch").unwrap();
    let tissue = Prepared::of(&scene(CAPSULE, [0.0, 15.0, 0.0]).unwrap(), &device).unwrap();
    let settings = Settings { limits: device.limit_values(), ..Settings::safe(&device.limits(Vector3::zeros())) };
    for (hand, id) in [("H5", "S1-1"), ("H2", "S1-0.2"), ("H3", "S2")] {
        let (hand, stimulus) = (Hand::named(hand).unwrap(), Stimulus::named(id).unwrap().short());
        let setup = Setup { device: &device, hand, stimulus, settings, depth_m: tissue.depth_m, static_n: tissue.static_n };
        let run = with_tissue(&tissue.patch, &tissue.params, |tissue| run(&setup, tissue)).unwrap().unwrap();
        let label = format!("{} {id}: {:?}, {:?}, {:?}", hand.id, run.hold, run.broken, run.fault);
        assert!(run.quiet() && run.created_j <= 0.01e-3 && run.peak_n > 0.05, "{label}: {} J, {} N", run.created_j, run.peak_n);
    }
}

/// A device that turns the tip but has no torque lets a hand put energy into the tissue without
/// effort: it presses the tip upright, tilts it about its middle at the depth, and the tissue then
/// pushes harder than it was pressed. The account gives the hand no more than the printed bound.
#[test]
fn a_tip_that_turns_without_effort_gives_no_more_than_the_printed_bound() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turns.toml");
    for (tip, device) in [(FLAT, "touch"), (FLAT, "inverse3"), (CAPSULE, "inverse3")] {
        let stiff = text(tip, [0.0; 3]).replace("3500.0", "20000.0").replace("nodes = 410", "nodes = 130");
        std::fs::write(&file, stiff).unwrap();
        let mut session = HapticSession::open(file.to_str().unwrap(), None, device).unwrap();
        session.arm().unwrap();
        let site_m = session.tissue().patch().site_m();
        // what the hand is given by the loop, and what the patch's own force would give
        let (mut given_j, mut owns_j, mut most_j) = (0.0_f32, 0.0_f32, 0.0_f32);
        let (mut at_m, mut force_n, mut own_n) = (site_m + Vector3::z() * 4e-3, Vector3::zeros(), Vector3::zeros());
        let cycle = [(0.0, -4e-3_f32), (0.0, 3e-3), (30.0, 3e-3), (30.0, -4e-3)];
        for (degrees, depth_m) in (0..10_u8).flat_map(|_| cycle) {
            session.turn(about_y(degrees)).unwrap();
            let step_m = (site_m - Vector3::z() * depth_m - at_m) * 4e-3;
            for _ in 0..250 {
                at_m += step_m;
                given_j += force_n.dot(&step_m);
                owns_j += own_n.dot(&step_m);
                most_j = most_j.max(given_j);
                let telemetry = session.tick(&Input::at(at_m));
                (force_n, own_n) = (telemetry.applied_n, telemetry.output.force_n);
            }
        }
        let bound_j = EnergyAccount::bound(&AccountSettings::DEFAULT, session.device(), 1e-3, 0).within_j(10.0);
        let tip = tip.lines().next().unwrap();
        println!("{tip} on {device}: {most_j} J of {bound_j} J; the patch's own force {owns_j} J");
        assert_eq!(session.telemetry().unwrap().fault, None);
        assert!(owns_j > 2e-3 && most_j <= bound_j, "{tip} on {device}: {most_j} J of {bound_j} J, {owns_j} J");
    }
}
