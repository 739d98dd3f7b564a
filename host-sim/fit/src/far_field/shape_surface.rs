//! The surface of the shape around a site, finer than the facets of the mesh.

use palpate_tissue::mesh::triangle::entry_m;
use palpate_tissue::tissue::Placed;
use palpate_tissue::tissue::organ_source::OrganSource;

use crate::statics::Vector;

/// Distance from the site up to which the surface is known [reaches of the probe].
const NEAR: f64 = 3.0;
/// Number of parts into which a facet's sides are divided: the distance from the shape falls with
/// its square.
const PARTS: usize = 3;

/// Triangles around a site whose corners lie on the shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeSurface {
    /// Corners of the triangles, relative to the site [m].
    triangles_m: Vec<[Vector; 3]>,
    /// Unit vector from the surface to the handle.
    pub axis: Vector,
    /// Height above the site from which the surface is looked at [m].
    high_m: f64,
}

impl ShapeSurface {
    /// The surface of a shape around the site of its mesh; without a shape, the mesh's own.
    /// `reach_m` is that of the probe.
    #[must_use]
    pub fn of(placed: &Placed, shape: Option<&OrganSource>, reach_m: f64) -> Self {
        let site_m = Vector::from(placed.tissue.site_m);
        let place_m = |n: u32| Vector::from(placed.tissue.mesh.nodes_m[n as usize]) - site_m;
        let near = placed.tissue.skin.iter().map(|t| t.map(place_m));
        let near = near.filter(|t: &[Vector; 3]| t.iter().any(|x| x.norm() < NEAR * reach_m));
        let on_shape = |x: Vector| match shape {
            Some(shape) => Vector::from(shape.nearest_m((x + site_m).into())) - site_m,
            None => x,
        };
        let parts = if shape.is_some() { PARTS } else { 1 };
        let triangles_m = near.flat_map(|t| divided(t, parts)).map(|t| t.map(on_shape)).collect();
        Self::around(triangles_m, placed.axis.into(), reach_m)
    }

    /// A surface of these triangles, relative to the site [m].
    #[must_use]
    pub fn around(triangles_m: Vec<[Vector; 3]>, axis: Vector, reach_m: f64) -> Self {
        Self { triangles_m, axis, high_m: (NEAR + 1.0) * reach_m }
    }

    /// Height of the surface above the site, along the axis, at a point relative to the site [m]:
    /// of several, the one nearest to the site's plane. `None` beside the surface.
    #[must_use]
    pub fn height_m(&self, at_m: Vector) -> Option<f64> {
        let foot = at_m - self.axis * at_m.dot(&self.axis);
        let from = foot + self.axis * self.high_m;
        let ways = self.triangles_m.iter().filter_map(|t| entry_m(*t, &from, &-self.axis));
        let way_m = ways.min_by(|a, b| (a - self.high_m).abs().total_cmp(&(b - self.high_m).abs()))?;
        Some(self.high_m - way_m)
    }
}

/// The parts of a triangle whose sides are divided evenly.
fn divided([a, b, c]: [Vector; 3], parts: usize) -> Vec<[Vector; 3]> {
    let at = |i: usize, j: usize| a + (b - a) * (i as f64 / parts as f64) + (c - a) * (j as f64 / parts as f64);
    let pairs = (0..parts).flat_map(|i| (0..parts - i).map(move |j| (i, j)));
    let mut divided = Vec::with_capacity(parts * parts);
    for (i, j) in pairs {
        divided.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
        if i + j + 1 < parts {
            divided.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    divided
}
