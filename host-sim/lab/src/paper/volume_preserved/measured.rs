//! Measures of a deformation of the scene: displacements of landmarks and surface points, and
//! changes of volume. Finite elements and springs are measured in the same way: a linear mesh is
//! treated as a quadratic one whose mid-edge nodes stay at the midpoints.

use nalgebra::Vector3;

use super::assembly::Assembly;
use crate::hanging::locate::Locator;

/// Measures of one deformation.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Displacement of each landmark [m].
    pub landmarks_m: Vec<Vector3<f64>>,
    /// Displacement of each sampled surface point [m].
    pub surface_m: Vec<Vector3<f64>>,
    /// Change of volume of each organ [%].
    pub volume_change_pct: Vec<f64>,
    /// Smallest local volume ratio (1); at or below zero an element is inside out.
    pub min_j: f64,
    /// Displacement of every node of the quadratic mesh [m].
    pub displacement_m: Vec<Vector3<f64>>,
}

impl Measured {
    /// Measures the deformation given by displacements of the nodes of `assembly.quadratic` [m].
    pub fn of(assembly: &Assembly, displacement_m: Vec<Vector3<f64>>) -> Self {
        let locator = Locator::new(&assembly.quadratic, &assembly.organs[0], f64::MAX);
        let at = |point: &Vector3<f64>| locator.displacement_at(&displacement_m, point).unwrap_or_else(Vector3::zeros);
        let volumes: Vec<_> = assembly.organs.iter().map(|organ| organ.volume(&assembly.quadratic, &displacement_m)).collect();
        Self {
            landmarks_m: assembly.landmarks.iter().map(|(_, point)| at(point)).collect(),
            surface_m: assembly.surface.iter().map(at).collect(),
            volume_change_pct: volumes.iter().map(|v| 100.0 * (v.now_m3 / v.rest_m3 - 1.0)).collect(),
            min_j: volumes.iter().map(|v| v.least_j).fold(f64::INFINITY, f64::min),
            displacement_m,
        }
    }

    /// Measures the deformation given by displacements of the corner nodes [m], organ after organ.
    pub fn of_corners(assembly: &Assembly, corners_m: &[Vector3<f64>]) -> Self {
        let mut displacement_m = vec![Vector3::zeros(); assembly.quadratic.nodes_m.len()];
        let mut corner = 0;
        for (organ, mesh) in assembly.organs.iter().zip(&assembly.meshes) {
            for n in 0..mesh.nodes_m.len() {
                displacement_m[organ.nodes.start + n] = corners_m[corner];
                corner += 1;
            }
        }
        for tet in &assembly.quadratic.tets {
            for (edge, [i, j]) in palpate_fit::reference::shape::TET_EDGES.into_iter().enumerate() {
                displacement_m[tet[4 + edge] as usize] =
                    (displacement_m[tet[i] as usize] + displacement_m[tet[j] as usize]) * 0.5;
            }
        }
        Self::of(assembly, displacement_m)
    }

    /// Distance of each landmark from its reference position (13) [m].
    pub fn landmark_errors_m(&self, truth: &Self) -> Vec<f64> {
        distances(&self.landmarks_m, &truth.landmarks_m)
    }

    /// Distance of each surface point from its reference position (13) [m].
    pub fn surface_errors_m(&self, truth: &Self) -> Vec<f64> {
        distances(&self.surface_m, &truth.surface_m)
    }
}

fn distances(found: &[Vector3<f64>], truth: &[Vector3<f64>]) -> Vec<f64> {
    found.iter().zip(truth).map(|(a, b)| (a - b).norm()).collect()
}

/// Mean of the values; zero if there are none.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}
