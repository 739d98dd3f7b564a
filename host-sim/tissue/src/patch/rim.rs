//! Rim springs: the far field of a patch in a form that a tick can afford.

/// Rim springs, with stiffness divided by Young's modulus.
#[derive(Clone, Debug, PartialEq)]
pub struct RimSprings {
    /// Index in the patch of each rim node, ascending.
    pub node: Vec<u32>,
    /// Stiffness blocks between rim nodes: `[i, j]`, indices into `node` with `i <= j`, and the
    /// entries [m], row by row. A diagonal block is symmetric.
    pub blocks: Vec<([usize; 2], [[f64; 3]; 3])>,
    /// Number of eigenvectors that had to be added to the stiffness until it had no negative
    /// eigenvalue.
    pub mended: usize,
}
