//! The answer of finite elements: what the paper took from computed tomography.

use nalgebra::Vector3;

use super::assembly::Assembly;
use super::measured::Measured;
use crate::error::Error;
use crate::reference::body::{Body, Stiffness};
use crate::reference::hang::Hanging;
use crate::reference::locate::Locator;
use crate::reference::shape::TetRule;
use crate::reference::suspension::Suspension;
use crate::reference::tie::layer;

/// The scene's moves, solved.
#[derive(Clone, Debug)]
pub struct Truth {
    /// One for each move of the scene.
    pub moves: Vec<Measured>,
    /// Nodes and tets of the quadratic mesh.
    pub size: [usize; 2],
    /// Newton iterations.
    pub iterations: usize,
}

impl Truth {
    /// The same answer at the landmarks and surface points of another assembly; `own` is the one it was solved on.
    #[must_use]
    pub fn at_points_of(&self, own: &Assembly, other: &Assembly) -> Self {
        let locator = Locator::new(&own.quadratic, &own.organs[0], f64::MAX);
        let moves = self.moves.iter().map(|solved| {
            let at = |point: &Vector3<f64>| locator.displacement_at(&solved.displacement_m, point).unwrap_or_else(Vector3::zeros);
            Measured {
                landmarks_m: other.landmarks.iter().map(|(_, point)| at(point)).collect(),
                surface_m: other.surface.iter().map(at).collect(),
                ..solved.clone()
            }
        });
        Self { moves: moves.collect(), ..*self }
    }
}

/// Solves the scene on an assembly; `progress` hears (move, share of the way).
///
/// # Errors
/// No equilibrium found, or memory for the factor ran out.
pub fn solve(assembly: &Assembly, mut progress: impl FnMut(usize, f64)) -> Result<Truth, Error> {
    let scene = assembly.scene;
    let modulus_pa = scene.organ[0].youngs_modulus_pa;
    let failed = |cause: &dyn std::fmt::Display| Error::Check(format!("{}: finite elements: {cause}", scene.file));
    let mesh = assembly.quadratic.clone();
    let mut fixed = vec![[false; 3]; mesh.nodes_m.len()];
    assembly.fixed.iter().for_each(|n| fixed[*n as usize] = [true; 3]);
    let mut ratios = vec![1.0; mesh.tets.len()];
    let mut densities = vec![0.0; mesh.tets.len()];
    for (organ, of) in assembly.organs.iter().zip(&scene.organ) {
        ratios[organ.tets.clone()].fill(of.youngs_modulus_pa / modulus_pa);
        densities[organ.tets.clone()].fill(of.density_kg_per_m3);
    }
    let per_m = scene.joint.stiffness_pa_per_m / modulus_pa;
    let ties = layer(&mesh, &assembly.joined, &assembly.onto, 2.0 * scene.joint.reach_m, |_| per_m);
    let stiffness = |tet: usize, _: &Vector3<f64>| Stiffness { ratio: ratios[tet], poisson_ratio: scene.poisson_ratio };
    let body = Body::with_stiffness(mesh, stiffness, fixed, Vec::new(), 1.0, TetRule::Four);
    let suspension = Suspension::new(body)
        .with_weight(&densities, Vector3::from(scene.gravity_m_per_s2), modulus_pa)
        .and_then(|s| s.with_ties(ties))
        .and_then(|s| s.with_grip(&assembly.held))
        .map_err(|cause| failed(&cause))?;
    let mut hanging = Hanging::new(&suspension).map_err(|cause| failed(&cause))?;
    let mut moves = Vec::new();
    for (n, to) in scene.attachment.moves_m.iter().enumerate() {
        let grip = vec![Vector3::from(*to); assembly.held.len()];
        hanging.go_to(1.0, &grip, |share| progress(n, share)).map_err(|cause| failed(&cause))?;
        moves.push(Measured::of(assembly, hanging.displacement_m.clone()));
    }
    let body = suspension.body();
    Ok(Truth { moves, size: [body.mesh.nodes_m.len(), body.mesh.tets.len()], iterations: hanging.iterations() })
}
