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
/// Places of an element at which the edge of the contact is looked for.
const EDGES: u32 = 8;
/// Width of elements near the edge of the contact over that of the others under the ball (1), and
/// how far from the edge they are so narrow, divided by the contact radius (1).
const EDGE: f64 = 0.25;
const EDGE_WIDTH: f64 = 0.1;
/// Growth of the elements' size with the distance from the fine ones, divided by the fineness (1),
/// so that finer elements are finer everywhere.
const GROWTH: f64 = 3.2;
/// Radius up to which elements keep their size when the others are fitted to the cylinder, and
/// depth of the fine ones, divided by the contact radius (1).
const FINE: [f64; 2] = [1.15, 0.5];
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
    /// Size of the elements under the ball, divided by the contact radius (1).
    pub fineness: f64,
}

/// Quadratic shape functions in one dimension and their slopes, at `x` in [-1, 1].
fn shape(x: f64) -> [[f64; 2]; 3] {
    [[0.5 * x * (x - 1.0), x - 0.5], [1.0 - x * x, -2.0 * x], [0.5 * x * (x + 1.0), x + 0.5]]
}

/// Boundaries of elements from 0 to `length`, of about `size(place)` up to `near`; beyond it they
/// shrink together to end at `length`.
fn graded(length: f64, near: f64, size: impl Fn(f64) -> f64) -> Vec<f64> {
    let (mut at, mut end, mut kept) = (vec![0.0], 0.0, 0.0);
    while end < length {
        // the size at either end of an element counts
        let step = size(end);
        end += step.min(size(end + step));
        at.push(end);
        if end <= near.min(0.9 * length) {
            kept = end;
        }
    }
    at.iter().map(|x| if *x <= kept { *x } else { kept + (x - kept) * (length - kept) / (end - kept) }).collect()
}

/// Sum of energy, its slope, and a band of its second derivative.
struct Sum {
    energy: f64,
    slope: Vec<f64>,
    band: Vec<f64>,
}

/// Nodes of the elements for one contact radius.
struct Mesh<'a> {
    of: &'a Cylinder,
    /// Positions of the columns and rows of nodes [m].
    r_m: Vec<f64>,
    z_m: Vec<f64>,
    width: usize,
}

/// Displacements of a mesh [m] in equilibrium at a depth [m].
struct Pressed<'a> {
    mesh: Mesh<'a>,
    u: Vec<f64>,
    depth_m: f64,
    contact_m: f64,
}

impl Cylinder {
    /// Forces over Young's modulus [m^2] at ascending depths [m]; fewer if no equilibrium is found.
    ///
    /// The elements shrink with the contact, and are narrow at its edge, so that their error is
    /// about the same part of every force. With the same elements for all depths it was 3 % of the
    /// smallest force, and swung by 0.3 % as the edge crossed elements.
    #[must_use]
    pub fn forces_m2(&self, depths_m: &[f64]) -> Vec<f64> {
        let mut forces = Vec::new();
        let mut last: Option<Pressed> = None;
        for depth_m in depths_m {
            // the contact and all around it grow about as Hertz's do
            let contact_m = match &last {
                Some(last) => last.contact_m * (depth_m / last.depth_m).sqrt(),
                None => (self.ball_m * depth_m).sqrt(),
            };
            let mesh = Mesh::new(self, contact_m.min(self.radius_m));
            let start = |depth_m: f64, contact_m: f64| match &last {
                Some(last) => mesh.grown_from(last, depth_m, contact_m),
                None => vec![0.0; mesh.unknowns()],
            };
            let mut u = start(*depth_m, contact_m);
            let found = mesh.settle(&mut u, *depth_m).or_else(|| {
                let (from_m, contact_m) = last.as_ref().map_or((0.0, 0.0), |last| (last.depth_m, last.contact_m));
                u = start(from_m, contact_m);
                mesh.press(&mut u, from_m, *depth_m, MOST_HALVINGS)
            });
            let Some(force) = found else { break };
            forces.push(force);
            let contact_m = mesh.contact_radius_m(&u, *depth_m);
            last = Some(Pressed { mesh, u, depth_m: *depth_m, contact_m });
        }
        forces
    }
}

impl<'a> Mesh<'a> {
    fn new(of: &'a Cylinder, contact_m: f64) -> Self {
        let fine_m = of.fineness * contact_m;
        // a slab may be thinner than the contact is wide
        let tall_m = contact_m.min(of.height_m);
        let (near_m, below_m) = (FINE[0] * contact_m, FINE[1] * tall_m);
        let grown_m = |beyond_m: f64| GROWTH * of.fineness * beyond_m.max(0.0);
        // the pressure ends like a square root, which shape functions miss
        let width_m = |r: f64| EDGE * fine_m + grown_m((r - contact_m).abs() - EDGE_WIDTH * contact_m);
        let width_m = |r: f64| width_m(r).min(if r < contact_m { fine_m } else { f64::MAX });
        let halved = |at: Vec<f64>| {
            let mut nodes = vec![0.0];
            at.windows(2).for_each(|pair| nodes.extend([pair[0].midpoint(pair[1]), pair[1]]));
            nodes
        };
        let r_m = halved(graded(of.radius_m, near_m, width_m));
        let z_m = halved(graded(of.height_m, below_m, |z| of.fineness * tall_m + grown_m(z - below_m)));
        Self { of, width: 2 * (2 * z_m.len() + 3), r_m, z_m }
    }

    fn unknowns(&self) -> usize {
        2 * self.r_m.len() * self.z_m.len()
    }

    /// Displacements at another depth [m] with another contact radius [m], if all lengths grow with
    /// this radius.
    fn grown_from(&self, last: &Pressed, depth_m: f64, contact_m: f64) -> Vec<f64> {
        let (other, growth, deeper) = (&last.mesh, contact_m / last.contact_m, depth_m / last.depth_m);
        // first node of the element around a place, and the shape functions there
        let around = |at: &[f64], x: f64| {
            let first = ((at.partition_point(|node| *node < x).max(1) - 1) / 2 * 2).min(at.len() - 3);
            let half = 0.5 * (at[first + 2] - at[first]);
            (first, shape((x - at[first + 1]) / half).map(|s| s[0]))
        };
        let rows: Vec<(usize, [f64; 3])> = self.z_m.iter().map(|z| around(&other.z_m, z / growth)).collect();
        let mut grown = Vec::with_capacity(self.unknowns());
        for (column, p) in self.r_m.iter().map(|r| around(&other.r_m, r / growth)) {
            for (row, q) in &rows {
                grown.extend([0, 1].map(|k| {
                    let of = |n: usize| p[n / 3] * q[n % 3] * last.u[2 * other.node(column + n / 3, row + n % 3) + k];
                    if self.is_fixed(grown.len() + k) { 0.0 } else { deeper * (0..9).map(of).sum::<f64>() }
                }));
            }
        }
        grown
    }

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

    /// Radius of the contact on the free surface [m].
    fn contact_radius_m(&self, u: &[f64], depth_m: f64) -> f64 {
        let (mut last, mut edge_m) = ((0.0, -1.0), 0.0);
        for column in (0..self.r_m.len() - 2).step_by(2) {
            for part in 1..=EDGES {
                let x = 2.0 * f64::from(part) / f64::from(EDGES) - 1.0;
                let at = |of: &dyn Fn(usize) -> f64| shape(x).iter().enumerate().map(|(n, s)| s[0] * of(n)).sum::<f64>();
                let rest_m = at(&|n| self.r_m[column + n]);
                let [r, z] = [0, 1].map(|k| at(&|n| u[2 * self.node(column + n, 0) + k]));
                let up_m = z + depth_m - self.of.ball_m;
                let gap_m = if up_m > 0.0 { 0.0 } else { (rest_m + r).hypot(up_m) - self.of.ball_m };
                // within the contact some places may be just above the ball
                if last.1 < 0.0 && gap_m >= 0.0 {
                    edge_m = last.0 + (rest_m - last.0) * last.1 / (last.1 - gap_m);
                }
                last = (rest_m, gap_m);
            }
        }
        if last.1 < 0.0 { last.0 } else { edge_m }
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
