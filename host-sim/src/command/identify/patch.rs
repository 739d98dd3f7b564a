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

/// Speeds for which a patch is prepared [m/s].
const SPEEDS_M_PER_S: [f64; 2] = [1e-5, 1.0];
/// Time of a test after which a patch is not compared any more [s].
const LONGEST_S: f64 = 300.0;
/// Relative difference up to which two depths are the same (1).
const SAME: f64 = 1e-3;

/// A test beside the patch that is pressed as in it.
pub(super) struct Beside {
    /// Rms differences over the peak [%] in press, hold and retreat; not a number without rows that
    /// the patch answers.
    pub rms_pct: [f64; 3],
    /// Force of the patch in the first rows of the record, as far as they are compared [N].
    pub force_n: Vec<f64>,
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
        let [press, hold, retreat] = beside.rms_pct.map(|pct| match pct.is_nan() {
            true => "not compared (none, or after the patch's depth limit)".to_owned(),
            false => format!("{pct:.2}"),
        });
        println!("  {}: press {press}, hold {hold}, retreat {retreat} (the identified model: {:.2})", record.name, found.rms_pct);
        Ok(beside)
    });
    Ok((beside.collect::<Result<_, Error>>()?, unpromised))
}

/// Moves the tip over a patch of a scene as in a test, tick by tick.
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
    let mut changes = vec![
        format!("solver.patch={}", patch.display()),
        format!("drive.holds_m=[{:?}]", test.depth_m.min(most_m)),
        format!("drive.ramp_m_per_s={:?}", record.speed_m_per_s().clamp(SPEEDS_M_PER_S[0], SPEEDS_M_PER_S[1])),
    ];
    let set = options.iter().position(|option| option == "--set");
    changes.extend(set.and_then(|at| options.get(at + 1)).cloned());
    let changes = changes.iter().map(|change| change.parse().map_err(TissueError::Usage)).collect::<Result<Vec<Change>, _>>()?;
    let session = Session::prepare(&Scene::load_with(scene, &changes)?)?;
    let model = session.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &session.params)?;
    let depths_m = record.delayed_m(delay_s, test.contact_m);
    // a patch may meet its first tip in air only
    let lead_m = 2.0 * record.speed_m_per_s() * TICK_S;
    let mut at = (record.time_s[0], depths_m[0].min(-lead_m));
    let mut force_n = Vec::new();
    for (n, depth_m) in depths_m.iter().enumerate() {
        if *depth_m > most_m * (1.0 + SAME) || record.time_s[n] - record.time_s[0] > LONGEST_S {
            break;
        }
        let ticks = ((record.time_s[n] - at.0) / TICK_S).round().max(1.0);
        for k in 1..=ticks as usize {
            let tip_m = session.tip_m(at.1 + (depth_m - at.1) * k as f64 / ticks);
            let output = palpate::tick(&model, &tuned, &mut state, ProbePose { tip_m });
            if let Some(fault) = output.fault {
                return Err(TissueError::Check(format!("the patch does not press as in the test: {fault}")).into());
            }
            force_n.resize(n + 1, 0.0);
            force_n[n] = f64::from(output.force_n.dot(&session.params.probe.axis));
        }
        at = (record.time_s[n], *depth_m);
    }
    let peak_n = record.force_n.iter().copied().fold(0.0, f64::max);
    let segments = [&record.segments.press, &record.segments.hold, &record.segments.retreat];
    let rms_pct = segments.map(|rows| match !rows.is_empty() && rows.end <= force_n.len() {
        true => rms_pct(&force_n[rows.clone()], &record.force_n[rows.clone()], peak_n),
        false => f64::NAN,
    });
    Ok(Beside { rms_pct, force_n })
}
