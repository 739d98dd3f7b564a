//! Result files and printed report of `fit --smallest`.

use palpate::Terms;
use palpate_charts::{Dot, Figure, Level, Plot, ScaledAxis, Series};
use palpate_fit::plan::{Bench, Effort, JudgedCandidate, Outcome, RimTreatment};
use palpate_fit::scene_fit::WORST_RATIO;
use palpate_tissue::budget::CostModel;
use palpate_tissue::fit_record::FitRecord;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;

use super::Written;
use super::board::{Load, file};
use super::report::record;
use super::worth::{self, Worth};
use crate::error::Error;

/// Ratio of the budget to the largest cost above which the budget is not drawn (1).
const FAR_BUDGET: f64 = 6.0;

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    board: &'a str,
    unit: &'a str,
    budget_units: f64,
    tolerance_pct: f64,
    quick: bool,
    patch: Option<&'a str>,
    record: Option<&'a FitRecord>,
    chosen: Option<&'a JudgedCandidate>,
    /// Terms of the scene, with the cost and the error of omitting each from the chosen model.
    terms: &'a [Worth],
    next_smaller: Option<&'a JudgedCandidate>,
    next_larger: Option<&'a JudgedCandidate>,
    elsewhere: Option<&'a JudgedCandidate>,
    elsewhere_board: Option<&'static str>,
    tightest_here: Option<&'a JudgedCandidate>,
    trials: &'a [JudgedCandidate],
}

/// Writes and prints the report; returns the written patch, if a model was found.
pub(super) fn write(
    folder: OutputFolder,
    bench: &Bench,
    outcome: &Outcome,
    ceiling_n_per_m: f32,
    all: bool,
) -> Result<Option<Written>, Error> {
    let (scene, machine) = (bench.scene, bench.machine);
    let (mut terms, mut written) = (Vec::new(), None);
    if let Some((chosen, session)) = outcome.chosen.as_ref().and_then(|t| Some((t, t.session.as_ref()?))) {
        let (name, bytes) = file(session, scene, machine, ceiling_n_per_m)?;
        let mut record = record(scene, session, &chosen.judged, &bench.presses.fitted_m, &bytes)?;
        record.reference_error_pct = Some(100.0 * bench.presses.error);
        record.quick = bench.quick;
        folder.write(&name, &bytes)?;
        record.write(&folder, &name)?;
        let (board, unit) = (machine.name.to_owned(), machine.unit.to_owned());
        let load = Load { board, substeps: chosen.substeps, units: chosen.units, budget: machine.budget(), unit };
        terms = worth::of(machine, &chosen.counts, &session.params);
        let model = format!("{} nodes", record.nodes);
        written = Some(Written { name, record, model, load: Some(load) });
    }
    folder.write_summary(&Summary {
        scene: &scene.name,
        board: machine.name,
        unit: machine.unit,
        budget_units: machine.budget(),
        tolerance_pct: bench.tolerance_pct,
        quick: bench.quick,
        patch: written.as_ref().map(|written| written.name.as_str()),
        record: written.as_ref().map(|written| &written.record),
        chosen: outcome.chosen.as_ref(),
        terms: &terms,
        next_smaller: outcome.smaller.as_ref(),
        next_larger: outcome.larger.as_ref(),
        elsewhere: outcome.elsewhere.as_ref(),
        elsewhere_board: outcome.elsewhere.as_ref().and_then(JudgedCandidate::slowest_board).map(|m| m.name),
        tightest_here: outcome.tightest.as_ref(),
        trials: &outcome.trials,
    })?;
    let header = ["nodes", "radius_radii", "element_radii", "points", "full_fit", "substeps", "units", "rms_pct", "worst_pct"];
    let row = |t: &JudgedCandidate| {
        let c = &t.candidate;
        [
            t.counts.nodes as f64,
            c.radius_radii,
            c.element_radii,
            c.points_per_triangle as f64,
            f64::from(u8::from(t.effort == Effort::Full)),
            f64::from(t.substeps),
            t.units,
            t.judged.rms_pct(),
            t.judged.worst_pct(),
        ]
    };
    folder.write_csv("searched.csv", header, outcome.trials.iter().map(row))?;
    draw(&folder, bench, outcome)?;
    let out = folder.publish()?;
    print(bench, outcome, &terms, all);
    let patch = written.as_ref().map_or_else(String::new, |written| format!("{}, its record beside it, ", written.name));
    println!("wrote {}: {patch}summary.json, searched.csv, searched.svg, searched.png", out.display());
    Ok(written)
}

/// Name of the unit of a cost in tables and charts, and the number by which a cost is divided to
/// have this unit.
fn unit(machine: &CostModel) -> (&'static str, f64) {
    if machine.unit == "ns" { ("us", 1e3) } else { ("k cycles", 1e3) }
}

/// Models that stand out, with their names in the table.
fn named(outcome: &Outcome) -> impl Iterator<Item = (&'static str, &JudgedCandidate)> {
    let all = [
        ("next smaller", &outcome.smaller),
        ("CHOSEN", &outcome.chosen),
        ("next larger", &outcome.larger),
        ("does, on a faster board", &outcome.elsewhere),
        ("best of this board", &outcome.tightest),
    ];
    all.into_iter().filter_map(|(what, trial)| Some((what, trial.as_ref()?)))
}

/// Name of what a trial omits or replaces; `None` for rim springs with volume and compensation.
fn omitted(edge: RimTreatment, terms: Terms) -> Option<String> {
    match edge {
        RimTreatment::RimSprings if !terms.volume => Some("without volume".into()),
        RimTreatment::RimSprings if !terms.compensation => Some("without compensation".into()),
        RimTreatment::RimSprings => None,
        other => Some(other.name().into()),
    }
}

/// Name of the group to which a trial belongs in the chart.
fn kind(trial: &JudgedCandidate) -> String {
    omitted(trial.edge, trial.terms).unwrap_or_else(|| format!("radius {} R, rim springs", trial.candidate.radius_radii))
}

fn draw(folder: &OutputFolder, bench: &Bench, outcome: &Outcome) -> Result<(), Error> {
    let (machine, tolerance_pct) = (bench.machine, bench.tolerance_pct);
    let (unit, per) = unit(machine);
    let mut kinds: Vec<String> = outcome.trials.iter().map(kind).collect();
    // radii come first, in their order, then the trials that omit something
    kinds.sort_by_key(|k| (!k.starts_with("radius"), k.clone()));
    kinds.dedup();
    let chosen = outcome.chosen.as_ref();
    let dot = |t: &JudgedCandidate| {
        let ringed = chosen.is_some_and(|c| (c.candidate, c.edge, c.terms, c.effort) == (t.candidate, t.edge, t.terms, t.effort));
        let label = if ringed { format!("chosen: {} nodes", t.counts.nodes) } else { String::new() };
        Dot { ringed, label, hollow: t.effort != Effort::Full, ..Dot::from((t.units / per, t.keeps_pct)) }
    };
    let series = kinds.iter().map(|name| {
        let trials = outcome.trials.iter().filter(|t| kind(t) == *name);
        Series::dots(name.as_str(), trials.map(dot).collect())
    });
    let x = ScaledAxis::log(format!("cost of a tick [{unit}]"));
    let y = ScaledAxis::log("force error: rms, or worst / 2.5 where that is more [%]");
    let wanted = Level::new(format!("tolerance: {tolerance_pct} %"), tolerance_pct);
    let budget = machine.budget() / per;
    let dearest = outcome.trials.iter().map(|t| t.units / per).fold(0.0, f64::max);
    // a budget far beyond every model would leave no room for them
    let drawn = (budget <= FAR_BUDGET * dearest).then(|| Level::new("budget", budget));
    let plot = Plot { budget: drawn, ..Plot::new(x, y, series.collect()).levels([wanted]) };
    let title = format!("{}: what keeps {tolerance_pct} % on {}", bench.scene.name, machine.name);
    let below = format!("at most {budget:.0} {unit} per tick (estimate); filled: full fit; hollow: short fit; R: probe radius");
    Ok(Figure::plot("searched", title, below, plot).draw(folder.draft())?)
}

fn print(bench: &Bench, outcome: &Outcome, terms: &[Worth], all: bool) {
    let ((name, per), fitted_m) = (unit(bench.machine), &bench.presses.fitted_m);
    println!(
        "force error at places that no fit saw, within a probe radius of the site, {:.2} to {:.2} mm deep: rms % and worst %",
        fitted_m.first().copied().unwrap_or_default() * 1e3,
        fitted_m.last().copied().unwrap_or_default() * 1e3
    );
    println!("shear %: error that the patch's edge makes on a glued disc; {name}: cost per tick (estimate)");
    println!("radius: of the patch, and elements: their size, in probe radii; points: contact points per surface triangle\n");
    let header =
        ["nodes", "radius", "elements", "points", "substeps", name, "RAM+flash", "rms %", "worst %", "shear %", "moving %"];
    let line = |what: &str, cells: [String; 11]| {
        let widths = [5, 6, 8, 6, 8, 9, 9, 7, 8, 8, 8];
        let cells: Vec<String> = cells.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        println!("{what:<28} {}", cells.join(" "));
    };
    line("", header.map(str::to_owned));
    let or_dash = |number: Option<f64>| number.map_or_else(|| "-".into(), |number| format!("{number:.2}"));
    let row = |what: &str, t: &JudgedCandidate| {
        let c = &t.candidate;
        let cells = [
            t.counts.nodes.to_string(),
            c.radius_radii.to_string(),
            c.element_radii.to_string(),
            c.points_per_triangle.to_string(),
            t.substeps.to_string(),
            format!("{:.1}", t.units / per),
            format!("{:.1} kB", (t.ram_bytes + t.patch_bytes) as f64 * 1e-3),
            format!("{:.2}", t.judged.rms_pct()),
            format!("{:+.2}", t.judged.worst_pct()),
            or_dash(t.shear_error_pct),
            or_dash(t.moving.map(|m| m.rms_pct)),
        ];
        line(what, cells);
    };
    for (what, trial) in named(outcome) {
        let omitted = omitted(trial.edge, trial.terms).map_or_else(String::new, |omitted| format!(", {omitted}"));
        row(&format!("{what}{omitted}"), trial);
    }
    let (tolerance_pct, shown) = (bench.tolerance_pct, outcome.chosen.as_ref().or(outcome.tightest.as_ref()));
    let mut most = [const { String::new() }; 11];
    most[5] = format!("{:.1}", bench.machine.budget() / per);
    most[7] = format!("{tolerance_pct:.2}");
    most[8] = format!("{:.2}", WORST_RATIO * tolerance_pct);
    most[9] = format!("{tolerance_pct:.2}");
    most[10] = or_dash(shown.and_then(|t| t.moving).filter(|m| m.asked).map(|m| m.allowed_pct));
    line("at most", most);
    let less = |t: &&JudgedCandidate| omitted(t.edge, t.terms).is_some();
    for trial in outcome.trials.iter().filter(|_| all).filter(less) {
        let short = if trial.effort == Effort::Screened { " (short)" } else { "" };
        row(&format!("{}{short}", kind(trial)), trial);
    }
    for (_, edge, terms) in outcome.unfitted.iter().filter(|_| all) {
        if let Some(what) = omitted(*edge, *terms) {
            println!("{what:<28} cannot be fitted or pressed to its depth");
        }
    }
    println!(
        "\n{} models tried{}{}",
        outcome.trials.len(),
        if all { "" } else { " (--all prints those without a term)" },
        if outcome.chosen.is_some() {
            ": the chosen one is the cheapest found that keeps every limit in the row *at most*"
        } else {
            ""
        }
    );
    if let Some(moving) = outcome.chosen.as_ref().and_then(|t| t.moving) {
        println!(
            "moving %: force error at up to {:.0} mm/s in the worst motion tried (of the chosen model: {})",
            moving.speed_m_per_s * 1e3,
            moving.motion
        );
    }
    for Worth { term, cost_pct, error } in terms {
        println!("without {term}: cost of the tick {cost_pct:+.1} %, {error}");
    }
}
