//! The command `palpate faults --trade`: what the settings of the energy account cost.

use std::ops::Range;

use crate::faults::paths::PathGround;
use crate::faults::yielding::{TradePoint, trade};
use palpate_charts::{Figure, Plot, ScaledAxis, Series};
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::study::{Findings, Study, Table};

/// Runs at each point, and with `--quick`.
pub(super) const RUNS: u64 = 60;
pub(super) const QUICK_RUNS: u64 = 6;
/// Smallest energy that the chart shows [mJ].
const LEAST_MJ: f64 = 1e-4;

/// Comparison of settings on the same hands.
pub(super) struct Trade {
    runs: u64,
    seed: u64,
    ground: PathGround,
}

/// A setting, and what the hands felt and were given.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Point {
    delay_ticks: u8,
    acceleration_m_per_s2: f32,
    handle_share: f32,
    felt_share: f64,
    lost_pct: f64,
    worst_mj: f64,
    contacts: u64,
    contacts_over_100_uj_pct: f64,
}

impl Point {
    fn of(point: &TradePoint) -> Self {
        Self {
            delay_ticks: point.delay_ticks,
            acceleration_m_per_s2: point.account.acceleration_m_per_s2,
            handle_share: point.account.handle_share,
            felt_share: point.felt,
            lost_pct: point.lost * 100.0,
            worst_mj: point.worst_j * 1e3,
            contacts: point.contacts,
            contacts_over_100_uj_pct: point.over as f64 / point.contacts.max(1) as f64 * 100.0,
        }
    }
}

impl Trade {
    pub(super) fn of(runs: u64, seed: u64) -> Result<Self, Error> {
        Ok(Self { runs, seed, ground: PathGround::load()? })
    }
}

impl Study for Trade {
    type Row = Point;

    fn cases(&self) -> u64 {
        1
    }

    fn run(&self, _: Range<u64>) -> Result<Vec<(u64, Point)>, Error> {
        let progress = Progress::new(TradePoint::count() as u64 * self.runs, "runs");
        let found = trade(&self.ground, self.runs, self.seed, |n| progress.inc(n))?;
        progress.finish();
        Ok(found.iter().map(|point| (0, Point::of(point))).collect())
    }

    fn findings(&self, points: Vec<Point>) -> Result<Findings, Error> {
        let (runs, seed) = (self.runs, self.seed);
        let mut findings = Findings {
            headline: format!("{} settings at {runs} runs each", points.len()),
            tables: vec![Table::of("trade", &points)?],
            figures: vec![
                figure(&points, runs, "trade_worst", ScaledAxis::log("most energy given [mJ]"), |p| p.worst_mj.max(LEAST_MJ)),
                figure(&points, runs, "trade_contacts", ScaledAxis::linear("contacts that create more than 0.1 mJ [%]"), |p| {
                    p.contacts_over_100_uj_pct
                }),
            ],
            ..Findings::default()
        };
        findings.fact("runs_per_point", runs);
        findings.fact("seed", seed);
        Ok(findings)
    }
}

/// Picture of the felt share against a measure of the energy, with two lines for each delay.
fn figure(points: &[Point], runs: u64, name: &str, x: ScaledAxis, measure: fn(&Point) -> f64) -> Figure {
    let series = points.chunks(TradePoint::settings().len() / 2).enumerate().map(|(n, line)| {
        let varied = if n % 2 == 0 { "0 to 50 m/s²" } else { "handle 0 to 1" };
        let delay_ticks = line.first().map_or(0, |p| p.delay_ticks);
        Series::curve(format!("delay {delay_ticks}: {varied}"), line.iter().map(|p| (measure(p), p.felt_share))).marked()
    });
    let below = format!("{runs} random hands, devices and tissues at each point; the default is 3 m/s² and 0.7");
    let y = ScaledAxis::linear("share of the patch's push that is felt (1)");
    Figure::plot(name, "Felt force against energy, over the account's settings", below, Plot::new(x, y, series.collect()))
}
