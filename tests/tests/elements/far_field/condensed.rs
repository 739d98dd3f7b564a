//! The condensed outside compared with independent results: a bar, rigid motions, and the smallest
//! energy found by conjugate gradients on the whole outside.

use palpate::Vector3;
use palpate_fit::far_field::FarField;
use palpate_fit::far_field::condense::condense;
use palpate_fit::far_field::cut::Outside;
use palpate_fit::reference::body::{Body, Stiffness};
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{TET_EDGES, TetRule};
use palpate_tests::bench::Noise;
use palpate_tissue::mesh::{BlockSpec, block, surface::surface};

use super::{far_field, graded, on_bottom, radius, tissue};

type Vector = Vector3<f64>;

fn outside() -> FarField {
    far_field(&tissue(graded(130), [0.0; 3], on_bottom), &radius(0.016))
}

/// Displacements of the rim under a rigid motion, shape \[3 rim nodes\].
fn rim_motion(outside: &Outside, of: impl Fn(Vector) -> Vector) -> Vec<f64> {
    let moved = outside.rim.iter().map(|n| of(Vector::from(outside.mesh.nodes_m[*n as usize])));
    moved.flat_map(|u| [u.x, u.y, u.z]).collect()
}

/// In a bar without lateral contraction whose end plane moves along its axis, the strain is
/// uniform: the stiffness is A / L in units of E.
#[test]
fn a_bar_has_the_stiffness_of_a_bar() {
    let size_m = [0.02, 0.015, 0.04];
    let mesh = block(&BlockSpec { size_m, nodes: 90, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
    let nodes = || (0_u32..).zip(&mesh.nodes_m);
    let rim: Vec<u32> = nodes().filter(|(_, x)| x[2] == 0.0).map(|(n, _)| n).collect();
    let anchors = nodes().filter(|(_, x)| x[2] <= -size_m[2]).map(|(n, _)| n).collect();
    let place = |n: u32| rim.binary_search(&n).ok();
    let rim_faces: Vec<[u32; 3]> = surface(&mesh.tets).into_iter().filter(|t| t.iter().all(|n| place(*n).is_some())).collect();
    let bar = Outside {
        stiffness_ratio: vec![1.0; mesh.tets.len()],
        anchors,
        rim_triangles: rim_faces.iter().map(|t| t.map(place)).collect(),
        rim_faces,
        rim: rim.clone(),
        mesh: mesh.clone(),
    };
    let s = condense(&bar, 0.0).unwrap();
    let pull: f64 =
        (0..rim.len()).flat_map(|i| (0..rim.len()).map(move |j| (i, j))).map(|(i, j)| s[(3 * i + 2, 3 * j + 2)]).sum();
    let wanted_m = size_m[0] * size_m[1] / size_m[2];
    assert!((pull / wanted_m - 1.0).abs() < 1e-9, "{pull} m, A / L = {wanted_m} m");
    // tissue twice as stiff gives a bar twice as stiff
    let stiffer = condense(&Outside { stiffness_ratio: vec![2.0; mesh.tets.len()], ..bar }, 0.0).unwrap();
    assert!((stiffer[(0, 0)] / s[(0, 0)] - 2.0).abs() < 1e-9);
}

/// Only the anchors resist a rigid motion of the rim; without them nothing does.
#[test]
fn only_anchors_resist_rigid_motions() {
    let far = outside();
    let held = &far.cut.outside;
    let loose = condense(&Outside { anchors: Vec::new(), ..held.clone() }, 0.45).unwrap();
    let scale = (0..loose.nrows()).map(|r| loose[(r, r)]).fold(0.0, f64::max);
    let axes = [Vector::x(), Vector::y(), Vector::z()];
    for axis in axes {
        for (what, u) in
            [("translation", rim_motion(held, |_| axis)), ("rotation", rim_motion(held, |x| axis.cross(&(x * 60.0))))]
        {
            let pull = |s: &dyn Fn(usize, usize) -> f64| -> f64 {
                (0..u.len()).map(|r| (0..u.len()).map(|c| s(r, c) * u[c]).sum::<f64>().powi(2)).sum::<f64>().sqrt()
            };
            let (free, fixed) = (pull(&|r, c| loose[(r, c)]), pull(&|r, c| far.exact_m[(r, c)]));
            assert!(free < 1e-8 * scale, "{what} along {axis:?}: {free} of {scale} left without anchors");
            assert!(fixed > 1e3 * free && fixed > 0.01 * scale, "{what} along {axis:?}: the anchors hold with {fixed}");
        }
    }
}

/// `u^T S u / 2` is the smallest energy of the outside while its rim has the displacement u.
#[test]
fn condensed_energy_is_the_least_energy_of_the_outside() {
    let far = outside();
    let outside = &far.cut.outside;
    let size = 3 * outside.rim.len();
    let mesh = QuadraticMesh::new(&outside.mesh);
    let nodes = mesh.nodes_m.len();
    let anchored = |n: u32| outside.anchors.binary_search(&n).is_ok();
    let mut fixed = vec![false; nodes];
    outside.anchors.iter().for_each(|a| fixed[*a as usize] = true);
    // the middle of a rim edge follows the mean of its ends
    let mut follows: Vec<Option<[u32; 2]>> = vec![None; nodes];
    for tet in &mesh.tets {
        for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
            let [a, b] = [tet[i], tet[j]];
            fixed[tet[4 + e] as usize] |= anchored(a) && anchored(b);
            if outside.rim_faces.iter().any(|f| f.contains(&a) && f.contains(&b)) {
                follows[tet[4 + e] as usize] = Some([a, b]);
            }
        }
    }
    let prescribed: Vec<bool> =
        (0..nodes).map(|n| fixed[n] || follows[n].is_some() || outside.rim.contains(&(n as u32))).collect();
    let stiffness =
        |t: usize, _: &Vector| Stiffness { ratio: outside.stiffness_ratio[t], poisson_ratio: 0.45, stiffening_b: 0.0 };
    let body = Body::with_stiffness(mesh, stiffness, vec![[false; 3]; nodes], Vec::new(), 1.0, TetRule::Four);
    let rest = body.assemble(&vec![Vector::zeros(); nodes], None).unwrap();
    let times = |w: &[Vector]| body.tangent_times(&rest, w);
    let dot = |a: &[Vector], b: &[Vector]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    let loose = |mut v: Vec<Vector>| {
        v.iter_mut().zip(&prescribed).filter(|(_, p)| **p).for_each(|(v, _)| *v = Vector::zeros());
        v
    };
    for seed in 0..3 {
        let mut noise = Noise::new(seed);
        let u: Vec<f64> = (0..size).map(|_| noise.uniform()).collect();
        let mut w = vec![Vector::zeros(); nodes];
        outside.rim.iter().enumerate().for_each(|(k, n)| w[*n as usize] = Vector::from_column_slice(&u[3 * k..3 * k + 3]));
        for n in 0..nodes {
            if let Some([a, b]) = follows[n] {
                w[n] = (w[a as usize] + w[b as usize]) / 2.0;
            }
        }
        let mut left = loose(times(&w).into_iter().map(|f| -f).collect());
        let (mut way, first) = (left.clone(), dot(&left, &left));
        let mut square = first;
        let mut steps = 0;
        while square > 1e-20 * first && steps < 20_000 {
            let bent = loose(times(&way));
            let share = square / dot(&way, &bent);
            w.iter_mut().zip(&way).for_each(|(w, d)| *w += d * share);
            left.iter_mut().zip(&bent).for_each(|(l, b)| *l -= b * share);
            let next = dot(&left, &left);
            way.iter_mut().zip(&left).for_each(|(d, l)| *d = l + *d * (next / square));
            square = next;
            steps += 1;
        }
        let least = dot(&w, &times(&w));
        let condensed: f64 =
            (0..size).flat_map(|r| (0..size).map(move |c| (r, c))).map(|(r, c)| u[r] * far.exact_m[(r, c)] * u[c]).sum();
        println!("{nodes} nodes, {steps} steps: least {least:.9e}, condensed {condensed:.9e}");
        assert!(condensed > 0.0 && (condensed / least - 1.0).abs() < 1e-7, "{condensed} is not {least}");
    }
}
