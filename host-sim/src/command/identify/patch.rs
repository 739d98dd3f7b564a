//! From an identified scene to a patch for a board, and its force beside the data.

use std::path::Path;

use clap::Parser;
use palpate_fit::identify::record::Record;
use palpate_fit::identify::study::{Identified, Judged};
use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::{Change, Drive, Scene};
use palpate_tissue::session::Session;

use crate::command::Cli;
use crate::error::Error;

/// Board of the patch.
pub(super) const BOARD: &str = "m4f-168";

/// Speeds [m/s] and lengths of holds [s] with which a patch is pressed.
const SPEEDS_M_PER_S: [f64; 2] = [1e-5, 1.0];
const HOLDS_S: [f64; 2] = [0.3, 100.0];
/// Relative difference up to which two depths are the same (1).
const SAME: f64 = 1e-3;

/// A test beside the patch that is pressed as in it.
pub(super) struct Beside {
    /// Rms differences over the peak [%]: at equal depths of the press, and at equal times of the
    /// hold; not a number without rows that the patch answers.
    pub rms_pct: [f64; 2],
    /// Row of the record, and force of the patch [N].
    pub force_n: Vec<(usize, f64)>,
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
    let kind = if options.iter().any(|option| option == "--law") { "law" } else { BOARD };
    let patch = format!("{}-{kind}.patch", Scene::load_with(&scene, &[])?.name);
    let path = out.canonicalize().unwrap_or_else(|_| out.into()).join(patch);
    println!("\nthe patch for {BOARD} beside the data, in % rms of the peak:");
    let beside = records.iter().zip(&found.tests).map(|(record, test)| {
        let beside = beside(&scene, options, &path, found.delay_s, (record, test))?;
        let [press, hold] = beside.rms_pct.map(|pct| match pct.is_nan() {
            true => "not compared (none, or deeper than the patch)".to_owned(),
            false => format!("{pct:.2}"),
        });
        println!("  {}: press {press}, hold {hold} (the identified model: {:.2})", record.name, found.rms_pct);
        Ok(beside)
    });
    Ok((beside.collect::<Result<_, Error>>()?, unpromised))
}

/// Presses a patch of a scene as in a test: as deep, as fast, and held as long.
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
    let deepest_m = test.depth_m.min(most_m);
    let mut changes = vec![
        format!("solver.patch={}", patch.display()),
        format!("drive.holds_m=[{deepest_m:?}]"),
        format!("drive.ramp_m_per_s={:?}", record.speed_m_per_s().clamp(SPEEDS_M_PER_S[0], SPEEDS_M_PER_S[1])),
        format!("drive.hold_s={:?}", record.hold_s().clamp(HOLDS_S[0], HOLDS_S[1])),
    ];
    let set = options.iter().position(|option| option == "--set");
    changes.extend(set.and_then(|at| options.get(at + 1)).cloned());
    let changes = changes.iter().map(|change| change.parse().map_err(TissueError::Usage)).collect::<Result<Vec<Change>, _>>()?;
    let scene = Scene::load_with(scene, &changes)?;
    let session = Session::prepare(&scene)?;
    let run = press::run(&scene, &session, |_| ())?;
    if let Some(fault) = run.fault {
        return Err(TissueError::Check(format!("the patch does not press as in the test: {fault}")).into());
    }
    let axis = session.params.probe.axis;
    let force_n: Vec<f64> = run.ticks.iter().map(|row| f64::from(row.output.force_n.dot(&axis))).collect();
    let reached = run.ticks.iter().position(|row| row.command_m > deepest_m - 1e-8).unwrap_or(0);
    let [press, hold] = [&record.segments.press, &record.segments.hold];
    let depths_m = record.delayed_m(delay_s, test.contact_m);
    let pressed = press.clone().filter_map(|n| {
        let tick = run.ticks[..reached].partition_point(|row| row.command_m < depths_m[n]);
        (depths_m[n] > 0.0 && depths_m[n] <= deepest_m).then(|| (n, force_n[tick]))
    });
    let held = hold.clone().filter_map(|n| {
        let tick = reached + (1e3 * (record.time_s[n] - record.time_s[hold.start])) as usize;
        let as_deep = test.depth_m <= most_m * (1.0 + SAME) && run.ticks.get(tick)?.command_m > deepest_m - 1e-8;
        as_deep.then(|| (n, force_n[tick]))
    });
    let parts: [Vec<(usize, f64)>; 2] = [pressed.collect(), held.collect()];
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let rms_pct = parts.each_ref().map(|part| {
        let square: f64 = part.iter().map(|(n, force_n)| (force_n - record.force_n[*n]).powi(2)).sum();
        100.0 * (square / part.len() as f64).sqrt() / peak_n
    });
    Ok(Beside { rms_pct, force_n: parts.concat() })
}
