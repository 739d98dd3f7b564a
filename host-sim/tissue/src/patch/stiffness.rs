//! Springs, volume stiffness and node data of a mesh, divided by Young's modulus.

use palpate::{NodeRest, Tet, Vector3};

use super::{Material, Multipliers};
use crate::mesh::{TetMesh, six_volume, surface};
use crate::tissue::{Joint, Tissue};

/// A spring before rounding: nodes, stiffness over E [m], rest length [m].
pub(super) struct RestSpring {
    pub nodes: [u32; 2],
    pub k: f64,
    pub length_m: f64,
}

/// Elastic constants of a mesh, divided by Young's modulus.
pub(super) struct Elastic {
    pub springs: Vec<RestSpring>,
    pub tets: Vec<Tet>,
    /// Volume of the tets around each node [m^3].
    around_m3: Vec<f64>,
    /// Volume stiffness kappa of each node over E (1).
    kappa: Vec<f64>,
    /// Mean diagonal stiffness over E of each node [m].
    diagonal_m: Vec<f64>,
    per_tet_share: f64,
    /// `per_tet_share`, times its multiplier (1).
    bulk_share: f64,
}

/// Edges of a tet, each as a pair of its corners.
const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

impl Elastic {
    pub fn of(tissue: &Tissue, material: &Material, multipliers: Option<&Multipliers>, joints: &[Joint]) -> Self {
        let mesh = &tissue.mesh;
        let nu = material.poisson_ratio;
        let mu = 0.5 / (1.0 + nu);
        let lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let kappa = lambda - mu;

        let volumes: Vec<f64> = mesh.tets.iter().map(|t| six_volume(mesh, *t) / 6.0).collect();
        let mut around = vec![0.0; mesh.nodes_m.len()];
        let mut stiff_volume = vec![0.0; mesh.nodes_m.len()];
        for ((tet, v), ratio) in mesh.tets.iter().zip(&volumes).zip(&tissue.stiffness_ratio) {
            for &n in tet {
                around[n as usize] += v;
                stiff_volume[n as usize] += v * ratio;
            }
        }
        let node_multiplier = |n: usize| multipliers.map_or(1.0, |m| m.node[n]);
        let node_kappa: Vec<f64> = (0..around.len()).map(|n| kappa * stiff_volume[n] / around[n] * node_multiplier(n)).collect();

        let mut springs = springs(tissue, &volumes, nu, multipliers);
        springs.extend(joints.iter().map(|joint| RestSpring::between(mesh, joint.nodes, joint.k_m)));
        let share = material.per_tet_share;
        let bulk = share * multipliers.map_or(1.0, |m| m.bulk);
        let mut tets = Vec::with_capacity(mesh.tets.len());
        for ((tet, v), ratio) in mesh.tets.iter().zip(&volumes).zip(&tissue.stiffness_ratio) {
            let tet_kappa = kappa * ratio;
            tets.push(Tet {
                node: tet.map(|n| n as u16),
                six_volume_reciprocal: (1.0 / (6.0 * v)) as f32,
                bulk: (bulk * tet_kappa / 6.0) as f32,
                barrier: (3.0 * mu * ratio / 6.0) as f32,
            });
        }
        let mut elastic = Self {
            springs,
            tets,
            around_m3: around,
            kappa: node_kappa,
            diagonal_m: Vec::new(),
            per_tet_share: share,
            bulk_share: bulk,
        };
        elastic.diagonal_m = elastic.diagonal(tissue, &volumes, kappa);
        elastic
    }

    /// Mean diagonal stiffness of each node over E [m]: a third of the trace of its diagonal block
    /// of the rest stiffness.
    fn diagonal(&self, tissue: &Tissue, volumes: &[f64], kappa: f64) -> Vec<f64> {
        let mesh = &tissue.mesh;
        let mut trace = vec![0.0; mesh.nodes_m.len()];
        for s in &self.springs {
            s.nodes.iter().for_each(|&n| trace[n as usize] += s.k);
        }
        // nodal volume: the energy is kappa V/2 (J - 1)^2, with V a quarter of the volume around
        // the node; d J_n / d x_i is a sum over the tets that contain both n and i
        let mut slopes: std::collections::BTreeMap<(u32, u32), [f64; 3]> = std::collections::BTreeMap::new();
        for ((tet, &v), ratio) in mesh.tets.iter().zip(volumes).zip(&tissue.stiffness_ratio) {
            let gradients = volume_gradients(mesh, tet);
            for (&i, g) in tet.iter().zip(&gradients) {
                let square: f64 = g.iter().map(|c| c * c).sum();
                trace[i as usize] += self.bulk_share * kappa * ratio * square / v;
                for &n in tet {
                    let sum = slopes.entry((n, i)).or_default();
                    sum.iter_mut().zip(g).for_each(|(s, c)| *s += c);
                }
            }
        }
        for ((n, i), g) in slopes {
            let around = self.around_m3[n as usize];
            let square: f64 = g.iter().map(|c| c * c).sum();
            trace[i as usize] += (1.0 - self.per_tet_share) * self.kappa[n as usize] * 0.25 * square / around;
        }
        trace.into_iter().map(|t| t / 3.0).collect()
    }

    /// Node data for the model.
    pub fn nodes(&self, mesh: &TetMesh) -> Vec<NodeRest> {
        let per_node = self.around_m3.iter().zip(&self.kappa).zip(&self.diagonal_m);
        mesh.nodes_m
            .iter()
            .zip(per_node)
            .map(|(x, ((around, kappa), diagonal))| NodeRest {
                rest_m: x.map(|c| c as f32),
                volume_m3: (around / 4.0) as f32,
                stiffness_m: *diagonal as f32,
                six_volume_reciprocal: (1.0 / (6.0 * around)) as f32,
                pressure: (2.0 * kappa * (1.0 - self.per_tet_share) / 24.0) as f32,
            })
            .collect()
    }
}

/// Paper 000, eq 11: `k = sum over the edge's tets of 2 sqrt(2)/25 l_e E`, `l_e = (12 V /
/// sqrt(2))^(1/3)`, times `1/(0.8 (1 + nu))`: as printed, the network has the shear modulus of a
/// solid with nu = 1/4.
fn springs(tissue: &Tissue, volumes: &[f64], nu: f64, multipliers: Option<&Multipliers>) -> Vec<RestSpring> {
    let mesh = &tissue.mesh;
    let edges = surface::edges(&mesh.tets);
    let mut k = vec![0.0; edges.len()];
    for ((tet, v), ratio) in mesh.tets.iter().zip(volumes).zip(&tissue.stiffness_ratio) {
        let length = (12.0 * v / 2.0_f64.sqrt()).cbrt();
        for [a, b] in TET_EDGES {
            let edge = [tet[a].min(tet[b]), tet[a].max(tet[b])];
            if let Ok(at) = edges.binary_search(&edge) {
                k[at] += 2.0 * 2.0_f64.sqrt() / 25.0 * length * ratio / (0.8 * (1.0 + nu));
            }
        }
    }
    if let Some(m) = multipliers {
        k.iter_mut().zip(&m.edge).for_each(|(k, m)| *k *= m);
    }
    edges.iter().zip(k).map(|(&nodes, k)| RestSpring::between(mesh, nodes, k)).collect()
}

impl RestSpring {
    fn between(mesh: &TetMesh, nodes: [u32; 2], k: f64) -> Self {
        let [a, b] = nodes.map(|n| mesh.nodes_m[n as usize]);
        Self { nodes, k, length_m: a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt() }
    }
}

/// Gradients of the volume with respect to the four corners [m^2].
fn volume_gradients(mesh: &TetMesh, tet: &[u32; 4]) -> [Vector3<f64>; 4] {
    let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
    let [e1, e2, e3] = [b, c, d].map(|x| x - a);
    let [b, c, d] = [e2.cross(&e3), e3.cross(&e1), e1.cross(&e2)].map(|g| g / 6.0);
    [-(b + c + d), b, c, d]
}
