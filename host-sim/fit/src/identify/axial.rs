//! Finite elements of a cylinder that a ball presses on its axis: the reference's law of tissue and
//! contact ([`crate::reference::body`], [`crate::reference::touch`]) in two dimensions, which takes
//! a hundredth of its time. Nine-node rectangles, finest under the ball; all forces are divided by
//! Young's modulus.

use std::f64::consts::TAU;

/// Penetration at a contact pressure equal to Young's modulus, as a share of sqrt(radius x depth).
const SOFTNESS: f64 = 3e-4;
/// Residual over force at which a press has converged (1), and most iterations.
const TOLERANCE: f64 = 1e-5;
const MOST_ITERATIONS: usize = 60;
/// Number of times that the way to a depth is halved, where no equilibrium is found at once.
const MOST_HALVINGS: u32 = 4;
/// Gauss points and weights on [-1, 1], exact to degree 5.
const GAUSS: [(f64, f64); 3] = [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// A cylinder with a fixed bottom under a ball on its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Radius of the ball [m].
    pub ball_m: f64,
    /// Radius and height of the cylinder [m].
    pub radius_m: f64,
    /// Height of the cylinder [m].
    pub height_m: f64,
    /// Poisson's ratio (1), below 0.5.
    pub poisson_ratio: f64,
    /// Stiffening exponent (1).
    pub stiffening_b: f64,
    /// Size of the elements under the ball, divided by the largest contact radius (1).
    pub fineness: f64,
}

/// Quadratic shape functions in one dimension and their slopes, at `x` in [-1, 1].
fn shape(x: f64) -> [[f64; 2]; 3] {
    [[0.5 * x * (x - 1.0), x - 0.5], [1.0 - x * x, -2.0 * x], [0.5 * x * (x + 1.0), x + 0.5]]
}

/// Element boundaries from 0 to `length`, of size `first` up to `even`, then growing by `growth`.
fn graded(length: f64, first: f64, even: f64, growth: f64) -> Vec<f64> {
    let (mut at, mut size) = (vec![0.0], first);
    let mut end = 0.0;
    while end < length {
        end += size;
        at.push(end);
        if end > even {
            size *= growth;
        }
    }
    at.iter().map(|x| x * length / end).collect()
}

/// Sum of energy, its slope, and a band of its second derivative.
struct Sum {
    energy: f64,
    slope: Vec<f64>,
    band: Vec<f64>,
}

struct Mesh<'a> {
    of: &'a Cylinder,
    /// Positions of the columns and rows of nodes [m].
    r_m: Vec<f64>,
    z_m: Vec<f64>,
    width: usize,
}

impl Cylinder {
    /// Forces over Young's modulus [m^2] at ascending depths [m]; fewer if no equilibrium is found.
    #[must_use]
    pub fn forces_m2(&self, depths_m: &[f64]) -> Vec<f64> {
        let deepest_m = depths_m.iter().copied().fold(0.0, f64::max);
        let contact_m = (self.ball_m * deepest_m).sqrt().min(self.radius_m);
        let fine_m = self.fineness * contact_m;
        let halved = |at: Vec<f64>| {
            let mut nodes = vec![0.0];
            at.windows(2).for_each(|pair| nodes.extend([pair[0].midpoint(pair[1]), pair[1]]));
            nodes
        };
        let r_m = halved(graded(self.radius_m, fine_m, 1.15 * contact_m, 1.45));
        let z_m = halved(graded(self.height_m, fine_m, 0.5 * contact_m, 1.45));
        let mesh = Mesh { of: self, width: 2 * (2 * z_m.len() + 3), r_m, z_m };
        let mut u = vec![0.0; 2 * mesh.r_m.len() * mesh.z_m.len()];
        let mut before = (u.clone(), 0.0);
        let mut forces = Vec::new();
        for depth_m in depths_m {
            let last_m = forces.len().checked_sub(1).map_or(0.0, |n| depths_m[n]);
            let step = last_m - before.1;
            let share = if step > 0.0 { (depth_m - last_m) / step } else { 0.0 };
            let ahead: Vec<f64> = u.iter().zip(&before.0).map(|(u, b)| u + share * (u - b)).collect();
            let from = (u, last_m);
            u = ahead;
            let found = mesh.settle(&mut u, *depth_m).or_else(|| {
                u.clone_from(&from.0);
                mesh.press(&mut u, last_m, *depth_m, MOST_HALVINGS)
            });
            let Some(force) = found else { break };
            forces.push(force);
            before = from;
        }
        forces
    }
}

impl Mesh<'_> {
    fn node(&self, column: usize, row: usize) -> usize {
        column * self.z_m.len() + row
    }

    fn is_fixed(&self, unknown: usize) -> bool {
        let (node, vertical) = (unknown / 2, unknown % 2 == 1);
        (node + 1).is_multiple_of(self.z_m.len()) || (node < self.z_m.len() && !vertical)
    }

    /// Force over E at a depth [m^2] from the equilibrium at another; where none is found at once,
    /// the one half way there is found first.
    fn press(&self, u: &mut Vec<f64>, from_m: f64, depth_m: f64, halvings: u32) -> Option<f64> {
        let kept = u.clone();
        if let found @ Some(_) = self.settle(u, depth_m) {
            return found;
        }
        let halvings = halvings.checked_sub(1)?;
        u.clone_from(&kept);
        let middle_m = from_m.midpoint(depth_m);
        self.press(u, from_m, middle_m, halvings)?;
        self.press(u, middle_m, depth_m, halvings)
    }

    /// Newton's method with a line search; the force over E [m^2].
    fn settle(&self, u: &mut Vec<f64>, depth_m: f64) -> Option<f64> {
        for _ in 0..MOST_ITERATIONS {
            let mut sum = self.sum(u, depth_m, true)?;
            let force = self.contact(u, depth_m, None).1;
            let residual = sum.slope.iter().map(|s| s * s).sum::<f64>().sqrt();
            if force > 0.0 && residual < TOLERANCE * force {
                return Some(force);
            }
            let mut step: Vec<f64> = sum.slope.iter().map(|s| -s).collect();
            let diagonal: Vec<f64> = (0..step.len()).map(|i| sum.band[i * self.width + self.width - 1]).collect();
            let plain = sum.band.clone();
            let factored = [0.0, 1e-3, 1e-1, 1.0].into_iter().any(|share| {
                sum.band.copy_from_slice(&plain);
                diagonal.iter().enumerate().for_each(|(i, d)| sum.band[i * self.width + self.width - 1] += share * d.abs());
                factorise(&mut sum.band, self.width)
            });
            if !factored {
                return None;
            }
            solve(&sum.band, self.width, &mut step);
            let slope: f64 = sum.slope.iter().zip(&step).map(|(s, d)| s * d).sum();
            let rounding = 1e-13 * sum.energy.abs();
            let (mut share, mut found) = (1.0, false);
            while share > 1e-4 {
                let there: Vec<f64> = u.iter().zip(&step).map(|(u, d)| u + share * d).collect();
                if let Some(there_sum) = self.sum(&there, depth_m, false)
                    && there_sum.energy <= sum.energy + 1e-4 * share * slope + rounding
                {
                    *u = there;
                    found = true;
                    break;
                }
                share *= 0.5;
            }
            if !found {
                return (force > 0.0 && residual < 1e-4 * force).then_some(force);
            }
        }
        None
    }

    /// Energy, slope and, if asked, tangent; `None` if an element is inverted.
    fn sum(&self, u: &[f64], depth_m: f64, tangent: bool) -> Option<Sum> {
        let nu = self.of.poisson_ratio;
        let (mu, lambda, b) = (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), self.of.stiffening_b);
        let count = u.len();
        let mut sum = Sum { energy: 0.0, slope: vec![0.0; count], band: vec![0.0; if tangent { count * self.width } else { 0 }] };
        for column in (0..self.r_m.len() - 2).step_by(2) {
            for row in (0..self.z_m.len() - 2).step_by(2) {
                let (half_r, half_z) =
                    (0.5 * (self.r_m[column + 2] - self.r_m[column]), 0.5 * (self.z_m[row + 2] - self.z_m[row]));
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
                        // F_rr, F_rz, F_zr, F_zz, F_tt, less one where small strains would lose
                        // their digits
                        let mut h = [0.0; 5];
                        for (n, by) in nodes.iter().zip(&by) {
                            let (v, w) = (u[2 * n], u[2 * n + 1]);
                            h[0] += by[0] * v;
                            h[1] += by[1] * v;
                            h[2] += by[0] * w;
                            h[3] += by[1] * w;
                            h[4] += by[2] * v;
                        }
                        let f = [1.0 + h[0], h[1], h[2], 1.0 + h[3], 1.0 + h[4]];
                        let grown = h[0] + h[3] + h[0] * h[3] - h[1] * h[2];
                        let flat = 1.0 + grown;
                        if flat <= 0.0 || f[4] <= 0.0 {
                            return None;
                        }
                        let ln_j = (grown + h[4] + grown * h[4]).ln_1p();
                        let distortion = 2.0 * (h[0] + h[3] + h[4] - ln_j) + h.iter().map(|h| h * h).sum::<f64>();
                        let stiff = mu * (b * distortion).exp();
                        let volume = TAU * r * half_r * half_z * wx * wy;
                        let shear = if b > 0.0 { 0.5 * mu / b * (b * distortion).exp_m1() } else { 0.5 * mu * distortion };
                        sum.energy += volume * (shear + 0.5 * lambda * ln_j * ln_j);
                        let g = [f[3] / flat, -f[2] / flat, -f[1] / flat, f[0] / flat, 1.0 / f[4]];
                        let s: [f64; 5] = std::array::from_fn(|k| f[k] - g[k]);
                        let p: [f64; 5] = std::array::from_fn(|k| stiff * s[k] + lambda * ln_j * g[k]);
                        for (n, by) in nodes.iter().zip(&by) {
                            sum.slope[2 * n] += volume * (p[0] * by[0] + p[1] * by[1] + p[4] * by[2]);
                            sum.slope[2 * n + 1] += volume * (p[2] * by[0] + p[3] * by[1]);
                        }
                        if !tangent {
                            continue;
                        }
                        let back = stiff - lambda * ln_j;
                        let law: [[f64; 5]; 5] = std::array::from_fn(|c| {
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
                        let of: [[f64; 5]; 18] = std::array::from_fn(|n| {
                            let by = by[n / 2];
                            if n % 2 == 0 { [by[0], by[1], 0.0, 0.0, by[2]] } else { [0.0, 0.0, by[0], by[1], 0.0] }
                        });
                        for (m, row) in of.iter().enumerate() {
                            let lawed: [f64; 5] =
                                std::array::from_fn(|d| (0..5).map(|c| row[c] * law[c][d]).sum::<f64>() * volume);
                            for (n, other) in of.iter().enumerate().take(m + 1) {
                                local[m][n] += (0..5).map(|d| lawed[d] * other[d]).sum::<f64>();
                            }
                        }
                    }
                }
                if tangent {
                    for (m, row) in local.iter().enumerate() {
                        for (n, value) in row.iter().enumerate().take(m + 1) {
                            self.add(&mut sum, 2 * nodes[m / 2] + m % 2, 2 * nodes[n / 2] + n % 2, *value);
                        }
                    }
                }
            }
        }
        sum.energy += self.contact(u, depth_m, Some((&mut sum.slope, &mut sum.band))).0;
        for unknown in (0..count).filter(|unknown| self.is_fixed(*unknown)) {
            sum.slope[unknown] = 0.0;
            if tangent {
                for other in unknown.saturating_sub(self.width - 1)..(unknown + self.width).min(count) {
                    let (i, j) = (unknown.max(other), unknown.min(other));
                    sum.band[i * self.width + self.width - 1 + j - i] = f64::from(u8::from(i == j));
                }
            }
        }
        sum.energy.is_finite().then_some(sum)
    }

    fn add(&self, sum: &mut Sum, i: usize, j: usize, value: f64) {
        let (i, j) = (i.max(j), i.min(j));
        sum.band[i * self.width + self.width - 1 + j - i] += value;
    }

    /// Energy of the contact and force on the ball, both over E; adds slope and tangent.
    fn contact(&self, u: &[f64], depth_m: f64, mut into: Option<(&mut Vec<f64>, &mut Vec<f64>)>) -> (f64, f64) {
        let (ball_m, width) = (self.of.ball_m, self.width);
        let penalty = 1.0 / (SOFTNESS * (ball_m * depth_m).sqrt());
        let (mut energy, mut force) = (0.0, 0.0);
        for column in (0..self.r_m.len() - 2).step_by(2) {
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
                    energy += 0.5 * penalty * gap * gap * area;
                    force += penalty * gap * normal[1] * area;
                    let Some((slope, band)) = &mut into else { continue };
                    for m in 0..6 {
                        let i = 2 * nodes[m / 2] + m % 2;
                        slope[i] += penalty * gap * normal[m % 2] * s[m / 2] * area;
                        for n in (0..=m).take(if band.is_empty() { 0 } else { 6 }) {
                            let j = 2 * nodes[n / 2] + n % 2;
                            let same = if m % 2 == n % 2 { 1.0 } else { 0.0 };
                            let both = normal[m % 2] * normal[n % 2];
                            let hess = both + gap / length * (same - both);
                            band[i.max(j) * width + width - 1 + i.min(j) - i.max(j)] +=
                                penalty * hess * s[m / 2] * s[n / 2] * area;
                        }
                    }
                }
            }
        }
        (energy, force)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in ca.zip(cb) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    rest + sums.iter().sum::<f64>()
}

/// Cholesky factor of a band, in place, row by row with the diagonal last; false if it has none.
fn factorise(band: &mut [f64], width: usize) -> bool {
    for i in 0..band.len() / width {
        let (above, row) = band.split_at_mut(i * width);
        for j in i.saturating_sub(width - 1)..i {
            let other = &above[j * width..][..width];
            // entries of row i from the first column that both rows have
            let (from, to) = ((i - j).min(width - 1), j + width - 1 - i);
            let sum = row[to] - dot(&row[..to], &other[from..from + to]);
            row[to] = sum / other[width - 1];
        }
        let square = row[width - 1] - dot(&row[..width - 1], &row[..width - 1]);
        if square <= 0.0 {
            return false;
        }
        row[width - 1] = square.sqrt();
    }
    true
}

fn solve(band: &[f64], width: usize, x: &mut [f64]) {
    let count = x.len();
    for i in 0..count {
        let from = i.saturating_sub(width - 1);
        let row = &band[i * width..][..width];
        x[i] = (x[i] - dot(&row[width - 1 + from - i..width - 1], &x[from..i])) / row[width - 1];
    }
    for i in (0..count).rev() {
        let row = &band[i * width..][..width];
        x[i] /= row[width - 1];
        let value = x[i];
        for j in i.saturating_sub(width - 1)..i {
            x[j] -= row[width - 1 + j - i] * value;
        }
    }
}
