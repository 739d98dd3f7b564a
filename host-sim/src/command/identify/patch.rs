//! From an identified scene to a patch for a board, and its force beside the data.

use std::path::Path;

use clap::Parser;
use palpate_fit::identify::record::Record;
use palpate_fit::identify::study::{Identified, Judged};
use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::{Change, Scene};
use palpate_tissue::session::Session;

use crate::command::Cli;
use crate::error::Error;

/// Board of the patch.
pub(super) const BOARD: &str = "m4f-168";

/// A test beside the patch that is pressed as in it.
pub(super) struct Beside {
    /// Rms differences over the peak [%]: at equal depths of the press, and at equal times of the
    /// hold.
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
    let change: Change = format!("solver.patch={}", out.canonicalize().unwrap_or_else(|_| out.into()).join(patch).display())
        .parse()
        .map_err(TissueError::Usage)?;
    let scene = Scene::load_with(&scene, &[change])?;
    let session = Session::prepare(&scene)?;
    let run = press::run(&scene, &session, |_| ())?;
    if let Some(fault) = run.fault {
        return Err(TissueError::Check(format!("the patch does not press as in the test: {fault}")).into());
    }
    let axis = session.params.probe.axis;
    let force_n: Vec<f64> = run.ticks.iter().map(|row| f64::from(row.output.force_n.dot(&axis))).collect();
    let deepest_m = run.ticks.iter().map(|row| row.command_m).fold(0.0, f64::max);
    let reached = run.ticks.iter().position(|row| row.command_m > deepest_m - 1e-8).unwrap_or(0);
    println!("\nthe patch for {BOARD} beside the data, in % rms of the peak:");
    let beside = |(record, test): (&Record, &Judged)| {
        let [press, hold] = [&record.segments.press, &record.segments.hold];
        let depths_m = record.delayed_m(found.delay_s, test.contact_m);
        let pressed = press.clone().filter_map(|n| {
            let depth_m = depths_m[n];
            let tick = run.ticks[..reached].partition_point(|row| row.command_m < depth_m);
            (depth_m > 0.0 && depth_m <= deepest_m).then(|| (n, force_n[tick]))
        });
        let held = hold.clone().filter_map(|n| {
            let tick = reached + (1e3 * (record.time_s[n] - record.time_s[hold.start])) as usize;
            (run.ticks.get(tick)?.command_m > deepest_m - 1e-8).then(|| (n, force_n[tick]))
        });
        let parts: [Vec<(usize, f64)>; 2] = [pressed.collect(), held.collect()];
        let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
        let rms_pct = parts.each_ref().map(|part| {
            let square: f64 = part.iter().map(|(n, force_n)| (force_n - record.force_n[*n]).powi(2)).sum();
            100.0 * (square / part.len().max(1) as f64).sqrt() / peak_n
        });
        println!(
            "  {}: press {:.2}, hold {:.2} (the identified model: {:.2})",
            record.name, rms_pct[0], rms_pct[1], found.rms_pct
        );
        Beside { rms_pct, force_n: parts.concat() }
    };
    Ok((records.iter().zip(&found.tests).map(beside).collect(), unpromised))
}
