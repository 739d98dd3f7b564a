//! The geometry that the checks use agrees with geometry computed independently.

use palpate::Vector3;
use palpate_loop::closed_loop::watch::{HalfSpace, RestShape};

use crate::no_force_without_contact::{GROUND, patch_named};

fn at(mm: [f64; 3]) -> Vector3<f64> {
    Vector3::from(mm) * 1e-3
}

/// The block measures 80 x 80 x 40 mm, has its top at z = 0, and can be touched on all sides except
/// from below. Distances are those of a box.
#[test]
fn the_block_is_a_box() {
    let ground = &*GROUND;
    let block = &ground.patches[patch_named(ground, "block-130")].shape;
    let radius_m = 8e-3;
    let box_m = |p: Vector3<f64>| {
        let out = |k: usize, low: f64, high: f64| (low - p[k]).max(p[k] - high).max(0.0);
        Vector3::new(out(0, -0.04, 0.04), out(1, -0.04, 0.04), out(2, -0.04, 0.0)).norm()
    };
    let mut judged = [0; 3];
    for x in -12..=12 {
        for y in -12..=12 {
            for z in -14..=6 {
                let p = Vector3::new(f64::from(x) * 5.1e-3, f64::from(y) * 4.9e-3, f64::from(z) * 4.3e-3);
                let (outside_m, far_m) = (block.outside_m(&p), box_m(p));
                assert!((block.distance_m(&p) - far_m).abs() < 1e-7, "{p}: {}", block.distance_m(&p));
                assert_eq!(block.contains(&p), far_m == 0.0, "{p}");
                let gap_m = (box_m(p + Vector3::z() * radius_m) - radius_m).max(0.0);
                let above = p.z >= 0.0;
                let beneath = p.z < -0.04 && p.x.abs() < 0.03 && p.y.abs() < 0.03;
                let expected = match (far_m == 0.0, above, beneath) {
                    (true, ..) => 0.0,
                    (_, true, _) => gap_m,
                    (.., true) => far_m,
                    // beside the block: the gap of the ball, or the distance of the tip if the
                    // ball's surface is above it
                    _ if (outside_m - gap_m).abs() < 1e-7 => gap_m,
                    _ => far_m,
                };
                assert!((outside_m - expected).abs() < 1e-7, "{p}: {outside_m} instead of {expected}");
                judged = [judged[0] + u32::from(above), judged[1] + u32::from(beneath), judged[2] + u32::from(far_m == 0.0)];
            }
        }
    }
    assert!(judged.iter().all(|n| *n > 200), "{judged:?}");
}

#[test]
fn the_normals_are_those_of_the_touchable_faces_that_the_ball_can_press() {
    let ground = &*GROUND;
    let block = &ground.patches[patch_named(ground, "block-130")].shape;
    let [x, z] = [Vector3::x(), Vector3::z()];
    for (inside, faces) in [([0.0, 0.0, -1.0], vec![z]), ([35.0, -20.0, -20.0], vec![x]), ([35.0, -20.0, -4.0], vec![x, z])] {
        let normals = block.normals(&at(inside));
        assert!(block.inside(&at(inside)) && !normals.is_empty(), "{inside:?}");
        for face in &faces {
            assert!(normals.iter().any(|n| (n - face).norm() < 1e-6), "{inside:?}: {normals:?} lack {face}");
        }
        let others = normals.iter().filter(|n| faces.iter().all(|face| (*n - face).norm() > 1e-6)).count();
        assert_eq!(others, 0, "{inside:?}: {normals:?}");
    }
    for outside in [[0.0, 0.0, 1.0], [45.0, 0.0, -2.0], [0.0, 0.0, -41.0]] {
        assert!(!block.inside(&at(outside)), "{outside:?}");
    }
    // just above the bottom, which cannot be touched
    assert!(block.normals(&at([0.0, 0.0, -39.5])).iter().all(|n| n.z > -1e-6));
}

#[test]
fn every_patch_holds_its_site_and_a_ball_above_it_is_outside_by_its_height() {
    let ground = &*GROUND;
    for patch in &ground.patches {
        let point = |out_m: f64| patch.point_m(&[0.0, 0.0, out_m]);
        assert!(patch.shape.contains(&point(-1e-3)), "{}", patch.name);
        for out_m in [0.5e-3, 2e-3, 10e-3] {
            let seen_m = patch.shape.outside_m(&point(out_m));
            // an organ's surface is not flat: the ball may be nearer to a bulge than its tip is to
            // the site
            assert!(seen_m <= out_m + 1e-6 && seen_m > 0.5 * out_m - 0.2e-3, "{}: {seen_m} at {out_m}", patch.name);
        }
    }
}

#[test]
fn a_half_space_begins_at_its_plane() {
    let space = HalfSpace { at_m: Vector3::zeros(), normal: Vector3::z() };
    assert_eq!((space.outside_m(&at([1.0, 2.0, 3.0])), space.outside_m(&at([1.0, 2.0, -3.0]))), (3e-3, 0.0));
    assert!(!space.inside(&at([0.0, 0.0, 1.0])) && space.inside(&at([0.0, 0.0, -1.0])));
}
