//! The search bisects candidates over their cost by screening, fits fully around the border, and
//! then tries to leave out terms of the chosen candidate.
//!
//! Errors of single meshes scatter around the trend of error with cost. Candidates are therefore
//! bisected in groups (*rungs*) of about equal cost, and full fits explore the border. The chosen
//! model is the smallest of those on the ladder, not of all possible models.

use std::ops::Range;

use palpate::Terms;

use super::candidate::{Candidate, Supply, Weighed};
use super::judged_candidate::{Bench, Effort, JudgedCandidate};
use super::outcome::Outcome;
use super::rim_treatment::RimTreatment;
use palpate_tissue::error::Error;

/// Largest ratio of costs in a rung, and the maximum numbers of candidates per rung that are
/// screened and fitted fully.
const RUNG: f64 = 1.12;
const SCREENED_PER_RUNG: usize = 3;
const FULL_PER_RUNG: usize = 2;
/// Ratio of the errors after screening and after a full fit: of most meshes, and one that is seldom
/// exceeded.
const SLACK: f64 = 1.25;
const MOST_SLACK: f64 = 1.6;
/// The ladder ends after this many consecutive element sizes whose error in a short fit is within
/// this share of the tolerance.
const SETTLED: f64 = 1.0;
const SETTLED_SIZES: usize = 2;
/// Ratio of the largest cost on the ladder to the budget, so that candidates beyond the budget are
/// shown.
const BEYOND: f64 = 1.3;
/// Maximum number of full fits below the chosen candidate, and above it to find the runner-up.
const WALK: usize = 3;
/// Maximum number of nodes of a candidate, and that of a quick search.
const MOST_NODES: usize = 250;
const QUICK_MOST_NODES: usize = 140;

/// A candidate and the indices of its trials, if it was tried; an inner `None` means that the fit
/// failed.
struct Step {
    weighed: Weighed,
    screened: Option<Option<usize>>,
    full: Option<Option<usize>>,
}

/// Candidates in the order of increasing cost.
struct Ladder<'a> {
    bench: &'a Bench<'a>,
    steps: Vec<Step>,
    trials: Vec<JudgedCandidate>,
    unfitted: Vec<(Candidate, RimTreatment, Terms)>,
}

impl Ladder<'_> {
    fn add(&mut self, list: Vec<Weighed>) {
        self.steps.extend(list.into_iter().map(|weighed| Step { weighed, screened: None, full: None }));
        self.steps.sort_by(|a, b| a.weighed.units.total_cmp(&b.weighed.units));
    }

    fn run(&mut self, step: usize, edge: RimTreatment, terms: Terms, effort: Effort) -> Option<usize> {
        let Ok(trial) = self.bench.run(&self.steps[step].weighed, edge, terms, effort) else {
            // a candidate whose patch cannot be fitted is dropped
            self.unfitted.push((self.steps[step].weighed.candidate, edge, terms));
            return None;
        };
        self.trials.push(trial);
        Some(self.trials.len() - 1)
    }

    fn screened(&mut self, step: usize) -> Option<&JudgedCandidate> {
        if self.steps[step].screened.is_none() {
            let found = self.run(step, RimTreatment::RimSprings, Terms::ALL, Effort::Screened);
            self.steps[step].screened = Some(found);
        }
        self.steps[step].screened.flatten().map(|t| &self.trials[t])
    }

    fn full(&mut self, step: usize) -> Option<&JudgedCandidate> {
        if self.steps[step].full.is_none() {
            let found = self.run(step, RimTreatment::RimSprings, Terms::ALL, Effort::Full);
            self.steps[step].full = Some(found);
        }
        self.steps[step].full.flatten().map(|t| &self.trials[t])
    }

    fn screened_keeps(&mut self, step: usize, tolerance_pct: f64) -> bool {
        self.screened(step).is_some_and(|t| t.keeps_pct <= tolerance_pct)
    }

    /// Groups steps into rungs of about equal cost.
    fn rungs(&self, steps: &[usize]) -> Vec<Vec<usize>> {
        let mut rungs: Vec<Vec<usize>> = Vec::new();
        for &step in steps {
            let units = |s: usize| self.steps[s].weighed.units;
            match rungs.last_mut() {
                Some(rung) if units(step) <= RUNG * units(rung[0]) => rung.push(step),
                _ => rungs.push(vec![step]),
            }
        }
        rungs
    }

    fn promises(&mut self, rung: &[usize]) -> bool {
        let most = rung.len().min(SCREENED_PER_RUNG);
        let slack = SLACK * self.bench.tolerance_pct;
        (0..most).any(|n| self.screened_keeps(rung[n * rung.len() / most], slack))
    }

    /// Cheapest of `steps` (in the order of increasing cost) that meets the tolerance after a full
    /// fit; with `within_budget` it must also meet the budget.
    fn cheapest(&mut self, steps: &[usize], within_budget: bool) -> Option<usize> {
        let rungs = self.rungs(steps);
        let Range { start: mut low, end: mut high } = 0..rungs.len();
        while low < high {
            let middle = low.midpoint(high);
            if self.promises(&rungs[middle]) { high = middle } else { low = middle + 1 }
        }
        let tolerance_pct = self.bench.tolerance_pct;
        for rung in &rungs[low.saturating_sub(1)..] {
            let mut fitted = 0;
            for &step in rung {
                if fitted == FULL_PER_RUNG || !self.screened_keeps(step, MOST_SLACK * tolerance_pct) {
                    continue;
                }
                fitted += 1;
                if self.full(step).is_some_and(|t| t.keeps(tolerance_pct) && (t.fits || !within_budget)) {
                    return Some(step);
                }
            }
        }
        None
    }

    /// Walks down from a step while the cheaper ones meet the tolerance too. Returns the last step
    /// that does, and the trial of the next cheaper one, which does not. A fitted patch may need
    /// more substeps than the unfitted one, so an earlier step is not always cheaper.
    fn walk_down(&mut self, mut step: usize) -> (usize, Option<JudgedCandidate>) {
        let tolerance_pct = self.bench.tolerance_pct;
        let mut units = self.full(step).map_or(f64::INFINITY, |t| t.units);
        for below in (0..step).rev().take(WALK) {
            let Some(trial) = self.full(below) else { continue };
            match (trial.units < units, trial.keeps(tolerance_pct) && trial.fits) {
                (true, true) => (step, units) = (below, trial.units),
                (true, false) => return (step, Some(trial.clone())),
                (false, _) => {}
            }
        }
        (step, None)
    }

    /// Returns the largest fully fitted model with fewer nodes that fails the tolerance or the
    /// budget.
    fn fewer_nodes(&self, step: usize) -> Option<JudgedCandidate> {
        let nodes = self.steps[step].weighed.counts.nodes;
        let misses = |t: &&JudgedCandidate| !(t.keeps(self.bench.tolerance_pct) && t.fits);
        let smaller = self.trials.iter().filter(|t| t.effort == Effort::Full && t.counts.nodes < nodes).filter(misses);
        smaller.max_by_key(|t| t.counts.nodes).cloned()
    }

    /// The next more expensive step that meets the tolerance, or the first that exceeds the budget.
    fn runner_up(&mut self, step: usize) -> Option<JudgedCandidate> {
        let tolerance_pct = self.bench.tolerance_pct;
        let units = self.full(step).map_or(0.0, |t| t.units);
        let mut tried = 0;
        for above in step + 1..self.steps.len() {
            if !self.steps[above].weighed.fits(self.bench.machine) {
                return self.screened(above).cloned();
            }
            if tried < WALK {
                tried += 1;
                if let Some(t) = self.full(above).filter(|t| t.units > units && (t.keeps(tolerance_pct) || !t.fits)) {
                    return Some(t.clone());
                }
            }
        }
        None
    }

    /// Tries to leave out a term or the springs of the rim; returns the reduced model if it is
    /// cheaper and meets the tolerance, and otherwise `chosen`.
    fn with_less(&mut self, step: usize, chosen: JudgedCandidate) -> JudgedCandidate {
        let tolerance_pct = self.bench.tolerance_pct;
        let mut best = chosen;
        let less = [
            (RimTreatment::RimSprings, Terms { compensation: false, ..Terms::ALL }),
            (RimTreatment::RimSprings, Terms { volume: false, ..Terms::ALL }),
            (RimTreatment::Bedded, Terms::ALL),
            (RimTreatment::Fixed, Terms::ALL),
        ];
        for (edge, without) in less {
            let both = |a: Terms, b: Terms| Terms {
                volume: a.volume && b.volume,
                compensation: a.compensation && b.compensation,
                rim: a.rim && b.rim,
                relative_mass: a.relative_mass && b.relative_mass,
                smooth_mass: a.smooth_mass || b.smooth_mass,
                stiffening: a.stiffening && b.stiffening,
                relaxation: a.relaxation && b.relaxation,
                friction: a.friction && b.friction,
                law: a.law && b.law,
            };
            let terms = both(best.terms, without);
            let Some(screened) = self.run(step, edge, terms, Effort::Screened) else { continue };
            let screened = &self.trials[screened];
            if screened.keeps_pct > MOST_SLACK * tolerance_pct || !screened.edge_keeps(tolerance_pct) {
                continue;
            }
            let Some(full) = self.run(step, edge, terms, Effort::Full) else { continue };
            let full = &self.trials[full];
            if full.keeps(tolerance_pct) && full.fits && full.units < best.units {
                best = full.clone();
            }
        }
        best
    }
}

/// Runs the search. It is not an error if no model is found: see [`Outcome::check`].
///
/// # Errors
/// Fails if the scene has no candidate.
pub fn search(bench: &Bench, supply: &mut Supply) -> Result<Outcome, Error> {
    let machine = bench.machine;
    let most_nodes = if bench.quick { QUICK_MOST_NODES } else { MOST_NODES };
    let mut ladder = Ladder { bench, steps: Vec::new(), trials: Vec::new(), unfitted: Vec::new() };
    let mut settled = 0;
    (bench.progress)("meshing candidates");
    while settled < SETTLED_SIZES {
        let Some(list) = supply.next(BEYOND * machine.budget(), most_nodes) else { break };
        let Some(element_radii) = list.first().map(|w| w.candidate.element_radii) else { continue };
        ladder.add(list);
        let mut of_this_size =
            (0..ladder.steps.len()).filter(|s| ladder.steps[*s].weighed.candidate.element_radii == element_radii);
        let inside = of_this_size.find(|s| ladder.steps[*s].weighed.fits(machine));
        let keeps = inside.is_some_and(|step| ladder.screened_keeps(step, SETTLED * bench.tolerance_pct));
        settled = if keeps { settled + 1 } else { 0 };
        (bench.progress)("meshing candidates");
    }
    if ladder.steps.is_empty() {
        let none = || Error::Check("no candidate can be meshed: take another probe radius or a larger organ".into());
        return Err(supply.refused.take().unwrap_or_else(none));
    }
    let fitting = |ladder: &Ladder, fits: bool| -> Vec<usize> {
        (0..ladder.steps.len()).filter(|s| ladder.steps[*s].weighed.fits(machine) == fits).collect()
    };
    let inside = fitting(&ladder, true);
    let mut outcome = Outcome::default();
    if let Some(step) = ladder.cheapest(&inside, true) {
        let (step, smaller) = ladder.walk_down(step);
        outcome.smaller = smaller.or_else(|| ladder.fewer_nodes(step));
        outcome.larger = ladder.runner_up(step);
        if let Some(chosen) = ladder.full(step).cloned() {
            let chosen = ladder.with_less(step, chosen);
            // with terms left out, the chosen model may be cheaper than the next smaller one
            outcome.smaller = outcome.smaller.filter(|smaller| smaller.units < chosen.units);
            outcome.chosen = Some(chosen);
        }
        (outcome.trials, outcome.unfitted) = (ladder.trials, ladder.unfitted);
        return Ok(outcome);
    }
    // no candidate was chosen: the best two are fitted fully, to report the tolerance that this
    // board reaches
    let mut known: Vec<(usize, f64)> =
        inside.iter().filter_map(|s| Some((*s, ladder.trials[ladder.steps[*s].screened.flatten()?].keeps_pct))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (step, _) in known.into_iter().take(2) {
        ladder.full(step);
    }
    let tightest = ladder.trials.iter().filter(|t| t.effort == Effort::Full && t.fits && t.edge_keeps(t.keeps_pct));
    outcome.tightest = tightest.min_by(|a, b| a.keeps_pct.total_cmp(&b.keeps_pct)).cloned();
    if let Some(whole) = supply.whole_blocks().into_iter().next() {
        let screened = bench.run(&whole, RimTreatment::Whole, Terms::ALL, Effort::Screened).ok();
        if screened.as_ref().is_some_and(|t| t.keeps_pct <= MOST_SLACK * bench.tolerance_pct) {
            let full = bench.run(&whole, RimTreatment::Whole, Terms::ALL, Effort::Full).ok();
            outcome.chosen = full.clone().filter(|t| t.fits && t.keeps(bench.tolerance_pct));
            ladder.trials.extend(full);
        }
        ladder.trials.extend(screened);
    }
    if outcome.chosen.is_none() {
        (bench.progress)("meshing candidates for other boards");
        while let Some(list) = supply.next(f64::INFINITY, most_nodes) {
            ladder.add(list);
        }
        let outside = fitting(&ladder, false);
        if let Some(step) = ladder.cheapest(&outside, false) {
            outcome.elsewhere = ladder.full(step).cloned();
        }
    }
    (outcome.trials, outcome.unfitted) = (ladder.trials, ladder.unfitted);
    Ok(outcome)
}
