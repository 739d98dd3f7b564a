//! Boundary conditions at the rim of a patch that represent the tissue outside the cut: ours and
//! others, all derived from the same condensed stiffness S.
//!
//! Each is written as a matrix between the rim nodes, so that all can be pressed in
//! [`palpate_fit::statics`]; the ticks of those that are not springs are in [`crate::methods`]. The
//! shapes of the rim are the leading left singular vectors of its displacements under loads on the
//! surface.

use faer::{Mat, Scale, Side};

use crate::error::Error;
use palpate_fit::far_field::{FarField, springs};
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::RimSprings;

/// Penalty stiffness of a slaved rim against motion outside its modes, in units of the mean
/// diagonal of S (1): a larger value leaves the first four digits of every force unchanged.
const HELD: f64 = 1e4;
/// Relative margin of the block-diagonal stiffness above the limit of positivity (1), so that the
/// subtracted matrix stays invertible.
const ABOVE: f64 = 1e-6;
/// Bracket of the Winkler factor (1), whose logarithm is bisected [`HALVINGS`] times.
const WINKLER: (f64, f64) = (1e-3, 10.0);
const HALVINGS: usize = 24;

/// Treatment of the rim of a cut patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimMethod {
    /// Rim nodes are fixed, as the papers do at the edge of a region.
    Fixed,
    /// Springs to the ground, `c diag(S)`, with a single factor c for the whole rim that is fitted
    /// to a press.
    Winkler,
    /// S restricted to the blocks of rim nodes and rim edges.
    Truncated,
    /// Fitted positive blocks of rim nodes and rim edges: the product's rim springs.
    RimSprings,
    /// The rim moves only in this number of shapes, with the stiffness of S along them.
    Modes(usize),
    /// A block-diagonal stiffness above S minus a matrix of this rank. It equals S along the
    /// shapes; in other directions the rim nodes can move.
    LowRank(usize),
    /// The full matrix S.
    Dense,
}

impl RimMethod {
    /// All treatments in the order of tables and legends.
    pub const ALL: [Self; 9] = [
        Self::Fixed,
        Self::Winkler,
        Self::Truncated,
        Self::RimSprings,
        Self::Modes(9),
        Self::Modes(18),
        Self::LowRank(9),
        Self::LowRank(18),
        Self::Dense,
    ];

    /// Name in files and legends.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Fixed => "fixed".into(),
            Self::Winkler => "winkler".into(),
            Self::Truncated => "truncated".into(),
            Self::RimSprings => "rim-springs".into(),
            Self::Modes(q) => format!("modes-{q}"),
            Self::LowRank(q) => format!("low-rank-{q}"),
            Self::Dense => "dense".into(),
        }
    }
}

/// A stiffness divided by E, written as `blocks - factor factor^T`.
#[derive(Clone, Debug)]
pub struct LowRank {
    /// A symmetric block per rim node [m].
    pub blocks: Vec<[[f64; 3]; 3]>,
    /// Square root of the subtracted matrix [m^(1/2)], shape [3 rim nodes][q].
    pub factor: Mat<f64>,
}

/// All edge treatments of one cut.
#[derive(Clone, Debug)]
pub struct RimMethods<'a> {
    /// Patch, outside, S and the rim springs fitted to it.
    pub far: &'a FarField,
    /// Shapes of the rim, orthonormal, the leading one first, shape [3 rim nodes][3 rim nodes].
    shapes: Mat<f64>,
    /// c of the Winkler springs (1).
    winkler: f64,
}

impl<'a> RimMethods<'a> {
    /// Performs all fits. `free` is the patch with its rim free. The Winkler factor is the one with
    /// which a disc of radius `disc_m`, glued to the site and pressed, has the same stiffness as
    /// with S: a single factor can match one case only, and this is the case of a force curve.
    ///
    /// # Errors
    /// The stiffness of the patch with its far field is not positive at rest.
    pub fn of(far: &'a FarField, free: &Statics, disc_m: f64) -> Result<Self, Error> {
        let squares = &far.answers_per_m * far.answers_per_m.transpose();
        let eigen = squares.self_adjoint_eigen(Side::Lower).map_err(|_| not_positive())?;
        let size = squares.nrows();
        // eigenvalues come in ascending order
        let shapes = Mat::from_fn(size, size, |r, c| eigen.U()[(r, size - 1 - c)]);
        let mut edges = Self { far, shapes, winkler: 1.0 };
        let dense = edges.statics(free, RimMethod::Dense)?;
        let solver = Solver::of(&dense).ok_or_else(not_positive)?;
        let site_m = Vector::from(far.cut.patch.site_m);
        let stiffness = |statics: &Statics| solver.glued(statics, site_m, disc_m, statics.axis()).map(|g| g.stiffness_m);
        let wanted = stiffness(&dense).map_err(|e| TissueError::Check(e.to_string()))?;
        let (mut low, mut high) = WINKLER;
        for _ in 0..HALVINGS {
            edges.winkler = (low * high).sqrt();
            let softer = stiffness(&edges.statics(free, RimMethod::Winkler)?).is_ok_and(|found| found < wanted);
            if softer { low = edges.winkler } else { high = edges.winkler }
        }
        Ok(edges)
    }

    /// Indices of the rim nodes in the patch.
    #[must_use]
    pub fn rim(&self) -> Vec<usize> {
        self.far.cut.rim.iter().map(|n| *n as usize).collect()
    }

    /// Statics of the patch `free` with one of the treatments at its rim.
    ///
    /// # Errors
    /// S is not positive, so that it has no factor.
    pub fn statics(&self, free: &Statics, edge: RimMethod) -> Result<Statics, Error> {
        let rim = self.rim();
        Ok(match edge {
            RimMethod::Fixed => free.with_fixed(&rim),
            RimMethod::Winkler | RimMethod::Truncated | RimMethod::RimSprings => {
                free.with_rim(&rim, &springs::dense(&self.sparse(edge).unwrap_or_else(|| self.far.springs.clone())))
            }
            RimMethod::Modes(q) => free.with_rim(&rim, &self.slaved(q)),
            RimMethod::LowRank(q) => {
                let LowRank { blocks, factor } = self.low_rank(q)?;
                let taken = &factor * factor.transpose();
                let block = |r: usize, c: usize| if r / 3 == c / 3 { blocks[r / 3][r % 3][c % 3] } else { 0.0 };
                free.with_rim(&rim, &Mat::from_fn(3 * rim.len(), 3 * rim.len(), |r, c| block(r, c) - taken[(r, c)]))
            }
            RimMethod::Dense => free.with_rim(&rim, &self.far.exact_m),
        })
    }

    /// The treatment as rim springs of the product's kind; `None` for the treatments that have
    /// another form.
    #[must_use]
    pub fn sparse(&self, edge: RimMethod) -> Option<RimSprings> {
        let s = &self.far.exact_m;
        let blocks = match edge {
            RimMethod::Winkler => {
                let c = self.winkler;
                let own = |k: usize| {
                    let d = [0, 1, 2].map(|a| c * s[(3 * k + a, 3 * k + a)]);
                    ([k, k], [[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]])
                };
                (0..self.far.cut.rim.len()).map(own).collect()
            }
            RimMethod::Truncated => self.far.springs.blocks.iter().map(|(at, _)| (*at, block(s, *at))).collect(),
            RimMethod::RimSprings => return Some(self.far.springs.clone()),
            _ => return None,
        };
        Some(RimSprings { node: self.far.cut.rim.clone(), blocks, mended: 0 })
    }

    /// The `q` leading shapes, or as many as there are, shape [3 rim nodes][q].
    #[must_use]
    pub fn modes(&self, q: usize) -> Mat<f64> {
        let size = self.shapes.nrows();
        Mat::from_fn(size, q.min(size), |r, c| self.shapes[(r, c)])
    }

    /// `P S P + p (1 - P)`, with P the projection on the modes and p large enough to suppress all
    /// other motion.
    fn slaved(&self, q: usize) -> Mat<f64> {
        let modes = self.modes(q);
        let on = &modes * modes.transpose();
        let size = on.nrows();
        let held = HELD * (0..size).map(|r| self.far.exact_m[(r, r)]).sum::<f64>() / size as f64;
        let along = &on * &self.far.exact_m * &on;
        Mat::from_fn(size, size, |r, c| 0.5 * (along[(r, c)] + along[(c, r)]) + held * (f64::from(u8::from(r == c)) - on[(r, c)]))
    }

    /// `D - (D - S) Phi [Phi^T (D - S) Phi]^-1 Phi^T (D - S)`, D = c blockdiag(S) with the least c
    /// that keeps `D - S` positive: S along the shapes Phi, and never below S elsewhere, because
    /// the subtracted matrix is a Nystroem approximation of `D - S` from below.
    ///
    /// # Errors
    /// S is not positive.
    pub fn low_rank(&self, q: usize) -> Result<LowRank, Error> {
        let s = &self.far.exact_m;
        let size = s.nrows();
        let diagonal = Mat::from_fn(size, size, |r, c| if r / 3 == c / 3 { s[(r, c)] } else { 0.0 });
        let root = diagonal.llt(Side::Lower).map_err(|_| not_positive())?;
        let scaled = within(root.L(), s);
        let largest = scaled.self_adjoint_eigenvalues(Side::Lower).map_err(|_| not_positive())?.into_iter().fold(0.0, f64::max);
        let above = largest * (1.0 + ABOVE);
        let phi = self.modes(q);
        let rest = &diagonal * Scale(above) - s;
        let pulled = &rest * &phi;
        let inner = phi.transpose() * &pulled;
        let root = inner.llt(Side::Lower).map_err(|_| not_positive())?;
        // `factor = pulled L^-T`
        let mut flat = pulled.transpose().to_owned();
        forward(root.L(), &mut flat);
        let blocks = (0..size / 3).map(|k| block(&diagonal, [k, k]).map(|row| row.map(|v| above * v))).collect();
        Ok(LowRank { blocks, factor: flat.transpose().to_owned() })
    }
}

fn not_positive() -> Error {
    Error::Tissue(TissueError::Check(
        "the patch with its far field is not stiff at rest: take another radius or another mesh".into(),
    ))
}

fn block(m: &Mat<f64>, [i, j]: [usize; 2]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| m[(3 * i + a, 3 * j + b)]))
}

/// Solves `L X = right` in place; L is lower triangular.
fn forward(l: faer::MatRef<f64>, right: &mut Mat<f64>) {
    for c in 0..right.ncols() {
        for r in 0..l.nrows() {
            let sum: f64 = (0..r).map(|k| l[(r, k)] * right[(k, c)]).sum();
            right[(r, c)] = (right[(r, c)] - sum) / l[(r, r)];
        }
    }
}

/// Returns `L^-1 S L^-T`.
fn within(l: faer::MatRef<f64>, s: &Mat<f64>) -> Mat<f64> {
    let mut half = s.clone();
    forward(l, &mut half);
    let mut whole = half.transpose().to_owned();
    forward(l, &mut whole);
    Mat::from_fn(whole.nrows(), whole.ncols(), |r, c| 0.5 * (whole[(r, c)] + whole[(c, r)]))
}
