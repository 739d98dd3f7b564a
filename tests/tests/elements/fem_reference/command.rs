//! `palpate reference`, run as a user runs it.

use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tissue::answer::Answer;
use palpate_tissue::scene::Scene;
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// A small pad under a wide probe, which is cheap and cannot be compressed completely.
const PAD: &str = r#"
name = "pad"
[tissue]
block_m = [0.008, 0.008, 0.006]
youngs_modulus_pa = 5000.0
poisson_ratio = 0.45
density_kg_per_m3 = 1000.0
[probe]
shape = "hemisphere"
radius_m = 0.008
[drive]
kind = "depth"
holds_m = [0.0005, 0.001, 0.0059]
ramp_m_per_s = 0.01
hold_s = 0.1
"#;

fn summary(desk: &Desk) -> Value {
    let text = std::fs::read_to_string(desk.folder().join("out/reference/summary.json")).expect("written");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_press_that_cannot_converge_says_how_far_it_got_and_keeps_what_did() {
    let desk = Desk::default();
    desk.put("pad.toml", PAD);
    let run = palpate(SCRATCH, desk.folder(), &["reference", "--quick", "--scene", "pad.toml"]);
    assert_eq!(run.code, Some(1), "{}{}", run.stdout, run.stderr);
    assert!(run.stderr.contains("2 of 3 holds converged") && run.stderr.contains("press less deep"), "{}", run.stderr);
    assert_eq!(run.stderr.trim_end().lines().count(), 1, "{}", run.stderr);
    let answer = Answer::load(&desk.folder().join("out/reference/answer.json")).expect("kept");
    assert_eq!(answer.holds.iter().map(|h| h.depth_m).collect::<Vec<_>>(), [0.0005, 0.001]);
    assert!(answer.holds[1].force_over_e_m2 > answer.holds[0].force_over_e_m2);
    let reached_m = summary(&desk)["levels"][0]["reached_m"].as_f64().expect("says how far");
    assert!((0.001..0.0059).contains(&reached_m), "{reached_m}");
}

#[test]
fn a_force_drive_finds_the_depth_of_the_depth_drive() {
    let desk = Desk::default();
    desk.put("depth.toml", PAD.replace(", 0.0059", ""));
    let run = palpate(SCRATCH, desk.folder(), &["reference", "--quick", "--scene", "depth.toml"]);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let files =
        ["answer.json", "forces.csv", "refinement.png", "refinement.svg", "summary.json", "surface_0.csv", "surface_1.csv"];
    for file in files {
        assert!(desk.folder().join("out/reference").join(file).is_file(), "{file}");
    }
    let by_depth = summary(&desk);
    let forces = |k: usize| by_depth["holds"][k]["force_n"][2].as_f64().expect("three meshes");
    assert!(by_depth["holds"][1]["estimated_error_pct"].as_f64().is_some_and(|e| e > 0.0 && e < 3.0), "{by_depth}");
    let scene = Scene::load(desk.folder().join("depth.toml").to_str().expect("UTF-8")).expect("valid");
    let answer = Answer::load(&desk.folder().join("out/reference/answer.json")).expect("written");
    assert!(answer.is_for(&scene));
    assert!((answer.holds[0].force_over_e_m2 * 5000.0 / forces(0) - 1.0).abs() < 1e-12);

    let holds = format!("holds_n = [{}]", forces(1));
    desk.put("force.toml", PAD.replace("holds_m = [0.0005, 0.001, 0.0059]", &holds).replace("\"depth\"", "\"force\""));
    let run = palpate(SCRATCH, desk.folder(), &["reference", "--quick", "--scene", "force.toml"]);
    assert_eq!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    // the two drives use different meshes, so the results differ by their mesh errors
    let depth_m = summary(&desk)["holds"][0]["depth_m"][2].as_f64().expect("three meshes");
    assert!((depth_m / 0.001 - 1.0).abs() < 0.01, "{depth_m}");
}

#[test]
fn a_scene_without_a_static_answer_is_refused() {
    let cases = [
        ("kind = \"depth\"", "kind = \"hand\"", "drive.kind"),
        ("density_kg_per_m3", "gravity_m_per_s2 = [0.0, 0.0, -9.81]\ndensity_kg_per_m3", "gravity_m_per_s2"),
        ("poisson_ratio = 0.45", "poisson_ratio = 0.495", "poisson_ratio"),
    ];
    for (from, to, key) in cases {
        let desk = Desk::default();
        desk.put("pad.toml", PAD.replace(from, to));
        let run = palpate(SCRATCH, desk.folder(), &["reference", "--quick", "--scene", "pad.toml"]);
        assert_eq!(run.code, Some(2), "{to}: {}", run.stderr);
        assert!(run.stderr.contains(key), "{to}: {}", run.stderr);
        assert_eq!(desk.listing(), ["pad.toml"], "bad input leaves nothing behind");
    }
}
