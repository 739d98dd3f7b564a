//! The scene as a model of the core: springs of both organs, their joints, masses with both
//! densities, and anchors that the stick moves.

use std::collections::BTreeSet;

use palpate::{GuardLimits, Params, Terms, Vector3};

use super::assembly::Assembly;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::{Joint, Tissue};

/// One patch that contains all organs.
#[derive(Clone, Debug)]
pub struct Network {
    /// Springs, tets and masses.
    pub patch: Patch,
    /// Parameters of the scene; a method changes those of its own terms.
    pub params: Params,
    /// Nodes of the patch that move with the stick, and their rest positions [m].
    pub held: Vec<(usize, Vector3<f64>)>,
}

/// Way in which organs are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joints {
    /// Each node is joined to the nearest node of the other organ, as in paper 000.
    Nearest,
    /// Each node is joined to the three nodes of the nearest triangle, with the stiffness shared by
    /// area coordinates: the joint does not slide and does not depend on the positions of the
    /// nodes.
    Triangle,
}

impl Network {
    /// Builds the patch. The Poisson's ratio of `material` is that of the springs; with 0.25 they
    /// are (11) as printed.
    pub fn build(assembly: &Assembly, material: &Material, joints: Joints) -> Self {
        let scene = assembly.scene;
        let first = &scene.organ[0];
        let mut mesh = TetMesh { nodes_m: Vec::new(), tets: Vec::new(), regions: Vec::new() };
        let (mut stiffness_ratio, mut mass_ratio) = (Vec::new(), Vec::new());
        for (part, of) in assembly.meshes.iter().zip(&scene.organ) {
            let start = mesh.nodes_m.len() as u32;
            mesh.nodes_m.extend_from_slice(&part.nodes_m);
            mesh.tets.extend(part.tets.iter().map(|t| t.map(|n| n + start)));
            mesh.regions.extend_from_slice(&part.regions);
            stiffness_ratio.extend(part.tets.iter().map(|_| of.youngs_modulus_pa / first.youngs_modulus_pa));
            mass_ratio.extend(part.nodes_m.iter().map(|_| of.density_kg_per_m3 / first.density_kg_per_m3));
        }
        let corner_of = corners(assembly);
        let corner = |n: &u32| corner_of[*n as usize];
        let held: BTreeSet<u32> = assembly.held.iter().filter_map(corner).collect();
        let fixed = assembly.fixed.iter().filter_map(corner);
        let anchors: BTreeSet<u32> = fixed.chain(held.iter().copied()).collect();
        let springs = springs(assembly, &corner_of, joints, first.youngs_modulus_pa);
        let held = held.iter().map(|n| (*n as usize, Vector3::from(mesh.nodes_m[*n as usize]))).collect();
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors.into_iter().collect(), [0.0; 3], 1e-3);
        let mut patch = Patch::build_joined(&tissue, material, None, &springs);
        patch.scale_masses(&mass_ratio);
        let params = Params {
            youngs_modulus_pa: first.youngs_modulus_pa as f32,
            poisson_ratio: material.poisson_ratio as f32,
            density_kg_per_m3: first.density_kg_per_m3 as f32,
            gravity_m_per_s2: scene.gravity_m_per_s2.map(|g| g as f32),
            limits: GuardLimits::HIGHEST,
            // the organs are joined by very short springs, whose relative mass floor would prevent
            // them from coming to rest
            terms: Terms { rim: false, relative_mass: false, ..Terms::ALL },
            ..Params::default()
        };
        Self { patch, params, held }
    }
}

/// Index in the patch of each node of the quadratic mesh; `None` for mid-edge nodes.
fn corners(assembly: &Assembly) -> Vec<Option<u32>> {
    let mut corner_of = vec![None; assembly.quadratic.nodes_m.len()];
    let mut next = 0;
    for (organ, mesh) in assembly.organs.iter().zip(&assembly.meshes) {
        for n in 0..mesh.nodes_m.len() {
            corner_of[organ.nodes.start + n] = Some(next);
            next += 1;
        }
    }
    corner_of
}

fn springs(assembly: &Assembly, corner_of: &[Option<u32>], joints: Joints, modulus_pa: f64) -> Vec<Joint> {
    let per_m = assembly.scene.joint.stiffness_pa_per_m / modulus_pa;
    let mut springs = Vec::new();
    for (node, area_m2, near) in assembly.joints() {
        let triangle = &assembly.quadratic.triangles[near.triangle];
        let distance_m =
            |k: usize| (assembly.quadratic.nodes_m[triangle[k] as usize] - assembly.quadratic.nodes_m[node as usize]).norm();
        let ends: Vec<(usize, f64)> = match joints {
            Joints::Triangle => (0..3).map(|k| (k, near.at[k])).filter(|(_, share)| *share > 0.0).collect(),
            Joints::Nearest => {
                let nearest = (0..3).min_by(|a, b| distance_m(*a).total_cmp(&distance_m(*b)));
                nearest.into_iter().map(|k| (k, 1.0)).collect()
            }
        };
        for (k, share) in ends.into_iter().filter(|(k, _)| distance_m(*k) > 0.0) {
            if let (Some(a), Some(b)) = (corner_of[node as usize], corner_of[triangle[k] as usize]) {
                springs.push(Joint { nodes: [a.min(b), a.max(b)], k_m: per_m * area_m2 * share });
            }
        }
    }
    springs
}
