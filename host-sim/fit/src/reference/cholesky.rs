//! Sparse Cholesky factorisation with a fixed pattern.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::Perm;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side, Spec};

/// A lower triangle stored by columns, and the pattern of its factor.
pub(crate) struct Cholesky {
    size: usize,
    column_start: Vec<usize>,
    row: Vec<usize>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
}

impl Cholesky {
    /// Analyses a lower triangle whose unknowns are eliminated in the given order; `None` if there
    /// is not enough memory.
    pub fn analyse(column_start: Vec<usize>, row: Vec<usize>, order: Vec<usize>) -> Option<Self> {
        let size = column_start.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &column_start, None, &row);
        let mut place = vec![0; size];
        order.iter().enumerate().for_each(|(at, unknown)| place[*unknown] = at);
        let order = Perm::new_checked(order.into_boxed_slice(), place.into_boxed_slice(), size);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let order = SymmetricOrdering::Custom(order.as_ref());
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, order, parameters).ok()?;
        let factor = vec![0.0; symbolic.len_val()];
        Some(Self { size, column_start, row, symbolic, factor })
    }

    /// Number of entries of the factor.
    pub fn entries(&self) -> usize {
        self.factor.len()
    }

    /// Computes the factor; returns false if the matrix is not positive definite.
    pub fn factorise(&mut self, values: &[f64]) -> bool {
        let pattern = SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.column_start, None, &self.row);
        let matrix = SparseColMatRef::new(pattern, values);
        let need = self.symbolic.factorize_numeric_llt_scratch::<f64>(parallel(), Spec::default());
        let Ok(mut memory) = MemBuffer::try_new(need) else { return false };
        let stack = MemStack::new(&mut memory);
        self.factor.fill(0.0);
        self.symbolic
            .factorize_numeric_llt(&mut self.factor, matrix, Side::Lower, Default::default(), parallel(), stack, Spec::default())
            .is_ok()
    }

    /// The last `count` rows and columns of the factor, in the order of elimination. They are the
    /// factor of the matrix from which all other unknowns are condensed out.
    pub fn last(&self, count: usize) -> Mat<f64> {
        let mut last = Mat::zeros(count, count);
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else { return last };
        let factor = SupernodalLltRef::<'_, usize, f64>::new(symbolic, &self.factor);
        let first = self.size - count;
        for s in (0..symbolic.n_supernodes()).rev() {
            let (node, values) = (factor.supernode(s), factor.supernode(s).val());
            let (start, columns) = (node.start(), values.ncols());
            if start + columns <= first {
                break;
            }
            for column in first.max(start)..start + columns {
                let below = (column..start + columns).chain(node.pattern().iter().copied());
                for (at, row) in below.enumerate() {
                    last[(row - first, column - first)] = values[(column - start + at, column - start)];
                }
            }
        }
        last
    }

    /// Solves in place with the factor that was computed last.
    pub fn solve(&self, rhs: &mut [f64]) {
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(1, parallel()));
        let rhs = MatMut::from_column_major_slice_mut(rhs, self.size, 1);
        LltRef::<'_, usize, f64>::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            rhs,
            parallel(),
            MemStack::new(&mut memory),
        );
    }
}

pub(crate) fn parallel() -> Par {
    #[cfg(not(target_family = "wasm"))]
    return Par::rayon(0);
    #[cfg(target_family = "wasm")]
    Par::Seq
}
