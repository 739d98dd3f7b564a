//! A recorded run that is driven again by its own `trace.csv` gives the same bits, and so do two
//! runs of one scene.

use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::{self, Press};
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::trace_file;

fn run(scene: &Scene) -> Press {
    press::run(scene, &Session::prepare(scene).unwrap(), |_| {}).unwrap()
}

/// Returns force, depth and limiter flags of each tick, as bits.
fn answers(press: &Press) -> Vec<[u32; 5]> {
    let bits = |t: &press::TickRow| {
        let f = t.output.force_n.map(f32::to_bits);
        [f.x, f.y, f.z, t.output.depth_m.to_bits(), u32::from(t.output.limiters.bits())]
    };
    press.ticks.iter().map(bits).collect()
}

fn compare(name: &str, first: &Press, second: &Press) {
    assert_eq!(first.ticks.len(), second.ticks.len(), "{name}");
    let (first_answers, second_answers) = (answers(first), answers(second));
    let differs = first_answers.iter().zip(&second_answers).position(|(a, b)| a != b);
    assert_eq!(differs, None, "{name}: first tick with another answer");
    assert_eq!(first.state_hash, second.state_hash, "{name}");
    assert!(first.ticks.iter().any(|t| t.output.force_n.norm() > 0.01), "{name}: a press that is not felt proves nothing");
}

/// Runs a scene twice, then replays its trace, and compares all three. The depth limit determines
/// the substeps, and the trace does not contain the depth that a finger could have reached.
fn replays(name: &str, scene: &Scene, told_limit: bool) {
    let folder = tempfile::tempdir().unwrap();
    let first = run(scene);
    compare(&format!("{name}, again"), &first, &run(scene));
    let out = OutputFolder::open(folder.path()).unwrap();
    trace_file::write(&out, &first).unwrap();
    out.publish().unwrap();
    let depth_limit_m = told_limit.then(|| Session::prepare(scene).unwrap().report.depth_limit_mm * 1e-3);
    let drive = Drive::Trace { trace: folder.path().join("trace.csv"), depth_limit_m };
    compare(&format!("{name}, replayed"), &first, &run(&Scene { drive, ..scene.clone() }));
}

fn preset(name: &str, drive: Option<Drive>) -> Scene {
    let mut scene = Scene::load(name).unwrap();
    scene.drive = drive.unwrap_or(scene.drive);
    scene
}

#[test]
fn presses_to_a_depth() {
    replays("block", &preset("block", None), false);
    replays("20 kPa", &preset("block-20kpa", None), false);
    replays("nodule", &preset("nodule", None), false);
}

#[test]
fn presses_of_a_finger() {
    let holds_n = vec![0.05, 0.12];
    replays("force", &preset("block", Some(Drive::Force { holds_n, ramp_m_per_s: 0.04, hold_s: 0.2 })), true);
    let holds_m = vec![0.002, 0.005];
    replays("hand", &preset("block", Some(Drive::Hand { holds_m, ramp_m_per_s: 0.04, hold_s: 0.2 })), true);
}

#[test]
fn a_press_deeper_than_the_probe_is_wide() {
    let holds_m = vec![0.008];
    replays("8 mm", &preset("block", Some(Drive::Depth { holds_m, ramp_m_per_s: 0.04, hold_s: 0.2 })), false);
}
