//! The finite-element reference, in place of the paper's computed tomography.

use nalgebra::Vector3;
use palpate::Fnv;
use serde::{Deserialize, Serialize};

use super::assembly::Assembly;
use super::measured::Measured;
use crate::error::Error;
use crate::hanging::hang::Hanging;
use crate::hanging::suspension::Suspension;
use crate::hanging::tie::layer;
use palpate_fit::reference::body::{Body, Stiffness};
use palpate_fit::reference::shape::TetRule;
use palpate_tissue::Error as TissueError;

/// Finite-element solution of the scene.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Deformation after each move of the scene.
    pub moves: Vec<Measured>,
    /// Numbers of nodes and tets of the quadratic mesh.
    pub size: [usize; 2],
    /// Number of Newton iterations.
    pub iterations: usize,
}

/// Shipped solutions, which take long to compute: of the full resolution, and of the sparse one
/// with every tet cut into eight.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Shipped {
    /// Solution at full resolution.
    pub full: Answer,
    /// Solution on the subdivided sparse mesh, at the landmarks and surface points of the sparse
    /// one.
    pub sparse_subdivided: Answer,
}

/// A solution, reduced to landmarks and surface points.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Answer {
    /// Fingerprint of the scene and mesh to which it belongs.
    pub fingerprint: String,
    /// Numbers of nodes and tets of the quadratic mesh.
    pub size: [usize; 2],
    /// Number of Newton iterations.
    pub iterations: usize,
    /// Deformation after each move.
    pub moves: Vec<AnswerMove>,
}

/// Deformation after one move.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct AnswerMove {
    /// Displacement of each landmark [m].
    pub landmarks_m: Vec<[f64; 3]>,
    /// Displacement of each surface point [m].
    pub surface_m: Vec<[f64; 3]>,
    /// Change of volume of each organ [%].
    pub volume_change_pct: Vec<f64>,
    /// Smallest local volume ratio (1).
    pub min_j: f64,
}

impl Shipped {
    /// The solutions in the repository; `None` if they cannot be read, which a test would detect.
    pub fn load() -> Option<Self> {
        serde_json::from_str(include_str!("../../../../references/hanging-liver.json")).ok()
    }
}

impl Answer {
    /// Reduces a solution to landmarks and surface points.
    pub fn of(assembly: &Assembly, truth: &Truth) -> Self {
        let plain = |vectors: &[Vector3<f64>]| vectors.iter().map(|v| (*v).into()).collect();
        let moves = truth.moves.iter().map(|m| AnswerMove {
            landmarks_m: plain(&m.landmarks_m),
            surface_m: plain(&m.surface_m),
            volume_change_pct: m.volume_change_pct.clone(),
            min_j: m.min_j,
        });
        Self { fingerprint: fingerprint(assembly), size: truth.size, iterations: truth.iterations, moves: moves.collect() }
    }

    /// The solution, without node displacements; `None` if it does not belong to this assembly.
    pub fn for_assembly(&self, assembly: &Assembly) -> Option<Truth> {
        if self.fingerprint != fingerprint(assembly) {
            return None;
        }
        let vectors = |plain: &[[f64; 3]]| plain.iter().map(|v| Vector3::from(*v)).collect();
        let moves = self.moves.iter().map(|m| Measured {
            landmarks_m: vectors(&m.landmarks_m),
            surface_m: vectors(&m.surface_m),
            volume_change_pct: m.volume_change_pct.clone(),
            min_j: m.min_j,
            displacement_m: Vec::new(),
        });
        Some(Truth { moves: moves.collect(), size: self.size, iterations: self.iterations })
    }
}

/// Fingerprint of everything on which a solution depends: mesh, sets, materials, moves and points.
fn fingerprint(assembly: &Assembly) -> String {
    let scene = assembly.scene;
    let mut hash = Fnv::default();
    let mut add = |v: [f64; 3]| hash.vector(Vector3::from(v).cast::<f32>());
    assembly.quadratic.nodes_m.iter().for_each(|x| add((*x).into()));
    let indices = [&assembly.fixed, &assembly.held].map(|set| set.iter().map(|n| f64::from(*n)).collect::<Vec<_>>());
    let joined: Vec<f64> = assembly.joined.iter().map(|t| *t as f64).collect();
    indices.iter().chain([&joined]).flatten().for_each(|n| add([*n, 0.0, 0.0]));
    scene.organ.iter().for_each(|o| add([o.youngs_modulus_pa, o.density_kg_per_m3, 0.0]));
    add([scene.poisson_ratio, scene.joint.stiffness_pa_per_m, scene.joint.reach_m]);
    add(scene.gravity_m_per_s2);
    scene.attachment.moves_m.iter().for_each(|m| add(*m));
    assembly.landmarks.iter().for_each(|(_, x)| add((*x).into()));
    assembly.surface.iter().for_each(|x| add((*x).into()));
    format!("{:016x}", hash.finish())
}

/// Solves the scene on an assembly; `progress` is called with (move, completed share).
pub fn solve(assembly: &Assembly, mut progress: impl FnMut(usize, f64)) -> Result<Truth, Error> {
    let scene = assembly.scene;
    let modulus_pa = scene.organ[0].youngs_modulus_pa;
    let failed = |cause: &dyn std::fmt::Display| TissueError::Check(format!("{}: finite elements: {cause}", scene.file));
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
    let stiffness =
        |tet: usize, _: &Vector3<f64>| Stiffness { ratio: ratios[tet], poisson_ratio: scene.poisson_ratio, stiffening_b: 0.0 };
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
