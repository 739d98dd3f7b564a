//! Writes `summary.json` and prints a short table.

use serde::Serialize;

use super::failures::region::{Awake, least_awake};
use super::fit::Found;
use super::report::REGION_ERROR;
use super::study::{OnBlock, OnOrgan, named};
use super::sweep::{Curve, STATIC};
use crate::error::Error;
use crate::paper::report::Claim;
use crate::paper_method::region::ContactPressure;
use palpate_tissue::output::OutputFolder;

#[derive(Serialize)]
struct Summary<'a> {
    paper: &'static str,
    quick: bool,
    scenes: Vec<Scene<'a>>,
    walks: Vec<Walk>,
    printed_stiffness_n_per_m: f64,
    printed_damping_n_s_per_m: f64,
    steps: Vec<Step>,
    correction: Vec<Correction>,
    region_at_2_pct: Vec<Region>,
    volume_force_net_share_mean: f64,
    volume_force_net_share_most: f64,
    claims: &'a [Claim],
}

#[derive(Serialize)]
struct Scene<'a> {
    name: &'a str,
    nodes: usize,
    tets: usize,
    walk: Option<Walk>,
    least_stress_pa: Option<f32>,
    methods: Vec<Method>,
}

#[derive(Serialize)]
struct Method {
    name: &'static str,
    step_s: Option<f64>,
    rms_depth_error_pct: Option<f64>,
    ended: Option<String>,
    presses: Vec<Press>,
}

#[derive(Serialize)]
struct Press {
    force_n: f64,
    depth_m: f64,
    virtual_s: Option<f64>,
    cpu_s: f64,
}

#[derive(Serialize)]
struct Walk {
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
    distance_mm: f64,
    simulations: usize,
    without_answer: usize,
}

#[derive(Serialize)]
struct Step {
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
    largest_step_s: f64,
}

#[derive(Serialize)]
struct Correction {
    name: String,
    step_s: Vec<f64>,
    force_n: Vec<f64>,
}

#[derive(Serialize)]
struct Region {
    pressure: &'static str,
    least_stress_pa: Option<f64>,
    radius_m: Option<f64>,
    awake_share: Option<f64>,
    force_error: Option<f64>,
}

/// Writes `summary.json`.
///
/// # Errors
/// The folder cannot be written.
pub(super) fn write(
    folder: &OutputFolder,
    quick: bool,
    block: &OnBlock,
    organs: &[OnOrgan],
    claims: &[Claim],
) -> Result<(), Error> {
    let size = block.block.size();
    let on_block = Scene {
        name: "block",
        nodes: size.nodes,
        tets: size.tets,
        walk: None,
        least_stress_pa: None,
        methods: methods(&block.curves),
    };
    let on_organs = organs.iter().map(|o| {
        let size = o.site.block.size();
        Scene {
            name: &o.scene.name,
            nodes: size.nodes,
            tets: size.tets,
            walk: Some(walk(&o.walk)),
            least_stress_pa: o.fitted.region.map(|r| r.least_stress_pa),
            methods: methods(&o.curves),
        }
    });
    let region = |pressure, name| {
        let least: Option<Awake> = least_awake(&block.region, pressure, REGION_ERROR);
        Region {
            pressure: name,
            least_stress_pa: least.map(|a| a.least_stress_pa),
            radius_m: least.map(|a| a.radius_m),
            awake_share: least.map(|a| a.share),
            force_error: least.map(|a| a.force_error),
        }
    };
    let [printed_k, printed_d] = super::identifiability::PRINTED;
    let summary = Summary {
        paper: "local-compression",
        quick,
        scenes: std::iter::once(on_block).chain(on_organs).collect(),
        walks: block.walks.iter().map(walk).collect(),
        printed_stiffness_n_per_m: printed_k,
        printed_damping_n_s_per_m: printed_d,
        steps: block
            .steps
            .iter()
            .map(|([k, d], step_s)| Step { stiffness_n_per_m: *k, damping_n_s_per_m: *d, largest_step_s: *step_s })
            .collect(),
        correction: block
            .correction
            .iter()
            .map(|c| Correction {
                name: c.compensation.name(),
                step_s: c.points.iter().map(|p| p.0).collect(),
                force_n: c.points.iter().map(|p| p.1).collect(),
            })
            .collect(),
        region_at_2_pct: vec![
            region(ContactPressure::UniformLoad, "uniform load"),
            region(ContactPressure::RigidPunch, "rigid punch"),
        ],
        volume_force_net_share_mean: block.volume.0[0],
        volume_force_net_share_most: block.volume.0[1],
        claims,
    };
    Ok(folder.write_summary(&summary)?)
}

fn methods(curves: &[Curve]) -> Vec<Method> {
    let truth = named(curves, STATIC);
    let method = |c: &Curve| Method {
        name: c.name,
        step_s: c.step_s,
        rms_depth_error_pct: truth.and_then(|t| c.depth_error(t)).map(|(rms, _)| rms * 100.0),
        ended: c.ended.clone(),
        presses: c
            .points
            .iter()
            .map(|p| Press { force_n: p.force_n, depth_m: p.depth_m, virtual_s: p.virtual_s, cpu_s: p.cpu_s })
            .collect(),
    };
    curves.iter().map(method).collect()
}

fn walk(found: &Found) -> Walk {
    Walk {
        stiffness_n_per_m: found.best.stiffness_n_per_m,
        damping_n_s_per_m: found.best.damping_n_s_per_m,
        distance_mm: found.best.distance_mm,
        simulations: found.simulations[0],
        without_answer: found.simulations[1],
    }
}

/// Prints a short table: every method under one force, on every scene.
pub fn print(block: &OnBlock, organs: &[OnOrgan]) {
    const FORCE_N: f64 = 1.6;
    println!(
        "depth error: from our static finite elements, over all forces; ms to rest: processor time until the press stands still"
    );
    println!("{:<16} {:<28} {:>18} {:>22} {:>12}", "scene", "method", "mm deep at 1.6 N", "depth error, rms %", "ms to rest");
    let scenes = std::iter::once(("block", &block.curves)).chain(organs.iter().map(|o| (o.scene.name.as_str(), &o.curves)));
    for (scene, curves) in scenes {
        let truth = named(curves, STATIC);
        for curve in curves {
            let point = curve.at(FORCE_N);
            let depth = point.map_or("-".into(), |p| format!("{:.2}", p.depth_m * 1e3));
            let error = truth
                .and_then(|t| curve.depth_error(t))
                .map_or("-".into(), |(rms, n)| format!("{:.1} ({n} forces)", rms * 100.0));
            let time = point.map_or("-".into(), |p| format!("{:.1}", p.cpu_s * 1e3));
            println!("{scene:<16} {:<28} {depth:>18} {error:>22} {time:>12}", curve.name);
        }
    }
}
