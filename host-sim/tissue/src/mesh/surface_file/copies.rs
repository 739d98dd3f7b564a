//! Removes copies of triangles.

use crate::mesh::pairs::sides;

/// Triangles, each once.
pub(super) struct Unique {
    pub triangles: Vec<[u32; 3]>,
    /// Whether each had a copy.
    had_copy: Vec<bool>,
}

/// The first of all triangles that have the same corners.
pub(super) fn unique(triangles: &[[u32; 3]]) -> Unique {
    let mut keys: Vec<([u32; 3], u32)> = triangles.iter().copied().zip(0..).collect();
    for (corners, _) in &mut keys {
        corners.sort_unstable();
    }
    keys.sort_unstable();
    let mut is_copy = vec![false; triangles.len()];
    let mut had_copy = vec![false; triangles.len()];
    for same in keys.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, first), copies @ ..] = same {
            had_copy[*first as usize] = !copies.is_empty();
            copies.iter().for_each(|(_, copy)| is_copy[*copy as usize] = true);
        }
    }
    let own = || is_copy.iter().enumerate().filter(|(_, is_copy)| !**is_copy).map(|(n, _)| n);
    Unique { triangles: own().map(|n| triangles[n]).collect(), had_copy: own().map(|n| had_copy[n]).collect() }
}

impl Unique {
    pub fn is_open(&self) -> bool {
        sides(&self.triangles).chunk_by(|a, b| a.key == b.key).any(|edge| edge.len() == 1)
    }

    /// The triangles without those of sheets that stand out from the body: written once for each of
    /// their sides, they enclose nothing.
    pub fn without_sheets(self) -> Vec<[u32; 3]> {
        let Self { mut triangles, mut had_copy } = self;
        while had_copy.contains(&true) {
            let mut is_loose = vec![false; triangles.len()];
            for edge in sides(&triangles).chunk_by(|a, b| a.key == b.key) {
                if let [side] = edge {
                    is_loose[side.triangle as usize] = had_copy[side.triangle as usize];
                }
            }
            if !is_loose.contains(&true) {
                break;
            }
            let kept = |n: &usize| !is_loose[*n];
            triangles = (0..triangles.len()).filter(kept).map(|n| triangles[n]).collect();
            had_copy = (0..had_copy.len()).filter(kept).map(|n| had_copy[n]).collect();
        }
        triangles
    }
}
