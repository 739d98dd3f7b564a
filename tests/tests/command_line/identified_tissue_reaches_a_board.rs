//! `identify --fit` goes from the guide's recording to a law for a board, and judges that against
//! the recording.

use palpate_tests::palpate_command::{Desk, palpate, repository};
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
/// Largest difference of a segment, in percent of the peak: the phantom's noise is 1 %.
const MOST_RMS_PCT: f64 = 2.5;

#[test]
#[ignore = "long: a minute of finite elements"]
fn press_hold_and_retreat_of_the_law_are_those_of_the_recording() {
    let desk = Desk::default();
    let phantom = repository().join("host-sim/book/src/guide/phantom.csv");
    let phantom = phantom.display().to_string();
    let line =
        ["identify", &phantom, "--tip", "sphere:4mm", "--thickness", "10mm", "--block", "50x50mm", "--out", "out", "--fit"];
    let outcome = palpate(SCRATCH, desk.folder(), &line);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let summary = std::fs::read(desk.folder().join("out/summary.json")).unwrap();
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    let segments = summary["patch_rms_pct"][0].as_array().unwrap();
    println!("press, hold and retreat: {segments:?} % rms of the peak");
    assert!(segments.len() == 3 && segments.iter().all(|pct| pct.as_f64().is_some_and(|pct| pct < MOST_RMS_PCT)), "{segments:?}");
}
