//! Neo-Hookean or stiffening tissue under a rigid probe: energy, residual, tangent.
//!
//! psi = w + lambda/2 (ln J)^2, w = mu/2 (I1 - 3) - mu ln J (Bonet and Wood, *Nonlinear Continuum
//! Mechanics*, 6.28), with mu = E/(2(1+nu)), lambda = E nu/((1+nu)(1-2nu)), and E = 1 Pa times the
//! stiffness ratio at the quadrature point. In tissue that stiffens, w is replaced by mu/2b (exp(2
//! b w / mu) - 1) (Fung 1967, Demiray 1972: w is mu/2 (I1 - 3) where the volume is preserved),
//! which is w at b = 0. Contact with the probe is in [`super::touch`].

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator, ParallelSlice};

use super::assembly::Pattern;
use super::probe::RigidProbe;
use super::quadratic::QuadraticMesh;
use super::shape::{TetRule, tet_at, tet_shape, triangle_shape};
use palpate_tissue::scene::Inclusion;

/// Number of elements that are processed at once, which bounds the memory for element matrices, and
/// number of elements per parallel task.
const BATCH: usize = 2048;
const CHUNK: usize = 64;

/// Material of the tissue; its stiffness is relative to Young's modulus.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Stiffening exponent b (1) outside the balls that have their own; zero is neo-Hookean.
    pub stiffening_b: f64,
    /// Balls of another stiffness; where balls overlap, the last one applies.
    pub inclusions: Vec<Inclusion>,
}

impl Material {
    /// Stiffness at a point [m].
    #[must_use]
    pub fn at(&self, x: &Vector3<f64>) -> Stiffness {
        let ball = self.inclusions.iter().rev().find(|ball| (x - Vector3::from(ball.center_m)).norm() <= ball.radius_m);
        Stiffness {
            ratio: ball.map_or(1.0, |ball| ball.stiffness_ratio),
            poisson_ratio: self.poisson_ratio,
            stiffening_b: ball.and_then(|ball| ball.stiffening_b).unwrap_or(self.stiffening_b),
        }
    }
}

/// Elastic constants at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Young's modulus at the point, divided by the modulus by which all energies and forces are
    /// divided (1).
    pub ratio: f64,
    /// Poisson's ratio (1), below 0.5.
    pub poisson_ratio: f64,
    /// Stiffening exponent b (1); zero is neo-Hookean.
    pub stiffening_b: f64,
}

impl Stiffness {
    /// Lamé constants mu and lambda, over Young's modulus (1).
    fn lame(self) -> (f64, f64) {
        let nu = self.poisson_ratio;
        (self.ratio * (0.5 / (1.0 + nu)), self.ratio * (nu / ((1.0 + nu) * (1.0 - 2.0 * nu))))
    }
}

/// A quadrature point of a tet, with the constants of its material over Young's modulus.
struct Point {
    gradients: [Vector3<f64>; 10],
    volume_m3: f64,
    mu: f64,
    lambda: f64,
    stiffening_b: f64,
}

/// Probe and penalty stiffness of the contact.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Rigid probe that presses the tissue, at its present position.
    pub probe: RigidProbe,
    /// Contact pressure divided by penetration and by Young's modulus [1/m].
    pub penalty_per_m: f64,
}

/// A supported piece of tissue.
pub struct Body {
    /// Quadratic mesh of the piece.
    pub mesh: QuadraticMesh,
    /// Components of each node's displacement that are fixed at zero.
    pub fixed: Vec<[bool; 3]>,
    /// Triangles that may touch the probe, as indices into those of the mesh.
    pub touchable: Vec<usize>,
    /// Number of mirror images, including this piece, of which the whole consists.
    pub copies: f64,
    /// Blocks of the tangent, and their places in it.
    pub pattern: Pattern,
    points: Vec<Point>,
    points_per_tet: usize,
    /// Estimated rounding error of the elastic energy over Young's modulus [m^3]: machine epsilon
    /// times the sum of shear modulus times volume. The energy is a small difference of numbers of
    /// this size.
    pub rounding_m3: f64,
}

/// Energy and its derivatives at one state of displacement.
pub struct Assembled {
    /// Energy over Young's modulus [m^3].
    pub energy_m3: f64,
    /// Gradient of the energy over Young's modulus [m^2], which vanishes at free components in
    /// equilibrium.
    pub residual_m2: Vec<Vector3<f64>>,
    /// Lower triangle of the second derivative over Young's modulus [m], in the pattern's order and
    /// before the rows and columns of fixed components are replaced. Empty unless requested.
    pub tangent: Vec<f64>,
}

struct Element {
    energy: f64,
    force: [Vector3<f64>; 10],
    stiffness: Vec<Matrix3<f64>>,
}

impl Body {
    /// Prepares a body of this material.
    #[must_use]
    pub fn new(
        mesh: QuadraticMesh,
        material: &Material,
        fixed: Vec<[bool; 3]>,
        touchable: Vec<usize>,
        copies: f64,
        rule: TetRule,
    ) -> Self {
        Self::with_stiffness(mesh, |_, x| material.at(x), fixed, touchable, copies, rule)
    }

    /// Prepares a body whose stiffness is a function of the tet (by index) and of the point (rest
    /// position [m]).
    #[must_use]
    pub fn with_stiffness(
        mesh: QuadraticMesh,
        stiffness: impl Fn(usize, &Vector3<f64>) -> Stiffness,
        fixed: Vec<[bool; 3]>,
        touchable: Vec<usize>,
        copies: f64,
        rule: TetRule,
    ) -> Self {
        let rule = rule.points();
        let mut points = Vec::with_capacity(rule.len() * mesh.tets.len());
        for (t, tet) in mesh.tets.iter().enumerate() {
            let nodes = tet.map(|n| mesh.nodes_m[n as usize]);
            for (at, share) in &rule {
                let x = nodes.iter().zip(tet_shape(*at)).map(|(x, part)| x * part).sum::<Vector3<f64>>();
                let stiffness = stiffness(t, &x);
                let (mu, lambda) = stiffness.lame();
                let (gradients, volume_m3) = tet_at(*at, &nodes);
                points.push(Point { gradients, volume_m3: share * volume_m3, mu, lambda, stiffening_b: stiffness.stiffening_b });
            }
        }
        let pattern = Pattern::new(&mesh, &[]);
        let rounding_m3 = f64::EPSILON * points.iter().map(|point| point.mu * point.volume_m3).sum::<f64>();
        Self { points_per_tet: rule.len(), mesh, fixed, touchable, copies, pattern, points, rounding_m3 }
    }

    /// Reserves blocks of the tangent between all nodes of each group.
    pub fn couple(&mut self, groups: &[[u32; 12]]) {
        self.pattern = Pattern::new(&self.mesh, groups);
    }

    /// Energy over Young's modulus [m^3]; `None` if an element is inverted.
    #[must_use]
    pub fn energy(&self, displacement_m: &[Vector3<f64>], contact: Option<&Contact>) -> Option<f64> {
        let tets: Vec<usize> = (0..self.mesh.tets.len()).collect();
        let parts: Vec<Option<f64>> =
            tets.par_chunks(CHUNK).map(|chunk| chunk.iter().map(|t| self.element_energy(*t, displacement_m)).sum()).collect();
        let elastic: f64 = parts.into_iter().sum::<Option<f64>>()?;
        let mut energy = elastic;
        if let Some(contact) = contact {
            energy += self.contact_energy_m3(&self.touchable, displacement_m, contact);
        }
        energy.is_finite().then_some(energy)
    }

    /// Energy, residual and tangent; `None` if an element is inverted.
    #[must_use]
    pub fn assemble(&self, displacement_m: &[Vector3<f64>], contact: Option<&Contact>) -> Option<Assembled> {
        let mut sum = self.derive(displacement_m, true)?;
        if let Some(contact) = contact {
            self.add_contact(&self.touchable, displacement_m, contact, &mut sum);
        }
        Some(sum)
    }

    /// Energy, residual and, if requested, tangent, all without contact; `None` if an element is
    /// inverted.
    pub fn derive(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled> {
        let mut sum = Assembled {
            energy_m3: 0.0,
            residual_m2: vec![Vector3::zeros(); self.mesh.nodes_m.len()],
            tangent: vec![0.0; if tangent { self.pattern.entries() } else { 0 }],
        };
        let tets: Vec<usize> = (0..self.mesh.tets.len()).collect();
        for batch in tets.chunks(BATCH) {
            let one = |t: &usize| self.element(*t, displacement_m, tangent);
            let elements: Vec<Option<Element>> = batch.par_iter().with_min_len(CHUNK).map(one).collect();
            for (t, element) in batch.iter().zip(elements) {
                let element = element?;
                sum.energy_m3 += element.energy;
                let nodes = &self.mesh.tets[*t];
                for (i, force) in nodes.iter().zip(&element.force) {
                    sum.residual_m2[*i as usize] += force;
                }
                let pairs = (0..10).flat_map(|a| (0..=a).map(move |b| (a, b)));
                for ((a, b), block) in pairs.zip(&element.stiffness) {
                    self.pattern.add(&mut sum.tangent, nodes[a], nodes[b], block);
                }
            }
        }
        Some(sum)
    }

    /// Product of the tangent and a vector over nodes, including fixed components.
    #[must_use]
    pub fn tangent_times(&self, assembled: &Assembled, vector: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        self.pattern.multiply(&assembled.tangent, vector)
    }

    /// Displacement of a point on a flat horizontal part of the touchable surface; `None` if there
    /// is no such surface at the point.
    #[must_use]
    pub fn surface_at(&self, displacement_m: &[Vector3<f64>], at_m: &Vector3<f64>) -> Option<Vector3<f64>> {
        // rounding may place a point slightly outside a triangle
        const SLACK: f64 = 1e-9;
        for t in &self.touchable {
            let nodes = &self.mesh.triangles[*t];
            let [a, b, c] = [0, 1, 2].map(|k| self.mesh.nodes_m[nodes[k] as usize] - at_m);
            if a.z.abs().max(b.z.abs()).max(c.z.abs()) > SLACK {
                continue;
            }
            let twice = |p: &Vector3<f64>, q: &Vector3<f64>| p.x * q.y - p.y * q.x;
            let parts = [twice(&b, &c), twice(&c, &a), twice(&a, &b)];
            let whole: f64 = parts.iter().sum();
            if whole > 0.0 && parts.iter().all(|p| *p >= -SLACK * whole) {
                let shape = triangle_shape(parts.map(|p| p / whole));
                return Some((0..6).map(|k| displacement_m[nodes[k] as usize] * shape[k]).sum());
            }
        }
        None
    }

    fn points(&self, tet: usize) -> &[Point] {
        &self.points[tet * self.points_per_tet..][..self.points_per_tet]
    }

    fn element_energy(&self, tet: usize, displacement_m: &[Vector3<f64>]) -> Option<f64> {
        let u = self.mesh.tets[tet].map(|n| displacement_m[n as usize]);
        let mut energy = 0.0;
        for point in self.points(tet) {
            let f = point.deformation(&u);
            let j = f.determinant();
            if j <= 0.0 {
                return None;
            }
            energy += point.energy(&f, j.ln());
        }
        Some(energy)
    }

    fn element(&self, tet: usize, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Element> {
        let u = self.mesh.tets[tet].map(|n| displacement_m[n as usize]);
        let blocks = if tangent { 55 } else { 0 };
        let mut sum = Element { energy: 0.0, force: [Vector3::zeros(); 10], stiffness: vec![Matrix3::zeros(); blocks] };
        for point in self.points(tet) {
            let f = point.deformation(&u);
            let j = f.determinant();
            if j <= 0.0 {
                return None;
            }
            let ln_j = j.ln();
            sum.energy += point.energy(&f, ln_j);
            let inverse_transposed = f.try_inverse()?.transpose();
            // gradients of the shape functions in the rest configuration and, pushed forward, in
            // the deformed one
            let rest = &point.gradients;
            let now = rest.map(|g| inverse_transposed * g);
            let (v, lambda) = (point.volume_m3, point.lambda);
            let stiffer = point.stiffer(&f, ln_j);
            let mu = point.mu * stiffer;
            let pressure = lambda * ln_j - mu;
            // gradient of w over mu with respect to each node, and the term from the change of the
            // stiffening factor
            let slopes: [Vector3<f64>; 10] = std::array::from_fn(|a| f * rest[a] - now[a]);
            let steeper = 2.0 * point.stiffening_b * mu * v;
            for a in 0..10 {
                sum.force[a] += ((f * rest[a]) * mu + now[a] * pressure) * v;
                if !tangent {
                    continue;
                }
                for b in 0..=a {
                    let block = &mut sum.stiffness[a * (a + 1) / 2 + b];
                    *block += now[a] * (now[b].transpose() * (lambda * v)) - now[b] * (now[a].transpose() * (pressure * v));
                    let same = mu * v * rest[a].dot(&rest[b]);
                    for k in 0..3 {
                        block[(k, k)] += same;
                    }
                    if steeper > 0.0 {
                        *block += slopes[a] * (slopes[b].transpose() * steeper);
                    }
                }
            }
        }
        Some(sum)
    }
}

impl Point {
    fn deformation(&self, displacement_m: &[Vector3<f64>; 10]) -> Matrix3<f64> {
        let mut f = Matrix3::identity();
        for (u, g) in displacement_m.iter().zip(&self.gradients) {
            f += u * g.transpose();
        }
        f
    }

    /// Twice the distortion energy over mu: I1 - 3 - 2 ln J.
    fn distortion(f: &Matrix3<f64>, ln_j: f64) -> f64 {
        (f.norm_squared() - 3.0) - 2.0 * ln_j
    }

    /// Factor by which stiffening increases the shear modulus (1).
    fn stiffer(&self, f: &Matrix3<f64>, ln_j: f64) -> f64 {
        if self.stiffening_b > 0.0 { (self.stiffening_b * Self::distortion(f, ln_j)).exp() } else { 1.0 }
    }

    fn energy(&self, f: &Matrix3<f64>, ln_j: f64) -> f64 {
        let b = self.stiffening_b;
        let strain = if b > 0.0 {
            0.5 * self.mu / b * (b * Self::distortion(f, ln_j)).exp_m1() + 0.5 * self.lambda * ln_j * ln_j
        } else {
            0.5 * self.mu * (f.norm_squared() - 3.0) - self.mu * ln_j + 0.5 * self.lambda * ln_j * ln_j
        };
        strain * self.volume_m3
    }
}
