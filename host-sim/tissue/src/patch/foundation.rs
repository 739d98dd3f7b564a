//! Foundation of a surface: its stiffness per area is a few times E over the element size, divided
//! among the points of each triangle.

use palpate::stages::force::foundation::point_weights;
use palpate::{FoundationPoint, Triangle};

use super::{Material, Multipliers};
use crate::mesh::quality::element_size;
use crate::tissue::Tissue;

pub(super) struct Foundation {
    pub triangles: Vec<Triangle>,
    pub points: Vec<FoundationPoint>,
    pub stiffening_per_m: f64,
    /// Element size at the site [m].
    pub element_m: f64,
}

pub(super) fn of(tissue: &Tissue, material: &Material, multipliers: Option<&Multipliers>) -> Foundation {
    let surface = &tissue.skin;
    let nodes = &tissue.mesh.nodes_m;
    let corners = |t: &[u32; 3]| t.map(|n| nodes[n as usize]);
    let areas: Vec<f64> = surface.iter().map(|t| area(corners(t))).collect();
    // the patch has one value of stiffening, by the element size at the site
    let nearest = surface.iter().zip(&areas).min_by(|(s, _), (t, _)| {
        distance_squared(centroid(corners(s)), tissue.site_m).total_cmp(&distance_squared(centroid(corners(t)), tissue.site_m))
    });
    let element_m = nearest.map_or(1.0, |(_, &a)| element_size(a));
    let stiffening = material.foundation_stiffening / element_m * multipliers.map_or(1.0, |m| m.stiffening);

    let mut triangles = Vec::with_capacity(surface.len());
    let weights = point_weights(material.points_per_triangle);
    let mut points = Vec::with_capacity(weights.len() * surface.len());
    for (at, (t, &a)) in surface.iter().zip(&areas).enumerate() {
        let h = element_size(a);
        let per_point = material.foundation_stiffness / h * a / weights.len() as f64;
        for point in 0..weights.len() {
            let k = per_point * multipliers.map_or(1.0, |m| m.point[at][point]);
            points.push(FoundationPoint { k: k as f32 });
        }
        triangles.push(Triangle { node: t.map(|n| n as u16), reserved: 0 });
    }
    Foundation { triangles, points, stiffening_per_m: stiffening, element_m }
}

fn area([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    0.5 * n.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn centroid(corners: [[f64; 3]; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 3.0)
}

fn distance_squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
