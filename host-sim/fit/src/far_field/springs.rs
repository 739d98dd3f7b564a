//! Rim springs: a symmetric 3 x 3 block per rim node and a 3 x 3 block per rim edge, fitted to the
//! condensed outside.
//!
//! They form a symmetric matrix M that has only these blocks and responds to loads on the surface
//! as the stiffness S of the condensed outside does. M minimises `|M U - S U|^2 + rho |M - S|^2`,
//! where U are the rim displacements under unit forces on the surface with the exact outside
//! attached. Blocks taken directly from S would be 1-10 % too stiff; fitted blocks are accurate to
//! half a percent. M is kept positive definite, so that the rim can never create energy: if the fit
//! has a negative eigenvalue (which occurs at jagged rims), its eigenvector is added to the loads,
//! with increasing weight, until none is left.

use faer::{Mat, Side};

pub use palpate_tissue::patch::RimSprings;

use super::cut::Cut;
use crate::statics::{Solver, Statics, Unbalanced, Vector};

/// Weight rho that keeps M near S, as a share of the mean diagonal of the normal equations. All
/// values from 1e-5 to 1e-2 give the same forces.
const RIDGE: f64 = 1e-3;
/// Smallest allowed eigenvalue, as a share of the mean diagonal of S (1).
const LEAST: f64 = 1e-3;
/// Maximum number of rounds in which eigenvectors are added, weight in the first round relative to
/// the ridge, and factor on the weight per round. Larger weights from the start would impair the
/// responses to the loads.
const MOST_ROUNDS: usize = 24;
const FIRST_WEIGHT: f64 = 10.0;
const HEAVIER: f64 = 1.6;
/// Residual at which conjugate gradients end, as a share of the right-hand side (1).
const TOLERANCE: f64 = 1e-7;
const MOST_STEPS: usize = 3000;

/// Displacements of the rim under unit forces over E on the surface near the site [1/m], shape [3
/// rim nodes][loads], for the patch with its far field `outside` (shape [3 rim nodes][3 rim nodes])
/// attached.
///
/// # Errors
/// Fails if the stiffness of the patch with its far field is not positive definite at rest.
pub fn rim_answers(statics: &Statics, cut: &Cut, outside: &Mat<f64>, reach_m: f64) -> Result<Mat<f64>, Unbalanced> {
    let refused = Unbalanced { depth_mm: 0.0, steps: 0 };
    let node: Vec<usize> = cut.rim.iter().map(|n| *n as usize).collect();
    let statics = statics.with_rim(&node, outside);
    let solver = Solver::of(&statics).ok_or(refused)?;
    let site_m = Vector::from(cut.patch.site_m);
    let rest = solver.rest(&statics, site_m, 1.0)?;
    let mut loaded: Vec<u32> = cut.patch.skin.iter().flatten().copied().collect();
    loaded.sort_unstable();
    loaded.dedup();
    loaded.retain(|n| {
        let from_site = statics.rest_m[*n as usize] - site_m;
        from_site.norm() <= reach_m && cut.rim.binary_search(n).is_err()
    });
    let mut answers = Mat::zeros(3 * node.len(), 3 * loaded.len());
    for (l, n) in loaded.iter().enumerate() {
        for c in 0..3 {
            let mut force = vec![Vector::zeros(); statics.rest_m.len()];
            force[*n as usize][c] = 1.0;
            let moved = rest.answer(&statics, &force);
            for (k, n) in node.iter().enumerate() {
                (0..3).for_each(|a| answers[(3 * k + a, 3 * l + c)] = moved[*n][a]);
            }
        }
    }
    Ok(answers)
}

/// Fits rim springs to the condensed outside `s` [m], shape [3 rim nodes][3 rim nodes], for the rim
/// displacements `answers`.
#[must_use]
pub fn fit(cut: &Cut, s: &Mat<f64>, answers: &Mat<f64>) -> RimSprings {
    let rim = cut.rim.len();
    let pattern = Pattern::of(cut);
    // responses are weighted by their magnitude and scaled so that the mean diagonal is one
    let mut shapes = answers * answers.transpose();
    let scale = (0..3 * rim).map(|i| shapes[(i, i)]).sum::<f64>() / (3 * rim) as f64;
    shapes = &shapes * faer::Scale(1.0 / scale);
    let least = LEAST * (0..3 * rim).map(|i| s[(i, i)]).sum::<f64>() / (3 * rim) as f64;
    let (mut weight, mut mended) = (FIRST_WEIGHT * RIDGE, 0);
    let mut fitted = pattern.fit(s, &shapes, None);
    for _ in 0..MOST_ROUNDS {
        let negative = eigen(&pattern.dense(&fitted), least);
        if negative.is_empty() {
            break;
        }
        mended += negative.len();
        for (_, v) in &negative {
            shapes += v * v.transpose() * faer::Scale(weight);
        }
        weight *= HEAVIER;
        fitted = pattern.fit(s, &shapes, Some(fitted));
    }
    let lowest = eigen(&pattern.dense(&fitted), least).into_iter().map(|(value, _)| value).fold(least, f64::min);
    if lowest < least {
        // this last resort always succeeds: the missing amount is added to the diagonal at every
        // node
        for (place, block) in pattern.place.iter().zip(&mut fitted) {
            if place[0] == place[1] {
                (0..3).for_each(|k| block[k][k] += least - lowest);
            }
        }
    }
    let blocks = pattern.place.iter().copied().zip(fitted).collect();
    RimSprings { node: cut.rim.clone(), blocks, mended }
}

/// Rim springs as a full matrix [m], shape [3 rim nodes][3 rim nodes].
#[must_use]
pub fn dense(springs: &RimSprings) -> Mat<f64> {
    let mut full = Mat::zeros(3 * springs.node.len(), 3 * springs.node.len());
    springs.blocks.iter().for_each(|(place, block)| put(&mut full, *place, block));
    full
}

/// Smallest eigenvalue of the rim springs [m].
#[must_use]
pub fn lowest_m(springs: &RimSprings) -> f64 {
    // a matrix whose decomposition fails counts as not positive definite
    let values = dense(springs).self_adjoint_eigenvalues(Side::Lower);
    values.map_or(f64::NEG_INFINITY, |values| values.into_iter().fold(f64::INFINITY, f64::min))
}

type Block = [[f64; 3]; 3];

fn put(full: &mut Mat<f64>, [i, j]: [usize; 2], block: &Block) {
    for a in 0..3 {
        for b in 0..3 {
            full[(3 * i + a, 3 * j + b)] = block[a][b];
            full[(3 * j + b, 3 * i + a)] = block[a][b];
        }
    }
}

/// Eigenvalues below `least`, with their eigenvectors.
fn eigen(matrix: &Mat<f64>, least: f64) -> Vec<(f64, Mat<f64>)> {
    let Ok(all) = matrix.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
    let values = all.S().column_vector();
    let low = (0..matrix.nrows()).filter(|n| values[*n] < least);
    low.map(|n| (values[n], Mat::from_fn(matrix.nrows(), 1, |r, _| all.U()[(r, n)]))).collect()
}

/// Positions of the non-zero blocks of M.
struct Pattern {
    /// Positions `[i, j]` with `i <= j`, ascending.
    place: Vec<[usize; 2]>,
    /// For each rim node, its neighbours including itself, each with the index of the block.
    row: Vec<Vec<(usize, usize)>>,
}

impl Pattern {
    fn of(cut: &Cut) -> Self {
        let mut place: Vec<[usize; 2]> = (0..cut.rim.len()).map(|k| [k, k]).collect();
        for t in &cut.outside.rim_triangles {
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                if let (Some(i), Some(j)) = (t[i], t[j]) {
                    place.push([i.min(j), i.max(j)]);
                }
            }
        }
        place.sort_unstable();
        place.dedup();
        let mut row = vec![Vec::new(); cut.rim.len()];
        for (b, [i, j]) in place.iter().enumerate() {
            row[*i].push((*j, b));
            if i != j {
                row[*j].push((*i, b));
            }
        }
        Self { place, row }
    }

    fn dense(&self, blocks: &[Block]) -> Mat<f64> {
        let mut full = Mat::zeros(3 * self.row.len(), 3 * self.row.len());
        self.place.iter().zip(blocks).for_each(|(place, block)| put(&mut full, *place, block));
        full
    }

    /// Solves the least-squares problem by conjugate gradients, in the space of symmetric matrices
    /// with this pattern.
    fn fit(&self, s: &Mat<f64>, shapes: &Mat<f64>, start: Option<Vec<Block>>) -> Vec<Block> {
        let ridge = RIDGE;
        let product = s * shapes;
        let at = |m: &Mat<f64>, [i, j]: [usize; 2]| -> Block {
            core::array::from_fn(|a| core::array::from_fn(|b| m[(3 * i + a, 3 * j + b)]))
        };
        let right: Vec<Block> = self
            .place
            .iter()
            .map(|p| {
                let (there, back, own) = (at(&product, *p), at(&product, [p[1], p[0]]), at(s, *p));
                core::array::from_fn(|a| core::array::from_fn(|b| there[a][b] + back[b][a] + 2.0 * ridge * own[a][b]))
            })
            .collect();
        let mut m = start.unwrap_or_else(|| self.place.iter().map(|p| at(s, *p)).collect());
        let mut residual = combine(&right, -1.0, &self.apply(&m, shapes, ridge));
        let mut way = residual.clone();
        let mut square = self.dot(&residual, &residual);
        let enough = TOLERANCE * TOLERANCE * self.dot(&right, &right);
        for _ in 0..MOST_STEPS {
            if square <= enough {
                break;
            }
            let bent = self.apply(&way, shapes, ridge);
            let step = square / self.dot(&way, &bent);
            m = combine(&m, step, &way);
            residual = combine(&residual, -step, &bent);
            let next = self.dot(&residual, &residual);
            way = combine(&residual, next / square, &way);
            square = next;
        }
        m
    }

    /// The product `M G + G M + 2 rho M` on the pattern, where `G` are the weighted responses
    /// `shapes`.
    fn apply(&self, m: &[Block], shapes: &Mat<f64>, ridge: f64) -> Vec<Block> {
        let of = |i: usize, j: usize, b: usize, r: usize, c: usize| if i <= j { m[b][r][c] } else { m[b][c][r] };
        // block (i, j) of M G
        let product = |i: usize, j: usize| -> Block {
            let mut sum = [[0.0; 3]; 3];
            for &(k, b) in &self.row[i] {
                for (r, row) in sum.iter_mut().enumerate() {
                    for (c, entry) in row.iter_mut().enumerate() {
                        *entry += (0..3).map(|l| of(i, k, b, r, l) * shapes[(3 * k + l, 3 * j + c)]).sum::<f64>();
                    }
                }
            }
            sum
        };
        self.place
            .iter()
            .zip(m)
            .map(|([i, j], own)| {
                let (there, back) = (product(*i, *j), product(*j, *i));
                core::array::from_fn(|a| core::array::from_fn(|b| there[a][b] + back[b][a] + 2.0 * ridge * own[a][b]))
            })
            .collect()
    }

    /// Frobenius product of two symmetric matrices.
    fn dot(&self, x: &[Block], y: &[Block]) -> f64 {
        let blocks = self.place.iter().zip(x).zip(y);
        blocks
            .map(|((place, x), y)| {
                let sum: f64 = x.iter().flatten().zip(y.iter().flatten()).map(|(x, y)| x * y).sum();
                if place[0] == place[1] { sum } else { 2.0 * sum }
            })
            .sum()
    }
}

fn combine(x: &[Block], share: f64, y: &[Block]) -> Vec<Block> {
    x.iter().zip(y).map(|(x, y)| core::array::from_fn(|a| core::array::from_fn(|b| x[a][b] + share * y[a][b]))).collect()
}
