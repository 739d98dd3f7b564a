//! The force on a probe that continues in its direction does not include the power of the floored
//! masses; on any other probe the force is unchanged. Friction stays within its cone.

use palpate::method::{Method, Product};
use palpate::stages::force::foundation::Load;
use palpate::{Model, ProbePose, State, Tuned, Vector3, tick_with};
use palpate_tests::bench::{Bench, at_depth};

/// The product's method, which also keeps the contact force of its last tick.
struct Watched(Vector3<f32>);

impl Method for Watched {
    fn begin(&mut self, _: &Tuned, _: &State) {
        self.0 = Vector3::zeros();
    }

    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, m_per_s: Vector3<f32>) -> Load {
        let load = Product.force(model, tuned, state, tip_m, m_per_s);
        self.0 -= load.force * tuned.youngs_modulus_pa();
        load
    }
}

/// Force, force without the correction, and friction limit after every tick of a motion through
/// these tip positions [N].
fn felt(bench: &Bench, tips_m: impl IntoIterator<Item = Vector3<f32>>) -> Vec<(Vector3<f32>, Vector3<f32>, f32)> {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let mut watched = Watched(Vector3::zeros());
    let ticks = tips_m.into_iter().map(|tip_m| {
        let output = tick_with(&model, &tuned, &mut state, ProbePose { tip_m }, &mut watched);
        assert_eq!(output.fault, None);
        (output.force_n, watched.0, output.grip_n)
    });
    ticks.collect()
}

fn stiff(nodes: usize) -> Bench {
    Bench::calibrated(nodes).with(|p| p.youngs_modulus_pa = 100e3)
}

/// Depths of a ramp at 200 mm/s from 1 mm above the surface to 3 mm [m].
fn ramp_m() -> impl Iterator<Item = f32> {
    (-5..=15_i8).map(|n| 2e-4 * f32::from(n))
}

/// A third of the force at 1 mm depth was due to the floored masses.
#[test]
fn a_ramp_is_without_it() {
    for nodes in [130, 410] {
        let (force_n, push_n, _) = felt(&stiff(nodes), ramp_m().take(11).map(at_depth))[10];
        println!("{nodes} nodes: {} of {} N", force_n.z, push_n.z);
        assert!(force_n.z > 0.6 * push_n.z && force_n.z < 0.8 * push_n.z, "{nodes} nodes: {force_n:?} of {push_n:?}");
    }
}

/// The power of the floored masses is subtracted only while the probe continues in its direction.
/// After a reversal it would have the wrong sign, and one count of 10 um at rest would be rendered
/// with up to five times its force.
#[test]
fn a_probe_that_stops_turns_round_or_trembles_gains_nothing() {
    for nodes in [130, 410] {
        let back = ramp_m().chain((1..10_u8).map(|n| 3e-3 - 2e-4 * f32::from(n)));
        let turns = felt(&stiff(nodes), back.map(at_depth));
        let (force_n, push_n, _) = turns[21];
        assert_eq!(force_n.z.to_bits(), push_n.z.to_bits(), "turned round: {force_n:?} of {push_n:?}");
        assert_ne!(turns[23].0.z.to_bits(), turns[23].1.z.to_bits(), "the way out has its gain");

        let trembles = ramp_m().chain((0..400_u16).map(|n| 3e-3 + if n / 2 % 2 == 0 { 0.0 } else { 1e-5 }));
        for (force_n, push_n, _) in felt(&stiff(nodes), trembles.map(at_depth)).into_iter().skip(22) {
            assert!((force_n - push_n).norm() <= 1e-6 * push_n.norm(), "{force_n:?} of {push_n:?}");
        }
    }
}

#[test]
fn friction_stays_within_its_cone() {
    let bench = stiff(130).with(|p| p.friction = 0.5);
    let slide = (0..40_u8).map(|n| at_depth(3e-3 - 5e-5 * f32::from(n)) + Vector3::x() * (6e-5 * f32::from(n)));
    let mut gripped = 0;
    for (force_n, _, grip_n) in felt(&bench, ramp_m().map(at_depth).chain(slide)) {
        // under a round tip the contact forces diverge, so the cone is wider than mu times their
        // sum
        let (push_n, along_n) = (force_n.z, force_n.xy().norm());
        assert!(along_n <= 1.1 * grip_n + 1e-6 && grip_n <= 0.6 * push_n.max(0.0) + 0.02, "{force_n:?}, grip {grip_n}");
        gripped += usize::from(grip_n > 0.1);
    }
    assert!(gripped > 20, "{gripped} ticks with friction");
}
