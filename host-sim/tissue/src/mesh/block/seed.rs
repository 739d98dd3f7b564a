//! Start positions of the nodes: corners, then edges, faces and the volume, each with the number of
//! nodes that its budget gives.

use super::grading::{Budget, Grading, Span, edge_axes, face_axes};
use super::vector::{Vec3, distance};

/// Number of candidates for each node to be placed.
const CANDIDATES: usize = 16;
/// Steps of a low-discrepancy sequence in four dimensions (Roberts 2018): powers of the inverse
/// real root of x^5 = x + 1.
const STEPS: [f64; 4] = [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_7, 0.538_597_257_223_610_1];

/// Shift of the sequence's start from one variant to the next: irrational, so that no two variants
/// start alike.
const SHIFTS: [f64; 4] = [0.414_213_562_373_095_1, 0.732_050_807_568_877_2, 0.236_067_977_499_789_8, 0.645_751_311_064_590_6];
/// Least distance between the shell and a node that starts off it, in elements.
const OFF_SHELL: f64 = 0.5;

/// Position of a node relative to the shell. Without a shell every node is `Outside`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Side {
    Inside,
    Shell,
    #[default]
    Outside,
}

/// Nodes of the block: the position of each, and the axes along which it may not move.
#[derive(Clone, Debug, Default)]
pub(super) struct Cloud {
    pub at: Vec<Vec3>,
    pub pinned: Vec<[bool; 3]>,
    /// Side of the shell on which each node stays.
    pub side: Vec<Side>,
}

/// A set of points that nodes can fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Domain {
    /// An edge, a face or the volume of the block, off the shell.
    Block([Span; 3]),
    /// The circle in which the shell meets the top face.
    Circle,
    /// The shell below the top face.
    Shell,
}

/// Places all nodes; another `variant` arranges the same number of nodes differently.
pub(super) fn seed(grading: &Grading, budget: &Budget, variant: u32) -> Cloud {
    let mut cloud = Cloud::default();
    for i in 0..8 {
        let corner = |k: usize| if i >> k & 1 == 1 { grading.high[k] } else { grading.low[k] };
        cloud.push(std::array::from_fn(corner), [true; 3], Side::Outside);
    }
    for (e, &count) in budget.edges.iter().enumerate() {
        fill_edge(&mut cloud, grading, edge_axes(e), count);
    }
    fill(&mut cloud, grading, Domain::Circle, variant, budget.circle);
    for (f, &count) in budget.faces.iter().enumerate() {
        fill(&mut cloud, grading, Domain::Block(face_axes(f)), variant, count);
    }
    fill(&mut cloud, grading, Domain::Shell, variant, budget.shell);
    fill(&mut cloud, grading, Domain::Block([Span::Free; 3]), variant, budget.volume);
    cloud
}

impl Cloud {
    /// Whether two nodes lie on the same block face across axis `k`.
    pub fn share_face(&self, a: usize, b: usize, k: usize) -> bool {
        self.pinned[a][k] && self.pinned[b][k] && self.at[a][k] == self.at[b][k]
    }

    /// Whether a tet has nodes on both sides of the shell.
    pub fn crosses_shell(&self, tet: [u32; 4]) -> bool {
        let has = |side: Side| tet.iter().any(|n| self.side[*n as usize] == side);
        has(Side::Inside) && has(Side::Outside)
    }

    fn push(&mut self, at: Vec3, pinned: [bool; 3], side: Side) {
        self.at.push(at);
        self.side.push(side);
        self.pinned.push(pinned);
    }
}

/// Point of an edge, face or volume at fractions `t` of its free axes.
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

/// Adds `count` nodes that divide an edge into pieces of equal length over element size.
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
            cloud.push(place(grading, axes, [t; 3]), pinned(axes), Side::Outside);
            placed += 1;
        }
        passed += here;
    }
}

/// Adds `count` nodes, each the candidate that is farthest (in elements) from all nodes so far.
fn fill(cloud: &mut Cloud, grading: &Grading, domain: Domain, variant: u32, count: usize) {
    let mut candidates = candidates(grading, domain, variant, CANDIDATES * count);
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
        let at = candidates.swap_remove(farthest).0;
        let side = if matches!(domain, Domain::Block(_)) { grading.side_of(at) } else { Side::Shell };
        cloud.push(at, domain.pinned(), side);
        gaps.swap_remove(farthest);
    }
}

/// Points with density `size^-d` over the d dimensions of `domain`, each with its element size.
fn candidates(grading: &Grading, domain: Domain, variant: u32, count: usize) -> Vec<(Vec3, f64)> {
    let least = grading.least_size();
    let chosen = offered(grading, domain, variant).filter_map(|(point, chance)| {
        let size = grading.size_at(point);
        let shrink = least / size;
        let kept = chance < (0..domain.dimensions()).fold(1.0, |s, _| s * shrink);
        (kept && domain.clear(grading, point, size)).then_some((point, size))
    });
    chosen.take(count).collect()
}

/// `count` points spread evenly over `domain`.
pub(super) fn points(grading: &Grading, domain: Domain, variant: u32, count: usize) -> impl Iterator<Item = Vec3> {
    offered(grading, domain, variant).map(|(point, _)| point).take(count)
}

/// An endless sequence of points spread evenly over `domain`, each with a number from 0 to 1 that
/// is independent of its place.
fn offered(grading: &Grading, domain: Domain, variant: u32) -> impl Iterator<Item = (Vec3, f64)> {
    let turn = |shift: f64| {
        let x = 0.5 + f64::from(variant) * shift;
        x - x.floor()
    };
    let mut sequence = SHIFTS.map(turn);
    std::iter::repeat_with(move || {
        for (x, step) in sequence.iter_mut().zip(STEPS) {
            *x += step;
            *x -= x.floor();
        }
        sequence
    })
    .filter_map(move |[x, y, z, chance]| Some((domain.point(grading, [x, y, z])?, chance)))
}

impl Domain {
    fn dimensions(self) -> usize {
        match self {
            Self::Block(axes) => axes.iter().filter(|a| **a == Span::Free).count(),
            Self::Circle => 1,
            Self::Shell => 2,
        }
    }

    fn pinned(self) -> [bool; 3] {
        match self {
            Self::Block(axes) => pinned(axes),
            Self::Circle => [false, false, true],
            Self::Shell => [false; 3],
        }
    }

    /// The point at fractions `t` of the box around the domain, if it lies in the domain.
    fn point(self, grading: &Grading, t: Vec3) -> Option<Vec3> {
        let [low, high] = grading.shell_box();
        let within = |k: usize| low[k] + t[k] * (high[k] - low[k]);
        match self {
            Self::Block(axes) => Some(place(grading, axes, t)),
            Self::Circle => grading.near_shell([within(0), within(1), high[2]]),
            Self::Shell => grading.near_shell([within(0), within(1), within(2)]),
        }
    }

    /// Whether a node at `p` is far enough from the shell, or meant to be on it.
    fn clear(self, grading: &Grading, p: Vec3, size: f64) -> bool {
        !matches!(self, Self::Block(_)) || grading.hold(grading.side_of(p), p, OFF_SHELL * size) == p
    }
}
