//! Probe tips of a recorded run, for a scene that repeats the run.

use std::path::Path;

use crate::error::Error;
use crate::scene::{Drive, SceneError, TICK_S};

/// Largest coordinate of a probe in the scene's frame [m]; a larger one means a wrong unit.
const FARTHEST_M: f32 = 10.0;

/// Reads the probe tips of a recorded run [m]; empty for a drive that is not a trace.
///
/// # Errors
/// The file cannot be read, a column is missing, a number does not parse, or the rows are not one
/// tick apart.
pub fn read_tips(drive: &Drive) -> Result<Vec<[f32; 3]>, Error> {
    let Drive::Trace { trace, .. } = drive else { return Ok(Vec::new()) };
    let text = std::fs::read_to_string(trace).map_err(|source| Error::Read { path: trace.clone(), source })?;
    parse_tips(trace, &text)
}

fn parse_tips(path: &Path, text: &str) -> Result<Vec<[f32; 3]>, Error> {
    let file = path.display().to_string();
    let bad = |line: usize, why: String| SceneError::value(&format!("{file}:{line}"), "trace", &why);
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let semicolons = header.len() == 1 && header[0].contains(';');
    let fix = if semicolons {
        "its cells are separated by semicolons: save it with commas, and with points in numbers"
    } else {
        "use a trace.csv of `press`"
    };
    let column =
        |name: &str| header.iter().position(|c| *c == name).ok_or_else(|| bad(1, format!("has no column {name}: {fix}")));
    let columns = [column("probe_x_m")?, column("probe_y_m")?, column("probe_z_m")?];
    let time = header.iter().position(|c| *c == "t_s");
    let (mut tips, mut last_s) = (Vec::new(), None);
    for (n, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let mut tip = [0.0_f32; 3];
        for (value, column) in tip.iter_mut().zip(columns) {
            let cell = cells.get(column).copied().unwrap_or_default();
            let number = cell.parse().ok().filter(|v: &f32| v.is_finite());
            *value = number.ok_or_else(|| bad(n + 2, format!("\"{cell}\" is not a number: use a trace.csv of `press`")))?;
            if value.abs() > FARTHEST_M {
                return Err(bad(n + 2, format!("{cell} m is no place of a probe: give metres, at most {FARTHEST_M}")).into());
            }
        }
        tips.push(tip);
        // a column of times is optional; if there is one, consecutive rows must be one tick apart
        let Some(cell) = time.map(|t| cells.get(t).copied().unwrap_or_default()) else { continue };
        let now_s = cell.parse().ok().filter(|t: &f64| t.is_finite());
        let now_s = now_s.ok_or_else(|| bad(n + 2, format!("\"{cell}\" is not a time: use a trace.csv of `press`")))?;
        if let Some(last_s) = last_s.replace(now_s)
            && ((now_s - last_s) / TICK_S - 1.0_f64).abs() > 0.1
        {
            let what = if now_s > last_s { "leaves a gap" } else { "goes back" };
            return Err(bad(n + 2, format!("{now_s} s {what} after {last_s} s: give one row for every millisecond")).into());
        }
    }
    if tips.is_empty() {
        return Err(bad(1, "has no rows: record a run first".into()).into());
    }
    Ok(tips)
}
