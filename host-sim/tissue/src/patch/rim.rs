//! Rim springs: the far field of a patch in a form that a tick can afford.

/// Rim springs over E.
#[derive(Clone, Debug, PartialEq)]
pub struct RimSprings {
    /// Node of the patch at each rim node, ascending.
    pub node: Vec<u32>,
    /// Blocks between rim nodes by index, `[i, j]` with `i <= j`, and their entries [m], row by
    /// row; a diagonal block is symmetric.
    pub blocks: Vec<([usize; 2], [[f64; 3]; 3])>,
    /// Number of eigenvectors that had to be added until no eigenvalue was negative.
    pub mended: usize,
}
