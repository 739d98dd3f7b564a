//! Each drive reaches the scene's targets, and each probe shape responds as contact mechanics
//! predicts.

use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tests::press_run::{PressRun, SMALL_BLOCK, edited, press, press_at};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const HOLDS: &str = "holds_m = [0.001, 0.002, 0.004]";
/// Stiffness between hand and probe [N/m]: a firm fingertip, of the order that Hajian & Howe (1997)
/// measured.
const FINGER_N_PER_M: f64 = 800.0;

fn driven(kind: &str, holds: &str) -> PressRun {
    press(SCRATCH, &edited(&edited(SMALL_BLOCK, "\"depth\"", &format!("\"{kind}\"")), HOLDS, holds))
}

fn shaped(shape: &str, radius_m: f64, nodes: usize, holds: &str) -> PressRun {
    let scene = edited(SMALL_BLOCK, "\"hemisphere\"", &format!("\"{shape}\""));
    let scene = edited(&scene, "radius_m = 0.008", &format!("radius_m = {radius_m}"));
    let scene = edited(&scene, "nodes = 129", &format!("nodes = {nodes}"));
    press(SCRATCH, &edited(&scene, HOLDS, &format!("holds_m = {holds}")))
}

/// Positions of the probe tip in a run [m], shape \[ticks\]\[3\].
fn tips(run: &PressRun) -> Vec<[f64; 3]> {
    run.trace.rows.iter().map(|row| [row[1], row[2], row[3]]).collect()
}

#[test]
fn depth_drive_stops_at_each_depth_and_returns() {
    let run = driven("depth", HOLDS);
    let z: Vec<f64> = tips(&run).iter().map(|tip| tip[2]).collect();
    for target in [0.001, 0.002, 0.004] {
        let ticks = z.iter().filter(|z| (*z + target).abs() < 1e-9).count();
        // the tick of arrival is the first of the 300; passing the depth during the retreat may add
        // one
        assert!((300..=301).contains(&ticks), "{target} m: {ticks} ticks");
    }
    let fastest = z.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!((fastest / 40e-6 - 1.0).abs() < 1e-4, "{fastest} m a tick");
    assert!(z[0] > 0.0 && z[z.len() - 1] > 0.0);
}

#[test]
fn force_drive_reaches_each_force() {
    let run = driven("force", "holds_n = [0.05, 0.1, 0.2]");
    let holds = run.holds();
    assert_eq!(holds.iter().map(|h| h.target).collect::<Vec<_>>(), [0.05, 0.1, 0.2]);
    for hold in &holds {
        println!("{hold:?}");
        assert!((hold.force_n / hold.target - 1.0).abs() < 0.02, "{hold:?}");
    }
    // compared with the forces of a depth drive at the depths that this drive reached
    let depths: Vec<String> = holds.iter().map(|h| h.depth_m.to_string()).collect();
    let pressed = driven("depth", &format!("holds_m = [{}]", depths.join(", ")));
    for (hold, force_n) in holds.iter().zip(pressed.forces_n()) {
        assert!((force_n / hold.force_n - 1.0).abs() < 0.02, "{hold:?}: {force_n} N when driven there");
    }
}

#[test]
fn force_that_the_patch_cannot_give_fails_the_check() {
    let desk = Desk::default();
    desk.put("scene.toml", edited(&edited(SMALL_BLOCK, "\"depth\"", "\"force\""), HOLDS, "holds_n = [0.1, 5.0]"));
    let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("of 5 N") && outcome.stderr.lines().count() == 1, "{outcome:?}");
    assert!(desk.folder().join("out/summary.json").is_file());
}

#[test]
fn hand_drive_stretches_the_finger_by_the_force() {
    let run = driven("hand", HOLDS);
    for (n, hold) in run.holds().iter().enumerate() {
        // a hold is evaluated at its end, in the last tick before the hand moves on
        let forces = run.trace.column("force_z_n");
        let row = forces.iter().position(|f| *f == hold.force_n).unwrap();
        let depth_m = -tips(&run)[row][2];
        let stretch_n = FINGER_N_PER_M * (hold.target - depth_m);
        println!("hold {n}: {:.5} N, finger {stretch_n:.5} N, {depth_m:.6} m", hold.force_n);
        // at rest after 0.3 s: the remaining motion is below 1 %
        assert!((stretch_n / hold.force_n - 1.0).abs() < 0.01, "hold {n}: {} N, finger {stretch_n} N", hold.force_n);
        assert!(depth_m < hold.target);
    }
}

#[test]
fn trace_drive_repeats_a_run_bit_for_bit() {
    let recorded = driven("depth", HOLDS);
    let scene = format!("{}[drive]\nkind = \"trace\"\ntrace = \"recorded.csv\"\n", SMALL_BLOCK.split("[drive]").next().unwrap());
    let desk = Desk::default();
    desk.put("recorded.csv", std::fs::read(recorded.out.join("trace.csv")).unwrap());
    let repeated = press_at(SCRATCH, desk, &scene, &[]);
    assert_eq!(repeated.summary["state_hash"], recorded.summary["state_hash"]);
    for column in ["t_s", "probe_x_m", "probe_y_m", "probe_z_m", "depth_m", "force_x_n", "force_y_n", "force_z_n"] {
        assert_eq!(repeated.trace.column(column), recorded.trace.column(column), "{column}");
    }
}

#[test]
fn trace_and_patch_are_looked_for_beside_the_scene() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    desk.put("scenes/t.csv", "t_s,probe_x_m,probe_y_m,probe_z_m\n0,0,0,0.001\n0.001,0,0,0.0005\n");
    let scene = format!("{}[drive]\nkind = \"trace\"\ntrace = \"t.csv\"\n", SMALL_BLOCK.split("[drive]").next().unwrap());
    desk.put("scenes/a.toml", scene);
    let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scenes/a.toml", "--out", "out"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn trace_is_followed_deeper_than_the_default_limit() {
    // 7.5 mm, the depth limit of a force drive, is 15/16 of this radius
    let recorded = shaped("hemisphere", 0.008, 129, "[0.0085]");
    let scene = format!("{}[drive]\nkind = \"trace\"\ntrace = \"t.csv\"\n", SMALL_BLOCK.split("[drive]").next().unwrap());
    let desk = Desk::default();
    desk.put("t.csv", std::fs::read(recorded.out.join("trace.csv")).unwrap());
    let repeated = press_at(SCRATCH, desk, &scene, &[]);
    assert_eq!(repeated.summary["limiters"], recorded.summary["limiters"]);
    assert_eq!(repeated.trace.column("force_z_n"), recorded.trace.column("force_z_n"));
}

#[test]
fn flat_punch_is_near_the_closed_form() {
    // 2 a E/(1 - nu^2) d on a half-space, times 1.213 for this block (linear finite elements); 0.25
    // mm is 3 % of the radius
    let (a_m, e_pa, nu, depth_m) = (0.008, 3500.0, 0.45_f64, 0.25e-3);
    let exact_n = 1.213 * 2.0 * a_m * e_pa / (1.0 - nu * nu) * depth_m;
    for nodes in [410, 1000] {
        let force_n = shaped("flat", a_m, nodes, "[0.00025]").forces_n()[0];
        println!("flat, {nodes} nodes: {force_n:.5} N, closed form {exact_n:.5} N ({:+.1} %)", (force_n / exact_n - 1.0) * 100.0);
        // the patch is uncalibrated: its promised error is a quarter
        assert!((force_n / exact_n - 1.0).abs() < 0.25, "{nodes} nodes: {force_n} N, closed form {exact_n} N");
    }
}

#[test]
fn hemisphere_rises_from_the_first_tenth_of_a_millimetre() {
    let run = shaped("hemisphere", 0.008, 410, "[0.0001, 0.0002, 0.0004, 0.0008, 0.0016]");
    let forces = run.forces_n();
    println!("{forces:.6?}");
    assert!(forces[0] > 0.0, "{forces:?}");
    for pair in forces.windows(2) {
        // Hertz: 2^1.5 = 2.8 times the force at twice the depth; one flat element would give 2,
        // contact of single points 4 and more
        assert!((2.0..4.0).contains(&(pair[1] / pair[0])), "{forces:?}");
    }
}

#[test]
fn sphere_is_a_hemisphere_without_the_handle() {
    let [shallow_s, shallow_h] = ["sphere", "hemisphere"].map(|shape| shaped(shape, 0.008, 129, "[0.001, 0.004]").forces_n());
    assert_eq!(shallow_s, shallow_h);
    // pressed against the side of the block, 3 mm in, with the tip outside the tissue: a handle
    // makes contact only where its tip went in
    let mut trace = String::from("probe_x_m,probe_y_m,probe_z_m\n");
    (0..=300).for_each(|n| trace.push_str(&format!("{},0,-0.012\n", 0.050 - 30e-6 * f64::from(n))));
    let last_n = |shape: &str| {
        let scene = edited(SMALL_BLOCK.split("[drive]").next().unwrap(), "\"hemisphere\"", &format!("\"{shape}\""));
        let scene = edited(&edited(&scene, "radius_m = 0.008", "radius_m = 0.004"), "nodes = 129", "nodes = 1000");
        let scene = edited(&scene, "position_m = [0.0, 0.0]", "position_m = [0.04, 0.0]");
        let desk = Desk::default();
        desk.put("t.csv", &trace);
        let run = press_at(
            SCRATCH,
            desk,
            &format!("{scene}[drive]\nkind = \"trace\"\ntrace = \"t.csv\"\ndepth_limit_m = 0.004\n"),
            &[],
        );
        *run.trace.column("force_x_n").last().unwrap()
    };
    let (sphere_n, hemisphere_n) = (last_n("sphere"), last_n("hemisphere"));
    println!("against the side: sphere {sphere_n:.4} N, hemisphere {hemisphere_n:.4} N");
    assert!(sphere_n > 0.03 && (hemisphere_n / sphere_n - 1.0).abs() < 0.05, "{sphere_n} {hemisphere_n}");
}

#[test]
fn flat_end_is_stiffer_than_a_round_one() {
    let [flat, round] = ["flat", "hemisphere"].map(|shape| shaped(shape, 0.008, 129, "[0.001, 0.002, 0.004]").forces_n());
    // half-space: 2 a d against 4/3 sqrt(a) d^1.5: 4.2 times at 1 mm, 2.1 times at 4 mm
    for ((flat, round), depth_m) in flat.iter().zip(&round).zip([0.001, 0.002, 0.004_f64]) {
        let expected = 1.5 * (0.008 / depth_m).sqrt();
        assert!((flat / round / expected - 1.0).abs() < 0.5, "{depth_m} m: {flat} N, {round} N, expected {expected} times");
    }
}
