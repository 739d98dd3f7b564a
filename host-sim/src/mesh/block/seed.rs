//! Where the nodes start: corners, then edges, faces and the volume, each filled to its budget.

use super::grading::{Budget, Grading, Span, edge_axes, face_axes};
use super::vector::{Vec3, distance};

/// Candidates offered per node to place.
const CANDIDATES: usize = 16;
/// Powers of the inverse real root of x^5 = x + 1: a low-discrepancy sequence in four dimensions (Roberts 2018).
const STEPS: [f64; 4] = [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_7, 0.538_597_257_223_610_1];

/// Nodes of the block: where each is, and along which axes it may not move.
#[derive(Clone, Debug, Default)]
pub(super) struct Cloud {
    pub at: Vec<Vec3>,
    pub pinned: Vec<[bool; 3]>,
}

pub(super) fn seed(grading: &Grading, budget: &Budget) -> Cloud {
    let mut cloud = Cloud::default();
    for i in 0..8 {
        let corner = |k: usize| if i >> k & 1 == 1 { grading.high[k] } else { grading.low[k] };
        cloud.push(std::array::from_fn(corner), [true; 3]);
    }
    for (e, &count) in budget.edges.iter().enumerate() {
        fill_edge(&mut cloud, grading, edge_axes(e), count);
    }
    for (f, &count) in budget.faces.iter().enumerate() {
        fill(&mut cloud, grading, face_axes(f), count);
    }
    fill(&mut cloud, grading, [Span::Free; 3], budget.volume);
    cloud
}

impl Cloud {
    /// Whether two nodes lie on the same block face across axis `k`.
    pub fn share_face(&self, a: usize, b: usize, k: usize) -> bool {
        self.pinned[a][k] && self.pinned[b][k] && self.at[a][k] == self.at[b][k]
    }

    fn push(&mut self, at: Vec3, pinned: [bool; 3]) {
        self.at.push(at);
        self.pinned.push(pinned);
    }
}

/// The point of an edge, face or volume at fractions `t` of its free axes.
fn place(grading: &Grading, axes: [Span; 3], t: Vec3) -> Vec3 {
    std::array::from_fn(|k| match axes[k] {
        Span::Low => grading.low[k],
        Span::High => grading.high[k],
        Span::Free => grading.low[k] + t[k] * (grading.high[k] - grading.low[k]),
    })
}

fn pinned(axes: [Span; 3]) -> [bool; 3] {
    axes.map(|a| a != Span::Free)
}

/// `count` nodes that split an edge into pieces of equal length over size.
fn fill_edge(cloud: &mut Cloud, grading: &Grading, axes: [Span; 3], count: usize) {
    const STEPS: usize = 512;
    let density = |i: usize| 1.0 / grading.size_at(place(grading, axes, [(i as f64 + 0.5) / STEPS as f64; 3]));
    let total: f64 = (0..STEPS).map(density).sum();
    let (mut passed, mut placed) = (0.0, 0);
    for i in 0..STEPS {
        let here = density(i);
        while placed < count {
            let wanted = total * (placed + 1) as f64 / (count + 1) as f64;
            if passed + here < wanted {
                break;
            }
            let t = (i as f64 + (wanted - passed) / here) / STEPS as f64;
            cloud.push(place(grading, axes, [t; 3]), pinned(axes));
            placed += 1;
        }
        passed += here;
    }
}

/// `count` nodes, each the candidate farthest (in elements) from all nodes so far.
fn fill(cloud: &mut Cloud, grading: &Grading, axes: [Span; 3], count: usize) {
    let mut candidates = candidates(grading, axes, CANDIDATES * count);
    let mut gaps = vec![f64::INFINITY; candidates.len()];
    let mut seen = 0;
    for _ in 0..count {
        for node in &cloud.at[seen..] {
            for (gap, (p, size)) in gaps.iter_mut().zip(&candidates) {
                *gap = gap.min(distance(*p, *node) / size);
            }
        }
        seen = cloud.at.len();
        let farthest = (0..gaps.len()).fold(0, |best, i| if gaps[i] > gaps[best] { i } else { best });
        cloud.push(candidates.swap_remove(farthest).0, pinned(axes));
        gaps.swap_remove(farthest);
    }
}

/// Points with density `size^-d` over the d free axes, each with its element size.
fn candidates(grading: &Grading, axes: [Span; 3], count: usize) -> Vec<(Vec3, f64)> {
    let mut sequence = [0.5; 4];
    let mut kept = Vec::with_capacity(count);
    while kept.len() < count {
        for (x, step) in sequence.iter_mut().zip(STEPS) {
            *x += step;
            *x -= x.floor();
        }
        let [x, y, z, chance] = sequence;
        let point = place(grading, axes, [x, y, z]);
        let size = grading.size_at(point);
        let shrink = grading.fine_size / size;
        let free = axes.iter().filter(|a| **a == Span::Free).count();
        if chance < (0..free).fold(1.0, |s, _| s * shrink) {
            kept.push((point, size));
        }
    }
    kept
}
