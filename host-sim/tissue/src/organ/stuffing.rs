//! Isosurface stuffing: cuts a lattice to an implicit shape (Labelle and Shewchuk, "Isosurface
//! Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles", 2007).
//!
//! Every lattice edge from inside to outside has a cut point, here found on the straight edge by
//! bisection. A lattice point that is too near to cuts moves onto the nearest of them. Then the
//! tets are cut ([`split`]). The thresholds are the paper's, for which it proves dihedral angles of
//! 10.7 to 164.8 degrees on a uniform lattice, whatever the shape. For a growing lattice there is
//! no such bound.

use std::collections::{BTreeMap, BTreeSet};

use super::OrganError;
use super::balls::Balls;
use super::lattice::{LONG, Lattice, NEIGHBOURS, is_even, tets_around};
use super::parts::V3;
use super::sound;
use super::split::{Cell, Part, Side};
use crate::mesh::TetMesh;

/// Share of a long edge within which a cut attracts the lattice point (1).
const NEAR_LONG: f64 = 0.24999;
/// Share of a short edge within which a cut attracts the lattice point (1).
const NEAR_SHORT: f64 = 0.41189;

/// Number of bisections of an edge: they locate the cut to the last bits of a position.
const HALVINGS: u32 = 44;
/// Largest number of chords, and of steps from the last one to the point where bisections end.
const CHORDS: u32 = 12;
const NEAR_STEPS: u32 = 4;
/// Share of an edge to which bisections locate the cut (1).
const EXACT_SHARE: f64 = 1.0 / (1_u64 << HALVINGS) as f64;

/// Point at which the surface crosses a lattice edge.
struct Cut {
    at: V3,
    /// Distance of the cut from the end of the edge with the smaller index, as a share of the edge
    /// (1).
    share: f64,
}

struct Stuffing<'a> {
    lattice: &'a Lattice,
    sides: Vec<Side>,
    /// Lattice points that were moved onto a cut, with their new positions.
    moved: BTreeMap<u32, V3>,
    /// Cuts by the indices of the lattice points at both ends of their edges, the smaller first.
    cuts: BTreeMap<[u32; 2], Cut>,
}

/// Meshes the inside of a shape, with regions 0, and checks that the mesh has the topology of a
/// ball.
pub(super) fn stuff(organ: &str, implicit: &dyn Fn(V3) -> f64, lattice: &Lattice) -> Result<TetMesh, OrganError> {
    let mesh = cut_out(organ, implicit, lattice)?;
    match sound::defect(&mesh.tets) {
        Some(defect) => Err(OrganError::TooCoarse { organ: organ.to_owned(), spacing_m: lattice.spacing_m, defect }),
        None => Ok(mesh),
    }
}

/// Meshes the inside of a shape that may have holes through it and internal cavities, with regions
/// 0, and checks that the mesh is one piece and nowhere touches itself along an edge.
pub(super) fn stuff_any(name: &str, shape: Shape, lattice: &Lattice) -> Result<TetMesh, OrganError> {
    let mesh = cut(name, shape, lattice)?;
    match sound::torn(&mesh.tets) {
        Some(defect) => Err(OrganError::TooCoarse { organ: name.to_owned(), spacing_m: lattice.spacing_m, defect }),
        None => Ok(mesh),
    }
}

/// Meshes the inside of a shape, with regions 0, without checking its topology.
pub(super) fn cut_out(organ: &str, implicit: &dyn Fn(V3) -> f64, lattice: &Lattice) -> Result<TetMesh, OrganError> {
    cut(organ, Shape { implicit, is_distance: false }, lattice)
}

/// An implicit shape.
#[derive(Clone, Copy)]
pub(super) struct Shape<'a> {
    pub implicit: &'a dyn Fn(V3) -> f64,
    /// Whether its values are distances [m], so that a ball of that radius is on one side.
    pub is_distance: bool,
}

impl Shape<'_> {
    /// Share of the way `from` a point inside `to` one outside at which the surface is.
    fn cut(&self, from: V3, to: V3) -> f64 {
        let value = |share: f64| (self.implicit)(from + (to - from) * share);
        if let Some(share) = self.is_distance.then(|| chord(&value)).flatten() {
            return share;
        }
        let (mut inner, mut outer) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inner + outer);
            if value(middle) < 0.0 { inner = middle } else { outer = middle }
        }
        0.5 * (inner + outer)
    }
}

/// The share that bisections find, by chords: along an edge a distance is nearly straight.
fn chord(value: &impl Fn(f64) -> f64) -> Option<f64> {
    let (mut inner, mut outer) = (0.0, 1.0);
    let (mut below, mut above) = (value(inner), value(outer));
    let mut share = 0.5;
    for _ in 0..CHORDS {
        share = inner + (outer - inner) * below / (below - above);
        if !(share > inner && share < outer) {
            break;
        }
        let at = value(share);
        if at.abs() <= EXACT_SHARE * (above - below) {
            break;
        }
        // the end that stays counts for half, or the chord would creep toward it (Illinois)
        if at < 0.0 {
            (inner, below, above) = (share, at, 0.5 * above);
        } else {
            (outer, above, below) = (share, at, 0.5 * below);
        }
    }
    // between the same two points that bisections end at
    let mut step = (share / EXACT_SHARE).floor();
    for _ in 0..NEAR_STEPS {
        match [step, step + 1.0].map(|n| value(n * EXACT_SHARE) < 0.0) {
            [true, false] => return Some((step + 0.5) * EXACT_SHARE),
            [true, true] => step += 1.0,
            _ => step -= 1.0,
        }
    }
    None
}

fn cut(organ: &str, shape: Shape, lattice: &Lattice) -> Result<TetMesh, OrganError> {
    let Shape { implicit, is_distance } = shape;
    let mut sides = vec![Side::Out; lattice.len()];
    let mut balls = Balls::new(is_distance);
    for triple in lattice.points() {
        if let Some(name) = lattice.name(triple) {
            let value = balls.value_m(lattice.place(triple), implicit);
            sides[name as usize] = if value < 0.0 {
                Side::In
            } else if value > 0.0 {
                Side::Out
            } else {
                Side::On
            };
        }
    }
    let mut stuffing = Stuffing { lattice, sides, moved: BTreeMap::new(), cuts: BTreeMap::new() };
    stuffing.find_cuts(shape);
    stuffing.draw_points();
    let tets = stuffing.tets();
    if tets.is_empty() {
        return Err(OrganError::Empty { organ: organ.to_owned(), spacing_m: lattice.spacing_m });
    }
    let mesh = stuffing.numbered(&tets);
    let inverted = mesh.tets.iter().filter(|tet| sound::six_volumes(&mesh, **tet) <= 0.0).count();
    if inverted > 0 {
        return Err(OrganError::Inverted { organ: organ.to_owned(), tets: inverted, all: mesh.tets.len() });
    }
    Ok(mesh)
}

impl Stuffing<'_> {
    fn neighbours(&self, name: u32) -> impl Iterator<Item = (usize, u32)> {
        let triple = self.lattice.triple(name);
        NEIGHBOURS.iter().enumerate().filter_map(move |(way, step)| {
            let other = std::array::from_fn(|k| triple[k] + step[k]);
            Some((way, self.lattice.name(other)?))
        })
    }

    fn find_cuts(&mut self, shape: Shape) {
        let mut cuts = BTreeMap::new();
        for name in self.lattice.points().filter_map(|t| self.lattice.name(t)) {
            if self.sides[name as usize] != Side::In {
                continue;
            }
            for (_, other) in self.neighbours(name).filter(|(_, other)| self.sides[*other as usize] == Side::Out) {
                let (from, to) = (self.lattice.place(self.lattice.triple(name)), self.lattice.place(self.lattice.triple(other)));
                let share = shape.cut(from, to);
                let cut = Cut { at: from + (to - from) * share, share: if name < other { share } else { 1.0 - share } };
                cuts.insert(edge(name, other), cut);
            }
        }
        self.cuts = cuts;
    }

    /// Moves points, one by one, onto cuts that are too near to them; the edges of a moved point
    /// are no longer cut.
    fn draw_points(&mut self) {
        let ends: BTreeSet<u32> = self.cuts.keys().flatten().copied().collect();
        for name in ends {
            let around: Vec<_> = self.neighbours(name).collect();
            let near = around.iter().filter_map(|(way, other)| {
                let cut = self.cuts.get(&edge(name, *other))?;
                let share = if name < *other { cut.share } else { 1.0 - cut.share };
                let nearness = share / if *way < LONG { NEAR_LONG } else { NEAR_SHORT };
                (nearness < 1.0).then_some((nearness, cut.at))
            });
            if let Some((_, at)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) {
                self.moved.insert(name, at);
                self.sides[name as usize] = Side::On;
                for (_, other) in around {
                    self.cuts.remove(&edge(name, other));
                }
            }
        }
    }

    fn tets(&self) -> Vec<[Node; 4]> {
        let mut tets = Vec::new();
        let even_points = self.lattice.points().filter(|[i, ..]| i & 1 == 0);
        for triples in even_points.flat_map(|point| (0..3).flat_map(move |axis| tets_around(point, axis))) {
            let [Some(a), Some(b), Some(c), Some(d)] = triples.map(|t| self.lattice.name(t)) else {
                continue;
            };
            let names = [a, b, c, d];
            let cell = Cell { sides: names.map(|n| self.sides[n as usize]), even: triples.map(is_even) };
            if !cell.sides.contains(&Side::In) {
                continue;
            }
            let node = |part| match part {
                Part::Corner(k) => Node::Point(names[k]),
                Part::Cut(k, l) => Node::Cut(edge(names[k], names[l])),
            };
            let square = |[a, b]: [Part; 2]| (self.place(node(a)) - self.place(node(b))).norm_squared();
            let parts = cell.inside(|a, b| square(a) <= square(b));
            tets.extend(parts.into_iter().map(|tet| tet.map(node)));
        }
        tets
    }

    fn place(&self, node: Node) -> V3 {
        match node {
            Node::Point(name) => self.moved.get(&name).copied().unwrap_or_else(|| self.lattice.place(self.lattice.triple(name))),
            // every named cut exists; a missing one would appear as a flat tet
            Node::Cut(edge) => self.cuts.get(&edge).map_or_else(V3::zeros, |cut| cut.at),
        }
    }

    /// Numbers the nodes in use, in rising order of their names.
    fn numbered(&self, tets: &[[Node; 4]]) -> TetMesh {
        let mut nodes: Vec<Node> = tets.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let number = |node: Node| nodes.partition_point(|n| *n < node) as u32;
        TetMesh {
            nodes_m: nodes.iter().map(|n| self.place(*n).into()).collect(),
            tets: tets.iter().map(|tet| tet.map(number)).collect(),
            regions: vec![0; tets.len()],
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Node {
    Point(u32),
    Cut([u32; 2]),
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_volume_of_a_ball_comes_out_with_the_square_of_the_spacing() {
        // chords of a sphere: the deficit is proportional to the square of the edge
        let ball = |x: V3| x.norm() - 0.03;
        let volume_m3 = 4.0 / 3.0 * std::f64::consts::PI * 0.03_f64.powi(3);
        let deficit = |spacing_m| {
            let lattice = Lattice::uniform(spacing_m, [[-0.03; 3], [0.03; 3]], 0.0).unwrap();
            let mesh = stuff("ball", &ball, &lattice).unwrap();
            let six: f64 = mesh.tets.iter().map(|t| sound::six_volumes(&mesh, *t)).sum();
            1.0 - six / 6.0 / volume_m3
        };
        let (coarse, fine) = (deficit(0.008), deficit(0.004));
        assert!(coarse > 0.0 && coarse < 0.04, "{coarse}");
        assert!((3.4..4.6).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn chords_cut_where_bisections_do() {
        let middle = V3::new(0.001, 0.002, -0.003);
        let ball = |x: V3| (x - middle).norm() - 0.03;
        let slab = |x: V3| (x.x + 0.3 * x.y).abs() / 1.09_f64.sqrt() - 0.005;
        for implicit in [&ball as &dyn Fn(V3) -> f64, &slab] {
            for seed in 0..2000 {
                let wave = |k: f64| (f64::from(seed) * k).sin();
                let from = V3::new(0.004 * wave(1.3), 0.004 * wave(2.1), 0.004 * wave(0.7));
                let to = from + 0.02 * V3::new(wave(3.3), wave(0.4), wave(5.1));
                if implicit(from) < 0.0 && implicit(to) > 0.0 {
                    let shares = [true, false].map(|is_distance| Shape { implicit, is_distance }.cut(from, to));
                    assert_eq!(shares[0], shares[1], "{from} {to}");
                }
            }
            let from = V3::new(0.0, 0.0, 0.0);
            let to = V3::new(0.01, 0.0, 0.0) * 1.09_f64.sqrt();
            let shares = [true, false].map(|is_distance| Shape { implicit: &slab, is_distance }.cut(from, to));
            assert_eq!(shares[0], shares[1]);
        }
    }

    #[test]
    fn a_ring_and_two_balls_are_refused() {
        let lattice = Lattice::uniform(0.004, [[-0.04; 3], [0.04; 3]], 0.0).unwrap();
        let ring = |x: V3| ((x.x * x.x + x.y * x.y).sqrt() - 0.025).hypot(x.z) - 0.01;
        let balls = |x: V3| (x - V3::new(0.02, 0.0, 0.0)).norm().min((x + V3::new(0.02, 0.0, 0.0)).norm()) - 0.012;
        assert!(matches!(stuff("ring", &ring, &lattice), Err(OrganError::TooCoarse { .. })));
        assert!(matches!(stuff("balls", &balls, &lattice), Err(OrganError::TooCoarse { .. })));
    }
}
