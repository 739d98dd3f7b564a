//! The tables and pictures of a sliding report.

use std::fmt::Write;

use super::measured::Measured;
use super::measured::TOLERANCE_PCT;
use super::trajectory::Leg;
use super::{DEPTH_M, Kind, Sliding};
use crate::error::Error;
use palpate_charts::{Level, LineSeries, Lines, Scale, ScaledAxis, lines};
use palpate_fit::calibrate::targets::Reference;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::TICK_S;

/// Young's modulus of the default block [Pa].
const YOUNGS_MODULUS_PA: f64 = 3500.0;

/// Writes `sliding.csv`, `sliding_stroke.csv` and `slide_<n>.csv`.
pub(super) fn write(folder: &OutputFolder, sliding: &Sliding, reference: &impl Reference) -> Result<(), Error> {
    let mut text = String::from(
        "method,kind,nodes,springs,tets,rim_nodes,rim_edges,substeps,stable_ms,m4f_168_pct,m7_480_pct,rest_worst_pct,rest_rms_pct,rim_pct,speed_mm_per_s,\
         worst_pct,rms_pct,mean_pct,step_n,region_step_n,lateral_pct,lateral_worst_pct,work_mj,awake_least_pct,awake_mean_pct,hold_awake_pct,tick_us,leaves_at_mm_per_s\n",
    );
    let cell = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    for (n, m) in sliding.methods.iter().enumerate() {
        let board = |name: &str| cell(m.boards.iter().find(|b| b.machine == name).map(|b| b.share_pct));
        for (speed_mm_per_s, figures) in &m.slides {
            let of = |pick: fn(&super::Figures) -> f64| cell(figures.as_ref().map(pick));
            let row = [
                m.name.clone(),
                m.kind.name().into(),
                m.nodes.to_string(),
                m.springs.to_string(),
                m.tets.to_string(),
                m.rim[0].to_string(),
                m.rim[1].to_string(),
                m.substeps.to_string(),
                m.stable_ms.to_string(),
                board("m4f-168"),
                board("m7-480"),
                cell(m.rest_pct.map(|r| r[0])),
                cell(m.rest_pct.map(|r| r[1])),
                cell(m.rim_pct),
                speed_mm_per_s.to_string(),
                of(|f| f.worst_pct),
                of(|f| f.rms_pct),
                of(|f| f.mean_pct),
                of(|f| f.step_n),
                of(|f| f.region_step_n),
                of(|f| f.lateral_pct),
                of(|f| f.lateral_worst_pct),
                of(|f| f.work_mj),
                of(|f| f.awake_pct[0]),
                of(|f| f.awake_pct[1]),
                of(|f| f.hold_awake_pct),
                of(|f| f.tick_us),
                cell(m.leaves_at_mm_per_s),
            ];
            let _ = writeln!(text, "{}", row.join(","));
        }
        let wanted = |along_m: f64| reference.force(m.trace.trajectory.place_m(along_m), DEPTH_M).unwrap_or(f64::NAN);
        let rows = m.trace.rows.iter().enumerate().map(|(tick, r)| {
            let reference_n = YOUNGS_MODULUS_PA * wanted(r.pose.along_m);
            let f = r.force_n;
            let depth_m = -r.pose.tip_m.z;
            [tick as f64 * TICK_S, r.pose.along_m, depth_m, f.x, f.y, f.z, reference_n, f64::from(r.active_nodes)]
        });
        let header =
            ["t_s", "along_m", "depth_m", "force_x_n", "force_y_n", "force_z_n", "reference_at_course_depth_n", "active_nodes"];
        folder.write_csv(&format!("slide_{n}.csv"), header, rows)?;
    }
    folder.write("sliding.csv", text.as_bytes())?;
    let strokes = sliding.strokes.iter().map(|s| {
        let of = |name: &str| s.share_pct.iter().find(|p| p.0 == name).map_or(f64::NAN, |p| p.1);
        [s.stroke_mm, s.nodes as f64, s.tets as f64, of("m4f-168"), of("m7-480")]
    });
    Ok(folder.write_csv("sliding_stroke.csv", ["stroke_mm", "nodes", "tets", "m4f_168_pct", "m7_480_pct"], strokes)?)
}

/// Draws `sliding_force`, `sliding_error` and `sliding_speed`.
pub(super) fn draw(folder: &OutputFolder, sliding: &Sliding, reference: &impl Reference) -> Result<(), Error> {
    let path = folder.draft();
    let below = format!(
        "{} mm forth at {} mm/s, {} mm deep, block 80 x 80 x 40 mm, {YOUNGS_MODULUS_PA} Pa",
        sliding.stroke_mm, sliding.speed_mm_per_s, sliding.depth_mm
    );
    let linear = |title| ScaledAxis { title, scale: Scale::Linear };
    let shown = shown(&sliding.methods);
    let forth = |m: &Measured, of: &dyn Fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
        let rows = m.trace.rows.iter().filter(|r| r.pose.leg == Leg::Forth);
        rows.map(|r| (r.pose.along_m * 1e3, of(r.pose.along_m, r.force_n.z))).collect()
    };
    let wanted_n = |along_m: f64| {
        let place_m = shown.first().map(|m| m.trace.trajectory.place_m(along_m)).unwrap_or_default();
        YOUNGS_MODULUS_PA * reference.force(place_m, DEPTH_M).unwrap_or(f64::NAN)
    };
    let half_mm = 0.5 * sliding.stroke_mm;
    let band = |share: f64| -> Vec<(f64, f64)> {
        (-30..=30).map(|n| f64::from(n) / 30.0 * half_mm).map(|mm| (mm, share * wanted_n(mm * 1e-3))).collect()
    };
    let line = |name, points| LineSeries { name, points, joined: true, marked: false };
    // closed outline of the tolerance band
    let mut around = band(1.0 + 0.01 * TOLERANCE_PCT);
    around.extend(band(1.0 - 0.01 * TOLERANCE_PCT).into_iter().rev());
    around.extend(around.first().copied());
    let mut series = vec![line("reference", band(1.0)), line("5 % band", around)];
    series.extend(shown.iter().filter(|m| m.kind != Kind::Round).map(|m| line(&m.short, forth(m, &|_, n| n))));
    series.retain(|s| !s.points.is_empty());
    let along = linear("place along the way [mm]");
    let picture = Lines {
        title: "Normal force of a sliding probe",
        below: &below,
        x: along,
        y: linear("normal force [N]"),
        series: &series,
        levels: &[],
    };
    lines(path, "sliding_force", &picture)?;
    let near = |m: &&&Measured| matches!(m.kind, Kind::Stroke | Kind::Stays | Kind::Round | Kind::Whole);
    let error = |along_m: f64, force_n: f64| 100.0 * (force_n / wanted_n(along_m) - 1.0);
    let series: Vec<LineSeries> =
        shown.iter().filter(near).map(|m| line(m.short.as_str(), forth(m, &error))).filter(|s| !s.points.is_empty()).collect();
    let levels = [Level { name: "+5 %", y: TOLERANCE_PCT }, Level { name: "-5 %", y: -TOLERANCE_PCT }];
    let picture = Lines {
        title: "Error of the normal force of a sliding probe, every node awake",
        below: &below,
        x: along,
        y: linear("force error [%]"),
        series: &series,
        levels: &levels[..],
    };
    lines(path, "sliding_error", &picture)?;
    let against = |m: &Measured| -> Vec<(f64, f64)> {
        m.slides.iter().filter_map(|(v, f)| Some((*v, f.as_ref()?.worst_pct.abs()))).collect()
    };
    let series: Vec<LineSeries> = shown
        .iter()
        .map(|m| LineSeries { name: &m.short, points: against(m), joined: true, marked: true })
        .filter(|s| !s.points.is_empty())
        .collect();
    let picture = Lines {
        title: "Largest force error of a sliding probe against its speed",
        below: "forth and back; the reference is at rest at every place",
        x: ScaledAxis { title: "speed [mm/s]", scale: Scale::Log },
        y: ScaledAxis { title: "largest force error [%]", scale: Scale::Log },
        series: &series,
        levels: &levels[..1],
    };
    Ok(lines(path, "sliding_speed", &picture)?)
}

/// Picks one method of each kind and the two highest thresholds of the stress rule: more curves
/// could not be told apart in one picture.
fn shown(methods: &[Measured]) -> Vec<&Measured> {
    let mut shown: Vec<&Measured> = Vec::new();
    for kind in [Kind::Stroke, Kind::Fixed, Kind::Stays, Kind::Round, Kind::Whole] {
        shown.extend(methods.iter().find(|m| m.kind == kind));
    }
    shown.extend(methods.iter().filter(|m| m.kind == Kind::StressRule).take(2));
    shown
}
