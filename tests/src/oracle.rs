//! An independent implementation of the model: derived from its energies, in double precision,
//! slow, and without code shared with the core.
//!
//! The energies are those that the core documents ([`energy`]). Forces are their derivatives by
//! automatic differentiation ([`number`]). Only damping forces, which have no energy, are written
//! directly.

pub mod energy;
pub mod number;
pub mod smooth;

use palpate::stages::force::foundation::point_weights;
use palpate::{Model, Params, Tet, Vector3};

use energy::{Point, depth_inside, minus, of_foundation, of_node, of_rim_edge, of_rim_node, of_spring, of_tet, six_volume};
use number::{Dual, Number};
use smooth::{Field, fields};

type Vector = Vector3<f64>;

/// Safety factor of lumping the foundation's stiffness at the nodes (1), as documented.
const CONTACT_LUMPING: f64 = 1.5;
/// Weight of a node's neighbours in its acceleration (1), as documented.
const NEIGHBOUR: f64 = 2.0;

/// A probe in motion.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// Position [m].
    pub at_m: Vector,
    /// Velocity [m/s].
    pub velocity_m_per_s: Vector,
}

/// A model with its parameters.
#[derive(Clone, Debug)]
pub struct Oracle<'a> {
    model: Model<'a>,
    params: Params,
    /// Diagonal of the mass matrix [kg], including anchors, shape \[nodes\].
    mass_kg: Vec<f64>,
    /// Added mass between the two ends of each spring [kg], shape \[springs\].
    between_kg: Vec<f64>,
    fields: Vec<Field>,
    anchored: Vec<bool>,
    springs_at: Vec<Vec<usize>>,
    tets_at: Vec<Vec<usize>>,
    rim_nodes_at: Vec<Vec<usize>>,
    rim_edges_at: Vec<Vec<usize>>,
}

impl<'a> Oracle<'a> {
    /// Reads the model and applies the documented factors.
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
        let [e, density, floor, tick_s] =
            [params.youngs_modulus_pa, params.density_kg_per_m3, params.mass_floor, params.tick_s].map(f64::from);
        let own_kg: Vec<f64> = model.nodes.iter().map(|n| density * f64::from(n.volume_m3)).collect();
        let added_kg = model
            .nodes
            .iter()
            .zip(&own_kg)
            .map(|(n, own)| (floor * e * f64::from(n.stiffness_m) * tick_s * tick_s - own).max(0.0));
        let added_kg: Vec<f64> = added_kg.collect();
        let around: Vec<f64> = springs_at.iter().map(|s| s.iter().map(|&s| f64::from(model.springs[s].k)).sum()).collect();
        // rim springs act against the ground, so their part of the added mass belongs to the node
        // alone
        let ground = |n: usize| -> f64 {
            let blocks = rim_nodes_at[n].iter().map(|&r| &model.rim_nodes[r].block_m);
            blocks.map(|b| f64::from(b[0] + b[1] + b[2]) / 3.0).sum()
        };
        let between = params.terms.relative_mass || params.terms.smooth_mass;
        let relative = |n: usize| between && around[n] > 0.0;
        let grounded_kg: Vec<f64> = (0..model.nodes.len())
            .map(|n| match (relative(n), params.terms.rim) {
                (false, _) => added_kg[n],
                (true, false) => 0.0,
                (true, true) => (added_kg[n] * ground(n) / f64::from(model.nodes[n].stiffness_m)).clamp(0.0, added_kg[n]),
            })
            .collect();
        let half = |n: u16| 0.5 * (added_kg[usize::from(n)] - grounded_kg[usize::from(n)]) / around[usize::from(n)];
        let between_kg: Vec<f64> = match between {
            true => model.springs.iter().map(|s| f64::from(s.k) * (half(s.i) + half(s.j))).collect(),
            false => vec![0.0; model.springs.len()],
        };
        let mass_kg: Vec<f64> = (0..model.nodes.len())
            .map(|n| own_kg[n] + grounded_kg[n] + springs_at[n].iter().map(|&s| between_kg[s]).sum::<f64>())
            .collect();
        let series = params.terms.relative_mass;
        let fields = fields(&model, &mass_kg, &between_kg, &anchored, series);
        // without the series there is no sum over neighbours, only the one smooth field
        let between_kg = if series { between_kg } else { vec![0.0; between_kg.len()] };
        Self { model, params, mass_kg, between_kg, fields, anchored, springs_at, tets_at, rim_nodes_at, rim_edges_at }
    }

    /// Diagonal of the mass matrix at a node [kg]; an anchor has the value that it would have if it
    /// were free.
    pub fn mass_kg(&self, node: usize) -> f64 {
        self.mass_kg[node]
    }

    /// Returns a function that computes momenta [kg m/s] from velocities: it solves densely with
    /// the approximate inverse mass matrix that [`Self::tick`] applies. Momenta of anchors are
    /// zero. Only external forces change the sum of the momenta.
    ///
    /// # Panics
    /// Panics if that matrix is not positive definite: it would then add energy.
    pub fn momenta(&self) -> impl Fn(&[Vector]) -> Vec<Vector> + use<> {
        let free: Vec<usize> = (0..self.mass_kg.len()).filter(|&n| !self.anchored[n]).collect();
        let place: std::collections::BTreeMap<usize, usize> = free.iter().enumerate().map(|(k, &n)| (n, k)).collect();
        let mut factor = vec![vec![0.0; free.len()]; free.len()];
        for (k, &n) in free.iter().enumerate() {
            factor[k][k] = 1.0 / self.mass_kg[n];
        }
        for (s, kg) in self.model.springs.iter().zip(&self.between_kg) {
            let [i, j] = [s.i, s.j].map(usize::from);
            if let (Some(&k), Some(&l)) = (place.get(&i), place.get(&j)) {
                factor[k.max(l)][k.min(l)] += NEIGHBOUR * kg / (self.mass_kg[i] * self.mass_kg[j]);
            }
        }
        for field in &self.fields {
            for (k, &n) in free.iter().enumerate() {
                let row = free.iter().zip(&mut factor[k]).take(k + 1);
                row.for_each(|(&m, entry)| *entry += field.per_kg * field.shape[n] * field.shape[m]);
            }
        }
        // Cholesky, in place
        for k in 0..free.len() {
            let (above, below) = factor.split_at_mut(k);
            let row = &mut below[0];
            for l in 0..k {
                let sum: f64 = row[..l].iter().zip(&above[l][..l]).map(|(a, b)| a * b).sum();
                row[l] = (row[l] - sum) / above[l][l];
            }
            let left = row[k] - row[..k].iter().map(|a| a * a).sum::<f64>();
            assert!(left > 0.0, "the mass matrix is not positive at node {}", free[k]);
            row[k] = left.sqrt();
        }
        let nodes = self.mass_kg.len();
        move |v: &[Vector]| {
            let mut solved: Vec<Vector> = free.iter().map(|&n| v[n]).collect();
            for k in 0..free.len() {
                let sum: Vector = (0..k).map(|l| solved[l] * factor[k][l]).sum();
                solved[k] = (solved[k] - sum) / factor[k][k];
            }
            for k in (0..free.len()).rev() {
                let sum: Vector = (k + 1..free.len()).map(|l| solved[l] * factor[l][k]).sum();
                solved[k] = (solved[k] - sum) / factor[k][k];
            }
            let mut momenta = vec![Vector::zeros(); nodes];
            free.iter().zip(solved).for_each(|(&n, p)| momenta[n] = p);
            momenta
        }
    }

    /// Young's modulus [Pa].
    pub fn youngs_modulus_pa(&self) -> f64 {
        f64::from(self.params.youngs_modulus_pa)
    }

    /// Potential energy of the tissue, without contact [J].
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

    /// Forces on the nodes without contact [N], including anchors.
    pub fn forces_n(&self, x: &[Vector]) -> Vec<Vector> {
        let around = self.six_volumes(x);
        (0..x.len()).map(|n| -self.slope(x, &around, n) * self.youngs_modulus_pa()).collect()
    }

    /// Forces of the foundation on the nodes [N], at the end of a substep in which the forces
    /// `inner` [N] act as well.
    pub fn contact_n(&self, x: &[Vector], v: &[Vector], inner: &[Vector], tip: Tip) -> Vec<Vector> {
        self.contact(x, v, inner, tip).into_iter().map(|(push, _)| push).collect()
    }

    /// For each node, the force of the foundation [N] and the share of the smooth fields'
    /// acceleration that contact leaves (1).
    fn contact(&self, x: &[Vector], v: &[Vector], inner: &[Vector], tip: Tip) -> Vec<(Vector, f64)> {
        let e = self.youngs_modulus_pa();
        let dt_s = f64::from(self.params.tick_s) / f64::from(self.params.substeps);
        let keep = 1.0 - f64::from(self.params.node_damping_per_s) * dt_s;
        let (mut push_n, mut slope_n_per_m) = (vec![Vector::zeros(); x.len()], vec![0.0; x.len()]);
        let stiffening_per_m = f64::from(self.model.stiffening_per_m);
        for (triangle, points) in self.model.triangles.iter().zip(self.model.foundation.chunks(self.model.points_per_triangle()))
        {
            let node = triangle.node.map(usize::from);
            for (weights, law) in point_weights(points.len()).iter().zip(points) {
                let mean = |of: &[Vector]| (0..3).map(|c| of[node[c]] * f64::from(weights[c])).sum::<Vector>();
                let point = Dual::coordinates(mean(x).into());
                let Some(depth) = depth_inside(&self.params, tip.at_m.into(), point) else { continue };
                let k = f64::from(law.k);
                let elastic = -Vector::from(of_foundation(k, stiffening_per_m, depth).slope);
                let slope = k * (1.0 + 2.0 * stiffening_per_m * depth.value);
                for (n, w) in node.into_iter().zip(weights) {
                    push_n[n] += elastic * (f64::from(*w) * e);
                    slope_n_per_m[n] += slope * f64::from(*w) * e;
                }
            }
        }
        // a node's force after its displacement in the substep, and a dashpot of beta times slope
        // times dt between node and probe
        let at_end = |n: usize| {
            let length = push_n[n].norm();
            if length == 0.0 {
                return (Vector::zeros(), 1.0);
            }
            let out = push_n[n] / length;
            let yields = if self.anchored[n] { 0.0 } else { CONTACT_LUMPING * dt_s * dt_s / self.mass_kg[n] };
            let displacement_m = keep * dt_s * v[n].dot(&out) + yields * inner[n].dot(&out)
                - f64::from(self.params.contact_damping) * dt_s * tip.velocity_m_per_s.dot(&out);
            let resists = 1.0 + slope_n_per_m[n] * yields;
            (out * ((length - slope_n_per_m[n] * displacement_m) / resists).max(0.0), 1.0 / resists)
        };
        (0..x.len()).map(at_end).collect()
    }

    /// Accelerations [m/s^2] by the documented approximation of the inverse mass matrix. Contact
    /// reduces the smooth fields' acceleration of each node to the share `left`.
    fn accelerations(&self, force_n: &[Vector], left: &[f64]) -> Vec<Vector> {
        let alone: Vec<Vector> =
            (0..force_n.len()).map(|n| if self.anchored[n] { Vector::zeros() } else { force_n[n] / self.mass_kg[n] }).collect();
        let from_neighbours = |n: usize| {
            let springs = self.springs_at[n].iter().map(|&s| (&self.model.springs[s], self.between_kg[s]));
            let sum: Vector = springs.map(|(s, kg)| alone[usize::from(if usize::from(s.i) == n { s.j } else { s.i })] * kg).sum();
            sum * (NEIGHBOUR / self.mass_kg[n])
        };
        let project = |field: &Field| -> Vector { force_n.iter().zip(&field.shape).map(|(f, s)| f * (s * field.per_kg)).sum() };
        let moved: Vec<(&Field, Vector)> = self.fields.iter().map(|field| (field, project(field))).collect();
        let together = |n: usize| moved.iter().map(|(field, a)| a * field.shape[n]).sum::<Vector>() * left[n];
        let of = |n: usize| alone[n] + from_neighbours(n) + together(n);
        (0..force_n.len()).map(|n| if self.anchored[n] { Vector::zeros() } else { of(n) }).collect()
    }

    /// Runs one tick as documented and returns the force on the probe [N], averaged over the
    /// substeps, without the inertia of the mass that the floor adds. The tip moves in a straight
    /// line from `from_m` to `to_m`.
    ///
    /// `moved_m` is the displacement of the tip in the tick before.
    pub fn tick(&self, x: &mut [Vector], v: &mut [Vector], moved_m: Vector, from_m: Vector, to_m: Vector) -> Vector {
        let (tick_s, substeps) = (f64::from(self.params.tick_s), self.params.substeps);
        let dt_s = tick_s / f64::from(substeps);
        let velocity_m_per_s = (to_m - from_m) / tick_s;
        let (mut force_n, mut power_w, mut fastest) = (Vector::zeros(), 0.0, velocity_m_per_s.norm_squared());
        for substep in 1..=substeps {
            let at_m = from_m + (to_m - from_m) * (f64::from(substep) / f64::from(substeps));
            let inner = self.forces_n(x);
            let touched = self.contact(x, v, &inner, Tip { at_m, velocity_m_per_s });
            let (contact, left): (Vec<Vector>, Vec<f64>) = touched.into_iter().unzip();
            let all: Vec<Vector> = inner.iter().zip(&contact).map(|(a, b)| a + b).collect();
            let accelerations = self.accelerations(&all, &left);
            for n in (0..x.len()).filter(|&n| !self.anchored[n]) {
                let before = v[n];
                let kept = before * (1.0 - f64::from(self.params.node_damping_per_s) * dt_s);
                v[n] = kept + accelerations[n] * dt_s;
                x[n] += v[n] * dt_s;
                let true_mass_kg = f64::from(self.params.density_kg_per_m3) * f64::from(self.model.nodes[n].volume_m3);
                let lacks = all[n] - (v[n] - kept) * (true_mass_kg / dt_s);
                power_w += lacks.dot(&(before + v[n])) / 2.0 / f64::from(substeps);
                fastest = fastest.max(v[n].norm_squared());
            }
            force_n -= contact.iter().sum::<Vector>() / f64::from(substeps);
        }
        let push_n = force_n.norm();
        if push_n == 0.0 || fastest == 0.0 || moved_m.dot(&velocity_m_per_s) <= 0.0 {
            return force_n;
        }
        let gain_n = power_w * velocity_m_per_s.dot(&force_n) / push_n / fastest;
        force_n * (1.0 + gain_n.clamp(-push_n, push_n) / push_n)
    }

    /// Derivative of the energy over E with respect to the coordinates of one node.
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
                    // the value is already included, so only the derivative is added
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

    /// Six times the total volume of the tets around each node [m^3].
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

    /// Gravitational energy of the node's true mass, without the mass that the floor adds.
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
