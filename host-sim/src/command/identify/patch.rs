//! From an identified scene to a patch for a board, and its force beside the data.

use std::path::Path;

use clap::Parser;
use palpate::ProbePose;
use palpate_fit::identify::record::Record;
use palpate_fit::identify::study::{Identified, Judged, rms_pct};
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::{Change, Drive, Scene, TICK_S};
use palpate_tissue::session::Session;

use crate::command::Cli;
use crate::error::Error;

/// Board of the patch.
pub(super) const BOARD: &str = "m4f-168";

/// Time of a test after which a patch is not compared any more [s].
const LONGEST_S: f64 = 1000.0;
/// Part of a tick by which a row may come before it (1): rounding of the times.
const SAME_TICK: f64 = 1e-6;
/// Ticks from the air to the first row of a test.
const LEAD_TICKS: usize = 50;
/// Relative difference up to which two depths are the same (1).
const SAME: f64 = 1e-3;

/// A test beside the patch that is pressed as in it.
pub(super) struct Beside {
    /// Rms differences over the peak [%] in press, hold and retreat, as far as they are compared;
    /// not a number without such rows.
    pub rms_pct: [f64; 3],
    /// Those of the identified tissue in the same rows.
    tissue_rms_pct: [f64; 3],
    /// Force of the patch in the first rows of the record, as far as they are compared [N].
    pub force_n: Vec<f64>,
}

fn is_law(options: &[String]) -> bool {
    options.iter().any(|option| option == "--law")
}

/// Name for people of the model that `fit` makes with some options.
pub(super) fn name(options: &[String]) -> String {
    format!("{} for {BOARD}", if is_law(options) { "law" } else { "patch" })
}

/// How far a model is off the tests in a segment, if by more than the tolerance of its fit beside
/// what the identified tissue itself is off there [%], and which rows were not compared.
pub(super) fn far_off(beside: &[Beside], records: &[Record], name: &str, tolerance_pct: f64) -> Option<String> {
    let segments = beside.iter().flat_map(|test| test.rms_pct.into_iter().zip(test.tissue_rms_pct));
    let over = segments.map(|(pct, tissue_pct)| (pct, tissue_pct.hypot(tolerance_pct))).filter(|(pct, most)| pct > most);
    let worst = over.max_by(|(a, _), (b, _)| a.total_cmp(b));
    let worst = worst.map(|(pct, most)| format!("the {name} is {pct:.1} % rms of the peak off the data, {most:.1} % is allowed"));
    let cut = beside.iter().zip(records).find(|(test, record)| test.force_n.len() < record.time_s.len());
    let cut = cut.map(|(test, record)| {
        let at_s = record.time_s[test.force_n.len()] - record.time_s[0];
        format!(
            "the {name} was compared with {} up to {at_s:.2} s only, as it ends at a smaller depth or after {LONGEST_S} s",
            record.name
        )
    });
    let said: Vec<String> = worst.into_iter().chain(cut).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// Fits a patch to the scene with some options, and presses it as in the tests. Returns each test
/// beside it, and why `fit` does not promise the patch, if it does not.
pub(super) fn fit_and_judge(
    scene: &Path,
    options: &[String],
    out: &Path,
    found: &Identified,
    records: &[Record],
) -> Result<(Vec<Beside>, Option<String>), Error> {
    let (scene, folder) = (scene.display().to_string(), out.display().to_string());
    let line = ["palpate", "fit", "--scene", &scene, "--out", &folder];
    let line: Vec<&str> = line.into_iter().chain(options.iter().map(String::as_str)).collect();
    println!("\n$ {}", line.join(" "));
    let fit = Cli::try_parse_from(line).map_err(|error| TissueError::Usage(error.to_string()))?.run();
    // the patch is judged even if it is further off finite elements than `fit` promises
    let unpromised = match fit {
        Err(Error::Tissue(TissueError::Check(why))) => Some(why),
        fit => fit.map(|()| None)?,
    };
    let kind = if is_law(options) { "law" } else { BOARD };
    let patch = format!("{}-{kind}.patch", Scene::load_with(&scene, &[])?.name);
    let path = out.canonicalize().unwrap_or_else(|_| out.into()).join(patch);
    println!("\n{} beside the data, in % rms of the peak:", name(options));
    let beside = records.iter().zip(&found.tests).map(|(record, test)| {
        let beside = beside(&scene, options, &path, found.delay_s, (record, test))?;
        let said = |n: usize| match beside.rms_pct[n].is_nan() {
            true => format!("not compared (none, deeper than the patch, or after {LONGEST_S} s)"),
            false => format!("{:.2} (the tissue {:.2})", beside.rms_pct[n], beside.tissue_rms_pct[n]),
        };
        println!("  {}: press {}, hold {}, retreat {}", record.name, said(0), said(1), said(2));
        Ok(beside)
    });
    Ok((beside.collect::<Result<_, Error>>()?, unpromised))
}

/// Presses a patch of a scene as in a test, and judges both it and the identified tissue.
fn beside(
    scene: &str,
    options: &[String],
    patch: &Path,
    delay_s: f64,
    (record, test): (&Record, &Judged),
) -> Result<Beside, Error> {
    let own = Scene::load_with(scene, &[])?;
    let most_m = match &own.drive {
        Drive::Depth { holds_m, .. } => holds_m.iter().copied().fold(0.0, f64::max),
        _ => test.depth_m,
    };
    let mut changes =
        vec![format!("solver.patch={}", patch.display()), format!("drive.holds_m=[{:?}]", test.depth_m.min(most_m))];
    let set = options.iter().position(|option| option == "--set");
    changes.extend(set.and_then(|at| options.get(at + 1)).cloned());
    let changes = changes.iter().map(|change| change.parse().map_err(TissueError::Usage)).collect::<Result<Vec<Change>, _>>()?;
    let session = Session::prepare(&Scene::load_with(scene, &changes)?)?;
    let depths_m = record.delayed_m(delay_s, test.contact_m);
    // a patch may meet its first tips in air only
    let air_m = depths_m[0].min(-2.0 * record.speed_m_per_s() * TICK_S);
    let since_s = record.time_s.iter().map(|time_s| time_s - record.time_s[0]);
    let compared = since_s.zip(&depths_m).take_while(|(at_s, depth_m)| **depth_m <= most_m * (1.0 + SAME) && *at_s <= LONGEST_S);
    let rows: Vec<(f64, f64)> = compared.map(|(at_s, depth_m)| (at_s / TICK_S, *depth_m)).collect();
    let force_n = pressed_n(&session, air_m, &rows)?;
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let segments = [&record.segments.press, &record.segments.hold, &record.segments.retreat];
    let rms_pct = |of_n: &[f64]| {
        segments.map(|rows| {
            let rows = rows.start..rows.end.min(force_n.len());
            if rows.is_empty() { f64::NAN } else { rms_pct(&of_n[rows.clone()], &record.force_n[rows], peak_n) }
        })
    };
    Ok(Beside { rms_pct: rms_pct(&force_n), tissue_rms_pct: rms_pct(&test.model_n), force_n })
}

/// Moves the tip of a session tick by tick, from the air through rows of time [ticks] and
/// depth [m]; returns the force along the axis at each row [N].
fn pressed_n(session: &Session, air_m: f64, rows: &[(f64, f64)]) -> Result<Vec<f64>, Error> {
    let model = session.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &session.params)?;
    let mut press = |depth_m: f64| {
        let output = palpate::tick(&model, &tuned, &mut state, ProbePose { tip_m: session.tip_m(depth_m) });
        let force_n = f64::from(output.force_n.dot(&session.params.probe.axis));
        let why = |fault| TissueError::Check(format!("the patch does not press as in the test: {fault}"));
        output.fault.map_or(Ok(force_n), |fault| Err(why(fault)))
    };
    let first_m = rows.first().map_or(air_m, |(_, depth_m)| *depth_m);
    for k in 0..LEAD_TICKS {
        press(air_m + (first_m - air_m) * k as f64 / LEAD_TICKS as f64)?;
    }
    let (mut force_n, mut now_n, mut ticks) = (Vec::new(), 0.0, 0.0);
    for (n, (at, depth_m)) in rows.iter().enumerate() {
        // a row has the force of the last tick before it; rows within a tick have the same one
        let (from, from_m) = rows[n.saturating_sub(1)];
        while ticks <= *at + SAME_TICK {
            let share = if n == 0 { 1.0 } else { (ticks - from) / (at - from) };
            now_n = press(from_m + (depth_m - from_m) * share)?;
            ticks += 1.0;
        }
        force_n.push(now_n);
    }
    Ok(force_n)
}
