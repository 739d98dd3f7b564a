//! Draws the tissue cut open under the probe: at rest, halfway and at its deepest.

use palpate_charts::{self as charts, Moment, Probe, Section};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::{Hold, Press};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

use crate::error::Error;

/// Draws `section`, if the press has a hold; `probe_at` returns the probe with its tip at a
/// position [m].
pub fn draw(
    folder: &OutputFolder,
    scene: &Scene,
    session: &Session,
    press: &Press,
    probe_at: impl Fn([f64; 3]) -> Probe,
) -> Result<(), Error> {
    let by_depth = |a: &&Hold, b: &&Hold| a.depth_m.total_cmp(&b.depth_m);
    let Some(deepest) = press.holds.iter().max_by(by_depth) else { return Ok(()) };
    let off_half_m = |hold: &&Hold| (hold.depth_m - 0.5 * deepest.depth_m).abs();
    let others = press.holds.iter().filter(|hold| hold.depth_m < 0.9 * deepest.depth_m && hold.depth_m > 0.0);
    let halfway = others.min_by(|a, b| off_half_m(a).total_cmp(&off_half_m(b)));

    let model = session.patch.wide_model();
    let rest_m: Vec<[f64; 3]> = model.nodes.iter().map(|n| n.rest_m.map(f64::from)).collect();
    let tets: Vec<[u32; 4]> = model.tets.iter().map(|tet| tet.node.map(u32::from)).collect();
    let triangles: Vec<[u32; 3]> = model.triangles.iter().map(|t| t.node.map(u32::from)).collect();
    let mut fixed = vec![false; rest_m.len()];
    for anchor in model.anchors {
        fixed[usize::from(*anchor)] = true;
    }
    let balls_m: Vec<([f64; 3], f64)> = scene.tissue.inclusion.iter().map(|ball| (ball.center_m, ball.radius_m)).collect();
    let deformed_m = |hold: &Hold| -> Vec<[f64; 3]> {
        rest_m.iter().zip(&hold.surface_displacement_m).map(|(x, u)| [0, 1, 2].map(|k| x[k] + f64::from(u[k]))).collect()
    };
    let pressed: Vec<(&Hold, Vec<[f64; 3]>)> =
        halfway.into_iter().chain([deepest]).map(|hold| (hold, deformed_m(hold))).collect();

    let axis = session.params.probe.axis.cast::<f64>();
    let touch_m = deepest.tip_m.cast::<f64>() + axis * deepest.depth_m;
    let rest = Moment { deformed_m: &rest_m, probe: probe_at(touch_m.into()), depth_m: 0.0, force_n: 0.0 };
    let mut moments = vec![rest];
    for (hold, deformed_m) in &pressed {
        let probe = probe_at(hold.tip_m.map(f64::from).into());
        moments.push(Moment { deformed_m, probe, depth_m: hold.depth_m, force_n: hold.force_n });
    }
    let caption = format!("{} nodes; tissue and finger are cut in half through the place that is pressed", session.report.nodes);
    let section = Section {
        scene: &scene.name,
        caption: &caption,
        rest_m: &rest_m,
        tets: &tets,
        triangles: &triangles,
        fixed: &fixed,
        balls_m: &balls_m,
        up: axis.into(),
        moments: &moments,
    };
    Ok(charts::section(folder.draft(), "section", &section)?)
}
