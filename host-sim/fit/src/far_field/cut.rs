//! Cuts a patch out of a whole organ: the patch consists of the tets near the site, the outside of
//! the rest.

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

use super::Sizes;
use super::whole::distance_m;
use palpate_tissue::mesh::{TetMesh, surface};
use palpate_tissue::tissue::Tissue;

/// Reason why no patch can be cut.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CutError {
    /// No tet is near the site.
    #[error("no element lies within {radius_mm:.1} mm of the site: take a larger patch radius or smaller elements")]
    Empty {
        /// Radius of the patch [mm].
        radius_mm: f64,
    },
    /// No part of the organ remains outside.
    #[error("a patch of {radius_mm:.1} mm swallows the organ: the largest radius that leaves an outside is {most_mm:.1} mm")]
    Swallows {
        /// Radius of the patch [mm].
        radius_mm: f64,
        /// Largest radius that leaves an outside [mm].
        most_mm: f64,
    },
    /// No node of the organ is fixed.
    #[error("the organ is fixed nowhere: give it an underside or bones that hold it, or press it from another side")]
    NoAnchor,
}

/// The rest of an organ around a patch.
#[derive(Clone, Debug)]
pub struct Outside {
    /// Mesh of the rest of the organ.
    pub mesh: TetMesh,
    /// Stiffness of each tet as a multiple of the tissue's, shape \[tets\].
    pub stiffness_ratio: Vec<f64>,
    /// Fixed nodes, ascending.
    pub anchors: Vec<u32>,
    /// Node of the outside that coincides with each rim node, in the order of [`Cut::rim`].
    pub rim: Vec<u32>,
    /// Triangles between patch and outside, as indices into [`Cut::rim`]; `None` for a fixed
    /// corner.
    pub rim_triangles: Vec<[Option<usize>; 3]>,
    /// Triangles between patch and outside, as nodes of the outside.
    pub rim_faces: Vec<[u32; 3]>,
}

/// A patch and its outside, after the cut.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Patch; its skin is the part of its surface that belongs to the organ's.
    pub patch: Tissue,
    /// Nodes of the patch on the cut that are not fixed, ascending.
    pub rim: Vec<u32>,
    /// Part of the organ outside the patch.
    pub outside: Outside,
    /// Node of the whole organ for each node of the patch, ascending.
    pub node: Vec<u32>,
}

impl Cut {
    /// Makes a patch of all tets of `whole` whose centroid is near the site and that are connected
    /// by faces.
    ///
    /// # Errors
    /// See [`CutError`].
    pub fn of(whole: &Tissue, sizes: &Sizes) -> Result<Self, CutError> {
        let radius_mm = sizes.radius_m * 1e3;
        if whole.anchors.is_empty() {
            return Err(CutError::NoAnchor);
        }
        let mesh = &whole.mesh;
        let away: Vec<f64> = mesh.tets.iter().map(|t| distance_m(whole.site_m, centroid(mesh, t))).collect();
        let choose = |radius_m: f64| held(whole, connected(&mesh.tets, &away, radius_m));
        if !away.iter().any(|a| *a <= sizes.radius_m) {
            return Err(CutError::Empty { radius_mm });
        }
        let Some(inside) = choose(sizes.radius_m) else {
            let (mut low, mut high) = (0.0, sizes.radius_m);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                if choose(middle).is_some() { low = middle } else { high = middle }
            }
            return Err(CutError::Swallows { radius_mm, most_mm: low * 1e3 });
        };
        Ok(Self::split(whole, &inside))
    }

    fn split(whole: &Tissue, inside: &[bool]) -> Self {
        let tets = |side: bool| inside.iter().enumerate().filter(move |(_, i)| **i == side).map(|(t, _)| t).collect::<Vec<_>>();
        let (near, far) = (tets(true), tets(false));
        let (patch_mesh, node) = part(&whole.mesh, &near);
        let (outside_mesh, outside_node) = part(&whole.mesh, &far);
        let local = |nodes: &[u32]| nodes.iter().enumerate().map(|(n, w)| (*w, n as u32)).collect::<BTreeMap<u32, u32>>();
        let (patch_of, outside_of) = (local(&node), local(&outside_node));
        let anchors = |of: &BTreeMap<u32, u32>| whole.anchors.iter().filter_map(|a| of.get(a).copied()).collect::<Vec<u32>>();
        let of_tets = |list: &[usize]| list.iter().map(|t| whole.stiffness_ratio[*t]).collect();

        // boundary faces of the patch that are not boundary faces of the whole organ form the cut
        let shown: BTreeSet<[u32; 3]> = whole.skin.iter().map(|t| sorted(*t)).collect();
        let as_whole = |t: &[u32; 3]| t.map(|n| node[n as usize]);
        let (skin, cut): (Vec<[u32; 3]>, Vec<[u32; 3]>) =
            surface::surface(&patch_mesh.tets).into_iter().partition(|t| shown.contains(&sorted(as_whole(t))));
        let fixed = anchors(&patch_of);
        // a node that both sides share is tied, even if the sides meet only at an edge
        let shared = (0_u32..).zip(&node).filter(|(n, w)| outside_of.contains_key(*w) && fixed.binary_search(n).is_err());
        let rim: Vec<u32> = shared.map(|(n, _)| n).collect();
        let rim_triangles = cut.iter().map(|t| t.map(|n| rim.binary_search(&n).ok())).collect();
        let rim_faces = cut.iter().map(|t| as_whole(t).map(|w| outside_of[&w])).collect();
        let outside = Outside {
            stiffness_ratio: of_tets(&far),
            anchors: anchors(&outside_of),
            rim: rim.iter().map(|n| outside_of[&node[*n as usize]]).collect(),
            rim_triangles,
            rim_faces,
            mesh: outside_mesh,
        };
        let patch = Tissue {
            stiffness_ratio: of_tets(&near),
            skin,
            anchors: fixed,
            site_m: whole.site_m,
            depth_limit_m: whole.depth_limit_m,
            mesh: patch_mesh,
        };
        Self { patch, rim, outside, node }
    }
}

fn centroid(mesh: &TetMesh, tet: &[u32; 4]) -> [f64; 3] {
    [0, 1, 2].map(|k| tet.iter().map(|n| 0.25 * mesh.nodes_m[*n as usize][k]).sum())
}

fn sorted(mut t: [u32; 3]) -> [u32; 3] {
    t.sort_unstable();
    t
}

/// For every tet, lists the tets with which it shares a face.
fn neighbours(tets: &[[u32; 4]]) -> Vec<Vec<usize>> {
    let mut beside = vec![Vec::new(); tets.len()];
    let mut faces: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for (t, &[a, b, c, d]) in tets.iter().enumerate() {
        for face in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            if let Some(other) = faces.insert(sorted(face), t) {
                beside[other].push(t);
                beside[t].push(other);
            }
        }
    }
    beside
}

/// Marks the tets that are connected with `start` by faces, through tets for which `may` is true.
fn flood(beside: &[Vec<usize>], start: usize, may: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut seen = vec![false; beside.len()];
    seen[start] = true;
    let mut open = vec![start];
    while let Some(t) = open.pop() {
        for &next in &beside[t] {
            if !seen[next] && may(next) {
                seen[next] = true;
                open.push(next);
            }
        }
    }
    seen
}

/// Marks the tets within the radius that are connected with the nearest one.
fn connected(tets: &[[u32; 4]], away: &[f64], radius_m: f64) -> Vec<bool> {
    let nearest = (0..away.len()).min_by(|a, b| away[*a].total_cmp(&away[*b]));
    let Some(start) = nearest.filter(|t| away[*t] <= radius_m) else { return vec![false; away.len()] };
    flood(&neighbours(tets), start, |t| away[t] <= radius_m)
}

/// Adds the unsupported fragments of the outside to the patch; returns `None` if no supported
/// fragment remains outside.
fn held(whole: &Tissue, mut inside: Vec<bool>) -> Option<Vec<bool>> {
    let tets = &whole.mesh.tets;
    let beside = neighbours(tets);
    let mut left = false;
    let mut known = inside.clone();
    for t in 0..tets.len() {
        if known[t] {
            continue;
        }
        let piece = flood(&beside, t, |n| !inside[n]);
        let fixed = |t: usize| tets[t].iter().filter(|n| whole.anchors.binary_search(n).is_ok()).count() >= 3;
        let holds = (0..tets.len()).any(|t| piece[t] && fixed(t));
        left |= holds;
        for (t, _) in piece.iter().enumerate().filter(|(_, p)| **p) {
            known[t] = true;
            inside[t] |= !holds;
        }
    }
    left.then_some(inside)
}

/// A mesh of some of the tets, and the node of the whole for each of its nodes, ascending.
fn part(mesh: &TetMesh, tets: &[usize]) -> (TetMesh, Vec<u32>) {
    let used: BTreeSet<u32> = tets.iter().flat_map(|t| mesh.tets[*t]).collect();
    let node: Vec<u32> = used.into_iter().collect();
    let local = |n: u32| node.binary_search(&n).unwrap_or_default() as u32;
    let part = TetMesh {
        nodes_m: node.iter().map(|n| mesh.nodes_m[*n as usize]).collect(),
        tets: tets.iter().map(|t| mesh.tets[*t].map(local)).collect(),
        regions: tets.iter().map(|t| mesh.regions[*t]).collect(),
    };
    (part, node)
}
