//! Charts and pictures of the report. Each function writes NAME.svg and NAME.png, and for curves
//! also NAME.csv.

use std::fmt::Write;

use palpate::Vector3;

use super::fit::Found;
use super::site::Site;
use super::sweep::{Curve, Point};
use crate::error::Error;
use palpate_charts::{self as charts, Level, LineSeries, Lines, Probe, ProbeShape, Scale, ScaledAxis, Surface};
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::output::OutputFolder;

/// Name, heading and axes of a chart.
#[derive(Clone, Copy, Debug)]
pub struct Words<'a> {
    /// File name without its extension.
    pub name: &'a str,
    /// First line of the heading.
    pub title: &'a str,
    /// Second line of the heading.
    pub below: &'a str,
    /// Quantity and unit of the horizontal axis, and its scale.
    pub x: (&'a str, Scale),
    /// Quantity and unit of the vertical axis, and its scale.
    pub y: (&'a str, Scale),
}

/// Draws named curves and writes them as CSV with one row per point. Curves without points are left
/// out.
///
/// # Errors
/// Fails if a value cannot be drawn, or if the folder cannot be written.
pub fn curves(
    folder: &OutputFolder,
    words: &Words,
    curves: &[(String, Vec<(f64, f64)>)],
    levels: &[(&str, f64)],
) -> Result<(), Error> {
    let series: Vec<LineSeries> = curves
        .iter()
        .filter(|(_, points)| !points.is_empty())
        .map(|(name, points)| LineSeries { name, points: points.clone(), joined: true, marked: points.len() <= 60 })
        .collect();
    let levels: Vec<Level> = levels.iter().map(|(name, y)| Level { name, y: *y }).collect();
    let axis = |(title, scale)| ScaledAxis { title, scale };
    let chart =
        Lines { title: words.title, below: words.below, x: axis(words.x), y: axis(words.y), series: &series, levels: &levels };
    charts::lines(folder.draft(), words.name, &chart)?;
    let column = |title: &str| title.replace([' ', '[', ']', '(', ')'], "_").replace("__", "_").trim_matches('_').to_lowercase();
    let mut text = format!("curve,{},{}\n", column(words.x.0), column(words.y.0));
    for (name, points) in curves {
        for (x, y) in points {
            let _ = writeln!(text, "\"{name}\",{x},{y}");
        }
    }
    Ok(folder.write(&format!("{}.csv", words.name), text.as_bytes())?)
}

/// Fig. 7: k and d against temperature.
///
/// # Errors
/// Errors of [`curves`].
pub fn annealing(folder: &OutputFolder, below: &str, walks: &[Found]) -> Result<(), Error> {
    let of = |pick: fn(&super::fit::Step) -> f64| -> Vec<(String, Vec<(f64, f64)>)> {
        let walk = |(n, found): (usize, &Found)| {
            (format!("walk {}", n + 1), found.steps.iter().map(|s| (s.temperature_mm, pick(s))).collect())
        };
        walks.iter().enumerate().map(walk).collect()
    };
    let x = ("temperature [mm]", Scale::Log);
    let stiffness = Words {
        name: "fig7_stiffness",
        title: "Fig. 7: spring stiffness k against temperature",
        below,
        x,
        y: ("k [N/m]", Scale::Log),
    };
    curves(folder, &stiffness, &of(|s| s.stiffness_n_per_m), &[("the paper's 0.91 N/mm", super::identifiability::PRINTED[0])])?;
    let damping =
        Words { name: "fig7_damping", title: "Fig. 7: damping d against temperature", below, x, y: ("d [N s/m]", Scale::Log) };
    curves(folder, &damping, &of(|s| s.damping_n_s_per_m), &[("the paper's 3.11", super::identifiability::PRINTED[1])])
}

/// Fig. 8: force against displacement.
///
/// # Errors
/// Errors of [`curves`].
pub fn force_displacement(folder: &OutputFolder, scene: &str, below: &str, found: &[Curve]) -> Result<(), Error> {
    let with_origin = |c: &Curve| {
        let points = c.points.iter().map(|p| (p.depth_m * 1e3, p.force_n));
        (c.name.to_owned(), std::iter::once((0.0, 0.0)).chain(points).collect())
    };
    let all: Vec<(String, Vec<(f64, f64)>)> = found.iter().filter(|c| !c.points.is_empty()).map(with_origin).collect();
    let (name, title) = (format!("fig8_{scene}"), format!("Fig. 8, {scene}: force against displacement at rest"));
    let words =
        Words { name: &name, title: &title, below, x: ("displacement [mm]", Scale::Linear), y: ("force [N]", Scale::Linear) };
    curves(folder, &words, &all, &[])
}

/// Fig. 9: CPU time from load to rest.
///
/// # Errors
/// Errors of [`curves`].
pub fn time_to_rest(folder: &OutputFolder, scene: &str, below: &str, found: &[Curve]) -> Result<(), Error> {
    let points = |c: &Curve| (c.name.to_owned(), c.points.iter().map(|p| (p.force_n, p.cpu_s * 1e3)).collect());
    let all: Vec<(String, Vec<(f64, f64)>)> = found.iter().filter(|c| !c.points.is_empty()).map(points).collect();
    let (name, title) = (format!("fig9_{scene}"), format!("Fig. 9, {scene}: CPU time from load to rest"));
    let words = Words { name: &name, title: &title, below, x: ("force [N]", Scale::Linear), y: ("CPU time [ms]", Scale::Log) };
    curves(folder, &words, &all, &[])
}

/// Figs. 5 and 6: the organ with the finger, before the press or under a force; shows the whole
/// organ or the part within some finger radii of the site.
///
/// # Errors
/// Errors of [`curves`].
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
