//! The finite-element reference, in place of the paper's computed tomography.

use nalgebra::Vector3;
use palpate::Fnv;
use serde::Deserialize;

use super::assembly::Assembly;
use super::measured::Measured;
use crate::error::Error;
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

/// Shipped solutions: of both resolutions, of the sparse one with every tet cut into eight, and of
/// the sparse one under its weight.
#[derive(Clone, Debug, Deserialize)]
pub struct Shipped {
    /// Solution at full resolution.
    pub full: Answer,
    /// Solution at sparse resolution.
    pub sparse: Answer,
    /// Solution on the subdivided sparse mesh, at the landmarks and surface points of the sparse
    /// one.
    pub sparse_subdivided: Answer,
    /// Solution at sparse resolution under full gravity, from a stress-free shape.
    pub weighed: Answer,
}

/// A solution, reduced to landmarks and surface points.
#[derive(Clone, Debug, Deserialize)]
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
#[derive(Clone, Debug, Deserialize)]
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

    /// The solution that belongs to an assembly.
    pub fn of(assembly: &Assembly) -> Result<Truth, Error> {
        let shipped = Self::load().map(|shipped| [shipped.full, shipped.sparse, shipped.weighed]);
        let found = shipped.into_iter().flatten().find_map(|answer| answer.for_assembly(assembly));
        found.ok_or_else(|| {
            let why = "has no finite elements in host-sim/references/hanging-liver.json: take the scene as it ships";
            TissueError::Usage(format!("{}: {why}", assembly.scene.file)).into()
        })
    }
}

impl Answer {
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
