//! A uniform deformation is exact on any mesh.

use palpate::Vector3;
use palpate_fit::reference::body::Body;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::TetRule;
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::scene::Shape;

use crate::fem_reference::{assert_within, tissue};

const SIDE_M: f64 = 0.02;
const NU: f64 = 0.45;

fn lame() -> (f64, f64) {
    (0.5 / (1.0 + NU), NU / ((1.0 + NU) * (1.0 - 2.0 * NU)))
}

/// A cube that extends from 0 to its side length in x and y and has its top at z = 0.
fn cube() -> TetMesh {
    let spec = BlockSpec { size_m: [SIDE_M; 3], nodes: 90, fine_at_m: [0.003, -0.002], fine_radius_m: 0.004 };
    let mut mesh = block(&spec).expect("a small cube is meshed");
    for node in &mut mesh.nodes_m {
        node[0] += 0.5 * SIDE_M;
        node[1] += 0.5 * SIDE_M;
    }
    mesh
}

fn body(fixed: impl Fn(&Vector3<f64>) -> [bool; 3], rule: TetRule) -> Body {
    let mesh = QuadraticMesh::new(&cube());
    let fixed = mesh.nodes_m.iter().map(fixed).collect();
    let top = |t: &[u32; 6]| t.iter().all(|n| mesh.nodes_m[*n as usize].z == 0.0);
    let touchable = (0..mesh.triangles.len()).filter(|t| top(&mesh.triangles[*t])).collect();
    Body::new(mesh, &tissue(NU), fixed, touchable, 1.0, rule)
}

#[test]
fn patch_test_no_node_inside_feels_a_force_and_the_energy_is_the_formulas() {
    for rule in [TetRule::Four, TetRule::Eleven] {
        let body = body(|_| [false; 3], rule);
        // rows of a displacement gradient with stretch, shear and rotation
        let rows = [[0.10, 0.07, -0.02], [-0.05, -0.08, 0.03], [0.04, 0.01, 0.06]].map(Vector3::from);
        let u: Vec<_> = body.mesh.nodes_m.iter().map(|x| Vector3::from(rows.map(|row| row.dot(x)))).collect();
        let now = body.assemble(&u, None).expect("nothing is inside out");

        let f = [0, 1, 2].map(|k| rows[k] + Vector3::ith(k, 1.0));
        let (mu, lambda) = lame();
        let ln_j = f[0].cross(&f[1]).dot(&f[2]).ln();
        let i1: f64 = f.iter().map(Vector3::norm_squared).sum();
        let density = 0.5 * mu * (i1 - 3.0) - mu * ln_j + 0.5 * lambda * ln_j * ln_j;
        assert_within("energy", now.energy_m3, density * SIDE_M.powi(3), 1e-12);

        let mut on_surface = vec![false; u.len()];
        for n in body.mesh.triangles.iter().flatten() {
            on_surface[*n as usize] = true;
        }
        let largest = |surface: bool| {
            let forces = now.residual_m2.iter().zip(&on_surface).filter(|(_, on)| **on == surface);
            forces.map(|(r, _)| r.norm()).fold(0.0, f64::max)
        };
        assert!(on_surface.iter().filter(|on| !**on).count() > 50);
        assert!(largest(true) > 1e-6, "a stretched cube is held by its surface: {:e}", largest(true));
        assert!(largest(false) < 1e-12 * largest(true), "{:e} inside, {:e} outside", largest(false), largest(true));
    }
}

#[test]
fn a_squeezed_bar_has_the_force_of_the_formula() {
    // bottom and two sides can slide, and the other two sides are free: uniaxial stress
    let body = body(|x| [x.x == 0.0, x.y == 0.0, x.z <= -SIDE_M * (1.0 - 1e-9)], TetRule::Four);
    let place = Vector3::new(0.5 * SIDE_M, 0.5 * SIDE_M, 0.0);
    // a plate wider than the bar
    let probe = RigidProbe::new(Shape::Flat, 2.0 * SIDE_M, place, Vector3::z());
    let mut press = Press::new(&body, probe, place).expect("small");
    for depth_m in [0.001, 0.006] {
        press.go_to(depth_m, |_| {}).expect("a bar can be squeezed");
        let stretch = 1.0 - (depth_m - press.touch().penetration_m) / SIDE_M;
        assert_within("force", press.force_over_e_m2(), -uniaxial(stretch) * SIDE_M * SIDE_M, 1e-6);
    }
}

/// Axial stress per rest area over E of a bar with free sides. The lateral stretch t follows from
/// zero lateral stress: `mu (t^2 - 1) + lambda ln(stretch t^2) = 0`.
fn uniaxial(stretch: f64) -> f64 {
    let (mu, lambda) = lame();
    let (mut low, mut high) = (0.5, 2.0);
    for _ in 0..100 {
        let across: f64 = 0.5 * (low + high);
        let pull = mu * (across * across - 1.0) + lambda * (stretch * across * across).ln();
        if pull > 0.0 { high = across } else { low = across }
    }
    let ln_j = (stretch * low * low).ln();
    mu * (stretch - 1.0 / stretch) + lambda * ln_j / stretch
}
