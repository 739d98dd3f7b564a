//! Result files of a press: summary, trace, surfaces and pictures.

use palpate::ClampFlags;
use serde::Serialize;

use crate::contact_report::{self, ContactSummary};
use crate::error::Error;
use crate::section_report;
use palpate_charts::{self as charts, Probe, ProbeShape, Sample, Surface, TickTimes};
use palpate_tissue::moving::RampError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::contact::DeepestContact;
use palpate_tissue::press::{Hold, Press};
use palpate_tissue::scene::{Scene, Shape, Tip};
use palpate_tissue::session::standing::Standing;
use palpate_tissue::session::{Report, Session};
use palpate_tissue::trace_file;

/// Contents of `summary.json`.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    scene: &'a str,
    method: &'static str,
    /// Whether the patch was calibrated to exactly this scene.
    calibrated: bool,
    /// The scene to which the patch was fitted, and the error to expect.
    model: Standing,
    fitted_places: u32,
    nodes: usize,
    springs: usize,
    tets: usize,
    substeps: u16,
    stable_dt_s: f64,
    ticks: usize,
    deadline_misses: usize,
    tick_us: TickUs,
    holds: Vec<HoldSummary>,
    /// Errors against the stored dynamic references of this scene; empty if there are none.
    moving: &'a [RampError],
    residual_m: f64,
    limiters: Vec<&'static str>,
    fault: Option<String>,
    state_hash: String,
    /// Contact at the deepest position of the tip; absent unless requested and in contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    contact: Option<ContactSummary>,
    report: &'a Report,
}

#[derive(Debug, Serialize)]
struct TickUs {
    p50: f32,
    p99: f32,
    max: f32,
}

#[derive(Debug, Serialize)]
struct HoldSummary {
    target: f64,
    depth_m: f32,
    force_n: f32,
    min_j: f64,
    volume_change_pct: f64,
}

/// Writes every file of a run.
pub fn write(
    folder: &OutputFolder,
    scene: &Scene,
    session: &Session,
    press: &Press,
    moving: &[RampError],
    contact: Option<&DeepestContact>,
    vtu: bool,
) -> Result<(), Error> {
    trace_file::write(folder, press)?;
    for (k, hold) in press.holds.iter().enumerate().filter(|_| has_surface(session)) {
        write_surface(folder, session, k, hold)?;
        if vtu {
            crate::vtu::write(folder, session, k, hold)?;
        }
    }
    let [p50, p99, max] = press.tick_us();
    let model = Standing::of(scene, session);
    let summary = Summary {
        scene: &scene.name,
        method: scene.solver.method.name(),
        calibrated: matches!(model, Standing::Calibrated { .. }),
        model,
        fitted_places: session.patch.fitted_places(),
        nodes: session.report.nodes,
        springs: session.report.springs,
        tets: session.report.tets,
        substeps: session.params.substeps,
        stable_dt_s: session.stable.pressed_s,
        ticks: press.ticks.len(),
        deadline_misses: press.deadline_misses,
        tick_us: TickUs { p50, p99, max },
        holds: press
            .holds
            .iter()
            .map(|h| HoldSummary {
                target: h.target,
                // in single precision, as in the trace
                depth_m: h.depth_m as f32,
                force_n: h.force_n as f32,
                min_j: h.min_j,
                volume_change_pct: h.volume_change_pct,
            })
            .collect(),
        moving,
        residual_m: press.residual_m,
        limiters: limiter_names(press.limiters),
        fault: press.fault.map(|f| f.to_string()),
        state_hash: format!("{:016x}", press.state_hash),
        contact: contact.map(ContactSummary::of),
        report: &session.report,
    };
    folder.write_summary(&summary)?;
    draw(folder, scene, session, press)?;
    contact.map_or(Ok(()), |contact| contact_report::write(folder, scene, session, contact))
}

/// Whether the tissue has a surface that a press deforms: that of a law only tells where the tissue
/// is.
pub fn has_surface(session: &Session) -> bool {
    session.patch.model().law.is_none()
}

fn limiter_names(limiters: ClampFlags) -> Vec<&'static str> {
    [(ClampFlags::SPEED, "speed"), (ClampFlags::DEPTH, "depth"), (ClampFlags::FORCE, "force"), (ClampFlags::BURIED, "buried")]
        .into_iter()
        .filter(|(flag, _)| limiters.contains(*flag))
        .map(|(_, name)| name)
        .collect()
}

fn write_surface(folder: &OutputFolder, session: &Session, k: usize, hold: &Hold) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let mut on_surface: Vec<u16> = model.triangles.iter().flat_map(|t| t.node).collect();
    on_surface.sort_unstable();
    on_surface.dedup();
    let rows = on_surface.into_iter().map(|n| {
        let (x, u) =
            (model.nodes[usize::from(n)].rest_m.map(f64::from), hold.surface_displacement_m[usize::from(n)].cast::<f64>());
        [x[0], x[1], x[2], u.x, u.y, u.z]
    });
    let header = ["rest_x_m", "rest_y_m", "rest_z_m", "displacement_x_m", "displacement_y_m", "displacement_z_m"];
    Ok(folder.write_csv(&format!("surface_{k}.csv"), header, rows)?)
}

fn draw(folder: &OutputFolder, scene: &Scene, session: &Session, press: &Press) -> Result<(), Error> {
    let axis = session.params.probe.axis;
    let trace: Vec<Sample> = press
        .ticks
        .iter()
        .map(|t| Sample { t_s: t.t_s, depth_m: t.command_m, force_n: f64::from(t.output.force_n.dot(&axis)) })
        .collect();
    let holds: Vec<Sample> = press.holds.iter().map(|h| Sample { t_s: h.t_s, depth_m: h.depth_m, force_n: h.force_n }).collect();
    // reference points that are deeper than the press would only compress the curve
    let deepest = trace.iter().map(|s| s.depth_m).fold(0.0, f64::max);
    let mut reference = palpate_tissue::reference_values::of(scene);
    reference.retain(|(depth, _)| *depth <= 1.05 * deepest);
    let run = charts::Press {
        scene: &scene.name,
        node_count: session.report.nodes,
        trace: &trace,
        holds: &holds,
        reference: &reference,
    };
    charts::force_depth(folder.draft(), "force_depth", &run)?;
    charts::force_time(folder.draft(), "force_time", &run)?;
    let times: Vec<f32> = press.ticks.iter().map(|t| t.tick_us).collect();
    let times = TickTimes { scene: &scene.name, node_count: session.report.nodes, machine: &press.timed_on, tick_us: &times };
    charts::tick_time(folder.draft(), "tick_time", &times)?;
    if !has_surface(session) {
        return Ok(());
    }
    if let Some(deepest) = press.holds.iter().max_by(|a, b| a.depth_m.total_cmp(&b.depth_m)) {
        draw_surface(folder, scene, session, deepest)?;
    }
    section_report::draw(folder, scene, session, press, |tip_m| probe_at(scene, session, tip_m))
}

fn probe_at(scene: &Scene, session: &Session, tip_m: [f64; 3]) -> Probe {
    let turned = session.params.turned_probe();
    Probe {
        shape: match Tip::of_core(&turned).shape {
            Shape::Hemisphere => ProbeShape::Hemisphere,
            Shape::Sphere => ProbeShape::Sphere,
            Shape::Flat => ProbeShape::Flat,
            Shape::Capsule { length_m, along } => ProbeShape::Capsule { length_m, along },
            Shape::Ellipsoid { semi_axes_m, along } => ProbeShape::Ellipsoid { semi_axes_m, along },
        },
        radius_m: scene.probe.radius_m,
        tip_m,
        axis: turned.axis.map(f64::from).into(),
    }
}

fn draw_surface(folder: &OutputFolder, scene: &Scene, session: &Session, hold: &Hold) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let rest_m: Vec<[f64; 3]> = model.nodes.iter().map(|n| n.rest_m.map(f64::from)).collect();
    let deformed_m: Vec<[f64; 3]> =
        rest_m.iter().zip(&hold.surface_displacement_m).map(|(x, u)| [0, 1, 2].map(|k| x[k] + f64::from(u[k]))).collect();
    let triangles: Vec<[u32; 3]> = model.triangles.iter().map(|t| t.node.map(u32::from)).collect();
    let caption = format!("{} nodes, {:.2} mm deep, {:.3} N", session.report.nodes, hold.depth_m * 1e3, hold.force_n);
    let probe = probe_at(scene, session, hold.tip_m.map(f64::from).into());
    let surface =
        Surface { scene: &scene.name, caption: &caption, rest_m: &rest_m, deformed_m: &deformed_m, triangles: &triangles, probe };
    charts::surface(folder.draft(), "surface", &surface)?;
    Ok(())
}
