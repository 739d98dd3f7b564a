//! The plane that holds a contact and the body above the tip, on shipped patches.

use palpate::stages::presence::{Plane, Presence, buried, locate};
use palpate::{ClampFlags, Params, Vector3};

use crate::guard::Tissue;

/// Height over the touched triangle at which contact is still possible [m].
const SURFACE_M: f32 = 1e-3;

fn corners(tissue: &Tissue, triangle: usize) -> [Vector3<f32>; 3] {
    let model = &tissue.file.model;
    model.triangles[triangle].node.map(|n| Vector3::from(model.nodes[usize::from(n)].rest_m))
}

/// Edges of the surface of the piece that was cut out: the middle relative to the site [m], the
/// outward direction along the surface, the normal.
fn cut_edges() -> Vec<(Vector3<f32>, Vector3<f32>, Vector3<f32>)> {
    let tissue = Tissue::cut();
    let triangles = tissue.file.model.triangles;
    let mut edges = Vec::new();
    for (index, triangle) in triangles.iter().enumerate() {
        for k in 0..3 {
            let ends = [triangle.node[k], triangle.node[(k + 1) % 3]];
            if triangles.iter().filter(|t| ends.iter().all(|end| t.node.contains(end))).count() == 1 {
                let [a, b, c] = [0, 1, 2].map(|n| corners(&tissue, index)[(k + n) % 3]);
                let normal = (b - a).cross(&(c - a)).normalize();
                edges.push((0.5 * (a + b) - tissue.file.site_m, (b - a).cross(&normal).normalize(), normal));
            }
        }
    }
    edges
}

/// Presence of a tip this far from the site [m], and the plane that it touches.
fn place(tissue: &mut Tissue, above_m: Vector3<f32>) -> (Presence, Option<Plane>) {
    let tip_m = tissue.file.site_m + above_m;
    locate(&tissue.file.model, &tissue.tuned, &mut tissue.state, tip_m)
}

/// Presses the tip a millimetre deep at this place; returns the tissue and the plane touched.
fn touched(mut tissue: Tissue, x_m: f32, y_m: f32) -> (Tissue, Plane) {
    for n in 0..=60_u8 {
        tissue.at(Vector3::new(x_m, y_m, 2e-3 - 50e-6 * f32::from(n)));
    }
    let (presence, plane) = place(&mut tissue, Vector3::new(x_m, y_m, -1e-3));
    assert_eq!(presence, Presence::Inside);
    (tissue, plane.expect("it touches"))
}

/// Middles of triangles on the top of a block, away from its sides [m].
fn middles(tissue: &Tissue) -> Vec<[f32; 2]> {
    let middles: Vec<_> = (0..tissue.file.model.triangles.len())
        .map(|triangle| corners(tissue, triangle).into_iter().sum::<Vector3<f32>>() / 3.0 - tissue.file.site_m)
        .filter(|middle_m| middle_m.z.abs() < 1e-6 && middle_m.x.abs() < 30e-3 && middle_m.y.abs() < 30e-3)
        .map(|middle_m| [middle_m.x, middle_m.y])
        .take(6)
        .collect();
    assert!(middles.len() > 3);
    middles
}

#[test]
fn the_plane_is_that_of_a_triangle_under_the_tip() {
    for tissue in [Tissue::new, || Tissue::fine(|_| ())] {
        for [x_m, y_m] in middles(&tissue()) {
            let (tissue, plane) = touched(tissue(), x_m, y_m);
            let found = (0..tissue.file.model.triangles.len()).any(|triangle| {
                let [a, b, c] = corners(&tissue, triangle);
                (plane.middle_m - (a + b + c) / 3.0).norm() < 1e-6
            });
            assert!(found, "{x_m} {y_m}: {plane:?}");
            assert!((plane.normal - Vector3::z()).norm() < 1e-5, "{x_m} {y_m}: {plane:?}");
            assert!((plane.depth_m(Vector3::new(x_m, y_m, -3e-3)) - 3e-3).abs() < 1e-6, "{x_m} {y_m}: {plane:?}");
        }
    }
}

#[test]
fn below_a_tilted_plane_the_ball_is_as_deep_as_its_deepest_point() {
    let (tissue, mut plane) = touched(Tissue::new(), 0.0, 0.0);
    let probe = tissue.file.params.probe;
    for degrees in [0.0_f32, 20.0, 45.0, 80.0] {
        plane.normal = Vector3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let tip_m = plane.middle_m + Vector3::new(1e-3, -2e-3, -3e-3);
        let deepest_m = tip_m + probe.axis * probe.radius_m - plane.normal * probe.radius_m;
        assert!((plane.probe_depth_m(&probe, tip_m) - plane.depth_m(deepest_m)).abs() < 1e-6, "{degrees} degrees");
    }
}

#[cfg(feature = "long-tips")]
#[test]
fn below_a_tilted_plane_a_long_tip_is_as_deep_as_its_deepest_point() {
    let (tissue, mut plane) = touched(Tissue::new(), 0.0, 0.0);
    let (axis, radius_m) = (tissue.file.params.probe.axis, tissue.file.params.probe.radius_m);
    let (along, across) = (Vector3::new(0.8, 0.6, 0.0), axis.cross(&Vector3::new(0.8, 0.6, 0.0)));
    let (length_m, semi_axes_m) = (0.012, [0.014, 0.005]);
    let capsule = palpate::ProbeShape::Capsule { length_m, along };
    let ellipsoid = palpate::ProbeShape::Ellipsoid { semi_axes_m, along };
    for degrees in [0.0_f32, 20.0, 45.0, 80.0, 130.0] {
        for round in [0.0_f32, 70.0, 200.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (s, c) = round.to_radians().sin_cos();
            plane.normal = Vector3::new(sin * c, sin * s, cos);
            let tip_m = plane.middle_m + Vector3::new(1e-3, -2e-3, -3e-3);
            let centre_m = tip_m + axis * radius_m;
            for shape in [capsule, ellipsoid] {
                let deepest_m = (0..400_u16).flat_map(|n| (0..200_u16).map(move |m| (n, m))).map(|(n, m)| {
                    let (turn, lift) = (f32::from(n) * 0.015_75, f32::from(m) * 0.015_75);
                    let unit = Vector3::new(turn.cos() * lift.sin(), turn.sin() * lift.sin(), lift.cos());
                    let at = match shape {
                        palpate::ProbeShape::Ellipsoid { semi_axes_m: [a, b], .. } => {
                            along * (a * unit.x) + across * (b * unit.y) + axis * (radius_m * unit.z)
                        }
                        _ => {
                            (along * unit.x + across * unit.y + axis * unit.z) * radius_m
                                + along * (0.5 * length_m).copysign(unit.x)
                        }
                    };
                    plane.depth_m(centre_m + at)
                });
                let deepest_m = deepest_m.fold(f32::MIN, f32::max);
                let depth_m = plane.probe_depth_m(&palpate::Probe { shape, radius_m, axis }, tip_m);
                assert!(
                    (0.0..4e-6).contains(&(depth_m - deepest_m + 1e-7)),
                    "{degrees} {round} {shape:?}: {depth_m} {deepest_m}"
                );
            }
        }
    }
}

#[test]
fn a_plane_is_steep_beyond_forty_five_degrees() {
    let (_, plane) = touched(Tissue::new(), 0.0, 0.0);
    let tilted = |degrees: f32| plane.steep(Vector3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()));
    assert!(!tilted(0.0) && !tilted(45.0) && tilted(46.0) && tilted(90.0) && tilted(180.0));
}

#[test]
fn over_the_triangle_touched_last_contact_is_possible_up_to_a_millimetre_and_no_further_beyond_its_edges_than_the_ball_reaches() {
    for tissue in [Tissue::new, || Tissue::fine(|_| ())] {
        for [x_m, y_m] in middles(&tissue()) {
            let over = |above_m: Vector3<f32>| {
                let (mut tissue, plane) = touched(tissue(), x_m, y_m);
                let above_m = plane.middle_m - tissue.file.site_m + above_m;
                (place(&mut tissue, above_m).0, tissue.at(above_m).outside)
            };
            let (tissue, plane) = touched(tissue(), x_m, y_m);
            let radius_m = tissue.file.params.probe.radius_m;
            let near_m = radius_m + SURFACE_M;
            let touched_m = (0..tissue.file.model.triangles.len())
                .map(|triangle| corners(&tissue, triangle))
                .find(|[a, b, c]| (plane.middle_m - (a + b + c) / 3.0).norm() < 1e-6)
                .unwrap();
            assert_eq!(over(Vector3::new(0.0, 0.0, 0.95e-3)), (Presence::AtSurface, false), "{x_m} {y_m}");
            assert_eq!(over(Vector3::new(0.0, 0.0, 1.05e-3)), (Presence::Outside, true), "{x_m} {y_m}");
            let high_m = 0.5e-3;
            for way in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
                // the distance at which the probe leaves the edge that it passes first
                let [a, b, c] = touched_m;
                let aside_m = [(a, b), (b, c), (c, a)]
                    .map(|(p, q)| {
                        let out = Vector3::new((q - p).y, -(q - p).x, 0.0).normalize();
                        let out = if out.dot(&(plane.middle_m - p)) < 0.0 { out } else { -out };
                        let speed = out.dot(&way);
                        if speed > 0.0 { (near_m - out.dot(&(plane.middle_m - p))) / speed } else { f32::INFINITY }
                    })
                    .into_iter()
                    .fold(f32::INFINITY, f32::min);
                let at = |off_m: f32| over(way * (aside_m + off_m) + Vector3::new(0.0, 0.0, high_m)).0;
                assert_eq!((at(-0.05e-3), at(0.05e-3)), (Presence::AtSurface, Presence::Outside), "{x_m} {y_m} {way}");
            }
        }
    }
}

#[test]
fn a_body_is_buried_when_no_press_can_have_brought_it_there() {
    // the point above the tip that stays outside in every press: one radius, or a millimetre more
    // than the deepest press
    let small = |params: &mut Params| params.probe.radius_m = 2e-3;
    for (mut tissue, above_m) in [(Tissue::new(), 8e-3), (Tissue::with(small), 7e-3), (Tissue::fine(|_| ()), 8e-3)] {
        for (deep_m, is) in [(above_m - 0.1e-3, false), (above_m + 0.1e-3, true), (30e-3, true), (3e-3, false), (-5e-3, false)] {
            let above_m = Vector3::new(3e-3, 2e-3, -deep_m);
            let mut found = !is;
            // from any start a walk takes a few ticks
            for _ in 0..20 {
                place(&mut tissue, above_m);
                let tip_m = tissue.file.site_m + above_m;
                found = buried(&tissue.file.model, &tissue.tuned, &mut tissue.state, tip_m);
            }
            assert_eq!(found, is, "{deep_m} m deep");
        }
    }
}

#[test]
fn a_tip_that_left_by_the_cut_gives_no_force_while_its_ball_still_touches() {
    let mut touching = 0;
    for (edge, out, normal) in cut_edges() {
        let mut tissue = Tissue::cut();
        let at = |aside_m: f32, high_m: f32| edge + out * aside_m + normal * high_m;
        (0..=100_u8).for_each(|n| _ = tissue.at(at(-2e-3, 3e-3 - 50e-6 * f32::from(n))));
        if tissue.at(at(-2e-3, -2e-3)).force_n == Vector3::zeros() {
            continue;
        }
        let mut left = 0;
        for n in 0..40_u8 {
            let output = tissue.at(at(-2e-3 + 0.1e-3 * f32::from(n), -2e-3));
            assert_eq!(output.fault, None);
            if output.outside {
                left += 1;
                assert!(output.force_n == Vector3::zeros() && output.depth_m == 0.0, "{edge}: {output:?}");
                assert!(left > 2 || output.limiters.contains(ClampFlags::BURIED), "{edge}: {output:?}");
            }
        }
        touching += usize::from(left > 0);
    }
    assert!(touching > 6, "{touching} edges");
}

#[test]
fn over_the_edge_of_a_cut_the_surface_is_entered_from_above() {
    let mut entered = 0;
    for (edge, out, normal) in cut_edges() {
        let mut tissue = Tissue::cut();
        let at = |aside_m: f32, high_m: f32| edge + out * aside_m + normal * high_m;
        (0..=40_u8).for_each(|n| assert!(tissue.at(at(0.3e-3, 5e-3 - 0.12e-3 * f32::from(n))).outside));
        let output = tissue.at(at(-0.3e-3, -0.2e-3));
        if !output.outside {
            entered += 1;
            assert!(!output.limiters.contains(ClampFlags::BURIED), "{edge}: {output:?}");
        }
    }
    assert!(entered > 6, "{entered} edges");
}
