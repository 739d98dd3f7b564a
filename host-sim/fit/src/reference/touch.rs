//! The rigid probe touching the surface: energy, residual, tangent and force of a frictionless
//! penalty.
//!
//! Penalty on the gap g at seven points of each surface triangle: penalty/2 g^2 per rest area where
//! g < 0.

use nalgebra::Vector3;

use super::body::{Assembled, Body, Contact};
use super::probe::Gap;
use super::shape::{triangle_points, triangle_shape};

/// Contact pressure over Young's modulus that few equilibria reach.
const HIGHEST_PRESSURE: f64 = 3.0;

/// Contact of the probe: force, penetration and area.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touch {
    /// Force on the probe over Young's modulus [m^2], of the whole, not of the piece.
    pub force_m2: Vector3<f64>,
    /// Deepest penetration [m].
    pub penetration_m: f64,
    /// Area in contact at rest [m^2], of the whole.
    pub area_m2: f64,
}

impl Body {
    pub(super) fn add_contact_energy(&self, displacement_m: &[Vector3<f64>], contact: &Contact, energy_m3: &mut f64) {
        self.each_touch(displacement_m, contact, |_, _, area, gap| {
            *energy_m3 += 0.5 * contact.penalty_per_m * area * gap.gap_m * gap.gap_m;
        });
    }

    pub(super) fn add_contact(&self, displacement_m: &[Vector3<f64>], contact: &Contact, sum: &mut Assembled) {
        let penalty = contact.penalty_per_m;
        self.each_touch(displacement_m, contact, |nodes, shape, area, gap| {
            sum.energy_m3 += 0.5 * penalty * area * gap.gap_m * gap.gap_m;
            // the probe's curvature makes the tangent indefinite where a step has not yet been
            // answered: bounded there
            let curved_m = gap.gap_m.max(-HIGHEST_PRESSURE / penalty);
            let block = (gap.normal * gap.normal.transpose() + gap.curvature_per_m * curved_m) * (penalty * area);
            for (a, i) in nodes.iter().enumerate() {
                sum.residual_m2[*i as usize] += gap.normal * (penalty * area * gap.gap_m * shape[a]);
                for (b, j) in nodes[..=a].iter().enumerate() {
                    self.pattern.add(&mut sum.tangent, *i, *j, &(block * (shape[a] * shape[b])));
                }
            }
        });
    }

    /// Returns force, penetration and contact area of the probe at the given displacements.
    #[must_use]
    pub fn touch(&self, displacement_m: &[Vector3<f64>], contact: &Contact) -> Touch {
        let mut touch = Touch::default();
        self.each_touch(displacement_m, contact, |_, _, area, gap| {
            touch.force_m2 += gap.normal * (contact.penalty_per_m * area * gap.gap_m * self.copies);
            touch.penetration_m = touch.penetration_m.max(-gap.gap_m);
            touch.area_m2 += area * self.copies;
        });
        touch
    }

    /// Calls `each` with (nodes, shape functions, rest area, gap) at every point inside the probe.
    fn each_touch(
        &self,
        displacement_m: &[Vector3<f64>],
        contact: &Contact,
        mut each: impl FnMut(&[u32; 6], &[f64; 6], f64, &Gap),
    ) {
        let rule = triangle_points().map(|(at, share)| (triangle_shape(at), share));
        for t in &self.touchable {
            let nodes = &self.mesh.triangles[*t];
            let rest = nodes.map(|n| self.mesh.nodes_m[n as usize]);
            let area = 0.5 * (rest[1] - rest[0]).cross(&(rest[2] - rest[0])).norm();
            let now: [Vector3<f64>; 6] = std::array::from_fn(|k| rest[k] + displacement_m[nodes[k] as usize]);
            for (shape, share) in &rule {
                let x = (0..6).map(|k| now[k] * shape[k]).sum::<Vector3<f64>>();
                let gap = contact.probe.gap(&x);
                if gap.gap_m < 0.0 {
                    each(nodes, shape, share * area, &gap);
                }
            }
        }
    }
}
