//! A law contains the stiffening of the tissue that it was fitted to, and says which.

use palpate_tests::palpate_command::{Desk, palpate};
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

fn fitted(desk: &Desk, more: &[&str]) {
    let line = ["fit", "--law", "--scene", "block", "--out", "law", "--tolerance-pct", "5"];
    let found = palpate(SCRATCH, desk.folder(), &[&line[..], more].concat());
    assert_eq!(found.code, Some(0), "{}", found.stderr);
}

fn press(desk: &Desk, sets: &[&str]) -> (Option<i32>, String) {
    let patch = ["press", "--scene", "block", "--set", "solver.patch=law/block-law.patch", "--out", "pressed"];
    let line: Vec<&str> = patch.into_iter().chain(sets.iter().flat_map(|set| ["--set", set])).collect();
    let found = palpate(SCRATCH, desk.folder(), &line);
    (found.code, found.stderr)
}

/// The stored forces are those of a finer mesh, at places that the fit does not see.
#[test]
#[ignore = "long: finite elements of a stiffening block, a minute"]
fn a_law_of_stiffening_tissue_is_near_finite_elements() {
    let stored: Value = serde_json::from_str(include_str!("../../data/stiffening_reference.json")).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let list = |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(number).collect() };
    for b in [3.0, 20.0] {
        let (desk, own_b) = (Desk::default(), format!("tissue.stiffening_b={b:?}"));
        fitted(&desk, &["--set", &own_b]);
        for press_at in stored["press"].as_array().unwrap().iter().filter(|at| number(&at["b"]) == b && number(&at["x_m"]) < 0.01)
        {
            let x = format!("probe.position_m=[{:?},0.0]", number(&press_at["x_m"]));
            let depths_m: Vec<f64> = list(&press_at["depth_m"]).into_iter().filter(|m| *m < 4.1e-3).collect();
            let holds = format!("drive.holds_m={depths_m:?}");
            let (code, why) = press(&desk, &[&own_b, &x, &holds]);
            assert_eq!(code, Some(0), "{why}");
            let summary: Value =
                serde_json::from_slice(&std::fs::read(desk.folder().join("pressed/summary.json")).unwrap()).unwrap();
            for (hold, force_m2) in summary["holds"].as_array().unwrap().iter().zip(list(&press_at["force_m2"])) {
                let off = number(&hold["force_n"]) / (force_m2 * 3500.0) - 1.0;
                println!("b = {b}, {x}, {} m: {:+.2} %", hold["target"], 100.0 * off);
                assert!(off.abs() < 0.015, "{off}");
            }
        }
    }
}

#[test]
fn a_law_says_which_stiffening_it_contains() {
    let desk = Desk::default();
    fitted(&desk, &[]);
    let record = desk.folder().join("law/block-law.patch.json");
    let text = std::fs::read_to_string(&record).unwrap();
    let stiffens = text.replacen("\"poisson_ratio\"", "\"stiffening_b\": 0.3, \"poisson_ratio\"", 1);
    assert_ne!(stiffens, text);
    std::fs::write(&record, stiffens).unwrap();
    let short = "drive.holds_m=[0.001]";
    assert_eq!(press(&desk, &["tissue.stiffening_b=0.3", short]), press(&desk, &[short]));
    let (code, why) = press(&desk, &["tissue.stiffening_b=0.5", short]);
    assert_eq!(code, Some(2));
    assert!(
        why.contains("tissue.stiffening_b = 0.5, but law/block-law.patch holds a law of tissue with 0.3: leave it out"),
        "{why}"
    );
}
