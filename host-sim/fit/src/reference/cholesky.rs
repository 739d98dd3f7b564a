//! Sparse Cholesky factor with a fixed pattern.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// Lower triangle by columns, and the factor's pattern.
pub(crate) struct Cholesky {
    size: usize,
    column_start: Vec<usize>,
    row: Vec<usize>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
}

impl Cholesky {
    /// Analyses a lower triangle and orders its elimination (approximate minimum degree); `None` if
    /// memory runs out.
    pub fn analyse(column_start: Vec<usize>, row: Vec<usize>) -> Option<Self> {
        let size = column_start.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &column_start, None, &row);
        let order = SymmetricOrdering::Amd;
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, order, CholeskySymbolicParams::default()).ok()?;
        let factor = vec![0.0; symbolic.len_val()];
        Some(Self { size, column_start, row, symbolic, factor })
    }

    /// Entries of the factor.
    pub fn entries(&self) -> usize {
        self.factor.len()
    }

    /// Factorises; false if the matrix is not positive definite.
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

    /// Solves in place with the last factor.
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

fn parallel() -> Par {
    #[cfg(not(target_family = "wasm"))]
    return Par::rayon(0);
    #[cfg(target_family = "wasm")]
    Par::Seq
}
