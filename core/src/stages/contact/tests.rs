//! Compares the candidates with every triangle's box, on a shipped patch, for every shape of probe.

extern crate std;

use std::vec;
use std::vec::Vec;

use super::*;
use crate::lanes::vector;
use crate::params::ProbeShape;
use crate::stages::probe::{ProbePose, admit};
use crate::state::Node;
use crate::{NodeStep, PatchFile, TetShapes};

#[repr(align(4))]
struct Words<Bytes: ?Sized>(Bytes);
static BLOCK: &Words<[u8]> = &Words(*include_bytes!("../../../examples/block-m4f-168.patch"));

/// Pseudo-random numbers from -1 to 1, the same in every run.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn vector(&mut self) -> Vector3<f32> {
        Vector3::new(self.next(), self.next(), self.next())
    }
}

/// Shapes that are not round; the tests turn them.
#[cfg(feature = "long-tips")]
fn long() -> [ProbeShape; 2] {
    let along = Vector3::zeros();
    [ProbeShape::Capsule { length_m: 7e-3, along }, ProbeShape::Ellipsoid { semi_axes_m: [6e-3, 3e-3], along }]
}

#[cfg(not(feature = "long-tips"))]
fn long() -> [ProbeShape; 0] {
    []
}

/// Turns a shape that is not round, so that it lies along a direction.
#[cfg_attr(not(feature = "long-tips"), expect(unused_variables, reason = "all are round"))]
fn turned(shape: ProbeShape, along: Vector3<f32>) -> ProbeShape {
    match shape {
        #[cfg(feature = "long-tips")]
        ProbeShape::Capsule { length_m, .. } => ProbeShape::Capsule { length_m, along },
        #[cfg(feature = "long-tips")]
        ProbeShape::Ellipsoid { semi_axes_m, .. } => ProbeShape::Ellipsoid { semi_axes_m, along },
        round => round,
    }
}

/// Points and a distance [m]: the box around the points, widened by the distance on every side, is
/// the box around a probe at all of `ends`. The points are centres of balls, both ends of a
/// capsule's segments, or corners around an ellipsoid.
fn spread(probe: &Probe, ends: Vec<Vector3<f32>>) -> (Vec<Vector3<f32>>, f32) {
    #[cfg(feature = "long-tips")]
    let both =
        |ends: Vec<Vector3<f32>>, way: Vector3<f32>| ends.iter().flat_map(|end| [end + way, end - way]).collect::<Vec<_>>();
    match probe.shape {
        #[cfg(feature = "long-tips")]
        ProbeShape::Capsule { length_m, along } => (both(ends, along * (0.5 * length_m)), probe.radius_m),
        #[cfg(feature = "long-tips")]
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => (both(both(ends, along * a), probe.axis.cross(&along) * b), 0.0),
        _ => (ends, probe.radius_m),
    }
}

/// Calls `check` for every shape and several axes, with a state whose probe has been outside, a
/// motion that the test may change, and a source of random numbers.
fn with_probes(mut check: impl FnMut(&Model, &Tuned, &mut State, Motion, &mut Numbers)) {
    let file = PatchFile::open(&BLOCK.0).unwrap();
    let model = &file.model;
    let mut numbers = Numbers(7);
    let round = [ProbeShape::Sphere, ProbeShape::Hemisphere, ProbeShape::Flat];
    for shape in round.into_iter().chain(long()) {
        for axis in [Vector3::z(), Vector3::new(0.6, 0.0, 0.8), Vector3::new(-0.48, 0.64, -0.6), -Vector3::x(), Vector3::y()] {
            let level = axis.cross(&Vector3::new(0.36, -0.48, 0.8)).normalize();
            let shape = turned(shape, level);
            let params = crate::Params { probe: Probe { shape, axis, radius_m: 4e-3 }, ..file.params };
            let mut node_step = vec![NodeStep::ZERO; model.nodes.len()];
            let tuned = params.build(model, &mut node_step).unwrap();
            let (mut nodes, mut candidates) = (vec![Node::ZERO; model.nodes.len()], vec![0; model.triangles.len()]);
            let mut shapes = vec![TetShapes::ZERO; TetShapes::count(model)];
            let mut state = State::new(model, &mut nodes, &mut candidates, &mut shapes).unwrap();
            let clear_m = file.site_m + Vector3::new(0.0, 0.0, 30e-3);
            let motion = admit(model, &tuned, &mut state, ProbePose { tip_m: clear_m }).unwrap();
            let motion = Motion { from_m: file.site_m, to_m: file.site_m, ..motion };
            state.been_outside = true;
            check(model, &tuned, &mut state, motion, &mut numbers);
        }
    }
}

fn found(state: &State) -> Vec<u16> {
    state.candidates.iter().take(state.near).copied().collect()
}

#[test]
fn candidates_are_the_triangles_whose_box_meets_that_of_the_probe() {
    let (mut met, mut missed) = (0, 0);
    with_probes(|model, tuned, state, motion, numbers| {
        for _ in 0..60 {
            let from_m = motion.from_m + numbers.vector() * 15e-3;
            let mut motion = Motion { from_m, to_m: from_m + numbers.vector() * 3e-3, ..motion };
            find(model, tuned, state, &mut motion);
            // a capsule or cylinder from the tip along the axis, at both ends of the motion
            let probe = &tuned.probe;
            let beyond_m = if probe.shape.has_handle() { model.depth_limit_m } else { 0.0 };
            let far = probe.axis * (2.0 * probe.radius_m + beyond_m);
            let ends = vec![motion.from_m, motion.to_m, motion.from_m + far, motion.to_m + far];
            let (ends, ball_m) = spread(probe, ends);
            let expected: Vec<u16> = (0..model.triangles.len())
                .filter(|n| {
                    let corners = model.triangles[*n].node.map(|c| vector(&state.nodes[usize::from(c)].x));
                    (0..3).all(|k| {
                        let low = ends.iter().map(|e| e[k]).fold(f32::INFINITY, f32::min) - ball_m;
                        let high = ends.iter().map(|e| e[k]).fold(f32::NEG_INFINITY, f32::max) + ball_m;
                        corners.iter().any(|c| c[k] >= low) && corners.iter().any(|c| c[k] <= high)
                    })
                })
                .map(|n| n as u16)
                .collect();
            met += expected.len();
            missed += model.triangles.len() - expected.len();
            let found = found(state);
            // for boxes that just touch, rounding may decide
            let differ =
                expected.iter().filter(|n| !found.contains(n)).count() + found.iter().filter(|n| !expected.contains(n)).count();
            assert!(differ == 0, "{:?}: {found:?} instead of {expected:?}", probe.shape);
        }
    });
    assert!(met > 1_000 && missed > 1_000, "{met} triangles met, {missed} not: the poses prove nothing");
}

#[test]
fn a_probe_that_starts_inside_presses_nothing_until_a_tick_after_it_was_outside() {
    with_probes(|model, tuned, state, motion, _| {
        state.been_outside = false;
        let out = tuned.probe.axis * 30e-3;
        let deep_m = motion.from_m - tuned.probe.axis * 2e-3;
        if tuned.probe.axis != Vector3::z() {
            return;
        }
        let at = |tip_m| Motion { from_m: tip_m, to_m: tip_m, limiters: ClampFlags::default(), ..motion };
        let mut inside = at(deep_m);
        find(model, tuned, state, &mut inside);
        assert!(state.near == 0 && !state.been_outside && inside.limiters.contains(ClampFlags::BURIED));
        let mut clear = at(deep_m + out);
        find(model, tuned, state, &mut clear);
        assert!(state.near == 0 && state.been_outside && !clear.limiters.contains(ClampFlags::BURIED));
        let mut again = at(deep_m);
        find(model, tuned, state, &mut again);
        assert!(state.near > 0 && state.been_outside && !again.limiters.contains(ClampFlags::BURIED));
    });
}
