//! Patch files for the board: the shipped ones, and patches with a far field built during the test.

use std::path::{Path, PathBuf};

use palpate::{Model, PatchFile};
use palpate_fit::far_field::condense::condense;
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::far_field::springs::rim_answers;
use palpate_fit::far_field::{FarField, springs};
use palpate_fit::statics::Statics;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

use crate::palpate_command::repository;

/// Patch radius of [`cut_block`] [m].
const RADIUS_M: f64 = 0.017;
/// Size of the elements at the site of that patch [m]; it gives some fifty nodes.
const ELEMENT_M: f64 = 0.0058;
/// Radius around the site within which surface nodes are loaded when a rim is refitted [m].
const LOADED_M: f64 = 0.012;

/// Absolute path of a patch in `firmware/patches`, by its file name.
///
/// # Panics
/// Panics if no shipped patch has this name.
pub fn shipped(name: &str) -> PathBuf {
    repository().join("firmware/patches").join(name).canonicalize().expect("a patch that ships")
}

/// Bytes of a patch file, aligned to a word boundary. The memory is never freed.
///
/// # Panics
/// Panics if the file cannot be read.
pub fn on_words(file: &Path) -> &'static [u8] {
    let bytes = std::fs::read(file).expect("a patch file");
    let words: &'static mut [u32] = Vec::leak(vec![0; bytes.len().div_ceil(4)]);
    let on_words = &mut bytemuck::cast_slice_mut(words)[..bytes.len()];
    on_words.copy_from_slice(&bytes);
    on_words
}

/// A patch cut out of the default block, before any fit.
///
/// # Panics
/// Never panics: these sizes fit the default block.
pub fn cut_block() -> Prepared {
    let scene = Scene::load("block").expect("the default scene");
    Prepared::of(&scene, &Recipe::new(RADIUS_M, ELEMENT_M, scene.probe.radius_m)).expect("a block that allows the cut")
}

/// Returns the patch with a refined outside: every tet of the outside is split into four at its
/// centroid, which is repeated `times` times. The rim does not change.
///
/// # Panics
/// Panics if the refined outside cannot be condensed.
pub fn with_finer_outside(prepared: &Prepared, times: usize) -> Prepared {
    let mut cut = prepared.far.cut.clone();
    for _ in 0..times {
        let old = &cut.outside.mesh;
        let mut mesh = TetMesh { nodes_m: old.nodes_m.clone(), tets: Vec::new(), regions: Vec::new() };
        let mut stiffness_ratio = Vec::new();
        for ((tet, region), ratio) in old.tets.iter().zip(&old.regions).zip(&cut.outside.stiffness_ratio) {
            let at = |k: usize| -> f64 { tet.iter().map(|n| old.nodes_m[*n as usize][k]).sum::<f64>() / 4.0 };
            let middle = mesh.nodes_m.len() as u32;
            mesh.nodes_m.push([at(0), at(1), at(2)]);
            for corner in 0..4 {
                let mut part = *tet;
                part[corner] = middle;
                mesh.tets.push(part);
                mesh.regions.push(*region);
                stiffness_ratio.push(*ratio);
            }
        }
        cut.outside.mesh = mesh;
        cut.outside.stiffness_ratio = stiffness_ratio;
    }
    let exact_m = condense(&cut.outside, prepared.material.poisson_ratio).expect("an outside that is held");
    let free = Patch::build(&cut.patch, &prepared.material, None);
    let statics = Statics::of(&free.model(), &prepared.params).expect("a patch that could be built before");
    let answers_per_m = rim_answers(&statics, &cut, &exact_m, LOADED_M).expect("a patch that its outside holds");
    let springs = springs::fit(&cut, &exact_m, &answers_per_m);
    Prepared { far: FarField { cut, exact_m, answers_per_m, springs }, ..prepared.clone() }
}

/// Packs an unfitted patch with the limits and substeps of a session and writes it to `folder`.
///
/// # Panics
/// Panics if no session accepts the patch or the folder cannot be written.
pub fn pack(prepared: &Prepared, folder: &Path, name: &str) -> PathBuf {
    let session = Session::of_fitted(&MACHINES[1], prepared.patch(), prepared.params).expect("a patch that keeps 1 kHz");
    let bytes = session.patch.pack(&session.params, session.stable.pressed_s as f32);
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("a scratch folder");
    path
}

/// Writes a copy of a packed patch without its rim edges, to measure the cost of the rim nodes.
///
/// # Panics
/// Panics if the file is not a patch or cannot be written.
pub fn without_rim_edges(file: &Path, name: &str) -> PathBuf {
    let packed = PatchFile::open(on_words(file)).expect("a patch");
    let model = Model { rim_edges: &[], ..packed.model };
    let mut bytes = Vec::new();
    PatchFile { model, ..packed }.write(|part| bytes.extend_from_slice(part));
    let path = file.with_file_name(name);
    std::fs::write(&path, bytes).expect("a scratch folder");
    path
}
