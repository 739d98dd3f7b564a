//! A bar: its wave speed, the force of its impact, and the decay of its first mode.

use std::f64::consts::FRAC_PI_2;

use palpate::Vector3;
use palpate_fit::reference::body::{Body, Material};
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::TetRule;
use palpate_lab::dynamic::march::{Inertia, March};
use palpate_tissue::mesh::TetMesh;

const CELLS: usize = 40;
const CELL_M: f64 = 0.001;
const LENGTH_M: f64 = CELLS as f64 * CELL_M;
/// Strain small enough that the bar is linear.
const SMALL: f64 = 1e-5;
/// Density of liver, 1060 kg/m^3, over its modulus of 3500 Pa.
const DENSITY_S2_PER_M2: f64 = 1060.0 / 3500.0;
/// Corners of a cell's six tets; the bits of a corner's number are x, y and z (Kuhn 1960).
const TETS: [[usize; 4]; 6] = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// A bar along x with a cross-section of one cell, fixed at x = 0, whose nodes move along x only.
fn bar(poisson_ratio: f64) -> Body {
    let corner = |n: usize, bits: usize| (4 * (n + (bits & 1)) + (bits >> 1)) as u32;
    let node = |n: u32| [f64::from(n / 4), f64::from(n % 2), f64::from(n / 2 % 2)].map(|x| x * CELL_M);
    let nodes_m = (0..4 * (CELLS as u32 + 1)).map(node).collect();
    let tets: Vec<[u32; 4]> = (0..CELLS).flat_map(|n| TETS.map(|tet| tet.map(|bits| corner(n, bits)))).collect();
    let regions = vec![0; tets.len()];
    let mesh = QuadraticMesh::new(&TetMesh { nodes_m, tets, regions });
    let fixed = mesh.nodes_m.iter().map(|x| [x.x == 0.0, true, true]).collect();
    Body::new(mesh, &Material { poisson_ratio, stiffening_b: 0.0, inclusions: vec![] }, fixed, vec![], 1.0, TetRule::Four)
}

fn march(body: &Body, damping_per_s: f64) -> March<'_> {
    let inertia = Inertia { density_s2_per_m2: DENSITY_S2_PER_M2, damping_per_s };
    let mut march = March::new(body, inertia, 0.8, 1e-6).expect("a small factor fits into memory");
    march.least_force_m2 = SMALL * CELL_M * CELL_M;
    march
}

/// Wave speed of a laterally confined bar: sqrt(M / rho), where M is the P-wave modulus.
fn speed_m_per_s(nu: f64) -> f64 {
    ((1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / DENSITY_S2_PER_M2).sqrt()
}

/// Mean x component at the nodes of the free end.
fn at_end(body: &Body, of: &[Vector3<f64>]) -> f64 {
    let ends = body.mesh.nodes_m.iter().zip(of).filter(|(x, _)| x.x > LENGTH_M * (1.0 - 1e-9));
    let (sum, count) = ends.fold((0.0, 0.0), |(sum, count), (_, u)| (sum + u.x, count + 1.0));
    sum / count
}

/// Integral of the x component of a field over the bar. Quadratic shape functions integrate to
/// -1/20 of a tet's volume at its corners and to 1/5 at the middles of its edges.
fn integral(body: &Body, of: &[Vector3<f64>]) -> f64 {
    let volume = CELL_M.powi(3) / 6.0;
    let sum = |nodes: &[u32]| nodes.iter().map(|n| of[*n as usize].x).sum::<f64>();
    body.mesh.tets.iter().map(|tet| volume * (sum(&tet[4..]) / 5.0 - sum(&tet[..4]) / 20.0)).sum()
}

#[test]
fn a_bar_that_hits_a_wall_pushes_with_the_impedance_until_the_wave_returns() {
    for nu in [0.0, 0.45] {
        let body = bar(nu);
        let speed = speed_m_per_s(nu);
        let mut march = march(&body, 0.0);
        let impact_m_per_s = SMALL * speed;
        for (v, fixed) in march.nodes.velocity_m_per_s.iter_mut().zip(&body.fixed) {
            v.x = if fixed[0] { 0.0 } else { -impact_m_per_s };
        }
        let arrival_s = LENGTH_M / speed;
        let step_s = arrival_s / 200.0;
        let (mut turned_s, mut released_s, mut push_m2, mut count) = (None, None, 0.0, 0.0);
        // rho c v per area, over Young's modulus
        let impedance_m2 = DENSITY_S2_PER_M2 * speed * impact_m_per_s * CELL_M * CELL_M;
        let mut before = -impact_m_per_s;
        for n in 1..=500 {
            let t_s = f64::from(n) * step_s;
            assert!(march.step(step_s, None), "{t_s} s");
            let end = at_end(&body, &march.nodes.velocity_m_per_s);
            if before < 0.0 && end >= 0.0 {
                turned_s.get_or_insert(t_s - step_s * end / (end - before));
            }
            before = end;
            let push = DENSITY_S2_PER_M2 * integral(&body, &march.nodes.acceleration_m_per_s2);
            if (0.3..1.7).contains(&(t_s / arrival_s)) {
                push_m2 += push;
                count += 1.0;
            }
            if t_s > 1.5 * arrival_s && push < 0.0 {
                released_s.get_or_insert(t_s);
            }
        }
        let turned = turned_s.expect("the free end turns") / arrival_s;
        assert!((turned - 1.0).abs() < 0.01, "nu {nu}: the free end turns at {turned} L/c");
        let push = push_m2 / count / impedance_m2;
        assert!((push - 1.0).abs() < 0.01, "nu {nu}: the wall pushes with {push} of the impedance's force");
        let released = released_s.expect("the bar leaves the wall") / arrival_s;
        assert!((released - 2.0).abs() < 0.06, "nu {nu}: the wall is pulled from {released} L/c on");
    }
}

#[test]
fn a_mode_rings_and_decays_as_the_closed_form() {
    let body = bar(0.0);
    for damping_per_s in [0.0, 40.0] {
        let mut march = march(&body, damping_per_s);
        let own_per_s = FRAC_PI_2 * speed_m_per_s(0.0) / LENGTH_M;
        for (n, x) in body.mesh.nodes_m.iter().enumerate() {
            march.nodes.displacement_m[n].x = SMALL * LENGTH_M * (FRAC_PI_2 * x.x / LENGTH_M).sin();
            march.nodes.acceleration_m_per_s2[n].x = -march.nodes.displacement_m[n].x * own_per_s * own_per_s;
        }
        let half = 0.5 * damping_per_s;
        let ring = (own_per_s * own_per_s - half * half).sqrt();
        for n in 1..=200 {
            let t_s = f64::from(n) * 5e-4;
            assert!(march.step(5e-4, None), "{t_s} s");
            let exact = (-half * t_s).exp() * ((ring * t_s).cos() + half / ring * (ring * t_s).sin());
            let got = at_end(&body, &march.nodes.displacement_m) / (SMALL * LENGTH_M);
            assert!((got - exact).abs() < 0.005, "damping {damping_per_s}/s, {t_s} s: {got}, not {exact}");
        }
    }
}
