//! Total-Lagrangian explicit dynamics with neo-Hookean linear tets (TLED: Miller et al. 2007;
//! average nodal pressure: Bonet and Burton 1998, in total-Lagrangian form Joldes et al. 2009).
//!
//! The energy density is that of the reference, `mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2`.
//! Evaluated per tet, the volume term locks. Averaged over nodes it is `lambda/2 (ln J_n)^2`, where
//! `J_n` is the volume of a node's tets divided by their rest volume, weighted with a quarter of
//! that rest volume.

use palpate::Vector3;

use super::Block;
use super::on_core::Law;
use super::rest_tet::{RestTet, cofactors, diagonal_m};

/// Domain over which the volume ratio of the volume term is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Volume {
    /// Each tet by itself: plain linear elements.
    PerTet,
    /// All tets around a node.
    Nodal,
}

/// Tets at rest, and the nodal averages of a tick.
#[derive(Clone, Debug)]
pub struct NeoHookean {
    tets: Vec<RestTet>,
    diagonal_m: Vec<f32>,
    lambda: f32,
    mu: f32,
    volume: Volume,
    /// Reciprocal of the rest volume of each node's tets [1/m^3].
    around_reciprocal: Vec<f32>,
    /// lambda over E of each node (1): the volume-weighted mean over its tets.
    node_lambda: Vec<f32>,
    /// For each node first the volume of its tets [m^3], then the pressure over E (1).
    node: Vec<f32>,
}

impl NeoHookean {
    /// Floating-point operations per tet, counted in this file; a logarithm counts as 20.
    pub const FLOPS_PER_TET: f64 = 215.0;
    /// Floating-point operations that averaging adds per tet, including its share of the logarithms
    /// of the nodes.
    pub const FLOPS_NODAL: f64 = 70.0;

    /// Creates the method at rest.
    pub fn new(block: &Block, volume: Volume) -> Self {
        let tets = RestTet::of(block);
        let (lambda, mu) = block.lame_over_modulus();
        let mut around = vec![0.0_f32; block.tissue.mesh.nodes_m.len()];
        let mut stiff = around.clone();
        for (t, n) in tets.iter().flat_map(|t| t.node.map(|n| (t, n as usize))) {
            around[n] += t.volume_m3;
            stiff[n] += t.volume_m3 * t.stiffness_ratio;
        }
        // nodal averaging only softens, so the diagonal of plain tets is an upper bound
        Self {
            diagonal_m: diagonal_m(block, &tets, lambda, mu),
            tets,
            lambda: lambda as f32,
            mu: mu as f32,
            volume,
            node_lambda: stiff.iter().zip(&around).map(|(s, v)| lambda as f32 * (s / v)).collect(),
            node: around.clone(),
            around_reciprocal: around.into_iter().map(|v| 1.0 / v).collect(),
        }
    }

    /// Computes the pressure `lambda ln J_n / J_n` of every node.
    fn average(&mut self, position_m: &[Vector3<f32>]) {
        self.node.fill(0.0);
        for tet in &self.tets {
            let [a, b, c, d] = tet.node.map(|n| position_m[n as usize]);
            let volume = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
            tet.node.iter().for_each(|&n| self.node[n as usize] += volume);
        }
        for ((p, reciprocal), lambda) in self.node.iter_mut().zip(&self.around_reciprocal).zip(&self.node_lambda) {
            let j = *p * reciprocal;
            *p = lambda * j.ln() / j;
        }
    }
}

impl Law for NeoHookean {
    fn forces(&mut self, position_m: &[Vector3<f32>], force: &mut [Vector3<f32>]) {
        if self.volume == Volume::Nodal {
            self.average(position_m);
        }
        force.fill(Vector3::zeros());
        for tet in &self.tets {
            let f = tet.deformation(position_m);
            let (cofactors, j) = cofactors(&f);
            let mu = self.mu * tet.stiffness_ratio;
            // the coefficient of the cofactors, d psi / d J
            let pressure = match self.volume {
                Volume::PerTet => (tet.stiffness_ratio * self.lambda * j.ln() - mu) / j,
                // d V / d F = V_0 cof F; a tet belongs to four nodes, each with a quarter of the
                // weight
                Volume::Nodal => 0.25 * tet.node.iter().map(|&n| self.node[n as usize]).sum::<f32>() - mu / j,
            };
            let stress = [0, 1, 2].map(|k| f[k] * mu + cofactors[k] * pressure);
            tet.scatter(&stress, force);
        }
    }

    fn diagonal_m(&self) -> &[f32] {
        &self.diagonal_m
    }
}
