//! The model a second time: written from its energies, in double precision, slow, and sharing no
//! line with the core.
//!
//! Energies are those the core documents ([`energy`]); forces are their slopes by automatic
//! differentiation ([`number`]); the only forces written as such are those that have no energy, the
//! dampings.

pub mod energy;
pub mod number;

use palpate::stages::force::foundation::point_weights;
use palpate::{Model, Params, Tet, Vector3};

use energy::{Point, depth_inside, minus, of_foundation, of_node, of_rim_edge, of_rim_node, of_spring, of_tet, six_volume};
use number::{Dual, Number};

type Vector = Vector3<f64>;

/// A probe in motion.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// Where [m].
    pub at_m: Vector,
    /// How fast [m/s].
    pub velocity_m_per_s: Vector,
}

/// A model with its parameters.
#[derive(Clone, Debug)]
pub struct Oracle<'a> {
    model: Model<'a>,
    params: Params,
    /// Masses with their floors [kg], anchors too, shape \[nodes\].
    mass_kg: Vec<f64>,
    anchored: Vec<bool>,
    springs_at: Vec<Vec<usize>>,
    tets_at: Vec<Vec<usize>>,
    rim_nodes_at: Vec<Vec<usize>>,
    rim_edges_at: Vec<Vec<usize>>,
}

impl<'a> Oracle<'a> {
    /// Reads the model's fields with their documented factors.
    #[must_use]
    pub fn new(model: Model<'a>, params: Params) -> Self {
        let none = || vec![Vec::new(); model.nodes.len()];
        let (mut springs_at, mut tets_at, mut rim_nodes_at, mut rim_edges_at) = (none(), none(), none(), none());
        let mut anchored = vec![false; model.nodes.len()];
        model.anchors.iter().for_each(|&a| anchored[usize::from(a)] = true);
        for (n, s) in model.springs.iter().enumerate() {
            [s.i, s.j].into_iter().for_each(|i| springs_at[usize::from(i)].push(n));
        }
        for (n, t) in model.tets.iter().enumerate() {
            t.node.into_iter().for_each(|i| tets_at[usize::from(i)].push(n));
        }
        model.rim_nodes.iter().enumerate().for_each(|(n, r)| rim_nodes_at[r.node as usize].push(n));
        for (n, r) in model.rim_edges.iter().enumerate() {
            r.node.into_iter().for_each(|i| rim_edges_at[usize::from(i)].push(n));
        }
        let [e, density, floor, contact_mass, tick_s] =
            [params.youngs_modulus_pa, params.density_kg_per_m3, params.mass_floor, params.contact_mass, params.tick_s]
                .map(f64::from);
        let mass = |node: &palpate::NodeRest| {
            let [volume_m3, stiffness_m, contact_m] = [node.volume_m3, node.stiffness_m, node.contact_m].map(f64::from);
            (density * volume_m3).max(floor * e * stiffness_m * tick_s * tick_s) + contact_mass * e * contact_m * tick_s * tick_s
        };
        let mass_kg = model.nodes.iter().map(mass).collect();
        Self { model, params, mass_kg, anchored, springs_at, tets_at, rim_nodes_at, rim_edges_at }
    }

    /// Mass of a node [kg]; an anchor's is what it would be if it were free.
    #[must_use]
    pub fn mass_kg(&self, node: usize) -> f64 {
        self.mass_kg[node]
    }

    /// Young's modulus [Pa].
    #[must_use]
    pub fn youngs_modulus_pa(&self) -> f64 {
        f64::from(self.params.youngs_modulus_pa)
    }

    /// Potential energy of the tissue, without contact [J].
    #[must_use]
    pub fn energy_j(&self, x: &[Vector]) -> f64 {
        let at = |n: usize| -> Point<f64> { x[n].into() };
        let springs = self.model.springs.iter().map(|s| of_spring(s, &self.params, at(s.i.into()), at(s.j.into())));
        let mut energy: f64 = springs.sum();
        if self.params.terms.volume {
            energy += self.model.tets.iter().map(|t| of_tet(t, &self.params, t.node.map(|n| at(n.into())))).sum::<f64>();
            let around = self.six_volumes(x);
            energy += (0..x.len()).map(|n| self.of_node(n, around[n])).sum::<f64>();
        }
        if self.params.terms.rim {
            energy += self
                .model
                .rim_nodes
                .iter()
                .map(|r| of_rim_node(r, self.moved(r.node as usize, at(r.node as usize))))
                .sum::<f64>();
            let u = |n: u16| self.moved(n.into(), at(n.into()));
            energy += self.model.rim_edges.iter().map(|r| of_rim_edge(r, u(r.node[0]), u(r.node[1]))).sum::<f64>();
        }
        energy += (0..x.len()).map(|n| self.of_weight(n, at(n))).sum::<f64>();
        energy * self.youngs_modulus_pa()
    }

    /// Forces on the nodes without contact [N], anchors too.
    #[must_use]
    pub fn forces_n(&self, x: &[Vector]) -> Vec<Vector> {
        let around = self.six_volumes(x);
        (0..x.len()).map(|n| -self.slope(x, &around, n) * self.youngs_modulus_pa()).collect()
    }

    /// Forces of the foundation on the nodes [N].
    #[must_use]
    pub fn contact_n(&self, x: &[Vector], v: &[Vector], tip: Tip) -> Vec<Vector> {
        let mut on = vec![Vector::zeros(); x.len()];
        let e = self.youngs_modulus_pa();
        let damping_s = f64::from(self.params.contact_damping * self.params.tick_s) / f64::from(self.params.substeps);
        for (triangle, points) in self.model.triangles.iter().zip(self.model.foundation.chunks(self.model.points_per_triangle()))
        {
            let node = triangle.node.map(usize::from);
            let cap_m = self.cap_m(triangle);
            for (weights, law) in point_weights(points.len()).iter().zip(points) {
                let mean = |of: &[Vector]| (0..3).map(|c| of[node[c]] * f64::from(weights[c])).sum::<Vector>();
                let point = Dual::coordinates(mean(x).into());
                let Some(depth) = depth_inside(&self.params, tip.at_m.into(), point) else { continue };
                let k = f64::from(law.k);
                // bend is 1 / (2 k s)
                let stiffening_per_m = 1.0 / (2.0 * k * f64::from(law.bend));
                let elastic = -Vector::from(of_foundation(k, stiffening_per_m, cap_m, depth).slope);
                let out = -Vector::from(depth.slope).normalize();
                let push = elastic.norm() - damping_s * cap_m.max(k) * (mean(v) - tip.velocity_m_per_s).dot(&out);
                for (n, w) in node.into_iter().zip(weights) {
                    on[n] += out * (push.max(0.0) * f64::from(*w) * e);
                }
            }
        }
        on
    }

    /// One tick as documented: the tip goes straight from one place to the other, the probe's force
    /// [N] is the mean over the substeps.
    pub fn tick(&self, x: &mut [Vector], v: &mut [Vector], from_m: Vector, to_m: Vector) -> Vector {
        let (tick_s, substeps) = (f64::from(self.params.tick_s), self.params.substeps);
        let dt_s = tick_s / f64::from(substeps);
        let velocity_m_per_s = (to_m - from_m) / tick_s;
        let mut force_n = Vector::zeros();
        for substep in 1..=substeps {
            let at_m = from_m + (to_m - from_m) * (f64::from(substep) / f64::from(substeps));
            let inner = self.forces_n(x);
            let contact = self.contact_n(x, v, Tip { at_m, velocity_m_per_s });
            for n in (0..x.len()).filter(|&n| !self.anchored[n]) {
                v[n] = v[n] * (1.0 - f64::from(self.params.node_damping_per_s) * dt_s)
                    + (inner[n] + contact[n]) * (dt_s / self.mass_kg[n]);
                x[n] += v[n] * dt_s;
            }
            force_n -= contact.iter().sum::<Vector>() / f64::from(substeps);
        }
        force_n
    }

    /// Largest slope of a triangle's foundation points over E [m]: a share of what the masses of
    /// its corners can take in a tick.
    #[must_use]
    pub fn cap_m(&self, triangle: &palpate::Triangle) -> f64 {
        let tick_s = f64::from(self.params.tick_s);
        let backed = triangle.node.iter().zip(triangle.share).map(|(&n, share)| self.mass_kg[usize::from(n)] * f64::from(share));
        f64::from(self.params.contact_cap) * backed.fold(f64::INFINITY, f64::min) / (self.youngs_modulus_pa() * tick_s * tick_s)
    }

    /// Slope of the energy over E along the coordinates of one node.
    fn slope(&self, x: &[Vector], around: &[f64], node: usize) -> Vector {
        let at = |n: usize| if n == node { Dual::coordinates(x[n].into()) } else { Point::from(x[n]).map(Dual::of) };
        let corners = |t: &Tet| t.node.map(|n| at(n.into()));
        let mut energy = self.of_weight(node, at(node));
        for s in self.springs_at[node].iter().map(|&s| &self.model.springs[s]) {
            energy = energy + of_spring(s, &self.params, at(s.i.into()), at(s.j.into()));
        }
        if self.params.terms.volume {
            let mut stars = std::collections::BTreeMap::new();
            for t in self.tets_at[node].iter().map(|&t| &self.model.tets[t]) {
                energy = energy + of_tet(t, &self.params, corners(t));
                for n in t.node.map(usize::from) {
                    let star = stars.entry(n).or_insert(Dual::of(around[n]));
                    // the value is there already, the slope is not
                    let v = six_volume(corners(t));
                    *star = *star + (v - Dual::of(v.value));
                }
            }
            for (n, six_volume) in stars {
                energy = energy + self.of_node(n, six_volume);
            }
        }
        if self.params.terms.rim {
            let u = |n: usize| self.moved(n, at(n));
            for r in self.rim_nodes_at[node].iter().map(|&r| &self.model.rim_nodes[r]) {
                energy = energy + of_rim_node(r, u(node));
            }
            for r in self.rim_edges_at[node].iter().map(|&r| &self.model.rim_edges[r]) {
                energy = energy + of_rim_edge(r, u(r.node[0].into()), u(r.node[1].into()));
            }
        }
        energy.slope.into()
    }

    /// Six times the volume of the tets around each node [m^3].
    fn six_volumes(&self, x: &[Vector]) -> Vec<f64> {
        let mut around = vec![0.0; x.len()];
        for t in self.model.tets {
            let v = six_volume(t.node.map(|n| x[usize::from(n)].into()));
            t.node.into_iter().for_each(|n| around[usize::from(n)] += v);
        }
        around
    }

    fn of_node<N: Number>(&self, n: usize, six_volume: N) -> N {
        let node = &self.model.nodes[n];
        // `pressure` is 2 kappa (1 - beta) / 24
        let kappa = 12.0 * f64::from(node.pressure);
        of_node(kappa, f64::from(node.volume_m3), six_volume * N::of(f64::from(node.six_volume_reciprocal)))
    }

    /// Energy of the true mass, not the floored one, in the field of gravity.
    fn of_weight<N: Number>(&self, n: usize, x: Point<N>) -> N {
        let over_e =
            f64::from(self.params.density_kg_per_m3) * f64::from(self.model.nodes[n].volume_m3) / self.youngs_modulus_pa();
        let gravity = self.params.gravity_m_per_s2.map(|g| N::of(-over_e * f64::from(g)));
        energy::dot(gravity, x)
    }

    fn moved<N: Number>(&self, n: usize, x: Point<N>) -> Point<N> {
        minus(x, self.model.nodes[n].rest_m.map(|c| N::of(f64::from(c))))
    }
}
