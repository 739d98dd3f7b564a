//! The position of the sensed tip decides whether anything can be felt: geometry alone, whatever
//! tip the patch is given.

use palpate::haptic::mode::Mode;
use palpate::stages::presence::{Presence, locate};
use palpate::{ClampFlags, Fault, Output, ProbeShape, Vector3};

use crate::bench::{Bench, pushing};
use crate::guard::Tissue;

/// Speed of a moving tip [m per tick].
const STEP_M: f32 = 0.4e-3;

/// Corners of the box around the rest shape, relative to the site [m].
fn extent(tissue: &Tissue) -> [Vector3<f32>; 2] {
    let rest = || tissue.file.model.nodes.iter().map(|node| Vector3::from(node.rest_m) - tissue.file.site_m);
    [rest().fold(Vector3::repeat(1.0), |low, at| low.inf(&at)), rest().fold(Vector3::repeat(-1.0), |high, at| high.sup(&at))]
}

/// Whether a point (relative to the site [m]) is in one of the tets, by a search of all of them.
fn in_a_tet(tissue: &Tissue, above_m: Vector3<f32>) -> bool {
    let model = &tissue.file.model;
    let tip_m = tissue.file.site_m + above_m;
    model.tets.iter().any(|tet| {
        let [a, b, c, d] = tet.node.map(|n| Vector3::from(model.nodes[usize::from(n)].rest_m));
        let volume = |p: Vector3<f32>, q: Vector3<f32>, r: Vector3<f32>, s: Vector3<f32>| (q - p).cross(&(r - p)).dot(&(s - p));
        [volume(tip_m, b, c, d), volume(a, tip_m, c, d), volume(a, b, tip_m, d), volume(a, b, c, tip_m)].iter().all(|v| *v >= 0.0)
    })
}

/// Moves the tip in a straight line, and calls `check` in every tick with its position relative to
/// the site [m] and the output.
fn go(tissue: &mut Tissue, from_m: Vector3<f32>, to_m: Vector3<f32>, step_m: f32, mut check: impl FnMut(Vector3<f32>, &Output)) {
    let ticks = ((to_m - from_m).norm() / step_m).ceil().max(1.0);
    for n in 0..=ticks as usize {
        let at_m = from_m + (to_m - from_m) * (n as f32 / ticks);
        let output = tissue.at(at_m);
        assert_eq!(output.fault, None, "{at_m}");
        check(at_m, &output);
    }
}

/// Checks that no force is felt; the cycle discards a force that is computed outside.
fn nothing(at_m: Vector3<f32>, output: &Output) {
    assert!(output.outside || output.force_n == Vector3::zeros(), "{at_m}: {output:?}");
}

#[test]
fn a_probe_that_leaves_by_a_side_or_from_below_feels_nothing_outside_until_it_comes_anew() {
    let ends = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), -Vector3::z()];
    for end in ends {
        let mut tissue = Tissue::new();
        let [low_m, high_m] = extent(&tissue);
        let far_m = end * ((high_m - low_m).norm() + 0.02);
        let down_m = Vector3::new(0.0, 0.0, -2e-3);
        assert!(tissue.press(2e-3).force_n.z > 0.02);
        let mut left = false;
        go(&mut tissue, down_m, down_m + far_m, STEP_M, |at_m, output| {
            let clear = (0..3).any(|k| at_m[k] < low_m[k] - 1.5e-3 || at_m[k] > high_m[k] + 1.5e-3);
            if clear {
                left = true;
                nothing(at_m, output);
            }
        });
        assert!(left);
        for _ in 0..100 {
            let output = tissue.at(down_m + far_m);
            nothing(down_m + far_m, &output);
        }
        // back on the same path: inside, but not through the surface
        go(&mut tissue, down_m + far_m, down_m, STEP_M, nothing);
        assert!(tissue.at(down_m).limiters.contains(ClampFlags::BURIED) && !tissue.at(down_m).outside);
        go(&mut tissue, down_m, Vector3::new(0.0, 0.0, 12e-3), STEP_M, nothing);
        assert!(tissue.press(2e-3).force_n.z > 0.02, "a fresh approach from outside");
    }
}

#[test]
fn round_the_tissue_at_any_speed_the_patch_is_shown_the_tip_where_it_is() {
    for step_m in [0.5e-3, 2e-3, 3e-3, 20e-3] {
        let mut tissue = Tissue::new();
        let [low_m, high_m] = extent(&tissue);
        let (out_m, under_m) = (high_m.x + 25e-3, low_m.z - 20e-3);
        let corners = [[-out_m, under_m], [-out_m, 20e-3], [out_m, 20e-3], [out_m, under_m], [-out_m, under_m]];
        for pair in corners.windows(2) {
            let [from_m, to_m] = [pair[0], pair[1]].map(|[x, z]| Vector3::new(x, 0.0, z));
            let site_m = tissue.file.site_m;
            go(&mut tissue, from_m, to_m, step_m, |at_m, output| {
                assert_eq!((output.force_n, output.apart_m), (Vector3::zeros(), 0.0), "{at_m}");
                assert!((output.point_m - site_m - at_m).norm() < 1e-6, "{at_m}: shown at {}", output.point_m);
                assert!(output.outside, "{at_m}");
            });
        }
    }
}

#[test]
fn what_is_inside_is_what_lies_in_a_tet() {
    let (mut inside, mut outside) = (0, 0);
    let mut seed = 1_u32;
    let mut number = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    for _ in 0..400 {
        let mut tissue = Tissue::new();
        let [low_m, high_m] = extent(&tissue);
        let share = Vector3::new(number(), number(), number()) * 1.2 - Vector3::repeat(0.1);
        let above_m = low_m + (high_m - low_m).component_mul(&share);
        let tip_m = tissue.file.site_m + above_m;
        let (presence, plane) = locate(&tissue.file.model, &tissue.tuned, &mut tissue.state, tip_m);
        let right = if in_a_tet(&tissue, above_m) { Presence::Inside } else { Presence::Outside };
        assert_eq!((presence, plane.is_some()), (right, false), "{above_m}");
        *(if right == Presence::Inside { &mut inside } else { &mut outside }) += 1;
    }
    assert!(inside > 50 && outside > 50, "{inside} inside, {outside} outside");
}

#[test]
fn a_tip_that_wanders_through_the_tissue_is_located_in_every_tick() {
    let mut tissue = Tissue::new();
    let [low_m, high_m] = extent(&tissue);
    let mut seed = 3_u32;
    let mut number = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    // it enters through a side and stays below the top
    let mut at_m = Vector3::new(low_m.x - 5e-3, 0.0, -0.5 * (high_m.z - low_m.z));
    let (mut located, mut ticks) = (0, 0);
    for _ in 0..60 {
        let to_m = Vector3::new(
            low_m.x - 4e-3 + (high_m.x - low_m.x + 8e-3) * number(),
            low_m.y - 4e-3 + (high_m.y - low_m.y + 8e-3) * number(),
            low_m.z - 4e-3 - (low_m.z - high_m.z) * 0.7 * number(),
        );
        let before = Tissue::new();
        go(&mut tissue, at_m, to_m, 1.4e-3, |at_m, output| {
            let (inside, clear) =
                (in_a_tet(&before, at_m), (0..3).any(|k| at_m[k] < low_m[k] - 2e-3 || at_m[k] > high_m[k] + 2e-3));
            assert!(!(inside && output.outside), "{at_m}: inside");
            assert!(!clear || output.force_n == Vector3::zeros() || output.outside, "{at_m}: {output:?}");
            located += usize::from(output.outside != inside);
            ticks += 1;
        });
        at_m = to_m;
    }
    // in the other ticks the probe touches a side with its tip outside
    assert!(located * 10 > ticks * 8, "{located} of {ticks} ticks");
}

#[test]
fn a_flat_tip_below_the_tissue_feels_nothing() {
    // the block ends 40 mm below its site; its sides and its underside have long triangles
    for (radius_m, x_m) in [(3e-3, 25e-3), (4e-3, 12e-3), (4e-3, -25e-3), (2e-3, 0.0)] {
        for z_m in [-42e-3, -46e-3, -50e-3, -55e-3] {
            for stops_m in [45e-3, 40.2e-3, 36e-3] {
                let mut tissue =
                    Tissue::with(|params| (params.probe.shape, params.probe.radius_m) = (ProbeShape::Flat, radius_m));
                let turns =
                    [[70e-3, 20e-3], [70e-3, z_m], [30e-3, z_m], [stops_m, z_m]].map(|[y_m, z_m]| Vector3::new(x_m, y_m, z_m));
                let mut forced = 0;
                for leg in turns.windows(2) {
                    go(&mut tissue, leg[0], leg[1], 0.05e-3, |at_m, output| {
                        let below = at_m.z < -41e-3 && output.force_n != Vector3::zeros();
                        forced = if below { forced + 1 } else { 0 };
                        assert!(forced <= 5, "{radius_m} m, {at_m}: {output:?}");
                    });
                }
                let rest = (0..50).map(|_| tissue.at(turns[3])).last().expect("ticks");
                assert_eq!(rest.force_n, Vector3::zeros(), "{radius_m} m, {}", turns[3]);
            }
        }
    }
}

/// Points of a wall behind a flat end used to push it up: 3 N, 2.3 mm below the block.
#[test]
fn a_flat_tip_that_comes_up_along_a_wall_feels_nothing_below_the_block() {
    for radius_m in [4e-3, 5e-3, 6e-3] {
        for x_m in [26e-3, 16e-3, 0.0, -11e-3] {
            let mut tissue = Tissue::with(|params| (params.probe.shape, params.probe.radius_m) = (ProbeShape::Flat, radius_m));
            let turns = [[70.0, 20.0], [70.0, -46.0], [39.6, -43.8], [40.5, -40.8], [41.0, -30.0]];
            let turns = turns.map(|[y_mm, z_mm]: [f32; 2]| Vector3::new(x_m, y_mm * 1e-3, z_mm * 1e-3));
            for leg in turns.windows(2) {
                go(&mut tissue, leg[0], leg[1], 0.05e-3, |at_m, output| {
                    // outside, the cycle drops a force
                    let felt = !output.outside && output.force_n != Vector3::zeros();
                    assert!(at_m.z >= -41e-3 || !felt, "{radius_m} m, {at_m}: {output:?}");
                });
            }
        }
    }
}

#[test]
fn a_straight_press_beyond_the_depth_limit_comes_back_the_way_it_went_in() {
    let mut tissue = Tissue::new();
    let limit_m = tissue.file.model.depth_limit_m;
    let pressed = tissue.press(limit_m + 3e-3);
    assert!((pressed.apart_m - 3e-3).abs() < 0.2e-3, "{pressed:?}");
    let end_m = Vector3::new(0.0, 0.0, -limit_m - 3e-3);
    go(&mut tissue, end_m, end_m + Vector3::new(0.0, 0.0, 2e-3), 0.04e-3, |_, output| assert!(!output.outside));
    let back = tissue.high(-limit_m - 1e-3);
    assert!((pressed.depth_m - back.depth_m - 2e-3).abs() < 0.02e-3, "{} m deep, then {}", pressed.depth_m, back.depth_m);
    // the same beside the first press: the place where the limit was met is forgotten above the
    // limit
    let above_m = Vector3::new(0.0, 0.0, 2e-3 - limit_m);
    let beside_m = Vector3::new(3e-3, 0.0, 0.0);
    let rest = |tissue: &mut Tissue, at_m: Vector3<f32>| {
        let output = (0..200).map(|_| tissue.at(at_m)).last().expect("ticks");
        output.depth_m - output.apart_m
    };
    go(&mut tissue, end_m + Vector3::new(0.0, 0.0, 2e-3), above_m, 0.04e-3, |_, _| ());
    go(&mut tissue, above_m, above_m + beside_m, 0.04e-3, |_, _| ());
    go(&mut tissue, above_m + beside_m, end_m + beside_m, 0.3e-3, |_, _| ());
    let pressed_m = rest(&mut tissue, end_m + beside_m);
    let back_m = rest(&mut tissue, end_m + beside_m + Vector3::new(0.0, 0.0, 2.8e-3));
    assert!((pressed_m - back_m).abs() < 0.05e-3, "beside: {pressed_m} m deep, then {back_m}");
}

#[test]
fn a_hand_that_slid_beyond_the_depth_limit_comes_back_as_far_as_it_moves() {
    let mut tissue = Tissue::new();
    let limit_m = tissue.file.model.depth_limit_m;
    tissue.press(limit_m + 3e-3);
    let mut at_m = Vector3::new(0.0, 0.0, -limit_m - 3e-3);
    let mut leg = |tissue: &mut Tissue, displacement_m: Vector3<f32>| {
        let mut depth_m = 0.0;
        go(tissue, at_m, at_m + displacement_m, 0.04e-3, |_, output| {
            assert!(!output.outside);
            depth_m = output.depth_m;
        });
        at_m += displacement_m;
        depth_m
    };
    let slid_m = leg(&mut tissue, Vector3::new(2e-3, 0.0, 0.0));
    let back_m = leg(&mut tissue, Vector3::new(0.0, 0.0, 2e-3));
    assert!((slid_m - back_m - 2e-3).abs() < 0.3e-3, "{slid_m} m deep, then {back_m}");
    // deeper than before, the limit holds, and again every millimetre back counts
    let deepest_m = leg(&mut tissue, Vector3::new(0.0, 0.0, -5e-3));
    assert!((deepest_m - slid_m).abs() < 0.3e-3, "{slid_m} m deep, then {deepest_m}");
    let back_m = leg(&mut tissue, Vector3::new(0.0, 0.0, 2e-3));
    assert!((deepest_m - back_m - 2e-3).abs() < 0.3e-3, "{deepest_m} m deep, then {back_m}");
}

/// Work of the hand over closed paths beyond the depth limit [J], positive into the tissue.
#[test]
fn a_path_beyond_the_depth_limit_gives_the_hand_no_energy() {
    for way in [1.0, -1.0] {
        for tissue in [Tissue::new, Tissue::cut] {
            let mut tissue = tissue();
            let (axis, limit_m) = (tissue.tuned.probe().axis, tissue.file.model.depth_limit_m);
            let across = axis.cross(&Vector3::new(0.3, way, 0.2)).normalize();
            let [high, deep] = [axis * 2e-3, -axis * (limit_m + 4e-3)];
            let corners = [high, deep, deep + across * 4e-3, high + across * 4e-3, high];
            go(&mut tissue, axis * 5e-3, high, 0.02e-3, |_, _| ());
            let (mut work_j, mut most_j) = (0.0, 0.0_f32);
            for ends in corners.windows(2) {
                let mut from_m = ends[0];
                go(&mut tissue, ends[0], ends[1], 0.02e-3, |at_m, output| {
                    work_j -= output.force_n.dot(&(at_m - from_m));
                    (from_m, most_j) = (at_m, most_j.max(work_j));
                });
            }
            assert!(most_j > 1e-4 && work_j > -0.002 * most_j, "{work_j} J of {most_j} J");
        }
    }
}

#[test]
fn a_hand_two_radii_beyond_the_shown_tip_has_pushed_through() {
    let mut tissue = Tissue::new();
    let (limit_m, radius_m) = (tissue.file.model.depth_limit_m, tissue.file.params.probe.radius_m);
    tissue.press(limit_m);
    let mut ends_m = None;
    let below = |beyond_m: f32| Vector3::new(0.0, 0.0, -limit_m - beyond_m);
    go(&mut tissue, below(0.0), below(2.5 * radius_m), 0.2e-3, |at_m, output| {
        if output.force_n == Vector3::zeros() && ends_m.is_none() {
            ends_m = Some(-at_m.z - limit_m);
        }
        assert!(ends_m.is_none() || output.force_n == Vector3::zeros(), "{at_m}: {output:?}");
    });
    let ends_m = ends_m.expect("no force far below");
    assert!((ends_m - 2.0 * radius_m).abs() < 0.5e-3, "{ends_m} m beyond, radius {radius_m} m");
}

#[test]
fn a_tip_that_outran_the_speed_limit_before_the_first_touch_feels_nothing() {
    let mut tissue = Tissue::new();
    let radius_m = tissue.file.params.probe.radius_m;
    tissue.high(1.2 * radius_m);
    for tick in 0..40 {
        let output = tissue.high(-2e-3);
        assert_eq!(output.force_n, Vector3::zeros(), "tick {tick}: {output:?}");
    }
    assert!(tissue.press(2e-3).force_n.z > 0.0, "a fresh approach is answered");
}

#[test]
fn a_force_outside_is_dropped_in_the_same_tick_and_a_fault_if_it_goes_on() {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.0);
    bench.wall.answer = Some(Output { outside: true, grip_n: 0.5, ..pushing(5e-3, 2.0) });
    for tick in 0..5 {
        let record = bench.tick();
        assert_eq!((record.applied_n, record.fault), (Vector3::zeros(), None), "tick {tick}");
        let output = record.output;
        assert_eq!(
            (output.force_n, output.normal, output.depth_m, output.grip_n),
            (Vector3::zeros(), Vector3::zeros(), 0.0, 0.0),
            "no contact is told"
        );
        assert!(!bench.cycle.in_contact());
    }
    let record = bench.tick();
    assert_eq!((record.fault, record.mode), (Some(Fault::TipApart), Mode::Fault));
    // a tip that is outside and feels no force is in free space, which is no fault
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(Output { outside: true, ..Output::NONE });
    assert_eq!(bench.ticks(200).fault, None);
}

#[test]
fn beside_an_edge_the_touch_ends_where_the_tissue_does() {
    for end in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
        let mut tissue = Tissue::new();
        let [low_m, high_m] = extent(&tissue);
        let edge_m = end * (high_m - low_m).x.min((high_m - low_m).y) * 0.5;
        let near_m = edge_m - end * 5e-3;
        let up_m = Vector3::new(0.0, 0.0, 6e-3);
        let down_m = near_m - Vector3::new(0.0, 0.0, 2.5e-3);
        let mut pressed = false;
        go(&mut tissue, near_m + up_m, down_m, 0.05e-3, |_, output| pressed |= output.force_n.z > 0.01);
        assert!(pressed);
        go(&mut tissue, down_m, down_m + end * 30e-3, STEP_M, |at_m, output| {
            assert!((at_m - edge_m).dot(&end) < 0.5e-3 || output.outside, "{at_m}: {output:?}");
        });
    }
}

#[test]
fn from_behind_a_cut_nothing_is_felt() {
    let mut tissue = Tissue::cut();
    let out = tissue.file.params.probe.axis;
    go(&mut tissue, out * 8e-3, out * -1.5e-3, 0.05e-3, |_, _| ());
    assert!(tissue.at(out * -1.5e-3).force_n.norm() > 0.01, "by its surface it is");
    let mut tissue = Tissue::cut();
    let [low_m, high_m] = extent(&tissue);
    go(&mut tissue, out * -((high_m - low_m).norm() + 0.02), out * -1.5e-3, STEP_M, nothing);
    assert!(tissue.at(out * -1.5e-3).limiters.contains(ClampFlags::BURIED));
}

#[test]
fn a_jump_through_the_tissue_is_not_swept() {
    let mut tissue = Tissue::with(|params| params.substeps = 4);
    let [low_m, high_m] = extent(&tissue);
    for n in 0..10 {
        let x_m = if n % 2 == 0 { high_m.x + 20e-3 } else { low_m.x - 20e-3 };
        let output = tissue.at(Vector3::new(x_m, 0.0, -3e-3));
        assert_eq!((output.force_n, output.apart_m, output.fault), (Vector3::zeros(), 0.0, None), "jump {n}");
    }
}

#[test]
fn from_below_a_block_is_not_felt_inside() {
    let mut tissue = Tissue::new();
    let [low_m, high_m] = extent(&tissue);
    let deep_m = 0.5 * low_m.z;
    for from_m in [Vector3::new(5e-3, -3e-3, low_m.z - 20e-3), Vector3::new(-8e-3, 0.0, low_m.z - 9e-3)] {
        for _ in 0..2 {
            let to_m = Vector3::new(0.0, 0.0, deep_m);
            let mut inside = 0;
            go(&mut tissue, from_m, to_m, STEP_M, |at_m, output| {
                if (0..3).all(|k| at_m[k] > low_m[k] + 1e-3 && at_m[k] < high_m[k] - 1e-3) {
                    inside += 1;
                    nothing(at_m, output);
                }
            });
            assert!(inside > 20, "{inside} ticks");
            go(&mut tissue, to_m, from_m, STEP_M, |_, _| ());
        }
    }
}
