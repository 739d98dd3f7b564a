//! Patches to test with, and deformed states that no press would reach.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use palpate::{Model, Params, Vector3};
use palpate_fit::far_field::{FarField, Sizes};
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::patch::{Material, Memory, Patch};
use palpate_tissue::stable_step::limits;
use palpate_tissue::tissue::Tissue;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Sides of the default block [m].
const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];
/// Radius of the default probe [m].
const RADIUS_M: f64 = 8e-3;
/// The default scene's deepest hold, plus a quarter [m].
const DEPTH_LIMIT_M: f64 = 5e-3;

/// A patch with its parameters.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The patch.
    pub patch: Patch,
    /// Parameters of the patch.
    pub params: Params,
}

impl Bench {
    /// The default block: 80 x 80 x 40 mm of 3.5 kPa with a fixed bottom, under a hemisphere of 8
    /// mm radius above the centre of its top (the origin).
    ///
    /// # Panics
    /// Panics if the block generator refuses the node count.
    pub fn block(nodes: usize) -> Self {
        Self::build(nodes, 1.0, true, 4)
    }

    /// The default block with 4, 9 or 16 foundation points per triangle.
    pub fn with_points(nodes: usize, points_per_triangle: usize) -> Self {
        Self::build(nodes, 1.0, true, points_per_triangle)
    }

    /// A shipped calibrated patch of this node count.
    ///
    /// # Panics
    /// Panics if no shipped patch has this node count.
    pub fn calibrated(nodes: usize) -> Self {
        let (patch, packed) = palpate_tissue::session::calibrated::sized(nodes).expect("a size that ships");
        let params = Params { limits: limits(&patch, f64::from(packed.tick_s)), substeps: 1, ..packed };
        Self { patch, params }
    }

    /// The default block with every length multiplied by `scale`, including the probe's radius.
    pub fn scaled(nodes: usize, scale: f64) -> Self {
        Self::build(nodes, scale, true, 4)
    }

    /// The default block without fixed nodes.
    pub fn floating(nodes: usize) -> Self {
        Self::build(nodes, 1.0, false, 4)
    }

    /// A patch of this radius [m] cut out of the default block of `nodes` nodes. Only its rim
    /// springs support it.
    ///
    /// # Panics
    /// Panics if the block generator refuses the node count or the patch covers the whole block.
    pub fn far_field(nodes: usize, radius_m: f64) -> Self {
        let whole = Self::tissue(nodes, 1.0, true);
        let sizes = Sizes { radius_m, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0 };
        let mut params = Params::default();
        let material = Material::default();
        let patch = FarField::of(&whole, &sizes, &material, &params).expect("a patch with an outside").patch(&material);
        params.limits = limits(&patch, f64::from(params.tick_s));
        Self { patch, params }
    }

    /// A block is meshed once in each test program, since the mesh takes longer than most tests.
    fn build(nodes: usize, scale: f64, fixed: bool, points_per_triangle: usize) -> Self {
        static BUILT: Mutex<BTreeMap<(usize, u64, bool, usize), Bench>> = Mutex::new(BTreeMap::new());
        let mut built = BUILT.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (nodes, scale.to_bits(), fixed, points_per_triangle);
        built.entry(key).or_insert_with(|| Self::meshed(nodes, scale, fixed, points_per_triangle)).clone()
    }

    fn meshed(nodes: usize, scale: f64, fixed: bool, points_per_triangle: usize) -> Self {
        let tissue = Self::tissue(nodes, scale, fixed);
        let mut params = Params::default();
        params.probe.radius_m = (RADIUS_M * scale) as f32;
        let patch = Patch::build(&tissue, &Material { points_per_triangle, ..Material::default() }, None);
        params.limits = limits(&patch, f64::from(params.tick_s));
        Self { patch, params }
    }

    fn tissue(nodes: usize, scale: f64, fixed: bool) -> Tissue {
        let size_m = BLOCK_M.map(|side| side * scale);
        let spec = BlockSpec { size_m, nodes, fine_at_m: [0.0; 2], fine_radius_m: RADIUS_M * scale };
        let mesh = block(&spec).expect("a block that can be meshed");
        let on_bottom = |x: &[f64; 3]| x[2] < -size_m[2] * (1.0 - 1e-9);
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| fixed && on_bottom(x)).map(|(n, _)| n).collect();
        let stiffness_ratio = vec![1.0; mesh.tets.len()];
        Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], DEPTH_LIMIT_M * scale)
    }

    /// Returns the patch with its parameters changed by `change`.
    pub fn with(mut self, change: impl FnOnce(&mut Params)) -> Self {
        change(&mut self.params);
        self
    }

    /// Memory in which the patch runs.
    pub fn memory(&self) -> Memory {
        Memory::for_model(&self.patch.wide_model())
    }
}

/// Position of a tip at this depth below the centre of the block's top [m].
pub fn at_depth(depth_m: f32) -> Vector3<f32> {
    Vector3::new(0.0, 0.0, -depth_m)
}

/// Pseudo-random numbers that are the same on every machine.
#[derive(Clone, Debug)]
pub struct Noise(SplitMix64);

impl Noise {
    /// Starts a sequence from a seed.
    pub fn new(seed: u64) -> Self {
        Self(SplitMix64::seed_from_u64(seed))
    }

    /// Uniform random number in -1 .. 1.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A vector of three random numbers.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.uniform())
    }
}

/// A uniform strain of the whole patch plus a random displacement of every node.
#[derive(Clone, Copy, Debug)]
pub struct Deformation {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Largest entry of the displacement gradient (1).
    pub strain: f64,
    /// Largest random displacement per coordinate, as a share of the node's shortest edge (1).
    pub jitter: f64,
}

impl Deformation {
    /// Deformed node positions [m]; anchors are moved as well.
    pub fn of(&self, model: &Model) -> Vec<Vector3<f32>> {
        let mut noise = Noise::new(self.seed);
        let gradient = [noise.vector(), noise.vector(), noise.vector()];
        let shortest = shortest_edges_m(model);
        let moved = model.nodes.iter().zip(shortest).map(|(node, edge_m)| {
            let x = Vector3::from(node.rest_m).cast::<f64>();
            let strained = Vector3::from_fn(|k, _| x[k] + self.strain * gradient[k].dot(&x));
            (strained + noise.vector() * (self.jitter * edge_m)).cast()
        });
        moved.collect()
    }
}

/// Length of the shortest spring at every node [m].
fn shortest_edges_m(model: &Model) -> Vec<f64> {
    let mut shortest = vec![f64::INFINITY; model.nodes.len()];
    for s in model.springs {
        let length_m = f64::from(s.k_rest) / f64::from(s.k);
        for n in [s.i, s.j].map(usize::from) {
            shortest[n] = shortest[n].min(length_m);
        }
    }
    shortest
}
