//! The report: tables with the paper's numbers next to ours, pictures, CSV files and summary.

use std::path::Path;

use nalgebra::Vector3;
use palpate::Fault;
use serde_json::{Value, json};

use super::assembly::Assembly;
use super::measured::{Measured, mean};
use super::method::{Rest, Setup};
use super::printed::{FULL, Printed, SPARSE, TABLE_1_MM};
use super::scene::HangingScene;
use super::steps::Steps;
use super::truth::Truth;
use super::{METHODS, PROMISED_M, PROMISED_VOLUME_PCT, Resolution, figures};
use crate::error::Error;
use crate::paper::report::{Claim, Report, print_claims, verdict};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Everything that was measured.
pub struct Findings<'a> {
    /// Scene that was simulated.
    pub scene: &'a HangingScene,
    /// Full and sparse resolution, or only the sparse one.
    pub resolutions: &'a [Resolution<'a>],
    /// The sparse resolution under its weight, starting from a stress-free shape.
    pub weighed: Option<&'a Resolution<'a>>,
    /// Finite elements of the sparse resolution with every tet cut into eight.
    pub subdivided: Option<&'a Truth>,
    /// Largest stable time steps, and forces as a function of the step.
    pub steps: &'a Steps,
    /// Whether only the sparse resolution was run.
    pub quick: bool,
    /// Duration of the run [s].
    pub elapsed_s: f64,
}

/// Writes report, pictures, CSV files and summary, and prints the results.
///
/// # Errors
/// Fails if the folder cannot be written, or if a promise of the product did not hold.
pub fn write(findings: &Findings, folder: OutputFolder) -> Result<(), Error> {
    let scene = findings.scene;
    let mut report = Report::new("Paper 000: a liver and its gallbladder, hung by a thread");
    introduce(findings, &mut report);
    for resolution in findings.resolutions {
        report.section(&format!("Table 1, {} resolution", resolution.name));
        let sizes: Vec<String> = resolution.assembly.meshes.iter().map(|m| m.tets.len().to_string()).collect();
        report.say(format!(
            "{} tets. Distances from rest and errors (13), mm. The paper's columns are porcine organs against tomography.",
            sizes.join(" + ")
        ));
        for (n, name) in scene.attachment.names.iter().enumerate() {
            markers(resolution, n, name, &mut report);
        }
        figures::fig_2(scene, resolution, &folder, &mut report)?;
        figures::fig_3(scene, resolution, &folder, &mut report)?;
    }
    report.section("Sections 3.3 and 3.4: mean errors, volume, speed");
    means(findings, &mut report);
    frames(findings, &mut report);
    failures(findings, &folder, &mut report)?;
    claims(findings, &mut report);
    let broken = broken_promises(findings);
    let summary = summary(findings, &report, &broken);
    folder.write_summary(&summary)?;
    csv(findings, &folder)?;
    let claims = report.claims().to_vec();
    folder.write("report.md", report.finish().as_bytes())?;
    print(findings, &claims, &broken, &folder.publish()?);
    if broken.is_empty() { Ok(()) } else { Err(TissueError::Check(broken.join("; ")).into()) }
}

fn mm(value_m: f64) -> String {
    format!("{:.2}", 1e3 * value_m)
}

fn introduce(findings: &Findings, report: &mut Report) {
    let Findings { scene, resolutions, subdivided, .. } = findings;
    let truth = &resolutions[0].truth;
    let weight = if scene.gravity_m_per_s2 == [0.0; 3] {
        "the rest shape is the shape under gravity"
    } else {
        "gravity on, from a stress-free shape"
    };
    report.say(format!(
        "Scene `{}`: our own shapes of a liver and a gallbladder of realistic size, joined over a fossa; posterior and Lobe 2 fixed where they face the \
         ground, Lobe 1 lifted by a stick that moves {} mm. E = {} Pa, nu = {}, {weight}. The paper's truth, tomography of a pig's organs, is not public: ours is \
         finite elements of the same scene on the same mesh (10-node tets, neo-Hookean), {} nodes and {} tets, {} Newton iterations.",
        scene.name,
        scene.attachment.moves_m.iter().map(|m| format!("{:.4}", 1e3 * Vector3::from(*m).norm())).collect::<Vec<_>>().join(" and "),
        scene.organ.iter().map(|o| o.youngs_modulus_pa.to_string()).collect::<Vec<_>>().join(" and "),
        scene.poisson_ratio,
        truth.size[0],
        truth.size[1],
        truth.iterations
    ));
    if let (Some(finer), Some(sparse)) = (subdivided, resolutions.last()) {
        let drift = |n: usize| mm(mean(&sparse.truth.moves[n].landmark_errors_m(&finer.moves[n])));
        report.say(format!(
            "How far that truth can be trusted: with every tet of the sparse mesh cut into eight ({} tets), supports and stick on the same nodes, the elements put the landmarks {} mm \
             elsewhere on average. Errors below are errors on the same mesh. Between the two resolutions the scene itself differs, because supports and stick hold \
             other nodes: see the columns of finite elements in the two tables.",
            finer.size[1],
            (0..finer.moves.len()).map(drift).collect::<Vec<_>>().join(" and ")
        ));
    }
    report.say(format!(
        "They change volumes by {}.",
        truth.moves.iter().map(|m| percents(&m.volume_change_pct)).collect::<Vec<_>>().join(" and ")
    ));
}

fn percents(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:+.3} %")).collect::<Vec<_>>().join(" / ")
}

fn markers(resolution: &Resolution, n: usize, name: &str, report: &mut Report) {
    report.say(format!("{} move:", capital(name)));
    let truth = &resolution.truth.moves[n];
    let ended: Vec<Option<&Measured>> = resolution.runs.iter().map(|(_, rests)| ended(rests, n)).collect();
    let mut header = vec!["marker".to_string(), "finite elements".into()];
    for (setup, _) in &resolution.runs {
        header.push(setup.method.name());
        header.push("error".into());
    }
    header.extend(["paper: CT".into(), "paper: estimated".into(), "paper: error".into()]);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = (0..truth.landmarks_m.len()).map(|l| {
        let mut row = vec![resolution.assembly.landmarks[l].0.clone(), mm(truth.landmarks_m[l].norm())];
        for end in &ended {
            match end {
                Some(m) => {
                    row.push(mm(m.landmarks_m[l].norm()));
                    row.push(mm((m.landmarks_m[l] - truth.landmarks_m[l]).norm()));
                }
                None => row.extend(["diverged".to_string(), "-".into()]),
            }
        }
        let printed = TABLE_1_MM.get(l).and_then(|marker| marker.get(n));
        row.extend([0, 1, 2].map(|k| printed.map_or("-".into(), |p| format!("{:.2}", p[k]))));
        row
    });
    report.table(&header, rows.collect::<Vec<_>>());
}

fn ended(rests: &[Result<Rest, Fault>], n: usize) -> Option<&Measured> {
    rests.get(n).and_then(|r| r.as_ref().ok()).map(|rest| &rest.measured)
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// One row of the table of means.
struct Row {
    method: String,
    resolution: &'static str,
    landmarks_mm: Vec<f64>,
    inside_mm: Vec<f64>,
    surface_mm: Vec<f64>,
    volume_pct: Vec<Vec<f64>>,
    min_j: Vec<f64>,
    at_rest: Vec<bool>,
    step_ms: f64,
    steps: usize,
    us_per_step: f64,
}

impl Row {
    fn of(resolution: &Resolution, setup: &Setup, rests: &[Result<Rest, Fault>]) -> Self {
        let good: Vec<(&Rest, &Measured)> =
            rests.iter().zip(&resolution.truth.moves).filter_map(|(r, t)| r.as_ref().ok().map(|r| (r, t))).collect();
        let landmarks: Vec<Vec<f64>> = good.iter().map(|(r, t)| r.measured.landmark_errors_m(t)).collect();
        let scene = &resolution.assembly.scene.landmark;
        let share = |e: &Vec<f64>, inside: bool| {
            let part = e.iter().zip(scene).filter(|(_, l)| l.inside_m.is_some() == inside).map(|(e, _)| *e);
            1e3 * mean(&part.collect::<Vec<_>>())
        };
        let steps: usize = good.iter().map(|(r, _)| r.steps).sum();
        Self {
            method: setup.method.name(),
            resolution: resolution.name,
            landmarks_mm: landmarks.iter().map(|e| share(e, false)).collect(),
            inside_mm: landmarks.iter().map(|e| share(e, true)).collect(),
            surface_mm: good.iter().map(|(r, t)| 1e3 * mean(&r.measured.surface_errors_m(t))).collect(),
            volume_pct: good.iter().map(|(r, _)| r.measured.volume_change_pct.clone()).collect(),
            min_j: good.iter().map(|(r, _)| r.measured.min_j).collect(),
            at_rest: good.iter().map(|(r, _)| r.at_rest).collect(),
            step_ms: 1e3 * f64::from(setup.dt_s),
            steps,
            us_per_step: 1e6 * good.iter().map(|(r, _)| r.cpu_s).sum::<f64>() / steps.max(1) as f64,
        }
    }

    fn json(&self) -> Value {
        json!({
            "method": self.method, "resolution": self.resolution, "mean_landmark_error_mm": self.landmarks_mm,
            "mean_inside_error_mm": self.inside_mm, "mean_surface_error_mm": self.surface_mm, "volume_change_pct": self.volume_pct,
            "min_j": self.min_j, "at_rest": self.at_rest, "step_ms": self.step_ms, "steps": self.steps, "cpu_us_per_step": self.us_per_step, "steps_per_s": 1e6 / self.us_per_step,
        })
    }
}

fn rows(findings: &Findings) -> Vec<Row> {
    let all = findings.resolutions.iter().flat_map(|r| r.runs.iter().map(move |(setup, rests)| Row::of(r, setup, rests)));
    all.collect()
}

fn weighed_rows(findings: &Findings) -> Vec<Row> {
    let of = |r: &Resolution| {
        let rows = r.runs.iter().map(|(setup, rests)| Row { resolution: "sparse, weight on", ..Row::of(r, setup, rests) });
        rows.collect::<Vec<_>>()
    };
    findings.weighed.map(of).unwrap_or_default()
}

fn joined(values: &[f64], digits: usize) -> String {
    if values.is_empty() {
        "diverged".into()
    } else {
        values.iter().map(|v| format!("{v:.digits$}")).collect::<Vec<_>>().join(" / ")
    }
}

fn means(findings: &Findings, report: &mut Report) {
    report.say("Small / large move. Volume: change of liver and gallbladder, small; large. Time: CPU of one core.");
    let header = [
        "method",
        "resolution",
        "landmarks mm",
        "inside mm",
        "surface mm",
        "volume %",
        "min J",
        "step ms",
        "us a step",
        "CPU s a virtual s",
        "at rest",
    ];
    let printed = |name: &str, p: &Printed| {
        vec![
            "paper, against tomography".to_string(),
            name.into(),
            joined(&p.landmarks_mm, 2),
            p.inside_mm.map_or("-".into(), |i| joined(&i, 2)),
            joined(&p.surface_mm, 2),
            format!("{}; {} (total)", p.volume_pct[0], p.volume_pct[1]),
            "-".into(),
            "-".into(),
            "-".into(),
            format!("{} frames a second", p.frames_per_s),
            "-".into(),
        ]
    };
    let ours = rows(findings).into_iter().chain(weighed_rows(findings)).map(|r| {
        let volume = r
            .volume_pct
            .iter()
            .map(|v| v.iter().map(|v| format!("{v:+.3}")).collect::<Vec<_>>().join(" "))
            .collect::<Vec<_>>()
            .join("; ");
        vec![
            r.method.clone(),
            r.resolution.into(),
            joined(&r.landmarks_mm, 2),
            joined(&r.inside_mm, 2),
            joined(&r.surface_mm, 2),
            volume,
            joined(&r.min_j, 2),
            format!("{:.3}", r.step_ms),
            format!("{:.0}", r.us_per_step),
            format!("{:.2}", r.us_per_step * 1e-3 / r.step_ms),
            r.at_rest.iter().map(|b| if *b { "yes" } else { "no" }).collect::<Vec<_>>().join(" / "),
        ]
    });
    report.table(&header, ours.chain([printed("full", &FULL), printed("sparse", &SPARSE)]).collect::<Vec<_>>());
}

/// Frames per second that a simulation in real time reaches: one frame takes the steps of a
/// thirtieth of a second, without and with drawing and writing the picture.
fn frames(findings: &Findings, report: &mut Report) {
    const FRAME_S: f64 = 1.0 / 30.0;
    let rows = rows(findings).into_iter().zip(findings.resolutions.iter().flat_map(|r| r.runs.iter().map(move |_| r.picture_s)));
    let rows = rows.map(|(r, picture_s)| {
        let steps_s = FRAME_S / (1e-3 * r.step_ms) * 1e-6 * r.us_per_step;
        let (without, with) = (1.0 / steps_s, 1.0 / (steps_s + picture_s));
        [
            r.method.clone(),
            r.resolution.into(),
            format!("{:.0}", 1e6 / r.us_per_step),
            format!("{without:.1}"),
            format!("{with:.2}"),
        ]
    });
    report.say(
        "Speed on one core. A frame is 1/30 s of virtual time; a picture is one of Fig. 2, drawn by painter's algorithm on the processor and written as SVG and PNG: it is made for \
         paper, not for speed, and takes most of the time. The paper's 15 and 40 frames a second are OpenGL's; how many steps a frame has it does not say.",
    );
    let header = ["method", "resolution", "steps a second", "frames a second, pictures excluded", "pictures included"];
    report.table(&header, rows.collect::<Vec<_>>());
}

fn failures(findings: &Findings, folder: &OutputFolder, report: &mut Report) -> Result<(), Error> {
    report.section("Where the printed formulas fail");
    report.say(
        "**The damper (12)** has the unit kg/(s m), so its size depends on the unit of length. Largest step that the sparse scene survives, springs (11) as printed, no \
         corrections; explicit dampers along springs cost step whatever their form:",
    );
    let rows =
        findings.steps.stable.iter().map(|(name, dt_s)| vec![(*name).to_string(), format!("{:.3}", 1e6 * f64::from(*dt_s))]);
    report.table(&["damping constant", "largest step us"], rows.collect::<Vec<_>>());
    figures::stable_step(findings.steps, folder, report)?;
    report.say(
        "**The length corrections (6)-(8)** move positions by a part of the violation at every step, which is a force of about m dx/dt^2: a block of 130 nodes, pressed 2 mm \
         deep, answers with a force that grows as the step shrinks. With tau = 0, the paper's setting, every spring is corrected at every step. The same intent as an energy \
         (the product's compensation) has no step in it.",
    );
    figures::force_against_step(findings.steps, folder, report)
}

fn product(findings: &Findings) -> Option<Row> {
    rows(findings).into_iter().find(|r| r.method == METHODS[0].name())
}

fn claims(findings: &Findings, report: &mut Report) {
    let all = rows(findings);
    let sharpest = findings.resolutions[0].name;
    let find = |n: usize, resolution: &str| all.iter().find(|r| r.method == METHODS[n].name() && r.resolution == resolution);
    let paper = if sharpest == "full" { &FULL } else { &SPARSE };
    if let Some(r) = find(2, sharpest) {
        let held = r.landmarks_mm.len() == 2 && (0..2).all(|k| r.landmarks_mm[k] <= paper.landmarks_mm[k]);
        let said = format!("mean landmark error {} mm", joined(&paper.landmarks_mm, 2));
        report.claim(
            format!("{said} ({sharpest} resolution, against tomography)"),
            format!("{} mm against finite elements{}", joined(&r.landmarks_mm, 2), still_moving(r)),
            Some(held),
        );
        // volume change of all organs together, as in the paper
        let rest_m3 = rest_volumes_m3(&findings.resolutions[0].assembly);
        let whole_m3: f64 = rest_m3.iter().sum();
        let total: Vec<f64> =
            r.volume_pct.iter().map(|v| v.iter().zip(&rest_m3).map(|(p, m3)| p * m3).sum::<f64>().abs() / whole_m3).collect();
        let held = total.len() == 2 && (0..2).all(|k| total[k] <= paper.volume_pct[k]);
        let said = format!("volume changes by {} and {} %", paper.volume_pct[0], paper.volume_pct[1]);
        report.claim(said, format!("by {} %", joined(&total, 2)), Some(held));
        report.claim(
            "no local deformation: it is well distributed",
            format!("least local volume ratio {}", joined(&r.min_j, 2)),
            Some(r.min_j.iter().all(|j| *j > 0.3)),
        );
    }
    if let (Some(with), Some(without)) = (find(2, sharpest), find(3, sharpest)) {
        let volume = |r: &Row| r.volume_pct.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
        report.claim(
            "tau = 0 preserves volume through the springs alone",
            format!("worst volume change {:.2} %, without the corrections {:.2} %", volume(with), volume(without)),
            Some(volume(with) < volume(without)),
        );
    }
    if let (Some(full), Some(sparse)) = (find(2, "full"), find(2, "sparse")) {
        let held = (0..2).all(|k| full.landmarks_mm.get(k) < sparse.landmarks_mm.get(k));
        report.claim(
            "a sparser mesh is less accurate: 2.59 and 5.27 mm instead of 1.50 and 2.93",
            format!("{} mm instead of {}", joined(&sparse.landmarks_mm, 2), joined(&full.landmarks_mm, 2)),
            Some(held),
        );
    }
    for (resolution, printed) in [("full", &FULL), ("sparse", &SPARSE)] {
        let Some(r) = find(2, resolution) else { continue };
        let per_virtual_s = r.us_per_step * 1e-3 / r.step_ms;
        report.claim(
            format!("{} frames a second with the {resolution} mesh, in real time", printed.frames_per_s),
            format!("a virtual second takes {per_virtual_s:.2} s on one core, pictures excluded"),
            Some(per_virtual_s <= 1.0),
        );
    }
    report.claim("accuracy against the porcine organs", "the tomography is not public", None);
}

fn still_moving(row: &Row) -> &'static str {
    if row.at_rest.iter().all(|r| *r) { "" } else { " (still swaying after 6 s)" }
}

fn rest_volumes_m3(assembly: &Assembly) -> Vec<f64> {
    let still = vec![Vector3::zeros(); assembly.quadratic.nodes_m.len()];
    assembly.organs.iter().map(|organ| organ.volume(&assembly.quadratic, &still).rest_m3).collect()
}

/// Promises that the product did not keep, one sentence each. Limits on error and volume apply only
/// at full resolution.
fn broken_promises(findings: &Findings) -> Vec<String> {
    let mut broken = Vec::new();
    let Some(row) = product(findings) else { return broken };
    for (n, name) in findings.scene.attachment.names.iter().enumerate() {
        let Some(error_mm) = row.landmarks_mm.get(n) else {
            broken.push(format!("palpate did not survive the {name} move"));
            continue;
        };
        if row.min_j[n] <= 0.0 {
            broken.push(format!("a tet is inside out after the {name} move"));
        }
        // the promised limits are those of the full resolution
        if row.resolution != "full" {
            continue;
        }
        if PROMISED_M.get(n).is_some_and(|most| error_mm * 1e-3 > *most) {
            broken.push(format!("mean landmark error {error_mm:.2} mm after the {name} move"));
        }
        let volume = row.volume_pct[n].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        if PROMISED_VOLUME_PCT.get(n).is_some_and(|most| volume > *most) {
            broken.push(format!("volume change {volume:.3} % after the {name} move"));
        }
    }
    broken
}

fn summary(findings: &Findings, report: &Report, broken: &[String]) -> Value {
    let truth = &findings.resolutions[0].truth;
    let steps = findings.steps;
    json!({
        "paper": "000", "scene": findings.scene.name, "quick": findings.quick, "elapsed_s": findings.elapsed_s,
        "reference": {
            "nodes": truth.size[0], "tets": truth.size[1], "iterations": truth.iterations,
            "mean_landmark_change_when_sparse_is_subdivided_mm": findings.subdivided.zip(findings.resolutions.last()).map(|(finer, sparse)| {
                (0..finer.moves.len()).map(|n| 1e3 * mean(&sparse.truth.moves[n].landmark_errors_m(&finer.moves[n]))).collect::<Vec<_>>()
            }),
            "volume_change_pct": truth.moves.iter().map(|m| m.volume_change_pct.clone()).collect::<Vec<_>>(),
        },
        "rows": rows(findings).iter().chain(&weighed_rows(findings)).map(Row::json).collect::<Vec<_>>(),
        "largest_step_ms": steps.stable.iter().map(|(name, dt)| json!({"damping": name, "step_ms": 1e3 * f64::from(*dt)})).collect::<Vec<_>>(),
        "claims": report.claims(), "broken_promises": broken,
    })
}

fn csv(findings: &Findings, folder: &OutputFolder) -> Result<(), Error> {
    for resolution in findings.resolutions {
        for (n, name) in findings.scene.attachment.names.iter().enumerate() {
            let truth = &resolution.truth.moves[n];
            for (m, (_, rests)) in resolution.runs.iter().enumerate() {
                let Some(found) = ended(rests, n) else { continue };
                let points = resolution.assembly.landmarks.iter().map(|(_, x)| x).chain(&resolution.assembly.surface);
                let there = found.landmarks_m.iter().chain(&found.surface_m);
                let wanted = truth.landmarks_m.iter().chain(&truth.surface_m);
                let rows = points.zip(there).zip(wanted).map(|((x, u), t)| [x.x, x.y, x.z, u.x, u.y, u.z, t.x, t.y, t.z]);
                let header =
                    ["rest_x_m", "rest_y_m", "rest_z_m", "u_x_m", "u_y_m", "u_z_m", "fem_u_x_m", "fem_u_y_m", "fem_u_z_m"];
                folder.write_csv(&format!("points_{}_{name}_method{m}.csv", resolution.name), header, rows)?;
            }
        }
    }
    let rows =
        findings.steps.force.iter().enumerate().flat_map(|(n, curve)| curve.iter().map(move |(dt, f)| [n as f64, *dt, *f]));
    let damped = findings.steps.damped.iter().map(|(share, dt_s)| [*share, *dt_s]);
    folder.write_csv("stable_step.csv", ["damping_over_critical", "largest_step_s"], damped)?;
    Ok(folder.write_csv("force_against_step.csv", ["curve_0_tau0_1_tau0.1_2_energy", "step_s", "force_n"], rows)?)
}

fn print(findings: &Findings, claims: &[Claim], broken: &[String], out: &Path) {
    println!("{}", verdict(claims, broken));
    println!(
        "mean distance from our finite elements, after each of two lifts; J: volume of the worst tet over that at rest, negative is inside out"
    );
    println!(
        "palpate promises, at full resolution: landmarks within {} mm, every J above 0",
        PROMISED_M.map(|most| (most * 1e3).to_string()).join(" / ")
    );
    println!("{:<60} {:>7} {:>17} {:>15} {:>11}", "method", "mesh", "landmarks mm", "surface mm", "min J");
    for r in rows(findings).into_iter().chain(weighed_rows(findings)) {
        println!(
            "{:<60} {:>7} {:>17} {:>15} {:>11}",
            r.method,
            r.resolution,
            joined(&r.landmarks_mm, 2),
            joined(&r.surface_mm, 2),
            joined(&r.min_j, 2)
        );
    }
    println!(
        "paper, against tomography: landmarks {} mm full, {} mm sparse\n",
        joined(&FULL.landmarks_mm, 2),
        joined(&SPARSE.landmarks_mm, 2)
    );
    print_claims(claims, out);
    println!("{}", verdict(claims, broken));
}
