//! Closed surfaces of simple bodies, as STL text in millimetres.

use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Numbers of corners around a dome, and of rings from its top to its edge.
const AROUND: usize = 96;
const RINGS: usize = 24;
/// Least distance of a site from an edge [mm].
const LEAST_FROM_EDGE_MM: f64 = 8.0;

type P = [f64; 3];

/// A body that stands on z = 0; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Body {
    /// Cap of a sphere on a cylinder.
    Dome { sphere_mm: f64, rim_mm: f64, base_mm: f64 },
    /// The upper side is a chain of straight lines in x, from one end to the other.
    Prism { name: &'static str, top_mm: Vec<[f64; 2]>, half_mm: f64 },
}

impl Body {
    /// Draws one of five kinds in turn; `between` draws a number from a range.
    pub fn draw(number: u64, between: &mut impl FnMut(f64, f64) -> f64) -> Self {
        let prism = |name, top_mm: Vec<[f64; 2]>| Self::Prism { name, top_mm, half_mm: 34.0 };
        match number % 5 {
            0 => Self::Dome { sphere_mm: between(30.0, 70.0), rim_mm: 28.0, base_mm: between(8.0, 20.0) },
            1 => {
                let high = between(20.0, 45.0);
                prism("block", vec![[40.0, high], [-40.0, high]])
            }
            2 => {
                let (low, rise) = (between(18.0, 26.0), between(8.0, 30.0));
                prism("wedge", vec![[40.0, low], [-40.0, low + rise]])
            }
            3 => {
                let (low, step) = (between(20.0, 28.0), between(4.0, 10.0));
                prism("step", vec![[40.0, low], [6.0, low], [5.0, low + step], [-40.0, low + step]])
            }
            _ => {
                let (low, rise) = (between(18.0, 26.0), between(5.0, 16.0));
                prism("ridge", vec![[40.0, low], [0.0, low + rise], [-40.0, low]])
            }
        }
    }

    /// Draws a site [m], at least 8 mm from an edge.
    pub fn site_m(&self, between: &mut impl FnMut(f64, f64) -> f64) -> P {
        let mm = match self {
            Self::Dome { sphere_mm, rim_mm, base_mm } => {
                let (away, angle) = (between(0.0, 0.5 * rim_mm), between(0.0, TAU));
                let z = (sphere_mm * sphere_mm - away * away).sqrt() - (sphere_mm * sphere_mm - rim_mm * rim_mm).sqrt();
                [away * angle.cos(), away * angle.sin(), base_mm + z]
            }
            Self::Prism { top_mm, half_mm, .. } => {
                // beside the middle edge, on the side of the last line
                let y = half_mm - LEAST_FROM_EDGE_MM;
                let x = between(-32.0, top_mm[top_mm.len() - 2][0].min(LEAST_FROM_EDGE_MM) - LEAST_FROM_EDGE_MM);
                let ([xa, za], [xb, zb]) = (top_mm[top_mm.len() - 2], top_mm[top_mm.len() - 1]);
                [x, between(-y, y), za + (zb - za) * (x - xa) / (xb - xa)]
            }
        };
        mm.map(|mm| (mm * 100.0).round() / 1e5)
    }

    pub fn words(&self) -> String {
        match self {
            Self::Dome { sphere_mm, .. } => format!("dome of radius {sphere_mm:.0} mm"),
            Self::Prism { name, top_mm, .. } => {
                let heights = top_mm.iter().map(|[_, z]| *z);
                let (low, high) = heights.fold((f64::MAX, 0.0_f64), |(low, high), z| (low.min(z), high.max(z)));
                format!("{name} {low:.0} to {high:.0} mm high")
            }
        }
    }

    /// Surface as STL text.
    pub fn stl(&self) -> String {
        let triangles = match self {
            Self::Dome { sphere_mm, rim_mm, base_mm } => dome(*sphere_mm, *rim_mm, *base_mm),
            Self::Prism { top_mm, half_mm, .. } => prism(top_mm, *half_mm),
        };
        let mut text = String::from("solid body\n");
        for triangle in triangles {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle {
                let _ = writeln!(text, "vertex {x:.6} {y:.6} {z:.6}");
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid body\n"
    }
}

fn dome(sphere: f64, rim: f64, base: f64) -> Vec<[P; 3]> {
    let (widest, below) = ((rim / sphere).asin(), (sphere * sphere - rim * rim).sqrt());
    let at = |ring: usize, k: usize| {
        let (polar, turn) = (widest * ring as f64 / RINGS as f64, TAU * (k % AROUND) as f64 / AROUND as f64);
        [sphere * polar.sin() * turn.cos(), sphere * polar.sin() * turn.sin(), sphere * polar.cos() - below + base]
    };
    let foot = |k: usize| {
        let [x, y, _] = at(RINGS, k);
        [x, y, 0.0]
    };
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([at(0, 0), at(1, k), at(1, k + 1)]);
        for ring in 1..RINGS {
            triangles.push([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            triangles.push([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
        triangles.push([at(RINGS, k), foot(k), foot(k + 1)]);
        triangles.push([at(RINGS, k), foot(k + 1), at(RINGS, k + 1)]);
        triangles.push([[0.0; 3], foot(k + 1), foot(k)]);
    }
    triangles
}

/// A prism along y with this upper side, whose x falls from corner to corner, and whose lower side
/// is z = 0. Its ends are divided at every corner of the upper side.
fn prism(top: &[[f64; 2]], half: f64) -> Vec<[P; 3]> {
    let upper = |n: usize, y: f64| [top[n][0], y, top[n][1]];
    let lower = |n: usize, y: f64| [top[n][0], y, 0.0];
    let mut triangles = Vec::new();
    for n in 1..top.len() {
        let m = n - 1;
        triangles.push([upper(m, -half), upper(m, half), upper(n, half)]);
        triangles.push([upper(m, -half), upper(n, half), upper(n, -half)]);
        triangles.push([lower(m, half), lower(m, -half), lower(n, -half)]);
        triangles.push([lower(m, half), lower(n, -half), lower(n, half)]);
        triangles.push([lower(m, -half), upper(m, -half), upper(n, -half)]);
        triangles.push([lower(m, -half), upper(n, -half), lower(n, -half)]);
        triangles.push([lower(m, half), upper(n, half), upper(m, half)]);
        triangles.push([lower(m, half), lower(n, half), upper(n, half)]);
    }
    for (n, turned) in [(0, false), (top.len() - 1, true)] {
        let [a, b, c, d] = [lower(n, -half), lower(n, half), upper(n, half), upper(n, -half)];
        triangles.extend(if turned { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] });
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_tissue::mesh::ClosedSurface;

    #[test]
    fn every_body_is_closed_and_its_site_is_on_it() {
        for number in 0..40 {
            let mut state = number;
            let mut between = |low: f64, high: f64| {
                state = (state * 6_364_136 + 1_442_695) % 1_000_003;
                low + (high - low) * state as f64 / 1_000_003.0
            };
            let body = Body::draw(number, &mut between);
            let site_m = body.site_m(&mut between);
            let triangles = match &body {
                Body::Dome { sphere_mm, rim_mm, base_mm } => dome(*sphere_mm, *rim_mm, *base_mm),
                Body::Prism { top_mm, half_mm, .. } => prism(top_mm, *half_mm),
            };
            let mut corners: Vec<P> = Vec::new();
            let indices: Vec<[u32; 3]> = triangles
                .iter()
                .map(|t| {
                    t.map(|x| {
                        let x = x.map(|mm| (mm * 1e6).round() / 1e9);
                        let found = corners.iter().position(|known| *known == x);
                        found.unwrap_or_else(|| {
                            corners.push(x);
                            corners.len() - 1
                        }) as u32
                    })
                })
                .collect();
            let surface = ClosedSurface::of_triangles(&corners, &indices).expect("a closed surface");
            let off_m = surface.foot(site_m).distance_m.abs();
            assert!(off_m < 2e-5, "{}: {off_m}", body.words());
        }
    }
}
