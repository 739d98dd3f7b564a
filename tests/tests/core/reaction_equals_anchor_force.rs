//! At the end of a hold the force on the probe equals the sum of the forces on the anchors, in all
//! three directions.
//!
//! Oscillation decays at half the damping rate: after 0.3 s of a hold, exp(-0.3 s x 20/s) = 0.25 %
//! remain of the step at the end of the ramp. The tolerance is 1 %.

use palpate::stages::probe::ProbePose;
use palpate::{ClampFlags, Vector3, tick};
use palpate_tissue::finger::Finger;
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;
use palpate_tissue::scene::{Scene, Shape};
use palpate_tissue::session::Session;

const ALLOWED: f64 = 0.01;

/// Runs the scene and returns the force at the end of each hold [N].
fn balanced_holds(scene: &Scene) -> Vec<f64> {
    let session = Session::prepare(scene).unwrap();
    let model = session.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &session.params).unwrap();
    let mut finger = Finger::new(&scene.drive, 0.5e-3, TICK_S, 0.1).unwrap();
    let (mut holds, mut force_n) = (Vec::new(), 0.0);
    while let Some(step) = finger.next(force_n) {
        let output = tick(&model, &tuned, &mut state, ProbePose { tip_m: session.tip_m(step.depth_m) });
        assert_eq!((output.fault, output.limiters), (None, ClampFlags::default()));
        let reaction = output.force_n.cast::<f64>();
        force_n = reaction.dot(&session.params.probe.axis.cast());
        if step.hold_ends.is_some() {
            let on_anchors = model.anchors.iter().map(|&a| state.nodes()[usize::from(a)].force_over_modulus().cast::<f64>());
            let support = -on_anchors.sum::<Vector3<f64>>() * f64::from(tuned.youngs_modulus_pa());
            let off = (reaction - support).norm() / reaction.norm();
            println!("{}: {:.4} N, support {:.4} N, off by {:.3} %", scene.name, reaction.norm(), support.norm(), off * 100.0);
            assert!(off < ALLOWED, "{}: reaction {reaction:?}, support {support:?}", scene.name);
            holds.push(reaction.norm());
        }
    }
    assert!(holds.iter().all(|f| *f > 1e-3), "{holds:?}");
    holds
}

fn preset(name: &str, label: &str, change: impl FnOnce(&mut Scene)) -> Scene {
    let mut scene = Scene::load(name).unwrap();
    scene.name = label.into();
    change(&mut scene);
    scene
}

#[test]
fn reaction_equals_anchor_force_under_each_probe() {
    assert_eq!(balanced_holds(&preset("block", "hemisphere", |_| {})).len(), 3);
    balanced_holds(&preset("block", "sphere", |s| s.probe.shape = Shape::Sphere));
    balanced_holds(&preset("block", "flat", |s| s.probe.shape = Shape::Flat));
}

#[test]
fn reaction_equals_anchor_force_off_centre_and_over_a_nodule() {
    balanced_holds(&preset("block", "off centre", |s| s.probe.position_m = Some([0.021, -0.013])));
    balanced_holds(&preset("block-20kpa", "20 kPa", |_| {}));
    balanced_holds(&preset("nodule", "nodule", |_| {}));
}
