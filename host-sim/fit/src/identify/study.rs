//! Identification from records to report: elastic curves, fit, intervals, the limits of the data
//! with the measurement that would remove them, and the judgement of rows that were not fitted.

use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use super::elastic::{Elastic, STILL_FINER, Setup};
use super::fit::{CHI_90, Estimate, Fitted, Problem, Quantity, Settings};
use super::model::{Forces, Tissue, any_n};
use super::record::{CONTACT_RANGE, Record};
use super::slide::Slide;
use super::unsaid::{press_s, unsaid};

/// Range of the moduli of tissues and phantoms [Pa].
const MODULI_PA: [f64; 2] = [100.0, 10e6];
/// Largest number of times that first contact is moved.
const MOST_TRIES: usize = 4;
/// Number of thicknesses of a range that are tried, and how often the best one's neighbourhood is
/// halved.
const THICKNESSES: usize = 4;
const HALVINGS: usize = 3;
/// Depth of a press over the one to which its model is certain, above which it is doubted (1).
const DEEP: f64 = 1.05;
/// Half width of the interval of a thickness, in its logarithm, up to which it is known (1).
const TOLD_THICKNESS: f64 = 0.2;
/// Mean difference of neighbouring rows from the model over the peak [%], and in standard errors,
/// above which the rows contain something that the model does not; and the share of the rows (1).
const MISFIT_PCT: f64 = 3.0;
const MISFIT_NOISES: f64 = 6.0;
const MISFIT_PARTS: usize = 40;
/// Rms error over the peak [%] above which the rows are no test of a tissue.
const MOST_RMS_PCT: f64 = 8.0;
/// Number of times that the range of a left-out test's contact is narrowed by a third.
const NARROWINGS: usize = 24;
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
    let half = records.len() == 1 && plan.leave_out > 0;
    let kept = if half { 1 } else { records.len().saturating_sub(plan.leave_out).max(records.len().min(1)) };
    let setup = Setup { ball_m: plan.ball_m, block_m: plan.block_m, poisson_ratio: plan.poisson_ratio };
    let rows = |r: &Record| if half { r.segments.hold.start + r.segments.hold.len() / 2 } else { r.segments.hold.end };
    let fitted: Vec<usize> = records[..kept].iter().map(rows).collect();
    let unsolved = || "no constants fit the forces: check the columns and their units".to_owned();
    let mut records = records.to_vec();
    let (mut tries, mut was_short) = (0, false);
    let (elastic, coarse) = loop {
        records.iter_mut().for_each(|r| r.limit_depth(plan.most_depth_m().max(r.least_depth_m())));
        let asked_m = deepest_m(&records);
        let elastic = Elastic::solve(&setup, asked_m).ok_or_else(|| too_deep(&setup, &records, 0.0))?;
        let reached_m = elastic.deepest_m();
        // contact may have been guessed too early; at the fitted one, elements must reach it
        let is_short = reached_m < asked_m;
        if is_short && was_short {
            return Err(too_deep(&setup, &records, reached_m));
        }
        records.iter_mut().for_each(|record| record.limit_depth(reached_m));
        let mut problem = Problem::new(&elastic, &records[..kept], fitted.clone(), Settings::default());
        let fit = problem.solve().ok_or_else(unsolved)?;
        let delayed = problem.delayed(&fit);
        let left_out = records[kept..].iter().map(|record| contact_m(record, &fit.tissue(), &elastic, fit.delay_s()));
        let to_m: Vec<f64> = (0..kept).map(|n| fit.contact_m(n)).chain(left_out).collect();
        (tries, was_short) = (tries + 1, was_short | is_short);
        // where contact was found at the edge of its range, it is somewhere else
        let moves = |(record, to_m): (&mut Record, f64)| record.move_contact(to_m, is_short);
        let moved = (is_short || tries <= MOST_TRIES) && records.iter_mut().zip(to_m).map(moves).fold(false, |a, b| a | b);
        if !moved {
            break (elastic, delayed.unwrap_or(fit));
        }
    };
    let elastic = elastic.finer_at(&setup, coarse.tissue().stiffening_b).ok_or_else(|| {
        let name = &records[0].name;
        format!("{name}: finer elements of the test find no equilibrium: check --tip, --thickness and the unit of the depth")
    })?;
    let records = &records[..];
    let mut problem = Problem::new(&elastic, &records[..kept], fitted.clone(), Settings::default());
    let fit = problem.corrected(&coarse).ok_or_else(unsolved)?;
    let tissue = fit.tissue();
    refuse_modulus(tissue.youngs_modulus_pa, records)?;
    let mut plain_problem = Problem::new(
        &elastic,
        &records[..kept],
        fitted.clone(),
        Settings { stiffens: false, delay: fit.delay_s() != 0.0, ..Settings::default() },
    );
    let plain = plain_problem.solve().ok_or_else(unsolved)?;
    let mut wanted = vec![Quantity::Modulus, Quantity::Relaxed, Quantity::Exponent];
    wanted.extend((0..fit.terms()).flat_map(|k| [Quantity::Share(k), Quantity::Time(k)]));
    let mut estimates: Vec<Estimate> = wanted.into_par_iter().map(|of| problem.estimate(&fit, of)).collect();
    // behind a term that is faster than the rows see, the instantaneous modulus has no upper end
    let unseen = |e: &Estimate| matches!(e.of, Quantity::Time(_)) && e.open && e.interval[1] < press_s(&records[..kept]);
    estimates[0].open |= estimates.iter().any(unseen);
    estimates.iter_mut().for_each(|e| *e = e.wider(STILL_FINER * problem.change(e.of, &coarse, &fit).abs()));
    let curve = elastic.at(tissue.stiffening_b);
    let mut tests = Vec::new();
    for (n, record) in records.iter().enumerate() {
        let contact_m = if n < kept { fit.contact_m(n) } else { contact_m(record, &tissue, &elastic, fit.delay_s()) };
        let depth_m = record.delayed_m(fit.delay_s(), contact_m);
        let mut model_n = any_n(&tissue, &curve, &record.time_s, &depth_m);
        let zero_n = if n < kept { problem.zero_n(&fit, n) } else { 0.0 };
        model_n.iter_mut().for_each(|force_n| *force_n += zero_n);
        tests.push(judge(record, model_n, contact_m, fitted.get(n).copied().unwrap_or(0)));
    }
    let error = |problem: &Problem, fit: &Fitted| {
        let tissue = fit.tissue();
        let of = |n: usize| {
            let r = &records[n];
            let depth_m = r.delayed_m(fit.delay_s(), fit.contact_m(n));
            let mut model = any_n(&tissue, &elastic.at(tissue.stiffening_b), &r.time_s[..fitted[n]], &depth_m[..fitted[n]]);
            model.iter_mut().for_each(|force_n| *force_n += problem.zero_n(fit, n));
            rms_pct(&model, &r.force_n[..fitted[n]], r.force_n.iter().copied().fold(0.0, f64::max)).powi(2)
        };
        ((0..kept).map(of).sum::<f64>() / kept as f64).sqrt()
    };
    // all models are compared with the same noise and the same number of independent points
    let independent = fitted.iter().sum::<usize>() as f64 / fit.inflation;
    let criterion = |rms_pct: f64, terms: usize| 2.0 * independent * rms_pct.ln() + 4.0 * terms as f64;
    let rms_pct = error(&problem, &fit);
    // to seem as soft at first, tissue without stiffening would begin below its surface
    let mut at_surface = records[..kept].to_vec();
    at_surface.iter_mut().enumerate().for_each(|(n, record)| record.contact_m = fit.contact_m(n));
    let settings = Settings { stiffens: false, contact: false, delay: fit.delay_s() != 0.0, ..Settings::default() };
    let mut held_problem = Problem::new(&elastic, &at_surface, fitted.clone(), settings);
    let held = held_problem.solve().ok_or_else(unsolved)?;
    let held = (held.tissue(), error(&held_problem, &held));
    let free = [Some(plain), plain_problem.without_stiffening(&fit)].into_iter().flatten();
    let best = free.map(|plain| (plain.tissue(), error(&plain_problem, &plain))).chain([held.clone()]);
    let of = |(tissue, rms_pct): &(Tissue, f64)| criterion(*rms_pct, tissue.terms.len());
    let best = best.min_by(|a, b| of(a).total_cmp(&of(b))).ok_or_else(unsolved)?;
    let exponent_gain = of(&best) - criterion(rms_pct, fit.terms()) - 2.0;
    let stiffens = exponent_gain > LEAST_GAIN && tissue.stiffening_b > 0.0;
    let plain = if stiffens { held } else { best };
    if rms_pct > MOST_RMS_PCT {
        return Err(format!(
            "{}: the best model is {rms_pct:.0} % rms of the peak off, so this is no press of a ball into a slab, or depth and force are swapped; check columns, units and --tip",
            records[0].name
        ));
    }
    let judged = records.iter().zip(&tests).take(kept);
    let worst = judged.filter_map(|(record, test)| misfit(record, test)).max_by(|a, b| a.0.total_cmp(&b.0));
    let mut unsaid = unsaid(plan.most_depth_m(), &records[..kept], &fit, &estimates);
    let doubts = [worst.map(|(_, sentence)| sentence), deep(plan, &records[..kept], &fit)];
    let misfits = doubts.iter().any(Option::is_some);
    unsaid.splice(0..0, doubts.into_iter().flatten());
    Ok(Identified {
        misfits,
        block_m: plan.block_m,
        thickness_m: [plan.block_m[2]; 2],
        left: problem.left(&fit),
        inflation: fit.inflation,
        delay_s: fit.delay_s(),
        rms_pct,
        plain,
        exponent_gain,
        stiffens,
        criteria: fit.criteria.clone(),
        tissue,
        estimates,
        trusts_zero: records[..kept].iter().any(|record| !record.starts_before),
        unsaid,
        slides: Vec::new(),
        tests,
    })
}

/// First contact of a test that was left out [m], at which a tissue gives its press best: that is
/// no constant of the tissue.
fn contact_m(record: &Record, tissue: &Tissue, elastic: &Elastic, delay_s: f64) -> f64 {
    let (mut record, rows) = (record.clone(), record.segments.press.end);
    for _ in 0..MOST_TRIES {
        let mut forces = Forces::default();
        let mut off = |contact_m: f64| -> f64 {
            let model_n = forces.growing_n(elastic, tissue, (&record, rows), contact_m, delay_s);
            model_n.iter().zip(&record.force_n).map(|(model, measured)| (model - measured).powi(2)).sum()
        };
        let [mut low, mut high] = record.contact_range_m;
        for _ in 0..NARROWINGS {
            let [a, b] = [2.0, 1.0].map(|share| (share * low + (3.0 - share) * high) / 3.0);
            if off(a) < off(b) { high = b } else { low = a }
        }
        // as in the fit, contact that is found at the edge of its range is somewhere else
        record.contact_m = 0.5 * (low + high);
        if !record.move_contact(record.contact_m, false) {
            break;
        }
        record.limit_depth(elastic.deepest_m());
    }
    record.contact_m
}

/// Identifies a tissue together with its thickness, of which only a range [m] is known.
///
/// # Errors
/// As [`identify`]; or only the combination of thickness, modulus and exponent is known.
pub fn identify_within(plan: &Plan, range_m: [f64; 2], records: &[Record]) -> Result<Identified, String> {
    let at = |ln: f64| {
        let [x, y, _] = plan.block_m;
        identify(&Plan { block_m: [x, y, ln.exp()], ..*plan }, records).map(|found| (ln, found))
    };
    let [low, high] = range_m.map(f64::ln);
    let even = (0..THICKNESSES).map(|n| low + (high - low) * n as f64 / (THICKNESSES - 1) as f64);
    // a slab that is too thin for the depth has no equilibrium
    let mut unsolved = String::new();
    let mut tried: Vec<(f64, Identified)> = even.filter_map(|ln| at(ln).map_err(|why| unsolved = why).ok()).collect();
    if tried.is_empty() {
        return Err(unsolved);
    }
    for _ in 0..HALVINGS {
        let (best, count) = (likely(&tried).1, tried.len());
        if !combined(&tried, 0).is_empty() {
            break;
        }
        for n in [best + 1, best].into_iter().filter(|n| (1..count).contains(n)) {
            let between = at(tried[n - 1].0.midpoint(tried[n].0))?;
            tried.insert(n, between);
        }
    }
    let why = combined(&tried, 1);
    if !why.is_empty() {
        return Err(format!("{}: {why}", records[0].name));
    }
    let ([first, last], best) = likely(&tried);
    // the end of the interval lies between a likely thickness and its unlikely neighbour
    let thickness_m = [tried[first.saturating_sub(1)].0, tried[(last + 1).min(tried.len() - 1)].0].map(f64::exp);
    let of = |of: Quantity| {
        let all = tried[first..=last].iter().filter_map(|(_, found)| Some(found.of(of)?.interval));
        all.fold([f64::MAX, f64::MIN], |[a, b], [c, d]| [a.min(c), b.max(d)])
    };
    let wider = [Quantity::Modulus, Quantity::Relaxed, Quantity::Exponent].map(|quantity| (quantity, of(quantity)));
    let mut found = tried.swap_remove(best).1;
    found.thickness_m = thickness_m;
    for (quantity, interval) in wider {
        found.estimates.iter_mut().filter(|e| e.of == quantity).for_each(|e| e.interval = interval);
    }
    let [low_mm, high_mm] = thickness_m.map(|m| m * 1e3);
    found
        .unsaid
        .insert(0, format!("the thickness is fitted, between {low_mm:.2} and {high_mm:.2} mm; state it with --thickness"));
    Ok(found)
}

/// First and last of the thicknesses that are likely at 90 %, and the most likely one.
fn likely(tried: &[(f64, Identified)]) -> ([usize; 2], usize) {
    let best = (0..tried.len()).min_by(|a, b| tried[*a].1.left.total_cmp(&tried[*b].1.left)).unwrap_or(0);
    let near = |n: &usize| tried[*n].1.left < tried[best].1.left + CHI_90 * tried[best].1.inflation;
    ([(0..tried.len()).find(near).unwrap_or(best), (0..tried.len()).rev().find(near).unwrap_or(best)], best)
}

/// Sentence on likely thicknesses, with some neighbours, that are too different to be called known;
/// empty if there is none.
fn combined(tried: &[(f64, Identified)], neighbours: usize) -> String {
    let ([first, last], _) = likely(tried);
    let (first, last) = (first.saturating_sub(neighbours), (last + neighbours).min(tried.len() - 1));
    if tried[last].0 - tried[first].0 <= 2.0 * TOLD_THICKNESS {
        return String::new();
    }
    let [from, to] = [first, last].map(|n| {
        let (ln, Identified { tissue, .. }) = &tried[n];
        format!("{:.1} mm with {:.2} kPa and b = {:.2}", ln.exp() * 1e3, tissue.youngs_modulus_pa * 1e-3, tissue.stiffening_b)
    });
    format!(
        "only the combination of thickness, modulus and exponent is known, from {from} to {to}: measure the thickness and state it with --thickness, or press deeper"
    )
}

/// Depth below first contact that the records may reach [m].
fn deepest_m(records: &[Record]) -> f64 {
    let deepest = |r: &Record| r.contact_m + r.span_m() - r.contact_range_m[0];
    records.iter().map(deepest).fold(0.0, f64::max)
}

/// Sentence on presses that go deeper than elements of the test find an equilibrium [m].
fn too_deep(setup: &Setup, records: &[Record], reached_m: f64) -> String {
    let deepest = records.iter().max_by(|a, b| a.span_m().total_cmp(&b.span_m()));
    format!(
        "{}: the tip goes {:.2} mm deep, and finite elements of a slab of {:.2} mm under a ball of {:.2} mm answer presses to {:.2} mm: press no deeper, or check --tip, --thickness and the unit of the depth",
        deepest.map_or("", |record| record.name.as_str()),
        deepest.map_or(0.0, Record::span_m) * 1e3,
        setup.block_m[2] * 1e3,
        setup.ball_m * 1e3,
        reached_m * 1e3 / (1.0 + CONTACT_RANGE),
    )
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

/// Largest mean difference of neighbouring rows over the peak [%], with a sentence on it, where it
/// is far above the noise: rows contain something that the model does not.
fn misfit(record: &Record, test: &Judged) -> Option<(f64, String)> {
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let off_n: Vec<f64> = test.model_n[..test.fitted].iter().zip(&record.force_n).map(|(model, force)| force - model).collect();
    let rows = (off_n.len() / MISFIT_PARTS).max(5);
    let means = off_n.windows(rows).map(|part| part.iter().sum::<f64>() / rows as f64);
    let (at, mean_n) = means.enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let (middle, pct) = (at + rows / 2, 100.0 * mean_n / peak_n);
    (pct.abs() > MISFIT_PCT && mean_n.abs() > MISFIT_NOISES * record.noise_n / (rows as f64).sqrt()).then(|| {
        let sentence = format!(
            "{}: after {:.2} s, {:.2} mm deep, the force is {pct:+.0} % of its peak off the model: a slip, a puncture, a drift, or tests of different tissues; leave out what is not the tissue",
            record.name,
            record.time_s[middle] - record.time_s[0],
            (record.depth_m[middle] - test.contact_m) * 1e3,
        );
        (pct.abs(), sentence)
    })
}

/// Sentence on a press beyond the depth to which the model of the test is certain to hold: there an
/// error of 0.1 % of the force is one of 4 % of the modulus.
fn deep(plan: &Plan, records: &[Record], fit: &Fitted) -> Option<String> {
    let depth_m = |(n, record): (usize, &Record)| record.contact_m + record.span_m() - fit.contact_m(n);
    let deepest_m = records.iter().enumerate().map(depth_m).fold(0.0, f64::max);
    let most_m = plan.most_depth_m();
    (deepest_m > DEEP * most_m).then(|| {
        let [deepest_mm, most_mm] = [deepest_m, most_m].map(|m| m * 1e3);
        format!("the press is {deepest_mm:.2} mm deep, where modulus and exponent may be off by more than their intervals: press to {most_mm:.2} mm")
    })
}

/// Refuses a modulus that is none of a tissue, and names the unit that would make it one.
fn refuse_modulus(modulus_pa: f64, records: &[Record]) -> Result<(), String> {
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
