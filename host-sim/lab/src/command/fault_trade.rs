//! The command `palpate faults --trade`: what the settings of the energy account cost.

use std::fmt::Write;
use std::path::Path;

use crate::faults::paths::PathGround;
use crate::faults::yielding::{TradePoint, trade};
use palpate_charts::{self as charts, LineSeries, Lines, Scale, ScaledAxis};
use palpate_tissue::output::OutputFolder;
use serde::Serialize;

use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_sim::provenance;

/// Runs at each point, and with `--quick`.
pub(super) const RUNS: u64 = 60;
pub(super) const QUICK_RUNS: u64 = 6;
/// Smallest energy that the chart shows [mJ].
const LEAST_MJ: f64 = 1e-4;

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary {
    runs_per_point: u64,
    seed: u64,
    points: Vec<Point>,
}

/// Figures of a point.
#[derive(Serialize)]
struct Point {
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

/// Runs the same hands with every setting, and draws what is felt against what is given.
pub(super) fn run(out: &Path, seed: u64, runs: u64) -> Result<(), Error> {
    let folder = OutputFolder::open(out)?.made_by(provenance::of(None));
    let ground = PathGround::load()?;
    let progress = Progress::new(TradePoint::count() as u64 * runs, "runs");
    let found = trade(&ground, runs, seed, |n| progress.inc(n))?;
    progress.finish();
    let points: Vec<Point> = found.iter().map(Point::of).collect();
    folder.write("trade.csv", csv(&points).as_bytes())?;
    draw(&folder, &points, runs)?;
    let verdict = Verdict::ok(format!("{} settings at {runs} runs each", points.len())).first();
    print(&points);
    folder.write_summary(&Summary { runs_per_point: runs, seed, points })?;
    println!("wrote {}: summary.json, trade.csv, pictures as SVG and PNG", folder.publish()?.display());
    verdict.last()
}

fn csv(points: &[Point]) -> String {
    let mut text = String::from(
        "delay_ticks,acceleration_m_per_s2,handle_share,felt_share,lost_pct,worst_mj,contacts,contacts_over_100_uj_pct\n",
    );
    for p in points {
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{}",
            p.delay_ticks,
            p.acceleration_m_per_s2,
            p.handle_share,
            p.felt_share,
            p.lost_pct,
            p.worst_mj,
            p.contacts,
            p.contacts_over_100_uj_pct
        );
    }
    text
}

fn print(points: &[Point]) {
    println!(
        "{:>5} {:>18} {:>12} {:>6} {:>7} {:>9} {:>9} {:>10}",
        "delay", "acceleration m/s^2", "handle share", "felt", "lost %", "worst mJ", "contacts", "> .1 mJ %"
    );
    for p in points {
        println!(
            "{:>5} {:>18} {:>12} {:>6.3} {:>7.3} {:>9.4} {:>9} {:>10.3}",
            p.delay_ticks,
            p.acceleration_m_per_s2,
            p.handle_share,
            p.felt_share,
            p.lost_pct,
            p.worst_mj,
            p.contacts,
            p.contacts_over_100_uj_pct
        );
    }
}

/// Draws a picture for each measure of the energy, with two lines for each delay.
fn draw(folder: &OutputFolder, points: &[Point], runs: u64) -> Result<(), Error> {
    type Measure = fn(&Point) -> f64;
    let pictures: [(&str, &str, Scale, Measure); 2] = [
        ("trade_worst", "most energy given [mJ]", Scale::Log, |p| p.worst_mj.max(LEAST_MJ)),
        ("trade_contacts", "contacts that create more than 0.1 mJ [%]", Scale::Linear, |p| p.contacts_over_100_uj_pct),
    ];
    let below = format!("{runs} random hands, devices and tissues at each point; the default is 3 m/s² and 0.7");
    for (name, x_title, scale, measure) in pictures {
        let series: Vec<(String, Vec<(f64, f64)>)> = points
            .chunks(TradePoint::settings().len() / 2)
            .enumerate()
            .map(|(n, line)| {
                let varied = if n % 2 == 0 { "0 to 50 m/s²" } else { "handle 0 to 1" };
                let delay_ticks = line.first().map_or(0, |p| p.delay_ticks);
                (format!("delay {delay_ticks}: {varied}"), line.iter().map(|p| (measure(p), p.felt_share)).collect())
            })
            .collect();
        let series: Vec<LineSeries> =
            series.iter().map(|(name, points)| LineSeries { name, points: points.clone(), joined: true, marked: true }).collect();
        let lines = Lines {
            title: "Felt force against energy, over the account's settings",
            below: &below,
            x: ScaledAxis { title: x_title, scale },
            y: ScaledAxis { title: "share of the patch's push that is felt (1)", scale: Scale::Linear },
            series: &series,
            levels: &[],
        };
        charts::lines(folder.draft(), name, &lines)?;
    }
    Ok(())
}
