//! Energy of the elements and of their contact with the ball, with two derivatives.

use std::f64::consts::TAU;

use super::mesh::Mesh;
use super::shape;

/// Gauss points and weights on [-1, 1], exact to degree 5.
const GAUSS: [(f64, f64); 3] = [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Energy over Young's modulus [m^3], its slope, and the lower triangle of its second derivative.
pub(super) struct Sum {
    pub energy: f64,
    pub slope: Vec<f64>,
    pub tangent: Vec<f64>,
    /// Force on the ball over Young's modulus [m^2].
    pub force: f64,
}

/// Energy of a volume, its stress and its stiffness for the components rr, rz, zr, zz and tt of the
/// displacement's gradient, over Young's modulus.
struct Law {
    energy: f64,
    stress: [f64; 5],
    stiffness: [[f64; 5]; 5],
}

impl Mesh<'_> {
    /// Law of the tissue at a gradient `h` of the displacement, which is F less one: small strains
    /// would lose their digits in F. `None` if the tissue is inverted.
    fn law(&self, h: [f64; 5]) -> Option<Law> {
        let (nu, b) = (self.of.poisson_ratio, self.of.stiffening_b);
        let (mu, lambda) = (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
        let f = [1.0 + h[0], h[1], h[2], 1.0 + h[3], 1.0 + h[4]];
        let grown = h[0] + h[3] + h[0] * h[3] - h[1] * h[2];
        let flat = 1.0 + grown;
        if flat <= 0.0 || f[4] <= 0.0 {
            return None;
        }
        let ln_j = (grown + h[4] + grown * h[4]).ln_1p();
        let distortion = 2.0 * (h[0] + h[3] + h[4] - ln_j) + h.iter().map(|h| h * h).sum::<f64>();
        let grown = (b * distortion).exp_m1();
        let stiff = mu * (1.0 + grown);
        let shear = if b > 0.0 { 0.5 * mu / b * grown } else { 0.5 * mu * distortion };
        let g = [f[3] / flat, -f[2] / flat, -f[1] / flat, f[0] / flat, 1.0 / f[4]];
        let s: [f64; 5] = std::array::from_fn(|k| f[k] - g[k]);
        let back = stiff - lambda * ln_j;
        let stiffness = std::array::from_fn(|c| {
            std::array::from_fn(|d| {
                let twisted = match (c, d) {
                    (4, 4) => g[4] * g[4],
                    (4, _) | (_, 4) => 0.0,
                    // G_ji G_lk for the components (j, k) and (l, i)
                    _ => g[2 * (c / 2) + d % 2] * g[2 * (d / 2) + c % 2],
                };
                let same = if c == d { stiff } else { 0.0 };
                same + back * twisted + lambda * g[c] * g[d] + 2.0 * b * stiff * s[c] * s[d]
            })
        });
        let stress = std::array::from_fn(|k| stiff * s[k] + lambda * ln_j * g[k]);
        Some(Law { energy: shear + 0.5 * lambda * ln_j * ln_j, stress, stiffness })
    }

    /// Energy with its derivatives at displacements [m] under a ball at a depth [m], whose
    /// penetration is `softness` times sqrt(radius x depth) at a pressure equal to Young's modulus;
    /// `None` if an element is inverted.
    pub fn sum(&self, u: &[f64], depth_m: f64, softness: f64) -> Option<Sum> {
        let mut sum = Sum { energy: 0.0, slope: vec![0.0; u.len()], tangent: vec![0.0; self.entries()], force: 0.0 };
        for column in (0..self.r_m.len() - 2).step_by(2) {
            for row in (0..self.z_m.len() - 2).step_by(2) {
                self.add_element(u, [column, row], &mut sum)?;
            }
            self.add_contact(u, depth_m, softness, column, &mut sum);
        }
        for unknown in (0..u.len()).filter(|unknown| self.fixed[*unknown]) {
            sum.slope[unknown] = 0.0;
            sum.tangent[self.entry(unknown, unknown)] = 1.0;
        }
        sum.energy.is_finite().then_some(sum)
    }

    fn add_element(&self, u: &[f64], [column, row]: [usize; 2], sum: &mut Sum) -> Option<()> {
        let half = |at: &[f64], n: usize| 0.5 * (at[n + 2] - at[n]);
        let (half_r, half_z) = (half(&self.r_m, column), half(&self.z_m, row));
        let nodes: [usize; 9] = std::array::from_fn(|n| self.node(column + n / 3, row + n % 3));
        let mut local = [[0.0; 18]; 18];
        for (x, wx) in GAUSS {
            for (y, wy) in GAUSS {
                let (sx, sy) = (shape(x), shape(y));
                let r = self.r_m[column + 1] + half_r * x;
                // the rows go down
                let by: [[f64; 3]; 9] = std::array::from_fn(|n| {
                    let (p, q) = (sx[n / 3], sy[n % 3]);
                    [p[1] * q[0] / half_r, -p[0] * q[1] / half_z, p[0] * q[0] / r]
                });
                let mut h = [0.0; 5];
                for (n, by) in nodes.iter().zip(&by) {
                    let (v, w) = (u[2 * n], u[2 * n + 1]);
                    h[0] += by[0] * v;
                    h[1] += by[1] * v;
                    h[2] += by[0] * w;
                    h[3] += by[1] * w;
                    h[4] += by[2] * v;
                }
                let Law { energy, stress: p, stiffness } = self.law(h)?;
                let volume = TAU * r * half_r * half_z * wx * wy;
                sum.energy += volume * energy;
                for (m, (node, of)) in nodes.iter().zip(&by).enumerate() {
                    sum.slope[2 * node] += volume * (p[0] * of[0] + p[1] * of[1] + p[4] * of[2]);
                    sum.slope[2 * node + 1] += volume * (p[2] * of[0] + p[3] * of[1]);
                    // the components that the node's two displacements change
                    let of = of.map(|of| volume * of);
                    let pull: [f64; 5] =
                        std::array::from_fn(|d| of[0] * stiffness[0][d] + of[1] * stiffness[1][d] + of[2] * stiffness[4][d]);
                    let lift: [f64; 5] = std::array::from_fn(|d| of[0] * stiffness[2][d] + of[1] * stiffness[3][d]);
                    for (n, by) in by.iter().enumerate().take(m + 1) {
                        for (k, s) in [pull, lift].iter().enumerate() {
                            local[2 * m + k][2 * n] += s[0] * by[0] + s[1] * by[1] + s[4] * by[2];
                            local[2 * m + k][2 * n + 1] += s[2] * by[0] + s[3] * by[1];
                        }
                    }
                }
            }
        }
        for m in 0..18 {
            for n in 0..=m {
                self.add(sum, 2 * nodes[m / 2] + m % 2, 2 * nodes[n / 2] + n % 2, local[m][n]);
            }
        }
        Some(())
    }

    /// Adds to the tangent for two unknowns that are not fixed, the later one first.
    fn add(&self, sum: &mut Sum, i: usize, j: usize, value: f64) {
        if !self.fixed[i] && !self.fixed[j] {
            sum.tangent[self.entry(i, j)] += value;
        }
    }

    /// Adds the contact of one element of the free surface.
    fn add_contact(&self, u: &[f64], depth_m: f64, softness: f64, column: usize, sum: &mut Sum) {
        let ball_m = self.of.ball_m;
        let penalty = 1.0 / (softness * (ball_m * depth_m).sqrt());
        let half_r = 0.5 * (self.r_m[column + 2] - self.r_m[column]);
        let nodes: [usize; 3] = std::array::from_fn(|n| self.node(column + n, 0));
        // the edge of the contact crosses an element: many points smooth what it adds
        for part in 0..4 {
            for (x, w) in GAUSS {
                let x = (x + 2.0 * f64::from(part) - 3.0) / 4.0;
                let s = shape(x).map(|s| s[0]);
                let rest_m = self.r_m[column + 1] + half_r * x;
                let area = TAU * rest_m * half_r * w / 4.0;
                let at = |k: usize| (0..3).map(|n| s[n] * u[2 * nodes[n] + k]).sum::<f64>();
                let (r, z) = (rest_m + at(0), at(1) + depth_m - ball_m);
                let length = r.hypot(z);
                let gap = length - ball_m;
                if gap >= 0.0 || z > 0.0 {
                    continue;
                }
                let normal = [r / length, z / length];
                sum.energy += 0.5 * penalty * gap * gap * area;
                sum.force += penalty * gap * normal[1] * area;
                for m in 0..6 {
                    let i = 2 * nodes[m / 2] + m % 2;
                    sum.slope[i] += penalty * gap * normal[m % 2] * s[m / 2] * area;
                    for n in 0..=m {
                        let same = if m % 2 == n % 2 { 1.0 } else { 0.0 };
                        let both = normal[m % 2] * normal[n % 2];
                        let hess = both + gap / length * (same - both);
                        self.add(sum, i, 2 * nodes[n / 2] + n % 2, penalty * hess * s[m / 2] * s[n / 2] * area);
                    }
                }
            }
        }
    }
}
