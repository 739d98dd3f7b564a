//! Least squares of the model over the recorded forces, with a robust loss (pseudo-Huber), by the
//! Levenberg-Marquardt method of the crate `rmpfit`; the number of Prony terms by the corrected
//! information criterion; intervals by the profile likelihood.

mod profile;

use std::ops::Range;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use rmpfit::{MPConfig, MPFitter, MPPar, MPResult};

use super::elastic::Elastic;
pub use super::estimate::{Estimate, Quantity};
use super::model::{Forces, Tissue};
use super::record::{Record, quantile, repeats};

/// Residual, in standard deviations, from which the loss grows linearly.
const ROBUST: f64 = 2.5;
/// Least deviation of the noise, over the peak, in the first round (1).
const START_NOISE: f64 = 0.02;
/// Largest number of Prony terms, which is that of a scene.
pub const MOST_TERMS: usize = 3;
/// Largest share of what is left after the faster terms that one term may relax (1).
const MOST_SHARE: f64 = 0.97;
/// Largest zero of the force, in deviations of its noise.
const MOST_ZERO: f64 = 5.0;
/// Quantile of chi squared with one degree of freedom at 90 %.
pub const CHI_90: f64 = 2.706;
/// Difference of the criterion up to which another number of terms is about as likely.
const RIVAL: f64 = 2.0;
/// Largest delay of the forces over the duration of a press (1), and what it must gain, in squared
/// standard errors.
const MOST_DELAY: f64 = 0.2;
const DELAY_GAIN: f64 = 25.0;
/// Step of derivatives over the range of an unknown (1), about the root of the rounding.
const STEP: f64 = 1e-8;
/// Settings of a fit.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Numbers of Prony terms that are tried.
    pub terms: Range<usize>,
    /// Whether the exponent is fitted; it is zero otherwise.
    pub stiffens: bool,
    /// Whether the depth of first contact is fitted.
    pub contact: bool,
    /// Range of the times of Prony terms [s]; that of the records if absent.
    pub times_s: Option<[f64; 2]>,
    /// Whether the delay of the forces against the depths is fitted; it is zero otherwise.
    pub delay: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { terms: 0..MOST_TERMS + 1, stiffens: true, contact: true, times_s: None, delay: false }
    }
}

/// Records with the rows to fit, and the elastic curves of the test.
pub struct Problem<'a> {
    elastic: &'a Elastic,
    records: &'a [Record],
    /// Rows of each record that are fitted.
    rows: Vec<usize>,
    sigma_n: Vec<f64>,
    settings: Settings,
    press_s: f64,
    times_s: [f64; 2],
}

/// A fitted set of constants.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// ln E, ln(1 + b), then for each term the part of the rest that relaxes and ln time, then the
    /// depth of contact of each record, then the zero of its force over the noise, and the delay.
    p: Vec<f64>,
    terms: usize,
    chi: f64,
    /// Standard deviation of each record's noise [N].
    sigma_n: Vec<f64>,
    /// Corrected information criterion of every number of terms tried, with that number.
    pub criteria: Vec<(usize, f64)>,
    sd: Vec<f64>,
    /// Correlation of the unknowns.
    correlation: Vec<f64>,
    /// Number of points over that of independent ones (1).
    pub inflation: f64,
    /// Fits with other numbers of terms that are about as likely.
    rivals: Vec<Fitted>,
}

struct Least<'a> {
    problem: &'a Problem<'a>,
    terms: usize,
    held: Option<(Quantity, f64, f64)>,
    limits: Vec<MPPar>,
    config: MPConfig,
    forces: Vec<Forces>,
}

impl MPFitter for Least<'_> {
    fn eval(&mut self, p: &[f64], out: &mut [f64]) -> MPResult<()> {
        self.problem.residuals(p, self.terms, &mut self.forces, out);
        if let (Some((of, at, weight)), Some(last)) = (self.held, out.last_mut()) {
            *last = (self.problem.inner(p, self.terms, of) - at) * weight;
        }
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.problem.points() + usize::from(self.held.is_some())
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.limits
    }
}

fn shares(p: &[f64], terms: usize) -> Vec<(f64, f64)> {
    let mut left = 1.0;
    let of = |k: usize| {
        let share = left * p[2 + 2 * k];
        left -= share;
        (share, p[3 + 2 * k].exp())
    };
    (0..terms).map(of).collect()
}

impl<'a> Problem<'a> {
    /// Prepares a fit of these rows of each record.
    #[must_use]
    pub fn new(elastic: &'a Elastic, records: &'a [Record], rows: Vec<usize>, settings: Settings) -> Self {
        let span = |record: &Record, rows: usize| record.time_s[rows - 1] - record.time_s[0];
        let longest_s = records.iter().zip(&rows).map(|(r, n)| span(r, *n)).fold(0.0, f64::max);
        // a hold's points are ever sparser
        let press = |r: &Record| r.segments.press.end.clamp(2, r.time_s.len());
        let step_s = records.iter().map(|r| (r.time_s[press(r) - 1] - r.time_s[0]) / press(r) as f64);
        let press_s = records.iter().map(|r| r.span_m() / r.speed_m_per_s()).fold(f64::MAX, f64::min);
        let fast_s = (2.0 * step_s.fold(f64::MAX, f64::min)).max(press_s / 20.0);
        let times_s = settings.times_s.unwrap_or([fast_s.min(longest_s), 3.0 * longest_s]);
        // far from the answer a loss that is linear beyond the noise has no slope to follow
        let sigma = |record: &Record| record.noise_n.max(START_NOISE * record.force_n.iter().copied().fold(0.0, f64::max));
        let sigma_n = records.iter().map(sigma).collect();
        Self { elastic, records, rows, sigma_n, settings, press_s, times_s }
    }

    /// A fit of the same rows with other settings, and perhaps with first contact elsewhere.
    #[must_use]
    pub fn with<'b>(&self, records: &'b [Record], settings: Settings) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem::new(self.elastic, records, self.rows.clone(), settings)
    }

    /// The records that are fitted.
    #[must_use]
    pub fn records(&self) -> &[Record] {
        self.records
    }

    /// Number of points that are fitted.
    #[must_use]
    pub fn points(&self) -> usize {
        self.rows.iter().sum()
    }

    /// Rms error over the peak in the fitted rows [%].
    #[must_use]
    pub fn rms_pct(&self, fit: &Fitted) -> f64 {
        let of = |n: usize| {
            let peak_n = self.records[n].force_n.iter().copied().fold(0.0, f64::max);
            let off = self.off(fit, n);
            off.iter().map(|off| (off / peak_n).powi(2)).sum::<f64>() / off.len().max(1) as f64
        };
        100.0 * ((0..self.records.len()).map(of).sum::<f64>() / self.records.len() as f64).sqrt()
    }

    /// The tissue of a set of unknowns.
    fn tissue(p: &[f64], terms: usize) -> Tissue {
        Tissue { youngs_modulus_pa: p[0].exp(), stiffening_b: p[1].exp_m1(), terms: shares(p, terms) }
    }

    /// Forces of the model in the fitted rows of one record, with the zero of its sensor [N].
    fn forces<'f>(&self, p: &[f64], terms: usize, of: usize, kept: &'f mut Forces) -> impl Iterator<Item = f64> + 'f {
        let rows = (&self.records[of], self.rows[of]);
        let (surface_m, delay_s) = (p[2 + 2 * terms + of], p[p.len() - 1]);
        let force_n = kept.growing_n(self.elastic, &Self::tissue(p, terms), rows, surface_m, delay_s);
        let zero_n = p[2 + 2 * terms + self.records.len() + of] * self.sigma_n[of];
        force_n.iter().map(move |force_n| force_n + zero_n)
    }

    fn residuals(&self, p: &[f64], terms: usize, kept: &mut [Forces], out: &mut [f64]) {
        let mut at = 0;
        for (of, (record, kept)) in self.records.iter().zip(kept).enumerate() {
            for (force, measured) in self.forces(p, terms, of, kept).zip(&record.force_n) {
                // a row whose force is missing only moves the tip
                let r = if measured.is_nan() { 0.0 } else { (force - measured) / self.sigma_n[of] };
                out[at] = r.signum() * ROBUST * (2.0 * ((1.0 + (r / ROBUST).powi(2)).sqrt() - 1.0)).sqrt();
                at += 1;
            }
        }
    }

    /// Differences of the model from the measured forces of one record [N].
    fn off(&self, fit: &Fitted, of: usize) -> Vec<f64> {
        let mut kept = Forces::default();
        let off = self.forces(&fit.p, fit.terms, of, &mut kept).zip(&self.records[of].force_n).map(|(a, b)| a - b);
        off.filter(|off| !off.is_nan()).collect()
    }

    /// A quantity as the fit moves it: moduli, times and 1 + b by their logarithms.
    fn inner(&self, p: &[f64], terms: usize, of: Quantity) -> f64 {
        match of {
            Quantity::Modulus => p[0],
            Quantity::Relaxed => p[0] + (1.0 - shares(p, terms).iter().map(|s| s.0).sum::<f64>()).ln(),
            Quantity::Exponent => p[1],
            Quantity::Share(k) => shares(p, terms)[k].0,
            Quantity::Time(k) => p[3 + 2 * k],
            Quantity::Contact(k) => p[2 + 2 * terms + k],
        }
    }

    /// Change of a quantity between two fits of these rows; zero if neither the first one nor
    /// one of its rivals has as many terms as the second.
    #[must_use]
    pub fn change(&self, of: Quantity, from: &Fitted, to: &Fitted) -> f64 {
        let value = |fit: &Fitted| of.outer(self.inner(&fit.p, fit.terms, of));
        let from = std::iter::once(from).chain(&from.rivals).find(|from| from.terms == to.terms);
        from.map_or(0.0, |from| value(to) - value(from))
    }

    fn limits(&self, terms: usize) -> Vec<MPPar> {
        let within = |low: f64, high: f64| MPPar {
            limited_low: true,
            limited_up: true,
            limit_low: low,
            limit_up: high,
            fixed: low == high,
            step: STEP * (high - low),
            ..MPPar::default()
        };
        let most_b = if self.settings.stiffens { self.elastic.most_b() } else { 0.0 };
        let times = self.times_s.map(f64::ln);
        let mut limits = vec![within(0.0, 25.0), within(0.0, most_b.ln_1p())];
        for _ in 0..terms {
            limits.extend([within(0.0, MOST_SHARE), within(times[0], times[1])]);
        }
        for record in self.records {
            let [low, high] = if self.settings.contact { record.contact_range_m } else { [record.contact_m; 2] };
            limits.push(within(low, high));
        }
        // without rows before contact the zero of the force is taken on trust
        let zero = |record: &Record| if record.starts_before { MOST_ZERO } else { 0.0 };
        limits.extend(self.records.iter().map(|record| within(-zero(record), zero(record))));
        let most_s = if self.settings.delay { MOST_DELAY * self.press_s } else { 0.0 };
        limits.push(within(-most_s, most_s));
        limits
    }

    /// Least squares from a start; `held` keeps a quantity at a value, with a weight.
    fn least(&self, start: &[f64], terms: usize, held: Option<(Quantity, f64, f64)>) -> Option<Fitted> {
        let limits = self.limits(terms);
        let mut p: Vec<f64> = start.iter().zip(&limits).map(|(p, l)| p.clamp(l.limit_low, l.limit_up)).collect();
        let config = MPConfig { ftol: 1e-9, xtol: 1e-9, max_iter: 60, epsfcn: 1e-14, ..MPConfig::default() };
        let forces = vec![Forces::default(); self.records.len()];
        let mut least = Least { problem: self, terms, held, limits, config, forces };
        let status = least.mpfit(&mut p).ok()?;
        let count = p.len();
        let chi = status.best_norm - held.map_or(0.0, |(of, at, weight)| ((self.inner(&p, terms, of) - at) * weight).powi(2));
        let sd = status.xerror;
        let mut correlation = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                let both = sd[i] * sd[j];
                correlation[i * count + j] = if both > 0.0 { status.covar[i * count + j] / both } else { 0.0 };
            }
        }
        let sigma_n = self.sigma_n.clone();
        Some(Fitted { p, terms, chi, sigma_n, criteria: Vec::new(), sd, correlation, inflation: 1.0, rivals: Vec::new() })
    }

    /// A first modulus [Pa] at an exponent, from the largest force.
    fn modulus_pa(&self, b: f64) -> f64 {
        let record = &self.records[0];
        let end = record.segments.press.end.clamp(1, self.rows[0]) - 1;
        record.force_n[end].max(1e-9) / self.elastic.at(b).force_m2(record.depth_m[end] - record.contact_m).max(1e-30)
    }

    fn best(&self, starts: Vec<Vec<f64>>, terms: usize) -> Option<Fitted> {
        let found: Vec<Option<Fitted>> = starts.into_par_iter().map(|start| self.least(&start, terms, None)).collect();
        found.into_iter().flatten().min_by(|a, b| a.chi.total_cmp(&b.chi))
    }

    /// The best fit of each number of terms, each from the one before with another term.
    fn ladder(&self) -> Vec<Fitted> {
        let contacts = self.records.iter().map(|r| r.contact_m);
        let contacts: Vec<f64> = contacts.chain(self.records.iter().map(|_| 0.0)).chain([0.0]).collect();
        let mut fits: Vec<Fitted> = Vec::new();
        for terms in 0..self.settings.terms.end {
            let starts: Vec<Vec<f64>> = match fits.last() {
                None => {
                    [0.1_f64, 2.0, 8.0].map(|b| [&[self.modulus_pa(b).ln(), b.ln_1p()], contacts.as_slice()].concat()).to_vec()
                }
                Some(last) => {
                    let [fast, slow] = self.times_s.map(f64::ln);
                    // the exponent of a fit with too few terms may be far off
                    let start = |(n, b): (usize, f64)| {
                        let time = fast + (slow - fast) * (n as f64 + 0.5) / 4.0;
                        let mut p = last.p.clone();
                        let at = (0..last.terms).position(|k| p[3 + 2 * k] > time).unwrap_or(last.terms);
                        (p[0], p[1]) = (self.modulus_pa(b).ln() + 0.3, b.ln_1p());
                        p.splice(2 + 2 * at..2 + 2 * at, [0.15, time]);
                        let contact = 4 + 2 * last.terms;
                        p[contact..].clone_from_slice(&contacts);
                        p
                    };
                    let exponents = [last.p[1].exp_m1(), 0.5, 5.0];
                    (0..4).flat_map(|n| exponents.map(|b| (n, b))).map(start).collect()
                }
            };
            let Some(found) = self.best(starts, terms) else { break };
            fits.push(self.sorted(found));
        }
        fits.into_iter().filter(|fit| self.settings.terms.contains(&fit.terms)).collect()
    }

    /// Fit with its terms in the order from fast to slow.
    fn sorted(&self, fit: Fitted) -> Fitted {
        let mut terms = shares(&fit.p, fit.terms);
        if terms.is_sorted_by(|a, b| a.1 <= b.1) {
            return fit;
        }
        terms.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (mut p, mut left) = (fit.p.clone(), 1.0);
        for (k, (share, time_s)) in terms.into_iter().enumerate() {
            (p[2 + 2 * k], p[3 + 2 * k]) = (share / left, time_s.ln());
            left -= share;
        }
        self.least(&p, fit.terms, None).unwrap_or(fit)
    }

    /// Fit from another one without its stiffening, with as many terms.
    #[must_use]
    pub fn without_stiffening(&self, fit: &Fitted) -> Option<Fitted> {
        let mut start = fit.p.clone();
        start[1] = 0.0;
        self.least(&start, fit.terms, None).map(|fit| self.sorted(fit))
    }

    /// Fits all numbers of terms and returns the one that the criterion chooses.
    #[must_use]
    pub fn solve(&mut self) -> Option<Fitted> {
        let first = self.ladder();
        let most = first.iter().min_by(|a, b| a.chi.total_cmp(&b.chi))?;
        // the spread that the largest model leaves is the noise
        for of in 0..self.records.len() {
            let off: Vec<f64> = self.off(most, of).into_iter().map(f64::abs).collect();
            let least_n = 1e-5 * self.records[of].force_n.iter().copied().fold(0.0, f64::max);
            self.sigma_n[of] = (quantile(&off, 0.5) / 0.6745).max(least_n);
        }
        let fits: Vec<Fitted> = first.iter().filter_map(|fit| Some(self.sorted(self.least(&fit.p, fit.terms, None)?))).collect();
        let last = fits.last()?;
        let inflation = repeats(&(0..self.records.len()).flat_map(|of| self.off(last, of)).collect::<Vec<f64>>());
        let n = self.points() as f64 / inflation;
        let criterion = |fit: &Fitted| {
            let k = self.limits(fit.terms).iter().filter(|l| !l.fixed).count() as f64 + 1.0;
            n * (fit.chi / self.points() as f64).ln() + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0).max(1.0)
        };
        let criteria: Vec<(usize, f64)> = fits.iter().map(|fit| (fit.terms, criterion(fit))).collect();
        let mut chosen = 0;
        for n in 1..fits.len() {
            if criteria[n].1 < criteria[chosen].1 {
                chosen = n;
            }
        }
        let near = criteria.iter().map(|(_, c)| *c < criteria[chosen].1 + RIVAL).collect::<Vec<bool>>();
        let all = fits.into_iter().zip(near).enumerate().map(|(n, (fit, near))| (n, near, Fitted { inflation, ..fit }));
        let (taken, rivals): (Vec<_>, Vec<_>) =
            all.filter(|(n, near, _)| *n == chosen || *near).partition(|(n, ..)| *n == chosen);
        let rivals = rivals.into_iter().map(|(.., fit)| fit).collect();
        Some(Fitted { criteria, rivals, ..taken.into_iter().next()?.2 })
    }

    /// Sum over the records of their points times the logarithm of the mean square of what the fit
    /// leaves [ln N^2], to compare models of the same rows.
    #[must_use]
    pub fn left(&self, fit: &Fitted) -> f64 {
        let mut out = vec![0.0; self.points()];
        self.residuals(&fit.p, fit.terms, &mut vec![Forces::default(); self.records.len()], &mut out);
        let mut rest = &out[..];
        let of = |(rows, sigma_n): (&usize, &f64)| {
            let (own, others) = rest.split_at(*rows);
            rest = others;
            let n = *rows as f64;
            n * (sigma_n.powi(2) * own.iter().map(|r| r * r).sum::<f64>() / n).ln()
        };
        self.rows.iter().zip(&self.sigma_n).map(of).sum()
    }

    /// The fit with a delay of the forces, if that leaves less by far; the other constants are
    /// fitted with it from now on.
    pub fn delayed(&mut self, fit: &Fitted) -> Option<Fitted> {
        self.settings.delay = true;
        let spread = fit.inflation * fit.chi / self.points() as f64;
        let within_s = 0.98 * MOST_DELAY * self.press_s;
        let gains = |found: &Fitted| fit.chi - found.chi > DELAY_GAIN * spread && found.delay_s().abs() < within_s;
        let found = self.again(fit).filter(gains);
        self.settings.delay = found.is_some();
        found
    }

    /// A fit of the same rows with other elastic curves, fitted again with these.
    pub fn corrected(&mut self, fit: &Fitted) -> Option<Fitted> {
        self.sigma_n.clone_from(&fit.sigma_n);
        self.settings.delay = fit.delay_s() != 0.0;
        self.again(fit)
    }

    /// A fit and its rivals from where they were.
    fn again(&self, fit: &Fitted) -> Option<Fitted> {
        let of = |fit: &Fitted| self.least(&fit.p, fit.terms, None).map(|found| Fitted { inflation: fit.inflation, ..found });
        let rivals = fit.rivals.iter().filter_map(of).collect();
        Some(Fitted { criteria: fit.criteria.clone(), inflation: fit.inflation, rivals, ..self.sorted(of(fit)?) })
    }

    /// Force of a record that a fit takes for zero [N].
    #[must_use]
    pub fn zero_n(&self, fit: &Fitted, record: usize) -> f64 {
        fit.p[2 + 2 * fit.terms + self.records.len() + record] * self.sigma_n[record]
    }
}

impl Fitted {
    /// Constants of the tissue.
    #[must_use]
    pub fn tissue(&self) -> Tissue {
        Problem::tissue(&self.p, self.terms)
    }

    /// Number of Prony terms.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// Depth of first contact of a record [m].
    #[must_use]
    pub fn contact_m(&self, record: usize) -> f64 {
        self.p[2 + 2 * self.terms + record]
    }

    /// Time by which the forces come after the depths [s].
    #[must_use]
    pub fn delay_s(&self) -> f64 {
        self.p[self.p.len() - 1]
    }

    /// Correlation between two quantities as the fit moves them (1).
    #[must_use]
    pub fn correlation(&self, a: Quantity, b: Quantity) -> f64 {
        self.correlation[a.place(self.terms) * self.p.len() + b.place(self.terms)]
    }
}
