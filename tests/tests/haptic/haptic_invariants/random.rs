//! Random events at any time: poses, glitches, faulty models, requests, silence, late boards.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::SensorStatus;
use palpate::haptic::limits::LoopLimitSettings;
use palpate::{Fault, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::haptic_invariants::rig::{NORMAL, Rig};

/// An event.
#[derive(Clone, Debug)]
enum Leg {
    Go { depth_m: f32, m_per_s: f32 },
    Hold { ticks: u32 },
    Ask(Ask),
    Silence { ticks: u32 },
    OldReadings { ticks: u32 },
    Jump { to_m: [f32; 3], back: bool },
    SensorFails,
    SickModel { force_n: [f32; 3], ticks: u32 },
    Found(Fault),
    Sequence(u32),
    Lower { share: f32 },
    Recover,
}

fn leg() -> impl Strategy<Value = Leg> {
    let ask = prop::sample::select(vec![Ask::Booted, Ask::TestPassed, Ask::Arm, Ask::Stop, Ask::Clear]);
    let found = prop::sample::select(vec![Fault::DeadlineMissed, Fault::SupplyLow, Fault::SelfTestFailed]);
    prop_oneof![
        8 => (-6e-3_f32..14e-3, 0.005_f32..1.9).prop_map(|(depth_m, m_per_s)| Leg::Go { depth_m, m_per_s }),
        4 => (1_u32..300).prop_map(|ticks| Leg::Hold { ticks }),
        2 => ask.prop_map(Leg::Ask),
        1 => (1_u32..200).prop_map(|ticks| Leg::Silence { ticks }),
        1 => (1_u32..5).prop_map(|ticks| Leg::OldReadings { ticks }),
        1 => ([any::<f32>(), any::<f32>(), any::<f32>()], any::<bool>()).prop_map(|(to_m, back)| Leg::Jump { to_m, back }),
        2 => ([-0.05_f32..0.05, -0.05..0.05, -0.05..0.05], any::<bool>()).prop_map(|(to_m, back)| Leg::Jump { to_m, back }),
        1 => Just(Leg::SensorFails),
        1 => ([any::<f32>(), any::<f32>(), any::<f32>()], 1_u32..12).prop_map(|(force_n, ticks)| Leg::SickModel { force_n, ticks }),
        1 => ([-30_f32..30.0, -30.0..30.0, -30.0..30.0], 1_u32..12).prop_map(|(force_n, ticks)| Leg::SickModel { force_n, ticks }),
        1 => found.prop_map(Leg::Found),
        1 => any::<u32>().prop_map(Leg::Sequence),
        1 => (0.3_f32..1.0).prop_map(|share| Leg::Lower { share }),
        4 => Just(Leg::Recover),
    ]
}

fn follow(rig: &mut Rig, leg: &Leg) {
    match *leg {
        Leg::Go { depth_m, m_per_s } => {
            rig.go(depth_m, m_per_s);
        }
        Leg::Hold { ticks } => {
            rig.hold(ticks);
        }
        Leg::Ask(asked) => {
            rig.ask(asked);
        }
        Leg::Silence { ticks } => {
            for _ in 0..ticks {
                rig.tick(Command::default(), true);
            }
        }
        Leg::OldReadings { ticks } => {
            for _ in 0..ticks {
                rig.tick(Command::HEARD, false);
            }
        }
        Leg::Jump { to_m, back } => {
            let from_m = rig.device.reading.position_m;
            rig.device.reading.position_m = to_m.into();
            rig.tick(Command::HEARD, true);
            rig.device.reading.position_m = if back { from_m } else { NORMAL * 5e-3 };
            rig.hold(3);
        }
        Leg::SensorFails => {
            rig.device.reading.status = SensorStatus::Failed;
            rig.hold(1);
            rig.device.reading.status = SensorStatus::Good;
        }
        Leg::SickModel { force_n, ticks } => {
            for _ in 0..ticks {
                rig.tissue.sick_n = Some(Vector3::from(force_n));
                rig.hold(1);
            }
            rig.tissue.sick_n = None;
        }
        Leg::Found(fault) => {
            rig.tick(Command { found: Some(fault), ..Command::HEARD }, true);
        }
        Leg::Sequence(sequence) => rig.device.reading.sequence = sequence,
        Leg::Lower { share } => {
            let now = *rig.cycle.limits();
            let max_force_n = now.max_force_n * share;
            rig.cycle.lower_limits(&LoopLimitSettings { max_force_n, ..now }).unwrap();
        }
        Leg::Recover => {
            rig.move_to(NORMAL * 5e-3);
            rig.hold(120);
            for asked in [Ask::Clear, Ask::TestPassed, Ask::Arm] {
                rig.ask(asked);
            }
            rig.hold(650);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(7), cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn nothing_breaks_an_invariant(legs in prop::collection::vec(leg(), 1..25), armed in prop::bool::weighted(0.8)) {
        let mut rig = if armed { Rig::active() } else { Rig::at(3e-3) };
        for leg in &legs {
            follow(&mut rig, leg);
            prop_assert!(rig.broken.is_empty(), "{:?} in {leg:?}: {:?}", rig.broken, rig.last);
        }
    }
}
