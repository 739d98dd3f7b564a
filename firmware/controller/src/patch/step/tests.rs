//! Compares the check with sums in double precision, in which the gradients of a tet's volume are
//! finite differences over displaced corners.

use std::boxed::Box;
use std::vec::Vec;

use palpate::{NodeRest, PatchFile, RimEdge, RimNode, Spring, Tet};

use super::*;
use crate::patch::{Memory, WordAligned};

/// A patch with masses relative to neighbours and four foundation points per triangle, one with
/// nine points, and one that was cut out of an organ.
static FINE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m7-480.patch"));
static COARSE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m4f-168.patch"));
static LIVER: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/liver-m4f-168.patch"));

/// A patch whose check receives other springs, tets or nodes than those from which its masses were
/// computed.
struct Judged {
    file: PatchFile<'static>,
    /// Compensation that is passed to the check.
    compensation: f32,
    memory: Box<Memory>,
}

impl Judged {
    fn of(bytes: &'static WordAligned<[u8]>) -> Self {
        let file = PatchFile::open(&bytes.0).unwrap();
        Self { compensation: file.params.compensation, file, memory: Box::new(Memory::RESERVED) }
    }

    /// Checks `model` with the masses that belong to the unchanged file.
    fn check(&mut self, model: &Model<'_>) -> Result<(), BuildError> {
        let (tuned, scratch) = self.memory.judge(&self.file.model, &self.file.params, &mut || {}).unwrap();
        let params = Params { compensation: self.compensation, ..self.file.params };
        check(model, &params, &tuned, scratch, &mut || {})
    }

    /// Checks the file with changed springs, tets or nodes, and unchanged masses.
    fn with(
        &mut self,
        springs: impl FnOnce(&mut [Spring]),
        tets: impl FnOnce(&mut [Tet]),
        nodes: impl FnOnce(&mut [NodeRest]),
    ) -> Result<(), BuildError> {
        let model = self.file.model;
        let (mut s, mut t, mut n) = (model.springs.to_vec(), model.tets.to_vec(), model.nodes.to_vec());
        springs(&mut s);
        tets(&mut t);
        nodes(&mut n);
        self.check(&Model { springs: &s, tets: &t, nodes: &n, ..model })
    }
}

fn six_volumes_m3(corners: [[f64; 3]; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let from_a = |corner: [f64; 3]| [corner[0] - a[0], corner[1] - a[1], corner[2] - a[2]];
    let [u, v, w] = [b, c, d].map(from_a);
    (0..3).map(|k| u[k] * (v[(k + 1) % 3] * w[(k + 2) % 3] - v[(k + 2) % 3] * w[(k + 1) % 3])).sum()
}

/// Mean diagonal stiffness under load, divided by E, of every node [m].
fn stiffness_m(model: &Model<'_>, compensation: f32) -> Vec<f64> {
    let mut sums = std::vec![0.0; model.nodes.len()];
    for spring in model.springs {
        for node in [spring.i, spring.j] {
            sums[usize::from(node)] += f64::from(spring.k) * (1.0 + f64::from(compensation)) / 3.0;
        }
    }
    for tet in model.tets {
        let corners = tet.node.map(|node| model.nodes[usize::from(node)].rest_m.map(f64::from));
        let mut per_square = (f64::from(tet.bulk) + 2.5 * f64::from(tet.barrier)) * f64::from(tet.six_volume_reciprocal);
        for node in tet.node.map(|node| model.nodes[usize::from(node)]) {
            per_square += 0.5 * f64::from(node.pressure) * f64::from(node.six_volume_reciprocal);
        }
        for (own, node) in tet.node.iter().enumerate() {
            for axis in 0..3 {
                let moved = |by_m: f64| {
                    let mut corners = corners;
                    corners[own][axis] += by_m;
                    six_volumes_m3(corners)
                };
                let slope = (moved(1e-3) - moved(-1e-3)) / 2e-3;
                sums[usize::from(*node)] += per_square * slope * slope / 3.0;
            }
        }
    }
    for rim in model.rim_nodes {
        let [xx, yy, zz, xy, xz, yz] = rim.block_m.map(f64::from);
        let square: f64 = [xx, xy, xz, xy, yy, yz, xz, yz, zz].iter().map(|entry| entry * entry).sum();
        sums[rim.node as usize] += (square / 3.0).sqrt();
    }
    for edge in model.rim_edges {
        let square: f64 = edge.block_m.iter().map(|entry| f64::from(*entry).powi(2)).sum();
        edge.node.iter().for_each(|node| sums[usize::from(*node)] += (square / 3.0).sqrt());
    }
    sums
}

#[test]
fn the_floor_of_every_node_is_its_mass_over_its_stiffness_under_load() {
    for bytes in [FINE, COARSE, LIVER] {
        let mut judged = Judged::of(bytes);
        // stiff enough for every node to be too light
        judged.compensation = 400.0;
        let nodes = judged.file.model.nodes.len() as u16;
        let entry = |n: u16, k: usize| 1e-3 * (f32::from(n) + 2.7 * k as f32).sin();
        let rim_nodes: Vec<RimNode> = (0..nodes)
            .step_by(2)
            .map(|n| RimNode { node: n.into(), block_m: std::array::from_fn(|k| entry(n, k) + if k < 3 { 2e-3 } else { 0.0 }) })
            .collect();
        let rim_edges: Vec<RimEdge> = (0..nodes - 1)
            .step_by(3)
            .map(|n| RimEdge { node: [n, n + 1], block_m: std::array::from_fn(|k| entry(n, k)) })
            .collect();
        let model = Model { rim_nodes: &rim_nodes, rim_edges: &rim_edges, ..judged.file.model };
        let stiffness_m = stiffness_m(&model, judged.compensation);
        let yields: Vec<f64> = {
            let (tuned, _) = judged.memory.judge(&judged.file.model, &judged.file.params, &mut || {}).unwrap();
            let gains = tuned.gains();
            let each = |node: &palpate::NodeStep| {
                let fields: f64 = node.smooth.iter().zip(gains).map(|(at, gain)| f64::from(gain) * f64::from(*at).powi(2)).sum();
                (f64::from(node.step) + fields) * f64::from(tuned.substep_s())
            };
            tuned.node_step().iter().map(each).collect()
        };
        let all: Vec<u16> = (0..model.nodes.len() as u16).collect();
        let mut judged_nodes = 0;
        for &alone in all.iter().filter(|node| model.anchors.binary_search(node).is_err()) {
            let anchors: Vec<u16> = all.iter().copied().filter(|node| *node != alone).collect();
            let answer = judged.check(&Model { anchors: &anchors, ..model });
            let Err(BuildError::OutOfRange { parameter: FLOOR, value, .. }) = answer else { panic!("{alone}: {answer:?}") };
            let n = usize::from(alone);
            let right = 1.0 / (yields[n] * stiffness_m[n]);
            assert!((f64::from(value) / right - 1.0).abs() < 1e-3, "node {alone}: {value} for {right}");
            judged_nodes += 1;
        }
        assert!(judged_nodes > 20);
    }
}

#[test]
fn constants_that_contradict_the_rest_shape_are_named() {
    let refused = |item, index| Err(BuildError::Degenerate { item, index });
    let mut patch = Judged::of(COARSE);
    assert_eq!(patch.with(|_| (), |_| (), |_| ()), Ok(()));
    for (times, taken) in [(1.004, true), (0.996, true), (1.006, false), (0.994, false)] {
        let said = patch.with(|springs| springs[7].k_rest *= times, |_| (), |_| ());
        assert_eq!(said, if taken { Ok(()) } else { refused("spring length", 7) }, "{times}");
    }
    for (times, taken) in [(1.009, true), (0.991, true), (1.011, false), (0.989, false)] {
        let expected = |item, index| if taken { Ok(()) } else { refused(item, index) };
        let said = patch.with(|_| (), |tets| tets[5].six_volume_reciprocal *= times, |_| ());
        assert_eq!(said, expected("tet volume", 5), "{times}");
        let said = patch.with(|_| (), |_| (), |nodes| nodes[3].volume_m3 *= times);
        assert_eq!(said, expected("node volume", 3), "{times}");
        let both = |nodes: &mut [NodeRest]| {
            nodes[3].volume_m3 /= times;
            nodes[3].six_volume_reciprocal *= times;
        };
        assert_eq!(patch.with(|_| (), |_| (), both), expected("node volume", 3), "{times}");
    }
    assert_eq!(patch.with(|_| (), |tets| tets[4].bulk = -1e-9, |_| ()), refused("tet volume", 4));
    assert_eq!(patch.with(|_| (), |tets| tets[4].barrier = -1e-9, |_| ()), refused("tet volume", 4));
    assert_eq!(patch.with(|_| (), |tets| (tets[4].bulk, tets[4].barrier) = (0.0, 0.0), |_| ()), Ok(()));
    let of_node = patch.file.model.tets.iter().position(|tet| tet.node.contains(&3)).unwrap();
    assert_eq!(patch.with(|_| (), |_| (), |nodes| nodes[3].pressure = -1e-9), refused("node pressure", of_node));
    assert_eq!(patch.with(|_| (), |_| (), |nodes| nodes[3].pressure = 0.0), Ok(()));
}

#[test]
fn the_foundation_is_held_to_twenty_times_the_tissue() {
    for bytes in [FINE, COARSE] {
        let mut patch = Judged::of(bytes);
        let model = patch.file.model;
        let points = model.points_per_triangle();
        let own_m = stiffness_m(&model, patch.compensation);
        let mut slopes_m = std::vec![0.0; model.nodes.len()];
        let stiffened = 1.0 + 2.0 * f64::from(model.stiffening_per_m) * f64::from(model.depth_limit_m);
        for (t, triangle) in model.triangles.iter().enumerate() {
            for (p, weights) in point_weights(points).iter().enumerate() {
                for (node, weight) in triangle.node.iter().zip(weights) {
                    let k = f64::from(model.foundation[t * points + p].k);
                    slopes_m[usize::from(*node)] += f64::from(*weight) * k * stiffened;
                }
            }
        }
        let over: Vec<f64> = slopes_m.iter().zip(&own_m).map(|(slope, own)| slope / own).collect();
        let most = over.iter().copied().fold(0.0, f64::max);
        assert!(stiffened > 1.1 && most > 0.0);
        let mut stiffer = |times: f64| {
            let mut foundation = model.foundation.to_vec();
            foundation.iter_mut().for_each(|point| point.k *= times as f32);
            patch.check(&Model { foundation: &foundation, ..model })
        };
        assert_eq!(stiffer(19.9 / most), Ok(()));
        for times in [20.1 / most, 40.0 / most] {
            let answer = stiffer(times);
            let Err(BuildError::OutOfRange { parameter: CONTACT, value, .. }) = answer else { panic!("{answer:?}") };
            let first = over.iter().map(|over| over * times).find(|over| *over > 20.0).unwrap();
            assert!((f64::from(value) / first - 1.0).abs() < 1e-3, "{value} for {first}");
        }
    }
}

/// Least eigenvalue of N, by three thousand rounds of power iteration in double precision.
fn least_eigenvalue(model: &Model<'_>, tuned: &Tuned<'_>) -> f64 {
    let inertia = tuned.node_step();
    let free: Vec<bool> = inertia.iter().map(|node| node.step > 0.0).collect();
    let times = |shape: &[f64]| {
        let mut sums = std::vec![0.0; shape.len()];
        for spring in model.springs {
            let [i, j] = [spring.i, spring.j].map(usize::from);
            let mass = f64::from(spring.k) * (f64::from(inertia[i].added) + f64::from(inertia[j].added));
            sums[i] += mass * shape[j];
            sums[j] += mass * shape[i];
        }
        sums.iter().zip(inertia).map(|(sum, node)| sum * f64::from(node.step)).collect::<Vec<f64>>()
    };
    let mut shape: Vec<f64> = free.iter().enumerate().map(|(n, free)| if *free { (n as f64 * 1.7).sin() } else { 0.0 }).collect();
    for _ in 0..3_000 {
        let pulled = times(&shape);
        shape.iter_mut().zip(pulled).for_each(|(at, pulled)| *at -= pulled);
        let largest = shape.iter().fold(0.0, |most: f64, at| most.max(at.abs()));
        shape.iter_mut().for_each(|at| *at /= largest);
    }
    let largest = shape.iter().zip(times(&shape)).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap();
    largest.1 / largest.0
}

#[test]
fn the_neighbours_part_is_judged_by_its_least_eigenvalue() {
    let mut patch = Judged::of(FINE);
    let mut values = Vec::new();
    for weaker in [0.05, 1e-2, 1e-4] {
        let mut springs = patch.file.model.springs.to_vec();
        for spring in springs.iter_mut().filter(|spring| (spring.i ^ spring.j) & 1 == 0) {
            (spring.k, spring.k_rest) = (weaker * spring.k, weaker * spring.k_rest);
        }
        let mut foundation = patch.file.model.foundation.to_vec();
        // softened, since the patch would otherwise be refused for its foundation first
        foundation.iter_mut().for_each(|point| point.k *= 0.1);
        let model = Model { springs: &springs, foundation: &foundation, ..patch.file.model };
        let (tuned, scratch) = patch.memory.judge(&model, &patch.file.params, &mut || {}).unwrap();
        let least = least_eigenvalue(&model, &tuned);
        let answer = check(&model, &patch.file.params, &tuned, scratch, &mut || {});
        match answer {
            Err(BuildError::OutOfRange { parameter: SERIES, value, .. }) => {
                let value = f64::from(value);
                assert!(value >= least - 1e-4 && value < least + 0.03, "{weaker}: {value} for {least}");
                values.push(value);
            }
            answer => assert!(answer == Ok(()) && least > -0.98, "{weaker}: {answer:?} for {least}"),
        }
    }
    assert!(!values.is_empty());
}
