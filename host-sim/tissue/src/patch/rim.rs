//! Rim springs, the far field of a patch as a tick can afford it.

/// Rim springs over E.
#[derive(Clone, Debug, PartialEq)]
pub struct RimSprings {
    /// Node of the patch at each rim node, ascending.
    pub node: Vec<u32>,
    /// Blocks between rim nodes by place, `[i, j]` with `i <= j`, and their entries [m], row by
    /// row; a diagonal block is symmetric.
    pub blocks: Vec<([usize; 2], [[f64; 3]; 3])>,
    /// Eigenvectors that had to be added before no eigenvalue was negative.
    pub mended: usize,
}
