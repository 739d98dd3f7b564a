//! Identification from records to report: elastic curves, fit, intervals, the limits of the data
//! with the measurement that would remove them, and the judgement of rows that were not fitted.

mod curves;
mod doubts;
mod plain;
mod thickness;

use curves::{contact_m, solved};
use doubts::{deep, misfit, refuse_modulus};
use plain::Plain;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
pub use thickness::identify_within;

use super::elastic::{STILL_FINER, Setup};
use super::fit::{Estimate, Fitted, Problem, Quantity, Settings};
use super::model::{Tissue, any_n};
use super::record::Record;
use super::slide::Slide;
use super::unsaid::{is_held, press_s, unsaid};

/// Rms error over the peak [%] above which the rows are no test of a tissue.
const MOST_RMS_PCT: f64 = 8.0;
/// Information from which the exponent is believed.
const LEAST_GAIN: f64 = 2.0;

/// Given data of the test.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Radius of the ball [m].
    pub ball_m: f64,
    /// Sides of the slab, the thickness last [m].
    pub block_m: [f64; 3],
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Number of tests that are left out; of a single test, half of its hold if not zero.
    pub leave_out: usize,
}

/// A test beside its model.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Depth of first contact [m].
    pub contact_m: f64,
    /// Depth of the deepest row below first contact [m].
    pub depth_m: f64,
    /// Rows that were fitted.
    pub fitted: usize,
    /// Forces of the model in all rows [N].
    pub model_n: Vec<f64>,
    /// Segments with the rms error over the peak [%], and whether the segment was fitted.
    pub segments: Vec<(&'static str, f64, bool)>,
    /// Depths at which the force vanishes on the way back: measured and by the model [m].
    pub lift_off_m: Option<[f64; 2]>,
}

/// Result of an identification.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Sides of the slab, the thickness last [m].
    pub block_m: [f64; 3],
    /// The 90 % interval of the thickness [m]; without width if the thickness was given.
    pub thickness_m: [f64; 2],
    /// Minus twice the logarithm of the likelihood for independent points, up to a constant of the
    /// data.
    pub left: f64,
    /// Number of points over that of independent ones (1).
    pub inflation: f64,
    /// Time by which the forces come after the depths [s], which the model contains.
    pub delay_s: f64,
    /// The most likely tissue.
    pub tissue: Tissue,
    /// Its constants with intervals: modulus, relaxed modulus, exponent, then share and time of
    /// each term.
    pub estimates: Vec<Estimate>,
    /// The best tissue without stiffening, and its rms error over the peak [%].
    pub plain: (Tissue, f64),
    /// Information gained by the exponent.
    pub exponent_gain: f64,
    /// Whether the tissue stiffens; a fit without stiffening then keeps the surface of this one.
    pub stiffens: bool,
    /// Information criterion of each number of terms, with stiffening.
    pub criteria: Vec<(usize, f64)>,
    /// Whether the zero of a force is taken on trust, as the tip is never seen in air.
    pub trusts_zero: bool,
    /// Sentences on what the data cannot say, and the measurement that would; first what they say
    /// and the model does not.
    pub unsaid: Vec<String>,
    /// Whether the rows of some test contain something that the model does not, or are too deep.
    pub misfits: bool,
    /// Slides of the tests that have one.
    pub slides: Vec<Slide>,
    /// Each test.
    pub tests: Vec<Judged>,
    /// Rms error over the peak in the fitted rows [%].
    pub rms_pct: f64,
}

impl Identified {
    /// Mean friction of the slides, with the ends of their intervals (1).
    #[must_use]
    pub fn friction(&self) -> Option<[f64; 3]> {
        let mean = |of: fn(&Slide) -> f64| self.slides.iter().map(of).sum::<f64>() / self.slides.len() as f64;
        let ends = self.slides.iter().map(|slide| slide.interval).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
        Some([mean(|slide| slide.friction), ends[0], ends[1]])
    }

    /// Adds a sentence on what one ball does not see.
    pub fn say_friction(&mut self, poisson_ratio: f64) {
        let friction = if self.slides.is_empty() { "friction (slide along the surface), " } else { "" };
        self.unsaid.push(format!("{friction}layers and another Poisson's ratio than {poisson_ratio} are not seen by one ball"));
    }

    /// The estimate of a quantity.
    #[must_use]
    pub fn of(&self, of: Quantity) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.of == of)
    }
}

fn unsolved() -> String {
    "no constants fit the forces: check the columns and their units".into()
}

/// Rms of a difference of forces [N] over the peak [N], in percent.
#[must_use]
pub fn rms_pct(model_n: &[f64], force_n: &[f64], peak_n: f64) -> f64 {
    let square: f64 = model_n.iter().zip(force_n).map(|(a, b)| (a - b).powi(2)).sum();
    100.0 * (square / force_n.len().max(1) as f64).sqrt() / peak_n
}

impl Plan {
    /// Deepest press for which finite elements of the test are certain to have an equilibrium [m].
    pub(super) fn most_depth_m(&self) -> f64 {
        (0.6 * self.block_m[2]).min(self.ball_m)
    }
}

/// Identifies the tissue of some tests.
///
/// # Errors
/// One sentence: a press is deeper than the finite elements find an equilibrium, or the modulus is
/// not that of a tissue.
pub fn identify(plan: &Plan, records: &[Record]) -> Result<Identified, String> {
    identify_with(plan, records, &[])
}

/// Identifies a tissue whose constants may also lie in some other intervals.
fn identify_with(plan: &Plan, records: &[Record], others: &[(Quantity, [f64; 2])]) -> Result<Identified, String> {
    let half = records.len() == 1 && plan.leave_out > 0;
    let kept = if half { 1 } else { records.len().saturating_sub(plan.leave_out).max(records.len().min(1)) };
    let setup = Setup { ball_m: plan.ball_m, block_m: plan.block_m, poisson_ratio: plan.poisson_ratio };
    let rows = |r: &Record| if half { r.segments.hold.start + r.segments.hold.len() / 2 } else { r.segments.hold.end };
    let fitted: Vec<usize> = records[..kept].iter().map(rows).collect();
    let mut records = records.to_vec();
    let (elastic, coarse) = solved(plan, &setup, &mut records, &fitted)?;
    let elastic = elastic.finer_at(&setup, coarse.tissue().stiffening_b).ok_or_else(|| {
        let name = &records[0].name;
        format!("{name}: finer elements of the test find no equilibrium: check --tip, --thickness and the unit of the depth")
    })?;
    let mut problem = Problem::new(&elastic, &records[..kept], fitted.clone(), Settings::default());
    let fit = problem.corrected(&coarse).ok_or_else(unsolved)?;
    let tissue = fit.tissue();
    refuse_modulus(tissue.youngs_modulus_pa, &records)?;
    let plain = Plain::of(&problem, &fit).ok_or_else(unsolved)?;
    let stiffens = plain.gain > LEAST_GAIN && tissue.stiffening_b > 0.0;
    let rms_pct = problem.rms_pct(&fit);
    if rms_pct > MOST_RMS_PCT {
        return Err(format!(
            "{}: the best model is {rms_pct:.0} % rms of the peak off, so this is no press of a ball into a slab, or depth and force are swapped; check columns, units and --tip",
            records[0].name
        ));
    }
    let mut estimates = estimates(&problem, &coarse, &fit);
    for (of, [low, high]) in others {
        estimates
            .iter_mut()
            .filter(|e| e.of == *of)
            .for_each(|e| e.interval = [e.interval[0].min(*low), e.interval[1].max(*high)]);
    }
    let curve = elastic.at(tissue.stiffening_b);
    let test = |(n, record): (usize, &Record)| {
        let contact_m = if n < kept { fit.contact_m(n) } else { contact_m(record, &tissue, &elastic, fit.delay_s()) };
        let depth_m = record.delayed_m(fit.delay_s(), contact_m);
        let mut model_n = any_n(&tissue, &curve, &record.time_s, &depth_m);
        let zero_n = if n < kept { problem.zero_n(&fit, n) } else { 0.0 };
        model_n.iter_mut().for_each(|force_n| *force_n += zero_n);
        judge(record, model_n, contact_m, fitted.get(n).copied().unwrap_or(0))
    };
    let tests: Vec<Judged> = records.iter().enumerate().map(test).collect();
    let records = &records[..kept];
    let misfit = records.iter().zip(&tests).filter_map(|(record, test)| misfit(record, test)).max_by(|a, b| a.0.total_cmp(&b.0));
    let doubts = [misfit.map(|(_, sentence)| sentence), deep(plan, records, &fit)];
    let misfits = doubts.iter().any(Option::is_some);
    let unsaid = unsaid(plan.most_depth_m(), records, &fit, &estimates);
    Ok(Identified {
        block_m: plan.block_m,
        thickness_m: [plan.block_m[2]; 2],
        left: problem.left(&fit),
        inflation: fit.inflation,
        delay_s: fit.delay_s(),
        stiffens,
        exponent_gain: plain.gain,
        plain: plain.told(stiffens),
        tissue,
        estimates,
        criteria: fit.criteria.clone(),
        trusts_zero: records.iter().any(|record| !record.starts_before),
        unsaid: doubts.into_iter().flatten().chain(unsaid).collect(),
        misfits,
        slides: Vec::new(),
        tests,
        rms_pct,
    })
}

/// All constants of a fit with their intervals, which contain what finer elements than those of the
/// second fit would change.
fn estimates(problem: &Problem, coarse: &Fitted, fit: &Fitted) -> Vec<Estimate> {
    let terms = (0..fit.terms()).flat_map(|k| [Quantity::Share(k), Quantity::Time(k)]);
    let wanted: Vec<_> = [Quantity::Modulus, Quantity::Relaxed, Quantity::Exponent].into_iter().chain(terms).collect();
    let mut estimates: Vec<Estimate> = wanted.into_par_iter().map(|of| problem.estimate(fit, of)).collect();
    // behind a term that is faster than the rows see, the instantaneous modulus has no upper end
    let unseen = |e: &Estimate| matches!(e.of, Quantity::Time(_)) && e.open && e.interval[1] < press_s(problem.records());
    estimates[0].open |= estimates.iter().any(unseen);
    estimates[1].open |= !is_held(problem.records());
    let wider = |e: Estimate| e.wider(STILL_FINER * problem.change(e.of, coarse, fit).abs());
    estimates.into_iter().map(wider).collect()
}

fn judge(record: &Record, model_n: Vec<f64>, contact_m: f64, fitted: usize) -> Judged {
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let s = &record.segments;
    let halves = if fitted > s.hold.start && fitted < s.hold.end {
        vec![s.hold.start..fitted, fitted..s.hold.end]
    } else {
        vec![s.hold.clone()]
    };
    let named = std::iter::once(("press", s.press.clone()))
        .chain(halves.into_iter().enumerate().map(|(n, rows)| (["hold", "rest of the hold"][n], rows)))
        .chain([("retreat", s.retreat.clone())]);
    let segments = named
        .filter(|(_, rows)| rows.len() > 2)
        .map(|(name, rows)| (name, rms_pct(&model_n[rows.clone()], &record.force_n[rows.clone()], peak_n), rows.end <= fitted))
        .collect();
    let lifts = |force_n: &[f64]| {
        let n = s.retreat.clone().find(|n| force_n[*n] < 0.01 * peak_n + record.noise_n)?;
        Some(record.depth_m[n] - contact_m)
    };
    let lift_off_m = lifts(&record.force_n).zip(lifts(&model_n)).map(|(a, b)| [a, b]);
    let depth_m = record.depth_m.iter().copied().fold(f64::MIN, f64::max) - contact_m;
    Judged { contact_m, depth_m, fitted, model_n, segments, lift_off_m }
}
