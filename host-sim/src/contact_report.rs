//! The contact map of a press: its table, its picture, and its description.

use palpate_charts::{self as charts, Contact};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::contact::DeepestContact;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use serde::Serialize;

use crate::error::Error;

/// `contact` of `summary.json`: [`palpate::ContactMap`] at the deepest point.
#[derive(Debug, Serialize)]
pub struct ContactSummary {
    t_s: f64,
    /// Commanded depth of the tip [m].
    depth_m: f64,
    area_m2: f32,
    centre_m: [f32; 3],
    force_n: [f32; 3],
    friction_n: [f32; 3],
    torque_nm: [f32; 3],
    axes: [[f32; 3]; 2],
    half_lengths_m: [f32; 2],
    peak_pressure_pa: f32,
    triangles: u16,
}

impl ContactSummary {
    /// Summary of a contact.
    pub fn of(contact: &DeepestContact) -> Self {
        let map = &contact.map;
        Self {
            t_s: contact.t_s,
            depth_m: contact.depth_m,
            area_m2: map.area_m2,
            centre_m: map.centre_m.into(),
            force_n: map.force_n.into(),
            friction_n: map.friction_n.into(),
            torque_nm: map.torque_nm.into(),
            axes: map.axes.map(Into::into),
            half_lengths_m: map.half_lengths_m,
            peak_pressure_pa: map.peak_pressure_pa,
            triangles: map.triangles,
        }
    }
}

/// Describes the contact in one line.
pub fn sentence(contact: Option<&DeepestContact>) -> String {
    let Some(DeepestContact { depth_m, map, .. }) = contact else { return "nothing was touched: no contact map".into() };
    let [x, y, z] = (map.centre_m * 1e3).into();
    let [a, b] = map.half_lengths_m.map(|half_m| half_m * 1e3);
    format!(
        "{:.1} mm2 at {:.2} mm; centre ({x:.2}, {y:.2}, {z:.2}) mm, half-axes {a:.2} and {b:.2} mm; pressure {:.3} kPa at most, {:.3} on average",
        map.area_m2 * 1e6,
        depth_m * 1e3,
        map.peak_pressure_pa * 1e-3,
        map.force_n.norm() / map.area_m2 * 1e-3,
    )
}

/// Writes contact.csv, with the triangles that exert pressure, and their picture.
pub fn write(folder: &OutputFolder, scene: &Scene, session: &Session, contact: &DeepestContact) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let corners = |nodes: [u16; 3]| nodes.map(|n| contact.nodes_m[usize::from(n)].cast::<f64>());
    let rows = model.triangles.iter().zip(&contact.pressure_pa).enumerate().filter(|(_, (_, p))| **p > 0.0);
    let rows = rows.map(|(number, (triangle, pressure_pa))| {
        let [a, b, c] = corners(triangle.node);
        let centroid = (a + b + c) / 3.0;
        let area_m2 = 0.5 * (b - a).cross(&(c - a)).norm();
        [number as f64, centroid.x, centroid.y, centroid.z, area_m2, f64::from(*pressure_pa)]
    });
    let header = ["triangle", "centroid_x_m", "centroid_y_m", "centroid_z_m", "area_m2", "pressure_pa"];
    folder.write_csv("contact.csv", header, rows)?;
    let map = &contact.map;
    let corners_m: Vec<_> = model.triangles.iter().map(|t| corners(t.node).map(Into::into)).collect();
    let pressure_pa: Vec<_> = contact.pressure_pa.iter().map(|p| f64::from(*p)).collect();
    let [a, b] = [0, 1].map(|k| (map.axes[k] * map.half_lengths_m[k]).cast::<f64>().into());
    let picture = Contact {
        scene: &scene.name,
        caption: &format!(
            "{:.2} mm deep: {:.1} mm², {:.3} N, at most {:.2} kPa",
            contact.depth_m * 1e3,
            map.area_m2 * 1e6,
            map.force_n.norm(),
            map.peak_pressure_pa * 1e-3
        ),
        corners_m: &corners_m,
        pressure_pa: &pressure_pa,
        axis: session.params.probe.axis.map(f64::from).into(),
        centre_m: map.centre_m.map(f64::from).into(),
        half_axes_m: [a, b],
    };
    Ok(charts::contact(folder.draft(), "contact", &picture)?)
}
