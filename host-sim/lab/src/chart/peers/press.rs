//! The press of the chart as a file: everything that another engine needs to repeat the press, and
//! the reference forces with which its results are compared.

use palpate::{Fnv, Params};
use palpate_tissue::Error as TissueError;
use palpate_tissue::moving::Ramp;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;

use super::grid::{GRIDS, grid, grid_name};
use crate::chart::reference::Reference;
use crate::chart::{accuracy, moving, survive, timing};
use crate::error::Error;
use crate::methods::{BLOCK_M, Block, DEEPEST_M, RADIUS_M};

/// Young's moduli at which the other engines are run [Pa].
pub const MODULI_PA: [f64; 2] = [3500.0, 20_000.0];
/// Node counts of the calibrated patches whose meshes the other engines may use.
const PATCHES: [usize; 3] = [130, 410, 1020];

/// Speed from which the other engines are judged in the 20 ms after the stop as well [mm/s]; in
/// slower ramps ours alone are, which puts ours at a disadvantage.
const TAP_MM_PER_S: u32 = 500;
/// Ticks after the stop that a ramp is judged in.
const AFTER_STOP_TICKS: usize = 20;

/// Everything about the press except the meshes; lengths in metres, times in seconds.
#[derive(Clone, Debug, Serialize)]
pub struct StandardPress {
    version: u32,
    scene: &'static str,
    block_m: [f64; 3],
    poisson_ratio: f32,
    density_kg_per_m3: f32,
    youngs_moduli_pa: [f64; 2],
    probe_radius_m: f64,
    tick_s: f32,
    survival: Survival,
    held: Held,
    moving: Vec<Moving>,
    timing: Timing,
}

/// The press that an engine must survive; it is then run with the smallest number of substeps that
/// survives.
#[derive(Clone, Debug, Serialize)]
struct Survival {
    speed_m_per_s: f64,
    clear_m: f64,
    deepest_m: f64,
    wait_ticks: usize,
    still_ticks: usize,
    still_m: f64,
    still_force_share: f64,
    returned_m: f64,
    most_substeps: u16,
}

/// The presses from one hold to the next; in each hold the force is averaged until it has settled.
#[derive(Clone, Debug, Serialize)]
struct Held {
    speed_m_per_s: f64,
    averaged_ticks: usize,
    settled_share: f64,
    in_a_row: usize,
    most_means: usize,
    depths_m: Vec<f64>,
    force_over_e_m2: Vec<f64>,
}

/// A ramp: the depth at the end of each tick, and the reference force of each tick after first
/// contact.
#[derive(Clone, Debug, Serialize)]
struct Moving {
    youngs_modulus_pa: f64,
    speed_mm_per_s: u32,
    depths_m: Vec<f64>,
    judged_force_over_e_m2: Vec<f64>,
}

/// The ticks whose processor time is measured.
#[derive(Clone, Debug, Serialize)]
struct Timing {
    depth_m: f64,
    approach_m: f64,
    settle_ticks: usize,
    step_m: f64,
    batch_ticks: usize,
    least_batches: usize,
    long_enough_s: f64,
}

/// A mesh that the other engines may use, with its bottom nodes fixed.
#[derive(Clone, Debug, Serialize)]
pub struct PeerMesh {
    name: String,
    nodes_m: Vec<[f64; 3]>,
    tets: Vec<[u32; 4]>,
    fixed: Vec<u32>,
}

impl StandardPress {
    /// The standard press with its shipped references.
    pub fn new() -> Result<Self, Error> {
        let (params, reference) = (Params::default(), Reference::block());
        let force = |d: &f64| reference.force_over_e_m2(*d);
        let force_over_e_m2 = accuracy::DEPTHS_M.iter().filter_map(force).collect();
        let mut ramps = Vec::new();
        for youngs_modulus_pa in MODULI_PA {
            for speed_mm_per_s in moving::SPEEDS_MM_PER_S {
                let name = format!("centre-{}kpa-{speed_mm_per_s}", youngs_modulus_pa * 1e-3);
                let ramp = Ramp::named(&name).map_err(TissueError::from)?;
                let mut judged_force_over_e_m2 = ramp.judged_force_over_e_m2();
                if speed_mm_per_s < TAP_MM_PER_S {
                    judged_force_over_e_m2.truncate(judged_force_over_e_m2.len().saturating_sub(AFTER_STOP_TICKS));
                }
                ramps.push(Moving { youngs_modulus_pa, speed_mm_per_s, depths_m: ramp.depths_m(), judged_force_over_e_m2 });
            }
        }
        Ok(Self {
            version: 1,
            scene: "block, pressed at its centre without friction; bottom fixed, other sides free",
            block_m: BLOCK_M,
            poisson_ratio: params.poisson_ratio,
            density_kg_per_m3: params.density_kg_per_m3,
            youngs_moduli_pa: MODULI_PA,
            probe_radius_m: RADIUS_M,
            tick_s: params.tick_s,
            survival: Survival {
                speed_m_per_s: survive::SPEED_M_PER_S,
                clear_m: survive::CLEAR_M,
                deepest_m: DEEPEST_M,
                wait_ticks: survive::WAIT_TICKS,
                still_ticks: survive::STILL_TICKS,
                still_m: survive::STILL_M,
                still_force_share: survive::STILL_FORCE,
                returned_m: survive::RETURNED_M,
                most_substeps: survive::MOST_SUBSTEPS,
            },
            held: Held {
                speed_m_per_s: accuracy::SPEED_M_PER_S,
                averaged_ticks: accuracy::AVERAGED_TICKS,
                settled_share: accuracy::SETTLED,
                in_a_row: accuracy::IN_A_ROW,
                most_means: accuracy::MOST_MEANS,
                depths_m: accuracy::DEPTHS_M.into(),
                force_over_e_m2,
            },
            moving: ramps,
            timing: Timing {
                depth_m: timing::DEPTH_M,
                approach_m: timing::APPROACH_M,
                settle_ticks: timing::SETTLE_TICKS,
                step_m: timing::STEP_M,
                batch_ticks: timing::BATCH_TICKS,
                least_batches: timing::LEAST_BATCHES,
                long_enough_s: timing::LONG_ENOUGH_S,
            },
        })
    }

    /// Checksum of the whole press without the meshes; a table of results quotes it.
    pub fn hash(&self) -> Result<String, Error> {
        let text = serde_json::to_string(self).map_err(|e| TissueError::Usage(format!("press.json: {e}")))?;
        let mut hash = Fnv::default();
        hash.bytes(text.as_bytes());
        Ok(format!("{:016x}", hash.finish()))
    }

    /// Writes `press.json`: the press, its hash and the meshes.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), Error> {
        #[derive(Serialize)]
        struct File<'a> {
            hash: String,
            program: String,
            processor: String,
            #[serde(flatten)]
            press: &'a StandardPress,
            meshes: Vec<PeerMesh>,
        }
        let file = File {
            hash: self.hash()?,
            program: palpate_tissue::machine::build(),
            processor: palpate_tissue::machine::processor(),
            press: self,
            meshes: meshes(),
        };
        Ok(folder.write_json("press.json", &file)?)
    }
}

/// Meshes of our calibrated patches, and uniform grids.
pub fn meshes() -> Vec<PeerMesh> {
    let of = |name: String, block: Block| {
        let Block { tissue, .. } = block;
        PeerMesh { name, nodes_m: tissue.mesh.nodes_m, tets: tissue.mesh.tets, fixed: tissue.anchors }
    };
    let patches = PATCHES.iter().filter_map(|&nodes| Some(of(format!("patch-{nodes}"), Block::calibrated(nodes, MODULI_PA[0])?)));
    let grids = GRIDS.iter().map(|&cells| of(grid_name(cells), on_grid(cells, MODULI_PA[0])));
    patches.chain(grids).collect()
}

/// The standard block meshed as a grid of `cells`.
pub fn on_grid(cells: [usize; 3], youngs_modulus_pa: f64) -> Block {
    Block::of_mesh(grid(cells), youngs_modulus_pa, |x| x[2] <= -BLOCK_M[2] * (1.0 - 1e-9))
}
