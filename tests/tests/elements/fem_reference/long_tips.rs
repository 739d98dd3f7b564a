//! Capsule and ellipsoid on a half-space, compared with Hertz's elliptical contact in closed form
//! and with a boundary-element solution that shares no code with the finite elements.

use palpate::Vector3;
use palpate_fit::reference::domain::{BlockBody, BlockCase};
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::refine::refine;
use palpate_tissue::mesh::{self, BlockSpec};
use palpate_tissue::scene::Shape;

use crate::fem_reference::{above, assert_within, standard_block};
use crate::fingerprint::solved_before;

const ALONG: [f64; 3] = [1.0, 0.0, 0.0];

/// E* over E: 1/(1 - nu^2).
fn plane_modulus() -> f64 {
    1.0 / (1.0 - 0.45 * 0.45)
}

/// A quarter of a block 0.4 x 0.4 x 0.2 m with elements `edge_m` long where both coordinates are
/// below `half_m`; from there on they grow.
fn half_space(half_m: [f64; 2], edge_m: f64, nodes: usize) -> BlockBody {
    let case = BlockCase { size_m: [0.4, 0.4, 0.2], ..standard_block(100, 0.05) };
    let quarter = BlockSpec { size_m: [0.2; 3], nodes: 100, fine_at_m: [-0.1; 2], fine_radius_m: 0.05 };
    let mut mesh = mesh::block(&quarter).expect("meshed");
    for x in &mut mesh.nodes_m {
        *x = [x[0] + 0.1, x[1] + 0.1, x[2]];
    }
    let beyond = |x: f64, half_m: f64| (x - half_m).max(0.0);
    let longest_m = |x: [f64; 3]| edge_m + 0.6 * Vector3::new(beyond(x[0], half_m[0]), beyond(x[1], half_m[1]), x[2]).norm();
    case.support(&refine(&mesh, longest_m, nodes), [true; 2])
}

/// Complete elliptic integrals K and E of the modulus k, by the arithmetic-geometric mean.
fn elliptic(k: f64) -> (f64, f64) {
    let (mut a, mut b, mut sum, mut power) = (1.0, (1.0 - k * k).sqrt(), 0.5 * k * k, 1.0);
    for _ in 0..30 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        sum += power * c * c;
        power *= 2.0;
    }
    let whole = std::f64::consts::PI / (2.0 * a);
    (whole, whole * (1.0 - sum))
}

/// Force over E [m^2] on a paraboloid with these radii of curvature, the longer first, and the
/// longer semi-axis of its contact [m] (Johnson, Contact Mechanics, 1985, 4.26 to 4.31).
fn hertz_m2([long_m, short_m]: [f64; 2], depth_m: f64) -> (f64, f64) {
    let ratio = |k: f64| {
        let (first, second) = elliptic(k);
        (second / (1.0 - k * k) - first) / (first - second)
    };
    let (mut low, mut high) = (1e-4, 1.0 - 1e-12);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < long_m / short_m { low = middle } else { high = middle }
    }
    let (first, second) = elliptic(low);
    let a_m = (2.0 * long_m * depth_m * (first - second) / (first * low * low)).sqrt();
    (2.0 * std::f64::consts::PI * a_m * plane_modulus() * depth_m / (3.0 * first), a_m)
}

/// Force over E [m^2] on a rigid probe whose lowest point is `depth_m` below the surface of a
/// half-space. Pressure is uniform in each cell (Love 1929) and found by conjugate gradients that
/// exclude tension (Polonsky and Keer, Wear 231, 1999). The `count` cells cover a quarter of the
/// contact, up to `extent_m` from its centre.
fn boundary_elements_m2(height_m: impl Fn(f64, f64) -> f64, depth_m: f64, extent_m: [f64; 2], count: [usize; 2]) -> f64 {
    let side_m: [f64; 2] = std::array::from_fn(|k| extent_m[k] / count[k] as f64);
    let centre =
        |n: usize| [(n % count[0]) as f64 + 0.5, (n / count[0]) as f64 + 0.5].into_iter().zip(side_m).map(|(n, s)| n * s);
    let places: Vec<[f64; 2]> = (0..count[0] * count[1]).map(|n| centre(n).collect::<Vec<_>>().try_into().unwrap()).collect();
    // displacement at (x, y) by unit pressure on a cell around the origin, times pi E*
    let love = |x: f64, y: f64| {
        let (p, q, r, s) = (x + 0.5 * side_m[0], x - 0.5 * side_m[0], y + 0.5 * side_m[1], y - 0.5 * side_m[1]);
        let part = |a: f64, b: f64, c: f64| a * ((b + a.hypot(b)) / (c + a.hypot(c))).ln();
        part(p, r, s) + part(r, p, q) + part(q, s, r) + part(s, q, p)
    };
    let cells = places.len();
    let mut answer = vec![0.0; cells * cells];
    for (n, [x, y]) in places.iter().enumerate() {
        for (m, [u, v]) in places.iter().enumerate() {
            let mirrored = [[*u, *v], [-u, *v], [*u, -v], [-u, -v]];
            answer[n * cells + m] = mirrored.iter().map(|[u, v]| love(x - u, y - v)).sum::<f64>() / std::f64::consts::PI;
        }
    }
    let times = |p: &[f64]| -> Vec<f64> { answer.chunks(cells).map(|row| row.iter().zip(p).map(|(a, p)| a * p).sum()).collect() };
    let wanted: Vec<f64> = places.iter().map(|[x, y]| depth_m - height_m(*x, *y)).collect();
    let mut pressure: Vec<f64> = wanted.iter().map(|w| if *w > 0.0 { *w } else { 0.0 }).collect();
    let (mut way, mut kept, mut before) = (vec![0.0; cells], 0.0, 1.0);
    for _ in 0..400 {
        let residual: Vec<f64> = times(&pressure).iter().zip(&wanted).map(|(u, w)| u - w).collect();
        let touching: Vec<bool> = pressure.iter().map(|p| *p > 0.0).collect();
        let square: f64 = residual.iter().zip(&touching).filter(|(_, t)| **t).map(|(r, _)| r * r).sum();
        for n in 0..cells {
            way[n] = if touching[n] { residual[n] + kept * square / before * way[n] } else { 0.0 };
        }
        before = square;
        let moved = times(&way);
        let [top, bottom] = [&residual, &moved].map(|v| v.iter().zip(&way).map(|(v, w)| v * w).sum::<f64>());
        if bottom == 0.0 {
            break;
        }
        let step = top / bottom;
        kept = 1.0;
        for n in 0..cells {
            pressure[n] = (pressure[n] - step * way[n]).max(0.0);
            // a cell without pressure that lies inside the probe is added to the contact
            if pressure[n] == 0.0 && residual[n] < 0.0 {
                (pressure[n], kept) = (-step * residual[n], 0.0);
            }
        }
    }
    4.0 * plane_modulus() * pressure.iter().sum::<f64>() * side_m[0] * side_m[1]
}

#[test]
fn an_elongated_ellipsoid_follows_hertz() {
    if solved_before() {
        return;
    }
    // radii of curvature of 42.7 and 6 mm: the contact is three and a half times as long as it is
    // wide
    let (semi_m, depth_m) = ([0.016, 0.006, 0.006], 6e-5);
    let radii_m = [semi_m[0] * semi_m[0], semi_m[1] * semi_m[1]].map(|square| square / semi_m[2]);
    let (hertz, a_m) = hertz_m2(radii_m, depth_m);
    let block = half_space([a_m, 0.3 * a_m], 2.6e-4, 3000);
    let mut press = above(&block, Shape::Ellipsoid { semi_axes_m: [semi_m[0], semi_m[1]], along: ALONG }, semi_m[2]);
    press.go_to(depth_m, |_| {}).expect("shallow");
    println!("{} nodes, contact {:.2} mm", block.body.mesh.nodes_m.len(), a_m * 1e3);
    assert_within("force", press.force_over_e_m2(), hertz, 0.02);
}

#[test]
fn boundary_elements_agree_with_hertz() {
    let (radii_m, depth_m) = ([0.0427, 0.006], 6e-5);
    let (hertz, a_m) = hertz_m2(radii_m, depth_m);
    let height_m = |x: f64, y: f64| 0.5 * (x * x / radii_m[0] + y * y / radii_m[1]);
    let found = boundary_elements_m2(height_m, depth_m, [1.15 * a_m, 0.4 * a_m], [40, 28]);
    assert_within("force", found, hertz, 0.005);
}

#[test]
fn a_capsule_on_a_large_block_presses_as_boundary_elements_say() {
    if solved_before() {
        return;
    }
    let (radius_m, length_m, depth_m) = (0.006, 0.004, 6e-5);
    let half_m = 0.5 * length_m;
    let height_m = |x: f64, y: f64| radius_m - (radius_m * radius_m - (x - half_m).max(0.0).powi(2) - y * y).sqrt();
    let wide_m = (radius_m * depth_m).sqrt();
    let expected = boundary_elements_m2(height_m, depth_m, [half_m + 1.3 * wide_m, 1.1 * wide_m], [40, 18]);
    let block = half_space([half_m + wide_m, wide_m], 3e-4, 2500);
    let mut press = above(&block, Shape::Capsule { length_m, along: ALONG }, radius_m);
    press.go_to(depth_m, |_| {}).expect("shallow");
    println!("{} nodes", block.body.mesh.nodes_m.len());
    assert_within("force", press.force_over_e_m2(), expected, 0.02);
}

#[test]
fn without_length_or_with_equal_axes_they_are_spheres() {
    let axis = Vector3::new(0.0, 0.6, 0.8);
    let tip_m = Vector3::new(1e-3, -2e-3, 3e-3);
    let of = |shape| RigidProbe::new(shape, 0.006, tip_m, axis);
    let sphere = of(Shape::Sphere);
    let others = [
        of(Shape::Capsule { length_m: 0.0, along: ALONG }),
        of(Shape::Ellipsoid { semi_axes_m: [0.006; 2], along: [1.0, 0.3, 0.2] }),
    ];
    for n in 0..500 {
        let turn = f64::from(n);
        let at_m = tip_m + Vector3::new((1.3 * turn).sin(), (2.1 * turn).cos(), (0.7 * turn).sin()) * 0.011;
        let wanted = sphere.gap(&at_m);
        for probe in others {
            let found = probe.gap(&at_m);
            assert!((found.gap_m - wanted.gap_m).abs() < 1e-15 && (found.normal - wanted.normal).norm() < 1e-11, "{probe:?}");
            assert!((found.curvature_per_m - wanted.curvature_per_m).norm() < 1e-9 * wanted.curvature_per_m.norm(), "{probe:?}");
        }
    }
}

/// Normal and curvature are the derivatives of the distance to the probe.
#[test]
fn normal_and_curvature_are_slopes_of_the_gap() {
    let axis = Vector3::new(0.0, 0.6, 0.8);
    for shape in [
        Shape::Capsule { length_m: 0.01, along: [1.0, 0.5, 0.0] },
        Shape::Ellipsoid { semi_axes_m: [0.012, 0.005], along: [1.0, 0.5, 0.0] },
    ] {
        let probe = RigidProbe::new(shape, 0.006, Vector3::zeros(), axis);
        for n in 0..300 {
            let turn = f64::from(n);
            let way = Vector3::new((1.3 * turn).sin(), (2.1 * turn).cos(), (0.7 * turn).sin()).normalize();
            // points near the surface of the probe, where contact occurs
            let out = way * 0.011 + axis * 0.006;
            let here = probe.gap(&out);
            let at_m = out - here.normal * (here.gap_m + 1e-3 * (0.9 * turn).sin());
            let found = probe.gap(&at_m);
            let step = 1e-8;
            for k in 0..3 {
                let mut off = Vector3::zeros();
                off[k] = step;
                let (more, less) = (probe.gap(&(at_m + off)), probe.gap(&(at_m - off)));
                assert!(((more.gap_m - less.gap_m) / (2.0 * step) - found.normal[k]).abs() < 1e-6, "{shape:?} {at_m}");
                let bend = (more.normal - less.normal) / (2.0 * step) - found.curvature_per_m.column(k);
                assert!(bend.norm() < 1e-3 * found.curvature_per_m.norm(), "{shape:?} {at_m}: {bend}");
            }
        }
    }
}
