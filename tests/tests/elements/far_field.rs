//! The far field: rim springs respond like the exact outside, the exact outside is exact, ticks
//! settle to its equilibrium, and it can be replaced.

mod condensed;
mod meshes;
mod swap;
mod tick;

use palpate::Params;
use palpate_fit::far_field::{FarField, Sizes};
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::Tissue;

/// Radius of the default probe [m].
const RADIUS_M: f64 = 0.008;
const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];

/// The default block, with a mesh that is fine at the centre of its top.
fn graded(nodes: usize) -> TetMesh {
    block(&BlockSpec { size_m: BLOCK_M, nodes, fine_at_m: [0.0; 2], fine_radius_m: RADIUS_M }).unwrap()
}

fn tissue(mesh: TetMesh, site_m: [f64; 3], fixed: impl Fn(&[f64; 3]) -> bool) -> Tissue {
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| fixed(x)).map(|(n, _)| n).collect();
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    Tissue::closed(mesh, stiffness_ratio, anchors, site_m, 0.01)
}

fn on_bottom(x: &[f64; 3]) -> bool {
    x[2] < -BLOCK_M[2] * (1.0 - 1e-9)
}

/// Sizes of a patch of this radius that is cut along the existing mesh.
fn radius(radius_m: f64) -> Sizes {
    Sizes { radius_m, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0 }
}

fn far_field(whole: &Tissue, sizes: &Sizes) -> FarField {
    FarField::of(whole, sizes, &Material::default(), &Params::default()).unwrap()
}

/// Statics of the patch with a free rim.
fn free(far: &FarField) -> Statics {
    Statics::of(&Patch::build(&far.cut.patch, &Material::default(), None).model(), &Params::default()).unwrap()
}

fn rim(far: &FarField) -> Vec<usize> {
    far.cut.rim.iter().map(|n| *n as usize).collect()
}

/// Forces over E of presses to increasing depths at one place [m^2].
fn forces(statics: &Statics, place_m: Vector, depths_m: &[f64]) -> Vec<f64> {
    let solver = Solver::of(statics).unwrap();
    let mut here = solver.rest(statics, place_m, 1e-4).unwrap();
    let mut press = |depth_m: f64| {
        here = solver.press(statics, &here, place_m - statics.axis() * depth_m, depth_m).unwrap();
        here.force
    };
    depths_m.iter().map(|d| press(*d)).collect()
}
