//! Every kind of fault, with every hand, at any moment of a contact: no invariant is broken, and
//! the required reaction follows in time.
//!
//! The long form, 100 000 runs: `palpate faults`.

use palpate::haptic::cycle::Renderer;
use palpate::stages::probe::ProbePose;
use palpate_lab::faults::campaign::{Case, Ground, LightPatch, MOTIONS, Table, campaign};
use palpate_lab::faults::faulty::list::FAULTS;
use palpate_lab::faults::faulty::{Expected, FaultType, FaultyTissue, Injection, Needs, TissueFault};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::HANDS;
use palpate_loop::closed_loop::surface::{Surface, with_tissue};

const RUNS: u64 = 2_000;

fn run(runs: u64, seed: u64) -> Table {
    let device = DeviceProfile::load("touch").unwrap();
    let light = LightPatch::load().unwrap();
    campaign(&Ground::new(&device, &light), 0..runs, seed, |_| ()).unwrap()
}

#[test]
fn two_thousand_faults_break_nothing_and_are_answered_in_time() {
    let table = run(RUNS, 7);
    assert_eq!(table.rows.iter().map(|r| r.runs).sum::<u64>(), RUNS);
    assert_eq!(table.bad(), 0, "{:#?}", table.examples());
    let kinds = table.kinds().filter(|(kind, row)| kind.injection != Injection::None && row.injected > 0).count();
    assert!(kinds >= 40, "{kinds} kinds of fault");
    for (kind, row) in table.kinds() {
        assert!(row.injected > 0, "{} never came", kind.id);
        if matches!(kind.expected, Expected::Fault(..)) {
            assert_eq!(row.detected, row.injected, "{}", kind.id);
        }
    }
}

/// The plausibility check leaves out what the guard adds beyond the depth limit. A force that
/// replaces the model's holds none of the guard's, and a multiple of it holds the same multiple.
#[test]
fn a_false_force_does_not_hide_behind_the_guard() {
    let light = LightPatch::load().unwrap();
    let limit_m = f64::from(light.patch.wide_model().depth_limit_m);
    let pressed = |fault| {
        with_tissue(&light.patch, &light.params, |tissue| {
            let site = tissue.site();
            let mut faulty = FaultyTissue::new(tissue);
            faulty.break_it(fault);
            let mut tick =
                |n| faulty.render(ProbePose { tip_m: site.point_m(limit_m * 1.5 * f64::from(n) / 150.0, 0.0, 0.0).cast() });
            (-20..150).for_each(|n| _ = tick(n));
            tick(150)
        })
        .unwrap()
    };
    let honest = pressed(None);
    assert!(honest.continuation_n > 1.0, "{} N beyond the depth limit", honest.continuation_n);
    assert_eq!(pressed(Some(TissueFault::Force(20.0))).continuation_n, 0.0);
    let share = |output: palpate::Output| output.continuation_n / output.force_n.norm();
    assert!((share(pressed(Some(TissueFault::Scaled(3.0)))) / share(honest) - 1.0).abs() < 1e-5);
}

#[test]
fn the_same_seed_gives_the_same_runs_and_another_seed_others() {
    let of = |seed| run(90, seed).rows.iter().map(|r| (r.injected, r.peak_n.to_bits(), r.ends())).collect::<Vec<_>>();
    let third = of(3);
    assert_eq!(third, of(3));
    assert_ne!(third, of(4));
}

#[test]
fn every_hand_and_motion_meets_every_kind() {
    let cases: Vec<Case> = (0..100_000).map(|n| Case::draw(n, 1)).collect();
    let free = |fault: &FaultType| !matches!(fault.needs, Needs::FastForce | Needs::NobodysForce);
    for (fault, kind) in FAULTS.iter().enumerate().filter(|(_, kind)| free(kind)) {
        for hand in HANDS {
            for motion in MOTIONS {
                let met = cases.iter().any(|c| c.fault == fault && c.hand == hand && c.motion == motion);
                assert!(met, "{} {} {}", kind.id, hand.id, motion.id);
            }
        }
    }
}
