//! The fault campaign bites: forty mistakes, planted in the loop one at a time, are each noticed; the soak is watched as well.
//!
//! Runs with `cargo test --release --package palpate-tests --features planted-defects --test planted_defects` alone: a build with the mistakes in it
//! is no other test's business.

use palpate::Defect;
use palpate_sim::closed_loop::campaign::{Ground, LightPatch, campaign};
use palpate_sim::closed_loop::device::DeviceProfile;
use palpate_sim::closed_loop::soak::soak;

/// Runs against one defect, in rounds: most are noticed in the first.
const ROUND: u64 = 160;
const ROUNDS: u64 = 12;

#[test]
fn every_planted_defect_is_noticed_and_without_one_nothing_is() {
    let device = DeviceProfile::load("touch").unwrap();
    let light = LightPatch::load().unwrap();
    let ground = Ground::new(&device, &light);
    let run = |round| campaign(&ground, ROUND, 100 + round, |_| ()).unwrap();
    let noticed = || (0..ROUNDS).find_map(|round| run(round).examples().first().map(|e| (round, (*e).to_owned())));
    assert_eq!(noticed(), None, "a healthy loop");
    let mut missed = Vec::new();
    for defect in Defect::ALL {
        defect.plant();
        match noticed() {
            Some((round, how)) => println!("{defect:?}: round {round}, {how}"),
            None => missed.push(defect),
        }
    }
    Defect::heal();
    assert!(Defect::ALL.len() >= 30 && missed.is_empty(), "not noticed: {missed:?}");

    // one process, one switch: after the campaign, not beside it
    let use_for_20_s = || soak(&ground, 20.0, |_| ()).unwrap().broken;
    assert!(use_for_20_s().is_empty());
    Defect::ForceInFreeSpace.plant();
    assert!(!use_for_20_s().is_empty(), "the soak does not look");
    Defect::heal();
}
