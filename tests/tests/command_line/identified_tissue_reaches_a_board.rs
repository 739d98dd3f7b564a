//! `identify --fit` goes from the guide's recording to a law for a board, and judges that against
//! the recording.

use palpate_tests::palpate_command::{Desk, palpate};
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const PHANTOM: &str = include_str!("../../../host-sim/book/src/guide/phantom.csv");
/// Largest difference of a segment, in percent of the peak: the phantom's noise is 1 %.
const MOST_RMS_PCT: f64 = 2.5;

/// The guide's recording from some depth on [mm], with its times divided by a number.
fn recording(from_mm: f64, faster: f64) -> String {
    let row = |line: &str| -> Option<[f64; 3]> {
        let cells: Vec<f64> = line.split(',').map_while(|cell| cell.parse().ok()).collect();
        cells.try_into().ok()
    };
    let rows = PHANTOM.lines().filter_map(row).skip_while(|[_, depth_mm, _]| *depth_mm < from_mm);
    let rows = rows.map(|[t, d, f]| format!("{:.6},{d},{f}\n", t / faster));
    rows.fold("time_s,depth_mm,force_mN\n".to_owned(), |text, row| text + &row)
}

/// The tip is in air first, or already in the tissue and so fast that rows come within a tick.
#[test]
#[ignore = "long: two minutes of finite elements"]
fn press_hold_and_retreat_of_the_law_are_those_of_the_recording() {
    for (name, from_mm, faster) in [("as it is", f64::MIN, 1.0), ("in contact, fast", 1.2, 30.0)] {
        let desk = Desk::default();
        desk.put("test.csv", recording(from_mm, faster));
        let options = ["--tip", "sphere:4mm", "--thickness", "10mm", "--block", "50x50mm", "--out", "out", "--fit"];
        let outcome = palpate(SCRATCH, desk.folder(), &[&["identify", "test.csv"], &options[..]].concat());
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        let summary = std::fs::read(desk.folder().join("out/summary.json")).unwrap();
        let summary: Value = serde_json::from_slice(&summary).unwrap();
        let segments = summary["patch_rms_pct"][0].as_array().unwrap();
        println!("{name}: press, hold and retreat {segments:?} % rms of the peak");
        let near = |pct: &Value| pct.as_f64().is_some_and(|pct| pct < MOST_RMS_PCT);
        assert!(segments.len() == 3 && segments.iter().all(near), "{name}: {segments:?}");
    }
}
