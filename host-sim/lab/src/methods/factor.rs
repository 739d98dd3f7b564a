//! A sparse matrix that is factored once (`faer`, Cholesky with fill-reducing order) and then used
//! for solves in every tick, without allocation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side, Spec};

use palpate_tissue::error::Error;

/// Factor of a symmetric positive definite matrix.
pub struct Factor<T> {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<T>,
    memory: MemBuffer,
}

impl<T: RealField + Copy> Factor<T> {
    /// Factors the matrix with these (row, column, value) in its lower triangle; duplicates are
    /// summed.
    pub fn new(rows: usize, lower: &[(usize, usize, T)]) -> Result<Self, Error> {
        let refused =
            |why: String| Error::TooSlow(format!("a stiffness matrix of {rows} rows cannot be factored: {why}: check the mesh"));
        let triplets: Vec<_> = lower.iter().map(|&(r, c, v)| Triplet::new(r, c, v)).collect();
        let matrix =
            SparseColMat::<usize, T>::try_new_from_triplets(rows, rows, &triplets).map_err(|e| refused(format!("{e:?}")))?;
        let symbolic = factorize_symbolic_cholesky(
            matrix.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams::default(),
        )
        .map_err(|e| refused(format!("{e:?}")))?;
        let mut values = vec![faer::traits::math_utils::zero::<T>(); symbolic.len_val()];
        let mut scratch = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Spec::default()));
        symbolic
            .factorize_numeric_llt(
                &mut values,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut scratch),
                Spec::default(),
            )
            .map_err(|e| refused(format!("{e:?}")))?;
        let memory = MemBuffer::new(symbolic.solve_in_place_scratch::<T>(1, Par::Seq));
        Ok(Self { symbolic, values, memory })
    }

    /// Replaces a right-hand side by the solution; both have shape \[rows\].
    pub fn solve(&mut self, right_hand_side: &mut [T]) {
        let rows = right_hand_side.len();
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(right_hand_side, rows, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }

    /// Number of stored entries of the factor, including zeros in dense blocks.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether the matrix has no rows.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}
