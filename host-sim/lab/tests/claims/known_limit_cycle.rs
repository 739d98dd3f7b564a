//! The limit cycle that encoder counts cause on a contact five times stiffer than the device can
//! render: the watch of the port notices it without ceiling and energy account, whether the hand
//! rests or kneads, and not with them.

use palpate::haptic::account::AccountSettings;
use palpate::{Params, Probe, ProbeShape};
use palpate_lab::faults::paths::{PathGround, PathPatch};
use palpate_lab::faults::yielding::{Motion, MotionKind, RunLength, YieldingCase};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_tissue::finger::Impedance;

const LENGTH: RunLength = RunLength { motion_s: 4.0, again_s: 0.0 };
const DEEP_M: f64 = 4e-3;

fn block(ground: &PathGround) -> PathGround {
    let on: &PathPatch = ground.patches.iter().find(|p| p.label().starts_with("block-m4f-168")).unwrap();
    let probe = Probe { shape: ProbeShape::Flat, radius_m: 8e-3, ..on.params.probe };
    PathGround { patches: vec![on.with_probe(probe, Params::UPRIGHT).unwrap()], devices: Vec::new() }
}

#[test]
fn a_limit_cycle_is_noticed_under_a_hand_that_rests_or_moves_and_the_loop_prevents_it() {
    let ground = block(&PathGround::load().unwrap());
    let touch = DeviceProfile::load("touch").unwrap();
    for kind in [MotionKind::Hold, MotionKind::Knead] {
        let case = YieldingCase {
            shipped: None,
            // so that the contact is not made softer
            uncapped: true,
            missing_ticks: 0,
            stop_ticks: 0,
            patch: 0,
            params: Params { youngs_modulus_pa: 100e3, ..ground.patches[0].params },
            device: DeviceProfile {
                count_m: 55e-6,
                delay_ticks: 0,
                amplifier_lag_s: 0.0,
                mass_kg: 0.045,
                force_limit_n: 3.0,
                friction_n: 0.0,
                damping_n_s_per_m: 0.1,
                ..touch.clone()
            },
            hand: Impedance { mass_kg: 0.021, damping_n_s_per_m: 3.5, stiffness_n_per_m: 287.0 },
            motion: Motion {
                kind,
                reach_m: DEEP_M,
                depth_m: DEEP_M,
                press_s: 0.18,
                share: 0.5,
                hz: 1.0,
                tremor_m: 0.024e-3,
                tremor_hz: 5.7,
                aside_m_per_s: 0.0,
                place_m: [0.0; 2],
                phase: 0.0,
                shake_m_per_s2: 0.0,
                shake_hz: 1.0,
            },
        };
        let raw = case.run(&ground, LENGTH, |s| s.account = AccountSettings::HIGHEST).unwrap();
        assert!(raw.broken.iter().any(|b| b.id == "I15"), "{kind:?}: {raw:?}");
        let case = YieldingCase { uncapped: false, ..case };
        let paid = case.run(&ground, LENGTH, |_| ()).unwrap();
        assert!(paid.broken.is_empty(), "{kind:?}: {paid:?}");
    }
}
