//! A disc glued to the surface and moved slightly: normal press and shear of a bonded contact, with
//! derivatives.
//!
//! Every foundation point within the radius of the disc is tied to the translation `d` of the disc
//! by a spring of its initial stiffness `k`, in all three directions. To first order about rest,
//! `(K + sum k w w^T x I) u = sum k w d`, where `w` are the weights of the point, and the force is
//! `F = sum k (d - sum w u)`. `F . d` is twice the minimum of the energy over `u`, so its
//! derivative with respect to a constant is that of the energy at this `u` (Danskin): `w^T (dK/dp)
//! w`, and `|d - sum w u|^2` for a point. After a fit to frictionless presses alone, these two
//! cases are wrong by up to 20 %.

use nalgebra::Matrix3;
use palpate::stages::force::foundation::point_weights;

use super::{Gradient, Solver, Statics, Unbalanced, Vector, elastic};

/// A foundation point under the disc.
struct GluedPoint {
    triangle: usize,
    point: usize,
    node: [usize; 3],
    weights: [f64; 3],
    /// Stiffness over E [m].
    k: f64,
}

impl GluedPoint {
    fn moved(&self, u: &[Vector]) -> Vector {
        self.node.iter().zip(self.weights).map(|(&n, w)| u[n] * w).sum()
    }
}

/// A patch under a glued disc that has moved by a unit length.
pub struct Glued {
    /// Force along the disc's displacement over E, divided by the displacement [m].
    pub stiffness_m: f64,
    /// Displacement of each node, divided by that of the disc (1), shape \[nodes\].
    pub u: Vec<Vector>,
    /// Direction of the disc's displacement, a unit vector.
    direction: Vector,
    held: Vec<GluedPoint>,
}

impl Solver {
    /// Glues a disc of radius `radius_m` to the surface around `place_m` [m] and moves it along
    /// `direction`, a vector of any non-zero length.
    ///
    /// # Errors
    /// [`Unbalanced`] if there is no foundation point under the disc, or if the stiffness at rest
    /// is not positive definite.
    pub fn glued(&self, statics: &Statics, place_m: Vector, radius_m: f64, direction: Vector) -> Result<Glued, Unbalanced> {
        let failed = Unbalanced { depth_mm: 0.0, steps: 0 };
        let direction = direction.try_normalize(0.0).ok_or(failed)?;
        // with a threshold of zero, compensation would act on every spring that rounding has made
        // too short
        let at_rest = Statics { compensation_acts: false, ..statics.clone() };
        let held = at_rest.held(place_m, radius_m);
        if held.is_empty() {
            return Err(failed);
        }
        let blocks: Vec<_> = held.iter().map(|h| (h.node, h.weights, Matrix3::from_diagonal_element(h.k))).collect();
        let factor = at_rest.factor_with(&self.pattern, &at_rest.rest_m, None, &blocks, 0.0).map_err(|_| failed)?;
        let mut pull = vec![Vector::zeros(); at_rest.rest_m.len()];
        for h in &held {
            h.node.iter().zip(h.weights).for_each(|(&n, w)| pull[n] += direction * (h.k * w));
        }
        let u = factor.solve_nodes(&at_rest, &pull);
        let stiffness_m = held.iter().map(|h| h.k * (direction - h.moved(&u)).dot(&direction)).sum();
        Ok(Glued { stiffness_m, u, direction, held })
    }
}

impl Statics {
    /// Foundation points within `radius_m` of a place, on triangles that face the probe.
    fn held(&self, place_m: Vector, radius_m: f64) -> Vec<GluedPoint> {
        let mut held = Vec::new();
        for (triangle, t) in self.triangles.iter().enumerate() {
            let [a, b, c] = t.node.map(|n| self.rest_m[n]);
            if (b - a).cross(&(c - a)).dot(&self.axis()) <= 0.0 {
                continue;
            }
            for ((point, weights), &k) in point_weights(t.k.len()).iter().enumerate().zip(&t.k) {
                let weights = weights.map(f64::from);
                let at = a * weights[0] + b * weights[1] + c * weights[2];
                if (at - place_m).norm() <= radius_m {
                    held.push(GluedPoint { triangle, point, node: t.node, weights, k });
                }
            }
        }
        held
    }
}

impl Glued {
    /// Derivatives of [`Self::stiffness_m`] [m]. Those with respect to stiffening and compensation
    /// are zero at rest, and the rim springs are not treated as constants here.
    #[must_use]
    pub fn gradient(&self, statics: &Statics) -> Gradient {
        let (x, u) = (&statics.rest_m, &self.u);
        let spring = statics.springs.iter().map(|s| {
            let (edge, moved) = (x[s.node[1]] - x[s.node[0]], u[s.node[1]] - u[s.node[0]]);
            let length_m = edge.norm();
            let opens = moved.dot(&edge) / length_m;
            // at rest the length of a spring deviates from `rest_m` by the rounding of its
            // constants
            s.k * (opens * opens + (1.0 - s.rest_m / length_m) * (moved.norm_squared() - opens * opens))
        });
        let spring = spring.collect();
        let (mut node, mut bulk) = (vec![0.0; x.len()], vec![0.0; statics.tets.len()]);
        if statics.volume_acts {
            let (mut around, mut swell, mut turn) = (vec![0.0; x.len()], vec![0.0; x.len()], vec![0.0; x.len()]);
            for (t, bulk) in statics.tets.iter().zip(&mut bulk) {
                let shape = elastic::geometry(t, x);
                let grows: f64 = t.node.iter().zip(&shape.gradient).map(|(&n, g)| u[n].dot(g)).sum();
                let between = shape.between();
                let pairs = (0..4).flat_map(|i| (0..4).map(move |j| (i, j)));
                let again: f64 = pairs.map(|(i, j)| u[t.node[i]].dot(&(between[i][j] * u[t.node[j]]))).sum();
                for &n in &t.node {
                    around[n] += shape.six_volume;
                    swell[n] += grows;
                    turn[n] += again;
                }
                let (pressure, bend) = elastic::own_pressure(t, shape.six_volume, false);
                *bulk = bend * grows * grows + pressure * again;
            }
            let pressures = statics.node_pressures(&around);
            for (n, (pressure, bend)) in pressures.into_iter().enumerate() {
                node[n] = bend * swell[n] * swell[n] + pressure * turn[n];
            }
        }
        let mut point: Vec<Vec<f64>> = statics.triangles.iter().map(|t| vec![0.0; t.k.len()]).collect();
        for h in &self.held {
            point[h.triangle][h.point] = h.k * (self.direction - h.moved(u)).norm_squared();
        }
        Gradient { spring, node, point, bulk, stiffening: 0.0, compensation: 0.0, compensation_threshold: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use palpate::Params;

    use super::*;
    use palpate_tissue::mesh::{BlockSpec, block};
    use palpate_tissue::patch::{Material, Patch};
    use palpate_tissue::tissue::Tissue;

    const SIZE_M: [f64; 3] = [0.04, 0.04, 0.02];

    fn statics(params: &Params) -> Statics {
        let mesh = block(&BlockSpec { size_m: SIZE_M, nodes: 90, fine_at_m: [0.0; 2], fine_radius_m: 0.008 }).unwrap();
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] <= -SIZE_M[2]).map(|(n, _)| n).collect();
        let stiffness_ratio = vec![1.0; mesh.tets.len()];
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], 0.005);
        Statics::of(&Patch::build(&tissue, &Material::default(), None).model(), params).unwrap()
    }

    fn glued(statics: &Statics, direction: [f64; 3]) -> Glued {
        Solver::of(statics).unwrap().glued(statics, Vector::new(0.002, -0.001, 0.0), 0.007, direction.into()).unwrap()
    }

    const DIRECTIONS: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.5, -0.3, 0.7]];

    #[test]
    fn the_disc_bears_what_the_nonlinear_energy_says() {
        // half the difference of the gradients of the full energy at small displacements in both
        // directions: the rounding errors at rest and the second-order terms cancel
        let statics = statics(&Params::default());
        for direction in DIRECTIONS {
            let glued = glued(&statics, direction);
            let (far_m, far_away) = (1e-5, Vector::new(0.0, 0.0, 1.0));
            let slope = |way: f64| {
                let x: Vec<Vector> = statics.rest_m.iter().zip(&glued.u).map(|(x, u)| x + u * way).collect();
                statics.slope(&x, far_away).0
            };
            let mut left: Vec<Vector> = slope(far_m).iter().zip(slope(-far_m)).map(|(a, b)| (a - b) * 0.5).collect();
            let mut force = Vector::zeros();
            for h in &glued.held {
                let pull = (glued.direction - h.moved(&glued.u)) * (h.k * far_m);
                force += pull;
                h.node.iter().zip(h.weights).for_each(|(&n, w)| left[n] -= pull * w);
            }
            assert!((force.dot(&glued.direction) / far_m / glued.stiffness_m - 1.0).abs() < 1e-9);
            let free = left.iter().zip(&statics.free).filter(|(_, f)| f.is_some());
            let left = free.map(|(s, _)| s.norm_squared()).sum::<f64>().sqrt();
            assert!(left < 1e-4 * force.norm(), "{left:e} of {:e} left", force.norm());
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences() {
        // with a threshold of zero, compensation must have no effect
        let base = statics(&Params { compensation_threshold: 0.0, ..Params::default() });
        let step = 1e-3_f64;
        for direction in DIRECTIONS {
            let slopes = glued(&base, direction).gradient(&base);
            let largest = |v: &[f64]| (0..v.len()).max_by(|&a, &b| v[a].total_cmp(&v[b])).unwrap();
            let differs = |what: &str, expected: f64, change: &dyn Fn(&mut Statics, f64)| {
                let at = |factor: f64| {
                    let mut there = base.clone();
                    change(&mut there, factor);
                    glued(&there, direction).stiffness_m
                };
                let found = (at(step.exp()) - at((-step).exp())) / (2.0 * step);
                assert!((found - expected).abs() < 1e-5 * expected.abs() + 2e-12, "{what}: {expected:e}, differences {found:e}");
            };
            for n in [0, 7, 100, largest(&slopes.spring)] {
                differs("spring", slopes.spring[n], &|s, f| s.springs[n].k *= f);
            }
            for n in [3, 40, largest(&slopes.node)] {
                differs("node", slopes.node[n], &|s, f| s.pressure[n] *= f);
            }
            for n in [5, largest(&slopes.bulk)] {
                differs("bulk", slopes.bulk[n], &|s, f| s.tets[n].bulk *= f);
            }
            let of: Vec<f64> = slopes.point.iter().map(|p| p[3]).collect();
            for n in [0, largest(&of)] {
                differs("point", of[n], &|s, f| s.triangles[n].k[3] *= f);
            }
            differs("compensation", 0.0, &|s, f| s.compensation *= f);
            differs("stiffening", 0.0, &|s, f| s.stiffening_per_m *= f);
            // all stiffness constants together: the force is proportional to them
            let parts = [&slopes.spring, &slopes.node, &slopes.bulk].map(|v| v.iter().sum::<f64>());
            let whole = parts.iter().sum::<f64>() + slopes.point.iter().flatten().sum::<f64>();
            assert!((whole / glued(&base, direction).stiffness_m - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_disc_beside_the_tissue_is_refused() {
        let statics = statics(&Params::default());
        let solver = Solver::of(&statics).unwrap();
        assert!(solver.glued(&statics, Vector::new(0.1, 0.0, 0.0), 0.008, Vector::z()).is_err());
        assert!(solver.glued(&statics, Vector::zeros(), 0.008, Vector::zeros()).is_err());
    }
}
