//! Compares the pushes with sums in double precision over every point, and checks the shapes by
//! their geometry.

#![expect(clippy::disallowed_types, reason = "the sums are in double precision, and no part of the image")]

extern crate std;

use std::vec;
use std::vec::Vec;

use super::*;
use crate::model::FoundationPoint;
use crate::{MOST_TERMS, NodeStep, Params, PatchFile, PronyTerm, TetShapes};

const RADIUS_M: f32 = 6e-3;

fn check<P: Points<Q>, const Q: usize>() {
    let corners = [[1.0, 0.0, 0.5], [0.0, 3.0, 0.25], [-2.0, 0.5, 7.0]].map(Vector3::from);
    let weights = point_weights(Q);
    for (point, w) in P::at(corners).iter().zip(weights) {
        let expected = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
        assert!((point - expected).norm() < 1e-5, "{point} {expected}");
    }
    let on: [f32; Q] = core::array::from_fn(|n| 1.0 + (n * n) as f32);
    for (k, shared) in P::shared(on).iter().enumerate() {
        let expected: f32 = on.iter().zip(weights).map(|(f, w)| f * w[k]).sum();
        assert!((shared - expected).abs() < 1e-4, "{shared} {expected}");
    }
}

#[test]
fn points_are_the_weighted_corners_and_share_by_the_same_weights() {
    check::<Four, 4>();
    check::<Nine, 9>();
    check::<Sixteen, 16>();
}

fn probe(shape: ProbeShape) -> Probe {
    Probe { shape, radius_m: RADIUS_M, axis: Vector3::new(0.0, 0.6, 0.8) }
}

/// A point given by its distance from the axis and its height along the axis, both in radii, and by
/// its direction around the axis. Also returns that direction.
fn at(probe: &Probe, off: f32, height: f32, degrees: f32) -> (Vector3<f32>, Vector3<f32>) {
    let (x, y) = (Vector3::x(), probe.axis.cross(&Vector3::x()));
    let (sin, cos) = degrees.to_radians().sin_cos();
    let across = x * cos + y * sin;
    ((across * off + probe.axis * height) * RADIUS_M, across)
}

fn is(found: Option<(f32, Vector3<f32>)>, right: Option<(f32, Vector3<f32>)>, what: &str) {
    match (found, right) {
        (None, None) => {}
        (Some((pen, out)), Some((right_pen, right_out))) => {
            assert!((pen - right_pen).abs() < 1e-5 * RADIUS_M && (out - right_out).norm() < 1e-4, "{what}: {pen} {out}");
        }
        _ => panic!("{what}: {found:?}, not {right:?}"),
    }
}

#[test]
fn a_ball_pushes_from_its_centre_and_a_shaft_from_its_axis() {
    for shape in [ProbeShape::Hemisphere, ProbeShape::Sphere] {
        let probe = probe(shape);
        for shaft in [false, true] {
            for (off, height) in
                [(0.3, -0.5), (0.6, 0.3), (0.9, 0.3), (0.9, -0.5), (0.2, 3.0), (1.1, 3.0), (0.7, 0.8), (0.0, -0.2)]
            {
                let (d, across) = at(&probe, off, height, 50.0);
                let cylinder = shaft && shape == ProbeShape::Hemisphere && height > 0.0;
                let (length, out) = if cylinder { (off * RADIUS_M, across) } else { (d.norm(), d.normalize()) };
                let right = (length < RADIUS_M).then_some((RADIUS_M - length, out));
                is(penetration(&probe, shaft, d), right, &std::format!("{shape:?} {shaft} {off} {height}"));
            }
            is(penetration(&probe, shaft, ZERO), Some((RADIUS_M, -probe.axis)), "the centre");
        }
    }
}

#[test]
fn a_flat_end_pushes_down_and_its_edge_is_round() {
    let probe = probe(ProbeShape::Flat);
    let (edge, inner) = (1.0 / 16.0, 15.0 / 16.0);
    for shaft in [false, true] {
        for degrees in [0.0, 130.0, 250.0] {
            for (off, height) in [(0.5, 0.3), (0.9, 0.01), (0.0, 0.99), (0.3, 1.5), (0.3, -0.01), (1.01, 0.5)] {
                let (d, _) = at(&probe, off, height, degrees);
                let inside = height > 0.0 && off < 1.0 && (shaft || height < 1.0);
                let right = inside.then_some((height * RADIUS_M, -probe.axis));
                is(penetration(&probe, shaft, d), right, &std::format!("{shaft} {off} {height}"));
            }
            for (off, height) in
                [(0.96, 0.03), (0.98, 0.05), (0.99, 0.02), (0.99, 0.3), (0.95, 0.8), (0.999, 0.001), (0.97, edge)]
            {
                let (d, across) = at(&probe, off, height, degrees);
                // from the ring inside the edge
                let arm = across * (off - inner) - probe.axis * if height < edge { edge - height } else { 0.0 };
                let right = (arm.norm() < edge).then_some(((edge - arm.norm()) * RADIUS_M, arm.normalize()));
                is(penetration(&probe, shaft, d), right, &std::format!("edge {off} {height}"));
            }
        }
    }
}

#[test]
fn the_centre_is_a_radius_above_a_round_tip_and_at_a_flat_one() {
    let tip_m = Vector3::new(1.0, 2.0, 3.0);
    for (shape, times) in [(ProbeShape::Hemisphere, 1.0), (ProbeShape::Sphere, 1.0), (ProbeShape::Flat, 0.0)] {
        let of = probe(shape);
        assert!((centre_m(&of, tip_m) - tip_m - of.axis * (times * RADIUS_M)).norm() < 1e-6, "{shape:?}");
    }
}

/// A triangle whose first corner is `a`, with this normal.
fn facing(a: Vector3<f32>, normal: Vector3<f32>) -> [Vector3<f32>; 3] {
    let u = normal.cross(&Vector3::new(0.3, 0.5, -0.8)).normalize();
    let v = normal.cross(&u);
    [a, a + u * 2e-3 + v * 1e-3, a - u * 1e-3 + v * 3e-3]
}

#[test]
fn a_triangle_is_pressed_from_in_front_and_by_a_handle_not_from_below() {
    let lift = Vector3::new(1e-3, -2e-3, 3e-3);
    for shape in [ProbeShape::Hemisphere, ProbeShape::Flat, ProbeShape::Sphere] {
        let of = probe(shape);
        for tangent in [Vector3::x(), of.axis.cross(&Vector3::x()), -Vector3::x()] {
            for (degrees, below) in [(0.0, false), (60.0, false), (90.0, false), (119.0, false), (121.0, true), (180.0, true)] {
                let (sin, cos) = f32::to_radians(degrees).sin_cos();
                let normal = of.axis * cos + tangent * sin;
                let away = |lifted_m: f32| turned_away(facing(lift - normal * lifted_m, normal), lift, &of);
                assert_eq!(away(0.1e-3), below && shape != ProbeShape::Sphere, "{shape:?}, {degrees} degrees, in front");
                assert!(away(-0.1e-3), "{shape:?}, {degrees} degrees, from behind");
            }
        }
    }
}

#[repr(align(4))]
struct Words<Bytes: ?Sized>(Bytes);
static BLOCK: &Words<[u8]> = &Words(*include_bytes!("../../../../examples/block-m4f-168.patch"));

/// A block with every triangle as a candidate.
struct Pressed {
    file: PatchFile<'static>,
    tuned: Tuned<'static>,
    state: State<'static>,
}

impl Pressed {
    fn new(points: usize, change: impl Fn(&mut Params)) -> Self {
        let mut file = PatchFile::open(&BLOCK.0).unwrap();
        change(&mut file.params);
        let triangles = file.model.triangles.len();
        // neighbouring points differ in stiffness
        let laws: Vec<_> = (0..points * triangles).map(|n| FoundationPoint { k: 1e-3 * (1.0 + (n % 7) as f32) }).collect();
        file.model.foundation = laws.leak();
        file.model.stiffening_per_m = 150.0;
        let nodes = file.model.nodes.len();
        let tuned = file.params.build(&file.model, vec![NodeStep::ZERO; nodes].leak()).unwrap();
        let shapes = vec![TetShapes::ZERO; TetShapes::count(&file.model)].leak();
        let mut state = State::new(&file.model, vec![Node::ZERO; nodes].leak(), vec![0; triangles].leak(), shapes).unwrap();
        state.candidates.iter_mut().enumerate().for_each(|(n, index)| *index = n as u16);
        state.near = triangles;
        for (n, node) in state.nodes.iter_mut().enumerate() {
            let wave = |k: f32| (n as f32 * k).sin();
            node.v = row(Vector3::new(wave(1.1), wave(2.3), wave(0.7)) * 0.2);
            node.f = row(Vector3::new(wave(0.9), wave(1.3), wave(1.9)) * 1e-6);
            node.p = 0.5 + 0.4 * wave(3.1);
        }
        Self { file, tuned, state }
    }

    fn tip_m(&self) -> Vector3<f32> {
        self.file.site_m - self.file.params.probe.axis * 2e-3
    }

    /// Push and slope of every node and strength of every triangle, computed by a sum over all
    /// points.
    fn by_hand(&self, stiffened: bool) -> (Vec<[f64; 3]>, Vec<f64>, Vec<f64>) {
        let (model, nodes) = (&self.file.model, &*self.state.nodes);
        let mut pushes = vec![[0.0; 3]; nodes.len()];
        let (mut slopes, mut strengths) = (vec![0.0; nodes.len()], vec![0.0; model.triangles.len()]);
        let points = model.points_per_triangle();
        let probe = self.tuned.probe;
        let centre = centre_m(&probe, self.tip_m());
        let lift = self.tip_m() + probe.axis * probe.radius_m - centre;
        for (t, triangle) in model.triangles.iter().enumerate() {
            let corners = triangle.node.map(|n| vector(&nodes[usize::from(n)].x) - centre);
            if turned_away(corners, lift, &probe) {
                continue;
            }
            for (p, w) in point_weights(points).iter().enumerate() {
                let place = corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
                let Some((pen, out)) = penetration(&probe, self.state.shaft, place) else { continue };
                let stiffer: f64 = triangle.node.iter().zip(w).map(|(n, w)| f64::from(nodes[usize::from(*n)].p * w)).sum();
                let k = f64::from(model.foundation[t * points + p].k) * if stiffened { 0.5 + stiffer } else { 1.0 };
                let stiffens = f64::from(model.stiffening_per_m * pen);
                let f = k * f64::from(pen) * (1.0 + stiffens);
                strengths[t] += f;
                for (n, w) in triangle.node.iter().zip(w) {
                    let n = usize::from(*n);
                    slopes[n] += f64::from(*w) * k * (1.0 + 2.0 * stiffens);
                    (0..3).for_each(|axis| pushes[n][axis] += f64::from(*w) * f * f64::from(out[axis]));
                }
            }
        }
        (pushes, slopes, strengths)
    }
}

fn close(found: f32, right: f64, scale: f64, what: &str) {
    assert!((f64::from(found) - right).abs() < 1e-4 * scale, "{what}: {found} for {right}");
}

#[test]
fn every_point_inside_the_probe_pushes_the_nodes_of_its_triangle() {
    for (points, stiffened, shape) in [
        (4, false, ProbeShape::Hemisphere),
        (9, false, ProbeShape::Flat),
        (4, true, ProbeShape::Sphere),
        (9, true, ProbeShape::Hemisphere),
    ] {
        let mut pressed = Pressed::new(points, |params| params.probe.shape = shape);
        pressed.state.shaft = true;
        let tip_m = pressed.tip_m();
        let (pushes, slopes, strengths) = pressed.by_hand(stiffened);
        let strongest = |over: Option<usize>| {
            let of = |t: usize| strengths[t] * if over == Some(t) { 1.25 } else { 1.0 };
            (0..strengths.len()).map(|t| (of(t), t)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
        };
        let (most, first) = strongest(None);
        // the second strongest, which replaces the strongest only if it was the strongest in the
        // last tick
        let near = (0..strengths.len()).filter(|t| *t != first).max_by(|a, b| strengths[*a].total_cmp(&strengths[*b])).unwrap();
        for over in [None, Some(near), Some(first)] {
            pressed.state.over = over.map(|t| t as u16);
            pressed.state.nodes.iter_mut().for_each(|node| (node.pass, node.slope) = ([0.0; ROW], 0.0));
            let load = match stiffened {
                true => push::<true>(&pressed.file.model, &pressed.tuned, &mut pressed.state, tip_m),
                false => push::<false>(&pressed.file.model, &pressed.tuned, &mut pressed.state, tip_m),
            };
            let (strength, triangle) = strongest(over);
            assert_eq!(usize::from(load.strongest.1), triangle, "{points} {over:?}");
            close(load.strongest.0, strength, most, "strongest");
            let steepest = slopes.iter().copied().fold(0.0, f64::max);
            for (n, node) in pressed.state.nodes.iter().enumerate() {
                (0..3).for_each(|axis| close(node.pass[axis], pushes[n][axis], most, "push"));
                close(node.slope, slopes[n], steepest, "slope");
            }
            assert!(slopes.iter().filter(|slope| **slope > 0.0).count() > 3 && slopes.contains(&0.0));
        }
    }
}

#[test]
fn a_load_is_the_sum_of_the_pushes_at_the_end_of_the_substep() {
    let speed_m_per_s = Vector3::new(0.1, -0.05, -0.15);
    for fields in [false, true] {
        let mut pressed = Pressed::new(9, |_| ());
        pressed.tuned.fields = fields;
        let (tip_m, tuned) = (pressed.tip_m(), &pressed.tuned);
        let (pushes, slopes, _) = pressed.by_hand(false);
        let before: Vec<Node> = pressed.state.nodes.to_vec();
        let mut right = [[0.0_f64; 3]; 3];
        let mut right_push = 0.0;
        let mut on_nodes = vec![[0.0_f64; 3]; before.len()];
        let mut free = vec![1.0_f64; before.len()];
        for (n, node) in before.iter().enumerate().filter(|(n, _)| slopes[*n] > 0.0) {
            let length = pushes[n].iter().map(|x| x * x).sum::<f64>().sqrt();
            let normal = pushes[n].map(|x| x / length);
            let dot = |v: Vector3<f32>| (0..3).map(|k| f64::from(v[k]) * normal[k]).sum::<f64>();
            let dt = f64::from(tuned.substep_s);
            let yields = 1.5 * dt * f64::from(tuned.node_step[n].step);
            let moves = dt * f64::from(tuned.keep) * dot(vector(&node.v))
                - f64::from(tuned.contact_damping_s) * dot(speed_m_per_s)
                + yields * dot(vector(&node.f));
            free[n] = 1.0 / (1.0 + slopes[n] * yields);
            let f = ((length - slopes[n] * moves) * free[n]).max(0.0);
            right_push += f;
            on_nodes[n] = normal.map(|x| x * f);
            let (at_m, rest_m) = (node.position_m(), pressed.file.model.nodes[n].rest_m);
            (0..3).for_each(|k| right[0][k] += normal[k] * f);
            (0..3).for_each(|k| right[1][k] += f64::from(at_m[k]) * f);
            (0..3).for_each(|k| right[2][k] += f64::from(rest_m[k]) * f);
        }
        let load = press(&pressed.file.model, &pressed.tuned, &mut pressed.state, tip_m, speed_m_per_s);
        assert!(right_push > 0.0);
        close(load.push, right_push, right_push, "length");
        let [right_force, right_point, right_rest] = right;
        (0..3).for_each(|k| close(load.force[k], right_force[k], right_push, "force"));
        (0..3).for_each(|k| close(load.point[k], right_point[k], 0.1 * right_push, "point"));
        (0..3).for_each(|k| close(load.rest[k], right_rest[k], 0.1 * right_push, "rest"));
        for (n, (node, before)) in pressed.state.nodes.iter().zip(&before).enumerate() {
            assert_eq!((node.pass, node.slope), ([0.0; ROW], 0.0), "{n}: ready for the next substep");
            (0..3).for_each(|k| close(node.f[k] - before.f[k], on_nodes[n][k], right_push, "on the node"));
            close(node.free, if fields { free[n] } else { 1.0 }, 1.0, "free");
        }
    }
}

/// A push of 2e-6 m^2 on a node that moves under other forces.
fn node() -> Node {
    let v = row(Vector3::new(0.3, -0.2, 0.1));
    let f = row(Vector3::new(-0.4e-6, 0.9e-6, 0.3e-6));
    Node { v, f, pass: row(Vector3::new(1.2e-6, 0.0, 1.6e-6)), slope: 2e-3, ..Node::ZERO }
}

const FADING: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.3, time_s: 0.01 }, PronyTerm { share: 0.2, time_s: 0.1 }, PronyTerm::NONE];

#[test]
fn a_push_solves_for_its_own_value_at_the_end_of_the_substep() {
    let normal = Vector3::new(0.6, 0.0, 0.8);
    let probe_m_per_s = Vector3::new(-0.1, 0.4, -0.2);
    let step = 2.4e5;
    for relaxation in [[PronyTerm::NONE; MOST_TERMS], FADING] {
        let pressed = Pressed::new(9, |params| params.relaxation = relaxation);
        let tuned = &pressed.tuned;
        let faded = match tuned.relaxes() {
            true => Faded([row(normal * 0.3e-6 + Vector3::y() * 1e-6), row(normal * 0.1e-6), [0.0; ROW]]),
            false => Faded::ZERO,
        };
        for pulled in [1.0, -3.0, 9.0] {
            let node = Node { v: node().v.map(|v| pulled * v), ..node() };
            let (f, length, free) = match tuned.relaxes() {
                true => implicit_relaxing(&node, &faded, step, tuned, probe_m_per_s),
                false => implicit(&node, step, tuned, probe_m_per_s),
            };
            let n = normal.cast::<f64>();
            let along = |v: Vector3<f32>| v.cast::<f64>().dot(&n);
            let dt = f64::from(tuned.substep_s);
            let (slope, yields) = (f64::from(node.slope), 1.5 * dt * f64::from(step));
            let (at_once, gone) = (f64::from(tuned.prony.at_once), along(faded.sum()));
            // q = C p - s, p = p0 - K moves, moves = by velocities + b (C F + s + q)
            let by_velocities =
                dt * f64::from(tuned.keep) * along(vector(&node.v)) - f64::from(tuned.contact_damping_s) * along(probe_m_per_s);
            let moves = |q: f64| by_velocities + yields * (at_once * along(vector(&node.f)) + gone + q);
            let residual = |q: f64| at_once * (2e-6 - slope * moves(q)) - gone - q;
            let (low, high) = (residual(0.0), residual(1e-6));
            let right = (low * 1e-6 / (low - high)).max(0.0);
            close(length, right, 2e-6, "length");
            assert!((f - normal * length).norm() < 1e-5 * 2e-6, "{f:?}");
            close(free, 1.0 / (1.0 + at_once * slope * yields), 1.0, "free");
        }
        let still = Node { pass: [0.0; ROW], ..node() };
        let none = (ZERO, 0.0, 1.0);
        assert_eq!(implicit(&still, step, tuned, probe_m_per_s), none);
        assert_eq!(implicit_relaxing(&still, &faded, step, tuned, probe_m_per_s), none);
    }
}

#[test]
fn a_probe_touches_from_the_first_point_inside_it_on() {
    for points in [4, 9] {
        let mut pressed = Pressed::new(points, |_| ());
        let model = pressed.file.model;
        let axis = pressed.file.params.probe.axis;
        let touched = |state: &State, tuned: &Tuned, tip_m: Vector3<f32>| {
            let centre = centre_m(&tuned.probe, tip_m);
            let of = |triangle: &crate::Triangle| {
                let corners = triangle.node.map(|n| vector(&state.nodes[usize::from(n)].x) - centre);
                let places = point_weights(points).iter().map(|w| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]);
                places.map(|place| place.norm()).fold(f32::MAX, f32::min)
            };
            model.triangles.iter().map(of).fold(f32::MAX, f32::min) < tuned.probe.radius_m
        };
        let mut both = [0; 2];
        for n in 0..40 {
            let tip_m = pressed.file.site_m + axis * (1e-3 - 0.1e-3 * n as f32);
            let right = touched(&pressed.state, &pressed.tuned, tip_m);
            assert_eq!(touches(&model, &pressed.tuned, &pressed.state, tip_m), right, "{points} {n}");
            both[usize::from(right)] += 1;
        }
        assert!(both[0] > 3 && both[1] > 3, "{both:?}");
        pressed.state.near = 0;
        assert!(!touches(&model, &pressed.tuned, &pressed.state, pressed.tip_m()), "no candidates");
    }
}

#[test]
fn no_more_triangles_are_pressed_than_allowed_and_that_is_told() {
    for points in [4, 9, 16] {
        let push = |most| {
            let mut pressed = Pressed::new(points, |_| {});
            pressed.tuned.most_pressed = most;
            let tip_m = pressed.tip_m();
            let load = push::<false>(&pressed.file.model, &pressed.tuned, &mut pressed.state, tip_m);
            let slopes: f32 = pressed.state.nodes.iter().map(|node| node.slope).sum();
            (load.limited, slopes)
        };
        let all = Pressed::new(points, |_| {}).by_hand(false).2.iter().filter(|strength| **strength > 0.0).count();
        assert!(all > 3, "{all}");
        assert_eq!([all, all + 1, usize::MAX].map(push), [push(all); 3]);
        let pushed: Vec<_> = (0..=all).map(push).collect();
        assert!(pushed.windows(2).all(|two| two[0].0 && two[0].1 < two[1].1), "each triangle adds to the slopes: {pushed:?}");
        assert_eq!((pushed[0], pushed[all].0), ((true, 0.0), false));
    }
}

#[test]
fn loads_of_substeps_are_added_and_the_strongest_push_is_kept() {
    let load = |times: f32, strongest| Load {
        force: Vector3::new(1.0, 2.0, 3.0) * times,
        push: 4.0 * times,
        point: Vector3::new(5.0, 6.0, 7.0) * times,
        rest: Vector3::new(8.0, 9.0, 10.0) * times,
        strongest,
        covered: false,
        limited: false,
    };
    for (other, kept) in [((2.0, 8), (2.0, 8)), ((0.5, 8), (1.0, 7)), ((1.0, 8), (1.0, 7))] {
        let mut sum = load(1.0, (1.0, 7));
        sum.add(&load(2.0, other));
        let right = load(3.0, kept);
        assert_eq!((sum.force, sum.push, sum.point, sum.rest), (right.force, right.push, right.point, right.rest));
        assert_eq!(sum.strongest, kept);
    }
    for (own, other) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut sum = Load { covered: own, ..Load::NONE };
        sum.add(&Load { covered: other, ..Load::NONE });
        assert_eq!(sum.covered, own || other);
    }
}

#[test]
fn a_tip_is_covered_where_the_surface_is_within_a_radius_above_its_centre() {
    let mut pressed = Pressed::new(4, |params| params.probe.shape = ProbeShape::Sphere);
    let (model, probe, site_m) = (pressed.file.model, pressed.tuned.probe, pressed.file.site_m);
    let aside = probe.axis.cross(&Vector3::new(0.3, 0.5, 0.2)).normalize();
    let below = |state: &State, radii: f32, aside_m: f32| {
        let centre = site_m + aside * aside_m - probe.axis * (radii * probe.radius_m);
        covered(&model, state, centre, &probe)
    };
    for (radii, is_covered) in [(0.1, true), (0.9, true), (1.1, false), (-0.1, false), (-0.9, false)] {
        for aside_m in [0.2e-3, -0.7e-3, 1.3e-3] {
            assert_eq!(below(&pressed.state, radii, aside_m), is_covered, "{radii} radii below");
        }
    }
    assert!(!below(&pressed.state, 0.5, 1.0), "beside the patch");
    pressed.state.near = 0;
    assert!(!below(&pressed.state, 0.5, 0.2e-3), "no candidates");
}
