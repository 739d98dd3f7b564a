//! Element size in a box, and the number of nodes that it requires. Unit of length: the longest
//! side of the block.

use super::vector::Vec3;

/// Growth of the element size per distance, over sqrt(fine size / fine radius) (1). The growth is
/// at most `MAX_GROWTH`. It depends on the fine size so that more nodes refine the far side, too. A
/// block of 80 x 80 x 40 mm with 410 nodes and a radius of 8 mm gets 0.45.
const GROWTH: f64 = 0.75;
const MAX_GROWTH: f64 = 0.8;
/// Number of nodes per element area in an isotropic Delaunay mesh whose mean edge is one element.
const PER_AREA: f64 = 1.1547;
/// Number of nodes per element volume in such a mesh.
const PER_VOLUME: f64 = 1.45;
/// Factor by which elements around a patch are longer than the requested size (1): the fewest nodes
/// are then used that keep the mean edge within 15 % of that size.
const LONGER: f64 = 1.09;
/// Number of quadrature points per axis on each side of the fine spot.
const SAMPLES: usize = 12;
/// Number of quadrature points per axis on each side of the fine spot if there is a shell, whose
/// neighbourhood is not centred on the spot.
const SHELL_SAMPLES: usize = 24;

/// A box with a fine spot on its top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grading {
    pub low: Vec3,
    pub high: Vec3,
    pub spot: Vec3,
    /// Radius of the half sphere around the spot on which nodes are held.
    pub shell: Option<f64>,
    pub fine_radius: f64,
    /// Element size within the fine radius.
    pub fine_size: f64,
    /// Growth of the element size per distance beyond the fine radius (1).
    pub growth: f64,
}

/// Numbers of nodes inside each edge and each face, on the circle where the shell meets the top
/// face, on the shell below it, and in the volume.
#[derive(Debug)]
pub(super) struct Budget {
    pub edges: [usize; 12],
    pub faces: [usize; 6],
    pub circle: usize,
    pub shell: usize,
    pub volume: usize,
}

impl Budget {
    pub fn total(&self) -> usize {
        8 + self.edges.iter().sum::<usize>() + self.faces.iter().sum::<usize>() + self.circle + self.shell + self.volume
    }
}

impl Grading {
    /// Element size wanted at `p`.
    pub fn size_at(&self, p: Vec3) -> f64 {
        let beyond = self.away(p) - self.fine_radius;
        let size = if beyond > 0.0 { self.fine_size + self.growth * beyond } else { self.fine_size };
        size.min(self.max_size()).min(self.room(p))
    }

    /// Largest size of an element: the length of the thinnest side, since a block is at least one
    /// element thick.
    fn max_size(&self) -> f64 {
        let side = |k: usize| self.high[k] - self.low[k];
        side(0).min(side(1)).min(side(2))
    }

    /// Sets the fine element size so that `nodes` fit; `Err` is the least number of nodes that a
    /// mesh needs.
    pub fn fit(&mut self, nodes: usize) -> Result<Budget, usize> {
        let (mut small, mut large) = (0.0, self.max_size());
        for _ in 0..40 {
            self.set_fine_size(0.5 * (small + large));
            if self.real_budget().total() > nodes as f64 {
                small = self.fine_size;
            } else {
                large = self.fine_size;
            }
        }
        // Whole numbers on edges and faces may add up to more than `nodes`: a slightly larger
        // element prevents that.
        while large < self.max_size() {
            self.set_fine_size(large);
            if let Ok(budget) = self.round(nodes) {
                return Ok(budget);
            }
            large *= 1.01;
        }
        self.set_fine_size(self.max_size());
        self.round(nodes)
    }

    fn set_fine_size(&mut self, fine_size: f64) {
        self.fine_size = fine_size;
        self.growth = (GROWTH * (fine_size / self.fine_radius).sqrt()).min(MAX_GROWTH);
    }

    fn real_budget(&self) -> RealBudget {
        let edges = std::array::from_fn(|e| (self.integral(edge_axes(e)) - 1.0).max(0.0));
        let faces = std::array::from_fn(|f| self.face_nodes(f, &edges));
        RealBudget { edges, faces, volume: self.volume_nodes(&edges, &faces) }
    }

    /// The budget in whole nodes, of which the rest goes to the volume; `Err` is the number that
    /// corners, edges and faces alone need.
    fn round(&self, nodes: usize) -> Result<Budget, usize> {
        let edges: [f64; 12] = std::array::from_fn(|e| (self.integral(edge_axes(e)) - 0.5).max(0.0).floor());
        let faces: [f64; 6] = std::array::from_fn(|f| (self.face_nodes(f, &edges) + 0.5).floor());
        let surface = 8 + (edges.iter().sum::<f64>() + faces.iter().sum::<f64>()) as usize;
        Ok(Budget {
            edges: edges.map(|n| n as usize),
            faces: faces.map(|n| n as usize),
            circle: 0,
            shell: 0,
            volume: nodes.checked_sub(surface).ok_or(surface)?,
        })
    }

    /// The budget that the given sizes require, with a shell.
    pub fn with_shell(&self) -> Budget {
        let asked = Self { fine_size: LONGER * self.fine_size, growth: LONGER * self.growth, ..*self };
        let RealBudget { edges, faces, volume } = asked.real_budget();
        let [along, area] = asked.shell_elements();
        let circle = along.round();
        let shell = (PER_AREA * area - 0.5 * circle).max(1.0).round();
        let whole = |n: f64| n.round() as usize;
        let mut budget = Budget {
            edges: edges.map(whole),
            faces: faces.map(whole),
            circle: circle as usize,
            shell: shell as usize,
            volume: (volume - shell).max(0.0).round() as usize,
        };
        budget.faces[TOP] = budget.faces[TOP].saturating_sub(budget.circle);
        budget
    }

    /// Number of nodes inside a face. A node on one of its edges already fills half a cell of the
    /// face, and a corner a quarter; these are subtracted.
    fn face_nodes(&self, face: usize, edges: &[f64; 12]) -> f64 {
        let rim: f64 = (0..12).filter(|e| edge_on_face(*e, face)).map(|e| edges[e]).sum();
        (PER_AREA * self.integral(face_axes(face)) - 0.5 * rim - 1.0).max(0.0)
    }

    fn volume_nodes(&self, edges: &[f64; 12], faces: &[f64; 6]) -> f64 {
        let skin = 0.5 * faces.iter().sum::<f64>() + 0.25 * edges.iter().sum::<f64>() + 1.0;
        (PER_VOLUME * self.integral([Span::Free; 3]) - skin).max(0.0)
    }

    /// Integral of `size^-d` over the d free axes: the number of elements along an edge, on a face
    /// or in the volume.
    fn integral(&self, axes: [Span; 3]) -> f64 {
        let [xs, ys, zs] = std::array::from_fn(|k| self.samples(k, axes[k]));
        let free = axes.iter().filter(|a| **a == Span::Free).count();
        let mut sum = 0.0;
        for &(x, wx) in &xs {
            for &(y, wy) in &ys {
                for &(z, wz) in &zs {
                    let size = self.size_at([x, y, z]);
                    sum += wx * wy * wz / (0..free).fold(1.0, |s, _| s * size);
                }
            }
        }
        sum
    }

    /// Points and weights of a midpoint rule that is denser toward the fine spot: x = spot + reach
    /// t^2.
    fn samples(&self, axis: usize, span: Span) -> Vec<(f64, f64)> {
        let mut samples = vec![];
        let count = if self.shell.is_some() { SHELL_SAMPLES } else { SAMPLES };
        for end in [self.low[axis], self.high[axis]] {
            let reach = end - self.spot[axis];
            for i in 0..count {
                let t = (i as f64 + 0.5) / count as f64;
                samples.push((self.spot[axis] + reach * t * t, 2.0 * t * reach.abs() / count as f64));
            }
        }
        match span {
            Span::Low => vec![(self.low[axis], 1.0)],
            Span::High => vec![(self.high[axis], 1.0)],
            Span::Free => samples.into_iter().filter(|s| s.1 > 0.0).collect(),
        }
    }
}

struct RealBudget {
    edges: [f64; 12],
    faces: [f64; 6],
    volume: f64,
}

impl RealBudget {
    fn total(&self) -> f64 {
        8.0 + self.edges.iter().sum::<f64>() + self.faces.iter().sum::<f64>() + self.volume
    }
}

/// Index of the face z = 0 for [`face_axes`].
const TOP: usize = 5;

/// Extent of a face, an edge or the volume along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Span {
    Low,
    High,
    Free,
}

/// Edge `e` runs along axis `e / 4`; bits 0 and 1 of `e` put it on the high side of the other two
/// axes.
pub(super) fn edge_axes(e: usize) -> [Span; 3] {
    let side = |bit: usize| if e & bit == 0 { Span::Low } else { Span::High };
    match e / 4 {
        0 => [Span::Free, side(1), side(2)],
        1 => [side(1), Span::Free, side(2)],
        _ => [side(1), side(2), Span::Free],
    }
}

/// Face `f` is the low (even) or high (odd) side of axis `f / 2`.
pub(super) fn face_axes(f: usize) -> [Span; 3] {
    let mut axes = [Span::Free; 3];
    axes[f / 2] = if f % 2 == 1 { Span::High } else { Span::Low };
    axes
}

fn edge_on_face(e: usize, f: usize) -> bool {
    edge_axes(e)[f / 2] == face_axes(f)[f / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_cube(fine_radius: f64) -> Grading {
        let (low, high) = ([-0.5, -0.5, -1.0], [0.5, 0.5, 0.0]);
        Grading { low, high, spot: [0.0; 3], shell: None, fine_radius, fine_size: 0.0, growth: 0.0 }
    }

    #[test]
    fn every_budget_adds_up() {
        for nodes in (30..300).step_by(9) {
            let Budget { edges, faces, volume, .. } = unit_cube(0.1).fit(nodes).unwrap();
            assert_eq!(8 + edges.iter().sum::<usize>() + faces.iter().sum::<usize>() + volume, nodes);
        }
    }

    #[test]
    fn more_nodes_are_finer_everywhere() {
        let fitted = |nodes| {
            let mut grading = unit_cube(0.1);
            grading.fit(nodes).unwrap();
            grading
        };
        let (coarse, fine) = (fitted(200), fitted(400));
        for p in [[0.0; 3], [0.2, 0.0, -0.1], [0.5, 0.5, -1.0]] {
            assert!(fine.size_at(p) < coarse.size_at(p));
        }
    }

    #[test]
    fn quadrature_integrates_a_uniform_size_to_its_element_counts() {
        // A fine radius beyond the block makes the size uniform; the midpoint rule in t is exact
        // for constants.
        let mut grading = unit_cube(10.0);
        grading.set_fine_size(0.25);
        for (axes, elements) in [(edge_axes(5), 4.0), (face_axes(5), 16.0), ([Span::Free; 3], 64.0)] {
            assert!((grading.integral(axes) - elements).abs() < 1e-12 * elements);
        }
    }
}
