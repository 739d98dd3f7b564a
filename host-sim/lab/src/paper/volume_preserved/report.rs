//! Tables with the paper's numbers next to ours, claims and pictures.

use nalgebra::Vector3;
use palpate::Fault;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;

use super::measured::{Measured, mean};
use super::method::{Rest, Setup};
use super::printed::{FULL, Printed, SPARSE, TABLE_1_MM};
use super::scene::HangingScene;
use super::truth::Truth;
use super::{METHODS, PROMISED_M, PROMISED_VOLUME_PCT, Resolution, figures};
use crate::study::{Claim, Findings, Table};

/// Duration of a frame in real time [s].
const FRAME_S: f64 = 1.0 / 30.0;
/// Smallest local volume ratio of a deformation that is well distributed (1).
const WELL_DISTRIBUTED_J: f64 = 0.3;

/// Everything that was measured.
pub struct Measurements<'a> {
    /// Scene that was simulated.
    pub scene: &'a HangingScene,
    /// Full and sparse resolution, or only the sparse one.
    pub resolutions: &'a [Resolution<'a>],
    /// The sparse resolution under its weight, starting from a stress-free shape.
    pub weighed: Option<&'a Resolution<'a>>,
    /// Finite elements of the sparse resolution with every tet cut into eight.
    pub subdivided: Option<&'a Truth>,
}

/// Mean errors of a method after a move; what was not reached is left out.
#[derive(Clone, Debug, Default, Serialize)]
struct Mean {
    method: String,
    resolution: String,
    after_move: String,
    landmarks_mm: Option<f64>,
    inside_mm: Option<f64>,
    surface_mm: Option<f64>,
    /// Change of each organ's volume.
    volume_change_pct: String,
    min_j: Option<f64>,
    at_rest: Option<bool>,
    step_ms: Option<f64>,
    steps: Option<usize>,
    cpu_us_per_step: Option<f64>,
    /// Frames of 1/30 s in a second of one core, without and with drawing a picture of each.
    frames_per_s: Option<f64>,
    frames_per_s_with_pictures: Option<f64>,
    /// Largest change of an organ's volume, and change of all together.
    #[serde(skip)]
    volume_pct: Option<[f64; 2]>,
}

/// Tables, claims and pictures of everything that was measured.
pub fn findings(found: &Measurements, folder: &OutputFolder) -> Result<Findings, crate::Error> {
    let sharpest = &found.resolutions[0];
    let means = means(found);
    let printed =
        [("full", &FULL), ("sparse", &SPARSE)].into_iter().flat_map(|(name, p)| [0, 1].map(|n| Mean::printed(name, p, n)));
    let all: Vec<Mean> = means.iter().cloned().chain(printed).collect();
    let mut findings = Findings {
        headline: "paper 000: a liver and its gallbladder, hung by a thread".into(),
        tables: vec![
            markers(found)
                .about("Table 1: distances from rest and errors (13); the paper's are of porcine organs against tomography"),
            points(found),
            Table::of("means", &all)?
                .about("sections 3.3 and 3.4: mean distances from our finite elements after each move, change of each organ's volume, speed on one core")
                .columns(&[
                    "method",
                    "resolution",
                    "after_move",
                    "landmarks_mm",
                    "inside_mm",
                    "surface_mm",
                    "volume_change_pct",
                    "min_j",
                    "at_rest",
                    "step_ms",
                    "cpu_us_per_step",
                    "frames_per_s",
                    "frames_per_s_with_pictures",
                ]),
        ],
        claims: printed_claims(found, &means),
        notes: notes(found),
        ..Findings::default()
    };
    findings.claims.extend(promises(found, &means));
    for resolution in found.resolutions {
        findings.drawn.extend(figures::fig_2(found.scene, resolution, folder)?);
        findings.figures.push(figures::fig_3(found.scene, resolution));
    }
    let truth = &sharpest.truth;
    findings.fact("reference_nodes", truth.size[0]);
    findings.fact("reference_tets", truth.size[1]);
    findings.fact("reference_iterations", truth.iterations);
    findings.fact("reference_volume_change_pct", truth.moves.iter().map(|m| m.volume_change_pct.clone()).collect::<Vec<_>>());
    Ok(findings)
}

fn notes(found: &Measurements) -> Vec<String> {
    let scene = found.scene;
    let lifted: Vec<String> = scene.attachment.moves_m.iter().map(|m| format!("{:.4}", 1e3 * Vector3::from(*m).norm())).collect();
    let weight = if scene.gravity_m_per_s2 == [0.0; 3] { "the rest shape is that under gravity" } else { "gravity on" };
    let mut notes = vec![
        format!(
            "Scene `{}`: our own shapes, Lobe 1 lifted by a stick that moves {} mm, {weight}. Truth: finite elements of the same scene on the same mesh (10-node tets, neo-Hookean), because the paper's tomography is not public",
            scene.name,
            lifted.join(" and ")
        ),
        "(12) has the unit kg/(s m), so its size depends on the unit of length; explicit dampers along springs cost step whatever their form".into(),
        "(6)-(8) move positions by a part of the violation at every step, a force of about m dx/dt^2 that grows as the step shrinks; the same intent as an energy has no step in it".into(),
    ];
    if let (Some(finer), Some(sparse)) = (found.subdivided, found.resolutions.last()) {
        let drift = |n: usize| format!("{:.2}", 1e3 * mean(&sparse.truth.moves[n].landmark_errors_m(&finer.moves[n])));
        notes.push(format!(
            "with every tet of the sparse mesh cut into eight ({} tets), finite elements put the landmarks {} mm elsewhere on average",
            finer.size[1],
            (0..finer.moves.len()).map(drift).collect::<Vec<_>>().join(" and ")
        ));
    }
    notes
}

fn ended(rests: &[Result<Rest, Fault>], n: usize) -> Option<&Rest> {
    rests.get(n).and_then(|r| r.as_ref().ok())
}

/// The setups of a resolution with every move: number and name of the move, and the truth after it.
fn each<'a>(
    found: &'a Measurements,
) -> impl Iterator<Item = (&'a Resolution<'a>, usize, &'a str, &'a Measured, &'a Setup, Option<&'a Rest>)> {
    found.resolutions.iter().flat_map(move |r| {
        found.scene.attachment.names.iter().enumerate().flat_map(move |(n, name)| {
            r.runs.iter().map(move |(setup, rests)| (r, n, name.as_str(), &r.truth.moves[n], setup, ended(rests, n)))
        })
    })
}

/// Table 1: displacements of the markers from rest, and errors (13).
fn markers(found: &Measurements) -> Table {
    let rows = each(found).flat_map(|(r, n, after_move, truth, setup, rest)| {
        let of = move |(l, (marker, _)): (usize, &'_ (String, _))| {
            let wanted: Vector3<f64> = truth.landmarks_m[l];
            let printed = TABLE_1_MM.get(l).and_then(|marker| marker.get(n).copied());
            let at = rest.map(|rest| rest.measured.landmarks_m[l]);
            (r.name, after_move.to_owned(), marker.to_owned(), setup.method.name(), at, wanted, printed)
        };
        r.assembly.landmarks.iter().enumerate().map(of).collect::<Vec<_>>()
    });
    Table::rows("markers", rows)
        .col("resolution", |row| row.0)
        .col("after_move", |row| row.1.clone())
        .col("marker", |row| row.2.clone())
        .col("method", |row| row.3.clone())
        .col("displacement_mm", |row| row.4.map(|u| 1e3 * u.norm()))
        .col("error_mm", |row| row.4.map(|u| 1e3 * (u - row.5).norm()))
        .col("finite_elements_mm", |row| 1e3 * row.5.norm())
        .col("paper_tomography_mm", |row| row.6.map(|p| p[0]))
        .col("paper_estimated_mm", |row| row.6.map(|p| p[1]))
        .col("paper_error_mm", |row| row.6.map(|p| p[2]))
        .all()
}

/// Displacements of the landmarks and surface points.
fn points(found: &Measurements) -> Table {
    let mut rows = Vec::new();
    for (r, _, after_move, truth, setup, rest) in each(found) {
        let Some(Rest { measured, .. }) = rest else { continue };
        let points = r.assembly.landmarks.iter().map(|(_, x)| x).chain(&r.assembly.surface);
        let there = measured.landmarks_m.iter().chain(&measured.surface_m);
        let wanted = truth.landmarks_m.iter().chain(&truth.surface_m);
        let head = || (r.name, after_move.to_owned(), setup.method.name());
        rows.extend(points.zip(there).zip(wanted).map(|((x, u), t)| (head(), [*x, *u, *t])));
    }
    let mut table = Table::rows("points", rows)
        .col("resolution", |(head, _)| head.0)
        .col("after_move", |(head, _)| head.1.clone())
        .col("method", |(head, _)| head.2.clone());
    for (n, what) in ["rest", "u", "fem_u"].into_iter().enumerate() {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            table = table.col(&format!("{what}_{name}_m"), |(_, vectors)| vectors[n][axis]);
        }
    }
    table.all().quiet()
}

impl Mean {
    fn of(r: &Resolution, name: &str, n: usize, after_move: &str, (setup, rests): &(Setup, Vec<Result<Rest, Fault>>)) -> Self {
        let good = || rests.iter().filter_map(|rest| rest.as_ref().ok());
        let steps: usize = good().map(|rest| rest.steps).sum();
        let us = 1e6 * good().map(|rest| rest.cpu_s).sum::<f64>() / steps.max(1) as f64;
        let step_ms = 1e3 * f64::from(setup.dt_s);
        let frame_s = FRAME_S / (1e-3 * step_ms) * 1e-6 * us;
        let head = Self {
            method: setup.method.name(),
            resolution: name.to_owned(),
            after_move: after_move.to_owned(),
            step_ms: Some(step_ms),
            steps: Some(steps),
            cpu_us_per_step: Some(us),
            frames_per_s: Some(1.0 / frame_s).filter(|f| f.is_finite()),
            frames_per_s_with_pictures: Some(1.0 / (frame_s + r.picture_s)).filter(|f| f.is_finite()),
            ..Self::default()
        };
        let Some(Rest { measured, at_rest, .. }) = ended(rests, n) else { return head };
        let truth = &r.truth.moves[n];
        let errors = measured.landmark_errors_m(truth);
        let share_mm = |inside: bool| {
            let part = errors.iter().zip(&r.assembly.scene.landmark).filter(|(_, l)| l.inside_m.is_some() == inside);
            1e3 * mean(&part.map(|(e, _)| *e).collect::<Vec<_>>())
        };
        let volumes = &measured.volume_change_pct;
        let rest_m3 = rest_volumes_m3(r);
        let total = volumes.iter().zip(&rest_m3).map(|(pct, m3)| pct * m3).sum::<f64>() / rest_m3.iter().sum::<f64>();
        Self {
            landmarks_mm: Some(share_mm(false)),
            inside_mm: Some(share_mm(true)),
            surface_mm: Some(1e3 * mean(&measured.surface_errors_m(truth))),
            volume_change_pct: volumes.iter().map(|v| format!("{v:+.4}")).collect::<Vec<_>>().join(" "),
            min_j: Some(measured.min_j),
            at_rest: Some(*at_rest),
            volume_pct: Some([volumes.iter().fold(0.0_f64, |a, b| a.max(b.abs())), total.abs()]),
            ..head
        }
    }

    fn printed(resolution: &str, printed: &Printed, n: usize) -> Self {
        Self {
            method: "paper, against tomography".into(),
            resolution: resolution.to_owned(),
            after_move: ["small", "large"][n].into(),
            landmarks_mm: Some(printed.landmarks_mm[n]),
            inside_mm: printed.inside_mm.map(|inside| inside[n]),
            surface_mm: Some(printed.surface_mm[n]),
            volume_change_pct: format!("{} (total)", printed.volume_pct[n]),
            frames_per_s: Some(printed.frames_per_s),
            ..Self::default()
        }
    }
}

fn means(found: &Measurements) -> Vec<Mean> {
    let named = found.resolutions.iter().map(|r| (r, r.name)).chain(found.weighed.map(|r| (r, "sparse, weight on")));
    let names = &found.scene.attachment.names;
    named
        .flat_map(|(r, name)| {
            let of = move |run| names.iter().enumerate().map(move |(n, after)| Mean::of(r, name, n, after, run));
            r.runs.iter().flat_map(of)
        })
        .collect()
}

fn rest_volumes_m3(resolution: &Resolution) -> Vec<f64> {
    let assembly = &resolution.assembly;
    let still = vec![Vector3::zeros(); assembly.quadratic.nodes_m.len()];
    assembly.organs.iter().map(|organ| organ.volume(&assembly.quadratic, &still).rest_m3).collect()
}

/// Values of the moves, as text.
fn joined(values: &[Option<f64>]) -> String {
    values.iter().map(|v| v.map_or("diverged".into(), |v| format!("{v:.2}"))).collect::<Vec<_>>().join(" / ")
}

/// The statements of the paper, with its method of 0.1 critical damping.
fn printed_claims(found: &Measurements, means: &[Mean]) -> Vec<Claim> {
    let sharpest = found.resolutions[0].name;
    let of = |n: usize, resolution: &str| -> Vec<&Mean> {
        means.iter().filter(|m| m.method == METHODS[n].name() && m.resolution == resolution).collect()
    };
    let paper = if sharpest == "full" { &FULL } else { &SPARSE };
    let values = |rows: &[&Mean], of: fn(&Mean) -> Option<f64>| rows.iter().map(|m| of(m)).collect::<Vec<_>>();
    let at_most = |found: &[Option<f64>], most: [f64; 2]| {
        found.len() == 2 && found.iter().zip(most).all(|(found, most)| found.is_some_and(|v| v <= most))
    };
    let (with, without) = (of(2, sharpest), of(3, sharpest));
    let landmarks = values(&with, |m| m.landmarks_mm);
    let total = values(&with, |m| Some(m.volume_pct?[1]));
    let least = values(&with, |m| m.min_j);
    let swaying = with.iter().any(|m| m.at_rest == Some(false));
    let worst = |rows: &[&Mean]| rows.iter().filter_map(|m| Some(m.volume_pct?[0])).fold(0.0, f64::max);
    let mut claims = vec![
        Claim::printed(
            format!(
                "mean landmark error {} mm ({sharpest} resolution, against tomography)",
                joined(&paper.landmarks_mm.map(Some))
            ),
            format!(
                "{} mm against finite elements{}",
                joined(&landmarks),
                if swaying { " (still swaying after 6 s)" } else { "" }
            ),
            Some(at_most(&landmarks, paper.landmarks_mm)),
        ),
        Claim::printed(
            format!("volume changes by {} and {} %", paper.volume_pct[0], paper.volume_pct[1]),
            format!("by {} %", joined(&total)),
            Some(at_most(&total, paper.volume_pct)),
        ),
        Claim::printed(
            "no local deformation: it is well distributed",
            format!("least local volume ratio {}", joined(&least)),
            Some(least.iter().flatten().all(|j| *j > WELL_DISTRIBUTED_J)),
        ),
        Claim::printed(
            "tau = 0 preserves volume through the springs alone",
            format!("worst volume change {:.2} %, without the corrections {:.2} %", worst(&with), worst(&without)),
            Some(worst(&with) < worst(&without)),
        ),
    ];
    let [full, sparse] = ["full", "sparse"].map(|name| values(&of(2, name), |m| m.landmarks_mm));
    if !full.is_empty() && !sparse.is_empty() {
        claims.push(Claim::printed(
            "a sparser mesh is less accurate: 2.59 and 5.27 mm instead of 1.50 and 2.93",
            format!("{} mm instead of {}", joined(&sparse), joined(&full)),
            Some((0..2).all(|k| full.get(k).copied().flatten() < sparse.get(k).copied().flatten())),
        ));
    }
    for (resolution, printed) in [("full", &FULL), ("sparse", &SPARSE)] {
        let Some(frames) = of(2, resolution).first().and_then(|m| m.frames_per_s) else { continue };
        let per_virtual_s = 1.0 / (frames * FRAME_S);
        claims.push(Claim::printed(
            format!("{} frames a second with the {resolution} mesh, in real time", printed.frames_per_s),
            format!("a virtual second takes {per_virtual_s:.2} s on one core, pictures excluded"),
            Some(per_virtual_s <= 1.0),
        ));
    }
    claims.push(Claim::printed("accuracy against the porcine organs", "the tomography is not public", None));
    claims
}

/// The promises of the product. Limits on error and volume apply only at full resolution.
fn promises(found: &Measurements, means: &[Mean]) -> Vec<Claim> {
    let mut claims = Vec::new();
    let resolution = found.resolutions[0].name;
    let product = means.iter().filter(|m| m.method == METHODS[0].name() && m.resolution == resolution);
    for (n, mean) in product.enumerate() {
        let after = |what: &str| format!("{what} after the {} move", mean.after_move);
        let said = |value: Option<f64>, unit: &str| value.map_or("did not survive".into(), |v| format!("{v:.3}{unit}"));
        let mut promise = |what: &str, bound: String, value: Option<f64>, unit, holds: bool| {
            claims.push(Claim::promise(after(what), bound, said(value, unit), holds));
        };
        promise("smallest volume ratio of a tet", "above 0".into(), mean.min_j, "", mean.min_j.is_some_and(|j| j > 0.0));
        if resolution != "full" {
            continue;
        }
        if let (Some(most_m), Some(most_pct)) = (PROMISED_M.get(n), PROMISED_VOLUME_PCT.get(n)) {
            let (error, volume) = (mean.landmarks_mm, mean.volume_pct.map(|v| v[0]));
            let holds = error.is_some_and(|mm| mm * 1e-3 <= *most_m);
            promise("mean landmark error", format!("at most {} mm", most_m * 1e3), error, " mm", holds);
            let holds = volume.is_some_and(|pct| pct <= *most_pct);
            promise("largest change of an organ's volume", format!("at most {most_pct} %"), volume, " %", holds);
        }
    }
    claims
}
