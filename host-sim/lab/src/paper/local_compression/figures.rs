//! Pictures of the report.

use palpate::Vector3;

use super::site::Site;
use super::sweep::Point;
use crate::error::Error;
use palpate_charts::{self as charts, Probe, ProbeShape, Surface};
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::output::OutputFolder;

/// Figs. 5 and 6: the organ with the finger, before the press or under a force; shows the whole
/// organ or the part within some finger radii of the site.
pub fn pressed(
    folder: &OutputFolder,
    name: &str,
    scene: &str,
    site: &Site,
    press: Option<&Point>,
    radii: Option<f64>,
) -> Result<(), Error> {
    /// Height of the finger above the skin before the press [m].
    const ABOVE_M: f64 = 0.004;
    let tissue = &site.block.tissue;
    let deformed_m: Vec<[f64; 3]> = match press {
        Some(point) => point.position_m.iter().map(|x| (*x).into()).collect(),
        None => tissue.mesh.nodes_m.clone(),
    };
    let axis: Vector3<f64> = site.block.params.probe.axis.cast();
    let tip = Vector3::from(tissue.site_m) - axis * press.map_or(-ABOVE_M, |p| p.depth_m);
    let caption = match press {
        Some(p) => {
            format!("{} N, {:.1} mm deep; {} nodes, the product on the core", p.force_n, p.depth_m * 1e3, deformed_m.len())
        }
        None => format!("before interaction; {} nodes", deformed_m.len()),
    };
    let probe_radius_m = f64::from(site.block.params.probe.radius_m);
    let near = |n: u32| {
        let away = Vector3::from(tissue.mesh.nodes_m[n as usize]) - Vector3::from(tissue.site_m);
        radii.is_none_or(|radii| away.norm() <= radii * probe_radius_m)
    };
    let shown: Vec<[u32; 3]> = surface(&tissue.mesh.tets).into_iter().filter(|t| t.iter().all(|n| near(*n))).collect();
    let picture = Surface {
        scene,
        caption: &caption,
        rest_m: &tissue.mesh.nodes_m,
        deformed_m: &deformed_m,
        triangles: &shown,
        probe: Probe { shape: ProbeShape::Hemisphere, radius_m: probe_radius_m, tip_m: tip.into(), axis: axis.into() },
    };
    Ok(charts::surface(folder.draft(), name, &picture)?)
}
