//! Elastic curves that reach the depths of the tests, and first contact, which says how deep they
//! are.

use super::super::elastic::{Elastic, Setup};
use super::super::fit::{Fitted, Problem, Settings};
use super::super::model::{Forces, Tissue};
use super::super::record::{CONTACT_RANGE, Record};
use super::{Plan, unsolved};

/// Largest number of times that first contact is moved.
const MOST_TRIES: usize = 4;
/// Number of times that the range of a left-out test's contact is narrowed by a third.
const NARROWINGS: usize = 24;

/// Elastic curves, and the fit of the first tests' rows to them, so many of each. First contact of
/// all tests moves to where the fit has it.
pub(super) fn solved(plan: &Plan, setup: &Setup, records: &mut [Record], fitted: &[usize]) -> Result<(Elastic, Fitted), String> {
    let (mut tries, mut was_short) = (0, false);
    loop {
        records.iter_mut().for_each(|r| r.limit_depth(plan.most_depth_m().max(r.least_depth_m())));
        let asked_m = deepest_m(records);
        let elastic = Elastic::solve(setup, asked_m).ok_or_else(|| too_deep(setup, records, 0.0))?;
        let reached_m = elastic.deepest_m();
        // contact may have been guessed too early; at the fitted one, elements must reach it
        let is_short = reached_m < asked_m;
        if is_short && was_short {
            return Err(too_deep(setup, records, reached_m));
        }
        records.iter_mut().for_each(|record| record.limit_depth(reached_m));
        let mut problem = Problem::new(&elastic, &records[..fitted.len()], fitted.to_vec(), Settings::default());
        let fit = problem.solve().ok_or_else(unsolved)?;
        let delayed = problem.delayed(&fit);
        let left_out = records[fitted.len()..].iter().map(|record| contact_m(record, &fit.tissue(), &elastic, fit.delay_s()));
        let to_m: Vec<f64> = (0..fitted.len()).map(|n| fit.contact_m(n)).chain(left_out).collect();
        (tries, was_short) = (tries + 1, was_short | is_short);
        // where contact was found at the edge of its range, it is somewhere else
        let moves = |(record, to_m): (&mut Record, f64)| record.move_contact(to_m, is_short);
        let moved = (is_short || tries <= MOST_TRIES) && records.iter_mut().zip(to_m).map(moves).fold(false, |a, b| a | b);
        if !moved {
            return Ok((elastic, delayed.unwrap_or(fit)));
        }
    }
}

/// First contact of a test that was left out [m], at which a tissue gives its press best: that is
/// no constant of the tissue.
pub(super) fn contact_m(record: &Record, tissue: &Tissue, elastic: &Elastic, delay_s: f64) -> f64 {
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
