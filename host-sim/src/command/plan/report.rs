//! Result files and printed report of `plan`.

use palpate::Terms;
use serde::Serialize;

use super::super::cut::write_patch;
use super::super::verdict::Verdict;
use super::unit;
use super::worth::{self, Worth};
use crate::error::Error;
use palpate_charts::{Dot, Figure, Level, Plot, ScaledAxis, Series};
use palpate_fit::far_field::fitted::JUDGED_RADII;
use palpate_fit::plan::{self as planned, Bench, Effort, Judge, JudgedCandidate, Outcome, RimTreatment, WORST_RATIO};
use palpate_tissue::budget::CostModel;
use palpate_tissue::fit_record::{Judged, Moving};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::session::moving::MovingReport;

/// Ratio of the budget to the largest cost above which the budget is not drawn (1).
const FAR_BUDGET: f64 = 6.0;

#[derive(Serialize)]
struct Promise<'a> {
    tolerance_pct: f64,
    worst_tolerance_pct: f64,
    /// Radius around the site in which the errors are judged [m].
    radius_m: f64,
    depths_m: &'a [f64],
    rms_pct: f64,
    worst_pct: f64,
    centred_rms_pct: f64,
    centred_worst_pct: f64,
    unseen_places: usize,
    /// Error while the probe moves at the speed that the scene gives.
    moving: Option<MovingReport>,
    holds: bool,
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    board: &'a str,
    unit: &'a str,
    budget_units: f64,
    tolerance_pct: f64,
    quick: bool,
    patch: Option<String>,
    promise: Option<Promise<'a>>,
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

/// Writes and prints the report; returns the name of the patch file, if a model was found.
pub(super) fn write(
    folder: OutputFolder,
    bench: &Bench,
    outcome: &Outcome,
    ceiling_n_per_m: f32,
    all: bool,
) -> Result<Option<String>, Error> {
    let (scene, machine) = (bench.scene, bench.machine);
    let chosen = outcome.chosen.as_ref().and_then(|t| Some((t, t.session.as_ref()?)));
    let patch = chosen
        .map(|(chosen, session)| {
            let judged = in_record(bench.judge, &chosen.judged, scene.probe.radius_m);
            let moving = chosen.moving.map(|m| Moving { speed_m_per_s: m.speed_m_per_s, rms_pct: m.rms_pct });
            write_patch(&folder, scene, session, (machine, ceiling_n_per_m), judged, moving).map(|(name, _)| name)
        })
        .transpose()?;
    let promise = outcome.chosen.as_ref().map(|t| Promise {
        tolerance_pct: bench.tolerance_pct,
        worst_tolerance_pct: WORST_RATIO * bench.tolerance_pct,
        radius_m: JUDGED_RADII * scene.probe.radius_m,
        depths_m: &bench.judge.depths_m,
        rms_pct: t.judged.rms_pct,
        worst_pct: t.judged.worst_pct,
        centred_rms_pct: t.judged.centred_rms_pct,
        centred_worst_pct: t.judged.centred_worst_pct,
        unseen_places: t.judged.places,
        moving: t.moving,
        holds: t.keeps(bench.tolerance_pct) && t.fits,
    });
    let session = |t: &JudgedCandidate| t.session.as_ref().map(|session| worth::of(machine, &t.counts, &session.params));
    let terms = outcome.chosen.as_ref().and_then(session).unwrap_or_default();
    let summary = Summary {
        scene: &scene.name,
        board: machine.name,
        unit: machine.unit,
        budget_units: machine.budget(),
        tolerance_pct: bench.tolerance_pct,
        quick: bench.quick,
        patch,
        promise,
        chosen: outcome.chosen.as_ref(),
        terms: &terms,
        next_smaller: outcome.smaller.as_ref(),
        next_larger: outcome.larger.as_ref(),
        elsewhere: outcome.elsewhere.as_ref(),
        elsewhere_board: outcome.elsewhere.as_ref().and_then(JudgedCandidate::slowest_board).map(|m| m.name),
        tightest_here: outcome.tightest.as_ref(),
        trials: &outcome.trials,
    };
    folder.write_summary(&summary)?;
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
            t.judged.rms_pct,
            t.judged.worst_pct,
        ]
    };
    folder.write_csv("searched.csv", header, outcome.trials.iter().map(row))?;
    draw(&folder, bench, outcome)?;
    let out = folder.publish()?;
    let _said = verdict(outcome, machine, bench.tolerance_pct)?.first();
    print(bench, outcome, &terms, all);
    println!(
        "wrote {}: {}summary.json, searched.csv, plan.svg, plan.png",
        out.display(),
        summary.patch.as_ref().map_or_else(String::new, |name| format!("{name}, "))
    );
    Ok(summary.patch)
}

/// Converts the errors of the chosen patch to the form of its record: of those at the centre and
/// those elsewhere, the larger one counts.
fn in_record(judge: &Judge, found: &planned::Judged, probe_radius_m: f64) -> Judged {
    let worst_pct = if found.centred_worst_pct.abs() > found.worst_pct.abs() { found.centred_worst_pct } else { found.worst_pct };
    Judged {
        rms_pct: found.rms_pct.max(found.centred_rms_pct),
        worst_pct,
        from_m: judge.depths_m.first().copied().unwrap_or_default(),
        to_m: judge.depths_m.last().copied().unwrap_or_default(),
        places: found.places,
        lost_presses: 0,
        disc_radius_m: JUDGED_RADII * probe_radius_m,
        bump: None,
        glued: None,
        surface: None,
    }
}

/// Says which model was chosen, or why none was.
pub(super) fn verdict(outcome: &Outcome, machine: &CostModel, tolerance_pct: f64) -> Result<Verdict, Error> {
    let found = outcome.check(machine, tolerance_pct);
    let words = found.as_ref().map_or_else(
        |_| String::new(),
        |chosen| {
            format!(
                "{} nodes keep {tolerance_pct} % on {}: {:.2} % rms, {:+.2} % at worst; a tick takes {:.0} % of the {} that it may take (estimate)",
                chosen.counts.nodes,
                machine.name,
                chosen.judged.rms_pct,
                chosen.judged.worst_pct,
                100.0 * chosen.units / machine.budget(),
                machine.unit
            )
        },
    );
    Verdict::of(found.map(|_| ()), || words)
}

/// Returns the name of the group to which a trial belongs in a chart.
fn kind(trial: &JudgedCandidate) -> String {
    named(trial.edge, trial.terms).unwrap_or_else(|| format!("radius {} R, rim springs", trial.candidate.radius_radii))
}

/// Returns the name of what `edge` and `terms` omit or replace; `None` for rim springs with volume
/// and compensation.
fn named(edge: RimTreatment, terms: Terms) -> Option<String> {
    match edge {
        RimTreatment::RimSprings if !terms.volume => Some("without volume".into()),
        RimTreatment::RimSprings if !terms.compensation => Some("without compensation".into()),
        RimTreatment::RimSprings => None,
        other => Some(other.name().into()),
    }
}

fn draw(folder: &OutputFolder, bench: &Bench, outcome: &Outcome) -> Result<(), Error> {
    let (machine, scene) = (bench.machine, bench.scene);
    let (name, per) = unit(machine);
    let mut kinds: Vec<String> = outcome.trials.iter().map(kind).collect();
    // radii come first, in their order, then the trials that omit something
    kinds.sort_by_key(|k| (!k.starts_with("radius"), k.clone()));
    kinds.dedup();
    let same = |a: &JudgedCandidate, b: &Option<JudgedCandidate>| {
        b.as_ref().is_some_and(|b| (a.candidate, a.edge, a.terms, a.effort) == (b.candidate, b.edge, b.terms, b.effort))
    };
    let dot = |t: &JudgedCandidate| {
        let chosen = same(t, &outcome.chosen);
        let label = if chosen {
            format!("chosen: {} nodes", t.counts.nodes)
        } else if same(t, &outcome.smaller) {
            format!("next smaller: {}", t.counts.nodes)
        } else if same(t, &outcome.larger) {
            format!("next larger: {}", t.counts.nodes)
        } else if same(t, &outcome.elsewhere) {
            format!("would do: {} nodes", t.counts.nodes)
        } else if same(t, &outcome.tightest) {
            format!("best here: {} nodes", t.counts.nodes)
        } else {
            String::new()
        };
        let radius_px = if chosen { 7.0 } else { 5.0 };
        Dot { radius_px, hollow: t.effort != Effort::Full, ringed: chosen, label, ..Dot::from((t.units / per, t.keeps_pct)) }
    };
    let series = kinds.iter().map(|name| {
        let trials = outcome.trials.iter().filter(|t| kind(t) == *name);
        Series::dots(name.as_str(), trials.map(dot).collect())
    });
    let x = ScaledAxis::log(format!("cost of a tick [{name}]"));
    let y = ScaledAxis::log("force error: rms, or worst / 2.5 where that is more [%]");
    let wanted = Level::new(format!("wanted: {} %", bench.tolerance_pct), bench.tolerance_pct);
    let budget = machine.budget() / per;
    let dearest = outcome.trials.iter().map(|t| t.units / per).fold(0.0, f64::max);
    // a budget far beyond every model would leave no room for them
    let drawn = (budget <= FAR_BUDGET * dearest).then(|| Level::new("budget", budget));
    let plot = Plot { budget: drawn, ..Plot::new(x, y, series.collect()).levels([wanted]) };
    let title = format!("{}: what keeps {} % on {}", scene.name, bench.tolerance_pct, machine.name);
    let below = format!(
        "at most {budget:.0} {name} per tick (estimate); filled: full fit, {} unseen places; hollow: short fit; R: probe radius",
        palpate_fit::far_field::fitted::JUDGED_PLACES * 4
    );
    Ok(Figure::plot("plan", title, below, plot).draw(folder.draft())?)
}

fn print(bench: &Bench, outcome: &Outcome, terms: &[Worth], all: bool) {
    let (name, per) = unit(bench.machine);
    println!(
        "force error at places that no fit saw, within a probe radius of the site, {:.2} to {:.2} mm deep: rms % and worst %; centred %: rms at the site",
        bench.judge.depths_m.first().copied().unwrap_or_default() * 1e3,
        bench.judge.depths_m.last().copied().unwrap_or_default() * 1e3
    );
    println!("shear %: error that the patch's edge makes on a glued disc; {name}: cost per tick (estimate)");
    println!("radius: of the patch, and elements: their size, in probe radii; points: contact points per surface triangle\n");
    println!(
        "{:<26} {:>5} {:>6} {:>8} {:>6} {:>8} {:>9} {:>9} {:>7} {:>8} {:>9} {:>8} {:>8}",
        "",
        "nodes",
        "radius",
        "elements",
        "points",
        "substeps",
        name,
        "RAM+flash",
        "rms %",
        "worst %",
        "centred %",
        "shear %",
        "moving %"
    );
    let row = |what: &str, t: &JudgedCandidate| {
        let c = &t.candidate;
        println!(
            "{what:<26} {:>5} {:>6} {:>8} {:>6} {:>8} {:>9.1} {:>6.1} kB {:>7.2} {:>+8.2} {:>9.2} {:>8} {:>8}",
            t.counts.nodes,
            c.radius_radii,
            c.element_radii,
            c.points_per_triangle,
            t.substeps,
            t.units / per,
            (t.ram_bytes + t.patch_bytes) as f64 * 1e-3,
            t.judged.rms_pct,
            t.judged.worst_pct,
            t.judged.centred_rms_pct,
            t.shear_error_pct.map_or_else(|| "-".into(), |e| format!("{e:+.2}")),
            t.moving.map_or_else(|| "-".into(), |m| format!("{:.2}", m.rms_pct))
        );
    };
    for (what, trial) in [
        ("next smaller", &outcome.smaller),
        ("CHOSEN", &outcome.chosen),
        ("next larger", &outcome.larger),
        ("does, on a faster board", &outcome.elsewhere),
        ("best of this board", &outcome.tightest),
    ] {
        if let Some(trial) = trial {
            row(what, trial);
        }
    }
    let (tolerance_pct, shown) = (bench.tolerance_pct, outcome.chosen.as_ref().or(outcome.tightest.as_ref()));
    println!(
        "{:<26} {:>5} {:>6} {:>8} {:>6} {:>8} {:>9.1} {:>9} {tolerance_pct:>7.2} {:>8.2} {:>9} {tolerance_pct:>8.2} {:>8}",
        "at most",
        "",
        "",
        "",
        "",
        "",
        bench.machine.budget() / per,
        "",
        WORST_RATIO * tolerance_pct,
        "",
        shown.and_then(|t| t.moving).map_or_else(|| "-".into(), |m| format!("{:.2}", m.allowed_pct))
    );
    let less = outcome.trials.iter().filter(|t| t.terms.rim && t.terms != Terms::ALL || t.edge != RimTreatment::RimSprings);
    for trial in less.filter(|_| all) {
        let mut what = kind(trial);
        if !trial.terms.compensation && trial.edge != RimTreatment::RimSprings {
            what.push_str(", no comp.");
        }
        if trial.effort == Effort::Screened {
            what.push_str(" (short)");
        }
        row(&what, trial);
    }
    for (_, edge, terms) in outcome.unfitted.iter().filter(|_| all) {
        if let Some(what) = named(*edge, *terms) {
            println!("{what:<26} cannot be fitted or pressed to its depth");
        }
    }
    if let Some(chosen) = &outcome.chosen
        && let Some(all) = outcome.trials.iter().find(|t| {
            (t.candidate, t.edge, t.terms, t.effort) == (chosen.candidate, RimTreatment::RimSprings, Terms::ALL, Effort::Full)
        })
        && all.units > chosen.units
    {
        println!(
            "\nleft out of the chosen one, as the tolerance does not need it: {:.1} {name} less, rms {:.2} % instead of {:.2} %",
            (all.units - chosen.units) / per,
            chosen.judged.rms_pct,
            all.judged.rms_pct
        );
    }
    let fits = outcome.trials.len();
    println!(
        "\n{fits} models tried{}{}",
        if all { "" } else { " (--all prints those without a term)" },
        if outcome.chosen.is_some() {
            ": the chosen one is the cheapest found that keeps every limit in the row *at most*"
        } else {
            ""
        }
    );
    if let Some(moving) = outcome.chosen.as_ref().and_then(|t| t.moving) {
        println!(
            "moving %: force error on the way down at {:.0} mm/s, against the same patch with almost true masses",
            moving.speed_m_per_s * 1e3
        );
    }
    for Worth { term, cost_pct, error } in terms {
        println!("without {term}: cost of the tick {cost_pct:+.1} %, {error}");
    }
}
