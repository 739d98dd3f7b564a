//! The core's forces are the derivatives of the documented energies: they agree with an oracle in
//! double precision that is written from the energies.

use palpate::stages::probe::{Motion, ProbePose};
use palpate::stages::{contact, force};
use palpate::{ClampFlags, Model, ProbeShape, RimEdge, RimNode, State, Tuned, Vector3, tick};
use palpate_tests::bench::{Bench, Deformation, Noise, at_depth};
use palpate_tests::oracle::{Oracle, Tip};
use palpate_tests::rounding::{self, UNIT};
use palpate_tissue::measure;

fn double(of: &[Vector3<f32>]) -> Vec<Vector3<f64>> {
    of.iter().map(|x| x.cast()).collect()
}

fn place(state: &mut State, x: &[Vector3<f32>], v: &[Vector3<f32>]) {
    for (n, (&x, &v)) in x.iter().zip(v).enumerate() {
        state.place(n, x, v);
    }
}

/// Node forces that the core computed last [N].
fn forces_n(tuned: &Tuned, state: &State) -> Vec<Vector3<f64>> {
    let e = f64::from(tuned.youngs_modulus_pa());
    state.nodes().iter().map(|n| n.force_over_modulus().cast() * e).collect()
}

/// A rim between the first thirteen nodes, because the meshes in this test have none.
fn rim(noise: &mut Noise) -> (Vec<RimNode>, Vec<RimEdge>) {
    let mut block = |entries: &mut [f32]| entries.iter_mut().for_each(|c| *c = 1e-3 * noise.uniform() as f32);
    let (mut nodes, mut edges) = (Vec::new(), Vec::new());
    for node in 0..12 {
        let mut ground = RimNode { node: node.into(), block_m: [0.0; 6] };
        let mut edge = RimEdge { node: [node, node + 1], block_m: [0.0; 9] };
        block(&mut ground.block_m);
        block(&mut edge.block_m);
        nodes.push(ground);
        edges.push(edge);
    }
    (nodes, edges)
}

#[test]
fn model_holds_the_documented_constants() {
    let bench = Bench::block(129);
    let model = bench.patch.wide_model();
    let nu = 0.45_f64;
    let (mu, lambda) = (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    // each constant is rounded once, and the oracle's factors are exact
    let is = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 2.0 * UNIT, "{found} is not {wanted}");
    let nodal = 12.0 * f64::from(model.nodes[0].pressure);
    let per_tet = 6.0 * f64::from(model.tets[0].bulk);
    is(nodal + per_tet, lambda - mu);
    is(per_tet, 0.109 * (lambda - mu));
    is(2.0 * f64::from(model.tets[0].barrier), mu);

    let mesh = bench.patch.mesh();
    let mut volume_m3 = vec![0.0; model.nodes.len()];
    let mut k = std::collections::BTreeMap::new();
    for tet in &mesh.tets {
        let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
        let v = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
        let edge_m = (12.0 * v / 2.0_f64.sqrt()).cbrt();
        for (at, &i) in tet.iter().enumerate() {
            volume_m3[i as usize] += v / 4.0;
            for &j in &tet[at + 1..] {
                *k.entry((i.min(j), i.max(j))).or_insert(0.0) += 2.0 * 2.0_f64.sqrt() / 25.0 * edge_m / (0.8 * (1.0 + nu));
            }
        }
    }
    // the mesh is read back with rounded coordinates: half an ulp of 40 mm on each, relative to the
    // shortest edge
    let shortest_m = model.springs.iter().map(|s| s.k_rest / s.k).fold(f32::MAX, f32::min);
    let rounded = 0.04 * UNIT / f64::from(shortest_m);
    for (node, wanted) in model.nodes.iter().zip(&volume_m3) {
        assert!((f64::from(node.volume_m3) / wanted - 1.0).abs() < 10.0 * rounded);
    }
    assert_eq!(k.len(), model.springs.len());
    for s in model.springs {
        let wanted = k[&(u32::from(s.i.min(s.j)), u32::from(s.i.max(s.j)))];
        assert!((f64::from(s.k) / wanted - 1.0).abs() < 10.0 * rounded, "spring {} - {}", s.i, s.j);
    }

    let mut memory = bench.memory();
    let (tuned, _) = memory.start(&model, &bench.params).unwrap();
    let oracle = Oracle::new(model, bench.params);
    for n in (0..model.nodes.len()).filter(|&n| !model.anchors.contains(&(n as u16))) {
        // seven operations in the core, and the sum over a node's springs
        let mass_kg = f64::from(tuned.mass_kg(n).unwrap());
        assert!((mass_kg / oracle.mass_kg(n) - 1.0).abs() < 64.0 * UNIT, "node {n}");
    }
}

#[test]
fn inner_forces_are_slopes_of_the_energies() {
    let (mut squeezed, mut barred, mut inverted, mut flattened) = (0, 0, 0, 0);
    let mut worst = 0.0_f64;
    for seed in 0..24 {
        // from strains of a hundredth of a percent up to inverted tets
        let share = f64::from(seed as u32 % 8) / 7.0;
        let deformation = Deformation { seed, strain: 1e-4 + 0.6 * share, jitter: 1e-4 + 0.6 * share };
        let bench = Bench::block([60, 129, 410][seed as usize % 3]).with(|p| p.gravity_m_per_s2 = [1.0, -2.0, -9.81]);
        let mut noise = Noise::new(!seed);
        let (rim_nodes, rim_edges) = rim(&mut noise);
        let model = Model { rim_nodes: &rim_nodes, rim_edges: &rim_edges, ..bench.patch.wide_model() };
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let x = deformation.of(&model);
        let v: Vec<Vector3<f32>> = x.iter().map(|_| noise.vector().cast()).collect();
        place(&mut state, &x, &v);
        force::accumulate(&model, &tuned, &mut state, at_depth(-1.0), Vector3::zeros());

        let x = double(&x);
        let oracle = Oracle::new(model, bench.params);
        let mut bound = rounding::of_forces_n(&model, &bench.params, &x);
        for b in bound.iter_mut().take(13) {
            // at most three blocks of 1e-3 at a node, twelve operations; displacements are below
            // 0.1 m
            *b += 3.0 * 12.0 * UNIT * 3e-3 * 0.1 * oracle.youngs_modulus_pa();
        }
        for (n, (found, wanted)) in forces_n(&tuned, &state).iter().zip(oracle.forces_n(&x)).enumerate() {
            let off = (found - wanted).norm() / bound[n];
            assert!(off <= 1.0, "{deformation:?} node {n}: {found:?} is not {wanted:?}: {off} of the rounding");
            worst = worst.max(off);
        }

        let length = |s: &palpate::Spring| (x[usize::from(s.j)] - x[usize::from(s.i)]).norm() * f64::from(s.k / s.k_rest);
        squeezed += model.springs.iter().filter(|s| length(s) < 0.927).count();
        let ratios: Vec<f64> = model
            .tets
            .iter()
            .map(|t| {
                let [a, b, c, d] = t.node.map(|n| x[usize::from(n)]);
                (b - a).cross(&(c - a)).dot(&(d - a)) * f64::from(t.six_volume_reciprocal)
            })
            .collect();
        barred += ratios.iter().filter(|j| (0.0..0.4).contains(*j)).count();
        inverted += ratios.iter().filter(|j| **j < 0.0).count();
        flattened += usize::from(measure::volumes(&model, &state).0 < 0.0);
    }
    println!(
        "largest share of the rounding bound {worst:.3}; {squeezed} squeezed springs, {barred} tets in the barrier, {inverted} beyond it"
    );
    assert!(squeezed > 1000 && barred > 1000 && inverted > 100 && flattened > 3, "the states must reach every branch");
}

#[test]
fn contact_forces_are_slopes_of_the_foundation_and_its_damping() {
    let mut touched = 0;
    for seed in 0..36 {
        let mut noise = Noise::new(seed);
        let along = Vector3::zeros();
        let shape = match seed {
            0..30 => [ProbeShape::Hemisphere, ProbeShape::Sphere, ProbeShape::Flat][seed as usize % 3],
            30..33 => ProbeShape::Capsule { length_m: 0.01, along },
            _ => ProbeShape::Ellipsoid { semi_axes_m: [0.013, 0.006], along },
        };
        let tilt = Vector3::new(0.3 * noise.uniform(), 0.3 * noise.uniform(), 1.0).normalize();
        let block = Bench::with_points(410, [9, 16, 4, 4, 4][seed as usize % 5]);
        let bench = block.with(|p| {
            p.probe.axis = tilt.cast();
            let level = p.probe.axis.cross(&Vector3::new(0.6, 0.3, 0.1)).normalize();
            p.probe.shape = match shape {
                ProbeShape::Capsule { length_m, .. } => ProbeShape::Capsule { length_m, along: level },
                ProbeShape::Ellipsoid { semi_axes_m, .. } => ProbeShape::Ellipsoid { semi_axes_m, along: level },
                round => round,
            };
            p.substeps = 1 + seed as u16 % 2;
        });
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let inside = Vector3::new(0.01 * noise.uniform(), 0.01 * noise.uniform(), -1e-3 - 3e-3 * noise.uniform().abs()).cast();
        let velocity = noise.vector().cast();
        let x = Deformation { seed, strain: 0.02, jitter: 0.05 }.of(&model);
        let v: Vec<Vector3<f32>> = x.iter().map(|_| noise.vector().cast()).collect();
        place(&mut state, &x, &v);
        // a probe must have been outside before it can touch
        for to_m in [Vector3::new(0.0, 0.0, 0.1), inside] {
            let mut motion = Motion {
                from_m: to_m,
                to_m,
                velocity_m_per_s: velocity,
                apart_m: 0.0,
                beyond_m: Vector3::zeros(),
                outside: false,
                limiters: ClampFlags::default(),
            };
            contact::find(&model, &tuned, &mut state, &mut motion);
        }
        let load = force::accumulate(&model, &tuned, &mut state, inside, velocity);

        let (x, v) = (double(&x), double(&v));
        let oracle = Oracle::new(model, bench.params);
        let inner = oracle.forces_n(&x);
        let on = oracle.contact_n(&x, &v, &inner, Tip { at_m: inside.cast(), velocity_m_per_s: velocity.cast() });
        let mut bound = rounding::of_forces_n(&model, &bench.params, &x);
        // The position of a point relative to the probe rounds at the magnitudes of both positions.
        // Its force rounds by the slope times that, and its direction by that over the radius; the
        // force is at most slope times radius. The rounding of the node's other forces is added.
        let r = f64::from(bench.params.probe.radius_m);
        let stiffest = model.foundation.iter().map(|p| f64::from(p.k)).fold(0.0, f64::max);
        let slope_m = stiffest * (1.0 + 2.0 * f64::from(model.stiffening_per_m) * r);
        let mut whole = 0.0;
        for t in model.triangles {
            let corners = t.node.map(|n| x[usize::from(n)]);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            let reached = (centre - inside.cast()).norm() < 3.0 * r;
            if reached {
                let size_m = 3.0 * r + centre.norm() + 4e-3;
                let error = model.points_per_triangle() as f64 * 16.0 * UNIT * slope_m * size_m * oracle.youngs_modulus_pa();
                for n in t.node.map(usize::from) {
                    let inner = bound[n];
                    bound[n] += error + inner;
                    whole += inner;
                }
                whole += error;
            }
        }
        for (n, found) in forces_n(&tuned, &state).iter().enumerate() {
            let wanted = inner[n] + on[n];
            assert!(
                (found - wanted).norm() <= bound[n],
                "{shape:?} seed {seed} node {n}: {found:?} is not {wanted:?} within {}",
                bound[n]
            );
        }
        let wanted: Vector3<f64> = on.iter().sum();
        let found = load.force.cast::<f64>() * oracle.youngs_modulus_pa();
        assert!((found - wanted).norm() <= whole, "{shape:?} seed {seed}: {found:?} is not {wanted:?}");
        touched += on.iter().filter(|f| f.norm() > 0.0).count();
    }
    assert!(touched > 300, "{touched} nodes were touched");
}

#[test]
fn a_press_in_double_precision_gives_the_same_force() {
    let bench = Bench::block(410);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let oracle = Oracle::new(model, bench.params);
    let mut x: Vec<Vector3<f64>> = model.nodes.iter().map(|n| Vector3::from(n.rest_m).cast()).collect();
    let mut v = vec![Vector3::zeros(); x.len()];
    // Each tick rounds a position by half an ulp at 40 mm, 1.9 nm. At worst the errors of all ticks
    // within the damping time 2/alpha = 50 ms add up, and the tissue at 1 mm is no stiffer than 100
    // N/m. The rounding of the foundation's own sum is added.
    let allowed_n = 100.0 * 50.0 * 1.9e-9 + 1e-6;
    let mut worst = 0.0_f64;
    let mut from = at_depth(-0.5e-3);
    let mut moved_m = Vector3::zeros();
    let mut last = 0.0;
    for n in 0..300 {
        // 40 mm/s from 0.5 mm above the surface to 1 mm below, then a hold
        let to = at_depth((-0.5e-3 + 40e-6 * n as f32).min(1e-3));
        let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: to });
        let wanted = oracle.tick(&mut x, &mut v, moved_m, from.cast(), to.cast());
        moved_m = (to - from).cast();
        from = to;
        let off = (output.force_n.cast() - wanted).norm();
        assert!(off <= allowed_n, "tick {n}: {:?} is not {wanted:?}", output.force_n);
        worst = worst.max(off);
        last = wanted.z;
    }
    println!("largest difference {worst:.2e} N of {last:.4} N");
    assert!(last > 1000.0 * allowed_n, "the press must be felt: {last} N");
}
