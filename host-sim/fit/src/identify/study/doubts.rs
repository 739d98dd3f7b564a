//! Doubts about a result: rows that contain more than the model, a press that is too deep, and a
//! modulus that no tissue has.

use super::super::fit::Fitted;
use super::super::record::Record;
use super::{Judged, Plan};

/// Range of the moduli of tissues and phantoms [Pa].
const MODULI_PA: [f64; 2] = [100.0, 10e6];
/// Depth of a press over the one to which its model is certain, above which it is doubted (1).
const DEEP: f64 = 1.05;
/// Mean difference of neighbouring rows from the model over the peak [%], and in standard errors,
/// above which the rows contain something that the model does not; and the share of the rows (1).
const MISFIT_PCT: f64 = 3.0;
const MISFIT_NOISES: f64 = 6.0;
const MISFIT_PARTS: usize = 40;

/// Largest mean difference of neighbouring rows over the peak [%], with a sentence on it, where it
/// is far above the noise: rows contain something that the model does not.
pub(super) fn misfit(record: &Record, test: &Judged) -> Option<(f64, String)> {
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let off_n: Vec<f64> = test.model_n.iter().zip(&record.force_n).map(|(model, force)| force - model).collect();
    let rows = (off_n.len() / MISFIT_PARTS).max(5);
    let means = off_n.windows(rows).map(|part| part.iter().sum::<f64>() / rows as f64);
    let (at, mean_n) = means.enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let (middle, pct) = (at + rows / 2, 100.0 * mean_n / peak_n);
    (pct.abs() > MISFIT_PCT && mean_n.abs() > MISFIT_NOISES * record.noise_n / (rows as f64).sqrt()).then(|| {
        let causes = match middle >= record.segments.retreat.start {
            true => "the tissue keeps a dent or sticks to the tip, relaxes otherwise than the hold shows, or the sensor drifts; hold for longer",
            false => "a slip, a puncture, a drift, or tests of different tissues; leave out what is not the tissue",
        };
        let sentence = format!(
            "{}: after {:.2} s, {:.2} mm deep, the force is {pct:+.0} % of its peak off the model: {causes}",
            record.name,
            record.time_s[middle] - record.time_s[0],
            (record.depth_m[middle] - test.contact_m) * 1e3,
        );
        (pct.abs(), sentence)
    })
}

/// Sentence on a press beyond the depth to which the model of the test is certain to hold: there an
/// error of 0.1 % of the force is one of 4 % of the modulus.
pub(super) fn deep(plan: &Plan, records: &[Record], fit: &Fitted) -> Option<String> {
    let depth_m = |(n, record): (usize, &Record)| record.contact_m + record.span_m() - fit.contact_m(n);
    let deepest_m = records.iter().enumerate().map(depth_m).fold(0.0, f64::max);
    let most_m = plan.most_depth_m();
    (deepest_m > DEEP * most_m).then(|| {
        let [deepest_mm, most_mm] = [deepest_m, most_m].map(|m| m * 1e3);
        format!("the press is {deepest_mm:.2} mm deep, where modulus and exponent may be off by more than their intervals: press to {most_mm:.2} mm")
    })
}

/// Refuses a modulus that is none of a tissue, and names the unit that would make it one.
pub(super) fn refuse_modulus(modulus_pa: f64, records: &[Record]) -> Result<(), String> {
    let [low, high] = MODULI_PA;
    if (low..=high).contains(&modulus_pa) {
        return Ok(());
    }
    let likely = match modulus_pa > (low * high).sqrt() {
        true => "the force is probably in mN where N is named, or the depth in mm where um is named, or in m where mm is",
        false => "the force is probably in N where mN is named, or the depth in um where mm is named, or in mm where m is",
    };
    Err(format!(
        "{}: the modulus would be {:.3} kPa, which no tissue has (0.1 kPa to 10 MPa): {likely}; correct the units in the names of the columns",
        records[0].name,
        modulus_pa * 1e-3
    ))
}
