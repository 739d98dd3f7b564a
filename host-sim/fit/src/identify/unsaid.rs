//! Sentences on what the data cannot say, with the measurement that would.

use super::fit::{Estimate, Fitted, Quantity};
use super::record::Record;

/// Depth over the deepest possible from which pressing deeper is no remedy (1).
const DEEP: f64 = 0.9;
/// Correlation from which two quantities trade off (1).
const TRADED: f64 = 0.85;

/// Shortest hold that shows relaxation [s].
const LEAST_HOLD_S: f64 = 1.0;

/// Whether some test is held for so long that relaxation is seen.
pub fn is_held(records: &[Record]) -> bool {
    records.iter().any(|record| record.hold_s() >= LEAST_HOLD_S)
}

/// Duration of the fastest press [s].
pub fn press_s(records: &[Record]) -> f64 {
    records.iter().map(|r| r.span_m() / r.speed_m_per_s()).fold(f64::MAX, f64::min)
}

/// Sentences on a fit, with those on values that it does not tell first. `most_m` is the depth
/// [m] up to which the model of the test is certain to hold.
pub fn unsaid(most_m: f64, records: &[Record], fit: &Fitted, estimates: &[Estimate]) -> Vec<String> {
    let mut said = Vec::new();
    let deepest_m = records.iter().map(Record::span_m).fold(0.0, f64::max);
    let hold_s = records.iter().map(Record::hold_s).fold(0.0, f64::max);
    let press_s = press_s(records);
    let contact = |a: Quantity| (0..records.len()).any(|n| fit.correlation(a, Quantity::Contact(n)).abs() > TRADED);
    for e in estimates.iter().filter(|e| !e.told()) {
        let [low, high] = e.interval;
        match e.of {
            Quantity::Modulus => {
                let with = match () {
                    () if contact(e.of) && !records.iter().all(|r| r.starts_before) => "it trades off with first contact: begin in air, and record at a higher rate".into(),
                    () if deepest_m < DEEP * most_m && fit.correlation(e.of, Quantity::Exponent).abs() > TRADED => "it trades off with the exponent: press deeper, at a higher rate of rows".into(),
                    () if (0..fit.terms()).any(|k| fit.correlation(e.of, Quantity::Share(k)).abs() > TRADED) => format!("it trades off with the fast relaxation: press faster than in {:.2} s", 0.3 * press_s),
                    () => "repeat the test, and leave the tests in one folder".to_owned(),
                };
                let above = if e.open { " or above" } else { "" };
                said.push(format!("the modulus lies between {:.2} and {:.2} kPa{above}; {with}", low * 1e-3, high * 1e-3));
            }
            Quantity::Exponent => {
                let remedy = match deepest_m < DEEP * most_m {
                    true => format!("press deeper than {:.1} mm ({:.1} mm is the limit here) or repeat the test", deepest_m * 1e3, most_m * 1e3),
                    false => "repeat the test, and leave the tests in one folder".to_owned(),
                };
                said.push(format!("the exponent b lies between {low:.2} and {high:.2}{}; {remedy}", if e.open { " or above" } else { "" }));
            }
            Quantity::Share(k) => said.push(format!("the share of relaxation term {} lies between {low:.2} and {high:.2}; hold for {:.0} s and press faster", k + 1, (3.0 * hold_s).max(10.0))),
            Quantity::Time(k) if e.open && high < press_s => said.push(format!(
                "relaxation term {} is faster than this test sees, or force and depth are not recorded at the same time: compare their clocks, and press faster than in {:.2} s",
                k + 1,
                0.3 * press_s
            )),
            Quantity::Time(k) if high < press_s => said.push(format!("the time of relaxation term {} lies between {low:.2} and {high:.2} s; press faster than in {:.2} s", k + 1, 0.3 * press_s)),
            Quantity::Time(k) => said.push(format!("the time of relaxation term {} lies between {low:.2} and {high:.2} s; hold for {:.0} s", k + 1, (3.0 * high).min(10.0 * hold_s.max(1.0)))),
            _ => {}
        }
    }
    if fit.delay_s() != 0.0 {
        said.push(format!(
            "the force comes {:.0} ms {} the depth, as behind a filter or by another clock: this is taken out; record both at the same time",
            1e3 * fit.delay_s().abs(),
            if fit.delay_s() > 0.0 { "after" } else { "before" }
        ));
    }
    if !is_held(records) {
        said.push(format!(
            "relaxation is not seen in a hold of {hold_s:.1} s, so the modulus is that of this speed; hold for ten seconds"
        ));
    } else {
        said.push(format!(
            "relaxation slower than {:.0} s or faster than {:.3} s is not seen: the modulus is that of a press of {press_s:.2} s",
            3.0 * hold_s,
            press_s / 20.0
        ));
    }
    said.extend(
        records
            .iter()
            .find(|r| !r.starts_before)
            .map(|r| format!("the zero of the force is taken on trust, as {}", r.why_no_air())),
    );
    said
}
