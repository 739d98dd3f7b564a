//! Nodes of the elements, and the places of their stiffness in a sparse matrix.

use super::{Cylinder, shape};
use crate::reference::cholesky::Cholesky;
use crate::reference::elimination::eliminate;

/// Width of elements near the edge of the contact over that of the others under the ball (1), and
/// how far from the edge they are so narrow, divided by the contact radius (1).
const EDGE: f64 = 0.25;
const EDGE_WIDTH: f64 = 0.1;
/// Growth of the elements' size with the distance from the fine ones, divided by the fineness (1),
/// so that finer elements are finer everywhere.
const GROWTH: f64 = 3.2;
/// Radius up to which elements keep their size when the others are fitted to the cylinder, and
/// depth of the fine ones, divided by the contact radius (1).
const FINE: [f64; 2] = [1.15, 0.5];

/// Boundaries of elements from 0 to `length`, of about `size(place)` up to `near`; beyond it they
/// shrink together to end at `length`.
fn graded(length: f64, near: f64, size: impl Fn(f64) -> f64) -> Vec<f64> {
    let (mut at, mut end, mut kept) = (vec![0.0], 0.0, 0.0);
    while end < length {
        // the size at either end of an element counts
        let step = size(end);
        end += step.min(size(end + step));
        at.push(end);
        if end <= near.min(0.9 * length) {
            kept = end;
        }
    }
    at.iter().map(|x| if *x <= kept { *x } else { kept + (x - kept) * (length - kept) / (end - kept) }).collect()
}

/// Nodes of the elements for one contact radius.
pub(super) struct Mesh<'a> {
    pub of: &'a Cylinder,
    /// Positions of the columns and rows of nodes [m].
    pub r_m: Vec<f64>,
    pub z_m: Vec<f64>,
    /// Whether an unknown is zero.
    pub fixed: Vec<bool>,
    /// First entry of each node's two columns in the lower triangle of the tangent.
    start: Vec<usize>,
}

/// Displacements of a mesh [m] in equilibrium at a depth [m].
pub(super) struct Pressed<'a> {
    pub mesh: Mesh<'a>,
    pub u: Vec<f64>,
    pub depth_m: f64,
    pub contact_m: f64,
}

impl Pressed<'_> {
    /// Growth of the contact to another depth [m] by the law of Hertz (1).
    pub fn growth(&self, depth_m: f64) -> f64 {
        (depth_m / self.depth_m).sqrt()
    }
}

/// First and last of the nodes on a line with which one shares an element.
fn neighbours(node: usize, count: usize) -> [usize; 2] {
    let reach = 2 - node % 2;
    [node.saturating_sub(reach), (node + reach).min(count - 1)]
}

impl<'a> Mesh<'a> {
    pub fn new(of: &'a Cylinder, contact_m: f64) -> Self {
        let fine_m = of.fineness * contact_m;
        // a slab may be thinner than the contact is wide
        let tall_m = contact_m.min(of.height_m);
        let (near_m, below_m) = (FINE[0] * contact_m, FINE[1] * tall_m);
        let grown_m = |beyond_m: f64| GROWTH * of.fineness * beyond_m.max(0.0);
        // the pressure ends like a square root, which shape functions miss
        let width_m = |r: f64| EDGE * fine_m + grown_m((r - contact_m).abs() - EDGE_WIDTH * contact_m);
        let width_m = |r: f64| width_m(r).min(if r < contact_m { fine_m } else { f64::MAX });
        let halved = |at: Vec<f64>| {
            let mut nodes = vec![0.0];
            at.windows(2).for_each(|pair| nodes.extend([pair[0].midpoint(pair[1]), pair[1]]));
            nodes
        };
        let r_m = halved(graded(of.radius_m, near_m, width_m));
        let z_m = halved(graded(of.height_m, below_m, |z| of.fineness * tall_m + grown_m(z - below_m)));
        let mut mesh = Self { of, r_m, z_m, fixed: Vec::new(), start: vec![0] };
        let (columns, rows) = (mesh.r_m.len(), mesh.z_m.len());
        let is_fixed = |n: usize| [n < rows || (n + 1).is_multiple_of(rows), (n + 1).is_multiple_of(rows)];
        mesh.fixed = (0..columns * rows).flat_map(is_fixed).collect();
        for n in 0..columns * rows {
            mesh.start.push(mesh.start[n] + 4 * mesh.below(n).count());
        }
        mesh
    }

    pub fn unknowns(&self) -> usize {
        2 * self.r_m.len() * self.z_m.len()
    }

    /// Displacements at another depth [m], if all lengths grow as the contact radius and those of
    /// the last two equilibria change on at the same rate; `None` without an equilibrium.
    pub fn grown_from(&self, found: &[Pressed], depth_m: f64) -> Option<Vec<f64>> {
        let (last, before) = found.split_last()?;
        let grown = self.grown(last, depth_m);
        let Some(before) = before.last() else { return Some(grown) };
        // all depends on the contact radius
        let [from, last, to] = [before.depth_m, last.depth_m, depth_m].map(f64::sqrt);
        let beyond = (to - last) / (last - from);
        Some(grown.iter().zip(self.grown(before, depth_m)).map(|(last, before)| last + beyond * (last - before)).collect())
    }

    fn grown(&self, from: &Pressed, depth_m: f64) -> Vec<f64> {
        let (other, growth, deeper) = (&from.mesh, from.growth(depth_m), depth_m / from.depth_m);
        // first node of the element around a place, and the shape functions there
        let around = |at: &[f64], x: f64| {
            let first = ((at.partition_point(|node| *node < x).max(1) - 1) / 2 * 2).min(at.len() - 3);
            let half = 0.5 * (at[first + 2] - at[first]);
            (first, shape((x - at[first + 1]) / half).map(|s| s[0]))
        };
        let rows: Vec<(usize, [f64; 3])> = self.z_m.iter().map(|z| around(&other.z_m, z / growth)).collect();
        let mut grown = Vec::with_capacity(self.unknowns());
        for (column, p) in self.r_m.iter().map(|r| around(&other.r_m, r / growth)) {
            for (row, q) in &rows {
                grown.extend([0, 1].map(|k| {
                    let of = |n: usize| p[n / 3] * q[n % 3] * from.u[2 * other.node(column + n / 3, row + n % 3) + k];
                    if self.fixed[grown.len() + k] { 0.0 } else { deeper * (0..9).map(of).sum::<f64>() }
                }));
            }
        }
        grown
    }

    pub fn node(&self, column: usize, row: usize) -> usize {
        column * self.z_m.len() + row
    }

    /// A node and those with higher numbers with which it shares an element, ascending.
    fn below(&self, node: usize) -> impl Iterator<Item = usize> {
        let rows = self.z_m.len();
        let (column, row) = (node / rows, node % rows);
        let [up, down] = neighbours(row, rows);
        let last = neighbours(column, self.r_m.len())[1];
        (column..=last).flat_map(move |c| (up..=down).map(move |r| c * rows + r)).filter(move |other| *other >= node)
    }

    /// Number of entries of the lower triangle.
    pub fn entries(&self) -> usize {
        self.start.last().copied().unwrap_or(0)
    }

    /// Entry of two unknowns, the first of which belongs to the same node or to a later one.
    pub fn entry(&self, i: usize, j: usize) -> usize {
        let (node, other, rows) = (j / 2, i / 2, self.z_m.len());
        let (row, [up, down]) = (node % rows, neighbours(node % rows, rows));
        let columns = other / rows - node / rows;
        // the first column of nodes begins at the node itself
        let at = if columns == 0 { other - node } else { columns * (down - up + 1) + other % rows - row };
        self.start[node] + (self.start[node + 1] - self.start[node]) / 2 * (j % 2) + 2 * at + i % 2
    }

    /// Analyses the tangent; `None` if there is not enough memory.
    pub fn analyse(&self) -> Option<Cholesky> {
        let below: Vec<Vec<u32>> = (0..self.unknowns() / 2).map(|n| self.below(n).map(|m| m as u32).collect()).collect();
        let order = eliminate(below.len(), |n| &below[n][1..], &[])?;
        let (mut start, mut row) = (vec![0], Vec::with_capacity(self.entries()));
        for rows in &below {
            for _ in 0..2 {
                row.extend(rows.iter().flat_map(|n| [2 * *n as usize, 2 * *n as usize + 1]));
                start.push(row.len());
            }
        }
        Cholesky::analyse(start, row, order.into_iter().flat_map(|n| [2 * n as usize, 2 * n as usize + 1]).collect())
    }
}
